"""Several equal parts side by side, ``count=``: what all do together, and what each does."""

from __future__ import annotations

import numpy as np
import pytest

import springpot as sp

LOOSE = sp.Mass(2.5), sp.WhiteNoise(0.01, on="ground")
COUNTED = (
    (sp.Spring(800.0, count=4), sp.Spring(3200.0)),
    (sp.PolynomialSpring((0.0, 0.0, 2e6), count=3), sp.PolynomialSpring((0.0, 0.0, 6e6))),
    (sp.Springpot(0.3, 60.0, count=4), sp.Springpot(0.3, 240.0)),
    (sp.Dashpot(1.5, count=2), sp.Dashpot(3.0)),
    (sp.Friction(0.1, count=2), sp.Friction(0.2)),
    (sp.Maxwell(100.0, 4.0, count=2), sp.Maxwell(200.0, 8.0)),
    (sp.Inerter(0.5, count=4), sp.Inerter(2.0)),
    (sp.FractionalMaxwell(sp.Springpot(0.5, 20.0), sp.Spring(90.0), count=2),
     sp.FractionalMaxwell(sp.Springpot(0.5, 40.0), sp.Spring(180.0))),
    (sp.Contact(0.004, 1e5, 1.5, 0.2, "below", count=2), sp.Contact(0.004, 2e5, 1.5, 0.2, "below")),
    (sp.PiezoelectricCircuit(1e-3, 1e5, 1e-7, count=2), sp.PiezoelectricCircuit(2e-3, 5e4, 2e-7)),
    (sp.ResonantCircuit(1e-3, 1e3, 1e-7, 10.0, count=2), sp.ResonantCircuit(2e-3, 5e2, 2e-7, 5.0)),
)  # fmt: skip


@pytest.mark.parametrize(("counted", "one"), COUNTED, ids=[type(one).__name__ for _, one in COUNTED])
def test_equal_parts_act_as_one_with_their_sum(counted: sp.Spring, one: sp.Spring) -> None:
    """Numbers are those of one; what acts is the sum."""
    several = sp.System(*LOOSE, sp.Spring(10.0), part=counted)
    alone = sp.System(*LOOSE, sp.Spring(10.0), part=one)
    assert dict(several.named()) == dict(alone.named())
    assert several != alone
    assert several.per_unit_mass == alone.per_unit_mass
    assert several.potential == alone.potential
    assert several.inertia == alone.inertia
    if one.is_linear and one.inertia == 0.0:
        p = 3.0 + 40.0j
        modulus = counted.count * type(one).modulus(counted, p)
        assert complex(modulus) == pytest.approx(complex(one.modulus(p)), rel=1e-14)


def test_what_was_stated_is_kept() -> None:
    """In the parts, as a call, in a file, in numbers by name, and where one of them is changed."""
    device = sp.System(*LOOSE, mount=sp.Springpot(0.3, 60.0, count=4), spring=sp.Spring(800.0, count=4))
    assert device.parts[2] == sp.Springpot(0.3, 60.0, count=4)
    assert "mount=Springpot(order=0.3, coefficient=60.0, count=4)" in repr(device)
    assert sp.read_system(device.to_dict()) == device
    assert "count = 4" in sp.to_toml(device)
    assert device.counts == {"mount": 4, "spring": 4}


def test_between_masses_and_in_a_run() -> None:
    """Runs are the same to the last bit, and the force of one is its share of that of all."""
    ends = ("ground", "b")
    frame = sp.Mass(1.0, at="a"), sp.Mass(1.0, at="b"), sp.Spring(1.0, between=("ground", "a"))
    noise = sp.WhiteNoise(1.0, on="a")

    def run(*mounts: sp.Spring | sp.Dashpot, forces: list[str]) -> sp.Run:
        device = sp.System(*frame, sp.Dashpot(0.5, between=("a", "b")), noise, *mounts)
        return sp.simulate(device, paths=8, duration=20.0, step=0.1, seed=3, forces=forces)

    four = run(sp.Spring(0.25, between=ends, count=4), forces=["spring_2_force_of_one", "spring_2_force"])
    one = run(sp.Spring(1.0, between=ends), forces=["spring_2_force"])
    for name in ("a_x_mean_square", "b_v_mean_square", "spring_2_force_mean_square"):
        assert four[name].value == one[name].value
    ratio = four["spring_2_force_mean_square"].value / four["spring_2_force_of_one_mean_square"].value
    assert ratio == pytest.approx(16.0, rel=1e-6)


