"""Reduction to fewer modes: its error, the estimate of the error, and continued runs."""

from __future__ import annotations

import warnings
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import gearbow as gb
from gearbow.accuracy import LEVELS, check_reduction
from reference.comparisons import error
from reference.machines import bowed_double_stage

# The systems give their numbers of elements, which a level need not find fine enough.
pytestmark = pytest.mark.filterwarnings("ignore:accuracy:gearbow.AccuracyWarning")

SPEED = 100.0
GEARS = ("g1", "g2", "g3", "g4")
PAIRS = (("g1", "g2"), ("g3", "g4"))
UNDAMPED: dict[str, Any] = {"mesh": {}, "bearing": {"stiffness": 1e8}}
LOOSE: dict[str, Any] = {
    "mesh": {"damping_ratio": 0.05, "backlash": 1e-4},
    "torque": 15.0,
}
#: Options of the train and of the run.
CASES: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {
    "live": ({}, {}),
    "frozen": ({}, {"geometry": "frozen"}),
    "smooth": ({"engagement": 0.4}, {}),
    "undamped": ({"engagement": 0.2, **UNDAMPED}, {}),
    "modal damping": ({"modal_damping": 0.02}, {}),
    "transient": ({"engagement": 0.4}, {"initial": "static"}),
    "anisotropic": ({"bearing": {"stiffness": [[1e8, 1e7], [1e7, 4e7]]}}, {}),
    "separation": (LOOSE, {}),
}
#: From this number of elements a shaft on, components replace the complete model.
LARGE = 15


def errors(found: gb.Response, exact: gb.Response) -> np.ndarray:
    """Compute the errors of displacements and of mesh forces."""

    return np.array(
        [
            max(error(found.displacement(gear), exact.displacement(gear)) for gear in GEARS),
            max(error(found.mesh(pair).force, exact.mesh(pair).force) for pair in PAIRS),
        ]
    )


@pytest.mark.parametrize("name", CASES)
@pytest.mark.filterwarnings("ignore::gearbow.errors.AccuracyWarning")
def test_the_estimate_of_a_number_of_modes(name: str):
    options, run = CASES[name]
    system = bowed_double_stage(**options)
    exact = system.simulate(0.03, SPEED, rtol=1e-6, **run)
    found = system.simulate(0.03, SPEED, rtol=1e-6, modes=44, **run)
    assert found.statistics.modes == 44
    ratio = np.array(found.statistics.modes_error) / errors(found, exact)
    assert (ratio > 1 / 3).all()
    assert (ratio < 3).all()


@pytest.mark.parametrize("name", ["live", "undamped", "anisotropic"])
def test_the_estimate_of_component_modes(name: str):
    options, run = CASES[name]
    system = bowed_double_stage(LARGE, **options)
    assert len(system.dofs) >= 250
    exact = system.simulate(0.1, SPEED, rtol=1e-5, **run)
    found = system.simulate(0.31, SPEED, accuracy="engineering", times=exact.time, **run)
    true = errors(found, exact)
    assert found.statistics.modes < 0.7 * len(system.dofs)
    # a third of the total error, and the uncertainty of the estimate of three
    assert (true < (1e-3, 1e-2)).all()
    ratio = np.array(found.statistics.modes_error) / true
    assert (ratio > 1 / 3).all()
    assert (ratio < 3).all()


@pytest.mark.parametrize("speed", [SPEED, -SPEED])
@pytest.mark.parametrize("initial", ["rest", "static", "synchronous"])
def test_a_large_rotor_without_meshes_keeps_few_modes(initial: str, speed: float):
    places = np.linspace(0.03, 1.45, 26)
    bow = gb.Bow.half_sine(3e-5, phase=0.3)
    rotor = gb.RotorSystem(
        [gb.Shaft("s", length=1.5, outer_diameter=0.05, elements=40, bow=bow)],
        disks=[
            gb.Disk(f"d{i}", "s", x, 1.0 + 0.1 * i, 2e-3, 4e-3, unbalance=1e-5)
            for i, x in enumerate(places)
        ],
        bearings=[
            gb.Bearing("s", 0.1, stiffness=[[3e7, 1e7], [-4e6, 6e7]], damping=2e3),
            gb.Bearing("s", 1.37, stiffness=(2e7, 7e7), damping=(500.0, 4e3)),
        ],
        gravity=9.81,
        motion="lateral",
    )
    assert len(rotor.dofs) >= 250
    given: dict[str, Any] = {"initial": initial, "times": np.linspace(0.0, 0.15, 301)}
    found = rotor.simulate(0.15, speed, accuracy="engineering", **given)
    every = rotor.simulate(0.15, speed, modes=len(rotor.dofs), rtol=1e-8, **given)
    assert found.statistics.modes < 0.6 * len(rotor.dofs)
    for at in ("d0", "d11", "d25"):
        a, b = found.displacement(at), every.displacement(at)
        # the level permits 1e-3
        assert np.abs(a - b).max() < 3e-4 * np.ptp(b)


