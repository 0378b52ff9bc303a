"""Coefficients of a bearing that depend on the speed of its shaft or on the frequency."""

import os
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import KW_ONLY, dataclass
from typing import get_args

import numpy as np
from numpy.typing import ArrayLike

from gearbow._convert import number, shown
from gearbow._core import table_at_frequency
from gearbow._lookup import one_of
from gearbow._types import Array, BearingQuantity, OutsideTable, Plain, TableAxes
from gearbow.description.part import Part, freeze
from gearbow.errors import SceneError, SceneWarning, outside

#: Letter of the columns of each quantity.
_LETTERS = {"stiffness": "k", "damping": "c"}
#: Letter of the columns of added masses.
_MASS = "m"


@dataclass(frozen=True)
class SpeedTable(Part):
    """A bearing coefficient against the speed of the shaft, the frequency or both.

    Each entry is interpolated by a monotone piecewise cubic (PCHIP) through the given values, as by
    `scipy.interpolate.PchipInterpolator`.

    Parameters
    ----------
    speeds : array_like, shape (k,), optional
        Magnitudes of the speed of the shaft that carries the bearing [rad/s], ascending from zero
        or above; at least two. None if the speed has no effect.
    values : array_like, shape (k,), (k, 2) or (k, 2, 2), or (k, m, ...) with m frequencies
        Stiffness [N/m] or damping [N s/m] at each speed: a number for every direction, (yy, zz), or
        [[yy, yz], [zy, zz]]; with `frequencies` at each speed and frequency, or at each frequency
        if `speeds` is None.
    outside : str
        "error" rejects speeds and frequencies outside the table; "hold" uses the first or the last
        value there.
    frequencies : array_like, shape (m,), optional
        Magnitudes of the frequency of the vibration [rad/s], ascending from zero or above; at least
        two. None if the frequency has no effect.

    Notes
    -----
    `gearbow.RotorSystem` reports an invalid table as a `gearbow.SceneError`. The interpolation is
    that of Fritsch and Carlson, *Monotone piecewise cubic interpolation*, SIAM J. Numer. Anal. 17
    (1980), with the slopes of Fritsch and Butland (1984).

    At a constant speed the bearing is linear, with the coefficients at that speed. In a run with a
    changing speed, stiffness and damping change with the speed. The work of the stiffness change is
    counted as work of the drive.

    The frequency is the magnitude of that of the vibration: a frequency response has the
    coefficients at each of its frequencies, and each mode those at its own. Intersections of a
    Campbell diagram and critical speeds follow from that; a static equilibrium has the frequency 0.
    Runs and steady motions contain many frequencies at once and refuse the table; `at_frequency`
    gives them the coefficients at one.

    The axis of the shaft is x. ROSS, and bearing programs after API standards, call the directions
    across the shaft x and y: their kxx, kxy, kyx, kyy are yy, yz, zy, zz here. The first index is
    the direction of the force, the second that of the displacement, F_y = k_yy v + k_yz w. The
    senses agree if the shaft turns from x to y there, as it turns from y to z here; if it turns
    from y to x, their kyy, kyx, kxy, kxx are yy, yz, zy, zz. `read_table` reads both. Cross
    coefficients of opposite signs, yz > 0 > zy, drive the forward whirl.

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

    A rubber ring that is stiffer at higher frequencies:

    >>> ring = gb.SpeedTable(None, [2e7, 3e7, 4e7], "hold", frequencies=[0.0, 300.0, 900.0])
    >>> soft = [gb.Bearing("rotor", x, stiffness=ring) for x in (0, 1)]
    >>> mode = system.replace(bearings=soft).modes(count=1)
    >>> same = [gb.Bearing("rotor", x, stiffness=4e7) for x in (0, 1)]
    >>> print(mode.frequencies_hz < system.replace(bearings=same).modes(count=1).frequencies_hz)
    [ True]
    """

    speeds: ArrayLike | None
    values: ArrayLike
    outside: OutsideTable = "error"
    _: KW_ONLY
    frequencies: ArrayLike | None = None

    def __post_init__(self) -> None:
        freeze(self, "speeds", "values", "frequencies")

    @classmethod
    def _from_description(cls, description: Mapping[str, Plain]) -> "SpeedTable":
        return cls(**{"speeds": None, **description})

    def at_frequency(self, frequency: float) -> "SpeedTable | Array":
        """Give the coefficient at one frequency, as a run in time needs it.

        Parameters
        ----------
        frequency : float
            Frequency of the vibration [rad/s].

        Returns
        -------
        SpeedTable or array, shape (2, 2)
            The table over the speed; without `speeds`, the matrix [[yy, yz], [zy, zz]].

        Raises
        ------
        SceneError
            If the table is invalid or does not contain the frequency.

        Examples
        --------
        >>> import gearbow as gb
        >>> ring = gb.SpeedTable(None, [2e7, 3e7], frequencies=[0.0, 1000.0])
        >>> bearing = gb.Bearing("rotor", 0.0, stiffness=ring.at_frequency(1000.0))
        >>> bearing.stiffness[0]
        array([30000000.,        0.])
        """
        found = table_at_frequency(self._describe("table"), number(frequency, "frequency"))
        if isinstance(found, Mapping):
            return SpeedTable._from_description(found)
        return np.array(found)

    @classmethod
    def read_table(
        cls,
        path: str | os.PathLike[str],
        quantity: BearingQuantity = "stiffness",
        *,
        axes: TableAxes = "yz",
        units: Mapping[str, str] | None = None,
        outside: OutsideTable = "error",
    ) -> "SpeedTable":
        r"""Read the coefficients of a bearing from a table of another program.

        Parameters
        ----------
        path : str or path-like
            A text file (``.csv``, ``.txt``, ``.tsv``, ``.dat``), an Excel file ``.xlsx`` (its first
            sheet; extra ``dataframe``) or a MATLAB file ``.mat`` of versions 4 to 7 with a vector
            for each column. The columns are "speed" or "rpm", and for stiffness "k", or "kyy",
            "kzz", "kyz", "kzy", in capital or small letters; for damping the same with "c", and for
            added masses, which are left out, with "m". A heading has the unit in brackets, for
            example "speed [rpm]" or "Kyy (lbf/in)", or the line below the headings has the units. A
            cross coefficient that has no column is zero. Separators of text are semicolons, tabs,
            commas or spaces, of decimals points or commas; lines that begin with "#" are comments.
        quantity : {"stiffness", "damping"}
            Which of both to read; one file can have both.
        axes : str
            The two axes across the shaft in the headings: the first is y here, the second z. The
            shaft turns from the first to the second. "xy" reads Kxx, Kxy, Kyx and Kyy, "yx" is for
            a table of the same names whose shaft turns from y to x.
        units : mapping of str to str, optional
            Units of headings without one, by "speed", "stiffness" and "damping", for example
            {"speed": "rpm", "stiffness": "N/um"}. Without them the numbers are in SI units.
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
        MissingExtraError
            If the format needs a library that is not installed.
        OSError
            If the file cannot be opened.

        Warns
        -----
        SceneWarning
            If the table has added masses that are not zero.

        Examples
        --------
        >>> from pathlib import Path
        >>> import gearbow as gb
        >>> text = "speed [rpm], Kxx [N/um], Kyy [N/um], c [N s/m]\n0,20,30,500\n3000,25,35,400"
        >>> written = Path("bearing.csv").write_text(text)
        >>> gb.SpeedTable.read_table("bearing.csv", axes="xy").values[1]
        ((25000000.0, 0.0), (0.0, 35000000.0))
        >>> gb.SpeedTable.read_table("bearing.csv", "damping", axes="xy").values
        (500.0, 400.0)
        >>> Path("bearing.csv").unlink()
        """
        from gearbow.exchange.tables import read_table  # noqa: PLC0415  # few scenes need it

        one_of(quantity, _LETTERS, "quantity")
        names = _names(axes)
        fields = {f"{_LETTERS[q]}{name}": q for q in _LETTERS for name in ("", *names)}
        masses = {f"{_MASS}{name}": "mass" for name in ("", *names)}
        found = read_table(
            path,
            {"speed": "speed", "rpm": "speed"}
            | {key: f"bearings.{fields[key]}" for key in fields}
            | masses,
            hints=_other_axes(names),
            units={"rpm": "rpm"} | _units(units, {"speed": "speed", **fields}),
        ).numbers
        _warn_of_masses(path, {name: found[name] for name in masses if name in found})
        k = _LETTERS[quantity]
        speeds = [found[name] for name in ("speed", "rpm") if name in found]
        if len(speeds) != 1:
            raise SceneError(f'{path}: needs the column "speed" or "rpm", and only one of them')
        if k in found:
            others = [name for name in found if name.startswith(k) and name != k]
            if others:
                raise SceneError(
                    f'{path}: has the column "{k}", which is isotropic, and "{others[0]}"; give '
                    f'either "{k}", or "{k}{names[0]}" and "{k}{names[1]}"'
                )
            return cls(speeds[0], found[k], outside)
        if not {f"{k}{name}" for name in names[:2]} <= found.keys():
            raise SceneError(
                f'{path}: needs the column "{k}", or "{k}{names[0]}" and "{k}{names[1]}"'
            )
        zero = 0.0 * speeds[0]
        yy, zz, yz, zy = (found.get(f"{k}{name}", zero) for name in names)
        return cls(speeds[0], np.moveaxis(np.array([[yy, yz], [zy, zz]]), -1, 0), outside)