@pytest.mark.parametrize("base", [(sp.Mass(2.5),), (sp.Mass(1.0, at="a"), sp.Mass(1.0, at="b"))])
def test_results_are_of_all_together_or_of_one(base: tuple[sp.Mass, ...]) -> None:
    """Two equal coils with a count, and the same two one by one: currents add up, the voltage is that of each."""
    ends = ("a", "b") if len(base) > 1 else None
    coil = {"coupling": 0.5, "resistance": 2.0, "capacitance": 0.5, "inductance": 1.0, "between": ends}
    frame = [sp.Spring(1.0, between=("ground", mass.at) if ends else None) for mass in base]
    noise = sp.WhiteNoise(1.0, on=base[0].at or "mass")

    def run(**coils: sp.ResonantCircuit) -> sp.Run:
        device = sp.System(*base, *frame, noise, **coils)
        return sp.simulate(
            device, paths=8, duration=40.0, step=0.05, start="rest", forces=[f"{n}_force" for n in coils]
        )

    both = run(coil=sp.ResonantCircuit(**coil, count=2))
    each = sp.System(*base, *frame, noise, one=sp.ResonantCircuit(**coil), other=sp.ResonantCircuit(**coil))
    apart = sp.simulate(each, paths=8, duration=40.0, step=0.05, start="rest")
    one = {name: apart[f"one_{name}_mean_square"].value for name in ("voltage", "current")}
    assert one["current"] > 0.01
    assert both["coil_current_of_one_mean_square"].value == pytest.approx(one["current"], rel=1e-4)
    assert both["coil_current_mean_square"].value == pytest.approx(4.0 * one["current"], rel=1e-4)
    assert both["coil_voltage_mean_square"].value == pytest.approx(one["voltage"], rel=1e-4)
    for name in ("harvested_power", "damping_power"):
        assert both[name].value == pytest.approx(apart[name].value, rel=1e-4)
    force = both["coil_force_mean_square"].value / (2.0 * coil["coupling"]) ** 2  # of both by the voltage
    assert force == pytest.approx(one["voltage"], rel=0.05)
    assert "coil_current_of_one_mean_square" not in run(coil=sp.ResonantCircuit(**coil)).estimates


def test_theory_knows_the_force_of_one() -> None:
    """Of a part that is alone it is its force."""
    device = sp.System(*LOOSE, sp.Spring(3200.0), rubber=sp.Springpot(0.3, 60.0, count=4))
    exact = sp.theory.linear(device)
    one = exact.mean_square("rubber_force_of_one")
    assert exact.mean_square("rubber_force") == pytest.approx(16.0 * one, rel=1e-12)
    spectrum = exact.spectrum([30.0, 60.0], "rubber_force_of_one")
    np.testing.assert_allclose(16.0 * spectrum, exact.spectrum([30.0, 60.0], "rubber_force"), rtol=1e-12)


def test_a_fit_finds_the_numbers_of_one() -> None:
    """Measured are all four together."""
    f = np.geomspace(1.0, 100.0, 30)
    measured = 240.0 * (2j * np.pi * f) ** 0.3
    mounts = sp.System(sp.Springpot(sp.free("order", 0.5, (0.1, 0.9)), sp.free("C", 20.0, (1.0, 1e3)), count=4))
    found = sp.fit(mounts, sp.MeasuredModuli(f, measured.real, measured.imag, relative_error=0.01))
    assert found.values["order"] == pytest.approx(0.3, rel=1e-6)
    assert found.values["C"] == pytest.approx(60.0, rel=1e-6)


@pytest.mark.parametrize("count", [0, -1, 2.0, True, "4", 10**6])
def test_a_count_is_a_whole_number(count: object) -> None:
    """One sentence says which."""
    with pytest.raises(ValueError, match=r"^count must be a whole number from 1 to 1000, not .*\.$"):
        sp.Spring(80.0, count=count)  # type: ignore[arg-type]


def test_what_cannot_be_counted_says_so() -> None:
    """Equal rigid walls are one wall; noises may be the same or not."""
    with pytest.raises(ValueError, match="count must be left out of a Barrier"):
        sp.Barrier(-0.1, count=3)
    with pytest.raises(ValueError, match="count must be left out of a ParametricNoise"):
        sp.ParametricNoise(0.1, count=2)
    with pytest.raises(ValueError, match="spring must be without count in a series"):
        sp.FractionalMaxwell(sp.Springpot(0.5, 1.0), sp.Spring(2.0, count=2))
