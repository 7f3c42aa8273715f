"""Weak order of the default scheme: how much stationary numbers change when the step is halved.

Two runs share their noise (each normal of the coarse one is the sum of two of the fine one) and start at the same
adapted x(0); the mean difference of their numbers has an error from the spread between paths.  Without a wall they stay
together, with one they part after some impacts.  ``python -m benchmarks.weak_order`` writes the table and the picture;
it takes about ten minutes of one processor.
"""

from __future__ import annotations

import argparse
import csv
import math
import sys
from collections.abc import Sequence
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt
from scipy import optimize

from benchmarks.measure import folder_for
from springpot import Barrier, Oscillator, Springpot, System, WhiteNoise
from springpot.figures.style import COLORS, save
from springpot.machine.crew import threads_available
from springpot.simulation.estimate.samples import samples_of
from springpot.simulation.estimate.stationary_start import adapt
from springpot.simulation.paths.simulation import simulation_of
from springpot.simulation.paths.statistics import standard_error
from springpot.simulation.plan.plan import plan_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes

__all__ = ["CASES", "Case", "Change", "Order", "change", "draw", "measure", "orders", "read", "text", "write"]

Floats = npt.NDArray[np.float64]

QUANTITIES = {
    "x_mean": (r"$\langle x\rangle$", "blue", "o"),
    "x_mean_square": (r"$\langle x^2\rangle$", "vermilion", "s"),
    "v_mean_square": (r"$\langle v^2\rangle$", "green", "^"),
    "impact_rate": ("impact rate", "purple", "D"),
    "impact_speed_mean": ("mean impact speed", "orange", "v"),
    "impact_speed_mean_square": ("mean square impact speed", "sky", "P"),
}
STEPS = (0.4, 0.2, 0.1, 0.05)
WINDOW = 30.0, 130.0
PATHS = 1_048_576  # pairs at a step of 0.1 s or less, which need the smallest errors
SEEN = 2.0  # standard errors below which a change is shown as a limit
FITTED = 0.2  # s; coarser steps are not fitted, for there two terms of opposite sign compete
USUAL = 0.01  # s; the default step, of which the bias is told


@dataclass(frozen=True)
class Case:
    """An oscillator with Omega = C = q = 1, unless said otherwise.

    Parameters
    ----------
    order : float
        alpha.
    restitution : float
        0 stands for no wall.
    position : float
        Of the wall, in m.
    steps : tuple of float
        Coarse steps, in s; each is compared with its half.
    share : float
        Pairs of paths, over the usual number: fewer where changes are large, or none are expected.
    """

    order: float
    restitution: float
    position: float = 0.0
    steps: tuple[float, ...] = STEPS
    share: float = 1.0

    @property
    def name(self) -> str:
        """What table and picture call it."""
        wall = f"wall at {self.position:g}, r = {self.restitution:g}" if self.restitution > 0.0 else "no wall"
        return f"alpha = {self.order:g}, {wall}"

    @property
    def oscillator(self) -> System:
        """The oscillator itself."""
        barrier = Barrier(self.position, self.restitution, free_side="above") if self.restitution > 0.0 else None
        return Oscillator(1.0, Springpot(self.order, 1.0), barrier, WhiteNoise(1.0))


CASES = (
    Case(0.5, 0.0, share=0.25),
    Case(1.0, 1.0, share=0.25),
    Case(0.5, 1.0),
    Case(0.3, 0.8),
    Case(0.5, 0.5, steps=(*STEPS, 0.025, 0.0125), share=0.25),
)


@dataclass(frozen=True)
class Change:
    """What one number gains when the step is halved.

    Parameters
    ----------
    case, quantity : str
    step : float
        The coarse one, in s.
    value : float
        Of the quantity at half the step, in its own unit.
    change, error : float
        Value at half the step less value at the step, and its standard error, both over ``value``.
    """

    case: str
    quantity: str
    step: float
    value: float
    change: float
    error: float


@dataclass(frozen=True)
class Order:
    """Fit of change = a h^p to the changes of one quantity.

    Parameters
    ----------
    case, quantity : str
    order, error : float
        p and its standard error; NaN where no change was seen.
    factor : float
        a.
    bias : float
        Relative bias at a step of 0.01 s that it implies, -a h^p / (1 - 2^-p).
    misfit : float
        Chi square of the fit over its degrees of freedom; of no change at all where none was seen.
    """

    case: str
    quantity: str
    order: float
    error: float
    factor: float
    bias: float
    misfit: float


