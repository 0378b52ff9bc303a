"""A pair of helical gears in NumPy: axial rods beside the train, and a deflection whose gradient is differentiated exactly.

The statement is that of vectors. The centres are c apart; the pitch point divides c in the ratio of the base radii. A gear
with the displacement x along its axis and the rotations B, G about y and z moves the pitch point along the axis by
x + B r_z - G r_y. An axial displacement X of a helicoid acts on its transverse section as the rotation -X tan(beta_b)/r.

    delta_n = cos(beta_b) {sigma [r_a t_a + r_b t_b - tan(beta_b) (X_a - X_b) - S (gamma - psi)] - S (inv alpha - inv alpha_0)}

Derivatives are those of complex steps, which have no round-off of differences.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.interpolate import PchipInterpolator

import gearbow as gb
from reference.bows import HalfSine
from reference.closed_forms import solid_disk
from reference.elements import Section
from reference.machines import distance_without_play
from reference.train import BearingSpec, Place, RigidSpec, ShaftPart, ShaftSpec, Train

Array = NDArray[np.float64]

STEP = 1e-30
E, DENSITY = 207e9, 7850.0  # the default steel of the interface
G = E / 2.6


@dataclass(frozen=True)
class HelicalMesh:
    """Two helical gears; `helix` is the helix angle of the driver, right-hand positive.

    The error [m], in the transverse section, is a function of the angles of both shafts. The run-out moves both base circles.
    """

    teeth: tuple[int, int]
    module: float
    helix: float
    stiffness: float
    damping: float = 0.0
    angle: float = 0.0
    sigma: float = 1.0
    pressure_angle: float = np.radians(20.0)
    film: bool = False  # the drive flank separates at zero deflection, and damping always acts
    centre_distance: float | None = None  # None is the sum of the reference radii
    error: Callable[..., NDArray] | None = None
    runout: tuple[complex, complex] = (0j, 0j)

    @property
    def radii(self) -> Array:
        """Give the reference radii."""
        return np.array(self.teeth) * self.module / np.cos(self.helix) / 2

    @property
    def transverse(self) -> float:
        return float(np.arctan(np.tan(self.pressure_angle) / np.cos(self.helix)))

    @property
    def base(self) -> float:
        """Give the helix angle on the base cylinder, from the lead."""
        return float(np.arctan(np.tan(self.helix) * np.cos(self.transverse)))

    def deflection(self, q: NDArray, live: bool) -> NDArray:
        """Give the deflection normal to the teeth at q: u, v, w, B, G, t of the driver, then of the driven gear, and the
        angles of both shafts."""
        a, b, angles = q[:6], q[6:12], q[12:]
        base = self.radii * np.cos(self.transverse)
        total, distance = base.sum(), self.centre_distance or self.radii.sum()
        rest = np.arccos(total / distance)
        along = np.array([np.cos(self.angle), np.sin(self.angle)])
        across = np.array([-along[1], along[0]])
        apart = b[1:3] - a[1:3]
        for out, sign, turned in zip(self.runout, (-1, 1), angles + q[[5, 11]], strict=True):
            c, s = np.cos(turned), np.sin(turned)
            apart = apart + sign * np.array(
                [out.real * c - out.imag * s, out.real * s + out.imag * c]
            )
        vector = (distance * along + (apart if live else 0.0 * apart).T).T
        if live:
            length = np.sqrt((vector * vector).sum(axis=0))
            turned = np.arctan((across @ vector) / (along @ vector))
            alpha = np.arctan(np.sqrt(length**2 - total**2) / total)
            opened = (np.tan(alpha) - alpha) - (np.tan(rest) - rest)
        else:
            turned = (across @ apart) / distance
            # the derivative of S inv(alpha) with respect to the centre distance is sin(alpha)
            opened = (along @ apart) * np.sin(rest) / total
        shift = 0.0
        for gear, share, sign in ((a, base[0] / total, 1.0), (b, -base[1] / total, -1.0)):
            y, z = share * vector
            shift = shift + sign * (gear[0] + gear[3] * z - gear[4] * y)
        rolled = base[0] * a[5] + base[1] * b[5] - np.tan(self.base) * shift
        error = self.error(*angles) if self.error else 0.0
        whole = self.sigma * (rolled - total * turned) - total * opened - error
        return np.cos(self.base) * whole

    def linear(self, q: Array, live: bool) -> tuple[float, Array]:
        """Give the deflection, and its gradient over the coordinates and the angles."""
        stepped = self.deflection(q[:, np.newaxis] + 1j * STEP * np.eye(14), live)
        return float(stepped[0].real), stepped.imag / STEP

    def force(self, q: Array, qd: Array, live: bool) -> tuple[float, Array]:
        """Give the force normal to the teeth and the generalised forces on the coordinates."""
        deflection, g = self.linear(q, live)
        value = self.stiffness * (max(deflection, 0.0) if self.film else deflection)
        value += self.damping * (g @ qd)
        return value, -value * g[:12]


class HelicalTrain:
    """A train without meshes, axial rods of its shafts, axial and tilting springs, and helical meshes.

    Coordinates: those of the train, then u of every node.
    """

    @classmethod
    def of(cls, system: gb.RotorSystem, speed: float) -> HelicalTrain:
        """State a system of steel shafts with half-sine bows and helical gears anew; tables of bearings are taken at `speed`."""
        gears = {gear.name: gear for gear in system.gears}
        ratios = {system.shafts[0].name: 1.0}
        for mesh in system.meshes:
            a, b = gears[mesh.driver], gears[mesh.driven]
            ratios[b.shaft] = -ratios[a.shaft] * a.teeth / b.teeth
        shafts = []
        for shaft in system.shafts:
            section = Section(shaft.outer_diameter, E, G, DENSITY, shaft.inner_diameter)
            curves: tuple = (None, None)
            if shaft.bow:
                bow = HalfSine(shaft.bow.amplitude, shaft.bow.phase or 0.0)
                curves = bow.curve(shaft.length), bow.slope(shaft.length)
            part = ShaftPart(shaft.length, section, shaft.elements)
            shafts.append(ShaftSpec(shaft.name, [part], ratios[shaft.name], *curves))
        inertias = {
            gear.name: solid_disk(
                0.5 * gear.module * gear.teeth / np.cos(gear.helix_angle), gear.face_width, DENSITY
            )
            for gear in system.gears
        }
        rigid = [
            RigidSpec(g.name, g.shaft, g.position, *inertias[g.name], complex(g.unbalance))
            for g in system.gears
        ]

        def matrix(given: object, spin: float) -> Array:
            if isinstance(given, gb.SpeedTable):
                values = [full(value) for value in given.values]
                top = given.speeds[-1]
                return PchipInterpolator(given.speeds, values)(min(abs(spin), top))
            return full(given)

        bearings = [
            BearingSpec(
                b.shaft,
                b.position,
                *(matrix(given, ratios[b.shaft] * speed) for given in (b.stiffness, b.damping)),
                b.support,
            )
            for b in system.bearings
        ]
        torques: list[tuple[str | Place, float]] = []
        power = 0.0
        for torque in system.torques:
            ratio = ratios[gears[torque.at].shaft if isinstance(torque.at, str) else torque.at[0]]
            value = -power / ratio if torque.value == "balance" else torque.value
            power += value * ratio
            torques.append((torque.at, value))
        whole = cls(Train(shafts, rigid, bearings, torques=torques))
        for bearing in system.bearings:
            whole.hold(bearing)
        for mesh in system.meshes:
            a, b = gears[mesh.driver], gears[mesh.driven]
            law = HelicalMesh(
                (a.teeth, b.teeth),
                a.module,
                a.helix_angle,
                mesh.stiffness,
                angle=mesh.centre_line_angle,
                sigma=float(np.sign(ratios[a.shaft] * speed)),
                film=mesh.damping_in_separation,
                centre_distance=distance_without_play(a, b),
                error=partial(harmonic_error, mesh.error, a.teeth) if mesh.error else None,
                runout=(a.runout, b.runout),
            )
            # c = 2ζ√(k m_e) of the transverse section, where k is cos² of the base helix angle smaller
            base = law.radii * np.cos(law.transverse)
            reduced = 1.0 / sum(
                r**2 / inertias[g.name][2] for r, g in zip(base, (a, b), strict=True)
            )
            damping = 2 * mesh.damping_ratio * np.sqrt(mesh.stiffness * reduced) / np.cos(law.base)
            whole.join(mesh.driver, mesh.driven, replace(law, damping=damping))
        return whole

    def __init__(self, train: Train) -> None:
        self.train = train
        nodes = sum(len(x) for x in train.nodes.values())
        n = self.size = train.size + nodes
        self.mass, self.stiffness, self.damping = (np.zeros((n, n)) for _ in range(3))
        self.gyroscopic = np.zeros((n, n))
        old = slice(0, train.size)
        self.mass[old, old], self.stiffness[old, old] = train.mass, train.grounded
        self.damping[old, old], self.gyroscopic[old, old] = train.viscous, train.gyroscopic
        self.meshes: list[
            tuple[HelicalMesh, Array, Array]
        ] = []  # with coordinates and speed ratios
        for shaft in train.shafts:
            x = train.nodes[shaft.name]
            ends = np.cumsum([part.length for part in shaft.parts])
            for left, right in pairwise(x):
                section = shaft.parts[int(np.searchsorted(ends, (left + right) / 2))].section
                at = [self.axial(shaft.name, place) for place in (left, right)]
                length, inertia = right - left, section.density * section.area * (right - left)
                stretch = section.youngs_modulus * section.area / length
                self.mass[np.ix_(at, at)] += inertia / 6 * np.array([[2.0, 1.0], [1.0, 2.0]])
                self.stiffness[np.ix_(at, at)] += stretch * np.array([[1.0, -1.0], [-1.0, 1.0]])
        for body in train.rigid:
            i = self.axial(body.shaft, body.position)
            self.mass[i, i] += body.mass

    def axial(self, shaft: str, position: float) -> int:
        """Give the index of u at a node."""
        return self.train.size + self.train.dof(shaft, position, 0) // 5

    def hold(self, bearing: gb.Bearing) -> None:
        """Add what a bearing has along the axis, and against tilting on the ground."""
        places = [
            (bearing.shaft, bearing.position),
            *([bearing.support] if bearing.support else []),
        ]
        at = [self.axial(*place) for place in places]
        apart = np.outer((1.0, -1.0), (1.0, -1.0))[: len(at), : len(at)]
        self.stiffness[np.ix_(at, at)] += bearing.axial_stiffness * apart
        self.damping[np.ix_(at, at)] += bearing.axial_damping * apart
        for coordinate in (2, 3):
            j = self.train.dof(*places[0], coordinate)
            self.stiffness[j, j] += bearing.tilting_stiffness

    def join(self, driver: str, driven: str, mesh: HelicalMesh) -> None:
        """Add a mesh between two gears."""
        at, ratios = [], {shaft.name: shaft.ratio for shaft in self.train.shafts}
        places = [self.train.place(driver), self.train.place(driven)]
        for place in places:
            at += [self.axial(*place), *(self.train.dof(*place, c) for c in range(5))]
        self.meshes.append((mesh, np.array(at), np.array([ratios[name] for name, _ in places])))

    def dofs(self) -> list[tuple[str, float, str]]:
        axial = [(name, x, "u") for name, x, kind in self.train.dofs() if kind == "v"]
        return [*self.train.dofs(), *axial]

    def linear(self) -> tuple[Array, Array]:
        """Give stiffness and damping with each mesh linearised at rest."""
        stiffness, damping = self.stiffness.copy(), self.damping.copy()
        for mesh, at, _ in self.meshes:
            g = replace(mesh, runout=(0j, 0j)).linear(np.zeros(14), live=True)[1][:12]
            stiffness[np.ix_(at, at)] += mesh.stiffness * np.outer(g, g)
            damping[np.ix_(at, at)] += mesh.damping * np.outer(g, g)
        return stiffness, damping

    def turning_force(self, speed: float) -> list[tuple[float, Array, Array]]:
        """Give per shaft the spin and the force at the angles 0 and pi/2."""
        more = (0, self.size - self.train.size)
        return [
            (spin, np.pad(a, more), np.pad(b, more))
            for spin, a, b in self.train.turning_force(speed)
        ]

    def response(self, frequency: float, speed: float, force: NDArray) -> NDArray:
        """Give the amplitude of a harmonic motion of the linear system; rotation is free."""
        stiffness, damping = self.linear()
        rate = damping + speed * self.gyroscopic
        dynamic = stiffness + 1j * frequency * rate - frequency**2 * self.mass
        return np.linalg.solve(dynamic, force)

    def from_rest(self, speed: float, times: Array, live: bool) -> tuple[Array, Array]:
        """Integrate from rest; give q (k, n), and the mesh forces (k, meshes)."""
        n, old = self.size, self.train.size
        inverse = np.linalg.inv(self.mass)
        damping = self.damping + speed * self.gyroscopic
        steady = np.zeros(n)
        steady[:old] = self.train.steady_force()
        turning = self.turning_force(speed)

        def meshed(t: float, q: Array, qd: Array) -> list[tuple[Array, float, Array]]:
            found = []
            for mesh, at, ratios in self.meshes:
                turned = np.concatenate([q[at], ratios * speed * t])
                moving = np.concatenate([qd[at], ratios * speed])
                found.append((at, *mesh.force(turned, moving, live)))
            return found

        def rate(t: float, state: Array) -> Array:
            q, qd = state[:n], state[n:]
            f = steady - self.stiffness @ q - damping @ qd
            for spin, a, b in turning:
                f += np.cos(spin * t) * a + np.sin(spin * t) * b
            for at, _, push in meshed(t, q, qd):
                f[at] += push
            return np.concatenate([qd, inverse @ f])

        scale = np.concatenate([np.full(n, 1e-14), np.full(n, 1e-10)])
        found = solve_ivp(
            rate, (0.0, times[-1]), np.zeros(2 * n), "DOP853", times, rtol=1e-10, atol=scale
        )
        assert found.success, found.message
        q, qd = found.y[:n].T, found.y[n:].T
        forces = [[force for _, force, _ in meshed(*one)] for one in zip(times, q, qd, strict=True)]
        return q, np.array(forces)


def full(given: object) -> Array:
    """Give the matrix of one, two or four coefficients along y and z."""
    values = np.asarray(given, dtype=float)
    return values if values.ndim == 2 else np.diag(np.broadcast_to(values, 2))


def harmonic_error(
    error: gb.TransmissionError, teeth: int, driver: complex, driven: complex
) -> complex:
    """Give the transmission error at the angles of both shafts."""
    sources = ((error.tooth, teeth * driver), (error.driver, driver), (error.driven, driven))
    return sum(
        amplitude * np.cos(n * angle + phase)
        for harmonics, angle in sources
        for n, (amplitude, phase) in enumerate(harmonics or (), start=1)
    )
