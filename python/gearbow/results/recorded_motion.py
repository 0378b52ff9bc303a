"""Recorded signals of a run, found by place."""

from abc import abstractmethod
from collections.abc import Mapping
from typing import Any, get_args

from numpy.typing import ArrayLike

from gearbow._types import Array, At, Record, RunData
from gearbow.recording import access
from gearbow.recording.access import BearingMotion
from gearbow.recording.contact import ContactShares
from gearbow.recording.energy import EnergyBalance
from gearbow.recording.record import Event, MeshResponse, RunRecord
from gearbow.results.at_places import AxialMotion, Vibration


class RecordedMotion(AxialMotion[Array, Array], Vibration[Array, Array]):
    """Signals of a recorded run at k times."""

    _data: RunData

    @abstractmethod
    def to_record(self) -> RunRecord:
        """Give the recording as plain data."""

    @property
    def time(self) -> Array:
        """Recorded times.

        Returns
        -------
        ndarray, shape (k,)
            Times [s].
        """
        return self._data["time"]

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
            position), "velocity", "acceleration", "energy".
        """
        return self.to_record().recorded

    @property
    def speeds(self) -> Array:
        """Speed of the reference shaft at the recorded times.

        Returns
        -------
        ndarray, shape (k,)
            Speeds [rad/s].
        """
        return access.speeds(self.to_record())

    def angle(self, shaft: str, times: "ArrayLike | None" = None) -> Array:
        """Prescribed angle of a shaft, without its twist.

        Parameters
        ----------
        shaft : str
            Name of the shaft.
        times : array_like, shape (n,), optional
            Times [s]; None is the k recorded times.

        Returns
        -------
        ndarray, shape (k,) or (n,)
            Angle about x, not reduced to one revolution [rad].

        Raises
        ------
        ChannelError
            If there is no such shaft, or the response has no kinematics.
        """
        return access.angle(self.to_record(), shaft, times)

    def spin(self, shaft: str, times: "ArrayLike | None" = None) -> Array:
        """Prescribed angular velocity of a shaft.

        Parameters
        ----------
        shaft : str
            Name of the shaft.
        times : array_like, shape (n,), optional
            Times [s]; None is the k recorded times.

        Returns
        -------
        ndarray, shape (k,) or (n,)
            Angular velocity about x [rad/s].
        """
        return access.spin(self.to_record(), shaft, times)

    def _at(self, quantity: str, at: Any) -> Any:
        record = self.to_record()
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

    def rolling(self, at: tuple[str, float]) -> BearingMotion:
        """Time history of a rolling bearing.

        Parameters
        ----------
        at : tuple of (str, float)
            Shaft and position of the bearing [m].

        Returns
        -------
        BearingMotion
            Force, number of loaded elements and largest contact force.
        """
        return access.rolling(self.to_record(), at)

    def mesh(self, at: str | tuple[str, str]) -> MeshResponse:
        """Time history of one mesh.

        Parameters
        ----------
        at : tuple of (str, str) or str
            The two gears, (driver, driven) in either order, or "driver/driven".

        Returns
        -------
        MeshResponse
            Force and deflection, and the geometry of the moving centres.
        """
        return access.mesh(self.to_record(), at)

    def contact_shares(self, at: str | tuple[str, str], *, skip_time: float = 0.0) -> ContactShares:
        """Find the shares of the time with contact of drive flanks, back flanks, both or none.

        The contact changes at the exact times of the events, also between recorded instants.

        Parameters
        ----------
        at : tuple of (str, str) or str
            The mesh, as for `mesh`.
        skip_time : float
            Time at the beginning that is ignored [s].

        Returns
        -------
        ContactShares
            The shares between the first and the last recorded time; `ContactShares.lost` is the
            share without contact of the drive flanks. A mesh without backlash is always in contact.

        Raises
        ------
        SceneError
            If `skip_time` is negative or longer than the record.
        """
        return access.contact_shares(self.to_record(), at, skip_time)

    @property
    def energy(self) -> Array:
        """Kinetic energy of the vibration plus elastic energy of shafts, bearings and meshes.

        Returns
        -------
        ndarray, shape (k,)
            Energy [J].
        """
        return access.energy(self.to_record())

    def energy_balance(self) -> EnergyBalance:
        """Compare the energies of the system with the work done on it.

        Returns
        -------
        EnergyBalance
            The terms, their sums, and the residual, which is the integration error.
        """
        return access.energy_balance(self.to_record())

    @property
    def events(self) -> tuple[Event, ...]:
        """Contact events of the teeth.

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
        return access.events(self.to_record())
