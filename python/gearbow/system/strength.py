"""Analyses of strength and heat: stresses, life of rolling bearings, and thermal bow."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from gearbow._convert import array, nearest, number, positive, shown
from gearbow._progress import working
from gearbow._types import At, ComplexArray, StrengthLine
from gearbow.analysis.protocol import System, variant, without_scene_warnings
from gearbow.description.layout import left_out, shafts_of_bodies
from gearbow.description.loads import ThermalBow, Torque
from gearbow.description.part import expect, parts
from gearbow.description.places import place, place_label
from gearbow.description.shafts import Notch
from gearbow.errors import SceneError
from gearbow.results.bearing_life import BearingLife, SpectrumCase, over_spectrum
from gearbow.results.stresses import Strength, Stresses, Tones, collect, of_tones, places_of
from gearbow.results.synchronous import Synchronous
from gearbow.results.thermal import ThermalStability
from gearbow.system.linear import static, synchronous


def stresses(
    self: System,
    speed: float,
    *,
    endurance_limit: float | Mapping[str, float] | None = None,
    tensile_strength: float | Mapping[str, float] | None = None,
    line: StrengthLine = "goodman",
    notches: Sequence[Notch] | None = None,
    progress: bool | None = None,
) -> Stresses:
    """Find mean and alternating stresses of the turning shafts at a speed.

    They follow from the section forces of the static equilibrium and of the synchronous response.
    `Response.stresses` gives those of a run, with tooth forces over the mesh cycle.

    Parameters
    ----------
    speed : float
        Speed of the reference shaft [rad/s].
    endurance_limit : float or mapping, optional
        Stress amplitude that a smooth specimen of the size of the shaft endures without a mean
        stress [Pa], for all shafts or by name. None gives no utilisation.
    tensile_strength : float or mapping, optional
        Tensile strength of the material [Pa], for the line of mean stresses.
    line : {"goodman", "din743"}
        How a mean stress lowers the endured amplitude.
    notches : sequence of Notch, optional
        Notches in place of those of the system.
    progress : bool, optional
        Whether to show the elapsed time; None shows it on a terminal if it is above 2 s.

    Returns
    -------
    Stresses
        Stresses at the worst fibre of each section: at the nodes of the shafts and at notches.

    Raises
    ------
    ConvergenceError
        If there is no equilibrium, or the residual of a response exceeds 1e-4.
    """
    speed = number(speed, "speed")
    given = self.notches if notches is None else tuple(parts(notches, Notch, "notches"))
    names = [shaft.name for shaft in self.shafts]
    strength = Strength.of(names, endurance_limit, tensile_strength, line)
    with working(progress, "stresses"):
        rest = static(self, speed).state
        response = synchronous(self, [speed])
    found = []
    frequencies = self.speed_ratios * speed
    for index, name in enumerate(names):
        positions = places_of(self._model, name, given)
        motions = {
            "phasors": response.amplitudes[0],
            "frequencies": frequencies.tolist(),
            "speeds": [speed] * len(names),
            "bowed": [source == name for source in names],
        }
        tones = Tones(
            standing=self._model.static_section_forces(name, positions, rest, speed),
            phasors=self._model.harmonic_section_forces(name, positions, motions),
            frequencies=frequencies,
            spin=float(frequencies[index]),
        )
        sections = self._model.sections(name, positions)
        found += [
            (section, factors, of_tones(tones, k, factors))
            for k, (section, factors) in enumerate(sections)
        ]
    return collect(found, given, strength, left_out(self))


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
    >>> system = gb.examples()["coaxial_reducer"].load()
    >>> print(f"{system.bearing_life(129.22).shortest.hours:.0f} h")
    3075 h
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


def thermal_bow(self: System, bow: ThermalBow, speeds: "ArrayLike") -> ThermalStability:
    """Find whether the bow by the uneven heating of a journal grows.

    Parameters
    ----------
    bow : ThermalBow
        The journal, how its temperature follows the vibration, and the shape of the bow.
    speeds : array_like, shape (speeds,) or scalar
        Speeds of the reference shaft [rad/s].

    Returns
    -------
    ThermalStability
        Loop gain and eigenvalue at each speed, from two synchronous responses: that to the bow of
        1 K, and that to bow and unbalance of the system.

    Warns
    -----
    AccuracyWarning
        If the system without thermal bow is unstable at some of the speeds.

    Notes
    -----
    The temperature difference changes slowly, so that the rotor follows it without delay. Of an
    elliptic orbit the forward part heats one side; the backward part goes around the shaft twice in
    each revolution.
    """
    expect(bow, ThermalBow, "bow")
    wanted = array(speeds, "speeds")
    at = place(bow.at, "bow.at", "place")
    bodies = shafts_of_bodies(self)
    name = at if isinstance(at, str) else at[0]
    shaft = bodies.get(name, name) if isinstance(at, str) else name
    names = [each.name for each in self.shafts]
    if shaft not in names:
        known = [*names, *bodies]
        raise SceneError(f'bow.at: no shaft, gear or disk is called "{name}"{nearest(name, known)}')
    index = names.index(shaft)
    bent = [
        replace(each, bow=bow.shape if i == index else None) for i, each in enumerate(self.shafts)
    ]
    by_heat = variant(self, shafts=bent).synchronous(wanted, excitation="bow")
    return ThermalStability(
        at=bow.at,
        speeds=wanted,
        time_constant=positive(bow.time_constant, "time_constant"),
        gain=bow._gains(wanted * self.speed_ratios[index]),
        response=_forward(by_heat, bow.at, index),
        vibration=_forward(self.synchronous(wanted), bow.at, index),
        left_out=left_out(self),
    )


def _forward(found: Synchronous, at: At, index: int) -> ComplexArray:
    """Give the part of the vibration by a shaft that turns with it, a phasor in the shaft."""
    v, w = np.moveaxis(found.displacement(at)[:, index], -1, 0)
    forward: ComplexArray = (v + 1j * w) / 2.0
    return forward
