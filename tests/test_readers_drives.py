"""A drive of an IMU's file and a receiver's: RTKLIB and NMEA."""

import numpy as np
from still_sensor import RATE, N, still

from imu_lib.readers import read_drive


def test_drive_of_imu_and_gnss_files(tmp_path):
    g, a = still()
    t = 1.7e9 + np.arange(N) / RATE  # UTC
    np.savetxt(
        tmp_path / "imu.csv",
        np.column_stack([t, g, a]),
        delimiter=",",
        fmt="%.12f",
        comments="",
        header="time [s],gx [rad/s],gy [rad/s],gz [rad/s],ax [m/s^2],ay [m/s^2],az [m/s^2]",
    )
    rows = [
        "% program   : RTKLIB",
        "%  GPST  latitude(deg) longitude(deg)  height(m)   Q  ns   sdn(m)   sde(m)   sdu(m)",
    ]
    for k in range(10):
        s = np.datetime64(int((1.7e9 + k + 18) * 1000), "ms")  # GPS time is 18 s ahead of UTC
        rows.append(
            f"{str(s.astype('datetime64[D]')).replace('-', '/')} {str(s).split('T')[1]} 45.0{k} 7.5 250.0 1 12 0.01 0.02 0.03"
        )
    (tmp_path / "g.pos").write_text("\n".join(rows) + "\n")
    drive = read_drive(tmp_path / "imu.csv", gnss=tmp_path / "g.pos")
    assert np.allclose(drive.gnss_time, np.arange(10), atol=1e-3) and np.allclose(
        np.degrees(drive.gnss_position[:, 0]), 45 + 0.01 * np.arange(10)
    )
    assert np.allclose(drive.gnss_position_sd, [0.01, 0.02, 0.03]) and np.allclose(drive.gyro, g)
    nmea = []
    for k in range(10):
        clock = str(np.datetime64(int(1.7e9) + k, "s")).split("T")[1].replace(":", "")
        for body in (
            f"GPGGA,{clock}.00,4500.0000,N,00730.0000,E,4,12,0.8,200.0,M,50.0,M,,",
            f"GPRMC,{clock}.00,A,4500.0,N,00730.0,E,10.0,90.0,141123,,,A",
        ):
            nmea.append(
                f"${body}*{np.bitwise_xor.reduce(np.frombuffer(body.encode(), np.uint8)):02X}"
            )
    nmea.insert(4, nmea[4].replace("4500", "4600"))  # a wrong checksum is left out
    (tmp_path / "g.nmea").write_text("\r\n".join(nmea) + "\r\n")
    drive = read_drive(tmp_path / "imu.csv", gnss=tmp_path / "g.nmea")
    assert np.allclose(drive.gnss_time, np.arange(10)) and np.allclose(
        drive.gnss_position, np.tile([np.pi / 4, np.radians(7.5), 250.0], (10, 1))
    )
    assert np.allclose(drive.gnss_velocity, [0, 10 * 1852 / 3600, 0], atol=1e-9) and set(
        drive.gnss_fix
    ) == {4}
