"""Runs of planets that move laterally on a carrier that turns, against equations in coordinates that do not turn."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

import gearbow as gb
from reference.carried import CarriedMesh, CarriedTrain, Pin
from reference.equations import Equations
from reference.internal import InternalLaw
from reference.mesh_law import MeshLaw

SUN, PLANET, RING = 24, 24, 72
TOOTH: dict[str, Any] = {"module": 3e-3, "pressure_angle": np.radians(20.0)}
ARM = 3e-3 * (SUN + PLANET) / 2
RATIO = SUN / (SUN + RING)
MESH, PIN, BEARING = 3e8, 1.5e8, 1e8
MESH_DAMPING, PIN_DAMPING, DAMPING = 2e3, 3e3, 4e3
UPRIGHT = 2e5
ANGLES = (0.0, 2 * np.pi / 3, 4 * np.pi / 3)


def base(teeth: int) -> float:
    return 3e-3 * teeth / 2 * np.cos(TOOTH["pressure_angle"])


def body(mass: float, radius: float) -> dict[str, float]:
    return {
        "mass": mass,
        "polar_inertia": mass * radius**2 / 2,
        "diametral_inertia": mass * radius**2 / 4,
    }


BODIES = {
    "sun": body(0.8, 0.036),
    "planet": body(0.8, 0.036),
    "ring": body(3.0, 0.12),
    "carrier": body(5.0, 0.08),
}


def shafts() -> list[gb.Shaft]:
    long = {"length": 0.3, "outer_diameter": 0.05, "elements": 2, "degree": 1}
    short = {"length": 0.1, "outer_diameter": 0.06, "elements": 2, "degree": 1}
    return [
        gb.Shaft("in", **long, bow=gb.Bow.half_sine(40e-6, phase=0.4)),
        gb.Shaft("out", **short, speed_ratio=0.0),
        gb.Shaft("arm", **short, bow=gb.Bow.half_sine(10e-6, phase=-0.3)),
    ]


def hold(name: str, x: float, stiffness: float = BEARING, damping: float = DAMPING) -> gb.Bearing:
    return gb.Bearing(name, x, stiffness=stiffness, damping=damping, tilting_stiffness=UPRIGHT)


def planetary(torque: float = 150.0, pin_errors: Any = None, **changes: Any) -> gb.RotorSystem:
    mesh = {"stiffness": MESH, "damping": MESH_DAMPING}
    stage = gb.PlanetaryStage(
        sun="sun",
        ring=gb.RingGear("ring", RING, "out", position=0.05, **TOOTH, **BODIES["ring"]),
        planets=3,
        carrier="carrier",
        planet=gb.Gear("planet", "pin", 0.02, teeth=PLANET, **TOOTH, **BODIES["planet"]),
        pin=gb.Shaft("pin", length=0.04, outer_diameter=0.04, elements=2, degree=1),
        bearing=hold("pin", 0.02, PIN, PIN_DAMPING),
        sun_mesh=gb.Mesh("sun", "planet", **mesh),
        ring_mesh=gb.Mesh("planet", "ring", **mesh),
        pin_errors=pin_errors,
    )
    parts: dict[str, Any] = {
        "shafts": shafts(),
        "gears": [
            gb.Gear("sun", "in", 0.15, teeth=SUN, **TOOTH, **BODIES["sun"], unbalance=2e-4 + 1e-4j)
        ],
        "disks": [gb.Disk("carrier", "arm", 0.05, **BODIES["carrier"], unbalance=3e-4j)],
        "bearings": [hold("in", 0.0), hold("in", 0.3), hold("out", 0.05), hold("arm", 0.05)],
        "drives": [gb.Drive("ring", 1e7, 2e3)],
        "torques": [gb.Torque("sun", torque), gb.Torque.balance("carrier")],
        "planetary_stages": [stage],
        "bow_torque": False,
    }
    return gb.RotorSystem(**(parts | changes))


#: Weight, large enough to be seen beside the other loads [m/s²].
GRAVITY = (60.0, -180.0)


def independent(speed: float, torque: float, live: bool, angles: Any = ANGLES) -> CarriedTrain:
    """State the train anew, with directions that turn."""
    # a shaft alone must turn
    ratios = {"in": 1.0, "out": 1e-9, "arm": RATIO, "pin": RATIO - (1.0 - RATIO) * SUN / PLANET}
    pin = gb.Shaft("pin", length=0.04, outer_diameter=0.04, elements=2, degree=1)
    numbers = range(1, len(angles) + 1)
    given = [replace(shaft, speed_ratio=ratios[shaft.name]) for shaft in shafts()]
    given += [replace(pin, name=f"pin {i}", speed_ratio=ratios["pin"]) for i in numbers]
    train = planetary(torque)
    sun = train.gears[0]
    disks = [
        *train.disks,
        gb.Disk("sun", "in", 0.15, **BODIES["sun"], unbalance=sun.unbalance),
        gb.Disk("ring", "out", 0.05, **BODIES["ring"]),
        *[gb.Disk(f"planet {i}", f"pin {i}", 0.02, **BODIES["planet"]) for i in numbers],
    ]
    free = gb.RotorSystem(
        shafts=given,
        disks=disks,
        bearings=[hold("in", 0.0), hold("in", 0.3), hold("out", 0.05), hold("arm", 0.05)],
        drives=[gb.Drive("ring", 1e7, 2e3)],
        torques=[gb.Torque("sun", torque), gb.Torque("carrier", -torque / RATIO)],
        motion="coupled",
    )
    gravity = GRAVITY if live else (0.0, 0.0)
    sigma = float(np.sign(speed))
    pins, meshes = [], []
    for i, angle in zip(numbers, angles, strict=True):
        place = (f"pin {i}", 0.02)
        arm = ARM * np.exp(1j * angle)
        pins.append(Pin(place, ("arm", 0.05), arm, PIN, PIN_DAMPING, UPRIGHT))
        both = {"stiffness": MESH, "damping": MESH_DAMPING}
        outer = MeshLaw(base(SUN), base(PLANET), ARM, angle, **both, sigma=sigma)
        inner = InternalLaw(base(PLANET), base(RING), ARM, angle + np.pi, **both, sigma=-sigma)
        meshes.append(CarriedMesh(("in", 0.15), place, outer))
        meshes.append(CarriedMesh(place, ("out", 0.05), inner))
    return CarriedTrain(free, speed, RATIO * speed, pins, meshes, live, gravity)


TIMES = np.linspace(0.0, 0.003, 31)
PLACES = {
    "sun": ("in", 0.15),
    "ring": ("out", 0.05),
    "carrier": ("arm", 0.05),
    "planet 1": ("pin 1", 0.02),
    "planet 2": ("pin 2", 0.02),
}


@cache
def reference(speed: float, live: bool) -> tuple[CarriedTrain, np.ndarray, np.ndarray]:
    train = independent(speed, 150.0 * np.sign(speed), live)
    return train, *train.from_rest(TIMES)


def off(found: np.ndarray, expected: np.ndarray) -> float:
    return float(np.abs(found - expected).max() / np.abs(expected).max())


@pytest.mark.parametrize(("speed", "live"), [(900.0, True), (-900.0, False)])
def test_a_run_is_that_of_the_equations_in_coordinates_that_do_not_turn(speed: float, live: bool):
    """Bow and unbalance turn at two speeds, pins and meshes with the carrier, and weight not at all."""
    model, q, v = reference(speed, live)
    train = planetary(150.0 * np.sign(speed), gravity=GRAVITY if live else 0.0)
    run = train.simulate(
        TIMES[-1],
        speed=speed,
        initial="rest",
        geometry="live" if live else "frozen",
        record=["gears", "disks", "meshes", "bearings", "velocity", "acceleration"],
        times=TIMES,
        rtol=1e-8,
    )
    for name, place in PLACES.items():
        at = [model.at[(*place, kind)] for kind in "vw"]
        assert off(run.displacement(name), q[:, at]) < 1e-5
        assert off(run.velocity(name), v[:, at]) < 1e-5
        twist = model.at[(*place, "twist")]
        assert off(run.twist(name), q[:, twist]) < 1e-5
    change = np.array([model.acceleration(*one) for one in zip(TIMES, q, v, strict=True)])
    for name in ("sun", "planet 1"):
        at = [model.at[(*PLACES[name], kind)] for kind in "vw"]
        assert off(run.acceleration(name)[1:], change[1:, at]) < 1e-4
    turns = np.exp(1j * model.carrier_speed * TIMES)
    states = list(zip(turns, q, v, strict=True))
    for number, mesh in enumerate(train.meshes):
        forces = [model.mesh_force(model.meshes[number], *state)[0] for state in states]
        found = run.mesh((mesh.driver, mesh.driven)).force
        assert off(found, np.array(forces)) < 1e-5
    pins = np.array([model.pin_force(model.pins[1], *state) for state in states])
    found = run.bearing_force(("pin 2", 0.02))
    assert off(found[:, 0] + 1j * found[:, 1], pins) < 1e-5
    at = [model.at["in", 0.0, kind] for kind in "vw"]
    assert off(run.bearing_force(("in", 0.0)), BEARING * q[:, at] + DAMPING * v[:, at]) < 1e-5


@pytest.fixture(scope="module")
def train() -> gb.RotorSystem:
    return planetary()


ALL = ["gears", "disks", "meshes", "bearings", "energy"]


def test_all_methods_give_the_same_run_and_the_energies_balance(train: gb.RotorSystem):
    """Energies are those relative to the carrier; the drive supplies the power of centrifugal forces."""
    shared: dict[str, Any] = {
        "speed": 900.0,
        "initial": "rest",
        "record": ALL,
        "times": TIMES,
    }
    runs = {
        method: train.simulate(TIMES[-1], method=method, **shared, **options)
        for method, options in (
            ("exponential", {"rtol": 1e-8}),
            ("rk45", {"rtol": 1e-8}),
            ("rk4", {"step": 4e-7}),
        )
    }
    first = runs.pop("exponential")
    balance = first.energy_balance()
    # no work is much larger than the energy
    scale = balance.total.max()
    assert np.abs(balance.drive).max() < 10.0 * scale
    assert np.abs(balance.residual).max() < 1e-7 * scale
    for run in runs.values():
        assert off(run.displacement("sun"), first.displacement("sun")) < 1e-5
        assert off(run.displacement("planet 1"), first.displacement("planet 1")) < 1e-5
        assert np.abs(run.energy_balance().residual).max() < 1e-5 * scale


@pytest.mark.parametrize(
    ("initial", "live", "near", "speed"),
    [
        ("static", False, 1e-7, -900.0),
        ("rest", False, 1e-3, 900.0),
        ("rest", True, 2e-2, -900.0),
    ],
)
def test_a_run_with_a_displaced_pin_keeps_or_reaches_the_equilibrium(
    initial: Any, live: bool, near: float, speed: float
):
    """Seen from the ground, the equilibrium turns with the carrier; forces of pins stay in the frame of the carrier.

    From rest, planets that move outwards delay the train by 2e-4 of its speed.
    """
    quiet = [replace(shaft, bow=None) for shaft in shafts()]
    errors = [50e-6j, 0.0, -20e-6]
    train = planetary(
        400.0 * np.sign(speed),
        errors,
        shafts=quiet,
        gears=[replace(planetary().gears[0], unbalance=0j)],
        disks=[replace(planetary().disks[0], unbalance=0j)],
    )
    still = train.static(speed=speed, geometry="frozen")
    duration = 0.3
    run = train.simulate(
        duration,
        speed=speed,
        initial=initial,
        geometry="live" if live else "frozen",
        record=["gears", "disks", "meshes", "bearings"],
        times=[duration],
    )
    turn = np.exp(1j * RATIO * speed * duration)
    behind = {"planet 1": 1j * ARM, "planet 3": 1j * ARM * np.exp(1j * ANGLES[2])}
    late = run.twist("carrier")[-1] - still.twist("carrier")
    assert (abs(late) > 1e-3) == (initial == "rest")
    for name in ("sun", "ring", "planet 1", "planet 3"):
        expected = complex(*still.displacement(name))
        found = complex(*run.displacement(name)[-1]) / turn - behind.get(name, 0.0) * late
        assert found == pytest.approx(expected, rel=near)
    shares = [still.mesh(("sun", f"planet {i}")).force for i in (1, 2, 3)]
    assert np.ptp(shares) > 0.2 * np.mean(shares)
    for mesh in train.meshes:
        pair = (mesh.driver, mesh.driven)
        assert run.mesh(pair).force[-1] == pytest.approx(still.mesh(pair).force, rel=near)
    for i in (1, 2, 3):
        at = (f"pin {i}", 0.02)
        found, expected = (
            complex(*force) for force in (run.bearing_force(at)[-1], still.bearing_force(at))
        )
        assert found == pytest.approx(expected, rel=near)
    ground = complex(*still.bearing_force(("in", 0.0))) * turn
    assert complex(*run.bearing_force(("in", 0.0))[-1]) == pytest.approx(ground, rel=near)


def circles(train: gb.RotorSystem, name: str, speed: float, times: np.ndarray) -> np.ndarray:
    """Give the equilibrium and the synchronous motion of a place, seen from the ground."""
    still = train.static(speed=speed, geometry="frozen")
    response = train.synchronous([speed])
    carrier = np.exp(1j * RATIO * speed * times)
    motion = np.full(len(times), complex(*still.displacement(name)))
    for (v, w), ratio in zip(response.displacement(name)[0], train.speed_ratios, strict=True):
        turn = np.exp(1j * (ratio - RATIO) * speed * times)
        motion += (v * turn).real + 1j * (w * turn).real
    return motion * carrier


@pytest.mark.parametrize("speed", [700.0, -700.0])
def test_synchronous_responses_are_those_in_the_frame_of_the_carrier(speed: float):
    """With linear meshes, a run from this motion stays in it: circles with the speeds of the sun and of the carrier."""
    train = planetary(150.0 * np.sign(speed))
    run = train.simulate(
        0.02,
        speed=speed,
        initial="synchronous",
        geometry="frozen",
        record=["gears", "disks", "bearings"],
        output_step=5e-4,
        method="rk45",
        rtol=1e-9,
    )
    for name in ("sun", "ring", "carrier", "planet 2"):
        found = run.displacement(name) @ [1.0, 1j]
        assert off(found, circles(train, name, speed, run.time)) < 1e-6


def test_responses_satisfy_the_equations_and_have_derivatives(train: gb.RotorSystem):
    speed, frequencies = 700.0, np.array([900.0, 4000.0])
    source = gb.Torque("sun", 10.0)
    found = train.frequency_response(frequencies, source=source, speed=speed)
    equations = Equations(train, speed)
    force = np.zeros(len(train.dofs))
    force[train.coordinates.twist("sun")] = 10.0
    for frequency, phasors in zip(frequencies, found.phasors, strict=True):
        expected = equations.response(frequency, force)
        assert phasors.ravel() == pytest.approx(
            expected, rel=1e-7, abs=1e-9 * np.abs(expected).max()
        )
    # the sun's bearing at rest sees the rotation of the frame
    u = found.displacement(("in", 0.0)).reshape(2, 2)
    rate = 1j * frequencies[:, None] * u + RATIO * speed * np.stack([-u[:, 1], u[:, 0]], axis=1)
    force = found.bearing_force(("in", 0.0)).reshape(2, 2)
    assert force == pytest.approx(BEARING * u + DAMPING * rate, rel=1e-9)


def test_derivatives_of_responses_are_differences(train: gb.RotorSystem):
    """The amplitude of unbalance follows the speed of the shaft, its frequency that relative to the carrier."""
    speed, at = 700.0, "sun"
    response = train.synchronous([speed])
    derivatives = train.sensitivity("bearings[0].stiffness", of=response, at=at)
    step = 1e-4 * BEARING

    def changed(change: float) -> np.ndarray:
        first, *others = train.bearings[:4]
        bearings = [replace(first, stiffness=BEARING + change), *others]
        return planetary(bearings=bearings).synchronous([speed]).displacement(at)

    expected = (changed(step) - changed(-step)) / (2.0 * step)
    assert off(derivatives.derivatives.reshape(expected.shape), expected) < 1e-5


@pytest.mark.parametrize(
    ("source", "message"),
    [
        (gb.Force("sun", 10.0), r'source\[0\]: has a fixed direction, .*by the shaft "in"'),
        (gb.GroundMotion(1e-6), r"source\[0\]: a lateral motion of the ground"),
    ],
)
def test_sources_with_a_direction_of_their_own_are_errors(
    train: gb.RotorSystem, source: Any, message: str
):
    with pytest.raises(gb.SceneError, match=message):
        train.frequency_response([1000.0], source=source, speed=100.0)


def test_section_forces_of_a_run_are_those_seen_from_the_ground():
    """At the left end of the shaft of the sun, the shear force is that of the bearing."""
    run = planetary().simulate(
        TIMES[-1],
        speed=900.0,
        initial="rest",
        record=[("in", 0.0), "bearings", "section_forces"],
        times=TIMES,
    )
    force = run.bearing_force(("in", 0.0))
    assert np.abs(force).max() > 100.0
    assert off(run.section_forces(("in", 0.0)).values[:, 1:3], force) < 1e-6


def test_a_steady_state_repeats_with_the_revolutions_of_the_carrier():
    """It is the motion that a long run reaches."""
    speed = 900.0
    holds = [gb.Drive("ring", 1e7, 2e3), gb.Drive("carrier", 1e5, 300.0)]
    train = planetary(drives=holds, torques=[gb.Torque("sun", 150.0)])
    steady = train.steady_state(speed, record=["gears", "meshes"], output_step=1e-3)
    assert steady.period == pytest.approx(2.0 * np.pi / (RATIO * speed), rel=1e-12)
    count = 10
    times = count * steady.period + steady.response.time
    run = train.simulate(times[-1], speed, record=["gears", "meshes"], times=times, rtol=1e-8)
    for name in ("sun", "planet 2"):
        assert off(steady.response.displacement(name), run.displacement(name)) < 1e-4
    mesh = ("sun", "planet 1")
    assert off(steady.response.mesh(mesh).force, run.mesh(mesh).force) < 1e-4


def helical(backlash: float | None) -> gb.RotorSystem:
    """Give the stage with helical teeth, whose pairs enter and leave the contact."""
    helix = TOOTH | {"face_width": 0.03, "helix_angle": 0.2}
    against = helix | {"helix_angle": -0.2}
    pairs = gb.Stiffness.parabolic(pair=2e8, end_ratio=0.6)
    mesh = {"stiffness": pairs, "damping_ratio": 0.05, "backlash": backlash}
    along = {"axial_stiffness": 5e7, "axial_damping": 2e3}
    stage = gb.PlanetaryStage(
        sun="sun",
        ring=gb.RingGear("ring", RING, "out", position=0.05, **against, **BODIES["ring"]),
        planets=3,
        carrier="carrier",
        planet=gb.Gear("planet", "pin", 0.02, teeth=PLANET, **against, **BODIES["planet"]),
        pin=gb.Shaft("pin", length=0.04, outer_diameter=0.04, elements=2, degree=1),
        bearing=replace(hold("pin", 0.02, PIN, PIN_DAMPING), **along),
        sun_mesh=gb.Mesh("sun", "planet", **mesh),
        ring_mesh=gb.Mesh("planet", "ring", **mesh),
        pin_errors=[30e-6j, 0.0, 10e-6],
    )
    given = planetary()
    sun = replace(given.gears[0], face_width=0.03, helix_angle=0.2)
    bearings = [replace(bearing, **along) for bearing in given.bearings[:4]]
    return planetary(gears=[sun], bearings=bearings, planetary_stages=[stage])


@pytest.mark.parametrize("backlash", [None, 60e-6])
def test_helical_tooth_pairs_move_with_the_carrier(backlash: float | None):
    """Forces follow from one energy: the audit of a run with moving lines of action closes."""
    train = helical(backlash)
    shared: dict[str, Any] = {
        "speed": 900.0,
        "initial": "rest",
        "record": ALL,
        "times": TIMES,
        "rtol": 1e-9,
    }
    run = train.simulate(TIMES[-1], **shared)
    balance = run.energy_balance()
    assert np.abs(balance.residual).max() < 1e-7 * balance.total.max()
    other = train.simulate(TIMES[-1], method="rk45", **shared)
    mesh = ("sun", "planet 2")
    assert np.ptp(run.mesh(mesh).pairs_in_contact) >= 1
    assert off(other.mesh(mesh).force, run.mesh(mesh).force) < 1e-5
    assert off(other.displacement("planet 1"), run.displacement("planet 1")) < 1e-5


def test_weight_turns_backwards_on_the_carrier():
    """It has a steady motion and no equilibrium; its work closes the audit."""
    train = planetary(gravity=GRAVITY)
    with pytest.raises(gb.SceneError, match=r"gravity: has a fixed direction, .*no equilibrium"):
        train.static(speed=900.0)
    run = train.simulate(TIMES[-1], 900.0, record=ALL, times=TIMES, geometry="frozen", rtol=1e-9)
    balance = run.energy_balance()
    assert np.abs(balance.gravity).max() > 0.0
    assert np.abs(balance.residual).max() < 1e-7 * balance.total.max()
    # a run begins with the steady motion under weight, which stands still
    sag = run.displacement("sun") - planetary().simulate(
        TIMES[-1], 900.0, record=ALL, times=TIMES, geometry="frozen", rtol=1e-9
    ).displacement("sun")
    assert np.ptp(sag, axis=0).max() < 1e-3 * np.abs(sag).max()
