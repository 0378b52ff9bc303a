"""The exceptions and the warning that gearbow raises; one tree, so that one ``except`` catches all.

This module imports nothing from the package: the compiled core imports it.
"""

from typing import Any

__all__ = [
    "ChannelError",
    "CheckpointWarning",
    "ContactError",
    "ConvergenceError",
    "GearbowError",
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


class CheckpointWarning(UserWarning):
    """The file of a long run could not be written; the run goes on, the file is as it was."""


class SceneWarning(UserWarning):
    """A description that is possible but looks like a slip, e.g. unlike base pitches."""
