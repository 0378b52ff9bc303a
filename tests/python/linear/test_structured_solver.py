"""Frequency-domain analyses with band matrices against dense linear algebra of the same matrices."""

from __future__ import annotations

import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given

import gearbow as gb
from reference.machines import double_stage, long_shaft, rotor
from test_random_scenes import Drawn, drawn, examples, scenes as scenes_with_contact

pytestmark = pytest.mark.implausible

MACHINES = Path(__file__).parents[3] / "examples/machines"
ROTORS = sorted((Path(__file__).parents[3] / "examples/rotors").glob("*.toml"))


def scenes(count: int):
    """Run a test on this many random scenes, without those that failed in runs with contact."""
    return lambda test: examples(count)(given(drawn())(test))


def tolerance(system: gb.RotorSystem, speed: float = 0.0) -> float:
    """Return 1e-9, or ten times the relative round-off of the slowest motion in dense matrices.

    The round-off of K, the square of the highest frequency, acts on the slowest elastic mode and, at a
    speed, on the rigid-body rotation, whose only dynamic stiffness is the square of a spin.
    """
    frequencies = np.sort(2 * np.pi * system.modes(speed).frequencies_hz)
    slowest = frequencies[frequencies > 1e-6 * frequencies[-1]][0]
    if speed:
        slowest = min(slowest, np.abs(speed * system.speed_ratios).min())
    return max(1e-9, 10 * np.finfo(float).eps * (frequencies[-1] / slowest) ** 2)


def assert_same_response(system: gb.RotorSystem, speeds: np.ndarray) -> None:
    wanted = through_dense_matrices(system).synchronous(speeds).amplitudes
    assert_response(system, speeds, wanted)


def distance_to_resonance(system: gb.RotorSystem, speed: float) -> float:
    """Return the smallest |λ − iω| / ω of all modes λ and spins ω, at most 1.

    Near a resonance the round-off of the frequencies changes the response by their relative
    round-off divided by this distance, in both methods.
    """
    spins = 1j * np.abs(speed * system.speed_ratios)
    apart = np.abs(system.modes(speed).eigenvalues - spins[:, np.newaxis])
    return float(min(1.0, (apart / np.abs(spins)[:, np.newaxis]).min())) if speed else 1.0


def assert_response(system: gb.RotorSystem, speeds: np.ndarray, wanted: np.ndarray) -> None:
    found = system.synchronous(speeds).amplitudes
    for speed, one, other in zip(speeds, found, wanted, strict=True):
        scale = max(np.abs(other).max(), 1e-12) / distance_to_resonance(system, speed)
        assert np.abs(one - other).max() <= tolerance(system, speed) * scale


def through_dense_matrices(system: gb.RotorSystem) -> gb.RotorSystem:
    """Return the system with a modal damping that is below round-off.

    With less than 100 coordinates its synchronous response takes dense matrices. Its modes take a
    Galerkin projection.
    """
    return system.replace(modal_damping=1e-300)


# An undamped rotor may turn at a critical speed by chance.
@pytest.mark.filterwarnings("ignore:a displacement is")
@scenes(15)
def test_the_synchronous_response_is_that_of_dense_matrices(scene: Drawn):
    assert_same_response(scene.system(), np.array([-300.0, 0.0, 17.0, 150.0, 900.0]))


@pytest.mark.parametrize("path", ROTORS, ids=lambda path: path.stem)
def test_published_rotors_have_the_response_of_dense_matrices(path: Path):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", gb.SceneWarning)
        system = gb.RotorSystem.load(path)
    assert_same_response(system, np.linspace(0.0, 2000.0, 21))


def dense_response(system: gb.RotorSystem, speeds: np.ndarray) -> np.ndarray:
    """Return the response x of (S + iΩD) x = S x₀ with the dense matrix D of modal damping.

    x₀ is the response without modal damping.
    """
    free, found = system.replace(modal_damping=None), []
    for speed, bare in zip(speeds, free.synchronous(speeds).amplitudes, strict=True):
        matrices, rate = free.matrices(speed), system.matrices(speed).damping
        modal = rate - matrices.damping
        row = []
        for x, spin in zip(bare, speed * system.speed_ratios, strict=True):
            rate_at_speed = rate + speed * matrices.gyroscopic
            dynamic = matrices.stiffness - spin**2 * matrices.mass + 1j * spin * rate_at_speed
            row.append(x - np.linalg.solve(dynamic, 1j * spin * (modal @ x)))
        found.append(row)
    return np.array(found)


