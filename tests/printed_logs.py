# ruff: noqa: E501
"""The same standing sensor as printed messages, wristbands, cameras and data sets write it."""

from __future__ import annotations

import json

from strange_logs import ACCEL, DPS, GYRO, IN_G, SI, I, N, T, clock, table

DEG_G = "--gyro-unit deg/s --accel-unit g"


CLOCK = clock((10, 21, 33), form="%Y-%m-%dT%H:%M:%S.%f")


def _lines(form):
    return "".join(form(k, GYRO[k], ACCEL[k]) + "\n" for k in range(N))


def _three(x, form="%.9g", sep=","):
    return sep.join(form % v for v in x)


def _xyz(v, form="x={:.9f}, y={:.9f}, z={:.9f}"):
    return form.format(*v)


def _block(name, v):
    return f"{name} {{\n" + "".join(f"  {c}: {x:.9g}\n" for c, x in zip("xyz", v)) + "}\n"


def logs():
    """name -> (content, flags, rate Hz); every one opens with its flags."""
    # fmt: off
    out = {}
    out["objects.txt"] = (_lines(lambda k, w, a: f"IMU data: IMUMeasurement(frame={k}, timestamp={14.4 + k / 20:.6f}, accelerometer=Vector3D({_xyz(a)}), gyroscope=Vector3D({_xyz(w)}), compass=4.7)"), SI, 20)
    stamp = lambda k: f"header {{\n  stamp {{\n    sec: {12 + k // 100}\n" + f"    nsec: {k % 100 * 10**7}\n" * (k % 100 > 0) + "  }\n  data {\n    key: \"frame_id\"\n    value: \"imu\"\n  }\n}\n"  # noqa: E731
    out["braces.txt"] = (_lines(lambda k, w, a: f"{stamp(k)}entity_name: \"rover\"\norientation {{\n  w: 1\n}}\n{_block('angular_velocity', w)}{_block('linear_acceleration', a)}"), "", 100)
    out["unit_before.txt"] = (_lines(lambda k, w, a: f"Accelerometer timestamp: {5012 + k * 10}.3 ms\nAccelerometer [m/s^2]: {_xyz(a, 'x: {:.9f} y: {:.9f} z: {:.9f}')}\nGyroscope timestamp: {5013 + k * 10}.3 ms\nGyroscope [rad/s]: {_xyz(w, 'x: {:.9f} y: {:.9f} z: {:.9f}')}"), "", 100)
    out["unit_behind.txt"] = (_lines(lambda k, w, a: f"ACCEL.x:{IN_G[k, 0]:.9f},ACCEL.y:{IN_G[k, 1]:.9f},ACCEL.z:{IN_G[k, 2]:.9f} Unit:g\nGYRO.x:{DPS[k, 0]:.9f},GYRO.y:{DPS[k, 1]:.9f},GYRO.z:{DPS[k, 2]:.9f} Unit:degrees/sec"), "--rate 50", 50)
    out["razor.txt"] = (_lines(lambda k, w, a: f"#YPR=1.0,2.0,{k % 7} #A-C={_three(IN_G[k] * 256)} #M-C=1,2,3 #G-C={_three(DPS[k] * 14.375)}"), "--rate 50 --gyro-unit counts:14.375 --accel-unit counts:256", 50)
    day = [f"2026-3-4 9:{8 + (k // 50) // 60}:{k // 50 % 60}.{k % 50 * 20}" for k in I]
    out["unpadded.txt"] = (table("Chiptime\tax(g)\tay(g)\taz(g)\twx(deg/s)\twy(deg/s)\twz(deg/s)\tT(°)", day, IN_G, DPS, T * 0 + 29.3, sep="\t"), "", 50)
    out["user_and_gravity.csv"] = (table("loggingTime(txt),motionTimestamp_sinceReboot(s)," + ",".join(f"motion{q}{c}({u})" for q, u in (("RotationRate", "rad/s"), ("UserAcceleration", "G"), ("Gravity", "G")) for c in "XYZ"), clock((10, 21, 33), form="%Y-%m-%dT%H:%M:%S.%f"), T + 812.5, GYRO, IN_G - [0.01, 0.02, -0.99], IN_G * 0 + [0.01, 0.02, -0.99]), "", 100)
    out["numbered_sensors.csv"] = ("% 0 = Accelerometer\n% 1 = Gyroscope\n% 2 = Magnetometer\n% Accelerometer: G\n% Gyroscope: degrees/second\n% TimeStamp; Sample No; X-Axis; Y-Axis; Z-Axis; Sensor Type;\n" + _lines(lambda k, w, a: f"{k * 10}; {k}; {_three(IN_G[k], sep='; ')}; 0;\n{k * 10 + 1}; {k}; {_three(DPS[k], sep='; ')}; 1;\n{k * 10 + 2}; {k}; 1; 2; 3; 2;"), "--time-unit ms", 100)
    out["streams.csv"] = ("Stream Type,F#,HW Timestamp (ms),Host Timestamp(ms),3DOF_x,3DOF_y,3DOF_z\n" + _lines(lambda k, w, a: f"Gyro,{k},{1700000000123 + k * 10}.0,{1700000000126 + k * 10}.0,{_three(w)}\nAccel,{k},{1700000000124 + k * 10}.0,{1700000000127 + k * 10}.0,{_three(a)}"), SI, 100)
    out["letter_r.csv"] = (table("time_s,ax,ay,az,rx,ry,rz", T, ACCEL, GYRO), SI, 100)
    out["tags_named_by_the_call.txt"] = (_lines(lambda k, w, a: f"UncalAccel,{1700000000123 + k * 10},{_three(a)},0\nUncalGyro,{1700000000125 + k * 10},{_three(w)},0"), SI + " --columns sensor,time,x,y,z,-", 100)
    out["gravity_called_g.csv"] = (table("t,rot_rate_x,rot_rate_y,rot_rate_z,g_x,g_y,g_z,accel_x,accel_y,accel_z", T, GYRO, IN_G, ACCEL), SI, 100)
    out["compass_letters.csv"] = (table("Time [s],a_n [m/s^2],a_e [m/s^2],a_d [m/s^2],p [deg/s],q [deg/s],r [deg/s],phi [deg]", T, ACCEL, DPS, T), "", 100)
    out["text_stamps.jsonl"] = (_lines(lambda k, w, a: json.dumps({"Time": CLOCK[k], "MPU": {"GyroXAxis": w[0], "GyroYAxis": w[1], "GyroZAxis": w[2], "AccelXAxis": a[0], "AccelYAxis": a[1], "AccelZAxis": a[2]}})), SI, 100)
    out["events.csv"] = ("TimeStamp,Gyro_X,Gyro_Y,Gyro_Z,Accelerometer_X,Accelerometer_Y,Accelerometer_Z,Elements\n" + _lines(lambda k, w, a: f"{CLOCK[k]},,,,,,,/event/blink\n" * (k % 90 == 7) + f"{CLOCK[k]},{_three(w)},{_three(a)},"), SI, 100)
    out["camera.csv"] = (table('"cts","date","Gyroscope (z,x,y) [rad/s]","1","2","temperature [°C]"', T * 1000 + 176.6, clock((10, 21, 33), form="%Y-%m-%dT%H:%M:%S.%fZ", cut=None), GYRO[:, [2, 0, 1]], T * 0 + 41), "--time-unit ms", 100)
    # fmt: on
    return out


