"""Axial motion of supports and housings, and axial velocities and accelerations: closed forms, runs, files."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gearbow as gb
from reference.comparisons import assert_modes_of_speeds

MASS, BASE_MASS = 12.0, 5.0
BEARING, BASE = (4e6, 300.0), (3e6, 500.0)
THRUST = 800.0
METHODS: dict[str, dict[str, Any]] = {
    "exponential": {"method": "exponential", "rtol": 1e-10},
    "etdrk4": {"method": "etdrk4", "step": 1e-5},
    "rk45": {"method": "rk45", "rtol": 1e-11},
    "rk4": {"method": "rk4", "step": 2.5e-7},
}
# A light shaft: its axial stiffness is 1e4 times that of the bearing.
pytestmark = pytest.mark.implausible


def rotor(*, damped: bool = True, force: float = THRUST, **changes: Any) -> gb.RotorSystem:
    """Return a rigid rotor whose thrust bearing stands on a support that moves along the axis."""
    bearing, base = ([k, c if damped else 0.0] for k, c in (BEARING, BASE))
    material = gb.Material(youngs_modulus=2e11, density=1.0, poisson_ratio=0.3)
    parts: dict[str, Any] = {
        "shafts": [
            gb.Shaft("rotor", length=0.1, outer_diameter=0.2, elements=1, material=material)
        ],
        "disks": [gb.Disk("disk", "rotor", 0.0, MASS, 0.1, 0.2)],
        "supports": [
            gb.Support(
                "pedestal",
                mass=BASE_MASS,
                stiffness=1e8,
                damping=1e3,
                axial_stiffness=base[0],
                axial_damping=base[1],
            )
        ],
        "bearings": [
            gb.Bearing(
                "rotor",
                0.0,
                stiffness=1e8,
                damping=1e3,
                axial_stiffness=bearing[0],
                axial_damping=bearing[1],
                support="pedestal",
            ),
            gb.Bearing("rotor", 0.1, stiffness=1e8, damping=1e3),
        ],
        "forces": [gb.Force("disk", axial=force)],
    }
    return gb.RotorSystem(**{**parts, **changes})


def chain(damped: bool = True) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return mass, damping and stiffness of two masses on two springs in series."""
    mass = np.diag([MASS, BASE_MASS])
    (k, c), (base_k, base_c) = BEARING, BASE
    stiffness = np.array([[k, -k], [-k, k + base_k]])
    damping = np.array([[c, -c], [-c, c + base_c]]) * damped
    return mass, damping, stiffness


def of_chain(time: np.ndarray, damped: bool = True) -> np.ndarray:
    """Return (u, u̇, ü) of both masses over time after a sudden thrust, shape (3, k, 2)."""
    mass, damping, stiffness = chain(damped)
    inverse = np.linalg.inv(mass)
    matrix = np.block([[np.zeros((2, 2)), np.eye(2)], [-inverse @ stiffness, -inverse @ damping]])
    rest = np.concatenate([np.linalg.solve(stiffness, [THRUST, 0.0]), np.zeros(2)])
    values, vectors = np.linalg.eig(matrix)
    weights = np.linalg.solve(vectors, -rest)
    turned = np.exp(np.outer(time, values)) * weights
    state = (turned @ vectors.T).real + rest
    rates = ((turned * values) @ vectors.T).real
    return np.array([state[:, :2], rates[:, :2], rates[:, 2:]])


def index(system: gb.RotorSystem, name: str, position: float = 0.0) -> int:
    return system.dofs.index((name, position, "u"))


