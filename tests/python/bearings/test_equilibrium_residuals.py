"""Static equilibria: forces and moments balance on every shaft, and the matrices are their derivatives.

`make random` tries 1,000 random scenes; `make test` takes the first hundred.
"""

from __future__ import annotations

import math
import os
from collections import Counter
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

import gearbow as gb
from reference.machines import rotor_on_films

Array = np.ndarray
pytestmark = pytest.mark.implausible

SCENES = 100 * int(os.environ.get("GEARBOW_CASES", "1"))
OIL = {"diameter": 0.05, "length": 0.02, "clearance": 5e-5, "viscosity": 0.02}
STEEL = gb.Material(2.07e11, 7850.0, poisson_ratio=0.3)
#: Unbalanced force over the load; Newton's method leaves round-off of about 1e-12.
TOLERANCE = 1e-6


# --- a rotor on oil films -----------------------------------------------------------------------


def test_each_bearing_carries_half_the_weight_at_every_speed():
    system = rotor_on_films()
    weight = 9.81 * (40.0 + STEEL.density * math.pi / 4 * 0.05**2 * 0.5)
    for speed in np.linspace(50.0, 1340.0, 130):
        for static in (system.static(speed=speed), system.static(geometry="frozen", speed=-speed)):
            for place in (0.0, 0.5):
                force = static.bearing_force(("r", place))
                np.testing.assert_allclose(force, [0.0, -weight / 2], atol=1e-6 * weight)
            assert static.residual <= 1e-9, speed


def test_the_matrices_belong_to_the_static_equilibrium():
    # The first call on a system may be any analysis: all stand on the same displacements.
    for speed in (300.0, 340.0, 350.0, 400.0):
        first, second = rotor_on_films(), rotor_on_films()
        matrices, static = first.matrices(speed), second.static(speed=speed)
        assert np.array_equal(first.static(speed=speed).state, static.state)
        assert np.array_equal(second.matrices(speed).stiffness, matrices.stiffness)


def test_the_result_has_a_residual_of_each_shaft_and_support():
    support = gb.Support("pedestal", mass=3.0, stiffness=(4e6, 2e6))
    bearings = [
        gb.Bearing("r", 0.0, stiffness=1e7, support=support),
        gb.Bearing("r", 0.5, stiffness=1e7),
    ]
    system = rotor_on_films(bearings=bearings)
    static = system.static()
    assert set(static.residuals) == {"r", "pedestal"}
    assert static.residual == max(static.residuals.values()) <= 1e-12
    # Without a load nothing is unbalanced.
    assert system.replace(gravity=0.0).static().residual == 0.0


# --- random scenes ------------------------------------------------------------------------------


@dataclass
class Balance:
    """Forces [N] and moments about the left end [N m] on one shaft, and the sums of their sizes."""

    length: float
    force: Array = field(default_factory=lambda: np.zeros(3))
    moment: Array = field(default_factory=lambda: np.zeros(3))
    load: float = 0.0

    def add(self, place: float, force: Any, moment: Any = (0.0, 0.0, 0.0)) -> None:
        """Add a force over (x, y, z) at a place of the axis, and a moment."""
        force, moment = np.asarray(force), np.asarray(moment)
        self.force += force
        self.moment += moment + np.cross([place, 0.0, 0.0], force)
        self.load += np.linalg.norm(force) + np.linalg.norm(moment) / self.length

    @property
    def residual(self) -> float:
        """Largest unbalanced force, or moment over the length, over the load."""
        unbalanced = np.abs(self.force).max(), np.abs(self.moment).max() / self.length
        return float(max(unbalanced)) / self.load


def bearing(rng: np.random.Generator, kind: str, shaft: str, place: float, **more: Any) -> Any:
    """Give a bearing of a kind on a shaft."""
    stiffness = 10 ** rng.uniform(6.5, 8.5)
    match kind:
        case "linear":
            return gb.Bearing(
                shaft, place, stiffness=(stiffness, 0.6 * stiffness), damping=500.0, **more
            )
        case "cross":
            k = stiffness * np.array([[1.0, 0.4], [-0.5, 0.8]])
            return gb.Bearing(shaft, place, stiffness=k, damping=500.0, **more)
        case "table":
            speeds = [0.0, 300.0, 3000.0]
            table = gb.SpeedTable(speeds, [stiffness, 1.5 * stiffness, 3.0 * stiffness])
            return gb.Bearing(shaft, place, stiffness=table, damping=500.0, **more)
        case "ball" | "roller":
            roller = {"contact": "roller", "roller_length": 0.015} if kind == "roller" else {}
            return gb.RollingBearing(
                shaft,
                place,
                elements=int(rng.integers(6, 15)),
                element_diameter=0.015,
                pitch_diameter=0.075,
                clearance=float(rng.choice([0.0, 2e-5, -5e-6])),
                damping=500.0,
                phase=rng.uniform(0.0, 1.0),
                **roller,
                **more,
            )
    film = {"film": "finite"} if kind == "finite" else {}
    length, clearance = (
        (0.025 if kind == "finite" else rng.uniform(0.015, 0.03)),
        rng.uniform(3e-5, 8e-5),
    )
    oil = {"diameter": 0.05, "length": length, "clearance": clearance}
    return gb.JournalBearing(
        shaft, place, viscosity=10 ** rng.uniform(-2.0, -0.7), **oil, **film, **more
    )


