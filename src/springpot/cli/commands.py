"""The commands: each calls the library and prints.  No physics here.

Everything heavy (Numba, SciPy, xarray, matplotlib) is imported inside the commands, so that ``springpot --help`` is
quick."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import App, Parameter

from springpot.cli.flags import (
    AS_USUAL,
    MONTE_CARLO,
    OUTPUT,
    RAINFLOW,
    STANDARD,
    Flags,
    OscillatorFile,
    Overwrite,
    PageFile,
    RunSettings,
    SystemFile,
    Threads,
    in_flags,
    monte_carlo,
    problem_of,
    repeated,
    written,
)
from springpot.cli.terminal import (
    Json,
    Whole,
    check_picture,
    gap,
    in_words,
    is_number,
    print_estimates,
    print_json,
    print_table,
)
from springpot.files.units import Decimal
from springpot.machine.arguments import place_for
from springpot.machine.bar import Bar, say
from springpot.machine.faults import Stopped, known_word, with_error
from springpot.machine.interrupt import asked_to_stop, leave_at_once

if TYPE_CHECKING:
    from springpot.problem.system import System

_LEVELS = repeated(
    "NAME LEVEL",
    "Also rates at which a linear system exceeds levels in m, by Rice's and Vanmarcke's formulas and the diffusion of "
    "the amplitude: x or distance (|x|), with several masses box_x or mount_elongation; can be repeated.",
)
_CURVES = Parameter(
    help="Also the damage per hour of a linear system's response, by spectral formulas, with the words of springpot "
    "simulate; can be repeated.",
    **RAINFLOW,
)
Schema = Annotated[bool, Parameter(negative="", help="Print the JSON schema of such a file, and nothing else.")]


def _version() -> str:
    from springpot import __version__

    return __version__


app = App(
    name="springpot",
    help="Random vibration of a mass on a viscoelastic mount that hits a stop.",
    help_format="plaintext",
    version=_version,
    suppress_keyboard_interrupt=False,  # main() turns it into one sentence and 130
)


@app.command
def explain(file: SystemFile = None, /, *, flags: Flags = STANDARD, schema: Schema = False) -> int:
    """Explain: the equation with its numbers and units, its scales, what dissipates, and which methods cover it.

    Example: springpot explain device.toml
    """
    if schema:
        if file is not None or flags != STANDARD:
            raise ValueError("--schema prints the JSON schema of a file, and takes nothing else.")
        from springpot.problem.file import schema as schema_of_a_file

        print_json(schema_of_a_file())
        return 0
    problem = problem_of(file, flags)
    with leave_at_once():
        from springpot.evidence.explanation import explain as in_words

    print(in_words(problem))
    return 0


@app.command
def theory(
    file: SystemFile = None,
    /,
    *,
    flags: Flags = STANDARD,
    levels: Annotated[list[tuple[str, float]] | None, _LEVELS] = None,
    rainflow: Annotated[list[tuple[str, tuple[float, ...]]] | None, _CURVES] = None,
    json_: Json = False,
) -> int:
    """Theory: all analytical methods side by side (no random numbers), their warnings, and the recommended one.

    Example: springpot theory --order 0.7 --coefficient 0.2 --natural-frequency 3
    """
    system = problem_of(file, flags)
    formulas = _formulas(system, levels or (), rainflow or ())
    with leave_at_once():
        from springpot.evidence.explanation import equation
        from springpot.evidence.recommendation import all_methods
        from springpot.problem.catalogue import unit_of_result
        from springpot.theory.result import names_of_results
        from springpot.theory.solve import grouped

    dicts = all_methods(system)
    if json_:
        print_json({"system": system.to_dict(), **dicts, **formulas})
        return 0
    print("\n".join(equation(system)))
    best, why_none = dicts.pop("recommended"), dicts.pop("why_none_is_recommended")
    answers = {name: answer for name, answer in dicts.items() if isinstance(answer, dict)}
    silent = {name: answer["statement"] for name, answer in answers.items() if "statement" in answer}
    shown = {name: answer for name, answer in answers.items() if name not in silent}
    units = {name: unit_of_result(system, name) for name in names_of_results(system)} | {"decay_rate": "s-1"}
    rows = [
        [name, *(f"{answer[name]:.5g}" if is_number(answer.get(name)) else "" for answer in shown.values()), unit]
        for name, unit in units.items()
        if any(is_number(answer.get(name)) for answer in shown.values())
    ]
    print_table([["", *(f"{name} *" if name == best else name for name in shown), "unit"], *rows] if shown else [])
    for sentence in grouped(silent):
        print(sentence)
    print(f"* recommended here: {best}" if best else why_none)
    for what, found in formulas.items():
        print()
        names = list(dict.fromkeys(name for each in found.values() for name in each))
        rows = [[key, *(f"{each[n]:.4g}" if n in each else "" for n in names)] for key, each in found.items()]
        print_table([[f"{what}, {'h-1' if what == 'damage_rate' else 's-1'}", *names], *rows])
    # warnings of the other methods: --json prints them
    warn(*(f"{best}: {sentence}" for sentence in answers.get(str(best), {}).get("warnings", ())))
    if not best:
        warn(*dict.fromkeys(each for answer in shown.values() for each in answer.get("warnings", ())))
    return 0


def _formulas(system: System, levels: Sequence[tuple[str, float]], curves: Sequence[tuple[str, Any]]) -> dict[str, Any]:
    """Rates of exceedance in 1/s and damages per hour by each formula, of each level and each curve."""
    from springpot.theory import exceedance, fatigue

    found: dict[str, Any] = {}
    if levels:
        found["exceedance_rate"] = {
            f"{name} {level:g}": {formula: float(rate[place]) for formula, rate in of_name.rate.items()}
            for name, of_name in exceedance(system, by_name(levels)).items()
            for place, level in enumerate(of_name.levels)
        }
    if curves:
        found["damage_rate"] = {
            " ".join((name, *map("{:g}".format, numbers))): dict(fatigue(system, curve, name).damage)
            for name, numbers in curves
            for curve in _curves([(name, numbers)]).values()
        }
    return found


@app.command
def atlas(file: OscillatorFile = None, /, *, flags: Flags = STANDARD, json_: Json = False) -> int:
    """Atlas: stationary moments and their errors, interpolated at once in a table of Monte Carlo results.

    Example: springpot atlas --order 0.3 --coefficient 30 --natural-frequency 12 --restitution 0.7
    """
    system = problem_of(file, flags)
    with leave_at_once():
        from springpot.evidence.atlases import atlas as look_up
        from springpot.evidence.explanation import equation
        from springpot.problem.catalogue import unit_of
        from springpot.theory.result import MOMENTS

    result = look_up(system)
    if json_:
        print_json({"system": system.to_dict(), **result.to_dict()})
        return 0
    print("\n".join(equation(system)))
    rows = [[name, with_error(getattr(result, name), result.errors[name], unit_of(name))] for name in MOMENTS]
    print_table([["", "value +- half-width of the 95 % interval"], *rows])
    return 0


@app.command
def compare(
    file: SystemFile = None,
    /,
    *,
    flags: Flags = STANDARD,
    rtol: Annotated[float, monte_carlo("Total relative error of Monte Carlo.")] = 0.01,
    seed: Annotated[Whole, monte_carlo("Seed of Monte Carlo.")] = 1,
    threads: Annotated[Threads, Parameter(group=MONTE_CARLO)] = None,
    max_time: Annotated[
        float | None, monte_carlo("Seconds after which Monte Carlo stops and keeps what it has reached.")
    ] = None,
    plot: Annotated[str | None, written("PNG file for the densities and spectra of theory and Monte Carlo.")] = None,
    json_: Json = False,
) -> int:
    """Compare theory with Monte Carlo: the gap of each method in per cent and in standard errors.

    Example: springpot compare --order 0.5 --restitution 0.8 --rtol 0.02
    """
    problem = problem_of(file, flags)
    with leave_at_once():
        from springpot.evidence.comparison import compare as set_side_by_side
        from springpot.evidence.comparison import observe
        from springpot.evidence.reliability import warnings_of
        from springpot.theory.solve import grouped

    check_picture(plot)
    with Bar("simulating", first="finding the stationary start") as bar:
        observed = observe(problem, seed=seed, threads=threads, progress=bar) if plot is not None else None
        result = set_side_by_side(problem, rtol=rtol, max_time=max_time, seed=seed, threads=threads, progress=bar)
    warn(*result.simulation.warnings)
    if result.recommended:
        warn(*(f"{result.recommended}: {sentence}" for sentence in warnings_of(result.answers[result.recommended])))
    if observed is not None and plot is not None:
        from springpot.figures.stationary import plot_comparison
        from springpot.figures.style import save

        save(plot_comparison(observed, result.answers), Path(plot))
    if json_:
        print_json(result.to_dict())
        return _exit_code(result.simulation.diagnostics)
    print(_stated(result.simulation.system))
    gaps = {name: result.gaps(name) for name in result.answers}
    table = [
        ["", "Monte Carlo +- standard error", *(f"{name} *" if name == result.recommended else name for name in gaps)]
    ]
    for name in result.moments:
        own = result.simulation[name]
        if math.isfinite(own.value):
            cells = [gap(gaps_of_method.get(name)) for gaps_of_method in gaps.values()]
            table.append([name, with_error(own.value, own.error, own.unit), *cells])
    print_table(table)
    for sentence in grouped(result.statements):
        print(sentence)
    print("gap of each method to Monte Carlo in per cent, and in standard errors in brackets.")
    print(f"* recommended here: {result.recommended}" if result.recommended else result.why_none_is_recommended)
    if plot is not None:
        print(plot)
    return _exit_code(result.simulation.diagnostics)


@app.command
def simulate(
    file: SystemFile = None,
    /,
    *,
    flags: Flags = STANDARD,
    settings: RunSettings = AS_USUAL,
    out: Annotated[
        str | None,
        written("Save the run: .nc (netCDF) or .json, which springpot.load_run can read, or .csv for spreadsheets."),
    ] = None,
    overwrite: Overwrite = False,
    json_: Json = False,
) -> int:
    """Monte Carlo: averages over a window of time and at the end, each with its standard error.

    Example: springpot simulate --order 0.5 --restitution 0.8 --out run.nc
    """
    problem = problem_of(file, flags)
    given: Any = {name: value for name, value in vars(settings).items() if value is not None and value is not False}
    if "quantities" in given and "rtol" not in given:
        raise ValueError("--quantities needs --rtol, the relative error to which they must be known.")
    if len(given.get("profile", ())) == 1:
        (given["profile"],) = given["profile"]  # a number of bins
    if "first_passage" in given:
        given["first_passage"] = _levels(problem, given["first_passage"])
    if "rainflow" in given:
        given["rainflow"] = _curves(given["rainflow"])
    if out is None and ("record" in given or overwrite):
        raise ValueError(f"--{'record' if 'record' in given else 'overwrite'} needs --out, the file to save to.")
    if "record_every" in given and "record" not in given:
        raise ValueError("--record-every needs --record, the number of paths to save.")
    with leave_at_once():
        from springpot.simulation.monte_carlo import simulated
        from springpot.simulation.plan.motions import motion_of
        from springpot.simulation.plan.plan import default_start
        from springpot.simulation.result.save import places

    saved = () if out is None else tuple(place_for(p, overwrite=overwrite) for p in places(out, settings.record or 0))
    adapted = "rtol" in given or (settings.start or default_start(motion_of(problem), given)[0]) == "stationary"
    shorter = {} if "rtol" in given else {"hint": "fewer --paths or a shorter --duration take less"}
    with Bar("simulating", first="finding the stationary start" if adapted else "simulating", **shorter) as bar:
        result = simulated(problem, **given, progress=bar)
    answer = result.to_dict()
    warn(*answer["warnings"])
    if out is not None:
        result.save(out, overwrite=overwrite)
    if json_:
        print_json(answer)
        return _exit_code(answer["diagnostics"])
    print(_stated(result.system))
    print(f"settings: {in_words(answer['settings'])}")
    print_estimates(answer, result.units, result.system.has_mass)
    for place in saved:
        print(place)
    return _exit_code(answer["diagnostics"])


def _stated(system: System) -> str:
    """The equation of a system."""
    from springpot.evidence.explanation import equation

    return "\n".join(["system:", *(f"  {line}" for line in equation(system))])


def _exit_code(diagnostics: Mapping[str, Any]) -> int:
    """0, or 1 if ``rtol`` was not reached; the numbers are printed in both cases."""
    return 0 if diagnostics.get("reached", True) else 1


def _levels(problem: System, asked: Sequence[tuple[str, Sequence[float]]]) -> dict[str, Any]:
    """The level or interval of each name, or a list if it is given more than once; an error if nothing has it.

    In Python another name is that of a function.
    """
    from springpot.problem.outputs import outputs_of
    from springpot.simulation.plan.signals import levels_of

    for name, _ in asked:
        if name not in outputs_of(problem):
            known_word(name, levels_of(problem), "--first-passage")
    return _one_or_many((name, each[0] if len(each) == 1 else (*each,)) for name, each in asked)


def _curves(asked: Sequence[tuple[str, Sequence[float]]]) -> dict[str, Any]:
    """The curve of each name, or a list if it is given more than once."""
    from springpot.problem.basquin import Basquin

    pairs = []
    for name, numbers in asked:
        try:
            pairs.append((name, Basquin(*numbers)))
        except ValueError as error:
            raise ValueError(f"--rainflow of {name}: {error}") from None
    return _one_or_many(pairs)


def by_name(pairs: Iterable[tuple[str, Any]]) -> dict[str, list[Any]]:
    """The values that a flag which may be repeated has for each name."""
    found: dict[str, list[Any]] = {}
    for name, value in pairs:
        found.setdefault(name, []).append(value)
    return found


def _one_or_many(pairs: Iterable[tuple[str, Any]]) -> dict[str, Any]:
    return {name: values if len(values) > 1 else values[0] for name, values in by_name(pairs).items()}


@app.command
def fit(
    data: Annotated[
        str,
        Parameter(
            help="File of moduli, relaxation, creep, a spectrum, a response, a record, impacts or statistics: CSV, ..."
        ),
    ],
    /,
    *,
    model: Annotated[
        list[str],
        Parameter(
            negative="",
            metavar="FILE",
            help='System file with free numbers, such as stiffness = { free = "k", start = 80, low = 10, '
            "high = 200 }; of several the best is chosen.",
        ),
    ],
    seed: Annotated[
        Whole, Parameter(help="Seed of the places from which the search is repeated, and of simulations.")
    ] = 1,
    paths: Annotated[
        Whole | None, Parameter(help="Of each run of a fit to statistics, a power of two; chosen if not set.")
    ] = None,
    rate: Annotated[
        float | None, Parameter(help="Samples per second, of a record without a column of the time.")
    ] = None,
    unit: Annotated[str, Parameter(help="Of the values, where the file does not say it, such as g.")] = "",
    columns: Annotated[
        str, Parameter(help="A header for each column of a file without one, with commas, such as time_s,x_mm.")
    ] = "",
    decimal: Annotated[Decimal, Parameter(help="The decimal mark of the file, where it cannot be told.")] = "",
    out: Annotated[str | None, written("Write the system with the found values to a file.")] = None,
    uncertain: Annotated[
        bool,
        Parameter(
            group=OUTPUT,
            negative="",
            help="In that file the numbers are uncertain, by their errors: see springpot scatter.",
        ),
    ] = False,
    plot: Annotated[str | None, written("PNG file for data, fit and residuals.")] = None,
    overwrite: Overwrite = False,
    json_: Json = False,
) -> int:
    """Fit: the free numbers of a system that agree best with measured data, with errors.

    Example: springpot fit rubber.csv --model rubber.toml
    """
    check_picture(plot)
    place = place_of(out, overwrite)
    if uncertain and place is None:
        raise ValueError("uncertain is of the file that out names: give --out too.")
    with leave_at_once():
        from springpot.fitting import fit as find
        from springpot.fitting import read_data
        from springpot.problem.file import read_system, to_toml
        from springpot.problem.free_numbers import free_numbers, with_values

    models = [read_system(name) for name in model]
    headers = [header.strip() for header in columns.split(",")] if columns else None
    measured = read_data(data, rate=rate, unit=unit, columns=headers, decimal=decimal)
    asked = models[0] if len(models) == 1 else models
    ending = asked_to_stop("springpot: stopping with the best numbers so far; Ctrl-C again ends at once.")
    with Bar("simulating", first="finding where to simulate", hint="") as bar, ending as stop:
        try:
            found = find(asked, measured, seed=seed, paths=paths, progress=bar, stop=stop)
        except Stopped:  # before there were any
            raise KeyboardInterrupt from None
    warn(*found.warnings)
    if place is not None:
        model_of_file = found.model
        if uncertain:
            own = free_numbers(found.given)  # a noise of the measurement is no number of the device
            numbers = {name: number for name, number in found.uncertain().items() if name in own}
            model_of_file = with_values(found.given, numbers)
        place.write_text(to_toml(model_of_file), encoding="utf-8")
    if plot is not None:
        from springpot.figures.fits import plot_fit
        from springpot.figures.style import save

        save(plot_fit(found), Path(plot))
    return tell(found, json_, place, plot)


# these modules are not imported here, so the list of commands needs the words of their help
app.command(
    "springpot.cli.exceeding:exceedance",
    name="exceedance",
    help="Rare events: the probability that a quantity exceeds levels within a time, and how often it does; or the "
    "level that it exceeds with a probability.  Of a file with uncertain numbers: over devices.\n\n"
    "Example: springpot exceedance --order 0.5 --levels x 3.0 --levels x 4.0 --duration 20\n\n"
    "Example: springpot exceedance --order 0.5 --probability x 1e-6 --duration 20",
)
app.command(
    "springpot.cli.designing:sensitivity",
    name="sensitivity",
    help="Sensitivity: how much each result changes with each number, d ln(quantity) / d ln(number), with errors.\n\n"
    "Example: springpot sensitivity device.toml --quantities impact_rate",
)
app.command(
    "springpot.cli.designing:design",
    name="design",
    help="Design: choose the free numbers of a system so that limits hold and a cost is least or a gain greatest.\n\n"
    "Example: springpot design device.toml --minimize c --below impact_rate 0.2",
)
app.command(
    "springpot.cli.designing:scatter",
    name="scatter",
    help="Scatter: how results differ from device to device, and which uncertain numbers matter.\n\n"
    "Example: springpot scatter device.toml --quantities impact_rate --limit impact_rate 3",
)
app.command(
    "springpot.cli.studying:app",
    name="study",
    help="Study: a grid of oscillators, described in a file.  Results are saved on disk; interrupted runs resume.",
)


@app.command
def doctor(
    *,
    json_: Json = False,
    compile_: Annotated[
        bool,
        Parameter(name="--compile", negative="", help="First compile what later runs would, and keep it on disk."),
    ] = False,
) -> int:
    """Check the installation: versions, processor, threads, compiled code, caches, and a self-test of about a second.

    Example: springpot doctor
    """
    with leave_at_once():
        import springpot.simulation.monte_carlo  # noqa: F401  (what takes long to load)
        from springpot.cli.doctor import compile_ahead, diagnose

        if compile_:
            compile_ahead()
    findings = diagnose()
    if json_:
        print_json(findings)
    else:
        print_table([[name, in_words(value)] for name, value in findings.items() if name != "self_check"])
        print(findings["self_check"]["statement"])
    if findings["self_check"]["passed"]:
        return 0
    say("the self-check failed: do not trust results from this installation.")
    return 1


@app.command
def reproduce(
    what: Annotated[Literal["fig1", "fig2", "errata", "all"], Parameter(help="Which part of the paper.")] = "all",
    *,
    out: Annotated[str, Parameter(help="Folder for the files; created if missing.")] = "figures",
    threads: Threads = None,
) -> int:
    """Reproduce the paper: its figures, their numbers, and a list of its errors.

    Example: springpot reproduce fig1 --out figures
    """
    with leave_at_once():
        import springpot.simulation.monte_carlo  # noqa: F401  (what takes long to load)
        from springpot.paper import reproduce as make

    with Bar(f"reproducing {what}") as bar:
        written = make(what, out, progress=bar, threads=threads)
    for path in written:
        print(path)
    return 0


@app.command
def validity(
    *,
    out: Annotated[str, Parameter(help="Folder for the files; created if missing.")] = "figures",
    simulate_again: Annotated[
        bool,
        Parameter(negative="", help="First repeat the Monte Carlo of the maps: two hours; can be interrupted."),
    ] = False,
    threads: Threads = None,
) -> int:
    """The validity maps: how far each method of the theory is from Monte Carlo, as pictures and as tables.

    Example: springpot validity --out figures
    """
    if threads is not None and not simulate_again:
        raise ValueError("--threads has no effect without --simulate-again: nothing is computed.")
    with leave_at_once():
        from springpot.evidence.reliability import PAPER_MAP, SYSTEMS_MAP
        from springpot.figures.style import save
        from springpot.figures.validity import plot_gaps_of_methods, plot_system_gaps_of_methods

    folder = Path(out)
    folder.mkdir(parents=True, exist_ok=True)
    source, of_systems = folder / PAPER_MAP.file.name, folder / SYSTEMS_MAP.file.name
    if simulate_again:
        from springpot.evidence.validity import CELLS, SYSTEM_CELLS, make_map
        from springpot.machine.record import Record

        record = Record(folder / "validity.record", "validity")  # of both maps, until both are written
        for what, cells, path in (("oscillators", CELLS, source), ("systems", SYSTEM_CELLS, of_systems)):
            with Bar(f"simulating the validity map of {what}") as bar:
                make_map(record, again=True, cells=cells, path=path, threads=threads, progress=bar)
        record.remove()
    else:
        source.write_bytes(PAPER_MAP.file.read_bytes())
        of_systems.write_bytes(SYSTEMS_MAP.file.read_bytes())
    print(source, of_systems, sep="\n")
    for moment, short in (("amplitude_mean_square", "amplitude"), ("x_mean", "mean"), ("impact_rate", "rate")):
        for along in ("restitution", "position"):
            print(save(plot_gaps_of_methods(moment, along, path=source), folder / f"validity_{short}_{along}.png"))
    for moment in ("x_mean_square", "v_mean_square", "impact_rate"):
        print(save(plot_system_gaps_of_methods(moment, path=of_systems), folder / f"validity_systems_{moment}.png"))
    return 0


@app.command
def explore(
    file: PageFile = None,
    *,
    port: Annotated[Whole, Parameter(help="Port to listen on; 0 takes any free port.")] = 8765,
    host: Annotated[str, Parameter(help="Numerical address to listen on; the default serves this computer only.")] = (
        "127.0.0.1"
    ),
    browser: Annotated[bool, Parameter(help="Open the page in the browser, or only print its address.")] = True,
) -> int:
    """Open a page in the browser: move a slider and watch the mass, the densities and every theory beside Monte Carlo.

    Example: springpot explore --port 0
    """
    from springpot.explorer.commands import open_file

    open_file(file, host=host, port=port, browser=browser)
    return 0


def place_of(out: str | None, overwrite: bool) -> Path | None:
    """Where --out writes to, checked before the work."""
    if overwrite and out is None:
        raise ValueError("--overwrite needs --out, the file to write to.")
    return None if out is None else place_for(Path(out), overwrite=overwrite)


def tell(found: Any, json_: bool, *written: Path | str | None, table: Sequence[Sequence[str]] = ()) -> int:
    """Print a result, which has ``to_dict`` and ``report``, and the files that were written; the status of the end."""
    if json_:
        print_json(found.to_dict())
        return 0
    print(found.report(warnings=False))
    if table:
        print_table(table)
    for file in filter(None, written):
        print(file)
    return 0


def warn(*sentences: str) -> None:
    """Print warnings of the library."""
    for sentence in sentences:
        say(f"warning: {in_flags(sentence)}")
