"""Drives, forces, and torques over time and speed: closed forms of a pendulum, SciPy, and errors."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import PchipInterpolator

import gearbow as gb
from reference.cases import each_case
from reference.scenes import G, single_shaft

LENGTH, DIAMETER, INERTIA = 0.2, 0.05, 0.02
DRIVE, DAMPING, TORQUE = 1e4, 6.0, 50.0
SHAFT = G * np.pi * DIAMETER**4 / 32 / LENGTH
STIFFNESS = 1 / (1 / DRIVE + 1 / SHAFT)
FREQUENCY = np.sqrt(STIFFNESS / INERTIA)
MATERIAL = gb.Material(207e9, 1e-2, shear_modulus=G)
METHODS = pytest.mark.parametrize(
    "options",
    [
        {"method": "exponential", "rtol": 1e-9},
        {"method": "exponential", "step": 1e-4},
        {"method": "rk45", "rtol": 1e-10},
        {"method": "etdrk4", "step": 1e-5},
    ],
    ids=lambda options: "-".join(str(value) for value in options.values()),
)
RUN: dict[str, Any] = {"initial": "rest", "output_step": 2e-4, "record": ["wheel", "energy"]}


def pendulum(*torques: gb.Torque, damping: float = 0.0) -> gb.RotorSystem:
    """Return a disk on a shaft without mass that a drive holds."""
    return gb.RotorSystem(
        [gb.Shaft("s", length=LENGTH, outer_diameter=DIAMETER, elements=1, material=MATERIAL)],
        disks=[gb.Disk("wheel", "s", LENGTH, 1.0, 0.01, INERTIA)],
        drives=[gb.Drive(("s", 0.0), stiffness=DRIVE, damping=damping)],
        torques=torques,
        motion="torsion",
    )


def solved(torque: Any, times: Any, spin: float = 0.0) -> Any:
    """Integrate the pendulum with DOP853; `torque` depends on time and actual speed."""

    def rate(t: float, state: Any) -> list[float]:
        angle, speed = state
        return [speed, (torque(t, spin + speed) - STIFFNESS * angle) / INERTIA]

    found = solve_ivp(
        rate, (0.0, times[-1]), [0.0, 0.0], "DOP853", times, rtol=1e-12, atol=1e-16, max_step=1e-3
    )
    return found.y[0]


def check(run: gb.Response, exact: Any, tolerance: float = 1e-6) -> None:
    # The shaft has 1e-7 of the inertia of the wheel; the methods have a tolerance of about 1e-8.
    np.testing.assert_allclose(
        run.twist("wheel"), exact, rtol=0.0, atol=tolerance * np.abs(exact).max()
    )
    assert np.abs(run.energy_balance().residual).max() < 1e-8 * run.energy.max()


def test_the_frequency_and_the_static_twist_are_those_of_two_springs_in_series():
    system = pendulum(gb.Torque("wheel", TORQUE))
    modes = system.modes()
    np.testing.assert_allclose(modes.frequencies_hz[0], FREQUENCY / (2 * np.pi), rtol=1e-6)
    np.testing.assert_allclose(system.modes(count=1).frequencies_hz[0], modes.frequencies_hz[0])
    np.testing.assert_allclose(system.static().twist("wheel"), TORQUE / STIFFNESS, rtol=1e-12)


@METHODS
def test_a_constant_torque_swings_the_pendulum(options: dict[str, Any]):
    run = pendulum(gb.Torque("wheel", TORQUE)).simulate(0.02, 0.0, **RUN, **options)
    check(run, TORQUE / STIFFNESS * (1 - np.cos(FREQUENCY * run.time)))


@METHODS
def test_a_torque_that_is_a_function_of_time(options: dict[str, Any]):
    order = 300.0
    run = pendulum(gb.Torque("wheel", lambda t: TORQUE * np.sin(order * t))).simulate(
        0.02, 0.0, **RUN, **options
    )
    ratio, t = order / FREQUENCY, run.time
    amplitude = TORQUE / STIFFNESS / (1 - ratio**2)
    check(run, amplitude * (np.sin(order * t) - ratio * np.sin(FREQUENCY * t)))


@METHODS
def test_a_time_series_is_the_monotone_cubic_of_scipy(options: dict[str, Any]):
    times, values = [0.001, 0.002, 0.004, 0.005, 0.012], [0.0, 80.0, 20.0, 25.0, -10.0]
    system = pendulum(gb.Torque("wheel", gb.TimeSeries(times, values)))
    run = system.simulate(0.02, 0.0, **RUN, **options)
    curve = PchipInterpolator(times, values)
    # Kinks of the slope within a fixed step limit the exponential method.
    tolerance = 1e-4 if options == {"method": "exponential", "step": 1e-4} else 1e-6
    exact = solved(lambda t, _: float(curve(np.clip(t, times[0], times[-1]))), run.time)
    check(run, exact, tolerance)


@METHODS
def test_a_linear_torque_over_the_speed_damps_the_pendulum(options: dict[str, Any]):
    spin, table = 100.0, gb.SpeedTable([0.0, 400.0], [TORQUE, 0.0])
    system = pendulum(gb.Torque("wheel", table))
    slope = TORQUE / 400.0
    assert system.matrices(spin).damping[1, 1] == pytest.approx(slope, rel=1e-12)
    left = TORQUE - slope * spin
    np.testing.assert_allclose(system.static(speed=spin).twist("wheel"), left / STIFFNESS)
    decay = slope / (2 * INERTIA)
    damped = np.sqrt(FREQUENCY**2 - decay**2)
    ratio = system.modes(spin).damping_ratios[0]
    np.testing.assert_allclose(ratio, decay / FREQUENCY, rtol=1e-6)
    if options["method"] == "rk45":
        return  # the massless shaft makes the table stiff
    run = system.simulate(0.02, spin, **RUN, **options)
    t = run.time
    swing = np.cos(damped * t) + decay / damped * np.sin(damped * t)
    check(run, left / STIFFNESS * (1 - np.exp(-decay * t) * swing))


@pytest.mark.parametrize("spin", [150.0, -150.0])
def test_a_curved_torque_over_the_speed_acts_at_the_actual_speed(spin: float):
    speeds, values = np.array([0.0, 145.0, 155.0, 300.0]), np.array([40.0, 35.0, -5.0, -20.0])
    system = pendulum(gb.Torque("wheel", gb.SpeedTable(speeds, values)))
    curve = PchipInterpolator(speeds, values)
    for options in ({"method": "exponential", "rtol": 1e-9}, {"method": "etdrk4", "step": 1e-5}):
        run = system.simulate(0.02, spin, **RUN, **options)
        check(run, solved(lambda _, speed: float(curve(abs(speed))), run.time, spin), 1e-6)


def test_a_run_up_follows_the_torque_of_each_speed():
    table = gb.SpeedTable([0.0, 200.0, 400.0], [TORQUE, 45.0, 0.0])
    system = pendulum(gb.Torque("wheel", table), damping=DAMPING)
    ramp = gb.SpeedProfile.ramp(0.0, 350.0, 0.05)
    runs = [
        system.simulate(0.05, ramp, method=method, **RUN, **options)
        for method, options in (("exponential", {"rtol": 1e-9}), ("rk4", {"step": 1e-7}))
        if method == "exponential"
    ]
    curve = PchipInterpolator([0.0, 200.0, 400.0], [TORQUE, 45.0, 0.0])

    def rate(t: float, state: Any) -> list[float]:
        # angles of wheel and drive; the massless shaft joins them
        angle, speed, held = state
        force = SHAFT * (angle - held)
        actual = abs(7000.0 * t + speed)
        return [speed, (float(curve(actual)) - force) / INERTIA, (force - DRIVE * held) / DAMPING]

    found = solve_ivp(rate, (0, 0.05), [0.0] * 3, "Radau", runs[0].time, rtol=1e-10, atol=1e-14)
    # the tolerance of Radau
    np.testing.assert_allclose(runs[0].twist("wheel"), found.y[0], rtol=0.0, atol=1e-8)


ROTOR: dict[str, Any] = {
    "support": None,
    "elements": 4,
    "bearings": [gb.Bearing("s", x, stiffness=(2e6, 3e6), damping=300.0) for x in (0.0, 1.0)],
    "disks": [gb.Disk("wheel", "s", 0.5, 8.0, 0.03, 0.05)],
}


def test_a_constant_force_is_a_weight():
    weight = single_shaft(**ROTOR, gravity=(0.0, -9.81)).static().displacement("wheel")
    bare = single_shaft(**{**ROTOR, "disks": [gb.Disk("wheel", "s", 0.5, 0.0, 0.0, 0.0)]},
                        gravity=(0.0, -9.81)).static()  # fmt: skip
    force = single_shaft(**ROTOR, forces=[gb.Force("wheel", -8.0 * 9.81j)]).static()
    found = force.displacement("wheel") + bare.displacement("wheel")
    np.testing.assert_allclose(found, weight, rtol=1e-9, atol=1e-18)


def test_a_force_of_order_one_is_an_unbalance_at_one_speed():
    speed, unbalance = 180.0, 3e-4 - 1e-4j
    heavy = [replace(ROTOR["disks"][0], unbalance=unbalance)]
    turned = single_shaft(**ROTOR, forces=[gb.Force("wheel", unbalance * speed**2, order=1)])
    balanced = single_shaft(**{**ROTOR, "disks": heavy})
    answers = [s.synchronous([speed]).displacement("wheel") for s in (turned, balanced)]
    np.testing.assert_allclose(*answers, rtol=1e-12)
    options = {"initial": "rest", "output_step": 1e-3, "record": ["wheel", "energy"]}
    for method in ({"method": "exponential"}, {"method": "rk45", "rtol": 1e-9}):
        runs = [s.simulate(0.02, speed, **options, **method) for s in (turned, balanced)]
        np.testing.assert_allclose(*(r.displacement("wheel") for r in runs), rtol=0.0, atol=1e-12)
        work = [r.energy_balance() for r in runs]
        np.testing.assert_allclose(work[0].torque, work[1].unbalance, rtol=0.0, atol=1e-9)


@pytest.mark.parametrize(
    "force",
    [
        gb.Force("wheel", 30.0 + 10.0j, order=2.5),
        gb.Force("wheel", lambda t: 30.0 * np.cos(400.0 * t) - 10j * np.sin(90.0 * t)),
        gb.Force("wheel", gb.TimeSeries([0.004, 0.006, 0.008], [0.0, 300.0j, 0.0])),
    ],
    ids=["order", "function", "pulse"],
)
def test_forces_that_vary_agree_in_all_methods_with_dop853(force: gb.Force):
    speed = 130.0
    system = single_shaft(**ROTOR, forces=[force])
    matrices = system.matrices(speed)
    at = [system.dofs.index(("s", 0.5, c)) for c in "vw"]
    inverse = np.linalg.inv(matrices.mass)
    rates = matrices.damping + speed * matrices.gyroscopic
    n = len(inverse)
    series = force.value if isinstance(force.value, gb.TimeSeries) else None
    pulse = series and PchipInterpolator(series.times, np.imag(series.values))

    def value(t: float) -> complex:
        if pulse is not None:
            return 1j * float(pulse(np.clip(t, 0.004, 0.008)))
        if callable(force.value):
            return complex(force.value(t))
        return complex(force.value) * np.exp(1j * force.order * speed * t)

    def rate(t: float, state: Any) -> Any:
        load = np.zeros(n)
        load[at] = value(t).real, value(t).imag
        q, v = state[:n], state[n:]
        return np.concatenate([v, inverse @ (load - matrices.stiffness @ q - rates @ v)])

    options = {"initial": "rest", "output_step": 1e-3, "record": ["wheel", "energy"]}
    methods = (
        {"method": "exponential", "rtol": 1e-9},
        {"method": "rk45", "rtol": 1e-9},
        {"method": "etdrk4", "step": 2e-5},
    )
    runs = [system.simulate(0.012, speed, **options, **method) for method in methods]
    exact = solve_ivp(
        rate, (0, 0.012), np.zeros(2 * n), "DOP853", runs[0].time, rtol=1e-10, atol=1e-16,
        max_step=5e-4,
    ).y[at].T  # fmt: skip
    for run in runs:
        # tolerances of 1e-9 relative to the energy of all modes
        np.testing.assert_allclose(
            run.displacement("wheel"), exact, rtol=0.0, atol=1e-6 * np.abs(exact).max()
        )
        assert np.abs(run.energy_balance().residual).max() < 1e-6 * run.energy.max()


def test_a_drive_loads_the_flanks_of_a_train():
    shafts = [gb.Shaft(n, length=0.2, outer_diameter=0.04, elements=2) for n in "ab"]
    system = gb.RotorSystem(
        shafts,
        [gb.Gear(n, s, 0.1, teeth=25, module=3e-3, face_width=0.02) for n, s in ("ga", "hb")],
        [gb.Mesh("g", "h", stiffness=2e8, backlash=1e-4)],
        [gb.Bearing(n, x, stiffness=1e8, damping=500.0) for n in "ab" for x in (0.0, 0.2)],
        [gb.Torque("h", 80.0)],
        drives=[gb.Drive(("a", 0.0), stiffness=1e5, damping=20.0)],
    )
    static = system.static(speed=100.0)
    radius = 3e-3 * 25 / 2 * np.cos(np.radians(20.0))
    np.testing.assert_allclose(static.mesh(("g", "h")).force, 80.0 / radius, rtol=1e-9)
    np.testing.assert_allclose(static.twist(("a", 0.0)), -80.0 / 1e5, rtol=1e-9)
    runs = [
        system.simulate(0.01, 100.0, method=m, rtol=1e-8, record=["meshes", "energy"])
        for m in ("exponential", "rk45")
    ]
    first, second = (run.mesh(("g", "h")).force for run in runs)
    np.testing.assert_allclose(first, second, rtol=1e-4)
    assert "rigid-body rotation" not in system.modes().names()


def test_functions_of_time_have_no_plain_form(tmp_path: Any):
    system = pendulum(gb.Torque("wheel", lambda t: 3.0 * t))
    for ask in (lambda: system.description, lambda: system.save(tmp_path / "scene.toml")):
        with pytest.raises(gb.SceneError, match=r"^torques\[0\].value: a function of time has no"):
            ask()
    run = system.simulate(0.01, 0.0, record=["wheel"])
    assert run.request is not None
    read = gb.RotorSystem.from_dict(run.request.description)
    assert isinstance(read.torques[0].value, gb.TimeSeries)
    again = read.simulate(0.01, 0.0, record=["wheel"])
    np.testing.assert_array_equal(again.twist("wheel"), run.twist("wheel"))


def test_round_trip_in_a_file(tmp_path: Any):
    forces = [
        gb.Force("wheel", 1.0 + 2.0j),
        gb.Force("wheel", 1.5, order=2.0),
        gb.Force(("s", 0.2), gb.TimeSeries([0.0, 1.0], [1.0j, 2.0], [0.0, 1.0j])),
    ]
    torques = [
        gb.Torque("wheel", gb.SpeedTable([0.0, 1.0], [-3.0, 2.0], outside="hold")),
        gb.Torque("wheel", gb.TimeSeries([0.0, 1.0], [3.0, 2.0])),
    ]
    drives = [gb.Drive("wheel", 1e5, 3.0)]
    system = single_shaft(**ROTOR, forces=forces, torques=torques, drives=drives)
    file = tmp_path / "scene.toml"
    system.save(file)
    for other in (gb.RotorSystem.load(file), gb.RotorSystem.from_dict(system.description)):
        assert other.description == system.description
        assert other.forces == system.forces
        assert other.torques == system.torques
        assert other.drives == system.drives


@each_case(
    ("parts", "message"),
    [
        (
            {"drives": [gb.Drive("weel", 1.0)]},
            'drives[0].at: no gear or disk is called "weel"; did',
        ),
        (
            {"drives": [gb.Drive("wheel", -1.0)]},
            "drives[0].stiffness: must not be negative, got -1",
        ),
        ({"drives": [gb.Drive("wheel", 1.0, np.nan)]}, "drives[0].damping: must be finite"),
        ({"forces": [gb.Force(("s", 3.0), 1.0)]}, "forces[0].at: "),
        ({"forces": [gb.Force("wheel", "x")]}, "forces[0].value: must be a number"),
        (
            {"forces": [gb.Force("wheel", gb.TimeSeries([0, 1], [1, 2]), order=1)]},
            "forces[0].order: turns a constant force",
        ),
        (
            {"forces": [gb.Force("wheel", gb.TimeSeries([0, 0], [1, 2]))]},
            "forces[0].value.times[1]: must be above the entry before it, 0, got 0",
        ),
        (
            {"torques": [gb.Torque("wheel", gb.TimeSeries([0, 1, 2], [1, 2]))]},
            "torques[0].value.values: needs one value for each of the 3 times, got 2",
        ),
        (
            {"torques": [gb.Torque("wheel", gb.TimeSeries([0, 1], [1, 2j]))]},
            "torques[0].value.values: a torque is a real number",
        ),
        (
            {"torques": [gb.Torque("wheel", gb.SpeedTable([-1, 1], [1, 2]))]},
            "torques[0].value.speeds[0]: must not be negative",
        ),
        (
            {
                "torques": [
                    gb.Torque("wheel", gb.SpeedTable([0, 1], [1, 2])),
                    gb.Torque.balance(("s", 0.0)),
                ]
            },
            "torques[1]: torques[0] depends on time or speed, which a constant torque cannot bal",
        ),
        ({"drives": [gb.Drive("wheel", 1.0)], "motion": "lateral"}, 'motion: "lateral" has no tw'),
        ({"forces": [gb.Force("wheel", 1.0)], "motion": "torsion"}, 'motion: "torsion" has no be'),
    ],
)
def test_invalid_drives_and_loads(parts: dict[str, Any], message: str):
    with pytest.raises(gb.SceneError, match="^" + re.escape(message)):
        single_shaft(**ROTOR, **parts)


def test_a_speed_outside_the_table_of_a_torque():
    system = pendulum(gb.Torque("wheel", gb.SpeedTable([10.0, 100.0], [1.0, 2.0])))
    message = (
        r"^torques\[0\].value: the table ranges from 10 to 100 rad/s .*, but the shaft turns at"
    )
    for ask in (system.static, lambda: system.simulate(0.01, 150.0), lambda: system.modes(5.0)):
        with pytest.raises(gb.SceneError, match=message):
            ask()


def test_torques_that_do_not_balance_name_the_drive():
    system = single_shaft(**ROTOR, torques=[gb.Torque("wheel", 1.0)])
    with pytest.raises(gb.SceneError, match=r"or hold the rotation with gb.Drive"):
        system.static()


def test_a_time_series_has_one_value_for_each_time():
    for values in (3.0, np.ones((2, 3)), [["a", "b"]], [[1.0], [2.0, 3.0]]):
        with pytest.raises(gb.SceneError, match=r"^values: must be a list of numbers"):
            gb.TimeSeries([0.0, 1.0], values)
    # pairs are complex numbers
    assert gb.TimeSeries([0.0, 1.0], [[1.0, 2.0], [3.0, 4.0]]).values == (1.0 + 2.0j, 3.0 + 4.0j)


def test_a_place_is_a_text_with_any_numpy(monkeypatch):
    # From NumPy 2.5 on, ArrayLike is no union, so that it has no members.
    from gearbow.description import part

    part._kinds.cache_clear()
    monkeypatch.setattr(part, "ArrayLike", type("ArrayLike", (), {}))
    assert gb.Drive("g1", 1e5)._describe("drive") == {"at": "g1", "stiffness": 1e5}
    part._kinds.cache_clear()
