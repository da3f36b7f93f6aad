# ruff: noqa: UP031
"""Files with one fault each, for the remedies that errors print."""

from __future__ import annotations

import json
import zipfile

import numpy as np
from strange_logs import ACCEL, DPS, GYRO, I, N, T, clock, table

THREE, SIX = "gx,gy,gz", "gx,gy,gz,ax,ay,az"
NAMED = "--columns time,gyro_x,gyro_y,gyro_z"


def _holed(folder, drive):
    """Five minutes straight to the north at 10 m/s, of which the IMU lost two seconds in each forty."""
    t, fixes = np.arange(0.0, 300.0, 0.1), np.arange(0.0, 300.0)
    t = t[t % 40.0 < 38.0]
    north = np.tile(np.asarray(drive.gnss_position)[0], (len(fixes), 1))
    north[:, 0] += 10.0 * fixes / 6.37e6
    noise = np.random.default_rng(1).normal(size=(2, len(t), 3))
    np.savez(
        folder / "holed.npz",
        time=t,
        gyro=1e-3 * noise[0],
        accel=1e-2 * noise[1] - [0.0, 0.0, 9.806],
        gnss_time=fixes,
        gnss_position=north,
    )


def _drive(folder):
    """A short drive as .npz, as a table with a solution beside it, and with rates in deg/s."""
    from imu_lib import preset
    from imu_lib.navigation import simulation, trajectory, turin

    whole = turin.drive(1)
    path = trajectory.Trajectory(whole.position, whole.angles, 0.0, 120.0)
    drive = simulation.simulate_drive(path, preset("3dm-gx3-25-2013"), np.random.default_rng(8))
    drive.save(folder / "drive.npz")
    drive.with_(gyro=np.asarray(drive.gyro) * 180 / np.pi).save(folder / "degrees.npz")
    still = {"gyro": np.zeros((6000, 3)) + GYRO[0], "accel": np.zeros((6000, 3)) + ACCEL[0]}
    place = np.asarray(drive.gnss_position)[0]
    np.savez(
        folder / "parked.npz",
        time=np.arange(6000) / 100,
        **still,
        gnss_time=np.arange(60.0),
        gnss_position=np.tile(place, (60, 1)),
    )
    _holed(folder, drive)
    t = np.asarray(drive.time)
    head = "time [s],gx [rad/s],gy [rad/s],gz [rad/s],ax [m/s^2],ay [m/s^2],az [m/s^2]"
    (folder / "imu.csv").write_text(table(head, t, np.asarray(drive.gyro), np.asarray(drive.accel)))
    rows = [
        "% solution",
        "%  GPST  latitude(deg) longitude(deg) height(m) Q ns sdn(m) sde(m) sdu(m)",
    ]
    for s, (lat, lon, h) in zip(drive.gnss_time, drive.gnss_position):
        moment = np.datetime64("2024-05-17T10:00:00.000") + np.timedelta64(
            round(1000 * float(s)), "ms"
        )
        rows.append(
            f"{str(moment).replace('-', '/').replace('T', ' ')} {np.degrees(lat):.9f} {np.degrees(lon):.9f} {h:.4f} 1 9 0.5 0.5 1.0"
        )
    (folder / "fixes.pos").write_text("\n".join(rows) + "\n")
    day = np.datetime64("2024-06-01T00:00:00.000") + (1e3 * t).astype("timedelta64[ms]")
    (folder / "dated.csv").write_text(
        table(
            head.replace("[s]", ""),
            [str(d) for d in day],
            np.asarray(drive.gyro),
            np.asarray(drive.accel),
        )
    )
    return float(np.asarray(drive.gnss_time)[0])


