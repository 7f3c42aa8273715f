"""Libraries that only some installations have: the extras of ``pyproject.toml``, and the error where one is missing."""

from __future__ import annotations

from importlib.util import find_spec

from springpot.machine.faults import listed

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
"""What each extra installs, by its names in Python."""


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
