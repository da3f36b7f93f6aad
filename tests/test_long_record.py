"""A record that stays on disk gives what the record in memory gives."""

import json
import sys

import numpy as np
import pytest

from imu_lib import InputError, characterise, faults, long_record, readers
from imu_lib.characterise import still
from imu_lib.faults import standing
from imu_lib.model import Model
from imu_lib.record import Record
from imu_lib.writers import arrays, write_record

FS, N = 200.0, 400_000
LEAST = 1 << 16  # samples from which on these tests call a record long

MODEL = Model.from_json(
    {
        "gyro_x": [
            {"process": "constant", "value": 0.01},
            {"process": "white_noise", "N": 1e-4},
            {"process": "gauss_markov", "sigma": 2e-4, "correlation_time": 20.0},
        ],
        "accel_z": [
            {"process": "constant", "value": -9.8},
            {"process": "white_noise", "N": 1e-3},
            {"process": "random_walk", "K": 1e-5},
        ],
    }
)


@pytest.fixture
def short(monkeypatch):
    """Records of 65,536 samples count as long."""
    monkeypatch.setattr(sys.modules["imu_lib.long_record.opening"], "LONG", LEAST)
    monkeypatch.setattr(sys.modules["imu_lib.characterise.channel"], "SUMMED", LEAST)
    monkeypatch.setattr(sys.modules["imu_lib.characterise.channel"], "SHORTEST", LEAST // 4)


@pytest.fixture(scope="module")
def signals():
    return MODEL.simulate(N, FS, np.random.default_rng(2))


def saved(record, path):
    if path.suffix == ".npz":  # not compressed: read where it lies
        np.savez(path, **arrays(record))
    else:
        write_record(record, path)
    return path


def test_a_part_of_a_long_file_stays_on_disk(signals, tmp_path):
    # a manifest's line with start and stop read the whole file into memory
    path = saved(Record(signals, FS), tmp_path / "r.npz")
    part = long_record.on_disk(path, start=100.0, stop=1500.0, least=LEAST)
    assert part.rows - part.begin == 1400 * FS and long_record.worth_it(part, LEAST) is part
    short = long_record.worth_it(long_record.on_disk(path, stop=100.0, least=LEAST), LEAST)
    assert np.array_equal(short["gyro_x"], signals["gyro_x"][: int(100 * FS)])
    with pytest.raises(InputError, match="not after"):
        long_record.on_disk(path, start=5.0, stop=5.0)


def holed(signals):
    """A record with a long gap, a short one and a few numbers missing."""
    keep = np.ones(N, dtype=bool)
    keep[250_000:260_000] = False
    keep[100_000:100_004] = False
    time = np.arange(N)[keep] / FS
    channels = {c: x[keep].copy() for c, x in signals.items()}
    for x in channels.values():
        x[50_000:50_003] = np.nan
    return Record(channels, FS, time=time)


def numbers(result):
    """Every coefficient, by its path."""
    out = {}

    def walk(value, path):
        if isinstance(value, dict):
            for key, entry in value.items():
                walk(entry, (*path, key))
        elif isinstance(value, list):
            for key, entry in enumerate(value):
                walk(entry, (*path, key))
        elif isinstance(value, float):
            out[path] = value

    for name, channel in result.channels.items():
        walk(channel.to_json(), (name,))
    return out


@pytest.mark.parametrize(("suffix", "gaps"), [(".parquet", True), (".npz", False)])
def test_characterised_on_disk_as_in_memory(suffix, gaps, signals, short, tmp_path):
    record = holed(signals) if gaps else Record(signals, FS)
    path = saved(record, tmp_path / f"record{suffix}")
    on_disk = long_record.open_long(path)
    assert on_disk is not None and on_disk.rate == FS
    in_memory = readers.read_record(path)
    assert on_disk.duration == pytest.approx(in_memory.duration)
    if gaps:
        assert [g[2] for g in on_disk.gaps() if g[2] > 4] == [10_000]
        assert len([note for note in on_disk.notes if "no number in" in note]) == 1
    a = numbers(characterise.characterise(in_memory, workers=1))
    b = numbers(characterise.characterise(on_disk, workers=1))
    assert set(a) == set(b) and len(a) > 60
    for path_, value in a.items():
        assert b[path_] == pytest.approx(value, rel=1e-9, nan_ok=True), path_


def test_units_and_counts_are_those_of_the_file(signals, short, tmp_path):
    """A column in deg/s, one in g, and integers of a stated scale."""
    import pyarrow as pa
    from pyarrow import parquet

    rate = np.rad2deg(signals["gyro_x"])
    table = pa.table(
        {
            "time [ms]": np.arange(N) * 5,
            "gyro_x [deg/s]": rate,
            "accel_z [g]": signals["accel_z"] / 9.80665,
        }
    )
    parquet.write_table(table, tmp_path / "units.parquet")
    record = long_record.open_long(tmp_path / "units.parquet")
    assert record.rate == 200.0
    got = np.concatenate(list(record.pieces("gyro_x", record.runs)))
    np.testing.assert_allclose(got, signals["gyro_x"], rtol=1e-12)
    got = np.concatenate(list(record.pieces("accel_z", record.runs)))
    np.testing.assert_allclose(got, signals["accel_z"], rtol=1e-12)


def test_what_the_readers_do_more_than_scale_is_left_to_them(signals, short, tmp_path):
    """Jittering stamps, repeats: no LongRecord, the ordinary way."""
    rng = np.random.default_rng(1)
    time = np.arange(N) / FS + 1e-3 * rng.random(N)
    path = saved(Record(signals, FS, time=time), tmp_path / "jitter.npz")
    assert long_record.open_long(path) is None
    assert long_record.open_long(path, start=3.0) is None
    assert long_record.open_long(tmp_path) is None


def test_command_on_disk(signals, short, tmp_path, capsys, monkeypatch):
    from imu_lib import stream
    from imu_lib.cli.main import main

    monkeypatch.setattr(stream, "LONG", LEAST)
    path = saved(Record(signals, FS), tmp_path / "record.parquet")
    call = ["characterise", str(path), "--workers", "1", "--json", str(tmp_path / "r.json")]
    assert main(call) == 0
    said = json.loads((tmp_path / "r.json").read_text())
    assert said["channels"]["gyro_x"]["likelihood"]["N"]["value"] == pytest.approx(1e-4, rel=0.01)


def test_infinite_value_is_named(signals, short, tmp_path):
    import pyarrow as pa
    from pyarrow import parquet

    from imu_lib import InputError

    x = signals["gyro_x"].copy()
    x[300_000] = np.inf
    parquet.write_table(
        pa.table({"time [s]": np.arange(N) / FS, "gyro_x [rad/s]": x}), tmp_path / "inf.parquet"
    )
    with pytest.raises(InputError, match="row 300001"):
        long_record.open_long(tmp_path / "inf.parquet")


def test_checked_on_disk_as_in_memory(signals, short, tmp_path, monkeypatch):
    """The same numbers; a knock is told with the part that shows it."""
    from imu_lib import health

    monkeypatch.setattr(sys.modules["imu_lib.health.long"], "PART", 1 << 17)
    channels = {c: x.copy() for c, x in signals.items()}
    channels["accel_z"][300_000:300_200] += 3.0 * np.hanning(200)
    path = saved(Record(channels, FS), tmp_path / "record.parquet")
    long = health.of_long(long_record.open_long(path))
    whole = health.of_record(readers.read_record(path, trust_units=True))
    assert long.clock.samples == whole.clock.samples
    assert long.clock.duration == pytest.approx(whole.clock.duration)
    for name, channel in whole.channels.items():
        other = long.channels[name]
        assert (other.low, other.high, other.nan) == (channel.low, channel.high, channel.nan)
        assert other.mean == pytest.approx(channel.mean, rel=1e-4)
        assert other.noise == pytest.approx(channel.noise, rel=0.02)
    assert [f.kind for f in long.faults] == [f.kind for f in whole.faults] == ["disturbance"]
    assert long.faults[0].start == pytest.approx(whole.faults[0].start, abs=1.0)
    assert long.faults[0].sentence.startswith("--start 1310.72 --stop ")
    assert long.motion.state == whole.motion.state


def test_a_coarse_grid_is_said_on_disk_as_in_memory(signals, short, tmp_path):
    """Steps of ten times the scatter, on a drift over many of them."""
    from imu_lib import health
    from imu_lib.characterise import causes

    x = 0.1 * np.rint(10 * (signals["gyro_x"] / np.std(signals["gyro_x"]) * 0.03))
    path = saved(Record({"gyro_x": x, "accel_z": signals["accel_z"]}, FS), tmp_path / "a.parquet")
    whole = readers.read_record(path, trust_units=True)
    long = long_record.open_long(path, trust_units=True)
    for said in (causes.coarse(whole, whole.channel_names), causes.of_parts(long, ("gyro_x",))):
        assert any("gyro_x" in s and "coarser" in s for s in said)
    for found in (health.of_record(whole), health.of_long(long)):
        assert any("coarser than its scatter" in f for f in found.findings)


def test_a_folder_of_logs_is_one_record(signals, tmp_path):
    """Four logs: the second goes on where the first ends, the third after a pause, the fourth after
    a restart."""
    from imu_lib.long_record import open_folder

    x, n = signals["gyro_x"], 5000
    starts = (1000.0, 1000.0 + n / FS, 1000.0 + 2 * n / FS + 60.0, 0.0)
    for k, start in enumerate(starts):
        lines = ["time [s],gyro_x [rad/s]"]
        lines += [f"{start + i / FS:.3f},{x[k * n + i]:.9g}" for i in range(n)]
        (tmp_path / f"log{k}.csv").write_text("\n".join(lines) + "\n")
    record = open_folder(tmp_path, trust_units=True)
    assert record.rate == FS and record.rows == 4 * n
    got = np.concatenate(list(record.pieces("gyro_x", record.runs[:1])))
    np.testing.assert_allclose(got, x[: 2 * n], rtol=1e-8)
    gaps = [g[2] for g in record.time_gaps()]
    assert gaps == [60 * FS] and record.seams == (3 * n,)  # how long a pause is not known
    assert "log3.csv" in record.notes[-1] and "begins anew" in record.notes[-1]
    whole = record.in_memory()
    assert [g.missing for g in whole.gaps()] == gaps and whole.n == 4 * n
    assert whole.slice(whole.times()[n]).seams == (2 * n,) and not whole.take(slice(n)).seams
    later = whole.slice(whole.times()[2 * n])  # of two logs neither stretch reaches into the other
    assert faults.sound(later).record.n == n


def test_logs_that_do_not_belong_together(signals, tmp_path):
    from imu_lib import InputError
    from imu_lib.long_record import open_folder

    one = Record({"gyro_x": signals["gyro_x"][:3000]}, FS)
    write_record(one, tmp_path / "log1.npz")
    write_record(Record({"accel_z": signals["accel_z"][:3000]}, FS), tmp_path / "log2.npz")
    with pytest.raises(InputError, match="log2.npz has the channels accel_z"):
        open_folder(tmp_path, trust_units=True)
    write_record(Record({"gyro_x": signals["gyro_x"][:3000]}, 100.0), tmp_path / "log2.npz")
    with pytest.raises(InputError, match="one rate"):
        open_folder(tmp_path, trust_units=True)
    write_record(one, tmp_path / "another.npz")
    assert open_folder(tmp_path, trust_units=True) is None  # not a row of logs


def test_a_part_is_cut_without_reading_the_rest(signals, tmp_path):
    """--start and --stop on disk are those of the record in memory, gaps between them too."""
    from imu_lib.long_record import cut

    whole = holed(signals)
    path = saved(whole, tmp_path / "a.npz")
    record = long_record.open_long(path, least=LEAST)
    for start, stop in ((None, 300.0), (240.0, 1310.0), (499.995, None), (1240.0, 1260.0)):
        part, want = cut(record, start, stop).in_memory(), whole.slice(start, stop)
        assert part.n == want.n
        np.testing.assert_array_equal(part.slots(), want.slots())
        np.testing.assert_array_equal(part["gyro_x"], want["gyro_x"])
    gaps = cut(record, 240.0, 1310.0).time_gaps()
    assert [g[2] for g in gaps] == [4, 10_000]
    with pytest.raises(InputError, match="fewer than two samples"):
        cut(record, 5000.0, None)


def test_an_output_that_stands_still_is_found_on_disk_as_in_memory(tmp_path, short, signals):
    """Five hundredths of the record, in two stretches, one of them at its end."""
    x = signals["gyro_x"].copy()
    x[300_000:315_000] = x[300_000]
    x[395_000:] = x[395_000]
    record = Record({"gyro_x": x, "accel_z": signals["accel_z"]}, FS)
    on_disk = long_record.open_long(saved(record, tmp_path / "still.npz"))
    name, rows = still.spans(on_disk, "gyro_x")
    assert rows.tolist() == [[300_001, 315_000], [395_001, N]]
    assert len(still.spans(on_disk, "accel_z")[1]) == 0
    left, share = still.without(on_disk, rows)
    masked, (note,) = standing.masked(record)
    assert left.n == np.isfinite(masked["gyro_x"]).sum() and left.longest == 300_001
    ends = (on_disk.second(int(row)) for row in (rows[0, 0], rows[-1, 1] - 1))
    assert standing.noted({standing.sentence(share, *ends, True): [name]}) == (note,)
    assert still.without(on_disk, np.array([[1, 250_000]]))[0] is None
