"""Some 340 systems drawn with a fixed seed, of a few kinds: what `benchmarks.compare_versions` simulates.

Within a kind only numbers differ, since a version may compile code for each kind of system.  Lengths, steps and windows
are stated, so that no default matters; the steps are so short that the error of any second-order scheme is below the
sampling error.  Where a mass rests on a lossy wall, as under smooth forces, older versions had errors of first order in
the step: such walls are elastic here, but for one kind.  Nothing but the public names of springpot is used, so that
older versions can run this file too.
"""

from __future__ import annotations

import hashlib
import inspect
import json
import math
import random
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import springpot as sp

__all__ = ["EACH", "KINDS", "OWNERS", "Case", "cases"]

EACH = 10  # systems of each kind
OWNERS = {
    *"abcd", "stop", "other", "mount", "arm", "circuit", "yielding", "damper", "noise", "pulses", "tone", "ground",
    "own", "hardening", "cubic", "mass", "x",
}  # fmt: skip
"""Names of points, parts and quantities before the kind of a result, as in ``stop_impact_rate`` and ``a_x_mean``."""
_SPECTRUM = (0.5, 1.0, 2.5)  # rad/s


@dataclass(frozen=True)
class Case:
    """A system, how it is run and what is asked.

    Parameters
    ----------
    name : str
        Its kind and its number.
    system : springpot.System
    given : dict
        Arguments of `springpot.simulate`; with ``levels``, those of `springpot.exceedance`.
    digest : str
        Of the numbers drawn and the source of its kind: of the same problem the same in every version.
    """

    name: str
    system: Any
    given: dict[str, Any]
    digest: str

    @property
    def kind(self) -> str:
        """Of its system."""
        return self.name.rpartition(" ")[0]


@dataclass(frozen=True)
class Draw:
    """Random numbers of one system, kept for its digest."""

    source: random.Random
    drawn: list[float] = field(default_factory=list)

    def between(self, low: float, high: float) -> float:
        """Uniform, with four digits."""
        self.drawn.append(float(f"{low + (high - low) * self.source.random():.4g}"))
        return self.drawn[-1]

    def one_of(self, *values: float) -> float:
        """Any of these."""
        self.drawn.append(values[int(self.source.random() * len(values))])
        return self.drawn[-1]

    def mount(self, **ends: Any) -> dict[str, Any]:
        """A spring, a springpot and a dashpot, with one or two units of force per displacement and light damping."""
        stiffness, order = self.between(0.7, 2.0), self.between(0.12, 0.95)
        whole, share = self.between(0.15, 0.6), self.between(0.1, 0.5)
        rate = math.sqrt(stiffness)
        pot = (1.0 - share) * whole * rate ** (1.0 - order) / math.sin(0.5 * math.pi * order)
        return {
            "spring": sp.Spring(stiffness, **ends), "mount": sp.Springpot(order, float(f"{pot:.4g}"), **ends),
            "dashpot": sp.Dashpot(float(f"{share * whole:.4g}"), **ends),
        }  # fmt: skip

    def white(self, on: str = "mass") -> Any:
        """White noise that moves such a mount by about 1."""
        return sp.WhiteNoise(self.between(0.4, 1.2), on)

    def below(self, low: float = -1.2, high: float = 0.0) -> float:
        """The position of a stop below the mass."""
        return self.between(low, high)

    def restitution(self) -> float:
        """Of a lossy or an elastic wall."""
        return self.one_of(1.0, self.between(0.5, 0.95))


# --- functions of a user ------------------------------------------------------------------------------------------


def softer(t: float, x: float, v: float) -> float:
    """A force."""
    return -0.3 * math.sin(x) - 0.1 * v * math.fabs(v) + 0.1 * math.cos(0.7 * t)


def pull(t: float, x: float, v: float) -> float:
    """A force between two masses."""
    return -0.3 * math.tanh(2.0 * x)


def falling(speed: float) -> float:
    """A restitution."""
    return 1.0 / (1.0 + 0.3 * speed)


def product(t: float, x: float, v: float) -> float:
    """An observable."""
    return x * x * v * v


def cube(speed: float) -> float:
    """An observable of an impact."""
    return speed**3


# --- one mass -----------------------------------------------------------------------------------------------------

