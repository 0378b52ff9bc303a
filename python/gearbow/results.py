"""What a system answers without a time history: matrices and equilibrium."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

from gearbow._lookup import locate
from gearbow._types import Array, At, Dof, StaticData
from gearbow.errors import ChannelError

if TYPE_CHECKING:
    from gearbow.system import RotorSystem

__all__ = ["Matrices", "MeshState", "Static"]


@dataclass(frozen=True, eq=False)
class Matrices:
    """Matrices of M q̈ + (C + Ω G) q̇ + K q = f, with Ω the speed of the reference shaft.

    Parameters
    ----------
    mass : ndarray, shape (n, n)
        Mass matrix M [kg, kg m²].
    stiffness : ndarray, shape (n, n)
        Stiffness matrix K [N/m, N m/rad]: shafts, bearings and each mesh linearised at rest.
    damping : ndarray, shape (n, n)
        Damping matrix C [N s/m, N m s/rad], with each mesh.
    gyroscopic : ndarray, shape (n, n)
        Gyroscopic matrix G per unit reference speed [kg m²]; skew-symmetric.
    dofs : tuple of (str, float, str)
        Shaft, position [m] and direction ("v", "w", "B", "G" or "twist") of each degree of freedom.

    Examples
    --------
    The mass that moves along y when the whole shaft does is its own, π/4 · 0.05² · 1 · 7850 kg:

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


@dataclass(frozen=True)
class MeshState:
    """State of one mesh at equilibrium.

    Parameters
    ----------
    deflection : float
        Mesh deflection along the line of action [m].
    force : float
        Mesh force [N].
    stiffness : float
        Mesh stiffness [N/m].
    pressure_angle : float
        Operating pressure angle [rad]. NaN where the base circles overlap, in frozen geometry.
    centre_distance : float
        Distance of the centres [m].
    centre_line_angle : float
        Angle of the line of centres, driver to driven, from y towards z [rad].
    contact_ratio : float
        Contact ratio, NaN where the base circles overlap.
    pairs_in_contact : float
        Number of tooth pairs that carry load.
    """

    deflection: float
    force: float
    stiffness: float
    pressure_angle: float
    centre_distance: float
    centre_line_angle: float
    contact_ratio: float
    pairs_in_contact: float


class Static:
    """Equilibrium under torque, gravity and the meshes; a bow turns, so it has no part in it.

    Parameters
    ----------
    data : mapping
        What the core found.
    system : RotorSystem
        The system that was asked.

    Attributes
    ----------
    state : ndarray, shape (n,)
        Displacements of all degrees of freedom [m, rad].

    Examples
    --------
    Two bearings of 1 MN/m that carry a shaft of 15.4 kg give way by 76 µm:

    >>> import gearbow as gb
    >>> rotor = gb.Shaft("rotor", length=1.0, outer_diameter=0.05, elements=8)
    >>> bearings = [gb.Bearing("rotor", x, stiffness=1e6) for x in (0.0, 1.0)]
    >>> static = gb.RotorSystem(shafts=[rotor], bearings=bearings, gravity=9.81).static()
    >>> print("{:.0f} N on each, {:.1f} µm".format(
    ...     static.bearing_force("rotor", 0.0)[1], 1e6 * static.displacement(("rotor", 0.0))[1]))
    -76 N on each, -75.6 µm
    """

    def __init__(self, data: StaticData, system: "RotorSystem") -> None:
        self.state = data["state"]
        self._data = data
        self.system = system

    def displacement(self, name: At) -> Array:
        """Lateral displacement somewhere.

        Parameters
        ----------
        name : str or tuple of (str, float)
            A gear or disk by name, or (shaft, position [m]).

        Returns
        -------
        ndarray, shape (2,)
            Displacements v and w [m].

        Raises
        ------
        GearbowError
            If there is no such place, or the system has no lateral motion.
        """
        return self.state[self.system._lateral(name)]

    def twist(self, name: At) -> float:
        """Twist somewhere.

        Parameters
        ----------
        name : str or tuple of (str, float)
            A gear or disk by name, or (shaft, position [m]).

        Returns
        -------
        float
            Twist from the uniform spin [rad].

        Raises
        ------
        GearbowError
            If there is no such place, or the system has no twist.
        """
        return float(self.state[self.system._twist(name)])

    def bearing_force(self, shaft: str, position: float) -> Array:
        """Force of a shaft on its bearing.

        Parameters
        ----------
        shaft : str
            Name of the shaft.
        position : float
            Position of the bearing [m].

        Returns
        -------
        ndarray, shape (2,)
            Components along y and z [N].

        Raises
        ------
        ChannelError
            If there is no such bearing.
        """
        i = locate(self._data["bearings"], shaft, position)
        if i is None:
            raise ChannelError(
                f"no bearing at ({shaft!r}, {position:g}); there are {self._data['bearings']}"
            )
        force: Array = self._data["bearing_force"][i]
        return force

    def mesh(self, driver: str, driven: str) -> MeshState:
        """State of one mesh.

        Parameters
        ----------
        driver : str
            Name of the driving gear.
        driven : str
            Name of the driven gear.

        Returns
        -------
        MeshState
            Its deflection, force and geometry.

        Raises
        ------
        ChannelError
            If there is no such mesh.
        """
        meshes = [tuple(pair) for pair in self._data["meshes"]]
        if (driver, driven) not in meshes:
            raise ChannelError(f"no mesh of {driver!r} with {driven!r}; there are {meshes}")
        i = meshes.index((driver, driven))
        return MeshState(**{name: float(values[i]) for name, values in self._data["mesh"].items()})

    def __repr__(self) -> str:
        return f"Static({self.state.size} degrees of freedom, {len(self._data['meshes'])} meshes)"
