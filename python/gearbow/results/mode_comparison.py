"""Comparison of computed and measured mode shapes."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from gearbow._extras import extra
from gearbow._read_only import ReadOnly
from gearbow._result import Column, Result
from gearbow._shown import listed
from gearbow._types import Array

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, eq=False)
class ModeComparison(Result, ReadOnly):
    """MAC of computed and measured mode shapes.

    Parameters
    ----------
    mac : ndarray, shape (m, k)
        Modal assurance criterion of each computed mode with each measured one.
    computed_hz : ndarray, shape (m,)
        Computed natural frequencies [Hz].
    measured_hz : ndarray, shape (k,)
        Measured natural frequencies [Hz].

    Notes
    -----
    MAC is abs(Σ conj(φ_m) φ_c)²/(Σ abs(φ_m)² Σ abs(φ_c)²) over the measured places and directions
    (R. J. Allemang, D. L. Brown, *A correlation coefficient for modal vector analysis*, IMAC 1982):
    1 for proportional shapes, 0 for orthogonal ones and for a shape without motion there, such as
    a rotation.

    Examples
    --------
    >>> import gearbow as gb
    >>> bearings = [gb.Bearing("rotor", x, stiffness=(1e7, 2e7)) for x in (0.0, 1.0)]
    >>> rotor = gb.Shaft("rotor", length=1.0, outer_diameter=0.05)
    >>> modes = gb.RotorSystem([rotor], bearings=bearings, motion="lateral").modes(count=2)
    >>> places = (("rotor", 0.0), ("rotor", 0.5))
    >>> shapes = modes.shapes_at(places)
    >>> found = modes.compare(gb.results.MeasuredShapes(places, modes.frequencies_hz, shapes))
    >>> found.mac.round(6)
    array([[1., 0.],
           [0., 1.]])
    """

    mac: Array
    computed_hz: Array
    measured_hz: Array

    @property
    def pairs(self) -> tuple[tuple[int, int], ...]:
        """The computed mode with the largest MAC for each measured one.

        Returns
        -------
        tuple of (int, int)
            Numbers of the computed and the measured mode, from 1.
        """
        best = np.argmax(self.mac, axis=0).tolist() if self.mac.size else []
        return tuple((i + 1, j + 1) for j, i in enumerate(best))

    def plot(self, *, ax: Any = None) -> "Figure":
        """Draw MAC as a table of colours.

        Parameters
        ----------
        ax : Axes, optional
            The panel; None makes a new figure.

        Returns
        -------
        matplotlib.figure.Figure
            Computed modes along the horizontal axis, measured ones along the vertical axis.
        """
        with extra("plot"):
            from gearbow.plotting import shapes as figures  # noqa: PLC0415

        return figures.assurance(self.mac, self.computed_hz, self.measured_hz, ax=ax)

    def _columns(self) -> list[Column]:
        """Give a row for each measured mode."""
        computed, own = np.reshape(np.array(self.pairs, dtype=np.intp), (-1, 2)).T - 1
        found, measured = self.computed_hz[computed], self.measured_hz[own]
        with np.errstate(invalid="ignore", divide="ignore"):
            difference = 100.0 * (found / measured - 1.0)
        return [
            Column("measured mode", own + 1),
            Column("measured", measured, "Hz", ".3f"),
            Column("computed mode", computed + 1),
            Column("computed", found, "Hz", ".3f"),
            Column("difference", difference, "%", ".2f"),
            Column("MAC", self.mac[computed, own], "", ".4f"),
        ]

    def __repr__(self) -> str:
        best = self.mac.max(axis=0, initial=0.0)
        return f"ModeComparison({len(best)} measured modes, largest MAC {listed(best)})"
