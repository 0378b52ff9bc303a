"""Axial force, internal damping and mass properties of shafts, against closed forms and published numbers."""

import math
from dataclasses import replace

import numpy as np
import pytest

import gearbow as gb
from reference.machines import BENDING_STIFFNESS, DISK_MASS, helical_pair, massless_rotor

STEEL_E, DENSITY = 207e9, 7850.0
LENGTH, DIAMETER = 1.0, 0.03
SECOND_MOMENT = math.pi * DIAMETER**4 / 64.0
EULER_LOAD = math.pi**2 * STEEL_E * SECOND_MOMENT / LENGTH**2
#: The bearings are rigid compared with the shaft, which costs digits.
rigid_bearings = pytest.mark.filterwarnings("ignore:natural frequencies range")


def column(force: float, *, degree: int = 8, **shaft) -> gb.RotorSystem:
    """Give a shaft on rigid bearings at its ends under an axial force."""
    beam = gb.Shaft(
        "s",
        length=LENGTH,
        outer_diameter=DIAMETER,
        elements=4,
        degree=degree,
        shear=False,
        axial_force=force,
        **shaft,
    )
    bearings = [gb.Bearing("s", x, stiffness=1e12) for x in (0.0, LENGTH)]
    return gb.RotorSystem([beam], bearings=bearings, motion="lateral")


@rigid_bearings
@pytest.mark.parametrize("share", [0.0, 1.5, -0.5, -0.999])
def test_an_axial_force_changes_the_frequencies_as_the_closed_form_does(share: float):
    # ω² = (nπ/L)⁴ EI/(ρA) (1 + P L²/(n²π²EI))/(1 + (nπr/L)²) with rotary inertia, r the radius of gyration.
    found = 2.0 * math.pi * column(share * EULER_LOAD).modes().frequencies_hz[:6:2]
    n = np.arange(1, 4)
    bending = STEEL_E * SECOND_MOMENT / (DENSITY * math.pi * DIAMETER**2 / 4.0)
    rotary = 1.0 + (n * math.pi * DIAMETER / 4.0 / LENGTH) ** 2
    expected = (n * math.pi / LENGTH) ** 2 * np.sqrt(bending * (1.0 + share / n**2) / rotary)
    # The bearings give way by 1e-6 of the deflection; near buckling the error of ω² is relative to 1 + P/P_E.
    np.testing.assert_allclose(found, expected, rtol=2e-6 / (1.0 + min(share, 0.0)))


@rigid_bearings
def test_the_first_frequency_vanishes_at_the_load_of_euler():
    lowest = [column(-part * EULER_LOAD).modes().frequencies_hz[0] for part in (0.0, 1.0 - 1e-5)]
    assert lowest[1] < 0.01 * lowest[0]
    with pytest.raises(gb.SceneError, match=r"shafts\[0\]\.axial_force: the shaft \"s\" buckles"):
        column(-1.001 * EULER_LOAD)


@pytest.mark.parametrize(
    ("force", "expected"),
    [
        (0.0, (13.792067, 43.658247, 114.080085)),
        (1e4, (13.935788, 43.913150, 114.759565)),
        (1e5, (15.020440, 46.132265, 120.620287)),
        (-1e4, (13.642635, 43.401542, 113.394556)),
    ],
)
def test_the_rotor_of_friswell_has_its_frequencies(force: float, expected: tuple[float, ...]):
    # Friswell et al. (2010), Dynamics of Rotating Machines, example 5.9.7.
    def disk(name: str, position: float, outer: float) -> gb.Disk:
        squares = (outer / 2.0) ** 2 + 0.025**2
        mass = 7810.0 * math.pi * ((outer / 2.0) ** 2 - 0.025**2) * 0.07
        diametral = mass * (3.0 * squares + 0.07**2) / 12.0
        return gb.Disk(name, "s", position, mass, diametral, mass * squares / 2.0)

    shaft = gb.Shaft(
        "s",
        length=1.5,
        outer_diameter=0.05,
        elements=6,
        material=gb.Material(211e9, 7810.0, shear_modulus=81.2e9),
        axial_force=force,
    )
    system = gb.RotorSystem(
        [shaft],
        disks=[disk("left", 0.5, 0.28), disk("right", 1.0, 0.35)],
        bearings=[gb.Bearing("s", x, stiffness=1e6) for x in (0.0, 1.5)],
        motion="lateral",
    )
    # The printed digits.
    np.testing.assert_allclose(system.modes().frequencies_hz[:6:2], expected, atol=6e-7)


