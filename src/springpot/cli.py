"""The ``springpot`` command: parses, calls the library, prints.  No physics here.

Everything heavy (Numba, SciPy, xarray, matplotlib) is imported inside the commands, so that ``springpot --help`` is
quick.

Exit codes: 0 done, 1 failed while running, 2 bad usage or bad input, 130 interrupted; other than 0, one sentence on
stderr says why and stdout stays empty.
"""

from __future__ import annotations

import json
import math
import os
import sys
import time
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, fields
from inspect import signature
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import App, CycloptsError, Group, Parameter, Token

from springpot.oscillator import Barrier, Oscillator, Springpot, WhiteNoise

if TYPE_CHECKING:
    from rich.progress import Progress

__all__ = ["main"]

_QUIET_SECONDS = 2.0
_DEFAULT = Oscillator()
_WALL = Barrier()
_OSCILLATOR = Group("Oscillator", sort_key=0)
_MONTE_CARLO = Group("Monte Carlo", sort_key=1)


def _version() -> str:
    from springpot import __version__

    return __version__


app = App(
    name="springpot",
    help="Random vibration of oscillators with a fractional derivative that strike a wall.",
    help_format="plaintext",
    version=_version,
    suppress_keyboard_interrupt=False,  # main() turns it into one sentence and 130
)


def _whole(type_: object, tokens: Sequence[Token]) -> int:
    """Cyclopts' own conversion rounds 2.5 to 2; a number of paths or a seed must be refused instead."""
    try:
        return int(tokens[0].value)
    except ValueError:
        raise ValueError(f"it must be a whole number, not {tokens[0].value!r}.") from None


_Whole = Annotated[int, Parameter(converter=_whole)]


@Parameter(name="*", group=_OSCILLATOR)
@dataclass(frozen=True, kw_only=True)
class _OscillatorFlags:
    """The oscillator's numbers, as flags shared by the commands."""

    order: Annotated[float, Parameter(help="Order alpha of the derivative, 0 (spring) to 1 (dashpot).")] = (
        _DEFAULT.springpot.order
    )
    coefficient: Annotated[float, Parameter(help="C of the springpot per unit mass, in s^(alpha-2).")] = (
        _DEFAULT.springpot.coefficient
    )
    natural_frequency: Annotated[float, Parameter(help="Omega, in rad/s.")] = _DEFAULT.natural_frequency
    intensity: Annotated[float, Parameter(help="Intensity q of the white noise, in m^2 s^-3.")] = (
        _DEFAULT.excitation.intensity
    )
    position: Annotated[float, Parameter(help="Place b of the wall, in m.")] = _WALL.position
    restitution: Annotated[float, Parameter(help="Coefficient r of the impacts, in (0, 1].")] = _WALL.restitution
    side: Annotated[Literal["above", "below"], Parameter(help="Side of the wall on which the mass moves.")] = _WALL.side
    barrier: Annotated[
        bool, Parameter(name="--barrier", negative="--no-barrier", show_default=False, help="With a wall, or without.")
    ] = True

    def oscillator(self) -> Oscillator:
        wall = Barrier(position=self.position, restitution=self.restitution, side=self.side)
        if not self.barrier and wall != _WALL:
            raise ValueError("--no-barrier leaves no wall for --position, --restitution or --side to describe.")
        return Oscillator(
            natural_frequency=self.natural_frequency,
            springpot=Springpot(order=self.order, coefficient=self.coefficient),
            barrier=wall if self.barrier else None,
            excitation=WhiteNoise(intensity=self.intensity),
        )


_Flags = Annotated[_OscillatorFlags, Parameter(name="*")]
_Json = Annotated[bool, Parameter(name="--json", negative="", help="Print one JSON object and nothing else.")]
_Threads = Annotated[_Whole | None, Parameter(help="Threads; all that this process may use if not given.")]


@app.command
def theory(*, flags: _Flags = _OscillatorFlags(), json_: _Json = False) -> int:
    """Closed-form answers: stochastic averaging, as the paper prints it and as corrected."""
    oscillator = flags.oscillator()
    from springpot.simulation import UNITS
    from springpot.theory import all_methods

    answers = all_methods(oscillator)
    if json_:
        _print_json({"oscillator": asdict(oscillator), **answers})
        return 0
    units = {**UNITS, "decay_rate": "s-1"}
    for method, answer in answers.items():
        for warning in _sentences(answer, "warnings"):
            _say(f"warning: {method}: {warning}")
        print(f"{method}: {answer.get('statement') or 'stationary state'}")
        known = {name: unit for name, unit in units.items() if _is_number(answer.get(name))}
        _print_rows([(name, f"{answer[name]:.5g}", unit) for name, unit in known.items()])
    return 0


