"""Campbell diagram: natural frequencies against the speed, and stability thresholds."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gearbow._extras import extra
from gearbow._result import Column, Result, WithSpeeds, in_percent
from gearbow._shown import ReadOnly, Shown
from gearbow._types import Array, CampbellData, ComplexArray
from gearbow.results.peak import operating_range
from gearbow.units.speed import SpeedUnit

if TYPE_CHECKING:
    from matplotlib.figure import Figure


#: Smallest ratio of a growth rate Re λ to |λ| that counts as unstable; round-off causes smaller
#: ones. The core has the same limit.
_MIN_GROWTH = 1e-6


@dataclass(frozen=True)
class StabilityThreshold(Shown):
    """A speed at which the damping of a mode changes its sign.

    Parameters
    ----------
    mode : int
        Number of the mode in the diagram, from 0.
    speed : float
        Speed of the reference shaft [rad/s].
    frequency_hz : float
        Frequency [Hz] of the mode at this speed, with which it oscillates at the threshold.
    whirl : str
        Whirl of the mode at this speed.
    above : {"unstable", "stable"}
        The mode at speeds farther from zero; unstable means a negative damping ratio.
    residual : float
        The larger one of ``|Re λ|/|λ|`` and the residual of the mode, as `Modes.residuals`.

    Examples
    --------
    The cross-coupled stiffness of a seal grows with the speed:

    >>> import gearbow as gb
    >>> seal = gb.SpeedTable([0.0, 400.0], [[[2e7, 0], [0, 2e7]], [[2e7, 4e6], [-4e6, 2e7]]])
    >>> bearings = [gb.Bearing("rotor", x, stiffness=seal, damping=5e3) for x in (0.0, 1.0)]
    >>> rotor = gb.Shaft("rotor", length=1.0, outer_diameter=0.1)
    >>> disk = gb.Disk("disk", "rotor", 0.5, 20.0, 0.1, 0.2)
    >>> system = gb.RotorSystem([rotor], disks=[disk], bearings=bearings)
    >>> threshold = system.campbell([0.0, 200.0, 400.0], count=2).thresholds[0]
    >>> print(f"{threshold.speed:.1f} rad/s: {threshold.whirl}, {threshold.above} above")
    289.8 rad/s: forward, unstable above
    """

    mode: int
    speed: float
    frequency_hz: float
    whirl: str
    above: str
    residual: float


def unstable_ranges(
    speeds: Array, eigenvalues: ComplexArray, thresholds: Sequence[StabilityThreshold]
) -> tuple[tuple[float, float], ...]:
    """Find the ranges of speeds at which a mode is unstable."""
    found: list[tuple[float, float]] = []
    for mode in range(eigenvalues.shape[1]):
        own = [one for one in thresholds if one.mode == mode]
        growing = eigenvalues[:, mode].real > _MIN_GROWTH * np.abs(eigenvalues[:, mode])
        # The mode changes at its thresholds; between them its state at any speed holds.
        ends = np.array([speeds[0], *(one.speed for one in own), speeds[-1]])
        for low, high in pairwise(ends):
            before = next((one.above == "unstable" for one in own if one.speed == low), None)
            after = next((one.above == "stable" for one in own if one.speed == high), None)
            given = [state for state in (before, after) if state is not None]
            if given[0] if given else bool(growing.any()):
                found.append((float(low), float(high)))
    return _merged(found)


def _merged(ranges: Sequence[tuple[float, float]]) -> tuple[tuple[float, float], ...]:
    """Unite overlapping ranges, each from its speed nearest to zero, of speeds of one sign."""
    united: list[tuple[float, float]] = []
    for low, high in sorted(ranges, key=lambda ends: (abs(ends[0]), abs(ends[1]))):
        if united and abs(low) <= abs(united[-1][1]):
            united[-1] = united[-1][0], max(high, united[-1][1], key=abs)
        else:
            united.append((low, high))
    return tuple(united)


@dataclass(frozen=True)
class ExcitationLine(Shown):
    """An excitation whose frequency is proportional to the speed.

    Parameters
    ----------
    kind : {"shaft", "mesh"}
        Rotation of a shaft, or teeth of a mesh.
    source : str or tuple of (str, str)
        Name of the shaft, or of the driving and the driven gear.
    harmonic : int
        The harmonic of the tooth frequency; 1 for a shaft.
    order : float
        Frequency divided by the speed of the reference shaft: negative at negative speeds.

    Examples
    --------
    >>> import gearbow as gb
    >>> system = gb.examples()["bowed_rotor"].load()
    >>> system.campbell([0.0, 500.0], count=2).lines[0].name
    '1× rotor'
    """

    kind: str
    source: str | tuple[str, str]
    harmonic: int
    order: float

    @property
    def name(self) -> str:
        """Name in tables and figures, e.g. "1× output", "2× teeth of g1–g2"."""
        if self.kind == "shaft":
            return f"1× {self.source}"
        return f"{self.harmonic}× teeth of {'–'.join(self.source)}"


@dataclass(frozen=True)
class Intersection(Shown):
    """A speed at which the frequency of a mode equals that of an excitation.

    Parameters
    ----------
    mode : int
        Number of the mode in the diagram, from 0.
    line : ExcitationLine
        The excitation: of a shaft at a critical speed, of teeth at a tooth resonance.
    speed, frequency_hz, damping_ratio : float
        Speed of the reference shaft [rad/s]; frequency [Hz] and damping ratio of the mode there.
    whirl : str
        Whirl of the mode at this speed.
    residual : float
        The larger of the relative distance from the line and the residual as in `Modes`.

    Examples
    --------
    >>> import gearbow as gb
    >>> system = gb.examples()["bowed_rotor"].load()
    >>> first = system.campbell([0.0, 500.0], count=2).criticals[0]
    >>> print(f"{first.speed:.0f} rad/s {first.whirl}")
    278 rad/s backward
    """

    mode: int
    line: ExcitationLine
    speed: float
    frequency_hz: float
    damping_ratio: float
    whirl: str
    residual: float


@dataclass(frozen=True, eq=False)
class Campbell(WithSpeeds, Result, ReadOnly):
    """Modes against the speed, and their intersections with excitation lines.

    Parameters
    ----------
    speeds : ndarray, shape (k,)
        Speeds of the reference shaft [rad/s], of one sign.
    eigenvalues : ndarray, shape (k, m)
        Complex eigenvalues [1/s]. A mode keeps its column where frequencies cross.
    whirl : ndarray of str, shape (k, m)
        "forward", "backward", "mixed", "planar", "torsion", "axial", "rigid" or "coupled".
    lines : tuple of ExcitationLine
        Rotation of every shaft, and tooth frequencies of every mesh.
    intersections : tuple of Intersection
        Intersections of modes and lines, from standstill on.
    thresholds : tuple of StabilityThreshold
        Speeds from standstill on at which the damping of a mode changes its sign.

    Notes
    -----
    Modes at neighbouring speeds are matched by their shapes in the energy norm. Where the match is
    uncertain, the speed step is halved, up to ten times. A veering wider than a hundredth of a step
    is resolved, and the two modes exchange their shapes; a narrower one counts as a crossing.

    A threshold is the root of Re λ of a mode between two neighbouring speeds at which it has
    opposite signs. Two thresholds of one mode between two neighbouring speeds are not found.

    Examples
    --------
    >>> import gearbow as gb
    >>> system = gb.examples()["bowed_rotor"].load()
    >>> for one in system.campbell([0.0, 200.0, 400.0], count=2).criticals:
    ...     print(f"{one.speed:.1f} rad/s {one.whirl}")
    278.2 rad/s backward
    279.5 rad/s forward
    """

    speeds: Array
    eigenvalues: ComplexArray
    whirl: NDArray[np.str_]
    lines: tuple[ExcitationLine, ...]
    intersections: tuple[Intersection, ...]
    thresholds: tuple[StabilityThreshold, ...] = ()

    @classmethod
    def _from_data(cls, speeds: Array, data: CampbellData) -> "Campbell":
        """Make a diagram of the plain data of the core."""
        lines = tuple(ExcitationLine(**row) for row in data["lines"])
        return cls(
            speeds,
            data["eigenvalues"],
            np.array(data["whirl"], dtype=np.str_).reshape(data["eigenvalues"].shape),
            lines,
            tuple(
                Intersection(**row | {"line": lines[row["line"]]}) for row in data["intersections"]
            ),
            tuple(StabilityThreshold(**row) for row in data["thresholds"]),
        )

    @property
    def frequencies_hz(self) -> Array:
        """Damped natural frequencies [Hz], shape (k, m)."""
        frequencies: Array = self.eigenvalues.imag / (2.0 * np.pi)
        return frequencies

    @property
    def damping_ratios(self) -> Array:
        """Damping ratios: −Re λ divided by the magnitude of λ, shape (k, m).

        The ratio is 0 for an eigenvalue of 0, and negative for an unstable mode.
        """
        ratios: Array = _ratio(self.eigenvalues)
        return ratios

    @property
    def criticals(self) -> tuple[Intersection, ...]:
        """Critical speeds: intersections with the rotation of a shaft, from standstill on.

        Backward modes are included, because unbalance excites them if bearings or meshes are
        anisotropic.
        """
        return tuple(
            intersection for intersection in self.intersections if intersection.line.kind == "shaft"
        )

    @property
    def unstable_ranges(self) -> tuple[tuple[float, float], ...]:
        """First and last speed [rad/s] of each range in which a mode of the diagram is unstable.

        The ranges are in their order from standstill on. They end at a threshold, or at an end of
        `speeds`.
        """
        return unstable_ranges(self.speeds, self.eigenvalues, self.thresholds)

    def _heading(self) -> list[str]:
        return [f"intersections and stability thresholds, {self._speed_text(self.speeds)}"]

    def _columns(self) -> list[Column]:
        rows: list[tuple[Intersection | StabilityThreshold, float, str]] = [
            (one, one.damping_ratio, one.line.name) for one in self.intersections
        ]
        rows += [(one, 0.0, f"itself: {one.above} above") for one in self.thresholds]
        rows.sort(key=lambda row: abs(row[0].speed))
        found = [row[0] for row in rows]
        return [
            Column("speed", np.array([one.speed for one in found]), "rad/s", ".2f"),
            Column("frequency", np.array([one.frequency_hz for one in found]), "Hz", ".3f"),
            Column(
                "damping ratio",
                np.array([damping for _, damping, _ in rows]),
                "",
                ".3f",
                in_percent("damping"),
            ),
            Column("whirl", [one.whirl for one in found]),
            Column("mode", np.array([one.mode + 1 for one in found], dtype=np.int64)),
            Column("excited by", [source for *_, source in rows]),
        ]

    def _series(self) -> list[Column]:
        orders = {line.name: line.order for line in self.lines}
        found = self._columns()
        names = found[-1].values
        return [*found, Column("order", np.array([orders.get(name, np.nan) for name in names]))]

    def __repr__(self) -> str:
        found = self._speed_text([one.speed for one in self.criticals])
        criticals = f"critical speeds {found}" if self.criticals else "no critical speeds"
        if self.thresholds:
            limits = self._speed_text([one.speed for one in self.thresholds])
            criticals += f"; stability thresholds {limits}"
        return (
            f"Campbell({self.eigenvalues.shape[1]} modes at {self.speeds.size} speeds, "
            f"{self._speed_text(self.speeds)}; {len(self.intersections)} intersections; "
            f"{criticals})"
        )

    def plot(
        self,
        *,
        ax: Any = None,
        speed_unit: SpeedUnit | None = None,
        operating: float | tuple[float, float] | None = None,
    ) -> "Figure":
        """Draw frequencies and damping ratios against the speed.

        Parameters
        ----------
        ax : sequence of two Axes, optional
            Panels for frequencies and damping ratios; None makes a new figure.
        speed_unit : str, optional
            Unit of the axis of speeds, as for `table`; None is that of the given ones.
        operating : float or tuple of (float, float), optional
            Operating speed of the reference shaft, or the lowest and the highest [rad/s], which
            the figure shades. The excitation lines reach at least to it.

        Returns
        -------
        matplotlib.figure.Figure
            Frequencies with excitation lines, intersections and stability thresholds above,
            damping ratios below; speeds at which a mode is unstable are shaded. Line styles show
            the whirl. Small marks are the values at `speeds`; the curve between them is a
            monotone cubic through these values, the intersections and the thresholds. The scale of
            the damping is logarithmic if the ratios differ by more than a factor of 10; with
            negative ratios it is linear about zero.
        """
        with extra("plot"):
            from gearbow.plotting import campbell  # noqa: PLC0415

        span = operating_range(operating)
        with self._showing(speed_unit):
            return campbell.campbell(
                self.speeds,
                self.frequencies_hz,
                self.damping_ratios,
                self.whirl,
                lines=[(line.name, line.order) for line in self.lines],
                intersections=[
                    (one.mode, one.speed, one.frequency_hz, one.damping_ratio)
                    for one in self.intersections
                ],
                thresholds=[(one.mode, one.speed, one.frequency_hz) for one in self.thresholds],
                unstable=self.unstable_ranges,
                operating=span,
                ax=ax,
            )


def _ratio(eigenvalues: ComplexArray) -> Array:
    size = np.abs(eigenvalues)
    ratio: Array = np.where(size > 0.0, -eigenvalues.real / np.where(size > 0.0, size, 1.0), 0.0)
    return ratio
