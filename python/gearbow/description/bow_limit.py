"""Limits of a bow that a user adds to those of the teeth, with the values of standards."""

import math
from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass
from typing import Any, get_args

from gearbow._convert import number, positive, text
from gearbow._lookup import one_of
from gearbow._types import At, StrengthLine
from gearbow.description.part import Part
from gearbow.description.places import place
from gearbow.units.speed import PER_MINUTE, speed_factor

#: Peak-to-peak displacement of a shaft relative to its bearing: factor over √n with the speed n
#: [1/min], and the largest value [m]. ISO 20816-3 (before: ISO 7919-3), boundaries of its zones;
#: API 617, √(12000/n) mil and at most 1 mil.
DISPLACEMENTS = {
    "ISO 20816-3 A/B": (4800e-6, math.inf),
    "ISO 20816-3 B/C": (9000e-6, math.inf),
    "ISO 20816-3 C/D": (13200e-6, math.inf),
    "API 617": (25.4e-6 * math.sqrt(12000.0), 25.4e-6),
}


def largest_displacement(standard: str, speed: float) -> float:
    """Give the largest peak-to-peak displacement [m] of a shaft at its speed [rad/s]."""
    factor, largest = DISPLACEMENTS[standard]
    turns = speed_factor(PER_MINUTE) * abs(speed)
    return min(factor / math.sqrt(turns) if turns else math.inf, largest)


#: RMS velocity of a bearing housing [m/s]: ISO 20816-3, boundaries of its zones by group of
#: machines (1: above 300 kW, 2: 15 to 300 kW) and foundation.
VELOCITIES = {
    f"ISO 20816-3 group {group} {foundation} {zone}": 1e-3 * value
    for (group, foundation), values in {
        (1, "rigid"): (2.3, 4.5, 7.1),
        (1, "flexible"): (3.5, 7.1, 11.0),
        (2, "rigid"): (1.4, 2.8, 4.5),
        (2, "flexible"): (2.3, 4.5, 7.1),
    }.items()
    for zone, value in zip(("A/B", "B/C", "C/D"), values, strict=True)
}


