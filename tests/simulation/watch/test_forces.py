"""Forces of parts and absolute accelerations: against linear theory, and the momentum of walls."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import pytest

import springpot as sp
from springpot.machine.faults import NotCoveredError
from springpot.problem.outputs import about_shocks
from springpot.simulation.monte_carlo import simulated
from springpot.theory import linear
from tests.simulation.systems import NEARLY_LINEAR, of_many_kinds
from tests.sizes import validation

SHAKING = sp.WhiteNoise(1.0, on="ground")


def device(order: float, *more: Any, **named: Any) -> sp.System:
    mount = sp.Springpot(order, 2.0)
    return sp.System(sp.Mass(2.0), *more, spring=sp.Spring(8.0), mount=mount, shaking=SHAKING, **named)


def isolated(damper: Any) -> sp.System:
    """A storey on a base: with the dashpot the section on several masses has its numbers by Lyapunov's equation."""
    return sp.System(
        sp.Mass(0.2, at="base"), sp.Mass(1.0, at="top"), spring=sp.Spring(0.192, between=("ground", "base")),
        mount=damper, storey=sp.Spring(4.0, between=("base", "top")), loss=sp.Dashpot(0.08, between=("base", "top")),
        shaking=sp.WhiteNoise(0.1, on="ground"),
    )  # fmt: skip


DAMPERS = sp.Dashpot(0.096, between=("ground", "base")), sp.Springpot(0.5, 0.3, between=("ground", "base"))


def off(run: Any, system: sp.System, name: str) -> tuple[float, float]:
    """How far a mean square is from linear theory's, and its standard error, as shares."""
    exact = linear(system).mean_square(name)
    found = run[f"{name}_mean_square"]
    return found.value / exact - 1.0, found.error / exact


# --- against linear theory --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("order", [validation(0.25), 0.5, validation(0.75), 1.0])
def test_forces_of_one_mass_are_those_of_linear_theory(order: float) -> None:
    system = device(order)
    names = "mount_force", "spring_force", "force_on_ground", "acceleration"
    run = simulated(system, paths=12800, duration=150.0, window=(50.0, 150.0), step=0.04, start="rest", forces=names)
    for name in names:
        far, error = off(run, system, name)
        assert error < 0.004
        assert abs(far) < 3.5 * error + 0.001
    assert run["force_on_ground_mean_square"].unit == "N2"
    assert run["acceleration_mean_square"].unit == "m2 s-4"


def test_a_long_step_leaves_the_force_of_a_dashpot() -> None:
    """The mean of a step lacks a quarter of what the noise brings in it, 3 % here: it is added."""
    system = sp.System(sp.Mass(2.0), sp.Spring(8.0), mount=sp.Dashpot(1.0), shaking=SHAKING)
    run = simulated(
        system, paths=12800, duration=120.0, window=(40.0, 120.0), step=0.2, start="rest", forces=("mount_force",),
        observables={"raw": lambda mount_force: mount_force**2},
    )  # fmt: skip
    far, error = off(run, system, "mount_force")
    assert abs(far) < 3.5 * error < 0.01
    assert 0.94 < run["raw"].value / run["mount_force_mean_square"].value < 0.96


@pytest.mark.parametrize("damper", DAMPERS)
def test_forces_of_several_masses_are_those_of_linear_theory(damper: Any) -> None:
    system = isolated(damper)
    names = "base_acceleration", "top_acceleration", "mount_force", "storey_force", "force_on_ground"
    run = simulated(system, paths=1920, duration=400.0, window=(150.0, 400.0), step=0.03, forces=names)
    for name in names:
        far, error = off(run, system, name)
        assert error < 0.008
        assert abs(far) < 3.5 * error + 0.002


def test_linear_theory_has_the_absolute_acceleration_of_an_isolated_storey() -> None:
    by_lyapunov = linear(isolated(DAMPERS[0]))
    found = [by_lyapunov.mean_square(f"{point}_acceleration") for point in ("base", "top")]
    assert found == pytest.approx([0.111115, 0.108969], abs=6e-7)


@pytest.mark.parametrize("of", ["mount_force", "force_on_ground", "acceleration"])
def test_a_mean_square_is_the_integral_of_the_spectrum(of: str) -> None:
    found = linear(device(0.5))
    u = np.linspace(-14.0, 16.0, 200_001)
    w = np.exp(u)
    whole = 2.0 * np.trapezoid(found.spectrum(w, of) * w, u)
    assert whole == pytest.approx(found.mean_square(of), rel=1e-4)


