"""Devices that differ, on the page: how impact rates and mean squares scatter, and which number matters."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from springpot.explorer.excitation import chart
from springpot.explorer.requests import HISTOGRAM_BINS, text_of
from springpot.explorer.sliders import shown_in, titled, written
from springpot.machine.faults import with_error
from springpot.machine.plain import plain
from springpot.machine.progress import until_stopped
from springpot.problem.catalogue import unit_of_result
from springpot.problem.free_numbers import nominal, uncertain_numbers
from springpot.problem.system import System

if TYPE_CHECKING:
    from springpot.scattering import Scatter
    from springpot.scattering.estimates import Interval

_SHOWN = "impact_rate", "x_mean_square", "v_mean_square", "elongation_mean_square"  # endings


def quantities_of(system: System) -> list[str]:
    """The results of a device whose scatter is shown.

    Examples
    --------
    >>> from springpot.problem.parts import Barrier, Dashpot, Spring, WhiteNoise
    >>> quantities_of(System(Spring(4.0), Dashpot(0.5), WhiteNoise(1.0), Barrier(-0.5)))
    ['impact_rate', 'x_mean_square', 'v_mean_square']
    """
    from springpot.scattering.devices import linear_names
    from springpot.simulation.paths.simulation import simulation_of
    from springpot.simulation.plan.plan import plan_of

    one = [f"{wall}_impact_rate" for wall in system.stops] if len(system.stops) == 1 else []  # that of the mass
    names = linear_names(simulation_of(plan_of(system, paths=1, start="rest", threads=1)))
    found = [name for name in names if name.endswith(_SHOWN) and name not in one]
    return sorted(found, key=lambda name: not name.endswith("impact_rate"))


def scattered(
    devices: System, length: str, run: Mapping[str, Any], progress: Callable[[float], None], stop: Callable[[], bool]
) -> dict[str, Any]:
    """Simulate devices that differ: of each result the numbers of the report as words and texts, and shares.

    Parameters
    ----------
    devices : System
        With its uncertain numbers.
    length : {"m", "mm"}
        Of lengths and speeds in what is found.
    run : dict
        Devices, seed and threads.
    progress : callable
        Told the fraction done.
    stop : callable
        Tells whether to stop.

    Raises
    ------
    TypeError, ValueError, Stopped
        If the devices cannot be simulated, or it was stopped.

    Examples
    --------
    >>> from springpot.problem.parts import Dashpot, Spring, WhiteNoise
    >>> from springpot.problem.uncertain import uncertain
    >>> device = System(Spring(4.0), Dashpot(uncertain("c", 0.5, cov=0.3)), WhiteNoise(1.0))
    >>> found = scattered(device, "m", {"devices": 64}, float, bool)["results"][0]
    >>> found["title"], [one["name"] for one in found["inputs"]]
    ('x mean square', ['c'])
    """
    from springpot.scattering import scatter

    if not uncertain_numbers(devices):
        raise ValueError("tolerances: no number has one; tick Tolerances and give one to a number, beside its slider.")

    found = scatter(devices, quantities_of(nominal(devices)), **run, progress=until_stopped(progress, stop))
    return {"results": [_shown(found, name, length) for name in found], "said": [*map(text_of, found.warnings)]}


def _shown(found: Scatter, name: str, length: str) -> dict[str, Any]:
    """A result: its numbers as words and texts, and the shares of each input, the largest first."""
    own, (factor, unit) = found[name], shown_in(length, written(unit_of_result(found.system, name)))
    order = sorted(own.alone, key=lambda each: -own.together[each].value)
    shares = [
        {"name": each, "alone": _share(own.alone[each]), "together": _share(own.together[each])} for each in order
    ]
    title, (density, edges) = titled(name), np.histogram(factor * own.of_devices, HISTOGRAM_BINS, density=True)
    drawn = chart(f"{title} from device to device", (title, unit), ("density", ""), edges, bars=density,
                  mark=factor * found.nominal[name].value, note="Dashed: the nominal device.")  # fmt: skip
    return plain({
        "title": title, "numbers": [(words, text_of(text)) for words, text in _numbers(found, name, factor, unit)],
        "charts": [drawn] if order else [], "inputs": shares, "left": _share(own.unexplained) if order else None,
    })  # fmt: skip


def _numbers(found: Scatter, name: str, factor: float, unit: str) -> Iterator[tuple[str, str]]:
    own, of_one = found[name], found.nominal[name]
    yield "nominal device", with_error(factor * of_one.value, factor * of_one.error, unit or "1")
    yield "mean over devices", with_error(factor * own.mean.value, factor * own.mean.error, unit or "1")
    if own.scatter.value == 0.0:
        yield "standard deviation from device to device", f"not seen: below {factor * own.scatter.high:.3g} {unit}"
        return
    part = f", {100.0 * own.scatter.value / abs(own.mean.value):.3g} % of the mean" if own.mean.value else ""
    value, low, high = (factor * each for each in (own.scatter.value, own.scatter.low, own.scatter.high))
    yield "standard deviation from device to device", f"{value:.3g} {unit} ({low:.3g} to {high:.3g}){part}"
    for at, quantile in own.quantiles.items():
        value, low, high = (factor * each for each in (quantile.value, quantile.low, quantile.high))
        words = f"{value:.4g} {unit} ({low:.4g} to {high:.4g})"
        yield f"{100.0 * at:.0f} % of the devices are below", words
    assert found.settings is not None
    length = found.settings.window[1] - found.settings.window[0]
    yield (
        "standard deviation from path to path",
        f"{factor * own.path_scatter:.3g} {unit} in {length:.3g} s, which averages out",
    )


def _share(found: Interval) -> tuple[float, float, float]:
    return found.value, found.low, found.high
