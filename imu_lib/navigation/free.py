"""Parameters of the drive as states of the filter: which there are, what they act on, and how large
they may be before anything is known.
"""

from __future__ import annotations

import numpy as np

from imu_lib.errors import InputError

from .structures import MEASUREMENT_STATES

_PAIRS = ("xy", "xz", "yx", "yz", "zx", "zy")
_ALL = tuple(a + b for a in "xyz" for b in "xyz")
_ONE = ("x", "y", "z")
#: Group -> (components, standard deviation where nobody says). Scale factors of a few per cent,
#: axes within a degree or so, a receiver that lags some tenths of a second, an antenna within two
#: metres: consumer sensors in a car.
GROUPS = {
    "accel_scale": (_ONE, 0.03),
    "gyro_scale": (_ONE, 0.03),
    "accel_misalignment": (_PAIRS, 0.03),
    "gyro_misalignment": (_PAIRS, 0.03),
    "gyro_g_sensitivity": (_ALL, 2e-3),
    "accel_bias": (_ONE, 0.3),
    "gyro_bias": (_ONE, 0.02),
    "gnss_time_offset": (("offset",), 0.3),
    "velocity_offset": (("velocity_offset",), 0.3),
    "lever_arm": (_ONE, 2.0),
    "mounting": (("roll", "pitch", "yaw"), 0.1),
    "imu_clock": (("scale",), 1e-3),
    "speed_scale": (("scale",), 0.03),
}


def priors(*names, **others):
    """Groups with their usual standard deviations, and others with their own: `priors("lever_arm",
    accel_scale=0.01)`. InputError for an unknown group.
    """
    for name in (*names, *others):
        if name not in GROUPS:
            raise InputError(f"unknown group {name!r} of states; groups are {', '.join(GROUPS)}")
    return {**{n: GROUPS[n][1] for n in names}, **others}


def on_channels(free):
    """States that act on a channel's reading: list of (channel 0-5, driver -1 to 5, name, sd)."""
    out = []
    for group, sd in free.items():
        components, _ = GROUPS[group]
        if group in MEASUREMENT_STATES:
            continue
        base = 3 if group.startswith("accel") else 0
        for part, each in zip(components, np.broadcast_to(sd, len(components))):
            channel = base + "xyz".index(part[0])
            if group.endswith("bias"):
                driver = -1
            elif group == "gyro_g_sensitivity":
                driver = 3 + "xyz".index(part[1])
            else:
                driver = base + "xyz".index(part[-1])
            out.append((channel, driver, f"{group} {part}", float(each)))
    return out


def on_measurements(free, correlated=None, interval=1.0):
    """States that act on the measurements, in the kernel's order.

    correlated : (sigma m, correlation_time s) of the fixes' correlated errors, or None; interval s
    returns : names, sd (k,), transition (k,), noise (k,), first column of each group from 0 (-1
    where it has none)
    """
    names, sd, transition, noise, at = [], [], [], [], []
    for group in MEASUREMENT_STATES:
        if group == "gnss_correlated" and correlated is not None:
            at.append(len(names))
            step = float(np.exp(-interval / correlated[1]))
            for axis in ("north", "east", "down"):
                names.append(f"gnss_correlated {axis}")
                sd.append(correlated[0])
                transition.append(step)
                noise.append(correlated[0] ** 2 * (1.0 - step**2))
        elif group in free:
            at.append(len(names))
            components, _ = GROUPS[group]
            names += [f"{group} {part}" for part in components]
            sd += [float(s) for s in np.broadcast_to(free[group], len(components))]
            transition += [1.0] * len(components)
            noise += [0.0] * len(components)
        else:
            at.append(-1)
    return names, np.array(sd), np.array(transition), np.array(noise), np.array(at, np.int64)