def test_one_of_two_masses_that_do_not_meet_is_one_mass() -> None:
    alone = linear(device(0.5))
    both = linear(
        sp.System(
            sp.Mass(2.0, at="a"), sp.Mass(1.0, at="b"), sp.Spring(1.0, between=("ground", "b")),
            sp.Dashpot(1.0, between=("ground", "b")), sp.Spring(8.0, between=("ground", "a")),
            mount=sp.Springpot(0.5, 2.0, between=("ground", "a")), shaking=SHAKING,
        )
    )  # fmt: skip
    assert both.mean_square("mount_force") == pytest.approx(alone.mean_square("mount_force"), rel=1e-6)
    assert both.mean_square("a_acceleration") == pytest.approx(alone.mean_square("acceleration"), rel=1e-6)


PUSHES = {
    "colored": sp.ColoredNoise(1.0, 0.5), "kanai-tajimi": sp.KanaiTajimiNoise(3.0, 0.4, 1.0, on="mass"),
    "harmonic": sp.Harmonic(1.0, 1.5),
    "spectral": sp.SpectralExcitation.from_psd((0.05, 0.2, 1.0), (0.5, 1.0, 0.2), "N2/Hz"),
}  # fmt: skip


@pytest.mark.parametrize("masses", [pytest.param(1, marks=pytest.mark.validation), 2])
@pytest.mark.parametrize("kind", PUSHES)
def test_a_smooth_force_on_the_mass_is_in_its_acceleration(kind: str, masses: int) -> None:
    ends: dict[str, Any] = {"between": ("ground", "a")} if masses == 2 else {}
    push, mount = PUSHES[kind], sp.Springpot(0.5, 2.0, **ends)
    if masses == 1:
        system = sp.System(sp.Mass(2.0), sp.Spring(8.0), mount=mount, push=push)
    else:
        system = sp.System(
            sp.Mass(2.0, at="a"), sp.Mass(1.0, at="b"), sp.Spring(8.0, **ends), sp.Spring(4.0, between=("ground", "b")),
            sp.Dashpot(1.0, between=("ground", "b")), rough=sp.WhiteNoise(1.0, on="b"), mount=mount,
            push=dataclasses.replace(push, on="a"),
        )  # fmt: skip
    name = "acceleration" if masses == 1 else "a_acceleration"
    run = simulated(system, paths=1280, duration=150.0, window=(50.0, 150.0), step=0.02, start="rest", forces=(name,))
    found, exact = run[f"{name}_mean_square"], linear(system).mean_square(name)
    assert found.error < 0.006 * exact
    assert abs(found.value - exact) < 3.5 * found.error + 0.002 * exact


# --- momentum ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("order", [0.25, 0.5, 1.0])
def test_walls_give_what_the_parts_take(order: float) -> None:
    system = device(order, stop=sp.Barrier(-0.1, 0.8))
    run = simulated(
        system, paths=1280, duration=200.0, window=(60.0, 200.0), step=0.01, start="rest", forces=("force_on_ground",)
    )
    taken, given = run["force_on_ground_mean"], run["stop_force_mean"]
    assert taken.error < 0.02 * taken.value
    assert abs(taken.value - given.value) < 3.0 * np.hypot(taken.error, given.error)
    assert taken.value == pytest.approx(given.value, rel=0.01)


@pytest.mark.validation  # every day: walls give what the parts take, above
def test_pounding_masses_give_what_the_parts_take() -> None:
    system = sp.System(*isolated(DAMPERS[1]).parts, stop=sp.Barrier(-0.05, 0.6, between=("base", "top")))
    run = simulated(system, paths=1280, duration=300.0, window=(150.0, 300.0), step=0.01, forces=("force_on_ground",))
    assert abs(run["force_on_ground_mean"].value) < 3.0 * run["force_on_ground_mean"].error


