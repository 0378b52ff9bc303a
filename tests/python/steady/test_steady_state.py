"""Steady-state response against running in, closed forms and published cases."""

from __future__ import annotations

import importlib.util
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gearbow as gb
from gearbow.orders import Kinematics
from gearbow.results.steady import instability
from reference.teeth import Toothed
from test_teeth_stability import MEISSNER, boundaries, criterion, monodromy

EXAMPLES = Path(__file__).parents[3] / "examples"
GEARS = ("g1", "g2", "g3", "g4")
PAIRS = (("g1", "g2"), ("g3", "g4"))


def train(**options: Any) -> gb.RotorSystem:
    """Return the train of the example with a bow of 5 % of the radius and 1 % damping."""
    spec = importlib.util.spec_from_file_location("bowed_train", EXAMPLES / "bowed_train.py")
    assert spec is not None
    assert spec.loader is not None
    example = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(example)
    return example.train(0.05 * example.RADIUS).replace(modal_damping=0.01, **options)


def signals(response: gb.Response) -> list[np.ndarray]:
    motion = [response.displacement(gear) for gear in GEARS]
    return [*motion, *(response.mesh(pair).force for pair in PAIRS)]


def difference(found: gb.Response, exact: gb.Response) -> float:
    """Return the largest RMS of a difference over the RMS of the signal about its mean."""
    pairs = zip(signals(found), signals(exact), strict=True)
    return max(
        float(np.sqrt(np.mean((a - b) ** 2) / np.mean((b - b.mean(axis=0)) ** 2))) for a, b in pairs
    )


@pytest.mark.parametrize(("geometry", "most"), [("frozen", 1e-8), ("live", 1e-6)])
def test_the_demo_train_equals_running_in_and_is_cheaper(geometry: str, most: float):
    system, speed = train(), 100.0
    options: dict[str, Any] = {"rtol": 1e-10, "geometry": geometry, "output_step": 2e-4}
    steady = system.steady_state(speed, initial="static", **options)
    # four revolutions of the input are one of the output
    assert steady.period == pytest.approx(4 * 2 * np.pi / speed, rel=1e-14)
    assert steady.method == ("linear" if geometry == "frozen" else "nonlinear")
    assert steady.residual < 1e-10
    last: Any = "static"
    periods, samples = 9, steady.response.time.size
    del options["output_step"]
    for number in range(periods):
        times = (number + np.arange(samples) / samples) * steady.period
        last = system.simulate(steady.period, speed, initial=last, times=times, **options)
    assert difference(steady.response, last) < most
    # Numbers of periods state the cost without a clock: a run-in to this error takes 8.
    assert steady.periods <= 8


def test_the_period_follows_from_the_teeth_and_the_excitation():
    speed = 100.0
    system = train()
    turn = 2 * np.pi / speed
    no_bow = [replace(shaft, bow=None) for shaft in system.shafts]
    one = [*no_bow[:2], system.shafts[2]]
    assert system.replace(shafts=one).steady_state(speed).period == pytest.approx(4 * turn)
    first = [system.shafts[0], *no_bow[1:]]
    assert system.replace(shafts=first).steady_state(speed).period == pytest.approx(turn)
    varying = gb.Stiffness.fourier(2e8, [1e7], phase="prescribed")
    meshes = [replace(system.meshes[0], stiffness=varying), system.meshes[1]]
    teeth = system.replace(shafts=no_bow, meshes=meshes)
    assert teeth.steady_state(speed).period == pytest.approx(turn / 25)
    both = [replace(mesh, stiffness=varying) for mesh in system.meshes]
    assert teeth.replace(meshes=both).steady_state(speed).period == pytest.approx(turn / 12.5)
    with pytest.raises(gb.SceneError, match="period: nothing in the scene excites"):
        system.replace(shafts=no_bow).steady_state(speed)
    with pytest.raises(gb.SceneError, match=r"longer than max_period = 0.01 s .*bow.*output"):
        system.steady_state(speed, max_period=0.01)


