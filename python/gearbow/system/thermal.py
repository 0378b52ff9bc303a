"""Stability of a thermal bow, from synchronous responses."""

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from gearbow._convert import array, positive
from gearbow._lookup import nearest
from gearbow._types import At, ComplexArray
from gearbow.analysis.protocol import System, variant
from gearbow.description.layout import left_out, shafts_of_bodies
from gearbow.description.loads import ThermalBow
from gearbow.description.part import expect
from gearbow.description.places import place
from gearbow.errors import SceneError
from gearbow.results.synchronous import Synchronous
from gearbow.results.thermal import ThermalStability


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
