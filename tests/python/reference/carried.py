"""Planets that move laterally on a carrier that turns, in coordinates that do not turn.

The displacements are those seen from the ground: of sun, ring and carrier from their axis, of a planet from the place where its
circular path has it. There, inertia has no Coriolis terms, and the directions of pins and meshes follow the angle of the carrier.
The matrices are those of a system of the same shafts, gears and bearings without pins and meshes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

import gearbow as gb
from reference.equations import rotating_force
from reference.mesh_law import MeshLaw

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Pin:
    """A bearing of a planet, the same in all directions, at the place of the carrier."""

    place: tuple[str, float]
    carrier: tuple[str, float]
    arm: complex
    stiffness: float
    damping: float
    tilting_stiffness: float


@dataclass(frozen=True)
class CarriedMesh:
    """A mesh of two places; its law has the directions in the frame of the carrier."""

    driver: tuple[str, float]
    driven: tuple[str, float]
    law: MeshLaw


@dataclass
class CarriedTrain:
    """A train in coordinates that do not turn; `free` has all parts except pins and meshes."""

    free: gb.RotorSystem
    speed: float
    carrier_speed: float
    pins: Sequence[Pin]
    meshes: Sequence[CarriedMesh]
    live: bool = False
    gravity: tuple[float, float] = (0.0, 0.0)

    def __post_init__(self) -> None:
        matrices = self.free.matrices(self.speed)
        self.mass, self.stiffness = matrices.mass, matrices.stiffness
        self.damping = matrices.damping + self.speed * matrices.gyroscopic
        self.inverse = np.linalg.inv(self.mass)
        self.at = {dof: i for i, dof in enumerate(self.free.dofs)}
        self.load = np.zeros(len(self.mass))
        for torque in self.free.torques:
            self.load[self.free.coordinates.twist(torque.at)] += torque.value
        fall = {"v": self.gravity[0], "w": self.gravity[1]}
        self.load += self.mass @ [fall.get(kind, 0.0) for _, _, kind in self.free.dofs]
        spins = self.speed * np.asarray(self.free.speed_ratios)
        self.turning = [
            (spin, rotating_force(self.free, replace(shaft, speed_ratio=None), spin))
            for shaft, spin in zip(self.free.shafts, spins, strict=True)
        ]

        # the places of the planets at the carrier's angle 0: the real part turns as a force over (v, w) does
        self.paths = []
        for pin in {pin.place[0]: pin for pin in self.pins}.values():
            translation = np.zeros(len(self.mass), dtype=complex)
            for (name, _, kind), index in self.at.items():
                if name == pin.place[0] and kind in "vw":
                    translation[index] = pin.arm * (1.0 if kind == "v" else -1j)
            self.paths.append((self.at[(*pin.carrier, "twist")], translation))

    def pair(self, place: tuple[str, float], values: Array, kinds: str = "vw") -> complex:
        return complex(*(values[self.at[(*place, kind)]] for kind in kinds))

    def push(self, place: tuple[str, float], force: complex, out: Array, kinds: str = "vw") -> None:
        out[self.at[(*place, kinds[0])]] += force.real
        out[self.at[(*place, kinds[1])]] += force.imag

    def pin_force(self, pin: Pin, turn: complex, q: Array, v: Array) -> complex:
        """Give the force of a planet on its pin in the frame of the carrier."""
        twist = self.at[(*pin.carrier, "twist")]
        apart = self.pair(pin.place, q) - self.pair(pin.carrier, q)
        rate = self.pair(pin.place, v) - self.pair(pin.carrier, v)
        # in the frame, d = (u e^{-i angle}) has the rate (u' - i speed u) e^{-i angle}
        rate -= 1j * self.carrier_speed * apart
        apart, rate = apart / turn, rate / turn
        apart, rate = apart - 1j * pin.arm * q[twist], rate - 1j * pin.arm * v[twist]
        return pin.stiffness * apart + pin.damping * rate

    def mesh_force(
        self, mesh: CarriedMesh, turn: complex, q: Array, v: Array
    ) -> tuple[float, Array]:
        """Give force and generalised forces of a mesh in the frame of the carrier."""
        own, rates = [], []
        follower = self.at[(*self.pins[0].carrier, "twist")]
        for place in (mesh.driver, mesh.driven):
            u, rate, twist = self.pair(place, q), self.pair(place, v), self.at[(*place, "twist")]
            # relative to where the twist of the carrier takes the gear
            along = 1j * next((pin.arm for pin in self.pins if pin.place == place), 0.0)
            rate = (rate - 1j * self.carrier_speed * u) / turn - along * v[follower]
            u = u / turn - along * q[follower]
            own += [u.real, u.imag, q[twist] - q[follower]]
            rates += [rate.real, rate.imag, v[twist] - v[follower]]
        return mesh.law.force(np.array(own), np.array(rates), self.live)

    def acceleration(self, t: float, q: Array, v: Array) -> Array:
        turn = np.exp(1j * self.carrier_speed * t)
        f = self.load - self.stiffness @ q - self.damping @ v
        for spin, amplitude in self.turning:
            f += (amplitude * np.exp(1j * spin * t)).real
        square = self.carrier_speed**2
        for pin in self.pins:
            force = self.pin_force(pin, turn, q, v)
            twist = self.at[(*pin.carrier, "twist")]
            self.push(pin.place, -force * turn, f)
            self.push(pin.carrier, force * turn, f)
            f[twist] += (np.conj(1j * pin.arm) * force).real
            slope = self.pair(pin.place, q, "BG") - self.pair(pin.carrier, q, "BG")
            self.push(pin.place, -pin.tilting_stiffness * slope, f, "BG")
            self.push(pin.carrier, pin.tilting_stiffness * slope, f, "BG")
        # the circular path of the planets, and their forces on pins, which turn with the twist of the carrier
        for twist, translation in self.paths:
            f += square * self.mass @ (translation * turn).real
            along = (1j * translation * turn).real
            momentum = self.mass @ along
            f -= square * momentum * q[twist]
            f[twist] -= square * (momentum @ q - along @ momentum * q[twist])
        for mesh in self.meshes:
            _, forces = self.mesh_force(mesh, turn, q, v)
            follower = self.at[(*self.pins[0].carrier, "twist")]
            for place, (y, z, moment) in zip(
                (mesh.driver, mesh.driven), forces.reshape(2, 3), strict=True
            ):
                self.push(place, complex(y, z) * turn, f)
                f[self.at[(*place, "twist")]] += moment
                along = 1j * next((pin.arm for pin in self.pins if pin.place == place), 0.0)
                f[follower] -= moment + (along.conjugate() * complex(y, z)).real
        return self.inverse @ f

    def from_rest(self, times: Array) -> tuple[Array, Array]:
        """Integrate from rest; give displacements and velocities (k, n)."""
        n = len(self.mass)

        def rate(t: float, state: Array) -> Array:
            q, v = state[:n], state[n:]
            return np.concatenate([v, self.acceleration(t, q, v)])

        scale = np.concatenate([np.full(n, 1e-12), np.full(n, 1e-8)])
        found = solve_ivp(
            rate,
            (0.0, times[-1]),
            np.zeros(2 * n),
            "DOP853",
            times,
            rtol=1e-8,
            atol=scale,
            max_step=5e-6,
        )
        assert found.success, found.message
        return found.y[:n].T, found.y[n:].T
