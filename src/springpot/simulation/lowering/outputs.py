"""From forces of parts and absolute accelerations to what the kernel adds up for observers."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from springpot.machine.arrays import Floats
from springpot.machine.faults import per_cent
from springpot.problem.messages import Message, say
from springpot.problem.parts.excitations import Excitation
from springpot.simulation.kernel.outputs import NUMBERS
from springpot.simulation.lowering.parts import Lowered, contact_time, numbers_of
from springpot.simulation.plan.motion import Motion
from springpot.simulation.plan.plan import Plan
from springpot.simulation.plan.settings import Settings
from springpot.simulation.plan.signals import Signal

# steps over which means over steps are compared with values; with more, rounding is all that is left
_MOST_LAGS = 20_000
_FAST = 3.0  # standard deviations of the velocity at a touch whose force is a largest one
_MISSED = (
    4.0  # share of the largest force between steps, times the square of the steps of a touch: measured 3.8, r = 0.6
)
_WORTH_SAYING, _SMALL = 0.02, 0.01
EXCEEDED_BY_NOISE = 0.771  # by which colored noise exceeds its means over steps, per root of its variance's rate


@dataclass(frozen=True, eq=False)
class OutputsInKernel:
    """The terms of all outputs, as `springpot.simulation.kernel.watching.table_of` takes them.

    Attributes
    ----------
    begin, row, numbers : ndarray
    lacking : dict of float
        What the mean square of each lacks by name, because the kernel sees the mean force of a step.
    lacking_in_steps : dict of ndarray
        The same in each step, where envelopes change it; otherwise one number.
    over : dict of float
        By how much each exceeds, between two steps, what the kernel sees there, on average near a high level.
    scale : float
        A power of two that brings what the kernel shows near 1.
    force, length : float
        The kernel's unit of the forces of contacts, and that of length.
    """

    begin: npt.NDArray[np.int64] = field(default_factory=lambda: np.zeros(1, np.int64))
    row: npt.NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, np.int64))
    numbers: Floats = field(default_factory=lambda: np.zeros(0))
    lacking: Mapping[str, float] = field(default_factory=dict)
    lacking_in_steps: Mapping[str, Floats] = field(default_factory=dict)
    over: Mapping[str, float] = field(default_factory=dict)
    scale: float = 1.0
    force: float = 1.0
    length: float = 1.0

    def exceeding(self, number: int) -> float:
        """What ``over`` has of one of them, as the kernel shows it."""
        return [*self.over.values()][number] / self.length


def roughness_in_steps(plan: Plan, outputs: OutputsInKernel, signal: Signal) -> Floats:
    """How rough noise makes what is seen in each step, over what it would be with the usual intensity.

    That is, of a velocity, the intensity without envelopes, and of a force or an acceleration its mean over the window.
    """
    if signal.outputs:
        name = [*outputs.lacking][signal.outputs[0]]
        own, usual = outputs.lacking_in_steps[name], outputs.lacking[name]
    else:
        own, usual = plan.motion.intensity_of(signal, plan.settings.middles), plan.motion.intensity_of(signal)
    share = own / usual if usual > 0.0 else np.zeros(1)
    return np.broadcast_to(np.sqrt(np.maximum(share, 0.0)), plan.settings.steps)


def lowered_outputs(
    plan: Plan, rows: Sequence[Mapping[str, Lowered]], g: Floats, place: float, jumps: Floats, unit: float,
    length: float, step: float, sources: Mapping[str, int], yielding: Mapping[str, tuple[int, float]],
    modulated: Sequence[tuple[Floats, Floats]] = (),
) -> OutputsInKernel:  # fmt: skip
    """The terms of each force or acceleration.

    Parameters
    ----------
    plan : Plan
    rows : sequence of dict
        The parts on each row, by name.
    g : ndarray, shape (rows, coordinates)
    place : float
        From which the kernel measures; other than 0 with linear springs alone.
    jumps : ndarray, shape (coordinates, coordinates)
        Covariance of what noise brings to the velocities in a step.
    unit, length : float
        The unit of mass over the square of that of time; and that of length.
    step : float
        In the kernel's units.
    sources : dict of int
        The numbers of the sources that are smooth, by name.
    yielding : dict of (int, float)
        Of what yields the first place of its states, and the impulse of its stiffness in half a step.
    modulated : sequence of (ndarray, ndarray)
        Of each noise with an envelope its part of ``jumps``, and by which factor that differs from it in each step.
    """
    outputs, excitations = plan.motion.outputs, dict(plan.system.named())
    # of a run that is far shorter than any time of the motion there would be as many as memory holds
    lags = min(math.ceil(1.0 / (plan.motion.scales.fastest_rate * plan.settings.step)), _MOST_LAGS)
    begin, row, numbers, lacking, in_steps, over = [0], list[int](), list[Floats](), {}, {}, {}
    low, high = plan.settings.window_steps

    def new_term(of_row: int) -> Floats:
        row.append(of_row)
        numbers.append(np.zeros(NUMBERS))
        return numbers[-1]

    for name, each in outputs.items():
        rough = list[tuple[float, Floats]]()
        for e, parts in enumerate(rows):
            own = {n: part for n, part in parts.items() if n in each.shares}
            if each.reason or not own:
                continue
            term = new_term(e)
            for n, part in own.items():
                share = unit * each.shares[n]
                term[: len(part.springs)] += share * np.array(part.springs)
                term[0] += share * place * sum(part.springs[1:2])
                term[10] = share if part.remembers else term[10]
                term[11] += share * part.dashpots
                rough += [(order, share * c * g[e]) for order, c in part.springpots]
            term[11] -= term[10] * sum(part.dashpots for part in parts.values())
            for n, contact in ((n, contact) for n, part in own.items() for _, contact in part.contacts):
                term = new_term(e)
                term[12], term[15:] = -unit * each.shares[n] * contact.inwards, numbers_of(contact)
            for n in (n for n in own if n in yielding):
                state, impulse = yielding[n]
                term = new_term(e)
                term[13] = 2.0 * unit * each.shares[n] * impulse / step
                term[14] = state + 3
        if each.constant and len(row) > begin[-1]:
            numbers[begin[-1]][0] += each.constant / length
        smooth = {n: share for n, share in each.shares.items() if n in sources and not each.reason}
        for n, share in smooth.items():
            new_term(-1 - sources[n])[10] = unit * share / step
        begin.append(len(row))

        def lacks(jumps: Floats, rough: list[tuple[float, Floats]] = rough) -> float:
            return length**2 * sum(
                float(one @ jumps @ other) * _lack(a, b, step, lags)
                for (a, one), (b, other) in itertools.product(rough, rough)
            )

        lacking[name] = lacks(jumps)
        orders = {order: sum(one for of, one in rough if of == order) for order, _ in rough}
        exceeded = sum(_exceeded(order, step) ** 2 * float(one @ jumps @ one) for order, one in orders.items())
        exceeded *= length**2
        in_steps[name] = lacking[name] + sum((lacks(own) * (factor - 1.0) for own, factor in modulated), np.zeros(1))
        for n, share in smooth.items():
            own = share**2 * _lack_of(excitations[n], plan.settings.step) * _squares(excitations[n], plan.settings)
            lacks_of_it = float(np.mean(own if np.ndim(own) == 0 else own[low:high]))
            lacking[name] += lacks_of_it
            exceeded += EXCEEDED_BY_NOISE**2 * 6.0 * lacks_of_it
            in_steps[name] = in_steps[name] + own
        over[name] = math.sqrt(max(exceeded, 0.0))
    whole, scale = np.concatenate([np.zeros(0), *numbers]), 2.0 ** -round(math.log2(unit))
    rows_of_terms = np.array(row, np.int64)
    return OutputsInKernel(np.array(begin), rows_of_terms, whole, lacking, in_steps, over, scale, unit * length, length)


def _squares(part: Excitation, settings: Settings) -> Any:
    """Of its envelope in the middle of each step; 1 without one."""
    return 1.0 if part.envelope is None else part.square_at(settings.middles)


def _exceeded(order: float, step: float) -> float:
    """By how much the force of a springpot exceeds its means over steps, per standard deviation of an impulse.

    Near a maximum the force is that of fractional noise.  The number is from 5,000 random walks or more of it for each
    of eleven orders, within 3 % of them from order 0.4 on; for a dashpot it is that of 40,000.
    """
    smoother = 1.0 - order
    return float(step**smoother * 0.894 / (1.0 + 2.85 * smoother + 1.6 * smoother**2))


def _lack_of(part: Excitation, step: float) -> float:
    """What the mean square of a force lacks by its mean over a step: of a density like r / (2 pi w^2), r h / 6."""
    density, far = getattr(part, "density", None), 1e3 / step
    return 0.0 if density is None else 2.0 * math.pi * far**2 * density(far) * step / 6.0


def _lack(one: float, other: float, step: float, lags: int) -> float:
    """What the product of the forces of two springpots lacks by their means over a step, per variance of an impulse.

    The force due to an impulse at an age t is C t^(1 - order) / Gamma(2 - order); in the kernel it is the mean over the
    step in which the force is seen, and over that in which the noise comes.
    """
    n = np.arange(lags + 1.0)
    power = 3.0 - one - other
    whole = float(lags + 1) ** (power + 1.0) - float(lags) ** (power + 1.0)
    whole /= power * (power + 1.0) * math.gamma(2.0 - one) * math.gamma(2.0 - other)
    seen = []
    for order in (one, other):
        own = 3.0 - order
        below = np.where(n > 0.0, np.abs(n - 1.0) ** own, 0.0)
        seen.append(((n + 1.0) ** own - 2.0 * n**own + below) / math.gamma(4.0 - order))
    return float(step ** (2.0 - one - other) * (whole - (seen[0] * seen[1]).sum()))


def about_contacts(motion: Motion, step: float, names: Iterable[str], values: Mapping[str, float]) -> list[Message]:
    """Of forces and accelerations with contacts in them, whose largest values are seen at the steps only.

    Parameters
    ----------
    motion : Motion
    step : float
        In s.
    names : iterable of str
        Of the forces and accelerations.
    values : dict
        Results by name: a contact without impacts is not named.

    Examples
    --------
    >>> import springpot as sp
    >>> from springpot.simulation.plan.motions import motion_of
    >>> box = sp.System(sp.Spring(1.0), sp.Dashpot(0.1), sp.Contact.linear(-1.0, 100.0), sp.WhiteNoise(0.1))
    >>> [len(about_contacts(motion_of(box), step, ["contact_force"], {})) for step in (0.1, 0.01)]
    [1, 0]
    """
    system, at, lasting = motion.system, motion.system.coordinates, dict[str, float]()
    for name, part in system.contacts.items():
        if values.get(f"{name}_impact_rate", values.get("impact_rate")) != 0.0:
            row = at.elongations[name]
            speed, free = motion.size_of(Signal(row=row))[2], replace(part, stiffness=part.stiffness / at.reduced(row))
            if speed > 0.0:
                lasting[name] = contact_time(free, _FAST * speed)
    found = []
    for name in names:
        shares = motion.outputs[name].shares if name in motion.outputs else {}
        touched = ((time, own) for own, time in lasting.items() if shares.get(own))
        time, contact = min(touched, key=lambda each: each[0], default=(math.inf, ""))
        if (lacking := _MISSED / (time / step) ** 2) > _WORTH_SAYING:
            most, share = time * math.sqrt(_SMALL / _MISSED), per_cent(min(lacking, 1.0))
            found.append(
                say("peaks_between_steps", name=name, contact=contact, steps=time / step, lacking=share, most=most)
            )
    return found
