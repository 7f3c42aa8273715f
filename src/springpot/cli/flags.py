"""Flags of several commands, and their oscillator: per unit mass, or a device in SI units."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence, Set
from dataclasses import dataclass, fields, make_dataclass
from typing import TYPE_CHECKING, Annotated, Any, Literal, get_args

from cyclopts import Group, Parameter

from springpot.cli.terminal import Whole
from springpot.machine.faults import listed
from springpot.problem.dimensionless import Dimensionless
from springpot.problem.spectral_density import DensityUnit, Excited, Sides
from springpot.simulation.plan.options import hints, words

if TYPE_CHECKING:
    from springpot.problem.system import System

__all__ = [
    "AS_USUAL", "MONTE_CARLO", "STANDARD", "Flags", "OscillatorFile", "OscillatorFlags", "PageFile", "RunSettings",
    "SystemFile",
    "Threads", "problem_of", "with_flags",
]  # fmt: skip

_DEFAULT = Dimensionless().numbers
_PER_MASS = Group("Oscillator", sort_key=0)
MONTE_CARLO = Group("Monte Carlo", sort_key=2)
_DEVICE = Group(
    "Device",
    help="A device in SI units, instead of the flags per unit mass above; --restitution and --side go with both.",
    sort_key=1,
)

_NEEDED = ("mass", "stiffness", "springpot", "psd", "psd_unit")
_DEVICE_ONLY = (*_NEEDED, "gap", "sides", "of")
_PER_MASS_ONLY = ("order", "coefficient", "natural_frequency", "intensity", "position")


@Parameter(name="*", group=_PER_MASS)
@dataclass(frozen=True, kw_only=True)
class OscillatorFlags:
    """The oscillator's numbers, as flags shared by the commands; None where a flag was not given."""

    order: Annotated[
        float | None,
        Parameter(
            help="Order alpha of the derivative, 0 (spring) to 1 (dashpot).", show_default=str(_DEFAULT["order"])
        ),
    ] = None
    coefficient: Annotated[
        float | None,
        Parameter(
            help="Coefficient C of the springpot per unit mass, in s^(alpha-2).",
            show_default=str(_DEFAULT["coefficient"]),
        ),
    ] = None
    natural_frequency: Annotated[
        float | None,
        Parameter(help="Natural frequency Omega, in rad/s.", show_default=str(_DEFAULT["natural_frequency"])),
    ] = None
    intensity: Annotated[
        float | None,
        Parameter(help="Intensity q of the white noise, in m^2 s^-3.", show_default=str(_DEFAULT["intensity"])),
    ] = None
    position: Annotated[
        float | None, Parameter(help="Position b of the wall, in m.", show_default=str(_DEFAULT["position"]))
    ] = None
    restitution: Annotated[
        float | None,
        Parameter(
            help="Speed after an impact / speed before it, in (0, 1].", show_default=str(_DEFAULT["restitution"])
        ),
    ] = None
    side: Annotated[
        Literal["above", "below"] | None,
        Parameter(help="Side of the wall on which the mass moves.", show_default="that of x = 0"),
    ] = None
    barrier: Annotated[
        bool,
        Parameter(
            name="--barrier",
            negative="--no-barrier",
            show_default=False,
            help="With a wall (the default), or without.",
        ),
    ] = True
    mass: Annotated[float | None, Parameter(group=_DEVICE, help="Mass m, in kg.")] = None
    stiffness: Annotated[
        float | None, Parameter(group=_DEVICE, help="Stiffness k of the spring, without the springpot, in N/m.")
    ] = None
    springpot: Annotated[
        tuple[float, float] | None,
        Parameter(
            group=_DEVICE,
            negative="",
            metavar="ORDER K_ALPHA",
            help="Order and k_alpha of the springpot, in N s^order/m; for a dashpot c in N s/m give 1 c.",
        ),
    ] = None
    gap: Annotated[
        float | None,
        Parameter(
            group=_DEVICE,
            help="Distance from equilibrium to the stop, in m; a negative gap is a preload; no stop if not given.",
        ),
    ] = None
    psd: Annotated[float | None, Parameter(group=_DEVICE, help="Spectral density of the excitation.")] = None
    psd_unit: Annotated[
        DensityUnit | None,
        Parameter(group=_DEVICE, help="Unit of --psd: of the base's acceleration, or of the force on the mass."),
    ] = None
    sides: Annotated[
        Sides | None,
        Parameter(
            group=_DEVICE,
            help="1: --psd is one-sided (positive frequencies only), as test equipment states it; 2: two-sided.",
            show_default="1",
        ),
    ] = None
    of: Annotated[
        Excited | None,
        Parameter(group=_DEVICE, help="What --psd describes; follows from --psd-unit and must agree with it."),
    ] = None

    def oscillator(self) -> System:
        from springpot.problem.oscillator import Oscillator  # here, so that the help is quick

        device, per_mass = self._given(_DEVICE_ONLY), self._given(_PER_MASS_ONLY)
        if not device:
            return Oscillator.from_numbers(**per_mass, **self._given(("restitution", "side", "barrier")))  # type: ignore[arg-type]
        if per_mass:
            raise ValueError(
                f"Either a device ({_flags(device)}) or an oscillator per unit mass ({_flags(per_mass)}) can be given, "
                "not both."
            )
        if not self.barrier and "gap" in device:
            raise ValueError("--no-barrier cannot be combined with --gap: there is no wall.")
        if missing := [name for name in _NEEDED if name not in device]:
            raise ValueError(f"{_flags(missing)} must be given too: a device needs {_flags(_NEEDED)}.")
        return Oscillator.from_device(**device, **self._given(("restitution", "side")))  # type: ignore[arg-type]

    def _given(self, names: Sequence[str]) -> dict[str, object]:
        return {name: value for name in names if (value := getattr(self, name)) is not None}


