"""Sources and outputs of the frequency response, against dense matrices, closed forms and runs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import gearbow as gb
from reference.machines import hostile, two_disks_in_torsion
from test_frequency_response import train


def dense(system, frequency: float, speed: float, force: np.ndarray) -> np.ndarray:
    """Solve the equations of motion with the matrices of the system."""
    m = system.matrices(speed)
    rate = m.damping + speed * m.gyroscopic
    return np.linalg.solve(m.stiffness + 1j * frequency * rate - frequency**2 * m.mass, force)


def at(system, *dof) -> int:
    return system.dofs.index(dof)


@pytest.mark.parametrize("options", [{}, {"modal_damping": 0.03}])
@pytest.mark.parametrize("frequency", [-900.0, 350.0, 2600.0])
def test_forces_and_torques_satisfy_the_equations_of_motion(options: dict, frequency: float):
    bearings = train().bearings
    axial = [gb.Bearing("in", 0.2, stiffness=0.0, axial_stiffness=5e7, axial_damping=300.0)]
    system = train(bearings=[*bearings, *axial], **options)
    speed, n = 120.0, len(system.dofs)
    sources = {
        gb.Force("pinion", (2.0 - 1j, 0.5j), axial=3j): {
            ("in", 0.15, "v"): 2.0 - 1j,
            ("in", 0.15, "w"): 0.5j,
            ("in", 0.15, "u"): 3j,
        },
        gb.Force(("out", 0.5), 1.0 + 2j): {("out", 0.5, "v"): 1.0, ("out", 0.5, "w"): 2.0},
        gb.Torque("wheel", 1.0 + 1j): {("out", 0.2, "twist"): 1.0 + 1j},
        gb.Force("pedestal", 1j): {("pedestal", 0.0, "w"): 1.0},
    }
    found = system.frequency_response([frequency], source=list(sources), speed=speed)
    for number, entries in enumerate(sources.values()):
        force = np.zeros(n, dtype=complex)
        for dof, value in entries.items():
            force[at(system, *dof)] = value
        x = dense(system, frequency, speed, force)
        # round-off of the dense solution
        scale = 1e-9 * np.abs(x).max()
        assert found.phasors[0, number] == pytest.approx(x, rel=1e-7, abs=scale)
    assert found.twist("wheel")[0, 2] == found.phasors[0, 2, at(system, "out", 0.2, "twist")]
    assert found.velocity("wheel") == pytest.approx(1j * frequency * found.displacement("wheel"))
    assert found.acceleration("wheel") == pytest.approx(
        -(frequency**2) * found.displacement("wheel")
    )
    axial = found.axial_displacement("pinion")[0, 0]
    assert axial == found.phasors[0, 0, at(system, "in", 0.15, "u")]


@pytest.mark.parametrize("quantity", ["displacement", "velocity", "acceleration"])
def test_motion_relative_to_the_ground_is_that_of_inertia_forces(quantity: str):
    # Damping αM would resist the motion of the frame.
    system, speed, frequency = train(rayleigh=(0.0, 2e-6)), 150.0, 640.0
    value = (1e-6, 2e-6j)
    found = system.frequency_response(
        [frequency], source=gb.GroundMotion(value, quantity=quantity), speed=speed
    )
    power = ("displacement", "velocity", "acceleration").index(quantity)
    ground = np.array(value) / (1j * frequency) ** power
    translation = np.zeros(len(system.dofs), dtype=complex)
    for index, (_, _, direction) in enumerate(system.dofs):
        if direction in ("v", "w"):
            translation[index] = ground["vw".index(direction)]
    inertia = frequency**2 * system.matrices(speed).mass @ translation
    x = translation + dense(system, frequency, speed, inertia)
    assert found.phasors[0, 0] == pytest.approx(x, rel=1e-8, abs=1e-9 * np.abs(x).max())
    u = found.displacement(("in", 0.0))[0, 0] - ground
    stiffness = np.array([8e7, 5e7]) + 1j * frequency * np.array([2e3, 1e3])
    assert found.bearing_force(("in", 0.0))[0, 0] == pytest.approx(stiffness * u, rel=1e-9)


def test_motions_below_single_bearings_add_up_to_that_of_the_ground():
    system = train()
    places = [("in", 0.0), ("in", 0.4), "pedestal", ("out", 0.5)]
    single = [gb.GroundMotion(1e-6 + 2e-6j, under=[place]) for place in places]
    found = system.frequency_response(
        [500.0], source=[gb.GroundMotion(1e-6 + 2e-6j), *single], speed=80.0
    )
    whole, *parts = found.phasors[0]
    assert np.sum(parts, axis=0) == pytest.approx(whole, rel=1e-9, abs=1e-9 * np.abs(whole).max())
    with pytest.raises(gb.SceneError, match=r"source\[0\].under\[0\]: nothing there stands"):
        system.frequency_response([1.0], source=gb.GroundMotion(1.0, under=[("in", 0.2)]))
    source = gb.GroundMotion(1.0, quantity="acceleration")
    with pytest.raises(gb.SceneError, match=r"frequencies\[1\]: must not be 0"):
        system.frequency_response([1.0, 0.0], source=source)


def test_a_transmission_error_has_the_forces_of_a_run():
    error, speed = 2e-6, 60.0
    shape = gb.TransmissionError(tooth=[(error, 0.4)])
    mesh = gb.Mesh("pinion", "wheel", stiffness=2e8, damping_ratio=0.06, error=shape)
    straight = [
        gb.Shaft(s.name, length=s.length, outer_diameter=s.outer_diameter, elements=4)
        for s in train().shafts
    ]
    gears = [
        gb.Gear(g.name, g.shaft, g.position, teeth=g.teeth, module=3e-3, face_width=0.03)
        for g in train().gears
    ]
    system = train(meshes=[mesh], shafts=straight, gears=gears)
    found = system.mesh_response("wheel/pinion", speeds=[speed], harmonics=[1, 2], error=error)
    assert found.axes == ("speed", "order")
    assert found.frequencies[0] == pytest.approx([23 * speed, 46 * speed])
    run = system.simulate(
        0.3, speed, geometry="frozen", rtol=1e-9, record=["gears", "meshes", "bearings"]
    )
    kept = run.time > 0.2
    time = run.time[kept]
    tooth = 23 * speed

    def amplitude(values: np.ndarray) -> complex:
        columns = np.stack(
            [np.cos(tooth * time), -np.sin(tooth * time), np.ones_like(time)], axis=1
        )
        a, b, _ = np.linalg.lstsq(columns, values[kept], rcond=None)[0]
        return complex(a, b) * np.exp(-0.4j)

    # transients have decayed to 1e-5; the tolerance of the run
    assert amplitude(run.mesh(("pinion", "wheel")).force) == pytest.approx(
        found.mesh_force("pinion/wheel")[0, 0, 0], rel=1e-4
    )
    for i in range(2):
        assert amplitude(run.displacement("wheel")[:, i]) == pytest.approx(
            found.displacement("wheel")[0, 0, 0, i], rel=1e-4
        )
        assert amplitude(run.bearing_force(("out", 0.5))[:, i]) == pytest.approx(
            found.bearing_force(("out", 0.5))[0, 0, 0, i], rel=1e-4
        )


def test_a_torsional_drive_line_of_two_disks():
    system = two_disks_in_torsion()
    k = 207e9 / 2.6 * np.pi * 0.03**4 / 32.0 / 0.5
    for w in (100.0, 900.0, 3000.0):
        found = system.frequency_response([w], source=gb.Torque("d0", 2.0))
        matrix = np.array([[k - w**2 * 0.02, -k], [-k, k - w**2 * 0.05]])
        exact = np.linalg.solve(matrix, [2.0, 0.0])
        # the shaft has a millionth of the inertia
        twist = [found.twist(f"d{i}")[0, 0] for i in range(2)]
        assert twist == pytest.approx(exact, rel=1e-5)
        # between the nodes
        assert found.twist(("s", 0.2))[0, 0] == pytest.approx(
            0.6 * exact[0] + 0.4 * exact[1], rel=1e-5
        )
    with pytest.raises(
        gb.SceneError, match=r"frequencies\[0\]: source\[0\] accelerates a rigid-body"
    ):
        system.frequency_response([0.0], source=gb.Torque("d0", 1.0))
    with pytest.raises(
        gb.SceneError, match=r"source\[0\]: a force acts on a system without lateral"
    ):
        system.frequency_response([1.0], source=gb.Force("d0", 1.0))


def test_frequency_zero_is_the_static_deflection():
    rotor = gb.Shaft("s", length=1.0, outer_diameter=0.04, elements=4)
    bearings = [gb.Bearing("s", x, stiffness=1e12) for x in (0.0, 1.0)]
    system = gb.RotorSystem([rotor], bearings=bearings)
    found = system.frequency_response([0.0], source=gb.Force(("s", 0.5), 100.0))
    weight = system.replace(forces=[gb.Force(("s", 0.5), 100.0)]).static()
    assert found.displacement(("s", 0.5))[0, 0, 0].real == pytest.approx(
        weight.displacement(("s", 0.5))[0], rel=1e-9
    )


@pytest.mark.parametrize(
    "options", [{}, {"modal_damping": 0.02}, {"modal_damping": 0.02, "fine": True}]
)
@pytest.mark.parametrize("w", [-700.0, 1500.0])
def test_a_loss_factor_acts_as_a_damping_at_one_frequency(options: dict, w: float):
    # η k/|ω| in place of a loss factor η; the fine model has bands with modal damping.
    options, eta = dict(options), 0.07
    elements = {"elements": 16} if options.pop("fine", False) else {"elements": 4}
    shafts = [replace(shaft, **elements) for shaft in train().shafts]

    def variant(lossy: bool):
        loss, extra = (eta, 0.0) if lossy else (0.0, eta / abs(w))
        bearings = []
        for bearing in train().bearings:
            matrix = np.array(bearing.stiffness)
            damping = np.ones_like(matrix) * np.array(bearing.damping)
            if matrix.ndim == 2:
                damping = np.eye(2) * bearing.damping
            bearings.append(replace(bearing, damping=damping + extra * matrix, loss_factor=loss))
        base = gb.Support(
            "pedestal", mass=30.0, stiffness=2e8, damping=4e3 + extra * 2e8, loss_factor=loss
        )
        mesh = gb.Mesh(
            "pinion", "wheel", stiffness=2e8, damping=1e3 + extra * 2e8, loss_factor=loss
        )
        return train(shafts=shafts, bearings=bearings, supports=[base], meshes=[mesh], **options)

    source = [gb.MeshExcitation("pinion/wheel"), gb.GroundMotion(1e-6), gb.Force("wheel", 1.0)]
    lossy, viscous = (
        variant(kind).frequency_response([w], source=source, speed=90.0) for kind in (True, False)
    )
    # the modes of modal damping are those without damping, in both
    scale = 1e-9 * np.abs(viscous.phasors).max(axis=-1, keepdims=True)
    assert (np.abs(lossy.phasors - viscous.phasors) < scale).all()
    assert lossy.mesh_force("pinion/wheel") == pytest.approx(
        viscous.mesh_force("pinion/wheel"), rel=1e-8
    )
    for place in (("in", 0.0), ("out", 0.0)):
        assert lossy.bearing_force(place) == pytest.approx(viscous.bearing_force(place), rel=1e-8)
    # bow and unbalance: the frequency is that of the speed
    ratio = abs(w)
    first, second = (variant(kind).synchronous([ratio]).amplitudes[:, 0] for kind in (True, False))
    assert first == pytest.approx(second, rel=1e-8, abs=1e-9 * np.abs(second).max())


def test_runs_refuse_loss_factors():
    bearings = [replace(train().bearings[0], loss_factor=0.1), *train().bearings[1:]]
    system = train(bearings=bearings)
    with pytest.raises(
        gb.SceneError, match=r"bearings\[0\].loss_factor: has a meaning in the frequency"
    ):
        system.simulate(0.01, 50.0)
    with pytest.raises(
        gb.SceneError, match=r"bearings\[0\].loss_factor: has a meaning in the frequency"
    ):
        system.steady_state(50.0)
    with pytest.raises(gb.SceneError, match=r"meshes\[0\].loss_factor: must not be negative"):
        train(meshes=[gb.Mesh("pinion", "wheel", stiffness=2e8, loss_factor=-0.1)])


def test_sensors_measure_phasors():
    system = train()
    found = system.frequency_response([300.0, 900.0], source=gb.Force("pinion", 1.0), speed=50.0)
    u = found.displacement(("in", 0.31)) @ [np.cos(0.4), np.sin(0.4)]
    probe = gb.Probe("in", 0.31, angle=0.4, support="pedestal")
    base = found.displacement("pedestal") @ [np.cos(0.4), np.sin(0.4)]
    assert found.measure(probe) == pytest.approx(u - base)
    sensor = gb.Accelerometer("pedestal", angle=0.4)
    assert found.measure(sensor)[1] == pytest.approx(-(900.0**2) * base[1])
    with pytest.raises(gb.SceneError, match="sensor: must be"):
        found.measure(gb.Tacho("in"))


def test_wrong_arguments_are_refused():
    system = train()
    force = gb.Force("pinion", 1.0)
    cases = {
        "frequencies: give either": {"order": 1.0, "source": force},
        "source: must be a source": {"frequencies": [1.0], "source": []},
        r"source\[0\]: must be a gb.Force": {
            "frequencies": [1.0],
            "source": [gb.Bearing("in", 0.0, stiffness=1.0)],
        },
        r"source\[0\].order: a harmonic force": {
            "frequencies": [1.0],
            "source": gb.Force("pinion", 1.0, order=1.0),
        },
        r'source\[1\].at: no gear, disk, support or housing is called "pinon"; did you mean "pinion"': {
            "frequencies": [1.0],
            "source": [force, gb.Force("pinon", 1.0)],
        },
        r"source\[0\].at: shaft \"in\" reaches from 0 to 0.4 m": {
            "frequencies": [1.0],
            "source": gb.Force(("in", 0.7), 1.0),
        },
        r"source\[0\].value: must be a finite": {
            "frequencies": [1.0],
            "source": gb.Force("pinion", float("nan")),
        },
        r"source\[0\].at: no mesh is called": {
            "frequencies": [1.0],
            "source": gb.MeshExcitation("pinion/gear"),
        },
        r"source\[0\].shaft: no shaft": {
            "frequencies": [1.0],
            "source": gb.ShaftExcitation("input"),
        },
        r"frequencies\[1\]: must be finite": {"frequencies": [1.0, np.inf], "source": force},
    }
    failures = []
    for text, arguments in cases.items():
        try:
            with pytest.raises(gb.SceneError, match=text):
                system.frequency_response(**arguments)
        except (AssertionError, pytest.fail.Exception) as error:
            failures.append(f"{text}: {error}")
    assert not failures, "\n".join(failures)


def test_a_transmission_error_acts_in_its_own_mesh_only():
    # far above all modes hardly anything moves: the teeth of the excited mesh alone have a force
    machine = hostile()
    pairs = [(mesh.driver, mesh.driven) for mesh in machine.meshes]
    for excited in pairs:
        source = gb.MeshExcitation(excited, 1e-6)
        found = machine.frequency_response([1e7], source=source, speed=50.0)
        force = {pair: abs(found.mesh_force(pair)[0, 0]) for pair in pairs}
        others = [size for pair, size in force.items() if pair != excited]
        assert max(others) < 0.05 * force[excited]
