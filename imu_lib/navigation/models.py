"""The error models that the 2013 paper compares, as filter models: 15AV, 18AV, 18AVWD, 15AR and
27AR (its Table 8).

None of them is a filter of its own: each is an error model given to the one filter. They can be
made from the paper's printed tables, from any error model, or from a static record of the sensor
at hand.
"""

import numpy as np
from statsmodels.regression.linear_model import burg

from imu_lib import allan
from imu_lib.errors import InputError
from imu_lib.model import Model
from imu_lib.presets import preset
from imu_lib.processes import Autoregressive, Flicker, GaussMarkov, RandomWalk, Sum, WhiteNoise
from imu_lib.published import AR_2013
from imu_lib.record import CHANNELS
from imu_lib.wavelet import denoise

from .filter import FilterModel
from .turin import LEVELS_TABLE_7

NAMES = ("15AV", "18AV", "18AVWD", "15AR", "27AR")
AR_LEVELS = 6  # levels of decomposition before the autoregressive fit (section 5.3)
AR_SECONDS = (
    3600.0  # of simulated standstill, where autoregressive models are made from an error model
)


def autoregressive(white, phi, sigma2, rate):
    """White noise and an autoregressive process; an AR(1) with its root on or beyond 1 is the
    random walk that it stands for.

    white : WhiteNoise or None; phi : coefficients, x_k = sum phi_i x_{k-i} + w_k; sigma2 :
    variance of w
    """
    terms = () if white is None else (white,)
    if len(phi) == 1 and abs(phi[0]) >= 1.0 - 1e-9:
        return Sum((*terms, RandomWalk(K=float(np.sqrt(sigma2 * rate)))))
    return Sum(
        (
            *terms,
            Autoregressive(
                phi=tuple(float(p) for p in phi), sigma=float(np.sqrt(sigma2)), rate=float(rate)
            ),
        )
    )


def printed(order):
    """The autoregressive model of the 2013 paper's Table 2, order 1 or 3, with the white noise of
    its Table 4, at 100 Hz.

    The third-order accelerometer X has a root outside the unit circle: the filter refuses it
    (UndefinedFormError).
    """
    base = preset("3dm-gx3-25-2013")
    channels = {
        c: autoregressive(
            base[c].find("white_noise"),
            [-a for a in AR_2013[c][order][0]],
            AR_2013[c][order][1],
            100.0,
        )
        for c in CHANNELS
    }
    return Model(
        channels,
        rate=100.0,
        name=f"{9 + 6 * order}AR as printed",
        source="Quinchia et al. (2013), Tables 2 and 4",
    )


def levels_at(rate):
    """The paper's levels of decomposition, chosen at 100 Hz, for another rate: one less for each
    halving, so that the same time scales are de-noised.
    """
    shift = int(round(np.log2(rate / 100.0)))
    return {c: max(level + shift, 0) for c, level in LEVELS_TABLE_7.items()}


def without_walk(model: Model) -> Model:
    """The 15-state version of a model: its random walks left out."""
    return model.with_channels(
        {c: Sum(tuple(t for t in model[c].terms if t.name != "random_walk")) for c in CHANNELS}
    )


def fit_autoregressive(record, rate, order, white, *, levels=AR_LEVELS, threshold="approximation"):
    """Burg's model of the de-noised standstill, as the 2013 paper makes it (section 5.3), with
    white noise put back.

    record : mapping of channel to ndarray, shape (n,); white : mapping of channel to WhiteNoise
    threshold : rule of the de-noising; "approximation" is the one that gives the printed
    coefficients
    """
    channels = {}
    for c in CHANNELS:
        x = np.asarray(record[c], float)
        clean = denoise(x - x.mean(), levels, threshold=threshold)
        phi, sigma2 = burg(clean, order=order, demean=True)
        channels[c] = autoregressive(white[c], np.atleast_1d(phi), sigma2, rate)
    return Model(channels, rate=rate, name=f"{9 + 6 * order}AR")