# --- what is refused --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("system", "names", "words"),
    [
        (sp.System(sp.Spring(1.0), sp.Dashpot(1.0), sp.WhiteNoise(1.0)), ("acceleration",), "white_noise would be in"),
        (sp.System(sp.Spring(1.0), sp.Dashpot(1.0), sp.ColoredNoise(1.0, 1.0), SHAKING), ("acceleration",), "one"),
        (sp.System(sp.Spring(1.0), sp.Dashpot(1.0), sp.ThermalNoise(1.0)), ("dashpot_force",), "matched noise of"),
        (sp.System(sp.Spring(1.0), sp.Friction(1.0), SHAKING), ("force_on_ground",), "friction is not seen"),
        (device(0.5, sp.Springpot(0.3, 1.0)), ("mount_force",), "have the same ends"),
    ],
)  # fmt: skip
def test_what_has_no_force_says_why(system: sp.System, names: tuple[str, ...], words: str) -> None:
    with pytest.raises(NotCoveredError, match=words):
        simulated(system, forces=names)


def test_an_unknown_force_is_refused_with_the_nearest() -> None:
    with pytest.raises(ValueError, match=r"forces has 'mount', which is no force or acceleration.*mount_force"):
        simulated(device(0.5), forces=("mount",))
    with pytest.raises(ValueError, match="default scheme only"):
        simulated(device(0.5), forces=("mount_force",), scheme="grunwald", step=0.1)


def test_theory_refuses_what_has_no_finite_mean_square() -> None:
    pushed = sp.System(sp.Mass(2.0), sp.Spring(8.0), sp.Dashpot(1.0), push=sp.WhiteNoise(1.0))
    with pytest.raises(NotCoveredError, match="push acts on the mass itself"):
        linear(pushed).mean_square("acceleration")
    warm = linear(sp.System(sp.Mass(2.0), sp.Spring(8.0), mount=sp.Springpot(0.5, 1.0), hot=sp.ThermalNoise(1.0)))
    with pytest.raises(NotCoveredError, match="matched noise of mount"):
        warm.mean_square("mount_force")
    assert warm.mean_square("spring_force") == pytest.approx(8.0)


# --- spectra and peaks ------------------------------------------------------------------------------------------------

FREQUENCIES = np.array([0.7, 1.5, 2.0, 2.6, 4.0])


@pytest.mark.parametrize("named", ["mount_force", "acceleration"])
def test_spectra_and_peaks_of_forces(named: str) -> None:
    system = device(0.5)
    run = simulated(
        system, paths=1280, duration=200.0, window=(40.0, 200.0), step=0.02, start="rest", forces=(named,),
        spectrum=FREQUENCIES, distributions=True,
    )  # fmt: skip
    found = run.spectra[named]
    exact = linear(system).spectrum(FREQUENCIES, named)
    assert np.all(np.abs(found.density - exact) < 4.0 * found.standard_error + 0.01 * exact)
    assert np.all(found.standard_error < 0.04 * exact)
    peaks = run.extremes[f"{named}_maximum"] / np.sqrt(run[f"{named}_mean_square"].value)
    assert 2.5 < np.median(peaks) < 4.5  # of some hundred cycles
    data = run.to_xarray()
    unit = "N" if named == "mount_force" else "m s-2"
    assert data[f"{named}_maximum_quantile"].units == unit
    assert data[f"{named}_spectrum"].units == {"N": "N2 s rad-1", "m s-2": "m2 s-3 rad-1"}[unit]


def test_peaks_of_a_force_in_a_system_of_several_masses() -> None:
    system = isolated(DAMPERS[1])
    run = simulated(system, paths=128, duration=60.0, forces=("storey_force",), distributions=True)
    spring = 4.0 * run.extremes["base_top_elongation_maximum"]
    assert run.extremes["storey_force_maximum"] == pytest.approx(spring, rel=0.05)


# --- distributions, profiles and records ------------------------------------------------------------------------------


