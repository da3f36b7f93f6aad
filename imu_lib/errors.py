"""The errors a caller may want to tell apart."""


class ImuLibError(Exception):
    """Base of every error that imu_lib raises on purpose."""


class InputError(ImuLibError):
    """A file or a call is at fault; the message is one plain sentence that names what and the
    remedy.

    The command line prints the sentence on standard error and exits with status 2.
    """


class UndefinedFormError(ImuLibError):
    """A closed form that does not exist was asked for.

    Examples: the autocovariance of a random walk, the power spectral density of a ramp,
    a finite state space of flicker noise.
    """


def once(pairs, where) -> dict:
    """The names and values of a JSON object (`object_pairs_hook`); InputError where a name stands
    in it twice, of which the usual reading keeps the last without a word.
    """
    names = [name for name, _ in pairs]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise InputError(
            f'{where}: "{twice}" stands twice in one place; write it once, with all that belongs '
            "to it."
        )
    return dict(pairs)
