"""Stochastic averaging: the closed form, what follows from it, and where it refuses."""

import itertools
import json
import math

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad

from springpot.evidence.comparison import compare
from springpot.evidence.recommendation import all_methods, recommended
from springpot.evidence.reliability import trust, warnings_of
from springpot.problem.dimensionless import Dimensionless
from springpot.problem.oscillator import Barrier, Oscillator, Springpot, WhiteNoise
from springpot.simulation import simulate
from springpot.theory import (
    Averaging,
    NoStationaryStateError,
    NotCoveredError,
    averaging,
    envelope,
    fokker_planck,
    memory_closure,
    solve_all,
)
from springpot.theory.decay import harmonic_sum
from springpot.theory.methods.exact import exact
from springpot.theory.result import MOMENTS, names_of_results
from tests.sizes import thinned


def oscillator(alpha=0.5, coefficient=1.0, omega=1.0, q=1.0, barrier=Barrier()) -> Oscillator:  # noqa: B008
    return Oscillator(omega, Springpot(alpha, coefficient), barrier, WhiteNoise(q))


orders = st.floats(0.01, 1.0)
positive = st.floats(0.05, 20.0)
oscillators = st.builds(oscillator, orders, positive, positive, positive)


@pytest.mark.parametrize("alpha", [0.0, 0.1, 0.5, 0.9, 1.0])
def test_harmonic_sum_against_mpmath(alpha):
    with mpmath.workdps(25):
        a = mpmath.mpf(alpha)
        direct = mpmath.nsum(
            lambda m: m**2 * (2 * m) ** (a - 1) / (4 * m**2 - 1) ** 2, [1, mpmath.inf], method="euler-maclaurin"
        )
    assert harmonic_sum(alpha) == pytest.approx(float(direct), rel=1e-14)


def test_harmonic_sum_of_a_dashpot():
    assert harmonic_sum(1.0) == pytest.approx(math.pi**2 / 64, rel=1e-15)


def test_both_forms_at_another_frequency():
    asked = oscillator(0.7, 0.2, omega=3.0)
    assert averaging(asked).amplitude_mean_square == pytest.approx(1.173, abs=5e-4)
    assert averaging(asked, form="printed").amplitude_mean_square == pytest.approx(3.519, abs=5e-4)


@pytest.mark.parametrize(("alpha", "mu"), [(0.7, 1.519), (0.5, 2.296), (0.3, 4.250), (0.1, 14.55)])
def test_values_at_unit_coefficients(alpha, mu):
    for form in ("corrected", "printed"):
        assert averaging(oscillator(alpha), form=form).amplitude_mean_square == pytest.approx(mu, rel=5e-4)


@given(positive, positive, positive)
def test_dashpot_is_exact(c, omega, q):
    result = averaging(oscillator(1.0, c, omega, q))
    assert result.amplitude_mean_square == pytest.approx(q / (c * omega**2), rel=1e-13)
    assert result.x_mean_square == pytest.approx(q / (2 * c * omega**2), rel=1e-13)
    assert result.v_mean_square == pytest.approx(q / (2 * c), rel=1e-13)
    assert result.impact_rate == omega / math.pi


@given(oscillators)
def test_dimensionless_law(asked):
    """Only alpha and c = C Omega^(alpha-2) matter once lengths and times are scaled."""
    paper = Dimensionless.of(asked)
    unit = oscillator(paper.springpot.order, paper.dimensionless_coefficient)
    mu = averaging(asked).amplitude_mean_square
    assert mu / paper.length_scale**2 == pytest.approx(averaging(unit).amplitude_mean_square, rel=1e-10)


@given(oscillators)
def test_energy_balance_and_amplitude(asked):
    """q/2 goes in; the free amplitude's energy loss beta v^2 * 2 goes out."""
    result = averaging(asked)
    q, omega = Dimensionless.of(asked).excitation.intensity, asked.natural_frequency
    assert 2 * result.decay_rate * result.v_mean_square == pytest.approx(q / 2, rel=1e-12)
    assert result.x_mean_square + result.v_mean_square / omega**2 == pytest.approx(result.amplitude_mean_square)


