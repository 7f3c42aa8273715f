"""Machine code from the wheel, from the disk and from Numba: the same bits, and never a wrong one."""

from __future__ import annotations

import ctypes
import hashlib
import importlib
import inspect
import json
import os
import re
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import llvmlite.binding as llvm
import numpy as np
import pytest

from springpot.machine import trusted
from springpot.simulation.kernel import kept, native, targets
from springpot.simulation.kernel.kept import MissingSymbolError, loaded, needed
from springpot.simulation.kernel.make_objects import LIBRARY, make
from springpot.simulation.kernel.native import ENTRIES, FILL_NORMALS, MANIFEST, Entry
from springpot.simulation.kernel.targets import TARGETS, target
from tests.posix import make_pipe
from tests.sizes import validation
from tests.strangers import as_stranger, needs_another_user, needs_owners

LAWS = """
from numba import njit
from springpot.simulation.kernel.lanes import INLINE, f32

@njit(**INLINE)
def pull(u, w, stiffness):
    return -stiffness * u * u * u - f32(0.3) * w
"""
KERNEL = """
import math
from springpot.simulation.kernel.lanes import LANES, f32, stack_array
from tiny.laws import pull

_lanes = stack_array(LANES)

def advance(numbers, state, blocks, steps, seed, out):
    x, v = _lanes(f32(0.0)), _lanes(f32(0.0))
    h, stiffness = numbers[0], numbers[1]
    for block in range(blocks):
        for lane in range(LANES):
            x[lane], v[lane] = f32(state[0]), f32(state[1]) + f32(seed) * f32(lane + 64 * block)
        for step in range(steps):
            for lane in range(LANES):
                v[lane] = v[lane] + h * pull(x[lane], v[lane], stiffness)
                x[lane] = x[lane] + h * v[lane] / (f32(1.0) + math.sqrt(f32(1.0) + v[lane] * v[lane]))
        for lane in range(LANES):
            out[block * LANES + lane] = math.exp(x[lane]) + math.sin(v[lane]) ** 1.7
"""
RUN = """
import sys
import numpy as np
from springpot.simulation.kernel.native import Entry

advance = Entry(
    "tiny.kernel:advance", ("float32*", "float64*", "int64", "int64", "uint32", "float64*"), "the tiny kernel"
)
if "wait" in sys.argv:
    from springpot.simulation.kernel import compiling
    print("ready", flush=True)
    sys.stdin.readline()
out = np.empty(128)
advance(np.float32([0.01, 2.0]), np.array([0.5, 0.25]), 2, 100, 3, out)
print(advance.load().how)
print("numba" in sys.modules, out.tobytes().hex())
"""


@pytest.fixture
def tiny(tmp_path: Path) -> Path:
    """A package with a small kernel, and a program that calls it."""
    folder = tmp_path / "tiny"
    folder.mkdir()
    (folder / "__init__.py").touch()
    (folder / "laws.py").write_text(LAWS, encoding="utf-8")
    (folder / "kernel.py").write_text(KERNEL, encoding="utf-8")
    (tmp_path / "run.py").write_text(RUN, encoding="utf-8")
    return tmp_path


def begun(where: Path, *words: str, **variables: str) -> subprocess.Popen[str]:
    # no .pyc: Python trusts one whose source has its size and was written in the same second, and tests write faster
    places = {"NUMBA_CACHE_DIR": str(where / "cache"), "PYTHONPATH": str(where), "PYTHONDONTWRITEBYTECODE": "1"}
    return subprocess.Popen(
        [sys.executable, str(where / "run.py"), *words], text=True,
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        env={**os.environ, "PYTHONWARNINGS": "default", **places, **variables},
    )  # fmt: skip


def answered(process: subprocess.Popen[str]) -> tuple[str, str, str, str]:
    """What it says of the code, whether Numba was there, the bits, and stderr."""
    out, err = process.communicate(timeout=300)
    assert process.returncode == 0, err
    how, numba, bits = re.fullmatch(r"(?:ready\n)?(.*)\n(\w+) (\w+)\n", out).groups()  # type: ignore[union-attr]
    return how, numba, bits, err


