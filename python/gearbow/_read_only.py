"""Results with read-only arrays, which prevent accidental changes."""

from collections.abc import Mapping
from typing import Any, TypeVar

import numpy as np

from gearbow._shown import Shown

T = TypeVar("T")


def read_only(data: T) -> T:
    """Make all arrays in (nested) mappings and sequences read-only, and return the data."""
    if isinstance(data, np.ndarray):
        data.setflags(write=False)
    elif isinstance(data, Mapping):
        for value in data.values():
            read_only(value)
    elif isinstance(data, list | tuple):
        for value in data:
            read_only(value)
    return data


class ReadOnly(Shown):
    """Base of every result that holds arrays: they are read-only, also in copies and pickles."""

    def __post_init__(self) -> None:
        read_only(vars(self))

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(read_only(state))
