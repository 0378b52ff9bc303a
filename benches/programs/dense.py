"""Equations of motion of a scene as a careful user would write them for SciPy.

Dense matrices give the linear part in one matrix-vector product; plain floats give the mesh force.
The matrices come from gearbow. The equations of mesh, bow and torque are written independently.
"""

import math
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

import gearbow as gb
from gearbow._types import Dof
from programs.scenes import Array


class Pair:
    """A mesh as a crossed belt between the base circles; at rest the centres lie along y."""

    def __init__(self, system: gb.RotorSystem, mesh: gb.Mesh, speed: float) -> None:
        gears = {gear.name: gear for gear in system.gears}
        a, b = gears[mesh.driver], gears[mesh.driven]
        names = [shaft.name for shaft in system.shafts]
        self.spin = float(system.speed_ratios[names.index(a.shaft)]) * speed
        self.sigma = math.copysign(1.0, self.spin)
        pitch = [(gear.module or math.nan) * gear.teeth / 2.0 for gear in (a, b)]
        self.alpha = a.pressure_angle
        self.distance = sum(pitch)
        self.r_a, self.r_b = (r * math.cos(self.alpha) for r in pitch)
        self.sum = self.r_a + self.r_b
        tip_a, tip_b = (r + (a.module or math.nan) for r in pitch)
        self.base_pitch = math.tau * self.r_a / a.teeth
        self.high = math.sqrt(tip_a**2 - self.r_a**2)
        self.low = self.distance * math.sin(self.alpha) - math.sqrt(tip_b**2 - self.r_b**2)
        if not isinstance(mesh.stiffness, gb.Stiffness):
            raise TypeError
        self.pair = mesh.stiffness.pair
        contact_ratio = (self.high - self.low) / self.base_pitch
        self.mean = mesh.stiffness.mean or (self.pair or math.nan) * contact_ratio
        inertia_a, inertia_b = (
            gb.STEEL.density * math.pi * r**4 * (gear.face_width or math.nan) / 2.0
            for r, gear in zip(pitch, (a, b), strict=True)
        )
        mass = 1.0 / (self.r_a**2 / inertia_a + self.r_b**2 / inertia_b)
        self.damping = 2.0 * mesh.damping_ratio * math.sqrt(self.mean * mass)
        self.rest = self.line(self.alpha, 0.0)
        index = {dof: i for i, dof in enumerate(system.dofs)}
        places = [(gear.shaft, gear.position, d) for gear in (a, b) for d in ("v", "w", "twist")]
        self.at = np.array([index[place] for place in places])

    def line(self, alpha: float, gamma: float) -> list[float]:
        """Return the gradient of the deflection with respect to (v, w, twist) of both gears."""
        across, along = self.sigma * math.cos(alpha), math.sin(alpha)
        y = along * math.cos(gamma) - across * math.sin(gamma)
        z = along * math.sin(gamma) + across * math.cos(gamma)
        return [y, z, self.sigma * self.r_a, -y, -z, self.sigma * self.r_b]

    def live(self, q: list[float], v: list[float]) -> list[float]:
        """Return the generalised mesh forces with the line of action of the moving centres."""
        y, z = self.distance + q[3] - q[0], q[4] - q[1]
        gamma, alpha = math.atan2(z, y), math.acos(self.sum / math.hypot(y, z))
        rolled = self.r_a * q[2] + self.r_b * q[5] - self.sum * gamma
        involute = math.tan(alpha) - alpha - (math.tan(self.alpha) - self.alpha)
        line = self.line(alpha, gamma)
        rate = sum(slope * velocity for slope, velocity in zip(line, v, strict=True))
        deflection = self.sigma * rolled - self.sum * involute
        force = self.mean * deflection + self.damping * rate
        return [force * slope for slope in line]

    def beyond_mean(self, t: float) -> float:
        """Return the stiffness of the tooth pairs in contact at time `t` minus its mean."""
        place = self.r_a * (abs(self.spin) * t + self.alpha)
        first = math.ceil((self.low - place) / self.base_pitch)
        last = math.floor((self.high - place) / self.base_pitch)
        return (last - first + 1) * (self.pair or 0.0) - self.mean


