"""Residuals of the equations of motion of any system, from its matrices and its parts.

(λ² M + λ (C + Ω G) + K) φ = 0 of modes, (K + iω (C + Ω G) − ω² M) a = f of the response to bow and unbalance, and the sum of
forces on each shaft at rest. Loads and mesh forces follow from the parts; only the matrices are those of the package.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray
from scipy.linalg import lu_factor, lu_solve
from scipy.sparse.linalg import LinearOperator, eigs

import gearbow as gb

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]


class Equations:
    """M q'' + (C + Ω G) q' + K q = f of a system at one speed of the reference shaft."""

    def __init__(self, system: gb.RotorSystem, speed: float) -> None:
        matrices = system.matrices(speed)
        self.speed = speed
        self.mass, self.stiffness = matrices.mass, matrices.stiffness
        self.damping = matrices.damping + speed * matrices.gyroscopic

    def scale(self, rate: float) -> Array:
        """Square root of the energy of a unit of each coordinate: it makes metres and radians comparable."""
        return np.sqrt(np.diag(self.stiffness) + rate**2 * np.diag(self.mass))

    def dynamic_stiffness(self, value: complex) -> ComplexArray:
        return value**2 * self.mass + value * self.damping + self.stiffness

    def mode_residual(self, value: complex, shape: ComplexArray) -> float:
        """Residual of an eigenpair in the energy norm, relative to the shape."""
        scale = self.scale(abs(value))
        residual = (self.dynamic_stiffness(value) @ shape) / scale
        return float(np.linalg.norm(residual) / np.linalg.norm(scale * shape))

    def eigenvalue_residual(self, value: complex) -> float:
        """Smallest singular value of the scaled dynamic stiffness, by inverse iteration."""
        scale = self.scale(abs(value))
        factors = lu_factor(self.dynamic_stiffness(value) / np.outer(scale, scale))
        vector = np.random.default_rng(0).normal(size=len(scale)) + 0j
        for _ in range(3):
            vector /= np.linalg.norm(vector)
            vector = lu_solve(factors, lu_solve(factors, vector), trans=2)
        return float(1.0 / np.sqrt(np.linalg.norm(vector)))

    def eigenvalues_below(self, highest: float) -> ComplexArray:
        """Every eigenvalue in the circle over the imaginary axis from 0 to `highest`, by ARPACK."""
        n, shift = len(self.mass), 0.5j * highest
        factors = lu_factor(self.dynamic_stiffness(shift))
        forward = self.damping + shift * self.mass

        def inverse(state: ComplexArray) -> ComplexArray:
            a, b = state[:n], state[n:]
            q = lu_solve(factors, -(self.mass @ b + forward @ a))
            return np.concatenate([q, a + shift * q])

        count = 30
        operator = LinearOperator((2 * n, 2 * n), matvec=inverse, dtype=complex)
        start = np.random.default_rng(0).normal(size=2 * n) + 0j
        found = shift + 1.0 / eigs(operator, count, v0=start, return_eigenvectors=False)
        radius = np.abs(found - shift)
        assert radius.max() > 0.5 * highest, "the circle may contain more eigenvalues"
        return found[radius < 0.5 * highest]

    def response(self, spin: float, force: ComplexArray) -> ComplexArray:
        return np.linalg.solve(self.dynamic_stiffness(1j * spin), force)


