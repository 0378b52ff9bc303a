"""Residual bow: the deflection curve of a shaft without load.

The curve b(x) = b_y + i b_z [m] is fixed in the shaft and rotates with it. The bow acts only on the
shaft itself: the force is K_s q_b, with the elastic stiffness K_s of the shaft and the bowed shape
q_b.
"""

import cmath
import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from gearbow._convert import function, nested, shown
from gearbow.description.part import Part, tuples
from gearbow.errors import SceneError

#: Number of points at which the curve of `Bow.function` is sampled.
SAMPLES = 1001


@dataclass(frozen=True)
class Bow(Part):
    """Residual bow of a shaft; made by one of its constructors.

    Parameters
    ----------
    shape : {"half_sine", "sag", "mode", "points", "function"}
        The family of the curve.
    amplitude : float, optional
        Largest deflection [m].
    phase : float, optional
        Angle of the plane of the bow in the shaft, from y towards z [rad].
    number : int, optional
        Half waves over the length, for "mode".
    positions : sequence of float, optional
        Positions of the measurements [m], for "points".
    amplitudes : sequence of float, optional
        Deflection at each position [m], for "points".
    phases : sequence of float, optional
        Angle at each position [rad], for "points".
    curve : callable, optional
        The curve itself, for "function".

    Notes
    -----
    The bow of a rotor as a fixed curve: Nicholas, Gunter and Allaire, *Effect of residual shaft bow
    on unbalance response and balancing of a single mass flexible rotor*, J. Eng. Power 98 (1976).

    Examples
    --------
    >>> import gearbow as gb
    >>> gb.Bow.half_sine(1e-4, phase=0.5).amplitude
    0.0001
    >>> gb.Bow.points([0.0, 0.5, 1.0], [0.0, 2e-4, 0.0]).phases
    (0.0, 0.0, 0.0)
    """

    shape: str
    amplitude: float | None = None
    phase: float | None = None
    number: int | None = None
    positions: Sequence[float] | None = None
    amplitudes: Sequence[float] | None = None
    phases: Sequence[float] | None = None
    curve: Callable[[float], complex] | None = None

    @classmethod
    def half_sine(cls, amplitude: float, phase: float = 0.0) -> "Bow":
        """Make a bow of one half wave over the length of the shaft.

        Parameters
        ----------
        amplitude : float
            Deflection at mid-length [m].
        phase : float
            Angle in the shaft [rad].

        Returns
        -------
        Bow
            The bow amplitude·sin(πx/L)·exp(i phase).
        """
        return cls("half_sine", amplitude=amplitude, phase=phase)

    @classmethod
    def sag(cls, amplitude: float, phase: float = 0.0) -> "Bow":
        """Make a bow with the shape of the deflection by the weight of the shaft.

        Parameters
        ----------
        amplitude : float
            Largest deflection [m].
        phase : float
            Angle in the shaft [rad].

        Returns
        -------
        Bow
            The bow, as after months at standstill.
        """
        return cls("sag", amplitude=amplitude, phase=phase)

    @classmethod
    def mode(cls, number: int, amplitude: float, phase: float = 0.0) -> "Bow":
        """Make a bow of several half waves over the length of the shaft.

        Parameters
        ----------
        number : int
            Number of half waves; 1 is `half_sine`.
        amplitude : float
            Deflection at the crests [m].
        phase : float
            Angle in the shaft [rad].

        Returns
        -------
        Bow
            The bow amplitude·sin(number·πx/L)·exp(i phase).
        """
        return cls("mode", amplitude=amplitude, phase=phase, number=number)

    @classmethod
    def points(
        cls, positions: "ArrayLike", amplitudes: "ArrayLike", phases: "ArrayLike" = 0.0
    ) -> "Bow":
        """Make a bow from a measured curve, e.g. run-out readings along the shaft.

        An amplitude is the distance of the centre line from the straight axis. A dial gauge shows
        twice as much in one turn: divide its total indicator reading by 2, as `read_table` does for
        "total_run_out".

        Parameters
        ----------
        positions : array_like, shape (p,)
            Positions of the measurements, from the left end of the shaft [m].
        amplitudes : array_like, shape (p,)
            Deflection of the centre line at each position [m], half of the total indicator reading.
        phases : array_like, shape (p,) or scalar
            Angle in the shaft at each position [rad].

        Returns
        -------
        Bow
            The bow: a cubic spline through the points (a parabola through three, a line through
            two), and straight lines with its end slopes beyond the first and the last point. The
            ends of a shaft therefore deflect even where both bearings, at the outer points, do not.
            Where the deflection of an end is more than half of the largest amplitude, the system
            warns; give points up to the ends.
        """
        deflections = nested(amplitudes, "bow.amplitudes")
        angles = nested(phases, "bow.phases")
        if isinstance(deflections, list) and not isinstance(angles, list):
            angles = [angles] * len(deflections)
        return cls(
            "points",
            positions=tuples(nested(positions, "bow.positions")),
            amplitudes=tuples(deflections),
            phases=tuples(angles),
        )

    @classmethod
    def read_table(cls, path: str | os.PathLike[str]) -> "Bow":
        r"""Read measured run-out or bow along a shaft from a table.

        Parameters
        ----------
        path : str or path-like
            A file as for `SpeedTable.read_table`, with the columns "position", "amplitude" or
            "total_run_out", and optionally "phase". The total run-out of a dial gauge, from its
            smallest to its largest reading in one turn, is twice the amplitude. A heading has the
            unit in brackets, for example "position [mm]", "total_run_out [mil]" or "phase [deg]";
            without one it is the SI unit.

        Returns
        -------
        Bow
            The bow, a cubic spline through the points.

        Examples
        --------
        >>> from pathlib import Path
        >>> import gearbow as gb
        >>> lines = ["position [mm]; total_run_out [um]; phase [deg]", "0; 0; 0", "250; 300; 90"]
        >>> written = Path("runout.csv").write_text("\n".join([*lines, "500; 0; 0"]))
        >>> bow = gb.Bow.read_table("runout.csv")
        >>> bow.positions, bow.amplitudes
        ((0.0, 0.25, 0.5), (0.0, 0.00015, 0.0))
        >>> Path("runout.csv").unlink()
        """
        from gearbow.exchange.tables import read_table  # noqa: PLC0415  # few scenes need it

        known = {"position": "position", "amplitude": "amplitude", "phase": "phase"}
        found = read_table(path, {**known, "total_run_out": "amplitude"}).numbers
        sizes = [name for name in ("amplitude", "total_run_out") if name in found]
        if "position" not in found or len(sizes) != 1:
            raise SceneError(
                f'{path}: needs the column "position" and one of "amplitude" and "total_run_out", '
                f"got {', '.join(found)}"
            )
        amplitudes = found[sizes[0]] / (2.0 if sizes == ["total_run_out"] else 1.0)
        return cls.points(found["position"], amplitudes, found.get("phase", 0.0))

    @classmethod
    def function(cls, f: Callable[[float], complex]) -> "Bow":
        """Make a bow from any curve, given as a function of the position.

        Parameters
        ----------
        f : callable
            Function of the distance x from the left end of the shaft [m]. It returns the complex
            deflection b_y + i b_z [m]. Making the system calls it once at each of 1001 equally
            spaced points.

        Returns
        -------
        Bow
            The bow, a cubic spline through the points.

        Examples
        --------
        A bend of 0.1 mm per metre that begins in the middle of a shaft of 1 m:

        >>> import gearbow as gb
        >>> bend = gb.Bow.function(lambda x: 1e-4 * max(0.0, x - 0.5))
        >>> shaft = gb.Shaft("rotor", length=1.0, outer_diameter=0.05, bow=bend)
        """
        return cls("function", curve=function(f, "bow.function.f"))

    def _sampled(self, length: float, path: str) -> "Bow":
        """Sample the curve of `Bow.function` along a shaft of this length."""
        if self.curve is None:
            return self
        function(self.curve, f"{path}.function")
        positions = np.linspace(0.0, length, SAMPLES)
        curve = np.array([_finite(self.curve, float(x), path) for x in positions])
        return Bow.points(positions, np.abs(curve), np.angle(curve))


