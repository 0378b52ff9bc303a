"""Branches of steady states: Duffing's equation and a gear pair with clearance."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gearbow as gb
from gearbow import _core
from gearbow.analysis.arclength import Settings, branch
from gearbow.results.steady import instability
from gearbow.system import continuation
from reference.machines import bowed_pair, rotor
from reference.teeth import Toothed
from test_steady_state import train

#: Mean stiffness [N/m], half backlash [m] and damping ratio of the pair with clearance.
MEAN, HALF, ZETA = 2e8, 1e-5, 0.05
MESH = ("ga", "gb")


class Duffing:
    """Period map of Duffing's equation by the classical Runge–Kutta method."""

    STEPS = 100

    def images(self, states: np.ndarray, value: float, **_: Any) -> np.ndarray:
        step = 2 * np.pi / value / self.STEPS

        # A prediction may be far from the branch.
        with np.errstate(over="ignore", invalid="ignore"):
            return self.after_period(states, value, step)

    def after_period(self, states: np.ndarray, value: float, step: float) -> np.ndarray:
        x = states.T
        for number in range(self.STEPS):
            x = self.after_step(x, value, number * step, step)
        return x.T

    def after_step(self, x: np.ndarray, value: float, t: float, step: float) -> np.ndarray:
        def rate(t: float, x: np.ndarray) -> np.ndarray:
            force = 0.18 * np.cos(value * t)
            return np.array([x[1], force - 0.05 * x[1] - x[0] - 0.1 * x[0] ** 3])

        a = rate(t, x)
        b = rate(t + step / 2, x + step / 2 * a)
        c = rate(t + step / 2, x + step / 2 * b)
        d = rate(t + step, x + step * c)
        return x + step / 6 * (a + 2 * b + 2 * c + d)

    def first_harmonic(self, state: np.ndarray, value: float) -> float:
        """Return the amplitude of the first harmonic of the motion from a state."""
        step = 2 * np.pi / value / self.STEPS
        motion = [state[:, None]]
        for number in range(self.STEPS - 1):
            motion.append(self.after_step(motion[-1], value, number * step, step))
        return float(2 * np.abs(np.fft.rfft([x[0, 0] for x in motion])[1]) / self.STEPS)

    def observed(self, state: np.ndarray, _: float) -> tuple[np.ndarray, float]:
        return state, np.inf

    def multipliers(self, kept: np.ndarray, value: float) -> np.ndarray:
        moved = kept + 1e-5 * np.vstack([np.eye(2), -np.eye(2)])
        images = self.images(moved, value)
        found = np.linalg.eigvals((images[:2] - images[2:]).T / 2e-5).astype(complex)
        return found[np.argsort(-np.abs(found))]


def test_a_branch_ends_at_the_bound_of_the_interval():
    shaft = {"elements": 2, "bow": gb.Bow.half_sine(1e-4)}
    system = rotor(shaft, bearing={"stiffness": 1e8, "damping": 1e3})
    middle = ("rotor", 0.5)
    for start, stop in ((1.0, 2.0), (2.0, 1.0)):
        branch = system.continuation("bow", start, stop, speed=100.0, record=[middle])
        assert branch.values[[0, -1]].tolist() == [start, stop]
        assert branch.message == ""
        # the response to a bow is proportional to it
        amplitude = branch.amplitude(middle)
        np.testing.assert_allclose(amplitude, amplitude[0] * branch.values / start, rtol=1e-7)


def test_the_folds_of_duffings_equation():
    points = list(
        branch(Duffing(), np.array([0.28, 0.0]), Settings(0.6, 1.4, first_step=0.05, largest=0.1))
    )
    folds = [point.value for point in points if point.kind == "fold"]
    # 15 odd harmonics give 1.269602 and 1.115700; the fixed steps have an error of 1e-6.
    assert folds == pytest.approx([1.269602, 1.115700], abs=3e-6)
    assert points[-1].value == 1.4
    # between the folds the motion is unstable by a multiplier beyond +1
    at = [i for i, point in enumerate(points) if point.kind == "fold"]
    for i, point in enumerate(points):
        largest = np.abs(point.multipliers[0])
        assert (largest > 1) == (at[0] < i < at[1]) or i in at
    assert len(points) < 200


