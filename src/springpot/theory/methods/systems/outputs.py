"""Forces of parts and absolute accelerations in linear systems: their spectra and mean squares.

The linear system is a `springpot.theory.methods.systems.linear.Companion`, which is not imported here.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from springpot.machine.arrays import Complexes, Floats
from springpot.machine.faults import NotCoveredError, few, listed, meant, shown
from springpot.problem.outputs import outputs_of
from springpot.problem.system import System

_NOTHING = 1e-12  # of what moves with the ground, of an acceleration without a white part


class _Output:
    """A force or an absolute acceleration of a linear system, by what each unit of excitation makes of it.

    Of an acceleration a force on a mass has a part that passes at once, M^-1 f; the acceleration of the ground has
    none, because what it is relative to the ground is taken from it again.
    """

    def __init__(self, system: System, companion: Any, of: str) -> None:
        at, parts, known = companion.coordinates, dict(system.named()), outputs_of(system)
        if of not in known:
            near = meant(str(of), known) or f"; there are {few([*known])}."
            raise ValueError(f"{shown(of)} is no force or acceleration{near}")
        output = known[of]
        self.companion, self.force = companion, output.row is None
        self.row = np.zeros(len(at.names)) if output.row is None else output.row
        if self.force and output.unseen:
            raise NotCoveredError(
                f"the force of {listed(output.unseen)} is not covered: it has what white noise brings."
            )
        self.parts = [
            (parts[n], share * at.elongations[n]) for n, share in output.shares.items() if n in at.elongations
        ]
        lossy = [n for n in (output.shares if self.force else system.elements) if parts[n].dissipates]
        if lossy and companion.temperature > 0.0:
            raise NotCoveredError(f"the matched noise of {listed(lossy)} in {of} has no finite mean square.")
        if companion.multiplied or companion.parametric:
            raise NotCoveredError(f"a noise that multiplies an elongation is not covered in {of}.")

    def direct(self, source: Any) -> float:
        """What passes at once."""
        if self.force:
            return 0.0
        own = self.companion
        passed = float(self.row @ np.linalg.solve(own.mass, own.push(source)))
        ground = float(self.row @ own.coordinates.participations) if source.on == "ground" else 0.0
        return passed + ground if abs(passed + ground) > _NOTHING * (abs(passed) + abs(ground)) else 0.0

    def response(self, w: Floats, source: Any) -> Complexes:
        """Per unit of a source, at each frequency."""
        own = self.companion
        moved = own.displaced(w, own.push(source))
        if self.force:
            return np.asarray(sum((self._modulus(part, w) * (moved @ row) for part, row in self.parts), np.zeros(1)))
        pulls = own.stiffness + own.dissipative(w)
        light = np.linalg.solve(own.mass, self.row)
        return np.asarray(self.direct(source) - np.einsum("i,wij,wj->w", light, pulls, moved))

    def _modulus(self, part: Any, w: Floats) -> Complexes:
        return np.asarray(part.modulus(1j * w) + np.zeros(len(w)), complex)

    def mean(self) -> float:
        """Of what constant forces make of it: of an acceleration nothing."""
        if not self.force:
            return 0.0
        own = self.companion
        return float(
            sum(complex(self._modulus(part, np.zeros(1))[0]).real * (row @ own.at_rest) for part, row in self.parts)
        )

    def density(self, w: Floats) -> Floats:
        """Two-sided, under all noise but matched noise."""
        found = np.zeros(w.shape)
        for noise in self.companion.noises:
            densities = np.array([noise.density(each) for each in w.tolist()])
            found += densities * np.abs(self.response(w, noise)) ** 2
        return found

    def springs(self) -> Floats:
        """The force per displacement where there is no damper in it."""
        return np.asarray(sum((part.modulus(0.0) * row for part, row in self.parts), np.zeros(len(self.row))))


def output_spectrum(system: System, companion: Any, of: str) -> Callable[[Floats], Floats]:
    """The two-sided spectral density of a force or an absolute acceleration, a function of frequencies w >= 0."""
    output = _Output(system, companion, of)
    if companion.temperature > 0.0:
        raise NotCoveredError("the spectrum of a force is not covered with thermal noise; its mean square is.")
    return lambda w: np.asarray(output.density(w.ravel()).reshape(w.shape))


def output_mean(system: System, companion: Any, of: str) -> float:
    """The mean of a force or an absolute acceleration."""
    return _Output(system, companion, of).mean()


def output_mean_square(system: System, companion: Any, of: str) -> float:
    """The mean square of a force or an absolute acceleration."""
    output = _Output(system, companion, of)
    for noise in companion.noises:
        if noise.is_white and output.direct(noise) != 0.0:
            raise NotCoveredError(
                f"{system.name_of(noise)} acts on the mass itself, so that its acceleration has no finite mean square."
            )
    found = output.mean() ** 2
    if companion.noises:
        found += float(companion.integrals(lambda w: output.density(w)[:, None], np.zeros(1))[0])
    for wave in companion.harmonics:
        found += 0.5 * wave.amplitude**2 * abs(complex(output.response(np.array([wave.frequency]), wave)[0])) ** 2
    if companion.temperature > 0.0 and output.force:
        row = output.springs()
        found += companion.temperature * float(row @ np.linalg.solve(companion.stiffness, row))
    return found
