"""Records with their measured input: numbers found, errors that hold, and what is said where nothing is found."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import scipy

import springpot as sp
from springpot.fitting.likelihood import inverse
from springpot.machine.arrays import Floats
from springpot.machine.faults import NoFitError
from springpot.problem.free_numbers import restarted
from springpot.problem.system import System
from tests.sizes import validation

pytestmark = pytest.mark.filterwarnings("ignore::springpot.SpringpotWarning")

STEP = 0.05
TRUTH: dict[str, dict[str, float]] = {
    "linear": {"k": 9.0, "c": 0.4},
    "springpot": {"k": 9.0, "order": 0.5, "C": 0.8},
    "duffing": {"k": 9.0, "c": 0.42, "k3": 2.5},
    "contact": {"k": 9.0, "c": 0.4, "gap": -0.1, "kc": 200.0},
    "wall": {"k": 9.0, "c": 0.4, "gap": -0.1, "r": 0.7},
}
BOUNDS = {
    "k": (1.0, 100.0), "c": (0.02, 10.0), "order": (0.05, 0.95), "C": (0.05, 10.0), "k3": (0.02, 100.0),
    "gap": (-1.0, -0.005), "kc": (10.0, 1e4), "r": (0.1, 1.0),
}  # fmt: skip


def device(kind: str, free: bool = True, **starts: float) -> System:
    numbers: Any = {
        name: sp.free(name, starts.get(name, value), BOUNDS[name]) if free else value
        for name, value in TRUTH[kind].items()
    }
    beside = {
        "linear": lambda k, c: (sp.Dashpot(c),),
        "springpot": lambda k, order, C: (sp.Springpot(order, C),),
        "duffing": lambda k, c, k3: (sp.Dashpot(c), sp.PolynomialSpring((0.0, 0.0, k3))),
        "contact": lambda k, c, gap, kc: (sp.Dashpot(c), sp.Contact(gap, kc, 1.5)),
        "wall": lambda k, c, gap, r: (sp.Dashpot(c), sp.Barrier(gap, r)),
    }[kind](**numbers)
    return sp.System(sp.Spring(numbers["k"]), *beside)


def simulated(system: System, force: Floats, on: str = "mass", fine: int = 40, record: int = 1) -> Floats:
    time = STEP * np.arange(force.size)
    drive = sp.RecordedExcitation(time, force, on)
    return sp.simulate(
        sp.System(**dict(system.stated()), drive=drive), paths=1, record=record, duration=time[-1], step=STEP / fine,
        record_every=fine, start="rest", threads=1,
    ).record[0]  # fmt: skip


def rough_force(samples: int, rng: np.random.Generator) -> Floats:
    return np.asarray(scipy.signal.lfilter([1.0], [1.0, -0.6], 2.4 * rng.standard_normal(samples + 200))[200:])


def sensor_noise(samples: int, rng: np.random.Generator, is_coloured: bool) -> Floats:
    white = rng.standard_normal(samples + 200)
    return np.asarray(scipy.signal.lfilter([0.19**0.5], [1.0, -0.9], white) if is_coloured else white)[200:]


def twin(kind: str, seed: int, samples: int = 1200, is_coloured: bool = False, **more: Any) -> sp.MeasuredRecord:
    rng = np.random.default_rng(seed)
    force = rough_force(samples, rng)
    x = simulated(device(kind, free=False), force, fine=1280 if kind == "wall" else 40)[:, 0]
    values = x + 0.02 * x.std() * sensor_noise(samples, rng, is_coloured)
    usual = {"input": force, "start": "rest", "interpolation": "linear"}
    return sp.MeasuredRecord(STEP * np.arange(samples), values, **usual | more)


def test_a_duffing_oscillator_without_noise_is_found_to_the_digits_of_the_data() -> None:
    force = rough_force(400, np.random.default_rng(1))
    x = simulated(device("duffing", free=False), force, fine=320)[:, 0]
    data = sp.MeasuredRecord(STEP * np.arange(400), x, input=force, start="rest")
    found = sp.fit(device("duffing", k=7.0, c=0.6, k3=3.5), data)  # tries both kinds of input between its samples
    for name, value in TRUTH["duffing"].items():
        assert found.values[name] == pytest.approx(value, rel=1e-4)
    assert found.extras["left"] < 1e-5 * x.std()


@pytest.mark.parametrize(
    ("kind", "is_coloured", "twins"),
    [validation("springpot", True, 2), ("duffing", False, 2), *(validation(kind, red, 100 if kind != "wall" else 30)
     for kind in ("springpot", "duffing", "contact", "wall") for red in (False, True))],
)  # fmt: skip
def test_intervals_cover(kind: str, is_coloured: bool, twins: int) -> None:
    inside, count, naive = 0, 0, 0
    for seed in range(twins):
        fit = sp.fit(device(kind), twin(kind, seed, is_coloured=is_coloured))
        own: Any = fit._likelihood
        left, slopes = own._model.compared(fit._theta, own._samples)
        flat = slopes.reshape(len(slopes), -1)
        plain = np.sqrt(np.diag(inverse(flat @ flat.T)) * float(np.sum(left**2)) / left.size)
        for n, (name, value) in enumerate(TRUTH[kind].items()):
            low, high = fit.interval(name)
            inside, count = inside + (low <= value <= high), count + 1
            naive += abs(fit.values[name] - value) < 1.96 * plain[n]
    few = count < 100
    assert inside / count >= (0.5 if few else 0.92)
    if not few:
        assert inside / count <= 0.985
        assert naive / count < 0.8 or not is_coloured


@pytest.mark.parametrize("is_coloured", [False, True])
def test_the_likelihood_for_samplers_falls_as_the_errors_say(is_coloured: bool) -> None:
    """One standard error off in one number, the others held: -2 ln L is more by that of the inverse correlations."""
    numbers = sp.free("k", 9.0, (1.0, 100.0)), sp.free("c", 0.42, (0.02, 10.0))
    model = sp.System(sp.Spring(numbers[0]), sp.Dashpot(numbers[1]), sp.PolynomialSpring((0.0, 0.0, 2.5)))
    fit = sp.fit(model, twin("duffing", 3, is_coloured=is_coloured))
    best, expected = fit.log_likelihood(fit.values), np.diag(inverse(fit.correlations))
    for name, rise in zip(fit.names, expected, strict=True):
        for way in (-1.0, 1.0):
            moved = {**fit.values, name: fit.values[name] + way * fit.errors[name]}
            assert 2.0 * (best - fit.log_likelihood(moved)) == pytest.approx(rise, rel=0.02)
    assert all(best - 10.0 < fit.log_likelihood(each) < best for each in fit.start_ensemble(8))


@pytest.mark.parametrize(("seed", "samples"), [(102, 300), *(validation(n, 300) for n in range(103, 112))])
def test_a_wall_is_found_from_numbers_that_are_far_off(seed: int, samples: int) -> None:
    starts = {"k": 9.0 * 1.3, "c": 0.4 * 0.7, "gap": -0.13, "r": 0.9}
    found = sp.fit(device("wall", **starts), twin("wall", seed, samples))
    for name, value in TRUTH["wall"].items():
        assert found.values[name] == pytest.approx(value, rel=0.03)


@pytest.mark.parametrize(
    ("mass", "on"), [(1.0, "mass"), (300.0, "ground"), validation(300.0, "mass"), validation(1.0, "ground")]
)
def test_a_lightly_damped_oscillator_is_found_from_a_wrong_frequency(on: str, mass: float) -> None:
    def heavy(k: Any, c: Any, m: Any = mass) -> System:
        return sp.System(sp.Mass(m), sp.Spring(k), sp.Dashpot(c))

    rng = np.random.default_rng(3)
    drive = rough_force(1200, rng) * (mass if on == "mass" else 1.0)
    x = simulated(heavy(9.0 * mass, 0.4 * mass), drive, on)[:, 0]
    data = sp.MeasuredRecord(
        STEP * np.arange(1200), x + 0.02 * x.std() * rng.standard_normal(1200), input=drive, on=on, start="rest",
        interpolation="linear",
    )  # fmt: skip
    k, c = sp.free("k", 14.0 * mass, (mass, 100.0 * mass)), sp.free("c", mass, (0.02 * mass, 10.0 * mass))
    found = sp.fit(heavy(k, c), data)
    assert found.values["k"] == pytest.approx(9.0 * mass, rel=0.01)
    assert found.values["c"] == pytest.approx(0.4 * mass, rel=0.01)


@pytest.mark.parametrize(
    ("kind", "taken_for"),
    [("duffing", "linear"), ("springpot", "linear"), validation("contact", "linear"), validation("wall", "contact")],
)
def test_a_wrong_model_is_said_to_be_wrong(kind: str, taken_for: str) -> None:
    try:
        found = sp.fit(device(taken_for), twin(kind, 5))
    except NoFitError as fault:
        assert "% of it are left" in str(fault)  # noqa: PT017  (either is right)
    else:
        assert not found.check().passed


def test_a_right_model_passes_and_predicts_another_record() -> None:
    found = sp.fit(device("duffing", k=8.0), twin("duffing", 7))
    assert found.check().passed
    other = twin("duffing", 8, start="free", skip=5.0)
    prediction = found.predict(other)
    assert prediction.share == pytest.approx(0.02, rel=0.15)
    assert prediction.error.mean() < 0.2 * prediction.left
    assert prediction.values.shape == other.values.shape


def test_x_and_v_at_the_first_sample_the_delay_and_the_offset_are_found() -> None:
    rng = np.random.default_rng(2)
    force = rough_force(900, rng)
    path = simulated(device("linear", free=False), force)
    x, v = path[100:, 0], path[100:, 1]
    values = np.roll(x, 2)[2:] + 0.003 + 0.001 * rng.standard_normal(798)
    data = sp.MeasuredRecord(STEP * np.arange(798), values, input=force[102:], delay=None, interpolation="linear")
    found = sp.fit(device("linear"), data)
    for name, value in {"k": 9.0, "c": 0.4, "offset": 0.003, "delay": 2 * STEP}.items():
        assert abs(found.values[name] - value) < 5.0 * found.errors[name] + 1e-4 * abs(value)
    assert found.values["x0"] == pytest.approx(x[0], abs=0.05)  # what acted before the record came later is not known
    assert found.values["v0"] == pytest.approx(v[0], abs=0.5)


@pytest.mark.validation  # every day: two masses at two points, below
def test_pieces_of_a_long_record_agree_with_the_whole() -> None:
    whole = twin("duffing", 9, 2400, start="free")
    one, cut = sp.fit(device("duffing"), whole), sp.fit(device("duffing"), whole.in_pieces(3))
    for name in TRUTH["duffing"]:
        assert abs(one.values[name] - cut.values[name]) < 3.0 * cut.errors[name]
    assert {"x0_1", "v0_3"} <= {*cut.values}


def test_two_masses_seen_at_two_points_on_a_shaken_ground() -> None:
    def frame(free: bool) -> System:
        def number(name: str, value: float) -> Any:
            return sp.free(name, 1.2 * value, (0.1 * value, 10.0 * value)) if free else value

        return sp.System(
            low=sp.Mass(1.0, at="low"), top=sp.Mass(0.5, at="top"),
            first=sp.Spring(number("k1", 40.0), between=("ground", "low")),
            brake=sp.Dashpot(0.3, between=("ground", "low")),
            second=sp.Spring(number("k2", 30.0), between=("low", "top")),
            damper=sp.Dashpot(number("c2", 0.2), between=("low", "top")),
        )  # fmt: skip

    rng = np.random.default_rng(4)
    ground = rough_force(1200, rng)
    path = simulated(frame(free=False), ground, on="ground")
    low, top = path[:, 0, 0], path[:, 1, 0]
    values = np.array([low, top]) + 0.02 * low.std() * rng.standard_normal((2, 1200))
    data = sp.MeasuredRecord(
        STEP * np.arange(1200),
        values,
        at=("low", "top"),
        input=ground,
        on="ground",
        start="rest",
        interpolation="linear",
    )
    found = sp.fit(frame(free=True), data)
    for name, value in {"k1": 40.0, "k2": 30.0, "c2": 0.2}.items():
        assert abs(found.values[name] - value) < 4.0 * found.errors[name]
        assert found.errors[name] < 0.05 * value


@pytest.mark.validation  # every day: two masses on a shaken ground, above
def test_an_accelerometer_on_a_shaken_table() -> None:
    rng = np.random.default_rng(6)
    ground = np.convolve(rough_force(1204, rng), np.ones(5) / 5.0, "valid")
    x, v = simulated(device("duffing", free=False), ground, on="ground").T
    force = -(9.0 * x + 0.42 * v + 2.5 * x**3)
    data = sp.MeasuredRecord(
        STEP * np.arange(1200), force + 0.02 * force.std() * rng.standard_normal(1200), of="a",
        input=ground, on="ground",
        start="rest", interpolation="linear",
    )  # fmt: skip
    found = sp.fit(device("duffing", k=8.0), data)
    for name, value in TRUTH["duffing"].items():
        assert abs(found.values[name] - value) < 4.0 * found.errors[name]


def test_numbers_that_leave_the_path_as_it_is_are_named() -> None:
    data = twin("linear", 11)
    model = sp.System(
        sp.Spring(sp.free("k", 9.0, (1.0, 100.0))),
        sp.Dashpot(0.4),
        sp.Barrier(sp.free("gap", -50.0, (-90.0, -40.0)), 0.7),
    )
    with pytest.raises(
        ValueError, match="gap must not be free: this record depends on none of this: the path never reaches"
    ):
        sp.fit(model, data)


@pytest.mark.parametrize("kind", ["linear", validation("duffing")])
@pytest.mark.parametrize(
    ("factor", "words"), [(-1.0, "check the sign of the input"), validation(1000.0, "check the units")]
)
def test_a_wrong_sign_or_unit_is_named(factor: float, words: str, kind: str) -> None:
    data = twin(kind, 12, 400)
    wrong = sp.MeasuredRecord(data.time, factor * data.values, input=data.input, start="rest", interpolation="linear")
    with pytest.raises(NoFitError, match=words):
        sp.fit(restarted(device(kind), {"k": 9.5}), wrong)


def test_a_search_that_is_stopped_gives_the_best_so_far() -> None:
    asked = iter(range(12))
    found = sp.fit(device("duffing", k=8.0), twin("duffing", 13), stop=lambda: next(asked, None) is None)
    assert any("stopped" in each for each in found.warnings)
    assert np.isfinite([*found.values.values()]).all()