@given(oscillators, st.floats(0.5, 0.999))
def test_impact_loss_adds_to_the_decay(asked, r):
    pot = Dimensionless.of(asked).springpot
    lossy = oscillator(pot.order, pot.coefficient, asked.natural_frequency, 1.0, Barrier(restitution=r))
    added = averaging(lossy).decay_rate - averaging(asked).decay_rate
    assert added == pytest.approx(-asked.natural_frequency / math.pi * math.log(r), rel=1e-6)


def test_impact_loss_value_and_warning():
    result = averaging(oscillator(0.5, 0.1, barrier=Barrier(restitution=0.9)))
    assert result.amplitude_mean_square == pytest.approx(9.04, abs=0.01)
    (warning,) = warnings_of(averaging(oscillator(0.5, 0.1, barrier=Barrier(restitution=0.5))))
    assert "gaps to Monte Carlo" in warning
    assert averaging(oscillator(0.0, barrier=Barrier(restitution=0.9))).amplitude_mean_square > 0


def test_no_wall():
    result = averaging(oscillator(0.5, 0.1, omega=2.0, barrier=None))
    assert result.decay_rate == pytest.approx(0.05 * 2**-0.5 * math.sin(math.pi / 4), rel=1e-14)
    assert (result.x_mean, result.impact_rate) == (0.0, 0.0)
    assert math.isnan(result.impact_speed_mean)
    assert result.to_dict()["impact_speed_mean_square"] is None
    with pytest.raises(NotCoveredError, match="no wall"):
        result.impact_speed_density(1.0)
    with pytest.raises(NotCoveredError, match="without a wall"):
        averaging(oscillator(barrier=None), form="printed")


def test_no_wall_against_the_exact_spectrum():
    """The number in the warning: 2 % too low at c = 1, alpha = 0.5."""

    def power(w: float) -> float:
        return (1 + w**2) / abs(1 - w**2 + (1j * w) ** 0.5) ** 2 / math.pi

    exact = quad(power, 0, 2, limit=200)[0] + quad(power, 2, math.inf, limit=200)[0]
    result = averaging(oscillator(barrier=None))
    assert result.amplitude_mean_square / exact - 1 == pytest.approx(-0.02, abs=0.003)
    assert "2 % too low" in result.warnings[0]


@pytest.mark.parametrize("form", ["corrected", "printed"])
def test_mirrored_wall(form):
    above = averaging(oscillator(), form=form)
    below = averaging(oscillator(barrier=Barrier(free_side="below")), form=form)
    assert below.x_mean == -above.x_mean < 0
    assert {n: v for n, v in below.to_dict().items() if n != "x_mean"} == {
        n: v for n, v in above.to_dict().items() if n != "x_mean"
    }
    x = np.linspace(-3, 3, 13)
    np.testing.assert_array_equal(below.x_density(x), above.x_density(-x))


@pytest.mark.parametrize("position", [0.5, -0.5])
@pytest.mark.parametrize("form", ["corrected", "printed"])
def test_wall_elsewhere_is_not_covered(position, form):
    with pytest.raises(NotCoveredError, match="covers a wall at position 0 or no wall"):
        averaging(oscillator(barrier=Barrier(position=position, free_side="above")), form=form)


def test_printed_form_is_for_an_elastic_wall():
    with pytest.raises(NotCoveredError, match=r"restitution 1\), not restitution 0.9"):
        averaging(oscillator(barrier=Barrier(restitution=0.9)), form="printed")


def test_unknown_form():
    with pytest.raises(ValueError, match="'corrected' or 'printed', not 'exact'"):
        averaging(oscillator(), form="exact")


