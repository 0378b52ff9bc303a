"""The motion that an animation shows, from a recorded run."""

import math
import os
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from gearbow._convert import number
from gearbow._core import Model
from gearbow._extras import extra
from gearbow._files import check_name, replacing
from gearbow._times import within
from gearbow._types import Array
from gearbow.description.places import place
from gearbow.description.speed import SpeedProfile
from gearbow.description.train import Train
from gearbow.errors import GearbowError, SceneError
from gearbow.recording import access
from gearbow.recording.record import RunRecord

if TYPE_CHECKING:
    from gearbow.plotting.animation import Motion

#: Largest number of frames of an animation.
MOST_FRAMES = 2000


def animate(
    run: RunRecord,
    path: str | os.PathLike[str],
    *,
    mesh: object = None,
    times: tuple[float, float] | None = None,
    magnify: float | None = None,
    duration: float = 6.0,
    fps: float = 15.0,
) -> None:
    """Write an animation of the train in motion, seen along -x."""
    with extra("plot"):
        from gearbow.plotting import animation  # noqa: PLC0415

    path, ending = check_name(path, [".gif", ".html"])
    length, rate = _positive(duration, "duration"), _positive(fps, "fps")
    if rate > 50.0:
        raise SceneError(f"fps: must be at most 50, got {rate:g}")
    count = max(2, round(length * rate))
    if count > MOST_FRAMES:
        raise SceneError(
            f"duration: {length:g} s with {rate:g} frames per second are {count} frames, at most "
            f"{MOST_FRAMES} are possible; give a shorter duration"
        )
    factor = None if magnify is None else _positive(magnify, "magnify")
    motion = _motion(run, mesh, _span(run, times), count, length)
    drawn = list(animation.frames(motion, factor))
    with replacing(path) as file:
        if ending == ".gif":
            animation.write_gif(drawn, file, fps=rate)
        else:
            animation.write_html(drawn, file, fps=rate, title="gearbow: train in motion")


def _positive(value: object, path: str) -> float:
    found = number(value, path)
    if not found > 0.0:
        raise SceneError(f"{path}: must be positive, got {found:g}")
    return found


def _motion(
    run: RunRecord,
    mesh: object,
    span: tuple[float, float],
    count: int,
    length: float,
) -> "Motion":
    """Collect the motion of all recorded gears and disks at the times of the frames."""
    from gearbow.plotting import animation  # noqa: PLC0415

    if run.request is None:
        raise GearbowError(
            "animate: this response does not know its system; take a response that simulate "
            "returned or that save wrote"
        )
    description = run.request.description
    train = Train.of(description, Model(dict(description)).speed_ratios)
    time = np.linspace(*span, count)
    bodies = {body.name for body in train.layout.bodies if body.radius > 0.0}
    recorded = [name for _, _, names in run.data["points"] for name in names]
    named = [name for name in recorded if name in bodies]
    if not named:
        raise GearbowError(
            "no gear or disk was recorded; give record=['gears', 'meshes'] to simulate"
        )
    shown_mesh, curves = _mesh(run, mesh, named, span, time)
    angle = _angle(run, time)
    centres = {name: _at(run, access.motion(run, "displacement", name), time) for name in named}
    return animation.Motion(
        train=train,
        time=time,
        speed=_speed(run, time),
        angles={name: ratio * angle for name, ratio in train.ratios.items()},
        centres={name: values - values.mean(axis=0) for name, values in centres.items()},
        twists={name: _at(run, access.motion(run, "twist", name), time) for name in named},
        mesh=shown_mesh,
        curves=curves,
        slow=length / (span[1] - span[0]),
    )


def _mesh(
    run: RunRecord,
    mesh: object,
    named: Sequence[str],
    span: tuple[float, float],
    time: Array,
) -> tuple[Any, dict[str, tuple[Array, Array]]]:
    """Collect the geometry of the mesh, and the curves beside the view."""
    from gearbow.plotting import animation  # noqa: PLC0415

    inside = (run.time >= span[0]) & (run.time <= span[1])
    times = run.time[inside]
    if mesh is None:
        recorded = ((driver, driven) for driver, driven in run.data["meshes"])
        mesh = next((pair for pair in recorded if set(pair) <= set(named)), None)
    if mesh is None:
        motion = 1e6 * access.motion(run, "displacement", named[0])[inside]
        curves = {f"{named[0]} {axis} [µm]": (times, motion[:, i]) for i, axis in enumerate("yz")}
        return None, curves
    pair = access.mesh_names(run, place(mesh, "mesh", "mesh"))
    found = access.mesh(run, pair)
    for name in pair:
        if name not in named:
            raise GearbowError(f"mesh: the motion of {name!r} was not recorded; record 'gears'")
    angles = (found.pressure_angle, found.centre_line_angle)
    curves = {
        "contact ratio": (times, found.contact_ratio[inside]),
        "pressure angle [°]": (times, np.degrees(found.pressure_angle[inside])),
    }
    return animation.MeshMotion(*pair, *(_at(run, angle, time) for angle in angles)), curves


def _span(run: RunRecord, times: tuple[float, float] | None) -> tuple[float, float]:
    """Find the first and the last time of the animation."""
    if run.time.size < 2:
        raise GearbowError("an animation needs at least two recorded times")
    first, last = float(run.time[0]), float(run.time[-1])
    if times is None:
        ratios = () if run.kinematics is None else run.kinematics.shafts
        slowest = min((abs(ratio) for _, ratio in ratios), default=1.0)
        speed = abs(float(_speed(run, run.time[-1:])[0]))
        turn = 2.0 * math.pi / (slowest * speed) if slowest * speed > 0.0 else math.inf
        return max(first, last - turn), last
    return within(run.time, times)


def _at(run: RunRecord, values: Array, time: Array) -> Array:
    """Interpolate recorded values linearly."""
    columns = values.reshape(values.shape[0], -1).T
    found = np.column_stack([np.interp(time, run.time, column) for column in columns])
    return found if values.ndim > 1 else found[:, 0]


def _speed(run: RunRecord, time: Array) -> Array:
    """Give the speed of the reference shaft [rad/s]."""
    if isinstance(run.speed, SpeedProfile):
        return run.speed(time)
    return np.full(time.shape, run.speed)


def _angle(run: RunRecord, time: Array) -> Array:
    """Give the angle of the reference shaft [rad]; of a changing speed, since the first time."""
    if not isinstance(run.speed, SpeedProfile):
        return run.speed * time
    grid = np.linspace(run.time[0], time[-1], max(2000, 4 * run.time.size))
    speed = run.speed(grid)
    steps = 0.5 * (speed[1:] + speed[:-1]) * np.diff(grid)
    angle: Array = np.interp(time, grid, np.concatenate([[0.0], np.cumsum(steps)]))
    return angle
