"""What `springpot.fragility` returns."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import betaincinv

from springpot.machine.arguments import finite_numbers
from springpot.machine.arrays import Floats
from springpot.machine.faults import name_results
from springpot.machine.installed import need
from springpot.machine.plain import plain
from springpot.scattering.estimates import Interval
from springpot.spectra.lognormal import Fit

if TYPE_CHECKING:
    import xarray

_CHANCE = 0.025


def _none() -> Floats:
    return np.zeros(0)


@dataclass(frozen=True, eq=False)
class FragilityCurve:
    """The probability that one limit is exceeded, against the intensity.

    Attributes
    ----------
    label, output : str
    limit : float
    unit : str
        Of the output.
    kind : {"capacities", "counts", "cloud", "splitting"}
        What was fitted.
    fit : Fit
    intensities : ndarray, shape (stripes,)
        Empty of a cloud.
    exceeded, tried : ndarray, shape (stripes,)
        How many of how many paths; empty of a cloud and of splitting.
    known : ndarray, shape (3, stripes)
        Of splitting the probabilities and the ends of their intervals, else empty.
    places, demands : ndarray, shape (stripes, paths)
        Intensity and largest value of each path; empty of splitting.
    """

    label: str
    output: str
    limit: float
    unit: str
    kind: str
    fit: Fit
    intensities: Floats
    exceeded: Any = field(default_factory=_none)
    tried: Any = field(default_factory=_none)
    known: Floats = field(default_factory=_none)
    places: Floats = field(default_factory=_none)
    demands: Floats = field(default_factory=_none)

    @property
    def median(self) -> Interval:
        """Of the intensities at which the limit is exceeded, with its standard error and 95 % interval."""
        return self.fit.median

    @property
    def dispersion(self) -> Interval:
        """The standard deviation of their logarithm."""
        return self.fit.dispersion

    def probability(self, intensity: ArrayLike) -> Floats:
        """Of exceeding the limit at intensities.

        Examples
        --------
        >>> from springpot.spectra.lognormal import fit_counts
        >>> three = np.array([1.0, 2.0, 4.0])
        >>> fit = fit_counts(three, np.array([2.0, 10.0, 18.0]), np.full(3, 20.0))
        >>> curve = FragilityCurve("", "displacement", 0.1, "m", "counts", fit, three, np.array([2, 10, 18]),
        ...                        np.full(3, 20), np.zeros((3, 0)), three, three)
        >>> curve.probability([2.0, 4.0]).round(2).tolist()
        [0.5, 0.9]
        """
        return self.fit.probability(_positive(intensity))

    def band(self, intensity: ArrayLike) -> tuple[Floats, Floats]:
        """The ends of a 95 % interval of the probability, at each intensity alone."""
        return self.fit.band(_positive(intensity))

    @property
    def shares(self) -> tuple[Floats, Floats, Floats]:
        """Of each stripe the share that exceeds the limit, with the ends of its exact 95 % interval."""
        if self.known.size:
            return self.known[0], self.known[1], self.known[2]
        k, n = np.asarray(self.exceeded, float), np.asarray(self.tried, float)
        low = np.where(k > 0.0, betaincinv(np.maximum(k, 1.0), n - k + 1.0, _CHANCE), 0.0)
        high = np.where(k < n, betaincinv(k + 1.0, np.maximum(n - k, 1.0), 1.0 - _CHANCE), 1.0)
        return k / n, low, high


def _positive(intensity: ArrayLike) -> Floats:
    return finite_numbers(intensity, "intensity", "intensity", low=0.0, open_low=True)


@dataclass(frozen=True, eq=False)
class Fragility:
    """Fragility curves; made by `springpot.fragility`.

    Attributes
    ----------
    curves : dict of FragilityCurve
        By the output, or by output and limit where there are several limits of one.
    intensities : ndarray or None
        The stripes; None of a cloud.
    method : {"plain", "splitting"}
    warnings : tuple of str
    """

    curves: dict[str, FragilityCurve]
    intensities: Floats | None
    method: str
    warnings: tuple[str, ...]

    def __post_init__(self) -> None:
        name_results(self, "curves")

    def __getitem__(self, label: str) -> FragilityCurve:
        """One curve; of an unknown name the error says which one was probably meant."""
        return self.curves[label]

    def __iter__(self) -> Iterator[str]:
        return iter(self.curves)

    def __repr__(self) -> str:
        """What it holds; printed, it shows its numbers."""
        return f"Fragility({', '.join(self.curves)})"

    def __str__(self) -> str:
        return "\n".join(self._lines())

    def _lines(self) -> Iterator[str]:
        for own in self.curves.values():
            unit = f" {own.unit}" if own.unit not in ("", "1") else ""
            yield f"{own.output} > {own.limit:g}{unit}, lognormal, fitted to {own.kind}; brackets hold with 95 %"
            for name, found in (("median", own.median), ("dispersion", own.dispersion)):
                yield f"  {name:12}{found.value:<10.4g} ({found.low:.4g} to {found.high:.4g})"
            if own.intensities.size:
                yield f"  {'intensity':>12} {'exceeded':>12} {'share':>10} {'':22} {'fitted':>10}"
                counts = [f"{k} of {n}" for k, n in zip(own.exceeded, own.tried, strict=True)]
                columns = own.intensities, *own.shares, own.probability(own.intensities)
                for n, (place, share, low, high, p) in enumerate(zip(*columns, strict=True)):
                    count = counts[n] if counts else ""
                    yield f"  {place:12.5g} {count:>12} {share:10.3g} {f'({low:.3g} to {high:.3g})':22} {p:10.3g}"
            else:
                yield f"  {own.demands.size} records, {int((own.demands > own.limit).sum())} beyond the limit"
            yield ""
        for sentence in self.warnings:
            yield f"warning: {sentence}"

    def to_dict(self) -> dict[str, Any]:
        """Its numbers as plain ones; what is not finite is None."""
        names = "output", "limit", "unit", "kind", "intensities", "exceeded", "tried", "median", "dispersion"
        curves = {label: {name: getattr(own, name) for name in names} for label, own in self.curves.items()}
        return plain({"curves": curves, "method": self.method, "warnings": self.warnings})

    def to_xarray(self) -> xarray.Dataset:
        """A dataset with the dimensions ``curve`` and, of stripes, ``intensity``.

        ``median`` and ``dispersion`` have the ends of their intervals as ``_low`` and ``_high``; ``share`` is that of
        the paths beyond the limit, with ``_low`` and ``_high``, and ``probability`` the fitted one.

        Raises
        ------
        MissingExtraError
            Without xarray.
        """
        need("files", "Fragility.to_xarray()")
        import xarray

        own = [*self.curves.values()]
        found: dict[str, Any] = {"limit": ("curve", [each.limit for each in own])}
        for name in ("median", "dispersion"):
            for end, word in (("value", ""), ("error", "_se"), ("low", "_low"), ("high", "_high")):
                found[f"{name}{word}"] = ("curve", [getattr(getattr(each, name), end) for each in own])
        coords: dict[str, Any] = {"curve": [*self.curves]}
        if self.intensities is not None:
            coords["intensity"] = self.intensities
            shares = np.array([each.shares for each in own])
            for n, word in enumerate(("", "_low", "_high")):
                found[f"share{word}"] = (("curve", "intensity"), shares[:, n])
            fitted = np.array([each.probability(self.intensities) for each in own])
            found["probability"] = (("curve", "intensity"), fitted)
        return xarray.Dataset(found, coords=coords, attrs={"warnings": "\n".join(self.warnings)})