@pytest.mark.parametrize(("alpha", "coefficient", "cause"), [(0.0, 1.0, "order 0 is a spring"), (0.5, 0.0, "C is 0")])
@pytest.mark.parametrize("form", ["corrected", "printed"])
def test_no_stationary_state(alpha, coefficient, cause, form):
    result = averaging(oscillator(alpha, coefficient, omega=2.0, q=3.0), form=form)
    assert result.decay_rate == 0.0
    np.testing.assert_allclose(result.mean_square([0.0, 4.0], initial=1.0), [1.0, 1.0 + 3.0 * 4.0 / 4.0])
    for name in MOMENTS:
        with pytest.raises(NoStationaryStateError, match=cause):
            getattr(result, name)
    with pytest.raises(NoStationaryStateError):
        result.amplitude_density(1.0)
    assert float(result.amplitude_density(1.0, time=2.0)) > 0
    answer = result.to_dict()
    assert all(answer[name] is None for name in MOMENTS)
    assert cause in str(answer["statement"])
    assert "inf" not in json.dumps(answer).lower()


def test_decay_too_small_for_floating_point():
    with pytest.raises(NoStationaryStateError, match="floating point"):
        _ = averaging(oscillator(5e-324)).x_mean


def test_no_noise_is_rest():
    result = averaging(oscillator(q=0.0))
    assert (result.amplitude_mean_square, result.x_mean, result.impact_rate) == (0.0, 0.0, 0.0)
    assert float(result.mean_square(1.0, initial=2.0)) == pytest.approx(2 * math.exp(-2 * result.decay_rate))
    with pytest.raises(ValueError, match="no density"):
        result.x_density(0.0)


@given(oscillators, st.floats(0.0, 5.0), st.floats(0.0, 10.0))
def test_transient_obeys_its_equation(asked, initial, time):
    result = averaging(asked)
    stationary, beta = result.amplitude_mean_square, result.decay_rate
    expected = stationary + (initial - stationary) * math.exp(-2 * beta * time)
    assert float(result.mean_square(time, initial=initial)) == pytest.approx(expected, rel=1e-9, abs=1e-9 * stationary)


@pytest.mark.parametrize("arguments", [(-1.0,), (1.0, -1.0), (math.nan,)])
def test_transient_refuses(arguments):
    with pytest.raises(ValueError, match="at least 0"):
        averaging(oscillator()).mean_square(*arguments)


@pytest.mark.parametrize(
    ("wall", "time"), thinned(itertools.product([Barrier(), Barrier(free_side="below"), None], [None, 0.3]), 2)
)
def test_densities_have_the_moments(time, wall):
    result = averaging(oscillator(0.6, 0.4, omega=1.7, q=2.0, barrier=wall))
    omega = result.paper.natural_frequency
    mu = result.amplitude_mean_square if time is None else float(result.mean_square(time))

    def moment(density, power, low=-60.0, high=60.0):
        parts = [quad(lambda u: u**power * float(density(u, time)), *ends)[0] for ends in ((low, 0.0), (0.0, high))]
        return sum(parts)

    assert moment(result.amplitude_density, 0) == pytest.approx(1)
    assert moment(result.amplitude_density, 2) == pytest.approx(mu)
    assert moment(result.x_density, 0) == pytest.approx(1)
    assert moment(result.x_density, 2) == pytest.approx(mu / 2)
    assert moment(result.v_density, 2) == pytest.approx(omega**2 * mu / 2)
    if time is None:
        assert moment(result.x_density, 1) == pytest.approx(result.x_mean, abs=1e-9)
    if wall is not None:
        assert moment(result.impact_speed_density, 0) == pytest.approx(1)
        assert moment(result.impact_speed_density, 2) == pytest.approx(omega**2 * mu)
        if time is None:
            assert moment(result.impact_speed_density, 1) == pytest.approx(result.impact_speed_mean)


@given(oscillators)
def test_ito_equation_gives_the_mean_square(asked):
    """E[2 A drift] + diffusion vanishes for the stationary Rayleigh amplitude, and so does the probability flux."""
    result = averaging(asked)
    mu = result.amplitude_mean_square
    a = math.sqrt(mu) * np.array([0.3, 1.0, 2.0])
    step = 1e-5 * a
    slope = (np.log(result.amplitude_density(a + step)) - np.log(result.amplitude_density(a - step))) / (2 * step)
    np.testing.assert_allclose(
        result.drift(a), result.diffusion / 2 * slope, rtol=1e-6, atol=1e-6 * result.diffusion / math.sqrt(mu)
    )


