"""Every quantity of a result, once: its name, unit, meaning and formula, when there is one, and what `rtol` controls.

Runs, data sets, columns of studies, the page and the docs read it; and a system that is being made, so that no two of
its parts, masses and pairs have results of the same name.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache, cached_property
from itertools import chain
from typing import Any, Protocol

from springpot.problem.coordinates import Coordinates
from springpot.problem.parts.registration import Part, per_unit_mass, unit_times

_OF = "<part>_"
_AT = "<point>_"
_PAIRS = "<pair>_"
_ANY = "<quantity>_"
_LEVEL = "<level>_"
_OWNERS = _OF, _AT, _PAIRS, _ANY, _LEVEL
_MOST_CURVES = 9
_WHOLE, _WALLS = "the whole system", "barrier"


class System(Protocol):
    """What names are made of: a `springpot.System`, also while it is being made."""

    @property
    def parts(self) -> tuple[Any, ...]:
        """All parts."""

    @property
    def points(self) -> tuple[str, ...]:
        """The names of its masses and other points."""

    @property
    def coordinates(self) -> Coordinates:
        """With the names of the masses, and the ends of parts."""

    @property
    def has_mass(self) -> bool:
        """Whether its numbers are in SI units."""

    @property
    def groups(self) -> Mapping[str, tuple[str, ...]]:
        """The parts of each group."""

    @property
    def counts(self) -> Mapping[str, int]:
        """How many equal ones there are, of parts and groups of which there are several."""

    @property
    def thermal(self) -> Part | None:
        """The noise of all that dissipates."""

    def stated(self) -> Iterator[tuple[str, Any]]:
        """Each part with its name."""


@dataclass(frozen=True)
class Quantity:
    """One entry of the catalogue.

    Attributes
    ----------
    name : str
        Of a part it begins with ``<part>_``, which stands for the part's name, of one of several masses with
        ``<point>_``, and of two masses with a part between them with ``<pair>_``; of any displacement, elongation,
        force or acceleration with ``<quantity>_``, and of what can pass a level with ``<level>_``.
    unit : str
        In a system with a `Mass`; without one it is per unit mass where newtons, joules or watts are in it.  ``q``
        stands for that of the quantity.
    meaning, formula : str
        In words, and in TeX.
    when : str
        When there is one, in words; with which option of `springpot.simulate`.
    of : callable
        Whether a part has it, or is what gives it to the system.
    where : callable
        Whether a system of such parts can have it.
    controlled : bool
        Whether ``rtol`` controls its error.
    option : str
        Argument of `springpot.simulate` without which a run does not have it; empty where every run has it.
    dimensions : tuple of str
        In the data set of `springpot.simulate`.
    numbered : bool
        Whether there may be several, with the endings ``_1``, ``_2`` and so on.
    of_groups : callable
        The groups of a system that have it, as parts have.
    """

    name: str
    unit: str
    meaning: str
    formula: str = ""
    when: str = "always"
    of: Callable[[Part], bool] = lambda part: True
    where: Callable[[System], bool] = lambda system: True
    controlled: bool = True
    option: str = ""
    dimensions: tuple[str, ...] = ()
    numbered: bool = False
    of_groups: Callable[[System], Iterable[str]] = lambda system: ()

    def names(self, system: System) -> Iterator[str]:
        """Its names in the results of a system, whatever the system's numbers are."""
        return (name for name, _ in self.owned(system))

    def owned(self, system: System) -> Iterator[tuple[str, str]]:
        """The same, each with the words for what has it: a part, a mass, a pair of them or the whole."""
        if not self.where(system):
            return
        stem, ending = self.split
        owners: Iterable[tuple[str, str]] = ()
        if stem == _OF:
            parts = ((name, f"the part {name}") for name, part in system.stated() if self.of(part))
            owners = chain(parts, ((group, f"the group {group}") for group in self.of_groups(system)))
        elif stem == _AT:
            owners = _points(system)
        elif stem == _PAIRS:
            owners = _pairs(system)
        elif stem:
            owners = asked_for(system, levels=stem == _LEVEL)
        elif any(map(self.of, system.parts)):
            yield self.name, _WHOLE
        for name, owner in owners:
            whole = f"{name}_{ending}".removesuffix("_")
            yield from ((each, owner) for each in (whole, *(f"{whole}_{n}" for n in self.numbers)))

    @cached_property
    def split(self) -> tuple[str, str]:
        """For what its name begins with the name of, and the rest of it."""
        stem = next((stem for stem in _OWNERS if self.name.startswith(stem)), "")
        return stem, self.name.removeprefix(stem)

    @property
    def numbers(self) -> range:
        """Of several."""
        return range(1, _MOST_CURVES + 1) if self.numbered else range(0)


