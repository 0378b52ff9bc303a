"""Time response of a system: recorded signals, spectra, orders, figures, tables and files."""

import os
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from gearbow._convert import number, shown
from gearbow._progress import working
from gearbow._result import Column, Result, WithSpeeds
from gearbow._shown import ReadOnly, read_only, span
from gearbow._types import Array, Record, RunData, SignalQuantity, Window
from gearbow.accuracy import estimate_errors
from gearbow.description.speed import SpeedProfile
from gearbow.errors import SceneError
from gearbow.orders.fit import Orders, orders
from gearbow.orders.spectrum import Spectrum, channel, spectrum
from gearbow.recording import channels
from gearbow.recording.channels import resampled
from gearbow.recording.record import Errors, RunRecord, Statistics
from gearbow.results.at_places import RecordedMotion
from gearbow.results.run_figures import animate, plot
from gearbow.results.stresses import stresses
from gearbow.sensors import Sensor, SignalSensor, signal_sensors

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr
    from typing_extensions import Self

    from gearbow.description.layout import Kinematics
    from gearbow.recording.record import RunRequest


class Stored(Result):
    """A result that a file holds without rounding: a recorded run, and entries of its own."""

    _own_endings = (".npz",)

    def _stored(self) -> tuple[RunRecord, dict[str, Any]]:
        """Give the run, and the entries of the metadata of the file."""
        raise NotImplementedError

    @classmethod
    def _restored(cls, run: RunRecord, about: dict[str, Any], path: Any) -> "Self":
        """Make the result of the run and the metadata of a file."""
        raise NotImplementedError

    def _save_own(self, path: Any, ending: str) -> None:  # noqa: ARG002  # the path has it
        from gearbow.recording import container  # noqa: PLC0415  # only files need its libraries

        run, more = self._stored()
        container.save(run, path, **more)

    def _dataset(self) -> "xr.Dataset":
        run, more = self._stored()
        dataset = channels.to_xarray(run)
        dataset.attrs["metadata"] = channels.metadata_of(run, more)
        return dataset

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> "Self":
        """Read a file that `save` wrote.

        Parameters
        ----------
        path : str or path-like
            The file. Its name ends with ".npz"; netCDF files (".nc") are for other programs.

        Returns
        -------
        Response, SteadyState or Continuation
            The result, of the class that reads; a simulation can continue from a response.

        Raises
        ------
        GearbowError
            If the file is damaged or has another content; the message names the file and the
            problem. The check comes before any memory is allocated for the arrays of the file.
        """
        from gearbow.recording import container  # noqa: PLC0415  # only files need its libraries

        return cls._restored(*container.read(path), path)


