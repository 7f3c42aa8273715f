"""Check of a number that a user gives, numbers that are marked as free, and the arguments of a user's function."""

from __future__ import annotations

import inspect
import keyword
import math
import numbers
import os
import unicodedata
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from springpot.machine.faults import few, meant, shown
from springpot.machine.platforms import wrong_letters

if TYPE_CHECKING:
    import numpy.typing as npt

    from springpot.machine.arrays import Floats

# NumPy is loaded where there are arrays: the command's help needs none

MOST_LETTERS = 100  # of a name
MOST_BYTES = 255  # of the name of a file, on every system of files
LARGEST = 1e50  # of any number of a problem: squares, cubes and their ratios stay far from the ends of double precision


_ROUNDED = 1e-12  # of the sizes of two multiples, below which their difference is rounding


class Free(float):
    """A number to be found, marked by `springpot.free`: everywhere else it is the number at which the search starts.

    Parameters
    ----------
    start : float
        The number that it is.
    name : str
    low, high : float
        Its bounds.
    times, plus, power : float
        It is ``times * number ** power + plus`` of the number of that name; ``low`` and ``high`` are those of the
        result.

    Notes
    -----
    A free number plus, minus, times or over a plain one is free too, so that one number may stand at several places; so
    is a power of one with positive bounds, and the sum of two multiples of one.  Other arithmetic, as with two free
    numbers, gives what is `Lost`, which parts refuse.  Functions of `math` and of NumPy give plain numbers, and so does
    a number of NumPy that stands on the left.

    Examples
    --------
    >>> gap = Free(0.004, "gap", 0.001, 0.006)
    >>> gap, gap == 0.004, gap.high
    (free('gap', 0.004, (0.001, 0.006)), True, 0.006)
    >>> -gap
    -free('gap', 0.004, (0.001, 0.006))
    >>> stiffness = 2.0 * Free(3.0, "frequency", 1.0, 4.0) ** 2
    >>> stiffness == 18.0, stiffness.high, stiffness.itself.high
    (True, 32.0, 4.0)
    """

    __slots__ = ("high", "low", "name", "plus", "power", "times")
    name: str
    low: float
    high: float
    times: float
    plus: float
    power: float

    def __new__(
        cls,
        start: float,
        name: str,
        low: float,
        high: float,
        times: float = 1.0,
        plus: float = 0.0,
        power: float = 1.0,
    ) -> Free:
        number = super().__new__(cls, start)
        number.name, number.low, number.high = name, low, high
        number.times, number.plus, number.power = times, plus, power
        return number

    def __getnewargs__(self) -> tuple[Any, ...]:
        return float(self), self.name, self.low, self.high, self.times, self.plus, self.power

    def __repr__(self) -> str:
        if self.itself is not self:
            times = {1.0: "", -1.0: "-"}.get(self.times, f"{self.times!r} * ")
            power = f" ** {self.power!r}" if self.power != 1.0 else ""
            return f"{times}{self.itself!r}{power}" + (f" + {self.plus!r}" if self.plus else "")
        return f"free({self.name!r}, {float(self)!r}, ({self.low!r}, {self.high!r}))"

    @property
    def itself(self) -> Free:
        """The number of that name, from which this one follows."""
        if (self.times, self.plus, self.power) == (1.0, 0.0, 1.0):
            return self
        low, start, high = (
            ((number - self.plus) / self.times) ** (1.0 / self.power) for number in (self.low, float(self), self.high)
        )
        return self._made(start, low, high)

    def at(self, value: float) -> float:
        """What stands here where the number of that name has a value; an uncertain one stays uncertain."""
        own = value if isinstance(value, Uncertain) else float(value)
        return self.times * (own if self.power == 1.0 else own**self.power) + self.plus

    @property
    def slope(self) -> float:
        """The derivative of what stands here by the number of that name."""
        return float(self.times * self.power * float(self.itself) ** (self.power - 1.0))

    def moved_to(self, value: float) -> Free:
        """The same with another start, as it stands here."""
        return self._made(value, self.low, self.high, self.times, self.plus, self.power)

    def _made(
        self, start: float, low: float, high: float, times: float = 1.0, plus: float = 0.0, power: float = 1.0
    ) -> Free:
        """Another number of this kind that follows from the one of that name."""
        law = self.__getnewargs__()[7:]  # of an uncertain one
        return type(self)(start, self.name, min(low, high), max(low, high), times, plus, power, *law)

    def _linear(self, times: Any, plus: Any) -> Any:
        if not _are_plain(times, plus) or not times or not math.isfinite(times + plus):
            return NotImplemented
        low, start, high = (float(times * each + plus) for each in (self.low, float(self), self.high))
        return self._made(start, low, high, float(times * self.times), float(times * self.plus + plus), self.power)

    def __neg__(self) -> Any:
        return self._linear(-1.0, 0.0)

    def __mul__(self, other: Any) -> Any:
        return _or_plain(self._linear(other, 0.0), float.__mul__, self, other)

    def __add__(self, other: Any) -> Any:
        if isinstance(other, Free) and self._is_multiple_of(other):
            return self._with(other)
        return _or_plain(self._linear(1.0, other), float.__add__, self, other)

    def _is_multiple_of(self, other: Free) -> bool:
        """Whether both are multiples of the same power of one number, of which nothing differs."""
        if (type(other), other.name, other.power) != (type(self), self.name, self.power):
            return False
        one, same = self.itself, other.itself
        pairs = (float(one), float(same)), (one.low, same.low), (one.high, same.high)
        return all(math.isclose(a, b, rel_tol=1e-9, abs_tol=1e-9 * (one.high - one.low)) for a, b in pairs)

    def _with(self, other: Free) -> Any:
        """The sum with a multiple of the number of that name."""
        times, plus, own = self.times + other.times, self.plus + other.plus, self.itself
        if abs(times) < _ROUNDED * (abs(self.times) + abs(other.times)):
            return plus
        low, start, high = (times * float(each) ** self.power + plus for each in (own.low, float(own), own.high))
        return self._made(start, low, high, times, plus, self.power)

    def __sub__(self, other: Any) -> Any:
        if isinstance(other, Free):
            return self + -other
        return _or_plain(self._linear(1.0, -other if _are_plain(other) else None), float.__sub__, self, other)

    def __rsub__(self, other: Any) -> Any:
        return _or_plain(self._linear(-1.0, other), float.__rsub__, self, other)

    def __truediv__(self, other: Any) -> Any:
        return _or_plain(
            self._linear(1.0 / other if _are_plain(other) and other else None, 0.0), float.__truediv__, self, other
        )

    def __pow__(self, other: Any, modulus: None = None) -> Any:
        plain = _are_plain(other) and other and math.isfinite(other)
        if plain and other == 1.0:
            return self
        if not plain or self.plus or not (self.low > 0.0 and self.times > 0.0):
            found = float.__pow__(self, other)
            return _lost(found, self) if plain else _or_lost(found, self, other)
        low, start, high = (float(each**other) for each in (self.low, float(self), self.high))
        return self._made(start, low, high, float(self.times**other), 0.0, float(self.power * other))

    def __rtruediv__(self, other: Any) -> Any:
        if _are_plain(other) and other:
            return other * self**-1.0
        return _or_lost(float.__rtruediv__(self, other), self, other)

    def __pos__(self) -> Any:
        return self

    def __abs__(self) -> Any:
        return self if self.low >= 0.0 else -self if self.high <= 0.0 else _lost(float.__abs__(self), self)

    __rmul__, __radd__ = __mul__, __add__