def test_a_force_has_a_distribution_a_profile_and_a_record() -> None:
    system, names = device(0.5), ("mount_force", "spring_force", "force_on_ground")
    run = simulated(
        system, paths=640, duration=200.0, window=(40.0, 200.0), step=0.02, start="rest", forces=names, record=2,
        distributions=True, profile=4,
    )  # fmt: skip
    spring = run.distributions["spring_force"]
    assert (spring.unit, spring.density_unit) == ("N", "N-1")
    at, error = spring.quantile([0.05, 0.95])
    root = linear(system).mean_square("spring_force") ** 0.5
    assert np.all(np.abs(at / root - [-1.6449, 1.6449]) < 4.0 * error / root)
    assert np.all(error < 0.02 * root)
    inside = run.profiles["mount_force_mean_square_profile"]
    assert inside.value.mean() == pytest.approx(run["mount_force_mean_square"].value, rel=2e-3)
    assert np.allclose(run.forces["mount_force"] + run.forces["spring_force"], run.forces["force_on_ground"])
    x = run.record[..., 0]
    # a kick is in the middle of a step: the mean of both ends lacks a quarter of its change of the velocity
    between = run.forces["spring_force"][:, 1:] - 4.0 * (x[:, 1:] + x[:, :-1])
    assert between.std() == pytest.approx(8.0 * 0.02 / 4.0 * 0.02**0.5, rel=0.05)
    assert run.to_xarray()["spring_force"].dims == ("path", "time")


def test_forces_in_a_record_of_several_masses_are_those_of_the_parts(tmp_path: Any) -> None:
    system = isolated(DAMPERS[1])
    run = simulated(system, paths=64, duration=20.0, forces=("storey_force",), record=3, record_every=2)
    stretched = run.record[:, :, 1, 0] - run.record[:, :, 0, 0]
    assert run.forces["storey_force"].shape == (3, len(run.time))
    assert np.corrcoef(4.0 * stretched.ravel(), run.forces["storey_force"].ravel())[0, 1] > 0.999
    again = sp.load_run(run.save(tmp_path / "run.nc"))
    assert np.array_equal(again.forces["storey_force"], run.forces["storey_force"])
    header = run.save(tmp_path / "run.csv").with_name("run_paths.csv").read_text(encoding="utf-8").splitlines()[0]
    assert header.endswith("storey force of path 2 (N)")


def test_forces_have_the_same_bits_for_any_threads() -> None:
    runs = [
        simulated(
            device(0.5, stop=sp.Barrier(-0.1, 0.8)), paths=640, duration=20.0, step=0.02, start="rest", threads=threads,
            forces=("mount_force", "acceleration"), record=1, distributions=True, profile=5,
        )
        for threads in (1, 2)
    ]  # fmt: skip
    one, two = (run.to_xarray().drop_attrs() for run in runs)
    assert one.identical(two)
    said = [str(message) for message in runs[0].warnings if message.name == "shocks_left_out"]
    assert len(said) == 1
    assert said[0].startswith("acceleration is that between impacts: the shocks on stop are not in it")


BELOW = sp.Barrier(-0.1, 0.8)
BETWEEN = sp.Barrier(-0.05, 0.6, between=("base", "top"))
OUTPUTS = ["mount_force", "force_on_ground", "acceleration", "base_acceleration", "top_acceleration"]


@pytest.mark.parametrize(
    ("system", "values", "named"),
    [
        (device(0.5, stop=BELOW), {"impact_rate": 0.2}, OUTPUTS[1:3]),
        (device(0.5, stop=BELOW), {"impact_rate": float("nan")}, OUTPUTS[1:3]),
        (device(0.5, stop=BELOW), {"impact_rate": 0.0}, []),
        (device(0.5, stop=sp.Contact(-0.1, 1e4)), {"impact_rate": 0.2}, []),
        (device(0.5), {}, []),
        (sp.System(*isolated(DAMPERS[1]).parts, stop=BETWEEN), {"stop_impact_rate": 0.1}, OUTPUTS[3:]),
    ],
)
def test_shocks_are_left_out_of_what_a_struck_rigid_wall_acts_on(
    system: sp.System, values: dict[str, float], named: list[str]
) -> None:
    said = about_shocks(system, OUTPUTS, values)
    assert [str(message).split()[0] for message in said] == named
    assert all("on stop are" in message for message in said)


def test_forces_of_too_many_recorded_points_are_refused() -> None:
    with pytest.raises(ValueError, match=r"60,000,030 points of forces.*larger record_every"):
        simulated(
            device(0.5), paths=10, duration=1e5, step=0.05, record=10,
            forces=("mount_force", "spring_force", "acceleration"),
        )  # fmt: skip


# --- soft stops -------------------------------------------------------------------------------------------------------


