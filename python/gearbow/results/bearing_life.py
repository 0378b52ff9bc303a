"""Rating life of rolling bearings at an equilibrium, or over a load spectrum."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from gearbow._convert import positive
from gearbow._result import ROUND_OFF, Column, Figured, WithSpeeds
from gearbow._shown import ReadOnly, Shown
from gearbow._types import Array
from gearbow.description.journal import JournalBearing, TiltingPadBearing
from gearbow.description.load_rating import (
    LoadRating,
    RatingSource,
    life_hours,
    life_revolutions,
    rating_of,
    reliability_factor,
    ring_ratios,
)
from gearbow.description.loads import Bearing
from gearbow.description.places import Places, place_label
from gearbow.description.rolling import RollingBearing
from gearbow.description.train import parts_of
from gearbow.errors import SceneError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from gearbow.results.static import Static


@dataclass(frozen=True)
class RatedBearing(Shown):
    """Loads and rating life of one bearing.

    Parameters
    ----------
    at : tuple of (str, float)
        Shaft and position [m].
    speed : float
        Speed of the inner ring relative to the outer one [rad/s]; over a spectrum its mean size.
    radial_force, axial_force : float
        Size of the forces [N]; NaN over a spectrum.
    equivalent_load : float
        Equivalent dynamic load P [N]; over a spectrum the constant one with the same life.
    dynamic_rating, static_rating : float
        Basic load ratings C and C₀ [N]; NaN for an unknown static one.
    rating : {"given", "catalogue", "computed"}
        Where the dynamic rating comes from.
    method : {"ISO 281", "ISO/TS 16281"}
        Life from the equivalent load, or from the loads of the rolling elements.
    exponent, revolutions : float
        Exponent p, and basic rating life L₁₀ = (C/P)^p [million turns].
    hours : float
        Basic rating life L₁₀ [h]; infinite if the rings do not turn relative to each other.
    modified_hours : float
        Life [h] times the factor of the reliability and the given factor.
    static_safety : float
        C₀ over the equivalent static load of ISO 76; over a spectrum the smallest one.

    Examples
    --------
    >>> import gearbow as gb
    >>> system = gb.examples()["coaxial_reducer"].load()
    >>> one = system.bearing_life(129.22).bearing(("input", 0.065))
    >>> f"C {one.dynamic_rating / 1e3:.1f} kN, {one.rating}; {one.hours:.0f} h"
    'C 35.1 kN, computed; 3075 h'
    """

    at: tuple[str, float]
    speed: float
    radial_force: float
    axial_force: float
    equivalent_load: float
    dynamic_rating: float
    static_rating: float
    rating: RatingSource
    method: str
    exponent: float
    revolutions: float
    hours: float
    modified_hours: float
    static_safety: float


@dataclass(frozen=True)
class SpectrumCase(Shown):
    """One row of a load spectrum, and the bearings under its loads.

    Parameters
    ----------
    speed : float
        Speed of the reference shaft [rad/s].
    torque : float
        Torque [N m] at `BearingLife.torque_at`; NaN for the loads of the system.
    share : float
        Share of the time.
    bearings : tuple of RatedBearing
        The bearings under these loads.

    Examples
    --------
    >>> import gearbow as gb
    >>> gb.results.SpectrumCase(speed=157.0, torque=250.0, share=0.4, bearings=()).share
    0.4
    """

    speed: float
    torque: float
    share: float
    bearings: tuple[RatedBearing, ...]


@dataclass(frozen=True, eq=False)
class BearingLife(WithSpeeds, Figured, ReadOnly):
    """Rating life of the rolling bearings of a system.

    `plot` draws the life of each bearing as bars on a logarithmic axis.

    Parameters
    ----------
    bearings : tuple of RatedBearing
        The bearings, in the order of the system; those without a dynamic rating are left out.
    cases : tuple of SpectrumCase
        The rows of the load spectrum; without a spectrum, the one operating point.
    factor, reliability : float
        Given factor, and reliability of the modified life.
    notes : tuple of str
        Bearings without a life, and forces that it does not contain.
    torque_at : str
        Place of the torque that a spectrum gives; empty without a spectrum.
    left_out : tuple of str
        Excitations of the system that this result does not contain.

    Notes
    -----
    The table has the life over all cases, the data frame each case. ISO 281:2007, *Rolling bearings
    - Dynamic load ratings and rating life*; ISO 76:2006, *Rolling bearings - Static load ratings*;
    ISO/TS 16281:2008, *Rolling bearings - Methods for calculating the modified reference rating
    life for universally loaded bearings*.

    Examples
    --------
    >>> import gearbow as gb
    >>> found = gb.examples()["coaxial_reducer"].load().bearing_life(129.22)
    >>> found.shortest.at
    ('input', 0.065)
    """

    bearings: tuple[RatedBearing, ...]
    cases: tuple[SpectrumCase, ...]
    factor: float = 1.0
    reliability: float = 0.9
    notes: tuple[str, ...] = ()
    torque_at: str = ""
    left_out: tuple[str, ...] = ()

    @property
    def hours(self) -> Array:
        """Basic rating life of each bearing [h], shape (bearings,)."""
        return np.array([one.hours for one in self.bearings])

    @property
    def shortest(self) -> RatedBearing:
        """The bearing with the shortest life."""
        return min(self.bearings, key=lambda one: one.hours)

    def bearing(self, at: tuple[str, float]) -> RatedBearing:
        """Look up one bearing.

        Parameters
        ----------
        at : tuple of (str, float)
            Shaft and position of the bearing [m].

        Returns
        -------
        RatedBearing
            Its loads and life.
        """
        return self.bearings[Places.of("bearing", [one.at for one in self.bearings]).index(at)]

    def _columns(self) -> list[Column]:
        return self._columns_of(self.bearings)

    def _series(self) -> list[Column]:
        if not self.torque_at:
            return self._columns()
        rows = [(case, one) for case in self.cases for one in case.bearings]
        hours = {one.at: one.hours for one in self.bearings}
        damage = [case.share / one.hours * hours[one.at] for case, one in rows]
        return [
            Column("speed", np.array([case.speed for case, _ in rows]), "rad/s", ".5g"),
            Column("torque", np.array([case.torque for case, _ in rows]), "N m"),
            Column("share of time", np.array([case.share for case, _ in rows])),
            *self._columns_of([one for _, one in rows]),
            Column("share of damage", np.nan_to_num(np.array(damage))),
        ]

    def _columns_of(self, rows: Sequence[RatedBearing]) -> list[Column]:
        def values(name: str) -> Array:
            return np.array([getattr(one, name) for one in rows])

        least = ROUND_OFF * float(np.nan_to_num(values("equivalent_load")).max(initial=0.0))
        forces = [
            Column(f"{name} force", values(f"{name}_force"), "N", round_off=least)
            for name in ("radial", "axial")
            if (np.abs(np.nan_to_num(values(f"{name}_force"))) > least).any()
        ]
        modified = [Column("modified life", values("modified_hours"), "h")]
        return [
            Column("bearing", [place_label(one.at) for one in rows]),
            *forces,
            Column("P", values("equivalent_load"), "N"),
            Column("C", values("dynamic_rating"), "N"),
            Column("rating", [one.rating for one in rows]),
            Column("method", [one.method for one in rows]),
            Column("relative speed", values("speed"), "rad/s", ".5g"),
            Column("L10", values("revolutions"), "10⁶ turns"),
            Column("life", values("hours"), "h"),
            *(modified if self._is_modified else []),
            Column("C0/P0", values("static_safety"), "", ".3g"),
        ]

    @property
    def _is_modified(self) -> bool:
        return self.factor != 1.0 or self.reliability != 0.9

    def _heading(self) -> list[str]:
        what = "basic rating life of rolling bearings, ISO 281"
        if not self.torque_at:
            return [f"{what}, at {self._speed_text(self.cases[0].speed)}"]
        cases = "1 case" if len(self.cases) == 1 else f"{len(self.cases)} cases"
        return [f"{what}, over a spectrum of {cases}; torque at {self.torque_at}"]

    def _remarks(self) -> list[str]:
        found = list(self.notes)
        if self._is_modified:
            found.append(
                f"modified life: reliability {self.reliability:g}, given factor {self.factor:g}"
            )
        if self.factor == 1.0:
            found.append("not contained: lubrication and contamination; give their factor")
        return found

    def _draw(self, ax: Any) -> "Figure":
        from gearbow.plotting import analyses as figures  # noqa: PLC0415

        lives = {"basic rating life": self.hours}
        if self._is_modified:
            lives["modified life"] = np.array([one.modified_hours for one in self.bearings])
        return figures.lives([place_label(one.at) for one in self.bearings], lives, ax)

    def __repr__(self) -> str:
        first = self.shortest
        count = "1 bearing" if len(self.bearings) == 1 else f"{len(self.bearings)} bearings"
        return f"BearingLife({count}; shortest {first.hours:.4g} h, {place_label(first.at)})"


def life_at(
    static: "Static",
    bearings: Sequence[Mapping[str, Any]],
    ratios: Mapping[str, float],
    *,
    factor: float,
    reliability: float,
    left_out: tuple[str, ...] = (),
) -> BearingLife:
    """Find the life of the bearings, given in plain form, at an equilibrium."""
    modifier = positive(factor, "factor") * reliability_factor(reliability)
    parts = parts_of({"bearings": bearings})["bearings"]
    places = [(one.shaft, float(one.position)) for one in parts]
    rows, notes = [], []
    for part, at in zip(parts, places, strict=True):
        rating = rating_of(part)
        if isinstance(part, JournalBearing | TiltingPadBearing):
            continue
        label = place_label(at)
        if rating is None:
            notes.append(f"no life of {label}: its dynamic_rating is not given")
        elif places.count(at) > 1:
            notes.append(f"no life of {label}: several bearings share its force")
        else:
            rows.append(_rated(static, part, rating, ring_ratios(part, ratios), modifier))
            if rows[-1].axial_force and not rating.carries_thrust:
                notes.append(f"{label}: P is without the thrust, which its rollers do not carry")
    if not rows:
        raise SceneError(
            "bearings: no bearing has a dynamic rating; give dynamic_rating, or gb.RollingBearing"
        )
    case = SpectrumCase(static.speed, math.nan, 1.0, tuple(rows))
    found = (tuple(rows), (case,), float(factor), float(reliability), tuple(notes))
    return BearingLife(*found, left_out=left_out)


def _rated(
    static: "Static",
    part: Bearing | RollingBearing,
    rating: LoadRating,
    ratios: tuple[float, float],
    modifier: float,
) -> RatedBearing:
    at = (part.shaft, float(part.position))
    radial = float(np.hypot(*static.bearing_force(at)))
    thrust = abs(static.axial_bearing_force(at))
    speed = static.speed * (ratios[0] - ratios[1])
    forces = static._contact_forces(at)
    method, load = "ISO 281", float(rating.equivalent_load(radial, thrust))
    revolutions = life_revolutions(rating.dynamic, load, rating.exponent)
    if forces is not None and rating.elements is not None:
        method = "ISO/TS 16281"
        revolutions = rating.revolutions_of_elements(forces, (ratios[0] != 0.0, ratios[1] != 0.0))
        load = rating.dynamic * revolutions ** (-1.0 / rating.exponent)
    hours, at_rest = life_hours(revolutions, speed), rating.static_load(radial, thrust)
    return RatedBearing(
        at=at,
        speed=speed,
        radial_force=radial,
        axial_force=thrust,
        equivalent_load=load,
        dynamic_rating=rating.dynamic,
        static_rating=rating.static,
        rating=rating.source,
        method=method,
        exponent=rating.exponent,
        revolutions=revolutions,
        hours=hours,
        modified_hours=modifier * hours,
        static_safety=rating.static / at_rest if at_rest else math.inf,
    )


def over_spectrum(cases: Sequence[SpectrumCase], like: BearingLife, torque_at: str) -> BearingLife:
    """Combine the lives of the cases of a spectrum by the rule of Palmgren and Miner."""
    modifier = like.factor * reliability_factor(like.reliability)
    shares = [case.share for case in cases]
    of_bearings = zip(*(case.bearings for case in cases), strict=True)
    rows = tuple(_combined(own, shares, modifier) for own in of_bearings)
    return replace(like, bearings=rows, cases=tuple(cases), torque_at=torque_at)


def _combined(
    rows: Sequence[RatedBearing], shares: Sequence[float], modifier: float
) -> RatedBearing:
    """Combine the lives of one bearing."""
    pairs = list(zip(rows, shares, strict=True))
    damage = sum(share / one.hours for one, share in pairs)
    speed = sum(share * abs(one.speed) for one, share in pairs)
    hours = 1.0 / damage if damage else math.inf
    revolutions = hours / life_hours(1.0, speed) if damage else math.inf
    first = rows[0]
    return replace(
        first,
        speed=speed,
        radial_force=math.nan,
        axial_force=math.nan,
        equivalent_load=first.dynamic_rating * revolutions ** (-1.0 / first.exponent),
        revolutions=revolutions,
        hours=hours,
        modified_hours=modifier * hours,
        static_safety=min(one.static_safety for one in rows),
    )
