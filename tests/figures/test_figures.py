"""Pictures: what is drawn is what was given, on the axes that were given, with units, and pyplot is left alone."""

from __future__ import annotations

import inspect
import os
import re
import sys
from collections.abc import Callable
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import springpot as sp
from springpot import figures
from springpot.memory import power_law_sum
from springpot.problem.dimensionless import Dimensionless
from springpot.simulation import Run
from tests.simulation.problems import oscillator
from tests.sizes import validation

if TYPE_CHECKING:
    from matplotlib.axes import Axes

FREQUENCIES = np.linspace(0.5, 2.4, 12)


@cache
def recorded() -> Run:
    """Every path recorded from rest, so that averages of the run can be told from its record."""
    return sp.simulate(
        oscillator(1.0, 0.3, restitution=0.9),
        paths=64,
        record=64,
        duration=40.0,
        step=0.01,
        window=(0.0, 40.0),
        start="rest",
    )


@cache
def adapted() -> Run:
    return sp.simulate(oscillator(1.0, 0.3), paths=64, record=8, duration=1.0, step=0.02)


@cache
def counted() -> Run:
    return sp.simulate(
        oscillator(1.0, 0.5),
        paths=640,
        duration=60.0,
        step=0.02,
        distributions=True,
        spectrum=FREQUENCIES,
        start="rest",
    )


@cache
def exact() -> Any:
    return sp.theory.exact(oscillator(1.0, 0.5))


DRAWN: dict[str, Callable[[Axes | None], Axes]] = {
    "path": lambda axes: figures.plot_path(recorded(), axes),
    "velocity": lambda axes: figures.plot_path(recorded(), axes, quantity="v", member=3, window=(5.0, 15.0)),
    "phase_portrait": lambda axes: figures.plot_phase_portrait(recorded(), axes),
    "density": lambda axes: figures.plot_density(counted(), "x", axes, theory=exact()),
    "spectrum": lambda axes: figures.plot_spectrum(
        counted(), axes, theory=sp.theory.memory_closure(oscillator(1.0, 0.5))
    ),
    "correlation": lambda axes: figures.plot_correlation(recorded(), axes, at=[0.0, 1.0], theory=exact()),
    "transient": lambda axes: figures.plot_transient(recorded(), ax=axes, theory=exact(), at=[0.0, 1.0]),
    "survival": lambda axes: figures.plot_survival(
        recorded(), 1.5, axes, theory=sp.theory.envelope(oscillator(1.0, 0.3))
    ),
    "against": lambda axes: figures.plot_against(
        "order", axes, system=oscillator(), values=[0.5, 1.0], theory=[sp.theory.averaging], runs=[counted()]
    ),
    "convergence": lambda axes: figures.plot_convergence({"one": ([0.1, 0.2], [0.01, 0.02])}, axes, ylabel="error (m)"),
    "fourier_series": lambda axes: figures.plot_fourier_series(axes),
    "fourier_error": lambda axes: figures.plot_fourier_error(axes),
    "memory_terms": lambda axes: figures.plot_memory_terms(0.5, axes, tolerance=1e-2),
    "memory_error": lambda axes: figures.plot_memory_error(0.5, axes, tolerances=[1e-2, 1e-3]),
    "gaps": lambda axes: figures.plot_gaps("envelope", ax=axes),
}
UNIT = re.compile(r"\((1|m|s|rad|m/s|1/m|s/m|1/s|rad/s|m\$\^2\$|m\$\^2\$ s/rad|s\$.*\$|any unit|.*s\$\^.*)\)")


def marks(axes: Axes) -> tuple[np.ndarray[Any, Any], np.ndarray[Any, Any], np.ndarray[Any, Any]]:
    """Places, values and half-lengths of the bars of the first error bars on the axes."""
    (points, _, (stems,)) = axes.containers[0]
    ends = np.array([segment[:, 1] for segment in stems.get_segments()])
    return points.get_xdata(), points.get_ydata(), (ends[:, 1] - ends[:, 0]) / 2.0


@pytest.mark.parametrize("name", list(DRAWN))
def test_a_picture_is_drawn_where_it_should_be_and_has_units(name: str) -> None:
    from matplotlib.figure import Figure

    given = Figure().subplots()
    assert DRAWN[name](given) is given
    own = DRAWN[name](None)
    assert own is not given
    assert isinstance(own.figure, Figure)
    for label in (given.get_xlabel(), given.get_ylabel()):
        assert UNIT.search(label) or label.startswith(("probability", "error (m)")), label
    given.figure.savefig(os.devnull, format="png")  # type: ignore[union-attr]


