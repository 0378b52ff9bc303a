"""Scenes in two forms: as input of the package and as input of the independent assembly."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

import gearbow as gb
from reference import published
from reference.bows import HalfSine, Kinked
from reference.closed_forms import full_depth_gear, solid_disk
from reference.elements import Section
from reference.mesh_law import MeshLaw
from reference.train import BearingSpec, MeshSpec, RigidSpec, ShaftPart, ShaftSpec, Train

E, NU, DENSITY = 207e9, 0.3, 7850.0  # the default steel of the interface
G = E / (2 * (1 + NU))


@dataclass(frozen=True)
class GearAt:
    name: str
    shaft: str
    position: float
    teeth: int
    unbalance: complex = 0j


@dataclass(frozen=True)
class Geared:
    """A chain of equal shafts with standard gears and two end bearings each; defaults: the demo."""

    shafts: Sequence[str] = ("input", "middle", "output")
    gears: Sequence[GearAt] = (
        GearAt("g1", "input", 0.25, 25),
        GearAt("g2", "middle", 0.125, 50),
        GearAt("g3", "middle", 0.375, 25),
        GearAt("g4", "output", 0.25, 50),
    )
    meshes: Sequence[tuple[str, str]] = (("g1", "g2"), ("g3", "g4"))
    ratios: Sequence[float] = (1.0, -0.5, 0.25)
    bows: Mapping[str, HalfSine | Kinked] = field(default_factory=dict)
    angles: Sequence[float] = (0.0, 0.0)  # of the centre lines
    module: float = 3e-3
    pressure_angle: float = np.radians(20)
    face_width: float = 0.03
    length: float = 0.5
    diameter: float = 0.05
    elements: int = 4
    degree: int | None = None
    mesh_stiffness: float = 2e8
    mesh_damping_ratio: float = 0.05
    bearing_stiffness: Any = 1e8  # number or 2 x 2
    bearing_damping: Any = 500.0
    torque: float = 250.0
    gravity: tuple[float, float] | None = None
    modal_damping: float | None = None
    centre_distance_factor: float = 1.0
    sigma: float = 1.0  # sign of the spin of the first shaft, only for the independent mesh
    options: Mapping[str, Any] = field(default_factory=dict)  # only for RotorSystem

    def package(self) -> gb.RotorSystem:
        torques = []
        if self.torque:
            last = self.gears[-1].name
            torques = [gb.Torque(self.gears[0].name, self.torque), gb.Torque.balance(last)]
        options = dict(self.options)
        if self.gravity is not None:
            options["gravity"] = list(self.gravity)
        if self.modal_damping is not None:
            options["modal_damping"] = self.modal_damping
        return gb.RotorSystem(
            shafts=[
                gb.Shaft(
                    name,
                    length=self.length,
                    outer_diameter=self.diameter,
                    elements=self.elements,
                    degree=self.degree,
                    bow=self.bows[name].package(self.length) if name in self.bows else None,
                )
                for name in self.shafts
            ],
            gears=[
                gb.Gear(
                    gear.name,
                    shaft=gear.shaft,
                    position=gear.position,
                    teeth=gear.teeth,
                    module=self.module,
                    face_width=self.face_width,
                    pressure_angle=self.pressure_angle,
                    unbalance=gear.unbalance,
                )
                for gear in self.gears
            ],
            meshes=[
                gb.Mesh(
                    driver,
                    driven,
                    stiffness=self.mesh_stiffness,
                    damping_ratio=self.mesh_damping_ratio,
                    centre_line_angle=angle,
                    centre_distance=self._centre_distance(driver, driven),
                )
                for (driver, driven), angle in zip(self.meshes, self.angles, strict=True)
            ],
            bearings=[
                gb.Bearing(
                    shaft,
                    position=x,
                    stiffness=self.bearing_stiffness,
                    damping=self.bearing_damping,
                )
                for shaft in self.shafts
                for x in (0.0, self.length)
            ],
            torques=torques,
            **options,
        )

    def _gear(self, name: str) -> GearAt:
        return next(gear for gear in self.gears if gear.name == name)

    def _centre_distance(self, driver: str, driven: str) -> float | None:
        if self.centre_distance_factor == 1.0:
            return None
        teeth = self._gear(driver).teeth + self._gear(driven).teeth
        return self.centre_distance_factor * self.module * teeth / 2

    def polar(self, gear: GearAt) -> float:
        return solid_disk(self.module * gear.teeth / 2, self.face_width, DENSITY)[2]

    def law(self, index: int) -> MeshLaw:
        a, b = (self._gear(name) for name in self.meshes[index])
        round_a, round_b = (
            full_depth_gear(g.teeth, self.module, self.pressure_angle) for g in (a, b)
        )
        r_a, r_b = round_a["base"], round_b["base"]
        effective_mass = 1 / (r_a**2 / self.polar(a) + r_b**2 / self.polar(b))
        spin = self.sigma * self.ratios[list(self.shafts).index(a.shaft)]
        return MeshLaw(
            base_radius_a=r_a,
            base_radius_b=r_b,
            centre_distance=self.centre_distance_factor * (round_a["pitch"] + round_b["pitch"]),
            centre_line_angle=self.angles[index],
            stiffness=self.mesh_stiffness,
            damping=2 * self.mesh_damping_ratio * np.sqrt(self.mesh_stiffness * effective_mass),
            sigma=float(np.sign(spin)),
            tip_radius_a=round_a["tip"],
            tip_radius_b=round_b["tip"],
            teeth_a=a.teeth,
        )

    def reference(self) -> Train:
        part = ShaftPart(self.length, Section(self.diameter, E, G, DENSITY), self.elements)
        shafts = []
        for name, ratio in zip(self.shafts, self.ratios, strict=True):
            bow = self.bows.get(name)
            curves = (bow.curve(self.length), bow.slope(self.length)) if bow else (None, None)
            shafts.append(ShaftSpec(name, [part], ratio, *curves))
        rigid = [
            RigidSpec(
                gear.name,
                gear.shaft,
                gear.position,
                *solid_disk(self.module * gear.teeth / 2, self.face_width, DENSITY),
                gear.unbalance,
            )
            for gear in self.gears
        ]
        stiffness, damping = (
            np.eye(2) * x if np.ndim(x) == 0 else np.asarray(x)
            for x in (self.bearing_stiffness, self.bearing_damping)
        )
        bearings = [
            BearingSpec(name, x, stiffness, damping)
            for name in self.shafts
            for x in (0.0, self.length)
        ]
        torques = []
        if self.torque:
            # balance: the torques do no work on the rigid-body rotation
            first, last = (self._gear(self.gears[i].name).shaft for i in (0, -1))
            ratio = dict(zip(self.shafts, self.ratios, strict=True))
            load = -self.torque * ratio[first] / ratio[last]
            torques = [(self.gears[0].name, self.torque), (self.gears[-1].name, load)]
        meshes = [MeshSpec(a, b, self.law(i)) for i, (a, b) in enumerate(self.meshes)]
        turning = bool(self.options.get("bow_torque"))
        gravity = self.gravity or (0.0, 0.0)
        return Train(shafts, rigid, bearings, meshes, torques, gravity, turning)


PAIR = Geared(
    shafts=("input", "output"),
    gears=(GearAt("g1", "input", 0.25, 25), GearAt("g2", "output", 0.25, 50)),
    meshes=(("g1", "g2"),),
    ratios=(1.0, -0.5),
    angles=(0.0,),
)

CHAIN = Geared(
    shafts=("s1", "s2", "s3", "s4"),
    gears=(
        GearAt("g1", "s1", 0.25, 20),
        GearAt("g2", "s2", 0.125, 40),
        GearAt("g3", "s2", 0.375, 20),
        GearAt("g4", "s3", 0.125, 40),
        GearAt("g5", "s3", 0.375, 20),
        GearAt("g6", "s4", 0.25, 40),
    ),
    meshes=(("g1", "g2"), ("g3", "g4"), ("g5", "g6")),
    ratios=(1.0, -0.5, 0.25, -0.125),
    angles=(0.3, -0.8, 2.0),
)


def single_shaft(
    bow: gb.Bow | None = None,
    *,
    length: float = 1.0,
    diameter: float = 0.05,
    inner_diameter: float = 0.0,
    elements: int = 8,
    degree: int | None = None,
    density: float = 7800.0,
    youngs_modulus: float = E,
    poisson_ratio: float = NU,
    shear: bool = True,
    support: float | None = 1e13,
    **more: Any,
) -> gb.RotorSystem:
    """Give one uniform shaft "s" on stiff end bearings (none if support is None)."""
    material = gb.Material(
        youngs_modulus=youngs_modulus, density=density, poisson_ratio=poisson_ratio
    )
    bearings = list(more.pop("bearings", []))
    if support is not None:
        bearings += [gb.Bearing("s", position=x, stiffness=support) for x in (0.0, length)]
    return gb.RotorSystem(
        shafts=[
            gb.Shaft(
                "s",
                length=length,
                outer_diameter=diameter,
                inner_diameter=inner_diameter,
                elements=elements,
                degree=degree,
                material=material,
                shear=shear,
                bow=bow,
            )
        ],
        bearings=bearings,
        **more,
    )


def v1() -> gb.RotorSystem:
    material = gb.Material(
        youngs_modulus=published.V1_E,
        density=published.V1_DENSITY,
        shear_modulus=published.V1_G,
    )
    names = ("rotor1", "rotor2")
    nodes = [np.concatenate([[0.0], np.cumsum(lengths)]) for lengths in published.V1_LENGTHS]
    with warnings.catch_warnings():
        # the published radii are rounded: base pitches differ by 0.02 %
        warnings.simplefilter("ignore", gb.SceneWarning)
        return gb.RotorSystem(
            shafts=[
                gb.Shaft(
                    name,
                    segments=[
                        gb.Segment(length=length, outer_diameter=diameter, elements=1)
                        for length, diameter in zip(lengths, diameters, strict=True)
                    ],
                    material=material,
                )
                for name, lengths, diameters in zip(
                    names, published.V1_LENGTHS, published.V1_DIAMETERS, strict=True
                )
            ],
            disks=[
                gb.Disk(name, names[s], nodes[s][i], mass, diametral, polar)
                for name, s, i, mass, diametral, polar in published.V1_DISKS
            ],
            gears=[
                gb.Gear(
                    name,
                    shaft=names[s],
                    position=nodes[s][i],
                    teeth=teeth,
                    base_radius=radius,
                    face_width=0.1,
                    pressure_angle=published.V1_PRESSURE_ANGLE,
                    mass=mass,
                    diametral_inertia=diametral,
                    polar_inertia=polar,
                )
                for name, s, i, mass, diametral, polar, radius, teeth in published.V1_GEARS
            ],
            meshes=[gb.Mesh("wheel", "pinion", stiffness=published.V1_MESH_STIFFNESS)],
            bearings=[
                gb.Bearing(
                    names[s],
                    position=nodes[s][i],
                    stiffness=(kyy, kzz),
                    damping=published.V1_BEARING_DAMPING,
                )
                for s, i, kyy, kzz in published.V1_BEARINGS
            ],
        )


def v2() -> gb.RotorSystem:
    cm = np.array(published.V2_STATIONS) / 100
    position, mass, diametral, polar = published.V2_DISK
    return gb.RotorSystem(
        shafts=[
            gb.Shaft(
                "shaft",
                segments=[
                    gb.Segment(
                        length=cm[i + 1] - cm[i],
                        outer_diameter=outer / 100,
                        inner_diameter=published.V2_BORES.get(i + 1, 0.0) / 100,
                        elements=1,
                    )
                    for i, outer in enumerate(published.V2_OUTER)
                ],
                material=gb.Material(
                    youngs_modulus=published.V2_E,
                    density=published.V2_DENSITY,
                    poisson_ratio=published.V2_POISSON,
                ),
                shear=False,
            )
        ],
        disks=[gb.Disk("disk", "shaft", position, mass, diametral, polar)],
        bearings=[
            gb.Bearing("shaft", position=cm[i - 1], stiffness=published.V2_BEARING_STIFFNESS)
            for i in published.V2_BEARING_STATIONS
        ],
    )


def v3(**options: Any) -> gb.RotorSystem:
    return gb.RotorSystem(
        shafts=[
            gb.Shaft(
                "shaft",
                length=published.V3_LENGTH,
                outer_diameter=published.V3_DIAMETER,
                elements=published.V3_ELEMENTS,
                material=gb.Material(
                    youngs_modulus=published.V3_E,
                    density=published.V3_DENSITY,
                    shear_modulus=published.V3_G,
                ),
            )
        ],
        disks=[gb.Disk(name, "shaft", x, m, d, p) for name, x, m, d, p in published.V3_DISKS],
        bearings=[
            gb.Bearing("shaft", position=x, stiffness=published.V3_BEARING)
            for x in (0.0, published.V3_LENGTH)
        ],
        **options,
    )
