"""Arrays by name into raw columns: the contract's keys in SI, everything else by what it is
called.
"""

from __future__ import annotations

import re

import numpy as np

from imu_lib.errors import InputError
from imu_lib.readers import by_rows, calendar, fields, names, question
from imu_lib.readers.asking import Unnamed, example
from imu_lib.readers.columns import Heading, decide
from imu_lib.readers.raw import Raw
from imu_lib.record import CHANNELS


def from_arrays(source, arrays, columns, signal, *, contract) -> Raw:
    raw = Raw(source)
    arrays = _plain(arrays)
    exact = {k for k in arrays if k in CONTRACT} if contract else set()
    if exact and not columns:
        return _contract(raw, arrays, exact, signal)
    for key, value in arrays.items():
        if leaf_is_rate(key) and value.size == 1 and value.dtype.kind in "fiu":
            raw.rate = float(value.ravel()[0])
    flat = _expanded(source, arrays, columns, signal)
    if signal in ("gyro", "accel") and not columns and len(arrays) == 1 and len(flat) == 3:
        flat = [(axis, x) for axis, (_, x) in zip("xyz", flat)]  # one matrix of one sensor
    headings = [
        Heading(_told(name, signal), _kind(x) if x.dtype.kind in "OUS" else "number")
        for name, x in flat
    ]

    def load(wanted):
        return {i: _moments(flat[i][1], headings[i].kind) for i in wanted}

    long = by_rows.sensors(raw, [names.meaning(h.name) for h in headings], headings, load)
    if (
        not columns
        and long is None
        and not any(
            names.meaning(h.name, signal=signal).quantity in names.SIGNALS for h in headings
        )
    ):
        if not (
            signal == "temperature"
            and any(names.meaning(h.name).quantity == "temperature" for h in headings)
        ):
            found = (
                ", ".join(f"{k} {np.shape(v)}" for k, v in list(arrays.items())[:8]) or "nothing"
            )
            hint = _hint(flat, headings)
            hint += question.units_open(hint)
            hint += "" if raw.rate or "time" in hint else ", and the rate with --rate HZ"
            raise Unnamed(
                f"{source} has no array called gyro, accel or one of their axes (found: {found}); "
                f"rename them, or name the {len(flat)} columns"
                f" by position with --columns{hint}."
            )
    decide(
        raw,
        headings,
        load,
        columns=columns,
        signal=signal,
    )
    return _checked(raw)


def _kind(x: np.ndarray) -> str:
    """What texts are: dates, clocks, both in one, or text."""
    kinds = {fields.kind(_text(v)) for v in x[:20]} - {"empty"}
    return kinds.pop() if len(kinds) == 1 and kinds <= set(fields.STAMPS) else "text"


def _text(value) -> str:
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)


def _moments(x: np.ndarray, kind: str) -> np.ndarray:
    """Texts that are stamps as they are usually written."""
    if kind not in fields.STAMPS:
        return x
    said = [_text(v) for v in x]
    return np.array([calendar.usual(v) or v for v in said], dtype=object)


def _hint(flat, headings) -> str:
    """An example of --columns for the columns of a matrix."""
    if len({len(x) for _, x in flat}) != 1 or len(flat) < 3:
        return ""
    numbers = {i: x for i, (_, x) in enumerate(flat) if x.dtype.kind in "fiu"}
    told = [names.Meaning()] * len(flat)
    return f", as in {_increments(flat) or example(told, headings, numbers)}"


def _increments(flat) -> str:
    """Names of increments with the time behind them, as PSINS keeps an IMU; empty where a matrix
    holds none.
    """
    if len(flat) != 7:
        return ""
    first, last = np.asarray(flat[0][1], dtype=float), np.asarray(flat[-1][1], dtype=float)
    if not (np.diff(last) > 0).all() or (np.diff(first) > 0).all():
        return ""
    step = float(np.median(np.diff(last)))
    size = np.linalg.norm([np.median(np.asarray(x, dtype=float)) for _, x in flat[3:6]])
    if not 0.7 < size / (9.81 * step) < 1.3:
        return ""
    units = {"dtheta": "rad", "dv": "m/s"}
    named = [f"{of}_{a}[{unit}]" for of, unit in units.items() for a in "xyz"]
    return f"'{','.join(named)},time[s]'"


def _plain(arrays) -> dict[str, np.ndarray]:
    """Fields of structured arrays as arrays of their own; dates as nanoseconds."""
    out = {}
    for key, value in arrays.items():
        value = np.asarray(value)
        if value.dtype.names:
            for name in value.dtype.names:
                out[name if len(arrays) == 1 else f"{key}.{name}"] = value[name]
        else:
            out[key] = value
    for key, value in list(out.items()):
        if value.dtype.kind in "mM":
            del out[key]
            out[f"{key} [ns]"] = value.astype(f"{value.dtype.kind}8[ns]").astype(np.int64)
    return out


def _told(name: str, signal) -> str:
    """A dotted name, or its last part where only that one says something."""
    if names.meaning(name, signal=signal).quantity is None:
        leaf = name.rpartition(".")[2]
        if names.meaning(leaf, signal=signal).quantity is not None:
            return leaf
    return name


