"""Tables of the chapters: coefficients side by side, stored studies, and how a table is shown."""

from imu_lib.tables.coefficients import (
    USUAL,
    autoregressive_models,
    coefficients,
    flat_parts,
    gauss_markov,
    held,
    values_of,
)
from imu_lib.tables.compared import Comparison, compare, flat
from imu_lib.tables.shown import Shown, show
from imu_lib.tables.studies import (
    calibration_coverage,
    coverage,
    coverage_by_channel,
    level_errors,
    medians,
    outage_errors,
    paper_outages,
    repeatability,
    stored,
)

__all__ = [
    "USUAL",
    "Comparison",
    "Shown",
    "autoregressive_models",
    "calibration_coverage",
    "coefficients",
    "compare",
    "coverage",
    "coverage_by_channel",
    "flat",
    "flat_parts",
    "gauss_markov",
    "held",
    "level_errors",
    "medians",
    "outage_errors",
    "paper_outages",
    "repeatability",
    "show",
    "stored",
    "values_of",
]
