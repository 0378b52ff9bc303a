"""Bearings, couplings, drives, torques and forces, and the sources of harmonic analyses."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import KW_ONLY, dataclass
from typing import Any, TypeAlias, get_args

import numpy as np
from numpy.typing import ArrayLike

from gearbow._convert import complex_number, items, one_of, positive, real, shown, text
from gearbow._types import (
    Array,
    At,
    ComplexArray,
    Excitation,
    MotionQuantity,
    Plain,
    RollingContact,
)
from gearbow.description.bow import Bow
from gearbow.description.journal import JournalBearing, TiltingPadBearing
from gearbow.description.part import Part, expect
from gearbow.description.places import Base, place, place_label
from gearbow.description.rolling import RollingBearing
from gearbow.description.speed import SpeedTable
from gearbow.description.time_series import TimeSeries, described_value
from gearbow.errors import SceneError


@dataclass(frozen=True)
class Coupling(Part):
    """A coupling between the ends of two coaxial shafts that turn at one speed.

    Linear springs and dampers join two hubs: axial, lateral, tilting and torsional. A large
    stiffness is a rigid coupling. Axial stiffness and damping act in a system with axial motion,
    which helical gears, axial forces and bearings with an axial stiffness cause.

    Parameters
    ----------
    a, b : str or tuple of (str, float)
        Hubs: a gear or disk by name, or (shaft, position [m]), on two shafts.
    torsional_stiffness : float
        Stiffness against the twist of hub a relative to hub b [N m/rad].
    axial_stiffness, lateral_stiffness : float
        Stiffness along and across the axis [N/m].
    tilting_stiffness : float
        Stiffness against the angle between the axes of the shafts [N m/rad].
    axial_damping, lateral_damping : float
        Damping along and across the axis [N s/m].
    tilting_damping, torsional_damping : float
        Damping of the angle between the axes and of the twist [N m s/rad].
    offset : complex
        Parallel misalignment y + iz of the axis of b to that of a, fixed in space [m].
    angle : complex
        Angular misalignment of the axis of b to that of a, fixed in space: slopes y + iz [rad].
    runout : complex
        Eccentricity of the hub of b [m], which turns; its argument is its angle in the shaft [rad].

    Examples
    --------
    >>> import gearbow as gb
    >>> coupling = gb.Coupling(
    ...     ("motor", 0.4),
    ...     ("pump", 0.0),
    ...     lateral_stiffness=1e6,
    ...     tilting_stiffness=1e3,
    ...     torsional_stiffness=5e4,
    ...     torsional_damping=5.0,
    ...     offset=1e-4,
    ... )
    """

    a: At
    b: At
    _: KW_ONLY
    torsional_stiffness: float
    axial_stiffness: float = 0.0
    lateral_stiffness: float = 0.0
    tilting_stiffness: float = 0.0
    axial_damping: float = 0.0
    lateral_damping: float = 0.0
    tilting_damping: float = 0.0
    torsional_damping: float = 0.0
    offset: complex = 0.0
    angle: complex = 0.0
    runout: complex = 0.0


@dataclass(frozen=True)
class Drive(Part):
    """A torsional spring and damper that hold the rotation of a shaft at its prescribed angle.

    A drive has the torque -k θ - c θ̇. It stands for a motor with speed control, and takes the
    torque that the other torques leave over.

    Parameters
    ----------
    at : str or tuple of (str, float)
        A gear or disk by name, or (shaft, position [m]).
    stiffness, damping : float
        Stiffness k [N m/rad] and damping c [N m s/rad].

    Examples
    --------
    >>> import gearbow as gb
    >>> drive = gb.Drive("g1", stiffness=1e5, damping=20.0)
    """

    at: At
    stiffness: float
    damping: float = 0.0


@dataclass(frozen=True)
class Force(Part):
    """A force on a shaft.

    Parameters
    ----------
    at : str or tuple of (str, float)
        A gear or disk by name, or (shaft, position [m]).
    value : complex, tuple of (complex, complex), TimeSeries or callable
        Force y + iz [N]: constant, over time, or a function of the time [s]. `simulate` samples a
        function over the run; static, modal and synchronous analyses do not contain it. As a source
        of `frequency_response` also two phasors, along y and z.
    order : float, optional
        The force turns with this multiple of the angle of its shaft, value·e^{i·order·ϑ}; None is
        fixed in space, or in the frame of a carrier that turns with planets on bearings. A force of
        order 1 belongs to the synchronous response, with its bow.
    axial : complex
        Constant force along the axis, towards +x [N]; a phasor as a source.

    Examples
    --------
    >>> import gearbow as gb
    >>> weight, rotating = gb.Force("disk", -50j), gb.Force("disk", 10.0, order=1)
    >>> thrust = gb.Force("disk", axial=200.0)
    """

    at: At
    value: complex | tuple[complex, complex] | TimeSeries | Callable[[Any], Any] = 0.0
    order: float | None = None
    axial: complex = 0.0

    def _describe(self, path: str) -> dict[str, Plain]:
        given: dict[str, Plain] = {"at": place(self.at, f"{path}.at")}
        given["value"] = described_value(self.value, f"{path}.value", complex_number)
        if self.order is not None:
            given["order"] = complex_number(self.order, f"{path}.order")
        axial = real(self.axial, f"{path}.axial", "a number [N]")
        if axial != 0.0:
            given["axial"] = axial
        return given


@dataclass(frozen=True)
class Bearing(Part):
    """A bearing between a shaft and what it stands on, linear in displacement and velocity.

    Parameters
    ----------
    shaft : str
        Name of its shaft.
    position : float
        Position on the shaft, from its left end [m].
    stiffness : float, pair, 2×2 array or SpeedTable
        Stiffness [N/m]: a number for every direction, (yy, zz), or [[yy, yz], [zy, zz]]; or a table
        of one of these against the speed of the shaft, the frequency of the vibration or both;
        between two shafts, against the speed of one relative to the other.
    damping : float, pair, 2×2 array or SpeedTable
        Damping [N s/m], in the same forms.
    axial_stiffness : float
        Stiffness along the axis [N/m]. One bearing of a shaft with helical gears needs it.
    axial_damping : float
        Damping along the axis of the shaft [N s/m].
    tilting_stiffness, tilting_damping : float
        Those against rotations of the shaft about y and z [N m/rad, N m s/rad].
    loss_factor : float
        Loss factor η of the stiffness, K(1 + iη sgn ω): structural damping of modes,
        Campbell diagrams, `frequency_response` and `synchronous`. Runs refuse it.
    misalignment : complex
        Distance of the centre of the bearing from its place in the drawing, y + iz [m]. The force
        of the bearing is zero where the shaft has this displacement. On a pin of a carrier that
        turns, y and z turn with the carrier. The bearing needs constant coefficients.
    dynamic_rating, static_rating : float, optional
        Basic load ratings C and C₀ of a rolling bearing [N], which `bearing_life` then contains.
    contact : {"ball", "roller"}, optional
        Rolling elements of a bearing with a rating; None is balls.
    contact_angle : float, optional
        Contact angle of a bearing with a rating [rad]; None is 0.
    support : str, Support or tuple of (str, float), optional
        What it stands on: the name of a support or housing of the system, a support of its own, or
        (shaft, position [m]) of another shaft. None is the ground.

    Examples
    --------
    >>> import gearbow as gb
    >>> bearing = gb.Bearing("input", 0.0, stiffness=(1e8, 2e8), damping=500.0)
    """

    shaft: str
    position: float
    _: KW_ONLY
    stiffness: "ArrayLike | SpeedTable"
    damping: "ArrayLike | SpeedTable" = 0.0
    axial_stiffness: float = 0.0
    axial_damping: float = 0.0
    tilting_stiffness: float = 0.0
    tilting_damping: float = 0.0
    loss_factor: float = 0.0
    misalignment: complex = 0.0
    dynamic_rating: float | None = None
    static_rating: float | None = None
    contact: RollingContact | None = None
    contact_angle: float | None = None
    support: Base | None = None


#: A bearing of any class.
AnyBearing: TypeAlias = Bearing | JournalBearing | TiltingPadBearing | RollingBearing


@dataclass(frozen=True)
class Torque(Part):
    """A torque on a shaft, positive about +x.

    Parameters
    ----------
    at : str or tuple of (str, float)
        A gear or disk by name, or (shaft, position [m]).
    value : complex, TimeSeries, SpeedTable, callable or "balance"
        The torque [N m]: constant; over time; over the magnitude of the actual speed Ω_s + θ̇ of the
        shaft [rad/s], with the end values beyond the table; or a function of the time [s], which
        `simulate` samples over the run. Static, modal and synchronous analyses do not contain a
        torque over time. A phasor as a source of `frequency_response`. "balance" is explained in
        `Torque.balance`.

    Examples
    --------
    >>> import gearbow as gb
    >>> drive, load = gb.Torque("g1", 250.0), gb.Torque.balance("g4")
    """

    at: At
    value: complex | str | SpeedTable | TimeSeries | Callable[[Any], Any]

    @classmethod
    def balance(cls, at: At) -> "Torque":
        """Apply the torque that balances all other torques on the train.

        Torques over time or speed cannot be balanced; hold the rotation with `gearbow.Drive`.

        Parameters
        ----------
        at : str or tuple of (str, float)
            A gear or disk by name, or (shaft, position [m]).

        Returns
        -------
        Torque
            The torque; the system computes its value.
        """
        return cls(at, "balance")

    def _describe(self, path: str) -> dict[str, Plain]:
        at = place(self.at, f"{path}.at")
        if isinstance(self.value, str) and self.value == "balance":
            return {"at": at, "balance": True}

        def number(value: object, path: str) -> Plain:
            wanted = 'a number [N m], a TimeSeries, a SpeedTable, a function of time or "balance"'
            return real(value, path, wanted)

        return {"at": at, "value": described_value(self.value, f"{path}.value", number)}

    @classmethod
    def _from_description(cls, description: Mapping[str, Plain]) -> "Torque":
        given = dict(description)
        if given.pop("balance", False):
            given["value"] = "balance"
        return super()._from_description(given)


@dataclass(frozen=True)
class MeshExcitation(Part):
    """A harmonic transmission error of a mesh, as a source of a frequency response.

    Parameters
    ----------
    at : str or tuple of (str, str)
        The mesh, "driver/driven" or (driver, driven) in either order.
    error : complex
        Phasor e of the unloaded transmission error along the line of action in the transverse
        section [m]. The force (k + iωc) e on the drive flank acts as if material was removed there.

    Examples
    --------
    >>> import gearbow as gb
    >>> gb.MeshExcitation("pinion/wheel").error
    1e-06
    """

    at: str | tuple[str, str]
    error: complex = 1e-6

    def _describe(self, path: str) -> dict[str, Plain]:
        mesh = place(self.at, f"{path}.at", "mesh")
        return {"kind": "mesh_error", "mesh": mesh, "error": phasor(self.error, f"{path}.error")}


@dataclass(frozen=True)
class GroundMotion(Part):
    """A harmonic translation of the ground, as a source of a frequency response.

    Parameters
    ----------
    value : complex or tuple of (complex, complex)
        Motion y + iz in phase along y and z, or its phasors along y and z [m, m/s, m/s²].
    quantity : {"displacement", "velocity", "acceleration"}
        The quantity that `value` and `axial` give.
    axial : complex
        Phasor of the motion along x.
    under : sequence of (str or tuple of (str, float)), optional
        Bearings (shaft, position [m]), supports and housings on moving ground; None is all of them.

    Examples
    --------
    >>> import gearbow as gb
    >>> gb.GroundMotion(1j, quantity="acceleration").quantity
    'acceleration'
    """

    value: complex | tuple[complex, complex] = 0.0
    _: KW_ONLY
    quantity: MotionQuantity = "displacement"
    axial: complex = 0.0
    under: Sequence[At] | None = None

    def _describe(self, path: str) -> dict[str, Plain]:
        one_of(self.quantity, get_args(MotionQuantity), f"{path}.quantity")
        given: dict[str, Plain] = {
            "kind": "ground",
            "quantity": self.quantity,
            "value": _direction(self.value, f"{path}.value"),
            "axial": phasor(self.axial, f"{path}.axial"),
        }
        if self.under is not None:
            listed = enumerate(items(self.under, f"{path}.under", "places"))
            given["under"] = [place(at, f"{path}.under[{i}]", "place") for i, at in listed]
        return given


@dataclass(frozen=True)
class ShaftExcitation(Part):
    """Bow, unbalance and turning forces of a shaft, as a source of a frequency response.

    The source rotates with the frequency ω. Its amplitude is that of the shaft at the spin ω: the
    force of the bow, forces of order 1 and eccentric couplings do not depend on ω, and the force
    of an unbalance is U ω². At the frequency of the spin the response is that of `synchronous`.
    Where planets move laterally on a carrier that turns with Ω_c, ω is the frequency seen from the
    carrier and ω + Ω_c the spin.

    Parameters
    ----------
    shaft : str
        Name of the shaft.
    excitation : {"both", "bow", "unbalance"}
        The excitation; "both" contains turning forces, too.

    Examples
    --------
    >>> import gearbow as gb
    >>> gb.ShaftExcitation("input", "unbalance").shaft
    'input'
    """

    shaft: str
    excitation: Excitation = "both"

    def _describe(self, path: str) -> dict[str, Plain]:
        one_of(self.excitation, get_args(Excitation), f"{path}.excitation")
        shaft = text(self.shaft, f"{path}.shaft")
        return {"kind": "shaft", "shaft": shaft, "excitation": self.excitation}


#: A source of a frequency response.
Source: TypeAlias = Force | Torque | MeshExcitation | GroundMotion | ShaftExcitation


def plain_sources(source: object) -> tuple[list[dict[str, Plain]], list[str]]:
    """Give plain data of one or several sources, and a label of each."""
    listed: list[Any]
    if isinstance(source, Part):
        listed = [source]
    elif isinstance(source, Iterable) and not isinstance(source, str):
        listed = list(source)
    else:
        listed = []
    if not listed:
        raise SceneError(f"source: must be a source or a list of them, got {shown(source)}")
    plain = [_plain(one, f"source[{i}]") for i, one in enumerate(listed)]
    return plain, [_label(one) for one in listed]


def _plain(source: Any, path: str) -> dict[str, Plain]:
    if isinstance(source, Part):
        source = source._in_si(path)
    if isinstance(source, MeshExcitation | GroundMotion | ShaftExcitation):
        return source._describe(path)
    if isinstance(source, Force):
        if source.order is not None:
            raise SceneError(f"{path}.order: a harmonic force has none; give (F, -1j * F)")
        return {
            "kind": "force",
            "at": place(source.at, f"{path}.at", "place"),
            "value": _direction(source.value, f"{path}.value"),
            "axial": phasor(source.axial, f"{path}.axial"),
        }
    if isinstance(source, Torque):
        value = phasor(source.value, f"{path}.value")
        return {"kind": "torque", "at": place(source.at, f"{path}.at", "place"), "value": value}
    names = "gb.Force, gb.Torque, gb.MeshExcitation, gb.GroundMotion or gb.ShaftExcitation"
    raise SceneError(f"{path}: must be a {names}, got {shown(source)}")


def _label(source: Source) -> str:
    """Give a label of a source in figures and tables."""
    if isinstance(source, MeshExcitation):
        return f"mesh {'/'.join(place(source.at, 'source', 'mesh'))}"
    if isinstance(source, GroundMotion):
        return f"ground {source.quantity}"
    if isinstance(source, ShaftExcitation):
        return f"shaft {source.shaft}"
    kind = "force" if isinstance(source, Force) else "torque"
    return f"{kind} at {place_label(place(source.at))}"


def phasor(value: object, path: str) -> Plain:
    """Convert a finite phasor to the pair [re, im]."""
    found = complex_number(value, path)
    pair = found if isinstance(found, list) else [found, 0.0]
    if len(pair) != 2 or not all(abs(part) < float("inf") for part in pair):
        raise SceneError(f"{path}: must be a finite complex number, got {shown(value)}")
    return [float(part) for part in pair]


def _direction(value: object, path: str) -> Plain:
    """Convert a direction y + iz, or phasors along y and z, to two pairs [re, im]."""
    if isinstance(value, tuple | list):
        if len(value) != 2:
            raise SceneError(f"{path}: must be y + iz or (y, z), got {shown(value)}")
        return [phasor(part, f"{path}[{i}]") for i, part in enumerate(value)]
    y, z = phasor(value, path)
    return [[y, 0.0], [z, 0.0]]


@dataclass(frozen=True)
class ThermalBow(Part):
    """A bow by the uneven heating of a journal, which its synchronous vibration causes.

    The side of a journal that is always nearest to the film or a seal becomes hotter than the
    other. The temperature difference T [K], a phasor that is fixed in the shaft, bends the shaft
    by b = B T and follows the vibration y at the journal slowly, τ dT/dt = g y - T.

    Parameters
    ----------
    at : str or tuple of (str, float)
        The journal, (shaft, position [m]), or a gear or disk by name.
    gain : complex or callable
        Temperature difference over the vibration, g [K/m]; its argument is the angle by which the
        hot spot is ahead of the high spot, in the direction of the shaft angle. A function has the
        speed of the shaft [rad/s] as its argument.
    time_constant : float
        Time constant τ of the temperature difference [s].
    shape : Bow
        Bow of the shaft at T = 1 K, with the hot spot along y.

    Examples
    --------
    >>> import gearbow as gb
    >>> shape = gb.Bow.half_sine(1e-6)
    >>> gb.ThermalBow(("rotor", 0.1), gain=2e5 - 1e5j, time_constant=300.0, shape=shape).gain
    (200000-100000j)
    """

    at: At
    gain: complex | Callable[[float], complex]
    time_constant: float
    shape: Bow

    def __post_init__(self) -> None:
        place(self.at, "at", "place")
        positive(self.time_constant, "time_constant")
        expect(self.shape, Bow, "shape")
        if not callable(self.gain):
            phasor(self.gain, "gain")

    def _gains(self, speeds: Array) -> ComplexArray:
        """Give the gain [K/m] at speeds of the shaft [rad/s]."""
        gain = self.gain
        values = [gain(float(speed)) if callable(gain) else gain for speed in speeds]
        pairs = np.array([phasor(value, "gain") for value in values], dtype=float)
        found: ComplexArray = pairs.reshape(-1, 2) @ np.array([1.0, 1j])
        return found
