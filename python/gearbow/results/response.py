"""Time response of a system: recorded signals, spectra, orders, figures, tables and files."""

import os
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from gearbow._extras import extra
from gearbow._shown import Table, span
from gearbow._types import At, Record
from gearbow.accuracy.estimate import estimate_errors
from gearbow.description.places import is_pair, place_label, places
from gearbow.errors import GearbowError
from gearbow.orders.fit import Orders, orders
from gearbow.orders.spectrum import Spectrum, amplitudes, spectrum
from gearbow.recording import tables
from gearbow.recording.errors import Errors
from gearbow.recording.record import RunRecord
from gearbow.recording.recording import Recording

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr
    from matplotlib.figure import Figure

__all__ = ["PLOT_KINDS", "Response"]

#: Kinds of figures of `Response.plot`.
PLOT_KINDS = ("orbits", "history", "twist", "mesh", "spectrum")


class Response(Recording):
    """Motion of a system at k times, made by `gearbow.RotorSystem.simulate`.

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

    Examples
    --------
    >>> import gearbow as gb
    >>> bow = gb.Bow.half_sine(1e-4)
    >>> rotor = gb.Shaft("rotor", length=1.0, outer_diameter=0.05, bow=bow)
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

    @classmethod
    def from_record(cls, record: RunRecord) -> "Response":
        """Make a response from plain data, the inverse of `to_record`.

        Parameters
        ----------
        record : RunRecord
            Plain data.

        Returns
        -------
        Response
            The response.
        """
        response = cls(record.data, record.speed)
        response.kinematics, response.accuracy = record.kinematics, record.accuracy
        response.request, response._errors = record.request, record.errors
        return response

    @property
    def errors(self) -> Errors:
        """Estimated error of the run: contributions of elements, modes and integration.

        The error is the RMS of the difference divided by the RMS of the signal about its mean, for
        the worst recorded displacement and the worst recorded mesh force. It applies to the time
        series over the first 0.1 s, or over the time that damping needs to forget, if that is
        longer. Later, phase errors of undamped modes grow, and the error applies to RMS values and
        spectra. After chaotic contact it applies to neither; `Errors.chaotic` is then true.

        The first access runs the system again over this time, with a much smaller tolerance, with
        all modes, and with finer elements. This takes several times as long as a run of this time.
        The result is kept, and saved with the response.

        Returns
        -------
        Errors
            A dictionary with the keys "displacement" and "mesh_force", where such signals were
            recorded and vary. Each value has the attributes `elements`, `modes`, `integration` and
            `total`.

        Raises
        ------
        GearbowError
            If the response does not know its system.
        """
        if self._errors is None:
            if self.request is None:
                raise GearbowError(
                    "errors: this response does not know its system; take the errors of a response "
                    "that simulate returned or that save wrote"
                )
            self._errors = estimate_errors(self.request, self.statistics.modes)
        return self._errors

    def spectrum(
        self, of: Record, quantity: str | None = None, *, window: str = "hann"
    ) -> Spectrum:
        """Find the amplitude spectrum of one recorded signal.

        Frequencies above half of the sampling rate appear as lower frequencies (aliasing). Choose
        an `output_step` that is short enough for the highest frequency of the signal.

        Parameters
        ----------
        of : str or tuple
            A gear or disk, (shaft, position [m]), (driver, driven), ("bearing", shaft,
            position [m]) or "energy".
        quantity : str, optional
            "v", "w", "twist" or "u" of a place, "y", "z" or "x" of the force on a bearing, or a
            field of `MeshResponse`. None is "v", "y" or the mesh force.
        window : {"hann", "flat top", "none"}
            Window function. "flat top" gives the most exact amplitudes, "none" is for a record of
            whole periods.

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
        bearing_harmonics: int = 3,
        skip_time: float = 0.0,
    ) -> Orders:
        """Find the amplitudes of one recorded signal at the orders of shafts and meshes.

        Parameters
        ----------
        of : str or tuple
            Owner of the signal, as for `spectrum`.
        quantity : str, optional
            Quantity, as for `spectrum`.
        shaft_harmonics, mesh_harmonics : int
            Number of harmonics of each shaft and of each tooth frequency.
        sidebands : int
            Number of sidebands on each side of a tooth frequency, for each of the two shafts.
        bearing_harmonics : int
            Number of harmonics of the ball-pass frequency of each rolling bearing; with one or
            more, also the order of the cage.
        skip_time : float
            Time at the beginning that is ignored [s].

        Returns
        -------
        Orders
            Complex amplitudes by least squares, with the names of the excitations.

        Raises
        ------
        ChannelError
            If it was not recorded.
        GearbowError
            If the speed changes, the record is too short to separate the orders, or the output
            step is too long for the highest order.
        """
        return orders(
            self,
            of,
            quantity,
            shaft_harmonics=shaft_harmonics,
            mesh_harmonics=mesh_harmonics,
            sidebands=sidebands,
            bearing_harmonics=bearing_harmonics,
            skip_time=skip_time,
        )

    def plot(self, kind: str = "orbits", names: At | Sequence[At] | None = None) -> "Figure":
        """Draw recorded signals.

        Parameters
        ----------
        kind : {"orbits", "history", "twist", "mesh", "spectrum"}
            Orbits of the centres, displacement or twist against time, geometry of the meshes
            (contact ratio, pressure angle and angle of the line of centres) against time, or
            amplitude spectrum of the displacement.
        names : str, tuple or sequence of them, optional
            Gears, disks or (shaft, position [m]); pairs (driver, driven) for "mesh". None is all
            recorded gears and disks, or all recorded places if there are none.

        Returns
        -------
        matplotlib.figure.Figure
            The figure. It is neither shown nor saved.

        Raises
        ------
        GearbowError
            If the kind is unknown, or no suitable signal was recorded.
        """
        with extra("plot"):
            from gearbow.plotting import response as figures  # noqa: PLC0415

        if kind not in PLOT_KINDS:
            raise GearbowError(f"kind: must be one of {', '.join(PLOT_KINDS)}, got {kind!r}")
        if kind == "mesh":
            geometry = {}
            for pair in self._pairs(names):
                found = self.mesh(*pair)
                angles = (found.pressure_angle, found.centre_line_angle)
                geometry[pair] = (found.contact_ratio, *angles)
            return figures.mesh(self.time, geometry)
        chosen = self._chosen(names)
        if kind == "twist":
            twists = {place_label(at): self.twist(at) for at in chosen}
            return figures.twist(self.time, twists)
        motion = {place_label(at): self.displacement(at) for at in chosen}
        if kind == "spectrum":
            spectra = {label: amplitudes(self.time, values) for label, values in motion.items()}
            return figures.spectrum(spectra)
        return figures.orbits(motion) if kind == "orbits" else figures.history(self.time, motion)

    def to_dataframe(self) -> "pd.DataFrame":
        """Convert all recorded signals to a table.

        Returns
        -------
        pandas.DataFrame
            Rows by time [s]; columns with their unit, e.g. "g1 v [m]", "g1/g2 force [N]".
        """
        return tables.to_dataframe(self.to_record())

    def to_xarray(self) -> "xr.Dataset":
        """Convert everything to a labelled data set.

        Returns
        -------
        xarray.Dataset
            Variables over time, point, axis, mesh and bearing, each with its unit as an attribute.
        """
        return tables.to_xarray(self.to_record())

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write everything to a file without rounding.

        Parameters
        ----------
        path : str or path-like
            The file. Its name ends with ".npz" (NumPy) or ".nc" (netCDF, needs the extra "netcdf").

        Raises
        ------
        GearbowError
            If the name has another ending.
        MissingExtraError
            If the extra that the format needs is not installed.
        OSError
            If the file cannot be written, for example on a full disk. An existing file is
            unchanged.
        """
        from gearbow.recording import file  # noqa: PLC0415  # only files need its libraries

        file.save(self.to_record(), path)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> "Response":
        """Read a file that `save` wrote.

        Parameters
        ----------
        path : str or path-like
            The file. Its name ends with ".npz" or ".nc".

        Returns
        -------
        Response
            The response; a simulation can continue from it.

        Raises
        ------
        GearbowError
            If the file is damaged or has another content; the message names the file and the
            problem. The check comes before any memory is allocated for the arrays of the file.
        OSError
            If the file cannot be opened.
        """
        from gearbow.recording import file  # noqa: PLC0415  # only files need its libraries

        return cls.from_record(file.load(path))

    def _chosen(self, names: At | Sequence[At] | None) -> list[At]:
        """Choose the places of a figure."""
        if names is not None:
            return list(places(names, "names"))
        points = self._data["points"]
        named: list[At] = [names[0] for _, _, names in points if names]
        chosen = named or [(shaft, position) for shaft, position, _ in points]
        if not chosen:
            raise GearbowError("no motion was recorded; give record=['gears'] to simulate")
        return chosen

    def _pairs(self, names: Any) -> list[tuple[str, str]]:
        """Choose the meshes of a figure."""
        given: Any = self._data["meshes"] if names is None else names
        pairs: list[tuple[str, str]] = [given] if is_pair(given) else list(given)
        if not pairs:
            raise GearbowError("no mesh was recorded; give record=['meshes'] to simulate")
        return pairs

    def __repr__(self) -> str:
        data = self._data
        times = "empty"
        if self.time.size:
            times = f"{self.time[0]:g} s to {self.time[-1]:g} s at {span(self.speeds)} rad/s"
        return (
            f"Response({self.time.size} times, {times}; {len(data['points'])} points, "
            f"{len(data['meshes'])} meshes, {len(data['bearings'])} bearings)"
        )

    def _rows(self) -> Table:
        """Give a row for each recorded point and mesh."""
        rows = []
        for i, (shaft, x, names) in enumerate(self._data["points"]):
            size = np.ptp(self._data["displacement"][:, i], axis=0) if self.time.size else (0, 0)
            text = f"peak-to-peak {1e6 * size[0]:.4g} µm along y, {1e6 * size[1]:.4g} µm along z"
            rows.append((", ".join(names) or place_label((shaft, x)), text))
        orders = {} if self.kinematics is None else {m[:2]: m[4] for m in self.kinematics.meshes}
        for i, (driver, driven) in enumerate(self._data["meshes"]):
            text = f"force {span(self._data['mesh']['force'][:, i])} N"
            order = orders.get((driver, driven))
            if order is not None and self.time.size:
                text += f", tooth frequency {span(np.abs(order * self.speeds) / (2 * np.pi))} Hz"
            rows.append((f"{driver}–{driven}", text))
        return (("recorded", "motion"), *rows)
