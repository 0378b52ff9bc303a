"""The line of the user that a warning points to."""

import sys
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from types import FrameType

__all__ = ["outside"]


def outside() -> int:
    """Count the stack frames up to the first one outside the package: the line of the user."""
    level = 0
    frame: FrameType | None = sys._getframe(1)
    while frame is not None and frame.f_globals.get("__name__", "").split(".")[0] == "gearbow":
        level, frame = level + 1, frame.f_back
    return level + 1
