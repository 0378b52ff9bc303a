"""Extreme speeds and bows: zero, reversed, supercritical and undamped critical speeds; bows from 1
nm to 0.1 m.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq

import gearbow as gb
from systems import MIDDLE, Hold, apart, rotor, train

BOW = gb.Bow.half_sine(1e-4, phase=0.4)


def simulated(
    system: gb.RotorSystem, speed: float, duration: float = 5e-3, **options: object
) -> np.ndarray:
    options = {
        "initial": "rest",
        "record": [MIDDLE],
        "times": np.linspace(0, duration, 20),
    } | options
    return system.simulate(duration, speed, **options).displacement(MIDDLE)


@pytest.mark.parametrize("method", ["exponential", "rk45"])
def test_low_speeds_converge_to_zero_speed(hold: Hold, method: str):
    system = rotor(1e8, 100.0, bow=BOW)
    still = simulated(system, 0.0, method=method, rtol=1e-9)
    worst = 0.0
    for speed in (1e-300, 1e-12, 1e-6, 1e-3, -1e-3):
        # The shaft rotates by speed × 5 ms, which bounds the relative difference.
        worst = max(
            worst,
            apart(simulated(system, speed, method=method, rtol=1e-9), still)
            / max(abs(speed), 1e-6),
        )
    hold(
        f'`"{method}"` at low speed: relative difference from zero speed / speed in rad/s',
        "speed 1e-300 to 1e-3 rad/s",
        worst,
        0.1,
    )


def test_reversed_speed_mirrors_the_motion(hold: Hold):
    worst = 0.0
    for speed in (1.0, 300.0, 3e3, 3e4):
        forward = simulated(rotor((1e8, 2e8), 100.0, bow=BOW), speed)
        back = simulated(rotor((1e8, 2e8), 100.0, bow=gb.Bow.half_sine(1e-4, phase=-0.4)), -speed)
        worst = max(worst, apart(back * [1.0, -1.0], forward))
    # Round-off differs because the mirrored matrices have different eigenvectors.
    hold(
        "A reversed speed gives the mirrored motion",
        "speed 1 to 3e4 rad/s",
        worst,
        1e-9,
    )


def test_runs_stay_on_the_synchronous_motion(hold: Hold):
    worst = 0.0
    system = rotor(1e8, 1e3, bow=BOW)
    for speed in (1.0, 1e2, 1e3, 1e4, 1e5):
        v, w = system.synchronous([speed]).displacement(MIDDLE)[0, 0]
        times = np.linspace(0, 20.0 / speed, 30)
        found = system.simulate(times[-1], speed, record=[MIDDLE], times=times).displacement(MIDDLE)
        turning = np.exp(1j * speed * times)
        worst = max(worst, apart(found, np.real(np.outer(turning, [v, w]))))
    hold(
        "A run that starts on the synchronous motion stays on it",
        "speed 1 to 1e5 rad/s, 150 times the first critical speed",
        worst,
        1e-8,
    )


def critical(system: gb.RotorSystem) -> float:
    def off(speed: float) -> float:
        modes = system.modes(speed, count=4)
        return 2 * np.pi * float(modes.frequencies_hz[modes.whirl.index("forward")]) - speed

    return float(brentq(off, 300.0, 900.0, xtol=1e-12))


def test_growth_at_an_undamped_critical_speed(hold: Hold):
    system = rotor(1e9, bow=BOW)
    speed = critical(system)
    independent = simulated(system, speed, 0.05, method="rk45", rtol=1e-10)
    worst = 0.0
    for off in (0.0, 1e-15, 1e-12, 1e-8, 1e-6, 9e-6, 1.1e-5, 1e-4):
        run = simulated(system, speed * (1 + off), 0.05)
        # The shaft rotates by 30 rad: a relative speed offset changes the phase by 30 rad × offset.
        worst = max(worst, apart(run, independent) / max(off * 30, 1e-6))
    # The amplitude grows without bound.
    assert np.abs(independent[-5:]).max() > 2 * np.abs(independent[:8]).max()
    hold(
        "Growth at an undamped critical speed: difference from an independent run / (30 × speed offset, at least 1e-6)",
        "relative speed offset 0 and 1e-15 to 1e-4",
        worst,
        3.0,
        '`initial="synchronous"`: `SceneError`; `system.synchronous`: `AccuracyWarning`',
    )
    with pytest.raises(gb.SceneError, match="critical speed with too little damping"):
        system.simulate(0.01, speed, initial="synchronous")
    with pytest.warns(gb.AccuracyWarning, match=r"speeds\[1\]: a displacement is"):
        system.synchronous([100.0, speed])


@pytest.mark.implausible
def test_response_is_proportional_to_the_bow(hold: Hold):
    worst = 0.0
    for phase in np.linspace(0, 2 * np.pi, 7):
        unit = simulated(rotor(1e8, 100.0, bow=gb.Bow.half_sine(1e-4, phase=phase)), 300.0)
        for amplitude in (1e-9, 1e-6, 1e-2, 1e-1):
            found = simulated(
                rotor(1e8, 100.0, bow=gb.Bow.half_sine(amplitude, phase=phase)), 300.0
            )
            worst = max(worst, apart(found * (1e-4 / amplitude), unit))
    hold(
        "The response is proportional to the bow at any bow phase",
        "bow 1e-9 to 0.1 m",
        worst,
        1e-12,
    )


@pytest.mark.implausible
def test_train_response_is_proportional_to_a_small_bow(hold: Hold):
    def run(amplitude: float) -> np.ndarray:
        moved = []
        for bow in (gb.Bow.half_sine(amplitude), None):
            system = train(bow=bow, torque=1.0)
            found = system.simulate(
                5e-3, 100.0, initial="rest", rtol=1e-9, times=np.linspace(0, 5e-3, 20)
            )
            moved.append(found.displacement("ga"))
        return moved[0] - moved[1]

    small = run(1e-9) * 1e3
    # Moving centres add a second-order effect: bow 1e-6 m / path of contact 1e-2 m.
    found = apart(small, run(1e-6))
    for amplitude in (1e-3, 3e-3):
        assert np.isfinite(run(amplitude)).all()
    with pytest.raises(gb.ContactError, match=r"overlap at \d"):
        run(1e-1)
    hold(
        "The response of a train is proportional to a small bow",
        "bow 1e-9 to 1e-6 m",
        found,
        1e-3,
        "overlapping base circles: `ContactError` with mesh and time",
    )


def test_bow_with_alternating_measured_values(hold: Hold):
    # Measured values of alternating sign give the spline its shortest wavelength. A slowly rotating
    # shaft follows it.
    places = np.linspace(0.0, 1.0, 21)
    heights = np.where(np.arange(21) % 2, 1e-4, -1e-4)
    bow = gb.Bow.points(places, heights)
    system = rotor(1e9, 100.0, elements=40, bow=bow)
    heights = heights - heights[0]  # the bearings hold both ends, which have the same value
    found = [system.synchronous([1e-3]).displacement(("rotor", float(x)))[0, 0, 0] for x in places]
    # The tolerance covers the deflection of the bearings.
    hold(
        "A bow from alternating measured values is exact at the measuring points",
        "21 values of ±1e-4 m",
        apart(found, heights),
        1e-6,
    )
