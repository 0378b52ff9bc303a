"""Figures and animations of a recorded run."""

import math
import os
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, get_args

import numpy as np

from gearbow._convert import one_of, positive
from gearbow._core import Model
from gearbow._extras import extra
from gearbow._files import check_name, replacing
from gearbow._times import begin_after, window, within
from gearbow._types import Abscissa, Array, At, RunFigure, Window
from gearbow.description.places import place, place_label, places
from gearbow.description.speed import SpeedProfile
from gearbow.description.train import Train
from gearbow.errors import GearbowError, SceneError
from gearbow.orders.spectrum import amplitudes, default_window, order_frequencies
from gearbow.recording import access
from gearbow.recording.record import Recorded, RunRecord
from gearbow.units.speed import SpeedUnit, showing_in

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from gearbow.plotting.analyses import Course
    from gearbow.plotting.animation import Motion


#: Quantities of the figures of meshes.
_MESH_FIELDS = {
    "mesh": ("force", "deflection", "stiffness"),
    "geometry": ("contact_ratio", "pressure_angle", "centre_line_angle", "centre_distance"),
}
#: Kinds of figures of `Response.plot`.
PLOT_KINDS: tuple[RunFigure, ...] = get_args(RunFigure)
#: Kinds of figures whose horizontal axis is not time.
_WITHOUT_TIME = ("orbits", "spectrum", "section forces")


def plot(
    self: Recorded,
    kind: RunFigure = "orbits",
    at: Any = None,
    *,
    times: tuple[float, float] | None = None,
    skip_time: float | None = None,
    against: Abscissa = "time",
    ax: Any = None,
    speed_unit: SpeedUnit | None = None,
) -> "Figure":
    """Draw recorded signals.

    Parameters
    ----------
    kind : str
        - "orbits": orbits of the centres. An orbit below a tenth of the largest has its own
          scale.
        - "history": displacement about its mean against time.
        - "twist": twist against time.
        - "mesh": force, deflection and stiffness of the meshes against time.
        - "geometry": contact ratio, pressure angle, angle of the line of centres and centre
          distance of the meshes against time.
        - "bearings": forces on the bearings against time.
        - "spectrum": amplitude spectrum of the displacement, with the orders of the train.
        - "section forces": smallest and largest axial and shear force, bending moment and torque
          along the shafts.
    at : str, tuple or sequence of them, optional
        Gears, disks or (shaft, position [m]); pairs (driver, driven) for "mesh" and "geometry";
        (shaft, position [m]) for "bearings"; names of shafts for "section forces". None is all
        recorded items; of places, the named ones if there are any, for "twist" those that twist.
    times : tuple of (float, float), optional
        First and last time of the figure [s], such as a few revolutions; None is the whole record.
    skip_time : float, optional
        Duration of the transient at the beginning of the run [s]. Orbits and histories show it in
        grey; spectra omit it. Scale and mean follow from the values after it; if earlier values
        exceed the scale, a title gives their range. With None and a constant speed, the scale
        follows from the last turn of the slowest shaft, and nothing is grey. 0 shows all values.
    against : {"time", "speed", "angle"}
        Horizontal axis of figures against time: time [s], speed of the reference shaft in a
        run at a changing speed, or revolutions of the reference shaft.
    ax : Axes or sequence of Axes, optional
        One panel for each place, for a bearing two, for a mesh three and for its geometry four;
        for section forces four rows with a panel for each shaft; None makes a new figure.
    speed_unit : str, optional
        Unit of the axis of speeds, as for `table`; None is that of the result.

    Returns
    -------
    matplotlib.figure.Figure
        The figure. It is neither shown nor saved.

    Raises
    ------
    GearbowError
        If the kind, `against` or `ax` is invalid, or no suitable signal was recorded.
    """
    run = self._to_record()
    with extra("plot"):
        from gearbow.plotting import response as figures  # noqa: PLC0415

    one_of(kind, PLOT_KINDS, "kind")
    cut = window(run.time, times)
    skipped = _skipped(run, skip_time, cut)
    with showing_in(run.speed_unit if speed_unit is None else speed_unit):
        x, label = _abscissa(run, kind, against)
    time = x[cut]
    axis = figures.TimeAxis(time, label, skipped, transient=skip_time is not None)
    if kind in _MESH_FIELDS:
        chosen = {}
        for pair in _connections("mesh", "meshes", run.data["meshes"], at):
            mesh, names = access.mesh(run, pair), access.mesh_names(run, pair)
            chosen[names] = tuple(getattr(mesh, name)[cut] for name in _MESH_FIELDS[kind])
        return getattr(figures, kind)(axis, chosen, ax=ax)  # type: ignore[no-any-return]
    if kind == "bearings":
        bearings = _connections("bearing", "bearings", run.data["bearings"], at)
        forces = {place_label(one): access.bearing_force(run, one)[cut] for one in bearings}
        return figures.bearings(axis, forces, ax=ax)
    if kind == "section forces":
        from gearbow.plotting.analyses import section_forces  # noqa: PLC0415

        begin = 0 if skip_time is None else skipped
        shafts = run.recorded_shafts if at is None else places(at)
        return section_forces({name: _course(run, name, cut, begin) for name in shafts}, ax=ax)
    places_of = _chosen(run, at)
    if kind == "twist":
        twists = {place_label(one): access.motion(run, "twist", one)[cut] for one in places_of}
        moving = {label: values for label, values in twists.items() if np.any(values)}
        shown = twists if at is not None or not moving else moving
        return figures.twist(axis, shown, ax=ax)
    motion = {place_label(one): access.motion(run, "displacement", one)[cut] for one in places_of}
    if kind == "orbits":
        return figures.orbits(axis, motion, ax=ax)
    if kind == "history":
        return figures.history(axis, motion, ax=ax)
    begin = 0 if skip_time is None else skipped
    # A part of a period is no period.
    periodic = run.period is not None and time[begin:].size == run.time.size
    kind_of_window: Window = default_window(run) if periodic else "hann"
    spectra = {
        label: amplitudes(time[begin:], values[begin:], kind_of_window)
        for label, values in motion.items()
    }
    return figures.spectrum(spectra, orders=order_frequencies(run), periodic=periodic, ax=ax)


