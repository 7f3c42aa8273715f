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
