"""Figures of deflected shafts: modes along the shafts and in space, MAC, and the equilibrium."""

from collections.abc import Iterator, Sequence
from itertools import product
from typing import Any, NamedTuple

import numpy as np
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d import Axes3D
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

from gearbow._types import Array, ComplexArray, NodalDof
from gearbow.description.coordinates import Coordinates, drawn_positions
from gearbow.description.layout import BaseOutline, BodyOutline, Layout, ShaftOutline
from gearbow.errors import GearbowError
from gearbow.plotting.style import (
    MICRO,
    STYLE,
    GivenAxes,
    colour,
    common_round_off,
    drawing,
    panels,
    text_size,
)


def refined(
    shapes: ComplexArray, coordinates: Coordinates, layout: Layout
) -> tuple[ComplexArray, list[NodalDof]]:
    """Evaluate mode shapes at the nodes and between them."""
    entries: dict[str, dict[float, dict[str, Any]]] = {}
    for (name, x, direction), values in zip(coordinates.dofs, shapes.T, strict=True):
        if not isinstance(x, tuple):
            entries.setdefault(name, {}).setdefault(x, {})[direction] = values
    found: dict[NodalDof, ComplexArray] = {}
    for shaft in layout.shafts:
        nodes = list(entries.get(shaft.name, ()))
        positions = drawn_positions(nodes)
        for direction, rows in coordinates.along(shaft.name, positions).items():
            for x, value in zip(positions, rows @ shapes.T, strict=True):
                found[shaft.name, x, direction] = value
    for base in layout.bases:
        for x, moved in entries.get(base.name, {}).items():
            found |= {(base.name, x, direction): value for direction, value in moved.items()}
        modes = shapes[:, [n for n, dof in enumerate(coordinates.dofs) if dof[0] == base.name]]
        for each in base.interfaces if base.name in entries else ():
            for direction, row in zip("uvw", each.rows, strict=True):
                found[each.name, float(each.position[0]), direction] = modes @ row
    return np.array(list(found.values())).T, list(found)


#: Largest motion of the drawing, relative to the diagonal of the train.
LARGEST_MOTION = 0.07
#: Largest twist of the drawing [rad].
LARGEST_TWIST = 0.8
#: Elevation and azimuth from which a train is seen [°].
_ELEVATION, _AZIMUTH = 22.0, -58.0
#: Largest height of the box of the axes as it is seen without zoom, relative to its panel; labels
#: stand below it.
_LARGEST_HEIGHT = 0.87
#: Angles of the points around a shaft or a gear [rad].
AROUND = np.linspace(0.0, 2.0 * np.pi, 25)


class Surface(NamedTuple):
    """A surface: points (3, rings, around), or the corners of a polygon (3, 1, around)."""

    points: Array
    colour: str
    opacity: float


class Path(NamedTuple):
    """A line through points (k, 3), with a label for the legend and a marker of matplotlib."""

    points: Array
    colour: str
    width: float
    label: str | None = None
    marker: str = ""
    marker_size: float = 6.0


class _Motion(NamedTuple):
    """Motion of the nodes of a shaft."""

    x: Array
    v: Array
    w: Array
    gamma: Array
    beta: Array
    twist: Array
    along: Array

    def at(self, position: float) -> Array:
        """(v, w, Γ, B, θ, u) at a position, interpolated linearly."""
        return np.array([np.interp(position, self.x, values) for values in self[1:]])