class ShaftAlone:
    """One shaft of a system without anything that it touches, with the nodes that it has there."""

    def __init__(self, system: gb.RotorSystem, shaft: gb.Shaft) -> None:
        self.shaft = shaft
        self.sleeves = [sleeve for sleeve in system.sleeves if sleeve.shaft == shaft.name]
        self.at = [i for i, dof in enumerate(system.dofs) if dof[0] == shaft.name]
        self.dofs = [system.dofs[i] for i in self.at]
        self.nodes = sorted({x for _, x, _ in self.dofs if not isinstance(x, tuple)})
        degrees = [int(kind[-1]) for _, _, kind in self.dofs if kind[-1].isdigit()]
        self.degree = max([degree for degree in degrees if degree], default=2) - 1

    @cached_property
    def length(self) -> float:
        return self.nodes[-1]

    def rigidity(self, x: Array) -> Array:
        """Bending stiffness EI at positions within one element."""

        def of(outer: Array, inner: Array, material: gb.Material) -> Array:
            return material.youngs_modulus * np.pi / 64.0 * (outer**4 - inner**4)

        found, begin = np.zeros_like(x), 0.0
        for part in self.shaft.segments or (self.shaft,):
            along = (x - begin) / part.length
            begin += part.length
            sizes = []
            for kind in ("outer_diameter", "inner_diameter"):
                first = getattr(part, kind)
                last = getattr(part, f"end_{kind}", None)
                sizes.append(first + along * ((first if last is None else last) - first))
            here = of(*sizes, getattr(part, "material", None) or self.shaft.material)
            found = np.where((along >= 0.0) & (along < 1.0), here, found)
        for sleeve in self.sleeves:
            share = {"none": 0.0, "full": 1.0}.get(sleeve.stiffness, sleeve.stiffness)
            layer = of(sleeve.outer_diameter, sleeve.inner_diameter, sleeve.material)
            found += np.where((x > sleeve.begin) & (x < sleeve.end), share * layer, 0.0)
        return found

    @cached_property
    def stiffness(self) -> Array:
        """Elastic matrix of the free shaft without axial force, in the order of `dofs`."""
        shaft = replace(self.shaft, bow=None, axial_force=0.0, elements=None, degree=self.degree)
        if shaft.segments:
            parts = [replace(part, elements=1) for part in shaft.segments]
            shaft = replace(shaft, segments=parts)
        else:
            shaft = replace(shaft, elements=1)
        # a force makes its place a node
        nodes = [gb.Force((shaft.name, x), 1.0) for x in self.nodes]
        free = gb.RotorSystem([shaft], sleeves=self.sleeves, forces=nodes, motion="coupled")

        def key(dof):
            _, x, kind = dof
            return tuple(np.round(np.atleast_1d(x), 9)), kind

        place = {key(dof): i for i, dof in enumerate(free.dofs)}
        matrix = np.zeros((len(self.dofs), len(self.dofs)))
        # a free shaft alone has no axial motion, which a bow does not excite
        both = [(i, place[key(dof)]) for i, dof in enumerate(self.dofs) if key(dof) in place]
        here, there = np.array(both).T
        matrix[np.ix_(here, here)] = free.matrices().stiffness[np.ix_(there, there)]
        return matrix

    def bow_force(self) -> ComplexArray:
        """Amplitude of the force of a half-sine bow."""
        bow = self.shaft.bow
        if bow is None:
            return np.zeros(len(self.dofs), dtype=complex)
        assert bow.shape == "half_sine"
        amplitude, wave = bow.amplitude * np.exp(1j * (bow.phase or 0.0)), np.pi / self.length
        curve = np.zeros(len(self.dofs), dtype=complex)
        within = np.zeros_like(curve)
        for i, (_, x, kind) in enumerate(self.dofs):
            # b e^{iϑ} = v + iw and b' e^{iϑ} = G − iB
            turn = {"v": 1.0, "w": -1j, "G": 1.0, "B": 1j}.get(kind[0], 0.0)
            if not isinstance(x, tuple):
                value = np.sin(wave * x) if kind in "vw" else wave * np.cos(wave * x)
                curve[i] = amplitude * turn * value
            elif kind[0] in "BG":
                # ∫ E I ψ_n' b'' dx with ψ_n' = sqrt((2n − 1)/2) P_{n−1}(ξ) dξ/dx
                degree, (a, b) = int(kind[1:]), x
                points, weights = legendre.leggauss(20)
                there = 0.5 * (a + b) + 0.5 * (b - a) * points
                slope = np.sqrt(degree - 0.5) * legendre.legval(
                    points, [0.0] * (degree - 1) + [1.0]
                )
                curvature = -(wave**2) * np.sin(wave * there)
                within[i] = (
                    amplitude * turn * (weights @ (slope * self.rigidity(there) * curvature))
                )
        return self.stiffness @ curve + within


