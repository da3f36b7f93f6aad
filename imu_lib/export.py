"""Error models for other programs: Kalibr, ROS, gnss-ins-sim.

Those programs know one white noise and one bias process per sensor, so a sum of processes has to
be put into fewer words. The rule is the same everywhere and is written into each file: white noise
as it is; all slower processes together as the random walk (or the Gauss-Markov process) that has
their Allan variance over the times for which such a program trusts a bias; where one number stands
for three axes, that of the worst axis.
"""

import numpy as np
from scipy.optimize import least_squares

from imu_lib import units
from imu_lib.errors import InputError, UndefinedFormError
from imu_lib.model import Model
from imu_lib.processes import Sum

#: Averaging time at which the slow processes and their substitute agree, s.
HORIZON = 30.0
#: Averaging times over which a Gauss-Markov process is fitted to them, s.
SPAN = (1.0, 1000.0)
#: What counts as white at those times.
WHITE = ("white_noise", "quantization")
#: A process that forgets within this many seconds is white noise to such a program, s.
FORGOTTEN = 1.0


def fast(entry: Sum) -> Sum:
    """The random terms that are neither white nor slow: what a filter of the sensor leaves of its
    noise, a Gauss-Markov process of a few hundredths of a second. Their spectrum is flat below the
    frequencies at which a bias is followed.
    """
    return Sum(tuple(t for t in entry.noise.terms if t.name not in WHITE and _forgets(t)))


def _forgets(term) -> bool:
    """Whether a term's spectrum keeps more than half its low end up to 1 / (2 pi FORGOTTEN) Hz, as
    that of a Gauss-Markov process does whose correlation time is below FORGOTTEN.
    """
    try:
        low, edge = term.psd(np.array([1e-6, 1.0 / (2.0 * np.pi * FORGOTTEN)]))
    except UndefinedFormError:
        return False
    return bool(np.isfinite(low) and 0.5 * low < edge < 2.0 * low)


def slow(entry: Sum) -> Sum:
    """The random terms of a channel that are neither white nor fast, without stages."""
    quick = fast(entry).terms
    return Sum(tuple(t for t in entry.noise.terms if t.name not in WHITE and t not in quick))


def white(entry: Sum) -> float:
    """Density N of a channel where a bias is followed, unit/sqrt(Hz); 0 where it has none: that of
    the white terms and the low end of the fast ones (one-sided 2 N^2; 2 sigma^2 Tc for
    Gauss-Markov).
    """
    low = sum(float(t.psd(np.array([1e-6]))[0]) / 2.0 for t in fast(entry).terms)
    return float(np.sqrt(sum(t.N**2 for t in entry.terms if t.name == "white_noise") + low))


def equivalent_walk(entry: Sum, horizon: float = HORIZON) -> float:
    """K of the random walk with the slow terms' Allan variance at `horizon` s: K^2 = 3 avar / tau.

    A walk gives its own K; a Gauss-Markov process of long correlation time its driving noise,
    sigma sqrt(2 / Tc).
    """
    terms = slow(entry)
    return float(np.sqrt(3 * terms.avar(np.array([horizon]))[0] / horizon)) if terms.terms else 0.0


def equivalent_markov(entry: Sum) -> tuple[float, float]:
    """(sigma, correlation time) of the Gauss-Markov process whose Allan variance is closest to the
    slow terms'.

    Least squares of the logarithms over 1 to 1000 s; a Gauss-Markov process gives itself. (0,
    1000) for none.
    """
    from imu_lib.processes import GaussMarkov

    terms = slow(entry)
    if not terms.terms:
        return 0.0, SPAN[1]
    markov = [t for t in terms.terms if t.name == "gauss_markov"]
    if len(terms.terms) == len(markov) == 1:
        return markov[0].sigma, markov[0].correlation_time
    tau = np.geomspace(*SPAN, 31)
    goal = np.log(terms.avar(tau))

    def miss(theta):
        return np.log(GaussMarkov(*np.exp(theta)).avar(tau)) - goal

    starts = [[0.5 * goal.max(), np.log(t)] for t in (3.0, 30.0, 300.0, 3000.0)]
    best = min(
        (least_squares(miss, s, bounds=([-80, -3], [80, np.log(1e5)])) for s in starts),
        key=lambda r: r.cost,
    )
    sigma, time = np.exp(best.x)
    return float(sigma), float(time)


