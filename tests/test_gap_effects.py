"""Every effect of the catalogue is found and named where it is plain to see, and nothing where
nothing is hidden.
"""

import gap_generator as generator
import numpy as np
import pytest

from imu_lib import gap, presets
from imu_lib.gap.channel import analyse
from imu_lib.gap.effects import CATALOGUE
from imu_lib.model import Model
from imu_lib.processes import OF_CHANNEL, OF_RECORD, Sum, from_json
from imu_lib.record import Record
from imu_lib.samples.imputation import impute
from imu_lib.samples.innovations import Smooth

FS, DURATION = 100.0, 900.0
#: A gain far above the limit of detectability, so that no seed makes the name a matter of luck.
PLAIN = 800.0


def _case(seed, effect, **more):
    made = generator.make(
        seed,
        [effect] if effect else [],
        duration=DURATION,
        fs=FS,
        channels=("gyro_x",),
        base="gm",
        gain=PLAIN,
        **more,
    )
    base = Sum.of(from_json(e) for e in made.base["gyro_x"])
    return made, base


@pytest.mark.parametrize(
    "effect",
    [
        "quantization",
        "flicker",
        "random_walk",
        "autoregressive",
        "ramp",
        "warm_up",
        "temperature",
        "step",
        "sinusoid",
        "slow_sinusoid",
        "telegraph",
        "gauss_markov",
        "gauss_markov_2",
        "low_pass",
        "noise_level_change",
        "spikes",
        "saturation",
        "resolution",
        "stuck",
        "change_N",
    ],
)
def test_a_plain_effect_is_named(effect):
    made, base = _case(31, effect)
    found = analyse("gyro_x", made.channels["gyro_x"], FS, base, temperature=made.temperature)
    truth = made.truths[0]
    step = next((s for s in found.steps if s.effect == truth["effect"]), None)
    assert step is not None, [s.effect for s in found.steps]
    assert not [s.effect for s in found.steps if s is not step and s.confidence >= 0.9]
    assert step.where and step.cause


@pytest.mark.parametrize("name, factor", [("sigma", 2.0), ("correlation_time", 3.0)])
def test_a_parameter_that_is_off_is_named_with_its_value(name, factor):
    entries = [
        {"process": "white_noise", "N": 1e-3},
        {"process": "gauss_markov", "sigma": 1e-3, "correlation_time": 0.5},
    ]
    rng = np.random.default_rng(52)
    x = sum(
        generator.noise(e, int(FS * DURATION), FS, rng)
        for e in [entries[0], {**entries[1], name: factor * entries[1][name]}]
    )
    found = analyse("gyro_x", x, FS, Sum.of(from_json(e) for e in entries))
    (step,) = found.steps
    assert (step.effect, step.parameters["name"]) == ("parameter_change", name)
    low, high = step.intervals["to"]
    assert (
        abs(step.parameters["to"] - factor * entries[1][name]) < high - low
    )  # four standard deviations


@pytest.mark.parametrize(
    "effects",
    [
        ("ramp", "warm_up"),
        ("step", "sinusoid"),
        ("low_pass", "noise_level_change"),
        ("spikes", "resolution"),
        ("quantization", "gauss_markov"),
        ("slow_sinusoid", "flicker"),
        ("telegraph", "change_N"),
        ("autoregressive", "temperature"),
        ("saturation", "ramp"),
    ],
)
def test_two_plain_effects_in_one_channel_are_both_named(effects):
    # beside a Gauss-Markov process in the base a second one is a near tie with a larger first one
    base = "white" if "gauss_markov" in effects else "gm"
    made = generator.make(
        51, effects, duration=DURATION, fs=FS, channels=("gyro_x",), base=base, gain=PLAIN
    )
    found = analyse(
        "gyro_x",
        made.channels["gyro_x"],
        FS,
        Sum.of(from_json(e) for e in made.base["gyro_x"]),
        temperature=made.temperature,
    )
    truths = {t["effect"] for t in made.truths}
    assert truths <= {s.effect for s in found.steps}
    assert not [s.effect for s in found.steps if s.effect not in truths and s.confidence >= 0.9]


