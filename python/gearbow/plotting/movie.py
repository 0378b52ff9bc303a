"""Files of animations: GIF, and HTML that needs no other file."""

import base64
import json
from collections.abc import Sequence
from html import escape
from io import BytesIO
from typing import BinaryIO

import numpy as np
from PIL import Image

__all__ = ["write_gif", "write_html"]

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
