"""Static and synchronous motion of a train at one speed, as a function of the size of a bow.

A signal x of the motion is x₀ + Σ_s Re(a_s e^{iϑ_s}) + Re(b u e^{i(ϑ_s + φ)}): the static value,
all sources but the bow, and the bow of the size b and phase φ with the response u to the size 1. It
is sampled over the angles ϑ_s = r_s Ω t of some turns and over the phases, if other sources exist.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from gearbow._types import Array, At, ComplexArray
from gearbow.analysis.bow_elements import with_elements_for
from gearbow.analysis.protocol import System, variant
from gearbow.description.bow import Bow, amplitude_of, scaled
from gearbow.results.synchronous import Synchronous

__all__ = ["BowMotion", "BowSignal", "Variants"]

#: Instants of one turn of the fastest shaft that excites. A maximum between two of them is missed
#: by at most 1 − cos(π/72) = 0.1 % of an orbit.
_INSTANTS = 72
#: Phases of the worst phase, by the same estimate within 0.4 % of the orbit.
_PHASES = 36
#: Largest number of turns of the bowed shaft, after which shafts with other speeds have met in many
#: positions.
_MAX_TURNS = 16
#: Change of a margin over the phases that the distance of instants and phases explains.
_SAME_MARGIN = 5e-3
#: Part of a turn by which shafts may miss a common period.
_SAME_TURN = 1e-6


@dataclass(frozen=True, eq=False)
class BowSignal:
    """A signal with a row for each instant: without the bow, and the part in proportion to it."""

    rest: Array
    unit: ComplexArray
    turns: ComplexArray

    def at(self, bow: float) -> Array:
        """Give the values for a size of the bow, (phases, instants, components)."""
        values: Array = self.rest + bow * np.real(self.turns[:, None, None] * self.unit)
        return values

    def __sub__(self, other: "BowSignal") -> "BowSignal":
        return BowSignal(self.rest - other.rest, self.unit - other.unit, self.turns)

    @cached_property
    def size(self) -> float:
        """Largest value for the bow 1."""
        return float(np.abs(self.unit).max(initial=0.0))


class Variants:
    """A system with any size of the bows of some shafts, on the same elements."""

    def __init__(
        self, system: System, shafts: Sequence[str], bows: Sequence[Bow], phase: float | None
    ) -> None:
        # The elements must not follow the loads: all variants have the same coordinates.
        self.base: System = with_elements_for(system, dict(zip(shafts, bows, strict=True)))
        self.shafts = tuple(shafts)
        largest = max(map(amplitude_of, bows))
        self.bows = [scaled(bow, 1.0 / largest) for bow in bows]
        self.phase = phase
        self.straight: System = self._bent([None] * len(bows))

    def bent(self, size: float, phase: float) -> System:
        """Give the system with bows of a size [m], turned by a phase."""
        return self._bent([scaled(bow, size, phase) for bow in self.bows])

    def _bent(self, bows: Sequence[Bow | None]) -> System:
        own = dict(zip(self.shafts, bows, strict=True))
        shafts = [replace(each, bow=own.get(each.name, each.bow)) for each in self.base.shafts]
        made: System = variant(self.base, shafts=shafts)
        return made

    def responses(self, speeds: Array) -> tuple[Synchronous, Synchronous]:
        """Give the response without these bows, and that to bows of the size 1 alone."""
        # A bow of 1 µm is small on every shaft; the response is linear.
        size = 1e-6
        alone = [
            replace(each, bow=scaled(own, size))
            for each, own in ((each, self._own(each.name)) for each in self.base.shafts)
        ]
        unit = variant(self.base, shafts=alone).synchronous(speeds, excitation="bow")
        unit = replace(
            unit,
            amplitudes=unit.amplitudes / size,
            _bearing_force=unit._bearing_force / size,
        )
        return self.straight.synchronous(speeds), unit

    def _own(self, name: str) -> Bow | None:
        return self.bows[self.shafts.index(name)] if name in self.shafts else None


class BowMotion:
    """Motion at one speed of the reference shaft as a function of the size of the bow."""

    def __init__(
        self,
        variants: Variants,
        speed: float,
        index: int,
        responses: tuple[Synchronous, Synchronous],
    ) -> None:
        self.variants, self.speed = variants, speed
        self.static = variants.straight.static(speed)
        self._index = index
        self._others, self._unit = responses
        self.ratios = variants.base.speed_ratios
        names = self._others.shafts
        excites = np.abs(self._others.amplitudes[index]).max(axis=1, initial=0.0) > 0.0
        bowed = np.array([name in variants.shafts for name in names])
        self.others_excite = bool(excites.any())
        about = float(self.ratios[names.index(variants.shafts[0])])
        relative = np.abs(self.ratios[excites | bowed] / about)
        turns = _common_turns(relative)
        count = math.ceil(_INSTANTS * turns * max(1.0, float(relative.max())))
        angles = 2.0 * math.pi * turns * np.arange(count) / (count * about)
        #: e^{iϑ_s} of each shaft, (instants, shafts).
        self._phasors = np.exp(1j * np.outer(angles, self.ratios))
        self.phases: Array = np.array([variants.phase or 0.0])
        if variants.phase is None and self.others_excite:
            self.phases = 2.0 * math.pi * np.arange(_PHASES) / _PHASES
        self._turns = np.exp(1j * self.phases)

    def displacement(self, at: At) -> BowSignal:
        """Give the displacement of a place [m]."""
        static = self.static.displacement(at)
        return self._signal(static, self._others.displacement(at), self._unit.displacement(at))

    def velocity(self, at: At) -> BowSignal:
        """Give the velocity of a place [m/s]."""
        rates = 1j * self.ratios[:, None] * self.speed
        others, unit = (each.displacement(at) * rates for each in (self._others, self._unit))
        return self._signal(np.zeros(2), others, unit)

    def bearing_force(self, at: tuple[str, float]) -> BowSignal:
        """Give the force on a bearing [N]."""
        static = self.static.bearing_force(at)
        return self._signal(static, self._others.bearing_force(at), self._unit.bearing_force(at))

    def combined(self, static: float, row: Array) -> BowSignal:
        """Give a static value and a linear combination of all coordinates."""
        others, unit = (each.amplitudes @ row[:, None] for each in (self._others, self._unit))
        return self._signal(np.array([static]), others, unit)

    def _signal(self, static: Array, others: ComplexArray, unit: ComplexArray) -> BowSignal:
        rest = static + np.real(self._phasors @ others[self._index])
        return BowSignal(rest, self._phasors @ unit[self._index], self._turns)

    def worst(self, values: Array, whole: float) -> float:
        """Give the phase of the smallest margin; NaN if it does not matter."""
        # `whole` is the margin without bow, of which the phases must change a part.
        if self.phases.size == 1:
            return math.nan if self.variants.phase is None else self.variants.phase
        smallest = values.reshape(self.phases.size, -1).min(axis=1)
        if np.ptp(smallest) < _SAME_MARGIN * whole:
            return math.nan
        return float(self.phases[int(np.argmin(smallest))])


def _common_turns(ratios: Array) -> int:
    """Find the number of turns after which shafts with these speed ratios are in phase again."""
    for turns in range(1, _MAX_TURNS):
        angles = turns * ratios
        if np.all(np.abs(angles - np.round(angles)) < _SAME_TURN * turns):
            return turns
    return _MAX_TURNS
