"""What a simulation recorded, and the state from which it can go on."""

import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from gearbow._describe import place, places
from gearbow._extras import extra
from gearbow._lookup import locate
from gearbow._read_only import ReadOnly, read_only
from gearbow._types import Array, At, Record, RunData
from gearbow.energy import EnergyBalance
from gearbow.errors import ChannelError, GearbowError
from gearbow.orders.fit import Orders, orders
from gearbow.orders.spectrum import Spectrum, spectrum
from gearbow.speed import SpeedProfile

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr
    from matplotlib.figure import Figure

    from gearbow.orders.kinematics import Kinematics

__all__ = ["Event", "MeshResponse", "Response", "Statistics"]


class Event(NamedTuple):
    """A change in what a mesh does, at the instant at which it was found.

    Parameters
    ----------
    time : float
        Time [s].
    driver : str
        Name of the driving gear.
    driven : str
        Name of the driven gear.
    kind : str
        "contact" (the driving flanks meet), "back contact" (those behind them do), "separation"
        (the teeth part), "tight" (both flanks press), "contact ratio below 1", "contact ratio above
        1" (again), "tip interference" (a tip reaches the root circle of the other gear), "tip
        clearance" (it no longer does), "involute interference" (a tip reaches beyond the base
        circle of the other gear, which shortens the path of contact) or "involute clearance" (it
        no longer does).
    """

    time: float
    driver: str
    driven: str
    kind: str


@dataclass(frozen=True, eq=False)
class MeshResponse(ReadOnly):
    """Time history of one mesh, each field at the k times of the response.

    Parameters
    ----------
    deflection : ndarray, shape (k,)
        Mesh deflection along the line of action [m].
    force : ndarray, shape (k,)
        Mesh force [N].
    stiffness : ndarray, shape (k,)
        Mesh stiffness [N/m].
    pressure_angle : ndarray, shape (k,)
        Operating pressure angle of the moving centres [rad]. NaN where the base circles overlap, in
        frozen geometry.
    centre_distance : ndarray, shape (k,)
        Distance of the moving centres [m].
    centre_line_angle : ndarray, shape (k,)
        Angle of the line of centres, driver to driven, from y towards z [rad].
    contact_ratio : ndarray, shape (k,)
        Contact ratio at the moving centres, NaN where the base circles overlap.
    pairs_in_contact : ndarray, shape (k,)
        Number of tooth pairs that carry load.
    """

    deflection: Array
    force: Array
    stiffness: Array
    pressure_angle: Array
    centre_distance: Array
    centre_line_angle: Array
    contact_ratio: Array
    pairs_in_contact: Array


@dataclass(frozen=True)
class Statistics:
    """What a simulation cost.

    Parameters
    ----------
    steps : int
        Accepted steps.
    rejected : int
        Rejected steps.
    evaluations : int
        Evaluations of the right-hand side.
    events : int
        Events that ended a step.
    step_min : float
        Smallest step [s].
    step_max : float
        Largest step [s].
    omega_max : float
        Largest natural frequency of the model [rad/s], which bounds the step of an explicit method.
    limited_by : str
        What set the length of most steps: "step" (as given), "stability", "tolerance", "cycle"
        (the longest step that resolves what is prescribed) or "events" (of the teeth).
    condition : float
        Condition number of the modes that carried the motion; NaN for a method that uses none.
    """

    steps: int
    rejected: int
    evaluations: int
    events: int
    step_min: float
    step_max: float
    omega_max: float
    limited_by: str
    condition: float

    def __getitem__(self, name: str) -> Any:
        return getattr(self, name)

    def __iter__(self) -> Iterator[str]:
        return iter(self.__dataclass_fields__)


