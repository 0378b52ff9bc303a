"""A system that differs from another one in loads only shares its modes, without any effect on results."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import gearbow as gb

SHAFTS = [
    gb.Shaft(name, length=0.5, outer_diameter=0.05, elements=4, bow=gb.Bow.half_sine(1e-4))
    for name in ("input", "output")
]
GEARS = [
    gb.Gear("g1", "input", position=0.25, teeth=25, module=3e-3, face_width=0.03),
    gb.Gear("g2", "output", position=0.25, teeth=50, module=3e-3, face_width=0.03),
]
BEARINGS = [
    gb.Bearing(shaft, position=x, stiffness=1e8, damping=500.0)
    for shaft in ("input", "output")
    for x in (0.0, 0.5)
]
SYSTEM = gb.RotorSystem(
    SHAFTS,
    GEARS,
    [gb.Mesh("g1", "g2", stiffness=2e8, damping_ratio=0.05)],
    BEARINGS,
    [gb.Torque("g1", 250.0), gb.Torque.balance("g2")],
)

CHANGES: dict[str, dict[str, Any]] = {
    "torque": {"torques": [gb.Torque("g1", -100.0), gb.Torque.balance("g2")]},
    "torque elsewhere": {"torques": [gb.Torque(("input", 0.3), 100.0), gb.Torque.balance("g2")]},
    "bow": {"shafts": [replace(shaft, bow=gb.Bow.half_sine(2e-4, phase=1.0)) for shaft in SHAFTS]},
    "no bow": {"shafts": [replace(shaft, bow=None) for shaft in SHAFTS]},
    "unbalance": {"gears": [replace(gear, unbalance=1e-3j) for gear in GEARS]},
    "gravity": {"gravity": 9.81},
    # these change the linear part
    "stiffness": {"meshes": [gb.Mesh("g1", "g2", stiffness=1e8, damping_ratio=0.05)]},
    "damping": {"modal_damping": 0.01},
    "bearing": {"bearings": [replace(bearing, stiffness=2e8) for bearing in BEARINGS]},
    "reference": {"reference": "output"},
}


def results(system: gb.RotorSystem) -> list[np.ndarray]:
    # at speed zero the torque decides on the loaded flanks
    found = [np.array(system.modes(speed).eigenvalues) for speed in (0.0, 120.0, -120.0)]
    for speed in (0.0, 120.0):
        run = system.simulate(2e-3, speed, rtol=1e-6, output_step=1e-4)
        found += [run.displacement("g1"), run.mesh(("g1", "g2")).force]
    return found


def assert_independent(system: gb.RotorSystem, change: dict[str, Any]) -> None:
    """Check that a replaced system gives what one that shares nothing gives."""
    results(system)  # fills what the systems share
    replaced = system.replace(**change)
    fresh = gb.RotorSystem.from_dict(replaced.description)
    for one, other in zip(results(replaced), results(fresh), strict=True):
        np.testing.assert_array_equal(one, other)


@pytest.mark.parametrize("name", CHANGES)
def test_results_do_not_depend_on_the_system_that_was_replaced(name: str):
    assert_independent(SYSTEM, CHANGES[name])


@pytest.mark.parametrize("name", CHANGES)
def test_the_chosen_elements_do_not_depend_on_the_system_that_was_replaced(name: str):
    automatic = [replace(shaft, elements=None) for shaft in SHAFTS]
    change = dict(CHANGES[name])
    if "shafts" in change:
        change["shafts"] = [replace(shaft, elements=None) for shaft in change["shafts"]]
    replaced = SYSTEM.replace(shafts=automatic).replace(**change)
    fresh = gb.RotorSystem.from_dict(replaced.description)
    assert replaced.discretisation == fresh.discretisation


def test_systems_that_differ_in_loads_share_modes_however_the_accuracy_is_given():
    shares = {
        name: SYSTEM.replace(**change)._model.share(SYSTEM._model)
        for name, change in CHANGES.items()
    }
    # the reversed torque presses the opposite flanks at rest; a torque elsewhere adds a node
    loads = ("bow", "no bow", "unbalance", "gravity")
    assert [name for name in CHANGES if shares[name]] == list(loads)
    assert SYSTEM.replace(torques=[gb.Torque("g1", 1.0)])._model.share(SYSTEM._model)
    # a file gives the option, which the default system leaves out
    shafts = [replace(shaft, elements=None) for shaft in SHAFTS]
    automatic = SYSTEM.replace(shafts=shafts)
    given = gb.RotorSystem.from_dict({**automatic.description, "accuracy": "engineering"})
    assert "accuracy" in given.description
    assert given.replace(gravity=9.81)._model.share(given._model)


def test_results_of_a_table_over_the_speed_do_not_depend_on_the_system_that_was_replaced():
    table = gb.SpeedTable([0.0, 500.0], [1e8, 2e8])
    bearings = [replace(bearing, stiffness=table) for bearing in BEARINGS]
    assert_independent(SYSTEM.replace(bearings=bearings), CHANGES["torque"])


ATTACHED = SYSTEM.replace(
    bearings=[replace(bearing, support="box") for bearing in BEARINGS],
    housings=[
        gb.Housing(
            "box",
            mass=30.0,
            stiffness=5e7,
            inertia=(0.5, 0.9, 0.9),
            position=(0.25, 0.0, 0.1),
            rotational_stiffness=(1e6, 5e6, 5e6),
        )
    ],
    drives=[gb.Drive(("input", 0.0), stiffness=1e5, damping=5.0)],
    torques=[gb.Torque("g2", gb.SpeedTable([0.0, 150.0, 300.0], [-300.0, -200.0, -150.0]))],
    forces=[gb.Force("g1", 100.0, order=1.0)],
)
SERIES = gb.TimeSeries([0.0, 1e-3, 2e-3], [0.0, -200.0, -100.0])
ATTACHED_CHANGES: dict[str, dict[str, Any]] = {
    "force": {"forces": [gb.Force(("input", 0.3), -50j)]},
    "turning force": {"forces": [gb.Force("g1", 300.0, order=0.5)]},
    "no force": {"forces": []},
    "further torque over time": {"torques": [*ATTACHED.torques, gb.Torque("g1", SERIES)]},
    # these change the linear part: the slope of a torque over the speed is a damping
    "torque over the speed": {
        "torques": [gb.Torque("g2", gb.SpeedTable([0.0, 300.0], [-900.0, -100.0]))]
    },
    "constant torque": {"torques": [gb.Torque("g2", -200.0)]},
    "torque over time": {"torques": [gb.Torque("g2", SERIES)]},
    "drive": {"drives": [gb.Drive(("input", 0.0), stiffness=1e5, damping=50.0)]},
    "housing": {"housings": [replace(ATTACHED.housings[0], mass=10.0)]},
}


@pytest.mark.parametrize("name", ATTACHED_CHANGES)
def test_results_with_housings_drives_and_loads_do_not_depend_on_the_replaced_system(name: str):
    assert_independent(ATTACHED, ATTACHED_CHANGES[name])


@pytest.mark.parametrize(
    "options",
    [
        {},
        {"rtol": 1e-4, "geometry": "frozen"},
        {"modes": 12},
        {"method": "etdrk4"},
        {"initial": "rest", "record": ["nodes", "meshes", "energy"], "rtol": 1e-5},
        {"speed": gb.SpeedProfile.ramp(100.0, 150.0, 5e-3), "rtol": 1e-4},
    ],
    ids=str,
)
@pytest.mark.filterwarnings("ignore:modes. 12 modes leave:gearbow.AccuracyWarning")
def test_a_repeated_run_gives_the_same_to_the_last_bit(options: dict[str, Any]):
    options = {"speed": 120.0, "output_step": 3e-5, **options}
    system = gb.RotorSystem.from_dict(SYSTEM.description)
    first = system.simulate(5e-3, **options)
    system.simulate(5e-3, **{**options, "speed": 110.0})
    again = system.simulate(5e-3, **options)
    assert np.array_equal(again.displacement("g1"), first.displacement("g1"))
    assert np.array_equal(again.mesh(("g1", "g2")).force, first.mesh(("g1", "g2")).force)
    assert again.statistics.modes_error == first.statistics.modes_error


@pytest.mark.filterwarnings("ignore:modes. 12 modes leave:gearbow.AccuracyWarning")
def test_a_run_after_one_that_was_reduced_for_other_signals_has_its_own_reduction():
    system = gb.RotorSystem.from_dict(SYSTEM.description)
    for record in (["g1"], ["g2"], ["g1"]):
        found = system.simulate(5e-3, 120.0, modes=12, record=record)
        fresh = gb.RotorSystem.from_dict(SYSTEM.description)
        wanted = fresh.simulate(5e-3, 120.0, modes=12, record=record)
        assert np.array_equal(found.displacement(record[0]), wanted.displacement(record[0]))
        assert found.statistics.modes_error == wanted.statistics.modes_error
