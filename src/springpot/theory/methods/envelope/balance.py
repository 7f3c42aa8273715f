"""The self-consistent balance of the envelope: loss, stored energy and probability of cycles of every size.

Everything is dimensionless (time 1/Omega, length sqrt(q/Omega^3), so that q = 1).  A cycle is labelled by its height
above the wall; cycles below the grazing one have no impact.  The fixed point is described by a few numbers (`Closure`);
the physics is in `method`.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import astuple, dataclass, replace

import numpy as np
from numpy.polynomial import legendre

from springpot.machine.arrays import Floats
from springpot.theory.methods.envelope.cycles import SMALLEST_PHASE, Cycles, harmonic_sum, make_cycles
from springpot.theory.numerics.energy_diffusion import EnergyDiffusion, make_energy_diffusion
from springpot.theory.numerics.equations import Anderson
from springpot.theory.numerics.panels import on_panels, panel_rule
from springpot.theory.problem import Problem

_NODES = 10  # Gauss-Legendre nodes of a panel
_FINE_NODES = 30  # for the diffusion in time, whose fluxes are of second order
_FAR = 45.0  # the stationary density ends where it has fallen by e^-45
_STEPS, _FREE = 40, 19  # largest number of steps, and of steps without damping
_SETTLED = 1e-8
_DEPTH, _CUTOFF = 3, 1e-8  # of the acceleration
_UNSETTLED = 0.02  # change of the numbers per step above which there is no result; a smaller one gives a warning
_FORGETFUL = 3.0  # decay over frequency above which the motion is overdamped: the line-width correction diverges
_STRUCK = 1e-8  # variance of the mean of a cycle over <x^2>, below which the wall has no effect
_STRIKING_PANELS = 9
_SHORT = 2.0  # power by which broadening decreases in short flights: of 1, 2, 4 the best at r = 0.5 and 0.8, b = 1
_FASTEST, _FARTHEST = 1e150, 1e60  # largest velocity and displacement whose powers do not overflow


@dataclass(frozen=True)
class Closure:
    """Averages over the whole motion on which a cycle depends.

    Parameters
    ----------
    slow_stiffness : float
        k0, the springpot's stiffness against slow changes of the cycle's mean.
    mean : float
        m = E[x].
    decay : float
        beta, the decay rate of the amplitude.
    frequency : float
        Mean frequency w of the arcs.
    share : float
        Share of the extra dissipation by broadened lines that the line at zero frequency does not compensate.
    taken : float
        Share of the input power that the springpot dissipates; impacts dissipate the rest.
    """

    slow_stiffness: float = 0.0
    mean: float = 0.0
    decay: float = 0.0
    frequency: float = 1.0
    share: float = 0.0
    taken: float = 1.0


@dataclass(frozen=True)
class Labels:
    """Gauss-Legendre panels of the label of the cycles: first those without impacts, then those with impacts.

    The label is A/A_clear - 1 in [-1, 0] without impacts and the square root of the height above grazing with them.

    Parameters
    ----------
    edges : ndarray
        Ends of the panels.
    clear : int
        Number of panels without impacts.
    clear_amplitude : float
        A at the end of the cycles without impacts: the grazing amplitude, or the largest of interest; 0 if every cycle
        has impacts.
    """

    edges: Floats
    clear: int
    clear_amplitude: float

    @property
    def nodes(self) -> Floats:
        """Labels of the nodes, one row for each panel."""
        return on_panels(self.edges[:-1], self.edges[1:], _NODES)[0]

    @property
    def weights(self) -> Floats:
        """Weights of the integral over the label, in the shape of the nodes."""
        return on_panels(self.edges[:-1], self.edges[1:], _NODES)[1]

    def derivative(self, values: Floats) -> Floats:
        """Derivative by the label."""
        return np.asarray((self._rows(values) @ _DERIVATIVE.T / np.diff(self.edges)[:, None]).ravel())

    def integral(self, values: Floats) -> Floats:
        """Integral over the label from the first edge to each node."""
        width = np.diff(self.edges)[:, None]
        rows = self._rows(values) * width
        before = np.r_[0.0, np.cumsum(rows @ _WEIGHTS)[:-1]]
        return np.asarray((rows @ _INTEGRAL.T + before[:, None]).ravel())

    def interpolate(self, values: Floats, label: Floats) -> Floats:
        """Values of the nodes' polynomials at any labels, shape (..., quantities) for values (nodes, quantities)."""
        panel = np.clip(np.searchsorted(self.edges, label, side="right") - 1, 0, self.edges.size - 2)
        place = 2.0 * (label - self.edges[panel]) / (self.edges[panel + 1] - self.edges[panel]) - 1.0
        series = np.einsum("kn,pnq->pkq", _TO_LEGENDRE, values.reshape(-1, _NODES, values.shape[-1]))
        return np.asarray(np.einsum("...k,...kq->...q", legendre.legvander(place, _NODES - 1), series[panel]))

    def _rows(self, values: Floats) -> Floats:
        return values.reshape(-1, _NODES)


