"""One mode of the whole train in space: shafts, gears and bearings to scale, the motion enlarged.

Lengths along all three axes are drawn at one scale. Every displacement, rotation and twist is
enlarged by one factor, so that the drawing is the mode's own shape.
"""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, NamedTuple

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

from gearbow._types import Array
from gearbow.errors import GearbowError
from gearbow.plots import STYLE, _colour
from gearbow.scene import Disk, Gear, Shaft

if TYPE_CHECKING:
    from gearbow.modes import Modes
    from gearbow.system import RotorSystem

__all__ = ["shape"]

#: The largest motion, over the diagonal of what is drawn.
ENLARGED = 0.07
#: The largest twist that is drawn [rad], where that is less.
TWISTED = 0.8
#: Points around a shaft or a gear.
AROUND = np.linspace(0.0, 2.0 * np.pi, 25)


class _Motion(NamedTuple):
    """What the centre line of a shaft does, node by node."""

    x: Array
    v: Array
    w: Array
    gamma: Array
    beta: Array
    twist: Array

    def at(self, position: float) -> Array:
        """(v, w, Γ, B, θ) somewhere on the shaft."""
        return np.array([np.interp(position, self.x, values) for values in self[1:]])


def shape(modes: "Modes", number: int) -> Figure:
    """Draw one mode of the whole train.

    Parameters
    ----------
    modes : Modes
        The modes.
    number : int
        Number of the mode, from 1 as in the table.

    Returns
    -------
    matplotlib.figure.Figure
        Shafts in their colours with a line along their surface that shows their twist, gears and
        disks with a spoke, bearings as triangles, and the orbits of gears and disks; thin lines are
        the train at rest.

    Raises
    ------
    GearbowError
        If there is no such mode.
    """
    if not 1 <= number <= len(modes.whirl):
        raise GearbowError(f"there is no mode {number}; there are {len(modes.whirl)}, from 1")
    system, shape_ = modes.system, modes.shapes[number - 1]
    places = _places(system)
    bodies = _bodies(system)
    ends = np.array(
        [
            places[shaft.name] + [[x, side * _reach(system, shaft), side * _reach(system, shaft)]]
            for shaft in system.shafts
            for x in (0.0, _length(shaft))
            for side in (-1.0, 1.0)
        ]
    ).reshape(-1, 3)
    extent = np.ptp(ends, axis=0)
    # What moves most, a rim by its turning included, sets the scale.
    lever = np.array([_lever(system, dof) for dof in system.dofs])
    moving = shape_ * lever
    factor = ENLARGED * float(np.linalg.norm(extent)) / float(np.abs(moving).max())
    twists = [abs(x) for x, dof in zip(shape_, system.dofs, strict=True) if dof[2] == "twist"]
    factor = min(factor, TWISTED / max([*twists, TWISTED / factor]))
    turned = _turned(shape_, moving) * factor

    with mpl.rc_context({**STYLE, "figure.constrained_layout.use": False}):
        figure = Figure(figsize=(12.0, 7.6))
        axes: Any = figure.add_axes((0.0, 0.06, 1.0, 0.82), projection="3d")
        for index, shaft in enumerate(system.shafts):
            at, colour = places[shaft.name], _colour(index)
            motion = _motion(system, shaft.name, np.real(turned))
            rest = np.array([[0.0, 0.0, 0.0], [_length(shaft), 0.0, 0.0]])
            axes.plot(*(at + rest).T, color="0.6", linewidth=0.8)
            _draw_tube(axes, at, shaft, motion, colour)
            axes.plot([], [], color=colour, linewidth=6.0, label=shaft.name)
            for body in (body for body in bodies if body.shaft == shaft.name):
                _draw_disc(axes, at, body, motion, colour)
                orbit = _orbit(system, body, turned)
                axes.plot(*(at + orbit).T, color=colour, linewidth=1.2)
        for bearing in system.bearings:
            shaft = next(shaft for shaft in system.shafts if shaft.name == bearing.shaft)
            foot = places[bearing.shaft] + [bearing.position, 0.0, -_outer(shaft, bearing.position)]
            axes.plot(*foot[:, np.newaxis], "^", color="black", markersize=10)
        # What reaches out of the box of the axes is not cut off.
        for artist in axes.get_children():
            artist.set_clip_on(False)
        axes.set_box_aspect(np.maximum(extent, 0.25 * extent.max()), zoom=1.35)
        axes.set(xlabel="x [m]", ylabel="y [m]", zlabel="z [m]")
        axes.xaxis.labelpad = axes.yaxis.labelpad = 14
        axes.locator_params(nbins=4)
        axes.view_init(elev=22.0, azim=-58.0)
        figure.legend(loc="upper left", bbox_to_anchor=(0.02, 0.88))
        figure.suptitle(
            f"mode {number}: {modes.frequencies_hz[number - 1]:.1f} Hz, {modes.whirl[number - 1]}, "
            f"damping {100.0 * modes.damping_ratios[number - 1]:.2f} %\n"
            f"{modes.names()[number - 1]}"
        )
    return figure


