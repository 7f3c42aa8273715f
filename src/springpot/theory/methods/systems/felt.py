"""Forces of parts and absolute accelerations in linear systems: their spectra and mean squares.

The linear system is a `springpot.theory.methods.systems.linear.Companion`, which is not imported here.
"""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from springpot.machine.faults import NotCoveredError, listed, shown
from springpot.problem.parts import Inerter, PoissonImpulses, WhiteNoise
from springpot.problem.system import System
from springpot.theory.numerics.frequencies import integrals, resonances

__all__ = ["What", "felt_mean_square", "felt_spectrum"]

FloatArray = NDArray[np.float64]
What = Literal["displacement", "force", "force of one", "acceleration"]

_NOTHING = 1e-12  # of what moves with the ground, of an acceleration without a white part


class _Felt:
    """A force or an absolute acceleration of a linear system, by what each unit of excitation makes of it.

    Of an acceleration a force on a mass has a part that passes at once, M^-1 f; the acceleration of the ground has
    none, because what it is relative to the ground is taken from it again.
    """

    def __init__(self, system: System, companion: Any, of: str, what: What) -> None:
        self.companion, self.force = companion, what.startswith("force")
        at, parts = companion.coordinates, dict(system.named())
        rows = {name: at.elongations[name] for name in system.elements}
        self.row = np.zeros(len(at.names))
        if self.force:
            chosen = system.grounded if of == "ground" else {of: 1.0}
            if of != "ground" and of not in rows:
                raise ValueError(f"of must be one of {listed([*rows, 'ground'], 'or')}, not {shown(of)}.")
            share = 1.0 / system.counts.get(of, 1) if what == "force of one" else 1.0
            self.parts = [(parts[n], sign * share * rows[n]) for n, sign in chosen.items()]
            if inert := [n for n in chosen if isinstance(parts[n], Inerter)]:
                raise NotCoveredError(f"the force of {listed(inert)} is not covered: it has what white noise brings.")
            lossy = [n for n in chosen if parts[n].dissipates]
        else:
            known = system.points
            if of not in known and (of or len(known) > 1):
                raise ValueError(f"of must be one of {listed([*known], 'or')}, not {shown(of)}.")
            self.row = at.rows[known.index(of) if of in known else 0]
            lossy = [n for n in rows if parts[n].dissipates]
        if lossy and companion.temperature > 0.0:
            raise NotCoveredError(
                f"the matched noise of {listed(lossy)} belongs to the {what}, which has no finite mean square."
            )
        if companion.multiplied or companion.parametric:
            raise NotCoveredError(f"a noise that multiplies an elongation is not covered in a {what}.")

    def direct(self, source: Any) -> float:
        """What passes at once."""
        if self.force:
            return 0.0
        own = self.companion
        passed = float(self.row @ np.linalg.solve(own.mass, own.push(source)))
        ground = float(self.row @ own.coordinates.participations) if source.on == "ground" else 0.0
        return passed + ground if abs(passed + ground) > _NOTHING * (abs(passed) + abs(ground)) else 0.0

    def response(self, w: FloatArray, source: Any) -> NDArray[np.complex128]:
        """Per unit of a source, at each frequency."""
        own = self.companion
        moved = own.displaced(w, own.push(source))
        if self.force:
            return np.asarray(sum((self._modulus(part, w) * (moved @ row) for part, row in self.parts), np.zeros(1)))
        pulls = own.stiffness + own.dissipative(w)
        light = np.linalg.solve(own.mass, self.row)
        return np.asarray(self.direct(source) - np.einsum("i,wij,wj->w", light, pulls, moved))

    def _modulus(self, part: Any, w: FloatArray) -> NDArray[np.complex128]:
        return np.asarray(part.modulus(1j * w) + np.zeros(len(w)), complex)

    def mean(self) -> float:
        """Of what constant forces make of it: of an acceleration nothing."""
        if not self.force:
            return 0.0
        own = self.companion
        at_rest = np.linalg.solve(own.stiffness, own.force)
        return float(
            sum(complex(self._modulus(part, np.zeros(1))[0]).real * (row @ at_rest) for part, row in self.parts)
        )

    def density(self, w: FloatArray) -> FloatArray:
        """Two-sided, under all noise but matched noise."""
        found = np.zeros(w.shape)
        for noise in self.companion.noises:
            densities = np.array([noise.density(each) for each in w.tolist()])
            found += densities * np.abs(self.response(w, noise)) ** 2
        return found

    def springs(self) -> FloatArray:
        """The force per displacement where there is no damper in it."""
        return np.asarray(sum((part.modulus(0.0) * row for part, row in self.parts), np.zeros(len(self.row))))


def felt_spectrum(system: System, companion: Any, w: FloatArray, of: str, what: What) -> FloatArray:
    """The two-sided spectral density of a force or an absolute acceleration at frequencies w >= 0."""
    felt = _Felt(system, companion, of, what)
    if companion.temperature > 0.0:
        raise NotCoveredError("the spectrum of a force is not covered with thermal noise; its mean square is.")
    return np.asarray(felt.density(w.ravel()).reshape(w.shape))


def felt_mean_square(system: System, companion: Any, of: str, what: What) -> float:
    """The mean square of a force or an absolute acceleration."""
    felt = _Felt(system, companion, of, what)
    for noise in companion.noises:
        if isinstance(noise, WhiteNoise | PoissonImpulses) and felt.direct(noise) != 0.0:
            raise NotCoveredError(
                f"{system.name_of(noise)} acts on the mass itself, so that its acceleration has no finite mean square."
            )
    found = felt.mean() ** 2
    if companion.noises:
        cuts = resonances(companion.nearest, companion.scales)
        found += float(integrals(lambda w: felt.density(w)[:, None], cuts, np.zeros(1))[0])
    for wave in companion.harmonics:
        found += 0.5 * wave.amplitude**2 * abs(complex(felt.response(np.array([wave.frequency]), wave)[0])) ** 2
    if companion.temperature > 0.0 and felt.force:
        row = felt.springs()
        found += companion.temperature * float(row @ np.linalg.solve(companion.stiffness, row))
    return found
