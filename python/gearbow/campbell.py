"""Modes over the speed, and where they meet what excites them: Campbell diagrams."""

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from gearbow._convert import array, whole
from gearbow._extras import extra
from gearbow._read_only import ReadOnly
from gearbow._types import Array, CampbellData, ComplexArray

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

    from gearbow.system import RotorSystem

__all__ = [
    "Campbell",
    "ExcitationLine",
    "Intersection",
    "campbell",
]


@dataclass(frozen=True)
class ExcitationLine:
    """What excites a train at a multiple of the speed.

    Parameters
    ----------
    kind : {"shaft", "mesh"}
        The turning of a shaft, or the teeth of a mesh.
    source : str or tuple of (str, str)
        Name of the shaft, or of the driving and the driven gear.
    harmonic : int
        The harmonic of the tooth frequency; 1 for a shaft.
    order : float
        Frequency over the speed of the reference shaft, not negative.
    """

    kind: str
    source: str | tuple[str, str]
    harmonic: int
    order: float

    @property
    def name(self) -> str:
        """What it is called in a table.

        Returns
        -------
        str
            E.g. "1× output", "2× teeth of g1–g2".
        """
        if self.kind == "shaft":
            return f"1× {self.source}"
        return f"{self.harmonic}× teeth of {'–'.join(self.source)}"


@dataclass(frozen=True)
class Intersection:
    """A speed at which a mode has the frequency of what excites it.

    Parameters
    ----------
    mode : int
        Number of the mode in the diagram, from 0.
    line : ExcitationLine
        What excites: a shaft makes a critical speed, teeth a resonance of theirs.
    speed : float
        Speed of the reference shaft [rad/s].
    frequency_hz : float
        Frequency [Hz].
    damping_ratio : float
        Damping ratio of the mode there.
    whirl : str
        How the mode whirls there.
    """

    mode: int
    line: ExcitationLine
    speed: float
    frequency_hz: float
    damping_ratio: float
    whirl: str


