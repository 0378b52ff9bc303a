"""The exponential method at changing speed, against rk45 at a tight tolerance."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import gearbow as gb
from reference.comparisons import error
from test_contact_events import scene
from test_random_scenes import Drawn

#: Largest difference from rk45 at rtol 1e-10: of a displacement, and of a mesh force, divided by the RMS of
#: the variation. The default tolerance leaves ten times less.
DISPLACEMENT, FORCE = 1e-4, 1e-3

#: A pair on soft shafts, with a critical speed at 97 rad/s.
PAIR = Drawn(
    lengths=(0.4, 0.5),
    diameters=(0.03, 0.03),
    elements=(2, 2),
    mesh=("parabolic", 1e8, 0.05),
    bearing=(0.02, 0.02, 0.0, 0.2),
    gravity=(0.0, 0.0),
    rayleigh=0.0,
)
UP = gb.SpeedProfile.ramp(0.0, 300.0, 0.03)
DOWN = gb.SpeedProfile.ramp(300.0, 20.0, 0.03)


def wavering(duration: float) -> gb.SpeedProfile:
    """Return a speed of 200 rad/s that varies by 2 % once per revolution."""
    return gb.SpeedProfile.function(lambda t: 200.0 * (1.0 + 0.02 * np.sin(200.0 * t)), duration)


def system(drawn: Drawn = PAIR, **parts: Any) -> gb.RotorSystem:
    return drawn.system().replace(**parts)


def difference(found: gb.Response, exact: gb.Response) -> tuple[float, float]:
    """Return the errors of displacements and of mesh forces, the largest of all gears and meshes."""

    gears, pair = ("g0", "g1"), ("g0", "g1")
    displacement = max(error(found.displacement(g), exact.displacement(g)) for g in gears)
    return displacement, error(found.mesh(pair).force, exact.mesh(pair).force)


def compare(
    scene: gb.RotorSystem, profile: gb.SpeedProfile, duration: float = 0.03, **how: Any
) -> tuple[gb.Response, gb.Response]:
    """Run both methods and check the difference."""
    options = {"initial": "rest", "times": np.linspace(0.0, duration, 301)} | how
    geometry = {"geometry": options.pop("geometry", "live"), "times": options.pop("times")}
    initial = {"initial": options.pop("initial")}
    if "step" not in options:
        options = {"rtol": 1e-6} | options
    found = scene.simulate(duration, profile, **geometry, **initial, **options)
    exact = scene.simulate(duration, profile, method="rk45", rtol=1e-10, **geometry, **initial)
    displacement, force = difference(found, exact)
    assert displacement < DISPLACEMENT, (displacement, force)
    assert force < FORCE, (displacement, force)
    return found, exact


@pytest.mark.parametrize("geometry", ["live", "frozen"])
@pytest.mark.parametrize("kind", ["mean", "square", "parabolic"])
def test_a_run_up_through_a_critical_speed(kind: str, geometry: str):
    compare(system(replace(PAIR, mesh=(kind, 1e8, 0.05))), UP, geometry=geometry)


@pytest.mark.parametrize("damping", [None, 0.02])
@pytest.mark.parametrize("profile", [UP, DOWN, wavering(0.03)], ids=["up", "down", "wavering"])
def test_modal_damping_and_other_profiles(profile: gb.SpeedProfile, damping: float | None):
    compare(system(modal_damping=damping), profile, initial="synchronous")


def test_a_speed_that_varies_with_every_revolution_takes_few_steps():
    scene, profile = system(), wavering(0.1)
    constant = scene.simulate(0.1, 200.0).statistics
    found = scene.simulate(0.1, profile).statistics
    # The pieces of the profile are smooth: none of them ends a step.
    assert len(profile.breaks) > 100
    assert found.steps < 1.3 * constant.steps


@pytest.mark.parametrize("kind", ["mean", "square"])
def test_flanks_that_separate(kind: str):
    drawn = replace(PAIR, mesh=(kind, 1e8, 0.02), backlash=5e-5, torque=5.0)
    found, exact = compare(system(drawn), gb.SpeedProfile.ramp(100.0, 250.0, 0.01), 0.01, rtol=1e-8)
    own, other = ([(e.kind, e.driver) for e in run.events] for run in (found, exact))
    assert "separation" in {kind for kind, _ in own}
    assert own == other
    instants = [[e.time for e in run.events] for run in (found, exact)]
    np.testing.assert_allclose(*instants, atol=1e-8)


def table_bearings(scene: gb.RotorSystem) -> list[gb.Bearing]:
    """Return bearings whose stiffness triples over the run-up, with cross-coupling."""
    stiffness = gb.SpeedTable(
        [0.0, 150.0, 400.0],
        np.array([[[1e6, 0.0], [0.0, 2e6]], [[2e6, 3e5], [-2e5, 2e6]], [[4e6, 1e6], [-8e5, 3e6]]]),
    )
    damping = gb.SpeedTable([0.0, 400.0], [300.0, 100.0])
    return [replace(b, stiffness=stiffness, damping=damping) for b in scene.bearings]


@pytest.mark.parametrize("damping", [None, 0.02])
def test_speed_dependent_bearings(damping: float | None):
    scene = system(replace(PAIR, gravity=(3.0, -9.81)), modal_damping=damping)
    compare(scene.replace(bearings=table_bearings(scene)), UP)


def test_errors_are_in_proportion_to_the_tolerance():
    scene = system(modal_damping=0.02)
    options: dict[str, Any] = {"initial": "rest", "times": np.linspace(0.0, 0.01, 101)}
    profile = gb.SpeedProfile.ramp(0.0, 600.0, 0.01)
    exact = scene.simulate(0.01, profile, method="rk45", rtol=1e-12, **options)
    for rtol in (1e-4, 1e-6, 1e-8):
        found = scene.simulate(0.01, profile, rtol=rtol, **options)
        # 100: as at constant speed; couplings are neglected up to ten times the tolerance
        assert max(difference(found, exact)) < 100 * rtol


def test_steps_follow_the_speed():
    profile = gb.SpeedProfile.table([0.0, 0.2, 0.21, 0.25], [2.0, 2.0, 400.0, 400.0])
    found = system(replace(PAIR, mesh=("mean", 1e8, 0.05))).simulate(0.25, profile, rtol=1e-3)
    # 64 steps per revolution of the fast part, and as few as the lowest mode needs before it
    assert found.statistics.step_max > 4 * found.statistics.step_min
    assert found.statistics.step_min <= 2 * np.pi / 400.0 / 64


def test_rotors_without_gyroscopic_difference_or_without_meshes():
    shaft = gb.Shaft("s", length=1.0, outer_diameter=0.02, elements=2, bow=gb.Bow.half_sine(1e-4))
    bearings = [gb.Bearing("s", x, stiffness=1e6, damping=500.0) for x in (0.0, 1.0)]
    disk = gb.Disk("d", "s", 0.5, 10.0, 0.05, 0.1, unbalance=1e-3 + 2e-3j)
    scene = gb.RotorSystem(shafts=[shaft], bearings=bearings, disks=[disk])
    for profile in (gb.SpeedProfile.ramp(20.0, 140.0, 0.2), gb.SpeedProfile.ramp(50.0, 50.0, 0.2)):
        found, exact = (
            scene.simulate(0.2, profile, record=["d"], output_step=1e-3, **how)
            for how in ({"rtol": 1e-9}, {"method": "rk45", "rtol": 1e-11})
        )
        size = np.abs(exact.displacement("d")).max()
        assert np.abs(found.displacement("d") - exact.displacement("d")).max() < 1e-8 * size


def test_fixed_steps_and_selected_modes():
    scene = system(modal_damping=0.02)
    compare(scene, UP, step=1e-5)
    # The error of 36 of 40 modes is that at constant speed.
    times = np.linspace(0.0, 0.03, 301)
    errors = []
    for profile in (gb.SpeedProfile.ramp(100.0, 300.0, 0.03), 200.0):
        found, complete = (
            scene.simulate(0.03, profile, initial="rest", times=times, modes=m) for m in (36, None)
        )
        errors.append(difference(found, complete))
    assert errors[0] < (3 * errors[1][0], 3 * errors[1][1])


def test_energy_is_accounted_for():
    scene = system(replace(PAIR, gravity=(3.0, -9.81)), modal_damping=0.02)
    scene = scene.replace(bearings=table_bearings(scene))
    found = scene.simulate(0.03, UP, record=["energy"], rtol=1e-8, output_step=1e-3)
    balance = found.energy_balance()
    # Gyroscopic forces do no work, whatever part of them the run contains.
    assert np.abs(balance.residual).max() < 1e-5 * np.ptp(balance.total)


class TestContinuation:
    """Cut a run-up."""

    @pytest.mark.parametrize("kind", ["square", "parabolic"])
    @pytest.mark.parametrize("backlash", [None, 5e-5])
    def test_the_same_bits_as_without_a_cut(self, kind: str, backlash: float | None):
        drawn = replace(PAIR, mesh=(kind, 1e8, 0.02), backlash=backlash, torque=5.0)
        scene = system(drawn)
        profile = gb.SpeedProfile.table([0.0, 3.3e-3, 7e-3], [100.0, 200.0, 150.0])
        whole = scene.simulate(8e-3, profile)
        part: Any = "synchronous"
        for duration in (1e-3, 2.5e-3, 3.7e-3, 8e-4):
            part = scene.simulate(duration, profile, initial=part)
        assert part.time[-1] == pytest.approx(8e-3)
        assert part.final["state"].tobytes() == whole.final["state"].tobytes()

    def test_modal_damping_and_bearings(self):
        scene = system(modal_damping=0.02)
        scene = scene.replace(bearings=table_bearings(scene))
        whole = scene.simulate(0.02, UP)
        part = scene.simulate(0.0123, UP)
        part = scene.simulate(0.02 - 0.0123, UP, initial=part)
        assert part.final["state"].tobytes() == whole.final["state"].tobytes()

    def test_a_stopped_run_goes_on_from_its_checkpoint(self, tmp_path):
        scene = system(modal_damping=0.02)
        options: dict[str, Any] = {
            "times": np.linspace(0.0, 0.02, 201),
            "record": ["gears", "energy"],
        }
        whole = scene.simulate(0.02, UP, **options)
        kept = {"checkpoint": tmp_path / "run.npz", "checkpoint_interval": 1e-9}

        def stop(_: float) -> None:
            raise KeyboardInterrupt

        for _ in range(3):
            with pytest.raises(KeyboardInterrupt) as stopped:
                scene.simulate(0.02, UP, progress=stop, **kept, **options)
        assert stopped.value.response.time.size < 201
        found = scene.simulate(0.02, UP, **kept, **options)
        assert found.displacement("g0").tobytes() == whole.displacement("g0").tobytes()
        assert found.energy.tobytes() == whole.energy.tobytes()

    def test_constant_speed_before_and_after(self):
        scene = system(modal_damping=0.02)
        first = scene.simulate(5e-3, 100.0, rtol=1e-6)
        profile = gb.SpeedProfile.ramp(100.0, 200.0, 5e-3, begin=5e-3)
        second = scene.simulate(7e-3, profile, initial=first, rtol=1e-6)
        third = scene.simulate(3e-3, 200.0, initial=second, rtol=1e-6)
        exact = scene.simulate(5e-3, 100.0, rtol=1e-9)
        exact = scene.simulate(7e-3, profile, initial=exact, method="rk45", rtol=1e-10)
        exact = scene.simulate(3e-3, 200.0, initial=exact, rtol=1e-9)
        assert max(difference(third, exact)) < DISPLACEMENT


def test_it_is_the_default():
    assert system().simulate(1e-4, UP, initial="rest").final["method"] == "exponential"


@pytest.mark.implausible
@pytest.mark.parametrize("seed", range(12))
def test_random_scenes(seed: int):
    drawn = scene(seed)
    slow, fast = (factor * (drawn.speed or 200.0) for factor in (0.5, 1.5))
    profile, times = gb.SpeedProfile.ramp(slow, fast, 1e-3), np.linspace(0.0, 1e-3, 11)
    options = {"initial": "rest", "times": times, "record": ["gears"]}
    for backlash in (None, drawn.backlash):
        train = replace(drawn, backlash=backlash).system()
        found = train.simulate(1e-3, profile, rtol=1e-9, **options)
        exact = train.simulate(1e-3, profile, rtol=1e-10, method="rk45", **options)
        for gear in ("g0", "g1"):
            error = np.abs(found.displacement(gear) - exact.displacement(gear)).max()
            # Impacts amplify the tolerance.
            assert error < 1e-5 * np.abs(exact.displacement(gear)).max()


@pytest.mark.filterwarnings("ignore::gearbow.SceneWarning")
@pytest.mark.parametrize("bearing", [1e4, 1e11])
@pytest.mark.parametrize("largest", [1.0, 3e3])
def test_extreme_bearings_and_speeds(bearing: float, largest: float):
    drawn = replace(PAIR, bearing=(bearing / 1e8, bearing / 1e8, 0.0, 0.2), lengths=(0.4, 0.1))
    profile = gb.SpeedProfile.ramp(largest, 0.0, 2e-3)
    options = {"initial": "rest", "times": np.linspace(0.0, 2e-3, 101)}
    found = drawn.system().simulate(2e-3, profile, rtol=1e-8, **options)
    exact = drawn.system().simulate(2e-3, profile, rtol=1e-10, method="rk45", **options)
    displacement, force = difference(found, exact)
    # On soft bearings the lowest mode carries hardly any force; see the limits in docs/methods.md.
    assert displacement < 1e-5
    assert force < 1e-4


def test_what_is_not_supported_is_named():
    with pytest.raises(gb.SceneError, match=r'^method: "etdrk4" needs a constant speed; use'):
        system().simulate(0.01, UP, method="etdrk4")
    with pytest.raises(gb.SceneError, match=r"^speed: changes its sign at 0.005 s"):
        system().simulate(0.01, gb.SpeedProfile.ramp(-50.0, 50.0, 0.01))
