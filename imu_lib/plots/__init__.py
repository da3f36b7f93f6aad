"""Figures: functions of the results, one file per subject; the only room that imports matplotlib.

A chapter does `from imu_lib import plots` and calls `plots.NAME(result)`; each function takes
`ax=None` and returns the axes. To add one, write it in a file of this folder and list it here.
"""

import sys
from importlib import import_module
from types import ModuleType

# function -> file; imported when first asked for
_HOME = {
    "apply": "style",
    "grid": "style",
    "headless": "style",
    "interactive": "interactive",
    "save": "style",
    "unstable_response": "errata",
    "outage_ratios": "errata",
    "recorded": "recorded",
    "recorded_curves": "recorded",
    "record_signals": "record",
    "record_lateness": "record",
    "record_levels": "record",
    "rest_windows": "calibration",
    "pose_magnitudes": "calibration",
    "panel_readings": "calibration",
    "rate_table": "calibration",
    "line_residuals": "calibration",
    "repeatability": "calibration",
    "repeatability_panels": "calibration",
    "triad_intervals": "calibration",
    "fitted_spectrum": "likelihood",
    "fit_residuals": "likelihood",
    "candidates": "likelihood",
    "intervals": "likelihood",
    "characterised_allan": "likelihood",
    "characterised_spectrum": "likelihood",
    "models_allan": "likelihood",
    "spectral_lines": "likelihood",
    "coverage": "likelihood",
    "planar_tracks": "update_interval",
    "planar_errors": "update_interval",
    "rms_by_interval": "update_interval",
    "paired_ratios": "update_interval",
    "level_curves": "wavelet_level",
    "band_energy": "wavelet_level",
    "denoised_detail": "wavelet_level",
    "outage_map": "outages",
    "outage_maps": "outages",
    "outage_details": "outages",
    "outage_errors_2013": "outages",
    "outage_tracks": "outages",
    "outage_growth": "outages",
    "outage_fan": "outages",
    "outage_errors": "outages",
    "outage_distributions": "outages",
    "solution_errors": "navigation",
    "nees_over_time": "navigation",
    "free_inertial": "navigation",
    "paired_intervals": "navigation",
    "autocorrelations": "autocorrelation",
    "before_and_after": "autocorrelation",
    "gauss_markov_fit": "autocorrelation",
    "record_length": "autocorrelation",
    "residual_variance": "autoregressive",
    "order_criteria": "autoregressive",
    "order_by_length": "autoregressive",
    "residual_autocorrelation": "autoregressive",
    "poles": "autoregressive",
    "wavelet_bands": "wavelet",
    "thresholds": "wavelet",
    "denoised_allan": "wavelet",
    "denoised_series": "wavelet",
    "edge_error": "wavelet",
    "coefficient_comparison": "wavelet",
    "process_portrait": "processes",
    "allan_family": "processes",
    "allan": "allan",
    "allan_curves": "allan",
    "allan_lines": "allan",
    "allan_panels": "allan",
    "allan_terms": "allan",
    "allan_errors": "allan",
    "allan_deviations": "allan",
    "coefficients": "allan",
    "papers_error_map": "allan",
    "fleet_dates": "fleet",
    "fleet_days": "fleet",
    "fleet_shares": "fleet",
    "fleet_spread": "fleet",
    "spectrum": "spectrum",
    "spectra": "spectrum",
    "spectrum_lines": "spectrum",
    "spectrum_terms": "spectrum",
    "roll_off": "spectrum",
    "drive_gap_map": "drive_gap",
    "drive_gap_innovations": "drive_gap",
    "drive_gap_outages": "drive_gap_recorded",
    "promised": "drive_gap_recorded",
    "drive_gap_hidden": "drive_gap_recorded",
}
__all__ = sorted(_HOME)


def __getattr__(name):
    if name not in _HOME:
        raise AttributeError(
            f"module `imu_lib.plots` has no function `{name}`; it has {', '.join(__all__)}"
        )
    value = getattr(import_module(f"imu_lib.plots.{_HOME[name]}"), name)
    globals()[name] = value
    return value


def __dir__():
    return sorted({*globals(), *_HOME})


class _Plots(ModuleType):
    """Lets a file and a function bear the same name: `plots.allan` stays the function once
    allan.py is imported.
    """

    def __setattr__(self, name, value):
        if isinstance(value, ModuleType) and _HOME.get(name) == name:
            value = getattr(value, name)
        super().__setattr__(name, value)


sys.modules[__name__].__class__ = _Plots
