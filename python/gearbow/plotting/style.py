"""Style of all figures: colours, settings, panels, legends and smooth curves."""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any, TypeAlias

import matplotlib as mpl
import numpy as np
from cycler import cycler
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.text import Text
from matplotlib.ticker import FuncFormatter, LogFormatterMathtext
from matplotlib.transforms import BboxBase
from numpy.typing import ArrayLike

from gearbow._convert import shown
from gearbow._core import whirl_classes
from gearbow._types import Array
from gearbow.errors import GearbowError
from gearbow.units.speed import shown_unit, speed_factor

#: Micrometres per metre.
MICRO = 1e6

#: Colours for colour-blind readers: Okabe and Ito, *Color universal design* (2008).
PALETTE = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")

#: Colour, line style and marker of each whirl. They differ without colour too.
_STYLES: dict[str, tuple[str, Any, str]] = {
    "forward": (PALETTE[0], "-", "^"),
    "backward": (PALETTE[1], "--", "v"),
    "mixed": (PALETTE[6], (0, (4, 2)), "X"),
    "planar": (PALETTE[5], "-", "s"),
    "torsion": (PALETTE[2], "-.", "o"),
    "axial": (PALETTE[4], (0, (5, 1, 1, 1, 1, 1)), "P"),
    "coupled": (PALETTE[3], ":", "D"),
    "rigid": (PALETTE[6], "-", "."),
}
#: The same for every whirl that the core knows; a class without style is an error of the import.
MARKS = {name: _STYLES[name] for name in whirl_classes()}
#: Colour of the operating speeds.
OPERATING = "0.88"
#: Largest range of a logarithmic axis with a label at 2 and 5 of each decade, and with a label at
#: every tick.
_LABELLED_RANGE, _SHORT_RANGE = 1e3, 5.0
#: Size of an orbit with its own scale, and of one that is round-off, relative to the largest.
_OWN_SCALE, ROUND_OFF = 0.1, 1e-6

#: Panels of a user: one, or several in any nesting; None makes a new figure.
GivenAxes: TypeAlias = Any

#: Settings of every figure. The font is legible at half size.
STYLE: dict[Any, Any] = {
    "axes.axisbelow": True,
    "axes.formatter.limits": (-4, 5),
    "axes.grid": True,
    "axes.prop_cycle": cycler(color=PALETTE),
    "axes.spines.right": False,
    "axes.spines.top": False,
    "figure.constrained_layout.use": True,
    "font.size": 14.0,
    "grid.alpha": 0.3,
    "legend.frameon": False,
    "lines.linewidth": 1.6,
    "savefig.dpi": 150,
}

#: Prefixes of units by their exponent of ten.
_PREFIXES = {-9: "n", -6: "µ", -3: "m", 0: "", 3: "k", 6: "M", 9: "G"}


