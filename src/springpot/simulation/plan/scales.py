"""The rates, times and sizes of a motion, in which the default step and duration are counted, and the kernel's units.

Those of the paper's problem have closed forms; those of any other system are a guess
(`springpot.simulation.plan.guess`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from springpot.problem.dimensionless import Dimensionless
from springpot.problem.parts import Barrier
from springpot.problem.system import System
from springpot.theory.decay import decay_rate, mean_square_amplitude


def beat(system: System) -> float:
    """How much longer than without a harmonic force the start is felt, and how much more of it is in a mean square.

    What the start leaves beats with the forced motion, 2 exp(-b t) of the square, where without that force only its
    own square is left, exp(-2 b t).

    Examples
    --------
    >>> from springpot.problem.parts import Harmonic, WhiteNoise
    >>> beat(System(Harmonic(1.0, 2.0))), beat(System(WhiteNoise(1.0)))
    (2.0, 1.0)
    """
    return 2.0 if any(part.feeds and not part.noise for part in system.excitations.values()) else 1.0


@dataclass(frozen=True)
class Units:
    """The kernel's units: powers of two, so that they cost no digit.

    Attributes
    ----------
    length, time : float
        In m and s.
    """

    length: float
    time: float

    @classmethod
    def near(cls, length: float, fastest: float) -> Units:
        """Powers of two near a length and the time of a rate."""
        near = 2.0 ** round(math.log2(length)) if length > 0.0 else 1.0
        return cls(near, 2.0 ** round(-math.log2(fastest)))

    @property
    def speed(self) -> float:
        """In m/s."""
        return self.length / self.time

    @property
    def state(self) -> tuple[float, float]:
        """Factors for x and v of the kernel."""
        return self.length, self.speed


@dataclass(frozen=True)
class Scales:
    """Rates, times and sizes of a motion.

    Attributes
    ----------
    frequency : float
        Typical angular frequency, in rad/s: Omega, or that of the linear spring with the guessed variance of x.
    fastest_rate : float
        The largest rate that the step must follow, in 1/s: of the springs, of the springpot alone,
        C^(1 / (2 - alpha)), and of what else is there.
    energy_time : float
        In which the energy relaxes, in s: its beat where a force is harmonic; infinite without any loss.
    creep_time : float
        (C / Omega^2)^(1 / alpha), in s, if a springpot is stronger than the spring, otherwise 0: the time of creep
        back to the equilibrium.
    forgetting_time : float
        The energy time, but at least 2 / frequency, in s; longer where it is a guess.
    settling_time : float
        In which the energy of a run from x(0) settles, in s.
    flight_frequency : float
        Of the linear spring that is followed exactly between kicks, in rad/s.
    length : float
        Largest usual displacement, in m: the unit of length is chosen by it; 0 if nothing moves the mass.
    spread : float
        Standard deviation of x, about, in m.
    mean : float
        First guess of E[x], in m.
    guessed : bool
        Whether the times are a rough guess, not closed forms.
    resolved_rate : float
        The rate that the default step follows, in 1/s, where a longer step is stable, but off; else 0.
    """

    frequency: float
    fastest_rate: float
    energy_time: float
    creep_time: float
    forgetting_time: float
    settling_time: float
    flight_frequency: float
    length: float
    spread: float
    mean: float
    guessed: bool
    resolved_rate: float = 0.0

    def seen_from(self, origin: float) -> Scales:
        """The same with E[x] measured from another place."""
        return replace(self, mean=self.mean - origin)

    @property
    def relaxation_time(self) -> float:
        """Relaxation time of the motion, in s: the larger of energy time and creep time."""
        return max(self.energy_time, self.creep_time)


def closed_form(paper: Dimensionless) -> Scales:
    """The rates, times and sizes of the paper's problem.

    Examples
    --------
    >>> from springpot.problem.parts import Springpot
    >>> scales = closed_form(Dimensionless(natural_frequency=2.0, springpot=Springpot(order=1.0, coefficient=0.1)))
    >>> scales.fastest_rate, round(scales.energy_time, 6), scales.creep_time
    (2.0, 10.0, 0.0)
    """
    spring, energy, omega = paper.springpot, _energy_time(paper), paper.natural_frequency
    stored = spring.coefficient if spring.order == 0.0 else 0.0
    return Scales(
        frequency=omega,
        fastest_rate=max(omega, float(spring.coefficient ** (1.0 / (2.0 - spring.order)))),
        energy_time=energy,
        creep_time=_creep_time(paper),
        forgetting_time=max(energy, 2.0 / omega),
        settling_time=energy,
        flight_frequency=math.sqrt(omega**2 + stored) if stored else omega,
        length=paper.length_scale,
        spread=paper.length_scale,
        mean=_mean(paper),
        guessed=False,
    )


def _mean(paper: Dimensionless) -> float:
    """E[x] by averaging with the wall moved to the equilibrium, or the wall's place if that is farther inside."""
    if paper.barrier is None:
        return 0.0
    beta = decay_rate(replace(paper, barrier=Barrier(0.0, paper.restitution)))
    square = mean_square_amplitude(paper, beta, paper.natural_frequency)
    mean = math.sqrt(square / math.pi) if math.isfinite(square) else 0.0
    return paper.direction * max(paper.direction * paper.barrier.position, mean)


def _energy_time(paper: Dimensionless) -> float:
    """1 / (2 beta) from averaging with the wall moved to the equilibrium.

    With a gap the part of beta due to lossy impacts is multiplied by the share of cycles that reach the wall, and the
    time to grow to that amplitude is added.
    """
    frequency, barrier = paper.natural_frequency, paper.barrier
    elastic = replace(paper, barrier=None if barrier is None else Barrier())
    rate = 2.0 * decay_rate(elastic) / _slowing(paper)
    growth = 0.0
    if barrier is not None and paper.restitution < 1.0:
        gap = max(0.0, -paper.direction * barrier.position)
        intensity = paper.excitation.intensity
        # share of a Rayleigh amplitude with <A^2> = q / (rate Omega^2) beyond the gap
        struck = math.exp(-rate * (gap * frequency) ** 2 / intensity) if gap > 0.0 and intensity > 0.0 else 1.0
        lossy = replace(paper, barrier=Barrier(0.0, paper.restitution))
        impacts = 2.0 * (decay_rate(lossy) - decay_rate(elastic))
        rate += struck * impacts
        growth = struck * (gap * frequency) ** 2 / intensity if intensity > 0.0 else 0.0
    return 1.0 / rate + growth if rate > 0.0 else math.inf


def _slowing(paper: Dimensionless) -> float:
    """Ratio of the decay rate by averaging at Omega to the actual one: the springpot's stiffness raises the frequency.

    At the resonance w without a wall (with a wall the stiffness is smaller) the springpot's power is proportional to
    w^(alpha - 1), and it stores the part alpha (w^2 - Omega^2) / (2 w^2) of the energy.
    """
    order, ratio = paper.springpot.order, paper.resonance / paper.natural_frequency
    return math.pow(ratio, 1.0 - order) * (1.0 + 0.5 * order * (1.0 - ratio**-2))


def _creep_time(paper: Dimensionless) -> float:
    spring = paper.springpot
    if paper.dimensionless_coefficient <= 1.0 or spring.order == 0.0:
        return 0.0
    return creep_time(spring.coefficient / paper.natural_frequency**2, spring.order)


def creep_time(ratio: float, order: float) -> float:
    """(C / k)^(1 / order) of a springpot C beside a spring k, from their ratio; infinite beyond double precision."""
    logarithm = math.log(ratio) / order
    return math.exp(logarithm) if logarithm < 700.0 else math.inf
