"""The text that goes with the pictures, in Markdown."""

from __future__ import annotations

from collections.abc import Sequence

from springpot.oscillator import Oscillator, Springpot
from springpot.paper.errata import ERRATA, Erratum
from springpot.paper.montecarlo import Collapse, Gap, Point, shortfall

__all__ = ["errata_page", "fig2_page"]


def fig2_page(rows: Sequence[Point], scaling: Collapse, settings: str, duration: float) -> str:
    """Words for Fig. 2.

    Parameters
    ----------
    rows : sequence of Point
    scaling : Collapse
    settings : str
        How the runs were made, in words.
    duration : float
        Of the runs from rest, in s.
    """
    least = min(row.alpha for row in rows)
    short = shortfall(Oscillator(1.0, Springpot(least, 1.0)), duration)
    worst = max(rows, key=lambda row: abs(row.mu_printed / row.mu_adapted - 1.0))
    lines = [
        "# Fig. 2: mean square amplitude against the order of the derivative",
        "",
        "Plotted is mu = <A^2> with A^2 = x^2 + v^2 / Omega^2, at C = Omega = 1, for the three noise intensities q.",
        "Other readings of *amplitude*, such as 2 <x^2>, give other numbers (see `errata.md`).",
        settings,
        "Error bars are 95 % intervals. At alpha = 0 the springpot is a spring, nothing dissipates, and there is no",
        "stationary state.",
        "",
        "## The three curves are one",
        "",
        "The equation of motion is the same for every q once lengths are measured in sqrt(q / Omega^3), so they",
        "must fall on one when divided by q. The runs of the three q have independent random numbers. They give a",
        f"chi-square of {scaling.chi_square:.1f} for {scaling.degrees} degrees of freedom (a larger one has chance "
        f"{scaling.probability:.2f});",
        f"no point is further than {scaling.largest:.1f} standard errors from the others.",
        "",
        "## Formula and Monte Carlo are not",
        "",
        f"The largest gap to the adapted runs is at alpha = {worst.alpha:g}, q = {worst.q:g}: the formula is "
        f"{_percent(worst.mu_printed / worst.mu_adapted)} off. From rest a further gap opens at small alpha, where the",
        f"amplitude has not yet grown to its stationary value: by Eq. 19 {100.0 * short:.1f} % of it are missing at "
        f"alpha = {least:g} in the mean over the run's second half (the dashed line of the figure).",
        "",
        *_table(
            ("alpha", "formula / q", "Monte Carlo / q", "gap", "adapted start / q", "gap"),
            [
                (
                    f"{row.alpha:g}",
                    f"{row.mu_printed / row.q:.4g}",
                    f"{row.mu_mc / row.q:.4g} ± {row.mu_mc_se / row.q:.2g}",
                    _percent(row.mu_printed / row.mu_mc),
                    f"{row.mu_adapted / row.q:.4g} ± {row.mu_adapted_se / row.q:.2g}",
                    _percent(row.mu_printed / row.mu_adapted),
                )
                for row in rows
                if row.q == rows[0].q
            ],
        ),
        "",
        f"(q = {rows[0].q:g}; ± is one standard error.)",
        "",
    ]
    return "\n".join(lines)


def errata_page(gaps: Sequence[Gap], settings: str) -> str:
    """Words for the errata: each with its numbers, then the gap between the formula and Monte Carlo.

    Parameters
    ----------
    gaps : sequence of Gap
    settings : str
        One sentence that says how the runs were made.
    """
    lines = [
        "# Errata of the paper",
        "",
        "Slips in the print of *Stochastic response of a fractional vibroimpact system*. None changes its idea, and",
        "at Omega = 1, the only case it computes, none changes its final formula. In each table *computed* is found",
        "without the equation in question.",
        "",
        *(line for erratum in ERRATA for line in _section(erratum)),
        "![Mean square amplitude against the natural frequency](errata.png)",
        "",
        "The factor Omega of erratum 4, seen in Monte Carlo: the printed formula has the wrong trend.",
        "",
        "## How excellent the agreement is",
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
                    f"{gap.rest:.4g} ± {gap.rest_se:.2g}",
                    _percent(gap.formula / gap.rest),
                    f"{gap.adapted:.4g} ± {gap.adapted_se:.2g}",
                    _percent(gap.formula / gap.adapted),
                    f"{gap.twice_x:.4g}",
                    f"{gap.twice_v:.4g}",
                )
                for gap in gaps
            ],
        ),
        "",
        f"± is one standard error. {settings}",
        "The last two columns, of the adapted runs, are other readings of *amplitude squared*: averaging cannot tell",
        "them apart, the simulation can.",
        "",
    ]
    return "\n".join(lines)


def _section(erratum: Erratum) -> list[str]:
    findings = [
        (f.what, *(_number(value) for value in (f.computed, f.printed, f.corrected))) for f in erratum.check()
    ]
    return [
        f"## {erratum.number}. {erratum.title} ({erratum.equation})",
        "",
        erratum.statement.replace("|", "\\|"),
        "",
        *_table(("", "computed", "as printed", "corrected"), findings),
        "",
    ]


def _table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> list[str]:
    def line(cells: Sequence[str]) -> str:
        return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"

    return [line(header), line(["---"] * len(header)), *(line(row) for row in rows)]


def _number(value: float) -> str:
    """Five digits; what is only rounding is 0."""
    return f"{0.0 if abs(value) < 1e-8 else value:.5g}"


def _percent(ratio: float) -> str:
    return f"{100.0 * (ratio - 1.0):+.1f} %"
