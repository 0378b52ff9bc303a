"""Planets that move laterally on a carrier that turns, against the planar equations of Lin and Parker in its frame."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.linalg import eig

import gearbow as gb

# Lin and Parker 1999: a lumped model, with rigid shafts, so that most values are implausible.
pytestmark = pytest.mark.implausible

ALPHA = np.radians(24.6)
MODULE = 3e-3
#: Teeth that fit 3, 4 and 5 planets.
SUN, PLANET, RING = 30, 30, 90
RADIUS = MODULE * (SUN + PLANET) / 2
TOOTH: dict[str, Any] = {"module": MODULE, "pressure_angle": ALPHA}
RIGID = gb.Material(youngs_modulus=207e9, density=1.0, poisson_ratio=0.3)
#: Stiffness against tilting that keeps all bodies in their plane [N m/rad].
UPRIGHT = 1e9
MESH, PIN, BEARING, RING_ROTATION = 5e8, 1e8, 1e8, 1e9
#: Speed of the sun [rad/s] when the carrier turns at its rated speed of 250 rad/s.
RATED = 1000.0
RATIO = SUN / (SUN + RING)


def base(teeth: int) -> float:
    return MODULE * teeth / 2 * np.cos(ALPHA)


#: Mass, I/r² and r of the bodies; the radius of the carrier is that of the pins.
MASS = {"carrier": 5.43, "ring": 2.35, "sun": 0.4, "planet": 0.66}
INERTIA = {"carrier": 6.29, "ring": 3.0, "sun": 0.39, "planet": 0.61}
ARM = {"carrier": RADIUS, "ring": base(RING), "sun": base(SUN), "planet": base(PLANET)}


def body(kind: str) -> dict[str, float]:
    polar = INERTIA[kind] * ARM[kind] ** 2
    return {"mass": MASS[kind], "polar_inertia": polar, "diametral_inertia": polar}


def shaft(name: str, **changes: Any) -> gb.Shaft:
    # Bearing and gear are at one node, so that the shafts do not bend.
    return gb.Shaft(name, length=0.02, outer_diameter=0.02, material=RIGID, elements=2, **changes)


def hold(name: str, stiffness: Any = BEARING, **changes: Any) -> gb.Bearing:
    return gb.Bearing(name, 0.01, stiffness=stiffness, tilting_stiffness=UPRIGHT, **changes)


def stage(planets: Any = 3, **changes: Any) -> gb.PlanetaryStage:
    given: dict[str, Any] = {
        "sun": "sun",
        "ring": gb.RingGear("ring", RING, "out", position=0.01, **TOOTH, **body("ring")),
        "planets": planets,
        "carrier": "carrier",
        "planet": gb.Gear("planet", "pin", 0.01, teeth=PLANET, **TOOTH, **body("planet")),
        "pin": shaft("pin"),
        "bearing": hold("pin", PIN),
        "sun_mesh": gb.Mesh("sun", "planet", stiffness=MESH),
        "ring_mesh": gb.Mesh("planet", "ring", stiffness=MESH),
    }
    return gb.PlanetaryStage(**(given | changes))


def system(given: gb.PlanetaryStage | None = None, **changes: Any) -> gb.RotorSystem:
    parts: dict[str, Any] = {
        "shafts": [shaft("in"), shaft("out", speed_ratio=0.0), shaft("arm")],
        "gears": [gb.Gear("sun", "in", 0.01, teeth=SUN, **TOOTH, **body("sun"))],
        "disks": [gb.Disk("carrier", "arm", 0.01, **body("carrier"))],
        "bearings": [hold(name) for name in ("in", "out", "arm")],
        "drives": [gb.Drive("ring", RING_ROTATION * base(RING) ** 2)],
        "planetary_stages": [given or stage()],
    }
    return gb.RotorSystem(**(parts | changes))


class LinAndParker:
    """Displacements x, y and u = rθ of carrier, ring and sun, and radial, tangential and u of the planets, in the frame of the carrier."""

    def __init__(self, planets: int, *, at_rest: float = 0.0, pin: float = 0.0):
        self.planets, size = planets, 3 * (planets + 3)
        kinds = ["carrier", "ring", "sun", *["planet"] * planets]
        self.mass = np.diag([value for kind in kinds for value in self.inertia(kind)])
        springs: list[tuple[np.ndarray, float]] = []
        dampers: list[tuple[np.ndarray, float]] = []
        turning_dampers = np.zeros((size, size))
        self.coriolis, self.centrifugal = np.zeros((size, size)), np.zeros((size, size))
        for number, kind in enumerate(kinds):
            x, y = 3 * number, 3 * number + 1
            self.coriolis[x, y], self.coriolis[y, x] = -2 * MASS[kind], 2 * MASS[kind]
            if number < 3:
                self.centrifugal[x, x] = self.centrifugal[y, y] = MASS[kind]
                for index in (x, y):
                    springs.append((self.row({index: 1.0}), BEARING))
                    dampers.append((self.row({index: 1.0}), at_rest))
                # a damper at rest sees the velocity (ẋ − Ωy, ẏ + Ωx)
                turning_dampers[x, y], turning_dampers[y, x] = -at_rest, at_rest
        springs.append((self.row({5: 1.0}), RING_ROTATION))
        self.meshes = []
        for number in range(planets):
            psi, first = 2 * np.pi * number / planets, 9 + 3 * number
            radial, tangential, spin = first, first + 1, first + 2
            cosine, sine = np.cos(psi), np.sin(psi)
            pins = (
                {0: cosine, 1: sine, radial: -1.0},
                {0: -sine, 1: cosine, 2: 1.0, tangential: -1.0},
            )
            springs += [(self.row(entries), PIN) for entries in pins]
            dampers += [(self.row(entries), pin) for entries in pins]
            # the tangential displacement from where the rotation of the carrier takes the planet
            for entries in ({radial: 1.0}, {tangential: 1.0, 2: -1.0}):
                row = self.row(entries)
                self.centrifugal += MASS["planet"] * np.outer(row, row)
            sun, ring = psi - ALPHA, psi + ALPHA
            of_teeth = (
                {6: -np.sin(sun), 7: np.cos(sun), 8: 1.0, spin: 1.0}
                | {radial: -np.sin(ALPHA), tangential: -np.cos(ALPHA)},
                {3: -np.sin(ring), 4: np.cos(ring), 5: 1.0, spin: -1.0}
                | {radial: np.sin(ALPHA), tangential: -np.cos(ALPHA)},
            )
            self.meshes += [self.row(entries) for entries in of_teeth]
        springs += [(row, MESH) for row in self.meshes]
        self.stiffness = sum(value * np.outer(row, row) for row, value in springs)
        self.damping = sum(value * np.outer(row, row) for row, value in dampers)
        self.turning_dampers = turning_dampers

    @staticmethod
    def inertia(kind: str) -> tuple[float, float, float]:
        return MASS[kind], MASS[kind], INERTIA[kind]

    def row(self, entries: dict[int, float]) -> np.ndarray:
        row = np.zeros(3 * (self.planets + 3))
        row[list(entries)] = list(entries.values())
        return row

    def at(self, speed: float) -> np.ndarray:
        """Give the stiffness at a speed of the carrier."""
        return self.stiffness - speed**2 * self.centrifugal + speed * self.turning_dampers

    def eigenvalues(self, speed: float) -> np.ndarray:
        size = len(self.mass)
        zero, one = np.zeros((size, size)), np.eye(size)
        rate = self.damping + speed * self.coriolis
        left = np.block([[zero, one], [-self.at(speed), -rate]])
        found = eig(left, np.block([[one, zero], [zero, self.mass]]), right=False)
        return found[np.argsort(np.abs(found))]

    def vibrations(self, speed: float) -> np.ndarray:
        """Give the eigenvalues with positive imaginary part without the rotation of the train."""
        found = self.eigenvalues(speed)
        assert np.all(np.abs(found[:2]) < 1.0)
        kept = found[2:]
        return kept[kept.imag > 0.0]


def lateral(modes: Any, mode: int, *names: str) -> float:
    """Give the largest lateral displacement of bodies in a mode, over that of all bodies and twists."""
    shape = modes.shapes[mode]
    nodes = {"carrier": "arm", "ring": "out", "sun": "in"}
    wanted = {nodes[name] for name in names}
    sizes = [
        abs(value)
        for value, (name, _, kind) in zip(shape, modes.dofs, strict=True)
        if name in wanted and kind in "vw"
    ]
    every = [
        abs(value) for value, (_, _, kind) in zip(shape, modes.dofs, strict=True) if kind in "vw"
    ]
    return max(sizes) / max(every)


@pytest.fixture(scope="module")
def stages() -> dict[int, gb.RotorSystem]:
    return {planets: system(stage(planets)) for planets in (3, 4, 5)}


@pytest.mark.parametrize("planets", [3, 4, 5])
@pytest.mark.parametrize("part", [0.0, 0.5, 1.0, -1.0])
def test_modes_are_those_of_lin_and_parker_at_speed(
    stages: dict[int, gb.RotorSystem], planets: int, part: float
):
    """Gyroscopic effects split the translational modes; rotational modes stay single and planet modes (N − 3)-fold."""
    model = LinAndParker(planets)
    expected = np.sort(model.vibrations(part * RATED * RATIO).imag) / (2 * np.pi)
    found = stages[planets].modes(part * RATED, count=1 + len(expected))
    # the rotation of the train
    assert found.frequencies_hz[0] < 1e-2
    # shafts of small mass that bend a little
    assert found.frequencies_hz[1:] == pytest.approx(expected, rel=1e-5)
    assert np.abs(found.eigenvalues.real).max() < 1e-3
    moves = [
        lateral(found, mode, "carrier", "ring", "sun") > 1e-3
        for mode in range(1, len(expected) + 1)
    ]
    assert sum(moves) == 12
    frequencies = found.frequencies_hz[1:]
    translational = frequencies[moves]
    apart = np.diff(translational)[::2]
    if part:
        assert np.all(apart > 1e-3)
    else:
        assert np.all(apart < 1e-3 * translational[::2])
    # rotational modes are single, planet modes (N − 3)-fold
    others = frequencies[~np.array(moves)]
    groups = np.split(others, np.flatnonzero(np.diff(others) > 1e-4 * others[1:]) + 1)
    sizes = sorted(len(group) for group in groups)
    assert sizes == sorted([1] * 5 + [planets - 3] * (3 if planets > 3 else 0))


def test_dampers_at_rest_and_on_pins_have_their_places_in_the_frame():
    """Dampers of bearings at rest see the rotation of the frame, and those of pins turn with it."""
    at_rest, pin = 3e3, 1e3
    bearings = [hold(name, damping=at_rest) for name in ("in", "out", "arm")]
    train = system(stage(4, bearing=hold("pin", PIN, damping=pin)), bearings=bearings)
    speed = 2.0 * RATED
    expected = LinAndParker(4, at_rest=at_rest, pin=pin).vibrations(speed * RATIO)
    found = train.modes(speed, count=len(expected), vibrating=True).eigenvalues
    for value in expected:
        nearest = found[np.argmin(np.abs(found - value))]
        assert nearest == pytest.approx(value, rel=3e-5)


def test_the_rotation_of_the_train_is_free_as_in_the_nonlinear_equations():
    """The centrifugal force that presses a planet on its pin turns with the pin, in contrast to the printed matrices."""
    planets, speed = 4, RATED * RATIO
    model = LinAndParker(planets)
    size = len(model.mass)

    def potential(q: np.ndarray) -> Any:
        """Give the elastic minus the centrifugal energy, with the exact place of the pins."""
        cosine, sine = np.cos(q[2] / RADIUS), np.sin(q[2] / RADIUS)
        energy = RING_ROTATION * q[5] ** 2 + sum(MESH * (row @ q) ** 2 for row in model.meshes)
        for number, kind in enumerate(("carrier", "ring", "sun")):
            x, y = q[3 * number : 3 * number + 2]
            energy = energy + (BEARING - MASS[kind] * speed**2) * (x**2 + y**2)
        for number in range(planets):
            angle = 2 * np.pi * number / planets
            out = np.array([np.cos(angle), np.sin(angle)])
            along = np.array([-out[1], out[0]])
            place = (RADIUS + q[9 + 3 * number]) * out + q[10 + 3 * number] * along
            pin = q[:2] + RADIUS * (cosine * out + sine * along)
            apart = place - pin
            energy = energy + PIN * apart @ apart - MASS["planet"] * speed**2 * place @ place
        return energy / 2

    def gradient(q: np.ndarray) -> np.ndarray:
        steps = 1e-30j * np.eye(size)
        return np.array([potential(q + step).imag / 1e-30 for step in steps])

    def tangent(q: np.ndarray) -> np.ndarray:
        columns = [(gradient(q + step) - gradient(q - step)) / 2e-6 for step in 1e-6 * np.eye(size)]
        return (np.array(columns) + np.array(columns).T) / 2

    q = np.zeros(size)
    for _ in range(4):
        q -= np.linalg.lstsq(tangent(q), gradient(q), rcond=1e-12)[0]
    exact, printed = LinAndParker(planets), LinAndParker(planets)
    exact.stiffness, exact.centrifugal = tangent(q), np.zeros((size, size))
    found, expected = model.vibrations(speed).imag, exact.vibrations(speed).imag
    # the planets are 37 µm farther out, on a radius of 90 mm
    assert np.sort(found) == pytest.approx(np.sort(expected), rel=2e-4)
    printed.centrifugal = np.diag(np.diag(model.mass))
    printed.centrifugal[2::3, 2::3] = 0.0
    assert printed.eigenvalues(speed)[:2].real.max() > 100.0
    system_at_speed = system(stage(planets)).modes(RATED, count=2)
    assert np.abs(system_at_speed.eigenvalues[0]) < 1e-2


@pytest.mark.parametrize("speed", [RATED, -RATED])
def test_planets_share_the_load_and_their_pins_carry_centrifugal_force(speed: float):
    torque, planets = 200.0 * np.sign(speed), 4
    train = system(stage(planets), torques=[gb.Torque("sun", torque), gb.Torque.balance("carrier")])
    found = train.static(speed=speed, geometry="frozen")
    force = abs(torque) / base(SUN) / planets
    for mesh in train.meshes:
        assert found.mesh((mesh.driver, mesh.driven)).force == pytest.approx(force, rel=1e-9)
    model = LinAndParker(planets)
    load = np.zeros(len(model.mass))
    load[8], load[2] = abs(torque) / base(SUN), -abs(torque) * (1 + RING / SUN) / RADIUS
    load[9::3] = MASS["planet"] * (speed * RATIO) ** 2 * RADIUS
    q = np.linalg.lstsq(model.at(abs(speed) * RATIO), load, rcond=1e-12)[0]
    # the first planet is on the y axis, and a train that turns backwards is the mirror image
    expected = PIN * np.array([q[9], np.sign(speed) * (q[10] - q[2])])
    assert found.bearing_force(("pin 1", 0.01)) == pytest.approx(expected, rel=2e-5)
    # the radial forces of the teeth of sun and ring cancel
    outwards = MASS["planet"] * (speed * RATIO) ** 2 * (RADIUS + q[9])
    assert expected[0] == pytest.approx(outwards, rel=1e-9)


def test_the_force_on_a_pin_follows_from_the_displacement_of_the_planet_on_its_carrier(
    stages: dict[int, gb.RotorSystem],
):
    # a carrier that twists moves its pins across their radius
    found = stages[3].frequency_response([400.0], source=gb.Torque("sun", 10.0), speed=RATED)
    for number in (1, 2, 3):
        at = (f"pin {number}", 0.01)
        moved = found.bearing_displacement(at)
        assert found.bearing_force(at) == pytest.approx(PIN * moved, rel=1e-7)


@pytest.mark.filterwarnings("ignore::gearbow.AccuracyWarning")
@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_a_displaced_pin_on_a_turning_carrier_unloads_its_planet_by_the_hand_calculation(
    sense: float,
):
    """F_i = (u − 2 e_i cos α)/(2/k_m + 4 cos²α/k) with rigid centres of sun, ring and carrier."""
    off, torque, stiff = 50e-6, 900.0, 1e12
    train = system(
        stage(pin_errors=[1j * off * sense, 0.4j * off * sense, 0.0]),
        bearings=[hold(name, stiff) for name in ("in", "out", "arm")],
        torques=[gb.Torque("sun", torque * sense), gb.Torque.balance("carrier")],
    )
    # centrifugal forces are below 1 N
    found = train.static(speed=10.0 * sense, geometry="frozen")
    forces = np.array([found.mesh(("sun", f"planet {i}")).force for i in (1, 2, 3)])
    compliance = 2 / MESH + 4 * np.cos(ALPHA) ** 2 / PIN
    mean = torque / base(SUN) / 3
    shares = np.array([1.0, 0.4, 0.0]) * 2 * off * np.cos(ALPHA) / compliance
    assert forces == pytest.approx(mean - shares + shares.mean(), rel=2e-4)


def test_a_campbell_diagram_has_the_lines_of_the_frame(stages: dict[int, gb.RotorSystem]):
    train = stages[3]
    diagram = train.campbell([1.0, 500.0, 1000.0], count=8)
    for speed, eigenvalues in zip(diagram.speeds, diagram.eigenvalues, strict=True):
        expected = np.sort(LinAndParker(3).vibrations(speed * RATIO).imag)
        found = np.sort(np.abs(eigenvalues.imag))
        kept = found[found > 1.0]
        assert kept == pytest.approx(expected[: len(kept)], rel=2e-5)
    orders = {line.order for line in diagram.lines if line.kind == "shaft"}
    # the unbalance of the sun turns relative to the carrier, that of the carrier does not
    assert max(orders) == pytest.approx(1.0 - RATIO)
    assert {line.order for line in diagram.lines if line.kind == "mesh"} == {SUN * (1.0 - RATIO)}


@pytest.mark.filterwarnings("ignore::gearbow.AccuracyWarning")
def test_large_models_have_the_same_modes():
    """Few modes of many elements come from band matrices."""
    fine = [
        shaft(name, **changes)
        for name, changes in (("in", {}), ("out", {"speed_ratio": 0.0}), ("arm", {}))
    ]
    fine = [gb.Shaft(**{**each.__dict__, "elements": 30}) for each in fine]
    train = system(shafts=fine)
    found = train.modes(RATED, count=8, vibrating=True)
    expected = np.sort(LinAndParker(3).vibrations(RATED * RATIO).imag)[:8] / (2 * np.pi)
    assert np.sort(found.frequencies_hz) == pytest.approx(expected, rel=2e-5)


ANALYSES = [
    (
        "run at a changing speed; give a constant speed",
        lambda train: train.simulate(0.001, gb.SpeedProfile.ramp(100.0, 200.0, duration=0.001)),
    ),
    ("critical speed map; campbell", lambda train: train.critical_speed_map([1e7])),
]


@pytest.mark.parametrize(("analysis", "compute"), ANALYSES)
def test_other_analyses_are_errors(
    stages: dict[int, gb.RotorSystem], analysis: str, compute: Callable[[gb.RotorSystem], object]
):
    message = (
        rf"bearings\[\d+\]: lets a planet move laterally .*no {analysis}.*; leave out the bearings"
    )
    with pytest.raises(gb.SceneError, match=message):
        compute(stages[3])


def other(name: str, **changes: Any) -> gb.Gear:
    return gb.Gear(name, changes.pop("on"), 0.015, teeth=40, **TOOTH, **body("sun"))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (
            {"bearings": [hold("in", (1e8, 2e8)), hold("out"), hold("arm")]},
            r'bearings\[0\]: on the shaft "in" is not the same in all directions',
        ),
        (
            {"bearings": [hold("in", loss_factor=0.1), hold("out"), hold("arm")]},
            r"bearings\[0\]\.loss_factor",
        ),
        (
            {
                "bearings": [
                    hold("in"),
                    hold("out"),
                    hold("arm", support=gb.Support(mass=1.0, stiffness=1e8)),
                ]
            },
            r"bearings\[2\]\.support: a support or housing has a fixed direction",
        ),
        (
            {"bearings": [hold("in"), hold("arm")]},
            r'meshes\[1\]: the planet moves laterally on its bearings, and "ring" on the shaft "out" cannot; give its shaft bearings, or a ring on the ground a lateral_stiffness',
        ),
        ({"modal_damping": 0.01}, r"modal_damping: is that of modes at rest"),
        ({"forces": [gb.Force("sun", 10.0)]}, r"forces\[0\]: has a fixed direction"),
        (
            {
                "gears": [*system().gears[:1], other("wheel", on="in"), other("next", on="side")],
                "shafts": [*system().shafts[:3], shaft("side")],
                "bearings": [hold(name) for name in ("in", "out", "arm", "side")],
                "meshes": [gb.Mesh("wheel", "next", stiffness=1e8)],
            },
            r"meshes\[0\]: has a fixed direction, .*separate them by a coupling with torsional stiffness",
        ),
        (
            {"motion": "torsion"},
            r'bearings\[3\]: is that of a planet on a carrier that turns, and motion="torsion"',
        ),
    ],
)
def test_what_is_not_constant_in_the_frame_is_an_error(changes: dict[str, Any], message: str):
    with pytest.raises(gb.SceneError, match=message):
        system(**changes)


@pytest.mark.filterwarnings("ignore::gearbow.AccuracyWarning")
def test_a_coupling_in_torsion_separates_the_stage_from_other_directions():
    """A parallel stage behind it keeps the frame at rest."""
    gears = [*system().gears[:1], other("wheel", on="ahead"), other("next", on="side")]
    train = system(
        gears=gears,
        shafts=[*system().shafts[:3], shaft("ahead"), shaft("side")],
        bearings=[
            *[hold(name) for name in ("in", "out", "arm")],
            *[hold(name, (1e8, 3e8)) for name in ("ahead", "side")],
        ],
        meshes=[gb.Mesh("wheel", "next", stiffness=1e8)],
        couplings=[gb.Coupling(("ahead", 0.02), ("in", 0.0), torsional_stiffness=1e5)],
    )
    found = train.modes(RATED, count=30).frequencies_hz
    # translational modes do not twist the sun
    expected = LinAndParker(3).vibrations(RATED * RATIO).imag / (2 * np.pi)
    near = [np.abs(found / value - 1.0).min() < 2e-5 for value in expected]
    assert sum(near) >= 12


@pytest.mark.filterwarnings("ignore::gearbow.AccuracyWarning")
@pytest.mark.parametrize("speed", [900.0, -900.0])
def test_a_shaft_that_teeth_hardly_touch_has_its_own_modes_in_the_frame(speed: float):
    """Forward whirl is slower by the speed of the carrier there, backward whirl faster; damping is the same."""
    long = gb.Shaft("in", length=0.5, outer_diameter=0.03, elements=6, internal_damping=2e-6)
    plate = {"mass": 2.0, "diametral_inertia": 0.01, "polar_inertia": 0.018}
    wheel = gb.Gear("sun", "in", 0.35, teeth=SUN, **TOOTH, **plate)
    ends = [gb.Bearing("in", x, stiffness=2e7, damping=2e3) for x in (0.0, 0.5)]
    both = {"rayleigh": (1.0, 1e-7)}
    alone = gb.RotorSystem(
        shafts=[long], disks=[gb.Disk("sun", "in", 0.35, **plate)], bearings=ends, **both
    )
    light = {"stiffness": 1.0}
    train = system(
        stage(
            sun_mesh=gb.Mesh("sun", "planet", **light), ring_mesh=gb.Mesh("planet", "ring", **light)
        ),
        shafts=[long, *system().shafts[1:3]],
        gears=[wheel],
        bearings=[*ends, hold("out"), hold("arm")],
        **both,
    )
    modes = alone.modes(speed, count=6)
    found = train.modes(speed, count=60).eigenvalues
    turn = abs(speed) * RATIO
    for value, whirl in zip(modes.eigenvalues, modes.whirl, strict=True):
        expected = value + 1j * turn * (-1.0 if whirl == "forward" else 1.0)
        nearest = found[np.argmin(np.abs(found - expected))]
        assert nearest == pytest.approx(expected, rel=1e-6)


@pytest.mark.filterwarnings("ignore::gearbow.AccuracyWarning")
def test_at_standstill_helical_planets_at_unequal_angles_are_those_of_a_star_gear():
    """A housing that rotates is such a carrier at rest."""
    helix = {"helix_angle": 0.2, "module": MODULE, "pressure_angle": ALPHA}
    polar = body("carrier")["polar_inertia"]
    step = 2 * np.pi / (SUN + RING)
    given: dict[str, Any] = {
        "planets": [0.3, 0.3 + 37 * step, 0.3 + 75 * step],
        "ring": gb.RingGear(
            "ring", RING, "out", position=0.01, **helix | {"helix_angle": -0.2}, **body("ring")
        ),
        "planet": gb.Gear(
            "planet", "pin", 0.01, teeth=PLANET, **helix | {"helix_angle": -0.2}, **body("planet")
        ),
        "bearing": [
            gb.Bearing("pin", x, stiffness=k, damping=c, axial_stiffness=a, tilting_stiffness=1e4)
            for x, k, c, a in ((0.0, 6e7, 3e2, 5e7), (0.02, 5e7, 1e2, 0.0))
        ],
    }
    common: dict[str, Any] = {
        "gears": [gb.Gear("sun", "in", 0.01, teeth=SUN, **helix, **body("sun"))],
    }
    holds = [hold(name, axial_stiffness=2e7) for name in ("in", "out")]
    turning = system(
        stage(**given),
        bearings=[
            *holds,
            gb.Bearing("arm", 0.01, stiffness=BEARING, tilting_stiffness=1e5, axial_stiffness=3e7),
        ],
        **common,
    )
    carrier = gb.Housing(
        "carrier",
        mass=MASS["carrier"],
        inertia=(polar, polar, polar),
        position=(0.01, 0.0, 0.0),
        stiffness=BEARING,
        axial_stiffness=3e7,
        rotational_stiffness=(0.0, 1e5, 1e5),
    )
    star = system(
        stage(**given),
        shafts=[shaft("in"), shaft("out")],
        disks=[],
        bearings=holds,
        housings=[carrier],
        **common,
    )
    found, expected = (train.modes(0.0, count=20, vibrating=True) for train in (turning, star))
    # the shaft of the carrier has a small mass
    assert found.eigenvalues == pytest.approx(expected.eigenvalues, rel=1e-5)


def test_planets_stand_around_the_axis_of_their_carrier(stages: dict[int, gb.RotorSystem]):
    found = stages[4].mass_properties().to_dataframe().set_index("shaft")
    places = found.loc[[f"pin {i}" for i in (1, 2, 3, 4)], ["y [m]", "z [m]"]].to_numpy()
    expected = RADIUS * np.array([[1, 0], [0, 1], [-1, 0], [0, -1]])
    assert places == pytest.approx(expected, abs=1e-12)
    assert found.loc["arm", ["y [m]", "z [m]"]].to_numpy(float) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.filterwarnings("ignore::gearbow.AccuracyWarning")
def test_a_ring_on_the_ground_is_one_on_a_shaft_that_stands_still():
    """Its mount is a thin shaft, of which the ring of this model has no mass."""
    on_ground = gb.RingGear(
        "ring",
        RING,
        face_width=0.02,
        **TOOTH,
        **body("ring"),
        rotational_stiffness=RING_ROTATION * base(RING) ** 2,
        lateral_stiffness=BEARING,
        lateral_damping=300.0,
        tilting_stiffness=UPRIGHT,
    )
    held = [hold("in"), hold("arm")]
    grounded = system(
        stage(ring=on_ground), shafts=[shaft("in"), shaft("arm")], bearings=held, drives=[]
    )
    standing = system(bearings=[*held, hold("out", damping=300.0)])
    found, expected = (
        np.sort(train.modes(RATED, count=15, vibrating=True).frequencies_hz)
        for train in (grounded, standing)
    )
    # the mount has 0.4 % of the mass of the ring
    assert found == pytest.approx(expected, rel=5e-3)


@pytest.mark.parametrize(
    "field",
    ["rotational_stiffness", "lateral_stiffness", "lateral_damping", "axial_stiffness"],
)
def test_a_ring_on_a_shaft_has_no_support_of_its_own(field: str):
    ring = gb.RingGear("ring", RING, "out", position=0.01, **TOOTH, **body("ring"), **{field: 1e6})
    with pytest.raises(gb.SceneError, match=rf"ring\.{field}: is for a ring on the ground"):
        system(stage(ring=ring))


@pytest.mark.parametrize(
    ("errors", "message"),
    [
        ([1e-5], r"pin_errors: must be a list of 3 numbers"),
        (1e-5, r"pin_errors: must be a list of 3 numbers"),
        (["1e-5", 0.0, 0.0], r"pin_errors\[0\]: must be a number"),
        ([0.0, np.nan, 0.0], r"pin_errors\[1\]: must be finite"),
    ],
)
def test_pin_errors_are_finite_numbers(errors: Any, message: str):
    with pytest.raises(gb.SceneError, match=message):
        system(stage(pin_errors=errors))


def test_pin_errors_need_linear_bearings():
    rigid = stage(pin_errors=[1e-5, 0.0, 0.0], bearing=())
    with pytest.raises(gb.SceneError, match="pin_errors: a pin that is off moves the planet"):
        system(rigid)