@rigid_bearings
@pytest.mark.parametrize("degree", [1, 4])
def test_tension_straightens_a_bow(degree: int):
    # EI(q − b)'' = P q: a half sine is b/(1 + P/P_E).
    bow = gb.Bow.half_sine(1e-4)
    for share in (2.0, -0.5):
        system = column(share * EULER_LOAD, degree=degree, bow=bow)
        found = abs(system.synchronous([0.0]).displacement(("s", LENGTH / 2.0))[0].sum(axis=0)[0])
        # Four elements of degree 1 represent the half sine to 1e-3.
        assert found == pytest.approx(1e-4 / (1.0 + share), rel=5e-3 if degree == 1 else 1e-5)


def test_energies_of_a_bowed_shaft_under_tension_are_in_balance():
    system = column(EULER_LOAD, degree=2, bow=gb.Bow.half_sine(1e-4))
    system = system.replace(
        bearings=[gb.Bearing("s", x, stiffness=1e7, damping=200.0) for x in (0.0, LENGTH)]
    )
    run = system.simulate(
        0.05, 150.0, initial="rest", record=["energy"], output_step=1e-3, method="exponential"
    )
    balance = run.energy_balance()
    assert np.abs(balance.residual).max() < 1e-6 * np.abs(balance.total).max()


def test_the_thrust_of_helical_gears_acts_on_the_shafts():
    plain = helical_pair()
    stiffened = plain.replace(geometric_stiffness=True)
    # The thrust, F_t tan β of about 2 kN, acts between a gear and the bearings that hold its shaft along the axis.
    found, known = (each.modes().frequencies_hz[1:10] for each in (stiffened, plain))
    assert 1e-9 < np.abs(found / known - 1.0).max() < 1e-2
    # Without torque there is no thrust.
    idle = plain.replace(torques=[])
    found, known = (
        each.modes().frequencies_hz[1:10] for each in (idle.replace(geometric_stiffness=True), idle)
    )
    np.testing.assert_allclose(found, known, rtol=1e-9)
    again = gb.RotorSystem.from_dict(stiffened.description)
    assert again.geometric_stiffness


# --- internal damping -----------------------------------------------------------------------------


def rotor_of_ansys(**shaft) -> gb.RotorSystem:
    """Give the rotor of the ANSYS verification problem VM261."""
    beam = gb.Shaft(
        "s",
        length=1.27,
        outer_diameter=0.1016,
        shear=False,
        material=gb.Material(2.1e11, 7800.0, poisson_ratio=0.3),
        **{"internal_damping": 2e-4, "elements": 16, **shaft},
    )
    bearings = [gb.Bearing("s", x, stiffness=1.75e7) for x in (0.0, 1.27)]
    return gb.RotorSystem([beam], bearings=bearings, motion="lateral")


def test_thresholds_of_ansys_are_the_forward_critical_speeds():
    campbell = rotor_of_ansys().campbell(np.linspace(0.0, 1300.0, 27), count=4)
    found = [each for each in campbell.thresholds if each.above == "unstable"]
    assert [each.whirl for each in found] == ["forward", "forward"]
    rpm = [each.speed * 30.0 / math.pi for each in found]
    # The published critical speeds; their elements are coarser than ours.
    np.testing.assert_allclose(rpm, [5000.2, 10523.0], rtol=1e-3)
    undamped = rotor_of_ansys(internal_damping=0.0)
    critical = undamped.campbell(np.linspace(0.0, 1300.0, 27), count=4).intersections
    speeds = [each.speed for each in critical if each.whirl == "forward"]
    # Exact: relative to the shaft, the mode stands still there.
    np.testing.assert_allclose([each.speed for each in found], speeds[:2], rtol=1e-6)


