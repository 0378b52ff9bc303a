"""A peak of the synchronous response, and how far API RP 684 wants it from the operating speed."""

from dataclasses import dataclass

import numpy as np

__all__ = ["Peak"]

#: Below this amplification factor a response is critically damped: no separation is required.
CRITICALLY_DAMPED = 2.5


@dataclass(frozen=True)
class Peak:
    """A peak of the synchronous response, in the terms of API RP 684.

    Parameters
    ----------
    speed : float
        N_c: speed of the reference shaft [rad/s].
    amplitude : float
        Largest semi-axis of the orbit there [m].
    lower : float
        N₁, where the response is 1/√2 of it below [rad/s]; NaN where the range ends before.
    upper : float
        N₂, the same above [rad/s].
    operating : tuple of (float, float) or None
        Lowest and highest operating speed [rad/s].

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
    operating: tuple[float, float] | None = None

    @property
    def amplification_factor(self) -> float:
        """N_c/(N₂ − N₁).

        Returns
        -------
        float
            The factor; NaN where the range ends before the response has fallen.
        """
        return self.speed / (self.upper - self.lower)

    @property
    def separation_margin(self) -> float:
        """Distance from the operating speeds.

        Returns
        -------
        float
            Percent of the nearest operating speed; 0 among them, NaN where none was given.
        """
        if self.operating is None:
            return float("nan")
        low, high = self.operating
        return 100.0 * max((low - self.speed) / low, (self.speed - high) / high, 0.0)

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
        factor = self.amplification_factor
        if self.operating is None or np.isnan(factor):
            return float("nan")
        if factor < CRITICALLY_DAMPED:
            return 0.0
        margin = 17.0 * (1.0 - 1.0 / (factor - 1.5))
        return margin if self.speed < self.operating[0] else 10.0 + margin

    @property
    def acceptable(self) -> bool:
        """Whether the separation is what is required.

        Returns
        -------
        bool
            False too where the required margin is not known.
        """
        return self.required_margin == 0.0 or self.separation_margin >= self.required_margin