def half_sines(run: Any, stop: str, of_all: bool) -> None:
    """A linear stop that is touched at rest of all springs pushes for half a period of sqrt(k / m): 1 kg, 1e4 N/m."""
    speed = run["impact_speed_mean_square" if of_all else f"{stop}_impact_speed_mean_square"].value
    highest, rate = run[f"{stop}_peak_force_mean_square"], run[f"{stop}_impact_rate"].value
    assert highest.value == pytest.approx(1e4 * speed, rel=0.006)
    assert highest.unit == "N2"
    assert run[f"{stop}_force_mean_square"].value == pytest.approx(rate * 1e4 * speed * np.pi / 200.0, rel=0.015)
    found = run.distributions[f"{stop}_peak_force"]
    speeds = run.distributions["impact_speed" if of_all else f"{stop}_impact_speed"]
    assert found.size == pytest.approx(speeds.size, abs=10)
    parts = [0.25, 0.5, 0.75, 0.95]
    assert np.allclose(found.quantile(parts)[0], 100.0 * speeds.quantile(parts)[0], rtol=0.01)
    deepest = run.to_xarray()[f"{stop}_peak_force_largest_quantile"]
    assert deepest.units == "N"
    assert np.nanmax(deepest) == pytest.approx(run.extremes[f"{stop}_peak_force_largest"].max(), rel=0.05)


def test_the_peaks_of_a_stiff_contact_are_half_sines() -> None:
    system = of_many_kinds(
        sp.Mass(1.0), sp.Spring(4.0), sp.Springpot(0.5, 0.4), SHAKING, sp.Contact(0.0, 1e4, 1.0, free_side="above")
    )
    run = simulated(
        system, paths=640, duration=40.0, window=(10.0, 40.0), step=0.01, start="rest", distributions=True,
        forces=("contact_force", "contact_peak_force"),
    )  # fmt: skip
    half_sines(run, "contact", of_all=True)


@pytest.mark.validation  # every day: those of one mass
def test_soft_stops_of_several_masses_push_as_one_does_and_give_what_the_parts_take() -> None:
    ends: dict[str, Any] = {"between": ("ground", "a")}
    system = sp.System(
        sp.Mass(1.0, at="a"), sp.Mass(1.0, at="b"), sp.Spring(4.0, **ends), sp.Springpot(0.5, 0.4, **ends),
        sp.Spring(4.0, between=("ground", "b")), sp.Dashpot(0.4, between=("ground", "b")), SHAKING,
        stop=sp.Contact(0.0, 1e4, 1.0, free_side="above", **ends),
    )  # fmt: skip
    run = simulated(
        system, paths=640, duration=40.0, window=(10.0, 40.0), step=0.0025, distributions=True, record=1,
        forces=("stop_force", "stop_peak_force", "force_on_ground"),
    )  # fmt: skip
    half_sines(run, "stop", of_all=False)
    balance = run["force_on_ground_mean"]
    assert abs(balance.value) < 3.0 * balance.error < 0.03 * run["stop_force_mean"].value
    assert run.forces["stop_force"].min() == 0.0


@pytest.mark.validation
def test_a_lossy_contact_gives_what_the_parts_take() -> None:
    """Springs and the springpot carry what two stops push; the mean square is that of the sum of all."""
    system = device(0.5, low=sp.Contact(-0.1, 2e3, 1.5, 0.3), high=sp.Contact(0.3, 3e3, 1.0, 0.1))
    run = simulated(
        system, paths=1280, duration=120.0, window=(40.0, 120.0), step=0.01, start="rest",
        forces=("spring_force", "mount_force", "low_force", "high_force", "force_on_ground", "acceleration"),
        observables={"low_pushes": lambda low_force: low_force},
    )  # fmt: skip
    given = run["low_force_mean"].value - run["high_force_mean"].value
    taken = run["spring_force_mean"].value + run["mount_force_mean"].value
    assert taken == pytest.approx(given, abs=3.0 * run["force_on_ground_mean"].error)
    assert run["low_pushes"].value == pytest.approx(run["low_force_mean"].value, rel=0.01)
    assert abs(run["force_on_ground_mean"].value) < 3.0 * run["force_on_ground_mean"].error
    assert run["force_on_ground_mean_square"].value == pytest.approx(4.0 * run["acceleration_mean_square"].value)


# --- first passages ---------------------------------------------------------------------------------------------------


