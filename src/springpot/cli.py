"""The ``springpot`` command: parses, calls the library, prints.  No physics here.

Everything heavy (Numba, SciPy, xarray, matplotlib) is imported inside the commands, so that ``springpot --help`` is
quick.

Exit codes: 0 done, 1 failed while running, 2 bad usage or bad input, 130 interrupted; other than 0, one sentence on
stderr says why.  Stdout then stays empty, except that ``doctor`` prints its findings even where its self-check fails.
"""

from __future__ import annotations

import difflib
import math
import os
import re
import sys
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, fields
from decimal import Decimal
from inspect import signature
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, get_args

from cyclopts import (
    App,
    CoercionError,
    CycloptsError,
    Group,
    MissingArgumentError,
    Parameter,
    RepeatArgumentError,
    Token,
    UnknownCommandError,
    UnknownOptionError,
    UnusedCliTokensError,
)

from springpot.interrupt import leave_at_once
from springpot.oscillator import Barrier, Oscillator, Springpot, WhiteNoise
from springpot.terminal import Bar, Json, Whole, check_picture, print_json, print_table, say

if TYPE_CHECKING:
    from springpot.comparison import Gap

__all__ = ["main"]

_TIMES = "two times, START and END"
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
_Threads = Annotated[Whole | None, Parameter(help="Threads; all that this process may use if not given.")]


@app.command
def theory(*, flags: _Flags = _OscillatorFlags(), json_: Json = False) -> int:
    """Answers without dice: every method side by side, their warnings, and the one to trust here."""
    oscillator = flags.oscillator()
    with leave_at_once():
        from springpot.theory import all_methods
        from springpot.units import UNITS

    found = all_methods(oscillator)
    if json_:
        print_json({"oscillator": asdict(oscillator), **found})
        return 0
    best = found.pop("recommended")
    answers = {name: answer for name, answer in found.items() if isinstance(answer, dict)}
    silent = {name: answer["statement"] for name, answer in answers.items() if "statement" in answer}
    shown = {name: answer for name, answer in answers.items() if name not in silent}
    units = {name: unit for name, unit in {**UNITS, "decay_rate": "s-1"}.items() if name in _names(shown)}
    rows = [
        [name, *(f"{answer[name]:.5g}" if _is_number(answer.get(name)) else "" for answer in shown.values()), unit]
        for name, unit in units.items()
    ]
    print_table([["", *(f"{name} *" if name == best else name for name in shown), "unit"], *rows] if shown else [])
    for name, statement in silent.items():
        print(f"{name}: {statement}")
    none = "no method can be trusted here." if shown else "no method has an answer here."
    print(f"* recommended here: {best}" if best else none)
    # of the others --json tells
    for sentence in _sentences(answers.get(str(best), {}), "warnings"):
        say(f"warning: {best}: {sentence}")
    return 0


@app.command
def atlas(*, flags: _Flags = _OscillatorFlags(), json_: Json = False) -> int:
    """Stationary moments from the atlas of Monte Carlo that comes with the library, with their errors, at once."""
    oscillator = flags.oscillator()
    with leave_at_once():
        from springpot.atlases import atlas as look_up
        from springpot.theory.result import MOMENTS
        from springpot.units import UNITS

    found = look_up(oscillator)
    if json_:
        print_json({"oscillator": asdict(oscillator), **found.to_dict()})
        return 0
    rows = [[name, _with_error(getattr(found, name), found.errors[name], UNITS[name])] for name in MOMENTS]
    print_table([["", "value +- half-width of the 95 % interval"], *rows])
    return 0


