"""What the gap workflow finds on recorded drives, and effects hidden in them.

    IMU_LIB_DATA=FOLDER python benchmarks/drive_gap_real.py [NAME ...]   # FOLDER/drive/*.npz

Each drive is searched as it is, without an error model; then, from what was found, with one effect
hidden in it at a time (`HIDDEN`, and turned axes). What is found then is compared with what was
found before. `expected` is the gain in nats that the drive's own information promises for the
hidden value: below PROMISED no search can name it (`excited` is false), and the answer is the upper
limit. Of two sizes of an effect the smaller is hidden where it is excited, else the larger; the
opposite where it would cancel what the drive has of it, so that nothing were left to be named. Errors
of the withheld outages are stored for the chapter's picture. Names given are searched anew (all
without names that the table in benchmarks/results/drive_gap_real.json does not hold), with --plain
without hidden effects: rows of them that there are stay. What was hidden is stored one by one;
--resume keeps what is there of today.
"""

from __future__ import annotations

import json
import os
import sys
import time
from datetime import date
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT)]

import numpy as np  # noqa: E402
from scipy.spatial.transform import Rotation  # noqa: E402

from imu_lib.drive import Drive  # noqa: E402
from imu_lib.gap import drive as gap_drive  # noqa: E402
from imu_lib.gap.drive import columns, select, vehicle  # noqa: E402
from imu_lib.navigation import axes  # noqa: E402

RESULTS = ROOT / "benchmarks" / "results" / "drive_gap_real.json"
TURNED = ("+y", "-x", "+z")
PROMISED = 15.0  # nats
#: what is hidden: effect, component, value, tolerance within which it counts as found again
HIDDEN = (
    ("gnss_time_offset", "offset", 0.3, 0.02),
    ("accel_scale", "scale x", 0.03, 0.003),
    ("accel_scale", "scale x", 0.05, 0.005),
    ("gyro_scale", "scale z", 0.03, 0.003),
    ("gyro_scale", "scale z", 0.05, 0.005),
    ("lever_arm", "arm x", 1.0, 0.3),
    ("mounting", "yaw", np.radians(4.0), np.radians(0.5)),
    ("gnss_noise", "position", 2.0, 0.2),
)


def searched(drive, **options):
    begin = time.process_time()
    found = gap_drive.close(drive, **options)
    result = found.to_json()["drive"]
    for step in result["steps"]:
        step.pop("cause", None)
    if found.outages is not None:
        study, against = found.outages.study, found.outages.against
        result["errors"] = {
            n: [round(float(v), 3) for v in study.errors(n, against=against)] for n in study.models
        }
    result["seconds"] = time.process_time() - begin
    return result, found


def hide(drive, effect, component, value):
    """The drive with one effect put in."""
    axis = "xyz".index(component[-1]) if component[-2:-1] == " " else 0
    if effect == "gnss_time_offset":
        return drive.with_(gnss_time=np.asarray(drive.gnss_time) + value)
    if effect in ("accel_scale", "gyro_scale"):
        name = effect.split("_")[0]
        readings = np.array(getattr(drive, name))
        readings[:, axis] *= 1.0 + value
        return drive.with_(**{name: readings})
    if effect == "lever_arm":  # the file's arm is wrong by as much
        arm = np.zeros(3) if drive.lever_arm is None else np.array(drive.lever_arm, float)
        arm[axis] -= value
        return drive.with_(lever_arm=arm)
    if effect == "mounting":
        turn = Rotation.from_euler("ZYX", [value, 0.0, 0.0]).inv()
        return drive.with_(
            gyro=turn.apply(np.array(drive.gyro)), accel=turn.apply(np.array(drive.accel))
        )
    rng = np.random.default_rng(5)
    sd = np.array(drive.gnss_position_sd if drive.gnss_position_sd is not None else [3.0, 3.0, 5.0])
    return drive.with_(gnss_position=_displaced(drive, rng, sd, value))


def _displaced(drive, rng, sd, ratio):
    """Positions with so much white noise that errors of `sd` become `ratio` times as large."""
    p = np.array(drive.gnss_position)
    more = rng.standard_normal(p.shape) * np.sqrt(ratio**2 - 1.0) * sd
    p[:, 0] += more[:, 0] / 6.37e6
    p[:, 1] += more[:, 1] / (6.37e6 * np.cos(p[:, 0]))
    p[:, 2] -= more[:, 2]
    return p


