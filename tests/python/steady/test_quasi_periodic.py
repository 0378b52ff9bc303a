"""Steady motions without a common period, which run in."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gearbow as gb
from reference import machines
from test_steady_state import difference, without_period

MESH = ("pinion", "wheel")
MIDDLE = ("rotor", 0.5)


def pair(teeth: int, **mesh: Any) -> gb.RotorSystem:
    """Return two bowed shafts with a gear in the middle of each; the pinion has 25 teeth."""
    return machines.pair(
        machines.SHAFTS,
        MESH,
        (25, teeth),
        shaft={"elements": None, "bow": gb.Bow.half_sine(1e-4)},
        mesh={"damping_ratio": 0.05, **mesh},
        modal_damping=0.01,
    )


def rotor(bearing: Any, **forces: float) -> gb.RotorSystem:
    """Return a bowed rotor with a disk on two bearings, and forces of given orders."""
    return machines.rotor(
        {"bow": gb.Bow.half_sine(2e-5)},
        machines.inertia(20.0, 0.05, 0.1, unbalance=1e-4),
        bearings=[bearing(x) for x in (0.1, 0.9)],
        forces=[gb.Force("disk", 50.0, order=order) for order in forces.values()],
        gravity=9.81,
        modal_damping=0.02,
    )


def film(x: float) -> gb.JournalBearing:
    return gb.JournalBearing("rotor", x, diameter=0.06, length=0.03, clearance=6e-5, viscosity=0.03)


def rolling(x: float) -> gb.RollingBearing:
    return gb.RollingBearing(
        "rotor", x, elements=9, element_diameter=0.0119, pitch_diameter=0.052, clearance=1e-5
    )


def relative(found: np.ndarray, exact: np.ndarray) -> float:
    """Return the RMS of a difference over the RMS of the signal about its mean."""
    return float(np.linalg.norm(found - exact) / np.linalg.norm(exact - exact.mean(axis=0)))


@pytest.mark.filterwarnings("ignore::gearbow.SceneWarning")
@pytest.mark.parametrize(
    ("stiffness", "geometry"),
    [
        (None, "live"),
        (gb.Stiffness.fourier(2e8, [2e7]), "live"),
        (gb.Stiffness.fourier(2e8, [2e7]), "frozen"),
    ],
)
def test_trains_equal_running_in(stiffness: gb.Stiffness | None, geometry: str, tmp_path: Path):
    # the transient of the run has decayed after 0.8 s
    system = without_period().replace(modal_damping=0.04)
    if stiffness is not None:
        meshes = [replace(mesh, stiffness=stiffness) for mesh in system.meshes]
        system = system.replace(meshes=meshes)
    options: dict[str, Any] = {"geometry": geometry, "rtol": 1e-9}
    steady = system.steady_state(100.0, max_period=0.5, **options)
    assert (steady.method, steady.period) == ("quasi-periodic", np.inf)
    # A run continues without a transient; that of the other one has decayed.
    end = 0.8
    times = end + np.linspace(0.0, 0.05, 40)
    rest = times[-1] + 1e-9 - steady.response.final["time"]
    continued = system.simulate(rest, 100.0, initial=steady.response, times=times, **options)
    run_in = system.simulate(times[-1] + 1e-9, 100.0, initial="static", times=times, **options)
    assert difference(continued, run_in) < 1e-6
    path = tmp_path / "steady.npz"
    steady.save(path)
    assert gb.SteadyState.load(path).method == "quasi-periodic"


@pytest.mark.parametrize("backlash", [None, 1e-4])
def test_sharp_engagement_has_the_motion_of_the_hunting_tooth_period(backlash: float | None):
    system = pair(47, stiffness=gb.Stiffness.square(1.5e8), backlash=backlash)
    steady = system.steady_state(300.0, rtol=1e-5, max_period=0.1)
    assert steady.method == "quasi-periodic"
    assert steady.residual < 1e-4
    period = system.steady_state(300.0, rtol=1e-6)
    # 25 teeth of the pinion meet 47 of the wheel.
    assert period.period == pytest.approx(47 * 2 * np.pi / 300.0, rel=1e-14)
    end, times = period.response.final["time"], steady.response.time
    again = system.simulate(
        times[-1] + 1e-9, 300.0, initial=period.response, times=end + times, rtol=1e-6
    )
    found, exact = (
        np.c_[run.displacement("pinion"), run.displacement("wheel")]
        for run in (steady.response, again)
    )
    # what is transient is at most ten times the tolerance, and that of the displacements less
    assert relative(found, exact) < 1e-4
    assert relative(steady.response.mesh(MESH).force, again.mesh(MESH).force) < 1e-4


def test_a_long_period_begins_with_the_state_after_running_in():
    system = pair(51, stiffness=gb.Stiffness.square(1.5e8))
    steady = system.steady_state(100.0, rtol=1e-8, geometry="frozen")
    assert steady.period == pytest.approx(51 * 2 * np.pi / 100.0, rel=1e-14)
    assert steady.residual < 1e-7
    # One period is recorded; running in takes less than another one. Whole periods take six.
    assert steady.periods <= 2


@pytest.mark.parametrize(
    ("system", "speed"),
    [(rotor(film, one=np.pi / 2), 200.0), (rotor(rolling), 50.0), (rotor(rolling), 200.0)],
    ids=["oil film", "rolling elements, slow", "rolling elements, fast"],
)
def test_nonlinear_bearings_equal_running_in(system: gb.RotorSystem, speed: float):
    options: dict[str, Any] = {"rtol": 1e-7, "record": [MIDDLE]}
    steady = system.steady_state(speed, **options)
    assert steady.method == "quasi-periodic"
    assert steady.is_stable()
    end = 2.0
    times = end + np.linspace(0.0, 0.05, 200)
    rest = times[-1] + 1e-9 - steady.response.final["time"]
    continued = system.simulate(rest, speed, initial=steady.response, times=times, **options)
    run_in = system.simulate(times[-1] + 1e-9, speed, initial="static", times=times, **options)
    assert relative(continued.displacement(MIDDLE), run_in.displacement(MIDDLE)) < 1e-6
    # what is transient is at most ten times the tolerance
    assert steady.residual <= 1e-6


def test_a_motion_that_does_not_settle_is_an_error():
    # The oil whirls: the motion contains a frequency that is none of the excitation.
    system = rotor(film, one=np.pi / 2)
    with pytest.raises(gb.ConvergenceError, match=r"does not settle .*run in with simulate"):
        system.steady_state(900.0, rtol=1e-6, record=[MIDDLE])


def test_rolling_bearings_take_a_short_run_in():
    steady = rotor(rolling).steady_state(200.0, record=[MIDDLE])
    turn = 2 * np.pi / 200.0
    assert steady.response.time[-1] < 10 * turn
    # at 2 % damping the lowest mode decays to 1e-3 within 60 turns; the synchronous response is closer to the motion than
    # its own size
    assert steady.periods <= 60
    # an error of ten times the tolerance
    assert steady.residual <= 1e-3


@pytest.mark.parametrize("geometry", ["live", "frozen"])
def test_growing_parametric_vibrations_are_an_error(geometry: str):
    stiffness = gb.Stiffness.fourier(2e8, [1.2e8], phase="prescribed")
    system = pair(47, stiffness=stiffness)
    meshes = [replace(system.meshes[0], damping_ratio=0.001)]
    system = system.replace(meshes=meshes, modal_damping=0.001)
    # The tooth frequency is twice the frequency of the mode that deflects the mesh most.
    speed = 2 * np.pi * 2 * 2288.0 / 25
    with pytest.raises(gb.ConvergenceError, match="unstable"):
        system.steady_state(speed, geometry=geometry, rtol=1e-6, max_period=0.1)


def test_superposed_sources_are_those_of_the_frequency_response():
    speed = 110.0
    forces = [
        gb.Force(("a", 0.36), 40.0, order=np.sqrt(2.0)),
        gb.Force("idler", 30.0 + 10.0j, order=np.sqrt(3.0)),
        gb.Force("wheel", 20.0, order=np.sqrt(5.0)),
    ]
    system = machines.uneven_train(forces=forces)
    record = ["gears", "meshes"]
    steady = system.steady_state(speed, geometry="frozen", rtol=1e-9, max_period=0.5, record=record)
    assert (steady.method, steady.period) == ("superposition", np.inf)
    ratio = dict(zip(("a", "b", "c"), system.speed_ratios, strict=True))
    # A force that turns with F e^{iωt} has the phasors F along y and -iF along z.
    sources: list[tuple[float, Any]] = [
        (
            order * ratio[shaft],
            gb.Force(force.at, (complex(force.value), -1j * complex(force.value))),
        )
        for force, shaft in zip(forces, "abc", strict=True)
        for order in [force.order]
    ]
    sources.append((31 * ratio["b"], gb.MeshExcitation("idler/wheel", 2e-6 * np.exp(0.4j))))
    time = steady.response.time
    static = system.replace(forces=[]).static(speed, geometry="frozen")
    waves = [np.exp(1j * order * speed * time) for order, _ in sources]
    responses = [
        system.frequency_response([order * speed], source=source, speed=speed)
        for order, source in sources
    ]

    def sums(static: Any, read: Any) -> np.ndarray:
        found = [
            np.real(np.multiply.outer(w, read(x)[0, 0]))
            for w, x in zip(waves, responses, strict=True)
        ]
        return static + np.sum(found, axis=0)

    for pair in (("pinion", "idler"), ("idler", "wheel")):
        exact = sums(static.mesh(pair).force, lambda x, pair=pair: x.mesh_force(pair))
        # the tolerance of the solution, relative to the varying part
        assert relative(steady.response.mesh(pair).force, exact) < 1e-6
    for gear in ("pinion", "idler", "wheel"):
        exact = sums(static.displacement(gear), lambda x, gear=gear: x.displacement(gear))
        assert relative(steady.response.displacement(gear), exact) < 1e-6
