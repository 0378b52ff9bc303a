"""Heights of the shafts in a side view: the train developed into one plane.

The distance of two shafts in mesh is their centre distance. A shaft lies above or below the shaft
that it meshes with, as at rest; on the other side where it would cover another shaft there; and
farther away where both sides are covered.
"""

from collections import deque
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from gearbow.description.gears import Disk
from gearbow.description.layout import BodyOutline, ShaftOutline
from gearbow.description.train import Train

__all__ = ["Box", "Development", "body_box", "developed", "width"]

#: (left, bottom, right, top) [m].
Box: TypeAlias = tuple[float, float, float, float]

#: Density of the solid disk whose width represents a disk or a gear without a face width [kg/m³].
_STEEL = 7850.0
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
    placed = list(_boxes(train, first, 0.0))
    moved = []
    waiting = deque([first.name])
    while waiting:
        known = waiting.popleft()
        for name, distance in _neighbours(train, known):
            if name in heights:
                continue
            shaft = train.layout.shaft(name)
            wanted = [heights[known] + distance, heights[known] - distance]
            free = [y for y in wanted if not _covered(_boxes(train, shaft, y), placed)]
            if not free and distance != 0.0:
                moved.append(name)
            heights[name] = free[0] if free else _beyond(train, shaft, wanted, placed)
            placed += _boxes(train, shaft, heights[name])
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
    if part.mass is None or body.radius == 0.0:
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
    bodies = {body.name: body.shaft for body in train.layout.bodies}
    for coupling in train.parts["couplings"]:
        ends = [bodies[at] if isinstance(at, str) else at[0] for at in (coupling.a, coupling.b)]
        found += [(other, 0.0) for own, other in (ends, ends[::-1]) if own == known]
    for bearing in train.parts["bearings"]:
        if isinstance(bearing.support, tuple):
            pair = (bearing.shaft, bearing.support[0])
            found += [(other, 0.0) for own, other in (pair, pair[::-1]) if own == known]
    return found


def _boxes(train: Train, shaft: ShaftOutline, height: float) -> list[Box]:
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
    own = _boxes(train, shaft, 0.0)
    reach = max(box[3] for box in own)
    gap = 0.1 * reach
    above = max(box[3] for box in placed) + reach + gap
    below = min(box[1] for box in placed) - reach - gap
    return min((above, below), key=lambda y: min(abs(y - w) for w in wanted))
