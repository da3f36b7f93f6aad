"""Figures that zoom hold what the drawn ones hold, in the unit of their axes, the same bytes each
time.
"""

import json

import matplotlib
import numpy as np
import pytest

from imu_lib import allan, plots, units
from imu_lib.plots.interactive import Explorable, _range, described
from imu_lib.plots.traces import POINTS
from imu_lib.processes import RandomWalk, WhiteNoise

matplotlib.use("Agg")
NOISE = WhiteNoise(N=1e-4) + RandomWalk(K=1e-6)


@pytest.fixture(scope="module")
def curve():
    return allan.deviation(NOISE.simulate(20_000, 50.0, np.random.default_rng(1)), 50.0)


def drawn(ax):
    figure = described(ax.figure)
    matplotlib.pyplot.close(ax.figure)
    return figure


def test_an_end_of_an_axis_beside_zero_has_no_digits_beyond_the_others():
    # 1.04961 and 1.04962, of two processors: the logarithm's last digits were those of rounding
    assert _range(0.0210324, 2.2328, True) == _range(0.0210348, 2.2328, True) == [0.021, 2.2328]
    assert _range(-0.0123412, 99.0, False) == _range(-0.0123467, 99.0, False) == [-0.012, 99.0]
    assert _range(-1.0, 1.0, False) == [-1.0, 1.0] and _range(2.0, 2.0, False) == [2.0, 2.0]


def test_values_are_those_of_the_curve_in_datasheet_units(curve):
    figure = drawn(plots.allan(curve, NOISE, channel="gyro_x"))
    record = next(t for t in figure["data"] if t["name"] == "record")
    assert np.allclose(record["x"], curve.tau, rtol=5e-4)
    assert np.allclose(record["y"], curve.adev / units.DEG_PER_HOUR, rtol=5e-4)  # four digits
    assert figure["layout"]["yaxis"]["title"]["text"] == "Allan deviation, deg/h"
    factor, unit = figure["si"]["yaxis"]
    assert unit == "rad/s" and np.allclose(np.multiply(record["y"], factor), curve.adev, rtol=5e-4)
    assert figure["layout"]["xaxis"]["type"] == figure["layout"]["yaxis"]["type"] == "log"
    band = next(t for t in figure["data"] if t.get("fill") == "toself")
    assert band["hoverinfo"] == "skip" and min(band["y"]) > 0


def test_two_runs_give_the_same_bytes(curve):
    texts = [json.dumps(drawn(plots.allan(curve, channel="accel_z"))) for _ in range(2)]
    assert texts[0] == texts[1]


def test_panels_keep_their_places(curve):
    axes = plots.allan_panels(
        dict.fromkeys(("gyro_x", "gyro_y"), curve),
        dict.fromkeys(("gyro_x", "gyro_y"), allan.read_off(curve)),
    )
    figure = drawn(axes[0, 0])
    left, right = (figure["layout"][key]["domain"] for key in ("xaxis", "xaxis2"))
    assert left[1] < right[0] and {t["xaxis"] for t in figure["data"]} == {"x", "x2"}
    named = [t["name"] for t in figure["data"] if t["showlegend"]]
    assert len(named) == len(set(named))  # a curve stands in the legend once


def test_a_long_line_is_thinned_and_keeps_its_extremes():
    ax = plots.grid()[0, 0]
    y = np.sin(np.arange(50_000.0))
    y[31_234] = 7.0
    ax.plot(np.arange(50_000.0), y)
    (trace,) = drawn(ax)["data"]
    assert len(trace["x"]) <= POINTS and max(trace["y"]) == 7.0


def test_what_ends_a_script_is_escaped():
    ax = plots.grid()[0, 0]
    ax.plot([1, 2], [1, 2], label="</script>")
    text = Explorable(drawn(ax))._repr_html_()
    assert text.count("</script>") == 1 and text.endswith("</script>")
