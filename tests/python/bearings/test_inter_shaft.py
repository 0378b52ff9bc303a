"""Bearings between two shafts: closed forms of two rigid rotors, numbers of ROSS, and every analysis.

Two rigid symmetric rotors share their middle. The inner one stands on two ground bearings k₁ at ±a, and the outer one on
two bearings k₂ at ±b between both. Then translation and tilt separate, and each has two degrees of freedom.
"""

import dataclasses

import numpy as np
import pytest

import gearbow as gb
from gearbow.orders import Kinematics
from reference.comparisons import assert_energy_closes

# Rigid shafts have fast modes.
pytestmark = pytest.mark.filterwarnings("ignore::gearbow.AccuracyWarning")

RIGID = gb.Material(1e14, 100.0, poisson_ratio=0.3)
INNER_DIAMETER, OUTER_DIAMETER, BORE = 0.2, 0.4, 0.3
INNER_MASS, OUTER_MASS = 20.0, 12.0
INNER_INERTIA, OUTER_INERTIA = (0.5, 0.4), (0.3, 0.45)  # diametral, polar
GROUND, BETWEEN = 4e6, 3e6
A, B = 0.5, 0.25
RATIO = -1.5
#: The shafts are rigid to this part of their bearings.
RIGIDITY = 5e-5
SPEED = 300.0


def pair(ground=None, between=None, **options):
    """Two rigid rotors, with other bearings if given."""
    ground = ground or (lambda x: gb.Bearing("inner", x, stiffness=GROUND, damping=300.0))
    between = between or (
        lambda x, at: gb.Bearing("outer", x, stiffness=BETWEEN, damping=200.0, support=at)
    )
    given = {
        "shafts": [
            gb.Shaft(
                "inner", length=1.0, outer_diameter=INNER_DIAMETER, elements=4, material=RIGID
            ),
            gb.Shaft(
                "outer",
                length=0.5,
                outer_diameter=OUTER_DIAMETER,
                inner_diameter=BORE,
                elements=2,
                material=RIGID,
                speed_ratio=RATIO,
            ),
        ],
        "disks": [
            gb.Disk("fan", "inner", 0.5, INNER_MASS, *INNER_INERTIA, unbalance=2e-3),
            gb.Disk("drum", "outer", 0.25, OUTER_MASS, *OUTER_INERTIA, unbalance=1e-3j),
        ],
        "bearings": [
            *(ground(x) for x in (0.0, 1.0)),
            *(between(x, ("inner", x + 0.25)) for x in (0.0, 0.5)),
        ],
    }
    return gb.RotorSystem(**{**given, **options})


def closed_form(speed=SPEED):
    """Mass, damping with gyroscopic moments, and stiffness of translation and of tilt."""
    squares = (INNER_DIAMETER**2, OUTER_DIAMETER**2 - BORE**2)
    own = [100.0 * np.pi / 4 * squares[0] * 1.0, 100.0 * np.pi / 4 * squares[1] * 0.5]
    radii = [INNER_DIAMETER**2 / 16, (OUTER_DIAMETER**2 + BORE**2) / 16]
    diametral = [
        m * (length**2 / 12 + r) for m, length, r in zip(own, (1.0, 0.5), radii, strict=True)
    ]
    polar = [2 * m * r for m, r in zip(own, radii, strict=True)]
    k = np.array([[2 * (GROUND + BETWEEN), -2 * BETWEEN], [-2 * BETWEEN, 2 * BETWEEN]])
    c = np.array([[2 * (300.0 + 200.0), -2 * 200.0], [-2 * 200.0, 2 * 200.0]])
    m = np.diag([INNER_MASS + own[0], OUTER_MASS + own[1]])
    g, b = GROUND * A**2, BETWEEN * B**2
    k_tilt = 2 * np.array([[g + b, -b], [-b, b]])
    g, b = 300.0 * A**2, 200.0 * B**2
    c_tilt = 2 * np.array([[g + b, -b], [-b, b]])
    m_tilt = np.diag([INNER_INERTIA[0] + diametral[0], OUTER_INERTIA[0] + diametral[1]])
    spins = np.array([1.0, RATIO]) * speed
    gyroscopic = np.diag(spins * (np.array([INNER_INERTIA[1], OUTER_INERTIA[1]]) + polar))
    return (m, c, k), (m_tilt, c_tilt - 1j * gyroscopic, k_tilt)


