"""Is a stated unit possible? Gravity tells for accelerometers, noise and Earth for gyros, turning
for both.

A number that cannot be what it is said to be is refused, with the unit it more likely has; nothing
is converted on suspicion.
"""

from __future__ import annotations

import numpy as np

from imu_lib import units
from imu_lib.readers import names
from imu_lib.readers.gravity import Told, gravity, some
from imu_lib.readers.turning import MOST, turning

GYRO_FAST = 17.0  # rad/s, 1000 deg/s, for one per cent of the time: not in a vehicle
EARTH = 7.292e-5  # rad/s
AT_EARTHS = 0.02  # of it, by which a mean rate may miss it
PARTS = 20  # of a record whose means are compared
#: Noise density of gyros on the market, rad/s/sqrt(Hz): median and spread of its logarithm, from
#: fibre-optic (3e-6) to the poorest consumer parts (3e-3), data sheets of some forty sensors.
GYRO_NOISE = (1e-4, np.log(6.0))
NOISY = 2.5e-3  # rad/s/sqrt(Hz), 8.6 deg/sqrt(h): hardly any gyro at rest has more
#: Noise of the accelerometer over that of the gyro beside it, m/s^2 per rad/s: 5 to 30 in MEMS
#: units.
RATIO = (12.0, np.log(3.0))
GYRO_BIAS = (0.1, 0.7)  # rad/s where a bias begins to be unusual, spread of its logarithm above it
MOST_OF_BIAS = 5.0  # log-odds that a bias may count against a unit
OPTICAL = (
    5e-6  # rad/s/sqrt(Hz), 0.017 deg/sqrt(h): below, only fibre-optic and ring-laser gyros are
)
REFUSED = 7.0  # log-odds for another unit from which a stated one is refused
DOUBTED = 2.5  # and from which a word is said
#: Units in which nobody writes whole numbers of a gyro in small motion; of mrad/s and mdps they
#: are usual.
COARSE = ("rad/s", "deg/s", "deg/h")
#: Units that a record may be in whatever its header says.
READINGS = ("rad/s", "deg/s", "deg/h", "mdps")


def gyro_unit(
    gyro: np.ndarray,
    accel: np.ndarray | None,
    rate: float,
    unit: str,
    factor: float | None = None,
    *,
    strict: bool,
) -> Told | None:
    """What is wrong with `gyro` (n, k) rad/s, stated in `unit` of `factor` rad/s; None where
    nothing.

    Where the record turns, gravity turns with it and tells the scale. At rest the noise, the bias
    and the accelerometer's noise are weighed for the stated unit against the others: one that
    loses by far is refused, so two units are never both refused. `strict` also holds the noise
    against that of the accelerometer.
    """
    factor = names.GYRO_UNITS.get(unit) if factor is None or unit in names.GYRO_UNITS else None
    turned = turning(gyro, accel, rate)
    if turned is not None and turned[1]:
        return _by_turning(turned[0], unit, factor)
    still, bias, quiet = _still(gyro, rate)
    if counts := _counts(gyro, unit, factor, still, bias):
        return counts
    noise = None
    if strict and quiet and accel is not None and gravity(accel) is not None:
        noise = _noise_density(some(accel), rate)
    fast = float(np.quantile(np.abs(some(gyro)).max(axis=1), 0.99)) if len(gyro) > 200 else 0.0
    if factor and fast > GYRO_FAST:
        return _too_fast(fast, unit, factor, still, bias, noise, rate)
    if factor is None:
        if _score(still, bias, noise, rate) < -2 * REFUSED:
            return Told(
                f"the rates stated in {unit} have a {_worst(still, bias)}, more than any gyro at "
                "rest; check the counts per deg/s",
                True,
                None,
            )
        return None
    scores = {
        u: _score(*(x * names.GYRO_UNITS[u] / factor for x in (still, bias)), noise, rate)
        for u in READINGS
    }
    fit = _fitting(scores)
    odds = scores[fit[0]] - _score(still, bias, noise, rate)
    if fit[0] != unit and odds >= DOUBTED:
        return _unlikely(gyro, unit, factor, fit, odds, still, bias, noise)
    if strict and quiet and (other := _earths(gyro, unit, factor)):
        return Told(
            f"the mean of the rates stated in {unit} would be the Earth's rate if they were in "
            f"{other}: chance in a hundred or so, unless that is their unit (--gyro-unit {other})",
            False,
            other,
        )
    if strict and quiet and noise is None and unit != "rad/s" and 0 < still < OPTICAL:
        return Told(
            f"the rates stated in {unit} have a {_worst(still, bias)}, that of an optical gyro; "
            "of a MEMS gyro the unit would likely be rad/s",
            False,
            "rad/s",
        )
    return None


