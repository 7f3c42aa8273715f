"""From the parts of a system to those of the kernel: one function for each kind of part, and the change of units.

A part per unit mass is lowered to what it adds to the kernel's forces, memory and walls, in the kernel's units.  The
sum of all is composed in `springpot.simulation.lowering.compose`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from functools import singledispatch
from typing import Any

import numpy as np

from springpot.machine.arrays import Floats
from springpot.machine.faults import NotCoveredError
from springpot.machine.sampling import band_limited
from springpot.memory import power_law_sum
from springpot.memory.exponential_sum import shared_span
from springpot.problem.parts import (
    Barrier,
    BoucWen,
    CloughPenzienNoise,
    ColoredNoise,
    Constant,
    Contact,
    Dashpot,
    Force,
    FractionalMaxwell,
    Friction,
    Harmonic,
    KanaiTajimiNoise,
    Maxwell,
    ParametricNoise,
    PiezoelectricCircuit,
    PoissonImpulses,
    PolynomialDashpot,
    PolynomialSpring,
    RecordedExcitation,
    ResonantCircuit,
    SpectralExcitation,
    Spring,
    Springpot,
    ThermalNoise,
    VanDerPol,
    WhiteNoise,
)
from springpot.problem.parts.hysteresis import Yielding
from springpot.simulation.kernel import laws
from springpot.simulation.kernel.callbacks import force_of
from springpot.simulation.kernel.sizes import GROUP
from springpot.simulation.lowering import sources
from springpot.simulation.lowering.modulated import Modulation, check_table, law_of
from springpot.simulation.lowering.sources import Named
from springpot.simulation.plan.scales import Units
from springpot.simulation.plan.settings import MOST_STEPS

_FAR = 1e30  # place of a contact that is not there
SUBSTEPS = 24  # of the shortest contact
MOST_SUBSTEPS = 2000
_DENSE, _MOST_DENSE = 8.0, 32  # points of a band-limited record in a step, and in one of its own steps at most
_MOST_IMPULSES = 50.0  # in a step
_THERMAL_TOLERANCE = 1e-4
_SHORTEST = 1.0 / 64.0  # lag of the matched noise, in steps
_SPACING = 0.9  # of modes of a series
_LEAST_SHARE = 1e5  # a series' spectrum ends where so small a part of the stiffness is left
_SLOWEST, _FASTEST = 1e-9, 300.0  # rates of a series, per step


@dataclass(frozen=True)
class Arm:
    """One decaying mode of memory: the force of a jump in displacement is ``strength`` exp(-rate t).

    Attributes
    ----------
    strength, rate : float
        In the kernel's units.
    name : str
        Of the circuit whose voltage it is; empty otherwise.
    volts, amperes : float
        V per unit of the mode's state (volt over the root of the mass); of a circuit with a coil A of its second state.
    turn : float
        Frequency of a circuit with a coil, whose rate is then R / L: a mode with two states, y' = x' - turn q and
        q' = turn y - rate q, and the force ``strength`` y.
    """

    strength: float
    rate: float
    name: str = ""
    volts: float = 0.0
    amperes: float = 0.0
    turn: float = 0.0


@dataclass(frozen=True)
class Damper:
    """A nonlinear damper, a part that yields, or a force of the user, which is followed alone beside the kick.

    Attributes
    ----------
    name : str
    kind : int
        Of `springpot.simulation.kernel.laws`, or the address of a function.
    impulses, numbers : tuple of float
        Of its law: those that are divided by the mass that moves, and the others.
    states : int
        Numbers that it keeps for each path.
    does : {"dissipates", "works"}
        How its work is reported: as what is taken out, or as what a force of unknown kind does.
    function : object
        Compiled code of the user, which must live as long as its address.
    """

    name: str
    kind: int
    impulses: tuple[float, ...]
    numbers: tuple[float, ...] = ()
    states: int = 0
    does: str = "dissipates"
    function: Any = None


@dataclass(frozen=True)
class Lowered:
    """What parts add to the kernel's problem; a sum of two is that of all their parts.

    Attributes
    ----------
    springs : tuple of float
        Coefficients of the force k0 + k1 x + k2 x^2 + ..., beside the spring that is followed exactly.
    springpots : tuple of (float, float)
        Orders and coefficients; a dashpot has the order 1.
    arms : tuple of Arm
    white, parametric : float
        Intensities of white noise, and of that which multiplies x.
    temperature : float
        kT of matched noise; 0 without.
    sources : tuple of Named
    dampers : tuple of Damper
    modulated : tuple of Modulation
        Noise that changes over the steps of a run.
    barriers : tuple of (str, Barrier)
    contacts : tuple of (str, Contact)
        With their names, in the kernel's units; a restitution that depends on the speed is in the user's.
    """

    springs: tuple[float, ...] = ()
    springpots: tuple[tuple[float, float], ...] = ()
    arms: tuple[Arm, ...] = ()
    white: float = 0.0
    parametric: float = 0.0
    temperature: float = 0.0
    sources: tuple[Named, ...] = ()
    dampers: tuple[Damper, ...] = ()
    modulated: tuple[Modulation, ...] = ()
    barriers: tuple[tuple[str, Barrier], ...] = ()
    contacts: tuple[tuple[str, Contact], ...] = ()

    @property
    def remembers(self) -> bool:
        """Whether its force depends on the past."""
        return bool(self.arms) or any(order != 1.0 for order, _ in self.springpots)

    @property
    def dashpots(self) -> float:
        """The coefficient of all dashpots together."""
        return sum(c for order, c in self.springpots if order == 1.0)

    def over(self, steps: int) -> Lowered:
        """With tables no longer than a run of so many steps."""
        return replace(self, sources=tuple(each.over(steps) for each in self.sources)) if self.sources else self

    def __add__(self, other: Lowered) -> Lowered:
        size = max(len(self.springs), len(other.springs))
        padded = ((*one.springs, *(0.0,) * (size - len(one.springs))) for one in (self, other))
        both = {f.name: getattr(self, f.name) + getattr(other, f.name) for f in fields(self) if f.name != "springs"}
        return Lowered(springs=tuple(a + b for a, b in zip(*padded, strict=True)), **both)


@singledispatch
def lower(part: object, name: str, units: Units, step: float) -> Lowered:
    """What a part per unit mass adds.

    Parameters
    ----------
    part
        Of `springpot.problem.parts`.
    name : str
        Its name in the system.
    units : Units
    step : float
        In the kernel's units.
    """
    raise NotCoveredError(f"{name} cannot be simulated: there is no law for {type(part).__name__} in the kernel.")


@lower.register
def _(part: Spring | PolynomialSpring | Constant, name: str, units: Units, step: float) -> Lowered:
    powers = enumerate(part.force_coefficients())
    return Lowered(springs=tuple(k * units.length ** (n - 1) * units.time**2 for n, k in powers))


@lower.register
def _(part: Dashpot, name: str, units: Units, step: float) -> Lowered:
    return Lowered(springpots=((1.0, part.coefficient * units.time),))


@lower.register
def _(part: PolynomialDashpot, name: str, units: Units, step: float) -> Lowered:
    c1, c2, c3 = (*part.coefficients, 0.0, 0.0)[:3]
    linear = ((1.0, c1 * units.time),) if c1 else ()
    if part.is_linear:
        return Lowered(springpots=linear)
    impulses = 0.5 * step * c2 * units.length, step * c3 * units.length**2 / units.time
    return Lowered(springpots=linear, dampers=(Damper(name, laws.POLYNOMIAL, impulses),))


@lower.register
def _(part: VanDerPol, name: str, units: Units, step: float) -> Lowered:
    rate = part.coefficient * units.length**2 * units.time
    return Lowered(
        dampers=(Damper(name, laws.VAN_DER_POL, (0.5 * step * rate,), ((part.length / units.length) ** 2,)),)
    )


@lower.register
def _(part: Friction, name: str, units: Units, step: float) -> Lowered:
    return Lowered(dampers=(Damper(name, laws.COULOMB, (0.5 * step * part.force / units.length * units.time**2,)),))


@lower.register
def _(part: Yielding, name: str, units: Units, step: float) -> Lowered:
    impulse, limit = 0.5 * step * part.stiffness * units.time**2, part.yield_displacement / units.length
    kind, numbers = laws.JENKINS, tuple[float, ...]([limit])
    if isinstance(part, BoucWen):
        kind = laws.WHOLE if part.exponent.is_integer() else laws.ANY
        numbers = limit, part.beta, part.exponent
    return Lowered(dampers=(Damper(name, kind, (impulse,), numbers, laws.STATES_OF_YIELDING),))


@lower.register
def _(part: Force, name: str, units: Units, step: float) -> Lowered:
    half = 0.5 * step * part.share / units.length * units.time**2
    own = force_of(part.function, name)
    numbers = units.time, units.length, units.speed
    return Lowered(dampers=(Damper(name, own.address, (half,), numbers, does="works", function=own),))


@lower.register
def _(part: RecordedExcitation, name: str, units: Units, step: float) -> Lowered:
    """Impulses are exact integrals of the straight lines between the points, or between points that are denser."""
    factor = part.scale / units.length * units.time**2

    def make(parts: int, steps: int = MOST_STEPS) -> Any:
        longest = math.ceil(min(part.duration / units.time / step, steps))
        most = -(-longest // GROUP) * GROUP  # the kernel takes four at once
        check_table(name, 2 * part.count, most)
        records = [((np.array(t) - t[0]) / units.time, factor * np.array(a)) for t, a in part.records]
        if part.interpolation == "band-limited":
            records = [denser(t, a, step) for t, a in records]
        rows = [impulses_of(t, a, step, most) for t, a in records]
        impulses = np.array([np.pad(row, (0, max(map(len, rows)) - len(row))) for row in rows])
        return sources.Records(part.is_drawn, impulses)

    return Lowered(sources=(Named(name, make, int(part.count > 1), "feeds", make),))


def denser(times: Floats, values: Floats, step: float) -> tuple[Floats, Floats]:
    """Points of a band-limited record so dense that straight lines between them lose less than the step does."""
    fold = min(max(math.ceil(_DENSE * times[-1] / (len(times) - 1) / step), 1), _MOST_DENSE)
    dense = band_limited(values, fold)
    return np.linspace(0.0, times[-1], len(dense)), dense


def impulses_of(times: Floats, values: Floats, step: float, most: int, delay: float = 0.0) -> Floats:
    """Integrals over the steps, at most so many, of straight lines between points that come later by the delay."""
    whole = np.concatenate([[0.0], np.cumsum(0.5 * np.diff(times) * (values[1:] + values[:-1]))])
    ends = np.clip(step * np.arange(math.ceil(min((times[-1] + delay) / step, most)) + 1) - delay, 0.0, times[-1])
    place = np.clip(np.searchsorted(times, ends, side="right") - 1, 0, len(times) - 2)
    since = ends - times[place]
    slope = np.diff(values) / np.diff(times)
    reached = whole[place] + since * (values[place] + 0.5 * slope[place] * since)
    return np.asarray(np.diff(reached))


@lower.register
def _(part: Springpot, name: str, units: Units, step: float) -> Lowered:
    if part.order == 0.0:
        return Lowered(springs=(0.0, part.coefficient * units.time**2))
    if part.coefficient == 0.0:
        return Lowered()
    return Lowered(springpots=((part.order, part.coefficient * units.time ** (2.0 - part.order)),))


@lower.register
def _(part: Maxwell, name: str, units: Units, step: float) -> Lowered:
    return Lowered(arms=(Arm(part.stiffness * units.time**2, part.stiffness / part.coefficient * units.time),))


@lower.register
def _(part: PiezoelectricCircuit, name: str, units: Units, step: float) -> Lowered:
    slope = part.coupling / part.capacitance
    return Lowered(
        arms=(Arm(part.coupling * slope * units.time**2, units.time / part.time, name, slope * units.length),)
    )


@lower.register
def _(part: ResonantCircuit, name: str, units: Units, step: float) -> Lowered:
    slope = part.coupling / part.capacitance
    arm = Arm(
        part.coupling * slope * units.time**2, part.rate * units.time, name, slope * units.length,
        part.coupling * part.frequency * units.length, part.frequency * units.time,
    )  # fmt: skip
    return Lowered(arms=(arm,))


@lower.register
def _(part: FractionalMaxwell, name: str, units: Units, step: float) -> Lowered:
    """Its kernel has a positive spectrum over the rates.

    It is integrated over their logarithm u by the trapezoidal rule on a scale y(u).
    """
    order, stiffness = part.springpot.order, part.spring.stiffness * units.time**2
    springpot = part.springpot.coefficient * units.time ** (2.0 - order)
    if order == 1.0:
        return Lowered(arms=(Arm(stiffness, stiffness / springpot),))
    turn, lam = math.pi * order, stiffness / springpot
    centre = math.log(lam) / order  # of the spectrum
    # near order 1 it is a narrow peak with long tails: the places are dense in the peak only
    width = math.pi * min(1.0, (1.0 - order) / order)
    reach = math.log(_LEAST_SHARE / order * math.sin(turn) / math.pi) / order
    low = max(-reach, math.log(_SLOWEST / step) - centre)
    high = min(reach, math.log(_FASTEST / step) - centre)
    if high <= -reach:  # the spring does not give way
        return Lowered(springpots=((order, springpot),))
    # at places of the logarithm of the rate on a scale that is wide within ``width`` of 0
    first, last = (math.floor((u + math.asinh(u / width)) / _SPACING) for u in (low, high))
    y = _SPACING * np.arange(first, last + 2, dtype=np.float64)
    u = _uneven(y, width)
    power = np.exp(order * u)  # s^a / lam
    spectrum = math.sin(turn) / math.pi / (power + 2.0 * math.cos(turn) + 1.0 / power)
    strengths = stiffness * spectrum * _SPACING / (1.0 + 1.0 / np.hypot(width, u))
    rates = np.exp(centre + u)
    # modes so slow that they are springs for this run are kept as one, with all that is slower still; what is faster
    # than the last mode is over within a fraction of a step
    kept = rates >= 100.0 * _SLOWEST / step
    if not kept.any():
        return Lowered(arms=(Arm(stiffness, 0.0),))
    modes = [Arm(float(k), float(s)) for k, s in zip(strengths[kept], rates[kept], strict=True)]
    edge = float(_uneven(np.array([y[kept][0] - 0.5 * _SPACING]), width)[0])
    slower = stiffness * math.atan2(math.sin(turn), math.exp(-order * edge) + math.cos(turn)) / turn
    if slower > 1e-6 * stiffness:
        modes.append(Arm(slower, 0.0))
    return Lowered(arms=tuple(modes))


def _uneven(y: Floats, width: float) -> Floats:
    """The inverse of u + asinh(u / width), by Newton's method: from below the bend it comes down to the root."""
    size = np.abs(y)
    u = np.minimum(size, width * np.sinh(np.minimum(size, 300.0)))
    for _ in range(60):
        u = u - (u + np.arcsinh(u / width) - size) / (1.0 + 1.0 / np.hypot(width, u))
    return np.copysign(u, y)