@pytest.mark.parametrize("rate, amplitude", [(0.01, 1.0), (0.12, 1.0), (0.12, 5.0)])
def test_two_levels_that_stand_out_of_the_noise_leave_nothing_behind(rate, amplitude):
    """A mistimed edge would be taken for a further noise."""
    made = generator.make(61, [], duration=DURATION, fs=FS, channels=("gyro_x",), base="gm")
    base = made.base["gyro_x"]
    size = amplitude * base[0]["N"] * np.sqrt(FS)
    entry = {"process": "telegraph", "rate": rate, "amplitude": size}
    x = made.channels["gyro_x"] + generator.noise(
        entry, int(FS * DURATION), FS, np.random.default_rng(62)
    )
    found = analyse("gyro_x", x, FS, Sum.of(from_json(e) for e in base))
    assert [s.effect for s in found.steps] == ["telegraph"] and found.unexplained is None
    low, high = found.steps[0].intervals["amplitude"]
    assert (
        abs(found.steps[0].parameters["amplitude"] - size) < high - low
    )  # four standard deviations


def test_a_noise_that_a_filter_stands_in_for_is_seen():
    """A filter fitted alone moves its cutoff until quantization has no slope left: it takes both
    together to see either right.
    """
    made = generator.make(
        73,
        ["low_pass", "quantization"],
        duration=DURATION,
        fs=FS,
        channels=("gyro_x",),
        base="white",
        gain=PLAIN,
    )
    found = analyse(
        "gyro_x", made.channels["gyro_x"], FS, Sum.of(from_json(e) for e in made.base["gyro_x"])
    )
    assert {s.effect for s in found.steps} == {"low_pass", "quantization"}


@pytest.mark.parametrize("kind", ["sweep", "wander"])
def test_a_tone_that_moves_is_no_resonance(kind):
    base = [{"process": "white_noise", "N": 1e-3}]
    rng = np.random.default_rng(74)
    t = np.arange(360_000) / FS
    f = 4.0 + 3.0 * t / t[-1] if kind == "sweep" else 6.0 * (1 + 0.05 * np.sin(2 * np.pi * t / 400))
    x = generator.noise(base[0], len(t), FS, rng) + 1.5e-3 * np.sin(2 * np.pi * np.cumsum(f) / FS)
    found = analyse("gyro_x", x, FS, Sum.of(from_json(e) for e in base))
    assert found.unexplained
    assert all(s.confidence < 0.9 for s in found.steps)


def test_a_resonance_is_one_and_its_strength_has_an_interval():
    base = [{"process": "white_noise", "N": 1e-3}]
    entry = {
        "process": "autoregressive",
        "phi": [2 * 0.95 * np.cos(0.8), -(0.95**2)],
        "rate": FS,
        "sigma": 4e-4,
    }
    rng = np.random.default_rng(75)
    x = sum(generator.noise(e, 360_000, FS, rng) for e in (base[0], entry))
    found = analyse("gyro_x", x, FS, Sum.of(from_json(e) for e in base))
    (step,) = found.steps
    low, high = step.intervals["sigma"]
    assert step.effect == "autoregressive" and found.unexplained is None
    assert abs(step.parameters["sigma"] - 4e-4) < high - low  # four standard deviations
    assert high / low < 1.5


def test_a_resonance_beside_a_filter_inside_the_sensor_is_no_error():
    made = generator.make(
        71,
        ["low_pass", "autoregressive"],
        duration=DURATION,
        fs=FS,
        channels=("gyro_x",),
        base="white",
        gain=PLAIN,
    )
    base = Sum.of(
        [
            *(from_json(e) for e in made.base["gyro_x"]),
            from_json({"process": "low_pass", "taps": 15, "rate": 10 * FS}),
        ]
    )
    analyse("gyro_x", made.channels["gyro_x"], FS, base)


@pytest.mark.parametrize(
    "effect", ["modulated_noise", "chirp", "heavy_tails", "clicks", "missing_codes", "square_wave"]
)
def test_an_unknown_effect_is_left_unexplained_without_a_confident_name(effect):
    made, _ = (
        generator.make(41, [], duration=DURATION, fs=FS, channels=("gyro_x",), base="gm"),
        None,
    )
    base = Sum.of(from_json(e) for e in made.base["gyro_x"])
    white = made.base["gyro_x"][0]["N"] * np.sqrt(FS)
    x = generator.unknown(effect, made.channels["gyro_x"], FS, np.random.default_rng(5), white)
    found = analyse("gyro_x", x, FS, base)
    assert found.unexplained
    assert all(s.confidence < 0.9 for s in found.steps)


