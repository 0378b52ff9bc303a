"""Limits of the bow of a shaft."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from gearbow._result import Column, Figured, WithSpeeds, in_degrees, in_micrometres
from gearbow._shown import ReadOnly, Shown
from gearbow._types import Array

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class ReachedLimit(Shown):
    """The bow at which one limit is reached at one speed.

    Parameters
    ----------
    limit, at : str
        The limit, for example "backlash used up", and its mesh, bearing or place.
    speed : float
        Speed of the reference shaft [rad/s].
    bow : float
        Size of the bow [m]: 0 if the limit is exceeded without bow, infinite if it is not reached.
    phase : float
        Angle by which the shape is turned in the shaft [rad], the worst one or the given one; NaN
        where every phase has the same limit. With several shafts, that of the first one.
    why : str
        Value of the limit, or the reason why it is not reached.
    phases : tuple of float
        The phase of each bowed shaft [rad].

    Examples
    --------
    >>> import gearbow as gb
    >>> found = gb.results.ReachedLimit("backlash used up", "g1/g2", 100.0, 2e-4)
    >>> found.is_reached
    True
    """

    limit: str
    at: str
    speed: float
    bow: float
    phase: float = math.nan
    why: str = ""
    phases: tuple[float, ...] = ()

    @property
    def is_reached(self) -> bool:
        """Whether some bow reaches the limit, so that it is finite."""
        return math.isfinite(self.bow)


@dataclass(frozen=True, eq=False)
class BowLimits(WithSpeeds, Figured, ReadOnly):
    """The bow at which each limit is reached, and the margin to the present bow.

    `plot` draws the seven smallest limits over the speed, and the present bow.

    Parameters
    ----------
    shafts : tuple of str
        The bowed shafts.
    present : float
        Size of the present bow [m]: its amplitude, or the largest of its points.
    speeds : ndarray, shape (speeds,)
        Speeds of the reference shaft [rad/s].
    found : tuple of ReachedLimit
        Every limit at every speed, the speeds of a limit after each other.
    phase : tuple of float or None
        Given phase of each bowed shaft [rad]; None is the worst phase.
    left_out : tuple of str
        Excitations of the system that this result does not contain.

    Notes
    -----
    The table has the smallest bow of each limit over the speeds, the data frame every speed.

    Examples
    --------
    >>> import gearbow as gb
    >>> system = gb.examples()["bowed_rotor"].load()
    >>> probe = gb.BowLimit.displacement("disk", 100e-6)
    >>> found = system.bow_limits("rotor", gb.rpm(1000), limits=[probe])
    >>> f"{1e6 * found.deciding.bow:.1f} µm"
    '49.6 µm'
    """

    shafts: tuple[str, ...]
    present: float
    speeds: Array
    found: tuple[ReachedLimit, ...]
    phase: tuple[float, ...] | None = None
    left_out: tuple[str, ...] = ()

    @property
    def limits(self) -> tuple[ReachedLimit, ...]:
        """Each limit at the speed with the smallest bow, by ascending bow."""
        # Round-off does not choose among equal limits.
        smallest = map(_smallest, self._series_of_limits())
        return tuple(sorted(smallest, key=lambda one: float(f"{one.bow:.9g}")))

    @property
    def deciding(self) -> ReachedLimit | None:
        """The limit with the smallest bow, which decides; None if no bow reaches a limit."""
        first = min(self.found, key=lambda one: one.bow, default=None)
        return first if first is not None and first.is_reached else None

    @property
    def margin(self) -> float:
        """The bow of the deciding limit minus the present one [m]; negative where exceeded."""
        return math.inf if self.deciding is None else self.deciding.bow - self.present

    def _draw(self, ax: Any) -> "Figure":
        from gearbow.plotting import analyses as figures  # noqa: PLC0415

        lines = {
            f"{own[0].limit}, {own[0].at}": np.array([one.bow for one in own])
            for own in self._series_of_limits()
        }
        order = [f"{one.limit}, {one.at}" for one in self.limits]
        return figures.bow_limits(
            self.speeds,
            {name: lines[name] for name in order},
            self.present,
            label=f"bow of {', '.join(self.shafts)}",
            ax=ax,
        )

    def _series_of_limits(self) -> list[tuple[ReachedLimit, ...]]:
        """Give the speeds of each limit."""
        count = self.speeds.size
        return [self.found[i : i + count] for i in range(0, len(self.found), count)]

    def _columns(self) -> list[Column]:
        return self._columns_of(self.limits)

    def _series(self) -> list[Column]:
        return self._columns_of(self.found)

    def _columns_of(self, rows: Sequence[ReachedLimit]) -> list[Column]:
        bows = np.array([one.bow for one in rows])
        return [
            Column("limit", [one.limit for one in rows]),
            Column("at", [one.at for one in rows]),
            Column("speed", np.array([one.speed for one in rows]), "rad/s", ".5g"),
            Column("bow", _known(bows), "m", ".4g", in_micrometres()),
            Column("margin", _known(bows - self.present), "m", ".4g", in_micrometres()),
            *self._phase_columns(rows),
            Column("why", [one.why for one in rows]),
        ]

    def _phase_columns(self, rows: Sequence[ReachedLimit]) -> list[Column]:
        several = len(self.shafts) > 1
        return [
            Column(
                f"phase {shaft}" if several else "phase",
                np.array([one.phases[i] if one.phases else math.nan for one in rows]),
                "rad",
                ".0f",
                in_degrees(),
            )
            for i, shaft in enumerate(self.shafts)
        ]

    def _heading(self) -> list[str]:
        ends = dict.fromkeys(self._speed_text(float(s)) for s in self.speeds[[0, -1]])
        phase = "worst phase"
        if self.phase is not None:
            phase = f"phase {', '.join(f'{math.degrees(one):.4g}°' for one in self.phase)}"
        first = f"limits of the bow of {', '.join(self.shafts)} at {' to '.join(ends)}, {phase}"
        return [f"{first}; present bow {1e6 * self.present:.4g} µm"]

    def _remarks(self) -> list[str]:
        first = self.deciding
        if first is None:
            return ["no bow reaches a limit"]
        return [f"decides: {first.limit}, {first.at}, at {1e6 * first.bow:.4g} µm"]

    def __repr__(self) -> str:
        reached = sum(one.is_reached for one in self.limits)
        text = f"{', '.join(self.shafts)}: {reached} of {len(self.limits)} limits reached"
        return f"BowLimits({text}; {self._remarks()[0]})"


def _known(values: Array) -> Array:
    """Give NaN for a limit that is not reached; tables write "–"."""
    return np.where(np.isfinite(values), values, np.nan)


def _smallest(own: Sequence[ReachedLimit]) -> ReachedLimit:
    return min(own, key=lambda one: one.bow)