def _points(system: System) -> Iterator[tuple[str, str]]:
    masses = system.coordinates.names
    yield from ((point, f"the {'mass' if point in masses else 'point'} {point}") for point in system.points)


def _pairs(system: System) -> Iterator[tuple[str, str]]:
    yield from (("_".join(pair), f"the pair {pair[0]}, {pair[1]}") for pair in system.coordinates.linked)


def asked_for(system: System, levels: bool = True) -> Iterator[tuple[str, str]]:
    """What a user names to see it, with the words for what has it: displacements, elongations, forces, accelerations.

    With ``levels`` also what is asked for by its levels alone, as sizes, velocities and speeds.
    """
    moving = (entry for entry in ASKED if levels or entry.name.endswith(_MOVING))
    forces = (entry for entry in CATALOGUE if entry.name in {output[0] for output in _OUTPUTS})
    return chain.from_iterable(entry.owned(system) for entry in (*moving, *forces))


def _on_request(option: str, more: str = "") -> dict[str, Any]:
    return {"option": option, "when": f"`{option}=`{more}", "controlled": False}


def _with(*powers: str) -> Callable[[Part], bool]:
    return lambda part: not {*powers}.isdisjoint(part.powers)


def _balances(system: System) -> bool:
    """Whether the balance of energy is a check, and no definition of what is fed in."""
    independent = any(map(_with("input"), system.parts)) or (_is_several(system) and system.thermal is not None)
    return independent or not any(map(_with("fed", "work"), system.parts))


def _is_single(system: System) -> bool:
    return len(system.points) == 1


def _always(_: System | Part) -> bool:
    return True


def _is_several(system: System) -> bool:
    return len(system.points) > 1


def _has_spring(part: Part) -> bool:
    return "stored" in part.powers and part.has_ends


def _has_coil(part: Part) -> bool:
    return part.of_load == "current"


def _is_soft(part: Part) -> bool:
    return part.soft_stop is not None


def _has_force(part: Part) -> bool:
    return _has_spring(part) or "damping" in part.powers or part.remembers or _is_soft(part)


def _is_counted(part: Part) -> bool:
    return part.has_ends and part.together is not part and _has_force(part)


_ABSOLUTE = "absolute acceleration, that of the ground included, between impacts"
_SPRINGS: dict[str, Any] = {"when": "with springs and one mass", "of": _has_spring}
_STOPS: dict[str, Any] = {"when": "with walls or contacts and one mass", "of": _with("stop"), "where": _is_single}
_STOP: dict[str, Any] = {"when": "of each wall and contact", "of": _with("stop"), "dimensions": ("barrier",)}
_DAMPING: dict[str, Any] = {
    "when": "with dashpots, arms, circuits or springpots of an order above 0", "of": _with("damping"),
}  # fmt: skip
_DAMPING_OF_ONE: dict[str, Any] = {
    **_DAMPING, "when": f"{_DAMPING['when']}, and one mass", "where": _is_single, "controlled": False,
}  # fmt: skip
_CIRCUITS: dict[str, Any] = {"of": lambda part: bool(part.of_load), "where": lambda system: system.thermal is None}
_SOFT: dict[str, Any] = {"when": "with soft contacts and one mass", "of": _is_soft, "where": _is_single}
_SINGLE: dict[str, Any] = {"when": "with one mass", "where": _is_single}
_END: dict[str, Any] = {**_SINGLE, "controlled": False}
_SEVERAL: dict[str, Any] = {"when": "of each of several masses", "where": _is_several}
_PAIR: dict[str, Any] = {"when": "of each two masses with a part between them", "where": _is_several}
_END_OF_SEVERAL: dict[str, Any] = {**_SEVERAL, "controlled": False}
_OF_SEVERAL = {
    "<point>": ", of each of several masses", "<pair>": ", of each two of them with a part between them",
    "<part>": ", of each wall, with several masses",
}  # fmt: skip
_MOMENTS = (
    ("x_mean", "m", "mean displacement", r"\langle x\rangle"),
    ("x_mean_square", "m2", "mean square displacement", r"\langle x^2\rangle"),
    ("v_mean_square", "m2 s-2", "mean square velocity", r"\langle v^2\rangle"),
)


