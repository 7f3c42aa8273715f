"""The command of `springpot.exceedance`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from springpot.cli.commands import by_name, tell, warn
from springpot.cli.flags import (
    MONTE_CARLO,
    STANDARD,
    Flags,
    SystemFile,
    Threads,
    monte_carlo,
    problem_of,
    repeated,
    written,
)
from springpot.cli.terminal import Json, Whole, check_picture, print_json
from springpot.machine.bar import Bar
from springpot.machine.interrupt import leave_at_once

_LEVELS = repeated(
    "NAME LEVEL",
    "Level of x, distance (|x|) or amplitude in m, of v, speed or impact_speed in m/s, of energy in m^2/s^2, of a "
    "force or an acceleration; can be repeated.",
    group=MONTE_CARLO,
)
_PROBABILITY = repeated(
    "NAME PROBABILITY",
    "In place of levels: the level that is exceeded with this probability is found; 'x below' of one that is exceeded "
    "downwards; can be repeated.",
    group=MONTE_CARLO,
)
_RETURN_PERIOD = repeated(
    "NAME SECONDS",
    "In place of levels: the level that is exceeded once in this time is found; can be repeated.",
    group=MONTE_CARLO,
)


def exceedance(
    file: SystemFile = None,
    /,
    *,
    flags: Flags = STANDARD,
    levels: Annotated[list[tuple[str, float]] | None, _LEVELS] = None,
    probability: Annotated[list[tuple[str, float]] | None, _PROBABILITY] = None,
    return_period: Annotated[list[tuple[str, float]] | None, _RETURN_PERIOD] = None,
    duration: Annotated[float | None, monte_carlo("The time, in s; may be left out with return periods.")] = None,
    rtol: Annotated[float, monte_carlo("Standard error of each probability, relative to it.")] = 0.1,
    start: Annotated[
        Literal["stationary", "rest"] | None, monte_carlo("stationary where there is a stationary state, if not given.")
    ] = None,
    step: Annotated[float | None, monte_carlo("Time step, in s.")] = None,
    seed: Annotated[Whole, monte_carlo("Seed of the random numbers.")] = 1,
    threads: Threads = None,
    max_time: Annotated[
        float | None,
        monte_carlo("Seconds after which it ends, with those of compilation; levels not reached have an upper bound."),
    ] = None,
    save: Annotated[
        str | None, written("File of the repetitions that have ended; the same command goes on from them.")
    ] = None,
    plot: Annotated[str | None, written("PNG file for levels against return periods, a panel for each name.")] = None,
    json_: Json = False,
) -> int:
    """Probabilities of rare events; its help is in `springpot.cli.commands`."""
    problem = problem_of(file, flags)
    check_picture(plot)
    with leave_at_once():
        from springpot.problem.free_numbers import uncertain_numbers
        from springpot.simulation.rare.exceedance import exceeded, hint_of

    asked, sought, often = (None if given is None else by_name(given) for given in (levels, probability, return_period))
    if uncertain_numbers(problem):
        for name, word in ((sought, "probability"), (often, "return_period"), (save, "save"), (plot, "plot")):
            if name is not None:
                raise ValueError(f"{word} cannot be given where numbers of the system are uncertain.")
        from springpot.scattering.exceedance import exceeded_by_devices

        with Bar("splitting paths of devices") as bar:
            over_devices = exceeded_by_devices(
                problem, asked, duration=duration, rtol=rtol, start=start, step=step, seed=seed, threads=threads,
                max_time=max_time, progress=bar,
            )  # fmt: skip
        warn(*over_devices.warnings)
        return tell(over_devices, json_)
    hint = hint_of(problem, asked or sought or often or {}, "--max-time ends it earlier", "springpot theory --levels")
    with Bar("splitting paths", first="simulating", hint=hint) as bar:
        found = exceeded(
            problem, asked, probability=sought, return_period=often, duration=duration, rtol=rtol, start=start,
            step=step, seed=seed, threads=threads, max_time=max_time, save=save, progress=bar,
        )  # fmt: skip
    warn(*found.warnings)
    if json_:
        print_json(found.to_dict())
    else:
        print("\n".join(map(str, [*found.level.values(), *found.curves.values()])))
    if plot is not None:
        from springpot.figures import style
        from springpot.figures.passages import plot_return_periods

        figure, panels = style.new_grid(5.6, 3.8 * len(found.curves), len(found.curves), 1)
        for curve, ax in zip(found.curves.values(), panels, strict=True):
            plot_return_periods(curve, ax)
        style.save(figure, Path(plot))
    lacking = {"rare_not_known", "level_not_reached", "level_not_found"}
    return int(any(sentence.name in lacking for sentence in found.warnings))
