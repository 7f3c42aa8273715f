"""Common to all commands: types of flags, JSON, tables, and numbers with their errors."""

from __future__ import annotations

import contextlib
import json
import math
import warnings
from collections.abc import Iterator, Mapping, Sequence
from itertools import zip_longest
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import CoercionError, Parameter, Token

from springpot.machine.arguments import check_folder
from springpot.machine.bar import say
from springpot.machine.faults import per_cent, with_error
from springpot.machine.installed import need
from springpot.machine.plain import plain
from springpot.machine.trusted import CacheWarning
from springpot.problem.messages import FileWarning

if TYPE_CHECKING:
    from springpot.evidence.comparison import Gap


def _whole(type_: object, tokens: Sequence[Token]) -> int:
    """Cyclopts' own conversion rounds 2.5 to 2; a number of paths or a seed must be refused instead."""
    try:
        return int(tokens[0].value)
    except ValueError:
        raise CoercionError(token=tokens[0], target_type=int) from None


Whole = Annotated[int, Parameter(converter=_whole)]
Json = Annotated[bool, Parameter(name="--json", negative="", help="Print one JSON object and nothing else.")]


def check_picture(path: str | None, name: str = "plot") -> None:
    """Raise an error, before any work, if a picture that is asked for cannot be written to this path."""
    if path is None:
        return
    need("plots", "a picture")
    if not path.endswith(".png"):
        raise ValueError(f"{name} must end in .png, but it is {path!r}.")
    check_folder(Path(path), name)


def print_table(rows: Sequence[Sequence[str]]) -> None:
    widths = [max(map(len, column)) for column in zip_longest(*rows, fillvalue="")]
    for row in rows:
        print("".join(f"  {cell:<{width}}" for cell, width in zip(row, widths, strict=False)).rstrip())


def print_json(answer: Mapping[str, Any]) -> None:
    print(json.dumps(plain(answer), indent=2, allow_nan=False))


@contextlib.contextmanager
def warnings_as_sentences() -> Iterator[None]:
    """Context in which warnings of an unused cache and of files are one sentence, without their place in the code."""
    before = warnings.showwarning

    def show(message: Warning | str, category: type[Warning], *place: Any, **more: Any) -> None:
        if issubclass(category, CacheWarning | FileWarning):
            say(f"warning: {message}")
        else:
            before(message, category, *place, **more)

    with warnings.catch_warnings():
        warnings.showwarning = show
        yield


def gap(gap_of_method: Gap | None) -> str:
    if gap_of_method is None:
        return ""
    near = f"({gap_of_method.standard_errors:+.1f})"
    return f"{gap_of_method.percent:+.1f} % {near}" if math.isfinite(gap_of_method.percent) else near


def is_number(value: object) -> bool:
    return isinstance(value, float) and math.isfinite(value)


