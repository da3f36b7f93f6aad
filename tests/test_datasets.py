"""Records by name: drawn once, kept under a checksum, found offline, converted as the registry
says.
"""

import gzip
import json
import struct
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from imu_lib import datasets, twins, units
from imu_lib.datasets import convert, embedded, places, public
from imu_lib.errors import InputError
from imu_lib.record import Record


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """An empty cache, and no folder of real records."""
    monkeypatch.setattr(places, "cache", lambda: tmp_path)
    monkeypatch.delenv("IMU_LIB_DATA", raising=False)
    return tmp_path


@pytest.fixture
def draws(monkeypatch):
    """A twin that is quick to draw, and how often it was."""
    count = []

    def generate(name):
        count.append(name)
        return Record({"gyro_x": np.random.default_rng(1).normal(size=5000)}, 100.0, name=name)

    monkeypatch.setattr(twins, "generate", generate)
    return count


def test_a_twin_is_drawn_once_and_checked(folder, draws):
    first, second = datasets.twin("isis-imu"), datasets.twin("isis-imu")
    assert (
        len(draws) == 1
        and np.array_equal(first["gyro_x"], second["gyro_x"])
        and second.rate == 100.0
    )
    path = next(folder.glob("*.npy"))
    with open(path, "r+b") as file:  # a byte turns over
        file.seek(2000)
        file.write(b"\xff")
    assert np.array_equal(datasets.twin("isis-imu")["gyro_x"], first["gyro_x"]) and len(draws) == 2


def test_a_changed_model_is_drawn_anew(folder, draws, monkeypatch):
    datasets.twin("isis-imu")
    monkeypatch.setattr(twins, "fingerprint", lambda name: "f" * 64)
    datasets.twin("isis-imu")
    assert len(draws) == 2 and len(list(folder.glob("*.npy"))) == 1  # the stale draw is gone


def test_many_at_once_draw_once(folder, draws):
    with ThreadPoolExecutor(6) as pool:
        found = list(pool.map(lambda _: datasets.twin("isis-imu")["gyro_x"].sum(), range(6)))
    assert len(set(found)) == 1 and len(draws) == 1
    assert not list(folder.glob("*.lock"))


def test_a_full_disk_costs_only_time(folder, draws, monkeypatch):
    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(np, "save", full)
    assert datasets.twin("isis-imu").n == 5000 and not list(folder.glob("*.npy"))


def test_chapter_record(folder, draws, tmp_path):
    assert datasets.chapter_record("", twin="isis-imu").name == "isis-imu"
    path = tmp_path / "own.csv"
    np.savetxt(
        path,
        np.column_stack(
            [np.arange(500) / 50, np.random.default_rng(2).normal(scale=0.1, size=500)]
        ),
        delimiter=",",
        header="time,gx",
        comments="",
    )
    found = datasets.chapter_record(str(path), gyro_unit="deg/s", rate=0.0)
    assert found.time is None and found.rate == 50.0
    with pytest.raises(InputError, match="--gyro-unit"):
        datasets.chapter_record(str(path))
    with pytest.raises(InputError, match="unknown embedded record"):
        datasets.chapter_record("", twin="nothing")


def test_registry_is_whole():
    for name, about in datasets.registry().items():
        assert (
            about["kind"] in ("static", "drive", "calibration")
            and about["licence"]
            and about["sensor"]
            and about["columns"]
        ), name
        for source in about["sources"]:
            commit = source["url"].split("/")[5]
            assert len(source["sha256"]) == 64 and len(commit) == 40 and source["bytes"] > 0
        assert about["convert"] in convert.CONVERSIONS if about["convert"] else "how" in about


def test_offline(folder, monkeypatch):
    import pooch

    assert not datasets.available("phone")
    with pytest.raises(InputError, match="adis16405_1"):
        datasets.load("adis")

    def unreachable(*_, **__):
        raise ConnectionError("no network")

    monkeypatch.setattr(pooch, "retrieve", unreachable)
    with pytest.raises(InputError, match="IMU_LIB_DATA"):
        datasets.load("phone")


