"""Bows of shafts, and limits that they reach."""

import cmath
import math
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass, replace
from typing import Any, get_args

import numpy as np
from numpy.typing import ArrayLike

from gearbow._convert import function, nested, number, one_of, positive, shown, text
from gearbow._types import At, StrengthLine
from gearbow.description.part import Part, tuples
from gearbow.description.places import place
from gearbow.errors import SceneError
from gearbow.units.speed import PER_MINUTE, speed_factor

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
    positions, amplitudes, phases : sequence of float, optional
        Positions [m], deflections there [m] and their angles [rad], for "points".
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
        amplitude, phase : float
            Deflection at mid-length [m], and angle in the shaft [rad].

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
        amplitude, phase : float
            Largest deflection [m], and angle in the shaft [rad].

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
        amplitude, phase : float
            Deflection at the crests [m], and angle in the shaft [rad].

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
        twice as much in one turn: halve its total indicator reading, as `read_table` does it.

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
            deflection b_y + i b_z [m]. Making the system calls it at 1001 equally spaced points.

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


#: Peak-to-peak displacement of a shaft relative to its bearing: factor over √n with the speed n
#: [1/min], and the largest value [m]. ISO 20816-3 (before: ISO 7919-3), boundaries of its zones;
#: API 617, √(12000/n) mil and at most 1 mil.
DISPLACEMENTS = {
    "ISO 20816-3 A/B": (4800e-6, math.inf),
    "ISO 20816-3 B/C": (9000e-6, math.inf),
    "ISO 20816-3 C/D": (13200e-6, math.inf),
    "API 617": (25.4e-6 * math.sqrt(12000.0), 25.4e-6),
}


def largest_displacement(standard: str, speed: float) -> float:
    """Give the largest peak-to-peak displacement [m] of a shaft at its speed [rad/s]."""
    factor, largest = DISPLACEMENTS[standard]
    turns = speed_factor(PER_MINUTE) * abs(speed)
    return min(factor / math.sqrt(turns) if turns else math.inf, largest)


#: RMS velocity of a bearing housing [m/s]: ISO 20816-3, boundaries of its zones by group of
#: machines (1: above 300 kW, 2: 15 to 300 kW) and foundation.
VELOCITIES = {
    f"ISO 20816-3 group {group} {foundation} {zone}": 1e-3 * value
    for (group, foundation), values in {
        (1, "rigid"): (2.3, 4.5, 7.1),
        (1, "flexible"): (3.5, 7.1, 11.0),
        (2, "rigid"): (1.4, 2.8, 4.5),
        (2, "flexible"): (2.3, 4.5, 7.1),
    }.items()
    for zone, value in zip(("A/B", "B/C", "C/D"), values, strict=True)
}


