"""Natural modes of a system, and what they look like in words."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from gearbow._convert import whole
from gearbow._extras import extra
from gearbow._read_only import ReadOnly
from gearbow._types import Array, ComplexArray, Dof

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

    from gearbow.system import RotorSystem

__all__ = ["Modes"]

#: Motions that one word stands for; bending in a plane is told by its translation.
_DIRECTION = {"v": "v", "G": "v", "w": "w", "B": "w", "twist": "twist"}


@dataclass(frozen=True, eq=False)
class Modes(ReadOnly):
    """Natural modes at one speed, in ascending order of frequency.

    Parameters
    ----------
    frequencies_hz : ndarray, shape (m,)
        Damped natural frequencies [Hz]; 0 for rigid-body rotation.
    damping_ratios : ndarray, shape (m,)
        Damping ratios.
    whirl : tuple of str
        "forward", "backward", "planar", "torsion", "rigid" or "coupled" for each mode.
    shapes : ndarray, shape (m, n)
        Complex shapes; the motion is Re(shape exp(eigenvalue t)).
    eigenvalues : ndarray, shape (m,)
        Complex eigenvalues [1/s].
    speed : float
        Speed of the reference shaft [rad/s].
    dofs : tuple of (str, float, str)
        Shaft, position [m] and direction of each degree of freedom.
    system : RotorSystem
        The system that was asked.

    Examples
    --------
    >>> import gearbow as gb
    >>> bearings = [gb.Bearing("rotor", x, stiffness=1e8) for x in (0.0, 1.0)]
    >>> rotor = gb.Shaft("rotor", length=1.0, outer_diameter=0.05, elements=8)
    >>> modes = gb.RotorSystem(shafts=[rotor], bearings=bearings).modes(speed=300.0, count=2)
    >>> modes.whirl
    ('backward', 'forward')
    """

    frequencies_hz: Array
    damping_ratios: Array
    whirl: tuple[str, ...]
    shapes: ComplexArray
    eigenvalues: ComplexArray
    speed: float
    dofs: tuple[Dof, ...]
    system: "RotorSystem" = field(repr=False)

    def energy_shares(self) -> dict[tuple[str, str], Array]:
        """Share of each shaft and direction in the kinetic energy of each mode.

        Returns
        -------
        dict of {(str, str): ndarray of shape (m,)}
            The share by (shaft, "v" | "w" | "twist"); rotary inertia counts with the translation
            that it belongs to. The shares of a mode add up to 1, so that metres and radians
            compare.
        """
        mass = self.system.matrices().mass
        energy = np.real(self.shapes.conj() * (self.shapes @ mass))
        energy /= energy.sum(axis=1, keepdims=True)
        groups = [(shaft, _DIRECTION[direction]) for shaft, _, direction in self.dofs]
        return {
            group: energy[:, [other == group for other in groups]].sum(axis=1)
            for group in dict.fromkeys(groups)
        }

    def names(self) -> list[str]:
        """Name each shape by where it moves most, e.g. "middle v" or "twist of output".

        Returns
        -------
        list of str, length m
            The motions with at least half the kinetic energy of the largest one; "rigid-body
            rotation" for the rotation of the whole train, which has no stiffness.
        """
        groups, shares = zip(*self.energy_shares().items(), strict=True)
        table = np.array(shares)
        names = []
        for mode, whirl in enumerate(self.whirl):
            order = np.argsort(-table[:, mode], kind="stable")
            largest = table[order[0], mode]
            # Two equal directions differ by round-off only; they stay in the order of the shafts.
            strong = sorted(int(g) for g in order if table[g, mode] >= 0.5 * largest)
            name = _name([groups[g] for g in strong])
            if whirl == "rigid":
                twists = groups[order[0]][1] == "twist"
                name = "rigid-body rotation" if twists else f"rigid motion of {name}"
            names.append(name)
        return names

    def table(self, count: int | None = None) -> str:
        """Lay the modes out as text.

        Parameters
        ----------
        count : int, optional
            How many modes; None is all of them.

        Returns
        -------
        str
            Number, frequency, damping, whirl and name of each mode, one a line.
        """
        lines = [
            f"{'mode':>4}  {'frequency [Hz]':>14}  {'damping [%]':>11}  {'whirl':<9} largest motion"
        ]
        most = None if count is None else whole(count, "count")
        rows = zip(self.frequencies_hz, self.damping_ratios, self.whirl, self.names(), strict=True)
        for number, (frequency, ratio, whirl, name) in enumerate(list(rows)[:most], start=1):
            lines.append(
                f"{number:>4}  {frequency:>14.3f}  {100.0 * ratio:>11.3f}  {whirl:<9} {name}"
            )
        return "\n".join(lines)

    def __str__(self) -> str:
        return self.table()

    def to_dataframe(self) -> "pd.DataFrame":
        """Give the table as a data frame.

        Returns
        -------
        pandas.DataFrame
            One row for each mode.
        """
        with extra("dataframe"):
            import pandas as pd  # noqa: PLC0415

        table: pd.DataFrame = pd.DataFrame(
            {
                "frequency [Hz]": self.frequencies_hz,
                "damping ratio": self.damping_ratios,
                "whirl": list(self.whirl),
                "largest motion": self.names(),
            }
        )
        return table

    def plot(self, number: int | None = None, *, count: int = 6) -> "Figure":
        """Draw one mode of the whole train in space, or the first shapes along the shafts.

        Parameters
        ----------
        number : int, optional
            The mode to draw in space, from 1 as in the table; None is the overview.
        count : int
            How many modes of the overview.

        Returns
        -------
        matplotlib.figure.Figure
            The train with shafts, gears and bearings to scale, or one panel for each mode.

        Raises
        ------
        GearbowError
            If there is no such mode.
        """
        with extra("plot"):
            from gearbow import plots, shape_plot  # noqa: PLC0415

        if number is None:
            return plots.modes(self, whole(count, "count"))
        return shape_plot.shape(self, whole(number, "number"))


def _name(groups: Sequence[tuple[str, str]]) -> str:
    """Put (shaft, direction) pairs in words: "input v and w, twist of output"."""
    lateral: dict[str, list[str]] = {}
    twist = []
    for shaft, direction in groups:
        if direction == "twist":
            twist.append(shaft)
        else:
            lateral.setdefault(shaft, []).append(direction)
    words = [f"{shaft} {' and '.join(directions)}" for shaft, directions in lateral.items()]
    if twist:
        words.append(f"twist of {' and '.join(twist)}")
    return ", ".join(words)
