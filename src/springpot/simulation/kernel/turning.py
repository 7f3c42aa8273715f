"""The modes of circuits with a coil: two states each, which a step turns into each other."""

from __future__ import annotations

from numba import njit

from springpot.simulation.kernel.lanes import INLINE, LANES

NUMBERS = 20
"""Of a mode: what four steps change of two states; what the four increments add; and the force in the next four."""


@njit(**INLINE)
def turn(z, z0, d, d0, h, h0, modes, table, t0):
    """Add four increments to every mode, and their force to that of the other modes in the next four steps."""
    for k in range(modes):
        t, i = t0 + NUMBERS * k, z0 + 2 * k * LANES
        j = i + LANES
        yy, yq, qy, qq = table[t], table[t + 1], table[t + 2], table[t + 3]  # less 1 on the diagonal
        y0, q0, y1, q1 = table[t + 4], table[t + 5], table[t + 6], table[t + 7]
        y2, q2, y3, q3 = table[t + 8], table[t + 9], table[t + 10], table[t + 11]
        u1, w1, u2, w2 = table[t + 12], table[t + 13], table[t + 14], table[t + 15]
        u3, w3, u4, w4 = table[t + 16], table[t + 17], table[t + 18], table[t + 19]
        for lane in range(LANES):
            e0, e1 = d[d0 + LANES + lane], d[d0 + 2 * LANES + lane]
            e2, e3 = d[d0 + 3 * LANES + lane], d[d0 + 4 * LANES + lane]
            y, q = z[i + lane], z[j + lane]
            z[i + lane] = y + (yy * y + yq * q + y0 * e0 + y1 * e1 + y2 * e2 + y3 * e3)
            z[j + lane] = q + (qy * y + qq * q + q0 * e0 + q1 * e1 + q2 * e2 + q3 * e3)
            y, q = z[i + lane], z[j + lane]
            h[h0 + lane] += u1 * y + w1 * q
            h[h0 + LANES + lane] += u2 * y + w2 * q
            h[h0 + 2 * LANES + lane] += u3 * y + w3 * q
            h[h0 + 3 * LANES + lane] += u4 * y + w4 * q
