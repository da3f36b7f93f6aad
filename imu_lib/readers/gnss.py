"""GNSS solutions in text: RTKLIB `.pos` and NMEA 0183 (through `pynmea2`)."""

from __future__ import annotations

import datetime as dt
from pathlib import Path

import numpy as np

from imu_lib.errors import InputError

GPS_EPOCH = dt.datetime(1980, 1, 6, tzinfo=dt.UTC).timestamp()
# GPS - UTC since 2017; earlier drives are off by what was added since, and should be given in UTC
LEAP_SECONDS = 18
KNOT = 1852.0 / 3600.0


def is_gnss(path) -> bool:
    """Whether a file is an RTKLIB .pos or an NMEA log, by its first lines."""
    path = Path(path)
    if path.suffix.lower() in (".pos", ".nmea"):
        return True
    with open(path, "rb") as file:
        head = file.read(4096)
    return (
        head.startswith(b"% program")
        or sum(line.startswith(b"$G") for line in head.splitlines()) > 2
    )


def read_gnss(path) -> dict[str, np.ndarray]:
    """gnss_time (UTC epoch, s), gnss_position and what else the file has, under the contract's
    keys. InputError where it is at fault.
    """
    path = Path(path)
    with open(path, "rb") as file:
        data = file.read()
    if not data.strip():
        raise InputError(f"{path} is empty; an RTKLIB .pos file or an NMEA log is expected.")
    text = data.decode("ascii", errors="replace")
    lines = text.splitlines()
    return (
        _nmea(path, lines)
        if sum(line.lstrip().startswith("$") for line in lines[:50]) > 1
        else _pos(path, lines)
    )


def _pos(path, lines) -> dict[str, np.ndarray]:
    """RTKLIB: time (calendar or week and seconds), latitude and longitude (deg), height, quality,
    satellites, standard deviations.
    """
    header = next((line for line in lines if line.startswith("%") and "latitude" in line), "")
    if lines and any(
        "x-ecef" in line or "e-baseline" in line for line in lines[:40] if line.startswith("%")
    ):
        raise InputError(
            f"{path} holds ECEF or baseline positions; write latitude, longitude and height "
            "(out-solformat=llh)."
        )
    gpst = "UTC" not in header
    time, values = [], []
    for number, line in enumerate(lines, 1):
        if not line.strip() or line.startswith("%"):
            continue
        f = line.split()
        try:
            if "/" in f[0]:
                day = dt.datetime.strptime(f[0], "%Y/%m/%d").replace(tzinfo=dt.UTC).timestamp()
                h, m, s = f[1].split(":")
                t = day + 3600 * int(h) + 60 * int(m) + float(s)
            else:
                t = GPS_EPOCH + 604800.0 * int(f[0]) + float(f[1])
            row = [float(x) for x in f[2:]]
            if (
                len(row) < 3
                or not np.isfinite([t, *row[:3]]).all()
                or abs(row[0]) > 90
                or abs(row[1]) > 360
            ):
                raise ValueError
        except (ValueError, IndexError, OverflowError):
            raise InputError(
                f"{path}, line {number}: {line[:40]!r} is no RTKLIB position (time, latitude, "
                "longitude, height); correct or remove it."
            ) from None
        if values and len(row) != len(values[0]):
            raise InputError(
                f"{path}, line {number}: {len(row) + 2} columns where the first position has "
                f"{len(values[0]) + 2}; the file is cut off there."
            )
        time.append(t - (LEAP_SECONDS if gpst else 0))
        values.append(row)
    if len(values) < 2:
        raise InputError(
            f"{path} has {len(values)} positions; at least two are needed: give the solution of "
            "the whole drive (RTKLIB .pos or NMEA)."
        )
    v = np.asarray(values)
    out = {
        "gnss_time": np.asarray(time),
        "gnss_position": np.column_stack([np.radians(v[:, 0]), np.radians(v[:, 1]), v[:, 2]]),
    }
    if v.shape[1] >= 4:
        out["gnss_fix"] = v[:, 3]
    if v.shape[1] >= 8:  # sdn, sde, sdu
        out["gnss_position_sd"] = v[:, 5:8]
    if v.shape[1] >= 16 and "vn" in header:
        out["gnss_velocity"] = v[:, 13:16] * [1.0, 1.0, -1.0]  # up is written, down is meant
        if v.shape[1] >= 19:
            out["gnss_velocity_sd"] = v[:, 16:19]
    return out