def objects(folder: Path) -> list[Path]:
    return sorted(folder.rglob("*.o"))


def test_code_is_compiled_once_and_later_processes_need_no_numba(tiny: Path) -> None:
    """What the kernel calls, in another file, belongs to it: when that changes it is compiled anew."""
    how, numba, bits, said = answered(begun(tiny))
    assert how.startswith(f"compiled in this process for {target().name}, since this installation brings")
    assert (numba, said) == (
        "True", f"springpot: compiling the tiny kernel for {target().name}; once on this machine.\n"
    )  # fmt: skip
    (file,) = objects(tiny / "cache")
    assert not hasattr(os, "geteuid") or file.stat().st_mode & 0o777 == 0o600
    assert answered(begun(tiny)) == (how.replace("compiled in this process", "kept on disk"), "False", bits, "")
    laws = tiny / "tiny" / "laws.py"
    laws.write_text(LAWS.replace("0.3", "0.4"), encoding="utf-8")
    again = answered(begun(tiny))
    assert again[0].startswith("compiled")
    assert again[2] != bits
    laws.write_text(LAWS, encoding="utf-8")
    assert answered(begun(tiny))[1:3] == ("False", bits)


@pytest.mark.validation  # every day: two processes keep code, in test_cache.py
def test_two_processes_at_once_compile_the_same(tiny: Path) -> None:
    both = [begun(tiny, "wait") for _ in range(2)]
    for process in both:
        assert process.stdout is not None
        assert process.stdout.readline() == "ready\n"
    for process in both:
        assert process.stdin is not None
        process.stdin.write("go\n")
        process.stdin.flush()
    one, other = map(answered, both)
    assert one[2] == other[2]
    assert len(objects(tiny / "cache")) == 1
    assert {file.suffix for file in (tiny / "cache").rglob("*") if file.is_file()} == {".o"}  # nothing half-written
    assert answered(begun(tiny))[:3] == (one[0].replace("compiled in this process", "kept on disk"), "False", one[2])


@pytest.mark.validation  # every day: bits do not depend on the lanes, in test_lanes.py
@pytest.mark.skipif("linux-x86-64-v3" not in [each.name for each in TARGETS if each.here], reason="another processor")
def test_without_the_widest_vectors_the_bits_are_the_same(tiny: Path) -> None:
    """As where the processor has none, by the variable that Numba knows too."""
    widest = next(each.name for each in TARGETS if each.here)
    bits = answered(begun(tiny, SPRINGPOT_TARGET=widest))[2]
    how, _, narrow, said = answered(begun(tiny, NUMBA_CPU_NAME="x86-64-v3"))
    assert "for linux-x86-64-v3" in how
    assert "for linux-x86-64-v3" in said
    assert narrow == bits
    assert answered(begun(tiny, SPRINGPOT_TARGET="linux-x86-64-v3"))[0].startswith("kept on disk")


@pytest.mark.validation  # every day: the command says it, below
@needs_owners
def test_where_others_can_write_nothing_is_kept(tiny: Path) -> None:
    cache = tiny / "cache"
    cache.mkdir()
    cache.chmod(0o777)
    for _ in range(2):
        how, _, _, said = answered(begun(tiny))
        assert how.startswith("compiled")
        assert f"{str(cache)!r} can be written by other users. Set NUMBA_CACHE_DIR to" in said
        assert "compiling the tiny kernel" in said
        assert "in each process, since it cannot be kept" in said
    assert list(cache.iterdir()) == []


