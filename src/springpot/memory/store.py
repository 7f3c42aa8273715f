"""Cache of exponential sums on disk, each in a small file named by the digest of its arguments.

The folder is SPRINGPOT_CACHE_DIR, or else the user's cache folder; it may be deleted at any time.  A
file is written under another name and then renamed, so that it is never read half-written.  It is used only if no other
user can have written it (:mod:`springpot.machine.trusted`) and its digest and arguments are right; the caller also
compares the sum with the kernel (:mod:`springpot.memory.exponential_sum`).  If a file cannot be used, the sum is
computed again.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from platformdirs import user_cache_dir

from springpot.machine.arrays import Floats
from springpot.machine.files import write
from springpot.machine.trusted import make_folder, read, reason_against, say_unused

Key = Mapping[str, str | float]
_LARGEST = 1 << 20  # bytes of a file; a sum takes a few kB


def folder() -> Path | None:
    """The folder of the cache, or None if the user has no home folder.

    Examples
    --------
    >>> import os
    >>> os.environ["SPRINGPOT_CACHE_DIR"] = "/some/where"
    >>> folder().as_posix()
    '/some/where/memory'
    >>> del os.environ["SPRINGPOT_CACHE_DIR"]
    """
    try:
        return Path(os.environ.get("SPRINGPOT_CACHE_DIR") or user_cache_dir("springpot", appauthor=False)) / "memory"
    except RuntimeError:
        return None


def load(key: Key) -> tuple[Floats, Floats, float] | None:
    """Rates, weights and relative error saved under this key, with the same bits, or None."""
    if (place := _place(key)) is None:
        return None
    if reason := reason_against(place.parent):
        say_unused(
            "The exponential sums of the memory are not stored, and each is computed again in about 0.1 s, because "
            f"{reason}. Set SPRINGPOT_CACHE_DIR to a folder that only you can write."
        )
        return None
    if (text := read(place, _LARGEST)) is None:
        return None
    try:
        kept = json.loads(text)
        content = kept["content"]
        if kept["digest"] != _digest(content) or content["key"] != key:
            return None
        rates, weights = (np.array(content[name], np.float64) for name in ("rates", "weights"))
        return rates, weights, float(content["relative_error"])
    except (ValueError, TypeError, KeyError, OverflowError, RecursionError):  # not written by `save`
        return None


def save(key: Key, rates: Floats, weights: Floats, relative_error: float) -> None:
    """Save a sum, if the folder can be written."""
    if (place := _place(key)) is None:
        return
    content = {
        "key": dict(key), "rates": rates.tolist(), "weights": weights.tolist(), "relative_error": relative_error,
    }  # fmt: skip
    body = json.dumps({"content": content, "digest": _digest(content)}).encode()
    with contextlib.suppress(OSError):
        make_folder(place.parent)
        write(str(place), body, private=True)


def _place(key: Key) -> Path | None:
    where = folder()
    return None if where is None else where / f"{_digest(dict(key))}.json"


def _digest(content: object) -> str:
    # Python writes the shortest decimal that reads back as the same double: equal text, equal bits
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()
