"""The choice of elements considers loads over time: steps at any time, and tones of high frequency."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import gearbow as gb
from reference import machines
from reference.comparisons import error
from reference.machines import pair_with_motor

DURATION, SPEED = 0.1, 100.0
RUN: dict[str, Any] = {"initial": "static", "output_step": 2e-5}


def rotor(**changes: Any) -> gb.RotorSystem:
    disks = [gb.Disk("a", "s", 0.3, 3.0, 0.005, 0.01), gb.Disk("b", "s", 0.8, 2.0, 0.004, 0.008)]
    damped = {"stiffness": 5e7, "damping": 300.0}
    shaft = {"name": "s", "elements": None}
    return machines.rotor(shaft, bearing=damped, **{"disks": disks, **changes})


def displacement_errors(system: gb.RotorSystem) -> list[float]:
    """Return the errors of a run at "engineering" against a run with elements of "reference"."""
    record = [disk.name for disk in system.disks]
    run = system.simulate(DURATION, SPEED, record=record, **RUN)
    fine = system.replace(accuracy="reference")
    fine_run = fine.simulate(DURATION, SPEED, method="exponential", rtol=1e-9, record=record, **RUN)
    return [error(run.displacement(name), fine_run.displacement(name)) for name in record]


def tone(frequency: float) -> gb.TimeSeries:
    return gb.TimeSeries.function(lambda t: 100.0 * np.sin(2.0 * np.pi * frequency * t), DURATION)


@pytest.mark.parametrize(("frequency", "most"), [(1000.0, 1e-3), (3000.0, 3e-3)])
def test_engineering_resolves_a_tone(frequency: float, most: float):
    system = rotor(forces=[gb.Force("a", tone(frequency))])
    # Without the rule, the elements are those of a rotor without load, with an error of up to 0.05.
    assert len(system.dofs) > len(rotor().dofs)
    # The promise of "engineering" for displacements is 1e-3. Between two natural frequencies, at
    # 3000 Hz, the modes cancel each other at one disk, which the rule does not know.
    assert max(displacement_errors(system)) < most


def test_engineering_resolves_a_sudden_force_at_any_time():
    for begin in (0.0, 0.05):
        step = gb.TimeSeries([begin, begin + 1e-5], [0.0, 100.0])
        assert max(displacement_errors(rotor(forces=[gb.Force("a", step)]))) < 1e-3


def test_the_time_of_a_step_does_not_matter():
    early, late = (
        rotor(forces=[gb.Force("a", gb.TimeSeries([t, t + 1e-6], [0.0, 50.0]))]).discretisation
        for t in (0.0, 0.05)
    )
    assert early.shafts == late.shafts
    assert early.expected_error == pytest.approx(late.expected_error, rel=1e-2)


def test_a_slow_load_needs_no_finer_elements():
    slow = gb.TimeSeries([0.0, 5.0, 10.0], [0.0, 1000.0, 0.0])
    system = rotor(forces=[gb.Force("a", slow)])
    assert len(system.dofs) == len(rotor().dofs)


@pytest.mark.parametrize("kind", ["step", "tone"])
def test_engineering_resolves_a_torque_in_a_train(kind: str):
    load = gb.TimeSeries([0.05, 0.05001], [0.0, 80.0]) if kind == "step" else tone(2000.0)
    system = pair_with_motor(torques=[*pair_with_motor().torques, gb.Torque("motor", load)])
    fine = system.replace(shafts=[replace(each, elements=4, degree=6) for each in system.shafts])
    record = ["gears", "meshes"]
    run = system.simulate(DURATION, SPEED, record=record, **RUN)
    exact = fine.simulate(DURATION, SPEED, record=record, rtol=1e-7, **RUN)
    # the promise of "engineering" for mesh forces and displacements
    force, wanted = (each.mesh(("g1", "g2")).force[:, None] for each in (run, exact))
    assert error(force, wanted) < 1e-2
    for name in ("g1", "g2"):
        assert error(run.displacement(name), exact.displacement(name)) < 1e-3


def test_torsion_follows_the_tone_of_a_torque():
    def pendulum(**changes: Any) -> gb.RotorSystem:
        parts: dict[str, Any] = {
            "shafts": [gb.Shaft("shaft", length=0.8, outer_diameter=0.05)],
            "disks": [gb.Disk("wheel", "shaft", 0.8, 10.0, 0.05, 0.1)],
            "drives": [gb.Drive(("shaft", 0.0), stiffness=1e6)],
            "motion": "torsion",
        }
        return gb.RotorSystem(**{**parts, **changes})

    torques = [gb.Torque(("shaft", 0.4), tone(6000.0))]
    run, fine = (
        pendulum(torques=torques, accuracy=level).simulate(
            0.05, SPEED, rtol=1e-9, record=["wheel"], **RUN
        )
        for level in ("engineering", "reference")
    )
    # The level promises the motion of gears and disks.
    assert error(run.twist("wheel")[:, None], fine.twist("wheel")[:, None]) < 1e-3


def test_a_function_counts_as_its_samples():
    def function(t: Any) -> Any:
        return 100.0 * np.sin(2.0 * np.pi * 4000.0 * t)

    system = rotor(forces=[gb.Force("a", function)])
    assert len(system.dofs) == len(rotor(forces=[gb.Force("a", tone(4000.0))]).dofs)
    run = system.simulate(0.01, SPEED, record=["a"])
    # A run has the elements of its system, so that another run can continue it.
    later = system.simulate(0.01, SPEED, initial=run, record=["a"])
    assert later.time[0] == run.time[-1]
    np.testing.assert_array_equal(later.displacement("a")[0], run.displacement("a")[-1])


def test_a_function_that_has_no_numbers_is_an_error_of_the_run():
    system = rotor(forces=[gb.Force("a", lambda t: np.nan * np.asarray(t))])
    with pytest.raises(gb.SceneError, match=r"forces\[0\].value: the function"):
        system.simulate(0.05, SPEED, record=["a"])
