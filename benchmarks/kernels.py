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
from springpot.simulation.kernel.block import Memory, _remember
from springpot.simulation.kernel.lanes import GROUP, LANES, f32, stack_array, u32
from springpot.simulation.kernel.normals import key_words
from springpot.simulation.kernel.numba_passes import OptimizedOnce
from springpot.simulation.kernel.questions import Forcing
from springpot.simulation.kernel.random import draw, lane_numbers, number_lanes
from springpot.simulation.kernel.steps import Glimpse, State, Struck, Sums, sweep_lanes
from springpot.simulation.kernel.watching import NO_OBSERVERS
from springpot.simulation.lowering import compose
from springpot.simulation.paths.simulation import simulation_of
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
_state = stack_array(LANES)
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


@njit(**COMPILED)
def _sweep_only(sweep, memory, x, v, groups):
    zero, quick = memory.newest * f32(0), sweep.zero
    p = (zero, zero, zero, zero)
    h, d, g, clear = _four(zero), _six(zero), _four(f32(0)), _state(quick)
    begun, change = State(_state(quick), _state(quick)), State(_state(quick), _state(quick))
    seen = Glimpse(_four(quick), _four(quick), _four(quick), _four(quick), _four(quick))
    terms = Sums(_state(quick), _state(quick), _state(quick), _state(quick), _state(quick), _state(quick))
    none = _state(quick)  # white noise and a rigid wall keep nothing beside the sums
    struck = Struck(none, none, none, none, none, none, none, none)  # for a sweep with impacts
    forcing = Forcing(none, none, none, none, g, g)
    for i in range((GROUP + 2) * LANES):
        d[i] = zero
    for i in range(GROUP * LANES):
        h[i] = zero
        g[i] = f32(i % 7) - f32(3)
    for lane in range(LANES):
        begun.x[lane], begun.v[lane] = x, v
    least = quick
    for n in range(groups):
        sweep_lanes(sweep, memory, p, n, begun, change, clear, g, forcing, h, d, seen, struck, terms, True, False)
        for lane in range(LANES):
            begun.x[lane] += change.x[lane]
            begun.v[lane] += change.v[lane]
            least = min(least, clear[lane] + terms.x[lane] + terms.power[lane] + terms.virial[lane])
        for i in range(2 * LANES):
            d[i] = d[GROUP * LANES + i]
    return least


@njit(**COMPILED)
def _memory_only(memory, groups):
    zero = memory.newest * f32(0)
    modes = memory.powers.size // 4
    z, h, d = _modes(zero), _four(zero), _six(zero)
    for i in range(modes * LANES):
        z[i] = zero
    for i in range((GROUP + 2) * LANES):
        d[i] = zero + f32(0.001)
    for _ in range(groups):
        _remember(z, d, h, modes, memory.powers, memory.weights)
        # the next increments depend on the force, as they do in a run: else the compiler sums them once for all lanes
        for i in range(2 * LANES):
            d[i] = d[GROUP * LANES + i]
        for i in range(GROUP * LANES):
            d[2 * LANES + i] -= f32(1e-6) * h[i]
    total = zero
    for i in range(GROUP * LANES):
        total += h[i]
    return total


def padded(memory: Memory, modes: int = MODES) -> Memory:
    """The same memory with modes that weigh nothing, up to a given number of them."""
    if (lacking := 4 * modes - memory.powers.size) < 0:
        raise ValueError(f"modes must be at least {memory.powers.size // 4}, not {modes}.")
    return memory._replace(powers=np.pad(memory.powers, (0, lacking)), weights=np.pad(memory.weights, (0, lacking)))


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
        kernel = replace(kernel, memory=padded(kernel.memory, modes))
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
        advance(kernel.start.states, 0, 1, own, k0, k1, 0, False, NO_OBSERVERS, record, stop, rows)

    few = GROUP * settings.step
    run(replace(settings, duration=few, window=(0.0, few)))
    return run


def _division(parts: Parts) -> dict[str, Callable[[], Any]]:
    """The parts of a block, each alone, compiled."""
    kernel, groups = parts.kernel, parts.settings.steps // GROUP
    (_, sweep), (x, v) = kernel.of_kernel(), kernel.start.states[0, :2]
    k0, k1 = key_words(1)
    drivers: dict[str, Callable[[int], Any]] = {
        "normals": lambda count: _normals_only(count, k0, k1),
        "sweep": lambda count: _sweep_only(sweep, kernel.memory, x, v, count),
        "memory": lambda count: _memory_only(kernel.memory, count),
    }
    for driver in drivers.values():
        driver(1)
    return {name: partial(driver, groups) for name, driver in drivers.items()}


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
    oscillator = Oscillator()
    first: list[Row] = []
    second: list[Row] = []
    for precision, word in (("float32", "single"), ("float64", "double")):
        repeats = 2_000 if quick else 20_000
        parts = parts_of(oscillator, steps, modes=MODES, precision=precision)
        per_step = 1e9 / (LANES * steps)
        needed, alone = parts_of(oscillator, steps, precision=precision), _division(parts)
        modes, tolerance = needed.kernel.memory.powers.size // 4, 1e-6 if precision == "float32" else 9e-8
        kernels = {"whole": _block(parts), "plain": _plain(oscillator, steps, precision), "needed": _block(needed)}
        turns = 1 if quick else 9
        seconds = cpu_by_turns({"chains": _chains_of(precision, repeats), **kernels, **alone}, turns)
        taken = {name: per_step * seconds[name] for name in (*kernels, *alone)}
        whole, plain, as_run = (taken[name] for name in kernels)
        division = {name: taken[name] for name in alone}
        division["walls, sums and the rest"] = whole - sum(division.values())
        first += shares_of_limit(f"one core, {word} memory", repeats * FLOPS_OF_CHAINS / seconds["chains"] / 1e9, taken)
        first += [
            Row(
                f"one core, {word} memory", f"of it {name}", value, "ns per path-step", value / whole, "the whole", note
            )
            for (name, value), note in zip(
                division.items(), ("alone", "alone", "alone", "what the three leave of the whole"), strict=True
            )
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