@lower.register
def _(part: WhiteNoise, name: str, units: Units, step: float) -> Lowered:
    intensity = part.intensity / units.length**2 * units.time**3
    if part.envelope is not None:
        return Lowered(modulated=(Modulation(name, part.envelope, intensity),))
    return Lowered(white=intensity)


@lower.register
def _(part: ParametricNoise, name: str, units: Units, step: float) -> Lowered:
    intensity = part.intensity * units.time**3
    if part.envelope is not None:
        return Lowered(modulated=(Modulation(name, part.envelope, intensity, multiplies=True),))
    return Lowered(parametric=intensity)


@lower.register
def _(part: PoissonImpulses, name: str, units: Units, step: float) -> Lowered:
    rate, size = part.rate * units.time * step, math.sqrt(part.mean_square) / units.speed
    if rate > _MOST_IMPULSES:
        raise ValueError(
            f"{name} has {rate:.3g} impulses in a step, which are white noise: use WhiteNoise({part.intensity:g})."
        )

    def make(parts: int) -> Any:
        return sources.Poisson(rate / parts, size)

    if part.envelope is not None:
        return Lowered(modulated=(Modulation(name, part.envelope, make=make),))
    return Lowered(sources=(Named(name, make, 0, "nothing"),))


@lower.register
def _(part: ColoredNoise, name: str, units: Units, step: float) -> Lowered:
    variance = part.variance / units.length**2 * units.time**4
    rate = step * units.time / part.correlation_time
    law = sources.Filter(np.array([[-rate]]), np.array([[2.0 * rate * variance]]), np.ones(1))
    return _of_a_filter(part, name, law, step)


