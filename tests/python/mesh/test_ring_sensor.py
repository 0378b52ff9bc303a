"""A sensor beside a ring, past which planets move: its window, its side bands and its errors."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import gearbow as gb

TOOTH: dict[str, Any] = {"module": 3e-3, "face_width": 0.025}
#: Places of planets between 24 and 72 teeth: multiples of 2π/96, not equally spaced.
PLACES = 2.0 * np.pi / 96.0 * np.array([0.0, 31.0, 65.0])
SUN, RING = 24, 72
CARRIER = SUN / (SUN + RING)  # speed of the carrier over that of the sun


def reducer(*, planets: int | list[float], reverse: bool = False) -> gb.RotorSystem:
    """Return a planetary set in torsion whose carrier turns; reversed, the carrier drives it."""
    meshes = [
        gb.Mesh("sun", "planet", damping_ratio=0.05),
        gb.Mesh("planet", "ring", damping_ratio=0.05),
    ]
    if reverse:
        meshes = [gb.Mesh(each.driven, each.driver, damping_ratio=0.05) for each in meshes]
    stage = gb.PlanetaryStage(
        sun="sun",
        ring=gb.RingGear("ring", RING, **TOOTH, rotational_stiffness=5e6, rotational_damping=500.0),
        planets=planets,
        carrier="carrier",
        planet=gb.Gear("planet", "pin", 0.0125, teeth=24, **TOOTH),
        sun_mesh=meshes[0],
        ring_mesh=meshes[1],
    )
    torque = -60.0 if reverse else 60.0
    return gb.RotorSystem(
        shafts=[gb.Shaft(name, length=0.1, outer_diameter=0.03) for name in ("input", "output")],
        gears=[gb.Gear("sun", "input", 0.05, teeth=SUN, **TOOTH)],
        disks=[gb.Disk("carrier", "output", 0.05, 2.0, 0.004, 0.007)],
        torques=[gb.Torque("sun", torque), gb.Torque.balance("carrier")],
        planetary_stages=[stage],
        motion="torsion",
    )


def run_of(system: gb.RotorSystem, speed: float, turns: float) -> gb.Response:
    """Return a run over turns of the carrier, from the equilibrium."""
    duration = turns * 2.0 * np.pi / abs(CARRIER * speed)
    return system.simulate(duration, speed=speed, initial="static")


@pytest.mark.parametrize("reverse", [False, True])
@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_each_planet_has_its_window(sense: float, reverse: bool) -> None:
    """The weight of a planet follows from its place on the turning carrier."""
    speed, at, width = sense * 300.0, 0.7, 1.1
    run = run_of(reducer(planets=PLACES.tolist(), reverse=reverse), speed, 1.2)
    expected = np.zeros_like(run.time)
    for i, place in enumerate(PLACES, start=1):
        pair = ("ring", f"planet {i}") if reverse else (f"planet {i}", "ring")
        towards = np.exp(1j * (place + CARRIER * speed * run.time - at))
        window = np.where(
            np.abs(np.angle(towards)) < width,
            0.5 + 0.5 * np.cos(np.pi * np.angle(towards) / width),
            0.0,
        )
        expected += window * run.mesh(pair).force
    measured = run.measure(gb.RingSensor("ring", angle=at, width=width))
    assert np.ptp(expected) > 100.0
    # Angles after a turn have rounding errors of 1e-15; forces are up to 600 N.
    np.testing.assert_allclose(measured, expected, atol=1e-9)


def test_equal_planets_modulate_with_their_frequency() -> None:
    """Equal forces F of N planets: F cos²(Nβ/2), with F/2 at N times the speed of the carrier."""
    speed = 300.0
    run = run_of(reducer(planets=3), speed, 4.0)
    force = run.mesh(("planet 1", "ring")).force
    np.testing.assert_allclose(force, force[0], rtol=1e-6)
    signal = run.measure(gb.RingSensor("ring", angle=0.3))
    phase = 3.0 * (CARRIER * speed * run.time - 0.3)
    np.testing.assert_allclose(signal, 0.5 * force[0] * (1.0 + np.cos(phase)), rtol=1e-6, atol=1e-3)


def test_star_gear_has_constant_weights() -> None:
    """Planets on pins at rest stay at their places; the sensor takes the units of a force."""
    stage = gb.PlanetaryStage(
        sun="sun",
        ring=gb.RingGear("ring", RING, support="output", position=0.05, **TOOTH),
        planets=3,
        planet=gb.Gear("planet", "pin", 0.0125, teeth=24, **TOOTH),
        bearing=[gb.Bearing("pin", x, stiffness=1e8, damping=500.0) for x in (0.0, 0.025)],
    )
    star = gb.RotorSystem(
        shafts=[gb.Shaft(name, length=0.1, outer_diameter=0.03) for name in ("input", "output")],
        gears=[gb.Gear("sun", "input", 0.05, teeth=SUN, **TOOTH)],
        bearings=[
            gb.Bearing(shaft, x, stiffness=1e8, damping=500.0)
            for shaft in ("input", "output")
            for x in (0.0, 0.1)
        ],
        torques=[gb.Torque("sun", 60.0), gb.Torque.balance("ring")],
        planetary_stages=[stage],
    )
    run = star.simulate(0.002, speed=300.0)
    sensor = gb.RingSensor("ring", angle=0.2)
    weight = np.cos(1.5 * 0.2) ** 2
    first = run.mesh(("planet 1", "ring")).force
    np.testing.assert_allclose(run.measure(sensor), weight * first, rtol=1e-12)
    assert sensor.unit == "N"
    assert sensor.label in run.to_dataframe([sensor]).columns[-1]


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        (
            lambda: gb.RingSensor(3),  # type: ignore[arg-type]
            "ring_sensor.ring",
        ),
        (lambda: gb.RingSensor("ring", angle=np.nan), "ring_sensor.angle"),
        (lambda: gb.RingSensor("ring", width=0.0), "ring_sensor.width"),
        (lambda: gb.RingSensor("ring", width=3.2), r"ring_sensor.width: must be at most π"),
    ],
)
def test_wrong_values_are_named(wrong: Callable[[], object], message: str) -> None:
    """An error names the field."""
    with pytest.raises(gb.SceneError, match=message):
        wrong()


def test_what_cannot_be_measured_is_said() -> None:
    """An external gear, meshes that were not recorded, and harmonic motions have no signal."""
    system = reducer(planets=3)
    run = run_of(system, 300.0, 0.1)
    with pytest.raises(gb.ChannelError, match='"sun"; there are ring'):
        run.measure(gb.RingSensor("sun"))
    few = system.simulate(0.001, speed=300.0, record=["sun"])
    with pytest.raises(gb.ChannelError, match="planet 1"):
        few.measure(gb.RingSensor("ring"))
    harmonic = system.frequency_response([100.0], source=gb.Torque("sun", 1.0), speed=300.0)
    with pytest.raises(gb.SceneError, match="planets pass a sensor"):
        harmonic.measure(gb.RingSensor("ring"))
