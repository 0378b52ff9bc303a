"""No result depends on what its system computed before, to the last bit."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from threading import Barrier
from typing import Any

import numpy as np
import pytest

import gearbow as gb
from test_checkpoint import EnoughError, Pause, Stop

# 12 of 30 modes leave an error of 2e-2 of the displacements.
pytestmark = pytest.mark.filterwarnings("ignore:modes. 12 modes leave:gearbow.AccuracyWarning")

GEAR = {"position": 0.25, "module": 3e-3, "face_width": 0.03}
SYSTEM = gb.RotorSystem(
    shafts=[
        gb.Shaft(name, length=0.5, outer_diameter=0.05, elements=2, bow=gb.Bow.half_sine(1e-4))
        for name in ("input", "output")
    ],
    gears=[
        gb.Gear("g1", "input", teeth=25, unbalance=1e-4, **GEAR),
        gb.Gear("g2", "output", teeth=50, **GEAR),
    ],
    meshes=[gb.Mesh("g1", "g2", stiffness=2e8, damping_ratio=0.05)],
    bearings=[
        gb.Bearing(shaft, position=x, stiffness=1e8, damping=500.0)
        for shaft in ("input", "output")
        for x in (0.0, 0.5)
    ],
    torques=[gb.Torque("g1", 250.0), gb.Torque.balance("g2")],
    modal_damping=0.01,
)


def run(speed: float = 100.0, duration: float = 0.01, **options: Any) -> Callable[..., bytes]:
    """Return a function that simulates a system and returns the bits of the result."""

    def found(system: gb.RotorSystem) -> bytes:
        given = {"record": ["gears", "meshes"], "output_step": duration / 20, **options}
        response = system.simulate(duration, speed, **given)
        return bits(response) if "record" not in options else places(response, options["record"])

    return found


def places(response: gb.Response, names: Any) -> bytes:
    """Return the bits of the recorded displacements and of the final state."""
    signals = [response.displacement(name) for name in names]
    return b"".join(
        np.ascontiguousarray(x).tobytes() for x in [*signals, np.asarray(response.final["state"])]
    )


def bits(response: gb.Response) -> bytes:
    """Return the bits of all displacements, of the mesh force, and of the final state."""
    return places(response, ["g1", "g2"]) + response.mesh(("g1", "g2")).force.tobytes()


def steady(system: gb.RotorSystem) -> bytes:
    return bits(system.steady_state(100.0, record=["gears", "meshes"]).response)


def synchronous(system: gb.RotorSystem) -> bytes:
    return np.ascontiguousarray(system.synchronous([90.0, 100.0]).displacement("g1")).tobytes()


#: Calls that share what a system keeps. Long runs choose a number of modes.
CALLS: dict[str, Callable[[gb.RotorSystem], bytes]] = {
    "default": run(),
    "12 modes": run(modes=12),
    "reduced": run(duration=0.31, rtol=1e-4),
    "loose": run(rtol=1e-3),
    "tight": run(rtol=1e-9),
    "frozen": run(geometry="frozen"),
    "backward": run(speed=-100.0),
    "from rest": run(initial="rest"),
    "rk45": run(method="rk45", duration=1e-3),
    "one gear": run(record=["g2"], modes=12),
    "steady": steady,
    "synchronous": synchronous,
}


def fresh() -> gb.RotorSystem:
    """Return a system that shares nothing with any other one."""
    return gb.RotorSystem.from_dict(SYSTEM.description)


@pytest.fixture(scope="module")
def wanted() -> dict[str, bytes]:
    """Return the result of each call on a system of its own."""
    return {name: call(fresh()) for name, call in CALLS.items()}


@pytest.mark.parametrize("first", CALLS)
def test_a_call_does_not_change_the_bits_of_the_next_one(first: str, wanted: dict[str, bytes]):
    for second, call in CALLS.items():
        system = fresh()
        CALLS[first](system)
        assert call(system) == wanted[second], f"{second} after {first}"


def test_threads_that_begin_together_have_the_same_bits(wanted: dict[str, bytes]):
    names = ("default", "12 modes", "default", "frozen")
    for _ in range(3):
        system, barrier = fresh(), Barrier(len(names))

        def together(
            name: str, system: gb.RotorSystem = system, barrier: Barrier = barrier
        ) -> bytes:
            barrier.wait()
            return CALLS[name](system)

        with ThreadPoolExecutor(len(names)) as pool:
            found = list(pool.map(together, names))
        assert found == [wanted[name] for name in names]


def test_a_resumed_run_does_not_depend_on_other_runs(tmp_path: Path, wanted: dict[str, bytes]):
    path = tmp_path / "run.npz"
    # a run long enough for several checks
    duration = 0.31
    options: dict[str, Any] = {"record": ["gears", "meshes"], "rtol": 1e-4}
    options["output_step"] = duration / 20
    with pytest.raises(EnoughError):
        fresh().simulate(duration, 100.0, **options, checkpoint=path, progress=Stop(Pause()))
    system = fresh()
    CALLS["12 modes"](system)
    found = system.simulate(duration, 100.0, **options, checkpoint=path)
    assert bits(found) == wanted["reduced"]


def test_a_variation_has_the_reduction_of_its_own_kind_of_run():
    # a steady state chooses the modes of its own run, a run takes those of the system that was varied
    base = fresh()
    options: dict[str, Any] = {"record": ["gears", "meshes"], "rtol": 1e-4}

    def runs(steady_first: bool) -> bytes:
        system = base.replace(gravity=9.81)
        calls = [
            lambda: bits(system.steady_state(100.0, initial="static", **options).response),
            lambda: bits(system.simulate(1.25663706143591, 100.0, initial="static", **options)),
        ]
        found = {i: calls[i]() for i in ((0, 1) if steady_first else (1, 0))}
        return found[0] + found[1]

    assert runs(True) == runs(False)


SIZE = {"diameter": 0.06, "length": 0.03, "clearance": 9e-5, "viscosity": 0.01}
#: Bearings with coefficients of each speed.
BEARINGS: dict[str, Callable[[float], Any]] = {
    **{
        profile: lambda x, profile=profile: gb.JournalBearing("s", x, **SIZE, profile=profile)
        for profile in ("plain", "two axial grooves", "lemon", "offset", "three-lobe", "four-lobe")
    },
    "tilting pads": lambda x: gb.TiltingPadBearing("s", x, **SIZE, pad_count=5, pad_inertia=1e-5),
    "balls": lambda x: gb.RollingBearing("s", x, "6212", clearance=1e-5),
    "table": lambda x: gb.Bearing(
        "s", x, stiffness=gb.SpeedTable([0.0, 700.0], [1e7, 2e7]), damping=1e3
    ),
}


@pytest.mark.filterwarnings("ignore:.* is unstable at:gearbow.AccuracyWarning")
@pytest.mark.parametrize("kind", BEARINGS)
@pytest.mark.parametrize("speed", [300.0, -300.0])
def test_results_of_a_speed_do_not_depend_on_the_speeds_before(kind: str, speed: float):
    system = gb.RotorSystem(
        [gb.Shaft("s", length=0.8, outer_diameter=0.06, elements=4, bow=gb.Bow.half_sine(1e-6))],
        disks=[gb.Disk("d", "s", 0.4, mass=15.0, diametral_inertia=0.1, polar_inertia=0.2)],
        bearings=[BEARINGS[kind](x) for x in (0.1, 0.7)],
        gravity=9.81,
        modal_damping=0.005,
        motion="lateral",
    )

    def after(*earlier: float) -> bytes:
        fresh = gb.RotorSystem.from_dict(system.description)
        for one in (*earlier, speed):
            static = fresh.static(one).displacement("d")
            found = [
                fresh.modes(one, count=4).eigenvalues,
                fresh.synchronous([one]).displacement("d"),
            ]
        return b"".join(np.ascontiguousarray(x).tobytes() for x in (static, *found))

    alone = after()
    assert all(after(*earlier) == alone for earlier in ([-speed], [2.0 * speed / 3.0, speed / 2.0]))
