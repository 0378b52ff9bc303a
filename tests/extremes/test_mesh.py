"""Extreme meshes: contact ratios at integers and below one, unloaded and impacting flanks,
stiffness and tooth ratios.
"""

from __future__ import annotations

import warnings
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import gearbow as gb
from reference.teeth import TeethLaw, Toothed, propagate, tips
from systems import Hold, apart, train

pytestmark = pytest.mark.filterwarnings("ignore:contact ratio:gearbow.AccuracyWarning")

SPEED, PAIR = 600.0, 1.5e8
TORSION = Toothed(torque=80.0, mesh={"damping_ratio": 0.03})


def exact_and_found(
    scene: Toothed, ratio: float, pair: float, torque: float = 80.0, **options: Any
) -> tuple[np.ndarray, np.ndarray]:
    scene = replace(
        scene,
        torque=torque,
        gear={**scene.gear, "tip_radius": tips(scene, ratio)},
        mesh={**scene.mesh, "stiffness": {"model": "square", "pair": pair, "engagement": "sharp"}},
    )
    times = (np.arange(12) + 0.37) * 2 * np.pi / (SPEED * scene.teeth[0]) / 3
    teeth = TeethLaw(scene.law(mean=pair * ratio), live=False)
    _, force = propagate(scene, teeth, pair, SPEED, times)
    options = {"rtol": 1e-10, "initial": "rest", "geometry": "frozen", "times": times} | options
    run = scene.package().simulate(times[-1], SPEED, **options)
    return force, run.mesh(("ga", "gb")).force


@pytest.mark.parametrize("method", ["exponential", "rk45"])
def test_contact_ratios_at_and_near_integers(hold: Hold, method: str):
    worst = 0.0
    for ratio in (0.9, 0.999, 1.0, 1.001, 1.98, 2.0, 2.001, 2.3, 3.0):
        force, found = exact_and_found(TORSION, ratio, PAIR, method=method)
        worst = max(worst, apart(found, force))
    hold(
        f'`"{method}"` with sharp engagement equals a product of matrix exponentials',
        "contact ratio 0.9 to 3, including integers and values 1e-3 away",
        worst,
        1e-6,
        "below 1: event `contact ratio below 1`",
    )


def test_soft_and_stiff_teeth(hold: Hold):
    worst = 0.0
    for factor in (1e-3, 1e-2, 1.0, 1e2, 1e3):
        force, found = exact_and_found(TORSION, 1.6, PAIR * factor)
        worst = max(worst, apart(found, force))
    hold(
        "The mesh force of soft and stiff teeth equals a product of matrix exponentials",
        "pair stiffness 1.5e5 to 1.5e11 N/m",
        worst,
        1e-6,
    )


def test_small_and_large_loads(hold: Hold):
    worst = 0.0
    for torque in (1e-9, 1e-3, 1.0, 1e6):
        force, found = exact_and_found(TORSION, 1.6, PAIR, torque)
        worst = max(worst, apart(found, force))
    hold(
        "The mesh force with frozen geometry equals a product of matrix exponentials at any load",
        "torque 1e-9 to 1e6 N m",
        worst,
        1e-6,
    )


def test_unequal_tooth_numbers(hold: Hold):
    worst = 0.0
    for teeth in ((3, 1200), (1200, 3), (17, 400), (400, 400)):
        with warnings.catch_warnings():
            # so few teeth are undercut, and so many on the other gear reach beyond their base
            # circle
            warnings.simplefilter("ignore", gb.SceneWarning)
            static = train(teeth=teeth, torque=1e-3).static()
        base = 3e-3 * teeth[0] / 2 * np.cos(np.radians(20.0))
        worst = max(worst, abs(static.mesh(("ga", "gb")).force / (1e-3 / base) - 1))
    hold(
        "The static mesh force equals torque / base radius",
        "tooth number ratio 1:400 to 400:1",
        worst,
        1e-9,
        "fewer than 3 teeth: `SceneError`",
    )
    with pytest.raises(gb.SceneError, match=r"gears\[0\]\.teeth: must be at least 3, got 2"):
        train(teeth=(2, 40))
    gaps = []
    for teeth in ((3, 1200), (1200, 3)):
        stiffness = gb.Stiffness.square(pair=2e8, engagement=0.2)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", gb.SceneWarning)
            system = train(teeth=teeth, torque=1.0, stiffness=stiffness)
        forces = [
            system.simulate(
                5e-3, 100.0, initial="rest", record=["meshes"], method=method, rtol=1e-9
            )
            .mesh(("ga", "gb"))
            .force
            for method in ("exponential", "rk45")
        ]
        gaps.append(apart(*forces))
    hold(
        '`"exponential"` and `"rk45"` agree on the mesh force of unequal gears',
        "tooth number ratio 1:400 and 400:1",
        max(gaps),
        1e-5,
    )


def rattling(method: str, backlash: float, duration: float, rtol: float) -> gb.Response:
    """Simulate gears without torque on bowed shafts: the moving centres cause flank impacts."""
    system = train(bow=gb.Bow.half_sine(1e-4), torque=0.0, backlash=backlash)
    record = ["gears", "meshes", "energy"]
    return system.simulate(
        duration,
        300.0,
        method=method,
        rtol=rtol,
        initial="rest",
        record=record,
        output_step=duration / 40,
    )


@pytest.mark.parametrize("backlash", [0.0, 1e-9, 1e-6, 1e-5])
def test_two_methods_agree_on_flank_impacts(hold: Hold, backlash: float):
    runs = [rattling(method, backlash, 3e-3, 1e-9) for method in ("exponential", "rk45")]
    assert len(runs[0].events) > 3
    # With 1 nm backlash both flanks make contact within less time than a step resolves: the order
    # may differ.
    if backlash != 1e-9:
        assert [event.kind for event in runs[0].events] == [event.kind for event in runs[1].events]
        times = [np.array([event.time for event in run.events]) for run in runs]
        assert np.abs(times[0] - times[1]).max() < 1e-8
    worst = apart(runs[0].displacement("ga"), runs[1].displacement("ga"))
    hold(
        '`"exponential"` and `"rk45"` agree on the displacement with flank impacts',
        f"backlash {backlash:g} m".replace("e-0", "e-"),
        worst,
        1e-6,
    )


@pytest.mark.implausible
def test_energy_balance_over_many_contact_events(hold: Hold):
    # Stiff teeth, no damping and no torque: the gears rattle between both flanks.
    system = train(
        bow=gb.Bow.half_sine(3e-4), torque=0.0, backlash=1e-7, stiffness=2e10, damping_ratio=0.0
    )
    run = system.simulate(
        0.01, 2000.0, initial="rest", record=["energy", "meshes"], output_step=1e-4
    )
    assert len(run.events) > 100
    residual = run.energy_balance().residual
    assert np.isfinite(run.energy).all()
    scale = np.abs(run.energy).max()
    hold(
        "The energy balance is closed over many contact events",
        "more than 100 events in 10 ms, no damping",
        float(np.abs(residual).max() / scale),
        1e-3,
    )


def test_unloaded_contact_does_not_stop_a_run():
    # Without backlash, torque and bow the flanks touch with zero force.
    for torque in (0.0, 1e-12, 1e-6):
        system = train(torque=torque, backlash=0.0)
        run = system.simulate(2e-3, 100.0)
        assert np.isfinite(run.mesh(("ga", "gb")).force).all()
        assert run.statistics.steps < 10_000