@pytest.mark.filterwarnings("ignore:modes. 40 modes leave an error:gearbow.AccuracyWarning")
def test_the_error_falls_fast_with_the_number_of_modes():
    # 40, 48 and 56 of these 75 modes leave errors of the mesh force of 3e-2, 3.6e-3 and 3.3e-3
    system = bowed_double_stage(engagement=0.2)
    exact = system.simulate(0.03, SPEED)
    found = [system.simulate(0.03, SPEED, modes=count) for count in (40, 48, 56)]
    force = [errors(each, exact)[1] for each in found]
    assert force[0] < 4e-2
    assert force[1] < force[0] / 2
    assert force[2] < force[1]


def test_a_warning_above_the_level():
    system = bowed_double_stage()
    with pytest.warns(
        gb.AccuracyWarning, match=r"^modes: 16 modes leave .* accuracy 'engineering'"
    ):
        system.simulate(0.01, SPEED, modes=16)
    with warnings.catch_warnings():
        warnings.filterwarnings("error", "^modes", gb.AccuracyWarning)
        warnings.filterwarnings("ignore", "^accuracy", gb.AccuracyWarning)
        system.simulate(0.01, SPEED, modes=60, accuracy="draft")


@pytest.mark.parametrize(
    ("given", "kind"),
    [((2e-3, 9e-3), "displacements"), ((9e-4, 2e-2), "mesh forces"), ((9e-4, 9e-3), None)],
)
@pytest.mark.parametrize(("by_user", "cure"), [(True, "keep more modes"), (False, "give rtol")])
def test_which_error_is_above_the_level(
    given: tuple[float, float], kind: str | None, by_user: bool, cure: str
):
    statistics = bowed_double_stage().simulate(0.0, SPEED).statistics
    statistics = replace(statistics, modes=9, modes_error=given)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        check_reduction(statistics, LEVELS["engineering"], given=by_user)
    texts = [str(each.message) for each in caught]
    assert [f"in {kind}, above" in text and cure in text for text in texts] == [True] * (
        kind is not None
    )


def test_small_systems_and_short_runs_keep_all_modes():
    system = bowed_double_stage()
    level = system.simulate(0.01, SPEED, accuracy="engineering")
    same = system.simulate(0.01, SPEED, rtol=1e-4)
    assert level.statistics.modes is None
    assert level.statistics.modes_error is None
    assert np.array_equal(level.final["state"], same.final["state"])


@pytest.mark.parametrize("options", [{"modes": 44}, {"accuracy": "draft"}])
@pytest.mark.parametrize("name", ["live", "separation", "modal damping"])
@pytest.mark.filterwarnings("ignore::gearbow.errors.AccuracyWarning")
def test_a_reduced_run_in_parts_is_the_whole(name: str, options: dict[str, Any]):
    system = bowed_double_stage(**CASES[name][0])
    # Below 0.3 s, a run at a level keeps all modes of a small system.
    duration = 0.02 if "modes" in options else 0.29
    times = np.linspace(0.0, duration, 41)
    parts = (times[:19], times[19:])
    whole = system.simulate(duration, SPEED, times=times, **options)
    first = system.simulate(0.45 * duration, SPEED, times=parts[0], **options)
    rest = duration - 0.45 * duration
    second = system.simulate(rest, SPEED, initial=first, times=parts[1], **options)
    assert np.array_equal(second.final["state"], whole.final["state"])


