"""Files through the other doors: the command, a system's file, and the stated arguments there."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import springpot as sp
from springpot import cli
from tests.files.dialects import OF_G, RECORD, peer, wide

RUBBER = """[[parts]]
kind = "springpot"
order = { free = "order", start = 0.5, low = 0.01, high = 0.99 }
coefficient = { free = "C", start = 1e5, low = 1.0, high = 1e9 }
"""


def test_the_command_says_what_was_assumed(tmp_path: Path, capsys: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    f = np.geomspace(0.1, 100.0, 12)
    modulus = 2e5 * (2j * np.pi * f) ** 0.3 * (1.0 + 0.01 * np.random.default_rng(1).standard_normal(12))
    rows = "\n".join(f"{a:.6g};{b.real:.1f};{b.imag:.1f}" for a, b in zip(f, modulus, strict=True)).replace(".", ",")
    (tmp_path / "rubber.toml").write_text(RUBBER, encoding="utf-8")
    (tmp_path / "named.csv").write_text(f"Freq (Hz);E' (Pa);E'' (Pa)\n{rows}\n", encoding="utf-8")
    (tmp_path / "bare.csv").write_text(f"{rows}\n", encoding="utf-8")
    model = ["--model", "rubber.toml"]
    assert cli.main(["fit", "named.csv", *model]) == 0
    said = capsys.readouterr()
    assert "springpot: warning: data file 'named.csv': its commas are decimal marks." in said.err
    assert "fit of 2 numbers to 24 moduli" in said.out
    assert cli.main(["fit", "bare.csv", *model]) == 2
    assert "data file 'bare.csv' has no header: give columns=" in capsys.readouterr().err
    stated = ["--columns", "frequency_hz,storage_Pa,loss_Pa", "--decimal", ","]
    assert cli.main(["fit", "bare.csv", *model, *stated]) == 0
    assert "warning: data file" not in capsys.readouterr().err


def test_a_systems_file_states_what_its_records_do_not_say(tmp_path: Path) -> None:
    (tmp_path / "bare.txt").write_text("0.00 0.5\n0.01 -1.5\n", encoding="utf-8")
    (tmp_path / "record.at2").write_bytes(peer(f"{OF_G}NPTS= 11, DT= .02", RECORD, wide, 5))
    (tmp_path / "lines.csv").write_text(
        "f (Hz);PSD\n" + "".join(f"{n};0,02\n" for n in range(10, 500)), encoding="utf-8"
    )
    (tmp_path / "device.toml").write_text(
        '[[parts]]\nkind = "spring"\nstiffness = 4.0\n'
        '[[parts]]\nkind = "recorded_excitation"\npath = "record.at2"\n'
        '[[parts]]\nkind = "recorded_excitation"\npath = "bare.txt"\ncolumns = ["time_s", "acceleration_g"]\n'
        '[[parts]]\nkind = "spectral_excitation"\npath = "lines.csv"\nunit = "g2/Hz"\ndecimal = ","\ntolerance = 0.1\n',
        encoding="utf-8",
    )
    system = sp.read_system(tmp_path / "device.toml")
    peers, bare = system.of(sp.RecordedExcitation)
    assert (len(peers.time), bare.values) == (11, (0.5 * 9.80665, -1.5 * 9.80665))
    (noise,) = system.of(sp.SpectralExcitation)
    assert noise.frequency == pytest.approx((10.0, 499.0))
    assert noise.psd == pytest.approx((0.02 * 9.80665**2,) * 2)
