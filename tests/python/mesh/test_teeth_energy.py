"""Energy of meshes with teeth: conservation without work, and the energy balance with work."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

import gearbow as gb
from reference.bows import HalfSine
from reference.teeth import TeethLaw, Toothed, begin, switch_times

K = 2e8


def thrown(
    scene: Toothed, speed: float, rates: tuple[float, float], duration: float, **options: Any
) -> gb.Response:
    """Return a torsional gear pair in its rest position, with the initial gear velocities `rates`."""
    system = scene.package()
    n = len(system.dofs)
    y = np.zeros(2 * n)
    y[:2] = -1e-5  # the gap is a third of a micrometre
    y[n:] = np.repeat(rates, 2)
    run = {k: v for k, v in options.items() if k in ("method", "step", "rtol")}
    more = {"output_step": duration / 2000} | options
    return system.simulate(
        duration, speed, initial=begin(system, speed, y, **run), record=["meshes", "energy"], **more
    )


@pytest.mark.parametrize(("method", "setting"), [("rk45", 1e-9), ("rk4", 2e-6)])
def test_hammering_never_gains_energy(method: str, setting: float):
    """One gear bounces between both flanks of the other: ten thousand impacts without damping."""
    scene = Toothed(mesh={"stiffness": K, "backlash": 1e-5})
    options = {"rtol": setting} if method == "rk45" else {"step": setting}
    found = thrown(scene, 0.0, (50.0, 0.0), 1.75, method=method, **options)
    impacts = [event for event in found.events if event.kind.endswith("contact")]
    assert len(impacts) > 1e4
    energy = found.energy
    # both methods dissipate 1e-9 or (h omega)^6/144 = 2e-11 per step; neither may gain more than
    # round-off
    assert np.max(energy) < energy[0] * (1 + 1e-12)
    assert energy[-1] > energy[0] * (1 - 4e-5)
    # the impacts on both flanks remain equally strong
    force = found.mesh(("ga", "gb")).force
    assert force[-200:].max() == pytest.approx(-force[-200:].min(), rel=0.05)


@pytest.mark.parametrize("rtol", [1e-4, 1e-6, 1e-8])
def test_loss_of_energy_in_impacts_follows_the_tolerance(rtol: float):
    found = thrown(
        Toothed(mesh={"stiffness": K, "backlash": 1e-5}), 0.0, (50.0, 0.0), 0.1, rtol=rtol
    )
    lost = found.energy / found.energy[0] - 1
    # 1200 impacts of 20 to 50 steps each
    assert np.abs(lost).max() < 1e3 * rtol


@pytest.mark.parametrize(
    "run",
    [
        {"method": "exponential", "rtol": 1e-13},
        {"method": "rk45", "rtol": 1e-13},
        {"method": "rk4", "step": 2e-7},
    ],
    ids=lambda run: run["method"],
)
def test_switching_stiffness_does_work(run: dict[str, Any]):
    """Energy is constant between stiffness switches; each switch changes it by dk delta^2 / 2."""
    speed, pair = 700.0, 1.5e8
    square = {"model": "square", "pair": pair, "engagement": "sharp"}
    scene = Toothed(mesh={"stiffness": square}, torque=0.0)
    duration = 12 * 2 * np.pi / (speed * scene.teeth[0])
    switches = switch_times(TeethLaw(scene.law()), speed, duration)
    assert len(switches) == 24
    between = [(a + b) / 2 for a, b in pairwise([0.0, *switches, duration])]
    found = thrown(
        scene, speed, (1.0, 0.0), duration, output_step=None, times=[*between, *switches], **run
    )
    energy, mesh = found.energy, found.mesh(("ga", "gb"))
    m = len(between)
    steps = np.diff(mesh.stiffness[:m])
    assert np.abs(steps) == pytest.approx(pair, rel=1e-9)
    change = steps * mesh.deflection[m:] ** 2 / 2
    # the interpolated deflection has an error of h^6; the energy error is 1e-13 or (h omega)^5 per
    # step
    assert np.diff(energy[:m]) == pytest.approx(change, abs=2e-10 * energy.max())
    assert np.abs(change).max() > 0.1 * energy[0]


TEETH = {"model": "square", "pair": 1.5e8, "engagement": 0.3, "phase": "twist"}
ROLLING = Toothed(coupled=True, bearing_damping=0.0, mesh={"stiffness": TEETH}, torque=0.0)


def rolling(options: dict[str, Any], given: Toothed = ROLLING, **mesh: Any) -> np.ndarray:
    """Return the energy of an undamped train without loads that rotates freely, with moving tooth
    pairs and centres.
    """
    scene = replace(given, mesh=given.mesh | mesh)
    system = scene.package()
    # The core stores, for each shaft, four bending coordinates of every node, then all twists.
    n, nodes = len(system.dofs), len(system.dofs) // 10
    y = np.zeros(2 * n)
    # the twists differ slightly from pure rolling, so that the mesh deflects
    speed = 300.0 * 25 / scene.teeth[0]
    other = -0.9867 * speed * scene.teeth[0] / scene.teeth[1]
    for first, rate in ((0, speed), (5 * nodes, other)):
        y[n + first + 4 * nodes : n + first + 5 * nodes] = rate
    found = system.simulate(
        2e-3,
        0.0,
        initial=begin(system, 0.0, y, **options),
        record=["meshes", "energy", "gears"],
        output_step=1e-5,
        **options,
    )
    pairs = found.mesh(("ga", "gb")).pairs_in_contact
    assert np.abs(np.diff(pairs)).sum() >= 3  # tooth pairs enter and leave contact
    assert np.ptp(found.mesh(("ga", "gb")).pressure_angle) > 1e-5
    vibrating = found.energy_balance().meshes.max()
    return (found.energy - found.energy[0]) / vibrating


@pytest.mark.parametrize(
    "model",
    [
        TEETH,
        {"model": "parabolic", "pair": 1.5e8, "engagement": 0.3},
        {"model": "potential_energy", "engagement": 0.5},
        {"model": "fourier", "mean": 2e8, "amplitudes": [4e7, 1e7]},
        {"model": "table", "values": [1e8, 2e8, 3e8, 2e8, 2.5e8]},
    ],
    ids=lambda model: model["model"],
)
@pytest.mark.parametrize("method", ["exponential", "rk45"])
def test_energy_is_constant_if_the_twist_moves_the_teeth(method: str, model: dict[str, Any]):
    options = {"method": method, "rtol": 1e-11}
    drift = np.abs(rolling(options, stiffness={**model, "phase": "twist"}))
    # relative to the mesh energy; the kinetic energy of the rotation is about a hundred times
    # larger
    assert drift.max() < 1e-6


@pytest.mark.parametrize("method", ["exponential", "rk45"])
@pytest.mark.parametrize("model", ["square", "parabolic", "potential_energy"])
@pytest.mark.parametrize("teeth", [(12, 60), (60, 12)])
def test_energy_is_constant_if_a_base_circle_limits_the_path(
    method: str, model: str, teeth: tuple[int, int]
):
    given = replace(ROLLING, teeth=teeth)
    stiffness = {"model": model, "engagement": 0.3, "phase": "twist"}
    if model == "potential_energy":
        stiffness["bore_radii"] = tuple(0.4 * 3e-3 * z / 2 for z in teeth)
    else:
        stiffness["pair"] = 1.5e8
    drift = np.abs(rolling({"method": method, "rtol": 1e-11}, given, stiffness=stiffness))
    assert drift.max() < 1e-6  # as above


def test_energy_drift_decreases_with_the_order_of_the_method():
    coarse, fine = (np.abs(rolling({"method": "rk4", "step": h})).max() for h in (4e-6, 2e-6))
    # the energy loss of RK4 is of fifth order; the force has two derivatives
    assert coarse / fine > 2**4
    assert coarse < 1e-3
    drift = [
        np.abs(rolling({"method": "rk45", "rtol": rtol})).max() for rtol in (1e-7, 1e-8, 1e-9)
    ]  # between the longest stable step and round-off
    assert drift[0] / drift[1] > 5
    assert drift[1] / drift[2] > 5
    # the third derivative jumps within a step where a pair enters: the exponential method converges
    # more slowly
    loose, tight = (np.abs(rolling({"rtol": rtol})).max() for rtol in (1e-5, 1e-9))
    assert loose / tight > 1e2


FORCED = {
    "torque alone": {},
    "error": {"error": {"tooth": [(3e-6, 0.0)], "driver": [(5e-6, 1.0)]}},
    "relief": {"tip_relief": {"amount": 5e-6, "length": 2e-3}},
    "backlash": {"backlash": 1e-4},
    "damping": {"damping": 800.0},
    "prescribed": {"stiffness": {**TEETH, "phase": "prescribed"}},
    "all": {
        "error": {"tooth": [(3e-6, 0.0)], "driver": [(5e-6, 1.0)]},
        "tip_relief": {"amount": 5e-6, "length": 2e-3},
        "backlash": 1e-4,
        "damping": 800.0,
    },
}


@pytest.mark.parametrize("runout", [None, (2e-5 + 1e-5j, 1e-5j)], ids=["round", "run-out"])
@pytest.mark.parametrize("geometry", ["live", "frozen"])
@pytest.mark.parametrize("name", FORCED)
@pytest.mark.parametrize("method", ["exponential", "rk45"])
def test_the_energy_balance_contains_all_works(method: str, name: str, geometry: str, runout: Any):
    scene = replace(
        ROLLING,
        torque=80.0,
        bearing_damping=300.0,
        mesh=ROLLING.mesh | FORCED[name],
        gear={"runout": runout} if runout else {},
        bows={"a": HalfSine(4e-5), "b": HalfSine(2e-5, 1.0)},
    )
    found = scene.package().simulate(
        1e-3,
        400.0,
        initial="rest",
        record=["energy"],
        method=method,
        rtol=1e-10,
        geometry=geometry,
        output_step=1e-5,
    )
    balance = found.energy_balance()
    turned_over = np.abs(np.diff(balance.total)).sum()
    # the works are integrals over the interpolated motion; kinks of the force law lie within steps
    assert np.abs(balance.residual).max() < 1e-6 * turned_over


@pytest.mark.parametrize("method", ["exponential", "rk45"])
def test_the_energy_balance_contains_the_work_of_a_stiffness_switch(method: str):
    square = {"model": "square", "pair": 1.5e8, "engagement": "sharp"}
    scene = Toothed(mesh={"stiffness": square})
    found = thrown(scene, 700.0, (1.0, 0.0), 4e-3, method=method, rtol=1e-11)
    balance = found.energy_balance()
    turned_over = np.abs(np.diff(balance.total)).sum()
    assert turned_over > balance.total[0]
    assert np.abs(balance.residual).max() < 1e-6 * turned_over


@pytest.mark.parametrize("geometry", ["live", "frozen"])
def test_centres_that_close_by_more_than_the_backlash_press_both_flanks(geometry: str):
    """Bowed shafts in a tight mesh: energy is constant where the contact moves to the other flank."""
    scene = replace(
        ROLLING,
        torque=80.0,
        mesh={"stiffness": K, "backlash": 5e-6},
        bows={"a": HalfSine(8e-5), "b": HalfSine(4e-5, np.pi)},
    )
    run = scene.package().simulate(
        1e-3,
        400.0,
        initial="rest",
        record=["energy", "meshes"],
        rtol=1e-10,
        geometry=geometry,
        output_step=1e-5,
    )
    balance = run.energy_balance()
    assert run.mesh(("ga", "gb")).stiffness.max() == 2 * K
    assert np.abs(balance.residual).max() < 1e-6 * np.abs(np.diff(balance.total)).sum()


@pytest.mark.parametrize("closing", [0.0, 2e-5, 1e-4])
def test_force_of_a_tight_mesh_is_the_difference_of_its_flanks(closing: float):
    backlash = 3e-5
    out = {"runout": (None, -closing or None)}
    scene = Toothed(mesh={"stiffness": K, "backlash": backlash}, gear=out)
    system, law = scene.package(), scene.law()
    alpha_0, alpha = (
        law.angle_at_rest,
        np.arccos(law.sum_of_radii / (law.centre_distance - closing)),
    )
    tight = -law.sum_of_radii * (np.tan(alpha) - alpha - np.tan(alpha_0) + alpha_0)
    for turn in np.linspace(-3e-3, 3e-3, 13):
        y = np.zeros(2 * len(system.dofs))
        y[:2] = turn
        mesh = system.simulate(0.0, 0.0, initial=begin(system, 0.0, y), times=[0.0]).mesh(
            ("ga", "gb")
        )
        rolled = turn * law.base_radius_a
        drive, back = max(rolled + tight, 0.0), max(-rolled + tight - backlash, 0.0)
        assert mesh.force[0] == pytest.approx(K * (drive - back), abs=1e-12 * K * law.base_radius_a)
        assert mesh.stiffness[0] == K * (int(drive > 0) + int(back > 0))


@pytest.mark.parametrize(
    "given", [{"model": "square", "mean": K}, {"model": "fourier", "mean": K, "amplitudes": [5e7]}]
)
def test_a_damped_train_keeps_its_speed(given: dict[str, Any]):
    """The drive supplies the power that damping dissipates, so that the twist stays bounded."""
    scene = Toothed(mesh={"stiffness": given, "damping_ratio": 0.05}, torque=80.0)
    omega = np.sqrt(K / scene.effective_mass)
    run = scene.package().simulate(
        0.3,
        0.6 * omega / scene.teeth[0],
        initial="static",
        record=["gears", "energy"],
        output_step=1e-3,
    )
    balance = run.energy_balance()
    # enough to decelerate the train (3e-3 kg m^2, 480 rad/s) by 0.1 rad/s
    assert balance.damping[-1] < -0.1
    assert np.abs(np.diff(run.twist("ga"))).max() < 1e-3
    assert np.abs(run.twist("ga")[-50:].mean()) < 1e-3


@pytest.mark.parametrize("method", ["exponential", "rk45"])
@pytest.mark.parametrize("rtol", [1e-1, 1e-2, 1e-3])
def test_a_tight_mesh_is_integrated_stably(method: str, rtol: float):
    """Two flanks are twice as stiff as one, so that the longest stable step is shorter."""
    scene = Toothed(mesh={"stiffness": K, "backlash": 1e-6}, gear={"runout": (None, -2e-4)})
    system = scene.package()
    y = np.zeros(2 * len(system.dofs))
    y[:2] = 1e-5
    run = system.simulate(
        0.5,
        0.0,
        initial=begin(system, 0.0, y, method=method, rtol=rtol),
        method=method,
        rtol=rtol,
        record=["meshes"],
        output_step=1e-5,
    )
    force = run.mesh(("ga", "gb")).force
    # free and undamped: Runge-Kutta may dissipate energy within its tolerance and never gains any;
    # collocation conserves energy, but a thousand kinks at random places within steps change the
    # force to 0.95 to 1.03, at every tolerance
    kept = np.ptp(force[-100:]) / np.ptp(force[:100])
    assert kept < (1.04 if method == "exponential" else 1.01)
    if method == "exponential":
        assert kept > 0.94


@pytest.mark.parametrize("engagement", [0.3, "sharp"])
@pytest.mark.parametrize("shape", ["linear", "parabolic"])
def test_methods_agree_on_the_work_of_relieved_teeth(shape: str, engagement: Any):
    """Tip relief begins within a step and the power of prescribed teeth jumps there: the audit
    divides the step.
    """
    teeth = {**TEETH, "phase": "prescribed", "engagement": engagement}
    relief = {"amount": 5e-6, "length": 2e-3, "shape": shape}
    scene = replace(
        ROLLING,
        torque=80.0,
        bearing_damping=300.0,
        mesh=ROLLING.mesh | {"stiffness": teeth, "tip_relief": relief, "damping": 300.0},
        bows={"a": HalfSine(4e-5), "b": HalfSine(2e-5, 1.0)},
    )
    system = scene.package()
    exact, *others = (
        system.simulate(1e-3, 400.0, initial="rest", record=["energy"], output_step=1e-5, **run)
        for run in (
            {"method": "rk45", "rtol": 1e-11},
            {"method": "exponential", "rtol": 1e-10},
            {"method": "exponential", "rtol": 1e-8},
        )
    )
    wanted = exact.energy_balance()
    # A part of a step is accepted if two quadrature rules agree to 1e-8 of the total work; about
    # 100 parts add up. The three-point rule of smooth steps has an error of 6e-5 with linear
    # relief.
    assert np.abs(wanted.residual).max() < 5e-8 * np.abs(np.diff(wanted.total)).sum()
    for found in others:
        apart = np.abs(found.energy_balance().teeth - wanted.teeth).max()
        assert apart < 1e-5 * np.ptp(wanted.teeth)