def test_a_chosen_reduction_in_parts_is_the_whole():
    system = bowed_double_stage(8)
    times = np.linspace(0.0, 0.62, 63)
    whole = system.simulate(0.62, SPEED, times=times, accuracy="draft")
    first = system.simulate(0.31, SPEED, times=times[:32], accuracy="draft")
    second = system.simulate(0.31, SPEED, initial=first, times=times[32:], accuracy="draft")
    assert whole.statistics.modes == second.statistics.modes == first.statistics.modes
    assert whole.statistics.modes < 100
    assert np.array_equal(second.final["state"], whole.final["state"])


@pytest.mark.filterwarnings("ignore::gearbow.errors.AccuracyWarning")
def test_continuing_with_another_number_of_modes():
    system = bowed_double_stage(engagement=0.4)
    first = system.simulate(0.01, SPEED, modes=48)
    whole = system.simulate(0.02, SPEED, times=first.time[-1] + np.linspace(0.0, 0.01, 101))
    for modes in (40, 56, None):
        second = system.simulate(0.01, SPEED, initial=first, modes=modes, times=whole.time)
        assert errors(second, whole)[0] < 1e-2


@pytest.mark.filterwarnings("ignore::gearbow.errors.AccuracyWarning")
def test_files_keep_the_number_of_modes(tmp_path):
    found = bowed_double_stage().simulate(0.005, SPEED, modes=40)
    found.save(tmp_path / "run.npz")
    assert gb.Response.load(tmp_path / "run.npz").statistics == found.statistics


def test_undamped_motion_does_not_grow():
    # Galerkin projection keeps the energy of an undamped system, however few the modes
    system = bowed_double_stage(**UNDAMPED, engagement=0.3)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", gb.AccuracyWarning)
        found = system.simulate(2.0, 0.0, modes=20, initial="rest", output_step=1e-3)
    size = np.abs(found.displacement("g1")).max(axis=1)
    assert size[1500:].max() < 2.0 * size[:500].max()


#: Profiles of a changing speed.
PROFILES = {
    "up": gb.SpeedProfile.ramp(0.0, 300.0, 0.1),
    "down": gb.SpeedProfile.ramp(300.0, 20.0, 0.1),
    "wavering": gb.SpeedProfile.function(lambda t: 100.0 * (1.0 + 0.02 * np.sin(100.0 * t)), 0.1),
}


@pytest.mark.parametrize("profile", PROFILES)
@pytest.mark.parametrize("initial", ["synchronous", "rest"])
@pytest.mark.parametrize("name", ["live", "modal damping", "anisotropic"])
@pytest.mark.filterwarnings("ignore::gearbow.errors.AccuracyWarning")
def test_the_estimate_at_a_changing_speed(name: str, initial: str, profile: str):
    system = bowed_double_stage(**CASES[name][0])
    run: dict[str, Any] = {"rtol": 1e-6, "initial": initial, "output_step": 1e-4}
    exact = system.simulate(0.1, PROFILES[profile], **run)
    found = system.simulate(0.1, PROFILES[profile], modes=44, **run)
    assert found.statistics.modes == 44
    ratio = np.array(found.statistics.modes_error) / errors(found, exact)
    # The mesh force is that of the part around the largest speed. At a run-down, the displacement varies little there:
    # the bow moves the gears less relative to it than at the lower speeds. Where bearings couple the planes, the estimate of
    # displacements is 0.30 of the error.
    assert 0.3 < ratio[1] < 3
    assert 1 / 4 < ratio[0] < 8


def test_a_run_up_against_rk45():
    system = bowed_double_stage(modal_damping=0.02)
    profile = gb.SpeedProfile.ramp(0.0, 300.0, 0.03)
    run: dict[str, Any] = {"initial": "rest", "output_step": 1e-4}
    exact = system.simulate(0.03, profile, method="rk45", rtol=1e-10, **run)
    found = system.simulate(0.03, profile, rtol=1e-6, modes=60, **run)
    assert (errors(found, exact) < (1e-4, 1e-3)).all()