# The three axes have the same scale. One factor enlarges all displacements, rotations and twists,
# so that the drawing shows the mode shape without distortion.
def draw(
    title: str,
    shape: ComplexArray,
    dofs: Sequence[NodalDof],
    layout: Layout,
    *,
    ax: GivenAxes = None,
) -> Figure:
    """Draw one mode of the train."""
    settings = {**STYLE, "figure.constrained_layout.use": False}
    with drawing(ax, (1,), _new, settings=settings) as (figure, (axes,)):
        if not isinstance(axes, Axes3D):
            raise GearbowError(
                "ax: a mode of the train needs Axes in three dimensions; make them with "
                'figure.add_subplot(projection="3d")'
            )
        for part in parts(shape, dofs, layout):
            if isinstance(part, Path):
                style: dict[str, Any] = {"marker": part.marker, "markersize": part.marker_size}
                style |= {"color": part.colour, "linewidth": part.width, "label": part.label}
                axes.plot(*part.points.T, **style)
            elif part.points.shape[1] > 1:
                style = {"color": part.colour, "alpha": part.opacity}
                axes.plot_surface(*part.points, linewidth=0.0, shade=True, **style)
            else:
                style = {"facecolor": part.colour, "edgecolor": part.colour, "alpha": part.opacity}
                axes.add_collection3d(Poly3DCollection([part.points[:, 0].T], lw=1.6, **style))
        _finish(axes, _extent(layout))
        if ax is None:
            figure.legend(loc="upper left", bbox_to_anchor=(0.02, 0.88))
            figure.suptitle(title)
        else:
            axes.legend(loc="upper left", fontsize="small")
            axes.set_title(title)
    return figure


def parts(
    shape: ComplexArray, dofs: Sequence[NodalDof], layout: Layout
) -> Iterator[Surface | Path]:
    """Give the surfaces and lines of a mode, with enlarged motions."""
    extent = _extent(layout)
    moving = shape * np.array([_lever(layout, dof) for dof in dofs])
    shafts = {shaft.name for shaft in layout.shafts}
    twists = [
        abs(x) for x, d in zip(shape, dofs, strict=True) if d[2] == "twist" and d[0] in shafts
    ]
    factor = LARGEST_MOTION * float(np.linalg.norm(extent)) / float(np.abs(moving).max())
    factor = min(factor, LARGEST_TWIST / max([*twists, LARGEST_TWIST / factor]))
    scaled = _at_maximum(shape, moving) * factor
    for index, shaft in enumerate(layout.shafts):
        motion = _motion(dofs, shaft.name, np.real(scaled))
        rest = np.array([[0.0, 0.0, 0.0], [shaft.length, 0.0, 0.0]])
        yield Path(shaft.origin + rest, "0.6", 0.8)
        yield from _tube(shaft, motion, colour(index))
        yield Path(np.empty((0, 3)), colour(index), 6.0, shaft.name)
        for body in (body for body in layout.bodies if body.shaft == shaft.name):
            yield from _disc(shaft.origin, body, motion, colour(index))
            yield Path(shaft.origin + _orbit(dofs, body, scaled), colour(index), 1.2)
    for index, base in enumerate(layout.bases):
        shade = colour(len(layout.shafts) + index)
        if base.interfaces:
            yield from _elastic(base, dofs, np.real(scaled), shade)
        else:
            yield from _base(layout, base, _motion(dofs, base.name, np.real(scaled)), shade)
    for name, position in layout.bearings:
        shaft = layout.shaft(name)
        foot = shaft.origin + np.array([position, 0.0, -shaft.outer_radius(position)])
        yield Path(foot[np.newaxis], "black", 0.0, marker="^", marker_size=10.0)


def _new() -> tuple[Figure, list[Any]]:
    """Make a figure with a panel in three dimensions."""
    figure = Figure(figsize=(12.0, 7.6))
    return figure, [figure.add_axes((0.0, 0.09, 1.0, 0.8), projection="3d")]


def _finish(axes: Any, extent: Array) -> None:
    """Set scales, labels and view of the axes."""
    # Do not clip parts that extend beyond the box of the axes.
    for artist in axes.get_children():
        artist.set_clip_on(False)
    elevation, azimuth = np.radians([_ELEVATION, _AZIMUTH])
    upwards = np.array(
        [
            np.sin(elevation) * np.cos(azimuth),
            np.sin(elevation) * np.sin(azimuth),
            np.cos(elevation),
        ]
    )
    box = np.maximum(extent, 0.25 * extent.max())
    height = np.abs(upwards) @ box / np.linalg.norm(box)
    axes.set_box_aspect(box, zoom=min(1.12, _LARGEST_HEIGHT / height))
    axes.set(xlabel="x [m]", ylabel="y [m]", zlabel="z [m]")
    axes.xaxis.labelpad = axes.yaxis.labelpad = 24
    axes.locator_params(nbins=4)
    axes.view_init(elev=_ELEVATION, azim=_AZIMUTH)