@app.command
def compare(
    *,
    flags: _Flags = _OscillatorFlags(),
    rtol: Annotated[float, Parameter(group=_MONTE_CARLO, help="Total relative error of the Monte Carlo.")] = 0.01,
    seed: Annotated[Whole, Parameter(group=_MONTE_CARLO, help="Seed of the Monte Carlo.")] = 1,
    threads: Annotated[_Threads, Parameter(group=_MONTE_CARLO)] = None,
    plot: Annotated[
        str | None,
        Parameter(metavar="FILE", help="PNG to draw densities and spectra of theory and Monte Carlo into."),
    ] = None,
    json_: Json = False,
) -> int:
    """Theory beside Monte Carlo: the gap of each method in per cent and in standard errors."""
    oscillator = flags.oscillator()
    with leave_at_once():
        from springpot.comparison import compare as set_side_by_side
        from springpot.comparison import observe
        from springpot.theory.result import MOMENTS
        from springpot.units import UNITS

    if plot is not None:
        check_picture(plot, "plot")
    with Bar("simulating", first="finding the stationary start") as bar:
        found = set_side_by_side(oscillator, rtol=rtol, seed=seed, threads=threads, progress=bar)
        observed = observe(oscillator, seed=seed, threads=threads, progress=bar) if plot is not None else None
    for sentence in found.simulation.warnings:
        say(f"warning: {sentence}")
    if found.recommended:
        for sentence in found.answers[found.recommended].warnings:
            say(f"warning: {found.recommended}: {sentence}")
    if observed is not None and plot is not None:
        from springpot.figures.comparison import draw_comparison
        from springpot.figures.style import save

        save(draw_comparison(observed, found.answers), Path(plot))
    if json_:
        print_json(found.to_dict())
        return 0
    gaps = {name: found.gaps(name) for name in found.answers}
    table = [["", "Monte Carlo", *(f"{name} *" if name == found.recommended else name for name in gaps)]]
    for name in MOMENTS:
        value, error = found.simulation.values[name], found.simulation.errors[name]
        if not math.isfinite(value):
            continue
        cells = [_gap(gaps[method].get(name)) for method in gaps]
        table.append([name, _with_error(value, error, UNITS[name]), *cells])
    print_table(table)
    for name, statement in found.statements.items():
        print(f"{name}: {statement}")
    print("gap of each method to Monte Carlo in per cent, and in standard errors in brackets.")
    print(f"* recommended here: {found.recommended}" if found.recommended else "no method has an answer here.")
    if plot is not None:
        print(plot)
    return 0


@app.command
def simulate(
    *,
    flags: _Flags = _OscillatorFlags(),
    rtol: Annotated[
        float | None,
        Parameter(
            group=_MONTE_CARLO,
            help="Total relative error wanted.  It decides on all of the below; only seed and threads can be given "
            "with it.",
        ),
    ] = None,
    quantity: Annotated[
        list[str] | None,
        Parameter(
            group=_MONTE_CARLO,
            negative="",
            metavar="NAME",
            help="With --rtol: what must be known so well, amplitude_mean_square if not given; can be repeated.",
        ),
    ] = None,
    paths: Annotated[
        Whole | None, Parameter(group=_MONTE_CARLO, help="Number of independent paths; 5000 if not given.")
    ] = None,
    duration: Annotated[float | None, Parameter(group=_MONTE_CARLO, help="End of the run, in s.")] = None,
    step: Annotated[float | None, Parameter(group=_MONTE_CARLO, help="Time step, in s.")] = None,
    window: Annotated[
        tuple[float, float] | None,
        Parameter(
            group=_MONTE_CARLO, negative="", metavar="START END", help="Times between which averages are taken, in s."
        ),
    ] = None,
    seed: Annotated[
        Whole | None,
        Parameter(group=_MONTE_CARLO, help="Seed: the same seed gives the same paths; 1 if not given."),
    ] = None,
    threads: Annotated[_Threads, Parameter(group=_MONTE_CARLO)] = None,
    scheme: Annotated[
        Literal["default", "grunwald"] | None,
        Parameter(group=_MONTE_CARLO, help="Our scheme, or the paper's; default if not given."),
    ] = None,
    start: Annotated[
        Literal["rest", "stationary"] | None,
        Parameter(group=_MONTE_CARLO, help="From rest, or adapted: from the stationary mean of x; rest if not given."),
    ] = None,
    initial_position: Annotated[float | None, Parameter(group=_MONTE_CARLO, help="x(0), in m.")] = None,
    initial_velocity: Annotated[
        float | None, Parameter(group=_MONTE_CARLO, help="x'(0), in m/s; 0 if not given.")
    ] = None,
    derivative: Annotated[
        Literal["caputo", "riemann-liouville"] | None,
        Parameter(group=_MONTE_CARLO, help="They differ when x(0) is not 0; caputo if not given."),
    ] = None,
    memory_tolerance: Annotated[
        float | None,
        Parameter(group=_MONTE_CARLO, help="Relative error allowed to the memory kernel; 1e-06 if not given."),
    ] = None,
    contact_tolerance: Annotated[
        float | None,
        Parameter(
            group=_MONTE_CARLO,
            help="Distance at which the paper's scheme sees an impact, in m; 1e-05 if not given.",
        ),
    ] = None,
    distributions: Annotated[
        bool,
        Parameter(
            group=_MONTE_CARLO,
            negative="",
            help="Quantiles of x, v, amplitude and impact speed, and of the extremes of each path, as well.",
        ),
    ] = False,
    json_: Json = False,
) -> int:
    """Monte Carlo: averages over a window of time and at the end, each with its standard error."""
    oscillator = flags.oscillator()
    if quantity is not None and rtol is None:
        raise ValueError("--quantity needs --rtol, the relative error to which it must be known.")
    settings: dict[str, Any] = {
        "rtol": rtol,
        "quantities": quantity,
        "paths": paths,
        "duration": duration,
        "step": step,
        "window": window,
        "seed": seed,
        "threads": threads,
        "scheme": scheme,
        "start": start,
        "initial_position": initial_position,
        "initial_velocity": initial_velocity,
        "derivative": derivative,
        "memory_tolerance": memory_tolerance,
        "contact_tolerance": contact_tolerance,
        "distributions": distributions or None,
    }
    given = {name: value for name, value in settings.items() if value is not None}
    with leave_at_once():
        from springpot.simulation import run

    adapted = start == "stationary" or rtol is not None
    with Bar("simulating", first="finding the stationary start" if adapted else "simulating") as bar:
        answer = run(oscillator, **given, progress=bar).to_dict()
    for warning in _sentences(answer, "warnings"):
        say(f"warning: {warning}")
    if json_:
        print_json(answer)
        return 0
    print(f"oscillator: {_plain(answer['oscillator'])}")
    print(f"settings: {_plain(answer['settings'])}")
    _print_estimates(answer)
    return 0


