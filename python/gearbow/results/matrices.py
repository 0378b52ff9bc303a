"""Matrices of the linear equations of motion."""

from dataclasses import dataclass
from typing import Any

from gearbow._extras import extra
from gearbow._read_only import ReadOnly
from gearbow._shown import Shown
from gearbow._types import Array, Dof, SparseMatricesData

__all__ = ["Matrices", "SparseMatrices"]


@dataclass(frozen=True, eq=False)
class Matrices(ReadOnly):
    """Matrices of M q̈ + (C + Ω G) q̇ + K q = f, with Ω the speed of the reference shaft.

    Parameters
    ----------
    mass : ndarray, shape (n, n)
        Mass matrix M [kg, kg m²].
    stiffness : ndarray, shape (n, n)
        Stiffness matrix K [N/m, N m/rad] of shafts, bearings and the meshes, which are linearised
        at rest.
    damping : ndarray, shape (n, n)
        Damping matrix C [N s/m, N m s/rad], including the meshes.
    gyroscopic : ndarray, shape (n, n)
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
    """

    mass: Array
    stiffness: Array
    damping: Array
    gyroscopic: Array
    dofs: tuple[Dof, ...]


@dataclass(frozen=True, eq=False)
class SparseMatrices(Shown):
    """Sparse matrices of M q̈ + (C + Ω G) q̇ + K q = f, with Ω the speed of the reference shaft.

    They need memory in proportion to n. SciPy must be installed (the extra ``sparse``).

    Parameters
    ----------
    mass : scipy.sparse.csr_array, shape (n, n)
        Mass matrix M [kg, kg m²].
    stiffness : scipy.sparse.csr_array, shape (n, n)
        Stiffness matrix K [N/m, N m/rad] of shafts, bearings and the meshes, which are linearised
        at rest.
    damping : scipy.sparse.csr_array, shape (n, n)
        Damping matrix C [N s/m, N m s/rad], including the meshes.
    gyroscopic : scipy.sparse.csr_array, shape (n, n)
        Gyroscopic matrix G per unit reference speed [kg m²]; skew-symmetric.
    dofs : tuple of (str, float or (float, float), str)
        Shaft, position [m] and direction of each degree of freedom, see `Matrices`.

    Examples
    --------
    >>> import gearbow as gb
    >>> rotor = gb.Shaft("rotor", length=1.0, outer_diameter=0.05, elements=1000, degree=1)
    >>> matrices = gb.RotorSystem(shafts=[rotor]).matrices(sparse=True)
    >>> matrices.mass.shape
    (5005, 5005)
    """

    mass: Any
    stiffness: Any
    damping: Any
    gyroscopic: Any
    dofs: tuple[Dof, ...]

    @classmethod
    def from_data(cls, data: SparseMatricesData, dofs: tuple[Dof, ...]) -> "SparseMatrices":
        """Create the matrices from those of the core.

        Parameters
        ----------
        data : dict
            Entries, columns and row starts of each matrix.
        dofs : tuple of (str, float or (float, float), str)
            Shaft, position [m] and direction of each degree of freedom.

        Returns
        -------
        SparseMatrices
            The matrices.

        Raises
        ------
        MissingExtraError
            If SciPy is not installed.
        """
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
