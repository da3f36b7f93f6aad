"""What a column or array is called, and the unit its name states.

`gyro_x [deg/s]`, `w_RS_S_x [rad s^-1]`, `accel_z_mps2`, `field.linear_acceleration.y`, `#timestamp
[ns]` and their
likes become a canonical name (`gyro_x`, `accel_z`, `time`, ...) and a unit.
"""

from __future__ import annotations

import re

from imu_lib import units
from imu_lib.errors import InputError

GYRO_UNITS = {"rad/s": 1.0, "deg/s": units.DEG_PER_S, "deg/h": units.DEG_PER_HOUR}
ACCEL_UNITS = {"m/s^2": 1.0, "g": units.G, "mg": units.MILLI_G}
TIME_UNITS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0, "h": 3600.0}
UNITS = {
    "gyro": GYRO_UNITS,
    "accel": ACCEL_UNITS,
    "time": TIME_UNITS,
    "dtheta": {"rad": 1.0, "deg": units.DEG},
    "dv": {"m/s": 1.0},
    "temperature": {"degC": 1.0},
}
COUNTS = ("counts", "count", "lsb", "raw", "adc")

_SPELLED = {
    "rad/s": "rad/s rad/sec rads radps rad*s^-1 rads^-1 rads-1 r/s rad_s",
    "deg/s": "deg/s deg/sec dps degps degs^-1 degs-1 degrees/s d/s deg_s",
    "deg/h": "deg/h deg/hr deg/hour dph deg_h",
    "m/s^2": "m/s^2 m/s2 m/s/s mps2 mps^2 ms^-2 ms-2 m/sec^2 m/s**2 ms2 m*s^-2 m_s2",
    "g": "g g0 gn",
    "mg": "mg milli-g millig",
    "s": "s sec secs second seconds",
    "ms": "ms msec",
    "us": "us usec",
    "ns": "ns nsec",
    "min": "min",
    "h": "h",
    "rad": "rad",
    "deg": "deg",
    "m/s": "m/s mps",
    "degC": "degc c celsius",
    "counts": " ".join(COUNTS),
}
_SPELLINGS = {
    spelling: unit for unit, spellings in _SPELLED.items() for spelling in spellings.split()
}

_SIGNAL = [
    ("dtheta", r"(?:d(?:elta)?_?theta|d(?:elta)?_?ang(?:le)?|dtheta|dang|da|dt(?=[_ .]?[xyz]$))"),
    ("dv", r"(?:d(?:elta)?_?v(?:el(?:ocity)?)?)"),
    (
        "gyro",
        r"(?:gyros?|gyr|gyroscopes?|g|w|wib_?b?|omega|rate|ang(?:ular)?_?(?:vel(?:ocity)?|rate)|w_rs_s|angvel|gyroreading)",
    ),
    (
        "accel",
        r"(?:accels?|acc|a|f|fib_?b?|accelerometers?|accelerations?|accl"
        r"|lin(?:ear)?_?acc(?:el(?:eration)?)?|spec(?:ific)?_?force|a_rs_s|accreading)",
    ),
]
_PREFIX = (
    r"(?:(?:imu|raw|meas|body|sensor|field|data|msg|calibrated|cal|uncalibrated|s)_?\d*[_. ])*"
)
_AXES = {"x": "x", "y": "y", "z": "z", "1": "x", "2": "y", "3": "z"}
_TIME = re.compile(
    r"^" + _PREFIX + r"(?:time|times|timestamps?|time_?stamp|t|stamp|tow|sow"
    r"|rostime|epoch|gps_?time|(?:header_)?stamp_(?:secs?|nsecs?)|elapsed|elapsed_time"
    r"|host_?time|utc_?time|unix_?time|system_?time|seconds?|secs?|datetime|date_?time)$"
)
_TEMPERATURE = re.compile(r"^" + _PREFIX + r"(?:(?:imu|chip|gyro|sensor|die)_?)?temp(?:erature)?$")
_TRAILING = re.compile(
    r"^(.*?)[_ .](rad_s|rads|radps|rad_per_s|dps|deg_s|degps|deg_per_s|deg_h|dph"
    r"|mps2|m_s2|ms2|m_per_s2|g|mg|counts?|lsb|raw|s|sec|ms|us|ns|degc|c)$"
)


