"""Is a stated unit possible? Gravity tells for accelerometers, noise and Earth for gyros, turning
for both.

A number that cannot be what it is said to be is refused, with the unit it more likely has; nothing
is converted on suspicion.
"""

from __future__ import annotations

import numpy as np

from imu_lib import units
from imu_lib.readers import names

MOST = 200_000  # samples looked at
GRAVITY = (7.0, 13.0)  # m/s^2; a poor accelerometer is 10 % off, a bumpy ride averages out
GYRO_NOISE = 2e-3  # rad/s/sqrt(Hz), 7 deg/sqrt(h): above the noisiest gyro sold as one
GYRO_BIAS = 0.6  # rad/s, 34 deg/s: MEMS data sheets allow 20
GYRO_FAST = 17.0  # rad/s, 1000 deg/s, for one per cent of the time: not in a vehicle
RATIO = (
    1.5,
    60.0,
)  # m/s^2 per rad/s: accelerometer over gyro noise density of the MEMS units measured (5 to 25)


def gravity(accel: np.ndarray) -> float | None:
    """Median length of the specific force (n, 3) where it is the length of one vector, None where
    gravity was taken out.
    """
    accel = _some(accel)
    if len(accel) < 2:
        return None
    size = np.linalg.norm(accel, axis=1)
    middle = float(np.median(size))
    if middle == 0.0:
        return None
    spread = float(np.quantile(size, 0.75) - np.quantile(size, 0.25)) / middle
    # zero-mean noise has a spread of about 0.6 and a mean vector near 0; a vector that only turns
    # has a small spread
    return middle if np.linalg.norm(accel.mean(axis=0)) > 0.5 * middle or spread < 0.3 else None


def accel_unit(accel: np.ndarray, unit: str, factor: float) -> str | None:
    """A sentence where `accel` (n, 3) m/s^2, stated in `unit`, cannot be; None where it can."""
    size = gravity(accel)
    if size is None or GRAVITY[0] < size < GRAVITY[1]:
        return None
    read = size / factor
    for other, scale in names.ACCEL_UNITS.items():
        if GRAVITY[0] < read * scale < GRAVITY[1] and other != unit:
            return f"the specific force stated in {unit} has a median length of {read:.4g}, that is {size / units.G:.3g} times gravity; its unit is likely {other}"
    if size < 0.5:
        return None  # what is left when gravity was taken out
    return (
        f"the specific force stated in {unit} has a median length of {size / units.G:.3g} times gravity; "
        + (
            f"if these are counts, counts:{read:.5g} (per g) is near"
            if read > 50
            else "check its unit and scale"
        )
    )


def gyro_unit(
    gyro: np.ndarray, accel: np.ndarray | None, rate: float, unit: str, *, strict: bool
) -> str | None:
    """A sentence where `gyro` (n, k) rad/s, stated in `unit`, cannot be; None where it can.

    `strict` also holds the noise against that of the accelerometer, which alone tells rad/s read
    as deg/s at rest.
    """
    factor = names.GYRO_UNITS.get(unit)
    turning = _turning(gyro, accel, rate)
    if turning is not None and turning[1]:
        slope = turning[0]
        for other, scale in names.GYRO_UNITS.items() if factor else ():
            if other != unit and 0.5 < slope / (scale / factor) < 2.0:
                return f"gravity turns {slope:.3g} times as fast as the rates stated in {unit} say; their unit is likely {other}"
        return (
            None
            if 0.2 < slope < 5
            else f"gravity turns {slope:.3g} times as fast as the rates stated in {unit} say; check the unit and scale"
        )
    still, bias = _still(gyro, rate)
    if still > GYRO_NOISE or bias > GYRO_BIAS:
        worst = (
            f"a noise of {still / units.DEG_PER_SQRT_HOUR:.3g} deg/sqrt(h)"
            if still > GYRO_NOISE
            else f"a bias of {bias / units.DEG_PER_S:.3g} deg/s"
        )
        said = f"the rates stated in {unit} have {worst}, more than any gyro at rest"
        if factor is None or _whole(gyro / factor):
            return (
                said + "; they are likely raw counts (counts:C, C counts per deg/s)"
                if factor
                else said + "; check the counts per deg/s"
            )
        for other, scale in names.GYRO_UNITS.items():
            if (
                scale < factor
                and still * scale / factor <= GYRO_NOISE
                and bias * scale / factor <= GYRO_BIAS
            ):
                return f"{said}; their unit is likely {other}"
        return f"{said}; check the unit"
    fast = float(np.quantile(np.abs(_some(gyro)).max(axis=1), 0.99)) if len(gyro) > 200 else 0.0
    if factor and fast > GYRO_FAST:
        other = next((u for u, scale in names.GYRO_UNITS.items() if scale < factor), None)
        return (
            f"the rates stated in {unit} exceed {fast / units.DEG_PER_S:.3g} deg/s in one sample of a hundred; "
            + (f"their unit is likely {other}" if other else "check the unit")
        )
    factor = factor or 1.0
    if strict and accel is not None and still > 0:
        size = gravity(accel)
        noise = _noise_density(_some(accel), rate)
        if size is not None and noise > 7e-4 and noise / still > 250:
            for other, scale in sorted(names.GYRO_UNITS.items(), key=lambda u: u[1]):
                if scale > factor and RATIO[0] < noise / (still * scale / factor) < RATIO[1]:
                    return (
                        f"the rates stated in {unit} have a noise of {still / units.DEG_PER_SQRT_HOUR:.2g} deg/sqrt(h), "
                        f"{noise / still:.0f} times less than these "
                        f"accelerometers' noise would go with (usual: {RATIO[0]:g} to {RATIO[1]:g}); their unit is likely {other}"
                    )
    return None


