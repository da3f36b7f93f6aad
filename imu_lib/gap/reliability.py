"""How sure a name is: from its likelihood where there is one, else as often as it was right."""

from __future__ import annotations

import numpy as np
from scipy.special import expit, logit

#: Findings without a likelihood, not counting those with a doubt of their own: how many there were
#: in the blind scores, and how many of them were right. Counted from benchmarks/results/gap_score,
#: gap_score_free and gap_score_pairs (2,280 cases); tests/test_gap_confidence.py counts again.
DETECTED = {
    "stuck": (76, 76),
    "saturation": (70, 70),
    "resolution": (66, 66),
    "quantization": (76, 75),
    "time_gaps": (82, 82),
    "jitter": (86, 86),
}


def share(effect: str) -> float:
    """Expected share of right names among further findings of that effect (Laplace's rule of
    succession); 1/2 where none were counted.
    """
    found, right = DETECTED.get(effect, (0, 0))
    return (right + 1) / (found + 2)


#: Logistic regression of right names on the logit of a name's weight among its rivals: 832 findings
#: of the blind scores beside which nothing was left unexplained (benchmarks/gap_reliability.py). A
#: winner of little weight is right more often than its weight says, one of much weight less often.
OFFSET, SLOPE = 0.75, 0.61


def calibrated(weight: float) -> float:
    """Share of right names among winners of that weight."""
    weight = min(max(weight, 1e-9), 1.0 - 1e-9)
    return float(expit(OFFSET + SLOPE * logit(weight)))


def weight(sure: float) -> float:
    """The weight among its rivals of a winner of that confidence."""
    sure = min(max(sure, 1e-9), 1.0 - 1e-9)
    return float(expit((logit(sure) - OFFSET) / SLOPE))


#: Confidence from which on no rival is listed.
PLAIN = 0.95


def odds(gain: float, places: float) -> float:
    """Confidence in the largest of the gains in log-likelihood that were looked at in `places`
    independent places.

    Noise alone exceeds it with a probability of about places exp(-gain); that against the effect
    itself, at even odds before the record is seen. Of a line the places are what its free amplitude
    and phase cost, too (`effects.sinusoid.occam`).
    """
    return float(1.0 / (1.0 + places * np.exp(-min(gain, 500.0))))
