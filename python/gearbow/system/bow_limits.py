"""The bow of a shaft at which each limit of a system is reached."""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from gearbow._convert import array, one_of
from gearbow._types import Array
from gearbow.analysis.arclength import first_crossing
from gearbow.analysis.bow_checks import Check, added_check, mesh_checks, mesh_teeth
from gearbow.analysis.bow_motion import BowMotion, Variants
from gearbow.analysis.protocol import System
from gearbow.description.bow import Bow, BowLimit, amplitude_of
from gearbow.description.layout import left_out
from gearbow.description.part import expect, parts
from gearbow.errors import ContactError, ConvergenceError, SceneError, StabilityError
from gearbow.results.bow_limits import BowLimits, ReachedLimit
from gearbow.system.steady import steady_state

#: Relative tolerance of a bow from the linear motion, and from steady states, which cost more.
_TOLERANCE, _STEADY_TOLERANCE = 1e-6, 2e-3
#: First bow of a search among steady states, as a part of the bow at which the linear motion ends.
_STEADY_PARTS = 8.0
#: Bow of a steady state that counts as none, as a part of the largest one.
_NO_BOW = 1e-6


def bow_limits(
    self: System,
    shaft: str | Sequence[str],
    speed: "ArrayLike",
    *,
    shape: Bow | None = None,
    phase: "ArrayLike | None" = None,
    limits: Sequence[BowLimit] = (),
) -> BowLimits:
    """Find the largest bow of a shaft for every limit.

    Each mesh has four limits: the backlash is used up, so that the back flanks touch; tips touch
    roots; tips pass the ends of the involutes; the contact ratio falls below 1. `limits` adds
    others.

    Parameters
    ----------
    shaft : str or sequence of str
        The bowed shaft. The bows of several shafts grow together.
    speed : float or array_like, shape (speeds,)
        Speed of the reference shaft [rad/s], or several.
    shape : Bow, optional
        Shape and phase of the bow, of any amplitude. None is the present bow, or a half sine.
    phase : float or array_like, shape (shafts,), optional
        Angle by which the shape is turned in the shaft [rad], for all named shafts or for each; 0
        keeps its own phase. None is the worst phase of each shaft relative to all else that turns.
    limits : sequence of BowLimit
        Further limits: displacement, velocity, contact ratio, mesh force, bearing force or life,
        oil film, clearance of a rolling bearing.

    Returns
    -------
    BowLimits
        The bow at each limit and speed, its margin to the present bow, and the limit that decides.

    Raises
    ------
    SceneError
        If an argument is invalid, or the bow is given by a function.
    ChannelError, GearbowError
        If a limit names an unknown mesh, bearing or place.

    Notes
    -----
    The limits of the teeth follow from the exact geometry of the moving centres. Their motion is
    the static equilibrium plus the linear synchronous response (`synchronous`), which contains bow,
    unbalance, run-out of gears and couplings, and turning forces of order 1; so are vibrations and
    forces of bearings. What is left out, as errors of the teeth and the changing number of tooth
    pairs, stands below the printed limits. The angles of shafts are independent of each other
    unless they have a common period of at most 36 turns of the faster one. Mesh forces and oil
    films are found from steady states of the nonlinear system; their worst phase is that with the
    smallest backlash (without one: tip clearance) or the largest displacement of the journal in the
    linear motion.

    Examples
    --------
    >>> from dataclasses import replace
    >>> import gearbow as gb
    >>> system = gb.examples()["geared_pair"].load()
    >>> loose = system.replace(meshes=[replace(system.meshes[0], backlash=2e-4)])
    >>> for one in loose.bow_limits("rotor 1", 10.0).limits[:2]:
    ...     print(f"{one.limit} {one.at}: {1e6 * one.bow:.0f} µm")
    backlash used up pinion/wheel: 2047 µm
    tips touch roots pinion/wheel: 5314 µm
    """
    speeds = np.atleast_1d(array(speed, "speed"))
    names, bows, present = _bows(self, shaft, shape)
    turned = _phases(phase, len(names))
    added = parts(limits, BowLimit, "limits")
    variants = Variants(self, names, bows, turned)
    responses = variants.responses(speeds)
    found: list[list[ReachedLimit]] = []
    for index, each in enumerate(speeds):
        motion = BowMotion(variants, float(each), index, responses)
        teeth = mesh_teeth(motion)
        checks = [*mesh_checks(teeth.values()), *(added_check(motion, x, teeth) for x in added)]
        found.append([_reached(motion, check) for check in checks])
    by_limit = tuple(one for own in zip(*found, strict=True) for one in own)
    lacks = left_out(self)
    return BowLimits(names, present, speeds, by_limit, turned, lacks)


