"""Mass, centre of mass and moments of inertia of the shafts and of the machine."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gearbow._read_only import ReadOnly
from gearbow._result import Column, Result
from gearbow._types import Array
from gearbow.units.speed import SpeedUnit


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
        cls, names: Sequence[str], found: Sequence[Sequence[float]], origins: Sequence[Array]
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

    def _heading(self, speed_unit: SpeedUnit) -> list[str]:  # noqa: ARG002  # no speeds
        return ["mass properties of the shafts with sleeves, gears and disks"]

    def _columns(self) -> list[Column]:
        """Give a row for each shaft, and one for the machine about axes through its centre."""
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
