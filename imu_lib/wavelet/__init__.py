"""Wavelet de-noising of inertial signals: what it removes, at which level to stop, and with or
without the future.

The discrete wavelet transform splits a signal sampled at `fs` into details D_j, nominally between
fs / 2^(j+1) and fs / 2^j, and an approximation A_J below fs / 2^(J+1) (Figs. 7 and 8 of Quinchia
et al. 2013). De-noising shrinks the details and leaves the approximation alone. The 2013 paper
uses Daubechies 4, soft thresholds by Stein's unbiased risk estimate (SURE), and three to eight
levels.

* `denoise`: whole record (every output sample uses the future), or causal (sliding or block);
* `thresholds`, `bands`, `band_variance`, `gain`, `span`: what a level does, in numbers;
* `level_for_band`, `choose_level`: where to stop, from the band of the vehicle's motion;
* `edge_response`: the price of having no future.
"""

from imu_lib.wavelet.bands import (
    Band,
    LevelChoice,
    band_variance,
    bands,
    choose_level,
    gain,
    level_for_band,
    span,
)
from imu_lib.wavelet.causal import EdgeResponse, edge_response
from imu_lib.wavelet.denoising import Thresholds, denoise, thresholds

__all__ = [
    "Band",
    "EdgeResponse",
    "LevelChoice",
    "Thresholds",
    "band_variance",
    "bands",
    "choose_level",
    "denoise",
    "edge_response",
    "gain",
    "level_for_band",
    "span",
    "thresholds",
]
