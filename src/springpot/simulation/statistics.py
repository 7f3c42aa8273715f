"""From one row of sums per path to named values with standard errors.

Paths are independent, so the standard error of a mean over paths of time averages is the spread between paths over
sqrt(paths), whatever the correlation within one path.  Ratios (impact speeds) use the linearised spread of
numerator minus ratio times denominator.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from springpot.oscillator import Oscillator
from springpot.simulation.compose import Tables, mirror
from springpot.simulation.kernel import COLUMNS
from springpot.simulation.settings import Settings
from springpot.simulation.slow_impacts import impacts_are_countable
from springpot.units import UNITS

__all__ = ["controlled", "estimates", "linearised", "standard_error"]

Floats = npt.NDArray[np.float64]


def estimates(
    oscillator: Oscillator, settings: Settings, made: Tables, rows: Floats
) -> tuple[dict[str, float], dict[str, float]]:
    """Values and standard errors, both by name.

    Parameters
    ----------
    rows : ndarray, shape (paths, len(COLUMNS))

    Returns
    -------
    values, errors : dict
        Keys of `UNITS`.  With a single path the errors are NaN; a speed without impacts is NaN, and so are impact rate
        and speeds at a restitution that makes infinitely many impacts.
    """
    found = linearised(oscillator, settings, made, rows)
    return (
        {name: found[name][0] for name in UNITS},
        {name: standard_error(found[name][1]) for name in UNITS},
    )


def linearised(
    oscillator: Oscillator, settings: Settings, made: Tables, rows: Floats
) -> dict[str, tuple[float, Floats]]:
    """Each value with what every path contributes to it: samples whose mean it is, to first order in their spread.

    So differences and sums of estimates from the same paths get their standard errors right.
    """
    low, high = settings.window_steps
    steps, time, sign = high - low, (high - low) * settings.step, mirror(oscillator)
    column = dict(zip(COLUMNS, rows.T, strict=True))
    stiffness = oscillator.natural_frequency**2
    restitution = 1.0 if oscillator.barrier is None else oscillator.barrier.restitution
    spent = column["power"] / steps
    spent = spent + 0.5 * (1.0 - restitution**2) * column["impact_speed_squares"] / time
    gained = (column["energy_last"] - column["energy_first"]) / time
    per_path = {
        "x_mean": sign * column["x"] / steps,
        "x_mean_square": column["x_square"] / steps,
        "v_mean_square": column["v_square"] / steps,
        "amplitude_mean_square": (column["x_square"] + column["v_square"] / stiffness) / steps,
        "impact_rate": column["impacts"] / time,
        "springpot_force_mean": sign * column["force"] / steps,
        "springpot_power": column["power"] / steps,
        "springpot_virial": column["virial"] / steps,
        "energy_residual": _residual(spent + gained, made.expected_power, column["energy_first"] / time),
        "x_mean_end": sign * column["x_end"],
        "x_mean_square_end": column["x_end"] ** 2,
        "v_mean_square_end": column["v_end"] ** 2,
        "amplitude_mean_square_end": column["x_end"] ** 2 + column["v_end"] ** 2 / stiffness,
    }
    found = {name: (float(samples.mean()), samples) for name, samples in per_path.items()}
    found["impact_speed_mean"] = _ratio(column["impact_speeds"], column["impacts"])
    found["impact_speed_mean_square"] = _ratio(column["impact_speed_squares"], column["impacts"])
    if oscillator.barrier is not None and not impacts_are_countable(oscillator):
        undefined = math.nan, np.full(len(rows), np.nan)
        found |= dict.fromkeys(("impact_rate", "impact_speed_mean", "impact_speed_mean_square"), undefined)
    return found


def _residual(out: Floats, fed: float, held: Floats) -> Floats:
    """1 - out / fed; without noise, what came out of nowhere over what was there at first (NaN if nothing was)."""
    if fed > 0.0:
        return 1.0 - out / fed
    return np.divide(-out, held, out=np.full_like(out, np.nan), where=held > 0.0)


def _ratio(above: Floats, below: Floats) -> tuple[float, Floats]:
    if not below.sum() > 0.0:
        return math.nan, np.full_like(above, np.nan)
    ratio = float(above.sum() / below.sum())
    return ratio, ratio + (above - ratio * below) / float(below.mean())


def standard_error(samples: Floats) -> float:
    """Standard error of the mean of independent samples; NaN for a single one."""
    return float(samples.std(ddof=1) / math.sqrt(samples.size)) if samples.size > 1 else math.nan


def controlled(samples: Floats, controls: Floats) -> Floats:
    """Samples less their regression on controls of mean zero; their mean stays what it is expected to be.

    Examples
    --------
    >>> control = np.array([[1.0], [-2.0], [4.0]])
    >>> controlled(3.0 + 2.0 * control[:, 0], control).round(12)
    array([3., 3., 3.])
    """
    if not np.isfinite(samples).all():
        return samples
    apart = controls - controls.mean(axis=0)
    slopes = np.linalg.lstsq(apart, samples - samples.mean(), rcond=None)[0]
    return np.asarray(samples - controls @ slopes)
