"""Extreme changes of the speed: slow and fast ramps, coast-downs to rest, and late start times."""

from __future__ import annotations

import numpy as np
import pytest

import gearbow as gb
from systems import MIDDLE, Hold, apart, rotor, train

BOW = gb.Bow.half_sine(1e-4, phase=0.4)
TIMES = np.linspace(0.0, 5e-3, 20)


def motion(system: gb.RotorSystem, profile: gb.SpeedProfile, **options: object) -> np.ndarray:
    """Return the displacements of the rotor at mid-length, or of the first gear of a train."""
    point = "ga" if system.gears else MIDDLE
    options = {"initial": "rest", "times": TIMES, "record": [point]} | options
    return system.simulate(TIMES[-1], profile, **options).displacement(point)


@pytest.mark.implausible
@pytest.mark.parametrize("scene", ["rotor", "train"])
def test_the_methods_agree_at_any_acceleration(hold: Hold, scene: str):
    system = rotor(1e7, 100.0, bow=BOW) if scene == "rotor" else train(bow=BOW)
    worst = 0.0
    for start, end in ((0.0, 1e-6), (100.0, 100.1), (0.0, 300.0), (3e3, 0.0), (1e4, 3e4)):
        profile = gb.SpeedProfile.ramp(start, end, TIMES[-1])
        exact = motion(system, profile, method="rk45", rtol=1e-10)
        worst = max(worst, apart(motion(system, profile, rtol=1e-6), exact))
    hold(
        f'`"exponential"` and `"rk45"` agree during a ramp, {scene}',
        "0 to 3e4 rad/s, acceleration 2e-4 to 4e6 rad/s²",
        worst,
        1e-4,
    )


def test_a_constant_profile_gives_the_motion_at_constant_speed(hold: Hold):
    worst = 0.0
    for system in (rotor(1e7, 100.0, bow=BOW), train(bow=BOW)):
        profile = gb.SpeedProfile.ramp(100.0, 100.0 * (1.0 + 1e-14), TIMES[-1])
        exact = motion(system, gb.SpeedProfile.ramp(100.0, 100.0, 1.0), rtol=1e-9)
        worst = max(worst, apart(motion(system, profile, rtol=1e-9), exact))
    hold(
        "A profile of constant speed gives the motion of a profile that changes by round-off",
        "relative change 1e-14",
        worst,
        1e-8,
    )


def test_a_jump_of_the_speed_within_a_microsecond(hold: Hold):
    # A shaft without bow and unbalance feels a change of speed only through gyroscopic moments; the
    # limit of ever shorter ramps is the motion after a sudden change of speed.
    system = rotor(1e7, 100.0, gravity=(0.0, -9.81))
    sudden = motion(system, gb.SpeedProfile.ramp(500.0, 500.0, 1.0), rtol=1e-9)
    worst = 0.0
    for length in (1e-6, 1e-9):
        profile = gb.SpeedProfile.ramp(100.0, 500.0, length)
        worst = max(worst, apart(motion(system, profile, rtol=1e-9), sudden))
    hold("A ramp within a microsecond acts as a sudden change", "1e-9 to 1e-6 s", worst, 1e-5)


def test_a_late_start_gives_the_same_motion(hold: Hold):
    # A run-up after 6e3 s at constant speed: the angle has rotated by 6e5 rad.
    system = rotor(1e7, 100.0, bow=BOW)
    start = 2.0 * np.pi * 1e3
    first = system.simulate(start, 100.0, record=[], times=[start])
    late = gb.SpeedProfile.ramp(100.0, 300.0, TIMES[-1], begin=start)
    options = {"record": [MIDDLE], "rtol": 1e-9}
    found = system.simulate(TIMES[-1], late, initial=first, times=start + TIMES, **options)
    early = system.simulate(
        TIMES[-1],
        gb.SpeedProfile.ramp(100.0, 300.0, TIMES[-1]),
        initial="synchronous",
        times=TIMES,
        **options,
    )
    hold(
        "A run-up after a long time at constant speed gives the same motion",
        "start time 6e3 s, angle 6e5 rad",
        apart(found.displacement(MIDDLE), early.displacement(MIDDLE)),
        1e-7,
    )