def _places(system: "RotorSystem") -> dict[str, Array]:
    """Say where the left end of every shaft lies at rest: meshes tell how shafts stand together."""
    gears = {gear.name: gear for gear in system.gears}
    found = {system.shafts[0].name: np.zeros(3)}
    while step := next(_next(system, gears, found), None):
        name, place = step
        found[name] = place
    return found


def _next(
    system: "RotorSystem", gears: dict[str, Gear], found: dict[str, Array]
) -> Iterator[tuple[str, Array]]:
    """Shafts that mesh with one whose place is found."""
    for mesh in system.meshes:
        driver, driven = gears[mesh.driver], gears[mesh.driven]
        distance = mesh.centre_distance or _radius(driver) + _radius(driven)
        angle = mesh.centre_line_angle
        step = np.array(
            [
                driver.position - driven.position,
                distance * np.cos(angle),
                distance * np.sin(angle),
            ]
        )
        for known, new, sign in ((driver, driven, 1.0), (driven, driver, -1.0)):
            if known.shaft in found and new.shaft not in found:
                yield new.shaft, found[known.shaft] + sign * step


def _radius(body: Gear | Disk) -> float:
    """Give the reference pitch radius of a gear; of a disk that of a thin one of its inertia."""
    if isinstance(body, Disk):
        return float(np.sqrt(2.0 * body.polar_inertia / body.mass)) if body.mass > 0.0 else 0.0
    if body.module is not None:
        return body.module * body.teeth / 2.0
    return (body.base_radius or 0.0) / float(np.cos(body.pressure_angle))


def _bodies(system: "RotorSystem") -> list[Gear | Disk]:
    return [*system.gears, *system.disks]


def _reach(system: "RotorSystem", shaft: Shaft) -> float:
    """Find the largest radius of what turns with a shaft."""
    bodies = [body for body in _bodies(system) if body.shaft == shaft.name]
    return max([_radius(body) for body in bodies] + [radius for _, radius in _steps(shaft)])


def _steps(shaft: Shaft) -> list[tuple[float, float]]:
    """(end, outer radius) of every segment of a shaft."""
    if shaft.segments is None:
        return [(float(shaft.length or 0.0), float(shaft.outer_diameter or 0.0) / 2.0)]
    ends = np.cumsum([segment.length for segment in shaft.segments])
    return [
        (float(end), segment.outer_diameter / 2.0)
        for end, segment in zip(ends, shaft.segments, strict=True)
    ]


def _length(shaft: Shaft) -> float:
    return _steps(shaft)[-1][0]


def _outer(shaft: Shaft, position: float) -> float:
    return next((radius for end, radius in _steps(shaft) if position <= end), _steps(shaft)[-1][1])


