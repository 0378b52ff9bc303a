"""Interactive figures of plotly with the content of figures of matplotlib.

A converted figure has the same panels, lines, areas and texts at the same places. Lines keep the
vertices that are visible at a fivefold magnification.
"""

import math
from collections.abc import Iterable
from html import escape
from io import BytesIO
from typing import Any, BinaryIO

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.legend import Legend
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.path import Path
from matplotlib.text import Text
from matplotlib.transforms import Affine2D, Transform

from gearbow._types import Array
from gearbow.plotting.shapes import Path as Line, Surface

#: Width of a figure that is as wide as a page [px], and of matplotlib [in].
WIDTH, _PAGE = 960.0, 12.0
#: Number of colours of an image of pixels: curves with soft edges, and shaded surfaces.
_COLOURS = 64
#: Resolution of an image as SVG [1/in].
_POINTS = 72.0
#: Length of the longest axis in three dimensions, in the unit of the distance of the camera.
_LONGEST = 1.8
#: Magnification at which a simplified line looks like the complete one: of the image with 72 points
#: per inch, which the page shows with 80.
_MAGNIFIED = 5.6
#: Steps of a range to which values are rounded, a power of two, so that a file with them compresses
#: well: the labels of points have five digits.
_STEPS = 2.0**17
#: Line styles and markers of plotly by those of matplotlib.
_DASHES = {"--": "dash", "-.": "dashdot", ":": "dot", "dashed": "dash", "dotted": "dot"}
_SYMBOLS = {
    "o": "circle",
    ".": "circle",
    "^": "triangle-up",
    "v": "triangle-down",
    "s": "square",
    "D": "diamond",
    "X": "x",
    "P": "cross",
}
#: Decades of a logarithmic axis below which it has labels between them.
_FEW_DECADES = 2.0
#: Scales that plotly has; on others the values are transformed.
_SCALES = {"linear": "linear", "log": "log"}


def converted(
    figure: Figure, image: BinaryIO | None = None, resolution: float | None = None
) -> dict[str, Any]:
    """Convert a figure for plotly, and write its image as SVG, or as PNG of a resolution [1/in]."""
    # One drawing gives the layout, the ticks and the image.
    drawing = BytesIO() if image is None else image
    if resolution is None:
        figure.set_dpi(_POINTS)
        FigureCanvasSVG(figure).print_svg(drawing)  # type: ignore[no-untyped-call]
        FigureCanvasAgg(figure)
    else:
        write_png(figure, drawing, resolution)
        figure.set_dpi(_POINTS)
    return _Converter(figure).result()


def write_png(figure: Figure, image: BinaryIO, resolution: float) -> None:
    """Write a figure as PNG with few colours, and draw it once, where `savefig` draws it twice."""
    from PIL import Image  # noqa: PLC0415  # matplotlib needs it

    figure.set_dpi(resolution)
    canvas: Any = FigureCanvasAgg(figure)
    canvas.draw()
    drawn = Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("RGB")
    drawn.quantize(_COLOURS).save(image, "PNG")


def scene(parts: Iterable[Surface | Line], title: str) -> dict[str, Any]:
    """Make a figure of a mode in three dimensions, which the mouse turns."""
    drawn = list(parts)
    data = [_in_space(part) for part in drawn]
    corners = np.concatenate(
        [part.points if isinstance(part, Line) else part.points.reshape(3, -1).T for part in drawn]
    )
    margin = 0.02 * np.ptp(corners, axis=0).max()
    low, high = corners.min(axis=0) - margin, corners.max(axis=0) + margin
    # Equal scales, at which the longest axis fills the view of the camera.
    aspect = _LONGEST * (high - low) / (high - low).max()
    axes = {
        f"{axis}axis": {"title": {"text": f"{axis} [m]"}, "range": ends, "nticks": 5}
        for axis, ends in zip("xyz", np.column_stack([low, high]).tolist(), strict=True)
    }
    ratio = dict(zip("xyz", aspect.tolist(), strict=True))
    camera = {"eye": {"x": 0.7, "y": -1.5, "z": 0.7}}
    heading = {"text": _markup(title), "font": {"size": 15}, "x": 0.5}
    layout = {"width": WIDTH, "height": round(0.62 * WIDTH), "title": heading}
    layout |= {"margin": {"l": 0, "r": 0, "t": 60, "b": 0}, "legend": {"x": 0.01, "y": 0.98}}
    return {
        "data": data,
        "layout": {
            **layout,
            "scene": {"aspectmode": "manual", "aspectratio": ratio, "camera": camera, **axes},
        },
    }


