"""Speed-dependent bearings: values at and between the knots, and run-ups."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator

import gearbow as gb
from gearbow._core import Model
from reference import elements, independent_solution
from reference.bows import HalfSine
from reference.cases import each_case
from reference.comparisons import assert_modes_of_speeds
from reference.elements import Section
from reference.independent_solution import Array
from reference.machines import pair_with_two_ranges
from reference.scenes import DENSITY, E, G, single_shaft
from reference.train import RigidSpec, ShaftPart, ShaftSpec, Train

LENGTH, DIAMETER, ELEMENTS = 1.0, 0.02, 2
DISK = {"mass": 10.0, "diametral_inertia": 0.05, "polar_inertia": 0.1}
UNBALANCE = 1e-3 + 2e-3j
BOW = HalfSine(1e-4, 0.5)
ENDS = (0.0, LENGTH)

# A rotor of 10 kg whose bearings stiffen with the speed and couple the planes like a journal
# bearing.
SPEEDS = np.array([0.0, 40.0, 70.0, 110.0, 160.0])
STIFFNESS = np.array(
    [
        [[8e4 + 900.0 * s, 30.0 * s], [-60.0 * s, 6e4 + 400.0 * s + 5.0 * s**2]]
        for s in SPEEDS
    ]
)  # fmt: skip
DAMPING = np.array([(600.0 - 2.0 * s, 700.0 - 1.5 * s) for s in SPEEDS])


def rotor(stiffness: Any = None, damping: Any = None, **options: Any) -> gb.RotorSystem:
    stiffness = gb.SpeedTable(SPEEDS, STIFFNESS) if stiffness is None else stiffness
    damping = gb.SpeedTable(SPEEDS, DAMPING) if damping is None else damping
    return single_shaft(
        BOW.package(LENGTH),
        length=LENGTH,
        diameter=DIAMETER,
        elements=ELEMENTS,
        density=DENSITY,
        support=None,
        disks=[gb.Disk("wheel", "s", 0.5, **DISK, unbalance=UNBALANCE)],
        bearings=[gb.Bearing("s", x, stiffness=stiffness, damping=damping) for x in ENDS],
        **options,
    )


def dense(speed: float) -> tuple[Array, Array]:
    """Return stiffness and damping of one bearing from SciPy's interpolation."""
    speed = abs(speed)
    return PchipInterpolator(SPEEDS, STIFFNESS)(speed), np.diag(
        PchipInterpolator(SPEEDS, DAMPING)(speed)
    )


def frozen(speed: float) -> gb.RotorSystem:
    """Return the rotor on constant bearings of one speed."""
    return rotor(*dense(speed))


RUN: dict[str, Any] = {
    "record": ["wheel", ("s", 0.0), ("s", LENGTH), "bearings", "energy"],
    "output_step": 1e-3,
}


@pytest.mark.parametrize("knot", range(len(SPEEDS)))
def test_at_a_knot_every_result_equals_that_of_the_constant_bearing(knot: int):
    speed = float(SPEEDS[knot])
    table, constant = rotor(), rotor(STIFFNESS[knot], DAMPING[knot])
    for name in ("mass", "stiffness", "damping", "gyroscopic"):
        first, second = (getattr(s.matrices(speed), name) for s in (table, constant))
        np.testing.assert_array_equal(first, second)
    np.testing.assert_array_equal(table.modes(speed).shapes, constant.modes(speed).shapes)
    answers = [s.synchronous([speed]) for s in (table, constant)]
    np.testing.assert_array_equal(*(answer.displacement("wheel") for answer in answers))
    np.testing.assert_array_equal(*(answer.bearing_force(("s", 0.0)) for answer in answers))
    for method in ("exponential", "rk45"):
        runs = [s.simulate(0.01, speed, method=method, **RUN) for s in (table, constant)]
        np.testing.assert_array_equal(*(run.displacement("wheel") for run in runs))
        np.testing.assert_array_equal(*(run.bearing_force(("s", LENGTH)) for run in runs))
        np.testing.assert_array_equal(*(run.energy for run in runs))


