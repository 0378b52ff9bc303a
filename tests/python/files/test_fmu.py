"""Functional mock-up units in FMPy: the same motion as in gearbow, states, errors and files."""

from __future__ import annotations

import re
import shutil
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest

import gearbow as gb
from reference.machines import pair

fmpy = pytest.importorskip("fmpy", reason="FMPy is not installed (dependency group fmi)")
pytest.importorskip("pythonfmu3", reason="pythonfmu3 is not installed (extra fmi)")

STEP, COUNT = 5e-4, 20
OPTIONS = {
    "torque_inputs": ["g1"],
    "speed_input": (50.0, 200.0),
    "record": ["g1", ("g1", "g2"), ("bearing", "input", 0.0)],
    "sensors": [gb.Probe("input", 0.25, angle=0.0)],
}
OUTPUTS = ["g1_y", "g1_g2_force", "input_0_force_y", "probe_input_at_0_25_m_0"]


def driven() -> gb.RotorSystem:
    return pair(
        shaft={"bow": gb.Bow.half_sine(1e-4)},
        torque=0.0,
        torques=[gb.Torque("g1", 250.0), gb.Torque("g2", 500.0)],
        drives=[gb.Drive("g1", 2e4, 20.0)],
        accuracy="draft",
    )


@pytest.fixture(scope="module")
def unit(tmp_path_factory):
    path = tmp_path_factory.mktemp("unit") / "my train.fmu"
    driven().to_fmu(path, 100.0, **OPTIONS)
    return path


def inputs() -> np.ndarray:
    times = STEP * np.arange(COUNT + 1)
    made = np.zeros(COUNT + 1, dtype=[(n, float) for n in ("time", "torque_g1", "speed")])
    made["time"], made["torque_g1"] = times, 40.0 * np.sin(300.0 * times)
    made["speed"] = 100.0 + 2000.0 * times
    return made


def instance(unit: Path, folder: Path, messages: list[str]):
    from fmpy.fmi3 import FMU3Slave

    description = fmpy.read_model_description(unit)
    slave = FMU3Slave(
        guid=description.guid,
        unzipDirectory=fmpy.extract(unit, folder),
        modelIdentifier=description.coSimulation.modelIdentifier,
        instanceName="train",
    )
    log = lambda environment, status, category, message: messages.append(message.decode())  # noqa: ARG005, E731
    slave.instantiate(logMessage=log, loggingOn=True)
    slave.enterInitializationMode(startTime=0.0)
    slave.exitInitializationMode()
    references = {each.name: each.valueReference for each in description.modelVariables}
    return slave, references


def test_the_unit_is_valid_and_packs_no_more_than_it_needs(unit):
    from fmpy.validation import validate_fmu

    assert validate_fmu(unit) == []
    description = fmpy.read_model_description(unit)
    kind = description.coSimulation
    assert (description.fmiVersion, description.modelName) == ("3.0", "my_train")
    assert (kind.canGetAndSetFMUstate, kind.canSerializeFMUstate) == (True, True)
    variables = {each.name: each for each in description.modelVariables}
    assert [n for n, v in variables.items() if v.causality == "input"] == ["torque_g1", "speed"]
    assert variables["g1_g2_force"].unit == "N"
    assert float(variables["speed"].start) == 100.0
    assert set(OUTPUTS) <= variables.keys()
    names = zipfile.ZipFile(unit).namelist()
    assert "resources/train.pickle" in names


def test_the_unit_moves_as_the_system(unit):
    given = inputs()
    found = fmpy.simulate_fmu(
        str(unit), stop_time=COUNT * STEP, step_size=STEP, output_interval=STEP, input=given,
        output=OUTPUTS,
    )  # fmt: skip
    # An input of the time t is set before the step that begins at t, and reached at its end.
    times = given["time"]
    torques = np.concatenate([[0.0], given["torque_g1"][:-1]])
    speeds = np.concatenate([[100.0], given["speed"][:-1]])
    series = gb.TimeSeries(times, torques, np.zeros_like(times))
    system = driven()
    system = system.replace(torques=[*system.torques, gb.Torque("g1", series)])
    run = system.simulate(
        times[-1], (times, speeds), times=times, record=[*OPTIONS["record"], ("input", 0.25)]
    )
    expected = {
        "g1_y": run.displacement("g1")[:, 0],
        "g1_g2_force": run.mesh(("g1", "g2")).force,
        "input_0_force_y": run.bearing_force(("input", 0.0))[:, 0],
        OUTPUTS[-1]: OPTIONS["sensors"][0].measure(run),
    }
    np.testing.assert_allclose(found["time"], times, atol=1e-12)
    for name, values in expected.items():
        size = np.ptp(values)
        np.testing.assert_allclose(found[name], values, rtol=0.0, atol=2e-3 * size, err_msg=name)