def assert_response_with_modal_damping(system: gb.RotorSystem, speeds: list[float]) -> None:
    assert len(system.dofs) >= 100  # smaller systems take dense matrices
    at = np.array(speeds)
    assert_response(system, at, dense_response(system, at))


@scenes(3)
def test_the_response_with_modal_damping_is_that_of_dense_matrices(scene: Drawn):
    for ratio in (0.001, 0.02, 0.3):
        system = refined(scene).replace(modal_damping=ratio)
        assert_response_with_modal_damping(system, [-300.0, 17.0, 150.0, 900.0])


@scenes(3)
def test_strongly_damped_trains_with_modal_damping_have_the_response_of_dense_matrices(
    scene: Drawn,
):
    stiffness = scene.bearing[:3]
    for damping in (10.0, 1000.0):
        system = refined(scene, bearing=(*stiffness, damping), rayleigh=0.0)
        assert_response_with_modal_damping(system.replace(modal_damping=0.02), [17.0, 900.0])


# The oil whirls at the highest speed; the equations have their solution all the same.
@pytest.mark.filterwarnings("ignore:speeds. the motion is unstable")
@pytest.mark.parametrize("speed", [50.0, 300.0, 900.0])
def test_the_response_on_journal_bearings_is_that_of_dense_matrices(speed: float):
    # at high speed the films are unstable
    system = on_films(0.02)
    shafts = [replace(system.shafts[0], bow=gb.Bow.half_sine(1e-5))]
    assert_response_with_modal_damping(system.replace(shafts=shafts), [speed, -speed])


def test_at_standstill_modal_damping_has_no_effect():
    system = refined(Drawn())
    damped = system.replace(modal_damping=0.02)
    found, wanted = damped.synchronous([0.0]), system.synchronous([0.0])
    assert np.array_equal(found.amplitudes, wanted.amplitudes)


def test_peaks_with_modal_damping_are_those_of_the_response():
    system = long_shaft(30).replace(modal_damping=0.02)
    assert len(system.dofs) >= 100
    found = system.synchronous(np.linspace(100.0, 900.0, 40))
    (peak,) = found.peaks("d")
    major = system.synchronous([peak.lower, peak.speed, peak.upper]).orbit("d")[:, 0]
    assert major[1] == pytest.approx(peak.amplitude, rel=1e-9)
    assert major[::2] == pytest.approx(peak.amplitude / np.sqrt(2), rel=1e-9)
    assert_response_with_modal_damping(system, [peak.lower, peak.speed, peak.upper])