@dataclass(frozen=True)
class Stretch:
    """Correction of the cycles for a lossy wall: displacements are stretched, outgoing velocities reduced.

    A point (x, v) of a cycle goes to x' = wall + factor ((x - wall + near)^power - near^power) and
    v' = v_factor (v - skew sqrt(v^2 + soft^2) + lift), where ``lift`` makes the mean velocity 0.

    Parameters
    ----------
    wall, near, factor, power, soft, skew, lift, v_factor : float
        As above; ``near`` and ``soft`` keep both smooth at the wall and at rest, and the skew is below 1.
    """

    wall: float
    near: float
    factor: float
    power: float
    soft: float
    skew: float
    lift: float
    v_factor: float

    def x(self, x: Floats) -> Floats:
        """Corrected displacements."""
        above = np.maximum(x - self.wall, 0.0) + self.near
        return np.asarray(self.wall + self.factor * (above**self.power - self.near**self.power))

    def v(self, v: Floats) -> Floats:
        """Corrected velocities."""
        return np.asarray(self.v_factor * (v - self.skew * np.hypot(v, self.soft) + self.lift))

    def v_slope(self, v: Floats) -> Floats:
        """Derivative of the corrected velocities."""
        return np.asarray(self.v_factor * (1.0 - self.skew * v / np.hypot(v, self.soft)))

    def origin(self, x: Floats, v: Floats) -> tuple[Floats, Floats, Floats]:
        """Inverse of the correction, and the factor on areas."""
        z = np.clip(v / self.v_factor - self.lift, -_FASTEST, _FASTEST)
        rest = 1.0 - self.skew**2
        before = (z + self.skew * np.hypot(z, math.sqrt(rest) * self.soft)) / rest
        away = np.clip(x - self.wall, 0.0, _FARTHEST) / self.factor
        above = (away + self.near**self.power) ** (1.0 / self.power)
        place = np.where(x < self.wall, x, self.wall + above - self.near)
        return place, before, self.v_slope(before) * self.factor * self.power * above ** (self.power - 1.0)


@dataclass(frozen=True)
class Cells:
    """Cells of the diffusion in time; one entry per cell for every array, named as in `Balance`."""

    diffusion: EnergyDiffusion
    stretch: Stretch | None
    label: Floats
    area: Floats
    x_square: Floats
    v_square: Floats
    phase: Floats
    amplitude: Floats
    frequency: Floats
    centre: Floats


