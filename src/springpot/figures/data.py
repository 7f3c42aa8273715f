"""The data of a picture, from runs or Datasets, and their system."""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias, cast

import numpy as np

from springpot.machine.arrays import Floats
from springpot.machine.faults import listed, shown
from springpot.problem.coordinates import Coordinates
from springpot.problem.dimensionless import Dimensionless
from springpot.problem.file import read_system
from springpot.theory import Result

if TYPE_CHECKING:
    import xarray

    from springpot.simulation import Run

Data: TypeAlias = "Run | xarray.Dataset"
Theory: TypeAlias = "Result | Iterable[Result]"


def as_dataset(data: Data) -> xarray.Dataset:
    """The Dataset of a Run; a Dataset itself stays as it is.

    Raises
    ------
    TypeError
        If it is neither.

    Examples
    --------
    >>> import springpot as sp
    >>> float(as_dataset(sp.simulate(sp.Oscillator(), paths=1, duration=1.0))["x_mean"]) > 0.0
    True
    """
    dataset: Any = data.to_xarray() if hasattr(data, "to_xarray") else data
    if not hasattr(dataset, "data_vars") or "system" not in dataset.attrs:
        raise TypeError(
            f"data must be what springpot.simulate returned, or its to_xarray(), not {type(data).__name__}."
        )
    return cast("xarray.Dataset", dataset)


def paper_of(data: xarray.Dataset) -> Dimensionless:
    """The paper's problem of a Dataset, read back from its attributes.

    Raises
    ------
    NotCoveredError
        If the Dataset is of another system.

    Examples
    --------
    >>> import springpot as sp
    >>> oscillator = sp.Oscillator(2.0, sp.Springpot(0.3, 0.5), sp.Barrier(-0.5, 0.8, "below"))
    >>> paper_of(as_dataset(sp.simulate(oscillator, paths=1, duration=1.0))).natural_frequency
    2.0
    """
    return Dimensionless.of(read_system(json.loads(data.attrs["system"])))


class Wall(NamedTuple):
    """A wall or a soft contact in a picture.

    Attributes
    ----------
    position : float
        In m.
    direction : float
        1 where the mass moves above it, otherwise -1.
    rigid : bool
    """

    position: float
    direction: float
    rigid: bool


def walls_of(data: xarray.Dataset, of: str = "") -> tuple[Wall, ...]:
    """The walls and contacts of a Dataset; of several masses those of the displacement ``of``, as in `recorded`.

    Examples
    --------
    >>> import springpot as sp
    >>> walls = sp.Barrier(-1.0), sp.Barrier(2.0, free_side="below")
    >>> hardening = sp.PolynomialSpring((0.0, 0.0, 0.2))
    >>> slot = sp.System(sp.Spring(1.0), hardening, sp.Dashpot(0.1), sp.WhiteNoise(1.0), *walls)
    >>> [wall.position for wall in walls_of(as_dataset(sp.simulate(slot, paths=1, duration=1.0, start="rest")))]
    [-1.0, 2.0]
    """
    at, row = _seen(data, of)
    stops = ((part, at.row(part.get("between"))) for part in _stops(data).values())
    return tuple(
        Wall(sign * part["position"], sign * (1.0 if part["free_side"] == "above" else -1.0), part["kind"] == "barrier")
        for part, own in stops
        if np.array_equal(np.abs(own), np.abs(row)) and (sign := float(np.sign(row @ own)))
    )


def _parts(data: xarray.Dataset) -> list[dict[str, Any]]:
    """As the system is stated, which may have functions that cannot be read."""
    return cast(list[dict[str, Any]], json.loads(data.attrs["system"])["parts"])


def _stops(data: xarray.Dataset) -> dict[str, dict[str, Any]]:
    return {part["name"]: part for part in _parts(data) if part["kind"] in ("barrier", "contact")}


