"""Static equilibrium."""

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from gearbow._extras import extra
from gearbow._read_only import ReadOnly, read_only
from gearbow._result import Column, Result, in_micrometres
from gearbow._shown import MOST_ROWS, Shown
from gearbow._types import Array, At, Plain, StaticData
from gearbow.description.coordinates import Coordinates
from gearbow.description.layout import Layout
from gearbow.description.places import Places, place, place_label
from gearbow.errors import ChannelError
from gearbow.recording.bearing_motion import BearingMotion, journal_motion
from gearbow.units.speed import SpeedUnit, speed_text

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["MeshState", "Static"]

#: Size of a displacement that is round-off, relative to the largest one.
_ROUND_OFF = 1e-9


@dataclass(frozen=True)
class MeshState(Shown):
    """State of one mesh at equilibrium."""

    deflection: float
    force: float
    stiffness: float
    pressure_angle: float
    centre_distance: float
    centre_line_angle: float
    contact_ratio: float
    pairs_in_contact: float
    thrust: float


class Static(Result, ReadOnly):
    """Equilibrium under torque, gravity and mesh forces. The rotating bow does not contribute.

    Parameters
    ----------
    data : mapping
        Displacements, mesh states and bearing forces.
    coordinates : Coordinates
        Degrees of freedom of the system.
    bearings : sequence of mapping
        Plain descriptions of the bearings.
    layout : Layout
        Geometry of the train at rest.
    speed : float
        Speed of the reference shaft [rad/s].
    speed_unit : {"rad/s", "rpm"}
        Unit in which it was given.
    geometry : {"live", "frozen"}
        Whether the line of action follows the moving centres or is that at rest.

    Attributes
    ----------
    state : ndarray, shape (n,)
        Displacements of all degrees of freedom [m, rad].
    coordinates : Coordinates
        Degrees of freedom of the system.
    speed : float
        Speed of the reference shaft [rad/s].
    speed_unit : {"rad/s", "rpm"}
        Unit of speeds in tables and figures: that in which the speed was given.
    geometry : {"live", "frozen"}
        Whether the line of action follows the moving centres or is that at rest.

    Examples
    --------
    A shaft of 15.4 kg on two bearings of 1 MN/m sinks by 76 µm:

    >>> import gearbow as gb
    >>> rotor = gb.Shaft("rotor", length=1.0, outer_diameter=0.05)
    >>> bearings = [gb.Bearing("rotor", x, stiffness=1e6) for x in (0.0, 1.0)]
    >>> static = gb.RotorSystem(shafts=[rotor], bearings=bearings, gravity=9.81).static()
    >>> print("{:.0f} N on each, {:.1f} µm".format(
    ...     static.bearing_force(("rotor", 0.0))[1], 1e6 * static.displacement(("rotor", 0.0))[1]))
    -76 N on each, -75.6 µm
    """

    def __init__(
        self,
        data: StaticData,
        coordinates: Coordinates,
        bearings: Sequence[Mapping[str, Plain]] = (),
        *,
        layout: Layout,
        speed: float = 0.0,
        speed_unit: SpeedUnit = "rad/s",
        geometry: str = "live",
    ) -> None:
        self.speed, self.speed_unit, self.geometry = speed, speed_unit, geometry
        self._layout = layout
        self._bearings = tuple(bearings)
        self._data = read_only(data)
        self.state = data["state"]
        self.coordinates = coordinates

    @property
    def residuals(self) -> dict[str, float]:
        """What the forces leave unbalanced on each shaft, support and housing, over its load.

        The forces are evaluated anew at `state`. The unbalanced force is the largest one of all
        degrees of freedom, or of the sums of forces and moments over the shaft; moments are divided
        by the length of the shaft, and those of a housing by that of the longest shaft. The load is
        the sum of the sizes of all forces of weight, torques, bearings, meshes, couplings and other
        loads on the shaft, and at least 1e-6 of the largest load of all. At a degree of freedom the
        round-off of elastic forces, ``8 ε Σ|K||q|`` with ε = 2.2e-16, does not count.

        Returns
        -------
        dict of str to float
            The unbalanced part of the load by name.
        """
        return dict(self._data["residuals"])

    @property
    def residual(self) -> float:
        """Largest value of `residuals`.

        Returns
        -------
        float
            The largest unbalanced part of the load of a shaft, support or housing; usually below
            1e-9, and never above 1e-6.
        """
        return max(self.residuals.values())

    def displacement(self, at: At) -> Array:
        """Lateral displacement of a place.

        Parameters
        ----------
        at : str or tuple of (str, float)
            A gear, disk, support, housing or point of a housing by name, or (shaft, position [m]).

        Returns
        -------
        ndarray, shape (2,)
            Displacements along y and z [m].

        Raises
        ------
        GearbowError
            If there is no such place, or the system has no lateral motion.
        """
        displacement: Array = self.coordinates.displacement(self.state, at)
        return displacement

    def twist(self, at: At) -> float:
        """Twist of a place.

        Parameters
        ----------
        at : str or tuple of (str, float)
            A gear or disk by name, or (shaft, position [m]).

        Returns
        -------
        float
            Twist [rad].

        Raises
        ------
        GearbowError
            If there is no such place, or the system has no twist.
        """
        return float(self.coordinates.twisted(self.state, at))

    def axial(self, at: At) -> float:
        """Axial displacement of a place.

        Parameters
        ----------
        at : str or tuple of (str, float)
            A gear, disk, support, housing or point of a housing by name, or (shaft, position [m]).

        Returns
        -------
        float
            Displacement along x [m].

        Raises
        ------
        GearbowError
            If there is no such place, or the system has no axial motion.
        """
        return float(self.coordinates.axial_displacement(self.state, at))

    def axial_bearing_force(self, at: tuple[str, float]) -> float:
        """Force of a shaft on a bearing along the axis.

        Parameters
        ----------
        at : tuple of (str, float)
            Shaft and position of the bearing [m].

        Returns
        -------
        float
            Component along x [N].

        Raises
        ------
        ChannelError
            If there is no such bearing.
        """
        return float(self._data["axial_bearing_force"][self._bearing(at)])

    def bearing_force(self, at: tuple[str, float]) -> Array:
        """Force of a shaft on a bearing.

        Parameters
        ----------
        at : tuple of (str, float)
            Shaft and position of the bearing [m].

        Returns
        -------
        ndarray, shape (2,)
            Components along y and z [N].
        """
        force: Array = self._data["bearing_force"][self._bearing(at)]
        return force

    def journal(self, at: tuple[str, float]) -> BearingMotion:
        """State of a journal bearing.

        Parameters
        ----------
        at : tuple of (str, float)
            Shaft and position of the bearing [m].

        Returns
        -------
        BearingMotion
            Force, eccentricity ratio and attitude angle.

        Raises
        ------
        ChannelError
            If there is no such journal bearing.
        """
        force = self.bearing_force(at)
        displacement = self._data["bearing_displacement"][self._bearing(at)]
        return journal_motion(self._bearings, place(at), displacement, force)

    def mesh(self, at: str | tuple[str, str]) -> MeshState:
        """State of one mesh.

        Parameters
        ----------
        at : tuple of (str, str) or str
            The two gears, (driver, driven) in either order, or "driver/driven".

        Returns
        -------
        MeshState
            Deflection, force and geometry.

        Raises
        ------
        ChannelError
            If there is no such mesh.
        """
        known = Places("mesh", ([pair] for pair in map(tuple, self._data["meshes"])))
        i = known.find(at)
        if i is None:
            driver, driven = place(at)
            raise ChannelError(f"no mesh of {driver!r} with {driven!r}; there are {known}")
        # The equilibrium contains no friction.
        own = [field.name for field in dataclasses.fields(MeshState)]
        found = {name: float(self._data["mesh"][name][i]) for name in own}
        # The core counts the pairs at one instant, but its stiffness is the mean of a tooth cycle.
        if found["pairs_in_contact"] > 0.0:
            found["pairs_in_contact"] = found["contact_ratio"]
        return MeshState(**found)

    def _bearing(self, at: object) -> int:
        known = Places("bearing", ([at] for at in map(tuple, self._data["bearings"])))
        i = known.find(at)
        if i is None:
            raise ChannelError(f"no bearing at {place(at)}; there are {known}")
        return i

    def __repr__(self) -> str:
        forces = [
            f"{driver}–{driven} {force:.4g} N"
            for (driver, driven), force in zip(
                self._data["meshes"][:MOST_ROWS], self._data["mesh"]["force"], strict=False
            )
        ]
        text = f"{self.state.size} degrees of freedom, {len(self._data['meshes'])} meshes"
        return f"Static({text}{': ' * bool(forces)}{', '.join(forces)})"

    def _heading(self, speed_unit: SpeedUnit) -> list[str]:
        at = f" at {speed_text(self.speed, speed_unit)}" if self.speed else ""
        return [f"static equilibrium{at}; unbalanced part of the load {self.residual:.1e}"]

    def _columns(self) -> list[Column]:
        """Give a row for each mesh, bearing, gear and disk."""
        mesh, none = self._data["mesh"], np.array([np.nan, np.nan])
        rows: list[tuple[str, float, float, Array, float]] = []
        for i, (driver, driven) in enumerate(self._data["meshes"]):
            label, deflection = f"mesh {driver}–{driven}", float(mesh["deflection"][i])
            rows.append((label, float(mesh["force"][i]), np.nan, none, deflection))
        moved = self._data["bearing_displacement"]
        for i, (shaft, x) in enumerate(self._data["bearings"]):
            force = float(np.hypot(*self._data["bearing_force"][i]))
            axial = float(self._data["axial_bearing_force"][i])
            rows.append((f"bearing {place_label((shaft, x))}", force, axial, moved[i], np.nan))
        directions = {direction for *_, direction in self.coordinates.dofs}
        if "v" in directions:
            bodies = self.coordinates.bodies
            rows += [(n, np.nan, np.nan, self.displacement(n), np.nan) for n in bodies]
        displacements = np.array([row[3] for row in rows]).reshape(-1, 2)
        thrusts = np.array([row[2] for row in rows])
        largest = np.abs(np.nan_to_num(thrusts)).max(initial=0.0)
        along = [Column("axial force", thrusts, "N", round_off=_ROUND_OFF * largest)]
        um = in_micrometres()
        given: Any = (".4g", um, _ROUND_OFF * np.abs(np.nan_to_num(displacements)).max(initial=0.0))
        return [
            Column("place", [row[0] for row in rows]),
            Column("force", np.array([row[1] for row in rows]), "N"),
            *(along if "u" in directions else []),
            Column("displacement y", displacements[:, 0], "m", *given),
            Column("displacement z", displacements[:, 1], "m", *given),
            Column("mesh deflection", np.array([row[4] for row in rows]), "m", ".4g", um),
        ]

    def plot(self, *, ax: Any = None) -> "Figure":
        """Draw the deflection of the shafts.

        Parameters
        ----------
        ax : sequence of two Axes, optional
            Panels for the displacements along y and z, or one panel for the twist of a system
            without lateral motion; None makes a new figure.

        Returns
        -------
        matplotlib.figure.Figure
            Displacements along the shafts, with marks at gears and disks.
        """
        with extra("plot"):
            from gearbow.plotting import deflection  # noqa: PLC0415

        return deflection.deflection(self.state, self.coordinates.dofs, self._layout, ax=ax)
