"""Words of the sentences about a record."""

from __future__ import annotations

from collections.abc import Iterable, Sequence


def seconds(x: float) -> str:
    """A time with its unit."""
    if x < 120:
        return f"{x:.3g} s"
    return f"{x / 60:.3g} min" if x < 7200 else f"{x / 3600:.3g} h"


def number(n: int, noun: str) -> str:
    """1 sensor, 2 sensors."""
    return f"{n:,} {noun}{'s' * (n != 1)}"


def listed(parts: list[str]) -> str:
    """a, b and c."""
    return parts[0] if len(parts) == 1 else f"{', '.join(parts[:-1])} and {parts[-1]}"


def sentence(parts: list[str]) -> str:
    """Clauses as one sentence."""
    text = "; ".join(parts)
    return text[:1].upper() + text[1:]


def names(channels: Iterable[str]) -> str:
    """Channels as a list."""
    return listed(list(channels))


def channels(some: Sequence[str]) -> str:
    """The channels of a finding on the record."""
    return "all channels" if len(some) == 6 else names(some)


def spread(values: list[float]) -> str:
    """Smallest to largest, one figure where they are alike."""
    low, high = min(values), max(values)
    return f"{low:.3g}" if high < 1.1 * low else f"{low:.3g} to {high:.3g}"
