"""What may act on a drive linearly: one column per parameter, in a fixed order.

The first IMU columns enter as errors of the readings, the others in the fixes alone. Columns whose
effect begins with "other" have no place in the catalogue: where one of them wins, the answer is
`unexplained`, in its words.
"""

from dataclasses import dataclass

import numpy as np

AXES = "xyz"
_PAIRS = ("xy", "xz", "yx", "yz", "zx", "zy")


@dataclass(frozen=True)
class Column:
    """effect and component name it; prior: standard deviation of the parameter, SI."""

    effect: str
    component: str
    prior: float


def _three(effect: str, word: str, prior: float) -> list[Column]:
    return [Column(effect, f"{word} {a}", prior) for a in AXES]


def _three_ways(effect: str, prior: float) -> list[Column]:
    return [Column(effect, a, prior) for a in ("north", "east", "down")]


def _six(effect: str, gyro: float, accel: float) -> list[Column]:
    return [Column(effect, c, gyro if c.startswith("gyro") else accel) for c in CHANNEL_NAMES]


CHANNEL_NAMES = tuple(f"{s}_{a}" for s in ("gyro", "accel") for a in AXES)

#: At `State.step_at`.
STEP = "other: biases step"
IMU = (
    *_three("accel_scale", "scale", 0.03),
    *_three("gyro_scale", "scale", 0.03),
    *[Column("accel_misalignment", f"matrix {p}", 0.03) for p in _PAIRS],
    *[Column("gyro_misalignment", f"matrix {p}", 0.03) for p in _PAIRS],
    *[Column("gyro_g_sensitivity", f"matrix {a}{b}", 5e-4) for a in AXES for b in AXES],
    Column("imu_clock", "scale", 5e-4),
    *[Column("gyro_bias", f"bias {a}", 0.02) for a in AXES],
    *[Column("accel_bias", f"bias {a}", 0.5) for a in AXES],
    *_six("other: biases follow the temperature", 2e-3, 0.05),
    *_six("other: biases follow the speed", 2e-4, 0.01),
    *_six(STEP, 2e-3, 0.05),
)
#: s, of the low passes whose sum stands for any
SMOOTHED = (0.15, 0.4, 0.8, 1.6)
#: Shares of the drive after which fixes may be displaced.
DISPLACED = {"a third": 1 / 3, "half": 1 / 2, "two thirds": 2 / 3}
#: What those columns are called.
DISPLACED_AFTER = {part: f"other: fixes are displaced after {part}" for part in DISPLACED}
#: At `State.moved_at`.
MOVED = "other: fixes are displaced from one time on"
FIX = (
    Column("gnss_time_offset", "offset", 0.5),
    Column("gnss_time_offset", "velocity_offset", 0.5),
    *_three("lever_arm", "arm", 1.5),
    *[Column("other: receiver's velocity is smoothed", f"{tau} s", 1.0) for tau in SMOOTHED],
    *[c for displaced in DISPLACED_AFTER.values() for c in _three_ways(displaced, 5.0)],
    *_three_ways("other: receiver's velocity is offset", 0.3),
    *_three_ways(MOVED, 5.0),
)
ALL = IMU + FIX
#: Numbers of those that enter in the fixes, the clock of the readings among them.
IN_FIXES = (IMU.index(Column("imu_clock", "scale", 5e-4)), *range(len(IMU), len(ALL)))
#: Columns of each effect of the file format, and of each cause outside it.
GROUPS: dict[str, list[int]] = {}
for _i, _c in enumerate(ALL):
    GROUPS.setdefault(_c.effect, []).append(_i)
PRIOR = np.array([c.prior for c in ALL])
INDEX = {(c.effect, c.component): i for i, c in enumerate(ALL)}


def in_path(effect: str) -> bool:
    """Whether a path is built without what an effect does to the drive, as of all of the catalogue;
    other causes are taken out of the innovations, which is enough where they are small.
    """
    return not effect.startswith("other") or effect in (MOVED, *DISPLACED_AFTER.values())


def of(effect: str) -> list[int]:
    """Column numbers of an effect, in the order of its parameter."""
    return [i for i, c in enumerate(ALL) if c.effect == effect]