def value_of(found, effect, component):
    """(value, standard deviation, gain expected of a unit) of a parameter, named or not."""
    state = found.state
    if effect == "mounting":
        turned = vehicle.mounting(state.problem, vehicle.attitude_sd(state))
        if turned is None:
            return 0.0, None, None
        angle, sd = (float(v[2]) for v in turned)
        return angle, sd, 0.5 / sd**2
    if effect == "gnss_noise":
        return state.noise.position, None, float(state.use[:, :3].sum()) / 2.0
    k = columns.GROUPS[effect].index(columns.INDEX[effect, component])
    x, _, sd = (float(v[k]) for v in select.seen(state.reg, state.kept, effect))
    prior = columns.ALL[columns.INDEX[effect, component]].prior
    return x, sd, 0.5 * max(1.0 / sd**2 - 1.0 / prior**2, 0.0)


def asked(effects, found):
    """The effects to hide: of two sizes the larger where the smaller is not excited, else the
    smaller.
    """
    out = {}
    for effect, component, value, tolerance in effects:
        unit = value_of(found, effect, component)[2]
        before = out.get((effect, component))
        if before is None or not excited(before[2], unit):
            out[effect, component] = effect, component, value, tolerance
    return list(out.values())


def opposed(value, before, unit):
    """The value, or its opposite where beside what the drive has it would leave too little to be
    named.
    """
    return -value if excited(value, unit) and not excited(before + value, unit) else value


def excited(value, unit):
    """Whether a value promises enough to be named; unit: gain of a unit, nats."""
    return unit is not None and unit * value**2 >= PROMISED


def injected(drive, found, known):
    """Each hidden effect against what the same search, from the same model, finds without it, as
    rows that grow; known : rows that there are.
    """
    out, had = list(known), {(r["effect"], r["component"], r["value"]) for r in known}
    plain = searched(drive, model=found.model, judge=False, random=False)[1]
    for effect, component, value, tolerance in asked(HIDDEN, found):
        if effect == "gnss_noise" and drive.gnss_position_sd is None:
            continue  # nothing is stated that could be wrong
        before, _, unit = value_of(found if effect == "gnss_noise" else plain, effect, component)
        value = opposed(value, before, unit)
        if (effect, component, value) in had:
            continue
        other = hide(drive, effect, component, value)
        again = searched(other, model=found.model, judge=False, random=effect == "gnss_noise")[1]
        after, sd, _ = value_of(again, effect, component)
        named = effect in {s["effect"] for s in again.steps}
        row = {"put in": value, "found": after - before}
        if effect == "gnss_noise":  # the errors that were there, times the stated ones, and more
            row = {"put in": float(np.sqrt(before**2 + value**2 - 1.0)), "found": after}
            tolerance = 0.1 * row["put in"]
        limit = None if sd is None else abs(after) + 1.96 * sd
        row |= {
            "effect": effect, "component": component, "value": value, "named": bool(named),
            "again": bool(abs(row["found"] - row["put in"]) < max(tolerance, 0.1 * abs(value))),
            "excited": bool(excited(value, unit)), "before": before,
            "expected": None if unit is None else unit * value**2, "sd": sd, "limit": limit,
            "limit holds": None if limit is None else bool(limit >= abs(before + value)),
            "steps": [s["effect"] for s in again.steps], "unexplained": again.unexplained,
        }  # fmt: skip
        out.append(row)
        print(
            "  ",
            {
                k: round(v, 4) if isinstance(v, float) else v
                for k, v in row.items() if k != "unexplained"
            },
            flush=True,
        )  # fmt: skip
        yield out


def stored():
    return json.loads(RESULTS.read_text()) if RESULTS.exists() else {"drives": {}}


def store(name, result):
    """A drive's rows into the table as it is: two calls may fill it at a time."""
    table = stored()
    table["drives"][name] = result
    table |= {"command": "python benchmarks/drive_gap_real.py", "date": result["date"]}
    RESULTS.write_text(json.dumps(table, indent=1) + "\n", encoding="utf-8")


def main():
    folder = Path(os.environ["IMU_LIB_DATA"]) / "drive"
    plain, resume = "--plain" in sys.argv, "--resume" in sys.argv
    wanted = [a for a in sys.argv[1:] if not a.startswith("--")]
    for name in wanted or [p.stem for p in sorted(folder.glob("*.npz"))]:
        known = stored()["drives"].get(name, {})
        if known and not wanted:
            continue
        drive = Drive.load(folder / f"{name}.npz")
        result, found = searched(drive)
        c = axes.to_body(TURNED)
        turned = drive.with_(gyro=drive.gyro @ c, accel=drive.accel @ c)
        result["axes"] = {"put in": list(TURNED), "found": list(axes.of(turned)[0])}
        today = result["date"] = date.today().isoformat()
        kept = plain or (resume and known.get("date") == today)
        result["hidden"] = known.get("hidden", []) if kept else []
        store(name, result)
        for rows in () if plain else injected(drive, found, result["hidden"]):
            store(name, result | {"hidden": rows})
        print(name, round(result["seconds"], 1), "s", flush=True)


if __name__ == "__main__":
    main()
