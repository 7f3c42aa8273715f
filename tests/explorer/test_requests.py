"""What a tab asks beside the moments: forces, passages, cycles and profiles of a run, and tables of densities."""

from __future__ import annotations

import base64
import io
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

import springpot as sp
from springpot.explorer.excitation import charts_of_excitation, table_of, with_table
from springpot.explorer.measured import Parts
from springpot.explorer.protocol import FilePart, Observe, Rare
from springpot.explorer.rare import growing
from springpot.explorer.requests import observed, offered
from springpot.machine.faults import Stopped
from springpot.simulation.monte_carlo import simulated
from tests.explorer.conftest import Server
from tests.explorer.test_page import COMPLETE, opened

if TYPE_CHECKING:
    from playwright.sync_api import Browser

FEW = sp.System(sp.Spring(1.0), sp.Dashpot(0.5), sp.WhiteNoise(1.0))
RUN: dict[str, Any] = {"paths": 64, "seed": 3, "start": "rest", "step": 0.01}
BAND = "frequency_Hz,psd_g2/Hz\n0.01,0.01\n2,0.02\n"


def _nothing(_: float) -> None:
    pass


def test_numbers_and_charts_are_those_of_a_run() -> None:
    """Histogram, survival, profile and cycles are those of `simulate` with the same arguments, to the last bit."""
    asked = Observe(
        kind="observe", forces=["spring_force"], levels_of="x", levels=[1.0, 2.0], cycles_of="x", exponent=4.0, bins=5
    )
    found = observed(FEW, asked, RUN, _nothing, lambda: False)
    run = simulated(
        FEW, forces=["spring_force"], distributions=True, first_passage={"x": [1.0, 2.0]},
        rainflow={"x": sp.Basquin(4.0)}, profile=5, **RUN,
    )  # fmt: skip
    charts = {chart["title"]: chart for chart in found["charts"]}
    edges, density = run.distributions["spring_force"].density(60)[:2]
    assert charts["spring force"]["at"] == edges.tolist()
    assert charts["spring force"]["bars"] == density.tolist()
    survival = charts["x: share that has not passed the level"]
    assert [line["name"] for line in survival["lines"]] == ["1 m", "2 m"]
    times = np.array(survival["at"])
    assert survival["lines"][1]["values"] == run.first_passages["x"][1].survival(times)[0].tolist()
    periods = charts["x: return period of the level"]["lines"][0]
    assert periods["values"] == [passages.return_period.value for passages in run.first_passages["x"]]
    assert charts["x mean square"]["lines"][0]["values"] == run.profiles["x_mean_square_profile"].value.tolist()
    cycles = charts["x: ranges of its cycles"]
    assert cycles["y"] == ("longer cycles", "1/h")
    share, _ = run.distributions["x_range"].share_above(cycles["at"])
    assert cycles["lines"][0]["values"] == (3600.0 * run["x_cycle_rate"].value * share).tolist()
    numbers = dict(found["numbers"])
    rms, error = run["spring_force_mean_square"].value ** 0.5, run["spring_force_mean_square"].error
    value, spread = (float(word) for word in numbers["spring force, rms"].removesuffix(" m/s²").split(" ± "))
    assert value == pytest.approx(rms, abs=0.02 * spread)
    assert spread == pytest.approx(error / (2.0 * rms), rel=0.05)
    assert {"x damage rate", "x past 2 m, rate"} <= {*numbers}
    assert found["said"] == [*run.warnings]


def test_what_cannot_be_seen_says_why() -> None:
    """What a run cannot see is offered with its reason; a run can be stopped."""
    forces = {name: why for name, *_, why in offered(FEW)["forces"]}
    assert forces["spring_force"] == ""
    assert "white_noise would be in it" in forces["acceleration"]
    with pytest.raises(ValueError, match="acceleration cannot be seen"):
        observed(FEW, Observe(kind="observe", forces=["acceleration"]), RUN, _nothing, lambda: False)
    with pytest.raises(Stopped):
        observed(FEW, Observe(kind="observe", bins=4), RUN, _nothing, lambda: True)


