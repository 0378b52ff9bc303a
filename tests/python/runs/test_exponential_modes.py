"""Modal basis: subsets of modes, and no modal basis for nearly parallel modes."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import gearbow as gb
from reference.bows import HalfSine
from reference.scenes import PAIR, GearAt, Geared
from reference.teeth import Toothed

pytestmark = pytest.mark.filterwarnings("ignore::gearbow.errors.AccuracyWarning")

SPEED = 600.0
BOWED = Toothed(
    coupled=True,
    torque=80.0,
    bows={"a": HalfSine(5e-5, 0.4), "b": HalfSine(3e-5, -1.0)},
    mesh={"centre_line_angle": 0.3},
    bearing_damping=0.0,
)
SMOOTH = {"model": "square", "pair": 1.5e8, "engagement": 0.2}
SHARP = {"model": "square", "pair": 1.5e8, "engagement": "sharp"}


def with_mesh(scene: Toothed, **mesh: Any) -> Toothed:
    return replace(scene, mesh={**scene.mesh, **mesh})


def distance(found: gb.Response, exact: gb.Response) -> float:
    first, second = exact.recorded[:2]
    worst = 0.0
    for gear in (first, second):
        for a, b in (
            (found.displacement(gear), exact.displacement(gear)),
            (found.twist(gear), exact.twist(gear)),
        ):
            worst = max(worst, float(np.abs(a - b).max() / np.abs(b).max()))
    a, b = (run.mesh((first, second)).force for run in (found, exact))
    return max(worst, float(np.abs(a - b).max() / np.abs(b).max()))


# --- subset of the modes --------------------------------------------------------------------------


@pytest.mark.parametrize("initial", ["rest", "static", "synchronous"])
def test_the_error_falls_with_the_number_of_modes(initial: str):
    system = with_mesh(BOWED, stiffness=SMOOTH, damping_ratio=0.03).package()
    run = {"initial": initial, "times": np.linspace(0.0, 2e-3, 41)}
    every = system.simulate(2e-3, SPEED, **run)
    n = len(system.dofs)
    errors = [
        distance(system.simulate(2e-3, SPEED, modes=count, **run), every) for count in (6, 10, 14)
    ]
    # So few modes carry little of the motion: 0.7 to 1.0 with six, 0.11 to 0.14 with fourteen.
    assert errors[0] > errors[1] > 1.5 * errors[2]
    assert errors[0] > 4.0 * errors[2]
    assert errors[2] > 1e-6  # these modes are omitted
    for count in (n, n + 5):
        # all modes, summed in a different order
        assert distance(system.simulate(2e-3, SPEED, modes=count, **run), every) < 1e-10


def test_the_synchronous_motion_needs_no_modes():
    scene = Geared(
        shafts=("s",),
        gears=(GearAt("g", "s", 0.25, 25, unbalance=1e-3),),
        meshes=(),
        angles=(),
        ratios=(1.0,),
        torque=0.0,
        bows={"s": HalfSine(1e-4)},
    )
    system = scene.package()
    few, every = (
        system.simulate(0.02, 400.0, output_step=1e-3, modes=modes, record=["g"])
        for modes in (1, None)
    )
    # it is integrated in full, in addition to the modes
    gap = np.abs(few.displacement("g") - every.displacement("g")).max()
    assert gap < 1e-11 * np.abs(every.displacement("g")).max()


def test_a_bowed_shaft_from_rest_needs_a_few_modes():
    scene = Geared(
        shafts=("s",),
        gears=(GearAt("g", "s", 0.25, 25),),
        meshes=(),
        angles=(),
        ratios=(1.0,),
        torque=0.0,
        bows={"s": HalfSine(1e-4)},
        elements=8,
    )
    system = scene.package()
    run: dict[str, Any] = {"initial": "rest", "output_step": 5e-4, "record": ["g"]}
    every = system.simulate(0.02, 400.0, **run).displacement("g")
    errors = []
    for count in (2, 8, 16):
        few = system.simulate(0.02, 400.0, modes=count, **run).displacement("g")
        errors.append(float(np.abs(few - every).max() / np.abs(every).max()))
    assert errors[0] < 0.05
    assert errors[0] > errors[1] > 4 * errors[2]


# --- parallel modes -------------------------------------------------------------------------------

# Only the rigid-body rotation is damped, and very weakly: it comes to rest after minutes.
HARDLY = {"rayleigh": (1e-8, 0.0)}
CASES: dict[str, dict[str, Any]] = {
    "mean": {"stiffness": 2e8},
    "smooth": {"stiffness": SMOOTH},
    "smooth, twist": {"stiffness": {**SMOOTH, "phase": "twist"}},
    "sharp": {"stiffness": SHARP},
    "backlash": {"stiffness": SMOOTH, "backlash": 1e-5},
    "damped": {"stiffness": SMOOTH, "damping": 800.0},
}


@pytest.mark.parametrize("geometry", ["live", "frozen"])
@pytest.mark.parametrize("name", CASES)
def test_a_rigid_body_rotation_with_weak_damping(name: str, geometry: str):
    options = {} if name == "damped" else HARDLY
    scene = replace(with_mesh(BOWED, **CASES[name]), options=options)
    system = scene.package()
    run: dict[str, Any] = {
        "initial": "static",
        "geometry": geometry,
        "times": np.linspace(0.0, 2e-3, 41),
    }
    exact = system.simulate(2e-3, SPEED, method="rk45", rtol=1e-11, **run)
    found = system.simulate(2e-3, SPEED, rtol=1e-9, **run)
    assert found.statistics.condition < 10.0
    # tolerance of a hundred steps, amplified by contact changes
    assert distance(found, exact) < 3e-7


def test_such_a_run_in_parts_is_bitwise_equal():
    scene = replace(with_mesh(BOWED, stiffness=SHARP), options=HARDLY)
    system = scene.package()
    times = np.linspace(0.0, 2e-3, 21)
    whole = system.simulate(2e-3, SPEED, times=times)
    first = system.simulate(8.3e-4, SPEED, times=times[:9])
    second = system.simulate(2e-3 - 8.3e-4, SPEED, initial=first, times=times[9:])
    assert np.array_equal(second.final["state"], whole.final["state"])
    rows = np.concatenate([first.twist("ga"), second.twist("ga")])
    assert np.array_equal(rows, whole.twist("ga"))
    assert (*first.events, *second.events) == whole.events


def tilting() -> gb.RotorSystem:
    """Return a free shaft whose rotation is so slow that its tilting motion is hardly
    distinguishable from rest.
    """
    gear = gb.Gear("g", "s", 0.1, teeth=25, module=3e-3, face_width=0.02)
    return gb.RotorSystem(
        shafts=[gb.Shaft("s", length=0.3, outer_diameter=0.03, elements=3)],
        gears=[gear],
        gravity=[0.0, -9.81],
    )


def test_a_motion_without_modal_basis():
    system = tilting()
    run: dict[str, Any] = {"initial": "rest", "times": np.linspace(0.0, 2e-3, 21)}
    with pytest.warns(gb.AccuracyWarning, match="nearly parallel.*rk45"):
        found = system.simulate(2e-3, 1e-3, **run)
    assert found.statistics.condition > 1e8
    exact = system.simulate(2e-3, 1e-3, method="rk45", rtol=1e-11, **run)
    fallen = found.displacement("g")
    assert np.abs(fallen - exact.displacement("g")).max() < 1e-9 * np.abs(fallen).max()


def test_a_steady_state_needs_modes_that_are_not_parallel():
    gear = gb.Gear("g", "s", 0.1, teeth=25, module=3e-3, face_width=0.02)
    bow = gb.Bow.half_sine(1e-4)
    shaft = gb.Shaft("s", length=0.3, outer_diameter=0.03, elements=3, bow=bow)
    system = gb.RotorSystem(shafts=[shaft], gears=[gear])
    with pytest.raises(gb.ConvergenceError, match="the modes are nearly parallel"):
        system.steady_state(1e-3)


def test_etdrk4_needs_modes_that_are_not_parallel():
    with pytest.raises(gb.SceneError, match=r'^method: .*parallel.*"rk45"'):
        tilting().simulate(1e-3, 1e-3, method="etdrk4", initial="rest")


@pytest.mark.parametrize("geometry", ["live", "frozen"])
@pytest.mark.parametrize("speed", [0.0, 100.0])
@pytest.mark.parametrize("ratio", [1.0, 1.0 - 1e-12, 1.0 - 1e-6, 1.5])
@pytest.mark.implausible
def test_critical_damping_of_every_mode(ratio: float, speed: float, geometry: str):
    bows = {"input": HalfSine(1e-4, 0.3), "output": HalfSine(5e-5)}
    scene = replace(PAIR, elements=2, bows=bows, modal_damping=ratio)
    scene = replace(scene, bearing_damping=0.0, mesh_damping_ratio=0.0)
    system = scene.package()
    run: dict[str, Any] = {
        "initial": "rest",
        "geometry": geometry,
        "times": np.linspace(0.0, 5e-3, 41),
    }
    exact = system.simulate(5e-3, speed, method="rk45", rtol=1e-10, **run)
    found = system.simulate(5e-3, speed, rtol=1e-9, **run)
    # modes that are parallel up to the square root of round-off lose half of the digits
    assert distance(found, exact) < 1e-7
    if ratio == 1.0:
        assert found.statistics.condition > 1e5


@pytest.mark.implausible
def test_a_critically_damped_bearing():
    # a stiff shaft on one soft bearing at its middle: vertical motion at 2e3 rad/s, critically
    # damped
    bearing = {"stiffness": 4e6, "damping": 0.0}
    shaft = gb.Shaft("s", length=0.2, outer_diameter=0.08, elements=2, bow=gb.Bow.half_sine(1e-5))

    def system(damping: float) -> gb.RotorSystem:
        middle = gb.Bearing("s", position=0.1, stiffness=bearing["stiffness"], damping=damping)
        return gb.RotorSystem(shafts=[shaft], bearings=[middle], gravity=[0.0, -9.81])

    # critical damping of the slow pair, to round-off
    low, high = 0.0, 1e5
    for _ in range(60):
        damping = (low + high) / 2
        slowest = np.array([m for m in system(damping).modes().eigenvalues if abs(m) > 1.0])
        bounce = slowest[np.argmin(np.abs(slowest + 2e3))]
        low, high = (damping, high) if abs(bounce.imag) > 0.0 else (low, damping)
    critical = system(damping)
    run: dict[str, Any] = {"initial": "rest", "output_step": 1e-4, "record": ["nodes"]}
    exact = critical.simulate(5e-3, 50.0, method="rk45", rtol=1e-11, **run)
    found = critical.simulate(5e-3, 50.0, **run)
    for x in (0.0, 0.1, 0.2):
        a, b = found.displacement(("s", x)), exact.displacement(("s", x))
        assert np.abs(a - b).max() < 1e-7 * np.abs(b).max()
