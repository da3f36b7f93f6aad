"""The 15-state filter beside one assembled from another package: inu 2.5 (D. Woodburn), its
mechanization step and its Jacobian.

    pip install --target /tmp/inu --no-deps inu r3f && PYTHONPATH=... python
    benchmarks/outages_against_inu.py

Same drive, windows, start, fixes, noise densities and bias random walks; inu's `mech_step`
integrated by Euler steps, its `jacobian` discretised to first order as in its examples, position
and velocity updates with the plain Kalman gain. inu is not a dependency of this project.
"""

import argparse
import json
import os
import sys
import time
from pathlib import Path

import numpy as np

from imu_lib.drive import Drive
from imu_lib.navigation import attitude, earth, outages, statistics, tuning
from imu_lib.navigation.filter import FilterModel, LooselyCoupled
from imu_lib.navigation.preparation import Gnss

RESULT = Path(__file__).parent / "results" / "outages_against_inu.json"
DENSITIES = (
    3e-4,
    0.05,
    3e-5,
    3e-3,
)  # rad/s and m/s^2 per sqrt(Hz), bias walks per s and sqrt(Hz): a module in a car
TURN_ON = (3.5e-3, 0.2)


class Inu:
    """Fifteen states from inu: latitude, longitude, height, velocity, tilt, gyro bias,
    accelerometer bias.
    """

    def __init__(self, inu, start, offset):
        self.inu = inu
        self.llh, self.vne, self.c = (
            start.position.copy(),
            start.velocity.copy(),
            attitude.matrix(start.attitude),
        )
        meridian, transverse = earth.radii(self.llh[0])
        self.size = np.array([1.0 / meridian, 1.0 / (transverse * np.cos(self.llh[0])), 1.0])
        sd = np.concatenate(
            [
                start.sd[:3] * self.size,
                start.sd[3:9],
                np.full(3, TURN_ON[0]),
                np.full(3, TURN_ON[1]),
            ]
        )
        self.p, self.bias, self.offset = np.diag(sd**2), np.zeros(6), offset

    def step(self, rate, force, dt, *, covariance=True):
        rate, force = rate - self.offset - self.bias[:3], force - self.bias[3:]
        if covariance:
            phi = np.eye(15)
            phi[:9, :9] += self.inu.jacobian(force, self.llh, self.vne, self.c) * dt
            phi[6:9, 9:12], phi[3:6, 12:15] = -self.c * dt, self.c * dt
            self.p = phi @ self.p @ phi.T
            d = np.einsum("ii->i", self.p)
            d[3:6] += DENSITIES[1] ** 2 * dt
            d[6:9] += DENSITIES[0] ** 2 * dt
            d[9:12] += DENSITIES[2] ** 2 * dt
            d[12:] += DENSITIES[3] ** 2 * dt
        d_llh, d_vne, turn = self.inu.mech_step(force, rate, self.llh, self.vne, self.c)
        self.llh, self.vne = self.llh + d_llh * dt, self.vne + d_vne * dt
        q = _quaternion(self.c)
        attitude.rotate_body(q, turn * dt)
        q /= np.linalg.norm(q)
        attitude.fill_matrix(q, self.c)

    def update(self, value, variance, use):
        rows = np.concatenate(
            [np.arange(3) if use & 1 else [], np.arange(3, 6) if use & 2 else []]
        ).astype(int)
        z = np.concatenate([self.llh - value[:3], self.vne - value[3:]])[rows]
        r = (variance * np.concatenate([self.size**2, np.ones(3)]))[rows]
        gain = self.p[:, rows] @ np.linalg.inv(self.p[np.ix_(rows, rows)] + np.diag(r))
        x = gain @ z
        self.p = self.p - gain @ self.p[rows]
        self.p = 0.5 * (self.p + self.p.T)
        self.llh, self.vne = self.llh - x[:3], self.vne - x[3:6]
        q = _quaternion(self.c)
        attitude.rotate_frame(q, *x[6:9])
        attitude.fill_matrix(q, self.c)
        self.bias = self.bias + x[9:]

    def moment(self):
        return self.llh.copy(), self.vne.copy(), self.c.copy(), self.bias.copy()


def _quaternion(c):
    w = 0.5 * np.sqrt(max(1.0 + np.trace(c), 1e-12))
    if w < 0.1:  # near half a turn: by way of the Euler angles
        return attitude.quaternion(
            np.array(
                [np.arctan2(c[2, 1], c[2, 2]), -np.arcsin(c[2, 0]), np.arctan2(c[1, 0], c[0, 0])]
            )
        )
    return np.array(
        [
            w,
            (c[2, 1] - c[1, 2]) / (4 * w),
            (c[0, 2] - c[2, 0]) / (4 * w),
            (c[1, 0] - c[0, 1]) / (4 * w),
        ]
    )