def five(
    model: Model | None = None,
    *,
    static=None,
    rate=100.0,
    names=NAMES,
    causal=False,
    turn_on_sd=(0.0, 0.0),
    constant=False,
    rng=None,
) -> dict:
    """The paper's models as filter models, by name.

    Parameters
    ----------
    model : Model
        White noise, Gauss-Markov process and (for the 18-state ones) random walk of each channel;
        None takes the paper's own.
    static : Record, optional
        Standstill of the same sensor for the autoregressive models; without it an hour is drawn
        from `model`.
    rate : float, Hz, of the drive
    names : the models wanted
    causal : whether the de-noising of 18AVWD may use the future (False: it may, as in the paper)
    turn_on_sd, constant : as in `FilterModel`: a bias left at switch-on goes to the slowest state
    of a
        channel, which a Gauss-Markov or autoregressive process forgets, or to one that keeps it

    Raises
    ------
    InputError
        For an unknown name, or a static record at another rate.
    """
    unknown = [n for n in names if n not in NAMES]
    if unknown:
        raise InputError(f"unknown model {unknown[0]!r}; the models are {', '.join(NAMES)}")
    model = preset("3dm-gx3-25-2013") if model is None else model
    plain = _plain(model)
    made, bias = {}, {"turn_on_sd": turn_on_sd, "constant": constant}
    if "15AV" in names:
        made["15AV"] = FilterModel("15AV", without_walk(plain), **bias)
    if "18AV" in names:
        made["18AV"] = FilterModel("18AV", plain, **bias)
    if "18AVWD" in names:
        made["18AVWD"] = FilterModel("18AVWD", plain, levels=levels_at(rate), causal=causal, **bias)
    orders = {"15AR": 1, "27AR": 3}
    if any(n in orders for n in names):
        record = _standstill(model, static, rate, rng)
        white = {c: plain[c].find("white_noise") for c in CHANNELS}
        for n in names:
            if n in orders:
                made[n] = FilterModel(n, fit_autoregressive(record, rate, orders[n], white), **bias)
    return {n: made[n] for n in names}


def _standstill(model, static, rate, rng):
    """A standstill for the autoregressive models: that of `static`, or an hour drawn."""
    if static is None:
        rng = np.random.default_rng(2013) if rng is None else rng
        return model.simulate(int(AR_SECONDS * rate), rate, rng, channels=CHANNELS)
    if abs(static.rate / rate - 1.0) > 0.02:
        raise InputError(
            f"the static record is at {static.rate:g} Hz, the drive at {rate:g} Hz; the "
            "autoregressive models need one rate"
        )
    still = static.continuous()
    return {c: still[c] for c in CHANNELS}


def read_off(record, rate) -> Model:
    """White noise, Gauss-Markov process and random walk of a static record, read off its Allan
    curves as the 2013 paper does.

    N and K from their slopes, sigma = 0.664 B and the correlation time from the flat part (section
    5.5, Eq. 29). Where no flat part is found its place is taken by the lowest point of the curve;
    a walk without a slope of its own is left out.
    """
    still = record.continuous()
    channels = {}
    for c in CHANNELS:
        if c not in still:
            raise InputError(
                f"{record.name or 'the static record'} has no channel {c}; the filter needs all six"
            )
        curve = allan.deviation(still[c], still.rate)
        reading = allan.read_off(curve)
        low = int(np.argmin(np.where(curve.adev > 0.0, curve.adev, np.inf)))
        white, flat, time, walk = (
            reading["N"].value,
            reading.flat.value,
            reading.correlation_time.value,
            reading["K"].value,
        )
        white = (
            white
            if white is not None
            else float(curve.adev[curve.adev > 0.0][0] * np.sqrt(curve.tau[curve.adev > 0.0][0]))
        )
        flat, time = (
            (flat, time)
            if flat is not None and time is not None
            else (float(curve.adev[low]), float(curve.tau[low]))
        )
        terms = (WhiteNoise(N=white), GaussMarkov(sigma=flat, correlation_time=time))
        channels[c] = Sum(terms + (() if walk is None else (RandomWalk(K=walk),)))
    return Model(
        channels,
        rate=rate,
        name="read off",
        source=f"Allan curves of {record.name or 'a static record'}",
    )


def _plain(model: Model) -> Model:
    """The noise processes of a model without output stages and functions of time; flicker becomes
    the paper's Gauss-Markov process.
    """
    channels = {}
    for c in CHANNELS:
        terms = []
        for t in model[c].terms:
            if isinstance(t, Flicker):
                terms.append(GaussMarkov(sigma=0.664 * t.B, correlation_time=300.0))
            elif not t.deterministic and t.name != "quantization":
                terms.append(t)
        if not any(isinstance(t, WhiteNoise) for t in terms):
            terms.insert(0, WhiteNoise(N=1e-9))
        channels[c] = Sum(tuple(terms))
    return Model(channels, rate=model.rate, name=model.name, source=model.source)
