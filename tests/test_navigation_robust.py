"""What a real drive throws at the filter: holes, wild and late fixes, starts in motion; and real drives."""

import numpy as np
import pytest
from paper_drive import PAPER, rms, the_drive, the_path  # noqa: F401  (fixtures)

from imu_lib.drive import Drive
from imu_lib.errors import InputError
from imu_lib.model import Model
from imu_lib.navigation import (
    alignment,
    earth,
    kernel,
    models,
    outages,
    preparation,
    simulation,
)
from imu_lib.navigation.filter import FilterModel, run
from imu_lib.navigation.preparation import Gnss
from imu_lib.processes import RandomWalk, WhiteNoise
from imu_lib.record import CHANNELS

MODEL = FilterModel("18AV", PAPER, turn_on_sd=(3e-3, 0.05))


def test_gaps_in_gnss_are_bridged_and_wild_fixes_rejected(drive, path):
    plain = rms(run(drive, MODEL), drive)
    keep = (drive.gnss_time < 200.0) | (drive.gnss_time > 215.0)
    holed = drive.with_(
        **{
            k: getattr(drive, k)[keep]
            for k in (
                "gnss_time",
                "gnss_position",
                "gnss_velocity",
                "gnss_position_sd",
                "gnss_velocity_sd",
            )
        }
    )
    assert rms(run(holed, MODEL), drive) < 4.0 * plain
    wild = simulation.simulate_drive(
        path, PAPER, np.random.default_rng(20), gnss=simulation.GnssErrors(wild=0.05)
    )
    solution = run(wild, MODEL)
    assert rms(solution, wild) < 1.5 * plain and any(
        "positions rejected" in n for n in solution.notes
    )


def test_a_lost_filter_finds_back_and_says_so(drive):
    """All fixes from 250 s on are a kilometre to the north: after `patience` the filter follows
    them, not silently.
    """
    moved = drive.gnss_position.copy()
    moved[drive.gnss_time > 250.0] = earth.shift(moved[drive.gnss_time > 250.0], [1000.0, 0.0, 0.0])
    solution = run(drive.with_(gnss_position=moved), MODEL)
    last = np.array([np.interp(solution.time[-1], drive.gnss_time, c) for c in moved.T])
    assert earth.horizontal(solution.position[-1], last) < 10.0
    assert any("widened" in n for n in solution.notes)


def test_holes_in_the_imu_data(drive):
    def without(a, b):
        keep = (drive.time < a) | (drive.time >= b)
        return drive.with_(time=drive.time[keep], gyro=drive.gyro[keep], accel=drive.accel[keep])

    plain = rms(run(drive, MODEL), drive)
    short = run(without(200.0, 200.3), MODEL)
    assert rms(short, drive) < 1.5 * plain and any("bridged" in n for n in short.notes)
    long = run(without(200.0, 212.0), MODEL)
    assert (
        len(long.moments) == 2
        and rms(long, drive) < 3.0 * plain
        and any("starts anew" in n for n in long.notes)
    )
    with pytest.raises(InputError, match="hole"):
        outages.compare(without(200.0, 212.0), {"18AV": MODEL}, [(195.0, 30.0)])


def test_starts_in_motion_and_without_velocity(drive):
    moving = drive.slice(100.0, None)
    solution = run(moving, MODEL)
    assert solution.alignments[0].standstill == 0.0 and rms(solution, drive) < 1.0
    slow = run(drive.with_(gnss_velocity=None, gnss_velocity_sd=None), MODEL)
    assert rms(slow, drive) < 2.0 and np.isnan(slow.innovation[:, 3:]).all()


def test_a_covariance_that_goes_over_several_intervals_at_once_is_the_same(drive):
    plain, coarse = (run(drive, MODEL, coarse=c) for c in (0.0, 0.05))
    at_fixes = np.searchsorted(plain.time, drive.gnss_time[5:] - 1e-6)
    sd = plain.sd[at_fixes]
    assert np.abs(coarse.sd[at_fixes] / sd - 1.0).max() < 0.01
    apart = earth.meters(coarse.position[at_fixes], plain.position[at_fixes])
    assert np.abs(apart / sd[:, :3]).max() < 0.05


def test_a_mean_over_intervals_begins_with_the_first():
    mean, body = kernel._body(), kernel._body()
    mean.force[:], mean.middle[:] = np.nan, np.nan  # whatever lay there
    for number, value in enumerate((1.0, 2.0, 6.0)):
        body.force[:], body.middle[:] = value, value
        kernel._gather(mean, body, 1.0 / (number + 1))
    assert np.allclose(mean.force, 3.0) and np.allclose(mean.middle, 3.0)


def test_late_time_tags_are_put_right(path):
    late = simulation.simulate_drive(
        path, PAPER, np.random.default_rng(21), gnss=simulation.GnssErrors(latency=0.35)
    )
    assert rms(run(late, MODEL, gnss=Gnss(latency=-0.35)), late) < 0.5 * rms(run(late, MODEL), late)


def test_velocities_that_contradict_their_positions_are_not_used(drive):
    wrong = drive.gnss_velocity.copy()
    wrong[:, 1] *= -1.0
    solution = run(drive.with_(gnss_velocity=wrong), MODEL, heading=None)
    assert (
        any("disagree with their own positions" in n for n in solution.notes)
        and rms(solution, drive) < 2.0
    )


