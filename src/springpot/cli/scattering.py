"""The command of `springpot.scattering`: it calls the library and prints."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from springpot.cli.commands import tell, warn
from springpot.cli.flags import MONTE_CARLO, Threads, monte_carlo, names, repeated, written
from springpot.cli.terminal import Json, Whole, check_picture
from springpot.machine.bar import Bar
from springpot.machine.interrupt import leave_at_once


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