@dataclass(frozen=True)
class Balance:
    """The converged balance; one entry per node for every array.

    Parameters
    ----------
    problem, closure, labels
        The problem, the fixed point and the nodes.
    steps, change : int, float
        Number of fixed-point steps, and the change in the last one.
    phase, amplitude, frequency, centre : ndarray
        p, A, w and x_e of the cycles.
    mean, x_square, v_square : ndarray
        Means of x, x^2 and v^2 over a cycle.
    dissipation : ndarray
        Power that the springpot dissipates.
    rate, speed, before : ndarray
        Impacts per unit of time (0 without), the cycle's impact speed, and the square of the speed before an impact
        over the square of that.
    action, measure, weight : ndarray
        J, that of a cycle with its memory, dJ/dlabel, and the probability of the node's cell.
    area : ndarray
        Area of the plane of x and v between cycles, over 2 pi dJ: 1 without memory.
    fall, mobility : ndarray
        -ln of the stationary density per action, and D / J.
    density : ndarray
        Stationary density per label.
    diffusion : EnergyDiffusion
        On the same cells, without those of negligible weight.
    stretch : Stretch or None
        Correction for a lossy wall.  It is included in ``mean``, ``x_square`` and ``v_square``; the other arrays are
        those of the cycles.
    """

    problem: Problem
    closure: Closure
    labels: Labels
    steps: int
    change: float
    phase: Floats
    amplitude: Floats
    frequency: Floats
    centre: Floats
    mean: Floats
    x_square: Floats
    v_square: Floats
    dissipation: Floats
    rate: Floats
    speed: Floats
    before: Floats
    action: Floats
    measure: Floats
    weight: Floats
    area: Floats
    fall: Floats
    mobility: Floats
    density: Floats
    diffusion: EnergyDiffusion
    stretch: Stretch | None = None

    def average(self, values: Floats) -> float:
        """Stationary mean of a quantity of the cycles."""
        return float(self.weight @ values)

    @property
    def per_area(self) -> Balance:
        """With the probabilities of cycles per area of the plane of x and v."""
        weight = self.weight * self.area
        total = weight.sum()
        return replace(self, weight=weight / total, density=self.density * self.area / total)

    def from_origin(self, origin: float) -> tuple[float, float]:
        """Mean and mean square of x - origin."""
        mean = self.average(self.mean)
        return mean - origin, self.average(self.x_square) - 2.0 * origin * mean + origin * origin

    @property
    def taken(self) -> float:
        """Share of the input power that the springpot dissipates; impacts dissipate the rest."""
        return 2.0 * self.average(self.dissipation)

    @property
    def fundamental(self) -> float:
        """Mean of the cycles' 2 pi / period."""
        return self.average(math.pi * self.frequency / self.phase)

    def cycle(self, label: Floats, clear: int) -> tuple[Floats, Floats]:
        """Amplitude and frequency of the cycles with these labels; the first ``clear`` are without impacts."""
        cycles, slow_share = _mean_field(self.problem, self.closure)
        above_rest = self.problem.position - slow_share * self.closure.mean
        p, a = _shape(cycles, self.labels, label, clear, above_rest, slow_share)
        return a, cycles.frequency(p)

    def cells(self) -> Cells:
        """The same cycles on a finer grid, for the diffusion in time."""
        label, measure = panel_rule(self.labels.edges, _FINE_NODES)
        columns = (self.action, self.measure, self.fall, self.mobility, self.area, self.x_square, self.v_square)
        shapes = (self.phase, self.amplitude, self.frequency, self.centre)
        fine = self.labels.interpolate(np.stack([*columns, *shapes], axis=1), label).T
        density = np.exp(-fine[2])
        mass = density * np.maximum(fine[1], 0.0) * measure
        likely = (mass > 1e-25 * mass.max()) & (np.diff(np.maximum.accumulate(fine[0]), prepend=0.0) > 0.0)
        diffusion = make_energy_diffusion(fine[0, likely], mass[likely], (density * fine[3])[likely])
        kept = likely & np.isin(fine[0], diffusion.action)
        return Cells(diffusion, self.stretch, label[kept], *fine[4:, kept])


def balance(problem: Problem) -> Balance:
    """Solve for the stationary envelope.

    Parameters
    ----------
    problem : Problem
        One that dissipates energy.

    Raises
    ------
    ValueError
        If cycles of different size cross, the preload is too deep, or the iteration does not converge.

    Examples
    --------
    >>> from springpot.theory.problem import Problem
    >>> settled = balance(Problem(order=1.0, coefficient=0.5, position=0.0, restitution=1.0))
    >>> round(settled.average(settled.v_square), 6)
    1.0
    """
    closure, reach = Closure(), _first_reach(problem)
    short, long = 0.0, math.inf  # reaches that were too short and too long
    mix, best = Anderson(_DEPTH, _CUTOFF), None
    for steps in range(1, _STEPS + 1):
        current = _sweep(problem, closure, reach)
        target, fall = _close(current), float(current.fall[-1] - current.fall[0])
        change = _distance(closure, target)
        # with a far wall, cycles with impacts may be too long and those without too short
        fits = fall > 0.9 * _FAR and (fall < 1.3 * _FAR or reach == long)
        cycles = problem.order == 1.0 or closure.decay < _FORGETFUL * current.fundamental
        # where cycles nearly cross, convergence is not monotonic
        if fits and cycles and (best is None or change < best.change):
            best = replace(current, steps=steps, change=change)
            if change < _SETTLED:
                break
        if not fits and long < 1.001 * short:
            reach = long
        elif not fits:
            if steps > _FREE:
                short, long = (reach, long) if fall < _FAR else (short, reach)
            if short > 0.0 and long < math.inf:  # with a far wall the step below would oscillate
                reach = math.sqrt(short * long)
            else:
                reach *= math.sqrt(min(max(1.05 * _FAR / max(fall, 1e-9), 0.05), 10.0))
        closure = _next(mix, closure, target, 1.0 if steps <= _FREE else 1.0 / 3.0)
    if best is None or best.change > _UNSETTLED or float(best.phase.min()) < 1.1 * SMALLEST_PHASE:
        raise ValueError("the cycles of interest are out of reach, or their mean field does not settle.")
    return best


