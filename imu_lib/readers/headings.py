"""A heading taken apart: its words, its unit, an axis in brackets."""

from __future__ import annotations

import re

from imu_lib.readers import lexicon
from imu_lib.readers.spelling import plain, unit_of

#: A heading that says by what its readings were multiplied, behind their unit.
_TIMES = re.compile(
    r"^(.+?)[_ ]((?:m?dps|rads?|mg|g|deg_?s|rad_?s|m_?s2|mss))[_ ]*[x*×](10{1,6})$", re.IGNORECASE
)


def split(name: str) -> tuple[str, str | None, str | None]:
    """A heading without its unit, the unit as spelled, and an axis that stands in brackets."""
    text = plain(str(name)).strip("\ufeff \t").lstrip("#%").strip().strip("\"'").strip()
    unit = axis = None
    piped = re.match(r'^([^|]+?)"?\|"?([^|"]*)"?\|', text)
    if piped and unit_of(piped[2]):  # a logger's name|unit|least|most|rate
        text, unit = piped[1], piped[2]
    text = re.sub(r"\s*\([^)]*\bS/?N\b[^)]*\)", "", text)  # a logger's serial numbers
    brackets = [b.strip() for b in re.findall(r"[\[({<]([^\])}>]*)[\])}>]", text)]
    for spelled in sorted(brackets, key=lambda b: unit_of(b) is None):  # a known unit goes first
        if re.fullmatch(r"[xyzXYZ0-3]", spelled):
            axis = spelled.lower()
        elif not spelled or spelled == "-":
            pass
        elif unit is None and (unit_of(spelled) or re.fullmatch(r"x80\d\d", spelled)):
            unit = spelled
        elif unit is None and not _tokens(spelled) & lexicon.REMARKS and not _known(spelled):
            unit = spelled
    # a remark in brackets stays a word of the name; a unit does not
    text = re.sub(
        r"[\[({<]([^\])}>]*)[\])}>]",
        lambda m: (
            "" if m[1].strip() in (unit, "-", "") or m[1].strip().lower() == axis else f" {m[1]} "
        ),
        text,
    )
    if unit is None and (tail := re.match(r"^(.+?)[_ .-]+([^\s_]*/\S+)$", text)):
        if unit_of(tail[2]):  # gyro_x_rad/s
            text, unit = tail[1], tail[2]
    if unit is None and (tail := _TIMES.match(text)):
        text, unit = tail[1], f"{tail[2]}*{tail[3]}"  # gx_dps_x10
    if unit is None:
        tail = re.match(r"^(.*?\S)\s*(?:,|/|\bin\b|:|\|)\s*(\S+(?:\s?\S+){0,4})$", text)
        if tail and unit_of(tail[2]) and len(tail[1]) > 0:
            text, unit = tail[1], tail[2]
    return text.strip(), unit, axis


def _tokens(text: str) -> set[str]:
    return set(re.split(r"[^0-9a-z]+", lexicon.without_accents(text).lower())) - {""}


def _known(text: str) -> bool:
    tokens = _tokens(text)
    return bool(
        tokens
        & (lexicon.GYRO | lexicon.ACCEL | lexicon.TEMPERATURE | set(lexicon.NOT))
        - {*lexicon.LETTERS, "t"}
    )


def key(text: str) -> str:
    """lower_case words set apart by `_`, camel case opened."""
    text = re.sub(
        r"^gF_?(?=[xyzXYZ]$)", "gforce_", lexicon.without_accents(text)
    )  # a phone's g-force
    text = re.sub(r"(?<=[a-z])(?=[A-Z][a-z])", "_", text)  # GyroData
    text = re.sub(
        r"(?<=[a-z])(?=[A-Z]{2,})|(?<=[a-z]{2})(?=[A-Z](?![A-Za-z0-9]))", "_", text
    )  # gyroADC, gyroX
    text = re.sub(r"(?<=_[XYZ])(?=[A-Z][a-z])", "_", text)  # Gyro_XRadPerSec
    text = re.sub(
        r"(?<=[\u0400-\uffff])(?=[A-Za-z0-9])|(?<=[A-Za-z0-9])(?=[\u0400-\uffff])", "_", text
    )
    text = re.sub(r"[^0-9A-Za-z\^\u0080-\uffff]+", "_", text).strip("_")
    return text.lower()
