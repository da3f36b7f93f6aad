"""Drives in which effects are hidden, for `drive_gap_score.py`: what is drawn, how it is searched,
and what the true effect would gain. The generator (tests/drive_generator.py) shares no code with
the navigation package.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "tests")]

import drive_generator as generator  # noqa: E402
import numpy as np  # noqa: E402

from imu_lib.drive import from_arrays  # noqa: E402
from imu_lib.drive_effects import DriveEffect  # noqa: E402
from imu_lib.errors import InputError  # noqa: E402
from imu_lib.gap import drive as gap_drive  # noqa: E402
from imu_lib.gap.drive import columns, correct, outage, path, problem  # noqa: E402
from imu_lib.model import Model  # noqa: E402
from imu_lib.navigation import outages  # noqa: E402
from imu_lib.navigation.filter_model import FilterModel  # noqa: E402

MODEL = Model.from_json(generator.MODEL)
UNKNOWN = (
    "velocity_low_pass", "second_half_offset", "temperature_bias", "pothole", "velocity_correlated",
)  # fmt: skip
PERMUTATIONS = (("+y", "-x", "+z"), ("-x", "-y", "+z"), ("+y", "+x", "-z"), ("-y", "+x", "+z"))


def spread(rng, low, high, size=None):
    """Of either sign, its size uniform in the logarithm."""
    sign = rng.choice([-1.0, 1.0], size)
    value = sign * np.exp(rng.uniform(np.log(low), np.log(high), size))
    return float(value) if size is None else [float(v) for v in value]


def draw(kind, rng):
    """Parameters of an effect."""
    if kind == "gnss_time_offset":
        offset = spread(rng, 0.03, 0.8)
        return {"offset": offset} if rng.random() < 0.7 else {
            "offset": offset, "velocity_offset": offset + spread(rng, 0.05, 0.3),
        }  # fmt: skip
    if kind == "mounting":
        return {"roll": 0.0, "pitch": spread(rng, 0.02, 0.06), "yaw": spread(rng, 0.05, 0.2)}
    if kind == "axes":
        return {"permutation": PERMUTATIONS[rng.integers(len(PERMUTATIONS))]}
    table = {
        "lever_arm": ("arm", 0.3, 2.0, 3), "accel_scale": ("scale", 3e-3, 0.04, 3),
        "gyro_scale": ("scale", 3e-3, 0.04, 3), "accel_misalignment": ("matrix", 3e-3, 0.04, 6),
        "gyro_misalignment": ("matrix", 3e-3, 0.04, 6), "accel_bias": ("bias", 0.4, 0.9, 3),
        "gyro_g_sensitivity": ("matrix", 5e-5, 8e-4, 9), "gyro_bias": ("bias", 0.015, 0.04, 3),
    }  # fmt: skip
    if kind in table:
        key, low, high, size = table[kind]
        return {key: spread(rng, low, high, size)}
    if kind == "heading":
        return {"error": spread(rng, 0.4, 2.5)}
    if kind == "imu_clock":
        return {"scale": spread(rng, 3e-5, 8e-4)}
    if kind == "gnss_noise":
        of = rng.choice(["position", "velocity"])
        return {"ratio": float(rng.choice([0.4, 0.6, 1.6, 2.5, 4.0])), "of": str(of)}
    if kind == "gnss_correlated":
        return {
            "sigma": float(rng.uniform(0.8, 3.0)),
            "correlation_time": float(rng.uniform(8, 90)),
        }
    if kind == "gnss_outliers":
        return {"fraction": float(rng.uniform(0.01, 0.06)), "scale": float(rng.uniform(8, 40))}
    if kind == "bias_model":
        channel = str(rng.choice(list(columns.CHANNEL_NAMES)))
        process, name = [("white_noise", "N"), ("gauss_markov", "sigma")][rng.integers(2)]
        entry = next(p for p in generator.MODEL[channel] if p["process"] == process)
        factor = float(rng.uniform(5.0, 15.0))
        return {
            "channel": channel, "process": process, "name": name, "from": entry[name],
            "to": factor * entry[name],
        }  # fmt: skip
    if kind == "vibration":
        channel = str(rng.choice(list(columns.CHANNEL_NAMES)))
        n = generator.MODEL[channel][0]["N"]
        return {"channel": channel, "N": n, "N_per_speed": n * float(rng.uniform(1.0, 4.0))}
    raise ValueError(kind)


KNOWN = (
    "gnss_time_offset", "mounting", "axes", "lever_arm", "accel_scale", "gyro_scale",
    "accel_misalignment", "gyro_misalignment", "gyro_g_sensitivity", "accel_bias", "gyro_bias",
    "imu_clock", "gnss_noise", "gnss_correlated", "gnss_outliers", "bias_model", "vibration",
    "heading",
)  # fmt: skip
KINDS = (*KNOWN, "pair", "none", *UNKNOWN)


def case(kind, seed, judged=False, given=True):
    """One drive made and searched, with the model of its sensors or without: a row of the log."""
    rng = np.random.default_rng([seed, 17])
    if kind == "pair":
        out = ("axes", "mounting", "heading", *(() if given else ("bias_model",)))
        pool = [k for k in KNOWN if k not in out]
        effects = [(k, draw(k, rng)) for k in rng.choice(pool, 2, replace=False)]
    else:
        effects = [(kind, draw(kind, rng))] if kind in KNOWN else []
    options = {
        "kind": str(rng.choice(["town", "town", "motorway"])),
        "gnss_rate": float(rng.choice([1.0, 5.0, 5.0])),
        "velocity": bool(rng.random() < 0.8),
        "duration": float(rng.choice([300.0, 420.0])),
        "moving_start": bool(rng.random() < 0.2),
    }
    if kind.startswith("velocity_") or any("velocity_offset" in p for _, p in effects):
        options["velocity"] = True
    if any(p.get("of") == "velocity" for _, p in effects):
        options["velocity"] = True
    options |= strange(seed)
    beside = [("mounting", draw("mounting", rng))] if options.pop("turned", False) else []
    if kind in ("mounting", "axes") or any(k == "heading" for k, _ in effects):
        beside = []
    unknown = [kind] if kind in UNKNOWN else []
    arrays = generator.make(seed, effects=[*effects, *beside], unknown=unknown, **options)
    drive = from_arrays(arrays, f"{kind} {seed}")
    heading = None
    if kind == "heading":
        heading = float(arrays["reference_attitude"][0, 2])
    begin = time.process_time()
    model = MODEL if given else None
    found = gap_drive.close(drive, model, judge=False, heading=heading)
    seconds = time.process_time() - begin
    return {
        "kind": kind, "seed": seed, "given": given, "effects": effects, "beside": beside,
        **{f"option {k}": v for k, v in options.items()},
        "gain": gain(drive, effects) if len(effects) == 1 else None,
        "steps": [
            {k: s[k] for k in ("effect", "parameters", "intervals", "weight", "confidence", "log_likelihood_gain")}
            for s in found.steps
        ],
        "unseen": [[e["effect"], e["parameter"]] for e in found.invisible],
        "indistinguishable": [s["indistinguishable"] for s in found.steps],
        "nis": found.after.nis, "index": found.after.index, "unexplained": found.unexplained, "right": found.right, "notes": list(found.notes),
        "outages": in_outages(drive, [*effects, *beside], found.model) if judged and effects else None,
        "seconds": seconds,
    }  # fmt: skip


def strange(seed):
    """Options of a drive that the others do not have: {} for one drive of three."""
    rng = np.random.default_rng([seed, 23])
    if rng.random() < 1 / 3:
        return {}
    out = {"slip": float(rng.choice([0.0, 0.004])), "rough": float(rng.choice([0.0, 0.003, 0.01]))}
    if rng.random() < 0.4:
        out["kind"] = str(rng.choice(["bus", "tractor", "motorcycle"]))
    if rng.random() < 0.2:
        out |= {"gnss_rate": 10.0, "position_sd": (0.02, 0.02, 0.04), "velocity_sd": (0.03,) * 3}
    if rng.random() < 0.2:
        out["rate"] = 200.0
    if rng.random() < 0.2:
        out["imu_gap"] = float(rng.uniform(0.5, 8.0))
    if rng.random() < 0.2:
        out["tunnels"] = int(rng.integers(1, 3))
    if rng.random() < 0.3:
        out["held_sd"] = 1.6
    if rng.random() < 0.2:
        out["turned"] = True
    if rng.random() < 0.1:
        out["duration"] = 1200.0
    return out


def in_outages(drive, effects, model):
    """Median of the largest errors in withheld outages, m: under the model found, under the true
    one, and without either.
    """
    entries = [DriveEffect(name, p) for name, p in effects if name != "bias_model"]
    true = path_model(effects).with_drive(tuple(entries))
    models = {"before": MODEL, "after": model, "true": true}
    filters = {n: FilterModel.of(problem.with_constants(m)) for n, m in models.items()}
    try:
        study = outages.compare(
            drive, filters, outage.withheld(drive), gnss=outage.GNSS, strict=False
        )
    except InputError:
        return None
    return {n: float(np.median(study.errors(n, against="reference"))) for n in models}


def path_model(effects):
    """The generator's model with what `bias_model` changed."""
    made = {
        k: [dict(e) for e in v] if isinstance(v, list) else v for k, v in generator.MODEL.items()
    }
    for name, p in effects:
        for e in made[p["channel"]] if name == "bias_model" else ():
            if e["process"] == p["process"]:
                e[p["name"]] = p["to"]
    return Model.from_json(made)


