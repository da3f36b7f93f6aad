"""A random record in a random dress comes back equal, or is asked about; never another value."""

import log_writer
import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st
from log_writer import Plan

from imu_lib.errors import InputError
from imu_lib.readers import read

PLANS = st.builds(
    Plan,
    stamps=st.sampled_from(log_writer.STAMPS),
    rate=st.sampled_from(
        [10.0, 20.0, 50.0, 62.5, 100.0, 125.0, 200.0, 250.0, 400.0, 500.0, 1000.0]
    ),
    n=st.sampled_from([360, 401, 1200]),
    named_time=st.booleans(),
    gyro_unit=st.sampled_from(list(log_writer.GYRO)),
    accel_unit=st.sampled_from(list(log_writer.ACCEL)),
    unit_style=st.sampled_from(["brackets", "round", "row", "flag"]),
    names=st.sampled_from(list(log_writer.NAMES)),
    delimiter=st.sampled_from([",", ";", "\t", "|", " "]),
    comma=st.booleans(),
    order=st.permutations([0, 1, 2]).map(tuple),
    extras=st.lists(st.sampled_from(["mag", "text", "temp", "roll"]), unique=True).map(tuple),
    layout=st.sampled_from(["plain", "plain", "held", "interleaved", "twice"]),
    held_by=st.sampled_from([2, 3, 4, 5, 8]),
    dress=st.sampled_from(
        [
            "plain",
            "plain",
            "comment",
            "preamble",
            "quoted",
            "bom",
            "crlf",
            "utf-16",
            "footer",
            "labels",
            "cells",
        ]
    ),
    gap=st.sampled_from([0, 0, 3, 40]),
    seed=st.integers(0, 10_000),
)


COARSE = ("coarse", "ticks_64", "six_digits", "single", "frames", "packets")


def possible(plan):
    """Whether the dress can hold the record at all."""
    if plan.stamps in COARSE and (plan.gap or plan.layout != "plain" or plan.dress == "labels"):
        return False
    if plan.stamps == "frames" and not (
        plan.rate >= 25 and 1.5 * plan.rate < plan.n < 55 * plan.rate
    ):
        return False
    if plan.stamps == "ticks_64" and (plan.rate > 400 or plan.n < 400):
        return False
    if plan.stamps == "packets" and plan.rate < 40:
        return False
    if plan.comma and plan.delimiter == ",":
        return False
    if plan.stamps in ("ms", "boot_ms", "epoch_ms", "colon_ms") and plan.rate > 500 and plan.gap:
        return False
    if plan.layout == "twice" and plan.stamps in ("none", "coarse"):
        return False  # nothing tells that a row is there twice
    if plan.gap and (plan.stamps == "none" or plan.layout in ("held", "interleaved")):
        return False
    if plan.stamps == "coarse" and (plan.gap or plan.rate < 40 or plan.layout != "plain"):
        return False
    if plan.delimiter == " " and (
        plan.layout == "interleaved"
        or plan.unit_style in ("brackets", "round")
        or plan.names in ("board", "phone", "german")
        or plan.stamps in ("ampm", "two_times", "day", "short_year")
        or " " in plan.gyro_unit
        or plan.extras
    ):
        return False  # blanks inside of fields, or empty ones
    if plan.dress in ("labels", "cells"):
        one = plan.dress == "cells"
        if plan.comma or plan.layout != "plain" or plan.extras or plan.unit_style == "row":
            return False
        if one and (plan.delimiter == " " or plan.names in ("zero", "one", "brackets", "omega")):
            return False
        if not one and (plan.stamps not in ("s", "us", "ms", "ns") or plan.unit_style != "flag"):
            return False
    if plan.delimiter == "|" and plan.stamps == "ampm" and plan.comma:
        return False
    return True


def equal(found, plan):
    """What is wrong with a record that was read, or an empty text."""
    t, gyro, accel = log_writer.truth(plan)
    record = found.record
    rate, rows = plan.rate, np.arange(plan.n)
    grain = {
        "coarse": 0.1,
        "ticks_64": 1 / 64,
        "six_digits": 0.1,
        "single": 1e-3,
        "frames": 0.04,
        "packets": 1.2 / rate,
        "ms": 1e-3,
        "boot_ms": 1e-3,
        "epoch_ms": 1e-3,
        "colon_ms": 1e-3,
    }.get(plan.stamps, 2e-6)
    if plan.layout == "interleaved":
        rate = plan.rate / 2 if plan.stamps not in ("none", "counter") else record.rate
        rows = rows[::2]
    # the clock's grain over the length of the record is how well stamps can tell the rate
    if abs(record.rate / rate - 1) > 1e-6 + 1.5 * grain / (t[-1] - t[0]):
        return f"rate {record.rate} instead of {rate}"
    for kind, right in (("gyro", gyro), ("accel", accel)):
        if f"{kind}_x" not in record:
            return f"{kind} is missing"
        x = record[kind]
        if plan.layout == "held" and kind == "accel":
            x, right = x[np.isfinite(x).all(axis=1)], right[:: plan.held_by]
        if plan.layout == "interleaved":
            offset = 0 if kind == "gyro" else 1
            right = right[offset::2][: len(x)]
        if len(x) < len(right) - 2 or len(x) > len(right):
            return f"{kind}: {len(x)} samples instead of {len(right)}"
        if not np.allclose(x, right[: len(x)], rtol=1e-7, atol=1e-9):
            return f"{kind} differs"
    if plan.gap and sum(g.missing for g in record.gaps()) != plan.gap:
        return f"{sum(g.missing for g in record.gaps())} missing instead of {plan.gap}"
    return ""


def verdict(path, plan):
    """What went wrong with one record in one dress, or an empty text."""
    answers = log_writer.write(path, plan)
    units = {k: v for k, v in answers.items() if k.endswith("unit") and k != "time_unit"}
    try:
        wrong = equal(read(path, **units), plan)
        if wrong:
            return f"{wrong} in silence"
    except InputError:
        pass
    return equal(read(path, **answers), plan)  # and what is asked for is enough


@settings(max_examples=40, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
@given(plan=PLANS)
def test_a_record_in_any_dress_comes_back_or_is_asked_about(tmp_path, plan):
    assume(possible(plan))
    wrong = verdict(tmp_path / "log.csv", plan)
    if wrong:
        pytest.fail(f"{wrong}: {plan}")
