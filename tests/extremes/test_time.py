"""Long runs, late beginnings, any times to record, parts of runs."""

from __future__ import annotations

import numpy as np
import pytest

import gearbow as gb
from systems import GRAVITY, MIDDLE, Hold, apart, at, rotor, train

METHODS = ["exponential", "rk45", "rk4"]


def test_many_steps_lose_nothing(hold: Hold):
    # An undamped rotor swings under its weight: modes by LAPACK say where it stands after thousands of swings.
    system = rotor(1e8, elements=2, gravity=GRAVITY)
    m = system.matrices()
    duration = 20.0
    times = np.array([0.5, 1.0]) * duration
    run = system.simulate(duration, 0.0, initial="rest", record=[MIDDLE], times=times, step=2e-6)
    assert run.statistics.steps >= 10_000_000 - 1
    low = np.linalg.cholesky(m.mass)
    inverse = np.linalg.inv(low)
    squares, vectors = np.linalg.eigh(inverse @ m.stiffness @ inverse.T)
    shapes = inverse.T @ vectors
    down = np.array([-GRAVITY if kind == "w" else 0.0 for _, _, kind in m.dofs])
    load = shapes.T @ m.mass @ down
    # the phase of the fastest mode that the weight excites is as uncertain as its frequency: ω t times round-off
    exact = [
        (shapes @ (load / squares * (1 - np.cos(np.sqrt(squares) * t))))[at(system, MIDDLE)[1]]
        for t in times
    ]
    hold(
        "steps add up without drift",
        "1e7 steps",
        apart(run.displacement(MIDDLE)[:, 1], exact),
        1e-5,
    )


@pytest.mark.parametrize("method", METHODS)
def test_a_late_start_is_an_early_one(hold: Hold, method: str):
    # 2^20 s: times and sums with them are exact; the bow is turned by what the shaft has turned until then.
    begin, speed, step = 2.0**20, 128.0, 2.0**-22
    offsets = np.arange(9) * 2.0**-12
    options = {"step": step} if method == "rk4" else {"rtol": 1e-9}

    def run(phase: float, start: float) -> np.ndarray:
        system = rotor(1e8, 100.0, elements=2, bow=gb.Bow.half_sine(1e-4, phase=phase))
        return system.simulate(
            2.0**-9,
            speed,
            start=start,
            initial="rest",
            method=method,
            record=[MIDDLE],
            times=start + offsets,
            **options,
        ).displacement(MIDDLE)

    turned = float(np.angle(np.exp(1j * speed * begin)))  # of 2^27, which is exact
    hold(
        f'`"{method}"` begins late as early',
        "1e6 s",
        apart(run(0.0, begin), run(turned, 0.0)),
        1e-8,
    )


@pytest.mark.parametrize("method", METHODS)
def test_any_times_to_record(method: str):
    system = rotor(1e8, 100.0, elements=2, bow=gb.Bow.half_sine(1e-4))
    random = np.random.default_rng(5)
    times = random.uniform(0.0, 2e-3, 40)
    times = np.concatenate([times, times[:7], [0.0, 2e-3, 1e-3]])
    run = system.simulate(2e-3, 300.0, method=method, record=[MIDDLE], times=times)
    one_by_one = [
        system.simulate(2e-3, 300.0, method=method, record=[MIDDLE], times=[t]).displacement(
            MIDDLE
        )[0]
        for t in times[-10:]
    ]
    # whatever else is recorded, a time has its motion to the last bit
    assert np.array_equal(run.time, times)
    assert np.array_equal(run.displacement(MIDDLE)[-10:], one_by_one)
    empty = system.simulate(2e-3, 300.0, method=method, record=[MIDDLE], times=[])
    assert empty.time.size == 0
    assert empty.displacement(MIDDLE).shape == (0, 2)
    assert np.array_equal(empty.final["state"], run.final["state"])


@pytest.mark.parametrize("method", METHODS)
def test_a_run_cut_anywhere_is_the_same(hold: Hold, method: str):
    system = train(bow=gb.Bow.half_sine(1e-4), torque=20.0, backlash=1e-6, elements=2)
    total = 2.0**-9
    options = {"method": method, "times": [total], "initial": "rest"}
    whole = system.simulate(total, 300.0, **options)
    random = np.random.default_rng(7)
    worst = 0.0
    for _ in range(5):
        # binary fractions, so that the parts add up to the whole
        cut = float(random.integers(1, 2**20)) * 2.0**-29
        first = system.simulate(cut, 300.0, **options | {"times": []})
        second = system.simulate(total - cut, 300.0, **options | {"initial": first})
        assert second.final["time"] == total
        worst = max(worst, float(np.abs(second.final["state"] - whole.final["state"]).max()))
        worst = max(
            worst, float(np.abs(second.displacement("ga") - whole.displacement("ga")).max())
        )
    hold(f'`"{method}"` in two parts is the same to the last bit', "cut anywhere", worst, 5e-324)


@pytest.mark.implausible
def test_more_steps_than_can_be_counted_are_refused():
    system = train()
    with pytest.raises(gb.SceneError, match=r"duration: .* more steps"):
        system.simulate(1e3, 1e14, times=[])