def passed(step: float) -> tuple[float, float]:
    """The probability that the acceleration on a strong dashpot leaves three standard deviations, and its error."""
    system = sp.System(sp.Mass(1.0), sp.Spring(1.0), mount=sp.Dashpot(1.0), shaking=SHAKING)
    root = linear(system).mean_square("acceleration") ** 0.5
    three = -3.0 * root, 3.0 * root
    run = simulated(system, paths=20480, duration=10.0, step=step, start="rest", first_passage={"acceleration": three})
    found = run.first_passages["acceleration"]
    assert found.unit == "m s-2"
    return float(1.0 - found.survival(9.9)[0]), float(found.survival(9.9)[1])


@pytest.mark.validation
def test_the_passage_of_a_rough_force_does_not_depend_on_the_step() -> None:
    """Without what lowers the level, half of them would be missed at this step."""
    (coarse, error), (fine, other) = passed(0.08), passed(0.02)
    assert abs(coarse - fine) < 3.0 * np.hypot(error, other) + 0.03 * fine
    assert error < 0.03 * coarse


def test_the_passage_of_the_force_of_a_spring_is_that_of_the_displacement() -> None:
    run = simulated(
        device(0.5), paths=640, duration=30.0, step=0.01, start="rest",
        first_passage={"x": [-0.4, 0.6], "spring_force": [-3.2, 4.8]},
    )  # fmt: skip
    for x, force in zip(run.first_passages["x"], run.first_passages["spring_force"], strict=True):
        both = np.isfinite(x.times) & np.isfinite(force.times)
        assert both.sum() > 0.98 * np.isfinite(x.times).sum() > 100
        assert np.median(np.abs(x.times[both] - force.times[both])) < 0.01


def test_a_long_step_is_told_where_more_than_moments_is_wanted() -> None:
    system = sp.System(sp.Mass(2.0), sp.Spring(8.0), mount=sp.Dashpot(1.0), shaking=SHAKING)
    given: dict[str, Any] = {"paths": 64, "duration": 20.0, "step": 0.2, "forces": ("mount_force",)}
    assert not [said for said in simulated(system, **given).warnings if "over a step" in said]
    (said,) = (said for said in simulated(system, record=1, **given).warnings if "over a step" in said)
    assert said.startswith("mount_force is seen as its mean over a step, which lacks ")
    with pytest.raises(
        ValueError, match="forces cannot be given with rtol, which controls their mean squares: name these"
    ):
        simulated(system, rtol=0.1, forces=("mount_force",))


# --- with rtol --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "damper", [sp.Dashpot(1.0), sp.Springpot(0.5, 1.0), sp.Maxwell(6.0, 0.5)], ids=lambda own: type(own).__name__
)
def test_rtol_controls_mean_squares_of_forces(damper: Any) -> None:
    system = sp.System(sp.Mass(2.0), sp.Spring(8.0), mount=damper, shaking=SHAKING)
    exact, names = linear(system), ["mount_force_mean_square", "acceleration_mean_square"]
    run = simulated(system, rtol=0.01, quantities=names, seed=3)
    for name in names:
        own = run.estimates[name]
        assert own.budget is not None
        assert own.budget.total < 0.01 * own.value
        assert abs(own.value - exact.mean_square(name.removesuffix("_mean_square"))) < own.budget.total


@pytest.mark.validation  # every day: rtol of forces, above
def test_rtol_sees_what_a_step_does_to_the_acceleration_on_a_soft_stop() -> None:
    """Its step bias is 2.5 % at the step that the run begins with."""
    system = device(0.6, stop=sp.Contact.linear(-0.5, 2000.0, dissipation=0.1))
    own = simulated(system, rtol=0.02, quantities=["acceleration_mean_square"], seed=2).estimates
    fine = simulated(system, paths=6400, duration=130.0, step=0.005, forces=["acceleration"], seed=5)
    there, here = fine["acceleration_mean_square"], own["acceleration_mean_square"]
    assert here.budget is not None
    assert here.budget.total < 0.02 * here.value
    assert there.error < 0.005 * there.value
    assert abs(here.value - there.value) < here.budget.total + 2.0 * there.error