def compare(inu, name, drive, gnss):
    model = FilterModel("15 states", tuning.vehicle_model(*DENSITIES), turn_on_sd=TURN_ON)
    engine = LooselyCoupled(drive, model, gnss=gnss)
    stretch = engine.prepared.stretches[0]
    windows = [
        w
        for w in outages.regular_windows(drive, duration=30.0, every=30.0, settle=60.0)
        if w.start + 30.0 < stretch.time[-1]
    ]
    study = outages.compare(drive, {"ours": model}, windows, gnss=gnss)
    solution = study.models["ours"].solution
    start = solution.alignments[0]
    offset = start.gyro_offset if start.standstill >= 2.0 else np.zeros(3)
    other, kept, began = Inu(inu, start, offset), {}, time.perf_counter()
    fixes = engine.prepared.fixes
    at = np.searchsorted(stretch.time, fixes.time - 1e-9)
    queue = [
        i
        for i in range(at.size)
        if start.epoch < at[i] < stretch.time.size and fixes.time[i] > start.used
    ]
    starts = {int(np.searchsorted(stretch.time, w.start - 1e-9)): w for w in study.windows}
    rate, force = stretch.dtheta / stretch.dt[:, None], stretch.dvel / stretch.dt[:, None]
    track = []
    for k in range(start.epoch, stretch.time.size - 1):
        other.step(rate[k], force[k], stretch.dt[k])
        while queue and at[queue[0]] <= k + 1:
            i = queue.pop(0)
            other.update(fixes.value[i], fixes.variance[i], fixes.use[i])
        track.append(other.llh.copy())
        if k + 1 in starts:
            kept[k + 1] = other.moment()
    per_epoch = (time.perf_counter() - began) / len(track) * 1e6
    theirs = []
    for k, w in starts.items():
        other.llh, other.vne, other.c, other.bias = (a.copy() for a in kept[k])
        path = []
        for j in range(
            k, int(np.searchsorted(stretch.time, w.start + w.duration + 1e-9, side="right")) - 1
        ):
            other.step(rate[j], force[j], stretch.dt[j], covariance=False)
            path.append(other.llh.copy())
        t = stretch.time[k + 1 : k + 1 + len(path)]
        theirs.append(earth.horizontal(np.array(path), truth_at(drive, t)).max())
    ours = study.errors("ours", against="reference")
    t = stretch.time[start.epoch + 1 : start.epoch + 1 + len(track)]
    return {
        "outages": len(ours),
        "ours": {
            "median": float(np.median(ours)),
            "mean": float(ours.mean()),
            "worst": float(ours.max()),
        },
        "inu": {
            "median": float(np.median(theirs)),
            "mean": float(np.mean(theirs)),
            "worst": float(np.max(theirs)),
        },
        "paired": statistics.paired(ours, theirs, ("ours", "inu")).to_json(),
        "inu_us_per_epoch": round(per_epoch, 1),
        "full_rms": {
            "ours": float(
                np.sqrt(np.mean(earth.horizontal(solution.at(t), truth_at(drive, t)) ** 2))
            ),
            "inu": float(
                np.sqrt(np.mean(earth.horizontal(np.array(track), truth_at(drive, t)) ** 2))
            ),
        },
    }


def truth_at(drive, time_):
    return np.column_stack(
        [np.interp(time_, drive.reference_time, c) for c in np.asarray(drive.reference_position).T]
    )


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--inu", metavar="DIR", help="folder that holds inu.py and r3f.py")
    args = parser.parse_args()
    if args.inu:
        sys.path.append(args.inu)
    try:
        import inu
    except ImportError:
        raise SystemExit(
            "inu is not installed: pip install --target DIR --no-deps inu r3f, then --inu DIR"
        ) from None
    data = Path(os.environ["IMU_LIB_DATA"]) / "drive"
    content = {
        "command": "python benchmarks/outages_against_inu.py --inu DIR",
        "date": time.strftime("%Y-%m-%d"),
        "inu": "2.5.7",
        "drives": {},
    }
    for name in ("span_a", "span_b", "span_c"):
        gnss = Gnss(
            accept=(1,) if name == "span_c" else None, velocity_floor=0.15, position_floor=0.5
        )
        content["drives"][name] = compare(inu, name, Drive.load(data / f"{name}.npz"), gnss)
        print(name, content["drives"][name])
    RESULT.write_text(json.dumps(content, indent=1) + "\n")


if __name__ == "__main__":
    main()
