"""Torques, drives and forces in the side view of a train."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from gearbow._types import At
from gearbow.description.loads import Torque
from gearbow.description.train import Train
from gearbow.plotting import symbols
from gearbow.plotting.development import body_box
from gearbow.plotting.labels import Box, Labels, around
from gearbow.plotting.style import quantity

__all__ = ["draw", "place"]

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


def place(train: Train, heights: Mapping[str, float], at: At) -> tuple[float, float, float]:
    """Find a place in the side view."""
    if isinstance(at, str):
        body = next(body for body in train.layout.bodies if body.name == at)
        name, position = body.shaft, body.position
    else:
        name, position = at
    shaft = train.layout.shaft(name)
    return float(shaft.origin[0]) + position, heights[name], shaft.outer_radius(position)


def draw(labels: Labels, train: Train, heights: Mapping[str, float]) -> None:
    """Draw all torques, drives and forces with their values."""
    arcs: dict[tuple[float, str], list[Box]] = {}
    for torque in train.parts["torques"]:
        value = _value(train, torque)
        text = "torque" if value is None else quantity(value, "N m")
        text += " (balance)" if torque.value == "balance" else ""
        box = _turning(labels, (train, heights, torque.at), value)
        arcs.setdefault((place(train, heights, torque.at)[1], text), []).append(box)
    for (_, text), boxes in arcs.items():
        edges = np.array(boxes)
        # Equal torques side by side, as of the cylinders of an engine, have one label.
        if len(boxes) >= _EQUAL:
            left, bottom = edges[:, :2].min(axis=0).tolist()
            right, top = edges[:, 2:].max(axis=0).tolist()
            labels.add(f"{len(boxes)} × {text}", around(left, bottom, right, top, _WAYS))
        else:
            for box in boxes:
                labels.add(text, around(*box, _WAYS))
    for drive in train.parts["drives"]:
        box = _turning(labels, (train, heights, drive.at), None)
        labels.add("drive", around(*box, _WAYS))
    for force in train.parts["forces"]:
        _force(labels, place(train, heights, force.at), force)


def _turning(labels: Labels, at: tuple[Train, Mapping[str, float], At], value: float | None) -> Box:
    """Draw an arc in front of a shaft: positive about +x moves the front of the shaft downwards."""
    x, y, radius = place(*at)
    if isinstance(at[2], str):  # beside a gear or disk, where the shaft is visible
        body = next(body for body in at[0].layout.bodies if body.name == at[2])
        x = body_box(at[0], body, y)[2]
    point = labels.point
    across, up = 9.0 * point, radius + 8.0 * point
    angle = np.linspace(0.5 * np.pi, -0.5 * np.pi, 30) * (-1.0 if (value or 0.0) < 0.0 else 1.0)
    path = np.column_stack([x + 2.0 * point + across * np.cos(angle), y + up * np.sin(angle)])
    symbols.arrow(labels.panel, path, both=value is None)
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
    symbols.arrow(labels.panel, np.array([tail, head]))
    box = (
        min(tail[0], head[0]),
        min(tail[1], head[1]),
        max(tail[0], head[0]),
        max(tail[1], head[1]),
    )
    labels.avoid(box, strictly=True)
    labels.add(text, around(*box, _WAYS))


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
