"""What the verdict says of a given model: its events of another day, and what it already holds."""

from types import SimpleNamespace

import numpy as np

from imu_lib import gap
from imu_lib.gap.sentences import given_model
from imu_lib.gap.sentences.summary import sentences
from imu_lib.model import Model
from imu_lib.processes import CommonMode
from imu_lib.record import Record

FS, N = 50.0, 15_000
WHITE = {"process": "white_noise", "N": 1e-4}


def verdict(x, *more):
    model = Model.from_json({"gyro_x": [WHITE, *more], "gyro_y": [WHITE]})
    noise = 1e-4 * np.sqrt(FS) * np.random.default_rng(3).standard_normal((2, N))
    found = gap.close(
        Record({"gyro_x": noise[0] + x, "gyro_y": noise[1]}, FS), model, simulations=0
    )
    return " ".join(sentences(found))


def test_a_jump_of_the_model_that_the_record_lacks_is_no_jump_of_the_record():
    t = np.arange(N) / FS
    jump = {"process": "step", "time": 180.0, "amplitude": 2e-3}
    text = verdict(np.zeros(N), jump)
    assert "jumped" not in text
    assert "The record does not have the given model's step on gyro_x" in text
    text = verdict(2e-3 * (t > 180.0), jump)
    assert "does not have" not in text and "already holds step on gyro_x" in text
    assert "jumped on gyro_x at 100 s" in verdict(2e-3 * (t > 180) + 2e-3 * (t > 100), jump)


def test_a_transient_that_the_model_holds_is_said():
    t = np.arange(N) / FS
    text = verdict(
        2e-3 * np.exp(-t / 60.0), {"process": "warm_up", "amplitude": 2e-3, "time_constant": 60.0}
    )
    assert "The given model already holds warm up on gyro_x" in text
    assert "it shows nothing more" in text


def test_what_is_absent_is_not_held_where_it_was_made_anew():
    """A long record's views make their models anew: equal processes are one, not the same object."""

    def common(N):
        return CommonMode(N=N, channels=("gyro_x", "gyro_y"))

    found = SimpleNamespace(
        absent=(SimpleNamespace(process=common(1e-4)),),
        model=SimpleNamespace(record=()),
        base=SimpleNamespace(record=(common(1e-4), common(2e-4))),
    )
    assert given_model._seen(found) == [common(2e-4)]