@pytest.mark.parametrize(("start", "stop"), [(0.6, 0.7), (0.7, 0.6)])
def test_no_point_beyond_the_interval_is_observed(start: float, stop: float):
    seen: list[float] = []

    class Watched(Duffing):
        def multipliers(self, kept: np.ndarray, value: float) -> np.ndarray:
            seen.append(value)
            return super().multipliers(kept, value)

    settings = Settings(start, stop, first_step=1.0)
    points = list(branch(Watched(), np.array([0.28, 0.0]), settings))
    assert seen == [point.value for point in points]
    assert (min(seen), max(seen)) == (0.6, 0.7)


def test_the_peak_of_duffings_equation():
    map_, points = Duffing(), []
    for point in branch(map_, np.array([0.28, 0.0]), Settings(0.6, 1.4, first_step=0.05)):
        # The fold at 1.2696 lies beyond the peak of the first harmonic.
        points.append(point)
        if point.kind == "fold":
            break
    amplitude = np.array([map_.first_harmonic(point.state, point.value) for point in points])
    top = int(amplitude.argmax())
    near = slice(top - 3, top + 3)
    at = [point.state[0] - points[top].state[0] for point in points[near]]
    fit = np.polynomial.Polynomial.fit(at, amplitude[near], 5)
    values = np.polynomial.Polynomial.fit(at, [point.value for point in points[near]], 5)
    roots = fit.deriv().roots()
    peak = min(roots.real[np.abs(roots.imag) < 1e-9], key=abs)
    # 15 odd harmonics; the fixed steps and the fit have errors of 1e-6.
    assert fit(peak) == pytest.approx(2.830198, abs=5e-6)
    assert values(peak) == pytest.approx(1.268717, abs=5e-6)


def test_a_point_of_a_whole_train_takes_few_periods(monkeypatch: pytest.MonkeyPatch):
    speed, rtol, periods = 100.0, 1e-8, 0
    system = train()
    correct = _core.corrected_states

    def counted(model: Any, *, states: Any, levels: Any, **options: Any) -> Any:
        nonlocal periods
        periods += len(states) + (levels is None)
        return correct(model, states=states, levels=levels, **options)

    monkeypatch.setattr(continuation, "corrected_states", counted)
    with pytest.warns(gb.AccuracyWarning, match=r"ends before bow 1\.1: max_points"):
        found = system.continuation(
            "bow", 1.0, 1.1, speed=speed, rtol=rtol, first_step=0.05, max_points=2
        )
    assert found.values.size == 3
    assert found.stable.all()
    # A dense derivative takes 4 periods for each degree of freedom, of which there are over 200.
    assert len(system.dofs) > 200
    assert periods < 15 * found.values.size
    last = found_at(system, found.values[-1], speed, rtol)
    for pair in (("g1", "g2"), ("g3", "g4")):
        force = last.response.mesh(pair).force
        assert found.statistic("max", pair, "force")[-1] == pytest.approx(force.max(), rel=1e-7)


def found_at(system: gb.RotorSystem, factor: float, speed: float, rtol: float) -> gb.SteadyState:
    """Return the steady state of a train with scaled bows, recorded at the instants of a branch."""
    shafts = [
        replace(shaft, bow=shaft.bow and replace(shaft.bow, amplitude=factor * shaft.bow.amplitude))
        for shaft in system.shafts
    ]
    return system.replace(shafts=shafts).steady_state(speed, rtol=rtol)


