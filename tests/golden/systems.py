"""Random systems in which every kind of part stands beside every other kind that it may stand beside."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import combinations

import numpy as np

import springpot as sp

__all__ = ["PARTS", "pairs_in", "random_systems"]

Draw = np.random.Generator


def _push(t: float, x: float, v: float) -> float:
    return 0.05 * math.sin(t) - 0.02 * v + 0.0 * x


def _law(speed: float) -> float:
    return 0.9 / (1.0 + 0.1 * speed)


def _on(draw: Draw) -> str:
    return ("mass", "ground")[int(draw.integers(2))]


def _record(draw: Draw) -> sp.RecordedExcitation:
    time = np.arange(0.0, 40.0, 0.5)
    return sp.RecordedExcitation(tuple(time.tolist()), tuple(draw.normal(0.0, 0.3, time.size).tolist()), _on(draw))


PARTS: dict[str, Callable[[Draw], object]] = {
    "mass": lambda draw: sp.Mass(draw.uniform(0.5, 2.0)),
    "spring": lambda draw: sp.Spring(draw.uniform(0.5, 3.0)),
    "polynomial_spring": lambda draw: sp.PolynomialSpring((draw.uniform(0.0, 0.5), 0.0, draw.uniform(0.01, 0.5))),
    "springpot": lambda draw: sp.Springpot(draw.uniform(0.05, 0.95), draw.uniform(0.05, 0.8)),
    "springpot_0": lambda draw: sp.Springpot(0.0, draw.uniform(0.05, 0.8)),
    "springpot_1": lambda draw: sp.Springpot(1.0, draw.uniform(0.05, 0.5)),
    "series": lambda draw: sp.FractionalMaxwell(
        sp.Springpot(draw.uniform(0.2, 0.9), 0.5), sp.Spring(draw.uniform(0.5, 2.0))
    ),
    "maxwell": lambda draw: sp.Maxwell(draw.uniform(0.2, 1.0), draw.uniform(0.2, 1.0)),
    "circuit": lambda draw: sp.PiezoelectricCircuit(
        draw.uniform(0.1, 0.5), draw.uniform(0.5, 2.0), draw.uniform(0.5, 2.0)
    ),
    "dashpot": lambda draw: sp.Dashpot(draw.uniform(0.05, 0.5)),
    "polynomial_dashpot": lambda draw: sp.PolynomialDashpot((0.05, draw.uniform(0.0, 0.1), draw.uniform(0.01, 0.1))),
    "van_der_pol": lambda draw: sp.VanDerPol(draw.uniform(0.02, 0.2), draw.uniform(0.5, 1.5)),
    "friction": lambda draw: sp.Friction(draw.uniform(0.02, 0.2)),
    "wall": lambda draw: sp.Barrier(-draw.uniform(0.0, 1.5), draw.uniform(0.4, 1.0)),
    "wall_below": lambda draw: sp.Barrier(draw.uniform(0.2, 1.5), draw.uniform(0.4, 1.0), side="below"),
    "wall_elastic": lambda draw: sp.Barrier(-draw.uniform(0.0, 1.5)),
    "wall_power": lambda draw: sp.Barrier(-draw.uniform(0.3, 1.5), sp.PowerRestitution(0.8, 1.0, 0.2)),
    "wall_law": lambda draw: sp.Barrier(draw.uniform(0.3, 1.5), _law, side="below"),
    "contact": lambda draw: sp.Contact(-draw.uniform(0.3, 1.0), draw.uniform(20.0, 200.0)),
    "contact_lossy": lambda draw: sp.Contact(draw.uniform(0.3, 1.0), 50.0, 1.5, draw.uniform(0.1, 0.5), "below"),
    "white_noise": lambda draw: sp.WhiteNoise(draw.uniform(0.2, 1.5), _on(draw)),
    "colored_noise": lambda draw: sp.ColoredNoise(draw.uniform(0.1, 0.8), draw.uniform(0.2, 2.0), _on(draw)),
    "kanai_tajimi_noise": lambda draw: sp.KanaiTajimiNoise(
        draw.uniform(1.0, 3.0), draw.uniform(0.2, 0.6), 0.3, _on(draw)
    ),
    "thermal_noise": lambda draw: sp.ThermalNoise(draw.uniform(0.1, 0.6)),
    "poisson_impulses": lambda draw: sp.PoissonImpulses(draw.uniform(0.2, 1.0), draw.uniform(0.1, 0.5), _on(draw)),
    "parametric_noise": lambda draw: sp.ParametricNoise(draw.uniform(0.001, 0.02)),
    "harmonic": lambda draw: sp.Harmonic(draw.uniform(0.1, 0.6), draw.uniform(0.5, 2.0), _on(draw)),
    "constant": lambda draw: sp.Constant(draw.uniform(-0.3, 0.3)),
    "recorded": _record,
    "force": lambda draw: sp.Force(_push, 0.5),
}
"""Ways of making a part, each with numbers at random."""

_TRIES, _MOST = 60, 7


def _made(names: list[str], draw: Draw) -> sp.System | None:
    """A system of these parts, or None where they do not fit together; a spring where nothing else holds the mass."""
    parts = [PARTS[name](draw) for name in names]
    springs = sp.Spring | sp.PolynomialSpring
    if not any(isinstance(part, springs) for part in parts) and draw.random() < 0.7:
        parts.append(sp.Spring(1.0))
    try:
        return sp.System(*parts)
    except ValueError:
        return None


def pairs_in(names: tuple[str, ...]) -> set[tuple[str, str]]:
    """All pairs among some kinds of parts, in alphabetical order."""
    return set(combinations(sorted(names), 2))


def random_systems(count: int = 100, seed: int = 28) -> list[tuple[tuple[str, ...], sp.System]]:
    """Each the one of many random ones that has most pairs of parts that no system before it has; with its kinds."""
    draw = np.random.default_rng(seed)
    found: list[tuple[tuple[str, ...], sp.System]] = []
    seen: set[tuple[str, str]] = set()
    while len(found) < count:
        best: tuple[tuple[str, ...], sp.System] | None = None
        for _ in range(_TRIES):
            size = int(draw.integers(2, _MOST + 1))
            names = [str(name) for name in draw.choice([*PARTS], size, replace=False)]
            system = _made(names, draw)
            if system is not None and (
                best is None or len(pairs_in(tuple(names)) - seen) > len(pairs_in(best[0]) - seen)
            ):
                best = tuple(names), system
        if best is not None:
            found.append(best)
            seen |= pairs_in(best[0])
    return found
