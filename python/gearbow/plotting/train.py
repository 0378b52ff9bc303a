"""Drawing of a train: side view with all parts to scale, and end view."""

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Polygon, Rectangle

from gearbow._types import Array
from gearbow.description.gears import Gear, Mesh
from gearbow.description.layout import (
    BaseOutline,
    BodyOutline,
    InterfaceOutline,
    ShaftOutline,
    Step,
)
from gearbow.description.places import Support, housing_and_interface, name_of_housing
from gearbow.description.train import Train
from gearbow.plotting import symbols
from gearbow.plotting.labels import Box, Labels, Place, around, series
from gearbow.plotting.style import (
    colour,
    drawing,
    figure_of,
    quantity,
    round_factor,
)
from gearbow.plotting.symbols import Development, body_box, boxes_of, developed

#: Points around a box where its label may be: above, below, right, left.
_WAYS = ((0, 1), (0, -1), (1, 0.8), (-1, 0.8), (1, -0.8), (-1, -0.8), (1, 0), (-1, 0), (0, 0))


def _without_interface(base: Any) -> Any:
    """Give what a bearing stands on; the name of an elastic housing for an interface of it."""
    seat = housing_and_interface(base)
    return base if seat is None else seat[0]


class SideView:
    """Side view of a train."""

    def __init__(self, train: Train, magnify: float) -> None:
        self.train, self.magnify = train, magnify
        self.development: Development = developed(train)
        self.shades = {shaft.name: colour(i) for i, shaft in enumerate(train.layout.shafts)}
        self.boxes: list[Box] = [box for shaft in train.layout.shafts for box in self._own(shaft)]
        self.kinds = symbols.kinds(train)

    def extent(self) -> Box:
        """Give the box of all parts to scale."""
        left, bottom, right, top = np.transpose(self.boxes)
        return float(left.min()), float(bottom.min()), float(right.max()), float(top.max())

    def draw(self, panel: Axes, point: float) -> None:
        """Draw the view into a panel with final limits."""
        labels = Labels(panel, point)
        labels.avoid(*self.boxes)
        for shaft in self.train.layout.shafts:
            self._shaft(panel, shaft)
        labels.avoid(*self._feet(labels), *self._couplings(labels), strictly=True)
        # Labels with fewer possible places come first.
        self._gear_names(labels)
        self._shaft_names(labels)
        symbols.draw_loads(labels, self.train, self.development.heights)
        self._bows(labels)
        labels.place()

    def _height(self, name: str) -> float:
        return self.development.heights[name]

    def _own(self, shaft: ShaftOutline) -> list[Box]:
        """Give the boxes of the segments, sleeves, gears and disks of a shaft."""
        return boxes_of(self.train, shaft, self._height(shaft.name))

    def _shaft(self, panel: Axes, shaft: ShaftOutline) -> None:
        """Draw the segments, gears and disks of a shaft, and its axis."""
        shade = self.shades[shaft.name]
        x, y = float(shaft.origin[0]), self._height(shaft.name)
        boxes = self._own(shaft)
        for step, box in zip(shaft.steps, boxes, strict=False):
            style: dict[str, Any] = {"facecolor": shade, "edgecolor": shade, "alpha": 0.35}
            if step.outer[0] == step.outer[1]:
                panel.add_patch(_rectangle(box, zorder=2.0, **style))
            else:
                corners = [*_edge(step, 1.0, x, y), *_edge(step, -1.0, x, y)[::-1]]
                panel.add_patch(Polygon(corners, zorder=2.0, **style))
            # The hidden edges of a bore.
            if max(step.inner) > 0.0:
                for side in (1.0, -1.0):
                    edge = [y + side * radius for radius in step.inner]
                    ends = [x + step.begin, x + step.end]
                    panel.plot(ends, edge, color=shade, linewidth=1.0, linestyle="--", zorder=2.5)
        for sleeve in shaft.sleeves:
            left, right = x + sleeve.begin, x + sleeve.end
            for side in (1.0, -1.0):
                bottom, top = sorted(
                    y + side * radius[0] for radius in (sleeve.inner, sleeve.outer)
                )
                style = {"facecolor": "none", "edgecolor": shade, "hatch": "/////"}
                panel.add_patch(_rectangle((left, bottom, right, top), zorder=2.2, **style))
        for box in boxes[len(shaft.steps) + len(shaft.sleeves) :]:
            style = {"facecolor": shade, "edgecolor": "black", "alpha": 0.55}
            panel.add_patch(_rectangle(box, zorder=3.0, **style))
        over = 0.03 * shaft.length
        ends = [x - over, x + shaft.length + over]
        panel.plot(ends, [y, y], color="0.25", linewidth=0.8, linestyle="-.", zorder=4.0)

    def _feet(self, labels: Labels) -> Iterator[Box]:
        """Draw the bearings and what they stand on."""
        panel, point = labels.panel, labels.point
        housings: dict[str, list[Box]] = {
            housing.name: [] for housing in self.train.parts["housings"]
        }
        for part in self.train.parts["bearings"]:
            shaft, base = self.train.layout.shaft(part.shaft), self._base(part)
            x = float(shaft.origin[0]) + part.position
            radius = shaft.outer_radius(part.position)
            if isinstance(base, tuple):  # on the surface of the inner one of two shafts
                radius = min(radius, self.train.layout.shaft(base[0]).outer_radius(base[1]))
            y = self._height(part.shaft) - radius
            kind = symbols.bearing_kind(part)
            foot = symbols.bearing(panel, kind, x, y, point)
            yield foot
            if isinstance(base, tuple):
                continue
            name = base if isinstance(base, str) else getattr(base, "name", None)
            if name in housings:
                housings[name].append(foot)
                continue
            if base is not None:
                foot = symbols.support(panel, x, foot[1], point)
                yield foot
                if name is not None:
                    labels.add(name, around(((1, 0), (-1, 0), (0, -1)), foot))
                under = name_of_housing(base.support)
                if under is not None:
                    housings[under].append(foot)
                    continue
            yield symbols.ground(panel, x, foot[1], point)
        for name, feet in housings.items():
            if feet:
                self._housing(labels, name, feet)

    def _base(self, bearing: Any) -> Any:
        """Give the base of a bearing: a support, the name of a housing or the place of a shaft."""
        base, supports = bearing.support, self.train.parts["supports"]
        named = next((each for each in supports if each.name == base), None)
        return _without_interface(base) if named is None else named

    def _stands_on(self, bearing: Any, housing: str) -> bool:
        base = self._base(bearing)
        return housing == (name_of_housing(base.support) if isinstance(base, Support) else base)

    def _housing(self, labels: Labels, name: str, feet: list[Box]) -> None:
        """Draw a grey area behind the bearings of a housing."""
        edges = np.array(feet)
        margin = 8.0 * labels.point
        left, bottom = edges[:, 0].min() - margin, edges[:, 1].min() - margin
        right = edges[:, 2].max() + margin
        bearings = self.train.parts["bearings"]
        shafts = {part.shaft for part in bearings if self._stands_on(part, name)}
        top = max(box[3] for shaft in shafts for box in self._own(self.train.layout.shaft(shaft)))
        top = max(top, edges[:, 3].max()) + margin
        (base,) = (each for each in self.train.layout.bases if each.name == name)
        others = _without_bearing(base)
        left = min([left, *(float(each.position[0]) for each in others)])
        right = max([right, *(float(each.position[0]) for each in others)])
        for each in others:  # the view has no height of its own for them
            x, above = float(each.position[0]), each.position[2] > base.centre[2]
            y, size = (top if above else bottom), 3.0 * labels.point
            box = (x - size, y - size, x + size, y + size)
            labels.panel.add_patch(_rectangle(box, fc="0.4", ec="black", zorder=5.0))
            labels.add(each.name, around(_WAYS[:8], box), color="0.25")
        style: dict[str, Any] = {"fc": "0.93", "ec": "0.4", "linewidth": 1.2, "linestyle": "--"}
        labels.panel.add_patch(_rectangle((left, bottom, right, top), zorder=1.0, **style))
        inside = [((left, top), (1.0, -1.0)), ((right, top), (-1.0, -1.0))]
        inside += [((left, bottom), (1.0, 1.0)), ((right, bottom), (-1.0, 1.0))]
        labels.add(name, inside, color="0.25")

    def _couplings(self, labels: Labels) -> Iterator[Box]:
        for part in self.train.parts["couplings"]:
            x, y, radius = symbols.place_of_load(self.train, self.development.heights, part.a)
            yield symbols.coupling(labels.panel, x, y, radius, labels.point)

    def _gear_names(self, labels: Labels) -> None:
        boxes = {
            body.name: body_box(self.train, body, self._height(body.shaft))
            for body in self.train.layout.bodies
        }
        for shaft in self.train.layout.shafts:
            own = [body.name for body in self.train.layout.bodies if body.shaft == shaft.name]
            for text, names in series(own):
                labels.add(text, around(_WAYS, *(boxes[name] for name in names)))

    def _shaft_names(self, labels: Labels) -> None:
        """Write the name of each shaft at its ends, or along it."""
        for shaft in self.train.layout.shafts:
            boxes = self._own(shaft)[: len(shaft.steps)]
            begin, end = boxes[0], boxes[-1]
            places = [*around(((-1, 0),), begin), *around(((1, 0),), end)]
            for box in sorted(boxes, key=lambda box: box[0] - box[2]):
                for way in ((0.0, 1), (0.0, -1), (0.7, 1), (-0.7, 1), (0.7, -1), (-0.7, -1)):
                    places += around((way,), box)
            labels.add(shaft.name, places, color=self.shades[shaft.name], weight="bold")

    def _bows(self, labels: Labels) -> None:
        """Draw the enlarged bow of each shaft in its own plane, with its size and angle."""
        for name, (x, bow) in self.train.bows.items():
            left, y = float(self.train.layout.shaft(name).origin[0]), self._height(name)
            largest = bow[int(np.argmax(np.abs(bow)))]
            if largest == 0.0:
                continue
            curve = y + self.magnify * np.real(bow * np.conj(largest)) / abs(largest)
            labels.panel.plot(left + x, curve, color="black", linewidth=2.2, zorder=6.0)
            for (a, b), (c, d) in pairwise(zip(left + x[::4], curve[::4], strict=True)):
                labels.avoid((a, min(b, d), c, max(b, d)), strictly=True)
            text = f"bow {quantity(abs(largest), 'm', 3)} at {np.degrees(np.angle(largest)):.0f}°"
            places: list[Any] = []
            for part in (0.5, 0.35, 0.65, 0.2, 0.8, 0.05, 0.95):
                n = int(part * (x.size - 1))
                places += [((left + x[n], float(curve[n])), (0.0, way)) for way in (1.0, -1.0)]
            labels.add(text.replace("-", "−"), places)