def asking():
    """name -> (content, flags, what is said, flags that answer, rate Hz)."""
    # fmt: off
    out = {}
    out["loop.csv"] = (table("loop_time_us,gx,gy,gz,ax,ay,az", 2500 + I * 37 % 61, GYRO, ACCEL), SI, "are durations of about 25", "--time-unit none --rate 400", 400)
    out["both_at_once.csv"] = (table("gx,gy,gz,ax,ay,az", GYRO, ACCEL), "", "--accel-unit m/s^2, g, mg or counts:C (C counts per g); and it has no time column and states no rate; give --rate HZ", SI + " --rate 50", 50)
    out["untold.csv"] = ("t_ms,sensor_id,x,y,z\n" + _lines(lambda k, w, a: f"{k * 10},1,{_three(a)}\n{k * 10 + 1},4,{_three(w)}"), "", "`sensor_id` tells apart (1, 4)", "", None)
    out["camera.csv"] = (table('"cts [ms]","Gyroscope [rad/s]","1","2"', T * 1000, GYRO), "", "nothing says in what order", "--columns time[ms],gyro_x,gyro_y,gyro_z", 100)
    out["numbered_lines.txt"] = (_lines(lambda k, w, a: f"IMU1: GyX = {w[0]:.9f}\tGyY = {w[1]:.9f}\tGyZ = {w[2]:.9f}\nIMU2: GyX = {w[0] + 1:.9f}\tGyY = {w[1] + 1:.9f}\tGyZ = {w[2] + 1:.9f}"), "--gyro-unit rad/s --rate 50", "both `IMU1 GyX` and `IMU2 GyX` would be gyro_x", "--columns gyro_x,gyro_y,gyro_z,-,-,-", 50)
    out["buffers.csv"] = ("timestamp,scale," + ",".join(f"{c}[{i}]" for c in "xyz" for i in range(8)) + "\n" + _lines(lambda k, w, a: f"{k * 1000},0.001" + ",7" * 24), "", "each of its rows holds 8 samples", "", None)
    out["increments.csv"] = (table("time,dt,theta[0],theta[1],theta[2],vel[0],vel[1],vel[2]", T, T * 0 + 0.01, GYRO * 0.01, ACCEL * 0.01), "", "time,-,dtheta_x[rad],dtheta_y[rad],dtheta_z[rad],dv_x[m/s],dv_y[m/s],dv_z[m/s]", "--columns time,-,dtheta_x[rad],dtheta_y[rad],dtheta_z[rad],dv_x[m/s],dv_y[m/s],dv_z[m/s]", 100)
    # fmt: on
    return out
