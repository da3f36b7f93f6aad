"""All records of a fleet, characterised in parallel, each one once."""

from __future__ import annotations

from pathlib import Path

from imu_lib import scheduler
from imu_lib.fleet import rows
from imu_lib.fleet.ledger import Ledger


def characterise(entries, out, *, workers=None, address=None, gap=False, progress=None) -> Path:
    """Characterise the records that have not been yet; returns the table's path.

    Parameters
    ----------
    entries : list of Entry
    out : path
        Folder of the table and of what has ended so far; with the same folder a run that was
        stopped goes on where it was.
    workers, address
        As for `scheduler.run`.
    gap : bool
        Whether the gap workflow is asked what each record's model misses.
    progress : callable, optional
        Called with the Entry and its rows as each record ends.
    """
    ledger = Ledger(out, entries, gap=gap)
    places = ledger.open()
    tasks = [(entries[place], gap) for place in places]
    for number, result in scheduler.run(
        rows.of_record, tasks, workers=workers, address=address, apart=True
    ):
        entry = tasks[number][0]
        found = rows.lost(entry) if isinstance(result, scheduler.Lost) else result
        ledger.put(places[number], found)
        if progress is not None:
            progress(entry, found)
    return ledger.write()