def _counts(gyro: np.ndarray, unit: str, factor, still: float, bias: float) -> Told | None:
    """Refused where the rates of a large noise or bias are whole numbers: raw counts."""
    whole = factor is not None and unit in COARSE and _whole(gyro / factor)
    if not whole or not (still > NOISY or bias > 3 * GYRO_BIAS[0]):
        return None
    return Told(
        f"the rates stated in {unit} have a {_worst(still, bias)} and are whole numbers; they "
        "are likely raw counts (--gyro-unit counts:C, C counts per deg/s)",
        True,
        None,
    )


def _earths(gyro: np.ndarray, unit: str, factor: float) -> str | None:
    """The other unit in which the mean of three gyros at rest has the length of the Earth's rate,
    to what their noise leaves of it; None where there is none.
    """
    x = some(gyro)
    if gyro.shape[1] != 3 or len(x) < 50 * PARTS:
        return None
    parts = np.array([p.mean(axis=0) for p in np.array_split(x, PARTS)])
    error = float(np.linalg.norm(parts.std(axis=0, ddof=1))) / np.sqrt(PARTS)
    mean = float(np.linalg.norm(x.mean(axis=0)))
    for other in READINGS:
        size = names.GYRO_UNITS[other] / factor / EARTH
        if other != unit and abs(mean * size - 1.0) < AT_EARTHS and error * size < AT_EARTHS:
            return other
    return None


def _fitting(scores: dict[str, float]) -> list[str]:
    """The units that fit about as well as the best one, that one first: which of them it is cannot
    be told from the values.
    """
    best = max(scores.values())
    fit = [u for u in scores if scores[u] > best - DOUBTED]
    return sorted(fit, key=lambda u: -scores[u])


def _by_turning(slope: float, unit: str, factor: float | None) -> Told | None:
    """What gravity says that turns `slope` times as fast as the rates."""
    for other in READINGS if factor else ():
        if other != unit and 0.5 < slope / (names.GYRO_UNITS[other] / factor) < 2.0:
            return Told(
                f"gravity turns {slope:.3g} times as fast as the rates stated in {unit} say; "
                f"their unit is likely {other}",
                True,
                other,
            )
    if 0.2 < slope < 5:
        return None
    return Told(
        f"gravity turns {slope:.3g} times as fast as the rates stated in {unit} say; check the "
        "unit and scale",
        True,
        None,
    )


def _too_fast(fast, unit, factor, still, bias, noise, rate) -> Told:
    """Rates that no vehicle has, and the smaller unit in which they would be usual."""
    scores = {
        u: _score(*(x * names.GYRO_UNITS[u] / factor for x in (still, bias)), noise, rate)
        for u in READINGS
        if names.GYRO_UNITS[u] < factor and fast * names.GYRO_UNITS[u] / factor < GYRO_FAST
    }
    fit = _fitting(scores) if scores else []
    return Told(
        f"the rates stated in {unit} exceed {fast / units.DEG_PER_S:.3g} deg/s in one sample of a "
        "hundred; " + (f"their unit is likely {' or '.join(fit)}" if fit else "check the unit"),
        True,
        fit[0] if fit else None,
        tuple(fit[1:]),
    )


