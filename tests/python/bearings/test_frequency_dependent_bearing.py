"""Bearings whose coefficients depend on the frequency of the vibration, and on the speed."""

import re
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator

import gearbow as gb
from reference.cases import each_case

SPEED = 80.0
SPEEDS = np.array([0.0, 60.0, 200.0])
FREQUENCIES = np.array([0.0, 150.0, 400.0, 900.0, 6000.0])
#: Stiffness and damping over speed and frequency, with cross coefficients.
STIFFNESS = np.array(
    [
        [[[1e7 + 9e3 * f, 8e3 * s], [-8e3 * s, 1.5e7 + 5e3 * f + 1e4 * s]] for f in FREQUENCIES]
        for s in SPEEDS
    ]
)
DAMPING = np.array(
    [
        [[[9e3 / (1.0 + f / 300.0), 0.0], [0.0, 5e3 + s + 0.5 * f]] for f in FREQUENCIES]
        for s in SPEEDS
    ]
)


def over_both(values: np.ndarray, **options: Any) -> gb.SpeedTable:
    return gb.SpeedTable(SPEEDS, values, frequencies=FREQUENCIES, **options)


def at(values: np.ndarray, speed: float, frequency: float) -> np.ndarray:
    """Interpolate with SciPy, over the frequency first."""
    over_speed = PchipInterpolator(FREQUENCIES, values, axis=1)(abs(frequency))
    return PchipInterpolator(SPEEDS, over_speed, axis=0)(abs(speed))


def rotor(stiffness: Any, damping: Any = 0.0, **changes: Any) -> gb.RotorSystem:
    shaft = gb.Shaft("s", length=1.0, outer_diameter=0.06, elements=6, bow=gb.Bow.half_sine(1e-4))
    given = {
        "disks": [gb.Disk("d", "s", 0.4, 20.0, 0.2, 0.35, unbalance=1e-3)],
        "bearings": [gb.Bearing("s", x, stiffness=stiffness, damping=damping) for x in (0.0, 1.0)],
    }
    return gb.RotorSystem([shaft], **(given | changes))


def table_rotor(**options: Any) -> gb.RotorSystem:
    return rotor(over_both(STIFFNESS, **options), over_both(DAMPING, **options))


def constant_rotor(speed: float, frequency: float) -> gb.RotorSystem:
    return rotor(at(STIFFNESS, speed, frequency), at(DAMPING, speed, frequency))


def with_added_mass(mass: float) -> gb.RotorSystem:
    masses = [gb.Disk(f"m{x}", "s", x, mass, 0.0, 0.0) for x in (0.0, 1.0)]
    return rotor(3e7, disks=[gb.Disk("d", "s", 0.4, 20.0, 0.2, 0.35, unbalance=1e-3), *masses])


def of_added_mass(mass: float, knots: np.ndarray) -> gb.RotorSystem:
    """Give the same rotor with the dynamic stiffness k - m ω² of a spring with a mass."""
    return rotor(gb.SpeedTable(None, 3e7 - mass * knots**2, frequencies=knots))


def test_a_stiffness_that_falls_with_the_frequency_is_an_added_mass():
    knots = np.linspace(0.0, 2500.0, 501)
    table, mass = of_added_mass(4.0, knots), with_added_mass(4.0)
    source = gb.Force(("s", 0.7), (1.0, 0.5j))
    at_knots = knots[[1, 40, 333]]
    responses = [
        system.frequency_response(at_knots, source=source, speed=SPEED).displacement("d")
        for system in (table, mass)
    ]
    # At its knots the table has the given values.
    np.testing.assert_allclose(responses[0], responses[1], rtol=1e-10)
    # Between them the error of the interpolation is 1e-8 of the stiffness.
    expected = mass.modes(SPEED, count=6)
    found = table.modes(SPEED, count=6)
    np.testing.assert_allclose(found.frequencies_hz, expected.frequencies_hz, rtol=1e-7)
    assert found.whirl == expected.whirl
    critical = [
        np.array([speed for speed, _ in system._model.critical_speeds(1.5, None)])
        for system in (table, mass)
    ]
    # The table ends at 2500 rad/s.
    assert np.count_nonzero(critical[0]) >= 3
    within = critical[1][1.5 * critical[1] < knots[-1]]
    np.testing.assert_allclose(critical[0], within, rtol=1e-7)
    diagrams = [system.campbell(np.linspace(0.0, 600.0, 7), count=4) for system in (table, mass)]
    speeds = [[each.speed for each in diagram.criticals] for diagram in diagrams]
    assert len(speeds[0]) == 2
    np.testing.assert_allclose(speeds[0], speeds[1], rtol=1e-7)


