"""The text that goes with the pictures, in Markdown."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal

from springpot.machine.faults import per_cent
from springpot.paper.errata import ERRATA, Erratum
from springpot.paper.montecarlo import Collapse, Estimate, Gap, Point, collapse, pooled, shortfall
from springpot.problem.dimensionless import Dimensionless
from springpot.problem.oscillator import Oscillator
from springpot.problem.parts import Springpot
from springpot.problem.system import System
from springpot.theory import averaging

_FORMS: tuple[Literal["printed"], Literal["corrected"]] = ("printed", "corrected")
_COLUMNS = (
    ("alpha", "1", "order of the derivative"),
    ("q", "m^2 s^-3", "intensity of the noise"),
    ("mu_printed, mu_corrected", "m^2", "Eq. 20 as printed and corrected (the same at Omega = 1)"),
    ("mu_mc, mu_mc_se", "m^2", "run from rest: mean over the paths and the second half of the run"),
    ("mu_end, mu_end_se", "m^2", "the same run: mean over the paths at its end"),
    ("mu_adapted, mu_adapted_se", "m^2", "adapted run: mean over the paths and the time after the transient"),
    ("start_residual", "1", "adapted run: how far the last pilot run's mean of x was from its x(0), over its r.m.s."),
)


def fig2_page(rows: Sequence[Point], settings: str, duration: float) -> str:
    """Words for Fig. 2.

    Parameters
    ----------
    rows : sequence of Point
    settings : str
        How the runs were made, in words.
    duration : float
        Of the runs from rest, in s.
    """
    least = min(row.alpha for row in rows)
    short = shortfall(Oscillator(1.0, Springpot(least, 1.0)), duration)
    formula = {row.alpha: row.mu_printed / row.q for row in rows}
    rest, adapted = pooled(rows, "rest"), pooled(rows, "adapted")
    gaps = {alpha: adapted[alpha].under(formula[alpha]) for alpha in formula}
    worst = max(gaps, key=lambda alpha: abs(gaps[alpha].value))
    lines = [
        "# Fig. 2: mean square amplitude against the order of the derivative",
        "",
        "Plotted is mu = <A^2> with A^2 = x^2 + v^2 / Omega^2, at C = Omega = 1, for the three noise intensities q.",
        "Other readings of *amplitude*, such as 2 <x^2>, give other numbers (see `errata.md`).",
        settings,
        "Error bars are 95 % intervals. At alpha = 0 the springpot is a spring, nothing dissipates, and there is no",
        "stationary state.",
        "",
        *_start(rows),
        "",
        "## The three curves are one",
        "",
        "The equation of motion is the same for every q once lengths are measured in sqrt(q / Omega^3), so they",
        "must fall on one when divided by q. The runs of the three q have independent random numbers.",
        "",
        *_table(
            ("runs", "chi-square", "degrees of freedom", "chance of a larger one", "farthest point, standard errors"),
            [_collapse_row("from rest", collapse(rows, "rest")), _collapse_row("adapted", collapse(rows, "adapted"))],
        ),
        "",
        "## Formula and Monte Carlo are not",
        "",
        f"The largest gap to the adapted runs is at alpha = {worst:g}: the formula is {_percent(gaps[worst])} off (the",
        f"largest of {len(gaps)} is by chance a little too large). From rest a further gap opens at small alpha, where "
        "the",
        f"amplitude has not yet grown to its stationary value: by Eq. 19 {100.0 * short:.1f} % of it is missing at "
        f"alpha = {least:g} in the mean over the run's second half (the dashed line of the figure).",
        "",
        *_table(
            ("alpha", "formula / q", "Monte Carlo / q", "gap", "adapted start / q", "gap"),
            [
                (
                    f"{alpha:g}",
                    f"{formula[alpha]:.4g}",
                    *(words for each in (rest[alpha], adapted[alpha]) for words in _with_gap(each, formula[alpha])),
                )
                for alpha in sorted(formula)
            ],
        ),
        "",
        "Each is the mean over the three q, weighted by precision; ± is one standard error, and a gap is how far the "
        "formula is too high.",
        "",
        "## The columns of `fig2.csv`",
        "",
        *_table(("column", "unit", "meaning"), _COLUMNS),
        "",
        "A name that ends in `_se` is the standard error of the one before it.",
        "",
    ]
    return "\n".join(lines)


def _start(rows: Sequence[Point]) -> list[str]:
    """How well adapted the adapted starts were."""
    worst = max(rows, key=lambda row: math.inf if math.isnan(row.start_residual) else row.start_residual)
    where = f"alpha = {worst.alpha:g}, q = {worst.q:g}"
    if math.isnan(worst.start_residual):
        return [f"An adapted start is right when x(0) is the stationary mean of x; at {where} no pilot run could tell."]
    return [
        "An adapted start is right when x(0) is the stationary mean of x. It is found by pilot runs; the mean of the",
        f"last one differed from its start by at most {per_cent(worst.start_residual)} of the r.m.s. of x",
        f"({where}), sampling error included, and x(0) was then corrected by that difference.",
    ]


def _collapse_row(start: str, row: Collapse) -> tuple[str, ...]:
    return start, f"{row.chi_square:.1f}", f"{row.degrees}", f"{row.probability:.2f}", f"{row.largest:.1f}"


def errata_page(gaps: Sequence[Gap], trend: Sequence[tuple[System, Estimate]], settings: str) -> str:
    """Words for the errata: each with its numbers, then the gap between the formula and Monte Carlo.

    Parameters
    ----------
    gaps : sequence of Gap
    trend : sequence of (System, Estimate)
        What the picture shows: <A^2> of adapted runs, in the order of Omega.
    settings : str
        One sentence that says how the runs were made.
    """
    lines = [
        "# Errata of the paper",
        "",
        "Errors in the text of *Stochastic response of a fractional vibroimpact system*. None changes its idea, and",
        "at Omega = 1, the only case it computes, none changes its final formula. In each table *computed* is found",
        "without the equation in question.",
        "",
        *(line for erratum in ERRATA for line in _section(erratum)),
        "![Mean square amplitude against the natural frequency](errata.png)",
        "",
        "The factor Omega of erratum 4, seen in Monte Carlo: the printed formula has the wrong trend. The runs have an",
        f"adapted start, {settings}",
        "",
        *_table(
            ("Omega", "c = C Omega^(alpha-2)", "as printed", "corrected", "Monte Carlo", "gap of the corrected"),
            [_trend_row(oscillator, estimate) for oscillator, estimate in trend],
        ),
        "",
        *_heavy(*trend[0]),
        "",
        "## The agreement with simulation",
        "",
        "The paper finds an excellent agreement of its formula with simulation over the whole domain of alpha. With",
        "A^2 = x^2 + v^2 / Omega^2 at Omega = q = 1 (where the printed and the corrected formula agree) it is:",
        "",
        *_table(
            ("alpha", "C", "formula", "from rest", "gap", "adapted start", "gap", "2 <x^2>", "2 <v^2> / Omega^2"),
            [
                (
                    f"{gap.alpha:g}",
                    f"{gap.coefficient:g}",
                    f"{gap.formula:.4g}",
                    *(words for each in (gap.rest, gap.adapted) for words in _with_gap(each, gap.formula)),
                    f"{gap.twice_x:.4g}",
                    f"{gap.twice_v:.4g}",
                )
                for gap in gaps
            ],
        ),
        "",
        f"± is one standard error, and a gap is how far the formula is too high. Both starts: {settings}",
        "The last two columns, of the adapted runs, are other readings of *amplitude squared*: averaging does not",
        "distinguish them, the simulation does.",
        "",
    ]
    return "\n".join(lines)


def _section(erratum: Erratum) -> list[str]:
    findings = [(f.what, *(_number(value) for value in (f.computed, f.printed, f.corrected))) for f in erratum.check()]
    return [
        f"## {erratum.number}. {erratum.title} ({erratum.equation})",
        "",
        erratum.statement.replace("|", "\\|"),
        "",
        *_table(("", "computed", "as printed", "corrected"), findings),
        "",
        *((erratum.remark, "") if erratum.remark else ()),
    ]


def _trend_row(oscillator: System, estimate: Estimate) -> tuple[str, ...]:
    printed, corrected = (averaging(oscillator, form=form).amplitude_mean_square for form in _FORMS)
    return (
        f"{oscillator.natural_frequency:.3g}",
        f"{Dimensionless.of(oscillator).dimensionless_coefficient:.2g}",
        f"{printed:.4g}",
        f"{corrected:.4g}",
        *_with_gap(estimate, corrected),
    )


def _heavy(oscillator: System, estimate: Estimate) -> list[str]:
    """Why the corrected formula is off at the lowest Omega."""
    gap = estimate.under(averaging(oscillator).amplitude_mean_square)
    return [
        f"At Omega = {oscillator.natural_frequency:g} the corrected formula is {_percent(gap)} off. This is no new "
        f"erratum: there c = {Dimensionless.of(oscillator).dimensionless_coefficient:.2g}, the springpot is",
        "no longer light, and averaging itself is too high by as much as at C = Omega = 1 (the row alpha = 0.7, C = 1",
        "of the table below). Towards larger Omega the springpot becomes light and the gap closes.",
    ]


def _table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    def line(cells: Sequence[str]) -> str:
        return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"

    return [line(header), line(["---"] * len(header)), *(line(row) for row in rows)]


def _number(value: float) -> str:
    """Five digits; what is only rounding is 0."""
    return f"{0.0 if abs(value) < 1e-8 else value:.5g}"


def _percent(gap: Estimate) -> str:
    return f"{100.0 * gap.value:+.1f} ± {100.0 * gap.error:.1f} %"


def _with_gap(estimate: Estimate, formula: float) -> tuple[str, str]:
    """A number with its error, and how far the formula is too high."""
    return f"{estimate.value:.4g} ± {estimate.error:.2g}", _percent(estimate.under(formula))