@needs_owners
def test_the_command_says_it_in_one_sentence(tmp_path: Path) -> None:
    """And the doctor says it among its findings."""
    tmp_path.chmod(0o777)
    code = (
        "from springpot import cli; from springpot.cli import doctor; from springpot.machine import trusted\n"
        "doctor.self_check = lambda: {'passed': True, 'statement': 'left out'}\n"
        "from springpot.simulation.kernel.native import FILL_NORMALS\n"
        "doctor.compiled_code = lambda: {'fill_normals': FILL_NORMALS.load().how}\n"
        "assert cli.main(['doctor']) == 0"
    )
    places = {"NUMBA_CACHE_DIR": str(tmp_path / "kernels"), "SPRINGPOT_CACHE_DIR": str(tmp_path / "sums")}
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=300, env={**os.environ, **places}
    )
    reason = f"{str(tmp_path)!r} can be written by other users"
    assert done.stderr == (
        "springpot: warning: Compiled kernels are not stored, and every process compiles them again for a few seconds, "
        f"because {reason}. Set NUMBA_CACHE_DIR to a folder that only you can write.\n"
    )
    (shown,) = (line for line in done.stdout.splitlines() if line.strip().startswith("cache"))
    assert f"folder none, used False, reason {reason}" in shown
    assert f"memory_folder {places['SPRINGPOT_CACHE_DIR']}/memory, memory_used False, memory_reason {reason}" in shown
    assert list(tmp_path.iterdir()) == []


# --- what is kept ----------------------------------------------------------------------------------------------------


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "cache"))
    return tmp_path / "cache"


@pytest.mark.parametrize("damage", ["cut", "empty", "flipped", "another key", validation("no checksum"), "longer"])
def test_a_damaged_file_is_none(cache: Path, damage: str) -> None:
    content = bytes(range(256)) * 40
    kept.save("some", "a key", content)
    assert kept.load("some", "a key") == content
    (file,) = objects(cache)
    whole = file.read_bytes()
    flipped = bytearray(whole)
    flipped[5000] ^= 1
    other = whole
    if damage == "another key":
        kept.save("some", "another key", content)
        other = next(each for each in objects(cache) if each != file).read_bytes()
    file.write_bytes(
        {
            "cut": whole[:5000], "empty": b"", "flipped": bytes(flipped), "no checksum": content,
            "longer": whole + b"\0", "another key": other,
        }[damage]
    )  # fmt: skip
    assert kept.load("some", "a key") is None
    kept.save("some", "a key", content)
    assert kept.load("some", "a key") == content