def _unlikely(gyro, unit, factor, fit, odds, still, bias, noise) -> Told:
    """A stated unit that loses against those of `fit`, the best one first: refused where by far."""
    best_unit, also = fit[0], tuple(u for u in fit[1:] if u != unit)
    likely = " or ".join((best_unit, *also))
    worst = _worst(still, bias)
    if noise and still and noise / still > 60:
        worst = (
            f"noise of {still / units.DEG_PER_SQRT_HOUR:.2g} deg/sqrt(h), {noise / still:.0f} "
            "times less than the accelerometers' (m/s^2 per rad/s; 5 to 30 is usual)"
        )
    said = f"the rates stated in {unit} have a {worst}"
    tactical = (
        gyro.shape[1] == 3
        and 0.3 * EARTH < _mean_rate(gyro) < 3.0 * EARTH
        and names.GYRO_UNITS[best_unit] > factor
    )
    if odds < REFUSED or tactical:
        return Told(
            f"{said}: unusual, though possible; in {likely} they would be usual (--gyro-unit "
            f"{' or --gyro-unit '.join((best_unit, *also))})",
            False,
            best_unit,
            also,
        )
    return Told(f"{said}; their unit is likely {likely}", True, best_unit, also)


def _mean_rate(gyro: np.ndarray) -> float:
    x = some(gyro)
    return float(np.linalg.norm(x.mean(axis=0))) if len(x) else 0.0


def _worst(still: float, bias: float) -> str:
    if still > NOISY or bias < 0.3:
        return f"noise of {still / units.DEG_PER_SQRT_HOUR:.3g} deg/sqrt(h)"
    return f"bias of {bias / units.DEG_PER_S:.3g} deg/s"


def _score(still: float, bias: float, noise: float | None, rate: float) -> float:
    """Log-likelihood, up to a constant, of a gyro at rest with this noise density, bias and
    accelerometer noise.

    The noise of a slow record is folded in from above by decimation: below 100 Hz it is taken as if
    the sensor had a bandwidth of 50 Hz.
    """
    out = 0.0
    fold = np.sqrt(min(rate, 100.0) / 100.0)
    if still > 0:
        n = still * fold
        out -= 0.5 * (np.log(n / GYRO_NOISE[0]) / GYRO_NOISE[1]) ** 2
        if n > NOISY:
            out -= (np.log(n / NOISY) / 0.5) ** 2
        if noise:
            out -= 0.5 * (np.log(noise / still / RATIO[0]) / RATIO[1]) ** 2
    if bias > GYRO_BIAS[0]:
        # a turntable turns as evenly as a bias is constant: that alone refuses no unit
        out -= min(0.5 * (np.log(bias / GYRO_BIAS[0]) / GYRO_BIAS[1]) ** 2, MOST_OF_BIAS)
    return out


def _whole(x: np.ndarray) -> bool:
    x = some(x)
    return (
        bool(len(x))
        and bool((np.abs(x - np.rint(x)) < 1e-6 * np.maximum(1.0, np.abs(x))).all())
        and float(np.abs(x).max()) > 20
    )


def _noise_density(x: np.ndarray, rate: float) -> float:
    """White noise coefficient N from the mean absolute difference of neighbours, middle axis."""
    if len(x) < 10:
        return 0.0
    return (
        float(np.median(np.mean(np.abs(np.diff(x, axis=0)), axis=0)))
        * np.sqrt(np.pi / 2)
        / np.sqrt(2 * rate)
    )


def _still(gyro: np.ndarray, rate: float) -> tuple[float, float, bool]:
    """Noise density and largest bias of the quietest parts of a record (of a moving one, what it
    has when it stands), and whether the rest is as quiet.
    """
    block = max(20, int(rate))
    n = len(gyro) // block
    if n < 5:
        x = some(gyro)
        bias = float(np.abs(np.median(x, axis=0)).max()) if len(x) else 0.0
        return _noise_density(x, rate), bias, True
    parts = gyro[: n * block].reshape(n, block, -1)[:: max(1, n * block // (2 * MOST))]
    noise = (
        np.median(np.mean(np.abs(np.diff(parts, axis=1)), axis=1), axis=1)
        * np.sqrt(np.pi / 2)
        / np.sqrt(2 * rate)
    )
    swing = np.ptp(parts, axis=1).max(axis=1)
    good = np.flatnonzero(np.isfinite(noise) & np.isfinite(swing))
    if not good.size:
        return 0.0, 0.0, False
    quiet = good[np.argsort(swing[good], kind="stable")[: max(1, len(good) // 10)]]
    bias = float(np.abs(np.median(parts[quiet].mean(axis=1), axis=0)).max())
    same = bool(
        np.median(swing[good]) < 3.0 * np.median(swing[quiet]) or np.median(swing[quiet]) == 0
    )
    return float(np.median(noise[quiet])), bias, same