def clearance(load: float = 0.1, **changes: Any) -> gb.RotorSystem:
    """Return a gear pair of Kahraman and Singh: K f(x) with K = 1 − 0.2 cos Ωt − …, backlash 2."""
    bare = Toothed()
    shares = (0.2, 0.1, 0.05)
    zero = first_phase()
    stiffness = gb.Stiffness.fourier(
        MEAN,
        [share * MEAN for share in shares],
        [np.pi - number * zero for number in (1, 2, 3)],
        phase="prescribed",
    )
    error = gb.TransmissionError(tooth=[(share * HALF, 0.0) for share in (0.01, 0.004, 0.002)])
    mesh = {
        "stiffness": stiffness,
        "damping_ratio": ZETA,
        "backlash": 2 * HALF,
        "error": error,
        **changes,
    }
    radius = bare.law().base_radius_a
    return Toothed(mesh=mesh, torque=load * MEAN * HALF * radius).package()


def first_phase() -> float:
    """Return the phase of the first harmonic of the mesh cycle at the shaft angle 0."""
    fourier = gb.Stiffness.fourier(MEAN, [0.1 * MEAN], phase="prescribed")
    system = Toothed(mesh={"stiffness": fourier}).package()
    period = 2 * np.pi / (100.0 * 25)
    found = system.simulate(
        period, 100.0, initial="rest", times=np.arange(32) * period / 32, record=["meshes"]
    )
    return float(np.angle(np.fft.rfft(found.mesh(MESH).stiffness)[1]))


def speed(ratio: float) -> float:
    """Return the speed for a tooth frequency Ω over the natural frequency."""
    return float(ratio * np.sqrt(MEAN / Toothed().effective_mass) / 25)


def test_the_pair_with_clearance_has_the_published_motion():
    steady = clearance().steady_state(
        speed(0.5), rtol=1e-10, initial="static", record=["meshes"], output_step=1e-7
    )
    x = steady.response.mesh(MESH).deflection / HALF + 1
    # The damper acts in contact, and the flanks never pull: the value of an independent integration
    # with tolerance 1e-9. With a damper that pulls, the largest value is 1.2409336.
    assert x.max() == pytest.approx(1.24052582, abs=1e-7)


def test_the_pair_with_damping_in_separation_has_the_published_motion():
    steady = clearance(damping_in_separation=True).steady_state(
        speed(0.5), rtol=1e-10, initial="static", record=["meshes"], output_step=1e-7
    )
    x = steady.response.mesh(MESH).deflection / HALF + 1
    assert x.max() == pytest.approx(1.2423926, abs=1e-6)
    assert x.std() == pytest.approx(0.0903348, abs=1e-6)
    # the damper acts always: |mu| = exp(-zeta T) with T = 2 pi / 0.5 of the natural frequency 1
    exact = np.exp(-ZETA * 2 * np.pi / 0.5)
    multipliers = steady.multipliers(0.5)
    assert np.abs(np.abs(multipliers) - exact).min() < 1e-6


def test_a_motion_that_does_not_repeat_is_an_error_after_few_periods():
    # A light torque lets the flanks rattle: steps of Newton's method do not reduce the difference.
    zero = first_phase()
    shares = [0.06 * MEAN, 0.03 * MEAN]
    phases = [np.pi - number * zero for number in (1, 2)]
    system = clearance(
        load=0.0007,
        stiffness=gb.Stiffness.fourier(MEAN, shares, phases, phase="prescribed"),
        error=gb.TransmissionError(tooth=[(0.02 * HALF, 0.0), (0.01 * HALF, 0.0)]),
        damping_ratio=0.013,
        damping_in_separation=True,
    )
    with pytest.raises(gb.ConvergenceError, match=r"did not converge in \d+ periods") as raised:
        system.steady_state(speed(0.65), rtol=1e-4)
    # An attempt of Newton's method that went on without a reduction would take 500 periods.
    assert int(str(raised.value).split(" periods")[0].split()[-1]) < 300