@app.command
def simulate(
    *,
    flags: _Flags = _OscillatorFlags(),
    paths: Annotated[_Whole, Parameter(group=_MONTE_CARLO, help="Number of independent paths.")] = 5000,
    duration: Annotated[float | None, Parameter(group=_MONTE_CARLO, help="End of the run, in s.")] = None,
    step: Annotated[float | None, Parameter(group=_MONTE_CARLO, help="Time step, in s.")] = None,
    window: Annotated[
        tuple[float, float] | None,
        Parameter(
            group=_MONTE_CARLO, negative="", metavar="START END", help="Times between which averages are taken, in s."
        ),
    ] = None,
    seed: Annotated[_Whole, Parameter(group=_MONTE_CARLO, help="Seed: the same seed gives the same paths.")] = 1,
    threads: Annotated[_Threads, Parameter(group=_MONTE_CARLO)] = None,
    scheme: Annotated[
        Literal["default", "grunwald"], Parameter(group=_MONTE_CARLO, help="Our scheme, or the paper's.")
    ] = "default",
    start: Annotated[
        Literal["rest", "stationary"],
        Parameter(group=_MONTE_CARLO, help="From rest, or adapted: from the stationary mean of x."),
    ] = "rest",
    initial_position: Annotated[float | None, Parameter(group=_MONTE_CARLO, help="x(0), in m.")] = None,
    initial_velocity: Annotated[float, Parameter(group=_MONTE_CARLO, help="x'(0), in m/s.")] = 0.0,
    derivative: Annotated[
        Literal["caputo", "riemann-liouville"], Parameter(group=_MONTE_CARLO, help="They differ when x(0) is not 0.")
    ] = "caputo",
    memory_tolerance: Annotated[
        float, Parameter(group=_MONTE_CARLO, help="Relative error allowed to the memory kernel.")
    ] = 1e-6,
    contact_tolerance: Annotated[
        float, Parameter(group=_MONTE_CARLO, help="Distance at which the paper's scheme sees an impact, in m.")
    ] = 1e-5,
    json_: _Json = False,
) -> int:
    """Monte Carlo: averages over a window of time and at the end, each with its standard error."""
    oscillator = flags.oscillator()
    from springpot.simulation import UNITS, run

    with _Bar("simulating") as bar:
        answer = run(
            oscillator,
            paths=paths,
            duration=duration,
            step=step,
            window=window,
            seed=seed,
            threads=threads,
            scheme=scheme,
            start=start,
            initial_position=initial_position,
            initial_velocity=initial_velocity,
            derivative=derivative,
            memory_tolerance=memory_tolerance,
            contact_tolerance=contact_tolerance,
            progress=bar,
        ).to_dict()
    for warning in _sentences(answer, "warnings"):
        _say(f"warning: {warning}")
    if json_:
        _print_json(answer)
        return 0
    print(f"oscillator: {_plain(answer['oscillator'])}")
    print(f"settings: {_plain(answer['settings'])}")
    _print_rows([(name, _with_error(answer[name], answer[f"{name}_se"]), unit) for name, unit in UNITS.items()])
    return 0


@app.command
def doctor(*, json_: _Json = False) -> int:
    """What this machine gives: versions, processor, threads, cache, and a check of about a second."""
    from springpot.doctor import diagnose

    findings = diagnose()
    if json_:
        _print_json(findings)
    else:
        _print_rows([(name, _plain(value), "") for name, value in findings.items() if name != "self_check"])
        print(findings["self_check"]["statement"])
    if findings["self_check"]["passed"]:
        return 0
    _say("the self-check failed: do not trust results from this installation.")
    return 1


@app.command
def reproduce(
    what: Annotated[Literal["fig1", "fig2", "errata", "all"], Parameter(help="Which part of the paper.")] = "all",
    *,
    out: Annotated[Path, Parameter(help="Folder for the files; made if missing.")] = Path("figures"),
    threads: _Threads = None,
) -> int:
    """The paper's figures, their numbers, and the list of its errata."""
    from springpot.paper import reproduce as make

    with _Bar(f"reproducing {what}") as bar:
        written = make(what, out, progress=bar, threads=threads)
    for path in written:
        print(path)
    return 0


