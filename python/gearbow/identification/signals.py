"""1× vibration in signals, in windows of whole revolutions."""

from collections.abc import Mapping
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from gearbow._convert import array, shown, whole
from gearbow._types import Array
from gearbow.errors import SceneError
from gearbow.sensors.probe import Probe
from gearbow.sensors.tacho import Tacho

__all__ = ["windows"]

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
