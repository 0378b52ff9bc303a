"""The exponential method is exact for linear motion, for every step length."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import gearbow as gb
from reference.bows import HalfSine
from reference.linear import LinearTrain
from reference.scenes import CHAIN, PAIR, GearAt, Geared, single_shaft

Array = np.ndarray
SHAFT = Geared(
    shafts=("s",),
    gears=(GearAt("g", "s", 0.125, 25, unbalance=1e-3 * np.exp(1j)),),
    meshes=(),
    angles=(),
    ratios=(1.0,),
    torque=0.0,
    bows={"s": HalfSine(1e-4, 0.5)},
    gravity=(0.0, -9.81),
)
UNDAMPED = replace(SHAFT, bearing_damping=0.0)
BENT_PAIR = replace(PAIR, bows={"input": HalfSine(1e-4), "output": HalfSine(5e-5, 1.0)})
SCENES = {
    "shaft": SHAFT,
    "undamped shaft": UNDAMPED,
    "free shaft": replace(UNDAMPED, bearing_stiffness=0.0),
    "free shaft in oil": replace(SHAFT, bearing_stiffness=0.0),
    "pair": BENT_PAIR,
    "chain": replace(
        CHAIN, bows={"s1": HalfSine(1e-4), "s3": HalfSine(1e-5, 2.0)}, gravity=(1.0, -9.81)
    ),
}


def linear(scene: Geared, speed: float) -> LinearTrain:
    """Return the independent assembly in the coordinates of the package; the loaded flank follows
    the sense of rotation.
    """
    train = replace(scene, sigma=-1.0 if speed < 0.0 else 1.0).reference()
    places = {dof: i for i, dof in enumerate(train.dofs())}
    keep = np.array([places[tuple(dof)] for dof in scene.package().dofs])
    sub = np.ix_(keep, keep)
    stiffness, damping = train.linear()
    return LinearTrain(
        train.mass[sub],
        (damping + speed * train.gyroscopic)[sub],
        stiffness[sub],
        train.steady_force()[keep],
        [(spin, a[keep], b[keep]) for spin, a, b in train.turning_force(speed)],
    )


def gap(system: gb.RotorSystem, found: gb.Response, q: Array) -> float:
    """Return the largest relative difference of translations and of twists at all nodes."""
    worst = 0.0
    for kinds in ({"v": 0, "w": 1}, {"twist": None}):
        at = [(i, dof) for i, dof in enumerate(system.dofs) if dof[2] in kinds]
        scale = max((np.abs(q[:, i]).max() for i, _ in at), default=0.0)
        for i, (shaft, x, kind) in at if scale > 0.0 else []:
            lane = kinds[kind]
            node = (shaft, x)
            series = found.twist(node) if lane is None else found.displacement(node)[:, lane]
            worst = max(worst, float(np.abs(series - q[:, i]).max()) / scale)
    return worst


@pytest.mark.parametrize("speed", [0.0, 300.0, -300.0, 3000.0])
@pytest.mark.parametrize("name", SCENES)
def test_a_linear_motion_is_exact_whatever_the_step(name: str, speed: float):
    scene, times = SCENES[name], np.linspace(0.0, 0.02, 41)
    system, exact = scene.package(), linear(scene, speed)
    at_rest = np.zeros(len(system.dofs))
    q, _ = exact.motion(times, at_rest, at_rest)
    runs: list[dict[str, Any]] = [{}, {"step": 1e-3}, {"step": 7e-5}, {"step": 3e-4, "stages": 1}]
    for options in [*runs, {"rtol": 0.1}, {"rtol": 1e-13}]:
        found = system.simulate(
            0.02,
            speed,
            initial="rest",
            geometry="frozen",
            times=times,
            record=["nodes"],
            **options,
        )
        # eps (omega_max / omega)^2, the agreement of frequencies of two assemblies, times a few
        # oscillations
        assert gap(system, found, q) < 2e-10, options


@pytest.mark.parametrize("step", [None, 5e-3])
def test_a_synchronous_start_stays_synchronous(step: float | None):
    system, speed = SHAFT.package(), 500.0
    found = system.simulate(0.2, speed, step=step, times=np.linspace(0, 0.2, 57), record=["g"])
    amplitude = system.synchronous([speed]).displacement("g")[0, 0]
    turn = np.exp(1j * speed * found.time)
    exact = np.asarray(system.static().displacement("g")) + (amplitude * turn[:, None]).real
    # the motion is purely synchronous: only round-off differs
    assert np.abs(found.displacement("g") - exact).max() < 1e-12 * np.abs(exact).max()


# --- rigid-body motion ---------------------------------------------------------------------------


def test_a_free_shaft_falls():
    system = single_shaft(support=None, gravity=[3.0, -9.81])
    times = np.array([0.0, 0.013, 0.5, 20.0])
    found = system.simulate(20.0, 100.0, initial="rest", times=times, record=["nodes"])
    for _, x, _ in system.dofs:
        # equal at all nodes up to round-off
        way = np.array([3.0, -9.81]) * times[:, None] ** 2 / 2
        assert found.displacement(("s", x)) == pytest.approx(way, rel=1e-11, abs=1e-13)


@pytest.mark.parametrize("geometry", ["live", "frozen"])
def test_an_unbalanced_torque_accelerates_the_train(geometry: str):
    scene = replace(PAIR, torque=0.0, options={"motion": "torsion"})
    package = scene.package()
    system = gb.RotorSystem(
        shafts=package.shafts,
        gears=package.gears,
        meshes=package.meshes,
        torques=[gb.Torque("g1", 40.0)],
        motion="torsion",
    )
    matrices = system.matrices()
    rolling = np.array([1.0 if dof[0] == "input" else -0.5 for dof in system.dofs])
    inertia = rolling @ matrices.mass @ rolling
    times = np.linspace(0.0, 0.5, 9)
    found = system.simulate(
        0.5, 100.0, initial="rest", geometry=geometry, times=times, record=["nodes"]
    )
    q = np.column_stack([found.twist((shaft, x)) for shaft, x, _ in system.dofs])
    rolled = q @ matrices.mass @ rolling / inertia
    # the rigid-body rotation is not coupled to the other modes: exact
    assert rolled == pytest.approx(40.0 / inertia * times**2 / 2, rel=1e-11)


# --- critical speeds ------------------------------------------------------------------------------


def critical(system: gb.RotorSystem, number: int) -> float:
    """Find a forward critical speed by fixed-point iteration of the mode frequency."""
    speed = 0.0
    for _ in range(60):
        modes = system.modes(speed=speed, count=2 * number + 2)
        speed = 2 * np.pi * modes.frequencies_hz[2 * number + 1]
    return float(speed)


@pytest.mark.parametrize("number", [0, 1])
@pytest.mark.parametrize("off", [0.0, 1e-7, -5e-6, 2e-5])
def test_a_run_at_an_undamped_critical_speed(number: int, off: float):
    system = UNDAMPED.package()
    speed = critical(system, number) * (1 + off)
    at_rest = np.zeros(len(system.dofs))
    times = np.linspace(0.0, 40 * 2 * np.pi / speed, 41)
    q, _ = linear(UNDAMPED, speed).motion(times, at_rest, at_rest)
    found = system.simulate(times[-1], speed, initial="rest", times=times, record=["nodes"])
    # rotating loads are polynomials over 1/64 revolution: (2 pi / 64)^6 / 1e4; where the
    # synchronous motion contains bow and unbalance, the error is 1 / off times the motion
    assert gap(system, found, q) < 1e-8
    size = np.abs(found.displacement("g")).max(axis=1)
    if off == 0.0:
        # the resonant part dominates and grows in proportion to time
        assert size[40] / size[20] == pytest.approx(2.0, rel=0.1)
        assert size[40] > 10 * size[1]


def test_there_is_no_synchronous_motion_at_an_undamped_critical_speed():
    system = UNDAMPED.package()
    with pytest.raises(gb.GearbowError, match=r"^initial: "):
        system.simulate(1e-2, critical(system, 0), initial="synchronous")


# --- instability ----------------------------------------------------------------------------------


def test_cross_coupled_bearings_grow_at_the_rate_of_their_eigenvalue():
    stiffness = [[5e7, 2e7], [-2e7, 5e7]]
    scene = replace(SHAFT, bearing_stiffness=stiffness, bearing_damping=2e3, gravity=None)
    system, speed = scene.package(), 250.0
    modes = system.modes(speed=speed)
    growth = modes.eigenvalues.real.max()
    assert growth > 10.0  # unstable
    times = np.linspace(0.0, 12.0 / growth, 481)
    found = system.simulate(times[-1], speed, initial="rest", times=times, record=["nodes"])
    at_rest = np.zeros(len(system.dofs))
    q, _ = linear(scene, speed).motion(times, at_rest, at_rest)
    # frequency difference of the two assemblies over many periods
    assert gap(system, found, q) < 1e-9
    # the synchronous part is negligible after growth by e^12
    size = np.log(np.hypot(*found.displacement(("s", 0.0)).T))
    rate = np.polyfit(times[240:], size[240:], 1)[0]
    assert rate == pytest.approx(growth, rel=1e-2)


# --- damping --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "options",
    [{}, {"method": "rk4", "step": 5e-8}, {"method": "rk45", "rtol": 1e-11}],
    ids=["exponential", "rk4", "rk45"],
)
@pytest.mark.parametrize("speed", [0.0, 200.0])
def test_modal_damping_is_that_of_the_matrices(speed: float, options: dict[str, Any]):
    scene = replace(BENT_PAIR, elements=2, modal_damping=0.03)
    system = scene.package()
    train, given = linear(scene, speed), system.matrices()
    assert np.abs(given.damping - given.damping.T).max() < 1e-9 * np.abs(given.damping).max()
    exact = replace(train, damping=given.damping + speed * given.gyroscopic)
    at_rest, times = np.zeros(len(system.dofs)), np.linspace(0.0, 2e-3, 21)
    q, _ = exact.motion(times, at_rest, at_rest)
    found = system.simulate(
        2e-3,
        speed,
        initial="rest",
        geometry="frozen",
        times=times,
        record=["nodes"],
        **options,
    )
    # tolerance and step; the damping matrix is a product of all modes, which loses one or two
    # digits
    assert gap(system, found, q) < 1e-8
