"""Closed forms of the processes against each other, against published identities and against
draws.
"""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.signal import welch

from imu_lib.errors import InputError, UndefinedFormError
from imu_lib.processes import (
    FLAT,
    Autoregressive,
    CommonMode,
    Constant,
    Flicker,
    GaussMarkov,
    GaussMarkov2,
    Jitter,
    LowPass,
    NoiseLevelChange,
    Quantization,
    Ramp,
    RandomWalk,
    Resolution,
    Saturation,
    Sinusoid,
    Spikes,
    Step,
    Stuck,
    Sum,
    Telegraph,
    Temperature,
    TimeGaps,
    WarmUp,
    WhiteNoise,
    from_json,
)

FS = 100.0
STATIONARY = [
    WhiteNoise(0.1),
    Quantization(0.1),
    GaussMarkov(1.0, 3.0),
    GaussMarkov(1.0, 0.03),
    GaussMarkov2(1.0, 0.3),
    Telegraph(1.0, 1.0),
    Autoregressive((1.2, -0.3), 1.0, FS),
]
NOISES = STATIONARY + [Flicker(1.0), RandomWalk(1.0)]
SUMS = [
    Sum((WhiteNoise(0.1), GaussMarkov(1.0, 3.0)), (LowPass(taps=15, rate=1000.0),)),
    Sum((WhiteNoise(1.0), RandomWalk(0.5)), (LowPass(cutoff=10.0, order=2, rate=FS),)),
    Sum(
        (WhiteNoise(1.0), GaussMarkov(2.0, 0.5)),
        (LowPass(taps=5), Spikes(1.0, 50.0), Resolution(3.0)),
    ),
]


def name_of(entry):
    return getattr(entry, "name", None) or "+".join(p.name for p in entry)


def direct_avar(r, m):
    """Allan variance of the samples from their autocovariance, term by term."""
    d = np.arange(-(m - 1), m)
    weight = m - np.abs(d)
    return (np.sum(weight * r(np.abs(d))) - np.sum(weight * r(np.abs(d + m)))) / m**2


@pytest.mark.parametrize("process", STATIONARY + SUMS[2:], ids=name_of)
@pytest.mark.parametrize("m", [1, 2, 7, 50])
def test_avar_of_samples_is_the_double_sum_of_their_autocovariance(process, m):
    exact = direct_avar(lambda d: process.autocovariance(d / FS, FS), m)
    # the double sum itself cancels, so a few digits fewer than double precision
    assert process.avar(m / FS, FS) == pytest.approx(exact, rel=1e-8)


@pytest.mark.parametrize("process", NOISES + SUMS, ids=name_of)
@pytest.mark.parametrize("m", [1, 3, 40])
def test_avar_of_samples_is_the_filtered_spectrum(process, m):
    """IEEE 952 Eq. C.1-4 with the sampled spectrum and the Dirichlet kernel of m samples."""

    def integrand(f):
        kernel = 2.0 * np.sin(np.pi * f * m / FS) ** 4 / (m * np.sin(np.pi * f / FS)) ** 2
        return float(process.psd(np.array([f]), FS)[0]) * kernel

    edges = np.concatenate([[1e-9], np.geomspace(1e-4, FS / 2, 40 + 2 * m)])
    total = sum(
        quad(integrand, a, b, epsabs=0, epsrel=1e-7, limit=200)[0] for a, b in zip(edges, edges[1:])
    )
    assert process.avar(m / FS, FS) == pytest.approx(total, rel=3e-5)


@pytest.mark.parametrize("process", STATIONARY + SUMS[2:], ids=name_of)
def test_variance_is_the_integral_of_the_spectrum(process):
    f = (np.arange(400_000) + 0.5) * (FS / 2) / 400_000
    assert np.sum(process.psd(f, FS)) * (FS / 2) / 400_000 == pytest.approx(
        float(process.autocovariance(0.0, FS)), rel=2e-4
    )


