"""The force of parts that are a group, wherever forces are asked for."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import springpot as sp
from springpot.explorer.requests import offered
from springpot.problem.catalogue import results_on_request

MOUNT = {"group": "mount"}
BOX = sp.System(sp.Mass(2.0), sp.Spring(8.0, **MOUNT), sp.Springpot(0.3, 2.0, **MOUNT), sp.WhiteNoise(1.0, on="ground"))
WHOLE = sp.theory.linear(BOX)


def test_the_force_of_a_group_is_the_sum_of_those_of_its_parts() -> None:
    names = ("spring_force", "springpot_force", "mount_force")
    run = sp.simulate(
        BOX, paths=4000, step=0.05, forces=names, record=8, distributions=True, seed=2,
        rainflow={"mount_force": sp.Basquin(4.0, strength=20.0)}, first_passage={"mount_force": [12.0]},
        observables={"product": lambda mount_force, spring_force: mount_force * spring_force},
    )  # fmt: skip
    spring, pot, mount = (run.forces[name] for name in names)
    assert np.abs(mount - spring - pot).max() < 1e-5 * np.abs(mount).max()
    for name in names:
        found = run[f"{name}_mean_square"]
        assert abs(found.value - WHOLE.mean_square(name)) < 4.0 * found.error
        assert found.error < 0.02 * found.value
    # the force of everything on the ground is the same here
    assert WHOLE.mean_square("mount_force") == pytest.approx(WHOLE.mean_square("force_on_ground"), rel=1e-12)
    low, high = (run.distributions["mount_force"].quantile(share)[0] for share in (0.1587, 0.8413))
    assert 0.5 * (high - low) == pytest.approx(WHOLE.mean_square("mount_force") ** 0.5, rel=0.03)
    assert run["mount_force_damage_rate"].value > 0.0
    assert list(run.first_passages) == ["mount_force"]
    data = run.to_xarray()
    assert data["mount_force_mean_square"].attrs["units"] == "N2"
    assert "mount_force_density" in data


def test_theory_has_it_as_a_run_has() -> None:
    w = np.array([0.5, 2.0, 3.0])
    k = 8.0 + 2.0 * (1j * w) ** 0.3
    exact = np.abs(2.0 * k / (k - 2.0 * w**2)) ** 2 / (2.0 * np.pi)
    assert WHOLE.spectrum(w, of="mount_force") == pytest.approx(exact, rel=1e-12)
    assert WHOLE.mean("mount_force") == 0.0
    assert np.isfinite(WHOLE.crossing_rate(5.0, of="mount_force"))
    life = sp.theory.fatigue(BOX, sp.Basquin(4.0, strength=20.0), "mount_force").life
    assert life == sp.theory.fatigue(BOX, sp.Basquin(4.0, strength=20.0), "force_on_ground").life


FOUR = {"group": "mount", "count": 4}
MOUNTED = sp.System(
    sp.Mass(2.0), sp.Spring(2.0, **FOUR), sp.Springpot(0.3, 0.5, **FOUR), sp.WhiteNoise(1.0, on="ground")
)


def test_of_a_group_with_one_count_the_force_of_one_is_its_share() -> None:
    """Everywhere: in a run, its distributions and names, theory, fatigue, first passages, rare events, the page."""
    names = ["mount_force", "mount_force_of_one", "spring_force_of_one"]
    run = sp.simulate(
        MOUNTED, paths=64, duration=20.0, forces=names, record=4, distributions=True, first_passage={names[1]: [3.0]}
    )
    np.testing.assert_allclose(run.forces["mount_force"], 4.0 * run.forces["mount_force_of_one"], rtol=1e-5, atol=1e-6)
    ratio = run["mount_force_mean_square"].value / run["mount_force_of_one_mean_square"].value
    assert ratio == pytest.approx(16.0, rel=1e-5)
    assert run.to_xarray()["mount_force_of_one_mean_square"].attrs["units"] == "N2"
    exact = sp.theory.linear(MOUNTED)
    assert exact.mean_square("mount_force") == pytest.approx(16.0 * exact.mean_square("mount_force_of_one"), rel=1e-12)
    assert sp.theory.fatigue(MOUNTED, sp.Basquin(4.0, strength=20.0), "mount_force_of_one").life
    assert "mount_force_of_one" in [name for name, *_ in offered(MOUNTED)["forces"]]
    assert "mount_force_of_one_spectrum" in results_on_request(MOUNTED)
    assert sp.exceedance(MOUNTED, {"mount_force_of_one": [3.0]}, duration=5.0, rtol=0.5, max_time=20.0)


def test_of_a_group_with_several_counts_there_is_no_force_of_one() -> None:
    mixed = sp.System(sp.Mass(2.0), sp.Spring(2.0, **FOUR), sp.Springpot(0.3, 0.5, group="mount"), sp.WhiteNoise(1.0))
    assert mixed.counts == {"spring": 4}
    assert "mount_force_of_one_spectrum" not in results_on_request(mixed)
    with pytest.raises(ValueError, match=r"mount_force_of_one.* did you mean mount_force"):
        sp.simulate(mixed, paths=8, duration=1.0, forces=["mount_force_of_one"])


def test_designs_the_page_and_files_have_it(tmp_path: Path) -> None:
    assert "mount_force" in [name for name, *_ in offered(BOX)["forces"]]
    assert "mount_force_spectrum" in results_on_request(BOX)
    assert sp.read_system(_written(tmp_path, BOX)) == BOX
    changes = sp.sensitivity(BOX, ["mount_force_mean_square"])
    assert "mount_force_mean_square" in str(changes)
    assert repr(BOX).startswith("System(Mass(value=2.0), Spring(stiffness=8.0, group='mount'), ")


def _written(folder: Path, system: sp.System) -> Path:
    (folder / "box.toml").write_text(sp.to_toml(system), encoding="utf-8")
    return folder / "box.toml"


def test_of_several_masses_and_equal_parts() -> None:
    ends: dict[str, Any] = {"between": ("a", "b"), "group": "link"}
    pair = sp.System(
        sp.Mass(1.0, at="a"), sp.Mass(0.5, at="b"), sp.Spring(4.0, between=("ground", "a")),
        sp.Dashpot(0.4, between=("ground", "a")), sp.Spring(0.75, count=4, **ends),
        sp.Springpot(0.4, 0.25, count=2, **ends),
        sp.WhiteNoise(1.0, on="a"),
    )  # fmt: skip
    theory = sp.theory.linear(pair)
    forces = "link_force", "spring_2_force", "springpot_force"
    run = sp.simulate(pair, paths=4000, step=0.05, forces=forces, record=4, seed=3)
    link, spring, pot = (run.forces[name] for name in forces)
    assert np.abs(link - spring - pot).max() < 1e-5 * np.abs(link).max()
    found = run["link_force_mean_square"]
    assert abs(found.value - theory.mean_square("link_force")) < 4.0 * found.error


@pytest.mark.parametrize(
    ("parts", "sentence"),
    [
        ((sp.Spring(1.0, group="spring"),), "group of spring must be another name: spring is that of a part"),
        ((sp.Spring(1.0, group="damping"), sp.Dashpot(0.1)),
         "damping_force_mean would be the name of two results, of the whole system and of the group damping"),
        ((sp.Mass(1.0, at="a"), sp.Mass(1.0, at="b"), sp.Spring(1.0, between=("ground", "a"), group="mount"),
          sp.Spring(1.0, between=("a", "b"), group="mount")),
         "group mount must be of parts with the same ends, but spring_1 and spring_2 have others"),
    ],
)  # fmt: skip
def test_a_group_that_cannot_be_is_refused(parts: tuple[Any, ...], sentence: str) -> None:
    with pytest.raises(ValueError, match=f"^{sentence}"):
        sp.System(*parts, sp.WhiteNoise(1.0, on="mass" if isinstance(parts[0], sp.Spring) else "a"))


def test_what_of_a_group_cannot_be_seen_says_why() -> None:
    for group in ("a mount", 3):
        with pytest.raises(ValueError, match=r"^group must be a word of letters, digits and _, not"):
            sp.Spring(1.0, group=group)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="springpot must be without group in a series"):
        sp.FractionalMaxwell(sp.Springpot(0.5, 1.0, **MOUNT), sp.Spring(1.0))
    rubbed = sp.System(sp.Spring(1.0, **MOUNT), sp.Friction(0.1, **MOUNT), sp.WhiteNoise(1.0))
    with pytest.raises(ValueError, match="mount_force cannot be seen: the force of friction is not seen"):
        sp.simulate(rubbed, paths=64, forces=["mount_force"])
    # two memories with the same ends are one: a group has both, or neither
    for other, seen in ((MOUNT, True), ({}, False)):
        pots = sp.Springpot(0.3, 1.0, **MOUNT), sp.Springpot(0.6, 0.5, **other)
        system = sp.System(sp.Spring(4.0, **MOUNT), *pots, sp.WhiteNoise(1.0))
        if seen:
            assert sp.theory.linear(system).mean_square("mount_force") > 0.0
        with pytest.raises(ValueError, match=r"springpot_1_force cannot be seen|mount_force cannot be seen"):
            sp.simulate(system, paths=64, forces=["springpot_1_force" if seen else "mount_force"])


@pytest.mark.validation
def test_rare_forces_of_a_group_and_studies_of_them(tmp_path: Path) -> None:
    rare = sp.exceedance(BOX, {"mount_force": [24.0]}, duration=10.0, rtol=0.2, seed=1)["mount_force"]
    ground = sp.exceedance(BOX, {"force_on_ground": [24.0]}, duration=10.0, rtol=0.2, seed=1)["force_on_ground"]
    assert 0.0 < rare.probability[0] < 0.2
    assert rare.probability[0] == pytest.approx(ground.probability[0], rel=1e-6)
    _written(tmp_path, BOX)
    (tmp_path / "study.toml").write_text(
        'name = "mounts"\nsystem = "box.toml"\nmethods = ["linear", "monte_carlo"]\n[axes]\n'
        '"parts.springpot.order" = [0.3, 0.5]\n[monte_carlo]\npaths = 512\nstep = 0.05\nforces = ["mount_force"]\n',
        encoding="utf-8",
    )
    tree = sp.study(tmp_path / "study.toml")
    assert "mount_force_mean_square" in tree["simulation"].to_dataset()
