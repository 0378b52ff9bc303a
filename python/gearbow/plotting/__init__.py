"""Figures. Every function takes plain arrays and returns a figure, which it does not show.

Global settings of matplotlib do not change.
"""

from gearbow.plotting.style import PALETTE, STYLE, legend, panels

__all__ = ["PALETTE", "STYLE", "legend", "panels"]