@pytest.mark.parametrize("process", NOISES + SUMS, ids=name_of)
def test_realisation_agrees_with_the_closed_forms(process):
    rng = np.random.default_rng(952)
    n, m, repeats = 40_000, 20, 24
    avar, spectrum = [], []
    for _ in range(repeats):
        x = process.simulate(n, FS, rng)
        means = x.reshape(-1, m).mean(axis=1)
        avar.append(0.5 * np.mean(np.diff(means) ** 2))
        f, s = welch(x, FS, nperseg=1024, detrend="constant")
        spectrum.append(s)
    # five standard errors, taken from the repeats themselves: a false alarm in 2e6
    error = np.std(avar, ddof=1) / np.sqrt(repeats)
    assert abs(np.mean(avar) - process.avar(m / FS, FS)) < 5 * error
    band = slice(30, 480)  # away from the window's leakage at both ends
    ratio = np.mean(spectrum, axis=0)[band] / process.psd(f[band], FS)
    each = np.array([np.mean(s[band] / process.psd(f[band], FS)) for s in spectrum])
    leak = 0.01  # of a Hann window on a steep spectrum, in this band
    assert abs(ratio.mean() - 1) < 5 * each.std(ddof=1) / np.sqrt(repeats) + leak


@pytest.mark.parametrize(
    "process", [GaussMarkov(0.7, 2.0), GaussMarkov2(0.7, 2.0), Telegraph(1.4, 0.25)], ids=name_of
)
def test_state_space_has_the_autocovariance(process):
    space = process.state_space()
    for dt in (0.01, 0.5, 3.0):
        transition, step = space.discrete(dt)
        assert space.H @ transition @ space.P0 @ space.H == pytest.approx(
            float(process.autocovariance(dt)), rel=1e-9
        )
        assert transition @ space.P0 @ transition.T + step == pytest.approx(
            space.P0, rel=1e-9, abs=1e-12
        )


def test_state_space_of_a_walk_and_of_white_noise():
    transition, step = RandomWalk(2.0).state_space().discrete(0.25)
    assert (transition.item(), step.item()) == pytest.approx((1.0, 1.0))
    assert WhiteNoise(0.3).state_space().direct == pytest.approx(0.09)
    joint = Sum((WhiteNoise(0.3), GaussMarkov(1.0, 2.0), RandomWalk(2.0), Ramp(1.0))).state_space()
    assert (joint.order, joint.direct) == (2, pytest.approx(0.09))


@pytest.mark.parametrize(
    ("sampled", "continuous"),
    [
        (GaussMarkov(1.0, 5.0), None),
        (GaussMarkov2(1.0, 5.0), None),
        (RandomWalk(1.0), None),
        (Flicker(1.0), None),
    ],
    ids=str,
)
def test_samples_tend_to_the_continuous_limit(sampled, continuous):
    tau = np.array([2.0, 10.0, 60.0])
    assert sampled.avar(tau, 1000.0) == pytest.approx(sampled.avar(tau), rel=1e-4)
    f = np.array([0.01, 0.3, 2.0])
    assert sampled.psd(f, 1000.0) == pytest.approx(sampled.psd(f), rel=1e-4)


def test_table_of_the_standard():
    """IEEE Std 952-1997, Annex C.1: the five terms at the averaging times where they are read."""
    assert np.sqrt(WhiteNoise(2.0).avar(1.0)) == pytest.approx(2.0)
    assert np.sqrt(Flicker(1.0).avar(7.0)) == pytest.approx(0.664, abs=5e-4)
    assert np.sqrt(RandomWalk(2.0).avar(3.0)) == pytest.approx(2.0)
    assert np.sqrt(Ramp(2.0).avar(np.sqrt(2.0))) == pytest.approx(2.0)
    assert np.sqrt(Quantization(2.0).avar(np.sqrt(3.0))) == pytest.approx(2.0)
    assert FLAT == pytest.approx(2 * np.log(2) / np.pi)
    tau = np.linspace(1.7, 2.1, 4001)
    curve = np.sqrt(GaussMarkov(1.0, 1.0).avar(tau))
    assert tau[np.argmax(curve)] == pytest.approx(1.893, abs=1e-3)
    assert curve.max() == pytest.approx(0.617, abs=5e-4)


def test_point_samples_of_a_walk_and_of_flicker_at_one_sample():
    assert RandomWalk(1.0).avar(1 / FS, FS) / RandomWalk(1.0).avar(1 / FS) == pytest.approx(1.5)
    assert Flicker(1.0).avar(1 / FS, FS) == pytest.approx(2 / np.pi)


