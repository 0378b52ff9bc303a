"""What a run is reduced to: the last turn of its slowest shaft, and a few numbers of it.

With teeth that are all alike, everything repeats after a turn of the slowest shaft: the means are
those of the steady motion, and what differs between the ends of the turn has not settled yet.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from gearbow._types import Array
from gearbow.study.case import Case, system
from gearbow.study.settings import Settings

if TYPE_CHECKING:
    from gearbow.results.response import Response
    from gearbow.system import RotorSystem

__all__ = ["UNITS", "Measured", "measure"]

#: Unit of each quantity.
UNITS = {
    "v": "m",
    "w": "m",
    "radius": "m",
    "contact_ratio": "1",
    "pressure_angle": "rad",
    "centre_distance": "m",
    "centre_line_angle": "rad",
    "line_of_action": "rad",
    "force": "N",
}


@dataclass(frozen=True, eq=False)
class Measured:
    """One turn of the slowest shaft.

    Parameters
    ----------
    turn : ndarray, shape (k,)
        Angle of the slowest shaft over a turn, from 0 to 1.
    signals : dict of {(str, str): ndarray, shape (k,)}
        By gear or mesh ("g1", "g1/g2") and quantity: "v", "w" and "radius", the distance from the
        place at rest without load [m]; of a mesh "contact_ratio", "pressure_angle",
        "centre_distance", "centre_line_angle", "line_of_action" (its angle [rad]) and "force".
    events : tuple of str
        What the meshes did in that turn, as "g1/g2 tip interference".
    """

    turn: Array
    signals: dict[tuple[str, str], Array]
    events: tuple[str, ...]

    def mean(self, of: str, quantity: str) -> float:
        """Mean over the turn.

        Parameters
        ----------
        of, quantity : str
            The signal.

        Returns
        -------
        float
            The mean; the end of the turn, which is its beginning, counts once.
        """
        return float(self.signals[of, quantity][:-1].mean())

    def swing(self, of: str, quantity: str) -> float:
        """Peak to peak over the turn.

        Parameters
        ----------
        of, quantity : str
            The signal.

        Returns
        -------
        float
            Largest less smallest.
        """
        return float(np.ptp(self.signals[of, quantity]))

    def largest(self, of: str, quantity: str) -> float:
        """Largest value in the turn.

        Parameters
        ----------
        of, quantity : str
            The signal.

        Returns
        -------
        float
            The largest.
        """
        return float(self.signals[of, quantity].max())

    def smallest(self, of: str, quantity: str) -> float:
        """Smallest value in the turn.

        Parameters
        ----------
        of, quantity : str
            The signal.

        Returns
        -------
        float
            The smallest.
        """
        return float(self.signals[of, quantity].min())

    def orbit(self, gear: str) -> float:
        """Peak to peak displacement, the larger of v and w.

        Parameters
        ----------
        gear : str
            Name of the gear.

        Returns
        -------
        float
            Displacement [m].
        """
        return max(self.swing(gear, "v"), self.swing(gear, "w"))

    def unsettled(self) -> float:
        """Tell how far the end of the turn is from its beginning.

        Returns
        -------
        float
            The largest difference of v, w and force, over the peak to peak of the signal.
        """
        parts = [
            abs(float(values[-1] - values[0])) / float(np.ptp(values))
            for (_, quantity), values in self.signals.items()
            if quantity in {"v", "w", "force"} and np.ptp(values) > 0.0
        ]
        return max(parts, default=0.0)

    @property
    def sound(self) -> bool:
        """Whether every pair of gears had teeth in contact all the time.

        Returns
        -------
        bool
            True where no contact ratio falls to 1.
        """
        return all(
            values.min() > 1.0
            for (_, quantity), values in self.signals.items()
            if quantity == "contact_ratio"
        )

    def apart(self, other: "Measured", of: str, quantities: tuple[str, ...]) -> float:
        """Tell how far another run is from this one.

        Parameters
        ----------
        other : Measured
            The other run, by whose swing the difference is measured.
        of : str
            Gear or mesh.
        quantities : tuple of str
            Signals that are taken together.

        Returns
        -------
        float
            RMS of the difference over the RMS of the swing about the mean; infinite where the other
            stands still and this one differs.
        """
        mine = np.array([self.signals[of, quantity] for quantity in quantities])
        others = np.array([other.signals[of, quantity] for quantity in quantities])
        swing = others - others.mean(axis=1, keepdims=True)
        difference, scale = (float(np.linalg.norm(each)) for each in (mine - others, swing))
        return difference / scale if scale > 0.0 else (np.inf if difference > 0.0 else 0.0)


def measure(settings: Settings, case: Case) -> Measured:
    """Run a case.

    Parameters
    ----------
    settings : Settings
        The study.
    case : Case
        The case.

    Returns
    -------
    Measured
        What came of it.
    """
    train = system(settings, case)
    slowest = float(np.abs(train.speed_ratios).min())
    turn = 2.0 * np.pi / (case.speed * slowest)
    parts = np.linspace(0.0, 1.0, settings.samples + 1)
    begin = settings.settle * turn
    response = train.simulate(
        begin + turn,
        case.speed,
        # The last time is the end of the run itself, to the last bit.
        times=np.minimum(begin + parts * turn, begin + turn),
        accuracy=case.accuracy,
        geometry=case.geometry,
    )
    events = {
        f"{event.driver}/{event.driven} {event.kind}"
        for event in response.events
        if event.time >= begin
    }
    return Measured(parts, _signals(train, response), tuple(sorted(events)))


def _signals(train: "RotorSystem", response: "Response") -> dict[tuple[str, str], Array]:
    signals: dict[tuple[str, str], Array] = {}
    for gear in train.gears:
        motion = response.displacement(gear.name)
        signals[gear.name, "v"] = motion[:, 0]
        signals[gear.name, "w"] = motion[:, 1]
        signals[gear.name, "radius"] = np.hypot(*motion.T)
    names = [shaft.name for shaft in train.shafts]
    shafts = {gear.name: names.index(gear.shaft) for gear in train.gears}
    for mesh in train.meshes:
        there = response.mesh(mesh.driver, mesh.driven)
        name = f"{mesh.driver}/{mesh.driven}"
        for quantity in (
            "contact_ratio",
            "pressure_angle",
            "centre_distance",
            "centre_line_angle",
            "force",
        ):
            signals[name, quantity] = getattr(there, quantity)
        # The line of action stands a right angle less the pressure angle from the line of centres,
        # on the side to which the driver turns.
        sign = np.sign(train.speed_ratios[shafts[mesh.driver]])
        signals[name, "line_of_action"] = there.centre_line_angle + sign * (
            np.pi / 2.0 - there.pressure_angle
        )
    return signals
