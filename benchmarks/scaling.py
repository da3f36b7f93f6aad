"""Time and memory against the length of a record and the number of records, each command in a
process of its own: wall time, processor time, and the peak memory of all its processes together.

python benchmarks/scaling.py --hours 0.167 1 6 24 --records 1 20

Each run replaces its own rows of the stored table and keeps the others; scaling_page.py makes the
page of it.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from imu_lib import fleet
from imu_lib.model import Model

RESULT = Path(__file__).parent / "results" / "scaling.json"
RATE, MODEL = 200.0, "preset:3dm-gx3-25"


def processes(pid):
    """The process and all that it has started."""
    out = [pid]
    try:
        for thread in os.listdir(f"/proc/{pid}/task"):
            text = Path(f"/proc/{pid}/task/{thread}/children").read_text()
            for child in text.split():
                out += processes(int(child))
    except OSError:
        pass
    return out


def memory(pid):
    """(sum of resident sizes, the same with shared pages counted once), MiB."""
    total = dict.fromkeys(("Rss:", "Pss:"), 0)
    for one in processes(pid):
        try:
            for line in Path(f"/proc/{one}/smaps_rollup").read_text().splitlines():
                key, *rest = line.split()
                if key in total:
                    total[key] += int(rest[0])
        except OSError:
            continue
    return total["Rss:"] / 1024, total["Pss:"] / 1024


def measured(*call):
    """One command: wall and processor time in s, peak memory in MiB."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    start = time.perf_counter()
    run = subprocess.Popen([sys.executable, "-m", "imu_lib", *map(str, call)],
                           stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)  # fmt: skip
    peak = np.zeros(2)
    while run.poll() is None:
        began = time.perf_counter()
        peak = np.maximum(peak, memory(run.pid))
        # reading the maps of large processes stops them: at most a hundredth of the time
        time.sleep(max(0.1, 100 * (time.perf_counter() - began)))
    wall = time.perf_counter() - start
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if run.returncode:
        raise SystemExit(f"{' '.join(map(str, call))} has ended with {run.returncode}")
    used = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return {
        "wall": round(wall, 1),
        "processor": round(used, 1),
        "rss": round(peak[0]),
        "pss": round(peak[1]),
        "load": round(os.getloadavg()[0], 1),
    }


def of_lengths(hours, commands, folder, keep):
    for length in hours:
        file = folder / f"{length}.parquet"
        call = ("simulate", MODEL, "--hours", length, "--rate", RATE, "--seed", 1, "--out", file)
        keep({"command": "simulate", "hours": length} | measured(*call))
        for command in commands:
            more = {"gap": ("--model", MODEL), "compare": (MODEL,)}.get(command, ())
            keep({"command": command, "hours": length} | measured(command, file, *more))
        file.unlink()


def of_records(counts, minutes, folder, keep):
    """Fleets of six channels at RATE; the table is the same bytes on one and on two workers."""
    axes = [f"{kind}_{axis}" for kind in ("gyro", "accel") for axis in "xyz"]
    entry = [{"process": "white_noise", "N": 1e-4}, {"process": "random_walk", "K": 1e-6}]
    spread = {axis: {"N": {"scatter": 0.2}} for axis in axes}
    model = Model.from_json({**dict.fromkeys(axes, entry), "spread": spread})
    for count in counts:
        records = folder / f"fleet{count}"
        records.mkdir()
        drawn = {"sensors": count, "dates": ("2024-01-01",), "hours": minutes / 60, "rate": RATE}
        fleet.simulate(model, records, seed=1, **drawn)
        tables = []
        for workers in (1, 2):
            out = folder / f"out{count}_{workers}"
            found = measured("fleet", records, "--out", out, "--workers", workers)
            told = {"command": "fleet", "records": count, "minutes": minutes, "workers": workers}
            keep(told | found)
            tables.append((out / "fleet.parquet").read_bytes())
        assert tables[0] == tables[1], "the table depends on the number of workers"
        start = time.process_time()
        fleet.summary(fleet.load(out))
        used = round(time.process_time() - start, 2)
        keep({"command": "fleet's summary alone", "records": count, "minutes": minutes,
              "processor": used, "load": round(os.getloadavg()[0], 1)})  # fmt: skip


def _same(a, b):
    keys = ("command", "hours", "records", "minutes", "workers")
    return all(a.get(k) == b.get(k) for k in keys)


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--hours", type=float, nargs="*", default=[0.167, 1.0, 6.0, 24.0])
    parser.add_argument(
        "--commands", nargs="*", default=["check", "characterise", "compare", "gap"]
    )
    parser.add_argument("--records", type=int, nargs="*", default=[])
    parser.add_argument("--minutes", type=float, default=10.0, help="of a fleet's record")
    parser.add_argument("--folder", type=Path, help="where the records are made")
    parser.add_argument(
        "--out", type=Path, default=RESULT, help="rows there are kept but for these"
    )
    options = parser.parse_args(arguments)
    held = json.loads(options.out.read_text(encoding="utf-8")) if options.out.exists() else {}
    rows = held.get("table", [])

    def keep(row):
        row["date"] = time.strftime("%Y-%m-%d")
        rows[:] = [r for r in rows if not _same(r, row)] + [row]
        rows.sort(key=lambda r: (r.get("records", 0), r.get("workers", 0), r.get("hours", 0)))
        print(row, flush=True)
        told = {"processors": os.cpu_count(), "table": rows}
        options.out.write_text(json.dumps(told, indent=1) + "\n", encoding="utf-8")

    with tempfile.TemporaryDirectory(dir=options.folder) as folder:
        of_records(options.records, options.minutes, Path(folder), keep)
        of_lengths(options.hours, options.commands, Path(folder), keep)


if __name__ == "__main__":
    main()
