"""Measured data on the page: the file, the ticks, the fit, and the sliders afterwards."""

from __future__ import annotations

import json
import math
import re
import time
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
import scipy

import springpot as sp
from springpot.explorer.fitting import fitted, freed
from springpot.explorer.protocol import FilePart, Fit, parse
from springpot.explorer.sliders import numbers
from springpot.fitting.reading import data_of
from springpot.problem.free_numbers import free_numbers
from tests.explorer.conftest import Server, running
from tests.explorer.talk import Tab, tab
from tests.explorer.test_page import SLOW_SCREEN

if TYPE_CHECKING:
    from playwright.sync_api import Browser

RUBBER = """
[[parts]]
kind = "mass"
value = 0.2

[[parts]]
kind = "spring"
stiffness = 50.0

[[parts]]
kind = "springpot"
order = { free = "order", start = 0.3, low = 0.02, high = 0.98 }
coefficient = 1.0

[[parts]]
kind = "barrier"
position = -0.003

[[parts]]
kind = "white_noise"
intensity = 0.001
"""
BARRIER = """[[parts]]
kind = "barrier"
position = -0.003

"""
TICKED = ["spring-stiffness", "springpot-order", "springpot-coefficient"]


def moduli() -> str:
    """A spring of 80 N/m beside a springpot of order 0.5 and 2 N s^0.5/m, with errors of 2 %."""
    frequency = np.geomspace(0.1, 100.0, 15)
    modulus = 80.0 + 2.0 * (2j * np.pi * frequency) ** 0.5
    noise = 1.0 + 0.02 * np.random.default_rng(1).standard_normal((2, 15))
    rows = zip(frequency, modulus.real * noise[0], modulus.imag * noise[1], strict=True)
    return "frequency_hz,storage_N/m,loss_N/m\n" + "\n".join(f"{f:.6g},{a:.6g},{b:.6g}" for f, a, b in rows)