def _moments(of_each: str = "") -> Iterator[Quantity]:
    """Of the displacement and the velocity, of one mass or of each."""
    words = " of the mass" if of_each else ""
    for name, unit, said, formula in _MOMENTS:
        own = re.sub("[xv]", r"\g<0>_i", formula) if of_each else formula
        yield Quantity(f"{of_each}{name}", unit, said + words, own, **(_SEVERAL if of_each else _SINGLE))


def _moments_at_end(of_each: str = "") -> Iterator[Quantity]:
    for entry in _moments(of_each):
        words, given = f"{entry.meaning} at the end of the run", _END_OF_SEVERAL if of_each else _END
        yield Quantity(f"{entry.name}_end", entry.unit, words, **given)


def _asked_of(name: str, option: str, more: str = "") -> dict[str, Any]:
    """When there is a result that is asked for: of one mass, or of each of several masses, pairs or walls."""
    several = _OF_SEVERAL.get(name.partition("_")[0], "")
    return {"where": _is_several if several else _is_single, **_on_request(option, more + several)}


def _distribution(name: str, unit: str, said: str) -> tuple[Quantity, Quantity]:
    """Its density and its quantiles."""
    given = {"of": _owner(name), **_asked_of(name, "distributions")}
    return (
        Quantity(f"{name}_density", unit_times("1", unit, -1), f"probability density of {said} in the window",
                 dimensions=(f"{name}_bin",), **given),
        Quantity(f"{name}_quantile", unit, f"quantiles of {said} in the window", dimensions=("probability",), **given),
    )  # fmt: skip


def _extreme(name: str, unit: str, said: str) -> Quantity:
    paths = "paths with an impact" if "impact" in name else "paths"
    return Quantity(
        f"{name}_quantile", unit, f"quantiles over the {paths} of {said} in the window",
        dimensions=("probability",), of=_owner(name), **_asked_of(name, "distributions"),
    )  # fmt: skip


def _profile(of: str, unit: str, said: str, **more: Any) -> Quantity:
    given = _asked_of(of, "profile", " with `slowest_counted_impact=`" * ("counted" in of))
    return Quantity(
        f"{of}_profile", unit, f"{said} in each bin of time", dimensions=("time_bin",),
        of=_with("stop") if "impact" in of else _always, **given | more,
    )  # fmt: skip


def _owner(name: str) -> Callable[[Part], bool]:
    """Walls of the results of each wall; otherwise any part."""
    return _with("stop") if name.startswith(_OF) else _always


_OUTPUTS = (
    (f"{_OF}force", "N", "N2", "force of the part, or of the group", "", _always),
    (f"{_OF}force_of_one", "N", "N2", "force of one of several equal parts", ", with `count=`", _always),
    ("force_on_ground", "N", "N2", "force of all parts on the ground, without impacts", "", _always),
    ("acceleration", "m s-2", "m2 s-4", _ABSOLUTE, "", _is_single),
    (f"{_AT}acceleration", "m s-2", "m2 s-4", _ABSOLUTE, _OF_SEVERAL["<point>"], _is_several),
)  # fmt: skip


def _of_output(
    name: str, unit: str, square: str, said: str, when: str, where: Callable[[System], bool]
) -> Iterator[Quantity]:
    """Of a force or an acceleration: moments, and with other options extremes and spectrum."""
    has = _is_counted if name.endswith("_of_one") else _has_force
    asked, of_part = f"`forces=`{when}", name == f"{_OF}force"
    given: dict[str, Any] = {"of": has, "where": where, "option": "forces"}
    if name.startswith(_OF):
        given["of_groups"] = lambda system: [one for one in system.groups if of_part or one in system.counts]
    # the mean force of a stop is in every run, and ``rtol`` controls its error
    mean: dict[str, Any] = {**given, "of": lambda part: has(part) and not (of_part and _is_soft(part))}
    yield Quantity(f"{name}_mean", unit, f"mean {said}", when=asked, controlled=of_part, **mean)
    yield Quantity(f"{name}_mean_square", square, f"mean square {said}", when=asked, **given)
    others = (
        ("density", unit_times("1", unit, -1), "probability density of the", "distributions", (f"{name}_bin",)),
        ("quantile", unit, "quantiles of the", "distributions", ("probability",)),
        ("minimum_quantile", unit, "quantiles over the paths of the minimum of the", "distributions", ("probability",)),
        ("maximum_quantile", unit, "quantiles over the paths of the maximum of the", "distributions", ("probability",)),
        ("spectrum", unit_times(square, "s rad-1", 1), "two-sided spectral density of the", "spectrum", ("frequency",)),
        ("mean_profile", unit, "mean in each bin of time of the", "profile", ("time_bin",)),
        ("mean_square_profile", square, "mean square in each bin of time of the", "profile", ("time_bin",)),
        ("", unit, "of the first paths, the", "record", ("path", "time")),
    )  # fmt: skip
    for ending, own, words, option, dimensions in others:
        yield Quantity(
            f"{name}_{ending}".removesuffix("_"), own, f"{words} {said}", when=f"{asked} with `{option}=`",
            controlled=False, dimensions=dimensions, **given,
        )  # fmt: skip