def test_equal_modes_at_rest_are_both_found():
    knots = np.linspace(0.0, 2500.0, 501)
    table, mass = of_added_mass(4.0, knots), with_added_mass(4.0)
    found, expected = table.modes(0.0, count=6), mass.modes(0.0, count=6)
    np.testing.assert_allclose(found.frequencies_hz, expected.frequencies_hz, rtol=1e-7)
    pair = found.shapes[:2]
    assert abs(np.vdot(pair[0], pair[1])) < 0.1 * np.linalg.norm(pair[0]) * np.linalg.norm(pair[1])


def test_each_mode_has_the_coefficients_of_its_own_frequency():
    modes = table_rotor().modes(SPEED, count=8)
    assert np.count_nonzero(modes.frequencies_hz) >= 6
    for value in modes.eigenvalues:
        own = constant_rotor(SPEED, value.imag).modes(SPEED).eigenvalues
        # The search ends at 1e-12 of the frequency; overdamped modes are more sensitive.
        assert np.min(np.abs(own - value)) < 1e-8 * abs(value)
    assert np.max(modes.residuals) < 1e-8


def test_frequency_response_agrees_with_dense_matrices():
    frequencies = np.array([-700.0, 33.0, 150.0, 2222.0])
    response = table_rotor().frequency_response(
        frequencies, source=gb.Force(("s", 0.7), (1.0, 2.0j)), speed=SPEED
    )
    displacement, force = response.displacement("d"), response.bearing_force(("s", 0.0))
    for i, frequency in enumerate(frequencies):
        system = constant_rotor(SPEED, frequency)
        same = system.frequency_response(
            [frequency], source=gb.Force(("s", 0.7), (1.0, 2.0j)), speed=SPEED
        )
        found = system.matrices(SPEED)
        stiffness = (
            found.stiffness
            + 1j * frequency * (found.damping + SPEED * found.gyroscopic)
            - frequency**2 * found.mass
        )
        # The force on the coordinates follows from the response of a system with constants.
        load = stiffness @ same.phasors[0, 0]
        phasors = np.linalg.solve(stiffness, load)
        np.testing.assert_allclose(response.phasors[i, 0], phasors, rtol=1e-8, atol=1e-17)
        np.testing.assert_allclose(displacement[i], same.displacement("d")[0], rtol=1e-9)
        np.testing.assert_allclose(force[i], same.bearing_force(("s", 0.0))[0], rtol=1e-8)
        both = table_rotor().matrices(SPEED, frequency=frequency)
        np.testing.assert_allclose(both.stiffness, found.stiffness, rtol=1e-12)
        np.testing.assert_allclose(both.damping, found.damping, rtol=1e-12)


def test_synchronous_response_has_the_frequency_of_the_rotation():
    speeds = np.array([-90.0, 20.0, 155.0])
    found = table_rotor().synchronous(speeds)
    for i, speed in enumerate(speeds):
        constant = constant_rotor(speed, speed).synchronous([speed])
        np.testing.assert_allclose(found.amplitudes[i], constant.amplitudes[0], rtol=1e-8)
        np.testing.assert_allclose(
            found.bearing_force(("s", 0.0))[i], constant.bearing_force(("s", 0.0))[0], rtol=1e-7
        )


def test_intersections_and_thresholds_satisfy_their_conditions():
    system = table_rotor()
    diagram = system.campbell(np.linspace(0.0, 200.0, 5), count=4)
    for crossing in diagram.intersections:
        modes = system.modes(crossing.speed, count=8)
        frequencies = 2.0 * np.pi * modes.frequencies_hz
        order = crossing.line.order
        assert np.min(np.abs(frequencies - order * crossing.speed)) < 1e-8 * crossing.speed
    unstable = rotor(over_both(STIFFNESS), 500.0)
    (first, *_) = unstable.campbell(np.linspace(0.0, 200.0, 5), count=4).thresholds
    growth = unstable.modes(first.speed, count=8).eigenvalues
    nearest = growth[np.argmin(np.abs(growth.imag - 2.0 * np.pi * first.frequency_hz))]
    assert abs(nearest.real) < 1e-8 * abs(nearest)