def test_a_mean_force_is_refused_by_rtol_and_a_longer_run_sees_no_force() -> None:
    system = device(0.5)
    with pytest.raises(ValueError, match="of forces and accelerations rtol controls mean squares"):
        simulated(system, rtol=0.1, quantities=["mount_force_mean"])
    run = simulated(system, paths=64, duration=20.0)
    with pytest.raises(ValueError, match=r"quantities must not have mount_force_mean_square here: only a run by simul"):
        sp.extend(run, rtol=0.1, quantities=["mount_force_mean_square"])


# --- crossings and densities of linear theory -------------------------------------------------------------------------


def test_crossings_and_densities_of_a_force_are_those_of_linear_theory() -> None:
    system = device(0.25)
    exact = linear(system)
    root = exact.mean_square("mount_force") ** 0.5
    moments = exact.spectral_moments((0.0, 2.0), "mount_force")
    assert moments[0.0] == pytest.approx(root**2, rel=1e-6)
    rate = exact.crossing_rate(1.5 * root, of="mount_force")
    assert rate == pytest.approx((moments[2.0] / moments[0.0]) ** 0.5 / (2.0 * np.pi) * np.exp(-1.125), rel=1e-6)
    run = simulated(
        system, paths=640, duration=100.0, window=(40.0, 100.0), step=0.02, start="rest", record=640,
        forces=("mount_force",), distributions=True,
    )  # fmt: skip
    force = run.forces["mount_force"][:, 2001:]
    up = ((force[:, :-1] < 1.5 * root) & (force[:, 1:] >= 1.5 * root)).sum(axis=1) / 60.0
    assert up.std() / 640**0.5 < 0.02 * rate
    assert abs(up.mean() - rate) < 3.5 * up.std() / 640**0.5 + 0.005 * rate
    edges, density, error = run.distributions["mount_force"].density(20)
    gauss = exact.density(0.5 * (edges[1:] + edges[:-1]), of="mount_force")
    assert np.all(np.abs(density - gauss) < 4.0 * error + 0.03 * gauss.max())


def test_what_has_no_crossings_says_so() -> None:
    exact = linear(device(1.0))
    assert exact.crossing_rate(1.0, of="mount_force") == np.inf
    assert exact.crossing_rate(1.0, of="spring_force") < 1.0
    with pytest.raises(ValueError, match=r"'mount' is no force or acceleration; there are spring_force"):
        exact.mean_square("mount")
    shots = sp.System(sp.Spring(1.0), sp.Dashpot(1.0), sp.PoissonImpulses(1.0, 1.0))
    with pytest.raises(NotCoveredError, match="Only Gaussian responses are covered"):
        linear(shots).density(0.0, of="dashpot_force")


def test_impulses_of_a_rigid_wall_are_its_momentum() -> None:
    system = device(0.5, stop=sp.Barrier(-0.1, 0.8))
    given: dict[str, Any] = {"paths": 640, "duration": 60.0, "step": 0.01, "start": "rest", "distributions": True}
    run = simulated(system, **given, forces=("stop_impulse",))
    mean, momentum = run["stop_impulse_mean"], run["stop_force_mean"].value / run["stop_impact_rate"].value
    assert mean.value == pytest.approx(momentum, rel=1e-6)
    assert (mean.unit, run["stop_impulse_mean_square"].unit) == ("N s", "N2 s2")
    assert run["stop_impulse_mean_square"].value == pytest.approx(3.6**2 * run["impact_speed_mean_square"].value)
    fast = run.distributions["impact_speed"].quantile(0.9)[0]
    assert run.distributions["stop_impulse"].quantile(0.9)[0] == pytest.approx(3.6 * fast, rel=1e-3)
    assert run.to_xarray()["stop_impulse_largest_quantile"].units == "N s"
    with pytest.raises(NotCoveredError, match=r"stop_force cannot be seen: a rigid wall gives .* stop_force_mean"):
        simulated(system, **given, forces=("stop_force",))