def _rectangle(box: Box, **style: Any) -> Rectangle:
    left, bottom, right, top = box
    return Rectangle((left, bottom), right - left, top - bottom, **{"linewidth": 1.0, **style})


def _edge(step: Step, side: float, x: float, y: float) -> list[tuple[float, float]]:
    """Give the ends of the upper (1) or lower (-1) edge of a segment."""
    begin, end = (y + side * radius for radius in step.outer)
    return [(x + step.begin, begin), (x + step.end, end)]


#: Angles of the labels around a circle [rad].
_AROUND = np.radians([90, 270, 45, 135, 225, 315, 0, 180, 67, 113, 247, 293])


def circles(train: Train) -> list[BodyOutline]:
    """List the gears and disks that are drawn as circles, the largest first."""
    bodies = [body for body in train.layout.bodies if body.radius > 0.0]
    return sorted(bodies, key=lambda body: -body.radius)


def end_extent(train: Train) -> Box:
    """Give the box of the view."""
    found = [(train.layout.shaft(body.shaft).origin, body.radius) for body in circles(train)]
    found += [
        (shaft.origin, max(step.largest for step in (*shaft.steps, *shaft.sleeves)))
        for shaft in train.layout.shafts
    ]
    found += [(each.position, 0.0) for each in _free_interfaces(train)]
    low = np.min([centre[1:] - radius for centre, radius in found], axis=0)
    high = np.max([centre[1:] + radius for centre, radius in found], axis=0)
    return float(low[0]), float(low[1]), float(high[0]), float(high[1])


