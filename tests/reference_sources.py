"""The impulses of each excitation in each step, in plain Python, and the random numbers of which they are made.

`tests/reference.py`, which is to be read before this, takes them as they come.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from scipy import linalg

import springpot as sp
from springpot.machine.sampling import band_limited
from springpot.memory.exponential_sum import power_law_sum, shared_span
from springpot.simulation.lowering import shaping

Floats = np.ndarray
WORD = 0xFFFFFFFF


# ------------------------------------------------------------------------------------------------ random numbers
def philox(seed: int, path: int, group: int, word: int) -> list[int]:
    """Four words of 32 bits of a counter: Philox4x32-10 (Salmon and others, SC11)."""
    c, k = [group, path, 0, word], [seed & WORD, seed >> 32]
    for _ in range(10):
        a, b = 0xD2511F53 * c[0], 0xCD9E8D57 * c[2]
        c = [(b >> 32) ^ c[1] ^ k[0], b & WORD, (a >> 32) ^ c[3] ^ k[1], a & WORD]
        k = [(k[0] + 0x9E3779B9) & WORD, (k[1] + 0xBB67AE85) & WORD]
    return c


def normal_pair(radius: int, angle: int) -> tuple[float, float]:
    """Two normals of two words, by Box and Muller; the angle is counted from the nearest axis."""
    size = math.sqrt(-2.0 * math.log(((radius >> 1) + 0.5) / 2.0**31))
    turned = (angle << 2) & WORD
    beside = (turned - (1 << 32) * (turned >> 31)) / 2.0**31 * math.pi / 4.0
    along, across = (-1.0 if angle >> 31 else 1.0) * math.cos(beside), math.sin(beside)
    return (size * along, size * across) if (angle >> 30) & 1 else (size * across, size * along)


@cache
def normals(seed: int, path: int, steps: int, word: int) -> Floats:
    """One for each step; four steps share a counter."""
    found: list[float] = []
    for group in range(-(-steps // 4)):
        a, b, c, d = philox(seed, path, group, word)
        found += [*normal_pair(a, b), *normal_pair(c, d)]
    drawn = np.array(found[:steps])
    drawn.flags.writeable = False
    return drawn


@dataclass(frozen=True)
class Numbers:
    """The random numbers of one source on one path: those of the counter words from its first on."""

    draw: Callable[..., Floats]
    seed: int
    path: int
    first: int

    def normals(self, steps: int, word: int = 0) -> Floats:
        return self.draw(self.seed, self.path, steps, self.first + word)

    def words(self, group: int) -> list[int]:
        return philox(self.seed, self.path, group, self.first)

    @property
    def uniform(self) -> float:
        """Between 0 and 1, one for the whole path."""
        return (self.words(0)[0] + 0.5) / 2.0**32


# ------------------------------------------------------------------------------------------------------ excitation
def harmonic(part: sp.Harmonic, h: float, steps: int, draw: Numbers) -> Floats:
    """Impulses of a force whose phase is drawn once for each path."""
    phase = 2.0 * math.pi * draw.uniform
    ends = part.frequency * h * np.arange(steps + 1) + phase
    return part.amplitude / part.frequency * np.diff(np.sin(ends))


def poisson(part: sp.PoissonImpulses, h: float, steps: int, draw: Numbers) -> Floats:
    """In each step a number of impulses by the inverse of its law, and for their sum one normal."""
    sizes, found = draw.normals(steps, 1), np.zeros(steps)
    for n in range(steps):
        left, count = (draw.words(n // 4)[n % 4] + 0.5) / 2.0**32, 0
        chance = math.exp(-part.rate * h)
        while left > chance > 0.0:
            left, count = left - chance, count + 1
            chance *= part.rate * h / count
        found[n] = math.sqrt(count * part.mean_square) * sizes[n]
    return found * envelope_of(part, h, steps)[1:]


def recorded(part: sp.RecordedExcitation, h: float, steps: int, draw: Numbers) -> Floats:
    """Impulses of the straight lines between the points of a record; each path has its record, in turn or drawn."""
    taken = draw.path % part.count
    if part.is_drawn and part.count > 1:
        taken = draw.words(0)[0] * part.count >> 32
    times, values = (np.array(each, float) for each in part.records[taken])
    times, ends = times - times[0], h * np.arange(steps + 1)
    if part.interpolation == "band-limited":  # lines between points of the signal, eight or more in a step
        fold = min(max(math.ceil(8.0 * times[-1] / (len(times) - 1) / h), 1), 32)
        values = band_limited(values, fold)
        times = np.linspace(0.0, times[-1], len(values))
    at = np.union1d(times, ends[ends <= times[-1]])
    height = part.scale * np.interp(at, times, values)
    whole = np.append(0.0, np.cumsum(0.5 * np.diff(at) * (height[1:] + height[:-1])))
    return np.diff(np.interp(ends, at, whole))


def white(part: sp.WhiteNoise, h: float, steps: int, draw: Numbers) -> Floats:
    """Of noise with an envelope."""
    return math.sqrt(part.intensity * h) * envelope_of(part, h, steps)[1:] * draw.normals(steps)


def envelope_of(part: Any, h: float, steps: int) -> Floats:
    """By which noise is multiplied: at time 0, and in the middle of each step."""
    times = np.append(0.0, h * (np.arange(steps) + 0.5))
    return np.ones(steps + 1) if part.envelope is None else np.asarray(part.envelope.at(times))


@dataclass
class Filter:
    """Of white noise: the force is c.y, with y' = a y + white noise of the covariance b per time.

    States come in twos; that of colored noise has one beside it that is silent.
    """

    a: Floats
    b: Floats
    c: Floats

    @classmethod
    def of(cls, part: Any, time: float) -> Filter:
        """That of a noise, as it is at a time."""
        if isinstance(part, sp.ColoredNoise):
            return cls.of_arms([(part.variance, 1.0 / part.correlation_time)], 1.0)
        if isinstance(part, sp.SpectralExcitation):  # the rational density that was fitted to the table
            fitted = shaping.filter_of(shaping.shape_of(part, ""), 0.5 * part.scale * max(part.psd), 2.0 * math.pi)
            return cls(fitted.matrix, fitted.noise, fitted.output)
        w, twice = part.frequency + part.frequency_rate * time, 2.0 * part.damping
        ground, output = [[0.0, 1.0], [-w * w, -twice * w]], [w * w, twice * w]
        if isinstance(part, sp.KanaiTajimiNoise):
            return cls(np.array(ground), np.diag([0.0, part.intensity]), np.array(output))
        u, own = part.base_frequency, 2.0 * part.base_damping
        a, b = np.zeros((4, 4)), np.diag([0.0, part.intensity, 0.0, 0.0])
        a[:2, :2], a[2, 3], a[3] = ground, 1.0, [*output, -u * u, -own * u]
        return cls(a, b, a[3])

    @classmethod
    def of_arms(cls, arms: list[tuple[float, float]], temperature: float) -> Filter:
        """Exponentially correlated noises, of variances and rates, times the temperature."""
        arms = arms + [(0.0, 1.0)] * (len(arms) % 2)
        strengths, rates = np.array(arms).T
        return cls(np.diag(-rates), np.diag(2.0 * temperature * strengths * rates), (strengths > 0.0).astype(float))

    def over(self, h: float) -> tuple[Floats, Floats]:
        """After a step, the state and behind it the impulse: from the state before it, and the covariance of noise."""
        size = len(self.c) + 1
        joint = np.zeros((2 * size, 2 * size))
        joint[size:-1, size:-1], joint[size:-1, -1], joint[: size - 1, size:-1] = self.a.T, self.c, self.b
        joint[:size, :size] = -joint[size:, size:].T
        halvings = max(0, math.ceil(math.log2(h * np.abs(joint).sum(axis=1).max())) + 1)  # of fast filters
        power = linalg.expm(0.5**halvings * h * joint)  # by Van Loan
        move = power[size:, size:].T
        noise = move @ power[:size, size:]
        for _ in range(halvings):
            move, noise = move @ move, noise + move @ noise @ move.T
        return move, 0.5 * (noise + noise.T)

    def stationary(self) -> Floats:
        """Covariance of the state."""
        return np.asarray(linalg.solve_continuous_lyapunov(self.a, -self.b))


def filtered(part: Any, h: float, steps: int, draw: Numbers) -> Floats:
    """Impulses of noise through a filter; where it has an envelope, its white noise is multiplied by that.

    They are a Gaussian sequence.  Each is foreseen from all earlier ones, by the best guess of the state of the filter,
    but for one normal (Kalman): exact, however short the correlation time.  Noise without an envelope begins as if it
    had been seen for ever, that of Clough and Penzien as if nothing had been seen of it.
    """
    sizes, squares = draw.normals(steps), envelope_of(part, h, steps) ** 2
    times = np.append(0.0, h * (np.arange(steps) + 0.5)) if getattr(part, "frequency_rate", 0.0) else [0.0, 0.0]
    filters = [Filter.of(part, time) for time in times]
    laws = [each.over(h) for each in filters[1:]] * (steps if len(filters) == 2 else 1)
    guess, unsure = np.zeros(len(filters[0].c)), squares[0] * filters[0].stationary()  # and its covariance
    if part.envelope is None and not isinstance(part, sp.CloughPenzienNoise):
        guess, unsure = begun(filters[0], laws[0], 0.0, draw)
    return foreseen(laws, squares[1:], guess, unsure, 0.0, sizes)


def spectral(part: sp.SpectralExcitation, h: float, steps: int, draw: Numbers) -> Floats:
    """Noise of a given density, multiplied itself; a little white noise is added for the sake of the arithmetic."""
    own = Filter.of(part, 0.0)
    move, noise = own.over(h)
    more = 1e-8 * float(move[-1, :-1] @ own.stationary() @ move[-1, :-1] + noise[-1, -1])
    found = foreseen(
        [(move, noise)] * steps, np.ones(steps), *begun(own, (move, noise), more, draw), more, draw.normals(steps)
    )
    return found * envelope_of(part, h, steps)[1:]


def matched(memories: list[Any], temperature: float, h: float, steps: int, draw: Numbers) -> Floats:
    """The noise at a temperature of Maxwell's arms and springpots, and of dashpots beside them.

    That of a springpot has its kernel as covariance, which is taken for a sum of exponentials from 1/64 of a step on,
    and what these lack of its integral up to 1/16 for white.
    """
    arms = [(part.stiffness, part.stiffness / part.coefficient) for part in memories if isinstance(part, sp.Maxwell)]
    flat = dashpots_in(memories)
    for part in memories:
        if isinstance(part, sp.FractionalMaxwell):
            raise NotImplementedError("the noise of FractionalMaxwell")
        if isinstance(part, sp.Springpot):
            law = power_law_sum(part.order, 1 / 64, float(shared_span(steps)), 1e-4)
            c, near = part.coefficient * h**-part.order, 1 / 16
            strengths = c * law.weights / math.gamma(1.0 - part.order)
            arms += zip(strengths.tolist(), (law.rates / h).tolist(), strict=True)
            kept = float((strengths * -np.expm1(-law.rates * near) / law.rates).sum())
            flat += h * max(c * near ** (1.0 - part.order) / math.gamma(2.0 - part.order) - kept, 0.0)
    own, more = Filter.of_arms(arms, temperature), 2.0 * temperature * h * flat
    law = own.over(h)
    return foreseen([law] * steps, np.ones(steps), *begun(own, law, more, draw), more, draw.normals(steps))


def dashpots_in(memories: list[Any]) -> float:
    """The sum of their coefficients."""
    return sum(part.coefficient for part in memories if isinstance(part, sp.Dashpot))


def foreseen(
    laws: list[tuple[Floats, Floats]], squares: Floats, guess: Floats, unsure: Floats, more: float, sizes: Floats
) -> Floats:
    """Impulses from the laws of the steps, the squares of an envelope in them, and normals; ``more`` is white."""
    found = np.zeros(len(sizes))
    for n, (move, noise) in enumerate(laws):
        spread, move, seen = squares[n] * noise, move[:-1, :-1], move[-1, :-1]
        root = math.sqrt(seen @ unsure @ seen + spread[-1, -1] + more)
        gain = (move @ unsure @ seen + spread[:-1, -1]) / root if root > 0.0 else 0.0 * seen
        found[n] = seen @ guess + root * sizes[n]
        guess = move @ guess + gain * sizes[n]
        unsure = move @ unsure @ move.T + spread[:-1, :-1] - np.outer(gain, gain)
    return found


def begun(own: Filter, law: tuple[Floats, Floats], more: float, draw: Numbers) -> tuple[Floats, Floats]:
    """Of stationary noise the guess at time 0, from normals by a triangle, and its covariance after endless time."""
    (move, noise), stationary = law, own.stationary()
    each = move[:-1, :-1].T, move[-1:, :-1].T, noise[:-1, :-1], noise[-1:, -1:] + more
    unsure = linalg.solve_discrete_are(*each, s=noise[:-1, -1:])
    values, vectors = np.linalg.eigh(stationary - unsure)
    root = np.tril(np.linalg.qr((vectors * np.sqrt(np.maximum(values, 0.0))).T)[1].T)
    root *= np.where(np.diag(root) < 0.0, -1.0, 1.0)  # the one root whose diagonal is not negative
    sizes = np.concatenate([draw.normals(4, 64 + k) for k in range(-(-len(root) // 4))])
    return root @ sizes[: len(root)], unsure


GIVEN: dict[type, Callable[..., Floats]] = {
    sp.Harmonic: harmonic, sp.PoissonImpulses: poisson, sp.RecordedExcitation: recorded, sp.WhiteNoise: white,
    sp.ColoredNoise: filtered, sp.KanaiTajimiNoise: filtered, sp.CloughPenzienNoise: filtered,
    sp.SpectralExcitation: spectral,
}  # fmt: skip