def test_each_of_two_stops_has_its_impulses_and_its_rate() -> None:
    """The impulses of both balance the spring but for the noise's, whose mean over all paths is known."""
    stops = {"low": sp.Barrier(-0.3, 0.8), "high": sp.Barrier(0.5, 0.6, free_side="below")}
    slot = sp.System(sp.Mass(2.0), sp.Spring(2.0), sp.Dashpot(0.5), NEARLY_LINEAR, sp.WhiteNoise(1.0), **stops)
    run = simulated(slot, paths=6400, duration=40.0, window=(10.0, 40.0), step=0.04, start="rest",
                    forces=("low_impulse", "high_impulse"), slowest_counted_impact=0.2, impact_observables={
                        "squares": lambda high_impact_speed: high_impact_speed**2})  # fmt: skip
    assert run["squares"].value * (1.0 - 0.6**2) == pytest.approx(run["high_power"].value, rel=1e-6)
    with pytest.raises(ValueError, match="'upper_impact_speed', which is nothing that can be seen"):
        simulated(slot, impact_observables={"wear": lambda upper_impact_speed: upper_impact_speed})
    for stop in stops:
        per_time = run[f"{stop}_impulse_mean"].value * run[f"{stop}_impact_rate"].value
        assert per_time == pytest.approx(run[f"{stop}_force_mean"].value, rel=1e-6)
        assert 0.3 < run[f"{stop}_counted_impact_rate"].value / run[f"{stop}_impact_rate"].value < 1.0
    left = 2.0 * run["x_mean"].value - run["low_force_mean"].value + run["high_force_mean"].value
    error = (1.0 / 30.0 / 6400.0) ** 0.5
    assert error < 0.02 / 3.0 * run["high_force_mean"].value
    assert abs(left) < 3.0 * error
    for name in ("counted_impact_rate", "impact_rate"):
        assert run[name].value == pytest.approx(run[f"low_{name}"].value + run[f"high_{name}"].value, rel=1e-12)
    by_wall = run.to_xarray()["barrier_counted_impact_rate"]
    assert [*by_wall.values] == [run[f"{stop}_counted_impact_rate"].value for stop in stops]


def test_a_soft_stop_has_a_rate_beside_a_wall_that_has_none() -> None:
    """It is that with which the recorded paths enter the contact."""
    device = of_many_kinds(
        sp.Spring(1.0), sp.Dashpot(0.5), sp.WhiteNoise(1.0), sp.Contact(0.4, 100.0, free_side="below"),
        sp.Barrier(-0.3, 0.1),
    )  # fmt: skip
    run = simulated(device, paths=256, duration=40.0, window=(10.0, 40.0), step=0.02, start="rest", record=256)
    for name in ("impact_rate", "barrier_impact_rate", "barrier_impact_speed_mean"):
        assert np.isnan(run[name].value)
    assert run["contact_impact_speed_mean"].value > 0.0
    inside = run.record[:, 501:, 0] > 0.4
    entered = (inside[:, 1:] > inside[:, :-1]).sum(axis=1) / 30.0
    assert run["contact_impact_rate"].value == pytest.approx(entered.mean(), rel=0.015)


def test_impulses_between_masses_are_those_of_the_reduced_mass() -> None:
    stop = sp.Barrier(-0.05, 0.6, between=("base", "top"))
    smooth = sp.System(*isolated(DAMPERS[1]).parts, stop=stop)
    undefined = simulated(smooth, paths=64, duration=10.0, forces=("stop_impulse",))
    assert np.isnan(undefined["stop_impulse_mean"].value)
    assert any(message.name == "uncountable_impacts" for message in undefined.warnings)
    system = sp.System(*smooth.parts[:-1], sp.WhiteNoise(0.01, on="top"), stop=stop)
    run = simulated(system, paths=64, duration=60.0, step=0.01, forces=("stop_impulse",))
    momentum = run["stop_force_mean"].value / run["stop_impact_rate"].value
    # an impact after which the masses rest on each other is counted, but shown to nobody
    assert run["stop_impulse_mean"].value == pytest.approx(momentum, rel=0.01)


def test_a_spring_beside_two_parts_that_yield_has_its_own_force() -> None:
    parts = sp.Spring(4.0), sp.Dashpot(0.1), sp.Jenkins(0.9, 0.3), sp.BoucWen(0.9, 0.3), sp.WhiteNoise(0.5)
    given: dict[str, Any] = {"paths": 64, "duration": 20.0, "start": "rest", "forces": ["own_force"]}
    for more in ((), (sp.Constant(-3.0),)):
        run = sp.simulate(sp.System(*parts, *more, own=sp.Spring(2.0)), **given)
        assert run["own_force_mean"].value == pytest.approx(2.0 * run["x_mean"].value, abs=0.02)
