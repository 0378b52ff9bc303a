"""Loss factors of shafts against closed forms and dense matrices."""

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest

import gearbow as gb
from reference.machines import BENDING_STIFFNESS, DISK_MASS, RIGID, massless_rotor

STEEL_E = 2.06e11
MASS, STIFFNESS = DISK_MASS, BENDING_STIFFNESS
FREQUENCY = math.sqrt(STIFFNESS / MASS)
pytestmark = pytest.mark.filterwarnings("ignore:natural frequencies range:gearbow.AccuracyWarning")


def stiffness(loss: float, side: np.ndarray | float) -> np.ndarray:
    """Give the stiffness of shaft and bearings with a sign of the frequency in the shaft."""
    return 1.0 / (1.0 / (STIFFNESS * (1.0 + 1j * loss * side)) + 0.5 / RIGID)


def jeffcott(loss: float, external: float = 0.0) -> gb.RotorSystem:
    """Give a disk amid a massless shaft with losses and a damper [N s/m] at the disk."""
    return massless_rotor({"loss_factor": loss}, damping=external)


@pytest.mark.parametrize("speed", [0.0, 0.5, 1.5, -0.5, -1.5])
@pytest.mark.parametrize("external", [0.0, 0.03])
def test_modes_of_a_jeffcott_rotor_have_the_eigenvalues_of_the_closed_form(
    speed: float, external: float
):
    loss = 0.04
    system = jeffcott(loss, external * MASS * FREQUENCY)
    modes = system.modes(speed * FREQUENCY, count=2)
    expected = []
    for direction in (1.0, -1.0):
        # mλ² + cλ + k(1 + iη sgn(1 ∓ Ω/ω)) = 0 for p and m.
        side = np.sign(1.0 - direction * speed)
        roots = np.roots([MASS, external * MASS * FREQUENCY, stiffness(loss, side)])
        expected.append(roots[np.argmax(roots.imag)])
    found = sorted(modes.eigenvalues, key=lambda value: value.real)
    # The mass of the shaft is 3e-8 of that of the disk.
    np.testing.assert_allclose(found, sorted(expected, key=lambda value: value.real), rtol=1e-7)
    # The bearings are 1e4 times as stiff as the shaft, which amplifies round-off.
    assert modes.residuals.max() < 3e-6


@pytest.mark.parametrize("external", [0.0, 0.01, 0.06])
def test_a_jeffcott_rotor_becomes_unstable_where_it_overtakes_its_mode(external: float):
    loss = 0.04
    system = jeffcott(loss, external * MASS * FREQUENCY)
    campbell = system.campbell(np.linspace(0.3, 2.0, 8) * FREQUENCY, count=2)
    thresholds = campbell.thresholds
    if external > loss:
        # The power of the damper, cω², exceeds that of the shaft, ηkω, at every speed.
        assert not thresholds
        return
    (found,) = thresholds
    assert (found.whirl, found.above) == ("forward", "unstable")
    # The frequency of the damped mode is lower by c²/8 and higher by η²/8.
    assert found.speed == pytest.approx(FREQUENCY, rel=4e-4)
    with pytest.warns(gb.AccuracyWarning, match="the motion is unstable"):
        system.synchronous([1.5 * FREQUENCY])


def test_the_critical_speed_is_that_without_losses():
    with_losses, without = (
        [each.speed for each in jeffcott(loss).campbell([1.0, 400.0, 900.0], count=2).intersections]
        for loss in (0.05, 0.0)
    )
    # Forward: at its critical speed the shaft does not move relative to itself. The backward mode has the frequency
    # ω √((1 + √(1 + η²))/2).
    raised = math.sqrt((1.0 + math.sqrt(1.0 + 0.05**2)) / 2.0)
    assert len(with_losses) == len(without) == 2
    ratios = sorted(np.divide(with_losses, without))
    np.testing.assert_allclose(ratios, [1.0, raised], rtol=1e-6)