Drawn = tuple[dict[str, Any], dict[str, Any]]


def free(d: Draw) -> Drawn:
    """No wall: spectra, distributions, and a start that pilot runs find."""
    return {**d.mount(), "noise": d.white()}, {"spectrum": _SPECTRUM, "distributions": True, "start": "stationary"}


def held_by_arms(d: Draw) -> Drawn:
    """Springpots of two orders, Maxwell arms with a dashpot and with a springpot; recorded paths."""
    soft, spring = sp.Springpot(d.between(0.3, 0.8), d.between(0.3, 1.0)), sp.Spring(d.between(0.5, 2.0))
    arms = {"arm": sp.Maxwell(d.between(0.3, 2.0), d.between(0.3, 2.0)), "other": sp.FractionalMaxwell(soft, spring)}
    return {**d.mount(), **arms, "noise": d.white()}, {"record": 64, "record_every": 40, "forces": ["force_on_ground"]}


def from_a_position(d: Draw) -> Drawn:
    """Riemann-Liouville's derivative, from a displacement: a profile."""
    given = {"derivative": "riemann-liouville", "initial_position": d.between(0.5, 2.0)}
    parts = {"spring": sp.Spring(d.between(0.7, 2.0)), "mount": sp.Springpot(d.between(0.2, 0.9), d.between(0.2, 0.8))}
    return {**parts, "noise": d.white()}, {**given, "profile": 3, "duration": 30.0, "window": (0.0, 30.0)}


def printed_scheme(d: Draw) -> Drawn:
    """The paper's own scheme, with a wall."""
    parts = {"spring": sp.Spring(d.between(0.7, 2.0)), "mount": sp.Springpot(d.between(0.2, 0.9), d.between(0.2, 0.8))}
    given = {"scheme": "grunwald", "paths": 2048, "duration": 15.0, "step": 0.005, "window": (0.0, 15.0)}
    return {**parts, "stop": sp.Barrier(d.below(), 0.8), "noise": d.white()}, given


def wall(d: Draw) -> Drawn:
    """A wall below or above, with a gap."""
    where = d.below()
    side = {"free_side": "below"} if d.one_of(0.0, 1.0) else {"free_side": "above"}
    stop = sp.Barrier(-where if side["free_side"] == "below" else where, d.restitution(), **side)
    given = {"first_passage": {"x": [-2.5 if side["free_side"] == "below" else 2.5]}, "distributions": True}
    return {**d.mount(), "stop": stop, "noise": d.white()}, {**given, "forces": ["stop_impulse"]}


def preload(d: Draw) -> Drawn:
    """Order 1, and the wall presses the mass."""
    stop = sp.Barrier(d.between(0.0, 0.8), d.one_of(1.0, 0.95, 0.9), free_side="above")
    parts = {"spring": sp.Spring(d.between(0.7, 2.0)), "dashpot": sp.Dashpot(d.between(0.1, 0.6)), "stop": stop}
    return {**parts, "noise": d.white()}, {"profile": 4, "slowest_counted_impact": 0.4, "step": 0.01}


def two_walls(d: Draw) -> Drawn:
    """Two walls and a cubic spring; observables."""
    walls = {"stop": sp.Barrier(d.below(-1.2, -0.3), d.restitution()), "other": sp.Barrier(d.between(0.3, 1.5), 0.8)}
    hard = sp.PolynomialSpring((0.0, 0.0, d.between(0.1, 1.0)))
    given = {"observables": {"product": product}, "impact_observables": {"cube": cube}}
    return {**d.mount(), "hardening": hard, **walls, "noise": d.white()}, given


def power_law(d: Draw) -> Drawn:
    """A restitution that falls with the speed; impacts above a speed are counted."""
    law = sp.PowerRestitution(d.between(0.5, 0.9), d.between(0.5, 1.5), d.between(0.05, 0.25))
    stop = sp.Barrier(d.below(), law)
    return {**d.mount(), "stop": stop, "noise": d.white()}, {"slowest_counted_impact": 0.4}


def own_law(d: Draw) -> Drawn:
    """A restitution of the user's."""
    return {**d.mount(), "stop": sp.Barrier(d.below(), falling), "noise": d.white()}, {"slowest_counted_impact": 0.4}


