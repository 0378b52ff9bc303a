"""Formulas for the teeth of a mesh: pairs on the path of contact, stored energy and gradient.

Pair j is at s_j = r_a [sigma (angle_a - gamma) + alpha] + j p_b from the interference point of a.
It is in contact between C sin(alpha) - reach_b and reach_a, reach^2 = tip^2 - base^2, limited to
the segment between the base circles. Stored energy U = 1/2 sum w k (delta - r)^2.
Forces are complex-step derivatives of U; there are no analytical derivatives.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import quad, solve_ivp
from scipy.linalg import expm

import gearbow as gb
from reference.bows import HalfSine
from reference.closed_forms import full_depth_gear, solid_disk
from reference.elements import Section
from reference.mesh_law import MeshLaw
from reference.train import BearingSpec, MeshSpec, RigidSpec, ShaftPart, ShaftSpec, Train

Array = NDArray[np.float64]
E, NU, DENSITY = 207e9, 0.3, 7850.0
G = E / (2 * (1 + NU))
TINY = 1e-30  # complex step


@dataclass(frozen=True)
class TeethLaw:
    """Tooth stiffness, relief, backlash and errors; `law` gives only geometry and damping."""

    law: MeshLaw
    pair: Callable[[Any], Any] | None = None  # stiffness of one pair as a function of s
    cycle: Callable[[Any], Any] | None = None  # mesh stiffness as a function of s / p_b
    width: float = 0.0  # width of a smooth engagement / p_b; 0 is sharp
    twist: bool = True  # the twist of the driver moves the teeth
    live: bool = True
    relief: tuple[float, float, int] | None = None  # amount, length, exponent
    backlash: float | None = None
    film: bool = False  # damping acts in separation too
    error: Callable[[Any, Any], Any] | None = None  # error as a function of the spin angles
    runout: tuple[complex, complex] = (0j, 0j)

    def reaches(self) -> tuple[float, float]:
        a, b = self.law, self.law
        return (
            float(np.sqrt(a.tip_radius_a**2 - a.base_radius_a**2)),
            float(np.sqrt(b.tip_radius_b**2 - b.base_radius_b**2)),
        )

    def path(self, distance: Any) -> tuple[Any, Any]:
        a, b = self.reaches()
        segment = np.sqrt(distance**2 - self.law.sum_of_radii**2)
        # a sufficiently large tip circle contains the whole segment
        low = np.where(np.real(segment) > b, segment - b, 0.0)
        return low, np.where(np.real(segment) > a, a, segment)

    def _centres(self, q: Any, angles: Sequence[Any]) -> tuple[Any, Any]:
        """Give the relative displacement u_b - u_a of the base-circle centres in (y, z)."""
        apart = [q[3] - q[0], q[4] - q[1]]
        for sign, out, angle, twist in zip((-1, 1), self.runout, angles, (q[2], q[5]), strict=True):
            turned = angle + twist
            apart[0] = apart[0] + sign * (out.real * np.cos(turned) - out.imag * np.sin(turned))
            apart[1] = apart[1] + sign * (out.real * np.sin(turned) + out.imag * np.cos(turned))
        return apart[0], apart[1]

    def _lie(self, apart: tuple[Any, Any]) -> tuple[Any, Any, Any]:
        """Give centre distance, pressure angle, and centre-line angle relative to psi."""
        law = self.law
        cos, sin = np.cos(law.centre_line_angle), np.sin(law.centre_line_angle)
        along = law.centre_distance + cos * apart[0] + sin * apart[1]
        across = cos * apart[1] - sin * apart[0]
        distance = np.sqrt(along**2 + across**2)
        return distance, np.arccos(law.sum_of_radii / distance), np.arctan(across / along)

    def deflection(self, q: Any, angles: Sequence[Any], back: bool = False) -> Any:
        law, apart = self.law, self._centres(q, angles)
        sigma = -law.sigma if back else law.sigma
        rolled = law.base_radius_a * q[2] + law.base_radius_b * q[5]
        alpha_0 = law.angle_at_rest
        if self.live:
            _, alpha, off = self._lie(apart)
            opened = np.tan(alpha) - alpha - (np.tan(alpha_0) - alpha_0)
            delta = sigma * (rolled - law.sum_of_radii * off) - law.sum_of_radii * opened
        else:
            psi = law.centre_line_angle
            n = (
                -sigma * np.cos(alpha_0) * np.sin(psi) + np.sin(alpha_0) * np.cos(psi),
                sigma * np.cos(alpha_0) * np.cos(psi) + np.sin(alpha_0) * np.sin(psi),
            )
            delta = sigma * rolled - n[0] * apart[0] - n[1] * apart[1]
        if back:
            return delta - (self.backlash or 0.0)
        return delta - self.error(*angles) if self.error else delta

    def place(self, q: Any, angles: Sequence[Any], back: bool = False) -> tuple[Any, Any, Any]:
        """Give the position of pair 0 and the ends of the path."""
        law = self.law
        if self.live:
            distance, alpha, off = self._lie(self._centres(q, angles))
        else:
            distance, alpha, off = law.centre_distance, law.angle_at_rest, 0.0
        turned = angles[0] + q[2] if self.twist else angles[0]
        sigma = -law.sigma if back else law.sigma
        s = law.base_radius_a * (sigma * (turned - law.centre_line_angle - off) + alpha)
        low, high = self.path(distance)
        # the tooth thickness is half a pitch on the reference circle of a 20 degree rack,
        # and larger on the base circle
        rack = np.radians(20)
        thickness = law.base_pitch / 2 + 2 * law.base_radius_a * (np.tan(rack) - rack)
        return s + (thickness if back else 0.0), low, high

    def weight(self, distance: Any) -> Any:
        if self.width == 0.0:
            return np.where(np.real(distance) >= 0, 1.0, 0.0)
        x = distance / (self.width * self.law.base_pitch) + 0.5
        ramp = 6 * x**5 - 15 * x**4 + 10 * x**3
        return np.where(np.real(x) <= 0, 0.0, np.where(np.real(x) >= 1, 1.0, ramp))

    def energy(self, place: tuple[Any, Any, Any], delta: Any) -> Any:
        s, low, high = place
        pitch = self.law.base_pitch
        if self.cycle is not None:
            return self.cycle(s / pitch) * delta**2 / 2
        assert self.pair is not None
        first = int(np.floor((np.real(low) - np.real(s)).min() / pitch)) - 1
        # one row for each pair
        at = s + pitch * np.arange(first, first + 7)[:, None]
        d: Any = delta
        if self.relief is not None:
            amount, length, exponent = self.relief
            x = 1 - np.stack([at - low, high - at]) / length
            d = delta - np.where(np.real(x) > 0, amount * x**exponent, 0.0).sum(axis=0)
            d = np.where(np.real(d) > 0, d, 0.0)
        weight = self.weight(at - low) * self.weight(high - at)
        return np.sum(weight * self.pair(at) * d**2 / 2, axis=0)

    def flank(
        self, q: Array, qd: Array, angles: Array, spins: Array, back: bool
    ) -> tuple[Any, Array, Array]:
        """Give deflection, tooth force and generalised forces as if the flank is loaded."""
        steps = np.zeros((6, 8), dtype=complex)  # six coordinates, time, deflection
        steps[:, :6] = TINY * 1j * np.eye(6)
        moved = q[:, None] + steps
        time = np.zeros(8, dtype=complex)
        time[6] = TINY * 1j
        turned = [angles[0] + spins[0] * time, angles[1] + spins[1] * time]
        delta = np.broadcast_to(self.deflection(moved, turned, back), 8)
        gradient = delta.imag / TINY
        rate = gradient[:6] @ qd + gradient[6]
        push = np.array([0, 0, 0, 0, 0, 0, 0, TINY * 1j])
        where = self.place(moved, turned, back) if self.twist else self.place(q, angles, back)
        energy = np.broadcast_to(self.energy(where, delta + push), 8).imag / TINY
        force = energy[7] + self.law.damping * rate
        # a prescribed stiffness acts only along the line of action
        generalised = energy[:6] if self.twist else energy[7] * gradient[:6]
        viscous = self.law.damping * rate
        if self.film and delta[0].real <= 0:
            return delta[0].real, viscous, -viscous * gradient[:6]
        return delta[0].real, force, -(generalised + viscous * gradient[:6])

    def force(self, q: Array, qd: Array, angles: Array, spins: Array) -> tuple[float, Array]:
        """Give drive-flank force minus back-flank force, and generalised forces as in `MeshLaw`."""
        if self.backlash is None:
            _, force, out = self.flank(q, qd, angles, spins, False)
            return float(force), out
        total, both, touches = 0.0, np.zeros(6), False
        for sign, back in ((1, False), (-1, True)):
            if self.deflection(q, angles, back) > 0:
                _, force, out = self.flank(q, qd, angles, spins, back)
                if force > 0 or self.film:
                    total, both, touches = total + sign * float(force), both + out, True
        if self.film and not touches:
            _, total, both = self.flank(q, qd, angles, spins, False)
        return total, both


@dataclass(frozen=True)
class Toothed:
    """A pair of gears on two shafts, as input of the package and of the independent train."""

    mesh: Mapping[str, Any] = field(default_factory=dict)  # fields of gb.Mesh
    teeth: tuple[int, int] = (25, 50)
    module: float = 3e-3
    face_width: float = 0.02
    gear: Mapping[str, tuple[Any, Any]] = field(
        default_factory=dict
    )  # further fields of gb.Gear, per gear
    torque: float = 0.0  # on the driver, balanced at the driven gear
    bearing_damping: float = 300.0
    coupled: bool = False  # otherwise only torsion of two inertias on thin shafts
    inertia: tuple[float, float] = (1e-3, 8e-3)
    bows: Mapping[str, HalfSine] = field(default_factory=dict)
    options: Mapping[str, Any] = field(default_factory=dict)

    @property
    def length(self) -> float:
        return 0.2 if self.coupled else 1.0

    @property
    def diameter(self) -> float:
        # in torsion a thin shaft: its inertia is 1e-13 of the gears', its stiffness is negligible
        return 0.03 if self.coupled else 1e-4

    @property
    def position(self) -> float:
        return self.length / 2 if self.coupled else 0.0

    def package(self) -> gb.RotorSystem:
        given = dict(self.mesh)
        kinds = {
            "stiffness": gb.Stiffness,
            "tip_relief": gb.TipRelief,
            "error": gb.TransmissionError,
            "friction": gb.MeshFriction,
        }
        for key, kind in kinds.items():
            if isinstance(given.get(key), Mapping):
                given[key] = kind(**given[key])
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", gb.SceneWarning)
            return gb.RotorSystem(
                shafts=[
                    gb.Shaft(
                        name,
                        length=self.length,
                        outer_diameter=self.diameter,
                        elements=2 if self.coupled else 1,
                        bow=self.bows[name].package(self.length) if name in self.bows else None,
                    )
                    for name in "ab"
                ],
                gears=[
                    gb.Gear(
                        f"g{name}",
                        shaft=name,
                        position=self.position,
                        teeth=z,
                        module=self.module,
                        face_width=self.face_width,
                        **({} if self.coupled else {"polar_inertia": inertia}),
                        **{key: pair[i] for key, pair in self.gear.items() if pair[i] is not None},
                    )
                    for i, (name, z, inertia) in enumerate(
                        zip("ab", self.teeth, self.inertia, strict=True)
                    )
                ],
                meshes=[gb.Mesh("ga", "gb", **given)],
                bearings=[
                    gb.Bearing(name, position=x, stiffness=1e8, damping=self.bearing_damping)
                    for name in "ab"
                    for x in (0.0, self.length)
                    if self.coupled
                ],
                torques=[gb.Torque("ga", self.torque), gb.Torque.balance("gb")]
                if self.torque
                else [],
                motion="coupled" if self.coupled else "torsion",
                **self.options,
            )

    def radii(self) -> list[dict[str, float]]:
        found = [full_depth_gear(z, self.module) for z in self.teeth]
        for i, tip in enumerate(self.gear.get("tip_radius", (None, None))):
            if tip is not None:
                found[i]["tip"] = tip
        return found

    def polar(self) -> tuple[float, float]:
        if not self.coupled:
            return self.inertia
        a, b = (solid_disk(self.module * z / 2, self.face_width, DENSITY)[2] for z in self.teeth)
        return a, b

    @property
    def effective_mass(self) -> float:
        return 1 / sum(r["base"] ** 2 / i for r, i in zip(self.radii(), self.polar(), strict=True))

    def law(self, sigma: float = 1.0, mean: float = 2e8) -> MeshLaw:
        a, b = self.radii()
        damping = 2 * self.mesh.get("damping_ratio", 0.0) * np.sqrt(mean * self.effective_mass)
        return MeshLaw(
            base_radius_a=a["base"],
            base_radius_b=b["base"],
            centre_distance=self.mesh.get("centre_distance") or a["pitch"] + b["pitch"],
            centre_line_angle=self.mesh.get("centre_line_angle", 0.0),
            stiffness=mean,
            damping=self.mesh.get("damping", damping),
            sigma=sigma,
            tip_radius_a=a["tip"],
            tip_radius_b=b["tip"],
            teeth_a=self.teeth[0],
        )

    def train(self, law: MeshLaw) -> Train:
        part = ShaftPart(
            self.length, Section(self.diameter, E, G, DENSITY), 2 if self.coupled else 1
        )
        ratio = -self.teeth[0] / self.teeth[1]
        shafts = []
        for name, r in (("a", 1.0), ("b", ratio)):
            bow = self.bows.get(name)
            curves = (bow.curve(self.length), bow.slope(self.length)) if bow else (None, None)
            shafts.append(ShaftSpec(name, [part], r, *curves))
        rigid = []
        for name, z, polar in zip("ab", self.teeth, self.polar(), strict=True):
            mass, diametral, _ = solid_disk(self.module * z / 2, self.face_width, DENSITY)
            rigid.append(RigidSpec(f"g{name}", name, self.position, mass, diametral, polar))
        bearings = [
            BearingSpec(name, x, np.eye(2) * 1e8, np.eye(2) * self.bearing_damping)
            for name in "ab"
            for x in (0.0, self.length)
            if self.coupled
        ]
        torques = [("ga", self.torque), ("gb", -self.torque / ratio)] if self.torque else []
        return Train(shafts, rigid, bearings, [MeshSpec("ga", "gb", law)], torques)


@dataclass(frozen=True)
class Equations:
    """The equations of a `Toothed` train in all coordinates, or only in its twists."""

    scene: Toothed
    law: MeshLaw

    def __post_init__(self) -> None:
        train = self.scene.train(self.law)
        at = train.interface(train.meshes[0])
        keep = np.arange(train.size) if self.scene.coupled else np.arange(4, train.size, 5)
        sub = np.ix_(keep, keep)
        inverse = np.linalg.inv(train.mass[sub])
        # indices of the six coordinates among the retained ones; the others are zero
        places = [int(np.flatnonzero(keep == i)[0]) if i in keep else None for i in at]
        select = np.zeros((6, len(keep)))
        for row, place in enumerate(places):
            if place is not None:
                select[row, place] = 1.0
        for name, value in {
            "train": train,
            "keep": keep,
            "select": select,
            "inverse": inverse,
            "grounded": train.grounded[sub],
            "viscous": train.viscous[sub],
            "gyroscopic": train.gyroscopic[sub],
            "steady": train.steady_force()[keep],
        }.items():
            object.__setattr__(self, name, value)

    def turning(self, speed: float) -> list[tuple[float, Array, Array]]:
        return [
            (spin, a[self.keep], b[self.keep]) for spin, a, b in self.train.turning_force(speed)
        ]


def integrate(
    scene: Toothed,
    teeth: TeethLaw,
    speed: float,
    times: Array,
    *,
    rtol: float = 1e-10,
    keep_rotation: bool = False,
) -> tuple[Array, Array]:
    """Give coordinates and tooth force at `times`, from rest, by SciPy's DOP853.

    With `keep_rotation`, a torque on all inertias holds the rigid-body rotation against the teeth.
    """
    system = Equations(scene, teeth.law)
    n = len(system.keep)
    linear = np.hstack(
        [
            -system.inverse @ system.grounded,
            -system.inverse @ (system.viscous + speed * system.gyroscopic),
        ]
    )
    steady = system.inverse @ system.steady
    turning = [(w, system.inverse @ a, system.inverse @ b) for w, a, b in system.turning(speed)]
    spins = np.array([speed, -speed * scene.teeth[0] / scene.teeth[1]])
    push = system.inverse @ system.select.T
    if keep_rotation:
        ratios = np.repeat([1.0, spins[1] / spins[0]], system.train.size // 10)
        rotation = np.zeros(system.train.size)
        rotation[4::5] = ratios
        rotation = rotation[system.keep]
        inertia = rotation @ np.linalg.solve(system.inverse, rotation)
        push = push - np.outer(rotation, system.select @ rotation) / inertia

    def rate(t: float, y: Array) -> Array:
        a = linear @ y + steady
        for spin, at_0, at_90 in turning:
            a += np.cos(spin * t) * at_0 + np.sin(spin * t) * at_90
        if system.train.turning_bows:
            a += system.inverse @ system.train.twisted_bow(speed * t, y[:n])
        a += push @ teeth.force(system.select @ y[:n], system.select @ y[n:], spins * t, spins)[1]
        return np.concatenate([y[n:], a])

    scale = np.concatenate([np.full(n, 1e-14), np.full(n, 1e-10)])
    found = solve_ivp(
        rate, (0.0, times[-1]), np.zeros(2 * n), "DOP853", times, rtol=rtol, atol=scale
    )
    assert found.success, found.message
    forces = [
        teeth.force(system.select @ y[:n], system.select @ y[n:], spins * t, spins)[0]
        for t, y in zip(times, found.y.T, strict=True)
    ]
    return found.y.T, np.array(forces)


def switch_times(teeth: TeethLaw, speed: float, until: float) -> Array:
    """Give the times when a pair passes an end of the path: sharp engagement, nominal rotation."""
    s, low, high = teeth.place(np.zeros(6), np.zeros(2))
    pitch = teeth.law.base_pitch
    rate = teeth.law.base_radius_a * teeth.law.sigma * speed
    times = []
    for end in (low, high):
        # s + rate t + j pitch = end
        first = (end - s) / rate
        times += [first + i * pitch / abs(rate) for i in range(-5000, 5000)]
    found = np.array([t for t in times if 0 < t < until])
    return np.sort(found)


def propagate(
    scene: Toothed,
    teeth: TeethLaw,
    pair: float,
    speed: float,
    times: Array,
) -> tuple[Array, Array]:
    """Give the exact motion from rest and the tooth force for frozen geometry and square stiffness.

    The solution is a matrix exponential between contact changes.
    """
    system = Equations(scene, teeth.law)
    n = len(system.keep)
    g = system.select.T @ teeth.law.gradient_at_rest()
    turning = system.turning(speed) if scene.bows else []
    size = 2 * n + 1 + 2 * len(turning)
    pitch = teeth.law.base_pitch
    s, low, high = teeth.place(np.zeros(6), np.zeros(2))
    velocity = teeth.law.base_radius_a * teeth.law.sigma * speed

    def matrix(stiffness: float) -> Array:
        a = np.zeros((size, size))
        a[:n, n : 2 * n] = np.eye(n)
        k = system.grounded + stiffness * np.outer(g, g)
        c = system.viscous + speed * system.gyroscopic + teeth.law.damping * np.outer(g, g)
        a[n : 2 * n, :n], a[n : 2 * n, n : 2 * n] = -system.inverse @ k, -system.inverse @ c
        a[n : 2 * n, 2 * n] = system.inverse @ system.steady
        for i, (spin, at_0, at_90) in enumerate(turning):
            cos = 2 * n + 1 + 2 * i
            a[n : 2 * n, cos], a[n : 2 * n, cos + 1] = system.inverse @ at_0, system.inverse @ at_90
            a[cos, cos + 1], a[cos + 1, cos] = -spin, spin
        return a

    def stiffness(t: float) -> float:
        at = s + velocity * t
        return pair * (np.floor((high - at) / pitch) - np.ceil((low - at) / pitch) + 1)

    y = np.zeros(size)
    y[2 * n] = 1.0
    y[2 * n + 1 :: 2] = 1.0
    marks = np.unique(np.concatenate([[0.0], switch_times(teeth, speed, times[-1]), times]))
    known: dict[tuple[float, float], Array] = {}
    out = np.zeros((len(times), 2 * n))
    force = np.zeros(len(times))
    at = 0.0
    for mark in marks:
        if mark > at:
            k = stiffness((at + mark) / 2)
            key = (k, float(f"{mark - at:.13e}"))
            if key not in known:
                known[key] = expm(matrix(k) * (mark - at))
            y = known[key] @ y
            at = mark
        for i in np.flatnonzero(times == mark):
            out[i] = y[: 2 * n]
            k = stiffness(mark)
            force[i] = k * g @ y[:n] + teeth.law.damping * g @ y[n : 2 * n]
    return out, force


def begin(
    system: gb.RotorSystem, speed: float, y: Array | None = None, **options: Any
) -> dict[str, Any]:
    """Give a restart state, from a run of zero length, with the given motion."""
    found = dict(system.simulate(0.0, speed, initial="rest", record=["meshes"], **options).final)
    if y is not None:
        found |= {"state": np.array(y, dtype=float), "contact_modes": np.zeros(0, dtype=np.int64)}
    return found


def tips(scene: Toothed, contact_ratio: float) -> tuple[float, float]:
    """Give tip radii for a contact ratio.

    One factor scales both reaches from full depth. The reach of b stays within the segment between
    the base circles.
    """
    law = scene.law()
    bases = (law.base_radius_a, law.base_radius_b)
    full = [np.sqrt(r["tip"] ** 2 - b**2) for r, b in zip(scene.radii(), bases, strict=True)]
    tangent = np.sqrt(law.centre_distance**2 - law.sum_of_radii**2)
    whole = contact_ratio * law.base_pitch + tangent
    of_b = min(whole * full[1] / sum(full), 0.98 * tangent)
    reaches = (whole - of_b, of_b)
    a, b = (float(np.hypot(reach, base)) for reach, base in zip(reaches, bases, strict=True))
    return a, b


def pair_stiffness(
    teeth: tuple[int, int], module: float, bores: tuple[float, float], tangent: float, s: float
) -> float:
    """Give the stiffness of one pair per face width.

    The compliances are bending, shear, compression, gear body and contact. The first three use the
    angle form of Yang, Lin and Tian: integrals over the tangent angle from -a1 at the contact to a2
    at the base circle.
    """
    contact = 4 * (1 - NU**2) / (np.pi * E)
    return 1 / (
        contact
        + tooth_compliance(teeth[0], module, bores[0], s)
        + tooth_compliance(teeth[1], module, bores[1], tangent - s)
    )


def tooth_compliance(z: int, module: float, bore: float, rolled: float) -> float:
    alpha = np.radians(20)
    base, root = module * z / 2 * np.cos(alpha), module * z / 2 - 1.25 * module
    a2 = np.pi / (2 * z) + np.tan(alpha) - alpha
    a1 = rolled / base - a2
    # the tooth begins at the base circle, or at the intersection of involute and root circle
    lowest = a2 - np.sqrt(max((root / base) ** 2 - 1, 0.0))

    def integrals(x: float) -> float:
        half = np.sin(x) + (a2 - x) * np.cos(x)  # thickness / base radius
        travel = (a2 - x) * np.cos(x)
        lever = 1 + np.cos(a1) * ((a2 - x) * np.sin(x) - np.cos(x))
        bending = 3 * lever**2 * travel / (2 * E * half**3)
        shear = 1.2 * (1 + NU) * travel * np.cos(a1) ** 2 / (E * half)
        axial = travel * np.sin(a1) ** 2 / (2 * E * half)
        return float(bending + shear + axial)

    total = quad(integrals, -a1, lowest, epsabs=0, epsrel=1e-12)[0]
    top = base * (np.cos(a1) + (a1 + a2) * np.sin(a1))
    side = base * ((a1 + a2) * np.cos(a1) - np.sin(a1))
    foot, thick = base * np.cos(a2), base * np.sin(a2)
    if root < foot:  # a straight stub from the base circle to the root circle
        area, inertia = 2 * thick, 2 / 3 * thick**3

        def stub(x: float) -> float:
            moment = np.cos(a1) * (top - x) - np.sin(a1) * side
            forces = 1.2 * np.cos(a1) ** 2 / G + np.sin(a1) ** 2 / E
            return float(moment**2 / (E * inertia) + forces / area)

        total += quad(stub, root, foot, epsabs=0, epsrel=1e-12)[0]

    return float(total) + body_compliance(z, module, bore, rolled)


def body_compliance(z: int, module: float, bore: float, rolled: float) -> float:
    """Give the contribution of fillet and gear body to `tooth_compliance`."""
    alpha = np.radians(20)
    base, root = module * z / 2 * np.cos(alpha), module * z / 2 - 1.25 * module
    a2 = np.pi / (2 * z) + np.tan(alpha) - alpha
    a1 = rolled / base - a2
    top = base * (np.cos(a1) + (a1 + a2) * np.sin(a1))
    side = base * ((a1 + a2) * np.cos(a1) - np.sin(a1))
    theta = a2
    if root > base:
        roll = np.sqrt((root / base) ** 2 - 1)
        theta = a2 - (roll - np.arctan(roll))
    h = root / bore
    table = {  # Sainsot, Velex and Duverger 2004
        "L": (-5.574e-5, -1.9986e-3, -2.3015e-4, 4.7702e-3, 0.0271, 6.8045),
        "M": (60.111e-5, 28.100e-3, -83.431e-4, -9.9256e-3, 0.1624, 0.9086),
        "P": (-50.952e-5, 185.50e-3, 0.0538e-4, 53.3e-3, 0.2895, 0.9236),
        "Q": (-6.2042e-5, 9.0889e-3, -4.0964e-4, 7.8297e-3, -0.1472, 0.6904),
    }
    L, M, P, Q = (
        A / theta**2 + B * h**2 + C * h / theta + D / theta + F * h + K
        for A, B, C, D, F, K in table.values()
    )
    reach = (top - side * np.tan(a1) - root) / (2 * theta * root)
    return float(np.cos(a1) ** 2 / E * (L * reach**2 + M * reach + P * (1 + Q * np.tan(a1) ** 2)))
