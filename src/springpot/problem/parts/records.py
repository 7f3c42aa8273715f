"""Records: forces and accelerations of the ground that were measured, and the files that hold them."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from operator import ge
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, get_args

from springpot.files.units import Decimal
from springpot.machine.arguments import LARGEST, checked_path, items_of, one_of
from springpot.machine.faults import FileError, listed
from springpot.problem.messages import warn_of_file
from springpot.problem.parts.checks import put, tabulated
from springpot.problem.parts.excitations import Excitation, On, Units
from springpot.problem.parts.registration import Number

if TYPE_CHECKING:
    from springpot.files.table import Stated

__all__ = ["RecordedExcitation"]

Points = tuple[float, ...]
Columns = Points | tuple[Points, ...]
Taken = Literal["in turn", "at random"]
"""Which of several records a path takes: that of its number, or one drawn by the seed."""
Interpolation = Literal["linear", "band-limited"]
"""What is between the points: straight lines, or the signal without content above half of the sampling rate."""

FEWEST_SAMPLES = 32  # of a file whose points are samples, if nothing else is said
_UNEVEN = 0.5  # of a step: times are rounded in files, but no point is missing


@dataclass(frozen=True)
class RecordedExcitation(Excitation):
    """A force or an acceleration of the ground that was recorded; 0 after the last point.

    Between the points are straight lines, or what was sampled there (``interpolation``).  A run begins at the first
    point.  Of several records each path has one.

    Parameters
    ----------
    time : tuple of float, or of one such tuple for each record
        Increasing, in s; at least two.
    values : tuple of float, or of one such tuple for each record
        One for each time, in N; per unit mass, and of the ground, in m/s^2.
    on : str
        The acceleration of the ``"ground"``, or a force on the ``"mass"``, or on one of several by its name.
    scale : float
        Factor on the values, above 0.
    taken : {"in turn", "at random"}
        Of several records path n has number n modulo how many there are, or one that the run's seed draws for it.
        With noise, results are means over these records, which count equally; standard errors say how well these means
        are known, and nothing of other records.  Without noise they are those over the records, as a sample of others.
    interpolation : {"linear", "band-limited"}
        Straight lines between the points, which are corners; or the signal of which these are samples at equal steps,
        without content above half of the sampling rate, as after the filter of a recorder.  Straight lines between
        samples of it lose 1 - (sin(u) / u)^2, u = pi frequency / rate, of its size: 4 % at 9 points in a period.

    Raises
    ------
    TypeError, ValueError
        If the times do not increase, the two have different lengths, something is not a finite number, or samples do
        not follow at equal steps.

    Examples
    --------
    >>> record = RecordedExcitation((0.0, 1.0, 2.0), (0.0, 3.0, 0.0))
    >>> record.duration, record.mean_square
    (2.0, 3.0)
    >>> RecordedExcitation((0.0, 1.0, 2.0), ((0.0, 3.0, 0.0), (0.0, -1.0, 2.0))).count
    2
    """

    said, glyph, powers = "recorded excitation", "rough", ("fed",)
    is_odd = False

    time: Annotated[Columns, Number("t", "time", "s", own=True)]
    values: Annotated[Columns, Number("a", "values", "N", turns=True, own=True)]
    on: On = "ground"
    scale: Annotated[float, Number("×", "the record times", "1", "positive", "It is a factor on the record.")] = field(
        default=1.0, kw_only=True
    )
    taken: Taken = field(default="in turn", repr=False, kw_only=True)
    interpolation: Interpolation = field(default="linear", repr=False, kw_only=True)

    def __post_init__(self) -> None:
        one_of(self.taken, "taken", get_args(Taken))
        one_of(self.interpolation, "interpolation", get_args(Interpolation))
        if _is_nested(self.values):
            own: list[Any] = [*self.values]
            times = _times(self.time, len(own))
            if len(times) != len(own):
                raise ValueError(
                    f"time must be one list for all records, or one for each of {len(own)}, not {len(times)}."
                )
            checked = [_checked(t, a, f"record {n}: ") for n, (t, a) in enumerate(zip(times, own, strict=True))]
            shared = all(each["time"] == checked[0]["time"] for each in checked)
            put(
                self, values=tuple(each["values"] for each in checked),
                time=checked[0]["time"] if shared else tuple(each["time"] for each in checked),
            )  # fmt: skip
        else:
            put(self, **_checked(self.time, self.values, ""))
        if self.interpolation == "band-limited":
            for n, (time, _) in enumerate(self.records):
                if not _is_even(time):
                    which = f"record {n}: " if self.count > 1 else ""
                    raise ValueError(f"{which}interpolation must be 'linear' where points are not at equal steps.")
        super().__post_init__()

    @classmethod
    def from_file(
        cls, path: str | Path | Sequence[str | Path], *, rate: float | None = None, unit: str = "",
        columns: Sequence[str] | Mapping[str, str] | None = None, decimal: Decimal = "", scale: float = 1.0,
        on: str = "", taken: Taken = "in turn", interpolation: Interpolation | None = None,
    ) -> RecordedExcitation:  # fmt: skip
        """The records in one file or several, whose kind is found from the content.

        Parameters
        ----------
        path : str, Path or sequence of them
            Tables in text, whose header has names and units, such as ``time_s,acceleration_g`` or
            ``Time (sec);Acc (G)``; records of PEER (.AT2) and in the SMC or COSMOS format; universal files (dataset
            58) and MATLAB files.  Each column of an acceleration or of a force is a record.  Of 32 points or more,
            times that are rounded to some decimals are taken for those of the rate.
        rate : float, optional
            Samples per second, of files without times.
        unit : str, optional
            Of the values, where a file does not say it.
        columns : sequence of str or mapping, optional
            A header for each column of a file without one, such as ``["time_s", "acceleration_g"]``, empty for one that
            is left out; or headers by the names in the file, of the columns that are wanted.
        decimal : {".", ","}, optional
            The decimal mark, where it cannot be told.
        scale : float
            Factor on the values.
        on : str
            The mass on which a force acts, by its name, where there are several.
        taken : {"in turn", "at random"}
            Which of several records a path has.
        interpolation : {"linear", "band-limited"}, optional
            What is between the points.  If it is not given, records of 32 points or more at equal steps are samples of
            a signal, ``"band-limited"``, and shorter or uneven ones corners with straight lines between them.

        Returns
        -------
        RecordedExcitation

        Raises
        ------
        FileNotFoundError
            If there is no such file.
        TypeError, ValueError
            One sentence that says what is wrong in it, and what to do.

        Warns
        -----
        FileWarning
            With what was assumed, in one line.

        Examples
        --------
        >>> import tempfile
        >>> place = Path(tempfile.mkdtemp()) / "ground.csv"
        >>> _ = place.write_text("acceleration_cm/s2,acceleration_cm/s2\\n0,0\\n50,-20\\n0,10\\n")
        >>> RecordedExcitation.from_file(place, rate=100.0)
        RecordedExcitation(time=(0.0, 0.01, 0.02), values=((0.0, 0.5, 0.0), (0.0, -0.2, 0.1)), on='ground', scale=1.0)
        """
        from springpot.files.table import Stated

        given = (path,) if isinstance(path, str | Path) else items_of(path, "path must be a file, or a list of them")
        places = [checked_path(place, "path") for place in given]
        stated = Stated(unit, columns, rate, decimal)
        if not places:
            raise ValueError("path must be a file, or a list of at least one.")
        read = [_read(place, stated) for place in places]
        if len(kinds := {kind for _, _, kind, _ in read}) > 1:
            raise FileError(
                f"the files {listed([repr(str(place)) for place in places])} must all hold accelerations, or forces."
            )
        ground = kinds == {"a"}
        if ground and on not in ("", "ground"):
            raise ValueError("on must be left out of a record of an acceleration, which is that of the ground.")
        if not ground and on == "ground":
            raise ValueError("on must be a mass for a record of a force.")
        records = [(time, values) for time, own, *_ in read for values in own]
        times, values = (tuple(each) if len(each) > 1 else each[0] for each in zip(*records, strict=True))
        sampled = all(len(time) >= FEWEST_SAMPLES and _is_even(time) for time, _ in records)
        between: Interpolation = interpolation or ("band-limited" if sampled else "linear")
        place = "ground" if ground else on or "mass"
        for name, (*_, notes) in zip(places, read, strict=True):
            warn_of_file(f"record file {str(name)!r}", notes)
        return cls(times, values, place, scale=scale, taken=taken, interpolation=between)

    @property
    def records(self) -> tuple[tuple[Points, Points], ...]:
        """Times and values of each, without the scale."""
        if not _is_nested(self.values):
            return ((self.time, self.values),)  # type: ignore[return-value]
        return tuple(zip(_times(self.time, len(self.values)), self.values, strict=True))  # type: ignore[arg-type]

    @property
    def count(self) -> int:
        """How many records it has."""
        return len(self.records)

    @property
    def is_drawn(self) -> bool:
        """Whether chance decides which record a path has."""
        return self.taken == "at random" and self.count > 1

    @property
    def is_random(self) -> bool:
        """Where chance decides which record a path has."""
        return self.is_drawn

    @property
    def duration(self) -> float:
        """From the first point to the last of the longest, in s."""
        return max(time[-1] - time[0] for time, _ in self.records)

    @property
    def mean_square(self) -> float:
        """Of the values, over the time of each record, and over the records."""
        of_one = _mean_square if self.interpolation == "linear" else _mean_of_squares
        return self.scale**2 * math.fsum(of_one(*record) for record in self.records) / self.count

    def fed_into(self, frequency: float, rate: Callable[[], float], square: float) -> float:
        """As noise that is white up to this frequency."""
        return 0.5 * math.pi * self.mean_square / frequency

    def words(self, name: str, unit: Units) -> str:
        """What it is."""
        rms = f"root mean square {math.sqrt(self.mean_square):.6g} {unit('values')}"
        what = "a record" if self.count == 1 else f"{self.count} records, taken {self.taken},"
        return f"{what} of {self.duration:.6g} s ({name}), {rms}"


def _is_nested(columns: Any) -> bool:
    first = next(iter(columns), None) if _is_iterable(columns) else None
    return first is not None and _is_iterable(first)


def _is_iterable(value: Any) -> bool:
    """Whether it has items, as an array without a dimension has none, though it seems so."""
    return hasattr(value, "__iter__") and not isinstance(value, str) and getattr(value, "ndim", 1) != 0


def _times(time: Any, count: int) -> list[Any]:
    """Those of each record, which may be the same of all."""
    return [*time] if _is_nested(time) else [time] * count


def _checked(time: Any, values: Any, which: str) -> dict[str, Points]:
    try:
        found = tabulated(time, values, "It is a point of the record.")
        if any(map(ge, found["time"], found["time"][1:])):
            raise ValueError("time must increase from each point to the next.")
    except (TypeError, ValueError) as fault:
        raise type(fault)(f"{which}{fault}") from None
    return found


def _mean_square(time: Points, values: Points) -> float:
    pieces = zip(time, time[1:], values, values[1:], strict=False)
    return math.fsum((t1 - t0) * (a * a + a * b + b * b) / 3.0 for t0, t1, a, b in pieces) / (time[-1] - time[0])


def _mean_of_squares(time: Points, values: Points) -> float:
    """Of samples at equal steps, those at the ends by half."""
    return (math.fsum(a * a for a in values) - 0.5 * (values[0] ** 2 + values[-1] ** 2)) / (len(values) - 1)


def _is_even(time: Points) -> bool:
    """Whether the points are at equal steps."""
    import numpy as np  # slow to import

    from springpot.machine.sampling import are_even

    return are_even(np.array(time))


def _read(path: str | Path, stated: Stated) -> tuple[Points, list[Points], str, list[str]]:
    """The times of a file in s, its columns in m/s^2 or N, which of the two they are, and what was assumed."""
    import numpy as np  # slow to import

    from springpot.files.reading import read_table
    from springpot.machine.sampling import equal_steps

    title = f"record file {str(path)!r}"
    table = read_table(path, title, stated)
    times, kinds = table.of("time"), {column.quantity for column in table.columns} - {"time"}
    if len(times) > 1:
        raise FileError(f"{title} has {len(times)} columns of the time, and a record has one: leave out the others.")
    if len(kinds) != 1 or not kinds <= {"a", "force"}:
        named = [column.header for column in table.columns if column.quantity != "time"]
        what = "no column of an acceleration or a force" if not {"a", "force"} & kinds else f"columns {listed(named)}"
        raise FileError(f"{title} has {what}: its header must be such as time_s,acceleration_g or time_s,force_N, and "
                        "columns= takes those that are meant.")  # fmt: skip
    rate = table.sampled_at(stated.rate)
    columns = table.alike(kind := kinds.pop(), stated)
    for column in (*times, *columns):
        if (wrong := ~(np.abs(column.values) <= LARGEST)).any():
            row = int(wrong.argmax())
            raise FileError(f"{table.where(row)}: {column.header} must be a finite number, not {column.values[row]}.")
    if (count := len(columns[0].values)) < 2:
        raise FileError(f"{title} has {count} points below its header: a record needs two or more.")
    own = [tuple(column.values.tolist()) for column in columns]
    if rate is not None:
        return tuple((np.arange(count) / rate).tolist()), own, kind, table.notes
    time = times[0].values
    if count >= FEWEST_SAMPLES and (np.diff(time) > 0.0).all() and (even := equal_steps(time)) is not None:
        return tuple(even.tolist()), own, kind, table.notes
    steps, usual = np.diff(time), float(np.median(np.diff(time)))
    if not usual > 0.0 or (wrong := np.abs(steps - usual) > _UNEVEN * usual).any():
        place = int(np.argmax(wrong)) if usual > 0.0 else 0
        raise FileError(
            f"{table.where(place + 1)}: the time goes on by {steps[place]:.6g} s, and by {usual:.6g} s "
            "in most other lines: fill the gap, or give the points to RecordedExcitation(time, values)."
        )
    return tuple(time.tolist()), own, kind, table.notes
