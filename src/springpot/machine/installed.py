"""What is installed: this library's version, those of others, and the extras, which only some installations have; and
names of packages that are loaded at first use.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from importlib import import_module
from importlib.util import find_spec
from typing import Any

from springpot.machine.faults import listed

__version__ = "0.2.0"

_FILES = ("h5netcdf", "h5py", "pandas", "xarray")
_STUDIES = ("pydantic", "zarr", *_FILES)
EXTRAS = {
    "files": _FILES,
    "plots": ("matplotlib", *_FILES),
    "studies": _STUDIES,
    "cluster": ("distributed", *_STUDIES),
    "page": ("pydantic", "starlette", "uvicorn", "websockets"),
    "uff": ("pyuff",),
    "op4": ("pyyeti",),
}
"""What each extra of ``pyproject.toml`` installs, by its names in Python."""


class MissingExtraError(ImportError):
    """A library that only some uses need is not installed; the message has the command that installs it."""


def need(extra: str, what: str) -> None:
    """Check, before work, that what an extra brings is installed.

    Parameters
    ----------
    extra : str
        One of EXTRAS.
    what : str
        Which use needs it, as the subject of the sentence.

    Raises
    ------
    MissingExtraError
        If it is not installed.

    Examples
    --------
    >>> need("files", "run.to_xarray()")
    """
    if missing := [name for name in EXTRAS[extra] if find_spec(name) is None]:
        raise MissingExtraError(
            f"{what} needs {listed(missing)}, not installed here: "
            f'python3 -m pip install "springpot[{extra}]" adds what is missing.'
        )


def versions(*names: str) -> dict[str, str]:
    """The versions of this library and of others that are installed, by name.

    Raises
    ------
    importlib.metadata.PackageNotFoundError
        If one is not installed.

    Examples
    --------
    >>> list(versions("numba", "numpy"))
    ['springpot', 'numba', 'numpy']
    """
    found = {"springpot": __version__}
    for name in names:
        if name in sys.modules:
            found[name] = sys.modules[name].__version__
            continue
        from importlib.metadata import version  # slow to import, and runs need none of it

        found[name] = version(name)
    return found


def loaded_later(package: str, places: Mapping[str, Sequence[str]]) -> Callable[[str], Any]:
    """What a package takes as its ``__getattr__``, so that commands start fast: names by the module that has them.

    Examples
    --------
    >>> loaded_later("springpot.machine", {"installed": ["need"]})("need") is need
    True
    """

    def named(name: str) -> Any:
        for module, names in places.items():
            if name in names:
                return getattr(import_module(f"{package}.{module}"), name)
        raise AttributeError(f"module {package!r} has no attribute {name!r}")

    return named