def test_what_was_not_used_for_longest_goes_first(cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A function that captures another number in each call would fill the disk."""
    monkeypatch.setattr(kept, "_MOST", 6)
    for number in range(6):
        kept.save("some", str(number), b"content")
    for age, file in enumerate(sorted(objects(cache), key=lambda file: file.stat().st_mtime_ns)):
        os.utime(file, (1000.0 + age, 1000.0 + age))
    assert kept.load("some", "1") == b"content"
    kept.save("some", "6", b"content")
    assert [number for number in range(7) if kept.load("some", str(number))] == [1, 4, 5, 6]


WRITING = """
import os, sys
from springpot.simulation.kernel import kept
content = os.urandom(1 << 20) * 48
print("begins", flush=True)
kept.save("large", "a key", content)
print("done", flush=True)
"""


def test_a_process_killed_while_it_writes_leaves_nothing_that_is_used(cache: Path) -> None:
    for _ in range(30):
        for file in objects(cache):  # what a process saved that was not killed in time
            file.unlink()
        process = subprocess.Popen([sys.executable, "-c", WRITING], stdout=subprocess.PIPE, text=True)
        assert process.stdout is not None
        assert process.stdout.readline() == "begins\n"
        while process.poll() is None:
            if any(file.stat().st_size > 1 << 20 for file in cache.rglob(".large*")):
                process.kill()
                break
        finished = "done" in process.communicate(timeout=300)[0]
        if not finished and list(cache.rglob(".large*")):
            break
    else:
        pytest.fail("no process was killed while it wrote")
    assert kept.load("large", "a key") is None
    kept.save("large", "a key", b"small")
    assert kept.load("large", "a key") == b"small"
    assert list(cache.rglob(".*")) == []  # what the killed one left is gone


@needs_owners
@pytest.mark.parametrize("place", ["pipe", "huge", "for all", "folder"])
def test_what_is_no_proper_file_is_none(cache: Path, place: str) -> None:
    kept.save("some", "a key", b"content")
    (file,) = objects(cache)
    if place == "for all":
        file.chmod(0o666)
    else:
        file.unlink()
    if place == "pipe":
        make_pipe(file)
    elif place == "huge":
        with file.open("wb") as huge:
            huge.truncate(1 << 36)
    elif place == "folder":
        file.mkdir()
    assert kept.load("some", "a key") is None
    kept.save("some", "a key", b"content")
    assert kept.load("some", "a key") == b"content"


@pytest.fixture
def shared() -> Iterator[Path]:
    """A folder that all users reach, and in which all can write."""
    with tempfile.TemporaryDirectory(dir="/tmp") as folder:
        os.chmod(folder, 0o1777)
        yield Path(folder)


@needs_another_user
@pytest.mark.parametrize("where", ["the folder", "the folder above", "a link", "its own folder"])
def test_code_forged_by_another_user_is_not_loaded(
    cache: Path, shared: Path, where: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The attack: another user puts a file in place, with the right name and the right checksum."""
    kept.save("some", "a key", b"forged")
    (file,) = objects(cache)
    forged, open_to_all = file.read_bytes(), shared / "cache"
    its = open_to_all / file.parent.name / file.name
    if where in ("the folder", "the folder above"):
        its.parent.mkdir(parents=True)
        (its.parent if where == "the folder" else open_to_all).chmod(0o777)
    with as_stranger():
        if where == "the folder above":
            its.parent.rename(open_to_all / "away")
        if where == "a link":
            (shared / "its").mkdir()
            open_to_all.symlink_to(shared / "its")
        its.parent.mkdir(parents=True, exist_ok=True)
        its.write_bytes(forged)
    if where == "a link":  # even where it leads to what is this user's
        for path in (shared / "its", *(shared / "its").rglob("*")):
            os.chown(path, 0, 0)
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(open_to_all))
    assert kept.load("some", "a key") is None
    kept.save("some", "a key", b"own")
    assert its.read_bytes() == forged
    place, reason = kept.folder()
    assert place is None
    assert reason is not None
    assert "can be written by other users" in reason or "belongs to the user" in reason
    trusted.say_unused.cache_clear()
    with pytest.warns(trusted.CacheWarning, match="Compiled kernels are not stored"):
        kept.warn_if_unused()


# --- the wheel's -----------------------------------------------------------------------------------------------------


HERE = [each.name for each in TARGETS if each.here]
needs_target = pytest.mark.skipif(target().name not in HERE, reason="no object is made for this machine")


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What the release makes, for this machine."""
    folder = tmp_path_factory.mktemp("objects")
    make(tuple(HERE), folder, (FILL_NORMALS,))
    return folder


@pytest.fixture
def installed(made: Path, cache: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The same, as if the wheel had brought it; its own copy."""
    folder = tmp_path / "objects"
    folder.mkdir()
    for file in made.iterdir():
        (folder / file.name).write_bytes(file.read_bytes())
    monkeypatch.setattr(native, "OBJECTS", folder)
    return folder


def normals_by(entry: Entry) -> bytes:
    out = np.empty((20, 101), np.float32)
    entry(64, 3, 0, 1234, 5678, 20, 101, out)
    assert 0.9 < out.std() < 1.1
    return out.tobytes()


def fresh() -> Entry:
    """The entry as another process has it."""
    return Entry(FILL_NORMALS.function, FILL_NORMALS.arguments)


