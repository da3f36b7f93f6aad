"""What wavelet de-noising does to a moving vehicle's signals: sample by sample, and once they are
integrated.

Two questions of the 2013 paper's Section 5.6, with truth known: how many levels before the motion
suffers (`level_study`), and what is left of the gain when a strapdown has integrated the samples
over an outage (`after_integration`). `moving_and_still` cuts the two stretches out of a recorded
drive that `wavelet.choose_level` compares.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..drive import Drive
from ..errors import InputError
from ..wavelet import denoise

#: name -> options of `wavelet.denoise`
FORMS = {
    "SURE, whole record": {},
    "SURE, noise of level 1": {"noise": "first_level"},
    "SURE, causal": {"causal": True},
    "low-pass, whole record": {"threshold": "approximation"},
    "low-pass, causal": {"threshold": "approximation", "causal": True},
}


@dataclass(frozen=True)
class LevelStudy:
    """Errors of one channel after de-noising with 0 to J levels, signal unit.

    `rms` {form: (J + 1,)} against the truth; `loss` and `noise` (J + 1,): what the whole-record
    low-pass takes from the motion, and what it leaves of the noise (their squares add up to that
    form's).
    """

    rms: dict[str, np.ndarray]
    loss: np.ndarray
    noise: np.ndarray

    def best(self, form: str = "SURE, whole record") -> int:
        """The level of least error."""
        return int(np.argmin(self.rms[form]))


def level_study(
    truth: np.ndarray, reading: np.ndarray, *, levels: int = 8, forms=tuple(FORMS)
) -> LevelStudy:
    """RMS errors of `reading` against `truth`, ndarray, shape (n,) each, after de-noising with 0
    to `levels` levels.

    The first eighth of the record is left out of the RMS, so that the causal forms have their
    window filled.
    """
    truth, reading = np.asarray(truth, float), np.asarray(reading, float)
    part = slice(len(truth) // 8, None)

    def rms(x):
        return float(np.sqrt(np.mean(x[part] ** 2)))

    grid = range(levels + 1)
    found = {
        name: np.array([rms(denoise(reading, k, **FORMS[name]) - truth) for k in grid])
        for name in forms
    }
    low_pass = [
        denoise(np.column_stack([truth, reading - truth]), k, threshold="approximation")
        for k in grid
    ]
    return LevelStudy(
        found,
        np.array([rms(x[:, 0] - truth) for x in low_pass]),
        np.array([rms(x[:, 1]) for x in low_pass]),
    )


def after_integration(x: np.ndarray, fs: float, duration: float, *, integrals: int = 2) -> float:
    """RMS of the error that a signal error `x` (n,) makes by the end of windows of `duration` s.

    `integrals` 1: an angle from a rate, or a velocity from a specific force; 2: a position.
    Consecutive windows, each starting from zero error.
    """
    size = round(duration * fs)
    count = len(x) // size
    if count < 1:
        raise ValueError(
            f"`x` has {len(x)} samples, less than one window of `duration` {duration:g} s"
        )
    rows = np.asarray(x[: count * size], float).reshape(count, size)
    for _ in range(integrals):
        rows = np.cumsum(rows, axis=1) / fs
    return float(np.sqrt(np.mean(rows[:, -1] ** 2)))


def moving_and_still(
    drive: Drive, *, still: float = 0.05, moving: float = 0.5
) -> tuple[slice, slice]:
    """The longest stretches of a drive, as slices of its IMU samples, in which it drives and in
    which it stands.

    The speed is the reference's, or the receiver's where there is none, m/s: below `still` it
    stands, above `moving` it drives; no stretch holds a gap.

    Raises
    ------
    InputError
        Where the drive has no velocity, or never stands or never drives for 5 s.
    """
    time, velocity = drive.reference_time, drive.reference_velocity
    if velocity is None:
        time, velocity = drive.gnss_time, drive.gnss_velocity
    if velocity is None:
        raise InputError(
            f"{drive.name or 'The drive'} has no velocity to tell driving from standing by."
        )
    t = np.asarray(drive.time)
    speed = np.interp(t, time, np.hypot(velocity[:, 0], velocity[:, 1]))
    step = np.median(np.diff(t))
    gap = np.concatenate([[False], np.diff(t) > 1.5 * step])
    out = []
    for name, where in (("drives", speed > moving), ("stands", speed < still)):
        label = np.cumsum(np.concatenate([[False], np.diff(where.astype(int)) != 0]) | gap)
        runs = [
            r
            for r in np.split(np.arange(len(t)), np.flatnonzero(np.diff(label)) + 1)
            if where[r[0]]
        ]
        longest = max(runs, key=len, default=np.zeros(0, int))
        if len(longest) * step < 5.0:
            raise InputError(f"{drive.name or 'The drive'} never {name} for 5 s.")
        out.append(slice(int(longest[0]), int(longest[-1]) + 1))
    return out[0], out[1]
