"""Every format opens, states or asks for its units, and gives the same numbers."""

import numpy as np
import pytest
from still_sensor import RATE, N, record, same, still, table

from imu_lib import units
from imu_lib.errors import InputError
from imu_lib.readers import names, read_record
from imu_lib.readers.plausibility import gravity
from imu_lib.writers import write_record


@pytest.mark.parametrize("suffix", [".npz", ".csv", ".tsv", ".txt", ".parquet"])
def test_round_trip(tmp_path, suffix):
    write_record(record(), tmp_path / f"r{suffix}")
    found = read_record(tmp_path / f"r{suffix}")
    assert same(found) and np.allclose(found.temperature, record().temperature)
    part = read_record(tmp_path / f"r{suffix}", start=2.0, stop=4.0)
    assert part.n == 100 and np.array_equal(part["gyro_x"], found["gyro_x"][100:200])


@pytest.mark.parametrize("delimiter", [",", ";", "\t", " ", "|", "   "])
@pytest.mark.parametrize("header", [True, False])
def test_any_delimiter(tmp_path, delimiter, header):
    path = table(tmp_path / "t.txt", delimiter=delimiter, header=header)
    columns = None if header else "time,gyro_x,gyro_y,gyro_z,accel_x,accel_y,accel_z"
    assert same(read_record(path, gyro_unit="rad/s", accel_unit="m/s^2", columns=columns))


def test_decimal_commas_comments_and_blank_lines(tmp_path):
    path = table(tmp_path / "t.csv", delimiter=";", decimal=",", comment="# logged by hand\n")
    lines = path.read_text().splitlines()
    path.write_text("\n".join(lines[:50] + ["# a remark", ""] + lines[50:]) + "\n")
    assert same(read_record(path, gyro_unit="rad/s", accel_unit="m/s^2"))


@pytest.mark.parametrize(
    ("gyro", "factor"),
    [
        ("deg/s", units.DEG_PER_S),
        ("deg/h", units.DEG_PER_HOUR),
        ("counts:131", units.DEG_PER_S / 131),
    ],
)
@pytest.mark.parametrize(
    ("accel", "scale"), [("g", units.G), ("mg", units.MILLI_G), ("counts:16384", units.G / 16384)]
)
def test_stated_units(tmp_path, gyro, factor, accel, scale):
    path = table(tmp_path / "t.csv", gyro=factor, accel=scale)
    assert same(read_record(path, gyro_unit=gyro, accel_unit=accel))


def test_units_of_the_header_and_columns_that_are_skipped(tmp_path):
    g, a = still()
    t = np.arange(N) * 20_000
    data = np.column_stack([np.arange(N), t, g / units.DEG_PER_S, np.full(N, 40.0), a / units.G])
    head = "n_samples,timestamp [us],Gyro X (deg/s),Gyro Y (deg/s),Gyro Z (deg/s),mag_x,Acc_X [g],Acc_Y [g],Acc_Z [g]"
    np.savetxt(tmp_path / "t.csv", data, delimiter=",", header=head, comments="", fmt="%.12g")
    assert same(read_record(tmp_path / "t.csv"))
    np.savetxt(tmp_path / "u.csv", data, delimiter=",", fmt="%.12g")
    columns = "-,time[us],gyro_x,gyro_y,gyro_z,-,accel_x,accel_y,accel_z"
    assert same(read_record(tmp_path / "u.csv", columns=columns, gyro_unit="deg/s", accel_unit="g"))


def test_euroc(tmp_path):
    g, a = still()
    stamp = 1403636579758555392 + 20_000_000 * np.arange(N)  # beyond what a float holds exactly
    head = "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],a_RS_S_x [m s^-2],a_RS_S_y [m s^-2],a_RS_S_z [m s^-2]"
    rows = [
        f"{s}," + ",".join(f"{v:.12g}" for v in row)
        for s, row in zip(stamp, np.column_stack([g, a]))
    ]
    (tmp_path / "data.csv").write_text("\r\n".join([head, *rows]) + "\r\n")
    assert same(read_record(tmp_path / "data.csv"))


def test_increments(tmp_path):
    g, a = still()
    np.savetxt(
        tmp_path / "i.txt",
        np.column_stack([5e5 + np.arange(N) / RATE, g / RATE, a / RATE]),
        fmt="%.15g",
    )
    columns = "time[s],dtheta_x[rad],dtheta_y[rad],dtheta_z[rad],dv_x[m/s],dv_y[m/s],dv_z[m/s]"
    found = read_record(tmp_path / "i.txt", columns=columns)
    assert same(found, rtol=1e-7) and "divided by the sampling interval" in found.notes[0]


