# ruff: noqa: E501, UP031
"""More small logs of the same standing sensor: cells that hold lists, messages under tags, stamps of
other clocks, documents of JSON.
"""

from __future__ import annotations

import json

import numpy as np
from strange_logs import ACCEL, DEG, DPS, GYRO, IN_G, SI, G, I, N, T, clock, table

DEG_G = "--gyro-unit deg/s --accel-unit g"
SIX = "gx,gy,gz,ax,ay,az"


def _lines(form):
    return "".join(form(k, GYRO[k], ACCEL[k]) + "\n" for k in range(N))


def _three(x, form="%.9g", sep=", "):
    return sep.join(form % v for v in x)


def times():
    """Heading of the stamps -> (stamps as text, rate, further flags)."""
    day = clock((10, 59, 58), form="%Y-%m-%d %H:%M:%S.%f")
    whole = lambda x: [str(int(v)) for v in x]  # noqa: E731
    return {
        "timestamp": (whole(133604231951234567 + I * 50000), 200, ""),
        "Ticks": (whole(638515431951234567 + I * 100000), 100, ""),
        "datenum": (["%.10f" % v for v in 739389.458275 + I / 50 / 86400], 50, ""),
        "ts": (whole(1715936395123456 + I * 2000), 500, ""),
        "time": ([f"2024-138T10:{k // 6000:02d}:{k / 100 % 60:06.3f}" for k in I], 100, ""),
        "time_iso": ([c.replace("-", "").replace(":", "").replace(" ", "T") for c in day], 100, ""),
        "time_c": ([f"Thu Mar  4 {c.split()[1]} 2021" for c in day], 100, ""),
        "time_dots": ([c.replace(" ", "T").replace(":", ".") for c in day], 100, ""),
        "elapsed": ([f"0 days 00:00:{k / 100:012.9f}" for k in I], 100, ""),
        "ms": (whole(I * 8 % 1000), 125, ""),
        "t_ms": (whole((I * 2 + 65200) % 65536), 500, ""),
        "tv_sec,tv_usec": ([f"{1715936395 + k // 100},{k % 100 * 10000}" for k in I], 100, ""),
        "seconds,centiseconds": ([f"{k // 100 + 4},{k % 100}" for k in I], 100, ""),
        "date": (["2024-05-17"] * N, 100, "--rate 100"),
        "clock_of_nothing": (["soon"] * N, 100, "--rate 100"),
    }


