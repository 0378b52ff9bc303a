"""Teeth: contact ratios through whole numbers and below one, flanks that graze and hammer, ratios of stiffness and of teeth."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import gearbow as gb
from reference.teeth import TeethLaw, Toothed, propagate, tips
from systems import Hold, apart, train

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
    return force, run.mesh("ga", "gb").force


@pytest.mark.parametrize("method", ["exponential", "rk45"])
def test_contact_ratios(hold: Hold, method: str):
    worst = 0.0
    for ratio in (0.9, 0.999, 1.0, 1.001, 1.98, 2.0, 2.001, 2.3, 3.0):
        force, found = exact_and_found(TORSION, ratio, PAIR, method=method)
        worst = max(worst, apart(found, force))
    hold(
        f'`"{method}"` with sharp tooth pairs is the product of matrix exponentials',
        "contact ratio 0.9 to 3, whole numbers and 1e-3 beside them",
        worst,
        1e-6,
        "below one the event `contact ratio below 1`",
    )


def test_ratios_of_stiffness(hold: Hold):
    worst = 0.0
    for factor in (1e-3, 1e-2, 1.0, 1e2, 1e3):
        force, found = exact_and_found(TORSION, 1.6, PAIR * factor)
        worst = max(worst, apart(found, force))
    hold("teeth softer and stiffer than the rest", "stiffness 1e-3 to 1e3 of usual", worst, 1e-6)


def test_loads_of_any_size(hold: Hold):
    worst = 0.0
    for torque in (1e-9, 1e-3, 1.0, 1e6):
        force, found = exact_and_found(TORSION, 1.6, PAIR, torque)
        worst = max(worst, apart(found, force))
    hold("frozen geometry is linear in the load", "1e-9 to 1e6 N m", worst, 1e-6)


def test_numbers_of_teeth(hold: Hold):
    worst = 0.0
    for teeth in ((3, 1200), (1200, 3), (17, 400), (400, 400)):
        static = train(teeth=teeth, torque=1e-3).static()
        base = 3e-3 * teeth[0] / 2 * np.cos(np.radians(20.0))
        worst = max(worst, abs(static.mesh("ga", "gb").force / (1e-3 / base) - 1))
    hold(
        "a mesh carries torque over base radius",
        "ratio 1:400 to 400:1",
        worst,
        1e-9,
        "fewer than 3 teeth: `SceneError`",
    )
    with pytest.raises(gb.SceneError, match=r"gears\[0\]\.teeth: must be at least 3, got 2"):
        train(teeth=(2, 40))
    gaps = []
    for teeth in ((3, 1200), (1200, 3)):
        stiffness = gb.Stiffness.square(pair=2e8, engagement=0.2)
        forces = [
            train(teeth=teeth, torque=1.0, stiffness=stiffness)
            .simulate(5e-3, 100.0, initial="rest", record=["meshes"], method=method, rtol=1e-9)
            .mesh("ga", "gb")
            .force
            for method in ("exponential", "rk45")
        ]
        gaps.append(apart(*forces))
    hold("two methods agree on so unequal teeth", "ratio 1:400 and 400:1", max(gaps), 1e-5)


def hammering(method: str, backlash: float, duration: float, rtol: float) -> gb.Response:
    """Gears without a torque on bent shafts: their run-out of the centres hammers the flanks."""
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
def test_hammering_flanks_by_two_methods(hold: Hold, backlash: float):
    runs = [hammering(method, backlash, 3e-3, 1e-9) for method in ("exponential", "rk45")]
    assert len(runs[0].events) > 3
    # flanks a nanometre apart meet on both sides within less time than a step resolves: in either order
    if backlash != 1e-9:
        assert [event.kind for event in runs[0].events] == [event.kind for event in runs[1].events]
        times = [np.array([event.time for event in run.events]) for run in runs]
        assert np.abs(times[0] - times[1]).max() < 1e-8
    worst = apart(runs[0].displacement("ga"), runs[1].displacement("ga"))
    hold(
        "two methods agree on flanks that hammer",
        f"backlash {backlash:g} m".replace("e-0", "e-"),
        worst,
        1e-6,
    )


@pytest.mark.implausible
def test_an_event_storm_ends_and_balances(hold: Hold):
    # stiff teeth, no damping, nothing that holds the flanks together: they rattle between both
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
        "the energy balance closes through an event storm",
        "more than 100 events in 10 ms, nothing damped",
        float(np.abs(residual).max() / scale),
        1e-3,
    )


def test_grazing_contact_goes_on():
    # Without backlash, torque or bow the flanks rest on each other with no force at all.
    for torque in (0.0, 1e-12, 1e-6):
        system = train(torque=torque, backlash=0.0)
        run = system.simulate(2e-3, 100.0)
        assert np.isfinite(run.mesh("ga", "gb").force).all()
        assert run.statistics.steps < 10_000
