"""CSV files: units in the header, and one sentence with the line for whatever is wrong."""

from __future__ import annotations

import json
import time
import tracemalloc
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import springpot as sp
from springpot import cli
from springpot.files import text as text_of_files
from springpot.machine.faults import FileError

RUBBER = """[[parts]]
kind = "springpot"
order = { free = "order", start = 0.5, low = 0.01, high = 0.99 }
coefficient = { free = "C", start = 1e5, low = 1.0, high = 1e9 }
"""


def written(folder: Path, text: str) -> Path:
    place = folder / "data.csv"
    place.write_text(text, encoding="utf-8")
    return place


def test_every_kind_is_read_in_si_units(tmp_path: Path) -> None:
    moduli = sp.read_data(written(tmp_path, "# relative_error = 0.02\nfrequency_rad/s; storage (MPa); loss [kPa]\n"
                                            "6.283185307179586;1;20\n12;2;30\n\n20;3;40\n"))  # fmt: skip
    assert isinstance(moduli, sp.MeasuredModuli)
    assert (moduli.frequency_hz[0], moduli.storage[1], moduli.loss[2]) == (1.0, 2e6, 4e4)
    assert moduli.relative_error == 0.02
    spectrum = sp.read_data(written(tmp_path, "# averages: 64\n# sampling_rate_hz = 8\n# window = hann\n"
                                              "# segment = 16\nfrequency_hz\tdensity_g2/Hz\n"
                                              "0.5\t1\n1\t2\n1.5\t3\n"))  # fmt: skip
    assert isinstance(spectrum, sp.MeasuredSpectrum)
    assert (spectrum.of, spectrum.averages, spectrum.segment, spectrum.window) == ("a", 64.0, 16, "hann")
    assert spectrum.density[1] == pytest.approx(2.0 * 9.80665**2)
    force = sp.read_data(
        written(tmp_path, "# averages = 9\n# of = 'mount_force'\nfrequency_hz,density_kN2/Hz\n1,1\n2,2\n3,3\n")
    )
    assert isinstance(force, sp.MeasuredSpectrum)
    assert (force.of, force.density[0]) == ("mount_force", 1e6)
    rows = "\n".join(f"{10 * n},{np.sin(n)},{np.cos(n)}" for n in range(40))
    record = sp.read_data(written(tmp_path, "# made by hand\n# noise = 1e-5\ntime_ms,x_mm,x_um\n" + rows))
    assert isinstance(record, sp.MeasuredRecord)
    assert (record.of, record.paths, record.noise) == ("x", 2, 1e-5)
    assert record.step == pytest.approx(0.01)
    assert record.values[1, 1] == pytest.approx(1e-6 * np.cos(1.0))
    impacts = sp.read_data(written(tmp_path, "# error = 0.01\nbefore_m/s,after_mm/s\n1,700\n2,1400\n3,2100\n"))
    assert isinstance(impacts, sp.MeasuredImpacts)
    assert (round(float(impacts.after[1]), 9), impacts.error) == (1.4, 0.01)


def test_relaxation_and_creep_are_read(tmp_path: Path) -> None:
    relaxed = sp.read_data(
        written(tmp_path, "# relative_error = 0.02\ntime_min,Relaxation Modulus (MPa)\n1,3\n2,2\n3,1\n")
    )
    assert isinstance(relaxed, sp.MeasuredRelaxation)
    assert (relaxed.time.tolist(), relaxed.modulus[1], relaxed.relative_error) == ([60.0, 120.0, 180.0], 2e6, 0.02)
    with pytest.warns(UserWarning, match="its line at 0 s is left out"):
        crept = sp.read_data(written(tmp_path, "Time (sec);J(t) [1/MPa]\n0;0\n0,1;0,3\n1;0,5\n10;0,9\n"))
    assert isinstance(crept, sp.MeasuredCreep)
    assert (crept.time[0], crept.compliance.tolist()) == (0.1, pytest.approx([3e-7, 5e-7, 9e-7]))
    part = sp.read_data(written(tmp_path, "t_s,compliance_mm/N\n1,5\n2,6\n3,7\n"))
    assert isinstance(part, sp.MeasuredCreep)
    assert part.compliance[0] == 0.005
    for table, sentence in (
        (
            "time_s,modulus_MPa,x_mm\n1,5,2\n2,6,2\n3,7,1\n",
            "a record must have columns of one kind beside the time, such as x_m, not modulus_MPa and x_mm",
        ),
        ("time_s,modulus_Pa\n1,5\n2,4\n-3,3\n", "line 4: time_s must be greater than 0, not -3"),
        ("# averages = 3\ntime_s,modulus_Pa\n1,5\n2,4\n3,3\n", "averages is a setting of .*, not of relaxation"),
    ):
        with pytest.raises(FileError, match=sentence):
            sp.read_data(written(tmp_path, table))


