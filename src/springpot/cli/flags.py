"""Flags that several commands share, and the oscillator that they state."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from cyclopts import Group, Parameter

from springpot.oscillator import Barrier, Oscillator, Springpot, WhiteNoise
from springpot.terminal import Whole

__all__ = ["STANDARD", "Flags", "OscillatorFlags", "Threads"]

_DEFAULT = Oscillator()
_WALL = Barrier()
_OSCILLATOR = Group("Oscillator", sort_key=0)


@Parameter(name="*", group=_OSCILLATOR)
@dataclass(frozen=True, kw_only=True)
class OscillatorFlags:
    """The oscillator's numbers, as flags shared by the commands."""

    order: Annotated[float, Parameter(help="Order alpha of the derivative, 0 (spring) to 1 (dashpot).")] = (
        _DEFAULT.springpot.order
    )
    coefficient: Annotated[float, Parameter(help="C of the springpot per unit mass, in s^(alpha-2).")] = (
        _DEFAULT.springpot.coefficient
    )
    natural_frequency: Annotated[float, Parameter(help="Omega, in rad/s.")] = _DEFAULT.natural_frequency
    intensity: Annotated[float, Parameter(help="Intensity q of the white noise, in m^2 s^-3.")] = (
        _DEFAULT.excitation.intensity
    )
    position: Annotated[float, Parameter(help="Place b of the wall, in m.")] = _WALL.position
    restitution: Annotated[float, Parameter(help="Coefficient r of the impacts, in (0, 1].")] = _WALL.restitution
    side: Annotated[Literal["above", "below"], Parameter(help="Side of the wall on which the mass moves.")] = _WALL.side
    barrier: Annotated[
        bool, Parameter(name="--barrier", negative="--no-barrier", show_default=False, help="With a wall, or without.")
    ] = True

    def oscillator(self) -> Oscillator:
        wall = Barrier(position=self.position, restitution=self.restitution, side=self.side)
        if not self.barrier and wall != _WALL:
            raise ValueError("--no-barrier leaves no wall for --position, --restitution or --side to describe.")
        return Oscillator(
            natural_frequency=self.natural_frequency,
            springpot=Springpot(order=self.order, coefficient=self.coefficient),
            barrier=wall if self.barrier else None,
            excitation=WhiteNoise(intensity=self.intensity),
        )


STANDARD = OscillatorFlags()
Flags = Annotated[OscillatorFlags, Parameter(name="*")]
Threads = Annotated[Whole | None, Parameter(help="Threads; all that this process may use if not given.")]
