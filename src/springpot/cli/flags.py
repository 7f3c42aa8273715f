"""Flags that several commands share, and the oscillator that they state: per unit mass, or a device in SI units."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence, Set
from dataclasses import dataclass, fields
from typing import Annotated, Literal

from cyclopts import Group, Parameter

from springpot.device import DensityUnit, Excited, Sides
from springpot.faults import listed
from springpot.oscillator import Barrier, Oscillator, Springpot, WhiteNoise
from springpot.terminal import Whole

__all__ = ["STANDARD", "Flags", "OscillatorFlags", "Threads", "listed", "with_flags"]

_DEFAULT = Oscillator()
_WALL = Barrier()
_PER_MASS = Group("Oscillator", sort_key=0)
_DEVICE = Group(
    "Device",
    help="In SI units, instead of the flags per unit mass above; --restitution and --side go with both.",
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
            help="Order alpha of the derivative, 0 (spring) to 1 (dashpot).", show_default=str(_DEFAULT.springpot.order)
        ),
    ] = None
    coefficient: Annotated[
        float | None,
        Parameter(
            help="C of the springpot per unit mass, in s^(alpha-2).", show_default=str(_DEFAULT.springpot.coefficient)
        ),
    ] = None
    natural_frequency: Annotated[
        float | None, Parameter(help="Omega, in rad/s.", show_default=str(_DEFAULT.natural_frequency))
    ] = None
    intensity: Annotated[
        float | None,
        Parameter(help="Intensity q of the white noise, in m^2 s^-3.", show_default=str(_DEFAULT.excitation.intensity)),
    ] = None
    position: Annotated[
        float | None, Parameter(help="Place b of the wall, in m.", show_default=str(_WALL.position))
    ] = None
    restitution: Annotated[
        float | None,
        Parameter(help="Speed after an impact / speed before it, in (0, 1].", show_default=str(_WALL.restitution)),
    ] = None
    side: Annotated[
        Literal["above", "below"] | None,
        Parameter(help="Side of the wall on which the mass moves.", show_default=_WALL.side),
    ] = None
    barrier: Annotated[
        bool,
        Parameter(
            name="--barrier",
            negative="--no-barrier",
            show_default=False,
            help="With the wall (as by default), or without.",
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
            help="The springpot's order and its k_alpha, in N s^order/m; a dashpot c in N s/m is 1 c.",
        ),
    ] = None
    gap: Annotated[
        float | None,
        Parameter(
            group=_DEVICE,
            help="Distance from equilibrium to the stop, in m; negative: preload; no stop if not given.",
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
        Parameter(group=_DEVICE, help="What --psd is of; follows from --psd-unit and must agree with it."),
    ] = None

    def oscillator(self) -> Oscillator:
        device, per_mass = self._given(_DEVICE_ONLY), self._given(_PER_MASS_ONLY)
        if not device:
            return self._per_unit_mass()
        if per_mass:
            raise ValueError(
                f"Either a device ({_flags(device)}) or an oscillator per unit mass ({_flags(per_mass)}) can be given, "
                "not both."
            )
        if not self.barrier and "gap" in device:
            raise ValueError("--no-barrier leaves no wall for --gap to describe.")
        if missing := [name for name in _NEEDED if name not in device]:
            raise ValueError(f"{_flags(missing)} must be given too: a device needs {_flags(_NEEDED)}.")
        return Oscillator.from_device(**device, **self._given(("restitution", "side")))  # type: ignore[arg-type]

    def _given(self, names: Sequence[str]) -> dict[str, object]:
        return {name: value for name in names if (value := getattr(self, name)) is not None}

    def _per_unit_mass(self) -> Oscillator:
        given = self._given
        wall = Barrier(**given(("position", "restitution", "side")))  # type: ignore[arg-type]
        if not self.barrier and wall != _WALL:
            raise ValueError("--no-barrier leaves no wall for --position, --restitution or --side to describe.")
        springpot = {"order": _DEFAULT.springpot.order, "coefficient": _DEFAULT.springpot.coefficient}
        return Oscillator(
            **given(("natural_frequency",)),  # type: ignore[arg-type]
            springpot=Springpot(**springpot | given(("order", "coefficient"))),  # type: ignore[arg-type]
            barrier=wall if self.barrier else None,
            excitation=WhiteNoise(**given(("intensity",))),  # type: ignore[arg-type]
        )


def with_flags(sentence: str, arguments: Set[str]) -> str:
    """The library's sentences name arguments; in a command they are flags."""
    names = {field.name for field in fields(OscillatorFlags)} | arguments
    flags = {name: f"--{name.replace('_', '-')}" for name in names} | {
        "quantities": "--quantity",
        "record_every": "--every",
        "out": "--out",
        "plot": "--plot",
    }
    any_flag = "|".join(flags)
    sentence = re.sub(rf"(?<![\w-])({any_flag})=True\b", lambda found: flags[found[1]], sentence)
    given = rf"(?<![\w-])({any_flag})=(['\"]?)([\w/+.-]*\w)\2"
    sentence = re.sub(given, lambda found: f"{flags[found[1]]} {found[3]}", sentence)
    # in the middle of a sentence, only those names that are no English words
    alone = "|".join(name for name in flags if "_" in name or name in ("rtol", "quantities"))
    sentence = re.sub(rf"(?<![\w-])({alone})\b(=(?!\S))?", lambda found: flags[found[1]], sentence)
    first, space, rest = sentence.partition(" ")
    return flags.get(first, first) + space + rest


def _flags(names: Iterable[str]) -> str:
    return listed([f"--{name.replace('_', '-')}" for name in names])


STANDARD = OscillatorFlags()
Flags = Annotated[OscillatorFlags, Parameter(name="*")]
Threads = Annotated[Whole | None, Parameter(help="Number of threads; as many as this process may use if not given.")]
