"""Designs of devices that scatter: quantities are means and quantiles over devices, by `springpot.scatter`."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

from springpot.designing.approximation import Quantities, by_short_runs, leading
from springpot.designing.pooling import RoundValue
from springpot.designing.quantities import MONTE_CARLO, chosen_method, if_stationary
from springpot.designing.rounds import Simulated
from springpot.designing.search import Approximation, DesignProgress, Found
from springpot.designing.statement import Space, quantile_in
from springpot.machine.arrays import Floats
from springpot.problem.free_numbers import nominal, with_values
from springpot.problem.system import System
from springpot.scattering.devices import linear_names
from springpot.scattering.result import Scatter
from springpot.scattering.scattered import FEWEST, scatter
from springpot.simulation.kernel.sizes import LANES
from springpot.simulation.paths.simulation import Progress, simulation_of
from springpot.simulation.plan.plan import plan_of
from springpot.theory.registry import METHODS

_QUICK, _FIRST, _MOST = 64, 512, 8192  # devices: at each place of the search, of the first round, and at most
_USUAL_SHARE = 0.5
_STUDENT = 1.12  # an error from 16 scramblings: with this factor a normal law is as wide, at 99 %, as Student's


def names_over_devices(system: System, asked: Iterable[object]) -> list[str]:
    """What can be limited: means over devices, and those quantiles that are asked for.

    Examples
    --------
    >>> import springpot as sp
    >>> device = sp.System(sp.Spring(sp.uncertain("k", 4.0, cov=0.1)), sp.Dashpot(1.0), sp.WhiteNoise(1.0))
    >>> names_over_devices(device, ["x_mean_square_quantile_0.9"])[-1]
    'x_mean_square_quantile_0.9'
    """
    means = linear_names(simulation_of(plan_of(nominal(system), paths=LANES, start="rest")))
    quantiles = []
    for name in asked:
        result, share = quantile_in(name) if isinstance(name, str) else ("", None)
        if result in means and share is not None and FEWEST <= share <= 1.0 - FEWEST:
            quantiles.append(str(name))
    return [*dict.fromkeys([*means, *quantiles])]


@dataclass(frozen=True, eq=False)
class OverDevices:
    """Quantities over the devices of a system with free numbers.

    Attributes
    ----------
    system : System
    names : tuple of str
        Of the quantities.
    threads : int or None
    """

    system: System
    names: tuple[str, ...]
    threads: int | None

    def at(self, values: dict[str, float], progress: Progress | None = None, **how: Any) -> Scatter:
        """The scatter of the devices with these free numbers."""
        asked = [quantile_in(name) for name in self.names]
        return scatter(
            with_values(self.system, values), [*dict.fromkeys(name for name, _ in asked)], progress=progress,
            quantiles=[*{share for _, share in asked if share is not None}] or [_USUAL_SHARE], threads=self.threads,
            **how,
        )  # fmt: skip

    def read(self, found: Scatter) -> dict[str, tuple[float, float]]:
        """Values and standard errors."""
        numbers = {}
        for name in self.names:
            result, share = quantile_in(name)
            own = found[result].mean if share is None else found[result].quantiles[share]
            numbers[name] = own.value, _STUDENT * own.error
        return numbers

    def quick(
        self, space: Space, places: Floats, method: str | None, seed: int, work: DesignProgress
    ) -> tuple[str, Quantities]:
        """The method of the search, and smooth surfaces through what it says of few devices at each place."""

        def middle(values: dict[str, float]) -> System:
            return nominal(with_values(self.system, values))

        middles = [if_stationary(partial(middle, space.values(place)), "design") for place in places]
        known = [middle for middle in middles if middle is not None]
        if method is None:  # methods of theory that are not exact take longer than short runs, for each device
            name = leading(known, [*{quantile_in(each)[0] for each in self.names}], work)
            name = name if name != MONTE_CARLO and METHODS[name].exact else MONTE_CARLO
        else:
            name = chosen_method(known[0], method)[0]
        steps = plan_of(known[0], paths=LANES).settings.steps if known else 1

        def run(values: dict[str, float], progress: Progress) -> dict[str, float]:
            found = self.read(self.at(values, progress, devices=_QUICK, method=name, seed=seed))
            return {each: value for each, (value, _) in found.items()}

        path_steps = float(len(places) * 8 * _QUICK * steps)
        return name, by_short_runs(self.system, space, places, run, path_steps, work)

    def measured(
        self, approximation: Approximation, seeds: Sequence[int], work: DesignProgress
    ) -> Callable[[Found, float, int], Simulated]:
        """Monte Carlo of what a search found: every round has devices of its own, as many as the error needs."""
        devices = _FIRST

        def measure(found: Found, rtol: float, number: int) -> Simulated:
            nonlocal devices
            work.round(number, 0.0)
            while True:
                own = self.at(
                    found.values, lambda fraction: work.round(number, fraction), devices=devices, seed=seeds[number]
                )
                numbers = self.read(own)
                above = max((error / (rtol * abs(value)) for value, error in numbers.values() if value), default=0.0)
                wanted = 2 ** math.ceil(math.log2(max(devices * above**2, 1.0)))
                if above <= 1.0 or devices >= _MOST:
                    break
                devices = min(max(wanted, 2 * devices), _MOST)
            devices = min(max(wanted, _FIRST), _MOST)
            theory = approximation.at(found.u)
            return {
                name: RoundValue(found.u, theory.get(name, math.nan), value, error, self._bias(own, name, value))
                for name, (value, error) in numbers.items()
            }, own.warnings  # fmt: skip

        return measure

    def _bias(self, found: Scatter, name: str, value: float) -> float:
        """Of the step, as of the nominal device."""
        middle = found.nominal[quantile_in(name)[0]]
        known = middle.step_bias is not None and middle.value
        return abs(value * (middle.step_bias or 0.0) / middle.value) / math.sqrt(3.0) if known else 0.0