def _first_reach(problem: Problem) -> float:
    """Estimate of the largest amplitude of interest, from light damping at b = 0."""
    c, r, b = problem.coefficient, problem.restitution, problem.position
    damping = c * problem.out_of_phase + (2.0 / math.pi) * (1.0 - r * r) / (1.0 + r * r)
    reach = math.sqrt(_FAR / damping)
    if b > 0.0:  # the energy above the preload is b h rather than h^2 / 2
        return min(reach, 1.5 * _FAR / (damping * b))
    return reach


def _next(mix: Anderson, old: Closure, new: Closure, part: float) -> Closure:
    """The next point of the iteration; ``part`` is below 1 where whole steps do not converge.

    If the accelerated step gives inadmissible numbers, the plain step is taken.
    """
    here, there = np.array(astuple(old)), np.array(astuple(new))
    k0, _, decay, frequency, share, taken = following = mix.part_of_step(here, there, part)
    if k0 < 0.0 or min(decay, frequency) <= 0.0 or not (0.0 <= share <= 1.0 and 0.0 <= taken <= 1.0):
        following = here + part * (there - here)
    return Closure(*following.tolist())


def _distance(old: Closure, new: Closure) -> float:
    """Largest change; relative for numbers above 1."""
    changes = ((abs(b - a), max(1.0, abs(b))) for a, b in zip(astuple(old), astuple(new), strict=True))
    return max(float(change / size) for change, size in changes)


def _labels(clearance: float, reach: float) -> Labels:
    """Panels for cycles up to about ``reach``; ``clearance`` is the grazing amplitude, negative for a preload."""
    clear = np.zeros(0)
    amplitude = 0.0
    if clearance > 0.0:
        amplitude = min(clearance, reach)
        wide = amplitude > 0.2 * reach
        clear = np.array([-1.0, -0.9, -0.8, -0.7, -0.55, -0.33] if wide else [-1.0, -0.6])
    if clearance >= reach:
        return Labels(np.r_[clear, 0.0], clear.size, amplitude)
    largest = math.sqrt(max(reach - clearance, 0.3 * reach) if clearance > 0.0 else reach)
    smallest = max(0.35 * math.sqrt(2.0 * max(clearance, 0.0)), largest * 0.5 ** (_STRIKING_PANELS - 1))
    strike = np.geomspace(min(smallest, 0.3 * largest), largest, _STRIKING_PANELS)
    return Labels(np.r_[clear, 0.0, strike], clear.size, amplitude)