def logs():
    """name -> (content, flags, rate Hz)."""
    # fmt: off
    out = {}
    body = table("", T, GYRO, ACCEL)
    lines = body.splitlines()
    head = f"time,{SIX}"
    out["list_cells.csv"] = ("t,gyro,accel\n" + _lines(lambda k, w, a: f'{k / 100},"[{_three(w)}]","[{_three(a)}]"'), SI, 100)
    out["tuple_cells.txt"] = ("t;gyro;accel\n" + _lines(lambda k, w, a: f"{k / 100};({_three(w)});({_three(a)})"), SI, 100)
    out["array_cells.csv"] = ("t,gyro,accel\n" + _lines(lambda k, w, a: f"{k / 100},[{_three(w, '%12.8f', ' ')}],[{_three(a, '%12.8f', ' ')}]"), SI, 100)
    out["unit_cells.csv"] = (head + "\n" + _lines(lambda k, w, a: f"{k / 100} s,{_three(w, '%.8f rad/s', ',')},{_three(a, '%.6f m/s²', ',')}"), "", 100)
    counts = np.c_[np.rint(DPS * 10000), np.rint(IN_G * 16384)].astype(int) & 0xFFFF
    out["hexadecimal.csv"] = (head + "\n" + "".join(f"{k / 100}," + ",".join("0x%04X" % v for v in counts[k]) + "\n" for k in I), "--gyro-unit counts:10000 --accel-unit counts:16384", 100)
    big = np.c_[DPS * 3600, IN_G * 1e6]
    out["thousands.csv"] = (head + "\n" + "".join(f"{k / 100}," + ",".join(f'"{v:,.3f}"' for v in big[k]) + "\n" for k in I), "--gyro-unit deg/h --accel-unit counts:1000000", 100)
    names = "gyro_x gyro_y gyro_z accel_x accel_y accel_z".split()
    out["one_reading_a_row.csv"] = ("timestamp,channel,value\n" + "".join(f"{k / 100:.3f},{c},{v:.9g}\n" for k in I for c, v in zip(names, [*GYRO[k], *ACCEL[k]])), SI, 100)
    tags = "# Header\n# UncalAccel,utcTimeMillis,elapsedRealtimeNanos,UncalAccelXMps2,UncalAccelYMps2,UncalAccelZMps2,BiasXMps2\n# UncalGyro,utcTimeMillis,elapsedRealtimeNanos,UncalGyroXRadPerSec,UncalGyroYRadPerSec,UncalGyroZRadPerSec,DriftXRadPerSec\n"
    out["tagged_phone.txt"] = (tags + _lines(lambda k, w, a: f"UncalAccel,{1715936395123 + k * 10},{88123456789 + k * 10**7},{_three(a, sep=',')},0.0\nUncalGyro,{1715936395126 + k * 10},{88126456789 + k * 10**7},{_three(w, sep=',')},0.0"), "", 100)
    out["measurements.csv"] = ("MessageType,utcTimeMillis,MeasurementX,MeasurementY,MeasurementZ,BiasX\n" + _lines(lambda k, w, a: f"UncalAccel,{1715936395123 + k * 10},{_three(a, sep=',')},0.0\nUncalGyro,{1715936395126 + k * 10},{_three(w, sep=',')},0.0\nUncalMag,{1715936395127 + k * 10},20,3,-40,1"), SI, 100)
    out["flight_text.log"] = ("FMT, 128, 89, FMT, BBnNZ, Type,Length,Name,Format,Columns\nFMT, 133, 47, IMU, QBffffff, TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ\nPARM, 5, INS_GYRO_FILTER, 20\n" + _lines(lambda k, w, a: f"IMU, {k * 20000 + 77777}, 0, {_three(w)}, {_three(a)}\nATT, {k * 20000}, 1.0, 2.0, 3.0"), SI, 50)
    out["corrected.txt"] = (_lines(lambda k, w, a: f"#CORRIMUDATASA,USB1,0,50.0,FINESTEERING,2200,{1000 + k / 100:.3f},02000000,0,0;2200,{1000 + k / 100:.9f},{_three(w / 100, '%.12f', ',')},{_three(a / 100, '%.12f', ',')}*{k:08x}"), "", 100)
    out["chip.txt"] = (_lines(lambda k, w, a: f"I ({3000 + k * 10}) IMU: gx={w[0]:.8f} gy={w[1]:.8f} gz={w[2]:.8f} ax={a[0]:.6f} ay={a[1]:.6f} az={a[2]:.6f}"), SI, 100)
    out["phone_log.txt"] = (_lines(lambda k, w, a: f"05-17 10:59:{k / 100:06.3f}  1234  1250 D Imu  : gyro=[{_three(w)}] acc=[{_three(a)}]"), SI, 100)
    out["document.json"] = (json.dumps([{"timestamp": 1715936395123 + k * 20, "gyro": dict(zip("xyz", GYRO[k])), "accel": dict(zip("xyz", ACCEL[k]))} for k in range(N)], indent=1), SI, 50)
    out["arrays.json"] = (json.dumps({"time": list(T), **{c: list(x) for c, x in zip(names, np.c_[GYRO, ACCEL].T)}}), SI, 100)
    out["elements.xml"] = ("<log>\n" + _lines(lambda k, w, a: "<sample " + " ".join(f"{n}='{v:.8f}'" for n, v in zip(("t", *SIX.split(",")), [k / 100, *w, *a])) + "/>") + "</log>\n", SI, 100)
    measured = "LabVIEW Measurement\t\nSeparator\tTab\nDecimal_Separator\t,\n***End_of_Header***\t\n\nChannels\t6\nSamples\t" + "\t".join(["400"] * 6) + "\nDelta_X\t" + "\t".join(["0,010000"] * 6) + "\n***End_of_Header***\t\nX_Value\tGyro_X\tGyro_Y\tGyro_Z\tAcc_X\tAcc_Y\tAcc_Z\tComment\n"
    out["measured.lvm"] = (measured + body.replace(",", "\t").replace(".", ","), SI, 100)
    out["attributes.arff"] = ("@relation imu\n@attribute t numeric\n@data\n" + body, SI + " --columns time,gyro_x,gyro_y,gyro_z,accel_x,accel_y,accel_z", 100)
    out["statistics_below.csv"] = (head + "\n" + body + "\nMin,-0.1,-0.1,-0.1,-9,-9,-9\nMean,0,0,0,0,0,0\nStopped by the user after 4.0 s, at 12:00, for lunch\n", SI, 100)
    out["unfiltered_beside.csv"] = (table("time_us,gyroUnfilt[0],gyroUnfilt[1],gyroUnfilt[2],gyroADC[0],gyroADC[1],gyroADC[2],accSmooth[0],accSmooth[1],accSmooth[2]", I * 1000, DPS + 5, DPS, np.rint(IN_G * 20480).astype(int)), "--gyro-unit deg/s --accel-unit counts:20480", 1000)
    out["force_and_linear.csv"] = (table("time,gFx,gFy,gFz,ax,ay,az,wx,wy,wz", T, IN_G, ACCEL * 0 + 0.01, GYRO), "", 100)
    out["chip_names.csv"] = (table("time,LSM6DS3_G_X,LSM6DS3_G_Y,LSM6DS3_G_Z,LSM6DS3_A_X,LSM6DS3_A_Y,LSM6DS3_A_Z", T, GYRO, ACCEL), SI, 100)
    out["greek.csv"] = (table("time,ωx,ωy,ωz,fx,fy,fz", T, GYRO, ACCEL), SI, 100)
    out["composites.csv"] = (table("Clock:offsetTime,IMU(0):accelX:C,IMU(0):accelY:C,IMU(0):accelZ:C,IMU(0):accelComposite:C,IMU(0):gyroX:C,IMU(0):gyroY:C,IMU(0):gyroZ:C,IMU(0):gyroComposite:C,IMU(0):velN,IMU(0):velE,IMU(0):velD", T - 3, IN_G, T * 0 + 1, DPS, T * 0, T * 0, T * 0, T * 0 + 1), DEG_G, 100)
    out["flight_increments.csv"] = (table("timestamp,timestamp_sample,delta_angle[0],delta_angle[1],delta_angle[2],delta_velocity[0],delta_velocity[1],delta_velocity[2],delta_angle_dt,delta_velocity_dt", I * 4000 + 50000300 + I % 7, I * 4000 + 50000000, GYRO * 0.004, ACCEL * 0.004, I * 0 + 4000, I * 0 + 4000, form="%.12g"), "", 250)
    uneven = np.sort(T + 0.02 * np.random.default_rng(3).random(N))
    out["host_and_own.csv"] = (table(f"time,timestamp,{SIX}", uneven, 1715936395123 + I * 10, GYRO, ACCEL), SI, 100)
    chip = [c.split()[1] for c in clock((10, 22, 33), form="%Y-%m-%d %H:%M:%S.%f")]
    out["over_two_columns.txt"] = (table("time\tDeviceName\tChip Time()\tAcceleration X(g)\tAcceleration Y(g)\tAcceleration Z(g)\tAngular velocity X(°/s)\tAngular velocity Y(°/s)\tAngular velocity Z(°/s)\tTemperature(°C)", [f"2021-03-04 {c}" for c in chip], ["WT901BLE(c0:11)"] * N, [f"2021-03-04 {c}" for c in chip], IN_G, DPS, T * 0 + 33, sep="\t"), "", 100)
    for n, (gyro, accel, scale_g, scale_a) in enumerate(UNITS):
        heads = [f"G{x} {gyro}" for x in "XYZ"] + [f"A{x} {accel}" for x in "XYZ"]
        out[f"units_{n}.csv"] = (table("time [s]," + ",".join(heads), T, GYRO * scale_g, ACCEL * scale_a, form="%.10g"), "", 100)
    out["demonstration.txt"] = ("Initialization of the sensor returned: All is well.\n" + _lines(lambda k, w, a: f"Scaled. Acc (mg) [ {_three(a / G * 1000, '%013.6f')} ], Gyr (DPS) [ {_three(w * DEG, '%013.8f')} ], Mag (uT) [ -00041.10, 00033.30, 00011.25 ], Tmp (C) [ 00024.05 ]"), "--rate 33", 33)
    out["dictionaries.txt"] = (_lines(lambda k, w, a: str({"t": k / 50, "gyro": dict(zip("xyz", map(float, w))), "accel": dict(zip("xyz", map(float, a)))})), SI, 50)
    out["brackets_only.txt"] = (_lines(lambda k, w, a: f"{k * 10 + 77} ({_three(w)}) ({_three(a)})"), SI + " --columns time[ms],gyro_x,gyro_y,gyro_z,accel_x,accel_y,accel_z", 100)
    out["labels_between.txt"] = (_lines(lambda k, w, a: "Gyro\t" + _three(w, sep="\t") + "\tAccel\t" + _three(a, sep="\t") + f"\tms\t{k * 10 + 100}"), SI, 100)
    out["seconds_in_cells.csv"] = (head + "\n" + _lines(lambda k, w, a: f"{k / 100} sec,{_three(w, sep=',')},{_three(a, sep=',')}"), SI, 100)
    out["step_above.txt"] = ("dt = 0.005 s\ngx gy gz ax ay az\n" + table("", GYRO, ACCEL, sep=" "), SI, 200)
    out["body_rates.csv"] = (table("t,q0,q1,q2,q3,p,q,r,ax,ay,az", T, T * 0 + 1, T * 0, T * 0, T * 0, GYRO, ACCEL), SI, 100)
    out["units_touch.txt"] = (_lines(lambda k, w, a: f"t={k * 5000 + 1}us a=[{_three(a, sep=',')}] w=[{_three(w, sep=',')}]"), SI, 200)
    out["with_and_without_gravity.csv"] = (table("timeStamp,acceleration.x,acceleration.y,acceleration.z,accelerationIncludingGravity.x,accelerationIncludingGravity.y,accelerationIncludingGravity.z,gyro.x,gyro.y,gyro.z", 1234.5 + I * 1000 / 60, ACCEL * 0 + 0.01, ACCEL, GYRO, form="%.10g"), SI, 60)
    out["surge.csv"] = (table("t [s],roll_rate [deg/s],pitch_rate [deg/s],yaw_rate [deg/s],surge [m/s^2],sway [m/s^2],heave [m/s^2]", T, DPS, ACCEL), "", 100)
    out["hours.csv"] = (table(f"Hours,{SIX}", T / 3600, GYRO, ACCEL, form="%.12g"), SI, 100)
    out["blanks_in_names.txt"] = (table("Time (s)   Gyro X (rad/s)   Gyro Y (rad/s)   Gyro Z (rad/s)   Accel X (m/s^2)   Accel Y (m/s^2)   Accel Z (m/s^2)", T, GYRO, ACCEL, sep="   "), "", 100)
    out["made_before.csv"] = (table(head, T, GYRO, ACCEL) + "\0" * 700, SI, 100)
    out["bare_behind.csv"] = (table("time [s],gyro x [rad/s],y,z,accel x [m/s^2],y,z", T, GYRO, ACCEL), "", 100)
    out["minus_sign.csv"] = (table(head, T, GYRO, ACCEL).replace("-", "\u2212"), SI, 100)
    out["fortran.txt"] = ("".join(f"{k / 100:.8E} {_three(w, '%+.8E', ' ')} {_three(a, '%+.8E', ' ')}\n".replace("E", "D") for k, w, a in zip(I, GYRO, ACCEL)), SI + " --columns time,gyro_x,gyro_y,gyro_z,accel_x,accel_y,accel_z", 100)
    out["no_reading.csv"] = (head + "\n" + "\n".join(r if k % 97 else f"{k / 100},{','.join(['-999.0'] * 6)}" for k, r in enumerate(lines)) + "\n", SI, 100)
    return out
    # fmt: on


#: Units of gyro and accelerometer as headings spell them, and how many of them the SI unit is.
UNITS = (
    ("(radians per second)", "(meters per second squared)", 1, 1),
    ("(degrees/second)", "(metres/second²)", DEG, 1),
    ("[arcsec/s]", "[mGal]", DEG * 3600, 1e5),
    ("[rev/s]", "[g-units]", DEG / 360, 1 / G),
    ("[µrad/s]", "[milli-g]", 1e6, 1e3 / G),
    ("(rad·s⁻¹)", "(g₀)", 1, 1 / G),
)