def test_matrices_are_those_of_two_springs_in_series():
    system = rotor()
    found, places = system.matrices(), [index(system, "rotor"), index(system, "pedestal")]
    block = np.ix_(places, places)
    _, damping, stiffness = chain()
    # the axial stiffness of the shaft element
    own = 2e11 * np.pi * 0.1**2 / 0.1
    expected = stiffness + np.diag([own, 0.0])
    np.testing.assert_allclose(found.stiffness[block], expected, rtol=1e-12)
    np.testing.assert_allclose(found.damping[block], damping, rtol=1e-12)
    assert found.mass[places[1], places[1]] == BASE_MASS
    np.testing.assert_array_equal(found.gyroscopic[places], 0.0)
    sparse = system.matrices(sparse=True)
    np.testing.assert_allclose(sparse.stiffness.toarray(), found.stiffness, rtol=1e-12)


def test_static_displacements_are_those_of_springs_in_series():
    static = rotor().static()
    (bearing, _), (base, _) = BEARING, BASE
    assert static.axial("pedestal") == pytest.approx(THRUST / base, rel=1e-12)
    assert static.axial("disk") == pytest.approx(THRUST / base + THRUST / bearing, rel=1e-9)
    assert static.axial_bearing_force(("rotor", 0.0)) == pytest.approx(THRUST, rel=1e-12)


def test_two_masses_on_springs_in_series_have_two_axial_modes():
    system = rotor(damped=False)
    mass, _, stiffness = chain()
    expected = np.sqrt(np.linalg.eigvals(np.linalg.solve(mass, stiffness)).real)
    for modes in (system.modes(), system.modes(200.0), system.modes(count=8)):
        axial = np.array([kind == "axial" for kind in modes.whirl])
        found = 2.0 * np.pi * modes.frequencies_hz[axial]
        # the mass (3e-4) and the compliance of the shaft
        np.testing.assert_allclose(found[:2], np.sort(expected), rtol=5e-4)


def test_a_light_support_and_its_bearing_are_springs_in_series():
    bearing, base = BEARING[0], BASE[0]
    light = gb.Support("pedestal", mass=1e-4, stiffness=1e8, axial_stiffness=base)
    series = 1.0 / (1.0 / bearing + 1.0 / base)
    rigid = [
        gb.Bearing("rotor", 0.0, stiffness=1e8, axial_stiffness=series),
        gb.Bearing("rotor", 0.1, stiffness=1e8),
    ]
    found, expected = (
        min(f for f, kind in zip(m.frequencies_hz, m.whirl, strict=True) if kind == "axial")
        for m in (
            rotor(damped=False, supports=[light]).modes(),
            rotor(supports=[], bearings=rigid).modes(),
        )
    )
    # the mass of the support is 1e-5 of that of the rotor
    assert found == pytest.approx(expected, rel=1e-5)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("damped", [True, False], ids=["damped", "undamped"])
def test_every_method_gives_the_exact_motion_and_its_rates(method: str, damped: bool):
    run = rotor(damped=damped).simulate(
        0.02,
        speed=100.0,
        initial="rest",
        output_step=2e-4,
        record=[
            "disk",
            "housings",
            "velocity",
            "acceleration",
            "energy",
            ("bearing", "rotor", 0.0),
        ],
        **METHODS[method],
    )
    expected = of_chain(run.time, damped)
    for number, name in enumerate(("disk", "pedestal")):
        signals = run.axial(name), run.axial_velocity(name), run.axial_acceleration(name)
        for found, exact in zip(signals, expected[:, :, number], strict=True):
            # The shaft has 3e-4 of the mass of the disk, which shifts the phase by 1.5e-4 times
            # the highest frequency times the duration, 20 rad.
            assert np.abs(found - exact).max() < 5e-3 * np.abs(exact).max()
    relative = [run.axial("disk") - run.axial("pedestal")]
    relative.append(run.axial_velocity("disk") - run.axial_velocity("pedestal"))
    force = BEARING[0] * relative[0] + BEARING[1] * damped * relative[1]
    np.testing.assert_allclose(run.axial_bearing_force(("rotor", 0.0)), force, rtol=1e-9, atol=1e-6)
    # the quadrature of the powers within a step
    assert np.abs(run.energy_balance().residual).max() < 1e-6 * np.abs(run.energy).max()


