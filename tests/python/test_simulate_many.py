"""Variations of one system, simulated in parallel."""

from __future__ import annotations

import threading
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import gearbow as gb
from test_sweep import pair


def torques(value: float) -> dict[str, object]:
    return {"torques": [gb.Torque("g1", value), gb.Torque.balance("g2")]}


def test_many_runs_have_the_bits_of_single_runs():
    base = pair(100.0, 1e-4)
    variations = [torques(50.0), {"gravity": 9.81}, {"modal_damping": 0.01}, torques(200.0), {}]
    options = {"output_step": 1e-4, "rtol": 1e-6, "record": ["gears", "meshes"]}
    fractions: list[float] = []
    runs = base.simulate_many(variations, 2e-3, 100.0, **options, progress=fractions.append)
    assert fractions == [i / 5 for i in range(1, 6)]
    for variation, run in zip(variations, runs, strict=True):
        fresh = gb.RotorSystem.from_dict(base.replace(**variation).description)
        alone = fresh.simulate(2e-3, 100.0, **options)
        assert run.displacement("g1").tobytes() == alone.displacement("g1").tobytes()
        assert run.mesh("g1", "g2").force.tobytes() == alone.mesh("g1", "g2").force.tobytes()
    assert base.simulate_many([], 2e-3, 100.0) == []


def test_the_error_names_the_variation():
    base = pair(100.0, 0.0)
    options = {"output_step": 1e-4, "rtol": 1e-6, "executor": ThreadPoolExecutor(1)}
    with pytest.raises(
        gb.SceneError, match=r"^variations\[1\] = \{'gravity': nan\}: gravity.*finite"
    ) as caught:
        base.simulate_many([torques(50.0), {"gravity": np.nan}], 1e-3, 100.0, **options)
    first, second = caught.value.responses
    assert first.time.size == 11
    assert second is None
    with pytest.raises(gb.SceneError, match=r"^variations\[0\]: must be a dict of arguments"):
        base.simulate_many([3], 1e-3, 100.0)
    with pytest.raises(gb.SceneError, match=r"^checkpoint: one file cannot contain several runs"):
        base.simulate_many([{}], 1e-3, 100.0, checkpoint="run.npz")
    with pytest.raises(gb.SceneError, match=r"^variations\[0\] = .*'torque' is not a parameter"):
        base.simulate_many([{"torque": 1.0}], 1e-3, 100.0)


def test_other_threads_continue_while_a_system_is_made():
    """A system with chosen elements needs modes. A thread that cannot run counts two ticks at most."""
    ticks = 0
    end = threading.Event()

    def count() -> None:
        nonlocal ticks
        while not end.wait(1e-4):
            ticks += 1

    shaft = gb.Shaft("rotor", length=5.0, outer_diameter=0.05)
    bearings = [gb.Bearing("rotor", float(x), stiffness=1e8) for x in range(6)]
    system = gb.RotorSystem([shaft], bearings=bearings, resolution="reference")
    description = system.description
    thread = threading.Thread(target=count)
    thread.start()
    most = 0
    for _ in range(20):  # a busy machine may not run the thread at once
        before = ticks
        type(system._model)(description)
        most = max(most, ticks - before)
        if most > 5:
            break
    end.set()
    thread.join()
    assert most > 5


def forces_of(base: gb.RotorSystem, variations: list[dict[str, object]], workers: int) -> list[gb.Response]:
    """Simulate 0.35 s, long enough for a reduction to fewer modes."""
    with ThreadPoolExecutor(workers) as executor:
        return base.simulate_many(
            variations, 0.35, 100.0, output_step=1e-3, record=["meshes"], executor=executor
        )
