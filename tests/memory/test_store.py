"""Sums kept on disk: the same bits as fresh ones, and no harm from any file or folder."""

import importlib
import json
import os
import subprocess
import sys
import time
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import springpot as sp
from springpot.machine import files, trusted
from springpot.memory import ExponentialSum, exponential_sum, power_law_sum, store
from tests.posix import link, make_pipe
from tests.sizes import thinned
from tests.strangers import STRANGER, needs_another_user, needs_limits, needs_owners

sums = importlib.import_module("springpot.memory.exponential_sum")


def ask() -> ExponentialSum:
    return exponential_sum("grunwald", 0.37, 5000, 1e-5)


def forget() -> None:
    sums._cached.cache_clear()


def same(a: ExponentialSum, b: ExponentialSum) -> bool:
    def bits(s: ExponentialSum) -> tuple[object, ...]:
        return s.rates.tobytes(), s.weights.tobytes(), s.relative_error, s.shortest, s.longest

    return bits(a) == bits(b)


@pytest.fixture
def never_made(monkeypatch: pytest.MonkeyPatch) -> Callable[[], None]:
    def forbid() -> None:
        monkeypatch.setattr(sums, "_computed", lambda *_: pytest.fail("computed again"))

    return forbid


@pytest.mark.parametrize("tolerance", [1e-5, 1e-12])
def test_from_disk_to_the_bit(fresh_folder: Path, never_made: Callable[[], None], tolerance: float) -> None:
    first = exponential_sum("average", 1 / 3, 5000, tolerance)
    assert len(list(fresh_folder.iterdir())) == 1
    forget()
    never_made()
    assert same(first, exponential_sum("average", 1 / 3, 5000, tolerance))


