"""Forces of parts, and what they add up to, in the middle of a step: observers see them beside the displacements.

In a kick the springs have the elongation of that time, and parts that yield their z then; dashpots the mean of the
velocities before and after it, and memory its mean force over the step around it.
"""

from __future__ import annotations

from numba import njit

from springpot.simulation.kernel.lanes import GROUP, INLINE, LANES, f64
from springpot.simulation.kernel.soft_contacts import force_of_contact

MOST_FELT = 40
NUMBERS = 20
"""Of a term: ten coefficients of springs; the weights of the force of dampers and memory, of the velocity, of a contact
and of the z of a part that yields; the place of this z among the states of all forces; from the 16th on the contact,
as `springpot.simulation.kernel.soft_contacts.force_of_contact` has it.
"""


@njit(**INLINE)
def feel(observers, number, count, u, pull, middle, given, state, to):
    """What is felt, from lane arrays of each row at the kick: the elongation, the force of dampers and memory, and the
    mean velocity; and from the impulses of sources in the step, and the states of forces.

    ``count``: LANES, or of a single row all steps of a group in one.  The row of a term with the source r is -1 - r.
    """
    begin, end = observers.felt_begin[number], observers.felt_begin[number + 1]
    begun = begin < end and observers.felt_row[begin] >= 0
    for lane in range(0 if begun else count):
        to[lane] = 0.0
    for term in range(begin, end):
        i, k = observers.felt_row[term] * LANES, NUMBERS * term
        if i < 0:
            at = (-1 - observers.felt_row[term]) * GROUP * LANES
            for lane in range(count):
                to[lane] += observers.felt[k + 10] * given[at + lane]
            continue
        constant, linear = observers.felt[k], observers.felt[k + 1]
        weight, damping = observers.felt[k + 10], observers.felt[k + 11]
        if begun and term == begin:
            for lane in range(count):
                to[lane] = (constant + linear * u[i + lane]) + (weight * pull[i + lane] + damping * middle[i + lane])
        else:
            for lane in range(count):
                to[lane] += (constant + linear * u[i + lane]) + (weight * pull[i + lane] + damping * middle[i + lane])
        for power in range(2, 10):
            factor = observers.felt[k + power]
            if factor != 0.0:
                for lane in range(count):
                    product = factor
                    for _ in range(power):
                        product *= u[i + lane]
                    to[lane] += product
        share, place, away = observers.felt[k + 12], observers.felt[k + 15], observers.felt[k + 16]
        stiffness, exponent, loss = observers.felt[k + 17], observers.felt[k + 18], observers.felt[k + 19]
        touching = 0
        for lane in range(count if share != 0.0 else 0):
            touching += 1 if away * (place - u[i + lane]) > 0.0 else 0
        numbers = place, away, share * stiffness, loss
        if touching > 0 and exponent == 1.0:  # a constant makes vector code
            _press(*numbers, 1.0, count, i, u, middle, to)
        elif touching > 0 and exponent == 1.5:
            _press(*numbers, 1.5, count, i, u, middle, to)
        elif touching > 0:
            _press(*numbers, exponent, count, i, u, middle, to)
        share = observers.felt[k + 13]
        if share != 0.0:
            i = int(observers.felt[k + 14]) * LANES
            for lane in range(count):
                to[lane] += share * state[i + lane]


@njit(**INLINE)
def _press(place, away, stiffness, loss, exponent, count, i, u, middle, to):
    """Add the force of a contact."""
    for lane in range(count):
        _, force = force_of_contact((place, away, stiffness, exponent), 0, f64(u[i + lane]), 1.0)
        to[lane] += force * (1.0 - away * loss * middle[i + lane])


@njit(**INLINE)
def record_felt(observers, before, shown, n, j, every, lane):
    """Store what is felt in step n + j of a lane; ``before`` displacements are shown before it.

    At time 0 nothing is felt yet: there stands what the first kick has.
    """
    for k in range(observers.record.shape[2]):
        here = shown[(GROUP * (before + observers.feels[k]) + j) * LANES + lane]
        if (n + j + 1) % every == 0:
            observers.record[lane, (n + j + 1) // every, k] = here
        if n + j == 0:
            observers.record[lane, 0, k] = here