@lower.register
def _(part: KanaiTajimiNoise, name: str, units: Units, step: float) -> Lowered:
    intensity = part.intensity / units.length**2 * units.time**3 / step
    at, twice = units.time * step, 2.0 * part.damping
    first = part.frequency * at

    def law(time: float) -> sources.Filter:
        """Of the states w u and u' with the first w, both in units of the white noise over a step."""
        w = part.frequency_at(time, name) * at
        matrix = first * np.array([[0.0, 1.0], [-((w / first) ** 2), -twice * w / first]])
        output = np.array([(w / first) ** 2, twice * w / first])
        return sources.Filter(matrix, np.diag([0.0, intensity * first * first]), output)

    return _of_a_filter(part, name, law if part.frequency_rate else law(0.0), step)


@lower.register
def _(part: CloughPenzienNoise, name: str, units: Units, step: float) -> Lowered:
    at, twice, again = units.time * step, 2.0 * part.damping, 2.0 * part.base_damping
    first, u = part.frequency * at, part.base_frequency * at
    intensity = part.intensity / units.length**2 * units.time**3 / step

    def law(time: float) -> sources.Filter:
        """Of the states of the Kanai-Tajimi noise, and wf^2 u and wf u' of the second filter."""
        w = part.frequency_at(time, name) * at
        stiff, damped = (w / first) ** 2, twice * (w / first)
        ground = [0.0, first, 0.0, 0.0], [-first * stiff, -first * damped, 0.0, 0.0]
        matrix = np.array([*ground, [0.0, 0.0, 0.0, u], [u * stiff, u * damped, -u, -u * again]])
        noise = np.diag([0.0, intensity * first * first, 0.0, 0.0])
        return sources.Filter(matrix, noise, np.array([stiff, damped, -1.0, -again]))

    own = law if part.frequency_rate else law(0.0)
    return Lowered(modulated=(Modulation(name, part.envelope, filter=own, states=8),))


