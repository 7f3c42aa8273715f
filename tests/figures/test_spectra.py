"""Pictures of response spectra and fragility curves: what is drawn of few and of many records."""

from __future__ import annotations

import numpy as np
import pytest

import springpot as sp

T = 0.02 * np.arange(60)


def records(count: int) -> sp.RecordedExcitation:
    values = np.random.default_rng(1).normal(size=(count, T.size))
    return sp.RecordedExcitation(T, tuple(map(tuple, values)))


@pytest.mark.parametrize(
    ("count", "labels"),
    [
        (1, ["one"]),
        (3, ["each record", "one, median"]),  # whose intervals have no ends
        (44, ["each record", "84 % are below", "one, median", "16 % are below"]),
    ],
)
def test_intervals_are_drawn_where_they_have_ends(count: int, labels: list[str]) -> None:
    found = sp.response_spectrum(records(count), [0.4, 0.1, 0.2])
    ax = sp.figures.plot_response_spectrum(found, "acceleration", label="one")
    assert ax.get_legend_handles_labels()[1] == labels
    assert len(ax.collections) == (3 if count == 44 else 0)
    assert np.asarray(ax.lines[-1].get_xdata()).tolist() == sorted(np.asarray(ax.lines[-1].get_xdata()).tolist())


def test_theory_has_its_rms_and_frequencies_their_axis() -> None:
    found = sp.response_spectrum(sp.WhiteNoise(1e-3, on="ground"), [0.1, 0.2], duration=10.0)
    ax = sp.figures.plot_response_spectrum(found, frequency=True)
    assert ax.get_legend_handles_labels()[1][-1] == "rms"
    assert ax.get_xlabel() == "frequency (Hz)"
    with pytest.raises(ValueError, match="output must be one of displacement"):
        sp.figures.plot_response_spectrum(found, "velocity")


def test_a_cloud_has_its_records_at_0_and_1() -> None:
    system = sp.System(sp.Mass(1.0), sp.Spring(400.0), sp.Dashpot(2.0), records(20))
    limit = float(np.median(sp.response_spectrum(records(20), [0.314], damping=0.05)["displacement"].values))
    measure = np.random.default_rng(2).lognormal(0.0, 0.1, 20) * np.array(
        sp.response_spectrum(records(20), [0.314], damping=0.05)["displacement"].values[0]
    )  # fmt: skip
    ax = sp.figures.plot_fragility(sp.fragility(system, {"displacement": limit}, measure=measure))
    assert {*np.asarray(ax.lines[-1].get_ydata()).tolist()} == {0.0, 1.0}
    assert ax.get_legend_handles_labels()[1] == [f"displacement > {limit:g} m"]