def test_a_fresh_sum_has_the_same_bits_each_time(fresh_folder: Path) -> None:
    first = ask()
    for file in fresh_folder.iterdir():
        file.unlink()
    forget()
    assert same(first, ask())
    code = (
        "from springpot.memory import exponential_sum as e; s = e('grunwald', 0.37, 5000, 1e-5);"
        "print((s.rates.tobytes() + s.weights.tobytes()).hex())"
    )
    environment = {**os.environ, "SPRINGPOT_CACHE_DIR": str(fresh_folder / "another")}
    other = subprocess.run(
        [sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True
    ).stdout.strip()
    assert other == (first.rates.tobytes() + first.weights.tobytes()).hex()


def test_each_question_has_its_own_file(fresh_folder: Path) -> None:
    ask()
    exponential_sum("average", 0.37, 5000, 1e-5)
    exponential_sum("grunwald", 0.37, 5001, 1e-5)
    exponential_sum("grunwald", 0.37, 5000, 2e-5)
    exponential_sum("grunwald", np.nextafter(0.37, 1.0), 5000, 1e-5)
    power_law_sum(0.37, 1.0, 5000.0, 1e-5)
    assert len(list(fresh_folder.iterdir())) == 6
    power_law_sum(0.37, 2.0, 10_000.0, 1e-5)  # the same range in other units
    assert len(list(fresh_folder.iterdir())) == 6


def changed_digit(text: bytes) -> bytes:
    content = json.loads(text)
    content["content"]["weights"][0] *= 1.0 + 1e-12
    return json.dumps(content).encode()


def another_question(text: bytes) -> bytes:
    """A sound file, but the answer to something else."""
    content = json.loads(text)["content"]
    content["key"]["order"] = 0.38
    return json.dumps({"content": content, "digest": store._digest(content)}).encode()


@pytest.mark.parametrize(
    "damage",
    [
        changed_digit,
        another_question,
        lambda text: text[: len(text) // 2],
        lambda text: b"",
        lambda text: b"\x00\xff" * 100,
        lambda text: b"[1, 2]",
        lambda text: b'{"content": 3, "digest": 4}',
        lambda text: b"[" * 100_000,
        lambda text: text.replace(b"grunwald", b"average!"),
    ],
)  # fmt: skip
def test_a_damaged_or_foreign_file_is_replaced(fresh_folder: Path, damage: Callable[[bytes], bytes]) -> None:
    first = ask()
    (file,) = fresh_folder.iterdir()
    sound = file.read_bytes()
    file.write_bytes(damage(sound))
    forget()
    assert same(first, ask())
    assert [f.read_bytes() for f in fresh_folder.iterdir()] == [sound]


def _sealed(change: Callable[[dict[str, Any]], None]) -> Callable[[bytes], bytes]:
    """A file with another content and the right digest of it."""

    def forged(text: bytes) -> bytes:
        content = json.loads(text)["content"]
        change(content)
        return json.dumps({"content": content, "digest": store._digest(content)}).encode()

    return forged


def _scaled(content: dict[str, Any]) -> None:
    content["weights"] = [0.45 * weight for weight in content["weights"]]


def _one_mode_off(content: dict[str, Any]) -> None:
    content["weights"][7] *= 1.0003


def _negative(content: dict[str, Any]) -> None:
    content["weights"].append(-1e-30)
    content["rates"].append(3.0)


def _growing(content: dict[str, Any]) -> None:
    content["weights"].append(1e-300)
    content["rates"].append(-1e-12)


def _boast(content: dict[str, Any]) -> None:
    content["relative_error"] = 1e-9


def _worse(content: dict[str, Any]) -> None:
    _scaled(content)
    content["relative_error"] = 1.0


def _no_number(content: dict[str, Any]) -> None:
    content["weights"][0] = float("nan")


def _no_terms(content: dict[str, Any]) -> None:
    content["weights"], content["rates"] = [], []


def _a_table(content: dict[str, Any]) -> None:
    content["weights"], content["rates"] = [content["weights"]], [content["rates"]]


def _in_another_order(content: dict[str, Any]) -> None:
    content["weights"].reverse()
    content["rates"].reverse()


def _split(count: int, apart: float) -> Callable[[dict[str, Any]], None]:
    """One of the terms as many that are together the same."""

    def split(content: dict[str, Any]) -> None:
        weight, rate = content["weights"].pop(3), content["rates"].pop(3)
        content["weights"][3:3] = [weight / count] * count
        content["rates"][3:3] = [rate * (1.0 + apart * number) for number in range(count)]

    return split


def _far_too_large(content: dict[str, Any]) -> None:
    content["weights"][0] = 10**400


@pytest.mark.parametrize(
    "change",
    thinned([_scaled, _one_mode_off, _negative, _growing, _boast, _worse, _no_number, _no_terms, _a_table,
             _far_too_large, _in_another_order, _split(2, 0.0), _split(9000, 1e-14)], 2),
)  # fmt: skip
def test_a_forged_sum_with_the_right_digest_is_not_believed(
    fresh_folder: Path, change: Callable[[dict[str, Any]], None]
) -> None:
    first = ask()
    (file,) = fresh_folder.iterdir()
    sound = file.read_bytes()
    file.write_bytes(_sealed(change)(sound))
    forget()
    assert same(first, ask())
    assert file.read_bytes() == sound


@needs_another_user
@pytest.mark.parametrize("mode", [0o777, 0o1777, 0o755])
def test_a_folder_in_which_another_user_can_write(
    fresh_folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, mode: int
) -> None:
    """Nothing is read there or written, and one sentence says so."""
    trusted.say_unused.cache_clear()
    first = ask()
    (file,) = fresh_folder.iterdir()
    if mode == 0o755:
        os.chown(fresh_folder, STRANGER, STRANGER)
    fresh_folder.chmod(mode)
    forget()
    file.unlink()
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        assert same(first, ask())
        forget()
        assert same(first, ask())
    assert len(said) == 1
    assert str(said[0].message).startswith("The exponential sums of the memory are not stored, and each is computed")
    assert str(fresh_folder) in str(said[0].message)
    assert list(fresh_folder.iterdir()) == []


@needs_owners
@pytest.mark.parametrize("place", ["pipe", "huge", "zeros"])
def test_no_proper_file_costs_neither_time_nor_memory(fresh_folder: Path, place: str) -> None:
    first = ask()
    (file,) = fresh_folder.iterdir()
    file.unlink()
    if place == "pipe":
        make_pipe(file)
    elif place == "huge":
        with file.open("wb") as stream:
            stream.truncate(1 << 40)
    else:
        link(file, "/dev/zero")
    forget()
    begun = time.monotonic()
    assert same(first, ask())
    assert time.monotonic() - begun < 10.0
    forget()
    assert same(first, ask())


@needs_owners
def test_the_folder_and_its_files_are_for_this_user_alone(fresh_folder: Path) -> None:
    ask()
    assert fresh_folder.stat().st_mode & 0o777 == 0o700
    assert [file.stat().st_mode & 0o777 for file in fresh_folder.iterdir()] == [0o600]


def test_a_folder_where_the_file_should_be(fresh_folder: Path) -> None:
    first = ask()
    (file,) = fresh_folder.iterdir()
    file.unlink()
    file.mkdir()
    forget()
    assert same(first, ask())
    assert list(fresh_folder.iterdir()) == [file]  # nothing half-written stays behind


def test_no_folder_can_be_made(tmp_path: Path, fresh_folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").touch()
    monkeypatch.setenv("SPRINGPOT_CACHE_DIR", str(tmp_path / "file"))
    assert ask().rates.size
    assert not fresh_folder.exists()


@needs_limits
def test_a_folder_that_is_read_only(fresh_folder: Path) -> None:
    fresh_folder.mkdir(parents=True)
    fresh_folder.chmod(0o500)
    assert ask().rates.size
    assert not list(fresh_folder.iterdir())


def test_a_full_disk(fresh_folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(files.os, "replace", full)
    assert ask().rates.size
    assert not list(fresh_folder.iterdir())


@pytest.mark.skipif(sys.platform != "linux", reason="other platforms have other folders")
def test_where_the_folder_is(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.delenv("SPRINGPOT_CACHE_DIR", raising=False)
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    assert store.folder() == tmp_path / ".cache" / "springpot" / "memory"
    monkeypatch.setenv("XDG_CACHE_HOME", "relative")
    assert store.folder() == tmp_path / ".cache" / "springpot" / "memory"
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "shared"))
    assert store.folder() == tmp_path / "shared" / "springpot" / "memory"
    monkeypatch.setenv("SPRINGPOT_CACHE_DIR", str(tmp_path / "chosen"))
    assert store.folder() == tmp_path / "chosen" / "memory"


def test_no_home(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("SPRINGPOT_CACHE_DIR", "XDG_CACHE_HOME"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(os.path, "expanduser", lambda path: path)  # what Python does then
    forget()
    assert store.folder() is None
    assert ask().rates.size


def test_reading_is_quick(fresh_folder: Path) -> None:
    ask()
    times = []
    for _ in range(20):
        forget()
        start = time.perf_counter()
        ask()
        times.append(time.perf_counter() - start)
    assert min(times) < 2e-3


def test_a_slightly_longer_run_takes_the_stored_sum(fresh_folder: Path) -> None:
    """Its own sum would take the time of some hundred short paths; a run twice as long has another."""
    for duration in (10.0, 10.5, 11.0):
        sp.simulate(sp.Oscillator(), paths=1, duration=duration, step=0.05, start="rest")
        assert len(list(fresh_folder.iterdir())) == 1
    sp.simulate(sp.Oscillator(), paths=1, duration=20.0, step=0.05, start="rest")
    assert len(list(fresh_folder.iterdir())) == 2


def test_a_shared_span_is_never_too_short() -> None:
    steps = [*range(1, 2000), *(2**n + more for n in range(11, 40) for more in (-1, 0, 1))]
    assert all(each <= sums.shared_span(each) <= max(1.4143 * each, each + 1) for each in steps)
    assert len({*map(sums.shared_span, steps)}) < 85
