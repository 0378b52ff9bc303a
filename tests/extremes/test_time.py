"""Extreme times: long runs, late start times, arbitrary output times, divided runs."""

from __future__ import annotations

import numpy as np
import pytest

import gearbow as gb
from systems import GRAVITY, MIDDLE, Hold, apart, at, rotor, train

METHODS = ["exponential", "rk45", "rk4"]


def test_errors_do_not_accumulate_over_many_steps(hold: Hold):
    # An undamped rotor oscillates under gravity. An independent modal solution by LAPACK gives the
    # exact motion.
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
    # The phase of the fastest excited mode has the uncertainty ω t × round-off, which sets the
    # tolerance.
    exact = [
        (shapes @ (load / squares * (1 - np.cos(np.sqrt(squares) * t))))[at(system, MIDDLE)[1]]
        for t in times
    ]
    hold(
        "Errors do not accumulate over many steps",
        "1e7 steps",
        apart(run.displacement(MIDDLE)[:, 1], exact),
        1e-5,
    )


@pytest.mark.parametrize("method", METHODS)
def test_late_start_time_gives_the_same_motion(hold: Hold, method: str):
    # The start time 2^20 s is a power of two: sums of times are exact. The bow phase contains the
    # rotation until then.
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

    turned = float(np.angle(np.exp(1j * speed * begin)))  # speed * begin = 2^27 is exact
    hold(
        f'`"{method}"` gives the same motion for a late start time',
        "start time 1e6 s",
        apart(run(0.0, begin), run(turned, 0.0)),
        1e-8,
    )


@pytest.mark.parametrize("method", METHODS)
def test_arbitrary_output_times(method: str):
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
    # The recorded motion at a time is bit-identical for any set of other output times.
    assert np.array_equal(run.time, times)
    assert np.array_equal(run.displacement(MIDDLE)[-10:], one_by_one)
    empty = system.simulate(2e-3, 300.0, method=method, record=[MIDDLE], times=[])
    assert empty.time.size == 0
    assert empty.displacement(MIDDLE).shape == (0, 2)
    assert np.array_equal(empty.final["state"], run.final["state"])


@pytest.mark.parametrize("method", METHODS)
def test_run_in_two_parts_is_bit_identical(hold: Hold, method: str):
    system = train(bow=gb.Bow.half_sine(1e-4), torque=20.0, backlash=1e-6, elements=2)
    total = 2.0**-9
    options = {"method": method, "times": [total], "initial": "rest"}
    whole = system.simulate(total, 300.0, **options)
    random = np.random.default_rng(7)
    worst = 0.0
    for _ in range(5):
        # Binary fractions: the two durations add up to the total without round-off.
        cut = float(random.integers(1, 2**20)) * 2.0**-29
        first = system.simulate(cut, 300.0, **options | {"times": []})
        second = system.simulate(total - cut, 300.0, **options | {"initial": first})
        assert second.final["time"] == total
        worst = max(worst, float(np.abs(second.final["state"] - whole.final["state"]).max()))
        worst = max(
            worst, float(np.abs(second.displacement("ga") - whole.displacement("ga")).max())
        )
    hold(
        f'`"{method}"` in two parts is bit-identical to one run',
        "divided at any time",
        worst,
        5e-324,
    )


@pytest.mark.implausible
def test_too_many_steps_are_an_error():
    system = train()
    with pytest.raises(gb.SceneError, match=r"duration: .* more steps"):
        system.simulate(1e3, 1e14, times=[])