def test_a_record_is_drawn_with_its_peaks() -> None:
    time = np.linspace(0.0, 10.0, 5001)
    values = np.where(np.arange(5001) == 1234, 7.0, np.sin(time))
    record = sp.RecordedExcitation((*time,), (*values,), scale=2.0)
    (drawn,) = charts_of_excitation(sp.System(sp.Spring(8.0), sp.Dashpot(0.5), record), 2.0)
    at, (line,) = drawn["at"], drawn["lines"]
    assert (len(at) <= 2 * 241, max(line["values"]), drawn["y"]) == (True, 14.0, ("a", "m/s²"))
    assert line["values"] == pytest.approx(2.0 * np.interp(at, time, values))


def test_a_table_takes_the_place_of_white_noise() -> None:
    """It is drawn with its overall rms, comes back as it was typed, and a wrong one is refused with one sentence."""
    device = sp.System(sp.Mass(2.0), sp.Spring(8.0), sp.Dashpot(0.5), shake=sp.WhiteNoise(1.0, on="ground"))
    made, notes = with_table(device, BAND.encode())
    assert notes == []
    noise = dict(made.stated())["shake"]
    assert noise == sp.SpectralExcitation.from_psd((0.01, 2.0), (0.01, 0.02), "g2/Hz")
    (drawn,) = charts_of_excitation(made, 2.0)
    assert f"{noise.rms:.4g} m/s²" in drawn["note"]
    area = np.trapezoid(drawn["lines"][0]["values"], drawn["at"])
    assert area == pytest.approx(noise.mean_square, rel=1e-3)
    assert with_table(device, table_of(made, 2.0).encode())[0].parts[-1].psd == pytest.approx(noise.psd, rel=1e-5)
    filtered = sp.System(*device.parts[:3], shake=sp.KanaiTajimiNoise(2.0, 0.6, 1.0))
    alike, _ = with_table(filtered, table_of(filtered, 2.0).encode())  # cut off where the page draws no longer
    assert sp.theory.linear(alike).x_mean_square == pytest.approx(sp.theory.linear(filtered).x_mean_square, rel=0.02)
    assert with_table(filtered, BAND.encode())[0].parts[-1] == noise
    for text, sentence in (
        ("frequency_Hz,psd_g2/Hz\n2,0.02\n1,0.01\n", "must increase"),
        ("frequency_Hz,psd_dB\n1,2\n2,3\n", "unit of psd"),
        ("frequency_Hz,psd_g2/Hz\n1,0\n2,3\n", "has fewer than two points above 0"),
        ("", "empty"),
    ):
        with pytest.raises(ValueError, match=sentence):
            with_table(device, text.encode())
    with pytest.raises(ValueError, match="neither a table of densities nor another noise"):
        with_table(sp.System(sp.Spring(1.0)), BAND.encode())


def test_what_was_assumed_of_a_table_and_a_binary_one() -> None:
    """A MATLAB file is read as it is; of a text in Latin-1 it is said, as where it is read in Python."""
    from scipy.io import savemat

    device, kept = sp.System(sp.Mass(2.0), sp.Spring(8.0), sp.WhiteNoise(1.0, on="ground")), io.BytesIO()
    savemat(kept, {"freq_Hz": [10.0, 2000.0], "psd": [0.02, 0.01]})
    made, _ = with_table(device, kept.getvalue(), "levels.mat", "g2/Hz")
    assert made.parts[-1] == sp.SpectralExcitation.from_psd((10.0, 2000.0), (0.02, 0.01), "g2/Hz")
    with pytest.raises(ValueError, match=r"levels\.mat.* psd"):
        with_table(device, kept.getvalue(), "levels.mat")
    parts = Parts()
    text = base64.b64encode(BAND.encode()).decode()
    assert parts.whole(FilePart(kind="table", name="b", part=0, of=1, text=text, binary=True)) == BAND.encode()
    with pytest.raises(ValueError, match="table: the bytes of a binary file must be in base64"):
        parts.whole(FilePart(kind="table", name="b", part=0, of=1, text="no base64!", binary=True))
    _, notes = with_table(device, "# géré\n".encode("latin-1") + BAND.encode(), "levels.csv")
    assert notes == ["it is not in UTF-8, and is read as Latin-1"]