def _in_space(part: Surface | Line) -> dict[str, Any]:
    """Convert a surface or a line in three dimensions."""
    # A micrometre is invisible.
    points = np.round(part.points, 6)
    if isinstance(part, Line):
        style = {"color": _css(part.colour), "width": 2.0 * part.width}
        mark = {"color": _css(part.colour), "size": 0.6 * part.marker_size, "symbol": "square"}
        mode = "+".join(["lines"] * bool(part.width) + ["markers"] * bool(part.marker))
        shown = points if len(points) else np.full((1, 3), None)
        trace: dict[str, Any] = {"type": "scatter3d", "mode": mode, "line": style, "marker": mark}
        trace |= {"name": _markup(part.label or ""), "showlegend": part.label is not None}
        return {**trace, "hoverinfo": "skip", **dict(zip("xyz", shown.T, strict=True))}
    if points.shape[1] == 1:  # a disk: triangles about its first corner
        corners = dict(zip("xyz", points[:, 0], strict=True))
        other = np.arange(1, points.shape[2] - 1)
        triangles = {"i": 0 * other, "j": other, "k": other + 1}
        style = {"type": "mesh3d", "color": _css(part.colour), "opacity": part.opacity}
        return {**style, "hoverinfo": "skip", **corners, **triangles}
    shade = {"colorscale": [[0.0, part.colour], [1.0, part.colour]], "showscale": False}
    style = {"type": "surface", "opacity": part.opacity, "hoverinfo": "skip", **shade}
    return {**style, **dict(zip("xyz", points, strict=True))}


