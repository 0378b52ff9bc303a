"""Rolling bearings: published deflections, mean coefficients, varying compliance, runs by all methods and errors."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import gearbow as gb
from reference import elements, independent_solution, machines
from reference.cases import each_case
from reference.comparisons import assert_energy_closes, assert_near, by_both_methods
from reference.rolling import Elements, hertz
from reference.scenes import PAIR

Array = np.ndarray[Any, np.dtype[np.float64]]

#: Nine balls with a moderate stiffness.
BALLS = Elements(count=9, stiffness=8e9, clearance=1e-5)
SIZES = {"element_diameter": 0.0127, "pitch_diameter": 0.065}
#: Speed of the cage over that of the shaft.
CAGE = (1 - 0.0127 / 0.065) / 2
DAMPING = 300.0


def bearing(
    shaft: str, position: float, balls: Elements = BALLS, **options: Any
) -> gb.RollingBearing:
    given: dict[str, Any] = {**SIZES, "damping": DAMPING, **options}
    contact = "roller" if balls.exponent < 1.5 else "ball"
    return gb.RollingBearing(
        shaft,
        position,
        elements=balls.count,
        clearance=balls.clearance,
        hertz_stiffness=balls.stiffness,
        phase=balls.phase,
        contact=contact,
        **given,
    )


def train(torque: float = 60.0, **options: Any) -> Any:
    given = {"elements": 2, "gravity": (0.0, -9.81), "bearing_stiffness": 0.0, **options}
    return replace(PAIR, torque=torque, **{"bearing_damping": 0.0, **given})


def pair(torque: float = 60.0, balls: Elements = BALLS, **options: Any) -> gb.RotorSystem:
    """Build a geared pair on four rolling bearings."""
    bearings = [bearing(s, x, balls, **options) for s in PAIR.shafts for x in (0.0, PAIR.length)]
    return train(torque).package().replace(bearings=bearings)


# --- one bearing ----------------------------------------------------------------------------------


@pytest.mark.parametrize("groove", [0.515, 0.52, 0.55])
def test_the_stiffness_of_the_geometry_is_that_of_hertz(groove: float):
    options = {"inner_groove": groove, "outer_groove": groove}
    ball = gb.RollingBearing("s", 0.0, elements=9, clearance=0.0, **options, **SIZES)
    # the approximation of Brewe and Hamrock
    wanted = hertz(0.0127, 12.7 / 65, groove, 206e9, 0.3)
    assert ball.stiffness_of_contact == pytest.approx(wanted, rel=0.03)


def test_a_roller_has_the_stiffness_of_palmgren():
    # delta = 3.84e-5 Q^0.9 / l^0.8 in mm and N at each of two races
    roller = gb.RollingBearing(
        "s", 0.0, elements=14, clearance=0.0, contact="roller", roller_length=0.01, **SIZES
    )
    deflection = 2 * 3.84e-5 * 1000.0**0.9 / 10.0**0.8 * 1e-3
    assert roller.stiffness_of_contact * deflection ** (10 / 9) == pytest.approx(1000.0, rel=1e-12)


@pytest.mark.parametrize(("exponent", "published"), [(1.5, 0.2288), (10 / 9, 0.2453)])
def test_the_static_deflection_is_sjovalls_integral(exponent: float, published: float):
    # without clearance the load is n Q_max J_r(0.5): 0.2288 for balls and 0.2453 for rollers (Harris
    # 2001, table 7.1)
    balls = replace(BALLS, clearance=0.0, exponent=exponent)
    found = bearing("s", 0.0, balls).coefficients(1000.0)
    largest = 1000.0 / (balls.count * published)
    deflection = (largest / balls.stiffness) ** (1 / exponent)
    # printed digits; the integral for rollers is 0.2448, its printed value belongs to the exponent 1.1
    part = 4e-4 if exponent == 1.5 else 2e-3
    np.testing.assert_allclose(found.displacement, [0.0, -deflection], rtol=part, atol=1e-15)


@pytest.mark.parametrize("clearance", [2e-5, 0.0, -1e-5])
@pytest.mark.parametrize("exponent", [1.5, 10 / 9])
def test_mean_force_and_stiffness_are_the_integral_over_the_cage(clearance: float, exponent: float):
    balls = replace(BALLS, clearance=clearance, exponent=exponent)
    found = bearing("s", 0.0, balls).coefficients(1000.0)
    r = -found.displacement[1]
    # the rule of the reference has this error for preloaded rollers
    assert balls.mean_force(r) == pytest.approx(1000.0, rel=1e-7)
    h = 1e-4 * r
    along = (balls.mean_force(r + h) - balls.mean_force(r - h)) / (2 * h)
    np.testing.assert_allclose(found.stiffness, np.diag([1000.0 / r, along]), rtol=1e-6, atol=1.0)


def test_stribecks_number_holds_for_clearance_free_balls():
    # Stribeck: Q_max = 4.37 F/n without clearance; the mean over the cage is between its extremes
    balls = replace(BALLS, clearance=0.0, count=15)
    forces = [
        bearing("s", 0.0, balls).coefficients(500.0, a).contact_forces.max()
        for a in np.linspace(0, 0.4, 21)
    ]
    assert max(forces) == pytest.approx(4.37 * 500.0 / 15, rel=0.02)


@pytest.mark.parametrize("angle", [0.0, 0.1, 0.35])
def test_a_bearing_at_a_cage_angle_is_the_sum_over_its_elements(angle: float):
    found = bearing("s", 0.0).coefficients(1000.0, angle)
    np.testing.assert_allclose(BALLS.force(found.displacement, angle), [0.0, -1000.0], atol=1e-7)
    pressed = np.maximum(BALLS.approach(found.displacement, angle), 0.0)
    np.testing.assert_allclose(found.contact_forces, BALLS.stiffness * pressed**1.5, atol=1e-6)
    h = 1e-9
    for j, unit in enumerate(np.eye(2)):
        high, low = (BALLS.force(found.displacement + sign * h * unit, angle) for sign in (1, -1))
        # error of the difference quotient
        np.testing.assert_allclose(
            found.stiffness[:, j], (high - low) / (2 * h), rtol=1e-4, atol=1e3
        )


def test_many_balls_tend_to_the_integral():
    errors = []
    for count in (8, 16, 32, 64):
        # the balls are thin enough for the pitch circle
        balls = replace(BALLS, count=count, stiffness=8e9 * 8 / count)
        thin = {"element_diameter": 0.003}
        mean = bearing("s", 0.0, balls, **thin).coefficients(1000.0).displacement[1]
        errors.append(
            max(abs(bearing("s", 0.0, balls, **thin).coefficients(1000.0, a).displacement[1] / mean - 1)
                for a in np.linspace(0.0, 2 * np.pi / count, 7))
        )  # fmt: skip
    assert errors[0] > 1e-3
    # the integrand has a kink of order 3/2: the sum converges with the power 5/2 of the spacing
    assert errors[-1] < errors[0] / 8**2


def test_a_contact_angle_softens_the_bearing():
    flat = bearing("s", 0.0).coefficients(1000.0).displacement[1] + BALLS.clearance / 2
    balls = replace(BALLS, clearance=0.0)
    angle = math.radians(40.0)
    first, second = (
        bearing("s", 0.0, balls, contact_angle=a).coefficients(1000.0) for a in (0.0, angle)
    )
    # K cos^(5/2): the deflection grows with its power 2/3
    ratio = second.displacement[1] / first.displacement[1]
    assert ratio == pytest.approx(math.cos(angle) ** (-5 / 3), rel=1e-10)
    forces = second.contact_forces.max() / first.contact_forces.max()
    assert forces == pytest.approx(1 / math.cos(angle), rel=1e-10)
    assert flat < 0.0


def test_the_coefficients_of_a_mirrored_cage_are_mirrored():
    found, mirrored = (bearing("s", 0.0).coefficients(700.0, a) for a in (0.2, -0.2 - np.pi))
    # nine balls from y: the mirror y -> -y maps the angle a to pi - a
    np.testing.assert_allclose(found.displacement * [-1, 1], mirrored.displacement, atol=1e-16)


# --- equilibrium and linear analyses ----------------------------------------------------------------


@pytest.mark.parametrize("clearance", [4e-5, 0.0, -1e-5])
def test_the_equilibrium_of_a_train_balances_every_bearing(clearance: float):
    balls = replace(BALLS, clearance=clearance)
    static = pair(balls=balls).static(speed=150.0)
    total = 0.0
    for shaft in PAIR.shafts:
        for x in (0.0, PAIR.length):
            u, force = static.displacement((shaft, x)), static.bearing_force((shaft, x))
            r = float(np.hypot(*u))
            np.testing.assert_allclose(force, balls.mean_force(r) * u / r, rtol=1e-7)
            total += force
    reference = train().reference()
    unit = np.zeros(reference.size)
    for shaft in PAIR.shafts:
        for x in reference.nodes[shaft]:
            unit[reference.dof(shaft, float(x), elements.W)] = 1.0
    np.testing.assert_allclose(total, [0.0, -9.81 * unit @ reference.mass @ unit], atol=1e-6)


def test_matrices_and_modes_have_the_mean_stiffness_of_the_equilibrium():
    system = pair()
    static = system.static(speed=150.0)
    linear = []
    for shaft in PAIR.shafts:
        for x in (0.0, PAIR.length):
            u = static.displacement((shaft, x))
            r, h = float(np.hypot(*u)), 1e-9
            along = (BALLS.mean_force(r + h) - BALLS.mean_force(r - h)) / (2 * h)
            across, e = BALLS.mean_force(r) / r, u / r
            stiffness = across * np.eye(2) + (along - across) * np.outer(e, e)
            linear.append(gb.Bearing(shaft, x, stiffness=stiffness, damping=DAMPING))
    equal = system.replace(bearings=linear)
    for name in ("stiffness", "damping"):
        first, second = (getattr(s.matrices(150.0), name) for s in (system, equal))
        np.testing.assert_allclose(first, second, atol=1e-6 * abs(second).max())
    first, second = (s.modes(150.0).frequencies_hz for s in (system, equal))
    np.testing.assert_allclose(first, second, rtol=1e-5, atol=1e-3)
    speeds = [100.0, 150.0]
    first, second = (s.synchronous(speeds).displacement("g1") for s in (system, equal))
    np.testing.assert_allclose(first[1], second[1], rtol=1e-4, atol=1e-15)
    diagram = system.campbell(np.linspace(100.0, 200.0, 3), count=4)
    eigenvalues = system.modes(diagram.speeds[1]).eigenvalues
    for value in diagram.eigenvalues[1]:
        assert np.abs(eigenvalues - value).min() < 1e-9 * abs(value)


def test_the_stiffness_grows_with_the_load():
    light, heavy = (pair(torque).modes(0.0).frequencies_hz for torque in (20.0, 200.0))
    assert heavy[2] > 1.02 * light[2]


def rotor(balls: Elements = BALLS, **options: Any) -> gb.RotorSystem:
    return machines.rotor(
        {"name": "s", "length": 0.3, "outer_diameter": 0.04, "elements": 2},
        machines.inertia(10.0, 0.02, 0.04, name="d"),
        bearings=[bearing("s", x, balls) for x in (0.0, 0.3)],
        **{"gravity": 9.81, "motion": "lateral", **options},
    )


def test_a_shaft_within_the_clearance_is_free():
    system = rotor(replace(BALLS, clearance=6e-4), gravity=0.0)
    assert abs(system.static().displacement("d")).max() == 0.0
    assert system.modes(100.0).frequencies_hz[0] < 1e-3
    start = system.simulate(0.0, 100.0, initial="rest")
    state = start.final["state"].copy()
    n = state.size // 2
    moving = np.array([direction == "v" for *_, direction in system.dofs])
    state[n:] = np.where(moving, 1e-2, 0.0)
    initial = {**start.final, "state": state, "memory": np.zeros(0)}
    run = system.simulate(0.02, 100.0, initial=initial, record=["disks", "bearings"], method="rk45")
    # dampers of 300 N s/m alone
    dampers = [gb.Bearing("s", x, stiffness=0.0, damping=DAMPING) for x in (0.0, 0.3)]
    equal = system.replace(bearings=dampers)
    free = equal.simulate(0.02, 100.0, initial=initial, record=["disks"], method="rk45")
    exact = free.displacement("d")
    assert np.ptp(exact) > 1e-4
    np.testing.assert_allclose(run.displacement("d"), exact, atol=1e-6 * np.ptp(exact))
    assert run.rolling(("s", 0.0)).loaded_elements.max() == 0.0


# --- runs ---------------------------------------------------------------------------------------------

SPEED, END = 300.0, 0.02
TIMES = np.linspace(0.0, END, 101)
RECORD = ["gears", "meshes", "bearings", "energy"]
ROLLERS = replace(BALLS, exponent=10 / 9, stiffness=1.5e8)


def judged(balls: Elements) -> independent_solution.Motion:
    given = train().reference()
    places = [
        (given.dof(shaft, x, elements.V), ratio * SPEED * CAGE)
        for shaft, ratio in zip(PAIR.shafts, PAIR.ratios, strict=True)
        for x in (0.0, PAIR.length)
    ]

    def forces(t: float, q: Array, qd: Array) -> Array:
        force = np.zeros(given.size)
        for i, spin in places:
            force[i : i + 2] = -balls.force(q[i : i + 2], spin * t) - DAMPING * qd[i : i + 2]
        return force

    return independent_solution.from_rest(given, SPEED, TIMES, rtol=1e-10, further=forces)


@pytest.fixture(scope="module")
def motion() -> independent_solution.Motion:
    return judged(BALLS)


@pytest.mark.parametrize(
    ("method", "options", "part"),
    [
        ("rk45", {"rtol": 1e-10}, 1e-6),
        ("rk4", {"step": 4e-7}, 1e-6),
        ("exponential", {"rtol": 1e-9}, 1e-6),
        ("etdrk4", {"step": 1e-6}, 1e-6),
    ],
)
def test_every_method_follows_the_independent_solution(
    motion: independent_solution.Motion, method: str, options: dict[str, Any], part: float
):
    run = pair().simulate(END, SPEED, initial="rest", times=TIMES, method=method, record=RECORD, **options)  # fmt: skip
    for gear in ("g1", "g2"):
        exact = motion.displacement(gear)
        assert np.abs(run.displacement(gear) - exact).max() < part * np.ptp(exact)
    exact = motion.mesh_force(0, live=True)
    assert np.abs(run.mesh(("g1", "g2")).force - exact).max() < 2 * part * np.ptp(exact)
    i, spin = motion.train.dof("output", 0.0, elements.V), -SPEED / 2 * CAGE
    u, rates = motion.q[:, i : i + 2], motion.qd[:, i : i + 2]
    force = np.array([BALLS.force(*at) for at in zip(u, spin * TIMES, strict=True)])
    force += DAMPING * rates
    found = run.rolling(("output", 0.0))
    # the force magnifies errors of the displacement near the bearing
    assert np.abs(found.force - force).max() < 10 * part * np.abs(force).max()
    pressed = [np.maximum(BALLS.approach(*at), 0.0) for at in zip(u, spin * TIMES, strict=True)]
    largest = [BALLS.stiffness * p.max() ** 1.5 for p in pressed]
    np.testing.assert_allclose(found.largest_contact_force, largest, atol=10 * part * max(largest))
    # a nearly loose element counts on either side of round-off
    assert np.mean(found.loaded_elements == [np.sum(p > 0) for p in pressed]) > 0.98
    assert_energy_closes(run)
    # without the work on the elements, the balance would not close
    balance = run.energy_balance()
    assert abs(balance.drive[-1]) > 1e-5 * balance.total.max()


@pytest.mark.parametrize(
    "balls", [ROLLERS, replace(BALLS, clearance=-1e-5), replace(BALLS, clearance=5e-5)]
)
def test_rollers_preload_and_clearance_follow_the_independent_solution(balls: Elements):
    exact = judged(balls).displacement("g1")
    for method, options in (("rk45", {"rtol": 1e-10}), ("exponential", {"rtol": 1e-9})):
        run = pair(balls=balls).simulate(END, SPEED, initial="rest", times=TIMES, method=method, record=RECORD, **options)  # fmt: skip
        # the tangent of a roller jumps nearly where it takes up load
        part = 1e-6 if balls.exponent == 1.5 else 3e-6
        assert np.abs(run.displacement("g1") - exact).max() < part * np.ptp(exact)
        assert_energy_closes(run)


def test_the_compliance_varies_with_the_ball_pass_frequency():
    system = rotor(replace(BALLS, clearance=2e-5))
    speed = 50.0
    period = 2 * np.pi / (speed * BALLS.count * CAGE)
    times = np.linspace(0.0, 60 * period, 60 * 24 + 1)
    run = system.simulate(
        times[-1], speed, times=times, record=["disks", "bearings"], rtol=1e-8, initial="static"
    )
    settled = run.displacement("d")[50 * 24 :]
    first, later = settled[:-24], settled[24:]
    swing = np.ptp(settled, axis=0).max()
    # the transient has decayed
    assert swing > 1e-8
    assert np.abs(first - later).max() < 1e-4 * swing
    found = run.orders("d", "z", shaft_harmonics=0, skip_time=40 * period)
    assert [order.names[0] for order in found.orders][1] == "1× ball pass s@0"
    assert found.orders[0].value == pytest.approx(CAGE, rel=1e-12)
    assert found.orders[1].value == pytest.approx(9 * CAGE, rel=1e-12)
    assert found.amplitude("1× ball pass s@0") > 10 * found.amplitude("1× cage s@0")
    assert run.rolling(("s", 0.0)).loaded_elements.min() >= 1.0


def test_a_rigid_slow_shaft_moves_as_the_static_deflection_at_each_cage_angle():
    # slow rotation: the shaft is at rest at each angle
    balls = replace(BALLS, clearance=2e-5)
    system, speed = rotor(balls), 1.0
    times = np.linspace(0.0, 4.0, 81)
    run = system.simulate(4.0, speed, times=times, record=["bearings", ("s", 0.0)], rtol=1e-8)
    load = -float(system.static().bearing_force(("s", 0.0))[1])
    wanted = [
        bearing("s", 0.0, balls).coefficients(load, CAGE * t).displacement for t in times[20:]
    ]
    swing = np.ptp(np.array(wanted), axis=0).max()
    assert np.abs(run.displacement(("s", 0.0))[20:] - wanted).max() < 0.02 * swing


def test_a_run_up_and_a_continued_run_keep_the_angle_of_the_cage():
    profile = gb.SpeedProfile.ramp(100.0, 200.0, 0.05)
    system = pair()
    run: dict[str, Any] = {"initial": "static", "output_step": 1e-3, "record": RECORD}
    runs = by_both_methods(system, 0.06, profile, **run)
    assert_near(runs, "g1")
    first = runs[0].displacement("g1")
    assert_energy_closes(*runs)
    half = system.simulate(0.03, profile, initial="static", record=RECORD, method="rk45", rtol=1e-9)
    rest = system.simulate(0.03, profile, initial=half, times=np.linspace(0.03, 0.06, 31), record=RECORD, method="rk45", rtol=1e-9)  # fmt: skip
    assert np.abs(rest.displacement("g1") - first[30:]).max() < 1e-7 * np.ptp(first)


def test_rolling_bearings_stand_on_supports_and_housings():
    support = gb.Support(mass=5.0, stiffness=5e7, damping=2e3)
    bearings = [bearing("s", 0.0, support=support), bearing("s", 0.3, support="box")]
    box = gb.Housing("box", mass=20.0, stiffness=1e8, damping=3e3)
    system = rotor().replace(bearings=bearings, housings=[box])
    static = system.static()
    # weight of shaft and disk on both bearings, of the housing on its mount
    load = -static.bearing_force(("s", 0.3))[1]
    sink = -static.displacement("box")[1]
    assert sink == pytest.approx((load + 20.0 * 9.81) / 1e8, rel=1e-9)
    deflection = -(static.displacement(("s", 0.3))[1] + sink)
    assert BALLS.mean_force(deflection) == pytest.approx(load, rel=1e-7)
    record = ["disks", "bearings", "energy"]
    runs = by_both_methods(system, 0.02, 300.0, record=record, initial="rest")
    assert_near(runs, "d")
    assert_energy_closes(*runs)


def test_files_keep_rolling_bearings(tmp_path: Any):
    system = pair()
    system.save(tmp_path / "scene.toml")
    assert gb.RotorSystem.load(tmp_path / "scene.toml").bearings == system.bearings
    times = np.array([0.0, 4e-4, 1e-3])
    run = system.simulate(0.001, SPEED, times=times, record=RECORD, initial="rest")
    turned = system.simulate(0.001, SPEED, times=times[::-1], record=RECORD, initial="rest")
    kept = {"checkpoint": tmp_path / "kept.npz", "checkpoint_interval": 1e-6}
    parts = system.simulate(0.001, SPEED, times=times, record=RECORD, initial="rest", **kept)
    for other, order in ((turned, slice(None, None, -1)), (parts, slice(None))):
        found = other.rolling(("input", 0.0)).largest_contact_force[order]
        np.testing.assert_array_equal(found, run.rolling(("input", 0.0)).largest_contact_force)
    for name in ("run.npz",):
        run.save(tmp_path / name)
        again = gb.Response.load(tmp_path / name)
        for field in ("force", "loaded_elements", "largest_contact_force"):
            first, second = (getattr(r.rolling(("input", 0.0)), field) for r in (run, again))
            np.testing.assert_array_equal(first, second)
        assert again.kinematics == run.kinematics


# --- errors -------------------------------------------------------------------------------------------


@each_case(
    ("change", "message"),
    [
        ({"elements": 0}, "bearings[0].elements: must be between 3 and 1000, got 0"),
        ({"elements": 2}, "bearings[0].elements: must be between 3 and 1000, got 2"),
        ({"elements": 30}, "bearings[0].elements: 30 elements of 0.0127 m overlap"),
        ({"element_diameter": 0.07}, "bearings[0].element_diameter: must be below pitch_diameter"),
        ({"element_diameter": math.nan}, "bearings[0].element_diameter: must be finite"),
        ({"element_diameter": -1.0}, "bearings[0].element_diameter: must be positive"),
        ({"pitch_diameter": 0.0}, "bearings[0].pitch_diameter: must be positive"),
        ({"clearance": math.nan}, "bearings[0].clearance: must be finite"),
        ({"clearance": 0.02}, "bearings[0].clearance: must be below element_diameter"),
        ({"hertz_stiffness": 0.0}, "bearings[0].hertz_stiffness: must be positive"),
        ({"contact_angle": 40.0}, "bearings[0].contact_angle: must be between -pi/2 and pi/2"),
        ({"phase": math.inf}, "bearings[0].phase: must be finite"),
        ({"contact": "cone"}, "bearings[0].contact: "),
        ({"inner_groove": 0.5}, "bearings[0].inner_groove: radius of the groove"),
        ({"roller_length": 0.01}, "bearings[0].roller_length: a ball has none"),
        ({"contact": "roller", "hertz_stiffness": None}, "bearings[0]: missing field `roller_length`"),
        ({"contact": "roller", "outer_groove": 0.6}, "bearings[0].outer_groove: a roller has none"),
        ({"support": "nowhere"}, "bearings[0].support: "),
    ],
)  # fmt: skip
def test_an_impossible_bearing_is_refused(change: dict[str, Any], message: str):
    with pytest.raises(gb.SceneError, match=re.escape(message)):
        rotor().replace(bearings=[replace(bearing("s", 0.0), **change)])
