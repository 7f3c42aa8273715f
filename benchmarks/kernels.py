"""One core: its limit of multiply-adds, where a path-step of ours goes, and the plain kernel it is set beside."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numba import njit

from benchmarks.measure import LIMIT, Row, best_cpu, cpu_by_turns
from benchmarks.plain import COMPILED, MODES, STEP, plain_of
from springpot import Oscillator, System
from springpot.simulation.kernel import tables
from springpot.simulation.kernel.lanes import GROUP, LANES, WIDTH, f32, stack_array, u32
from springpot.simulation.kernel.motion import NUMBERS_OF_MODE, remember
from springpot.simulation.kernel.native import key_words
from springpot.simulation.kernel.numba_passes import OptimizedOnce
from springpot.simulation.kernel.random import draw, lane_numbers, number_lanes
from springpot.simulation.kernel.reading import fixed
from springpot.simulation.kernel.tables import Tables
from springpot.simulation.kernel.vectors import pointer_like
from springpot.simulation.lowering import compose
from springpot.simulation.paths.simulation import addresses_of, simulation_of
from springpot.simulation.plan.plan import plan_of
from springpot.simulation.plan.settings import Settings

__all__ = ["MODES", "block_cpu", "one_core", "padded", "parts_of", "shares_of_limit"]

# one mode of one path in a group of four steps: 4 multiply-adds to take the increments in, and 4 to exert the force on
# the next four steps.  The one addition beside them is not counted: some processors have units of its own for it.
FLOPS_PER_MODE_STEP = 2 * (4 + 4) / GROUP

_CHAINS = 12  # independent, to hide the latency of a multiply-add; they and the constants fit into 16 registers
_ROUNDS = 8
FLOPS_OF_CHAINS = 2 * LANES * _CHAINS * _ROUNDS
_chains = stack_array(_CHAINS * LANES)
_four = stack_array(GROUP * LANES)
_six = stack_array((GROUP + 2) * LANES)  # as in the kernel: two increments before the group, then the group's four
_modes = stack_array(MODES * LANES)


class Parts(NamedTuple):
    """What a block consists of, and how it is run."""

    kernel: compose.Parts
    settings: Settings


# --- the limit ----------------------------------------------------------------------------------------------------


@njit(fastmath={"contract"}, error_model="numpy", pipeline_class=OptimizedOnce)
def _multiply_add(a, b, repeats):
    """``repeats`` * LANES * _CHAINS * _ROUNDS multiply-adds."""
    z = _chains(a)
    for i in range(_CHAINS * LANES):
        z[i] = b
    for _ in range(repeats):
        for i in range(LANES):
            y0, y1, y2, y3 = z[i], z[LANES + i], z[2 * LANES + i], z[3 * LANES + i]
            y4, y5, y6, y7 = z[4 * LANES + i], z[5 * LANES + i], z[6 * LANES + i], z[7 * LANES + i]
            y8, y9, y10, y11 = z[8 * LANES + i], z[9 * LANES + i], z[10 * LANES + i], z[11 * LANES + i]
            for _ in range(_ROUNDS):
                y0, y1, y2, y3 = y0 * a + b, y1 * a + b, y2 * a + b, y3 * a + b
                y4, y5, y6, y7 = y4 * a + b, y5 * a + b, y6 * a + b, y7 * a + b
                y8, y9, y10, y11 = y8 * a + b, y9 * a + b, y10 * a + b, y11 * a + b
            z[i], z[LANES + i], z[2 * LANES + i], z[3 * LANES + i] = y0, y1, y2, y3
            z[4 * LANES + i], z[5 * LANES + i], z[6 * LANES + i], z[7 * LANES + i] = y4, y5, y6, y7
            z[8 * LANES + i], z[9 * LANES + i], z[10 * LANES + i], z[11 * LANES + i] = y8, y9, y10, y11
    total = z[0]
    for i in range(1, _CHAINS * LANES):
        total += z[i]
    return total


def _chains_of(precision: str, repeats: int) -> Callable[[], Any]:
    """Independent chains of multiply-adds, compiled: ``repeats`` * FLOPS_OF_CHAINS flops."""
    kind = np.dtype(precision).type
    _multiply_add(kind(0.5), kind(1.0), 1)
    return partial(_multiply_add, kind(0.5), kind(1.0), repeats)


# --- a path-step of ours, and its parts ---------------------------------------------------------------------------


@njit(**COMPILED)
def _normals_only(groups, k0, k1):
    g, who = _four(f32(0)), lane_numbers(u32(0))
    number_lanes(0, who)
    kept = _four(f32(0))
    for i in range(GROUP * LANES):
        kept[i] = f32(0)
    for group in range(groups):
        draw(group, who, 0, 0, k0, k1, g)
        for i in range(GROUP * LANES):
            kept[i] += g[i]
    total = 0.0
    for i in range(GROUP * LANES):
        total += kept[i]
    return total


class _Kept(NamedTuple):
    """What the memory is kept in, as in `springpot.simulation.kernel.motion.Lanes`."""

    z: Any
    h: Any
    d: Any


@njit(**COMPILED)
def _memory_only(integers, numbers, groups):
    zero = numbers[0] * f32(0)
    kept = _Kept(_modes(zero), _four(zero), _six(zero))
    table = fixed(pointer_like(numbers.ctypes.data, kept.z))
    for i in range(MODES * LANES):
        kept.z[i] = zero
    for i in range((GROUP + 2) * LANES):
        kept.d[i] = zero + f32(0.001)
    for _ in range(groups):
        for o in range(0, LANES, WIDTH):
            remember(integers, table, kept, o)
        # the next increments depend on the force, as they do in a run: else the compiler sums them once for all lanes
        for i in range(GROUP * LANES):
            kept.d[2 * LANES + i] -= f32(1e-6) * kept.h[i]
    total = zero
    for i in range(GROUP * LANES):
        total += kept.h[i]
    return total


def padded(own: Tables, modes: int = MODES) -> Tables:
    """The tables of one mass with modes that weigh nothing, up to a given number of them."""
    if (lacking := modes - own.count("modes")) < 0:
        raise ValueError(f"modes must be at least {own.count('modes')}, not {modes}.")
    integers, end = own.integers.copy(), own.integers[tables.MODE] + NUMBERS_OF_MODE * own.count("modes")
    more = NUMBERS_OF_MODE * lacking
    integers[tables.MODES] = integers[integers[tables.MODE_COUNT]] = modes
    for behind in (tables.TURN_OF_MODES, integers[tables.TURNED_TABLE]):
        integers[behind] += more
    return Tables(integers, *(np.insert(each, end, np.zeros(more)) for each in (own.numbers, own.sweep)))


def parts_of(
    oscillator: System, steps: int, *, step: float = STEP, modes: int | None = None, precision: str = "float32"
) -> Parts:
    """What a block needs for ``steps`` steps, with averages over the second half."""
    whole = step * steps
    plan = plan_of(oscillator, duration=whole, window=(0.5 * whole, whole), step=step, start="rest")
    if precision == "float64":
        plan = plan.but(memory_tolerance=9e-8)
    kernel = simulation_of(plan).parts
    if modes is not None:
        kernel = replace(kernel, tables=padded(kernel.tables, modes))
    return Parts(kernel, plan.settings)


def block_cpu(parts: Parts, times: int = 5) -> float:
    """Processor time in s of one block of LANES paths."""
    return best_cpu(_block(parts), times)


def _block(parts: Parts) -> Callable[[], None]:
    """One block of LANES paths as a run advances it, compiled."""
    kernel, settings, advance = parts.kernel, parts.settings, parts.kernel.kernel()
    k0, k1 = key_words(1)
    rows, record, stop = np.empty((LANES, len(kernel.columns))), np.empty((0, 1, 2)), np.zeros(1, np.uint8)

    def run(own: Settings = settings) -> None:
        advance(kernel.start, 0, 1, own, k0, k1, 0, False, addresses_of((), (), kernel), record, stop, rows)

    few = GROUP * settings.step
    run(replace(settings, duration=few, window=(0.0, few)))
    return run


def _division(parts: Parts, without_wall: Parts) -> dict[str, Callable[[], Any]]:
    """Parts of a block, each alone, and a block without a wall, compiled."""
    (integers, _, numbers), groups = parts.kernel.tables, parts.settings.steps // GROUP
    k0, k1 = key_words(1)
    drivers: dict[str, Callable[[int], Any]] = {
        "normals": lambda count: _normals_only(count, k0, k1),
        "memory": lambda count: _memory_only(integers, numbers, count),
    }
    for driver in drivers.values():
        driver(1)
    alone = {name: partial(driver, groups) for name, driver in drivers.items()}
    return {**alone, "without a wall": _block(without_wall)}


# --- the plain kernel ---------------------------------------------------------------------------------------------


def _plain(oscillator: System, steps: int, precision: str) -> Callable[[], None]:
    """One block of LANES paths of the plain kernel with MODES modes, compiled."""
    plain, key = plain_of(oscillator, steps, modes=MODES, precision=precision), key_words(1)
    plain.run(GROUP, GROUP // 2, key)

    def run() -> None:
        if not np.isfinite(plain.run(steps, steps // 2, key)).all():
            raise ArithmeticError("the plain kernel blew up, so its time means nothing.")

    return run


# --- the rows -----------------------------------------------------------------------------------------------------


def one_core(quick: bool) -> list[Row]:
    """Rows of sections 1 and 2."""
    steps = 4_000 if quick else 100_000
    oscillator, free = Oscillator(), Oscillator(barrier=None)
    first: list[Row] = []
    second: list[Row] = []
    for precision, word in (("float32", "single"), ("float64", "double")):
        repeats = 2_000 if quick else 20_000
        parts = parts_of(oscillator, steps, modes=MODES, precision=precision)
        per_step = 1e9 / (LANES * steps)
        needed = parts_of(oscillator, steps, precision=precision)
        alone = _division(parts, parts_of(free, steps, modes=MODES, precision=precision))
        modes, tolerance = needed.kernel.tables.count("modes"), 1e-6 if precision == "float32" else 9e-8
        kernels = {"whole": _block(parts), "plain": _plain(oscillator, steps, precision), "needed": _block(needed)}
        turns = 1 if quick else 9
        seconds = cpu_by_turns({"chains": _chains_of(precision, repeats), **kernels, **alone}, turns)
        taken = {name: per_step * seconds[name] for name in (*kernels, *alone)}
        whole, plain, as_run = (taken[name] for name in kernels)
        of_two = taken["normals"] + taken["memory"]
        division = {
            "normals": (taken["normals"], "alone"), "memory": (taken["memory"], "alone"),
            "kicks, drifts and sums": (taken["without a wall"] - of_two, "a block without a wall, less these two"),
            "the wall": (whole - taken["without a wall"], "the whole less a block without it"),
        }  # fmt: skip
        first += shares_of_limit(f"one core, {word} memory", repeats * FLOPS_OF_CHAINS / seconds["chains"] / 1e9, taken)
        first += [
            Row(
                f"one core, {word} memory", f"of it {name}", value, "ns per path-step", value / whole, "the whole", note
            )
            for name, (value, note) in division.items()
        ]
        second += [
            Row(
                f"plain kernel, {word} memory", "springpot", whole, "ns per path-step", 1.0, "springpot",
                f"{MODES} modes, exact impacts, all sums over the second half of the run",
            ),
            Row(
                f"plain kernel, {word} memory", f"springpot with the {modes} modes it needs", as_run,
                "ns per path-step", as_run / whole, "springpot", f"memory error below {tolerance:g}",
            ),
            Row(
                f"plain kernel, {word} memory", "plain kernel", plain, "ns per path-step", plain / whole, "springpot",
                f"{MODES} modes, the same normals; one step at a time, mirrored at its end, Euler step",
            ),
        ]  # fmt: skip
    return first + second


def shares_of_limit(section: str, chains: float, taken: Mapping[str, float]) -> list[Row]:
    """Multiply-adds of chains (in Gflop/s), of the memory modes alone and within the whole, whose ns are ``taken``.

    The most that any kernel does is the limit: what a processor has done, it can do.
    """
    flops = MODES * FLOPS_PER_MODE_STEP
    alone, within = flops / taken["memory"], flops / taken["whole"]
    most = max(chains, alone)
    note = f"{_CHAINS} independent chains, by turns with the kernels below"
    return [
        Row(section, "multiply-adds, chains", chains, "Gflop/s", chains / most, LIMIT, note),
        Row(section, "multiply-adds, memory modes alone", alone, "Gflop/s", alone / most, LIMIT,
            f"{flops:g} flops per path-step with {MODES} modes"),
        Row(section, "multiply-adds, memory modes in the whole kernel", within, "Gflop/s", within / most, LIMIT,
            "the same flops over all of the time"),
    ]  # fmt: skip
