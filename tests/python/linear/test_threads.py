"""The number of threads of an analysis changes nothing in its result."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import gearbow as gb
from gearbow import _parallel
from reference.cases import each_case
from reference.machines import double_stage, rotor_on_films

SPEEDS = np.linspace(50.0, 400.0, 41)
#: The arrays of a result of each analysis of a system, with a number of threads.
ANALYSES: dict[str, Callable[[gb.RotorSystem, int], list[Any]]] = {
    "campbell": lambda system, threads: [
        (found := system.campbell(SPEEDS[:4], count=5, threads=threads)).eigenvalues,
        [crossing.speed for crossing in found.intersections],
        [crossing.residual for crossing in found.intersections],
    ],
    "synchronous": lambda system, threads: [
        (found := system.synchronous(SPEEDS, threads=threads)).amplitudes,
        found.residuals,
    ],
    "frequency_response": lambda system, threads: [
        system.frequency_response(
            SPEEDS, source=gb.ShaftExcitation(system.shafts[0].name), speed=100.0, threads=threads
        ).phasors
    ],
    "mesh_response": lambda system, threads: [
        system.mesh_response(
            (system.meshes[0].driver, system.meshes[0].driven), speeds=SPEEDS, threads=threads
        ).phasors
        if system.meshes
        else []
    ],
    "critical_speed_map": lambda system, threads: [
        system.critical_speed_map(np.geomspace(1e6, 1e9, 5), count=4, threads=threads).speeds
    ],
}


@pytest.fixture(autouse=True)
def many_cores(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the analyses have three threads also where the tests have one core."""
    monkeypatch.setattr(_parallel, "cores", lambda: 3)


@pytest.mark.parametrize("machine", [double_stage, rotor_on_films])
def test_every_number_of_threads_gives_the_same_bits(
    machine: Callable[[], gb.RotorSystem],
) -> None:
    for name, analysis in ANALYSES.items():
        one, *others = [analysis(machine(), threads) for threads in (1, 2, 3)]
        for other in others:
            for known, found in zip(one, other, strict=True):
                assert np.array_equal(known, found, equal_nan=True), name


@pytest.mark.parametrize("threads", [1, 3])
def test_the_error_is_that_of_the_first_point_without_a_result(threads: int) -> None:
    # At 0, the torque accelerates the free rotation of the train.
    frequencies = np.append(np.linspace(900.0, 100.0, 9), np.zeros(30))
    system = double_stage()
    source = gb.Torque(system.gears[0].name, 1.0)
    with pytest.raises(gb.SceneError, match=r"^frequencies\[9\]: source\[0\] accelerates"):
        system.frequency_response(frequencies, source=source, threads=threads)


@each_case("threads", [0, -1, 1.5, "2"])
def test_an_invalid_number_is_refused(threads: Any) -> None:
    with pytest.raises(gb.SceneError, match=r"^threads: must be "):
        double_stage().synchronous(SPEEDS, threads=threads)


@each_case("text", ["0", "-1", "two", "1.5", "²"])
def test_an_invalid_environment_variable_is_refused(
    text: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("GEARBOW_THREADS", text)
    with pytest.raises(gb.SceneError, match=r"^GEARBOW_THREADS: must be a whole number"):
        double_stage().synchronous(SPEEDS)


def test_the_number_is_that_of_the_argument_the_environment_or_the_cores(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.delenv("GEARBOW_THREADS", raising=False)
    assert [_parallel.thread_count(given) for given in (None, 1, 2, 8)] == [3, 1, 2, 3]
    monkeypatch.setenv("GEARBOW_THREADS", " 2 ")
    assert [_parallel.thread_count(given) for given in (None, 1, 3)] == [2, 1, 3]


def test_a_call_of_a_sweep_has_one_thread() -> None:
    with _parallel.ParallelCalls(_parallel.thread_count, [(None,), (2,)]) as calls:
        assert [future.result() for _, future in calls] == [1, 1]
