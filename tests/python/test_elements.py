"""Matrices of shaft elements of degree p: order of the frequencies, exact statics, and structure."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from scipy.linalg import eigh, eigvals

import gearbow as gb
from reference import closed_forms
from reference.elements import Section
from reference.scenes import PAIR, single_shaft

DEGREES = (1, 2, 3, 4)
ALL = range(1, 9)


def section(shear: bool, bore: float) -> Section:
    return Section(0.1, 207e9, 207e9 / 2.6, 7800.0, bore, shear)


def matrices(degree: int, elements: int, **how: object) -> gb.results.Matrices:
    options = {"diameter": 0.1, "support": None, **how}
    return single_shaft(elements=elements, degree=degree, **options).matrices()


def simply_supported(given: gb.results.Matrices, length: float = 1.0) -> np.ndarray:
    """Give the indices of the coordinates of a shaft whose ends do not move along y and z."""
    ends = [("s", x, direction) for x in (0.0, length) for direction in "vw"]
    lateral = [dof[2].rstrip("0123456789") in ("v", "w", "B", "G") for dof in given.dofs]
    return np.flatnonzero([move and dof not in ends for move, dof in zip(lateral, given.dofs, strict=True)])


def frequencies(degree: int, elements: int, spin: float = 0.0, **how: object) -> np.ndarray:
    """Give the positive whirl frequencies of a simply supported shaft [rad/s]; at rest each once."""
    found = matrices(degree, elements, **how)
    at = np.ix_(*[simply_supported(found)] * 2)
    mass, stiffness, gyroscopic = found.mass[at], found.stiffness[at], found.gyroscopic[at]
    if spin == 0.0:
        return np.sqrt(eigh(stiffness, mass, eigvals_only=True))[::2]
    # Lengths in units that make the entries of the companion matrix comparable.
    size = np.sqrt(np.diag(mass))
    mass, stiffness, gyroscopic = (x / np.outer(size, size) for x in (mass, stiffness, gyroscopic))
    n = len(mass)
    scale = 1e3
    solved = np.linalg.solve(mass, np.hstack([-stiffness / scale, -spin * gyroscopic]))
    companion = np.vstack([np.hstack([np.zeros((n, n)), scale * np.eye(n)]), solved])
    values = np.imag(eigvals(companion))
    return np.sort(values[values > 0])


@pytest.mark.parametrize("bore", [0.0, 0.08], ids=["solid", "hollow"])
@pytest.mark.parametrize("degree", DEGREES)
def test_bending_frequencies_converge_with_the_order_2p(degree: int, bore: float):
    exact = closed_forms.simply_supported(section(True, bore), 1.0, 3)[0]
    counts = {1: (16, 32), 2: (8, 16), 3: (4, 8), 4: (3, 6)}[degree]
    errors = [frequencies(degree, n, inner_diameter=bore)[2] / exact - 1 for n in counts]
    order = np.log2(errors[0] / errors[1])
    # Terms of the next order change the ratio of the two errors by a few per cent.
    assert order == pytest.approx(2 * degree, abs=0.35), errors
