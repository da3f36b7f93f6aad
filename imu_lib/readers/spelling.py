"""Units as people spell them, and what each is in SI."""

from __future__ import annotations

import re
import unicodedata

from imu_lib import units
from imu_lib.errors import InputError

FOOT = 0.3048  # m
GYRO_UNITS = {
    "rad/s": 1.0,
    "deg/s": units.DEG_PER_S,
    "deg/h": units.DEG_PER_HOUR,
    "mdps": 1e-3 * units.DEG_PER_S,
    "cdps": 1e-2 * units.DEG_PER_S,
    "mrad/s": 1e-3,
    "deg/min": units.DEG_PER_S / 60.0,
    "rpm": 6.0 * units.DEG_PER_S,
    "rev/s": 360.0 * units.DEG_PER_S,
    "arcsec/s": units.DEG_PER_S / 3600.0,
    "urad/s": 1e-6,
}
ACCEL_UNITS = {
    "m/s^2": 1.0,
    "g": units.G,
    "mg": units.MILLI_G,
    "ug": 1e-3 * units.MILLI_G,
    "cm/s^2": 1e-2,
    "mm/s^2": 1e-3,
    "mGal": 1e-5,
    "ft/s^2": FOOT,
}
TIME_UNITS = {
    "s": 1.0,
    "cs": 1e-2,
    "ms": 1e-3,
    "us": 1e-6,
    "ns": 1e-9,
    "min": 60.0,
    "h": 3600.0,
    "day": 86_400.0,
}
UNITS = {
    "gyro": GYRO_UNITS,
    "accel": ACCEL_UNITS,
    "time": TIME_UNITS,
    "dtheta": {"rad": 1.0, "deg": units.DEG},
    "dv": {"m/s": 1.0, "g*s": units.G},
    "temperature": {"degC": 1.0, "degF": 5.0 / 9.0, "K": 1.0, "mdegC": 1e-3},
}
#: What is asked for first: the rest of the table is understood where a file spells it.
USUAL = {
    "gyro": ("rad/s", "deg/s", "deg/h", "mdps"),
    "accel": ("m/s^2", "g", "mg"),
    "time": ("s", "ms", "us", "ns", "min", "ticks:HZ"),
}
COUNTS = ("counts", "count", "lsb", "lsbs", "raw", "adc", "digit", "digits", "bits", "ticks")
_SPELLED = {
    "rad/s": "rad/s rad/sec rad/second rads radps rad*s^-1 rads^-1 rads-1 rad*s-1 r/s rad_s "
    "rad_per_s",
    "deg/s": "deg/s deg/sec deg/second dps degps degs^-1 degs-1 deg*s^-1 deg*s-1 degree/s "
    "derece/s derece/sn deg/sn grados/s graus/s graden/s grader/s st/s stopni/s degres/s degrees/s degree/sec degrees/sec degrees/second d/s deg_s deg_per_s grad/s gradi/s",
    "deg/h": "deg/h deg/hr deg/hour degrees/hour degree/hour dph degph deg_h deg_hr",
    "deg/min": "deg/min degrees/min",
    "mdps": "mdps mdeg/s mdeg/sec millidps millideg/s mdegs^-1",
    "cdps": "cdps cdeg/s centideg/s centidps",
    "mrad/s": "mrad/s mrad/sec mrads mradps millirad/s",
    "rpm": "rpm rev/min r/min u/min",
    "rev/s": "rev/s revps revs/s",
    "rps": "rps",  # radians or revolutions: asked
    "arcsec/s": "arcsec/s as/s",
    "urad/s": "urad/s microrad/s",
    "m/s^2": "m/s^2 m/sn^2 m/s2 m/s/s mps2 mps^2 ms^-2 ms-2 m*s^-2 m*s-2 m/sec^2 m/sec2 m/s**2 ms2 m_s2 "
    "m_per_s2 meters/second^2 m/s/sec n/kg meter/s^2 metre/s^2 meters/s^2",
    "g": "g g0 gn gs g's gee gees standard_gravity g-force gforce g-unit g-units g_unit g_units",
    "mg": "mg milli-g millig mgs mgee mg0",
    "ug": "ug micro-g microg",
    "cm/s^2": "cm/s^2 cm/s2 gal gals cms^-2",
    "mm/s^2": "mm/s^2 mm/s2 mms^-2",
    "mGal": "mgal milligal",
    "ft/s^2": "ft/s^2 ft/s2 ft/sec^2 feet/s^2 fts^-2",
    "s": "s sec secs second seconds unix_time unix_seconds epoch_seconds sek sekunde sekunden "
    "seconde secondes segundo segundos secondi secondo saniye sn s. с сек 秒 초",
    "cs": "cs csec centisecond centiseconds",
    "ms": "ms msec msecs millis millisec millisecs millisecond milliseconds millisekunden 毫秒",
    "us": "us usec usecs micros microsec microsecs microsecond microseconds mikrosekunden 微秒",
    "ns": "ns nsec nsecs nanos nanosec nanosecs nanosecond nanoseconds",
    "min": "min mins minute minutes minuten minuti minutos",
    "h": "h hr hrs hour hours std stunden",
    "day": "day days d",
    "rad": "rad radian radians",
    "deg": "deg degree degrees",
    "m/s": "m/s mps m/sec",
    "g*s": "g*s g*sec g-s g*seconds",
    "degC": "degc c celsius deg_c degree_c degrees_c degreec degreesc degree_celsius degrees_celsius grad_celsius centigrade",
    "mdegC": "mdegc millidegc mcelsius millicelsius mdeg_c",
    "degF": "degf f fahrenheit degrees_fahrenheit deg_f degreef degreesf",
    "K": "k kelvin degk",
    "counts": " ".join(COUNTS),
}
SPELLINGS = {
    spelling: unit for unit, spellings in _SPELLED.items() for spelling in spellings.split()
}
_SIGNS = {
    "°": "deg", "º": "deg", "˚": "deg", "²": "^2", "µ": "u", "μ": "u", "·": "*", "⋅": "*",
    "×": "*", "−": "-", "₀": "0", "ω": "omega", "θ": "theta", "Δ": "delta", "∆": "delta", "⁻¹": "^-1", "⁻²": "^-2", "℃": "degC", "℉": "degF", "′": "'",
    "сек": "s", "м/с": "m/s", "рад/с": "rad/s", "град/с": "deg/s",
    "м/сек": "m/s", "рад/сек": "rad/s", "град/сек": "deg/s", "°/с": "deg/s", "°/сек": "deg/s",
    "мс": "ms", "мкс": "us",
}  # fmt: skip