@contextmanager
def panels(
    count: int,
    height: float,
    *,
    columns: int = 1,
    width: float = 12.0,
    sharex: bool = False,
    ax: GivenAxes = None,
    x: str | None = None,
    legend: bool | str = True,
) -> Iterator[tuple[Figure, list[Axes]]]:
    """Make a figure with rows of panels, or take the panels of the user, and finish it."""
    # At the end the panels get the label of their horizontal axis, and the figure a legend of all
    # lines with a label; a text is its title.

    def rows_of_panels() -> tuple[Figure, list[Axes]]:
        used = min(columns, count)
        rows = -(-count // used)
        figure = Figure(figsize=(width, height * rows + 0.8))
        grid = figure.subplots(rows, used, squeeze=False, sharex="col" if sharex else False)
        found = list(grid.flat)
        for panel in found[count:]:
            panel.remove()
        return figure, found[:count]

    with drawing(ax, (count,), rows_of_panels) as (figure, found):
        yield figure, found
        if x is not None:
            label_x(found, x)
        if legend:
            entries = legend_entries(found)
            title = legend if isinstance(legend, str) else None
            if entries[0]:
                place_legend(figure, found[0], entries, title=title, ax=ax)
        if ax is None:
            figure.align_ylabels()


@contextmanager
def drawing(
    ax: GivenAxes,
    counts: Sequence[int],
    make: Callable[[], tuple[Figure, list[Axes]]],
    what: str = "",
    settings: Mapping[Any, Any] = STYLE,
) -> Iterator[tuple[Figure, list[Axes]]]:
    """Give the panels of the user and their figure, or new ones with the settings."""
    if ax is not None:
        given = given_axes(ax, counts, what)
        figure = figure_of(given[0])
        with plain_texts(figure):
            yield figure, given
        return
    with mpl.rc_context(dict(settings)):
        figure, made = make()
        with plain_texts(figure):
            yield figure, made


@contextmanager
def plain_texts(figure: Figure) -> Iterator[None]:
    """Write what is added to a figure as it is: the "$" of a name begins no mathematics."""
    before = {text: text.get_text() for text in _texts(figure)}
    yield
    for text in _texts(figure):
        if text.get_text() != before.get(text):
            text.set_parse_math(False)


def _texts(figure: Figure) -> Iterator[Text]:
    """Give the texts of a figure without the numbers at its axes."""
    yield from figure.texts
    legends = [*figure.legends, *(panel.get_legend() for panel in figure.axes)]
    for legend in (each for each in legends if each is not None):
        yield from (legend.get_title(), *legend.get_texts())
    for panel in figure.axes:
        yield from (*panel.texts, panel.title, panel._left_title, panel._right_title)  # type: ignore[attr-defined]
        yield from (axis.label for axis in panel._axis_map.values())


def named_ticks(axis: Axis, places: ArrayLike, names: Sequence[str]) -> None:
    """Write names at an axis, whose texts matplotlib makes again whenever it draws."""
    axis.set_ticks(places, [name.replace("$", r"\$") for name in names])


def named_bars(panel: Axes, names: Sequence[str]) -> None:
    """Write the names of horizontal bars, the first of which is at the top."""
    named_ticks(panel.yaxis, range(len(names)), names)
    panel.invert_yaxis()
    panel.grid(visible=False, axis="y")


def given_axes(ax: GivenAxes, counts: Sequence[int], what: str = "") -> list[Axes]:
    """Check the panels of the user."""
    given = list(np.ravel(np.array(ax, dtype=object)))
    for one in given:
        if not isinstance(one, Axes):
            raise GearbowError(
                f"ax: must be matplotlib Axes or a sequence of them, got {shown(one)}"
            )
    if len(given) not in counts:
        wanted = " or ".join(str(count) for count in counts)
        shows = f" ({what})" if what else ""
        raise GearbowError(
            f"ax: this figure has {wanted} panel{'s' if wanted != '1' else ''}{shows}, "
            f"got {len(given)}; give as many Axes, for example of figure.subplots({counts[-1]})"
        )
    return given


def figure_of(panel: Axes) -> Figure:
    """Give the figure of a panel, also of one in a subfigure."""
    figure: Any = panel.figure
    while not isinstance(figure, Figure):
        figure = figure.figure
    return figure


def equal_ranges(axes: Sequence[Axes]) -> None:
    """Give orbits a common scale: equal lengths of all axes, each about the middle of its data."""
    boxes = [panel.dataLim for panel in axes]
    sizes = [max(box.width, box.height) for box in boxes]
    largest = max(sizes)
    for panel, box, size in zip(axes, boxes, sizes, strict=True):
        own = ROUND_OFF * largest < size < _OWN_SCALE * largest
        half = 0.54 * (size if own else largest)
        if math.isfinite(half) and half > 0.0:
            x, y = (box.x0 + box.x1) / 2.0, (box.y0 + box.y1) / 2.0
            panel.set(xlim=(x - half, x + half), ylim=(y - half, y + half))
        panel.set_aspect("equal", adjustable="box")
        panel.locator_params(nbins=4)
        if own:
            panel.ticklabel_format(useOffset=False)
            place: dict[str, Any] = {"ha": "left", "va": "top", "fontsize": text_size(0.79)}
            panel.text(0.03, 0.98, "own scale", transform=panel.transAxes, **place)


def common_round_off(axes: Sequence[Axes]) -> None:
    """Show values that are round-off on the scale of the largest values of all panels."""
    ends = [np.abs(panel.dataLim.intervaly) for panel in axes]
    largest = max((float(end.max()) for end in ends if np.isfinite(end).all()), default=0.0)
    for panel, end in zip(axes, ends, strict=True):
        if end.max() < ROUND_OFF * largest:
            panel.set_ylim(-largest, largest)


def log_scale(panel: Axes) -> None:
    """Make the vertical axis logarithmic, with plain numbers that do not touch each other."""
    panel.set_yscale("log")
    axis = panel.yaxis
    usual = LogFormatterMathtext()
    usual.set_axis(axis)

    def label(value: float, _: int | None = None) -> str:
        low, high = sorted(axis.get_view_interval())
        if value <= 0.0 or low <= 0.0:
            return ""
        digit = value / 10.0 ** math.floor(math.log10(value) + 1e-9)
        kept = any(math.isclose(digit, one, rel_tol=1e-6) for one in (1.0, 2.0, 5.0))
        if high < _SHORT_RANGE * low or (high < _LABELLED_RANGE * low and kept):
            if 1e-4 <= value < 1e6:
                return f"{value:g}"
            # 2 × 10⁻⁵, where the usual label is 10^-4.70.
            power = round(math.log10(value / digit))
            number = "" if math.isclose(digit, 1.0, rel_tol=1e-6) else f"{digit:g}\\times "
            return f"$\\mathdefault{{{number}10^{{{power}}}}}$"
        return usual(value) if math.isclose(digit, 1.0, rel_tol=1e-6) else ""

    axis.set_major_formatter(FuncFormatter(label))
    axis.set_minor_formatter(FuncFormatter(label))


def label_x(axes: Sequence[Axes], label: str) -> None:
    """Label the horizontal axis of every panel that is not above one with the same axis."""
    for number, panel in enumerate(axes):
        shared = panel.get_shared_x_axes()
        if not any(shared.joined(panel, below) for below in axes[number + 1 :]):
            panel.set_xlabel(label)


def legend_entries(axes: Sequence[Axes]) -> tuple[list[Any], list[str]]:
    """Give the handles and labels of all panels, each label once."""
    found: dict[str, Any] = {}
    for panel in axes:
        for handle, label in zip(*panel.get_legend_handles_labels(), strict=True):
            found.setdefault(label, handle)
    return list(found.values()), list(found)


def place_legend(
    figure: Figure,
    panel: Axes,
    entries: tuple[Sequence[Any], Sequence[str]],
    *,
    title: str | None = None,
    ax: GivenAxes = None,
    outside: bool = False,
) -> None:
    """Place one legend above the panels, or inside the first given panel."""
    if ax is not None:
        place: dict[str, Any] = {"loc": "best"}
        if outside:
            place = {"loc": "lower center", "bbox_to_anchor": (0.5, 1.0), "borderaxespad": 2.5}
        panel.legend(*entries, title=title, fontsize="small", ncols=3 if outside else 1, **place)
        return
    # An inch of the legend holds about eight letters; a handle takes the space of nine.
    widths = [len(label) + 9 for label in entries[1]]
    for rows in range(1, len(widths) + 1):
        wide = [max(widths[first : first + rows]) for first in range(0, len(widths), rows)]
        if sum(wide) <= 8.0 * figure.get_figwidth():
            break
    columns = len(wide) if widths else 1
    figure.legend(*entries, loc="outside upper center", ncols=columns, title=title)


def speed_axis() -> tuple[float, str]:
    """Give the factor and the label of an axis of speeds."""
    return speed_factor(), f"speed of the reference shaft [{shown_unit()}]"


def shade_operating(panel: Axes, speeds: Sequence[float] | Array) -> None:
    """Shade the operating speeds; a single one is a line."""
    if speeds[0] == speeds[1]:
        panel.axvline(speeds[0], color=OPERATING, linewidth=6.0, zorder=0.5)
    else:
        panel.axvspan(*speeds, color=OPERATING, linewidth=0.0, zorder=0.5)


def quantity(value: float, unit: str, digits: int = 4) -> str:
    """Write a value with the prefix of its magnitude, such as "1.25 mm" or "−24.5 kN m"."""
    # Rounding first: 999.96 µm is 1 mm.
    rounded = float(f"{value:.{digits - 1}e}")
    if not math.isfinite(rounded) or rounded == 0.0:
        return f"{rounded:g} {unit}".replace("-", "−")
    # A value of one to three digits before the point has the prefix of its thousands.
    exponent = 3 * math.floor(math.floor(math.log10(abs(rounded))) / 3)
    exponent = min(max(exponent, min(_PREFIXES)), 0 if unit == "m" else max(_PREFIXES))
    number = f"{rounded / 10.0**exponent:.{digits}g}"
    return f"{number} {_PREFIXES[exponent]}{unit}".replace("-", "−")


def remark(panel: Axes, *sentences: str) -> None:
    """Add sentences in small letters to the right title of a panel."""
    said = [text for text in (panel.get_title(loc="right"), *sentences) if text]
    if said:
        panel.set_title("; ".join(said), loc="right", fontsize=text_size(0.86))


def text_size(part: float) -> float:
    """Give the size of a text within a panel."""
    return part * float(mpl.rcParams["font.size"])


def text_extent(panel: Axes, text: str, **style: Any) -> BboxBase:
    """Measure a text."""
    trial = panel.text(0.0, 0.0, text, parse_math=False, **style)
    extent: BboxBase = trial.get_window_extent()
    trial.remove()
    return extent


def round_factor(exact: float) -> float:
    """Round a factor down to 1, 2 or 5 times a power of ten."""
    power = 10.0 ** math.floor(math.log10(exact))
    # 10**n and the quotient have round-off.
    return max(n for n in (1.0, 2.0, 5.0) if n * power <= exact * (1.0 + 1e-9)) * power


def colour(number: int) -> str:
    """Give the colour of a line by its number."""
    return PALETTE[number % len(PALETTE)]


#: Number of parts of the interval between two points.
_PARTS = 16
#: Points closer than this part of the whole range count as one.
_SAME = 1e-9


def smooth(x: Array, y: Array) -> tuple[Array, Array]:
    """Draw a monotone cubic through points, so that a curve has no corners and no overshoot."""
    order = np.argsort(x, kind="stable")
    x, y = x[order], y[order]
    distinct = np.diff(x, prepend=-np.inf) > _SAME * np.ptp(x) if x.size else np.empty(0, bool)
    x, y = x[distinct], y[distinct]
    if x.size < 3:
        return x, y
    step = np.diff(x)
    secant = np.diff(y) / step
    slope = np.concatenate([secant[:1], np.zeros(x.size - 2), secant[-1:]])
    left, right = secant[:-1], secant[1:]
    rising = left * right > 0.0
    weights = 2.0 * step[1:] + step[:-1], step[1:] + 2.0 * step[:-1]
    means = (weights[0] + weights[1])[rising] / (
        weights[0][rising] / left[rising] + weights[1][rising] / right[rising]
    )
    slope[1:-1][rising] = means
    part = np.arange(_PARTS) / _PARTS
    low, high = 1.0 - part, part
    # Cubic Hermite polynomial of each interval, shape (intervals, parts).
    values = (
        np.outer(y[:-1], low**2 * (1.0 + 2.0 * high))
        + np.outer(y[1:], high**2 * (1.0 + 2.0 * low))
        + np.outer(step * slope[:-1], low**2 * high)
        - np.outer(step * slope[1:], high**2 * low)
    )
    places = x[:-1, np.newaxis] + np.outer(step, part)
    return np.append(places.ravel(), x[-1]), np.append(values.ravel(), y[-1])
