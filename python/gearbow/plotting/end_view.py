"""End view of a train, seen along -x: pitch circles, lines of action, senses of rotation."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle

from gearbow._types import Array
from gearbow.description.gears import Gear, Mesh
from gearbow.description.layout import BodyOutline
from gearbow.description.train import Train
from gearbow.plotting import symbols
from gearbow.plotting.development import Box
from gearbow.plotting.labels import Labels, Place, series

__all__ = ["circles", "draw", "extent", "line_of_action"]

#: Angles of the labels around a circle [rad].
_AROUND = np.radians([90, 270, 45, 135, 225, 315, 0, 180, 67, 113, 247, 293])


def circles(train: Train) -> list[BodyOutline]:
    """List the gears and disks that are drawn as circles, the largest first."""
    bodies = [body for body in train.layout.bodies if body.radius > 0.0]
    return sorted(bodies, key=lambda body: -body.radius)


def extent(train: Train) -> Box:
    """Give the box of the view."""
    found = [(train.layout.shaft(body.shaft).origin, body.radius) for body in circles(train)]
    found += [
        (shaft.origin, max(step.largest for step in (*shaft.steps, *shaft.sleeves)))
        for shaft in train.layout.shafts
    ]
    low = np.min([centre[1:] - radius for centre, radius in found], axis=0)
    high = np.max([centre[1:] + radius for centre, radius in found], axis=0)
    return float(low[0]), float(low[1]), float(high[0]), float(high[1])


def line_of_action(pressure_angle: Any, centre_line_angle: Any, sense: float) -> Array:
    """Give the direction of the force on the driven gear."""
    along = np.stack([np.cos(centre_line_angle), np.sin(centre_line_angle)], axis=-1)
    across = np.stack([-np.sin(centre_line_angle), np.cos(centre_line_angle)], axis=-1)
    cosine = sense * np.cos(pressure_angle)[..., np.newaxis]
    direction: Array = cosine * across + np.sin(pressure_angle)[..., np.newaxis] * along
    return direction


def draw(panel: Axes, train: Train, shades: Mapping[str, str], point: float) -> None:
    """Draw the view into a panel with final limits."""
    labels = Labels(panel, point)
    for body in circles(train):
        y, z = train.layout.shaft(body.shaft).origin[1:]
        half = body.radius / np.sqrt(2.0)
        labels.avoid((y - half, z - half, y + half, z + half))
        for angle in np.linspace(0.0, 2.0 * np.pi, 72, endpoint=False):
            at = (y + body.radius * np.cos(angle), z + body.radius * np.sin(angle))
            low, high = ((at[0] + d * point, at[1] + d * point) for d in (-2.0, 2.0))
            labels.avoid((*low, *high))
    for shaft in train.layout.shafts:
        y, z = shaft.origin[1:]
        radius = max(step.largest for step in shaft.steps)
        style: dict[str, Any] = {"fc": shades[shaft.name], "ec": "black", "alpha": 0.55}
        panel.add_patch(Circle((y, z), radius, linewidth=0.8, zorder=3.0, **style))
        for sleeve in shaft.sleeves:
            style = {"ec": shades[shaft.name], "fc": "none", "hatch": "/////"}
            panel.add_patch(Circle((y, z), sleeve.largest, linewidth=0.8, zorder=2.2, **style))
        panel.plot([y], [z], "+", color="black", markersize=9.0, zorder=6.0)
    gears = {gear.name: gear for gear in train.parts["gears"]}
    many = {
        name
        for shaft in train.layout.shafts
        for _, names in series([b.name for b in circles(train) if b.shaft == shaft.name])
        if len(names) > 1
        for name in names
    }
    for body in circles(train):
        line = "-" if body.name in gears else "--"
        width = 0.7 if body.name in many else 2.0
        shade = shades[body.shaft]
        centre = train.layout.shaft(body.shaft).origin[1:]
        panel.add_patch(
            Circle(tuple(centre), body.radius, ec=shade, fc="none", lw=width, ls=line, zorder=4.0)
        )
    for mesh in train.parts["meshes"]:
        _mesh(labels, train, mesh, gears)
    for name, radius in _turning(train).items():
        centre = train.layout.shaft(name).origin[1:]
        _sense(panel, centre, radius, train.ratios[name], shades[name])
    # Shafts on one axis have one list of names: their circles lie within each other.
    axes: dict[tuple[float, float], list[BodyOutline]] = {}
    for body in reversed(circles(train)):
        y, z = train.layout.shaft(body.shaft).origin[1:]
        axes.setdefault((round(float(y), 9), round(float(z), 9)), []).append(body)
    for axis, bodies in axes.items():
        radii = {body.name: body.radius for body in bodies}
        for text, names in series(list(radii)):
            teeth = f", z = {gears[text].teeth}" if text in gears else ""
            places = _around_circle(np.array(axis), max(radii[name] for name in names))
            labels.add(f"{text}{teeth}", places)
    labels.place()


def _around_circle(centre: Array, radius: float) -> list[Place]:
    """Give places of a label outside a circle."""
    found: list[Place] = []
    for angle in _AROUND:
        way = (float(np.cos(angle)), float(np.sin(angle)))
        found.append(((centre[0] + radius * way[0], centre[1] + radius * way[1]), way))
    return found


def _mesh(labels: Labels, train: Train, mesh: Mesh, gears: Mapping[str, Gear]) -> None:
    """Draw the line of action between the base circles, with the force on the driven gear."""
    panel = labels.panel
    bodies = {body.name: body for body in train.layout.bodies}
    pair = [bodies[name] for name in (mesh.driver, mesh.driven)]
    a, b = (train.layout.shaft(body.shaft).origin[1:] for body in pair)
    offset = b - a
    distance = float(np.hypot(*offset))
    angle = gears[mesh.driver].pressure_angle
    helix = gears[mesh.driver].helix_angle
    transverse = np.arctan(np.tan(angle) / np.cos(helix))
    base = [body.radius * np.cos(transverse) for body in pair]
    alpha = np.arccos(min(1.0, sum(base) / distance))
    sense = float(np.sign(train.ratios[pair[0].shaft]))
    gamma = mesh.centre_line_angle
    way = line_of_action(np.float64(alpha), np.float64(gamma), sense)
    pitch = a + offset * base[0] / sum(base)
    ends = np.array([pitch - base[0] * np.tan(alpha) * way, pitch + base[1] * np.tan(alpha) * way])
    long = np.array([pitch - 0.4 * distance * way, pitch + 0.4 * distance * way])
    panel.plot(*long.T, color="black", linewidth=1.0, linestyle="--", zorder=7.0)
    symbols.arrow(panel, ends, head=9.0)
    panel.plot(*pitch, "o", color="black", markersize=4.0, zorder=7.0)
    low, high = ends.min(axis=0), ends.max(axis=0)
    labels.avoid((low[0], low[1], high[0], high[1]), strictly=True)


def _turning(train: Train) -> dict[str, float]:
    """Give the radius at which each shaft shows its sense of rotation [m]."""
    radii: dict[str, float] = {}
    seen: list[tuple[float, float, float]] = []
    for shaft in sorted(train.layout.shafts, key=lambda shaft: -_reach(train, shaft.name)):
        y, z = (round(float(x), 9) for x in shaft.origin[1:])
        # Coaxial shafts that turn alike have one arrow.
        turn = (y, z, float(np.sign(train.ratios[shaft.name])))
        if turn not in seen:
            seen.append(turn)
            radii[shaft.name] = 0.72 * _reach(train, shaft.name)
    return radii


def _reach(train: Train, name: str) -> float:
    """Give the largest radius on a shaft [m]."""
    shaft = train.layout.shaft(name)
    own = [body.radius for body in train.layout.bodies if body.shaft == name]
    return max([*own, *(step.largest for step in shaft.steps)])


def _sense(panel: Axes, centre: Array, radius: float, ratio: float, shade: str) -> None:
    """Draw an arc with a head in the sense of rotation."""
    angle = np.radians(np.linspace(115.0, 205.0, 40))
    if ratio < 0.0:
        angle = angle[::-1]
    path = centre + radius * np.column_stack([np.cos(angle), np.sin(angle)])
    symbols.arrow(panel, path, colour=shade)