@rigid_bearings
@pytest.mark.parametrize("external", [0.5, 2.0])
def test_external_damping_raises_the_threshold_of_a_jeffcott_rotor(external: float):
    # Ω = ω(1 + c_e/c_i) with the internal damping c_i = βk.
    frequency, beta = math.sqrt(BENDING_STIFFNESS / DISK_MASS), 1e-4
    system = massless_rotor({"internal_damping": beta}, damping=external * beta * BENDING_STIFFNESS)
    expected = frequency * (1.0 + external)
    campbell = system.campbell(np.linspace(0.5, 1.5, 11) * expected, count=2)
    (found,) = [each for each in campbell.thresholds if each.above == "unstable"]
    # The bearings give way by 4e-5 of the deflection.
    assert found.speed == pytest.approx(expected, rel=1e-4)


def test_undamped_critical_speeds_have_no_internal_damping():
    speeds = [
        rotor_of_ansys(internal_damping=beta).critical_speed_map([1e6, 1.75e7], count=3).speeds
        for beta in (2e-4, 0.0)
    ]
    # The same matrices.
    np.testing.assert_allclose(*speeds, rtol=1e-9)


def test_damped_modes_follow_from_the_matrices():
    system = rotor_of_ansys()
    speed = 900.0
    matrices = system.matrices(speed)
    n = len(matrices.dofs)
    inverse = np.linalg.inv(matrices.mass)
    first_order = np.block(
        [
            [np.zeros((n, n)), np.eye(n)],
            [
                -inverse @ matrices.stiffness,
                -inverse @ (matrices.damping + speed * matrices.gyroscopic),
            ],
        ]
    )
    expected = np.linalg.eigvals(first_order)
    found = system.modes(speed).eigenvalues
    for eigenvalue in found[np.argsort(np.abs(found))][:8]:
        # An unscaled matrix of M⁻¹K has round-off of 1e-16 ω_max²/ω².
        assert np.abs(expected - eigenvalue).min() < 1e-6 * abs(eigenvalue)
    # −iΩβK: the circulatory part is the skew part of K, and β times the symmetric one.
    skew = (matrices.stiffness - matrices.stiffness.T) / 2.0
    standing = system.matrices(0.0)
    v, w = (
        [i for i, dof in enumerate(matrices.dofs) if dof[2] == kind and dof[1] not in (0.0, 1.27)]
        for kind in "vw"
    )
    np.testing.assert_allclose(
        skew[np.ix_(v, w)], 2e-4 * speed * standing.stiffness[np.ix_(v, v)], rtol=1e-9, atol=1e-3
    )


@pytest.mark.parametrize("method", ["exponential", "rk45", "etdrk4"])
def test_runs_of_every_method_agree(method: str):
    system = rotor_of_ansys(bow=gb.Bow.half_sine(1e-4), elements=4, degree=2)
    system = system.replace(
        bearings=[gb.Bearing("s", x, stiffness=1.75e7, damping=3e3) for x in (0.0, 1.27)]
    )
    middle = ("s", 0.635)
    options = {"initial": "rest", "record": [middle], "output_step": 1e-3}
    found = system.simulate(0.03, 700.0, method=method, **options).displacement(middle)
    expected = system.simulate(0.03, 700.0, method="rk4", step=1e-6, **options)
    expected = expected.displacement(middle)
    np.testing.assert_allclose(found, expected, atol=1e-4 * np.abs(expected).max())


def test_a_bow_turns_with_the_shaft_so_that_internal_damping_does_not_see_it():
    speeds = [100.0, 400.0]
    bow = gb.Bow.half_sine(1e-4)
    damped, undamped = (
        rotor_of_ansys(bow=bow, internal_damping=beta)
        .synchronous(speeds)
        .displacement(("s", 0.635))
        for beta in (2e-4, 0.0)
    )
    # In isotropic bearings the shaft has one deformed shape, which turns with it.
    np.testing.assert_allclose(damped, undamped, rtol=1e-9, atol=1e-15)


@pytest.mark.parametrize(
    ("method", "speed"),
    [
        ("exponential", 700.0),
        ("exponential", -700.0),
        ("rk45", 700.0),
        ("rk45", gb.SpeedProfile.ramp(300.0, 900.0, 0.05)),
        ("exponential", gb.SpeedProfile.ramp(300.0, 900.0, 0.05)),
    ],
)
def test_the_energy_audit_contains_the_work_of_internal_damping(method: str, speed):
    system = rotor_of_ansys(bow=gb.Bow.half_sine(1e-4), elements=4, degree=2, internal_damping=1e-3)
    bearings = [
        gb.Bearing("s", x, stiffness=k, damping=3e3) for x, k in ((0.0, 1.75e7), (1.27, 3e7))
    ]
    system = system.replace(bearings=bearings, gravity=9.81)
    run = system.simulate(0.05, speed, method=method, initial="rest", record=["energy"], rtol=1e-9)
    balance = run.energy_balance()
    assert balance.damping[-1] < -0.1 * balance.total.max()
    # The tolerance of the run.
    assert abs(balance.residual).max() < 1e-6 * balance.total.max()


