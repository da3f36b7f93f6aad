"""The page of measured scaling, book/scaling.md, from the stored table of scaling.py.

python benchmarks/scaling_page.py
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

HERE = Path(__file__).parent
SENSORS, HOURS = 1000, 100.0


def line(rows, command):
    """(fixed, per hour) processor time of a command, s, by least relative squares."""
    own = [r for r in rows if r["command"] == command]
    t, y = (np.array([r[key] for r in own], float) for key in ("hours", "processor"))
    return np.linalg.lstsq(np.column_stack([1 / y, t / y]), np.ones(y.size), rcond=None)[0]


def table(rows, columns, heads):
    def cell(value):
        return "-" if value is None else value if isinstance(value, str) else f"{value:g}"

    out = ["| " + " | ".join(heads) + " |", "|" + "---|" * len(heads)]
    out += ["| " + " | ".join(cell(r[c]) for c in columns) + " |" for r in rows]
    return "\n".join(out)


def page(told):
    rows = told["table"]
    lengths = [r for r in rows if "hours" in r]
    fleets = [r for r in rows if "records" in r]
    busy = max(r["load"] for r in rows)
    longest = max(r["hours"] for r in lengths)
    one = next(r for r in lengths if r["command"] == "characterise" and r["hours"] == longest)
    fixed, hourly = line(lengths, "characterise")
    total = SENSORS * (fixed + HOURS * hourly) / 3600
    pairs = [
        (a, b) for a in fleets for b in fleets
        if a["records"] == b["records"] and (a["workers"], b["workers"]) == (1, 2)
    ]  # fmt: skip
    text = f"""# How long it takes, and how much memory

Measured by `{told["command"]}` on {told["date"]}, {told["processors"]} processors. The machine was
shared, with a load of up to {busy:g} on them: **wall times are those of a busy machine**, processor
times are what the work costs. Memory is the peak of all processes of a command together, each with
the pages that it shares counted (resident) and with them counted once (shared once).

## Length of a record

Six channels at 200 Hz, simulated into a Parquet file, then checked and characterised from it.

{
        table(
            lengths,
            ("command", "hours", "wall", "processor", "rss", "pss"),
            ("command", "hours", "wall, s", "processor, s", "resident, MiB", "shared once, MiB"),
        )
    }

Up to 5.8 hours (4.2 million samples) a record is held in memory; beyond, it stays on disk and each
channel goes through one pass of some megabytes, so that memory does not grow with length.

## What does not scale

Of the processor time of `characterise` about {
        fixed:.0f} s do not depend on the length: programs that
are loaded in each process and the fits, whose size is that of some hundred statistics. An hour of
record adds {hourly:.2f} s.

## Number of records

Records of one minute at 50 Hz, six channels: nearly all of the time is fits.

{
        table(
            fleets,
            ("records", "workers", "wall", "processor", "rss", "pss"),
            ("records", "workers", "wall, s", "processor, s", "resident, MiB", "shared once, MiB"),
        )
    }

The tables are the same bytes for one and for two workers. What does not scale is the start of the
processes, the table and the summary at the end. """
    text += "; ".join(
        f"{a['records']} records: {a['wall'] / b['wall']:.2f} times faster on two workers"
        for a, b in pairs
    )
    text += f""" in wall time, on processors that had other work to do.

## A thousand sensors

{SENSORS:,} sensors of {HOURS:g} hours at 200 Hz would need, by these figures,
{total:.0f} hours of processor time: {total / 2:.0f} hours on two processors, {total / 64:.1f} hours on 64.
Each process takes about {one["rss"] / 2:.0f} MiB, whatever the length. The
records themselves are {SENSORS * HOURS * 3600 * 200 * 7 * 8 / 1e12:.1f} TB as numbers of eight bytes; reading them is then the larger
part of the work of the disks, which was not measured here. Longest record measured: {longest:g} hours.

Long records whose stamps jitter, text files and compressed `.npz` are still read into memory as a
whole, and so is what `gap` and `compare` are given.
"""
    return text


if __name__ == "__main__":
    told = json.loads((HERE / "results" / "scaling.json").read_text(encoding="utf-8"))
    (HERE.parent / "book" / "scaling.md").write_text(page(told), encoding="utf-8")
