"""What a verdict says of effects: all of a short record, a part and the means of a long one."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np

from imu_lib import report, verdict
from imu_lib.cli.gap_drive import values
from imu_lib.estimate import Estimate
from imu_lib.gap.table import describe
from imu_lib.processes import WhiteNoise
from imu_lib.record import Record
from imu_lib.verdict import missing
from imu_lib.verdict.datasheet import bias_instability, coefficient
from imu_lib.verdict.missing import averaged


def test_means_of_blocks():
    record = Record({"gyro_x": np.arange(10.0)}, 2.0, temperature=np.arange(10.0))
    found = averaged(record, 4)
    assert found["gyro_x"].tolist() == [1.5, 5.5] == found.temperature.tolist()
    assert found.rate == 0.5


def test_a_long_record_is_looked_at_twice(monkeypatch):
    """With small limits: the rounding is seen in the part, the jump, which lies behind it, in the
    means.
    """
    import sys

    room = sys.modules["imu_lib.verdict.missing"]
    for name, value in (("LONGEST", 8000), ("PART", 6000), ("MEANS", 2000)):
        monkeypatch.setattr(room, name, value)
    x = WhiteNoise(N=1e-3).simulate(40_000, 50.0, np.random.default_rng(3))
    x[25_000:] += 2e-3
    lsb = 5e-3
    found = missing(Record({"gyro_x": lsb * np.round(x / lsb)}, 50.0))
    (_, part), (_, means) = found.looks
    named = [[s.effect for s in r.channels["gyro_x"].result.steps] for r in (part, means)]
    assert "resolution" in named[0] and named[1] == ["step"]
    (step,) = means.channels["gyro_x"].result.steps
    assert abs(step.parameters["time"] - 500.0) < 5.0, describe(step, "gyro_x")
    assert "first 2 min" in found.note and "means of 20 samples" in found.note


class Quiet:
    findings = ()


def test_alike_findings_are_said_once():
    rng = np.random.default_rng(4)
    lsb = 5e-3
    record = Record(
        {
            f"gyro_{a}": lsb * np.round(WhiteNoise(N=1e-3).simulate(6000, 50.0, rng) / lsb)
            for a in "xy"
        },
        50.0,
    )
    found = missing(record)
    lines = verdict.anomalies(Quiet, found)
    (told,) = [line for line in lines if line.startswith("Resolution")]
    assert "gyro_x, gyro_y: lsb" in told
    x = found.looks[0][1].channels["gyro_x"]  # a name that is one of many is no finding
    x.result.steps[:] = [replace(s, confidence=0.02) for s in x.result.steps]
    lines = verdict.anomalies(Quiet, found)
    (told,) = [line for line in lines if line.startswith("Resolution")]
    assert "gyro_x" not in told and "gyro_y: lsb" in told
    assert any("not sure" in line and "resolution (gyro_x)" in line for line in lines)
    for channel in found.looks[0][1].channels.values():
        channel.result.steps[:] = [replace(s, confidence=0.02) for s in channel.result.steps]
    lines = verdict.anomalies(Quiet, found)
    assert not any(line.startswith("Resolution") for line in lines)
    assert any("not sure" in line and "resolution (gyro_x, gyro_y)" in line for line in lines)


def test_what_acts_on_several_channels_is_one_sentence():
    knock = SimpleNamespace(
        effect="disturbance",
        parameters={"start": 43.9, "duration": 0.7},
        where="A knock at 43.9 s.",
    )
    common = SimpleNamespace(
        effect="common_mode",
        parameters={"N": 0.1, "channels": ["accel_y", "accel_z"]},
        where="coherence between accel_y, accel_z",
    )
    look = SimpleNamespace(
        channels={}, record_steps=[knock, common], record_unexplained=None, stretch=(7.0, 90.0)
    )
    found = SimpleNamespace(looks=[("it", look)], note="")
    lines = verdict.anomalies(Quiet, found)
    assert lines[0] == "A knock at 43.9 s." and lines[-1].endswith("it count from 7 s of it on.")
    told = SimpleNamespace(findings=("A knock at 43.9 s. It is masked.",))
    assert sum("A knock" in line for line in verdict.anomalies(told, found)) == 1
    assert lines[1].startswith("Noise in common: N 6 m/s/sqrt(h)") and lines[1].endswith(
        "accel_y, accel_z."
    )


def test_what_two_looks_find_is_told_once():
    def look(*steps):
        of = [
            SimpleNamespace(effect=e, parameters=p, cause="", where="", confidence=1.0)
            for e, p in steps
        ]
        channel = SimpleNamespace(result=SimpleNamespace(steps=of, unexplained=None))
        return SimpleNamespace(
            channels={"gyro_x": channel}, record_steps=[], record_unexplained=None, stretch=None
        )

    jump, again, later = (
        ("step", {"amplitude": 1e-4, "time": time}) for time in (180.6, 180.4, 900.0)
    )
    found = SimpleNamespace(
        looks=[("the first 5 min", look(jump)), ("the means", look(again, later))], note=""
    )
    (line,) = verdict.anomalies(Quiet, found)
    assert "180.6" in line and "180.4" not in line and "900" in line


def test_limits_are_of_what_the_datasheet_prints_and_of_the_part_it_is_from():
    shown, limit = Estimate(3e-5, 2e-5, 4e-5), Estimate(None, 0.0, 6e-5)
    channel = SimpleNamespace(
        likelihood={"B": shown, "K": limit},  # K stands in the datasheet as a limit
        allan={"B": limit, "K": shown},
        choice=SimpleNamespace(p_value=0.5),
    )
    assert coefficient(channel, "K") is limit and coefficient(channel, "B") is shown
    result = SimpleNamespace(channels={"gyro_x": channel})
    part = Record({"gyro_x": np.zeros(2501)}, 100.0)
    health = SimpleNamespace(clock=SimpleNamespace(duration=60.0), channels={})
    first, *others = verdict.limits(part, result, health)
    assert first.startswith("Of its 60 s the numbers use one stretch of 25 s")
    assert "Of the gyros it shows no K, only upper limits." in others


def test_the_bias_instability_is_that_of_the_chosen_sum():
    """Where the likelihood has flicker noise the datasheet does not say that none shows."""
    shown, limit = Estimate(3e-5, 2e-5, 4e-5), Estimate(None, 0.0, 6e-5)
    channel = SimpleNamespace(likelihood={"B": shown}, allan={"B": limit})
    assert bias_instability(channel) is shown
    assert bias_instability(SimpleNamespace(likelihood={}, allan={"B": limit})) is limit


def test_an_effect_begins_a_sentence():
    assert verdict.effect_name("gnss_time_offset") == "GNSS time offset"
    assert verdict.effect_name("imu_clock") == "IMU clock"
    assert verdict.effect_name("lever_arm") == "Lever arm"
    assert verdict.effect_name("gauss_markov_2") == "Gauss-Markov process of second order"


def test_what_was_found_on_a_drive_has_units_and_axes():
    arm = {
        "effect": "lever_arm",
        "parameters": {"arm": [1.0, 0.5, -1.0]},
        "intervals": {"arm": [[0.9, 1.1], [0.4, 0.6], [-1.2, -0.8]]},
    }
    assert values(arm) == "x 1 [0.9, 1.1], y 0.5 [0.4, 0.6], z -1 [-1.2, -0.8] m"
    turned = {"effect": "mounting", "parameters": {"yaw": np.pi / 6}, "intervals": {}}
    assert values(turned) == "yaw 30 deg"
    loud = {
        "effect": "vibration",
        "parameters": {"channel": "gyro_z", "N": 1e-3, "N_per_speed": 1e-4},
        "intervals": {},
    }
    assert values(loud).endswith("N per speed 0.0001 rad/s/sqrt(Hz) per m/s")


def test_a_tiny_probability_is_a_bound():
    assert report.probability(0.0) == report.probability(5e-275) == "< 1e-9"
    assert report.probability(0.5432) == "0.54" and report.probability(None) == "-"