def _axes(model: Model, sensor: str):
    return [name for name in model.channel_names if name.startswith(sensor)]


def _worst(model, sensor, value):
    axes = _axes(model, sensor)
    return (
        (
            max(value(model[a]) for a in axes),
            ", ".join(f"{a[-1]} {value(model[a]):.4g}" for a in axes),
        )
        if axes
        else None
    )


def _source(model, mark="#"):
    rate = f"{model.rate:g} Hz" if model.rate else "rate not stated"
    return [
        f"{mark} written by imu_lib from the error model {model.name or '(unnamed)'} ({rate})",
        f"{mark} {model.source}" if model.source else f"{mark} source not stated",
        f"{mark} a bias random walk stands for all slow processes: it has their Allan variance at "
        f"{HORIZON:g} s",
    ]


def kalibr(model: Model) -> str:
    """Kalibr's imu.yaml: continuous-time densities, units of m/s^2/sqrt(Hz), m/s^3/sqrt(Hz),
    rad/s/sqrt(Hz), rad/s^2/sqrt(Hz).
    """
    lines = _source(model)
    rows = [
        ("accelerometer", "accel", "noise_density", white, "m/s^2/sqrt(Hz)"),
        ("accelerometer", "accel", "random_walk", equivalent_walk, "m/s^3/sqrt(Hz)"),
        ("gyroscope", "gyro", "noise_density", white, "rad/s/sqrt(Hz)"),
        ("gyroscope", "gyro", "random_walk", equivalent_walk, "rad/s^2/sqrt(Hz)"),
    ]
    for word, sensor, key, value, unit in rows:
        found = _worst(model, sensor, value)
        lines.append(
            f"{word}_{key}: {found[0]:.6e}  # {unit}, the worst axis of {found[1]}"
            if found
            else f"# {word}_{key}: the model has no {word}"
        )
        if found and found[0] == 0:
            lines.append(
                "# 0: the record shows none. Kalibr divides by it: put in a longer record's "
                f"value or the data sheet's for {word}_{key}"
            )
    lines += [
        "rostopic: /imu0",
        f"update_rate: {model.rate or 100.0:.6g}  # Hz"
        + ("" if model.rate else ", not stated by the model"),
    ]
    return "\n".join(lines) + "\n"


def ros(model: Model) -> str:
    """A ROS parameter file: covariances of sensor_msgs/Imu (what robot_localization weighs) and
    densities per axis.
    """
    rate = model.rate or 100.0
    lines = _source(model)
    lines += ["/**:", "  ros__parameters:", "    imu:", f"      rate: {rate:.6g}  # Hz"]
    for key, sensor, unit in (
        ("angular_velocity", "gyro", "rad/s"),
        ("linear_acceleration", "accel", "m/s^2"),
    ):
        axes = _axes(model, sensor)
        if not axes:
            lines.append(f"      # {key}: the model has no such channel")
            continue
        value = {a[-1]: model[a] for a in axes}
        variance = [_variance(value[a], rate) if a in value else 0.0 for a in "xyz"]
        rows = [f"{v:.6e}" for v in np.diag(variance).ravel()]
        walks = [f"{equivalent_walk(value[a]):.6e}" if a in value else "0.0" for a in "xyz"]
        lines += [
            f"      # per-sample variance, ({unit})^2: sensor_msgs/Imu {key}_covariance, "
            "row by row",
            f"      {key}_covariance: [{', '.join(rows)}]",
            f"      {key}_noise_density: "
            f"[{', '.join(f'{white(value[a]):.6e}' if a in value else '0.0' for a in 'xyz')}]"
            f"  # {unit}/sqrt(Hz)",
            f"      {key}_random_walk: [{', '.join(walks)}]  # {unit}/s/sqrt(Hz)",
        ]
    gyro = _worst(model, "gyro", lambda entry: np.sqrt(_variance(entry, rate)))
    if gyro:
        walk = _worst(model, "gyro", equivalent_walk)[0]
        lines += [
            "    # imu_tools, imu_filter_madgwick: sqrt(3/4) of the gyro's error, rad/s, and of "
            f"its drift over {HORIZON:g} s, rad/s^2",
            f"    gain: {np.sqrt(0.75) * gyro[0]:.6e}",
            f"    zeta: {np.sqrt(0.75) * walk / np.sqrt(HORIZON):.6e}",
        ]
    return "\n".join(lines) + "\n"


