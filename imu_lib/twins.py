"""The embedded records: digital twins drawn from the presets with a fixed seed."""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass

import numpy as np

from imu_lib import units
from imu_lib.errors import InputError
from imu_lib.presets import preset
from imu_lib.record import Record


@dataclass(frozen=True)
class Twin:
    """How an embedded record is drawn: which preset, how long (h), at what rate (Hz), from which
    seed.
    """

    preset: str
    hours: float
    rate: float
    seed: int
    about: str


TWINS = {
    "3dm-gx3-25": Twin(
        "3dm-gx3-25",
        7.0,
        100.0,
        20130724,
        "seven hours of the 3DM-GX3-25 as the 2013 paper measured it",
    ),
    "isis-imu": Twin("isis-imu", 2.0, 100.0, 2011, "two hours of the ISIS-IMU of the 2011 paper"),
    "rga300ca": Twin("rga300ca", 8.0, 20.0, 2008, "eight hours of the RGA300CA of the 2008 paper"),
}

#: Raised when the generation itself changes, so that no stale draw is served.
GENERATION = 1


def twin_of(name: str) -> Twin:
    """The entry of that name; raises InputError if there is none."""
    if name not in TWINS:
        raise InputError(f"unknown embedded record {name!r}; there are {', '.join(TWINS)}")
    return TWINS[name]


def fingerprint(name: str) -> str:
    """Hash of everything the draw depends on, hexadecimal."""
    twin = twin_of(name)
    content = json.dumps(
        [GENERATION, twin.hours, twin.rate, twin.seed, preset(twin.preset).to_json()],
        sort_keys=True,
    )
    return hashlib.sha256(content.encode()).hexdigest()


def generate(name: str) -> Record:
    """Draw the embedded record of that name (seconds of work; `datasets.twin` caches it)."""
    twin = twin_of(name)
    n = round(twin.hours * units.HOUR * twin.rate)
    return preset(twin.preset).simulate_record(
        n, twin.rate, np.random.default_rng(twin.seed), name=name
    )
