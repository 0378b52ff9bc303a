"""The train in motion: frames, and their files."""

import base64
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from html import escape
from io import BytesIO
from typing import Any, BinaryIO

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Circle
from PIL import Image

from gearbow._types import Array
from gearbow.description.layout import BodyOutline
from gearbow.description.train import Train
from gearbow.plotting.style import PALETTE, STYLE, colour, plain_texts, round_factor
from gearbow.plotting.train import circles, end_extent, line_of_action
from gearbow.units.speed import PER_MINUTE, speed_text

#: Size of a frame [in] and its resolution [dot/in].
_SIZE, _DPI = (11.0, 5.0), 80
#: Largest enlarged displacement, relative to the smallest radius.
_LARGEST = 0.35


@dataclass(frozen=True)
class MeshMotion:
    """One mesh at the times of the frames."""

    driver: str
    driven: str
    pressure_angle: Array
    centre_line_angle: Array


@dataclass(frozen=True)
class Motion:
    """Motion of a train at the times of the frames."""

    train: Train
    time: Array
    speed: Array
    angles: Mapping[str, Array]
    centres: Mapping[str, Array]
    twists: Mapping[str, Array]
    mesh: MeshMotion | None
    curves: Mapping[str, tuple[Array, Array]]
    slow: float


def frames(motion: Motion, magnify: float | None) -> Iterator[Image.Image]:
    """Draw all frames."""
    factor = _factor(motion) if magnify is None else magnify
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=_SIZE, dpi=_DPI)
        canvas: Any = FigureCanvasAgg(figure)
        with plain_texts(figure):
            view, marks = _panels(figure, motion)
            moving = [
                _Body(view, motion, body, factor)
                for body in circles(motion.train)
                if body.name in motion.centres
            ]
        line = _Line(view, motion, factor) if motion.mesh is not None else None
        _limits(view, motion, factor)
        title = figure.suptitle("time", fontsize=15.0)
        parts: list[_Body | _Line] = [*moving, *([line] if line is not None else [])]
        artists = [title, *marks, *(artist for part in parts for artist in part.artists)]
        for artist in artists:
            artist.set_animated(True)
        # All frames have one background.
        canvas.draw()
        background = canvas.copy_from_bbox(figure.bbox)
        for n in range(motion.time.size):
            canvas.restore_region(background)
            for part in parts:
                part.show(n)
            for (times, values), mark in zip(motion.curves.values(), marks, strict=True):
                mark.set_data([motion.time[n]], [np.interp(motion.time[n], times, values)])
            title.set_text(_title(motion, n, factor))
            for artist in artists:
                figure.draw_artist(artist)
            yield Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("RGB")


def _title(motion: Motion, n: int, factor: float) -> str:
    return (
        f"t = {motion.time[n]:.4f} s, {speed_text(motion.speed[n], PER_MINUTE, '.0f')}; "
        f"motion and bow × {factor:g}, slowed down {motion.slow:.3g} times"
    )


class _Body:
    """A gear or disk in motion."""

    def __init__(self, view: Axes, motion: Motion, body: BodyOutline, factor: float) -> None:
        names = [shaft.name for shaft in motion.train.layout.shafts]
        shade = colour(names.index(body.shaft))
        rest = motion.train.layout.shaft(body.shaft).origin[1:]
        angle = motion.angles[body.shaft] + motion.twists[body.name]
        self._centre = rest + factor * motion.centres[body.name]
        rim = body.radius * np.column_stack([np.cos(angle), np.sin(angle)])
        self._rim = self._centre + rim
        bow = complex(0.0)
        found = motion.train.bows.get(body.shaft)
        if found is not None:
            bow = complex(np.interp(body.position, found[0], found[1]))
        turned = factor * bow * np.exp(1j * motion.angles[body.shaft])
        self._bow = rest + np.column_stack([turned.real, turned.imag])
        self._rest = rest
        gears = {gear.name for gear in motion.train.parts["gears"]}
        style = "-" if body.name in gears else "--"
        self._circle = Circle((0.0, 0.0), body.radius, ec=shade, fc="none", lw=2.0, ls=style)
        view.add_patch(self._circle)
        view.plot(*self._centre.T, color=shade, linewidth=0.8, alpha=0.5)
        view.plot(*rest, "+", color="0.4", markersize=8.0)
        (self._spoke,) = view.plot([], [], color=shade, linewidth=1.4)
        (self._bowed,) = view.plot([], [], color="black", linewidth=2.2)
        (self._dot,) = view.plot([], [], "o", color=shade, markersize=5.0)
        self._name = view.text(0.0, 0.0, body.name, ha="center", va="bottom", fontsize=12.0)
        self._top = np.array([0.0, body.radius])
        self.artists = [self._circle, self._spoke, self._bowed, self._dot, self._name]

    def show(self, n: int) -> None:
        """Move everything to its place in a frame."""
        centre = self._centre[n]
        self._circle.set_center(tuple(centre))
        self._spoke.set_data(*np.array([centre, self._rim[n]]).T)
        self._bowed.set_data(*np.array([self._rest, self._bow[n]]).T)
        self._dot.set_data(centre[:1], centre[1:])
        self._name.set_position(tuple(centre + self._top))


