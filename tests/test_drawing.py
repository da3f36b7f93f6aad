"""A record drawn piece by piece is the record drawn at once."""

import json

import numpy as np
import pytest

from imu_lib import drawing, stream
from imu_lib.drawing import terms
from imu_lib.model import Model
from imu_lib.processes import Flicker
from imu_lib.stream import Scratch, inverse

N, FS = 20_000, 100.0

#: Everything that is drawn by pieces: in each channel several terms, so that the order in which
#: they ask the generator shows.
CONTENT = {
    "gyro_x": [
        {"process": "constant", "value": 0.3},
        {"process": "white_noise", "N": 1e-3},
        {"process": "random_walk", "K": 1e-4},
        {"process": "gauss_markov", "sigma": 1e-3, "correlation_time": 20.0},
        {"process": "spikes", "rate": 0.5, "scale": 0.1},
        {"process": "resolution", "lsb": 1e-3},
    ],
    "gyro_y": [
        {"process": "telegraph", "amplitude": 1e-2, "rate": 0.2},
        {"process": "quantization", "Q": 1e-4},
        {"process": "sinusoid", "amplitude": 1e-3, "frequency": 3.3},
        {"process": "autoregressive", "phi": [0.5, 0.3], "sigma": 1e-3, "rate": FS},
        {"process": "noise_level_change", "ratio": 3.0, "time": 50.0},
        {"process": "saturation", "limit": 0.01},
    ],
    "gyro_z": [
        {"process": "white_noise", "N": 1e-3},
        {"process": "quantization", "Q": 1e-5, "rounded": 1},
        {"process": "gauss_markov_2", "sigma": 1e-3, "correlation_time": 5.0},
        {"process": "step", "amplitude": 0.01, "time": 99.0},
        {"process": "stuck", "fraction": 0.02, "length": 7},
    ],
    "accel_x": [
        {"process": "white_noise", "N": 1e-3},
        {"process": "flicker", "B": 1e-3},
        {"process": "low_pass", "order": 2, "cutoff": 30.0, "rate": 3 * FS},
    ],
    "accel_y": [
        {"process": "white_noise", "N": 1e-3},
        {"process": "temperature", "slope": 1e-3, "reference": 20.0},
        {"process": "low_pass", "taps": 15, "rate": 10 * FS},
    ],
    "accel_z": [
        {"process": "white_noise", "N": 1e-3},
        {"process": "warm_up", "amplitude": 0.1, "time_constant": 30.0},
        {"process": "low_pass", "smoothing": 1, "cutoff": 10.0},
    ],
    "record": [
        {"process": "common_mode", "N": 1e-3, "channels": ["gyro_x", "accel_z"]},
        {"process": "jitter", "sd": 1e-3},
        {"process": "time_gaps", "fraction": 0.01, "length": 3},
    ],
}


@pytest.mark.parametrize("size", [997, 20_000])
def test_the_pieces_make_the_record(size, tmp_path):
    model = Model.from_json(CONTENT)
    temperature = 20 + np.sin(np.arange(N) / 3000)
    whole = model.simulate_record(N, FS, np.random.default_rng(5), temperature=temperature)
    drawn = drawing.draw(
        model,
        N,
        FS,
        np.random.default_rng(5),
        temperature=temperature,
        size=size,
        folder=tmp_path,
    )
    pieces = list(drawn.pieces(1234))
    got = {key: np.concatenate([p[key] for p in pieces]) for key in pieces[0]}
    assert drawn.n == whole.n
    np.testing.assert_array_equal(got["time"], whole.times())
    np.testing.assert_array_equal(got["temperature"], whole.temperature)
    for name, x in whole.channels.items():
        if name == "accel_y":  # the moving average adds in another order
            np.testing.assert_allclose(got[name], x, rtol=0, atol=1e-14)
        else:
            np.testing.assert_array_equal(got[name], x, err_msg=name)
    assert not list(tmp_path.iterdir())  # scratch files have no name