def test_fetch_converts(folder, monkeypatch):
    x = np.random.default_rng(3).normal(size=(1500, 6)) * 0.01 + [0, 0, 0, 0, 0, 1.0]
    original = folder / "original.rda"
    original.write_bytes(gzip.compress(rda("imu", x)))
    import pooch

    monkeypatch.setattr(pooch, "retrieve", lambda *_, **__: str(original))
    found = datasets.load("adis16405_1")
    assert (
        found.n == 1500
        and np.allclose(found["gyro"], x[:, :3] * units.DEG_PER_S, rtol=1e-6)
        and np.allclose(found["accel"], x[:, 3:] * units.G, rtol=1e-6)
    )
    assert datasets.available("adis16405_1")  # the second time nothing is fetched
    (folder / "log.txt").write_text("\n".join("-8.4 0.1 5.2 0.035 0.002 0.041" for _ in range(50)))
    convert.mpu9150([folder / "log.txt"], [folder / "m.npz"])
    assert np.allclose(np.load(folder / "m.npz")["gyro"][0], [0.035, 0.002, 0.041])


def rda(name, x, version=2):
    """A matrix as R's save() writes it."""
    flag = lambda kind, attributes=0, tag=0: struct.pack(">i", kind | attributes | tag)  # noqa: E731
    text = lambda s: flag(9 | 0x40000) + struct.pack(">i", len(s)) + s.encode()  # noqa: E731
    symbol = lambda s: flag(1) + text(s)  # noqa: E731
    head = b"RDX2\nX\n" if version == 2 else b"RDX3\nX\n"
    head += struct.pack(">iii", version, 0x30600, 0x20300) + (
        struct.pack(">i", 5) + b"UTF-8" if version == 3 else b""
    )
    vector = flag(14, 0x200) + struct.pack(">i", x.size) + x.T.astype(">f8").tobytes()
    dim = (
        flag(2, 0, 0x400) + symbol("dim") + flag(13) + struct.pack(">iii", 2, *x.shape) + flag(254)
    )
    return head + flag(2, 0, 0x400) + symbol(name) + vector + dim + flag(254)


@pytest.mark.parametrize("version", [2, 3])
def test_r_data(tmp_path, version):
    from imu_lib.readers.rdata import read_rdata

    x = np.arange(12.0).reshape(4, 3)
    (tmp_path / "a.rda").write_bytes(rda("m", x, version))
    assert np.array_equal(read_rdata(tmp_path / "a.rda")["m"], x)
    (tmp_path / "b.rda").write_bytes(rda("m", x, version)[:-30])
    with pytest.raises(InputError, match="b.rda"):
        read_rdata(tmp_path / "b.rda")


def test_real_records_by_name(data_dir, monkeypatch):
    monkeypatch.setenv("IMU_LIB_DATA", str(data_dir))
    assert all(datasets.available(name) for name in datasets.registry())
    assert datasets.load("phone").rate == pytest.approx(5.0, rel=1e-3)
    assert datasets.load("kth_car").duration == pytest.approx(299.0, abs=0.1)
    assert datasets.load("xsens_mti_poses")["accel_counts"].shape == (51_175, 3)
    assert datasets.load("mpu6050_raw_counts").n == 44_930


def test_committed_files(root, tmp_path, monkeypatch):
    """The script that made them makes them again."""
    import runpy

    script = runpy.run_path(str(root / "data/make_examples.py"))
    for function in ("careful", "careless"):
        monkeypatch.setitem(script[function].__globals__, "HERE", tmp_path)
        script[function]()
    for name in ("gx3_25_one_minute.csv", "logger_counts.csv"):
        same = (tmp_path / name).read_text() == datasets.example(
            name
        ).read_text()  # no diff of megabytes when it fails
        assert same, f"{name} is not what data/make_examples.py makes: run it"
    with pytest.raises(InputError, match="committed"):
        datasets.example("nothing.csv")


def test_sidecar_tells_what_it_is(folder, draws):
    datasets.twin("isis-imu")
    side = json.loads(next(folder.glob("*.json")).read_text())
    assert (
        side["fingerprint"] == twins.fingerprint("isis-imu")
        and len(side["sha256"]) == 64
        and side["channels"] == ["gyro_x"]
    )
    assert embedded.twin is datasets.twin and public.registry is datasets.registry