class _Converter:
    """Collects traces and layout of one figure."""

    def __init__(self, figure: Figure) -> None:
        self.figure = figure
        width, height = figure.get_size_inches()
        # A narrow figure keeps the size of its letters.
        self.width = WIDTH * min(1.0, float(width) / _PAGE)
        #: Pixels of plotly per point of matplotlib.
        self.scale = self.width / (72.0 * float(width))
        self.data: list[dict[str, Any]] = []
        self.shapes: list[dict[str, Any]] = []
        self.texts: list[dict[str, Any]] = []
        self.layout: dict[str, Any] = {
            "width": round(self.width),
            "height": round(self.width * float(height / width)),
            "shapes": self.shapes,
            "annotations": self.texts,
            "margin": dict.fromkeys("lrtb", 0),
            "hovermode": "closest",
            "plot_bgcolor": "white",
            "paper_bgcolor": "white",
            "font": {"family": "DejaVu Sans, Verdana, sans-serif", "color": "black"},
        }

    def result(self) -> dict[str, Any]:
        """Convert panels, legends and texts."""
        legends = [*self.figure.legends]
        legends += [own for panel in self.figure.axes if (own := panel.get_legend()) is not None]
        named = {text.get_text() for legend in legends for text in legend.get_texts()}
        for number, panel in enumerate(self.figure.axes):
            self._panel(panel, number, named)
        for number, legend in enumerate(legends):
            self._legend(legend, "legend" if number == 0 else f"legend{number + 1}")
        for text in self.figure.texts:
            self._text(text)
        return {"data": self.data, "layout": self.layout}

    def _panel(self, panel: Axes, number: int, named: set[str]) -> None:
        end = "" if number == 0 else str(number + 1)
        box = panel.get_position()
        for axis, low, high, other in (("x", box.x0, box.x1, "y"), ("y", box.y0, box.y1, "x")):
            self.layout[f"{axis}axis{end}"] = {
                **self._axis(panel, axis),
                "domain": [low, high],
                "anchor": f"{other}{end}",
            }
        before = self.figure.axes[:number]
        shared = panel.get_shared_x_axes()
        first = next((i for i, each in enumerate(before) if shared.joined(panel, each)), None)
        if first is not None:
            self.layout[f"xaxis{end}"]["matches"] = "x" if first == 0 else f"x{first + 1}"
        if panel.get_aspect() == 1.0:
            self.layout[f"yaxis{end}"] |= {"scaleanchor": f"x{end}", "scaleratio": 1.0}
        artists: list[Line2D | Patch] = [*panel.patches, *panel.lines]
        for artist in sorted(artists, key=lambda artist: artist.get_zorder()):
            if artist.get_visible():
                self._artist(panel, artist, end, named)
        for text in (*panel.texts, panel.title, panel._left_title, panel._right_title):  # type: ignore[attr-defined]
            self._text(text, panel, end)

    def _axis(self, panel: Axes, name: str) -> dict[str, Any]:
        """Give scale, range, title and ticks of an axis."""
        axis: Any = getattr(panel, f"{name}axis")
        scale = str(axis.get_scale())
        ends = np.array(axis.get_view_interval(), dtype=np.float64)
        # Space for one tick label: about an inch along a horizontal axis, half an inch along a
        # vertical axis.
        ticks = int(np.clip((2.0 if name == "y" else 1.0) * self._length(panel, name), 3, 8))
        # A title of plotly does not keep clear of powers of ten: the label is a text.
        self._text(axis.label)
        found: dict[str, Any] = {
            "type": _SCALES.get(scale, "linear"),
            "range": (np.log10(ends) if scale == "log" else _forward(axis)(ends)).tolist(),
            "tickfont": {"size": self.scale * self._tick_size(axis)},
            "gridcolor": "#e3e3e3",
            "linecolor": "black",
            "showline": True,
            "zeroline": False,
            "ticks": "outside",
            "showgrid": bool(panel.xaxis.get_gridlines()[0].get_visible()),
            "exponentformat": "power",
            "minexponent": 5,
            "nticks": ticks,
            "tickangle": 0,
            "showticklabels": any(text.get_text() for text in axis.get_ticklabels())
            and bool(
                axis.get_tick_params(which="major").get(
                    f"label{'bottom' if name == 'x' else 'left'}", True
                )
            ),
        }
        if scale == "log":
            decades = float(np.ptp(found["range"]))
            found["dtick"] = math.ceil(decades / (2.0 * self._length(panel, name)))
            if decades < _FEW_DECADES:
                found["dtick"] = "D2"
            if ends.min() > 1e-4 and ends.max() < 1e6:
                found["tickformat"] = "~g"
        if scale not in _SCALES:
            ticks = axis.get_major_locator()()
            texts = axis.get_major_formatter().format_ticks(ticks)
            found |= {"tickvals": _forward(axis)(ticks).tolist(), "ticktext": list(texts)}
        return found

    @staticmethod
    def _length(panel: Axes, name: str) -> float:
        """Give the length of an axis [in]."""
        return float(getattr(panel.bbox, "width" if name == "x" else "height")) / panel.figure.dpi

    @staticmethod
    def _tick_size(axis: Any) -> float:
        return next((float(text.get_fontsize()) for text in axis.get_ticklabels()), 10.0)

    def _font(self, text: Text) -> dict[str, Any]:
        return {"size": self.scale * float(text.get_fontsize()), "color": _css(text.get_color())}

    def _artist(self, panel: Axes, artist: Line2D | Patch, end: str, named: set[str]) -> None:
        transform: Transform = artist.get_transform()
        along, upright = transform.contains_branch_seperately(panel.transData)
        axes = {"xref": f"x{end}", "yref": f"y{end}"}
        if along != upright:  # a span, or a line across the panel
            self._span(panel, artist, axes, along)
            return
        label = str(artist.get_label())
        trace: dict[str, Any] = {"type": "scatter", "xaxis": f"x{end}", "yaxis": f"y{end}"}
        trace |= {"showlegend": False, "hoverinfo": "skip"}
        if label in named:
            trace["legendgroup"] = label
        if isinstance(artist, Patch):
            polygons = artist.get_path().transformed(transform).to_polygons(closed_only=False)
            for corners in map(np.asarray, polygons):
                area = self._area(artist)
                if not np.array_equal(corners[0], corners[-1]):  # the shaft of an arrow
                    area["fillcolor"] = _css("none")
                values = self._values(panel, _data(panel, corners))
                own = {**trace, "mode": "lines", "fill": "toself", **area}
                self._add(own | dict(zip("xy", values, strict=True)))
            return
        points = _visible(artist)
        style = self._line(artist)
        x, y = self._values(panel, points)
        names = [] if label.startswith("_") else [_markup(label)]
        texts = [_markup(getattr(panel, f"{axis}axis").label.get_text()) or axis for axis in "xy"]
        true = "%{customdata:.5g}" if "customdata" in self._true(panel, points) else "%{y:.5g}"
        names += [f"{texts[0]}: %{{x:.5g}}", f"{texts[1]}: {true}"]
        hover = "<br>".join(names) + "<extra></extra>"
        trace |= {"x": x, "y": y, **style, **self._true(panel, points), "hovertemplate": hover}
        trace.pop("hoverinfo")
        if not panel.xaxis.get_gridlines()[0].get_visible() and not names[:-2]:
            trace.pop("hovertemplate")
            trace["hoverinfo"] = "skip"
        self.data.append(trace)

    def _add(self, trace: dict[str, Any]) -> None:
        """Add an area to the previous one if both look alike."""
        last = self.data[-1] if self.data else {}
        if last.get("fill") and all(last[key] == trace[key] for key in trace if key not in "xy"):
            for axis in "xy":
                last[axis] = np.concatenate([last[axis], [np.nan], trace[axis]])
        else:
            self.data.append(trace)

    def _values(self, panel: Axes, points: Array) -> tuple[Array, Array]:
        """Give the values of points on the axes of plotly."""
        found = []
        for values, axis in zip(points.T, (panel.xaxis, panel.yaxis), strict=True):
            placed = values if axis.get_scale() in _SCALES else _forward(axis)(values)
            found.append(_five_digits(placed) if axis.get_scale() == "log" else _rounded(placed))
        return found[0], found[1]

    def _true(self, panel: Axes, points: Array) -> dict[str, Any]:
        """Give the true values on a scale that plotly lacks."""
        return {} if panel.yaxis.get_scale() in _SCALES else {"customdata": points[:, 1]}

    def _line(self, line: Line2D) -> dict[str, Any]:
        """Give mode and style of a line."""
        drawn, mark = str(line.get_linestyle()), str(line.get_marker())
        modes = [] if drawn in ("None", "none", " ", "") else ["lines"]
        modes += [] if mark in ("None", "none", "", " ") else ["markers"]
        return {
            "mode": "+".join(modes) or "none",
            "line": {
                "color": _css(line.get_color(), line.get_alpha()),
                "width": self.scale * float(line.get_linewidth()),
                "dash": _DASHES.get(drawn, "solid"),
            },
            "marker": {
                "symbol": _SYMBOLS.get(mark, "circle"),
                "size": self.scale * float(line.get_markersize()) * (0.5 if mark == "." else 1.0),
                "color": _css(line.get_markerfacecolor()),
                "line": {"color": _css(line.get_markeredgecolor()), "width": self.scale},
            },
        }

    def _area(self, patch: Patch) -> dict[str, Any]:
        """Give fill and edge of an area."""
        width = self.scale * float(patch.get_linewidth())
        edge = patch.get_edgecolor()
        return {
            "fillcolor": _css(patch.get_facecolor() if patch.get_fill() else "none"),
            "line": {
                "color": _css(edge),
                "width": width if to_rgba(edge)[3] else 0.0,
                "dash": _DASHES.get(str(patch.get_linestyle()), "solid"),
            },
        }

    def _span(self, panel: Axes, artist: Line2D | Patch, axes: dict[str, str], along: bool) -> None:
        """Convert a span of one axis, or a line across the panel."""
        path = artist.get_path()
        points = artist.get_transform().transform(path.vertices)
        ends = np.array([points.min(axis=0), points.max(axis=0)])
        low, high = (dict(zip("xy", point, strict=True)) for point in _data(panel, ends))
        across = "y" if along else "x"
        axes[f"{across}ref"] += " domain"
        low[across], high[across] = 0.0, 1.0
        shape = {**axes, "x0": low["x"], "x1": high["x"], "y0": low["y"], "y1": high["y"]}
        shape["layer"] = "below"
        if isinstance(artist, Line2D):
            width = self.scale * float(artist.get_linewidth())
            line = {"color": _css(artist.get_color()), "width": width}
            line["dash"] = _DASHES.get(str(artist.get_linestyle()), "solid")
            self.shapes.append({"type": "line", **shape, "line": line})
        else:
            self.shapes.append({"type": "rect", **shape, **self._area(artist)})

    def _legend(self, legend: Legend, name: str) -> None:
        """Convert a legend; its entries show and hide the lines with their names."""
        entries = list(zip(legend.legend_handles, legend.get_texts(), strict=True))
        for handle, text in entries:
            trace: dict[str, Any] = {"type": "scatter", "x": [None], "y": [None], "legend": name}
            trace |= {
                "name": _markup(text.get_text()),
                "legendgroup": text.get_text(),
                "showlegend": True,
            }
            if isinstance(handle, Line2D):
                trace |= self._line(handle)
            elif isinstance(handle, Patch):
                area = self._area(handle)
                square = {"symbol": "square", "size": 12, "color": area["fillcolor"]}
                trace |= {"mode": "markers", "marker": {**square, "line": area["line"]}}
            self.data.append(trace)
        size = self.scale * float(entries[0][1].get_fontsize()) if entries else 10.0
        box = legend.get_window_extent().transformed(self.figure.transFigure.inverted())
        title = legend.get_title().get_text()
        wide = box.width > 2.5 * box.height * self.layout["height"] / self.width
        self.layout[name] = {
            "orientation": "h" if wide else "v",
            "font": {"size": size},
            "x": 0.5 * (box.x0 + box.x1),
            "y": 0.5 * (box.y0 + box.y1),
            "xanchor": "center",
            "yanchor": "middle",
            "bgcolor": "rgba(255,255,255,0.6)",
            "title": {"text": _markup(title)},
            "entrywidth": 0,
            "itemsizing": "trace",
        }

    def _text(self, text: Text, panel: Axes | None = None, end: str = "") -> None:
        """Convert a text. One within a panel stays at its data when a reader zooms."""
        if not text.get_text() or not text.get_visible():
            return
        box = text.get_window_extent()
        centre = np.array([[0.5 * (box.x0 + box.x1), 0.5 * (box.y0 + box.y1)]])
        place: dict[str, Any] = {"xref": "paper", "yref": "paper"}
        at = self.figure.transFigure.inverted().transform(centre)[0]
        if panel is not None and panel.bbox.contains(*centre[0]):
            place = {"xref": f"x{end}", "yref": f"y{end}"}
            given = _data(panel, centre)
            at = np.array(self._values(panel, given)).ravel()
            for i, axis in enumerate((panel.xaxis, panel.yaxis)):
                at[i] = np.log10(at[i]) if axis.get_scale() == "log" else at[i]
        paper = text.get_bbox_patch()
        self.texts.append(
            {
                **place,
                "x": float(at[0]),
                "y": float(at[1]),
                "showarrow": False,
                "align": "center",
                "text": _html(text),
                "font": self._font(text),
                "xanchor": "center",
                "yanchor": "middle",
                "textangle": -float(text.get_rotation()),
                "bgcolor": _css("none") if paper is None else "rgba(255,255,255,0.65)",
            }
        )