def _names(axes: TableAxes) -> tuple[str, str, str, str]:
    """Give the ends of the headings that are yy, zz, yz, zy here."""
    one_of(axes, get_args(TableAxes), "axes")
    first, second = axes[0], axes[1]
    return 2 * first, 2 * second, first + second, second + first


def _other_axes(names: Sequence[str]) -> dict[str, str]:
    """Give the ends of messages for headings with other axes."""
    hint = '; name the axes of the table, for example axes="xy": y here is its x, z its y'
    return {
        f"{letter}{first}{second}": hint
        for letter in (*_LETTERS.values(), _MASS)
        for first in "xyz"
        for second in "xyz"
        if f"{first}{second}" not in names
    }


def _warn_of_masses(path: str | os.PathLike[str], masses: Mapping[str, Array]) -> None:
    """Warn of added masses, which a bearing of gearbow does not have."""
    given = [f"{name} up to {max(abs(m)):.4g} kg" for name, m in masses.items() if np.any(m)]
    if given:
        warnings.warn(
            f"{os.fspath(path)}: the added masses are left out: {', '.join(given)}",
            SceneWarning,
            stacklevel=outside(),
        )


def _units(units: Mapping[str, str] | None, quantities: Mapping[str, str]) -> dict[str, str]:
    """Give the unit of each column that the call names."""
    given = {} if units is None else units
    is_mapping = isinstance(given, Mapping)
    if not is_mapping or not all(isinstance(each, str) for each in given.values()):
        raise SceneError(f"units: must be a mapping of names to units, got {shown(units)}")
    for name in given:
        one_of(name, ("speed", *_LETTERS), "units")
    return {column: given[name] for column, name in quantities.items() if name in given}
