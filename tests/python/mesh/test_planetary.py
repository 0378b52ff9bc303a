"""Planetary stages with a carrier at rest: published modes, load sharing, phases, wrong stages."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import gearbow as gb

# Lin and Parker 1999: a lumped model, with rigid shafts, so that most values are implausible.
pytestmark = pytest.mark.implausible

ALPHA = np.radians(24.6)
MODULE = 3e-3
#: Teeth that fit 3, 4 and 5 planets.
SUN, PLANET, RING = 30, 30, 90
# Bearing and gear are at one node, so that the shafts do not bend.
RIGID = gb.Material(youngs_modulus=207e9, density=1.0, poisson_ratio=0.3)
#: Stiffness against tilting that keeps all bodies in their plane [N m/rad].
UPRIGHT = 1e9
MESH, PIN, BEARING, RING_ROTATION = 5e8, 1e8, 1e8, 1e9


def base(teeth: int) -> float:
    return MODULE * teeth / 2 * np.cos(ALPHA)


def body(mass: float, inertia: float, teeth: int) -> dict[str, float]:
    """Give mass and inertias of a gear from I/r² with its base radius."""
    polar = inertia * base(teeth) ** 2
    return {"mass": mass, "polar_inertia": polar, "diametral_inertia": polar}


def stage(planets: Any = 3, *, carrier: str | None = None, **changes: Any) -> gb.PlanetaryStage:
    tooth = {"module": MODULE, "pressure_angle": ALPHA}
    given: dict[str, Any] = {
        "sun": "sun",
        "ring": gb.RingGear("ring", RING, "out", position=0.01, **tooth, **body(2.35, 3.0, RING)),
        "planets": planets,
        "carrier": carrier,
        "planet": gb.Gear("planet", "pin", 0.01, teeth=PLANET, **tooth, **body(0.66, 0.61, PLANET)),
        "pin": gb.Shaft("pin", length=0.02, outer_diameter=0.02, material=RIGID, elements=2),
        "bearing": gb.Bearing("pin", 0.01, stiffness=PIN, tilting_stiffness=UPRIGHT),
        "sun_mesh": gb.Mesh("sun", "planet", stiffness=MESH),
        "ring_mesh": gb.Mesh("planet", "ring", stiffness=MESH),
    }
    return gb.PlanetaryStage(**(given | changes))


def system(given: gb.PlanetaryStage, sun: int = SUN, **changes: Any) -> gb.RotorSystem:
    tooth = {"module": MODULE, "pressure_angle": ALPHA}
    parts: dict[str, Any] = {
        "shafts": [
            gb.Shaft(name, length=0.02, outer_diameter=0.02, material=RIGID, elements=2)
            for name in ("in", "out")
        ],
        "gears": [gb.Gear("sun", "in", 0.01, teeth=sun, **tooth, **body(0.4, 0.39, sun))],
        "bearings": [
            gb.Bearing(name, 0.01, stiffness=BEARING, tilting_stiffness=UPRIGHT)
            for name in ("in", "out")
        ],
        "planetary_stages": [given],
    }
    return gb.RotorSystem(**(parts | changes))


PUBLISHED = {
    3: (
        (1475.7, 1930.3, 2658.3, 7462.8, 11775.3),
        (743.2, 1102.4, 1896.0, 2276.4, 6986.3, 9647.9),
        (),
    ),
    4: (
        (1536.5, 1970.6, 2625.7, 7773.6, 13071.1),
        (727.3, 1091.2, 1892.8, 2342.5, 7189.9, 10437.6),
        (1808.2, 5963.8, 6981.7),
    ),
}


@pytest.mark.parametrize("planets", [3, 4, 5])
def test_modes_of_lin_and_parker(planets: int):
    """Rotational modes are single, translational ones double, planet modes (N − 3)-fold."""
    radius = MODULE * (SUN + PLANET) / 2
    carrier = gb.Housing(
        "carrier",
        mass=5.43,
        stiffness=BEARING,
        inertia=(6.29 * radius**2, 0.03, 0.03),
        position=(0.01, 0.0, 0.0),
        rotational_stiffness=(0.0, UPRIGHT, UPRIGHT),
    )
    hold = gb.Drive("ring", stiffness=RING_ROTATION * base(RING) ** 2)
    train = system(stage(planets, carrier="carrier"), housings=[carrier], drives=[hold])
    found = np.sort(train.modes(0.0, count=19 + 3 * (planets - 3)).frequencies_hz)
    # the ring turns with the sun, planets and carrier
    assert found[0] < 1e-3
    found = found[1:]
    kinds = PUBLISHED.get(planets, ((), (), PUBLISHED[4][2]))
    expected = np.sort([*kinds[0], *np.repeat(kinds[1], 2), *np.repeat(kinds[2], planets - 3)])
    if planets == 5:
        # only the planet modes are published: double here
        for value in kinds[2]:
            assert np.sum(np.abs(found - value) < 0.1) == 2
    else:
        # printed with one decimal; the shafts are nearly rigid
        assert found[: len(expected)] == pytest.approx(expected, abs=0.15)


def test_a_star_gear_is_the_train_of_its_meshes():
    angles = [0.0, 2 * np.pi / 3, -2 * np.pi / 3]
    train = system(stage(angles))
    assert train.speed_ratios == pytest.approx([1.0, -SUN / RING, *[-SUN / PLANET] * 3], rel=1e-15)
    explicit = gb.RotorSystem(
        shafts=train.shafts,
        gears=train.gears,
        meshes=[
            mesh
            for i, angle in enumerate(angles, start=1)
            for mesh in (
                gb.Mesh("sun", f"planet {i}", stiffness=MESH, centre_line_angle=angle),
                gb.Mesh(
                    f"planet {i}",
                    "ring",
                    stiffness=MESH,
                    centre_line_angle=float(np.remainder(angle + 2 * np.pi, 2 * np.pi) - np.pi),
                ),
            )
        ],
        bearings=train.bearings,
    )
    one, other = (each.modes(100.0, count=12).eigenvalues for each in (train, explicit))
    # angles of the lines of centres differ by round-off
    assert one == pytest.approx(other, rel=1e-9, abs=1e-6)
    assert gb.RotorSystem.from_dict(train.description).meshes == train.meshes


@pytest.mark.parametrize("drives", ["sun", "ring"])
def test_planets_share_the_load_and_power_is_conserved(drives: str):
    torque = 100.0
    meshes = {
        "sun": {},
        "ring": {
            "sun_mesh": gb.Mesh("planet", "sun", stiffness=MESH),
            "ring_mesh": gb.Mesh("ring", "planet", stiffness=MESH),
        },
    }[drives]
    driven = "ring" if drives == "sun" else "sun"
    torques = [gb.Torque(drives, torque), gb.Torque.balance(driven)]
    train = system(stage(3, **meshes), torques=torques)
    still = train.static(speed=10.0, geometry="frozen")
    radius = base(SUN if drives == "sun" else RING)
    for mesh in train.meshes:
        force = float(still.mesh((mesh.driver, mesh.driven)).force)
        assert abs(force) == pytest.approx(torque / 3 / radius, rel=1e-8)


def test_a_displaced_pin_unloads_its_planet_by_the_hand_calculation():
    """F_i (2/k + 4 cos²α/k_p) = u_s − 2 e_i cos α for stiff centres of sun and ring."""
    torque, offset = 300.0, 50e-6
    stiff = [
        gb.Bearing(name, 0.01, stiffness=1e15, tilting_stiffness=UPRIGHT) for name in ("in", "out")
    ]
    # An offset e of a pin is the force k_p e on its planet, at angle 0 along z with the drive.
    push = gb.Force("planet 1", 1j * PIN * offset)
    torques = [gb.Torque("sun", torque), gb.Torque.balance("ring")]
    train = system(stage(3), bearings=stiff, forces=[push], torques=torques)
    still = train.static(speed=10.0, geometry="frozen")
    forces = np.array(
        [float(still.mesh(("sun", f"planet {i}")).force) for i in (1, 2, 3)], dtype=float
    )
    compliance = 2 / MESH + 4 * np.cos(ALPHA) ** 2 / PIN
    mean = torque / base(SUN) / 3
    loss = 2 * offset * np.cos(ALPHA) / compliance
    expected = mean + loss * np.array([-2 / 3, 1 / 3, 1 / 3])
    # bearings of 1e15 N/m against meshes of 5e8
    assert forces == pytest.approx(expected, rel=1e-5)


@pytest.mark.parametrize(("teeth", "in_phase"), [((24, 24, 72), True), ((25, 23, 71), False)])
def test_phases_of_the_planets_cancel_forces_or_torques(
    teeth: tuple[int, int, int], in_phase: bool
):
    """Planets in phase excite the rotation, those in sequence the translation of sun and ring."""
    sun, planet, ring = teeth
    tooth = {"module": MODULE, "pressure_angle": ALPHA}
    square = gb.Stiffness.square(pair=MESH)
    given = stage(
        3,
        ring=gb.RingGear("ring", ring, "out", position=0.01, **tooth, **body(2.35, 3.0, ring)),
        planet=gb.Gear("planet", "pin", 0.01, teeth=planet, **tooth, **body(0.66, 0.61, planet)),
        bearing=gb.Bearing("pin", 0.01, stiffness=PIN, damping=2e4, tilting_stiffness=UPRIGHT),
        sun_mesh=gb.Mesh("sun", "planet", stiffness=square, damping_ratio=0.1),
        ring_mesh=gb.Mesh("planet", "ring", stiffness=square, damping_ratio=0.1),
    )
    torques = [gb.Torque("sun", 100.0), gb.Torque.balance("ring")]
    bearings = [
        gb.Bearing(name, 0.01, stiffness=BEARING, damping=2e4, tilting_stiffness=UPRIGHT)
        for name in ("in", "out")
    ]
    train = system(given, sun, torques=torques, bearings=bearings)
    speed = 5.0
    cycle = 2 * np.pi / sun / speed
    times = np.linspace(6 * cycle, 7 * cycle, 64, endpoint=False)
    run = train.simulate(
        7 * cycle, speed=speed, times=times, initial="static", geometry="frozen", rtol=1e-7
    )

    def harmonic(values: np.ndarray) -> float:
        return float(np.abs(np.fft.rfft(values)[1]))

    for gear, radius in (("sun", base(sun)), ("ring", base(ring))):
        lateral = harmonic(run.displacement(gear)[:, 0])
        twist = radius * harmonic(run.twist(gear))
        small, large = (lateral, twist) if in_phase else (twist, lateral)
        assert small < 1e-3 * large


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"carrier": "in"}, r'planetary_stages\[0\]\.carrier: "in" is a shaft: give the disk'),
        (
            {"ring": gb.RingGear("ring", RING, module=MODULE)},
            r"planetary_stages\[0\]\.ring\.support: a ring on the ground does not turn",
        ),
        ({"planets": 7}, r"planetary_stages\[0\]\.planets: the teeth of a planet at 0\.897598 rad"),
        ({"planets": []}, r"planetary_stages\[0\]\.planets: at least one planet"),
        ({"planets": "3"}, r"planetary_stages\[0\]\.planets: must be a whole number or a list"),
        ({"sun": "sum"}, r'planetary_stages\[0\]\.sun: no gear is called "sum"'),
        ({"ring": "sun"}, r"planetary_stages\[0\]\.ring: the ring needs internal=True"),
        (
            {"sun_mesh": gb.Mesh("sun", "ring")},
            r'planetary_stages\[0\]\.sun_mesh: must be between "sun" and "planet"',
        ),
        (
            {"sun_mesh": gb.Mesh("planet", "sun", stiffness=MESH)},
            r"planetary_stages\[0\]: the power flows from the sun",
        ),
        (
            {"ring_mesh": gb.Mesh("ring", "planet", stiffness=MESH)},
            r"planetary_stages\[0\]: the power flows from the sun",
        ),
    ],
)
def test_impossible_stages_are_errors(changes: dict[str, Any], message: str):
    with pytest.raises(gb.SceneError, match=message):
        system(stage(**changes))
