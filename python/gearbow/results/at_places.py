"""Motion and forces at places: the methods with an argument `at` that results have in common."""

from abc import abstractmethod
from collections.abc import Mapping
from typing import Any, Generic, TypeVar, get_args

from gearbow._convert import CheckedMethods, one_of
from gearbow._types import Array, At, Record, RunData, Side
from gearbow.recording import access
from gearbow.recording.access import BearingMotion
from gearbow.recording.record import Event, RunRecord
from gearbow.results.section_forces import SectionForces, recorded_forces

#: Arrays of vectors, and of numbers.
V = TypeVar("V")
S = TypeVar("S")


class Motion(CheckedMethods, Generic[V, S]):
    """Displacements of places; the first axes of all values are those of the result."""

    @abstractmethod
    def _at(self, quantity: str, at: Any) -> Any:
        """Give a quantity of a place, which has the name of its method."""

    def displacement(self, at: At) -> V:
        """Lateral displacement of a place.

        Parameters
        ----------
        at : str or tuple of (str, float)
            A gear, disk, support, housing or point of a housing by name, or (shaft, position [m]),
            in results of linear analyses also between nodes.

        Returns
        -------
        ndarray, shape (..., 2)
            Displacements along y and z [m], of modes in the unit of `shapes`.

        Raises
        ------
        GearbowError
            If there is no such place, or the system has no lateral motion.
        """
        return self._at("displacement", at)  # type: ignore[no-any-return]

    def twist(self, at: At) -> S:
        """Twist of a place, relative to the rigid-body rotation.

        Parameters
        ----------
        at : str or tuple of (str, float)
            A gear or disk by name, or (shaft, position [m]), as for `displacement`.

        Returns
        -------
        float or ndarray, shape (...,)
            Twist about x [rad], of modes in the unit of `shapes`.

        Raises
        ------
        GearbowError
            If there is no such place, or the system has no torsion.
        """
        return self._at("twist", at)  # type: ignore[no-any-return]


class LoadedMotion(Motion[V, S]):
    """Displacements of places, and forces on bearings."""

    def bearing_force(self, at: tuple[str, float]) -> V:
        """Force of a shaft on a bearing.

        Parameters
        ----------
        at : tuple of (str, float)
            Shaft and position of the bearing [m].

        Returns
        -------
        ndarray, shape (..., 2)
            Components along y and z [N]; for a planet on a carrier that turns, in the frame of this
            carrier.
        """
        return self._at("bearing_force", at)  # type: ignore[no-any-return]

    def bearing_displacement(self, at: tuple[str, float]) -> V:
        """Displacement of a shaft relative to what its bearing stands on.

        A proximity probe in the bearing housing measures it.

        Parameters
        ----------
        at : tuple of (str, float)
            Shaft and position of the bearing [m].

        Returns
        -------
        ndarray, shape (..., 2)
            Components along y and z [m].
        """
        return self._at("bearing_displacement", at)  # type: ignore[no-any-return]

    def section_forces(self, at: At, side: Side = "before") -> SectionForces:
        """Axial and shear force, bending moment and torque in a section of a shaft.

        Parameters
        ----------
        at : str or tuple of (str, float)
            A gear or disk by name, (shaft, position [m]), or the name of a shaft for all its nodes.
        side : {"before", "beyond"}
            Side of a node, where forces jump by what acts there: just before it or just beyond it.
            At an end of the shaft there is one section, and this choice has no effect.

        Returns
        -------
        SectionForces
            N, Q_y, Q_z, M_y, M_z and T, shape (..., 6); of a whole shaft (..., k, 6).

        Raises
        ------
        ChannelError
            If a run did not record it: record=[..., "section_forces"].
        """
        one_of(side, get_args(Side), "side")
        return self._section_forces(at, side)

    @abstractmethod
    def _section_forces(self, at: At, side: Side) -> SectionForces:
        """Give the section forces."""


class AxialMotion(LoadedMotion[V, S]):
    """Motion and forces of runs and of equilibria, also along the axis."""

    def axial(self, at: At) -> S:
        """Axial displacement of a place, in a system with axial motion.

        Parameters
        ----------
        at : str or tuple of (str, float)
            Place, as for `displacement`.

        Returns
        -------
        float or ndarray, shape (...,)
            Displacement along x [m].

        Raises
        ------
        GearbowError
            If there is no such place, or the system has no axial motion.
        """
        return self._at("axial", at)  # type: ignore[no-any-return]

    def axial_bearing_force(self, at: tuple[str, float]) -> S:
        """Force of a shaft on a bearing along the axis, in a system with axial motion.

        Parameters
        ----------
        at : tuple of (str, float)
            Shaft and position of the bearing [m].

        Returns
        -------
        float or ndarray, shape (...,)
            Component along x [N].
        """
        return self._at("axial_bearing_force", at)  # type: ignore[no-any-return]

    def journal(self, at: tuple[str, float]) -> BearingMotion:
        """Motion of the journal in a journal bearing.

        Parameters
        ----------
        at : tuple of (str, float)
            Shaft and position of the bearing [m].

        Returns
        -------
        BearingMotion
            Force, eccentricity ratio and attitude angle.
        """
        return self._at("journal", at)  # type: ignore[no-any-return]


