"""Analyses of rotors on profiled bores, tilting pads and squeeze films, against differences of systems and each other."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import gearbow as gb

SIZE = {"diameter": 0.06, "length": 0.03, "clearance": 1e-4, "viscosity": 0.02}
PADS: dict[str, Any] = {**SIZE, "pad_count": 5, "pad_inertia": 1e-4, "preload": 0.5}
SPEED = 300.0
PLACES = (0.1, 0.7)


def integral(values: np.ndarray, x: np.ndarray) -> Any:
    """Integrate along the last axis by the trapezoidal rule."""
    return ((values[..., 1:] + values[..., :-1]) / 2.0 * np.diff(x)).sum(axis=-1)


def on(bearings: list[Any]) -> gb.RotorSystem:
    shaft = gb.Shaft("s", length=0.8, outer_diameter=0.06, elements=2, bow=gb.Bow.half_sine(2e-6))
    disk = gb.Disk("d", "s", 0.45, 15.0, 0.1, 0.2, unbalance=1e-5)
    return gb.RotorSystem([shaft], disks=[disk], bearings=bearings, gravity=9.81, motion="lateral")


def squeeze(**options: Any) -> list[Any]:
    size = {"diameter": 0.1, "length": 0.02, "clearance": 1e-4, "viscosity": 0.02}
    damper = gb.SqueezeFilm(mass=2.0, stiffness=5e6, **size, **options)
    return [gb.Bearing("s", x, stiffness=1e8, damping=1e3, support=damper) for x in PLACES]


SYSTEMS = {
    "lemon": on([gb.JournalBearing("s", x, **SIZE, profile="lemon", preload=0.5) for x in PLACES]),
    "offset": on([gb.JournalBearing("s", x, **SIZE, profile="offset") for x in PLACES]),
    "pads": on([gb.TiltingPadBearing("s", x, **PADS) for x in PLACES]),
    "pivots": on(
        [gb.TiltingPadBearing("s", x, **PADS, pivot_stiffness=2e8, pad_mass=0.3) for x in PLACES]
    ),
    "reduced": on([gb.TiltingPadBearing("s", x, **PADS, reduced="synchronous") for x in PLACES]),
    "squeeze": on(squeeze()),
    "whole squeeze": on(squeeze(ruptures=False)),
}


def changed(system: gb.RotorSystem, name: str, factor: float) -> gb.RotorSystem:
    """Change a number of the first bearing, or of its support."""
    first, *others = system.bearings
    if hasattr(first, name):
        first = replace(first, **{name: factor * getattr(first, name)})
    else:
        base = first.support
        first = replace(first, support=replace(base, **{name: factor * getattr(base, name)}))
    return system.replace(bearings=[first, *others])


@pytest.mark.parametrize(
    ("kind", "names"),
    [
        ("lemon", ["viscosity", "clearance", "preload"]),
        ("offset", ["viscosity", "clearance"]),
        ("pads", ["viscosity", "clearance", "preload", "pad_inertia"]),
        ("pivots", ["pivot_stiffness", "pad_mass"]),
        ("reduced", ["viscosity", "preload"]),
        ("squeeze", ["viscosity", "clearance", "length"]),
    ],
)
def test_sensitivities_are_derivatives(kind: str, names: list[str]):
    system, step = SYSTEMS[kind], 1e-4
    modes = system.modes(SPEED, count=2, vibrating=True)
    response = system.synchronous(SPEED)
    for name in names:
        path = f"bearings[0].{'support.' if kind == 'squeeze' else ''}{name}"
        found = system.sensitivity(path, modes)
        pair = [
            changed(system, name, factor).modes(SPEED, count=2, vibrating=True).frequencies_hz
            for factor in (1.0 - step, 1.0 + step)
        ]
        expected = (pair[1] - pair[0]) / (2.0 * step) / modes.frequencies_hz
        # the interpolated film has jumps of the third derivative
        np.testing.assert_allclose(found.relative[0], expected, rtol=2e-3, atol=1e-6, err_msg=name)
        pair = [
            np.abs(changed(system, name, factor).synchronous(SPEED).displacement("d"))[0, 0]
            for factor in (1.0 - step, 1.0 + step)
        ]
        expected = (pair[1] - pair[0]) / (pair[1] + pair[0]) / step
        given = system.sensitivity(path, response, at="d").relative[0, 0, 0]
        np.testing.assert_allclose(given, expected, rtol=2e-3, atol=2e-6, err_msg=name)


@pytest.mark.parametrize("kind", [kind for kind in SYSTEMS if kind not in ("reduced", "squeeze")])
def test_a_small_steady_state_is_the_synchronous_response(kind: str):
    system = SYSTEMS[kind]
    steady = system.steady_state(SPEED, record=["d"]).response.displacement("d")
    linear = 2.0 * np.abs(system.synchronous(SPEED).displacement("d"))[0, 0]
    np.testing.assert_allclose(np.ptp(steady, axis=0), linear, rtol=0.02)


def test_reduced_pads_have_no_steady_state():
    with pytest.raises(gb.SceneError, match=r"^bearings\[0\].reduced: coefficients for one freq"):
        SYSTEMS["reduced"].steady_state(SPEED)


@pytest.mark.parametrize("kind", SYSTEMS)
def test_a_bow_at_the_limit_of_a_bearing_force_has_this_force(kind: str):
    system, at = SYSTEMS[kind], ("s", 0.1)
    mean = system.static(speed=SPEED).bearing_force(at)
    limit = gb.BowLimit.bearing_force(at, 1.5 * float(np.hypot(*mean)))
    (found,) = system.bow_limits("s", SPEED, limits=[limit], phase=0.0).found
    bent = system.replace(shafts=[replace(system.shafts[0], bow=gb.Bow.half_sine(found.bow))])
    turning = bent.synchronous(SPEED).bearing_force(at)[0, 0]
    angles = np.linspace(0.0, 2.0 * np.pi, 3601)
    force = mean + (turning * np.exp(1j * angles)[:, None]).real
    # the search takes instants of a period, which miss the largest force by up to 4e-4
    assert np.hypot(*force.T).max() == pytest.approx(limit.value, rel=1e-3)


def test_the_limit_of_a_film_is_that_of_a_cylindrical_bore():
    limit = gb.BowLimit.film(("s", 0.1), 2e-5)
    for kind in ("lemon", "offset"):
        message = "limits: the thickness of a film is known for a cylindrical bore, and the bearing at ('s', 0.1) has lobes; limit the displacement of its shaft"
        with pytest.raises(gb.SceneError, match="^" + re.escape(message) + "$"):
            SYSTEMS[kind].bow_limits("s", SPEED, limits=[limit])
    message = "limits: the bearing at s at 0.1 m is no JournalBearing, which the limit 'film' needs"
    with pytest.raises(gb.ChannelError, match="^" + re.escape(message) + "$"):
        SYSTEMS["pads"].bow_limits("s", SPEED, limits=[limit])
    grooved = on([gb.JournalBearing("s", x, **SIZE, profile="two axial grooves") for x in PLACES])
    (found,) = grooved.bow_limits("s", SPEED, limits=[limit]).found
    assert found.bow > 0.0


def measured(system: gb.RotorSystem) -> complex:
    return complex(system.synchronous(SPEED).displacement("d")[0, 0, 0])


def test_a_sweep_over_the_preload_is_the_analyses_of_its_systems():
    def make(preload: float) -> gb.RotorSystem:
        return on([gb.TiltingPadBearing("s", x, **{**PADS, "preload": preload}) for x in PLACES])

    found = gb.sweep(make, {"preload": [0.4, 0.6]}, lambda system, **_: measured(system))
    expected = [measured(make(preload)) for preload in (0.4, 0.6)]
    np.testing.assert_array_equal(found.values(), expected)
    assert abs(expected[0] - expected[1]) > 1e-3 * abs(expected[0])


@pytest.mark.parametrize(("kind", "share"), [("whole squeeze", 1.0), ("squeeze", 0.5)])
def test_a_squeeze_film_off_centre_has_the_damping_of_its_closed_form(kind: str, share: float):
    # a full short film: π(1 + 2ε²)/(1 − ε²)^(5/2) along the displacement, π/(1 − ε²)^(3/2) across it
    system = SYSTEMS[kind]
    ring = system.bearings[0].support
    scale = ring.viscosity * ring.diameter / 2.0 * ring.length**3 / ring.clearance**3
    static = system.static(speed=SPEED)
    support = np.flatnonzero([kind in "vw" for _, _, kind in system.dofs])[-4:-2]
    place = static.state[support]
    ratio = np.hypot(*place) / ring.clearance
    # the ring sags below its film
    assert 0.2 < ratio < 0.5
    along = np.pi * (1.0 + 2.0 * ratio**2) / (1.0 - ratio**2) ** 2.5
    across = np.pi / (1.0 - ratio**2) ** 1.5
    bearing = system.bearings[0].damping
    found = system.matrices(SPEED).damping[np.ix_(support, support)] - bearing * np.eye(2)
    np.testing.assert_allclose(
        found / scale, share * np.diag([across, along]), rtol=1e-9, atol=1e-9
    )


@pytest.mark.parametrize("kind", ["lemon", "pads", "squeeze"])
def test_bow_and_unbalance_are_identified(kind: str):
    system = SYSTEMS[kind]
    speeds = SPEED * np.linspace(0.6, 1.4, 7)
    probes = [gb.Probe("s", x, angle=angle) for x in (0.4, PLACES[1]) for angle in (0.0, np.pi / 2)]
    response = system.synchronous(speeds)
    vectors = np.stack(
        [
            response.displacement((probe.shaft, probe.position))[:, 0]
            @ [np.cos(probe.angle), np.sin(probe.angle)]
            for probe in probes
        ],
        axis=1,
    )
    straight = system.replace(
        shafts=[replace(system.shafts[0], bow=None)],
        disks=[replace(system.disks[0], unbalance=0.0)],
    )
    wanted = [gb.unknown.bow("s"), gb.unknown.unbalance("d")]
    measured = gb.Measurement(speeds, vectors, probes)
    found = gb.identify(straight, measured, wanted, runout=False, noise=1e-9)
    # the second half sine is zero
    np.testing.assert_allclose(found.values, [2e-6, 1e-5][: len(found.values)], rtol=1e-6)


def test_the_pressure_of_the_pads_carries_the_load():
    # integrated over the pad with the pressure along the length of a short film, a parabola
    size = {**SIZE, "length": 0.006}
    load = 20.0
    for bearing in (
        gb.JournalBearing("s", 0.0, **size),
        gb.JournalBearing("s", 0.0, **size, profile="lemon"),
        gb.TiltingPadBearing("s", 0.0, **size, pad_count=5, preload=0.3),
        gb.TiltingPadBearing(
            "s", 0.0, **size, pad_count=4, preload=0.5, pivot_stiffness=1e8, pad_mass=0.1
        ),
    ):
        found = bearing.coefficients(load, SPEED)
        force = np.zeros(2)
        for pad in found.pads:
            direction = np.array([np.cos(pad.angles), np.sin(pad.angles)])
            line = 2.0 / 3.0 * size["length"] * size["diameter"] / 2.0 * pad.pressure
            force += integral(line * direction, pad.angles)
            assert pad.thickness[pad.pressure > 0.0].min() > 0.0
            assert pad.pressure.max() > 0.0 or pad.pivot is not None
        # the pressure of the ends of a pad is no parabola
        np.testing.assert_allclose(force, [0.0, -load], atol=0.06 * load, err_msg=str(bearing))


def test_a_pressure_falls_off_at_the_ends_of_its_pad_and_peaks_near_its_pivot():
    found = gb.TiltingPadBearing("s", 0.0, **PADS).coefficients(2000.0, SPEED)
    assert [round(pad.pivot, 6) for pad in found.pads] == [
        round(-0.3 * np.pi + 0.4 * np.pi * i, 6) for i in range(5)
    ]
    for pad in found.pads:
        assert pad.pressure[0] == pad.pressure[-1] == 0.0
        # without friction, the resultant passes through the pivot
        moment = integral(pad.pressure * np.sin(pad.angles - pad.pivot), pad.angles)
        # the pressure of the middle has its moment elsewhere than that of the ends
        assert abs(moment) < 0.02 * integral(pad.pressure, pad.angles)
