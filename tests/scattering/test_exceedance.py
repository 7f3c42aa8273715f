"""`sp.exceedance_over_devices`: against averages of single devices, in units of the errors."""

from __future__ import annotations

import json
import math
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import springpot as sp
from springpot import cli
from springpot.machine.arrays import Floats
from springpot.machine.progress import Clock, OutOfTimeError
from springpot.scattering import exceedance as exceedance_of_devices
from springpot.scattering import stages
from springpot.scattering.stages import EventOfDevices, Stage, Tilt, normal_scores
from springpot.scattering.surface import polynomials, powers_of, probability_surface
from springpot.simulation.paths.simulation import simulation_of
from springpot.simulation.plan.plan import plan_of
from springpot.simulation.rare.event import constants_of, event_of, quantity_of
from springpot.simulation.rare.splitting import Population, Tally, repetitions
from tests.scattering.problems import RARE, rare_device
from tests.sizes import validation

WALLED = sp.System(
    sp.Spring(1.0), sp.Springpot(0.5, 0.2), sp.Barrier(-0.3, 0.8), sp.WhiteNoise(0.2)
)  # fmt: skip
PAIR = sp.System(
    sp.Mass(1.0, at="a"), sp.Mass(0.5, at="b"), sp.Spring(1.0, between=("ground", "a")),
    sp.Spring(0.6, between=("a", "b")), sp.Springpot(0.4, 0.2, between=("ground", "a")),
    sp.Dashpot(0.1, between=("a", "b")), sp.WhiteNoise(0.2, on="a"),
)  # fmt: skip
MODULATED = sp.System(
    sp.Spring(1.0), sp.Dashpot(0.2), sp.WhiteNoise(0.2, envelope=sp.ExponentialEnvelope(slow=0.05, fast=0.5))
)


@pytest.fixture
def few_devices(monkeypatch: pytest.MonkeyPatch) -> None:
    """An eighth of them, for what does not depend on how many there are: to make one takes longer than its paths."""
    monkeypatch.setattr(stages, "DEVICES", 4)


def tallies(system: sp.System, name: str, level: float, splits: bool, by_device: bool) -> Tally:
    plan = plan_of(system, duration=20.0, step=0.1, start="rest", seed=5, threads=2)
    simulation = simulation_of(plan)
    quantity = quantity_of(plan.motion, name)
    asked = event_of(plan, simulation.parts, quantity, np.array([0.6 * level, level]), 1.0)
    population, given = None, {"clock": Clock(None), "tell": lambda _: None}
    if by_device:
        pairs = [(plan, simulation.parts)] * 4
        constants = constants_of(pairs[0], pairs, quantity, asked, 1.0, np.ones(4))
        population = Population([simulation] * 4, constants, np.ones(4))
    first = repetitions(simulation, asked, first=0, count=32, paths=64, stream=7, splits=False, **given)
    return repetitions(
        simulation, asked.told_by(first.ends), first=0, count=2, paths=256, stream=8 + splits, splits=splits,
        population=population, **given,
    )  # fmt: skip


@pytest.mark.parametrize(
    ("system", "name", "level"),
    [
        (WALLED, "x", 3.0),
        (WALLED, "impact_speed", 3.0),
        (WALLED, "amplitude", 2.6),
        (PAIR, "b_x", 3.5),
        validation(PAIR, "a_speed", 2.5),
        validation(WALLED, "v", 2.6),
        validation(WALLED, "energy", 3.5),
        validation(MODULATED, "v", 2.0),
    ],
)
@pytest.mark.parametrize("splits", [False, True])
def test_devices_that_are_alike_are_one(system: sp.System, name: str, level: float, splits: bool) -> None:
    """By lane the same numbers, to rounding: the same paths exceed the levels, and the same ones are split."""
    plain, apart = (tallies(system, name, level, splits, by_device) for by_device in (False, True))
    assert apart.exceeded == pytest.approx(plain.exceeded, rel=0.02 if splits else 1e-9)
    if splits:
        assert plain.exceeded[:, 1].min() > 0.0
    else:
        assert apart.ends == pytest.approx(plain.ends, rel=1e-4)
    by_repetition = apart.of_devices.reshape(2, 2, 2).sum(axis=1)
    assert by_repetition == pytest.approx(apart.exceeded[:, 1], rel=1e-9)
    assert apart.of_ancestors.reshape(2, -1).sum(axis=1) == pytest.approx(apart.exceeded[:, 1, -1], rel=1e-9)