def _extent(layout: Layout) -> Array:
    """Find the lengths of the train along x, y and z [m]."""
    corners = []
    for shaft in layout.shafts:
        radii = [body.radius for body in layout.bodies if body.shaft == shaft.name]
        reach = max(radii + [step.largest for step in shaft.steps])
        for x in (0.0, shaft.length):
            for side in (-reach, reach):
                corners.append(shaft.origin + np.array([x, side, side]))
    extent: Array = np.ptp(np.array(corners), axis=0)
    return extent


def _lever(layout: Layout, dof: NodalDof) -> float:
    """Give the displacement of the surface per unit of a degree of freedom."""
    name, position, direction = dof
    if direction in ("u", "v", "w"):
        return 1.0
    if direction in ("B", "G") or any(base.name == name for base in layout.bases):
        return 0.0
    rims = [
        body.radius
        for body in layout.bodies
        if body.shaft == name and abs(body.position - position) < 1e-9
    ]
    return max(rims, default=layout.shaft(name).outer_radius(position))


def _at_maximum(shape: Any, moving: Any) -> Any:
    """Rotate the phase of a complex shape so that its largest motion is real and positive."""
    largest = moving[int(np.argmax(np.abs(moving)))]
    return shape * (np.conj(largest) / np.abs(largest))


def _motion(dofs: Sequence[NodalDof], name: str, values: Array) -> _Motion:
    nodes: dict[float, dict[str, float]] = {}
    for (shaft, position, direction), value in zip(dofs, values.tolist(), strict=True):
        if shaft == name:
            nodes.setdefault(position, {})[direction] = value
    columns = [
        np.array([node.get(direction, 0.0) for node in nodes.values()])
        for direction in ("v", "w", "G", "B", "twist", "u")
    ]
    return _Motion(np.array(list(nodes)), *columns)


def _ring(position: float, radius: float, moved: Array, around: Array) -> Array:
    """Give points of a circle on the shaft after its displacements, tilt and twist."""
    v, w, gamma, beta, twist, along = moved
    y, z = radius * np.cos(around + twist), radius * np.sin(around + twist)
    return np.column_stack([position + along - gamma * y + beta * z, v + y, w + z])


def _tube(shaft: ShaftOutline, motion: _Motion, shade: str) -> Iterator[Surface | Path]:
    stations = [
        (position, step.radius(position))
        for step in shaft.steps
        for position in np.linspace(
            step.begin, step.end, max(2, int(24 * (step.end - step.begin) / shaft.length))
        )
    ]
    rings = np.array([shaft.origin + _ring(x, r, motion.at(x), AROUND) for x, r in stations])
    yield Surface(np.moveaxis(rings, -1, 0), shade, 0.35)
    # This line is straight and parallel to the shaft at rest.
    top = np.array([np.pi / 2.0])
    mark = np.array([shaft.origin + _ring(x, r, motion.at(x), top)[0] for x, r in stations])
    yield Path(mark, "black", 1.4)


def _disc(
    origin: Array, body: BodyOutline, motion: _Motion, shade: str
) -> Iterator[Surface | Path]:
    """Give a moved disk with a mark on its radius, and its rim at rest."""
    moved = motion.at(body.position)
    rim = origin + _ring(body.position, body.radius, moved, AROUND)
    yield Surface(rim.T[:, np.newaxis], shade, 0.25)
    rest = origin + _ring(body.position, body.radius, np.zeros(6), AROUND)
    yield Path(rest, "0.6", 0.8)
    spoke = origin + _ring(body.position, body.radius, moved, np.array([np.pi / 2.0]))
    centre = origin + np.array([body.position + moved[5], *moved[:2]])
    yield Path(np.vstack([centre, spoke]), "black", 1.4)


