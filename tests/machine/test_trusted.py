"""Which folders and files may be read: only what nobody else can have written."""

from __future__ import annotations

import errno
import os
import stat
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from springpot.machine import trusted
from tests.strangers import STRANGER, needs_another_user, needs_owners

pytestmark = needs_owners


@pytest.fixture
def place(tmp_path: Path) -> Iterator[Path]:
    """A folder of this user's, two deep, with a file in it."""
    folder = tmp_path / "above" / "cache"
    folder.mkdir(parents=True)
    for each in (folder, folder.parent):
        each.chmod(0o755)
    (folder / "file").write_bytes(b"words")
    (folder / "file").chmod(0o644)
    yield folder
    os.chown(folder.parent, os.geteuid(), os.getegid())


def read(folder: Path) -> bytes | None:
    return trusted.read(folder / "file", 100)


def test_a_folder_of_this_user(place: Path) -> None:
    assert trusted.reason_against(place) is None
    assert read(place) == b"words"


@pytest.mark.parametrize("mode", [0o777, 0o1777, 0o757, 0o2777, 0o1757])
def test_others_can_write_in_the_folder(place: Path, mode: int) -> None:
    place.chmod(mode)
    assert trusted.reason_against(place) == f"{str(place)!r} can be written by other users"
    assert read(place) is None


def test_others_can_replace_the_folder(place: Path) -> None:
    place.parent.chmod(0o777)
    assert trusted.reason_against(place) == f"{str(place.parent)!r} can be written by other users"
    assert read(place) is None
    place.parent.chmod(0o1777)  # the sticky bit: what is ours stays
    assert read(place) == b"words"


@needs_another_user
@pytest.mark.parametrize("whose", ["folder", "above", "file"])
def test_of_another_user(place: Path, whose: str) -> None:
    its = {"folder": place, "above": place.parent, "file": place / "file"}[whose]
    os.chown(its, STRANGER, STRANGER)
    if whose != "file":
        reason = trusted.reason_against(place)
        assert reason is not None
        assert reason.startswith(f"{str(its)!r} belongs to the user ")
    assert read(place) is None


@needs_another_user
def test_a_group_of_others(place: Path) -> None:
    os.chown(place, -1, STRANGER)
    place.chmod(0o775)
    assert read(place) is None
    place.chmod(0o755)
    os.chown(place / "file", -1, STRANGER)
    (place / "file").chmod(0o664)
    assert read(place) is None
    (place / "file").chmod(0o644)
    assert read(place) == b"words"


@pytest.mark.parametrize("which", ["folder", "above", "file"])
def test_a_group_may_not_write_even_where_it_is_this_users_own(place: Path, which: str) -> None:
    its = {"folder": place, "above": place.parent, "file": place / "file"}[which]
    os.chown(its, -1, os.getegid())
    its.chmod(its.stat().st_mode | 0o020)
    assert read(place) is None


def test_the_file_can_be_written_by_others(place: Path) -> None:
    (place / "file").chmod(0o646)
    assert read(place) is None


def test_links_on_the_way(place: Path, tmp_path: Path) -> None:
    there = tmp_path / "link"
    there.symlink_to(place)
    assert read(there) == b"words"
    place.chmod(0o777)
    assert read(there) is None
    place.chmod(0o755)
    open_to_all = tmp_path / "open"
    open_to_all.mkdir()
    open_to_all.chmod(0o777)
    (open_to_all / "link").symlink_to(place)
    assert read(open_to_all / "link") is None  # others can let it lead elsewhere
    open_to_all.chmod(0o1777)
    assert read(open_to_all / "link") == b"words"
    (open_to_all / "here").symlink_to(".")
    (open_to_all / "file").write_bytes(b"words")
    assert read(open_to_all / "here") is None
    (open_to_all / "up").symlink_to("../above/../above/cache")
    assert read(open_to_all / "up") == b"words"
    (tmp_path / "circle").symlink_to("circle")
    assert read(tmp_path / "circle") is None
    with pytest.raises(OSError, match="circle"):
        trusted.make_folder(tmp_path / "circle")


def test_up_from_where_a_link_leads(place: Path, tmp_path: Path) -> None:
    """The system goes up from the link's target: what is checked must be what it opens."""
    open_to_all = tmp_path / "open"
    (open_to_all / "inner").mkdir(parents=True)
    (open_to_all / "cache").mkdir()
    (open_to_all / "cache" / "file").write_bytes(b"forged")
    (tmp_path / "link").symlink_to(open_to_all / "inner")
    there = tmp_path / "link" / ".." / "cache"  # without the link it would be the folder of this user
    assert read(there) == b"forged"
    open_to_all.chmod(0o777)
    assert read(there) is None
    assert "can be written by other users" in str(trusted.reason_against(there))
    assert read(place / ".." / place.name) == b"words"
    with pytest.raises(trusted.UntrustedFolderError, match="can be written by other users"):
        trusted.make_folder(there / "new")
    trusted.make_folder(tmp_path / "made" / ".." / "new")
    assert (tmp_path / "new").is_dir()


