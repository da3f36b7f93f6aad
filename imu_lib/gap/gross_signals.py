"""What is so loud in a channel that it has to be set aside before single samples can be judged."""

from __future__ import annotations

import numpy as np

from imu_lib.arrays import Array
from imu_lib.gap.data import Data
from imu_lib.gap.effects.sinusoid import Sinusoid
from imu_lib.gap.effects.step import sharpen


def gross_signals(x: Array, fs: float) -> np.ndarray:
    """Gross jumps and lines of a channel, shape (n,)."""
    out = gross_jumps(x, fs)
    lines, _ = Sinusoid().find(Data(x - out, fs))
    for _, signal in lines:
        out = out + signal
    return out


def gross_jumps(x: Array, fs: float) -> np.ndarray:
    """The jumps that stand out of a channel by eye, as a signal to set aside, shape (n,)."""
    q = max(1, int(round(0.5 * fs)))
    k = len(x) // q
    out = np.zeros(len(x))
    if k < 60:
        return out
    y = x[: k * q].reshape(k, q).mean(axis=1)
    c = np.concatenate([[0.0], np.cumsum(y)])
    w = 6
    i = np.arange(w, k - w + 1)
    jump = (c[i + w] - 2 * c[i] + c[i - w]) / w
    sd = 1.4826 * np.median(np.abs(jump - np.median(jump)))
    fast_sd = np.median(np.abs(np.diff(x[::3]))) / 0.954
    strong = np.abs(jump)
    for _ in range(400):
        j = int(np.argmax(strong))
        if strong[j] < 9 * sd or strong[j] < 0.3 * fast_sd:
            break
        density = fast_sd**2 / fs
        edge = sharpen(x, fs, i[j] * q / fs, 1.0, jump[j], density)
        at = int(round((edge[0] if edge else i[j] * q / fs) * fs))
        a = x[max(0, at - w * q) : at].mean() if at > 0 else x[0]
        b = x[at : at + w * q].mean()
        out[at:] += b - a
        strong[max(0, j - w) : j + w + 1] = 0.0
    return out
