"""A channel on disk whose output stands still for long: found by pieces, and left out as in
memory.
"""

from dataclasses import replace

import numpy as np

from imu_lib import timing
from imu_lib.faults.standing import LEAST, MOST_STILL, STANDS, least_run

#: Part without a gap that a pass goes over, samples.
SHORTEST = 1 << 16


def spans(record, name):
    """(channel, rows (k, 2) first and one behind the last of each stretch that stands still)."""
    column, found, again = record.columns[name], [], 0
    for start, stop, _ in record.runs:
        at, last, begun = int(start), None, None
        for x in column.source.pieces(column.name, int(start), int(stop)):
            same = np.r_[last is not None and x[0] == last, x[1:] == x[:-1]]
            again += int(same.sum())
            first, end = (edges + at for edges in timing.runs(same))
            runs = list(zip(first.tolist(), end.tolist()))
            if begun is not None:  # what stood still at the end of the piece before
                if runs and runs[0][0] == at:
                    runs[0] = (begun, runs[0][1])
                else:
                    runs.insert(0, (begun, at))
            at, last = at + x.size, x[-1]
            begun = runs.pop()[0] if runs and runs[-1][1] == at else None
            found += [run for run in runs if run[1] - run[0] >= STANDS]
        if begun is not None and at - begun >= STANDS:
            found.append((begun, at))
    least = least_run(record.n, max(LEAST, again / record.n))
    kept = [(a, b) for a, b in found if b - a > least]
    return name, np.array(kept, np.int64).reshape(-1, 2)


def without(record, rows):
    """The record without these rows (k, 2), and the share of its samples that they are; None in
    place of the record where too little is left.
    """
    share = float((rows[:, 1] - rows[:, 0]).sum()) / record.n
    runs = []
    for start, stop, slot in record.runs.tolist():
        at = start
        for a, b in rows.tolist():
            if at <= a and b <= stop:
                runs.append((at, a, slot + at - start))
                at = b
        runs.append((at, stop, slot + at - start))
    left = replace(record, runs=np.array([r for r in runs if r[1] > r[0]], np.int64))
    enough = share <= MOST_STILL and len(left.runs) and left.longest >= SHORTEST
    return (left if enough else None), share
