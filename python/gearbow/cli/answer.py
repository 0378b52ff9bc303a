"""The result of a command: text for a person, plain data for a program."""

import json
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from io import StringIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from gearbow._files import printable, replacing

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["Answer", "Drawing"]


@dataclass(frozen=True)
class Drawing:
    """A figure that a command draws after it has printed its answer."""

    draw: "Callable[[], Figure]"
    path: Path

    def save(self) -> None:
        """Draw the figure and write the file."""
        figure, ending = self.draw(), self.path.suffix[1:].lower()
        with replacing(self.path) as file:
            if ending == "svg":  # a file of XML, which a name may not make invalid
                stream = StringIO()
                figure.savefig(stream, format=ending)
                file.write(printable(stream.getvalue()).encode())
            else:
                figure.savefig(file, format=ending)


@dataclass(frozen=True)
class Answer:
    """What a command prints."""

    text: str
    data: Mapping[str, Any]
    drawing: Drawing | None = None

    def json(self) -> str:
        """Format the data as JSON in ASCII; numbers that JSON lacks (NaN, infinity) become null."""
        return json.dumps(_plain(self.data), indent=2, allow_nan=False)


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
