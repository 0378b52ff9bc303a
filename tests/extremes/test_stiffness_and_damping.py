"""Extreme bearing stiffness and damping, cross-coupled bearings, repeated modes."""

from __future__ import annotations

import numpy as np
import pytest

import gearbow as gb
from systems import GRAVITY, MIDDLE, Hold, apart, at, released, rotor, sag, train

# The tests check results that come with an accuracy warning.
pytestmark = [
    pytest.mark.implausible,
    pytest.mark.filterwarnings("ignore::gearbow.AccuracyWarning"),
]

TIMES = [1e-3, 7e-3]
ONE_SIDED = [[1e8, 1e10], [0.0, 1e8]]
CROSSED = {
    "one-sided": ONE_SIDED,
    "one-sided, weak": [[1e8, 1e7], [0.0, 1e8]],
    "circulatory": [[1e8, 1e9], [-1e9, 1e8]],
    "purely circulatory": [[0.0, 1e8], [-1e8, 0.0]],
    "indefinite": [[1e8, 2e8], [2e8, 1e8]],
    "nearly singular": [[1e8, 1e8 - 1.0], [1e8 - 1.0, 1e8]],
    "singular symmetric part": [[1e8, 2e8], [0.0, 1e8]],
}


def moved(system: gb.RotorSystem, **options: object) -> np.ndarray:
    options = {
        "method": "exponential",
        "initial": "rest",
        "record": [MIDDLE],
        "times": TIMES,
    } | options
    return system.simulate(TIMES[-1], 300.0, **options).displacement(MIDDLE)


def test_static_sag_with_soft_and_stiff_bearings(hold: Hold):
    worst = 0.0
    for power in range(-2, 13, 2):
        system = rotor(10.0**power, gravity=1e-6 * GRAVITY)
        found = -1e6 * system.static().displacement(MIDDLE)[1]
        worst = max(worst, abs(found / sag(1.0, (0.05, 0.0), 10.0**power) - 1))
    hold(
        "The static sag of a rotor on two bearings equals the closed form",
        "bearing stiffness 1e-2 to 1e12 N/m",
        worst,
        1e-8,
    )


def test_soft_bearings_balance_a_stiff_mesh(hold: Hold):
    # The torque is 1 mN m: bearings of 100 N/m deflect by micrometres.
    worst = 0.0
    for soft, stiff in ((1e2, 2e8), (1e2, 2e11), (1e4, 2e13)):
        system = train(soft, 0.0, torque=1e-3, stiffness=stiff)
        static = system.static()
        force = static.mesh(("ga", "gb")).force
        carried = sum(np.hypot(*static.bearing_force(("a", x))) for x in (0.0, 0.5))
        worst = max(worst, abs(carried / force - 1))
        assert system.modes().frequencies_hz[0] == 0.0
        assert system.modes().frequencies_hz[1] > 0.0
    hold(
        "The forces of soft bearings balance the force of a stiff mesh",
        "mesh stiffness / bearing stiffness up to 2e9",
        worst,
        1e-4,
        "`AccuracyWarning` names the bearing, mesh or element",
    )


@pytest.mark.parametrize("method", ["exponential", "rk45"])
def test_runs_with_bearings_of_any_stiffness_and_damping(hold: Hold, method: str):
    worst = 0.0
    powers = (0, 4, 8, 12) if method == "exponential" else (0, 8)
    dampers = (0.0, 1e3, 1e6) if method == "exponential" else (0.0, 1e3)
    for power in powers:
        for damping in dampers:
            system = rotor(10.0**power, damping, elements=4, gravity=GRAVITY)
            exact = released(system, 300.0, TIMES)[:, at(system, MIDDLE)]
            worst = max(worst, apart(moved(system, method=method, rtol=1e-9), exact))
    through = {
        "exponential": "bearing stiffness 1 to 1e12 N/m, damping 0 to 1e6 N s/m",
        "rk45": "bearing stiffness 1 to 1e8 N/m, damping 0 to 1e3 N s/m",
    }[method]
    hold(f'`"{method}"` equals the matrix exponential', through, worst, 1e-6)


