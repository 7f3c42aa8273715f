"""Uncertain numbers on the page: tolerances beside the sliders, devices that differ, the link and the file."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

import springpot as sp
from springpot.explorer.protocol import Problem, Scatter, parse
from springpot.explorer.question import Opened, question_of
from springpot.explorer.scattering import quantities_of, scattered
from springpot.explorer.views import opened_script
from springpot.machine.faults import Stopped
from springpot.problem.file import to_toml
from springpot.problem.free_numbers import uncertain_numbers
from tests.explorer.conftest import Server, running
from tests.explorer.talk import tab
from tests.explorer.test_page import CUT, OVERLAPPING, opened

if TYPE_CHECKING:
    from playwright.sync_api import Browser, BrowserContext

GAP = sp.uncertain("gap", 0.006, sd=0.0006, bounds=(0.003, 0.009))
DEVICE = sp.System(
    sp.Mass(0.8), sp.Spring(sp.uncertain("k", 3200.0, cov=0.05)),
    sp.Springpot(sp.uncertain("order", bounds=(0.28, 0.32)), sp.uncertain("C", 150.0, cov=0.10)),
    lower=sp.Barrier(-GAP, 0.7), upper=sp.Barrier(GAP, 0.7, free_side="below"),
    noise=sp.WhiteNoise.from_psd(0.01, "g2/Hz"),
)  # fmt: skip
OPENED = Opened(DEVICE, "device.toml")
QUICK = "paths=64"
RUN = {"devices": 64, "seed": 1, "threads": 1}
SHOWN = "!document.querySelector('#scatter-found').hidden"


@pytest.fixture(scope="module")
def mount(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    path = tmp_path_factory.mktemp("mount") / "device.toml"
    path.write_text(to_toml(DEVICE), encoding="utf-8")
    with running(str(path)) as server:
        yield server


@pytest.fixture(scope="module")
def context(browser: Browser) -> Iterator[BrowserContext]:
    made = browser.new_context(viewport={"width": 1400, "height": 900}, accept_downloads=True)
    yield made
    made.close()


def asked(**given: Any) -> tuple[sp.System, str]:
    """The devices of a question, and the name of their file."""
    question = question_of(Problem(**given), OPENED)
    assert not uncertain_numbers(question.system)
    return question.devices, question.file


def test_what_the_file_has_is_told() -> None:
    (_, text) = opened_script(OPENED).split(" = ", 1)
    told = {one["name"]: one for one in json.loads(text.rstrip(";\n"))["sliders"]}
    tolerances = {name: one["tolerance"] for name, one in told.items()}
    assert tolerances["spring-stiffness"] | {"follows": None} == {
        "name": "k", "kind": "cov", "spread": 0.05, "other": False, "follows": None,
    }  # fmt: skip
    assert (tolerances["springpot-order"]["kind"], tolerances["springpot-order"]["other"]) == ("sd", True)
    assert [tolerances[f"{wall}-position"]["follows"] for wall in ("lower", "upper")] == [[-1, 0, 1], [1, 0, 1]]
    assert (told["lower-position"]["hint"], told["lower-position"]["free"]) == ("−gap", False)
    kinds = {name: one["kind"] for name, one in tolerances.items()}
    assert kinds["mass-value"] == kinds["noise-intensity"] == "cov"
    assert kinds["lower-restitution"] == kinds["upper-position"] == "sd"


def test_a_tolerance_moves_with_its_number() -> None:
    """In per cent of a lognormal law, as wide as before of others; the numbers that follow from one stay one."""
    assert asked() == (DEVICE, "device.toml")
    devices, file = asked(numbers={
        "spring-stiffness": 1600.0, "springpot-order": 0.5, "lower-position": -0.005, "upper-position": 0.005,
    })  # fmt: skip
    laws = {name: number.law for name, number in uncertain_numbers(devices).items()}
    moved = sp.uncertain("gap", 0.005, sd=0.0006, bounds=(0.002, 0.008))
    assert laws["k"] == sp.uncertain("k", 1600.0, cov=0.05).law
    assert (laws["order"].low, laws["order"].high) == pytest.approx((0.48, 0.52))
    assert laws["gap"].law == moved.law.law
    assert (laws["gap"].low, laws["gap"].high) == pytest.approx((0.002, 0.008))
    assert file == "device-changed.toml"
    with pytest.raises(ValueError, match="gap must have the same value and law wherever it stands"):
        asked(numbers={"lower-position": -0.005})


def test_tolerances_are_given_and_taken_away() -> None:
    devices, file = asked(tolerances={"k": 0.1, "C": 0.0, "order": 0.01, "lower_restitution": 0.02, "mass_value": 0.01})
    found = uncertain_numbers(devices)
    assert found["k"].law == sp.uncertain("k", 3200.0, cov=0.1).law
    assert found["order"].law == sp.uncertain("order", float(found["order"]), sd=0.01).law
    assert found["lower_restitution"].law == sp.uncertain("r", 0.7, sd=0.02).law
    assert found["mass_value"].law == sp.uncertain("m", 0.8, cov=0.01).law
    assert "C" not in found
    assert file == "device-changed.toml"  # though its nominal numbers are those of the file
    near_one, _ = asked(numbers={"lower-restitution": 0.95}, tolerances={"lower_restitution": 0.02})
    assert uncertain_numbers(near_one)["lower_restitution"].law.high == 1.0  # what is beyond is left out
    wide, _ = asked(tolerances={"gap": 0.001})
    assert [wall.position.law for wall in wide.of(sp.Barrier)] == [  # type: ignore[attr-defined]
        sp.uncertain("gap", 0.006, sd=0.001, bounds=(0.003, 0.009)).law
    ] * 2
    assert "gap" not in uncertain_numbers(asked(without=["lower", "upper"], tolerances={"gap": 0.001})[0])


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        ({"tolerances": {"lower_restitution": 0.5}}, "bounds must leave out at most 5 % of the law"),
        ({"tolerances": {"k": 3.0}}, "cov must be"),
        ({"tolerances": {"gap": 0.01}}, "bounds must leave out at most 5 %"),
        ({"tolerances": {"nothing": 0.1}}, "tolerances: this system has no number 'nothing'"),
        ({"numbers": {"springpot-order": 0.99}}, "order must be"),
    ],
)
def test_refused_tolerances_are_one_sentence(given: dict[str, Any], sentence: str) -> None:
    with pytest.raises(ValueError, match=sentence) as fault:
        asked(**given)
    assert "\n" not in str(fault.value)
    with pytest.raises(ValueError, match="greater than or equal to 0"):
        parse('{"kind": "problem", "tolerances": {"k": -0.1}}')


def test_a_law_of_python_s_stays_where_it_is() -> None:
    from scipy import stats

    own = Opened(sp.System(sp.Spring(sp.uncertain("k", law=stats.norm(80.0, 4.0))), sp.Dashpot(1.0), sp.WhiteNoise(1)))
    assert "k" in question_of(Problem(), own).laws
    with pytest.raises(ValueError, match="k has a law of its own"):
        question_of(Problem(numbers={"spring-stiffness": 90.0}), own)


def test_copies_have_the_devices() -> None:
    question = question_of(Problem(seed=3), OPENED)
    assert question.command == "springpot scatter device.toml --seed 3"
    for line in (
        "devices = sp.read_system('device.toml')",
        "system = sp.nominal(devices)",
        "sp.scatter(devices, seed=3)",
    ):
        assert line in question.python
    assert "simulate" in question_of(Problem(), Opened()).command


def test_the_page_s_scatter_is_that_of_the_library() -> None:
    """The same bits as `scatter` with the same arguments; it can be stopped, and needs a tolerance."""
    names = quantities_of(sp.nominal(DEVICE))
    assert names == ["impact_rate", "lower_impact_rate", "upper_impact_rate", "x_mean_square", "v_mean_square"]
    assert quantities_of(sp.System(sp.Spring(4.0), sp.Dashpot(0.5), sp.WhiteNoise(1.0))) == names[3:]
    found, same = scattered(DEVICE, "mm", RUN, lambda _: None, lambda: False), sp.scatter(DEVICE, names, **RUN)
    assert json.dumps(found, allow_nan=False)
    result, own = found["results"][0], same["impact_rate"]
    assert result["title"] == "impact rate"
    numbers = dict(result["numbers"])
    assert numbers["5 % of the devices are below"].startswith(f"{own.quantiles[0.05].value:.4g} 1/s (")
    assert numbers["standard deviation from device to device"].startswith(f"{own.scatter.value:.3g} 1/s (")
    order = [one["name"] for one in result["inputs"]]
    assert {*order} == {"k", "order", "C", "gap"}
    assert result["inputs"][0]["alone"] == [
        own.alone[order[0]].value,
        own.alone[order[0]].low,
        own.alone[order[0]].high,
    ]
    assert result["charts"][0]["mark"] == same.nominal["impact_rate"].value
    squares = same["x_mean_square"]
    result = found["results"][3]
    assert result["title"] == "x mean square"
    assert dict(result["numbers"])["5 % of the devices are below"].startswith(
        f"{1e6 * squares.quantiles[0.05].value:.4g} mm² ("
    )
    assert result["charts"][0]["mark"] == pytest.approx(1e6 * same.nominal["x_mean_square"].value)
    with pytest.raises(Stopped):
        scattered(DEVICE, "m", RUN, lambda _: None, lambda: True)
    with pytest.raises(ValueError, match="tolerances: no number has one"):
        scattered(sp.nominal(DEVICE), "m", RUN, lambda _: None, lambda: False)


def test_a_tab_asks_for_devices(mount: Server) -> None:
    """Over the wire: results, the file, a stop, and what is refused."""
    assert parse('{"kind": "scatter"}') == Scatter(kind="scatter", devices=512)
    with pytest.raises(ValueError, match="devices: "):
        parse('{"kind": "scatter", "devices": 9}')
    with tab(mount) as page:
        page.say(kind="problem", generation=1, paths=64, tolerances={"C": 0.2})
        laws = page.until("accepted")["laws"]
        assert laws["order"] == "from 0.28 to 0.32"
        page.say(kind="file")
        assert "value = 150.0, cov = 0.2" in page.until("file")["text"]
        page.say(kind="scatter", devices=64)
        assert len(page.until("scatter", running=False, fault="")["results"]) == 5
        page.say(kind="scatter", devices=4096)
        page.until("scatter", running=True)
        page.say(kind="stop-scatter")
        assert page.until("scatter", running=False)["fault"] == "it was stopped."
        page.say(kind="scatter", devices=100)
        assert "devices must be a power of two" in page.until("scatter", running=False)["fault"]


@pytest.mark.validation  # every day: tolerances by hand; the results, over the wire
def test_devices_that_differ_on_the_page(mount: Server, context: BrowserContext) -> None:
    """Fields show what the file has; devices are simulated, and each result is shown; other numbers clear it."""
    with opened(context, mount, QUICK) as tab:
        page = tab.page
        assert page.locator("#tolerance-spring-stiffness").input_value() == "5"
        assert page.locator("#tolerance-lower-position").input_value() == "0.6"  # mm
        assert page.locator("#tolerance-springpot-order").input_value() == ""
        assert page.get_by_text("from 0.28 to 0.32", exact=True).is_visible()
        assert page.locator("#tolerance-mass-value").is_hidden()
        page.locator("#tolerances").check()
        assert page.locator("#tolerance-mass-value").is_visible()
        page.locator("#asked").scroll_into_view_if_needed()
        page.locator("#scatter-form").wait_for()
        assert (
            "spring, stiffness ± 5 %; springpot, order (from 0.28" in page.locator("#scatter-numbers-of").inner_text()
        )
        page.locator("[name=devices]").select_option("256")
        page.locator("#scatter-run").click()
        page.locator("#scatter-stop").wait_for()
        tab.wait(SHOWN)
        rows = page.locator("#scatter-numbers tr")
        assert rows.first.inner_text().startswith("nominal device")
        first = page.locator("#scatter-numbers").inner_text()
        for words in ("mean over devices", "from device to device", "5 % of the devices", "95 % of the devices", "±"):
            assert words in first
        assert page.locator("#scatter-charts canvas").count() == 1
        assert page.locator("#scatter-bars h4").all_inner_texts()[0] == "gap: lower, position and upper, position"
        assert page.locator("#scatter-bars .alone").count() == page.locator("#scatter-bars .together").count() == 4
        wide = page.locator("#scatter-bars .alone .bar").first.bounding_box()
        assert wide is not None
        assert wide["width"] > 20.0
        page.locator("#scatter-of").select_option("x mean square")
        assert page.locator("#scatter-numbers").inner_text() != first
        assert "m²" in page.locator("#scatter-numbers").inner_text()
        for width in (1400, 390):
            page.set_viewport_size({"width": width, "height": 844})
            page.evaluate("controls.open = true")
            page.wait_for_timeout(400)
            assert page.evaluate(CUT) == []
            assert page.evaluate(OVERLAPPING) == []
        page.set_viewport_size({"width": 1400, "height": 900})
        page.wait_for_timeout(300)
        tab.changed(lambda: page.locator("#field-lower-position").fill("-0.005"))
        assert page.locator("#field-upper-position").input_value() == "0.005"  # one gap
        assert page.locator("#scatter-found").is_hidden()
        tab.changed(lambda: page.locator("#unit-lower-position").select_option("mm") and page.locator("#reset").click())
        tab.changed(lambda: page.locator("#tolerance-lower-position").fill("0.7"))
        assert page.locator("#tolerance-upper-position").input_value() == "0.7"
        tab.wait("location.hash.includes('tolerance.gap=0.0007')")


def test_tolerances_by_hand_are_kept_in_link_and_file(server: Server, context: BrowserContext) -> None:
    """The paper's oscillator: without a tolerance it is refused; with one it goes into the link and the file."""
    with opened(context, server, QUICK) as tab:
        page = tab.page
        page.locator("#asked").scroll_into_view_if_needed()
        page.locator("#scatter-form").wait_for()
        assert page.locator("#scatter-numbers-of").inner_text().startswith("No number has a tolerance")
        page.locator("#scatter-run").click()
        tab.wait(
            "document.querySelector('#scatter-said.wrong')?.textContent.startsWith('tolerances: no number has one')"
        )
        page.locator("#tolerances").check()
        rms = tab.number("x_rms")
        tab.changed(lambda: page.locator("#tolerance-springpot-coefficient").fill("10"))
        assert tab.number("x_rms") == rms  # the nominal device
        assert page.locator("#scatter-said").inner_text() == ""
        page.locator("#tolerance-barrier-restitution").fill("0.5")  # half of the law is above 1
        sentence = page.locator("#range-barrier-restitution")
        sentence.filter(has_text="bounds must leave out at most 5 % of the law").wait_for()
        assert page.locator("#tolerance-barrier-restitution").get_attribute("aria-invalid") == "true"
        page.locator("#seed").focus()
        sentence.wait_for(state="hidden")
        assert page.locator("#tolerance-barrier-restitution").input_value() == ""
        tab.wait("location.hash.includes('tolerance.springpot_coefficient=0.1')")
        with page.expect_download() as waiting:
            page.locator("#save-file").click()
        text = Path(waiting.value.path()).read_text(encoding="utf-8")
        assert 'coefficient = { uncertain = "springpot_coefficient", value = 1.0, cov = 0.1 }' in text
        link = page.evaluate("location.hash")
        page.reload()
        tab.complete()
        assert page.evaluate("location.hash") == link
        assert page.locator("#tolerance-springpot-coefficient").input_value() == "10"
        tab.ask(QUICK + "&tolerance.nothing=1")
        assert "invalid values for tolerance of nothing" in page.locator("#banner").inner_text()
        assert page.locator("#tolerance-springpot-coefficient").input_value() == ""
        file = {"name": "kept.toml", "mimeType": "application/toml", "buffer": text.encode()}
        page.set_input_files("#open-file", file)  # type: ignore[arg-type]
        page.wait_for_url("**?system=*")
        tab.complete()
        assert page.locator("#tolerance-springpot-coefficient").input_value() == "10"
