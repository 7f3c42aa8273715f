"""An axis that is a sample of devices: the uncertain numbers of a study's system at points of Sobol's sequence."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from springpot.machine.arguments import Uncertain
from springpot.machine.faults import FileError, listed, shown
from springpot.problem.free_numbers import nominal, uncertain_numbers
from springpot.problem.numbers import numbers_of
from springpot.problem.system import System

AXIS = "draw"
_MOST = 2**16


def with_draws(content: dict[str, Any], system: System, title: str) -> dict[str, Any]:
    """The content of a study, with the devices of ``draws`` as the columns of a zipped axis.

    The devices are those that `springpot.scatter` draws with the same seed and as many devices.  More draws hold those
    of fewer.

    Parameters
    ----------
    content : dict
    system : System
    title : str
        Of the study, for messages.

    Raises
    ------
    FileError
        If there are uncertain numbers and no ``draws``, or the other way round, or it is no such number.
    """
    numbers, draws = uncertain_numbers(system), content.get("draws")
    if not numbers and draws is None:
        return content
    from springpot.scattering.devices import correlated, drawn  # brings the whole engine
    from springpot.scattering.estimates import SCRAMBLINGS

    told = f"{title} is not right: draws must be a power of two from {SCRAMBLINGS} to {_MOST}"
    if not numbers:
        raise FileError(f"{title} is not right: draws are of uncertain numbers, and the system has none.")
    if draws is None:
        raise FileError(f"{told}, for {listed([*numbers])} {'is' if len(numbers) == 1 else 'are'} uncertain.")
    whole = isinstance(draws, int) and not isinstance(draws, bool)
    if not whole or not SCRAMBLINGS <= draws <= _MOST or draws & (draws - 1):
        raise FileError(f"{told}, not {shown(draws)}.")
    zipped, seed = content.get("zipped", {}), content.get("seed", 1)
    if not isinstance(zipped, Mapping) or not isinstance(seed, int) or seed < 0:
        return {name: each for name, each in content.items() if name != "draws"}  # which is refused with its reason
    if AXIS in zipped:
        raise FileError(f"{title} is not right: zipped axis {AXIS!r} must have another name beside draws.")
    values = drawn(numbers, draws, seed, correlated({}, numbers)).values
    own = dict(zip(numbers, values.T.tolist(), strict=True))
    columns = {
        name: [number.at(value) for value in own[number.name]]
        for name, number in numbers_of(system).items() if isinstance(number, Uncertain)
    }  # fmt: skip
    rest = {name: each for name, each in content.items() if name != "draws"}
    return {**rest, "system": nominal(system), "zipped": {**zipped, AXIS: columns}}
