"""Variations of one system, simulated in parallel."""

from __future__ import annotations

import threading
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import gearbow as gb
from test_sweep import pair


def torques(value: float, last: str = "g2") -> dict[str, object]:
    return {"torques": [gb.Torque("g1", value), gb.Torque.balance(last)]}


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
        assert run.mesh(("g1", "g2")).force.tobytes() == alone.mesh(("g1", "g2")).force.tobytes()
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
    rotor = gb.RotorSystem([shaft], bearings=bearings, accuracy="reference")
    description = rotor.description
    thread = threading.Thread(target=count)
    thread.start()
    most = 0
    for _ in range(20):  # a busy machine may not run the thread at once
        before = ticks
        type(rotor._model)(description)
        most = max(most, ticks - before)
        if most > 5:
            break
    end.set()
    thread.join()
    assert most > 5


def long_runs(
    base: gb.RotorSystem, variations: list[dict[str, object]], workers: int = 1
) -> list[gb.Response]:
    """Simulate 0.35 s, long enough for a choice among numbers of modes."""
    with ThreadPoolExecutor(workers) as executor:
        options = {"output_step": 2e-4, "record": ["meshes"], "executor": executor}
        return base.simulate_many(variations, 0.35, 100.0, **options)


def bits(runs: list[gb.Response]) -> list[bytes]:
    return [run.mesh(("g1", "g2")).force.tobytes() for run in runs]


def test_variations_share_a_number_of_modes_in_any_order_and_with_any_number_of_workers():
    base = pair(100.0, 1e-4)
    variations = [torques(50.0), torques(200.0), {"gravity": 9.81}, {}]
    runs = long_runs(base, variations)
    statistics = [run.statistics for run in runs]
    assert {each.modes for each in statistics} == {statistics[0].modes}
    assert statistics[0].modes < len(base.dofs)
    # A third of the permitted errors of "engineering".
    assert all(np.all(np.less(each.modes_error, (1e-3 / 3, 1e-2 / 3))) for each in statistics)
    # A new system does not know the reduction yet.
    assert bits(long_runs(pair(100.0, 1e-4), variations, 2)) == bits(runs)
    assert bits(long_runs(pair(100.0, 1e-4), variations[::-1])) == bits(runs)[::-1]
    for variation, run in zip(variations, runs, strict=True):
        alone = base.replace(**variation).simulate(0.35, 100.0, output_step=2e-4, record=["meshes"])
        force, exact = run.mesh(("g1", "g2")).force, alone.mesh(("g1", "g2")).force
        # Both have at most the permitted error.
        assert np.sqrt(np.mean((force - exact) ** 2)) < 2e-2 * np.std(exact)


def train() -> gb.RotorSystem:
    """Return the train of the bow study, with bows of a twentieth of the radius."""
    path = Path(__file__).parents[3] / "examples" / "machines" / "double_stage_train.toml"
    return gb.RotorSystem.load(path)


def test_a_variation_takes_the_modes_that_its_loads_need():
    base = train()

    def bowed(amplitude: float) -> dict[str, object]:
        bows = [gb.Bow.half_sine(amplitude, phase=1.4 * place) for place in range(3)]
        return {"shafts": [replace(s, bow=b) for s, b in zip(base.shafts, bows, strict=True)]}

    straight = {"shafts": [replace(shaft, bow=None) for shaft in base.shafts]}
    variations = [{}, {**bowed(2.5e-3), **torques(205.0, "g4")}, straight]
    options = {"record": ["meshes"]}
    with ThreadPoolExecutor(1) as executor:
        runs = base.simulate_many(variations, 0.31, 100.0, **options, executor=executor)
    few, many, own = (run.statistics for run in runs)
    assert few.modes < many.modes < len(base.dofs)
    # A third of the permitted error of mesh forces.
    assert max(each.modes_error[1] for each in (few, many, own)) < 1e-2 / 3
    # The comparison begins with the modes of the system, which straight shafts do not need more of.
    alone = base.replace(**straight).simulate(0.31, 100.0, **options)
    assert few.modes <= own.modes
    assert alone.statistics.modes <= own.modes


def test_a_variation_has_the_matrices_and_loads_of_its_scene():
    base = pair(100.0, 1e-4)
    bent = replace(base.shafts[1], bow=gb.Bow.half_sine(2e-4, phase=1.0))
    heavy = replace(base.gears[0], unbalance=1e-3)
    variations = [
        {"shafts": [base.shafts[0], bent], "gravity": 9.81},
        {"gears": [heavy, base.gears[1]]},
        {"forces": [gb.Force("g1", (10.0, 20.0))], **torques(-50.0)},
        {"shafts": [base.shafts[0], replace(base.shafts[1], outer_diameter=0.06)]},
    ]
    for changes in variations:
        varied, fresh = base._variation(**changes), base.replace(**changes)
        assert varied.description == fresh.description
        for name in ("mass", "stiffness", "damping", "gyroscopic"):
            own, other = (getattr(each.matrices(100.0), name) for each in (varied, fresh))
            assert np.array_equal(own, other)
        for analyse in (gb.RotorSystem.static, lambda each: each.synchronous([100.0])):
            own, other = (analyse(each).displacement("g1") for each in (varied, fresh))
            assert np.array_equal(own, other)


def test_a_variation_has_the_elements_of_the_system_where_they_meet_the_level():
    base = train()
    heavy = base._variation(gravity=9.81)
    assert heavy.discretisation == base.discretisation
    # The place of a force is a node.
    forces = {"forces": [gb.Force(("input", 0.1), (10.0, 0.0))]}
    assert base._variation(**forces).dofs == base.replace(**forces).dofs != base.dofs
    draft = base._variation(accuracy="draft")
    assert draft.discretisation == base.replace(accuracy="draft").discretisation