def _coupled(case: Case, step: float, position: float, paths: int, stream: int) -> dict[str, tuple[float, Floats]]:
    """Fine value and per-path difference of every quantity."""
    base = plan_of(
        case.oscillator, paths=paths, duration=WINDOW[1], window=WINDOW, step=step, threads=threads_available(),
        start="stationary",
    )  # fmt: skip
    levels = []
    for at, halved in ((step, True), (0.5 * step, False)):
        simulation = simulation_of(base.but(step=at, initial_position=position))
        levels.append(samples_of(simulation, simulation.advance(stream=stream, halved=halved).rows))
    coarse, fine = levels
    names = QUANTITIES if case.restitution > 0.0 else ("x_mean_square", "v_mean_square")
    return {name: (fine[name][0], fine[name][1] - coarse[name][1]) for name in names}


def change(case: Case, step: float, *, position: float = 0.0, paths: int = PATHS, stream: int = 5) -> list[Change]:
    """Changes of all quantities from ``step`` to half of it.

    Parameters
    ----------
    case : Case
    step : float
    position : float
        x(0), the same for both steps.
    paths, stream : int
        Number of pairs, and their stream of normals.

    Returns
    -------
    list of Change
        Without a wall, of <x^2> and <v^2>.
    """
    found = _coupled(case, step, position, paths, stream)
    return [
        Change(case.name, name, step, value, float(samples.mean()) / value, standard_error(samples) / value)
        for name, (value, samples) in found.items()
    ]


def measure(cases: Sequence[Case] = CASES, *, paths: int = PATHS) -> list[Change]:
    """Changes of all cases at all their steps, with ``paths`` pairs or fewer."""
    found = []
    for case in cases:
        position = 0.0
        if case.restitution > 0.0:
            position = adapt(plan_of(case.oscillator, start="stationary", paths=65_536)).settings.initial_position
        for number, step in enumerate(case.steps):
            pairs = max(1024, int(paths * case.share * min(1.0, 0.1 / step)))
            found += change(case, step, position=position, paths=pairs, stream=5 + number)
            print(f"{case.name}, step {step:g}", file=sys.stderr, flush=True)
    return found


def _fitted(changes: Sequence[Change]) -> Order:
    """Weighted least squares of a h^p."""
    first = changes[0]
    h, d, e = (np.array([getattr(c, name) for c in changes]) for name in ("step", "change", "error"))
    unchanged = float(((d / e) ** 2).mean())
    if abs(d[0]) < 5.0 * e[0]:  # an order cannot be told
        return Order(first.case, first.quantity, math.nan, math.nan, math.nan, math.nan, unchanged)

    def power(steps: Floats, a: float, p: float) -> Floats:
        return np.asarray(a * (steps / h[0]) ** p)

    # fine changes may come out with either sign: the fit is to them, not to their logarithms
    (a, order), covariance = optimize.curve_fit(power, h, d, p0=(d[0], 1.0), sigma=e, absolute_sigma=True)
    misfit = float((((d - power(h, a, order)) / e) ** 2).sum()) / max(d.size - 2, 1)
    return _order(first, float(order), math.sqrt(covariance[1, 1]), float(a / h[0] ** order), misfit)


def _order(of: Change, order: float, error: float, factor: float, misfit: float) -> Order:
    bias = -factor * USUAL**order / (1.0 - 2.0**-order)
    return Order(of.case, of.quantity, order, error, factor, bias, misfit)


def orders(changes: Sequence[Change]) -> list[Order]:
    """A fit for every case and quantity."""
    keys = dict.fromkeys((c.case, c.quantity) for c in changes)
    return [_fitted([c for c in changes if (c.case, c.quantity) == key and c.step <= FITTED]) for key in keys]


def write(changes: Sequence[Change], path: Path) -> Path:
    """Write the changes as CSV."""
    with path.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(field.name for field in fields(Change))
        for one in changes:
            writer.writerow(item if isinstance(item, str) else f"{item:.6g}" for item in asdict(one).values())
    return path


def read(path: Path) -> list[Change]:
    """Read the changes back."""
    with path.open(newline="", encoding="utf-8") as stream:
        return [
            Change(row["case"], row["quantity"], *(float(row[name]) for name in ("step", "value", "change", "error")))
            for row in csv.DictReader(stream)
        ]


def text(changes: Sequence[Change]) -> str:
    """Changes and orders for a terminal."""
    lines = []
    fits = {(fit.case, fit.quantity): fit for fit in orders(changes)}
    for case in dict.fromkeys(c.case for c in changes):
        lines.append(f"\n{case}: relative change when the step h is halved, in units of 1e-4")
        for name in QUANTITIES:
            mine = [c for c in changes if (c.case, c.quantity) == (case, name)]
            if not mine:
                continue
            numbers = "  ".join(f"h {c.step:g}: {1e4 * c.change:.3g} +- {1e4 * c.error:.2g}" for c in mine)
            fit = fits[case, name]
            told = (
                f"no order to be told, chi^2 of no change {fit.misfit:.1f} per step" if math.isnan(fit.order)
                else f"order {fit.order:.2f} +- {fit.error:.2f} (chi^2 {fit.misfit:.1f}), bias at h = {USUAL:g}: "
                f"{100.0 * fit.bias:.2g} %"
            )  # fmt: skip
            lines.append(f"  {name:<25} {told}\n      {numbers}")
    return "\n".join(lines)