def _of_a_filter(part: ColoredNoise | KanaiTajimiNoise, name: str, law: Any, step: float) -> Lowered:
    if part.envelope is not None:
        states = 2 if isinstance(part, ColoredNoise) else 4
        return Lowered(modulated=(Modulation(name, part.envelope, filter=law, states=states),))
    return Lowered(sources=(_filtered(name, [law], step),))


@lower.register
def _(part: SpectralExcitation, name: str, units: Units, step: float) -> Lowered:
    from springpot.simulation.lowering import shaping  # SciPy's linear algebra is slow to import

    intensity = 0.5 * part.scale * max(part.psd) / units.length**2 * units.time**3 / step
    law = shaping.filter_of(shaping.shape_of(part, name), intensity, 2.0 * math.pi * units.time * step)
    own = _filtered(name, [law], step, floor=shaping.FLOOR)
    if part.envelope is not None:
        return Lowered(modulated=(Modulation(name, part.envelope, make=own.make, states=own.states),))
    return Lowered(sources=(own,))


@lower.register
def _(part: Harmonic, name: str, units: Units, step: float) -> Lowered:
    turn = part.frequency * units.time * step
    impulse = step * part.amplitude / units.length * units.time**2 * float(np.sinc(0.5 * turn / math.pi))
    return Lowered(sources=(Named(name, lambda parts: sources.Harmonic(impulse, turn), 2, "feeds"),))