TIMES = [f"{0.1 * n:.1f},{n % 7}" for n in range(40)]
BAD = [
    ("", "is empty: it needs a header"),
    ("# only a comment\n", "is empty: it needs a header"),
    ("1,2,3\n", "has no header: give columns=, a header for each of its 3 columns"),
    ("frequency,storage_Pa\n", "line 1: frequency must have its unit, as frequency_hz"),
    ("frequency_hz,storage\n", "line 1: storage must have its unit, as storage_Pa"),
    ("frequency_hz,storage_psi\n", "line 1: the unit of storage must be Pa, kPa, .* not 'psi'"),
    ("frequency_hz,storrage_Pa\n", "line 1: 'storrage_Pa' is not a column.*did you mean storage"),
    ("frequency_hz\n1\n2\n3\n", "is not right: it must have a column storage_Pa, loss_Pa, density_m2/Hz or mag"),
    ("storage_Pa,loss_Pa\n1,1\n", "is not right: it must have a column frequency_hz"),
    ("frequency_hz,storage_Pa,loss_N/m\n1,1,1\n2,2,2\n3,3,3\n", "storage and loss must both be moduli"),
    ("frequency_hz,storage_Pa,storage_Pa\n1,1,1\n2,2,2\n3,3,3\n", "storage must be one column, not 2"),
    ("frequency_hz,storage_Pa,x_m\n1,1,1\n2,2,2\n3,3,3\n", "x cannot be a column of moduli"),
    ("frequency_hz,storage_Pa\n1,1\n2,2\n", "frequency_hz must have at least 3 points, not 2"),
    ("frequency_hz,storage_Pa\n1,1\n2,-2\n3,3\n", "line 3: storage_Pa must be greater than 0, not -2"),
    ("# c\nfrequency_hz,storage_MPa\n\n1,1\n2,nan\n3,3\n", "line 5: storage_MPa must be a finite number, not nan"),
    ("frequency_hz,storage_Pa\n1,1\n2,inf\n3,3\n", "line 3: storage_Pa must be a finite number, not inf"),
    ("frequency_hz,storage_Pa\n1,1\n2,abc\n3,3\n", "line 3: storage_Pa must be a number, not 'abc'"),
    ("frequency_hz,storage_Pa\n1,1\n2,\n3,3\n", "line 3: storage_Pa has no number"),
    ("frequency_hz,storage_Pa\n1,1\n2,2,2\n3,3\n", "line 3: 2 numbers are needed, not 3"),
    ("frequency_hz,storage_Pa\n1,1\n2\n3,3\n", "line 3: 2 numbers are needed, not 1"),
    ("frequency_hz;storage_Pa\n1,0;1\n2.5;2\n3;3\n", "line 3: frequency_hz must be a number with a decimal comma"),

    ("frequency_hz,storage_Pa\n1,1\n3,2\n2,3\n", "line 4: frequency_hz must be above the frequency before it"),
    ("frequency_hz,storage_Pa\n0,1\n3,2\n4,3\n", "line 2: frequency_hz must be greater than 0, not 0"),
    ('frequency_hz,storage_Pa\n1,"1\n2",2\n', "must have one row in each line"),
    ("# relative_error = 2 %\nfrequency_hz,storage_Pa\n1,1\n2,2\n3,3\n", "relative_error must be a number, not '2 %'"),
    ("# relative_error = 2\nfrequency_hz,storage_Pa\n1,1\n2,2\n3,3\n", r"relative_error must be in \(0, 1\], not 2"),
    ("# averages = 2\nfrequency_hz,storage_Pa\n1,1\n2,2\n3,3\n", "averages is a setting of a spectrum.*, not of mod"),
    ("# average = 2\nfrequency_hz,density_m2/Hz\n1,1\n2,2\n3,3\n", "line 1: 'average' is not a setting; did you mean"),
    ("# averages = 2\n# averages = 3\nfrequency_hz,density_m2/Hz\n1,1\n", "line 2: averages must be given only once"),
    ("frequency_hz,density_m2/Hz\n1,1\n2,2\n3,3\n", "it must state the number of averages"),
    ("# averages = 9\nfrequency_hz,density_N2/Hz\n1,1\n2,2\n3,3\n", "must state of which in a line"),
    ("# averages = 9\n# of = mount_force\nfrequency_hz,density_m2/Hz\n1,1\n2,2\n3,3\n", "m2/Hz is no density of m"),
    ("# averages = 9\n# of = v\nfrequency_hz,density_N2/Hz\n1,1\n2,2\n3,3\n", "density_N2/Hz is no density of v"),
    ("# averages = 0.5\nfrequency_hz,density_m2/Hz\n1,1\n2,2\n3,3\n", "averages must be a finite number at least 1"),
    ("# averages = 2\n# sampling_rate_hz = 5\nfrequency_hz,density_m2/Hz\n1,1\n2,2\n3,3\n",
     "line 6: frequency_hz must be at most half of sampling_rate, 2.5 Hz, not 3"),
    ("# averages = 2\n# window = hann\nfrequency_hz,density_m2/Hz\n1,1\n2,2\n3,3\n",
     "window and segment must be given"),
    ("# averages = 2\n# sampling_rate_hz = 8\n# segment = 16\n# window = hann\nfrequency_hz,density_m2/Hz\n"
     "1,1\n2,2\n2.2,3\n",
     "line 8: frequency_hz must be a multiple of sampling_rate / segment, 0.5 Hz, not 2.2"),
    ("\n".join(["time_s,x_m", *TIMES[:20], *TIMES[22:]]), "line 22: time_s must follow at equal steps of 0.1 s, not "
     "after 0.3 s"),
    ("\n".join(["time_s,x_m", *TIMES[:20], *TIMES[19:]]), "line 22: time_s must be later than the time before"),
    ("\n".join(["time_s,x_m", *TIMES[:12]]), "time must have at least 32 samples, not 12"),
    ("\n".join(["time_s,x_m", *(f"{n},1" for n in range(40))]), "values must not all be equal"),
    ("\n".join(["time_s,x_m,v_m/s", "1,2,3"]), "must have columns of one kind beside the time, such as x_m"),
    ("\n".join(["time_s", "1", "2"]), "must have columns of one kind beside the time, such as x_m, not nothing"),
    ("before_m/s\n1\n2\n3\n", "it must have a column after_m/s"),
    ("before_m/s,after_m/s\n1,1\n2,0\n3,1\n", "line 3: after_m/s must be greater than 0, not 0"),
]  # fmt: skip