def test_warning_where_the_springpot_is_not_light():
    (warning,) = warnings_of(averaging(oscillator()))
    assert "the validity map has gaps to Monte Carlo of up to: <A^2> 7" in warning
    assert warnings_of(averaging(oscillator(0.5, 0.05))) == ()
    assert warnings_of(averaging(oscillator(1.0))) == ()
    assert "factor Omega = 3" in averaging(oscillator(0.7, 0.2, omega=3.0), form="printed").warnings[0]


@pytest.mark.parametrize("barrier", [Barrier(), None])
def test_warning_where_nothing_was_checked(barrier):
    warning, *of_the_map = warnings_of(averaging(oscillator(0.5, 100.0, barrier=barrier)))
    assert ["no cell near" in sentence for sentence in of_the_map] == ([True] if barrier else [])
    assert "unchecked" in warning
    assert "100" in warning
    assert ("+8, +7, -2, -19, -40 %" if barrier else "2, 8, 25, 43, 61 % too low") in warning


@pytest.mark.validation
@pytest.mark.parametrize(("c", "error"), [(3.0, 7), (30.0, -19)])
def test_the_errors_of_a_strong_springpot_are_what_the_warning_says(c, error):
    asked = oscillator(0.5, c)
    formula, found = averaging(asked), simulate(asked, paths=1024, start="stationary", duration=300.0)
    gap = 100 * (formula.amplitude_mean_square / found["amplitude_mean_square"].value - 1)
    assert gap == pytest.approx(error, abs=1.5)
    assert 1.1 < formula.impact_rate / found["impact_rate"].value < 4.0


@pytest.mark.parametrize("c", [3.0, 30.0])
def test_a_strong_springpot_without_a_wall_against_the_exact_spectrum(c):
    def power(w: float) -> float:
        return (1 + w**2) / abs(1 - w**2 + c * (1j * w) ** 0.5) ** 2 / math.pi

    cuts = [0.0, 0.5, 2.0, 3 * c ** (2 / 3), math.inf]
    exact = sum(quad(power, low, high, limit=400)[0] for low, high in itertools.pairwise(cuts))
    error = averaging(oscillator(0.5, c, barrier=None)).amplitude_mean_square / exact - 1
    assert error == pytest.approx({3.0: -0.08, 30.0: -0.43}[c], abs=0.005)


def trusted(value):
    return trust(value, "memory_closure")


@pytest.mark.parametrize("value", [3, None, "oscillator", Springpot(0.5, 1.0)])
def test_what_is_not_a_system(value):
    methods = averaging, envelope, memory_closure, exact, fokker_planck
    for solve in (*methods, solve_all, all_methods, compare, trusted, recommended):
        with pytest.raises(TypeError, match=r"^system must be a System, not "):
            solve(value)


def test_infinite_time():
    result = averaging(oscillator())
    mu = result.amplitude_mean_square
    np.testing.assert_allclose(result.mean_square([math.inf, 1e300, 0.0], initial=3.0), [mu, mu, 3.0], rtol=1e-14)
    assert float(result.x_density(0.5, time=math.inf)) == pytest.approx(float(result.x_density(0.5)))
    with pytest.raises(NoStationaryStateError, match="grows"):
        averaging(oscillator(0.0)).mean_square(math.inf)


def test_densities_far_away_are_zero():
    result = averaging(oscillator())
    for density in (result.amplitude_density, result.x_density, result.v_density, result.impact_speed_density):
        np.testing.assert_array_equal(density([1e200, math.inf]), 0.0)


@pytest.mark.parametrize("amplitude", [0.0, -1.0, [1.0, 0.0], math.nan, math.inf])
def test_drift_refuses(amplitude):
    with pytest.raises(ValueError, match=r"^amplitude must be positive"):
        averaging(oscillator()).drift(amplitude)