def _variance(entry, rate):
    """Variance of one sample about its bias: white and fast terms behind the filter, unit^2."""
    quick = fast(entry).terms
    sample = Sum(tuple(t for t in entry.terms if t.name in WHITE or t in quick), entry.stages)
    return float(sample.autocovariance(np.zeros(1), rate)[0]) if sample.terms else 0.0


def gnss_ins_sim(model: Model) -> str:
    """A Python file with the dictionary that gnss-ins-sim's `imu_model.IMU(accuracy=...)` takes,
    in its units.
    """
    missing = [
        c
        for c in ("gyro_x", "gyro_y", "gyro_z", "accel_x", "accel_y", "accel_z")
        if c not in model.channel_names
    ]
    lines = _source(model)[:2] + [
        "# one Gauss-Markov process stands for all slow processes: the closest Allan variance "
        f"from {SPAN[0]:g} to {SPAN[1]:g} s"
    ]
    lines += [f"# the model has no {', '.join(missing)}: zero here"] if missing else []
    lines += ["import numpy as np", "", "imu_err = {"]
    for sensor, keys in (
        (
            "gyro",
            (
                ("b", 1.0),
                ("arw", units.DEG_PER_SQRT_HOUR),
                ("b_stability", units.DEG_PER_HOUR),
                ("b_corr", 1.0),
            ),
        ),
        (
            "accel",
            (("b", 1.0), ("vrw", units.MPS_PER_SQRT_HOUR), ("b_stability", 1.0), ("b_corr", 1.0)),
        ),
    ):
        entries = [
            model[f"{sensor}_{a}"] if f"{sensor}_{a}" in model.channel_names else Sum()
            for a in "xyz"
        ]
        markov = [equivalent_markov(entry) for entry in entries]
        values = {
            "b": [0.0] * 3,
            "arw": [white(e) for e in entries],
            "vrw": [white(e) for e in entries],
            "b_stability": [sigma for sigma, _ in markov],
            "b_corr": [time for _, time in markov],
        }
        unit = {
            "gyro": {"b": "deg/h", "arw": "deg/sqrt(h)", "b_stability": "deg/h", "b_corr": "s"},
            "accel": {"b": "m/s^2", "vrw": "m/s/sqrt(h)", "b_stability": "m/s^2", "b_corr": "s"},
        }[sensor]
        for key, factor in keys:
            numbers = ", ".join(f"{v / factor:.6g}" for v in values[key])
            lines.append(f"    '{sensor}_{key}': np.array([{numbers}]),  # {unit[key]}")
    return "\n".join([*lines, "}"]) + "\n"


#: Name on the command line -> (file, writer).
FORMATS = {
    "kalibr": ("imu.yaml", kalibr),
    "ros": ("imu_ros.yaml", ros),
    "gnss-ins-sim": ("imu_gnss_ins_sim.py", gnss_ins_sim),
}


def text(model: Model, form: str) -> tuple[str, str]:
    """(file name, content) of a model in a format of `FORMATS`.

    Raises
    ------
    InputError
        For an unknown format.
    """
    if form not in FORMATS:
        raise InputError(f"unknown export {form!r}; there are {', '.join(FORMATS)}")
    name, writer = FORMATS[form]
    return name, writer(model)