def rotating_force(system: gb.RotorSystem, shaft: gb.Shaft, spin: float) -> ComplexArray:
    """Amplitude of the force of bow and unbalance of one shaft that turns with `spin`."""
    alone = ShaftAlone(system, shaft)
    force = np.zeros(len(system.dofs), dtype=complex)
    force[alone.at] = alone.bow_force()
    for body in (*system.disks, *system.gears):
        if body.shaft == shaft.name and body.unbalance:
            v, w = system.coordinates.lateral(body.name)
            force[v] += spin**2 * body.unbalance
            force[w] -= 1j * spin**2 * body.unbalance
    return force


class Balance:
    """Mean forces on each shaft and housing at rest or in a run: y, z, x and the torque about x.

    `terms` has one row for each force. The sum of the rows of one body is zero at equilibrium; in a run it is the change of the
    momentum over the time. Without lateral motion, only the torques balance.
    """

    def __init__(
        self,
        system: gb.RotorSystem,
        motion: gb.results.Static | gb.Response,
        speed: float,
        rows: slice = slice(None),
    ) -> None:
        """`rows` are the times of a run to which the mean belongs."""
        self.system, self.motion, self.rows = system, motion, rows
        self.kinds = {kind for _, _, kind in system.dofs}
        self.ratio = dict(zip((s.name for s in system.shafts), system.speed_ratios, strict=True))
        self.bending = {name for name, _, kind in system.dofs if kind == "v"}
        self.terms: dict[str, list[Array]] = {}
        self._weights()
        self._torques()
        for mesh in system.meshes:
            self._mesh(mesh, speed)
        self._bearings()
        for coupling in system.couplings:
            self._coupling(coupling)

    def residual(self, body: str) -> float:
        """Largest sum of a component, relative to the sum of the magnitudes of all forces, or of all torques."""
        rows = np.array(self.terms[body])
        load = np.array([*3 * [np.abs(rows[:, :3]).sum()], np.abs(rows[:, 3]).sum()])
        shares = np.abs(rows.sum(axis=0)) / np.where(load > 0.0, load, 1.0)
        only_twists = body not in self.bending and body in self.ratio
        return float(shares[3 if only_twists else 0 :].max())

    def _add(self, body: str, y=0.0, z=0.0, x=0.0, torque=0.0) -> None:
        row = [float(np.mean(value)) for value in (y, z, x, torque)]
        self.terms.setdefault(body, []).append(np.array(row))

    def _taken(self, values):
        """Components first; of a run, the given times only."""
        return np.asarray(values).T if np.ndim(self._time) == 0 else values[self.rows].T

    @property
    def _time(self):
        return getattr(self.motion, "time", 0.0)

    def _carriers(self) -> list[gb.Housing | gb.Support]:
        """What bearings stand on."""
        own = [b.support for b in self.system.bearings if isinstance(b.support, gb.Support)]
        return [*self.system.housings, *self.system.supports, *own]

    def _weights(self) -> None:
        gravity = float(self.system.description.get("gravity", 0.0))
        for shaft in self.system.shafts:
            for part in shaft.segments or (shaft,):
                material = getattr(part, "material", None) or shaft.material
                outer, inner = (
                    [getattr(part, kind), getattr(part, f"end_{kind}", None)]
                    for kind in ("outer_diameter", "inner_diameter")
                )
                volume = frustum(part.length, *outer) - frustum(part.length, *inner)
                self._add(shaft.name, z=-gravity * material.density * volume)
        for sleeve in self.system.sleeves:
            length = sleeve.end - sleeve.begin
            volume = frustum(length, sleeve.outer_diameter) - frustum(length, sleeve.inner_diameter)
            self._add(sleeve.shaft, z=-gravity * sleeve.material.density * volume)
        for disk in self.system.disks:
            self._add(disk.shaft, z=-gravity * disk.mass)
        for gear in self.system.gears:
            mass = gear.mass
            if mass is None:
                # a solid steel disk with the diameter of the reference circle, or a ring outside it: the
                # dedendum of 1.25 modules and a rim of 3.5
                diameter = gear.module * gear.teeth / np.cos(gear.helix_angle)
                square = diameter**2
                if gear.internal:
                    square = (diameter + 2.0 * (1.25 + 3.5) * gear.module) ** 2 - square
                mass = 7850.0 * np.pi / 4.0 * square * gear.face_width
            self._add(gear.shaft, z=-gravity * mass)
        for body in self._carriers():
            self._add(body.name, z=-gravity * body.mass)

    def _torques(self) -> None:
        def shaft(torque: gb.Torque) -> str:
            return self.system.coordinates.shaft(torque.at)

        power = 0.0
        for torque in self.system.torques:
            if torque.value != "balance":
                self._add(shaft(torque), torque=torque.value)
                power += torque.value * self.ratio[shaft(torque)]
        for torque in self.system.torques:
            if torque.value == "balance":
                self._add(shaft(torque), torque=-power / self.ratio[shaft(torque)])
        for drive in self.system.drives:
            # the damping torque has the mean zero over a period
            twist = self._taken(self.motion.twist(drive.at))
            self._add(shaft(drive), torque=-drive.stiffness * twist)

    def _tilt(self, gear: gb.Gear) -> Array:
        """Slopes of a gear along y and z; they are neglected in a run, which does not record them."""
        if not isinstance(self.motion, gb.results.Static) or gear.shaft not in self.bending:
            return np.zeros(2)
        at = {dof: i for i, dof in enumerate(self.system.dofs)}
        b, g = (self.motion.state[at[gear.shaft, gear.position, kind]] for kind in "BG")
        return np.array([g, -b])

    def _mesh(self, mesh: gb.Mesh, speed: float) -> None:
        state = self.motion.mesh((mesh.driver, mesh.driven))
        force, alpha, gamma = (
            self._taken(getattr(state, name))
            for name in ("force", "pressure_angle", "centre_line_angle")
        )
        a, b = (
            next(g for g in self.system.gears if g.name == name)
            for name in (mesh.driver, mesh.driven)
        )
        carrier = mesh.carrier and self.system.coordinates.shaft(mesh.carrier)
        side = np.sign(speed * (self.ratio[a.shaft] - self.ratio.get(carrier, 0.0)))
        if mesh.backlash is not None:
            side = np.where(force < 0.0, -side, side)  # the back flanks push
            force = np.abs(force)
        radii = [base_radius(gear) for gear in (a, b)]
        base_helix = np.arcsin(np.sin(a.helix_angle) * np.cos(a.pressure_angle))
        lead = np.tan(base_helix)
        force = force * np.cos(
            base_helix
        )  # of the normal force, the part in the transverse section
        # the tilt of the gears turns the plane of action of helical teeth
        tilt = sum(r * self._tilt(g) for r, g in zip(radii, (a, b), strict=True)) / sum(radii)
        y = (
            -side * np.cos(alpha) * np.sin(gamma)
            + np.sin(alpha) * np.cos(gamma)
            - side * lead * tilt[0]
        )
        z = (
            side * np.cos(alpha) * np.cos(gamma)
            + np.sin(alpha) * np.sin(gamma)
            - side * lead * tilt[1]
        )
        thrust = side * force * lead
        turning = -side
        if a.internal or b.internal:
            assert lead == 0.0
            # The contact lies beyond the centre of the pinion, and the gears are pulled together; both turn the same way.
            along = side if a.internal else -side
            y = -along * np.cos(alpha) * np.sin(gamma) - np.sin(alpha) * np.cos(gamma)
            z = along * np.cos(alpha) * np.cos(gamma) - np.sin(alpha) * np.sin(gamma)
            turning = side
        if carrier is not None:
            # the stage acts in torsion only; the carrier takes the torque that both gears leave
            torques = -side * force * radii[0], turning * force * radii[1]
            for shaft, torque in zip(
                (a.shaft, b.shaft, carrier), (*torques, -sum(torques)), strict=True
            ):
                self._add(shaft, torque=torque)
            return
        self._add(a.shaft, -force * y, -force * z, thrust, -side * force * radii[0])
        self._add(b.shaft, force * y, force * z, -thrust, turning * force * radii[1])
        if mesh.friction is not None and isinstance(self.motion, gb.Response):
            self._friction(state, [a.shaft, b.shaft], speed, side)

    def _friction(self, state, shafts: list[str], speed: float, side) -> None:
        """Friction of a mesh on both shafts, and the torque by which the drive of the train supplies its loss.

        The moments about both centres follow from their sum, the friction times the length between the tangent points, and from
        the power. Vibrations contribute little to its mean.
        """
        names = ("friction_force", "pressure_angle", "centre_line_angle", "centre_distance")
        force, alpha, gamma, distance = (self._taken(getattr(state, name)) for name in names)
        y = np.cos(alpha) * np.cos(gamma) + side * np.sin(alpha) * np.sin(gamma)
        z = np.cos(alpha) * np.sin(gamma) - side * np.sin(alpha) * np.cos(gamma)
        spins = [self.ratio[shaft] * speed for shaft in shafts]
        both = np.mean(side * force * distance * np.sin(alpha))
        power = np.mean(self._taken(state.friction_power))
        first = -(power + spins[1] * both) / (spins[0] - spins[1])
        self._add(shafts[0], -force * y, -force * z, torque=first)
        self._add(shafts[1], force * y, force * z, torque=both - first)
        if self.system.drives:
            return
        # nothing holds the rotation: the loss comes to all inertias in proportion
        found = self.system.mass_properties()
        inertia = dict(zip(found.names, found.polar_inertia, strict=True))
        whole = sum(value * self.ratio[name] ** 2 for name, value in inertia.items())
        for name, value in inertia.items():
            self._add(name, torque=power / speed * value * self.ratio[name] / whole)

    def _bearings(self) -> None:
        for bearing in self.system.bearings:
            place = (bearing.shaft, bearing.position)
            force = self._taken(self.motion.bearing_force(place))
            axial = (
                self._taken(self.motion.axial_bearing_force(place))
                if bearing.axial_stiffness or is_ring(bearing)
                else 0.0
            )
            self._add(bearing.shaft, *-force, x=-axial)
            base = bearing.support
            if base is not None:
                other = base[0] if isinstance(base, tuple) else getattr(base, "name", base)
                self._add(other, *force, x=axial if isinstance(base, tuple) else 0.0)
        for body in self._carriers():
            for place, stiffness in _mounts(body):
                k_y, k_z = np.broadcast_to(np.asarray(stiffness, dtype=float), 2)
                v, w = self._taken(self.motion.displacement(place))
                self._add(body.name, -k_y * v, -k_z * w)

    def _coupling(self, coupling: gb.Coupling) -> None:
        def apart(measure):
            return self._taken(measure(coupling.b)) - self._taken(measure(coupling.a))

        v, w = apart(self.motion.displacement) if "v" in self.kinds else np.zeros(2)
        along = apart(self.motion.axial) if "u" in self.kinds else 0.0
        pull = (
            coupling.lateral_stiffness * (v + complex(coupling.offset).real),
            coupling.lateral_stiffness * (w + complex(coupling.offset).imag),
            coupling.axial_stiffness * along,
            coupling.torsional_stiffness * apart(self.motion.twist),
        )
        self._add(coupling.a[0], *pull)
        self._add(coupling.b[0], *(-value for value in pull))