@pytest.mark.parametrize("value", ["a", "1", None, [1.0, "b"], [[1.0], [1.0, 2.0]], 1j, True])
def test_what_is_not_a_number_is_named(value):
    result = averaging(oscillator())
    for ask, name in (
        (result.mean_square, "time"),
        (result.drift, "amplitude"),
        (result.amplitude_density, "amplitude"),
        (result.x_density, "displacement"),
        (result.v_density, "velocity"),
        (result.impact_speed_density, "speed"),
    ):
        with pytest.raises(TypeError, match=f"^{name} must be a real number"):
            ask(value)


def test_a_density_has_one_time():
    with pytest.raises(TypeError, match=r"^time must be one number"):
        averaging(oscillator()).x_density(1.0, time=[1.0, 2.0])
    with pytest.raises(ValueError, match="not NaN"):
        averaging(oscillator()).x_density(1.0, time=math.nan)


def test_dictionary_is_what_the_command_prints():
    answer = averaging(oscillator()).to_dict()
    assert list(answer) == [*names_of_results(oscillator()), "decay_rate", "assumptions", "warnings"]
    assert json.loads(json.dumps(answer)) == answer


def test_all_methods():
    both = all_methods(oscillator(0.7, 0.2, omega=3.0))
    assert list(both)[:2] == ["averaging_printed", "averaging"]
    assert both["averaging_printed"]["amplitude_mean_square"] == pytest.approx(3.519, abs=5e-4)
    assert both["averaging"]["amplitude_mean_square"] == pytest.approx(1.173, abs=5e-4)
    away = all_methods(oscillator(barrier=Barrier(position=1.0, free_side="above")))
    assert away["averaging"]["x_mean"] is None
    assert "covers a wall at position 0" in str(away["averaging"]["statement"])


def test_result_is_frozen():
    result = averaging(oscillator())
    assert isinstance(result, Averaging)
    with pytest.raises(AttributeError):
        result.decay_rate = 1.0


def shifted(*arguments, **words) -> Averaging:
    return averaging(oscillator(*arguments, **words), form="shifted")


@pytest.mark.parametrize("barrier", [Barrier(), None])
@pytest.mark.parametrize(
    ("alpha", "c", "omega"),
    [
        (0.5, 1.0, 1.0),
        (0.1, 30.0, 2.0),
        (0.9, 0.2, 0.3),
        (0.7, 1e4, 1.0),
    ],
)
def test_shifted_frequency_is_where_the_oscillation_is_in_balance(alpha, c, omega, barrier):
    """The harmonic balance of y'' + Omega^2 y + sgn(y) C D^alpha |y| = 0, by a plain sum over many harmonics."""
    result = shifted(alpha, c, omega=omega, barrier=barrier)
    w, m = result.frequency, np.arange(1.0, 20001.0)
    if barrier is None:
        stiffness, loss = c * w**alpha * math.cos(alpha * math.pi / 2), c * w**alpha * math.sin(alpha * math.pi / 2)
    else:
        force = 16 / math.pi**2 * c * float(np.sum((2 * m * w) ** alpha / (4 * m * m - 1) ** 2))
        stiffness, loss = force * math.cos(alpha * math.pi / 2), 0.0
        loss = (
            16
            / math.pi**2
            * c
            * math.sin(alpha * math.pi / 2)
            * float(np.sum(2 * m * (2 * m * w) ** alpha / (4 * m * m - 1) ** 2))
        )
    assert w**2 == pytest.approx(omega**2 + stiffness, rel=1e-9)
    assert result.decay_rate == pytest.approx(loss / (2 * w), rel=2e-5)
    assert result.v_mean_square == pytest.approx(1 / (4 * result.decay_rate))
    assert result.x_mean_square == pytest.approx(result.v_mean_square / w**2)


@pytest.mark.parametrize(("alpha", "v", "x"), [(0.7, -1.2, 1.2), (0.5, 1.1, 6.4), (0.3, 3.4, 11.8)])
def test_shifted_form_at_unit_coefficient(alpha, v, x):
    """Errors in per cent against recorded Monte Carlo from an adapted start."""
    found = {0.7: (0.665, 0.785), 0.5: (0.939, 1.189), 0.3: (1.672, 2.200)}[alpha]
    result = shifted(alpha)
    assert 100 * (result.v_mean_square / found[1] - 1) == pytest.approx(v, abs=1.2)
    assert 100 * (result.x_mean_square / found[0] - 1) == pytest.approx(x, abs=1.2)


