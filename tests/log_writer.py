"""Writes a record as some logger might: any unit of time, any order, delimiter, decimal sign and
header, streams held or in rows of their own. It shares nothing with the readers but the conventions.
"""

from __future__ import annotations

import datetime as dt
from dataclasses import dataclass, field

import numpy as np

DEG = np.pi / 180
G = 9.80665
GYRO = {"rad/s": 1.0, "deg/s": DEG, "mdps": 1e-3 * DEG, "deg/h": DEG / 3600,
        "mrad/s": 1e-3, "degrees per second": DEG}  # fmt: skip
ACCEL = {"m/s^2": 1.0, "g": G, "mg": 1e-3 * G, "cm/s^2": 1e-2, "m·s⁻²": 1.0}
NAMES = {
    "short": ("g{}", "a{}"),
    "long": ("gyro_{}", "accel_{}"),
    "board": ("{} Gyro", "{} Accel"),
    "ros": ("angular_velocity.{}", "linear_acceleration.{}"),
    "zero": ("gyro_{0}", "acc_{0}"),
    "one": ("gyr{1}", "acc{1}"),
    "brackets": ("gyro[{0}]", "accel[{0}]"),
    "phone": ("Gyroscope {}", "Accelerometer {}"),
    "chip": ("LSM6DSO_gyr_{}", "LSM6DSO_acc_{}"),
    "german": ("Drehrate {}", "Beschleunigung {}"),
    "forces": ("w{}", "f{}"),
    "omega": ("omega_{}", "alpha_{}"),
}
STAMPS = ("s", "epoch_s", "ms", "boot_ms", "epoch_ms", "us", "boot_us", "ns", "min",
          "secs_nsecs", "iso", "split", "dmy", "mdy", "ampm", "colon_ms", "counter", "none", "wrap_us", "coarse", "hms",
          "day", "filetime", "compact", "two_times", "ticks_64", "six_digits", "single", "digits", "short_year", "frames",
          "packets")  # fmt: skip


@dataclass
class Plan:
    """What is drawn: see the fields of the file that it makes."""

    stamps: str
    rate: float
    n: int = 400
    named_time: bool = True  # whether the heading of the time says its unit
    gyro_unit: str = "rad/s"
    accel_unit: str = "m/s^2"
    unit_style: str = "brackets"  # brackets, round, row, flag
    names: str = "short"
    delimiter: str = ","
    comma: bool = False  # decimal comma
    order: tuple = (0, 1, 2)  # of time, gyro, accel
    extras: tuple = ()
    layout: str = "plain"  # plain, held, interleaved, twice
    held_by: int = 4  # rows of a held reading
    dress: str = (
        "plain"  # plain, comment, preamble, quoted, bom, crlf, utf-16, footer, labels, cells
    )
    gap: int = 0  # samples lost in the middle
    seed: int = 1
    flags: dict = field(default_factory=dict)


