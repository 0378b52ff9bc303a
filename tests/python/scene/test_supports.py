"""Supports and housings under bearings: closed forms, an independent assembly, runs and errors."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import gearbow as gb
from reference import film
from reference.attached import Attached, RigidBody
from reference.cases import each_case
from reference.comparisons import assert_matrices, assert_modes_of_speeds
from reference.elements import Section
from reference.scenes import DENSITY, E, G, single_shaft
from reference.train import RigidSpec, ShaftPart, ShaftSpec, Train

LENGTH, DIAMETER, ELEMENTS, SPEED = 0.8, 0.03, 4, 250.0
STIFFNESS = np.array([[3e6, 4e5], [-2e5, 5e6]])
DAMPING = np.array([[600.0, 20.0], [20.0, 400.0]])
DISK = {"mass": 6.0, "diametral_inertia": 0.02, "polar_inertia": 0.035}
UNBALANCE = 2e-4 + 1e-4j
GRAVITY = (1.0, -9.0)
HOUSING = gb.Housing(
    "box",
    mass=25.0,
    stiffness=[[8e6, 1e6], [1e6, 6e6]],
    damping=(900.0, 700.0),
    inertia=(0.4, 0.7, 0.9),
    position=(0.3, 0.05, -0.1),
    rotational_stiffness=(2e5, 9e5, 7e5),
    rotational_damping=(30.0, 20.0, 10.0),
    points={"sensor": (0.7, 0.2, 0.15)},
)
RUN: dict[str, Any] = {"initial": "rest", "output_step": 1e-3}


def rotor(support: str | gb.Support | None, **more: Any) -> gb.RotorSystem:
    return single_shaft(
        length=LENGTH,
        diameter=DIAMETER,
        elements=ELEMENTS,
        density=DENSITY,
        support=None,
        disks=[gb.Disk("wheel", "s", 0.6, **DISK, unbalance=UNBALANCE)],
        bearings=[
            gb.Bearing("s", x, stiffness=STIFFNESS, damping=DAMPING, support=support)
            for x in (0.0, LENGTH)
        ],
        motion="coupled",
        gravity=GRAVITY,
        **more,
    )


def train() -> Train:
    """Return the rotor without bearings."""
    part = ShaftPart(LENGTH, Section(DIAMETER, E, G, DENSITY), ELEMENTS)
    wheel = RigidSpec(
        "wheel", "s", 0.6, DISK["mass"], DISK["diametral_inertia"], DISK["polar_inertia"], UNBALANCE
    )
    return Train([ShaftSpec("s", [part])], rigid=[wheel], gravity=GRAVITY)


def on_housing() -> tuple[gb.RotorSystem, Attached]:
    reference = Attached(train(), RigidBody(HOUSING.mass, HOUSING.inertia))
    centre = np.array(HOUSING.position)
    for x in (0.0, LENGTH):
        arm = tuple(np.array([x, 0.0, 0.0]) - centre)
        rows = reference.node("s", x) - reference.point(0, arm)
        reference.spring(rows, STIFFNESS, DAMPING)
    reference.spring(reference.point(0), HOUSING.stiffness, np.diag(HOUSING.damping))
    rotational = [HOUSING.rotational_stiffness, HOUSING.rotational_damping]
    reference.spring(reference.rotations(0), *(np.diag(given) for given in rotational))
    return rotor("box", housings=[HOUSING]), reference


def on_supports() -> tuple[gb.RotorSystem, Attached]:
    """Return a rotor with a shared support at the left end and an own support at the right."""
    first = gb.Support("first", mass=3.0, stiffness=(4e6, 2e6), damping=150.0)
    own = gb.Support("second", mass=2.0, stiffness=5e6)
    system = rotor("first", supports=[first])
    bearings = [system.bearings[0], replace(system.bearings[1], support=own)]
    reference = Attached(train(), RigidBody(3.0), RigidBody(2.0))
    for body, x in enumerate((0.0, LENGTH)):
        rows = reference.node("s", x) - reference.point(body)
        reference.spring(rows, STIFFNESS, DAMPING)
    reference.spring(reference.point(0), np.diag([4e6, 2e6]), 150.0)
    reference.spring(reference.point(1), 5e6)
    return system.replace(bearings=bearings), reference


def on_supports_of_a_housing() -> tuple[gb.RotorSystem, Attached]:
    """Return the rotor on a listed and an own support, both of which stand on the housing."""
    first = gb.Support("first", mass=3.0, stiffness=(4e6, 2e6), damping=150.0, support="box")
    own = gb.Support("second", mass=2.0, stiffness=5e6, support="box")
    system = rotor("box", housings=[HOUSING])
    bases = zip(system.bearings, ["first", own], strict=True)
    bearings = [replace(bearing, support=base) for bearing, base in bases]
    reference = Attached(
        train(), RigidBody(3.0), RigidBody(HOUSING.mass, HOUSING.inertia), RigidBody(2.0)
    )
    centre = np.array(HOUSING.position)
    mounts = [(0, 0.0, np.diag([4e6, 2e6]), 150.0), (2, LENGTH, 5e6 * np.eye(2), 0.0)]
    for body, x, stiffness, damping in mounts:
        reference.spring(reference.node("s", x) - reference.point(body), STIFFNESS, DAMPING)
        arm = tuple(np.array([x, 0.0, 0.0]) - centre)
        reference.spring(reference.point(body) - reference.point(1, arm), stiffness, damping)
    reference.spring(reference.point(1), HOUSING.stiffness, np.diag(HOUSING.damping))
    rotational = [HOUSING.rotational_stiffness, HOUSING.rotational_damping]
    reference.spring(reference.rotations(1), *(np.diag(given) for given in rotational))
    return system.replace(bearings=bearings, supports=[first]), reference


CASES = pytest.mark.parametrize("make", [on_housing, on_supports, on_supports_of_a_housing])


@CASES
def test_matrices_are_those_of_the_independent_assembly(make: Any):
    assert_matrices(*make())


@CASES
def test_the_static_equilibrium_includes_the_weight_of_what_bearings_stand_on(make: Any):
    system, reference = make()
    kept = np.array([direction != "twist" or name != "s" for name, _, direction in system.dofs])
    q = np.zeros(reference.size)
    q[kept] = np.linalg.solve(reference.stiffness[np.ix_(kept, kept)], reference.steady[kept])
    found = system.static().displacement("wheel")
    np.testing.assert_allclose(found, reference.node("s", 0.6) @ q, rtol=1e-9)


@CASES
def test_a_few_modes_are_those_of_all_and_of_the_independent_assembly(make: Any):
    system, reference = make()
    n = reference.size
    rates = reference.damping + SPEED * reference.gyroscopic
    inverse = np.linalg.inv(reference.mass)
    state = np.block(
        [[np.zeros((n, n)), np.eye(n)], [-inverse @ reference.stiffness, -inverse @ rates]]
    )
    values = np.linalg.eigvals(state)
    modes = system.modes(SPEED)
    for mode in modes.eigenvalues[2:12]:
        # the conditioning of the unscaled state matrix
        assert np.abs(values - mode).min() < 1e-7 * abs(mode)
    few = system.modes(SPEED, count=10)
    np.testing.assert_allclose(few.frequencies_hz[1:], modes.frequencies_hz[1:10], rtol=1e-8)


# Cross-coupled stiffness makes one of the scenes unstable; its linear response is exact all the same.
@pytest.mark.filterwarnings("ignore:speeds. the motion is unstable:gearbow.AccuracyWarning")
@CASES
def test_synchronous_response_and_bearing_force(make: Any):
    system, reference = make()
    answer, expected = system.synchronous([SPEED]), reference.synchronous(SPEED)
    wheel = reference.node("s", 0.6) @ expected
    np.testing.assert_allclose(answer.displacement("wheel")[0].sum(axis=0), wheel, rtol=1e-9)
    name = "box" if make is on_housing else "second"
    found = answer.displacement(name)[0].sum(axis=0)
    np.testing.assert_allclose(found, reference.point(-1 + len(reference.bodies)) @ expected,
                               rtol=1e-9)  # fmt: skip


@CASES
@pytest.mark.parametrize(
    "options",
    [
        {"method": "exponential", "rtol": 1e-9},
        {"method": "rk45", "rtol": 1e-10},
        {"method": "rk4", "step": 5e-6},
        {"method": "etdrk4", "step": 1e-4},
    ],
    ids=lambda options: options["method"],
)
def test_every_method_gives_the_exact_motion(make: Any, options: dict[str, Any]):
    system, reference = make()
    record = ["wheel", "housings", "energy", ("bearing", "s", LENGTH)]
    run = system.simulate(0.02, SPEED, record=record, **RUN, **options)
    zero = np.zeros(reference.size)
    q, v = reference.linear(SPEED).motion(run.time, zero, zero)
    wheel = q @ reference.node("s", 0.6).T
    # the tolerance of the explicit methods
    tolerance = {"rtol": 0.0, "atol": 1e-7 * np.abs(wheel).max()}
    np.testing.assert_allclose(run.displacement("wheel"), wheel, **tolerance)
    if make is on_housing:
        arm = tuple(np.array(HOUSING.points["sensor"]) - HOUSING.position)
        rows, base = reference.point(0, arm), reference.point(0, (LENGTH - 0.3, -0.05, 0.1))
        np.testing.assert_allclose(run.displacement("sensor"), q @ rows.T, **tolerance)
    else:
        base = reference.point(-1 + len(reference.bodies))
        np.testing.assert_allclose(run.displacement("second"), q @ base.T, **tolerance)
    relative = reference.node("s", LENGTH) - base
    force = q @ relative.T @ STIFFNESS.T + v @ relative.T @ DAMPING.T
    scale = 1e-6 * np.abs(force).max()
    np.testing.assert_allclose(run.bearing_force(("s", LENGTH)), force, rtol=0.0, atol=scale)
    # the quadrature of the powers within a step
    assert np.abs(run.energy_balance().residual).max() < 1e-6 * run.energy.max()


def test_a_table_bearing_on_a_housing_has_the_motion_of_the_constant_one():
    system, _ = on_housing()
    table = gb.SpeedTable([0.0, 400.0], [STIFFNESS, STIFFNESS])
    bearings = [replace(bearing, stiffness=table) for bearing in system.bearings]
    changing = system.replace(bearings=bearings)
    ramp = gb.SpeedProfile.ramp(150.0, 250.0, 0.02)
    for method, rtol in (("exponential", 1e-9), ("rk45", 1e-10)):
        options = {"method": method, "rtol": rtol, "record": ["wheel", "box", "energy"], **RUN}
        first, second = (s.simulate(0.02, ramp, **options) for s in (system, changing))
        for name in ("wheel", "box"):
            # two tolerances of 1e-9
            np.testing.assert_allclose(
                first.displacement(name), second.displacement(name), rtol=0.0, atol=1e-11
            )
        assert np.abs(second.energy_balance().residual).max() < 1e-7 * second.energy.max()


def test_a_light_support_has_the_stiffness_of_two_springs_in_series():
    bearing, base = 4e6, 6e6
    on_support = gb.Support(mass=1e-3, stiffness=base)
    systems = [
        single_shaft(
            support=None,
            density=DENSITY,
            bearings=[gb.Bearing("s", x, stiffness=k, support=support) for x in (0.0, 1.0)],
            gravity=9.81,
        )
        for k, support in ((bearing, on_support), (1 / (1 / bearing + 1 / base), None))
    ]
    found, expected = (s.modes().frequencies_hz[:4] for s in systems)
    # The mass of the support lowers the frequency by its share of the mass of the rotor, 1e-4.
    np.testing.assert_allclose(found, expected, rtol=2e-4)
    sag = [s.static().displacement(("s", 0.5))[1] for s in systems]
    # The weight of the support adds its share.
    np.testing.assert_allclose(sag[0], sag[1], rtol=1e-3)


@pytest.mark.implausible
def test_a_rigid_rotor_on_supports_has_two_modes_in_each_plane():
    rotor_mass, bearing, mass, base = 10.0, 2e6, 4.0, 3e6
    shaft = {"length": 0.2, "diameter": 0.2, "density": 10.0}
    support = gb.Support("pedestal", mass=mass, stiffness=base)
    wheel = rotor_mass - 10.0 * np.pi / 4 * 0.2**3
    system = single_shaft(
        support=None,
        elements=2,
        **shaft,
        disks=[gb.Disk("wheel", "s", 0.1, wheel, 1.0, 1.0)],
        bearings=[
            gb.Bearing("s", x, stiffness=bearing / 2, support="pedestal") for x in (0.0, 0.2)
        ],
        supports=[support],
    )
    # m M ω⁴ - (m (k + K) + M k) ω² + k K = 0
    squares = np.roots(
        [rotor_mass * mass, -(rotor_mass * (bearing + base) + mass * bearing), bearing * base]
    )
    expected = np.sort(np.sqrt(squares)) / (2.0 * np.pi)
    found = system.modes().frequencies_hz
    for value in expected:
        # the shaft has 2e-5 of the compliance; the tilting modes lie elsewhere
        assert np.sum(np.abs(found / value - 1.0) < 1e-4) == 2


def test_the_arms_follow_the_centres_of_meshing_shafts():
    # The roll of the housing leaves the teeth alone: a couple of mesh force and bearing forces.
    gears = [gb.Gear(n, s, 0.1, teeth=20, module=3e-3, face_width=0.02) for n, s in ("ga", "hb")]
    housing = replace(HOUSING, position=(0.1, 0.03, 0.0), points={})
    system = gb.RotorSystem(
        [gb.Shaft(name, length=0.2, outer_diameter=0.04, elements=2) for name in "ab"],
        gears,
        [gb.Mesh("g", "h", stiffness=2e8)],
        [
            gb.Bearing(name, x, stiffness=1e8, support="box")
            for name in "ab"
            for x in (0.0, 0.2)
        ],
        [gb.Torque("g", 50.0), gb.Torque("h", 50.0)],
        housings=[housing],
    )  # fmt: skip
    matrices = system.matrices()
    roll = system.dofs.index(("box", 0.1, "twist"))
    # the centre of mass is in the middle: two bearings at ±30 mm along y each
    expected = 4 * 1e8 * 0.03**2 + housing.rotational_stiffness[0]
    np.testing.assert_allclose(matrices.stiffness[roll, roll], expected, rtol=1e-12)
    # Both torques act from outside, so the mount takes 100 N m about x.
    static = system.static()
    found = static.twist("box")
    # the line of action follows the centres, which move by 1e-4 of their distance
    np.testing.assert_allclose(found, 100.0 / housing.rotational_stiffness[0], rtol=1e-3)


def test_analyses_give_the_motion_of_a_point_that_a_run_records():
    system, _ = on_housing()
    speed = 150.0
    run = system.simulate(
        0.05, speed, initial="synchronous", record=["sensor", "box"], output_step=1e-3
    )
    turning = np.exp(1j * speed * run.time)[:, None]
    for name in ("sensor", "box"):
        amplitude = system.synchronous([speed]).displacement(name)[0, 0]
        expected = system.static().displacement(name) + (amplitude * turning).real
        # the difference of the stationary motion and of one that the run integrates
        np.testing.assert_allclose(
            run.displacement(name), expected, rtol=0, atol=1e-6 * np.abs(amplitude).max()
        )


def test_only_displacements_accept_a_point_of_a_housing():
    system, _ = on_housing()
    synchronous = system.synchronous([100.0])
    with pytest.raises(gb.SceneError, match=r'"sensor" is a point of a housing.*the housing "box"'):
        synchronous.peaks("sensor")
    with pytest.raises(gb.SceneError, match=r'no gear, disk, support or housing.*mean "sensor"\?'):
        system.static().displacement("senser")
    with pytest.raises(gb.GearbowError, match="'box' is no place of a shaft"):
        synchronous.elastic("box")


def test_analyses_over_the_speed_and_files(tmp_path: Any):
    system, _ = on_housing()
    speeds = np.linspace(50.0, 400.0, 8)
    diagram = system.campbell(speeds, count=6)
    assert_modes_of_speeds(system, diagram, (0, 7), 1e-8)
    file = tmp_path / "scene.toml"
    system.save(file)
    assert gb.RotorSystem.load(file).description == system.description
    assert gb.RotorSystem.from_dict(system.description).description == system.description
    run = system.simulate(0.01, SPEED, method="exponential", record=["housings"], **RUN)
    run.save(tmp_path / "run.npz")
    read = gb.Response.load(tmp_path / "run.npz")
    np.testing.assert_array_equal(read.displacement("sensor"), run.displacement("sensor"))
    assert run.recorded == ["box", "sensor"]


def test_chosen_elements_and_reduction_with_a_housing():
    system, _ = on_housing()
    shaft = gb.Shaft("s", length=LENGTH, outer_diameter=DIAMETER)
    chosen = system.replace(shafts=[shaft])
    options = {"initial": "rest", "output_step": 1e-3, "record": ["wheel", "sensor"]}
    draft = chosen.simulate(0.02, SPEED, accuracy="draft", **options)
    fine = chosen.simulate(0.02, SPEED, method="exponential", rtol=1e-9, **options)
    for name in ("wheel", "sensor"):
        signal = fine.displacement(name)
        # the promise of the level: 1e-2 of the variation
        assert np.abs(draft.displacement(name) - signal).std() < 1e-2 * signal.std()


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"support": "bx"}, 'bearings[0].support: no support or housing is called "bx"; did you'),
        ({"support": gb.Support(mass=0.0, stiffness=1e6)}, "bearings[0].support.mass: must be pos"),
        ({"support": gb.Support(mass=1.0, stiffness=-1.0)}, "bearings[0].support.stiffness: must"),
        (
            {"support": 3.0},
            "bearings[0].support: must be a name or a tuple such as (shaft, position), got 3.0",
        ),
    ],
)
def test_an_invalid_support_of_a_bearing(changes: dict[str, Any], message: str):
    system, _ = on_housing()
    bearings = [replace(system.bearings[0], **changes), system.bearings[1]]
    with pytest.raises(gb.SceneError, match="^" + re.escape(message)):
        system.replace(bearings=bearings)


@pytest.mark.parametrize("ruptures", [True, False])
def test_a_run_on_squeeze_films_of_a_housing_is_that_of_an_independent_model(ruptures: bool):
    size = {"diameter": 0.06, "length": 0.02, "clearance": 2e-4, "viscosity": 0.05}
    ring = gb.SqueezeFilm("r", mass=2.0, stiffness=4e6, ruptures=ruptures, support="box", **size)
    plain = rotor("box", housings=[HOUSING])
    supports = [replace(ring, name=None), replace(ring, name="second")]
    bearings = [replace(b, support=s) for b, s in zip(plain.bearings, supports, strict=True)]
    # large enough that the film is squeezed far from its centre
    unbalance = 20.0 * UNBALANCE
    disk = replace(plain.disks[0], unbalance=unbalance)
    system = plain.replace(disks=[disk], bearings=bearings, gravity=None)
    rigid = [replace(train().rigid[0], unbalance=unbalance)]
    reference = Attached(
        replace(train(), rigid=rigid, gravity=(0.0, 0.0)),
        RigidBody(HOUSING.mass, HOUSING.inertia),
        RigidBody(2.0),
        RigidBody(2.0),
    )
    films = []
    for body, x in ((1, 0.0), (2, LENGTH)):
        reference.spring(reference.node("s", x) - reference.point(body), STIFFNESS, DAMPING)
        arm = tuple(np.array([x, 0.0, 0.0]) - HOUSING.position)
        films.append(reference.point(body) - reference.point(0, arm))
        reference.spring(films[-1], 4e6)
    reference.spring(reference.point(0), HOUSING.stiffness, np.diag(HOUSING.damping))
    rotational = [HOUSING.rotational_stiffness, HOUSING.rotational_damping]
    reference.spring(reference.rotations(0), *(np.diag(given) for given in rotational))
    linear, oil = reference.linear(SPEED), film.Bearing(**size)
    inverse, ((_, cosine, sine),) = np.linalg.inv(linear.mass), linear.turning

    def rates(time: float, state: Any) -> Any:
        q, v = np.split(state, 2)
        force = cosine * np.cos(SPEED * time) + sine * np.sin(SPEED * time)
        force -= linear.stiffness @ q + linear.damping @ v
        for rows in films:
            pressed = film.short(oil, rows @ q, rows @ v, 0.0)
            if not ruptures:
                pressed = pressed - film.short(oil, rows @ q, -rows @ v, 0.0)
            force -= rows.T @ pressed
        return np.concatenate([v, inverse @ force])

    options = {"initial": "rest", "output_step": 1e-3, "record": ["housings", "wheel", "energy"]}
    run = system.simulate(0.01, SPEED, method="exponential", rtol=1e-8, **options)
    start = np.zeros(2 * reference.size)
    solved = solve_ivp(rates, (0.0, 0.01), start, "DOP853", run.time, rtol=1e-8, atol=1e-13)
    q = solved.y[: reference.size].T
    moved = q @ films[1].T
    assert 0.2 < np.hypot(*moved.T).max() / size["clearance"] < 0.95
    box, second = run.displacement("box"), run.displacement("second")
    for found, rows in ((box, reference.point(0)), (second, reference.point(2))):
        expected = q @ rows.T
        np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-6 * np.abs(expected).max())
    assert np.abs(run.energy_balance().residual).max() < 1e-6 * run.energy.max()


def test_a_light_support_on_a_stiff_spring_moves_along_and_tilts_with_its_housing():
    box = replace(HOUSING, axial_stiffness=2e6, points={})
    holds = {"axial_stiffness": 3e6, "tilting_stiffness": 4e4}

    def held(support: Any) -> gb.RotorSystem:
        plain = rotor("box", housings=[box]).replace(motion=None, gravity=None)
        first = replace(plain.bearings[0], support=support, **holds)
        thrust = gb.Force("wheel", 100.0 + 50j, axial=200.0)
        return plain.replace(bearings=[first, plain.bearings[1]], forces=[thrust])

    # the spring has 4e-4 of the compliance of the bearing
    between = gb.Support("ring", mass=1e-2, stiffness=1e10, support="box")
    direct, light = held("box"), held(between)
    for name in ("box", "wheel"):
        one, other = (system.static() for system in (direct, light))
        assert one.axial(name) == pytest.approx(other.axial(name), rel=1e-3)
        assert one.displacement(name) == pytest.approx(other.displacement(name), rel=1e-3)
    assert direct.static().axial("box") == pytest.approx(200.0 / 2e6, rel=0.5)
    frequencies = [system.modes(count=10).frequencies_hz for system in (direct, light)]
    assert frequencies[0] == pytest.approx(frequencies[1], rel=1e-3)
    # with a spring along the axis, three are in series
    soft = held(replace(between, axial_stiffness=1e6)).static()
    stretch = soft.axial("ring") - soft.axial("box")
    assert soft.axial("wheel") - direct.static().axial("wheel") == pytest.approx(2e-4, rel=1e-2)
    assert stretch == pytest.approx(2e-4, rel=0.1)


def test_the_ground_moves_below_a_housing_not_below_its_supports():
    system, _ = on_supports_of_a_housing()
    response = system.frequency_response([20.0], source=gb.GroundMotion(1e-3, under=["box"]))
    assert np.abs(response.displacement("second")).max() > 1e-6
    with pytest.raises(
        gb.SceneError, match=r"source.*under\[0\]: nothing there stands on the ground"
    ):
        system.frequency_response([20.0], source=gb.GroundMotion(1e-3, under=["second"]))


def test_a_figure_and_a_file_contain_a_support_on_a_housing(tmp_path: Any):
    system, _ = on_supports_of_a_housing()
    system.save(tmp_path / "scene.toml")
    assert gb.RotorSystem.load(tmp_path / "scene.toml").description == system.description
    axes = system.plot()
    assert axes is not None


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"support": "bx"}, 'supports[0].support: no support or housing is called "bx"; did you'),
        ({"support": "other"}, "supports[0].support: a support stands on the ground or on a hous"),
        ({"support": ("box", "seat")}, 'supports[0].support: "box" is no elastic housing and has'),
        ({"support": ("s", 0.1)}, "supports[0].support[1]: must be text"),
        (
            {"support": 3.0},
            "supports[0].support: must be a name or a tuple such as (shaft, position), got 3.0",
        ),
    ],
)
def test_an_invalid_base_of_a_support(changes: dict[str, Any], message: str):
    system, _ = on_supports_of_a_housing()
    other = gb.Support("other", mass=1.0, stiffness=1e6)
    supports = [replace(system.supports[0], **changes), other]
    bearings = [*system.bearings, gb.Bearing("s", 0.4, stiffness=1e6, support="other")]
    with pytest.raises(gb.SceneError, match="^" + re.escape(message)):
        system.replace(supports=supports, bearings=bearings)


def test_a_support_of_bearings_at_several_places_has_no_place_on_a_housing():
    system, _ = on_supports_of_a_housing()
    bearings = [replace(bearing, support="first") for bearing in system.bearings]
    with pytest.raises(gb.SceneError, match=r"^supports\[0\].support: carries bearings at several"):
        system.replace(bearings=bearings)


@each_case(
    ("changes", "message"),
    [
        ({"mass": -1.0}, "housings[0].mass: must be positive, got -1"),
        ({"inertia": (1.0, 0.0, 1.0)}, "housings[0].inertia[1]: must be positive, got 0"),
        ({"inertia": None}, "housings[0].rotational_stiffness: acts on rotations"),
        ({"name": "s"}, 'housings[0].name: shafts[0] has the name "s" too'),
        ({"name": "other"}, 'housings[0]: no bearing stands on "other"'),
        ({"points": {"wheel": (0, 0, 0)}}, "housings[0].points.wheel: disks[0] has the name"),
        ({"points": {"p": (0, np.nan, 0)}}, "housings[0].points.p[1]: must be finite"),
        ({"points": 3}, "housings[0].points: must be a dict"),
    ],
)
def test_an_invalid_housing(changes: dict[str, Any], message: str):
    box = replace(HOUSING, **changes)
    carries = "name" not in changes
    with pytest.raises(gb.SceneError, match="^" + re.escape(message)):
        rotor("box" if carries else None, housings=[box])


def test_the_description_of_a_housing_keeps_a_position_other_than_the_origin():
    system, _ = on_housing()
    (housing,) = system.housings
    for place in ((0.0, 0.0, 0.0), (0.3, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, -0.2)):
        given = system.replace(housings=[replace(housing, position=place)]).description["housings"]
        assert given[0].get("position", (0.0, 0.0, 0.0)) == place


def test_a_listed_support_needs_a_name():
    with pytest.raises(gb.SceneError, match=r"^supports\[0\].name: needs a name"):
        single_shaft(supports=[gb.Support(mass=1.0, stiffness=1e6)])


def test_a_housing_that_its_mount_does_not_hold():
    loose = replace(HOUSING, stiffness=0.0)
    with pytest.raises(gb.SceneError, match='the load moves "box"; give it a stiffness'):
        rotor("box", housings=[loose]).static()


def test_an_unknown_recorded_name_is_compared_with_those_of_housings():
    system, _ = on_housing()
    with pytest.raises(gb.SceneError, match=r"did you mean .sensor."):
        system.simulate(0.01, SPEED, record=["sensr"])
