"""Data of a run, and what it recorded."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from gearbow._convert import array, number, shown, text
from gearbow._read_only import ReadOnly, read_only
from gearbow._types import Array, Record, RunData
from gearbow.description.speed import SpeedProfile
from gearbow.errors import ChannelError, SceneError
from gearbow.recording.record import RunRecord, Statistics

if TYPE_CHECKING:
    from gearbow.description.kinematics import Kinematics
    from gearbow.recording.errors import Errors
    from gearbow.recording.request import RunRequest

__all__ = ["RecordedRun"]


class RecordedRun(ReadOnly):
    """Data of a run at k times.

    Parameters
    ----------
    data : mapping
        Recorded arrays, events, final state and statistics.
    speed : float or SpeedProfile
        Speed of the reference shaft [rad/s].

    Attributes
    ----------
    time : ndarray, shape (k,)
        Times [s].
    speed : float or SpeedProfile
        Speed of the reference shaft [rad/s].
    statistics : Statistics
        Counts and step lengths of the simulation.
    accuracy : str or None
        What an accuracy level promises for the run; None without a level.
    kinematics : Kinematics or None
        Speed ratios and tooth frequencies, which determine the orders.
    request : RunRequest or None
        Scene and options of the run; None if unknown.
    """

    def __init__(self, data: RunData, speed: float | SpeedProfile) -> None:
        if not isinstance(data, Mapping):
            raise SceneError(
                f"data: must be the data of a run, got {shown(data)}; simulate and load make "
                "responses"
            )
        if not isinstance(speed, SpeedProfile):
            speed = number(speed, "speed")
        self._data = read_only(data)
        self.time = data["time"]
        self.speed = speed
        self.statistics = Statistics(**data["statistics"])
        self.accuracy: str | None = None
        self.kinematics: Kinematics | None = None
        self.request: RunRequest | None = None
        self._errors: Errors | None = None

    def to_record(self) -> RunRecord:
        """Give the recording as plain data.

        Returns
        -------
        RunRecord
            All data that a file contains.
        """
        return RunRecord(
            self._data, self.speed, self.kinematics, self.accuracy, self.request, self._errors
        )

    @property
    def speeds(self) -> Array:
        """Speed of the reference shaft at the recorded times.

        Returns
        -------
        ndarray, shape (k,)
            Speeds [rad/s].
        """
        if isinstance(self.speed, SpeedProfile):
            return self.speed(self.time)
        return np.full(self.time.shape, self.speed)

    def angle(self, shaft: str, times: ArrayLike | None = None) -> Array:
        """Prescribed angle of a shaft, without its twist.

        Parameters
        ----------
        shaft : str
            Name of the shaft.
        times : array_like, shape (n,), optional
            Times [s]; None is the k recorded times.

        Returns
        -------
        ndarray, shape (k,) or (n,)
            Angle about x, not reduced to one revolution [rad].

        Raises
        ------
        ChannelError
            If there is no such shaft, or the response has no kinematics.
        """
        known, high, low = self._data["final"]["anchor"]
        t = self.time if times is None else array(times, "times", least=0)
        turned: Array
        if isinstance(self.speed, SpeedProfile):
            turned = self.speed.angle(t) - self.speed.angle(known)
        else:
            turned = self.speed * (t - known)
        angle: Array = self._ratio(shaft) * (high + (low + turned))
        return angle

    def spin(self, shaft: str, times: ArrayLike | None = None) -> Array:
        """Prescribed angular velocity of a shaft.

        Parameters
        ----------
        shaft : str
            Name of the shaft.
        times : array_like, shape (n,), optional
            Times [s]; None is the k recorded times.

        Returns
        -------
        ndarray, shape (k,) or (n,)
            Angular velocity about x [rad/s].

        Raises
        ------
        ChannelError
            If there is no such shaft, or the response has no kinematics.
        """
        t = self.time if times is None else array(times, "times", least=0)
        if isinstance(self.speed, SpeedProfile):
            return self._ratio(shaft) * self.speed(t)
        return np.full(t.shape, self._ratio(shaft) * self.speed)

    def _ratio(self, shaft: str) -> float:
        """Find the signed speed ratio of a shaft."""
        if self.kinematics is None:
            raise ChannelError(
                "the angles of the shafts are unknown: the response has no kinematics"
            )
        ratios = dict(self.kinematics.shafts)
        if text(shaft, "shaft") not in ratios:
            raise ChannelError(f"no shaft is called {shaft!r}; there are {', '.join(ratios)}")
        return ratios[shaft]

    @property
    def final(self) -> Mapping[str, Any]:
        """Final state without rounding; `simulate(initial=...)` continues from it.

        Returns
        -------
        mapping
            Method, time, speed, a known angle of the reference shaft (time [s], angle [rad] and
            its rounding error), and the state variables of the method.
        """
        return dict(self._data["final"])

    @property
    def recorded(self) -> list[Record]:
        """Recorded items, in the form of the argument `record` of `simulate`.

        Returns
        -------
        list of str or tuple
            Names of gears and disks, (shaft, position), (driver, driven), ("bearing", shaft,
            position), "velocity", "acceleration", "energy".
        """
        items: list[Record] = []
        for shaft, position, names in self._data["points"]:
            items.extend(names or [(shaft, position)])
        items.extend((driver, driven) for driver, driven in self._data["meshes"])
        items.extend(("bearing", shaft, position) for shaft, position in self._data["bearings"])
        items += [name for name in ("velocity", "acceleration") if name in self._data]
        return [*items, "energy"] if self._data["energy"] is not None else items

    def _axial(self, name: Literal["axial", "axial_bearing_force"]) -> Array:
        found = self._data.get(name)
        if found is None:
            raise ChannelError(
                "the system has no axial motion; helical gears, axial forces and bearings with "
                "axial_stiffness cause it"
            )
        return found

    def _missing(self, what: str, record: Record) -> ChannelError:
        recorded = ", ".join(repr(item) for item in self.recorded) or "nothing"
        return ChannelError(
            f"{what} was not recorded; give record=[{record!r}, ...] to simulate "
            f"(recorded: {recorded})"
        )