def test_static_equilibrium_and_its_bearing_forces_are_those_of_the_speed():
    heavy = [s.static(speed=70.0) for s in (rotor(gravity=9.81), rotor(*dense(70.0), gravity=9.81))]
    np.testing.assert_array_equal(*(s.displacement("wheel") for s in heavy))
    np.testing.assert_array_equal(*(s.bearing_force(("s", 0.0)) for s in heavy))


def test_modes_between_the_knots_follow_the_interpolation():
    for speed in (13.0, 55.0, -99.0, 159.0):
        found, expected = rotor().modes(speed), frozen(speed).modes(speed)
        # round-off of both interpolations
        np.testing.assert_allclose(found.frequencies_hz, expected.frequencies_hz, rtol=1e-12)
        np.testing.assert_allclose(found.damping_ratios, expected.damping_ratios, rtol=1e-9)


def test_campbell_intersections_are_modes_of_their_speed():
    system = rotor()
    speeds = np.linspace(5.0, 160.0, 25)
    diagram = system.campbell(speeds, count=6)
    assert_modes_of_speeds(system, diagram, (0, 12, 24), 1e-9)
    assert len(diagram.intersections) >= 2
    for meeting in diagram.intersections:
        values = frozen(meeting.speed).modes(meeting.speed).eigenvalues
        assert np.abs(values.imag - meeting.speed).min() < 1e-9 * meeting.speed


def test_undamped_critical_speeds_belong_to_the_stiffness_of_the_same_speed():
    symmetric = (STIFFNESS + STIFFNESS.transpose(0, 2, 1)) / 2
    table = Model(rotor(gb.SpeedTable(SPEEDS, symmetric)).description)
    found = [speed for speed, _ in table.critical_speeds(1.0)]
    assert len(found) >= 2
    at = PchipInterpolator(SPEEDS, symmetric)
    for speed in found:
        near = [s for s, _ in Model(rotor(at(speed)).description).critical_speeds(1.0)]
        assert min(abs(s - speed) for s in near) < 1e-9 * speed
    # dense sampling finds no other: the frozen critical speed crosses the speed itself
    samples = np.linspace(0.5, 159.5, 160)
    below = [
        sum(s < speed for s, _ in Model(rotor(at(speed)).description).critical_speeds(1.0))
        for speed in samples
    ]
    assert np.abs(np.diff(below)).sum() == len(found)


def test_a_critical_speed_that_overtakes_the_speed_again_is_found():
    """Bearings that stiffen a thousandfold between 40 and 70 rad/s: below, in and above this range the frequency is the speed."""
    stiffness = np.array([6e3, 6e3, 5e6, 5e6, 5e6])
    table = gb.SpeedTable(SPEEDS, stiffness)
    found = np.sort([s for s, _ in Model(rotor(table, 0.0).description).critical_speeds(1.0)])
    at = PchipInterpolator(SPEEDS, stiffness)

    def criticals(speed: float) -> Array:
        pairs = Model(rotor(float(at(speed)), 0.0).description).critical_speeds(1.0)
        return np.sort([critical for critical, _ in pairs])

    # With rising speed, the frozen critical speeds fall below the speed, rise above it and fall again.
    samples = np.linspace(0.5, 159.5, 160)
    margins = np.array([criticals(speed)[:4] - speed for speed in samples])
    falling = (margins[:-1] >= 0.0) & (margins[1:] < 0.0)
    rising = (margins[:-1] < 0.0) & (margins[1:] >= 0.0)
    assert rising.sum() >= 1
    assert len(found[found < SPEEDS[-1]]) == falling.sum() + rising.sum()
    for speed in found:
        assert np.abs(criticals(speed) - speed).min() < 1e-9 * speed


def test_held_tables_give_critical_speeds_outside_their_range():
    table = gb.SpeedTable(SPEEDS, STIFFNESS[:, 0, 0], outside="hold")
    last = float(STIFFNESS[-1, 0, 0])
    found = [s for s, _ in Model(rotor(table, 0.0).description).critical_speeds(1.0)]
    constant = [s for s, _ in Model(rotor(last, 0.0).description).critical_speeds(1.0)]
    beyond = [s for s in constant if s > SPEEDS[-1]]
    assert beyond
    np.testing.assert_allclose([s for s in found if s > SPEEDS[-1]], beyond, rtol=1e-12)