def truth(plan):
    """time (n,) s, gyro and accel (n, 3) in SI; of a held accelerometer one reading in four."""
    rng = np.random.default_rng(plan.seed)
    gyro = rng.normal(0, 2e-3, (plan.n, 3)) + [0.010, -0.020, 0.005]
    accel = rng.normal(0, 2e-2, (plan.n, 3)) + [0.3, -0.4, -9.78]
    slot = np.arange(plan.n)
    if plan.gap:
        slot[plan.n // 2 :] += plan.gap
    return slot / plan.rate, gyro, accel


def stamp_columns(plan, t):
    """(headings, columns of text, flags that answer what may be asked)."""
    # fmt: off
    told = {"s": "s", "ms": "ms", "us": "us", "ns": "ns", "min": "min"}
    kind = plan.stamps
    unit = {"epoch_s": "s", "boot_ms": "ms", "epoch_ms": "ms", "boot_us": "us", "wrap_us": "us", "coarse": "s"}.get(kind, kind)
    rate = {"rate": plan.rate}
    if kind == "none":
        return [], [], rate
    if kind == "counter":
        return ["sample"], [[str(17 + int(k)) for k in np.rint(t * plan.rate)]], rate
    if kind == "filetime":
        tenths = 132_594_191_990_000_000 + np.rint(t * 1e7).astype(np.int64)
        return ["timestamp"], [[str(v) for v in tenths]], {"time_unit": "ticks:1e7"}
    if kind == "two_times":  # of arrival, uneven, beside the sensor's own
        late = np.sort(t + np.random.default_rng(plan.seed).uniform(0.0, 2.0 / plan.rate, len(t)))
        own = 7_000_000 + np.rint(t * 1e6).astype(np.int64)
        return ["host_time [s]", "device_time [us]"], [[f"{1.6e9 + v:.6f}" for v in late], [str(v) for v in own]], {}
    if kind == "ticks_64":  # a computer's clock, printed to the millisecond
        return ["time_ms"], [[str(int(v * 1e3)) for v in np.floor((t + 77.7) * 64) / 64]], {}
    if kind == "six_digits":
        return ["time [s]"], [[f"{v:.6g}" for v in t + 9_998.0]], {}
    if kind == "single":
        return ["time [s]"], [[f"{float(v):.7f}" for v in np.float32(t + 9_000.0)]], {}
    if kind == "frames":  # 25 in a second
        return ["timecode"], [[f"10:59:{int(v) // 1:02d}:{int(v % 1 * 25 + 1e-6):02d}" for v in t]], {}
    if kind == "packets":
        late = np.random.default_rng(plan.seed).uniform(0.0, 0.2, plan.n)
        group = np.rint(t * plan.rate).astype(np.int64) // 4
        return ["recv_ms"], [[f"{1000 * (4 * (g + late[g % plan.n]) / plan.rate) + 5000:.0f}" for g in group]], {}
    if kind == "day":
        days = [f"{44197.25 + v / 86400:.12f}" for v in t]
        return ["time [day]" if plan.named_time else "datetime"], [days], {"time_unit": "day"}
    if kind == "secs_nsecs":
        ns = 1_600_000_000_999_000_000 + np.rint(t * 1e9).astype(np.int64)
        return ["secs", "nsecs"], [[str(v // 10**9) for v in ns], [str(v % 10**9) for v in ns]], {}
    if kind in ("iso", "compact", "digits", "short_year", "split", "dmy", "mdy", "ampm", "colon_ms", "hms"):
        start = dt.datetime(2021, 3, 4, 23, 59, 59) if kind != "hms" else dt.datetime(2021, 3, 4, 10, 58, 59)
        if kind == "ampm":
            start = dt.datetime(2021, 3, 4, 11, 59, 59)
        when = [start + dt.timedelta(microseconds=round(v * 1e6)) for v in t]
        clock = [w.strftime("%H:%M:%S.%f") for w in when]
        if kind == "iso":
            return ["timestamp"], [[w.isoformat(timespec="microseconds") for w in when]], {}
        if kind == "digits":
            return ["timestamp"], [[w.strftime("%Y%m%d%H%M%S%f") for w in when]], {}
        if kind == "short_year":
            return ["timestamp"], [[w.strftime("%y/%m/%d %H:%M:%S.%f") for w in when]], {}
        if kind == "compact":
            return ["timestamp"], [[w.strftime("%Y%m%dT%H%M%S.%f") for w in when]], {}
        if kind == "split":
            return ["date", "time"], [[w.strftime("%Y-%m-%d") for w in when], clock], {}
        if kind == "dmy":
            return ["date", "clock"], [[w.strftime("%d.%m.%Y") for w in when], clock], {}
        if kind == "mdy":
            return ["date", "time"], [[w.strftime("%m/%d/%Y") for w in when], clock], {}
        if kind == "ampm":
            return ["time"], [[w.strftime("%I:%M:%S.%f %p") for w in when]], {}
        if kind == "hms":
            seconds = [f"{w.second + w.microsecond * 1e-6:.6f}" for w in when]
            return ["hour", "minute", "second"], [[str(w.hour) for w in when], [str(w.minute) for w in when], seconds], {}
        return ["time"], [[w.strftime("%H:%M:%S:") + f"{w.microsecond // 1000:03d}" for w in when]], {}
    offset = {"s": 0.0, "epoch_s": 1.6e9, "boot_ms": 432_000.0, "epoch_ms": 1.6e9, "boot_us": 432_000.0, "ns": 1.6e9,
              "wrap_us": 4294.0, "ms": 5.231, "us": 3.5, "min": 0.0, "coarse": 2.0}[kind]
    heading = {0: "time", 1: "timestamp", 2: "t"}[plan.seed % 3]
    if plan.named_time:
        heading += {"brackets": f" [{told[unit]}]", "round": f" ({told[unit]})"}.get(plan.unit_style, f"_{told[unit]}")
    if unit == "min":
        text = [f"{v / 60:.9f}" for v in t]
    elif kind == "coarse":
        text = [f"{np.floor((v + offset) * 10 + 1e-6) / 10:.1f}" for v in t]
    elif unit == "s":
        text = [f"{offset + v:.6f}" for v in t]
    else:
        per = {"ms": 10**3, "us": 10**6, "ns": 10**9}[unit]
        whole = int(offset) * per + round(offset % 1 * per) + np.floor(t * per + 1e-4).astype(np.int64)
        if kind == "wrap_us":
            whole = whole % 2**32
        text = [str(v) for v in whole]
    return [heading], [text], {"time_unit": told[unit]}


def write(path, plan):
    """The file, and the flags that answer whatever may be asked about it."""
    t, gyro, accel = truth(plan)
    heads, stamps, answers = stamp_columns(plan, t)
    shape = NAMES[plan.names]
    gyro, accel = gyro / GYRO[plan.gyro_unit], accel / ACCEL[plan.accel_unit]
    held = (
        (np.arange(plan.n) // plan.held_by) * plan.held_by
        if plan.layout == "held"
        else np.arange(plan.n)
    )
    groups = [[(h, c, None) for h, c in zip(heads, stamps)]]
    for form, unit, values, kind in (
        (shape[0], plan.gyro_unit, gyro, 0),
        (shape[1], plan.accel_unit, accel[held], 1),
    ):
        group = []
        for k, axis in enumerate("xyz"):
            name = (
                form.format(axis, k + 1)
                if "{1}" in form
                else form.format(k if "{0}" in form else axis)
            )
            if plan.unit_style in ("brackets", "round"):
                name += f" [{unit}]" if plan.unit_style == "brackets" else f" ({unit})"
            text = [f"{v:.10g}" for v in values[:, k]]
            if plan.layout == "interleaved":  # every second reading goes to the other sensor's row
                text = [v if row % 2 == kind else "" for row, v in enumerate(text)]
            group.append((name, text, unit))
        groups.append(group)
    columns = [c for i in plan.order for c in groups[i]]
    for extra in plan.extras:
        more = {
            "mag": ("mag_x [uT]", [f"{20 + 0.01 * (k % 7):.3f}" for k in range(plan.n)], "uT"),
            "text": ("frame_id", ["imu_link"] * plan.n, ""),
            "temp": ("temperature", [f"{24 + k / plan.n:.3f}" for k in range(plan.n)], "degC"),
            "roll": ("roll", [f"{0.01 * (k % 11):.4f}" for k in range(plan.n)], "deg"),
        }[extra]
        columns.append(more)

    def marked(text):
        numeric = text.replace(".", "").replace("-", "").replace("e", "").isdigit()
        return text.replace(".", ",") if plan.comma and numeric else text

    sep = plan.delimiter
    lines = [sep.join(name for name, _, _ in columns)]
    if plan.unit_style == "row":
        unit_of_time = (
            {"time_unit": answers.get("time_unit", "")}["time_unit"] if plan.named_time else ""
        )
        lines.append(
            sep.join((unit if unit is not None else unit_of_time) or "-" for _, _, unit in columns)
        )
    rows = [sep.join(marked(c[k]) for _, c, _ in columns) for k in range(plan.n)]
    if plan.layout == "twice":
        rows = [r for row in rows for r in (row, row)]
    path.write_bytes(_dressed(plan, lines, rows, columns, marked))
    flags = dict(answers)
    if plan.unit_style == "flag":
        flags |= {"gyro_unit": plan.gyro_unit, "accel_unit": plan.accel_unit}
    return flags
    # fmt: on


def _dressed(plan, lines, rows, columns, marked):
    """The bytes of the file: what stands above and below, quotes, labels, cells of three."""
    end, encoding = "\n", "utf-8"
    if plan.dress == "comment":
        lines = [f"# {line}" for line in lines]
    elif plan.dress == "preamble":
        lines = ["Logger 2.0", "Serial;1234", "", *lines]
    elif plan.dress == "footer":
        rows = [*rows, "", "Stopped by the user, all is well"]
    elif plan.dress == "crlf":
        end = "\r\n"
    elif plan.dress == "bom":
        encoding = "utf-8-sig"
    elif plan.dress == "utf-16":
        encoding = "utf-16"
    elif plan.dress == "quoted":
        rows = [plan.delimiter.join(f'"{f}"' for f in row.split(plan.delimiter)) for row in rows]
    elif plan.dress == "labels":
        lines = []
        rows = [" ".join(f"{name.replace(' ', '_')}={c[k]}" for name, c, _ in columns) for k in range(plan.n)]  # fmt: skip
    elif plan.dress == "cells":
        lines, rows = _cells(plan, columns, marked)
    return (end.join([*lines, *rows]) + end).encode(encoding)


def _cells(plan, columns, marked):
    """Three axes in a cell: `[0.1, 0.2, 0.3]`."""
    heads, cells, at = [], [], 0
    while at < len(columns):
        name, text, unit = columns[at]
        if unit in GYRO or unit in ACCEL:
            word = "gyro" if unit in GYRO else "accel"
            heads.append(f"{word} [{unit}]" if plan.unit_style in ("brackets", "round") else word)
            three = columns[at : at + 3]
            cells.append(["[" + " ".join(c[k] for _, c, _ in three) + "]" for k in range(plan.n)])
            at += 3
            continue
        heads.append(name)
        cells.append([marked(v) for v in text])
        at += 1
    sep = plan.delimiter
    return [sep.join(heads)], [sep.join(c[k] for c in cells) for k in range(plan.n)]
