"""One test of what is left."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Check:
    """One test: the domain, log10 of its p-value (already corrected for the places it looked at),
    where it disagrees, and how large the disagreement is in units of what matters to those who use
    the model (`inf` where no such size is known: it matters whatever it is).
    """

    domain: str
    log_p: float
    where: str
    size: float = float("inf")