def _base(layout: Layout, base: BaseOutline, motion: _Motion, shade: str) -> Iterator[Path]:
    """Give lines from the centre of a support or housing to its bearings, at rest and moved."""
    if not motion.x.size:
        return
    feet = []
    for name, position in base.feet:
        shaft = layout.shaft(name)
        below = np.array([position, 0.0, -shaft.outer_radius(position)])
        feet.append(shaft.origin + below - base.centre)
    v, w, gamma, beta, twist, along = (float(values[0]) for values in motion[1:])
    for number, foot in enumerate(feet):
        x, y, z = foot
        moved = np.array([along, v, w])
        moved += [beta * z - gamma * y, gamma * x - twist * z, twist * y - beta * x]
        centre = base.centre + np.array([along, v, w])
        yield Path(np.array([base.centre, base.centre + foot]), "0.6", 0.8)
        path = np.array([centre, base.centre + foot + moved])
        yield Path(path, shade, 3.0, base.name if number == 0 else None, marker="s")


def _elastic(
    base: BaseOutline, dofs: Sequence[NodalDof], values: Array, shade: str
) -> Iterator[Path]:
    """Give lines from the middle of an elastic housing to its interfaces, at rest and moved."""
    rest = np.array([each.position for each in base.interfaces])
    moved = rest.copy()
    for row, each in zip(moved, base.interfaces, strict=True):
        motion = _motion(dofs, each.name, values)
        row += [motion.along[0], motion.v[0], motion.w[0]]
    for number, (before, after) in enumerate(zip(rest, moved, strict=True)):
        yield Path(np.array([rest.mean(axis=0), before]), "0.6", 0.8)
        path = np.array([moved.mean(axis=0), after])
        yield Path(path, shade, 2.0, base.name if number == 0 else None, marker="s")


def _orbit(dofs: Sequence[NodalDof], body: BodyOutline, scaled: Any) -> Array:
    """Give the path of the centre of a body over one cycle."""
    found = {
        direction: index
        for index, (shaft, position, direction) in enumerate(dofs)
        if shaft == body.shaft and abs(position - body.position) < 1e-9
    }
    if "v" not in found:
        return np.array([[body.position, 0.0, 0.0]])
    cycle = np.exp(1j * AROUND)
    along = scaled[found["u"]] if "u" in found else 0.0
    return np.column_stack(
        [
            body.position + np.real(along * cycle),
            np.real(scaled[found["v"]] * cycle),
            np.real(scaled[found["w"]] * cycle),
        ]
    )


def overview(
    titles: Sequence[str],
    shapes: ComplexArray,
    dofs: Sequence[NodalDof],
    drawn: Sequence[str],
    layout: Layout,
    *,
    ax: GivenAxes = None,
) -> Figure:
    """Draw mode shapes along the shafts."""
    shafts = [shaft.name for shaft in layout.shafts]
    places = {base.name: float(np.mean([x for _, x in base.feet])) for base in layout.bases}
    if not titles:
        return _without_modes(ax)
    with panels(len(titles), 3.5, columns=2, width=13.0, ax=ax) as (figure, axes):
        for mode, (panel, title) in enumerate(zip(axes, titles, strict=True)):
            lines = {"v": "-", "w": "--"} if drawn[mode] == "lateral" else {drawn[mode]: "-"}
            shape = _real(shapes[mode], [direction in lines for _, _, direction in dofs])
            for (direction, line), (i, shaft) in product(lines.items(), enumerate(shafts)):
                at = [n for n, (s, _, d) in enumerate(dofs) if (s, d) == (shaft, direction)]
                x = [dofs[n][1] for n in at]
                name = None if direction == "w" else shaft
                panel.plot(x, shape[at], line, color=colour(i), label=name)
            for (direction, line), (i, name) in product(lines.items(), enumerate(places)):
                at = [n for n, (s, _, d) in enumerate(dofs) if (s, d) == (name, direction)]
                face = colour(len(shafts) + i) if line == "-" else "white"
                style: dict[str, Any] = {"color": colour(len(shafts) + i), "markerfacecolor": face}
                if at:
                    own = name if line == "-" else None
                    panel.plot(places[name], shape[at[0]], "s", markersize=8.0, label=own, **style)
                for each in layout.bases[i].interfaces:
                    at = [n for n, (s, _, d) in enumerate(dofs) if (s, d) == (each.name, direction)]
                    if at and each.bearing is not None:
                        panel.plot(each.bearing, shape[at[0]], "s", markersize=6.0, **style)
            panel.set_title(title, fontsize=text_size(1.0))
            panel.set(xlabel="position [m]")
            label = "y (z dashed, open)" if places else "y (z dashed)"
            label = {"lateral": label, "u": "x"}.get(drawn[mode], drawn[mode])
            panel.set(ylabel=label, ylim=(-1.15, 1.15))
    return figure