def hertz(d: Draw) -> Drawn:
    """A contact of Hertz with dissipation; its forces."""
    stop = sp.Contact(d.below(), d.between(20.0, 300.0), d.one_of(1.5, 2.0), d.between(0.0, 0.3))
    return {**d.mount(), "stop": stop, "noise": d.white()}, {"forces": ["stop_force", "stop_peak_force"]}


def linear_contact(d: Draw) -> Drawn:
    """A linear contact above and a wall below, with a weight; distributions of a force."""
    stop = sp.Contact(d.between(0.2, 1.2), d.between(20.0, 200.0), 1.0, free_side="below")
    parts = {"stop": stop, "other": sp.Barrier(d.below(-2.0, -0.8), 0.8), "weight": sp.Constant(d.between(-0.4, 0.4))}
    return {**d.mount(), **parts, "noise": d.white()}, {"forces": ["mount_force"], "distributions": True}


def ninth_power(d: Draw) -> Drawn:
    """A spring of the ninth power, and friction."""
    hard = sp.PolynomialSpring((0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, d.between(0.001, 0.02)))
    friction = sp.Friction(d.between(0.05, 0.3))
    return {**d.mount(), "hardening": hard, "damper": friction, "noise": d.white()}, {"forces": ["hardening_force"]}


def nonlinear_damper(d: Draw) -> Drawn:
    """A cubic damper, and a softening and a hardening power of the spring."""
    hard = sp.PolynomialSpring((0.0, d.between(-0.1, 0.1), d.between(0.1, 0.5)))
    damper = sp.PolynomialDashpot((0.0, d.between(0.0, 0.2), d.between(0.05, 0.3)))
    return {**d.mount(), "hardening": hard, "damper": damper, "noise": d.white()}, {"spectrum": _SPECTRUM}


def van_der_pol(d: Draw) -> Drawn:
    """A damper that feeds small motions, and a wall."""
    stop, damper = sp.Barrier(d.below(-1.5, -0.5), 0.8), sp.VanDerPol(d.between(0.1, 0.5), d.between(0.7, 1.3))
    return {**d.mount(), "stop": stop, "damper": damper, "noise": d.white()}, {}


def jenkins(d: Draw) -> Drawn:
    """Parts that yield; rainflow."""
    part = sp.Jenkins(d.between(0.5, 1.5), d.between(0.2, 0.8))
    curves = {"x": sp.Basquin(4.0), "yielding_force": sp.Basquin(3.0)}
    return {**d.mount(), "yielding": part, "noise": d.white()}, {"rainflow": curves}


def bouc_wen(d: Draw) -> Drawn:
    """Parts that yield smoothly, and a wall; a profile from rest."""
    part = sp.BoucWen(d.between(0.5, 1.5), d.between(0.2, 0.8), d.one_of(1.0, 2.0), d.between(0.5, 0.8))
    parts = {**d.mount(), "yielding": part, "stop": sp.Barrier(d.below(-1.0, -0.2), 0.8), "noise": d.white()}
    return parts, {"profile": 3, "duration": 30.0, "window": (0.0, 30.0)}


def circuit(d: Draw) -> Drawn:
    """A circuit without a coil, and a wall."""
    part = sp.PiezoelectricCircuit(d.between(0.3, 0.9), d.between(0.5, 5.0), d.between(0.5, 2.0))
    return {**d.mount(), "circuit": part, "stop": sp.Barrier(d.below(), 0.8), "noise": d.white()}, {}


def coil(d: Draw) -> Drawn:
    """A circuit with a coil, under coloured noise."""
    part = sp.ResonantCircuit(d.between(0.3, 0.6), d.between(0.2, 2.0), d.between(0.8, 2.0), d.between(0.3, 2.0))
    noise = sp.ColoredNoise(d.between(0.5, 2.0), d.between(0.2, 1.5))
    return {**d.mount(), "circuit": part, "noise": noise}, {"forces": ["acceleration"]}


