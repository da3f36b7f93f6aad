"""One test of what is left."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Check:
    """One test: the domain, log10 of its p-value (already corrected for the places it looked at),
    where it disagrees.
    """

    domain: str
    log_p: float
    where: str
