"""A problem of the page as text to copy: the same run as a command, and as a Python program."""

from __future__ import annotations

import re

from springpot.explorer.protocol import Problem, SystemProblem
from springpot.machine.faults import listed
from springpot.problem.parts import RecordedExcitation
from springpot.problem.system import System

__all__ = ["as_command", "as_python", "command_of_system", "python_of_system"]


def as_command(problem: Problem) -> str:
    """The command `springpot simulate` that gives the page's numbers.

    Examples
    --------
    >>> as_command(Problem(wall=False, seed=3))
    'springpot simulate --order 0.5 --coefficient 1.0 --natural-frequency 1.0 --intensity 1.0 --no-barrier \
--paths 10000 --seed 3'
    """
    place = f"--position {problem.position!r}{' --side above' if problem.position > 0.0 else ''}"
    wall = f"{place} --restitution {problem.restitution!r}" if problem.wall else "--no-barrier"
    return (
        f"springpot simulate --order {problem.order!r} --coefficient {problem.coefficient!r} "
        f"--natural-frequency {problem.natural_frequency!r} --intensity {problem.intensity!r} {wall} "
        f"--paths {problem.paths} --seed {problem.seed}{' --start rest' if problem.start == 'rest' else ''}"
    )


def as_python(problem: Problem) -> str:
    """A program that prints the page's <A^2> by Monte Carlo and by all analytical methods.

    Examples
    --------
    >>> as_python(Problem()).splitlines()[0]
    'import springpot as sp'
    """
    side = ', side="above"' if problem.position > 0.0 else ""
    wall = f"sp.Barrier(position={problem.position!r}, restitution={problem.restitution!r}{side})"
    start = ', start="rest"' if problem.start == "rest" else ""  # stationary where possible is the default
    return f"""\
import springpot as sp

oscillator = sp.Oscillator(
    natural_frequency={problem.natural_frequency!r},
    springpot=sp.Springpot(order={problem.order!r}, coefficient={problem.coefficient!r}),
    barrier={wall if problem.wall else None},
    excitation=sp.WhiteNoise(intensity={problem.intensity!r}),
)
run = sp.simulate(oscillator, paths={problem.paths}, seed={problem.seed}{start})
value, error = float(run["amplitude_mean_square"]), float(run["amplitude_mean_square_se"])
print(f"Monte Carlo: <A^2> = {{value:.5g}} +- {{error:.2g}} m2")
answers, statements = sp.theory.solve_all(oscillator)
for method, answer in answers.items():
    print(f"{{method}}: <A^2> = {{answer.amplitude_mean_square:.5g}} m2")
for method, statement in statements.items():
    print(f"{{method}}: {{statement}}")
"""


def command_of_system(file: str, asked: SystemProblem) -> str:
    """The command that gives the page's numbers, with the system's file.

    Examples
    --------
    >>> command_of_system("device.toml", SystemProblem(kind="system", seed=3))
    'springpot simulate device.toml --paths 10000 --seed 3'
    """
    start = " --start rest" if asked.start == "rest" else ""
    return f"springpot simulate {file} --paths {asked.paths} --seed {asked.seed}{start}"


def python_of_system(system: System, file: str, asked: SystemProblem) -> str:
    """A program that prints the page's numbers, and those of all analytical methods.

    A system with a record is read from its file, for a record is long.

    Examples
    --------
    >>> from springpot.problem.parts import Spring
    >>> python_of_system(System(Spring(2.0)), "device.toml", SystemProblem(kind="system")).splitlines()[3]
    '    spring=sp.Spring(stiffness=2.0),'
    """
    start = ', start="rest"' if asked.start == "rest" else ""
    if system.with_functions:
        made = f"system = ...  # as it was given to sp.explore: {listed(system.with_functions)} cannot be written down"
    elif system.of(RecordedExcitation):
        made = f'system = sp.read_system("{file}")'
    else:
        parts = "\n".join(f"    {name}={_made(part)}," for name, part in system.named())
        made = f"system = sp.System(\n{parts}\n)"
    return f"""\
import springpot as sp

{made}
run = sp.simulate(system, paths={asked.paths}, seed={asked.seed}{start})
for name, value in run.values.items():
    print(f"{{name}}: {{value:.5g}} +- {{run.errors[name]:.2g}}")
answers, statements = sp.theory.solve_all(system)
for method, answer in answers.items():
    print(f"{{method}}: <x^2> = {{answer.x_mean_square:.5g}} m2")
for method, statement in statements.items():
    print(f"{{method}}: {{statement}}")
"""


def _made(part: object) -> str:
    """A part as a program makes it; parts of a part too."""
    return re.sub(r"\b([A-Z][A-Za-z]+|free)\(", r"sp.\1(", repr(part))
