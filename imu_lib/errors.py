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