def test_the_hunting_tooth_period_of_coprime_teeth():
    toothed = Toothed(
        mesh={
            "stiffness": 2e8,
            "damping_ratio": 0.05,
            "error": {"driver": [(1e-6, 0.0)], "driven": [(1e-6, 0.0)]},
        },
        teeth=(23, 47),
        torque=50.0,
    )
    found = toothed.package().steady_state(200.0, rtol=1e-8)
    assert found.period == pytest.approx(47 * 2 * np.pi / 200.0, rel=1e-14)


def without_period(**options: Any) -> gb.RotorSystem:
    """Return the train with coprime teeth, errors of the teeth and a force of an irrational order."""
    system = train(**options)
    teeth = dict(zip(GEARS, (23, 47, 29, 61), strict=True))
    errors = [
        gb.TransmissionError(tooth=[(2e-6, 0.3)], driver=[(3e-6, 0.1)], driven=[(5e-6, 0.4)]),
        gb.TransmissionError(table=[0.0, 1e-6, 3e-6, 1e-6]),
    ]
    return system.replace(
        gears=[replace(gear, teeth=teeth[gear.name], unbalance=1e-4) for gear in system.gears],
        meshes=[
            replace(mesh, error=error) for mesh, error in zip(system.meshes, errors, strict=True)
        ],
        forces=[gb.Force("g2", 100.0, order=np.pi), gb.Force("g4", 30.0, order=1)],
    )


@pytest.mark.filterwarnings("ignore::gearbow.SceneWarning")
def test_motions_without_a_common_period_superpose(tmp_path: Path):
    system, speed = without_period(), 100.0
    options: dict[str, Any] = {"geometry": "frozen", "rtol": 1e-9}
    steady = system.steady_state(speed, output_step=0.1, max_period=0.5, **options)
    assert (steady.method, steady.period) == ("superposition", np.inf)
    # Both runs reach the same time; the first one has no transient, that of the second has decayed.
    end = 2.0
    times = end + np.linspace(0.0, 0.05, 40)
    rest = end - steady.response.final["time"]
    continued = system.simulate(rest, speed, initial=steady.response, times=[end], **options)
    run_in = system.simulate(end, speed, initial="static", times=[end], **options)
    found, exact = (
        system.simulate(0.05, speed, initial=last, times=times, **options)
        for last in (continued, run_in)
    )
    assert difference(found, exact) < 1e-6
    path = tmp_path / "steady.npz"
    steady.save(path)
    assert gb.SteadyState.load(path).period == np.inf


def test_forces_of_unrelated_frequencies_have_the_response_of_each():
    bearings = [gb.Bearing("rotor", x, stiffness=1e8, damping=1e3) for x in (0.0, 1.0)]
    shaft = gb.Shaft("rotor", length=1.0, outer_diameter=0.05, elements=2)
    forces = [gb.Force(("rotor", 0.5), 100.0, order=order) for order in (1, np.pi)]
    rotor, middle = gb.RotorSystem(shafts=[shaft], bearings=bearings), ("rotor", 0.5)
    options: dict[str, Any] = {"record": [middle], "rtol": 1e-10, "output_step": 1e-3}
    both = rotor.replace(forces=forces).steady_state(100.0, **options)
    assert both.is_stable()
    matrices, time = rotor.matrices(100.0), both.response.time
    exact = np.zeros(time.size, complex)
    for order in (1, np.pi):
        # A turning force drives a circular orbit: w lags v by a quarter of a turn.
        lines = {dof[2]: i for i, dof in enumerate(rotor.dofs) if dof[:2] == middle}
        load = np.zeros(len(rotor.dofs), complex)
        load[lines["v"]], load[lines["w"]] = 100.0, -100.0j
        frequency = 100.0 * order
        damping = matrices.damping + 100.0 * matrices.gyroscopic
        stiffness = matrices.stiffness - frequency**2 * matrices.mass + 1j * frequency * damping
        amplitude = np.linalg.lstsq(stiffness, load, rcond=None)[0]
        phase = np.exp(1j * frequency * time)
        exact += (amplitude[lines["v"]] * phase).real + 1j * (amplitude[lines["w"]] * phase).real
    orbit = both.response.displacement(middle) @ np.array([1.0, 1.0j])
    np.testing.assert_allclose(orbit, exact, atol=1e-8 * np.abs(exact).max())