def quadratic(m, c, k):
    """Eigenvalues of M λ² + C λ + K."""
    n = len(m)
    inverse = np.linalg.inv(m)
    block = np.block([[np.zeros((n, n)), np.eye(n)], [-inverse @ k, -inverse @ c]])
    return np.linalg.eigvals(block)


def test_modes_of_two_rigid_rotors():
    system = pair()
    translation, tilt = closed_form()
    wanted = np.concatenate([quadratic(*translation), quadratic(*tilt)])
    found = system.modes(SPEED).eigenvalues
    found = np.concatenate([found, found.conj()])
    for value in wanted:
        assert np.abs(found - value).min() < RIGIDITY * abs(value)


def test_unbalance_of_one_shaft_forces_the_other_at_its_own_speed():
    system = pair()
    (m, c, k), _ = closed_form()
    speeds = np.array([150.0, 300.0, 700.0])
    response = system.synchronous(speeds)
    for source, (ratio, unbalance) in enumerate(((1.0, 2e-3), (RATIO, 1e-3j))):
        for i, speed in enumerate(speeds):
            spin = ratio * speed
            force = np.zeros(2, complex)
            force[source] = unbalance * spin**2
            wanted = np.linalg.solve(-(spin**2) * m + 1j * spin * c + k, force)
            for at, value in zip(("fan", "drum"), wanted, strict=True):
                v, w = response.displacement(at)[i, source]
                # v + iw = value·e^{i spin t}: the parts along y and z are value and −i·value.
                # Near a resonance an error of the stiffness counts more.
                assert abs(v - value) < 4 * RIGIDITY * abs(value)
                assert abs(w + 1j * value) < 4 * RIGIDITY * abs(value)


def test_critical_speeds_have_both_spools():
    (m, _, k), _ = closed_form()
    campbell = pair().campbell(np.linspace(0.0, 900.0, 31), count=8)
    speeds = {
        shaft: [each.speed for each in campbell.intersections if each.line.source == shaft]
        for shaft in ("inner", "outer")
    }
    for frequency in np.sqrt(np.linalg.eigvals(np.linalg.solve(m, k)).real):
        for shaft, ratio in (("inner", 1.0), ("outer", abs(RATIO))):
            wanted = frequency / ratio
            if wanted < 900.0:
                # Damping of 1 % changes a frequency by its square.
                assert np.abs(np.array(speeds[shaft]) / wanted - 1.0).min() < 1e-3


def test_static_equilibrium_and_bearing_forces():
    system = pair(gravity=9.81)
    (m, _, k), _ = closed_form()
    weights = -9.81 * np.diag(m)
    wanted = np.linalg.solve(k, weights)
    static = system.static()
    for at, value in zip(("fan", "drum"), wanted, strict=True):
        assert static.displacement(at)[1] == pytest.approx(value, rel=RIGIDITY)
    for x in (0.0, 0.5):
        # The weight of the outer rotor goes through the bearings between the rotors.
        assert static.bearing_force(("outer", x))[1] == pytest.approx(weights[1] / 2, rel=1e-9)
    assert static.bearing_force(("inner", 0.0))[1] == pytest.approx(sum(weights) / 2, rel=1e-9)


def translation_at(times, speed):
    """Integrate the translation of both rotors from the synchronous motion with SciPy's formula."""
    (m, c, k), _ = closed_form()
    total = np.zeros((2, len(times)), complex)
    for source, (ratio, unbalance) in enumerate(((1.0, 2e-3), (RATIO, 1e-3j))):
        spin = ratio * speed
        force = np.zeros(2, complex)
        force[source] = unbalance * spin**2
        phasor = np.linalg.solve(-(spin**2) * m + 1j * spin * c + k, force)
        total += phasor[:, np.newaxis] * np.exp(1j * spin * times)
    return total


METHODS = {
    "exponential": {},
    "rk45": {"rtol": 1e-7},
    "rk4": {"step": 2e-6},
    "etdrk4": {"step": 1e-4},
}


