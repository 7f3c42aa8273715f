"""Matrices from files: against SciPy's and pyYeti's own, dialects that SciPy misreads, and damaged files."""

from __future__ import annotations

import io
import random
import sys
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy import sparse
from scipy.io import mmread, mmwrite

import springpot as sp
from springpot.machine.faults import FileError
from springpot.machine.installed import MissingExtraError
from tests.files.test_fuzzed import damaged
from tests.sizes import validation

HALF = sparse.random_array((7, 7), density=0.4, rng=np.random.default_rng(1))
SYMMETRIC = (HALF + HALF.T).toarray()
WIDE = np.arange(6.0).reshape(2, 3)
HEAD = "%%MatrixMarket matrix coordinate real symmetric\n"


def dense(matrix: Any) -> Any:
    return matrix.toarray() if sparse.issparse(matrix) else matrix


@pytest.mark.parametrize("form", [np.asarray, sparse.coo_array])
@pytest.mark.parametrize(("matrix", "symmetry"), [(SYMMETRIC, "symmetric"), (SYMMETRIC, "general"), (WIDE, "general")])
def test_matrix_market_as_scipy_has_it(form: Any, matrix: Any, symmetry: str, tmp_path: Path) -> None:
    mmwrite(tmp_path / "own.mtx", form(matrix), comment="of a program", symmetry=symmetry)
    found = sp.read_matrix(tmp_path / "own.mtx")
    assert sparse.issparse(found) == (form is sparse.coo_array)
    np.testing.assert_array_equal(dense(found), dense(mmread(tmp_path / "own.mtx")))
    np.testing.assert_array_equal(dense(found), matrix)


def test_an_exponent_of_fortran(tmp_path: Path) -> None:
    """SciPy 1.17 reads 1."""
    place = tmp_path / "own.mtx"
    place.write_text(f"{HEAD}% of Fortran\n\n 2 2 2\n1 1 1.5D+03\n2 1 -2d0\n", encoding="utf-8")
    assert sp.read_matrix(place).toarray().tolist() == [[1500.0, -2.0], [-2.0, 0.0]]


BAD = {
    "hello": "is neither in the Matrix Market format, which begins with %%MatrixMarket, nor an OP4 file",
    "": "is neither in the Matrix Market format",
    "%%MatrixMarket matrix coordinate pattern general\n1 1 1\n1 1\n": "must begin with %%MatrixMarket matrix, coord",
    "%%MatrixMarket matrix coordinate complex hermitian\n1 1 1\n1 1 1 0\n": "not with '%%MatrixMarket matrix coord",
    HEAD: "line 1: the numbers of rows and columns and of entries are needed, not ''",
    f"{HEAD}2 x 1\n": "line 2: the numbers of rows and columns and of entries are needed, not '2 x 1'",
    f"{HEAD}2 3 1\n1 1 1\n": "must have 1 to 1,000,000 rows and columns, as many of both, not 2 and 3",
    f"{HEAD}0 0 0\n": "must have 1 to 1,000,000 rows and columns",
    f"{HEAD}9999999999 9999999999 1\n1 1 1\n": "must have 1 to 1,000,000 rows and columns",
    f"{HEAD}2 2 4\n1 1 1\n": "must have at most 3 entries, not 4",
    f"{HEAD}2 2 2\n1 1 1\n": "states 2 entries, and has 1: it may be cut off",
    f"{HEAD}2 2 1\n1 1 1\n2 1 1\n": "states 1 entries, and has 2",
    f"{HEAD}2 2 1\n1 1 1,5\n": "line 3: numbers must have a decimal point, not a comma",
    f"{HEAD}2 2 1\n1 1 one\n": "line 3: value must be a number, not 'one'",
    f"{HEAD}2 2 1\n1 1 1 1\n": "line 3: 3 numbers are needed, not 4",
    f"{HEAD}2 2 1\n1 1 nan\n": "line 3: a number is not finite",
    f"{HEAD}2 2 1\n0 1 1\n": "line 3: row and column must be whole numbers from 1 to 2 and 2, on or below the diagonal",
    f"{HEAD}2 2 1\n1 2 1\n": "line 3: row and column must be whole numbers from 1 to 2 and 2, on or below the diagonal",
    f"{HEAD}2 2 1\n1.5 1 1\n": "line 3: row and column must be whole numbers",
    f"{HEAD}2 2 2\n2 1 1\n2 1 1\n": "line 4: row 2 and column 1 are there twice",
}  # fmt: skip


@pytest.mark.parametrize("content", BAD)
def test_what_cannot_be_read_is_refused_in_one_sentence(content: str, tmp_path: Path) -> None:
    (tmp_path / "own.mtx").write_text(content, encoding="utf-8")
    with pytest.raises(FileError) as caught:
        sp.read_matrix(tmp_path / "own.mtx")
    assert BAD[content] in str(caught.value)
    assert "\n" not in str(caught.value)


