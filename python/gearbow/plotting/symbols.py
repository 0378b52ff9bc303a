"""Symbols of the parts and loads of a train, and the heights of its shafts in a side view."""

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import FancyArrowPatch, Patch, Polygon, Rectangle
from matplotlib.path import Path

from gearbow._types import Array, At
from gearbow.description.gears import Disk
from gearbow.description.journal import JournalBearing, TiltingPadBearing
from gearbow.description.layout import BodyOutline, ShaftOutline
from gearbow.description.loads import Torque
from gearbow.description.places import Support
from gearbow.description.rolling import RollingBearing
from gearbow.description.train import Train
from gearbow.plotting.labels import Box, Labels, around
from gearbow.plotting.style import quantity

#: Sizes of the symbols [pt].
BEARING, GROUND = 11.0, 6.0
#: End of the name of a rolling bearing by the sign of the contact angle.
_SIDES = {0: "", 1: " for thrust to the right", -1: " for thrust to the left"}
_ARROW: dict[str, Any] = {"arrowstyle": "-|>", "linewidth": 1.8}


def bearing_kind(part: object) -> str:
    """Name the kind of a bearing."""
    if isinstance(part, TiltingPadBearing):
        return "tilting-pad bearing"
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
    is_film = kind in ("journal bearing", "tilting-pad bearing")
    face = "black" if is_film else "white"
    style: dict[str, Any] = {"ec": "black", "fc": face, "lw": 1.3, "zorder": 5.0}
    if kind == "bearing":
        corners = [(x, y), (x - 0.6 * size, y - size), (x + 0.6 * size, y - size)]
        panel.add_patch(Polygon(corners, **{**style, "fc": "0.8"}))
    elif is_film:
        # A shell around the shaft, or three pads, on a foot.
        lefts, width = ([-1.0, -0.25, 0.5], 0.5) if kind.startswith("tilting") else ([-1.0], 2.0)
        for left in lefts:
            panel.add_patch(Rectangle((x + left * size, y - half), width * size, half, **style))
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
    reach = size if is_film else 0.6 * size
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
    corner = (x - size, y - 0.7 * size)
    panel.add_patch(Rectangle(corner, 2.0 * size, 0.7 * size, ec="black", fc="0.6", zorder=5))
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
    found += ["housing"] if housings else []
    found += ["support"] if any(base not in housings for base in bases) else []
    return found + (["coupling"] if train.parts["couplings"] else [])


def handles(kinds: list[str]) -> list[Any]:
    """Give the handles of a legend of symbols."""
    marks = {"bearing": "^", "journal bearing": "s", "ball bearing": "o", "roller bearing": "X"}
    marks["tilting-pad bearing"] = "D"
    fills = {"bearing": "0.8", "journal bearing": "black", "tilting-pad bearing": "black"}
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


# The shafts of a side view are developed into one plane. The distance of two shafts in mesh is
# their centre distance. A shaft lies above or below the shaft that it meshes with, as at rest; on
# the other side where it would cover another shaft there; and farther away where both sides are
# covered.

#: Density of the solid disk whose width represents a disk or a gear without a face width [kg/m³].
_STEEL = 7850.0
#: Distance below which two shafts have one axis [m].
_SAME_AXIS = 1e-9
#: Part of a box that another one may cover: pitch circles in mesh touch.
_TOUCH = 0.05


@dataclass(frozen=True)
class Development:
    """Heights of the shafts."""

    heights: dict[str, float]
    true: bool
    moved: tuple[str, ...]


def developed(train: Train) -> Development:
    """Find the heights."""
    first = train.layout.shafts[0]
    heights = {first.name: 0.0}
    placed = list(boxes_of(train, first, 0.0))
    moved = []
    gears = {gear.name: gear.shaft for gear in train.parts["gears"]}
    stages = [mesh for mesh in train.parts["meshes"] if mesh.carrier is not None]
    # sun, planets and ring of a stage lie in each other
    nested = {gears[name] for mesh in stages for name in (mesh.driver, mesh.driven)}
    waiting = deque([first.name])
    while waiting:
        known = waiting.popleft()
        for name, distance in _neighbours(train, known):
            if name in heights:
                continue
            shaft = train.layout.shaft(name)
            wanted = [heights[known] + distance, heights[known] - distance]
            boxes = {y: boxes_of(train, shaft, y) for y in wanted}
            free = [y for y in wanted if name in nested or not _covered(boxes[y], placed)]
            if not free and distance != 0.0:
                moved.append(name)
            heights[name] = free[0] if free else _beyond(train, shaft, wanted, placed)
            placed += boxes_of(train, shaft, heights[name])
            waiting.append(name)
    true = all(
        abs(heights[shaft.name] - shaft.origin[1]) < 1e-9 and abs(shaft.origin[2]) < 1e-9
        for shaft in train.layout.shafts
    )
    return Development(heights, true, tuple(moved))


