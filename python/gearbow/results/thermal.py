"""Stability of a thermal bow over the speed, and its spiral over time."""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from gearbow._convert import number, positive, whole
from gearbow._result import Column, Figured, WithSpeeds, in_micrometres
from gearbow._shown import ReadOnly
from gearbow._types import Array, At, ComplexArray
from gearbow.description.places import place_label
from gearbow.errors import SceneError
from gearbow.units.speed import in_given_unit

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, eq=False)
class ThermalStability(WithSpeeds, Figured, ReadOnly):
    """Growth of a thermal bow over the speed.

    `plot` draws the loop gain over the speed, and the rate of growth below.

    Parameters
    ----------
    at : str or tuple of (str, float)
        The journal.
    speeds : ndarray, shape (speeds,)
        Speeds of the reference shaft [rad/s].
    time_constant : float
        Time constant τ of the temperature difference [s].
    gain : ndarray, shape (speeds,)
        Temperature difference over the vibration, g [K/m].
    response : ndarray, shape (speeds,)
        Forward vibration at the journal over the temperature difference, H B [m/K].
    vibration : ndarray, shape (speeds,)
        Forward vibration at the journal without thermal bow [m].
    left_out : tuple of str
        Excitations of the system that this result does not contain.

    Notes
    -----
    The temperature difference changes with exp(λt), λ = (H B g - 1)/τ. It grows where the real part
    of the loop gain H B g is above 1. P. G. Morton, *Unstable shaft vibrations arising from thermal
    effects due to oil shearing between stationary and rotating elements*, IMechE (2008); F. M. de
    Jongh and P. G. Morton, *The synchronous instability of a compressor rotor due to bearing
    journal differential heating*, J. Eng. Gas Turbines Power 118 (1996).

    Examples
    --------
    >>> import gearbow as gb
    >>> bearings = [gb.Bearing("rotor", x, stiffness=2e7, damping=5e3) for x in (0.0, 0.8)]
    >>> system = gb.RotorSystem(
    ...     [gb.Shaft("rotor", length=1.0, outer_diameter=0.06)], bearings=bearings
    ... )
    >>> hot = gb.ThermalBow(("rotor", 0.8), 1e5, time_constant=200.0, shape=gb.Bow.half_sine(1e-6))
    >>> system.thermal_bow(hot, [628.0]).stable
    array([ True])
    """

    at: At
    speeds: Array
    time_constant: float
    gain: ComplexArray
    response: ComplexArray
    vibration: ComplexArray
    left_out: tuple[str, ...] = ()

    @property
    def loop_gain(self) -> ComplexArray:
        """Loop gain H B g, shape (speeds,)."""
        found: ComplexArray = self.response * self.gain
        return found

    @property
    def eigenvalues(self) -> ComplexArray:
        """Eigenvalue λ of the temperature difference [1/s], shape (speeds,)."""
        found: ComplexArray = (self.loop_gain - 1.0) / self.time_constant
        return found

    @property
    def stable(self) -> Any:
        """Whether the thermal bow decays, boolean, shape (speeds,)."""
        return self.eigenvalues.real < 0.0

    @property
    def periods(self) -> Array:
        """Time of one turn of the hot spot around the shaft [s], shape (speeds,)."""
        with np.errstate(divide="ignore"):
            found: Array = 2.0 * math.pi / np.abs(self.eigenvalues.imag)
        return found

    @in_given_unit
    def spiral(self, speed: float, duration: float, *, count: int = 500) -> "ThermalSpiral":
        """Follow the thermal bow over time, from a shaft of even temperature.

        Parameters
        ----------
        speed : float
            One of the speeds of the result [rad/s].
        duration : float
            Duration [s].
        count : int
            Number of instants.

        Returns
        -------
        ThermalSpiral
            Temperature difference and vibration over time.
        """
        speed = number(speed, "speed")
        time = np.linspace(0.0, positive(duration, "duration"), whole(count, "count", least=2))
        near = int(np.argmin(np.abs(self.speeds - speed)))
        if not math.isclose(self.speeds[near], speed, rel_tol=1e-9):
            raise SceneError(
                f"speed: the result has no {speed:.6g} rad/s; the nearest is "
                f"{self.speeds[near]:.6g} rad/s"
            )
        rate = complex(self.eigenvalues[near])
        drive = complex(self.gain[near] * self.vibration[near]) / self.time_constant
        # (exp(λt) - 1)/λ without cancellation at the limit of stability.
        exponent = rate * time
        small = np.abs(exponent) < 1e-6
        grown = np.where(small, time, np.expm1(exponent) / (rate or 1.0))
        temperature = drive * np.where(small, time * (1.0 + exponent / 2.0), grown)
        vibration = self.vibration[near] + self.response[near] * temperature
        return ThermalSpiral(self.at, speed, time, temperature, vibration)

    def _draw(self, ax: Any) -> "Figure":
        from gearbow.plotting import analyses as figures  # noqa: PLC0415

        growth = 60.0 * self.eigenvalues.real
        return figures.stability(self.speeds, self.loop_gain, growth, ax)

    def _heading(self) -> list[str]:
        unstable = self.speeds[~self.stable]
        found = f"thermal bow by {place_label(self.at)}: "
        if not unstable.size:
            return [found + "stable"]
        low, high = (self._speed_text(value) for value in (unstable.min(), unstable.max()))
        ends = low if low == high else f"between {low} and {high}"
        return [f"{found}unstable at {unstable.size} of {self.speeds.size} speeds, {ends}"]

    def _columns(self) -> list[Column]:
        gain, eigenvalues = self.loop_gain, self.eigenvalues
        return [
            Column("speed", self.speeds, "rad/s", ".6g"),
            Column("loop gain, real", gain.real, "", ".4f"),
            Column("loop gain, imaginary", gain.imag, "", ".4f"),
            Column("growth", eigenvalues.real, "1/s", ".3e"),
            Column("period", self.periods, "s", ".4g"),
            Column("verdict", np.where(self.stable, "stable", "unstable")),
        ]

    def __repr__(self) -> str:
        unstable = int(np.sum(~self.stable))
        return f"ThermalStability({self.speeds.size} speeds, {unstable} unstable)"


