"""One likelihood of the whole model on the whole record.

The record goes through one cosine transform, which leaves its mean out and makes the noises of an
error model (nearly) independent: `Statistics.of(x, fs)` keeps some 450 numbers of seven hours.
`log_likelihood(stats, model)` is then a sum over 450 terms, `fit(x, fs, template)` its maximum with
profile intervals, and `choose(x, fs)` compares candidate sums. Equations: `statistics`, `kernel`
and `evaluate`.
"""

from .choose import CANDIDATES, Choice, FastEnd, choose, fast_end
from .evaluate import density, goodness, log_likelihood, residuals
from .fit import Fit, fit
from .flat import flat_level
from .regressors import Regressors
from .scales import of_scales
from .statistics import Statistics

__all__ = [
    "CANDIDATES",
    "Choice",
    "FastEnd",
    "Fit",
    "Regressors",
    "Statistics",
    "choose",
    "density",
    "fast_end",
    "fit",
    "flat_level",
    "goodness",
    "log_likelihood",
    "of_scales",
    "residuals",
]
