"""Properties of the model: mass, matrices, elements."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from gearbow._extras import extra
from gearbow._result import Column, Result
from gearbow._shown import ReadOnly, Shown
from gearbow._types import Array, Dof, Plain, SparseMatricesData


@dataclass(frozen=True, eq=False)
class MassProperties(Result, ReadOnly):
    """Mass properties of each shaft with what it carries, and of the machine.

    Parameters
    ----------
    names : tuple of str
        Names of the shafts.
    mass : ndarray, shape (k,)
        Mass of each shaft with its sleeves, gears and disks [kg].
    centre : ndarray, shape (k, 3)
        Centre of mass (x, y, z) [m]; the reference shaft begins at the origin.
    polar_inertia, diametral_inertia : ndarray, shape (k,)
        Moments of inertia about the axis, and about a diameter through the centre [kg m²].
    total_mass : float
        Mass of the machine without housings and supports [kg].
    total_centre : ndarray, shape (3,)
        Its centre of mass [m].
    total_inertia : ndarray, shape (3, 3)
        Its inertia matrix about this centre [kg m²].

    Notes
    -----
    Bows, run-outs and unbalances are left out. The shaft that the description names first begins at
    the origin; the centre distances place the others, and shafts that nothing joins to it begin at
    the origin as well.

    Examples
    --------
    >>> import gearbow as gb
    >>> rotor = gb.Shaft("rotor", length=1.0, outer_diameter=0.05)
    >>> wheel = gb.Disk("wheel", "rotor", 0.75, 15.0, diametral_inertia=0.1, polar_inertia=0.2)
    >>> found = gb.RotorSystem([rotor], disks=[wheel]).mass_properties()
    >>> print(f"{found.total_mass:.2f} kg at {found.total_centre[0]:.3f} m")
    30.41 kg at 0.623 m
    """

    names: tuple[str, ...]
    mass: Array
    centre: Array
    polar_inertia: Array
    diametral_inertia: Array
    total_mass: float
    total_centre: Array
    total_inertia: Array

    @classmethod
    def _of(
        cls, names: Sequence[str], found: list[list[float]], origins: list[list[float]]
    ) -> "MassProperties":
        """Add the shafts, which begin at the origins [m], to a machine."""
        mass, along, polar, diametral = np.array(found, dtype=float).T
        centre = np.array(origins, dtype=float)
        centre[:, 0] += along
        total = float(mass.sum())
        middle = mass @ centre / total if total > 0.0 else np.zeros(3)
        inertia = np.zeros((3, 3))
        for own, axial, across, place in zip(mass, polar, diametral, centre - middle, strict=True):
            inertia += np.diag([axial, across, across])
            inertia += own * (place @ place * np.eye(3) - np.outer(place, place))
        return cls(tuple(names), mass, centre, polar, diametral, total, middle, inertia)

    def _heading(self) -> list[str]:
        return ["mass properties of the shafts with sleeves, gears and disks"]

    def _columns(self) -> list[Column]:
        x, y, z = np.vstack([self.centre, self.total_centre]).T
        inertia = np.diag(self.total_inertia)
        return [
            Column("shaft", [*self.names, "machine"]),
            Column("mass", np.append(self.mass, self.total_mass), "kg", ".5g"),
            Column("x", x, "m", ".4f"),
            Column("y", y, "m", ".4f"),
            Column("z", z, "m", ".4f"),
            Column("inertia xx", np.append(self.polar_inertia, inertia[0]), "kg m²", ".4e"),
            Column("inertia yy", np.append(self.diametral_inertia, inertia[1]), "kg m²", ".4e"),
            Column("inertia zz", np.append(self.diametral_inertia, inertia[2]), "kg m²", ".4e"),
        ]

    def __repr__(self) -> str:
        return f"MassProperties({len(self.names)} shafts, {self.total_mass:.4g} kg)"


@dataclass(frozen=True, eq=False)
class Matrices(ReadOnly):
    """Matrices of M q̈ + (C + Ω G) q̇ + K q = f, with Ω the speed of the reference shaft.

    They are arrays, or sparse matrices (`scipy.sparse.csr_array`), which need memory in proportion
    to n, with `matrices(sparse=True)` and SciPy (the extra ``sparse``).

    Parameters
    ----------
    mass : ndarray or scipy.sparse.csr_array, shape (n, n)
        Mass matrix M [kg, kg m²].
    stiffness : ndarray or scipy.sparse.csr_array, shape (n, n)
        Stiffness matrix K [N/m, N m/rad] with bearings and the meshes, linearised at rest.
    damping : ndarray or scipy.sparse.csr_array, shape (n, n)
        Damping matrix C [N s/m, N m s/rad], including the meshes.
    gyroscopic : ndarray or scipy.sparse.csr_array, shape (n, n)
        Gyroscopic matrix G per unit reference speed [kg m²]; skew-symmetric.
    dofs : tuple of (str, float or (float, float), str)
        Shaft, position [m] and direction ("u", "v", "w", "B", "G" or "twist") of each degree of
        freedom.
        Those within an element have the positions of its ends and a degree ("v2").

    Examples
    --------
    A rigid translation along y moves the mass of the shaft, π/4 · 0.05² · 1 · 7850 kg:

    >>> import numpy as np
    >>> import gearbow as gb
    >>> rotor = gb.Shaft("rotor", length=1.0, outer_diameter=0.05, elements=8)
    >>> matrices = gb.RotorSystem(shafts=[rotor]).matrices()
    >>> along_y = np.array([direction == "v" for _, _, direction in matrices.dofs], dtype=float)
    >>> print(f"{along_y @ matrices.mass @ along_y:.3f} kg")
    15.413 kg

    Sparse matrices of a shaft with 1001 nodes:

    >>> rotor = gb.Shaft("rotor", length=1.0, outer_diameter=0.05, elements=1000, degree=1)
    >>> gb.RotorSystem(shafts=[rotor]).matrices(sparse=True).mass.shape
    (5005, 5005)
    """

    mass: Any
    stiffness: Any
    damping: Any
    gyroscopic: Any
    dofs: tuple[Dof, ...]

    @classmethod
    def _from_sparse(cls, data: SparseMatricesData, dofs: tuple[Dof, ...]) -> "Matrices":
        """Create sparse matrices from the entries, columns and row starts of the core."""
        with extra("sparse"):
            from scipy.sparse import csr_array  # noqa: PLC0415 (only here)
        shape = (len(dofs), len(dofs))
        return cls(
            mass=csr_array(data["mass"], shape=shape),
            stiffness=csr_array(data["stiffness"], shape=shape),
            damping=csr_array(data["damping"], shape=shape),
            gyroscopic=csr_array(data["gyroscopic"], shape=shape),
            dofs=dofs,
        )


@dataclass(frozen=True)
class ShaftElements(Shown):
    """Elements of one shaft.

    Parameters
    ----------
    numbers : tuple of int
        Number of elements of each segment.
    degree : int
        Degree of their polynomials.

    Examples
    --------
    >>> import gearbow as gb
    >>> gb.results.ShaftElements(numbers=(4, 2), degree=3)
    ShaftElements(numbers=(4, 2), degree=3)
    """

    numbers: tuple[int, ...]
    degree: int


@dataclass(frozen=True)
class Discretisation(Shown):
    """Elements of a system.

    Parameters
    ----------
    shafts : mapping of {str: ShaftElements}
        Elements of each shaft.
    coordinates : int
        Number of degrees of freedom of the system.
    level : str or None
        Level of the chosen elements; None if all numbers are given.
    expected_error : float or None
        Expected error of the mesh forces, or of the displacements in a scene without meshes, from
        the response to a step of the load: RMS of the difference / RMS of the signal about its
        mean, over 0.1 s. None if all numbers are given.
    permitted_error : float or None
        Largest error that the level permits. The chosen elements exceed it only where a system, or
        a mesh of a long train, would need more than 1200 coordinates.
    highest_frequency_hz : float or None
        Highest natural frequency with a relative error of at most 1e-3 [Hz].

    Examples
    --------
    >>> import gearbow as gb
    >>> elements = gb.examples()["bowed_rotor"].load().discretisation
    >>> elements.shafts["rotor"].degree > 1
    True
    """

    shafts: Mapping[str, ShaftElements]
    coordinates: int
    level: str | None = None
    expected_error: float | None = None
    permitted_error: float | None = None
    highest_frequency_hz: float | None = None

    @classmethod
    def _of(
        cls,
        description: Mapping[str, Plain],
        choice: tuple[str, float, float, float] | None,
        coordinates: int,
    ) -> "Discretisation":
        """Collect the elements of a plain scene; `choice` has level, errors and frequency."""
        shafts = {}
        for shaft in description["shafts"]:
            parts = shaft.get("segments", [shaft])
            numbers = tuple(part.get("elements", 1) for part in parts)
            shafts[shaft["name"]] = ShaftElements(numbers, shaft.get("degree", 1))
        if choice is None:
            return cls(shafts, coordinates)
        level, expected, permitted, highest = choice
        return cls(shafts, coordinates, level, expected, permitted, highest / (2.0 * math.pi))

    def __str__(self) -> str:
        lines = [
            f"{name}: {' + '.join(map(str, each.numbers))} elements of degree {each.degree}"
            for name, each in self.shafts.items()
        ]
        lines.append(f"{self.coordinates} degrees of freedom")
        if self.level is not None:
            lines.append(
                f"{self.level}: expected error {self.expected_error:.0e}, at most "
                f"{self.permitted_error:.0e}; frequencies up to {self.highest_frequency_hz:.0f} Hz "
                "are accurate to 1e-3"
            )
        return "\n".join(lines)
