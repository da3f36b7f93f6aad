"""In which order are the logs of a folder? By their names, unless their stamps say another."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

#: Stamps beyond this count seconds of a calendar, not of a device: thirty years.
CALENDAR = 9.5e8
#: Samples between the end of a log and the beginning of the next where one goes on from the other.
GOES_ON = 1.5


def by_stamps(
    files: Sequence[Path], spans: Sequence[tuple[float, float] | None], rate: float
) -> list[Path] | None:
    """The files in the order of their stamps; None where this is the order that they have, or
    where the stamps tell none.

    Stamps that begin anew in each file tell none. Those of one clock do: dates, or logs that
    follow each other to the sample in the other order.

    Parameters
    ----------
    files : sequence of path
    spans : sequence of (float, float) or None
        First stamp of each and the one that would follow its last, s.
    rate : float
        Hz.
    """
    known = [s for s in spans if s is not None]
    if len(known) < len(files):
        return None
    order = sorted(range(len(files)), key=lambda i: known[i])
    if order == list(range(len(files))):
        return None
    apart = [known[j][0] - known[i][1] for i, j in zip(order, order[1:])]
    if min(apart) * rate < -GOES_ON:
        return None
    dated = all(begin > CALENDAR for begin, _ in known)
    if not dated and max(apart) * rate > GOES_ON:
        return None
    return [files[i] for i in order]
