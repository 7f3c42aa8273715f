"""A problem of the page as text to copy: the same run as a command, and as a Python program."""

from __future__ import annotations

from springpot.explorer.protocol import Problem

__all__ = ["as_command", "as_python"]


def as_command(problem: Problem) -> str:
    """The command `springpot simulate` that gives the page's numbers.

    Examples
    --------
    >>> as_command(Problem(wall=False, seed=3))
    'springpot simulate --order 0.5 --coefficient 1.0 --natural-frequency 1.0 --intensity 1.0 --no-barrier \
--paths 10000 --seed 3'
    """
    wall = f"--position {problem.position!r} --restitution {problem.restitution!r}" if problem.wall else "--no-barrier"
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
    wall = f"sp.Barrier(position={problem.position!r}, restitution={problem.restitution!r})"
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
