"""Speeds and speed profiles, and tables of coefficients over the speed."""

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass
from typing import Any, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gearbow._convert import array, function, matrix, number, one_of, positive, real, shown
from gearbow._core import check_speed, table_at_frequency
from gearbow._shown import ReadOnly
from gearbow._types import Array, BearingQuantity, OutsideTable, Plain, TableAxes
from gearbow.description.part import Part, freeze
from gearbow.errors import SceneError, SceneWarning, warn

#: Tolerance of the sampling of a function, relative to the largest speed. Each cubic piece is
#: compared with the function at two points; elsewhere the error is at most twice as large.
_ACCURACY = 5e-11
#: Initial and largest number of pieces of a sampled function.
_FIRST, _MOST = 32, 200_000
#: A shorter piece, as a fraction of the duration, indicates a jump of the function.
_SHORTEST = 2.0**-44


@dataclass(frozen=True, eq=False)
class SpeedProfile(ReadOnly):
    """Speed of the reference shaft as a piecewise polynomial of time.

    The speed is constant before the first break and after the last one. The angle and the
    acceleration follow exactly. Use `ramp`, `table` or `function`, or give the breaks and
    coefficients of a polynomial of SciPy (``PPoly``, ``CubicSpline``).

    Parameters
    ----------
    breaks : ndarray, shape (m + 1,)
        Times between the pieces, ascending [s].
    coefficients : ndarray, shape (order, m)
        Coefficients of each piece in the time since its break, the highest power first. The degree
        is at most 3 [rad/s, rad/s², ...].

    Raises
    ------
    SceneError
        If times do not ascend, a number is not finite, or the speed is discontinuous.

    Examples
    --------
    >>> import gearbow as gb
    >>> run_up = gb.SpeedProfile.ramp(50.0, 150.0, duration=2.0)
    >>> run_up([0.0, 1.0, 2.0, 3.0])
    array([ 50., 100., 150., 150.])
    """

    breaks: Array
    coefficients: Array

    def __post_init__(self) -> None:
        for name, axes in (("breaks", 1), ("coefficients", 2)):
            values = matrix(getattr(self, name), f"speed.{name}")
            if values.ndim != axes:
                raise SceneError(f"speed.{name}: must have {axes} axes, got {values.ndim}")
            object.__setattr__(self, name, values)
        check_speed(self.breaks.tolist(), self.coefficients.tolist())
        super().__post_init__()

    @classmethod
    def ramp(
        cls, start: float, end: float, duration: float, *, begin: float = 0.0
    ) -> "SpeedProfile":
        """Make a linear change from one speed to another.

        Parameters
        ----------
        start, end : float
            Initial and final speed [rad/s]; the final one is constant afterwards.
        duration, begin : float
            Duration of the change, and time at which it begins [s].
        """
        begin, duration = number(begin, "speed.begin"), positive(duration, "speed.duration")
        return cls.table(
            [begin, begin + duration], [number(start, "speed.start"), number(end, "speed.end")]
        )

    @classmethod
    def table(cls, times: "ArrayLike", speeds: "ArrayLike") -> "SpeedProfile":
        """Interpolate linearly between points.

        Parameters
        ----------
        times, speeds : array_like, shape (m + 1,)
            Ascending times [s] and the speeds at them [rad/s].
        """
        t, values = array(times, "speed.times"), array(speeds, "speed.speeds")
        if t.shape != values.shape or t.size < 2:
            raise SceneError(
                f"speed: needs equal numbers of times and speeds, at least two, got {t.size} times "
                f"and {values.size} speeds"
            )
        # The core rejects times that do not ascend.
        with np.errstate(divide="ignore", invalid="ignore"):
            slopes = np.where(np.diff(t) > 0.0, np.diff(values) / np.diff(t), 0.0)
        return cls(t, np.array([slopes, values[:-1]]))

    @classmethod
    def function(
        cls, f: Callable[[Any], Any], duration: float, *, begin: float = 0.0
    ) -> "SpeedProfile":
        """Approximate a function of time to 1e-10 of the largest speed.

        Parameters
        ----------
        f : callable
            Gives the speed [rad/s] at a time [s], or at an array of times.
        duration, begin : float
            Duration and begin of the approximation [s]; before and after it the speed is constant.

        Returns
        -------
        SpeedProfile
            Cubic pieces through values of the function.

        Raises
        ------
        SceneError
            If `f` is no function, is discontinuous, or has a value that is not finite.
        """
        begin, duration = number(begin, "speed.begin"), positive(duration, "speed.duration")
        function(f, "speed.f")
        left, coefficients = sampled(f, np.linspace(begin, begin + duration, _FIRST + 1), "speed")
        return cls(np.append(left, begin + duration), coefficients)

    def __call__(self, times: "ArrayLike") -> Array:
        """Evaluate the speed."""
        t = np.clip(matrix(times, "times"), self.breaks[0], self.breaks[-1])
        piece = np.clip(np.searchsorted(self.breaks, t, side="right") - 1, 0, self.breaks.size - 2)
        since = t - self.breaks[piece]
        return _polynomial(self.coefficients, piece, since)

    def angle(self, times: "ArrayLike") -> Array:
        """Integrate the speed exactly.

        Parameters
        ----------
        times : array_like, shape (k,) or scalar
            Times [s].

        Returns
        -------
        ndarray, shape (k,)
            Angle since the first break, negative before it [rad].
        """
        t = matrix(times, "times")
        order, pieces = self.coefficients.shape
        powers = np.arange(order, 0, -1)[:, np.newaxis]
        integral = np.vstack([self.coefficients / powers, np.zeros(pieces)])
        whole = _polynomial(integral, np.arange(pieces), np.diff(self.breaks))
        before = np.concatenate([[0.0], np.cumsum(whole)])
        inner = np.clip(t, self.breaks[0], self.breaks[-1])
        piece = np.clip(np.searchsorted(self.breaks, inner, side="right") - 1, 0, pieces - 1)
        outside = (t - inner) * self(inner)
        return before[piece] + _polynomial(integral, piece, inner - self.breaks[piece]) + outside

    def __repr__(self) -> str:
        start, end = self.breaks[[0, -1]]
        first, last = self([start, end])
        return (
            f"SpeedProfile({self.breaks.size - 1} pieces, {start:g} s to {end:g} s; "
            f"{first:g} rad/s to {last:g} rad/s)"
        )


