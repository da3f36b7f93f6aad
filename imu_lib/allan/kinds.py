"""Several kinds of deviation of one record, as the package `allantools` computes them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from imu_lib.arrays import Array, ArrayLike

#: What a deviation is called here, and in `allantools`.
KINDS = {"Allan": "oadev", "modified": "mdev", "Hadamard": "ohdev", "total": "totdev"}


def by_allantools(
    x: Array, fs: float, *, taus: ArrayLike | None = None, kinds: Sequence[str] = tuple(KINDS)
) -> dict[str, tuple[Array, Array]]:
    """Allan, modified, Hadamard and total deviation of a record, all overlapped.

    `allantools` takes its input for a phase unless it is told that it is a rate; here it is told
    so.

    Parameters
    ----------
    x : array_like, shape (n,)
        Samples of rate or specific force, none missing.
    fs : float
        Sampling rate, Hz.
    taus : array_like or None
        Averaging times, s; by default 24 from one sample to a quarter of the record.
    kinds : sequence of str
        Which, of `KINDS`.

    Returns
    -------
    dict of str to (ndarray, Array)
        Averaging times (s) and deviation by kind. A kind that a record is too short for at some
        time leaves that time out.

    Raises
    ------
    ValueError
        For a kind that is not in `KINDS`.
    """
    import allantools

    unknown = [kind for kind in kinds if kind not in KINDS]
    if unknown:
        raise ValueError(f"`kinds` has {unknown[0]!r}; choose from {', '.join(KINDS)}")
    if taus is None:
        taus = np.unique(np.geomspace(1, len(x) // 4, 24).astype(int)) / fs
    return {
        kind: getattr(allantools, KINDS[kind])(x, rate=fs, data_type="freq", taus=taus)[:2]
        for kind in kinds
    }