def test_a_restored_state_repeats_the_steps_to_the_last_bit(unit, tmp_path):
    slave, references = instance(unit, tmp_path / "unit", messages := [])
    given, own = inputs(), [references[name] for name in OUTPUTS]

    def steps(numbers: range) -> list[list[float]]:
        found = []
        for i in numbers:
            row = given[i]
            slave.setFloat64([references["torque_g1"], references["speed"]], list(row)[1:])
            slave.doStep(currentCommunicationPoint=row["time"], communicationStepSize=STEP)
            found.append(slave.getFloat64(own))
        return found

    steps(range(5))
    state = slave.getFMUState()
    packed = slave.serializeFMUState(state)
    first = steps(range(5, 10))
    assert all(np.isfinite(first).ravel())
    slave.setFMUState(state)
    assert slave.getFloat64([references["time"]]) == [pytest.approx(5 * STEP)]
    assert steps(range(5, 10)) == first
    slave.freeFMUState(state)
    slave.setFMUState(slave.deserializeFMUState(packed))
    assert steps(range(5, 10)) == first
    assert messages == []
    slave.terminate()
    slave.freeInstance()


@pytest.mark.parametrize(
    ("time", "speed", "message"),
    [
        (-STEP, 100.0, "cannot step from"),
        (STEP, 100.0, "cannot step from"),
        (0.0, 300.0, "within speed_input, 50 to 200 rad/s, got 300"),
    ],
)
def test_a_refused_step_says_why_and_the_unit_goes_on(unit, tmp_path, time, speed, message):
    from fmpy.fmi1 import FMICallException

    slave, references = instance(unit, tmp_path / "unit", messages := [])
    slave.setFloat64([references["speed"]], [speed])
    with pytest.raises(FMICallException):
        slave.doStep(currentCommunicationPoint=time, communicationStepSize=STEP)
    assert any(re.search(message, each) for each in messages), messages
    slave.setFloat64([references["speed"]], [100.0])
    slave.doStep(currentCommunicationPoint=0.0, communicationStepSize=STEP)
    slave.terminate()
    slave.freeInstance()


def test_a_process_runs_several_units(unit, tmp_path):
    other = tmp_path / "other.fmu"
    driven().to_fmu(other, 50.0, record=["g2"])
    for path, output in ((unit, "g1_y"), (other, "g2_y")):
        found = fmpy.simulate_fmu(str(path), stop_time=STEP, step_size=STEP, output=[output])
        assert np.isfinite(found[output]).all()


def test_a_unit_of_another_version_is_refused(unit, monkeypatch):
    from gearbow.exchange import fmu

    folder = Path(fmpy.extract(unit))
    given = {"resources": str(folder / "resources"), "instance_name": "train"}
    monkeypatch.setattr(fmu, "__version__", "0.0.0")
    from pythonfmu3 import Fmi3Slave

    made = type("Made", (fmu.Train, Fmi3Slave), {})
    with pytest.raises(gb.SceneError, match=r"and gearbow 0\.0\.0 is installed"):
        made(**given)
    shutil.rmtree(folder)


def test_wrong_files_and_arguments_leave_no_file(tmp_path, monkeypatch):
    system = driven()
    for path, options, message in (
        (tmp_path / "train.zip", {}, r"path: must end with \.fmu"),
        (tmp_path / "a.fmu", {"torque_inputs": ["g7"]}, "g7"),
        (tmp_path / "a.fmu", {"record": ["g7"]}, "g7"),
        (tmp_path / "a.fmu", {"sensors": [gb.Probe("output", 0.1)]}, "was not recorded"),
        (tmp_path / "a.fmu", {"initial": "moving"}, "initial"),
        (tmp_path / "a.fmu", {"accuracy": "best"}, "accuracy"),
    ):
        with pytest.raises(gb.GearbowError, match=message):
            system.to_fmu(path, 100.0, **options)
    with pytest.raises(FileNotFoundError, match="no folder"):
        system.to_fmu(tmp_path / "none" / "a.fmu", 100.0)
    monkeypatch.setitem(sys.modules, "pythonfmu3", None)
    with pytest.raises(gb.MissingExtraError, match=r'pip install "gearbow\[fmi\]"'):
        system.to_fmu(tmp_path / "a.fmu", 100.0)
    assert list(tmp_path.iterdir()) == []