class _Bar:
    """A progress bar on stderr, only on a terminal and only once the work has lasted a while."""

    def __init__(self, text: str) -> None:
        self._text = text
        self._wanted = sys.stderr.isatty()
        self._from = time.monotonic() + _QUIET_SECONDS
        self._bar: Progress | None = None

    def __enter__(self) -> _Bar:
        return self

    def __call__(self, fraction: float, text: str = "") -> None:
        if not self._wanted or time.monotonic() < self._from:
            return
        if self._bar is None:
            from rich.console import Console
            from rich.progress import Progress

            self._bar = Progress(console=Console(stderr=True), transient=True)
            self._bar.add_task(self._text, total=1.0)
            self._bar.start()
        self._bar.update(self._bar.task_ids[0], completed=fraction, description=text or self._text)

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._bar is not None:
            self._bar.stop()


def _sentences(answer: Mapping[str, object], name: str) -> list[str]:
    found = answer.get(name)
    return [str(sentence) for sentence in found] if isinstance(found, list | tuple) else []


def _is_number(value: object) -> bool:
    return isinstance(value, float) and math.isfinite(value)


def _with_error(value: float | None, error: float | None) -> str:
    """The error to two digits, the value to as many decimals."""
    if value is None or error is None:
        return "none" if value is None else f"{value:.5g} (no error known)"
    if error == 0.0:
        return f"{value:.5g} +- 0"
    decimals = max(0, 1 - math.floor(math.log10(error)))
    return f"{value:.{decimals}f} +- {error:.{decimals}f}" if decimals < 8 else f"{value:.7g} +- {error:.2g}"


def _plain(value: object) -> str:
    if isinstance(value, Mapping):
        return ", ".join(f"{name} {_plain(part)}" for name, part in value.items())
    if isinstance(value, list | tuple):
        return " ".join(map(_plain, value))
    if value is None:
        return "none"
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _print_rows(rows: Sequence[tuple[str, str, str]]) -> None:
    width = max((len(name) for name, _, _ in rows), default=0)
    for name, value, unit in rows:
        print(f"  {name:<{width}}  {value} {'' if unit == '1' else unit}".rstrip())


def _without_nan(value: Any) -> Any:
    """JSON has no NaN and no infinity; null says that there is no number."""
    if isinstance(value, Mapping):
        return {name: _without_nan(part) for name, part in value.items()}
    if isinstance(value, list | tuple):
        return [_without_nan(part) for part in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _print_json(answer: Mapping[str, Any]) -> None:
    print(json.dumps(_without_nan(answer), indent=2, allow_nan=False))


def _say(sentence: str) -> None:
    print(f"springpot: {sentence}", file=sys.stderr)


def _one_sentence(error: BaseException) -> str:
    return " ".join(str(error).split()) or type(error).__name__


def _as_flag(sentence: str) -> str:
    """The library's sentences begin with an argument's name; whoever typed a command knows it as a flag."""
    name, _, rest = sentence.partition(" ")
    flags = {field.name for field in fields(_OscillatorFlags)} | set(signature(simulate).parameters)
    return f"--{name.replace('_', '-')} {rest}" if name in flags else sentence


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit code.

    Parameters
    ----------
    arguments : sequence of str, optional
        The words after ``springpot``; those of this process if not given.

    Returns
    -------
    int
        0 done, 1 failed while running, 2 bad usage or bad input, 130 interrupted.

    Examples
    --------
    >>> main(["--version"])
    0.1.0
    0
    """
    try:
        code = app(
            sys.argv[1:] if arguments is None else list(arguments),
            exit_on_error=False,
            print_error=False,
            result_action="return_value",
        )
        sys.stdout.flush()
    except CycloptsError as error:
        error.verbose = False
        _say(_one_sentence(error))
        return 2
    except (TypeError, ValueError) as error:
        _say(_as_flag(_one_sentence(error)))
        return 2
    except KeyboardInterrupt:
        _say("interrupted.")
        return 130
    except BrokenPipeError:  # the reader went away (springpot ... | head): nobody is left to tell
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1
    except OSError as error:
        _say(_one_sentence(error))
        return 1
    except Exception as error:
        _say(f"{type(error).__name__}: {_one_sentence(error)}")
        return 1
    return int(code or 0)
