"""Steps whose inputs another program gives: equal to one run with the same inputs, and repeatable to the last bit."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from itertools import pairwise

import numpy as np
import pytest

import gearbow as gb
from gearbow.exchange.fmu import Train, names_of
from gearbow.system.cosimulation import CoSimulation, Instant, Interface, Knots
from reference.machines import pair

RECORD = ["g1", ("g1", "g2")]
STEP, COUNT = 2e-4, 60
SPEEDS = (50.0, 200.0)


@cache
def driven(sign: float = 1.0) -> gb.RotorSystem:
    """Give a bent pair whose drive holds the rotation."""
    made = pair(
        shaft={"bow": gb.Bow.half_sine(1e-4)},
        torque=0.0,
        torques=[gb.Torque("g1", sign * 250.0), gb.Torque("g2", sign * 500.0)],
        drives=[gb.Drive("g1", 2e4, 20.0)],
        accuracy="draft",
    )
    stiffness = gb.Stiffness.parabolic(2e8, engagement=0.2)
    return made.replace(meshes=[replace(mesh, stiffness=stiffness) for mesh in made.meshes])


def torque(time: float) -> float:
    return 40.0 * np.sin(300.0 * time)


def speed(time: float) -> float:
    return 100.0 + 2000.0 * time


def interface(*, torques: bool = True, speeds: bool = True, sign: float = 1.0, **more) -> Interface:
    limits = tuple(sorted((sign * SPEEDS[0], sign * SPEEDS[1]))) if speeds else None
    return Interface.of(sign * 100.0, ["g1"] if torques else [], limits, RECORD, [], **more)


def stepped(
    face: Interface, count: int = COUNT, begin: float = 0.0, sign: float = 1.0
) -> tuple[CoSimulation, list[Instant]]:
    made = CoSimulation(driven(sign), face)
    made.begin(begin)
    instants = [made.now]
    for number in range(1, count + 1):
        given = {"torque g1": torque(number * STEP), "speed": sign * speed(number * STEP)}
        made.set({name: given[name] for name in face.inputs})
        made.step(STEP)
        instants.append(made.now)
    return made, instants


def whole_run(face: Interface, sign: float = 1.0, begin: float = 0.0) -> gb.Response:
    times = STEP * np.arange(COUNT + 1)
    system, profile = driven(sign), sign * 100.0
    if face.torque_inputs:
        series = gb.TimeSeries(begin + times, [torque(t) for t in times], np.zeros(COUNT + 1))
        system = system.replace(torques=[*system.torques, gb.Torque("g1", series)])
    if face.speed_input is not None:
        profile = gb.SpeedProfile.table(begin + times, [sign * speed(t) for t in times])
    return system.simulate(COUNT * STEP, profile, start=begin, times=begin + times, record=RECORD)


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize(("torques", "speeds"), [(True, False), (False, True), (True, True)])
def test_steps_are_one_run_with_the_same_inputs(torques, speeds, sign):
    face = interface(torques=torques, speeds=speeds, sign=sign)
    made, instants = stepped(face, sign=sign)
    run = whole_run(face, sign)
    names = [column.name for column in made.columns]
    assert instants[-1].time == pytest.approx(run.time[-1], rel=1e-12)
    for name, expected in (
        ("g1 y", run.displacement("g1")[:, 0]),
        ("g1 twist", run.twist("g1")),
        ("g1/g2 force", run.mesh(("g1", "g2")).force),
    ):
        found = np.array([instant.outputs[names.index(name)] for instant in instants])
        # A speed profile has other speeds than the one that passes through both limits.
        error = 1e-3 if speeds else 1e-11
        size = np.ptp(expected)
        np.testing.assert_allclose(found, expected, rtol=0.0, atol=error * size, err_msg=name)


def test_inputs_change_the_motion():
    ends = []
    for face in (interface(torques=False, speeds=False), interface()):
        _, instants = stepped(face, count=30)
        ends.append(instants[-1].outputs)
    assert not np.allclose(*ends, rtol=1e-3)


@pytest.mark.parametrize("serialised", [False, True])
def test_a_restored_instant_repeats_the_steps_to_the_last_bit(serialised):
    made, instants = stepped(interface(), count=20)
    state = {"start": 0.0, "inputs": instants[10].inputs, "now": instants[10]}
    if serialised:
        state = Train._fmu_state_from_bytes(Train._fmu_state_to_bytes(state))
        made = CoSimulation(driven(), made.interface)
    made.now = state["now"]
    for number in range(11, 21):
        made.set({"torque g1": torque(number * STEP), "speed": speed(number * STEP)})
        made.step(STEP)
        assert made.now.outputs == instants[number].outputs
        assert np.array_equal(made.now.final["state"], instants[number].final["state"])


def test_a_long_profile_begins_again_without_a_jump(monkeypatch):
    face = interface(torques=False)
    _, expected = stepped(face, count=40, begin=3.0)
    monkeypatch.setattr("gearbow.system.cosimulation._LONGEST_PROFILE", 7)
    made, found = stepped(face, count=40, begin=3.0)
    assert len(made.now.speed_knots.times) <= 7
    forces = [np.array([each.outputs for each in steps])[:, :3] for steps in (expected, found)]
    np.testing.assert_allclose(*forces, rtol=0.0, atol=2e-3 * np.ptp(forces[0], axis=0).max())


def test_knots_keep_what_the_run_still_needs():
    knots = Knots([0.0, 1.0, 2.0, 3.0], [[0.0], [1.0], [2.0], [3.0]], [0.0, 1.0, 2.0, 3.0])
    assert knots.since(1.5).times == [1.0, 2.0, 3.0]
    assert knots.since(-1.0) == knots
    assert knots.since(9.0).times == [2.0, 3.0], "two knots make a series"
    _, instants = stepped(interface(speeds=False), count=40)
    assert len(instants[-1].torque_knots.times) < 10
    assert all(a.time < b.time for a, b in pairwise(instants))


def test_sensors_and_default_outputs():
    probe = gb.Probe("input", 0.1, angle=0.3)
    face = Interface.of(100.0, [], None, ["g1", ("input", 0.1)], [probe])
    made = CoSimulation(driven(), face)
    made.begin(0.0)
    assert made.columns[-1].name == probe.label
    run = driven().simulate(0.0, 100.0, times=[0.0], record=face.record)
    assert made.now.outputs[-1] == probe.measure(run._to_record())[0]
    default = CoSimulation(driven(), Interface.of(100.0, [], None, None, []))
    default.begin(0.0)
    assert "g1/g2 force" in [column.name for column in default.columns]


def test_a_failed_step_leaves_the_instant():
    made, _ = stepped(interface(), count=2)
    before = made.now
    for call, message in (
        (lambda: made.step(0.0), "step: must be positive"),
        (lambda: made.step(-STEP), "step: must be positive"),
        (lambda: made.step(float("nan")), "step: must be finite"),
        (lambda: made.set({"torque g2": 1.0}), r"no 'torque g2'; did you mean .torque g1"),
        (lambda: made.set({"speed": 201.0}), "within speed_input, 50 to 200 rad/s, got 201"),
        (lambda: made.set({"torque g1": float("inf")}), "torque g1"),
    ):
        with pytest.raises(gb.SceneError, match=message):
            call()
        assert made.now is before
    with pytest.raises(gb.SceneError, match="begin: must be called"):
        CoSimulation(driven(), interface()).step(STEP)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((100.0, ["g1", "g1"], None, None, []), r"torque_inputs\[1\]: 'g1' is given twice"),
        ((100.0, "g1", None, None, []), "torque_inputs: must be a list"),
        ((100.0, [], (200.0, 50.0), None, []), "speed_input: must be two ascending"),
        ((100.0, [], (-50.0, 200.0), None, []), "speed_input: must be two ascending"),
        ((100.0, [], (50.0,), None, []), "speed_input: must be the smallest"),
        ((10.0, [], (50.0, 200.0), None, []), "speed: must be within speed_input"),
        ((float("nan"), [], None, None, []), "speed: must be finite"),
        ((100.0, [], None, None, [gb.Tacho("input")]), r"sensors\[0\]: must be a Probe"),
    ],
)
def test_wrong_arguments_are_refused(arguments, message):
    with pytest.raises(gb.SceneError, match=message):
        Interface.of(*arguments)


def test_names_are_those_of_fmi_and_differ():
    labels = ["g1/g2 force", "g1 g2 force", "3rd y", "é", "input@0.5 force_y"]
    found = names_of(labels)
    assert found == ["g1_g2_force", "g1_g2_force_2", "_3rd_y", "signal", "input_0_5_force_y"]
