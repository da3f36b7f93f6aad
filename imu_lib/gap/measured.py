"""How sure a name is: from its likelihood where there is one, else as often as it was right."""

from __future__ import annotations

import numpy as np

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


def odds(gain: float, places: float) -> float:
    """Confidence in the largest of the gains in log-likelihood that were looked at in `places`
    independent places.

    Noise alone exceeds it with a probability of about places exp(-gain) (Rice 1944 for a line
    among frequencies); that against the effect itself, at even odds before the record is seen.
    """
    return float(1.0 / (1.0 + places * np.exp(-min(gain, 500.0))))