LEVELS = {"x": "m", "distance": "m", "v": "m s-1", "speed": "m s-1", "amplitude": "m", "energy": "m2 s-2"}
"""Quantities of one mass that can pass a level, and the units of the levels."""
_OF_A_MASS = "x", "distance", "v", "speed"
_MOVING = "x", "elongation"
ASKED = (
    *(Quantity(name, unit, "", where=_is_single) for name, unit in LEVELS.items()),
    *(Quantity(f"{_AT}{name}", LEVELS[name], "", where=_is_several) for name in _OF_A_MASS),
    *(Quantity(f"{of}{name}", "m", "", of=lambda part: part.has_ends, where=_is_several)
      for of in (_OF, _PAIRS) for name in ("elongation", "distance")),
    Quantity("impact_speed", "m s-1", "", of=_with("stop"), where=_is_single),
    Quantity(f"{_OF}impact_speed", "m s-1", "", of=_with("stop"), where=_is_several),
)  # fmt: skip
"""What a user names to see it, or when it passes a level, beside forces and accelerations."""
BOUNDED = ("", "_se", "_low", "_high")
"""Endings of a number, of its error and of the ends of its interval."""
OF_A_LEVEL = {
    "probability": ("1", "share of the paths that have passed by the end of the run", BOUNDED),
    "mean": ("s", "mean time of the first passage", BOUNDED[:2]),
    "restricted_mean": ("s", "mean of the time of the first passage, cut off at the end of the run", BOUNDED[:2]),
    "censored": ("1", "share of the paths that have not passed by the end of the run", BOUNDED[:2]),
    "at_start": ("1", "share of the paths beyond the level when the clock starts", BOUNDED[:2]),
    "rate": ("s-1", "rate of passages from when it is constant", BOUNDED),
    "return_period": ("s", "one over the rate of passages", BOUNDED),
}
"""The single numbers of each level that is passed: unit, meaning, and the endings of value, error and interval."""
CATALOGUE = (
    *_moments(),
    Quantity("amplitude_mean_square", "m2", "mean square of the amplitude of the linear springs' motion",
             r"\langle x^2\rangle + \langle v^2\rangle / \Omega^2", **_SPRINGS, where=_is_single),
    *_moments(_AT),
    Quantity("<pair>_elongation_mean", "m", "mean of the second mass's displacement less that of the first",
             r"\langle x_j - x_i\rangle", **_PAIR),
    Quantity("<pair>_elongation_mean_square", "m2", "mean square of the difference of their displacements",
             r"\langle (x_j - x_i)^2\rangle", **_PAIR),
    Quantity("impact_rate", "s-1", "impacts per unit time, on all walls and contacts together", **_STOPS),
    Quantity("impact_speed_mean", "m s-1", "mean speed before an impact", r"\langle |v^-|\rangle", **_STOPS),
    Quantity("impact_speed_mean_square", "m2 s-2", "mean square of the speed before an impact",
             r"\langle (v^-)^2\rangle", **_STOPS),
    Quantity("damping_force_mean", "N", "mean force of springpots, dashpots, arms and circuits together",
             r"\langle F\rangle", **_DAMPING_OF_ONE),
    Quantity("damping_power", "W", "power that they take from the motion", r"\langle F v\rangle", **_DAMPING),
    Quantity("damping_virial", "J", "their virial", r"\langle F x\rangle", **_DAMPING_OF_ONE),
    Quantity("<part>_power", "W", "power that the part feeds in, or, of a damper, takes", r"\langle F v\rangle",
             "of excitations but white noise and impulses, and of nonlinear dampers", _with("taken", "fed", "work")),
    Quantity("input_power", "W", "power that all excitations feed in"),
    Quantity("<part>_power", "W", "power that the wall or contact takes", r"\langle (1 - r^2) (v^-)^2\rangle m\nu / 2",
             **_STOP),
    Quantity("<part>_force_mean", "N", "mean force of the wall or contact, by impacts and on a mass at rest",
             r"\langle (1 + r) |v^-|\rangle m\nu + \langle F\rangle_\text{rest}", **_STOP),
    Quantity("energy_residual", "1", "what white noise and impulses are expected to feed in, less what is taken out "
             "and what the motion gains, over what is fed in: 0 within its error", "",
             "with white noise or impulses, or if nothing is fed in", where=_balances, controlled=False),
    Quantity("<part>_voltage_mean_square", "V2", "mean square voltage of the circuit", r"\langle V^2\rangle",
             "of each circuit, without thermal noise", **_CIRCUITS),
    Quantity("<part>_current_mean_square", "A2", "mean square current of the circuit's coil", r"\langle I^2\rangle",
             "of each circuit with a coil, without thermal noise", **_CIRCUITS | {"of": _has_coil}),
    Quantity("<part>_current_of_one_mean_square", "A2", "mean square current of one of several equal coils",
             r"\langle I^2\rangle / n^2", "of each circuit with a coil and `count=`, without thermal noise",
             **_CIRCUITS | {"of": lambda part: _has_coil(part) and part.together is not part}),
    Quantity("harvested_power", "W", "power that all circuits deliver", r"\sum\langle V^2\rangle / R",
             "with circuits, without thermal noise", **_CIRCUITS),
    Quantity("contact_share", "1", "share of the time in which a contact is touched", **_SOFT),
    Quantity("contact_penetration", "m", "deepest penetration of a path, its mean", **_SOFT, controlled=False),
    Quantity("<part>_impact_rate", "s-1", "impacts per unit time on the wall or contact", r"\nu", **_STOP),
    Quantity("<part>_impact_speed_mean", "m s-1", "mean speed before an impact on it", r"\langle |v^-|\rangle",
             **_STOP),
    Quantity("<part>_impact_speed_mean_square", "m2 s-2", "mean square speed before an impact on it",
             r"\langle (v^-)^2\rangle", "of each wall, with several masses", _with("stop"), _is_several),
    *_moments_at_end(),
    *_moments_at_end(_AT),
    Quantity("amplitude_mean_square_end", "m2", "mean square amplitude at the end of the run", **_END | _SPRINGS),
    *(Quantity(f"{of}counted_{name}", unit, f"{said} of impacts that are not slower than a speed",
               of=_with("stop"), dimensions=("barrier",) * bool(when), **_on_request("slowest_counted_impact", when))
      for name, unit, said in (("impact_rate", "s-1", "rate"), ("impact_speed_mean", "m s-1", "mean speed"),
                               ("impact_speed_mean_square", "m2 s-2", "mean square speed"))
      for of, when in (("", ""), (_OF, ", of each wall and contact"))),
    *_distribution("x", "m", "the displacement"),
    *_distribution("v", "m s-1", "the velocity"),
    *_distribution("amplitude", "m", "the amplitude"),
    *_distribution("impact_speed", "m s-1", "the speed before an impact"),
    *_distribution(f"{_AT}x", "m", "the displacement of the mass"),
    *_distribution(f"{_AT}v", "m s-1", "its velocity"),
    *_distribution(f"{_PAIRS}elongation", "m", "the difference of their displacements"),
    *_distribution(f"{_OF}impact_speed", "m s-1", "the speed before an impact on it"),
    _extreme("x_minimum", "m", "the smallest displacement"),
    _extreme("x_maximum", "m", "the largest displacement"),
    _extreme("v_largest", "m s-1", "the largest speed"),
    _extreme("impact_speed_largest", "m s-1", "the largest speed before an impact"),
    _extreme(f"{_AT}x_minimum", "m", "the smallest displacement of the mass"),
    _extreme(f"{_AT}x_maximum", "m", "the largest displacement of the mass"),
    _extreme(f"{_AT}v_largest", "m s-1", "its largest speed"),
    _extreme(f"{_PAIRS}elongation_minimum", "m", "the smallest difference of their displacements"),
    _extreme(f"{_PAIRS}elongation_maximum", "m", "the largest difference of their displacements"),
    _extreme(f"{_OF}impact_speed_largest", "m s-1", "the largest speed before an impact on it"),
    *(entry for each in _OUTPUTS for entry in _of_output(*each)),
    Quantity("<quantity>_cycle_rate", "s-1", "rainflow cycles per unit time of the displacement, force or acceleration",
             **_on_request("rainflow")),
    Quantity("<quantity>_damage_rate", "h-1", "damage per hour, by Basquin's curve and Miner's sum; of several curves "
             "`..._1`, `..._2`", r"\sum_i 1 / N(S_i)", numbered=True, **_on_request("rainflow")),
    Quantity("<quantity>_life", "h", "time to failure at this rate; of several curves `..._1`, `..._2`", numbered=True,
             **_on_request("rainflow")),
    *(entry
      for name, said in (("range", "the ranges of its cycles"), ("peak", "its maxima"), ("valley", "its minima"))
      for entry in (
          Quantity(f"<quantity>_{name}_density", "q-1", f"probability density of {said} in the window",
                   dimensions=(f"<quantity>_{name}_bin",), **_on_request("rainflow")),
          Quantity(f"<quantity>_{name}_quantile", "q", f"quantiles of {said} in the window",
                   dimensions=("probability",), **_on_request("rainflow")))),
    *(Quantity(f"{_OF}{what}_{ending}", unit_times("1", unit, power), f"{words} {said}",
               dimensions=dimensions, of=has, **_on_request("forces", more))
      for what, unit, said, has in (
          ("peak_force", "N", "the largest force of each touch of a soft contact", _is_soft),
          ("impulse", "N s", "the impulse of each impact on a rigid wall",
           lambda part: "stop" in part.powers and not _is_soft(part)))
      for ending, power, words, more, dimensions in (
          ("mean", 1, "mean of", "", ()), ("mean_square", 2, "mean square of", "", ()),
          ("density", -1, "probability density of", " with `distributions=`", (f"{_OF}{what}_bin",)),
          ("quantile", 1, "quantiles of", " with `distributions=`", ("probability",)),
          ("largest_quantile", 1, "quantiles over the paths with an impact of the largest of", " with `distributions=`",
           ("probability",)))),
    Quantity("decay_rate", "s-1", "rate at which the amplitude decays without noise", when="of `theory.averaging`",
             of=lambda part: False, controlled=False),
    *(Quantity(f"{of}_spectrum", "m2 s rad-1", f"two-sided spectral density of {said}", formula,
               dimensions=("frequency",), **_asked_of(of, "spectrum"))
      for of, said, formula in (
          ("x", "x", r"S_x(\omega)"), (f"{_AT}x", "the displacement of the mass", r"S_{x_i}(\omega)"),
          (f"{_PAIRS}elongation", "the difference of their displacements", ""))),
    *(_profile(entry.name, entry.unit, entry.meaning) for entry in _moments()),
    _profile("impact_rate", "s-1", "impacts per unit time"),
    _profile("impact_speed_mean", "m s-1", "mean speed before an impact"),
    _profile("counted_impact_rate", "s-1", "rate of impacts that are not slower than a speed"),
    _profile("counted_impact_speed_mean", "m s-1", "mean speed of impacts that are not slower than a speed"),
    _profile("impact_power", "W", "power that rigid walls take, if all have one constant restitution"),
    _profile("damping_power", "W", "power that dampers and memory take", where=_always),
    _profile("input_power", "W", "power that excitations feed in; of white noise and impulses its mean, known "
             "beforehand", where=_always),
    *(_profile(entry.name, entry.unit, entry.meaning) for entry in _moments(_AT)),
    _profile(f"{_PAIRS}elongation_mean", "m", "mean difference of their displacements"),
    _profile(f"{_PAIRS}elongation_mean_square", "m2", "mean square of the difference of their displacements"),
    _profile(f"{_OF}impact_rate", "s-1", "impacts per unit time on the wall or contact"),
    _profile(f"{_OF}impact_speed_mean", "m s-1", "mean speed before an impact on it"),
    _profile(f"{_OF}counted_impact_rate", "s-1", "rate of impacts on it that are not slower than a speed"),
    _profile(f"{_OF}counted_impact_speed_mean", "m s-1", "mean speed of impacts on it that are not slower than a "
             "speed"),
    _profile(f"{_OF}impact_power", "W", "power that the wall takes, of a constant restitution"),
    *(Quantity(f"{_LEVEL}first_passage_{name}", unit, said, dimensions=(f"{_LEVEL}first_passage_level",),
               **_on_request("first_passage"))
      for name, (unit, said, _) in OF_A_LEVEL.items()),
    Quantity(f"{_LEVEL}first_passage_survival", "1", "share of the paths that have not passed the level by a time",
             dimensions=(f"{_LEVEL}first_passage_level", f"{_LEVEL}first_passage_time"),
             **_on_request("first_passage")),
    Quantity(f"{_LEVEL}first_passage_quantile", "s", "quantiles of the time of the first passage",
             dimensions=(f"{_LEVEL}first_passage_level", "probability"), **_on_request("first_passage")),
    Quantity("x", "m", "displacement of the first paths", dimensions=("path", "time"), **_on_request("record")),
    Quantity("v", "m s-1", "velocity of the first paths", dimensions=("path", "time"), **_on_request("record")),
)  # fmt: skip
"""The quantities of runs, in the order of their results; each has a twin ``_se``, its standard error."""
PARTS_OF_ERROR = ("_se", "_step_bias", "_memory_bias", "_transient", "_error")
"""Endings of names of errors."""
OF_A_POINT = tuple(f"{name}{end}" for end in ("", "_end") for name in ("x_mean", "x_mean_square", "v_mean_square"))
"""Results of each of several masses, without the point's name in datasets."""
OF_A_WALL = tuple(entry.name.removeprefix(_OF) for entry in CATALOGUE if entry.dimensions == ("barrier",))
"""What there is of each wall and contact: in datasets ``barrier_impact_rate`` and so on over all of them."""


