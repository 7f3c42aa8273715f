"""System files and tables of data that somebody damaged or forged: one sentence each, soon, and in little memory."""

from __future__ import annotations

import random
import re
import sys
import time
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

import springpot as sp
from springpot.explorer.question import Opened
from springpot.explorer.views import opened_script
from springpot.machine.faults import FileError
from tests.explorer.conftest import Server, running
from tests.explorer.talk import Tab, tab
from tests.sizes import validation

resource = pytest.importorskip("resource", reason="limits of a process are those of Unix")
pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="limits of a process as Linux has them")

LONGEST = 2000  # characters in a sentence
SECONDS, BYTES = 10.0, 1_000_000_000  # that one file may take

SYSTEM = """
[[parts]]
kind = "mass"
value = 0.8
[[parts]]
name = "mounts"
kind = "springpot"
order = { free = "order", start = 0.3, low = 0.02, high = 0.98 }
coefficient = { free = "C", start = 150.0, low = 1.0, high = 1e4, times = 4.0, plus = 0.5 }
[[parts]]
kind = "fractional_maxwell"
springpot = { order = 0.5, coefficient = 2.0 }
spring = { stiffness = 30.0 }
[[parts]]
kind = "polynomial_spring"
coefficients = [0.0, 0.0, 3e7]
[[parts]]
name = "lower"
kind = "barrier"
position = -0.006
restitution = { restitution = 0.7, speed = 0.1, exponent = 0.25 }
[[parts]]
kind = "contact"
position = 0.005
stiffness = 1e5
exponent = 1.5
free_side = "below"
[[parts]]
kind = "recorded_excitation"
times = [0.0, 0.1, 0.2, 0.3]
values = [0.0, 1.0, -1.0, 0.5]
on = "ground"
[[parts]]
kind = "white_noise"
psd = 0.01
psd_unit = "g2/Hz"
"""
SYSTEMS = [
    SYSTEM,
    *(path.read_text(encoding="utf-8") for path in sorted(Path(__file__).parent.glob("explorer/systems/*.toml"))),
]
TABLES = [
    "# relative_error = 0.02\nfrequency_hz,storage_MPa,loss_kPa\n0.1,1.0,0.2\n1,1.5,0.4\n10,2.3,0.7\n",
    "# averages = 64\n# sampling_rate_hz = 8\n# window = hann\n# segment = 16\nfrequency_hz\tdensity_g2/Hz\n"
    "0.5\t1\n1\t2\n1.5\t3\n",
    "# averages = 8\nfrequency_hz;magnitude_m/N;phase_deg;coherence_1\n1;2;3;0.9\n2;3;4;0.8\n3;2;1;0.7\n",
    "# noise = 1e-5\ntime_ms,x_mm,x_um\n" + "".join(f"{10 * n},{n % 7},{n % 5}\n" for n in range(40)),
    "# error = 0.01\nbefore_m/s,after_mm/s\n1,700\n2,1400\n3,2100\n",
    "quantity,value,error\nx_rms (mm),2.41,0.03\nimpact_rate (1/min),97,2\nx_quantile_0.9 (mm),3,0.1\n",
]
NUMBERS = (
    "1", "2.5", "-3", "0.5", "1e-3", "7e2", "1", "2.5", "-3", "0.5", "1e-3", "7e2", "100", "0.9", "1e-12", "1e12",
    "0", "-0.0", "1e308", "-1e308", "1e-320", "1e400", "nan", "inf", "-inf", "9" * 5000, "0x1F", "1_000", "true",
    "1" + "0" * 400, "1" + "0" * 12, "1979-05-27", "١٢", "1,5", "1e", "", '"3"', "[]", "{}", "[[1]]",
    "0.9999999999999999", "1e16",
)  # fmt: skip
GARBAGE = (
    "\x00", "\x0b", "\r", "\r\n", "\ufeff", "\u2028", "\U0001f600", '"', "'", '"""', "#", "# averages = 3", "=", ",",
    ";", "\t", "[" * 400, "{a=" * 60, "[[parts]]\n" * 300, " " * 50_000, "," * 3000, ";x_m" * 5000, "a." * 4000,
    "(" * 3000, "x_rms (" + " " * 5000, "\\", "\\u0000", "_" * 20_000, "x" * 120_000, "\n" * 5000, "1," * 30_000,
)  # fmt: skip
NUMBER = re.compile(r"-?\d[\d.e+-]*")
WORD = re.compile(r"[A-Za-z_][A-Za-z_/\d]*")