def test_gauss_markov_series_meets_the_closed_form():
    """The two branches agree where they join, sampled and continuous."""
    for process in (GaussMarkov(1.0, 1.0), GaussMarkov2(1.0, 1.0)):
        for edge in (0.02, 0.3 / process.beta if hasattr(process, "beta") else 0.02):
            below, above = process.avar(edge * (1 - 1e-9)), process.avar(edge * (1 + 1e-9))
            assert below == pytest.approx(above, rel=1e-7)
    m = np.array([1.0, 10.0, 199.0, 201.0])
    process = GaussMarkov(1.0, 100.0)  # a = m dt / Tc crosses 0.02 between the last two
    exact = [direct_avar(lambda d: -(process.sigma**2) * -np.expm1(-d / 1e4), int(k)) for k in m]
    assert process.avar(m / FS, FS) == pytest.approx(exact, rel=1e-9)


@settings(max_examples=40, deadline=None)
@given(st.floats(1e-3, 1e4), st.floats(1e-2, 1e5))
def test_gauss_markov_avar_is_positive_and_below_its_peak(time, tau):
    value = float(GaussMarkov(1.0, time).avar(tau, FS))
    # one sample of noise far faster than the sampling has the whole variance
    assert 0.0 < value <= 1.0


def test_ar1_is_gauss_markov():
    markov = GaussMarkov(2.0, 0.5)
    phi = np.exp(-1 / (FS * 0.5))
    ar = Autoregressive((phi,), 2.0 * np.sqrt(1 - phi**2), FS)
    back = ar.to_gauss_markov()
    assert (back.sigma, back.correlation_time) == pytest.approx((2.0, 0.5))
    tau = np.array([0.01, 0.2, 5.0])
    assert ar.avar(tau) == pytest.approx(markov.avar(tau, FS), rel=1e-9)
    assert ar.psd(tau) == pytest.approx(markov.psd(tau, FS), rel=1e-9)
    assert ar.autocovariance(tau) == pytest.approx(markov.autocovariance(tau), rel=1e-9)


def test_forms_that_do_not_exist_say_so():
    with pytest.raises(UndefinedFormError, match="not stationary"):
        RandomWalk(1.0).autocovariance(1.0)
    with pytest.raises(UndefinedFormError, match="not stationary"):
        Flicker(1.0).autocovariance(1.0)
    with pytest.raises(UndefinedFormError, match="no power spectral density"):
        Ramp(1.0).psd(1.0)
    with pytest.raises(UndefinedFormError, match="no finite state space"):
        Flicker(1.0).state_space()
    with pytest.raises(UndefinedFormError, match="sampling"):
        Quantization(1.0).psd(1.0)
    with pytest.raises(UndefinedFormError, match="infinite"):
        WhiteNoise(1.0).autocovariance(0.0)
    with pytest.raises(UndefinedFormError, match="1.044"):
        # Acc X of Table 2 of the 2013 paper as printed, its sign turned
        Autoregressive((2.582, -2.166, 0.585), 1.0, FS).psd(1.0)
    with pytest.raises(UndefinedFormError, match="behind stuck"):
        Sum((WhiteNoise(1.0),), (Stuck(0.1, 3),)).psd(1.0, FS)


def test_deterministic_terms():
    t = np.arange(5.0)
    assert Ramp(2.0).mean(t) == pytest.approx(2 * t)
    assert Step(3.0, 2.0).mean(t) == pytest.approx([0, 0, 3, 3, 3])
    assert WarmUp(1.0, 2.0).mean(t) == pytest.approx(np.exp(-t / 2))
    assert Constant(-9.8).mean(t) == pytest.approx(np.full(5, -9.8))
    assert Temperature(0.5, 20.0).mean(t, 20 + t) == pytest.approx(0.5 * t)
    with pytest.raises(InputError, match="temperature"):
        Temperature(0.5, 20.0).mean(t)
    wave = Sinusoid(2.0, 3.3)
    x = wave.simulate(200_000, FS, np.random.default_rng(0))
    y = np.diff(x.reshape(-1, 10).mean(axis=1))
    # a finite record holds a fraction of a cycle more or less
    assert 0.5 * np.mean(y**2) == pytest.approx(float(wave.avar(0.1, FS)), rel=1e-2)


