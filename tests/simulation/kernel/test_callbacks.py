"""What the kernel calls by its address is compiled once for all processes, a user's own functions too."""

from __future__ import annotations

import ctypes
import math
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numba import njit, types
from scipy import special

import springpot as sp
from springpot.simulation.kernel import callbacks
from springpot.simulation.kernel.callbacks import callback, inlined
from springpot.simulation.kernel.fingerprint import fingerprint
from springpot.simulation.kernel.lanes import INLINE, LANES, lesser, stack_array
from springpot.simulation.monte_carlo import simulated
from tests.sizes import validation

NOW, KEPT = "compiled now, and kept", "kept on disk"
STIFFNESS = 2.0
TABLE = np.array([1.0, 2.0])


@pytest.fixture(autouse=True, scope="module")
def _kernel() -> None:
    """From the folder of all tests."""
    simulated(DEVICE, paths=1, duration=1.0, step=0.1, start="rest")


@pytest.fixture(autouse=True)
def _as_in_a_new_process(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "cache"))
    monkeypatch.setattr(callbacks, "_recent", callbacks._Recent())


def again(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(callbacks, "_recent", callbacks._Recent())


_numbers = types.CPointer(types.float64)
OF_LANES = types.void(types.int64, _numbers, _numbers)
"""(lanes, arguments, results): argument k of a lane is at ``k * lanes + lane``."""


def in_lanes(function: Callable[..., float], arguments: int, what: str) -> Any:
    """A function of the user as the kernel has those of restitution and of forces."""
    inner = inlined(function, arguments, what)

    def of_one(lanes, given, found):  # type: ignore[no-untyped-def]
        for lane in range(lanes):
            found[lane] = np.nan
            found[lane] = inner(given[lane])

    def of_three(lanes, given, found):  # type: ignore[no-untyped-def]
        for lane in range(lanes):
            found[lane] = inner(given[lane], given[lanes + lane], given[2 * lanes + lane])

    return callback(OF_LANES)(of_one if arguments == 1 else of_three)


def at(law: Any, *values: float) -> float:
    """The value of a function of the user, by its address."""
    given, found = np.array(values), np.full(1, 7.0)
    call = ctypes.CFUNCTYPE(None, ctypes.c_int64, ctypes.c_void_p, ctypes.c_void_p)(law.address)
    call(1, given.ctypes.data, found.ctypes.data)
    return float(found[0])


def spring(stiffness: float) -> Callable[[float], float]:
    return lambda x: -stiffness * x**3


def test_it_is_compiled_once_for_all_processes_and_for_each_captured_number(monkeypatch: pytest.MonkeyPatch) -> None:
    first = in_lanes(spring(2.0), 1, "it")
    assert (first.how, at(first, 3.0)) == (NOW, -54.0)
    assert in_lanes(spring(2.0), 1, "it") is first  # in this process it is not even loaded again
    again(monkeypatch)
    kept = in_lanes(spring(2.0), 1, "it")
    assert (kept.how, at(kept, 3.0)) == (KEPT, -54.0)
    other = in_lanes(spring(3.0), 1, "it")
    assert (other.how, at(other, 3.0)) == (NOW, -81.0)


def test_arguments_have_their_places() -> None:
    law = in_lanes(lambda t, x, v: t + 10.0 * x + 100.0 * v, 3, "it")
    given, found = np.arange(12.0), np.empty(4)
    call = ctypes.CFUNCTYPE(None, ctypes.c_int64, ctypes.c_void_p, ctypes.c_void_p)(law.address)
    call(4, given.ctypes.data, found.ctypes.data)
    t, x, v = given.reshape(3, 4)
    assert found.tolist() == (t + 10.0 * x + 100.0 * v).tolist()


@njit
def shared_law(x: float) -> float:
    return math.tanh(x) * STIFFNESS


def test_a_function_that_it_calls_belongs_to_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """And so do the numbers of that one, wherever they stand."""

    def outer(x: float) -> float:
        return shared_law(x) + np.exp(-x)

    law = in_lanes(outer, 1, "it")
    assert at(law, 0.5) == pytest.approx(2.0 * math.tanh(0.5) + math.exp(-0.5), rel=1e-14)
    again(monkeypatch)
    assert in_lanes(outer, 1, "it").how == KEPT
    again(monkeypatch)
    monkeypatch.setitem(globals(), "STIFFNESS", 3.0)
    monkeypatch.setitem(globals(), "shared_law", njit(shared_law.py_func))
    law = in_lanes(outer, 1, "it")
    assert law.how == NOW
    assert at(law, 0.5) == pytest.approx(3.0 * math.tanh(0.5) + math.exp(-0.5), rel=1e-14)


def picky(x: float) -> float:
    if x > 1.0:
        raise ValueError("too far")
    return x


def of_a_list(x: float) -> float:
    return sum([x, 2.0 * x])


def in_an_array(x: float) -> float:
    return float(np.array([x, 2.0 * x]).sum())


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
@pytest.mark.parametrize(
    ("function", "value"),
    [(lambda x: TABLE[1] * x, 1.0), (picky, 0.5), (of_a_list, 1.5), validation(in_an_array, 1.5)],
)
def test_what_needs_more_than_numbers_is_compiled_for_each_process(
    function: Callable[[float], float], value: float, tmp_path: Path
) -> None:
    """Nobody could tell when it has changed, or its code calls Python."""
    law = in_lanes(function, 1, "it")
    assert (law.how.endswith("for this process alone"), at(law, 0.5)) == (True, value)
    assert list(tmp_path.rglob("*.o")) == []


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_where_it_raises_there_is_no_number() -> None:
    assert math.isnan(at(in_lanes(picky, 1, "it"), 2.0))


@pytest.mark.parametrize(
    ("function", "sentence"),
    [
        (lambda x: "a word", "the wall has a restitution that Numba cannot compile: "),
        (lambda x: print, "the wall has a restitution that Numba cannot compile: "),
        (lambda x, y: x, "the wall has a restitution that Numba cannot compile: "),
    ],
)
def test_what_is_no_function_of_numbers_is_refused(function: Callable[..., float], sentence: str) -> None:
    with pytest.raises(ValueError, match=sentence):
        in_lanes(function, 1, "the wall has a restitution")


# --- the key ---------------------------------------------------------------------------------------------------------


def of(*captured: Any) -> str | None:
    (value,) = captured
    return fingerprint(lambda x: x * value)


def test_the_key_tells_numbers_apart_by_type_and_bits() -> None:
    values = [2, 2.0, np.float64(2.0), np.float32(2.0), True, 1, 0.0, -0.0, (2.0,), (2.0, 2.0), None, "2.0"]
    words = [of(value) for value in values]
    assert None not in words
    assert len(set(words)) == len(values)
    assert of(2.0) == of(2.0)


@pytest.mark.parametrize(
    "value",
    [
        np.ones(2), [1.0], {"a": 1.0}, {1.0}, object(), Path(), of, os, lambda x: x, special.erf, special,
        np.frompyfunc(abs, 1, 1), np.vectorize(abs),
    ],
)  # fmt: skip
def test_what_is_no_number_has_no_key(value: Any) -> None:
    assert of(value) is None


def test_the_key_of_a_compiled_function_has_its_types_and_options() -> None:
    """A function for integers only cuts off what another one keeps."""

    def half(x: float) -> float:
        return 0.5 * x

    made = njit(half), njit("float64(int64)")(half), njit("float64(float64)")(half), njit(fastmath=True)(half)
    made = (*made, njit(locals={"x": types.float32})(half))
    words = [of(each) for each in made]
    assert None not in words
    assert len(set(words)) == len(made)
    assert of(njit(half)) == words[0]


@pytest.mark.parametrize("known", [np.tanh, np.clip, np.float32, math.sin, abs, int, types.float32, math])
def test_functions_of_known_libraries_have_a_key(known: Any) -> None:
    assert of(known) is not None
    assert of(known) != of(np.sinh)


def test_the_key_of_code_is_its_bytecode() -> None:
    def one(x: float) -> float:
        return x if x > 0.0 else 2.0 * x

    def same(x: float) -> float:
        return x if x > 0.0 else 2.0 * x

    def other(x: float) -> float:
        return x if x > 0.0 else 3.0 * x

    def defaults(x: float, y: float = 2.0) -> float:
        return x * y

    words = [fingerprint(each) for each in (one, other, defaults)]
    assert None not in words
    assert len(set(words)) == 3
    assert fingerprint(same) == words[0]
    changed = defaults.__defaults__
    defaults.__defaults__ = (3.0,)
    assert fingerprint(defaults) != words[2]
    defaults.__defaults__ = changed
    assert fingerprint(defaults) == words[2]


def recursive(x: float) -> float:
    return x if x < 1.0 else compiled_again(0.5 * x)


compiled_again = njit(recursive)


def test_parts_of_the_house_and_functions_that_call_themselves_have_a_key() -> None:
    def made(count: int, flags: dict[str, Any]) -> str | None:
        room = stack_array(count)
        inner = njit(**flags)(lambda x: lesser(x, 1.0) + LANES)
        return fingerprint(lambda x: inner(x) + room(x)[0])

    words = made(4, INLINE), made(5, INLINE), made(4, {"fastmath": True})
    assert None not in words
    assert len(set(words)) == 3
    assert made(4, INLINE) == words[0]
    assert fingerprint(compiled_again.py_func) is not None


def run_with_functions_of_the_user(power: float) -> tuple[str, str]:
    level = 0.5
    run = sp.simulate(
        DEVICE, paths=64, duration=20.0, step=0.05, start="rest", distributions=True,
        observables={"own": lambda t, x, v: abs(x) ** power},
        impact_observables={"loss": lambda speed: 0.255 * speed**2},
        first_passage={"mixed": (lambda t, x, v: x + v, level)},
    )  # fmt: skip
    return repr(run["own"].value), repr(run["loss"].value)


DEVICE = sp.System(sp.Mass(1.0), sp.Spring(1.0), sp.Dashpot(0.2), sp.WhiteNoise(1.0), sp.Barrier(-0.5, 0.7))


@pytest.mark.filterwarnings("ignore::springpot.AccuracyWarning", "ignore::springpot.StationarityWarning")
def test_a_run_with_functions_of_the_user_compiles_nothing_the_second_time(monkeypatch: pytest.MonkeyPatch) -> None:
    """Before, each process compiled them anew, and each run of a process too."""
    asked: list[str] = []
    made = callbacks.loaded
    monkeypatch.setattr(callbacks, "loaded", lambda content, how: asked.append(how) or made(content, how))

    def said(power: float) -> tuple[set[str], tuple[str, str]]:
        asked.clear()
        values = run_with_functions_of_the_user(power)
        return set(asked), values

    how, values = said(2.0)
    assert how == {NOW}
    assert said(2.0) == (set(), values)
    again(monkeypatch)
    assert said(2.0) == ({KEPT}, values)
    how, others = said(3.0)
    assert how == {NOW}
    assert (others[0] != values[0], others[1]) == (True, values[1])


@pytest.mark.validation  # every day: what needs more than numbers, in this file
@pytest.mark.filterwarnings("ignore::springpot.AccuracyWarning", "ignore::springpot.StationarityWarning")
def test_an_observable_may_make_an_array() -> None:
    """As a law of restitution could before; it costs a compilation in each process."""
    run = sp.simulate(
        DEVICE, paths=64, duration=20.0, step=0.05, start="rest",
        observables={"largest": lambda t, x, v: np.array([x, v]).max(), "plain": lambda t, x, v: max(x, v)},
    )  # fmt: skip
    assert run["largest"].value == run["plain"].value


CALLBACKS = """
from springpot.explorer.gathering import _growth_part
from springpot.simulation.watch.spectrum import _compiled

print([part.how for part in (_compiled(2), _compiled(3), _growth_part())])
"""


@pytest.mark.validation  # every day: any callback is, in this file
def test_what_counts_and_observes_is_compiled_once_for_all_processes(tmp_path: Path) -> None:
    """A function that holds another number is another function."""
    script = tmp_path / "callbacks.py"
    script.write_text(CALLBACKS, encoding="utf-8")
    for how in (NOW, KEPT):
        done = subprocess.run([sys.executable, str(script)], capture_output=True, text=True, timeout=300)
        assert done.stdout == f"{[how] * 3}\n", done.stderr
    assert len([*(tmp_path / "cache").rglob("*.o")]) == 3


def test_another_signature_is_another_function() -> None:
    def body(numbers: Any) -> None:
        numbers[0] = numbers[0] * 2

    of_floats = callback(types.void(types.CPointer(types.float64)))(body)
    of_integers = callback(types.void(types.CPointer(types.int64)))(body)
    numbers = np.array([3])
    ctypes.CFUNCTYPE(None, ctypes.c_void_p)(of_integers.address)(numbers.ctypes.data)
    assert numbers[0] == 6
    assert of_floats.address != of_integers.address
