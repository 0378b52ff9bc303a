"""Figures of spectra, orders and waterfalls."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from numpy.typing import NDArray

from gearbow._types import Array
from gearbow.plotting.style import (
    PALETTE,
    GivenAxes,
    colour,
    figure_of,
    log_scale,
    named_bars,
    panels,
    quantity,
    remark,
    speed_axis,
    text_size,
)

#: Smallest amplitude that spectra, their ranges of frequencies and waterfalls show, relative to the
#: largest one: 60 dB below it is less than the noise of most measurements.
_SHOWN = 1e-3
#: Number of letters of the name of a bar from which its gears have a line each: a third of the
#: width of a figure.
_LONG = 32
#: Smallest amplitude of a waterfall that the order lines do not cover, relative to the largest, and
#: number of points of such a line.
_STRONG, _POINTS = 1e-2, 600
#: A peak is larger than this multiple of the median of the spectrum around it.
_PEAK = 3.0
#: Smallest ratio of the largest to the smallest bar of a logarithmic scale, and smallest bar of it
#: relative to the largest.
_LOGARITHMIC, _SMALLEST = 30.0, 1e-5
#: Marker and colour of each family of orders.
FAMILIES: dict[str, tuple[str, str]] = {
    "shaft": ("o", PALETTE[1]),
    "mesh": ("^", PALETTE[2]),
    "sideband": ("d", "#A64D86"),
    "bearing": ("s", "#B37400"),
}


def family(name: str) -> str:
    """Give the family of an order."""
    if "× mesh" in name:
        return "sideband" if " + " in name or " − " in name else "mesh"
    return "bearing" if "× ball pass " in name or "× cage " in name else "shaft"


def spectrum(
    frequencies_hz: Array,
    amplitudes: Array,
    label: str,
    *,
    orders: Sequence[tuple[str, float]] = (),
    periodic: bool = False,
    ax: GivenAxes = None,
) -> Figure:
    """Draw one spectrum; of a period of a motion, its lines."""
    with panels(1, 4.8, ax=ax) as (figure, (panel,)):
        log_scale(panel)
        highest = spectrum_limits(panel, frequencies_hz, amplitudes, periodic=periodic)
        curve = (frequencies_hz, amplitudes)
        if periodic:
            curve = spectral_lines(panel, frequencies_hz, amplitudes)
        panel.plot(*curve, color=PALETTE[0], linewidth=1.8 if periodic else 1.2)
        if highest > 0.0:
            panel.set_xlim(0.0, highest)
        panel.set(xlabel="frequency [Hz]", ylabel=label)
        name_orders(panel, frequencies_hz, amplitudes, orders, periodic=periodic)
        say_resolution(panel, frequencies_hz, orders, periodic=periodic)
    return figure


def spectral_lines(panel: Axes, frequencies_hz: Array, amplitudes: Array) -> tuple[Array, Array]:
    """Give the curve of upright lines from the bottom of a panel to each visible amplitude."""
    bottom = panel.get_ylim()[0]
    seen = amplitudes > bottom
    x = np.repeat(frequencies_hz[seen], 3)
    y = np.column_stack([0.0 * amplitudes[seen] + bottom, amplitudes[seen], amplitudes[seen]])
    # A gap after each line.
    y[:, 2] = np.nan
    return x, y.ravel()


def spectrum_limits(
    panel: Axes, frequencies_hz: Array, amplitudes: Array, *, periodic: bool = False
) -> float:
    """Limit the amplitudes of a panel to those above round-off, and find the last frequency."""
    top = float(amplitudes.max(initial=0.0))
    if not top > 0.0:
        return 0.0
    largest = amplitudes.reshape(len(amplitudes), -1).max(axis=1)
    highest = _highest(frequencies_hz, largest, _SHOWN)
    # The floor between the lines says nothing: most of it stays below the panel.
    floor = 0.0 if periodic else 0.3 * float(np.median(largest[frequencies_hz <= highest]))
    panel.set_ylim(min(max(_SHOWN * top, floor), 0.1 * top), 2.0 * top)
    return highest


def name_orders(
    panel: Axes,
    frequencies_hz: Array,
    amplitudes: Array,
    orders: Sequence[tuple[str, float]],
    *,
    most: int = 12,
    sidebands: bool = True,
    periodic: bool = False,
) -> None:
    """Mark the peaks of a spectrum at orders of the train, and name the largest."""
    distinct = _distinct(frequencies_hz, orders, periodic)
    found = _peaks(panel, frequencies_hz, amplitudes, distinct, periodic=periodic)
    if not found:
        return
    for kind, (marker, shade) in FAMILIES.items():
        own = [(x, y) for name, x, y in found if family(name) == kind]
        if own:
            style: dict[str, Any] = {"marker": marker, "color": shade, "ls": "none", "ms": 6.0}
            panel.plot(*np.transpose(own), label=f"{kind} order", **style)
    size = text_size(0.79)
    figure, place = figure_of(panel), panel.get_position()
    height = place.height * figure.get_figheight()
    left, right = panel.get_xlim()
    # The height of a line of text as a length of the axis of frequencies.
    point = (right - left) / (72.0 * place.width * figure.get_figwidth())
    line = 1.3 * size * point
    named: list[tuple[str, float, float]] = []

    short = zip(_short([name for name, _, _ in found]), found, strict=True)
    for whole, (_, x, _) in sorted(short, key=lambda pair: -pair[1][2]):
        # The gears of a mesh stand in a second line, or in two further ones.
        name = re.sub(r"× mesh (?![−+])", "× mesh\n", whole)
        if _length(name) >= 0.45 * height:
            name = name.replace("–", "–\n")
        wanted = (sidebands or family(name) != "sideband") and _length(name) < 0.45 * height
        free = all(
            abs(x - at) > line * (_lines_of(name) + _lines_of(other)) / 2.0
            for other, at, _ in named
        )
        if wanted and free and len(named) < most:
            # A name stands above the markers beside its peak, and within the panel.
            above = max(v for _, u, v in found if abs(u - x) < 0.7 * line * _lines_of(name))
            named.append((name, x, above))
            panel.annotate(
                name,
                (x, above),
                xytext=(max(0.0, 0.75 * size - (x - left) / point), 7),
                textcoords="offset points",
                rotation=90,
                ha="center",
                va="bottom",
                fontsize=size,
                color=FAMILIES[family(name)][1],
            )
    _raise_limit(panel, [(name, y) for name, _, y in named], height)


def _resolution(frequencies_hz: Array, periodic: bool) -> float:
    """Give the distance at which two tones have separate peaks or, of a period, lines [Hz]."""
    lines = 1.0 if periodic else 2.0
    return lines * float(frequencies_hz[1] - frequencies_hz[0]) if frequencies_hz.size > 1 else 0.0


def _distinct(
    frequencies_hz: Array, orders: Sequence[tuple[str, float]], periodic: bool
) -> list[tuple[str, float]]:
    """Give the orders that the spectrum separates from all others, or all but their sidebands."""
    # Round-off of a distance of exactly the resolution must not hide an order.
    nearest = (1.0 - 1e-6) * _resolution(frequencies_hz, periodic)
    ascending = sorted(orders, key=lambda order: order[1])
    gaps = np.diff([frequency for _, frequency in ascending])
    ends = [0, *(np.flatnonzero(gaps >= nearest) + 1).tolist(), len(ascending)]
    found = []
    for first, last in pairwise(ends):
        group = ascending[first:last]
        main = [order for order in group if family(order[0]) != "sideband"]
        if len(group) == 1:
            found += group
        elif len(main) == 1:
            name, frequency = main[0]
            found.append((f"{name} ± sidebands", frequency))
    return found


def say_resolution(
    panel: Axes,
    frequencies_hz: Array,
    orders: Sequence[tuple[str, float]],
    *,
    periodic: bool = False,
) -> None:
    """Say in the title below which distance orders have no name, if there are such orders."""
    visible = [order for order in orders if order[1] <= panel.get_xlim()[1]]
    if len(_distinct(frequencies_hz, visible, periodic)) < len(visible):
        distance = quantity(_resolution(frequencies_hz, periodic), "Hz", 3)
        remark(panel, f"orders closer than {distance} have no name of their own")


def _short(names: Sequence[str]) -> list[str]:
    """Leave out the gears in the names of orders if there is one mesh only."""
    # The name of a mesh ends before that of a sideband or before the frequency.
    meshes = {
        re.split(r" [+−±(]", name.split("× mesh ")[1])[0] for name in names if "× mesh " in name
    }
    if len(meshes) != 1:
        return list(names)
    (only,) = meshes
    return [name.replace(f"× mesh {only}", "× mesh") for name in names]


def _length(name: str) -> float:
    """Estimate the length of a name beside a peak [in]."""
    return 0.0077 * text_size(0.79) * max(map(len, name.split("\n"))) + 0.15


def _lines_of(name: str) -> int:
    return name.count("\n") + 1


def _raise_limit(panel: Axes, named: Sequence[tuple[str, float]], height: float) -> None:
    """Raise the upper limit of a logarithmic panel, so that the names above the peaks fit in."""
    low, high = panel.get_ylim()
    share = 1.0
    for name, y in named:
        part = np.log(y / low) / np.log(high / low)
        share = min(share, max(0.4, (1.0 - _length(name) / height) / max(part, 0.1)))
    # No signal is above the old limit: ticks there would suggest one.
    ticks = [tick for tick in panel.get_yticks() if low <= tick <= high]
    panel.set_ylim(low, low * (high / low) ** (1.0 / share))
    if len(ticks) > 1:
        panel.set_yticks(ticks)
        panel.set_yticks([], minor=True)


def _peaks(
    panel: Axes,
    frequencies_hz: Array,
    amplitudes: Array,
    orders: Sequence[tuple[str, float]],
    *,
    periodic: bool,
) -> list[tuple[str, float, float]]:
    """Find the orders at which the spectrum has a visible peak: name, frequency and amplitude."""
    if frequencies_hz.size < 3 or not orders:
        return []
    step = float(frequencies_hz[1] - frequencies_hz[0])
    low, right = panel.get_ylim()[0], panel.get_xlim()[1]
    found: dict[int, tuple[str, float, float]] = {}
    for name, frequency in orders:
        # A tone of a period is on its line, beside which there may be larger ones.
        reach = 0.01 if periodic else 1.01
        near = np.flatnonzero(np.abs(frequencies_hz - frequency) <= reach * step)
        if near.size == 0 or frequency > right:
            continue
        peak = int(near[np.argmax(amplitudes[near])])
        if periodic:
            if amplitudes[peak] > low:
                found.setdefault(peak, (name, frequency, float(amplitudes[peak])))
            continue
        around = amplitudes[max(0, peak - 12) : peak + 13]
        inside = 0 < peak < amplitudes.size - 1
        if inside and amplitudes[peak] < max(amplitudes[peak - 1], amplitudes[peak + 1]):
            continue
        if amplitudes[peak] > max(low, _PEAK * float(np.median(around))):
            found.setdefault(peak, (name, float(frequencies_hz[peak]), float(amplitudes[peak])))
    return list(found.values())


def orders(
    names: Sequence[str],
    amplitudes: Array,
    label: str,
    *,
    title: str = "",
    ax: GivenAxes = None,
) -> Figure:
    """Draw orders as bars."""
    top = float(amplitudes.max(initial=0.0))
    low = max(float(amplitudes.min(initial=top)), _SMALLEST * top)
    logarithmic = top > _LOGARITHMIC * low > 0.0
    shades = [FAMILIES[family(name)][1] for name in names]
    names = [each.replace("–", "–\n") if len(each) > _LONG else each for each in _short(names)]
    row = 0.45 if max(map(_lines_of, names), default=1) == 1 else 0.6
    with panels(1, 1.2 + row * len(names), ax=ax) as (figure, (panel,)):
        begin = 0.5 * low if logarithmic else 0.0
        # The value of a bar that is too short to be seen stands at the edge of the panel.
        lengths = np.maximum(amplitudes, begin)
        bars = panel.barh(range(len(names)), lengths, color=shades, log=logarithmic)
        panel.bar_label(bars, [_three_digits(value) for value in amplitudes], padding=4)
        named_bars(panel, names)
        panel.set(xlabel=label)
        panel.set_title(title, loc="right", fontsize=text_size(0.86))
        if logarithmic:
            panel.set_xlim(begin, top * (top / begin) ** 0.15)
        elif top > 0.0:
            panel.set_xlim(0.0, 1.15 * top)
    return figure


def tracks(
    x: Array,
    amplitudes: Mapping[str, Array],
    label: str,
    *,
    title: str,
    over_time: bool,
    ax: GivenAxes = None,
) -> Figure:
    """Draw the amplitude of each order against the speed, or against time."""
    factor, name = (1.0, "time [s]") if over_time else speed_axis()
    with panels(1, 5.2, ax=ax) as (figure, (panel,)):
        shown = _short(list(amplitudes))
        for i, (order, values) in enumerate(zip(shown, amplitudes.values(), strict=True)):
            panel.plot(factor * x, values, color=colour(i), label=order)
        panel.set_ylim(bottom=0.0)
        panel.set(xlabel=name, ylabel=label)
        panel.set_title(title, loc="right", fontsize=text_size(0.86))
    return figure


def _three_digits(value: float) -> str:
    """Write a value with three digits; 1260 has no exponent."""
    return f"{value:.0f}" if 1e3 <= value < 1e6 else f"{value:.3g}"


def waterfall(
    speeds: Array,
    frequencies_hz: Array,
    amplitudes: Array,
    label: str,
    *,
    lines: Sequence[tuple[str, float]],
    highest: float | None,
    ax: GivenAxes = None,
) -> Figure:
    """Draw spectra against the speed."""
    factor, speed = speed_axis()
    top = float(amplitudes.max())
    frequencies_hz = np.broadcast_to(frequencies_hz, amplitudes.shape)
    if highest is None:
        highest = _highest(frequencies_hz, amplitudes, _SHOWN)
    with panels(1, 6.0, ax=ax) as (figure, (panel,)):
        speed_map(panel, frequencies_hz, factor * speeds, amplitudes, label, least=_SHOWN * top)
        panel.set(ylabel=speed)
        panel.set_xlim(0.0, highest)
        background = _Background(frequencies_hz, factor * speeds, amplitudes < _STRONG * top)
        _order_lines(panel, background, lines, factor)
    return figure


def speed_map(
    panel: Axes,
    frequencies_hz: Array,
    speeds: Array,
    amplitudes: Array,
    label: str,
    *,
    least: float,
) -> None:
    """Draw amplitudes over frequency and speed as colours on a logarithmic scale."""
    top = float(amplitudes.max())
    # The segments of a run-up have frequencies of their own.
    shape = amplitudes.shape
    drawn = panel.pcolormesh(
        np.broadcast_to(frequencies_hz, shape),
        np.broadcast_to(speeds[:, np.newaxis], shape),
        np.maximum(amplitudes, least),
        norm=LogNorm(least, top) if top > 0.0 else None,
        cmap="cividis",
        shading="nearest",
        rasterized=True,
    )
    figure_of(panel).colorbar(drawn, ax=panel, label=label)
    panel.grid(visible=False)
    panel.set(xlabel="frequency [Hz]")


@dataclass(frozen=True, eq=False)
class _Background:
    """Cells of a waterfall without signal; all arrays but `speeds` are (speeds, frequencies)."""

    frequencies_hz: Array
    speeds: Array
    is_free: NDArray[np.bool_]

    def free(self, frequencies: Array, speeds: Array) -> NDArray[np.bool_]:
        """Tell which points lie on the background."""
        row = _nearest(self.speeds, speeds)
        column = _nearest(self.frequencies_hz[row], frequencies)
        found: NDArray[np.bool_] = self.is_free[row, column]
        return found


def _nearest(ascending: Array, values: Array) -> NDArray[np.intp]:
    """Give the index of the nearest of ascending numbers, of one row for all values or for each."""
    middles = (ascending[..., 1:] + ascending[..., :-1]) / 2.0
    found: NDArray[np.intp] = np.sum(middles < values[:, np.newaxis], axis=-1)
    return found


def _order_lines(
    panel: Axes, background: _Background, lines: Sequence[tuple[str, float]], factor: float
) -> None:
    """Draw the orders over the background, with their names above and inside."""
    highest = panel.get_xlim()[1]
    speeds = np.array(panel.get_ylim())
    along = np.linspace(speeds[0], speeds[1], _POINTS)
    free, taken = highest, -np.inf
    # Names from the highest order down; a name without space is omitted.
    for name, order in reversed(lines):
        at = order * speeds / (2.0 * np.pi * factor)
        path = order * along / (2.0 * np.pi * factor)
        # A line does not cover the signal that it explains.
        path = np.where(background.free(path, along), path, np.nan)
        panel.plot(path, along, color="white", linewidth=0.7, alpha=0.7)
        if at[-1] <= free:
            free = at[-1] - 0.035 * highest
            where, shift, turned = (at[-1], speeds[-1]), (0, 6), 45.0
        elif at[-1] > highest:
            # The order leaves the panel at the right: its name stands inside, on the line.
            where = (0.86 * highest, 0.86 * highest * 2.0 * np.pi * factor / order)
            if where[1] < max(speeds[0], taken + 0.06 * np.ptp(speeds)):
                continue
            taken, shift, turned = where[1], (0, 3), 0.0
        else:
            continue
        panel.annotate(
            name,
            where,
            xytext=shift,
            textcoords="offset points",
            rotation=turned,
            rotation_mode="anchor",
            fontsize=text_size(0.86),
            color="black" if turned else "white",
            ha="left" if turned else "center",
            annotation_clip=False,
        )


def _highest(frequencies: Array, amplitudes: Array, fraction: float) -> float:
    """Give 1.1 times the largest frequency with an amplitude above a fraction of the maximum."""
    visible = frequencies[amplitudes > fraction * amplitudes.max(initial=0.0)]
    end = float(frequencies.max())
    return min(1.1 * float(visible.max()), end) if visible.size else end