def _without_bearing(base: BaseOutline) -> list[InterfaceOutline]:
    """Give the interfaces of a housing that carry no bearing."""
    return [each for each in base.interfaces if each.bearing is None]


def _free_interfaces(train: Train) -> list[InterfaceOutline]:
    """Give the interfaces of all housings that carry no bearing."""
    return [each for base in train.layout.bases for each in _without_bearing(base)]


def line_of_action(pressure_angle: Any, centre_line_angle: Any, sense: float) -> Array:
    """Give the direction of the force on the driven gear."""
    along = np.stack([np.cos(centre_line_angle), np.sin(centre_line_angle)], axis=-1)
    across = np.stack([-np.sin(centre_line_angle), np.cos(centre_line_angle)], axis=-1)
    cosine = sense * np.cos(pressure_angle)[..., np.newaxis]
    direction: Array = cosine * across + np.sin(pressure_angle)[..., np.newaxis] * along
    return direction


def draw_end_view(panel: Axes, train: Train, shades: Mapping[str, str], point: float) -> None:
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
    # Interfaces behind each other are one square with the names of all.
    behind: dict[tuple[float, float], list[str]] = {}
    for each in _free_interfaces(train):
        y, z = (round(float(value), 9) for value in each.position[1:])
        behind.setdefault((y, z), []).append(each.name)
    for (y, z), own in behind.items():
        box = (y - 3.0 * point, z - 3.0 * point, y + 3.0 * point, z + 3.0 * point)
        panel.add_patch(_rectangle(box, fc="0.4", ec="black", zorder=5.0))
        labels.add(", ".join(own), around(_WAYS[:8], box), color="0.25")
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
    base = [body.signed_radius * np.cos(transverse) for body in pair]
    alpha = np.arccos(min(1.0, abs(sum(base)) / distance))
    sense = float(np.sign(train.ratios[pair[0].shaft]))
    gamma = mesh.centre_line_angle
    # The line of an internal driver leans the other way; an internal gear lies behind the pinion.
    leaning = -alpha if pair[0].internal else alpha
    way = line_of_action(np.float64(leaning), np.float64(gamma), sense)
    way = -way if pair[1].internal else way
    pitch = a + offset * base[0] / sum(base)
    internal = pair[0].internal or pair[1].internal
    arms = [min(map(abs, base))] * 2 if internal else base
    ends = np.array([pitch - arms[0] * np.tan(alpha) * way, pitch + arms[1] * np.tan(alpha) * way])
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


