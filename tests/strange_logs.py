# ruff: noqa: E501, UP031
"""Small logs in the shapes of many makers' tools, drawn anew: the same standing sensor in each."""

from __future__ import annotations

import bz2
import datetime as dt
import gzip
import io
import lzma
import zipfile

import numpy as np

N = 400
DEG, G = 180 / np.pi, 9.80665
_rng = np.random.default_rng(5)
GYRO = _rng.normal(0, 2e-3, (N, 3)) + [0.01, -0.02, 0.005]  # rad/s
ACCEL = _rng.normal(0, 2e-2, (N, 3)) + [0.05, -0.11, -9.81]  # m/s^2
I, T = np.arange(N), np.arange(N) / 100
DPS, IN_G = GYRO * DEG, ACCEL / G
SI = "--gyro-unit rad/s --accel-unit m/s^2"


def _text(x, form):
    return x if isinstance(x, str) else str(int(x)) if isinstance(x, int | np.integer) else form % x


def table(head, *columns, sep=",", form="%.9g", end=""):
    """A header and rows; a matrix is its three columns."""
    flat = []
    for c in columns:
        flat += [c[:, k] for k in range(3)] if isinstance(c, np.ndarray) and c.ndim == 2 else [c]
    rows = [sep.join(_text(c[k], form) for c in flat) + end for k in range(len(flat[0]))]
    return "\n".join([*([head] if head else []), *rows]) + "\n"


def sentence(body):
    total = 0
    for c in body.encode():
        total ^= c
    return f"${body}*{total:02X}"


def archive(**files):
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w") as packed:
        for name, text in files.items():
            packed.writestr(name.replace("__", "/") + ".csv", text)
    return out.getvalue()


def clock(start, step=0.01, form="%H:%M:%S.%f", cut=3):
    zero = dt.datetime(2021, 3, 4, *start)
    out = [(zero + dt.timedelta(seconds=float(k * step))).strftime(form) for k in I]
    return [c[:-cut] for c in out] if cut else out