@dataclass(frozen=True, eq=False)
class Campbell(ReadOnly):
    """Modes followed by their shapes over the speed, and where they meet what excites them.

    Parameters
    ----------
    speeds : ndarray, shape (k,)
        Speeds of the reference shaft [rad/s].
    eigenvalues : ndarray, shape (k, m)
        Complex eigenvalues [1/s] of each mode, which keeps its column through crossings.
    whirl : ndarray of str, shape (k, m)
        "forward", "backward", "planar", "torsion", "rigid" or "coupled".
    lines : tuple of ExcitationLine
        The turning of every shaft, and the tooth frequencies of every mesh.
    intersections : tuple of Intersection
        Where modes meet lines, by ascending speed.
    system : RotorSystem
        The system that was asked.

    Notes
    -----
    A mode keeps its column by its shape with the energy as weight. A step in which that is in doubt
    is halved, up to ten times: a veering that is wider than a hundredth of a step is followed, and
    each mode takes over the shape of the other; a narrower one is passed like a crossing.

    Examples
    --------
    >>> import numpy as np
    >>> import gearbow as gb
    >>> rotor = gb.Shaft("rotor", length=1.0, outer_diameter=0.05, elements=8)
    >>> bearings = [gb.Bearing("rotor", x, stiffness=1e7) for x in (0.0, 1.0)]
    >>> disk = gb.Disk("disk", "rotor", 0.3, mass=20.0, diametral_inertia=0.3, polar_inertia=0.6)
    >>> system = gb.RotorSystem(shafts=[rotor], bearings=bearings, disks=[disk])
    >>> campbell = system.campbell(np.linspace(0.0, 700.0, 15), count=4)
    >>> for intersection in campbell.criticals:
    ...     print(f"{intersection.speed:.1f} rad/s {intersection.whirl}")
    324.7 rad/s backward
    341.1 rad/s forward
    """

    speeds: Array
    eigenvalues: ComplexArray
    whirl: NDArray[np.str_]
    lines: tuple[ExcitationLine, ...]
    intersections: tuple[Intersection, ...]
    system: "RotorSystem" = field(repr=False)

    @classmethod
    def _from_data(cls, speeds: Array, data: CampbellData, system: "RotorSystem") -> "Campbell":
        lines = []
        for (kind, names, harmonic), order in zip(data["lines"], data["orders"], strict=True):
            source = names[0] if kind == "shaft" else (names[0], names[1])
            lines.append(ExcitationLine(kind, source, harmonic, float(order)))
        found = zip(
            data["intersection_modes"],
            data["intersection_lines"],
            data["intersection_speeds"],
            data["intersection_eigenvalues"],
            data["intersection_whirl"],
            strict=True,
        )
        intersections = tuple(
            Intersection(
                mode=mode,
                line=lines[line],
                speed=float(speed),
                frequency_hz=float(value.imag) / (2.0 * np.pi),
                damping_ratio=float(_ratio(value)),
                whirl=whirl,
            )
            for mode, line, speed, value, whirl in found
        )
        whirls = np.array(data["whirl"], dtype=np.str_).reshape(data["eigenvalues"].shape)
        return cls(speeds, data["eigenvalues"], whirls, tuple(lines), intersections, system)

    @property
    def frequencies_hz(self) -> Array:
        """Damped natural frequencies.

        Returns
        -------
        ndarray, shape (k, m)
            Frequencies [Hz].
        """
        frequencies: Array = self.eigenvalues.imag / (2.0 * np.pi)
        return frequencies

    @property
    def damping_ratios(self) -> Array:
        """Damping ratios −Re λ/|λ|.

        Returns
        -------
        ndarray, shape (k, m)
            Ratios; 0 for a motion without stiffness.
        """
        ratios: Array = _ratio(self.eigenvalues)
        return ratios

    @property
    def criticals(self) -> tuple[Intersection, ...]:
        """Critical speeds: where a mode has the frequency of a shaft's turning.

        Returns
        -------
        tuple of Intersection
            By ascending speed, backward ones too: unbalance excites these where bearings or meshes
            are stiffer in one direction.
        """
        return tuple(
            intersection for intersection in self.intersections if intersection.line.kind == "shaft"
        )

    def table(self) -> str:
        """Lay the intersections out as text.

        Returns
        -------
        str
            Speed, frequency, damping, whirl, mode number and excitation of each, one a line.
        """
        heads = f"{'speed [rad/s]':>13}  {'frequency [Hz]':>14}  {'damping [%]':>11}"
        lines = [f"{heads}  {'whirl':<9}  mode  excited by"]
        lines += [
            f"{intersection.speed:>13.2f}  {intersection.frequency_hz:>14.3f}"
            f"  {100.0 * intersection.damping_ratio:>11.3f}  {intersection.whirl:<9}"
            f"  {intersection.mode + 1:>4}  {intersection.line.name}"
            for intersection in self.intersections
        ]
        return "\n".join(lines)

    def __str__(self) -> str:
        return self.table()

    def to_dataframe(self) -> "pd.DataFrame":
        """Give the intersections as a data frame.

        Returns
        -------
        pandas.DataFrame
            One row for each intersection.
        """
        with extra("dataframe"):
            import pandas as pd  # noqa: PLC0415

        rows = [
            {
                "speed [rad/s]": intersection.speed,
                "frequency [Hz]": intersection.frequency_hz,
                "damping ratio": intersection.damping_ratio,
                "whirl": intersection.whirl,
                "mode": intersection.mode,
                "excited by": intersection.line.name,
                "order": intersection.line.order,
            }
            for intersection in self.intersections
        ]
        table: pd.DataFrame = pd.DataFrame(rows)
        return table

    def plot(self) -> "Figure":
        """Draw frequencies and damping ratios against the speed, with the lines and criticals.

        Returns
        -------
        matplotlib.figure.Figure
            Frequencies above, damping ratios below; marks tell the whirl, dots the intersections.
        """
        with extra("plot"):
            from gearbow import frequency_plots  # noqa: PLC0415

        return frequency_plots.campbell(self)


def _ratio(eigenvalues: ComplexArray) -> Array:
    size = np.abs(eigenvalues)
    ratio: Array = np.where(size > 0.0, -eigenvalues.real / np.where(size > 0.0, size, 1.0), 0.0)
    return ratio


def campbell(
    system: "RotorSystem", speeds: ArrayLike, *, count: int = 10, harmonics: int = 1
) -> Campbell:
    """Follow the modes over a range of speeds, and find where they meet what excites them.

    Parameters
    ----------
    system : RotorSystem
        The system.
    speeds : array_like, shape (k,)
        Ascending speeds of the reference shaft [rad/s], from 0 or above.
    count : int
        Number of modes, beginning with the lowest frequency at the first speed, without
        rigid-body rotation.
    harmonics : int
        How many harmonics of every tooth frequency; 0 leaves the teeth out.

    Returns
    -------
    Campbell
        Eigenvalues and whirl of each mode, and the intersections, which are found on the modes
        themselves, to about 1e-12 of the speed, however coarse the speeds are.

    Raises
    ------
    SceneError
        If an argument is impossible.
    """
    wanted = array(speeds, "speeds")
    count = whole(count, "count")
    harmonics = whole(harmonics, "harmonics", least=0)
    return Campbell._from_data(wanted, system._model.campbell(wanted, count, harmonics), system)