def test_rates_satisfy_the_equation_of_motion():
    run = rotor().simulate(
        0.01, 100.0, initial="rest", record=["disk", "pedestal", "velocity", "acceleration"]
    )
    (k, c), (base_k, base_c) = BEARING, BASE
    force = k * (run.axial("disk") - run.axial("pedestal"))
    force += c * (run.axial_velocity("disk") - run.axial_velocity("pedestal"))
    inertia = BASE_MASS * run.axial_acceleration("pedestal")
    mount = base_k * run.axial("pedestal") + base_c * run.axial_velocity("pedestal")
    # Both sides are those of one state. The stiffness of the shaft, 1.5e4 times that of the bearing,
    # magnifies round-off.
    np.testing.assert_allclose(inertia, force - mount, rtol=0.0, atol=1e-7 * np.abs(force).max())


def test_a_support_without_axial_stiffness_does_not_move_along_the_axis():
    fixed = gb.Support("pedestal", mass=BASE_MASS, stiffness=1e8, damping=1e3)
    system = rotor(supports=[fixed])
    assert ("pedestal", 0.0, "u") not in system.dofs
    static = system.static()
    assert static.axial("disk") == pytest.approx(THRUST / BEARING[0], rel=1e-9)
    with pytest.raises(gb.GearbowError, match="has no axial motion"):
        static.axial("pedestal")
    run = system.simulate(1e-3, 100.0, record=["pedestal"])
    np.testing.assert_array_equal(run.axial("pedestal"), 0.0)


def test_a_system_without_axial_motion_has_the_same_results():
    system = rotor(
        forces=[],
        bearings=[
            gb.Bearing("rotor", x, stiffness=1e8, damping=1e3, support="pedestal")
            for x in (0.0, 0.1)
        ],
        disks=[gb.Disk("disk", "rotor", 0.0, MASS, 0.1, 0.2, unbalance=1e-4)],
    )
    plain = system.replace(supports=[gb.Support("pedestal", mass=BASE_MASS, stiffness=1e8,
                                                damping=1e3)])  # fmt: skip
    assert system.dofs == plain.dofs
    first, second = (s.simulate(5e-3, 200.0, record=["disk"]) for s in (system, plain))
    np.testing.assert_array_equal(first.displacement("disk"), second.displacement("disk"))


HOUSING = gb.Housing(
    "box",
    mass=20.0,
    stiffness=2e8,
    damping=2e3,
    axial_stiffness=6e6,
    axial_damping=900.0,
    inertia=(0.5, 0.6, 0.7),
    position=(0.05, 0.02, -0.1),
    rotational_stiffness=(3e5, 4e5, 5e5),
    rotational_damping=(20.0, 30.0, 40.0),
    points={"sensor": (0.2, 0.15, 0.05)},
)


def on_housing(**changes: Any) -> gb.RotorSystem:
    bearings = [
        gb.Bearing(
            "rotor",
            x,
            stiffness=1e8,
            damping=1e3,
            axial_stiffness=k,
            axial_damping=10.0,
            support="box",
        )
        for x, k in ((0.0, BEARING[0]), (0.1, 0.0))
    ]
    parts: dict[str, Any] = {"supports": [], "housings": [HOUSING], "bearings": bearings}
    return rotor(**{**parts, **changes})


def test_a_housing_moves_and_turns_under_the_thrust():
    system = on_housing()
    static = system.static()
    assert static.axial("box") == pytest.approx(THRUST / HOUSING.axial_stiffness, rel=1e-9)
    state = {
        kind: static.state[i] for i, (name, _, kind) in enumerate(system.dofs) if name == "box"
    }
    _, y, z = np.subtract(HOUSING.points["sensor"], HOUSING.position)
    expected = state["u"] + state["B"] * z - state["G"] * y
    assert static.axial("sensor") == pytest.approx(expected, rel=1e-12)
    # the thrust acts at the distance 0.1 m above the centre of mass along z
    assert state["B"] == pytest.approx(THRUST * 0.1 / HOUSING.rotational_stiffness[1], rel=0.05)


