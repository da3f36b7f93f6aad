"""The page of measured scaling, book/scaling.md, from the stored table of scaling.py.

python benchmarks/scaling_page.py
"""

from __future__ import annotations

import json
from pathlib import Path

HERE = Path(__file__).parent
SENSORS, HOURS = 1000, 100.0
TEXT = """# How long it takes, and how much memory

Measured by `python benchmarks/scaling.py` ({dates}), {processors} processors. {busy} Memory is the
peak of all processes of a command together: resident, and with the pages that they share counted
once.

## Length of a record

Six channels at 200 Hz, simulated into a Parquet file, then checked, characterised, compared with the
model and searched for what the model misses (`gap`, an ensemble of a hundred simulations).

{lengths}

Up to a million samples (1.5 hours) `characterise` and `compare` hold a record in memory, `gap` up to
four million (5.8 hours); beyond, it stays on disk, and memory does not grow with its length:

| command | what it does with a long record |
|---|---|
| `simulate` | draws each channel by pieces into its file; the same seed gives the same samples whatever the pieces |
| `check` | looks at parts of twenty minutes, one after the other |
| `characterise`, `compare` | one pass over each channel, of some megabytes, whose sums merge |
| `gap` | one pass for block means and windows of minutes; the workflow on the part most like the rest, on the block means, on windows unlike the rest |

{grows}
Parquet, NumPy files that are not compressed and HDF5 are read where they lie. Text, packed logs,
compressed `.npz` and files whose stamps jitter are read once, part by part, into a Parquet file in
the user's cache (`IMU_LIB_CACHE` names another folder), which the next command finds again; the
command says where it is. ROS bags, ULog files and MATLAB files before 7.3 are read into memory as a
whole, which is said. A Zarr store (formats 2 and 3, a folder or one that was zipped) is read by
slices as HDF5 is, where `pip install 'imu_lib[zarr]'` has brought its library.

{fleets}## What does not scale

Of the processor time of `characterise` about {fixed:.0f} s do not depend on the length: programs
that are loaded in each process, and fits to some hundred statistics. Between the shortest and the
longest record an hour adds {hourly:.1f} s. With workers the loading is paid in each of them. A fleet's
table is written and its summary made by one process{alone}.

## A thousand sensors

{sensors:,} sensors of {hours:g} hours at 200 Hz would need, by these figures, {total:.0f} hours of
processor time to be characterised: {two:.0f} hours on two processors, {many:.1f} hours on 64, in two
processes of about {each:.0f} MiB each for a record, whatever its length. The records are {size:.1f} TB
as numbers of eight bytes; how fast the disks give them was not measured here. The longest record
measured had {longest:g} hours.
"""


def table(rows, first, head):
    """Measurements as a table; `first` is the key of its second column."""
    heads = {
        "command": "command",
        first: head,
        "wall": "wall, s",
        "processor": "processor, s",
        "rss": "resident, MiB",
        "pss": "shared once, MiB",
        "load": "load",
    }
    out = ["| " + " | ".join(heads.values()) + " |", "|" + "---|" * len(heads)]
    for row in rows:
        cells = (row.get(key) for key in heads)
        text = ("-" if c is None else c if isinstance(c, str) else f"{c:g}" for c in cells)
        out.append("| " + " | ".join(text) + " |")
    return "\n".join(out)


def fleets(rows):
    """The section on fleets, empty where none was measured."""
    own = [r for r in rows if r.get("workers")]
    if not own:
        return ""
    lines = []
    for one in (r for r in own if r["workers"] == 1):
        two = next(
            (
                r
                for r in own
                if r["workers"] == 2
                and r["records"] == one["records"]
                and r.get("minutes") == one.get("minutes")
            ),
            None,
        )
        if two:
            lines.append(
                f"Two workers take {two['wall']:g} s where one takes {one['wall']:g} s for "
                f"{one['records']} records: {one['wall'] / two['wall']:.2f} times faster, and the "
                "table is the same, byte for byte."
            )
    minutes = ", ".join(sorted({f"{r['minutes']:g}" for r in own if "minutes" in r}))
    about = f"Records of {minutes} minutes, six channels at 200 Hz, on one and on two workers."
    return "\n\n".join(["## Fleets", about, table(own, "records", "records"), *lines]) + "\n\n"


def alone(rows):
    """What the summary costs, where it was measured."""
    own = [r for r in rows if r["command"] == "fleet's summary alone"]
    if not own:
        return ""
    most = max(own, key=lambda r: r["records"])
    return f": of {most['records']} records the summary takes {most['processor']:g} s"


def grows(rows):
    """A sentence where the peak of `gap` is not the same on the two longest records."""
    own = sorted((r["hours"], r["pss"]) for r in rows if r["command"] == "gap")[-2:]
    (short, before), (long, after) = own[0], own[-1]
    if after < 1.1 * before:
        return ""
    return (
        f"Except for `gap`, whose two processes had a peak of {after:.0f} MiB together on {long:g} "
        f"hours and {before:.0f} MiB on {short:g}.\n\n"
    )


def page(told):
    """The text of the page."""
    rows = [row for row in told["table"] if "hours" in row]
    own = sorted(
        (r["hours"], r["processor"], r["rss"]) for r in rows if r["command"] == "characterise"
    )
    (t0, y0, _), (t1, y1, memory) = own[0], own[-1]
    hourly = (y1 - y0) / (t1 - t0)
    fixed = y0 - hourly * t0
    total = SENSORS * (fixed + HOURS * hourly) / 3600
    load = max(row["load"] for row in told["table"])
    busy = (
        f"The machine was shared, with a load of up to {load:g}: **wall times under a load of more "
        "than two are those of a busy machine**, processor times are what the work costs."
        if load > 3
        else "Nothing else ran on it."
    )
    return TEXT.format(
        dates=", ".join(sorted({row["date"] for row in told["table"]})),
        processors=told["processors"],
        busy=busy,
        lengths=table(rows, "hours", "hours"),
        grows=grows(rows),
        fleets=fleets(told["table"]),
        alone=alone(told["table"]),
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
