"""What was asked of a run: the scene and the options, as plain data."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from gearbow._shown import Shown
from gearbow._types import Plain
from gearbow.description.part import tuples
from gearbow.errors import GearbowError

#: Names of the options of a run.
OPTIONS = (
    *("duration", "speed", "method", "step", "rtol", "stages", "modes"),
    *("initial", "record", "geometry", "start", "accuracy"),
)
#: Arrays of a final state from which a run continues.
_ARRAYS = {"state": np.float64, "memory": np.float64, "contact_modes": np.int64}


@dataclass(frozen=True, eq=False)
class RunRequest(Shown):
    """The scene and the options of a run, from which the same run can be made again."""

    description: Mapping[str, Plain]
    options: Mapping[str, Any]

    def plain(self) -> dict[str, Plain]:
        """Convert to data that JSON can hold."""
        return {"description": dict(self.description), "options": _plain(dict(self.options))}

    @classmethod
    def from_plain(cls, given: Mapping[str, Plain] | None) -> "RunRequest | None":
        """Read the data of `plain`."""
        if given is None:
            return None
        options = dict(given["options"])
        initial = options.get("initial")
        if isinstance(initial, Mapping):
            options["initial"] = {name: _array(name, value) for name, value in initial.items()}
        options["record"] = [tuples(item) for item in options["record"]]
        return cls(given["description"], options)


def _array(name: str, value: Plain) -> Any:
    """Convert a list of numbers to an array; another entry stays the same."""
    if name not in _ARRAYS:
        return value
    try:
        return np.array(value, dtype=_ARRAYS[name]).reshape(len(value))
    except (TypeError, ValueError, OverflowError) as error:
        raise GearbowError(f"request.options.initial.{name}: {error}") from None


def _plain(value: Any) -> Plain:
    """Convert arrays in mappings to lists."""
    if isinstance(value, Mapping):
        return {name: _plain(entry) for name, entry in value.items()}
    return value.tolist() if isinstance(value, np.ndarray | np.generic) else value
