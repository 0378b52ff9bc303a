"""The exceptions, one tree for one ``except`` to catch, and the warnings of gearbow.

This module imports nothing from the package: the compiled core imports it.
"""

from typing import Any

__all__ = [
    "AccuracyWarning",
    "ChannelError",
    "CheckpointWarning",
    "ContactError",
    "ConvergenceError",
    "GearbowError",
    "MissingExtraError",
    "RunTimeWarning",
    "SceneError",
    "SceneWarning",
    "StabilityError",
]


class GearbowError(Exception):
    """Base of every error that gearbow raises on purpose.

    Attributes
    ----------
    response : gearbow.Response or None
        What a simulation had computed when it failed; None for every other error.
        `KeyboardInterrupt` out of a simulation carries it too.
    """

    response: Any = None


class SceneError(GearbowError, ValueError):
    """A description, or an argument, that cannot be; the text begins with where it is.

    Examples
    --------
    >>> import gearbow as gb
    >>> gb.RotorSystem(shafts=["input"])
    Traceback (most recent call last):
    ...
    gearbow.errors.SceneError: shafts[0]: must be a gb.Shaft, got 'input'
    """


class StabilityError(GearbowError):
    """A step above the stability limit, or a run that diverged; the text names the limit."""


class ContactError(GearbowError):
    """Base circles that overlap, where no involute contact exists; names mesh and time."""


class ConvergenceError(GearbowError):
    """An iteration that did not converge; the text names it and its residual."""


class ChannelError(GearbowError, KeyError):
    """A response was asked for something that was not recorded; the text says what to record."""

    # KeyError prints the repr of its argument, which makes a sentence unreadable.
    __str__ = Exception.__str__


class MissingExtraError(GearbowError, ImportError):
    """A library that an extra of gearbow installs is missing; the text says how to install it."""


class CheckpointWarning(UserWarning):
    """The file of a long run could not be written; the run goes on, the file is as it was."""


class SceneWarning(UserWarning):
    """A description that is possible but looks like a slip, e.g. unlike base pitches."""


class RunTimeWarning(RuntimeWarning):
    """A run that takes longer than an hour at the pace of its first second.

    The text gives the estimate. An error in its place, by `warnings.simplefilter("error",
    gb.RunTimeWarning)`, ends the run; the exception carries `.response`, what was computed.
    """


class AccuracyWarning(UserWarning):
    """An answer that may be worth less than it looks.

    Frequencies may be so far apart that round-off takes digits of the slow motions, a tolerance may
    be below round-off, a displacement larger than the shafts, where the equations hold for small
    ones. The text says by how much, and what is the cause.

    Examples
    --------
    >>> import warnings
    >>> import gearbow as gb
    >>> shaft = gb.Shaft("rotor", length=1.0, outer_diameter=0.05, elements=4)
    >>> bearings = [gb.Bearing("rotor", x, stiffness=1e20) for x in (0.0, 1.0)]
    >>> with warnings.catch_warnings(record=True) as caught:
    ...     warnings.simplefilter("always")
    ...     modes = gb.RotorSystem(shafts=[shaft], bearings=bearings).modes()
    >>> str(caught[-1].message)
    '...the fastest mode is that of bearings[0], of 1.000e20 N/m'
    """
