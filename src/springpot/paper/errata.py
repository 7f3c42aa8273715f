"""Slips in the print of "Stochastic response of a fractional vibroimpact system", with the numbers that show them.

None of them changes the paper's idea, and at Omega = 1, the only case it computes, none changes its final formula.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np
from scipy import special
from scipy.integrate import quad

from springpot.machine.arrays import Floats
from springpot.problem.oscillator import Oscillator
from springpot.problem.parts import Barrier, Springpot, WhiteNoise
from springpot.simulation.monte_carlo import simulated
from springpot.theory import averaging
from springpot.theory.fourier import coefficients, cosine_integral, sine_integral


@dataclass(frozen=True)
class Finding:
    """One number of a check, and the values that the print and the correction give for it.

    Parameters
    ----------
    what : str
        What the number is.
    computed : float
        The number, computed without the equation in question.
    printed, corrected : float
        What the equation gives as printed and as corrected.
    """

    what: str
    computed: float
    printed: float
    corrected: float


@dataclass(frozen=True)
class Erratum:
    """One slip of the print.

    Parameters
    ----------
    number : int
        Its place in this list.
    equation : str
        Where it stands in the paper.
    title, statement : str
        What is wrong and what is right.
    check : callable
        Computes the findings that show it.
    remark : str
        What there is to say about the findings' digits, if anything.
    """

    number: int
    equation: str
    title: str
    statement: str
    check: Callable[[], tuple[Finding, ...]]
    remark: str = ""


def roles_of_the_order() -> tuple[Finding, ...]:
    """Free response of an oscillator without a wall at either end of the range, found by marching Eq. 1 and 2."""
    omega, coefficient, step = 1.0, 0.2, 2e-3
    spring, dashpot = (_free_response(alpha, omega, coefficient, step) for alpha in (0.0, 1.0))
    stiffened = omega**2 + coefficient, 0.0  # squared frequency of x(t), and its rate of decay, under a spring C
    damped = omega**2 - coefficient**2 / 4.0, coefficient / 2.0  # and under a dashpot C
    words = "squared frequency, in s^-2", "rate of decay, in 1/s"
    return tuple(
        Finding(f"free response at alpha = {alpha}: {word}", computed, printed, corrected)
        for alpha, response, slip, right in ((0, spring, damped, stiffened), (1, dashpot, stiffened, damped))
        for word, computed, printed, corrected in zip(words, response, slip, right, strict=True)
    )


def _free_response(alpha: float, omega: float, coefficient: float, step: float) -> tuple[float, float]:
    """Squared frequency and rate of decay of x(t), x(0) = 0, without wall and noise.

    Two earlier values of a decaying sinusoid predict the next one; a fit of that rule gives both numbers.
    """
    x = _march(alpha, omega, coefficient, step, steps=8000, mirrored=False)[:: round(0.4 / step)]
    later, earlier = np.linalg.lstsq(np.column_stack([x[1:-1], x[:-2]]), x[2:], rcond=None)[0].tolist()
    root = np.log(np.roots([1.0, -later, -earlier])[0]) / (0.4 * omega)
    return float(root.imag**2), float(-root.real)


def _march(alpha: float, omega: float, coefficient: float, step: float, steps: int, mirrored: bool) -> Floats:
    """Eq. 5 without noise (``mirrored``), or Eq. 1 without wall and noise, from rest with unit velocity.

    The fractional derivative is its Grünwald-Letnikov sum, so nothing is used but Eq. 2.
    """
    weights = np.cumprod(np.concatenate([[1.0], 1.0 - (1.0 + alpha) / np.arange(1, steps + 1)])) * step**-alpha
    y = np.zeros(steps + 1)
    history = np.zeros(steps + 1)  # of |y|, or of y
    v = 1.0
    for n in range(steps):
        side = math.copysign(1.0, y[n]) if mirrored else 1.0
        memory = float(weights[: n + 1] @ history[n::-1])
        v -= step * (omega**2 * y[n] + side * coefficient * memory)
        y[n + 1] = y[n] + step * v
        history[n + 1] = abs(y[n + 1]) if mirrored else y[n + 1]
    return y


def side_of_the_wall() -> tuple[Finding, ...]:
    """Free motion by Eq. 3 and 5, which have no wall, against runs with a wall on either side of the mass."""
    omega, coefficient, alpha, duration, step = 1.0, 0.3, 0.5, 10.0, 2e-3
    x = np.abs(_march(alpha, omega, coefficient, step, round(duration / step), mirrored=True))

    def with_wall(free_side: Literal["above", "below"]) -> Floats:
        oscillator = Oscillator(omega, Springpot(alpha, coefficient), Barrier(free_side=free_side), WhiteNoise(0.0))
        away = 1.0 if free_side == "above" else -1.0
        found = simulated(
            oscillator, paths=1, record=1, duration=duration, step=step, initial_velocity=away, memory_tolerance=1e-9
        )
        return found.record[0, :, 0]

    printed, corrected = with_wall("below"), with_wall("above")
    first = round(math.pi / 2.0 / step)
    return (
        Finding("mean of x over 10 s of free motion, in m", *(float(np.mean(p)) for p in (x, printed, corrected))),
        Finding("x a quarter period after the start, in m", *(float(p[first]) for p in (x, printed, corrected))),
    )


def sign_of_the_force() -> tuple[Finding, ...]:
    """Rates of amplitude and phase from the y-equation itself, against Eq. 7-8: force at y > 0, noise at y < 0."""
    amplitude, omega = 1.3, 1.7

    def rates(theta: float, force: float, noise: float) -> complex:
        """A' + i theta' by differentiating A and theta along the motion, with y'' from Eq. 5."""
        y, v = amplitude * math.cos(theta), -amplitude * omega * math.sin(theta)
        acceleration = -(omega**2) * y + math.copysign(1.0, y) * (noise - force)
        step = 1e-6

        def state(time: float) -> complex:
            return complex(y + v * time, -(v + acceleration * time) / omega)

        late, early = state(step), state(-step)
        return complex(abs(late) - abs(early), np.angle(late / early)) / (2.0 * step)

    right, left = 0.9, 2.2
    by_force = rates(right, 1.0, 0.0) - rates(right, 0.0, 0.0)
    by_noise = rates(left, 0.0, 1.0) - rates(left, 0.0, 0.0)

    def printed(theta: float) -> complex:
        """Coefficient of C D^alpha|y| (at y > 0) and of zeta in Eq. 7 and 8."""
        return -complex(math.sin(theta) / omega, math.cos(theta) / (amplitude * omega))

    return tuple(
        Finding(f"{rate} per unit of {cause}", part(computed), part(slip), -part(slip))
        for cause, computed, slip in (
            ("C D^alpha|y| at y > 0", by_force, printed(right)),
            ("zeta at y < 0", by_noise, printed(left)),
        )
        for rate, part in (("A'", np.real), ("theta'", np.imag))
    )


def lost_frequency() -> tuple[Finding, ...]:
    """Rate of change of Eq. 12 at late times, the sine integral near t = 0, and the final formula at alpha = 1."""
    omega, alpha, m = 3.0, 0.6, 2
    k = 2.0 * m * omega
    late = 1e5

    def memory(time: float) -> float:
        """The left side of Eq. 12 with theta = Omega t + pi/5."""
        angle = 2.0 * m * (omega * time + math.pi / 5)
        c, s = cosine_integral(k, time, alpha), sine_integral(k, time, alpha)
        return float(math.cos(angle) * c + math.sin(angle) * s)

    # central difference with the factor that makes it exact for a sinusoid of angular frequency k
    step = 0.1 / k
    slope = (memory(late + step) - memory(late - step)) * k / (2.0 * math.sin(k * step))
    angle = 2.0 * m * (omega * late + math.pi / 5)
    steady = k ** (alpha - 1.0) * math.gamma(1.0 - alpha) * math.sin(math.pi / 2 * (1 - alpha) - angle)
    z = 200.0
    remainder = float(sine_integral(1.0, z, alpha)) - math.gamma(1.0 - alpha) * math.cos(alpha * math.pi / 2)
    dashpot = Oscillator(omega, Springpot(1.0, 0.2))
    exact = 1.0 / (0.2 * omega**2)
    return (
        Finding(f"d/dt of Eq. 12 at Omega = {omega:g}, m = {m}, late", slope, 2 * m * steady, 2 * m * omega * steady),
        Finding(
            "13b less its limit at 2m Omega t = 200, per (2m Omega)^(alpha-1)",
            remainder,
            math.cos(z) / z**alpha,
            -math.cos(z) / z**alpha,
        ),
        Finding(
            f"<A^2> of a dashpot C = 0.2 at Omega = {omega:g}, q = 1, in m^2 (Eq. 20)",
            exact,
            averaging(dashpot, form="printed").amplitude_mean_square,
            averaging(dashpot).amplitude_mean_square,
        ),
    )


def prefactor_of_the_cosine() -> tuple[Finding, ...]:
    """The integrand of Eq. 16 over a quarter turn, where it does not vanish, and over the whole turn, where it does."""

    def integrand(m: int) -> Callable[[float], float]:
        return lambda p: math.cos(2 * m * p) * math.sin(p)

    quarters = (
        Finding(
            f"quarter turn of Eq. 16, m = {m}",
            quad(integrand(m), 0.0, math.pi / 2)[0],
            -1.0 / (2 * m * m - 1),
            -1.0 / (4 * m * m - 1),
        )
        for m in (1, 2, 3)
    )
    return (*quarters, Finding("whole turn of Eq. 16, m = 2", _turn(integrand(2)), 0.0, 0.0))


def sign_of_the_sine() -> tuple[Finding, ...]:
    """Eq. 17 by quadrature, and the decay per unit of amplitude that Eq. 15 gives with it."""

    def integrand(m: int) -> Callable[[float], float]:
        return lambda p: math.sin(2 * m * p) * math.sin(p)

    terms, alpha = 6, 0.5
    m = np.arange(1, terms + 1)
    printed = np.where(m % 2 == 0, 8.0, -8.0) * m / (4 * m**2 - 1)
    computed = np.array([_turn(integrand(int(each))) for each in m])
    # Eq. 15 with its printed prefactor at C = Omega = 1: A'/A = -A_m m (2m)^(alpha-1) / pi (0 - Eq. 17)
    weights = coefficients(terms) * m * (2.0 * m) ** (alpha - 1.0) * math.sin(alpha * math.pi / 2) / math.pi
    by_18 = 32.0 / math.pi**2 * math.sin(alpha * math.pi / 2) * m**2 * (2.0 * m) ** (alpha - 1.0) / (4 * m**2 - 1) ** 2
    integrals = (
        Finding(f"Eq. 17 over sin(alpha pi/2), m = {each}", value, slip, -slip)
        for each, value, slip in zip(m.tolist(), computed.tolist(), printed.tolist(), strict=True)
    )
    growth = Finding(
        "A'/A by Eq. 18, six terms at alpha = 0.5, C = Omega = 1, in 1/s; by Eq. 15 with Eq. 17",
        float(-by_18.sum()),
        float(weights @ printed),
        float(weights @ computed),
    )
    return (*integrals, growth)


def ito_drift() -> tuple[Finding, ...]:
    """Drift and growth of the amplitude of an undamped oscillator, from the exact law of its increments.

    Over a whole period the white noise adds to (y, y'/Omega) a normal vector whose two parts are independent, each of
    variance s^2 = q T / (2 Omega^2).  The new amplitude has Rice's distribution, whose mean is known in closed form.
    """
    omega, q, amplitude = 2.0, 0.01, 1.0
    period = 2.0 * math.pi / omega
    variance = q * period / (2.0 * omega**2)
    h = amplitude**2 / (4.0 * variance)
    rice_mean = math.sqrt(math.pi * variance / 2.0) * ((1 + 2 * h) * special.ive(0, h) + 2 * h * special.ive(1, h))
    drift = (float(rice_mean) - amplitude) / period
    # the growth of <A^2> from the impulse response sin(Omega s) / Omega: q int (sin^2 + cos^2) / Omega^2 ds
    power = quad(lambda s: math.sin(omega * s) ** 2 + math.cos(omega * s) ** 2, 0.0, period)[0]
    growth = q / omega**2 * power / period
    diffusion = q / (2.0 * omega**2)
    slip, right = q / (2.0 * omega**2 * amplitude), q / (4.0 * omega**2 * amplitude)
    return (
        Finding("noise part of the drift of A at A = 1 m, in m/s", drift, slip, right),
        Finding(
            "growth of <A^2> by Ito's rule, 2 A drift + diffusion, in m^2/s",
            growth,
            2.0 * amplitude * slip + diffusion,
            2.0 * amplitude * right + diffusion,
        ),
    )


def _turn(integrand: Callable[[float], float]) -> float:
    """int_0^2pi integrand(p) sign(cos p) dp, cut where the sign changes."""
    corners = (0.0, math.pi / 2, 3 * math.pi / 2, 2 * math.pi)
    parts = (quad(integrand, low, high)[0] for low, high in pairwise(corners))
    return math.fsum(sign * part for sign, part in zip((1.0, -1.0, 1.0), parts, strict=True))


ERRATA = (
    Erratum(
        1,
        "text after Eq. 1",
        "Spring and dashpot are swapped",
        "The text calls C a damping coefficient at alpha = 0 and a stiffness at alpha = 1. By Eq. 2 the derivative of "
        "order 0 is x itself, so C is a stiffness there, and at alpha = 1 it is x', so C is a damping coefficient.",
        roles_of_the_order,
        "*Computed* is a free response, marched through Eq. 1 and 2 with a finite step; hence its last digits.",
    ),
    Erratum(
        2,
        "Eq. 1 against Eq. 3",
        "The mass is on the other side of the wall",
        "Eq. 1 lets the mass move at x < h, and with h = 0 that is x < 0; Eq. 3 sets x = |y|, which is x >= 0. The two "
        "problems are mirror images, so all but the sign of x is the same.",
        side_of_the_wall,
        "*Computed* is |y| from Eq. 5, in which there is no wall, marched with a finite step (hence its last digits); "
        "the other columns are runs of the library with the mass below and above a wall at 0.",
    ),
    Erratum(
        3,
        "Eq. 7 and 8",
        "The springpot's force has the wrong sign, and sgn(y) is missing",
        "Putting Eq. 6 into Eq. 5 gives A' = (sin theta / Omega) sgn(y) [C D^alpha|y| - zeta] and theta' = Omega + "
        "(cos theta / (A Omega)) sgn(y) [C D^alpha|y| - zeta]. The print has the force with the other sign in both, "
        "and lacks sgn(y) on the noise in both and on the force in Eq. 8.",
        sign_of_the_force,
    ),
    Erratum(
        4,
        "Eq. 14, and through it Eq. 15 and 18-20",
        "The time derivative loses a factor Omega",
        "With theta' = Omega, differentiating cos 2m theta brings out 2m Omega, where the print has 2m. The loss is "
        "carried to the end: Eq. 18-20 have Omega^(alpha-2) where Omega^(alpha-1) belongs, so the printed mean square "
        "is too large by the factor Omega, and its units do not agree. In the same equation the sum over m is not "
        "written, the middle member lacks the factor A / Gamma(1-alpha), and the second cosine term has a plus where "
        "Eq. 13b has, rightly, a minus.",
        lost_frequency,
        "In the second row *computed* is the exact integral, and Eq. 13b keeps one term of an asymptotic series: the "
        "last digits differ by its next term, smaller by the order of alpha / (2m Omega t).",
    ),
    Erratum(
        5,
        "Eq. 16",
        "The prefactor has 2m^2 - 1 for 4m^2 - 1",
        "The antiderivative brings out 1 / (4m^2 - 1). The integral over a whole turn is zero with either, so nothing "
        "follows from it.",
        prefactor_of_the_cosine,
    ),
    Erratum(
        6,
        "Eq. 17, with Eq. 15",
        "The integral has the other sign",
        "The integral is (-1)^(m+1) 8m / (4m^2 - 1), for example +8/3 at m = 1. Eq. 15-17 as printed make the "
        "amplitude grow, and Eq. 18 does not follow from them; Eq. 15 as printed with the right integral gives the "
        "decay of Eq. 18 as printed. Eq. 7 and 14 as printed would give Eq. 15 a plus in front, and then the slips in "
        "Eq. 7 and 17 cancel.",
        sign_of_the_sine,
    ),
    Erratum(
        7,
        "Eq. 15 and 18",
        "The noise term is not the drift of the amplitude",
        "The Ito drift due to the noise is q / (4 Omega^2 A), with diffusion q / (2 Omega^2), and these give Eq. 19. "
        "The printed q / (2 Omega^2 A) gives Eq. 19 only when the diffusion is left out; read as an Ito drift it would "
        "make the noise feed <A^2> half as fast again.",
        ito_drift,
        "*Computed* has a finite noise, q = 0.01, and the drift is its limit for weak noise: hence the last digits of "
        "the first row.",
    ),
)
"""The seven slips, in the order of the paper."""
