"""Planetary stages whose carrier turns: speeds, torques, modes and runs against an independent torsional model."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import eigh

import gearbow as gb
from gearbow.orders import Kinematics

# Lumped models with rigid, massless shafts, so that most values are implausible.
pytestmark = pytest.mark.implausible

ALPHA = np.radians(20.0)
MODULE = 3e-3
SUN, PLANET, RING, COUNT = 24, 30, 84, 3
TOOTH: dict[str, Any] = {"module": MODULE, "face_width": 0.03}
STIFFNESS = {"sun": 4e8, "ring": 6e8}  # of the meshes [N/m]
DAMPING = 3e3  # of every mesh [N s/m]
HOLD, HOLD_DAMPING = 2e7, 50.0  # of the ring [N m/rad, N m s/rad]
INERTIA = {"sun": 0.02, "planet": 0.008, "ring": 0.4, "carrier": 0.3}  # [kg m²]
MASS = 2.0  # of a planet [kg]
RIGID = gb.Material(youngs_modulus=207e9, density=1.0, poisson_ratio=0.3)
DISTANCE = MODULE * (SUN + PLANET) / 2
#: Coordinates of the independent model.
TWISTS = ("sun", "ring", "carrier", *(f"planet {i + 1}" for i in range(COUNT)))


def base(teeth: int) -> float:
    return MODULE * teeth / 2 * np.cos(ALPHA)


def body(kind: str, mass: float = 1.0) -> dict[str, float]:
    return {"mass": mass, "polar_inertia": INERTIA[kind], "diametral_inertia": INERTIA[kind]}


def shaft(name: str, **changes: Any) -> gb.Shaft:
    return gb.Shaft(name, length=0.02, outer_diameter=0.02, material=RIGID, elements=2, **changes)


def stage(drives: str = "sun", **changes: Any) -> gb.PlanetaryStage:
    """Give a stage with a ring at rest; `drives` is the gear from which the power flows, relative to the carrier."""
    pairs = {
        "sun": ("sun", "planet", "planet", "ring"),
        "ring": ("planet", "sun", "ring", "planet"),
    }
    a, b, c, d = pairs[drives]
    given: dict[str, Any] = {
        "sun": "sun",
        "ring": gb.RingGear(
            "ring",
            RING,
            **TOOTH,
            **body("ring"),
            rotational_stiffness=HOLD,
            rotational_damping=HOLD_DAMPING,
        ),
        "planets": COUNT,
        "carrier": "carrier",
        "planet": gb.Gear("planet", "pin", 0.01, teeth=PLANET, **TOOTH, **body("planet", MASS)),
        "pin": shaft("pin"),
        "sun_mesh": gb.Mesh(a, b, stiffness=STIFFNESS["sun"], damping=DAMPING),
        "ring_mesh": gb.Mesh(c, d, stiffness=STIFFNESS["ring"], damping=DAMPING),
    }
    return gb.PlanetaryStage(**(given | changes))


def system(given: gb.PlanetaryStage | None = None, **changes: Any) -> gb.RotorSystem:
    parts: dict[str, Any] = {
        "shafts": [shaft("in"), shaft("out")],
        "gears": [gb.Gear("sun", "in", 0.01, teeth=SUN, **TOOTH, **body("sun"))],
        "disks": [gb.Disk("carrier", "out", 0.01, 1.0, INERTIA["carrier"], INERTIA["carrier"])],
        "planetary_stages": [given or stage()],
        "motion": "torsion",
    }
    return gb.RotorSystem(**(parts | changes))


def ratios(train: gb.RotorSystem) -> dict[str, float]:
    names = (each.name for each in train.shafts)
    return dict(zip(names, train.speed_ratios, strict=True))


class Independent:
    """Angles of sun, ring, carrier and planets about their own axes, with rigid pins; the planets orbit with the carrier."""

    def __init__(self) -> None:
        orbit = COUNT * MASS * DISTANCE**2
        planets = [INERTIA["planet"]] * COUNT
        inertia = [INERTIA["sun"], INERTIA["ring"], INERTIA["carrier"] + orbit, *planets]
        self.mass = np.diag(inertia)
        self.rows, self.springs = [], []
        for i in range(COUNT):
            # velocity of the teeth of the driver minus that of the driven gear on the line of action, seen from the carrier
            for row in ((base(SUN), 0.0, base(PLANET)), (0.0, -base(RING), base(PLANET))):
                sun, ring, planet = row
                full = np.zeros(3 + COUNT)
                full[0], full[1], full[3 + i] = sun, ring, planet
                full[2] = -(sun + ring + planet)
                self.rows.append(full)
                self.springs.append(STIFFNESS["sun" if sun else "ring"])
        rows = np.array(self.rows)
        self.stiffness = rows.T @ np.diag(self.springs) @ rows
        self.damping = DAMPING * rows.T @ rows
        self.stiffness[1, 1] += HOLD
        self.damping[1, 1] += HOLD_DAMPING


def test_speeds_are_those_of_willis():
    one = ratios(system())
    assert one["out"] == pytest.approx(SUN / (SUN + RING), rel=1e-15)
    assert one["ring mount"] == 0.0
    planet = one["out"] - (1.0 - one["out"]) * SUN / PLANET
    assert one["pin 1"] == pytest.approx(planet, rel=1e-14)
    copied = gb.RotorSystem.from_dict(system().description)
    assert (copied.meshes, copied.disks) == (system().meshes, system().disks)
    # the carrier is the reference
    other = ratios(system(reference="out"))
    assert other["in"] == pytest.approx(1.0 + RING / SUN, rel=1e-15)


def test_a_sun_at_rest_and_three_turning_members():
    ring = gb.RingGear("ring", RING, "in", position=0.015, **TOOTH, **body("ring"))
    shafts = [shaft("in"), shaft("out"), shaft("fixed", speed_ratio=0.0)]
    gears = [gb.Gear("sun", "fixed", 0.01, teeth=SUN, **TOOTH, **body("sun"))]
    drives = [gb.Drive("sun", HOLD)]
    train = system(stage("ring", ring=ring), shafts=shafts, gears=gears, drives=drives)
    assert ratios(train)["out"] == pytest.approx(RING / (SUN + RING), rel=1e-15)
    shafts[2] = shaft("fixed", speed_ratio=-0.5)
    train = system(stage("ring", ring=ring), shafts=shafts, gears=gears, drives=drives)
    assert ratios(train)["out"] == pytest.approx((RING - 0.5 * SUN) / (SUN + RING), rel=1e-15)


def test_two_stages_in_a_row_multiply_their_ratios():
    second = stage(
        sun="sun 2",
        ring=gb.RingGear("ring 2", RING, **TOOTH, **body("ring"), rotational_stiffness=HOLD),
        carrier="carrier 2",
        planet=gb.Gear("moon", "pin", 0.01, teeth=PLANET, **TOOTH, **body("planet")),
        pin=shaft("moon pin"),
        sun_mesh=gb.Mesh("sun 2", "moon", stiffness=4e8),
        ring_mesh=gb.Mesh("moon", "ring 2", stiffness=4e8),
    )
    gears = [
        gb.Gear(name, at, 0.01, teeth=SUN, **TOOTH, **body("sun"))
        for name, at in (("sun", "in"), ("sun 2", "out"))
    ]
    disks = [
        gb.Disk(name, at, 0.015, 1.0, 0.3, 0.3)
        for name, at in (("carrier", "out"), ("carrier 2", "end"))
    ]
    train = system(
        shafts=[shaft("in"), shaft("out"), shaft("end")],
        gears=gears,
        disks=disks,
        planetary_stages=[stage(), second],
        torques=[gb.Torque("sun", 10.0), gb.Torque.balance("carrier 2")],
    )
    ratio = SUN / (SUN + RING)
    assert ratios(train)["end"] == pytest.approx(ratio**2, rel=1e-14)
    forces = train.static(speed=10.0).mesh(("moon 2", "ring 2")).force
    assert forces == pytest.approx(10.0 / ratio / base(SUN) / COUNT, rel=1e-9)
    # one rigid-body motion: the rotation of the train
    assert np.sum(train.modes(0.0, count=6).frequencies_hz < 1e-3) == 1


@pytest.mark.parametrize("drives", ["sun", "carrier"])
@pytest.mark.parametrize("speed", [40.0, -40.0])
def test_torques_of_all_members_balance_and_power_is_conserved(drives: str, speed: float):
    torque = 200.0 * np.sign(speed)
    other = "carrier" if drives == "sun" else "sun"
    train = system(
        stage("sun" if drives == "sun" else "ring"),
        torques=[gb.Torque(drives, torque), gb.Torque.balance(other)],
    )
    ratio = SUN / (SUN + RING)
    of_sun, of_carrier = (torque, -torque / ratio) if drives == "sun" else (-torque * ratio, torque)
    found = train.static(speed=speed)
    for mesh in train.meshes:
        force = found.mesh((mesh.driver, mesh.driven)).force
        assert force == pytest.approx(abs(of_sun) / base(SUN) / COUNT, rel=1e-9)
    # the support of the ring takes the rest
    assert -HOLD * found.twist("ring") == pytest.approx(-of_sun - of_carrier, rel=1e-9)
    assert of_sun * speed + of_carrier * speed * ratio == pytest.approx(0.0, abs=1e-9)


def test_modes_are_those_of_the_independent_model():
    pairs = [("sun", "planet"), ("planet", "ring")]
    sun, ring = (gb.Mesh(*pair, stiffness=STIFFNESS[pair[i]]) for i, pair in enumerate(pairs))
    held = gb.RingGear("ring", RING, **TOOTH, **body("ring"), rotational_stiffness=HOLD)
    train = system(stage(ring=held, sun_mesh=sun, ring_mesh=ring))
    model = Independent()
    expected = np.sqrt(np.abs(eigh(model.stiffness, model.mass, eigvals_only=True))) / (2 * np.pi)
    for speed in (0.0, 500.0):
        found = train.modes(speed, count=3 + COUNT)
        assert found.frequencies_hz[0] < 1e-3
        assert found.frequencies_hz[1:] == pytest.approx(expected[1:], rel=1e-6)


@pytest.fixture(scope="module")
def driven() -> gb.RotorSystem:
    """Give a train whose teeth have errors in the phases of the planets."""
    error = gb.TransmissionError(tooth=[(4e-6, 0.3)])
    return system(
        stage(
            sun_mesh=gb.Mesh(
                "sun", "planet", stiffness=STIFFNESS["sun"], damping=DAMPING, error=error
            )
        ),
        torques=[gb.Torque("sun", 200.0), gb.Torque.balance("carrier")],
    )


@pytest.mark.parametrize("speed", [30.0, -30.0])
def test_a_run_is_that_of_the_independent_model(driven: gb.RotorSystem, speed: float):
    """The meshes see the angles relative to the carrier, in their frequency z (Ω_sun − Ω_carrier) and in their deflections."""
    duration = 0.02
    run = driven.simulate(
        duration, speed=speed, initial="static", rtol=1e-9, output_step=1e-4, record=[*TWISTS]
    )
    model = Independent()
    sense = np.sign(speed)
    tooth = SUN * speed * (1.0 - SUN / (SUN + RING))
    load = np.zeros(3 + COUNT)
    load[0], load[2] = 200.0, -200.0 * (SUN + RING) / SUN

    def rate(t: float, state: np.ndarray) -> np.ndarray:
        q, v = np.split(state, 2)
        force = load - model.stiffness @ q - model.damping @ v
        # the error reduces the deflection along the loaded flank
        error = 4e-6 * np.cos(tooth * t + 0.3)
        slope = -4e-6 * tooth * np.sin(tooth * t + 0.3)
        for row, spring in zip(model.rows[::2], model.springs[::2], strict=True):
            force = force + sense * row * (spring * error + DAMPING * slope)
        return np.concatenate([v, force / np.diag(model.mass)])

    # the static twists, of which the rigid-body rotation is that of the run
    start = np.array([float(run.twist(name)[0]) for name in TWISTS])
    solved = solve_ivp(
        rate,
        (0.0, duration),
        np.concatenate([start, np.zeros(3 + COUNT)]),
        method="RK45",
        t_eval=run.time,
        rtol=1e-9,
        atol=1e-15,
    )
    for i, name in enumerate(TWISTS):
        assert run.twist(name) == pytest.approx(solved.y[i], abs=1e-5 * np.ptp(solved.y[0]))


def test_the_energy_audit_closes_during_a_run_up_with_tooth_pairs():
    square = gb.Stiffness.square(pair=3e8)
    train = system(
        stage(
            sun_mesh=gb.Mesh("sun", "planet", stiffness=square, damping=DAMPING, backlash=5e-5),
            ring_mesh=gb.Mesh("planet", "ring", stiffness=square, damping=DAMPING, friction=0.05),
        ),
        torques=[gb.Torque("sun", 200.0), gb.Torque.balance("carrier")],
    )
    profile = gb.SpeedProfile.ramp(20.0, 60.0, 0.02)
    places = ["sun", "carrier", "planet 2", "ring"]
    options = {"speed": profile, "initial": "static", "rtol": 1e-8, "record": [*places, "energy"]}
    run = train.simulate(0.02, **options)
    balance = run.energy_balance()
    assert np.abs(balance.residual).max() < 1e-7 * np.abs(balance.total).max()
    rk45 = train.simulate(0.02, method="rk45", **options)
    for name in places:
        scale = np.ptp(rk45.twist(name))
        assert run.twist(name) == pytest.approx(rk45.twist(name), abs=1e-5 * scale)


def test_the_mesh_period_and_the_lines_are_relative_to_the_carrier():
    square = gb.Stiffness.square(pair=3e8)
    train = system(
        stage(sun_mesh=gb.Mesh("sun", "planet", stiffness=square, damping_ratio=0.1)),
        torques=[gb.Torque("sun", 200.0), gb.Torque.balance("carrier")],
    )
    order = SUN * RING / (SUN + RING)
    assert train.steady_state(speed=100.0).period == pytest.approx(2 * np.pi / 100.0 / order)
    lines = train.campbell([10.0, 100.0], count=2).lines
    assert [line.order for line in lines if line.kind == "mesh"] == pytest.approx(
        [order] * len(train.meshes)
    )
    assert all(line.order > 0.0 for line in lines)
    found = Kinematics.of(train)
    assert [mesh[-1] for mesh in found.meshes] == pytest.approx([order] * len(train.meshes))
    assert all(each.value > 0.0 for each in found.orders())
    response = train.mesh_response("sun/planet 1", error=1e-6, speeds=[100.0])
    assert response.frequencies == pytest.approx([order * 100.0])
    rows = train._repr_html_().split("<tr><td>")[1:]
    with_gears = [row for row in rows if "(" in row]
    assert len(with_gears) == len({gear.shaft for gear in train.gears})
    assert all(f">{order:.6g}<" in row for row in with_gears)


def test_in_a_bending_train_a_stage_couples_the_shafts_in_torsion():
    bearings = [
        gb.Bearing(name, x, stiffness=1e8, damping=1e3)
        for name in ("in", "out")
        for x in (0.0, 0.2)
    ]
    shafts = [gb.Shaft(name, length=0.2, outer_diameter=0.08, elements=8) for name in ("in", "out")]
    bent = system(shafts=shafts, bearings=bearings, motion=None)
    kinds = {(name, kind) for name, _, kind in bent.dofs}
    assert ("pin 1", "v") not in kinds
    assert ("in", "v") in kinds
    torsion = system(shafts=shafts).modes(0.0, count=6).frequencies_hz
    found = bent.modes(0.0, count=14).frequencies_hz
    for frequency in torsion[1:5]:
        assert np.abs(found - frequency).min() < 1e-6 * frequency


def test_tables_and_stresses_know_shafts_that_only_twist_and_a_ring_at_rest():
    machine = gb.examples()["wind_turbine"]
    train, speed = machine.load(), machine.speed
    places = train.static(speed).to_dataframe()["place"]
    assert "wheel 2" in set(places)
    assert not {"ring", "planet 1"} & set(places)
    stresses = train.stresses(speed).to_dataframe()
    assert set(stresses["shaft"]) >= {"low speed", "ring mount"}
    numbers = stresses.select_dtypes("number").drop(columns="utilisation", errors="ignore")
    assert np.isfinite(numbers.to_numpy()).all()


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (
            {"ring": gb.RingGear("ring", RING, **TOOTH)},
            r"planetary_stages\[0\]\.ring\.rotational_stiffness: a ring on the ground needs",
        ),
        (
            {"ring": gb.RingGear("ring", RING, "in", **TOOTH, rotational_stiffness=1e7)},
            r"planetary_stages\[0\]\.ring\.rotational_stiffness: is for a ring on the ground",
        ),
        ({"carrier": "out"}, r'planetary_stages\[0\]\.carrier: "out" is a shaft: give the disk'),
        (
            {"carrier": ("in", 0.01)},
            r'meshes\[0\]\.carrier: stands on the shaft "in" of the gear "sun"',
        ),
        (
            {"bearing": gb.Bearing("pin", 0.01, stiffness=1e8)},
            r'bearings\[0\]: is that of a planet on a carrier that turns, and motion="torsion"',
        ),
        ({"planets": 6}, r"planetary_stages\[0\]\.planets: planets 1 and 2 overlap"),
    ],
)
def test_impossible_stages_are_errors(changes: dict[str, Any], message: str):
    with pytest.raises(gb.SceneError, match=message):
        system(stage(**changes))


def test_what_a_turning_carrier_cannot_have_is_an_error():
    held = [gb.Bearing(name, x, stiffness=1e8) for name in ("in", "out") for x in (0.0, 0.02)]
    with pytest.raises(
        gb.SceneError, match=r"carrier: turns, and its planets do not stand at equal"
    ):
        system(stage(planets=[0.0, np.pi / 3 * 2]), bearings=held, motion="coupled")
    sun = gb.Gear("sun", "in", 0.01, teeth=SUN, **TOOTH, **body("sun"), runout=1e-5)
    with pytest.raises(gb.SceneError, match=r'carrier: the gear "sun" has run-out'):
        system(gears=[sun])
    torques = [gb.Torque("sun", 1.0), gb.Torque.balance("ring")]
    with pytest.raises(gb.SceneError, match=r'torques\[1\]: "ring mount" does not turn'):
        system(torques=torques)
    ring = gb.RingGear("ring", RING, "free", position=0.01, **TOOTH, **body("ring"))
    with pytest.raises(gb.SceneError, match=r"two speeds must be known"):
        system(stage(ring=ring), shafts=[shaft("in"), shaft("out"), shaft("free")])
