"""Shafts: material, segments, the shaft itself, and sleeves around it.

A part is an immutable record of its arguments. `gearbow.RotorSystem` checks all of them; the error
names the entry.
"""

import math
from collections.abc import Sequence
from dataclasses import KW_ONLY, dataclass, replace
from typing import Any

import numpy as np

from gearbow._convert import real
from gearbow._types import Plain
from gearbow.description.bow import Bow
from gearbow.description.part import Part, expect, parts


@dataclass(frozen=True)
class Material(Part):
    """Isotropic elastic material.

    Parameters
    ----------
    youngs_modulus, density : float
        Young's modulus E [Pa] and density ρ [kg/m³].
    poisson_ratio : float, optional
        Poisson's ratio ν; give either this or `shear_modulus`.
    shear_modulus : float, optional
        Shear modulus G [Pa]; E = 2G(1 + ν) relates it to Poisson's ratio.

    Examples
    --------
    >>> import gearbow as gb
    >>> titanium = gb.Material(114e9, 4430.0, poisson_ratio=0.34)
    """

    youngs_modulus: float
    density: float
    poisson_ratio: float | None = None
    shear_modulus: float | None = None


#: Steel: 207 GPa, Poisson's ratio 0.3, 7850 kg/m³.
STEEL = Material(youngs_modulus=207e9, density=7850.0, poisson_ratio=0.3)


