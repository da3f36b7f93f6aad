"""The words that headings are made of, in the languages in which phone apps and loggers write
them.
"""

from __future__ import annotations

import re
import unicodedata

#: Letters that have no accent to leave out, and stand for a plain one all the same.
_PLAIN = str.maketrans({"ı": "i", "ł": "l", "Ł": "L", "ø": "o", "đ": "d"})


def without_accents(text: str) -> str:
    """Without accents: `Accélération` and `Acceleration` are one word."""
    text = unicodedata.normalize("NFKD", text.translate(_PLAIN))
    return "".join(c for c in text if not unicodedata.combining(c))


def words(text: str) -> set[str]:
    return set(without_accents(text).split())


#: Words that tell what a column is, in the languages in which phone apps and loggers write them.
GYRO = words(
    "gyro gyros gyr gyroscope gyroscopes gyroskop giroscopio gyroscoop zyroskop giroskop giro omg "
    "gyrometer pqr omega w wb wib wibb angvel anglvel angrate turnrate rotationrate "
    "winkelgeschwindigkeit drehrate drehraten drehr hoeksnelheid vinkelhastighet vinkelhastighed "
    "kulmanopeus jiroskop uhlovarychlost szogsebesseg acisalhiz gy гироскоп гиро 陀螺仪 陀螺儀 陀螺 角速度 "
    "ジャイロ 자이로 각속도 gyroreading gyrodata rateofturn"
)
ACCEL = words(
    "accelerometer accelerometers accelero accelerometre accel accels accele acc accl acce acel "
    "acl aceler acceleration accelerations xl akzelerometer beschl beschleunigung beschleunigungen "
    "beschleunigungssensor accelerazione accelerometro aceleracion acelerometro aceleracao "
    "versnelling versnellingsmeter gyorsulas kiihtyvyys hastighetsandring acceleratie akseleration "
    "przyspieszenie akcelerometr zrychleni ivme ускорение ускорения акселерометр 加速度 加速度计 加速计 加速度計 "
    "가속도 επιταχυνση επιταχυνσιομετρο accreading ac f fb fib fibb a gforce gf specificforce sf accs"
)
ANGULAR = words(
    "угловая угл acisal uhlova angular ang angulaire angolare rotation rotational turn rot katowa "
    "winkel"
)
SPEED = words(
    "velocity vel rate rates vitesse velocidad velocita velocidade predkosc скорость скорости hiz "
    "rychlost speed turn"
)
#: Letters that name a sensor where they stand nearly alone, and what may stand beside them.
LETTERS = words("g w a f ac gy")
BESIDE_LETTERS = words(
    "rs s b ib imu raw data cal field meas body sensor msg kf r i lsm mpu out filt filtered lpf "
    "corr corrected calib calibrated comp compensated smooth smoothed avg average"
)
DELTA = words("delta d del increment inc dang dvel dtheta dv velinc deltav deltatheta")
DELTA_ANGLE = words("theta angle ang angles dtheta dang rot deltatheta gyro gyr")
DELTA_VELOCITY = words("v vel velocity dv dvel velinc deltav acc accel")
TIME = words(
    "time times timestamp timestamps stamp t zeit zeitstempel temps tiempo tempo tijd czas cas "
    "zaman zamani χρονος время 时间 時間 時刻 时间戳 시간 elapsed sow tow sod ido epoch rostime uptime millis micros nanos "
    "datetime datenum serialdate filetime seconds secs sec second nsecs nsec nanosec nanosecs "
    "nanoseconds usec usecs microseconds frac fraction fractional subsec subsecs subsecond "
    "subseconds milliseconds msec msecs ms us ns s minutes unix jd mjd julian juliandate "
    "tov timestampstart ticks tick sampletimefine"
)
TEMPERATURE = words(
    "temp temps temperature temperatures temperatur temperatura tmp temper температура 温度 온도 "
    "θερμοκρασια sicaklik "
    "tempc tempf"
)
COUNTER = words(
    "index idx sample samples counter count cnt seq sequence frame n i id packet packetcounter"
    " number nr no row line zeile packetcount samplenumber messagecounter"
)
DATE = words("date day datum fecha dates 日期")
NOT = {
    "covariance": "a covariance", "cov": "a covariance", "mag": "a magnetometer",
    "magnetometer": "a magnetometer", "magnetic": "a magnetometer", "magn": "a magnetometer",
    "magnet": "a magnetometer", "compass": "a magnetometer", "magnetfeld": "a magnetometer",
    "magnetometro": "a magnetometer", "field_strength": "a magnetometer", "quat": "an attitude",
    "quaternion": "an attitude", "orientation": "an attitude", "euler": "an attitude",
    "attitude": "an attitude", "roll": "an attitude", "pitch": "an attitude", "yaw": "an attitude",
    "heading": "an attitude", "azimuth": "an attitude", "std": "a standard deviation",
    "sigma": "a standard deviation", "stddev": "a standard deviation", "variance": "a variance",
    "gravity": "gravity as the device computed it", "grav": "gravity as the device computed it",
    "schwerkraft": "gravity as the device computed it", "gravitation": "gravity as the device "
                                                                       "computed it",
    "position": "a position", "pos": "a position", "lat": "a position", "lon": "a position",
    "latitude": "a position", "longitude": "a position", "altitude": "a position", "height": "a position",
    "pressure": "a pressure", "baro": "a pressure", "barometer": "a pressure", "humidity": "humidity",
    "light": "light", "sound": "sound", "decibel": "sound", "battery": "a battery",
    "voltage": "a voltage", "absolute": "the length of a vector", "abs": "the length of a vector",
    "absolut": "the length of a vector", "absolue": "the length of a vector", "betrag": "the length of a vector",
    "norm": "the length of a vector", "magnitude": "the length of a vector", "total": "the length of a vector",
    "composite": "the length of a vector", "resultant": "the length of a vector",
    "mod": "the length of a vector", "len": "the length of a vector",
    "modulus": "the length of a vector", "tgf": "the length of a vector", "bias": "an estimated "
                                                                                  "bias",
    "offset": "an estimated bias", "drift": "an estimated bias", "week": "a week number: the "
                                                                         "second of the week is "
                                                                         "the time",
    "flag": "a flag", "flags": "a flag", "tflags": "a flag", "status": "a status", "accuracy": "an accuracy",
    "speed": "a speed", "distance": "a distance", "checksum": "a checksum", "crc": "a checksum",
    "dq": "an attitude increment", "oriinc": "an attitude increment", "jerk": "a jerk",
    "age": "the age of a value", "err": "an error", "error": "an error", "residual": "a residual",
    "residuals": "a residual", "innov": "a residual", "innovation": "a residual", "noise": "a noise level",
    "factor": "a scale factor", "valid": "a flag", "saturated": "a flag", "clipped": "a flag",
    "peak": "a statistic", "rms": "a statistic", "var": "a variance", "iqr": "a statistic", "mad": "a statistic",
    "kurtosis": "a statistic", "skewness": "a statistic", "entropy": "a statistic", "energy": "a statistic",
    "fft": "a spectrum", "psd": "a spectrum", "diff": "a difference", "tilt": "an angle", "inclination": "an angle",
    "cmd": "a command", "command": "a command", "setpoint": "a command",
    "sp": "a command", "target": "a command", "desired": "a command", "demand": "a command",
}  # fmt: skip
FREE = words(
    "linear lineare lineaire linearen user free lin freeacc useracceleration linearacceleration "
    "lineal"
)
#: Words of angles, unless one of speed or of an increment stands beside them.
ANGLE = words("angle angles winkel angolo angulo kat uhel vinkel hoek")
#: Words of readings that a device has worked on: gravity or the bias taken out, sensors put
#: together.
WORKED_ON = FREE | words(
    "motion fused fusion fusedrotation rotationrate calibrated calib cal corrected compensated "
    "unbiased est estimated virtual filtered filt"
) - {"lin"}
ARRIVAL = words(
    "host arrival received receive recv rx system pc log logging server local bag rosbag wall "
    "write rostime"
)
OWN = words("header sensor device imu hw hardware")
#: Prefixes of maker's field descriptors (MIP data sets 0x80): what each holds.
DESCRIPTORS = {
    "8004": ("accel", "g"), "8005": ("gyro", "rad/s"), "8007": ("dtheta", "rad"), "8008": ("dv", "g*s"),
    "8006": (None, None), "8017": (None, None),
}  # fmt: skip
PARTS = {
    "year": "year", "yyyy": "year", "month": "month", "hour": "hour", "hours": "hour", "hh": "hour", "h": "hour", "hr": "hour", "hrs": "hour",
    "stunde": "hour",
}  # fmt: skip
FINE = {
    "nsec": "ns", "nsecs": "ns", "nanosec": "ns", "nanosecs": "ns", "nanoseconds": "ns", "nanos": "ns",
    "ns": "ns", "usec": "us", "usecs": "us", "microsec": "us", "microseconds": "us", "micros": "us",
    "us": "us", "msec": "ms", "msecs": "ms", "millis": "ms", "milliseconds": "ms", "ms": "ms",
    "millisecond": "ms", "microsecond": "us", "nanosecond": "ns",
    "sec": "s", "secs": "s", "seconds": "s", "second": "s", "s": "s", "tow": "s", "sod": "s", "sow": "s",
    "minutes": "min", "datenum": "day", "serialdate": "day", "jd": "day", "mjd": "day", "julian": "day",
    "juliandate": "day",
    "frac": "fraction", "fraction": "fraction", "fractional": "fraction", "subsec": "fraction", "subsecs": "fraction",
    "subsecond": "fraction", "subseconds": "fraction",
    "centiseconds": "cs", "centisecond": "cs", "hundredths": "cs", "csec": "cs",
}  # fmt: skip
COMPACT = re.compile(
    r"^(gyroscope|gyro|gyr|gy|g|w|omega|wb|rate|accelerometer|acceleration|accel|acc|ac|a|ag|f|sf|"
    r"fb|gf|gforce|dtheta|dt|da|dang|dv|dvel|mag|m|q|alpha|ang|rot)_?([xyz])$"
)
COMPACT_FRONT = re.compile(
    r"^([xyz])(gyro|gyr|gyroscope|rate|omega|accelerometer|acceleration|accel|acc|accl|mag|dtheta|"
    r"dang|dvel)$"
)
#: Poses: the vector and the quaternion of a trajectory.
POSE = re.compile(r"([tpq])[xyz]|(q)[w0-3]")
KIND_OF = {
    "ag": "accel", "ac": "accel", "gy": "gyro", "g": "gyro", "w": "gyro", "gyro": "gyro", "gyr": "gyro", "gyroscope": "gyro", "omega": "gyro",
    "wb": "gyro", "rate": "gyro", "ang": "gyro", "rot": "gyro", "a": "accel", "f": "accel", "sf": "accel", "fb": "accel",
    "gf": "accel", "gforce": "accel", "acc": "accel", "accl": "accel", "accel": "accel",
    "accelerometer": "accel", "acceleration": "accel", "alpha": "alpha", "dtheta": "dtheta",
    "dt": "dtheta", "da": "dtheta", "dang": "dtheta", "dv": "dv", "dvel": "dv",
}  # fmt: skip
SUFFIX = re.compile(
    r"_(meters?_pers2|m_pers2|meters?_per_s2|meters?_per_second_squared|rad_per_sec|rad_per_s|"
    r"rad_s|rads|radps|revps|rps|rad_sec|deg_per_sec|deg_per_s|degs|deg_s|degps|deg_sec|dps|mdps|"
    r"cdps|deg_per_hour|deg_per_hr|deg_per_h|degph|deg_hr|deg_h|dph|m_per_s2|mps2|m_s2|m_s_2|"
    r"m_s\^2|ms2|ms_2"
    r"|mss|mg|ug|g|counts?|lsb|raw|adc|sec|secs|msec|usec|nsec|ms|us|ns|s|min|degc|degf|deg_c|"
    r"deg_f|celsius|fahrenheit|kelvin|c|f|k)$"
)
SUFFIX_UNIT = {
    "rad_sec": "rad/s", "deg_sec": "deg/s", "rad_per_sec": "rad/s", "deg_per_sec": "deg/s", "degs": "deg/s", "m_s_2": "m/s^2", "m_s^2": "m/s^2", "ms_2": "m/s^2",
    "mss": "m/s^2", "meters_pers2": "m/s^2", "meters_per_s2": "m/s^2", "m_pers2": "m/s^2", "m_per_s2": "m/s^2", "rad_per_s": "rad/s", "deg_per_s": "deg/s",
}  # fmt: skip
#: Units of an increment behind its name, or before its axis.
SUMMED_UNIT = {
    "rad": "rad", "deg": "deg", "m_s": "m/s", "mps": "m/s", "m_per_s": "m/s", "g_s": "g*s",
}  # fmt: skip
SUMMED = re.compile(rf"(.+?)_({'|'.join(SUMMED_UNIT)})((?:_[xyz])?)")
REMARKS = words(
    "raw calibrated uncalibrated cal uncal imu utc local gps relative boot body sensor device "
    "filtered lp hp axis unix posix since start system host txt text string hex elapsed"
)


#: A sensor's own name in a heading, which says nothing of what is under it.
CHIP = re.compile(
    r"(?:imu|sensor|dev|device)\d*|(?:mpu|icm|iim|lsm|lis|l3g|ism|asm|bmi|bno|bma|bmg|adis|adxl|"
    r"mma|mma|itg|fxas|fxos|max|scc|sch|qmi|sh)\d[0-9a-z]*|mpu|icm|lsm|bmi|bno|adis"
)


def interval(tokens: list[str]) -> bool:
    """Whether a heading is that of the time from one sample to the next: dt, delta_t_us, dt_ms."""
    have = set(tokens) - set(FINE)
    since = {"since", "last"} <= have or {"since", "previous"} <= have
    return (
        have
        in (
            {"dt"},
            {"delta", "t"},
            {"delta", "time"},
            {"time", "delta"},
            {"deltat"},
            {"deltatime"},
            {"dtime"},
            {"sample", "interval"},
            {"interval"},
        )
        or have == {"delta"}
        and len(tokens) == 2
        or since
        and bool(have & TIME)
    )


def fine(tokens: list[str]) -> str | None:
    """The unit of time that the last such word of a heading says."""
    return next((FINE[t] for t in reversed(tokens) if t in FINE), None)
