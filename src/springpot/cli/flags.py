"""Flags of several commands, and their oscillator: per unit mass, or a device in SI units."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import fields, make_dataclass
from typing import TYPE_CHECKING, Annotated, Any, Literal, TypeAlias, get_args

from cyclopts import Group, Parameter

from springpot.cli.terminal import Whole
from springpot.machine.faults import listed
from springpot.problem.dimensionless import Dimensionless
from springpot.problem.spectral_density import DensityUnit, Excited, Sides
from springpot.simulation.plan.options import hints, words

if TYPE_CHECKING:
    from springpot.problem.system import System

_DEFAULT = Dimensionless().numbers
_PER_MASS = Group("Oscillator", sort_key=0)
MONTE_CARLO = Group("Monte Carlo", sort_key=2)
OUTPUT = Group("Output", sort_key=9)
_DEVICE = Group(
    "Device",
    help="A device in SI units, instead of the flags per unit mass above; --restitution and --free-side go with both.",
    sort_key=1,
)

_NEEDED = ("mass", "stiffness", "springpot", "psd", "psd_unit")
_DEVICE_ONLY = (*_NEEDED, "gap", "sides", "of")
_PER_MASS_ONLY = ("order", "coefficient", "natural_frequency", "intensity", "position")


def _flag(name: str, kind: Any, group: Group, words: str, **more: Any) -> tuple[str, Any, Any]:
    """A flag: None where it is not given."""
    return name, Annotated[kind | None, Parameter(group=group, negative="", help=words, **more)], None


def _state(_: object, tokens: Sequence[Any]) -> float | dict[str, float]:
    """A number, or numbers by point as ``a=0.01 b=-0.02``."""
    named = [token.value.rpartition("=") for token in tokens]
    try:
        if not any(equals for _, equals, _ in named) and len(named) == 1:
            return float(named[0][2])
        found = {point: float(value) for point, equals, value in named if point and equals}
    except ValueError:
        found = {}
    if len(found) < len(named):
        raise ValueError("must be a number, or of several masses as box=0.01 panel=-0.02, each once")
    return found


def named_numbers(form: str, *counts: int) -> dict[str, Any]:
    """What reads names, each with the numbers that follow it, as ``form`` says; so many numbers are right."""

    def read(_: object, tokens: Sequence[Any]) -> list[tuple[str, tuple[float, ...]]]:
        found: list[tuple[str, list[float]]] = []
        right = f"{tokens[0].keyword} must be {form}"
        words = [token.value for token in tokens]
        for word in words:
            try:
                number = float(word)
            except ValueError:
                found.append((word, []))
                continue
            if not found:
                raise ValueError(f"{right}, and begin with the name, not with {word}.")
            found[-1][1].append(number)
        if any(len(numbers) not in counts for _, numbers in found):
            raise ValueError(f"{right}, not {' '.join(words)}.")
        return [(name, (*numbers,)) for name, numbers in found]

    return {"converter": read, "n_tokens": -1, "consume_multiple": (1, None), "negative": "", "metavar": form}


RAINFLOW = named_numbers("NAME EXPONENT STRENGTH [CYCLES]", 2, 3)


def _flags_class(name: str, flags: Iterable[tuple[str, Any, Any]]) -> Any:
    return make_dataclass(name, flags, frozen=True, kw_only=True, namespace={"__module__": __name__})


_NUMBERS = {
    "order": "Order alpha of the derivative, 0 (spring) to 1 (dashpot).",
    "coefficient": "Coefficient C of the springpot per unit mass, in s^(alpha-2).",
    "natural_frequency": "Natural frequency Omega, in rad/s.",
    "intensity": "Intensity q of the white noise, in m^2 s^-3.",
    "position": "Position b of the wall, in m.",
    "restitution": "Speed after an impact / speed before it, from 0 to 1.",
}
_WALL = Parameter(
    name="--barrier", negative="--no-barrier", group=_PER_MASS, show_default=False,
    help="With a wall (the default), or without.",
)  # fmt: skip
OscillatorFlags = _flags_class("OscillatorFlags", (
    *(_flag(name, float, _PER_MASS, words, show_default=str(_DEFAULT[name])) for name, words in _NUMBERS.items()),
    _flag("free_side", Literal["above", "below"], _PER_MASS, "Side of the wall on which the mass moves.",
          show_default="that of x = 0"),
    ("barrier", Annotated[bool, _WALL], True),
    _flag("mass", float, _DEVICE, "Mass m, in kg."),
    _flag("stiffness", float, _DEVICE, "Stiffness k of the spring, without the springpot, in N/m."),
    _flag("springpot", tuple[float, float], _DEVICE,
          "Order and k_alpha of the springpot, in N s^order/m; for a dashpot c in N s/m give 1 c.",
          metavar="ORDER K_ALPHA"),
    _flag("gap", float, _DEVICE,
          "Distance from equilibrium to the stop, in m; a negative gap is a preload; no stop if not given."),
    _flag("psd", float, _DEVICE, "Spectral density of the excitation."),
    _flag("psd_unit", DensityUnit, _DEVICE, "Unit of --psd: of the base's acceleration, or of the force on the mass."),
    _flag("sides", Sides, _DEVICE,
          "1: --psd is one-sided (positive frequencies only), as test equipment states it; 2: two-sided.",
          show_default="1"),
    _flag("of", Excited, _DEVICE, "What --psd describes; follows from --psd-unit and must agree with it."),
))  # fmt: skip
"""The oscillator's numbers."""