KINDS = ("linear", "cross", "table", "short", "short", "finite", "ball", "roller")


def scene(seed: int) -> gb.RotorSystem:
    """Give a random rotor, or a train of two or three shafts, on bearings of every kind."""
    rng = np.random.default_rng(seed)
    count = int(rng.choice([1, 1, 2, 3]))
    helix = float(rng.choice([0.0, 0.3])) if count > 1 else 0.0
    parts: dict[str, list[Any]] = {
        "shafts": [],
        "bearings": [],
        "disks": [],
        "gears": [],
        "meshes": [],
    }
    on_box = rng.random() < 0.25
    for i in range(count):
        shaft, length = f"s{i}", rng.uniform(0.3, 1.0)
        elements, diameter = int(rng.integers(2, 7)), rng.uniform(0.03, 0.06)
        parts["shafts"].append(
            gb.Shaft(
                shaft, length=length, outer_diameter=diameter, elements=elements, material=STEEL
            )
        )
        mass = rng.uniform(1.0, 40.0)
        parts["disks"].append(
            gb.Disk(f"d{i}", shaft, length * rng.uniform(0.1, 0.9), mass, 0.5, 0.3)
        )
        places = [0.0, length, *([length * 0.6] if rng.random() < 0.2 else [])]
        for j, place in enumerate(places):
            more: dict[str, Any] = {"axial_stiffness": 1e7} if helix and j == 0 else {}
            if rng.random() < 0.2:
                more["support"] = gb.Support(
                    f"p{i}{j}", mass=5.0, stiffness=10 ** rng.uniform(7.0, 9.0)
                )
                if helix and j == 0:
                    more["support"] = replace(more["support"], axial_stiffness=1e8)
            elif on_box:
                more["support"] = "box"
            parts["bearings"].append(bearing(rng, str(rng.choice(KINDS)), shaft, place, **more))
        if count > 1:
            hand = {"helix_angle": helix * (-1) ** i, "face_width": 0.03} if helix else {}
            gear = {"teeth": int(rng.integers(20, 45)), "module": 3e-3, "mass": 3.0}
            place = length * rng.uniform(0.2, 0.8)
            parts["gears"].append(
                gb.Gear(
                    f"g{i}",
                    shaft,
                    place,
                    **gear,
                    diametral_inertia=0.01,
                    polar_inertia=0.02,
                    **hand,
                )
            )
    for i in range(count - 1):
        backlash = float(rng.choice([0.0, 1e-4])) or None
        angle = rng.uniform(-math.pi, math.pi)
        parts["meshes"].append(
            gb.Mesh(f"g{i}", f"g{i + 1}", stiffness=2e8, centre_line_angle=angle, backlash=backlash)
        )
    if count > 1:
        torque = rng.choice([-1.0, 1.0]) * rng.uniform(5.0, 400.0)
        parts["torques"] = [
            gb.Torque(("s0", 0.0), torque),
            gb.Torque.balance((f"s{count - 1}", 0.0)),
        ]
    if any(one.support == "box" for one in parts["bearings"]):
        axial = {"axial_stiffness": 1e8} if helix else {}
        parts["housings"] = [
            gb.Housing(
                "box",
                mass=60.0,
                stiffness=1e8,
                inertia=(1.0, 2.0, 2.0),
                rotational_stiffness=(1e7, 1e7, 1e7),
                **axial,
            )
        ]
    angle = rng.uniform(-math.pi, math.pi) if rng.random() < 0.3 else -math.pi / 2
    gravity = [9.81 * math.cos(angle), 9.81 * math.sin(angle)]
    return gb.RotorSystem(**parts, gravity=gravity, motion="coupled" if count > 1 else None)


