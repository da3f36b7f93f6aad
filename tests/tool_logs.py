# ruff: noqa: E501, UP031
"""The same standing sensor as loggers, phones and flight controllers write it, line by line."""

from __future__ import annotations

import io
import json

import numpy as np
from strange_logs import ACCEL, DPS, GYRO, IN_G, SI, I, N, T, clock, table

DEG_G = "--gyro-unit deg/s --accel-unit g"
SIX = "gx,gy,gz,ax,ay,az"


def _lines(form):
    return "".join(form(k, GYRO[k], ACCEL[k]) for k in range(N))


def _three(x, form="%.9g", sep=","):
    return sep.join(form % v for v in x)


def _cell(v):
    return '"' + "\n".join(f"{c}: {x:.9g}" for c, x in zip("xyz", v)) + '"'


def _gyroflow(scales, t, gyro, accel):
    return (
        f"GYROFLOW IMU LOG\nversion,1.3\nid,own\norientation,YxZ\ntimestamp,1644159993\n{scales}\n"
        + table("t," + SIX, t, gyro, accel)
    )


def texts():
    """name -> (content, flags, rate Hz); every one opens with its flags."""
    # fmt: off
    out = {}
    out["blocks.txt"] = ("Adafruit MPU6050 test!\nFilter bandwidth set to: 21 Hz\n\n" + _lines(lambda k, w, a: f"Acceleration X: {a[0]:.6f}, Y: {a[1]:.6f}, Z: {a[2]:.6f} m/s^2\nRotation X: {w[0]:.8f}, Y: {w[1]:.8f}, Z: {w[2]:.8f} rad/s\nTemperature: 26.1 degC\n\n"), "--rate 10", 10)
    out["rotation.txt"] = (_lines(lambda k, w, a: f"Rotation: {_three(w, sep=', ')}\n"), "--gyro-unit rad/s --rate 10", 10)
    out["rot.csv"] = (table("time,Acc X,Acc Y,Acc Z,Rot X,Rot Y,Rot Z", T, IN_G, DPS), DEG_G, 100)
    scale = (0.00122173047395736, 0.00048828125)
    out["integers.gcsv"] = (_gyroflow(f"tscale,0.001\ngscale,{scale[0]}\nascale,{scale[1]}", I * 2, np.rint(GYRO * 1000 / scale[0]).astype(int), np.rint(IN_G * 1000 / scale[1]).astype(int)), "--trust-units --gyro-unit counts:14323.9 --accel-unit counts:2048000", 500)
    out["units.gcsv"] = (_gyroflow("tscale,0.000001\ngscale,1.00000000000\nascale,1.0", I * 2000 + 171000, GYRO, IN_G), "", 500)
    out["odd.gcsv"] = (_gyroflow("tscale,0.020000000\ngscale,0.00001745329252\nascale,0.00981", I, DPS * 1000, IN_G / 0.00981), "", 50)
    out["explorer.csv"] = ('"Product","Blackbox flight data recorder"\n"Firmware revision","4.5.1"\n"gyro_scale",1\n"acc_1G",2048\n"rollPID","45,80,40"\n' + table('"loopIteration","time","gyroADC[0]","gyroADC[1]","gyroADC[2]","accSmooth[0]","accSmooth[1]","accSmooth[2]"', I * 4, I * 2000 + 38012345, DPS, IN_G * 2048), "--gyro-unit deg/s", 500)
    out["long.csv"] = ("epoch_ms,elapsed_ms,sensor,x,y,z\n" + _lines(lambda k, w, a: f"{1760000000123 + k * 10},{k * 10},accel_g,{_three(IN_G[k])}\n{1760000000126 + k * 10},{k * 10 + 3},gyro_dps,{_three(DPS[k])}\n"), "", 100)
    out["empty_stamps.txt"] = ("// Start Time: Unknown\n// Update Rate: 100.0Hz\n// Option Flags: none\n" + table("PacketCounter\tSampleTimeFine\tAcc_X\tAcc_Y\tAcc_Z\tGyr_X\tGyr_Y\tGyr_Z", I + 27626, [""] * N, ACCEL, GYRO, sep="\t"), "", 100)
    out["null_stamps.txt"] = (table("time\tDeviceName\tChipTime()\tAccX(g)\tAccY(g)\tAccZ(g)\tAsX(°/s)\tAsY(°/s)\tAsZ(°/s)\tAngleX(°)\tAngleY(°)\tAngleZ(°)", clock((10, 21, 33), form="%Y-%m-%dT%H:%M:%S.%f"), ["HC-06(0D)"] * N, ["null"] * N, IN_G, DPS, GYRO * 0 + 3, sep="\t"), "", 100)
    out["units_with_date.csv"] = ('"sep=\t"\n' + "time_CAL\tS_Accel_LN_X_CAL\tS_Accel_LN_Y_CAL\tS_Accel_LN_Z_CAL\tS_Gyro_X_CAL\tS_Gyro_Y_CAL\tS_Gyro_Z_CAL\nyyyy/mm/dd hh:mm:ss.000" + "\tm/(s^2)" * 3 + "\tdeg/s" * 3 + "\n" + table("", clock((10, 21, 33), form="%Y/%m/%d %H:%M:%S.%f"), ACCEL, DPS, sep="\t"), "", 100)
    gravity = np.tile([0.04, -0.1, -9.8], (N, 1)) / 9.80665
    out["gravity_apart.csv"] = (table("timestamp(unix),attitude_roll(radians),rotation_rate_x(radians/s),rotation_rate_y(radians/s),rotation_rate_z(radians/s),gravity_x(G),gravity_y(G),gravity_z(G),user_acc_x(G),user_acc_y(G),user_acc_z(G)", ["%.2f" % (1520000000.2 + t) for t in T], T * 0, GYRO, gravity, IN_G - gravity), "", 100)
    out["in_line.csv"] = (table('"Time","GPS LatAcc","InlineAcc","LateralAcc","VerticalAcc","RollRate","PitchRate","YawRate"\n"s","g","g","g","g","deg/s","deg/s","deg/s"', T, T * 0, IN_G, DPS), "", 100)
    out["bus.csv"] = (table("time,V_X_AXIS_ACCELERATION,V_Y_AXIS_ACCELERATION,V_Z_AXIS_ACCELERATION,V_X_AXIS_YAW_RATE,V_Y_AXIS_YAW_RATE,V_Z_AXIS_YAW_RATE", T, IN_G, DPS), DEG_G, 100)
    out["load_factors.csv"] = (table("t [s],nx_g,ny_g,nz_g,p_dps,q_dps,r_dps", T, IN_G, DPS), "", 100)
    out["radians.csv"] = (table("time_s,ax_ms2,ay_ms2,az_ms2,wx_rad,wy_rad,wz_rad", T, ACCEL, GYRO), "--gyro-unit rad/s", 100)
    whole = 3968946093 + (I * 4 + 120) // 1000
    out["network.csv"] = (table("ntp_sec,ntp_frac," + SIX, whole, ((I * 4 + 120) % 1000 * 2**32) // 1000, GYRO, ACCEL), SI, 250)
    out["fractions.csv"] = (table("sec,frac_sec," + SIX, whole, ["%.6f" % v for v in (I * 4 + 120) % 1000 / 1000], GYRO, ACCEL), SI, 250)
    out["marks.txt"] = (_lines(lambda k, w, a: f"33,Jogging,{49105962326000 + k * 50000000},{_three(a)};\n"), "--accel-unit m/s^2 --columns -,-,time,accel_x,accel_y,accel_z --time-unit ns", 20)
    out["bare_beside.csv"] = (table("time_us,x,y,z,ax,ay,az", I * 10000, GYRO, ACCEL), SI, 100)
    out["own_stamps.csv"] = (table("accTs,accX,accY,accZ,gyrTs,gyrX,gyrY,gyrZ", T + 12.345, ACCEL, T + 12.347, GYRO), SI, 100)
    out["message_cells.csv"] = ("seq,orientation,angular velocity,linear acceleration,secs,nsecs\n" + _lines(lambda k, w, a: f'{k},"x: 0.0\ny: 0.0\nz: 0.0\nw: 1.0",{_cell(w)},{_cell(a)},{1760000000 + k // 100},{k % 100 * 10000000}\n'), SI, 100)
    out["rate_in_words.csv"] = ("# Config: data_rate = 100.0 Hz, filter = 42 Hz, gyro_range = 250.0 dps\n" + table("count,g_x,g_y,g_z,a_x,a_y,a_z", I, GYRO, ACCEL), SI, 100)
    out["spelled.csv"] = (table("Timestamp_ms,Accelerometer_x_MetersPerS2,Accelerometer_y_MetersPerS2,Accelerometer_z_MetersPerS2,Gyroscope_x_DegPerS,Gyroscope_y_DegPerS,Gyroscope_z_DegPerS,Gyroscope_VM_DegPerS", I * 10, ACCEL, DPS, T * 0 + 1), "", 100)
    body = table("t," + SIX, T, GYRO, ACCEL).splitlines(keepends=True)
    out["complaints.csv"] = ("".join(r + "Failed to read data from Accelerometer\n" * (k % 37 == 5) for k, r in enumerate(body)), SI, 100)
    out["quoted_numbers.json"] = (json.dumps([{"sensor": s, "time": str(1788594189329554400 + k * 10**7), "seconds_elapsed": f"{k / 100}", **{c: f"{v:.9g}" for c, v in zip("zyx", x[k][::-1])}} for k in range(N) for s, x in (("Gyroscope", GYRO), ("TotalAcceleration", ACCEL))]), SI, 100)
    out["offset_stamps.csv"] = (table("time,seconds_elapsed,gz,gy,gx,az,ay,ax", [str(1788594189329554400 + int(k) * 10**7) for k in I], ["%.7f" % (t + 0.0707) for t in T], GYRO[:, ::-1], ACCEL[:, ::-1]), SI, 100)
    out["scaled_brackets.txt"] = (_lines(lambda k, w, a: f"Scaled. Acc (mg) [ {_three(IN_G[k] * 1000, '%09.4f', ', ')} ], Gyr (DPS) [ {_three(DPS[k], '%09.6f', ', ')} ], Mag (uT) [  00010.05, -00020.10,  00030.00 ], Tmp (C) [  00025.78 ]\n"), "--rate 30", 30)
    out["world_beside.csv"] = (table("Timestamp,AccelX,AccelY,AccelZ,GyroX,GyroY,GyroZ,WorldAccelX,WorldAccelY,WorldAccelZ", I * 10 + 1760000000123, ACCEL, GYRO, ACCEL * 0), SI, 100)
    ingestion = {"device_type": "own", "interval_ms": 10, "sensors": [*({"name": f"acc{c}", "units": "m/s2"} for c in "XYZ"), *({"name": f"gyr{c}", "units": "deg/s"} for c in "XYZ")], "values": np.c_[ACCEL, DPS].tolist()}
    out["names_apart.json"] = (json.dumps({"protected": {"ver": "v1"}, "payload": ingestion}), "", 100)
    out["milliradians.csv"] = (table("time_boot_ms,xacc,yacc,zacc,xgyro,ygyro,zgyro", I * 10, np.rint(IN_G * 1e6).astype(int), np.rint(GYRO * 1e6).astype(int)), "--accel-unit ug --gyro-unit urad/s", 100)
    out["two_brackets.csv"] = (table("X[s],IM sensor 1: Acc 1.X (IM) [g],IM sensor 1: Acc 1.Y (IM) [g],IM sensor 1: Acc 1.Z (IM) [g],IM sensor 1: Gyro 1.X (IM) [°/s],IM sensor 1: Gyro 1.Y (IM) [°/s],IM sensor 1: Gyro 1.Z (IM) [°/s]", T, IN_G, DPS), "", 100)
    out["tags_with_units.csv"] = ("$FLYS,1\n$COL,BARO,time,pressure\n$UNIT,BARO,s,Pa\n$COL,IMU,time,wx,wy,wz,ax,ay,az,temperature\n$UNIT,IMU,s,deg/s,deg/s,deg/s,g,g,g,deg C\n$DATA\n" + _lines(lambda k, w, a: f"$IMU,{59970.376 + k / 100:.3f},{_three(DPS[k])},{_three(IN_G[k])},24.18\n" + f"$BARO,{59970.379 + k / 100:.3f},101325.0\n" * (k % 5 == 0)), "", 100)
    out["of_the_day.csv"] = (table("ms_today;accX;accY;accZ;gyroX;gyroY;gyroZ", I * 20 + 37293250, IN_G, DPS, sep=";"), DEG_G, 50)
    out["sources_row.csv"] = (table("timestamp,elapsed_time,lateral_acc,x_acc,y_acc,z_acc,x_rate_of_rotation,y_rate_of_rotation,z_rate_of_rotation\nunix time,s,G,G,G,G,deg/s,deg/s,deg/s\n,,calc,101: acc,101: acc,101: acc,102: gyro,102: gyro,102: gyro", ["%.2f" % (1773483693.25 + t) for t in T], T, T * 0, IN_G, DPS), "", 100)
    out["turning_speeds.txt"] = (table("% Imu's timestamp   IMU_X_ACC   IMU_Y_ACC   IMU_Z_ACC   IMU_YAW_VEL   IMU_PITCH_VEL   IMU_ROLL_VEL", ["%.6f" % (1261228749.91859 + t) for t in T], ACCEL, GYRO[:, ::-1], sep=" "), SI, 100)
    out["blanks_over_tabs.txt"] = (table("accX accY accZ gyroX gyroY gyroZ roll gyroXangle", ACCEL, GYRO, T, T, sep="\t"), SI + " --rate 50", 50)
    days = clock((23, 59, 58), form="%Y-%m-%d %H:%M:%S.%f")
    out["dated_commas.txt"] = (table("date time gyro_x gyro_y gyro_z accel_x accel_y accel_z\n- - mrad/s mrad/s mrad/s mg mg mg", [d.replace(".", "DOT") for d in days], GYRO * 1000, IN_G * 1000, sep=" ").replace(".", ",").replace("DOT", "."), "", 100)
    out["typed_units.csv"] = (table("#t[s:double],w.x[rad/s:double],w.y[rad/s:double],w.z[rad/s:double],a.x[m/s^2:double],a.y[m/s^2:double],a.z[m/s^2:double]", T + 8123.4, GYRO, ACCEL), "", 100)
    serial = "(LGR S/N: 10012345, SEN S/N: 10012345)"
    out["serial_numbers.csv"] = ('"Plot Title: 10012345"\n' + table(f'"#","Date Time, GMT+01:00","X Accel, g {serial}","Y Accel, g {serial}","Z Accel, g {serial}"', I + 1, clock((10, 21, 33), form="%m/%d/%y %I:%M:%S.%f"), IN_G), "", 100)
    out["stamp_lines.txt"] = ("*** Booting ***\n" + _lines(lambda k, w, a: f"[0:{k // 600:02d}:{k / 10 % 60:06.3f}]:29.6 Cel\n  accel {_three(a, '%.6f', ' ')} m/s/s\n  gyro  {_three(w, '%.8f', ' ')} rad/s\n"), "", 10)
    out["user_beside.csv"] = (table("Index,Arrival_Time,x,y,z,User,Device", I, I * 20 + 1424696633908, ACCEL, ["a"] * N, ["phone_1"] * N), "--accel-unit m/s^2", 50)
    # fmt: on
    return out


def binaries(folder):
    """(path, flags, rate) of files of arrays, written into a folder."""
    import h5py
    import pandas as pd

    names = ["timestamp_us", *(f"acc_{c}" for c in "xyz"), *(f"gyro_{c}" for c in "xyz")]
    frame = pd.DataFrame(dict(zip(names, [I * 10000 + 10**15, *ACCEL.T, *GYRO.T])))
    frame.to_feather(folder / "a.feather")
    yield folder / "a.feather", SI, 100
    np.save(folder / "three.npy", ACCEL)
    yield folder / "three.npy", "--accel-unit m/s^2 --rate 100", 100
    with h5py.File(folder / "matlab.mat", "w", userblock_size=512) as file:
        for name, x in (("t", T), ("wb", DPS), ("fb", IN_G)):
            file[f"imu/{name}"] = np.atleast_2d(x).T if x.ndim == 1 else x.T
        for name, text in (("gyro_units", "deg/s"), ("accel_units", "g")):
            file[f"imu/{name}"] = np.array([[ord(c)] for c in text], dtype=np.uint16)
            file[f"imu/{name}"].attrs["MATLAB_class"] = np.bytes_("char")
    head = io.BytesIO()
    head.write(b"MATLAB 7.3 MAT-file".ljust(512, b" "))
    with open(folder / "matlab.mat", "r+b") as file:
        file.write(head.getvalue())
    yield folder / "matlab.mat", "", 100
    with h5py.File(folder / "own.h5", "w") as file:
        file["imu/time"] = T + 12345.6
        file["imu/gyro"], file["imu/acce"] = DPS, IN_G
        file["imu/gyro"].attrs["units"], file["imu/acce"].attrs["units"] = "deg/s", "g"
    yield folder / "own.h5", "", 100
    with h5py.File(folder / "table.h5", "w") as file:
        rows = np.zeros(N, dtype=[(n, "f8") for n in ("t", "gx", "gy", "gz", "ax", "ay", "az")])
        for n, x in zip(rows.dtype.names, [T, *GYRO.T, *ACCEL.T]):
            rows[n] = x
        file["log"] = rows
    yield folder / "table.h5", SI, 100