@dataclass(frozen=True, eq=False)
class ThermalSpiral(WithSpeeds, Figured, ReadOnly):
    """Temperature difference and vibration of a thermal bow over time, at one speed.

    `plot` draws the vibration in the complex plane, and its amplitude over time.

    Parameters
    ----------
    at : str or tuple of (str, float)
        The journal.
    speed : float
        Speed of the reference shaft [rad/s].
    time : ndarray, shape (instants,)
        Time [s].
    temperature, vibration : ndarray, shape (instants,)
        Temperature difference [K] and forward vibration at the journal [m], phasors in the shaft.

    Examples
    --------
    >>> import numpy as np
    >>> import gearbow as gb
    >>> state = np.array([0.0, 1.0 + 1j])
    >>> gb.results.ThermalSpiral("disk", 300.0, np.array([0.0, 9.0]), state, 1e-6 * state)
    ThermalSpiral(2 instants, 9 s at 300 rad/s)
    """

    at: At
    speed: float
    time: Array
    temperature: ComplexArray
    vibration: ComplexArray

    def _draw(self, ax: Any) -> "Figure":
        from gearbow.plotting import analyses as figures  # noqa: PLC0415

        return figures.spiral(self.time, self.vibration, ax)

    def _heading(self) -> list[str]:
        speed = self._speed_text(self.speed)
        return [f"thermal bow by {place_label(self.at)} at {speed}"]

    def _columns(self) -> list[Column]:
        written = in_micrometres()
        return [
            Column("time", self.time, "s", ".4g"),
            Column("temperature difference", np.abs(self.temperature), "K", ".4g"),
            Column("vibration", np.abs(self.vibration), "m", ".4g", written),
            Column("vibration, real", self.vibration.real, "m", ".4g", written),
            Column("vibration, imaginary", self.vibration.imag, "m", ".4g", written),
        ]

    def __repr__(self) -> str:
        speed = self._speed_text(self.speed)
        return f"ThermalSpiral({self.time.size} instants, {self.time[-1]:.4g} s at {speed})"