class Uncertain(Free):
    """A number that differs from device to device, marked by `springpot.uncertain`: everywhere else it is its nominal
    value.

    Parameters
    ----------
    start : float
        The nominal value.
    name : str
    low, high : float
        Between which all values lie.
    times, plus, power : float
        As of `Free`.
    law : object
        Of the number of that name: ``law.ppf(u)`` are its quantiles.

    Notes
    -----
    Arithmetic is that of a free number.
    """

    __slots__ = ("correlation", "law")
    law: Any
    correlation: tuple[tuple[str, float], ...]

    def __new__(
        cls, start: float, name: str, low: float, high: float, times: float = 1.0, plus: float = 0.0,
        power: float = 1.0, law: Any = None, correlation: tuple[tuple[str, float], ...] = (),
    ) -> Uncertain:  # fmt: skip
        number: Uncertain = super().__new__(cls, start, name, low, high, times, plus, power)  # type: ignore[assignment]
        number.law, number.correlation = law, correlation
        return number

    def __getnewargs__(self) -> tuple[Any, ...]:
        return *super().__getnewargs__(), self.law, self.correlation

    def __repr__(self) -> str:
        if self.itself is not self:
            return super().__repr__()
        return f"uncertain({self.name!r}, {float(self)!r}, {self.law})"


