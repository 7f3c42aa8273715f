"""Arguments of a run that change nothing: each is worth a word, for whoever gives one expects an effect."""

from __future__ import annotations

from springpot.oscillator import Oscillator
from springpot.simulation.settings import SINGLE_PRECISION, Options

__all__ = ["without_effect"]


def without_effect(oscillator: Oscillator, given: Options) -> list[str]:
    """One sentence for each argument that was given and changes nothing.

    Parameters
    ----------
    oscillator : Oscillator
    given : dict
        What the caller gave, and nothing else.

    Returns
    -------
    list of str

    Examples
    --------
    >>> without_effect(Oscillator(), {"contact_tolerance": 1e-4})
    ["contact_tolerance has no effect without scheme='grunwald'."]
    """
    order = oscillator.springpot.order
    found = []
    if "contact_tolerance" in given:
        if given.get("scheme", "default") != "grunwald":
            found.append("contact_tolerance has no effect without scheme='grunwald'.")
        elif oscillator.barrier is None:
            found.append("contact_tolerance has no effect without a wall.")
    if "derivative" in given:
        if order == 0.0:
            found.append("derivative has no effect at order 0: both derivatives are x itself.")
        elif given["derivative"] == "riemann-liouville" and _starts_at_zero(oscillator, given):
            found.append("derivative='riemann-liouville' has no effect with x(0) = 0: both derivatives are the same.")
    no_memory = order in (0.0, 1.0) or oscillator.springpot.coefficient == 0.0
    # a smaller one asks for double precision of the whole step
    if no_memory and given.get("memory_tolerance", 0.0) >= SINGLE_PRECISION:
        what = "a coefficient of 0" if oscillator.springpot.coefficient == 0.0 else f"order {order:g}"
        found.append(f"memory_tolerance has no effect at {what}: there is no memory.")
    return found


def _starts_at_zero(oscillator: Oscillator, given: Options) -> bool:
    position = given.get("initial_position")
    if position is not None or oscillator.barrier is None:
        return not position
    return oscillator.direction * oscillator.barrier.position <= 0.0  # at the equilibrium, otherwise on the wall
