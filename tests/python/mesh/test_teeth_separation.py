"""Flank separation: force on each flank, free flight, static equilibrium, events, continuation."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import gearbow as gb
from reference.teeth import Toothed, begin, tips

K, BACKLASH, TORQUE = 2e8, 4e-5, 100.0
SCENE = Toothed(mesh={"stiffness": K, "backlash": BACKLASH}, torque=TORQUE)
LAW = SCENE.law()
STATIC = TORQUE / LAW.base_radius_a / K  # deflection
MESH = ("ga", "gb")


def at_deflection(
    system: gb.RotorSystem, deflection: float, rate: float = 0.0, **run: Any
) -> dict[str, Any]:
    """Return displacements of both gears that cause a mesh deflection without rigid-body rotation."""
    n = len(system.dofs)
    y = np.zeros(2 * n)
    share = np.array([LAW.base_radius_a / SCENE.inertia[0], LAW.base_radius_b / SCENE.inertia[1]])
    share *= SCENE.effective_mass
    y[:n] = np.repeat(share, 2) * deflection
    y[n:] = np.repeat(share, 2) * rate
    return begin(system, run.pop("speed", 0.0), y, **run)


@pytest.mark.parametrize("sigma", [1.0, -1.0])
def test_force_law_of_both_flanks(sigma: float):
    system = replace(SCENE, torque=0.0).package()
    for deflection in np.linspace(-3 * BACKLASH, 2 * BACKLASH, 51) + 1e-9:
        state = at_deflection(system, sigma * deflection, speed=sigma)
        found = system.simulate(0.0, sigma, initial=state, times=[0.0]).mesh(MESH)
        expected = K * max(deflection, 0.0) - K * max(-deflection - BACKLASH, 0.0)
        # the force of the drive flank is positive, that of the back flank negative
        assert found.force[0] == pytest.approx(expected, abs=1e-12 * K * BACKLASH)
        assert found.deflection[0] == pytest.approx(deflection, abs=1e-12 * BACKLASH)
        touching = expected != 0.0
        assert found.stiffness[0] == (K if touching else 0.0)
        assert (found.pairs_in_contact[0] > 0) == touching


@pytest.mark.parametrize("torque", [TORQUE, -TORQUE])
@pytest.mark.parametrize("coupled", [False, True])
def test_static_equilibrium_on_either_flank(torque: float, coupled: bool):
    scene = replace(SCENE, torque=torque, coupled=coupled)
    system = scene.package()
    mesh = system.static(speed=300.0).mesh(MESH)
    assert mesh.force == pytest.approx(torque / LAW.base_radius_a, rel=1e-9)
    if not coupled:
        lost = 0.0 if torque > 0 else -BACKLASH
        assert mesh.deflection == pytest.approx(torque / LAW.base_radius_a / K + lost, rel=1e-9)
    # a run stays at this equilibrium, rotating or not; at rest the drive flank is in contact
    for speed, force in ((0.0, abs(torque)), (300.0, torque)):
        still = system.simulate(2e-3, speed, initial="static")
        assert still.mesh(MESH).force == pytest.approx(force / LAW.base_radius_a, rel=1e-7)
        assert not still.events
        shares = still.contact_shares(MESH)
        assert (shares.drive, shares.back) == ((1.0, 0.0) if force > 0.0 else (0.0, 1.0))


def test_steps_converge_on_the_back_flanks_as_on_the_drive_flanks():
    # Each step solves its equations by Newton's method, which converges within about four
    # evaluations if it takes the damping of the flank that is in contact.
    mesh = {"stiffness": K, "backlash": BACKLASH, "damping": 1e4}
    counts = []
    for torque in (TORQUE, -TORQUE):
        run = Toothed(mesh=mesh, torque=torque).package().simulate(2e-3, 300.0, initial="rest")
        counts.append(run.statistics.evaluations / run.statistics.steps)
    drive, back = counts
    assert back == pytest.approx(drive, rel=0.1)


@pytest.mark.parametrize("method", ["rk4", "rk45"])
def test_from_rest_the_flanks_meet_at_once(method: str):
    found = (
        SCENE.package()
        .simulate(1e-3, 100.0, initial="rest", method=method, output_step=1e-6)
        .mesh(MESH)
    )
    # an undamped spring under a sudden load deflects to twice its static deflection
    assert np.max(found.deflection) == pytest.approx(2 * STATIC, rel=0.05)
    assert np.min(found.deflection) > -0.05 * STATIC


@pytest.mark.parametrize("amplitude", [1.0005, 1.01, 1.05, 1.1, 1.5, 5.0])
@pytest.mark.parametrize(
    ("method", "setting"),
    [("rk45", 1e-3), ("rk45", 1e-6), ("rk45", 1e-9), ("rk4", None), ("rk4", 2e-6)],
)
def test_no_flank_ever_pulls(amplitude: float, method: str, setting: float | None):
    """Oscillations about the static deflection that graze, bounce and reach the other flank."""
    system = SCENE.package()
    options: dict[str, Any] = {"method": method}
    if setting:
        options["rtol" if method == "rk45" else "step"] = setting
    state = at_deflection(system, STATIC * (1 + amplitude), **options)
    found = system.simulate(5e-3, 0.0, initial=state, output_step=1e-6, **options)
    mesh = found.mesh(MESH)
    load = TORQUE / LAW.base_radius_a
    drive, back = mesh.deflection > 0, mesh.deflection < -BACKLASH
    # a separation shorter than a quarter of a step is not detected; the default step of rk4 is 1 /
    # omega of this mesh, where the interpolated motion has an error of a few percent
    slack = (5e-4 if setting else 2e-2) * load
    assert np.all(mesh.force[drive] >= -slack)
    assert np.all(mesh.force[back] <= slack)
    assert np.abs(mesh.force[~drive & ~back]).max(initial=0.0) <= slack
    if amplitude > 2:
        assert back.any()


def test_bounce_against_the_closed_form():
    """Undamped, constant load: a sine in contact, a parabola during separation."""
    amplitude = 2.5 * STATIC
    omega = np.sqrt(K / SCENE.effective_mass)
    wide = replace(SCENE, mesh={**SCENE.mesh, "backlash": 1e-3})
    system = wide.package()
    # delta = static + amplitude cos(omega t) down to zero, then separation with the acceleration
    # -static omega^2 of the load
    leaves = np.arccos(-STATIC / amplitude) / omega
    speed = amplitude * omega * np.sin(omega * leaves)
    flight = 2 * speed / (STATIC * omega**2)
    period = 2 * leaves + flight
    options = {"rtol": 1e-12}
    found = system.simulate(
        3.2 * period,
        0.0,
        initial=at_deflection(system, STATIC + amplitude, **options),
        times=np.linspace(0.0, 3.2 * period, 400),
        **options,
    )
    t = (
        np.mod(found.time + period / 2, period) - period / 2
    )  # relative to the middle of the contact phase
    into = np.abs(t) - leaves
    flying = -speed * into + STATIC * omega**2 * into**2 / 2
    expected = np.where(into < 0, STATIC + amplitude * np.cos(omega * t), flying)
    mesh = found.mesh(MESH)
    # six contact changes, each located to 1e-12 of a step of three radians
    assert mesh.deflection == pytest.approx(expected, abs=2e-10 * amplitude)
    assert mesh.force == pytest.approx(K * np.maximum(expected, 0.0), abs=1e-8 * K * amplitude)
    # time of each event
    instants = [
        leaves,
        period - leaves,
        period + leaves,
        2 * period - leaves,
        2 * period + leaves,
        3 * period - leaves,
    ]
    kinds = ["separation", "contact"] * 3
    seen = [event for event in found.events if event.time > 0]
    assert [event.kind for event in seen] == kinds
    assert [event.time for event in seen] == pytest.approx(instants, abs=1e-8 * period)
    assert found.statistics.events == 6


def test_a_damped_flank_separates_at_zero_force():
    scene = replace(SCENE, mesh={**SCENE.mesh, "damping_ratio": 0.2})
    system = scene.package()
    options = {"rtol": 1e-10}
    state = at_deflection(system, 6 * STATIC, **options)
    found = system.simulate(2e-3, 0.0, initial=state, output_step=1e-7, **options)
    mesh = found.mesh(MESH)
    parted = np.flatnonzero((mesh.force[1:] == 0) & (mesh.force[:-1] > 0))
    assert parted.size
    load = TORQUE / LAW.base_radius_a
    # the spring is still compressed when the damping force cancels its force: no jump and no
    # tension
    assert mesh.deflection[parted[0]] > 0.1 * STATIC
    assert mesh.force[parted[0]] < 0.05 * load
    assert np.min(mesh.force[mesh.deflection > 0]) >= 0.0


SHARP = {"model": "square", "pair": 1.5e8, "engagement": "sharp"}
SMOOTH = {"model": "parabolic", "pair": 1.5e8}
STORM = replace(
    SCENE,
    mesh={"backlash": 1e-5, "damping_ratio": 0.02, "error": {"tooth": [(2e-5, 0.0)]}},
)


@pytest.mark.parametrize("method", ["rk45", "rk4"])
@pytest.mark.parametrize("stiffness", [SHARP, SMOOTH], ids=["sharp", "smooth"])
@pytest.mark.parametrize("coupled", [False, True])
def test_a_run_in_two_parts_is_bitwise_equal(stiffness: dict[str, Any], method: str, coupled: bool):
    scene = replace(
        STORM, mesh={**STORM.mesh, "stiffness": stiffness}, coupled=coupled, torque=20.0
    )
    system = scene.package()
    run: dict[str, Any] = {"method": method, "record": ["meshes", "energy"]}
    times = np.linspace(0.0, 4e-3, 401)
    whole = system.simulate(4e-3, 400.0, times=times, **run)
    assert whole.statistics.events > 10
    assert len([event for event in whole.events if "contact" in event.kind]) > 3
    first = system.simulate(1.37e-3, 400.0, times=times[times <= 1.37e-3], **run)
    rest = times[times > 1.37e-3]
    second = system.simulate(4e-3 - 1.37e-3, 400.0, initial=first, times=rest, **run)
    for name in ("force", "deflection", "stiffness", "pairs_in_contact"):
        one = getattr(whole.mesh(MESH), name)
        two = np.concatenate([getattr(part.mesh(MESH), name) for part in (first, second)])
        assert np.array_equal(one, two), name
    assert np.array_equal(whole.energy, np.concatenate([first.energy, second.energy]))
    flanks = [e for e in whole.events if e.kind in ("contact", "back contact", "separation")]
    parts = [
        e
        for r in (first, second)
        for e in r.events
        if e.kind in ("contact", "back contact", "separation")
    ]
    assert parts == flanks


@pytest.mark.parametrize("coupled", [False, True])
def test_a_run_without_separation_is_equal_with_and_without_backlash(coupled: bool):
    runs = []
    for mesh in ({}, {"backlash": 1.0}):
        scene = Toothed(
            mesh={"stiffness": K, "damping_ratio": 0.05, **mesh}, torque=TORQUE, coupled=coupled
        )
        found = scene.package().simulate(
            2e-3, 300.0, initial="static", method="rk4", output_step=1e-5
        )
        runs.append(found.mesh(MESH).force)
        assert found.statistics.events == 0
    # round-off of sums in a different order
    assert runs[0] == pytest.approx(runs[1], rel=1e-12)


def test_each_event_is_counted_once():
    speed, cycles = 200.0, 10
    scene = Toothed(mesh={"stiffness": SHARP}, torque=TORQUE)
    for ratio, per_cycle in ((1.5, 2), (1.9, 2), (2.0, 2), (2.4, 2)):
        trial = replace(scene, gear={"tip_radius": tips(scene, ratio)})
        duration = cycles * 2 * np.pi / (speed * scene.teeth[0])
        for method in ("rk45", "rk4"):
            found = trial.package().simulate(duration, speed, method=method)
            # in each mesh cycle one pair enters and one leaves; at an integer contact ratio both
            # changes are one event or two
            lowest = per_cycle * cycles / (2 if ratio == 2.0 else 1)
            assert lowest <= found.statistics.events <= per_cycle * cycles
            assert not {"contact", "back contact", "separation"} & {
                event.kind for event in found.events
            }


@pytest.mark.parametrize("torque", [TORQUE, -TORQUE])
@pytest.mark.parametrize("geometry", ["frozen", "live"])
def test_a_backlash_that_is_not_used_costs_no_steps(geometry: str, torque: float):
    def run(**more: float) -> gb.Response:
        mesh = {"stiffness": K, "damping_ratio": 0.05, **more}
        system = replace(SCENE, torque=torque, coupled=True, mesh=mesh).package()
        return system.simulate(0.05, 30.0, initial="static", geometry=geometry, rtol=1e-3)

    never, may_part = run(), run(backlash=BACKLASH)
    assert not may_part.events
    # steps with detection of separation would be half as long
    assert may_part.statistics.steps == never.statistics.steps


@pytest.mark.parametrize("geometry", ["frozen", "live"])
@pytest.mark.parametrize("stages", [1, 2, 3, 4])
def test_varying_stiffness_without_separation_gives_the_motion_without_backlash(
    geometry: str, stages: int
):
    """With backlash the linear part contains the shafts alone, otherwise also the mean mesh
    stiffness.
    """

    def run(**more: float) -> gb.Response:
        stiffness = {"model": "square", "pair": K / 2, "engagement": 0.2}
        mesh = {"stiffness": stiffness, "damping_ratio": 0.05, **more}
        system = replace(SCENE, torque=TORQUE, coupled=True, mesh=mesh).package()
        # some hundred steps with this tolerance stay below that of the test; one stage needs a
        # hundred times more steps
        rtol = 1e-6 if stages == 1 else 1e-9
        options = {"initial": "static", "geometry": geometry, "output_step": 2e-5}
        return system.simulate(2e-3, 150.0, rtol=rtol, stages=stages, **options)

    coupled, separable = run(), run(backlash=BACKLASH)
    assert not separable.events
    tolerance = 1e-4 if stages == 1 else 1e-6
    for found, wanted in (
        (separable.mesh(MESH).force, coupled.mesh(MESH).force),
        (separable.displacement("ga"), coupled.displacement("ga")),
        (separable.twist("gb"), coupled.twist("gb")),
    ):
        assert np.abs(found - wanted).max() < tolerance * np.ptp(wanted)


@pytest.mark.parametrize("amplitude", [1.002, 1.02, 1.05, 1.2])
@pytest.mark.parametrize("damping", [0.0, 1e-3])
@pytest.mark.parametrize("setting", [{"step": 0.45}, {"rtol": 1e-1}, {"rtol": 1e-3}])
def test_long_steps_detect_short_separations(
    amplitude: float, damping: float, setting: dict[str, float]
):
    """Separations of 1/100 to 1/4 of the oscillation period, with steps of up to half the period."""
    omega = np.sqrt(K / SCENE.effective_mass)
    system = replace(SCENE, mesh={**SCENE.mesh, "damping_ratio": damping}).package()
    period = 2 * np.pi / omega
    options: dict[str, Any] = dict(setting)
    if "step" in options:
        options["step"] *= period

    def events(**options: Any) -> list[str]:
        state = at_deflection(system, STATIC * (1 + amplitude), **options)
        # damping ends the separation after a few oscillations, so that the last ones graze
        run = system.simulate(3.3 * period, 0.0, initial=state, times=[3.3 * period], **options)
        return [event.kind for event in run.events]

    exact = events(method="rk45", rtol=1e-10)
    # the damping loss of one oscillation exceeds the margin of the smallest one
    assert len(exact) >= ((2 if amplitude > 1.01 else 0) if damping else 6)
    assert events(**options) == exact