@pytest.mark.parametrize("method", ["exponential", "rk45", "etdrk4"])
def test_runs_have_both_frequencies(method):
    run = pair().simulate(
        0.02, SPEED, method=method, output_step=1e-3, record=["disks"], **METHODS[method]
    )
    wanted = translation_at(run.time, SPEED)
    for at, motion in zip(("fan", "drum"), wanted, strict=True):
        found = run.displacement(at) @ [1.0, 1j]
        # The tolerance of the runs, relative to the motion.
        assert np.abs(found - motion).max() < 2e-4 * np.abs(motion).max()


def soft(**options):
    """Elastic shafts with lighter bearings, for runs of every kind of bearing."""
    steel = {"shafts": [dataclasses.replace(s, material=gb.STEEL) for s in pair().shafts]}
    return pair(**{**steel, "gravity": 9.81, **options})


def rolling(x, at):
    return gb.RollingBearing(
        "outer",
        x,
        elements=24,
        element_diameter=0.02,
        pitch_diameter=0.25,
        clearance=-4e-6,
        damping=500.0,
        support=at,
    )


def journal(x, at):
    return gb.JournalBearing(
        "outer", x, diameter=0.2, length=0.05, clearance=2e-4, viscosity=0.05, support=at
    )


def table(x, at):
    speeds = [0.0, 400.0, 1500.0]
    return gb.Bearing(
        "outer",
        x,
        stiffness=gb.SpeedTable(speeds, [1e6, 3e6, 9e6]),
        damping=gb.SpeedTable(speeds, [1e3, 600.0, 300.0]),
        support=at,
    )


@pytest.mark.parametrize("kind", [rolling, journal, table])
@pytest.mark.parametrize("ramp", [False, True])
def test_kinds_agree_by_exponential_and_runge_kutta(kind, ramp):
    system = soft(between=kind)
    speed = gb.SpeedProfile.ramp(300.0, 330.0, 0.01) if ramp else SPEED
    given = {"output_step": 5e-4, "record": ["disks", "bearings", "energy"]}
    one = system.simulate(0.01, speed, method="exponential", rtol=1e-6, **given)
    other = system.simulate(0.01, speed, method="rk45", rtol=1e-7, **given)
    for at in ("fan", "drum"):
        a, b = one.displacement(at), other.displacement(at)
        assert np.abs(a - b).max() < 1e-4 * np.ptp(b, axis=0).max()
    # The rule of the audit, beside the tolerance of the run.
    assert_energy_closes(one, other, share=1e-4)


def test_tables_are_over_the_relative_speed():
    tabulated = soft(between=table).modes(200.0)
    relative = 200.0 * abs(1.0 - RATIO)
    k, c = (gb.SpeedTable([0.0, 400.0, 1500.0], v) for v in ([1e6, 3e6, 9e6], [1e3, 600.0, 300.0]))
    ground = soft(
        bearings=[
            gb.Bearing("inner", 0.0, stiffness=k, damping=c),
            gb.Bearing("inner", 1.0, stiffness=1e7),
            *(gb.Bearing("outer", x, stiffness=1e7) for x in (0.0, 0.5)),
        ]
    )
    # The same table on the ground gives the coefficients at a speed.
    matrices = ground.matrices(relative)
    index = ground.dofs.index(("inner", 0.0, "v"))
    none = gb.Bearing("inner", 0.0, stiffness=0.0)
    with pytest.warns(gb.SceneWarning, match="alone holds"):
        other = ground.replace(bearings=[none, *ground.bearings[1:]])
    stiffness = (matrices.stiffness - other.matrices(relative).stiffness)[index, index]
    damping = (matrices.damping - other.matrices(relative).damping)[index, index]
    constant = soft(
        between=lambda x, at: gb.Bearing(
            "outer", x, stiffness=float(stiffness), damping=float(damping), support=at
        )
    ).modes(200.0)
    np.testing.assert_allclose(tabulated.eigenvalues, constant.eigenvalues, rtol=1e-9)


def test_a_speed_outside_a_table_names_both_shafts():
    with pytest.raises(gb.SceneError, match='the shaft "outer" relative to "inner"'):
        soft(between=table).modes(900.0)