def test_a_table_that_is_constant_over_the_frequency_is_that_over_the_speed():
    flat = [np.repeat(values[:, :1], FREQUENCIES.size, axis=1) for values in (STIFFNESS, DAMPING)]
    table = rotor(*(over_both(values) for values in flat))
    plain = rotor(*(gb.SpeedTable(SPEEDS, values[:, 0]) for values in (STIFFNESS, DAMPING)))
    for count in (4, None):
        found, expected = table.replace(), plain.modes(SPEED, count=count)
        if count is None:
            found = rotor(*(over_both(values, outside="hold") for values in flat))
        np.testing.assert_allclose(
            found.modes(SPEED, count=count).eigenvalues,
            expected.eigenvalues,
            rtol=1e-8,
            atol=1e-6,
        )
    source = gb.Force("d", 1.0)
    responses = [
        system.frequency_response([50.0, 700.0], source=source, speed=SPEED).phasors
        for system in (table, plain)
    ]
    np.testing.assert_allclose(responses[0], responses[1], rtol=1e-10, atol=1e-18)
    np.testing.assert_array_equal(table.static(SPEED).state, plain.static(SPEED).state)


def test_the_equilibrium_has_the_frequency_zero():
    found = table_rotor().replace(gravity=(9.81, 0.0)).static(SPEED)
    expected = constant_rotor(SPEED, 0.0).replace(gravity=(9.81, 0.0)).static(SPEED)
    np.testing.assert_allclose(found.displacement("d"), expected.displacement("d"), rtol=1e-12)


@pytest.mark.filterwarnings("ignore::gearbow.AccuracyWarning")
def test_a_machine_with_another_bearing():
    machine = gb.examples()["gearbox"].load()
    speed = 100.0
    knots = np.array([0.0, 500.0, 2000.0, 20000.0])
    table = gb.SpeedTable(None, [2e8, 2.5e8, 4e8, 6e8], frequencies=knots)
    first, *others = machine.bearings
    place = {"shaft": first.shaft, "position": first.position}

    def with_bearing(stiffness: Any) -> gb.RotorSystem:
        bearing = gb.Bearing(**place, stiffness=stiffness, damping=2e3, support=first.support)
        return machine.replace(bearings=[bearing, *others])

    system = with_bearing(table)
    modes = system.modes(speed, count=12)
    constant = PchipInterpolator(knots, [2e8, 2.5e8, 4e8, 6e8])
    for value in modes.eigenvalues[[2, 8, 11]]:
        own = with_bearing(constant(value.imag)).modes(speed, count=12).eigenvalues
        # Modal damping of approximated modes depends on the coefficients: docs/formulation.md
        # promises 6e-7.
        assert np.min(np.abs(own - value)) < 6e-7 * abs(value)
    name = machine.meshes[0]
    response = system.frequency_response(
        [3000.0], source=gb.MeshExcitation((name.driver, name.driven)), speed=speed
    )
    same = with_bearing(constant(3000.0)).frequency_response(
        [3000.0], source=gb.MeshExcitation((name.driver, name.driven)), speed=speed
    )
    # The oil films have the equilibrium with the coefficients at the frequency 0.
    np.testing.assert_allclose(
        response.phasors, same.phasors, rtol=0.0, atol=1e-6 * np.abs(same.phasors).max()
    )


def test_coefficients_at_one_frequency_serve_runs():
    table = over_both(STIFFNESS).at_frequency(-333.0)
    assert isinstance(table, gb.SpeedTable)
    expected = PchipInterpolator(FREQUENCIES, STIFFNESS, axis=1)(333.0)
    np.testing.assert_allclose(table.values, expected, rtol=1e-14)
    assert np.shape(over_both(STIFFNESS, outside="hold").at_frequency(1e9).values) == (3, 2, 2)
    alone = gb.SpeedTable(None, [1e7, 2e7], frequencies=[0.0, 1000.0])
    np.testing.assert_array_equal(alone.at_frequency(1000.0), [[2e7, 0.0], [0.0, 2e7]])
    rotor(table, 500.0).simulate(0.001, 100.0)
    with pytest.raises(gb.SceneError, match="frequency: the table has the frequencies 0 to 1000"):
        alone.at_frequency(1001.0)


def test_runs_and_steady_motions_refuse_the_table():
    text = r"^bearings\[0\]\.stiffness: depends on the frequency of the vibration, and this .* SpeedTable\.at_frequency"
    system = table_rotor()
    for ask in (
        lambda: system.simulate(0.01, 100.0),
        lambda: system.simulate(0.1, gb.SpeedProfile.ramp(100.0, 150.0, 0.1), method="rk45"),
        lambda: system.steady_state(100.0),
        lambda: system.continuation("speed", 90.0, 100.0),
        lambda: system.matrices(100.0),
        lambda: system.sensitivity(
            ["disks['d'].mass"],
            of=system.frequency_response([10.0], source=gb.Force("d", 1.0)),
            at="d",
        ),
    ):
        with pytest.raises(gb.SceneError, match=text):
            ask()


