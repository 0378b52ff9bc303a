"""Peaks of the synchronous response, and their separation margins after API RP 684."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gearbow._convert import BYTES, number
from gearbow._shown import Shown
from gearbow.errors import SceneError

__all__ = ["Peak"]

#: A response with a smaller amplification factor is critically damped and needs no separation.
CRITICALLY_DAMPED = 2.5


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
        Speed N₁ between standstill and the peak with 1/√2 of the peak amplitude [rad/s]; NaN if
        the range of speeds does not contain it.
    upper : float
        Speed N₂ beyond the peak with 1/√2 of the peak amplitude [rad/s]; NaN as above.
    operating : float or tuple of (float, float), optional
        Operating speed, or the lowest and the highest, of one sign and not zero [rad/s]. The
        attribute is a pair.
    stable : bool
        Whether every mode has positive damping at the speed of the peak. An unstable rotor does
        not show this peak: a mode grows until something else limits it.

    Raises
    ------
    SceneError
        If the operating speeds are zero, not finite, of both signs or in descending order.

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

        Returns
        -------
        float
            The factor; NaN if N₁ or N₂ is unknown.
        """
        width = abs(self.upper - self.lower)
        return math.inf if width == 0.0 else abs(self.speed) / width

    @property
    def separation_margin(self) -> float:
        """Distance between the peak and the operating speeds.

        Returns
        -------
        float
            Percent of the nearest operating speed; 0 within the operating range, NaN without one.
        """
        span = self._forward()
        if span is None:
            return math.nan
        speed, low, high = span
        return 100.0 * max((low - speed) / low, (speed - high) / high, 0.0)

    @property
    def required_margin(self) -> float:
        """Separation margin that API RP 684 requires.

        Returns
        -------
        float
            With the amplification factor AF: 17 (1 − 1/(AF − 1.5)) percent below the operating
            speeds, 10 percent more above them, and 0 for AF < 2.5. NaN if AF or the operating
            speeds are unknown.
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

        Returns
        -------
        bool
            Also False if the required margin is unknown.
        """
        sufficient = self.required_margin == 0.0 or self.separation_margin >= self.required_margin
        return self.stable and sufficient


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