def test_a_bow_in_its_own_shaft_sees_no_losses():
    bow = gb.Bow.half_sine(1e-4)
    speeds = FREQUENCY * np.array([-1.4, 0.4, 1.4])
    responses = []
    for loss in (0.1, 0.0):
        system = jeffcott(loss, external=0.2 * MASS * FREQUENCY)
        system = system.replace(shafts=[replace(system.shafts[0], bow=bow)])
        responses.append(system.synchronous(speeds).displacement("d"))
    np.testing.assert_allclose(*responses, rtol=1e-10, atol=1e-16)


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_a_force_that_turns_at_another_speed_meets_the_losses_of_its_direction(sense: float):
    loss, speed = 0.05, sense * 1.5 * FREQUENCY
    system = jeffcott(loss, external=20.0)
    frequencies = FREQUENCY * np.array([0.0, 0.6, 1.0, 1.4, 1.6])
    for direction in (1.0, -1.0):
        # y + iz = e^{±iωt}
        force = gb.Force("d", (1.0, -1j * direction))
        found = system.frequency_response(frequencies, source=force, speed=speed)
        sign = np.sign(direction * frequencies - speed)
        turning = 1j * direction * frequencies
        expected = 1.0 / (stiffness(loss, sign) + 20.0 * turning + MASS * turning**2)
        y, z = np.moveaxis(found.displacement("d")[:, 0], -1, 0)
        np.testing.assert_allclose(y if direction > 0.0 else y.conj(), expected, rtol=1e-5)
        np.testing.assert_allclose(z, -1j * direction * y, rtol=1e-9, atol=1e-18)


def test_a_standing_bar_has_the_complex_modulus():
    # Euler-Bernoulli: the receptance of the simply supported bar with E(1 + iη).
    length, diameter, loss, density = 1.2, 0.012, 0.02, 7850.0
    bar = gb.Shaft(
        "bar",
        length=length,
        outer_diameter=diameter,
        elements=12,
        degree=5,
        shear=False,
        material=gb.Material(STEEL_E, density, poisson_ratio=0.3),
        loss_factor=loss,
    )
    bearings = [gb.Bearing("bar", x, stiffness=1e12) for x in (0.0, length)]
    system = gb.RotorSystem([bar], bearings=bearings, motion="lateral")
    frequencies = 2.0 * math.pi * np.array([5.0, 40.0, 150.0, 333.0])
    at = ("bar", 0.3)
    found = system.frequency_response(frequencies, source=gb.Force(at, 1.0)).displacement(at)
    expected = np.zeros(4, complex)
    area, second = math.pi * diameter**2 / 4.0, math.pi * diameter**4 / 64.0
    for n in range(1, 400):
        wave = n * math.pi / length
        # With the rotary inertia of the Rayleigh beam.
        mass = density * (area + second * wave**2) * length / 2.0
        stiffness = STEEL_E * second * wave**4 * length / 2.0 * (1.0 + 1j * loss)
        expected += math.sin(wave * at[1]) ** 2 / (stiffness - frequencies**2 * mass)
    # The bearings give way by 1e-6 of the deflection, of which resonance makes more.
    np.testing.assert_allclose(found[:, 0, 0], expected, rtol=1e-5)


def test_torsion_has_the_losses_of_a_standing_shaft():
    loss, length = 0.03, 0.5
    shaft = gb.Shaft("s", length=length, outer_diameter=0.02, loss_factor=loss)
    disks = [gb.Disk(name, "s", x, 5.0, 0.05, 0.1) for name, x in (("a", 0.0), ("b", length))]
    system = gb.RotorSystem([shaft], disks=disks, motion="torsion")
    mode = next(each for each in system.modes(100.0, count=3).eigenvalues if each.imag > 1.0)
    (free,) = (
        each.imag
        for each in system.replace(shafts=[replace(shaft, loss_factor=0.0)])
        .modes(100.0, count=2)
        .eigenvalues
        if each.imag > 1.0
    )
    # λ² = −ω²(1 + iη); the disks are 300 times as heavy as the shaft, whose other modes have no part.
    assert mode == pytest.approx(1j * free * np.sqrt(1.0 + 1j * loss), rel=1e-9)


