"""What `springpot.response_spectrum` returns."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from springpot.machine.arrays import Floats
from springpot.machine.faults import name_results
from springpot.machine.installed import need
from springpot.machine.plain import plain
from springpot.problem.system import System

if TYPE_CHECKING:
    import xarray


@dataclass(frozen=True, eq=False)
class Spectrum:
    """The largest values of one output.

    Attributes
    ----------
    name, unit : str
    values : ndarray, shape (periods, records)
        Of each record, or of each path of noise; none of theory.
    errors : ndarray, shape (periods, records)
        Bounds on what the step leaves in them; under noise how far they are off at twice the step, with the same
        noise.  NaN under noise with an envelope, which is another one at another step.
    shares : tuple of float
        Of the records or paths below the quantiles.
    quantiles, low, high : ndarray, shape (shares, periods)
        With the ends of their 95 % intervals: 0 or infinite where there are too few records, NaN of theory, which has
        no records.
    rms : ndarray of shape (periods,) or None
        Of stationary noise by theory, about the mean.
    """

    name: str
    unit: str
    values: Floats
    errors: Floats
    shares: tuple[float, ...]
    quantiles: Floats
    low: Floats
    high: Floats
    rms: Floats | None

    @property
    def middle(self) -> Floats:
        """The values of a single record, else the quantile nearest to the median."""
        if self.values.shape[1] == 1:
            return np.asarray(self.values[:, 0])
        return np.asarray(self.quantiles[int(np.argmin(np.abs(np.array(self.shares) - 0.5)))])


@dataclass(frozen=True, eq=False)
class ResponseSpectrum:
    """Response spectra of records or noise; made by `springpot.response_spectrum`.

    Attributes
    ----------
    periods : ndarray
        In s.
    outputs : dict of Spectrum
        By name; ``found["acceleration"]`` is one of them.
    kind : {"maximax", "primary", "residual"}
    method : {"exact", "kernel", "theory"}
        How they were computed.
    systems : tuple of System
        Of each period, with the excitation.
    damping : float or None
    shares : tuple of float
        Of the quantiles.
    warnings : tuple of str
    """

    periods: Floats
    outputs: dict[str, Spectrum]
    kind: str
    method: str
    systems: tuple[System, ...]
    damping: float | None
    shares: tuple[float, ...]
    warnings: tuple[str, ...]

    def __post_init__(self) -> None:
        name_results(self, "outputs")

    def __getitem__(self, name: str) -> Spectrum:
        """One output; of an unknown name the error says which one was probably meant."""
        return self.outputs[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.outputs)

    @property
    def frequencies(self) -> Floats:
        """One over the periods, in Hz."""
        return np.asarray(1.0 / self.periods)

    def __repr__(self) -> str:
        """What it holds; printed, it is a table."""
        return f"ResponseSpectrum({', '.join(self.outputs)} at {self.periods.size} periods, {self.method})"

    def __str__(self) -> str:
        return "\n".join(self._lines())

    def _lines(self) -> Iterator[str]:
        records = next(iter(self.outputs.values())).values.shape[1]
        how = {"exact": "exact", "kernel": "by the compiled kernel", "theory": "by theory"}[self.method]
        word = "record" if self.systems[0].records else "path"
        many = f"{records} {word}{'s' * (records > 1)}" if records else "stationary noise"
        yield f"Response spectrum ({self.kind}) at {self.periods.size} periods, {many}, {how}."
        for own in self.outputs.values():
            yield ""
            yield f"{own.name}, {own.unit}"
            if records == 1:
                yield f"{'period s':>12} {'frequency Hz':>13} {'largest':>12} {'error':>10}"
                for period, value, error in zip(self.periods, own.values[:, 0], own.errors[:, 0], strict=True):
                    yield f"{period:12.5g} {1.0 / period:13.5g} {value:12.5g} {error:10.2g}"
                continue
            heads = "".join(f"{f'{100.0 * share:.4g} %':>12}{'':25}" for share in own.shares)
            yield f"{'period s':>12} {'frequency Hz':>13}" + (f"{'rms':>12}" if own.rms is not None else "") + heads
            for n, period in enumerate(self.periods.tolist()):
                line = f"{period:12.5g} {1.0 / period:13.5g}"
                line += f"{own.rms[n]:12.5g}" if own.rms is not None else ""
                for middle, low, high in zip(own.quantiles[:, n], own.low[:, n], own.high[:, n], strict=True):
                    between = f"({low:.4g} to {high:.4g})" if math.isfinite(low) else ""
                    line += f"{middle:12.5g} {between:24}"
                yield line.rstrip()
        for sentence in self.warnings:
            yield f"warning: {sentence}"

    def to_dict(self) -> dict[str, Any]:
        """All of it but the systems, as plain numbers, words, lists and dicts; what is not finite is None."""
        names = "unit", "values", "errors", "quantiles", "low", "high", "rms"
        outputs = {name: {each: getattr(own, each) for each in names} for name, own in self.outputs.items()}
        about = "periods", "kind", "method", "damping", "shares", "warnings"
        return plain({**{name: getattr(self, name) for name in about}, "outputs": outputs})

    def to_xarray(self) -> xarray.Dataset:
        """A dataset with the dimensions ``period``, ``record`` and ``probability``.

        ``acceleration`` has the values of each record, ``acceleration_error`` what the step leaves in them,
        ``acceleration_quantile`` the quantiles with ``_low`` and ``_high``, and ``acceleration_rms`` that of theory.

        Raises
        ------
        MissingExtraError
            Without xarray.
        """
        need("files", "ResponseSpectrum.to_xarray()")
        import xarray

        found: dict[str, Any] = {}
        for name, own in self.outputs.items():
            units = {"units": own.unit}
            if own.values.size:
                found[name] = (("period", "record"), own.values, units)
                found[f"{name}_error"] = (("period", "record"), own.errors, units)
            for word, numbers in (("", own.quantiles), ("_low", own.low), ("_high", own.high)):
                found[f"{name}_quantile{word}"] = (("probability", "period"), numbers, units)
            if own.rms is not None:
                found[f"{name}_rms"] = ("period", own.rms, units)
        return xarray.Dataset(
            found,
            coords={"period": ("period", self.periods, {"units": "s"}), "probability": [*self.shares]},
            attrs={"kind": self.kind, "method": self.method, "warnings": "\n".join(self.warnings)},
        )