class Lost(float):
    """What an expression gives that does not follow the marked numbers in it, such as two of them, or an exponent.

    Everywhere but in a part it is a plain number, and so is what is made of it.

    Parameters
    ----------
    value : float
    names : tuple of str
        Of the marked numbers in it.

    Examples
    --------
    >>> k, m = Uncertain(80.0, "k", 70.0, 90.0), Uncertain(2.0, "m", 1.9, 2.1)
    >>> 0.5 * (k / m), (0.5 * (k / m)).names
    (20.0, ('k', 'm'))
    """

    __slots__ = ("names",)
    names: tuple[str, ...]

    def __new__(cls, value: float, names: tuple[str, ...]) -> Lost:
        number = super().__new__(cls, value)
        number.names = names
        return number

    def __getnewargs__(self) -> tuple[Any, ...]:
        return float(self), self.names


def _loses(name: str) -> Callable[..., Any]:
    """An operation of plain numbers whose result follows none of the marked ones in it."""
    plain = getattr(float, name)
    return lambda *given: _lost(plain(*given), *(each for each in given if isinstance(each, Free | Lost)))


for _name in ("neg", "pos", "abs", *(f"{side}{name}" for side in ("", "r") for name in
                                     ("add", "sub", "mul", "truediv", "pow", "floordiv", "mod"))):  # fmt: skip
    setattr(Lost, f"__{_name}__", _loses(f"__{_name}__"))
for _name in ("rpow", "floordiv", "rfloordiv", "mod", "rmod"):
    setattr(Free, f"__{_name}__", _loses(f"__{_name}__"))


def _are_plain(*given: Any) -> bool:
    return all(isinstance(each, numbers.Real) and not isinstance(each, bool | Free | Lost) for each in given)


def _or_plain(found: Any, plain: Any, *numbers: Any) -> Any:
    return _or_lost(plain(*numbers), *numbers) if found is NotImplemented else found


def _or_lost(found: Any, *numbers: Any) -> Any:
    """A result that no longer follows a marked number in it: that of two marked ones, or of a lost one, is lost."""
    marked = [each for each in numbers if isinstance(each, Free | Lost)]
    return found if len(marked) < 2 and isinstance(marked[0], Free) else _lost(found, *marked)


def _lost(found: Any, *marked: Free | Lost) -> Any:
    if type(found) is not float:
        return found
    names = (name for each in marked for name in (each.names if isinstance(each, Lost) else (each.name,)))
    return Lost(found, tuple(dict.fromkeys(names)))


def finite_number(
    value: object, name: str, *, low: float = -math.inf, high: float = math.inf, open_low: bool = False, hint: str = ""
) -> float:
    """Return ``value`` as a float, or raise one sentence that names the argument and its allowed range.

    A `Free` number is returned as it is; its bounds must be allowed too.  An array without an axis is its number.

    Parameters
    ----------
    value : object
        What the caller gave.
    name : str
        The argument's name, for the message.
    low, high : float
        Allowed range, ends included; with ``open_low`` the lower end is excluded.
    hint : str
        What the argument means, appended to the message.

    Raises
    ------
    TypeError
        If ``value`` is not a real number (strings and booleans are not).
    ValueError
        If it is NaN, infinite or outside the range.

    Examples
    --------
    >>> finite_number(2, "duration", low=0.0)
    2.0
    """
    hint = f" {hint}" if hint else ""
    value = without_axis(value)
    if isinstance(value, bool) or not isinstance(value, numbers.Real):
        raise TypeError(f"{name} must be a real number, not {shown(value)} ({type(value).__name__}).{hint}")
    try:
        number = float(value)
    except OverflowError:  # a whole number beyond double precision
        number = math.inf
    inside = (number > low if open_low else number >= low) and number <= high
    if not math.isfinite(number) or not inside:
        raise ValueError(f"{name} must be {_range(low, high, open_low)}, not {number:g}.{hint}")
    if isinstance(value, Free):
        for bound in (value.low, value.high):
            try:
                finite_number(bound, name, low=low, high=high, open_low=open_low)
            except ValueError as fault:
                kind = "uncertain number {}: give bounds=" if isinstance(value, Uncertain) else "free number {}"
                raise ValueError(f"{fault} This is a bound of the {kind.format(value.name)}.") from None
        return value
    return number


