"""Forces and torques over time."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from gearbow._convert import array, function, nested, number, shown
from gearbow._types import Array, Plain
from gearbow.description.part import Part, freeze
from gearbow.description.speed import sampled
from gearbow.errors import SceneError
from gearbow.units.values import has_quantity


@dataclass(frozen=True)
class TimeSeries(Part):
    """A force or torque over time, as a piecewise cubic through given values.

    The first value holds before the first time, the last value after the last time.

    Parameters
    ----------
    times : array_like, shape (k,)
        Times [s], ascending; at least two.
    values : array_like, shape (k,), real or complex
        Torque [N m], or force y + iz [N], at each time.
    slopes : array_like, shape (k,), real or complex, optional
        Derivative over time at each time. None: that of the monotone cubic (PCHIP), which does not
        overshoot the values.

    Examples
    --------
    >>> import gearbow as gb
    >>> shock = gb.TimeSeries([0.1, 0.101, 0.102], [0.0, 500.0, 0.0])
    >>> force = gb.Force("disk", shock)
    """

    times: ArrayLike
    values: ArrayLike
    slopes: ArrayLike | None = None

    def __post_init__(self) -> None:
        freeze(self, "times")
        for name in ("values", "slopes"):
            value = getattr(self, name)
            if value is not None and not has_quantity(value):
                object.__setattr__(self, name, _numbers(value, name))

    @classmethod
    def function(
        cls,
        f: Callable[[Any], Any],
        duration: float,
        *,
        begin: float = 0.0,
        path: str = "time_series",
    ) -> "TimeSeries":
        """Approximate a function of time to 1e-9 of its largest value.

        Parameters
        ----------
        f : callable
            Gives the torque [N m] or force y + iz [N] at a time [s].
        duration : float
            Duration of the approximation [s].
        begin : float
            Time at which the approximation begins [s].
        path : str
            Beginning of error messages.

        Returns
        -------
        TimeSeries
            Cubic pieces through values of the function.

        Raises
        ------
        SceneError
            If `f` is no function, is discontinuous, or has a value that is not finite.
        """
        begin, duration = number(begin, f"{path}.begin"), number(duration, f"{path}.duration")
        if not duration > 0.0:
            raise SceneError(f"{path}.duration: must be positive, got {duration!r}")
        function(f, f"{path}.f")
        first = np.linspace(begin, begin + duration, 33)
        pieces = [
            sampled(lambda t: np.real(f(t)), first, path),
            sampled(lambda t: np.imag(f(t)), first, path),
        ]
        times = np.unique(np.concatenate([*(left for left, _ in pieces), first[-1:]]))
        parts = [_hermite(left, cubic, times) for left, cubic in pieces]
        values, slopes = (parts[0][i] + 1j * parts[1][i] for i in (0, 1))
        if not values.imag.any():
            values, slopes = values.real, slopes.real
        return cls(times, values, slopes)

    def _describe(self, path: str) -> dict[str, Plain]:
        given = {"times": nested(self.times, f"{path}.times")}
        for name in ("values", "slopes"):
            found = getattr(self, name)
            if found is not None:
                given[name] = [
                    [value.real, value.imag] if isinstance(value, complex) else value
                    for value in found
                ]
        return given

    @classmethod
    def _from_description(cls, description: Mapping[str, Plain]) -> "TimeSeries":
        return cls(**description)


def _numbers(given: object, name: str) -> tuple[float | complex, ...]:
    """Convert real or complex values, or pairs [re, im], to a tuple."""
    try:
        found = np.asarray(given)
        if found.ndim == 2 and found.shape[1] == 2 and found.dtype.kind in "iuf":
            found = found[:, 0] + 1j * found[:, 1]
        if found.ndim != 1 or found.dtype.kind not in "iufc":
            raise ValueError(name)
    except ValueError:
        raise SceneError(f"{name}: must be a list of numbers, got {shown(given)}") from None
    if found.dtype.kind != "c":
        return tuple(array(found, name, least=0).tolist())
    return tuple(found.astype(np.complex128).tolist())


def _hermite(left: Array, cubic: Array, times: Array) -> tuple[Array, Array]:
    """Evaluate cubic pieces and their slopes."""
    piece = np.clip(np.searchsorted(left, times, side="right") - 1, 0, left.size - 1)
    a, b, c, d = cubic[:, piece]
    x = times - left[piece]
    return ((a * x + b) * x + c) * x + d, (3.0 * a * x + 2.0 * b) * x + c