def earthquake(d: Draw) -> Drawn:
    """A shaped noise of the ground with an envelope; first passages.  On a lossy wall the mass rests: rates are NaN."""
    over = sp.JenningsHousnerEnvelope(d.between(3.0, 6.0), d.between(8.0, 14.0), d.between(0.1, 0.4))
    ground = sp.KanaiTajimiNoise(d.between(1.5, 4.0), d.between(0.3, 0.7), d.between(0.2, 0.8), envelope=over)
    given: dict[str, Any] = {"first_passage": {"x": [1.0, 2.0]}, "duration": 24.0, "window": (0.0, 24.0)}
    restitution = d.one_of(1.0, 0.7)
    if restitution == 1.0:
        given["profile"] = 3
    return {**d.mount(), "stop": sp.Barrier(d.below(-0.8, -0.2), restitution), "ground": ground}, given


def spectral(d: Draw) -> Drawn:
    """A noise of a given spectral density, and an elastic wall."""
    band = (0.02, 0.1, 0.3, 0.6)  # Hz
    noise = sp.SpectralExcitation(band, (0.2, d.between(1.0, 4.0), d.between(1.0, 4.0), 0.3), on="mass")
    return {**d.mount(), "stop": sp.Barrier(d.below(), 1.0), "noise": noise}, {}


def impulses(d: Draw) -> Drawn:
    """Impulses, a harmonic force and noise that multiplies the displacement."""
    parts = {
        "pulses": sp.PoissonImpulses(d.between(0.5, 3.0), d.between(0.1, 0.5)),
        "tone": sp.Harmonic(d.between(0.2, 1.0), d.between(0.5, 1.5)), "shaken": sp.ParametricNoise(0.05),
    }  # fmt: skip
    return {**d.mount(), **parts}, {"spectrum": _SPECTRUM}


def recorded(d: Draw) -> Drawn:
    """A record of the ground's acceleration, white noise beside it, and a wall."""
    times, rate = tuple(0.25 * n for n in range(161)), d.between(0.7, 1.3)
    values = tuple(round(math.sin(rate * t) * math.exp(-0.05 * t), 4) for t in times)
    ground, stop = sp.RecordedExcitation(times, values, "ground"), sp.Barrier(d.below(-1.0, -0.2), 0.8)
    given = {"duration": 40.0, "window": (0.0, 40.0), "profile": 4}
    return {**d.mount(), "stop": stop, "ground": ground, "noise": d.white()}, given


def thermal(d: Draw) -> Drawn:
    """The noise of all dissipators, and two elastic walls; from Boltzmann's law."""
    walls = {"stop": sp.Barrier(d.below(-1.5, -0.3)), "other": sp.Barrier(d.between(0.5, 1.5))}
    return {**d.mount(), **walls, "noise": sp.ThermalNoise(d.between(0.5, 1.5))}, {"start": "stationary"}


def own_force(d: Draw) -> Drawn:
    """A force of the user's, in SI units, on equal mounts."""
    parts = {"mass": sp.Mass(d.between(0.5, 2.0)), "own": sp.Force(softer, d.between(0.5, 1.5))}
    return {**parts, **d.mount(), "noise": d.white()}, {"forces": ["force_on_ground"]}


def rare(d: Draw) -> Drawn:
    """Probabilities by splitting, with a wall."""
    parts = {
        "spring": sp.Spring(d.between(0.9, 1.2)), "mount": sp.Springpot(d.between(0.4, 0.9), 0.3),
        "stop": sp.Barrier(d.below(-1.0, 0.0), 0.8), "noise": sp.WhiteNoise(d.between(0.5, 0.7)),
    }  # fmt: skip
    return parts, {"levels": {"x": [3.0, 4.0]}, "duration": 15.0, "step": 0.05, "rtol": 0.05}


# --- several masses -----------------------------------------------------------------------------------------------


def _row(d: Draw, points: str) -> dict[str, Any]:
    """Masses in a row from the ground, a mount from each to the next; the names of its parts end with its number."""
    parts: dict[str, Any] = {f"mass_{point}": sp.Mass(d.between(0.6, 1.4), at=point) for point in points}
    for ends in pairwise(("ground", *points)):
        own = d.mount(between=ends)
        parts |= {f"{name}_{ends[1]}" if ends[1] != points[-1] else name: part for name, part in own.items()}
    return parts