def test_film_between_shafts_has_the_sum_of_their_speeds():
    system = pair(between=journal, gravity=9.81)
    weight = 9.81 * closed_form()[0][0][1, 1] / 2
    ground = journal(0.0, None)
    for ratio in (1.0, 0.5):
        shafts = [system.shafts[0], dataclasses.replace(system.shafts[1], speed_ratio=ratio)]
        static = system.replace(shafts=shafts).static(speed=200.0)
        found = static.journal(("outer", 0.0)).eccentricity_ratio
        wanted = ground.coefficients(weight, 200.0 * (1.0 + ratio)).eccentricity_ratio
        assert found == pytest.approx(wanted, rel=1e-6)
    shafts = [system.shafts[0], dataclasses.replace(system.shafts[1], speed_ratio=-1.0)]
    with pytest.raises(gb.SceneError, match="sum of their speeds is 0"):
        system.replace(shafts=shafts).static(speed=200.0)


def test_elements_pass_with_both_rings():
    system = soft(between=rolling, gravity=0.0)
    gamma = 0.02 / 0.25
    cage = abs((1 - gamma) / 2 * RATIO + (1 + gamma) / 2 * 1.0)
    orders = Kinematics.of(system).orders(bearing_harmonics=1)
    values = {name: order.value for order in orders for name in order.names}
    assert values["1× cage outer@0"] == pytest.approx(cage)
    assert values["1× ball pass outer@0"] == pytest.approx(24 * cage)


def test_axial_and_tilting_stiffness_act_between_the_shafts():
    system = pair(
        between=lambda x, at: gb.Bearing(
            "outer", x, stiffness=BETWEEN, axial_stiffness=1e6, tilting_stiffness=2e4, support=at
        ),
        ground=lambda x: gb.Bearing("inner", x, stiffness=GROUND, axial_stiffness=5e5),
    )
    forced = system.replace(forces=[gb.Force("drum", axial=1000.0)]).static()
    assert forced.axial("fan") == pytest.approx(1000.0 / 1e6, rel=1e-4)
    assert forced.axial("drum") == pytest.approx(1000.0 / 1e6 + 1000.0 / 2e6, rel=1e-4)
    _, (m, c, k) = closed_form()
    k = k + 2 * 2e4 * np.array([[1.0, -1.0], [-1.0, 1.0]])
    gyroscopic = 1j * np.imag(c)
    wanted = quadratic(m, gyroscopic, k)
    found = system.modes(SPEED).eigenvalues
    found = np.concatenate([found, found.conj()])
    for value in wanted:
        assert np.abs(found - value).min() < RIGIDITY * abs(value)


def test_files_keep_the_bearing(tmp_path):
    system = soft(between=rolling)
    path = tmp_path / "rotor.toml"
    system.save(path)
    again = gb.RotorSystem.load(path)
    assert (again.shafts, again.bearings) == (system.shafts, system.bearings)
    assert again.bearings[2].support == ("inner", 0.25)
    assert again.shafts[1].speed_ratio == RATIO


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            {"support": ("outer", 0.25)},
            "bearings.2..support: is on .outer., the shaft of the bearing",
        ),
        ({"support": ("middle", 0.25)}, "no shaft is called .middle."),
        ({"support": ("inner", 3.0)}, "bearings.2..support"),
        ({"support": ("inner", 0.3)}, "bearings.3..support: is 0.05"),
        ({"support": ("inner",)}, "must be a name or a tuple"),
        ({"support": "inner"}, "give .shaft, position. for a bearing on another shaft"),
    ],
)
def test_errors_of_places(change, message):
    system = pair()
    wrong = dataclasses.replace(system.bearings[2], **change)
    with pytest.raises(gb.SceneError, match=message):
        system.replace(bearings=[*system.bearings[:2], wrong, system.bearings[3]])


@pytest.mark.parametrize(
    ("index", "ratio", "message"),
    [
        (1, None, "its speed is unknown; .*give speed_ratio="),
        (1, 0.0, "speed_ratio: must not be 0"),
        (0, 2.0, "speed_ratio: is 1 by the meshes and couplings"),
        (1, float("nan"), "speed_ratio: must be finite"),
    ],
)
def test_errors_of_speed_ratios(index, ratio, message):
    shafts = list(pair().shafts)
    shafts[index] = dataclasses.replace(shafts[index], speed_ratio=ratio)
    with pytest.raises(gb.SceneError, match=message):
        pair().replace(shafts=shafts)


