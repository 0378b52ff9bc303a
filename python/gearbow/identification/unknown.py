"""Unknowns that `gearbow.identify` finds.

An unknown replaces the value in the system: the bow of a shaft, the unbalance of a gear or disk,
the run-out of a probe, or the value of a parameter.

Examples
--------
>>> import gearbow as gb
>>> gb.unknown.bow("input", shapes=2)
BowUnknown(shaft='input', shapes=2)
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

from gearbow._convert import array, number, positive, text, whole
from gearbow._shown import Shown
from gearbow._types import At
from gearbow.description.places import place
from gearbow.errors import SceneError


@dataclass(frozen=True)
class BowUnknown(Shown):
    """Unknown bow of a shaft: half waves, or deflections at points."""

    shaft: str
    shapes: int = 1
    points: tuple[float, ...] | None = None
    prior: float | None = None


@dataclass(frozen=True)
class UnbalanceUnknown(Shown):
    """Unknown unbalance of a gear, a disk or a place of a shaft."""

    at: At
    prior: float | None = None


@dataclass(frozen=True)
class RunoutUnknown(Shown):
    """Unknown run-out of every probe."""

    prior: float | None = None


@dataclass(frozen=True)
class ParameterUnknown(Shown):
    """Unknown number in the description of the system."""

    path: str
    prior: tuple[float, float] | None = None


#: Everything that can be unknown.
Unknown: TypeAlias = BowUnknown | UnbalanceUnknown | RunoutUnknown | ParameterUnknown


def bow(
    shaft: str,
    shapes: int = 1,
    *,
    points: Sequence[float] | None = None,
    prior: float | None = None,
) -> BowUnknown:
    """Make the bow of a shaft unknown.

    Parameters
    ----------
    shaft : str
        Name of the shaft.
    shapes : int
        Number of half-wave shapes: sin(kπx/L) with k from 1 to `shapes`.
    points : sequence of float, optional
        Positions [m] strictly between the ends of the shaft, in place of half waves. The bow is a
        cubic spline through them, measured from the straight line through both ends: a straight
        line causes no forces, so that no measurement of vibration shows it.
    prior : float, optional
        Standard deviation of each component before the measurement, about zero [m].

    Returns
    -------
    BowUnknown
        The unknown, one complex amplitude [m] for each shape or point.
    """
    chosen = None if points is None else tuple(array(points, "unknown.bow.points").tolist())
    if chosen is not None and shapes != 1:
        raise SceneError("unknown.bow.shapes: must be left out where points are given")
    count = whole(shapes, "unknown.bow.shapes")
    return BowUnknown(text(shaft, "unknown.bow.shaft"), count, chosen, _prior(prior, "bow"))


def unbalance(at: At, *, prior: float | None = None) -> UnbalanceUnknown:
    """Make an unbalance unknown.

    Parameters
    ----------
    at : str or tuple of (str, float)
        A gear, a disk or (shaft, position [m]).
    prior : float, optional
        Standard deviation of each component before the measurement, about zero [kg m].

    Returns
    -------
    UnbalanceUnknown
        The unknown, a complex unbalance [kg m].
    """
    where = place(at, "unknown.unbalance.at", "place")
    return UnbalanceUnknown(where, _prior(prior, "unbalance"))


def runout(*, prior: float | None = None) -> RunoutUnknown:
    """Make the run-out of every probe unknown, which is the default of `gearbow.identify`.

    Parameters
    ----------
    prior : float, optional
        Standard deviation of each component before the measurement, about zero [m]: what is known
        about the surface below the probes narrows the intervals of the bow.

    Returns
    -------
    RunoutUnknown
        The unknown, one complex constant [m] for each probe.
    """
    return RunoutUnknown(_prior(prior, "runout"))


def parameter(path: str, *, prior: tuple[float, float] | None = None) -> ParameterUnknown:
    """Make a number in the description of the system unknown.

    Parameters
    ----------
    path : str
        Path in `RotorSystem.description`, for example "bearings[0].stiffness". With "[*]" all
        parts of a list have the same unknown value.
    prior : tuple of (float, float), optional
        Expected value, in the unit of the parameter, and its relative standard deviation.

    Returns
    -------
    ParameterUnknown
        The unknown. Its value keeps the sign of the expected value, or of that in the system.
    """
    expected = None
    if prior is not None:
        if len(prior) != 2:
            raise SceneError(
                "unknown.parameter.prior: must be (value, relative standard deviation), "
                f"got {prior!r}"
            )
        value = number(prior[0], "unknown.parameter.prior[0]")
        expected = (value, positive(prior[1], "unknown.parameter.prior[1]"))
        if value == 0.0:
            raise SceneError("unknown.parameter.prior[0]: must not be zero")
    return ParameterUnknown(text(path, "unknown.parameter.path"), expected)


def _prior(given: float | None, kind: str) -> float | None:
    return None if given is None else positive(given, f"unknown.{kind}.prior")


def __dir__() -> list[str]:
    return ["bow", "parameter", "runout", "unbalance"]
