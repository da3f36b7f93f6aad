"""Which grade of sensor a record shows, by its white noise.

The trade names grades by bias and noise; boundaries differ by a factor of a few from one author to
the next (Groves 2013, chapter 4, tabulates typical values). White noise is what every record at
rest shows, so it decides here, and the worst axis decides for three.
"""

from __future__ import annotations

from imu_lib import report, units

#: Upper end of N for each grade, in the datasheet unit: deg/sqrt(h) and m/s/sqrt(h).
GRADES = {
    "gyro": ((0.005, "navigation grade"), (0.15, "tactical grade")),
    "accel": ((0.003, "navigation grade"), (0.03, "tactical grade")),
}
LOWEST = "low-cost MEMS (consumer, automotive or industrial)"
WORDS = {"gyro": "Gyros", "accel": "Accelerometers"}


def grades(result) -> list[str]:
    """A sentence on each sensor of a `Characterisation`."""
    out = []
    for sensor, bounds in GRADES.items():
        noise = {
            name: c.likelihood["N"]
            for name, c in result.channels.items()
            if name.startswith(sensor) and "N" in c.likelihood and c.likelihood["N"].shown
        }
        if not noise:
            continue
        worst = max(noise, key=lambda name: noise[name].value)
        factor, unit = units.datasheet("N", worst)
        value = noise[worst].value / factor
        grade = next((name for bound, name in bounds if value < bound), LOWEST)
        drift = _drift(result, sensor)
        out.append(
            f"{WORDS[sensor]}: {grade} by their white noise, {report.number(value, 3)} {unit} on "
            f"the worst axis ({worst[-1]}){drift}."
        )
    return out


def _drift(result, sensor) -> str:
    """The worst bias instability, or the best limit that the record gives."""
    found = [
        (c.allan["B"], name)
        for name, c in result.channels.items()
        if name.startswith(sensor) and "B" in c.allan
    ]
    shown = [(e.value, name) for e, name in found if e.shown]
    if shown:
        value, name = max(shown)
        factor, unit = units.datasheet("B", name)
        return f"; bias instability up to {report.number(value / factor, 3)} {unit}"
    if found:
        high, name = max((e.high, name) for e, name in found)
        factor, unit = units.datasheet("B", name)
        return f"; bias instability not shown, at most {report.number(high / factor, 3)} {unit}"
    return ""
