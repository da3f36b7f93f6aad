"""What the gap workflow finds in the recorded signals as they are: verdict, causes, what is left.

    python benchmarks/gap_real.py --log real.jsonl          # resumes; stores the table
    python benchmarks/gap_real.py --names xsens_mtx --simulations 40   # that row, the others stay
    python benchmarks/gap_real.py --names vn100_still --simulations 100 --print
    python benchmarks/gap_real.py --again          # one sensor's model on its other records
    python benchmarks/gap_real.py --pictures       # the curves of stored models

No model is given. Ten minutes of the long ones, all of the others. Needs the folder of recorded
data, IMU_LIB_DATA. The table goes to benchmarks/results/gap_real.json.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import sys
import time
from datetime import date
from pathlib import Path
from types import SimpleNamespace

os.environ.setdefault("OMP_NUM_THREADS", "1")
ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT)]

from _log import Log  # noqa: E402

from imu_lib import datasets, read_record  # noqa: E402
from imu_lib.gap import close  # noqa: E402
from imu_lib.model import Model  # noqa: E402
from imu_lib.plots import recorded_curves  # noqa: E402

RESULTS = ROOT / "benchmarks" / "results"
#: File, what it needs to be read, and the stretch that is looked at, s.
RECORDS = {
    "vn100_still": ({"rate": 40.0}, None),
    "sony_cxd5602": ({}, None),
    "xsens_dot": ({"rate": 120.0}, None),
    "memsense_gyros": ({"rate": 250.0}, None),
    "xsens_mtx": ({"rate": 200.0}, None),
    "mtig_gyro_x": ({"rate": 100.0}, (0.0, 600.0)),
    "mpu6050_10min": ({}, (0.0, 600.0)),
    "mpu6050_raw_counts": ({}, None),
    "hipnuc_ch104": ({"rate": 100.0}, (600.0, 1200.0)),
    "sbg_ig500n": ({}, None),
    "adis16405_1": ({"rate": 100.0}, (600.0, 1200.0)),
    "adis16405_2": ({"rate": 100.0}, (600.0, 1200.0)),
    "adis16405_3": ({"rate": 100.0}, (600.0, 1200.0)),
    "phone": ({"gyro_unit": "rad/s", "accel_unit": "m/s^2"}, None),
}


def opened(data: Path, name: str, *, continuous: bool = False):
    """The record, or the stretch of it that is looked at, perhaps without its stamps."""
    options, stretch = RECORDS[name]
    if name == "phone":
        record = read_record(
            gyro=data / "static" / "phone_gyro.txt",
            accel=data / "static" / "phone_accel.txt",
            **options,
        )
    elif name == "mpu6050_raw_counts":  # counts, whose scale the registry knows
        record = datasets.load(name)
    else:
        record = read_record(data / "static" / f"{name}.npz", **options)
    record = record.continuous() if continuous else record
    return record if stretch is None else record.slice(*stretch)


def run(name: str, data: Path, simulations: int) -> dict:
    """What was found in one record."""
    started = time.perf_counter()
    found = close(opened(data, name), simulations=simulations, jobs=1)
    out = found.to_json()
    return {
        "record": name,
        "date": date.today().isoformat(),
        "duration": round(found.record.duration, 2),
        "rate": round(found.record.rate, 3),
        "simulations": simulations,
        "verdict": out["verdict"],
        "channels": {
            c: {
                "steps": [[s["effect"], s["confidence"], s["where"]] for s in r["steps"]],
                "unexplained": r["unexplained"],
                "gap_before": r["gap_before"],
                "gap_after": r["gap_after"],
                "held_out": r["gap_held_out"],
            }
            for c, r in out["channels"].items()
        },
        "on_record": [
            [s["effect"], s["confidence"], s["where"], s["parameters"].get("channels")]
            for s in out["record"]["steps"]
        ],
        "left_on_record": out["record"]["unexplained"],
        "model": found.model.to_json(),
        "seconds": round(time.perf_counter() - started, 1),
    }


#: Channels of the sensor whose records are compared: one of each filter, one that a fan shakes.
AGAIN = ("gyro_x", "gyro_z", "accel_x")


def again(data: Path, simulations: int = 20) -> list[dict]:
    """What a second and a third record of one sensor have beyond the model grown on the first."""
    first, *others = (opened(data, f"adis16405_{k}", continuous=True) for k in (1, 2, 3))
    known = {"channels": list(AGAIN), "jobs": 1}
    unit = close(first, simulations=0, **known)
    out = [{"record": "adis16405_1", **_beyond(unit)}]
    for k, other in zip((2, 3), others):
        bare = close(other, unit.base, simulations=simulations, **known)
        day = close(other, unit.model, simulations=simulations, **known)
        index = {
            c: {
                "sensor_and_day": round(bare.channels[c].before.value, 3),
                "day": round(day.channels[c].before.value, 3),
                "left": round(day.channels[c].after.value, 3),
            }
            for c in AGAIN
        }
        out.append({"record": f"adis16405_{k}", "index": index, **_beyond(day)})
        print(out[-1], flush=True)
    return out


def _beyond(found) -> dict:
    """What was found beyond a model, on the channels and on the record."""
    return {
        "steps": {c: [s.effect for s in r.result.steps] for c, r in found.channels.items()},
        "on_record": [
            [s.effect, s.where, s.parameters.get("channels")] for s in found.record_steps
        ],
    }


#: Channel of each record whose picture is stored.
PICTURES = {
    "vn100_still": "gyro_x",
    "xsens_dot": "gyro_x",
    "memsense_gyros": "gyro_x",
    "xsens_mtx": "accel_y",
    "mpu6050_10min": "gyro_z",
    "hipnuc_ch104": "gyro_x",
    "sbg_ig500n": "accel_z",
    "adis16405_1": "accel_z",
    "adis16405_2": "gyro_z",
    "phone": "gyro_y",
}


def pictures(data: Path) -> dict:
    """The curves of one channel of each record, with its stored model."""
    rows = json.loads((RESULTS / "gap_real.json").read_text())["records"]
    out = {}
    for row in rows:
        name = row["record"]
        if name in PICTURES:
            found = SimpleNamespace(record=opened(data, name), model=Model.from_json(row["model"]))
            curves = recorded_curves(found, PICTURES[name])
            out[name] = {"channel": PICTURES[name], "curves": curves}
    return out


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--names", default=",".join(RECORDS))
    parser.add_argument("--simulations", type=int, default=0, help="of the gap index; 0: none")
    parser.add_argument("--log", help="JSON lines; what is there already is not run again")
    parser.add_argument("--minutes", type=float, default=1e9, help="stop after this time")
    parser.add_argument("--again", action="store_true", help="only other records of one sensor")
    parser.add_argument("--pictures", action="store_true", help="only the curves of stored models")
    parser.add_argument("--print", action="store_true", help="store nothing")
    args = parser.parse_args()
    data, log = Path(os.environ["IMU_LIB_DATA"]), Log(args.log)
    rows = log.rows
    started = time.time()
    if args.again:
        return _keep({"another_record": again(data)})
    if args.pictures:
        return _keep({"pictures": pictures(data)})
    for name in args.names.split(","):
        if any(r["record"] == name for r in rows) or time.time() - started > 60 * args.minutes:
            continue
        row = run(name, data, args.simulations)
        log.add(row)
        print(name, " ".join(row["verdict"]), row["seconds"], flush=True)
    if not args.print:
        rows += [r for r in _stored() if all(r["record"] != new["record"] for new in rows)]
        rows.sort(key=lambda r: list(RECORDS).index(r["record"]))
        _keep(
            {
                "command": "python " + " ".join(["benchmarks/gap_real.py", *_said(sys.argv[1:])]),
                "date": date.today().isoformat(),
                "records": rows,
            }
        )


def _said(words: list[str]) -> list[str]:
    """The call without the place of its log, which is no part of the result."""
    return [w for a, w in zip(["", *words], words) if "--log" not in (a, w)]


def _stored() -> list[dict]:
    """The rows that are stored of other records."""
    path = RESULTS / "gap_real.json"
    return json.loads(path.read_text())["records"] if path.exists() else []


def _keep(content: dict):
    """Store what was found beside what is stored of other runs."""
    path = RESULTS / "gap_real.json"
    old = json.loads(path.read_text()) if path.exists() else {}
    text = json.dumps(old | content, indent=1)
    # curves on one line each
    text = re.sub(r"\[\s+(-?[\d.e+-]+(?:,\s+-?[\d.e+-]+)*)\s+\]", _flat, text)
    path.write_text(text + "\n")


def _flat(match) -> str:
    return "[" + ",".join(part.strip() for part in match[1].split(",")) + "]"


if __name__ == "__main__":
    main()