def nodes(count: int) -> tuple[Floats, Floats]:
    scores, weights = np.polynomial.hermite_e.hermegauss(count)
    return scores, weights / weights.sum()


def averaged(system_at: Any, name: str, level_at: Any, count: int, **given: Any) -> tuple[float, float]:
    """The mean over the normal score of one number, from single devices, and its standard error."""
    mean = square = 0.0
    for score, weight in zip(*nodes(count), strict=True):
        own = sp.exceedance(system_at(score), {name: [level_at(score)]}, seed=int(500 + 50 * score), **given)[name]
        mean += weight * float(own.probability[0])
        square += (weight * float(own.error[0])) ** 2
    return mean, math.sqrt(square)


@pytest.mark.parametrize(
    ("name", "level"),
    [validation("x", 3.2), validation("impact_speed", 3.4), validation("speed", 3.2), validation("energy", 5.0)],
)
def test_one_number_scatters(name: str, level: float) -> None:
    """Behind a lossy wall, with memory: the mean over devices of the probabilities of each."""

    def device(coefficient: float) -> sp.System:
        return sp.System(sp.Spring(1.0), sp.Springpot(0.5, coefficient), sp.Barrier(-0.3, 0.8), sp.WhiteNoise(0.2))

    given: dict[str, Any] = {"duration": 20.0, "step": 0.05, "start": "rest"}
    wide = math.sqrt(math.log1p(0.2**2))
    mean, error = averaged(
        lambda z: device(0.2 * math.exp(wide * z - 0.5 * wide**2)), name, lambda _: level, 7, rtol=0.1, **given
    )
    uncertain = device(sp.uncertain("C", 0.2, cov=0.2))
    found = sp.exceedance_over_devices(uncertain, {name: level}, rtol=0.1, **given)[name]
    assert 1e-5 < mean < 3e-3
    assert abs(found.probability[0] - mean) < 3.5 * math.hypot(error, found.error[0])
    assert found.probability[0] > 1.1 * found.nominal.probability[0]
    assert found.by_mean["C"][0].value < -0.5
    assert found.devices_seen > 50


@pytest.mark.validation
def test_an_order_and_a_gap_scatter() -> None:
    """Common modes of memory, and walls at other places: against single devices at the same draws."""

    def device(order: float, gap: float) -> sp.System:
        return sp.System(
            sp.Mass(0.8), sp.Spring(3200.0), sp.Springpot(order, 150.0), sp.Barrier(-gap, 0.7),
            sp.WhiteNoise.from_psd(0.01, "g2/Hz"),
        )  # fmt: skip

    given: dict[str, Any] = {"duration": 2.0, "step": 1e-3, "start": "rest"}
    places, weights = np.polynomial.legendre.leggauss(3)
    mean = square = 0.0
    for order, share in zip(0.3 + 0.05 * places, weights / 2.0, strict=True):
        for score, weight in zip(*nodes(5), strict=True):
            own = sp.exceedance(
                device(order, 0.006 + 6e-4 * score), {"x": [0.013]}, rtol=0.1, seed=int(1e4 * order), **given
            )
            mean += share * weight * float(own["x"].probability[0])
            square += (share * weight * float(own["x"].error[0])) ** 2
    uncertain = device(sp.uncertain("order", bounds=(0.25, 0.35)), sp.uncertain("gap", 0.006, sd=6e-4))
    found = sp.exceedance_over_devices(uncertain, {"x": 0.013}, rtol=0.1, **given)["x"]
    assert abs(found.probability[0] - mean) < 3.5 * math.hypot(math.sqrt(square), found.error[0])