def gain(drive, effects):
    """Log-likelihood of the innovations gained by the true effect at its true parameters; None
    where it is no matter of the innovations.
    """
    ((name, p),) = effects
    if name in ("axes", "mounting", "heading"):
        return None
    theta, noise = np.zeros(len(columns.ALL)), problem.Noise(MODEL)
    part = columns.of(name)
    true = noise
    if name == "gnss_time_offset":
        theta[part] = p["offset"], p.get("velocity_offset", p["offset"])
    elif part:
        theta[part] = np.ravel(next(iter(p.values())))
    elif name == "gnss_noise":
        true = noise.with_(**{p["of"]: p["ratio"]})
    elif name == "gnss_correlated":
        true = noise.with_(sigma=p["sigma"], tau=p["correlation_time"])
    elif name == "gnss_outliers":
        true = noise.with_(fraction=p["fraction"], scale=p["scale"])
    elif name == "vibration":
        k = columns.CHANNEL_NAMES.index(p["channel"])
        true = noise.with_(per_speed=tuple(p["N_per_speed"] if i == k else 0.0 for i in range(6)))
    elif name == "bias_model":
        true = problem.Noise(path_model(effects))
    with_it = path.build(
        correct.corrected(drive, theta), true, velocity_shift=correct.velocity_shift(theta)
    ).evaluate(true)
    return float(with_it.log_likelihood - path.build(drive, noise).evaluate(noise).log_likelihood)