app.command("springpot.studies.commands:app", name="study")


@app.command
def doctor(*, json_: Json = False) -> int:
    """What this machine gives: versions, processor, threads, cache, and a check of about a second."""
    with leave_at_once():
        from springpot import simulation  # noqa: F401  (what takes long to load)
        from springpot.doctor import diagnose

    findings = diagnose()
    if json_:
        print_json(findings)
    else:
        print_table([[name, _plain(value)] for name, value in findings.items() if name != "self_check"])
        print(findings["self_check"]["statement"])
    if findings["self_check"]["passed"]:
        return 0
    say("the self-check failed: do not trust results from this installation.")
    return 1


@app.command
def reproduce(
    what: Annotated[Literal["fig1", "fig2", "errata", "all"], Parameter(help="Which part of the paper.")] = "all",
    *,
    out: Annotated[str, Parameter(help="Folder for the files; made if missing.")] = "figures",
    threads: _Threads = None,
) -> int:
    """The paper's figures, their numbers, and the list of its errata."""
    with leave_at_once():
        from springpot import simulation  # noqa: F401  (what takes long to load)
        from springpot.paper import reproduce as make

    with Bar(f"reproducing {what}") as bar:
        written = make(what, out, progress=bar, threads=threads)
    for path in written:
        print(path)
    return 0


@app.command
def validity(
    *,
    out: Annotated[str, Parameter(help="Folder for the files; made if missing.")] = "figures",
    simulate_again: Annotated[
        bool, Parameter(negative="", help="Make the map's Monte Carlo anew first: half an hour, and it can be stopped.")
    ] = False,
    threads: _Threads = None,
) -> int:
    """The validity map: how far each method of the theory is from Monte Carlo, as pictures and as a table."""
    with leave_at_once():
        from springpot.figures.style import save
        from springpot.figures.validity import draw_gaps
        from springpot.theory.reliability import MAP_FILE

    folder = Path(out)
    folder.mkdir(parents=True, exist_ok=True)
    source = MAP_FILE
    if simulate_again:
        from springpot.validity import make_map

        with Bar("simulating the validity map") as bar:
            source = make_map(path=folder / MAP_FILE.name, threads=threads, progress=bar)
    else:
        (folder / MAP_FILE.name).write_bytes(MAP_FILE.read_bytes())
    print(folder / MAP_FILE.name)
    for moment, short in (("amplitude_mean_square", "amplitude"), ("x_mean", "mean"), ("impact_rate", "rate")):
        for along in ("restitution", "position"):
            print(save(draw_gaps(moment, along, path=source), folder / f"validity_{short}_{along}.png"))
    return 0


@app.command
def explore(
    *,
    port: Annotated[Whole, Parameter(help="Port to listen on; 0 takes any that is free.")] = 8765,
    host: Annotated[str, Parameter(help="Numerical address to listen on; by default only this computer's own.")] = (
        "127.0.0.1"
    ),
    browser: Annotated[bool, Parameter(help="Whether to open the page in the browser.")] = True,
) -> int:
    """A page in the browser: move a slider, and watch the mass, the densities and every theory beside Monte Carlo."""
    from springpot.explorer.commands import open_page

    open_page(host=host, port=port, browser=browser)
    return 0


