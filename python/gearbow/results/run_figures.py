"""Figures of a recorded run."""

import math
from typing import TYPE_CHECKING, Any, get_args

import numpy as np

from gearbow._extras import extra
from gearbow._lookup import one_of
from gearbow._times import begin_after, window
from gearbow._types import Abscissa, Array, At, RunFigure, Window
from gearbow.description.places import place_label, places
from gearbow.description.speed import SpeedProfile
from gearbow.errors import GearbowError, SceneError
from gearbow.orders.spectrum import amplitudes, default_window, order_frequencies
from gearbow.recording import access
from gearbow.recording.record import RunRecord

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: Quantities of the figures of meshes.
_MESH_FIELDS = {
    "mesh": ("force", "deflection", "stiffness"),
    "geometry": ("contact_ratio", "pressure_angle", "centre_line_angle", "centre_distance"),
}
#: Kinds of figures of `Response.plot`.
PLOT_KINDS: tuple[RunFigure, ...] = get_args(RunFigure)
#: Kinds of figures whose horizontal axis is not time.
_WITHOUT_TIME = ("orbits", "spectrum")


def plot(
    run: RunRecord,
    kind: RunFigure,
    at: Any,
    *,
    times: tuple[float, float] | None,
    skip_time: float | None,
    against: Abscissa,
    speed_unit: str,
    ax: Any,
) -> "Figure":
    """Draw recorded signals."""
    with extra("plot"):
        from gearbow.plotting import response as figures  # noqa: PLC0415

    one_of(kind, PLOT_KINDS, "kind")
    cut = window(run.time, times)
    skipped = _skipped(run, skip_time, cut)
    x, label = _abscissa(run, kind, against, speed_unit)
    time = x[cut]
    settled: Any = {"skipped": skipped, "transient": skip_time is not None, "ax": ax}
    if kind not in _WITHOUT_TIME:
        settled["against"] = label
    if kind in _MESH_FIELDS:
        chosen = {}
        for pair in _connections("mesh", "meshes", run.data["meshes"], at):
            mesh, names = access.mesh(run, pair), access.mesh_names(run, pair)
            chosen[names] = tuple(getattr(mesh, name)[cut] for name in _MESH_FIELDS[kind])
        return getattr(figures, kind)(time, chosen, **settled)  # type: ignore[no-any-return]
    if kind == "bearings":
        bearings = _connections("bearing", "bearings", run.data["bearings"], at)
        forces = {place_label(one): access.bearing_force(run, one)[cut] for one in bearings}
        return figures.bearings(time, forces, **settled)
    places_of = _chosen(run, at)
    if kind == "twist":
        twists = {place_label(one): access.motion(run, "twist", one)[cut] for one in places_of}
        moving = {label: values for label, values in twists.items() if np.any(values)}
        shown = twists if at is not None or not moving else moving
        return figures.twist(time, shown, **settled)
    motion = {place_label(one): access.motion(run, "displacement", one)[cut] for one in places_of}
    if kind == "orbits":
        return figures.orbits(motion, **settled)
    if kind == "history":
        return figures.history(time, motion, **settled)
    begin = 0 if skip_time is None else skipped
    # A part of a period is no period.
    periodic = run.period is not None and time[begin:].size == run.time.size
    kind_of_window: Window = default_window(run) if periodic else "hann"
    spectra = {
        label: amplitudes(time[begin:], values[begin:], kind_of_window)
        for label, values in motion.items()
    }
    return figures.spectrum(spectra, orders=order_frequencies(run), periodic=periodic, ax=ax)


def _abscissa(run: RunRecord, kind: str, against: str, speed_unit: str) -> tuple[Array, str]:
    """Give the values and the label of the horizontal axis."""
    from gearbow.plotting.style import speed_axis  # noqa: PLC0415  # with the extra "plot"

    one_of(against, get_args(Abscissa), "against")
    factor, speed = speed_axis(speed_unit)
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