def test_a_shaft_that_turns_below_its_weight_takes_power_from_its_drive():
    speed, duration = 300.0, 0.01
    system = rotor_of_ansys(internal_damping=1e-4, elements=4, degree=2).replace(gravity=9.81)
    run = system.simulate(duration, speed, record=["energy"])
    # The deflection u stands still, and moves with −iΩu relative to the shaft.
    matrices, state = system.matrices(speed), system.static(speed=speed).state
    power = speed**2 * state @ (matrices.damping @ state)
    balance = run.energy_balance()
    assert balance.damping[-1] == pytest.approx(-power * duration, rel=1e-6)
    assert balance.drive[-1] == pytest.approx(power * duration, rel=1e-6)


def test_negative_internal_damping_is_an_error():
    with pytest.raises(gb.SceneError, match=r"internal_damping: must not be negative"):
        rotor_of_ansys(internal_damping=-1e-4)


# --- mass properties ------------------------------------------------------------------------------


def test_mass_properties_of_a_cone_with_a_sleeve_are_those_of_solids():
    length, radius = 0.3, 0.04
    cone = gb.Segment(length, 2.0 * radius, end_outer_diameter=0.02)
    found = gb.RotorSystem([gb.Shaft("s", segments=[cone])]).mass_properties()
    r, e = radius, 0.01
    volume = math.pi * length / 3.0 * (r * r + r * e + e * e)
    assert found.mass[0] == pytest.approx(DENSITY * volume, rel=1e-12)
    centre = length / 4.0 * (r * r + 2.0 * r * e + 3.0 * e * e) / (r * r + r * e + e * e)
    assert found.centre[0, 0] == pytest.approx(centre, rel=1e-12)
    polar = DENSITY * math.pi * length / 10.0 * (r**5 - e**5) / (r - e)
    assert found.polar_inertia[0] == pytest.approx(polar, rel=1e-12)
    sleeve = gb.Sleeve("s", 0.1, 0.2, 0.1, 0.08)
    more = gb.RotorSystem([gb.Shaft("s", segments=[cone])], sleeves=[sleeve]).mass_properties()
    added = DENSITY * math.pi * 0.1 * (0.05**2 - 0.04**2)
    assert more.mass[0] - found.mass[0] == pytest.approx(added, rel=1e-9)


def test_the_machine_is_the_sum_of_its_shafts():
    system = helical_pair()
    found = system.mass_properties()
    masses = found.mass
    assert found.total_mass == pytest.approx(masses.sum())
    np.testing.assert_allclose(found.total_centre, masses @ found.centre / masses.sum(), rtol=1e-12)
    distance = np.linalg.norm(found.centre[0, 1:] - found.centre[1, 1:])
    # Two bodies at a distance: m₁m₂/(m₁ + m₂) d² about the axis.
    reduced = masses.prod() / masses.sum()
    expected = found.polar_inertia.sum() + reduced * distance**2
    assert found.total_inertia[0, 0] == pytest.approx(expected, rel=1e-12)
    assert list(found.to_dataframe()["shaft"]) == [*found.names, "machine"]
    assert "machine" in found.table()


def test_the_mass_matrix_has_the_mass_of_the_properties():
    system = helical_pair()
    matrices = system.matrices()
    along = np.array([kind == "v" and not isinstance(x, tuple) for _, x, kind in matrices.dofs])
    total = along.astype(float) @ matrices.mass @ along.astype(float)
    assert system.mass_properties().total_mass == pytest.approx(total, rel=1e-9)


def test_parts_are_kept_by_replace():
    system = rotor_of_ansys()
    changed = system.replace(
        shafts=[replace(system.shafts[0], internal_damping=1e-4, axial_force=1e3)]
    )
    assert changed.shafts[0].axial_force == 1e3