def positive_number(value: object, name: str, hint: str = "") -> float:
    """That of `finite_number` above 0, as most numbers of a problem are."""
    return finite_number(value, name, low=0.0, high=LARGEST, open_low=True, hint=hint)


def check_whole(value: object, name: str, low: int, high: int) -> None:
    """Raise one sentence unless ``value`` is a whole number within its range.

    Raises
    ------
    ValueError
        If it is not.

    Examples
    --------
    >>> check_whole(0, "walkers", 1, 8)
    Traceback (most recent call last):
    ValueError: walkers must be a whole number from 1 to 8, not 0.
    """
    if isinstance(value, bool) or not isinstance(value, numbers.Integral) or not low <= int(value) <= high:
        raise ValueError(f"{name} must be a whole number from {low} to {high}, not {shown(value)}.")


def without_axis(value: Any) -> Any:
    """The number in an array that has no axis, such as a quantile of a run; anything else as it is.

    Examples
    --------
    >>> import numpy as np
    >>> without_axis(np.array(0.5)), without_axis([0.5])
    (0.5, [0.5])
    """
    return value.item() if getattr(value, "ndim", None) == 0 and not isinstance(value, numbers.Real) else value


def check_plain(value: object, name: str, instead: str) -> None:
    """Refuse a number, or a list with one, that is marked as free or uncertain, where what is made of it cannot follow.

    Parameters
    ----------
    value : object
        A list may hold lists.
    name : str
        The argument's name, for the message.
    instead : str
        What to do, in words.

    Raises
    ------
    ValueError
        With the marked number's name.

    Examples
    --------
    >>> check_plain(Free(0.2, "alpha", 0.1, 0.3), "order", "mark the coefficient")
    Traceback (most recent call last):
    ValueError: order must be a plain number here, not the free number alpha: mark the coefficient.
    """
    if isinstance(value, Free):
        kind = "uncertain" if isinstance(value, Uncertain) else "free"
        raise ValueError(f"{name} must be a plain number here, not the {kind} number {value.name}: {instead}.")
    if isinstance(value, Lost):
        raise ValueError(f"{name} must be a plain number here, not one of {' and '.join(value.names)}: {instead}.")
    if isinstance(value, list | tuple) and not {*map(type, value)} <= {float, int}:
        for each in value:
            check_plain(each, name, instead)


def checked_name(value: object, label: str, wanted: str = "be a word of letters, digits and _") -> str:
    """Return ``value`` if it can be a name in Python and in results, or raise one sentence.

    Parameters
    ----------
    value : object
        What the caller gave.
    label : str
        The argument, for the message.
    wanted : str
        What it must be, or do, in words.

    Raises
    ------
    ValueError
        If it is no word of letters, digits and _, is too long, a keyword, or would be another name in Python's own
        writing, Unicode's NFKC: ``run.name`` would not find it, and two names that look alike would be two parts.

    Examples
    --------
    >>> checked_name("lower_stop", "name")
    'lower_stop'
    """
    if not isinstance(value, str) or not value.isidentifier():
        raise ValueError(f"{label} must {wanted}, not {shown(value)}.")
    if len(value) > MOST_LETTERS:
        raise ValueError(f"{label} must have at most {MOST_LETTERS} letters, not {len(value)}.")
    if keyword.iskeyword(value):
        raise ValueError(f"{label} must not be {value!r}, a keyword of Python: {value}_ can be a name.")
    if (usual := unicodedata.normalize("NFKC", value)) != value:
        raise ValueError(f"{label} must be {usual!r}, in the letters that Python makes of {value!r}.")
    return value