@pytest.fixture(scope="module")
def system(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("rubber") / "rubber.toml"
    path.write_text(RUBBER, encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def rubber(system: Path) -> Iterator[Server]:
    with running(str(system)) as server:
        yield server


def test_ticked_numbers_are_free_and_no_others(system: Path) -> None:
    device = sp.read_system(system)
    free = free_numbers(freed(device, ["spring-stiffness"]))
    assert [*free] == ["spring_stiffness"]
    assert free["spring_stiffness"].low < 1.0
    assert free["spring_stiffness"].high == pytest.approx(100.0, rel=0.01)
    kept = free_numbers(freed(device, ["springpot-order"]))["springpot_order"]
    assert (kept.low, kept.high, float(kept)) == (0.02, 0.98, 0.3)
    assert float(numbers(freed(device, ["springpot-order"]))["spring-stiffness"]) == 50.0
    with pytest.raises(ValueError, match="this system has no number 'spring-order'"):
        freed(device, ["spring-order"])


def test_the_page_s_fit_is_that_of_the_library(system: Path) -> None:
    device, data = sp.read_system(system), data_of(moduli().encode(), "rubber.csv")[0]
    found = fitted(device, TICKED, data)
    same = sp.fit(freed(device, TICKED), data)
    assert [one["value"] for one in found["values"]] == [*same.values.values()]
    assert [one["error"] for one in found["values"]] == [*same.errors.values()]
    assert [len(group["at"]) for group in found["groups"]] == [15, 15]
    assert json.dumps(found, allow_nan=False)
    with pytest.raises(ValueError, match="tick the numbers"):
        fitted(device, [], data)


def test_messages_of_a_fit() -> None:
    assert parse('{"kind": "fit", "free": ["a"]}') == Fit(kind="fit", free=["a"])
    part = {"kind": "data", "name": "a.csv", "part": 0, "of": 2, "text": "x"}
    assert parse(json.dumps(part)) == FilePart(kind="data", name="a.csv", part=0, of=2, text="x")
    for change in ({"of": 10_000}, {"part": -1}, {"text": "x" * 8000}, {"name": ""}):
        with pytest.raises(ValueError, match=r"^(of|part|text|name): "):
            parse(json.dumps({**part, **change}))


def test_faults_of_a_file_are_one_sentence(rubber: Server) -> None:
    with tab(rubber) as page:
        page.say(kind="problem", generation=1, paths=64)
        page.until("accepted")
        page.say(kind="fit", free=["spring-stiffness"])
        assert page.until("refused")["sentence"] == "fit: there are no data yet."
        page.say(kind="data", name="a.csv", part=1, of=2, text="")
        assert "in their order" in page.until("refused")["sentence"]
        page.say(kind="data", name="a.csv", part=0, of=1, text="frequency_hz,storage_N/m\n1,2\n2,-3\n3,4\n")
        fault = page.until("data")["fault"]
        assert fault.startswith("a.csv, line 3: storage_N/m must")
        text = moduli()
        for part, piece in enumerate((text[:100], text[100:])):
            page.say(kind="data", name="rubber.csv", part=part, of=2, text=piece)
        assert page.until("data")["said"] == "moduli, 15 points"
        page.say(kind="fit", free=["barrier-position"])
        assert "barrier_position" in page.until("fit", running=False)["fault"]
        page.say(kind="fit", free=TICKED)
        found = page.until("fit", running=False, fault="")["values"]
        assert math.isclose(found[1]["value"], 0.5, abs_tol=4.0 * found[1]["error"])


STRUCK = """quantity,value,error
x_rms (mm),11.84,0.12
v_rms (mm/s),242,2
impact_rate (1/s),4.88,0.05
"""
"""Of 70 N/m and 1.3 N s^0.3/m."""


def test_a_fit_of_statistics_that_is_stopped_at_once_has_found_nothing(rubber: Server) -> None:
    with tab(rubber) as page:
        page.say(kind="problem", generation=1, paths=64)
        page.until("accepted")
        page.say(kind="stop-fit")  # nothing runs: nothing happens
        page.say(kind="data", name="struck.csv", part=0, of=1, text=STRUCK)
        assert page.until("data")["said"] == "statistics, 3 points"
        page.say(kind="fit", free=["spring-stiffness", "springpot-coefficient"])
        assert not page.until("fit", running=True)["done"]
        page.say(kind="stop-fit")
        fault = page.until("fit", running=False)["fault"]
        assert fault == "the fit was stopped before it had found anything."


def many_impacts(count: int) -> str:
    """A fit to them takes seconds to minutes, for the restitution of each is asked again and again."""
    return "before_m/s,after_m/s\n" + "\n".join(f"{n},{0.6 * n:g}" for n in range(1, count))


def send(page: Tab, text: str, name: str = "a.csv") -> None:
    pieces = [text[at : at + 7000] for at in range(0, len(text), 7000)]
    for part, piece in enumerate(pieces):
        page.say(kind="data", name=name, part=part, of=len(pieces), text=piece)


@pytest.mark.validation  # every day: a closed tab, in test_server.py
def test_slow_work_of_one_tab_keeps_no_other_waiting_and_ends_with_it(rubber: Server) -> None:
    with tab(rubber) as slow:
        slow.say(kind="problem", generation=1, paths=64)
        slow.until("accepted")
        send(slow, many_impacts(60_000))
        assert slow.until("data")["said"] == "impacts, 59999 points"
        slow.say(kind="fit", free=["barrier-restitution"])
        slow.until("fit", running=True)
        with tab(rubber) as quick:
            quick.say(kind="play", playing=False, speed=1.0)
            quick.say(kind="problem", generation=1, paths=64)
            quick.until("accepted")
            send(quick, moduli())
            quick.until("data", fault="")
            quick.say(kind="fit", free=TICKED)
            assert quick.until("fit", running=False, fault="", seconds=20.0)["values"]
        slow.say(kind="stop-fit")
        assert "The fit was stopped" in slow.until("fit", running=False, seconds=5.0)["warnings"][-1]  # it still ran
        slow.say(kind="fit", free=["barrier-restitution"])
        slow.until("fit", running=True)
    assert any(idle(rubber) for _ in range(10))


def idle(server: Server) -> bool:
    """Whether it computes nothing for half a second."""
    spent = server.processor_time()
    time.sleep(0.5)
    return server.processor_time() - spent < 0.05


@pytest.mark.validation
def test_a_fit_of_statistics_tells_how_far_it_is_and_stops_with_the_best_so_far(rubber: Server) -> None:
    with tab(rubber) as page:
        page.say(kind="problem", generation=1, paths=64)
        page.until("accepted")
        page.say(kind="data", name="struck.csv", part=0, of=1, text=STRUCK)
        page.until("data")
        page.say(kind="fit", free=["spring-stiffness", "springpot-coefficient"])
        told = page.until("fit", running=True)
        assert not told["done"]  # not known yet, or nothing
        while not told["done"] or told["done"] < 0.02:
            told = page.until("fit", running=True, seconds=200.0)
        page.say(kind="stop-fit")
        found = page.until("fit", running=False, seconds=200.0)
        assert found["fault"] == ""
        assert "The fit was stopped: these are the best numbers so far." in found["warnings"]
        assert [one["name"] for one in found["values"]] == ["spring-stiffness", "springpot-coefficient"]
        assert [one["name"] for one in found["statistics"]] == ["x_rms", "v_rms", "impact_rate"]
        assert [one["data"] for one in found["statistics"]] == [0.01184, 0.242, 4.88]
        assert found["groups"] == []


@pytest.mark.validation
def test_a_fit_of_statistics_comes_to_its_end_on_the_page(rubber: Server, browser: Browser) -> None:
    page = browser.new_page(viewport={"width": 1440, "height": 900})
    page.set_default_timeout(300_000)
    said: list[str] = []
    page.on("pageerror", lambda error: said.append(str(error)))
    page.goto(f"{rubber.address}#paths=64")
    page.set_input_files("#fit-file", {"name": "a.csv", "mimeType": "text/csv", "buffer": STRUCK.encode()})
    page.locator("#fit-note").filter(has_text="a.csv: statistics, 3 points.").wait_for()
    page.evaluate("controls.open = true")
    page.locator("#free-springpot-order").uncheck()
    for name in ("spring-stiffness", "springpot-coefficient"):
        page.locator(f"#free-{name}").check()
    assert page.locator("#fit-stop").is_hidden()
    page.locator("#fit-run").click()
    page.locator("#fit-progress[value]").wait_for()
    assert page.locator("#fit-stop").is_visible()
    page.locator("#fit-said").filter(has_text=re.compile(r"about \d+ (s|min) left")).wait_for()
    page.locator("#fit-table tbody tr").nth(1).wait_for()
    assert page.locator("#fit-stop").is_hidden()
    assert page.locator("#fit-warnings").inner_text() == ""
    order = page.locator("#fit-table tbody tr").first.inner_text()
    assert page.locator("#fit-statistics tbody tr").nth(2).inner_text().startswith("impact rate")
    assert page.locator("#fit-plot").is_hidden()
    page.locator("#fit-run").click()  # once more, and stopped
    while page.evaluate("document.getElementById('fit-progress').value") < 0.03:  # the third round, or so
        page.wait_for_timeout(50)
    page.locator("#fit-stop").click()
    page.locator("#fit-warnings").filter(has_text="The fit was stopped").wait_for()
    assert order.startswith("spring, stiffness")
    assert said == []
    page.close()


def test_a_file_is_fitted_and_taken_into_the_sliders(rubber: Server, browser: Browser) -> None:
    """On a large screen; what is shown fits on a phone's too."""
    page = browser.new_page(viewport={"width": 1440, "height": 900})
    page.add_init_script(SLOW_SCREEN)
    said: list[str] = []
    page.on("console", lambda message: said.append(message.text) if message.type in ("error", "warning") else None)
    page.on("pageerror", lambda error: said.append(str(error)))
    page.goto(f"{rubber.address}#paths=64")
    page.locator("#fit-run").wait_for()
    assert page.locator("#fit-run").is_disabled()
    page.set_input_files("#fit-file", {"name": "rubber.csv", "mimeType": "text/csv", "buffer": moduli().encode()})
    page.locator("#fit-note").filter(has_text="rubber.csv: moduli, 15 points.").wait_for()
    page.evaluate("controls.open = true")
    assert [page.locator(f"#free-{name}").is_checked() for name in TICKED] == [False, True, False]
    for name in TICKED:
        page.locator(f"#free-{name}").check()
    page.locator("#fit-run").click()
    page.locator("#fit-table tbody tr").nth(2).wait_for()
    assert page.locator("#fit-plot canvas").count() == 1
    for width in (390, 1440):
        page.set_viewport_size({"width": width, "height": 900})
        page.wait_for_timeout(400)
        assert page.evaluate("document.documentElement.scrollWidth") <= width
    assert page.locator("#field-springpot-order").input_value() == "0.3"
    page.locator("#fit-use").click()
    order = float(page.locator("#field-springpot-order").input_value())
    assert abs(order - 0.5) < 0.01
    found = fitted(
        sp.System(sp.Spring(50.0), sp.Springpot(0.3, 1.0), sp.WhiteNoise(1.0)),
        TICKED,
        data_of(moduli().encode(), "a")[0],
    )
    assert order == pytest.approx(found["values"][1]["value"], rel=1e-4)
    assert page.locator("#fit-set").inner_text() == ""
    page.locator("#fit-count").fill("4")
    assert page.locator("#fit-table thead").inner_text().strip().endswith("4 of these mounts")
    page.locator("#fit-use").filter(has_text="Set the sliders to 4 of these mounts").click()
    assert page.locator("#fit-set").inner_text().startswith("The sliders were set to 4 of these mounts: 4 times the")
    four = [float(page.locator(f"#field-{name}").input_value()) for name in TICKED]
    one = [number["value"] for number in found["values"]]
    assert four == pytest.approx([4.0 * one[0], one[1], 4.0 * one[2]], rel=1e-4)
    bad = {"name": "bad.csv", "mimeType": "text/csv", "buffer": b"frequency,storage\n1,2\n"}
    page.set_input_files("#fit-file", bad)
    page.locator("#fit-note.wrong").filter(has_text="bad.csv, line 1: ").wait_for()
    assert page.locator("#fit-run").is_disabled()
    assert page.locator("#fit-table tr").count() == 0
    note = page.locator("#fit-note")
    for name, content, sentence in (
        ("a.xlsx", b"PK\x03\x04\x00\x00", "a.xlsx is not text, for it has control characters: save its table as CSV."),
        ("b.csv", b"\x0b" * 9000, "b.csv is not text, for it has control characters: save its table as CSV."),
        ("c.csv", b"\\" * 9000, "c.csv, line 1: "),
        ("d.csv", ("#" + "\U0001f600" * 4000 + "\n" + moduli()).encode(), "d.csv: moduli, 15 points."),
        ("e" * 240 + ".csv", moduli().encode(), ": moduli, 15 points."),
        ("f.csv", moduli().encode("utf-16"), "f.csv: moduli, 15 points."),
        (
            "g.csv",
            "# Prüfung\n".encode("latin-1") + moduli().encode(),
            "15 points; it is not in UTF-8, and is read as Latin-1.",
        ),
        (
            "h.csv",
            b"Freq (Hz);E' (Pa);tan delta\n0,1;1;0,2\n1;1,5;0,3\n9;2,3;0,3\n",
            "3 points; its commas are decimal",
        ),
    ):
        page.set_input_files("#fit-file", {"name": name, "mimeType": "text/csv", "buffer": content})
        note.filter(has_text=sentence).wait_for()
    assert said == []
    page.close()


def shaken() -> str:
    """Six seconds of a shaker's table and of 0.2 kg on 80 N/m and 2 N s^0.5/m, with noise of 1 %."""
    rng, rate = np.random.default_rng(1), 250.0
    time = np.arange(1500) / rate
    band = scipy.signal.butter(4, (2.0, 40.0), "bandpass", fs=rate, output="sos")
    table = scipy.signal.sosfilt(band, 4.0 * rng.standard_normal(time.size))
    motion = sp.RecordedExcitation(tuple(time), tuple(table), "ground", interpolation="band-limited")
    device = sp.System(sp.Mass(0.2), sp.Spring(80.0), sp.Springpot(0.5, 2.0), motion)
    run = sp.simulate(
        device, paths=1, record=1, start="rest", step=1e-1 / rate, record_every=10, duration=time[-1], seed=1
    )
    x = run.record[0, :, 0]
    x = x + 0.01 * x.std() * rng.standard_normal(x.size)
    rows = "\n".join(f"{t:.3f},{a:.6g},{1e3 * own:.6g}" for t, a, own in zip(time, table, x, strict=True))
    return f"# start = rest\ntime_s,ground_acceleration_m/s2,x_mm\n{rows}"


@pytest.fixture(scope="module")
def mount(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    path = tmp_path_factory.mktemp("mount") / "mount.toml"
    path.write_text(RUBBER.replace(BARRIER, ""), encoding="utf-8")
    with running(str(path)) as server:
        yield server


@pytest.mark.validation  # every day: a file is fitted, in this file
def test_a_record_with_its_input_is_drawn_under_the_simulated_path(mount: Server, browser: Browser) -> None:
    page = browser.new_page(viewport={"width": 1440, "height": 900})
    page.add_init_script(SLOW_SCREEN)
    said: list[str] = []
    page.on("console", lambda message: said.append(message.text) if message.type in ("error", "warning") else None)
    page.on("pageerror", lambda error: said.append(str(error)))
    page.goto(f"{mount.address}#paths=64")
    page.set_input_files("#fit-file", {"name": "shaker.csv", "mimeType": "text/csv", "buffer": shaken().encode()})
    page.locator("#fit-note").filter(has_text="shaker.csv: record with its input, 1500 points.").wait_for()
    page.evaluate("controls.open = true")
    for name in TICKED:
        page.locator(f"#free-{name}").check()
    page.locator("#free-white_noise-intensity").check()
    page.locator("#fit-run").click()
    page.locator("#fit-note.wrong").filter(has_text="is of the excitation, and the input was measured").wait_for()
    page.locator("#free-white_noise-intensity").uncheck()
    page.locator("#fit-run").click()
    page.locator("#fit-table tbody tr").nth(2).wait_for(timeout=40_000)
    assert page.locator("#fit-plot canvas").count() == page.locator("#fit-residuals canvas").count() == 1
    legend = page.locator("#fit-legend .item").all_text_contents()
    assert legend == ["—\u2002x measured", "—\u2002x simulated"]
    for width in (390, 1440):
        page.set_viewport_size({"width": width, "height": 900})
        page.wait_for_timeout(400)
        assert page.evaluate("document.documentElement.scrollWidth") <= width
    page.locator("#fit-use").click()
    found = [float(page.locator(f"#field-{name}").input_value()) for name in TICKED]
    assert found == pytest.approx([80.0, 0.5, 2.0], rel=0.1)
    page.set_input_files("#fit-file", {"name": "a.csv", "mimeType": "text/csv", "buffer": moduli().encode()})
    page.locator("#fit-note").filter(has_text="a.csv: moduli, 15 points.").wait_for()
    assert page.locator("#fit-residuals").is_hidden()
    assert said == []
    page.close()
