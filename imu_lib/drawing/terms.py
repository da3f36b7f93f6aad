"""The realisation of one process in pieces: the numbers that its `simulate` draws at once.

What is not listed here draws the whole first, one process of one channel at a time.
"""

from __future__ import annotations

import copy
from functools import singledispatch

import numpy as np
from scipy.fft import next_fast_len
from scipy.signal import lfilter, lfiltic
from scipy.special import sici

from imu_lib.processes import (
    Autoregressive,
    Constant,
    Flicker,
    GaussMarkov,
    GaussMarkov2,
    Quantization,
    Ramp,
    RandomWalk,
    Sinusoid,
    Step,
    Telegraph,
    WarmUp,
    WhiteNoise,
)
from imu_lib.stream import LONG, Scratch, bounds, inverse

#: Flicker noise of more samples than this is transformed over the disk.
LONG_FLICKER = LONG


@singledispatch
def chunks(process, n, fs, rng, *, size, temperature=None, start=0.0, folder=None):
    """Pieces of `size` samples of a realisation; arguments as for `Process.simulate`.

    `temperature` may be anything that gives arrays for slices; `folder` is for scratch files.
    """
    if temperature is not None:
        temperature = temperature[slice(0, n)]
    x = process.simulate(n, fs, rng, temperature=temperature, start=start)
    return (x[low:high] for low, high in bounds(n, size))


@chunks.register(WhiteNoise)
def _(process, n, fs, rng, *, size, **_):
    for low, high in bounds(n, size):
        yield process.simulate(high - low, fs, rng)


@chunks.register(Quantization)
def _(process, n, fs, rng, *, size, **_):
    last = rng.standard_normal(1)
    for low, high in bounds(n, size):
        e = np.concatenate([last, rng.standard_normal(high - low)])
        last = e[-1:]
        yield np.diff(e) * (process.Q * fs)


@chunks.register(RandomWalk)
def _(process, n, fs, rng, *, size, **_):
    last = 0.0
    for low, high in bounds(n, size):
        steps = rng.standard_normal(high - low)
        steps *= process.K / np.sqrt(fs)
        steps[0] = last + (steps[0] if low else 0.0)
        last = np.cumsum(steps, out=steps)[-1]
        yield steps


@chunks.register(GaussMarkov)
def _(process, n, fs, rng, *, size, **_):
    b = 1.0 / (fs * process.correlation_time)
    state = np.zeros(1)
    for low, high in bounds(n, size):
        w = rng.standard_normal(high - low)
        w[0 if low else 1 :] *= np.sqrt(-np.expm1(-2.0 * b))  # the first sample is stationary
        x, state = lfilter([1.0], [1.0, -np.exp(-b)], w, zi=state)
        yield process.sigma * x


@chunks.register(GaussMarkov2)
def _(process, n, fs, rng, *, size, **_):
    space = process.state_space()
    transition, step = space.discrete(1.0 / fs)
    again = copy.deepcopy(rng)  # the start is drawn last: the noise is drawn twice
    for low, high in bounds(n, size):
        again.multivariate_normal(np.zeros(2), step, size=high - low, method="eigh")
    first = again.multivariate_normal(np.zeros(2), space.P0, method="eigh")
    denominator = np.array([1.0, -np.trace(transition), np.linalg.det(transition)])
    own, other = np.zeros(2), np.zeros(2)
    for low, high in bounds(n, size):
        w = rng.multivariate_normal(np.zeros(2), step, size=high - low, method="eigh")
        if low == 0:
            w[0] = first
        x, own = lfilter([1.0, -transition[1, 1]], denominator, w[:, 0], zi=own)
        y, other = lfilter([0.0, transition[0, 1]], denominator, w[:, 1], zi=other)
        yield x + y
    rng.bit_generator.state = again.bit_generator.state


@chunks.register(Autoregressive)
def _(process, n, fs, rng, *, size, **_):
    process._at(fs)
    denominator = np.concatenate([[1.0], -np.array(process.phi)])
    space = process.state_space()
    past = rng.multivariate_normal(np.zeros(len(process.phi)), space.P0, method="eigh")
    state = lfiltic([1.0], denominator, past)
    for low, high in bounds(n, size):
        w = rng.standard_normal(high - low) * process.sigma
        x, state = lfilter([1.0], denominator, w, zi=state)
        yield x


@chunks.register(Telegraph)
def _(process, n, fs, rng, *, size, **_):
    again = copy.deepcopy(rng)  # the level at the start is drawn last: the flips are drawn twice
    for low, high in bounds(n, size):
        again.poisson(process.rate / fs, high - low)
    level = again.integers(2)
    for low, high in bounds(n, size):
        flips = np.cumsum(rng.poisson(process.rate / fs, high - low))
        yield process.amplitude * ((flips + level) % 2 - 0.5)
        level = level + flips[-1]
    rng.bit_generator.state = again.bit_generator.state


def _of_time(process, n, fs, rng, *, size, start=0.0, **_):
    for low, high in bounds(n, size):
        yield process.mean(start + np.arange(low, high) / fs)


for _kind in (Constant, Ramp, Sinusoid, WarmUp, Step):
    chunks.register(_kind, _of_time)


@chunks.register(Flicker)
def _(process, n, fs, rng, *, size, start=0.0, folder=None, **_):
    if n <= LONG_FLICKER:
        yield from _pieces(process.simulate(n, fs, rng), size)
        return
    half = next_fast_len(n, real=True)
    spectrum = Scratch(half + 1, dtype=complex, folder=folder)
    for unit in (1.0, 1j):  # all the real parts are drawn first
        for low, high in bounds(half + 1, size):
            noise = unit * rng.standard_normal(high - low)
            edge = np.sqrt(2.0) if unit == 1.0 else 0.0
            if low == 0:
                noise[0] *= edge
            if high == half + 1:
                noise[-1] *= edge
            noise = noise * amplitudes(half, low, high)
            spectrum.write(low, noise if unit == 1.0 else spectrum.read(low, high) + noise)
    last, done = 0.0, 0
    for y in inverse(spectrum, folder=folder):
        y = y[: n - done]
        if y.size:
            y[0] = last + (y[0] if done else 0.0)
            last, done = np.cumsum(y, out=y)[-1], done + y.size
            yield from _pieces(process.B * y, size)
    spectrum.close()


def _pieces(x, size):
    return (x[low:high] for low, high in bounds(x.size, size))


def amplitudes(half: int, low: int, high: int) -> np.ndarray:
    """Amplitudes k = low .. high - 1 of the circulant embedding of flicker's increments, in closed
    form.

    The autocovariance r_d = -1 / (pi (d^2 - 1/4)) over all lags has the density 2 sin(theta / 2);
    the embedding ends at d = half, and what lies beyond is an integral of cos(theta d) / d^2 (its
    Euler-Maclaurin terms vanish there to 1 / half^3).
    """
    k = np.arange(low, high)
    theta = np.pi * k / half
    beyond = np.where(k % 2, -1.0, 1.0) / half + theta * (sici(np.pi * k)[0] - 0.5 * np.pi)
    density = 2.0 * np.sin(0.5 * theta) + 2.0 / np.pi * beyond
    return np.sqrt(np.maximum(density, 0.0) * half)
