"""Reading coefficients off the slopes of an Allan curve, as IEEE Std 952 and the papers do, with
intervals.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from imu_lib.allan.confidence import interval
from imu_lib.allan.deviation import AllanCurve, deviation
from imu_lib.arrays import Array
from imu_lib.estimate import Estimate
from imu_lib.record import Record
from imu_lib.slopes import Segment, rising, segments

#: Flat Allan deviation over B, sqrt(2 ln2 / pi).
FLAT = float(np.sqrt(2 * np.log(2) / np.pi))
#: The Allan deviation of a first-order Gauss-Markov process peaks at PEAK_TIME * Tc with PEAK *
#: sigma.
PEAK_TIME, PEAK = 1.8926, 0.6174
#: Symbol -> slope of the deviation, averaging time at which the line gives the coefficient (Annex
#: C of the standard).
LINES = {
    "Q": (-1.0, 3**0.5),
    "N": (-0.5, 1.0),
    "B": (0.0, 1.0),
    "K": (0.5, 3.0),
    "R": (1.0, 2**0.5),
}


@dataclass(frozen=True)
class Reading:
    """What the slopes of an Allan curve say.

    Attributes
    ----------
    coefficients : dict of str to Estimate
        Q, N, B, K, R; one without a segment of its slope has no value and an upper limit.
    segments : tuple of Segment
        All straight stretches, in order of averaging time.
    used : dict of str to Segment
        The stretch that each coefficient was read from.
    flat : Estimate
        The flat level itself, 0.664 B.
    correlation_time : Estimate
        Averaging time in the (logarithmic) middle of the flat part, with its ends: what the 2013
        paper takes for Tc (Table 5).
    sigma, peak_correlation_time : Estimate
        The flat part read as the peak of a Gauss-Markov process: level / 0.617 and time / 1.893.
    """

    coefficients: dict[str, Estimate]
    segments: tuple[Segment, ...]
    used: dict[str, Any]
    flat: Estimate
    correlation_time: Estimate
    sigma: Estimate
    peak_correlation_time: Estimate

    def __getitem__(self, symbol: str) -> Estimate:
        return self.coefficients[symbol]


def read_off(curve: AllanCurve, *, least: float = 0.3, longest: float | None = None) -> Reading:
    """Find the straight stretches of an Allan curve and read the coefficients at the standard's
    averaging times.

    Q at sqrt(3) s, N at 1 s, B the flat level over 0.664, K at 3 s, R at sqrt(2) s, each on the
    line through its own stretch (Table 1 of the 2011 paper). Only stretches in an order of rising
    slope are read, of several of one slope the longest. The interval of a line is that of its best
    known point, widened by the points' scatter about it. No line is forced where there is no
    stretch: the coefficient is then at most what the curve leaves room for at every averaging
    time.

    Parameters
    ----------
    curve : AllanCurve
    least : float
        Shortest stretch, decades.
    longest : float or None
        Longest averaging time that takes part, s; by default a tenth of the record, beyond which
        too few clusters are left to see a slope in them.

    Returns
    -------
    Reading
    """
    good = np.flatnonzero((curve.adev > 0) & (curve.tau <= (longest or curve.duration / 10)))
    tau, adev, edf = curve.tau[good], curve.adev[good], curve.edf[good]
    # neighbouring points of an overlapped curve say nearly the same: about three of them count as
    # one
    found = segments(
        tau, adev, np.sqrt(1.5 / edf), [slope for slope, _ in LINES.values()], least=least
    )
    chain = rising(found)
    upper = interval(adev, edf, level=0.9)[1]
    coefficients, used = {}, {}
    for symbol, (slope, place) in LINES.items():
        scale = FLAT if symbol == "B" else 1.0
        mine = [s for s in chain if s.slope == slope]
        if mine:
            used[symbol] = line = max(mine, key=lambda s: s.decades)
            coefficients[symbol] = _on_line(line, edf, place).scaled(1 / scale)
        else:
            coefficients[symbol] = Estimate.absent(np.min(upper * (place / tau) ** slope) / scale)
    flat = coefficients["B"].scaled(FLAT)
    middle = Estimate.absent()
    if "B" in used:
        line = used["B"]
        middle = Estimate((line.start * line.stop) ** 0.5, line.start, line.stop)
    return Reading(
        coefficients, found, used, flat, middle, flat.scaled(1 / PEAK), middle.scaled(1 / PEAK_TIME)
    )


def of_record(record: Record) -> tuple[dict[str, AllanCurve], dict[str, Reading]]:
    """Curve and reading of every channel of a `Record`: (dict of AllanCurve, dict of Reading) by
    channel.
    """
    curves = {channel: deviation(record[channel], record.rate) for channel in record.channel_names}
    return curves, {channel: read_off(curve) for channel, curve in curves.items()}


def _on_line(line: Segment, edf: Array, place: float) -> Estimate:
    points = slice(line.first, line.last + 1)
    relative = np.sqrt(0.5 / edf[points].max() + line.scatter**2 / (line.last - line.first + 1))
    value = float(line.at(place))
    low, high = interval(value, 0.5 / relative**2)
    return Estimate(value, float(low), float(high))
