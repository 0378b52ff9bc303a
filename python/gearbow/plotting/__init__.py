"""Figures. Every function takes plain arrays and returns a figure, which it does not show.

Global settings of matplotlib do not change.
"""

from gearbow.plotting.style import PALETTE, STYLE, equal_ranges, panels

__all__ = ["PALETTE", "STYLE", "equal_ranges", "panels"]
