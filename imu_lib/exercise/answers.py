"""Files of answers: what students write, read with one sentence for each mistake."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping, Sequence
from difflib import get_close_matches
from pathlib import Path

from imu_lib.errors import InputError, once
from imu_lib.exercise import drives, hidden
from imu_lib.record import CHANNELS

#: What students call an effect, where no name on the sheet looks like it: a hint, no mark.
SYNONYMS = {
    "jump": "step",
    "bias_jump": "step",
    "clipping": "saturation",
    "clipped": "saturation",
    "rounding": "resolution",
    "lsb": "resolution",
    "sine": "sinusoid",
    "sine_wave": "sinusoid",
    "tone": "sinusoid",
    "line": "sinusoid",
    "trend": "ramp",
    "drift": "ramp",
    "outliers": "spikes",
    "popcorn_noise": "telegraph",
    "burst_noise": "telegraph",
    "transient": "warm_up",
    "latency": "gnss_time_offset",
    "delay": "gnss_time_offset",
    "antenna": "lever_arm",
    "scale_factor": "accel_scale",
}
#: A number with a comma for its point (1,180 may be of thousands, and is asked about), or with the
#: SI unit that was asked for.
COMMA = re.compile(r"[+-]?(0*,\d+|\d+,(?!\d{3}(e|$))\d+)(e[+-]?\d+)?", re.IGNORECASE)
SI = re.compile(
    r"(.*\d\.?)\s*(?:1/s|Hz|(?:s|m|rad)?(?:/s(?:\^?[23]|²|³)?)?(?:/sqrt\(Hz\)|/√Hz)?)",
    re.IGNORECASE,
)
#: What stands beside an answer without being a parameter, as in what `imu-lib gap --json` writes.
BESIDE = {
    "channel", "effect", "parameters", "intervals", "where", "confidence", "runner_up",
    "indistinguishable", "gap_before", "gap_after", "log_likelihood_gain",
}  # fmt: skip

FORM = '{"channels": {"gyro_x": [{"effect": "step", "parameters": {"time": 12.0}}]}}'


def read_json(path: Path):
    """The content of a JSON file, as editors write it: UTF-8 or UTF-16, with a mark or without."""
    raw = path.read_bytes()
    try:
        text = raw.decode("utf-16" if raw[:2] in (b"\xff\xfe", b"\xfe\xff") else "utf-8-sig")
    except UnicodeDecodeError:
        raise InputError(f"{path} is not text in UTF-8: save it again as UTF-8.") from None
    if not text.strip():
        raise InputError(f"{path} is empty.")
    try:
        return json.loads(text, object_pairs_hook=lambda pairs: once(pairs, path))
    except ValueError as problem:
        raise InputError(f"{path} is not valid JSON: {problem}.") from None


def student_of(given, path: Path, students, key) -> str:
    """The student whose answers these are; 1 is 01."""
    if not isinstance(given, Mapping):
        raise InputError(f"{path}: these are no answers; answers look like {FORM}.")
    folder = path.parent.name
    name = given.get("student", folder if "student_" in folder else None)
    if name is None:
        raise InputError(f'{path}: "student" is missing; it is the number on the sheet.')
    name = str(name).strip().lower().removeprefix("student").lstrip("_ ")
    found = [s for s in students if s == name or s.lstrip("0") == name]
    if len(found) != 1:
        raise InputError(
            f"{path}: there is no student {name!r} in {key}; "
            '"student" has to be the number on the sheet.'
        )
    return found[0]


def listed(answers: Mapping, where: str) -> list[tuple[str, str, dict]]:
    """(channel, effect, parameters) of every answer; InputError where one cannot be meant."""
    channels = answers.get("channels") if isinstance(answers, Mapping) else None
    if isinstance(channels, Sequence) and not isinstance(channels, str):
        channels = _by_channel(channels, where)
    if isinstance(answers, Mapping) and "drive" in answers:
        channels = {"drive": answers["drive"], **(channels or {})}
    if not isinstance(channels, Mapping):
        raise InputError(f'{where}: there is no "channels"; answers look like {FORM}.')
    out = []
    for name, entry in channels.items():
        channel = _known(name, (*CHANNELS, "drive"), "channel", where)
        if isinstance(entry, Mapping) and "effect" in entry:  # one, without the brackets of a list
            entry = [entry]
        steps = entry.get("steps") if isinstance(entry, Mapping) else entry
        if not isinstance(steps, Sequence) or isinstance(steps, str):
            raise InputError(f"{where}: the answers for {channel} are no list of effects.")
        for step in steps:
            effect = step.get("effect") if isinstance(step, Mapping) else None
            parameters = _parameters(step) if isinstance(step, Mapping) else {}
            if not isinstance(effect, str) or not isinstance(parameters, Mapping):
                raise InputError(
                    f'{where}: an answer for {channel} has no "effect", or parameters that are '
                    "no names with numbers."
                )
            effect = _effect(effect, channel, where)
            place = f"{where}, {channel}, {effect}"
            out.append((channel, effect, {k: _value(v, k, place) for k, v in parameters.items()}))
    return out


def _by_channel(steps: Sequence, where: str) -> dict[str, list]:
    """One list of answers, each with its channel, sorted by channel."""
    out: dict[str, list] = {}
    for step in steps:
        if not isinstance(step, Mapping) or not isinstance(step.get("channel"), str):
            raise InputError(f'{where}: an answer has no "channel"; answers look like {FORM}.')
        out.setdefault(step["channel"], []).append(step)
    return out


def _parameters(step: Mapping):
    """The parameters of an answer, which may stand beside its effect as well."""
    given = step.get("parameters")
    return {k: v for k, v in step.items() if k not in BESIDE} if given is None else given


def plain_name(name: str) -> str:
    """A name as the sheet writes it: `Gyro X` is `gyro_x`."""
    return re.sub(r"[\s.-]+", "_", name.strip().lower())


def same_name(name: str, names) -> str | None:
    """That of the names which differs from this one in capitals, spaces and hyphens alone."""
    letters = re.sub(r"[\W_]", "", name).lower()
    return next((n for n in names if n.replace("_", "").lower() == letters), None)


def _known(name: str, names, what: str, where: str) -> str:
    plain = same_name(name, names) or plain_name(name)
    if plain not in names:
        meant = SYNONYMS.get(plain)
        near = [meant] if meant in names else get_close_matches(plain, names, 1, 0.5)
        hint = f"; is {near[0]} meant?" if near else f"; choose from {', '.join(names)}."
        raise InputError(f'{where}: there is no {what} "{name}"{hint}')
    return plain


def _effect(name: str, channel: str, where: str) -> str:
    sheet = tuple(drives.EFFECTS if channel == "drive" else hidden.EFFECTS)
    same = same_name(name, sheet) or same_name(name, _others())
    return same or _known(name, sheet, "effect", where)


def _others():
    """Names that the workflow gives beyond those on the sheets."""
    from imu_lib import drive_effects
    from imu_lib.gap.effects import CATALOGUE

    return {*CATALOGUE, *drive_effects.EFFECTS, "parameter_change"}


def _value(value, name: str, place: str):
    """A number or a list of numbers; in quotes, with a comma for its point or with an SI unit it is
    one too, with another unit it is none.
    """
    if isinstance(value, Sequence) and not isinstance(value, str):
        return [_value(v, name, place) for v in value]
    if isinstance(value, str):
        unit = SI.fullmatch(value.strip())
        number = unit[1].strip() if unit else value.strip()
        try:
            value = float(number.replace(",", ".") if COMMA.fullmatch(number) else number)
        except ValueError:
            if not any(letter.isdigit() for letter in value):
                return value  # a channel
            raise InputError(
                f'{place}: {name} is "{value}"; a number in SI units is asked for, without its '
                "unit and "
                "with a point for the decimals."
            ) from None
    if isinstance(value, float) and not math.isfinite(value):
        raise InputError(f"{place}: {name} is {value}, which is no number.")
    return value