class Dense:
    """The first-order form dy/dt = f(t, y); y contains displacements, then velocities."""

    def __init__(self, system: gb.RotorSystem, geometry: str, speed: float) -> None:
        matrices = system.matrices()
        self.index = {dof: i for i, dof in enumerate(system.dofs)}
        self.n = n = len(self.index)
        stiffness, damping = matrices.stiffness.copy(), matrices.damping.copy()
        damping += speed * matrices.gyroscopic
        turning = [i for i, shaft in enumerate(system.shafts) if shaft.bow is not None]
        self.spins = [float(system.speed_ratios[i]) * speed for i in turning]
        self.pairs = [Pair(system, mesh, speed) for mesh in system.meshes]
        self.geometry = geometry
        # The matrices contain each mesh linearised at rest. Frozen geometry adds the varying part
        # of its stiffness as an input; live geometry replaces the linearised mesh by an input.
        columns = []
        for pair in self.pairs:
            rest = np.array(pair.rest)
            if geometry == "live":
                stiffness[np.ix_(pair.at, pair.at)] -= pair.mean * np.outer(rest, rest)
                damping[np.ix_(pair.at, pair.at)] -= pair.damping * np.outer(rest, rest)
                columns.append(-np.eye(n)[:, pair.at])
            elif pair.pair is not None:
                columns.append(-np.eye(n)[:, pair.at] @ rest[:, None])
        inputs = [-stiffness, -damping, torques(system, self.index)[:, None]]
        bows = [bow_force(system.shafts[i], self.index) for i in turning]
        # Weights of cosine and sine of the shaft angle.
        inputs += [np.column_stack([bow.real, -bow.imag]) for bow in bows] + columns
        self.linear = np.linalg.solve(matrices.mass, np.hstack(inputs))
        self.input = np.ones(self.linear.shape[1])
        rates = np.linalg.solve(
            matrices.mass,
            -np.hstack([matrices.stiffness, matrices.damping + speed * matrices.gyroscopic]),
        )
        #: Jacobian with mean mesh stiffness at rest, for implicit methods.
        self.jacobian = np.vstack([np.hstack([np.zeros((n, n)), np.eye(n)]), rates])

    def __call__(self, t: float, y: Array) -> Array:
        """Evaluate dy/dt."""
        n, put = self.n, self.input
        put[: 2 * n] = y
        at = 2 * n + 1  # the torques are constant
        for spin in self.spins:
            put[at], put[at + 1] = math.cos(spin * t), math.sin(spin * t)
            at += 2
        for pair in self.pairs:
            if self.geometry == "live":
                put[at : at + 6] = pair.live(y[pair.at].tolist(), y[pair.at + n].tolist())
                at += 6
            elif pair.pair is not None:
                q = y[pair.at].tolist()
                deflection = sum(slope * x for slope, x in zip(pair.rest, q, strict=True))
                put[at] = pair.beyond_mean(t) * deflection
                at += 1
        return np.concatenate([y[n:], self.linear @ put])


def bow_force(shaft: gb.Shaft, index: Mapping[Dof, int]) -> NDArray[np.complex128]:
    """Return the bow force K_s q_b (n,) as a complex amplitude of the shaft rotation."""
    force = np.zeros(len(index), dtype=complex)
    if shaft.bow is None:
        return force
    alone = gb.RotorSystem(shafts=[shaft])
    rows = [index[dof] for dof in alone.dofs]
    force[rows] = alone.matrices().stiffness @ bow_shape(shaft, nodal(alone.dofs))
    return force


def torques(system: gb.RotorSystem, index: Mapping[Dof, int]) -> Array:
    """Return the torques on the gears (n,); the balancing torque makes the total power zero."""
    gears = {gear.name: gear for gear in system.gears}
    names = [shaft.name for shaft in system.shafts]
    force, power = np.zeros(len(index)), 0.0
    for torque in system.torques:
        gear = gears[str(torque.at)]
        ratio = float(system.speed_ratios[names.index(gear.shaft)])
        given = torque.value
        value = given.real if isinstance(given, (float, complex)) else -power / ratio
        force[index[gear.shaft, gear.position, "twist"]] += value
        power += value * ratio
    return force


def nodal(
    dofs: Sequence[tuple[str, float | tuple[float, float], str]],
) -> list[tuple[str, float, str]]:
    """Return the coordinates of the nodes: elements of degree 1 have no others."""
    return [(shaft, x, d) for shaft, x, d in dofs if not isinstance(x, tuple)]


def bow_shape(shaft: gb.Shaft, dofs: Sequence[tuple[str, float, str]]) -> NDArray[np.complex128]:
    """Return the coordinates of a half-sine bow as complex amplitudes of the shaft rotation."""
    if shaft.bow is None or shaft.bow.amplitude is None or shaft.segments is None:
        raise TypeError
    amplitude, k = shaft.bow.amplitude, math.pi / math.fsum(s.length for s in shaft.segments)
    turn = {"v": 1.0, "w": -1j, "G": k, "B": 1j * k}
    wave = {"v": math.sin, "w": math.sin, "G": math.cos, "B": math.cos}
    return np.array([amplitude * turn[d] * wave[d](k * x) for _, x, d in dofs])
