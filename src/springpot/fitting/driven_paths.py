"""What a model under a measured input makes of a record, and its derivatives by all numbers.

The numbers are those of the model and those of the record: an offset of each point, the delay, and x and v of each
coordinate at the first sample.  Derivatives are differences of paths that run in neighbouring lanes of one block.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from springpot.fitting.motion_data import MOST_DELAY, MeasuredRecord
from springpot.fitting.spectral_density import row_of
from springpot.machine.arguments import Free
from springpot.machine.arrays import Floats
from springpot.machine.faults import NotCoveredError, listed
from springpot.problem.free_numbers import free_numbers, with_values
from springpot.problem.parts import Dashpot, RecordedExcitation, Spring
from springpot.problem.system import System
from springpot.simulation.paths.driven import Driven, driven_by, with_stub
from springpot.simulation.plan.motion import Motion
from springpot.simulation.plan.motions import motion_of
from springpot.simulation.plan.scales import Scales
from springpot.simulation.plan.schemes import scheme_of

OFFSET, DELAY = "offset", "delay"
_DRIVE = "measured"  # the name of the part that stands for the input
_DIFFERENCE = 1e-6  # of a number, by which paths are compared
_BESIDE_STOPS = 1e-8  # the same, on both sides, where stops make a path jump a little: the smaller one has no jump
_LATER = 1e-3  # of a sample, the same of the delay
_FAR = 1e3  # residual of a path that grows without limit, over the spread of the record
_LED = 0.5  # damping ratio of what leads a path to the measured one
_COARSE, _FINER = 0.2, 4  # step at first, times the frequency; parts of a default step, where walls are struck
_FEWEST = 4.0  # samples in a period
_PERIODS = 2.0


@dataclass(frozen=True, eq=False, kw_only=True)
class DrivenModel:
    """A model, a record with its input, and the numbers of both.  Made by `driven_model`.

    Attributes
    ----------
    data : MeasuredRecord
    whole, stub : System
        The model with its input, and with a short stub in place of it.
    driven : Driven
    rows : list of ndarray, shape (coordinates,)
        How each measured point moves with the coordinates.
    numbers : tuple of Free
        Of the model, then of the record.
    of_model : int
        How many of them are of the model.
    """

    data: MeasuredRecord
    whole: System
    stub: System
    driven: Driven
    rows: list[Floats]
    numbers: tuple[Free, ...]
    of_model: int

    @property
    def has_stops(self) -> bool:
        """Whether something can be struck."""
        return bool(self.stub.stops)

    @property
    def coordinates(self) -> int:
        """How many there are."""
        return len(self.stub.coordinates.names)

    @property
    def pieces(self) -> int:
        """Records with an input of their own."""
        return len(self.data.input)

    @property
    def offsets(self) -> slice:
        """Where those of the points stand; the delay follows."""
        return slice(self.of_model, self.of_model + (len(self.rows) if self.data.offset is None else 0))

    @property
    def states(self) -> slice:
        """Where x and v at the first sample stand: of each piece, of each coordinate."""
        return slice(len(self.numbers) - (2 * self.coordinates * self.pieces if self.data.start == "free" else 0), None)

    def of_channel(self, n: int) -> slice:
        """The rows of the record of a point: one of several, or all pieces of one."""
        return slice(n, n + 1) if len(self.rows) > 1 else slice(None)

    def with_step(self, every: int) -> DrivenModel:
        """The same with so many steps in a sample."""
        return replace(self, driven=_driven(self.whole, self.data, every, self.driven.is_sampled))

    def interpolated(self, is_sampled: bool) -> DrivenModel:
        """The same with another input between its samples."""
        return replace(self, driven=_driven(self.whole, self.data, self.driven.every, is_sampled))

    def led(self, rate: float) -> DrivenModel | None:
        """The same with a spring and a dashpot to the measured motion, by which the path cannot leave it.

        The stronger they are, the smoother is the sum of squares: with an infinite spring it is that of the equation of
        motion.  So numbers are found from far away, and then led to those without them (homotopy: C. P. Vyasarayani,
        T. Uchida, A. Carvalho and J. McPhee, "Parameter identification in dynamic systems using the homotopy
        optimization approach", Multibody System Dynamics 26, 2011).  None where the displacement of a lone mass was not
        measured.
        """
        system, data = self.whole, self.data
        if self.coordinates > 1 or data.channels[0][0] != "x" or len(data.channels) > 1 or data.delay is None:
            return None
        mass = next((part.value for part in system.masses.values()), 1.0)
        mass = float(mass) if data.on != "ground" else mass  # of a free one the force is not known before
        pull = rate**2 * data.values + 2.0 * _LED * rate * np.gradient(data.values, data.step, axis=1)
        pull = float(mass) * pull if data.on != "ground" else -pull
        whole = system.but(lead=Spring(rate**2 * mass), brake=Dashpot(2.0 * _LED * rate * mass))
        driven = _driven(whole, data, self.driven.every, self.driven.is_sampled, data.input + pull)
        stub = with_stub(whole, _DRIVE, data.step, [*data.input])
        return replace(self, whole=whole, stub=stub, driven=driven)

    def expected(self, thetas: Sequence[Floats], samples: int) -> Floats:
        """The first samples of the record without noise, of several sets of numbers with the same delay.

        Returns
        -------
        ndarray, shape (sets, rows, samples)
            Not finite where a path grows without limit.
        """
        pieces, size = self.pieces, self.coordinates
        names, systems = [number.name for number in self.numbers[: self.of_model]], dict[bytes, System]()
        all_systems, starts = list[System](), np.zeros((len(thetas), pieces, 2, size))
        for n, theta in enumerate(thetas):
            own = theta[: self.of_model]
            if own.tobytes() not in systems:
                systems[own.tobytes()] = with_values(self.stub, dict(zip(names, own.tolist(), strict=True)))
            all_systems += [systems[own.tobytes()]] * pieces
            if self.data.start == "free":
                starts[n] = theta[self.states].reshape(pieces, size, 2).swapaxes(1, 2)
        driven = self.driven.delayed(
            float(thetas[0][self.offsets.stop]) if self.data.delay is None else self.data.delay
        )
        driven = driven if samples == driven.samples else driven.first(samples)
        paths = driven.paths(all_systems, starts.reshape(len(all_systems), -1))
        paths = paths.reshape(len(thetas), pieces, *paths.shape[1:])[..., :size, :]
        found = np.empty((len(thetas), len(self.data.values), samples))
        offsets = np.full((len(thetas), len(self.rows)), self.data.offset or 0.0)
        if self.data.offset is None:
            offsets[:] = np.array(thetas)[:, self.offsets]
        for n, (of, _) in enumerate(self.data.channels):
            seen = paths[..., "xva".index(of)] @ self.rows[n]
            if of == "a" and self.data.on == "ground":
                seen = seen + driven.input_at_samples
            found[:, self.of_channel(n)] = seen + offsets[:, n, None, None]
        return found

    def compared(self, theta: Floats, samples: int) -> tuple[Floats, Floats]:
        """What is left of the first samples, and the derivatives of what is expected.

        Returns
        -------
        left : ndarray, shape (rows, samples)
        slopes : ndarray, shape (numbers, rows, samples)
        """
        moves = [([place], self._difference(place, theta[place])) for place in range(self.of_model)]
        first = self.states.start
        for k in range(2 * self.coordinates if self.data.start == "free" else 0):  # of all pieces at once
            places = [first + 2 * self.coordinates * piece + k for piece in range(self.pieces)]
            moves.append((places, self._difference(places[0], theta[places[0]])))
        sets = [theta]
        for places, step in moves:
            for end in self._ends(places[0], theta[places[0]], step):
                sets.append(theta.copy())
                sets[-1][places] += end * step
        middle, *others = self.expected(sets, samples)
        far = _FAR * float(self.data.values.std())
        slopes = np.zeros((theta.size, *middle.shape))
        for k, (places, step) in enumerate(moves):
            beside = others[2 * k : 2 * k + 2] if self.has_stops else others[k : k + 1]
            ends = self._ends(places[0], theta[places[0]], step)
            rises = list[Floats]()
            for other, end in zip(beside, ends, strict=True):
                with np.errstate(invalid="ignore"):
                    rise = other - middle
                    rises.append(np.where(np.abs(rise) <= far, rise, 0.0) / (end * step))  # 0: grows without limit
            rise = min(rises, key=lambda each: float(np.abs(each).sum()))
            for n, place in enumerate(places):
                own = slice(n, n + 1) if len(places) > 1 else slice(None)
                slopes[place, own] = rise[own]
        for n, place in enumerate(range(self.offsets.start, self.offsets.stop)):
            slopes[place, self.of_channel(n)] = 1.0
        if self.data.delay is None:
            place, later = self.offsets.stop, theta.copy()
            later[place] += (step := -_LATER * self.data.step if theta[place] > 0.0 else _LATER * self.data.step)
            slopes[place] = (self.expected([later], samples)[0] - middle) / step
        left = self.data.values[:, :samples] - middle
        with np.errstate(invalid="ignore"):
            lost = ~(np.abs(left) <= far)  # a path that grows without limit
        return np.where(lost, far, left), np.where(lost | ~np.isfinite(slopes), 0.0, slopes)

    def _ends(self, place: int, value: float, step: float) -> tuple[float, ...]:
        """Where the path is compared, in steps: on both sides where there are stops, but not beyond a bound."""
        if not self.has_stops:
            return (1.0,)
        number = self.numbers[place]
        return (1.0, -1.0) if number.low <= value - step <= number.high else (1.0, 2.0)

    def _difference(self, place: int, value: float) -> float:
        number, relative = self.numbers[place], _BESIDE_STOPS if self.has_stops else _DIFFERENCE
        step = relative * max(abs(value), 1e-3 * (number.high - number.low))
        return -step if value + step > number.high else step


def driven_model(system: System, data: MeasuredRecord) -> DrivenModel:
    """A model under the measured input of a record.

    Raises
    ------
    NotCoveredError, ValueError
        If the model has other excitation, or its record cannot be this one.

    Examples
    --------
    >>> from springpot.problem.free_numbers import free
    >>> from springpot.problem.parts import Spring
    >>> time = 0.1 * np.arange(64)
    >>> record = MeasuredRecord(time, np.sin(time), input=np.cos(time))
    >>> model = driven_model(System(Spring(free("k", 4.0, (1.0, 9.0)))), record)
    >>> [number.name for number in model.numbers]
    ['k', 'offset', 'x0', 'v0']
    """
    if others := [name for name in system.excitations if name not in system.constants]:
        raise ValueError(f"model must have no excitation where the input was measured: leave out {listed(others)}.")
    if any(of == "a" for of, _ in data.channels) and system.walls:
        raise NotCoveredError(
            "an acceleration is not covered where a rigid wall is struck: give x or v, or a sp.Contact."
        )
    rows = [row_of(system, at) for _, at in data.channels]
    points = [each for each in system.coordinates.called if each]
    if data.on != "ground" and data.on not in points:
        known = listed([repr(each) for each in ("ground", *points)], "or")
        raise ValueError(f"on of the data must be {known}, not {data.on!r}.")
    parts = dict(system.stated())
    drive = RecordedExcitation((0.0, data.step), (1.0, -1.0), data.on)
    whole = System(**parts, **{_DRIVE: drive})
    stub = with_stub(whole, _DRIVE, data.step, [*data.input])
    motion = motion_of(stub)
    _check_sampling(motion, data)
    model = tuple(free_numbers(system).values())
    numbers = (*model, *_of_record(system, data, motion.scales, rows))
    names = [number.name for number in numbers]
    if clash := sorted({name for name in names if names.count(name) > 1}):
        raise ValueError(f"{listed(clash)} must not be the name of a free number: a number of the record has it.")
    return DrivenModel(
        data=data, whole=whole, stub=stub, rows=rows, numbers=numbers, of_model=len(model),
        driven=_driven(whole, data, _steps_at_first(motion, data.step), data.interpolation != "linear"),
    )  # fmt: skip


def _driven(whole: System, data: MeasuredRecord, every: int, is_sampled: bool, inputs: Floats | None = None) -> Driven:
    accelerates = any(of == "a" for of, _ in data.channels)
    own = [*(data.input if inputs is None else inputs)]
    return driven_by(whole, _DRIVE, data.step, own, every=every, is_sampled=is_sampled, accelerates=accelerates)


def _frequency(motion: Motion) -> float:
    """Of the linear springs of a lone mass, where it has some; guesses depend on how large the motion is."""
    linear = motion.potential is not None and motion.system.stiffness > 0.0
    return motion.system.natural_frequency if linear else motion.scales.frequency


def _steps_at_first(motion: Motion, sample: float) -> int:
    """In a sample, of which a search takes more as far as it matters."""
    usual = max(1, math.ceil(sample / motion.default_step(scheme_of("default")) - 1e-9))
    if motion.system.walls:  # what a step does to an impact grows with every later one
        return _FINER * usual
    return usual if motion.system.stops else min(usual, max(1, math.ceil(sample * _frequency(motion) / _COARSE)))


def _check_sampling(motion: Motion, data: MeasuredRecord) -> None:
    """Samples must be frequent and long enough to see the motion that the model has at its start."""
    period = 2.0 * np.pi / _frequency(motion)
    if period < _FEWEST * data.step:
        raise ValueError(
            f"time must have more than {_FEWEST:g} samples in a period of the model: that is {period:.4g} s at its "
            f"start, and the samples are {data.step:.4g} s apart."
        )
    if (length := float(data.time[-1])) - float(data.time[0]) < _PERIODS * period:
        raise ValueError(
            f"time must last at least {_PERIODS:g} periods of the model: that is {period:.4g} s at its start, and the "
            f"record lasts {length - float(data.time[0]):.4g} s."
        )


def _of_record(system: System, data: MeasuredRecord, scales: Scales, rows: Sequence[Floats]) -> Iterator[Free]:
    """Offsets, the delay, and x and v at the first sample, with wide bounds."""
    points = len(data.channels)
    spreads = [float(data.values[n if points > 1 else slice(None)].std()) for n in range(points)]
    for n, spread in enumerate(spreads if data.offset is None else ()):
        yield Free(0.0, f"{OFFSET}_{n + 1}" if points > 1 else OFFSET, -10.0 * spread, 10.0 * spread)
    if data.delay is None:
        yield Free(0.0, DELAY, -MOST_DELAY * data.step, MOST_DELAY * data.step)
    if data.start == "rest":
        return
    seen = max((spread for (of, _), spread in zip(data.channels, spreads, strict=True) if of == "x"), default=0.0)
    names = [called.rstrip("_") for called in system.coordinates.beginnings][: len(system.coordinates.names)]
    for piece in range(len(data.input)):
        for n, name in enumerate(names):
            of = "_".join(each for each in (name, str(piece + 1) if len(data.input) > 1 else "") if each)
            x, v = _begun(data, rows, piece, n)
            far = 20.0 * max(scales.length, seen, abs(x))
            fast = max(far * scales.fastest_rate, 2.0 * abs(v))
            yield Free(x, f"x0_{of}" if of else "x0", -far, far)
            yield Free(v, f"v0_{of}" if of else "v0", -fast, fast)


def _begun(data: MeasuredRecord, rows: Sequence[Floats], piece: int, coordinate: int) -> tuple[float, float]:
    """x and v at the first sample: by a parabola through five samples where this coordinate was measured."""
    for n, (of, _) in enumerate(data.channels):
        if of == "x" and np.flatnonzero(rows[n]).tolist() == [coordinate]:
            values = data.values[n if len(rows) > 1 else piece][:5] / rows[n][coordinate]
            _, v, x = np.polyfit(data.step * np.arange(5), values, 2)
            return float(x), float(v)
    return 0.0, 0.0
