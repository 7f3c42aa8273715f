"""What is installed: the wheel's content, and the installed command in an empty environment and an empty folder."""

from __future__ import annotations

import json
import os
import platform
import re
import shutil
import subprocess
import sys
import tomllib
import urllib.request
import zipfile
from pathlib import Path

import pytest

from springpot.machine.installed import EXTRAS
from springpot.simulation.kernel.make_objects import SHIPPED
from springpot.simulation.kernel.native import ENTRIES
from springpot.simulation.kernel.targets import TARGETS

ROOT = Path(__file__).resolve().parents[1]
NETWORK_TROUBLE = ("failed to fetch", "error sending request", "dns error", "network connectivity is disabled")


def uv(*words: str) -> str:
    own = ROOT / ".tools" / "bin" / "uv"
    program = str(own) if own.exists() else shutil.which("uv")
    if program is None:
        pytest.skip("uv is neither in .tools/bin nor on the path: run make setup")
    done = subprocess.run([program, *words], cwd=ROOT, capture_output=True, text=True, timeout=300)
    if done.returncode and any(trouble in done.stderr.lower() for trouble in NETWORK_TROUBLE):
        pytest.skip("the package index cannot be reached")
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("wheel")
    uv("build", "--wheel", "--out-dir", str(folder))
    (built,) = folder.glob("*.whl")
    return built


