"""Comparison of computed and measured frequency response functions."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from gearbow._extras import extra
from gearbow._read_only import ReadOnly
from gearbow._result import Column, Result
from gearbow._shown import short
from gearbow._types import Array, ComplexArray
from gearbow.errors import SceneError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from gearbow.exchange.harmonic import MeasuredCurve


@dataclass(frozen=True, eq=False)
class FrequencyComparison(Result, ReadOnly):
    """Measured curves, and the computed ones at the same frequencies.

    Parameters
    ----------
    measured : tuple of MeasuredCurve
        The measured curves, each with `at`, `direction`, `quantity`, `frequencies` [rad/s] and
        `values`.
    computed : tuple of ndarray
        Values of the computed curves.

    Notes
    -----
    FRAC is the frequency response assurance criterion
    abs(Σ conj(H_m) H_c)²/(Σ abs(H_m)² Σ abs(H_c)²) of one curve over its frequencies (Heylen and
    Lammens, 1996). MAC is the same ratio of the shapes at one frequency, over the curves (Allemang
    and Brown, 1982). Both are 1 for proportional functions.

    Examples
    --------
    >>> import numpy as np
    >>> import gearbow as gb
    >>> system = gb.RotorSystem(
    ...     shafts=[gb.Shaft("rotor", length=1.0, outer_diameter=0.05)],
    ...     bearings=[gb.Bearing("rotor", x, stiffness=1e8, damping=1e3) for x in (0.0, 1.0)],
    ... )
    >>> frequencies = np.linspace(100.0, 1000.0, 50)
    >>> force = gb.Force(("rotor", 0.5), 1.0)
    >>> response = system.frequency_response(frequencies, source=force)
    >>> at = ("rotor", 0.5)
    >>> values = response.displacement(at)[:, 0, 0]
    >>> curve = gb.results.MeasuredCurve(at, "y", "displacement", frequencies, values)
    >>> print(f"{response.compare([curve]).frac[0]:.3f}")
    1.000
    """

    measured: "tuple[MeasuredCurve, ...]"
    computed: tuple[ComplexArray, ...]

    def _facts(self) -> dict[str, str]:
        return {"curves": short([one.label for one in self.measured]), "frac": short(self.frac)}

    def _columns(self) -> list[Column]:
        """Give a row for each curve."""
        return [
            Column("curve", [one.label for one in self.measured]),
            Column("quantity", [one.quantity for one in self.measured]),
            Column("frequencies", [one.frequencies.size for one in self.measured]),
            Column("FRAC", self.frac, "", ".4f"),
        ]

    @property
    def frac(self) -> Array:
        """FRAC of each curve.

        Returns
        -------
        ndarray, shape (curves,)
            Values from 0 to 1.
        """
        pairs = zip(self.measured, self.computed, strict=True)
        return np.array([_assurance(one.values, own, 0) for one, own in pairs])

    @property
    def mac(self) -> Array:
        """MAC of the measured and computed shapes.

        Returns
        -------
        ndarray, shape (k,)
            Values from 0 to 1 at each frequency.

        Raises
        ------
        SceneError
            If the curves have different frequencies or quantities.
        """
        first = self.measured[0]
        for one in self.measured[1:]:
            same = np.array_equal(one.frequencies, first.frequencies)
            if not same or one.quantity != first.quantity:
                raise SceneError(
                    f"mac: a shape needs curves of one quantity at the same frequencies; "
                    f"{one.label!r} differs from {first.label!r}"
                )
        mac: Array = _assurance(
            np.array([one.values for one in self.measured]), np.array(self.computed), 0
        )
        return mac

    def plot(self, *, ax: Any = None) -> "Figure":
        """Draw the measured and the computed curves on the same axes.

        Parameters
        ----------
        ax : sequence of two Axes, optional
            Panels for amplitude and phase; None makes a new figure.

        Returns
        -------
        matplotlib.figure.Figure
            Amplitudes above, phases below; measured curves solid, computed ones dashed.

        Raises
        ------
        SceneError
            If the curves have different quantities.
        """
        with extra("plot"):
            from gearbow.plotting import harmonic as figures  # noqa: PLC0415

        quantities = {one.quantity for one in self.measured}
        if len(quantities) > 1:
            raise SceneError(f"plot: the curves have different quantities: {sorted(quantities)}")
        unit = {"displacement": "m", "velocity": "m/s", "acceleration": "m/s²"}[quantities.pop()]
        lines = {}
        for one, own, frac in zip(self.measured, self.computed, self.frac, strict=True):
            for name, values in (("measured", one.values), (f"computed (FRAC {frac:.3f})", own)):
                lines[f"{one.label}, {name}"] = figures.Curve.of(one.frequencies, values)
        return figures.bode(lines, unit, over="frequency", frf=True, pairs=True, ax=ax)


def _assurance(measured: Any, computed: Any, axis: int) -> Any:
    """Give |Σ m* c|²/(Σ|m|² Σ|c|²) over an axis; 0 where one is zero."""
    cross = np.abs(np.sum(np.conj(measured) * computed, axis=axis)) ** 2
    sizes = np.sum(np.abs(measured) ** 2, axis=axis) * np.sum(np.abs(computed) ** 2, axis=axis)
    return np.divide(cross, sizes, out=np.zeros_like(sizes), where=sizes > 0.0)
