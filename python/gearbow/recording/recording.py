"""Access to the recorded signals of a run by name and place."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from gearbow._lookup import locate
from gearbow._read_only import ReadOnly, read_only
from gearbow._types import Array, At, Record, RunData
from gearbow.description.journal import JournalMotion
from gearbow.description.places import place
from gearbow.description.rolling import RollingMotion
from gearbow.description.speed import SpeedProfile
from gearbow.errors import ChannelError
from gearbow.recording.energy import EnergyBalance
from gearbow.recording.record import Event, MeshResponse, RunRecord, Statistics

if TYPE_CHECKING:
    from gearbow.description.kinematics import Kinematics
    from gearbow.recording.errors import Errors
    from gearbow.recording.request import RunRequest

__all__ = ["Recording"]


class Recording(ReadOnly):
    """Recorded signals of a run at k times.

    Parameters
    ----------
    data : mapping
        Recorded arrays, events, final state and statistics.
    speed : float or SpeedProfile
        Speed of the reference shaft [rad/s].

    Attributes
    ----------
    time : ndarray, shape (k,)
        Times [s].
    speed : float or SpeedProfile
        Speed of the reference shaft [rad/s].
    statistics : Statistics
        Counts and step lengths of the simulation.
    accuracy : str or None
        What an accuracy level promises for the run; None without a level.
    kinematics : Kinematics or None
        Speed ratios and tooth frequencies, which determine the orders.
    request : RunRequest or None
        Scene and options of the run; None if unknown.
    """

    def __init__(self, data: RunData, speed: float | SpeedProfile) -> None:
        self._data = read_only(data)
        self.time = data["time"]
        self.speed = speed
        self.statistics = Statistics(**data["statistics"])
        self.accuracy: str | None = None
        self.kinematics: Kinematics | None = None
        self.request: RunRequest | None = None
        self._errors: Errors | None = None

    def to_record(self) -> RunRecord:
        """Give the recording as plain data.

        Returns
        -------
        RunRecord
            All data that a file contains.
        """
        return RunRecord(
            self._data, self.speed, self.kinematics, self.accuracy, self.request, self._errors
        )

    @property
    def speeds(self) -> Array:
        """Speed of the reference shaft at the recorded times.

        Returns
        -------
        ndarray, shape (k,)
            Speeds [rad/s].
        """
        if isinstance(self.speed, SpeedProfile):
            return self.speed(self.time)
        return np.full(self.time.shape, self.speed)

    @property
    def final(self) -> Mapping[str, Any]:
        """Final state without rounding; `simulate(initial=...)` continues from it.

        Returns
        -------
        mapping
            Method, time, speed, a known angle of the reference shaft (time [s], angle [rad] and
            its rounding error), and the state variables of the method.
        """
        return dict(self._data["final"])

    @property
    def recorded(self) -> list[Record]:
        """Recorded items, in the form of the argument `record` of `simulate`.

        Returns
        -------
        list of str or tuple
            Names of gears and disks, (shaft, position), (driver, driven), ("bearing", shaft,
            position), "energy".
        """
        items: list[Record] = []
        for shaft, position, names in self._data["points"]:
            items.extend(names or [(shaft, position)])
        items.extend((driver, driven) for driver, driven in self._data["meshes"])
        items.extend(("bearing", shaft, position) for shaft, position in self._data["bearings"])
        return [*items, "energy"] if self._data["energy"] is not None else items

    def displacement(self, name: At) -> Array:
        """Lateral displacement of a place.

        Parameters
        ----------
        name : str or tuple of (str, float)
            A gear or disk by name, or (shaft, position [m]).

        Returns
        -------
        ndarray, shape (k, 2)
            Displacements v and w [m].

        Raises
        ------
        ChannelError
            If it was not recorded; the message says what to record.
        """
        return self._data["displacement"][:, self._point(name)]

    def twist(self, name: At) -> Array:
        """Twist of a place, relative to the rigid-body rotation.

        Parameters
        ----------
        name : str or tuple of (str, float)
            A gear or disk by name, or (shaft, position [m]).

        Returns
        -------
        ndarray, shape (k,)
            Twist about x [rad].

        Raises
        ------
        ChannelError
            If it was not recorded; the message says what to record.
        """
        return self._data["twist"][:, self._point(name)]

    def axial(self, name: At) -> Array:
        """Axial displacement of a place.

        Parameters
        ----------
        name : str or tuple of (str, float)
            A gear or disk by name, or (shaft, position [m]).

        Returns
        -------
        ndarray, shape (k,)
            Displacement u along x [m].

        Raises
        ------
        ChannelError
            If it was not recorded; the message says what to record. If the system has no axial
            motion.
        """
        point = self._point(name)
        return self._axial("axial")[:, point]

    def axial_bearing_force(self, shaft: str, position: float) -> Array:
        """Force of a shaft on a bearing along the axis.

        Parameters
        ----------
        shaft : str
            Name of the shaft.
        position : float
            Position of the bearing [m].

        Returns
        -------
        ndarray, shape (k,)
            Component along x [N].

        Raises
        ------
        ChannelError
            If it was not recorded; the message says what to record. If the system has no axial
            motion.
        """
        bearing = self._bearing(shaft, position)
        return self._axial("axial_bearing_force")[:, bearing]

    def bearing_force(self, shaft: str, position: float) -> Array:
        """Force of a shaft on a bearing.

        Parameters
        ----------
        shaft : str
            Name of the shaft.
        position : float
            Position of the bearing [m].

        Returns
        -------
        ndarray, shape (k, 2)
            Components along y and z [N].

        Raises
        ------
        ChannelError
            If it was not recorded; the message says what to record.
        """
        return self._data["bearing_force"][:, self._bearing(shaft, position)]

    def bearing_displacement(self, shaft: str, position: float) -> Array:
        """Displacement of a shaft relative to what its bearing stands on.

        A proximity probe in the bearing housing measures it.

        Parameters
        ----------
        shaft : str
            Name of the shaft.
        position : float
            Position of the bearing [m].

        Returns
        -------
        ndarray, shape (k, 2)
            Components along y and z [m].

        Raises
        ------
        ChannelError
            If it was not recorded; the message says what to record.
        """
        bearing = self._bearing(shaft, position)
        found = self._data.get("bearing_displacement")
        if found is None:
            raise ChannelError("the file of this run has no displacements at bearings; run again")
        return found[:, bearing]

    def journal(self, shaft: str, position: float) -> JournalMotion:
        """Time history of a journal bearing.

        Parameters
        ----------
        shaft : str
            Name of the shaft.
        position : float
            Position of the bearing [m].

        Returns
        -------
        JournalMotion
            Force, eccentricity ratio and attitude angle.

        Raises
        ------
        ChannelError
            If the bearing was not recorded, or is no journal bearing of a known scene.
        """
        force, displacement = (
            self.bearing_force(shaft, position),
            self.bearing_displacement(shaft, position),
        )
        bearings = () if self.request is None else self.request.description.get("bearings", ())
        return JournalMotion.of(bearings, (shaft, position), displacement, force)

    def rolling(self, shaft: str, position: float) -> RollingMotion:
        """Time history of a rolling bearing.

        Parameters
        ----------
        shaft : str
            Name of the shaft.
        position : float
            Position of the bearing [m].

        Returns
        -------
        RollingMotion
            Force, number of loaded elements and largest contact force.

        Raises
        ------
        ChannelError
            If the bearing was not recorded, or is no rolling bearing.
        """
        force = self.bearing_force(shaft, position)
        places = self._data["rolling_bearings"]
        i = locate(places, shaft, position)
        if i is None:
            raise ChannelError(
                f"no rolling bearing at ({shaft!r}, {position:g}); there are {places}"
            )
        return RollingMotion(force, *np.moveaxis(self._data["rolling_contact"][:, i], -1, 0))

    def mesh(self, driver: str, driven: str) -> MeshResponse:
        """Time history of one mesh.

        Parameters
        ----------
        driver : str
            Name of the driving gear.
        driven : str
            Name of the driven gear.

        Returns
        -------
        MeshResponse
            Force and deflection, and the geometry of the moving centres.

        Raises
        ------
        ChannelError
            If it was not recorded; the message says what to record.
        """
        meshes = [tuple(pair) for pair in self._data["meshes"]]
        if (driven, driver) in meshes:
            raise ChannelError(f"{driven!r} drives {driver!r}: ask for ({driven!r}, {driver!r})")
        if (driver, driven) not in meshes:
            raise self._missing(f"the mesh of {driver!r} with {driven!r}", (driver, driven))
        i = meshes.index((driver, driven))
        return MeshResponse(**{name: values[:, i] for name, values in self._data["mesh"].items()})

    @property
    def energy(self) -> Array:
        """Kinetic energy of the vibration plus elastic energy of shafts, bearings and meshes.

        Returns
        -------
        ndarray, shape (k,)
            Energy [J].

        Raises
        ------
        ChannelError
            If it was not recorded; the message says what to record.
        """
        energy = self._data["energy"]
        if energy is None:
            raise self._missing("the energy", "energy")
        return energy

    def energy_balance(self) -> EnergyBalance:
        """Compare the energies of the system with the work done on it.

        Returns
        -------
        EnergyBalance
            The terms, their sums, and the residual, which is the integration error.

        Raises
        ------
        ChannelError
            If the energy was not recorded; the message says what to record.
        """
        terms = self._data["energy_terms"]
        if terms is None:
            raise self._missing("the energy balance", "energy")
        return EnergyBalance(time=self.time, **terms)

    @property
    def events(self) -> tuple[Event, ...]:
        """Changes of the tooth contact.

        A change of the contact mode ("contact", "back contact", "separation", "tight") is an event
        only after the start of the run. The contact mode at the start is not an event, even if
        flanks that touch at the start separate or press immediately.

        Returns
        -------
        tuple of Event
            In the order of detection. A mesh with backlash or time-varying stiffness has all its
            events, recorded or not. Other meshes have the events that their recorded instants
            show.
        """
        return tuple(Event(*event) for event in self._data["events"])

    def _point(self, name: At) -> int:
        points = self._data["points"]
        name = place(name, "name")
        if isinstance(name, str):
            for i, (_, _, names) in enumerate(points):
                if name in names:
                    return i
        else:
            found = locate([(shaft, x) for shaft, x, _ in points], *name)
            if found is not None:
                return found
        raise self._missing(f"the motion of {name!r}", name)

    def _bearing(self, shaft: str, position: float) -> int:
        i = locate(self._data["bearings"], shaft, position)
        if i is None:
            raise self._missing(
                f"the bearing force at ({shaft!r}, {position:g})", ("bearing", shaft, position)
            )
        return i

    def _axial(self, name: Literal["axial", "axial_bearing_force"]) -> Array:
        found = self._data.get(name)
        if found is None:
            raise ChannelError(
                "the system has no axial motion; helical gears, axial forces and bearings with "
                "axial_stiffness cause it"
            )
        return found

    def _missing(self, what: str, record: Record) -> ChannelError:
        recorded = ", ".join(repr(item) for item in self.recorded) or "nothing"
        return ChannelError(
            f"{what} was not recorded; give record=[{record!r}, ...] to simulate "
            f"(recorded: {recorded})"
        )