def _mounts(body: gb.Housing | gb.Support) -> list[tuple[str, Any]]:
    """Places of a housing with springs to the ground, and their stiffness along y and z [N/m].

    The forces on a clamped elastic housing do not balance: what holds it is not in the model.
    """
    elastic = getattr(body, "elastic", None)
    if elastic is None:
        return [(body.name, body.stiffness)]
    assert elastic.translation is not None, "a clamped housing has no balance"
    own = {name: each.get("stiffness") for name, each in elastic.interfaces.items()}
    return [(name, given[1:]) for name, given in own.items() if given]


def is_ring(bearing: gb.Bearing | gb.JournalBearing | gb.RollingBearing) -> bool:
    """Tell whether the rings of a bearing have five degrees of freedom."""
    return isinstance(bearing, gb.RollingBearing) and bearing.degrees_of_freedom == 5


def frustum(length: float, begin: float, end: float | None = None) -> float:
    """Volume of a cone between two diameters, or of a cylinder."""
    end = begin if end is None else end
    return np.pi * length * (begin**2 + begin * end + end**2) / 12.0


def base_radius(gear: gb.Gear) -> float:
    """Radius of the base circle, that of the transverse section of a helical gear [m]."""
    pitch = 0.5 * gear.module * gear.teeth / np.cos(gear.helix_angle)
    return float(pitch * np.cos(np.arctan(np.tan(gear.pressure_angle) / np.cos(gear.helix_angle))))
