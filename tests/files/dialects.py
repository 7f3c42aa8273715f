"""Small files of each kind that is read, what the caller says of each, and the first numbers that are right."""

from __future__ import annotations

import io
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from scipy.io import savemat

G = 9.80665
Kind = Literal["record", "density", "data"]
"""What reads it: RecordedExcitation.from_file, SpectralExcitation.from_file or read_data."""


@dataclass(frozen=True)
class Dialect:
    """A file and what it holds."""

    name: str
    kind: Kind
    content: bytes
    right: tuple[tuple[float, ...], tuple[float, ...]]  # times or frequencies, and values, in SI units: the first ones
    given: dict[str, Any] = field(default_factory=dict)
    assumed: str = ""  # a part of what is said
    needs: str = ""


def peer(head: str, values: list[float], form: Callable[[float], str], columns: int, between: str = "") -> bytes:
    """A record in the layout of PEER."""
    rows = ["".join(form(value) for value in values[at : at + columns]) for at in range(0, len(values), columns)]
    return "\n".join([head + between, *rows, ""]).encode()


RECORD = [0.00068, 0.02767, -0.04387, 0.0205, 0.00839, -0.00467, 0.00812, 0.00456, 0.01813, -0.02425, 0.01435]
WORDS = "SOME AGENCY STRONG MOTION RECORD\nPLACE 01/01/00 0000, STATION X, 090\n"
OF_G = f"{WORDS}ACCELERATION TIME HISTORY IN UNITS OF G\n"
IN_SI = tuple(G * value for value in RECORD[:3])


def wide(value: float) -> str:
    return f"{value:15.7E}"


def touching(value: float) -> str:
    """In the columns of Fortran's F10.7: those of negative numbers touch."""
    return f"{value:10.7f}" if value < 0.0 else f" {value:9.7f}"


def narrow(value: float) -> str:
    """Without a 0 before the point, in eight columns of ten that touch."""
    text = f"{value:.8f}".replace("0.", ".", 1)
    return f"{text:>10}"


AT2 = [
    Dialect("PEER's .AT2, NPTS=, DT=", "record", peer(f"{OF_G}NPTS=    11, DT= .02000 SEC", RECORD, wide, 5),
            ((0.0, 0.02, 0.04), IN_SI)),
    Dialect("PEER's .AT2, numbers before NPTS, DT", "record", peer(f"{OF_G}   11   0.0200  NPTS, DT", RECORD, wide, 5),
            ((0.0, 0.02, 0.04), IN_SI)),
    Dialect("PEER's .AT2, DTSEC without a blank, eight columns that touch", "record",
            peer(f"{OF_G}NPTS=11, DT=.01SEC", RECORD, narrow, 8), ((0.0, 0.01, 0.02), IN_SI)),
    Dialect("PEER's .AT2, more words, and a mark before the data", "record",
            peer(f"a report\n\n{OF_G}DT = 0.005, NPTS = 11", RECORD, touching, 5, "\nfiltered\n*** Begin data ***"),
            ((0.0, 0.005, 0.01), IN_SI)),
    Dialect("PEER's .VT2, a velocity", "data",
            peer(f"{WORDS}VELOCITY TIME SERIES IN UNITS OF CM/S\nNPTS=  33, DT=   .0100 SEC", 3 * RECORD, wide, 5),
            ((0.0, 0.01, 0.02), tuple(0.01 * value for value in RECORD[:3]))),
    Dialect("PEER's .AT2 without a unit", "record", peer(f"{WORDS}NPTS, DT: 11 0.02", RECORD, wide, 5),
            ((0.0, 0.02, 0.04), IN_SI), {"unit": "g"}),
]  # fmt: skip