def plain(text: str) -> str:
    """A text with its signs spelled in ASCII where a unit may hold them."""
    for sign, spelled in sorted(_SIGNS.items(), key=lambda s: -len(s[0])):
        text = text.replace(sign, spelled)
    return unicodedata.normalize("NFKC", text)


#: Words of units, each before those that it holds.
_WORDS = (
    (r"(?<=[a-z])[ _]+squared\b", "^2"), (r"\bradians?\b", "rad"), (r"\bdegrees?\b", "deg"),
    (r"\b(?:arc[ -]?seconds?)\b", "arcsec"), (r"\bmet(?:er|re)s?\b", "m"), (r"\b(?:feet|foot)\b", "ft"),
    (r"\brevolutions?\b", "rev"), (r"\b(?:seconds?|secs?)(?=\b|\^)", "s"), (r"\bhours?\b|\bhr\b", "h"),
    (r"\bminutes?\b", "min"), (r"\bmilli[ -]?(?=[a-z])", "m"), (r"\bmicro[ -]?(?=[a-z])", "u"),
    (r"\bsquare s\b", "s^2"),
)  # fmt: skip


def unwrapped(text: str) -> str:
    """A text without brackets and quotes around the whole of it."""
    text = text.strip().strip("\"'").strip()
    while len(text) > 1 and text[0] + text[-1] in ("[]", "()", "{}", "<>"):
        text = text[1:-1].strip()
    return text


def unit_of(text: str) -> str | None:
    """The canonical unit that a text spells, or None."""
    text = plain(unwrapped(text))
    text = re.sub(r":(?:double|float|u?int|real|[fiu])\d*$", "", text)  # the type of the numbers
    if text in ("G", "g"):
        return "g"
    if text == "K":
        return "K"
    text = text.replace("_per_", "/").replace(" per ", "/").replace(" pro ", "/")
    text = re.sub(r"\s*([/*^])\s*", r"\1", text.lower())
    text = re.sub(r"(?<=[a-z])\.(?=[a-z])", "*", text).replace("(s^2)", "s^2").replace("(s)", "s")
    text = re.sub(r"\^\((-?\d)\)|\*\*\(?(-?\d)\)?", r"^\1\2", text)
    for spelled in (
        text,
        text.replace(" ", "*"),
        re.sub(r"[\s]+", "", text),
        text.replace(" ", "_"),
    ):
        spelled = spelled.replace("sec^", "s^")
        if spelled in SPELLINGS:
            return SPELLINGS[spelled]
    short = text
    for word, sign in _WORDS:
        short = re.sub(word, sign, short)
    return unit_of(short) if short != text else None


