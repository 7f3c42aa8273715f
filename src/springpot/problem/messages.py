"""The catalogue of warnings: each has a name, a category, a sentence with its numbers, and what to do.

A result's ``warnings`` are `Message`: strings that know their name and category.  `springpot.simulate` also raises them
as Python warnings of their category, so that `warnings.filterwarnings` can tell them apart.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

__all__ = [
    "MESSAGES", "AccuracyWarning", "FileWarning", "Message", "NoEffectWarning", "ProblemWarning", "RareEventWarning",
    "SpringpotWarning", "StationarityWarning", "say", "warn_of_file",
]  # fmt: skip


class SpringpotWarning(UserWarning):
    """Any warning of springpot."""


class AccuracyWarning(SpringpotWarning):
    """A number may be off by more than its error says."""


class StationarityWarning(SpringpotWarning):
    """An average is not that of a stationary state."""


class RareEventWarning(SpringpotWarning):
    """So few events were seen that a standard error does not say enough."""


class ProblemWarning(SpringpotWarning):
    """The problem itself is odd: often a slip of a sign or a unit."""


class NoEffectWarning(SpringpotWarning):
    """An argument was given that changes nothing."""


class FileWarning(SpringpotWarning):
    """Something was assumed of a file that it does not say itself."""


class Message(str):
    """A sentence that knows its name in `MESSAGES`."""

    name: str

    def __new__(cls, sentence: str, name: str) -> Message:
        self = super().__new__(cls, sentence)
        self.name = name
        return self

    @property
    def category(self) -> type[SpringpotWarning]:
        """The class of the Python warning."""
        return MESSAGES[self.name].category


@dataclass(frozen=True)
class Kind:
    """One entry of the catalogue.

    Attributes
    ----------
    category : type
    sentence : str
        With the names of its numbers in braces.
    advice : str
        What to do.
    """

    category: type[SpringpotWarning]
    sentence: str
    advice: str


def say(name: str, /, **numbers: Any) -> Message:
    """The sentence of a message with its numbers.

    Examples
    --------
    >>> say("few_impacts", rate="impact_rate", low=0.1, high=0.9, seen="3 impacts", time="20 s").name
    'few_impacts'
    """
    return Message(MESSAGES[name].sentence.format(**numbers), name)


def warn_of_file(title: str, notes: Sequence[str]) -> None:
    """Warn of what was assumed of a file, in one line, where the caller of a function of the library called it."""
    if notes:
        warnings.warn(say("assumed_of_file", file=title, assumed="; ".join(notes)), FileWarning, stacklevel=3)


_ACCURACY, _STATIONARY, _RARE = AccuracyWarning, StationarityWarning, RareEventWarning
_PROBLEM, _NO_EFFECT = ProblemWarning, NoEffectWarning
_OF_FILE = FileWarning

MESSAGES: dict[str, Kind] = {
    "not_finite": Kind(
        _ACCURACY, "the response is not a finite number{cause}",
        "Use a much finer step; check a force or a law of your own, which must return a number everywhere.",
    ),
    "coarse_step": Kind(
        _ACCURACY,
        "step is {step:g} s, {ratio:.2g} of the shortest time scale: expect errors of about 1 % above {limit:g}; use "
        "at most {most:.2g} s.",
        "Use the step that the sentence names, or rtol=, which chooses it.",
    ),
    "coarse_step_of_transients": Kind(
        _ACCURACY,
        "step is {step:g} s, {ratio:.2g} of the shortest time scale: stationary averages of motion and impacts have no "
        "error of the step at order 1, but transients, spectra, extremes and first passages have; use at most "
        "{most:.2g} s for these.",
        "Nothing for averages; for the rest use the step that the sentence names.",
    ),
    "shaped_density": Kind(
        _ACCURACY,
        "{name} is made by a filter, which changes the linear response by {x} in x^2 and {v} in v^2: its density is "
        "within {worst} of the table, and passes to 0 within a tenth of the frequency on either side of the band.",
        "The resonance lies at an end of the band or outside it: take values of linear systems from theory.linear.",
    ),
    "contact_tolerance": Kind(
        _ACCURACY,
        "contact_tolerance is {tolerance:g} m, which is not small compared with the root mean square displacement of "
        "{size:.2g} m: the response is biased by about their ratio; use at most {most:.1g} m.",
        "Give a smaller contact_tolerance.",
    ),
    "coarse_hops": Kind(
        _ACCURACY,
        "v_mean_square is about {low} too low at a step of {step:g} s: springs or constant forces press the mass on "
        "{wall} with {press:.3g} m/s2, which changes the velocity in a step by {turned:.2g} of its root mean square of "
        "{speed:.2g} m/s; use at most {most:.2g} s. The power and the mean force of the wall are right at any step.",
        "Use the step that the sentence names, or rtol=; the error falls like the step.",
    ),
    "uncountable_impacts": Kind(
        _PROBLEM,
        "impact rate and speeds{of} are undefined, and so are mean impulses: {reason}. Power and mean force of the "
        "wall are defined; slowest_counted_impact counts those that are faster.",
        "Give slowest_counted_impact=, or a Contact in place of the wall, or ask for powers and forces of the wall, "
        "which are finite.",
    ),
    "springpot_holds_alone": Kind(
        _STATIONARY,
        "{name} lacks about {left} in a window from {begin:.3g} s on: no spring holds the mass, and a springpot of "
        "order {order:.3g} alone forgets the start only like t^({power:.2g}); from {later:.3g} s on it lacks 1 %.",
        "Use theory.linear, which has the stationary value exactly, or a window from the time that the sentence names.",
    ),
    "transient_in_window": Kind(
        _STATIONARY,
        "window starts at {begin:g} s, when about {left} of the transient is left{cause}: start it after {later:.3g} s "
        "for stationary values.",
        "Use a longer run and a later window, or rtol=.",
    ),
    "window_from_rest": Kind(
        _STATIONARY,
        "the window is the whole run, because {asked} begins at rest, so that means over it include the transient: for "
        "stationary means leave {asked} out, or give window=({begin:.3g}, {end:.3g}), where {asked} then begins.",
        "Have stationary means and what happens from rest in two runs.",
    ),
    "no_stationary_state": Kind(
        _STATIONARY, "there is no stationary state: {reason}.",
        "Read the averages as those of a transient, or add what dissipates energy.",
    ),
    "starts_from_rest": Kind(
        _STATIONARY, "the run starts from rest, because there is no stationary state: {reason}.",
        "Give start='rest' to say that you know.",
    ),
    "unchecked_start": Kind(
        _STATIONARY,
        "the adapted start was taken from a rough theory and was not checked: long enough pilot runs would take too "
        "much time.",
        "Use a longer run, and compare two windows of it.",
    ),
    "start_was_off": Kind(
        _STATIONARY,
        "the start was off: {name} is still about {off} of the root mean square (standard error {error}) or more away "
        "from its stationary value, as the means over the window show. A springpot forgets this only like "
        "t^-{order:.2g}, and other results are off too.",
        "Use start='stationary', or more paths.",
    ),
    "still_changes": Kind(
        _STATIONARY,
        "not stationary: {name} still changes by {share} {compared}; a run with a window from {later:.3g} s on is "
        "needed.",
        "Give a longer run and a later window=, at least from the time that the sentence names.",
    ),
    "memory_of_start": Kind(
        _STATIONARY,
        "the memory still acts of the start: its mean force is {share} of the springs' (0 in the stationary state) "
        "and decays only like t^-{order:.2g}, so mean displacement and impact rate are not yet stationary (energies "
        "are barely affected). Use start='stationary' for them.",
        "Use start='stationary'.",
    ),
    "energy_balance": Kind(
        _ACCURACY,
        "the energy balance fails by {share} of the input power (standard error {error}): repeat the run with a finer "
        "step before you trust it.",
        "Repeat the run with a finer step.",
    ),
    "impacts_limited": Kind(
        _ACCURACY,
        "in {count} half steps more than 32 impacts followed each other: later ones were taken as plastic, and in "
        "{halted} of these half steps the masses stayed where they were for the rest.",
        "Use a shorter step. Energies are barely affected; impact rates count these impacts only in part.",
    ),
    "coarse_record": Kind(
        _ACCURACY,
        "{name} has {points:.3g} points in a period of the motion, at {frequency:.4g} Hz: {fate}.",
        "Where the points are samples of a signal, make the record with interpolation='band-limited', or take a record "
        "of a higher rate; where they are corners, between which straight lines are meant, nothing is wrong.",
    ),
    "slow_impacts": Kind(
        _ACCURACY,
        "impact rate is about {low} too low and the mean impact speed {high} too high at a step of {step:g} s: the "
        "step misses slow impacts behind this lossy wall, and the error decreases only like step^{order:.2g}; "
        "they take hardly any energy. With rtol= the error is bounded.",
        "Use rtol=, or count only impacts that matter with slowest_counted_impact=.",
    ),
    "slow_impacts_of_some_wall": Kind(
        _ACCURACY,
        "impact rate{of} {low} at a step of {step:g} s: the step misses slow impacts behind a lossy wall, which take "
        "hardly any energy.",
        "Use a finer step, or slowest_counted_impact=.",
    ),
    "slow_impact_quantiles": Kind(
        _ACCURACY,
        "the step of {step:g} s misses slow impacts, so these quantiles of the impact speed{of} are wrong: "
        "{quantiles}. {name}_quantile_step_bias bounds the error; a shorter step reduces it.",
        "Use a finer step, or read higher quantiles only.",
    ),
    "uncontrolled_impacts": Kind(
        _ACCURACY,
        "quantities does not name these results, which may be wrong by up to: {off}; name them to bound their errors.",
        "Name them in quantities=.",
    ),
    "rtol_not_reached": Kind(
        _ACCURACY, "{sentence}", "Give a larger rtol or max_time; the sentence says what holds it up.",
    ),
    "observable_not_finite": Kind(
        _ACCURACY,
        "observable {name} is not a finite number: its function raised an error, or is not finite everywhere.",
        "Check the function at every x and v that the motion reaches.",
    ),
    "force_over_steps": Kind(
        _ACCURACY,
        "{name} is seen as its mean over a step, which lacks {share} of its mean square: so do its distribution, "
        "extremes, record and profile.",
        "Use a shorter step; the mean square itself has what is lacking.",
    ),
    "shocks_left_out": Kind(
        _PROBLEM,
        "{name} is that between impacts: the shocks on {walls} are not in it, nor in its peaks, cycles and damage, "
        "because a rigid wall has no largest force.",
        "Take a Contact with the stiffness of the stop for peaks, cycles and damage: they depend on it.",
    ),
    "peaks_between_steps": Kind(
        _ACCURACY,
        "{name} is taken at the steps, and a touch of {contact} lasts {steps:.2g} of them: its largest values may be "
        "{lacking} too low; use at most {most:.2g} s. {contact}_peak_force has the largest forces between steps.",
        "Use the step that the sentence names for peaks and levels; moments need no other step.",
    ),
    "passage_mean_extrapolated": Kind(
        _ACCURACY, "{name}: {assumed}",
        "Use a longer run, or read the restricted mean and the survival curve.",
    ),
    "passed_at_start": Kind(
        _STATIONARY,
        "{name}: {share} of the paths were beyond the level when the clock started; their time is 0.",
        "Start from rest, or take a level that the stationary motion passes rarely.",
    ),
    "unseen_impacts": Kind(
        _RARE,
        "{rate} is below {high:.2g} per second with a probability of 95 %: no impact was seen in {time} of all paths "
        "together.",
        "Use more or longer paths, or theory.",
    ),
    "few_impacts": Kind(
        _RARE,
        "{rate} is between {low:.2g} and {high:.2g} per second with a probability of 95 %, not symmetric about its "
        "value: only {seen} in {time} of all paths together.",
        "Use more or longer paths.",
    ),
    "damage_of_few_paths": Kind(
        _RARE,
        "{name} is {share} that of the worst of {paths:,} paths: its standard error is itself off by about {off}.",
        "Use more or longer paths.",
    ),
    "uneven_repetitions": Kind(
        _RARE,
        "the repetitions of {name} differ by {spread:.1f} times their mean, and the largest has {most} of their sum: "
        "the probability may be larger than its error says, for there may be ways to the level that few of them found.",
        "Use a smaller rtol, or a longer max_time.",
    ),
    "wide_interval": Kind(
        _RARE,
        "the 95 % interval of the probability of {name} above {level:g} {unit}, {low} to {high}, is {times:.1f} times "
        "as wide as its standard error says, since a few repetitions make most of it: read the interval.",
        "Read low and high; a smaller rtol brings both together.",
    ),
    "rare_not_known": Kind(
        _RARE,
        "the probability of {name} above {level:g} {unit} is known to {reached} only, not to {rtol}: {reason}.",
        "Give a larger rtol or max_time.",
    ),
    "level_not_found": Kind(
        _RARE,
        "no level of {name} was found that is exceeded {asked}: {reason}.",
        "Ask for the probability of a level instead, or give a larger max_time.",
    ),
    "level_not_reached": Kind(
        _RARE,
        "no path exceeded {name} of {level:g} {unit}: its probability is at most {most:.2g}.",
        "Give a larger max_time, or lower levels.",
    ),
    "not_saved": Kind(
        _RARE,
        "{place!r} could not be written any more ({reason}), so later repetitions are not in it; this result has them.",
        "Make room, and repeat the call: it goes on from those that are in the file.",
    ),
    "far_wall": Kind(
        _PROBLEM,
        "{wall} is {away:.0f} standard deviations of {x} away from its mean, so no path comes near it: check position, "
        "free_side and unit.",
        "Check position, free_side and unit; leave the wall out if it is meant.",
    ),
    "pressed_wall": Kind(
        _PROBLEM,
        "{wall} is pressed against by the springs all the time, and {x} has a standard deviation of only {spread:.2g} "
        "m: check position, free_side and unit.",
        "Check position, free_side and unit: a gap of the wrong sign is a preload.",
    ),
    "chatter": Kind(
        _PROBLEM,
        "{wall} is struck {rate:.3g} times per second, {often:.0f} times in a natural period: this is chatter near a "
        "wall, or rattle in a narrow gap, of impacts that are mostly small; slowest_counted_impact of a run counts "
        "those that are not.",
        "Give slowest_counted_impact=.",
    ),
    "free_modes": Kind(
        _STATIONARY,
        "{count} a frequency of 0: unless a part that you add holds it, its mean square displacement grows without "
        "bound under noise; what it does not change, such as bending or an elongation, has stationary results.",
        "Ask for elongations between points, or hold the structure by springs; look for a support that was forgotten.",
    ),
    "massless_coordinates": Kind(
        _PROBLEM,
        "coordinates without a mass, {count} of {size}, follow the others statically (Guyan): the static flexibility "
        "at the others is exact.",
        "Nothing, if it is meant, as of rotations without inertia. What a force on such a coordinate itself bends has "
        "no mass and is left out: put a small mass where a stop or a force is.",
    ),
    "modes_left_out": Kind(
        _ACCURACY,
        "{modes} of {size} modes are kept, up to {top:.4g} Hz: those left out have {left}.",
        "Take more modes; or name the point in residual=, which adds a mode that has its static flexibility; or put a "
        "mass on the point, if it has none.",
    ),
    "assumed_of_file": Kind(
        _OF_FILE,
        "{file}: {assumed}.",
        "Compare it with the file; unit=, columns=, rate= and decimal= state what it is.",
    ),
    "no_effect": Kind(_NO_EFFECT, "{argument} has no effect{why}.", "Leave the argument out."),
}  # fmt: skip
"""Every warning by name."""