def geared(loss: float) -> gb.RotorSystem:
    """Give a geared pair on soft supports with losses in every part."""
    return gb.RotorSystem(
        [
            gb.Shaft("a", length=0.4, outer_diameter=0.03, elements=4, loss_factor=loss,
                     bow=gb.Bow.half_sine(1e-4)),
            gb.Shaft("b", length=0.5, outer_diameter=0.04, elements=4, loss_factor=2.0 * loss),
        ],
        gears=[
            gb.Gear("pinion", "a", 0.15, teeth=25, module=3e-3, face_width=0.03),
            gb.Gear("wheel", "b", 0.2, teeth=50, module=3e-3, face_width=0.03),
        ],
        disks=[gb.Disk("d", "b", 0.5, 8.0, 0.05, 0.1)],
        meshes=[gb.Mesh("pinion", "wheel", stiffness=2e8, damping=1e3, loss_factor=loss)],
        bearings=[
            gb.Bearing(name, x, stiffness=(4e7, 7e7), damping=1e3, loss_factor=3.0 * loss)
            for name, ends in (("a", (0.0, 0.4)), ("b", (0.0, 0.4)))
            for x in ends
        ],
    )  # fmt: skip


def structural(system: gb.RotorSystem, frequency: float, speed: float) -> np.ndarray:
    """Give the structural damping, from the matrices of internal damping and of stiffer parts."""
    base = system.matrices(speed)
    total = np.zeros(base.mass.shape, complex)
    standing = 1j * np.sign(frequency)
    torsion = np.array([dof[2].startswith("twist") for dof in base.dofs])
    for i, shaft in enumerate(system.shafts):
        damped = [*system.shafts]
        damped[i] = replace(shaft, internal_damping=1.0)
        found = system.replace(shafts=damped).matrices(speed)
        # βK and −iΩ_s βK for β = 1 s.
        stiffness = found.damping - base.damping
        spin = speed * system.speed_ratios[i]
        turned = (found.stiffness - base.stiffness) / spin
        forward, backward = np.sign(frequency - spin), np.sign(frequency + spin)
        bending = np.where(torsion[:, None], 0.0, stiffness)
        lossy = 0.5j * (forward + backward) * bending - 0.5 * (forward - backward) * turned
        total += shaft.loss_factor * (lossy + standing * (stiffness - bending))
    for key in ("bearings", "meshes"):
        for i, part in enumerate(getattr(system, key)):
            changed = [*getattr(system, key)]
            changed[i] = replace(part, stiffness=2.0 * np.array(part.stiffness))
            doubled = system.replace(**{key: changed}).matrices(speed).stiffness
            total += standing * part.loss_factor * (doubled - base.stiffness)
    return total


@pytest.mark.parametrize("speed", [150.0, -400.0])
@pytest.mark.parametrize("modal_damping", [0.0, 0.01])
def test_responses_follow_from_the_matrices(speed: float, modal_damping: float):
    system = geared(0.02).replace(modal_damping=modal_damping)
    m = system.matrices(speed)
    frequencies = np.array([-900.0, -170.0, -60.0, 60.0, 170.0, 900.0])
    source = gb.Force("pinion", (1.0, 0.5j))
    found = system.frequency_response(frequencies, source=source, speed=speed)
    force = np.zeros(len(m.dofs), complex)
    for kind, value in (("v", 1.0), ("w", 0.5j)):
        force[m.dofs.index(("a", 0.15, kind))] = value
    for w, phasors in zip(frequencies, found.phasors[:, 0], strict=True):
        dynamic = m.stiffness + 1j * w * (m.damping + speed * m.gyroscopic) - w**2 * m.mass
        expected = np.linalg.solve(dynamic + structural(system, w, speed), force)
        # Round-off of the dense solution.
        np.testing.assert_allclose(phasors, expected, rtol=0.0, atol=1e-7 * abs(expected).max())


