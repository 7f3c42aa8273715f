"""Records of a response whose input was measured: least squares on the simulated path (output error).

The path is simulated under the measured input with the numbers of the model, and compared with the record.  What is
left is noise of the sensor, and what the model does not have.  It is seldom white.  So an autoregressive model of it
filters residuals and derivatives, and the fit is repeated (generalized least squares): errors of plain least squares
are 2 to 4 times too small where noise is coloured.

Where a wall or contact is struck the sum of squares has many minima, because paths separate.  So the record is fitted
as a whole, led along the measured motion, and from its beginning in growing parts, each from the numbers of the one
before, and the smallest sum of squares is taken; from other starts too, where none of these follows the record.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from springpot.fitting.driven_paths import driven_model
from springpot.fitting.likelihood import USUAL, Coordinates, How, LeastSquares, Table, inverse, refuse_idle
from springpot.fitting.motion_data import MeasuredRecord
from springpot.fitting.sensor_noise import clipped, coloured_square, filtered, lags_of, noise_probability
from springpot.machine.arrays import Floats
from springpot.machine.faults import NoFitError, Stopped
from springpot.problem.system import System

_FIRST = 60  # samples of the first part of a record that grows
_PARTS = 8  # of a record, in which it may be followed or not
# rms of what is left over the spread of the record: of a fit that needs no other start, and of none, with and without
# stops; and of a part over that of the best part
_FOLLOWED, _LOST_BEHIND_STOPS, _LOST, _UNEVEN = 0.03, 0.15, 0.5, 3.0
_BY_CHANCE = 0.01  # probability below which what is left behind a stop is a wrong minimum, and other starts are tried
_ROUNDS, _PLACES = 6, 120  # of the search near a minimum
_ABOUT = 0.5, 1.0, 2.0, 4.0  # how far it looks, in standard errors
_LONGER, _WORSE = 1.6, 1.3  # of a part to the one before, and of its mean square, from which on it is followed worse
_LEADS = 2.0, 1.0, 0.5, 0.25, 0.1  # rates of the spring that leads, over the frequency
_FOLLOWED_AT_FIRST = 0.2  # rms of what is left over that of the first part, which tells a path that is lost later
_GROWN = 1.05  # of the sum of squares, by which another step may have lost the path
_STARTS, _STARTS_WITHOUT_WALLS, _APART = 8, 2, 0.4  # other starts, and how far they are in the logarithm
_MOVED = 0.2  # of a standard error: by how much half the step may move a number
_HALVINGS, _HALVINGS_WITHOUT_STOPS = 4, 8
_CORNERS = 20.0  # samples in a period from which on straight lines lose less than 1 %
_FEWEST = 32  # samples in which x and v at the first one are found
_AT_EXTREME = 10  # samples at the largest value, from which on a record may be clipped


@dataclass(frozen=True, eq=False)
class Prediction:
    """What a fitted model makes of another input, beside what was measured.

    Attributes
    ----------
    time : ndarray, shape (n,)
    measured, values : ndarray, shape (rows, n)
        The record, and what is expected in its place.
    error : ndarray, shape (rows, n)
        Standard error of the expected values, by the errors of the numbers; without noise of the sensor.
    left : float
        Root mean square of the differences, but for ``skip`` at the beginning.
    share : float
        The same over the standard deviation of the record.
    """

    time: Floats
    measured: Floats
    values: Floats
    error: Floats
    left: float
    share: float


class DrivenLikelihood(LeastSquares):
    """Samples of the response to a measured input.

    Parameters
    ----------
    system : System
        Without excitation of its own; with free numbers.
    data : MeasuredRecord
        With its input.
    how : How
        Its seed is that of other starts, where the record is not followed from the given one; its progress is called
        with the share of the search that is done.

    Raises
    ------
    NotCoveredError, ValueError
        If the record cannot be one of the model.
    """

    known, smooth_start, simulated = False, True, True

    def __init__(self, system: System, data: MeasuredRecord, how: How = USUAL) -> None:
        super().__init__(system, data, how)
        self._model = driven_model(system, data)
        self.coordinates = Coordinates(self._model.numbers)
        self._spreads = [float(data.values[own].std()) for own in self._channels]
        self._filters = [np.zeros(0) for _ in self._channels]
        self._samples, self._settled = data.time.size, False
        self._last: tuple[object, tuple[Floats, Floats]] | None = None
        self._is_linear = not system.stops and all(getattr(part, "is_linear", True) for part in system.parts)

    @property
    def _channels(self) -> list[slice]:
        """The rows of the record of each measured point."""
        return [self._model.of_channel(n) for n in range(len(self.data.channels))]

    @property
    def size(self) -> int:
        """Number of samples that are compared."""
        return sum(own.size for own in self._compared(self.data.values))

    def _compared(self, rows: Floats, whiten: bool = True) -> list[Floats]:
        """The part of each channel that is compared, over its spread; through the filter that makes its noise white."""
        first = self.data.first
        own = [
            rows[channel, first : self._samples] / spread
            for channel, spread in zip(self._channels, self._spreads, strict=True)
        ]
        return [filtered(each, lags) for each, lags in zip(own, self._filters, strict=True)] if whiten else own

    def _in_a_row(self, rows: Floats) -> Floats:
        """What is compared, of one channel after the other."""
        return np.concatenate([own.ravel() for own in self._compared(rows)])

    def _at(self, theta: Floats) -> tuple[Floats, Floats]:
        """What is left of the record, and the derivatives of what is expected; of the last numbers they are kept."""
        key = theta.tobytes(), self._samples, self._model
        if self._last is None or self._last[0] != key:
            self._last = key, self._model.compared(theta, self._samples)
        return self._last[1]

    def _left(self, theta: Floats) -> Floats:
        """The record less what is expected, as it was measured."""
        return self._at(theta)[0]

    def residuals(self, theta: Floats) -> Floats:
        """Of the record over its spread, filtered."""
        return self._in_a_row(self._left(theta))

    def sensitivity(self, theta: Floats) -> Floats:
        """Derivatives of what is expected."""
        return np.stack([self._in_a_row(slope) for slope in self._at(theta)[1]], axis=1)

    def constant(self) -> float:
        """What the spreads add."""
        counts = [own.size for own in self._compared(self.data.values)]
        return float(sum(n * np.log(2.0 * np.pi * spread**2) for n, spread in zip(counts, self._spreads, strict=True)))

    def covariance(self, theta: Floats, moves: NDArray[np.bool_]) -> Floats:
        """Of the coordinates: of filtered least squares, or of plain ones in coloured noise (the sandwich)."""
        if self.data.weights == "noise":
            return super().covariance(theta, moves)
        left, slopes = self._at(theta)
        slope, middle = self.coordinates.slope(theta), np.zeros((theta.size, theta.size))
        rows = [self._compared(each) for each in slopes]
        for n, own in enumerate(self._compared(left)):
            lags = lags_of(own)
            scatter = float(np.var(filtered(own, lags)))
            middle += scatter * coloured_square(np.array([row[n] for row in rows]), lags)
        sensitivity = self.sensitivity(theta) * slope
        bread = inverse(sensitivity[:, moves].T @ sensitivity[:, moves])
        return np.asarray(bread @ (middle * np.outer(slope, slope))[np.ix_(moves, moves)] @ bread)

    def solve(self, begin: Floats, moves: NDArray[np.bool_]) -> Floats:
        """The first time the whole search; later least squares, with the filter and the step that it has found."""
        if self._settled or not moves.all():
            return super().solve(begin, moves)
        try:
            u = self._followed(begin, moves)
            self._check_influence(u)
            u = self._near(u, moves)
            u = self._interpolated(u, moves)
            for halving in range(most := _HALVINGS if self.system.stops else _HALVINGS_WITHOUT_STOPS):
                u = self._whitened(u, moves)
                if halving + 1 == most or self._is_fine(u):
                    break
                before, root = self._squares(u), self._root(u)
                self._model = self._model.with_step(2 * self._model.driven.every)
                again = self._again(u, moves)
                if not self._is_linear and self._squares(again) > _GROWN * before:
                    rng = np.random.default_rng([self.how.seed, 49])
                    others = self._best_about(u, root, rng, moves), self._growing(u, moves)
                    again = min(again, *others, key=self._squares)
                u = again
        except Stopped:
            if self.least is None:
                raise
            theta = self.least[1]
            self._samples = self.data.time.size
            self.least = float(np.sum(self.residuals(theta) ** 2)), theta
            raise
        u = self._near(u, moves)
        self._settled = True
        return u

    def _whitened(self, u: Floats, moves: NDArray[np.bool_]) -> Floats:
        """Least squares through the filter of what is left, twice."""
        for turn in range(2):
            before = self._filters
            if self.data.weights == "noise":
                self._filters = [lags_of(own) for own in self._rest(u)]
            if turn and not any(own.size for own in (*before, *self._filters)):
                break
            u = self._again(u, moves)
        return u

    def _outer(self, u: Floats) -> Floats:
        return self.coordinates.outer(u)

    def _again(self, u: Floats, moves: NDArray[np.bool_]) -> Floats:
        """Least squares from there; what was the least before is of another sum of squares."""
        self.least = None
        return super().solve(u, moves)

    def _followed(self, begin: Floats, moves: NDArray[np.bool_]) -> Floats:
        """Numbers with which the model follows the record.

        Raises
        ------
        NoFitError
            If none are found.
        """
        best = self._again(begin, moves)
        for n, start in enumerate(self._starts(begin)):
            if self._is_followed(best) or (self._is_linear and not self._is_lost(best)):
                break
            if self.how.progress is not None:
                self.how.progress(n / (_STARTS + 2.0))
            best = min(best, self._led(start, moves), key=self._squares)
            if not self._is_linear and not self._is_followed(best):
                best = min(best, self._growing(start, moves), key=self._squares)
        if self._is_lost(best):
            raise NoFitError(self._how_far_off(best, moves))
        return best

    def _starts(self, begin: Floats) -> Iterator[Floats]:
        """The given one, and others about it."""
        from scipy.stats import qmc

        own, count = self.coordinates, self._model.of_model
        yield begin
        starts = _STARTS if self.system.walls else _STARTS_WITHOUT_WALLS
        places = qmc.LatinHypercube(count, rng=np.random.default_rng([self.how.seed, 46])).random(starts)
        for place in 2.0 * places - 1.0:
            away = np.zeros(begin.size)
            sizes = np.where(own.logarithmic, 1.0, np.maximum(np.abs(begin), 0.05 * (own.high - own.low)))
            away[:count] = _APART * place * sizes[:count]
            yield np.clip(begin + away, own.low, own.high)

    def _led(self, begin: Floats, moves: NDArray[np.bool_]) -> Floats:
        """Along the measured motion, led by a spring that becomes weaker and weaker."""
        u, plain, rate = begin, self._model, self._model.driven.plan.motion.scales.frequency
        try:
            for share in _LEADS:
                led = plain.led(share * rate)
                if led is None:
                    break
                self._model = led
                u = self._again(u, moves)
        finally:
            self._model = plain
        return self._again(u, moves)

    def _growing(self, begin: Floats, moves: NDArray[np.bool_]) -> Floats:
        """From the first part of the record on, in longer and longer parts.

        Where a longer part is followed worse, places about the numbers of the shorter one are tried: its errors say how
        far the numbers may still be off.
        """
        u, whole, rng = begin, self.data.time.size, np.random.default_rng([self.how.seed, 48])
        first = self.data.first
        parts, length = list[int](), max(_FIRST, 4 * begin.size)
        while first + length < whole:
            parts.append(first + length)
            length = math.ceil(_LONGER * length)
        before, root = math.inf, np.zeros((0, 0))
        try:
            for samples in (*parts, whole):
                self._samples = samples
                found = self._again(u, moves)
                if self._squares(found) / self.size > _WORSE * before:
                    found = min(found, self._best_about(u, root, rng, moves), key=self._squares)
                u, before, root = found, self._squares(found) / self.size, self._root(found)
        finally:
            self._samples = whole
        return u

    def _near(self, u: Floats, moves: NDArray[np.bool_]) -> Floats:
        """Behind stops, the least of the minima near one: from the best of many places about it, again and again."""
        rng = np.random.default_rng([self.how.seed, 47])
        for _ in range(_ROUNDS if self.system.stops else 0):
            before = self._squares(u)
            best = self._best_about(u, self._root(u), rng, moves)
            if not self._squares(best) < before * (1.0 - 1.0 / self.size):
                return u
            u = best
        return u

    def _root(self, u: Floats) -> Floats:
        """Of the covariance of the coordinates, a triangle."""
        theta = self._outer(u)
        residual, own = self.residuals(theta), self.sensitivity(theta) * self.coordinates.slope(theta)
        scatter, reach = float(residual @ residual) / residual.size, self.coordinates.high - self.coordinates.low
        return np.asarray(np.linalg.cholesky(inverse(own.T @ own / scatter + np.diag(4.0 / reach**2))))

    def _best_about(self, u: Floats, root: Floats, rng: np.random.Generator, moves: NDArray[np.bool_]) -> Floats:
        """Least squares from the best of many places about one, which run together."""
        own, away = self.coordinates, rng.standard_normal((_PLACES, u.size)) * np.resize(_ABOUT, _PLACES)[:, None]
        places = [np.clip(u + root @ z, own.low, own.high) for z in away]
        paths = self._model.expected([self._outer(place) for place in places], self._samples)
        rows = self.data.values[:, : self._samples]
        squares = [sum(float(np.sum(part**2)) for part in self._compared(rows - each)) for each in paths]
        return self._again(places[int(np.argmin(np.nan_to_num(squares, nan=np.inf)))], moves)

    def _squares(self, u: Floats) -> float:
        return float(np.sum(self.residuals(self._outer(u)) ** 2))

    def _rest(self, u: Floats) -> list[Floats]:
        """What is left of each channel over its spread, as it was measured."""
        return self._compared(self._left(self._outer(u)), whiten=False)

    def _shares(self, u: Floats) -> tuple[float, float, float]:
        """What is left over the spread of the record: of all of it, and of the part where it is most and least."""
        left = self._rest(u)
        shares = [_by_parts(own) for own in left]
        return max(float(np.sqrt(np.mean(own**2))) for own in left), max(map(max, shares)), max(map(min, shares))

    def _is_followed(self, u: Floats) -> bool:
        """Whether so little is left that no other start is tried."""
        whole, worst, best = self._shares(u)
        lags = [lags_of(own) for own in self._rest(u)]
        most = _FOLLOWED if any(own.size for own in lags) else _LOST_BEHIND_STOPS
        if not (whole < most and worst < _UNEVEN * best):
            return False
        if not self.system.stops:
            return True
        plain, self._filters = self._filters, lags
        try:
            return self._of_noise(self._outer(u), u.size) > _BY_CHANCE
        finally:
            self._filters = plain

    def _is_lost(self, u: Floats) -> bool:
        """Whether the model does not follow the record, or only a part of it."""
        whole, worst, best = self._shares(u)
        most = _LOST_BEHIND_STOPS if self.system.stops else _LOST
        return not whole < most or (worst > most and worst > 2.0 * _UNEVEN * best)

    def _how_far_off(self, u: Floats, moves: NDArray[np.bool_]) -> str:
        """One sentence, with what may be wrong with the record: its sign or its unit."""
        left = self._rest(u)
        share = float(np.sqrt(np.mean(np.concatenate([own.ravel() for own in left]) ** 2)))
        said = f"no numbers were found with which the model follows the record: {100.0 * share:.0f} % of it are left"
        seen = self._compared(self.data.values - self.data.values.mean(axis=1, keepdims=True), whiten=False)
        parts = [a / max(b, 1e-300) for a, b in zip(_by_parts(left[0]), _by_parts(seen[0]), strict=True)]
        if parts[0] < _FOLLOWED_AT_FIRST and max(parts) > _LOST:
            place = next(n for n, part in enumerate(parts) if part > _LOST)
            since = self.data.time[place * self._samples // _PARTS]
            return f"{said}, from about {since:.3g} s on. Give starts that are nearer."
        gain = self._gain(u, moves)
        if gain is not None:
            what = "the sign of the input" if gain < 0.0 else "the units of the input and of the response"
            return f"{said}, but it follows a record {gain:.3g} times as large: check {what}."
        return f"{said}. Give starts that are nearer, or another model."

    def _gain(self, u: Floats, moves: NDArray[np.bool_]) -> float | None:
        """By what the response would have to be multiplied to be followed, if so it is."""
        from scipy.optimize import least_squares

        own, values = self.coordinates, self.data.values

        def scaled(part: Floats) -> tuple[Floats, float]:
            expected = self._model.expected([own.outer(part)], self._samples)[0]
            if not np.isfinite(expected).all():
                return 10.0 * values.ravel() / values.std(), 0.0
            seen, wanted = expected - expected.mean(), values - values.mean()
            gain = float(np.sum(seen * wanted) / max(float(np.sum(seen * seen)), 1e-300))
            return (wanted - gain * seen).ravel() / values.std(), gain

        def misfit(part: Floats) -> Floats:
            return scaled(part)[0]

        low, high = own.low, own.high
        for begin in (own.start, u):
            inside = np.clip(begin, low + 1e-6 * (high - low), high - 1e-6 * (high - low))
            found = least_squares(misfit, inside, bounds=(low, high), x_scale="jac", max_nfev=20, diff_step=[1e-5])
            left, gain = scaled(found.x)
            if np.sqrt(np.mean(left**2)) < 0.5 * _LOST:
                return gain
        return None

    def _interpolated(self, u: Floats, moves: NDArray[np.bool_]) -> Floats:
        """With the input between its samples that agrees better, if it was not said."""
        if self.data.interpolation is not None:
            return u
        sampled, of_sampled = self._model, self._squares(u)
        self._model = sampled.interpolated(False)
        other = self._again(u, moves)
        if self._squares(other) < of_sampled:
            return other
        self._model = sampled
        return u

    def _is_fine(self, u: Floats) -> bool:
        """Whether half the step moves no number by more than a small part of its error."""
        theta = self._outer(u)
        residual, slopes = self.residuals(theta), self.sensitivity(theta)
        finer = self._model.with_step(2 * self._model.driven.every)
        left = self.data.values - finer.expected([theta], self._samples)[0]
        change = residual - self._in_a_row(left)
        information = inverse(slopes.T @ slopes)
        errors = np.sqrt(np.diag(information) * float(residual @ residual) / max(residual.size - theta.size, 1))
        return bool((np.abs(information @ (slopes.T @ change)) <= _MOVED * errors).all())

    def _check_influence(self, u: Floats) -> None:
        """Every number of the model must move the path."""
        moved = np.abs(self.sensitivity(self._outer(u))).max(axis=0)[: self._model.of_model]
        never = ": the path never reaches what they belong to" if self.system.stops else ""
        idle = [name for name, move in zip(self.coordinates.names, moved.tolist(), strict=False) if move == 0.0]
        refuse_idle(idle, f"this record depends on none of this{never}")

    def extras(self, theta: Floats) -> dict[str, float]:
        """The standard deviation of what is left of each point, and how many samples its noise remembers."""
        found, together = dict[str, float](), len(self._channels) > 1
        left = self._left(theta)[:, self.data.first :]
        for n, (channel, lags) in enumerate(zip(self._channels, self._filters, strict=True), start=1):
            own = f"_{n}" * together
            found |= {f"left{own}": float(np.sqrt(np.mean(left[channel] ** 2))), f"noise_lags{own}": float(lags.size)}
        return found

    def checks(self, theta: Floats, moving: int) -> dict[str, tuple[float, str]]:
        """Whether what is left is noise: without any relation to the motion or the input, and of the stated size."""
        from scipy import stats

        found = dict[str, tuple[float, str]]()
        found["what is left against the motion (score test)"] = (
            self._of_noise(theta, moving), "what is left depends on the motion or the input: the model lacks something",
        )  # fmt: skip
        if self.data.noise is not None:
            raw = self._left(theta)[:, self.data.first :].ravel()
            chi = float(raw @ raw) / self.data.noise**2
            found["size of the residuals (chi-square)"] = (
                float(stats.chi2.sf(chi, max(raw.size - moving, 1))), "more is left than the stated noise explains",
            )  # fmt: skip
        return found

    def _of_noise(self, theta: Floats, moving: int) -> float:
        """The probability of what is left, if it is noise."""
        return noise_probability(self.residuals(theta), self.sensitivity(theta), self._beyond(theta), moving)

    def _beyond(self, theta: Floats) -> Floats:
        """What a better model might have: powers and products of the motion, and the input earlier and later."""
        expected = self.data.values[:, : self._samples] - self._left(theta)
        columns = list[Floats]()
        for n, channel in enumerate(self._channels):
            own = expected[channel] - expected[channel].mean()
            x = own / max(float(own.std()), 1e-300)
            v = np.gradient(x, axis=1)
            v = v / max(float(v.std()), 1e-300)
            drive = np.broadcast_to(
                self._model.driven.input_at_samples[:, : self._samples], self.data.values[:, : self._samples].shape
            )[channel]
            kinds = [x**2, x**3, np.abs(x), v * np.abs(v), v**3, x * v, x**2 * v, np.sign(v), x, v]
            kinds += [np.roll(drive, k, axis=1) for k in range(-1, 4)]
            for kind in kinds:
                whole = np.zeros_like(expected)
                whole[channel] = kind * self._spreads[n]
                columns.append(self._in_a_row(whole))
        return np.stack(columns, axis=1)

    def doubts(self, theta: Floats) -> tuple[str, ...]:
        """Of the search, of the input between its samples, and of the record."""
        said, data = [*super().doubts(theta)], self.data
        period = 2.0 * np.pi / self._model.driven.plan.motion.scales.frequency
        if data.interpolation == "linear" and period < _CORNERS * data.step:
            said.append(
                f"The input has straight lines between its samples, of which a period has {period / data.step:.3g}: "
                "if it was sampled behind a filter, interpolation='band-limited' loses nothing."
            )
        for name, rows in (("values", data.values), ("input", data.input)):
            if (count := clipped(rows)) >= _AT_EXTREME:
                said.append(f"The {name} may be clipped: {count} samples stand at the largest or the least value.")
        return tuple(said)

    def table(self, theta: Floats) -> Table:
        """Samples, and what the path with the found numbers has in their place."""
        left = self._left(theta)
        word = "point" if len(self._channels) > 1 else "piece"
        names = [f"{word} {n + 1}" for n in range(len(left))]
        sizes = np.maximum(np.sqrt(np.mean(left**2, axis=1, keepdims=True)), 1e-300)
        return Table.of_record(self.data.time, names, self.data.values, self.data.values - left, left / sizes)

    def predicted(self, theta: Floats, covariance: Floats, data: MeasuredRecord) -> Prediction:
        """Another record of the same device: as `springpot.fitting.result.Fit.predict` says.

        Raises
        ------
        TypeError, ValueError
            If it is no record of the same points with its input.
        """
        if not isinstance(data, MeasuredRecord) or not data.has_input or data.channels != self.data.channels:
            raise TypeError("record must be a MeasuredRecord of the same points, with its input.")
        for name in ("delay", "offset"):
            if (getattr(data, name) is None) != (getattr(self.data, name) is None):
                raise ValueError(f"{name} of the record must be found, or stated, as in the record that was fitted.")
        own = self._like(data)
        shared = self._model.offsets.stop + (self.data.delay is None)
        whole = own.coordinates.given
        whole[:shared] = theta[:shared]
        if data.start == "free":
            seen = max(data.first, _FEWEST) if data.skip > 0.0 else data.time.size
            part = replace(
                data, time=data.time[:seen], values=data.values[:, :seen], input=data.input[:, :seen], skip=0.0
            )
            beginning = self._like(part)
            moves = np.arange(whole.size) >= shared
            whole = beginning._outer(LeastSquares.solve(beginning, beginning.coordinates.inner(whole), moves))
        left, slopes = own._model.compared(whole, data.time.size)
        inner = np.nan_to_num(covariance[:shared, :shared])
        error = np.sqrt(np.einsum("irn,ij,jrn->rn", slopes[:shared], inner, slopes[:shared]))
        compared = left[:, data.first :]
        size = float(np.sqrt(np.mean(compared**2)))
        return Prediction(data.time, data.values, data.values - left, error, size, size / float(data.values.std()))

    def _like(self, data: MeasuredRecord) -> DrivenLikelihood:
        """Of another record, with the step and the interpolation that were found."""
        found = DrivenLikelihood(self.system, data)
        found._model = found._model.with_step(self._model.driven.every)
        if data.interpolation is None:
            found._model = found._model.interpolated(self._model.driven.is_sampled)
        return found


def _by_parts(rows: Floats) -> list[float]:
    """Root mean square of each part of rows."""
    return [float(np.sqrt(np.mean(part**2))) for part in np.array_split(rows, _PARTS, axis=1)]
