"""The exceptions of gearbow, all derived from `GearbowError`, and its warnings.

This module imports nothing from the package: the compiled core imports it.
"""

import sys
import warnings
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from types import FrameType


class GearbowError(Exception):
    """Base of all public exceptions of gearbow.

    Every function raises `SceneError` for an invalid argument, `ChannelError` for a signal that was
    not recorded, `MissingExtraError` without a library that it needs, and `OSError` for a file that
    cannot be read or written; a file that it would have replaced is then unchanged. The section
    "Raises" of a docstring has the errors beyond these.

    Attributes
    ----------
    response : gearbow.Response or None
        Results of a simulation until its failure; None for every other error. A
        `KeyboardInterrupt` from a simulation has this attribute too.
    """

    response: Any = None


class SceneError(GearbowError, ValueError):
    """An invalid scene or argument; the message begins with its path.

    Examples
    --------
    >>> import gearbow as gb
    >>> gb.RotorSystem(shafts=["input"])
    Traceback (most recent call last):
    ...
    gearbow.errors.SceneError: shafts[0]: must be a gb.Shaft, got 'input'
    """


class StabilityError(GearbowError):
    """A step above the stability limit, or a run that diverged; the message names the limit."""


class ContactError(GearbowError):
    """Base circles overlap, so that involute contact is impossible; names mesh and time."""


class ConvergenceError(GearbowError):
    """An iteration that did not converge; the message names it and its residual."""


class ChannelError(GearbowError, KeyError):
    """A requested signal was not recorded; the message says what to record."""

    # KeyError prints the repr of its argument, which makes a sentence unreadable.
    __str__ = Exception.__str__


class MissingExtraError(GearbowError, ImportError):
    """A library of an optional extra is missing; the message says how to install it."""


class CheckpointWarning(UserWarning):
    """The file of a long run or a sweep could not be written, or a part of it is damaged.

    The run continues. A file that could not be written is unchanged; points of a sweep that are
    damaged are computed again.
    """


class SceneWarning(UserWarning):
    """A valid scene with a probable mistake, e.g. different base pitches."""


class AccuracyWarning(UserWarning):
    """A result with reduced accuracy, or a run that takes more than an hour for its accuracy.

    Possible causes: the frequencies differ so much that round-off reduces the accuracy of the slow
    motions; a tolerance is below round-off; a displacement exceeds the size of the shafts,
    although the equations assume small displacements; the motion is unstable at the speed of a
    steady response; orders contain only a small part of a signal; or a branch ends before the
    end of its interval. The message gives the amount
    and the cause. The time of a run is estimated from its first second. A filter "error" ends the
    run there, and the attribute `response` of the warning contains the results so far.

    Examples
    --------
    >>> import warnings
    >>> import gearbow as gb
    >>> shaft = gb.Shaft("rotor", length=1.0, outer_diameter=0.05, elements=4)
    >>> bearings = [gb.Bearing("rotor", x, stiffness=1e15) for x in (0.0, 1.0)]
    >>> with warnings.catch_warnings(record=True) as caught:
    ...     warnings.simplefilter("always")
    ...     response = gb.RotorSystem(shafts=[shaft], bearings=bearings).synchronous([10.0])
    >>> str(caught[-1].message)
    '...the fastest mode is that of bearings[0], of 1.000e15 N/m'
    """


def outside() -> int:
    """Count the stack frames up to the first one outside the package: the line of the user."""
    level = 0
    frame: FrameType | None = sys._getframe(1)
    while frame is not None and frame.f_globals.get("__name__", "").split(".")[0] == "gearbow":
        level, frame = level + 1, frame.f_back
    return level + 1


def warn(message: str, category: type[Warning]) -> None:
    """Warn at the line of the user."""
    warnings.warn(message, category, stacklevel=outside())