def test_shifted_form_of_a_dashpot_and_of_a_light_springpot_is_the_corrected_one():
    for asked in (oscillator(1.0, 0.7), oscillator(0.4, 1e-9), oscillator(1.0, 0.7, barrier=None)):
        moved, plain = averaging(asked, form="shifted"), averaging(asked)
        assert moved.x_mean_square == pytest.approx(plain.x_mean_square, rel=1e-8)
        assert moved.decay_rate == pytest.approx(plain.decay_rate, rel=1e-8)


def test_shifted_moments_hang_together():
    result = shifted(0.4, 0.8, omega=2.0, q=3.0, barrier=Barrier(restitution=0.9, free_side="below"))
    w = result.frequency
    assert w > 2.0
    assert result.method == "averaging_amplitude"
    assert result.amplitude_mean_square == pytest.approx(result.x_mean_square + result.v_mean_square / 4)
    assert result.impact_rate == pytest.approx(w / math.pi)
    assert result.impact_speed_mean_square == pytest.approx(2 * result.v_mean_square)
    assert result.x_mean == pytest.approx(-math.sqrt(2 * result.x_mean_square / math.pi))
    assert float(result.mean_square(math.inf)) == pytest.approx(2 * result.x_mean_square)
    assert result.to_dict()["frequency"] == w
    assert "one frequency w" in " ".join(result.assumptions)
    (warning,) = warnings_of(result)
    assert "gaps to Monte Carlo" in warning


def test_shifted_form_warns_and_refuses():
    assert shifted(0.5, 0.03).warnings == ()
    assert "gaps to Monte Carlo" in warnings_of(shifted())[0]
    assert "unchecked" in shifted(0.5, 5.0).warnings[0]
    assert "without a wall" in shifted(barrier=None).warnings[0]
    with pytest.raises(NotCoveredError, match="position 0 or no wall"):
        shifted(barrier=Barrier(0.5, free_side="above"))
    with pytest.raises(NoStationaryStateError, match="order 0 is a spring"):
        _ = shifted(0.0).x_mean
    assert shifted(0.0).frequency ** 2 == pytest.approx(1 + (1 - 8 / math.pi**2), rel=1e-12)


@pytest.mark.parametrize(("alpha", "c"), [(0.7, 1.0), (0.5, 1.0), (0.3, 1.0), (0.1, 1.0), (0.7, 3.0), (0.3, 3.0)])
def test_the_shifted_warning_without_a_wall_against_the_exact_answer(alpha, c):
    said = {1.0: {0.7: -12, 0.5: -12, 0.3: -8, 0.1: -3}, 3.0: {0.7: -24, 0.3: -11.5}}[c][alpha]
    asked = oscillator(alpha, c, barrier=None)
    error = averaging(asked, form="shifted").amplitude_mean_square / exact(asked).amplitude_mean_square - 1
    assert 100 * error == pytest.approx(said, abs=0.5)


@pytest.mark.parametrize("form", ["corrected", "shifted"])
@pytest.mark.parametrize("wall", [Barrier(), None])
def test_densities_of_energy_and_of_both(form, wall):
    result = averaging(oscillator(0.4, 0.9, omega=1.6, q=2.0, barrier=wall), form=form)
    scale = result.amplitude_mean_square

    def moment(density, power, high):
        return quad(lambda u: u**power * float(density(u)), 0, high, limit=200)[0]

    assert moment(result.amplitude_density, 0, 12 * math.sqrt(scale)) == pytest.approx(1.0, rel=1e-8)
    assert moment(result.amplitude_density, 2, 12 * math.sqrt(scale)) == pytest.approx(scale, rel=1e-8)
    assert moment(result.energy_density, 0, 60 * scale) == pytest.approx(1.0, rel=1e-6)
    assert moment(result.energy_density, 1, 60 * scale) == pytest.approx(1.6**2 * scale / 2, rel=1e-6)
    x, v = np.meshgrid(np.linspace(-1, 3, 5), np.linspace(-2, 2, 4))
    np.testing.assert_allclose(result.joint_density(x, v), result.x_density(x) * result.v_density(v))
    assert float(np.asarray(result.energy_density(-1.0))) == 0.0


