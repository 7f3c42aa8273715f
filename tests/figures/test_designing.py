"""Pictures of designs and sensitivities show the numbers of the results."""

from __future__ import annotations

import numpy as np
import pytest

import springpot as sp
from springpot.designing import Curve
from springpot.figures import plot_design_curve, plot_sensitivities


def test_a_curve_is_grey_where_the_limit_cannot_hold() -> None:
    costs = np.array([np.nan, np.nan, 3.0, 2.0])
    curve = Curve("impact_rate", "c", "s-1", "", True, np.array([0.1, 0.2, 0.3, 0.4]), costs, ({},) * 4)
    axes = plot_design_curve(curve)
    (line,) = axes.lines
    np.testing.assert_array_equal(line.get_ydata(), costs)
    (grey,) = axes.patches
    assert grey.get_extents().transformed(axes.transData.inverted()).x1 == pytest.approx(0.3)
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("limit of impact rate (s$^{-1}$)", "c")
    lower = Curve("x_mean", "c", "m", "", False, np.array([0.1, 0.2, 0.3, 0.4]), costs[::-1], ({},) * 4)
    (grey,) = plot_design_curve(lower).patches
    assert grey.get_extents().transformed(axes.transData.inverted()).x0 >= 0.2


@pytest.mark.validation  # every day: the axes of a made-up curve, and the examples of the two
def test_the_axis_of_a_free_number_has_its_unit() -> None:
    damper = sp.Dashpot(sp.free("c", 0.5, (0.05, 5.0)))
    device = sp.System(sp.Mass(1.0), sp.Spring(4.0), damper, sp.Barrier(-1.0), sp.WhiteNoise(1.0))
    found = sp.design(device, minimize="c", subject_to={"impact_rate": (None, 0.2)}, rtol=0.1)
    assert found.units["c"] == "N s m-1"
    assert plot_design_curve(found.curve(limits=[0.1, 0.2])).get_ylabel() == "c (N s m$^{-1}$)"


def test_bars_are_sensitivities_with_their_intervals() -> None:
    linear = sp.Oscillator(2.0, sp.Springpot(1.0, 0.4), None, sp.WhiteNoise(3.0))
    names = ["x_mean_square", "v_mean_square"]
    by_theory = sp.sensitivity(linear, names, method="theory")
    by_chance = sp.sensitivity(linear, names, method="monte_carlo", paths=64, duration=10.0)
    figure = plot_sensitivities(by_theory, by_chance)
    for axes, name in zip(figure.axes, names, strict=True):
        shown = [bar.get_width() for bars in axes.containers[:1] for bar in bars.patches]
        assert shown == pytest.approx([by_theory.values[name][number] for number in by_theory.numbers], nan_ok=True)
        assert len(axes.collections) == 1  # intervals of Monte Carlo alone
    assert [text.get_text() for text in figure.legends[0].texts] == ["exact", "Monte Carlo, 64 paths, 95 %"]


def test_nothing_to_draw_is_one_sentence() -> None:
    linear = sp.System(sp.Spring(9.0), sp.Dashpot(0.3), sp.WhiteNoise(1.0))
    with pytest.raises(ValueError, match="found must be at least one"):
        plot_sensitivities()
    with pytest.raises(ValueError, match="found must have a quantity in common"):
        plot_sensitivities(sp.sensitivity(linear, "x_mean_square"), sp.sensitivity(linear, "v_mean_square"))