def two_masses(d: Draw) -> Drawn:
    """Two walls, one between the masses; distributions and spectra."""
    walls = {
        "stop": sp.Barrier(d.below(-1.0, -0.2), d.restitution(), between=("a", "b")),
        "other": sp.Barrier(d.below(-1.5, -0.3), d.restitution(), between=("ground", "a")),
    }
    given = {"distributions": True, "spectrum": _SPECTRUM, "forces": ["stop_impulse", "mount_force"]}
    return {**_row(d, "ab"), **walls, "noise_a": d.white("a"), "noise": d.white("b")}, given


def on_the_ground(d: Draw) -> Drawn:
    """Three masses, a wall, a cubic spring, white and coloured noise of the ground; rainflow and first passage."""
    parts = {
        "stop": sp.Barrier(d.below(-1.0, -0.2), between=("a", "b")),
        "hardening": sp.PolynomialSpring((0.0, 0.0, d.between(0.1, 0.5)), between=("b", "c")),
        "ground": sp.WhiteNoise(d.between(0.1, 0.4), "ground"),
        "noise": sp.ColoredNoise(d.between(0.2, 1.0), d.between(0.2, 1.0), "ground"),
    }
    given = {"rainflow": {"c_x": sp.Basquin(4.0)}, "first_passage": {"c_x": [2.0]}}
    return {**_row(d, "abc"), **parts}, given


def contacts_and_friction(d: Draw) -> Drawn:
    """Two masses with a contact of Hertz, friction and a part that yields."""
    parts = {
        "stop": sp.Contact(d.below(-0.8, 0.0), d.between(20.0, 200.0), 1.5, d.between(0.0, 0.2), between=("a", "b")),
        "damper": sp.Friction(d.between(0.05, 0.3), between=("ground", "a")),
        "yielding": sp.Jenkins(d.between(0.3, 1.0), d.between(0.2, 0.6), between=("a", "b")),
    }
    given = {"forces": ["stop_peak_force", "yielding_force"]}
    return {**_row(d, "ab"), **parts, "noise_a": d.white("a"), "noise": d.white("b")}, given


def four_masses(d: Draw) -> Drawn:
    """Four masses with circuits, an arm, two walls, white noise and a harmonic force; a profile and recorded paths."""
    parts = {
        "circuit": sp.PiezoelectricCircuit(d.between(0.3, 0.8), d.between(0.5, 3.0), 1.0, between=("a", "b")),
        "arm": sp.Maxwell(d.between(0.3, 1.5), d.between(0.3, 1.5), between=("c", "d")),
        "stop": sp.Barrier(d.below(-1.0, -0.2), d.restitution(), between=("b", "c")),
        "other": sp.Barrier(d.between(0.5, 1.5), 0.8, between=("ground", "a")),
        "tone": sp.Harmonic(d.between(0.2, 0.8), d.between(0.4, 1.2), "d"),
    }
    noises = {f"noise_{point}": d.white(point) for point in "abcd"}
    return {**_row(d, "abcd"), **parts, **noises}, {"profile": 2, "record": 64, "record_every": 40}


def pushed_apart(d: Draw) -> Drawn:
    """Two masses with a force of the user's, a restitution that falls, and a wall."""
    law = sp.PowerRestitution(d.between(0.5, 0.9), d.between(0.5, 1.5), 0.25)
    parts = {
        "own": sp.Force(pull, d.between(0.5, 1.5), between=("a", "b")),
        "stop": sp.Barrier(d.below(-1.0, -0.2), law, between=("a", "b")), "noise": d.white("b"),
    }  # fmt: skip
    return {**_row(d, "ab"), **parts}, {"slowest_counted_impact": 0.4}


def other_sources(d: Draw) -> Drawn:
    """Three masses under shaped noise of the ground, impulses, a spectral density and noise of a stiffness."""
    parts = {
        "ground": sp.KanaiTajimiNoise(d.between(1.5, 4.0), d.between(0.3, 0.7), d.between(0.1, 0.4)),
        "pulses": sp.PoissonImpulses(d.between(0.5, 3.0), d.between(0.1, 0.5), "b"),
        "noise": sp.SpectralExcitation((0.02, 0.1, 0.3, 0.6), (0.2, d.between(1.0, 3.0), 1.0, 0.3), on="c"),
        "shaken": sp.ParametricNoise(0.03, between=("a", "b")),
        "stop": sp.Barrier(d.below(-1.0, -0.2), 1.0, between=("b", "c")),
    }  # fmt: skip
    return {**_row(d, "abc"), **parts}, {"spectrum": _SPECTRUM}