@pytest.mark.parametrize("known", [RARE[0], *map(validation, RARE[1:])])
def test_a_linear_oscillator_whose_limit_scatters(known: dict[str, Any]) -> None:
    """Damping, noise and limit: against a table of single devices, integrated by Gauss and Hermite."""
    system, level = rare_device(known["limit"])
    found = sp.exceedance_over_devices(
        system, {"amplitude": level}, duration=100.0, step=0.3, start=known["start"], rtol=0.1,
        limits={"amplitude": known["much"]},
    )["amplitude"]  # fmt: skip
    share = 3.5 * found.error[0] / found.probability[0] + 0.05
    assert abs(found.probability[0] / known["probability"] - 1.0) < share
    assert known["probability"] / found.nominal.probability[0] == pytest.approx(known["times"], rel=0.3)
    for n, name in enumerate(("c", "q", "limit")):
        for own, exact in ((found.by_mean, known["by_mean"]), (found.by_scatter, known["by_scatter"])):
            assert abs(own[name][0].value - exact[n]) < 4.0 * own[name][0].error + 0.05
    own = found.of_devices
    assert own is not None
    assert own.quantiles[0.95].value == pytest.approx(known["quantile"], rel=0.25)
    assert own.above is not None
    assert own.above.value == pytest.approx(known["above"], rel=0.3)
    assert own.together["c"].value > own.together["q"].value > own.together["limit"].value


def test_what_is_not_rare_is_counted_on_plain_paths() -> None:
    """Where the nominal device exceeds the level in one of four runs."""
    device = sp.System(sp.Spring(1.0), sp.Dashpot(sp.uncertain("c", 0.2, cov=0.3)), sp.WhiteNoise(0.2))
    given: dict[str, Any] = {"duration": 20.0, "step": 0.1, "start": "rest"}
    found = sp.exceedance_over_devices(device, {"x": [1.0, 1.6]}, rtol=0.03, **given)["x"]
    assert not found.splits
    assert found.of_devices is None
    wide = math.sqrt(math.log1p(0.3**2))
    mean, error = averaged(
        lambda z: sp.System(sp.Spring(1.0), sp.Dashpot(0.2 * math.exp(wide * z - 0.5 * wide**2)), sp.WhiteNoise(0.2)),
        "x", lambda _: 1.6, 5, rtol=0.03, **given,
    )  # fmt: skip
    assert abs(found.probability[1] - mean) < 3.5 * math.hypot(error, found.error[1])


@pytest.mark.usefixtures("few_devices")
def test_the_same_bits_for_any_number_of_threads() -> None:
    device = sp.System(sp.Spring(1.0), sp.Dashpot(sp.uncertain("C", 0.2, cov=0.2)), sp.WhiteNoise(0.2))
    one, two = (
        sp.exceedance_over_devices(
            device, {"x": 3.2}, duration=20.0, step=0.1, start="rest", rtol=1.0, threads=threads
        )["x"]
        for threads in (1, 2)
    )
    assert one.probability.tobytes() == two.probability.tobytes()
    assert one.shares.tobytes() == two.shares.tobytes()


def test_weights_of_the_second_stage_give_the_laws_back() -> None:
    """Means over the laws, from devices that are drawn elsewhere."""
    tilt = Tilt(np.array([-1.2, 0.8]), np.linalg.cholesky(np.array([[0.8, 0.2], [0.2, 1.2]])))
    drawn = [tilt.drawn(normal_scores(2, 3, 64, number)) for number in range(64)]
    scores, weights = np.concatenate([z for z, _ in drawn]), np.concatenate([w for _, w in drawn])
    assert weights.max() <= 4.0
    for function, exact in (
        (np.ones(len(scores)), 1.0), (scores[:, 0], 0.0), (scores[:, 1] ** 2, 1.0), (scores[:, 0] * scores[:, 1], 0.0),
        (np.exp(-scores[:, 0]), math.exp(0.5)),
    ):  # fmt: skip
        assert (weights * function).mean() == pytest.approx(exact, abs=0.04)


def test_the_surface_of_a_probability() -> None:
    """A logarithm of second degree, from counts most of which are 0."""
    scores = normal_scores(2, 1, 4096)
    powers = powers_of(2, 2, 1.0)
    terms = polynomials(scores, (True, True), powers)
    exact = np.array([-4.0, 1.0, -0.6, -0.15, 0.1, 0.0])
    counts = np.random.default_rng(2).poisson(np.exp(terms @ exact))
    assert np.count_nonzero(counts) < 700
    found = probability_surface(terms, counts.astype(float))
    assert np.abs(found - exact).max() < 0.15


