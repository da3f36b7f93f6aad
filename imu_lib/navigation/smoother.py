"""Rauch-Tung-Striebel smoothing of a closed-loop filter: the best that the same model and fixes
can give, past and future.

The filter keeps, at every fix and every second, its covariance before and after, the transition
since the last and the correction
it made. Backwards, the smoothed error relative to the filter's own solution is s_k = C_k (s_{k+1}
+ dx_{k+1}) with
C_k = P_k Phi' (P-_{k+1})^-1 (Gelb 1974, Eqs. 5.2-13 to 5.2-17, written for errors that are taken
out as they are found).
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from . import attitude, earth
from .filter import LooselyCoupled


@dataclass(frozen=True)
class Smoothed:
    """A smoothed solution at the stored moments.

    time (k,) s; position (k, 3); velocity (k, 3); attitude (k, 3); sd (k, 9); x (k, m) sensor
    states; p (k, 9 + m, 9 + m) where asked for
    """

    time: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    attitude: np.ndarray
    sd: np.ndarray
    x: np.ndarray
    p: np.ndarray | None = None


def smooth(engine: LooselyCoupled, *, withhold=(), covariances=False) -> Smoothed:
    """Run the filter forwards and the smoother backwards.

    engine : LooselyCoupled; withhold : windows (start s, duration s) without fixes: what
    interpolation over an outage would give, the bound that no causal filter reaches; covariances :
    keep the whole matrices
    """
    solution = engine.solve(withhold=withhold, smooth=True)
    pieces = [_stretch(m, covariances) for m in solution.moments]
    joined = [np.concatenate([p[i] for p in pieces]) for i in range(6)]
    return Smoothed(*joined, np.concatenate([p[6] for p in pieces]) if covariances else None)


def _stretch(moments, covariances):
    count, n = moments.time.size, moments.p.shape[1]
    correction, sd = np.zeros((count, n)), np.zeros((count, 9))
    s, p = np.zeros(n), moments.p[-1]
    kept = np.zeros((count, n, n)) if covariances else None
    for k in range(count - 1, -1, -1):
        if k < count - 1:
            prior = moments.prior[k + 1]
            # scaled to unit diagonal before the factorisation: metres and rad/s side by side would
            # cost the digits
            size = np.sqrt(np.maximum(np.diag(prior), 1e-300))
            factor = cho_factor(prior / np.outer(size, size) + 1e-12 * np.eye(n))
            gain = (
                cho_solve(factor, (moments.phi[k + 1] @ moments.p[k]) / size[:, None])
                / size[:, None]
            ).T
            s = gain @ (s + moments.dx[k + 1])
            p = moments.p[k] + gain @ (p - prior) @ gain.T
        correction[k] = s
        sd[k] = np.sqrt(np.maximum(np.diag(p)[:9], 0.0))
        if covariances:
            kept[k] = 0.5 * (p + p.T)
    nav = moments.nav
    position = earth.shift(nav[:, :3], -correction[:, :3])
    quaternions = nav[:, 6:10].copy()
    for q, turn in zip(quaternions, correction[:, 6:9]):
        attitude.rotate_frame(q, turn[0], turn[1], turn[2])
    out = (
        moments.time,
        position,
        nav[:, 3:6] - correction[:, 3:6],
        attitude.euler(quaternions),
        sd,
        moments.x + correction[:, 9:],
    )
    return (*out, kept)
