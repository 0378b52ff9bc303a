"""Thermal bow: stability against a closed form and a slow integration."""

import math
from collections.abc import Callable

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import gearbow as gb
from reference.cases import each_case
from reference.machines import BENDING_STIFFNESS, DISK_MASS, MASSLESS, RIGID, massless_rotor

LENGTH, MASS, DAMPING = MASSLESS["length"], DISK_MASS, 400.0
STIFFNESS = 1.0 / (1.0 / BENDING_STIFFNESS + 0.5 / RIGID)
FREQUENCY = math.sqrt(STIFFNESS / MASS)
pytestmark = pytest.mark.filterwarnings("ignore:natural frequencies range:gearbow.AccuracyWarning")
#: Bow at 1 K [m], time constant [s] and gain [K/m].
BOW, TAU, GAIN = 1e-6, 250.0, 2.5e5 * np.exp(0.7j)


def bent(curve: Callable[[float], complex]) -> dict:
    """Give the fields of a massless shaft with a bow, with enough elements for its curve."""
    return {"elements": 8, "degree": 3, "bow": gb.Bow.function(curve)}


def jeffcott(unbalance: complex = 2e-4 + 1e-4j) -> gb.RotorSystem:
    """Give a damped disk amid a bowed massless shaft on rigid bearings."""

    def cubic(x: float) -> complex:
        near = min(x, LENGTH - x) / LENGTH
        return 2e-5j * (3.0 * near - 4.0 * near**3)

    return massless_rotor(bent(cubic), damping=DAMPING, unbalance=unbalance)


def hot(**changes) -> gb.ThermalBow:
    """Give a thermal bow with the deflection of a force in the middle."""

    def cubic(x: float) -> complex:
        near = min(x, LENGTH - x) / LENGTH
        return BOW * (3.0 * near - 4.0 * near**3)

    given = {"at": "d", "gain": GAIN, "time_constant": TAU, "shape": gb.Bow.function(cubic)}
    return gb.ThermalBow(**{**given, **changes})


SPEEDS = FREQUENCY * np.array([0.2, 0.7, 0.98, 1.3, 2.5])


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_a_jeffcott_rotor_has_the_eigenvalue_of_the_closed_form(sense: float):
    speeds = sense * SPEEDS
    # In the mirrored rotor, angles along the rotation change their sign.
    gain = GAIN if sense > 0.0 else GAIN.conjugate()
    found = jeffcott().thermal_bow(hot(gain=gain), speeds)
    # y = k b/(k - mΩ² + icΩ)
    response = STIFFNESS * BOW / (STIFFNESS - MASS * speeds**2 + 1j * DAMPING * speeds)
    expected = (response * gain - 1.0) / TAU
    # The mass of the shaft is 1e-7 of that of the disk, and the curve is sampled at 257 points.
    np.testing.assert_allclose(found.eigenvalues, expected, rtol=1e-5)
    np.testing.assert_array_equal(found.stable, (response * gain).real < 1.0)
    assert not found.stable.all()
    assert found.stable.any()
    np.testing.assert_allclose(found.periods, 2.0 * np.pi / abs(expected.imag), rtol=1e-4)


def test_a_slow_integration_with_synchronous_responses_has_the_same_growth():
    system, bow, speed = jeffcott(), hot(), 0.98 * FREQUENCY
    stability = system.thermal_bow(bow, speed)

    def vibration(temperature: complex) -> complex:
        """Compute the synchronous response with the bow of this temperature difference."""

        def curve(x: float) -> complex:
            return system.shafts[0].bow.curve(x) + temperature * bow.shape.curve(x)

        bowed = system.replace(shafts=massless_rotor(bent(curve)).shafts)
        v, w = bowed.synchronous(speed).displacement("d")[0, 0]
        return (v + 1j * w) / 2.0

    def rate(_: float, state: np.ndarray) -> np.ndarray:
        temperature = state[0] + 1j * state[1]
        change = (GAIN * vibration(temperature) - temperature) / TAU
        return np.array([change.real, change.imag])

    duration = 2.0 * TAU
    run = solve_ivp(rate, (0.0, duration), np.zeros(2), rtol=1e-6, dense_output=True)
    spiral = stability.spiral(speed, duration, count=9)
    expected = run.sol(spiral.time)
    size = abs(spiral.temperature).max()
    np.testing.assert_allclose(spiral.temperature, expected[0] + 1j * expected[1], atol=1e-3 * size)
    assert spiral.vibration[-1] == pytest.approx(vibration(spiral.temperature[-1]), rel=1e-3)
    # λ from the integration: the differences of equal times form a geometric series.
    at = run.sol(np.array([0.0, 0.5, 1.0]) * duration)
    values = at[0] + 1j * at[1]
    ratio = (values[2] - values[1]) / (values[1] - values[0])
    found = np.log(ratio) / (0.5 * duration)
    turns = 2.0j * np.pi / (0.5 * duration)
    found += turns * np.round((stability.eigenvalues[0] - found).imag / turns.imag)
    assert found == pytest.approx(stability.eigenvalues[0], rel=1e-3)


def test_the_gain_may_depend_on_the_speed_of_the_shaft():
    constant = jeffcott().thermal_bow(hot(), SPEEDS)
    falling = jeffcott().thermal_bow(hot(gain=lambda speed: GAIN * 100.0 / speed), SPEEDS)
    np.testing.assert_allclose(falling.loop_gain, constant.loop_gain * 100.0 / SPEEDS, rtol=1e-12)


def test_a_spiral_at_the_limit_of_stability_grows_with_the_time():
    one = np.ones(1, complex)
    limit = gb.results.ThermalStability("d", np.ones(1), 10.0, 2.0 * one, 0.5 * one, 3.0 * one)
    found = limit.spiral(1.0, 50.0, count=6)
    np.testing.assert_allclose(found.temperature, 2.0 * 3.0 / 10.0 * found.time, rtol=1e-12)


def test_results_are_tables_with_a_verdict():
    found = jeffcott().thermal_bow(hot(), SPEEDS)
    assert str(found).startswith("thermal bow by d: unstable at")
    assert list(found.to_dataframe()["verdict"]) == [
        "stable" if stable else "unstable" for stable in found.stable
    ]
    spiral = found.spiral(SPEEDS[1], 100.0)
    assert spiral.to_dataframe()["time [s]"].iloc[-1] == 100.0


WRONG = {
    "time constant": (lambda: hot(time_constant=0.0), r"time_constant: must be positive"),
    "gain": (lambda: hot(gain=float("nan")), r"gain: must be a finite"),
    "function": (
        lambda: jeffcott().thermal_bow(hot(gain=lambda _: float("nan")), 10.0),
        r"gain: must be a finite complex number",
    ),
    "shape": (lambda: hot(shape=1e-6), r"shape: must be a gb.Bow"),
    "place": (lambda: jeffcott().thermal_bow(hot(at="disc"), 10.0), r"bow.at: no shaft"),
    "bow": (lambda: jeffcott().thermal_bow(gb.Bow.half_sine(1e-6), 10.0), r"bow: must be a gb.Th"),
    "speed": (
        lambda: jeffcott().thermal_bow(hot(), [10.0]).spiral(11.0, 5.0),
        r"speed: the result has no 11 rad/s; the nearest is 10 rad/s",
    ),
}


@each_case("name", list(WRONG))
def test_wrong_values_are_errors(name: str):
    make, message = WRONG[name]
    with pytest.raises(gb.SceneError, match=message):
        make()