def _bag(folder):
    from rosbags.rosbag1 import Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS1_NOETIC)
    types, zero = store.types, np.zeros(9)
    vector = types["geometry_msgs/msg/Vector3"]
    with Writer(folder / "two.bag") as writer:
        links = [
            writer.add_connection(t, "sensor_msgs/msg/Imu", typestore=store) for t in ("/a", "/b")
        ]
        for k in range(200):
            ns = 1_700_000_000_000_000_000 + k * 10_000_000
            head = types["std_msgs/msg/Header"](
                seq=k,
                stamp=types["builtin_interfaces/msg/Time"](ns // 10**9, ns % 10**9),
                frame_id="i",
            )
            message = types["sensor_msgs/msg/Imu"](
                head,
                types["geometry_msgs/msg/Quaternion"](0, 0, 0, 1),
                zero,
                vector(*GYRO[k]),
                zero,
                vector(*ACCEL[k]),
                zero,
            )
            for link in links:
                writer.write(link, ns, store.serialize_ros1(message, link.msgtype))


def files(folder):
    """Write everything that the calls below name."""
    (folder / "hours").mkdir()
    for k in range(2):
        x = np.random.default_rng(k).normal(0.0, 1e-3, 1000)
        np.savez(folder / "hours" / f"log_{k}.npz", time=10.0 * k + np.arange(1000) / 100, gyro_x=x)
    text = {}
    text["sound.csv"] = table(
        "time [s],gx [rad/s],gy [rad/s],gz [rad/s],ax [m/s^2],ay [m/s^2],az [m/s^2]", T, GYRO, ACCEL
    )
    text["plain.csv"] = table(f"time,{SIX}", T, GYRO, ACCEL)
    text["summed.csv"] = table(f"time,{SIX},status", T, GYRO / 100, ACCEL / 100, I * 0)
    text["named_wrong.csv"] = table("t [s],acc_x [deg/s],acc_y [deg/s],acc_z [deg/s]", T, DPS)
    text["loop.csv"] = table(f"loop_time_us,{THREE}", 2500 + I * 37 % 61, GYRO)
    text["range.csv"] = table("t [s],gx (500 dps),gy (500 dps),gz (500 dps)", T, DPS)
    text["lsb.csv"] = table(
        "time [s],gx [lsb],gy [lsb],gz [lsb]", T, np.rint(DPS * 100).astype(int)
    )
    text["furlong.csv"] = table("time [s],gx [furlong],gy [furlong],gz [furlong]", T, GYRO)
    text["kelvin.csv"] = table(f"time,{THREE},temp [rankine]", T, GYRO, T * 0 + 20)
    text["wrong.csv"] = table("time [s],ax [m/s^2],ay [m/s^2],az [m/s^2]", T, ACCEL / 9.80665)
    text["hollow.csv"] = table(f"time,{THREE},ax", T, GYRO, [""] * (N - 1) + [""])
    text["labels.csv"] = "time,sensor,x,y,z\n" + "".join(
        f"{k / 100},{'abc'[k % 2]},{GYRO[k, 0]:.6f},0.1,0.2\n" for k in I
    )
    text["mixed.csv"] = "time,sensor,x,y,z\n" + "".join(
        f"{k / 100},{'gyr' if k % 2 else 'acc'},{GYRO[k, 0]:.6f},0.1,0.2\n" for k in I
    )
    text["mixed_si.csv"] = "time,sensor,x,y,z\n" + "".join(
        f"{k / 200:.3f},{'gyr' if k % 2 else 'acc'},{','.join('%.6f' % v for v in (GYRO if k % 2 else ACCEL)[k])}\n"
        for k in I
    )
    text["dates.csv"] = table(
        f"date,time,{THREE}",
        ["03/04/2021" if k < 200 else "05/06/2021" for k in I],
        clock((10, 0, 0)),
        GYRO,
    )
    text["clock.csv"] = table(
        f"time,{THREE}", [c if k != 300 else "25:99" for k, c in enumerate(clock((10, 0, 0)))], GYRO
    )
    frames = [f"10:59:{k // 17:02d}:{k % 17:02d}" for k in I]
    text["frames.csv"] = table(f"tc,{THREE}", frames, GYRO)
    text["rad.csv"] = table("t [s],gyro_x [rad],gyro_y [rad],gyro_z [rad]", T, GYRO / 100)
    text["rises.csv"] = table(f"moment_of_it,{THREE}", T + 4, GYRO)
    text["g_of_x.csv"] = table("Time [s],G(x),G(y),G(z)", T, ACCEL / 9.80665)
    text["soon.csv"] = table(
        f"date,clock,{THREE}",
        ["2021-03-04"] * N,
        [c if k != 300 else "soon" for k, c in enumerate(clock((10, 0, 0)))],
        GYRO,
    )
    text["ticks.csv"] = table(f"ticks,{THREE}", I * 328, GYRO)
    text["unit_open.csv"] = table(f"timestamp,{THREE}", I * 640 + 5, GYRO)
    text["ms_as_s.csv"] = table(f"time [s],{THREE}", I * 10, GYRO)
    text["no_time.csv"] = table(THREE, GYRO)
    text["unnamed.csv"] = table("a,b,c,d", T, GYRO)
    angles = np.cumsum(GYRO, axis=0) * 0.573
    text["angles.csv"] = table("t [s],GyroX (deg),GyroY (deg),GyroZ (deg),ax [m/s^2],ay [m/s^2],az [m/s^2]", T, angles, ACCEL)  # fmt: skip
    text["two.csv"] = table(f"t,I,{THREE}", T, I % 2, GYRO)
    text["fall.csv"] = table(f"time,{THREE}", np.where(I % 50 == 30, T - 0.2, T), GYRO)
    text["fall_clock.csv"] = table(
        f"date,time,{THREE}",
        ["2021-03-04"] * N,
        [c if k % 50 else "09:00:00.000" for k, c in enumerate(clock((10, 0, 0)))],
        GYRO,
    )
    text["nan.csv"] = table(f"time,{THREE}", np.where(I == 20, np.nan, T), GYRO)
    text["one_stamp.csv"] = table(f"time,{THREE}", T * 0 + 5, GYRO)
    text["one_date.csv"] = table(f"date,{THREE}", ["2021-03-04"] * N, GYRO)
    text["sheet.csv"] = table(
        f"time,{THREE}", [f"{k // 6000:02d}:{k // 100 % 60:02d}.{k // 10 % 10}" for k in I], GYRO
    )
    text["twice.csv"] = table(f"time,{THREE}", np.where(I == 20, 0.19, T), GYRO)
    text["letter_t.csv"] = table(f"T,{THREE}", 24.0 + 1e-3 * I, GYRO)
    text["both.csv"] = table("time [s],gx [deg/s],gyro_x [deg/s],gz [deg/s]", T, DPS)
    text["slow.csv"] = table(f"time,{SIX}", T[::2] * 2.7, GYRO[::2], ACCEL[::2])
    accel = [",".join("%.6f" % v for v in ACCEL[k]) if k % 4 == 0 else ",," for k in I]
    text["two_rates.csv"] = f"time [s],{SIX}\n" + "".join(
        f"{k / 100},{','.join('%.8f' % v for v in GYRO[k])},{accel[k]}\n" for k in I
    )
    text["stated_rate.csv"] = "sampling rate: 50\n" + table("time [s],gx,gy,gz", T, GYRO)
    text["g.csv"] = table("time [s],x,y,z", T, GYRO)
    text["turns.txt"] = "".join(f"{k},{k % 3},0.1,0.2,9.8\n" for k in range(N))
    text["a_later.csv"] = table("time [s],x,y,z", [f"{v:.3f}" for v in 1e9 + 3.99 + T], ACCEL)
    text["g_epoch.csv"] = table("time [s],x,y,z", [f"{v:.3f}" for v in 1e9 + T], GYRO)
    text["a_slow.csv"] = table("time [s],x,y,z", [f"{v:.3f}" for v in 1e9 + 3.9 + T * 4], ACCEL)
    text["hot.csv"] = table("time,temperature", T, T * 0 + 20)
    text["warm.csv"] = table("time,temperature", T * 10, T + 20)
    for name, content in text.items():
        (folder / name).write_text(content)
    np.savez(folder / "one.npz", time=T, gyro_x=GYRO[:, 0])
    np.savez(folder / "fine.npz", time=T, gyro=GYRO, accel=ACCEL)
    np.savez(folder / "matrix.npz", foo=np.c_[T, GYRO, ACCEL])
    np.savez(folder / "slow.npz", time=I * 1e5, gyro=GYRO)
    np.savez(folder / "temperature.npz", temperature=T + 20, bar=np.c_[T, GYRO, ACCEL])
    one = table(f"time [s],{THREE}", T, GYRO)
    with zipfile.ZipFile(folder / "many.zip", "w") as packed:
        packed.writestr("first.csv", one)
        packed.writestr("second.csv", one)
    for name, rate in (("logs", (100, 50)), ("even", (100, 100))):
        (folder / name).mkdir()
        for k, fs in enumerate(rate):
            np.savez(
                folder / name / f"{k}.npz",
                time=10 * k + np.arange(400) / fs,
                gyro=GYRO[:: 1 - 2 * k],
            )
    model = {"gyro_x": [{"process": "white_noise", "N": 2e-4}]}
    (folder / "model.json").write_text(json.dumps(model))
    hot = {
        "gyro_x": [{"process": "temperature", "slope": 1e-4, "reference": 20.0}, *model["gyro_x"]],
        "rate": 10.0,
    }
    (folder / "hot.json").write_text(json.dumps(hot))
    rng = np.random.default_rng(3)
    ways = rng.standard_normal((24, 3))
    ways *= 9.81 / np.linalg.norm(ways, axis=1, keepdims=True)
    poses = np.repeat(ways, 300, axis=0) + rng.normal(0, 1e-2, (7200, 3))
    np.savez(folder / "poses.npz", time=np.arange(7200) / 100, accel=poses)
    (folder / "full").mkdir()
    (folder / "full" / "x.txt").write_text("x")
    _bag(folder)
    _drive(folder)
