"""Time response of a system: recorded signals, spectra, orders, figures, tables and files."""

import os
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from gearbow._convert import items, shown
from gearbow._shown import Table, span
from gearbow.accuracy.estimate import estimate_errors
from gearbow.description.places import place_label
from gearbow.errors import GearbowError, SceneError
from gearbow.orders.channel import channel
from gearbow.recording import tables
from gearbow.recording.errors import Errors
from gearbow.recording.record import RunRecord
from gearbow.recording.resample import resampled
from gearbow.results.run_figures import RunFigures
from gearbow.sensors.sensor import SignalSensor

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

__all__ = ["Response"]


class Response(RunFigures):
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

        Raises
        ------
        SceneError
            If it is no such record.
        """
        if not isinstance(record, RunRecord):
            raise SceneError(f"record: must be that of to_record, got {shown(record)}")
        response = cls(record.data, record.speed)
        response.kinematics, response.accuracy = record.kinematics, record.accuracy
        response.request, response._errors = record.request, record.errors
        return response

    def errors(self) -> Errors:
        """Estimated error of the run: contributions of elements, modes and integration.

        The error is the RMS of the difference divided by the RMS of the signal about its mean (or
        by 2 % of the mean where this is larger), for the worst recorded displacement and the worst
        recorded mesh force. It applies to the time series over the first 0.1 s, or over the time
        that damping needs to forget, if that is longer. Later, phase errors of undamped modes grow,
        and the error applies to RMS values and spectra. After chaotic contact it applies to
        neither; `Errors.chaotic` is then true.

        The first call runs the system again over this time, with a much smaller tolerance, with
        all modes, and with finer elements. It first checks the initial state, which all runs share,
        against the equations of the equilibrium and of the synchronous response. This takes several
        times as long as a run of this time.
        The result is kept, and saved with the response.

        Returns
        -------
        Errors
            A dictionary with the keys "displacement", "velocity", "acceleration" and "mesh_force",
            where such signals were recorded and vary. Each value has the attributes `elements`,
            `modes`, `integration` and `total`.

        Raises
        ------
        GearbowError
            If the response does not know its system.
        ConvergenceError
            If the initial state does not satisfy its equations.
        """
        if self._errors is None:
            if self.request is None:
                raise GearbowError(
                    "errors: this response does not know its system; take the errors of a response "
                    "that simulate returned or that save wrote"
                )
            self._errors = estimate_errors(self.request, self.statistics.modes)
        return self._errors

    def resample(self, rate: float) -> "Response":
        """Sample all signals at a lower rate, as a data-acquisition chain with an analogue filter.

        A low-pass filter precedes the sampling, so that no frequency appears as another one
        (aliasing). It passes frequencies up to 0.4 `rate` with an error of 0.01 %, suppresses those
        above 0.5 `rate` by 80 dB, and shifts no phase. The filter sees what was recorded: the
        `output_step` of the run must be short enough for all frequencies of the motion.

        Parameters
        ----------
        rate : float
            Sampling rate [Hz].

        Returns
        -------
        Response
            The response at multiples of 1/rate. The first and the last 25 samples are missing,
            because the filter needs the signal on both sides. Events, final state and statistics
            are those of the run.

        Raises
        ------
        GearbowError
            If the times are not equally spaced, the rate exceeds that of the recording, or the
            recording is shorter than the filter.
        """
        return Response.from_record(resampled(self.to_record(), rate))

    def to_dataframe(self, sensors: Sequence[SignalSensor] = ()) -> "pd.DataFrame":
        """Convert all recorded signals to a table.

        Parameters
        ----------
        sensors : sequence of Probe or Accelerometer
            Sensors whose signals are added.

        Returns
        -------
        pandas.DataFrame
            Rows by time [s]; columns with their unit, e.g. "g1 v [m]", "g1/g2 force [N]".

        Raises
        ------
        ChannelError
            If a sensor needs a motion that was not recorded.
        """
        table = tables.to_dataframe(self.to_record())
        for i, sensor in enumerate(items(sensors, "sensors", "sensors")):
            if not isinstance(sensor, SignalSensor):
                raise SceneError(
                    f"sensors[{i}]: must be a Probe or an Accelerometer, got {shown(sensor)}"
                )
            found = channel(self, sensor)
            table[f"{found.label} [{found.unit}]"] = found.values
        return table

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