@needs_another_user
def test_a_link_of_another_user(tmp_path: Path, place: Path) -> None:
    open_to_all = tmp_path / "open"
    open_to_all.mkdir()
    open_to_all.chmod(0o1777)
    (open_to_all / "link").symlink_to(place)
    os.chown(open_to_all / "link", STRANGER, STRANGER, follow_symlinks=False)
    assert str(trusted.reason_against(open_to_all / "link")).startswith(f"{str(open_to_all / 'link')!r} belongs")
    assert read(open_to_all / "link") is None


def test_the_file_is_a_link(place: Path, tmp_path: Path) -> None:
    (place / "file").rename(tmp_path / "elsewhere")
    (place / "file").symlink_to(tmp_path / "elsewhere")
    assert read(place) is None


def _pipe(file: Path) -> None:
    os.mkfifo(file, 0o600)


def _device(file: Path) -> None:
    try:
        os.mknod(file, 0o600 | stat.S_IFCHR, os.makedev(1, 5))  # /dev/zero: without an end
    except PermissionError:
        pytest.skip("no device can be made here")


def _huge(file: Path) -> None:
    with file.open("wb") as stream:
        stream.truncate(1 << 40)  # a TiB with nothing in it
    file.chmod(0o600)


@pytest.mark.parametrize("make", [_pipe, _device, _huge, Path.mkdir, lambda file: file.symlink_to("/dev/zero")])
def test_what_is_no_small_file_is_left_alone_at_once(place: Path, make: Callable[[Path], None]) -> None:
    (place / "file").unlink()
    try:
        make(place / "file")
    except OSError as error:
        pytest.skip(f"not here: {errno.errorcode[error.errno or 0]}")
    begun = time.monotonic()
    assert read(place) is None
    assert time.monotonic() - begun < 1.0


def test_the_length_of_a_file(place: Path) -> None:
    assert trusted.read(place / "file", 5) == b"words"
    assert trusted.read(place / "file", 4) is None
    (place / "file").write_bytes(b"")
    assert trusted.read(place / "file", 0) == b""


def test_a_file_swapped_while_it_is_read(place: Path, tmp_path: Path) -> None:
    """Either the good file or nothing: never the one that all can write, whenever it is put in its place."""
    good, bad, file = tmp_path / "good", tmp_path / "bad", place / "file"
    for path, content, mode in ((good, b"words", 0o600), (bad, b"forged", 0o666)):
        path.write_bytes(content)
        path.chmod(mode)
    over = threading.Event()

    def swap() -> None:
        while not over.is_set():
            for source in (bad, good):
                copy = tmp_path / "copy"
                copy.unlink(missing_ok=True)
                os.link(source, copy)
                copy.replace(file)

    swapping = threading.Thread(target=swap)
    swapping.start()
    found = {read(place) for _ in range(2000)}
    over.set()
    swapping.join()
    assert found == {b"words", None}


def test_folders_are_made_for_this_user_alone(tmp_path: Path) -> None:
    before = os.umask(0)
    try:
        trusted.make_folder(tmp_path / "new" / "cache")
    finally:
        os.umask(before)
    assert stat.S_IMODE((tmp_path / "new").stat().st_mode) == 0o700
    assert stat.S_IMODE((tmp_path / "new" / "cache").stat().st_mode) == 0o700


def test_none_is_made_where_others_can_write(tmp_path: Path) -> None:
    tmp_path.chmod(0o777)
    with pytest.raises(trusted.UntrustedFolderError, match="can be written by other users"):
        trusted.make_folder(tmp_path / "new" / "cache")
    assert list(tmp_path.iterdir()) == []
    tmp_path.chmod(0o1777)
    trusted.make_folder(tmp_path / "new" / "cache")
    assert trusted.reason_against(tmp_path / "new" / "cache") is None


def test_without_owner_numbers_only_the_home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delattr(os, "geteuid")
    monkeypatch.setenv("HOME", str(tmp_path / "me"))
    assert trusted.reason_against(tmp_path / "me" / "cache") is None
    assert "is outside this user's home" in str(trusted.reason_against(tmp_path / "shared" / "cache"))
    (tmp_path / "me" / "cache").mkdir(parents=True)
    (tmp_path / "me" / "cache" / "file").write_bytes(b"words")
    assert read(tmp_path / "me" / "cache") == b"words"
    (tmp_path / "me" / "out").symlink_to(tmp_path)
    assert trusted.reason_against(tmp_path / "me" / "out") is not None
