"""Map of undamped critical speeds against the bearing stiffness."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from gearbow._convert import whole
from gearbow._extras import extra
from gearbow._lookup import nearest
from gearbow._read_only import ReadOnly
from gearbow._shown import Table, listed, span
from gearbow._types import Array
from gearbow.errors import GearbowError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["CriticalSpeedMap"]


@dataclass(frozen=True, eq=False)
class CriticalSpeedMap(ReadOnly):
    """Undamped critical speeds against the bearing stiffness.

    Parameters
    ----------
    stiffnesses : ndarray, shape (k,)
        Stiffness of every bearing, the same in every direction [N/m].
    excitation : float
        Order of the excitation, ω = excitation·Ω.
    speeds : tuple of ndarray
        Critical speeds of the reference shaft [rad/s] for each stiffness, ascending.
    whirl : tuple of tuple of str
        Whirl of the mode at each critical speed.
    actual : tuple of float
        Stiffnesses along y and z of the bearings of the system that have constant coefficients
        [N/m].

    Examples
    --------
    With increasing bearing stiffness, the first critical speed approaches that of a pinned shaft:

    >>> import gearbow as gb
    >>> rotor = gb.Shaft("rotor", length=1.0, outer_diameter=0.05)
    >>> bearings = [gb.Bearing("rotor", x, stiffness=1e6) for x in (0.0, 1.0)]
    >>> system = gb.RotorSystem(shafts=[rotor], bearings=bearings)
    >>> for speed in system.critical_speed_map([1e6, 1e7, 1e12]).lines("forward")[:, 0]:
    ...     print(f"{speed:.1f} rad/s")
    318.8 rad/s
    563.0 rad/s
    632.6 rad/s
    """

    stiffnesses: Array
    excitation: float
    speeds: tuple[Array, ...]
    whirl: tuple[tuple[str, ...], ...]
    actual: tuple[float, ...] = ()

    def _rows(self) -> Table:
        return (
            ("stiffness [N/m]", "critical speeds [rad/s]"),
            *(
                (f"{stiffness:.4g}", listed(speeds))
                for stiffness, speeds in zip(self.stiffnesses, self.speeds, strict=True)
            ),
        )

    def __repr__(self) -> str:
        lowest = np.array([speeds[0] for speeds in self.speeds if speeds.size])
        return (
            f"CriticalSpeedMap({self.stiffnesses.size} stiffnesses, {span(self.stiffnesses)} N/m; "
            f"lowest critical speed {span(lowest)} rad/s)"
        )

    def lines(self, whirl: str) -> Array:
        """Critical speeds of modes with one whirl.

        Parameters
        ----------
        whirl : str
            "forward", "backward", "planar", "torsion" or "coupled".

        Returns
        -------
        ndarray, shape (k, m)
            Speeds [rad/s], ascending; NaN where a stiffness has fewer critical speeds.

        Raises
        ------
        GearbowError
            If no mode has this whirl.
        """
        rows = [
            speeds[np.array(names, dtype=np.str_) == whirl]
            for speeds, names in zip(self.speeds, self.whirl, strict=True)
        ]
        width = max((row.size for row in rows), default=0)
        if width == 0:
            names = sorted({name for names in self.whirl for name in names})
            raise GearbowError(
                f"no critical speed is {whirl!r}; there are {names}{nearest(str(whirl), names)}"
            )
        table: Array = np.full((len(rows), width), np.nan)
        for line, row in zip(table, rows, strict=True):
            line[: row.size] = row
        return table

    def plot(self, count: int = 4, *, ax: Any = None, speed_unit: str = "rad/s") -> "Figure":
        """Draw the map on logarithmic axes.

        Parameters
        ----------
        count : int
            Number of lines for each whirl.
        ax : Axes, optional
            Panel for the map; None makes a new figure.
        speed_unit : {"rad/s", "rpm"}
            Unit of the axis of speeds.

        Returns
        -------
        matplotlib.figure.Figure
            One line for each critical speed. Its style shows the whirl. A vertical line or a grey
            range shows the stiffness of the bearings of the system.

        Raises
        ------
        GearbowError
            If `ax` or the unit is invalid.
        """
        with extra("plot"):
            from gearbow.plotting import frequency  # noqa: PLC0415

        most = whole(count, "count")
        found = dict.fromkeys(name for names in self.whirl for name in names)
        lines = {whirl: self.lines(whirl)[:, :most] for whirl in found}
        return frequency.critical_speed_map(
            self.stiffnesses,
            lines,
            self.excitation,
            actual=self.actual,
            speed_unit=speed_unit,
            ax=ax,
        )
