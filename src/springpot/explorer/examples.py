"""Cases to choose from on the page."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from springpot.explorer.sliders import numbers
from springpot.problem.oscillator import Oscillator
from springpot.problem.parts import Barrier, Dashpot, Springpot
from springpot.problem.system import System

_ORDER, _COEFFICIENT, _STIFFNESS = "springpot-order", "springpot-coefficient", "spring-stiffness"
_POSITION, _RESTITUTION = "barrier-position", "barrier-restitution"
_PAPER: dict[str, tuple[str, dict[str, float]]] = {
    "The paper: wall at rest, elastic": (
        "Half-order springpot at C = Ω = q = 1, the middle of the paper's figure.", {}),
    "Light damping": (
        "Where averaging is accurate: a narrow band, and a slow approach to the stationary state.",
        {_COEFFICIENT: 0.1}),
    "Dashpot: solved exactly": (
        "At α = 1 the impacting oscillator is the mirrored linear one, and all theories must meet.", {_ORDER: 1.0}),
    "Rubber-like: small order": (
        "Nearly a spring with a long memory: a run from rest stays transient for long.", {_ORDER: 0.2}),
    "Pounding across a gap": (
        "A building with a neighbor: wall half a length scale away, lossy impacts, light damping.",
        {_ORDER: 0.6, _COEFFICIENT: 0.15, _POSITION: -0.5, _RESTITUTION: 0.65}),
    "Preload: pressed to a stop": (
        "The spring presses the mass to the wall, as in a valve or a contact probe: short hops.",
        {_COEFFICIENT: 0.5, _POSITION: 0.6, _RESTITUTION: 0.8}),
    "Very lossy wall": (
        "Energy leaves at the wall; slow impacts crowd together.", {_COEFFICIENT: 0.1, _RESTITUTION: 0.5}),
    "Ω = 3: the misprint shows": (
        "Away from Ω = 1 the formula as printed is off by the factor Ω that was lost on the way to Eq. 18.",
        {_ORDER: 0.7, _COEFFICIENT: 0.2, _STIFFNESS: 9.0}),
    "α = 0: no stationary state": (
        "An elastic element dissipates nothing: the energy grows as q t / 2, and no theory claims otherwise.",
        {_ORDER: 0.0}),
}  # fmt: skip


def examples(system: System, file: str) -> Iterator[dict[str, Any]]:
    """Label and note of each case, the numbers that differ from those of the page, and parts that are left out.

    The paper's oscillator has cases of its own; of any other system the first one is the system as it was opened.

    Examples
    --------
    >>> from springpot.problem.parts import Spring
    >>> [case["label"] for case in examples(System(Spring(1.0), Barrier(-1.0, 0.5)), "device.toml")]
    ['device.toml', 'Elastic walls', 'Without walls']
    """
    known = numbers(system)
    if system == Oscillator():
        cases = _PAPER
    else:
        own = {
            "Elastic walls": ("No rigid wall takes energy.", _all(system, Barrier, "restitution", 1.0)),
            "Springpots as dashpots": ("Order 1, with the same coefficients.", _all(system, Springpot, "order", 1.0)),
            "A tenth of the damping": (
                "A tenth of the coefficients of springpots and dashpots.",
                {name: 0.1 * known[name] for name in _all(system, Springpot | Dashpot, "coefficient", 0.0)},
            ),
        }
        other = {label: case for label, case in own.items() if case[1].items() - known.items()}
        cases = {file or "As it was opened": ("", {})} | other
    for label, (note, changed) in cases.items():
        yield {"label": label, "note": note, "numbers": changed, "without": []}
    if walls := [*system.stops]:
        yield {"label": "Without walls", "note": "All else is the same.", "numbers": {}, "without": walls}


def _all(system: System, kinds: Any, field: str, value: float) -> dict[str, float]:
    """A value for the same number of all parts of a kind, as far as it is a number."""
    known, names = numbers(system), (f"{name}-{field}" for name, part in system.named() if isinstance(part, kinds))
    return {name: value for name in names if name in known}
