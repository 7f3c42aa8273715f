"""The repr of parts, systems and data is one line, however long their tables are."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import springpot as sp
from springpot.explorer.copies import python_of
from springpot.explorer.protocol import Problem

TIME = 0.01 * np.arange(3000)
RECORD = sp.RecordedExcitation(TIME, np.sin(TIME))
ENVELOPE = sp.TabulatedEnvelope(TIME, np.exp(-TIME))
LONG: list[Any] = [
    RECORD,
    sp.System(sp.Spring(1.0), sp.Dashpot(0.1), shake=RECORD),
    sp.RecordedExcitation(TIME, (np.sin(TIME), np.cos(TIME))),
    sp.SpectralExcitation(1.0 + np.arange(900), np.ones(900)),
    sp.WhiteNoise(1.0, envelope=ENVELOPE),
    sp.MeasuredRecord(TIME, np.sin(TIME)),
    sp.MeasuredSpectrum(1.0 + np.arange(900), np.ones(900), averages=9),
    sp.MeasuredFrequencyResponse(1.0 + np.arange(900), np.ones(900) - 0.1j),
    sp.MeasuredModuli(1.0 + np.arange(900), np.ones(900)),
    sp.MeasuredImpacts(np.ones(900), np.ones(900)),
    sp.MeasuredStatistics(correlation=np.eye(30), x_quantile={
        0.01 * n: (0.1 * n, 0.1) for n in range(1, 31)
    }),
]  # fmt: skip


@pytest.mark.parametrize("one", LONG, ids=lambda one: type(one).__name__)
def test_a_long_table_is_not_written_out(one: Any) -> None:
    text = repr(one)
    assert "\n" not in text
    assert len(text) < 300
    assert "numbers from" in text or "complex numbers" in text


def test_a_short_table_is_written_out_and_can_be_read_again() -> None:
    record = sp.RecordedExcitation((0.0, 0.01, 0.02), (0.0, 0.5, 0.0))
    assert eval(repr(record), {"RecordedExcitation": sp.RecordedExcitation}) == record
    assert "frequency_hz=[0.1, 1.0, 10.0]" in repr(sp.MeasuredModuli([0.1, 1.0, 10.0], storage=[1.0, 2.0, 4.0]))


def test_the_text_of_a_long_envelope_is_read_from_its_file() -> None:
    """The page writes a system as Python only where that is the whole of it."""
    spring, noise = sp.Spring(1.0), sp.WhiteNoise(1.0, envelope=ENVELOPE)
    assert "read_system" in python_of(sp.System(spring, noise), "device.toml", Problem())
    short = sp.WhiteNoise(1.0, envelope=sp.TabulatedEnvelope((0.0, 1.0), (0.0, 1.0)))
    assert "read_system" not in python_of(sp.System(spring, short), "device.toml", Problem())
