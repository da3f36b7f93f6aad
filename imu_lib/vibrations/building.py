"""Bands that accelerometers show at one place without moving together: a building or a table sways
in two directions, each driven for itself.
"""

from __future__ import annotations

from dataclasses import replace

from imu_lib.vibrations.sources import Source

#: Hz below which two accelerometers show the modes of what they stand on, and power of such a band
#: over the noise.
SLOW_MODES, STRONG = 40.0, 2.0


def apart(s: Source) -> list[Source]:
    """A band that accelerometers show at one place without moving together, as a building sways in
    two directions: a source for each of them.
    """
    if s.coherent or len(s.channels) < 2 or not _sways(s):
        return [s]
    return [replace(s, amplitude={c: s.amplitude[c]}, sd={c: s.sd[c]}) for c in s.channels]


def _sways(s: Source) -> bool:
    """Whether a band is at the place and on the channels of what a building or a table does."""
    kinds = {c.split("_")[0] for c in s.channels}
    return kinds == {"accel"} and s.frequency < SLOW_MODES and s.strength > STRONG


def of_building(family: list[Source]) -> bool:
    """Whether it is one direction of what was parted so."""
    s = family[0]
    return len(family) == 1 == len(s.channels) and not s.coherent and _sways(s)
