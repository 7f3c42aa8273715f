"""What a printed run says."""

from __future__ import annotations

import springpot as sp


def test_a_printed_run_says_what_the_step_may_leave() -> None:
    lossy = sp.Oscillator(springpot=sp.Springpot(1.0, 0.5), barrier=sp.Barrier(0.0, 0.8))
    run = sp.simulate(lossy, paths=128, duration=20.0, window=(10.0, 20.0), step=0.02, start="rest", seed=2)
    lines = {line.split()[0]: line for line in str(run).splitlines()}
    bias = run["impact_rate"].step_bias
    assert bias is not None
    assert lines["impact_rate"].endswith(f"{run['impact_rate']}, step bias up to {bias:.2g}")
    assert lines["x_mean"].endswith(str(run["x_mean"]))


def test_a_printed_run_shows_profiles_and_first_passages_with_units() -> None:
    device = sp.System(sp.Mass(2.0), sp.Spring(50.0), sp.Dashpot(1.0), sp.WhiteNoise(1.0))
    asked = {"first_passage": {"x": [0.2, (-0.3, 0.35)]}, "profile": 2, "rainflow": {"x": sp.Basquin(4.0, 0.1)}}
    run = sp.simulate(device, paths=128, duration=10.0, step=0.02, start="rest", forces=["spring_force"], **asked)
    printed = str(run)
    assert f"x_mean_square_profile  {run.profiles['x_mean_square_profile']}".split() in map(
        str.split, printed.split("\n")
    )
    for words in (
        " m2 in 2 bins, 0 to 10 s",
        "first passage of x through 0.2 m: rate", "first passage of x out of -0.3 to 0.35 m: rate",
        f"{run['spring_force_mean_square']}", f"{run['x_damage_rate']}",
    ):  # fmt: skip
        assert words in printed
    assert str(run["spring_force_mean_square"]).endswith(" N2")
