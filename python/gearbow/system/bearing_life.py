"""Rating life of the rolling bearings of a system, at a speed or over a load spectrum."""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from gearbow._convert import number, shown
from gearbow._progress import working
from gearbow.analysis.protocol import System, without_scene_warnings
from gearbow.description.loads import Torque
from gearbow.description.places import place_label
from gearbow.errors import SceneError
from gearbow.results.bearing_life import BearingLife, SpectrumCase, over_spectrum

#: Largest difference of the sum of the shares of a spectrum from 1: three rounded thirds.
_ROUNDED_SHARES = 1e-3


def bearing_life(
    self: System,
    speed: float | None = None,
    *,
    spectrum: Sequence[Sequence[Any]] | None = None,
    factor: float = 1.0,
    reliability: float = 0.9,
    progress: bool | None = None,
) -> BearingLife:
    """Find the rating life of the rolling bearings, at a speed or over a load spectrum.

    The forces are those of the static equilibrium. Every rolling bearing has a life, and every
    linear bearing with a `dynamic_rating`.

    Parameters
    ----------
    speed : float, optional
        Speed of the reference shaft [rad/s]. Give it, or a spectrum.
    spectrum : sequence of (speed, torque, share), optional
        Speed of the reference shaft [rad/s], torque [N m] and share of the time of each case;
        texts with a unit such as "30 %" are possible. The torque is that of the
        first constant torque on the reference shaft, or the first constant one in `torques` if
        there is none on it. All constant torques are scaled in the same proportion, and
        `Torque.balance` follows; forces and gravity stay the same. The shares must sum to 1.
    factor : float
        Factor of the modified life for lubrication and contamination, a_ISO of ISO 281.
    reliability : float
        Reliability of the modified life, from 0.9 to 0.9995: factor a₁ of ISO 281.
    progress : bool, optional
        Whether to show the elapsed time; None shows it on a terminal if it is above 2 s.

    Returns
    -------
    BearingLife
        Forces, equivalent load, rating life in turns and hours, and static safety of each bearing.

    Raises
    ------
    SceneError
        If neither or both of speed and spectrum are given, a case is invalid, the shares do not sum
        to 1, no torque can be scaled, or no bearing has a dynamic rating.
    ContactError, ConvergenceError
        As `static`.

    Notes
    -----
    L₁₀ = (C/P)^p million turns, p = 3 for balls and 10/3 for rollers, with P = X F_r + Y F_a of ISO
    281. Where the rings have five degrees of freedom, the life follows from the loads of the
    elements (ISO/TS 16281), and P is the load with this life. Turns are those of one ring relative
    to the other. C is `dynamic_rating` of the bearing; else, for the dimensions of deep groove ball
    bearings of the series 60, 62 and 63, that of a catalogue (SKF 17000/1 EN, 2018); else that of
    ISO 281 for number and size of the elements. Over a spectrum, the parts of the life that the
    cases use up are added (Palmgren and Miner). P₀ is that of ISO 76. Bearings with two degrees of
    freedom have the thrust of their `axial_stiffness` only; that which a radial load induces in
    inclined contacts needs five.

    Examples
    --------
    >>> import gearbow as gb
    >>> shaft = gb.Shaft("rotor", length=0.5, outer_diameter=0.04)
    >>> bearings = [gb.RollingBearing("rotor", x, "6208") for x in (0.0, 0.5)]
    >>> force = gb.Force(("rotor", 0.25), -4000j)
    >>> system = gb.RotorSystem([shaft], bearings=bearings, forces=[force])
    >>> print(f"{system.bearing_life(157.08).shortest.hours:.0f} h")
    47678 h
    """
    if (speed is None) == (spectrum is None):
        raise SceneError("speed: give either a speed or a spectrum")
    if speed is not None:
        wanted = number(speed, "speed")
        with working(progress, "life of the bearings"):
            return self.static(wanted).bearing_life(factor=factor, reliability=reliability)
    cases = _cases(spectrum or ())
    index = _driving_torque(self)
    driving = self.torques[index]
    found: list[SpectrumCase] = []
    with working(progress, f"life of the bearings in {len(cases)} cases"):
        for turning, torque, share in cases:
            system = _with_torque(self, index, torque)
            like = system.static(turning)._life(factor, reliability)
            found.append(SpectrumCase(turning, torque, share, like.bearings))
    return over_spectrum(found, like, place_label(driving.at))


def _cases(given: Sequence[Sequence[Any]]) -> list[tuple[float, float, float]]:
    """Check the rows of a spectrum."""
    if isinstance(given, str | bytes) or not hasattr(given, "__iter__"):
        raise SceneError(f"spectrum: must be a list of (speed, torque, share), got {shown(given)}")
    found = []
    for i, row in enumerate(given):
        if isinstance(row, str | bytes) or not hasattr(row, "__len__") or len(row) != 3:
            raise SceneError(f"spectrum[{i}]: must be (speed, torque, share), got {shown(row)}")
        names = ("speed", "torque", "share")
        pairs = zip(row, names, strict=True)
        speed, torque, share = (_value(each, f"spectrum[{i}].{name}") for each, name in pairs)
        if share < 0.0:
            raise SceneError(f"spectrum[{i}].share: must not be negative, got {share:g}")
        found.append((speed, torque, share))
    total = math.fsum(share for *_, share in found)
    if abs(total - 1.0) > _ROUNDED_SHARES:
        raise SceneError(
            f"spectrum: the shares of the time must sum to 1, got {total:g}; add a case with speed "
            "0 for standstill"
        )
    return found


def _value(given: Any, path: str) -> float:
    """Read a number, or a text with a unit."""
    if isinstance(given, str):
        from gearbow.units.parse import parsed  # noqa: PLC0415  # most spectra have no texts

        given = parsed(given, path)
    return number(given, path)


def _driving_torque(system: System) -> int:
    """Find the torque that a spectrum gives."""
    constant = [i for i, one in enumerate(system.torques) if _is_constant(one)]
    for i, one in enumerate(system.torques):
        if i not in constant and one.value != "balance":
            raise SceneError(
                f"torques[{i}].value: a spectrum scales constant torques only; leave out a torque "
                "over time or speed"
            )
    shafts = {i: system.coordinates.shaft(system.torques[i].at) for i in constant}
    first = system.reference or system.shafts[0].name
    found = next((i for i in constant if shafts[i] == first), next(iter(constant), None))
    if found is None:
        raise SceneError("torques: a spectrum needs a constant torque that it can scale")
    if system.torques[found].value == 0.0:
        raise SceneError(f"torques[{found}].value: must not be zero: a spectrum scales it")
    return found


def _is_constant(torque: Torque) -> bool:
    return isinstance(torque.value, int | float)


def _with_torque(system: System, index: int, value: float) -> Any:
    """Make a system with another driving torque, in proportion to which all others change."""
    ratio = value / system.torques[index].value  # type: ignore[operator]  # it is a number
    torques = [
        replace(one, value=ratio * one.value) if _is_constant(one) else one  # type: ignore[operator]
        for one in system.torques
    ]
    with without_scene_warnings():
        return system._variation(torques=torques)