def test_dates_and_clocks_across_midnight(tmp_path):
    g, a = still(200)
    stamps = np.datetime64("2024-02-28T23:59:58.5") + (np.arange(200) * 20_000).astype(
        "timedelta64[us]"
    )
    split = [str(s).split("T") for s in stamps.astype("datetime64[ms]")]
    rows = [
        f"{d} {c} " + " ".join(f"{v:.12g}" for v in row)
        for (d, c), row in zip(split, np.column_stack([g, a]))
    ]
    (tmp_path / "d.txt").write_text("\n".join(rows) + "\n")
    options = {"gyro_unit": "rad/s", "accel_unit": "m/s^2"}
    found = read_record(
        tmp_path / "d.txt",
        columns="date,clock,gyro_x,gyro_y,gyro_z,accel_x,accel_y,accel_z",
        **options,
    )
    assert same(found) and found.gaps() == ()
    (tmp_path / "c.txt").write_text(
        "clock,gx,gy,gz,ax,ay,az\n" + "\n".join(",".join(r.split()[1:]) for r in rows) + "\n"
    )
    assert same(read_record(tmp_path / "c.txt", **options))


def test_two_files_with_epochs_are_laid_over_each_other(tmp_path):
    g, a = still()
    t = 1.7e9 + np.arange(N) / RATE
    for name, x, part in (("g.csv", g, slice(0, 500)), ("a.csv", a, slice(100, 600))):
        np.savetxt(
            tmp_path / name,
            np.column_stack([t, x])[part],
            delimiter=",",
            header="time,x,y,z",
            comments="",
            fmt="%.12f",
        )
    found = read_record(
        gyro=tmp_path / "g.csv", accel=tmp_path / "a.csv", gyro_unit="rad/s", accel_unit="m/s^2"
    )
    assert (
        found.n == 400
        and np.allclose(found["gyro"], g[100:500])
        and np.allclose(found["accel"], a[100:500])
    )
    assert any("no partner" in note for note in found.notes)


@pytest.mark.parametrize("version", ["4", "5", "7.3"])
def test_matlab(tmp_path, version):
    g, a = still()
    path = tmp_path / "m.mat"
    if version == "7.3":
        import h5py

        with h5py.File(path, "w") as file:
            file["imu/gyro"], file["imu/acc"], file["imu/fs"] = g.T, a.T, [[RATE]]
    else:
        import scipy.io

        content = {"gyro": g, "acc": a, "fs": RATE}
        scipy.io.savemat(
            path,
            content if version == "4" else {"imu": content},
            format=version,
            do_compression=version == "5",
        )
    assert same(read_record(path, gyro_unit="rad/s", accel_unit="m/s^2"))
    with pytest.raises(InputError, match="--gyro-unit"):
        read_record(path)


