"""What the filter knows at its first epoch, from an alignment."""

import numpy as np
from scipy.spatial.transform import Rotation

from . import attitude, earth
from .structures import State


def initial_state(start, arm, turn, x, p_sensor):
    """State of the sensor's point.

    start : `alignment.Alignment`, in the vehicle's axes; arm (3,) m, vehicle axes: from the sensor
    to the point whose position it has; turn (3, 3): the case's axes into the vehicle's, or None; x
    (m,), p_sensor (m, m): sensor states and their covariance
    """
    nav = np.zeros(16)
    away = attitude.matrix(start.attitude) @ arm
    nav[:3] = earth.shift(start.position, -away)
    nav[3:6] = start.velocity
    q = attitude.quaternion(start.attitude)
    if turn is not None:
        attitude.rotate_body(q, Rotation.from_matrix(turn).as_rotvec())
    nav[6:10] = q
    p = np.zeros((9 + x.size, 9 + x.size))
    p[np.arange(9), np.arange(9)] = start.sd**2
    # an attitude that is off puts the sensor where it is not
    cross = np.array([[0.0, -away[2], away[1]], [away[2], 0.0, -away[0]], [-away[1], away[0], 0.0]])
    put = -cross * start.sd[6:9] ** 2
    p[:3, 6:9], p[6:9, :3] = put, put.T
    p[:3, :3] -= put @ cross.T
    p[9:, 9:] = p_sensor
    return State(nav, np.array(x), p, np.zeros(4))