@cache
def _entry(name: str) -> Quantity | None:
    """The entry of that name, or the one of parts, points or pairs with the longest ending."""
    known = {entry.name: entry for entry in CATALOGUE}
    endings = {entry.name.partition(">")[2]: entry for entry in reversed(CATALOGUE) if entry.split[0]}
    stem = re.sub(r"(?<=_(?:life|rate))_\d$", "", name)
    found = max((ending for ending in endings if stem.endswith(ending)), key=len, default="")
    return known.get(name) or endings.get(found)


def unit_of(name: str, heavy: bool = False) -> str:
    """The unit of a quantity, with a mass or per unit mass; empty if there is no such quantity.

    Examples
    --------
    >>> unit_of("x_mean"), unit_of("stop_impact_rate"), unit_of("damping_power"), unit_of("damping_power", heavy=True)
    ('m', 's-1', 'm2 s-3', 'W')
    """
    entry = _entry(name)
    if entry is None:
        return ""
    unit = entry.unit
    if "q" in unit and not name.startswith(_ANY):
        own = unit_of(f"{name[: len(_ANY) - 1 - len(entry.name)]}_mean", heavy=True)
        unit = own if unit == "q" else unit_times("1", own, -1)
    return unit if heavy else per_unit_mass(unit)


def unit_of_result(system: System, name: str) -> str:
    """The unit of a result of a system: powers and forces are those of the mass, or per unit mass without one."""
    return unit_of(name, system.has_mass)


