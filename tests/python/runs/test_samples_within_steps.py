"""Samples at any time within a step of the exponential method."""

from dataclasses import replace

import numpy as np
import pytest

import gearbow as gb
from reference.machines import pair


def train(damping: float, rayleigh: tuple[float, float] | None) -> gb.RotorSystem:
    bent = {"elements": 4, "bow": gb.Bow.half_sine(1e-4)}
    return pair(shaft=bent, bearing={"stiffness": 1e8, "damping": damping}, rayleigh=rayleigh)


@pytest.mark.parametrize(
    ("damping", "rayleigh"),
    [(0.0, None), (500.0, None), (3e6, None), (500.0, (1e5, 0.0))],
    ids=["undamped", "damped", "overdamped", "fast decay of the rotation"],
)
def test_samples_agree_with_the_ends_of_short_steps(
    damping: float, rayleigh: tuple[float, float] | None
):
    """Slow, fast, overdamped and rigid-body modes follow the loads within a step."""
    system = train(damping, rayleigh)
    step = 1e-5
    times = step * np.arange(1, 200)
    options = {"initial": "rest", "times": times, "record": ["nodes", "meshes"]}
    # the first run has steps that are not commensurate with the times
    coarse = system.simulate(2e-3, 150.0, step=7.3e-5, stages=4, **options)
    fine = system.simulate(2e-3, 150.0, step=step, stages=4, **options)
    for gear in ("g1", "g2"):
        one, other = coarse.displacement(gear), fine.displacement(gear)
        # the error of four-stage collocation with the coarse step
        np.testing.assert_allclose(one, other, atol=1e-7 * np.abs(other).max(), rtol=0)


def test_a_sample_does_not_depend_on_the_others():
    system = train(500.0, None)
    times = np.linspace(0.0, 1e-3, 301)
    every = system.simulate(1e-3, 150.0, rtol=1e-6, times=times)
    some = system.simulate(1e-3, 150.0, rtol=1e-6, times=times[5::7])
    np.testing.assert_array_equal(every.displacement("g2")[5::7], some.displacement("g2"))
    np.testing.assert_array_equal(
        every.mesh(("g1", "g2")).force[5::7], some.mesh(("g1", "g2")).force
    )


def test_the_energies_of_any_number_of_samples_are_complete():
    # The energies of the shafts are computed for eight samples together.
    system, options = train(500.0, None), {"rtol": 1e-6, "record": ["energy"]}
    times = np.linspace(0.0, 1e-3, 18)[1:]
    every = system.simulate(1e-3, 150.0, **options, times=times).energy_balance()
    assert every.kinetic.min() > 0.0
    for count in (1, 7, 8, 9, 16, 17):
        some = system.simulate(1e-3, 150.0, **options, times=times[:count]).energy_balance()
        for name in ("kinetic", "shafts"):
            found, expected = getattr(some, name), getattr(every, name)[:count]
            np.testing.assert_allclose(found, expected, rtol=1e-9, err_msg=f"{count} {name}")


def test_energy_between_steps_balances():
    """Works at instants within a step follow from the powers of the whole step."""
    system = train(500.0, None)
    shafts = [
        replace(shaft, bow=gb.Bow.half_sine(2e-4, phase=float(k)))
        for k, shaft in enumerate(system.shafts)
    ]
    gears = [replace(gear, unbalance=2e-3 + 1e-3j) for gear in system.gears]
    system = system.replace(shafts=shafts, gears=gears, gravity=9.81)
    times = np.linspace(0.0, 5e-3, 1237)
    run = system.simulate(5e-3, 300.0, initial="rest", rtol=1e-9, times=times, record=["energy"])
    balance = run.energy_balance()
    turned_over = np.abs(np.diff(balance.total)).sum()
    assert run.statistics.steps < 1000
    # the works of two rules agree to 1e-8
    assert np.abs(balance.residual).max() < 1e-7 * turned_over