#: Width and largest height of the figure, and height of legend and labels of the axes [in].
_WIDTH, _HEIGHT, _BELOW = 13.5, 7.5, 1.6
#: Largest height of the end view below a side view [in].
_END = 4.6
#: Part of the width that the side view takes, and length of a train relative to its height from
#: which it takes the whole width, above the end view.
_SIDE, _LONG = 0.58, 6.5
#: Margins around the parts in both views, for names and symbols [pt].
_MARGIN = 46.0
#: Size of the largest bow on the page, as a fraction of the height of the parts.
_BOW = 0.12


def draw(train: Train, magnify: float | None, ax: Axes | Sequence[Axes] | None) -> Figure:
    """Draw a train."""
    side = SideView(train, magnification(train) if magnify is None else magnify)
    boxes = [side.extent(), end_extent(train)]
    entries = (symbols.handles(side.kinds), side.kinds)
    counts, what = (1, 2), "side view, or side view and end view"
    with drawing(ax, counts, lambda: _new(boxes), what) as (figure, panels):
        if side.kinds and ax is None:
            figure.legend(*entries, loc="outside lower center", ncols=6)
        elif side.kinds:
            panels[0].legend(*entries, fontsize="small", loc="best")
        _views(figure, side, panels, boxes)
    return figure


