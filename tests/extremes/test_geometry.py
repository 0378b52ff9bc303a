"""Elements, slenderness, walls and numbers of elements far from what a shaft drawing has."""

from __future__ import annotations

import numpy as np
import pytest

import gearbow as gb
from systems import GRAVITY, MIDDLE, E, Hold, apart, rotor, sag, train


@pytest.mark.filterwarnings("ignore::gearbow.AccuracyWarning")
def test_a_short_element_changes_nothing(hold: Hold):
    def answers(short: float) -> np.ndarray:
        segments = [(0.3, 3), (short, 1), (0.7 - short, 4)]
        system = rotor(1e8, 100.0, segments=segments, bow=gb.Bow.half_sine(1e-4), gravity=GRAVITY)
        place = ("rotor", 0.3)
        return np.concatenate(
            [
                system.modes(200.0, count=4).frequencies_hz,
                1e6 * system.static().displacement(place)[1:],
                1e6 * np.abs(system.synchronous([200.0]).displacement(place)).ravel(),
            ]
        )

    # The same shaft without the short element, which makes the others finer by its own length.
    plain = answers(0.0)
    worst = max(np.abs(answers(short) / plain - 1).max() for short in (1e-5, 1e-6, 1e-7))
    with pytest.warns(
        gb.AccuracyWarning, match=r"shortest element, 1\.000e-8 m, on shaft \"rotor\" at 0\.3 m"
    ):
        answers(1e-8)
    hold(
        "a short element beside others of 0.1 m changes no mode, equilibrium or synchronous response",
        "1e-5 to 1e-7 m",
        worst,
        1e-6,
        "`AccuracyWarning` names the shortest element, from 1e-6 m on",
    )


@pytest.mark.filterwarnings("ignore::gearbow.AccuracyWarning")
def test_runs_do_not_see_a_short_element(hold: Hold):
    def run(short: float) -> np.ndarray:
        system = train(bow=gb.Bow.half_sine(1e-4), first=short)
        return system.simulate(5e-3, 100.0, rtol=1e-9, output_step=1e-4).displacement("ga")

    plain = run(0.0)
    worst = max(apart(run(short), plain) for short in (1e-3, 1e-4, 1e-5))
    # twist makes a short element ten times as fast as bending does, and the estimate of the warning is met
    with pytest.warns(gb.AccuracyWarning, match=r"may take up to 8e-3 .* shortest element"):
        beyond = apart(run(1e-6), plain)
    assert worst < beyond < 8e-3
    hold(
        "nor does a run of a train see it",
        "1e-3 to 1e-5 m",
        worst,
        1e-5,
        "`AccuracyWarning` from 5e-5 m on; at 1e-6 m a run is off by 1e-4 to 1e-3",
    )


@pytest.mark.implausible
def test_equilibrium_of_slender_and_of_deep_shafts(hold: Hold):
    worst = 0.0
    for over in (0.5, 1.0, 10.0, 100.0, 1e3, 1e4):
        diameters, length = (0.1, 0.0), 0.05 * over
        stiffness = 1e2 * E * np.pi * 0.05**4 / 4 / length**3
        # a weight of a millionth, so that 500 m of shaft hang by less than that
        system = rotor(stiffness, length=length, diameters=diameters, gravity=1e-6 * GRAVITY)
        hangs = -1e6 * system.static().displacement(("rotor", length / 2))[1]
        worst = max(worst, abs(hangs / sag(length, diameters, stiffness) - 1))
    hold(
        "the sag of a shaft under its weight is the closed form",
        "length over radius 0.5 to 1e4",
        worst,
        1e-9,
    )


def test_walls_of_tubes(hold: Hold):
    worst = 0.0
    for wall in (0.5, 1e-1, 1e-2, 1e-3, 1e-4, 1e-5):
        diameters = (0.1, 0.1 * (1 - wall))
        system = rotor(1e6, diameters=diameters, gravity=GRAVITY)
        worst = max(
            worst, abs(-system.static().displacement(MIDDLE)[1] / sag(1.0, diameters, 1e6) - 1)
        )
    # the difference of the radii has lost as many digits
    hold("a thin tube hangs as the closed form", "wall over radius 0.5 to 1e-5", worst, 1e-9)


def test_one_to_many_elements(hold: Hold):
    # A weight is carried to the nodes exactly, however many there are.
    worst = 0.0
    for count in (2, 10, 50, 200):
        system = rotor(1e7, elements=count, gravity=GRAVITY)
        worst = max(
            worst, abs(-system.static().displacement(MIDDLE)[1] / sag(1.0, (0.05, 0.0), 1e7) - 1)
        )
    hold("the number of elements does not matter to the sag", "2 to 200 elements", worst, 1e-9)


def test_a_bow_as_long_as_one_element():
    # One element alone: straight lines of bending between its ends, still a system that answers.
    system = gb.RotorSystem(
        shafts=[
            gb.Shaft(
                "rotor", length=1.0, outer_diameter=0.05, elements=1, bow=gb.Bow.half_sine(1e-4)
            )
        ],
        bearings=[gb.Bearing("rotor", x, stiffness=1e8) for x in (0.0, 1.0)],
    )
    run = system.simulate(0.01, 100.0, record=[("rotor", 1.0)])
    assert np.isfinite(run.displacement(("rotor", 1.0))).all()
    assert apart(system.modes(count=1).frequencies_hz, [98.0]) < 0.2