def in_words(value: object) -> str:
    if isinstance(value, Mapping):
        return ", ".join(f"{name} {in_words(part)}" for name, part in value.items())
    if isinstance(value, list | tuple):
        return " ".join(map(in_words, value))
    if value is None:
        return "none"
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def print_estimates(answer: Mapping[str, Any], units: Mapping[str, str], heavy: bool) -> None:
    """Estimates with a budget first, its parts in columns; then those with a standard error only.

    ``heavy``: with a mass, or per unit mass.
    """
    controlled = [name for name in units if f"{name}_error" in answer]
    rest = [name for name in units if name not in controlled]
    if controlled:
        columns = ("se", "step_bias", "memory_bias", "transient")
        rows = [
            [name, with_error(answer[name], answer[f"{name}_error"], units[name])]
            + [_plain_short(answer[f"{name}_{column}"]) for column in columns]
            for name in controlled
        ]
        print_table([["", "value +- total error (95 %)", "standard error", "step", "memory", "transient"], *rows, []])
    rows = []
    for name in rest:
        bound = answer.get(f"{name}_step_bias")
        bias = f"step bias up to {bound:.2g}" if bound else ""
        rows.append([name, with_error(answer[name], answer[f"{name}_se"], units[name]), bias])
    print_table([["", "value +- standard error"], *rows])
    rows = []  # one for each level, under its name such as ``x_first_passage``
    for name in [key.removesuffix("_survival") for key in answer if key.endswith("_first_passage_survival")]:
        levels = answer.get(f"{name}_level")
        middles = answer.get(f"{name}_reference") or ([None] * len(levels) if levels else [])
        wanted = *(f"{part}{end}" for part in _OF_PASSAGES for end in ("", "_se")), "rate_low", "rate_high"
        passed = [answer[f"{name}_{part}"] for part in wanted]
        each = zip(map(_level, levels, middles), *passed, strict=True) if levels else [("", *passed)]
        for level, *numbers, low, high in each:
            pairs = zip(numbers[::2], numbers[1::2], _OF_PASSAGES.values(), strict=True)
            rate = "none" if high is None else f"{low:.2g} to {high:.2g} s-1" if low else f"at most {high:.2g} s-1"
            rows.append([name + level, *(with_error(value, error, unit) for value, error, (_, unit) in pairs), rate])
    if rows:
        print()
        header = [*(words for words, _ in _OF_PASSAGES.values()), "rate once constant, 95 %"]
        print_table([["first passage +- standard error", *header], *rows])
    if "time_bin" in answer:
        from springpot.problem.catalogue import unit_of

        bins = zip(answer["time_bin"], answer["time_bin_width"], strict=True)
        head = [f"{middle - 0.5 * width:.6g} to {middle + 0.5 * width:.6g} s" for middle, width in bins]
        rows = [["in bins of time +- standard error", *head]]
        for name in (name for name in answer if name.endswith("_profile")):
            unit = unit_of(name, heavy) or "1"
            values = zip(answer[name], answer[f"{name}_se"], strict=True)
            rows.append([name.removesuffix("_profile"), *(with_error(value, error, unit) for value, error in values)])
        print()
        print_table(rows)
    if "probability" in answer:
        _print_quantiles(answer, units)


_OF_PASSAGES = {
    "mean": ("mean time", "s"),
    "restricted_mean": ("of times cut off at the end", "s"),
    "censored": ("share not passed", "1"),
    "at_start": ("share beyond at the start", "1"),
}


def _level(level: float, middle: float | None) -> str:
    """A level, or both ends of an interval of which it is half the width."""
    return f" {level:g}" if middle is None else f" {middle - level:g} to {middle + level:g}"


def _print_quantiles(answer: Mapping[str, Any], means: Mapping[str, str]) -> None:
    """Quantiles of distributions and extremes, one row for each probability in the middle and in the tails.

    ``means`` has the unit of the mean of a force, from which those of its extremes follow.
    """
    from springpot.problem.catalogue import unit_of

    names = [name.removesuffix("_quantile") for name in answer if name.endswith("_quantile")]
    names = [name for name in names if f"{name}_level" not in answer]  # of several levels there are many
    if not names:
        return
    units = {name: means.get(f"{name.rpartition('_')[0]}_mean") or unit_of(f"{name}_quantile") or "s" for name in names}
    shown = [i for i, p in enumerate(answer["probability"]) if p in (0.01, 0.05, 0.5, 0.95, 0.99)]
    rows = [["quantile +- standard error", *(per_cent(answer["probability"][i]) for i in shown)]]
    for name, unit in units.items():
        values, errors = answer[f"{name}_quantile"], answer[f"{name}_quantile_se"]
        rows.append([name, *(with_error(values[i], errors[i], unit) for i in shown)])
    for name in units:
        if (biases := answer.get(f"{name}_quantile_step_bias")) is not None:
            rows.append([f"{name}, step bias up to", *(_plain_short(biases[i]) for i in shown)])
    print()
    print_table(rows)


def _plain_short(value: float | None) -> str:
    return "none" if value is None else f"{value:.2g}"
