"""A problem of the page as text to copy: the same run as a command, and as a Python program."""

from __future__ import annotations

import re

from springpot.explorer.protocol import Problem
from springpot.machine.faults import listed
from springpot.machine.files import shell_word
from springpot.problem.dimensionless import Dimensionless
from springpot.problem.free_numbers import uncertain_numbers
from springpot.problem.parts.checks import is_written_out
from springpot.problem.system import System


def command_of(file: str, papers: tuple[Dimensionless, ...], asked: Problem, *, differ: bool = False) -> str:
    """The command that gives the page's numbers, with the system's file, or with the flags of the paper's problem.

    What has no file and is not the paper's problem has to be saved first, and so has a system of which devices
    ``differ``: of it the command has the scatter.

    Examples
    --------
    >>> command_of("device.toml", (), Problem(seed=3))
    'springpot simulate device.toml --paths 10000 --seed 3'
    >>> command_of("", (Dimensionless(barrier=None),), Problem(paths=64))[:56]
    'springpot simulate --order 0.5 --coefficient 1.0 --natur'
    """
    if differ:
        return f"springpot scatter {shell_word(file or 'system.toml')} --seed {asked.seed}"
    what = shell_word(file) if file else next((_flags(paper) for paper in papers), "system.toml")
    start = " --start rest" if asked.start == "rest" else ""  # stationary where possible is the default
    return f"springpot simulate {what} --paths {asked.paths} --seed {asked.seed}{start}"


def _flags(paper: Dimensionless) -> str:
    numbers = paper.numbers
    wall = {name: numbers.pop(name) for name in ("position", "restitution", "free_side")}
    struck = numbers.pop("barrier")
    shown = numbers | (wall if struck else {"no-barrier": ""})
    return " ".join(f"--{name.replace('_', '-')} {value}".rstrip() for name, value in shown.items())


def python_of(system: System, file: str, asked: Problem) -> str:
    """A program that prints the page's numbers, and those of all analytical methods.

    A system with a record or another long table, or with uncertain numbers, is read from its file.

    Examples
    --------
    >>> from springpot.problem.parts import Spring
    >>> python_of(System(Spring(2.0)), "device.toml", Problem()).splitlines()[3]
    '    spring=sp.Spring(stiffness=2.0),'
    """
    start = ', start="rest"' if asked.start == "rest" else ""
    differ = bool(uncertain_numbers(system))
    if system.with_functions:
        made = f"system = ...  # as it was given to sp.explore: {listed(system.with_functions)} cannot be written down"
    elif differ:
        made = f"devices = sp.read_system({file!r})\nsystem = sp.nominal(devices)"
    elif system.records or not all(map(is_written_out, system.parts)):
        made = f"system = sp.read_system({file!r})"
    else:
        written = "\n".join(f"    {name}={part!r}," for name, part in system.stated())
        parts = re.sub(r"\b([A-Z][A-Za-z]+|free)\(", r"sp.\1(", written)  # parts of a part too
        made = f"system = sp.System(\n{parts}\n)"
    at = system.coordinates
    symbols = zip(at.beginnings, map(at.symbol, at.points), strict=True)
    said = ", ".join(f"<{x}^2> = {{answer.{own}x_mean_square:.5g}} m2" for own, x in symbols)
    scatter = f"print(sp.scatter(devices, seed={asked.seed}))\n" if differ else ""
    return f"""\
import springpot as sp

{made}
run = sp.simulate(system, paths={asked.paths}, seed={asked.seed}{start})
print(run)
answers, statements = sp.theory.solve_all(system)
for method, answer in answers.items():
    print(f"{{method}}: {said}")
for method, statement in statements.items():
    print(f"{{method}}: {{statement}}")
{scatter}"""
