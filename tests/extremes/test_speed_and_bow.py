"""Speeds of nothing, reversed, far above all criticals and on one that nothing damps; bows of a nanometre and more."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq

import gearbow as gb
from systems import MIDDLE, Hold, apart, rotor, train

BOW = gb.Bow.half_sine(1e-4, phase=0.4)


def swing(
    system: gb.RotorSystem, speed: float, duration: float = 5e-3, **options: object
) -> np.ndarray:
    options = {
        "initial": "rest",
        "record": [MIDDLE],
        "times": np.linspace(0, duration, 20),
    } | options
    return system.simulate(duration, speed, **options).displacement(MIDDLE)


@pytest.mark.parametrize("method", ["exponential", "rk45"])
def test_no_speed_is_the_limit_of_small_ones(hold: Hold, method: str):
    system = rotor(1e8, 100.0, bow=BOW)
    still = swing(system, 0.0, method=method, rtol=1e-9)
    worst = 0.0
    for speed in (1e-300, 1e-12, 1e-6, 1e-3, -1e-3):
        # the shaft turns by the speed times 5 ms
        worst = max(
            worst,
            apart(swing(system, speed, method=method, rtol=1e-9), still) / max(abs(speed), 1e-6),
        )
    hold(
        f'`"{method}"` at a small speed differs from rest by its share',
        "0, 1e-300 to 1e-3 rad/s",
        worst,
        0.1,
    )


def test_a_reversed_speed_is_the_mirror_image(hold: Hold):
    worst = 0.0
    for speed in (1.0, 300.0, 3e3, 3e4):
        forward = swing(rotor((1e8, 2e8), 100.0, bow=BOW), speed)
        back = swing(rotor((1e8, 2e8), 100.0, bow=gb.Bow.half_sine(1e-4, phase=-0.4)), -speed)
        worst = max(worst, apart(back * [1.0, -1.0], forward))
    # the mirrored matrices have other eigenvectors
    hold("a reversed speed is the mirror image", "1 to 3e4 rad/s", worst, 1e-9)


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
        "a run from the synchronous motion stays on it",
        "1 to 1e5 rad/s, 150 times the first critical",
        worst,
        1e-8,
    )


def critical(system: gb.RotorSystem) -> float:
    def off(speed: float) -> float:
        modes = system.modes(speed, count=4)
        return 2 * np.pi * float(modes.frequencies_hz[modes.whirl.index("forward")]) - speed

    return float(brentq(off, 300.0, 900.0, xtol=1e-12))


def test_on_a_critical_speed_that_nothing_damps(hold: Hold):
    system = rotor(1e9, bow=BOW)
    speed = critical(system)
    independent = swing(system, speed, 0.05, method="rk45", rtol=1e-10)
    worst = 0.0
    for off in (0.0, 1e-15, 1e-12, 1e-8, 1e-6, 9e-6, 1.1e-5, 1e-4):
        run = swing(system, speed * (1 + off), 0.05)
        # off by 1e-4 of 30 rad turned
        worst = max(worst, apart(run, independent) / max(off * 30, 1e-6))
    # growing all the time
    assert np.abs(independent[-5:]).max() > 2 * np.abs(independent[:8]).max()
    hold(
        "on a critical speed that nothing damps a run grows as it must",
        "on it, and off by 1e-15 to 1e-4 of it",
        worst,
        3.0,
        "no synchronous start: `SceneError`; `synchronous` gives an `AccuracyWarning`",
    )
    with pytest.raises(gb.SceneError, match="critical speed with too little damping"):
        system.simulate(0.01, speed, initial="synchronous")
    with pytest.warns(gb.AccuracyWarning, match=r"speeds\[1\]: a displacement of"):
        system.synchronous([100.0, speed])


@pytest.mark.implausible
def test_a_bow_gives_its_share(hold: Hold):
    worst = 0.0
    for phase in np.linspace(0, 2 * np.pi, 7):
        unit = swing(rotor(1e8, 100.0, bow=gb.Bow.half_sine(1e-4, phase=phase)), 300.0)
        for amplitude in (1e-9, 1e-6, 1e-2, 1e-1):
            found = swing(rotor(1e8, 100.0, bow=gb.Bow.half_sine(amplitude, phase=phase)), 300.0)
            worst = max(worst, apart(found * (1e-4 / amplitude), unit))
    hold("a bow gives its share, whatever its phase", "1e-9 to 0.1 m", worst, 1e-12)


@pytest.mark.implausible
def test_a_bow_in_a_train_until_the_base_circles_overlap(hold: Hold):
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
    # what moving centres add is of second order: 1e-6 m over 1e-2 m of the path of contact
    found = apart(small, run(1e-6))
    for amplitude in (1e-3, 3e-3):
        assert np.isfinite(run(amplitude)).all()
    with pytest.raises(gb.ContactError, match=r"overlap at \d"):
        run(1e-1)
    hold(
        "a bow of a train gives its share while it is small",
        "1e-9 to 1e-6 m",
        found,
        1e-3,
        "`ContactError` with mesh and instant where base circles overlap",
    )


def test_jagged_readings(hold: Hold):
    # As many readings as half waves of the spline, alternating: a free shaft that turns slowly follows them.
    places = np.linspace(0.0, 1.0, 21)
    heights = np.where(np.arange(21) % 2, 1e-4, -1e-4)
    bow = gb.Bow.points(places, heights)
    system = rotor(1e9, 100.0, elements=40, bow=bow)
    heights = heights - heights[0]  # the bearings hold both ends, which stand at the same height
    found = [system.synchronous([1e-3]).displacement(("rotor", float(x)))[0, 0, 0] for x in places]
    # straight off only by what the bearings give way
    hold(
        "jagged readings are followed at their places",
        "21 readings of ±1e-4 m",
        apart(found, heights),
        1e-6,
    )