@pytest.mark.parametrize(("text", "sentence"), BAD)
def test_bad_data_are_one_sentence(tmp_path: Path, text: str, sentence: str) -> None:
    with pytest.raises(FileError, match=sentence) as caught:
        sp.read_data(written(tmp_path, text))
    assert str(caught.value).startswith("data file ")
    assert "\n" not in str(caught.value)


def test_what_is_no_file_of_data(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match="There is no file"):
        sp.read_data(tmp_path / "none.csv")
    with pytest.raises(FileError, match="it is a folder, not a file"):
        sp.read_data(tmp_path)
    (tmp_path / "raw.csv").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(FileError, match="is not text, nor a kind of file that is read here"):
        sp.read_data(tmp_path / "raw.csv")


def test_a_record_that_is_too_short_or_too_coarse_for_its_model() -> None:
    model = sp.System(sp.Spring(4.0), sp.Dashpot(sp.free("c", 0.5, (0.1, 1.0))), sp.WhiteNoise(1.0))
    values = np.random.default_rng(1).standard_normal(40)
    with pytest.raises(ValueError, match="data must last at least 5 periods of the model: its natural frequency is"):
        sp.fit(model, sp.MeasuredRecord(0.01 * np.arange(40), values))
    with pytest.raises(ValueError, match="data must have more than two samples in a period of the model"):
        sp.fit(model, sp.MeasuredRecord(4.0 * np.arange(40), values))


