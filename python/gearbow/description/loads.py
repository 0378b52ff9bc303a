"""Bearings and torques."""

from collections.abc import Callable, Mapping
from dataclasses import KW_ONLY, dataclass
from typing import Any

from numpy.typing import ArrayLike

from gearbow._convert import real
from gearbow._types import At, Plain
from gearbow.description.journal import JournalBearing
from gearbow.description.load_values import described_value
from gearbow.description.part import Part
from gearbow.description.places import place
from gearbow.description.rolling import ROLLING_FIELDS, RollingBearing
from gearbow.description.speed_table import SpeedTable
from gearbow.description.supports import Base, with_support
from gearbow.description.time_series import TimeSeries


@dataclass(frozen=True)
class Bearing(Part):
    """A bearing between a shaft and what it stands on, linear in displacement and velocity.

    Parameters
    ----------
    shaft : str
        Name of its shaft.
    position : float
        Position on the shaft, from its left end [m].
    stiffness : float, pair, 2×2 array or SpeedTable
        Stiffness [N/m]: a number for every direction, (yy, zz), or [[yy, yz], [zy, zz]]; or a table
        of one of these against the speed of the shaft, the frequency of the vibration or both;
        between two shafts, against the speed of one relative to the other.
    damping : float, pair, 2×2 array or SpeedTable
        Damping [N s/m], in the same forms.
    axial_stiffness : float
        Stiffness along the axis of the shaft [N/m]. One bearing of a shaft with helical gears needs
        it.
    axial_damping : float
        Damping along the axis of the shaft [N s/m].
    tilting_stiffness : float
        Stiffness against rotations of the shaft about y and z [N m/rad].
    tilting_damping : float
        Damping of these rotations [N m s/rad].
    loss_factor : float
        Loss factor η of the stiffness, K(1 + iη sgn ω): structural damping of modes,
        Campbell diagrams, `frequency_response` and `synchronous`. Runs refuse it.
    support : str, Support or tuple of (str, float), optional
        What it stands on: the name of a support or housing of the system, a support of its own, or
        (shaft, position [m]) of another shaft. None is the ground.

    Examples
    --------
    >>> import gearbow as gb
    >>> bearing = gb.Bearing("input", 0.0, stiffness=(1e8, 2e8), damping=500.0)
    """

    shaft: str
    position: float
    _: KW_ONLY
    stiffness: ArrayLike | SpeedTable
    damping: ArrayLike | SpeedTable = 0.0
    axial_stiffness: float = 0.0
    axial_damping: float = 0.0
    tilting_stiffness: float = 0.0
    tilting_damping: float = 0.0
    loss_factor: float = 0.0
    support: Base | None = None

    @classmethod
    def _from_description(  # type: ignore[override]  # one list holds several classes
        cls, description: Mapping[str, Plain]
    ) -> "Bearing | JournalBearing | RollingBearing":
        if any(name in description for name in ROLLING_FIELDS):
            return RollingBearing._from_description(description)
        if "stiffness" not in description:
            return JournalBearing._from_description(description)
        given = with_support(description)
        for key in ("stiffness", "damping"):
            if isinstance(given.get(key), Mapping):
                given[key] = SpeedTable._from_description(given[key])
        return cls(**given)


@dataclass(frozen=True)
class Torque(Part):
    """A torque on a shaft, positive about +x.

    Parameters
    ----------
    at : str or tuple of (str, float)
        A gear or disk by name, or (shaft, position [m]).
    value : complex, TimeSeries, SpeedTable, callable or "balance"
        The torque [N m]: constant; over time; over the magnitude of the actual speed Ω_s + θ̇ of the
        shaft [rad/s], with the end values beyond the table; or a function of the time [s], which
        `simulate` samples over the run. Static, modal and synchronous analyses do not contain a
        torque over time. A phasor as a source of `frequency_response`. "balance" is explained in
        `Torque.balance`.

    Examples
    --------
    >>> import gearbow as gb
    >>> drive, load = gb.Torque("g1", 250.0), gb.Torque.balance("g4")
    """

    at: At
    value: complex | str | SpeedTable | TimeSeries | Callable[[Any], Any]

    @classmethod
    def balance(cls, at: At) -> "Torque":
        """Apply the torque that balances all other torques on the train.

        Torques over time or speed cannot be balanced; hold the rotation with `gearbow.Drive`.

        Parameters
        ----------
        at : str or tuple of (str, float)
            A gear or disk by name, or (shaft, position [m]).

        Returns
        -------
        Torque
            The torque; the system computes its value.
        """
        return cls(at, "balance")

    def _describe(self, path: str) -> dict[str, Plain]:
        at = place(self.at, f"{path}.at")
        if isinstance(self.value, str) and self.value == "balance":
            return {"at": at, "balance": True}

        def number(value: object, path: str) -> Plain:
            wanted = 'a number [N m], a TimeSeries, a SpeedTable, a function of time or "balance"'
            return real(value, path, wanted)

        return {"at": at, "value": described_value(self.value, f"{path}.value", number)}

    @classmethod
    def _from_description(cls, description: Mapping[str, Plain]) -> "Torque":
        at = description["at"]
        at = at if isinstance(at, str) else (at[0], at[1])
        if description.get("balance"):
            return cls.balance(at)
        value = description["value"]
        if isinstance(value, Mapping):
            kind: type[Part] = SpeedTable if "speeds" in value else TimeSeries
            value = kind._from_description(value)
        return cls(at, value)
