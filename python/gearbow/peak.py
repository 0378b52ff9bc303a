"""A peak of the synchronous response, and how far API RP 684 wants it from the operating speed."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gearbow._convert import number
from gearbow.errors import SceneError

__all__ = ["Peak"]

#: Below this amplification factor a response is critically damped: no separation is required.
CRITICALLY_DAMPED = 2.5


@dataclass(frozen=True)
class Peak:
    """A peak of the synchronous response, in the terms of API RP 684.

    Parameters
    ----------
    speed : float
        N_c: speed of the reference shaft [rad/s]; negative where the shaft turns backwards.
    amplitude : float
        Largest semi-axis of the orbit there [m].
    lower : float
        N₁, the speed between standstill and the peak where the response is 1/√2 of it [rad/s]; NaN
        where the range ends before.
    upper : float
        N₂, the same beyond the peak [rad/s].
    operating : float or tuple of (float, float), optional
        Operating speed, or the lowest and the highest, of one sign and not zero [rad/s]; kept as
        two.

    Raises
    ------
    SceneError
        If the operating speeds are zero, not finite, of both signs or in descending order.

    Notes
    -----
    A rotor that turns backwards is judged like its mirror image, which turns forwards. A peak in
    the other sense of rotation than the operating speeds is far from them: the distance counts
    through standstill.

    Examples
    --------
    Halfway between critically damped and undamped, a peak 20 % below the operating speed:

    >>> import gearbow as gb
    >>> peak = gb.Peak(80.0, 1e-4, lower=75.0, upper=91.0, operating=(100.0, 100.0))
    >>> print(f"{peak.amplification_factor:.0f}: {peak.separation_margin:.0f} % of "
    ...       f"{peak.required_margin:.1f} %, {peak.acceptable}")
    5: 20 % of 12.1 %, True
    """

    speed: float
    amplitude: float
    lower: float
    upper: float
    operating: float | tuple[float, float] | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "operating", operating_range(self.operating))

    @property
    def amplification_factor(self) -> float:
        """N_c/(N₂ − N₁), positive for either sense of rotation.

        Returns
        -------
        float
            The factor; NaN where the range ends before the response has fallen.
        """
        width = abs(self.upper - self.lower)
        return math.inf if width == 0.0 else abs(self.speed) / width

    @property
    def separation_margin(self) -> float:
        """Distance from the operating speeds.

        Returns
        -------
        float
            Percent of the nearest operating speed; 0 among them, NaN where none was given.
        """
        span = self._forward()
        if span is None:
            return math.nan
        speed, low, high = span
        return 100.0 * max((low - speed) / low, (speed - high) / high, 0.0)

    @property
    def required_margin(self) -> float:
        """Separation that API RP 684 requires.

        Returns
        -------
        float
            With AF the amplification factor, 17 (1 − 1/(AF − 1.5)) percent below the operating
            speeds, 10 more above them, 0 where AF < 2.5; NaN where AF or the operating speeds are
            not known.
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
        """Give N_c, the lowest and the highest operating speed, mirrored to operate forwards."""
        span = operating_range(self.operating)
        if span is None:
            return None
        sense = math.copysign(1.0, span[0])
        return sense * self.speed, abs(span[0]), abs(span[1])

    @property
    def acceptable(self) -> bool:
        """Whether the separation is what is required.

        Returns
        -------
        bool
            False too where the required margin is not known.
        """
        return self.required_margin == 0.0 or self.separation_margin >= self.required_margin


def operating_range(given: object) -> tuple[float, float] | None:
    """Read an operating speed, or a range of them.

    Parameters
    ----------
    given : float, (float, float) or None
        One speed, or the lowest and the highest [rad/s].

    Returns
    -------
    tuple of (float, float) or None
        The speeds nearest to and farthest from standstill.

    Raises
    ------
    SceneError
        If they are no speeds to operate at, or the highest comes first.
    """
    if given is None:
        return None
    speeds = (
        given
        if isinstance(given, Sequence | np.ndarray) and not isinstance(given, str)
        else [given]
    )
    if len(speeds) not in (1, 2):
        raise SceneError(f"operating: must be one speed or (lowest, highest), got {given!r}")
    low, high = number(speeds[0], "operating"), number(speeds[-1], "operating")
    if not (math.isfinite(low) and math.isfinite(high)):
        raise SceneError(f"operating: must be finite, got {given!r}")
    if low == 0.0 or high == 0.0 or (low > 0.0) != (high > 0.0):
        raise SceneError(f"operating: must be above 0, or below 0 throughout, got {given!r}")
    # Backwards both orders are clear: (-700, -200) ascends, (-200, -700) begins at standstill.
    if low > high > 0.0:
        raise SceneError(f"operating: the lowest speed comes first, got {given!r}")
    return (low, high) if abs(low) <= abs(high) else (high, low)
