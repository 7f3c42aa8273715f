"""What a picture is made of: runs and Datasets alike, and the oscillator they belong to."""

from __future__ import annotations

import json
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, TypeAlias, cast

import numpy as np
from numpy.typing import NDArray

from springpot.oscillator import Oscillator
from springpot.theory import Result

if TYPE_CHECKING:
    import xarray

    from springpot.simulation import Run

__all__ = ["Data", "FloatArray", "Theory", "as_dataset", "oscillator_of", "recorded", "results", "spacing_in_steps"]

Data: TypeAlias = "Run | xarray.Dataset"
Theory: TypeAlias = "Result | Iterable[Result]"
FloatArray = NDArray[np.float64]


def as_dataset(data: Data) -> xarray.Dataset:
    """What `springpot.simulate` returns, made from what `springpot.run` returns if need be.

    Raises
    ------
    TypeError
        If it is neither.

    Examples
    --------
    >>> import springpot as sp
    >>> float(as_dataset(sp.run(sp.Oscillator(), paths=1, duration=1.0))["x_mean"]) > 0.0
    True
    """
    made: Any = data.to_dataset() if hasattr(data, "to_dataset") else data
    if not hasattr(made, "data_vars") or "oscillator" not in made.attrs:
        raise TypeError(f"data must be what springpot.run or springpot.simulate returned, not {type(data).__name__}.")
    return cast("xarray.Dataset", made)


def oscillator_of(data: xarray.Dataset) -> Oscillator:
    """The oscillator of a Dataset, read back from its attributes.

    Examples
    --------
    >>> import springpot as sp
    >>> asked = sp.Oscillator(2.0, sp.Springpot(0.3, 0.5), sp.Barrier(-0.5, 0.8, "below"))
    >>> oscillator_of(as_dataset(sp.run(asked, paths=1, duration=1.0))) == asked
    True
    """
    return Oscillator.from_dict(json.loads(data.attrs["oscillator"]))


def recorded(data: Data) -> tuple[Oscillator, FloatArray, FloatArray, FloatArray]:
    """Oscillator, times (n,), x and v (paths, n) of the recorded paths.

    Raises
    ------
    TypeError, ValueError
        If it is no run, or a run without recorded paths.
    """
    found = as_dataset(data)
    if "x" not in found:
        raise ValueError("data must hold recorded paths: simulate with record= a number of paths.")
    x, v = (np.asarray(found[name], dtype=float) for name in ("x", "v"))
    return oscillator_of(found), np.asarray(found["time"], dtype=float), x, v


def spacing_in_steps(data: Data) -> int:
    """Steps between two recorded points of a path.

    Examples
    --------
    >>> import springpot as sp
    >>> spacing_in_steps(sp.run(sp.Oscillator(), paths=1, duration=1.0, record=1, record_every=5))
    5
    """
    return int(json.loads(as_dataset(data).attrs["settings"])["record_every"])


def results(theory: Theory) -> tuple[Result, ...]:
    """One result of the theory or several, as a tuple.

    Raises
    ------
    TypeError
        If there is anything else among them.
    """
    found = (theory,) if isinstance(theory, Result) else tuple(theory)
    for each in found:
        if not isinstance(each, Result):
            raise TypeError(f"theory must be a result such as springpot.theory.envelope(oscillator), not {each!r}.")
    return found
