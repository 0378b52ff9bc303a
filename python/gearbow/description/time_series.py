"""Values of loads over time, angle and speed, and modal damping over the frequency."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from gearbow._convert import array, function, nested, number, positive, shown, whole
from gearbow._types import Array, Plain
from gearbow.description.part import Part, freeze, tuples
from gearbow.description.speed import evaluated, sampled
from gearbow.errors import SceneError
from gearbow.units.fields import has_quantity


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
        Derivatives at the times. None: those of the monotone cubic (PCHIP), without overshoot.

    Examples
    --------
    >>> import gearbow as gb
    >>> shock = gb.TimeSeries([0.1, 0.101, 0.102], [0.0, 500.0, 0.0])
    >>> force = gb.Force("disk", shock)
    """

    times: "ArrayLike"
    values: "ArrayLike"
    slopes: "ArrayLike | None" = None

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
        duration, begin : float
            Duration of the approximation, and time at which it begins [s].
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
        begin, duration = number(begin, f"{path}.begin"), positive(duration, f"{path}.duration")
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


P = TypeVar("P", bound=Part)

#: Time at the beginning of a function from which elements are chosen [s]: that over which the
#: accuracy levels promise errors. Number of its samples; they show tones up to 10 kHz.
_OUTLINE, _SAMPLES = 0.1, 4097


def described_value(value: object, path: str, read: Callable[[object, str], Plain]) -> Plain:
    """Convert the value of a load to plain data."""
    if isinstance(value, Part):
        return value._describe(path)
    if callable(value):
        return _outline(value, path)
    return read(value, path)


def _outline(function: Callable[[Any], Any], path: str) -> dict[str, Plain]:
    """Give samples of the beginning of a function; zeros for one that has no numbers there."""
    times = np.linspace(0.0, _OUTLINE, _SAMPLES)
    try:
        with np.errstate(all="ignore"):
            real, imaginary = (
                evaluated(lambda t, part=part: part(function(t)), times, path)  # type: ignore[misc]
                for part in (np.real, np.imag)
            )
    except (ArithmeticError, LookupError, TypeError, ValueError):
        # A run reports what is wrong with the function.
        real, imaginary = np.zeros((2, _SAMPLES))
    values = np.stack([real, imaginary], axis=1) if imaginary.any() else real
    return {"times": times.tolist(), "values": values.tolist()}


def functions(**lists: Sequence[Part]) -> list[str]:
    """Give the paths of the values that are functions of time, in named lists of loads."""
    return [
        f"{key}[{i}].value"
        for key, loads in lists.items()
        for i, load in enumerate(loads)
        if callable(getattr(load, "value", None))
    ]


def refuse_functions(**lists: Sequence[Part]) -> None:
    """Refuse functions of time, which have no plain form, in named lists of loads."""
    for path in functions(**lists):
        raise SceneError(
            f"{path}: a function of time has no plain form; give "
            "gb.TimeSeries.function(f, duration)"
        )


def over_time(loads: Sequence[P], begin: float, duration: float, path: str) -> tuple[P, ...]:
    """Replace functions of time in the values of loads by their samples over a run."""
    found = []
    for i, load in enumerate(loads):
        value = getattr(load, "value", None)
        if callable(value):
            series = TimeSeries.function(value, duration, begin=begin, path=f"{path}[{i}].value")
            found.append(replace(load, value=series))  # type: ignore[type-var]  # a dataclass
        else:
            found.append(load)
    return tuple(found)


#: Keys of a table over the frequency, and the key of the modes without a ratio of their own.
_TABLE, _OTHER = ("frequencies", "ratios"), "other"
#: Exponents of ten of the frequencies [rad/s] at which a function is sampled, and points for a
#: decade: with 50, a ratio a/ω + bω differs by 2e-6 of its value between the points.
_DECADES, _POINTS = (1, 5), 50


def described_ratios(value: object, path: str) -> Plain:
    """Convert a ratio, ratios by mode number, a table or a function of ω to plain data."""
    if callable(value):
        begin, end = _DECADES
        frequencies = np.logspace(begin, end, (end - begin) * _POINTS + 1)
        ratios = evaluated(value, frequencies, path, "rad/s")
        return {"frequencies": frequencies.tolist(), "ratios": ratios.tolist()}
    if not isinstance(value, Mapping):
        return number(value, path)
    if any(key in value for key in _TABLE):
        if set(value) != set(_TABLE):
            raise SceneError(f"{path}: a table needs the keys frequencies and ratios only")
        return {key: array(value[key], f"{path}.{key}").tolist() for key in _TABLE}
    return {_key(key, path): number(ratio, f"{path}[{key!r}]") for key, ratio in value.items()}


def _key(key: object, path: str) -> str:
    """Give the name of a mode number in plain data."""
    if isinstance(key, str):
        return key if key == _OTHER or not key.isdecimal() else str(int(key))
    return str(whole(key, f"{path}: the number of a mode"))


def given_ratios(plain: Plain) -> Plain:
    """Give ratios of plain data with mode numbers as a user gives them."""
    if not isinstance(plain, Mapping):
        return plain
    return {int(key) if key.isdecimal() else key: tuples(value) for key, value in plain.items()}