def test_a_point_of_a_housing_has_the_motion_of_the_rigid_body():
    run = on_housing().simulate(
        0.01,
        100.0,
        initial="rest",
        output_step=1e-4,
        record=["box", "sensor", "velocity", "acceleration"],
        method="exponential",
        rtol=1e-10,
    )
    fixed = on_housing(housings=[HOUSING.__class__(**{**vars(HOUSING), "axial_stiffness": None,
                                                      "axial_damping": 0.0})])  # fmt: skip
    turning = fixed.simulate(
        0.01, 100.0, initial="rest", output_step=1e-4, record=["box", "sensor"]
    )
    np.testing.assert_array_equal(turning.axial("box"), 0.0)
    # The thrust turns the housing, so that the point moves along the axis.
    assert np.abs(turning.axial("sensor")).max() > 1e-6
    for name in ("box", "sensor"):
        slope = np.gradient(run.axial(name), run.time, edge_order=2)[1:-1]
        found = run.axial_velocity(name)[1:-1]
        # differences of second order at 1e-4 s
        assert np.abs(slope - found).max() < 2e-2 * np.abs(found).max()
        slope = np.gradient(run.axial_velocity(name), run.time, edge_order=2)[1:-1]
        found = run.axial_acceleration(name)[1:-1]
        assert np.abs(slope - found).max() < 4e-2 * np.abs(found).max()


def test_analyses_over_the_speed():
    system = on_housing(disks=[gb.Disk("disk", "rotor", 0.0, MASS, 0.1, 0.2, unbalance=1e-4)])
    speeds = np.linspace(50.0, 400.0, 4)
    diagram = system.campbell(speeds, count=6)
    assert_modes_of_speeds(system, diagram, (0, 3), 1e-8)
    amplitude = system.synchronous([150.0])
    run = system.simulate(0.01, 150.0, initial="synchronous", record=["disk", "box"])
    turning = np.exp(150j * run.time)[:, None]
    for name in ("disk", "box"):
        motion = amplitude.displacement(name)[0, 0]
        expected = system.static().displacement(name) + (motion * turning).real
        # the integrated motion stays on the stationary one
        np.testing.assert_allclose(
            run.displacement(name), expected, rtol=0.0, atol=1e-6 * np.abs(motion).max()
        )
    assert system.critical_speed_map(np.geomspace(1e6, 1e8, 3)).speeds


def test_files_checkpoints_tables_and_sensors(tmp_path: Path):
    system = on_housing()
    system.save(tmp_path / "scene.toml")
    assert gb.RotorSystem.load(tmp_path / "scene.toml").description == system.description
    assert gb.RotorSystem.from_dict(system.description).housings == (HOUSING,)
    record = ["disk", "sensor", "velocity", "acceleration"]
    run = system.simulate(5e-3, 100.0, initial="rest", record=record)
    run.save(tmp_path / "run.npz")
    back = gb.Response.load(tmp_path / "run.npz")
    for name in ("disk", "sensor"):
        np.testing.assert_array_equal(back.axial_velocity(name), run.axial_velocity(name))
        np.testing.assert_array_equal(back.axial_acceleration(name), run.axial_acceleration(name))
    table = run.to_dataframe()
    np.testing.assert_array_equal(table["sensor velocity_x [m/s]"], run.axial_velocity("sensor"))
    assert run.to_xarray()["axial_acceleration"].attrs["units"] == "m/s²"
    assert run.spectrum("sensor", "acceleration_x").unit == "m/s²"
    sensor = gb.Accelerometer("sensor", axial=True)
    assert sensor.label == "accelerometer sensor, axial"
    np.testing.assert_array_equal(run.measure(sensor), run.axial_acceleration("sensor"))
    with pytest.raises(
        gb.SceneError, match=r"accelerometer\.angle: an axial accelerometer has none"
    ):
        gb.Accelerometer("sensor", angle=0.1, axial=True)
    probed = system.simulate(5e-3, 100.0, initial="rest", record=[("rotor", 0.0), "sensor"])
    probe = gb.Probe("rotor", 0.0, support="sensor", axial=True)
    relative = probed.axial(("rotor", 0.0)) - probed.axial("sensor")
    np.testing.assert_allclose(probed.measure(probe), relative, rtol=1e-12)
    with pytest.raises(gb.ChannelError, match="axial velocity of 'disk' was not recorded"):
        system.simulate(1e-3, 100.0, record=["disk"]).axial_velocity("disk")