def test_the_branch_of_the_pair_with_clearance_has_four_folds(tmp_path: Path):
    system = clearance(damping_in_separation=True)
    found = system.continuation(
        "speed", speed(0.95), speed(0.4), record=["meshes"], rtol=1e-9, first_step=0.05
    )
    assert not found.message
    ratios = found.folds / speed(1.0)
    assert ratios.size == 4
    assert np.all((ratios > 0.43) & (ratios < 0.84))
    # located to 1e-6: another step along the branch gives the same values
    assert ratios == pytest.approx([0.598153, 0.835838, 0.437007, 0.455324], abs=1e-6)
    # both branches of each jump are stable, the one between the folds is not
    inside = np.flatnonzero([kind == "fold" for kind in found.kinds])
    assert found.stable[0]
    assert found.stable[-1]
    assert not found.stable[inside[0] + 1 : inside[1]].any()
    assert found.contact_loss.size >= 2
    path = tmp_path / "branch.npz"
    found.save(path)
    again = gb.Continuation.load(path)
    np.testing.assert_array_equal(again.values, found.values)
    np.testing.assert_array_equal(again.stable, found.stable)
    np.testing.assert_array_equal(
        again.amplitude(MESH, "deflection"), found.amplitude(MESH, "deflection")
    )
    assert repr(again) == repr(found)


def test_differences_do_not_limit_the_convergence_of_newtons_method():
    system, at, rtol = clearance(damping_in_separation=True), speed(0.9), 1e-10
    steady = system.steady_state(at, rtol=1e-8, record=["meshes"])
    deflection = steady.response.mesh(MESH).deflection
    assert deflection.min() < 0.0 < deflection.max()
    motion = continuation._Motion(
        continuation._Family(system, "speed", at),
        ["meshes"],
        continuation._RunSettings(None, rtol, "live"),
        (1, 1.0),
        128,
    )
    state = motion.unknowns(steady) * (1 + 1e-3 * np.sin(np.arange(7)))
    residuals = []
    image = motion.images(state[None], at, adapt=True)[0]
    for _ in range(4):
        size = np.linalg.norm(state)
        residuals.append(np.linalg.norm(image - state) / size)
        moved = motion.images(state + 1e-7 * size * np.eye(state.size), at)
        derivative = (moved - image).T / (1e-7 * size)
        state = state + np.linalg.solve(np.eye(state.size) - derivative, image - state)
        image = motion.images(state[None], at)[0]
    # Round-off is reached after two or three corrections, as with a variational equation.
    assert residuals[0] > 1e-5
    assert residuals[3] < 1e-13


def parametric() -> gb.RotorSystem:
    """Return a lightly damped pair whose stiffness varies by 30 %, and nothing else excites."""
    stiffness = gb.Stiffness.fourier(
        MEAN, [0.3 * MEAN], [np.pi - first_phase()], phase="prescribed"
    )
    return clearance(
        stiffness=stiffness, damping_ratio=0.02, damping_in_separation=True, error=None
    )


def test_a_strong_parametric_excitation_flips_the_motion():
    system = parametric()
    found = system.continuation("speed", speed(2.4), speed(1.7), record=["meshes"], rtol=1e-9)
    assert not found.message
    # Mathieu's boundaries Ω² = 4 (1 ± √((h/2)² − (2 ζ)²)), whose error is of order h².
    width = np.sqrt(0.15**2 - 0.04**2)
    exact = 2 * np.sqrt(1 + np.array([width, -width]))
    assert found.flips / speed(1.0) == pytest.approx(exact, abs=3e-3)
    kinds = np.array(found.kinds)
    first, last = np.flatnonzero(kinds == "flip")
    for at in (first, last):
        real = found.multipliers[at].real[found.multipliers[at].imag == 0.0]
        assert np.abs(real + 1.0).min() < 1e-6
    names = [instability(values) for values in found.multipliers]
    assert set(names[first + 1 : last]) == {"flip"}
    assert set(names[:first] + names[last + 1 :]) == {None}