def test_the_command_fits_and_writes(tmp_path: Path, capsys: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    f = np.geomspace(0.1, 100.0, 12)
    modulus = 2e5 * (2j * np.pi * f) ** 0.3 * (1.0 + 0.01 * np.random.default_rng(1).standard_normal(12))
    rows = "\n".join(f"{a},{b.real / 1e3},{b.imag / 1e3}" for a, b in zip(f, modulus, strict=True))
    written(tmp_path, "frequency_hz,storage_kPa,loss_kPa\n" + rows)
    (tmp_path / "rubber.toml").write_text(RUBBER, encoding="utf-8")
    words = ["fit", "data.csv", "--model", "rubber.toml"]
    assert cli.main([*words, "--out", "found.toml", "--plot", "found.png"]) == 0
    said = capsys.readouterr()
    assert "fit of 2 numbers to 24 moduli" in said.out
    assert (tmp_path / "found.png").stat().st_size > 10_000
    assert sp.read_system("found.toml").of(sp.Springpot)[0].order == pytest.approx(0.3, abs=0.02)
    assert cli.main([*words, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["values"]["C"] == pytest.approx(2e5, rel=0.05)
    assert cli.main([*words, "--out", "found.toml"]) == 2
    assert "exists already" in capsys.readouterr().err
    assert cli.main(["fit", "none.csv", "--model", "rubber.toml"]) == 2
    assert "There is no file" in capsys.readouterr().err
    assert cli.main(["fit", "data.csv"]) == 2


def record_of(columns: int, rows: int) -> str:
    """A record of so many paths."""
    values = np.random.default_rng(1).integers(0, 1000, (rows, columns))
    lines = [f"{0.1 * n:.1f}," + ",".join(map(str, row)) for n, row in enumerate(values.tolist())]
    return "\n".join(["time_s" + ",x_m" * columns, *lines])


STATISTICS = "quantity,value,error\n" + "".join(f"w{n}_impact_rate (1/s),1,1\n" for n in range(1001))


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        (record_of(20_000, 2), r"^data file '.*' must have at most 1,000 columns, not 20,001\.$"),
        ("time_s,x_m\n" + "0," + "1" * 100_000, r", line 2: a line must have at most 100,000 characters\.$"),
        (STATISTICS, r"is not right: MeasuredStatistics must have at most 1,000 statistics\.$"),
        ("quantity,value,error\nx_rms (" + " " * 50_000 + "x,1,1\n", "line 2: .* must be a quantity with its unit"),
        ("# averages =" + " x" * 40_000 + "\nfrequency_hz,density_m2/Hz\n1,1\n2,1\n3,1\n", "averages must be a number"),
        ("x" + " " * 90_000 + "(m,x_m\n1,1\n", "the unit of x must be m, mm"),
    ],
)
def test_what_is_large_is_refused_soon(tmp_path: Path, text: str, sentence: str) -> None:
    """Each of these took seconds to hours, for its time grew with the square or the cube of its length."""
    place = written(tmp_path, text)
    start = time.perf_counter()
    with pytest.raises(FileError, match=sentence):
        sp.read_data(place)
    assert time.perf_counter() - start < 2.0


def test_a_large_file_is_not_read_at_all(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    place = written(tmp_path, record_of(2, 40))
    monkeypatch.setattr(text_of_files, "MOST_NUMBERS", 60)
    with pytest.raises(FileError, match=r"must have at most 60 numbers: line 22 has more\.$"):
        sp.read_data(place)
    with place.open("ab") as file:
        file.truncate(200_000_001)
    with pytest.raises(FileError, match=r"cannot be read: it has more than 200,000,000 bytes\.$"):
        sp.read_data(place)


def test_memory_is_that_of_the_numbers(tmp_path: Path) -> None:
    """It was 32 times the file."""
    place = written(tmp_path, record_of(20, 3000))
    sp.read_data(place)  # what is imported is not counted
    tracemalloc.start()
    try:
        record = sp.read_data(place)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert isinstance(record, sp.MeasuredRecord)
    assert peak < 8.0 * place.stat().st_size + 1e6
    assert peak < 6.0 * record.values.nbytes


WAVE = np.sin(0.3 * np.arange(40)), np.cos(0.5 * np.arange(40)), np.sin(0.7 * np.arange(40))


def with_input(folder: Path, header: str, *settings: str) -> Any:
    rows = (
        ",".join(f"{own[n]:.6g}" for own in (0.1 * np.arange(40), *WAVE)[: header.count(",") + 1]) for n in range(40)
    )
    return sp.read_data(written(folder, "\n".join([*(f"# {own}" for own in settings), header, *rows])))


def test_a_record_is_read_with_its_input(tmp_path: Path) -> None:
    settings = "on = box", "at = lid", "start = rest", "skip = 1", "delay = found"
    force = with_input(tmp_path, "time_s,input_kN,x_mm", *settings)
    assert (force.of, force.at, force.on) == ("x", "lid", "box")
    assert (force.start, force.skip, force.delay) == ("rest", 1.0, None)
    assert force.input[0] == pytest.approx(1e3 * WAVE[0], abs=1e-2)
    assert force.values[0] == pytest.approx(1e-3 * WAVE[1], abs=1e-8)
    ground = with_input(tmp_path, "time_s,Ground acceleration (g),acceleration_g", "interpolation = band-limited")
    assert (ground.of, ground.on, ground.delay, ground.interpolation) == ("a", "ground", 0.0, "band-limited")
    assert ground.input[0] == pytest.approx(9.80665 * WAVE[0], abs=1e-4)
    assert with_input(tmp_path, "time_s,acceleration_g,v_m/s", "on = ground").of == "v"
    assert with_input(tmp_path, "time_s,input_m/s2,x_m").on == "ground"
    assert with_input(tmp_path, "time_s,input_m/s2,x_m", "on = mass").on == "mass"
    both = with_input(tmp_path, "time_s,force_N,x_m,a_g")
    assert (both.of, both.at, both.values.shape) == (("x", "a"), (None, None), (2, 40))
    assert with_input(tmp_path, "time_s,force_N,x_m,x_m", "at = box, lid").at == ("box", "lid")
    rated = sp.read_data(written(tmp_path, "force_N,x_m\n" + "\n".join(f"{n % 7},{n % 5}" for n in range(40))), rate=50)
    assert isinstance(rated, sp.MeasuredRecord)
    assert rated.has_input
    assert rated.step == pytest.approx(0.02)
    begun = with_input(tmp_path, "time_s,x_m", "Start: 12:30", "start: by hand")  # words of a logger
    assert not begun.has_input


@pytest.mark.parametrize(
    ("header", "settings", "sentence"),
    [
        ("time_s,acceleration_g,x_m", (), "it has acceleration_g and x_m, and one may be the input: call"),
        ("time_s,force_N,input_N,x_m", (), "it must have one input, not force_N and input_N: columns= takes those"),
        ("time_s,force_N", (), "it must have a column of the response, such as x_m, beside its input, force_N"),
        ("time_s,force_N,x_m", ("on = ground",), "on must not be 'ground': force_N acts on a mass"),
        ("time_s,base_acc_g,x_m", ("on = box",), "on must not be 'box': base_acc_g acts on the ground"),
        ("time_s,force_N,x_m,x2_m", (), "at must name the mass of each column, x_m and x2_m, in a line such"),
        ("time_s,force_N,x_m", ("at = box, lid",), "at must name the mass of each column, x_m, in a line"),
        ("time_s,force_N,x_m", ("delay = some",), "delay must be a number, not 'some'"),
        ("time_s,force_N,x_m", ("start = still",), "start must be 'free' or 'rest', not 'still'"),
        ("time_s,x_m", ("start = rest",), "start must be left out of a record without an input"),
        ("time_s,force_N,x_m", ("skip = 9",), r"skip must be in \[0, 1.95\], not 9"),
    ],
)  # fmt: skip
def test_a_record_whose_input_is_not_clear_asks(
    tmp_path: Path, header: str, settings: tuple[str, ...], sentence: str
) -> None:
    with pytest.raises(FileError, match=sentence) as caught:
        with_input(tmp_path, header, *settings)
    assert "\n" not in str(caught.value)


def test_a_hole_in_the_input_is_in_its_line_and_column(tmp_path: Path) -> None:
    lines = [f"{n},{'nan' if n == 3 else n % 7},{n % 5}" for n in range(40)]
    with pytest.raises(FileError, match="line 5: ground_acceleration_g must be a finite number, not nan"):
        sp.read_data(written(tmp_path, "\n".join(["time_s,ground_acceleration_g,a_g", *lines])))


DEVICE = """[[parts]]
kind = "mass"
value = 2.0

[[parts]]
kind = "dashpot"
coefficient = 2.0

[[parts]]
kind = "spring"
stiffness = { free = "k", start = 60, low = 10, high = 300 }
"""


def test_the_command_fits_a_record_with_its_input(tmp_path: Path, capsys: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    time, rng = 0.02 * np.arange(400), np.random.default_rng(1)
    force = np.convolve(rng.standard_normal(406), np.hanning(9)[1:-1], "valid")
    drive = sp.RecordedExcitation(tuple(time), tuple(force), "mass")
    run = sp.simulate(sp.System(sp.Mass(2.0), sp.Spring(80.0), sp.Dashpot(2.0), drive), paths=1, record=1, start="rest",
                      step=2e-3, record_every=10, duration=time[-1], seed=1)  # fmt: skip
    rows = "\n".join(f"{t:.2f},{f:.6g},{1e3 * x:.7g}" for t, f, x in zip(time, force, run.record[0, :, 0], strict=True))
    written(tmp_path, "# start = rest\n# interpolation = linear\ntime_s,force_N,x_mm\n" + rows)
    (tmp_path / "device.toml").write_text(DEVICE, encoding="utf-8")
    assert cli.main(["fit", "data.csv", "--model", "device.toml", "--plot", "fit.png", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["values"]["k"] == pytest.approx(80.0, rel=0.01)
    assert (tmp_path / "fit.png").stat().st_size > 10_000