def _take(fix: dict, kind: str, m) -> None:
    """What one sentence says of a fix."""
    if kind == "GGA" and m.lat and int(m.gps_qual or 0) > 0:
        height = float(m.altitude or 0) + float(m.geo_sep or 0)
        fix.update(position=(m.latitude, m.longitude, height), fix=float(m.gps_qual))
    elif kind == "RMC" and m.status == "A":
        if m.spd_over_grnd is not None and m.true_course is not None:
            v, c = m.spd_over_grnd * KNOT, np.radians(m.true_course)
            fix["velocity"] = (v * np.cos(c), v * np.sin(c))
    elif kind == "GST" and m.std_dev_latitude:
        fix["sd"] = (
            float(m.std_dev_latitude),
            float(m.std_dev_longitude),
            float(m.std_dev_altitude or 0),
        )


def _nmea(path, lines) -> dict[str, np.ndarray]:
    """GGA for position and fix, RMC for date, speed and course, GST for standard deviations;
    sentences with a wrong checksum are left out."""
    import pynmea2

    fixes: dict[float, dict] = {}
    day, last, bad = None, None, 0
    for line in lines:
        line = line.strip()
        if not line.startswith("$"):
            continue
        try:
            m = pynmea2.parse(line, check=True)
        except (pynmea2.ParseError, ValueError, AttributeError, TypeError, KeyError, IndexError):
            bad += 1
            continue
        stamp = getattr(m, "timestamp", None)
        kind = getattr(m, "sentence_type", "")
        if kind not in ("GGA", "RMC", "GST") or not isinstance(stamp, dt.time):
            continue
        seconds = 3600 * stamp.hour + 60 * stamp.minute + stamp.second + 1e-6 * stamp.microsecond
        try:
            if kind == "RMC" and isinstance(m.datestamp, dt.date):
                day = dt.datetime.combine(m.datestamp, dt.time(), dt.UTC).timestamp()
            elif last is not None and seconds < last - 43_200 and day is not None and kind == "GGA":
                day += 86_400.0
            last = seconds
            _take(fixes.setdefault(round((day or 0.0) + seconds, 3), {}), kind, m)
        except (ValueError, TypeError, AttributeError):
            bad += 1
    if day is not None:  # sentences before the first RMC had no date yet
        first = next(iter(t for t in fixes if t > 86_400 * 2), 0.0)
        early = {t: fixes.pop(t) for t in [t for t in fixes if t < 86_400 * 2]}
        for t, fix in early.items():
            fixes.setdefault(round(first - first % 86_400 + t, 3), {}).update(fix)
    rows = sorted((t, f) for t, f in fixes.items() if "position" in f)
    if len(rows) < 2:
        raise InputError(
            f"{path} has {len(rows)} GGA positions with a fix ({bad} damaged sentences); at least "
            "two are needed: give a log with GGA sentences of the whole drive."
        )
    p = np.asarray([f["position"] for _, f in rows])
    out = {
        "gnss_time": np.asarray([t for t, _ in rows]),
        "gnss_position": np.column_stack([np.radians(p[:, :2]), p[:, 2]]),
        "gnss_fix": np.asarray([f["fix"] for _, f in rows]),
    }
    if all("sd" in f for _, f in rows):
        out["gnss_position_sd"] = np.asarray([f["sd"] for _, f in rows])
    if all("velocity" in f for _, f in rows):
        # the vertical speed is not in NMEA: the height's own slope
        down = -np.gradient(p[:, 2], out["gnss_time"])
        out["gnss_velocity"] = np.column_stack([np.asarray([f["velocity"] for _, f in rows]), down])
    return out