RAMP = (30.0, 130.0, 0.6, 0.05)  # through the critical speed, from 0.05 s to 0.65 s
END = 0.75


turning = independent_solution.ramp(*RAMP)


@pytest.fixture(scope="module")
def judged() -> independent_solution.Motion:
    part = ShaftPart(LENGTH, Section(DIAMETER, E, G, DENSITY), ELEMENTS)
    wheel = RigidSpec("wheel", "s", 0.5, *DISK.values(), UNBALANCE)
    curves = (BOW.curve(LENGTH), BOW.slope(LENGTH))
    train = Train([ShaftSpec("s", [part], 1.0, *curves)], [wheel], [])
    stiffness, damping = (PchipInterpolator(SPEEDS, table) for table in (STIFFNESS, DAMPING))
    places = [train.dof("s", x, elements.V) for x in ENDS]

    def bearings(speed: float) -> tuple[Array, Array]:
        k, c = np.zeros_like(train.mass), np.zeros_like(train.mass)
        for i in places:
            k[i : i + 2, i : i + 2], c[i : i + 2, i : i + 2] = (
                stiffness(speed),
                np.diag(damping(speed)),
            )
        return k, c

    # the second derivative of the interpolation jumps at its knots
    start, end, duration, begin = RAMP
    knots = begin + (SPEEDS - start) / (end - start) * duration
    kinks = sorted([begin, begin + duration, *knots[(SPEEDS > start) & (SPEEDS < end)]])
    times = np.linspace(0.0, END, 151)
    return independent_solution.run_up(
        train, turning, times, rtol=1e-11, kinks=kinks, bearings=bearings
    )


def profile() -> gb.SpeedProfile:
    start, end, duration, begin = RAMP
    return gb.SpeedProfile.ramp(start, end, duration, begin=begin)


def test_a_run_up_through_the_critical_speed_follows_the_independent_solution(
    judged: independent_solution.Motion,
):
    options: dict[str, Any] = {
        "initial": "rest",
        "times": judged.time,
        "record": ["wheel", "bearings"],
    }
    exact = judged.displacement("wheel")
    size = np.abs(exact).max()
    found = rotor().simulate(END, profile(), method="rk45", rtol=1e-10, **options)
    # the independent solution is accurate to 1e-10
    assert np.abs(found.displacement("wheel") - exact).max() < 1e-8 * size
    # the step crosses the knots, where the second derivative of the interpolation jumps: third
    # order at worst
    errors = []
    for step in (2e-4, 1e-4):
        run = rotor().simulate(END, profile(), method="rk4", step=step, **options)
        errors.append(np.abs(run.displacement("wheel") - exact).max() / size)
    assert errors[1] < 1e-6
    assert np.log2(errors[0] / errors[1]) > 2.5
    # constant bearings of the initial speed differ by much more
    constant = frozen(RAMP[0]).simulate(END, profile(), method="rk45", rtol=1e-6, **options)
    assert np.abs(constant.displacement("wheel") - exact).max() > 0.05 * size
    # the recorded force has the coefficients of each speed
    i = judged.train.dof("s", 0.0, elements.V)
    expected = []
    for t, q, qd in zip(judged.time, judged.q, judged.qd, strict=True):
        k, c = dense(turning(float(t))[1])
        expected.append(k @ q[i : i + 2] + c @ qd[i : i + 2])
    gap = np.abs(found.bearing_force(("s", 0.0)) - np.array(expected)).max()
    assert gap < 1e-6 * np.abs(expected).max()


