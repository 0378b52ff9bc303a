"""Tolerances from loose to below round-off; methods below and above their stability limit."""

from __future__ import annotations

import re

import numpy as np
import pytest

import gearbow as gb
from systems import GRAVITY, MIDDLE, Hold, apart, at, released, rotor, train

STIFFNESS = {
    "mean": 2e8,
    "smooth": gb.Stiffness.square(1.5e8, engagement=0.3),
    "sharp": gb.Stiffness.square(1.5e8, engagement="sharp"),
}


def displaced(stiffness: object, **options: object) -> np.ndarray:
    options = {"initial": "rest", "output_step": 1e-4} | options
    return (
        train(bow=gb.Bow.half_sine(1e-4), stiffness=stiffness)
        .simulate(2e-3, 100.0, **options)
        .displacement("ga")
    )


@pytest.mark.parametrize("method", ["exponential", "rk45"])
def test_error_stays_below_a_multiple_of_rtol(hold: Hold, method: str):
    worst = 0.0
    for stiffness in STIFFNESS.values():
        exact = displaced(stiffness, method=method, rtol=1e-12)
        for power in range(1, 12):
            off = apart(displaced(stiffness, method=method, rtol=10.0**-power), exact)
            worst = max(worst, off / 10.0**-power)
    hold(
        f'Error of `"{method}"` / `rtol`',
        "`rtol` 1e-1 to 1e-11",
        worst,
        1e2,
        "`rtol` below 1e-13 is replaced by 1e-13, with an `AccuracyWarning`",
    )


@pytest.mark.implausible
def test_smallest_tolerance(hold: Hold):
    exact = displaced(STIFFNESS["smooth"], method="rk45", rtol=1e-13)
    found = displaced(STIFFNESS["smooth"], rtol=1e-13)
    hold(
        '`"exponential"` and `"rk45"` agree at the smallest tolerance',
        "`rtol` 1e-13",
        apart(found, exact),
        1e-11,
    )
    for rtol in (1e-14, 1e-300):
        with pytest.warns(
            gb.AccuracyWarning,
            match="rtol: .* is below what round-off leaves to a step; taken as 1e-13",
        ):
            assert np.array_equal(displaced(STIFFNESS["smooth"], rtol=rtol), found)
    for rtol in (0.0, 1.0, -1.0, np.nan, np.inf):
        with pytest.raises(gb.SceneError, match=r"rtol: must (lie between 0 and 1|be finite)"):
            displaced(2e8, rtol=rtol)


SCENES = {
    "undamped": {},
    "heavily damped": {"damping": 1e6},
    "modal damping": {"modal_damping": 0.2},
    "stiff bearings": {"stiffness": 1e12},
    "circulatory bearings": {"stiffness": [[1e8, 2e7], [-2e7, 1e8]], "damping": 1e5},
    "supercritical speed": {"speed": 3e4},
}


@pytest.mark.parametrize("name", SCENES)
def test_rk4_below_and_above_the_stability_limit(hold: Hold, name: str):
    scene = dict(SCENES[name])
    speed = float(scene.pop("speed", 300.0))
    system = rotor(**{"elements": 4, "gravity": GRAVITY} | scene)

    def run(step: float, steps: int = 20_000) -> np.ndarray:
        times = np.linspace(0.0, steps * step, 50)
        return system.simulate(
            times[-1], speed, method="rk4", step=step, initial="rest", record=[MIDDLE], times=times
        ).displacement(MIDDLE)

    with pytest.raises(gb.StabilityError) as refused:
        run(1.0, 1)
    limit = float(
        re.search(r"stability limit of (\S+) s", str(refused.value))[1]
    )  # the message has five digits
    scale = 2 * np.abs(system.static().displacement(MIDDLE)).max()
    grown = np.abs(run(limit * (1 - 1e-4))).max() / scale
    with pytest.raises(gb.StabilityError, match="above the stability limit"):
        run(limit * (1 + 1e-4), 1)
    hold(
        f'`"rk4"` just below its stability limit stays bounded, {name}',
        "20 000 steps; maximum displacement / (2 × static displacement)",
        grown,
        1.5,
        "longer step: `StabilityError` before the run",
    )


@pytest.mark.parametrize("rtol", [0.99, 0.1])
def test_rk45_stays_stable_at_any_tolerance(hold: Hold, rtol: float):
    system = rotor(1e8, elements=4, gravity=GRAVITY)
    times = np.linspace(0.0, 0.1, 100)
    run = system.simulate(
        0.1, 300.0, method="rk45", rtol=rtol, initial="rest", record=[MIDDLE, "energy"], times=times
    )
    scale = 2 * np.abs(system.static().displacement(MIDDLE)).max()
    hold(
        '`"rk45"` stays bounded at any tolerance',
        f"`rtol` {rtol:g}; maximum displacement / (2 × static displacement)",
        np.abs(run.displacement(MIDDLE)).max() / scale,
        1.2,
    )


def test_linear_motion_is_exact_at_any_step(hold: Hold):
    # Both methods integrate a linear system exactly with any step.
    system = rotor(1e8, 300.0, elements=4, gravity=GRAVITY)
    times = [0.01, 0.04]
    exact = released(system, 300.0, times)[:, at(system, MIDDLE)]
    worst = 0.0
    for options in (
        {"step": 1e-6},
        {"step": 1e-2},
        {"step": 10.0},
        {"step": 1e-2, "method": "etdrk4"},
    ):
        run = system.simulate(0.04, 300.0, initial="rest", record=[MIDDLE], times=times, **options)
        worst = max(worst, apart(run.displacement(MIDDLE), exact))
    hold("Linear motion is exact at any step", "step 1e-6 to 10 s", worst, 1e-8)