def _expanded(source, arrays, columns, signal) -> list[tuple[str, np.ndarray]]:
    """Every column of every array, (name, values): a matrix is its columns, `key[0]` and so on."""
    long = {
        k: v for k, v in arrays.items() if v.size > 1 and v.ndim <= 2 and v.dtype.kind in "fiubcOUS"
    }
    if not long:
        long = {k: v for k, v in arrays.items() if v.ndim <= 2 and v.size}
    lengths = [max(v.shape) for v in long.values()] if long else []
    named = [
        k
        for k in long
        if names.meaning(_told(k, signal), signal=signal).quantity in (*names.SIGNALS, "time")
    ]
    if columns and lengths:
        n = max(set(lengths), key=lambda m: (lengths.count(m), m))
        long = {k: v for k, v in long.items() if n in v.shape}
    flat = []
    for key, value in long.items():
        if (
            columns is None
            and named
            and key not in named
            and max(value.shape) not in {max(long[k].shape) for k in named}
        ):
            continue
        if value.ndim == 1 or 1 in value.shape or value.ndim == 0:
            flat.append((key, value.ravel()))
            continue
        found = names.meaning(_told(key, signal), signal=signal)
        if found.quantity in names.SIGNALS and 3 in value.shape:
            value = value if value.shape[1] == 3 else value.T
        elif found.quantity in names.SIGNALS and found.axis is None and columns is None:
            raise InputError(
                f"{source}: `{key}` has the shape {value.shape}; three axes, (n, 3), are expected."
            )
        elif value.shape[0] < value.shape[1]:
            value = value.T
        unit = re.search(r"\s*[\[(][^\])]*[\])]\s*$", key)
        head, tail = (key[: unit.start()], key[unit.start() :]) if unit else (key, "")
        flat += [(f"{head}[{i}]{tail}", value[:, i]) for i in range(value.shape[1])]
    for name, x in flat:
        if x.dtype.kind == "c" and (
            columns or names.meaning(_told(name, signal), signal=signal).quantity
        ):
            raise InputError(
                f"{source}, `{name}`: holds {x.dtype} instead of numbers; save it as real numbers."
            )
    return flat


def _contract(raw: Raw, arrays, exact, signal) -> Raw:
    """Arrays under the contract's keys, SI by their names."""
    raw.simulated = "simulated" in arrays
    raw.contract = True
    for key, value in arrays.items():
        if key in exact:
            if value.dtype.kind not in "fiub":
                raise InputError(
                    f"{raw.source}, `{key}`: holds {value.dtype} instead of numbers; save it as "
                    "real numbers."
                )
            unit = {"g": "rad/s", "a": "m/s^2"}.get(key[0])
            raw.add(key, value, unit, key, f"the key {key} is SI")
        elif leaf_is_rate(key) and value.size == 1 and value.dtype.kind in "fiu":
            raw.rate = float(value.ravel()[0])
        elif value.size > 1:
            told = names.meaning(key, signal=signal)
            taken = {k.partition("_")[0] for k in exact}
            if told.quantity == "time" and "time" not in arrays and value.ndim == 1:
                raw.add("time", value, told.unit, key, told.why)
                raw.contract = False  # another name for the time: its unit is open
            elif told.quantity in names.SIGNALS and told.quantity not in taken and value.ndim <= 2:
                more = Raw(raw.source)  # a signal beside the contract's own, under another name
                flat = _expanded(raw.source, {key: value}, None, signal)
                decide(
                    more,
                    [Heading(n) for n, _ in flat],
                    lambda w, f=flat: {i: f[i][1] for i in w},
                    signal=signal,
                )
                for canonical, x in more.columns.items():
                    if canonical not in raw.columns:
                        raw.add(
                            canonical,
                            x,
                            more.units[canonical],
                            more.headings[canonical],
                            f"named {told.quantity}",
                        )
            else:
                drive = key.startswith(("gnss_", "reference_", "lever_arm"))
                raw.skip(key, "of the drive" if drive else "not a key of a static record")
    if not raw.kinds() and not (signal == "temperature" and "temperature" in raw.columns):
        found = ", ".join(f"{k} {np.shape(v)}" for k, v in list(arrays.items())[:8]) or "nothing"
        raise InputError(
            f"{raw.source} has no array called gyro, accel or one of their axes (found: {found}); "
            "rename them, or give --columns for the columns of one matrix."
        )
    return _checked(raw)


def leaf_is_rate(key: str) -> bool:
    return key.rpartition(".")[2].lower() in (
        "fs",
        "rate",
        "sample_rate",
        "sampling_rate",
        "samplerate",
        "freq",
        "frequency",
    )


def _checked(raw: Raw) -> Raw:
    lengths = {h: len(raw.columns[c]) for c, h in raw.headings.items() if c in raw.columns}
    if len(set(lengths.values())) > 1:
        raise InputError(
            f"{raw.source}: its arrays differ in length "
            f"({', '.join(f'{h} {n:,}' for h, n in list(lengths.items())[:6])}); every one needs "
            "a value per sample."
        )
    if next(iter(lengths.values())) < 2:
        raise InputError(
            f"{raw.source} has {'only 1 sample' if 1 in lengths.values() else 'no samples'}; at "
            "least two are needed."
        )
    return raw


CONTRACT = {"time", "gyro", "accel", "temperature", *CHANNELS}
