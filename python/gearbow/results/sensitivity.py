"""Derivatives of natural frequencies, critical speeds and signals."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from gearbow._convert import whole
from gearbow._extras import extra
from gearbow._result import Column, Result, WithSpeeds, in_percent
from gearbow._shown import ReadOnly, short
from gearbow._types import Array

if TYPE_CHECKING:
    from matplotlib.figure import Figure


#: Unit of each kind of output that has always the same one.
_UNITS = {"frequency": "Hz", "critical speed": "rad/s"}
#: Name of the column of the outputs of each kind.
_OUTPUTS = {"frequency": "mode", "critical speed": "intersection"}


@dataclass(frozen=True, eq=False)
class Sensitivity(WithSpeeds, Result, ReadOnly):
    """Derivatives of natural frequencies or critical speeds with respect to parameters.

    Parameters
    ----------
    kind : {"frequency", "critical speed", "amplitude"}
        What is differentiated: natural frequencies [Hz] at one speed, speeds of intersections
        with excitation lines [rad/s], or the largest amplitudes of a `ResponseSensitivity`.
    parameters : tuple of str
        Paths of the parameters.
    parameter_values : ndarray, shape (p,)
        Their values.
    units : tuple of str
        Their SI units.
    outputs : tuple of str
        Name of each mode or intersection.
    output_values : ndarray, shape (m,)
        Natural frequencies [Hz] or speeds [rad/s].
    derivatives : ndarray, shape (p, m)
        Derivative of each output with respect to each parameter [Hz or rad/s over the unit of the
        parameter]. NaN for a motion without stiffness.
    damping_ratios : ndarray, shape (p, m)
        Derivatives of the damping ratios [1 over the unit]; of an intersection, along its line.
    equal : tuple of tuple of int
        Numbers of the modes with equal eigenvalues, from 1. Their derivatives ascend and are those
        for an increase of one parameter alone; they do not add up over parameters.
    speed : float or None
        Speed of the reference shaft [rad/s] of natural frequencies.
    amplitude_unit : str
        Unit of amplitudes.

    Examples
    --------
    >>> import gearbow as gb
    >>> system = gb.examples()["bowed_rotor"].load()
    >>> modes = system.modes(count=1)
    >>> found = system.sensitivity(["shafts['rotor'].outer_diameter"], modes)
    >>> f"1 % more diameter raises the frequency by {found.relative[0, 0]:.1f} %"
    '1 % more diameter raises the frequency by 1.7 %'
    """

    kind: str
    parameters: tuple[str, ...]
    parameter_values: Array
    units: tuple[str, ...]
    outputs: tuple[str, ...]
    output_values: Array
    derivatives: Array
    damping_ratios: Array
    equal: tuple[tuple[int, ...], ...] = ()
    speed: float | None = None
    amplitude_unit: str = ""

    @property
    def relative(self) -> Array:
        """Relative change of each output over the relative change of each parameter, shape (p, m).

        (p/f) df/dp is the change in percent for 1 % of the parameter. 0 for a parameter of the
        value 0; NaN for an output that is 0.
        """
        with np.errstate(invalid="ignore", divide="ignore"):
            found: Array = self.parameter_values[:, None] * self.derivatives / self.output_values
        return np.where(np.isfinite(found), found, np.nan)

    def plot(self, *, count: int = 4, ax: Any = None) -> "Figure":
        """Draw the effect of the parameters on the first outputs as bars, the largest on top.

        Parameters
        ----------
        count : int
            Largest number of outputs, each with a panel.
        ax : Axes or sequence of Axes, optional
            One panel for each output; None makes a new figure.

        Returns
        -------
        matplotlib.figure.Figure
            The relative change of each output for 1 % of each parameter (tornado diagram).
        """
        with extra("plot"):
            from gearbow.plotting import analyses as figures  # noqa: PLC0415

        shown = np.flatnonzero(np.isfinite(self.relative).any(axis=0))[: whole(count, "count")]
        return figures.tornado(
            self.parameters,
            [self.outputs[i] for i in shown],
            self.relative[:, shown],
            of=self.kind,
            ax=ax,
        )

    def _columns(self) -> list[Column]:
        p, m = self.derivatives.shape
        unit = _UNITS.get(self.kind, self.amplitude_unit)
        values = np.repeat(self.output_values, p)
        damping = Column(
            "damping ratio for 1 %",
            0.01 * (self.parameter_values[:, None] * self.damping_ratios).T.ravel(),
            "",
            ".2g",
            in_percent("damping for 1 %"),
        )
        columns = [
            Column(_OUTPUTS.get(self.kind, "signal"), _repeated(self.outputs, p)),
            Column(self.kind, values, unit, {"Hz": ".3f", "rad/s": ".2f"}.get(unit, ".4g")),
            Column("parameter", list(self.parameters) * m),
            Column("value", np.tile(self.parameter_values, m), "", ".5g"),
            Column("unit", list(self.units) * m),
            Column(f"derivative, {unit}/unit", self.derivatives.T.ravel(), "", ".4g"),
            Column("% for 1 %", self.relative.T.ravel(), "", ".3f"),
        ]
        return columns if self.kind == "amplitude" else [*columns, damping]

    def _heading(self) -> list[str]:
        at = "" if self.speed is None else f" at {self._speed_text(self.speed)}"
        what = {"frequency": "natural frequencies", "critical speed": "critical speeds"}
        return [f"derivatives of {what.get(self.kind, 'largest amplitudes')}{at}"]

    def _remarks(self) -> list[str]:
        return [
            f"modes {', '.join(map(str, own))} have equal eigenvalues: their derivatives ascend, "
            "each for an increase of one parameter alone"
            for own in self.equal
        ]

    def __repr__(self) -> str:
        p, m = self.derivatives.shape
        first = ", ".join(self.parameters[:2]) + (", …" if p > 2 else "")
        outputs = {"frequency": "frequencies", "critical speed": "critical speeds"}.get(
            self.kind, "amplitudes"
        )
        return f"Sensitivity({m} {outputs}; {p} parameters: {first[:100]})"


def _repeated(names: tuple[str, ...], times: int) -> list[str]:
    return [name for name in names for _ in range(times)]


@dataclass(frozen=True, eq=False)
class ResponseSensitivity(WithSpeeds, Result, ReadOnly):
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
    label, unit : str
        Name and unit of the signal.
    components : tuple of str
        Its c components: "y" and "z", or one without a name.
    values : ndarray, shape (..., sources, c)
        The signal over the `axes` of a response: phasors; numbers of an equilibrium.
    derivatives : ndarray, shape (p, ..., sources, c)
        Derivatives for each parameter [unit of the signal over that of the parameter].
    sources, axes : tuple of str
        Labels of the sources, and names of the first axes of `values`.
    frequencies : ndarray or None
        Frequencies [rad/s] of a frequency response.
    speeds : ndarray or None
        Speeds of the reference shaft [rad/s] of a response.

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

    @property
    def amplitudes(self) -> Array:
        """Derivatives of the amplitudes by each parameter, shape (p, ..., sources, c).

        d abs(s)/dp [unit of the signal over that of the parameter]; of an equilibrium ds/dp. 0
        where the signal is 0.
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
        """Relative change of the amplitudes over that of each parameter.

        Its shape is (p, ..., sources, c). (p/a) da/dp is the change in percent for 1 % of the
        parameter. NaN where the signal is 0.
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
            amplitude_unit=self.unit,
        )

    def _place(self, i: int) -> str:
        """Name the frequency or speed with a number."""
        if self.frequencies is not None:
            return f"{self.frequencies.ravel()[i] / (2.0 * np.pi):.4g} Hz"
        return "" if self.speeds is None else self._speed_text(self.speeds[i])

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
            The change of each largest amplitude for 1 % of each parameter (tornado diagram).
        """
        return self.largest().plot(count=count, ax=ax)

    def _facts(self) -> dict[str, str]:
        return {"kind": self.kind, "signal": self.label, "parameters": short(self.parameters)}

    def _columns(self) -> list[Column]:
        return self.largest()._columns()

    def _heading(self) -> list[str]:
        return [f"derivatives of the {self.kind}, at the largest amplitudes"]
