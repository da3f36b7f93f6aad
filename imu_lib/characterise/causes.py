"""What stands behind a slow error, or behind the lack of one: warming, an output that re-zeroes
itself, a level that jumped, steps of a converter in the place of noise. Said beside the
coefficients, which describe all of them as if they were the sensor's noise.
"""

from __future__ import annotations

import numpy as np
from scipy import stats
from scipy.fft import rfft

from imu_lib import units
from imu_lib.faults import jump, travelling
from imu_lib.faults.grid import resolution
from imu_lib.long_record import LongRecord
from imu_lib.record import Record

WARMED = 1.0  # degC over the record: below, a drift has other causes
FOLLOWS = (
    0.6  # share of the slow variation that the temperature accounts for, from which it is said
)
PART = 1 << 17  # samples of a part of a record on disk
BLOCKS = 200  # means over which slow variation is looked at
STRONG = 3.0  # times the variance that the noise leaves in such means
SURE = 1e-6  # probability, times the bands looked at, below which the low end is called empty
EMPTY = 0.5  # of the density above it


def notes(record: Record, names) -> tuple[str, ...]:
    """Sentences on what the slow end of each channel shows besides noise.

    Parameters
    ----------
    record : Record
        Evenly sampled, no gaps.
    names : sequence of str
        The channels looked at.
    """
    return (
        *filter(None, [travelling.sentence(record) or jump.sentence(record, names)]),
        *coarse(record, names),
        *warming(record, names),
        *empty_low_end(record, names),
    )


def of_parts(record: LongRecord, names):
    """Sentences on motion and coarse steps of a record on disk, from a part of its beginning,
    middle and end.
    """
    last = max(record.rows - PART, record.begin)
    starts = sorted({record.begin, (record.begin + last) // 2, last})
    parts = [record.part(low, min(low + PART, record.rows)) for low in starts]
    moved = [said for part in parts if (said := travelling.sentence(part))]
    if 2 * len(moved) > len(parts):
        yield moved[0]
    yield from _coarse({name: [part[name] for part in parts] for name in names})


def coarse(record: Record, names):
    """Channels whose output steps are coarser than their scatter: rounding takes the place of
    noise.
    """
    yield from _coarse({name: [record[name]] for name in names})


def _coarse(channels):
    found = []
    for name, parts in channels.items():
        told = [(s, float(np.nanstd(x))) for x in parts if (s := resolution(x))]
        step, scatter = np.median(told, axis=0) if told else (0.0, 0.0)
        if step and 0 < scatter < step:
            factor, unit = (units.DEG_PER_S, "deg/s") if name.startswith("gyro") else (units.G, "g")
            found.append(f"{name} {step / factor:.3g} against {scatter / factor:.3g} {unit}")
    if found:
        yield (
            f"The output steps are coarser than the scatter ({'; '.join(found)}): the "
            "coefficients of these channels describe the rounding, not the noise "
            "of the sensor, which may be far smaller or nearly as large."
        )


def warming(record: Record, names):
    """Channels whose slow variation follows the temperature."""
    if record.temperature is None or np.ptp(record.temperature) < WARMED:
        return
    n = record.n // BLOCKS
    if n < 2:
        return
    warm = record.temperature[: n * BLOCKS].reshape(BLOCKS, n).mean(axis=1)
    follow = []
    for name in names:
        x = record[name][: n * BLOCKS].reshape(BLOCKS, n)
        means = x.mean(axis=1)
        own = float(np.mean(np.diff(record[name][: n * BLOCKS]) ** 2)) / 2.0 / n
        if np.var(means) < STRONG * own:
            continue
        r = np.corrcoef(means, warm)[0, 1] ** 2
        if r > FOLLOWS:
            follow.append(f"{name} {100 * r:.0f} %")
    if follow:
        yield (
            f"The temperature moved by {np.ptp(record.temperature):.3g} degC and the slow "
            f"variation follows it (share it accounts for: {', '.join(follow)}): K, R and slow "
            "Gauss-Markov processes of these channels describe that warming, not noise of the "
            "sensor; let it settle, or fit a temperature term (imu-lib gap)."
        )


def empty_low_end(record: Record, names):
    """Channels whose spectrum falls towards zero frequency: high-passed, or re-zeroed while at
    rest.
    """
    empty = []
    for name in names:
        found = _empty(record[name] - np.mean(record[name]), record.rate)
        if found:
            empty.append(f"{name} below {found[0]:.2g} Hz by {found[1]:.0f} dB")
    if empty:
        yield (
            f"The spectrum falls towards zero frequency ({'; '.join(empty)}): the output is "
            "high-passed, or re-zeroes itself at rest. N holds above that "
            "frequency; of the bias and what drives it the record shows nothing, and a model of "
            "white noise promises too much of a moving sensor."
        )


def _empty(x: np.ndarray, rate: float) -> tuple[float, float] | None:
    """Frequency (Hz) below which the periodogram of `x` (n,) is empty, and by how much (dB),
    against the band above it; None where it is not.

    Of white noise the mean of m ordinates over that of many others is Gamma(m) / m.
    """
    n = len(x)
    if n < 4096:
        return None
    power = np.abs(rfft(x)) ** 2
    power = power[1:]  # the mean is taken out
    total = np.r_[0.0, np.cumsum(power)]
    best = None
    bands = [m for m in 2 ** np.arange(3, 14) if 64 * m < len(power)]
    for m in bands:
        low = total[m] / m
        above = (total[64 * m] - total[8 * m]) / (56 * m)
        ratio = low / above if above > 0 else 1.0
        sure = stats.gamma.cdf(m * ratio, m) * len(bands)
        if ratio < EMPTY and sure < SURE:
            best = (m * rate / n, -10.0 * np.log10(max(ratio, 1e-12)))
    return best