@needs_target
def test_the_object_of_a_release_is_byte_for_byte_what_is_compiled_here(installed: Path, cache: Path) -> None:
    """So the bits of results are the same in all three ways; nothing is kept where there is an object."""
    shipped = fresh()
    bits = normals_by(shipped)
    assert shipped.load().how == f"of this installation, for {target().name}"
    assert objects(cache) == []
    file = installed / f"fill_normals.{target().name}.o"
    content = file.read_bytes()
    assert fresh().compiled(target()) == content
    file.unlink()
    for how in ("compiled in this process", "kept on disk"):
        other = fresh()
        assert normals_by(other) == bits
        assert other.load().how.startswith(how)


@needs_target
def test_all_targets_of_this_machine_have_the_same_bits(installed: Path) -> None:
    found = set()
    for name in HERE:
        code = loaded((installed / f"fill_normals.{name}.o").read_bytes(), name)
        kinds = [ctypes.c_void_p if each.endswith("*") else native.NUMBERS[each] for each in FILL_NORMALS.arguments]
        out = np.empty((64, 404), np.float32)
        ctypes.CFUNCTYPE(None, *kinds)(code.address)(0, 0, 0, 1, 2, 64, 404, out.ctypes.data)
        found.add(out.tobytes())
    assert len(found) == 1


@needs_target
@pytest.mark.parametrize(
    ("damage", "reason"),
    [
        ("flipped", "the compiled code of this installation is damaged"),
        validation("another", "the compiled code of this installation is damaged"),
        ("stale", "the compiled code of this installation was made from other sources"),
        validation("missing", "the compiled code of this installation is not complete"),
        validation("no target", f"this installation brings none for {target().name}"),
        validation("unreadable", "the list of compiled code cannot be read"),
        ("no list", "this installation brings no compiled code"),
        validation("another list", "the list of compiled code cannot be read"),
        validation("not listed", "this installation brings none of it"),
    ],
)
def test_an_object_that_is_not_right_is_not_used(installed: Path, damage: str, reason: str) -> None:
    """A stale one has the right checksum; the numbers that it would give are others."""
    bits = normals_by(fresh())
    file, listed = installed / f"fill_normals.{target().name}.o", installed / MANIFEST
    content, manifest = bytearray(file.read_bytes()), json.loads(listed.read_text(encoding="utf-8"))
    if damage == "flipped":
        content[len(content) // 2] ^= 1
        file.write_bytes(content)
    elif damage in ("another", "stale"):
        file.write_bytes(nothing_done())
    elif damage == "missing":
        file.unlink()
    if damage == "stale":
        of_it = manifest["fill_normals"]
        of_it["sha256"][target().name] = hashlib.sha256(file.read_bytes()).hexdigest()
        of_it["sources"] = "0" * 64
    elif damage == "no target":
        del manifest["fill_normals"]["sha256"][target().name]
    elif damage == "another list":
        manifest = [1, 2]
    elif damage == "not listed":
        manifest = {}
    listed.write_text("{" if damage == "unreadable" else json.dumps(manifest), encoding="utf-8")
    if damage == "no list":
        listed.unlink()
    entry = fresh()
    assert normals_by(entry) == bits
    assert entry.load().how == f"compiled in this process for {target().name}, since {reason}"


def emitted(text: str) -> bytes:
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    machine = llvm.Target.from_default_triple().create_target_machine()
    return bytes(machine.emit_object(llvm.parse_assembly(text)))


def nothing_done() -> bytes:
    """Code that is loaded without an error, and writes nothing."""
    takes = "i64, i32, i32, i32, i32, i64, i64, ptr"
    return emitted(f"define void @springpot({takes}) {{ ret void }}")


@validation
@pytest.mark.parametrize("name", [each.name for each in TARGETS if not each.here])
def test_objects_for_other_machines_can_be_made(name: str, tmp_path: Path) -> None:
    """Whether they are right only such a machine can tell."""
    assert make((name,), tmp_path, (FILL_NORMALS,))["fill_normals"]["sha256"].keys() == {name}  # type: ignore[attr-defined]
    (file,) = objects(tmp_path)
    content = file.read_bytes()
    assert content[:4] == (b"\xcf\xfa\xed\xfe" if name.startswith("macos") else b"\x7fELF")
    assert needed(content) <= LIBRARY


def test_a_target_that_is_not_known_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"target must be one of linux-x86-64-v4, .*, not 'vax'"):
        make(("vax",), tmp_path)


