"""A fix taken by the filter, compiled: its tests, then its updates one number after the other."""

import numpy as np
from numba import njit

from . import covariance, measurement
from .measurement import POSITION, RECOVERED, REJECTED_POSITION, VELOCITY, WILD
from .pieces import copy, zero


@njit(cache=True)
def take_fix(live, how, fixes, f, moment, rejected, room, logs):
    """One fix: tests, then the updates with what passed, one number after the other. The correction
    goes into room.dx (n,); whether there is one is returned.

    moment : `structures.Body`, white (6,) densities and the length of the interval, s
    """
    body, white, step = moment
    y, arm, variance = logs.innovation[f], np.empty(3), np.empty(6)
    s, dx, h6 = logs.covariance[f], room.dx, room.h6
    measurement.innovation(live, how, body, fixes, f, y, arm)
    measurement.fill_rows(h6, live, how, body.motion, arm, fixes.delay[f], fixes.time[f])
    measurement.fill_variance(fixes.variance[f], live.c, arm, white, step, variance)
    measurement.fill_covariance(live.pieces, h6, room.tail, variance, room.ph, s)
    copy(live.nav[3:6], logs.velocity[f])
    bits, likelihood = _tested(live.pieces, how, fixes.use[f], (y, s), variance, rejected)
    zero(dx)
    nis, freedom = 0.0, 0
    for i in range(6):
        if (i < 3 and bits & POSITION) or (i >= 3 and bits & VELOCITY):
            residual = y[i]
            for j in range(dx.size):
                residual -= h6[i, j] * dx[j]
            sigma2 = covariance.update(
                live.pieces, h6[i], room.tail, variance[i], room.gain, room.ph
            )
            for j in range(dx.size):
                dx[j] += room.gain[j] * residual
            nis += residual * residual / sigma2
            freedom += 1
            logs.normalised[f, i] = residual / np.sqrt(sigma2)
            if i >= 3 or how.outliers[0] == 0.0:
                likelihood -= 0.5 * (
                    residual * residual / sigma2 + np.log(sigma2) + measurement.LOG_2_PI
                )
    logs.nis[f], logs.freedom[f], logs.bits[f] = nis, freedom, bits
    logs.likelihood[f] = likelihood
    return freedom > 0


@njit(cache=True)
def _tested(pieces, how, use, innovation, variance, rejected):
    """(bits, log density of what may be wild) of a fix: which of its parts are taken; innovation :
    y (6,) and its covariance; variance (6,) grows where a position is wild, the filter's own where
    it has lost too many.
    """
    y, s = innovation
    bits, likelihood = 0, 0.0
    for part in range(2):
        if not use & (POSITION << part):
            continue
        if part == 0 and how.outliers[0] > 0.0:
            wild, density = measurement.wild_probability(s, y, how.outliers)
            bits |= POSITION
            likelihood += density
            if wild > 0.5:
                bits |= WILD
                for i in range(3):
                    variance[i] += how.outliers[1] ** 2
            continue
        square, _ = measurement.distance(s, y, 3 * part, 0.0)
        if square > how.gates[part]:
            rejected[part] += 1
            bits |= REJECTED_POSITION << part
            # the fixes agree among themselves, so it is the filter that is lost
            if rejected[part] > how.patience:
                for i in range(3 * part, 3 * part + 3):
                    pieces.nn[i, i] += y[i] * y[i]
                bits |= RECOVERED | (POSITION << part)
                rejected[part] = 0
        else:
            rejected[part] = 0
            bits |= POSITION << part
    return bits, likelihood
