"""Symbols of a side view: bearings and what they stand on, couplings, torques, drives, forces."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import FancyArrowPatch, Patch, Polygon, Rectangle
from matplotlib.path import Path

from gearbow._types import Array
from gearbow.description.journal import JournalBearing
from gearbow.description.rolling import RollingBearing
from gearbow.description.supports import Support
from gearbow.description.train import Train
from gearbow.plotting.development import Box

__all__ = ["arrow", "bearing", "bearing_kind", "coupling", "ground", "handles", "kinds", "support"]

#: Sizes of the symbols [pt].
BEARING, GROUND = 11.0, 6.0
#: End of the name of a rolling bearing by the sign of the contact angle.
_SIDES = {0: "", 1: " for thrust to the right", -1: " for thrust to the left"}
_ARROW: dict[str, Any] = {"arrowstyle": "-|>", "linewidth": 1.8}


def bearing_kind(part: object) -> str:
    """Name the kind of a bearing."""
    if isinstance(part, JournalBearing):
        return "journal bearing"
    if isinstance(part, RollingBearing):
        kind = "roller bearing" if part._rolls else "ball bearing"
        return kind + _SIDES[int(np.sign(part._angle))] if part.degrees_of_freedom == 5 else kind
    return "bearing"


def bearing(panel: Axes, kind: str, x: float, y: float, point: float) -> Box:
    """Draw a bearing below the surface of a shaft."""
    size = BEARING * point
    half = size / 2.0
    face = "black" if kind == "journal bearing" else "white"
    style: dict[str, Any] = {"ec": "black", "fc": face, "lw": 1.3, "zorder": 5.0}
    if kind == "bearing":
        corners = [(x, y), (x - 0.6 * size, y - size), (x + 0.6 * size, y - size)]
        panel.add_patch(Polygon(corners, **{**style, "fc": "0.8"}))
    elif kind == "journal bearing":
        panel.add_patch(Rectangle((x - size, y - half), 2.0 * size, half, **style))
        panel.add_patch(Rectangle((x - 0.3 * size, y - size), 0.6 * size, half, **style))
    else:
        panel.add_patch(Rectangle((x - half, y - size), size, size, **style))
        if kind.startswith("ball"):
            angle = np.linspace(0.0, 2.0 * np.pi, 41)
            ring = half * (0.7 * np.exp(1j * angle)) + complex(x, y - half)
            panel.plot(ring.real, ring.imag, color="black", linewidth=1.3, zorder=6.0)
        else:
            for sign in (-1.0, 1.0):
                ends = y - half + sign * half * np.array([-1.0, 1.0])
                panel.plot([x - half, x + half], ends, color="black", linewidth=1.3, zorder=6.0)
        sides = [side for side, name in _SIDES.items() if name and kind.endswith(name)]
        for side in sides:
            # The line of contact, through which the shaft presses on the outer ring.
            ends = x + side * half * np.array([-0.6, 0.6])
            panel.plot(ends, [y, y - size], color="black", linewidth=2.2, zorder=6.5)
    reach = size if kind == "journal bearing" else 0.6 * size
    return x - reach, y - size, x + reach, y


def ground(panel: Axes, x: float, y: float, point: float) -> Box:
    """Draw the ground below a symbol."""
    size = GROUND * point
    half = 1.6 * size
    panel.plot([x - half, x + half], [y, y], color="black", linewidth=1.6, zorder=5.0)
    for start in np.linspace(x - half, x + half, 5)[1:]:
        panel.plot(
            [start, start - 0.8 * size], [y, y - 0.8 * size], color="black", lw=0.9, zorder=5.0
        )
    return x - half, y - size, x + half, y


def support(panel: Axes, x: float, y: float, point: float) -> Box:
    """Draw a support: a mass on a spring."""
    size = BEARING * point
    panel.add_patch(
        Rectangle(
            (x - size, y - 0.7 * size), 2.0 * size, 0.7 * size, ec="black", fc="0.6", zorder=5
        )
    )
    turns = np.linspace(0.0, 1.0, 8)
    side = np.array([0.0, *(0.35, -0.35) * 3, 0.0]) * size
    low = y - 0.7 * size - size * turns
    panel.plot(x + side, low, color="black", linewidth=1.2, zorder=5.0)
    return x - size, float(low[-1]), x + size, y


def coupling(panel: Axes, x: float, y: float, radius: float, point: float) -> Box:
    """Draw the two hubs of a coupling."""
    reach, thick = radius + 5.0 * point, 4.0 * point
    for left in (x - thick - 0.5 * point, x + 0.5 * point):
        corner = (left, y - reach)
        panel.add_patch(Rectangle(corner, thick, 2.0 * reach, ec="black", fc="0.35", zorder=5.0))
    return x - 1.2 * thick, y - reach, x + 1.2 * thick, y + reach


def arrow(
    panel: Axes, path: Array, *, both: bool = False, colour: str = "black", head: float = 13.0
) -> None:
    """Draw an arrow along a path."""
    style = {**_ARROW, "arrowstyle": "<|-|>"} if both else _ARROW
    panel.add_patch(
        FancyArrowPatch(path=Path(path), color=colour, mutation_scale=head, zorder=7.0, **style)
    )


def kinds(train: Train) -> list[str]:
    """List the kinds of symbols of a train."""
    bearings = train.parts["bearings"]
    housings = {housing.name for housing in train.parts["housings"]}
    bases = [each.support for each in bearings if isinstance(each.support, str | Support)]
    found = list(dict.fromkeys(bearing_kind(each) for each in bearings))
    found += ["housing"] if any(base in housings for base in bases) else []
    found += ["support"] if any(base not in housings for base in bases) else []
    return found + (["coupling"] if train.parts["couplings"] else [])


def handles(kinds: list[str]) -> list[Any]:
    """Give the handles of a legend of symbols."""
    marks = {"bearing": "^", "journal bearing": "s", "ball bearing": "o", "roller bearing": "X"}
    fills = {"bearing": "0.8", "journal bearing": "black"}
    found: list[Any] = []
    for kind in kinds:
        if kind.endswith(_SIDES[1]):
            mark = r"$\backslash$"
        elif kind.endswith(_SIDES[-1]):
            mark = "$/$"
        else:
            mark = marks.get(kind, "")
        if mark:
            style: dict[str, Any] = {"marker": mark, "mfc": fills.get(kind, "white")}
            found.append(Line2D([], [], color="black", linestyle="none", markersize=9.0, **style))
        else:
            shade = {"coupling": "0.35", "support": "0.6"}.get(kind, "0.9")
            found.append(Patch(facecolor=shade, edgecolor="black"))
    return found
