"""Access to the recorded signals of a run by name and place."""

from gearbow._convert import text
from gearbow._times import begin_after
from gearbow._types import Array
from gearbow.errors import ChannelError
from gearbow.recording.contact import (
    Contact,
    ContactShares,
    MeshScene,
    contact_at,
    first_contact,
    shares,
)
from gearbow.recording.energy import EnergyBalance
from gearbow.recording.motion import MotionRecording
from gearbow.recording.record import Event, MeshResponse

__all__ = ["Recording"]


class Recording(MotionRecording):
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
        found = self._mesh(driver, driven)
        contact = contact_at(self.time, *self._contact(driver, driven, found))
        return MeshResponse(**found, contact=contact)

    def contact_shares(self, driver: str, driven: str, *, skip_time: float = 0.0) -> ContactShares:
        """Find the shares of the time with contact of drive flanks, back flanks, both or none.

        The contact changes at the exact times of the events, also between recorded instants.

        Parameters
        ----------
        driver : str
            Name of the driving gear.
        driven : str
            Name of the driven gear.
        skip_time : float
            Time at the beginning that is ignored [s].

        Returns
        -------
        ContactShares
            The shares between the first and the last recorded time; `ContactShares.lost` is the
            share without contact of the drive flanks. A mesh without backlash is always in contact.

        Raises
        ------
        ChannelError
            If the mesh was not recorded; the message says what to record.
        SceneError
            If `skip_time` is negative or longer than the record.
        """
        begin = begin_after(self.time, skip_time)
        given = self._contact(driver, driven, self._mesh(driver, driven))
        return shares(begin, float(self.time[-1]), *given)

    def _contact(
        self, driver: str, driven: str, found: dict[str, Array]
    ) -> tuple[list[Event], Contact]:
        """Give the events of a mesh, and its contact before the first of them."""
        events = [each for each in self.events if (each.driver, each.driven) == (driver, driven)]
        scene = None if self.request is None else MeshScene.of(self.request, driver, driven)
        return events, first_contact(self.time, found, events, scene)

    def _mesh(self, driver: str, driven: str) -> dict[str, Array]:
        """Give the recorded quantities of a mesh."""
        meshes = [tuple(pair) for pair in self._data["meshes"]]
        driver, driven = text(driver, "driver"), text(driven, "driven")
        if (driven, driver) in meshes:
            raise ChannelError(f"{driven!r} drives {driver!r}: ask for ({driven!r}, {driver!r})")
        if (driver, driven) not in meshes:
            raise self._missing(f"the mesh of {driver!r} with {driven!r}", (driver, driven))
        i = meshes.index((driver, driven))
        return {name: values[:, i] for name, values in self._data["mesh"].items()}

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
        return tuple(Event(*event) for event in self._data["events"])
