"""Parts that yield: their force depends on the way that the elongation took, not on how fast."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, ClassVar

from springpot.machine.arguments import LARGEST, finite_number
from springpot.problem.parts.checks import put
from springpot.problem.parts.registration import Element, Law, Number
from springpot.problem.parts.springpots import Maxwell

__all__ = ["BoucWen", "Jenkins"]

_MOST = 50.0  # exponent; beyond it is a Jenkins element
_FAR = 7.0  # standard deviations beyond which it is no matter how seldom a slider slips
_HARDLY = 0.01  # of the power of dry friction: a part that takes less of the motion is a spring


@dataclass(frozen=True)
class Yielding(Element, abstract=True):
    """An element with the force k z, where z follows the elongation u until it yields.

    At time 0 it has been brought from u = 0, where it has no force, to its elongation in one stroke.
    """

    glyph, powers = "slider arm", ("taken",)
    is_linear, remembers, dissipates, is_thermal, is_odd, yields = False, True, True, False, True, True
    is_seen, is_rough = True, True
    doubt: ClassVar[str]  # of what linearization makes of it

    stiffness: Annotated[float, Number("k", "stiffness", "N m-1", "positive", "It is that before anything yields.")]
    yield_force: Annotated[
        float, Number("F", "yield force", "N", "positive", "It is the largest force that it carries.")
    ]

    @property
    def yield_displacement(self) -> float:
        """Elongation at which it would yield if it were a spring until then, in m."""
        return self.yield_force / self.stiffness

    @property
    def stiffness_at_once(self) -> float:
        """Before it yields."""
        return self.stiffness

    def taken_from(self, law: Law, frequency: float) -> tuple[float, float]:
        """That of `taken_beside` the spring of the law."""
        return 0.0, self.taken_beside(law.frequency**2, law.temperature)

    def damping_beside(self, spread: float, speed: float, reduced: float) -> float:
        """That power over the mean square of its rate."""
        if not speed > 0.0:
            return 0.0
        return reduced * self.per_mass(reduced).taken_beside(0.0, speed**2) / speed**2

    def taken_beside(self, square: float, theta: float) -> float:
        """Power that it takes of a unit mass beside a stiffness: that of dry friction, times a share.

        The share is small where the motion hardly reaches the yield displacement.

        Examples
        --------
        >>> round(Jenkins(0.9, 0.9).taken_beside(0.1, 0.379), 3)  # by simulation 0.035
        0.046
        """
        share = self.share_taken(max(self._reached(square, theta), 1e-5))
        return float(share * self.yield_force * math.sqrt(2.0 * theta / math.pi))

    def share_taken(self, reached: float) -> float:
        """Of the power of dry friction, where the motion has this share of the yield displacement."""
        raise NotImplementedError

    def nearest_arm(self, speed: float, state: float) -> tuple[Maxwell, float]:
        """The Maxwell element nearest to it in mean square, and the standard deviation of its force.

        Parameters
        ----------
        speed : float
            Standard deviation of the rate of its elongation.
        state : float
            What says how far it yields, within a range: of the kind of part.
        """
        raise NotImplementedError

    @staticmethod
    def arm_state(free: float) -> float:
        """A state of `nearest_arm` for each number, so that a search has no limits."""
        raise NotImplementedError

    def slow_dashpot(self, square: float, theta: float) -> float:
        """The dashpot that it is for slow displacements, beside a stiffness and a fast motion; 0 if it hardly yields.

        That of the Maxwell element with its stiffness that takes the same power of the fast motion, or, where this goes
        far beyond the yield displacement, of the dashpot alone.

        Examples
        --------
        >>> round(Jenkins(0.9, 0.9).slow_dashpot(0.1, 0.379), 1), Jenkins(0.9, 9.0).slow_dashpot(0.1, 0.379)
        (6.5, 0.0)
        >>> round(BoucWen(0.9, 0.9).slow_dashpot(0.1, 0.234), 1)  # that of linearization is 3.1
        2.6
        """
        taken, fast = self.taken_beside(square, theta), square + self.stiffness
        if taken < _HARDLY * self.yield_force * math.sqrt(theta):
            return 0.0
        if self._reached(square, theta) > 1.0:
            return taken / theta
        half = 0.5 * theta * self.stiffness**2 / (fast * taken)
        return half + math.sqrt(max(half**2 - self.stiffness**2 / fast, 0.0))

    def _reached(self, square: float, theta: float) -> float:
        """Standard deviation of the elongation over that at which it yields."""
        return math.sqrt(theta / (square + self.stiffness)) / self.yield_displacement

    def term(self) -> str:
        """Its force in the equation of motion."""
        return f" + {self.stiffness:.6g} z"


@dataclass(frozen=True)
class Jenkins(Yielding):
    """A spring and a dry friction slider in series: elastic, then perfectly plastic.

    With a `Spring` beside it, it is the bilinear hysteresis.

    Parameters
    ----------
    stiffness : float
        k > 0 in N/m.
    yield_force : float
        F > 0 in N: the force at which the slider slips.

    Raises
    ------
    TypeError, ValueError
        If a number is not one, not finite or not positive.

    References
    ----------
    W. D. Iwan, "A distributed-element model for hysteresis and its steady-state dynamic response", Journal of Applied
    Mechanics 33 (1966).

    Examples
    --------
    >>> Jenkins(stiffness=50.0, yield_force=2.0).yield_displacement
    0.04
    """

    said = "jenkins"
    doubt = (
        "A Jenkins part makes x far from Gaussian: under white noise <v^2> came out within 18 %, <x^2> too where half "
        "of the stiffness is left, but too small by up to 20 % where a fifth is left, and by 55 % where a twentieth is."
    )

    def nearest_arm(self, speed: float, state: float) -> tuple[Maxwell, float]:
        """The Maxwell element nearest to it in mean square, and the standard deviation of its force.

        Not z is taken as Gaussian with v, since it rests at its limits, but a variable g of which z is what lies within
        the limits.  The slider slips where g is beyond them and v points outward.  Since z is stationary, the work of
        the slip is that of the force, which gives the correlation of v and g; the moments of v and z of z' then give
        z' = c v - d z.  So a part that hardly yields becomes a spring, and one that always does dry friction.

        Parameters
        ----------
        speed : float
            Standard deviation of v.
        state : float
            That of g over the limit of z.

        Examples
        --------
        >>> arm, force = Jenkins(0.5, 0.5).nearest_arm(0.7, 1.0)
        >>> round(arm.stiffness, 3), round(arm.coefficient, 3), round(force, 3)
        (0.382, 1.751, 0.359)
        """
        from scipy import optimize, special  # slow to import

        h = min(1.0 / state, _FAR)
        within, beyond, density = math.erf(h * math.sqrt(0.5)), float(special.ndtr(-h)), _density(h)

        def slipped(rho: float) -> float:
            """E[abs(v)] over the slips, per the standard deviation of v."""
            across = h / math.sqrt(1.0 - rho * rho)
            return 2.0 * (
                _density(0.0) * float(special.ndtr(-across)) + rho * density * float(special.ndtr(rho * across))
            )

        rho = float(
            optimize.brentq(lambda rho: rho * within / h - slipped(rho), 0.0, 1.0 - 1e-14, xtol=1e-300, rtol=1e-14)
        )
        rest = math.sqrt(1.0 - rho * rho)
        square = (within - 2.0 * h * density) / (h * h) + 2.0 * beyond  # of z over its limit
        both = rho * within / h  # E[v z], of unit v and limit
        lost = beyond + 2.0 * float(special.owens_t(h, rho / rest))  # E[v^2] over the slips
        lost += 2.0 * rho * density * rho * h * float(special.ndtr(rho * h / rest))
        lost += 2.0 * rho * rest * _density(0.0) * _density(h / rest)
        c = (1.0 - lost) / (1.0 - both * both / square)
        stiffness, rate = self.stiffness * c, c * both / square * speed / self.yield_displacement
        size = math.sqrt(square) * min(state * _FAR, 1.0)
        return Maxwell(float(stiffness), float(stiffness / rate), between=self.between), size * self.yield_force

    @staticmethod
    def arm_state(free: float) -> float:
        """Above 0."""
        return math.exp(free)

    def share_taken(self, reached: float) -> float:
        """That of the time beyond the yield displacement."""
        return math.erfc(math.sqrt(0.5) / reached)

    def line(self, name: str) -> str:
        """The law of its z."""
        return f"z ({name}): z' = x', |z| <= {self.yield_displacement:.6g}"


@dataclass(frozen=True)
class BoucWen(Yielding):
    """The smooth hysteresis of Bouc and Wen: the force k z, with z' = v - r^n (beta sgn(v z) + 1 - beta) v.

    Here r = abs(k z) / F is the share of the yield force.

    Parameters
    ----------
    stiffness : float
        k > 0 in N/m: that of z = 0.
    yield_force : float
        F > 0 in N: the force that is reached in a long stroke.
    exponent : float
        n from 1 to 50: how sharply it yields.  A `Jenkins` is the limit of large n.
    beta : float
        At least 1/2: the share of the term with sgn(v z).  At 1/2 it unloads with the stiffness k, above it with more.

    Raises
    ------
    TypeError, ValueError
        If a number is not one, not finite or out of its range.  With a beta below 1/2 it would feed some motions.

    Notes
    -----
    Let a force be stated as alpha k x + (1 - alpha) k z with z' = A v - b abs(v) abs(z)^(n-1) z - g v abs(z)^n.  It is
    a `Spring` of alpha k beside a BoucWen.  The BoucWen has the stiffness (1 - alpha) k A, the yield force
    (1 - alpha) k (A / (b + g))^(1/n) and beta = b / (b + g).  Small loops within a large one do not close in this
    model: about a mean force it drifts under small vibration, which metals do not.

    References
    ----------
    Y.-K. Wen, "Equivalent linearization for hysteretic systems under random excitation", Journal of Applied Mechanics
    47 (1980).

    Examples
    --------
    >>> BoucWen(stiffness=0.5, yield_force=0.5).line("mount")
    "z (mount): z' = x' - |z| (0.5 sgn(x' z) + 0.5) x'"
    """

    said = "bouc wen"
    doubt = (
        "The parts that yield make x far from Gaussian: under white noise <x^2> and <v^2> came out up to 17 % "
        "too small, most where little stiffness is left."
    )

    exponent: Annotated[float, Number("n", "exponent", "1", "exponent", own=True)] = 1.0
    beta: Annotated[float, Number("β", "beta", "1", "positive", own=True)] = 0.5

    def __post_init__(self) -> None:
        super().__post_init__()
        hint = "It is how sharply the force yields; of more than 50 a Jenkins is the limit."
        put(self, exponent=finite_number(self.exponent, "exponent", low=1.0, high=_MOST, hint=hint))
        hint = "It is b / (b + g) of b |v| |z|^(n-1) z + g v |z|^n; below 1/2 it would feed some motions."
        put(self, beta=finite_number(self.beta, "beta", low=0.5, high=LARGEST, hint=hint))

    def nearest_arm(self, speed: float, state: float) -> tuple[Maxwell, float]:
        """The Maxwell element nearest to it in mean square, and the standard deviation of its force.

        With v and z as Gaussian, z' = c v - d z by the means of the derivatives of its law [1]_.  Since z is
        stationary, the correlation of the two gives the size of z, and is a better unknown: that has a largest value,
        where it is 1.

        Parameters
        ----------
        speed : float
            Standard deviation of v.
        state : float
            The correlation of v and z, in (0, 1).

        References
        ----------
        .. [1] Y.-K. Wen, "Equivalent linearization for hysteretic systems under random excitation", Journal of Applied
           Mechanics 47 (1980); his beta and gamma are exchanged.

        Examples
        --------
        >>> arm, force = BoucWen(0.5, 0.5).nearest_arm(0.66244, 0.3514)  # of the first system of the documentation
        >>> round(arm.stiffness, 3), round(arm.stiffness / arm.coefficient, 3), round(force**2 / 0.25, 3)
        (0.37, 0.357, 0.233)
        """
        from scipy import special  # slow to import

        n, beta, rho = self.exponent, self.beta, state
        size = 2.0 ** (0.5 * n) / math.pi
        even, odd = size * math.gamma(0.5 * n + 1.0), size * math.sqrt(math.pi) * math.gamma(0.5 * (n + 1.0))
        arc = float(special.beta(0.5, 0.5 * (n + 1.0)) * special.betainc(0.5, 0.5 * (n + 1.0), rho * rho))
        slower = beta * even * arc + (1.0 - beta) * odd  # of what r^n takes from c
        faster = (
            beta * even * (2.0 * (1.0 - rho * rho) ** (0.5 * (n + 1.0)) + n * rho * arc) + (1.0 - beta) * n * rho * odd
        )
        power = rho / (faster + rho * slower)
        spread = power ** (1.0 / n)  # of z over its limit
        rate = faster * spread ** (n - 1.0) * speed / self.yield_displacement
        stiffness = self.stiffness * (1.0 - power * slower)
        return Maxwell(float(stiffness), float(stiffness / rate), between=self.between), spread * self.yield_force

    @staticmethod
    def arm_state(free: float) -> float:
        """Between 0 and 1."""
        from scipy import special  # slow to import

        return float(special.expit(free))

    def share_taken(self, reached: float) -> float:
        """It yields a little everywhere."""
        return float(1.0 / (1.0 + reached ** -(self.exponent + 1.0)))

    def line(self, name: str) -> str:
        """The law of its z."""
        ratio = "|z|" if self.yield_displacement == 1.0 else f"|z / {self.yield_displacement:.6g}|"
        power = "" if self.exponent == 1.0 else f"^{self.exponent:g}"
        return f"z ({name}): z' = x' - {ratio}{power} ({self.beta:g} sgn(x' z) + {1.0 - self.beta:g}) x'"


def _density(x: float) -> float:
    """Of a normal variable of unit variance."""
    return math.exp(-0.5 * x * x) / math.sqrt(2.0 * math.pi)
