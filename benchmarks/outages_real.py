"""Outages on the recorded drives: the paper's models, a joint fit of a standstill, and a model fitted in motion on another drive.

    IMU_LIB_DATA=... python benchmarks/outages_real.py

Windows of 30 s every 30 s and of 60 s every 60 s. The five models and "likelihood" come from a static record of the maker's other
module (HiPNUC CH104), for want of one of the same units; "in motion" is fitted to the outages of a drive of the other day (`tuning`), so
that no drive judges its own fit; the same "+ road" with the vehicle constraint, which is knowledge about cars, not about sensors.
span_a and span_b are two modules on one drive: not independent of each other.
"""
import json
import os
import time
from pathlib import Path

import numpy as np

from imu_lib.characterise import characterise
from imu_lib.drive import Drive
from imu_lib.navigation import earth, models, outages, preparation, statistics, tuning
from imu_lib.navigation.filter import FilterModel
from imu_lib.readers import read_record

RESULT = Path(__file__).parent / "results" / "outages_real.json"
TURN_ON = (3.5e-3, 0.2)                      # 0.2 deg/s, 20 mg
TRAINED_ON = {"span_a": "span_c", "span_b": "span_c", "span_c": "span_a", "kth_car": "span_a"}


def gnss_of(name):
    """Only the single-point receiver's fixes of span_c: its other receiver's velocities contradict their own positions."""
    return preparation.Gnss(accept=(1,) if name == "span_c" else None, velocity_floor=0.15)


def full_rms(drive, solution):
    if not drive.has_reference:
        return None
    truth = np.column_stack([np.interp(solution.time, drive.reference_time, c) for c in np.asarray(drive.reference_position).T])
    return float(np.sqrt(np.mean(earth.horizontal(solution.position, truth) ** 2)))


def fix_rms(drive):
    if not drive.has_reference:
        return None
    truth = np.column_stack([np.interp(drive.gnss_time, drive.reference_time, c) for c in np.asarray(drive.reference_position).T])
    return float(np.sqrt(np.mean(earth.horizontal(drive.gnss_position, truth) ** 2)))


def main():
    data = Path(os.environ["IMU_LIB_DATA"])
    drives = {n: Drive.load(data / "drive" / f"{n}.npz") for n in TRAINED_ON}
    static = read_record(data / "static" / "hipnuc_ch104.npz")
    fitted = characterise(static, workers=2).model
    tuned = {}
    for n in sorted(set(TRAINED_ON.values())):
        windows = outages.regular_windows(drives[n], duration=30.0, every=30.0, settle=60.0)
        tuned[n] = tuning.fit_in_motion([(drives[n], windows, gnss_of(n))], turn_on_sd=TURN_ON, evaluations=45)
        print("in motion, from", n, dict(zip(tuning.PARAMETERS, tuned[n].parameters.tolist())))
    content = {"command": "python benchmarks/outages_real.py", "date": time.strftime("%Y-%m-%d"),
               "in_motion": {n: dict(zip(tuning.PARAMETERS, t.parameters.tolist())) for n, t in tuned.items()}, "drives": {}}
    pooled = {}
    for name, drive in drives.items():
        base = models.read_off(static, drive.rate)
        entries = models.five(base, static=static, rate=drive.rate, turn_on_sd=TURN_ON)
        entries["18AVWD causal"] = entries["18AVWD"].with_(name="18AVWD causal", causal=True)
        entries["likelihood"] = FilterModel("likelihood", fitted, flicker="markov", turn_on_sd=TURN_ON)
        entries["in motion"] = tuned[TRAINED_ON[name]].model
        entries["in motion + road"] = entries["in motion"].with_(name="in motion + road", constraint_sd=0.3)
        found = {"fix_rms": fix_rms(drive)}
        for duration in (30.0, 60.0):
            windows = outages.regular_windows(drive, duration=duration, every=duration, settle=60.0)
            study = outages.compare(drive, entries, windows, gnss=gnss_of(name), strict=False)
            against = study.against[-1]
            errors = {n: study.errors(n, against=against) for n in entries}
            found["full_rms"] = {n: full_rms(drive, m.solution) for n, m in study.models.items()}
            found[f"{duration:g} s"] = {
                "outages": len(study.windows), "against": against,
                "models": {n: {"median": statistics.median_interval(e), "mean": float(e.mean()), "worst": float(e.max()),
                               "predicted": float(np.median([s[-1] for s in study.models[n].sigma]))} for n, e in errors.items()},
                "paired": [p.to_json() for p in study.paired(against=against)]}
            found["notes"] = list(study.notes)
            for n, e in errors.items():
                pooled.setdefault(duration, {}).setdefault(n, []).append(e)
            print(name, f"{duration:g} s", len(study.windows), {n: round(float(np.median(e)), 1) for n, e in errors.items()})
        content["drives"][name] = found
    for duration, by in pooled.items():
        joined = {n: np.concatenate(e) for n, e in by.items()}
        order = sorted(joined, key=lambda n: np.log(joined[n]).mean())
        content.setdefault("pooled", {})[f"{duration:g} s"] = {
            "outages": int(joined[order[0]].size), "median": {n: float(np.median(joined[n])) for n in order},
            "paired": [statistics.paired(joined[a], joined[b], (a, b)).to_json() for i, a in enumerate(order) for b in order[i + 1:]]}
    RESULT.parent.mkdir(exist_ok=True)
    RESULT.write_text(json.dumps(content, indent=1) + "\n")


if __name__ == "__main__":
    main()