def logs():
    """name -> (content, flags, rate Hz). Every one opens with its flags."""
    # fmt: off
    out = {}
    empty, zero = [""] * N, I * 0
    mag, angles = GYRO * 0 + 0.5, GYRO * 100
    out["mt_manager.txt"] = ("// General information:\n//  Update Rate: 100.0Hz\n" + table("PacketCounter\tSampleTimeFine\tYear\tMonth\tDay\tSecond\tUTC_Nano\tAcc_X\tAcc_Y\tAcc_Z\tGyr_X\tGyr_Y\tGyr_Z\tMag_X\tMag_Y\tMag_Z\tRoll\tPitch\tYaw", I + 51000, I * 100 + 1234567, empty, empty, empty, empty, empty, ACCEL, GYRO, mag, angles, sep="\t"), SI, 100)
    out["dot.csv"] = ("sep=,\nDeviceTag:,one\nFirmwareVersion:,1.6.0\nOutputRate:,60Hz\n\n" + table("PacketCounter,SampleTimeFine,Acc_X,Acc_Y,Acc_Z,Gyr_X,Gyr_Y,Gyr_Z,", I, I * 16667 + 1046321, ACCEL, DPS, end=","), "--gyro-unit deg/s --accel-unit m/s^2", 60)
    phone = "Time (s),{0} x ({1}),{0} y ({1}),{0} z ({1})"
    out["phone.zip"] = (archive(Accelerometer=table(phone.format("Acceleration", "m/s^2"), T + 0.0031, ACCEL), Gyroscope=table(phone.format("Gyroscope", "rad/s"), T + 0.001, GYRO), meta__device="property,value\nversion,1\n"), "", 100)
    back = "time,seconds_elapsed,z,y,x"
    out["reversed.zip"] = (archive(Accelerometer=table(back, 16 * 10**17 + I * 10**7, T + 0.1, ACCEL * 0 + 0.01), TotalAcceleration=table(back, 16 * 10**17 + I * 10**7, T + 0.1, ACCEL[:, ::-1]), Gyroscope=table(back, 16 * 10**17 + I * 10**7, T + 0.1, GYRO[:, ::-1]), Metadata="version\n3\n"), SI, 100)
    out["phone_de.csv"] = (table('"Zeit (s)";"Winkelgeschwindigkeit x (rad/s)";"Winkelgeschwindigkeit y (rad/s)";"Winkelgeschwindigkeit z (rad/s)";"Absolut (rad/s)"', T, GYRO, mag[:, 0], sep=";").replace(".", ","), "", 100)
    out["phone_fr.csv"] = (table('"Temps (s)"\t"Accélération x (m/s²)"\t"Accélération y (m/s²)"\t"Accélération z (m/s²)"\t"Accélération absolue (m/s²)"', T, ACCEL, mag[:, 0], sep="\t"), "", 100)
    out["phone_it.csv"] = (table("Tempo (s);Accelerazione X (m/s²);Accelerazione Y (m/s²);Accelerazione Z (m/s²);Giroscopio X (°/s);Giroscopio Y (°/s);Giroscopio Z (°/s)", T, ACCEL, DPS, sep=";").replace(".", ","), "", 100)
    out["phone_ja.csv"] = (table("時刻(ms),加速度X(G),加速度Y(G),加速度Z(G),角速度X(dps),角速度Y(dps),角速度Z(dps),温度(℃)", I * 10, IN_G, DPS, T * 0 + 25.5), "", 100)
    out["phone_ru.csv"] = (table("Время, с;Ускорение X, м/с²;Ускорение Y, м/с²;Ускорение Z, м/с²;Гироскоп X, рад/с;Гироскоп Y, рад/с;Гироскоп Z, рад/с", T, ACCEL, GYRO, sep=";"), "", 100)
    out["flight.csv"] = (table("timestamp,gyro_rad[0],gyro_rad[1],gyro_rad[2],gyro_integral_dt,accelerometer_timestamp_relative,accelerometer_m_s2[0],accelerometer_m_s2[1],accelerometer_m_s2[2],accelerometer_integral_dt", I * 4000 + 98765432, GYRO, zero + 4000, zero, ACCEL, zero + 4000), "", 250)
    out["dataflash.csv"] = (table("timestamp,TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ,EG,EA,T,GH", 1.6e9 + I * 0.04, I * 40000 + 123456, zero, GYRO, ACCEL, zero, zero, T * 0 + 41.2, zero + 1, form="%.12g"), SI, 25)
    out["blackbox.csv"] = (table("loopIteration,time (us),gyroADC[0],gyroADC[1],gyroADC[2],accSmooth[0],accSmooth[1],accSmooth[2],motor[0]", I * 2, I * 500 + 1000000, np.rint(DPS * 1e4).astype(int), np.rint(IN_G * 20480).astype(int), zero), "--gyro-unit counts:10000 --accel-unit counts:20480", 2000)
    units = "\nms\tm/(s^2)\tm/(s^2)\tm/(s^2)\tdeg/s\tdeg/s\tdeg/s\t"
    out["wearable.csv"] = ('"sep=\t"\n' + table("S1_Timestamp_Unix_CAL\tS1_Accel_LN_X_CAL\tS1_Accel_LN_Y_CAL\tS1_Accel_LN_Z_CAL\tS1_Gyro_X_CAL\tS1_Gyro_Y_CAL\tS1_Gyro_Z_CAL\t" + units, 1.6e12 + I * 1000 / 51.2, ACCEL, DPS, sep="\t", form="%.16g", end="\t"), "", 51.2)
    blocks = [f"Acceleration X: {a[0]:.5f}, Y: {a[1]:.5f}, Z: {a[2]:.5f} m/s^2\nRotation X: {w[0]:.6f}, Y: {w[1]:.6f}, Z: {w[2]:.6f} rad/s\nTemperature: 24.51 degC\n" for a, w in zip(ACCEL, GYRO)]
    out["blocks.txt"] = ("sensor test!\nsensor found!\n" + "\n".join(blocks) + "\n", "--rate 50", 50)
    out["lines.json.txt"] = ("\n".join('{"t": %.3f, "gx": %.7f, "gy": %.7f, "gz": %.7f, "ax": %.6f, "ay": %.6f, "az": %.6f}' % (t, *w, *a) for t, w, a in zip(T, GYRO, ACCEL)) + "\n", SI, 100)
    out["openlog.txt"] = (table("rtcDate,rtcTime,aX,aY,aZ,gX,gY,gZ,mX,mY,mZ,imu_degC,output_Hz,", ["01/02/2023"] * N, clock((10, 0, 0), 0.02, cut=4), IN_G * 1000, DPS, mag, T * 0 + 25.1, T * 0 + 50, end=","), "--gyro-unit deg/s --accel-unit mg", 50)
    out["points.txt"] = (table("time (us)\tstatus\taccX (m.s-2)\taccY (m.s-2)\taccZ (m.s-2)\tgyroX (deg.s-1)\tgyroY (deg.s-1)\tgyroZ (deg.s-1)\ttemp (degC)", I * 5000 + 55, zero, ACCEL, DPS, T * 0 + 31.5, sep="\t"), "", 200)
    out["board.csv"] = (table("Sample,X_GYRO_OUT,Y_GYRO_OUT,Z_GYRO_OUT,X_ACCL_OUT,Y_ACCL_OUT,Z_ACCL_OUT,TEMP_OUT", I, DPS, IN_G * 1000, T * 0 + 29.0), "--gyro-unit deg/s --accel-unit mg --rate 100", 100)
    out["increments.txt"] = (table("", 456300 + I * 0.005, GYRO * 0.005, ACCEL * 0.005, sep=" ", form="%.12g"), "--columns time[s],dtheta_x[rad],dtheta_y[rad],dtheta_z[rad],dv_x[m/s],dv_y[m/s],dv_z[m/s]", 200)
    out["serial_date.csv"] = (table("date,gx [rad/s],gy [rad/s],gz [rad/s],ax [m/s^2],ay [m/s^2],az [m/s^2]", 44197.5 + T / 86400, GYRO, ACCEL, form="%.15g"), "", 100)
    out["zone.csv"] = (table("Timestamp;GyroX (°/s);GyroY (°/s);GyroZ (°/s);AccX (g);AccY (g);AccZ (g)", [f"{c}+02:00" for c in clock((23, 59, 58), form="%Y-%m-%dT%H:%M:%S.%f")], DPS, IN_G, sep=";"), "", 100)
    out["address.txt"] = ("StartTime: 2021-08-16 10:22:33.331\n" + table("address\tTime(s)\tax(g)\tay(g)\taz(g)\twx(deg/s)\twy(deg/s)\twz(deg/s)\tAngleX(deg)\tAngleY(deg)\tAngleZ(deg)\tT(°)", ["0x50"] * N, clock((10, 22, 33)), IN_G, DPS, angles, T * 0 + 30.25, sep="\t"), "", 100)
    fixed = "\n".join("%8.3f%11.6f%11.6f%11.6f%11.5f%11.5f%11.5f" % (t, *w, *a) for t, w, a in zip(T, GYRO, ACCEL))
    out["fixed_width.txt"] = ("  TIME        P         Q         R        FX        FY        FZ\n  sec      rad/s     rad/s     rad/s    m/s^2     m/s^2     m/s^2\n" + fixed + "\n", "", 100)
    out["own_stamps.csv"] = (table("loggingTime(txt),loggingSample(N),accelerometerTimestamp_sinceReboot(s),accelerometerAccelerationX(G),accelerometerAccelerationY(G),accelerometerAccelerationZ(G),gyroTimestamp_sinceReboot(s),gyroRotationX(rad/s),gyroRotationY(rad/s),gyroRotationZ(rad/s)", [f"{c} +0100" for c in clock((12, 0, 0), form="%Y-%m-%d %H:%M:%S.%f")], I, 81234.5 + T, IN_G, 81234.503 + T, GYRO, form="%.12g"), "", 100)
    out["odr.csv"] = ("evaluation data\nSensor: six axes\nODR: 104 Hz\n" + table("TIMESTAMP [ms],ACC_X [mg],ACC_Y [mg],ACC_Z [mg],GYR_X [mdps],GYR_Y [mdps],GYR_Z [mdps]", np.rint(I * 1000 / 104).astype(int), IN_G * 1000, DPS * 1000), "", 104)
    out["minutes_seconds.csv"] = (table("Time,gx(dps),gy(dps),gz(dps)", clock((10, 59, 58), form="%M:%S.%f"), DPS), "", 100)
    out["ticks.csv"] = (table("ticks,gx,gy,gz,ax,ay,az", I * 640 + 5, GYRO, ACCEL), SI + " --time-unit ticks:32768", 51.2)
    out["week.csv"] = (table("week,tow_ms,gyro_x(rad/s),gyro_y(rad/s),gyro_z(rad/s),acc_x(m/s2),acc_y(m/s2),acc_z(m/s2)", zero + 2200, (I * 8 + 604797000) % 604800000, GYRO, ACCEL), "", 125)
    out["many_columns.csv"] = (table("Year,Month,Day,Hour,Minute,Second,Gx (deg/s),Gy (deg/s),Gz (deg/s)", zero + 2020, zero + 3, zero + 4, *[[c.split(":")[k] for c in clock((10, 59, 58))] for k in range(3)], DPS), "", 100)
    out["milli_centi.csv"] = (table("t(s) gyro_x(mrad/s) gyro_y(mrad/s) gyro_z(mrad/s) acc_x(cm/s^2) acc_y(cm/s^2) acc_z(cm/s^2)", T, GYRO * 1000, ACCEL * 100, sep=" "), "", 100)
    out["startup.csv"] = (table("GpsCycle,GpsWeek,GpsTow,TimeStartup,Yaw,Pitch,Roll,MagX,MagY,MagZ,AccelX,AccelY,AccelZ,GyroX,GyroY,GyroZ,Temperature,Pressure", zero, zero, zero, I * 5000000 + 12345678901, angles, mag, ACCEL, GYRO, T * 0 + 28.1, T * 0 + 100.1), SI, 200)
    attitude = "VNYMR,+100.00,+000.10,-000.20,+1.0,+2.0,+3.0"
    out["sentences.txt"] = ("\n".join(sentence("%s,%+.6f,%+.6f,%+.6f,%+.7f,%+.7f,%+.7f" % (attitude, *a, *w)) for a, w in zip(ACCEL, GYRO)) + "\n", "--rate 40", 40)
    out["stamped_sentences.txt"] = ("\n".join(f"[{c}] " + sentence("VNIMU,+1.0,+2.0,+3.0,%+.6f,%+.6f,%+.6f,%+.7f,%+.7f,%+.7f,+25.1,+101.3" % (*a, *w)) for c, a, w in zip(clock((10, 0, 0)), ACCEL, GYRO)) + "\n", "", 100)
    out["remark.csv"] = (table("time,ax,ay,az,gx,gy,gz,label", T, ACCEL, GYRO, ["walking" if k % 50 else "" for k in I]), SI, 100)
    out["quoted.csv"] = (table('"time"$"gx"$"gy"$"gz"$"ax"$"ay"$"az"', T, GYRO, ACCEL, sep="$").replace("$", '","').replace('""', '"').replace("\n", '"\n"')[:-1], SI, 100)
    typed = [[I * 10000 + 100, ["ACC"] * N, ACCEL], [I * 10000 + 5100, ["GYR"] * N, GYRO]]
    halves = [table("", *h, form="%.9g").splitlines() for h in typed]
    out["typed.csv"] = ("time_us,sensor,x,y,z\n" + "\n".join(r for pair in zip(*halves) for r in pair) + "\n", SI, 100)
    out["two_lines.csv"] = (table("Time,Gyroscope,,,Accelerometer,,\ns,x,y,z,x,y,z", T, GYRO, ACCEL), SI, 100)
    out["coarse.csv"] = (table("Date,Time,gx (dps),gy (dps),gz (dps)", ["2021/03/04"] * N, clock((10, 0, 0), 0.02, "%H:%M:%S", 0), DPS), "", 50)
    out["negative.csv"] = (table("t,gx [rad/s],gy [rad/s],gz [rad/s]", T - 2, GYRO), "", 100)
    out["noon.csv"] = (table("Time,gx [deg/s],gy [deg/s],gz [deg/s]", clock((11, 59, 50), 0.1, "%I:%M:%S.%f %p", 0), DPS), "", 10)
    out["reset.csv"] = (table("time [ms],gx [rad/s],gy [rad/s],gz [rad/s]", np.r_[I[:200] * 10 + 5000, I[:200] * 10], GYRO), "", 100)
    six = "t [s],gx [rad/s],gy [rad/s],gz [rad/s],ax [m/s^2],ay [m/s^2],az [m/s^2]"
    body = table("", T, GYRO, ACCEL)
    lines = body.splitlines()
    out["raw_beside.csv"] = (table("t [s],ax_raw,ay_raw,az_raw,gx_raw,gy_raw,gz_raw,ax [g],ay [g],az [g],gx [deg/s],gy [deg/s],gz [deg/s]", T, np.rint(IN_G * 16384).astype(int), np.rint(DPS * 131).astype(int), IN_G, DPS), "", 100)
    out["header_again.csv"] = ("\n".join([six, *lines[:200], six, *lines[200:], "End of log", "Total: 400 samples"]) + "\n", "", 100)
    out["wide.csv"] = ("\ufeff" + six.replace(",", "\t") + "\n" + body.replace(",", "\t")).encode("utf-16-le"), "", 100
    out["quoted_commas.csv"] = (six + "\n" + "\n".join('"' + '","'.join(f.replace(".", ",") for f in r.split(",")) + '"' for r in lines) + "\n", "", 100)
    out["letters.csv"] = (table("Time (s),Gx (g),Gy (g),Gz (g),ax (deg/s),ay (deg/s),az (deg/s)", T, IN_G, DPS), "", 100)
    out["turned.csv"] = (table("t(s),Gyro Z (deg/s),Gyro Y (deg/s),Gyro X (deg/s),Acc Z (g),Acc Y (g),Acc X (g)", T, DPS[:, ::-1], IN_G[:, ::-1]), "", 100)
    parts = [f"2021-03-04,10:00:{k // 100:02d},{k % 100 * 10}" for k in I]
    out["clock_and_ms.csv"] = ("Date,Time,ms" + six[5:] + "\n" + "\n".join(f"{p},{r.partition(',')[2]}" for p, r in zip(parts, lines)) + "\n", "", 100)
    out["digits.csv"] = (table("UTC time (HHMMSS.SS)" + six[5:], [f"{c[:2]}{c[3:5]}{c[6:]}" for c in clock((10, 59, 58))], GYRO, ACCEL), "", 100)
    out["counter.csv"] = (table("cnt" + six[5:], I % 256, GYRO, ACCEL), "--rate 100", 100)
    echo = "header:\n  stamp:\n    sec: {}\n    nanosec: {}\n  frame_id: imu\norientation:\n  x: 0.0\n  w: 1.0\nangular_velocity:\n  x: {:.8f}\n  y: {:.8f}\n  z: {:.8f}\nlinear_acceleration:\n  x: {:.6f}\n  y: {:.6f}\n  z: {:.6f}\n---\n"
    out["echo.txt"] = ("".join(echo.format(1600000000 + k // 100, k % 100 * 10**7, *GYRO[k], *ACCEL[k]) for k in I), SI, 100)
    plain = table("time [s],gx [rad/s],gy [rad/s],gz [rad/s]", T, GYRO).encode()
    out["plain.csv.gz"], out["plain.csv.bz2"], out["plain.csv.xz"] = (gzip.compress(plain), "", 100), (bz2.compress(plain), "", 100), (lzma.compress(plain), "", 100)
    return out
    # fmt: on


def asking():
    """name -> (content, flags, what is asked for, the flags that answer, rate)."""
    # fmt: off
    zero = I * 0
    out = {}
    out["two_imus.csv"] = (table("t [s],imu0_gx [rad/s],imu0_gy [rad/s],imu0_gz [rad/s],imu1_gx [rad/s],imu1_gy [rad/s],imu1_gz [rad/s]", T, GYRO, GYRO + 1), "", "--columns", None, 100)
    out["unnamed_ticks.csv"] = (table("timestamp,gx,gy,gz,ax,ay,az", I * 640 + 5, GYRO, ACCEL), SI, "--time-unit ticks:HZ", "--time-unit ticks:32768", 51.2)
    out["sensortime.csv"] = (table("sensortime,gyr_x,gyr_y,gyr_z,acc_x,acc_y,acc_z", I * 256 + 1000, GYRO, ACCEL), SI, "--time-unit ticks:HZ", "--time-unit ticks:25600", 100)
    out["one_and_two.csv"] = (table("time,gyro_1 [rad/s],gyro_2 [rad/s]", T, GYRO[:, 0], GYRO[:, 1]), "", "counted from 0 or from 1", "--columns time,gyro_x[rad/s],gyro_y[rad/s]", 100)
    out["nothing.csv"] = (table("", T, GYRO, ACCEL), SI, "--columns", None, 100)
    out["day_or_month.csv"] = (table("date,time,gx [rad/s],gy [rad/s],gz [rad/s]", ["03/04/2021" if k < 200 else "05/06/2021" for k in I], clock((10, 0, 0)), GYRO), "", "day or the month first", "--columns -,clock,gyro_x[rad/s],gyro_y[rad/s],gyro_z[rad/s]", 100)
    out["whole_seconds.csv"] = (table("t,gx,gy,gz", I, GYRO), "--gyro-unit rad/s", "--rate HZ", "--rate 100", 100)
    out["flag_of_a_column_that_is_not_there.csv"] = (table("time,foo_x,foo_y,foo_z", T, GYRO), "--gyro-unit rad/s", "--columns", "--columns time,gyro_x,gyro_y,gyro_z", 100)
    out["counts.csv"] = (table("time [s],gx [lsb],gy [lsb],gz [lsb]", T, np.rint(DPS * 1e4).astype(int)), "", "--gyro-unit counts:C", "--gyro-unit counts:10000", 100)
    out["hundredths.csv"] = (table("t [s],gx [deg/s*100],gy [deg/s*100],gz [deg/s*100]", T, DPS * 100), "", "--gyro-unit counts:100", "--gyro-unit counts:100", 100)
    out["tenths.csv"] = (table("t [0.1 ms],gx [rad/s],gy [rad/s],gz [rad/s]", I * 100, GYRO), "", "--time-unit ticks:10000", "--time-unit ticks:10000", 100)
    out["accel_first.csv"] = (table("", T, zero + 3, ACCEL, zero + 4, GYRO), SI, "--columns", None, 100)
    out["minutes.csv"] = (table("time,gx,gy,gz", T / 6, GYRO, form="%.9f"), "--gyro-unit rad/s", "--time-unit min", "--time-unit min", 10)
    return out
    # fmt: on