def is_controlled(name: str) -> bool:
    """Whether ``rtol`` can control a result.

    Examples
    --------
    >>> is_controlled("x_mean"), is_controlled("x_mean_end")
    (True, False)
    """
    entry = _entry(name)
    return entry is None or entry.controlled


def possible_results(system: System) -> tuple[str, ...]:
    """Names of all results that a system of these kinds of parts can have, whatever their numbers are.

    Examples
    --------
    >>> from springpot.problem.parts import Barrier, Spring, WhiteNoise
    >>> from springpot.problem.system import System
    >>> [name for name in possible_results(System(Spring(1.0), WhiteNoise(1.0), stop=Barrier(0.0))) if "stop" in name]
    ['stop_power', 'stop_force_mean', 'stop_impact_rate', 'stop_impact_speed_mean']
    """
    return _names(system, lambda entry: not entry.option)


def stated_in(system: System, names: Iterable[str]) -> tuple[str, ...]:
    """Those of some names that results of such masses have, whatever the parts on them are.

    Examples
    --------
    >>> from springpot.problem.parts import Spring
    >>> from springpot.problem.system import System
    >>> stated_in(System(Spring(1.0)), ["x_mean", "mass_x_mean"])
    ('x_mean',)
    """
    entries = ((name, _entry(name)) for name in names)
    return tuple(name for name, entry in entries if entry is not None and entry.where(system))