def test_refusals_say_what_and_what_to_do(drive):
    still = drive.slice(0.0, 25.0)
    with pytest.raises(InputError, match="heading"):
        run(still, MODEL)
    assert run(still, MODEL, heading=1.0).time[-1] > 20.0
    with pytest.raises(InputError, match="usable GNSS"):
        run(drive.with_(gnss_fix=np.full(drive.gnss_time.size, 1.0)), MODEL, gnss=Gnss(accept=(4,)))
    with pytest.raises(InputError, match="ends after the drive"):
        outages.compare(drive, {"18AV": MODEL}, [(350.0, 30.0)])
    with pytest.raises(InputError, match="START:DURATION"):
        outages.windows_from("100-30")
    with pytest.raises(InputError, match="no fix before it"):
        outages.compare(drive.slice(100.0, None), {"18AV": MODEL}, [(100.0, 30.0)])
    with pytest.raises(InputError, match="unknown model"):
        models.five(names=("16AV",))


def test_alignment_levels_and_finds_the_heading(drive):
    prepared = preparation.prepare(drive)
    found = alignment.align(prepared.stretches[0], prepared.fixes)
    truth = drive.reference_attitude[0]
    assert found.standstill > 20.0
    assert np.abs(found.attitude[:2] - truth[:2]).max() < 0.01  # 0.02 m/s^2 of bias is 2 mrad
    assert abs(np.angle(np.exp(1j * (found.attitude[2] - truth[2])))) < 0.05
    assert alignment.level(np.array([0.0, 0.0, -9.8])) == (0.0, 0.0)


@pytest.mark.parametrize("velocity", [True, False])
def test_a_start_in_motion_does_not_follow_a_wild_fix(drive, velocity):
    moving = drive.slice(100.0, None)
    if not velocity:
        moving = moving.with_(gnss_velocity=None, gnss_velocity_sd=None)
    plain = _start(moving)
    wild = np.flatnonzero(moving.gnss_time >= plain.used - 1e-6)[0]
    position = np.array(moving.gnss_position)
    position[wild] = earth.shift(position[wild], np.array([60.0, -60.0, 20.0]))
    changes = {"gnss_position": position}
    if velocity:
        changes["gnss_velocity"] = np.array(moving.gnss_velocity)
        changes["gnss_velocity"][wild] += [12.0, -12.0, 0.0]
    found = _start(moving.with_(**changes))
    for start in (plain, found):
        when = moving.time[0] + (start.epoch - 1) / moving.rate
        row = np.searchsorted(moving.reference_time, when)
        apart = start.attitude[2] - moving.reference_attitude[row, 2]
        assert abs(np.angle(np.exp(1j * apart))) < 0.1
        away = earth.meters(start.position, moving.reference_position[row])
        assert np.linalg.norm(away) < 15.0
    assert found.epoch != plain.epoch


def test_a_standstill_does_not_end_where_a_fix_is_wild(drive):
    plain = _start(drive)
    position, velocity = np.array(drive.gnss_position), np.array(drive.gnss_velocity)
    position[0] = earth.shift(position[0], np.array([60.0, -60.0, 20.0]))
    velocity[len(velocity) // 100] = [12.0, -12.0, 0.0]
    assert drive.gnss_time[len(velocity) // 100] < plain.standstill - 5.0
    found = _start(drive.with_(gnss_position=position, gnss_velocity=velocity))
    assert found.standstill == plain.standstill
    assert np.linalg.norm(earth.meters(found.position, drive.reference_position[0])) < 15.0
    assert found.attitude[2] == pytest.approx(plain.attitude[2], abs=0.02)


def _start(drive):
    prepared = preparation.prepare(drive)
    return alignment.align(prepared.stretches[0], prepared.fixes)


# -- real drives ----------------------------------------------------------------------------------


VEHICLE = Model(
    {
        c: WhiteNoise(N=3e-4 if c.startswith("gyro") else 0.05)
        + RandomWalk(K=3e-5 if c.startswith("gyro") else 3e-3)
        for c in CHANNELS
    },
    name="vehicle",
)


@pytest.mark.parametrize(
    "name, fixes_rms, accept",
    [("span_a", 0.74, None), ("span_b", 0.74, None), ("span_c", 2.2, (1,))],
)
def test_real_drives_with_full_gnss_are_no_worse_than_their_fixes(
    data_dir, name, fixes_rms, accept
):
    drive = Drive.load(data_dir / "drive" / f"{name}.npz")
    solution = run(
        drive,
        FilterModel("vehicle", VEHICLE, turn_on_sd=(5e-3, 0.2)),
        gnss=Gnss(velocity_floor=0.15, accept=accept),
    )
    assert rms(solution, drive) <= fixes_rms
    assert solution.time.size > 0.95 * drive.time.size


def test_a_car_without_reference_or_velocity(data_dir):
    drive = Drive.load(data_dir / "drive" / "kth_car.npz")
    solution = run(drive, FilterModel("vehicle", VEHICLE, turn_on_sd=(5e-3, 0.2)))
    at = np.column_stack(
        [np.interp(drive.gnss_time, solution.time, c) for c in solution.position.T]
    )
    assert np.sqrt(np.mean(earth.horizontal(at[5:], drive.gnss_position[5:]) ** 2)) < 3.0