def _polynomial(coefficients: Array, piece: NDArray[np.intp], since: Array) -> Array:
    """Evaluate the polynomial of each piece at times since its break."""
    value: Array = np.zeros_like(since)
    for row in coefficients:
        value = value * since + row[piece]
    return value


def plain_speed(speed: float | SpeedProfile) -> Plain:
    """Give a speed as plain data."""
    if isinstance(speed, SpeedProfile):
        return {"breaks": speed.breaks.tolist(), "coefficients": speed.coefficients.tolist()}
    return speed


def read_speed(plain: Plain) -> float | SpeedProfile:
    """Read a speed from plain data, the inverse of `plain_speed`."""
    return SpeedProfile(**plain) if isinstance(plain, dict) else float(plain)


def sampled(f: Callable[[Any], Any], breaks: Array, path: str) -> tuple[Array, Array]:
    """Approximate a function by cubic pieces, each through four of its values."""
    shortest = max(_SHORTEST * (breaks[-1] - breaks[0]), 1e-15 * np.abs(breaks).max())
    left, right = breaks[:-1], breaks[1:]
    done: list[tuple[Array, Array]] = []
    pieces, largest = 0, 0.0
    while left.size:
        # The cubic interpolates the first four values; the other two check it.
        parts = np.array([0.0, 1 / 3, 2 / 3, 1.0, 1 / 6, 1 / 2])[:, np.newaxis]
        times = left + (right - left) * parts
        times[3] = right  # exactly the beginning of the next piece
        values = evaluated(f, times, path)
        largest = max(largest, float(np.abs(values).max()))
        a, b, c, d = values[:4]
        h = right - left
        cubic = np.array(
            [
                4.5 * (d - a + 3.0 * (b - c)) / h**3,
                4.5 * (2.0 * a - 5.0 * b + 4.0 * c - d) / h**2,
                (-5.5 * a + 9.0 * b - 4.5 * c + d) / h,
                a,
            ]
        )
        x = parts[4:] * h
        fitted = ((cubic[0] * x + cubic[1]) * x + cubic[2]) * x + cubic[3]
        good = np.abs(fitted - values[4:]).max(axis=0) <= _ACCURACY * largest
        done.append((left[good], cubic[:, good]))
        pieces += int(np.count_nonzero(good))
        left, right = left[~good], right[~good]
        if left.size and (h.min() < shortest or pieces + left.size > _MOST):
            raise SceneError(
                f"{path}: the function is discontinuous or not smooth enough at {left[0]:g} s"
            )
        middle = (left + right) / 2.0
        left, right = np.concatenate([left, middle]), np.concatenate([middle, right])
    order = np.argsort(np.concatenate([begin for begin, _ in done]))
    return (
        np.concatenate([begin for begin, _ in done])[order],
        np.concatenate([cubic for _, cubic in done], axis=1)[:, order],
    )


def evaluated(f: Callable[[Any], Any], times: Array, path: str, unit: str = "s") -> Array:
    """Evaluate a function that takes one time, or another argument, or an array of them."""
    flat = times.reshape(-1)
    try:
        values: NDArray[Any] = np.asarray(f(flat))
    except (TypeError, ValueError, OverflowError):  # the function takes a single time
        values = np.empty(0)
    if values.shape != flat.shape or values.dtype.kind not in "iuf":
        values = np.array([_value(f(float(t)), path) for t in flat])
    values = values.astype(np.float64)
    if not np.isfinite(values).all():
        at = int(np.argmin(np.isfinite(values)))
        raise SceneError(f"{path}: the function gives {values[at]} at {flat[at]:g} {unit}")
    return values.reshape(times.shape)


def _value(value: object, path: str) -> float:
    """Check one value of a function of time."""
    if isinstance(value, np.ndarray) and value.ndim == 0:
        value = value[()]
    try:
        return float(real(value, path))
    except SceneError:
        raise SceneError(f"{path}: the function must give a number, got {shown(value)}") from None


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
        "error" rejects speeds and frequencies outside; "hold" uses the first or last value.
    frequencies : array_like, shape (m,), optional
        At least two ascending frequencies of the vibration [rad/s]; None if they have no effect.

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

    speeds: "ArrayLike | None"
    values: "ArrayLike"
    outside: OutsideTable = "error"
    _: KW_ONLY
    frequencies: "ArrayLike | None" = None

    def __post_init__(self) -> None:
        freeze(self, "speeds", "values", "frequencies")

    @classmethod
    def _from_description(cls, description: Mapping[str, Plain]) -> "SpeedTable":
        return super()._from_description({"speeds": None, **description})

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
        warn(
            f"{os.fspath(path)}: the added masses are left out: {', '.join(given)}",
            SceneWarning,
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