@pytest.mark.filterwarnings("ignore::gearbow.SceneWarning")
def test_loads_over_time_have_no_frequency_that_is_known():
    system = without_period()
    series = gb.TimeSeries([0.0, 1.0], [0.0, 10.0])
    forces = [*system.forces, gb.Force("g2", series)]
    pattern = r"period: the frequencies have no common period .*forces\[2\].value over time"
    for geometry in ("live", "frozen"):
        with pytest.raises(gb.SceneError, match=pattern):
            system.replace(forces=forces).steady_state(100.0, geometry=geometry)


def test_orders_over_one_period_are_exact():
    system = train()
    steady = system.steady_state(100.0, geometry="frozen", rtol=1e-10)
    found = steady.response.orders("g1", "y", mesh_harmonics=0, shaft_harmonics=1)
    exact = system.synchronous([100.0])
    amplitude = np.abs(exact.displacement("g1")[0, 0, 0])
    at = next(i for i, order in enumerate(found.orders) if order.names[0] == "1× input")
    assert np.abs(found.amplitudes[at]) == pytest.approx(amplitude, rel=1e-6)


def test_one_period_is_long_enough_for_all_orders(tmp_path: Path):
    # without a bow of the output shaft, the period is one turn of the input shaft: half a period of
    # the output shaft does not separate its orders
    shafts = [
        gb.Shaft(name, length=0.5, outer_diameter=0.06, bow=bow, elements=4)
        for name, bow in (("input", gb.Bow.half_sine(4e-5)), ("output", None))
    ]
    gears = [
        gb.Gear(name, shaft.name, 0.25, teeth, module=3e-3, face_width=0.03)
        for name, shaft, teeth in zip(("g1", "g2"), shafts, (25, 50), strict=True)
    ]
    bearings = [gb.Bearing(s.name, x, stiffness=1e8, damping=2e3) for s in shafts for x in (0, 0.5)]
    system = gb.RotorSystem(shafts, gears, [gb.Mesh("g1", "g2", stiffness=2e8)], bearings)
    steady = system.steady_state(100.0, geometry="frozen", rtol=1e-10)
    assert steady.period == pytest.approx(2.0 * np.pi / 100.0)
    steady.save(tmp_path / "steady.npz")
    exact = np.abs(system.synchronous([100.0]).displacement("g1")[0, 0, 0])
    for motion in (steady, gb.SteadyState.load(tmp_path / "steady.npz")):
        found = motion.response.orders("g1", "y")
        assert found.amplitude("1× input") == pytest.approx(exact, rel=1e-6)
        assert found.amplitude("1× output") == found.amplitude("3× output") == 0.0
        assert found.rest < 1e-6 * exact


def test_a_record_without_a_period_separates_the_default_orders():
    system = without_period()
    steady = system.steady_state(100.0, geometry="frozen", rtol=1e-7, output_step=1e-3)
    gaps = np.diff([0.0, *(order.value for order in Kinematics.of(system).orders())])
    assert steady.response.time[-1] * 100.0 / (2.0 * np.pi) * gaps.min() > 0.5
    found = steady.response.orders("g2", "y", mesh_harmonics=1)
    # teeth without errors of their second and third harmonic: the known orders are the motion
    assert found.rest_share < 0.01


@pytest.mark.parametrize("tongue", [0, 1, 2, 3])
@pytest.mark.parametrize("off", [-4e-3, 4e-3])
def test_meissner_multipliers_are_those_of_the_closed_form(tongue: int, off: float):
    speed = boundaries()[tongue] * (1 + off)
    steady = MEISSNER.package().steady_state(speed, rtol=1e-10, initial="rest")
    exact = np.linalg.eigvals(monodromy(speed))
    found = steady.multipliers(0.5)
    for value in exact:
        assert np.abs(found - value).min() < 1e-6
    assert steady.is_stable() == (criterion(speed) < 2)
    if not steady.is_stable():
        largest = exact[np.abs(exact).argmax()]
        assert steady.instability() == ("fold" if largest.real > 0 else "flip")