def test_stages_do_what_they_say():
    rng = np.random.default_rng(5)
    x = rng.standard_normal(100_000)
    assert set(np.unique(np.round(Resolution(0.5).apply(x, FS, rng) / 0.5 % 1, 9))) <= {0.0, 1.0}
    assert Saturation(1.0).apply(x, FS, rng).min() == -1.0
    assert Saturation(1.0, -0.5).apply(x, FS, rng).min() == -0.5
    changed = NoiseLevelChange(3.0, 500.0).apply(x, FS, rng)
    assert np.std(changed[50_000:]) / np.std(changed[:50_000]) == pytest.approx(3.0, rel=0.03)
    frozen = Stuck(0.05, 4).apply(x, FS, rng)
    # runs that begin where another ended repeat nothing more, so the fraction is exact
    assert np.mean(np.diff(frozen) == 0) == pytest.approx(0.05, rel=0.01)
    hit = Spikes(2.0, 100.0).apply(x, FS, rng) - x
    assert np.count_nonzero(hit) / (len(x) / FS) == pytest.approx(
        2.0, rel=0.15
    )  # Poisson, 3 sigma of 2000
    average = LowPass(taps=15, rate=1000.0)
    # 14.16 % attenuation at 20 Hz, 2013 paper Sec. 5.1 (of the amplitude)
    assert 1 - np.sqrt(average.gain(20.0, FS)) == pytest.approx(0.1416, abs=2e-3)
    assert average.cutoff == pytest.approx(29.5, abs=0.1)
    assert LowPass(cutoff=10.0, order=2).gain(10.0, FS) == pytest.approx(0.5)


def test_decimated_average_of_white_noise_is_a_moving_average_of_three_half_samples():
    entry = Sum((WhiteNoise(1.0),), (LowPass(taps=15, rate=1000.0),))
    assert entry.autocovariance(np.array([0.0, 0.01, 0.02]), FS) == pytest.approx(
        [1000 / 15, 1000 / 45, 0.0], abs=1e-9
    )


def test_sum_keeps_its_order_and_its_labels():
    entry = (
        Sum((GaussMarkov(1.0, 2.0),)) + Resolution(0.1) + LowPass(taps=3) + GaussMarkov(3.0, 4.0)
    )
    assert [p.name for p in entry] == ["gauss_markov", "gauss_markov", "low_pass", "resolution"]
    assert [label for label, _, _ in entry.labels()][:4] == [
        "sigma",
        "correlation_time",
        "sigma_2",
        "correlation_time_2",
    ]
    assert entry.with_values({"sigma_2": 9.0}).terms[1].sigma == 9.0
    assert Sum.of(from_json(e) for e in entry.to_json()) == entry
    with pytest.raises(InputError, match="two of low_pass"):
        entry + LowPass(taps=4)


@pytest.mark.parametrize(
    ("entry", "message"),
    [
        ({"process": "white_nose", "N": 1}, "unknown process 'white_nose'"),
        ({"process": "white_noise"}, "parameter N is missing"),
        ({"process": "white_noise", "N": -1}, "at least zero"),
        ({"process": "white_noise", "N": "a"}, "must be a number"),
        ({"process": "white_noise", "N": float("nan")}, "must be finite"),
        ({"process": "white_noise", "N": 1, "K": 2}, "unknown parameter 'K'"),
        ({"process": "gauss_markov", "sigma": 1, "correlation_time": 0}, "above zero"),
        ({"process": "autoregressive", "phi": [], "sigma": 1, "rate": 1}, "list of numbers"),
        ({"process": "low_pass", "taps": 3, "smoothing": 1}, "goes with neither"),
        ({"N": 1}, "key 'process'"),
        ([], "key 'process'"),
    ],
)
def test_bad_entries_are_refused_in_a_sentence(entry, message):
    with pytest.raises(InputError, match=message):
        from_json(entry)


def test_record_processes():
    rng = np.random.default_rng(3)
    keep = TimeGaps(0.01, 5).keep(200_000, rng)
    assert np.mean(~keep) == pytest.approx(0.01, rel=0.15)
    stamps = Jitter(1e-3).stamps(np.arange(1000) / FS, rng)
    assert np.all(np.diff(stamps) >= 0)
    assert np.std(stamps - np.arange(1000) / FS) == pytest.approx(1e-3, rel=0.1)
    shared = CommonMode(0.5, ["gyro_x", "gyro_y"])
    assert from_json(shared.to_json(), on_record=True) == shared
