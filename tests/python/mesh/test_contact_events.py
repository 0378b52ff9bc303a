"""Contact events: changes of the contact mode after the start are the same for every method."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from test_random_scenes import Drawn

#: Each method with its tightest options.
METHODS: dict[str, dict[str, Any]] = {
    "exponential": {"method": "exponential", "rtol": 1e-10},
    "rk45": {"method": "rk45", "rtol": 1e-9},
    "rk4": {"method": "rk4", "rtol": None},
    "etdrk4": {"method": "etdrk4", "step": 5e-7, "rtol": None},
}
CONTACT = {"contact", "back contact", "separation", "tight"}


def scene(seed: int) -> Drawn:
    """Draw a random train of two or three shafts at rest, with unloaded flanks in contact."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(2, 4))

    def each(low: float, high: float) -> tuple[float, ...]:
        return tuple(rng.uniform(low, high, count).tolist())

    def plane(size: float) -> complex:
        return complex(*rng.uniform(-size, size, 2))

    return Drawn(
        lengths=each(0.2, 1.0),
        diameters=each(0.02, 0.1),
        elements=tuple(rng.integers(1, 4, count).tolist()),
        places=tuple(rng.choice([0.0, 0.25, 0.4, 0.6, 1.0], count).tolist()),
        teeth=tuple((4 * rng.integers(5, 16, count)).tolist()),
        bows=tuple(plane(2e-4) for _ in range(count)),
        unbalance=plane(1e-3),
        bearing=(*rng.uniform(0.01, 5.0, 2).tolist(), 0.0, float(rng.uniform(0.0, 2.0))),
        angle=float(rng.uniform(-3.0, 3.0)),
        mesh=(
            str(rng.choice(["mean", "square", "parabolic"])),
            float(10 ** rng.uniform(7.0, 8.7)),
            float(rng.choice([0.0, 0.03, 0.1])),
        ),
        backlash=2e-5,
        torque=float(rng.choice([-1.0, 1.0]) * rng.uniform(1.0, 200.0)),
        gravity=tuple(rng.uniform(-10.0, 10.0, 2).tolist()),
        rayleigh=float(rng.choice([0.0, 1e-7])),
        speed=float(rng.choice([0.0, 40.0, -150.0, 600.0])),
    )


@pytest.mark.parametrize("seed", range(40))
def test_all_methods_report_the_same_first_events(seed: int):
    """At the start δ is round-off of either sign: no method reports an event there."""
    drawn = scene(seed)
    found = {}
    for name, options in METHODS.items():
        # Coarse fixed steps change the motion after some steps: only the first events are compared,
        # over a time in
        run = drawn.run(times=np.array([0.0, 5e-5]), **options)
        found[name] = [
            (e.driver, e.kind) for e in run.events if e.kind in CONTACT and e.time < 4e-5
        ]
        assert all(event.time > 0.0 for event in run.events if event.kind in CONTACT)
    assert all(events == found["rk45"] for events in found.values()), found


@pytest.mark.parametrize("method", METHODS)
def test_flanks_in_contact_from_the_start_cause_no_event(method: str):
    """Two gears at rest, flanks in contact, and a torque: the contact exists from the start."""
    drawn = Drawn(bows=(0j, 0j), unbalance=0j, backlash=2e-5, gravity=(0.0, 0.0), speed=0.0)
    run = drawn.run(times=np.array([0.0, 2e-5]), **METHODS[method])
    assert run.mesh(("g0", "g1")).force[-1] > 0.0
    assert run.events == ()


@pytest.mark.parametrize("method", METHODS)
def test_events_do_not_depend_on_the_recorded_quantities(method: str):
    drawn = scene(5)
    whole, points = (
        drawn.run(times=np.array([0.0, 5e-5]), record=record, **METHODS[method])
        for record in (["gears", "meshes", "energy"], [("s0", 0.0)])
    )
    contact = [[e for e in run.events if e.kind in CONTACT] for run in (whole, points)]
    assert contact[0] == contact[1]


@pytest.mark.parametrize("seed", [31, 239, 253])
def test_round_off_of_touching_flanks_does_not_delay_their_contact(seed: int):
    """Two meshes touch at rest: round-off of both margins must not exhaust the changes at one instant."""
    drawn = scene(seed)
    undamped = replace(
        drawn, bearing=(*drawn.bearing[:3], 0.0), mesh=(*drawn.mesh[:2], 0.0), rayleigh=0.0
    )
    system, found = undamped.system(), []
    for options in ({"method": "rk45", "rtol": 1e-9}, {"rtol": 1e-8}, {"rtol": 1e-11}):
        run = system.simulate(
            1e-3, drawn.speed, initial="rest", times=np.linspace(0.0, 1e-3, 21), **options
        )
        forces = np.stack([run.mesh(pair).force for pair in (("g0", "g1"), ("g1", "g2"))])
        found.append(([(e.driver, e.kind) for e in run.events if e.kind in CONTACT], forces))
    (wanted, exact), *others = found
    assert len(wanted) >= 5
    for events, forces in others:
        assert events == wanted
        # A contact that is late by 3 microseconds changes the forces by 6e-5.
        assert np.abs(forces - exact).max() < 1e-6 * np.abs(exact).max()