@pytest.mark.validation  # every day: a level that moves with the walls, below
def test_devices_whose_walls_are_nearer_than_the_level() -> None:
    """They never exceed it; the others do as plain paths of each say."""
    given: dict[str, Any] = {"duration": 20.0, "step": 0.1, "start": "rest"}

    def device(gap: float) -> sp.System:
        walls = sp.Barrier(-gap, 0.7), sp.Barrier(gap, 0.7, free_side="below")
        return sp.System(sp.Spring(1.0), sp.Dashpot(0.2), *walls, sp.WhiteNoise(0.2))

    found = sp.exceedance_over_devices(
        device(sp.uncertain("g", bounds=(0.8, 1.6))), {"distance": 1.1}, rtol=0.05, **given
    )["distance"]
    assert not found.draws[found.shares > 0.0].min() < 1.1
    alone = sp.exceedance(device(1.35), {"distance": 1.1}, rtol=0.05, **given)["distance"].probability
    assert found.probability[0] == pytest.approx(float(alone) * (1.6 - 1.1) / (1.6 - 0.8), rel=0.3)


@pytest.mark.usefixtures("few_devices")
def test_a_level_that_moves_with_the_walls() -> None:
    """Beyond the walls of the nominal device in half of the devices: against single ones."""
    given: dict[str, Any] = {"duration": 20.0, "step": 0.1, "start": "rest", "rtol": 0.03}

    def device(gap: float) -> sp.System:
        walls = sp.Barrier(-gap, 0.7), sp.Barrier(gap, 0.7, free_side="below")
        return sp.System(sp.Spring(1.0), sp.Dashpot(0.2), *walls, sp.WhiteNoise(0.6))

    gap = sp.uncertain("g", bounds=(1.2, 2.0))
    found = sp.exceedance_over_devices(device(gap), {"distance": 0.9 * gap}, **given)["distance"]
    places, weights = np.polynomial.legendre.leggauss(4)
    alone = [
        float(sp.exceedance(device(own), {"distance": 0.9 * own}, **given)["distance"].probability)
        for own in 1.6 + 0.4 * places
    ]
    assert found.probability[0] == pytest.approx(float(weights @ alone) / 2.0, rel=0.1)


@pytest.mark.usefixtures("few_devices")
def test_what_all_devices_exceed() -> None:
    found = sp.exceedance_over_devices(DEVICE, {"x": 1e-4}, duration=20.0, step=0.1, start="rest")["x"]
    assert found.probability[0] == found.high[0] == 1.0
    assert 0.999 < found.low[0] < 1.0
    assert 0.0 < found.error[0] < 1e-3


@pytest.mark.validation  # every day: rounds in which no path exceeds a level, below
def test_what_no_device_exceeds_ends_early() -> None:
    """And repetitions without any path there count with their zeros."""
    with pytest.warns(sp.SpringpotWarning, match="no path exceeded 15"):
        found = sp.exceedance_over_devices(
            DEVICE, {"x": 15.0}, duration=2.0, step=0.1, start="rest", rtol=0.5, max_time=60.0
        )["x"]
    assert found.repetitions <= 3 * 16
    assert found.probability[0] == 0.0
    assert 0.0 < found.high[0] < 1e-6


def rounds(monkeypatch: pytest.MonkeyPatch, ends_at: int, found_at: int = 0) -> list[int]:
    """The rounds that are asked for, where the time is over at one and before another no path exceeds a level."""
    run, seen = EventOfDevices._run, list[int]()

    def own(
        self: EventOfDevices, asked: Any, drawn: Any, paths: int, splits: bool, number: int, clock: Clock
    ) -> Stage:  # fmt: skip
        if number >= ends_at:
            raise OutOfTimeError
        seen.append(number)
        stage = run(self, asked, drawn, 256, splits, number, clock)
        if 2 <= number < found_at:
            tally = replace(stage.tally, exceeded=0.0 * stage.tally.exceeded, of_devices=0.0 * stage.tally.of_devices)
            stage = replace(stage, tally=tally)
        return stage

    monkeypatch.setattr(EventOfDevices, "_run", own)
    return seen


