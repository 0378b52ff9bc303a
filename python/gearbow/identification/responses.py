"""Responses of a system to unit unknowns, at the probes of measurements.

The 1× response is linear in bow, unbalance and run-out. Each shaft excites the train at its own
speed, so that one analysis gives the response to one unknown of every shaft.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Generic, TypeAlias

import numpy as np

from gearbow._convert import nearest, shown
from gearbow._shown import ReadOnly
from gearbow._types import Array, At, ComplexArray
from gearbow.analysis.balance import (
    bodies_with,
    body_of,
    with_unbalances,
    without_unbalance,
)
from gearbow.analysis.bow_motion import with_elements_for
from gearbow.analysis.protocol import S, System, variant, without_scene_warnings
from gearbow.description.bow import Bow, scaled
from gearbow.description.layout import ratios_by_shaft, shafts_of_bodies
from gearbow.description.places import place_label
from gearbow.description.shafts import Shaft, segments_of
from gearbow.description.train import Parameter
from gearbow.errors import SceneError
from gearbow.identification.measurement import Measurement
from gearbow.identification.unknown import (
    BowUnknown,
    ParameterUnknown,
    RunoutUnknown,
    UnbalanceUnknown,
    Unknown,
)
from gearbow.results.synchronous import Synchronous
from gearbow.sensors import Probe

#: Reads amplitudes of a response that some shafts cause, turned by a complex factor.
Reader: TypeAlias = Callable[[Synchronous, Sequence[str], complex], ComplexArray]
#: Amplitudes of the unit excitations [m] and [kg m]. The response is linear; these are small on
#: every rotor, so that no displacement looks too large.
_UNIT = {"m": 1e-6, "kg m": 1e-9}


@dataclass(frozen=True, eq=False)
class Term:
    """A complex amplitude in which the response is linear, and the shaft that turns with it."""

    name: str
    shaft: str
    unit: str
    prior: float | None = None
    bow: Bow | None = None
    plane: At | None = None
    probe: Probe | None = None


@dataclass(frozen=True)
class MeasuredChannel:
    """What one probe measures: place, direction, phase reference and its angle at phase zero."""

    shaft: str
    position: float
    angle: float
    support: str | None
    reference: str
    phase_angle: float

    @property
    def probe(self) -> tuple[str, float, float, str | None]:
        """Give what tells a probe from others."""
        return (self.shaft, self.position, self.angle, self.support)


@dataclass(frozen=True, eq=False)
class LinearModel(ReadOnly, Generic[S]):
    """A system with nodes at all probes and planes, its terms, and the rows of measurements."""

    base: S
    terms: tuple[Term, ...]
    trials: tuple[Term, ...]
    parameters: tuple[ParameterUnknown, ...]
    channels: tuple[MeasuredChannel, ...]
    labels: tuple[str, ...]
    speeds: Array
    #: Channel, index of the speed, amplitude [m], measurement and (row, column) there, by row.
    channel: Any
    speed: Any
    measured: ComplexArray
    cells: Any
    #: Known unbalances of each row [kg m], shape (rows, trials).
    weights: ComplexArray
    #: The last answer of `rows`, by the values of the parameters, for any measured amplitudes.
    last: dict[tuple[float, ...], tuple[ComplexArray, ComplexArray]] = field(default_factory=dict)

    @classmethod
    def of(
        cls, system: S, measurements: Sequence[Measurement], unknowns: Sequence[Unknown]
    ) -> "LinearModel[S]":
        """Make the model of a system, measurements and unknowns."""
        ratios = ratios_by_shaft(system)
        channels: dict[MeasuredChannel, int] = {}
        probes: dict[Any, Probe] = {}
        labels: list[str] = []
        rows: list[tuple[int, float, complex, int, int, int, Mapping[At, complex]]] = []
        for m, measured in enumerate(measurements):
            ratio = _ratio(ratios, measured.speed_shaft)
            for j, (probe, reference) in enumerate(
                zip(measured.probes, measured.references, strict=True)
            ):
                for name in (probe.shaft, reference):
                    _known_shaft(name, ratios, f"measured[{m}].probes[{j}]")
                angle = measured.phase_angle
                channel = MeasuredChannel(
                    probe.shaft, probe.position, probe.angle, probe.support, reference, angle
                )
                if channel not in channels:
                    channels[channel] = len(channels)
                    labels.append(measured.labels[j])
                probes.setdefault(channel.probe, probe)
                for i in np.flatnonzero(np.isfinite(measured.amplitudes[:, j])).tolist():
                    row = (measured.speeds[i] / ratio, complex(measured.amplitudes[i, j]))
                    rows.append((channels[channel], *row, m, i, j, measured.trial_weights))
        speeds, index = np.unique([row[1] for row in rows], return_inverse=True)
        if speeds.size < 2:
            raise SceneError(
                f"measured: needs at least two speeds, got {speeds.size}: at one speed, bow, "
                "unbalance and run-out look the same"
            )
        planes = list(dict.fromkeys(at for row in rows for at in row[6]))
        trials = tuple(_unbalance_term(system, at, None, "trial_weights") for at in planes)
        terms, parameters = _terms(system, unknowns, probes)
        base = _with_nodes(system, terms + trials, channels)
        return cls(
            base,
            terms,
            trials,
            parameters,
            tuple(channels),
            tuple(labels),
            speeds,
            np.array([row[0] for row in rows]),
            index,
            np.array([row[2] for row in rows]),
            np.array([row[3:6] for row in rows]),
            np.array([[row[6].get(at, 0.0) for at in planes] for row in rows]).reshape(
                len(rows), -1
            ),
        )

    def with_parameters(self, values: Sequence[float]) -> S:
        """Give the base system with other values of the parameters."""
        return with_numbers(self.base, self.parameters, values) if self.parameters else self.base

    def starts(self) -> list[float]:
        """Give the expected value of each parameter, or that in the system."""
        found = []
        for each in self.parameters:
            value = each.prior[0] if each.prior else _number(self.base, each).value
            if value == 0.0:
                raise SceneError(
                    f"{each.path}: is 0 in the system; give its expected value by prior="
                )
            found.append(value)
        return found

    def rows(self, values: Sequence[float]) -> tuple[ComplexArray, ComplexArray]:
        """Find `rows_of` for values of the parameters; once for equal values in succession."""
        key = tuple(values)
        if key not in self.last:
            found = self.rows_of(self.with_parameters(key))
            self.last.clear()
            self.last[key] = found
        return self.last[key]

    def rows_of(self, system: S) -> tuple[ComplexArray, ComplexArray]:
        """Find known amplitudes, (rows,), and those by terms of 1 and i, (rows, terms, 2)."""
        known, units = self.responses(system, self.speeds, self._at_channels)
        rows = (self.speed, self.channel)
        total = known[rows]
        columns = np.zeros((self.channel.size, len(self.terms), 2), dtype=np.complex128)
        for j, term in enumerate((*self.terms, *self.trials)):
            of = self._of_runout(term.probe) if term.probe is not None else units[j]
            if j < len(self.terms):
                columns[:, j] = of[rows]
            else:
                weight = self.weights[:, j - len(self.terms)]
                total = total + weight.real * of[rows][:, 0] + weight.imag * of[rows][:, 1]
        return total, columns

    def responses(
        self, system: S, speeds: Array, read: Reader
    ) -> tuple[ComplexArray, dict[int, ComplexArray]]:
        """Read the known response, and those to bows and unbalances of 1 and i on the last axis."""
        terms = (*self.terms, *self.trials)
        known = read(system.synchronous(speeds), [shaft.name for shaft in system.shafts], 1.0)
        bare = _without_excitation(system)
        queues: dict[str, list[int]] = {}
        for j, term in enumerate(terms):
            if term.probe is None:
                queues.setdefault(term.shaft, []).append(j)
        units: dict[int, ComplexArray] = {}
        while any(queues.values()):
            now = [waiting.pop(0) for waiting in queues.values() if waiting]
            found = _excited(bare, [terms[j] for j in now]).synchronous(speeds)
            for j in now:
                unit = [read(found, [terms[j].shaft], turn) for turn in (1.0, 1j)]
                units[j] = np.stack(unit, axis=-1) / _UNIT[terms[j].unit]
        return known, units

    def _at_channels(
        self, found: Synchronous, shafts: Sequence[str], turn: complex
    ) -> ComplexArray:
        """Read the measured amplitudes (speeds, channels) that some sources cause."""
        ratios = ratios_by_shaft(self.base)
        result = np.zeros((found.speeds.size, len(self.channels)), dtype=np.complex128)
        for c, channel in enumerate(self.channels):
            moved = found.displacement((channel.shaft, channel.position))
            if channel.support is not None:
                moved = moved - found.displacement(channel.support)
            towards = moved @ np.array([np.cos(channel.angle), np.sin(channel.angle)])
            for name in shafts:
                amplitudes = turn * towards[:, found.shafts.index(name)]
                result[:, c] += _as_measured(amplitudes, channel, name, ratios, found.speeds)
        return result

    def _of_runout(self, probe: Probe) -> ComplexArray:
        """Give amplitudes (speeds, channels, 2) that run-outs of 1 and i below a probe cause."""
        result = np.zeros((self.speeds.size, len(self.channels), 2), dtype=np.complex128)
        ratios = ratios_by_shaft(self.base)
        key = (probe.shaft, probe.position, probe.angle, probe.support)
        for c, channel in enumerate(self.channels):
            if channel.probe == key:
                for i, unit in enumerate((1.0, 1j)):
                    turned = np.full(self.speeds.size, unit * np.exp(-1j * probe.angle))
                    result[:, c, i] = _as_measured(
                        turned, channel, probe.shaft, ratios, self.speeds
                    )
        return result


def _as_measured(
    amplitudes: ComplexArray,
    channel: MeasuredChannel,
    source: str,
    ratios: Mapping[str, float],
    speeds: Array,
) -> ComplexArray:
    """Convert amplitudes over the angle of a source to those over a phase that grows in time."""
    # A source at another speed than that of the phase reference is at another order.
    own, other = ratios[channel.reference], ratios[source]
    if not np.isclose(abs(own), abs(other), rtol=1e-9):
        return np.zeros_like(amplitudes)
    turned = amplitudes * np.exp(1j * (other / own) * channel.phase_angle)
    measured: ComplexArray = np.where(other * speeds > 0.0, turned, np.conj(turned))
    return measured


def _ratio(ratios: Mapping[str, float], shaft: str | None) -> float:
    """Give the speed of a shaft over that of the reference shaft, without its sign."""
    if shaft is None:
        return 1.0
    _known_shaft(shaft, ratios, "measured.speed_shaft")
    return abs(ratios[shaft])


def _known_shaft(name: str, ratios: Mapping[str, float], path: str) -> None:
    if name not in ratios:
        raise SceneError(f'{path}: no shaft is called "{name}"{nearest(name, ratios)}')


def _terms(
    system: System, unknowns: Sequence[Unknown], probes: Mapping[Any, Probe]
) -> tuple[tuple[Term, ...], tuple[ParameterUnknown, ...]]:
    """Split unknowns into complex amplitudes and parameters."""
    shafts = {shaft.name: shaft for shaft in system.shafts}
    terms: list[Term] = []
    parameters: list[ParameterUnknown] = []
    for i, each in enumerate(unknowns):
        path = f"unknowns[{i}]"
        if isinstance(each, BowUnknown):
            _known_shaft(each.shaft, dict.fromkeys(shafts, 0.0), path)
            terms += _bow_terms(each, shafts[each.shaft], path)
        elif isinstance(each, UnbalanceUnknown):
            terms.append(_unbalance_term(system, each.at, each.prior, path))
        elif isinstance(each, RunoutUnknown):
            for probe in probes.values():
                name = f"run-out of {probe.label}"
                terms.append(Term(name, probe.shaft, "m", each.prior, probe=probe))
        elif isinstance(each, ParameterUnknown):
            _number(system, each, path)
            parameters.append(each)
        else:
            raise SceneError(f"{path}: must be made by gb.unknown, got {shown(each)}")
    names = [term.name for term in terms] + [each.path for each in parameters]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise SceneError(f"unknowns: {twice} occurs twice")
    return tuple(terms), tuple(parameters)


def _length(shaft: Shaft) -> float:
    return float(sum(segment.length for segment in segments_of(shaft)))


def _unit_bow(length: float, points: Sequence[float] | None, index: int) -> Bow:
    """Give the shape with this number and the amplitude 1 m."""
    if points is None:
        return Bow.mode(index + 1, 1.0)
    deflections = [1.0 if i == index else 0.0 for i in range(len(points))]
    return Bow.points([0.0, *points, length], [0.0, *deflections, 0.0])


def _bow_terms(each: BowUnknown, shaft: Shaft, path: str) -> list[Term]:
    length = _length(shaft)
    if each.points is None:
        names = [f"half wave {k + 1}" for k in range(each.shapes)]
    else:
        ordered = [0.0, *each.points, length]
        if not np.diff(ordered).min() > 0.0:
            raise SceneError(
                f"{path}.points: must ascend strictly between 0 and {length:g} m, got {each.points}"
            )
        names = [f"{x:g} m" for x in each.points]
    joint = ", " if each.points is None else " at "
    terms = []
    for k, name in enumerate(names):
        bow = _unit_bow(length, each.points, k)
        terms.append(Term(f"bow of {each.shaft}{joint}{name}", each.shaft, "m", each.prior, bow))
    return terms


def _unbalance_term(system: System, at: At, prior: float | None, path: str) -> Term:
    if isinstance(at, str):
        bodies = shafts_of_bodies(system)
        if at not in bodies:
            raise SceneError(
                f'{path}: no gear or disk is called "{at}"{nearest(at, bodies)}; another place is '
                "(shaft, position)"
            )
        shaft = bodies[at]
    else:
        shaft = at[0]
        _known_shaft(shaft, dict.fromkeys((s.name for s in system.shafts), 0.0), path)
    return Term(f"unbalance of {place_label(at)}", shaft, "kg m", prior, plane=at)


def _with_nodes(system: S, terms: Sequence[Term], channels: Iterable[MeasuredChannel]) -> S:
    """Make the system with a node at every place, fixed elements, and zero in place of unknowns."""
    zero = {term.plane: 0.0 for term in terms if term.plane is not None}
    places: dict[At, complex] = dict.fromkeys(
        [(channel.shaft, channel.position) for channel in channels], 0.0
    )
    with without_scene_warnings():
        bows = [{term.shaft: term.bow} for term in terms if term.bow is not None]
        found = with_elements_for(with_unbalances(system, {**places, **zero}), *bows)
        bowed = {name for each in bows for name in each}
        shafts = [replace(s, bow=None) if s.name in bowed else s for s in found.shafts]
        changes = bodies_with(found, {body_of(at): 0.0 for at in zero})
        changes["shafts"] = shafts
        made: S = found.replace(**changes)
    return made


def _without_excitation(system: S) -> S:
    changes = without_unbalance(system)
    changes["shafts"] = [replace(shaft, bow=None) for shaft in system.shafts]
    with without_scene_warnings():
        made: S = system._variation(**changes)
    return made


def _excited(bare: S, terms: Sequence[Term]) -> S:
    """Give the system with unit terms, of different shafts."""
    bows = {term.shaft: scaled(term.bow, _UNIT["m"]) for term in terms if term.bow is not None}
    planes = {body_of(term.plane): _UNIT["kg m"] for term in terms if term.plane is not None}
    changes = bodies_with(bare, planes)
    changes["shafts"] = [replace(shaft, bow=bows.get(shaft.name)) for shaft in bare.shafts]
    with without_scene_warnings():
        made: S = bare._variation(**changes)
    return made


def assembled(system: S, model: LinearModel[S], values: Sequence[complex]) -> S:
    """Put values of the terms into a system, in place of its own bows and unbalances."""
    curves: dict[str, Any] = {}
    bodies: dict[str, complex] = {}
    planes: dict[At, complex] = {}
    for term, value in zip(model.terms, values, strict=True):
        if term.bow is not None:
            curves.setdefault(term.shaft, []).append((term.bow, value))
        elif term.plane is not None:
            bodies[body_of(term.plane)] = 0.0
            planes[term.plane] = value
    with without_scene_warnings():
        changes = bodies_with(system, bodies)
        changes["shafts"] = [
            replace(shaft, bow=_sum(curves[shaft.name], _length(shaft)))
            if shaft.name in curves
            else shaft
            for shaft in system.shafts
        ]
        made: S = with_unbalances(system.replace(**changes), planes)
    return made


def _sum(parts: Sequence[tuple[Bow, complex]], length: float) -> Bow:
    """Add shapes of one family with complex amplitudes."""
    first = parts[0][0]
    if first.positions is not None:
        total = np.sum([np.array(bow.amplitudes) * value for bow, value in parts], axis=0)
        return Bow.points(first.positions, np.abs(total), np.angle(total))
    if len(parts) == 1:
        return Bow.mode(first.number or 1, abs(parts[0][1]), float(np.angle(parts[0][1])))
    waves = [(bow.number or 1, value) for bow, value in parts]
    return Bow.function(
        lambda x: sum(value * complex(np.sin(k * np.pi * x / length)) for k, value in waves)
    )


def with_numbers(system: S, unknowns: Sequence[ParameterUnknown], values: Sequence[float]) -> S:
    """Give a checked system with values of unknown parameters."""
    changes: dict[str, Any] = {}
    for unknown, value in zip(unknowns, values, strict=True):
        number = _number(system, unknown)
        owner = changes.get(number.key, getattr(system, number.key))
        changes[number.key] = number.changed(owner, value)
    return variant(system, **changes)


def _number(system: System, unknown: ParameterUnknown, where: str = "unknowns") -> Parameter:
    return Parameter.find(lambda key: getattr(system, key), unknown.path, where, several=True)