@lower.register
def _(part: ThermalNoise, name: str, units: Units, step: float) -> Lowered:
    return Lowered(temperature=part.temperature / units.speed**2)


@lower.register
def _(part: Barrier, name: str, units: Units, step: float) -> Lowered:
    return Lowered(barriers=((name, replace(part, position=part.position / units.length)),))


@lower.register
def _(part: Contact, name: str, units: Units, step: float) -> Lowered:
    exponent = float(part.exponent)
    stiffness = float(part.stiffness) * units.length ** (exponent - 1.0) * units.time**2
    dissipation = float(part.dissipation) * units.speed
    contact = Contact(float(part.position) / units.length, stiffness, exponent, dissipation, part.free_side)
    return Lowered(contacts=((name, contact),))


def _filtered(
    name: str, filters: Sequence[sources.Filter], step: float, white: float = 0.0, floor: float = 0.0
) -> Named:
    states = max(2, sum(filter.output.size for filter in filters))
    states += states % 2

    def make(parts: int) -> sources.Filtered:
        from springpot.simulation.lowering.filters import filtered  # SciPy's linear algebra is slow to import

        slower = [replace(filter, matrix=filter.matrix / parts, noise=filter.noise / parts) for filter in filters]
        return filtered(slower, step / parts, white / parts, floor=floor)

    return Named(name, make, states, "feeds")