def _lever(system: "RotorSystem", dof: tuple[str, float, str]) -> float:
    """How far a degree of freedom moves the outside of the train: a twist turns a rim."""
    name, position, direction = dof
    if direction in ("v", "w"):
        return 1.0
    if direction in ("B", "G"):
        return 0.0
    shaft = next(shaft for shaft in system.shafts if shaft.name == name)
    rims = [
        _radius(body)
        for body in _bodies(system)
        if body.shaft == name and abs(body.position - position) < 1e-9
    ]
    return max(rims, default=_outer(shaft, position))


def _turned(shape_: Any, moving: Any) -> Any:
    """Turn a complex shape to the instant at which what moves most is at its largest."""
    largest = moving[int(np.argmax(np.abs(moving)))]
    return shape_ * (np.conj(largest) / np.abs(largest))


def _motion(system: "RotorSystem", name: str, values: Array) -> _Motion:
    nodes: dict[float, dict[str, float]] = {}
    for (shaft, position, direction), value in zip(system.dofs, values.tolist(), strict=True):
        if shaft == name:
            nodes.setdefault(position, {})[direction] = value
    columns = [
        np.array([node.get(direction, 0.0) for node in nodes.values()])
        for direction in ("v", "w", "G", "B", "twist")
    ]
    return _Motion(np.array(list(nodes)), *columns)


def _ring(position: float, radius: float, moved: Array, around: Array) -> Array:
    """Points of a circle on the shaft, moved, tilted and twisted with it."""
    v, w, gamma, beta, twist = moved
    y, z = radius * np.cos(around + twist), radius * np.sin(around + twist)
    return np.column_stack([position - gamma * y + beta * z, v + y, w + z])


def _draw_tube(axes: Any, at: Array, shaft: Shaft, motion: _Motion, colour: str) -> None:
    stations = [
        (position, radius)
        for begin, (end, radius) in zip(
            [0.0, *(end for end, _ in _steps(shaft))], _steps(shaft), strict=False
        )
        for position in np.linspace(begin, end, max(2, int(24 * (end - begin) / _length(shaft))))
    ]
    rings = np.array([at + _ring(x, r, motion.at(x), AROUND) for x, r in stations])
    surface = np.moveaxis(rings, -1, 0)
    axes.plot_surface(*surface, color=colour, alpha=0.35, linewidth=0.0, shade=True)
    # A line that is straight along the shaft at rest.
    mark = np.array(
        [at + _ring(x, r, motion.at(x), np.array([np.pi / 2.0]))[0] for x, r in stations]
    )
    axes.plot(*mark.T, color="black", linewidth=1.4)


def _draw_disc(axes: Any, at: Array, body: Gear | Disk, motion: _Motion, colour: str) -> None:
    radius = _radius(body)
    moved = motion.at(body.position)
    rim = at + _ring(body.position, radius, moved, AROUND)
    disc = Poly3DCollection([rim], facecolor=colour, edgecolor=colour, alpha=0.25, linewidth=1.6)
    axes.add_collection3d(disc)
    still = at + _ring(body.position, radius, np.zeros(5), AROUND)
    axes.plot(*still.T, color="0.6", linewidth=0.8)
    spoke = at + _ring(body.position, radius, moved, np.array([np.pi / 2.0]))
    centre = at + np.array([body.position, *moved[:2]])
    axes.plot(*np.vstack([centre, spoke]).T, color="black", linewidth=1.4)


def _orbit(system: "RotorSystem", body: Gear | Disk, turned: Any) -> Array:
    """Follow the path of a body over a cycle."""
    v, w, _ = system._model.indices(body.name)
    if v is None or w is None:
        return np.array([[body.position, 0.0, 0.0]])
    cycle = np.exp(1j * AROUND)
    return np.column_stack(
        [
            np.full(AROUND.size, body.position),
            np.real(turned[v] * cycle),
            np.real(turned[w] * cycle),
        ]
    )