def other_dampers(d: Draw) -> Drawn:
    """Two masses with a part that yields smoothly, Van der Pol's and a cubic damper, a coil and a linear contact."""
    parts = {
        "yielding": sp.BoucWen(d.between(0.3, 1.0), d.between(0.2, 0.6), d.one_of(1.0, 2.0), between=("a", "b")),
        "damper": sp.VanDerPol(d.between(0.05, 0.3), d.between(0.7, 1.3), between=("ground", "a")),
        "cubic": sp.PolynomialDashpot((0.0, d.between(0.0, 0.2), d.between(0.05, 0.3)), between=("a", "b")),
        "circuit": sp.ResonantCircuit(d.between(0.3, 0.5), d.between(0.5, 2.0), 1.0, 1.0, between=("a", "b")),
        "stop": sp.Contact(d.below(-0.8, 0.0), d.between(20.0, 150.0), 1.0, between=("ground", "a")),
    }
    return {**_row(d, "ab"), **parts, "noise_a": d.white("a"), "noise": d.white("b")}, {"forces": ["yielding_force"]}


def one_temperature(d: Draw) -> Drawn:
    """Two masses with the noise of all dissipators, an elastic wall and a cubic spring; from Boltzmann's law."""
    parts = {
        "stop": sp.Barrier(d.below(-1.0, -0.2), between=("a", "b")),
        "hardening": sp.PolynomialSpring((0.0, 0.0, d.between(0.1, 0.5)), between=("ground", "a")),
        "noise": sp.ThermalNoise(d.between(0.5, 1.5)),
    }
    return {**_row(d, "ab"), **parts}, {"distributions": True}


def rare_between_masses(d: Draw) -> Drawn:
    """Probabilities by splitting, of two masses with a wall."""
    parts: dict[str, Any] = {"mass_a": sp.Mass(1.0, at="a"), "mass_b": sp.Mass(1.0, at="b")}
    for at, ends in {"a": ("ground", "a"), "b": ("a", "b")}.items():
        spring, pot = sp.Spring(d.between(0.9, 1.2), between=ends), sp.Springpot(d.between(0.4, 0.9), 0.3, between=ends)
        parts |= {f"spring_{at}": spring, f"mount_{at}": pot}
    parts |= {"stop": sp.Barrier(d.below(-1.0, -0.2), 0.8, between=("a", "b")), "noise": d.white("b")}
    return parts, {"levels": {"b_x": [4.0, 6.0]}, "duration": 15.0, "step": 0.05, "rtol": 0.05}


KINDS: tuple[Callable[[Draw], Drawn], ...] = (
    free, held_by_arms, from_a_position, printed_scheme, wall, preload, two_walls, power_law, own_law, hertz,
    linear_contact, ninth_power, nonlinear_damper, van_der_pol, jenkins, bouc_wen, circuit, coil, earthquake, spectral,
    impulses, recorded, thermal, own_force, rare,
    two_masses, on_the_ground, contacts_and_friction, four_masses, pushed_apart, other_sources, other_dampers,
    one_temperature, rare_between_masses,
)  # fmt: skip
_OF_ONE, _OF_SEVERAL = 16_384, 8_192  # paths
_RUN = {"duration": 80.0, "step": 0.02, "window": (40.0, 80.0), "start": "rest"}


def cases(each: int = EACH) -> Iterator[Case]:
    """All of them, kind by kind."""
    for kind in KINDS:
        words = inspect.getsource(kind) + inspect.getsource(Draw)
        for number in range(1, each + 1):
            name = f"{kind.__name__} {number}"
            draw = Draw(random.Random(name))
            parts, asked = kind(draw)
            system = sp.System(**parts)
            paths = _OF_ONE if len(system.points) == 1 else _OF_SEVERAL
            given = {"start": "rest", **asked} if "levels" in asked else {"paths": paths, **_RUN, **asked}
            digest = hashlib.sha256((words + json.dumps(draw.drawn)).encode()).hexdigest()[:12]
            yield Case(name, system, given, digest)
