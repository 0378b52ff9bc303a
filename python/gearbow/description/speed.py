"""Prescribed speed of a run as a piecewise polynomial of time."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gearbow._convert import array, function, matrix, number, real, shown
from gearbow._core import check_speed
from gearbow._read_only import ReadOnly
from gearbow._types import Array, Plain
from gearbow.errors import SceneError

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
        start : float
            Initial speed [rad/s].
        end : float
            Final speed [rad/s], constant afterwards.
        duration : float
            Duration of the change [s].
        begin : float
            Time at which the change begins [s].

        Returns
        -------
        SpeedProfile
            The profile.

        Raises
        ------
        SceneError
            If the duration is not positive, or a number is not finite.
        """
        begin, duration = number(begin, "speed.begin"), number(duration, "speed.duration")
        if not duration > 0.0:
            raise SceneError(f"speed.duration: must be positive, got {duration!r}")
        return cls.table(
            [begin, begin + duration], [number(start, "speed.start"), number(end, "speed.end")]
        )

    @classmethod
    def table(cls, times: "ArrayLike", speeds: "ArrayLike") -> "SpeedProfile":
        """Interpolate linearly between points.

        Parameters
        ----------
        times : array_like, shape (m + 1,)
            Times, ascending [s].
        speeds : array_like, shape (m + 1,)
            Speeds [rad/s].

        Returns
        -------
        SpeedProfile
            The profile.

        Raises
        ------
        SceneError
            If times do not ascend, or the numbers of times and speeds differ.
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
        duration : float
            Duration of the approximation [s]; the speed is constant afterwards.
        begin : float
            Time at which the approximation begins [s]; the speed is constant before.

        Returns
        -------
        SpeedProfile
            Cubic pieces through values of the function.

        Raises
        ------
        SceneError
            If `f` is no function, is discontinuous, or has a value that is not finite.
        """
        begin, duration = number(begin, "speed.begin"), number(duration, "speed.duration")
        if not duration > 0.0:
            raise SceneError(f"speed.duration: must be positive, got {duration!r}")
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
