"""The independent solution itself: its mesh law, its elements and its accuracy."""

from __future__ import annotations

import numpy as np
import pytest

from reference import elements, independent_solution, published
from reference.bows import HalfSine
from reference.mesh_law import MeshLaw
from reference.scenes import Geared

SECTION = elements.Section(0.05, 207e9, 207e9 / 2.6, 7800.0, 0.02)


def law(sigma: float, angle: float = 0.7) -> MeshLaw:
    return MeshLaw(0.0352, 0.0705, 0.1125, angle, 2e8, 100.0, sigma)


@pytest.mark.parametrize("sigma", [1.0, -1.0])
def test_gradient_of_the_mesh_deflection(sigma: float):
    mesh, h = law(sigma), 1e-6
    q = np.array([1e-3, -2e-3, 0.02, -5e-4, 8e-4, -0.01])

    def deflection(q: np.ndarray) -> float:
        return mesh.deflection(q[0:2], q[3:5], q[2], q[5])

    differences = [(deflection(q + h * e) - deflection(q - h * e)) / (2 * h) for e in np.eye(6)]
    gradient = mesh.gradient(q[0:2], q[3:5])
    # round-off eps times the deflection over h, and truncation (h / C)^2
    assert gradient == pytest.approx(np.array(differences), abs=1e-9)
    assert np.hypot(*gradient[:2]) == pytest.approx(1, rel=1e-14)
    assert mesh.gradient_at_rest() == pytest.approx(mesh.gradient(*np.zeros((2, 2))), rel=1e-14)


@pytest.mark.parametrize("sigma", [1.0, -1.0])
@pytest.mark.parametrize("turn", [1e-3, -0.4, 1.2])
def test_rotating_the_pair_about_its_first_gear_causes_no_deflection(sigma: float, turn: float):
    mesh = law(sigma)
    at_rest = mesh.centre_distance * np.exp(1j * mesh.centre_line_angle)
    moved = at_rest * (np.exp(1j * turn) - 1)
    u_b = np.array([moved.real, moved.imag])
    # both gears rotate with the frame
    assert mesh.deflection(np.zeros(2), u_b, turn, turn) == pytest.approx(0, abs=1e-15)


def test_a_larger_centre_distance_changes_the_deflection_by_the_sine_of_the_pressure_angle():
    mesh, open_by = law(1.0, 0.0), 1e-7
    found = mesh.deflection(np.zeros(2), np.array([open_by, 0.0]), 0.0, 0.0)
    assert found == pytest.approx(-np.sin(mesh.angle_at_rest) * open_by, rel=1e-5)  # b / C


def test_element_against_the_closed_form_of_its_stiffness():
    length = 0.2
    _, stiffness, _ = elements.beam(SECTION, length)
    phi = SECTION.shear_parameter(length)
    s, t = (4 + phi) * length**2, (2 - phi) * length**2
    c = 6 * length
    form = np.array([[12, c, -12, c], [c, s, -c, t], [-12, -c, 12, -c], [c, t, -c, s]])
    form *= SECTION.youngs_modulus * SECTION.moment / (length**3 * (1 + phi))
    assert stiffness[np.ix_(elements.XY, elements.XY)] == pytest.approx(form, rel=1e-12)


def test_element_of_a_rigid_motion():
    length = 0.3
    mass, stiffness, gyroscopic = elements.beam(SECTION, length)
    shift, tilt = np.zeros(10), np.zeros(10)
    shift[[0, 5]] = 1.0
    tilt[[0, 5, 3, 8]] = -length / 2, length / 2, 1.0, 1.0  # v and G
    whole = SECTION.density * SECTION.area * length
    diametral = whole * length**2 / 12 + SECTION.density * SECTION.moment * length
    for motion, inertia in ((shift, whole), (tilt, diametral)):
        assert np.abs(stiffness @ motion).max() < 1e-12 * np.abs(stiffness).max()
        assert motion @ mass @ motion == pytest.approx(inertia, rel=1e-12)
    across = np.zeros(10)
    across[[1, 6, 2, 7]] = length / 2, -length / 2, 1.0, 1.0  # w and B
    # I_d B'' + spin I_p G' = M_y
    polar = 2 * SECTION.density * SECTION.moment * length
    assert across @ gyroscopic @ tilt == pytest.approx(polar, rel=1e-12)


def test_published_frequencies():
    spin = 4000 * 2 * np.pi / 60
    found = published.v3().eigenvalues(spin, lateral_only=True).imag[:5]
    assert found == pytest.approx(published.V3_AT_4000_RPM, abs=1e-2)  # printed digits
    found = published.v1().eigenvalues(published.V1_SPEED).imag[:13] / (2 * np.pi)
    assert found == pytest.approx(published.V1_HZ, rel=1e-4)


def test_independent_solution_is_ten_times_more_accurate_than_its_tolerance():
    scene = Geared(bows={"input": HalfSine(1.2e-3, -2.0)}, angles=(2.5, 0.9))
    train, times = scene.reference(), np.linspace(0, 2e-3, 21)
    usual = independent_solution.from_rest(train, 100.0, times)
    closer = independent_solution.from_rest(train, 100.0, times, rtol=1e-12)
    for name in ("g1", "g2", "g3", "g4"):
        u = closer.displacement(name)
        assert np.abs(usual.displacement(name) - u).max() < 1e-7 * np.ptp(u, axis=0).max()
    force = closer.mesh_force(1, live=True)
    assert np.abs(usual.mesh_force(1, live=True) - force).max() < 1e-7 * np.ptp(force)


def test_independent_solution_conserves_energy():
    # undamped, from rest, zero speed: only the live geometry conserves energy
    scene = Geared(
        bows={"input": HalfSine(1e-3), "middle": HalfSine(-8e-4, 1.0)},
        torque=0.0,
        bearing_damping=0.0,
        mesh_damping_ratio=0.0,
        elements=2,
    )
    train, times = scene.reference(), np.linspace(0, 2e-3, 41)
    bow = sum(train.bow_shape(shaft, 0.0) for shaft in train.shafts)

    def energies(live: bool) -> np.ndarray:
        run = independent_solution.from_rest(train, 0.0, times, live)
        rest = train.grounded - train.elastic
        out = np.einsum("ki,ij,kj->k", run.qd, train.mass, run.qd)
        out += np.einsum("ki,ij,kj->k", run.q - bow, train.elastic, run.q - bow)
        out += np.einsum("ki,ij,kj->k", run.q, rest, run.q)
        forces = [run.mesh_force(i, live) for i in range(2)]
        return (out + sum(f**2 for f in forces) / scene.mesh_stiffness) / 2

    energy = energies(live=True)
    assert np.abs(energy / energy[0] - 1).max() < 1e-8
    # and the geometry has a visible effect in this scene
    frozen = independent_solution.from_rest(train, 0.0, times, live=False).mesh_force(0, live=False)
    moving = independent_solution.from_rest(train, 0.0, times, live=True).mesh_force(0, live=True)
    assert np.abs(frozen - moving).max() > 1e-3 * np.ptp(moving)
