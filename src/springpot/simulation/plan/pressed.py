"""How finely a step must follow a mass that springs or constant forces press on a lossy wall under white noise.

The mass hops on the wall, and a hop lasts about its speed over the acceleration a that presses.  With a step h too few
kicks share in a hop, and the mean square of the velocity is too low by 12 to 14 % of h a / v_rms (at restitutions of
0.2 by 11 % of its root, about).  The power that the wall takes is right at any step: it is what noise feeds in.
Compared with the Fokker-Planck equation at order 1, restitutions from 0.2 to 0.8.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

MOST_TURNED = 0.1  # h a / v_rms up to which a run does not warn, at restitutions of at least `_SLOW`
_AIMED = 0.8  # of the most, for default steps: v_rms is a guess there
_SLOW = 0.3  # restitution below which the error is larger
_LARGER = 0.3  # there, of the most
_SHARE = 0.13  # of h a / v_rms that is lacking in the mean square of the velocity
_SHARE_SLOW, _POWER_SLOW = 0.11, 0.45


@dataclass(frozen=True)
class Pressed:
    """A lossy wall, and what presses a mass on it.

    Attributes
    ----------
    acceleration : float
        With which springs and constant forces press the mass on the wall, in m/s^2.
    restitution : float
    """

    acceleration: float
    restitution: float

    @property
    def most_turned(self) -> float:
        """The largest h a / v_rms that gives no warning."""
        return MOST_TURNED if self.restitution >= _SLOW else _LARGER * MOST_TURNED

    def turned(self, step: float, speed: float) -> float:
        """h a / v_rms."""
        return step * self.acceleration / speed

    def lacking(self, step: float, speed: float) -> float:
        """Share of the mean square of the velocity that a step loses.

        Examples
        --------
        >>> round(Pressed(9.81, 0.5).lacking(0.005, 0.0624), 3)
        0.102
        """
        turned = self.turned(step, speed)
        return _SHARE * turned if self.restitution >= _SLOW else _SHARE_SLOW * math.pow(turned, _POWER_SLOW)

    def speed(self, fed: float, damping: float) -> float:
        """v_rms, about, at which walls and dampers together take a power per unit mass.

        The wall takes (1 - r^2) a v_rms / 2, within a tenth for restitutions from 0.2 to 0.8.

        Examples
        --------
        >>> round(Pressed(9.81, 0.5).speed(0.25, 0.1), 3)  # it is 0.0624
        0.068
        """
        taken = 0.5 * (1.0 - self.restitution**2) * self.acceleration
        return 2.0 * fed / (taken + math.sqrt(taken * taken + 4.0 * damping * fed))

    def rate(self, speed: float, default_step: float) -> float:
        """The rate, in 1/s, of which a default step is this part, where v_rms is a guess."""
        return default_step * self.acceleration / (_AIMED * self.most_turned * speed)
