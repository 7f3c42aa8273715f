"""Answers without dice: functions that take an oscillator and return a small frozen result."""

from collections.abc import Callable

from springpot.oscillator import Oscillator
from springpot.theory.averaging import Averaging, averaging
from springpot.theory.result import Moments, NoStationaryState, NotCovered, Result, no_answer

__all__ = ["Averaging", "Moments", "NoStationaryState", "NotCovered", "Result", "all_methods", "averaging"]


def all_methods(oscillator: Oscillator) -> dict[str, dict[str, object]]:
    """Every method's answer to one oscillator, ready for JSON.

    Parameters
    ----------
    oscillator : Oscillator

    Returns
    -------
    dict
        Name of the method to its dictionary (see `Result.to_dict`).  A method that does not cover the oscillator has
        None for every moment and a ``statement`` that says what it covers.

    Examples
    --------
    >>> answers = all_methods(Oscillator())
    >>> [(name, round(answer["amplitude_mean_square"], 3)) for name, answer in answers.items()]
    [('averaging_printed', 2.296), ('averaging', 2.296)]
    """
    methods: dict[str, Callable[[], Result]] = {
        "averaging_printed": lambda: averaging(oscillator, form="printed"),
        "averaging": lambda: averaging(oscillator),
    }
    answers: dict[str, dict[str, object]] = {}
    for name, solve in methods.items():
        try:
            answers[name] = solve().to_dict()
        except NotCovered as refusal:
            answers[name] = no_answer(str(refusal))
    return answers