def balances(system: gb.RotorSystem, static: gb.results.Static) -> dict[str, Balance]:
    """Add up the forces on every shaft from the weights, torques, tooth forces and bearing forces."""
    found = {shaft.name: Balance(shaft.length) for shaft in system.shafts}
    gravity = np.array([0.0, *system.gravity])
    for shaft in system.shafts:
        weight = STEEL.density * math.pi / 4 * shaft.outer_diameter**2 * shaft.length * gravity
        found[shaft.name].add(shaft.length / 2, weight)
    for body in (*system.disks, *system.gears):
        found[body.shaft].add(body.position, body.mass * gravity)
    for one in system.bearings:
        lateral = static.bearing_force((one.shaft, one.position))
        axial = static.axial_bearing_force((one.shaft, one.position))
        found[one.shaft].add(one.position, [-axial, *(-lateral)])
    return found


def add_teeth(
    found: dict[str, Balance], system: gb.RotorSystem, static: gb.results.Static, speed: float
) -> None:
    """Add the forces of the teeth on both gears of every mesh."""
    gears = {gear.name: gear for gear in system.gears}
    ratio = 1.0
    for mesh in system.meshes:
        a, b = gears[mesh.driver], gears[mesh.driven]
        state = static.mesh((mesh.driver, mesh.driven))
        helix = abs(a.helix_angle)
        transverse = math.atan(math.tan(a.pressure_angle) / math.cos(helix))
        base = math.asin(math.sin(helix) * math.cos(a.pressure_angle))
        sense = math.copysign(1.0, speed * ratio)  # of the rotation of the driver
        force = state.force * math.cos(base)
        if mesh.backlash is not None and force < 0.0:
            sense, force = -sense, -force
        # Frozen geometry is that at rest; the reported one is that of the displaced centres.
        line = mesh.centre_line_angle if helix else state.centre_line_angle
        centres = np.array([math.cos(line), math.sin(line)])
        across = sense * np.array([-centres[1], centres[0]])
        angle = transverse if helix else state.pressure_angle
        lateral = force * (math.sin(angle) * centres + math.cos(angle) * across)
        at_rest = a.module * (a.teeth + b.teeth) / 2.0 / math.cos(helix)
        distance = at_rest if helix else state.centre_distance
        pitch = distance * np.array([a.teeth, b.teeth]) / (a.teeth + b.teeth)
        for gear, sign, radius in ((a, -1.0, pitch[0]), (b, 1.0, pitch[1])):
            point = -sign * radius * centres  # of the pitch point over the centre
            push, thrust = sign * lateral, sign * state.thrust
            torque = point[0] * push[1] - point[1] * push[0]
            moment = [torque, point[1] * thrust, -point[0] * thrust]
            found[gear.shaft].add(gear.position, [thrust, *push], moment)
        ratio *= -a.teeth / b.teeth


def add_torques(found: dict[str, Balance], system: gb.RotorSystem) -> None:
    """Add the given torque, and the one that balances it."""
    teeth = {gear.shaft: gear.teeth for gear in system.gears}
    first = system.torques[0]
    ratio = (
        (-1.0) ** (len(system.shafts) - 1)
        * teeth[system.shafts[0].name]
        / teeth[system.shafts[-1].name]
    )
    for shaft, value in (
        (system.shafts[0].name, first.value),
        (system.shafts[-1].name, -first.value / ratio),
    ):
        found[shaft].add(0.0, [0.0] * 3, [value, 0.0, 0.0])


#: Errors of scenes without an equilibrium, and their largest part of all scenes.
EXPECTED = {
    "the journal touches the bearing": 0.1,
    "no load acts on the journal bearing": 0.02,
    "no static equilibrium found": 0.05,
    "base circles overlap": 0.02,
}


def test_forces_balance_on_every_shaft_of_random_scenes():
    refused: Counter[str] = Counter()
    for seed in range(SCENES):
        system = scene(seed)
        speed = np.random.default_rng(seed).uniform(30.0, 900.0)
        # With helical gears, the tilt of the gears turns the tooth force in live geometry.
        helical = any(gear.helix_angle for gear in system.gears)
        for omega in (speed, -speed):
            try:
                static = system.static(omega, geometry="frozen" if helical else "live")
                if helical:
                    assert system.static(speed=omega).residual <= TOLERANCE
            except (gb.SceneError, gb.ConvergenceError, gb.ContactError) as error:
                refused[next(text for text in EXPECTED if text in str(error))] += 1
                continue
            assert static.residual <= TOLERANCE, (seed, omega)
            meshes = [(mesh, static.mesh((mesh.driver, mesh.driven))) for mesh in system.meshes]
            if any(state.stiffness > mesh.stiffness for mesh, state in meshes):
                continue  # Both flanks are pressed, and the result has the difference of their forces.
            found = balances(system, static)
            if system.gears:
                add_teeth(found, system, static, omega)
                add_torques(found, system)
            for shaft, balance in found.items():
                assert balance.residual <= TOLERANCE, (seed, omega, shaft)
    for text, part in EXPECTED.items():
        assert refused[text] <= part * 2 * SCENES + 2, refused


