"""Extreme geometry: element length, slenderness, wall thickness and number of elements."""

from __future__ import annotations

import numpy as np
import pytest

import gearbow as gb
from systems import GRAVITY, MIDDLE, E, Hold, apart, rotor, sag, train


@pytest.mark.filterwarnings("ignore::gearbow.AccuracyWarning")
def test_short_element_does_not_change_linear_results(hold: Hold):
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

    # The same shaft without the short element. The other elements keep almost the same length.
    plain = answers(0.0)
    worst = max(np.abs(answers(short) / plain - 1).max() for short in (1e-5, 1e-6, 1e-7))
    with pytest.warns(
        gb.AccuracyWarning, match=r"shortest element, 1\.000e-8 m, on shaft \"rotor\" at 0\.3 m"
    ):
        answers(1e-8)
    hold(
        "One short element among elements of 0.1 m does not change modes, equilibrium and synchronous response",
        "element length 1e-5 to 1e-7 m",
        worst,
        1e-6,
        "`AccuracyWarning` names the shortest element, at 1e-6 m and below",
    )


@pytest.mark.filterwarnings("ignore::gearbow.AccuracyWarning")
def test_short_element_does_not_change_runs(hold: Hold):
    def run(short: float) -> np.ndarray:
        system = train(bow=gb.Bow.half_sine(1e-4), first=short)
        return system.simulate(5e-3, 100.0, rtol=1e-9, output_step=1e-4).displacement("ga")

    plain = run(0.0)
    worst = max(apart(run(short), plain) for short in (1e-3, 1e-4, 1e-5))
    # The torsional frequency of a short element is ten times its bending frequency. The warning
    # states an upper bound of the error.
    with pytest.warns(gb.AccuracyWarning, match=r"may reach 8e-3; .* shortest element"):
        beyond = apart(run(1e-6), plain)
    # 1e-6 is reached; the subspace iteration finds the lowest modes again where the element is shortest.
    assert worst < 1e-5
    assert beyond < 8e-3
    hold(
        "One short element does not change the simulated displacement of a train",
        "element length 1e-3 to 1e-5 m",
        worst,
        1e-5,
        "`AccuracyWarning` at 5e-5 m and below; at 1e-6 m the error of a run is 1e-4 to 1e-3",
    )


@pytest.mark.implausible
def test_static_sag_of_slender_and_short_shafts(hold: Hold):
    worst = 0.0
    for over in (0.5, 1.0, 10.0, 100.0, 1e3, 1e4):
        diameters, length = (0.1, 0.0), 0.05 * over
        stiffness = 1e2 * E * np.pi * 0.05**4 / 4 / length**3
        # Gravity is scaled by 1e-6: the sag of the 500 m shaft stays smaller than its length.
        system = rotor(stiffness, length=length, diameters=diameters, gravity=1e-6 * GRAVITY)
        hangs = -1e6 * system.static().displacement(("rotor", length / 2))[1]
        worst = max(worst, abs(hangs / sag(length, diameters, stiffness) - 1))
    hold(
        "The static sag of a shaft under gravity equals the closed form",
        "length / radius 0.5 to 1e4",
        worst,
        1e-9,
    )


def test_static_sag_of_thin_walled_tubes(hold: Hold):
    worst = 0.0
    for wall in (0.5, 1e-1, 1e-2, 1e-3, 1e-4, 1e-5):
        diameters = (0.1, 0.1 * (1 - wall))
        system = rotor(1e6, diameters=diameters, gravity=GRAVITY)
        worst = max(
            worst, abs(-system.static().displacement(MIDDLE)[1] / sag(1.0, diameters, 1e6) - 1)
        )
    # The difference of the two radii loses five digits at the thinnest wall.
    hold(
        "The static sag of a thin-walled tube equals the closed form",
        "wall thickness / outer radius 0.5 to 1e-5",
        worst,
        1e-9,
    )


def test_static_sag_is_independent_of_element_count(hold: Hold):
    # The consistent nodal loads of gravity are exact for any number of elements.
    worst = 0.0
    for count in (2, 10, 50, 200):
        system = rotor(1e7, elements=count, gravity=GRAVITY)
        worst = max(
            worst, abs(-system.static().displacement(MIDDLE)[1] / sag(1.0, (0.05, 0.0), 1e7) - 1)
        )
    hold(
        "The static sag does not depend on the number of elements", "2 to 200 elements", worst, 1e-9
    )


def test_bowed_shaft_with_one_element():
    # The coarsest model has one element. Its first frequency is inaccurate, but runs and modes are
    # finite.
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
