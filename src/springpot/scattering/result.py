"""What `springpot.scatter` returns."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from springpot.machine.arrays import Floats
from springpot.machine.faults import with_error
from springpot.machine.installed import need
from springpot.machine.plain import plain
from springpot.problem.catalogue import unit_of_result
from springpot.problem.system import System
from springpot.scattering.estimates import BELOW, Estimates, Interval
from springpot.simulation.plan.settings import Settings
from springpot.simulation.result.results import Estimate

if TYPE_CHECKING:
    import xarray


@dataclass(frozen=True, eq=False)
class Scatter:
    """Results over many devices; made by `springpot.scatter`.

    Attributes
    ----------
    system : System
        With its uncertain numbers.
    method : str
        "monte_carlo", or the method of theory.
    settings : Settings or None
        Of all devices; None of theory.
    numbers : tuple of str
        The uncertain numbers.
    inputs : tuple of str
        The same, with those in one word that depend on each other.
    draws : ndarray, shape (devices, numbers)
        Their values.
    paths : int
        Of each device; 0 of theory.
    estimates : dict of Estimates
        By the names of results.
    means : dict of ndarray
        Of the paths of each device, shape (devices,).
    nominal : dict of Estimate
        Of the device with the nominal values.
    warnings : tuple of str
    """

    system: System
    method: str
    settings: Settings | None
    numbers: tuple[str, ...]
    inputs: tuple[str, ...]
    draws: Floats
    paths: int
    estimates: dict[str, Estimates]
    means: dict[str, Floats]
    nominal: dict[str, Estimate]
    warnings: tuple[str, ...]

    def __getitem__(self, name: str) -> Estimates:
        return self.estimates[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.estimates)

    def __str__(self) -> str:
        return self.report()

    def report(self, *, warnings: bool = True) -> str:
        """All of it on a screen: ``+-`` is one standard error, and brackets hold with 95 %."""
        few = f"{len(self.inputs)} input{'s' if len(self.inputs) > 1 else ''}"
        each = f"{self.paths} paths each" if self.settings else f"by theory ({self.method})"
        lines = [f"Scatter of {few}: {len(self.draws)} devices, {each}. Brackets hold with 95 %."]
        for name, found in self.estimates.items():
            lines += ["", *self._of(name, found)]
        told = [f"warning: {each}" for each in self.warnings] if warnings else []
        return "\n".join([*lines, *([""] if told else []), *told])

    def to_dict(self) -> dict[str, Any]:
        """All but the draws, as plain numbers, strings, lists and dicts; NaN is None.

        Examples
        --------
        >>> import springpot as sp
        >>> device = sp.System(sp.Spring(sp.uncertain("k", 4.0, cov=0.1)), sp.Dashpot(0.5), sp.WhiteNoise(1.0))
        >>> [*sp.scatter(device, ["x_mean_square"], devices=64).to_dict()["x_mean_square"]][:3]
        ['nominal', 'mean', 'scatter']
        """
        results = {
            name: {
                "nominal": {end: getattr(self.nominal[name], end) for end in ("value", "error")},
                "mean": own.mean, "scatter": own.scatter, "path_scatter": own.path_scatter,
                "quantiles": own.quantiles, "tolerance": own.tolerance, "index": own.alone,
                "total_index": own.together, "unexplained": own.unexplained, "above": own.above,
            }
            for name, own in self.estimates.items()
        }  # fmt: skip
        about = {
            "numbers": self.numbers, "inputs": self.inputs, "devices": len(self.draws), "paths": self.paths,
            "method": self.method, "settings": self.settings.to_dict() if self.settings else None,
            "warnings": self.warnings,
        }  # fmt: skip
        return plain(results | about)

    def _of(self, name: str, found: Estimates) -> Iterator[str]:
        unit = unit_of_result(self.system, name)
        own = self.nominal[name]
        yield f"{name}, {unit}"
        yield f"  nominal device        {with_error(own.value, own.error)}"
        more, change = "", found.mean.value - own.value
        if abs(change) < 0.5 * abs(own.value):
            share = 100.0 * abs(change / own.value)
            more = f"   {share:.0f} % {'above' if change > 0.0 else 'below'} nominal"
        yield f"  mean over devices     {with_error(found.mean.value, found.mean.error)}{more}"
        if found.scatter.value == 0.0:
            yield f"  device to device      not seen: below {found.scatter.high:.3g}"
        else:
            part = found.scatter.value / abs(found.mean.value) if found.mean.value else math.inf
            words = f" ({100.0 * part:.0f} %)" if part < 10.0 else ""
            yield f"  device to device      {found.scatter.value:.3g}{words}, {_brackets(found.scatter)}"
            for at, quantile in found.quantiles.items():
                yield f"    {100.0 * at:4.3g} % of devices are below {quantile.value:.4g} {_brackets(quantile)}"
            yield f"    {100.0 * BELOW:4.0f} % of devices are below {found.tolerance:.4g}, 95 % sure"
        if self.settings is not None:
            length = self.settings.window[1] - self.settings.window[0]
            words = f"{found.path_scatter:.3g} in {length:.3g} s   averages out, does not count above"
            yield f"  path to path          {words}"
        for limit, share_above in found.above.items():
            yield f"  limit {limit:<16g}{_share(share_above)} of the devices are above"
        if found.alone:
            yield "  which input matters   alone                      with all others"
            wide = max(map(len, self.inputs))
            for each in sorted(self.inputs, key=lambda each: -found.together[each].value):
                yield f"    {each:{max(wide, 18)}}{_share(found.alone[each]):27}{_share(found.together[each])}"
            yield f"    {'not explained':{max(wide, 18)}}{_share(found.unexplained)}"

    def to_xarray(self) -> xarray.Dataset:
        """A dataset with the dimensions ``draw``, ``number``, ``input`` and ``probability``.

        ``value``, the values of the uncertain numbers, the means of the devices, and each result by its name:
        ``impact_rate`` is the mean over the devices, ``impact_rate_scatter`` their standard deviation,
        ``impact_rate_path_scatter`` that of the paths of one device, ``impact_rate_quantile``, ``impact_rate_index``
        and ``impact_rate_total_index``, each with ``_se``, ``_low`` and ``_high``.

        Raises
        ------
        MissingExtraError
            Without xarray.
        """
        need("files", "Scatter.to_xarray()")
        import numpy as np
        import xarray

        own: dict[str, object] = {"value": (("draw", "number"), self.draws)}

        def put(name: str, found: list[Interval], dims: tuple[str, ...], unit: str) -> None:
            for end, word in (("value", ""), ("error", "_se"), ("low", "_low"), ("high", "_high")):
                numbers = [getattr(each, end) for each in found]
                own[f"{name}{word}"] = (dims, np.array(numbers) if dims else numbers[0], {"units": unit})

        for name, found in self.estimates.items():
            unit = unit_of_result(self.system, name)
            own[f"{name}_of_draw"] = ("draw", self.means[name], {"units": unit})
            own[f"{name}_path_scatter"] = ((), found.path_scatter, {"units": unit})
            put(name, [found.mean], (), unit)
            put(f"{name}_scatter", [found.scatter], (), unit)
            put(f"{name}_quantile", [*found.quantiles.values()], ("probability",), unit)
            for word, indices in (("index", found.alone), ("total_index", found.together)):
                if indices:
                    put(f"{name}_{word}", [indices[each] for each in self.inputs], ("input",), "1")
        first = next(iter(self.estimates.values()))
        return xarray.Dataset(
            own, coords={"number": [*self.numbers], "input": [*self.inputs], "probability": [*first.quantiles]},
            attrs={"method": self.method, "paths": self.paths, "warnings": "\n".join(self.warnings)},
        )  # fmt: skip


def _brackets(found: Interval) -> str:
    return f"({found.low:.4g} to {found.high:.4g})"


def _share(found: Interval) -> str:
    return f"{100.0 * found.value:5.1f} % ({100.0 * found.low:.1f} to {100.0 * found.high:.1f})"
