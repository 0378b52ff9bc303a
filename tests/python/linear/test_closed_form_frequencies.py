"""Natural frequencies against closed forms: Timoshenko shafts on rigid ends, torsion, gear trains."""

from __future__ import annotations

import numpy as np
import pytest

import gearbow as gb
from reference import closed_forms
from reference.elements import Section
from reference.scenes import single_shaft

SUPPORT = 1e13  # N/m; the closed form is corrected for the remaining flexibility
ELEMENTS = 32


def solid(diameter: float, bore: float = 0.0, shear: bool = True) -> Section:
    return Section(diameter, 207e9, 207e9 / 2.6, 7800.0, bore, shear)


def tolerance(section: Section, number: int) -> float:
    # leading error of the elements, one third more for the next order, and 3e-6 for the
    # second order of the supports' flexibility
    return 1.35 * closed_forms.element_error(section, 1.0, number, ELEMENTS) + 3e-6


@pytest.mark.filterwarnings(
    "ignore::gearbow.AccuracyWarning"
)  # flexibility of bearings of 1e13 N/m for the thinnest shaft
@pytest.mark.parametrize("shear", [True, False], ids=["Timoshenko", "Rayleigh"])
@pytest.mark.parametrize(
    ("diameter", "bore"),
    [(0.02, 0.0), (0.05, 0.0), (0.1, 0.0), (0.2, 0.0), (0.1, 0.06), (0.2, 0.16)],
)
def test_simply_supported_shaft(diameter: float, bore: float, shear: bool):
    section = solid(diameter, bore, shear)
    system = single_shaft(
        diameter=diameter, inner_diameter=bore, elements=ELEMENTS, shear=shear, support=SUPPORT
    )
    found = 2 * np.pi * system.modes(count=6).frequencies_hz
    for number in (1, 2, 3):
        exact = closed_forms.simply_supported(section, 1.0, number)[0]
        exact *= 1 - closed_forms.support_shift(section, 1.0, number, SUPPORT)
        pair = found[2 * number - 2 : 2 * number]
        assert pair == pytest.approx([exact, exact], rel=tolerance(section, number))


def test_first_frequency_of_the_published_table():
    found = 2 * np.pi * single_shaft(elements=64).modes(count=1).frequencies_hz[0]
    assert found == pytest.approx(633.630, abs=2e-3)  # the last digit printed; elements leave 4e-4


def test_frequency_depends_on_the_shear_coefficient_of_a_hollow_shaft():
    # a thin tube has kappa 0.53, a solid shaft 0.886: 10 % in this frequency, far above any
    # tolerance here
    tube = Section(0.2, 207e9, 207e9 / 2.6, 7800.0, 0.18)
    assert tube.kappa == pytest.approx(0.5338, abs=1e-3)
    system = single_shaft(diameter=0.2, inner_diameter=0.18, elements=ELEMENTS, support=SUPPORT)
    exact = closed_forms.simply_supported(tube, 1.0, 2)[0]
    exact *= 1 - closed_forms.support_shift(tube, 1.0, 2, SUPPORT)
    found = 2 * np.pi * system.modes(count=4).frequencies_hz[2]
    assert found == pytest.approx(exact, rel=tolerance(tube, 2))


@pytest.mark.parametrize("spin", [500.0, 3000.0, -3000.0])
def test_whirl_with_gyroscopic_moment(spin: float):
    section = solid(0.1)
    system = single_shaft(diameter=0.1, elements=ELEMENTS, support=SUPPORT)
    modes = system.modes(speed=spin, count=6)
    found = 2 * np.pi * modes.frequencies_hz
    for number in (1, 2, 3):
        shift = 1 - closed_forms.support_shift(section, 1.0, number, SUPPORT)
        # forward whirl has the sense of the spin, for both signs of the spin
        exact = np.array(closed_forms.simply_supported(section, 1.0, number, abs(spin))) * shift
        pair = slice(2 * number - 2, 2 * number)
        assert found[pair] == pytest.approx(exact, rel=tolerance(section, number))
        assert list(modes.whirl[pair]) == ["backward", "forward"]
        assert exact[1] / exact[0] - 1 > 4 * tolerance(
            section, number
        )  # both frequencies differ clearly


def test_an_undamped_system_has_undamped_modes():
    modes = single_shaft(diameter=0.1).modes(speed=2000.0, count=8)
    # round-off of a first-order pencil whose frequencies span four decades
    assert np.abs(modes.damping_ratios).max() < 1e-8


@pytest.mark.parametrize("bore", [0.0, 0.03])
def test_free_torsion(bore: float):
    elements = 16
    section = solid(0.05, bore)
    system = single_shaft(inner_diameter=bore, elements=elements, support=None, motion="torsion")
    found = 2 * np.pi * system.modes(count=6).frequencies_hz
    assert found[0] == pytest.approx(0, abs=1e-3 * found[1])  # the shaft rotates freely
    for number in range(1, 6):
        chain = closed_forms.free_torsion_of_elements(section, 1.0, number, elements)
        # the same chain of elements: only round-off differs
        assert found[number] == pytest.approx(chain, rel=1e-9)
        exact = closed_forms.free_torsion(section, 1.0, number)
        # linear elements with consistent mass: (kh)^2 / 24, twice that as a bound
        assert found[number] == pytest.approx(exact, rel=(number * np.pi / elements) ** 2 / 12)
    assert {dof[2] for dof in system.matrices().dofs} == {"twist"}