def _seen(data: xarray.Dataset, of: str) -> tuple[Coordinates, Floats]:
    """The points of the paths as coordinates, and the row of numbers by which a displacement is made of theirs.

    Raises
    ------
    ValueError
        If there is neither a mass nor such a part of this name.
    """
    parts = _parts(data)
    masses, others = (tuple(p["at"] for p in parts if p["kind"] == kind and p.get("at")) for kind in ("mass", "point"))
    ends = {part["name"]: tuple(part["between"]) for part in parts if part.get("between")}
    at = replace(Coordinates.of_masses((*(masses or ("mass",)), *others)), ends=ends)  # paths have every point
    if of in (rows := {name: at.row(pair) for name, pair in ends.items()} | at.called):
        return at, rows[of]
    known = [*at.points, *ends]
    said = f", not {shown(of)}" if of else " where there are several masses"
    raise ValueError(f"of must be {'one of ' if len(known) > 1 else ''}{listed([*known], 'or')}{said}.")


def recorded(data: Data, of: str = "") -> tuple[xarray.Dataset, Floats, Floats, Floats]:
    """Dataset, times (n,), x and v (paths, n) of the recorded paths.

    Parameters
    ----------
    data : Run or xarray.Dataset
    of : str
        Of several masses: the mass whose displacement it is, or the part whose elongation it is.

    Raises
    ------
    TypeError, ValueError
        If it is not a run, or a run without recorded paths, or there is no such mass or part.
    """
    dataset = as_dataset(data)
    if "x" not in dataset:
        raise ValueError("data must hold recorded paths: simulate with record= a number of paths.")
    x, v = (np.asarray(dataset[name], dtype=float) for name in ("x", "v"))
    _, row = _seen(dataset, of)
    if len(row) > 1:
        x, v = x @ row, v @ row
    return dataset, np.asarray(dataset["time"], dtype=float), x, v


def result_of(data: xarray.Dataset, quantity: str, of: str = "") -> str:
    """The name of a quantity in the results: of one mass its own, of several that of a mass, a pair or a wall.

    Parameters
    ----------
    data : xarray.Dataset
    quantity : {"x", "v", "amplitude", "impact_speed"}
    of : str
        As in `recorded`; of an impact speed the wall.

    Raises
    ------
    ValueError
        If there is no such mass or part, or it has no such result.

    Examples
    --------
    >>> import springpot as sp
    >>> masses = sp.Mass(1.0, at="box"), sp.Mass(2.0, at="panel")
    >>> legs = (sp.Spring(1.0, between=("ground", end)) for end in ("box", "panel"))
    >>> pair = sp.System(*masses, *legs, mount=sp.Spring(1.0, between=("panel", "box")))
    >>> data = sp.simulate(pair, paths=1, duration=1.0, start="rest").to_xarray()
    >>> result_of(data, "v", "box"), result_of(data, "x", "mount")
    ('box_v', 'panel_box_elongation')
    """
    at, row = _seen(data, of)
    of_points = {own: each for own, each in at.beginnings.items() if quantity in ("x", "v") or not own}
    rows = {f"{own}{quantity}": each for own, each in of_points.items()}
    rows |= {f"{pair}_elongation": each for pair, each in at.pairs.items() if quantity == "x"}
    if found := [name for name, each in rows.items() if np.array_equal(each, row)]:
        return found[0]
    if quantity == "impact_speed" and of in _stops(data):
        return f"{of}_impact_speed"
    raise ValueError(f"data holds no {quantity} of {of}.")


def error_of_mean(values: Floats) -> Floats:
    """The standard error of the mean over the first axis, independent paths; NaN of a single one.

    Examples
    --------
    >>> error_of_mean(np.array([[0.0], [2.0]])), error_of_mean(np.array([[0.0]]))
    (array([1.]), array([nan]))
    """
    count = len(values)
    return values.std(axis=0, ddof=1) / np.sqrt(count) if count > 1 else np.full(values.shape[1], np.nan)


def spacing_in_steps(data: Data) -> int:
    """Steps between two recorded points of a path.

    Examples
    --------
    >>> import springpot as sp
    >>> spacing_in_steps(sp.simulate(sp.Oscillator(), paths=1, duration=1.0, record=1, record_every=5))
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
    given = (theory,) if isinstance(theory, Result) else tuple(theory)
    for each in given:
        if not isinstance(each, Result):
            raise TypeError(f"theory must be a result such as springpot.theory.envelope(system), not {shown(each)}.")
    return given