class Response(WithSpeeds, Stored, ReadOnly, RecordedMotion):
    """Motion of a system at k times, made by `gearbow.RotorSystem.simulate`.

    The first axis of all values is that of the times.

    Attributes
    ----------
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
    period : float or None
        Period [s] if this is one of a `SteadyState`, whose orders are exact; None for other runs.

    Examples
    --------
    >>> import gearbow as gb
    >>> system = gb.examples()["bowed_rotor"].load()
    >>> options = {"speed": 100.0, "output_step": 1e-3, "record": ["disk"]}
    >>> response = system.simulate(0.1, **options)
    >>> response.displacement("disk").shape
    (101, 2)
    >>> further = system.simulate(0.1, initial=response, **options)
    >>> print(f"{further.time[0]:g} s to {further.time[-1]:g} s")
    0.1 s to 0.2 s
    """

    _indexed = True

    def __init__(self, data: RunData, speed: float | SpeedProfile) -> None:
        if not isinstance(data, Mapping):
            raise SceneError(
                f"data: must be the data of a run, got {shown(data)}; simulate and load make "
                "responses"
            )
        if not isinstance(speed, SpeedProfile):
            speed = number(speed, "speed")
        self._data = read_only(data)
        self.speed = speed
        self.statistics = Statistics(**data["statistics"])
        self.accuracy: str | None = None
        self.kinematics: Kinematics | None = None
        self.request: RunRequest | None = None
        self.period: float | None = None
        self._errors: Errors | None = None

    @classmethod
    def _from_record(cls, record: RunRecord) -> "Response":
        """Make a response from plain data, the inverse of `_to_record`."""
        response = cls(record.data, record.speed)
        response.kinematics, response.accuracy = record.kinematics, record.accuracy
        response.request, response._errors = record.request, record.errors
        response.period = record.period
        response.speed_unit = record.speed_unit
        return response

    def _stored(self) -> tuple[RunRecord, dict[str, Any]]:
        return self._to_record(), {}

    @classmethod
    def _restored(cls, run: RunRecord, _about: dict[str, Any], _path: Any) -> "Response":
        return cls._from_record(run)

    def _to_record(self) -> RunRecord:
        """Give the recording as plain data."""
        return RunRecord(
            self._data,
            self.speed,
            self.kinematics,
            self.accuracy,
            self.request,
            self._errors,
            self.period,
            self.speed_unit,
        )

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
            request = self._to_record().asked("errors")
            with working(None, "errors, by more accurate runs"):
                self._errors = estimate_errors(request, self.statistics.modes)
        return self._errors

    def measure(self, sensor: Sensor) -> Array:
        """Measure the recorded motion with a sensor.

        Parameters
        ----------
        sensor : Probe, Accelerometer, StrainGauge, RingSensor or Tacho
            The sensor.

        Returns
        -------
        ndarray, shape (k,) or (n,)
            What `measure` of the sensor gives: the signal at the recorded times in its `unit`, or
            the times of the n pulses of a tachometer [s].
        """
        if not isinstance(sensor, Sensor):
            raise SceneError(
                f"sensor: must be a Probe, an Accelerometer or a Tacho, got {shown(sensor)}"
            )
        return sensor.measure(self)

    def spectrum(
        self,
        at: Record | SignalSensor,
        quantity: SignalQuantity | None = None,
        *,
        window: Window | None = None,
    ) -> Spectrum:
        """Find the amplitude spectrum of one recorded signal.

        Frequencies above half of the sampling rate appear as lower frequencies (aliasing). Choose
        an `output_step` that is short enough for the highest frequency of the signal; `resample`
        then gives a lower rate.

        Parameters
        ----------
        at : str, tuple, Probe or Accelerometer
            A gear or disk, (shaft, position [m]), (driver, driven) in either order or
            "driver/driven", ("bearing", shaft, position [m]), "energy", or a sensor.
        quantity : str, optional
            "y", "z", "x" or "twist" of a place, also as ``velocity_y``, ``acceleration_y`` or
            ``twist_rate``; "y", "z" or "x" of the force on a bearing; a number
            field of `MeshResponse`. None is "y" or the mesh force.
        window : {"hann", "flat top", "none"}, optional
            Window function. "flat top" gives the most exact amplitudes, "none" is for a record of
            whole periods. None is "none" for a period of a `SteadyState`, and "hann" for a run.

        Returns
        -------
        Spectrum
            Amplitudes over frequency.

        Raises
        ------
        GearbowError
            If the times are not equally spaced.
        """
        return spectrum(self._to_record(), at, quantity, window=window)

    def orders(
        self,
        at: Record | SignalSensor,
        quantity: SignalQuantity | None = None,
        *,
        shaft_harmonics: int = 4,
        mesh_harmonics: int | None = None,
        sidebands: int = 1,
        bearing_harmonics: int = 3,
        skip_time: float = 0.0,
        revolutions: float | None = None,
    ) -> Orders:
        """Find the amplitudes of one recorded signal at the orders of shafts and meshes.

        What these orders do not contain is the rest, of which the result states the RMS. At a
        changing speed, the amplitudes of segments of the run show each order over the speed.

        Orders that are too close to each other for the record have one common amplitude. Those of a
        `SteadyState` are always separate, because its motion repeats after the record.

        Parameters
        ----------
        at : str, tuple, Probe or Accelerometer
            Place of the signal, as for `spectrum`.
        quantity : str, optional
            Quantity, as for `spectrum`.
        shaft_harmonics : int
            Number of harmonics of each shaft.
        mesh_harmonics : int, optional
            Number of harmonics of each tooth frequency. None takes three, and of the harmonics 4 to
            30 and their sidebands those that the record resolves and separates and whose amplitude
            is above 1 % of the largest.
        sidebands : int
            Number of sidebands on each side of a tooth frequency, for each of the two shafts.
        bearing_harmonics : int
            Number of harmonics of the ball-pass frequency of each rolling bearing; with one or
            more, also the order of the cage.
        skip_time : float
            Time at the beginning that is ignored [s].
        revolutions : float, optional
            Length of the segments in revolutions of the reference shaft. Long segments separate
            close orders, short ones follow fast changes: a segment must be shorter than the
            passage of a resonance. Orders with a distance of 4/`revolutions` are separate. None
            is the complete record at a constant speed. At a changing speed, it is the shortest
            length that separates all orders, up to a fifth of the record.

        Returns
        -------
        Orders
            Complex amplitudes by least squares, with the names of the excitations.

        Raises
        ------
        GearbowError
            If the train does not rotate, no harmonic is asked for or `revolutions` is too long.

        Warns
        -----
        AccuracyWarning
            If the record does not separate some orders, or its output step is too long for the
            highest of them, which are then left out: the message gives all remedies. If the rest
            is more than 30 % of the RMS of the signal about its mean.
        """
        return orders(
            self._to_record(),
            at,
            quantity,
            shaft_harmonics=shaft_harmonics,
            mesh_harmonics=mesh_harmonics,
            sidebands=sidebands,
            bearing_harmonics=bearing_harmonics,
            skip_time=skip_time,
            revolutions=revolutions,
        )

    def resample(self, rate: float, *, shaft: str | None = None) -> "Response":
        """Sample all signals at a lower rate, as a data-acquisition chain with an analogue filter.

        A low-pass filter precedes the sampling, so that no frequency appears as another one
        (aliasing). It passes frequencies up to 0.4 `rate` with an error of 0.01 %, suppresses those
        above 0.5 `rate` by 80 dB, and shifts no phase. The filter sees what was recorded: the
        `output_step` of the run must be short enough for all frequencies of the motion.

        With a shaft, the samples have equal distances in its angle, and the filter acts over this
        angle. At a changing speed, the orders of the shaft are then sines.

        Parameters
        ----------
        rate : float
            Sampling rate [Hz]; with a shaft, the number of samples in a revolution.
        shaft : str, optional
            Name of the shaft whose prescribed angle replaces the time.

        Returns
        -------
        Response
            The response at multiples of 1/rate, or at the times at which the angle of the shaft is
            a multiple of 2π/rate. The first and the last 25 samples are missing,
            because the filter needs the signal on both sides. Events, final state and statistics
            are those of the run.

        Raises
        ------
        GearbowError
            If the times are not equally spaced, the rate is too high or the recording too short.
        """
        return Response._from_record(resampled(self._to_record(), rate, shaft))

    stresses = stresses

    plot = plot

    animate = animate

    def to_dataframe(self, sensors: Sequence[SignalSensor] = ()) -> "pd.DataFrame":
        """Convert all recorded signals to a table.

        Parameters
        ----------
        sensors : sequence of Probe, Accelerometer, StrainGauge or RingSensor
            Sensors whose signals are added.

        Returns
        -------
        pandas.DataFrame
            Rows by time [s]; columns with their unit, e.g. "g1 y [m]", "g1/g2 force [N]".
        """
        table = super().to_dataframe()
        for sensor in signal_sensors(sensors, "sensors"):
            found = channel(self._to_record(), sensor)
            table[f"{found.label} [{found.unit}]"] = found.values
        return table

    def to_xarray(self) -> "xr.Dataset":
        """Convert everything to a labelled data set.

        Returns
        -------
        xarray.Dataset
            Variables over time, point, axis, mesh and bearing, each with its unit as an attribute.
        """
        return channels.to_xarray(self._to_record())

    def __repr__(self) -> str:
        data = self._data
        times = "empty"
        if self.time.size:
            speeds = self._speed_text(self.speeds)
            times = f"{self.time[0]:g} s to {self.time[-1]:g} s at {speeds}"
        return (
            f"Response({self.time.size} times, {times}; {len(data['points'])} points, "
            f"{len(data['meshes'])} meshes, {len(data['bearings'])} bearings"
            f"{'' if self._level is None else f'; accuracy {self._level!r}'})"
        )

    @property
    def _level(self) -> str | None:
        """Name of the accuracy level with which `accuracy` begins; None without a level."""
        return None if self.accuracy is None else self.accuracy.partition(":")[0]

    def _heading(self) -> list[str]:
        time = self.time
        if not time.size:
            return ["run without recorded times"]
        speed = self._speed_text(
            self.speeds if isinstance(self.speed, SpeedProfile) else self.speed
        )
        level = "" if self._level is None else f", accuracy {self._level!r}"
        lines = [f"run at {speed}, {time[0]:g} s to {time[-1]:g} s, {time.size} times{level}"]
        meshes = () if self.kinematics is None else self.kinematics.meshes
        recorded = {tuple(pair) for pair in self._data["meshes"]}
        for driver, driven, *_, order in (m for m in meshes if m[:2] in recorded):
            hertz = span(np.abs(order * self.speeds) / (2.0 * np.pi))
            lines.append(f"tooth frequency {driver}/{driven}: {hertz} Hz")
        return lines

    def _columns(self) -> list[Column]:
        return channels.summary(self._to_record())

    def _series(self) -> list[Column]:
        return channels.series(self._to_record())