@pytest.mark.parametrize("speed", [150.0, 900.0])
def test_modes_follow_from_the_matrices(speed: float):
    system = geared(0.02)
    m = system.matrices(speed)
    n, inverse = len(m.dofs), np.linalg.inv(m.mass)
    rate = inverse @ (m.damping + speed * m.gyroscopic)
    spins = sorted({0.0, *np.abs(speed * system.speed_ratios), np.inf})
    expected = []
    for low, high in itertools.pairwise(spins):
        inside = low + min(1.0, 0.5 * (high - low))
        stiffness = inverse @ (m.stiffness + structural(system, inside, speed))
        pencil = np.block([[np.zeros((n, n)), np.eye(n)], [-stiffness, -rate]])
        values = np.linalg.eigvals(pencil)
        expected += [value for value in values if low < value.imag < high]
    expected = sorted(expected, key=lambda value: value.imag)
    modes = system.modes(speed, count=12)
    vibrating = [value for value in modes.eigenvalues if value.imag > 1.0]
    for found, value in zip(vibrating, [v for v in expected if v.imag > 1.0], strict=False):
        # An unscaled matrix of M⁻¹K has round-off of 1e-16 ω_max²/ω².
        assert found == pytest.approx(value, rel=1e-6)
    assert modes.residuals.max() < 1e-9


def test_derivatives_are_those_of_whole_analyses():
    system = geared(0.02)
    path, h = "shafts['a'].loss_factor", 1e-4
    around = [
        system.replace(shafts=[replace(system.shafts[0], loss_factor=0.02 + e), system.shafts[1]])
        for e in (h, -h)
    ]
    frequencies = [60.0, 170.0, 900.0]
    source = gb.Force("pinion", 1.0)

    def response(each: gb.RotorSystem):
        return each.frequency_response(frequencies, source=source, speed=150.0)

    found = system.sensitivity([path], of=response(system), at="wheel").derivatives
    high, low = (response(each).displacement("wheel") for each in around)
    expected = (high - low) / (2.0 * h)
    np.testing.assert_allclose(found[0], expected, rtol=0.0, atol=1e-6 * abs(expected).max())
    modes = [each.modes(150.0, count=6).eigenvalues for each in (system, *around)]
    slopes = system.sensitivity([path], of=system.modes(150.0, count=6))
    damping = [-value.real / np.fmax(abs(value), 1e-9) for value in modes]
    expected = (damping[1] - damping[2]) / (2.0 * h)
    vibrating = modes[0].imag > 1.0
    np.testing.assert_allclose(
        slopes.damping_ratios[0, vibrating], expected[vibrating], rtol=1e-5, atol=1e-8
    )


def test_runs_refuse_loss_factors_of_shafts():
    system = jeffcott(0.02)
    with pytest.raises(
        gb.SceneError, match=r"shafts\[0\].loss_factor: has a meaning in the frequency domain"
    ):
        system.simulate(0.01, 100.0)
    with pytest.raises(gb.SceneError, match=r"loss_factor: must not be negative"):
        jeffcott(-0.02)


@pytest.mark.parametrize("speed", [0.0, 40.0, 500.0])
def test_modes_of_band_matrices_are_those_of_dense_ones(speed: float):
    # At rest both planes have equal frequencies, which the losses of one bearing part.
    shaft = gb.Shaft("s", length=1.0, outer_diameter=0.04, elements=14, degree=2, loss_factor=0.01)
    post = gb.Support("post", mass=5.0, stiffness=3e7, loss_factor=0.1)
    system = gb.RotorSystem(
        [shaft],
        disks=[gb.Disk("d", "s", 0.3, 12.0, 0.05, 0.1)],
        bearings=[
            gb.Bearing("s", 0.0, stiffness=5e7, loss_factor=0.05),
            gb.Bearing("s", 1.0, stiffness=5e7, damping=(100.0, 300.0), support="post"),
        ],
        supports=[post],
        motion="lateral",
    )
    assert len(system.dofs) >= 100
    few, all_modes = system.modes(speed, count=6), system.modes(speed)
    np.testing.assert_allclose(few.eigenvalues, all_modes.eigenvalues[:6], rtol=1e-8)
    assert few.residuals.max() < 1e-8
