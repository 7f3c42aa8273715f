"""The settings of a run, declared once: Python, the command and studies take names, types and words from here."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, Literal, get_args, get_type_hints

if TYPE_CHECKING:
    from annotated_types import Ge, Gt

Observable = Callable[..., float]
Progress = Callable[[float], None]
Scheme = Literal["default", "grunwald"]
SchemeOfRun = Literal["default", "grunwald", "straight"]
"""That of several masses is straight."""
StartKind = Literal["rest", "stationary"]
Derivative = Literal["caputo", "riemann-liouville"]


@dataclass(frozen=True, kw_only=True)
class Options:
    """What a caller may give to a run, with its words in the help of the command, and what is taken otherwise.

    Where that depends on the rest it is None.  `springpot.simulation.simulate` says more of each one;
    `springpot.simulation.plan.plan.plan_of` checks them.
    """

    paths: Annotated[int | None, Ge(1), "Number of independent paths; 5000 if not given."] = None
    duration: Annotated[float | None, Gt(0.0), "End of the run, in s."] = None
    step: Annotated[float | None, Gt(0.0), "Time step, in s."] = None
    window: Annotated[tuple[float, float] | None, "Times between which averages are taken, in s."] = None
    seed: Annotated[int, "Seed: the same seed gives the same paths, and other systems with it deviate alike"] = 1
    threads: Annotated[int | None, "Number of threads; as many as this process may use if not given."] = None
    scheme: Annotated[Scheme, "Integration scheme: default, or grunwald, the scheme of the paper"] = "default"
    start: Annotated[
        StartKind | None,
        "stationary: from the stationary means, which pilot runs find; rest: from rest.  If not given: "
        "stationary, but rest if an initial state or the Riemann-Liouville derivative is given, or if there is no "
        "stationary state.",
    ] = None
    initial_position: Annotated[
        float | dict[str, float] | None,
        "x(0), in m; the run then starts from there.  Of several masses by their names, 0 where none is given.",
    ] = None
    initial_velocity: Annotated[
        float | dict[str, float] | None,
        "x'(0), in m/s; the run then starts from there.  Of several masses by their names, 0 where none is given.",
    ] = None
    derivative: Annotated[Derivative, "Definition of the derivative; the two differ if x(0) is not 0"] = "caputo"
    memory_tolerance: Annotated[float, "Relative error allowed in the memory kernel"] = 1e-6
    contact_tolerance: Annotated[
        float, "Scheme grunwald only: distance from the wall that counts as an impact, in m"
    ] = 1e-5
    record: Annotated[int, "Number of paths whose x and v are stored"] = 0
    record_every: Annotated[int | None, "Steps between two stored points of a path."] = None


def hints(*without: str) -> Mapping[str, Any]:
    """The type of each setting, None allowed, with its limits; but for those named.

    Examples
    --------
    >>> list(hints("paths"))[:2]
    ['duration', 'step']
    """
    from annotated_types import Ge, Gt  # only those who show the limits need them

    declared = get_type_hints(Options, localns={"Ge": Ge, "Gt": Gt}, include_extras=True)
    parts = {name: get_args(hint) for name, hint in declared.items() if name not in without}
    return {name: Annotated[(kind | None, *rest)] for name, (kind, *rest) in parts.items()}


def is_default(value: Any, default: Any) -> bool:
    """Whether it is as if an argument were left out; of whatever was given: what cannot be compared is not.

    Examples
    --------
    >>> is_default(1, 1), is_default(True, 1), is_default([1.0], None)
    (True, False, False)
    """
    return value is default or (type(value) is type(default) and bool(value == default))


def own_seed(seed: int, thing: Mapping[str, Any]) -> int:
    """The seed of one thing among many that are simulated with one seed: with the same for all they would be off alike.

    Parameters
    ----------
    seed : int
    thing : dict
        What it is, in plain values.

    Returns
    -------
    int
        From 0 to 2^63 - 1; for the same thing the same.

    Examples
    --------
    >>> own_seed(1, {"order": 0.5}) == own_seed(1, {"order": 0.5}) != own_seed(1, {"order": 0.6})
    True
    """
    # Python writes the shortest decimal that reads back as the same double: equal text, equal numbers
    content = json.dumps({**thing, "seed": seed}, sort_keys=True)
    return int.from_bytes(hashlib.sha256(content.encode()).digest()[16:24], "little") >> 1


def words(name: str) -> str:
    """What the help of the command says of a setting, its default included.

    Examples
    --------
    >>> words("paths")
    'Number of independent paths; 5000 if not given.'
    """
    text = next(word for word in get_args(hints()[name]) if isinstance(word, str))
    return text if text.endswith(".") else f"{text}; {getattr(Options, name)} if not given."