def _gap(gap: Gap | None) -> str:
    if gap is None:
        return ""
    near = f"({gap.standard_errors:+.1f})"
    return f"{gap.percent:+.1f} % {near}" if math.isfinite(gap.percent) else near


def _names(answers: Mapping[str, Mapping[str, object]]) -> set[str]:
    """Names of all numbers that any of the answers has."""
    return {name for answer in answers.values() for name, value in answer.items() if _is_number(value)}


def _sentences(answer: Mapping[str, object], name: str) -> list[str]:
    found = answer.get(name)
    return [str(sentence) for sentence in found] if isinstance(found, list | tuple) else []


def _is_number(value: object) -> bool:
    return isinstance(value, float) and math.isfinite(value)


def _with_error(value: float | None, error: float | None, unit: str = "1") -> str:
    """The error to two digits, the value to as many decimals, both with one power of ten where that is shorter."""
    unit = "" if unit == "1" else f" {unit}"
    if value is None:
        return "none"
    if error is None:
        return f"{value:.5g}{unit} (no error known)"
    if error == 0.0:
        return f"{value:.5g} +- 0{unit}"
    scale = max(abs(value), error)
    power = 0 if 1e-4 <= scale < 1e6 else _power(scale)
    decimals = max(0, power - _power(error) + 1)
    if decimals > 8:
        return f"{value:.7g} +- {error:.1e}{unit}"
    digits = f"{Decimal(value).scaleb(-power):.{decimals}f} +- {Decimal(error).scaleb(-power):.{decimals}f}"
    return f"({digits})e{power:+03d}{unit}" if power else f"{digits}{unit}"


def _power(number: float) -> int:
    """The power of ten of a number written with two digits."""
    return int(f"{number:.1e}".partition("e")[2])


def _plain(value: object) -> str:
    if isinstance(value, Mapping):
        return ", ".join(f"{name} {_plain(part)}" for name, part in value.items())
    if isinstance(value, list | tuple):
        return " ".join(map(_plain, value))
    if value is None:
        return "none"
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def _print_estimates(answer: Mapping[str, Any]) -> None:
    """Estimates with a budget first, its parts in columns; then those with a standard error only."""
    from springpot.units import UNITS

    controlled = [name for name in UNITS if f"{name}_error" in answer]
    rest = [name for name in UNITS if name not in controlled]
    if controlled:
        columns = ("se", "step_bias", "memory_bias", "transient")
        rows = [
            [name, _with_error(answer[name], answer[f"{name}_error"], UNITS[name])]
            + [_plain_short(answer[f"{name}_{column}"]) for column in columns]
            for name in controlled
        ]
        print_table([["", "value +- total error", "standard error", "step", "memory", "transient"], *rows, []])
    rows = [[name, _with_error(answer[name], answer[f"{name}_se"], UNITS[name])] for name in rest]
    print_table([["", "value +- standard error"], *rows] if controlled else rows)
    if "probability" in answer:
        _print_quantiles(answer)


def _print_quantiles(answer: Mapping[str, Any]) -> None:
    """Quantiles of distributions and extremes, one row for each probability in the middle and in the tails."""
    from springpot.simulation.observers import EXTREMES, SKETCHED

    units = {name: unit for name, (unit, _) in SKETCHED.items()} | EXTREMES
    shown = [i for i, p in enumerate(answer["probability"]) if p in (0.01, 0.05, 0.5, 0.95, 0.99)]
    print()
    print_table(
        [["quantile +- standard error", *(f"{100.0 * answer['probability'][i]:g} %" for i in shown)]]
        + [
            [name, *(_with_error(answer[f"{name}_quantile"][i], answer[f"{name}_quantile_se"][i], unit) for i in shown)]
            for name, unit in units.items()
        ]
    )


def _plain_short(value: float | None) -> str:
    return "none" if value is None else f"{value:.2g}"


def _one_sentence(error: BaseException) -> str:
    return " ".join(str(error).split()) or type(error).__name__