def refined(scene: Drawn, **changes: object) -> gb.RotorSystem:
    """Return the scene with so many elements that a few of its modes take band matrices.

    A dense solution then takes a tenth of a second. `tests/rust/structured.rs` has other degrees.
    """
    elements = tuple(max(8, 24 // len(scene.lengths)) for _ in scene.lengths)
    degrees = tuple(1 for _ in scene.degrees)
    return replace(scene, elements=elements, degrees=degrees, **changes).system()


def round_off(highest: float, size: np.ndarray) -> np.ndarray:
    """Return 1e-9, or ten times the relative round-off of dense matrices, for each frequency."""
    part = 10 * np.finfo(float).eps * (highest / np.maximum(size, 1e-9 * highest)) ** 2
    return np.maximum(1e-9, part)


def assert_lowest_modes(system: gb.RotorSystem, speed: float, count: int = 8) -> None:
    found, wanted = system.modes(speed, count=count), system.modes(speed)
    highest, size = np.abs(wanted.eigenvalues).max(), np.abs(wanted.eigenvalues[:count])
    difference = np.abs(found.eigenvalues - wanted.eigenvalues[:count])
    assert np.all(difference <= round_off(highest, size) * size)


@scenes(5)
def test_the_lowest_modes_are_those_of_dense_matrices(scene: Drawn):
    assert_lowest_modes(refined(scene), scene.speed)


@scenes(3)
def test_the_lowest_modes_of_strongly_damped_trains_are_those_of_dense_matrices(scene: Drawn):
    stiffness = scene.bearing[:3]
    for damping in (10.0, 100.0, 1000.0):
        assert_lowest_modes(
            refined(scene, bearing=(*stiffness, damping), rayleigh=0.0), scene.speed
        )


@pytest.mark.parametrize("path", ROTORS, ids=lambda path: path.stem)
def test_published_rotors_with_more_elements_have_the_modes_of_dense_matrices(path: Path):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", gb.SceneWarning)
        system = gb.RotorSystem.load(path)
    shafts = []
    for shaft in system.shafts:
        if shaft.segments is None:
            shafts.append(replace(shaft, elements=25))
        else:
            parts = [replace(segment, elements=4 * segment.elements) for segment in shaft.segments]
            shafts.append(replace(shaft, segments=parts))
    finer = system.replace(shafts=shafts)
    for speed in (0.0, 300.0):
        assert_lowest_modes(finer, speed, count=6)


@scenes(3)
def test_the_lowest_modes_with_modal_damping_are_those_of_dense_matrices(scene: Drawn):
    for ratio in (0.001, 0.02, 0.3):
        assert_lowest_modes(refined(scene).replace(modal_damping=ratio), scene.speed)


@scenes(3)
def test_strongly_damped_trains_with_modal_damping_have_the_modes_of_dense_matrices(scene: Drawn):
    stiffness = scene.bearing[:3]
    for damping in (10.0, 1000.0):
        system = refined(scene, bearing=(*stiffness, damping), rayleigh=0.0)
        assert_lowest_modes(system.replace(modal_damping=0.02), scene.speed)


@pytest.mark.parametrize("factor", [1.0, 1.0 + 1e-8, 1.001])
@pytest.mark.parametrize("ratio", [0.0, 0.01])
def test_equal_and_close_modes_are_all_found(factor: float, ratio: float):
    # both planes of a rotor, whose rotation is a rigid-body mode
    bearings = [
        gb.Bearing("s", x, stiffness=(1e7, factor * 1e7), damping=100.0) for x in (0.0, 1.0)
    ]
    system = long_shaft(40).replace(bearings=bearings, modal_damping=ratio)
    for speed in (0.0, 1e-3, 300.0):
        assert_lowest_modes(system, speed, count=12)


def test_undamped_modes_have_the_modal_damping_ratio():
    shaft = {"elements": 30, "degree": 1}
    system = rotor(shaft, bearing={"stiffness": 1e7}, modal_damping=0.05)
    found = system.modes(count=8)
    free = system.replace(modal_damping=0.0).modes(count=8)
    elastic = free.frequencies_hz > 0.0
    assert found.damping_ratios[elastic] == pytest.approx(0.05, rel=1e-9)
    size = np.abs(found.eigenvalues[elastic]) / (2 * np.pi)
    assert size == pytest.approx(free.frequencies_hz[elastic], rel=1e-9)


def on_films(ratio: float, **film: object) -> gb.RotorSystem:
    """Return a shaft on two journal bearings, whose films damp strongly and have cross-coupling."""
    given = {"diameter": 0.06, "length": 0.03, "clearance": 6e-5, "viscosity": 0.03, **film}
    return rotor(
        {"name": "s", "outer_diameter": 0.06, "elements": 40, "degree": 1},
        disks=[gb.Disk("d", "s", 0.4, 60.0, 0.5, 0.9)],
        bearings=[gb.JournalBearing("s", x, **given) for x in (0.1, 0.9)],  # type: ignore[arg-type]
        gravity=9.81,
        modal_damping=ratio,
    )


@pytest.mark.parametrize("ratio", [0.0, 0.01, 0.1])
@pytest.mark.parametrize("speed", [50.0, 300.0, 900.0])
def test_the_modes_on_journal_bearings_are_those_of_dense_matrices(ratio: float, speed: float):
    # at high speed the films are unstable
    assert_lowest_modes(on_films(ratio), speed, count=10)


def index_of_twist(system: gb.RotorSystem, gear: gb.Gear) -> int:
    """Return the index of the rotation of a gear about its axis; labels round positions."""
    twists = [
        (abs(position - gear.position), index)
        for index, (name, position, direction) in enumerate(system.dofs)
        if (name, direction) == (gear.shaft, "twist") and isinstance(position, float)
    ]
    return min(twists)[1]


def dense_equilibrium(system: gb.RotorSystem) -> np.ndarray:
    """Return the equilibrium in frozen geometry without backlash: a linear problem."""
    matrices = system.matrices()
    gravity = np.zeros(len(matrices.dofs))
    for index, (_, position, direction) in enumerate(matrices.dofs):
        if isinstance(position, float) and direction in "vw":
            gravity[index] = system.gravity["vw".index(direction)]
    load = matrices.mass @ gravity
    gears = {gear.name: gear for gear in system.gears}
    ratios = dict(zip([s.name for s in system.shafts], system.speed_ratios, strict=True))
    places = [gears[torque.at] for torque in system.torques]
    given = system.torques[0].value
    values = [given, -given * ratios[places[0].shaft] / ratios[places[-1].shaft]]
    for gear, value in zip(places, values, strict=True):
        load[index_of_twist(system, gear)] += value
    modes = system.modes()
    # overdamped modes have no frequency either
    is_rigid = modes.eigenvalues == 0.0
    rigid = modes.shapes[is_rigid].real.T
    constrained = matrices.mass @ rigid * np.abs(modes.eigenvalues[~is_rigid]).min()
    return np.linalg.solve(matrices.stiffness + constrained @ constrained.T, load)


@scenes_with_contact(10)
def test_the_equilibrium_is_that_of_dense_matrices(scene: Drawn):
    system = replace(scene, backlash=None).system()
    found = system.static(geometry="frozen").state
    wanted = dense_equilibrium(system)
    assert np.abs(found - wanted).max() <= tolerance(system) * np.abs(wanted).max()


def test_bearings_that_are_soft_in_one_direction():
    # The couplings between the circular coordinates are about as large as the mean stiffness.
    scene = Drawn(
        lengths=(1.0, 0.5, 1.0),
        diameters=(0.0625, 0.02344, 0.0625),
        elements=(3, 1, 1),
        degrees=(2, 1, 3),
        places=(0.25, 0.25, 0.25),
        teeth=(20, 20, 20),
        bows=(0j, 0j, 0j),
        density=3310.0,
        disk=1.0,
        bearing=(1.0, 0.0625, 0.0, 0.0),
        mesh=("mean", 10**8.5, 0.0),
    )
    system = scene.system()
    assert_lowest_modes(system, 0.0, count=3)
    found, wanted = system.static(geometry="frozen").state, dense_equilibrium(system)
    assert np.abs(found - wanted).max() <= tolerance(system) * np.abs(wanted).max()


@scenes(3)
def test_the_critical_speeds_are_those_of_dense_matrices(scene: Drawn):
    system = refined(scene)
    highest = 2 * np.pi * system.modes().frequencies_hz.max()
    # Each stiffness by itself: between two of them, many more follow the modes for their lines.
    for stiffness in (1e6, 1e10):
        (found,) = system.critical_speed_map([stiffness], count=7).speeds
        wanted = system.critical_speed_map([stiffness]).speeds[0][:7]
        assert len(found) == 7
        # very stiff bearings raise the highest frequency
        assert np.all(np.abs(found - wanted) <= round_off(100 * highest, wanted) * wanted)


@pytest.mark.parametrize("order", [1.0, -1.0])
@pytest.mark.parametrize("name", ["housed_pair", "idler_train", "overhung_rotor"])
def test_one_space_gives_the_critical_speeds_of_each_stiffness(name: str, order: float):
    # Stiffnesses above zero share the space of the lowest one, which has a search of its own. The
    # stiffest bearings determine the elements.
    loaded = gb.RotorSystem.load(MACHINES / f"{name}.toml")
    stiffnesses = [1e9, 0.0, 1e7, 1e8]
    found = loaded.critical_speed_map(stiffnesses, order=order, count=5)
    for stiffness, speeds, residuals in zip(
        stiffnesses, found.speeds, found.residuals, strict=True
    ):
        wanted, _ = loaded.critical_speed_map([stiffness, 1e9], order=order, count=5).speeds
        assert len(speeds) == len(wanted)
        np.testing.assert_allclose(speeds, wanted, rtol=1e-10)
        assert np.all(residuals <= 1e-7)


@scenes(2)
def test_the_campbell_diagram_is_that_of_dense_matrices(scene: Drawn):
    system = refined(scene)
    speeds = np.linspace(0.0, 400.0, 4)
    found = system.campbell(speeds, count=6)
    wanted = through_dense_matrices(system).campbell(speeds, count=6)
    highest = 2 * np.pi * system.modes().frequencies_hz.max()
    size = np.abs(wanted.eigenvalues)
    assert np.all(np.abs(found.eigenvalues - wanted.eigenvalues) <= round_off(highest, size) * size)
    assert np.array_equal(found.whirl[-1], wanted.whirl[-1])
    assert len(found.intersections) == len(wanted.intersections)
    for one, other in zip(found.intersections, wanted.intersections, strict=True):
        assert (one.mode, one.line) == (other.mode, other.line)
        assert one.speed == pytest.approx(other.speed, rel=1e-8)


@scenes(3)
def test_sparse_matrices_are_the_dense_ones(scene: Drawn):
    system = scene.system()
    sparse, dense = system.matrices(scene.speed, sparse=True), system.matrices(scene.speed)
    assert sparse.dofs == dense.dofs
    for name in ("mass", "stiffness", "damping", "gyroscopic"):
        one, other = getattr(sparse, name).toarray(), getattr(dense, name)
        # the terms of an entry are added in another order
        assert one == pytest.approx(other, rel=1e-14, abs=1e-15 * np.abs(other).max())


def test_sparse_matrices_are_refused_with_modal_damping():
    system = Drawn().system().replace(modal_damping=0.01)
    with pytest.raises(gb.SceneError, match=r"^sparse: must be False with modal damping"):
        system.matrices(sparse=True)
    with pytest.raises(gb.SceneError, match=r"^sparse: must be True or False, got 1"):
        system.matrices(sparse=1)  # type: ignore[call-overload]


def test_nine_thousand_elements_need_memory_in_proportion():
    # 36,004 degrees of freedom: a dense matrix would take 10 GB
    system = long_shaft(9000)
    with warnings.catch_warnings():
        # one element is 0.1 mm long: round-off takes digits of the slow modes
        warnings.simplefilter("ignore", gb.AccuracyWarning)
        modes = system.modes(100.0, count=4)
        sag = system.static().displacement("d")
        orbit = system.synchronous([100.0]).displacement("d")
    coarse = long_shaft(100)
    expected = coarse.modes(100.0, count=4)
    assert modes.frequencies_hz == pytest.approx(expected.frequencies_hz, rel=1e-5)
    assert sag == pytest.approx(coarse.static().displacement("d"), rel=1e-5)
    wanted = coarse.synchronous([100.0]).displacement("d")
    assert np.abs(orbit - wanted).max() < 1e-5 * np.abs(wanted).max()
    assert system.matrices(sparse=True).mass.nnz < 40 * len(system.dofs)
    for refused in (system.matrices, system.modes):
        with pytest.raises(gb.SceneError, match=r"36004 degrees of freedom need .* GB of memory"):
            refused()


@pytest.mark.parametrize("machine", ["gearbox", "turbine_rotor"])
def test_only_vibrations_are_counted(machine: str):
    # Oil films have overdamped motions among the lowest modes.
    example = gb.examples()[machine]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        system = example.load()
    found = system.modes(example.speed, count=6, vibrating=True).eigenvalues
    values = system.modes(example.speed).eigenvalues
    expected = values[values.imag > 0.05 * np.abs(values)][:6]
    # Both are accurate to the residual of a mode; the film modes of the gearbox are the most sensitive (3e-7).
    np.testing.assert_allclose(found, expected, rtol=1e-5)


def test_fewer_vibrations_than_asked_for_are_all():
    # Two degrees of freedom along y have critical damping, two along z vibrate.
    system = gb.RotorSystem(
        [gb.Shaft("s", length=0.2, outer_diameter=0.1, elements=1, degree=1)],
        bearings=[gb.Bearing("s", x, stiffness=1e6, damping=(1e8, 1e2)) for x in (0.0, 0.2)],
        motion="lateral",
    )
    every = system.modes()
    vibrating = every.eigenvalues[every.eigenvalues.imag > 0.05 * np.abs(every.eigenvalues)]
    assert 0 < len(vibrating) < len(every.whirl)
    for count in (None, len(vibrating), 100):
        found = system.modes(count=count, vibrating=True).eigenvalues
        np.testing.assert_allclose(found, vibrating, rtol=1e-9)
    # Undamped: a train that turns freely has a rigid-body mode, which is no vibration.
    train = double_stage()
    assert train.modes(count=1).whirl == ("rigid",)
    assert train.modes(count=1, vibrating=True).frequencies_hz[0] > 1.0


def test_too_many_overdamped_modes_are_refused_before_dense_matrices():
    # 2044 degrees of freedom, almost all modes overdamped
    system = long_shaft(510).replace(rayleigh=(0.0, 1e-3), modal_damping=0.02)
    with pytest.raises(gb.ConvergenceError, match=r"^the 10 lowest modes .* use at most 2000"):
        system.modes(100.0, count=10)