def test_the_wheel_holds_the_package_and_nothing_else(wheel: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        names = set(archive.namelist())
    assert "springpot/py.typed" in names
    sources = {path.relative_to(ROOT / "src").as_posix() for path in (ROOT / "src" / "springpot").rglob("*.py")}
    assets = ROOT / "src" / "springpot" / "explorer" / "static"
    sources |= {path.relative_to(ROOT / "src").as_posix() for path in assets.rglob("*") if path.is_file()} | {
        "springpot/py.typed",
        "springpot/evidence/atlases/atlas.npz",
        "springpot/theory/methods/envelope/losses.npz",
        "springpot/evidence/validity.csv",
        "springpot/evidence/validity_systems.csv",
    }
    objects = "springpot/simulation/kernel/objects/"  # compiled code, where `make objects` has been run here
    assert {name for name in names if ".dist-info/" not in name and not name.startswith(objects)} == sources
    assert any(name.endswith(".dist-info/licenses/LICENSE") for name in names)


WITH_OBJECTS = """
import sys
from springpot.simulation.kernel.native import ENTRIES
from springpot.simulation.kernel.native import normals
assert 0.8 < normals(seed=3, paths=70, steps=9).std() < 1.2
print(all(entry.load().how.startswith("of this installation, for ") for entry in ENTRIES), "numba" in sys.modules)
"""


@pytest.mark.validation
@pytest.mark.skipif(not any(each.here for each in TARGETS), reason="no object is made for this machine")
def test_a_released_wheel_brings_compiled_code_and_uses_it(tmp_path: Path) -> None:
    """Built as a release is, from a copy of this folder; then Numba is not even imported, and nothing is kept."""
    copy, environment = tmp_path / "copy", {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    shutil.copytree(ROOT / "src", copy / "src", ignore=shutil.ignore_patterns("__pycache__", "objects"))
    for name in ("pyproject.toml", "README.md", "LICENSE", ".gitignore", "CHANGELOG.md"):
        shutil.copy(ROOT / name, copy)

    def python(folder: Path, *words: str) -> str:
        done = subprocess.run(
            [sys.executable, *words], cwd=tmp_path, capture_output=True, text=True, timeout=600,
            env={**environment, "PYTHONPATH": str(folder), "NUMBA_CACHE_DIR": str(tmp_path / "cache")},
        )  # fmt: skip
        assert done.returncode == 0, done.stderr
        return done.stdout

    made = python(copy / "src", "-m", "springpot.simulation.kernel.make_objects").splitlines()
    assert len(made) == len(SHIPPED) * len(ENTRIES)
    uv("build", "--wheel", "--out-dir", str(tmp_path), str(copy))
    (built,) = tmp_path.glob("*.whl")
    with zipfile.ZipFile(built) as archive:
        archive.extractall(tmp_path / "installed")
    names = {file.name for file in (tmp_path / "installed").rglob("objects/*")}
    assert names == {"manifest.json", *(line.split(":")[0] for line in made)}
    assert python(tmp_path / "installed", "-c", WITH_OBJECTS) == "True False\n"
    assert not (tmp_path / "cache").exists()


def test_the_wheel_announces_the_command(wheel: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        (entry,) = [name for name in archive.namelist() if name.endswith("entry_points.txt")]
        assert "springpot = springpot.__main__:main" in archive.read(entry).decode()


def test_the_lock_names_the_public_index_only() -> None:
    lock = tomllib.loads((ROOT / "uv.lock").read_text(encoding="utf-8"))
    allowed = ("https://pypi.org/", "https://files.pythonhosted.org/")
    for package in lock["package"]:
        files = [package["sdist"]] if "sdist" in package else []
        addresses = [file["url"] for file in [*files, *package.get("wheels", [])]]
        addresses += [address for kind, address in package["source"].items() if kind == "registry"]
        assert all(address.startswith(allowed) for address in addresses), package["name"]


def first_files_of_the_page(command: Path, folder: Path) -> tuple[str, str]:
    """The page and its first script, from a server that is started for it."""
    words = [str(command), "explore", "--no-browser", "--port", "0"]
    with subprocess.Popen(words, cwd=folder, stdout=subprocess.PIPE, text=True) as serving:
        try:
            assert serving.stdout is not None
            address = next(word for word in serving.stdout.readline().split() if word.startswith("http://"))
            with urllib.request.urlopen(address, timeout=60) as page:
                text = page.read().decode()
            with urllib.request.urlopen(address + "static/js/main.js", timeout=60) as script:
                return text, script.read().decode()
        finally:
            serving.kill()


def test_the_package_in_the_wheel_answers_in_an_empty_folder(wheel: Path, tmp_path: Path) -> None:
    """Theory, the validity map and the atlas, from the files of the wheel alone."""
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(tmp_path / "installed")
    empty = tmp_path / "empty"
    empty.mkdir()
    code = (
        "import sys; from springpot import __file__ as here, cli\n"
        "assert cli.main(['theory', '--restitution', '0.8']) == cli.main(['atlas']) == cli.main(['--version']) == 0\n"
        "print(here)"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=empty, env={**os.environ, "PYTHONPATH": str(tmp_path / "installed")},
        capture_output=True, text=True, timeout=300,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert "recommended here" in done.stdout
    assert done.stdout.splitlines()[-1] == str(tmp_path / "installed" / "springpot" / "__init__.py")
    assert list(empty.iterdir()) == []


def test_each_extra_installs_what_it_is_said_to_bring() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    declared = project["optional-dependencies"]

    def brought(extra: str) -> set[str]:
        found: set[str] = set()
        for line in declared[extra]:
            name, others = re.fullmatch(r"([\w-]+)(?:\[(.*)\])?.*", line).groups("")  # type: ignore[union-attr]
            if name == "springpot":
                found = found.union(*map(brought, others.split(",")))
            else:
                found |= {name, *filter(None, [others])}
        return found

    assert {extra: brought(extra) for extra in EXTRAS} == {extra: set(names) for extra, names in EXTRAS.items()}
    assert brought("all") == set().union(*EXTRAS.values()) - set(EXTRAS["op4"])  # of which macOS has no wheels
    assert declared.keys() == {*EXTRAS, "all"}


WITHOUT_EXTRAS = """
import sys
from importlib.machinery import PathFinder
from springpot.machine.installed import EXTRAS, MissingExtraError
class Core(PathFinder):
    @classmethod
    def find_spec(cls, name, path=None, target=None):
        return None if name in set().union(*EXTRAS.values()) else PathFinder.find_spec(name, path, target)
sys.meta_path[sys.meta_path.index(PathFinder)] = Core
import springpot as sp
from springpot import cli
sp.simulate(sp.Oscillator(), paths=64, duration=4.0)
assert not {"scipy.linalg", "scipy.optimize", "scipy.sparse", "scipy.special"} & sys.modules.keys()  # slow to import
asked_for = (  # by other runs
    "simulation.error.", "simulation.rare.", "simulation.result.load", "simulation.result.save", "simulation.watch.",
    "theory.methods.",
)
loaded = {name for name in sys.modules if name.removeprefix("springpot.").startswith(asked_for)}
assert loaded == {"springpot.simulation.watch.requested"}, loaded
assert cli.main(["theory", "--restitution", "0.8"]) == cli.main(["atlas"]) == 0
words = ["simulate", "--paths", "64", "--duration", "1", "--out"]
assert cli.main([*words, "run.json"]) == cli.main([*words, "run.csv"]) == 0
run = sp.load_run("run.json")
assert cli.main([*words, "run.nc"]) == cli.main(["study", "new", "a.toml"]) == cli.main(["explore"]) == 1
assert cli.main(["compare", "--plot", "a.png"]) == 1
for use in (run.to_xarray, lambda: run.save("run.nc"), lambda: sp.figures, lambda: sp.study, lambda: sp.explore):
    try:
        use()
    except MissingExtraError as error:
        print(error)
"""


def test_the_core_works_without_any_extra(tmp_path: Path) -> None:
    """Theory, atlas, simulation, files of text; each use that needs more says which command adds it."""
    done = subprocess.run(
        [sys.executable, "-c", WITHOUT_EXTRAS], cwd=tmp_path, capture_output=True, text=True, timeout=300
    )
    assert done.returncode == 0, done.stderr
    files = "h5netcdf, h5py, pandas and xarray"
    expected = [
        ("run.to_xarray()", files, "files"),
        ("a netCDF file (.nc)", files, "files"),
        ("a picture", "matplotlib, h5netcdf, h5py, pandas and xarray", "plots"),
        ("a study", "pydantic, zarr, h5netcdf, h5py, pandas and xarray", "studies"),
        ("the page in the browser", "pydantic, starlette, uvicorn and websockets", "page"),
    ]
    sentences = [
        f'{what} needs {missing}, not installed here: python3 -m pip install "springpot[{extra}]" adds what is missing.'
        for what, missing, extra in expected
    ]
    assert done.stdout.splitlines()[-len(sentences) :] == sentences
    told = [line for line in done.stderr.splitlines() if "not installed" in line]
    assert told == [f"springpot: {sentences[i]}" for i in (1, 3, 4, 2)]


@pytest.mark.validation
def test_the_installed_command_works_in_an_empty_folder(wheel: Path, tmp_path: Path) -> None:
    """In an environment that holds only the wheel and what it asks for; with and without the widest vectors."""
    locked = tmp_path / "locked.txt"
    locked.write_text(
        uv("export", "--frozen", "--all-extras", "--no-dev", "--no-emit-project", "--no-hashes"), encoding="utf-8"
    )
    environment = tmp_path / "environment"
    uv("venv", "--python", sys.executable, str(environment))
    programs = environment / ("Scripts" if sys.platform == "win32" else "bin")
    python = programs / "python"
    uv("pip", "install", "--python", str(python), "--constraints", str(locked), f"{wheel}[page]")
    empty = tmp_path / "empty"
    empty.mkdir()

    def springpot(*words: str, **variables: str) -> str:
        clean = {name: value for name, value in os.environ.items() if not name.startswith(("NUMBA_", "PYTHON"))}
        done = subprocess.run(
            [str(programs / "springpot"), *words],
            cwd=empty,
            env={**clean, **variables},
            capture_output=True,
            text=True,
            timeout=300,
        )
        assert done.returncode == 0, done.stderr
        return done.stdout

    assert "self-check passed" in springpot("doctor")
    words = ["simulate", "--order", "1", "--paths", "2000", "--duration", "50", "--step", "0.01", "--json"]
    native = json.loads(springpot(*words))
    assert abs(native["amplitude_mean_square"] - 1.0) < 5.0 * native["amplitude_mean_square_se"] + 0.005

    page, script = first_files_of_the_page(programs / "springpot", empty)
    assert "springpot" in page
    assert "import" in script

    if platform.machine() == "x86_64":
        # The name alone leaves the host's extensions switched on; the empty list of features takes them away.
        plain = {"NUMBA_CPU_NAME": "x86-64-v3", "NUMBA_CPU_FEATURES": ""}
        findings = json.loads(springpot("doctor", "--json", **plain))
        assert findings["processor"]["name"] == "x86-64-v3"
        assert "avx512f" not in findings["processor"]["vector"]
        assert findings["self_check"]["passed"]
        again = json.loads(springpot(*words, **plain))
        assert abs(again["amplitude_mean_square"] - native["amplitude_mean_square"]) < 1e-3
    assert list(empty.iterdir()) == []