def width(train: Train, body: BodyOutline) -> float:
    """Give the width at which a gear or disk is drawn."""
    part = next(p for p in (*train.parts["gears"], *train.parts["disks"]) if p.name == body.name)
    if not isinstance(part, Disk) and part.face_width is not None:
        return float(part.face_width)
    if part.mass is None or body.radius == 0.0 or body.internal:
        return 0.3 * body.radius
    return float(part.mass / (_STEEL * np.pi * body.radius**2))


def body_box(train: Train, body: BodyOutline, height: float) -> Box:
    """Give the box of a gear or disk in the side view."""
    x = float(train.layout.shaft(body.shaft).origin[0]) + body.position
    half = width(train, body) / 2.0
    return x - half, height - body.radius, x + half, height + body.radius


def _neighbours(train: Train, known: str) -> list[tuple[str, float]]:
    """Give the shafts that mesh with a shaft or lie on its axis, with their signed distance."""
    found = []
    origins = {shaft.name: shaft.origin for shaft in train.layout.shafts}
    gears = {gear.name: gear for gear in train.parts["gears"]}
    for mesh in train.parts["meshes"]:
        pair = (gears[mesh.driver].shaft, gears[mesh.driven].shaft)
        for own, other in (pair, pair[::-1]):
            if own == known:
                y, z = origins[other][1:] - origins[own][1:]
                upwards = y if abs(y) > 1e-9 * abs(z) else z
                found.append((other, float(np.copysign(np.hypot(y, z), upwards))))
    own = origins[known][1:]
    found += [
        (name, 0.0)
        for name, origin in origins.items()
        if name != known and np.allclose(origin[1:], own, rtol=0.0, atol=_SAME_AXIS)
    ]
    return found


def boxes_of(train: Train, shaft: ShaftOutline, height: float) -> list[Box]:
    """Give the boxes of the segments, sleeves, gears and disks of a shaft."""
    left = float(shaft.origin[0])
    boxes = [
        (left + step.begin, height - step.largest, left + step.end, height + step.largest)
        for step in (*shaft.steps, *shaft.sleeves)
    ]
    own = (body for body in train.layout.bodies if body.shaft == shaft.name)
    return [*boxes, *(body_box(train, body, height) for body in own)]


def _covered(boxes: list[Box], placed: list[Box]) -> bool:
    """Whether one of the boxes covers more of a placed one than gears that touch."""
    for a in boxes:
        for b in placed:
            common = [min(a[i + 2], b[i + 2]) - max(a[i], b[i]) for i in (0, 1)]
            smaller = [min(a[i + 2] - a[i], b[i + 2] - b[i]) for i in (0, 1)]
            if all(c > _TOUCH * s for c, s in zip(common, smaller, strict=True)):
                return True
    return False


def _beyond(train: Train, shaft: ShaftOutline, wanted: list[float], placed: list[Box]) -> float:
    """Give the height beyond all placed boxes that is closer to a wanted one."""
    if wanted[0] == wanted[1]:  # coaxial shafts keep their common axis
        return wanted[0]
    own = boxes_of(train, shaft, 0.0)
    reach = max(box[3] for box in own)
    gap = 0.1 * reach
    above = max(box[3] for box in placed) + reach + gap
    below = min(box[1] for box in placed) - reach - gap
    return min((above, below), key=lambda y: min(abs(y - w) for w in wanted))


#: Directions of the labels of loads.
_WAYS: tuple[tuple[float, float], ...] = (
    (0, 1),
    (0, -1),
    (1, 0.7),
    (1, -0.7),
    (-1, 0.7),
    (-1, -0.7),
)

#: Number of equal torques on a shaft from which one label names them.
_EQUAL = 3


def place_of_load(train: Train, heights: Mapping[str, float], at: At) -> tuple[float, float, float]:
    """Find a place in the side view."""
    if isinstance(at, str):
        body = next(body for body in train.layout.bodies if body.name == at)
        name, position = body.shaft, body.position
    else:
        name, position = at
    shaft = train.layout.shaft(name)
    return float(shaft.origin[0]) + position, heights[name], shaft.outer_radius(position)


