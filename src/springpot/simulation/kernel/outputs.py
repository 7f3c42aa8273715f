"""Forces of parts, and what they add up to, in the middle of a step: observers see them beside the displacements.

In a kick the springs have the elongation of that time, and parts that yield their z then; dashpots the mean of the
velocities before and after it, and memory its mean force over the step around it.
"""

from __future__ import annotations

from numba import njit

from springpot.simulation.kernel.contacts import pressed
from springpot.simulation.kernel.lanes import GROUP, INLINE, LANES, LINKED
from springpot.simulation.kernel.vectors import double, doubles, filled, load, store
from springpot.simulation.kernel.watching import (
    OUTPUT_BEGIN,
    OUTPUT_NUMBERS,
    OUTPUT_ROW,
    OUTPUTS,
    OUTPUTS_COUNT,
    RECORD,
    RECORD_POINTS,
)

MOST_OUTPUTS = 40
NUMBERS = 20
"""Of a term: ten coefficients of springs; the weights of the force of dampers and memory, of the velocity, of a contact
and of the z of a part that yields; the place of this z among the states of all forces; from the 16th on the contact,
as `springpot.simulation.kernel.contacts.elastic` has it, but for its mass.
"""


@njit(**LINKED)
def output_of(S, T, elongation, number, j, to, o):
    """An output in step j of the group; a source has the row -1 less its number."""
    N, total = doubles(S[OUTPUT_NUMBERS]), filled(double(load(elongation, o)), 0.0)
    for term in range(S[S[OUTPUT_BEGIN] + number], S[S[OUTPUT_BEGIN] + number + 1]):
        row, b = S[S[OUTPUT_ROW] + term], NUMBERS * term
        if row < 0:
            total = total + N[b + 10] * double(load(T.inputs, ((-1 - row) * GROUP + j) * LANES + o))
            continue
        u, middle = double(load(elongation, row * LANES + o)), double(load(T.middle, row * LANES + o))
        total = total + (N[b] + N[b + 1] * u + (N[b + 10] * load(T.pull, row * LANES + o) + N[b + 11] * middle))
        for k in range(2, 10):
            if N[b + k] != 0.0:
                product = N[b + k] * u
                for _ in range(k - 1):
                    product = product * u
                total = total + product
        if N[b + 12] != 0.0:
            total = total + N[b + 12] * pressed(N, b + 15, u, middle)
        if N[b + 13] != 0.0:
            total = total + N[b + 13] * load(T.state, int(N[b + 14]) * LANES + o)
    store(to, o, total)


@njit(**INLINE)
def record_outputs(S, before, shown, n, j, every, lane):
    """Store the outputs in step n + j of a lane; ``before`` displacements are shown before it.

    At time 0 there is none yet: there stands what the first kick has.
    """
    record, seen = doubles(S[RECORD]), S[OUTPUTS_COUNT]
    for k in range(seen):
        here = shown[(GROUP * (before + S[S[OUTPUTS] + k]) + j) * LANES + lane]
        row = lane * S[RECORD_POINTS]
        if (n + j + 1) % every == 0:
            record[(row + (n + j + 1) // every) * seen + k] = here
        if n + j == 0:
            record[row * seen + k] = here