@pytest.mark.parametrize("excess", [-0.1, 0.1])
def test_mathieu_threshold_from_the_multipliers(excess: float):
    zeta, mean = 0.02, 2e8
    h = 4 * zeta * (1 + excess)
    fourier = {"model": "fourier", "mean": mean, "amplitudes": [h * mean], "phase": "prescribed"}
    scene = Toothed(mesh={"stiffness": fourier, "damping_ratio": zeta})
    omega = np.sqrt(mean / scene.effective_mass)
    steady = scene.package().steady_state(2 * omega / scene.teeth[0], rtol=1e-10, initial="rest")
    # (h/4 - zeta) omega over half a period; the next terms are of order h^2
    found = steady.multipliers()
    real = found[np.abs(found.imag) < 1e-6]
    flips = real[real.real < 0.0]
    assert np.log(np.abs(flips[0])) == pytest.approx(
        (h / 4 - zeta) * np.pi, abs=2 * zeta**2 * np.pi
    )
    assert (steady.instability() == "flip") == (excess > 0)


def test_the_kind_of_an_instability_follows_from_its_multiplier():
    assert instability(np.array([0.99 + 0j])) is None
    assert instability(np.array([1.0 + 1e-9j])) is None
    assert instability(np.array([1.01 + 0j, 0.2])) == "fold"
    assert instability(np.array([-1.01 + 0j, 0.2])) == "flip"
    assert instability(np.array([0.9 + 0.9j, 0.9 - 0.9j])) == "Neimark-Sacker"


@pytest.mark.parametrize("speed", [300.0, -300.0])
def test_the_largest_multipliers_are_the_first_of_all(speed: float):
    steady = train().steady_state(speed, rtol=1e-8)
    largest = np.abs(steady._computed(0.01, only_largest=True))
    every = np.abs(steady.multipliers(0.01))
    assert every.size > largest.size > 0
    # the error is far below the distance from the unit circle, which decides about the stability
    assert largest[0] == pytest.approx(every[0], abs=1e-3 * abs(1.0 - every[0]))


def test_a_mean_torque_without_balance_names_the_drive():
    system = train(torques=[gb.Torque("g1", 250.0)])
    with pytest.raises(gb.SceneError, match=r"torques: a mean torque .*gb.Drive"):
        system.steady_state(100.0, initial="rest")


def test_files_keep_the_motion_and_the_multipliers(tmp_path: Path):
    steady = train().steady_state(100.0, rtol=1e-8)
    path = tmp_path / "steady.npz"
    steady.save(path)
    before = gb.SteadyState.load(path)
    again = before.multipliers()
    np.testing.assert_allclose(again, steady.multipliers(), atol=1e-6)
    steady.save(path)
    loaded = gb.SteadyState.load(path)
    np.testing.assert_array_equal(loaded.multipliers(), steady.multipliers())
    np.testing.assert_array_equal(
        loaded.response.displacement("g1"), steady.response.displacement("g1")
    )
    assert (loaded.period, loaded.residual) == (steady.period, steady.residual)
    assert repr(loaded) == repr(steady)
    steady.response.save(path)
    with pytest.raises(gb.GearbowError, match="not a steady state"):
        gb.SteadyState.load(path)


def test_a_run_continues_from_a_steady_state_without_transient():
    system = train()
    steady = system.steady_state(100.0, rtol=1e-9)
    times = steady.response.time + steady.period
    run = system.simulate(steady.period, 100.0, initial=steady, times=times, rtol=1e-9)
    last = steady.response
    again = system.simulate(steady.period, 100.0, initial=last, times=times, rtol=1e-9)
    assert np.array_equal(run.displacement("g4"), again.displacement("g4"))
    np.testing.assert_allclose(
        run.displacement("g4"), steady.response.displacement("g4"), atol=1e-12
    )
