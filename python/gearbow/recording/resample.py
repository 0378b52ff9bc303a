"""Sampling of a recorded run at a lower rate, with a low-pass filter against aliasing.

The filter is a sinc function of the cut-off frequency 0.45 of the new rate in the window of Kaiser
(Oppenheim and Schafer, *Discrete-time signal processing*, 1989, section 7.4). It is symmetric, so
that it shifts no phase, and is evaluated at any time between the recorded ones.

New samples are equally spaced in time, or in the angle of a shaft. The filter then acts over the
angle: its integral over the angle is a sum over the recorded times, with the speed as weight.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from gearbow._convert import number
from gearbow._times import crossings
from gearbow._types import Array
from gearbow.errors import GearbowError
from gearbow.recording import access
from gearbow.recording.channels import signals, with_signals
from gearbow.recording.record import RunRecord

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
#: Weights that are held in memory at once, and largest number of new samples with one window.
_WEIGHTS, _BLOCK = 4_000_000, 256


def resampled(run: RunRecord, rate: float, shaft: str | None = None) -> RunRecord:
    """Filter and sample the signals of a recorded run."""
    low_pass = LowPass.of(run, number(rate, "rate"), shaft)
    found = signals(run.data)
    filtered = dict(zip(found, low_pass.apply(list(found.values())), strict=True))
    return replace(run, data=with_signals(run.data, low_pass.times, filtered))


@dataclass(frozen=True, eq=False)
class LowPass:
    """The filter, and the new samples that it gives."""

    # The position of a recorded sample counts the new samples: rate · time, or samples in a
    # revolution · revolutions. New samples are where it is a whole number.
    #: New samples in a second, or in a revolution of a shaft.
    rate: float
    #: Times of the new samples [s], and their positions.
    times: Array
    whole_numbers: Array
    #: Positions of the recorded samples, and a weight in proportion to their rate of change.
    positions: Array
    density: Array

    @classmethod
    def of(cls, run: RunRecord, rate: float | None, shaft: str | None = None) -> "LowPass":
        """Make the filter for a rate [Hz], or for samples in a revolution of a shaft."""
        time, step = run.time, _step(run.time)

        def turned(t: Array) -> Array:
            """Give what is divided into samples: seconds, or revolutions of the shaft."""
            return t if shaft is None else sense * access.angle(run, shaft, t) / (2.0 * np.pi)

        def speed(t: Array) -> Array:
            """Give the rate of `turned`."""
            if shaft is None:
                return np.ones_like(t)
            return sense * access.spin(run, shaft, t) / (2.0 * np.pi)

        sense = 1.0 if shaft is None or access.spin(run, shaft).sum() >= 0.0 else -1.0
        density, unit = speed(time), "Hz" if shaft is None else f"in a revolution of {shaft!r}"
        fastest = float(density.max())
        most = math.inf if fastest == 0.0 else 1.0 / (fastest * step)
        rate = float(math.floor(most)) if rate is None else rate
        if not 0.0 < rate <= most * (1.0 + _EQUAL):
            raise GearbowError(
                f"rate: must be positive and at most that of the recording, {most:.6g} {unit}, "
                f"got {rate:.6g}; give a shorter output_step to simulate"
            )
        positions = rate * turned(time)
        begin, end = positions[0] + _HALF_LENGTH, positions[-1] - _HALF_LENGTH
        first = math.ceil(begin - 1e-12 * abs(begin))
        last = math.floor(end + 1e-12 * abs(end))
        if last < first:
            what = "s" if shaft is None else f"revolutions of {shaft!r}"
            raise GearbowError(
                f"resample: the recording of {np.ptp(positions) / rate:.3g} {what} is shorter than "
                f"the filter for {rate:.6g} {unit}, {2.0 * _HALF_LENGTH / rate:.3g} {what}; "
                "simulate for longer"
            )
        whole_numbers = np.arange(first, last + 1, dtype=np.float64)
        if shaft is None:
            return cls(rate, whole_numbers / rate, whole_numbers, positions, density)
        times = crossings(time[[0, -1]], lambda t: rate * turned(t), lambda t: rate * speed(t))
        times = times[first - math.ceil(positions[0]) :][: whole_numbers.size]
        return cls(rate, times, whole_numbers, positions, density)

    def apply(self, arrays: Sequence[Array]) -> list[Array]:
        """Filter arrays over the recorded times."""
        size = arrays[0].shape[0]
        columns = np.hstack([values.reshape(size, -1) for values in arrays])
        found = np.empty((self.whole_numbers.size, columns.shape[1]))
        first = np.searchsorted(self.positions, self.whole_numbers - _HALF_LENGTH)
        end = np.searchsorted(self.positions, self.whole_numbers + _HALF_LENGTH, "right")
        at = 0
        while at < found.shape[0]:
            taps = int((end - first)[at : at + _BLOCK].max())
            count = min(_BLOCK, max(1, _WEIGHTS // (taps * max(1, columns.shape[1]))))
            part = slice(at, at + count)
            starts = np.minimum(first[part], size - taps)
            windows = sliding_window_view(columns, taps, axis=0)[starts]
            weights = self._weights(self.whole_numbers[part], starts, taps)
            found[part] = np.einsum("mt,mct->mc", weights, windows)
            at += count
        counts = np.cumsum([values[0].size for values in arrays])[:-1]
        parts = np.split(found, counts, axis=1)
        return [
            part.reshape(found.shape[0], *values.shape[1:])
            for part, values in zip(parts, arrays, strict=True)
        ]

    def _weights(self, numbers: Array, starts: NDArray[np.intp], taps: int) -> Array:
        """Give the weights of the recorded samples from the first one on, for every new sample."""
        indices = starts[:, np.newaxis] + np.arange(taps)
        x = self.positions[indices] - numbers[:, np.newaxis]
        inside = np.clip(1.0 - (x / _HALF_LENGTH) ** 2, 0.0, None)
        weights = np.sinc((PASS + STOP) * x) * np.i0(_BETA * np.sqrt(inside))
        weights *= self.density[indices]
        weights[np.abs(x) > _HALF_LENGTH] = 0.0
        # A constant signal passes exactly.
        normal: Array = weights / weights.sum(axis=1, keepdims=True)
        return normal


def _step(time: Array) -> float:
    """Give the interval between the recorded times."""
    steps = np.diff(time)
    if steps.size < 2 or np.ptp(steps) > _EQUAL * abs(steps[0]) or not steps[0] > 0.0:
        raise GearbowError("resample: needs equally spaced times; give output_step to simulate")
    return float(time[-1] - time[0]) / steps.size
