"""A validity map that is interrupted: killed, damaged, shared by two processes, on a full disk."""

from __future__ import annotations

import subprocess
import sys
from itertools import product
from pathlib import Path
from typing import Any

import pytest

from springpot import cli
from springpot.evidence import validity
from springpot.evidence.cells import Cell, PaperCell
from springpot.evidence.validity import gaps_of, make_map, simulate_cell
from springpot.machine.faults import FileError
from springpot.machine.record import Record
from tests.kills import fill, kill_when, lines_in
from tests.sizes import validation

ROUGH = 0.02  # of Monte Carlo here: tenths of a second for a cell
CELLS = [PaperCell(order, c, 1.0, b) for order, c, b in product((1.0, 0.5), (1.0, 3.0), (0.0, 0.5))]
EXACT = (Cell(0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.5, 0.3), Cell(1, 0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.3))
"""Of systems: what is exact costs nothing."""
CALL = f"""
import sys
from pathlib import Path
from springpot.evidence import validity
from springpot.evidence.cells import PaperCell
from springpot.machine.record import Record
validity.OSCILLATOR_RTOL = {ROUGH}
path = Path(sys.argv[1])
record = Record(path.with_name("record"), "validity")
validity.make_map(record, cells={CELLS!r}, path=path, threads=1)
record.remove()
"""
COMMAND = [sys.executable, "-c", CALL]