@pytest.mark.parametrize("name", CROSSED)
def test_equilibrium_of_cross_coupled_bearings(name: str):
    system = rotor(CROSSED[name], 1e3, elements=4, gravity=GRAVITY)
    matrices = system.matrices()
    down = np.array([-GRAVITY if kind == "w" else 0.0 for _, _, kind in matrices.dofs])
    exact = np.linalg.solve(matrices.stiffness, matrices.mass @ down)
    # The stiffness ratio of the elements to the softest bearing direction limits the number of
    # digits.
    assert apart(system.static().displacement(MIDDLE), exact[at(system, MIDDLE)]) < 1e-6


@pytest.mark.parametrize("method", ["exponential", "rk45"])
def test_runs_with_cross_coupled_bearings(hold: Hold, method: str):
    worst = 0.0
    for coefficients in CROSSED.values():
        system = rotor(coefficients, 1e3, elements=4, gravity=GRAVITY)
        exact = released(system, 300.0, TIMES)[:, at(system, MIDDLE)]
        worst = max(worst, apart(moved(system, method=method, rtol=1e-10), exact))
    # The error of an unstable motion grows with the motion.
    allowed = 1e-6
    hold(
        f'`"{method}"` equals the matrix exponential with any non-singular 2×2 bearing stiffness, stable or unstable',
        "cross-coupling up to 100 times the direct stiffness; indefinite and one-sided matrices",
        worst,
        allowed,
        "displacement larger than the shaft: `AccuracyWarning`; overflow: `StabilityError`",
    )


@pytest.mark.parametrize("name", CROSSED)
def test_modes_with_cross_coupled_bearings(name: str):
    system = rotor(CROSSED[name], 1e3, elements=3)
    m = system.matrices()
    n = len(m.mass)
    # Scaled displacements give blocks of equal magnitude.
    scale = np.sqrt(np.linalg.norm(np.linalg.solve(m.mass, m.stiffness), 2))
    a = np.block(
        [
            [np.zeros((n, n)), np.eye(n) * scale],
            [
                -np.linalg.solve(m.mass, m.stiffness) / scale,
                -np.linalg.solve(m.mass, m.damping + 300.0 * m.gyroscopic),
            ],
        ]
    )
    exact = np.linalg.eigvals(a)
    for value in system.modes(300.0).eigenvalues:
        assert np.abs(exact - value).min() < 1e-6 * abs(value) + 1e-9 * scale


def test_singular_bearing_without_equilibrium_is_an_error():
    # The bearing gives no force along z at any displacement.
    with pytest.raises(gb.SceneError, match="no static equilibrium"):
        rotor([[1e8, 1e8], [0.0, 0.0]], gravity=GRAVITY).static()
    with pytest.raises(gb.SceneError, match="which its bearings do not constrain"):
        rotor(0.0, gravity=GRAVITY).static()


def test_growing_motion_warns_and_then_fails():
    system = rotor([[1e8, 1e8], [-1e8, 1e8]], gravity=GRAVITY)
    with pytest.warns(gb.AccuracyWarning, match="the length of the longest shaft, 1 m"):
        system.simulate(8e-3, 300.0, initial="rest", record=[MIDDLE], times=[8e-3])
    with pytest.raises(gb.StabilityError, match="diverged after"):
        system.simulate(1.0, 300.0, initial="rest", record=[MIDDLE], times=[1.0])


def test_critical_damping_and_repeated_modes(hold: Hold):
    # From light damping to nearly rigid dampers the lowest modes become critically damped one after
    # another, in pairs for the two planes.
    worst, conditions = 0.0, []
    for damping in np.geomspace(1e3, 1e5, 25):
        system = rotor((1e6, 1.2e6), damping, elements=3, gravity=GRAVITY)
        run = system.simulate(TIMES[-1], 0.0, initial="rest", record=[MIDDLE], times=TIMES)
        exact = released(system, 0.0, TIMES)[:, at(system, MIDDLE)]
        worst = max(worst, apart(run.displacement(MIDDLE)[:, 1], exact[:, 1]))
        conditions.append(run.statistics.condition)
    assert max(conditions) > 10 * min(conditions)
    hold(
        "Nearly parallel and repeated modes: the motion equals the matrix exponential",
        "damping 1e3 to 1e5 N s/m, through critical damping of the lowest modes",
        worst,
        1e-8,
    )