def test_a_reduced_run_of_helical_gears_in_an_elastic_casing():
    helix = 0.35
    gears = [
        gb.Gear(name, shaft, 0.15, z, module=3e-3, face_width=0.03, helix_angle=angle)
        for name, shaft, z, angle in (("g1", "input", 25, helix), ("g2", "output", 50, -helix))
    ]
    base = gb.Housing("box", mass=40.0, stiffness=3e8, damping=2e4, axial_stiffness=1e8,
                      axial_damping=1e4)  # fmt: skip
    system = gb.RotorSystem(
        [gb.Shaft(name, length=0.4, outer_diameter=0.05) for name in ("input", "output")],
        gears,
        [gb.Mesh("g1", "g2", stiffness=gb.Stiffness.parabolic(3e8), damping_ratio=0.05)],
        [
            gb.Bearing(s, x, stiffness=1e8, damping=1e3, axial_stiffness=5e7 * (x == 0.0),
                       axial_damping=1e3 * (x == 0.0), support="box")
            for s in ("input", "output")
            for x in (0.0, 0.4)
        ],
        [gb.Torque("g1", 200.0), gb.Torque.balance("g2")],
        housings=[base],
    )  # fmt: skip
    # The thrusts of both shafts cancel in the housing.
    assert abs(system.static().axial("box")) < 1e-9 * abs(system.static().axial("g1"))
    options = {"initial": "rest", "output_step": 1e-4, "record": ["box", "gears"]}
    draft = system.simulate(0.02, 150.0, **options)
    fine = system.simulate(0.02, 150.0, method="exponential", rtol=1e-8, **options)
    for name in ("g1", "g2"):
        signal = fine.axial(name)
        # the promise of "engineering" for displacements, 1e-3 of the variation, and a factor of 10
        # because it is given for lateral displacements
        assert np.abs(draft.axial(name) - signal).std() < 1e-2 * signal.std()


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"axial_stiffness": -1.0}, r"supports\[0\].axial_stiffness: must not be negative, got -1"),
        ({"axial_stiffness": np.nan}, r"supports\[0\].axial_stiffness: must be finite, got nan"),
        ({"axial_stiffness": None}, r"supports\[0\].axial_damping: .* needs axial_stiffness"),
        ({"axial_damping": -1.0}, r"supports\[0\].axial_damping: must not be negative, got -1"),
    ],
)
def test_invalid_axial_coefficients(changes: dict[str, Any], message: str):
    given = {"axial_stiffness": 1e6, "axial_damping": 10.0, **changes}
    with pytest.raises(gb.SceneError, match=message):
        rotor(supports=[gb.Support("pedestal", mass=1.0, stiffness=1e8, **given)])


def test_a_support_that_nothing_holds_along_the_axis_is_named():
    free = gb.Support("pedestal", mass=1.0, stiffness=1e8, axial_stiffness=0.0)
    message = 'the load moves "pedestal"; give it a positive axial_stiffness'
    with pytest.raises(gb.SceneError, match=message):
        rotor(supports=[free]).static()
    assert "rigid" in rotor(supports=[free], damped=False, forces=[]).modes().whirl
