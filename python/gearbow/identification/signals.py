"""1× vibration in signals, in windows of whole revolutions."""

import math
from collections.abc import Mapping
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from gearbow._convert import array, shown, whole
from gearbow._files import parsing
from gearbow._types import Array
from gearbow.errors import SceneError
from gearbow.exchange.universal import DataSet, data_sets, units_of
from gearbow.sensors import Probe, Tacho

#: Types of data set 58: a function of time, and a displacement.
_OVER_TIME, _DISPLACEMENT = 1, 8
#: Angle of a probe by the direction of its node.
_ANGLES = {2: 0.0, 3: math.pi / 2.0}

#: Degree of the polynomial of the angle over time within a window: its speed may change with the
#: square of the time.
_ANGLE_DEGREE = 3


def windows(
    time: "ArrayLike",
    signals: Mapping[Probe, "ArrayLike"],
    pulses: Mapping[Tacho, "ArrayLike"],
    revolutions: int,
) -> dict[str, Any]:
    """Fit the 1× vibration in each window; give arguments of `Measurement`."""
    times = array(time, "time")
    expected: tuple[tuple[str, Any, type], ...] = (
        ("signals", signals, Probe),
        ("pulses", pulses, Tacho),
    )
    for name, given, kind in expected:
        if not isinstance(given, Mapping) or not all(isinstance(each, kind) for each in given):
            raise SceneError(
                f"{name}: must be a mapping of gb.{kind.__name__} to numbers, got {shown(given)}"
            )
    turns = whole(revolutions, "revolutions", least=2)
    values = np.column_stack([array(each, "signals") for each in signals.values()])
    if values.shape[0] != times.size or not np.diff(times).min(initial=1.0) > 0.0:
        raise SceneError("time: must ascend, with one time for each sample of the signals")
    if not pulses or len({tacho.angle for tacho in pulses}) != 1:
        raise SceneError("pulses: needs one tachometer for each shaft, all at the same angle")
    for tacho in pulses:
        if tacho.pulses != 1:
            raise SceneError(
                f"pulses: the tachometer of {tacho.shaft} has {tacho.pulses} marks, which do not "
                "say which one is the phase reference; give one pulse per revolution"
            )
    marks = {tacho.shaft: array(each, "pulses", least=0) for tacho, each in pulses.items()}
    first, main = next(iter(pulses)), next(iter(marks.values()))
    bounds = main[::turns]
    if bounds.size < 2:
        raise SceneError(
            f"pulses: {turns} revolutions need {turns + 1} pulses of {first.shaft}, got "
            f"{main.size}; give a smaller number of revolutions"
        )
    shafts = list(marks)
    references = [probe.shaft if probe.shaft in shafts else first.shaft for probe in signals]
    own = [shafts.index(name) for name in references]
    speeds, rows = [], []
    for begin, end in pairwise(bounds):
        inside = (times >= begin) & (times < end)
        angles = [_angle(shaft, found, begin, end, times[inside]) for shaft, found in marks.items()]
        columns = [np.ones(int(inside.sum()))]
        columns += [wave(angle) for angle in angles for wave in (np.cos, np.sin)]
        if columns[0].size < 2 * len(columns):
            raise SceneError(
                f"time: a window of {turns} revolutions has {columns[0].size} samples, too few for "
                f"{len(columns)} amplitudes"
            )
        fitted = np.linalg.lstsq(np.column_stack(columns), values[inside], rcond=None)[0]
        vectors = fitted[1::2] - 1j * fitted[2::2]
        rows.append([vectors[shaft, i] for i, shaft in enumerate(own)])
        speeds.append(2.0 * np.pi * turns / (end - begin))
    return {
        "speeds": np.array(speeds),
        "amplitudes": np.array(rows),
        "probes": tuple(signals),
        "references": references,
        "phase_angle": first.angle,
        "speed_shaft": first.shaft,
    }


def _angle(shaft: str, pulses: Array, begin: float, end: float, times: Array) -> Array:
    """Interpolate the angle since a pulse, with a pulse on each side of the window."""
    first = max(int(np.searchsorted(pulses, begin, side="right")) - 1, 0)
    near = pulses[first : int(np.searchsorted(pulses, end)) + 1]
    if near.size < _ANGLE_DEGREE + 1:
        raise SceneError(
            f"pulses: a window must contain at least {_ANGLE_DEGREE + 1} pulses of {shaft}, got "
            f"{near.size}; give more revolutions"
        )
    polynomial = np.polynomial.Polynomial.fit(near, np.arange(near.size), _ANGLE_DEGREE)
    angle: Array = 2.0 * np.pi * polynomial(times)
    return angle


def read_signals(
    path: Path, channels: Mapping[int, Any]
) -> tuple[Array, dict[Probe, Array], dict[Tacho, Array]]:
    """Read time, signals and pulses of a universal file by the nodes of its time histories."""
    times: list[Array] = []
    signals: dict[Probe, Array] = {}
    pulses: dict[Tacho, Array] = {}
    sets = list(data_sets(path))
    with parsing(path, "a universal file"):
        units = units_of(sets)
        for one in sets:
            function = one.function() if one.kind == 58 else None
            if function is None or function.kind != _OVER_TIME:
                continue
            node, axis = function.response
            given, values = channels.get(node), function.values.real
            if isinstance(given, Tacho):
                pulses[given] = _pulses(one, function.abscissa, values)
            elif given is not None:
                quantity = function.quantities[1]
                if quantity.kind != _DISPLACEMENT:
                    raise SceneError(
                        f"{one.where}: must be a displacement (ordinate {_DISPLACEMENT}), has "
                        f"{quantity.kind}; leave node {node} out, or integrate it before"
                    )
                if not isinstance(given, Probe):
                    if abs(axis) not in _ANGLES:
                        raise SceneError(
                            f"{one.where}: the direction {axis} is neither y nor z; give a gb.Probe"
                        )
                    given = Probe(*given, angle=_ANGLES[abs(axis)])
                if times and not np.array_equal(times[0], function.abscissa):
                    raise SceneError(f"{one.where}: must have the times of the first signal")
                if any(given.label == other.label for other in signals):
                    raise SceneError(f"{one.where}: is a second signal of {given.label}")
                times.append(function.abscissa)
                factor = units.factor(quantity, _DISPLACEMENT, one.where)
                signals[given] = math.copysign(factor, axis) * values
    if not signals:
        raise SceneError(
            f"{path}: has no time history (data set 58, function type {_OVER_TIME}) of the nodes "
            f"in channels={shown(dict(channels))}"
        )
    return times[0], signals, pulses


def _pulses(given: DataSet, time: Array, signal: Array) -> Array:
    """Find where a signal rises through the middle of its range."""
    level = 0.5 * float(signal.min() + signal.max())
    before = np.flatnonzero((signal[:-1] < level) & (signal[1:] >= level))
    part = (level - signal[before]) / (signal[before + 1] - signal[before])
    found: Array = time[before] + part * (time[before + 1] - time[before])
    turns = np.diff(found)
    if turns.size and turns.min() < 0.5 * float(np.median(turns)):
        raise SceneError(
            f"{given.where}: pulses at unequal distances, the shortest {turns.min():.3g} s; the "
            "signal needs one clean rise per revolution"
        )
    return found