def _oscillator(flags: Any) -> System:
    from springpot.problem.oscillator import Oscillator  # here, so that the help is quick

    given = {name: value for name, value in vars(flags).items() if value is not None}
    device, per_mass, both = (
        {name: given[name] for name in names if name in given}
        for names in (_DEVICE_ONLY, _PER_MASS_ONLY, ("restitution", "free_side"))
    )
    if not device:
        return Oscillator.from_numbers(**per_mass, **both, barrier=flags.barrier)
    if per_mass:
        raise ValueError(
            f"Either a device ({_flags(device)}) or an oscillator per unit mass ({_flags(per_mass)}) can be given, "
            "not both."
        )
    if not flags.barrier and "gap" in device:
        raise ValueError("--no-barrier cannot be combined with --gap: there is no wall.")
    if missing := [name for name in _NEEDED if name not in device]:
        raise ValueError(f"{_flags(missing)} must be given too: a device needs {_flags(_NEEDED)}.")
    return Oscillator.from_device(**device, **both)


def in_flags(sentence: str) -> str:
    """A sentence of the library with flags instead of arguments."""
    names = [field.name for group in (OscillatorFlags, RunFlags) for field in fields(group)]
    flags = {name: f"--{name.replace('_', '-')}" for name in (*names, "out", "overwrite", "plot")}
    sentence = sentence.replace("barrier = false", "--no-barrier")
    any_flag = "|".join(flags)
    sentence = re.sub(rf"(?<![\w-])({any_flag})=True\b", lambda match: flags[match[1]], sentence)
    given = rf"(?<![\w-])({any_flag})=(['\"]?)([\w/+.-]*\w)\2"
    sentence = re.sub(given, lambda match: f"{flags[match[1]]} {match[3]}", sentence)
    # in the middle of a sentence, only those names that are no English words
    alone = "|".join(name for name in flags if "_" in name or name in ("rtol", "quantities"))
    sentence = re.sub(rf"(?<![\w-])({alone})\b(=(?!\S))?", lambda match: flags[match[1]], sentence)
    first, space, rest = sentence.partition(" ")
    # a wall at some place is a part, whose name may be that of an argument
    return sentence if rest.startswith("at ") else flags.get(first, first) + space + rest


def _flags(names: Iterable[str]) -> str:
    return listed([f"--{name.replace('_', '-')}" for name in names])


STANDARD = OscillatorFlags()
Threads = Annotated[Whole | None, Parameter(help=words("threads"))]


def _toml_file(_: object, tokens: Sequence[Any]) -> str:
    """The place of a TOML file; another word is one too many."""
    word: str = tokens[0].value
    if not word.endswith(".toml"):
        raise ValueError("the file of a system must end with .toml")
    return word


def _read(words: str, **more: Any) -> Parameter:
    words = f"A system of parts, in a file that ends with .toml{words}"
    return Parameter(metavar="FILE", converter=_toml_file, help=words, **more)


def written(words: str) -> Parameter:
    """A file that a command writes."""
    return Parameter(group=OUTPUT, metavar="FILE", help=words)


def monte_carlo(words: str) -> Parameter:
    """A flag of the simulation."""
    return Parameter(group=MONTE_CARLO, help=words)


def repeated(metavar: str, words: str, **more: Any) -> Parameter:
    """A flag with a name and what is said of it, which may be given for several names."""
    return Parameter(negative="", metavar=metavar, help=words, **more)


def names(words: str) -> Parameter:
    """A flag with the names of some results."""
    return Parameter(negative="", consume_multiple=True, metavar="NAME ...", help=words)


