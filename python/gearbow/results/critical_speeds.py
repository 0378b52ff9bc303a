"""Map of undamped critical speeds against the bearing stiffness."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gearbow._convert import nearest, text, whole
from gearbow._extras import extra
from gearbow._result import Column, Result, WithSpeeds
from gearbow._shown import ReadOnly, span
from gearbow._types import Array
from gearbow.errors import GearbowError
from gearbow.units.speed import SpeedUnit

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, eq=False)
class CriticalSpeedMap(WithSpeeds, Result, ReadOnly):
    """Undamped critical speeds against the bearing stiffness.

    Parameters
    ----------
    stiffnesses : ndarray, shape (k,)
        Stiffness of every bearing, the same in every direction [N/m].
    order : float
        Order of the excitation, ω = order·Ω; negative for negative speeds.
    speeds : tuple of ndarray
        Critical speeds of the reference shaft [rad/s] for each stiffness, from standstill on.
    whirl : tuple of tuple of str
        Whirl of the mode at each critical speed.
    line : tuple of ndarray of int
        Number from 0 of the line, that of one mode, to which each critical speed belongs.
    residuals : tuple of ndarray
        Residual of the undamped mode at each critical speed, as `Modes.residuals`.
    actual : tuple of float
        Stiffnesses [N/m] along y and z of the system's bearings with constant coefficients.

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
    order: float
    speeds: tuple[Array, ...]
    whirl: tuple[tuple[str, ...], ...]
    line: tuple[NDArray[np.int64], ...]
    residuals: tuple[Array, ...]
    actual: tuple[float, ...] = ()

    @classmethod
    def _from_rows(
        cls,
        stiffnesses: Array,
        order: float,
        found: Sequence[Sequence[tuple[float, str, float, int]]],
        actual: tuple[float, ...],
    ) -> "CriticalSpeedMap":
        """Make a map of the plain data of the core."""
        return cls(
            stiffnesses,
            order,
            speeds=tuple(np.array([speed for speed, *_ in row]) for row in found),
            whirl=tuple(tuple(name for _, name, *_ in row) for row in found),
            line=tuple(np.array([line for *_, line in row], dtype=np.int64) for row in found),
            residuals=tuple(np.array([residual for *_, residual, _ in row]) for row in found),
            actual=actual,
        )

    def _heading(self) -> list[str]:
        return [f"undamped critical speeds of the order {self.order:g}"]

    def _columns(self) -> list[Column]:
        counts = [speeds.size for speeds in self.speeds]
        return [
            Column("stiffness", np.repeat(self.stiffnesses, counts), "N/m"),
            Column("critical speed", np.concatenate([[], *self.speeds]), "rad/s", ".2f"),
            Column("whirl", [whirl for row in self.whirl for whirl in row]),
            Column("line", np.concatenate([np.empty(0, np.int64), *self.line]) + 1),
            Column("residual", np.concatenate([[], *self.residuals]), "", ".1e"),
        ]

    def __repr__(self) -> str:
        lowest = np.array([speeds[0] for speeds in self.speeds if speeds.size])
        return (
            f"CriticalSpeedMap({self.stiffnesses.size} stiffnesses, {span(self.stiffnesses)} N/m; "
            f"lowest critical speed {self._speed_text(lowest)})"
        )

    def lines(self, whirl: str) -> Array:
        """Give the critical speeds of the modes with one whirl as lines.

        Parameters
        ----------
        whirl : str
            "forward", "backward", "mixed", "planar", "torsion", "axial" or "coupled".

        Returns
        -------
        ndarray, shape (k, m)
            Speeds [rad/s]. A column is one mode, which is followed by its shape; the columns have
            the order of their first speeds from standstill on. NaN where the mode has no critical
            speed among those of the map, or another whirl.

        Raises
        ------
        GearbowError
            If no mode has this whirl.
        """
        return self._lines(whirl, joined=False)

    def _lines(self, whirl: str, *, joined: bool) -> Array:
        """Give the lines of a whirl; joined ones begin at the last point before it."""
        text(whirl, "whirl")
        classes = [
            {int(line): name for name, line in zip(*row, strict=True)}
            for row in zip(self.whirl, self.line, strict=True)
        ]
        after = [*classes[1:], {}] if joined else [{}] * len(classes)
        own = [
            {
                line: speed
                for speed, name, line in zip(*row, strict=True)
                if whirl in (name, following.get(int(line)))
            }
            for row, following in zip(
                zip(self.speeds, self.whirl, self.line, strict=True), after, strict=True
            )
        ]
        rows = [(i, line, speed) for i, row in enumerate(own) for line, speed in row.items()]
        if not rows:
            names = sorted({name for names in self.whirl for name in names})
            raise GearbowError(
                f"whirl: no critical speed is {whirl!r}; there are {', '.join(names)}"
                f"{nearest(whirl, names)}"
            )
        first: dict[int, float] = {}
        for _, line, speed in rows:
            first.setdefault(int(line), float(speed))
        column = {
            line: place for place, line in enumerate(sorted(first, key=lambda one: abs(first[one])))
        }
        table: Array = np.full((len(own), len(column)), np.nan)
        for i, line, speed in rows:
            table[i, column[int(line)]] = speed
        return table

    def plot(
        self, count: int = 4, *, ax: Any = None, speed_unit: SpeedUnit | None = None
    ) -> "Figure":
        """Draw the map on logarithmic axes.

        Parameters
        ----------
        count : int
            Number of lines for each whirl.
        ax : Axes, optional
            Panel for the map; None makes a new figure.
        speed_unit : str, optional
            Unit of the axis of speeds, as for `table`; None is that of the given ones.

        Returns
        -------
        matplotlib.figure.Figure
            One line for each mode. Its style shows the whirl: a piece with another whirl begins at
            the last point before it. A vertical line or a grey
            range shows the stiffness of the bearings of the system.
        """
        with extra("plot"):
            from gearbow.plotting import campbell  # noqa: PLC0415

        most = whole(count, "count")
        found = dict.fromkeys(name for names in self.whirl for name in names)
        lines = {whirl: self._lines(whirl, joined=True)[:, :most] for whirl in found}
        with self._showing(speed_unit):
            return campbell.critical_speed_map(
                self.stiffnesses, lines, self.order, actual=self.actual, ax=ax
            )
