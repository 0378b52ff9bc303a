"""Results that nobody changes by accident: their arrays are read-only."""

from collections.abc import Mapping
from typing import TypeVar

import numpy as np

T = TypeVar("T")


def read_only(data: T) -> T:
    """Make all arrays in (nested) mappings and sequences read-only, and give the data back.

    A result may be continued, saved or asked again, so that a changed array would falsify later
    answers. Views of a read-only array are read-only too. Whoever wants to change one takes a copy.
    """
    if isinstance(data, np.ndarray):
        data.setflags(write=False)
    elif isinstance(data, Mapping):
        for value in data.values():
            read_only(value)
    elif isinstance(data, list | tuple):
        for value in data:
            read_only(value)
    return data


class ReadOnly:
    """Base of every dataclass that holds arrays of a result."""

    def __post_init__(self) -> None:
        read_only(vars(self))
