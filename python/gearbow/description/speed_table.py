"""Coefficients of a bearing that depend on the speed of its shaft."""

import os
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from gearbow._lookup import one_of
from gearbow.description.part import Part, freeze
from gearbow.errors import SceneError

__all__ = ["SpeedTable"]

#: Letter of the columns of each quantity.
_LETTERS = {"stiffness": "k", "damping": "c"}
#: Columns of tables with the shaft along z, and what a message says of them.
_OTHER_AXES = {
    f"{letter}{axes}": (
        f"; here x is the axis of the shaft: a table with x and y across the shaft (ROSS, API) has "
        f"{letter}xx, {letter}xy, {letter}yx, {letter}yy for {letter}yy, {letter}yz, {letter}zy, "
        f"{letter}zz"
    )
    for letter in _LETTERS.values()
    for axes in ("xx", "xy", "yx", "xz", "zx")
}


@dataclass(frozen=True)
class SpeedTable(Part):
    """A bearing coefficient against the magnitude of the speed of the shaft.

    Each entry is interpolated by a monotone piecewise cubic (PCHIP) through the given values, as by
    `scipy.interpolate.PchipInterpolator`.

    Parameters
    ----------
    speeds : array_like, shape (k,)
        Magnitudes of the speed of the shaft that carries the bearing [rad/s], ascending from zero
        or above; at least two.
    values : array_like, shape (k,), (k, 2) or (k, 2, 2)
        Stiffness [N/m] or damping [N s/m] at each speed: a number for every direction, (yy, zz), or
        [[yy, yz], [zy, zz]].
    outside : str
        "error" rejects speeds outside the table; "hold" uses the first or the last value there.

    Notes
    -----
    `gearbow.RotorSystem` reports an invalid table as a `gearbow.SceneError`. The interpolation is
    that of Fritsch and Carlson, *Monotone piecewise cubic interpolation*, SIAM J. Numer. Anal. 17
    (1980), with the slopes of Fritsch and Butland (1984).

    At a constant speed the bearing is linear, with the coefficients at that speed. In a run with a
    changing speed, stiffness and damping change with the speed. The work of the stiffness change is
    counted as work of the drive.

    The axis of the shaft is x. ROSS, and bearing programs after API standards, call the directions
    across the shaft x and y: their kxx, kxy, kyx, kyy are yy, yz, zy, zz here. The first index is
    the direction of the force, the second that of the displacement, F_y = k_yy v + k_yz w. The
    senses agree if the shaft turns from x to y there, as it turns from y to z here; if it turns
    from y to x, change the sign of both cross coefficients. Cross coefficients of opposite signs,
    yz > 0 > zy, drive the forward whirl.

    Examples
    --------
    >>> import gearbow as gb
    >>> stiffness = gb.SpeedTable([0.0, 200.0, 500.0], [2e7, 3e7, 8e7], outside="hold")
    >>> damping = gb.SpeedTable([0.0, 500.0], [(900.0, 900.0), (300.0, 400.0)], outside="hold")
    >>> bearings = [gb.Bearing("rotor", x, stiffness=stiffness, damping=damping) for x in (0, 1)]
    >>> rotor = gb.Shaft("rotor", length=1.0, outer_diameter=0.05)
    >>> system = gb.RotorSystem(shafts=[rotor], bearings=bearings)
    >>> for speed in (0.0, 500.0):
    ...     print(f"{system.modes(speed).frequencies_hz[0]:.1f} Hz")
    94.7 Hz
    98.9 Hz
    """

    speeds: ArrayLike
    values: ArrayLike
    outside: str = "error"

    def __post_init__(self) -> None:
        freeze(self, "speeds", "values")

    @classmethod
    def read_csv(
        cls, path: str | os.PathLike[str], quantity: str = "stiffness", *, outside: str = "error"
    ) -> "SpeedTable":
        r"""Read the coefficients of a bearing from a CSV file.

        Parameters
        ----------
        path : str or path-like
            A file with the columns "speed" and "k", or "kyy", "kzz", "kyz", "kzy", for stiffness,
            and the same with "c" for damping. A heading has the unit in brackets, for example
            "speed [rpm]" or "kyy [N/um]"; without one it is the SI unit. A cross coefficient that
            has no column is zero. Separators are commas, semicolons or tabs; lines that begin with
            "#" are comments.
        quantity : {"stiffness", "damping"}
            Which of both to read; one file can have both.
        outside : str
            What holds outside the speeds, see the class.

        Returns
        -------
        SpeedTable
            The table.

        Raises
        ------
        SceneError
            If a heading, a unit or a number is invalid, or a column is missing.
        OSError
            If the file cannot be opened.

        Examples
        --------
        >>> from pathlib import Path
        >>> import gearbow as gb
        >>> text = "speed [rpm], kyy [N/um], kzz [N/um], c [N s/m]\n0,20,30,500\n3000,25,35,400"
        >>> written = Path("bearing.csv").write_text(text)
        >>> gb.SpeedTable.read_csv("bearing.csv").values[1]
        ((25000000.0, 0.0), (0.0, 35000000.0))
        >>> gb.SpeedTable.read_csv("bearing.csv", "damping").values
        (500.0, 400.0)
        >>> Path("bearing.csv").unlink()
        """
        from gearbow.exchange.columns import read_columns  # noqa: PLC0415  # few scenes need it

        one_of(quantity, _LETTERS, "quantity")
        axes = ("", "yy", "zz", "yz", "zy")
        known = {f"{_LETTERS[q]}{each}": f"bearings.{q}" for q in _LETTERS for each in axes}
        found = read_columns(path, {"speed": "speed", **known}, _OTHER_AXES)
        k = _LETTERS[quantity]
        if "speed" not in found:
            raise SceneError(f'{path}: needs the column "speed"')
        if k in found:
            others = [name for name in found if name.startswith(k) and name != k]
            if others:
                raise SceneError(
                    f'{path}: has the column "{k}", which is isotropic, and "{others[0]}"; give '
                    f'either "{k}", or "{k}yy" and "{k}zz"'
                )
            return cls(found["speed"], found[k], outside)
        if f"{k}yy" not in found or f"{k}zz" not in found:
            raise SceneError(f'{path}: needs the column "{k}", or "{k}yy" and "{k}zz"')
        zero = 0.0 * found["speed"]
        yy, zz, yz, zy = (found.get(f"{k}{each}", zero) for each in axes[1:])
        return cls(found["speed"], np.moveaxis(np.array([[yy, yz], [zy, zz]]), -1, 0), outside)