@dataclass(frozen=True)
class BowLimit(Part):
    """A limit that `RotorSystem.bow_limits` adds to those of the teeth; made by its constructors.

    Parameters
    ----------
    kind : str
        Name of the constructor.
    at : str or tuple
        Place, bearing or mesh.
    value : float or str
        Limit, or the name of a standard.
    angle : float, optional
        Direction of a displacement or velocity, from y towards z [rad].
    support : str, optional
        What a displacement is measured from.
    capacity : float, optional
        Basic dynamic load rating [N], for "bearing_life"; None is that of the bearing.
    exponent : float, optional
        Exponent of the life, for "bearing_life"; None is that of the bearing.
    tensile_strength : float, optional
        Tensile strength [Pa], for "stress".
    line : {"goodman", "din743"}
        How a mean stress lowers the endured amplitude, for "stress".

    Examples
    --------
    >>> import gearbow as gb
    >>> gb.BowLimit.displacement(("input", 0.1), "API 617").value
    'API 617'
    >>> gb.BowLimit.bearing_life(("input", 0.1), 40e3, capacity=35e3, exponent=3.0).value
    40000.0
    """

    kind: str
    at: Any
    value: float | str
    _: KW_ONLY
    angle: float | None = None
    support: str | None = None
    capacity: float | None = None
    exponent: float | None = None
    tensile_strength: float | None = None
    line: StrengthLine = "goodman"

    @classmethod
    def displacement(
        cls, at: At, limit: float | str, *, angle: float | None = None, support: str | None = None
    ) -> "BowLimit":
        """Limit the peak-to-peak displacement at a probe. The bow itself counts as vibration.

        Parameters
        ----------
        at : str or tuple of (str, float)
            A gear, disk, support, housing or point of a housing by name, or (shaft, position [m]).
        limit : float or str
            Peak-to-peak displacement [m]; or "ISO 20816-3 A/B", "ISO 20816-3 B/C", "ISO 20816-3
            C/D" (4800, 9000 and 13200 µm over √n with the speed n [1/min] of the shaft), or
            "API 617" (25.4 µm √(12000/n), at most 25.4 µm).
        angle : float, optional
            Direction of the probe, from y towards z [rad]; None is the direction with the largest
            displacement.
        support : str, optional
            Support, housing or point of a housing on which the probe stands; None is the ground.
        """
        value = _value(limit, DISPLACEMENTS)
        towards = None if angle is None else number(angle, "angle")
        on = None if support is None else text(support, "support")
        return cls("displacement", place(at, kind="place"), value, angle=towards, support=on)

    @classmethod
    def velocity(cls, at: At, limit: float | str, *, angle: float | None = None) -> "BowLimit":
        """Limit the RMS velocity of a place, usually of a bearing housing.

        Parameters
        ----------
        at : str or tuple of (str, float)
            As for `displacement`.
        limit : float or str
            RMS velocity [m/s], or a boundary of zones such as "ISO 20816-3 group 2 rigid B/C", with
            group 1 or 2, "rigid" or "flexible", and "A/B", "B/C" or "C/D".
        angle : float, optional
            Direction, from y towards z [rad]; None is the one with the largest velocity.
        """
        towards = None if angle is None else number(angle, "angle")
        return cls("velocity", place(at, kind="place"), _value(limit, VELOCITIES), angle=towards)

    @classmethod
    def contact_ratio(cls, at: str | tuple[str, str], least: float) -> "BowLimit":
        """Require a contact ratio above 1.

        Parameters
        ----------
        at : tuple of (str, str) or str
            The mesh: (driver, driven) in either order, or "driver/driven".
        least : float
            Smallest contact ratio at any instant.
        """
        return cls("contact_ratio", place(at, kind="mesh"), positive(least, "least"))

    @classmethod
    def mesh_force(cls, at: str | tuple[str, str], factor: float) -> "BowLimit":
        """Limit the largest mesh force, found from steady states.

        Parameters
        ----------
        at : tuple of (str, str) or str
            The mesh: (driver, driven) in either order, or "driver/driven".
        factor : float
            Largest mesh force of the steady motion over the static one.
        """
        return cls("mesh_force", place(at, kind="mesh"), positive(factor, "factor"))

    @classmethod
    def bearing_force(cls, at: tuple[str, float], force: float) -> "BowLimit":
        """Limit the largest radial force on a bearing.

        Parameters
        ----------
        at : tuple of (str, float)
            Shaft and position of the bearing [m].
        force : float
            Largest force [N].
        """
        return cls("bearing_force", place(at, kind="bearing"), positive(force, "force"))

    @classmethod
    def bearing_life(
        cls,
        at: tuple[str, float],
        hours: float,
        *,
        capacity: float | None = None,
        exponent: float | None = None,
    ) -> "BowLimit":
        """Require a basic rating life of a rolling bearing (ISO 281), as `bearing_life` finds it.

        The life is (C/P)^p million turns; P is the mean of the equivalent load over the time with
        the exponent p, from the radial force of each instant and the thrust of the equilibrium. A
        bearing between shafts counts relative turns.

        Parameters
        ----------
        at : tuple of (str, float)
            Shaft and position of the bearing [m].
        hours : float
            Smallest life L₁₀ [h].
        capacity : float, optional
            Basic dynamic load rating C [N]; None is that of the bearing.
        exponent : float, optional
            Exponent p; None is that of the bearing, 3 for balls and 10/3 for rollers.
        """
        return cls(
            "bearing_life",
            place(at, kind="bearing"),
            positive(hours, "hours"),
            capacity=None if capacity is None else positive(capacity, "capacity"),
            exponent=None if exponent is None else positive(exponent, "exponent"),
        )

    @classmethod
    def stress(
        cls,
        at: At,
        endurance_limit: float,
        *,
        tensile_strength: float,
        line: StrengthLine = "goodman",
    ) -> "BowLimit":
        """Limit the utilisation of a section of a shaft to 1, as `RotorSystem.stresses` finds it.

        Notches are those of the system.

        Parameters
        ----------
        at : str or tuple of (str, float)
            A gear or disk by name, or (shaft, position [m]).
        endurance_limit : float
            Stress amplitude that a smooth specimen of the size of the shaft endures [Pa].
        tensile_strength : float
            Tensile strength of the material [Pa].
        line : {"goodman", "din743"}
            How a mean stress lowers the endured amplitude.
        """
        return cls(
            "stress",
            place(at, kind="place"),
            positive(endurance_limit, "endurance_limit"),
            tensile_strength=positive(tensile_strength, "tensile_strength"),
            line=one_of(line, get_args(StrengthLine), "line"),  # type: ignore[arg-type]
        )

    @classmethod
    def film(cls, at: tuple[str, float], thickness: float) -> "BowLimit":
        """Require an oil film of a journal bearing, found from steady states.

        Parameters
        ----------
        at : tuple of (str, float)
            Shaft and position of the journal bearing [m].
        thickness : float
            Smallest film thickness at any instant [m].
        """
        return cls("film", place(at, kind="bearing"), positive(thickness, "thickness"))

    @classmethod
    def clearance(cls, at: tuple[str, float], approach: float) -> "BowLimit":
        """Limit how far the shaft moves in a rolling bearing: through its clearance, and beyond.

        The limit follows from the linear motion. A run with the contacts of the elements may reach
        it at a smaller bow.

        Parameters
        ----------
        at : tuple of (str, float)
            Shaft and position of the rolling bearing [m].
        approach : float
            Largest elastic approach of the rings [m]: the displacement of the shaft relative to
            what the bearing stands on, less the radial gap, which is half of the clearance.
        """
        return cls("clearance", place(at, kind="bearing"), positive(approach, "approach"))


def _value(limit: Any, standards: Mapping[str, Any]) -> float | str:
    """Check a positive number or the name of a standard."""
    if isinstance(limit, str):
        return one_of(limit, standards, "limit")
    return positive(limit, "limit")