@dataclass(frozen=True)
class BowLimit(Part):
    """A limit that `RotorSystem.bow_limits` adds to those of the teeth; made by its constructors.

    Parameters
    ----------
    kind : str
        Name of the constructor.
    at : str or tuple
        Place, bearing or mesh.
    value : float or str
        Limit, or the name of a standard.
    angle : float, optional
        Direction of a displacement or velocity, from y towards z [rad].
    support : str, optional
        What a displacement is measured from.
    capacity, exponent : float, optional
        Dynamic load rating [N] and exponent, for "bearing_life"; None is that of the bearing.
    tensile_strength : float, optional
        Tensile strength [Pa], for "stress".
    line : {"goodman", "din743"}
        How a mean stress lowers the endured amplitude, for "stress".

    Examples
    --------
    >>> import gearbow as gb
    >>> gb.BowLimit.displacement(("input", 0.1), "API 617").value
    'API 617'
    >>> gb.BowLimit.bearing_life(("input", 0.1), 40e3, capacity=35e3, exponent=3.0).value
    40000.0
    """

    kind: str
    at: Any
    value: float | str
    _: KW_ONLY
    angle: float | None = None
    support: str | None = None
    capacity: float | None = None
    exponent: float | None = None
    tensile_strength: float | None = None
    line: StrengthLine = "goodman"

    @classmethod
    def displacement(
        cls, at: At, limit: float | str, *, angle: float | None = None, support: str | None = None
    ) -> "BowLimit":
        """Limit the peak-to-peak displacement at a probe. The bow itself counts as vibration.

        Parameters
        ----------
        at : str or tuple of (str, float)
            A gear, disk, support, housing or point of a housing by name, or (shaft, position [m]).
        limit : float or str
            Peak-to-peak displacement [m]; or "ISO 20816-3 A/B", "ISO 20816-3 B/C", "ISO 20816-3
            C/D" (4800, 9000 and 13200 µm over √n with the speed n [1/min] of the shaft), or
            "API 617" (25.4 µm √(12000/n), at most 25.4 µm).
        angle : float, optional
            Direction of the probe, from y towards z [rad]; None is that of the largest one.
        support : str, optional
            Support, housing or point of a housing on which the probe stands; None is the ground.
        """
        value = _value(limit, DISPLACEMENTS)
        towards = None if angle is None else number(angle, "angle")
        on = None if support is None else text(support, "support")
        return cls("displacement", place(at, kind="place"), value, angle=towards, support=on)

    @classmethod
    def velocity(cls, at: At, limit: float | str, *, angle: float | None = None) -> "BowLimit":
        """Limit the RMS velocity of a place, usually of a bearing housing.

        Parameters
        ----------
        at : str or tuple of (str, float)
            As for `displacement`.
        limit : float or str
            RMS velocity [m/s], or a boundary of zones such as "ISO 20816-3 group 2 rigid B/C", with
            group 1 or 2, "rigid" or "flexible", and "A/B", "B/C" or "C/D".
        angle : float, optional
            Direction, from y towards z [rad]; None is the one with the largest velocity.
        """
        towards = None if angle is None else number(angle, "angle")
        return cls("velocity", place(at, kind="place"), _value(limit, VELOCITIES), angle=towards)

    @classmethod
    def contact_ratio(cls, at: str | tuple[str, str], least: float) -> "BowLimit":
        """Require a contact ratio above 1.

        Parameters
        ----------
        at : tuple of (str, str) or str
            The mesh: (driver, driven) in either order, or "driver/driven".
        least : float
            Smallest contact ratio at any instant.
        """
        return cls("contact_ratio", place(at, kind="mesh"), positive(least, "least"))

    @classmethod
    def mesh_force(cls, at: str | tuple[str, str], factor: float) -> "BowLimit":
        """Limit the largest mesh force, found from steady states.

        Parameters
        ----------
        at : tuple of (str, str) or str
            The mesh: (driver, driven) in either order, or "driver/driven".
        factor : float
            Largest mesh force of the steady motion over the static one.
        """
        return cls("mesh_force", place(at, kind="mesh"), positive(factor, "factor"))

    @classmethod
    def bearing_force(cls, at: tuple[str, float], force: float) -> "BowLimit":
        """Limit the largest radial force on a bearing.

        Parameters
        ----------
        at : tuple of (str, float)
            Shaft and position of the bearing [m].
        force : float
            Largest force [N].
        """
        return cls("bearing_force", place(at, kind="bearing"), positive(force, "force"))

    @classmethod
    def bearing_life(
        cls,
        at: tuple[str, float],
        hours: float,
        *,
        capacity: float | None = None,
        exponent: float | None = None,
    ) -> "BowLimit":
        """Require a basic rating life of a rolling bearing (ISO 281), as `bearing_life` finds it.

        The life is (C/P)^p million turns; P is the mean of the equivalent load over the time with
        the exponent p, from the radial force of each instant and the thrust of the equilibrium. A
        bearing between shafts counts relative turns.

        Parameters
        ----------
        at : tuple of (str, float)
            Shaft and position of the bearing [m].
        hours : float
            Smallest life L₁₀ [h].
        capacity : float, optional
            Basic dynamic load rating C [N]; None is that of the bearing.
        exponent : float, optional
            Exponent p; None is that of the bearing, 3 for balls and 10/3 for rollers.
        """
        return cls(
            "bearing_life",
            place(at, kind="bearing"),
            positive(hours, "hours"),
            capacity=None if capacity is None else positive(capacity, "capacity"),
            exponent=None if exponent is None else positive(exponent, "exponent"),
        )

    @classmethod
    def stress(
        cls,
        at: At,
        endurance_limit: float,
        *,
        tensile_strength: float,
        line: StrengthLine = "goodman",
    ) -> "BowLimit":
        """Limit the utilisation of a section of a shaft to 1, as `RotorSystem.stresses` finds it.

        Notches are those of the system.

        Parameters
        ----------
        at : str or tuple of (str, float)
            A gear or disk by name, or (shaft, position [m]).
        endurance_limit, tensile_strength : float
            Amplitude that a smooth specimen of this size endures, and tensile strength [Pa].
        line : {"goodman", "din743"}
            How a mean stress lowers the endured amplitude.
        """
        return cls(
            "stress",
            place(at, kind="place"),
            positive(endurance_limit, "endurance_limit"),
            tensile_strength=positive(tensile_strength, "tensile_strength"),
            line=one_of(line, get_args(StrengthLine), "line"),  # type: ignore[arg-type]
        )

    @classmethod
    def film(cls, at: tuple[str, float], thickness: float) -> "BowLimit":
        """Require an oil film of a journal bearing, found from steady states.

        Parameters
        ----------
        at : tuple of (str, float)
            Shaft and position of the journal bearing [m].
        thickness : float
            Smallest film thickness at any instant [m].
        """
        return cls("film", place(at, kind="bearing"), positive(thickness, "thickness"))

    @classmethod
    def clearance(cls, at: tuple[str, float], approach: float) -> "BowLimit":
        """Limit how far the shaft moves in a rolling bearing: through its clearance, and beyond.

        The limit follows from the linear motion. A run with the contacts of the elements may reach
        it at a smaller bow.

        Parameters
        ----------
        at : tuple of (str, float)
            Shaft and position of the rolling bearing [m].
        approach : float
            Largest elastic approach of the rings [m]: the displacement of the shaft relative to
            what the bearing stands on, less the radial gap, which is half of the clearance.
        """
        return cls("clearance", place(at, kind="bearing"), positive(approach, "approach"))


def _value(limit: Any, standards: Mapping[str, Any]) -> float | str:
    """Check a positive number or the name of a standard."""
    if isinstance(limit, str):
        return one_of(limit, standards, "limit")
    return positive(limit, "limit")