def test_pyplot_is_left_alone() -> None:
    """No figure of any window, whatever was drawn before."""
    pyplot = sys.modules.get("matplotlib.pyplot")
    before = [] if pyplot is None else pyplot.get_fignums()
    for draw in DRAWN.values():
        draw(None)
    pyplot = sys.modules.get("matplotlib.pyplot")
    assert (pyplot is None and before == []) or pyplot.get_fignums() == before


def test_a_path_is_the_recorded_one() -> None:
    run = recorded()
    x = figures.plot_path(run, member=2).lines[0]
    assert np.array_equal(x.get_xdata(), run.time)
    assert np.array_equal(x.get_ydata(), run.record[2, :, 0])
    v = figures.plot_path(run, quantity="v", member=2).lines[0].get_ydata()
    assert np.array_equal(v[np.isfinite(v)], run.record[2, :, 1])
    inside = figures.plot_path(run, window=(5.0, 6.0)).lines[0].get_xdata()
    assert (inside.min(), inside.max()) == (pytest.approx(5.0), pytest.approx(6.0))


@pytest.mark.parametrize(("position", "side"), [validation(0.0, "above"), validation(-0.3, "above"), (0.4, "below")])
def test_the_impacts_marked_are_those_of_the_run(position: float, side: str) -> None:
    """All paths recorded: as many marks as impacts were counted, but for those that share a step or graze."""
    problem = oscillator(0.5, 0.3, position=position, free_side=side)
    paths, away = 24, 1.0 if side == "above" else -1.0
    run = sp.simulate(
        problem, paths=paths, record=paths, duration=40.0, step=0.005, window=(0.0, 40.0),
        initial_position=0.8 * away,
    )  # fmt: skip
    found, places = 0, []
    for member in range(paths):
        axes = figures.plot_path(run, member=member)
        found += axes.lines[-1].get_xdata().size
        places.append(axes.lines[-1].get_ydata())
    counted = run["impact_rate"].value * 40.0 * paths
    assert abs(found / counted - 1.0) < 0.02
    assert np.all(np.concatenate(places) == position)
    plane = figures.plot_phase_portrait(run, member=5)
    assert plane.lines[-1].get_xdata().size == figures.plot_path(run, member=5).lines[-1].get_xdata().size
    assert np.all(away * plane.lines[-1].get_ydata() < 0.0)  # the velocity before the impact


@pytest.mark.parametrize("quantity", ["x", "v", "amplitude", "impact_speed"])
def test_a_density_has_the_counts_and_the_curve(quantity: str) -> None:
    run = counted()
    axes = figures.plot_density(run, quantity, theory=exact())
    edges, density, error = run.distributions[quantity].density()
    place, value, half = marks(axes)
    assert np.array_equal(place, 0.5 * (edges[1:] + edges[:-1]))
    assert np.array_equal(value, density)
    assert half == pytest.approx(1.96 * error)
    curve = axes.lines[-1]
    assert np.array_equal(curve.get_ydata(), getattr(exact(), f"{quantity}_density")(curve.get_xdata()))
    given = figures.plot_density(None, quantity, theory=exact(), at=[0.5]).lines[0]
    assert given.get_ydata() == pytest.approx([float(getattr(exact(), f"{quantity}_density")(0.5))])


def test_a_spectrum_has_the_sums_and_the_curve() -> None:
    run, closure = counted(), sp.theory.memory_closure(oscillator(1.0, 0.5))
    axes = figures.plot_spectrum(run, theory=[closure, exact()])  # exact has none behind a wall
    place, value, half = marks(axes)
    assert np.array_equal(place, FREQUENCIES)
    assert np.array_equal(value, run.spectra["x"].density)
    assert half == pytest.approx(1.96 * run.spectra["x"].standard_error)
    assert np.array_equal(axes.lines[-1].get_ydata(), closure.spectrum(FREQUENCIES))
    assert [text for text in axes.get_legend_handles_labels()[1] if "Monte" not in text] == ["memory closure"]


def test_a_dataset_is_as_good_as_a_run() -> None:
    from_run, from_dataset = (figures.plot_density(data) for data in (counted(), counted().to_xarray()))
    assert np.array_equal(marks(from_run)[1], marks(from_dataset)[1])


