"""The check of an initial state against its equations, before errors are estimated."""

import numpy as np
import pytest

import gearbow as gb
from gearbow import accuracy
from gearbow._core import Model, user_order
from reference import machines


def pair() -> gb.RotorSystem:
    """Return a pair of bowed shafts under gravity."""
    bent = {"length": 0.4, "outer_diameter": 0.04, "bow": gb.Bow.half_sine(1e-4)}
    return machines.pair(("a", "b"), ("p", "w"), (20, 40), shaft=bent, torque=50.0, gravity=9.81)


class Changed:
    """A model with one method that returns a changed result."""

    def __init__(self, model, name, change):
        self._model, self._name, self._change = model, name, change

    def __getattr__(self, name):
        found = getattr(self._model, name)
        if name != self._name:
            return found
        return lambda *args, **options: self._change(found(*args, **options))


@pytest.mark.parametrize("start", ["synchronous", "static", "rest"])
@pytest.mark.parametrize("speed", [90.0, -90.0, "ramp"])
@pytest.mark.parametrize("geometry", ["live", "frozen"])
def test_initial_states_satisfy_their_equations(start, speed, geometry):
    given = gb.SpeedProfile.ramp(60.0, 90.0, duration=1.0) if speed == "ramp" else speed
    run = pair().simulate(1e-3, given, initial=start, geometry=geometry, start=0.3)
    accuracy.check_initial_state(Model(dict(run.request.description)), run.request.options)


def displaced(data):
    """Move one coordinate of an equilibrium by a thousandth."""
    state = data["state"].copy()
    state[np.argmax(np.abs(state))] *= 1.001
    return {**data, "state": state}


@pytest.mark.parametrize(
    ("start", "method", "change", "message"),
    [
        ("static", "static", displaced, "is not the motion 'static'"),
        ("synchronous", "static", displaced, "is not the motion 'synchronous'"),
        (
            "synchronous",
            "synchronous",
            lambda data: {**data, "phasors": 1.001 * data["phasors"]},
            "is not the motion 'synchronous'",
        ),
        (
            "static",
            "static",
            lambda data: {**data, "residuals": [("s0", 2e-6)]},
            "forces .* do not balance",
        ),
        (
            "static",
            "static",
            lambda data: {**data, "residuals": [("s0", np.nan)]},
            "forces .* do not balance",
        ),
        (
            "synchronous",
            "synchronous",
            lambda data: {**data, "residuals": np.array([2e-6])},
            "does not satisfy the equations of motion",
        ),
    ],
)
def test_a_wrong_initial_state_stops_the_estimate(monkeypatch, start, method, change, message):
    run = pair().simulate(1e-3, 90.0, initial=start)
    monkeypatch.setattr(accuracy, "Model", lambda given: Changed(Model(given), method, change))
    monkeypatch.setattr(
        accuracy, "user_order", lambda model, state: user_order(model._model, state)
    )
    with pytest.raises(gb.ConvergenceError, match=message):
        run.errors()


def test_a_state_that_continues_a_run_needs_no_equation():
    system = pair()
    first = system.simulate(1e-3, 90.0)
    assert system.simulate(1e-3, 90.0, initial=first).errors()["mesh_force"].total < 0.5


def test_the_static_state_of_a_run_up_does_not_depend_on_earlier_runs():
    # the static state has the torque at the highest speed of the run, which differs between the runs
    def machine() -> gb.RotorSystem:
        over_speed = gb.SpeedTable([0.0, 300.0], [150.0, 20.0])
        torques = [gb.Torque(("input", 0.07), over_speed), gb.Torque(("output", 0.17), -60.0)]
        drive = gb.Drive(("output", 0.17), stiffness=1e5, damping=10.0)
        return machines.hostile(torques=torques, drives=[drive])

    def start(system: gb.RotorSystem, fastest: float) -> np.ndarray:
        speed = gb.SpeedProfile.ramp(100.0, fastest, 1e-3)
        run = system.simulate(1e-3, speed, initial="static", output_step=1e-3, record=["gears"])
        return run.displacement("g4")[0]

    one = machine()
    earlier, later = start(one, 120.0), start(one, 280.0)
    assert np.array_equal(later, start(machine(), 280.0))
    assert np.abs(later - earlier).max() > 1e-6