def smc() -> bytes:
    """A record in the SMC format."""
    whole, real = [-32768] * 48, [1.7e38] * 50
    whole[15], whole[16], real[1] = 2, len(RECORD), 200.0
    lines = ["2 CORRECTED ACCELEROGRAM", *(f"line {n} of words" for n in range(2, 12))]
    lines += ["".join(f"{number:10d}" for number in whole[at : at + 8]) for at in range(0, 48, 8)]
    lines += ["".join(f"{number:15.7E}" for number in real[at : at + 5]) for at in range(0, 50, 5)]
    lines += ["| a comment", "| another"]
    values = [f"{100.0 * value:10.4E}".replace("E+0", "E+").replace("E-0", "E-").rjust(10) for value in RECORD]
    lines += ["".join(values[at : at + 8]) for at in range(0, len(values), 8)]
    return "\n".join([*lines, ""]).encode()


def cosmos(channels: int = 1) -> bytes:
    """A record in the COSMOS format."""
    real = [-999.0] * 100
    real[33], real[61] = 5.0, 10.0
    lines = [
        "Corrected acceleration    (Format v01.20 with 13 text lines) Converted",
        *(f"line {n}" for n in range(2, 14)),
    ]
    lines += [" 100 Integer-header values follow on  10 lines, Format= (10I8)"]
    lines += ["".join(f"{-999:8d}" for _ in range(10))] * 10
    lines += [" 100 Real-header values follow on  17 lines, Format= (6F13.6)"]
    lines += ["".join(f"{number:13.6f}" for number in real[at : at + 6]) for at in range(0, 100, 6)]
    lines += ['   1 Comment line(s) follow, each starting with a "|":', "| a comment"]
    lines += ["      11 acceleration pts, approx    0 secs, units=cm/sec2(04),Format=(8F10.5)"]
    lines += ["".join(f"{100.0 * value:10.5f}" for value in RECORD[at : at + 8]) for at in range(0, len(RECORD), 8)]
    return "\n".join([*lines, "End-of-data for Chan  1 acceleration", ""] * channels).encode()


def universal(
    numbers: np.ndarray[Any, Any], step: float, kind: int, units: tuple[str, str] = ("m/s2", "NONE"), of: int = 12,
    on: int = 0, reference: int = 0, begin: float = 0.0, binary: bool = False,
) -> bytes:  # fmt: skip
    """A dataset 58 as text, or with binary numbers in double precision."""
    complex_, time = np.iscomplexobj(numbers), kind == 1
    flat = np.column_stack([numbers.real, numbers.imag]).ravel() if complex_ else numbers
    axes = [(17 if time else 18, "s" if time else "Hz"), (of, units[0]), (on, units[1]), (0, "NONE")]
    direction = 3 if reference else 0
    lines = ["    -1", "    58", *(f"line {n}" for n in range(1, 6))]
    lines.append(f"{kind:5d}{1:10d}{0:5d}{0:10d} {'NONE':<10}{3:10d}{3:4d} {'NONE':<10}{reference:10d}{direction:4d}")
    double = 4 if binary else 2
    if binary:
        lines[1] = f"    58b{1:6d}{2:6d}{11:12d}{flat.nbytes:12d}{0:6d}{0:6d}{0:12d}{0:12d}"
    lines.append(f"{5 if complex_ else double:10d}{len(numbers):10d}{1:10d}{begin:13.5E}{step:13.5E}{0.0:13.5E}")
    lines += [f"{spec:10d}{0:5d}{0:5d}{0:5d} {'NONE':<20} {unit:<20}" for spec, unit in axes]
    if binary:
        return "\n".join([*lines, ""]).encode() + flat.astype("<f8").tobytes() + b"\n    -1\n"
    lines += ["".join(f"{number:13.5E}" for number in flat[at : at + 6]) for at in range(0, len(flat), 6)]
    return "\n".join([*lines, "    -1", ""]).encode()


def matlab(compressed: bool = False, **variables: Any) -> bytes:
    content = io.BytesIO()
    savemat(content, variables, do_compression=compressed)
    return content.getvalue()


def rows(form: str, comma: bool = False, size: float = 1.0) -> bytes:
    """Rows of times and values, such as 0.01 and -1.5, in a form."""
    lines = [form.format(0.01 * n, size * value) for n, value in enumerate(VALUES)]
    return "".join(line.replace(".", ",") if comma else line for line in lines).encode()