def test_torques_of_each_spool_balance():
    torques = [
        gb.Torque("fan", 50.0),
        gb.Torque.balance(("inner", 0.0)),
        gb.Torque("drum", 20.0),
        gb.Torque.balance(("outer", 0.0)),
    ]
    static = soft(torques=torques).static()
    assert abs(static.twist("fan")) < 1.0
    with pytest.raises(gb.SceneError, match="balancing torque too"):
        soft(torques=[gb.Torque.balance("fan"), gb.Torque.balance(("inner", 0.0))])


def coaxial(speed_ratio=1.0):
    """The coaxial rotor of the package ROSS."""
    steel = gb.Material(211e9, 7810.0, shear_modulus=81.2e9)
    inner = (32.58972765304033, 0.17808928257067666, 0.32956362089137037)
    outer = (81.7534142969549, 1.4150153457897943, 2.7632654032370754)
    pedestal = gb.Support(mass=20.0, stiffness=1e8)
    return gb.RotorSystem(
        shafts=[
            gb.Shaft("inner", length=2.5, outer_diameter=0.05, elements=10, material=steel),
            gb.Shaft(
                "outer",
                length=1.5,
                outer_diameter=0.3,
                inner_diameter=0.25,
                elements=6,
                material=steel,
                speed_ratio=speed_ratio,
            ),
        ],
        disks=[
            gb.Disk("fan", "inner", 0.25, *inner),
            gb.Disk("turbine", "inner", 2.25, *inner),
            gb.Disk("compressor", "outer", 0.5, *outer),
            gb.Disk("drum", "outer", 1.0, *outer),
        ],
        bearings=[
            gb.Bearing("inner", 0.0, stiffness=1e6, support=pedestal),
            gb.Bearing("inner", 2.5, stiffness=1e6, support=pedestal),
            gb.Bearing("outer", 0.0, stiffness=1e6),
            gb.Bearing("inner", 2.0, stiffness=1e6, support=("outer", 1.5)),
        ],
    )


#: Frequencies of ROSS 2.3.0 [rad/s], `coaxrotor_example().run_modal(speed).wn`, by the speed of both shafts [rad/s].
ROSS = {
    0.0: [
        39.05334063,
        39.05334063,
        98.63132175,
        98.63132175,
        129.42581573,
        129.42581573,
        215.11918018,
        215.11918018,
        281.78489839,
        281.78489839,
    ],
    500.0: [
        33.07480923,
        43.56876718,
        82.24727589,
        111.41689385,
        118.27503593,
        153.48045352,
        210.03678815,
        226.48863615,
        264.47395282,
        297.84926214,
    ],
}


@pytest.mark.parametrize("speed", ROSS)
@pytest.mark.filterwarnings("ignore::gearbow.SceneWarning")
def test_modes_of_the_coaxial_rotor_of_ross(speed):
    found = np.sort(np.abs(coaxial().modes(speed).eigenvalues.imag))[:10]
    # ROSS prints eight decimals.
    np.testing.assert_allclose(found, ROSS[speed], rtol=1e-8)


def test_sag_of_a_shaft_on_bearings_of_another():
    bow = gb.Bow.sag(1e-4)
    shafts = [pair().shafts[0], dataclasses.replace(pair().shafts[1], bow=bow, material=gb.STEEL)]
    alone = [gb.Bearing("outer", x, stiffness=1e8) for x in (0.0, 0.5)]
    rotor = gb.RotorSystem(
        [dataclasses.replace(shafts[1], speed_ratio=None)],
        disks=[dataclasses.replace(pair().disks[1])],
        bearings=alone,
    )

    def turned(x, at):
        return gb.Bearing("inner", at[1], stiffness=BETWEEN, support=("outer", x))

    both = pair(between=turned, shafts=shafts)
    slow = [
        each.synchronous([1e-3], excitation="bow").displacement("drum")[0, -1, 0]
        for each in (rotor, both)
    ]
    assert slow[0] == pytest.approx(slow[1], rel=1e-6)


def test_the_drawing_has_the_bearing_without_ground():
    figure = pair().plot()
    assert "support" not in {text.get_text() for text in figure.legends[0].get_texts()}
