"""Signals of a recorded run: measurements by sensors, spectra, and amplitudes at orders."""

from gearbow._convert import shown
from gearbow._types import Array, Record
from gearbow.errors import SceneError
from gearbow.orders.fit import Orders, orders
from gearbow.orders.spectrum import Spectrum, spectrum
from gearbow.recording.recording import Recording
from gearbow.sensors.sensor import Sensor, SignalSensor

__all__ = ["SignalResponse"]


class SignalResponse(Recording):
    """Recorded signals of a run with their evaluation."""

    def measure(self, sensor: Sensor) -> Array:
        """Measure the recorded motion with a sensor.

        Parameters
        ----------
        sensor : Probe, Accelerometer or Tacho
            The sensor.

        Returns
        -------
        ndarray, shape (k,) or (n,)
            Displacement [m] or acceleration [m/s²] at the recorded times, or the times of the n
            pulses of a tachometer [s].

        Raises
        ------
        ChannelError
            If a motion was not recorded; the message says what to record.
        SceneError
            If it is no sensor.
        """
        if not isinstance(sensor, Sensor):
            raise SceneError(
                f"sensor: must be a Probe, an Accelerometer or a Tacho, got {shown(sensor)}"
            )
        return sensor.measure(self)

    def spectrum(
        self, of: Record | SignalSensor, quantity: str | None = None, *, window: str = "hann"
    ) -> Spectrum:
        """Find the amplitude spectrum of one recorded signal.

        Frequencies above half of the sampling rate appear as lower frequencies (aliasing). Choose
        an `output_step` that is short enough for the highest frequency of the signal; `resample`
        then gives a lower rate.

        Parameters
        ----------
        of : str, tuple, Probe or Accelerometer
            A gear or disk, (shaft, position [m]), (driver, driven), ("bearing", shaft,
            position [m]), "energy", or a sensor.
        quantity : str, optional
            "v", "w", "twist", "u", "velocity_v", "velocity_w", "velocity_u", "twist_rate",
            "acceleration_v", "acceleration_w" or "acceleration_u" of a place, "y", "z" or "x" of
            the force on a bearing, or a field of `MeshResponse`. None is "v", "y" or the mesh
            force.
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
        of: Record | SignalSensor,
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
        of : str, tuple, Probe or Accelerometer
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