@pytest.fixture(autouse=True)
def rough(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(validity, "OSCILLATOR_RTOL", ROUGH)


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """A map that was not interrupted."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(validity, "OSCILLATOR_RTOL", ROUGH)
        path = tmp_path_factory.mktemp("whole") / "map.csv"
        return make_map(kept(path), cells=CELLS, path=path).read_bytes()


def kept(path: Path) -> Record:
    """The record of a map."""
    return Record(path.with_name("record"), "validity")


def counted(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """The cells that are simulated from now on."""
    made = list[Any]()

    def watched(cell: PaperCell | Cell, **how: Any) -> dict[str, float]:
        made.append(cell)
        return simulate_cell(cell, **how)

    monkeypatch.setattr(validity, "simulate_cell", watched)
    return made


@pytest.mark.validation  # every day: a damaged record, below; kills of any record in machine/
@pytest.mark.parametrize("cells", [3, validation(1), validation(7)])
def test_a_killed_map_goes_on_to_the_same_bytes(
    cells: int, tmp_path: Path, whole: bytes, monkeypatch: pytest.MonkeyPatch
) -> None:
    """SIGKILL of the process; what it had simulated is not simulated again."""
    path, record = tmp_path / "map.csv", tmp_path / "record"
    kill_when([*COMMAND, path], lambda: lines_in(record) >= cells)
    assert [place.name for place in tmp_path.iterdir()] == ["record"]
    before, made = lines_in(record), counted(monkeypatch)
    assert make_map(kept(path), cells=CELLS, path=path).read_bytes() == whole
    assert made == CELLS[before:]
    assert sorted(place.name for place in tmp_path.iterdir()) == ["map.csv", "record"]


def test_a_map_goes_on_where_it_was_interrupted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The earlier map stays until the new one is whole; without ``again`` nothing of it is simulated anew."""

    class Enough(Exception):
        pass

    def stop(fraction: float) -> None:
        raise Enough

    path, made = tmp_path / "map.csv", counted(monkeypatch)
    old = make_map(kept(path), cells=EXACT[:1], path=path).read_bytes()
    kept(path).remove()
    with pytest.raises(Enough):
        make_map(kept(path), cells=EXACT, path=path, again=True, progress=stop)
    assert path.read_bytes() == old
    assert lines_in(tmp_path / "record") == 1
    new = make_map(kept(path), cells=EXACT, path=path, again=True).read_bytes()
    assert made == [EXACT[0], EXACT[0], EXACT[1]]
    assert make_map(kept(path), cells=EXACT, path=path).read_bytes() == new
    assert len(made) == 3


def test_damage_in_its_record_costs_the_damaged_cells(
    tmp_path: Path, whole: bytes, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, record = tmp_path / "map.csv", tmp_path / "record"

    class Enough(Exception):
        pass

    def stop(fraction: float) -> None:
        if fraction == 0.5:
            raise Enough

    with pytest.raises(Enough):
        make_map(kept(path), cells=CELLS, path=path, progress=stop)
    lines = record.read_bytes().splitlines()
    digit = lines[1].rindex(b"1")
    lines[1] = lines[1][:digit] + b"7" + lines[1][digit + 1 :]
    record.write_bytes(b"\n".join([*lines[:3], lines[3][:-10]]))
    made = counted(monkeypatch)
    assert make_map(kept(path), cells=CELLS, path=path).read_bytes() == whole
    assert made == [CELLS[1], *CELLS[3:]]
    record.write_bytes(b"mine\n")
    with pytest.raises(FileError, match="record must be a file of validity or a new one"):
        make_map(kept(path), cells=CELLS, path=path)
    assert record.read_bytes() == b"mine\n"


@pytest.mark.validation  # every day: of splitting and of studies
def test_two_processes_make_one_map(tmp_path: Path, whole: bytes) -> None:
    two = [subprocess.Popen([*COMMAND, str(tmp_path / "map.csv")]) for _ in range(2)]
    assert [process.wait() for process in two] == [0, 0]
    assert [place.name for place in tmp_path.iterdir()] == ["map.csv"]
    assert (tmp_path / "map.csv").read_bytes() == whole


@pytest.mark.validation  # every day: a damaged record; a full disk of any record in machine/
def test_a_full_disk_keeps_what_was_simulated(small_disk: Path, whole: bytes, monkeypatch: pytest.MonkeyPatch) -> None:
    path, ballast = small_disk / "map.csv", small_disk / "ballast"

    def fill_up(fraction: float) -> None:
        if fraction == 0.25:
            fill(ballast)

    says = r"^map '.*map\.csv' cannot be written \(No space left on device\): all results so far are kept, and running "
    for _ in range(2):
        with pytest.raises(OSError, match=says):
            make_map(kept(path), cells=CELLS, path=path, progress=fill_up)
    assert sorted(place.name for place in small_disk.iterdir()) == ["ballast", "record"]
    ballast.unlink()
    made = counted(monkeypatch)
    assert make_map(kept(path), cells=CELLS, path=path).read_bytes() == whole
    assert made
    assert CELLS[:2] != made[:2]


def test_the_command_simulates_again_what_it_had_not_when_it_was_interrupted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Though the maps of the library are there from an earlier call; the pictures are left out."""
    for name in ("plot_gaps_of_methods", "plot_system_gaps_of_methods"):
        monkeypatch.setattr(f"springpot.figures.validity.{name}", lambda *_, **__: None)
    monkeypatch.setattr("springpot.figures.style.save", lambda _, place: place)
    monkeypatch.setattr(validity, "CELLS", CELLS[:2])
    monkeypatch.setattr(validity, "SYSTEM_CELLS", EXACT)
    command = ["validity", "--out", str(tmp_path)]
    assert cli.main(command) == 0
    shipped = (tmp_path / "validity_systems.csv").read_bytes()
    made = counted(monkeypatch)

    def stop(cell: Cell, simulated: dict[str, float]) -> dict[str, float]:
        if cell == EXACT[1]:
            raise KeyboardInterrupt
        return gaps_of(cell, simulated)

    with monkeypatch.context() as interrupted:
        interrupted.setattr(validity, "gaps_of", stop)
        assert cli.main([*command, "--simulate-again"]) == 130
    assert (tmp_path / "validity_systems.csv").read_bytes() == shipped
    assert cli.main([*command, "--simulate-again"]) == 0
    assert made == [*CELLS[:2], *EXACT]
    assert (tmp_path / "validity_systems.csv").read_bytes().count(b"\n") == 3
    assert not (tmp_path / "validity.record").exists()
    capsys.readouterr()