def _some(x: np.ndarray) -> np.ndarray:
    """At most MOST rows without NaN, neighbours kept together."""
    x = x[: 2 * MOST]
    return x[~np.isnan(x).any(axis=1)][:MOST]


def _whole(x: np.ndarray) -> bool:
    x = _some(x)
    return (
        bool(len(x))
        and bool((np.abs(x - np.rint(x)) < 1e-6 * np.maximum(1.0, np.abs(x))).all())
        and float(np.abs(x).max()) > 20
    )


def _noise_density(x: np.ndarray, rate: float) -> float:
    """White noise coefficient N from the mean absolute difference of neighbours, middle axis."""
    if len(x) < 10:
        return 0.0
    return (
        float(np.median(np.mean(np.abs(np.diff(x, axis=0)), axis=0)))
        * np.sqrt(np.pi / 2)
        / np.sqrt(2 * rate)
    )


def _still(gyro: np.ndarray, rate: float) -> tuple[float, float]:
    """Noise density and largest bias of the quietest parts of a record: of a moving one, what it
    has when it stands.
    """
    block = max(20, int(rate))
    n = len(gyro) // block
    if n < 5:
        x = _some(gyro)
        return _noise_density(x, rate), float(np.abs(np.median(x, axis=0)).max()) if len(x) else 0.0
    parts = gyro[: n * block].reshape(n, block, -1)[:: max(1, n * block // (2 * MOST))]
    noise = (
        np.median(np.mean(np.abs(np.diff(parts, axis=1)), axis=1), axis=1)
        * np.sqrt(np.pi / 2)
        / np.sqrt(2 * rate)
    )
    swing = np.ptp(parts, axis=1).max(axis=1)
    good = np.flatnonzero(np.isfinite(noise) & np.isfinite(swing))
    if not good.size:
        return 0.0, 0.0
    quiet = good[np.argsort(swing[good], kind="stable")[: max(1, len(good) // 10)]]
    return float(np.median(noise[quiet])), float(
        np.abs(np.median(parts[quiet].mean(axis=1), axis=0)).max()
    )


def _turning(gyro, accel, rate):
    """(slope of measured gravity's turning on the gyro's, whether the record turned), None where
    it cannot be asked.
    """
    if accel is None or gyro.shape[1] != 3 or accel.shape[1] != 3:
        return None
    block = max(1, int(round(rate * 0.1)))
    n = min(len(gyro), 40 * MOST) // block
    if n < 10:
        return None
    a = accel[: n * block].reshape(n, block, 3).mean(axis=1)
    w = gyro[: n * block].reshape(n, block, 3).mean(axis=1)
    size = np.linalg.norm(a, axis=1, keepdims=True)
    good = np.isfinite(a).all(axis=1) & np.isfinite(w).all(axis=1) & (size[:, 0] > 0)
    if good.sum() < 10:
        return None
    unit_vector = np.where(good[:, None], a / np.where(size > 0, size, 1.0), 0.0)
    dt = block / rate
    turned = (unit_vector[2:] - unit_vector[:-2]) / (2 * dt)  # body axes: d(a)/dt = -w x a
    w = w - np.median(w[good], axis=0)
    smooth = (w[:-2] + 2 * w[1:-1] + w[2:]) / 4  # the rate over the span of the difference
    said = -np.cross(np.where(np.isfinite(smooth), smooth, 0.0), unit_vector[1:-1])
    use = (
        good[2:]
        & good[:-2]
        & good[1:-1]
        & (np.linalg.norm(turned, axis=1) > 0.1)
        & (np.linalg.norm(turned, axis=1) < 3.0)
    )
    if use.sum() < 8:
        return 0.0, False
    x, y = said[use].ravel(), turned[use].ravel()
    if (x @ x) == 0:
        return 0.0, False
    r = float(x @ y / np.sqrt((x @ x) * (y @ y)))
    return float(x @ y / (x @ x)), abs(r) > 0.8
