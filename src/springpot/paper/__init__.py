"""The paper's own figures and tables, "Stochastic response of a fractional vibroimpact system", made anew."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable, Iterable
from os import PathLike
from pathlib import Path
from typing import Literal

__all__ = ["reproduce"]

# Share of the whole in computing time, for one progress bar over all parts.
_SHARES = {"fig1": 0.01, "fig2": 0.87, "errata": 0.12}
_FILES = {
    "fig1": ("fig1.png",),
    "fig2": ("fig2.csv", "fig2.csv.record", "fig2.png", "fig2.md"),
    "errata": ("errata.md", "errata.png"),
}


def reproduce(
    what: Literal["fig1", "fig2", "errata", "all"],
    out: str | PathLike[str],
    progress: Callable[[float, str], None] | None = None,
    threads: int | None = None,
) -> list[Path]:
    """Reproduce a part of the paper, or all of it.

    Parameters
    ----------
    what : {"fig1", "fig2", "errata", "all"}
        ``"fig1"`` is the Fourier series, ``"fig2"`` the mean square amplitude with its Monte Carlo, ``"errata"`` a page
        of the slips in the print with the numbers that show them, and a picture of the main one.
    out : str or path
        Folder for the files; made where it does not exist.  The points of figure 2 are kept in ``fig2.csv.record`` as
        they come: an interrupted run leaves that file, and the others as they were, and the same call goes on from it.
    progress : callable, optional
        Called with the fraction done, from 0 to 1, and a line of text.
    threads : int, optional
        All processors by default.  ``"fig1"`` takes none: nothing is simulated.

    Returns
    -------
    list of Path
        The files written.

    Raises
    ------
    TypeError, ValueError
        If ``what`` is another word, ``out`` empty or not a path, or ``threads`` not a whole number from 1 to 4096, or
        given with ``"fig1"``.
    OSError
        If the folder cannot be made or written, ``out`` is a file, or a folder has the name of a file to be written.

    Examples
    --------
    >>> [path.name for path in reproduce("fig1", tempfile.mkdtemp())]
    ['fig1.png']
    """
    if what not in (*_SHARES, "all"):
        raise ValueError(f"what must be 'fig1', 'fig2', 'errata' or 'all', not {what!r}.")
    if what == "fig1" and threads is not None:
        raise ValueError("threads has no effect on fig1, the Fourier series: nothing is simulated.")
    from springpot.simulation.plan.settings import checked_threads

    threads = checked_threads(threads)
    parts = tuple(_SHARES) if what == "all" else (what,)
    folder = _writable(_folder(out), [name for part in parts for name in _FILES[part]])
    from springpot.paper import figures

    total = sum(_SHARES[part] for part in parts)
    written: list[Path] = []
    before = 0.0
    for part in parts:
        share = _SHARES[part] / total

        def report(fraction: float, text: str, before: float = before, share: float = share) -> None:
            if progress is not None:
                progress(before + share * fraction, text)

        how = {} if part == "fig1" else {"threads": threads, "progress": report}
        written += getattr(figures, part)(folder, **how)
        before += share
        report(1.0, f"{part} is done", before=before, share=0.0)
    return written


def _folder(out: str | PathLike[str]) -> Path:
    if not isinstance(out, str | PathLike) or not isinstance(os.fspath(out), str):
        raise TypeError(f"out must be the name of a folder, not {out!r}.")
    if not os.fspath(out):
        raise ValueError("out must name a folder, but it is empty; '.' is the current folder.")
    return Path(out)


def _writable(folder: Path, names: Iterable[str]) -> Path:
    """Make the folder and try it, before any long computation."""
    if folder.exists() and not folder.is_dir():
        raise NotADirectoryError(f"{str(folder)!r} is not a folder.")
    for name in names:
        if (folder / name).is_dir():
            raise IsADirectoryError(f"{str(folder / name)!r} is a folder, but a file of that name must be written.")
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise OSError(f"The folder {str(folder)!r} cannot be written: {error.strerror}.") from error
    return folder