@pytest.mark.parametrize("form", ["corrected", "shifted"])
def test_correlation_is_that_of_a_folded_narrow_band(form):
    """Against sampled pairs: the modulus of a normal pair of correlation exp(-beta t) cos(wt)."""
    result = averaging(oscillator(0.5, 0.3), form=form)
    first, other = np.random.default_rng(3).standard_normal((2, 400_000))
    for lag in (0.4, 2.0, 5.0):
        rho = math.exp(-result.decay_rate * lag) * math.cos(result.frequency * lag)
        sample = np.abs(first) * np.abs(rho * first + math.sqrt(1 - rho**2) * other)
        assert float(result.correlation(lag)) / result.x_mean_square == pytest.approx(sample.mean(), rel=0.008)
    assert float(result.correlation(0.0)) == pytest.approx(result.x_mean_square)
    assert float(result.correlation(math.inf)) == pytest.approx(result.x_mean**2)
    assert float(result.correlation(-1.3)) == float(result.correlation(1.3))


@pytest.mark.parametrize("beta", [0.3, 0.03])
@pytest.mark.parametrize("form", ["corrected", "shifted"])
def test_spectrum_is_the_transform_of_the_correlation(beta, form):
    """By Gauss panels that never straddle a kink of the correlation, on every half period until nothing is left."""
    c = beta / averaging(oscillator(0.6, 1.0)).decay_rate
    result = averaging(oscillator(0.6, c), form=form)
    half_period = math.pi / result.frequency
    x, w = np.polynomial.legendre.leggauss(24)
    inner = np.array([0.0, 1e-4, 1e-3, 0.01, 0.06, 0.2, 0.5, 0.8, 0.94, 0.99, 0.999, 0.9999, 1.0])
    starts = np.arange(math.ceil(14 / (result.decay_rate * half_period)))
    edges = half_period * np.unique(np.add.outer(starts, inner))
    half = np.diff(edges) / 2
    t = ((edges[:-1] + half)[:, None] + half[:, None] * x).ravel()
    weight = (half[:, None] * w).ravel() * (result.correlation(t) - result.x_mean**2) / math.pi
    frequencies = result.frequency * np.array([0.0, 0.3, 1.0, 1.9, 2.0, 2.05, 4.0, 7.0])
    truth = np.array([float(weight @ np.cos(f * t)) for f in frequencies])
    np.testing.assert_allclose(result.spectrum(frequencies), truth, atol=2e-7 * truth.max())
    np.testing.assert_array_equal(result.spectrum(-frequencies), result.spectrum(frequencies))


@pytest.mark.parametrize("wall", [Barrier(), None])
def test_spectrum_has_the_variance(wall):
    result = averaging(oscillator(0.5, 1.0, omega=2.0, q=3.0, barrier=wall))
    panels = itertools.pairwise([0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 8.0, 20.0, 60.0, 200.0])
    total = 2 * sum(quad(lambda f: float(result.spectrum(f)), *ends)[0] for ends in panels)
    missing = 0.0 if wall else result.x_mean_square * 2 * result.decay_rate / (math.pi * 200.0)
    assert total + missing == pytest.approx(result.x_mean_square - result.x_mean**2, rel=2e-3 if wall else 1e-3)


def test_spectrum_of_an_almost_undamped_oscillator_is_lines():
    result = averaging(oscillator(0.5, 1e-7))
    line = float(result.spectrum(2.0))
    assert line > 1e5 * float(result.spectrum(1.0)) > 0
    with pytest.raises(ValueError, match=r"^frequency must be finite"):
        result.spectrum(math.inf)
    with pytest.raises(ValueError, match="not NaN"):
        result.correlation(math.nan)
    with pytest.raises(TypeError, match=r"^frequency must be a real number"):
        result.spectrum("a")