def test_torsion_converges_with_order_two():
    section = solid(0.05)
    errors = []
    for elements in (8, 16):
        system = single_shaft(elements=elements, support=None, motion="torsion")
        found = 2 * np.pi * system.modes(count=2).frequencies_hz[1]
        errors.append(found / closed_forms.free_torsion(section, 1.0, 1) - 1)
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2, abs=0.05)


def rigid_train(
    teeth: list[tuple[int, int]], inertias: list[float], stiffnesses: list[float], **options: object
) -> gb.RotorSystem:
    """Shafts in a chain, stiff enough to be rigid (a twist of 1e-5 of the mesh's), without
    bearings.
    """
    stiff = gb.Material(youngs_modulus=1e17, density=7850.0, poisson_ratio=0.3)
    count = len(inertias)
    own = [7850.0 * np.pi / 32 * 0.05**4 * 0.3] * count
    gears, meshes = [], []
    for i, (a, b) in enumerate(teeth):
        gears += [(f"a{i}", i, 0.2, a), (f"b{i}", i + 1, 0.1, b)]
        meshes.append(gb.Mesh(f"a{i}", f"b{i}", stiffness=stiffnesses[i]))
    per_shaft = [sum(1 for g in gears if g[1] == i) for i in range(count)]
    return gb.RotorSystem(
        shafts=[
            gb.Shaft(f"s{i}", length=0.3, outer_diameter=0.05, elements=1, material=stiff)
            for i in range(count)
        ],
        gears=[
            gb.Gear(
                name,
                shaft=f"s{i}",
                position=x,
                teeth=z,
                module=3e-3,
                face_width=0.03,
                mass=1.0,
                diametral_inertia=1e-2,
                # the prescribed inertia minus that of the shaft
                polar_inertia=(inertias[i] - own[i]) / per_shaft[i],
            )
            for name, i, x, z in gears
        ],
        meshes=meshes,
        **options,
    )


def base(teeth: int) -> float:
    return closed_forms.full_depth_gear(teeth, 3e-3)["base"]


@pytest.mark.parametrize("options", [{}, {"motion": "torsion"}], ids=["left out", "asked for"])
@pytest.mark.implausible
def test_two_rigid_gears(options: dict[str, str]):
    inertias, stiffness = [0.02, 0.3], 2e8
    system = rigid_train([(25, 50)], inertias, [stiffness], **options)
    assert {dof[2] for dof in system.matrices().dofs} == {"twist"}
    exact = closed_forms.geared_pair(stiffness, (base(25), base(50)), (inertias[0], inertias[1]))
    modes = system.modes(count=2)
    # the twist of the shafts is 1e-5 of the mesh deflection
    assert 2 * np.pi * modes.frequencies_hz[1] == pytest.approx(exact, rel=5e-5)
    assert modes.frequencies_hz[0] == pytest.approx(0, abs=1e-3)


@pytest.mark.implausible
def test_chain_of_four_rigid_shafts():
    teeth, inertias = [(25, 50), (20, 61), (33, 17)], [0.02, 0.3, 0.11, 0.07]
    stiffnesses = [2e8, 1e8, 3.3e8]
    exact = closed_forms.geared_chain(stiffnesses, [(base(a), base(b)) for a, b in teeth], inertias)
    modes = rigid_train(teeth, inertias, stiffnesses).modes(count=4)
    assert modes.frequencies_hz[0] == pytest.approx(0, abs=1e-3)
    # the twist of the shafts is 1e-5 of the mesh deflection
    assert 2 * np.pi * modes.frequencies_hz[1:] == pytest.approx(exact[1:], rel=1e-4)


@pytest.mark.filterwarnings("ignore::gearbow.SceneWarning", "ignore::gearbow.AccuracyWarning")
@pytest.mark.parametrize("density", [1e-3, 1e-6, 1e-9])
@pytest.mark.parametrize("elements", [2, 40])  # dense matrices, band matrices
def test_shafts_with_hardly_any_inertia_do_not_hide_the_lowest_frequencies(density, elements):
    # disks on short shafts, joined by couplings: only the disks have inertia, the shafts less
    # than 1e-11 of it
    inertias = np.array([1170.0, 1950.0, 10800.0, 11100.0, 10900.0, 430.0])
    springs = [4.6e7, 8.3e7, 1.2e8, 1.7e8, 6.7e6]
    stiffness = np.zeros((6, 6))
    for index, spring in enumerate(springs):
        stiffness[index : index + 2, index : index + 2] += [[spring, -spring], [-spring, spring]]
    squares = np.linalg.eigvalsh(stiffness / np.sqrt(np.outer(inertias, inertias)))
    light = gb.Material(207e9, density, poisson_ratio=0.3)
    names = [f"shaft {number}" for number in range(6)]
    line = gb.RotorSystem(
        motion="torsion",
        shafts=[
            gb.Shaft(name, length=0.1, outer_diameter=0.1, elements=elements, material=light)
            for name in names
        ],
        disks=[
            gb.Disk(f"disk of {name}", name, 0.05, 1.0, inertia / 2, inertia)
            for name, inertia in zip(names, inertias, strict=True)
        ],
        couplings=[
            gb.Coupling(f"disk of {first}", f"disk of {second}", torsional_stiffness=spring)
            for first, second, spring in zip(names, names[1:], springs, strict=False)
        ],
    )
    found = 2 * np.pi * line.modes(count=6).frequencies_hz
    # round-off of the stiffness of the shafts is 1e-8 of the lowest frequency
    assert found[1:] == pytest.approx(np.sqrt(squares[1:]), rel=1e-7)