def test_the_energy_audit_counts_the_work_that_stiffens_the_bearings():
    run = rotor().simulate(END, profile(), method="rk45", rtol=1e-10, **RUN)
    balance = run.energy_balance()
    # the audit integrates the power over steps to the seventh digit
    assert np.abs(balance.residual).max() < 1e-7 * balance.total.max()
    # without that work the balance would not close; its power is u^T (dK/dt) u / 2
    slope = PchipInterpolator(SPEEDS, STIFFNESS).derivative()
    work = 0.0
    for x in ENDS:
        u = run.displacement(("s", x))
        speeds = [turning(float(t))[1:] for t in run.time]
        power = [q @ slope(s) @ q / 2 * a for q, (s, a) in zip(u, speeds, strict=True)]
        work += float(np.trapezoid(power, run.time))
    assert work > 1e-3 * balance.total.max()


def test_a_continued_run_equals_the_whole_run(tmp_path: Any):
    whole = rotor().simulate(0.4, profile(), method="rk45", **RUN)
    first = rotor().simulate(0.2, profile(), method="rk45", **RUN)
    second = rotor().simulate(0.2, profile(), method="rk45", initial=first, **RUN)
    np.testing.assert_array_equal(whole.final["state"], second.final["state"])
    whole.save(tmp_path / "run.npz")
    again = gb.Response.load(tmp_path / "run.npz")
    np.testing.assert_array_equal(again.bearing_force(("s", 0.0)), whole.bearing_force(("s", 0.0)))


def test_a_start_on_the_synchronous_motion_takes_the_bearings_of_the_first_speed():
    start = rotor().simulate(0.0, profile(), method="rk45", **RUN)
    constant = frozen(RAMP[0]).simulate(0.0, RAMP[0], method="rk45", **RUN)
    np.testing.assert_allclose(
        start.displacement("wheel"), constant.displacement("wheel"), rtol=1e-10
    )


def test_an_analysis_without_speed_says_how_to_give_one():
    bearing = gb.Bearing(
        "s", 0.0, stiffness=gb.SpeedTable(gb.rpm(np.array([500.0, 1e4])), [1e7, 2e7])
    )
    system = gb.RotorSystem(
        [gb.Shaft("s", length=1.0, outer_diameter=0.05)],
        bearings=[bearing, gb.Bearing("s", 1.0, stiffness=1e7)],
    )
    text = r"ranges from 52.36 to 1047 rad/s \(500 to 10000 rpm\), .* 0 rad/s .*; give .* speed="
    for ask in (system.modes, system.matrices, system.static):
        with pytest.raises(gb.SceneError, match=text):
            ask()


def test_speeds_outside_the_table_name_bearing_speed_and_range():
    text = r'bearings\[0\].stiffness: the table ranges from 0 to 160 rad/s \(0 to 1528 rpm\), but the shaft "s" turns at 200 rad/s \(1910 rpm\); extend'
    system = rotor()
    for ask in (
        lambda: system.modes(200.0),
        lambda: system.modes(-200.0),
        lambda: system.matrices(200.0),
        lambda: system.static(speed=200.0),
        lambda: system.synchronous([10.0, 200.0]),
        lambda: system.campbell([10.0, 200.0]),
        lambda: system.simulate(0.01, 200.0),
        lambda: system.simulate(0.1, gb.SpeedProfile.ramp(100.0, 200.0, 0.1), method="rk45"),
    ):
        with pytest.raises(gb.SceneError, match=text):
            ask()
    held = rotor(
        gb.SpeedTable(SPEEDS, STIFFNESS, outside="hold"),
        gb.SpeedTable(SPEEDS, DAMPING, outside="hold"),
    )
    end = rotor(STIFFNESS[-1], DAMPING[-1])
    np.testing.assert_array_equal(held.modes(200.0).eigenvalues, end.modes(200.0).eigenvalues)


