"""The result of a command: text for a person, plain data for a program."""

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

__all__ = ["Answer"]


@dataclass(frozen=True)
class Answer:
    """What a command prints.

    Parameters
    ----------
    text : str
        Lines for a person.
    data : mapping
        The same as plain data; units are SI units, or the ending of a key (`_hz`).
    """

    text: str
    data: Mapping[str, Any]

    def json(self) -> str:
        """Format the data as JSON; numbers that JSON lacks (NaN, infinity) become null.

        Returns
        -------
        str
            One JSON object.
        """
        return json.dumps(_plain(self.data), indent=2, allow_nan=False, ensure_ascii=False)


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return _plain(value.tolist())
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
