"""Derivatives of responses and of the static equilibrium, against differences of complete analyses."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

import gearbow as gb
from reference.machines import bowed_pair, rotor_on_films, uneven_train
from test_frequency_response import train
from test_sensitivity import TOLERANCE, differences, part

#: Parameters of a random train, with functions that multiply them by a factor.
CHANGES: dict[str, Callable[[gb.RotorSystem, float], gb.RotorSystem]] = {
    "bearings[1].stiffness": part("bearings", 1, "stiffness"),
    "bearings[2].damping": part("bearings", 2, "damping"),
    "shafts['a'].outer_diameter": part("shafts", 0, "outer_diameter"),
    "shafts['b'].outer_diameter": part("shafts", 1, "outer_diameter"),
    "gears['gb'].face_width": part("gears", 1, "face_width"),
    "gears['ga'].position": part("gears", 0, "position"),
    "meshes[0].stiffness": part("meshes", 0, "stiffness"),
    "meshes[0].damping": part("meshes", 0, "damping"),
}


def random_train(seed: int) -> gb.RotorSystem:
    """Return a train with random numbers, bent and unbalanced under torque and weight."""
    random = np.random.default_rng(seed)
    # Every response on cross-coupled bearings searches for unstable modes, 0.3 s at each speed of a system of 146 coordinates.
    size = 1 if seed % 5 in (0, 1) and seed % 2 else 3
    shafts = [
        gb.Shaft(
            name,
            length=0.5,
            outer_diameter=random.uniform(0.03, 0.07),
            elements=size,
            degree=max(size, 2),
            bow=gb.Bow.half_sine(random.uniform(1e-5, 1e-4), phase=random.uniform(0.0, 6.0)),
        )
        for name in ("a", "b")
    ]
    gears = [
        gb.Gear(
            f"g{shaft.name}",
            shaft.name,
            x,
            teeth,
            module=3e-3,
            face_width=0.03,
            unbalance=random.uniform(1e-5, 1e-4),
        )
        for shaft, x, teeth in zip(shafts, random.uniform(0.2, 0.3, 2), (23, 41), strict=True)
    ]
    bearings = [
        gb.Bearing(
            shaft.name,
            x,
            stiffness=stiffness if seed % 2 else stiffness * np.eye(2),
            damping=random.uniform(1e2, 1e4),
            loss_factor=0.02 * (seed % 3),
        )
        for shaft in shafts
        for x in (0.0, 0.5)
        for stiffness in [random.uniform(1e7, 1e8, (2, 2)) * [[1.0, 0.2], [-0.1, 1.0]]]
    ]
    # Where the parameter is a stiffness, it is one number.
    bearings[1] = replace(bearings[1], stiffness=random.uniform(1e7, 1e8))
    mesh = gb.Mesh("ga", "gb", stiffness=2e8, damping=2e3, centre_line_angle=random.uniform(0, 6))
    return gb.RotorSystem(
        shafts,
        gears,
        [mesh],
        bearings,
        torques=[gb.Torque("ga", 200.0), gb.Torque.balance("gb")],
        gravity=9.81,
        modal_damping=0.01 if seed in (0, 1, 3) else None,
    )


def check(found: gb.results.ResponseSensitivity, values: Callable[[str, float], Any]) -> None:
    """Compare derivatives with central differences of complete analyses."""
    expected = np.array(
        # Near a resonance with 1 % damping, steps of 1.6e-3 have errors of 3e-6, which fall with h⁴.
        [differences(lambda f, path=path: values(path, f), 1e-4) for path in found.parameters]
    )
    own = found.derivatives * found.parameter_values.reshape(-1, *(1,) * found.values.ndim)
    assert own.shape == expected.shape
    # the largest derivative of its kind
    assert np.max(np.abs(own - expected)) < TOLERANCE * np.max(np.abs(expected))


FREQUENCIES = 2.0 * np.pi * np.array([-300.0, 40.0, 170.0, 900.0])


# Each signal with bearings that are and are not isotropic; loss factors and modal damping with some of them.
@pytest.mark.parametrize("seed", range(10))
def test_derivatives_of_responses_are_differences_of_complete_analyses(seed: int):
    system, paths = random_train(seed), list(CHANGES)
    sources = [
        gb.Force(("a", 0.31), 1.0 + 0.5j),
        gb.MeshExcitation("ga/gb"),
        gb.GroundMotion(1e-6 + 1e-6j, quantity=("velocity", "acceleration")[seed % 2]),
        gb.ShaftExcitation("b"),
    ]
    at, quantity = [
        (("b", 0.5), "bearing_force"),
        (("a", 0.11), "displacement"),
        ("ga/gb", "displacement"),
        ("gb", "acceleration"),
        ("ga", "twist"),
    ][seed % 5]

    @cache
    def changed(path: str, factor: float) -> gb.RotorSystem:
        return CHANGES[path](system, factor)

    def read(of: Any) -> Any:
        if at == "ga/gb":
            return of.mesh_force(at)[..., None]
        return of.twist(at)[..., None] if quantity == "twist" else getattr(of, quantity)(at)

    def response(path: str, factor: float) -> Any:
        other = changed(path, factor)
        return read(other.frequency_response(FREQUENCIES, source=sources, speed=120.0))

    of = system.frequency_response(FREQUENCIES, source=sources, speed=120.0)
    found = system.sensitivity(paths, of, at=at, quantity=quantity)
    assert found.values == pytest.approx(read(of), rel=1e-9, abs=1e-9 * np.abs(read(of)).max())
    check(found, response)

    speeds = np.array([-90.0, 0.0, 150.0, 400.0])
    if at != "ga/gb" and quantity in ("displacement", "bearing_force"):
        unbalanced = system.synchronous(speeds)
        found = system.sensitivity(paths, unbalanced, at=at, quantity=quantity)
        check(found, lambda path, f: read(changed(path, f).synchronous(speeds)))
    if quantity != "acceleration":

        def loads(path: str, factor: float) -> Any:
            static = changed(path, factor).static(100.0)
            return np.atleast_1d(getattr(static, quantity)(place))[None, :]

        # The torque determines the force of the only mesh.
        place = "gb" if at == "ga/gb" else at
        check(system.sensitivity(paths, system.static(100.0), at=place, quantity=quantity), loads)


def test_derivatives_of_velocities_are_those_of_displacements_times_the_frequency():
    system, paths, w = uneven_train(), ["bearings[1].damping", "meshes[1].stiffness"], FREQUENCIES
    source = gb.Force("pinion", 1.0 + 0.5j)
    of = system.frequency_response(w, source=source, speed=120.0)
    still = system.sensitivity(paths, of, at="wheel")
    for quantity, factor in (("velocity", 1j * w), ("acceleration", -(w**2))):
        found = system.sensitivity(paths, of, at="wheel", quantity=quantity)  # type: ignore[arg-type]
        factors = factor[:, None, None]
        # the same sums in another order
        assert found.values == pytest.approx(factors * still.values, rel=1e-9)
        assert found.values == pytest.approx(getattr(of, quantity)("wheel"), rel=1e-9)
        assert found.derivatives == pytest.approx(factors * still.derivatives, rel=1e-9)


def test_the_equilibrium_of_oil_films_changes_with_a_parameter():
    system, path = rotor_on_films(), "bearings[0].clearance"
    change = part("bearings", 0, "clearance")
    source, w = gb.Force("d", 1.0), np.array([200.0, 400.0])

    def response(_path: str, factor: float) -> Any:
        other = change(system, factor)
        return other.frequency_response(w, source=source, speed=300.0).displacement("d")

    def loads(_path: str, factor: float) -> Any:
        return change(system, factor).static(300.0).displacement("d")[None, :]

    of = system.frequency_response(w, source=source, speed=300.0)
    check(system.sensitivity(path, of, at="d"), response)
    check(system.sensitivity(path, system.static(300.0), at="d"), loads)


def test_sensors_and_places_between_nodes_have_derivatives():
    system = train()
    source = gb.Force(("out", 0.33), 1.0)
    change = part("gears", 0, "position")
    for at in (gb.Accelerometer("pedestal", angle=0.4), gb.Probe("in", 0.31, angle=0.4)):
        of = system.frequency_response([300.0, 900.0], source=source, speed=50.0)
        found = system.sensitivity("gears['pinion'].position", of, at=at)

        def measured(_path: str, factor: float, at: Any = at) -> Any:
            other = change(system, factor).frequency_response(
                [300.0, 900.0], source=source, speed=50.0
            )
            return other.measure(at)[..., None]

        check(found, measured)


def test_the_table_and_the_figure_show_the_largest_amplitudes():
    system = bowed_pair()
    speeds = np.linspace(10.0, 300.0, 30)
    paths = ["bearings[0].stiffness", "shafts['input'].bow.amplitude"]
    found = system.sensitivity(paths, system.synchronous(speeds), at="g1")
    # The response is proportional to the only bow that excites it.
    assert found.relative[1, :, 0] == pytest.approx(1.0, rel=1e-9)
    table = found.table()
    assert "derivatives of the synchronous response, at the largest amplitudes" in table
    assert "g1 y, shaft input, " in table
    largest = found.largest()
    assert largest.output_values[0] == np.abs(found.values[:, 0, 0]).max()
    panels = found.plot(count=2).axes
    assert len(panels) == 2
    assert panels[0].yaxis_inverted()
    assert panels[0].get_yticklabels()[0].get_text() == "shafts['input'].bow.amplitude"


def test_wrong_signals_are_refused():
    system = train()
    static, path = system.static(), "bearings[1].damping"
    with pytest.raises(gb.SceneError, match="quantity: must be one of"):
        system.sensitivity(path, static, at="pinion", quantity="velocity")
    with pytest.raises(gb.SceneError, match="at: a sensor measures no equilibrium"):
        system.sensitivity(path, static, at=gb.Accelerometer("pedestal"))
    with pytest.raises(gb.ChannelError, match="at: no bearing"):
        system.sensitivity(path, static, at=("in", 0.2), quantity="bearing_force")
    other = train(torques=[gb.Torque("pinion", 50.0), gb.Torque.balance("wheel")], drives=())
    with pytest.raises(gb.SceneError, match="of: is no equilibrium of this system"):
        system.sensitivity(path, other.static(), at="pinion")