def _course(run: RunRecord, shaft: str, cut: slice, begin: int) -> "Course":
    """Give the smallest and largest section forces of a shaft from a time on, and what is on it."""
    from gearbow.plotting.analyses import Course  # noqa: PLC0415  # with the extra "plot"

    sections, forces = access.section_forces(run, shaft)
    bodies = [(x, ", ".join(names)) for name, x, names in run.data["points"] if name == shaft]
    bearings = [(x, "bearing") for name, x in run.data["bearings"] if name == shaft]
    values = forces[cut][begin:]
    positions = np.array([x for _, x, _ in sections])
    marks = [(x, label) for x, label in (*bodies, *bearings) if label]
    return Course(positions, values.min(axis=0), values.max(axis=0), marks)


def _abscissa(run: RunRecord, kind: str, against: str) -> tuple[Array, str]:
    """Give the values and the label of the horizontal axis."""
    from gearbow.plotting.style import speed_axis  # noqa: PLC0415  # with the extra "plot"

    one_of(against, get_args(Abscissa), "against")
    factor, speed = speed_axis()
    if against == "time":
        return run.time, "time [s]"
    if kind in _WITHOUT_TIME:
        raise GearbowError(f"against: the figure {kind!r} has no axis of time, got {against!r}")
    if against == "angle":
        turns = np.abs(access.reference_angle(run)) / (2.0 * np.pi)
        return turns, "angle of the reference shaft [revolutions]"
    if not isinstance(run.speed, SpeedProfile):
        raise GearbowError('against: the speed of this run is constant; give "time" or "angle"')
    return factor * np.abs(access.speeds(run)), speed


def _skipped(run: RunRecord, skip_time: float | None, cut: slice) -> int:
    """Count the times within the figure before those that set its scale."""
    time = run.time[cut]
    if time.size == 0:
        return 0
    if skip_time is not None:
        begin = begin_after(run.time, skip_time)
    elif run.kinematics is not None and not isinstance(run.speed, SpeedProfile):
        slowest = min(abs(ratio) for _, ratio in run.kinematics.shafts) * abs(run.speed)
        begin = time[-1] - (2.0 * math.pi / slowest if slowest > 0.0 else math.inf)
    else:
        return 0
    # Round-off of the times must not exclude the first instant after the transient.
    count = int(np.searchsorted(time, begin - 1e-9 * abs(begin)))
    if count == time.size:
        raise SceneError(
            f"times: {time[0]:g} s to {time[-1]:g} s is within the transient; give later "
            "times, or a smaller skip_time"
        )
    return count