def numbers_in_array(value: Any, must: str, kind: type = float) -> npt.NDArray[Any]:
    """An array of numbers of whatever NumPy makes one of, or a TypeError that begins with ``must``.

    Examples
    --------
    >>> numbers_in_array([1, 2], "masses must be numbers")
    array([1., 2.])
    """
    import numpy as np

    try:
        with np.errstate(all="ignore"):
            return np.array(value, dtype=kind)
    except Exception:  # of a list that is ragged, a number beyond double precision, or an object that fails as it likes
        raise TypeError(f"{must}, not {shown(value)}.") from None


def finite_numbers(value: Any, label: str, each: str, **limits: Any) -> Floats:
    """One number or a list of them, of any shape, all in the same range, or an error of one sentence.

    Parameters
    ----------
    value : object
        What the caller gave.
    label, each : str
        All of them, and one of them, for the message.
    **limits
        Of `finite_number`.

    Raises
    ------
    TypeError, ValueError
        If there is none, or one is not such a number.

    Examples
    --------
    >>> finite_numbers([1, 2.5], "levels of x", "level of x", low=0.0)
    array([1. , 2.5])
    """
    import numpy as np

    given = numbers_in_array(value, f"{label} must be a number or a list of numbers", object)
    if not given.size:
        raise ValueError(f"{label} must not be empty.")
    return np.array([finite_number(number, each, **limits) for number in given.flat]).reshape(given.shape)


def real_array(value: Any, name: str) -> Floats:
    """Real numbers as an array of floats; ``name`` is the argument's name in the error.

    Raises
    ------
    TypeError
        If a value is not a real number (strings, booleans and complex numbers are not).

    Examples
    --------
    >>> real_array([1, 2], "speed")
    array([1., 2.])
    """
    must = f"{name} must be a real number or an array of them"
    if str(getattr(getattr(value, "dtype", None), "kind", "O")) in "iuf":
        return numbers_in_array(value, must)
    array = numbers_in_array(value, must, object)
    flat = [without_axis(each) for each in array.ravel().tolist()]
    real = all(isinstance(each, numbers.Real) and not isinstance(each, bool) for each in flat)
    if isinstance(value, str | bytes) or not real:
        raise TypeError(f"{must}, not {shown(value)}.")
    return numbers_in_array(array, must)


def finite_array(value: Any, name: str) -> Floats:
    """Finite real numbers as an array of floats; ``name`` is the argument's name in the error.

    Raises
    ------
    TypeError, ValueError
        If a value is not a real number, or is NaN or infinite.

    Examples
    --------
    >>> finite_array(1, "lag")
    array(1.)
    """
    import numpy as np

    array = real_array(value, name)
    if not np.all(np.isfinite(array)):
        raise ValueError(f"{name} must be finite.")
    return array


def items_of(value: Any, must: str) -> tuple[Any, ...]:
    """The items of a list, a tuple or an array, or a TypeError that begins with ``must``; a text has none.

    Examples
    --------
    >>> items_of([1.0, 2.0], "times must be a list of numbers")
    (1.0, 2.0)
    """
    if not isinstance(value, str | bytes | dict):
        try:
            return tuple(value.tolist() if type(value).__name__ == "ndarray" else value)
        except TypeError:
            pass
    raise TypeError(f"{must}, not {shown(value)}.")


def one_of(value: Any, name: str, words: Sequence[Any], hint: str = "") -> Any:
    """One of some words or numbers, and of its type; what cannot be compared is none.

    Examples
    --------
    >>> one_of("Hz", "unit", ("Hz", "kHz"))
    'Hz'
    """
    if not any(type(value) is type(word) and value == word for word in words):
        more = f" {hint}" if hint else ""
        raise ValueError(f"{name} must be {' or '.join(map(repr, words))}, not {shown(value)}.{more}")
    return value


def text(value: object, name: str) -> str:
    """A text, such as a name, that is looked up later.

    Examples
    --------
    >>> text("box", "of")
    'box'
    """
    if not isinstance(value, str):
        raise TypeError(f"{name} must be a name, not {shown(value)}.")
    return value


def switch(value: object, name: str) -> bool:
    """True or False.

    Examples
    --------
    >>> switch(True, "overwrite")
    True
    """
    if not isinstance(value, bool):
        raise TypeError(f"{name} must be True or False, not {shown(value)}.")
    return value


