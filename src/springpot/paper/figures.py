"""The paper's two figures, and one that shows its main erratum."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import astuple, fields
from pathlib import Path
from typing import Literal

import numpy as np

from springpot.figures import COLORS, bars, new_figure, plot_fourier_error, plot_fourier_series, save
from springpot.machine.arrays import Floats
from springpot.machine.files import write, write_table
from springpot.machine.record import Record, writing
from springpot.paper import montecarlo, pages
from springpot.paper.montecarlo import ALPHAS, INTENSITIES, Estimate, Point
from springpot.problem.oscillator import Oscillator
from springpot.problem.parts import Springpot, WhiteNoise
from springpot.problem.system import System
from springpot.simulation.monte_carlo import simulated
from springpot.theory import averaging

Progress = Callable[[float, str], None]

_REST, _ADAPTED = ("o", 3.0), ("D", 5.0)  # markers and their sizes: one fits inside the other
_GAP_CASES = ((0.1, 1.0), (0.3, 1.0), (0.5, 1.0), (0.7, 1.0), (0.9, 1.0), (0.5, 0.1))
_OMEGAS = np.geomspace(0.3, 3.0, 10)


def _silent(fraction: float, text: str) -> None:
    """Progress that nobody watches."""


def fig1(out: Path) -> list[Path]:
    """Draw the paper's Fig. 1: partial sums of the series of \\|cos p\\| (Eq. 10), and their errors.

    Parameters
    ----------
    out : Path
        Folder, which must exist.

    Returns
    -------
    list of Path
        ``fig1.png``.

    Raises
    ------
    OSError
        If the file cannot be written.

    Examples
    --------
    >>> import tempfile
    >>> [path.name for path in fig1(Path(tempfile.mkdtemp()))]
    ['fig1.png']
    """
    figure, (curves, errors) = new_figure(7.0, 6.0, ratios=(3.0, 2.0))
    plot_fourier_series(curves)
    plot_fourier_error(errors)
    curves.set_xlabel("")
    return [save(figure, out / "fig1.png")]


def fig2(
    out: Path,
    *,
    alphas: Sequence[float] = ALPHAS,
    intensities: Sequence[float] = INTENSITIES,
    paths: int = 5000,
    duration: float = 100.0,
    step: float = 1e-3,
    seed: int = 1,
    threads: int | None = None,
    progress: Progress = _silent,
) -> list[Path]:
    """Reproduce the paper's Fig. 2: mean square amplitude against alpha for three noise intensities.

    Parameters
    ----------
    out : Path
        Folder, which must exist.
    alphas, intensities, paths, duration, step, seed, threads
        As in `springpot.paper.montecarlo.points`; the defaults are the paper's.
    progress : callable
        Called with the fraction done, from 0 to 1, and a line of text.

    Returns
    -------
    list of Path
        ``fig2.csv``, ``fig2.png`` and ``fig2.md``.  While points are being computed those done are in
        ``fig2.csv.record``; an interrupted run leaves that file and no other, and the same call goes on from there.

    Raises
    ------
    OSError
        If a file cannot be written.
    """
    table = out / "fig2.csv"
    record = Record(out / "fig2.csv.record", "figure_2")
    rows: list[Point] = []
    with writing(f"figure {str(table)!r}"):
        for row in montecarlo.points(
            alphas, intensities, paths=paths, duration=duration, step=step, seed=seed, threads=threads, record=record
        ):
            rows.append(row)
            progress(len(rows) / (len(alphas) * len(intensities)), f"fig2: alpha = {row.alpha:g}, q = {row.q:g}")
        header = [field.name for field in fields(Point)]
        write_table(table, [header, *([f"{value:.10g}" for value in astuple(row)] for row in rows)])
        settings = (
            f"Monte Carlo as in the paper: {paths} paths from rest, Grünwald-Letnikov sum with step {step:g} s, mean "
            f"over t = {duration / 2:g} to {duration:g} s. The adapted runs start from the stationary mean without the "
            f"memory of a start: {paths} paths, step {10 * step:g} s, mean over {duration / 2:g} s after the transient."
        )
        text = out / "fig2.md"
        write(str(text), pages.fig2_page(rows, settings, duration).encode())
        picture = _draw_fig2(out / "fig2.png", rows, duration)
        record.remove()
    return [table, picture, text]


def _draw_fig2(path: Path, rows: Sequence[Point], duration: float) -> Path:
    figure, (curves, from_rest, from_adapted) = new_figure(7.5, 8.5, ratios=(3.0, 1.3, 1.3))
    fine = np.linspace(0.04, 1.0, 193)
    intensities = sorted({row.q for row in rows})
    colors = [COLORS[name] for name in ("blue", "vermilion", "green", "purple", "orange", "sky")]
    for number, q in enumerate(intensities):
        color = colors[number % len(colors)]
        systems = [Oscillator(1.0, Springpot(float(alpha), 1.0), excitation=WhiteNoise(q)) for alpha in fine]
        formula = [averaging(system, form="printed").amplitude_mean_square for system in systems]
        curves.plot(fine, formula, color=color, linewidth=1.2, label=f"Eq. 20, $q = {q:g}$ m² s⁻³")
        group = [row for row in rows if row.q == q]
        alpha, printed, *simulated = np.array(
            [(r.alpha, r.mu_printed, r.mu_mc, r.mu_mc_se, r.mu_adapted, r.mu_adapted_se) for r in group]
        ).T
        # beside each other in the lower panels, so that no bar hides another
        beside = alpha + 0.006 * (number - (len(intensities) - 1) / 2)
        for ratios, mu, error, (marker, size) in (
            (from_rest, *simulated[:2], _REST),
            (from_adapted, *simulated[2:], _ADAPTED),
        ):
            look = {"color": color, "marker": marker, "size": size, "hollow": (marker, size) != _REST}
            bars(curves, alpha, mu, error, **look)
            bars(ratios, beside, mu / printed, error / printed, **look)
    for (marker, size), label in (
        (_REST, f"Monte Carlo from rest, $t$ = {duration / 2:g}–{duration:g} s"),
        (_ADAPTED, "Monte Carlo, adapted start, after the transient"),
    ):
        fill: Literal["full", "none"] = "full" if (marker, size) == _REST else "none"
        curves.plot([], [], color=COLORS["black"], linestyle="none", marker=marker, markersize=size, fillstyle=fill,
                    label=label)  # fmt: skip
    definition = r"$A^2 = x^2 + \dot x^2/\Omega^2$,  $C = \Omega = 1$"
    curves.legend(
        loc="upper right", frameon=False, title=f"{definition}\n95 % bars are smaller than the markers in this panel"
    )
    curves.set_yscale("log")
    curves.set_ylabel(r"mean square amplitude $\mu = \langle A^2\rangle$ (m²)")
    curves.text(0.008, 0.03, "α = 0: no stationary state", rotation=90, va="bottom", color="0.35", size="small",
                transform=curves.get_xaxis_transform())  # fmt: skip
    for ratios, start in ((from_rest, "from rest"), (from_adapted, "adapted start")):
        ratios.axhline(1.0, color=COLORS["black"], linewidth=1.2)
        ratios.set_ylabel(f"Monte Carlo / Eq. 20\n{start}")
        ratios.text(0.5, 0.06, "bars: 95 %", ha="center", size="small", transform=ratios.transAxes)
    reached = [1.0 - montecarlo.shortfall(Oscillator(1.0, Springpot(float(alpha), 1.0)), duration) for alpha in fine]
    from_rest.plot(fine, reached, color="0.45", linewidth=1.2, linestyle="--", label="Eq. 19, not yet stationary")
    from_rest.legend(loc="lower right", frameon=False, fontsize="small")
    for axes in (curves, from_rest, from_adapted):
        axes.axvline(0.0, color="0.45", linestyle=(0, (4, 3)), linewidth=1.2)
    from_adapted.sharey(from_rest)
    from_adapted.set_xlabel(r"order of the derivative $\alpha$")
    from_adapted.set_xlim(-0.03, 1.03)
    return save(figure, path)


def errata(out: Path, *, seed: int = 1, threads: int | None = None, progress: Progress = _silent) -> list[Path]:
    """Write the errata page, with its numbers, and draw the main erratum against Monte Carlo.

    Parameters
    ----------
    out : Path
        Folder, which must exist.
    seed, threads
        As in `springpot.paper.montecarlo.points`.
    progress : callable
        Called with the fraction done, from 0 to 1, and a line of text.

    Returns
    -------
    list of Path
        ``errata.md`` and ``errata.png``.

    Raises
    ------
    OSError
        If a file cannot be written.
    """
    paths, duration, step = 4096, 200.0, 5e-3
    total = len(_GAP_CASES) + _OMEGAS.size
    measured = []
    for gap in montecarlo.gaps(_GAP_CASES, paths=paths, duration=duration, step=step, seed=seed, threads=threads):
        measured.append(gap)
        progress(len(measured) / total, f"errata: alpha = {gap.alpha:g}, C = {gap.coefficient:g}")
    settings = f"{paths} paths, step {step:g} s, mean over t = {duration / 2:g} to {duration:g} s."
    estimates: list[Estimate] = []
    for number, omega in enumerate(_OMEGAS):
        answer = simulated(
            _tuned(float(omega)), paths=paths, duration=duration, step=step, window=(duration / 2, duration),
            seed=1000 * seed + 700 + number, threads=threads, start="stationary",
        )  # fmt: skip
        estimates.append(Estimate.of(answer))
        progress((len(measured) + len(estimates)) / total, f"errata: Omega = {omega:.3g}")
    page = out / "errata.md"
    trend = [(_tuned(float(omega)), estimate) for omega, estimate in zip(_OMEGAS, estimates, strict=True)]
    page.write_text(pages.errata_page(measured, trend, settings), encoding="utf-8")
    drawn = np.array([(estimate.value, estimate.error) for estimate in estimates])
    return [page, _draw_errata(out / "errata.png", drawn)]


def _draw_errata(path: Path, simulated: Floats) -> Path:
    figure, (curves, ratios) = new_figure(7.0, 6.5, ratios=(3.0, 2.0))
    fine = np.geomspace(0.28, 3.2, 121)
    corrected = np.array([averaging(_tuned(float(omega))).amplitude_mean_square for omega in fine])
    printed = np.array([averaging(_tuned(float(omega)), form="printed").amplitude_mean_square for omega in fine])
    at_points = np.array([averaging(_tuned(float(omega))).amplitude_mean_square for omega in _OMEGAS])
    for axes, scale, point_scale in ((curves, 1.0, 1.0), (ratios, corrected, at_points)):
        axes.plot(fine, printed / scale, color=COLORS["vermilion"], linestyle="--", label="Eq. 20 as printed")
        axes.plot(fine, corrected / scale, color=COLORS["blue"], label="Eq. 20 corrected")
        mu, error = simulated.T / point_scale
        label = "Monte Carlo (95 % bars\nare smaller than the markers)"
        bars(axes, _OMEGAS, mu, error, color=COLORS["black"], size=_REST[1], label=label)
    curves.set_xscale("log")
    curves.set_yscale("log")
    curves.set_ylabel(r"mean square amplitude $\mu = \langle A^2\rangle$ (m²)")
    curves.legend(frameon=False, title=r"$A^2 = x^2 + \dot x^2/\Omega^2$,  $\alpha = 0.7$,  $C = 0.2$,  $q = 1$ m² s⁻³")
    ratios.set_yscale("log")
    ratios.set_ylabel("over Eq. 20 corrected")
    ratios.set_xlabel(r"natural frequency $\Omega$ (rad/s)")
    ratios.set_xticks([0.3, 0.5, 1.0, 2.0, 3.0], ["0.3", "0.5", "1", "2", "3"])
    ratios.set_yticks([0.3, 0.5, 1.0, 2.0, 3.0], ["0.3", "0.5", "1", "2", "3"])
    ratios.minorticks_off()
    return save(figure, path)


def _tuned(omega: float) -> System:
    """The oscillator of the errata picture."""
    return Oscillator(omega, Springpot(0.7, 0.2))
