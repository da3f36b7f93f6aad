"""`imu-lib calibrate FILE`: bias, scale factor and cross-coupling from static poses or a rate
table.
"""

from __future__ import annotations

import math

from imu_lib.cli import common
from imu_lib.errors import InputError

NAME = "calibrate"
#: Names of the files in --out DIR.
WRITES = ("calibration.json", "*.png")
HELP = (
    "Bias, scale factor and cross-coupling of accelerometers and gyroscopes: from poses put down "
    "by hand (24 or more, each axis up, down and level; the rests are found), or from poses or "
    "rates that --poses lists."
)


def add_arguments(parser):
    common.add_record_arguments(parser)
    parser.add_argument(
        "--poses",
        metavar="FILE",
        help="what was done when: CSV with start, stop (s) and x, y, z (g) or rate_x, rate_y, "
        "rate_z (deg/s) or angle_x, angle_y, angle_z (deg); or JSON sections x_p x_a x_rot ... in "
        "samples",
    )
    parser.add_argument(
        "--gravity",
        type=common.positive,
        metavar="G",
        help="local gravity, m/s^2 (9.80665 where not given)",
    )
    parser.add_argument(
        "--latitude", type=common.number, metavar="DEG", help="gives gravity instead, with --height"
    )
    parser.add_argument(
        "--height", type=common.number, metavar="M", help="above the ellipsoid, with --latitude"
    )
    parser.add_argument("--out", metavar="DIR", help="write calibration.json and figures there")
    common.add_json_argument(parser)


def run(args):
    common.check_writable(args.json)
    common.check_out(args.out)
    gravity = local_gravity(args)
    record = common.open_record(args)
    from imu_lib import calibration

    found = calibration.calibrate_record(record, poses=args.poses, gravity=gravity)
    result = {"record": record.source or record.name, **found.to_json()}
    if args.out:
        with common.atomic_folder(args.out) as folder:
            common.write_json(result, folder / "calibration.json")
            figures(record, found, folder)
    common.write_json(result, args.json)
    if args.json != "-":
        print(report(record, found))


def local_gravity(args) -> float:
    """Gravity from the flags, m/s^2."""
    from imu_lib import units
    from imu_lib.navigation import earth

    if args.latitude is None:
        if args.height is not None:
            raise InputError("--height needs --latitude.")
        if args.gravity is not None and not 9.7 < args.gravity < 9.9:
            raise InputError(
                f"--gravity {args.gravity:g} is not that of any place on Earth, 9.76 to 9.84 "
                "m/s^2; give it in m/s^2, or --latitude and --height."
            )
        return units.G if args.gravity is None else args.gravity
    if args.gravity is not None:
        raise InputError("Give --gravity, or --latitude with --height, not both.")
    if abs(args.latitude) > 90:
        raise InputError(f"--latitude {args.latitude:g} is not between -90 and 90 degrees.")
    if args.height is not None and not -500 <= args.height <= 10_000:
        raise InputError(f"--height {args.height:g} is not between -500 and 10,000 m.")
    return float(earth.gravity(args.latitude * units.DEG, args.height or 0.0))


def report(record, found) -> str:
    """The calibration as text, in datasheet units."""
    from imu_lib import units

    lines = [
        f"record   {record.source or record.name}",
        f"method   {found.method}; {len(found.windows)} windows, gravity {found.gravity:.6g} m/s^2",
    ]
    kinds = (
        ("accelerometers", found.accelerometers, units.MILLI_G, "mg"),
        ("gyroscopes", found.gyroscopes, units.DEG_PER_S, "deg/s"),
    )
    for name, triad, unit, label in kinds:
        if triad is None:
            continue
        rows = []
        for i, axis in enumerate("xyz"):
            cross = [triad.cross_coupling.get(axis + other) for other in "xyz"]
            rows.append(
                (
                    axis,
                    _text(triad.biases[i], 1 / unit),
                    _text(triad.scale_factors[i], 100),
                    *(_text(c, 1e3) if j != i else "" for j, c in enumerate(cross)),
                )
            )
        head = (
            name,
            f"bias, {label}",
            "scale factor, %",
            *(f"cross from {a}, mrad" for a in "xyz"),
        )
        lines += ["", common.table(rows, head)]
        what = {
            "accelerometers": ("m/s^2", 1.0),
            "gyroscopes": ("deg/s" if found.rests is None else "deg", units.DEG),
        }[name]
        fit = (
            f"residual {triad.residual_sd / what[1]:.3g} {what[0]}, {triad.dof} degrees of freedom"
        )
        if not math.isnan(triad.consistency):
            fit += (
                "; mean square of the residuals over what the noise explains: "
                f"{triad.consistency:.3g}"
            )
        lines.append(fit)
    lines += ["", "Values with 95 % intervals; - where the record does not determine the quantity."]
    return "\n".join(lines + [f"note: {n}" for n in found.notes])


def _text(estimate, factor) -> str:
    if estimate is None:
        return "-"
    v, low, high = (x * factor for x in (estimate.value, estimate.low, estimate.high))
    return f"{v:.4g} +- {(high - low) / 2:.2g}"


def figures(record, found, folder) -> None:
    """Rests and pose magnitudes as PNG."""
    import numpy as np

    from imu_lib import plots

    plots.headless()
    if found.rests is not None:
        accel = record.continuous()["accel"]
        ax = plots.rest_windows(accel, record.rate, found.rests)
        plots.save(ax, folder / "rests.png")
        before = np.linalg.norm(found.rests.means(accel), axis=1)
        ax = plots.pose_magnitudes(before, found.magnitude, found.gravity)
        plots.save(ax, folder / "poses.png")
    elif found.magnitude is not None:
        plots.save(
            plots.pose_magnitudes(None, found.magnitude, found.gravity), folder / "poses.png"
        )
