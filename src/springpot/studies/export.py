"""A store written as netCDF, as a Zarr group that any xarray opens, or as a table."""

from __future__ import annotations

import math
import os
import shutil
from pathlib import Path

from springpot.machine.arguments import check_folder
from springpot.machine.files import netcdf_of, write
from springpot.problem.numbers import label_of
from springpot.studies.dataset import Results, result_columns, to_xarray
from springpot.studies.labelled import to_zarr
from springpot.studies.store import Store, is_store, whole_folder


def export(store: Store, path: str | Path, *, overwrite: bool = False) -> Path:
    """Write all results of a store to one file or folder.

    Parameters
    ----------
    store : Store
    path : str or Path
        Ends in ``.nc`` (netCDF 4, groups ``theory`` and ``simulation``), ``.zarr`` (a folder: the same as a Zarr group)
        or ``.csv`` (a row for each point and method).
    overwrite : bool
        Whether to replace an existing file, or a Zarr group that is not a store of a study.

    Returns
    -------
    Path

    Raises
    ------
    ValueError
        If the name ends otherwise, or exists already.
    OSError
        If it cannot be written.
    """
    path = Path(path)
    if path.suffix not in (".nc", ".zarr", ".csv"):
        raise ValueError(
            f"the file to export to must end in .nc (netCDF), .zarr (a Zarr group) or .csv, not {path.name!r}."
        )
    check_folder(path, "the file to export to")
    _check_replaced(path, overwrite)
    if path.suffix == ".nc":
        write(str(path), netcdf_of(to_xarray(store)))
    elif path.suffix == ".csv":
        write(str(path), _table(store).encode())
    else:
        with whole_folder(path) as partial:
            to_zarr(to_xarray(store), partial)
            if path.is_dir():
                shutil.rmtree(path)
    return path


def _check_replaced(path: Path, overwrite: bool) -> None:
    """Raise an error unless ``path`` may be written."""
    if not os.path.lexists(path):
        return
    what = str(path)
    if path.suffix == ".zarr":
        if is_store(path):
            raise ValueError(f"{what!r} is the store of a study, which export does not replace: give another name.")
        if not (path / "zarr.json").is_file():
            raise ValueError(f"{what!r} exists and is not a Zarr group: give another name, or remove it first.")
    elif path.is_dir():
        raise ValueError(f"{what!r} is a folder: give another name, or remove it first.")
    if not overwrite:
        raise ValueError(f"{what!r} exists already: give another name, or --overwrite (overwrite=True) to replace it.")


def _table(store: Store) -> str:
    """One row for each point and method: numbers at full precision, empty cells for NaN."""
    import pandas

    study = store.study
    columns = [*result_columns(study, *study.methods)]
    rows = []
    for method in study.methods:
        answers = Results(store, method)
        for point, answer in zip(study.points(), answers.all, strict=True):
            cells = (answer.numbers.get(name, math.nan) if answer else math.nan for name in columns)
            end = (1, answer.said) if answer else (0, "")
            rows.append([method, *(point[name] for name in study.columns), *cells, *end])
    names = ["method", *map(label_of, study.columns), *columns, "done", "said"]
    return str(pandas.DataFrame(rows, columns=names).to_csv(index=False))