def replaced(text: str, token: re.Pattern[str], other: str, rng: random.Random) -> str:
    """One of the places that a pattern finds, by something else."""
    found = [*token.finditer(text)]
    if not found:
        return text + other
    place = rng.choice(found)
    return text[: place.start()] + other + text[place.end() :]


def moved(text: str, rng: random.Random) -> str:
    """A piece taken out and put elsewhere, once or many times, or not at all."""
    begin = rng.randrange(len(text) + 1)
    piece = text[begin : begin + rng.choice((1, 10, 100, 1000))]
    rest = text[:begin] + text[begin + len(piece) :] if rng.random() < 0.5 else text
    at = rng.randrange(len(rest) + 1)
    return rest[:at] + piece * rng.choice((0, 1, 2, 300)) + rest[at:]


def inserted(text: str, rng: random.Random) -> str:
    at = rng.randrange(len(text) + 1)
    return text[:at] + rng.choice(GARBAGE) + text[at:]


def damaged(text: str, rng: random.Random) -> str:
    """One to eight changes, most of which leave something that can nearly be read."""
    for _ in range(rng.choice((1, 1, 1, 2, 8))):
        kind = rng.randrange(8)
        if kind < 4:
            text = replaced(text, NUMBER, rng.choice(NUMBERS), rng)
        elif kind < 6:
            text = replaced(text, WORD, rng.choice((*WORD.findall(text), "x", "free", "psd")), rng)
        else:
            text = (moved if kind == 6 else inserted)(text, rng)
        text = text[:1_000_000]
    return text


def raw(text: str, rng: random.Random) -> bytes:
    """In UTF-8, or nearly."""
    content = bytearray(text.encode("utf-8", "surrogatepass"))
    if content and rng.random() < 0.1:
        content[rng.randrange(len(content))] = rng.randrange(256)
    return bytes(content)


@contextmanager
def limited() -> Iterator[None]:
    """Little memory, and little time, whatever comes of it."""
    taken = int(Path("/proc/self/statm").read_text(encoding="utf-8").split()[0]) * resource.getpagesize()
    before = resource.getrlimit(resource.RLIMIT_AS)
    resource.setrlimit(resource.RLIMIT_AS, (taken + BYTES, before[1]))
    start = time.process_time()
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, before)
        assert time.process_time() - start < SECONDS  # of this process: others may be busy


def tried(function: Callable[..., Any], *args: object, kind: type[ValueError] = FileError) -> tuple[Any, str]:
    """What comes of it within the limits, and the sentence with which this library refuses it, or an empty one."""
    try:
        with limited():
            return function(*args), ""
    except kind as fault:
        *_, (frame, _line) = traceback.walk_tb(fault.__traceback__)
        ours = Path(sp.__file__).parent in Path(frame.f_code.co_filename).parents
        return None, str(fault) if ours else f"foreign: {fault!r}"


def is_sentence(text: str, begin: str | tuple[str, ...]) -> bool:
    return not text or (text.startswith(begin) and text.isprintable() and len(text) < LONGEST)


@pytest.mark.parametrize("seeds", [range(40), validation(range(40, 1040))])
def test_damaged_systems(seeds: range, tmp_path: Path) -> None:
    """What is read can be written, read again and opened as a page."""
    place, refused = tmp_path / "system.toml", 0
    for seed in seeds:
        rng = random.Random(seed)
        place.write_bytes(raw(damaged(rng.choice(SYSTEMS), rng), rng))
        system, said = tried(sp.read_system, place)
        assert is_sentence(said, f"system file {str(place)!r} "), (seed, said)
        if said:
            refused += 1
            continue
        place.write_text(sp.to_toml(system), encoding="utf-8")
        assert sp.read_system(place) == system
        _, said = tried(opened_script, Opened(system), kind=ValueError)
        assert is_sentence(said, ("the ", "system must ", "natural_frequency must ")), (seed, said)
    assert 0.3 * len(seeds) < refused < len(seeds)


@pytest.mark.parametrize("seeds", [range(40), validation(range(40, 1040))])
def test_damaged_tables(seeds: range, tmp_path: Path) -> None:
    place, refused = tmp_path / "data.csv", 0
    for seed in seeds:
        rng = random.Random(seed)
        place.write_bytes(raw(damaged(rng.choice(TABLES), rng), rng))
        _, said = tried(sp.read_data, place)
        assert is_sentence(said, f"data file {str(place)!r}"), (seed, said)
        refused += bool(said)
    assert 0.3 * len(seeds) < refused < len(seeds)


RUBBER = sp.Springpot(0.5, 3.0)
NOT_HELD = "system must have a spring, or a wall on each side: without them nothing holds the mass in place."