def test_arguments(tmp_path: Path) -> None:
    mmwrite(tmp_path / "own.mtx", SYMMETRIC)
    with pytest.raises(FileError, match=r"name must be left out of matrix file .* which has one matrix without a name"):
        sp.read_matrix(tmp_path / "own.mtx", "KAA")
    with pytest.raises(FileNotFoundError):
        sp.read_matrix(tmp_path / "none.mtx")
    with pytest.raises(TypeError, match="path must be the place of a file"):
        sp.read_matrix(3)  # type: ignore[arg-type]


def misread(found: Any, right: Any) -> bool:
    """Whether more numbers are others than two changes make, of a line or two each; lines may have moved."""
    return bool(found.shape != right.shape or (~np.isin(dense(found), right)).sum() > 8)


def read_damaged(content: bytes, right: Any, place: Path) -> str:
    """The sentence, where it is not read."""
    place.write_bytes(content)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            found = sp.read_matrix(place)
        except FileError as fault:
            return str(fault)
    assert not misread(found, right), content
    return ""


@pytest.mark.parametrize("seeds", [range(100), validation(range(100, 1100))])
@pytest.mark.parametrize("form", [np.asarray, sparse.coo_array])
def test_damaged_files(form: Any, seeds: range, tmp_path: Path) -> None:
    """Such as end the process in SciPy's reader."""
    written = io.BytesIO()
    mmwrite(written, form(SYMMETRIC))
    sentences = [read_damaged(damaged(written.getvalue(), random.Random(seed)), SYMMETRIC, tmp_path / "own.mtx")
                 for seed in seeds]  # fmt: skip
    assert not any("\n" in sentence for sentence in sentences)
    assert 0.3 * len(seeds) < len([*filter(None, sentences)]) < len(seeds)


def test_an_op4_file_needs_an_extra(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "own.op4").write_text("       2       2       6       2KAA     1P,3E23.16\n", encoding="utf-8")
    monkeypatch.setattr("springpot.machine.installed.find_spec", lambda _: None)
    with pytest.raises(MissingExtraError, match=r'an OP4 file needs pyyeti, .* "springpot\[op4\]"'):
        sp.read_matrix(tmp_path / "own.op4")


def test_an_op4_file_leaves_how_numpy_prints(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its reader sets that for the whole process when it is imported."""
    with np.printoptions():
        op4 = pytest.importorskip("pyyeti.nastran.op4")
    op4.write(str(tmp_path / "own.op4"), {"KAA": np.eye(2)})
    for name in [each for each in sys.modules if each.startswith("pyyeti")]:
        monkeypatch.delitem(sys.modules, name)
    sp.read_matrix(tmp_path / "own.op4")
    assert np.get_printoptions()["legacy"] is False


@pytest.mark.parametrize("binary", [True, False])
@pytest.mark.parametrize("layout", ["dense", "bigmat", "nonbigmat"])
def test_op4(binary: bool, layout: str, tmp_path: Path) -> None:
    with np.printoptions():
        op4 = pytest.importorskip("pyyeti.nastran.op4")
    place = tmp_path / "own.op4"
    op4.write(str(place), {"KAA": SYMMETRIC, "MAA": np.eye(7)}, binary=binary, sparse=layout)
    np.testing.assert_array_equal(sp.read_matrix(place, "kaa").toarray(), SYMMETRIC)
    np.testing.assert_array_equal(sp.read_matrix(place, "MAA").toarray(), np.eye(7))
    with pytest.raises(FileError, match="has the matrices KAA and MAA: give name= for one of them"):
        sp.read_matrix(place)
    with pytest.raises(
        ValueError, match=r"name must be that of a matrix in .*: kaa, maa, not 'ka'; did you mean kaa\?"
    ):
        sp.read_matrix(place, "KA")
    op4.write(str(place), {"KAA": 1j * SYMMETRIC}, binary=binary, sparse=layout)
    with pytest.raises(FileError, match="has complex numbers in KAA, and a real matrix is needed"):
        sp.read_matrix(place)
    op4.write(str(place), {"KAA": SYMMETRIC}, binary=binary, sparse=layout)
    whole = place.read_bytes()
    for cut in range(40, len(whole) - 1, 7):
        if not read_damaged(whole[:cut], SYMMETRIC, place):  # what is lacking comes after the numbers
            assert not binary
            assert cut > whole.rfind(b"\n       8")
            np.testing.assert_array_equal(sp.read_matrix(place).toarray(), SYMMETRIC)
