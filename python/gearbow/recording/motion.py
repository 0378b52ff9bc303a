"""Access to the recorded motion of places."""

from gearbow._lookup import locate
from gearbow._types import Array, At
from gearbow.description.places import is_place, place
from gearbow.recording.bearings import BearingRecording
from gearbow.recording.tables import optional_arrays

__all__ = ["MotionRecording"]


class MotionRecording(BearingRecording):
    """Recorded motion of the places of a run."""

    def displacement(self, name: At) -> Array:
        """Lateral displacement of a place.

        Parameters
        ----------
        name : str or tuple of (str, float)
            Name of a gear, disk, support, housing or point of a housing, or (shaft, position [m]).

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
            Name of a gear, disk, support, housing or point of a housing, or (shaft, position [m]).

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
            Name of a gear, disk, support, housing or point of a housing, or (shaft, position [m]).

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

    def velocity(self, name: At) -> Array:
        """Lateral velocity of a place.

        It belongs to the state of the run; no difference of displacements is taken.

        Parameters
        ----------
        name : str or tuple of (str, float)
            Name of a gear, disk, support, housing or point of a housing, or (shaft, position [m]).

        Returns
        -------
        ndarray, shape (k, 2)
            Velocities of v and w [m/s].

        Raises
        ------
        ChannelError
            If it was not recorded; the message says what to record.
        """
        return self._rate("velocity", name)

    def twist_rate(self, name: At) -> Array:
        """Rate of the twist of a place: its angular velocity beyond the prescribed one.

        Parameters
        ----------
        name : str or tuple of (str, float)
            Name of a gear or disk, or (shaft, position [m]).

        Returns
        -------
        ndarray, shape (k,)
            Rate of the twist about x [rad/s].

        Raises
        ------
        ChannelError
            If it was not recorded; the message says what to record.
        """
        return self._rate("twist_rate", name)

    def acceleration(self, name: At) -> Array:
        """Lateral acceleration of a place.

        It follows from the state and the equation of motion; no difference is taken. If the run
        leaves out modes, it is the acceleration of the reduced model.

        Parameters
        ----------
        name : str or tuple of (str, float)
            Name of a gear, disk, support, housing or point of a housing, or (shaft, position [m]).

        Returns
        -------
        ndarray, shape (k, 2)
            Accelerations of v and w [m/s²].

        Raises
        ------
        ChannelError
            If it was not recorded; the message says what to record.
        """
        return self._rate("acceleration", name)

    def axial_velocity(self, name: At) -> Array:
        """Axial velocity of a place.

        It belongs to the state of the run; no difference of displacements is taken.

        Parameters
        ----------
        name : str or tuple of (str, float)
            Name of a gear, disk, support, housing or point of a housing, or (shaft, position [m]).

        Returns
        -------
        ndarray, shape (k,)
            Velocity of u [m/s].

        Raises
        ------
        ChannelError
            If it was not recorded; the message says what to record. If the system has no axial
            motion.
        """
        return self._rate("axial_velocity", name)

    def axial_acceleration(self, name: At) -> Array:
        """Axial acceleration of a place.

        It follows from the state and the equation of motion; no difference is taken. If the run
        leaves out modes, it is the acceleration of the reduced model.

        Parameters
        ----------
        name : str or tuple of (str, float)
            Name of a gear, disk, support, housing or point of a housing, or (shaft, position [m]).

        Returns
        -------
        ndarray, shape (k,)
            Acceleration of u [m/s²].

        Raises
        ------
        ChannelError
            If it was not recorded; the message says what to record. If the system has no axial
            motion.
        """
        return self._rate("axial_acceleration", name)

    def _rate(self, array: str, name: At) -> Array:
        point = self._point(name)
        if array.startswith("axial"):
            self._axial("axial")
        found = optional_arrays(self._data).get(array)
        if found is None:
            group = "acceleration" if array.endswith("acceleration") else "velocity"
            what = f"the {array.replace('_', ' ')} of {name!r}"
            raise self._missing(what, group)
        return found[:, point]

    def _point(self, name: At) -> int:
        points = self._data["points"]
        name = place(name, "name")
        if isinstance(name, str):
            for i, (_, _, names) in enumerate(points):
                if name in names:
                    return i
        elif is_place(name):
            found = locate([(shaft, x) for shaft, x, _ in points], *name)
            if found is not None:
                return found
        raise self._missing(f"the motion of {name!r}", name)