@dataclass(frozen=True)
class Segment(Part):
    """A segment of a stepped shaft: a cylinder, or a cone.

    Parameters
    ----------
    length : float
        Length [m].
    outer_diameter : float
        Outer diameter [m], of a cone that at its begin.
    inner_diameter : float
        Diameter of the bore [m], of a conical bore that at its begin.
    elements : int, optional
        Minimum number of elements; None is 1 if another segment of the shaft has a number. If none
        has, gearbow chooses all numbers.
    end_outer_diameter, end_inner_diameter : float, optional
        Diameters of a cone and of a conical bore at their ends [m]; None is that at the begin.
    material : Material, optional
        Material; None is that of the shaft.

    Notes
    -----
    The shape functions of a conical element are its static solutions, and its matrices are Gauss
    integrals over the cone, so that one element has the exact flexibility.

    Examples
    --------
    >>> import gearbow as gb
    >>> seat = gb.Segment(length=0.1, outer_diameter=0.06)
    >>> cone = gb.Segment(0.1, 0.06, end_outer_diameter=0.04)
    """

    length: float
    outer_diameter: float
    inner_diameter: float = 0.0
    elements: int | None = None
    _: KW_ONLY
    end_outer_diameter: float | None = None
    end_inner_diameter: float | None = None
    material: Material | None = None

    @property
    def _ends(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """Give outer and inner diameter at the begin, and at the end [m]."""
        outer, inner = self.end_outer_diameter, self.end_inner_diameter
        return (self.outer_diameter, self.inner_diameter), (
            self.outer_diameter if outer is None else outer,
            self.inner_diameter if inner is None else inner,
        )

    def _between(self, begin: float, end: float) -> "Segment":
        """Give the part between two fractions of the length."""
        first, last = np.array(self._ends)
        (outer, inner), (end_outer, end_inner) = (
            (first + part * (last - first)).tolist() for part in (begin, end)
        )
        diameters: dict[str, Any] = {}
        if self.end_outer_diameter is not None:
            diameters |= {"outer_diameter": outer, "end_outer_diameter": end_outer}
        if self.end_inner_diameter is not None:
            diameters |= {"inner_diameter": inner, "end_inner_diameter": end_inner}
        return replace(self, length=(end - begin) * self.length, elements=1, **diameters)


@dataclass(frozen=True)
class Sleeve(Part):
    """A tube around a shaft: the hub of an impeller or a coupling, a shrunk ring, a bush.

    Its mass and inertia belong to the shaft. How much it stiffens the shaft depends on its fit: a
    shrink fit may carry all of the bending, a loose one nothing.

    Parameters
    ----------
    shaft : str
        Name of the shaft.
    begin, end : float
        Positions of its ends [m], which become nodes.
    outer_diameter : float
        Outer diameter [m].
    inner_diameter : float
        Inner diameter [m], at least the diameter of the shaft there.
    material : Material
        Material.
    stiffness : {"none", "full"} or float
        What it adds to the rigidities of the shaft (bending, shear, torsion and extension): "none"
        of its own, all of it, or a fraction from 0 to 1. There is no slip.

    Examples
    --------
    >>> import gearbow as gb
    >>> hub = gb.Sleeve("rotor", 0.2, 0.3, outer_diameter=0.1, inner_diameter=0.06)
    >>> shrunk = gb.Sleeve("rotor", 0.4, 0.5, 0.08, 0.06, stiffness="full")
    """

    shaft: str
    begin: float
    end: float
    outer_diameter: float
    inner_diameter: float
    material: Material = STEEL
    stiffness: str | float = "none"


@dataclass(frozen=True)
class Notch(Part):
    """A notch of a shaft: a shoulder, a groove, a keyway or the end of a hub.

    It has no effect on the motion; `RotorSystem.stresses` multiplies the alternating stresses there
    by its factors, which tables of DIN 743-2 or Peterson give for the shape, the radius and the
    strength of the material.

    Parameters
    ----------
    shaft : str
        Name of the shaft.
    position : float
        Position on the shaft [m].
    bending, torsion : float
        Fatigue notch factors of bending and axial stresses, and of torsion, at least 1.

    Examples
    --------
    >>> import gearbow as gb
    >>> keyway = gb.Notch("rotor", 0.3, bending=2.1, torsion=1.7)
    """

    shaft: str
    position: float
    bending: float = 1.0
    torsion: float = 1.0


@dataclass(frozen=True)
class Shaft(Part):
    """A shaft of Timoshenko beam elements along x, uniform or stepped.

    Parameters
    ----------
    name : str
        Name, unique in the system.
    length, outer_diameter, inner_diameter : float
        Length, outer diameter and diameter of the bore of a uniform shaft [m].
    elements : int, optional
        Minimum number of elements of a uniform shaft. The position of every gear, disk, bearing
        and torque becomes a node: the element there is split. None lets gearbow choose number and
        degree, see `gearbow.RotorSystem.discretisation`.
    degree : int, optional
        Degree p of the elements, 1 to 8; None is 1 if a number of elements is given. The relative
        error of natural frequencies decreases as (element length)^(2p). Static displacements of
        nodes are exact for any degree.
    segments : sequence of Segment
        The segments from x = 0 on, instead of length, diameters and number of elements.
    material : Material
        Material of the shaft, and of all segments without one.
    shear : bool
        Whether the model includes shear deformation; False is the Rayleigh beam.
    axial_force : float
        Axial force [N], positive for tension, which stiffens the shaft; buckling is an error.
    internal_damping : float
        Internal damping β [s]: viscous damping βK of the shaft in coordinates that rotate with it,
        of hysteresis and fits. Above a critical speed it makes the rotor unstable where the
        damping of the bearings does not prevent it. It damps torsion and axial motion as well.
    loss_factor : float
        Loss factor η of the material, K(1 + iη sgn(ω - Ω)) in coordinates that rotate with the
        shaft: structural damping of modes, Campbell diagrams, `frequency_response` and
        `synchronous`. Runs refuse it.
    bow : Bow, optional
        Residual bow; None is a straight shaft.
    speed_ratio : float, optional
        Signed speed over that of the reference shaft, for a shaft that no mesh or coupling connects
        to it: the other spool of a dual rotor. In a planetary stage whose carrier turns, 0 is a sun
        or a ring at rest.

    Notes
    -----
    Shape functions: Nelson, *A finite rotating shaft element using Timoshenko beam theory*, J.
    Mech. Des. 102 (1980); shear coefficient: Cowper (1966).

    Examples
    --------
    >>> import gearbow as gb
    >>> bow = gb.Bow.half_sine(1.5e-4)
    >>> shaft = gb.Shaft("input", length=0.5, outer_diameter=0.05, bow=bow)
    >>> steps = [gb.Segment(0.1, 0.04), gb.Segment(0.4, 0.05)]
    >>> stepped = gb.Shaft("output", segments=steps)
    """

    name: str
    _: KW_ONLY
    length: float | None = None
    outer_diameter: float | None = None
    inner_diameter: float = 0.0
    elements: int | None = None
    degree: int | None = None
    segments: Sequence[Segment] | None = None
    material: Material = STEEL
    shear: bool = True
    axial_force: float = 0.0
    internal_damping: float = 0.0
    loss_factor: float = 0.0
    bow: Bow | None = None
    speed_ratio: float | None = None

    def _describe(self, path: str) -> dict[str, Plain]:
        shaft = self
        if self.bow is not None and expect(self.bow, Bow, f"{path}.bow").curve is not None:
            length = self._length(path)
            bow = None if length is None else self.bow._sampled(length, f"{path}.bow")
            shaft = replace(self, bow=bow)
        return super(Shaft, shaft)._describe(path)

    def _length(self, path: str) -> float | None:
        """Give the length for the sampling of a bow curve; None unless positive and finite."""
        if self.segments is None:
            lengths = [] if self.length is None else [real(self.length, f"{path}.length")]
        else:
            segments = parts(self.segments, Segment, f"{path}.segments")
            lengths = [
                real(segment.length, f"{path}.segments[{i}].length")
                for i, segment in enumerate(segments)
            ]
        length = math.fsum(lengths)
        return length if 0.0 < length < math.inf else None


def segments_of(shaft: Shaft) -> Sequence[Segment]:
    """Give the segments of a shaft; one for a uniform shaft."""
    if shaft.segments is not None:
        return shaft.segments
    sizes = (shaft.length or 0.0, shaft.outer_diameter or 0.0, shaft.inner_diameter)
    return (Segment(*sizes, shaft.elements),)