def magnification(train: Train) -> float:
    """Choose a round factor at which the largest bow is visible."""
    largest = max((float(np.abs(bow).max()) for _, bow in train.bows.values()), default=0.0)
    if largest == 0.0:
        return 1.0
    low, high = (end_extent(train)[i] for i in (1, 3))
    return round_factor(_BOW * (high - low) / largest)


def _new(boxes: Sequence[Box]) -> tuple[Figure, list[Axes]]:
    """Make a figure with two panels."""
    spans = np.array([[right - left, top - bottom] for left, bottom, right, top in boxes])
    margin = 2.0 * _MARGIN / 72.0
    if spans[0, 0] > _LONG * spans[0, 1]:
        width = _WIDTH - 2.0
        upper = float(np.clip(spans[0, 1] * (width - margin) / spans[0, 0] + margin, 3.2, _HEIGHT))
        lower = float(np.clip(spans[1, 1] * (width - margin) / spans[1, 0] + margin, 3.2, _END))
        figure = Figure(figsize=(_WIDTH, upper + lower + 1.5 * _BELOW))
        rows = figure.subplots(2, 1, height_ratios=[upper, lower], squeeze=False)
        return figure, rows[:, 0].tolist()
    widths = np.array([_SIDE, 1.0 - _SIDE]) * (_WIDTH - 2.0)
    heights = spans[:, 1] * (widths - margin) / spans[:, 0] + margin
    figure = Figure(figsize=(_WIDTH, float(np.clip(heights.max(), 3.5, _HEIGHT)) + _BELOW))
    panels = figure.subplots(1, 2, width_ratios=widths.tolist(), squeeze=False)[0].tolist()
    return figure, panels


def _views(figure: Figure, side: SideView, panels: Sequence[Axes], boxes: Sequence[Box]) -> None:
    """Draw the views, after the limits, which give the length of a point of the page."""
    bow = f", bow × {side.magnify:g}" if side.train.bows else ""
    titles = (f"side view{bow}", "end view, seen along −x")
    upright = "y [m]" if side.development.true else "along the lines of centres [m]"
    labels = (("x [m]", upright), ("y [m]", "z [m]"))
    for panel, title, (x, y) in zip(panels, titles, labels, strict=False):
        panel.set(title=title, xlabel=x, ylabel=y)
        panel.grid(visible=False)
    # The width of the numbers at the axes depends on the limits, and the limits on this width.
    _fit_all(panels, boxes)
    engine = figure.get_layout_engine()
    if engine is not None:
        engine.execute(figure)
    points = _fit_all(panels, boxes)
    for panel in panels:
        panel.set_aspect("equal", adjustable="box")
    side.draw(panels[0], points[0])
    if len(panels) > 1:
        draw_end_view(panels[1], side.train, side.shades, points[1])


def _fit_all(panels: Sequence[Axes], boxes: Sequence[Box]) -> list[float]:
    return [_fit(panel, box) for panel, box in zip(panels, boxes, strict=False)]


def _fit(panel: Axes, box: Box) -> float:
    """Set limits with equal scales around a box, and give the length of a point of the page [m]."""
    size = panel.get_window_extent()
    scale = 72.0 / figure_of(panel).dpi
    pixels = np.array([size.width, size.height])
    # Very small panels keep a third of their size for the parts.
    available = np.maximum(pixels * scale - 2.0 * _MARGIN, pixels * scale / 3.0)
    point = float(np.max(np.array([box[2] - box[0], box[3] - box[1]]) / available))
    half = 0.5 * point * pixels * scale
    panel.set_xlim(0.5 * (box[0] + box[2]) - half[0], 0.5 * (box[0] + box[2]) + half[0])
    panel.set_ylim(0.5 * (box[1] + box[3]) - half[1], 0.5 * (box[1] + box[3]) + half[1])
    panel.locator_params(nbins=6)
    return point
