"""Tolerances from loose to below round-off; every method at, under and over its limit of stability."""

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
def test_the_error_follows_the_tolerance(hold: Hold, method: str):
    worst = 0.0
    for stiffness in STIFFNESS.values():
        exact = displaced(stiffness, method=method, rtol=1e-12)
        for power in range(1, 12):
            off = apart(displaced(stiffness, method=method, rtol=10.0**-power), exact)
            worst = max(worst, off / 10.0**-power)
    hold(
        f'the error of `"{method}"` stays below a multiple of `rtol`',
        "1e-1 to 1e-11",
        worst,
        1e2,
        "below 1e-13 `rtol` is taken as 1e-13, with an `AccuracyWarning`",
    )


@pytest.mark.implausible
def test_round_off_is_where_tolerances_end(hold: Hold):
    exact = displaced(STIFFNESS["smooth"], method="rk45", rtol=1e-13)
    found = displaced(STIFFNESS["smooth"], rtol=1e-13)
    hold("two methods meet at the tightest tolerance", "1e-13", apart(found, exact), 1e-11)
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
    "circulating": {"stiffness": [[1e8, 2e7], [-2e7, 1e8]], "damping": 1e5},
    "far supercritical": {"speed": 3e4},
}


@pytest.mark.parametrize("name", SCENES)
def test_at_and_over_the_limit_of_stability(hold: Hold, name: str):
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
    )  # printed with five digits
    swing = 2 * np.abs(system.static().displacement(MIDDLE)).max()
    grown = np.abs(run(limit * (1 - 1e-4))).max() / swing
    with pytest.raises(gb.StabilityError, match="above the stability limit"):
        run(limit * (1 + 1e-4), 1)
    hold(
        f'`"rk4"` just under its limit of stability stays bounded, {name}',
        "20 000 steps; largest over the static swing",
        grown,
        1.5,
        "a longer step: `StabilityError` before the run",
    )


@pytest.mark.parametrize("rtol", [0.99, 0.1])
def test_rk45_is_held_below_its_limit(hold: Hold, rtol: float):
    system = rotor(1e8, elements=4, gravity=GRAVITY)
    times = np.linspace(0.0, 0.1, 100)
    run = system.simulate(
        0.1, 300.0, method="rk45", rtol=rtol, initial="rest", record=[MIDDLE, "energy"], times=times
    )
    swing = 2 * np.abs(system.static().displacement(MIDDLE)).max()
    hold(
        '`"rk45"` stays bounded whatever its tolerance',
        f"rtol {rtol:g}",
        np.abs(run.displacement(MIDDLE)).max() / swing,
        1.2,
    )


def test_large_steps_of_what_is_exact(hold: Hold):
    # The linear motion is exact in steps of any length.
    system = rotor(1e8, 300.0, elements=4, gravity=GRAVITY)
    times = [0.01, 0.04]
    exact = released(system, 300.0, times)[:, at(system, MIDDLE)]
    worst = 0.0
    for options in (
        {"step": 1e-6},
        {"step": 1e-2},
        {"step": 10.0},
        {"step": 1e-2, "method": "rk4", "linear": "exact"},
    ):
        run = system.simulate(0.04, 300.0, initial="rest", record=[MIDDLE], times=times, **options)
        worst = max(worst, apart(run.displacement(MIDDLE), exact))
    hold("linear motion is exact at any step", "1e-6 to 10 s", worst, 1e-8)
