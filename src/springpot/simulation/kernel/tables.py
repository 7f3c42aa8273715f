"""What a system is to the kernel: one table of integers and one of numbers, the latter in two precisions.

Nothing in the types of the kernel's arguments depends on the system, so one compilation serves all systems.  The table
of integers begins with a header: counts of things, then where each list begins, in the same table or in that of
numbers.  Lists are described where they are made (`springpot.simulation.lowering.compose`).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from springpot.machine.arrays import Floats
from springpot.simulation.kernel.sizes import LANES

COUNTS = (
    "points",  # coordinates
    "rows",  # elongations
    "gauged",  # the first of them, whose mean and mean square are summed
    "shown",  # the first of these, whose velocity's mean square is summed too: points that are no coordinates
    "forced",  # the first rows, of which the mean force of dampers and memory is summed, and its virial
    "walls",
    "noises",  # white
    "sources",  # other excitation
    "dampers",  # nonlinear ones, parts that yield, forces of the user
    "contacts",
    "shaken",  # elongations that a noise multiplies
    "taps",  # modes of memories whose mean square is kept
    "modes",  # numbers that all memories keep
    "resting",  # walls on which rows can rest
    "states",  # of sources and dampers; behind them is which rows rest
    "turns",  # 1: a lone coordinate turns on a circle between two kicks; 0: straight drift
    "paper",  # 1: the scheme as the paper prints it
    "parts",  # of a step: with 2 the impulses are sums of two of a run with half the step
    "substeps",  # of half a drift in which a contact is touched
    # of each of several systems in a call, which have the same path numbers; 0: all are of one system, or each block
    # has numbers of its own
    "blocks",
    # from the numbers of a system to those of the next, in the sweep's precision and in double
    "stride",
    "stride_in_double",
    "goes_on",  # 1: the path numbers go on from system to system
    "columns",  # numbers of a row of results
)
"""Of the header, in this order; the lists follow."""
LISTS = (
    # sparse rows: nonzeros from ``begin[i]`` to ``begin[i + 1]``, each with its coordinate ``at`` and its value
    "row_begin", "row_at", "noise_begin", "noise_at", "source_begin", "source_at",
    "source",  # eight integers of each, the seventh of a long list: see `springpot.simulation.kernel.excitations`
    "spring_kind",  # of each row; 0 is none
    "mode_count", "mode_begin", "mode_table",  # of each row; the last is where its numbers begin
    "turned", "turned_table",  # modes of circuits with a coil, which follow
    "drive", "drive_steps",  # where forces of each row in each step begin, and how many there are
    "tapped",
    "wall_at", "wall_kind",  # number of the elongation; kind of restitution, or the address of a function
    "damper_at", "damper_kind", "damper_place",  # the last: of its state, or the number of a contact
    "contact_at",
    "shaken_at", "shaken_begin", "shaken_steps",
    "at",  # where the sums of each kind begin, in the order of SUMS
)  # fmt: skip
NUMBERS = (
    "step",
    "rounding",  # relative, of the precision of the sweep
    "row", "noise", "source_row",  # values of sparse rows; noise with sqrt(q h)
    "wave",  # (2 sources) see `springpot.simulation.kernel.excitations`
    "smooth",  # of each source: 1 of a force that changes little within a step, otherwise 0
    "constant",  # impulse of constant forces on each coordinate in a step
    "origin",  # the place in the user's displacements from which a lone coordinate is measured
    "early",  # displacement of each coordinate at the first kick by what springpots remember of the start
    "spring",  # (10 rows) coefficients of the springs, times the step
    "kick",  # the same without what the drift has
    "damping",  # weight of the present velocity in the force of springpots and dashpots
    "answer",  # their mean force within a step per unit of impulse in that step
    "near",  # (20 rows) weights of the two increments before the group and of its first three, in each of four steps
    "solve",  # (points * points) inverse of mass + step * answers
    "side",  # 1: the elongation stays above the place, -1: below
    "place",
    "restitution",  # (3 walls) a number, or of a power of the speed
    "jump",  # (walls * points) change of the velocities per unit of change of the elongation's velocity
    "along",  # (walls * rows) the same, of the elongations' velocities
    "reduced",  # mass along the row of each wall
    "rests",  # 1 of a lossy wall along whose row only smooth forces act, otherwise 0
    "lean",  # (walls * points) as jump, with the answers of dampers and memory
    "heavy",  # as reduced, with these
    "mass",  # (points * points)
    "damper",  # (6 dampers) numbers of the law per unit of reduced mass, and that
    "damper_jump", "damper_along",  # as of walls
    "contact",  # (6 contacts) place, direction of the force, stiffness, exponent, dissipation, reduced mass
    "contact_jump", "contact_along",
    "shaken",  # (2 shaken) variance of the impulses per square, and half of it over the reduced mass
    "turn",  # of half a drift on a circle cosine less 1, sine / frequency, sine * frequency; of all of it; frequency
    "modes",  # (8 numbers of each mode) four powers, four weights
    "turns_of_modes",  # (20 of each)
)  # fmt: skip
SUMS = (  # "soft" is of contacts together: time in touch, and the largest depth
    "x", "xx", "vv", "u", "uu", "ww", "power", "works", "force", "virial", "hits", "soft", "taps", "energy", "x_end",
    "v_end", "limits", "early_xx", "early_vv",
)  # fmt: skip

_WHERE = {name: i for i, name in enumerate((*COUNTS, *LISTS, *(f"number {name}" for name in NUMBERS)))}
(POINTS, ROWS, GAUGED, SHOWN, FORCED, WALLS, NOISES, SOURCES, DAMPERS, CONTACTS, SHAKEN, TAPS, MODES, RESTING, STATES,
 TURNS, PAPER, PARTS, SUBSTEPS, BLOCKS, STRIDE, STRIDE_IN_DOUBLE, GOES_ON, COLUMNS,
 ROW_BEGIN, ROW_AT, NOISE_BEGIN, NOISE_AT, SOURCE_BEGIN, SOURCE_AT, SOURCE, SPRING_KIND, MODE_COUNT, MODE_BEGIN,
 MODE_TABLE, TURNED, TURNED_TABLE, DRIVE, DRIVE_STEPS, TAPPED, WALL_AT, WALL_KIND, DAMPER_AT, DAMPER_KIND, DAMPER_PLACE,
 CONTACT_AT, SHAKEN_AT, SHAKEN_BEGIN, SHAKEN_STEPS, AT,
 STEP, ROUNDING, ROW, NOISE, SOURCE_ROW, WAVE, SMOOTH, CONSTANT, ORIGIN, EARLY, SPRING, KICK, DAMPING, ANSWER, NEAR,
 SOLVE, SIDE, PLACE, RESTITUTION, JUMP, ALONG, REDUCED, RESTS, LEAN, HEAVY, MASS, DAMPER, DAMPER_JUMP, DAMPER_ALONG,
 CONTACT, CONTACT_JUMP, CONTACT_ALONG, SHAKING, TURN, MODE, TURN_OF_MODES) = range(len(_WHERE))  # fmt: skip
(X, XX, VV, U, UU, WW, POWER, WORKS, FORCE, VIRIAL, HITS, SOFT, TAPPED_SQUARES, ENERGY, X_END, V_END, LIMITS,
 EARLY_XX, EARLY_VV) = range(len(SUMS))  # fmt: skip
OF_A_WALL = 5  # sums of a wall or contact: impacts, speeds, their squares, energy taken, momentum
OF_A_SOURCE = 8
IN_TURN, AT_RANDOM, COMMON = range(3)  # which of several records a path has; the last: in turn, and they stand once


@dataclass(frozen=True, eq=False)
class Tables:
    """The tables of a system.

    Attributes
    ----------
    integers : ndarray of int64
    numbers : ndarray of float64
        Without the long lists behind them.
    sweep : ndarray of float32 or float64
        The same numbers in the precision of the sweep, and behind them the long lists.
    by_lane : bool
        Whether each lane has numbers of its own: each number stands LANES times, once for each lane.
    """

    integers: npt.NDArray[np.int64]
    numbers: Floats
    sweep: npt.NDArray[np.floating]
    by_lane: bool = False

    def __iter__(self) -> Iterator[Any]:
        return iter((self.integers, self.numbers, self.sweep))

    def count(self, name: str) -> int:
        """How many there are of something."""
        return int(self.integers[_WHERE[name]])


def packed(
    counts: Mapping[str, int],
    lists: Mapping[str, Any],
    numbers: Mapping[str, Any],
    long: Sequence[Floats],
    kind: npt.DTypeLike,
) -> Tables:
    """The tables of a system.

    Parameters
    ----------
    counts : dict of int
    lists : dict of array of int
        All LISTS but ``at``.  In ``drive``, ``shaken_begin`` and the seventh number of each source stands the number of
        a long list, or -1 for none; the table has where it begins.
    numbers : dict of array of float
        All NUMBERS.
    long : sequence of ndarray
        Lists that only the sweep needs, in its precision.
    kind : dtype
        Of the sweep.
    """
    head = np.zeros(len(_WHERE), np.int64)
    flat = [np.asarray(numbers[name], float).ravel() for name in NUMBERS]
    ends = np.cumsum([0, *(part.size for part in flat)])
    for name, begin in zip(NUMBERS, ends, strict=False):
        head[_WHERE[f"number {name}"]] = begin
    begins = ends[-1] + np.cumsum([0, *(part.size for part in long)])
    at = begins_of_sums(counts)
    whole = {**lists, "at": at[:-1]}
    placed = list[npt.NDArray[np.int64]]()
    for name in LISTS:
        own = np.array(whole[name], np.int64).ravel()
        where = slice(None) if name in ("drive", "shaken_begin") else slice(6, None, OF_A_SOURCE)
        if name in ("drive", "shaken_begin", "source"):
            own[where] = [begins[number] if number >= 0 else -1 for number in own[where]]
        if name in ("mode_table", "turned_table"):
            own += head[_WHERE["number modes" if name == "mode_table" else "number turns_of_modes"]]
        head[_WHERE[name]] = head.size + sum(part.size for part in placed)
        placed.append(own)
    for name in COUNTS:
        head[_WHERE[name]] = counts.get(name, 0)
    head[_WHERE["columns"]] = at[-1]
    double = np.concatenate(flat)
    return Tables(
        np.concatenate([head, *placed]), double,
        np.concatenate([double.astype(kind), *(np.asarray(part).astype(kind).ravel() for part in long)]),
    )  # fmt: skip


def stacked(systems: Sequence[Tables], blocks: int, goes_on: bool = False) -> Tables:
    """The tables of several systems with the same integers, each of which has so many ``blocks`` of a call.

    With ``goes_on`` the numbers of the paths go on from each system to the next.
    """
    return Tables(
        _with(systems[0], blocks=blocks, goes_on=int(goes_on)), np.concatenate([each.numbers for each in systems]),
        np.concatenate([each.sweep for each in systems]),
    )  # fmt: skip


def side_by_side(systems: Sequence[Tables], lanes: int) -> Tables:
    """The tables of several systems with the same `common` numbers, each in so many neighbouring ``lanes``."""
    numbers, sweeps = np.stack([each.numbers for each in systems]), np.stack([each.sweep for each in systems])
    return by_lane(systems[0], numbers, sweeps, np.repeat(np.arange(len(systems)), lanes))


def by_lane(one: Tables, numbers: Floats, sweeps: npt.NDArray[np.floating], which: npt.NDArray[np.int64]) -> Tables:
    """The tables of blocks in which each lane has the numbers of one of several systems.

    The numbers of the paths go on from each block to the next.

    Parameters
    ----------
    one : Tables
        Of one of the systems.
    numbers, sweeps : ndarray, shape (systems, numbers)
        Of the tables of all.
    which : ndarray of int
        The system of each lane: a multiple of LANES of them.
    """

    def apart(rows: npt.NDArray[Any]) -> npt.NDArray[Any]:
        return rows[which].reshape(-1, LANES, rows.shape[1]).transpose(0, 2, 1).ravel()

    return Tables(_with(one, blocks=1, goes_on=1), apart(numbers), apart(sweeps), by_lane=True)


def with_common_records(tables: Tables, records: int, impulses: Floats) -> Tables:
    """Tables by lane of one block whose only source is a record: so many, of one lane after another.

    Their impulses stand once, not once for each lane.
    """
    integers = tables.integers.copy()
    source = integers[_WHERE["source"]]
    integers[source + 3 : source + OF_A_SOURCE] = records, COMMON, 0, tables.numbers.size // LANES, impulses.size
    return replace(tables, integers=integers, sweep=np.concatenate([tables.numbers, impulses]))


def common(tables: Tables) -> bytes:
    """What systems in neighbouring lanes must have in common: all integers, and numbers that the kernel reads once.

    These are the step, the exponents of laws, and the powers of the modes of memories, which depend on the order and
    the step; their weights need not be alike.
    """
    at, numbers = tables.integers, tables.numbers
    modes = numbers[at[MODE] : at[TURN_OF_MODES]].reshape(-1, 8)[:, :4]
    laws = (numbers[at[begin] + 3 : at[end] : 6] for begin, end in ((DAMPER, DAMPER_JUMP), (CONTACT, CONTACT_JUMP)))
    alike = (numbers[at[STEP] : at[ROUNDING] + 1], numbers[at[SMOOTH] : at[CONSTANT]], modes, *laws)
    return b"".join([at.tobytes(), *(each.tobytes() for each in alike)])


def _with(tables: Tables, **counts: int) -> npt.NDArray[np.int64]:
    """The integers of one of several systems in a call."""
    integers = tables.integers.copy()
    for name, number in {**counts, "stride": tables.sweep.size, "stride_in_double": tables.numbers.size}.items():
        integers[_WHERE[name]] = number
    return integers


def begins_of_sums(counts: Mapping[str, int]) -> npt.NDArray[np.int64]:
    """Where the sums of each kind begin in a row of results, and its end."""
    n = counts["points"]
    sizes = {
        "x": n, "xx": n, "vv": n, "u": counts["gauged"], "uu": counts["gauged"], "ww": counts["shown"], "power": 1,
        "works": counts["sources"] + counts["dampers"] + counts["shaken"],
        "force": counts["forced"], "virial": counts["forced"], "soft": 2 if counts["contacts"] else 0,
        "hits": OF_A_WALL * (counts["walls"] + counts["contacts"]), "taps": counts["taps"], "energy": 2, "x_end": n,
        "v_end": n, "limits": 2, "early_xx": n, "early_vv": n,
    }  # fmt: skip
    return np.cumsum([0, *(sizes[name] for name in SUMS)], dtype=np.int64)
