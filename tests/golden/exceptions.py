"""Numbers that may differ, be missing, or be new, each with the reason; the changelog has the same list.

A key is a regular expression that is searched in the name, after the renaming of ``renamed.py``.  The first that fits
counts.
"""

from __future__ import annotations

# with the root finder of before in place these have the bits of before; the last five only in their values, not errors
_ROOTS = (
    "3|9|13|15|17|23|27|29|31|37|38|41|43|45|47|61|62|65|69|73|79|87|91|93|95|99|77|83|92|64|82|"
    "0|10|20|24|28|36|44|52|80|84|88|1"
)
_SPRING = r"^(runs/spring|random_runs/\d*0|devices/(0|10|20))/"
_EVERY_NINTH = "|".join(map(str, range(5, 220, 9)))
_OPEN = rf"^((runs|rtol|files)/open|(random_runs|devices)/({_EVERY_NINTH}))/(.*/)?"

EXCEPTIONS: dict[str, str] = {
    # runs
    r"/\w*spectrum(_se)?$": "Its sums are over sixteen samples at once: last digits (within 1e-13).",
    # runs of the paper's oscillator
    _SPRING: "A springpot of order 0 is a spring: it adds to the stiffness and flies exactly; it takes no power.",
    r"^runs/\w+/observe/": "The seed of an observable's run is made from the words of the problem, and these changed.",
    _OPEN + r"impact_(rate|speed_mean|speed_mean_square)(_\w+)?$": "Without a wall there are no results of impacts.",
    r"/barrier_(impact_rate|impact_speed_mean|power|force_mean)(_\w+)?$": "New: what each wall takes.",
    r"/input_power(_\w+)?$": "New for oscillators: what the noise puts in.  For systems it is of the whole inertia.",
    r"^(rtol|random_runs|devices).*/damping_(power|force_mean|virial)_(error|step_bias|memory_bias|transient)$":
        "New: the power of the springpot has a budget.",
    r"^(rtol/\w+|random_runs/\d+/rtol)/damping_power(_se)?$":
        "The bias of the step is taken from the power of the springpot too.",
    r"/settings/initial_position$": "0.0 for a wall at 0 above, and not -0.0.",
    r"^(runs|random_runs|devices)/\w+/(record|together)/x$": "The same path; it begins at 0.0 and not at -0.0.",
    # an oscillator written as a device is the device: its forces are in newtons and its powers in watts
    r"^devices/\d+/\w+/damping_(power|force_mean|virial)(_\w+)?$": "In N and W; they were per kilogram.",
    r"^(devices/(5|14|23)/theory|methods_for_systems/75)/(exact|trust)":
        "Exact laws know that the paper's problem without a wall is a linear system.",
    r"^devices/21/theory/exact/": "With a dashpot, the law of the paper's problem, which has more curves; last digits.",
    # theory: one registry, in which each method is asked about every system
    r"^methods/\d+/(averaging_amplitude|half_cycles|linear|linearization|path_integration)(/|$)":
        "New: methods of systems are asked about the paper's problem too.",
    r"/(trust|judge\w*)/.*$": "New: the map of a system is that of its problem, so more methods are judged.",
    r"^(methods|methods_for_systems|devices/\d+/theory).*/warnings$":
        "A result of theory has the warnings of theory alone; `trust` and `recommended` add those of the maps.",
    r"^(methods|methods_for_systems)/\d+/words/numbers$": "Numbers of new and of fewer sentences.",
    r"^methods/32/exact/curves/": "Last digits: SciPy finds the pole.",
    r"/(barrier_impact_rate|barrier_impact_speed_mean)/\d+$": "Each wall has its results by its own name.",
    r"/(barrier|contact)(_\d+)?_impact_(rate|speed_mean)$": "Each wall has its results by its own name.",
    r"/rarest_impact_rate$": "It is read where it is needed: the map of systems has it, a result has not.",
    # systems: the same sums in another order, and what they had not
    r"^(systems|files|studies)/.*amplitude_mean_square_end(_se)?$": "New: the amplitude at the end.",
    r"^(systems|files|studies)/.*impact_(rate|speed_mean|speed_mean_square)_step_bias$": "New: of systems too.",
    r"^(systems|files|studies)/.*/energy_residual(_se)?$": "Last digits: the works are summed in another order; NaN "
        "where no balance can be checked.",
    r"^(systems|files)/.*/warnings$": "One list of warnings: what a transient, a record or a missing stationary state "
        "says already is not said again, and the paper's problem says it as others do.",
    r"^systems/57-": "The loss of a contact counts in the guess that sets step and duration.",
    r"^systems/(5|97)-": "A motion that has died out (1e-115 m), and one without noise, whose phase is that of its "
        "pilots: the last digits of its scales decide.",
    rf"^(systems/|files/(system|toml)_)({_ROOTS})\b": "SciPy finds the roots (the wells, the ends of the law, its "
        "temperature): step and duration in their last digits.",
    r"^files/spring/": "A springpot of order 0 is a spring: it flies exactly.",
    r"^files/\w+/(json|netcdf|table)/": "The path begins at 0.0 and not at -0.0; without a wall no result has "
        "one.",
    # what is simulated with seeds of its own: they are made from the parts.  With one seed for all, before and after,
    # the bits are the same
    r"^(comparisons|fits/statistics)/": "Seeds are made from the parts.",
    r"^fits/(choices|moduli|response|spectrum)/(errors|covariance|correlations)": "The covariance of independent "
        "points is the inverse information itself: last digits.",
    r"^studies/scaled/": "Gone: a run to a tolerance does its work.",
    r"^(studies|designs)/devices?/": "Parts that are the paper's problem are it: closed forms, and no guess, set step, "
        "duration and the search.",
    r"^studies/": "Seeds are made from the parts, and roots are SciPy's.",
    r"^designs/hard/": "SciPy finds the roots: last digits.",
    r"^sensitivities/\w+/\w+/.*/(natural_frequency|spring_stiffness)$": "To the stiffness, not to its root.",
    r"^sensitivities/two_walls/": "The recommended method of unlike walls is the half cycles; roots are SciPy's.",
    r"^page/open/theory/(places|methods/\w+/densities)/": "The axis is wide enough for all methods, which are more.",
    r"^page/open/estimates/": "Without a wall there are no results of impacts.",
    r"^page/\w+/theory/methods/(averaging_amplitude|linear|linearization)/": "New: they are asked about the paper's "
        "problem too.",
    r"^validity/\d+/\w+/warnings$": "A result of theory has the warnings of theory alone.",
    r"^files/(system_\d+|\w+)/table/": "The table has a row more for each new result, and systems have one at all.",
}  # fmt: skip

ROUNDED: dict[str, tuple[float, str]] = {
    r"^(devices/\d+/theory|methods|methods_for_systems|validity|page)/":
        (1e-6, "Theory: moments, quadrature on panels and the ends of a law are found in one place each; the memory "
         "closure without a wall is the exact law.  Curves were compared within 1e-7."),
    r"^sensitivities/": (5e-3, "The same; most in the errors of extrapolated differences, which are rounding."),
    r"^designs/": (1e-5, "The same, in the search."),
}  # fmt: skip
"""Numbers that may differ by so much of their value, or by 1e-12, with the reason; arrays are compared by their bits
alone, and are then only counted."""