def _chosen(run: RunRecord, given: Any) -> list[At]:
    """Choose the places of a figure."""
    if given is not None:
        return list(places(given))
    points = run.data["points"]
    named: list[At] = [names[0] for _, _, names in points if names]
    chosen = named or [(shaft, position) for shaft, position, _ in points]
    if not chosen:
        raise GearbowError(
            "no motion was recorded; name gears, disks or other places in record=, for example "
            "record=['gears', 'disks']"
        )
    return chosen


def _connections(kind: str, group: str, recorded: Any, given: Any) -> list[tuple[Any, Any]]:
    """Choose the bearings or the meshes of a figure."""
    found = [tuple(each) for each in recorded] if given is None else list(places(given, kind=kind))
    if not found:
        raise GearbowError(f"no {kind} was recorded; give record=['{group}'] to simulate")
    return found


#: Largest number of frames of an animation.
MOST_FRAMES = 2000


def animate(
    self: Recorded,
    path: str | os.PathLike[str],
    *,
    mesh: str | tuple[str, str] | None = None,
    times: tuple[float, float] | None = None,
    magnify: float | None = None,
    duration: float = 6.0,
    fps: float = 15.0,
) -> None:
    """Write an animation of the train in motion, seen along -x.

    Parameters
    ----------
    path : str or path-like
        The file. Its name ends with ".gif" or ".html".
    mesh : (driver, driven) or "driver/driven", optional
        Mesh whose line of action and curves it shows; None is the first recorded one.
    times : tuple of (float, float), optional
        First and last time [s]; None is the last turn of the slowest shaft.
    magnify : float, optional
        Factor that enlarges displacements and twists; None chooses one.
    duration, fps : float
        Duration of the animation [s], and frames per second, at most 50.
    """
    run = self._to_record()
    with extra("plot"):
        from gearbow.plotting import animation  # noqa: PLC0415

    path, ending = check_name(path, [".gif", ".html"])
    length, rate = positive(duration, "duration"), positive(fps, "fps")
    if rate > 50.0:
        raise SceneError(f"fps: must be at most 50, got {rate:g}")
    count = max(2, round(length * rate))
    if count > MOST_FRAMES:
        raise SceneError(
            f"duration: {length:g} s with {rate:g} frames per second are {count} frames, at most "
            f"{MOST_FRAMES} are possible; give a shorter duration"
        )
    factor = None if magnify is None else positive(magnify, "magnify")
    motion = _motion(run, mesh, _span(run, times), count, length)
    drawn = list(animation.frames(motion, factor))
    with replacing(path) as file:
        if ending == ".gif":
            animation.write_gif(drawn, file, fps=rate)
        else:
            animation.write_html(drawn, file, fps=rate, title="gearbow: train in motion")


def _motion(
    run: RunRecord,
    mesh: object,
    span: tuple[float, float],
    count: int,
    length: float,
) -> "Motion":
    """Collect the motion of all recorded gears and disks at the times of the frames."""
    from gearbow.plotting import animation  # noqa: PLC0415

    description = run.asked("animate").description
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
    angle = access.reference_angle(run, time)
    centres = {name: _at(run, access.motion(run, "displacement", name), time) for name in named}
    return animation.Motion(
        train=train,
        time=time,
        speed=access.speeds(run, time),
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
        speed = abs(float(access.speeds(run, run.time[-1:])[0]))
        turn = 2.0 * math.pi / (slowest * speed) if slowest * speed > 0.0 else math.inf
        return max(first, last - turn), last
    return within(run.time, times)


def _at(run: RunRecord, values: Array, time: Array) -> Array:
    """Interpolate recorded values linearly."""
    columns = values.reshape(values.shape[0], -1).T
    found = np.column_stack([np.interp(time, run.time, column) for column in columns])
    return found if values.ndim > 1 else found[:, 0]