def _phases(given: "ArrayLike | None", count: int) -> tuple[float, ...] | None:
    """Check the given phases of the shafts [rad]."""
    if given is None:
        return None
    phases = np.atleast_1d(array(given, "phase"))
    if phases.ndim != 1 or phases.size not in (1, count):
        raise SceneError(f"phase: give one angle, or one for each of the {count} shafts")
    return tuple(np.broadcast_to(phases, count).tolist())


def _bows(
    system: System, shaft: str | Sequence[str], shape: Bow | None
) -> tuple[tuple[str, ...], list[Bow], float]:
    """Give the shafts, their bows, and the size of the present bow."""
    known = {each.name: each for each in system.shafts}
    wanted = shaft if isinstance(shaft, list | tuple) else [shaft]
    names = tuple(one_of(name, known, "shaft") for name in wanted)
    if not names:
        raise SceneError("shaft: name at least one shaft")
    own = [known[name].bow for name in names]
    present = max(map(amplitude_of, own))
    given = None if shape is None else expect(shape, Bow, "shape")
    if given is None and present == 0.0:
        given = Bow.half_sine(1.0)
    bows = [given or bow or Bow.half_sine(0.0) for bow in own]
    if not max(map(amplitude_of, bows)) > 0.0:
        raise SceneError("shape: the amplitude must be positive; it is scaled to each limit")
    return names, bows, present


def _reached(motion: BowMotion, check: Check) -> ReachedLimit:
    found = ReachedLimit(check.limit, check.at, motion.speed, math.inf, why=check.why)
    if check.steady is not None:
        return _steady(motion, check, found)
    margin = check.margin
    if margin is None:
        return found

    def smallest(bow: float) -> float:
        return motion.smallest(margin, bow, of_instants=check.of_instants)

    bow = first_crossing(smallest, check.first, check.most, _TOLERANCE)
    if bow is None:
        return replace(found, why=f"{check.beyond} first, at {1e6 * check.most:.4g} µm")
    if bow == 0.0:
        return replace(found, bow=0.0, why=f"{check.why}; exceeded without this bow")
    return replace(found, bow=bow, **_of_phases(motion.worst(margin, bow)[1]))


def _of_phases(phases: Array) -> dict[str, Any]:
    return {"phase": float(phases[0]), "phases": tuple(phases.tolist())}


def _steady(motion: BowMotion, check: Check, found: ReachedLimit) -> ReachedLimit:
    """Find the bow at which a limit of steady states is reached."""
    proxy, steady = check.proxy, check.steady
    assert proxy is not None
    assert steady is not None
    scale = first_crossing(
        lambda bow: motion.smallest(proxy, bow, of_instants=check.of_instants),
        check.first,
        check.most,
        _STEADY_TOLERANCE,
    )
    most = check.most if scale is None else check.stretch * scale
    phases = motion.worst(proxy, scale or most)[1]
    turned = np.nan_to_num(phases).tolist()
    failures: dict[float, str] = {}

    def margin(bow: float) -> float:
        # A system that nothing excites has no period: a small bow stands for none.
        system = motion.variants.bent(max(bow, _NO_BOW * most), turned)
        try:
            found = steady_state(
                system, motion.speed, initial="static", record=["meshes", "bearings"]
            )
            return steady(found.response)
        except (ConvergenceError, StabilityError, ContactError) as error:
            failures[bow] = str(error)
            return -math.inf

    bow = first_crossing(margin, (scale or most) / _STEADY_PARTS, most, _STEADY_TOLERANCE)
    if bow is None:
        return replace(found, why=f"not reached up to {1e6 * most:.4g} µm: {check.beyond}")
    if failures and min(failures) <= (1.0 + _STEADY_TOLERANCE) * bow:
        text = f"no steady motion above {1e6 * bow:.4g} µm: {failures[min(failures)]}"
        return replace(found, why=text)
    why = f"{check.why}; exceeded without this bow" if bow == 0.0 else check.why
    return replace(found, bow=bow, why=why, **_of_phases(phases))
