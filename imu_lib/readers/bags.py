"""ROS 1 and ROS 2 bags through `rosbags` (optional): the sensor_msgs/Imu topic, rad/s and m/s^2 by
its definition.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from imu_lib.errors import InputError
from imu_lib.readers.raw import Raw

IMU = ("sensor_msgs/msg/Imu", "sensor_msgs/Imu")


def is_bag(path: Path) -> bool:
    return path.suffix.lower() in (".bag", ".db3", ".mcap") or (
        path.is_dir() and (path / "metadata.yaml").exists()
    )


def read_bag(path, *, topic: str | None = None) -> Raw:
    """The messages of the one IMU topic, or of `topic`. InputError where there is none, or several
    and no choice.
    """
    try:
        from rosbags.highlevel import AnyReader, AnyReaderError
        from rosbags.typesys import Stores, get_typestore
    except ImportError:
        raise InputError(
            f"{path} is a ROS bag, which needs the package rosbags: pip install rosbags."
        ) from None
    path = Path(path)
    place = (
        path.parent
        if path.suffix.lower() in (".db3", ".mcap") and (path.parent / "metadata.yaml").exists()
        else path
    )
    stamp, arrival, rows = [], [], []
    try:
        with AnyReader([place], default_typestore=get_typestore(Stores.ROS2_HUMBLE)) as reader:
            for connection, received, data in reader.messages(
                connections=_chosen(reader.connections, path, topic)
            ):
                message = reader.deserialize(data, connection.msgtype)
                header = message.header.stamp
                own = int(header.sec) * 1_000_000_000 + int(header.nanosec)
                stamp.append(own)
                arrival.append(received)
                w, a = message.angular_velocity, message.linear_acceleration
                rows.append((w.x, w.y, w.z, a.x, a.y, a.z))
    except InputError:
        raise
    except AnyReaderError as error:
        raise InputError(
            f"{path} is not a readable ROS bag ({str(error).splitlines()[0][:90]}); record or "
            "copy it again."
        ) from None
    # a damaged bag fails deep inside sqlite, mcap, lz4 or the message parser, each in its own way
    except Exception as error:
        if isinstance(error, OSError) and error.errno is not None:
            raise
        raise InputError(
            f"{path} is damaged ({type(error).__name__}: "
            f"{(str(error).splitlines() or [''])[0][:70]}); record or copy it again."
        ) from None
    if len(rows) < 2:
        raise InputError(
            f"{path}: its IMU topic has {len(rows)} messages; at least two are needed."
        )
    return _columns(path, np.asarray(stamp, dtype=np.int64), arrival, np.asarray(rows, dtype=float))


def _chosen(connections, path, topic):
    """The connections of the one IMU topic. InputError where there is none, or several and no
    choice.
    """
    found = [c for c in connections if c.msgtype in IMU]
    chosen = [c for c in found if topic is None or c.topic == topic]
    if chosen and len({c.topic for c in chosen}) == 1:
        return chosen
    topics = ", ".join(sorted({c.topic for c in found})) or "none"
    raise InputError(
        f"{path}: "
        + (
            f"has several IMU topics ({topics}); choose one with --topic."
            if chosen
            else f"has no sensor_msgs/Imu topic{f' {topic}' if topic else ''} (IMU topics: "
            f"{topics})."
        )
    )


def _columns(path, own, arrival, values) -> Raw:
    """The messages as raw columns, by their own stamps (n,) ns or those of arrival."""
    raw = Raw(str(path), received=True, has_topics=True)
    # a driver that does not stamp leaves zeros; a simulated clock that begins at 0 goes on
    if (own == own[0]).all() or (own == 0).mean() > 0.5:
        raw.add(
            "time",
            np.asarray(arrival, dtype=np.int64),
            "ns",
            "arrival",
            "the messages' own stamps do not move",
        )
        raw.notes += ("The messages' own stamps do not move; the time of arrival is taken.",)
    else:
        raw.add("time", own, "ns", "header.stamp", "header.stamp of the messages")
        raw.skip("arrival", "`header.stamp` is the time")
    raw.add("gyro", values[:, :3], "rad/s", "angular_velocity", "rad/s by the message's definition")
    raw.add(
        "accel", values[:, 3:], "m/s^2", "linear_acceleration", "m/s^2 by the message's definition"
    )
    return raw
