"""Tables that a known tool writes without a header, told by their width and by where text
stands.
"""

from __future__ import annotations

from dataclasses import replace

AXES = ("x", "y", "z")
#: `ros2 topic echo --csv` of sensor_msgs/Imu: (columns, place of the text) -> names.
KNOWN = {
    (40, 2): (
        "secs",
        "nsecs",
        "frame_id",
        *(f"orientation.{a}" for a in (*AXES, "w")),
        *(f"orientation_covariance.{i}" for i in range(9)),
        *(f"angular_velocity.{a} [rad/s]" for a in AXES),
        *(f"angular_velocity_covariance.{i}" for i in range(9)),
        *(f"linear_acceleration.{a} [m/s^2]" for a in AXES),
        *(f"linear_acceleration_covariance.{i}" for i in range(9)),
    )
}


def with_names(layout):
    """The layout with the header that its tool left out; as it is where it is no such table."""
    texts = [i for i, k in enumerate(layout.kinds) if k == "text"]
    names = KNOWN.get((len(layout.kinds), texts[0])) if len(texts) == 1 else None
    return layout if layout.header is not None or names is None else replace(layout, header=names)