def _data(panel: Axes, points: Array) -> Array:
    """Convert points of the page [px] to the values of a panel."""
    found: Array = panel.transData.inverted().transform(points)
    return found


def _rounded(values: Array) -> Array:
    """Round values to the steps of their range."""
    known = values[np.isfinite(values)]
    size = float(np.ptp(known)) if known.size else 0.0
    if not size > 0.0:
        return values
    step = 2.0 ** math.floor(math.log2(size / _STEPS))
    rounded: Array = np.round(values / step) * step
    return rounded


def _five_digits(values: Array) -> Array:
    """Round values relative to their size, so that a file with them compresses well."""
    parts, exponents = np.frexp(values)
    rounded: Array = np.ldexp(np.round(parts * _STEPS) / _STEPS, exponents)
    return rounded


def _forward(axis: Any) -> Any:
    """Give the function from values to places on the axis, for a scale that plotly lacks."""
    if axis.get_scale() in _SCALES:
        return lambda values: values
    return axis.get_transform().transform


def _visible(line: Line2D) -> Array:
    """Give the points of a line that are visible at the largest magnification, shape (k, 2)."""
    every = line.get_markevery()
    points = np.array(line.get_xydata(), dtype=np.float64)
    if isinstance(every, int | np.integer):
        return points[:: int(every)]
    path = Path(points)
    if not path.should_simplify:
        return points
    enlarged = line.get_transform() + Affine2D().scale(_MAGNIFIED)
    # `cleaned` knows affine transforms only, but a logarithmic scale is none.
    simple = enlarged.transform_path(path).cleaned(remove_nans=False, simplify=True)
    kept = simple.codes != Path.STOP
    found: Array = enlarged.inverted().transform(np.asarray(simple.vertices)[kept])
    return found


def _markup(text: str) -> str:
    """Write a text for plotly, which reads some HTML and "%{...}" in it."""
    return escape(text, quote=False).replace("%{", "%&#123;").replace("\n", "<br>")


def _html(text: Text) -> str:
    """Write a text of a figure for plotly, with its weight."""
    found = _markup(text.get_text())
    return f"<b>{found}</b>" if text.get_fontweight() == "bold" else found


def _css(colour: Any, alpha: float | None = None) -> str:
    if isinstance(colour, str) and colour == "none":
        return "rgba(0,0,0,0)"
    red, green, blue, opacity = to_rgba(colour, alpha)
    return f"rgba({255 * red:.0f},{255 * green:.0f},{255 * blue:.0f},{opacity:.3g})"
