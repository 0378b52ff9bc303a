"""Systems for the tests at extreme parameters, and independent solutions for them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cholesky, expm, solve_triangular

import gearbow as gb

Array = NDArray[np.float64]
Hold = Callable[..., None]  # type of the fixture `hold`
E, G, RHO = 207e9, 207e9 / 2.6, 7850.0
GRAVITY = 9.81
MIDDLE = ("rotor", 0.5)


def rotor(
    stiffness: Any = 1e8,
    damping: Any = 0.0,
    *,
    length: float = 1.0,
    diameters: tuple[float, float] = (0.05, 0.0),
    segments: Sequence[tuple[float, int]] | None = None,
    elements: int = 6,
    **system: Any,
) -> gb.RotorSystem:
    """Return a uniform shaft on two equal bearings; `segments` are (length [m], number of
    elements).
    """
    segments = (
        [(length / 2, elements - elements // 2), (length / 2, elements // 2)]
        if segments is None
        else segments
    )
    parts = [gb.Segment(x, *diameters, elements=n) for x, n in segments if x > 0 and n > 0]
    end = sum(part.length for part in parts)
    shaft = gb.Shaft("rotor", segments=parts, bow=system.pop("bow", None))
    bearings = [gb.Bearing("rotor", x, stiffness=stiffness, damping=damping) for x in (0.0, end)]
    return gb.RotorSystem(shafts=[shaft], bearings=bearings, **system)


def train(
    support: float = 1e8,
    damping: float = 500.0,
    *,
    teeth: tuple[int, int] = (25, 50),
    bow: gb.Bow | None = None,
    torque: float = 250.0,
    elements: int = 4,
    first: float = 0.0,
    **mesh: Any,
) -> gb.RotorSystem:
    """Return two shafts, each with a gear at mid-length; `first` is the length [m] of an optional
    short first element.
    """
    names = ("a", "b")
    lengths = [(first, 1), (0.25 - first, elements // 2), (0.25, elements // 2)]
    segments = [gb.Segment(x, 0.05, elements=n) for x, n in lengths if x > 0]
    gear = {"module": 3e-3, "face_width": 0.03}
    return gb.RotorSystem(
        shafts=[gb.Shaft(x, segments=segments, bow=bow) for x in names],
        gears=[
            gb.Gear(f"g{x}", x, 0.25, teeth=z, **gear) for x, z in zip(names, teeth, strict=True)
        ],
        meshes=[gb.Mesh("ga", "gb", **({"stiffness": 2e8, "damping_ratio": 0.05} | mesh))],
        bearings=[
            gb.Bearing(x, p, stiffness=support, damping=damping) for x in names for p in (0.0, 0.5)
        ],
        torques=[gb.Torque("ga", torque), gb.Torque.balance("gb")] if torque else [],
    )


def section(diameters: tuple[float, float]) -> tuple[float, float, float]:
    """Return area [m²], second moment of area [m⁴] and Cowper shear coefficient of a tube.

    The factored form avoids cancellation for thin walls.
    """
    ro, ri = diameters[0] / 2, diameters[1] / 2
    area = np.pi * (ro - ri) * (ro + ri)
    m2, nu = (ri / ro) ** 2, 0.3
    kappa = 6 * (1 + nu) * (1 + m2) ** 2 / ((7 + 6 * nu) * (1 + m2) ** 2 + (20 + 12 * nu) * m2)
    return area, area * (ro**2 + ri**2) / 4, kappa


def sag(length: float, diameters: tuple[float, float], stiffness: float) -> float:
    """Return the static sag [m] at mid-length under gravity: bending, shear and bearings.

    Beam elements give the exact value at their nodes.
    """
    area, moment, kappa = section(diameters)
    load = RHO * area * GRAVITY
    bending = 5 * load * length**4 / (384 * E * moment) + load * length**2 / (8 * kappa * G * area)
    return bending + load * length / 2 / stiffness


def released(system: gb.RotorSystem, speed: float, times: Sequence[float]) -> Array:
    """Return the displacements (times, n) after release from rest under gravity along −z, by matrix exponentials.

    The state is y = (R q, Lᵀ q̇) with K + Kᵀ = 2(RᵀR − μM) and M = L Lᵀ. Without damping its matrix is skew-symmetric,
    so the matrix exponential is accurate for stiff systems as well.
    """
    m = system.matrices()
    c = m.damping + speed * m.gyroscopic
    n = len(m.mass)
    low = cholesky(m.mass, lower=True)
    symmetric = (m.stiffness + m.stiffness.T) / 2

    def left(x: Array) -> Array:
        return solve_triangular(low, x, lower=True)

    shift = 1.0 + max(0.0, -2 * np.linalg.eigvalsh(left(left(symmetric).T))[0])
    upper = cholesky(symmetric + shift * m.mass)
    b = left(upper.T).T  # R L⁻ᵀ
    beside = left(
        solve_triangular(upper, (m.stiffness - symmetric - shift * m.mass).T, trans="T").T
    )
    damped = left(left(c.T).T)
    a = np.block([[np.zeros((n, n)), b], [-b.T - beside, -damped]])
    down = np.array([-GRAVITY if dof[2] == "w" else 0.0 for dof in m.dofs])
    rest = np.linalg.solve(m.stiffness, m.mass @ down)
    y = np.concatenate([-upper @ rest, np.zeros(n)])
    moved = [solve_triangular(upper, (expm(a * t) @ y)[:n]) + rest for t in times]
    return np.array(moved)


def at(system: gb.RotorSystem, name: tuple[str, float]) -> list[int]:
    """Return the indices of v and w of a (shaft, position) in the matrices."""
    dofs = [(shaft, round(x, 9), kind) for shaft, x, kind in system.matrices().dofs]
    return [dofs.index((name[0], round(name[1], 9), kind)) for kind in "vw"]


def apart(found: Any, exact: Any) -> float:
    """Return the largest absolute difference divided by the largest absolute exact value."""
    exact = np.asarray(exact)
    return float(np.abs(np.asarray(found) - exact).max() / np.abs(exact).max())