def test_a_correlation_is_that_of_the_record() -> None:
    run = recorded()
    x = run.record[:, 1000:, 0]
    _, value, half = marks(figures.plot_correlation(run, at=[0.0, 0.5], since=10.0))
    products = np.stack([(x * x).mean(axis=1), (x[:, :-50] * x[:, 50:]).mean(axis=1)])
    assert value == pytest.approx(products.mean(axis=1))
    assert half == pytest.approx(1.96 * products.std(axis=1, ddof=1) / 8.0)


def test_a_transient_is_the_mean_over_the_record() -> None:
    run = recorded()
    place, value, half = marks(figures.plot_transient(run, "v_mean_square"))
    squares = run.record[:, :, 1] ** 2
    at = np.searchsorted(run.time, place)
    assert value == pytest.approx(squares.mean(axis=0)[at])
    assert half == pytest.approx(1.96 * squares.std(axis=0, ddof=1)[at] / 8.0)
    averaging, shifted = (sp.theory.averaging(oscillator(0.5, 0.3), form=form) for form in ("corrected", "shifted"))
    axes = figures.plot_transient(None, theory=[averaging, shifted], at=[1.0, 5.0])  # the shifted one's is not of A^2
    (curve,) = axes.lines
    assert np.array_equal(curve.get_ydata(), averaging.mean_square([1.0, 5.0]))


def test_survival_is_the_share_that_never_crossed() -> None:
    run = recorded()
    place, value, half = marks(figures.plot_survival(run, 2.5))
    amplitude = np.hypot(run.record[:, :, 0], run.record[:, :, 1])
    share = np.array([(amplitude[:, run.time <= t].max(axis=1) < 2.5).mean() for t in place])
    assert value == pytest.approx(share)
    assert half == pytest.approx(1.96 * np.sqrt(share * (1.0 - share) / 64.0))
    assert 0.0 < share[-1] < 1.0


@pytest.mark.parametrize(
    ("parameter", "values", "read"),
    [
        ("order", [0.4, 1.0], lambda o: o.springpot.order),
        ("coefficient", [0.1, 0.2], lambda o: o.springpot.coefficient),
        ("natural_frequency", [1.0, 2.0], lambda o: o.natural_frequency),
        ("restitution", [0.8, 1.0], lambda o: o.barrier.restitution),
        ("position", [-0.5, 0.5], lambda o: o.barrier.position),
        ("intensity", [1.0, 4.0], lambda o: o.excitation.intensity),
    ],
)
def test_a_sweep_asks_what_it_says(parameter: str, values: list[float], read: Callable[[Any], float]) -> None:
    asked: list[float] = []

    def method(problem: sp.System) -> sp.theory.Envelope:
        asked.append(read(Dimensionless.of(problem)))
        return sp.theory.envelope(problem)

    axes = figures.plot_against(
        parameter, system=oscillator(0.6, 0.3), values=values, theory={"own": method}, quantity="x_mean",
        runs=[counted()],
    )  # fmt: skip
    assert asked == values
    assert axes.lines[0].get_label() == "own"
    found = [sp.theory.envelope(problem).x_mean for problem in _changed(parameter, values)]
    assert axes.lines[0].get_ydata() == pytest.approx(found)
    place, value, half = marks(axes)
    assert (place[0], value[0]) == (read(Dimensionless.of(counted().system)), counted()["x_mean"].value)
    assert half[0] == pytest.approx(1.96 * counted()["x_mean"].error)


def _changed(parameter: str, values: list[float]) -> list[sp.System]:
    names = {"natural_frequency": "frequency"}
    base = {"order": 0.6, "coefficient": 0.3}
    return [oscillator(**{**base, names.get(parameter, parameter): value}) for value in values]


def test_a_sweep_has_a_gap_where_there_is_no_answer() -> None:
    axes = figures.plot_against("position", system=oscillator(), values=[-1.0, 0.0], theory=[sp.theory.averaging])
    assert np.isnan(axes.lines[0].get_ydata()).tolist() == [True, False]


def test_the_gaps_are_those_of_the_map() -> None:
    from springpot.evidence.reliability import read_map

    cells = read_map()
    chosen = (cells["restitution"] == 0.7) & (cells["position"] == 0.0)
    axes = figures.plot_gaps("memory_closure", "impact_rate", restitution=0.7)
    shown = axes.images[0].get_array()
    wanted = cells["memory_closure:impact_rate"][chosen]
    assert shown.compressed() == pytest.approx(wanted[np.isfinite(wanted)].tolist(), abs=1e-9) or sorted(
        shown.compressed()
    ) == pytest.approx(sorted(wanted[np.isfinite(wanted)]))


