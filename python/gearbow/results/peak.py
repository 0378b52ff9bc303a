"""Peaks of the synchronous response, and their separation margins after API RP 684."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, overload

import numpy as np

from gearbow._convert import BYTES, number
from gearbow._result import Column, Figured, WithSpeeds, in_micrometres
from gearbow._shown import ReadOnly, Shown
from gearbow._types import Array, At
from gearbow.description.places import place_label
from gearbow.errors import SceneError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: A response with a smaller amplification factor is critically damped and needs no separation.
CRITICALLY_DAMPED = 2.5

#: Where the amplitude stays above the half-power one, by what a peak lacks.
_STAYS = {
    "no N₁": "from standstill or the lowest speed to the peak",
    "no N₂": "from the peak to the last speed; give speeds beyond it",
    "no N₁ and N₂": "at all speeds on both sides; give more speeds",
}


@dataclass(frozen=True)
class Peak(Shown):
    """A peak of the synchronous response, with the quantities of API RP 684.

    Parameters
    ----------
    speed : float
        Speed N_c of the reference shaft [rad/s]; negative for backward rotation.
    amplitude : float
        Major semi-axis of the orbit at the peak [m].
    lower : float
        Speed N₁ nearer to standstill with 1/√2 of its amplitude [rad/s]; NaN outside the range.
    upper : float
        Speed N₂ beyond the peak with 1/√2 of the peak amplitude [rad/s]; NaN as above.
    operating : float or tuple of (float, float), optional
        Operating speed, or the lowest and highest, of one sign [rad/s]; kept as a pair.
    stable : bool
        Whether every mode has positive damping at the speed of the peak. An unstable rotor does
        not show this peak: a mode grows until something else limits it.

    Notes
    -----
    Backward rotation is treated like forward rotation of the mirrored rotor. For a peak with the
    opposite sense of rotation to the operating speeds, the distance includes the standstill.

    Examples
    --------
    A peak 20 % below the operating speed:

    >>> import gearbow as gb
    >>> peak = gb.results.Peak(80.0, 1e-4, lower=75.0, upper=91.0, operating=(100.0, 100.0))
    >>> print(f"{peak.amplification_factor:.0f}: {peak.separation_margin:.0f} % of "
    ...       f"{peak.required_margin:.1f} %, {peak.acceptable}")
    5: 20 % of 12.1 %, True
    """

    speed: float
    amplitude: float
    lower: float
    upper: float
    operating: float | tuple[float, float] | None = None
    stable: bool = True

    def __post_init__(self) -> None:
        object.__setattr__(self, "operating", operating_range(self.operating))

    @property
    def amplification_factor(self) -> float:
        """Amplification factor N_c/(N₂ − N₁), positive for both senses of rotation.

        It is NaN if N₁ or N₂ is unknown.
        """
        width = abs(self.upper - self.lower)
        return math.inf if width == 0.0 else abs(self.speed) / width

    @property
    def missing(self) -> str | None:
        """What the amplification factor lacks: "no N₁", "no N₂" or both; None if it is known.

        N₁ is missing if the amplitude does not fall to 1/√2 of the peak between standstill and the
        peak, as where a bow is large; N₂ if it does not beyond the peak within the speeds of the
        response.
        """
        ends = {"N₁": self.lower, "N₂": self.upper}
        unknown = " and ".join(name for name, speed in ends.items() if math.isnan(speed))
        return f"no {unknown}" if unknown else None

    @property
    def separation_margin(self) -> float:
        """Distance between the peak and the nearest operating speed, in percent of this speed.

        It is 0 within the operating range, and NaN without one.
        """
        span = self._forward()
        if span is None:
            return math.nan
        speed, low, high = span
        return 100.0 * max((low - speed) / low, (speed - high) / high, 0.0)

    @property
    def required_margin(self) -> float:
        """Separation margin that API RP 684 requires [%].

        With the amplification factor AF: 17 (1 − 1/(AF − 1.5)) below the operating speeds, 10 more
        above them, and 0 for AF < 2.5. NaN if AF or the operating speeds are unknown.
        """
        factor, span = self.amplification_factor, self._forward()
        if span is None or np.isnan(factor):
            return math.nan
        if factor < CRITICALLY_DAMPED:
            return 0.0
        margin = 17.0 * (1.0 - 1.0 / (factor - 1.5))
        speed, low, _ = span
        return margin if speed < low else 10.0 + margin

    def _forward(self) -> tuple[float, float, float] | None:
        """Give N_c, the lowest and the highest operating speed, mirrored to forward rotation."""
        span = operating_range(self.operating)
        if span is None:
            return None
        sense = math.copysign(1.0, span[0])
        return sense * self.speed, abs(span[0]), abs(span[1])

    @property
    def acceptable(self) -> bool:
        """Whether the motion at the peak is stable and the separation margin is sufficient.

        Also False if the required margin is unknown.
        """
        sufficient = self.required_margin == 0.0 or self.separation_margin >= self.required_margin
        return self.stable and sufficient

    @property
    def verdict(self) -> str:
        """Whether the peak is acceptable, and if not, why.

        One of "acceptable", "critically damped", "too close", "unstable", "no operating speed", or
        "unknown" if the range of speeds does not contain N₁ or N₂.
        """
        if not self.stable:
            return "unstable"
        if self.amplification_factor < CRITICALLY_DAMPED:
            return "critically damped"
        if self.operating is None:
            return "no operating speed"
        if math.isnan(self.required_margin):
            return "unknown"
        return "acceptable" if self.acceptable else "too close"


@dataclass(frozen=True, eq=False)
class Peaks(WithSpeeds, Figured, ReadOnly, Sequence[Peak]):
    """The peaks of the synchronous response at a place: a sequence of `Peak` with a table.

    `plot` draws a Bode diagram, phase above amplitude, with the operating speeds, in which each
    peak has its amplification factor.

    Parameters
    ----------
    peaks : tuple of Peak
        The peaks, by ascending speed.
    at : str or tuple of (str, float)
        The place.
    source : str
        The shaft that excites.
    speeds : ndarray, shape (speeds,)
        Speeds of the response [rad/s].
    phase, amplitude : ndarray, shape (speeds,)
        Phase [rad] and major semi-axis [m] of the orbit.
    operating : tuple of (float, float), optional
        Lowest and highest operating speed [rad/s].

    Examples
    --------
    >>> import numpy as np
    >>> import gearbow as gb
    >>> system = gb.examples()["bowed_rotor"].load()
    >>> response = system.synchronous(np.linspace(10.0, 400.0, 60))
    >>> print(response.peaks("disk", operating=400.0))
    peaks of disk, excited by rotor; operating speed 400 rad/s
    speed [rad/s]  amplitude [µm]  amplification factor  margin [%]  required margin [%]  verdict
           279.49            7080                 750.3       30.13                16.98  acceptable
    """

    peaks: tuple[Peak, ...]
    at: At
    source: str
    speeds: Array = field(repr=False)
    phase: Array = field(repr=False)
    amplitude: Array = field(repr=False)
    operating: tuple[float, float] | None = None

    @overload
    def __getitem__(self, index: int) -> Peak: ...
    @overload
    def __getitem__(self, index: slice) -> Sequence[Peak]: ...
    def __getitem__(self, index: int | slice) -> Peak | Sequence[Peak]:
        return self.peaks[index]

    def __len__(self) -> int:
        return len(self.peaks)

    def __eq__(self, other: object) -> bool:
        # As a list of peaks.
        return isinstance(other, list | tuple | Peaks) and list(self) == list(other)

    def __hash__(self) -> int:
        return hash(self.peaks)

    def _draw(self, ax: Any) -> "Figure":
        from gearbow.plotting import harmonic  # noqa: PLC0415

        label = place_label(self.at)
        return harmonic.bode(
            {label: harmonic.Curve(self.speeds, self.amplitude, self.phase)},
            "m",
            peaks={label: marks(self.peaks)},
            operating=self.operating,
            ax=ax,
        )

    def _heading(self) -> list[str]:
        text = f"peaks of {place_label(self.at)}, excited by {self.source}"
        if self.operating is not None:
            ends = dict.fromkeys(self._speed_text(speed) for speed in self.operating)
            text += f"; operating speed {' to '.join(ends)}"
        return [text]

    def _columns(self) -> list[Column]:
        def values(name: str) -> Array:
            return np.array([getattr(peak, name) for peak in self.peaks], dtype=np.float64)

        return [
            Column("speed", values("speed"), "rad/s", ".2f"),
            Column("amplitude", values("amplitude"), "m", ".4g", in_micrometres()),
            Column("amplification factor", values("amplification_factor")),
            Column("margin", values("separation_margin"), "%"),
            Column("required margin", values("required_margin"), "%"),
            Column("verdict", [peak.verdict for peak in self.peaks]),
        ]

    def _remarks(self) -> list[str]:
        """Say why peaks have no amplification factor."""
        return [
            f"peak {number}: {peak.missing}, because the amplitude stays above 1/√2 of the peak "
            f"{_STAYS[peak.missing]}"
            for number, peak in enumerate(self.peaks, 1)
            if peak.missing is not None
        ]

    def __repr__(self) -> str:
        speeds = self._speed_text([peak.speed for peak in self.peaks])
        where = f"{place_label(self.at)}, excited by {self.source}"
        return f"Peaks({len(self)} of {where}: {speeds})"


def marks(peaks: Sequence[Peak]) -> list[tuple[float, float, str | None]]:
    """Give speed, amplitude and text of peaks for a figure; half-power points have no text."""
    root, found = math.sqrt(0.5), []
    for peak in peaks:
        factor = peak.amplification_factor
        text = peak.missing or f"AF {float(f'{factor:.3g}'):g}"
        points = ((peak.lower, root, None), (peak.speed, 1.0, text), (peak.upper, root, None))
        found += [(x, y * peak.amplitude, own) for x, y, own in points if math.isfinite(x)]
    return found


def operating_range(given: object) -> tuple[float, float] | None:
    """Check an operating speed or a range of operating speeds."""
    if given is None:
        return None
    speeds = (
        given
        if isinstance(given, Sequence | np.ndarray) and not isinstance(given, (str, *BYTES))
        else [given]
    )
    if len(speeds) not in (1, 2):
        raise SceneError(f"operating: must be one speed or (lowest, highest), got {given!r}")
    low, high = number(speeds[0], "operating"), number(speeds[-1], "operating")
    if not (math.isfinite(low) and math.isfinite(high)):
        raise SceneError(f"operating: must be finite, got {given!r}")
    if low == 0.0 or high == 0.0 or (low > 0.0) != (high > 0.0):
        raise SceneError(f"operating: must be above 0, or below 0 throughout, got {given!r}")
    # Both orders are valid for backward rotation: (-700, -200) ascends in value, (-200, -700) in
    # absolute value.
    if low > high > 0.0:
        raise SceneError(f"operating: the lowest speed comes first, got {given!r}")
    return (low, high) if abs(low) <= abs(high) else (high, low)
