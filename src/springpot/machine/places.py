"""Output files, which are checked before any work and never replaced without permission; files in a shell's words."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

from springpot.machine.arguments import checked_path, switch
from springpot.machine.platforms import WINDOWS


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
    place, name = checked_path(path, "path"), str(path)
    switch(overwrite, "overwrite")
    if not place.absolute().parent.is_dir():
        raise ValueError(f"{name!r} cannot be written: the folder {str(place.parent)!r} does not exist.")
    if place.exists() and not place.is_file():
        raise ValueError(f"{name!r} cannot be written: it is a folder or another thing that is not a file.")
    if place.exists() and not overwrite:
        raise ValueError(f"{name!r} exists already: give another name, or overwrite=True to replace it.")
    return place


def shell_word(path: str | Path) -> str:
    """A file's name as a person can copy it into a shell: quoted, on one line, and no flag.

    Examples
    --------
    >>> shell_word("device.toml"), shell_word("-device.toml")
    ('device.toml', './-device.toml')
    """
    name = str(path)
    name = f"./{name}" if name.startswith("-") else name
    if WINDOWS:  # where double quotes do in each shell, and no name has one
        return name if re.fullmatch(r"[\w.:\\/-]+", name, re.ASCII) else f'"{name}"'
    if name.isprintable():
        return shlex.quote(name)
    escaped = (
        letter if letter.isprintable() and letter not in "'\\" else "".join(f"\\x{byte:02x}" for byte in _bytes(letter))
        for letter in name
    )
    return f"$'{''.join(escaped)}'"  # of Bash, which has escapes


def _bytes(letter: str) -> bytes:
    return letter.encode("utf-8", "surrogateescape")