def _real(shape: ComplexArray, drawn: Sequence[bool]) -> Array:
    """Give the real part of a complex shape, scaled so that its largest drawn entry is 1."""
    largest = shape[int(np.argmax(np.where(drawn, np.abs(shape), 0.0)))]
    return np.real(shape / largest) if largest != 0.0 else np.real(shape)


def _without_modes(ax: GivenAxes) -> Figure:
    """Say that there is no mode to draw."""
    with panels(1, 3.5, width=6.5, ax=ax) as (figure, (panel,)):
        panel.set_title("no modes", fontsize=text_size(1.0))
    return figure


def assurance(mac: Array, computed: Array, measured: Array, *, ax: GivenAxes = None) -> Figure:
    """Draw MAC of computed and measured modes as a table of colours."""
    if mac.size == 0:
        return _without_modes(ax)
    with panels(1, 6.0, width=8.0, ax=ax) as (figure, (panel,)):
        image = panel.imshow(mac.T, vmin=0.0, vmax=1.0, origin="lower", cmap="Blues", aspect="auto")
        figure.colorbar(image, ax=panel, label="MAC")
        for (i, j), value in np.ndenumerate(mac):
            dark = value > 0.6  # light text on a dark colour
            if value >= 0.005:
                panel.text(
                    i,
                    j,
                    f"{value:.2f}",
                    ha="center",
                    va="center",
                    color="white" if dark else "black",
                )
        for ticks, axis, values in (
            (panel.set_xticks, "computed", computed),
            (panel.set_yticks, "measured", measured),
        ):
            ticks(np.arange(values.size), [f"{i + 1}: {f:.4g} Hz" for i, f in enumerate(values)])
            panel.set(**{f"{'x' if axis == 'computed' else 'y'}label": f"{axis} mode"})
        panel.tick_params(axis="x", rotation=45.0)
        panel.grid(visible=False)
    return figure


def deflection(
    state: Array, coordinates: Coordinates, layout: Layout, *, ax: GivenAxes = None
) -> Figure:
    """Draw the displacements of the shafts along y and z, or their twist."""
    values, nodes = refined(state[np.newaxis].astype(np.complex128), coordinates, layout)
    directions = {direction for *_, direction in nodes}
    rows = {"v": ("displacement y [µm]", MICRO), "w": ("displacement z [µm]", MICRO)}
    if "v" not in directions:
        rows = {"twist": ("twist [mrad]", 1e3)}
    with panels(len(rows), 3.2, sharex=True, ax=ax, x="position [m]") as (figure, axes):
        for panel, (direction, (label, factor)) in zip(axes, rows.items(), strict=True):
            for i, shaft in enumerate(layout.shafts):
                own = sorted(
                    (x, factor * float(value.real))
                    for (name, x, kind), value in zip(nodes, values[0], strict=True)
                    if (name, kind) == (shaft.name, direction)
                )
                if not own:
                    continue
                x, y = np.array(own).T
                panel.plot(shaft.origin[0] + x, y, color=colour(i), label=shaft.name)
                marks = [body.position for body in layout.bodies if body.shaft == shaft.name]
                at = shaft.origin[0] + np.array(marks)
                panel.plot(at, np.interp(marks, x, y), "o", color=colour(i), markersize=5.0)
            panel.set(ylabel=label)
        # Without gravity along y, round-off would fill its panel.
        common_round_off(axes)
    return figure