def test_ros_bags(tmp_path):
    rosbags = pytest.importorskip("rosbags.rosbag2")
    from rosbags.rosbag1 import Writer as Writer1
    from rosbags.typesys import Stores, get_typestore

    g, a = still(80)
    for kind, store in (
        ("ros2", get_typestore(Stores.ROS2_HUMBLE)),
        ("ros1", get_typestore(Stores.ROS1_NOETIC)),
    ):
        types = store.types
        path = tmp_path / ("bag" if kind == "ros2" else "one.bag")
        with rosbags.Writer(path, version=9) if kind == "ros2" else Writer1(path) as writer:
            connection = writer.add_connection("/imu", "sensor_msgs/msg/Imu", typestore=store)
            for k in range(80):
                ns = 1_700_000_000_000_000_000 + k * 20_000_000
                stamp = types["builtin_interfaces/msg/Time"](ns // 10**9, ns % 10**9)
                head = {"stamp": stamp, "frame_id": "i"} | ({"seq": k} if kind == "ros1" else {})
                vector, zero = types["geometry_msgs/msg/Vector3"], np.zeros(9)
                message = types["sensor_msgs/msg/Imu"](
                    types["std_msgs/msg/Header"](**head),
                    types["geometry_msgs/msg/Quaternion"](0, 0, 0, 1),
                    zero,
                    vector(*g[k]),
                    zero,
                    vector(*a[k]),
                    zero,
                )
                data = (
                    store.serialize_cdr(message, connection.msgtype)
                    if kind == "ros2"
                    else store.serialize_ros1(message, connection.msgtype)
                )
                writer.write(connection, ns, data)
        found = read_record(path)
        assert (
            found.n == 80
            and np.allclose(found["gyro"], g)
            and np.allclose(found["accel"], a)
            and found.rate == RATE
        )


def test_names():
    told = {
        "#timestamp [ns]": ("time", "ns"), "w_RS_S_x [rad s^-1]": ("gyro_x", "rad/s"), "accel_z_mps2": ("accel_z", "m/s^2"),
        "field.linear_acceleration.y": ("accel_y", None), "gyro_x_dps": ("gyro_x", "deg/s"), "Acc_X [mg]": ("accel_x", "mg"),
        "Temperature (°C)": ("temperature", "degC"), "gx [mdps]": ("gyro_x", "mdps"), "mag_x": (None, None), "latitude": (None, None),
        "dtheta_x": ("dtheta_x", None), "dv_y": ("dv_y", None), "n_samples": ("index", None), "t_ms": ("time", "ms"), "roll": (None, None),
    }  # fmt: skip
    assert {name: names.parse(name) for name in told} == told


@pytest.mark.parametrize(
    ("gyro", "accel", "likely"),
    [
        (1.0, units.G, "likely g"),
        (1.0, units.MILLI_G, "likely mg"),
        (units.DEG_PER_S, 1.0, "likely deg/s"),
        (units.DEG_PER_HOUR, 1.0, "likely deg/h"),
    ],
)
def test_an_impossible_unit_is_refused_with_the_likely_one(tmp_path, gyro, accel, likely):
    path = table(tmp_path / "t.csv", gyro=gyro, accel=accel)
    with pytest.raises(InputError, match=likely):
        read_record(path, gyro_unit="rad/s", accel_unit="m/s^2")
    assert read_record(path, gyro_unit="rad/s", accel_unit="m/s^2", trust_units=True).n == N


def test_rates_taken_57_times_too_small_are_refused(tmp_path):
    path = table(tmp_path / "t.csv")
    with pytest.raises(InputError, match="likely rad/s"):
        read_record(path, gyro_unit="deg/s", accel_unit="m/s^2")


def test_gravity_is_told_from_noise():
    rng = np.random.default_rng(7)
    assert gravity(rng.normal(size=(5000, 3))) is None
    turned = rng.normal(size=(20, 3))
    turned *= 9.8 / np.linalg.norm(turned, axis=1, keepdims=True)
    assert gravity(np.repeat(turned, 100, axis=0)) == pytest.approx(9.8)


LOGS = {
    "phone app": (
        '"Time (s)";"Gyroscope x (rad/s)";"Gyroscope y (rad/s)";"Gyroscope z (rad/s)"',
        ";",
        ",",
        {},
    ),
    "blanks before units": ("# t [s] gx [rad/s] gy (rad/s) gz [rad/s]", " ", ".", {}),
    "trailing delimiter": ("time,gx,gy,gz,", ",", ".", {"gyro_unit": "rad/s"}),
    "evaluation board": (
        "Time [s],X_GYRO_OUT,Y_GYRO_OUT,Z_GYRO_OUT",
        ",",
        ".",
        {"gyro_unit": "rad/s"},
    ),
    "byte order mark": ("\ufefftime|w_x [rad/s]|w_y [rad/s]|w_z [rad/s]", "|", ".", {}),
}


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16", "latin-1"])
@pytest.mark.parametrize("name", LOGS)
def test_logs_as_programs_write_them(tmp_path, name, encoding):
    head, delimiter, decimal, options = LOGS[name]
    if encoding == "latin-1":
        head = head.lstrip("\ufeff")
    g, _ = still()
    rows = [
        delimiter.join(f"{v:.12g}".replace(".", decimal) for v in row)
        for row in np.column_stack([np.arange(N) / RATE, g])
    ]
    if head.endswith(delimiter):
        rows = [row + delimiter for row in rows]
    (tmp_path / "log.txt").write_text("\n".join([head, *rows]) + "\n", encoding=encoding)
    found = read_record(tmp_path / "log.txt", **options)
    assert np.allclose(found["gyro"], g) and found.rate == RATE
