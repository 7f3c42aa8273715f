"""The version of this library, and those of others that its numbers depend on."""

from __future__ import annotations

import sys

__all__ = ["__version__", "versions"]

__version__ = "0.2.0"


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
