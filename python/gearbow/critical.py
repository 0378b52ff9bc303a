"""Undamped critical speeds against the stiffness of the bearings."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from gearbow._convert import array, number, whole
from gearbow._core import Model
from gearbow._extras import extra
from gearbow._lookup import nearest
from gearbow._read_only import ReadOnly
from gearbow._types import Array
from gearbow.errors import GearbowError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from gearbow.system import RotorSystem

__all__ = ["CriticalSpeedMap", "critical_speed_map"]


@dataclass(frozen=True, eq=False)
class CriticalSpeedMap(ReadOnly):
    """Undamped critical speeds against the stiffness of the bearings.

    Parameters
    ----------
    stiffnesses : ndarray, shape (k,)
        Stiffness of every bearing, the same in every direction [N/m].
    excitation : float
        Frequency over the speed of the reference shaft, ω = excitation·Ω.
    speeds : tuple of ndarray
        Critical speeds of the reference shaft [rad/s] for each stiffness, ascending.
    whirl : tuple of tuple of str
        How the train whirls at each of them.

    Examples
    --------
    The stiffer the bearings, the nearer is the first critical speed to that of a pinned shaft:

    >>> import gearbow as gb
    >>> rotor = gb.Shaft("rotor", length=1.0, outer_diameter=0.05, elements=8)
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

    def lines(self, whirl: str) -> Array:
        """Critical speeds of one whirl, number after number.

        Parameters
        ----------
        whirl : str
            "forward", "backward", "planar", "torsion" or "coupled".

        Returns
        -------
        ndarray, shape (k, m)
            Speeds [rad/s], ascending; NaN where a stiffness has fewer.

        Raises
        ------
        GearbowError
            If there is no such critical speed.
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

    def plot(self, count: int = 4) -> "Figure":
        """Draw the map on logarithmic axes.

        Parameters
        ----------
        count : int
            How many lines of each whirl.

        Returns
        -------
        matplotlib.figure.Figure
            One line for each critical speed; its style tells the whirl.
        """
        with extra("plot"):
            from gearbow import frequency_plots  # noqa: PLC0415

        return frequency_plots.critical_speed_map(self, whole(count, "count"))


def critical_speed_map(
    system: "RotorSystem", stiffnesses: ArrayLike, *, excitation: float = 1.0
) -> CriticalSpeedMap:
    """Find the undamped critical speeds against the stiffness of the bearings.

    Parameters
    ----------
    system : RotorSystem
        The system. Every bearing of it takes the given stiffness, the same in every direction;
        damping plays no part.
    stiffnesses : array_like, shape (k,)
        Stiffnesses [N/m].
    excitation : float
        Frequency over the speed of the reference shaft: a critical speed is one where an undamped
        mode has the frequency excitation·Ω. It is 1 for unbalance of the reference shaft, more for
        what happens several times in a turn.

    Returns
    -------
    CriticalSpeedMap
        Critical speeds and their whirl, straight from an eigenproblem for each stiffness.

    Raises
    ------
    SceneError
        If the excitation is not positive, or a stiffness is impossible.
    """
    wanted = array(stiffnesses, "stiffnesses")
    excitation = number(excitation, "excitation")
    speeds, whirl = [], []
    for stiffness in wanted:
        description = system.description
        for bearing in description.get("bearings", ()):
            bearing["stiffness"] = float(stiffness)
            bearing.pop("damping", None)
        found = Model(description).critical_speeds(excitation)
        speeds.append(np.array([speed for speed, _ in found]))
        whirl.append(tuple(name for _, name in found))
    return CriticalSpeedMap(wanted, excitation, tuple(speeds), tuple(whirl))
