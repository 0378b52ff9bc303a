"""Access to the recorded quantities of bearings."""

import numpy as np

from gearbow._lookup import locate
from gearbow._types import Array
from gearbow.errors import ChannelError
from gearbow.recording.bearing_motion import BearingMotion, journal_motion
from gearbow.recording.recorded_run import RecordedRun

__all__ = ["BearingRecording"]


class BearingRecording(RecordedRun):
    """Recorded quantities of the bearings of a run."""

    def axial_bearing_force(self, shaft: str, position: float) -> Array:
        """Force of a shaft on a bearing along the axis.

        Parameters
        ----------
        shaft : str
            Name of the shaft.
        position : float
            Position of the bearing [m].

        Returns
        -------
        ndarray, shape (k,)
            Component along x [N].

        Raises
        ------
        ChannelError
            If it was not recorded; the message says what to record. If the system has no axial
            motion.
        """
        bearing = self._bearing(shaft, position)
        return self._axial("axial_bearing_force")[:, bearing]

    def bearing_force(self, shaft: str, position: float) -> Array:
        """Force of a shaft on a bearing.

        Parameters
        ----------
        shaft : str
            Name of the shaft.
        position : float
            Position of the bearing [m].

        Returns
        -------
        ndarray, shape (k, 2)
            Components along y and z [N].

        Raises
        ------
        ChannelError
            If it was not recorded; the message says what to record.
        """
        return self._data["bearing_force"][:, self._bearing(shaft, position)]

    def bearing_displacement(self, shaft: str, position: float) -> Array:
        """Displacement of a shaft relative to what its bearing stands on.

        A proximity probe in the bearing housing measures it.

        Parameters
        ----------
        shaft : str
            Name of the shaft.
        position : float
            Position of the bearing [m].

        Returns
        -------
        ndarray, shape (k, 2)
            Components along y and z [m].

        Raises
        ------
        ChannelError
            If it was not recorded; the message says what to record.
        """
        bearing = self._bearing(shaft, position)
        found = self._data.get("bearing_displacement")
        if found is None:
            raise ChannelError("the file of this run has no displacements at bearings; run again")
        return found[:, bearing]

    def journal(self, shaft: str, position: float) -> BearingMotion:
        """Time history of a journal bearing.

        Parameters
        ----------
        shaft : str
            Name of the shaft.
        position : float
            Position of the bearing [m].

        Returns
        -------
        BearingMotion
            Force, eccentricity ratio and attitude angle.

        Raises
        ------
        ChannelError
            If the bearing was not recorded, or is no journal bearing of a known scene.
        """
        force, displacement = (
            self.bearing_force(shaft, position),
            self.bearing_displacement(shaft, position),
        )
        bearings = () if self.request is None else self.request.description.get("bearings", ())
        return journal_motion(bearings, (shaft, position), displacement, force)

    def rolling(self, shaft: str, position: float) -> BearingMotion:
        """Time history of a rolling bearing.

        Parameters
        ----------
        shaft : str
            Name of the shaft.
        position : float
            Position of the bearing [m].

        Returns
        -------
        BearingMotion
            Force, number of loaded elements and largest contact force.

        Raises
        ------
        ChannelError
            If the bearing was not recorded, or is no rolling bearing.
        """
        force = self.bearing_force(shaft, position)
        places = self._data["rolling_bearings"]
        i = locate(places, shaft, position)
        if i is None:
            raise ChannelError(
                f"no rolling bearing at ({shaft!r}, {position:g}); there are {places}"
            )
        loaded, largest = np.moveaxis(self._data["rolling_contact"][:, i], -1, 0)
        return BearingMotion(force, loaded_elements=loaded, largest_contact_force=largest)

    def _bearing(self, shaft: str, position: float) -> int:
        i = locate(self._data["bearings"], shaft, position)
        if i is None:
            raise self._missing(
                f"the bearing force at ({shaft!r}, {position:g})", ("bearing", shaft, position)
            )
        return i