def unit_of(text: str) -> str | None:
    """The canonical unit a text spells, or None."""
    plain = (
        text.strip()
        .strip("[]()")
        .replace("°", "deg")
        .replace("º", "deg")
        .replace("²", "^2")
        .replace("µ", "u")
        .replace("μ", "u")
        .replace("·", "*")
    )
    plain = plain.replace("_per_", "/").replace(" per ", "/")
    if plain in ("G", "g"):
        return "g"
    plain = re.sub(r"\s+", "", plain.lower())
    return _SPELLINGS.get(plain)


def parse(name: str, *, signal: str | None = None) -> tuple[str | None, str | None]:
    """Canonical name and unit of a column called `name`; (None, None) where the name says nothing.

    Canonical: time, date, clock, temperature, index, gyro_x.., accel_x.., dtheta_x.., dv_x.., and
    gyro / accel for an array
    of three axes. `signal` ("gyro" or "accel") is what a bare x, y, z or 1, 2, 3 stands for. The
    unit is as spelled where it is
    not known, so that it can be refused by name.
    """
    text = str(name).strip("\ufeff \t").lstrip("#%").strip().strip("\"'").strip()
    unit = None
    bracket = re.match(r"^(.*?)[\s_]*[\[(]([^\])]*)[\])]\s*$", text)
    if bracket and bracket[1].strip():
        spelled = bracket[2].strip()
        text = bracket[1].strip()
        if spelled and spelled.lower() not in "xyz-":
            unit = unit_of(spelled) or spelled
    key = re.sub(r"[\s\-]+", "_", text.lower()).strip("_")
    key = re.sub(r"[\[(]([xyz0-9])[\])]$", r"_\1", key)
    found = _canonical(key, signal)
    if found is None and unit is None:
        trailing = _TRAILING.match(key)
        if trailing:
            found = _canonical(trailing[1], signal)
            unit = (
                unit_of(trailing[2].replace("_per_", "/").replace("m/s2", "m/s^2"))
                if found
                else None
            )
    if found == "time" and unit is None and re.search(r"(?:sec(?:ond)?s?|tow|sow)$", key):
        unit = "ns" if "nsec" in key else "s"
    return found, (unit if found else None)


def _canonical(key: str, signal: str | None) -> str | None:
    if key in ("date", "day") or key == "clock":
        return "date" if key != "clock" else "clock"
    if _TIME.match(key):
        return "time"
    if _TEMPERATURE.match(key):
        return "temperature"
    if key in (
        "index",
        "n_samples",
        "sample",
        "samples",
        "counter",
        "count",
        "frame",
        "seq",
        "n",
        "i",
        "id",
        "packet",
        "packetcounter",
        "sample_number",
    ):
        return "index"
    if signal and key in _AXES:
        return f"{signal}_{_AXES[key]}"
    for canonical, pattern in _SIGNAL:
        match = re.match(
            rf"^{_PREFIX}{pattern}[_. ]?(?:data_?)?(?:([xyz])(?:_?axis)?|[_.]?([123]))$", key
        )
        if match:
            return f"{canonical}_{_AXES[match[1] or match[2]]}"
        match = re.match(rf"^([xyz])[_. ](?:axis_)?{pattern}(?:_out|_data)?$", key)
        if match and len(key) > 3:
            return f"{canonical}_{match[1]}"
        if re.match(rf"^{_PREFIX}{pattern}(?:_?data)?$", key) and len(key) > 1:
            return canonical
    return None


def stated(flag: str, kind: str) -> tuple[float, float, str]:
    """What `--gyro-unit` / `--accel-unit` states: factor to SI, zero (subtracted before), unit.
    InputError where it is no unit.

    `counts:C` is C counts per deg/s (gyro) or per g (accelerometer); `counts:C:ZERO` has its zero
    at ZERO counts.
    """
    known = UNITS[kind]
    option = f"--{kind}-unit"
    counts = re.match(r"^counts(?::([^:]*))?(?::([^:]*))?$", flag.strip(), re.IGNORECASE)
    if counts:
        per = "deg/s" if kind == "gyro" else "g"
        try:
            scale, zero = float(counts[1]), float(counts[2] or 0.0)
        except (TypeError, ValueError):
            scale, zero = 0.0, 0.0
        if not 0 < scale < float("inf"):
            raise InputError(
                f"{option} {flag} must give the counts per {per}, as in counts:{131 if kind == 'gyro' else 16384}."
            )
        return (units.DEG_PER_S if kind == "gyro" else units.G) / scale, zero, flag
    unit = unit_of(flag)
    if unit not in known:
        raise InputError(f"{option} {flag!r} is not known; give {', '.join(known)} or counts:C.")
    return known[unit], 0.0, unit