@pytest.mark.parametrize("elements", [4, LARGE, 20])
def test_a_level_at_a_changing_speed(elements: int):
    system = bowed_double_stage(elements, engagement=0.4)
    profile = gb.SpeedProfile.ramp(50.0, 150.0, 0.31)
    run: dict[str, Any] = {"output_step": 1e-4}
    exact = system.simulate(0.31, profile, rtol=1e-6, **run)
    found = system.simulate(0.31, profile, accuracy="engineering", **run)
    modes = found.statistics.modes
    # With four elements, more than three quarters of the modes would be necessary.
    assert modes is None if elements == 4 else modes < 0.75 * len(system.dofs)
    assert (errors(found, exact) < (1e-3, 1e-2)).all()


@pytest.mark.parametrize("damping", [0.0, 0.02])
@pytest.mark.filterwarnings("ignore::gearbow.errors.AccuracyWarning")
def test_every_place_of_a_large_model_at_a_changing_speed(damping: float):
    # Bow and unbalance are loads on the reduced motion, and bend the shafts between the gears.
    system = bowed_double_stage(LARGE, engagement=0.4, modal_damping=damping)
    profile = gb.SpeedProfile.ramp(SPEED, SPEED * (1.0 + 1e-9), 0.02)
    run: dict[str, Any] = {"output_step": 1e-4, "record": ["nodes"]}
    exact = system.simulate(0.02, profile, rtol=1e-7, **run)
    found = system.simulate(0.02, profile, accuracy="engineering", **run)
    # Each recorded coordinate may need a static shape.
    assert found.statistics.modes < 0.75 * len(system.dofs)
    for place in exact.recorded:
        values = exact.displacement(place)
        mean = values.mean(axis=0)
        size = max(np.sqrt(np.mean((values - mean) ** 2)), 0.02 * np.abs(mean).max())
        difference = found.displacement(place) - values
        assert np.sqrt(np.mean(difference**2)) < 1e-3 * size, place


@pytest.mark.filterwarnings("ignore::gearbow.errors.AccuracyWarning")
def test_speed_dependent_bearings_in_a_reduced_run_up():
    stiffness = gb.SpeedTable([0.0, 300.0], [5e7, 1.5e8])
    system = bowed_double_stage(bearing={"stiffness": stiffness, "damping": 500.0}, engagement=0.4)
    profile = gb.SpeedProfile.ramp(50.0, 300.0, 0.03)
    run: dict[str, Any] = {"rtol": 1e-6, "output_step": 1e-4}
    exact = system.simulate(0.03, profile, **run)
    found = system.simulate(0.03, profile, modes=56, **run)
    true = errors(found, exact)
    assert (true < (1e-2, 1e-1)).all()
    ratio = np.array(found.statistics.modes_error) / true
    assert (ratio > 1 / 3).all()
    assert (ratio < 3).all()


def test_a_warning_at_a_changing_speed():
    with pytest.warns(gb.AccuracyWarning, match="^modes: 16 modes leave"):
        bowed_double_stage().simulate(0.01, PROFILES["up"], modes=16)


@pytest.mark.parametrize("options", [{"modes": 44}, {"accuracy": "draft"}])
@pytest.mark.filterwarnings("ignore::gearbow.errors.AccuracyWarning")
def test_a_reduced_run_up_in_parts_is_the_whole(options: dict[str, Any]):
    system, profile = bowed_double_stage(), gb.SpeedProfile.ramp(100.0, 300.0, 0.5)
    times = np.linspace(0.0, 0.62, 63)
    whole = system.simulate(0.62, profile, times=times, **options)
    first = system.simulate(0.31, profile, times=times[:32], **options)
    second = system.simulate(0.31, profile, initial=first, times=times[32:], **options)
    assert second.statistics.modes == whole.statistics.modes
    assert np.array_equal(second.final["state"], whole.final["state"])


def test_modal_damping_in_the_synchronous_motion_of_a_large_model():
    # The damping acts on the modes of the subspace; the motion starts without a transient.
    system = bowed_double_stage(LARGE, modal_damping=0.02, engagement=0.4)
    run: dict[str, Any] = {"rtol": 1e-8, "output_step": 1e-4}
    exact = system.simulate(0.01, SPEED, **run)
    found = system.simulate(0.01, SPEED, modes=200, **run)
    assert errors(found, exact)[0] < 1e-5


def test_a_long_run_with_separation_is_reduced():
    system = bowed_double_stage(8, **LOOSE)
    found = system.simulate(1.0, SPEED, accuracy="draft", output_step=1e-2)
    assert found.statistics.modes is not None