class Response:
    """Motion of a system at k times, made by `gearbow.RotorSystem.simulate`.

    Parameters
    ----------
    data : mapping
        What the core recorded.
    speed : float or SpeedProfile
        Speed of the reference shaft [rad/s].

    Attributes
    ----------
    time : ndarray, shape (k,)
        Times [s].
    speed : float or SpeedProfile
        Speed of the reference shaft [rad/s].
    statistics : Statistics
        What the simulation cost.
    expected_error : float or None
        What error to expect of a run with `accuracy=`: RMS of the error over the RMS of the swing.
    accuracy : str or None
        Why: which setting it was, and what its error was measured on.
    kinematics : Kinematics or None
        What the orders of the train follow from.

    Examples
    --------
    >>> import gearbow as gb
    >>> bow = gb.Bow.half_sine(1e-4)
    >>> rotor = gb.Shaft("rotor", length=1.0, outer_diameter=0.05, elements=4, bow=bow)
    >>> bearings = [gb.Bearing("rotor", x, stiffness=1e8) for x in (0.0, 1.0)]
    >>> system = gb.RotorSystem(shafts=[rotor], bearings=bearings)
    >>> middle = ("rotor", 0.5)
    >>> options = {"speed": 100.0, "output_step": 1e-3, "record": [middle]}
    >>> response = system.simulate(0.1, **options)
    >>> response.displacement(middle).shape
    (101, 2)
    >>> further = system.simulate(0.1, initial=response, **options)
    >>> print(f"{further.time[0]:g} s to {further.time[-1]:g} s")
    0.1 s to 0.2 s
    """

    def __init__(self, data: RunData, speed: float | SpeedProfile) -> None:
        self._data = read_only(data)
        self.time = data["time"]
        self.speed = speed
        self.statistics = Statistics(**data["statistics"])
        self.expected_error: float | None = None
        self.accuracy: str | None = None
        self.kinematics: Kinematics | None = None

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
        """State at the end, to the last bit: `simulate(initial=...)` continues from it.

        Returns
        -------
        mapping
            The method and time, the speed, an angle of the reference shaft that is known (time [s]
            and angle [rad] with the digits that rounding took), and the state as that method keeps
            it.
        """
        return dict(self._data["final"])

    @property
    def recorded(self) -> list[Record]:
        """What there is, in the words of the `record` of a simulation.

        Returns
        -------
        list of str or tuple
            Names of gears and disks, (shaft, position), (driver, driven), ("bearing", shaft,
            position), "energy".
        """
        there: list[Record] = []
        for shaft, position, names in self._data["points"]:
            there.extend(names or [(shaft, position)])
        there.extend((driver, driven) for driver, driven in self._data["meshes"])
        there.extend(("bearing", shaft, position) for shaft, position in self._data["bearings"])
        return [*there, "energy"] if self._data["energy"] is not None else there

    def displacement(self, name: At) -> Array:
        """Lateral displacement somewhere.

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
            If it was not recorded; the text says what to record.
        """
        return self._data["displacement"][:, self._point(name)]

    def twist(self, name: At) -> Array:
        """Twist somewhere, from the uniform spin.

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
            If it was not recorded; the text says what to record.
        """
        return self._data["twist"][:, self._point(name)]

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
        ndarray, shape (k, 2)
            Components along y and z [N].

        Raises
        ------
        ChannelError
            If it was not recorded; the text says what to record.
        """
        i = locate(self._data["bearings"], shaft, position)
        if i is None:
            raise self._missing(
                f"the bearing force at ({shaft!r}, {position:g})", ("bearing", shaft, position)
            )
        return self._data["bearing_force"][:, i]

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
            Force, deflection and geometry, always those of the moving centres.

        Raises
        ------
        ChannelError
            If it was not recorded; the text says what to record.
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
        """Kinetic energy beside the spin, and elastic energy of shafts, bearings and meshes.

        Returns
        -------
        ndarray, shape (k,)
            Energy [J].

        Raises
        ------
        ChannelError
            If it was not recorded; the text says what to record.
        """
        energy = self._data["energy"]
        if energy is None:
            raise self._missing("the energy", "energy")
        return energy

    def energy_balance(self) -> EnergyBalance:
        """Hold the energies of the system against the work that was done on it.

        Returns
        -------
        EnergyBalance
            The terms, their sums, and what the integration lost or gained.

        Raises
        ------
        ChannelError
            If the energy was not recorded; the text says what to record.
        """
        terms = self._data["energy_terms"]
        if terms is None:
            raise self._missing("the energy balance", "energy")
        return EnergyBalance(time=self.time, **terms)

    @property
    def events(self) -> tuple[Event, ...]:
        """What the meshes did between the recorded times: contact, separation, loss of overlap.

        A change of the contact mode ("contact", "back contact", "separation", "tight") is an event
        only after the start of the run. The mode at the start, flanks that touch there and part or
        press at once included, is not an event.

        Returns
        -------
        tuple of Event
            In the order in which they were found: those of meshes that have backlash or a stiffness
            that varies, recorded or not, and of other meshes what their recorded instants show.
        """
        return tuple(Event(*event) for event in self._data["events"])

    def spectrum(
        self, of: Record, quantity: str | None = None, *, window: str = "hann"
    ) -> Spectrum:
        """Take the amplitude spectrum of one recorded signal.

        What is faster than half of the recording rate folds back onto slower lines: record with an
        `output_step` that is short enough for the fastest vibration of the signal.

        Parameters
        ----------
        of : str or tuple
            A gear or disk, (shaft, position [m]), (driver, driven), ("bearing", shaft,
            position [m]) or "energy".
        quantity : str, optional
            "v", "w" or "twist" of a place, "y" or "z" of the force on a bearing, a field of
            `MeshResponse`; None is the first of these, or the force of a mesh.
        window : {"hann", "flat top", "none"}
            What weighs the times: "flat top" reads amplitudes best, "none" is for a record that
            holds whole periods.

        Returns
        -------
        Spectrum
            Amplitudes over frequency.

        Raises
        ------
        ChannelError
            If it was not recorded.
        GearbowError
            If the times are not equally spaced.
        """
        return spectrum(self, of, quantity, window=window)

    def orders(
        self,
        of: Record,
        quantity: str | None = None,
        *,
        shaft_harmonics: int = 4,
        mesh_harmonics: int = 3,
        sidebands: int = 1,
        skip_time: float = 0.0,
    ) -> Orders:
        """Find the amplitude of one recorded signal at the orders of shafts and meshes.

        Parameters
        ----------
        of : str or tuple
            What the signal belongs to, as for `spectrum`.
        quantity : str, optional
            Which quantity of it, as for `spectrum`.
        shaft_harmonics, mesh_harmonics : int
            How many harmonics of each shaft and of each tooth frequency.
        sidebands : int
            How many on either side of a tooth frequency, from each of the two shafts.
        skip_time : float
            Time at the beginning that is left out [s].

        Returns
        -------
        Orders
            Complex amplitudes by least squares, with the names of all that excites them.

        Raises
        ------
        ChannelError
            If it was not recorded.
        GearbowError
            If the speed changes, or the record is too short to tell the orders apart or too
            coarse for the highest.
        """
        return orders(
            self,
            of,
            quantity,
            shaft_harmonics=shaft_harmonics,
            mesh_harmonics=mesh_harmonics,
            sidebands=sidebands,
            skip_time=skip_time,
        )

    def plot(self, kind: str = "orbits", names: At | Sequence[At] | None = None) -> "Figure":
        """Draw what was recorded.

        Parameters
        ----------
        kind : {"orbits", "history", "twist", "mesh", "spectrum"}
            The paths of the centres, displacement or twist against time, the geometry of the meshes
            (contact ratio, pressure angle and angle of the line of centres), or the amplitude
            spectrum of the displacement.
        names : str, tuple or sequence of them, optional
            What to draw: gears, disks or (shaft, position [m]), or pairs (driver, driven) for
            "mesh"; one or several. None is all that has a name, or else all that there is.

        Returns
        -------
        matplotlib.figure.Figure
            The figure; it is shown or saved by the caller.

        Raises
        ------
        GearbowError
            If the kind is unknown, or nothing was recorded that it could draw.
        """
        with extra("plot"):
            from gearbow import plots  # noqa: PLC0415

        if kind not in plots.KINDS:
            raise GearbowError(f"kind: must be one of {', '.join(plots.KINDS)}, got {kind!r}")
        return plots.KINDS[kind](self, None if names is None else places(names, "names"))

    def to_dataframe(self) -> "pd.DataFrame":
        """Give everything as one table.

        Returns
        -------
        pandas.DataFrame
            Rows by time [s]; columns with their unit, e.g. "g1 v [m]", "g1/g2 force [N]".
        """
        from gearbow import storage  # noqa: PLC0415  # it imports this module

        return storage.to_dataframe(self)

    def to_xarray(self) -> "xr.Dataset":
        """Give everything as one labelled data set.

        Returns
        -------
        xarray.Dataset
            Variables over time, point, axis, mesh and bearing, each with its unit as an attribute.
        """
        from gearbow import storage  # noqa: PLC0415  # it imports this module

        return storage.to_xarray(self)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write everything to a file; what `load` reads back is the same to the last bit.

        Parameters
        ----------
        path : str or path-like
            A name that ends with ".npz" (NumPy) or ".nc" (netCDF; needs the extra "netcdf").

        Raises
        ------
        GearbowError
            If the name ends otherwise.
        MissingExtraError
            If the extra that the format needs is not installed.
        OSError
            If the file cannot be written, for example on a full disk. A file that was there is
            unchanged.
        """
        from gearbow import storage  # noqa: PLC0415  # stands upon this module

        storage.save(self, path)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> "Response":
        """Read a file that `save` wrote.

        Parameters
        ----------
        path : str or path-like
            A name that ends with ".npz" or ".nc".

        Returns
        -------
        Response
            The response; a simulation can continue from it.

        Raises
        ------
        GearbowError
            If the file is damaged or holds something else; the text names the file and the
            problem. This is found before memory is allocated for what the file declares.
        OSError
            If the file cannot be opened.
        """
        from gearbow import storage  # noqa: PLC0415  # stands upon this module

        return storage.load(path)

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

    def _missing(self, what: str, record: Record) -> ChannelError:
        there = ", ".join(repr(item) for item in self.recorded) or "nothing"
        return ChannelError(
            f"{what} was not recorded; give record=[{record!r}, ...] to simulate "
            f"(recorded: {there})"
        )

    def __repr__(self) -> str:
        data = self._data
        span = f"{self.time[0]:g} s to {self.time[-1]:g} s" if self.time.size else "empty"
        return (
            f"Response({self.time.size} times, {span}; {len(data['points'])} points, "
            f"{len(data['meshes'])} meshes, {len(data['bearings'])} bearings)"
        )