def test_lengths_are_asked_and_found_in_millimetres() -> None:
    """Levels in mm are those in m, and so are the numbers and the axes; other units stay."""
    device = sp.System(sp.Mass(0.8), sp.Spring(3200.0), sp.Dashpot(5.0), sp.WhiteNoise.from_psd(0.01, "g2/Hz"))
    asked = {"kind": "observe", "forces": ["spring_force"], "levels_of": "x", "cycles_of": "x", "bins": 4}
    run = {"paths": 128, "seed": 3}
    metres = observed(device, Observe(**asked, levels=[0.004, 0.006], strength=0.01), run, float, bool)
    both = observed(device, Observe(**asked, levels=[4.0, 6.0], strength=10.0, length="mm"), run, float, bool)
    found, same = dict(both["numbers"]), dict(metres["numbers"])
    assert found["x past 4 mm, rate"] == same["x past 0.004 m, rate"]
    for words in ("spring force, rms", "x damage rate"):
        assert found[words] == same[words]
    for one, other in zip(both["charts"], metres["charts"], strict=True):
        times = {"mm": 1e3, "mm²": 1e6, "mm²/s²": 1e6}
        assert one["at"] == pytest.approx(np.multiply(other["at"], times.get(one["x"][1], 1.0)))
        for line, its in zip(one["lines"], other["lines"], strict=True):
            known = np.array(its["values"], dtype=float) * times.get(one["y"][1], 1.0)
            np.testing.assert_allclose(np.array(line["values"], dtype=float), known)
    assert {one["x"][1] for one in both["charts"]} >= {"mm", "N", "s"}


def test_a_table_is_shown_in_the_unit_in_which_it_was_stated() -> None:
    """In g²/Hz where this takes fewer digits, else in (m/s²)²/Hz."""

    def of(densities: tuple[float, ...], unit: str) -> str:
        return table_of(
            sp.System(sp.Mass(2.0), sp.Spring(8.0), sp.SpectralExcitation.from_psd((1, 5), densities, unit)), 2
        )

    assert of((0.01, 0.04), "g2/Hz") == "frequency_Hz,psd_g2/Hz\n1,0.01\n5,0.04"
    assert of((0.5, 2.25), "m2/s4/Hz") == "frequency_Hz,psd_m2/s4/Hz\n1,0.5\n5,2.25"


def test_asked_on_the_page(browser: Browser, server: Server) -> None:
    """The card is loaded when it comes near; other numbers of the system clear it."""
    context = browser.new_context()
    with opened(context, server) as tab:
        page = tab.page
        page.locator("#asked").scroll_into_view_if_needed()
        page.locator("#asked-form").wait_for()
        assert page.locator("#asked-run").is_disabled()
        page.locator("[name=levels]").fill("0.5 x")
        assert page.locator("#asked-run").is_disabled()
        page.locator("[name=levels]").fill("2, 3")
        page.locator("[name=bins]").fill("4")
        page.locator("#asked-run").click()
        page.locator("#asked-charts canvas").first.wait_for()
        tab.wait("document.querySelectorAll('#asked-charts canvas').length === 5")  # survival, periods, x, v, impacts
        assert "x past 3 m, within" in page.locator("#asked-numbers").inner_text()
        page.locator("[name=bins]").fill("4000")
        assert page.locator("#asked-run").is_disabled()
        tab.changed(lambda: page.locator("#field-springpot-order").fill("0.8"))
        assert page.locator("#asked-charts canvas").count() == 0
    context.close()


