"""What the health of a record consists of."""

from __future__ import annotations

from dataclasses import asdict, dataclass, fields

from imu_lib.faults import Finding


@dataclass(frozen=True)
class Clock:
    """The time stamps.

    jitter: standard deviation of a stamp about the even grid, s (None without stamps). bursts:
    whether a host stamped the samples in bursts. gaps: (start s, duration s, missing samples),
    longest first.
    """

    samples: int
    rate: float
    duration: float
    stamped: bool
    jitter: float | None
    bursts: bool
    repeats: int
    gaps: tuple[tuple[float, float, int], ...]
    gap_count: int
    missing: int


@dataclass(frozen=True)
class Channel:
    """One channel, SI, samples that are no measurements left out.

    resolution: step of the output grid, None where none shows. saturated: samples at an end of the
    range where they pile up. frozen: samples in runs of one value longer than chance allows;
    longest_run in samples. noise: white-noise coefficient from neighbours' differences.
    """

    mean: float
    sd: float
    low: float
    high: float
    nan: int
    resolution: float | None
    saturated: int
    frozen: int
    longest_run: int
    noise: float


@dataclass(frozen=True)
class Motion:
    """state: `at rest`, `touched` (knocks), `moved` (it was tilted), `partly moving` or `moving`.

    moving_share, shaking_share: of the seconds. rest_start, rest_stop: the longest sound stretch,
    s. gravity: median length of the specific force, m/s^2, None where it shows none.
    """

    state: str
    moving_share: float
    shaking_share: float
    rest_start: float
    rest_stop: float
    gravity: float | None


@dataclass(frozen=True)
class Health:
    """What `check` says.

    faults: what was found in the data and happened to the sensor. gnss: of a drive. findings:
    sentences on what deserves attention; none for a sound record.
    """

    name: str
    source: str
    clock: Clock
    channels: dict[str, Channel]
    motion: Motion
    temperature: dict | None
    gnss: dict | None
    notes: tuple[str, ...]
    findings: tuple[str, ...]
    faults: tuple[Finding, ...] = ()

    def to_json(self) -> dict:
        """All of it; the faults without the rows that they touch."""
        out = {}
        for f in fields(self):
            value = getattr(self, f.name)
            if f.name == "faults":
                value = [item.to_json() for item in value]
            elif f.name == "channels":
                value = {c: asdict(x) for c, x in value.items()}
            elif f.name in ("clock", "motion"):
                value = asdict(value)
            out[f.name] = value
        out["sound"] = {"start": self.motion.rest_start, "stop": self.motion.rest_stop}
        return out