@pytest.mark.parametrize(("ratio", "doubles"), [(2.2, False), (2.05, True), (1.8, False)])
def test_beyond_a_flip_the_period_of_the_motion_doubles(ratio: float, doubles: bool):
    system, count = parametric(), 32
    period = 2 * np.pi / (25 * speed(ratio))
    times = (400 + np.arange(2 * count) / count) * period
    run = system.simulate(402 * period, speed(ratio), times=times, rtol=1e-8, record=["meshes"])
    again = system.simulate(
        2 * period,
        speed(ratio),
        initial=run,
        times=times + 2 * period,
        rtol=1e-8,
        record=["meshes"],
    )
    x, next_x = (one.mesh(MESH).deflection for one in (run, again))
    size = np.ptp(x)
    assert np.abs(next_x - x).max() < 1e-6 * size
    difference = np.abs(x[count:] - x[:count]).max()
    assert difference > 0.5 * size if doubles else difference < 1e-6 * size


def equal_gears(bow: float) -> gb.RotorSystem:
    """Return a pair with equal gears, modal damping and this amplitude [m] of the bow."""
    bearing = {"stiffness": 1e8, "damping": 1e3}
    return bowed_pair(bow, (25, 25), bearing=bearing, torque=50.0, modal_damping=0.02)


@pytest.mark.filterwarnings("ignore::gearbow.SceneWarning", "ignore::gearbow.AccuracyWarning")
def test_a_branch_ends_where_the_bow_ends_the_contact_geometry():
    found = equal_gears(1e-3).continuation(
        "bow", 4.0, 6.0, speed=50.0, rtol=1e-8, initial="synchronous", record=["meshes"]
    )
    assert found.message.startswith("continuation: the branch cannot be followed beyond 4.5")
    assert "the base circles overlap" in found.message
    # The points so far are kept.
    assert found.values.size > 2
    distance = found.statistic("min", ("g1", "g2"), "centre_distance")
    radii = 2 * 25 * 3e-3 / 2 * np.cos(np.radians(20))
    assert 0.0 < distance[-1] - radii < 1e-5
    # A sweep keeps the points that exist, too.
    swept = gb.sweep(equal_gears, {"bow": [1e-3, 6e-3]}, one_run)
    assert [len(swept.failed), "base circles overlap" in str(swept.failed)] == [1, True]


def one_run(system: gb.RotorSystem, **_: float) -> float:
    return float(system.simulate(0.1, 50.0).mesh(("g1", "g2")).force.max())


def test_a_branch_over_the_torque_keeps_what_it_reached():
    with pytest.warns(gb.AccuracyWarning, match="branch ends before torque 3: max_points"):
        found = clearance().continuation(
            "torque", 1.0, 3.0, speed=speed(0.3), record=["meshes"], max_points=3
        )
    assert found.values.size >= 4
    assert found.message.startswith("max_points: 3 points reach")
    assert "open end: 'max_points: 3 points reach" in repr(found)
    (panel,) = found.plot(MESH).axes
    open_end = panel.get_lines()[-1]
    assert open_end.get_label().startswith("open end")
    assert open_end.get_xdata().tolist() == [found.values[-1]]


def test_a_branch_to_its_end_has_no_open_end():
    found = clearance().continuation("torque", 1.0, 1.05, speed=speed(0.3), record=["meshes"])
    assert found.values[-1] == 1.05
    assert "open end" not in repr(found)
    (panel,) = found.plot(MESH).axes
    assert not any(line.get_label().startswith("open end") for line in panel.get_lines())