def _usage(error: CycloptsError) -> str:
    """What is wrong with the words of a command, and what would be right."""
    command = " ".join(["springpot", *(error.command_chain or ())])
    match error:
        case UnknownCommandError(unused_tokens=[word, *_]):
            names = [name for name in app if not name.startswith("-")]
            return f"there is no command {word!r}{_meant(word, names) or f': the commands are {_listed(names)}.'}"
        case UnknownOptionError(token=token):
            word = token.keyword or token.value
            names = [name for argument in error.argument_collection for name in argument.names]
            return f"there is no flag {word}{_meant(word, names) or f': {command} --help lists all flags.'}"
        case UnusedCliTokensError(unused_tokens=[word, *_]):
            flag = _flag_before(word, error.root_input_tokens or [])
            right = f"--window takes {_TIMES}" if flag == "--window" else f"{command} --help shows what it takes"
            return f"{word!r} is one word too many: {right}."
        case MissingArgumentError(argument=argument) if argument is not None:
            wanted = _TIMES if argument.token_count()[0] == 2 else f"a value: {command} --help says which"
            return f"{error.keyword or argument.name} needs {wanted}."
        case RepeatArgumentError(token=token):
            return f"{token.keyword} must be given only once."
        case CoercionError(token=Token() as token):
            return _unfit(error, token)
    error.verbose = False
    return _one_sentence(error)


def _unfit(error: CoercionError, token: Token) -> str:
    """A word that is not of the kind its flag asks for."""
    name = token.keyword or (error.argument.name.lstrip("-").upper() if error.argument else "the word")
    if error.target_type is bool:
        return f"{name} is a switch: it takes no value such as {token.value!r}."
    chosen = [repr(word) for word in get_args(error.target_type) if isinstance(word, str)]
    if chosen:
        wanted = _listed(chosen, "or")
    elif error.argument and error.argument.token_count()[0] == 2:
        wanted = _TIMES
    else:
        wanted = "a whole number" if error.target_type is int else "a number"
    return f"{name} must be {wanted}, not {token.value!r}."


def _listed(words: Sequence[str], last: str = "and") -> str:
    return f" {last} ".join(filter(None, [", ".join(words[:-1]), words[-1]]))


def _meant(word: str, names: Sequence[str]) -> str:
    """A question, if one of the names is close; without their hyphens, or all flags would look alike."""
    plain = {name.lstrip("-"): name for name in names}
    close = difflib.get_close_matches(word.lstrip("-"), plain, n=1, cutoff=0.7)
    return f"; did you mean {plain[close[0]]}?" if close else ""


def _flag_before(word: str, words: Sequence[str]) -> str:
    before = words[: words.index(word)] if word in words else []
    return next((flag for flag in reversed(before) if flag.startswith("--")), "")


def _in_flags(sentence: str) -> str:
    """The library's sentences speak of arguments; whoever typed a command knows them as flags."""
    names = {field.name for field in fields(_OscillatorFlags)} | set(signature(simulate).parameters)
    flags = {name: f"--{name.replace('_', '-')}" for name in names} | {
        "quantities": "--quantity",
        "out": "--out",
        "plot": "--plot",
    }
    any_flag = "|".join(flags)
    sentence = re.sub(rf"\b({any_flag})='([\w-]+)'", lambda found: f"{flags[found[1]]} {found[2]}", sentence)
    # in the middle of a sentence, only those names that are no English words
    alone = "|".join(name for name in flags if "_" in name or name == "rtol")
    sentence = re.sub(rf"(?<![\w-])({alone})\b", lambda found: flags[found[1]], sentence)
    first, space, rest = sentence.partition(" ")
    return flags.get(first, first) + space + rest


def _of_the_system(error: OSError) -> str:
    """A failure of the operating system without its number; those of the library are sentences already."""
    if error.strerror is None:
        return _one_sentence(error)
    place = "reading or writing" if error.filename is None else repr(os.fspath(error.filename))
    return f"{place} failed: {error.strerror}."


def _flush() -> None:
    if sys.stdout is not None:
        sys.stdout.flush()


def _drop_output() -> None:
    """What can no longer be written must not be tried once more when the process ends."""
    try:
        _flush()
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


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
        _flush()
    except CycloptsError as error:
        say(_usage(error))
        return 2
    except (TypeError, ValueError) as error:
        say(_in_flags(_one_sentence(error)))
        return 2
    except KeyboardInterrupt:
        say("interrupted.")
        return 130
    except BrokenPipeError:  # the reader went away (springpot ... | head): nobody is left to tell
        _drop_output()
        return 1
    except OSError as error:
        _drop_output()
        say(_of_the_system(error))
        return 1
    except MemoryError:
        say("there is not enough memory for this; fewer --paths need less.")
        return 1
    except Exception as error:
        say(f"{type(error).__name__}: {_one_sentence(error)}")
        return 1
    return int(code or 0)
