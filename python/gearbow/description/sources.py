"""Sources of harmonic excitation, and the bow that heat causes."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import KW_ONLY, dataclass
from typing import Any, TypeAlias, get_args

import numpy as np

from gearbow._convert import complex_number, items, positive, shown, text
from gearbow._lookup import one_of
from gearbow._types import Array, At, ComplexArray, Excitation, MotionQuantity, Plain
from gearbow.description.bow import Bow
from gearbow.description.loads import Force, Torque
from gearbow.description.part import Part, expect
from gearbow.description.places import place, place_label
from gearbow.errors import SceneError


@dataclass(frozen=True)
class MeshExcitation(Part):
    """A harmonic transmission error of a mesh, as a source of a frequency response.

    Parameters
    ----------
    at : str or tuple of (str, str)
        The mesh, "driver/driven" or (driver, driven) in either order.
    error : complex
        Phasor e of the unloaded transmission error along the line of action in the transverse
        section [m]. It acts on the drive flank with the force (k + iωc) e there, as material
        removed from the flank.

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
        Bearings (shaft, position [m]), and supports and housings by name, below which the ground
        moves; None is all of them.

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
    Where planets move laterally on a carrier that turns with Ω_c, ω is the frequency on the carrier
    and ω + Ω_c the spin.

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
    """Give the plain data of a source."""
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

    Raises
    ------
    SceneError
        If a value is invalid.

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
