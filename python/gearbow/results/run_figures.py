"""Figures and animations of a recorded run."""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from gearbow._extras import extra
from gearbow._lookup import one_of
from gearbow._times import begin_after, window
from gearbow._types import At
from gearbow.description.places import is_pair, is_place, place_label, places
from gearbow.description.speed import SpeedProfile
from gearbow.errors import GearbowError, SceneError
from gearbow.orders.spectrum import amplitudes, order_frequencies
from gearbow.results.motion import animate
from gearbow.results.signals import SignalResponse

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["PLOT_KINDS", "RunFigures"]

#: Kinds of figures of `Response.plot`.
#: Quantities of the figures of meshes.
_MESH_FIELDS = {
    "mesh": ("force", "deflection", "stiffness"),
    "geometry": ("contact_ratio", "pressure_angle", "centre_line_angle", "centre_distance"),
}
PLOT_KINDS = ("orbits", "history", "twist", "mesh", "geometry", "bearings", "spectrum")


class RunFigures(SignalResponse):
    """Figures of a run at k times.

    Parameters
    ----------
    data : mapping
        Recorded arrays, events, final state and statistics.
    speed : float or SpeedProfile
        Speed of the reference shaft [rad/s].
    """

    animate = animate

    def plot(
        self,
        kind: str = "orbits",
        names: Any = None,
        *,
        times: tuple[float, float] | None = None,
        skip_time: float | None = None,
        ax: Any = None,
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
        names : str, tuple or sequence of them, optional
            Gears, disks or (shaft, position [m]); pairs (driver, driven) for "mesh" and "geometry";
            (shaft, position [m]) for "bearings". None is all recorded items; of places, the named
            ones if there are any, for "twist" those that twist.
        times : tuple of (float, float), optional
            First and last time of the figure [s]; None is the complete record. A few revolutions
            show what fills the figure of a long run.
        skip_time : float, optional
            Time at the beginning with the transient [s]: orbits and histories show it in grey,
            spectra omit it. The values after it set the scale and the mean; a title gives the range
            of earlier values beyond this scale. None takes the last turn of the slowest shaft for
            the scale, without shading, if the speed is constant; 0 shows all values.
        ax : Axes or sequence of Axes, optional
            One panel for each name, for a bearing two, for a mesh three and for its geometry four;
            None makes a new figure.

        Returns
        -------
        matplotlib.figure.Figure
            The figure. It is neither shown nor saved.

        Raises
        ------
        GearbowError
            If the kind or `ax` is invalid, or no suitable signal was recorded.
        SceneError
            If `skip_time` is negative or longer than the record, or `times` are not in it.
        """
        with extra("plot"):
            from gearbow.plotting import response as figures  # noqa: PLC0415

        one_of(kind, PLOT_KINDS, "kind")
        cut = window(self.time, times)
        skipped = self._skipped(skip_time, cut)
        time = self.time[cut]
        settled: Any = {"skipped": skipped, "transient": skip_time is not None, "ax": ax}
        if kind in _MESH_FIELDS:
            chosen = {
                pair: tuple(getattr(self.mesh(*pair), name)[cut] for name in _MESH_FIELDS[kind])
                for pair in self._pairs(names)
            }
            return getattr(figures, kind)(time, chosen, **settled)  # type: ignore[no-any-return]
        if kind == "bearings":
            bearings = self._bearings(names)
            forces = {place_label(at): self.bearing_force(*at)[cut] for at in bearings}
            return figures.bearings(time, forces, **settled)
        places_of = self._chosen(names)
        if kind == "twist":
            twists = {place_label(at): self.twist(at)[cut] for at in places_of}
            moving = {label: values for label, values in twists.items() if np.any(values)}
            shown = twists if names is not None or not moving else moving
            return figures.twist(time, shown, **settled)
        motion = {place_label(at): self.displacement(at)[cut] for at in places_of}
        if kind == "orbits":
            return figures.orbits(motion, **settled)
        if kind == "history":
            return figures.history(time, motion, **settled)
        begin = 0 if skip_time is None else skipped
        spectra = {
            label: amplitudes(time[begin:], values[begin:]) for label, values in motion.items()
        }
        return figures.spectrum(spectra, orders=order_frequencies(self), ax=ax)

    def _skipped(self, skip_time: float | None, cut: slice) -> int:
        """Count the times within the figure before those that set its scale."""
        time = self.time[cut]
        if time.size == 0:
            return 0
        if skip_time is not None:
            begin = begin_after(self.time, skip_time)
        elif self.kinematics is not None and not isinstance(self.speed, SpeedProfile):
            slowest = min(abs(ratio) for _, ratio in self.kinematics.shafts) * abs(self.speed)
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

    def _chosen(self, names: At | Sequence[At] | None) -> list[At]:
        """Choose the places of a figure."""
        if names is not None:
            return list(places(names, "names"))
        points = self._data["points"]
        named: list[At] = [names[0] for _, _, names in points if names]
        chosen = named or [(shaft, position) for shaft, position, _ in points]
        if not chosen:
            raise GearbowError("no motion was recorded; give record=['gears'] to simulate")
        return chosen

    def _bearings(self, names: Any) -> list[tuple[str, float]]:
        """Choose the bearings of a figure."""
        if names is None:
            found = [(shaft, position) for shaft, position in self._data["bearings"]]
        else:
            found = list(places(names, "names"))
            for i, at in enumerate(found):
                if not is_place(at):
                    raise SceneError(f"names[{i}]: must be (shaft, position), got {at!r}")
        if not found:
            raise GearbowError("no bearing was recorded; give record=['bearings'] to simulate")
        return found

    def _pairs(self, names: Any) -> list[tuple[str, str]]:
        """Choose the meshes of a figure."""
        given: Any = self._data["meshes"] if names is None else names
        pairs: list[tuple[str, str]] = [given] if is_pair(given) else list(given)
        if not pairs:
            raise GearbowError("no mesh was recorded; give record=['meshes'] to simulate")
        return pairs