def stated(flag: str, kind: str) -> tuple[float, float, str]:
    """What `--gyro-unit` / `--accel-unit` states: factor to SI, zero (subtracted before), unit.

    `counts:C` is C counts per deg/s (gyro) or per g (accelerometer); `counts:C:ZERO` has its zero
    at ZERO counts. InputError where it is no unit.
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
                f"{option} {flag} must give the counts per {per}, as in "
                f"counts:{131 if kind == 'gyro' else 16384}."
            )
        return (units.DEG_PER_S if kind == "gyro" else units.G) / scale, zero, flag
    unit = unit_of(flag)
    if unit not in known:
        raise InputError(
            f"{option} {flag!r} is not known; give {', '.join(USUAL[kind])} or counts:C."
        )
    return known[unit], 0.0, unit


def scaled(text: str, kind: str) -> str | None:
    """What a call would say for a unit with a factor before it, as `0.01 deg/s`: counts per deg/s
    or g, ticks per second. None where the text is no such unit.
    """
    text = re.sub(
        r"\s*(?:/|\bper\b)?\s*\b(?:ticks?|lsb|counts?|digits?)\s*$", "", text, flags=re.IGNORECASE
    )
    found = re.match(
        r"^\s*(\d*\.?\d+(?:[eE][+-]?\d+)?)\s*(?:/\s*(\d+\.?\d*))?\s*[*x ]?\s*(\D.*)$", text
    )
    times = re.match(r"^\s*(\D.*?)\s*[*x×]\s*(\d+(?:\.\d+)?)\s*$", text)
    if times and unit_of(times[1]) in UNITS.get(kind, {}) and float(times[2]) > 0:
        size = UNITS[kind][unit_of(times[1])] / float(times[2])  # deg/s*100: a hundredth
    else:
        unit = unit_of(found[3]) if found else None
        if unit is None or unit not in UNITS.get(kind, {}) or not float(found[1]) > 0:
            return None
        if found[2] is not None and not float(found[2]) > 0:
            return None
        size = float(found[1]) / float(found[2] or 1.0) * UNITS[kind][unit]
    if kind == "time":
        return f"ticks:{1.0 / size:.10g}"
    if kind in ("gyro", "accel"):
        return f"counts:{(units.DEG_PER_S if kind == 'gyro' else units.G) / size:.10g}"
    return None


def of_range(text: str) -> str | None:
    """The unit of a text like `500 dps`, which may be the range of a sensor; None where the number
    is below one, as the size of a count is.
    """
    found = re.match(r"^\s*[±+-]*\s*(\d+(?:\.\d+)?)\s*(\D.*)$", text)
    return unit_of(found[2]) if found and float(found[1]) >= 1 else None


def size_of_a_count(text: str) -> bool:
    """Whether a text like `0.1dps` or `1/16 mg` begins with a number below one: the size of a
    count.
    """
    found = re.match(r"^\s*(\d*\.?\d+(?:[eE][+-]?\d+)?)(?:\s*/\s*(\d+))?", text)
    return bool(found) and 0 < float(found[1]) / float(found[2] or 1) < 1


def stated_time(flag: str) -> float:
    """Seconds per unit of a stamp as `--time-unit` states it: s, ms, us, ns, min, h, day, or
    ticks:HZ. InputError where it is none.
    """
    ticks = re.match(r"^ticks:(.*)$", flag.strip(), re.IGNORECASE)
    if ticks:
        try:
            rate = float(ticks[1])
        except ValueError:
            rate = 0.0
        if not 0 < rate < float("inf"):
            raise InputError(
                f"--time-unit {flag} must give the ticks per second, as in ticks:10000."
            )
        return 1.0 / rate
    unit = unit_of(flag)
    if unit not in TIME_UNITS:
        raise InputError(f"--time-unit {flag!r} is not known; give {', '.join(USUAL['time'])}.")
    return TIME_UNITS[unit]