class Vibration(LoadedMotion[V, S]):
    """Motion with velocities and accelerations."""

    def velocity(self, at: At) -> V:
        """Lateral velocity of a place.

        No difference of displacements is taken: in a run it belongs to the state, and a phasor is
        that of the displacement times iω.

        Parameters
        ----------
        at : str or tuple of (str, float)
            Place, as for `displacement`.

        Returns
        -------
        ndarray, shape (..., 2)
            Velocities along y and z [m/s].
        """
        return self._at("velocity", at)  # type: ignore[no-any-return]

    def acceleration(self, at: At) -> V:
        """Lateral acceleration of a place.

        In a run it follows from the state and the equation of motion; no difference is taken. If
        the run leaves out modes, it is the acceleration of the reduced model.

        Parameters
        ----------
        at : str or tuple of (str, float)
            Place, as for `displacement`.

        Returns
        -------
        ndarray, shape (..., 2)
            Accelerations along y and z [m/s²].
        """
        return self._at("acceleration", at)  # type: ignore[no-any-return]


class RecordedMotion(AxialMotion[Array, Array], Vibration[Array, Array]):
    """Signals of a recorded run at k times."""

    _data: RunData

    @abstractmethod
    def _to_record(self) -> RunRecord:
        """Give the recording as plain data."""

    @property
    def time(self) -> Array:
        """Recorded times [s], shape (k,)."""
        return self._data["time"]

    @property
    def final(self) -> Mapping[str, Any]:
        """Final state without rounding; `simulate(initial=...)` continues from it.

        It has the method, time, speed, a known angle of the reference shaft (time [s], angle [rad]
        and its rounding error), and the state variables of the method.
        """
        return dict(self._data["final"])

    @property
    def recorded(self) -> list[Record]:
        """Recorded items, in the form of the argument `record` of `simulate`.

        These are names of gears and disks, (shaft, position), (driver, driven), ("bearing", shaft,
        position), "velocity", "acceleration", "energy".
        """
        return self._to_record().recorded

    @property
    def speeds(self) -> Array:
        """Speed of the reference shaft at the recorded times [rad/s], shape (k,)."""
        return access.speeds(self._to_record())

    angle = access.angle
    spin = access.spin
    rolling = access.rolling
    mesh = access.mesh
    contact_shares = access.contact_shares
    energy_balance = access.energy_balance

    def _section_forces(self, at: At, side: Side) -> SectionForces:
        return recorded_forces(self._to_record(), at, side)

    def _at(self, quantity: str, at: Any) -> Any:
        record = self._to_record()
        if quantity in get_args(access.Quantity):
            return access.motion(record, quantity, at)  # type: ignore[arg-type]
        return getattr(access, quantity)(record, at)

    def twist_rate(self, at: At) -> Array:
        """Rate of the twist of a place: its angular velocity beyond the prescribed one.

        Parameters
        ----------
        at : str or tuple of (str, float)
            Place, as for `displacement`.

        Returns
        -------
        ndarray, shape (k,)
            Rate of the twist about x [rad/s].
        """
        return self._at("twist_rate", at)  # type: ignore[no-any-return]

    def axial_velocity(self, at: At) -> Array:
        """Axial velocity of a place, in a system with axial motion.

        Parameters
        ----------
        at : str or tuple of (str, float)
            Place, as for `displacement`.

        Returns
        -------
        ndarray, shape (k,)
            Velocity along x [m/s].
        """
        return self._at("axial_velocity", at)  # type: ignore[no-any-return]

    def axial_acceleration(self, at: At) -> Array:
        """Axial acceleration of a place, in a system with axial motion.

        Parameters
        ----------
        at : str or tuple of (str, float)
            Place, as for `displacement`.

        Returns
        -------
        ndarray, shape (k,)
            Acceleration along x [m/s²].
        """
        return self._at("axial_acceleration", at)  # type: ignore[no-any-return]

    @property
    def energy(self) -> Array:
        """Kinetic energy of the vibration plus elastic energy of shafts, bearings and meshes.

        The unit is J, the shape (k,).
        """
        return access.energy(self._to_record())

    @property
    def events(self) -> tuple[Event, ...]:
        """Contact events of the teeth, in the order of detection.

        A change of the contact mode ("contact", "back contact", "separation", "tight") is an event
        only after the start of the run. The contact mode at the start is not an event, even if
        flanks that touch at the start separate or press immediately.

        A mesh with backlash or time-varying stiffness has all its events, recorded or not. Other
        meshes have the events that their recorded instants show.
        """
        return access.events(self._to_record())