@pytest.mark.validation  # some ten seconds of paths; every day: the curve without the page
def test_rare_events_on_the_page(browser: Browser, server: Server) -> None:
    """The curve grows on one axis; stopped, it stays; other numbers of the system clear it."""
    context = browser.new_context()
    with opened(context, server) as tab:
        page = tab.page
        page.locator("#asked").scroll_into_view_if_needed()
        page.locator("#rare-form").wait_for()
        page.locator("#rare-form [name=low]").fill("2")
        page.locator("#rare-form [name=high]").fill("9")
        page.locator("#rare-run").click()
        page.locator("#rare-charts canvas").wait_for(timeout=60_000)
        rows = page.locator("#rare-numbers tr")
        first = rows.count()
        tab.wait(f"document.querySelectorAll('#rare-numbers tr').length > {first}")
        page.locator("#rare-stop").click()
        tab.wait("document.querySelector('#rare-warnings').textContent.includes('Stopped: the curve has')")
        assert page.locator("#rare-run").is_visible()
        assert first < rows.count() < 13
        tab.changed(lambda: page.locator("#field-springpot-order").fill("0.8"))
        assert page.locator("#rare-charts canvas").count() == 0
        page.locator("#rare-form [name=low]").fill("9")
        page.locator("#rare-run").click()
        tab.wait("document.querySelector('#rare-said').textContent.includes('must differ')")
    context.close()


@pytest.mark.validation  # every day: what a table becomes
def test_a_table_on_the_page(browser: Browser, server: Server) -> None:
    """A table that is wrong is refused beside it; one that is right opens the system with it, and its numbers."""
    context = browser.new_context()
    with opened(context, server) as tab:
        page = tab.page
        page.locator("#asked").scroll_into_view_if_needed()
        page.locator("#table-ask summary").click()
        page.locator("#table-text").fill("frequency_Hz,psd_g2/Hz\n10,0.01\n")
        page.locator("#table-use").click()
        tab.wait("document.querySelector('#table-note').textContent.includes('two or more')")
        page.locator("#table-text").fill(BAND)
        with page.expect_navigation():
            page.locator("#table-use").click()
        tab.wait(COMPLETE.format(after=0))
        page.locator("#asked").scroll_into_view_if_needed()
        page.locator("#excitation-charts canvas").wait_for()
        assert "Overall rms" in page.locator("#excitation-charts").inner_text()
        system, _ = with_table(sp.Oscillator(), BAND.encode())
        assert tab.number("x_rms") ** 2 == pytest.approx(sp.simulate(system, paths=640)["x_mean_square"].value)
    context.close()


def test_a_tab_asks(server: Server) -> None:
    """Over the wire: what is not possible is one sentence, and the tab goes on."""
    from websockets.sync.client import connect

    from tests.explorer import talk

    with connect(server.live, origin=server.origin) as socket:
        tab = talk.Tab(socket)
        tab.say(kind="problem", generation=1, paths=64)
        tab.until("accepted")
        tab.say(kind="observe", levels_of="y", levels=[1.0])
        assert "first_passage must name x" in tab.until("observed", running=False)["fault"]
        tab.say(kind="observe", levels_of="x", levels=[2.0])
        assert tab.until("observed", running=False)["charts"][0]["x"] == ["t", "s"]


def test_a_curve_of_return_periods_grows() -> None:
    """By one run, whose end is what `exceedance` gives to the last bit; stopped, it keeps the levels that it has."""
    wish = Rare(kind="rare", of="x", low=2.0, high=5.0, duration=10.0, rtol=0.5)
    run: dict[str, Any] = {"seed": 3, "start": "rest", "threads": 1}
    device, told = sp.System(sp.Spring(1.0), sp.Dashpot(0.5), sp.WhiteNoise(1.0)), list[int]()
    found = growing(device, wish, run, lambda _, **known: told.append(known.get("found", 0)), lambda: False)
    curve = sp.exceedance(device, {"x": np.linspace(2.0, 5.0, 13)}, duration=10.0, rtol=0.5, **run)["x"]
    assert found["charts"][0]["lines"][0]["values"] == curve.return_period.tolist()
    assert told == sorted(told)
    assert len({*told}) > 3
    half = growing(device, wish, run, lambda _, **known: told.append(-1), lambda: told.count(-1) > 6)
    assert half["said"][0].startswith("Stopped: the curve has")
    assert 0 < len(half["numbers"]) == half["found"] < 13
    with pytest.raises(ValueError, match="nothing is by chance"):
        growing(sp.System(sp.Spring(1.0), sp.Dashpot(0.5)), wish,
                run, lambda _, **known: None, lambda: False)  # fmt: skip
