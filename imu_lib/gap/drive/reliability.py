"""How sure a name is: as often as names like it were right on blind drives.

A name's weight among its rivals says how much likelier it is than they, if one of them is true and
the filter is right. How often it is right is counted (`benchmarks/drive_gap_score.py`), apart for
names of full weight, for lesser ones, for names beside a cause outside the catalogue with which the
innovations are those of a right filter, and for names beside innovations that are not. An effect
that was found often has its own share; one found seldom, that of all.
"""

from typing import Any

#: Weight from which on a name counts as of full weight.
FULL = 0.99
#: The stored scores that are counted, benchmarks/results/drive_gap_score_NAME.json: 134 drives,
#: with a model of the sensors and without.
SOURCES = ("third", "outages", "fourth", "free")
#: Findings of other effects count for as many of its own.
SHARED = 4.0
#: {class: {effect: (found, right)}}
COUNTED: dict[str, dict[str, tuple[int, int]]] = {
    "full": {
        "accel_bias": (3, 3),
        "accel_misalignment": (6, 6),
        "accel_scale": (8, 8),
        "axes": (6, 6),
        "bias_model": (1, 1),
        "gnss_correlated": (7, 7),
        "gnss_noise": (8, 8),
        "gnss_outliers": (10, 10),
        "gnss_time_offset": (5, 5),
        "gyro_bias": (4, 4),
        "gyro_g_sensitivity": (4, 4),
        "gyro_misalignment": (5, 5),
        "gyro_scale": (4, 4),
        "heading": (4, 4),
        "imu_clock": (1, 1),
        "lever_arm": (8, 7),
        "mounting": (19, 17),
        "vibration": (7, 7),
    },
    "lesser": {
        "accel_misalignment": (1, 0),
        "bias_model": (2, 2),
        "gnss_correlated": (1, 1),
        "gnss_noise": (2, 2),
        "gyro_scale": (1, 1),
    },
    "beside cause": {
        "heading": (1, 0),
        "mounting": (4, 3),
    },
    "beside": {
        "accel_bias": (1, 1),
        "bias_model": (1, 1),
        "gnss_correlated": (1, 1),
        "gnss_time_offset": (1, 1),
        "gyro_scale": (1, 0),
        "lever_arm": (1, 0),
        "mounting": (2, 2),
    },
}


def kind(weight: float, left: str | None) -> str:
    """The class of a name of that weight; left: of `left`."""
    if left is not None:
        return left
    return "full" if weight >= FULL else "lesser"


def left(unexplained: str | None, right: bool) -> str | None:
    """The class of all names of a drive on which something is left, else None; right: whether the
    innovations are those of a right filter nevertheless.
    """
    if unexplained is None:
        return None
    return "beside cause" if right else "beside"


def share(effect: str, weight: float, left: str | None) -> float:
    """Expected share of right names among further ones like it (Laplace's rule, for an effect
    drawn to the share of its class).
    """
    counted = COUNTED[kind(weight, left)]
    found, right = (sum(c[k] for c in counted.values()) for k in (0, 1))
    of_class = (right + 1.0) / (found + 2.0)
    found, right = counted.get(effect, (0, 0))
    return (right + SHARED * of_class) / (found + SHARED)


def give(found: list[dict[str, Any]], left: str | None) -> None:
    """Give steps their confidence, and the runner-up what that leaves; left: of `left`."""
    for step in found:
        sure = share(step["effect"], step["weight"], left)
        step["confidence"] = sure
        step["runner_up"]["confidence"] = min(step["runner_up"]["confidence"], 1.0 - sure)
