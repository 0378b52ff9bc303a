"""Variable speed: run-ups against an independent integration, continuation, invalid profiles."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import CubicSpline, PPoly

import gearbow as gb
from reference import independent_solution
from reference.bows import HalfSine
from reference.cases import each_case
from reference.elements import Section
from reference.machines import hostile
from reference.scenes import DENSITY, PAIR, E, G, GearAt, Geared, single_shaft
from reference.train import BearingSpec, RigidSpec, ShaftPart, ShaftSpec, Train

# A rotor of 10 kg on a shaft of 20 mm: critical speed 76 rad/s, highest frequency 4.6e3 rad/s.
LENGTH, DIAMETER, ELEMENTS = 1.0, 0.02, 2
DISK = {"mass": 10.0, "diametral_inertia": 0.05, "polar_inertia": 0.1}
UNBALANCE = 1e-3 + 2e-3j
BOW = HalfSine(1e-4, 0.5)
DAMPING = 500.0
MIDDLE = ("s", 0.5)


def rotor(damping: float = DAMPING) -> gb.RotorSystem:
    return single_shaft(
        BOW.package(LENGTH),
        length=LENGTH,
        diameter=DIAMETER,
        elements=ELEMENTS,
        density=DENSITY,
        support=None,
        disks=[gb.Disk("wheel", "s", 0.5, **DISK, unbalance=UNBALANCE)],
        bearings=[gb.Bearing("s", x, stiffness=1e6, damping=damping) for x in (0.0, LENGTH)],
    )


def own_rotor() -> Train:
    part = ShaftPart(LENGTH, Section(DIAMETER, E, G, DENSITY), ELEMENTS)
    curves = (BOW.curve(LENGTH), BOW.slope(LENGTH))
    wheel = RigidSpec("wheel", "s", 0.5, *DISK.values(), UNBALANCE)
    bearings = [BearingSpec("s", x, 1e6 * np.eye(2), DAMPING * np.eye(2)) for x in (0.0, LENGTH)]
    return Train([ShaftSpec("s", [part], 1.0, *curves)], [wheel], bearings)


RAMP = (20.0, 140.0, 0.6, 0.05)  # the ramp passes the critical speed, from 0.05 s to 0.65 s
END = 0.75
KINKS = (0.05, 0.65)


@pytest.fixture(scope="module")
def solution() -> independent_solution.Motion:
    times = np.linspace(0.0, END, 301)
    return independent_solution.run_up(
        own_rotor(), independent_solution.ramp(*RAMP), times, rtol=1e-11, kinks=KINKS
    )


def profile() -> gb.SpeedProfile:
    start, end, duration, begin = RAMP
    return gb.SpeedProfile.ramp(start, end, duration, begin=begin)


def gap(found: gb.Response, exact: independent_solution.Motion, name: str = "wheel") -> float:
    expected = exact.displacement(name)
    return float(np.abs(found.displacement(name) - expected).max() / np.abs(expected).max())


def test_run_up_through_the_critical_speed_matches_the_independent_solution(
    solution: independent_solution.Motion,
):
    found = rotor().simulate(
        END, profile(), initial="rest", times=solution.time, record=["wheel"], rtol=1e-9
    )
    # the error of the independent solution is 1e-10
    assert gap(found, solution) < 1e-8
    # This fails if the force lacks the acceleration term, or if the angle is wrong.
    angle, speed, acceleration = independent_solution.ramp(*RAMP)(0.4)
    assert abs(UNBALANCE) * acceleration > 1e-3 * abs(UNBALANCE) * speed**2
    assert abs(speed * 0.4 - angle) > 1.0


def test_rk4_keeps_its_order_across_the_kinks(solution: independent_solution.Motion):
    system = rotor()
    # the kinks lie within steps
    errors = []
    for step in (2e-4, 1e-4):
        found = system.simulate(
            END, profile(), initial="rest", times=solution.time, record=["wheel"], method="rk4",
            step=step,
        )  # fmt: skip
        errors.append(gap(found, solution))
    assert errors[0] > 1e-9  # far above the error of the independent solution
    assert np.log2(errors[0] / errors[1]) == pytest.approx(4.0, abs=0.3)


def test_a_faster_run_up_has_a_later_and_lower_peak():
    # general result for rotors that pass a critical speed (Lewis 1932)
    system = rotor(damping=200.0)
    peaks = []
    for rate in (20.0, 100.0, 500.0):
        for start, end in ((20.0, 140.0), (140.0, 20.0)):
            run = gb.SpeedProfile.ramp(start, end, 120.0 / rate)
            found = system.simulate(120.0 / rate, run, record=["wheel"], output_step=1e-3)
            whirl = np.hypot(*found.displacement("wheel").T)
            peaks.append((found.speeds[np.argmax(whirl)], whirl.max()))
    up, down = np.array(peaks[::2]), np.array(peaks[1::2])
    critical = 2 * np.pi * system.modes().frequencies_hz[0]
    steady = np.abs(system.synchronous([critical]).displacement("wheel")).max()
    assert np.all(np.diff(up[:, 0]) > 0)
    assert np.all(np.diff(down[:, 0]) < 0)
    assert down[0, 0] < critical < up[0, 0]
    assert np.all(np.diff(up[:, 1]) < 0)
    assert up[0, 1] < steady


GEARED = Geared(
    bows={"input": HalfSine(1.5e-4), "middle": HalfSine(1.5e-4, 0.7)},
    angles=(0.4, -1.1),
    gears=[
        GearAt("g1", "input", 0.25, 25, unbalance=5e-3 + 1e-3j),
        GearAt("g2", "middle", 0.125, 50, unbalance=-2e-2j),
        GearAt("g3", "middle", 0.375, 25),
        GearAt("g4", "output", 0.25, 50, unbalance=3e-2),
    ],
)
SWIFT = (100.0, 900.0, 3e-3, 1e-3)  # 2.7e5 rad/s²: its force equals that of the speed


@pytest.mark.parametrize("how", [{"rtol": 1e-9}, {"method": "rk4", "step": 1.25e-7}], ids=str)
def test_a_geared_train_that_runs_up_matches_the_independent_solution(how: dict[str, Any]):
    times = np.linspace(0.0, 5e-3, 101)
    exact = independent_solution.run_up(
        GEARED.reference(), independent_solution.ramp(*SWIFT), times, rtol=1e-10, kinks=(1e-3, 4e-3)
    )
    start, end, duration, begin = SWIFT
    run = gb.SpeedProfile.ramp(start, end, duration, begin=begin)
    found = GEARED.package().simulate(5.01e-3, run, initial="rest", times=times, **how)
    for gear in ("g1", "g2", "g3", "g4"):
        for own, other in ((found.displacement, exact.displacement), (found.twist, exact.twist)):
            # as at constant speed
            assert np.abs(own(gear) - other(gear)).max() < 1e-6 * np.ptp(other(gear), axis=0).max()
    force = exact.mesh_force(0, True)
    assert np.abs(found.mesh(("g1", "g2")).force - force).max() < 1e-6 * np.ptp(force)


def test_energy_is_accounted_for_while_the_speed_changes():
    start, end, duration, begin = SWIFT
    run = gb.SpeedProfile.ramp(start, end, duration, begin=begin)
    found = GEARED.package().simulate(
        5e-3, run, initial="rest", record=["energy"], rtol=1e-9, output_step=1e-4
    )
    balance = found.energy_balance()
    # rtol and quadrature error of 3000 steps; the compared works are far larger
    allowed = 1e-7 * balance.total.max()
    assert np.abs(balance.residual).max() < allowed
    assert min(np.ptp(balance.drive), np.ptp(balance.unbalance)) > 1e4 * allowed


@pytest.mark.parametrize("method", ["exponential", "rk45", "rk4"])
def test_teeth_that_turn_at_a_changing_speed(method: str):
    # tooth engagement times follow from the shaft angle
    mesh = gb.Mesh("g1", "g2", stiffness=gb.Stiffness.square(mean=2e8), error=gb.TransmissionError(tooth=[(1e-6, 0.0)]))  # fmt: skip
    scene = PAIR.package()
    system = scene.replace(meshes=[mesh])
    run = gb.SpeedProfile.ramp(100.0, 300.0, 0.01)
    found = system.simulate(
        0.015, run, method=method, record=["meshes", "energy"], output_step=1e-5
    )
    pairs = found.mesh(("g1", "g2")).pairs_in_contact
    # speed = number of contact ends per time / teeth per revolution; 25 teeth, counted over 5 ms
    late = found.time > 0.01
    arrivals = np.count_nonzero(np.diff(pairs[late]) > 0)
    assert arrivals == pytest.approx(300.0 * 0.005 * 25 / (2 * np.pi), abs=1.0)
    early = found.time < 0.01
    arrivals = np.count_nonzero(np.diff(pairs[early]) > 0)
    assert arrivals == pytest.approx(200.0 * 0.01 * 25 / (2 * np.pi), abs=1.0)
    balance = found.energy_balance()
    # the default step of rk4 is stable but not accurate
    assert np.abs(balance.residual).max() < 1e-3 * np.ptp(balance.total)


class TestProfiles:
    """Give a speed in each accepted form."""

    def test_a_profile_that_does_not_change_is_a_constant_speed(self):
        system = GEARED.package()
        times = np.linspace(0.0, 3e-3, 31)
        options: dict[str, Any] = {"times": times, "method": "rk4"}
        constant = system.simulate(3e-3, 100.0, **options)
        flat = gb.SpeedProfile.table([-1.0, 4.0], [100.0, 100.0])
        found = system.simulate(3e-3, flat, **options)
        for gear in ("g1", "g4"):
            expected = constant.displacement(gear)
            error = np.abs(found.displacement(gear) - expected).max()
            assert error < 1e-12 * np.abs(expected).max()

    def test_the_angle_is_accurate_after_a_long_time(self):
        # an angle of 1e8 rad loses 1e-8 rad to round-off unless it is reduced early
        system = GEARED.package()
        options: dict[str, Any] = {"start": 1e6, "method": "rk4", "initial": "rest"}
        times = 1e6 + np.arange(9) * 2.0**-12
        constant = system.simulate(2e-3, 100.0, times=times, **options)
        flat = gb.SpeedProfile.table([0.5, 4.0], [100.0, 100.0])
        found = system.simulate(2e-3, flat, times=times, **options)
        # the second shaft rotates by exactly half of this angle
        expected = constant.displacement("g2")
        assert np.abs(found.displacement("g2") - expected).max() < 1e-11 * np.abs(expected).max()

    def test_values(self):
        run = gb.SpeedProfile.ramp(10.0, 30.0, 2.0, begin=1.0)
        np.testing.assert_allclose(run([0.0, 1.0, 1.5, 3.0, 9.0]), [10, 10, 15, 30, 30])
        assert run(2.0) == 20.0
        points = gb.SpeedProfile.table([0.0, 1.0, 4.0], [1.0, 5.0, 2.0])
        np.testing.assert_allclose(points([-1.0, 0.5, 1.0, 2.0, 5.0]), [1, 3, 5, 4, 2])

    def test_polynomials_of_scipy(self):
        spline = CubicSpline([0.0, 0.3, 1.0, 1.2], [100.0, 130.0, 90.0, 95.0])
        run = gb.SpeedProfile(spline.x, spline.c)
        t = np.linspace(0.0, 1.2, 100)
        np.testing.assert_allclose(run(t), spline(t), rtol=1e-14)
        again = PPoly(run.coefficients, run.breaks)
        np.testing.assert_allclose(again(t), spline(t), rtol=1e-14)

    @pytest.mark.parametrize(
        "f",
        [
            lambda t: 100 + 20 * np.sin(7 * t),
            lambda t: 100 + 20 * math.sin(7 * t),
            lambda t: np.minimum(40 * np.asarray(t), 50.0),
            lambda t: min(40 * t, 50.0),
            lambda _: 5.0,
        ],
        ids=["array", "scalar", "kink", "kink of a scalar", "constant"],
    )
    def test_a_function_is_followed(self, f):
        if f(0.5) == pytest.approx(100 + 20 * np.sin(3.5)):
            scalar = lambda t: 100 + 20 * np.sin(7 * t)  # noqa: E731
        else:
            scalar = f
        run = gb.SpeedProfile.function(f, 2.0, begin=1.0)
        t = np.random.default_rng(3).uniform(1.0, 3.0, 2000)
        expected = np.array([scalar(x) for x in t])
        assert np.abs(run(t) - expected).max() < 1e-10 * np.abs(expected).max()
        assert run(0.0) == pytest.approx(scalar(1.0), rel=1e-12)
        assert run(9.0) == pytest.approx(scalar(3.0), rel=1e-12)

    @pytest.mark.parametrize("method", ["exponential", "rk45", "rk4"])
    def test_a_kink_of_a_function_is_that_of_a_table(self, method: str):
        # intervals of 1e-13 s about the kink; a step of 1e-6 s must not pass the end of one
        system = GEARED.package()
        options: dict[str, Any] = {"times": np.linspace(0.0, 1e-3, 11), "method": method}
        sharp = gb.SpeedProfile.function(lambda t: 100 + 2e5 * abs(t - 4.1e-4), 1e-3)
        assert np.diff(sharp.breaks).min() < 1e-11
        exact = gb.SpeedProfile.table([0.0, 4.1e-4, 1e-3], [182.0, 100.0, 218.0])
        found, expected = (
            system.simulate(1e-3, run, **options).displacement("g1") for run in (sharp, exact)
        )
        # rk45 has a tolerance of 1e-6, the default step of rk4 a similar error, and the steps
        # differ
        assert np.abs(found - expected).max() < 1e-5 * np.ptp(expected)

    def test_all_forms_of_the_same_profile(self):
        system = rotor()
        options: dict[str, Any] = {"times": np.linspace(0.0, 0.1, 11), "rtol": 1e-9}
        ways = [
            gb.SpeedProfile.ramp(20.0, 40.0, 0.1),
            ([0.0, 0.1], [20.0, 40.0]),
            np.array([[0.0, 0.1], [20.0, 40.0]]),
            lambda t: 20.0 + 200.0 * t,
        ]
        runs = [system.simulate(0.1, way, record=["wheel"], **options) for way in ways]
        expected = runs[0].displacement("wheel")
        for run in runs[1:]:
            np.testing.assert_allclose(run.speeds, 20.0 + 200.0 * run.time, rtol=1e-10)
            # each run has its own intervals and steps
            error = np.abs(run.displacement("wheel") - expected).max()
            assert error < 1e-7 * np.abs(expected).max()

    def test_a_table_that_ends_before_the_run_is_a_warning_except_for_round_off(self):
        system, options = rotor(), {"record": ["wheel"], "output_step": 1e-3}
        end = (0.1 + 0.2) / 100.0
        assert end > 0.003
        system.simulate(end, ([0.0, 0.003], [20.0, 21.0]), **options)
        with pytest.warns(gb.SceneWarning, match=r"the last time is 0\.002 s, .* stays 21 rad/s"):
            system.simulate(end, ([0.0, 0.002], [20.0, 21.0]), **options)

    def test_a_response_contains_its_speed(self, tmp_path):
        system, run = rotor(), profile()
        found = system.simulate(0.1, run, output_step=0.01, record=["wheel"])
        assert found.speed is run
        np.testing.assert_array_equal(found.speeds, run(found.time))
        constant = system.simulate(0.1, 30.0, output_step=0.01, record=["wheel"])
        assert constant.speed == 30.0
        np.testing.assert_array_equal(constant.speeds, np.full(11, 30.0))
        found.save(tmp_path / "run.npz")
        loaded = gb.Response.load(tmp_path / "run.npz")
        assert isinstance(loaded.speed, gb.SpeedProfile)
        np.testing.assert_array_equal(loaded.speeds, found.speeds)
        a, b = (
            system.simulate(0.1, run, initial=initial, record=["wheel"])
            for initial in (found, loaded)
        )
        assert a.displacement("wheel").tobytes() == b.displacement("wheel").tobytes()

    def test_the_default_output_is_fine_enough_for_the_largest_speed(self):
        spacing = np.diff(rotor().simulate(0.5, ([0.0, 0.25, 0.5], [0.0, 2000.0, 0.0])).time)
        assert spacing[0] == pytest.approx(
            1e-4
        )  # the round number below a twentieth of 2 pi / 2000

    @each_case(
        ("speed", "text"),
        [
            ("fast", "^speed: must be a number, a SpeedProfile, a function .* got 'fast'"),
            (None, "^speed: must be a number"),
            (
                (1.0, 2.0),
                r"^speed.times: must be|^speed: needs equal numbers of times and speeds, at least two",
            ),
            (
                ([0.0, 1.0], [1.0, 2.0, 3.0]),
                "^speed: needs equal numbers of times and speeds, .*, got 2 times and 3 speeds",
            ),
            (([0.0, 1.0, 1.0], [1.0, 2.0, 3.0]), "^speed: times must ascend, 1 s follows 1 s"),
            (([0.0, np.nan], [1.0, 2.0]), r"^speed.times\[1\]: must be finite, got nan"),
            (([0.0, 1.0], [1.0, np.inf]), r"^speed.speeds\[1\]: must be finite, got inf"),
            (([0.0, 1.0], ["a", "b"]), r"^speed.speeds\[0\]: must be a number, got 'a'"),
            (([0.0, 2e-3], [-50.0, 50.0]), "^speed: changes its sign at 0.001 s"),
            (
                lambda t: 100.0 * (t < 5e-4),
                "^speed: the function is discontinuous or not smooth enough at 0.0005 s",
            ),
            (lambda t: np.nan * t, "^speed: the function gives nan at 0 s"),
            (lambda _: "a", "^speed: the function must give a number"),
        ],
        ids=lambda value: "function" if callable(value) else str(value),
    )
    def test_the_error_names_the_invalid_value(self, speed, text):
        with pytest.raises(gb.SceneError, match=text):
            rotor().simulate(2e-3, speed)

    def test_the_error_names_the_invalid_part(self):
        with pytest.raises(
            gb.SceneError, match=r"^speed: must not jump, goes from 1 to 2 rad/s at 1 s"
        ):
            gb.SpeedProfile([0.0, 1.0, 2.0], [[1.0, 2.0]])
        with pytest.raises(gb.SceneError, match=r"^speed: must have 1 to 4 rows of 1 coefficients"):
            gb.SpeedProfile([0.0, 1.0], np.ones((5, 1)))
        with pytest.raises(gb.SceneError, match=r"^speed.coefficients: must have 2 axes, got 1"):
            gb.SpeedProfile([0.0, 1.0], [1.0])
        with pytest.raises(gb.SceneError, match=r"^speed.duration: must be positive, got 0"):
            gb.SpeedProfile.ramp(1.0, 2.0, 0)
        with pytest.raises(gb.SceneError, match=r"^speed.duration: must be positive, got -1"):
            gb.SpeedProfile.function(np.cos, -1)

    def test_the_stability_limit_uses_the_largest_speed(self):
        # 2.8 divided by the sum of the frequency and twice the spin
        system = rotor(damping=0.0)
        omega = system.simulate(0.0, 1.0).statistics.omega_max
        step = 2.828 / (omega + 1e4)
        system.simulate(1e-3, ([0.0, 1e-3], [0.0, 2e3]), method="rk4", step=step)
        with pytest.raises(gb.StabilityError):
            system.simulate(1e-3, ([0.0, 1e-3], [0.0, 2e4]), method="rk4", step=step)


class TestContinuation:
    """Continue a response."""

    @pytest.mark.parametrize("method", ["exponential", "rk45", "rk4"])
    def test_the_same_profile_continues_bitwise(self, method: str):
        system, run = GEARED.package(), gb.SpeedProfile.ramp(100.0, 300.0, 2e-3, begin=1e-3)
        whole = system.simulate(4e-3, run, method=method)
        part: Any = "synchronous"
        for _ in range(4):
            part = system.simulate(1e-3, run, method=method, initial=part)
        assert part.final["state"].tobytes() == whole.final["state"].tobytes()

    def test_the_loaded_flanks_are_kept_down_to_rest(self):
        # a negative speed decreases to zero and stays zero: its sign is lost, the loaded flanks
        # must not change
        scene = replace(PAIR, sigma=-1.0, torque=-250.0, bows={"input": HalfSine(1e-4)}).package()
        mesh = gb.Mesh("g1", "g2", stiffness=2e8, damping_ratio=0.05, backlash=1e-4)
        system = scene.replace(meshes=[mesh])
        run = gb.SpeedProfile.ramp(-100.0, 0.0, 1e-3)
        whole = system.simulate(3e-3, run, output_step=1e-4)
        first = system.simulate(1.5e-3, run)
        second = system.simulate(1.5e-3, run, initial=first)
        assert second.final["state"].tobytes() == whole.final["state"].tobytes()
        assert second.mesh(("g1", "g2")).force.min() > 0.0
        assert whole.mesh(("g1", "g2")).force.min() > 0.0
        # from rest to negative speed the back flanks are in contact from the start
        up = system.simulate(1e-3, gb.SpeedProfile.ramp(0.0, -100.0, 1e-3), output_step=1e-4)
        assert up.mesh(("g1", "g2")).force.min() > 0.0

    @pytest.mark.parametrize("method", ["rk45", "rk4"])
    def test_another_speed_continues_at_the_shaft_angles(self, method: str):
        jump = 3.317e-3

        def turning(t: float) -> tuple[float, float, float]:
            if t < jump:
                return 100.0 * t, 100.0, 0.0
            return 100.0 * jump + 250.0 * (t - jump), 250.0, 0.0

        times = np.linspace(0.0, 5e-3, 101)
        early, late = times[times < jump], times[times > jump]
        exact = independent_solution.run_up(
            GEARED.reference(), turning, times, rtol=1e-10, kinks=(jump,)
        )
        how: dict[str, Any] = {"rk45": {"rtol": 1e-9}, "rk4": {"step": 1.25e-7}}[method]
        system = GEARED.package()
        how |= {"method": method, "record": ["gears"]}
        first = system.simulate(jump, 100.0, initial="rest", times=[*early, jump], **how)
        second = system.simulate(5e-3 - jump, 250.0, initial=first, times=[jump, *late], **how)
        for gear in ("g1", "g2", "g3", "g4"):
            a, b = first.displacement(gear), second.displacement(gear)
            expected = exact.displacement(gear)
            scale = np.ptp(expected, axis=0).max()
            # as at constant speed
            assert np.abs(np.vstack([a[:-1], b[1:]]) - expected).max() < 1e-6 * scale
            # the first run interpolates, the second one steps to this time
            assert np.abs(a[-1] - b[0]).max() < 1e-9 * scale

    def test_a_jump_equals_a_ramp_of_zero_duration(self):
        # from constant speed to a profile and back: the angle is continuous
        system = rotor()
        options: dict[str, Any] = {"record": ["wheel"], "rtol": 1e-10, "output_step": 1e-3}
        whole = system.simulate(0.3, ([0.0, 0.1, 0.2, 0.3], [50.0, 50.0, 80.0, 80.0]), **options)
        a = system.simulate(0.1, 50.0, **options)
        b = system.simulate(
            0.1, gb.SpeedProfile.ramp(50.0, 80.0, 0.1, begin=0.1), initial=a, **options
        )
        c = system.simulate(0.1, 80.0, initial=b, **options)
        for part, rows in ((a, slice(0, 101)), (b, slice(100, 201)), (c, slice(200, 301))):
            expected = whole.displacement("wheel")
            error = np.abs(part.displacement("wheel") - expected[rows]).max()
            assert error < 1e-7 * np.abs(expected).max()  # each run has its own steps

    def test_a_change_of_speed_and_back_keeps_the_angle(self):
        # no time passes at the other speed
        system = GEARED.package()
        options: dict[str, Any] = {"record": ["gears"], "rtol": 1e-9, "output_step": 1e-4}
        whole = system.simulate(4e-3, 100.0, **options)
        first = system.simulate(2e-3, 100.0, **options)
        still = system.simulate(0.0, 500.0, initial=first, **options)
        last = system.simulate(2e-3, 100.0, initial=still, **options)
        expected = whole.displacement("g4")
        error = np.abs(last.displacement("g4") - expected[20:]).max()
        assert error < 1e-7 * np.ptp(expected)

    @pytest.mark.parametrize("anchor", [[0.0, 1.0], [0.0, 1.0, np.nan], "none"])
    def test_an_invalid_known_angle_is_refused(self, anchor):
        system = rotor()
        final = system.simulate(1e-3, 100.0).final
        with pytest.raises(gb.SceneError, match=r"^initial.anchor: must be a time and an angle"):
            system.simulate(1e-3, 100.0, initial={**final, "anchor": anchor})

    def test_a_change_of_the_sense_of_rotation_is_refused(self):
        system = GEARED.package()
        first = system.simulate(1e-3, 100.0)
        with pytest.raises(
            gb.SceneError, match=r"^initial: ended at 100 rad/s and cannot continue at -50 rad/s"
        ):
            system.simulate(1e-3, -50.0, initial=first)


@pytest.mark.parametrize("initial", ["synchronous", "static"])
def test_runs_up_in_both_senses_begin_with_their_own_flanks(initial: str):
    # Both begin at standstill, where torque and bow deflect the shafts against the flanks that will
    # carry: drive or coast.
    system = hostile()

    def start(owner: gb.RotorSystem, sense: float) -> Any:
        speed = gb.SpeedProfile.ramp(0.0, sense * 100.0, 1e-3)
        run = owner.simulate(1e-3, speed=speed, initial=initial, output_step=1e-3)
        return run.displacement("g4")[0]

    first, second = start(system, 1.0), start(system, -1.0)
    alone = start(hostile(), -1.0)
    np.testing.assert_array_equal(second, alone)
    assert np.abs(first - alone).max() > 1e-3 * np.abs(first).max()