def results_on_request(system: System) -> tuple[str, ...]:
    """Names of all results of a run of such a system that need an argument of their own.

    Examples
    --------
    >>> from springpot.problem.parts import Spring
    >>> from springpot.problem.system import System
    >>> [name for name in results_on_request(System(Spring(1.0))) if name.endswith("density")][:4]
    ['x_density', 'v_density', 'amplitude_density', 'impact_speed_density']
    """
    return _names(system, lambda entry: bool(entry.option))


def numbers_on_request(system: System, option: str, of: Iterable[str] | None = None) -> tuple[str, ...]:
    """Names of the single numbers that a run has with an option, of each quantity that the option names.

    Examples
    --------
    >>> from springpot.problem.parts import Spring
    >>> from springpot.problem.system import System
    >>> numbers_on_request(System(Spring(1.0)), "rainflow", ["x", "spring_force"])[1:4]
    ('x_damage_rate', 'x_life', 'spring_force_cycle_rate')
    """
    names = _names(system, lambda entry: entry.option == option and entry.dimensions in ((), ("barrier",)))
    if of is None:
        return names
    known = {*(name for name, _ in asked_for(system, levels=False)), *of}
    owners = {name: owner_of(name, known) for name in names}
    return tuple(name for own in of for name in names if owners[name] == own and not name[-1].isdigit())