def draw_loads(labels: Labels, train: Train, heights: Mapping[str, float]) -> None:
    """Draw all torques, drives and forces with their values."""
    arcs: dict[tuple[float, str], list[Box]] = {}
    for torque in train.parts["torques"]:
        value = _value(train, torque)
        text = "torque" if value is None else quantity(value, "N m")
        text += " (balance)" if torque.value == "balance" else ""
        box = _turning(labels, (train, heights, torque.at), value)
        arcs.setdefault((place_of_load(train, heights, torque.at)[1], text), []).append(box)
    for (_, text), boxes in arcs.items():
        # Equal torques side by side, as of the cylinders of an engine, have one label.
        if len(boxes) >= _EQUAL:
            labels.add(f"{len(boxes)} × {text}", around(_WAYS, *boxes))
        else:
            for box in boxes:
                labels.add(text, around(_WAYS, box))
    for drive in train.parts["drives"]:
        box = _turning(labels, (train, heights, drive.at), None)
        labels.add("drive", around(_WAYS, box))
    for force in train.parts["forces"]:
        _force(labels, place_of_load(train, heights, force.at), force)


def _turning(labels: Labels, at: tuple[Train, Mapping[str, float], At], value: float | None) -> Box:
    """Draw an arc in front of a shaft: positive about +x moves the front of the shaft downwards."""
    x, y, radius = place_of_load(*at)
    if isinstance(at[2], str):  # beside a gear or disk, where the shaft is visible
        body = next(body for body in at[0].layout.bodies if body.name == at[2])
        x = body_box(at[0], body, y)[2]
    point = labels.point
    across, up = 9.0 * point, radius + 8.0 * point
    angle = np.linspace(0.5 * np.pi, -0.5 * np.pi, 30) * (-1.0 if (value or 0.0) < 0.0 else 1.0)
    path = np.column_stack([x + 2.0 * point + across * np.cos(angle), y + up * np.sin(angle)])
    arrow(labels.panel, path, both=value is None)
    box = (x, y - up, x + 1.3 * across, y + up)
    labels.avoid(box, strictly=True)
    return box


def _force(labels: Labels, at: tuple[float, float, float], force: Any) -> None:
    """Draw an arrow towards the shaft, with the components of a constant force."""
    x, y, radius = at
    if force.axial != 0.0:
        tail, head = (x - np.sign(force.axial) * 30.0 * labels.point, y), (x, y)
        _arrow(labels, tail, head, f"{quantity(force.axial, 'N')} axial")
        if force.value == 0.0:
            return
    text = "force"
    downwards = 1.0
    if isinstance(force.value, (int, float, complex)):
        value = complex(force.value)
        order = "" if force.order is None else f", order {force.order:g}"
        components = {"y": value.real, "z": value.imag}
        parts = [f"{quantity(x, 'N')} along {axis}" for axis, x in components.items() if x]
        text = (", ".join(parts) or "0 N") + order
        downwards = -1.0 if value.real > 0.0 else 1.0
    head = (x, y + downwards * radius)
    _arrow(labels, (x, y + downwards * (radius + 30.0 * labels.point)), head, text)


def _arrow(labels: Labels, tail: tuple[float, float], head: tuple[float, float], text: str) -> None:
    arrow(labels.panel, np.array([tail, head]))
    # A line has no area: the box is as wide as the head of the arrow.
    (left, bottom), (right, top) = np.sort([tail, head], axis=0)
    half = 5.0 * labels.point
    box = (left - half, bottom - half, right + half, top + half)
    labels.avoid(box, strictly=True)
    labels.add(text, around(_WAYS, box))


def _value(train: Train, torque: Torque) -> float | None:
    """Give the value of a torque [N m]; None if it varies or cannot be balanced from constants."""
    if isinstance(torque.value, (int, float)):
        return float(torque.value)
    if torque.value != "balance":
        return None
    ratios = {}
    shafts = {body.name: body.shaft for body in train.layout.bodies}
    for each in train.parts["torques"]:
        shaft = shafts[each.at] if isinstance(each.at, str) else each.at[0]
        ratios[id(each)] = train.ratios[shaft]
    others = [each for each in train.parts["torques"] if each is not torque]
    if not all(isinstance(each.value, (int, float)) for each in others):
        return None
    power = sum(each.value * ratios[id(each)] for each in others)
    return float(-power / ratios[id(torque)])
