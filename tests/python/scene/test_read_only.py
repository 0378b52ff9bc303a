"""Result arrays are read-only: users cannot alter a response before it is continued or saved."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import gearbow as gb
from gearbow import _shown
from gearbow._shown import ReadOnly
from reference.machines import bowed_rotor, hostile
from test_response import recorded


def writable(value: object) -> list[np.ndarray]:
    """Return all writable arrays in attributes, mappings and sequences."""
    if isinstance(value, np.ndarray):
        return [value] if value.flags.writeable else []
    if isinstance(value, dict):
        return [array for item in value.values() for array in writable(item)]
    if isinstance(value, list | tuple):
        return [array for item in value for array in writable(item)]
    if dataclasses.is_dataclass(value) or isinstance(value, gb.Response | gb.results.Static):
        return writable(vars(value))
    return []


def results():
    system = hostile()
    speeds = np.linspace(50.0, 100.0, 3)
    bowed = bowed_rotor(disks=[gb.Disk("disk", "rotor", 0.5, 10.0, 0.1, 0.2)])
    response = recorded()
    return {
        "matrices": system.matrices(),
        "modes": system.modes(10.0),
        "campbell": system.campbell(speeds, count=3),
        "synchronous": system.synchronous(speeds),
        "frequency response": system.frequency_response([10.0], source=gb.Force("g1", 1.0)),
        "sensitivity": system.sensitivity("bearings[0].stiffness", system.modes(10.0, count=3)),
        "less": system.synchronous(speeds).subtract_slow_roll(1.0),
        "static": system.static(),
        "critical": bowed.critical_speed_map(speeds * 1e6),
        "balance": bowed.balance(["disk"], 50.0),
        "response": response,
        "unsorted": system.simulate(1e-3, 10.0, times=[1e-3, 0.0]),
        "mesh": response.mesh(("g1", "g2")),
        "energy": response.energy_balance(),
        "spectrum": response.spectrum("g1"),
    }


@pytest.fixture(scope="module")
def made():
    return results()


@pytest.mark.parametrize(
    "name",
    [
        *(
            "matrices",
            "modes",
            "campbell",
            "synchronous",
            "less",
            "static",
            "critical",
            "balance",
            "sensitivity",
        ),
        *("response", "unsorted", "mesh", "energy", "spectrum"),
    ],
)
def test_all_arrays_of_a_result_are_read_only(made, name):
    assert writable(made[name]) == []


def test_views_of_a_response_are_read_only(made):
    response = made["response"]
    for view in (response.time, response.displacement("g1"), response.twist("g1"), response.energy):
        with pytest.raises(ValueError, match="read-only"):
            view[0] = 0.0
    with pytest.raises(ValueError, match="read-only"):
        response.final["state"][0] = 0.0
    before = response.final["time"]
    response.final["time"] = 12.0
    assert response.final["time"] == before


def test_a_response_from_a_file_is_read_only_too(made, tmp_path):
    made["response"].save(tmp_path / "run.npz")
    assert writable(gb.Response.load(tmp_path / "run.npz")) == []


def test_arrays_of_the_caller_stay_writable():
    speeds = np.linspace(50.0, 100.0, 3)
    system = hostile()
    diagram, response = system.campbell(speeds, count=2), system.synchronous(speeds)
    speeds[0] = 1.0
    assert diagram.speeds[0] == response.speeds[0] == 50.0


def test_results_with_arrays_are_equal_to_themselves_only():
    def below(cls: type) -> set[type]:
        return {cls}.union(*(below(one) for one in cls.__subclasses__()))

    results()  # import the classes
    kinds = {one for one in below(ReadOnly) if dataclasses.is_dataclass(one)}
    assert len(kinds) > 15
    # whether arrays are equal has no single answer; this one has numbers only
    compared = {one.__name__ for one in kinds if one.__dataclass_params__.eq}
    assert compared <= {"RollingEstimate"}
    assert all(one.__dataclass_params__.frozen for one in kinds)


def test_numbers_of_a_description_are_not_visited_one_by_one(monkeypatch: pytest.MonkeyPatch):
    # The interfaces of an elastic housing have a row of numbers over its modes for each motion.
    rows = [[0.5] * 100 for _ in range(6)]
    array = np.zeros(3)
    visited = []
    original = _shown.read_only

    def counted(data):
        visited.append(data)
        return original(data)

    monkeypatch.setattr(_shown, "read_only", counted)
    counted({"rows": rows, "motion": (array, "text")})
    assert not array.flags.writeable
    assert len(visited) == 1 + 1 + len(rows) + 1 + 2
