"""A user's own functions: the mean of one of the state over the window, the sum of one of the speed over its impacts.

Each observer is compiled separately, and the kernel calls it through its address (see
:mod:`springpot.simulation.kernel.watching`).  So it needs no new kernel, and runs without it are not slower.
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numba import njit
from numba.core.errors import NumbaError

from springpot.machine.arguments import checked_name, named_arguments
from springpot.machine.faults import cause_of, shown
from springpot.problem.catalogue import OF_A_POINT, OF_A_WALL, PARTS_OF_ERROR, possible_results, results_on_request
from springpot.problem.system import System
from springpot.simulation.kernel.callbacks import callback
from springpot.simulation.kernel.lanes import GROUP, INLINE, LANES, OF_USER
from springpot.simulation.kernel.watching import ON_IMPACTS, ON_STEPS
from springpot.simulation.lowering.observers import Observer, begins, layout
from springpot.simulation.paths.simulation import Ensemble, Simulation
from springpot.simulation.plan.motion import Motion
from springpot.simulation.plan.plan import Plan
from springpot.simulation.plan.signals import Signal
from springpot.simulation.watch.requested import Observed, Request

_LAYOUT = layout(sum=LANES)
_LENGTH, _SPEED_UNIT, _TIME, _SUM = begins(_LAYOUT, "length", "speed", "time", "sum")


@dataclass(frozen=True, eq=False)
class MeanOfOwn(Request):
    """The mean of one function of the user.

    Attributes
    ----------
    name : str
    """

    name: str

    @classmethod
    def asked(cls, plan: Plan, wishes: Mapping[str, Any]) -> Iterator[MeanOfOwn]:
        kinds: tuple[tuple[str, Literal["state", "impact"]], ...]
        kinds = ("observables", "state"), ("impact_observables", "impact")
        given = {kind: wishes.get(argument, {}) for argument, kind in kinds}
        for argument, kind in kinds:
            if not isinstance(given[kind], Mapping):
                raise TypeError(f"{argument} must be a dict of names and functions, not {shown(given[kind])}.")
        for name in (*given["state"], *given["impact"]):
            if isinstance(name, str) and is_taken(plan.system, name):
                raise ValueError(f"an observable cannot be called {name!r}: the run already has a result of that name.")
        if both := [name for name in given["state"] if name in given["impact"]]:
            raise ValueError(f"{both[0]!r} cannot name an observable and an impact observable at once.")
        for _, kind in kinds:
            for name, function in given[kind].items():
                yield cls((mean_of(plan.motion, name, function, kind),), name)

    def read(self, simulation: Simulation, ensemble: Ensemble) -> Observed:
        (low, high), step = simulation.settings.window_steps, simulation.settings.step
        of_impacts = self.observer.on_steps is None
        samples = ensemble.observed[self.observer]["sum"] / ((high - low) * (step if of_impacts else 1))
        errors = {}
        if of_impacts and (walls := [stop] if (stop := self.observer.signal.stop) else [*simulation.parts.walls]):
            sums = simulation.parts.sums(ensemble.rows)
            if not any(sums["impacts", wall].any() for wall in walls):
                errors[self.name] = math.nan  # no path has struck them
        return {"means": {self.name: samples}, "errors": errors}


def mean_of(
    motion: Motion, name: str, function: Callable[..., float], kind: Literal["state", "impact"], *, most: int = 0
) -> Observer:
    """Sum of a user's function: of the state over the steps of the window, or of the speed over its impacts.

    With ``most`` it is the largest value of a function of the state instead, from this place of the array on.

    Of one mass the state is (t, x, v), and the speed one argument; of several, and with forces or accelerations among
    them, the names of the arguments say what they are.  Variables that the function captures have their values at the
    start of the run.

    Raises
    ------
    TypeError, ValueError
        If the name is not valid, an argument is unknown, or the function cannot be compiled.
    """
    wanted = ("(t, x, v)" if kind == "state" else "(speed)") if not motion.arguments else "what it observes"
    checked_name(name, "an observable's name")
    if (own := python_of(function)) is None:
        given = shown(function)
        raise TypeError(f"observable {name!r} must be a function of {wanted}, not {given}: wrap it in a lambda.")
    signal = Signal(stop="")
    takes: tuple[tuple[str, int], ...] = ("t", 0), ("x", 0), ("v", 0)
    if kind == "state" and (
        motion.arguments or not motion.outputs.keys().isdisjoint(inspect.signature(own).parameters)
    ):
        first = motion.displacements_shown
        outputs = {word: ("x", first + number) for number, word in enumerate(motion.outputs)}
        known = (motion.arguments or {word: (word, 0) for word in "txv"}) | outputs
        words = _arguments(name, own, known)
        takes = tuple(known[word] for word in words)
        signal = replace(signal, outputs=tuple(motion.output_number(word) for word in words if word in outputs))
    elif kind == "impact":
        stops = {"speed": "", **{f"{stop}_impact_speed": stop for stop in motion.touched}}
        words = [*inspect.signature(own).parameters]
        if motion.arguments or any(word.endswith("_impact_speed") for word in words):  # else of one mass any name
            signal = replace(signal, stop=stops[_arguments(name, own, stops, most=1)[0]])
    with compiled_of(f"observable {name!r} must be a function of {wanted}"):
        compiled = _on_steps_of(own, takes, most or _SUM, most > 0) if kind == "state" else _on_impacts_of(own)
    on_steps, on_impacts = (compiled, None) if kind == "state" else (None, compiled)
    return Observer(signal, on_steps, on_impacts, np.zeros((), _LAYOUT), of_paths=("sum",))


def python_of(function: object) -> Callable[..., float] | None:
    """The function in Python that a user gives, maybe compiled by Numba; None if it is none."""
    own = getattr(function, "py_func", function)
    return own if callable(function) and inspect.isfunction(own) else None


@contextmanager
def compiled_of(must: str) -> Iterator[None]:
    """Say what the function of a user must be, if Numba does not compile it."""
    try:
        yield
    except (NumbaError, TypeError) as reason:
        raise ValueError(f"{must} that Numba can compile to a real number: {cause_of(reason)}") from reason


def _arguments(name: str, function: Callable[..., float], known: Iterable[str], most: int = 0) -> list[str]:
    return named_arguments(f"observable {name!r}", function, known, "nothing that can be seen", most)


def is_taken(system: System, name: str) -> bool:
    """Whether a run of a system uses a name already, for a result or in the dataset of its results."""
    if name in possible_results(system) or name.endswith(PARTS_OF_ERROR):
        return True
    asked = results_on_request(system)
    bins = (asked_for.removesuffix("_density") + end for asked_for in asked for end in ("_bin", "_bin_width"))
    samples = (asked_for.removesuffix("_quantile") for asked_for in asked)
    walls = (f"barrier_{quantity}" for quantity in OF_A_WALL)
    others = (*OF_A_POINT, "path", "time", "frequency", "probability", "barrier", "point", "time_bin", "time_bin_width")
    attributes = ("system", "settings", "diagnostics", "warnings")
    return name in {*asked, *bins, *samples, *walls, *others, *attributes}


def _with(rest: Any, kind: str, begin: int) -> Any:
    """``rest``, which is given one argument more: the time, or the displacement or velocity that begins there."""

    @njit(**INLINE)
    def value(t, length, speed, x, v, at, given):
        own = t if kind == "t" else length * x[begin + at] if kind == "x" else speed * v[begin + at]
        return rest(t, length, speed, x, v, at, (*given, own))

    return value


def _on_steps_of(
    function: Callable[..., float], takes: Sequence[tuple[str, int]], place: int = _SUM, most: bool = False
) -> Any:
    """The sum, or the most, at this place; ``takes`` says of each argument if it is t, x or v, and the number of the
    displacement.
    """
    inner = njit(**OF_USER)(function)

    @njit(**INLINE)
    def value(t, length, speed, x, v, at, given):
        return inner(*given)

    for kind, number in reversed(takes):
        value = _with(value, kind, number * GROUP * LANES)

    @callback(ON_STEPS)
    def on_steps(x, v, step, n, low, high, array):
        length, speed, time = array[_LENGTH], array[_SPEED_UNIT], array[_TIME]
        for j in range(GROUP):
            if low <= n + j < high:
                t = time * step * (n + j + 1)
                for lane in range(LANES):
                    at = j * LANES + lane
                    so_far = array[place + lane]
                    array[place + lane] = np.nan  # stays if the function raises
                    found = value(t, length, speed, x, v, at, ())
                    array[place + lane] = (found if found > so_far else so_far) if most else so_far + found

    return on_steps


def _on_impacts_of(function: Callable[..., float]) -> Any:
    inner = njit(**OF_USER)(function)

    @callback(ON_IMPACTS)
    def on_impacts(count, speed, lane, array):
        so_far = array[_SUM + lane]
        array[_SUM + lane] = np.nan
        array[_SUM + lane] = so_far + count * inner(array[_SPEED_UNIT] * speed)

    return on_impacts
