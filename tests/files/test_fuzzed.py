"""Damaged files: one sentence of this library, soon, or numbers that are those of the file but for what was damaged."""

from __future__ import annotations

import random
import time
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import springpot as sp
from springpot.machine.faults import FileError
from tests.files.dialects import DIALECTS, Dialect
from tests.files.test_dialects import NAMES, READERS, numbers_of
from tests.sizes import validation

SECONDS = 5.0  # that one file may take
LONGEST = 2000  # characters of a sentence
SIGNS = "0123456789.,;-+eED \t\n#%/\"'()[]_xXgsmHz=\x00\x1aé²"
TOUCHED = 4  # rows that a change of one or two lines may change


def changed(text: str, rng: random.Random) -> str:
    """A sign or two, a cell, a separator or a line that is another, is missing, or is there twice."""
    at = rng.randrange(len(text))
    kind = rng.randrange(10)
    if kind == 0:
        return text[:at] + rng.choice(SIGNS) + text[at + 1 :]
    if kind == 1:
        return text[:at] + text[at + 1 :]
    if kind == 2:
        return text[:at] + rng.choice(SIGNS) + text[at:]
    if kind == 3:
        return text[:at] + text[at + 1 : at + 2] + text[at : at + 1] + text[at + 2 :]
    if kind == 4:
        return text[:at]
    lines = text.splitlines(keepends=True)
    n = rng.randrange(len(lines))
    marks = [mark for mark in ",;\t ." if mark in lines[n]]
    if kind == 5:
        del lines[n]
    elif kind == 6:
        lines.insert(n, lines[n])
    elif kind == 7 and marks:
        lines[n] = lines[n].replace(rng.choice(marks), rng.choice(",;\t .|"))
    elif kind == 8 and marks:
        cells = lines[n].split(mark := rng.choice(marks))
        del cells[rng.randrange(len(cells))]
        lines[n] = mark.join(cells)
    else:
        m = rng.randrange(len(lines))
        lines[n], lines[m] = lines[m], lines[n]
    return "".join(lines)


def damaged(content: bytes, rng: random.Random) -> bytes:
    """With one change, now and then with two; a file that is no text in its bytes."""
    binary = b"\0" in content[:200]  # a byte less and a byte more, and what is between has other bytes
    for _ in range(1 if binary else rng.choice((1, 1, 1, 2))):
        if binary or rng.random() < 0.1:
            at = rng.randrange(len(content))
            other = rng.choice((b"", bytes([rng.randrange(256)]), content[at : at + 1] * 2))
            content = content[:at] + other + content[at + 1 :] if rng.random() < 0.9 else content[:at]
        else:
            content = changed(content.decode("utf-8", "surrogateescape") or " ", rng).encode("utf-8", "surrogateescape")
        content = content or b"\n"
    return content


def read(dialect: Dialect, content: bytes, place: Path) -> tuple[Any, set[str], str]:
    """What is read, what is said of it, and the sentence that refuses it."""
    place.write_bytes(content)
    more = {"tolerance": 0.0} if dialect.kind == "density" else {}
    begin = time.perf_counter()
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            found, sentence = READERS[dialect.kind](place, **dialect.given, **more), ""
        except FileError as fault:
            found, sentence = None, str(fault)
    assert time.perf_counter() - begin < SECONDS
    assert all(issubclass(each.category, sp.FileWarning) for each in caught), [str(each.message) for each in caught]
    said = {part for each in caught for part in str(each.message).split(": ", 1)[1].rstrip(".").split("; ")}
    return found, said, sentence


def misread(right: Any, found: Any) -> str:
    """Why numbers cannot be those of the file with one or two lines changed; empty if they can."""
    before, after = (np.asarray(numbers_of(each)[1], float).ravel() for each in (right, found))
    if type(right) is not type(found):
        return f"{type(found).__name__} in the place of {type(right).__name__}"
    known, some = np.sort(before), min(before.size, after.size, TOUCHED + 1)
    with np.errstate(all="ignore"):  # a header that was changed may name another unit
        sizes = np.unique(np.round(after[:some] / before[:some], 9))
    for size in (1.0, *sizes[np.isfinite(sizes) & (sizes != 0.0)]):
        own = after / size
        near = known[np.clip(np.searchsorted(known, own), 0, known.size - 1)]
        lower = known[np.clip(np.searchsorted(known, own) - 1, 0, known.size - 1)]
        off = np.minimum(np.abs(near - own), np.abs(lower - own)) > 1e-9 * np.abs(known).max()
        if off.sum() <= TOUCHED:
            return ""
    return f"{after[:8]} in the place of {before[:8]}"


@pytest.mark.parametrize("seeds", [range(30), validation(range(30, 1100))])
@pytest.mark.parametrize("dialect", DIALECTS, ids=NAMES)
def test_damaged_files(dialect: Dialect, seeds: range, tmp_path: Path) -> None:
    if dialect.needs:
        pytest.importorskip(dialect.needs)
    place = tmp_path / "file.dat"
    right, usual, sentence = read(dialect, dialect.content, place)
    assert not sentence
    for seed in seeds:
        rng = random.Random(f"{dialect.name} {seed}")
        content = damaged(dialect.content, rng)
        found, said, sentence = read(dialect, content, place)
        if found is None:
            assert sentence.isprintable(), (seed, sentence)
            assert len(sentence) < LONGEST, (seed, sentence)
            assert sentence.startswith((f"{dialect.kind} file ", "columns", "unit", "rate")), (seed, sentence)
        elif not said - usual:
            assert not misread(right, found), (seed, misread(right, found), content[:400])