def test_code_for_another_machine_is_not_run(monkeypatch: pytest.MonkeyPatch) -> None:
    """LLVM would end the process."""
    other = next(each.name for each in TARGETS if not each.here)
    monkeypatch.setenv("SPRINGPOT_TARGET", other)
    monkeypatch.setattr(targets, "target", targets.target.__wrapped__)
    with pytest.raises(ValueError, match=rf"SPRINGPOT_TARGET must be .*not set, not {other}: this machine cannot run"):
        fresh().load()
    monkeypatch.setenv("SPRINGPOT_TARGET", "vax")
    with pytest.raises(ValueError, match="target must be one of linux-x86-64-v4"):
        fresh().load()


def test_every_entry_states_arrays_and_numbers_of_its_function() -> None:
    assert len({entry.name for entry in ENTRIES}) == len(ENTRIES)
    for entry in ENTRIES:
        function = getattr(importlib.import_module(entry.module), entry.function_name)
        assert len(inspect.signature(function).parameters) == len(entry.arguments)


# --- loading, calling ------------------------------------------------------------------------------------------------


def test_a_missing_function_is_said_before_the_process_would_end() -> None:
    """LLVM ends the process where it does not find one."""
    content = emitted("""
        declare void @no_such_function()
        declare double @exp(double)
        define double @springpot(double %x) {
          call void @no_such_function()
          %y = call double @exp(double %x)
          ret double %y
        }
    """)
    assert {"no_such_function", "exp"} <= needed(content)
    with pytest.raises(MissingSymbolError, match=r"it needs no_such_function, which this process does not have"):
        loaded(content, "")


def test_functions_of_the_mathematical_library_are_found() -> None:
    content = emitted("""
        declare double @pow(double, double)
        declare float @expf(float)
        declare double @tgamma(double)
        define double @springpot(double %x) {
          %p = call double @pow(double %x, double 1.5)
          %s = fptrunc double %x to float
          %e = call float @expf(float %s)
          %d = fpext float %e to double
          %g = call double @tgamma(double %x)
          %a = fadd double %p, %d
          %b = fadd double %a, %g
          ret double %b
        }
    """)
    code = loaded(content, "")
    found = ctypes.CFUNCTYPE(ctypes.c_double, ctypes.c_double)(code.address)(4.0)
    assert found == pytest.approx(8.0 + np.exp(4.0) + 6.0, rel=1e-7)


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        (np.empty((4, 8)), "an array of float32 without gaps is wanted, not of float64"),
        (np.empty((4, 16), np.float32)[:, ::2], "an array of float32 without gaps is wanted"),
    ],
)
def test_another_array_is_refused(given: np.ndarray, sentence: str, cache: Path) -> None:
    with pytest.raises(TypeError, match=sentence):
        FILL_NORMALS(0, 0, 0, 1, 2, 4, 8, given)
    with pytest.raises(TypeError, match="fill_normals takes 8 arguments, not 7"):
        FILL_NORMALS(0, 0, 0, 1, 2, 4, 8)
    with pytest.raises(ValueError, match=r"arguments must be of int64, .*, not complex64\*"):
        Entry("some:where", ("int64", "complex64*"))


def test_other_threads_run_while_the_code_does() -> None:
    out = np.empty((64, 400_000), np.float32)
    thread = threading.Thread(target=FILL_NORMALS, args=(0, 0, 0, 1, 2, 64, 400_000, out))
    FILL_NORMALS(0, 0, 0, 1, 2, 1, 1, np.empty(1, np.float32))
    thread.start()
    beats = 0
    while thread.is_alive():
        beats += 1
        time.sleep(1e-4)
    assert beats > 20
