"""The commands of `springpot.designing` and `springpot.scattering`: each calls the library and prints."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Annotated

from cyclopts import Group, Parameter

from springpot.cli.commands import place_of, tell, warn
from springpot.cli.flags import (
    MONTE_CARLO,
    STANDARD,
    Flags,
    Overwrite,
    SystemFile,
    Threads,
    monte_carlo,
    names,
    problem_of,
    repeated,
    written,
)
from springpot.cli.terminal import Json, Whole, check_picture
from springpot.machine.bar import Bar
from springpot.machine.faults import with_error
from springpot.machine.interrupt import leave_at_once

_WISHES = Group("What is asked for", sort_key=1)


def _limit(which: str) -> Parameter:
    words = f"A result with its {which} limit; over devices such as impact_rate_quantile_0.95; may be repeated."
    return repeated("NAME LIMIT", words, group=_WISHES)


def sensitivity(
    file: SystemFile = None,
    /,
    *,
    flags: Flags = STANDARD,
    quantities: Annotated[list[str], names("Such as impact_rate.")],
    method: Annotated[
        str | None, Parameter(help='"theory", "monte_carlo" or the name of a method; the recommended one if not given.')
    ] = None,
    paths: Annotated[Whole, Parameter(help="Of each run by Monte Carlo.")] = 5000,
    seed: Annotated[Whole, Parameter(help="Seed of the random numbers.")] = 1,
    plot: Annotated[str | None, written("PNG file for a chart of bars.")] = None,
    json_: Json = False,
) -> int:
    """How much each result changes with each number; its help is in `springpot.cli.commands`."""
    problem = problem_of(file, flags)
    check_picture(plot)
    with leave_at_once():
        from springpot.designing import sensitivity as find

    with Bar("changing each number") as bar:
        found = find(problem, quantities, method=method, paths=paths, seed=seed, progress=bar)
    warn(*found.warnings)
    if plot is not None:
        from springpot.figures.designing import plot_sensitivities
        from springpot.figures.style import save

        save(plot_sensitivities(found), Path(plot))
    return tell(found, json_, plot)


def design(
    file: Annotated[
        str,
        Parameter(
            help='System file with free numbers, such as coefficient = { free = "c", start = 2, low = 0.5, high = 50 }.'
        ),
    ],
    /,
    *,
    minimize: Annotated[
        str | None, Parameter(group=_WISHES, metavar="NAME", help="The result or free number that is to be least.")
    ] = None,
    maximize: Annotated[
        str | None, Parameter(group=_WISHES, metavar="NAME", help="In place of --minimize: what is to be greatest.")
    ] = None,
    below: Annotated[list[tuple[str, float]] | None, _limit("upper")] = None,
    above: Annotated[list[tuple[str, float]] | None, _limit("lower")] = None,
    probability: Annotated[float, Parameter(group=_WISHES, help="With which all limits must hold.")] = 0.99,
    method: Annotated[
        str | None,
        Parameter(help='Of the search: "monte_carlo" or the name of a method; a trusted and quick one if not given.'),
    ] = None,
    rtol: Annotated[float, monte_carlo("Relative error of the limited results in the first run.")] = 0.02,
    cost_rtol: Annotated[
        float,
        monte_carlo(
            "By how much the distance to the limits may raise the cost; later runs are as precise as this needs."
        ),
    ] = 0.02,
    max_time: Annotated[float | None, monte_carlo("Seconds after which the search ends with the best so far.")] = None,
    seed: Annotated[Whole, monte_carlo("Seed of the random numbers.")] = 1,
    threads: Annotated[Threads, Parameter(group=MONTE_CARLO)] = None,
    out: Annotated[str | None, written("Write the system with the chosen values to a file.")] = None,
    plot: Annotated[str | None, written("PNG file for the least cost against the first limit.")] = None,
    overwrite: Overwrite = False,
    json_: Json = False,
) -> int:
    """The free numbers of a system chosen; its help is in `springpot.cli.commands`."""
    check_picture(plot)
    if (minimize is None) == (maximize is None):
        raise ValueError(f"{'only ' if minimize else ''}one of --minimize and --maximize must be given.")
    if plot is not None and not below and not above:
        raise ValueError("--plot needs a limit, --below or --above.")
    place = place_of(out, overwrite)
    limits: dict[str, tuple[float | None, float | None]] = {}
    for side, pairs in (("above", above), ("below", below)):
        for name, limit in pairs or ():
            low, high = limits.get(name, (None, None))
            if (low if side == "above" else high) is not None:
                raise ValueError(f"--{side} must be given only once for {name}.")
            limits[name] = (limit, high) if side == "above" else (low, limit)
    with leave_at_once():
        from springpot.designing import design as find
        from springpot.problem.file import read_system, to_toml
        from springpot.problem.free_numbers import with_values

    system = read_system(file)
    try:
        with Bar("designing", first="searching") as bar:
            found = find(
                system, minimize, limits, maximize=maximize, seed=seed, rtol=rtol, cost_rtol=cost_rtol,
                probability=probability, method=method, max_time=max_time, threads=threads, progress=bar,
            )  # fmt: skip
    except ValueError as fault:  # in the words of the command
        said = str(fault).replace("subject_to", "--below and --above")
        raise ValueError(re.sub(r"\b(minimize|maximize)\b", r"--\1", said)) from fault
    warn(*found.warnings)
    if place is not None:
        place.write_text(to_toml(with_values(system, found.values)), encoding="utf-8")
    if plot is not None:
        from springpot.figures.designing import plot_design_curve
        from springpot.figures.style import new_figure, save

        figure, (axes,) = new_figure(5.6, 3.8)
        plot_design_curve(found.curve(), found, axes)
        save(figure, Path(plot))
    units = found.units
    rows = [[name, with_error(value, found.errors[name], units[name])] for name, value in found.quantities.items()]
    return tell(found, json_, place, plot, table=[["by Monte Carlo", "value +- error"], *rows])


def scatter(
    file: Annotated[
        str,
        Parameter(
            help='System file with uncertain numbers, such as stiffness = { uncertain = "k", value = 80, cov = 0.05 }.'
        ),
    ],
    /,
    *,
    quantities: Annotated[list[str] | None, names("Such as impact_rate; all if not given.")] = None,
    limit: Annotated[
        list[tuple[str, float]] | None,
        repeated("NAME LIMIT", "The share of the devices above it is told; may be repeated."),
    ] = None,
    method: Annotated[str, Parameter(help='"monte_carlo", or the name of a method of theory.')] = "monte_carlo",
    devices: Annotated[Whole, monte_carlo("How many are drawn: a power of two.")] = 1024,
    paths: Annotated[Whole, monte_carlo("Of each device: a power of two.")] = 8,
    duration: Annotated[float | None, monte_carlo("Time simulated, in s.")] = None,
    step: Annotated[float | None, monte_carlo("Time step, in s.")] = None,
    seed: Annotated[Whole, monte_carlo("Seed of the random numbers.")] = 1,
    threads: Annotated[Threads, Parameter(group=MONTE_CARLO)] = None,
    plot: Annotated[str | None, written("PNG file for a picture of the first quantity.")] = None,
    json_: Json = False,
) -> int:
    """How results differ from device to device; its help is in `springpot.cli.commands`."""
    check_picture(plot)
    with leave_at_once():
        from springpot.problem.file import read_system
        from springpot.scattering import scatter as find

    system = read_system(Path(file))
    with Bar("simulating devices") as bar:
        found = find(
            system, quantities, devices=devices, paths=paths, duration=duration, step=step, limits=dict(limit or ()),
            method=method,
            seed=seed, threads=threads, progress=bar,
        )  # fmt: skip
    warn(*found.warnings)
    if plot is not None:
        from springpot.figures.designing import plot_scatter
        from springpot.figures.style import save

        save(plot_scatter(found), Path(plot))
    return tell(found, json_, plot)