def draw(changes: Sequence[Change], path: Path) -> Path:
    """One panel for each case, and one for the legend."""
    cases = list(dict.fromkeys(c.case for c in changes))
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10.0, 6.6), layout="constrained")
    panels = figure.subplots(2, 3, sharex=True, sharey=True).ravel()
    fits = {(fit.case, fit.quantity): fit for fit in orders(changes)}
    for panel, case in zip(panels, cases, strict=False):
        _panel(panel, case, [c for c in changes if c.case == case], fits)
    for panel in panels[::3]:
        panel.set_ylabel("relative change when h is halved (its size)", fontsize=9)
    for panel in panels[2:5]:
        panel.set_xlabel("step h in s (Omega = 1 per s)")
        panel.tick_params(labelbottom=True)
    _legend(panels[len(cases)])
    return save(figure, path)


def _panel(panel: Axes, case: str, changes: Sequence[Change], fits: dict[tuple[str, str], Order]) -> None:
    panel.set_title(case.replace("alpha", r"$\alpha$"), fontsize=10)
    panel.set_xscale("log")
    panel.set_yscale("log")
    panel.set_xlim(0.01, 0.55)
    panel.set_ylim(2e-5, 4e-2)
    panel.set_xticks([0.0125, 0.025, 0.05, 0.1, 0.2, 0.4], ["0.0125", "0.025", "0.05", "0.1", "0.2", "0.4"])
    panel.minorticks_off()
    panel.grid(visible=True, color="0.9", linewidth=0.6)
    panel.set_axisbelow(True)
    panel.spines[["top", "right"]].set_visible(False)
    panel.tick_params(labelsize=8)
    for number, (name, (_, color, mark)) in enumerate(QUANTITIES.items()):
        shift = 1.05 ** (number - 2.5)  # so that marks do not hide each other
        for one in (c for c in changes if c.quantity == name):
            x, size = one.step * shift, abs(one.change)
            if size > SEEN * one.error:
                panel.errorbar(
                    x, size, [[min(one.error, 0.9 * size)], [one.error]], fmt=mark, color=COLORS[color],
                    markersize=5, elinewidth=1,
                )  # fmt: skip
            else:  # the upper end of the interval
                panel.plot(x, size + SEEN * one.error, marker=r"$\downarrow$", color=COLORS[color], markersize=7)
        fit = fits.get((case, name))
        if fit is not None and math.isfinite(fit.order):
            steps = np.array([min(c.step for c in changes), FITTED])
            panel.plot(shift * steps, abs(fit.factor) * steps**fit.order, color=COLORS[color], linewidth=1)
    guide = np.array([0.22, 0.5])
    panel.plot(guide, 3e-5 * (guide / guide[0]) ** 2, "--", color=COLORS["black"], linewidth=1)
    panel.annotate("order 2", (guide[0], 3e-5), (-42, -3), textcoords="offset points", fontsize=8)


def _legend(panel: Axes) -> None:
    panel.axis("off")
    for label, color, mark in QUANTITIES.values():
        panel.plot([], [], mark, color=COLORS[color], label=label)
    panel.plot([], [], marker=r"$\downarrow$", linestyle="", color="0.4", label="not seen: size + 2 standard errors")
    panel.plot([], [], "-", color="0.4", label="fit of $a h^p$ to h up to 0.2 s")
    panel.legend(loc="center", frameon=False, fontsize=9, title="bars: one standard error", title_fontsize=9)


def main() -> None:
    """Measure, then write table and picture and print the orders."""
    parser = argparse.ArgumentParser(prog="weak_order", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="few paths: shows that it works, and means nothing")
    parser.add_argument("--draw", action="store_true", help="measure nothing: draw the table that is there")
    parser.add_argument("--out", type=Path, help="folder for both files")
    chosen = parser.parse_args()
    folder = folder_for(chosen.out, chosen.quick)
    table = folder / "weak_order.csv"
    if not chosen.draw:
        write(measure(paths=4096 if chosen.quick else PATHS), table)
    changes = read(table)
    print(text(changes))
    print(f"\nwritten: {table}, {draw(changes, folder / 'weak_order.png')}")


if __name__ == "__main__":
    main()