@pytest.mark.usefixtures("few_devices")
def test_rounds_in_which_no_path_exceeds_a_level_count(monkeypatch: pytest.MonkeyPatch) -> None:
    seen = rounds(monkeypatch, ends_at=5, found_at=4)
    with pytest.warns(sp.SpringpotWarning):
        found = sp.exceedance_over_devices(DEVICE, {"x": 3.5}, duration=20.0, step=0.1, start="rest", rtol=0.05)["x"]
    assert seen == [0, 1, 2, 3, 4]
    assert found.repetitions == 48


@pytest.mark.parametrize("ends_at", [1, 2])
@pytest.mark.usefixtures("few_devices")
def test_what_is_known_when_the_time_is_over(ends_at: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Plain paths, then those that tell where."""
    rounds(monkeypatch, ends_at=ends_at)
    with pytest.warns(sp.SpringpotWarning):
        found = sp.exceedance_over_devices(DEVICE, {"x": 4.5}, duration=20.0, step=0.1, start="rest", rtol=1.0)["x"]
    assert found.splits == (ends_at == 2)
    assert found.repetitions == 16
    assert found.high[0] > found.probability[0]


@pytest.mark.validation  # every day: what is known when the time is over, above
@pytest.mark.usefixtures("few_devices")
def test_a_nominal_device_for_which_no_time_is_left(monkeypatch: pytest.MonkeyPatch) -> None:
    def late(*_: Any, **__: Any) -> None:
        raise TimeoutError

    monkeypatch.setattr(exceedance_of_devices, "exceeded", late)
    with pytest.warns(sp.SpringpotWarning, match="of the nominal device"):
        found = sp.exceedance_over_devices(DEVICE, {"x": 1.0}, duration=20.0, step=0.1, start="rest")
    assert found["x"].probability[0] > 0.0
    assert "at most 1" in str(found)


def test_a_time_that_is_over_while_devices_are_made() -> None:
    begun = time.perf_counter()
    with pytest.raises(TimeoutError, match="max_time is too short for any result"):
        sp.exceedance_over_devices(DEVICE, {"x": 3.0}, duration=20.0, step=0.1, start="rest", max_time=1e-6)
    assert time.perf_counter() - begun < 60.0


@pytest.mark.usefixtures("few_devices")
def test_laws_without_tails_are_told() -> None:
    device = sp.System(sp.Spring(1.0), sp.Dashpot(sp.uncertain("c", values=[0.1, 0.2, 0.3])), sp.WhiteNoise(0.2))
    with pytest.warns(sp.SpringpotWarning, match="the law of 3 measured values has no tails"):
        sp.exceedance_over_devices(device, {"x": 1.0}, duration=20.0, step=0.1, start="rest", rtol=1.0)


@pytest.mark.usefixtures("few_devices")
def test_what_bounds_leave_out_is_told_once() -> None:
    damping = sp.uncertain("c", 0.2, sd=0.05, bounds=(0.05, 0.5))
    device = sp.System(sp.Spring(1.0), sp.Dashpot(damping), sp.WhiteNoise(0.2))
    with pytest.warns(sp.SpringpotWarning, match="bounds leave out") as raised:
        found = sp.exceedance_over_devices(
            device, {"x": [1.0], "v": [1.0]}, duration=20.0, step=0.1, start="rest", rtol=1.0
        )
    told = [str(each.message) for each in raised]
    assert told == [*found.warnings]
    assert len([sentence for sentence in told if "bounds leave out" in sentence]) == 1
    assert "bounds leave out" not in str(found)
    assert "bounds leave out" in found.report()


@pytest.mark.validation  # every day: a report with correlated numbers, below
@pytest.mark.usefixtures("few_devices")
def test_a_report_where_all_numbers_depend_on_each_other() -> None:
    device = sp.System(
        sp.Spring(1.0), sp.Dashpot(sp.uncertain("c", 0.2, cov=0.2)), sp.WhiteNoise(sp.uncertain("q", 0.2, cov=0.1))
    )
    found = sp.exceedance_over_devices(
        device, {"x": 3.0}, duration=20.0, step=0.1, start="rest", rtol=1.0, correlation={("c", "q"): 0.5}
    )
    assert str(found).splitlines()[-1].split() == ["c", "and", "q", "100.0", "%", "100.0", "%"]


@pytest.mark.usefixtures("few_devices")
def test_a_report_a_dict_and_correlated_numbers() -> None:
    device = sp.System(
        sp.Spring(sp.uncertain("k", 1.0, cov=0.1)), sp.Dashpot(sp.uncertain("c", 0.2, cov=0.2)),
        sp.WhiteNoise(sp.uncertain("q", 0.2, cov=0.1)),
    )  # fmt: skip
    found = sp.exceedance_over_devices(
        device, {"x": [2.5, 3.5]}, duration=20.0, step=0.1, start="rest", rtol=0.5, correlation={("k", "c"): 0.8},
        limits={"x": 1e-3},
    )  # fmt: skip
    text = str(found)
    told = "Exceedance in 20 s, 3 uncertain numbers", "x > 2.5 m", "nominal device", "over devices", "limit 0.001"
    for words in (*told, "95 % of devices are below", "which number matters"):
        assert words in text
    assert 0.0 <= found["x"].of_devices.above.low < found["x"].of_devices.above.high
    assert found.inputs == ("k and c", "q")
    assert [*found["x"].by_mean] == ["q"]
    plain = json.loads(json.dumps(found.to_dict()))
    assert plain["curves"]["x"]["index"]["k and c"]["value"] == found["x"].of_devices.alone["k and c"].value
    assert found["x"].draws.shape == (len(found["x"].shares), 3)


K = sp.uncertain("k", 1.0, cov=0.1)
B = sp.uncertain("b", 3.0, cov=0.1)
DEVICE = sp.System(sp.Spring(K), sp.Dashpot(0.2), sp.WhiteNoise(0.2))


@pytest.mark.parametrize(
    ("system", "levels", "given", "words"),
    [
        (WALLED, {"x": 3.0}, {}, "system or levels must have uncertain numbers"),
        (DEVICE, 3.0, {}, "levels must be a dict of names and levels"),
        (DEVICE, {}, {}, "levels must be a dict of names and levels"),
        (DEVICE, {"y": 3.0}, {}, "levels has 'y', which is no quantity"),
        (DEVICE, {"x": [B, 4.0]}, {}, "levels of x must be plain numbers, or multiples"),
        (DEVICE, {"x": [B, K * 4.0]}, {}, "levels of x must be plain numbers, or multiples"),
        (DEVICE, {"spring_force": 3.0}, {}, "levels of spring_force cannot be asked of devices"),
        (DEVICE, {"x": 3.0}, {"limits": {"v": 0.1}}, "limits must be of x, not 'v'"),
        (DEVICE, {"x": 3.0}, {"limits": {"x": 1.5}}, "limits of x must be"),
        (DEVICE, {"x": 3.0}, {"limits": 0.1}, "limits must be a dict of quantities and probabilities"),
        (DEVICE, {"x": 3.0}, {"rtol": 2.0}, "rtol must be"),
        (DEVICE, {"x": 3.0}, {"duration": -1.0}, "duration must be"),
        (DEVICE, {"x": 3.0}, {"correlation": {("k", "c"): 0.5}}, "correlation must be of k"),
        (DEVICE, {"x": sp.uncertain("b", 3.0, sd=2.0)}, {}, "levels of x must have one sign in all devices"),
        (
            sp.System(sp.Spring(1.0), sp.Maxwell(K, 1.0), sp.Dashpot(0.1), sp.WhiteNoise(0.2)), {"x": 3.0}, {},
            "system must have devices that share blocks of paths",
        ),
    ],
)  # fmt: skip
@pytest.mark.usefixtures("few_devices")
def test_what_is_wrong_is_one_sentence(system: Any, levels: Any, given: Any, words: str) -> None:
    with pytest.raises((TypeError, ValueError)) as caught:
        sp.exceedance_over_devices(system, levels, **{"duration": 20.0, "step": 0.1, "start": "rest", **given})
    assert str(caught.value).startswith(words)
    assert str(caught.value).count("\n") == 0


def test_the_command_of_a_file_with_uncertain_numbers(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "device.toml"
    file.write_text(sp.to_toml(DEVICE), encoding="utf-8")
    words = ["exceedance", str(file), "--levels", "x", "1.0", "--duration", "20", "--start", "rest", "--step", "0.1"]
    assert cli.main([*words, "--json"]) == 0
    curve = json.loads(capsys.readouterr().out)["curves"]["x"]
    assert curve["devices"] >= 512
    assert curve["low"][0] < curve["probability"][0] < curve["high"][0]
    assert cli.main([*words, "--save", "kept"]) == 2
    assert "save cannot be given where numbers of the system are uncertain" in capsys.readouterr().err


@pytest.mark.validation
@pytest.mark.parametrize("known", RARE)
def test_intervals_hold(known: dict[str, Any]) -> None:
    """Of 24 runs; with 95 % each, fewer than 19 of them would come by chance once in a thousand times."""
    system, level = rare_device(known["limit"])
    held, found = np.zeros(4, int), list[float]()
    for seed in range(100, 124):
        curve = sp.exceedance_over_devices(
            system, {"amplitude": level}, duration=100.0, step=0.3, start=known["start"], rtol=0.15, seed=seed
        )["amplitude"]
        own = curve.of_devices
        assert own is not None
        found.append(float(curve.probability[0]))
        held += [
            curve.low[0] < known["probability"] < curve.high[0],
            own.quantiles[0.95].low < known["quantile"] < own.quantiles[0.95].high,
            *(each["c"][0].low < exact < each["c"][0].high for each, exact in (
                (curve.by_mean, known["by_mean"][0]), (curve.by_scatter, known["by_scatter"][0]))),
        ]  # fmt: skip
    assert held.min() >= 19
    mean, error = float(np.mean(found)), float(np.std(found, ddof=1)) / math.sqrt(len(found))
    assert abs(mean / known["probability"] - 1.0) < 3.0 * error / mean + 0.02


DAMPED = sp.System(sp.Mass(1.0), sp.Spring(1.0), sp.Dashpot(sp.uncertain("c", 0.1, cov=0.2)), sp.WhiteNoise(0.2))


@pytest.mark.validation  # every day: the example of `exceedance_over_devices`, and what it needs, below
def test_a_longer_time_is_the_mean_over_devices_and_not_that_of_their_mean() -> None:
    """The rates of devices by the envelope, averaged over the lognormal law of the damping."""
    from scipy.special import ndtri

    found = sp.exceedance_over_devices(DAMPED, {"x": 5.0}, duration=100.0, rtol=0.1)["x"]
    spread = math.sqrt(math.log(1.04))
    dampings = 0.1 * np.exp(spread * ndtri((np.arange(40) + 0.5) / 40) - 0.5 * spread**2)
    systems = [sp.System(sp.Spring(1.0), sp.Dashpot(c), sp.WhiteNoise(0.2)) for c in dampings.tolist()]
    rates = np.array([sp.theory.exceedance(each, {"x": 5.0})["x"].rate["envelope"] for each in systems])
    for longer in (3600.0, 1e5):
        exact, naive = float(-np.expm1(-rates * longer).mean()), -math.expm1(-rates.mean() * longer)
        own = found.within(longer)
        assert own.low < own.probability < own.high
        assert abs(own.probability - exact) < 4.0 * own.error + 0.05 * exact
    assert own.high < naive
    assert found.within(100.0).probability == pytest.approx(found.probability[-1])


@pytest.mark.usefixtures("few_devices")
def test_a_longer_time_needs_the_own_probabilities_and_a_stationary_start() -> None:
    given: dict[str, Any] = {"step": 0.1, "rtol": 1.0, "duration": 20.0}
    often = sp.exceedance_over_devices(DAMPED, {"x": 1.0}, **given)["x"]
    with pytest.raises(ValueError, match=r"duration must be that of the paths, 20 s: the mean over devices of 1 - exp"):
        often.within(3600.0)
    rest = sp.exceedance_over_devices(DAMPED, {"x": 1.0}, **given, start="rest")["x"]
    with pytest.raises(ValueError, match="their time does not begin in the stationary state"):
        rest.within(3600.0)


def test_a_time_that_is_too_long_says_what_to_ask_for() -> None:
    with pytest.raises(TimeoutError, match=r"duration=1.3e\+02, and take .within\(1e\+06\) of the curve"):
        sp.exceedance_over_devices(DAMPED, {"x": 5.0}, duration=1e6, max_time=0.2)