def with_flags(sentence: str, arguments: Set[str]) -> str:
    """A sentence of the library with flags instead of arguments."""
    names = {field.name for group in (OscillatorFlags, RunFlags) for field in fields(group)} | arguments
    flags = {name: f"--{name.replace('_', '-')}" for name in (*names, "plot")}
    sentence = sentence.replace("barrier = false", "--no-barrier")
    any_flag = "|".join(flags)
    sentence = re.sub(rf"(?<![\w-])({any_flag})=True\b", lambda match: flags[match[1]], sentence)
    given = rf"(?<![\w-])({any_flag})=(['\"]?)([\w/+.-]*\w)\2"
    sentence = re.sub(given, lambda match: f"{flags[match[1]]} {match[3]}", sentence)
    # in the middle of a sentence, only those names that are no English words
    alone = "|".join(name for name in flags if "_" in name or name in ("rtol", "quantities"))
    sentence = re.sub(rf"(?<![\w-])({alone})\b(=(?!\S))?", lambda match: flags[match[1]], sentence)
    first, space, rest = sentence.partition(" ")
    return flags.get(first, first) + space + rest


def _flags(names: Iterable[str]) -> str:
    return listed([f"--{name.replace('_', '-')}" for name in names])


STANDARD = OscillatorFlags()
Flags = Annotated[OscillatorFlags, Parameter(name="*")]
Threads = Annotated[Whole | None, Parameter(help=words("threads"))]


def _toml_file(_: object, tokens: Sequence[Any]) -> str:
    """The place of a TOML file; another word is one too many."""
    word: str = tokens[0].value
    if not word.endswith(".toml"):
        raise ValueError("the file of a system must end with .toml")
    return word


def _file(words: str) -> Parameter:
    return Parameter(group=_PER_MASS, metavar="FILE", converter=_toml_file, help=words)


SystemFile = Annotated[
    str | None, _file("A system of parts, in a file that ends with .toml, instead of the flags below.")
]
OscillatorFile = Annotated[
    str | None,
    _file(
        "A system of parts, in a file that ends with .toml, instead of the flags below.  Here it must be an "
        "oscillator: a linear spring, one springpot or dashpot, at most one rigid wall, and white noise."
    ),
]

PageFile = Annotated[
    str | None,
    Parameter(
        metavar="FILE",
        converter=_toml_file,
        help="A system of parts, in a file that ends with .toml: a slider for each number.  An oscillator if left out.",
    ),
]


def problem_of(file: str | None, flags: OscillatorFlags) -> System:
    """The problem of a command: the system in a file, or the oscillator of the flags."""
    if file is None:
        return flags.oscillator()
    if flags != STANDARD:
        raise ValueError(f"FILE {file!r} states the problem: no flag of the oscillator can be given with it.")
    from springpot.problem.file import read_system

    return read_system(file)


def _flag_of(name: str, hint: Any) -> tuple[str, Any, Any]:
    """A setting of a run as a flag: its type and its words."""
    kind, *_ = get_args(hint)
    metavar = "START END" if name == "window" else None
    parameter = Parameter(group=MONTE_CARLO, negative="", help=words(name), metavar=metavar)
    return name, Annotated[Whole | None if int in get_args(kind) else kind, parameter], None


if TYPE_CHECKING:
    RunFlags = Any
else:
    RunFlags = make_dataclass(
        "RunFlags",
        [_flag_of(*each) for each in hints("record", "record_every").items()],  # these two belong to the file
        frozen=True,
        kw_only=True,
        namespace={"__module__": __name__},
    )
AS_USUAL: Any = RunFlags()
RunSettings = Annotated[RunFlags, Parameter(name="*")]