class _Line:
    """The line of action of a mesh through the pitch point of the drawn centres."""

    def __init__(self, view: Axes, motion: Motion, factor: float) -> None:
        mesh: Any = motion.mesh
        bodies = {body.name: body for body in motion.train.layout.bodies}
        pair = [bodies[name] for name in (mesh.driver, mesh.driven)]
        a, b = (
            motion.train.layout.shaft(body.shaft).origin[1:] + factor * motion.centres[body.name]
            for body in pair
        )
        radii = [body.signed_radius for body in pair]
        pitch = a + (b - a) * radii[0] / sum(radii)
        sense = float(np.sign(motion.train.ratios[pair[0].shaft] * (motion.speed[0] or 1.0)))
        leaning = -mesh.pressure_angle if pair[0].internal else mesh.pressure_angle
        way = line_of_action(leaning, mesh.centre_line_angle, sense)
        reach = 0.9 * min(body.radius for body in pair)
        self._ends = np.stack([pitch - reach * way, pitch + reach * way], axis=1)
        self._middle = pitch
        (self._line,) = view.plot([], [], color=PALETTE[-1], linewidth=1.6, linestyle="--")
        (self._dot,) = view.plot([], [], "o", color="black", markersize=4.0)
        self.artists = [self._line, self._dot]

    def show(self, n: int) -> None:
        """Move the line to its place in a frame."""
        self._line.set_data(*self._ends[n].T)
        self._dot.set_data(self._middle[n, :1], self._middle[n, 1:])


def _panels(figure: Figure, motion: Motion) -> tuple[Axes, Sequence[Any]]:
    """Make the panels, draw the curves, and give the view and the marks on the curves."""
    count = len(motion.curves)
    grid = figure.add_gridspec(count, 2, width_ratios=(1.35, 1.0))
    view = figure.add_subplot(grid[:, 0])
    view.set(xlabel="y [m]", ylabel="z [m]")
    view.set_aspect("equal", adjustable="box")
    view.grid(visible=False)
    view.locator_params(nbins=5)
    marks = []
    for row, (label, (times, values)) in enumerate(motion.curves.items()):
        panel = figure.add_subplot(grid[row, 1])
        panel.plot(times, values, color="0.4", linewidth=1.1)
        panel.set(ylabel=label, xlabel="time [s]" if row == count - 1 else "")
        panel.ticklabel_format(axis="y", useOffset=False)
        panel.locator_params(axis="x", nbins=5)
        marks += panel.plot([], [], "o", color=PALETTE[1], markersize=8.0)
    if motion.mesh is not None:
        view.set_title(f"line of action of {motion.mesh.driver} – {motion.mesh.driven}")
    return view, marks


def _limits(view: Axes, motion: Motion, factor: float) -> None:
    """Set limits that include all parts at all times."""
    left, bottom, right, top = end_extent(motion.train)
    shift = factor * max(float(np.abs(values).max()) for values in motion.centres.values())
    margin = shift + 0.1 * (top - bottom)
    view.set(xlim=(left - margin, right + margin), ylim=(bottom - margin, top + margin))


def _factor(motion: Motion) -> float:
    """Choose a round factor at which the largest displacement is visible."""
    largest = max(float(np.abs(values).max()) for values in motion.centres.values())
    radii = [body.radius for body in circles(motion.train) if body.name in motion.centres]
    return round_factor(_LARGEST * min(radii) / largest) if largest > 0.0 else 1.0


#: Number of colours of a frame: few make the file small.
_COLOURS = 48
#: Colours with larger components are white.
_WHITE = 244

_PAGE = """<!DOCTYPE html>
<html lang="en">
<head><meta charset="utf-8"><title>{title}</title></head>
<body style="font-family: sans-serif; text-align: center">
<p><img id="frame" alt="{title}" style="max-width: 100%"></p>
<p><button id="play">pause</button>
<input id="time" type="range" min="0" max="{last}" value="0" style="width: 60%"></p>
<script>
const frames = {frames};
const image = document.getElementById("frame"), time = document.getElementById("time");
const play = document.getElementById("play");
let running = true;
function show(n) {{ time.value = n; image.src = "data:image/png;base64," + frames[n]; }}
play.onclick = () => {{ running = !running; play.textContent = running ? "pause" : "play"; }};
time.oninput = () => {{ running = false; play.textContent = "play"; show(Number(time.value)); }};
setInterval(() => {{ if (running) show((Number(time.value) + 1) % frames.length); }}, {delay});
show(0);
</script>
</body>
</html>
"""


def write_gif(frames: Sequence[Image.Image], file: BinaryIO, *, fps: float) -> None:
    """Write an animated GIF, which repeats."""
    first, *others = _reduced(frames)
    first.save(
        file,
        format="GIF",
        save_all=True,
        append_images=others,
        duration=round(1000.0 / fps),
        loop=0,
        optimize=True,
    )


def write_html(frames: Sequence[Image.Image], file: BinaryIO, *, fps: float, title: str) -> None:
    """Write a page that contains all frames and shows them, with a button and a slider."""
    encoded = []
    for frame in _reduced(frames):
        data = BytesIO()
        frame.save(data, format="PNG", optimize=True)
        encoded.append(base64.b64encode(data.getvalue()).decode("ascii"))
    page = _PAGE.format(
        title=escape(title),
        last=len(encoded) - 1,
        frames=json.dumps(encoded),
        delay=round(1000.0 / fps),
    )
    file.write(page.encode())


def _reduced(frames: Sequence[Image.Image]) -> list[Image.Image]:
    """Reduce all frames to the colours of one in the middle."""
    middle = frames[len(frames) // 2].convert("RGB")
    few = middle.quantize(_COLOURS, dither=Image.Dither.NONE)
    # The reduction averages similar colours: the background has to stay white.
    shades = np.array(few.getpalette(), dtype=np.uint8).reshape(-1, 3)
    shades[shades.min(axis=1) >= _WHITE] = 255
    palette = Image.new("P", (1, 1))
    palette.putpalette(shades.ravel().tolist())
    return [
        frame.convert("RGB").quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames
    ]