@each_case(
    ("table", "message"),
    [
        (gb.SpeedTable([0.0], [1e8]), "bearings[0].stiffness.speeds: needs at least 2 speeds, got 1"),
        (gb.SpeedTable([0.0, 0.0], [1e8, 2e8]), "bearings[0].stiffness.speeds[1]: must be above the speed before it, 0, got 0"),
        (gb.SpeedTable([-1.0, 0.0], [1e8, 2e8]), "bearings[0].stiffness.speeds[0]: must not be negative, got -1"),
        (gb.SpeedTable([0.0, 1.0], [1e8]), "bearings[0].stiffness.values: needs one value for each of the 2 speeds, got 1"),
        (gb.SpeedTable([0.0, 1.0], [1e8, -2e8]), "bearings[0].stiffness.values[1]: must not be negative, got -2"),
        (gb.SpeedTable([0.0, 1.0], [1e8, np.nan]), "bearings[0].stiffness.values[1]: must be finite, got nan"),
        (gb.SpeedTable([0.0, 1.0], [1e8, (1e8, 1e8)]), "bearings[0].stiffness.values[1]: must have the same form"),
        (gb.SpeedTable([0.0, 1.0], [(1e8, 2e8, 3e8)] * 2), "bearings[0].stiffness.values[0]: expected a number, a pair"),
        (gb.SpeedTable([0.0, 1.0], [1e8, 1e8], outside="keep"), "bearings[0].stiffness.outside: unknown variant"),
        ("soft", "bearings[0].stiffness: "),
    ],
)  # fmt: skip
def test_invalid_tables_name_the_entry(table: Any, message: str):
    with pytest.raises(gb.SceneError, match="^" + re.escape(message)):
        rotor(table)


def test_tables_survive_files_and_descriptions(tmp_path: Any):
    system = rotor(damping=gb.SpeedTable(SPEEDS, DAMPING, outside="hold"))
    system.save(tmp_path / "scene.toml")
    for again in (
        gb.RotorSystem.load(tmp_path / "scene.toml"),
        gb.RotorSystem.from_dict(system.description),
    ):
        assert again.bearings == system.bearings
        assert again.description == system.description
        np.testing.assert_array_equal(again.modes(33.0).shapes, system.modes(33.0).shapes)


#: Speeds of each shaft in its tables [rad/s]; the second shaft turns at 25/32 of the first.
RANGES = {"a": (50.0, 150.0), "b": (20.0, 60.0)}
LAST_COMMON = 60.0 * 32 / 25


def two_ranges(outside: str = "error") -> gb.RotorSystem:
    return pair_with_two_ranges(RANGES, outside)


#: Analyses at a speed of the reference shaft; 60 rad/s is in all tables.
ANALYSES: dict[str, Callable[[gb.RotorSystem, float], Any]] = {
    "matrices": lambda system, v: system.matrices(v),
    "modes": lambda system, v: system.modes(v),
    "static": lambda system, v: system.static(speed=v),
    "campbell": lambda system, v: system.campbell(sorted({60.0, v})),
    "synchronous": lambda system, v: system.synchronous([60.0, v]),
    "slow roll": lambda system, v: system.synchronous([60.0]).subtract_slow_roll(v),
    "peaks": lambda system, v: system.synchronous(sorted({60.0, v})).peaks("ga"),
    "balance": lambda system, v: system.balance(["ga"], v),
    "run": lambda system, v: system.simulate(1e-4, v),
    "run-up": lambda system, v: system.simulate(1e-4, gb.SpeedProfile.ramp(60.0, v, 1e-4)),
    "continued": lambda system, v: system.simulate(1e-4, v, initial=system.simulate(1e-4, 60.0)),
}


@pytest.mark.parametrize("name", ANALYSES)
def test_tables_of_different_ranges_limit_every_analysis_to_the_common_range(name: str):
    system, analysis = two_ranges(), ANALYSES[name]
    # Both ends belong to the range, also after a multiplication with the speed ratio.
    for speed in (50.0, LAST_COMMON):
        analysis(system, speed)
    outside = {
        40.0: r'bearings\[0\].stiffness: the table ranges from 50 to 150 rad/s .*, but the shaft "a" turns at 40 rad/s',
        80.0: r'bearings\[2\].stiffness: the table ranges from 20 to 60 rad/s .*, but the shaft "b" turns at 62.5 rad/s',
    }
    for speed, message in outside.items():
        with pytest.raises(gb.SceneError, match="^" + message):
            analysis(system, speed)
        analysis(two_ranges("hold"), speed)
