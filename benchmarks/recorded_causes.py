"""Why the Allan models of a standstill do badly in a moving car: one part replaced at a time.

    IMU_LIB_DATA=... python benchmarks/recorded_causes.py

The 18-state Allan model of `recorded_outages` on the same drives and windows, first with the white
noise N of the gyros or of the accelerometers ten times as large, then with the slow terms of the
gyros or of the accelerometers taken from 15AR. What makes the errors small is what the standstill
got wrong for a car. Stored beside: the driving density of the slow terms of both models, which says
how fast a filter lets a bias move.
"""

import json
import os
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from imu_lib.drive import Drive
from imu_lib.navigation import models, outages, preparation, statistics
from imu_lib.processes import Autoregressive, GaussMarkov, RandomWalk, Sum, WhiteNoise
from imu_lib.readers import read_record

RESULT = Path(__file__).parent / "results" / "recorded_causes.json"
TURN_ON = (3.5e-3, 0.2)
FACTOR = 10.0
SENSORS = {"gyros": ("gyro",), "accelerometers": ("accel",)}


def louder(model, sensors):
    """The model with N of these sensors multiplied by FACTOR."""
    channels = {}
    for channel in model.channel_names:
        terms = [
            replace(t, N=FACTOR * t.N)
            if isinstance(t, WhiteNoise) and channel.startswith(sensors)
            else t
            for t in model[channel].terms
        ]
        channels[channel] = Sum(tuple(terms))
    return model.with_channels(channels)


def mixed(model, other, sensors):
    """The model with the channels of these sensors taken from `other`."""
    return model.with_channels(
        {c: other[c] if c.startswith(sensors) else model[c] for c in model.channel_names}
    )


def driving(channel):
    """Density that drives the slow terms of a channel, the square of an equivalent K."""
    total = 0.0
    for term in channel.terms:
        if isinstance(term, GaussMarkov):
            total += 2.0 * term.sigma**2 / term.correlation_time
        elif isinstance(term, RandomWalk):
            total += term.K**2
        elif isinstance(term, Autoregressive):
            total += term.sigma**2 * term.rate
    return total


def main():
    data = Path(os.environ["IMU_LIB_DATA"])
    static = read_record(data / "static" / "hipnuc_ch104.npz")
    five = models.five(models.read_off(static, 100.0), static=static, turn_on_sd=TURN_ON)
    base = five["18AV"]
    entries = {"18AV": base, "15AR": five["15AR"]}
    for label, sensors in SENSORS.items():
        parts = {
            f"N of the {label} times {FACTOR:g}": louder(base.model, sensors),
            f"slow terms of the {label} from 15AR": mixed(base.model, five["15AR"].model, sensors),
        }
        entries |= {n: base.with_(name=n, model=part) for n, part in parts.items()}
    content = {
        "command": "python benchmarks/recorded_causes.py",
        "date": time.strftime("%Y-%m-%d"),
        "driving density, 15AR over 18AV": {
            c: driving(five["15AR"].model[c]) / driving(base.model[c])
            for c in base.model.channel_names
        },
        "drives": {},
    }
    pooled, labels = {n: [] for n in entries}, []
    for name in ("span_a", "span_b", "span_c", "kth_car"):
        drive = Drive.load(data / "drive" / f"{name}.npz")
        gnss = preparation.Gnss(
            accept=(1,) if name == "span_c" else None, velocity_floor=0.15, position_floor=0.5
        )
        windows = outages.regular_windows(drive, duration=30.0, every=30.0, settle=60.0)
        study = outages.compare(drive, entries, windows, gnss=gnss, strict=False)
        errors = {n: study.errors(n, against=study.against[-1]) for n in entries}
        content["drives"][name] = {
            "outages": len(study.windows),
            "models": {n: {"median": statistics.median_interval(e)} for n, e in errors.items()},
        }
        for n, e in errors.items():
            pooled[n].append(e)
        labels += [name] * len(study.windows)
        print(name, {n: round(float(np.median(e)), 1) for n, e in errors.items()}, flush=True)
    joined = {n: np.concatenate(e) for n, e in pooled.items()}
    content["paired"] = [
        statistics.paired(joined[n], joined["18AV"], (n, "18AV")).to_json()
        for n in entries
        if n != "18AV"
    ]
    RESULT.write_text(json.dumps(content, indent=1) + "\n")


if __name__ == "__main__":
    main()
