"""Coefficients of a bearing that depend on the speed of its shaft."""

from dataclasses import dataclass

from numpy.typing import ArrayLike

from gearbow.description.part import Part, freeze

__all__ = ["SpeedTable"]


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
