"""Motion and forces at places: the methods with an argument `at` that results have in common."""

from abc import abstractmethod
from typing import Any, Generic, TypeVar

from gearbow._keywords import CheckedMethods
from gearbow._types import At
from gearbow.recording.access import BearingMotion

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
        ChannelError
            If a run did not record it; the message says what to record.
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
        ChannelError
            If a run did not record it; the message says what to record.
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
            Components along y and z [N].

        Raises
        ------
        ChannelError
            If there is no such bearing, or a run did not record it.
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

        Raises
        ------
        ChannelError
            If there is no such bearing, or a run did not record it.
        """
        return self._at("bearing_displacement", at)  # type: ignore[no-any-return]


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

        Raises
        ------
        ChannelError
            If there is no such bearing, or a run did not record it.
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

        Raises
        ------
        ChannelError
            If there is no such journal bearing, or a run did not record it.
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

        Raises
        ------
        GearbowError
            As for `displacement`.
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

        Raises
        ------
        GearbowError
            As for `displacement`.
        """
        return self._at("acceleration", at)  # type: ignore[no-any-return]