# --- matrices and stability ---------------------------------------------------------------------

ROLLING: dict[str, Any] = {
    "elements": 9,
    "element_diameter": 0.012,
    "pitch_diameter": 0.06,
    "clearance": 1e-5,
}


@pytest.mark.parametrize("kind", ["short", "finite", "ball", "roller"])
def test_the_stiffness_matrix_is_the_derivative_of_the_static_forces(kind: str):
    def bearing_at(place: float) -> Any:
        if kind in ("short", "finite"):
            return gb.JournalBearing("r", place, **OIL, film=kind)
        roller = {"contact": "roller", "roller_length": 0.012} if kind == "roller" else {}
        return gb.RollingBearing("r", place, **ROLLING, **roller, phase=0.1)

    system = rotor_on_films(bearings=[bearing_at(x) for x in (0.0, 0.5)], motion="lateral")
    for speed in (120.0, -400.0):
        stiffness = system.matrices(speed).stiffness
        place = {"v": 0, "w": 1}
        for direction, index in place.items():
            force = np.zeros(2)
            force[index] = (
                0.02  # N, 1e-4 of the load: a difference quotient of second order, and round-off
            )
            moved = []
            for sign in (1.0, -1.0):
                push = gb.Force(("r", 0.0), sign * force)
                moved.append(system.replace(forces=[push]).static(speed=speed).state)
            found = stiffness @ (moved[0] - moved[1])
            expected = np.zeros(len(system.dofs))
            expected[system.dofs.index(("r", 0.0, direction))] = 2.0 * 0.02
            np.testing.assert_allclose(
                found, expected, atol=2e-5 * 0.02, err_msg=f"{speed} {direction}"
            )


@pytest.mark.parametrize("flexibility", [0.1, 1.0, 4.0])
def test_the_threshold_of_a_jeffcott_rotor_is_that_of_lund(flexibility: float):
    """Lund, J. Eng. Ind. 87 (1965): whirl of a disk on a massless shaft and two short films.

    At the threshold, a journal whirls with the frequency ω where the film has the stiffness k and
    no damping: k = (Kyy Czz + Kzz Cyy − Kyz Czy − Kzy Cyz)/(Cyy + Czz) and
    ω² = ((Kyy − k)(Kzz − k) − Kyz Kzy)/(Cyy Czz − Cyz Czy). The disk needs 1/(m ω²) = 1/ks + 1/2k.
    """
    mass, length, oil = 10.0, 0.5, gb.JournalBearing("r", 0.0, **OIL)
    weight = 9.81 * mass
    sag = flexibility * OIL["clearance"]
    shaft = weight / sag  # stiffness at the disk, N/m

    def whirl(speed: float) -> tuple[float, float]:
        film = oil.coefficients(weight / 2, speed)
        (kyy, kyz), (kzy, kzz) = film.stiffness
        (cyy, cyz), (czy, czz) = film.damping
        k = (kyy * czz + kzz * cyy - kyz * czy - kzy * cyz) / (cyy + czz)
        return k, ((kyy - k) * (kzz - k) - kyz * kzy) / (cyy * czz - cyz * czy)

    def missing(speed: float) -> float:
        k, square = whirl(speed)
        return mass * square * (1.0 / shaft + 1.0 / (2.0 * k)) - 1.0

    speeds = np.linspace(20.0, 3000.0, 300)
    values = [missing(speed) for speed in speeds]
    at = next(i for i in range(len(speeds) - 1) if values[i] < 0.0 < values[i + 1])
    expected = brentq(missing, speeds[at], speeds[at + 1], rtol=1e-12)
    # Stiffness 48 E I/L³ without shear.
    diameter = (shaft * length**3 / 48.0 / 2.07e11 * 64.0 / math.pi) ** 0.25
    light = gb.Material(2.07e11, 1e-2, poisson_ratio=0.3)
    rod = gb.Shaft(
        "r", length=length, outer_diameter=diameter, elements=2, material=light, shear=False
    )
    system = gb.RotorSystem(
        [rod],
        disks=[gb.Disk("d", "r", 0.25, mass, 0.05, 0.1)],
        bearings=[replace(oil, position=x) for x in (0.0, length)],
        gravity=9.81,
        motion="lateral",
    )
    found = system.campbell(np.array([0.91, 0.97, 1.04]) * expected, count=6).thresholds
    # The shaft has a mass of 1e-6 of that of the disk.
    assert min(abs(one.speed / expected - 1.0) for one in found) <= 1e-5
