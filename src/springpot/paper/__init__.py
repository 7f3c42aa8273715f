"""The paper's own figures and tables, "Stochastic response of a fractional vibroimpact system", made anew."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from os import PathLike
from pathlib import Path
from typing import Literal

__all__ = ["reproduce"]

# Share of the whole in computing time, for one progress bar over all parts.
_SHARES = {"fig1": 0.01, "fig2": 0.87, "errata": 0.12}


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
        Folder for the files; made where it does not exist.
    progress : callable, optional
        Called with the fraction done, from 0 to 1, and a line of text.
    threads : int, optional
        All processors by default.

    Returns
    -------
    list of Path
        The files written.

    Raises
    ------
    TypeError, ValueError
        If ``what`` is another word or ``threads`` not a whole number from 1 to 4096.
    OSError
        If the folder cannot be made or written.

    Examples
    --------
    >>> [path.name for path in reproduce("fig1", tempfile.mkdtemp())]
    ['fig1.png']
    """
    if what not in (*_SHARES, "all"):
        raise ValueError(f"what must be 'fig1', 'fig2', 'errata' or 'all', not {what!r}.")
    from springpot.simulation.settings import checked_threads

    threads = checked_threads(threads)
    folder = _writable(Path(out))
    from springpot.paper import figures

    parts = tuple(_SHARES) if what == "all" else (what,)
    total = sum(_SHARES[part] for part in parts)
    written: list[Path] = []
    before = 0.0
    for part in parts:
        share = _SHARES[part] / total

        def report(fraction: float, text: str, before: float = before, share: float = share) -> None:
            if progress is not None:
                progress(before + share * fraction, text)

        if part == "fig1":
            written += figures.fig1(folder)
        elif part == "fig2":
            written += figures.fig2(folder, threads=threads, progress=report)
        else:
            written += figures.errata(folder, threads=threads, progress=report)
        before += share
        report(1.0, f"{part} is done", before=before, share=0.0)
    return written


def _writable(folder: Path) -> Path:
    """Make the folder and try it, before any long computation."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise OSError(f"The folder {str(folder)!r} cannot be written: {error.strerror}.") from error
    return folder
