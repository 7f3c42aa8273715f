"""What Windows lacks stands in one module of the library, and each text file says its encoding."""

from __future__ import annotations

from tests.house.platforms import ROOT, files, lacking, not_in_windows, without_encoding

# who asks for it before use, or is skipped whole with a reason
ASKING = {
    "src/springpot/machine/platforms.py": "the one module",
    "tests/posix.py": "skips", "tests/strangers.py": "marks", "tests/conftest.py": "skips: only root may mount",
    "tests/machine/test_trusted.py": "needs_owners", "tests/explorer/conftest.py": "for tests that need /proc",
    "tests/memory/test_store.py": "needs_another_user", "tests/simulation/kernel/test_cache.py": "needs_another_user",
    "tests/simulation/kernel/test_native.py": "needs_another_user", "tests/studies/test_running.py": "needs_signals",
}  # fmt: skip


def test_what_windows_lacks_is_known() -> None:
    assert {"fork", "geteuid", "mkfifo", "killpg", "chown"} <= lacking()["os"]
    assert {"SIGKILL", "SIGALRM", "pthread_sigmask"} <= lacking()["signal"]
    assert not {"kill", "replace", "chmod", "link"} & lacking()["os"]
    assert {"fcntl", "resource", "pwd", "grp", "termios"} <= {
        name for name, of in lacking().items() if of == {"import"}
    }
    assert not {"msvcrt", "json", "errno"} & lacking().keys()


def test_it_is_found() -> None:
    text = "import resource, os\nfrom os import fork, getpid\nos.killpg(1, 2)\nos.kill(1, 2)\n"
    assert not_in_windows(text) == [(1, "import resource"), (2, "from os import fork"), (3, "os.killpg")]


def test_it_stands_in_one_module_and_where_tests_ask_for_it() -> None:
    found = {}
    for folder in ("src", "tests"):
        for file in files(folder):
            if lines := not_in_windows(file.read_text(encoding="utf-8")):
                found[file.relative_to(ROOT).as_posix()] = lines
    assert {name: lines for name, lines in found.items() if name not in ASKING} == {}
    assert found.keys() == ASKING.keys()


def test_each_text_file_says_its_encoding() -> None:
    text = "open('a')\nopen('a', 'rb')\nplace.read_text()\nplace.write_text('a', encoding='utf-8')\nread_text('a')\n"
    assert without_encoding(text) == [(1, "open"), (3, "read_text")]
    found = {}
    for file in files("src"):
        if lines := without_encoding(file.read_text(encoding="utf-8")):
            found[file.relative_to(ROOT).as_posix()] = lines
    assert found == {}
