"""Pictures of first passages: what is drawn are the numbers of the results."""

from __future__ import annotations

import numpy as np
import pytest

import springpot as sp
from springpot import figures

SYSTEM = sp.Oscillator(springpot=sp.Springpot(0.5, 0.3), barrier=None, excitation=sp.WhiteNoise(0.4))
LEVELS = [2.0, 3.0, 9.0]


@pytest.fixture(scope="module")
def passages() -> sp.simulation.PassagesOfLevels:  # type: ignore[name-defined]
    run = sp.simulate(SYSTEM, paths=256, duration=80.0, step=0.05, start="rest", first_passage={"x": LEVELS})
    return run.first_passages["x"]


def test_probabilities_go_on_beyond_the_run(passages) -> None:
    axes = figures.plot_passage_probability(passages, until=800.0)
    within, beyond = axes.get_lines()[:2]
    for line, style in ((within, "-"), (beyond, "--")):
        assert line.get_linestyle() == style
        time, value = line.get_xdata()[-1], line.get_ydata()[-1]
        assert value == passages[0].probability(time).value
    assert within.get_xdata()[-1] <= 80.0 < beyond.get_xdata()[0]
    unseen = axes.get_lines()[4]
    assert (unseen.get_linestyle(), unseen.get_label()) == (":", "x through 9 m, at most")
    assert np.all(unseen.get_ydata() == passages[2].probability(40.0).high)
    assert axes.get_lines()[-2].get_xdata() == [80.0, 80.0]
    assert len(figures.plot_passage_probability(passages[0]).get_lines()) == 2


def test_return_periods_of_runs_and_formulas_are_beside_each_other(passages) -> None:
    axes = figures.plot_return_periods(passages)
    bars = axes.containers[0]
    np.testing.assert_array_equal(bars[0].get_ydata(), [each.return_period.value for each in passages[:2]])
    low, high = np.array(bars[2][0].get_segments())[:, :, 1].T
    np.testing.assert_allclose(low, [each.return_period.low for each in passages[:2]])
    np.testing.assert_allclose(high, [each.return_period.high for each in passages[:2]])
    found = sp.theory.exceedance(SYSTEM, {"x": LEVELS})["x"]
    figures.plot_return_periods(found, axes)
    lines = {line.get_label(): line for line in axes.get_lines()}
    assert lines["no passage: at least, 95 %"].get_ydata() == [passages[2].return_period.low]
    np.testing.assert_array_equal(lines["Vanmarcke"].get_ydata(), found.return_period["vanmarcke"])
    curve = sp.exceedance(sp.Oscillator(), {"x": [2.5]}, duration=30.0, step=0.05, start="rest", rtol=0.5)["x"]
    figures.plot_return_periods(curve, axes)
    assert axes.get_lines()[-1].get_label() == f"{curve.method}, 95 %"
    assert axes.get_lines()[-1].get_ydata() == curve.return_period
    band = axes.collections[-1].get_paths()[0].vertices[:, 1]
    np.testing.assert_allclose([band.min(), band.max()], np.ravel(curve.return_interval))


def test_other_things_are_refused(passages) -> None:
    with pytest.raises(TypeError, match="passages must be those of a run"):
        figures.plot_passage_probability(passages[0].times)
    with pytest.raises(ValueError, match="until must be"):
        figures.plot_passage_probability(passages, until=-1.0)
    with pytest.raises(TypeError, match="data must be first passages of a run"):
        figures.plot_return_periods([1.0])
