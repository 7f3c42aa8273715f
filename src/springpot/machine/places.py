"""Output files: they are checked before any work, and never replaced without permission."""

from __future__ import annotations

from pathlib import Path


def place_for(path: str | Path, *, overwrite: bool = False) -> Path:
    """The path of an output file, if it may be written.

    Parameters
    ----------
    path : str or Path
    overwrite : bool
        Whether a file that is there may be replaced.

    Returns
    -------
    Path

    Raises
    ------
    ValueError
        If its folder does not exist, something else than a file is in its place, or a file is there and ``overwrite``
        was not given.

    Examples
    --------
    >>> import tempfile
    >>> place = Path(tempfile.mkdtemp()) / "run.nc"
    >>> place_for(place) == place
    True
    """
    place, name = Path(path), str(path)
    if not place.absolute().parent.is_dir():
        raise ValueError(f"{name!r} cannot be written: the folder {str(place.parent)!r} does not exist.")
    if place.exists() and not place.is_file():
        raise ValueError(f"{name!r} cannot be written: it is a folder or another thing that is not a file.")
    if place.exists() and not overwrite:
        raise ValueError(f"{name!r} exists already: give another name, or overwrite=True to replace it.")
    return place