#: What acts on the whole record, in an order that shows who asks the generator first.
ON_RECORD = {
    "gyro_x": [
        {"process": "white_noise", "N": 1e-3},
        {"process": "random_walk", "K": 1e-4},
        {"process": "heavy_tails", "freedom": 6.0, "lean": 0.4},
        {"process": "wandering_level", "sd": 0.3, "correlation_time": 20.0},
        {"process": "spikes", "rate": 0.5, "scale": 0.1},
    ],
    "accel_x": [
        {"process": "autoregressive", "phi": [0.5], "sigma": 1e-3, "rate": 2 * FS},
        {"process": "noise_level_change", "ratio": 2.0, "time": 50.0},
        {"process": "wandering_level", "sd": 0.2, "correlation_time": 9.0},
        {"process": "low_pass", "order": 2, "cutoff": 20.0, "rate": 2 * FS},
        {"process": "stuck", "fraction": 0.2, "length": 70},
    ],
    "accel_y": [
        {"process": "white_noise", "N": 1e-3},
        {"process": "heavy_tails", "freedom": 4.0},
        {"process": "low_pass", "order": 2, "cutoff": 30.0, "rate": 3 * FS},
    ],
    "accel_z": [{"process": "white_noise", "N": 1e-3}],
    "record": [
        {
            "process": "vibration",
            "frequency": 7.0,
            "bandwidth": 0.01,
            "harmonics": 2,
            "amplitude": [0.1, 0.2],
            "channels": ["gyro_x", "accel_x"],
            "from": 20.0,
            "to": 90.0,
        },
        {"process": "common_mode", "N": 1e-3, "channels": ["gyro_x", "accel_z"]},
        {"process": "disturbance", "start": 99.9, "duration": 3.0, "peak": [1.0, 2.0],
         "channels": ["accel_z", "gyro_y"]},
        {"process": "tilt", "time": 120.0, "angles": [0.01, -0.02, 0.0]},
        {"process": "common_mode", "N": 1e-3, "channels": ["accel_x", "accel_z"], "filtered": 1},
        {"process": "vibration", "frequency": 30.0, "bandwidth": 8.0, "harmonics": 2,
         "amplitude": [0.1, 0.2], "channels": ["accel_z", "gyro_x"], "ratios": [1.0, 0.4]},
        {"process": "rate_error", "ratio": 1.02},
        {"process": "dropout", "fraction": 0.01, "held": True, "channels": ["gyro_x", "accel_x"]},
        {"process": "dropout", "fraction": 0.01, "value": [0.0, 1.0], "period": 50,
         "channels": ["gyro_x", "accel_z"]},
        {"process": "dropout", "fraction": 0.1, "held": True, "from": 50.0, "to": 70.0,
         "channels": ["accel_z"]},
        {"process": "time_gaps", "fraction": 0.01},
    ],
}  # fmt: skip


@pytest.mark.parametrize("size", [64, 997])
def test_what_acts_on_the_record_is_drawn_by_pieces(size, tmp_path, monkeypatch):
    """Vibrations, knocks, tilts, drop-outs, noise in common and a wrong rate: the same samples."""
    for module in (drawing.on_record, drawing.stages):
        monkeypatch.setattr(module, "CHUNK", size)
        monkeypatch.setattr(module, "bounds", lambda n, size=size: stream.bounds(n, size))
    model = Model.from_json(ON_RECORD)
    assert drawing.by_pieces(model)
    whole = model.simulate_record(N, FS, np.random.default_rng(5))
    drawn = drawing.draw(model, N, FS, np.random.default_rng(5), size=size, folder=tmp_path)
    pieces = list(drawn.pieces(1234))
    got = {key: np.concatenate([p[key] for p in pieces]) for key in pieces[0]}
    np.testing.assert_array_equal(got["time"], whole.times())
    for name, x in whole.channels.items():
        # the band of vibration comes out of another transform
        np.testing.assert_allclose(got[name], x, rtol=0, atol=1e-12, err_msg=name)


def test_long_flicker_is_the_flicker_drawn_at_once(monkeypatch):
    """The embedding's amplitudes in closed form, its transform over the disk."""
    n = 50_000
    whole = Flicker(B=2.0).simulate(n, FS, np.random.default_rng(3))
    monkeypatch.setattr(terms, "LONG_FLICKER", 1000)
    for size in (999, 1 << 16):
        pieces = terms.chunks(Flicker(B=2.0), n, FS, np.random.default_rng(3), size=size)
        # the amplitudes of the transform at once are known to 1e-9 at the slow end
        np.testing.assert_allclose(np.concatenate(list(pieces)), whole, rtol=0, atol=1e-8)


@pytest.mark.parametrize("h", [1, 7, 1000, 12_288])
def test_transform_over_the_disk(h):
    rng = np.random.default_rng(h)
    spectrum = rng.standard_normal(h + 1) + 1j * rng.standard_normal(h + 1)
    scratch = Scratch(h + 1, dtype=complex)
    scratch.write(0, spectrum)
    got = np.concatenate(list(inverse(scratch)))
    np.testing.assert_allclose(got, np.fft.irfft(spectrum, 2 * h), atol=1e-14)


@pytest.mark.parametrize("suffix", [".npz", ".parquet", ".csv"])
def test_simulate_streams_the_same_file(suffix, tmp_path, monkeypatch, capsys):
    """`imu-lib simulate` of a long record writes what it writes of a short one."""
    from imu_lib import read_record, stream
    from imu_lib.cli.main import main

    model = {key: value for key, value in CONTENT.items() if key not in ("accel_y", "record")}
    Model.from_json(model).save(tmp_path / "model.json")
    call = ["simulate", str(tmp_path / "model.json"), "--hours", "0.02", "--rate", "100"]
    call += ["--seed", "4"]
    assert main([*call, "--out", str(tmp_path / f"whole{suffix}")]) == 0
    monkeypatch.setattr(stream, "LONG", 1000)
    out = tmp_path / f"pieces{suffix}"
    assert main([*call, "--out", str(out), "--json", str(tmp_path / "s.json")]) == 0
    whole = read_record(tmp_path / f"whole{suffix}", trust_units=True)
    pieces = read_record(out, trust_units=True)
    assert pieces.n == whole.n == 7200 and pieces.rate == whole.rate
    for name, x in whole.channels.items():
        np.testing.assert_array_equal(pieces[name], x)
    summary = json.loads((tmp_path / "s.json").read_text())
    assert summary["sd"]["gyro_x"] == pytest.approx(whole["gyro_x"].std(), rel=1e-9)