@pytest.mark.parametrize(
    ("parts", "sentence"),
    [
        ((RUBBER,), NOT_HELD),
        ((sp.Mass(2.0), sp.Spring(0.0), RUBBER), NOT_HELD),
        ((sp.Spring(-20.0), sp.PolynomialSpring((0.0, 0.0, 1e-320)), RUBBER), NOT_HELD),
        ((sp.Spring(20.0), sp.PolynomialSpring((0.0, 0.0, 1e-320)), RUBBER), ""),
        ((sp.Spring(31.0), RUBBER, sp.Barrier(0.2, 0.8, free_side="above"), sp.ColoredNoise(1.0, 0.5)), ""),
        (
            (sp.Spring(1e12), RUBBER, sp.Barrier(1.0, free_side="above"), sp.ThermalNoise(1e-18)),
            "system must move by more than rounding",
        ),
    ],
)  # fmt: skip
def test_systems_that_were_found_so(parts: tuple[object, ...], sentence: str) -> None:
    """Each ended in an error or a warning of NumPy, in a run as on the page."""
    noise = () if isinstance(parts[-1], sp.ColoredNoise | sp.ThermalNoise) else (sp.WhiteNoise(0.1),)
    system = sp.System(*parts, *noise)
    _, said = tried(opened_script, Opened(system), kind=ValueError)
    assert said.startswith(sentence)
    assert bool(said) == bool(sentence)
    if sentence:
        with pytest.raises(ValueError, match=re.escape(sentence)):
            sp.simulate(system, paths=64)


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("frequency_hz,storage_GPa\n1,1\n2,1e308\n3,1\n", "line 3: storage_GPa must be a finite number, not inf."),
        ("frequency_hz,magnitude_m/N,phase_deg\n1,1,1\n2,1,inf\n3,1,1\n", "line 3: phase_deg must be a finite number"),
        ("# averages = 8\nfrequency_hz,real_m/N,imaginary_m/N,coherence_1\n1,1,1,0.9\n2,1,1,1e-320\n3,1,1,0.9\n",
         "line 4: coherence_1 is too small"),
        (TABLES[1].replace("16", "1" + 400 * "0"), "segment must be a whole number of samples from 8 to 1"),
    ],
)  # fmt: skip
def test_tables_that_were_found_so(text: str, sentence: str, tmp_path: Path) -> None:
    """Each ended in an error or a warning of NumPy."""
    place = tmp_path / "data.csv"
    place.write_text(text, encoding="utf-8")
    assert sentence in tried(sp.read_data, place)[1]


@pytest.fixture(scope="module")
def device(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    place = tmp_path_factory.mktemp("attack") / "device.toml"
    place.write_text(SYSTEMS[-1], encoding="utf-8")
    with running(str(place)) as server:
        yield server


def upload(page: Tab, rng: random.Random) -> None:
    """A damaged table in parts; now and then the parts are not what they say."""
    text = damaged(rng.choice(TABLES), rng).encode("utf-8", "replace").decode()[:150_000]
    pieces = [text[at : at + 7000] for at in range(0, max(len(text), 1), 7000)]
    name = rng.choice(("a.csv", "../../etc/passwd", "<script>.csv", "\x00", "x" * 200, "😀.csv"))
    for part, piece in enumerate(pieces):
        wrong = rng.random() < 0.02
        page.say(kind="data", name=name, part=part + wrong, of=len(pieces), text=piece)
        if wrong:
            return


@pytest.mark.parametrize("seeds", [range(40), validation(range(40, 1040))])
def test_damaged_uploads_to_the_page(seeds: range, device: Server) -> None:
    """Each gets an answer soon, and the page goes on."""
    taken = []
    for begin in range(seeds.start, seeds.stop, 10):  # a page that goes on sending what is refused is closed
        with tab(device) as page:
            page.say(kind="play", playing=False, speed=1.0)
            for seed in range(begin, begin + 10):
                upload(page, random.Random(seed))
                start = time.perf_counter()
                while (heard := page.hear(SECONDS))[0] not in ("data", "refused"):
                    pass
                assert time.perf_counter() - start < SECONDS
                said = heard[1].get("fault") or heard[1].get("sentence") or heard[1]["said"]
                assert 0 < len(said) < LONGEST, seed
                assert not re.match(r"[A-Za-z]+(Error|Exception): ", said), (seed, said)
                taken.append(heard[1].get("said", "") != "")
                time.sleep(0.01)  # no more messages a second than a page may send
    assert 0.05 * len(seeds) < sum(taken) < len(seeds)
    assert device.process.poll() is None
    assert device.memory() < BYTES / 1e6