def test_frequencies_outside_the_table_name_bearing_frequency_and_range():
    text = r"bearings\[0\]\.stiffness: .*the table has the frequencies 0 to 6000 rad/s, but the vibration has {}"
    system = table_rotor()
    force = gb.Force("d", 1.0)
    for ask, frequency in (
        (lambda: system.frequency_response([7000.0], source=force), "7000"),
        (lambda: system.frequency_response([-7000.0], source=force), "7000"),
        (lambda: system.matrices(0.0, frequency=6001.0), "6001"),
        (lambda: system.modes(0.0), ""),
    ):
        with pytest.raises(gb.SceneError, match=text.format(frequency)):
            ask()
    with pytest.raises(gb.SceneError, match=r"mode 9 at 0 rad/s: the table"):
        system.modes(0.0)
    held = table_rotor(outside="hold")
    (value,) = held.modes(0.0, count=9).eigenvalues[8:]
    own = constant_rotor(0.0, FREQUENCIES[-1]).modes(0.0).eigenvalues
    assert np.min(np.abs(own - value)) < 1e-9 * abs(value)
    with pytest.raises(gb.SceneError, match="the table has the frequencies 10 to 20 rad/s"):
        rotor(gb.SpeedTable(None, [1e7, 2e7], frequencies=[10.0, 20.0])).static()


@each_case(
    ("table", "message"),
    [
        (lambda: gb.SpeedTable(None, [1e8]), "bearings[0].stiffness: a table needs speeds, frequencies or both"),
        (lambda: gb.SpeedTable(None, [1e8], frequencies=[1.0]), "bearings[0].stiffness.frequencies: needs at least 2 frequencies, got 1"),
        (lambda: gb.SpeedTable(None, [1e8, 2e8], frequencies=[1.0, 0.0]), "bearings[0].stiffness.frequencies[1]: must be above the frequency before it, 1, got 0"),
        (lambda: gb.SpeedTable(None, [1e8], frequencies=[0.0, 1.0]), "bearings[0].stiffness.values: needs one value for each of the 2 frequencies, got 1"),
        (lambda: gb.SpeedTable([0, 1], [1e8, 2e8], frequencies=[0.0, 1.0]), "bearings[0].stiffness.values[0]: needs one value for each of the 2 frequencies, got 1"),
        (lambda: gb.SpeedTable([0, 1], [[1e8] * 3] * 3, frequencies=[0.0, 1.0, 2.0]), "bearings[0].stiffness.values: needs one value for each of the 2 speeds, got 3"),
        (lambda: gb.SpeedTable([0, 1], [[1e8] * 3, [1e8, 1e8, -1.0]], frequencies=[0.0, 1.0, 2.0]), "bearings[0].stiffness.values[1][2]: must not be negative, got -1"),
        (lambda: gb.SpeedTable([0, 1], [[1e8] * 3] * 2), "bearings[0].stiffness.values[0]: expected a number, a pair [yy, zz] or rows [[yy, yz], [zy, zz]]; a list of these needs"),
    ],
)  # fmt: skip
def test_invalid_tables_name_the_entry(table: Callable[[], gb.SpeedTable], message: str):
    with pytest.raises(gb.SceneError, match="^" + re.escape(message)):
        rotor(table())


def test_a_torque_has_no_frequency():
    torque = gb.Torque("d", gb.SpeedTable([0.0, 1.0], [1.0, 2.0], frequencies=[0.0, 1.0]))
    with pytest.raises(gb.SceneError, match=r"torques\[0\]"):
        rotor(1e7, torques=[torque])


def test_tables_survive_files_and_descriptions(tmp_path: Any):
    alone = gb.SpeedTable(None, [1e3, 2e3], "hold", frequencies=[0.0, 1000.0])
    system = rotor(over_both(STIFFNESS, outside="hold"), alone)
    system.save(tmp_path / "scene.toml")
    for again in (
        gb.RotorSystem.load(tmp_path / "scene.toml"),
        gb.RotorSystem.from_dict(system.description),
        system.replace(gravity=None),
    ):
        assert again.bearings == system.bearings
        np.testing.assert_array_equal(
            again.modes(33.0, count=3).shapes, system.modes(33.0, count=3).shapes
        )
