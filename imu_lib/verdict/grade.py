"""Which grade of sensor a record shows, by its white noise.

The trade names grades by bias and noise; boundaries differ by a factor of a few from one author to
the next (Groves 2013, chapter 4, tabulates typical values). White noise is what every record at
rest shows, so it decides here, and the worst axis decides for three.
"""

from __future__ import annotations

from imu_lib import report, units
from imu_lib.verdict.datasheet import bias_instability

#: Upper end of N for each grade, in the datasheet unit: deg/sqrt(h) and m/s/sqrt(h).
GRADES = {
    "gyro": ((0.005, "navigation grade"), (0.15, "tactical grade")),
    "accel": ((0.003, "navigation grade"), (0.03, "tactical grade")),
}
LOWEST = "low-cost MEMS (consumer, automotive or industrial)"
UNLIKELY = 1e-6  # p-value below which a fitted N is no description
WORDS = {"gyro": "Gyros", "accel": "Accelerometers"}


def grades(result, health) -> list[str]:
    """A sentence on each sensor of a `Characterisation`; `health` gives the noise of an axis of
    which the fit shows none.
    """
    out = []
    for sensor, bounds in GRADES.items():
        noise, rough = {}, []
        for name, channel in result.channels.items():
            if name.startswith(sensor):
                fitted = channel.likelihood.get("N")
                if fitted is not None and fitted.shown and channel.choice.p_value > UNLIKELY:
                    noise[name] = fitted.value
                else:
                    noise[name] = max(
                        float(health.channels[name].noise),
                        fitted.value if fitted is not None and fitted.shown else 0.0,
                    )
                    rough.append(name)
        if not noise:
            continue
        worst = max(noise, key=noise.get)
        factor, unit = units.datasheet("N", worst)
        value = noise[worst] / factor
        grade = next((name for bound, name in bounds if value < bound), LOWEST)
        axis = f"axis {worst[-1]}" if len(noise) == 1 else f"the worst axis ({worst[-1]})"
        if worst in rough:
            how = (
                f"some {report.number(value, 2)} {unit} from one sample to the next on {axis}, "
                "where no sum of noises fits"
            )
        else:
            how = f"{report.number(value, 3)} {unit} on {axis}"
        out.append(f"{WORDS[sensor]}: {grade} by their white noise, {how}{_drift(result, sensor)}.")
    return out


def _drift(result, sensor) -> str:
    """The worst bias instability, or the best limit that the record gives."""
    of_sensor = [
        (bias_instability(c), n) for n, c in result.channels.items() if n.startswith(sensor)
    ]
    found = [(e, name) for e, name in of_sensor if e is not None]
    shown = [(e.value, name) for e, name in found if e.shown]
    if shown:
        value, name = max(shown)
        factor, unit = units.datasheet("B", name)
        axis = "" if len(found) == 1 else f" on {name[-1]}, the highest that shows"
        return f"; bias instability {report.number(value / factor, 3)} {unit}{axis}"
    if found:
        high, name = max((e.high, name) for e, name in found)
        factor, unit = units.datasheet("B", name)
        return f"; bias instability not shown, at most {report.number(high / factor, 3)} {unit}"
    return ""
