# ruff: noqa: E501, UP031
"""Logs whose clocks, units, headers or lines are of kinds that invent a rate, a gap or a sensor when they
are read by rule of thumb: the same standing sensor in each.
"""

from __future__ import annotations

import json

import numpy as np
from strange_logs import ACCEL, DPS, GYRO, IN_G, SI, I, N, T, clock, table
from stranger_logs import SIX

HEAD = f"time,{SIX}"


def _lines(form):
    return "".join(form(k, GYRO[k], ACCEL[k]) for k in range(N))


def _six(w, a, sep=","):
    return sep.join("%.9g" % v for v in (*w, *a))


def _ticks(rate, tick, first=12_345.6):
    """Seconds of a clock that moves every `tick` s."""
    return np.floor((I / rate + first) / tick) * tick


def clocks():
    """name -> (heading of the stamps, stamps as text, rate Hz, rows lost)."""
    # fmt: off
    text = lambda form, x: [form % v for v in x]  # noqa: E731
    whole = lambda x: [str(int(v)) for v in x]  # noqa: E731
    frames = lambda fs, fps, sign: [f"10:59:{k // fs:02d}{sign}{int(k % fs * fps / fs):02d}" for k in I]  # noqa: E731
    lost = I + 40 * (I >= 200)
    return {
        "a computer's ticks under 100 Hz": ("time_ms", whole(_ticks(100, 1 / 64) * 1e3), 100, 0),
        "a computer's ticks under 50 Hz": ("time_ms", whole(_ticks(50, 1 / 64) * 1e3), 50, 0),
        "a computer's ticks in seconds": ("t", text("%.3f", _ticks(60, 1 / 64)), 60, 0),
        "a gap under a computer's ticks": ("ms", whole(np.floor((lost / 100 + 3) * 64) / 64e-3), 100, 40),
        "jiffies": ("t_s", text("%.3f", _ticks(104, 1 / 250)), 104, 0),
        "six digits from 1000 s on": ("time", text("%.6g", 999 + I / 200), 200, 0),
        "six digits from 10000 s on": ("t", text("%.6g", 9998 + I / 100), 100, 0),
        "single precision": ("time", text("%.6f", np.float32(40_000 + I / 200)), 200, 0),
        "digits of a date to the ms": ("timestamp", clock((10, 59, 58), form="%Y%m%d%H%M%S%f"), 100, 0),
        "digits of a date and a fraction": ("time", clock((10, 59, 58), form="%Y%m%d%H%M%S.%f"), 100, 0),
        "digits of a clock": ("UTC", clock((10, 59, 58), form="%H%M%S.%f"), 100, 0),
        "digits of a clock over midnight": ("time", clock((23, 59, 58), form="%H%M%S.%f"), 100, 0),
        "25 frames": ("timecode", frames(25, 25, ":"), 25, 0),
        "25 frames under 100 Hz": ("timecode", frames(100, 25, ":"), 100, 0),
        "30 frames, dropped": ("tc", frames(30, 30, ";"), 30, 0),
        "hundredths behind a colon": ("clock", frames(100, 100, ":"), 100, 0),
        "year of two digits first": ("time", clock((10, 59, 58), form="%y/%m/%d %H:%M:%S.%f"), 100, 0),
        "year of two digits last": ("time", clock((10, 59, 58), form="%d.%m.%y %H:%M:%S.%f"), 100, 0),
        "packets of four": ("timestamp_ms", whole(I // 4 * 40 + 171_000), 100, 0),
        "packets of four, late by chance": ("timestamp_ms", whole(I // 4 * 40 + np.resize([0, 3, 11, 1, 9, 4, 2], N // 4).repeat(4)), 100, 0),
        "seconds since 1970 under 50 Hz": ("unix", whole(1_700_000_000 + (I + 17) // 50), 50, 0),
        "Julian days": ("JD", text("%.10f", 2_459_277.5 + I / 50 / 86_400), 50, 0),
        "hours": ("h", text("%.9f", I / 100 / 3600), 100, 0),
        "misspelled": ("Timpstemp", whole(1_614_855_598_000_000 + I * 10_000), 100, 0),
    }
    # fmt: on


def logs():
    """name -> (content, flags, rate Hz). Every one opens with its flags."""
    # fmt: off
    counts = np.c_[np.rint(DPS * 10_000), np.rint(IN_G * 16_384)].astype(int)
    per = "--gyro-unit counts:10000 --accel-unit counts:16384"
    named = "gyro_x gyro_y gyro_z accel_x accel_y accel_z".split()
    wide = "time [s],gx [%s],gy [%s],gz [%s],ax [%s],ay [%s],az [%s]"
    body = table("", T, GYRO, ACCEL)
    out = {
        "size_of_a_count.csv": (table(wide % (*["0.1dps"] * 3, *["1/1000 g"] * 3), T, DPS * 10, IN_G * 1000), "", 100),
        "unit_behind_a_slash.csv": (table("time_s,gyro_x_rad/s,gyro_y_rad/s,gyro_z_rad/s,ax_m/s/s,ay_m/s/s,az_m/s/s", T, GYRO, ACCEL), "", 100),
        "unit_in_many_words.csv": (table(",".join(["Time in seconds", *(f"Angular velocity {a} in degrees per second" for a in "XYZ"), *(f"Acceleration {a} in meters per second squared" for a in "XYZ")]), T, DPS, ACCEL), "", 100),
        "units_above.csv": ("# units: s, rad/s, rad/s, rad/s, m/s^2, m/s^2, m/s^2\n" + table(HEAD, T, GYRO, ACCEL), "", 100),
        "units_in_a_sentence.csv": ("# gyro in deg/s, accel in g\n" + table(HEAD, T, DPS, IN_G), "", 100),
        "units_of_each.csv": ("# gyro: deg/s\n# acc: g\n" + table(HEAD, T, DPS, IN_G), "", 100),
        "unsigned.csv": (table(f"ms,{SIX}", I * 10, counts[:, :3] & 0xFFFF, counts[:, 3:] & 0xFFFF), per, 100),
        "hexadecimal.txt": ("".join(" ".join("0x%04X" % (v & 0xFFFF) for v in r) + "\n" for r in counts.tolist()), f"{per} --rate 100 --columns gyro_x,gyro_y,gyro_z,accel_x,accel_y,accel_z", 100),
        "rate_in_a_line.csv": ("---- File created at 100 Hz  Filter Normal ----\n" + table(SIX, GYRO, ACCEL), SI, 100),
        "two_headers.csv": ("time,gyro,gyro,gyro,accel,accel,accel\n,x,y,z,x,y,z\n" + body, SI, 100),
        "three_headers.csv": ("Sensor 1,,,,,,\nTime,Gyroscope,,,Accelerometer,,\n(s),X,Y,Z,X,Y,Z\n" + body, SI, 100),
        "how_sampled.dat": ('"TIMESTAMP","GyroX","GyroY","GyroZ","AccX","AccY","AccZ"\n"TS","deg/s","deg/s","deg/s","g","g","g"\n"","Smp","Smp","Smp","Smp","Smp","Smp"\n' + table("", clock((10, 0, 0), form="%Y-%m-%d %H:%M:%S.%f"), DPS, IN_G), "", 100),
        "behind_every_row.txt": ("gx\tgy\tgz\tax\tay\taz\ttime\n" + table("", GYRO, ACCEL, T, sep="\t", end="\t"), SI, 100),
        "message_laid_flat.csv": ("bagTimestamp,header,secs,nsecs,orientation,x,y,z,w,angular_velocity,x,y,z,linear_acceleration,x,y,z\n" + _lines(lambda k, w, a: f"{1614855598000000000 + k * 10**7 + k % 7 * 12345},,{1614855598 + k // 100},{k % 100 * 10**7},,0,0,0,1,,{_six(w, [])},,{_six([], a)}\n"), SI, 100),
        "abscissas.csv": (table(",".join(f"X [s],Sensor 1: {k}.{a} 1 [{u}]" for k, u in (("ACC", "g"), ("GYRO", "deg/s")) for a in "XYZ"), *[x for m in (IN_G, DPS) for a in range(3) for x in (T, m[:, a])]), "", 100),
        "sensors_of_linux.csv": (table("timestamp,in_anglvel_x,in_anglvel_y,in_anglvel_z,in_accel_x,in_accel_y,in_accel_z", 1614855598 * 10**9 + I * 5_000_000, GYRO, ACCEL), SI, 200),
        "left_and_up.csv": (table("time,acc_forward,acc_left,acc_up,gyro_forward,gyro_left,gyro_up", T, ACCEL, GYRO), SI, 100),
        "turns.csv": (table("time [s],Roll [deg/s],Pitch [deg/s],Yaw [deg/s],longacc [g],latacc [g],vertacc [g]", T, DPS, IN_G), "", 100),
        "piped.csv": (table(",".join(['"Time"|"ms"|0|0|1', *(f'"Gyro{a}"|"deg/s"|-9|9|100' for a in "XYZ"), *(f'"Accel{a}"|"G"|-9|9|100' for a in "XYZ")]), I * 10, DPS, IN_G), "", 100),
        "misspelled.csv": (table("time,Gyroscoope X,Gyroscoope Y,Gyroscoope Z,Acelerometer X,Acelerometer Y,Acelerometer Z", T, GYRO, ACCEL), SI, 100),
        "labels_and_blanks.log": (_lines(lambda k, w, a: f"[00:00:{k / 100:06.3f},000] <inf> imu: " + " ".join(f"{n} {v:.9g}" for n, v in zip(SIX.split(","), (*w, *a))) + "\n"), SI, 100),
        "kernel.log": (_lines(lambda k, w, a: f"[{k / 100 + 12:12.6f}] imu: " + " ".join(f"{n}={v:.9g}" for n, v in zip(SIX.split(","), (*w, *a))) + "\n"), SI, 100),
        "colours.log": (_lines(lambda k, w, a: f"\x1b[0;32mI ({3000 + k * 10}) IMU: " + " ".join(f"{n}={v:.9g}" for n, v in zip(SIX.split(","), (*w, *a))) + "\x1b[0m\n"), SI, 100),
        "seconds_before_a_colon.txt": (_lines(lambda k, w, a: f"{k / 100:.2f} s: gyro=({_six(w, [], ', ')}) accel=({_six([], a, ', ')})\n"), SI, 100),
        "sensor_before_its_axes.txt": (_lines(lambda k, w, a: "".join(f"{n}:\tx= {x[0]:.9g} |\ty= {x[1]:.9g} |\tz= {x[2]:.9g}\n" for n, x in (("Gyro", w), ("Accl", a))) + "--\n"), f"{SI} --rate 100", 100),
        "signals_of_a_message.log": (_lines(lambda k, w, a: f"({1690000000 + k / 100:.6f}) can0 123#00 :: IMU(" + ", ".join(f"{n}: {v:.9g} {u}" for n, v, u in zip(("GyroX", "GyroY", "GyroZ", "AccX", "AccY", "AccZ"), (*w, *a), ["rad/s"] * 3 + ["m/s^2"] * 3)) + ")\n"), "", 100),
        "one_reading_a_row.csv": (",result,table,_measurement,_time,_field,_value\n" + "".join(f",,{j},imu,2021-03-04T10:59:{k / 100:09.6f}Z,{n},{v:.9g}\n" for j, n in enumerate(named) for k, v in enumerate(np.c_[GYRO, ACCEL][:, j])), SI, 100),
        "arrays_of_one.txt": (_lines(lambda k, w, a: '{"Body": {"Timestamp": %d, "ArrayAcc": [{"x": %.9g, "y": %.9g, "z": %.9g}], "ArrayGyro": [{"x": %.9g, "y": %.9g, "z": %.9g}]}}\n' % (k * 10 + 99, *a, *w)), SI, 100),
        "numbers_that_touch.txt": (_lines(lambda k, w, a: "%10.4f%12.8f%12.8f%12.8f%11.6f%11.6f%11.6f\n" % (k / 100, *w, *a)), f"{SI} --columns time,{','.join(named)}", 100),
    }
    out["row_names.txt"] = ('"time" "gx" "gy" "gz" "ax" "ay" "az"\n' + _lines(lambda k, w, a: f'"{k + 1}" {k / 100} {_six(w, a, " ")}\n'), SI, 100)
    out["columns_and_data.json"] = (json.dumps({"columns": HEAD.split(","), "index": I.tolist(), "data": np.c_[T, GYRO, ACCEL].tolist()}), SI, 100)
    out["turkish.csv"] = (table("Zaman,Jiroskop X,Jiroskop Y,Jiroskop Z,İvme X,İvme Y,İvme Z", T, GYRO, ACCEL), SI, 100)
    out["russian.csv"] = (table(";".join(["Время (с)", *(f"Угловая скорость {a} (град/с)" for a in "XYZ"), *(f"Ускорение {a} (м/с²)" for a in "XYZ")]), T, DPS, ACCEL, sep=";"), "", 100)
    out["specific_force.csv"] = (table("time,Wx,Wy,Wz,SFx,SFy,SFz", T, GYRO, ACCEL), SI, 100)
    out["intervals.csv"] = (table(f"delta_ms,{SIX}", np.where(I, 10, 0), GYRO, ACCEL), SI, 100)
    out["cycles.csv"] = (table(f"cycles,{SIX}", (I * 480_000 + 12_345) % 2**32, GYRO, ACCEL), f"{SI} --time-unit ticks:48e6", 100)
    out["names_in_a_remark.txt"] = (f"; made by hand\n; columns: {HEAD.replace(',', ' ')}\n" + table("", T, GYRO, ACCEL, sep=" "), SI, 100)
    out["unit_behind_a_bracket.txt"] = (_lines(lambda k, w, a: f"t={k * 10}ms w=[{_six(w, [])}]rad/s a=[{_six([], a)}]m/s2\n"), "", 100)
    out["plotted.txt"] = (_lines(lambda k, w, a: "".join(f">{n}:{k * 10}:{v:.9g}\n" for n, v in zip(SIX.split(","), (*w, *a)))), SI, 100)
    both = [(n, k, o, x) for k in range(N) for n, o, x in (("accelerometer", 0, ACCEL[k]), ("gyroscope", 3, GYRO[k]))]
    out["samples_of_each.json"] = (json.dumps([{"sensor": n, "time": 1614855598 * 10**9 + k * 10**7 + o, "values": dict(zip("xyz", x.tolist()))} for n, k, o, x in both]), SI, 100)
    out["values_from_one.csv"] = ("wall_ms,sensor_type,v1,v2,v3\n" + "".join(f"{1614855598000 + k * 20 + o},{n},{_six(x, [])}\n" for n, k, o, x in both), SI, 50)
    out["slashes_between.txt"] = (_lines(lambda k, w, a: f"{k * 20}ms, gyro: {_six(w, [], ' / ')} rad/s, acc: {_six([], a, ' / ')} m/s^2\n"), "", 50)
    out["tuples.txt"] = (_lines(lambda k, w, a: f"{{'t': {k * 10}, 'gyro': ({_six(w, [])}), 'accel': ({_six([], a)})}}\n"), SI, 100)
    out["stamp_of_a_terminal.log"] = (_lines(lambda k, w, a: f"[Thu Mar 04 10:59:{k / 50 + 10:06.3f} 2021] {_six(w, a)}\n"), f"{SI} --columns clock,{','.join(named)}", 50)
    out["stamp_before_commas.txt"] = (_lines(lambda k, w, a: f"2021-03-04 10:59:{k / 50 + 10:06.3f} {_six(w, a)}\n"), f"{SI} --columns date,{','.join(named)}", 50)
    out["hundredths_of_degrees.csv"] = (table("t_ms,gx_cdps,gy_cdps,gz_cdps,ax_mg,ay_mg,az_mg", I * 10, DPS * 100, IN_G * 1000), "", 100)
    out["spanish.csv"] = (table("tiempo,Giro X,Giro Y,Giro Z,Acel X,Acel Y,Acel Z", T, GYRO, ACCEL), SI, 100)
    out["body_rates.csv"] = (table("elapsed_s,p_radps,q_radps,r_radps,ax_mps2,ay_mps2,az_mps2", T, GYRO, ACCEL), "", 100)
    nines = ",".join(["0.0"] * 9)
    out["echo_of_a_topic.csv"] = (_lines(lambda k, w, a: f"{1614855598 + k // 100},{k % 100 * 10**7},imu_link,0.0,0.0,0.0,1.0,{nines},{_six(w, [])},{nines},{_six([], a)},{nines}\n"), "", 100)
    return out
    # fmt: on


def wristband():
    """Start and rate in every column of the first rows: content, flags, rate Hz."""
    top = "1614855598.000000, 1614855598.000000, 1614855598.000000\n32.0, 32.0, 32.0\n"
    return top + table("", IN_G), "--accel-unit g --columns accel_x,accel_y,accel_z", 32
