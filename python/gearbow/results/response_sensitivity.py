"""Derivatives of a signal of a response or of the static equilibrium."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from gearbow._read_only import ReadOnly
from gearbow._result import Column, Result
from gearbow._shown import short
from gearbow._types import Array
from gearbow.results.sensitivity import Sensitivity
from gearbow.units.speed import SpeedUnit, speed_text

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, eq=False)
class ResponseSensitivity(Result, ReadOnly):
    """Derivatives of a signal of a response or of the static equilibrium.

    Parameters
    ----------
    kind : {"frequency response", "synchronous response", "static equilibrium"}
        The result that is differentiated.
    parameters : tuple of str
        Paths of the p parameters.
    parameter_values : ndarray, shape (p,)
        Their values.
    units : tuple of str
        Their SI units.
    label : str
        Name of the signal.
    unit : str
        Its unit.
    components : tuple of str
        Its c components: "y" and "z", or one without a name.
    values : ndarray, shape (..., sources, c)
        The signal over the `axes` of a response: phasors; numbers of an equilibrium.
    derivatives : ndarray, shape (p, ..., sources, c)
        Its derivatives with respect to each parameter [unit of the signal over that of the
        parameter].
    sources : tuple of str
        Labels of the sources.
    axes : tuple of str
        Names of the first axes of `values`.
    frequencies : ndarray or None
        Frequencies [rad/s] of a frequency response.
    speeds : ndarray or None
        Speeds of the reference shaft [rad/s] of a response.
    speed_unit : {"rad/s", "rpm"}
        Unit of speeds in tables.

    Examples
    --------
    A rotor on soft bearings at rest, far below its first natural frequency:

    >>> import numpy as np
    >>> import gearbow as gb
    >>> rotor = gb.Shaft("rotor", length=0.2, outer_diameter=0.1)
    >>> bearings = [gb.Bearing("rotor", x, stiffness=1e6, damping=10.0) for x in (0.0, 0.2)]
    >>> system = gb.RotorSystem([rotor], bearings=bearings, motion="lateral")
    >>> response = system.frequency_response([1.0, 2.0], source=gb.Force(("rotor", 0.1), 1.0))
    >>> found = system.sensitivity("bearings[0].stiffness", response, at=("rotor", 0.1))
    >>> found.derivatives.shape, f"{found.relative[0, 0, 0, 0]:.2f} % for 1 %"
    ((1, 2, 1, 2), '-0.50 % for 1 %')
    """

    kind: str
    parameters: tuple[str, ...]
    parameter_values: Array
    units: tuple[str, ...]
    label: str
    unit: str
    components: tuple[str, ...]
    values: Any
    derivatives: Any
    sources: tuple[str, ...]
    axes: tuple[str, ...]
    frequencies: Array | None
    speeds: Array | None
    speed_unit: SpeedUnit = "rad/s"

    @property
    def amplitudes(self) -> Array:
        """Derivatives of the amplitudes with respect to each parameter.

        Returns
        -------
        ndarray, shape (p, ..., sources, c)
            d abs(s)/dp [unit of the signal over that of the parameter]; of an equilibrium ds/dp.
            0 where the signal is 0.
        """
        if self.kind == "static equilibrium":
            slopes: Array = self.derivatives
            return slopes
        size = np.abs(self.values)
        with np.errstate(invalid="ignore", divide="ignore"):
            found: Array = (np.conj(self.values) * self.derivatives).real / size
        return np.where(size > 0.0, found, 0.0)

    @property
    def relative(self) -> Array:
        """Relative change of the amplitudes over the relative change of each parameter.

        Returns
        -------
        ndarray, shape (p, ..., sources, c)
            (p/a) da/dp: the change in percent for 1 % of the parameter. NaN where the signal is 0.
        """
        values = self.values if self.kind == "static equilibrium" else np.abs(self.values)
        factors = self.parameter_values.reshape(-1, *(1,) * self.values.ndim)
        with np.errstate(invalid="ignore", divide="ignore"):
            found: Array = factors * self.amplitudes / values
        return np.where(np.isfinite(found), found, np.nan)

    def largest(self) -> Sensitivity:
        """Give the derivatives of the largest amplitude of each component and source.

        Returns
        -------
        Sensitivity
            One output for each source and component: its largest amplitude over the axes, whose
            change at a fixed frequency and speed is that of the peak.
        """
        p, (sources, components) = len(self.parameters), self.values.shape[-2:]
        flat = self.values.reshape(-1, sources * components)
        size = flat if self.kind == "static equilibrium" else np.abs(flat)
        at = np.argmax(np.abs(flat), axis=0)
        own = np.arange(flat.shape[1])
        slopes = self.amplitudes.reshape(p, -1, flat.shape[1])[:, at, own]
        names = []
        for j, i in enumerate(at.tolist()):
            source, component = self.sources[j // components], self.components[j % components]
            parts = [f"{self.label} {component}".strip(), source, self._place(i)]
            names.append(", ".join(part for part in parts if part))
        return Sensitivity(
            kind="amplitude",
            parameters=self.parameters,
            parameter_values=self.parameter_values,
            units=self.units,
            outputs=tuple(names),
            output_values=size[at, own],
            derivatives=slopes,
            damping_ratios=np.full(slopes.shape, np.nan),
            speed_unit=self.speed_unit,
            amplitude_unit=self.unit,
        )

    def _place(self, i: int) -> str:
        """Name the frequency or speed with a number."""
        if self.frequencies is not None:
            return f"{self.frequencies.ravel()[i] / (2.0 * np.pi):.4g} Hz"
        return "" if self.speeds is None else speed_text(self.speeds[i], self.speed_unit)

    def plot(self, *, count: int = 4, ax: Any = None) -> "Figure":
        """Draw the effect of the parameters on the largest amplitudes as bars.

        Parameters
        ----------
        count : int
            Largest number of components and sources, each with a panel.
        ax : Axes or sequence of Axes, optional
            One panel for each; None makes a new figure.

        Returns
        -------
        matplotlib.figure.Figure
            The relative change of each largest amplitude for 1 % of each parameter (tornado
            diagram).
        """
        return self.largest().plot(count=count, ax=ax)

    def _facts(self) -> dict[str, str]:
        return {"kind": self.kind, "signal": self.label, "parameters": short(self.parameters)}

    def _columns(self) -> list[Column]:
        """Give a row for each largest amplitude and parameter."""
        return self.largest()._columns()

    def _heading(self, _speed_unit: SpeedUnit) -> list[str]:
        return [f"derivatives of the {self.kind}, at the largest amplitudes"]
