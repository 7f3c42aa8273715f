"""The study file that `springpot study new` writes."""

from __future__ import annotations

import json

from springpot.machine.arguments import Uncertain
from springpot.problem.free_numbers import nominal
from springpot.problem.numbers import numbers_of, unit_of, with_numbers
from springpot.problem.system import System
from springpot.studies.columns import scalars_of
from springpot.studies.tables import SIMULATED
from springpot.theory.registry import METHODS
from springpot.theory.result import MOMENTS
from springpot.theory.solve import solve_one

_TRIED = "linear", "envelope", "linearization"  # quick, and for most systems; in the file where they have an answer

TEMPLATE = """\
# A study: a grid of {kind}, each computed by every method below.{takes}
#     springpot study check {file}
#     springpot study run {file} --store {store}
#     springpot study plot {store} --out {picture}
#     springpot study export {store} {table}
name = {name}
seed = 1             # every point's own seed is made from this and the point's numbers
{system}# methods: METHODS
methods = [{methods}]
# {quantities}
quantities = {chosen}  # what rtol controls and charts show; the store keeps them all

{fixed}[axes]               # the grid is the product of the axes; they can be extended later
{axes}

# [zipped.case]      # columns that vary together, along one axis with a name of your own
{zipped}
[monte_carlo]        # one of
{monte_carlo}
# first_passage.{level} = [2.0, 3.0]        # with paths: levels whose first passages are wanted

# [exceedance]       # with the method "exceedance": rare events, by splitting of paths
# duration = 10.0    # s
# rtol = 0.3         # relative standard error of each probability
# levels.{level} = {{linspace = [2.0, 4.0, 5]}}
""".replace("METHODS", ", ".join((*METHODS, *SIMULATED)))

OF_OSCILLATORS = {
    "level": "x",
    "kind": "oscillators",
    "takes": "  It takes ten seconds.",
    "system": "",
    "methods": '"averaging", "envelope", "monte_carlo"',
    "quantities": ", ".join(MOMENTS),
    "chosen": '["amplitude_mean_square", "impact_rate"]',
    "fixed": """\
[fixed]              # the same at every point; these values are also the defaults
coefficient = 1.0    # C, s^(alpha-2)
natural_frequency = 1.0  # Omega, rad/s
intensity = 1.0      # q, m^2/s^3
position = 0.0       # b, m
free_side = "above"  # of the wall, where the mass moves
barrier = true       # false: no wall

""",
    "axes": """\
order = {linspace = [0.2, 1.0, 9]}      # start, end, count; or geomspace = [start, end, count]
restitution = [1.0, 0.9, 0.7]            # or a plain list""",
    "zipped": "# coefficient = [0.1, 0.5]\n# natural_frequency = [1.0, 2.0]\n",
    "monte_carlo": """\
rtol = 0.03          #   the total relative error of the quantities, or
# paths = 5000       #   the settings of a run: paths, duration, step, window, scheme, start = "rest", ...""",
}
"""What the file says of the paper's oscillator."""


def of_system(device: System, place: str) -> dict[str, str]:
    """What the file says of a system: methods, quantities, and an axis for each number, of which the first is in use.

    Examples
    --------
    >>> from springpot.problem.parts import Barrier, Spring, WhiteNoise
    >>> words = of_system(System(Spring(80.0), Barrier(-0.02), WhiteNoise(0.02)), "device.toml")
    >>> print(words["axes"])
    parts.spring.stiffness = [64.0, 80.0]  # s-2
    # parts.barrier.position = [-0.02]  # m
    # parts.barrier.restitution = [1.0]
    # parts.white_noise.intensity = [0.02]  # m2 s-3
    >>> words["methods"]  # nothing dissipates, so no theory has an answer
    '"monte_carlo"'
    """
    scatters = [name for name, value in numbers_of(device).items() if isinstance(value, Uncertain)]
    device = nominal(device)
    numbers = {name: float(value) for name, value in numbers_of(device).items() if name not in scatters}
    usable = [name for name in numbers if _varies(device, name)]
    heavy = {name for name, part in device.named() if "inertia" in part.powers}
    first = next((name for name in usable if name.split(".")[1] not in heavy), next(iter(usable), ""))
    lines = []
    for name, value in numbers.items():
        values = f"[{float(f'{0.8 * value:.12g}')!r}, {value!r}]" if name == first else f"[{value!r}]"
        unit = unit_of(device, name)
        lines.append(f"{'' if name == first else '# '}{name} = {values}" + (f"  # {unit}" if unit != "1" else ""))
    theories = [name for name in _TRIED if solve_one(device, name)[0] is not None]
    known = scalars_of(device)
    chosen = [name for name in known if name.endswith(("x_mean_square", "impact_rate"))]
    if "impact_rate" in chosen:  # of one mass: of all walls together
        chosen = ["x_mean_square", "impact_rate"]
    return {
        "kind": "systems",
        "level": f"{next(iter(device.coordinates.beginnings))}x",
        "takes": "",
        "system": f"system = {json.dumps(place, ensure_ascii=False)}    # its place, from this file\n"
        + ("draws = 64           # devices, by its uncertain numbers: the axis draw\n" if scatters else ""),
        "fixed": "",
        "axes": "\n".join(lines),
        "zipped": "",
        "quantities": ", ".join(known),
        "chosen": "[" + ", ".join(f'"{name}"' for name in chosen) + "]",
        "methods": ", ".join(f'"{name}"' for name in (*theories, "monte_carlo")),
        "monte_carlo": """\
paths = 1000         #   the settings of a run: paths, duration, step, window, start = "rest", ..., or
# rtol = 0.05        #   the total relative error of the quantities""",
    }


def _varies(device: System, name: str) -> bool:
    """Whether a number may also be a fifth smaller."""
    value = numbers_of(device)[name]
    try:
        with_numbers(device, {name: 0.8 * value})
    except ValueError:
        return False
    return value != 0.0