VALUES = [0.5, -1.5, 1.25, -0.75, 0.35, 0.85, -0.45, 1.05, -1.15, 0.65, -0.25, 0.95]
WAVE = np.sin(0.3 * np.arange(40.0))
LINES = np.arange(0.0, 41.0, 4.0)
RESPONSE = 1.0 / (400.0 - LINES[1:] ** 2 + 8j * LINES[1:])
RECORDED = (0.0, 0.01), (0.5 * G, -1.5 * G)
ROWS = "\n".join(f"{0.01 * n:.2f}{{0}}{np.sin(0.3 * n):.4f}" for n in range(40))
MOVED = (0.0, 0.01), (0.0, 0.2955e-3)
LEVELS = (10.0, 40.0), (0.02 * G**2, 0.04 * G**2)
RUBBER = (0.1, 1.0, 10.0), (1e6, 1.5e6, 2.3e6)

OTHERS = [
    Dialect("SMC format of the USGS", "record", smc(), ((0.0, 0.005), tuple(value for value in RECORD[:2]))),
    Dialect("COSMOS format, version 1.20", "record", cosmos(), ((0.0, 0.01), tuple(value for value in RECORD[:2]))),
    Dialect("universal file, a time history", "record", universal(WAVE, 0.01, 1),
            ((0.0, 0.01), (0.0, 0.29552)), needs="pyuff"),
    Dialect("universal file, a time history in binary", "record", universal(WAVE, 0.01, 1, binary=True),
            ((0.0, 0.01), (0.0, 0.29552)), needs="pyuff"),
    Dialect("universal file, a frequency response", "data",
            universal(RESPONSE, 4.0, 4, ("m", "N"), 8, 13, 1, 4.0), ((4.0, 8.0), (2.59517e-3, 2.92363e-3)),
            needs="pyuff"),
    Dialect("universal file, a spectral density", "density",
            universal(0.02 + 0.0 * LINES[1:], 4.0, 9, ("g^2/Hz", "NONE"), begin=4.0), ((4.0, 8.0), (0.02 * G**2,) * 2),
            needs="pyuff"),
    Dialect("MATLAB file with fs", "record", matlab(acc=np.array([[0.5, -1.5, 1.0]]), fs=100.0), RECORDED,
            {"unit": "g"}),
    Dialect("MATLAB file, vectors by name", "data", matlab(True, T=0.01 * np.arange(40), u=WAVE, note="x"),
            ((0.0, 0.01), (0.0, 0.29552e-3)), {"columns": {"T": "time_s", "u": "x_mm"}}),
]  # fmt: skip
TEXT = [
    Dialect("springpot's own", "record", b"time_s,acceleration_g\n" + rows("{:.2f},{:g}\n"), RECORDED),
    Dialect("semicolons and decimal commas", "record", b"time_s;acceleration_g\n" + rows("{:.2f};{:g}\n", True),
            RECORDED, assumed="its commas are decimal marks"),
    Dialect("commas between quoted numbers with decimal commas", "record",
            b'"time_s","acceleration_g"\n' + rows('"{:.2f}"|"{:g}"\n', True).replace(b"|", b","), RECORDED,
            assumed="its commas are decimal marks"),
    Dialect("decimal commas that could separate thousands", "data",
            ("time_s;x_mm\n" + "\n".join(f"{1 + 0.001 * n:.3f};{n % 7}" for n in range(40)).replace(".", ",")).encode(),
            ((1.0, 1.001), (0.0, 1e-3)), {"decimal": ","}),
    Dialect("names and units in use, trailing commas, words before", "record",
            b"Test 12,\nTime (sec),Acc (G),\n" + rows("{:.2f},{:g},\n"), RECORDED, assumed="line 1 is passed over"),
    Dialect("a line of units, Latin-1, line ends of Windows", "record",
            "Time;Acc\r\ns;m/s²\r\n".encode("latin-1") + rows("{:.2f};{:.6f}\r\n", True, G), RECORDED,
            assumed="is read as Latin-1"),
    Dialect("UTF-16 with tabs, as spreadsheets write Unicode text", "record",
            ("Time [s]\tAcceleration [m/s²]\n" + rows("{:.2f}\t{:.6f}\n", size=G).decode()).encode("utf-16"), RECORDED),
    Dialect("UTF-8 with a byte order mark, and the line that names the separator", "record",
            "sep=;\nt (s);acc (g)\n".encode("utf-8-sig") + rows("{:.2f};{:g}\n"), RECORDED),
    Dialect("MATLAB's comments, the last of them a header, blanks between", "record",
            b"% made with fprintf\n% Time (s)  Acc (g)\n" + rows("{:6.2f}{:7.3g}\n"), RECORDED,
            assumed="its header is the comment in line 2"),
    Dialect("C's comments, line ends of old Macs", "record",
            b"// a test\rtime_s,acceleration_g\r" + rows("{:.2f},{:g}\r"), RECORDED),
    Dialect("two columns without a header", "record", rows("{:.2f} {:g}\n"), RECORDED,
            {"columns": ["time_s", "acceleration_g"]}),
    Dialect("one column without a header", "record", b"".join(b"%g\n" % value for value in VALUES), RECORDED,
            {"rate": 100.0, "unit": "g"}),
    Dialect("one of three axes", "record", b"Time (s),X (g),Y (g),Z (g)\n" + rows("{0:.2f},3,4,{1:g}\n"), RECORDED,
            {"columns": ["time_s", "", "", "acceleration_g"]}, "line 1 is passed over"),
    Dialect("columns with words, which are left out", "record",
            b"Time (s);Acc (g);Status\n" + rows("{:.2f};{:g};OK\n"), RECORDED,
            {"columns": {"Time (s)": "time_s", "Acc (g)": "acceleration_g"}}),
    Dialect("Fortran's exponents, blanks, no unit in the header", "record",
            b"Time(s)    Acc\n" + rows("{:10.2E}{:10.2E}\n").replace(b"E", b"D"), RECORDED, {"unit": "g"}),
    Dialect("a displacement in mm", "data", f"Time (s);Displacement (mm)\n{ROWS.format(';')}\n".encode(), MOVED),
    Dialect("inches per second squared", "record",
            b"Time (sec)\tAcc (in/s^2)\n" + rows("{:.2f}\t{:.5f}\n", size=G / 0.0254), RECORDED),
    Dialect("a controller's break points", "density", b"Freq (Hz);ASD (G^2/Hz)\n10;0,02\n40;0,04\n", LEVELS,
            assumed="its commas are decimal marks"),
    Dialect("a density per rad/s", "density",
            b"frequency (rad/s),PSD [(m/s^2)^2/(rad/s)]\n62.83185307,0.30611984\n251.3274123,0.61223968\n", LEVELS),
    Dialect("a controller's lines from 0 Hz", "density",
            b"frequency_Hz,psd_g2/Hz\n" + b"".join(b"%d,%g\n" % (n, 0.02 * (n >= 10)) for n in range(0, 2001, 5)),
            ((10.0, 2000.0), (0.02 * G**2,) * 2), assumed="its 399 points are thinned to 2"),
    Dialect("moduli of a rheometer", "data", b"Freq (Hz);G' (MPa);G'' (MPa)\n0,1;1;0,2\n1;1,5;0,4\n10;2,3;0,7\n",
            RUBBER, assumed="its commas are decimal marks"),
    Dialect("moduli by tan delta", "data", b"Freq [Hz],E' [MPa],tan delta\n0.1,1,0.2\n1,1.5,0.3\n10,2.3,0.3\n", RUBBER),
    Dialect("a response from 0 Hz", "data", b"frequency_hz,real_m/N,imaginary_m/N\n0,1,0\n1,2,0\n2,3,-1\n4,1,-2\n",
            ((1.0, 2.0), (2.0, 3.1622777)), assumed="its line at 0 Hz is left out"),
    Dialect("statistics with decimal commas", "data", b"quantity;value;error\nx_rms (mm);2,41;0,03\n",
            ((), (2.41e-3,)), assumed="its commas are decimal marks"),
]  # fmt: skip
DIALECTS = [*AT2, *OTHERS, *TEXT]