def test_nothing_is_found_where_nothing_is_hidden():
    made = generator.make(7, [], duration=DURATION, fs=FS, channels=("gyro_x", "accel_z"))
    found = gap.close(
        Record(made.channels, FS, temperature=made.temperature),
        Model.from_json(made.base),
        simulations=0,
        jobs=1,
    )
    assert found.steps == [] and all(c.result.unexplained is None for c in found.channels.values())
    assert found.record_unexplained is None


@pytest.mark.parametrize("effect", generator.RECORD)
def test_what_acts_on_the_record_is_named(effect):
    made = generator.make(
        8, [effect], duration=DURATION, fs=FS, channels=("gyro_x", "gyro_y"), base="white"
    )
    found = gap.close(
        Record(made.channels, FS, time=made.time, temperature=made.temperature),
        Model.from_json(made.base),
        simulations=0,
        jobs=1,
    )
    assert [(c, s.effect) for c, s in found.steps] == [("record", effect)]
    truth = made.truths[0]["parameters"]
    step = found.record_steps[0]
    for name in set(truth) & {"N", "fraction"}:
        assert abs(step.parameters[name] / truth[name] - 1) < 0.1
    if effect == "common_mode":
        assert step.parameters["channels"] == truth["channels"]


def test_a_free_base_says_what_it_absorbed():
    made, _ = _case(9, "random_walk")
    found = analyse("gyro_x", made.channels["gyro_x"], FS, None)
    assert {"white_noise", "random_walk"} <= set(found.absorbed)
    assert not [s for s in found.steps if s.confidence >= 0.9]


def test_a_free_base_leaves_the_filter_of_the_sensor_to_be_named():
    """Fifteen taps at a kilohertz roll off by 4 dB at half the output rate: flicker or a quick
    Gauss-Markov process would do so too.
    """
    model = presets.preset("3dm-gx3-25")["accel_z"]
    found = analyse("accel_z", model.simulate(180_000, FS, np.random.default_rng(11)), FS, None)
    (step,) = found.steps
    assert (step.effect, step.parameters["taps"], step.parameters["rate"]) == (
        "low_pass",
        15,
        1000.0,
    )
    assert abs(found.model.find("white_noise").N / model.find("white_noise").N - 1) < 0.02


def test_filled_in_samples_have_the_spectrum_of_the_rest():
    rng = np.random.default_rng(10)
    x = generator.noise(
        {"process": "gauss_markov", "sigma": 1.0, "correlation_time": 0.2}, 60_000, FS, rng
    )
    bad = np.zeros(60_000, bool)
    for start in range(500, 59_000, 600):
        bad[start : start + 40] = True
    y = impute(np.where(bad, 50.0, x), bad, Smooth(x, FS), rng)
    assert (
        abs(np.std(y[bad]) / np.std(x[~bad]) - 1) < 0.1
    )  # 98 runs of two correlation times: 7 % scatter
    assert abs(np.std(np.diff(y)[bad[1:]]) / np.std(np.diff(x)) - 1) < 0.05


def test_the_catalogue_covers_the_vocabulary_of_the_model_file():
    # the noise of the read-out is a part of what is found of the filter that lies before it
    missing = set(OF_CHANNEL) - {"constant", "read_out_noise"} - set(CATALOGUE)
    extra = set(CATALOGUE) - set(OF_CHANNEL) - set(OF_RECORD)
    assert not missing and extra == {"parameter_change"}
    assert all(e.cause for e in CATALOGUE.values())


def test_a_resonance_alone_leaves_no_drift_for_a_telegraph_to_hide_in():
    """Noise that comes again a fifth of a second later is fitted by resonances: none of them is
    slow.
    """
    base = [{"process": "white_noise", "N": 1e-4}]
    x = generator.noise(base[0], int(FS * DURATION), FS, np.random.default_rng(76))
    found = analyse("gyro_x", x + 0.3 * np.roll(x, 20), FS, Sum.of(from_json(e) for e in base))
    assert found.unexplained