def check_called(value: object, name: str, what: str = "a function of the fraction done") -> None:
    """That what is called later, if it is given, is a function.

    Examples
    --------
    >>> check_called(None, "progress")
    """
    if value is not None and not callable(value):
        raise TypeError(f"{name} must be {what}, not {shown(value)}.")


def checked_path(value: Any, name: str) -> Path:
    """The place of a file or folder.

    Examples
    --------
    >>> checked_path("run.nc", "path").suffix
    '.nc'
    """
    if not isinstance(value, str | os.PathLike) or not isinstance(place := os.fspath(value), str):
        raise TypeError(f"{name} must be the place of a file, as a text or a Path, not {shown(value)}.")
    if "\0" in place:
        raise ValueError(f"{name} must be the place of a file, and {shown(place)} has a null character.")
    try:
        os.fsencode(place)
    except UnicodeEncodeError:  # of half a character
        raise ValueError(f"{name} must be the place of a file, and {place!r} is no text.") from None
    if (longest := max((len(part.encode("utf-8", "replace")) for part in Path(place).parts), default=0)) > MOST_BYTES:
        raise ValueError(f"{name} must be the place of a file: no name has {longest} bytes, but {MOST_BYTES} at most.")
    if wrong := wrong_letters(Path(place)):
        raise ValueError(f"{name} must be the place of a file: no name has {' or '.join(wrong)} in Windows.")
    return Path(place)


def check_folder(path: Path, name: str) -> None:
    """That a file can be put at a path: its folder exists.

    Examples
    --------
    >>> check_folder(Path("run.nc"), "the file")
    """
    if not path.absolute().parent.is_dir():
        raise ValueError(f"{name} must lie in a folder that exists, but {str(path.parent)!r} does not.")


def place_for(path: str | Path, *, overwrite: bool = False) -> Path:
    """The path of an output file, if it may be written.

    Parameters
    ----------
    path : str or Path
    overwrite : bool
        Whether a file that is there may be replaced.

    Returns
    -------
    Path

    Raises
    ------
    ValueError
        If its folder does not exist, something else than a file is in its place, or a file is there and ``overwrite``
        was not given.

    Examples
    --------
    >>> import tempfile
    >>> place = Path(tempfile.mkdtemp()) / "run.nc"
    >>> place_for(place) == place
    True
    """
    place, name = checked_path(path, "path"), str(path)
    switch(overwrite, "overwrite")
    if not place.absolute().parent.is_dir():
        raise ValueError(f"{name!r} cannot be written: the folder {str(place.parent)!r} does not exist.")
    if place.exists() and not place.is_file():
        raise ValueError(f"{name!r} cannot be written: it is a folder or another thing that is not a file.")
    if place.exists() and not overwrite:
        raise ValueError(f"{name!r} exists already: give another name, or overwrite=True to replace it.")
    return place


def _range(low: float, high: float, open_low: bool) -> str:
    if math.isinf(low) and math.isinf(high):
        return "a finite number"
    if math.isinf(high):
        return f"a finite number {'greater than' if open_low else 'at least'} {low:g}"
    return f"in {'(' if open_low else '['}{low:g}, {high:g}]"


def named_arguments(
    who: str, function: Callable[..., float], known: Iterable[str], what: str, most: int = 0
) -> list[str]:
    """The names of the arguments of a user's function, which say what it takes, if all are known.

    Parameters
    ----------
    who : str
        The function, as the subject of a sentence.
    function : callable
    known : iterable of str
    what : str
        What an unknown name is.
    most : int
        How many it may have; 0: any number.

    Raises
    ------
    ValueError
        With the nearest of the known ones.

    Examples
    --------
    >>> named_arguments("minimize", lambda x_mean: 2.0 * x_mean, ["c", "x_mean"], "no result")
    ['x_mean']
    """
    names, words = [*known], [*inspect.signature(function).parameters]
    for word in words:
        if word not in names:
            near = meant(word, names) or f"; there are {few(sorted(names))}."
            raise ValueError(f"{who} has an argument {word!r}, which is {what}{near}")
    if not words or (most and len(words) > most):
        raise ValueError(f"{who} must have {'one argument' if most else 'an argument'}: {few(sorted(names))}.")
    return words
