"""One record of a fleet into the rows of the fleet's table."""

from __future__ import annotations

import math

from imu_lib.errors import InputError
from imu_lib.estimate import Estimate
from imu_lib.fleet.manifest import Entry

#: Columns of the table and their types. A coefficient that the record does not show has no value,
#: and `high` is its 95 % upper limit; `effect` names what the gap workflow found or the sum that
#: the likelihood chose; `error` is the sentence on a record that could not be used.
COLUMNS = {
    "sensor": "string",
    "file": "string",
    "date": "string",
    "channel": "string",
    "method": "string",
    "coefficient": "string",
    "value": "double",
    "low": "double",
    "high": "double",
    "effect": "string",
    "confidence": "double",
    "rate": "double",
    "duration": "double",
    "error": "string",
}
METHODS = ("allan", "psd", "likelihood", "gauss_markov")


def of_record(entry: Entry, gap: bool = False) -> list[dict]:
    """The rows of one record; a record that cannot be used is one row with its sentence."""
    try:
        return _found(entry, gap)
    except (InputError, OSError, ValueError, MemoryError) as error:
        return [_row(entry, error=_sentence(entry, error))]
    except Exception as error:
        return [_row(entry, error=f"{entry.file}: {type(error).__name__}: {_one_line(error)}")]


def lost(entry: Entry) -> list[dict]:
    """The row of a record that has ended every process that took it up."""
    said = "its process was ended every time (too little memory?); characterise it alone"
    return [_row(entry, error=f"{entry.file}: {said}.")]


def _sentence(entry, error):
    if isinstance(error, MemoryError):
        return f"{entry.file}: there is not enough memory for this record."
    if isinstance(error, OSError) and not isinstance(error, InputError):
        return f"{entry.file}: {error.strerror or _one_line(error)}; check the path."
    return _one_line(error).replace(entry.path, entry.file)


def _one_line(error):
    return " ".join(str(error).split())


def _row(entry, **values):
    row = dict.fromkeys(COLUMNS)
    return {**row, "sensor": entry.sensor, "file": entry.file, "date": entry.date or None, **values}


def _found(entry, gap):
    from imu_lib.characterise import characterise

    record = _opened(entry)
    result = characterise(record, workers=1)
    about = {"rate": float(result.rate), "duration": float(result.duration)}
    rows = []
    for name, channel in result.channels.items():
        for method in METHODS:
            for symbol, estimate in getattr(channel, method).items():
                rows.append(
                    _row(entry, channel=name, method=method, coefficient=symbol)
                    | _numbers(estimate)
                    | about
                )
        sigma = channel.autoregressive["sigma"]
        if isinstance(sigma, Estimate):
            rows.append(
                _row(entry, channel=name, method="autoregressive", coefficient="sigma")
                | _numbers(sigma)
                | about
            )
        weight = channel.choice.weights.get(channel.choice.name)
        rows.append(
            _row(entry, channel=name, method="likelihood", effect=channel.choice.name)
            | {"confidence": None if weight is None else float(weight)}
            | about
        )
    return rows + (_effects(entry, record, result, about) if gap else [])


def _opened(entry):
    """The record, in memory or, where it is long, on disk; a folder is one of consecutive logs."""
    from imu_lib.long_record import on_disk, worth_it
    from imu_lib.readers import read_record

    record = on_disk(entry.path, **entry.reading)
    if record is None:
        return read_record(entry.path, **entry.reading)
    return worth_it(record)


def _numbers(estimate):
    def number(v):
        return float(v) if v is not None and math.isfinite(v) else None

    return {
        "value": number(estimate.value),
        "low": number(estimate.low),
        "high": number(estimate.high),
    }


def _effects(entry, record, result, about):
    """What the gap workflow finds missing: a row for each parameter of each effect."""
    from imu_lib.gap import close

    found = close(record, None, seed=0, simulations=0, jobs=1).to_json()
    steps = [(name, s) for name, c in found["channels"].items() for s in c["steps"]]
    steps += [(None, step) for step in found.get("record", {}).get("steps", [])]
    rows = []
    for channel, step in steps:
        numbers = {
            k: v for k, v in step.get("parameters", {}).items() if isinstance(v, (int, float))
        }
        for key, value in numbers.items() or [(None, None)]:
            low, high = (step.get("intervals") or {}).get(key) or (None, None)
            rows.append(
                _row(entry, channel=channel, method="gap", coefficient=key, effect=step["effect"])
                | {"value": value, "low": low, "high": high}
                | {"confidence": step.get("confidence")}
                | about
            )
    return rows
