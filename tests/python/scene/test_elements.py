"""Shaft elements of degree p: order of the frequencies, exact statics, and matrices in another basis."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.linalg import eigh, eigvals

import gearbow as gb
from reference import closed_forms
from reference.cases import each_case
from reference.elements import Section
from reference.high_order import Shaft
from reference.scenes import PAIR, single_shaft

ALL = range(1, 9)
LATERAL = ("v", "w", "B", "G")
STEPS = ((0.2, 0.06, 0.0), (0.3, 0.1, 0.05), (0.25, 0.08, 0.0))  # length, diameter, bore


def section(shear: bool = True, bore: float = 0.0, diameter: float = 0.1) -> Section:
    return Section(diameter, 207e9, 207e9 / 2.6, 7800.0, bore, shear)


def free(degree: int, elements: int, **how: Any) -> gb.RotorSystem:
    options = {"diameter": 0.1, "support": None, **how}
    return single_shaft(elements=elements, degree=degree, **options)


def stepped(degree: int | None, elements: int = 1, **how: Any) -> gb.RotorSystem:
    """Give a stepped, partly hollow shaft."""
    segments = [gb.Segment(l, d, inner, elements) for l, d, inner in STEPS]
    material = gb.Material(207e9, 7800.0, poisson_ratio=0.3)
    bow = how.pop("bow", None)
    shaft = gb.Shaft("s", segments=segments, degree=degree, material=material, bow=bow)
    return gb.RotorSystem(shafts=[shaft], **how)


def stepped_reference(degree: int) -> Shaft:
    """Give the same shaft, one element per step, in another basis."""
    sections = [section(bore=inner, diameter=d) for _, d, inner in STEPS]
    return Shaft(np.cumsum([0.0, *(l for l, _, _ in STEPS)]).tolist(), sections, degree)


def pair(degree: int) -> gb.RotorSystem:
    """Give two shafts of two elements with a gear in the middle."""
    return replace(PAIR, elements=2, degree=degree).package()


def direction(dof: tuple[str, Any, str]) -> str:
    return dof[2].rstrip("0123456789")


def frequencies(degree: int, elements: int, spin: float = 0.0, **how: Any) -> np.ndarray:
    """Give the whirl frequencies of a simply supported shaft [rad/s]; at rest one of each pair."""
    found = free(degree, elements, **how).matrices()
    ends = [("s", x, name) for x in (0.0, 1.0) for name in "vw"]
    kept = [n for n, dof in enumerate(found.dofs) if direction(dof) in LATERAL and dof not in ends]
    at = np.ix_(kept, kept)
    mass, stiffness, gyroscopic = found.mass[at], found.stiffness[at], found.gyroscopic[at]
    if spin == 0.0:
        return np.sqrt(eigh(stiffness, mass, eigvals_only=True))[::2]
    # Rates are divided by a frequency, so that the entries of the companion matrix are comparable.
    n, scale = len(mass), 1e4
    rates = np.linalg.solve(mass, np.hstack([-stiffness / scale, -spin * gyroscopic]))
    companion = np.vstack([np.hstack([np.zeros((n, n)), scale * np.eye(n)]), rates])
    values = np.imag(eigvals(companion))
    return np.sort(values[values > 0])


# --- order -----------------------------------------------------------------------------------------

#: Numbers of elements at which the error of the second frequency has its leading order and exceeds round-off.
COUNTS = {1: (12, 24), 2: (6, 12), 3: (4, 8), 4: (3, 6)}


@pytest.mark.parametrize("bore", [0.0, 0.08], ids=["solid", "hollow"])
@pytest.mark.parametrize("degree", COUNTS)
def test_bending_frequencies_converge_with_the_order_2p(degree: int, bore: float):
    exact = closed_forms.simply_supported(section(bore=bore), 1.0, 2)[0]
    errors = [frequencies(degree, n, inner_diameter=bore)[1] / exact - 1 for n in COUNTS[degree]]
    # The term of the next order changes the ratio of the errors by a few per cent.
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2 * degree, abs=0.2), errors


@pytest.mark.parametrize(("degree", "order"), [(1, 4), (2, 4), (3, 6), (4, 8)])
def test_without_shear_a_cubic_deflection_has_the_order_four(degree: int, order: int):
    exact = closed_forms.simply_supported(section(shear=False), 1.0, 2)[0]
    counts = COUNTS[max(degree, 2)]
    errors = [frequencies(degree, n, shear=False)[1] / exact - 1 for n in counts]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.2), errors


@pytest.mark.parametrize("degree", COUNTS)
def test_whirl_frequencies_converge_with_the_order_2p(degree: int):
    exact = np.array(closed_forms.simply_supported(section(), 1.0, 2, 3000.0))
    coarse, fine = (frequencies(degree, n, 3000.0)[2:4] / exact - 1 for n in COUNTS[degree])
    assert np.log2(coarse / fine) == pytest.approx(2 * degree, abs=0.2)
    assert exact[1] / exact[0] > 1.02


@pytest.mark.parametrize("degree", COUNTS)
def test_torsional_frequencies_converge_with_the_order_2p(degree: int):
    exact = closed_forms.free_torsion(section(), 1.0, 2)

    def error(elements: int) -> float:
        found = free(degree, elements, motion="torsion").matrices()
        return np.sqrt(eigh(found.stiffness, found.mass, eigvals_only=True)[2]) / exact - 1

    coarse, fine = (error(n) for n in COUNTS[degree])
    assert np.log2(coarse / fine) == pytest.approx(2 * degree, abs=0.2)


@pytest.mark.parametrize("bore", [0.0, 0.08])
def test_one_element_of_the_largest_degree_has_the_first_frequencies(bore: float):
    exact = [closed_forms.simply_supported(section(bore=bore), 1.0, n)[0] for n in (1, 2, 3)]
    # Errors of one element at p = 8 grow with the number of half waves.
    found = frequencies(8, 1, inner_diameter=bore)[:3]
    assert np.all(np.abs(found / exact - 1) < [1e-9, 1e-6, 1e-3])


# --- another basis ---------------------------------------------------------------------------------


@pytest.mark.parametrize("degree", ALL[1:])
def test_a_stepped_shaft_has_the_frequencies_of_another_basis(degree: int):
    found = stepped(degree, motion="lateral").matrices()
    mass, _, stiffness = stepped_reference(degree).assemble()
    own = eigh(found.stiffness, found.mass, eigvals_only=True)
    wanted = np.repeat(eigh(stiffness, mass, eigvals_only=True), 2)
    # Round-off of the largest frequency; the monomials of the other basis lose digits with the degree.
    assert own == pytest.approx(wanted, rel=1e-7, abs=1e-9 * wanted[-1])


@pytest.mark.parametrize("degree", ALL[1:])
def test_bow_and_unbalance_of_a_stepped_shaft_equal_those_of_another_basis(degree: int):
    speed, amplitude, length = 900.0, 1e-4 * np.exp(0.4j), 0.75
    bearings = [gb.Bearing("s", x, stiffness=3e8, damping=2e4) for x in (0.0, length)]
    disk = gb.Disk(
        "d", "s", 0.2, mass=3.0, diametral_inertia=0.01, polar_inertia=0.02, unbalance=2e-4j
    )
    system = stepped(degree, bearings=bearings, disks=[disk], bow=gb.Bow.mode(2, 1e-4, phase=0.4))
    found = system.synchronous([speed]).displacement("d")[0, 0]

    reference = stepped_reference(degree)
    mass, rotary, stiffness = reference.assemble()
    k = 2 * np.pi / length
    force = reference.bow_force(lambda x: -amplitude * k**2 * np.sin(k * x))
    dynamic = stiffness - speed**2 * mass + 2 * speed**2 * rotary + 0j
    for end in (0, 3):
        dynamic[end, end] += 3e8 + 1j * speed * 2e4
    tilt = len(reference.nodes) + 1
    dynamic[1, 1] -= speed**2 * 3.0
    dynamic[tilt, tilt] += speed**2 * (0.02 - 0.01)
    force[1] += speed**2 * 2e-4j
    wanted = np.linalg.solve(dynamic, force)[1]
    ahead, behind = closed_forms.forward_backward(found)
    assert abs(ahead / wanted - 1) < 1e-8  # condition of the matrices
    assert abs(behind) < 1e-8 * abs(wanted)


# --- statics, mass and rigid motions ---------------------------------------------------------------


@pytest.mark.parametrize("shear", [True, False], ids=["Timoshenko", "Rayleigh"])
@pytest.mark.parametrize("degree", ALL)
def test_the_matrices_of_the_nodes_do_not_depend_on_the_degree(degree: int, shear: bool):
    one, found = (free(p, 3, shear=shear).matrices() for p in (1, degree))
    n = len(one.dofs)
    bending = 2 * ((2 * degree - 1) if shear else max(degree - 2, 0)) if degree > 1 else 0
    assert len(found.dofs) == n + 3 * (bending + degree - 1)
    assert found.dofs[:n] == one.dofs
    for name in ("mass", "stiffness", "gyroscopic"):
        assert np.array_equal(getattr(found, name)[:n, :n], getattr(one, name))
    assert not found.stiffness[:n, n:].any()
    assert np.array_equal(found.mass, found.mass.T)
    assert np.array_equal(found.gyroscopic, -found.gyroscopic.T)
    scale = np.sqrt(np.diag(found.mass))
    assert np.linalg.eigvalsh(found.mass / np.outer(scale, scale))[0] > 1e-4 / degree**4
    assert np.linalg.eigvalsh(found.stiffness[n:, n:]).min(initial=1.0) > 0.0


def test_a_rigid_rotation_has_no_force_and_the_inertia_of_the_shaft():
    found = stepped(4, elements=2).matrices()
    translation, rotation = np.zeros((2, len(found.dofs)))
    for n, (_, x, name) in enumerate(found.dofs):
        if name == "v":
            translation[n], rotation[n] = 1.0, x
        elif name == "G":
            rotation[n] = 1.0
    x = np.cumsum([0.0, *(l for l, _, _ in STEPS)])
    sections = [section(bore=inner, diameter=d) for _, d, inner in STEPS]
    mass = sum(s.density * s.area * (b - a) for s, a, b in zip(sections, x, x[1:], strict=False))
    inertia = sum(
        s.density * (s.area * (b**3 - a**3) / 3 + s.moment * (b - a))
        for s, a, b in zip(sections, x, x[1:], strict=False)
    )
    assert translation @ found.mass @ translation == pytest.approx(mass, rel=1e-13)
    assert rotation @ found.mass @ rotation == pytest.approx(inertia, rel=1e-13)
    assert np.abs(found.stiffness @ rotation).max() < 1e-14 * np.abs(found.stiffness).max()


@pytest.mark.parametrize("degree", ALL)
def test_statics_are_exact_for_every_degree(degree: int):
    bearings = [gb.Bearing("s", x, stiffness=3e8) for x in (0.0, 0.75)]
    torques = [gb.Torque(("s", x), value) for x, value in ((0.0, 300.0), (0.75, -300.0))]

    def static(p: int) -> np.ndarray:
        system = stepped(p, bearings=bearings, torques=torques, gravity=9.81)
        n = len(stepped(1).dofs)
        return system.static().state[:n]

    # Round-off of the bearing stiffness relative to that of the shaft.
    assert static(degree) == pytest.approx(static(1), rel=1e-9, abs=1e-15)


def test_the_weight_bends_a_beam_as_the_closed_form_between_its_nodes():
    # A single element with p = 3 contains the deflection of a beam under its weight, of degree four.
    system = single_shaft(
        elements=1, degree=3, support=1e8, gravity=9.81, diameter=0.1, shear=False
    )
    static = system.static()
    names = [dof[2] for dof in static.coordinates.dofs]
    s = section(shear=False)
    # w'''' = −ρAg/EI: the twice integrated polynomial of degree 4 has the fourth derivative √(5/2)·3·(2/L)⁴.
    weight = s.density * s.area * 9.81 / (s.youngs_modulus * s.moment)
    assert static.state[names.index("w4")] == pytest.approx(
        -weight / (np.sqrt(2.5) * 3 * 16), rel=1e-12
    )
    assert static.state[names.index("v4")] == 0.0


# --- description -----------------------------------------------------------------------------------


def test_coordinates_have_the_names_of_shape_functions():
    names = [dof for dof in free(3, 2).dofs if isinstance(dof[1], tuple)]
    first = [name for _, ends, name in names if ends == (0.0, 0.5)]
    assert first == [
        *("v2", "w2", "B2", "G2", "twist2", "v3", "w3", "B3", "G3", "twist3"),
        *("v4", "w4"),
    ]
    assert [ends for _, ends, _ in names] == [(0.0, 0.5)] * 12 + [(0.5, 1.0)] * 12
    names = [dof[2] for dof in free(4, 1, shear=False).dofs if isinstance(dof[1], tuple)]
    assert names == ["twist2", "twist3", "v4", "w4", "twist4", "v5", "w5"]


@each_case("degree", [0, 9, -1, 1.5, "two", True])
def test_a_degree_is_a_whole_number_from_one_to_eight(degree: Any):
    with pytest.raises(gb.SceneError, match=r"^shafts\[0\]\.degree: must be"):
        free(degree, 2)


def test_degrees_of_shafts_survive_files(tmp_path: Any):
    given = stepped(3)
    given.save(tmp_path / "scene.toml")
    again = gb.RotorSystem.load(tmp_path / "scene.toml")
    assert again.description == given.description
    assert again.shafts[0].degree == 3
    assert again.dofs == given.dofs
    assert "degree" not in stepped(None).description["shafts"][0]
    assert stepped(None).dofs == stepped(1).dofs


# --- results ---------------------------------------------------------------------------------------


def test_results_of_modes_do_not_depend_on_the_degree():
    one, found = (pair(p).modes(speed=300.0, count=12) for p in (1, 4))
    assert found.whirl == one.whirl
    assert found.names() == one.names()
    shares = found.energy_shares()
    assert set(shares) == set(one.energy_shares())
    assert sum(shares.values()) == pytest.approx(np.ones(12), rel=1e-12)
    for figure in (found.plot(count=4), found.plot(2)):
        assert figure.axes
    # The positions of the overview include the nodes; frequencies and shapes of degree 1 have errors of some per cent.
    pairs = zip(one.plot(count=4).axes, found.plot(count=4).axes, strict=True)
    for wanted, panel in pairs:
        for coarse, line in zip(wanted.get_lines(), panel.get_lines(), strict=True):
            assert np.array_equal(line.get_xdata(), coarse.get_xdata())
            assert np.isin([0.0, 0.25, 0.5], line.get_xdata()).all()
            shape, other = (np.asarray(given.get_ydata()) for given in (line, coarse))
            assert np.abs(shape) == pytest.approx(np.abs(other), abs=0.1)


def test_places_are_those_of_nodes():
    system = pair(3)
    assert system.coordinates.lateral(("input", 0.5)) == [10, 11]
    with pytest.raises(gb.SceneError, match=r"has no node at 0\.1 m"):
        system.coordinates.twist(("input", 0.1))
    response = system.simulate(1e-4, 300.0, record=["nodes"])
    assert response.displacement(("output", 0.5)).shape == (response.time.size, 2)
    assert system.synchronous([300.0]).displacement(("output", 0.5)).shape == (1, 2, 2)


@pytest.mark.parametrize("shear", [True, False])
def test_a_sag_between_nodes_does_not_depend_on_the_elements(shear: bool):
    bow = gb.Bow.sag(1e-4, phase=0.3)

    def response(degree: int, elements: int) -> np.ndarray:
        options = {"bow": bow, "support": 1e8, "diameter": 0.1, "shear": shear}
        system = single_shaft(elements=elements, degree=degree, **options)
        return system.synchronous([900.0]).displacement(("s", 0.5))[0, 0]

    wanted = response(6, 4)
    # Degree 6 leaves 1e-8; nodal values of the bow alone would leave an error of the order of degree 1.
    assert response(6, 2) == pytest.approx(wanted, rel=1e-6)
    assert np.abs(response(1, 2) / wanted - 1.0).max() > 1e-4