def _sweep(problem: Problem, closure: Closure, reach: float) -> Balance:
    """Every cycle for one closure."""
    alpha, c, b, r = problem.order, problem.coefficient, problem.position, problem.restitution
    k0, m = closure.slow_stiffness, closure.mean
    cycles, slow_share = _mean_field(problem, closure)
    rest = slow_share * m  # position of rest without impacts
    labels = _labels(rest - b, reach)
    label = labels.nodes.ravel()
    first = labels.clear * _NODES  # the first node of a striking cycle
    p, a = _shape(cycles, labels, label, first, b - rest, slow_share)
    w = cycles.frequency(p)
    w1 = math.pi * w / p
    k1 = np.maximum(w * w - 1.0, 0.0)
    bulge = a * np.sinc(p / math.pi) * (1.0 + k1)
    bulge[:first] = 0.0
    mean = (bulge + k0 * m) / (1.0 + k0)
    centre = mean - a * np.sinc(p / math.pi)
    centre[:first] = rest
    wave = a * a * harmonic_sum(p, 0.0)
    x_square = mean**2 + wave / 2.0
    v_square = 0.5 * (w * a) ** 2 * missing_sinc(2.0 * p)
    speed = w * a * np.sin(p)
    speed[:first] = 0.0
    rate = w1 / (2.0 * math.pi)
    rate[:first] = 0.0
    dashpot = 0.5 * c * problem.out_of_phase * w1 ** (1.0 + alpha) * a * a * harmonic_sum(p, 1.0 + alpha)
    before = before_impact(dashpot / v_square * 2.0 * p / w, r)
    dissipation = dashpot + closure.share * _broadening(problem, closure, p, a, w, w1)
    lost = dissipation + rate * 0.5 * (1.0 - r * r) * before * speed**2
    plain = v_square / w1
    action = plain - 0.25 * alpha * k1 * wave / w1  # Whitham's: dJ is the change of the stored energy over w1
    measure, area = (np.maximum(labels.derivative(each), 1e-12 * each) for each in (action, plain))
    fall = labels.integral(2.0 * lost / v_square * w1 * measure)
    density = np.exp(fall.min() - fall) * measure
    weight = labels.weights.ravel() * density
    total = weight.sum()
    mobility = v_square / (2.0 * w1 * w1 * action)
    return Balance(
        problem=problem,
        closure=closure,
        labels=labels,
        steps=0,
        change=math.inf,
        phase=p,
        amplitude=a,
        frequency=w,
        centre=centre,
        mean=mean,
        x_square=x_square,
        v_square=v_square,
        dissipation=dissipation,
        rate=rate,
        speed=speed,
        before=before,
        action=action,
        measure=measure,
        weight=weight / total,
        area=area / measure,
        fall=fall - fall.min(),
        mobility=mobility,
        density=density / total,
        diffusion=make_energy_diffusion(action, weight, np.exp(fall.min() - fall) * mobility),
    )


def _mean_field(problem: Problem, closure: Closure) -> tuple[Cycles, float]:
    """The cycles' frequencies, and k0 / (1 + k0)."""
    alpha, k0 = problem.order, closure.slow_stiffness
    broadened = problem.in_phase - (1.0 - alpha) * closure.decay / closure.frequency * problem.out_of_phase
    return make_cycles(alpha, problem.coefficient * max(broadened, 0.0)), k0 / (1.0 + k0)


def _shape(
    cycles: Cycles, labels: Labels, label: Floats, first: int, above_rest: float, slow_share: float
) -> tuple[Floats, Floats]:
    """Phase and amplitude of the cycles with these labels."""
    p = np.full(label.size, math.pi)
    a = np.empty(label.size)
    a[:first] = labels.clear_amplitude * (1.0 + label[:first])
    if first < label.size:
        height = 2.0 * labels.clear_amplitude + label[first:] ** 2
        p[first:] = cycles.phase_at(np.maximum(above_rest / height, -0.5), slow_share)
        a[first:] = height / (2.0 * np.sin(p[first:] / 2.0) ** 2)
    return p, a


def missing_sinc(angle: Floats) -> Floats:
    """1 - sin(angle) / angle, without cancellation."""
    small = angle**2 / 6.0 * (1.0 - angle**2 / 20.0)
    return np.where(angle < 0.01, small, 1.0 - np.sinc(angle / math.pi))


def before_impact(damping: Floats, r: float) -> Floats:
    """Energy before an impact over the mean energy between two impacts.

    With damping d and period T the energy H grows towards q / 2d, from r^2 times its value before the impact: the ratio
    is (1 - E) / (1 - r^2 E) over 1 - (1 - r^2) (1 - E) / ((1 - r^2 E) d T), with E = e^(-d T); 2 / (1 + r^2) undamped.
    """
    if r == 1.0:
        return np.ones_like(damping)
    z = np.maximum(damping, 1e-12)
    gone = -np.expm1(-z)
    # (z - gone) / z^2, without cancellation
    lag = np.where(z < 1e-3, 0.5 - z / 6.0, (z - gone) / z**2)
    return np.asarray(gone / (z * ((1.0 - r * r) * lag + r * r * gone / z)))