def test_a_point_of_the_new_scene_takes_few_evaluations(monkeypatch: pytest.MonkeyPatch):
    # the scene that the command "new" writes
    system = gb.RotorSystem.load(Path(gb.__file__).parent / "cli" / "example.toml")
    evaluations = 0
    correct = _core.corrected_states

    def counted(model: Any, *, states: Any, levels: Any, **options: Any) -> Any:
        nonlocal evaluations
        evaluations += len(states) + (levels is None)
        return correct(model, states=states, levels=levels, **options)

    monkeypatch.setattr(continuation, "corrected_states", counted)
    with pytest.warns(gb.AccuracyWarning, match="branch ends before speed 600"):
        found = system.continuation("speed", 300.0, 600.0, max_points=8, record=["meshes"])
    # The motion that runs in at the last speed: both have an error of the accuracy "engineering".
    alone = system.steady_state(float(found.values[-1]), rtol=1e-7, record=["meshes"])
    forces = alone.response.mesh(("pinion", "wheel")).force
    amplitude = found.amplitude("pinion/wheel", "force")[-1]
    assert amplitude == pytest.approx(np.ptp(forces) / 2, rel=1e-2)
    # Near the fold at 303.17 rad/s a point takes 3 to 6 corrections; without the slope at each
    # slow one, up to 12 with 3 evaluations each.
    assert evaluations <= 15 * found.values.size


def test_wrong_arguments_name_the_argument():
    system = clearance()
    with pytest.raises(gb.SceneError, match="parameter: must be one of speed, torque"):
        system.continuation("mass", 1.0, 2.0)
    with pytest.raises(gb.SceneError, match="speed: give it"):
        system.continuation("torque", 1.0, 2.0)
    with pytest.raises(gb.SceneError, match="bow: no shaft has a bow"):
        system.continuation("bow", 1.0, 2.0, speed=10.0)


def test_an_interrupted_branch_keeps_its_points():
    def stop(fraction: float) -> None:
        if fraction > 0.5:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt) as caught:
        clearance().continuation(
            "backlash",
            HALF,
            3 * HALF,
            speed=speed(0.3),
            record=["meshes"],
            max_points=6,
            progress=stop,
        )
    kept: gb.Continuation = caught.value.branch  # type: ignore[attr-defined]
    assert kept.values.size == 4
    assert kept.message == "interrupted"
    assert kept.stable.all()
    assert "backlash" in repr(kept)
    kept.plot(MESH, "deflection").savefig(Path("/dev/null"), format="png")
    (panel,) = kept.plot(MESH, speed_unit="rpm").axes
    assert panel.get_xlabel() == "backlash [µm]"
    table = kept.to_dataframe(MESH)
    assert len(table) == kept.values.size
    assert table.columns[1:3].tolist() == ["stable", "kind"]
    np.testing.assert_array_equal(table.iloc[:, -1], kept.amplitude(MESH))


def test_tilting_pads_keep_their_tilt_along_a_branch():
    # the symmetric part of the stiffness of a loaded pad is negative in one direction, which is no rigid-body motion
    size = {"diameter": 0.06, "length": 0.03, "clearance": 1e-4, "viscosity": 0.02}
    pads = [gb.TiltingPadBearing("s", x, **size, pad_count=5, pad_inertia=1e-4) for x in (0.1, 0.7)]
    shaft = gb.Shaft("s", length=0.8, outer_diameter=0.06, elements=2, bow=gb.Bow.half_sine(2e-5))
    disk = gb.Disk("d", "s", 0.4, mass=15.0, diametral_inertia=0.1, polar_inertia=0.2)
    system = gb.RotorSystem([shaft], disks=[disk], bearings=pads, gravity=9.81, motion="lateral")
    found = system.continuation("speed", 300.0, 300.5, first_step=0.5, record=["d"], max_points=20)
    steady = system.steady_state(float(found.values[-1]), record=["d"]).response
    expected = 0.5 * np.ptp(steady.displacement("d")[:, 0])
    # the instants of the samples miss the extremes by 1e-3 of them
    assert found.amplitude("d", "y")[-1] == pytest.approx(expected, rel=5e-3)
