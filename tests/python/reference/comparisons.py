"""Comparisons that several files of tests share."""

from __future__ import annotations

from typing import Any

import numpy as np

import gearbow as gb


def error(found: np.ndarray, exact: np.ndarray) -> float:
    """Give the RMS of the difference over the RMS of the variation about the mean."""
    return float(np.sqrt(((found - exact) ** 2).sum() / ((exact - exact.mean(axis=0)) ** 2).sum()))


def by_both_methods(
    system: gb.RotorSystem, *given: Any, exact: float = 1e-9, rtol: float = 1e-8, **options: Any
) -> list[gb.Response]:
    """Run with the tolerance `exact` of the explicit method, and with `rtol` of the exponential one."""
    return [
        system.simulate(*given, method=method, rtol=tolerance, **options)
        for method, tolerance in (("rk45", exact), ("exponential", rtol))
    ]


def assert_near(runs: list[gb.Response], *places: Any, share: float = 1e-6) -> None:
    """Check that displacements of two runs differ by less than a share of the range of the first."""
    for place in places:
        first, second = (run.displacement(place) for run in runs)
        assert np.abs(first - second).max() < share * np.ptp(first), place


def assert_energy_closes(*runs: gb.Response, share: float = 1e-6) -> None:
    """Check that the balance of energy leaves less than a share of the largest energy."""
    for run in runs:
        balance = run.energy_balance()
        assert np.abs(balance.residual).max() < share * balance.total.max()


def assert_matrices(system: gb.RotorSystem, expected: Any) -> None:
    """Check that the matrices of a system are those of an independent assembly."""
    found = system.matrices()
    for name in ("mass", "stiffness", "damping", "gyroscopic"):
        wanted = getattr(expected, name)
        # quadrature of the shaft elements
        atol = 1e-12 * np.abs(wanted).max()
        np.testing.assert_allclose(getattr(found, name), wanted, rtol=1e-9, atol=atol)


def assert_modes_of_speeds(
    system: gb.RotorSystem, diagram: gb.results.Campbell, speeds: tuple[int, ...], share: float
) -> None:
    """Check that a Campbell diagram has the modes of some of its speeds."""
    for k in speeds:
        modes = system.modes(diagram.speeds[k]).eigenvalues
        for value in diagram.eigenvalues[k]:
            assert np.abs(modes - value).min() < share * abs(value)
