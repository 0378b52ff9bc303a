"""Sampling of a recorded run at a lower rate, with a low-pass filter against aliasing.

The filter is a sinc function of the cut-off frequency 0.45 of the new rate in the window of Kaiser
(Oppenheim and Schafer, *Discrete-time signal processing*, 1989, section 7.4). It is symmetric, so
that it shifts no phase, and is evaluated at any time between the recorded ones.
"""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from gearbow._convert import number
from gearbow._types import Array
from gearbow.errors import GearbowError
from gearbow.recording.record import RunRecord
from gearbow.recording.tables import OPTIONAL

__all__ = ["PASS", "STOP", "resampled"]

#: Frequencies up to which signals pass, and from which they are suppressed, as fractions of the new
#: rate. The second one is the highest frequency that the new rate represents.
PASS, STOP = 0.4, 0.5
#: Suppression, and deviation of the passed amplitudes, 80 dB.
_RIPPLE = 1e-4
#: Length of the filter on both sides, in new samples, and the parameter of the window for it, by
#: the formulas of Kaiser.
_ATTENUATION = -20.0 * math.log10(_RIPPLE)
_HALF_LENGTH = (_ATTENUATION - 7.95) / (2.285 * 2.0 * math.pi * (STOP - PASS)) / 2.0
_BETA = 0.1102 * (_ATTENUATION - 8.7)
#: Largest relative difference of the intervals between recorded times.
_EQUAL = 1e-6
#: Weights that are held in memory at once.
_WEIGHTS = 4_000_000


def resampled(run: RunRecord, rate: float) -> RunRecord:
    """Filter and sample the signals of a recorded run."""
    low_pass = _Filter(run.data["time"], number(rate, "rate"))
    data: Any = run.data
    names = ("displacement", "twist", "bearing_force", "rolling_contact", "energy", *OPTIONAL)
    signals: dict[tuple[str, ...], Array] = {
        (name,): data[name] for name in names if data.get(name) is not None
    }
    for name in ("mesh", "energy_terms"):
        signals |= {(name, key): values for key, values in (data[name] or {}).items()}
    filtered = dict(zip(signals, low_pass.apply(list(signals.values())), strict=True))
    arrays: dict[str, Any] = {"time": low_pass.times}
    for path, values in filtered.items():
        owner = arrays if len(path) == 1 else arrays.setdefault(path[0], {})
        owner[path[-1]] = values
    sampled: Any = {**data, **arrays}
    return replace(run, data=sampled)


class _Filter:
    """Weights of the recorded samples for every new sample."""

    def __init__(self, time: Array, rate: float) -> None:
        steps = np.diff(time)
        if steps.size < 2 or np.ptp(steps) > _EQUAL * abs(steps[0]) or not steps[0] > 0.0:
            raise GearbowError("resample: needs equally spaced times; give output_step to simulate")
        self.step = float(time[-1] - time[0]) / steps.size
        if not 0.0 < rate * self.step <= 1.0 + _EQUAL:
            raise GearbowError(
                f"rate: must be positive and at most that of the recording, {1.0 / self.step:.6g} "
                f"Hz, got {rate:.6g} Hz; give a shorter output_step to simulate"
            )
        self.rate, self.begin = rate, float(time[0])
        reach = _HALF_LENGTH / rate
        first = math.ceil((time[0] + reach) * rate * (1.0 - 1e-12))
        last = math.floor((time[-1] - reach) * rate * (1.0 + 1e-12))
        if last < first:
            raise GearbowError(
                f"resample: the recording of {time[-1] - time[0]:.3g} s is shorter than the filter "
                f"for {rate:.6g} Hz, {2.0 * reach:.3g} s; simulate for longer"
            )
        self.times: Array = np.arange(first, last + 1) / rate
        self.taps = min(math.ceil(2.0 * reach / self.step) + 1, time.size)

    def apply(self, arrays: Sequence[Array]) -> list[Array]:
        """Filter arrays over the recorded times."""
        size = arrays[0].shape[0]
        columns = np.hstack([values.reshape(size, -1) for values in arrays])
        windows = sliding_window_view(columns, self.taps, axis=0)
        found = np.empty((self.times.size, columns.shape[1]))
        block = max(1, _WEIGHTS // (self.taps * max(1, columns.shape[1])))
        for at in range(0, self.times.size, block):
            first, weights = self._weights(self.times[at : at + block], size)
            found[at : at + block] = np.einsum("mt,mct->mc", weights, windows[first])
        counts = np.cumsum([values[0].size for values in arrays])[:-1]
        parts = np.split(found, counts, axis=1)
        return [
            part.reshape(self.times.size, *values.shape[1:])
            for part, values in zip(parts, arrays, strict=True)
        ]

    def _weights(self, times: Array, size: int) -> tuple[NDArray[np.intp], Array]:
        """Give the first recorded sample that each new one takes, and the weights from there on."""
        position = (times - self.begin) / self.step
        first = np.rint(position - (self.taps - 1) / 2.0).astype(np.intp)
        first = np.clip(first, 0, size - self.taps)
        indices = first[:, np.newaxis] + np.arange(self.taps)
        x = (indices - position[:, np.newaxis]) * (self.step * self.rate)
        inside = np.clip(1.0 - (x / _HALF_LENGTH) ** 2, 0.0, None)
        weights = np.sinc((PASS + STOP) * x) * np.i0(_BETA * np.sqrt(inside))
        weights[np.abs(x) > _HALF_LENGTH] = 0.0
        # A constant signal passes exactly.
        return first, weights / weights.sum(axis=1, keepdims=True)