def owner_of(name: str, known: Iterable[str]) -> str:
    """Whose result a name is, of the parts, masses or quantities that are known; empty if it is of none.

    Examples
    --------
    >>> owner_of("stop_high_impact_rate", ["stop", "stop_high"])
    'stop_high'
    """
    return max((own for own in known if name.startswith(f"{own}_")), key=len, default="")


def _names(system: System, are_wanted: Callable[[Quantity], bool]) -> tuple[str, ...]:
    entries = filter(are_wanted, CATALOGUE)
    return tuple(dict.fromkeys(name for entry in entries for name in entry.names(system)))


_JOINED = tuple(
    Quantity(f"{_WALLS}_{what}", "", "", of=_with("stop"), where=lambda system: _WALLS not in _stops(system))
    for what in OF_A_WALL
)
"""Arrays over all walls in datasets, which take the place of the results of a wall that is called so."""


def _stops(system: System) -> list[str]:
    return [name for name, part in system.stated() if "stop" in part.powers]


def check_result_names(system: System) -> None:
    """That no two things have results of the same name, for any options of a run.

    Raises
    ------
    ValueError
        With the first such name, and what would have it.

    Examples
    --------
    >>> from springpot.problem.parts import Barrier, Spring
    >>> from springpot.problem.system import System
    >>> try:
    ...     System(Spring(1.0), stop=Barrier(-1.0), stop_counted=Barrier(1.0, free_side="below"))
    ... except ValueError as error:
    ...     print(error.args[0].partition(":")[0])
    stop_counted_impact_rate would be the name of two results, of the part stop_counted and of the part stop
    """
    if not _may_collide(system):
        return
    owners: dict[str, str] = {}
    simple_first = sorted((*CATALOGUE, *ASKED, *_JOINED), key=lambda entry: entry.split[0] in (_ANY, _LEVEL))
    for entry in simple_first:
        for name, owner in entry.owned(system):
            if (other := owners.setdefault(name, owner)) != owner:
                which = "the part" if _WHOLE in (other, owner) else "one of them"
                raise ValueError(
                    f"{name} would be the name of two results, of {other} and of {owner}: give {which} another name."
                )


def _may_collide(system: System) -> bool:
    """Whether a result can have two owners: one's name with the beginning of a result's ending is the other's name.

    Most systems are done with here, in a time that counts little beside that of making them.
    """
    of_whole, endings = _beginnings()
    names = [name for name, part in system.stated() if "inertia" not in part.powers or part.has_ends]
    names += system.groups
    if len(system.points) > 1:
        names += [*system.points, *(pair for pair, _ in _pairs(system))]
    known = {*names}
    taken = _WALLS in known and (stops := _stops(system)) and _WALLS not in stops
    return (
        bool(taken)
        or len(known) < len(names)
        or any(
            name in of_whole or any(name[:at] in known and name[at + 1 :] in endings for at in _ends_of_words(name))
            for name in known
        )
    )


@cache
def _beginnings() -> tuple[frozenset[str], frozenset[str]]:
    """How names of results of the whole begin, and the endings of those of its parts, masses and pairs."""
    found: dict[bool, set[str]] = {False: set(), True: set()}
    for entry in (*ASKED, *CATALOGUE):
        stem, ending = entry.split
        found[bool(stem)] |= {ending[:at] for at in _ends_of_words(ending)}
    return frozenset(found[False]), frozenset(found[True])


def _ends_of_words(name: str) -> list[int]:
    return [at for at, letter in enumerate(name) if letter == "_"]
