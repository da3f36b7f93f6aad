"""The page of measured scaling, book/scaling.md, from the stored table of scaling.py.

python benchmarks/scaling_page.py
"""

from __future__ import annotations

import json
from pathlib import Path

HERE = Path(__file__).parent
SENSORS, HOURS = 1000, 100.0
TEXT = """# How long it takes, and how much memory

Measured by `{command}` on {date}, {processors} processors; {note}. The machine was shared, with a
load of up to {busy:g}: **wall times are those of a busy machine**, processor times are what the work
costs. Memory is the peak of all processes of a command together: resident, and with the pages that
they share counted once.

## Length of a record

Six channels at 200 Hz, simulated into a Parquet file, then checked and characterised from it.

{table}

Up to 5.8 hours (4.2 million samples) `characterise` and `simulate` hold a record in memory; beyond,
it stays on disk and each channel goes through one pass of some megabytes, so that memory does not
grow with length: the day takes less than the hour. `check` looks at records of more than half a
million samples part by part.

## What does not scale

Of the processor time of `characterise` about {fixed:.0f} s do not depend on the length: programs
that are loaded in each process, and fits to some hundred statistics. Between the shortest and the
longest record an hour adds {hourly:.1f} s. With workers the loading is paid in each of them, and a
fleet adds its table and its summary at the end.

## A thousand sensors

{sensors:,} sensors of {hours:g} hours at 200 Hz would need, by these figures, {total:.0f} hours of
processor time: {two:.0f} hours on two processors, {many:.1f} hours on 64, in two processes of about
{each:.0f} MiB each for a record, whatever its length. The records are {size:.1f} TB as numbers of
eight bytes; how fast the disks give them was not measured here. The longest record measured had
{longest:g} hours; two workers against one were not measured on idle processors.

Long records whose stamps jitter, text files and compressed `.npz` are still read into memory as a
whole, and so is what `gap` and `compare` are given.
"""


def table(rows):
    """The measurements as a table."""
    heads = {
        "command": "command",
        "hours": "hours",
        "wall": "wall, s",
        "processor": "processor, s",
        "rss": "resident, MiB",
        "pss": "shared once, MiB",
    }
    out = ["| " + " | ".join(heads.values()) + " |", "|" + "---|" * len(heads)]
    for row in rows:
        cells = (row[key] for key in heads)
        text = ("-" if c is None else c if isinstance(c, str) else f"{c:g}" for c in cells)
        out.append("| " + " | ".join(text) + " |")
    return "\n".join(out)


def page(told):
    """The text of the page."""
    rows = [row for row in told["table"] if "hours" in row]
    own = sorted((r["hours"], r["processor"], r["rss"]) for r in rows if r["command"] == "characterise")  # fmt: skip
    (t0, y0, _), (t1, y1, memory) = own[0], own[-1]
    hourly = (y1 - y0) / (t1 - t0)
    fixed = y0 - hourly * t0
    total = SENSORS * (fixed + HOURS * hourly) / 3600
    return TEXT.format(
        command=told["command"],
        date=told["date"],
        processors=told["processors"],
        note=told["note"],
        busy=max(row["load"] for row in rows),
        table=table(rows),
        fixed=fixed,
        hourly=hourly,
        sensors=SENSORS,
        hours=HOURS,
        total=total,
        two=total / 2,
        many=total / 64,
        each=memory / 2,
        size=SENSORS * HOURS * 3600 * 200 * 7 * 8 / 1e12,
        longest=t1,
    )


if __name__ == "__main__":
    told = json.loads((HERE / "results" / "scaling.json").read_text(encoding="utf-8"))
    (HERE.parent / "book" / "scaling.md").write_text(page(told), encoding="utf-8")