Overwrite = Annotated[bool, Parameter(group=OUTPUT, negative="", help="Replace FILE if it exists.")]
_INSTEAD = ", instead of the flags below."
SystemFile = Annotated[str | None, _read(_INSTEAD, group=_PER_MASS)]
_LIMITED = (
    f"{_INSTEAD}  Here it must be an oscillator: a linear spring, one springpot or dashpot, at most one rigid wall, "
    "and white noise."
)
OscillatorFile = Annotated[str | None, _read(_LIMITED, group=_PER_MASS)]
PageFile = Annotated[str | None, _read(": a slider for each number.  An oscillator if left out.")]


def problem_of(file: str | None, flags: Any) -> System:
    """The problem of a command: the system in a file, or the oscillator of the flags."""
    if file is None:
        return _oscillator(flags)
    if flags != STANDARD:
        raise ValueError(f"FILE {file!r} states the problem: no flag of the oscillator can be given with it.")
    from springpot.problem.file import read_system

    return read_system(file)


_STATE: Any = {"converter": _state, "n_tokens": -1, "consume_multiple": True, "metavar": "NUMBER | POINT=NUMBER ..."}
_QUANTILES = "Also print quantiles of x, v, amplitude and impact speed, and of the extremes of each path."
RunFlags = _flags_class("RunFlags", (
    _flag("rtol", float, MONTE_CARLO,
          "Total relative error to reach, such as 0.01.  Paths, duration, step, window and start are then "
          "chosen; of this group only --quantities, --max-time, --seed and --threads can be given with it."),
    _flag("quantities", list[str], MONTE_CARLO,
          "With --rtol: the results that must reach it; amplitude_mean_square if not given, and with several masses "
          "all mean square displacements and velocities.",
          consume_multiple=True, metavar="NAME ..."),
    _flag("max_time", float, MONTE_CARLO,
          "With --rtol: seconds, with those of compilation, after which the run stops and keeps what it has reached."),
    *(_flag(name, Whole if int in get_args(get_args(hint)[0]) else get_args(hint)[0], MONTE_CARLO, words(name),
            **_STATE if name.startswith("initial_") else {"metavar": "START END" if name == "window" else None})
      for name, hint in hints("record", "record_every").items()),  # these two belong to the file
    ("distributions", Annotated[bool, Parameter(group=MONTE_CARLO, negative="", help=_QUANTILES)], False),
    ("first_passage", Annotated[list[tuple[str, tuple[float, ...]]] | None, Parameter(
        group=MONTE_CARLO, **named_numbers("NAME LEVEL, or NAME LOW HIGH", 1, 2),
        help="Time at which NAME first passes LEVEL, or leaves the interval from LOW to HIGH: x, distance (|x|) or "
             "amplitude in m, v or speed (|v|) in m/s, energy in m^2/s^2; can be repeated, also for levels of one NAME."
             "  With several masses box_x, box_distance, box_v, box_speed, panel_box_elongation or "
             "panel_box_distance; or a name of --forces.  Time counts from the start of the window; from rest from "
             "0.")], None),
    ("rainflow", Annotated[list[tuple[str, tuple[float, ...]]] | None, Parameter(
        group=MONTE_CARLO, **RAINFLOW,
        help="Also count the cycles of NAME, and their damage per hour by Basquin's curve, N = CYCLES "
             "(STRENGTH / amplitude)^EXPONENT, with CYCLES 1 if not given: x, with several masses box_x or "
             "mount_elongation, or a name of --forces, with STRENGTH in its unit; can be repeated, also for curves of "
             "one NAME.")], None),
    _flag("slowest_counted_impact", float, MONTE_CARLO,
          "A speed in m/s: also count the impacts that are not slower, which can be done where the rate of all "
          "impacts is infinite."),
    _flag("profile", list[float], MONTE_CARLO,
          "Also means, mean squares, impacts and powers in so many bins of time, such as 25, or between these times in "
          "s, such as 0 5 10.",
          consume_multiple=True, metavar="COUNT | TIME ..."),
    _flag("forces", list[str], MONTE_CARLO,
          "Also mean and mean square of these forces and absolute accelerations: PART_force, force_on_ground, "
          "acceleration (with several masses POINT_acceleration), and of soft contacts PART_peak_force; with "
          "--distributions, --profile and --record these of them too.", consume_multiple=True, metavar="NAME ..."),
    _flag("record", Whole, OUTPUT, "Number of paths whose x and v are saved in FILE at every step; 0 if not given."),
    _flag("record_every", Whole, OUTPUT, "With --record: steps between two saved points; 1 if not given."),
))  # fmt: skip
AS_USUAL = RunFlags()

if TYPE_CHECKING:
    Flags: TypeAlias = Any
    RunSettings: TypeAlias = Any
else:
    Flags, RunSettings = (Annotated[kind, Parameter(name="*")] for kind in (OscillatorFlags, RunFlags))