def _finite(curve: Callable[[float], complex], x: float, path: str) -> complex:
    value = curve(x)
    try:
        number = complex(value)
    except (TypeError, ValueError):
        number = complex("nan")
    if not cmath.isfinite(number):
        raise SceneError(
            f"{path}.function: must give a finite complex number, got {shown(value)} at x = {x:g} m"
        )
    return number


def scaled(bow: Bow | None, factor: float, turn: float = 0.0) -> Bow | None:
    """Multiply a bow by a factor, and turn its plane by an angle in the shaft [rad]."""
    if bow is None:
        return None
    if bow.curve is not None:
        raise SceneError("bow: a bow given by a function cannot be scaled; use Bow.points")
    if bow.amplitudes is not None:
        return replace(
            bow,
            amplitudes=[factor * each for each in bow.amplitudes],
            phases=[turn + each for each in bow.phases or ()],
        )
    phase = bow.phase if turn == 0.0 else turn + (bow.phase or 0.0)
    return replace(bow, amplitude=factor * (bow.amplitude or 0.0), phase=phase)


def amplitude_of(bow: Bow | None) -> float:
    """Give the size of a bow by which it is scaled: its amplitude, or the largest of its points."""
    if bow is None:
        return 0.0
    if bow.amplitudes is not None:
        return float(max(map(abs, bow.amplitudes)))
    return abs(bow.amplitude or 0.0)
