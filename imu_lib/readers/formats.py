"""Units that a format fixes: messages of ROS, exports of Xsens MT Manager, the units beside the
arrays of a MATLAB file.
"""

from __future__ import annotations

import re
from collections.abc import Iterable

from imu_lib.readers import names
from imu_lib.readers.raw import Raw

_SI = {"gyro": "rad/s", "accel": "m/s^2"}
_MESSAGE = [
    re.compile(rf"(?:^|[./_ ]){w}[./][xyz]$") for w in ("angular_velocity", "linear_acceleration")
]
_MANAGER = re.compile(r"^//.*(?:Update Rate|Filter Profile|Firmware Version|Option Flags)")


def fix(raw: Raw, headings: Iterable[str], above: Iterable[str] = ()) -> None:
    """The units that the format fixes, where the columns state none; plausibility judges them as it
    does stated ones.
    """
    heads = [h.strip().lower() for h in headings]
    if all(any(word.search(h) for h in heads) for word in _MESSAGE):
        _take(raw, _SI, "by the definition of sensor_msgs/Imu")
    manager = any(_MANAGER.match(line) for line in above)
    if manager and {"packetcounter", "acc_x", "gyr_x"} <= set(heads):
        _take(raw, _SI, "as MT Manager exports it")


def beside(raw: Raw, texts: dict[str, str]) -> None:
    """Units in a text called units beside the arrays: `deg/s, g`, or one text for each array."""
    said: dict[str, set[str]] = {"gyro": set(), "accel": set()}
    for text in texts.values():
        for part in re.split(r"[,;]|\band\b", text):
            unit = names.unit_of(part)
            for kind in said:
                if unit in names.UNITS[kind]:
                    said[kind].add(unit)
    once = {k: u.pop() for k, u in said.items() if len(u) == 1}
    _take(raw, once, f"by `{next(iter(texts), '')}`")


def _take(raw: Raw, units: dict[str, str], why: str) -> None:
    for kind, unit in units.items():
        raw.state(kind, unit, why)
