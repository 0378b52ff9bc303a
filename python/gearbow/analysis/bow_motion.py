"""Systems with bows of any size, and their motion at one speed.

A signal x of the motion is x₀ + Σ_s Re(a_s e^{iϑ_s}) + b Σ_s Re(u_s e^{i(ϑ_s + φ_s)}): the static
value, what turns with each shaft without the bows, and the bow of the size b and the phase φ_s of
each bowed shaft, with the response u_s to the size 1. Shafts whose angles ϑ_s have a short common
period are a group, which is sampled over this period. Between groups every relative angle occurs,
so that the values of x are the sums of one value of each group.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from gearbow._types import Array, At, ComplexArray, Section, Side
from gearbow.analysis.protocol import S, System, silent, variant
from gearbow.description.bow import Bow, amplitude_of, scaled
from gearbow.description.shafts import Shaft
from gearbow.results.section_forces import shaft_of
from gearbow.results.stresses import Tones
from gearbow.results.synchronous import Synchronous

#: Amplitude of the bows [m], small on every shaft. Elements depend on the shape only, as the
#: response is linear.
_AMPLITUDE = 1e-6


def with_elements_for(system: S, *cases: Mapping[str, Bow]) -> S:
    """Make a system with fixed elements, as fine as if the bows of any case were its own."""
    # The bows of a case, by shaft, act at the same time, without those of other shafts.
    shafts: list[dict[str, Any]] = system._model.resolved()["shafts"]
    for bows in cases:
        largest = max(map(amplitude_of, bows.values()), default=0.0)
        if largest > 0.0:
            own = {name: scaled(bow, _AMPLITUDE / largest) for name, bow in bows.items()}
            bent = [replace(shaft, bow=own.get(shaft.name)) for shaft in system.shafts]
            chosen = variant(system, shafts=bent)._model.resolved()["shafts"]
            shafts = [_finer(a, b) for a, b in zip(shafts, chosen, strict=True)]
    return variant(system, shafts=[Shaft._from_description(shaft) for shaft in shafts])


def _finer(given: dict[str, Any], other: dict[str, Any]) -> dict[str, Any]:
    """Give a shaft, or a segment of one, the larger numbers and degrees of elements of two."""
    numbers = {
        key: max(given[key], other[key])
        for key in ("elements", "degree")
        if given.get(key) is not None and other.get(key) is not None
    }
    if given.get("segments"):
        pairs = zip(given["segments"], other["segments"], strict=True)
        numbers["segments"] = [_finer(*pair) for pair in pairs]
    return {**given, **numbers}


#: Instants of one turn of the fastest shaft of a group. A maximum between two of them is missed by
#: at most 1 − cos(π/72) = 0.1 % of an orbit.
_INSTANTS = 72
#: Largest number of turns of the fastest shaft in the common period of a group. With more, the
#: angles come closer than a turn/72 to every pair of angles: within 1 − cos(π/36) = 0.4 %.
_GROUP_TURNS = 36
#: Phases of the worst phase: within 1 − cos(π/36) = 0.4 % of the orbit.
_PHASES = 36
#: Most passes over the phases of several shafts, one shaft after the other. A pass that changes
#: nothing is the last one.
_PHASE_PASSES = 8
#: Change of a margin over the phases that the distance of instants and phases explains.
_SAME_MARGIN = 5e-3
#: Part of a turn by which shafts may miss a common period.
_SAME_TURN = 1e-6
#: Instants of a mean over groups. The mean of |F|³ of three orbits of equal size is within 0.1 %.
_MEAN_INSTANTS = 8192

#: Margins for a size of the bows [m] and phases, (phases, bowed shafts): (phases,).
Margin = Callable[[float, Array], Array]


@dataclass(frozen=True, eq=False)
class BowSignal:
    """A signal of c components: its static value, and its motion at the instants of each group."""

    static: Array
    #: For each group, the motion without the bows, (instants, c).
    others: tuple[Array, ...]
    #: For each bowed shaft, its group, and the motion for the bow 1, (instants, c).
    groups: tuple[int, ...]
    units: tuple[ComplexArray, ...]

    def curves(self, bow: float, phases: Array) -> list[Array]:
        """Give the motion of each group, (phases, instants, c)."""
        # With a phase of NaN, a bow has every angle to the others: it is a group of its own.
        found = [each[None] for each in self.others]
        for shaft, (group, unit) in enumerate(zip(self.groups, self.units, strict=True)):
            if np.isnan(phases[0, shaft]):
                angles = 2.0 * math.pi * np.arange(_INSTANTS) / _INSTANTS
                found.append(bow * np.real(np.outer(np.exp(1j * angles), unit[0]))[None])
                continue
            turned = np.exp(1j * phases[:, shaft])[:, None, None] * unit
            found[group] = found[group] + bow * np.real(turned)
        return found

    def instants(self, bow: float, phases: Array) -> Array:
        """Give values at instants with the frequency of each in time, (phases, instants, c)."""
        curves = self.curves(bow, phases)
        if len(curves) == 1:
            return self.static + curves[0]
        # Additive recurrence with the powers of the generalised golden ratio, g^(n+1) = g + 1.
        golden = 2.0
        for _ in range(64):
            golden = (1.0 + golden) ** (1.0 / (len(curves) + 1.0))
        values: Array = self.static[None, None]
        for number, curve in enumerate(curves):
            part = (np.arange(_MEAN_INSTANTS) * golden ** -(number + 1.0)) % 1.0
            values = values + curve[:, (part * curve.shape[1]).astype(int)]
        return values

    def largest(self, bow: float, phases: Array, directions: Array) -> Array:
        """Give the largest absolute component along directions (c, d) over time, (phases,)."""
        sums = [(each @ directions) for each in self.curves(bow, phases)]
        above = sum(each.max(axis=1) for each in sums)
        below = sum(each.min(axis=1) for each in sums)
        rest = self.static @ directions
        found: Array = np.maximum(rest + above, -rest - below).max(axis=-1)
        return found

    @property
    def size(self) -> float:
        """Largest value of the motion for the bow 1, at most."""
        return float(sum(np.abs(unit).max(initial=0.0) for unit in self.units))


class Variants:
    """A system with any size of the bows of some shafts, on the same elements."""

    def __init__(
        self,
        system: System,
        shafts: Sequence[str],
        bows: Sequence[Bow],
        phases: tuple[float, ...] | None,
    ) -> None:
        # The elements must not follow the loads: all variants have the same coordinates.
        self.base: System = with_elements_for(system, dict(zip(shafts, bows, strict=True)))
        self.shafts = tuple(shafts)
        largest = max(map(amplitude_of, bows))
        self.bows = [scaled(bow, 1.0 / largest) for bow in bows]
        self.phases = phases
        self.straight: System = self._bent([None] * len(bows))

    def bent(self, size: float, phases: Sequence[float]) -> System:
        """Give the system with bows of a size [m], turned by their phases."""
        turned = zip(self.bows, phases, strict=True)
        return self._bent([scaled(bow, size, phase) for bow, phase in turned])

    def _bent(self, bows: Sequence[Bow | None]) -> System:
        own = dict(zip(self.shafts, bows, strict=True))
        shafts = [replace(each, bow=own.get(each.name, each.bow)) for each in self.base.shafts]
        made: System = variant(self.base, shafts=shafts)
        return made

    def responses(self, speeds: Array) -> tuple[Synchronous, Synchronous]:
        """Give the response without these bows, and that to bows of the size 1 alone."""
        size = _AMPLITUDE
        alone = [replace(each, bow=scaled(self._own(each.name), size)) for each in self.base.shafts]
        parts = silent(self.base) | {"shafts": alone}
        unit = variant(self.base, **parts).synchronous(speeds, excitation="bow")
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
        self._bowed = [names.index(name) for name in variants.shafts]
        excites = np.abs(self._others.amplitudes[index]).max(axis=1, initial=0.0) > 0.0
        sources = [i for i in range(len(names)) if excites[i] or i in self._bowed]
        #: Shafts of each group, and e^{iϑ_s} of all shafts at its instants, (instants, shafts).
        self._groups = locked_groups(self.ratios, sources)
        self._phasors = [self._turning(group) for group in self._groups]
        self._group_of = [
            next(n for n, group in enumerate(self._groups) if shaft in group)
            for shaft in self._bowed
        ]
        #: Bowed shafts whose phase can matter: something else turns at a locked angle.
        self._free = [
            i
            for i, (shaft, group) in enumerate(zip(self._bowed, self._group_of, strict=True))
            if variants.phases is None and (excites[shaft] or len(self._groups[group]) > 1)
        ]

    def _turning(self, group: list[int]) -> ComplexArray:
        fastest = float(np.abs(self.ratios[group]).max())
        turns = _common_turns(self.ratios[group])
        assert turns is not None
        count = _INSTANTS * turns
        angles = 2.0 * math.pi * turns * np.arange(count) / (count * fastest)
        phasors: ComplexArray = np.exp(1j * np.outer(angles, self.ratios))
        return phasors

    def displacement(self, at: At) -> BowSignal:
        """Give the displacement of a place [m]."""
        return self._of(self.static.displacement(at), lambda each: each.displacement(at))

    def relative(self, at: At, base: At) -> BowSignal:
        """Give the displacement of a place relative to another one [m]."""
        return self._of(
            self.static.displacement(at) - self.static.displacement(base),
            lambda each: each.displacement(at) - each.displacement(base),
        )

    def velocity(self, at: At) -> BowSignal:
        """Give the velocity of a place [m/s]."""
        return self._of(np.zeros(2), lambda each: each.velocity(at))

    def forces_in_sections(self, at: At) -> tuple[list[Section], Callable[[float, Array], Tones]]:
        """Give the sections at a place, and their forces for a bow [m] and phases (shafts,)."""
        shaft, positions = shaft_of(self.variants.base.coordinates, at)
        model = self.variants.base._model
        sections = [section for section, _ in model.sections(shaft, positions)]
        sides: list[Side] = ["beyond" if side == "beyond" else "before" for *_, side in sections]
        # Section forces need the motion to the bow that the system has.
        bent = replace(self._unit, amplitudes=_AMPLITUDE * self._unit.amplitudes)
        standing, others, unit = (
            np.stack([each.section_forces(at, side).values for side in sides], axis=-2)
            for each in (self.static, self._others, bent)
        )
        unit = unit / _AMPLITUDE

        def tones(bow: float, phases: Array) -> Tones:
            found = others[self._index].copy()
            turned = zip(self._bowed, np.nan_to_num(phases), strict=True)
            for source, phase in turned:
                found[source] += bow * np.exp(1j * phase) * unit[self._index, source]
            frequencies = self.ratios * self.speed
            spin = float(frequencies[self._others.shafts.index(shaft)])
            return Tones(standing, found, frequencies, spin)

        return sections, tones

    def bearing_force(self, at: tuple[str, float]) -> BowSignal:
        """Give the force on a bearing [N]."""
        return self._of(self.static.bearing_force(at), lambda each: each.bearing_force(at))

    def rows(self, static: Array, rows: Array, added: ComplexArray) -> BowSignal:
        """Give static values and linear combinations `rows` of all coordinates, (c, n)."""
        # `added` turns with each shaft and is no displacement, (shafts, c).
        return self._of(static, lambda each: each.amplitudes @ rows.T, added)

    def _of(
        self,
        static: Array,
        values: Callable[[Synchronous], ComplexArray],
        added: ComplexArray | float = 0.0,
    ) -> BowSignal:
        others, unit = (values(each)[self._index] for each in (self._others, self._unit))
        others = others + added
        return BowSignal(
            np.asarray(static, dtype=np.float64),
            tuple(
                np.real(turning[:, group] @ others[group])
                for turning, group in zip(self._phasors, self._groups, strict=True)
            ),
            tuple(self._group_of),
            tuple(
                np.outer(self._phasors[group][:, shaft], unit[shaft])
                for group, shaft in zip(self._group_of, self._bowed, strict=True)
            ),
        )

    def smallest(self, margin: Margin, bow: float, *, of_instants: bool) -> float:
        """Find the smallest margin over the phases; `of_instants` is that of `Check`."""
        if not of_instants:
            return self.worst(margin, bow)[0]
        phases = np.array(self.variants.phases or np.zeros(len(self._bowed)))
        phases[self._free] = math.nan
        return float(margin(bow, phases[None])[0])

    def worst(self, margin: Margin, bow: float) -> tuple[float, Array]:
        """Find the smallest margin, and the phase of each bowed shaft, NaN if it has no effect."""
        given = self.variants.phases
        phases = np.array(given or np.zeros(len(self._bowed)))
        smallest = float(margin(bow, phases[None])[0])
        if given is not None:
            return smallest, phases
        found = np.full(phases.size, math.nan)
        whole = float(margin(0.0, phases[None])[0]) if self._free else 0.0
        grid = 2.0 * math.pi * np.arange(_PHASES) / _PHASES
        for _ in range(_PHASE_PASSES if len(self._free) > 1 else 1):
            before = smallest
            for shaft in self._free:
                tried = np.tile(phases, (_PHASES, 1))
                tried[:, shaft] = grid
                values = margin(bow, tried)
                best = int(np.argmin(values))
                smallest, phases[shaft] = float(values[best]), grid[best]
                matters = np.ptp(values) >= _SAME_MARGIN * abs(whole)
                found[shaft] = grid[best] if matters else math.nan
            if smallest == before:
                break
        return smallest, found


def locked_groups(ratios: Array, shafts: Sequence[int]) -> list[list[int]]:
    """Divide shafts into groups whose angles have a short common period."""
    groups: list[list[int]] = []
    for shaft in shafts:
        for group in groups:
            if _common_turns(ratios[[*group, shaft]]) is not None:
                group.append(shaft)
                break
        else:
            groups.append([shaft])
    return groups


def _common_turns(ratios: Array) -> int | None:
    """Find the turns of the fastest shaft after which shafts with these speeds are in phase."""
    relative = np.abs(ratios) / np.abs(ratios).max()
    for turns in range(1, _GROUP_TURNS + 1):
        angles = turns * relative
        if np.all(np.abs(angles - np.round(angles)) < _SAME_TURN * turns):
            return turns
    return None