def modulated_noise(total: Lowered, units: Units, step: float, steps: int) -> tuple[Named, ...]:
    """The sources of what changes over the steps of a run."""

    def named(noise: Modulation) -> Named:
        make = lambda parts: law_of(noise, units, step, steps, parts)  # noqa: E731
        return Named(noise.name, make, noise.states, "feeds" if noise.states else "nothing")

    return tuple(map(named, total.modulated))


def thermal_noise(name: str, total: Lowered, step: float, steps: int, parts: int) -> Named:
    """The noise that belongs to every dissipator: forces with the correlation kT times the kernel of their memory.

    A springpot's kernel is a sum of exponentials from a fraction of a step on; what that leaves of its integral near
    time 0 is white.  The sum is that of a run whose step is one of ``parts`` of this one.
    """
    from scipy import special  # slow to import, and most runs need none of it

    step, steps = step / parts, steps * parts
    theta, white = total.temperature, 0.0
    modes = [(arm.strength, arm.rate * step) for arm in total.arms if not arm.turn]
    for order, coefficient in total.springpots:
        if order == 1.0:
            white += coefficient
            continue
        law = power_law_sum(order, _SHORTEST, float(shared_span(max(steps, 2))), _THERMAL_TOLERANCE)
        weights = coefficient * step**-order * law.weights / math.gamma(1.0 - order)
        modes += zip(weights, law.rates, strict=True)
        near = 4.0 * _SHORTEST  # within the range of the sum
        whole = coefficient * step**-order * near ** (1.0 - order) / math.gamma(2.0 - order)
        kept = sum(w * near * float(special.exprel(-s * near)) for w, s in zip(weights, law.rates, strict=True))
        white += step * max(whole - kept, 0.0)
    one = np.ones((1, 1))
    filters = [
        sources.Filter(-parts * rate * one, parts * 2.0 * rate * theta * strength * one, np.ones(1))
        for strength, rate in modes
        if rate > 0.0
    ]
    for arm in total.arms:
        if arm.turn > 0.0:  # the noise of the resistor, in the voltage of the coil
            turn, rate = parts * arm.turn * step, parts * arm.rate * step
            matrix, noise = np.array([[0.0, -turn], [turn, -rate]]), np.diag([0.0, 2.0 * rate * theta * arm.strength])
            filters.append(sources.Filter(matrix, noise, np.array([1.0, 0.0])))
    return _filtered(name, filters, parts * step, 2.0 * theta * white * parts * step)


def numbers_of(contact: Contact) -> tuple[float, ...]:
    """A contact as the kernels have it: where it is, the sign of its force, and its law."""
    return contact.position, contact.inwards, contact.stiffness, contact.exponent, contact.dissipation


def contact_time(contact: Contact, speed: float) -> float:
    """Duration of a free contact without loss that begins with this speed.

    Examples
    --------
    >>> round(contact_time(Contact(0.0, 100.0), 1.0), 6)
    0.510029
    """
    power = contact.exponent + 1.0
    depth = (power * speed**2 / (2.0 * contact.stiffness)) ** (1.0 / power)
    shape = math.gamma(1.0 + 1.0 / power) / math.gamma(0.5 + 1.0 / power)
    return 2.0 * math.sqrt(math.pi) * shape * float(depth) / speed