def _broadening(problem: Problem, closure: Closure, p: Floats, a: Floats, w: Floats, w1: Floats) -> Floats:
    """Extra power that the springpot dissipates because the harmonics are lines of finite width.

    The width comes from the decay of the amplitude's correlation.  The part due to impacts is not power of the
    springpot, so the correction is reduced in short flights from a lossy wall.
    """
    alpha = problem.order
    if alpha == 1.0 or closure.decay == 0.0:
        return np.zeros_like(p)
    sums = (w1 / w) ** 2 * harmonic_sum(p, 2.0 + alpha) - harmonic_sum(p, alpha)
    whole = 0.25 * problem.coefficient * problem.in_phase * (1.0 - alpha) * closure.decay
    counts = closure.taken ** (_SHORT * np.maximum(1.0 - 2.0 * p / math.pi, 0.0))
    return np.asarray(np.maximum(whole * counts * w1**alpha * a * a * sums, 0.0))


def _close(b: Balance) -> Closure:
    """The averages of the cycles of a sweep."""
    alpha, c = b.problem.order, b.problem.coefficient
    decay = 1.0 / (4.0 * b.average(b.v_square))
    frequency = b.average(b.frequency)
    mean = b.average(b.mean)
    taken = 1.0 if b.problem.restitution == 1.0 else min(b.taken, 1.0)
    plain = Closure(0.0, mean, decay, frequency, 0.0, taken)
    if alpha == 1.0 or c == 0.0:
        return plain
    kept = np.isin(b.action, b.diffusion.action)
    rates, squares = b.diffusion.spectrum(b.mean[kept])
    variance = float(squares.sum())
    if variance <= _STRUCK * b.from_origin(max(b.problem.position, 0.0))[1]:
        return plain
    extra = b.average(
        _broadening(b.problem, b.closure, b.phase, b.amplitude, b.frequency, math.pi * b.frequency / b.phase)
    )
    slow_stiffness, share = slow_line([(alpha, c)], rates, squares, b.fundamental, extra)
    return Closure(slow_stiffness, mean, decay, frequency, share, taken)


def slow_line(
    springpots: Iterable[tuple[float, float]], rates: Floats, squares: Floats, frequency: float, broadened: float
) -> tuple[float, float]:
    """What springpots do to the slow changes of the cycles' mean.

    Its correlation is a sum of exponentials, on each of which a springpot acts with C rate^alpha, less what makes the
    correlation smooth at lag 0.

    Parameters
    ----------
    springpots : iterable of (order, coefficient)
    rates, squares : ndarray
        Of the exponentials, and their parts of the variance.
    frequency : float
        Mean frequency of the cycles.
    broadened : float
        Power that the springpots would take because all lines but this one are broad.

    Returns
    -------
    stiffness, share : float
        The stiffness, and the share of the broadened lines' power that is left.
    """
    variance, stiffness, back, least = float(squares.sum()), 0.0, 0.0, 1.0
    for order, coefficient in springpots:
        late = saturated((rates / frequency) ** (1.0 - order) * math.sin(order * math.pi / 2.0), 1.0 / (1.0 - order))
        stiffness += coefficient * float(squares @ (rates**order * late)) / variance
        back += coefficient * float(squares @ rates) * float(squares @ rates**order) / variance
        least = min(least, order)
    return stiffness, float(saturated(np.array(back / broadened), 1.0 / least)) if broadened > 0.0 else 0.0


def saturated(y: Floats, power: float) -> Floats:
    """(1 - y) / (1 - y^power): 1 - y for small y, and never negative.

    Examples
    --------
    >>> saturated(np.array([0.5, 2.0]), 2.0).round(4)
    array([0.6667, 0.3333])
    """
    log = np.log(np.clip(y, 1e-200, 1e200))
    high = np.minimum(power * log, 700.0)
    near = np.abs(log) < 1e-9
    return np.where(near, 1.0 / power, np.expm1(log) / np.where(near, 1.0, np.expm1(high)))


_X, _W = legendre.leggauss(_NODES)
_WEIGHTS = _W / 2.0
_TO_LEGENDRE = np.linalg.inv(legendre.legvander(_X, _NODES - 1))
_UNIT = np.eye(_NODES)
_DERIVATIVE = 2.0 * legendre.legval(_X, legendre.legder(_UNIT)).T @ _TO_LEGENDRE
_INTEGRAL = 0.5 * legendre.legval(_X, legendre.legint(_UNIT, lbnd=-1)).T @ _TO_LEGENDRE