def test_the_terms_drawn_are_those_of_the_sum() -> None:
    found = power_law_sum(0.5, 1e-3, 1e3, 1e-2)
    axes = figures.plot_memory_terms(0.5, tolerance=1e-2)
    *terms, law, total = axes.lines
    lag = total.get_xdata()
    assert len(terms) == found.rates.size
    assert total.get_ydata() == pytest.approx(np.exp(-np.multiply.outer(lag, found.rates)) @ found.weights)
    assert law.get_ydata() == pytest.approx(lag**-0.5)


def test_known_slopes_are_drawn_as_they_are() -> None:
    axes = figures.plot_convergence({"one": ([0.1, 0.2], [0.01, 0.02], [0.001, 0.001])}, orders=(0.5, 2.0))
    for line, order in zip(axes.lines[-2:], (0.5, 2.0), strict=True):
        x, y = line.get_data()
        assert np.log(y[1] / y[0]) / np.log(x[1] / x[0]) == pytest.approx(order)
    assert marks(axes)[2] == pytest.approx([0.00196, 0.00196])


@pytest.mark.parametrize(
    ("draw", "error", "says"),
    [
        (lambda: figures.plot_path(counted()), ValueError, "recorded paths"),
        (lambda: figures.plot_path(recorded(), member=64), ValueError, "from 0 to 63"),
        (lambda: figures.plot_path(recorded(), window=(90.0, 99.0)), ValueError, "window must hold"),
        (lambda: figures.plot_path(recorded(), quantity="a"), ValueError, "quantity must be 'x' or 'v'"),  # type: ignore[arg-type]
        (lambda: figures.plot_path("run"), TypeError, "what springpot.simulate returned"),  # type: ignore[arg-type]
        (lambda: figures.plot_density(recorded()), ValueError, "distributions=True"),
        (lambda: figures.plot_density(counted(), "energy"), ValueError, "quantity must be one of"),
        (lambda: figures.plot_density(None), ValueError, "at must say where"),
        (lambda: figures.plot_density(counted(), theory="exact"), TypeError, "theory must be a result"),  # type: ignore[arg-type]
        (lambda: figures.plot_spectrum(recorded()), ValueError, "spectrum= frequencies"),
        (lambda: figures.plot_correlation(recorded(), at=[50.0]), ValueError, "shorter than the 40 s"),
        (lambda: figures.plot_correlation(recorded(), at=[-1.0]), ValueError, "at least 0 s"),
        (lambda: figures.plot_transient(adapted()), ValueError, "data must be of a run from rest"),
        (lambda: figures.plot_survival(adapted(), 1.0), ValueError, "data must be of a run from rest"),
        (lambda: figures.plot_transient(None), ValueError, "at must say when"),
        (lambda: figures.plot_transient(recorded(), "impact_rate"), ValueError, "quantity must be one of"),
        (lambda: figures.plot_survival(recorded(), -1.0), ValueError, "level must be a positive"),
        (lambda: figures.plot_against("color"), ValueError, "parameter must be one of"),
        (lambda: figures.plot_against("order", quantity="x"), ValueError, "quantity must be one of"),
        (
            lambda: figures.plot_against("order", values=[0.5], theory=[exact]),
            TypeError,
            "system must be a System, not None",
        ),
        (
            lambda: figures.plot_against(
                "position", system=oscillator(position=None), values=[0.0], theory=[sp.theory.exact]
            ),
            ValueError,
            "must have a wall",
        ),
        (lambda: figures.plot_gaps("guess"), ValueError, "method must be one of"),
        (lambda: figures.plot_gaps("memory_closure", restitution=0.33), ValueError, "no cells with restitution 0.33"),
        (lambda: figures.plot_convergence({"one": ([0.1], [0.1, 0.2])}), ValueError, "as many errors as steps"),
        (lambda: figures.plot_convergence({"one": ([0.1], [-0.1])}), ValueError, "must be positive"),
    ],
)
def test_what_cannot_be_drawn_is_refused_in_a_sentence(
    draw: Callable[[], Any], error: type[Exception], says: str
) -> None:
    with pytest.raises(error, match=re.escape(says)):
        draw()


def test_the_docstring_of_each_picture_has_all_its_parameters_and_no_word_to_be_filled_in() -> None:
    for name in (name for name in figures.__all__ if name.startswith("plot_")):
        words = getattr(figures, name).__doc__
        assert not re.search(r"^    <", words, re.MULTILINE)
        for parameter in inspect.signature(getattr(figures, name)).parameters:
            assert re.search(rf"^    [\w*, ]*\b{parameter}\b", words, re.MULTILINE), (name, parameter)
