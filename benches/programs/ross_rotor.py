"""Scenes that ROSS supports: the same shaft elements, bearings and mesh.

ROSS has no shaft bow. The bow force K_s q_b rotates with the shaft and enters the time response of
ROSS as a table of forces over time. The shaft elements of ROSS give K_s.
"""

import contextlib
import io
import math
import warnings
from typing import Any

import numpy as np

import gearbow as gb
from programs.dense import bow_shape, nodal
from programs.scenes import Array, bodies

with warnings.catch_warnings(), contextlib.redirect_stdout(io.StringIO()):
    warnings.simplefilter("ignore")  # ROSS warns about an optional package for refrigerants
    import ross

#: Degrees of freedom of a node in ROSS: x, y, z (axial), and the rotations about these axes.
DOFS = 6
PLACE = {"v": 0, "w": 1, "B": 3, "G": 4, "twist": 5}


class Ross:
    """A scene with one or two shafts in ROSS."""

    def __init__(self, system: gb.RotorSystem, speed: float) -> None:
        self.speed = speed
        steel = ross.Material(
            "steel",
            rho=gb.STEEL.density,
            E=gb.STEEL.youngs_modulus,
            Poisson=gb.STEEL.poisson_ratio,
        )
        self.steel, self.system = steel, system
        rotors = [self.rotor(shaft) for shaft in system.shafts]
        self.rotor_ = rotors[0]
        if system.meshes:
            mesh, gears = system.meshes[0], {gear.name: gear for gear in system.gears}
            nodes = [self.node(gears[name].position) for name in (mesh.driver, mesh.driven)]
            stiffness = mesh.stiffness
            if not isinstance(stiffness, gb.Stiffness):
                raise TypeError
            self.rotor_ = ross.MultiRotor(
                *rotors, coupled_nodes=tuple(nodes), gear_mesh_stiffness=stiffness.mean
            )
        first = DOFS * len(rotors[0].nodes)
        self.offset = {shaft.name: i * first for i, shaft in enumerate(system.shafts)}

    def node(self, x: float) -> int:
        """Return the node at a position [m]."""
        lengths = self.lengths(self.system.shafts[0])
        return int(np.argmin(np.abs(np.concatenate([[0.0], np.cumsum(lengths)]) - x)))

    @staticmethod
    def lengths(shaft: gb.Shaft) -> list[float]:
        """Return the lengths of the elements [m]."""
        counts = [(s.length, s.elements or 1) for s in shaft.segments or ()]
        return [length / count for length, count in counts for _ in range(count)]

    def elements(self, shaft: gb.Shaft) -> list[Any]:
        """Return the shaft elements."""
        diameter = (shaft.segments or ())[0].outer_diameter
        return [
            ross.ShaftElement(L=length, idl=0.0, odl=diameter, material=self.steel)
            for length in self.lengths(shaft)
        ]

    def rotor(self, shaft: gb.Shaft) -> Any:
        """Return the rotor of a shaft with its gears and bearings."""
        bearings = [
            ross.BearingElement(n=self.node(b.position), kxx=b.stiffness, cxx=b.damping)
            for b in self.system.bearings
            if isinstance(b, gb.Bearing) and b.shaft == shaft.name
        ]
        disks = [self.gear(gear) for gear in self.system.gears if gear.shaft == shaft.name]
        disks += [self.disk(disk) for disk in self.system.disks if disk.shaft == shaft.name]
        return ross.Rotor(self.elements(shaft), disks, bearings)

    def disk(self, disk: gb.Disk) -> Any:
        """Return a disk."""
        return ross.DiskElement(
            n=self.node(disk.position),
            m=disk.mass,
            Id=disk.diametral_inertia,
            Ip=disk.polar_inertia,
        )

    def gear(self, gear: gb.Gear) -> Any:
        """Return a gear, a solid disk with the diameter of the pitch circle."""
        radius, width = (gear.module or math.nan) * gear.teeth / 2.0, gear.face_width or math.nan
        mass = gb.STEEL.density * math.pi * radius**2 * width
        return ross.GearElement(
            n=self.node(gear.position),
            m=mass,
            Id=mass * (radius**2 / 4.0 + width**2 / 12.0),
            Ip=mass * radius**2 / 2.0,
            n_teeth=gear.teeth,
            pitch_diameter=2.0 * radius,
            pr_angle=gear.pressure_angle,
        )

    def force(self, times: Array) -> Array:
        """Return the table (times, n) of the forces of bows and torques."""
        table = np.zeros((len(times), self.rotor_.ndof))
        for shaft, ratio in zip(self.system.shafts, self.system.speed_ratios, strict=True):
            alone = gb.RotorSystem([shaft])
            dofs = nodal(alone.dofs)
            shape = bow_shape(shaft, dofs)
            free = np.zeros(DOFS * (len(self.lengths(shaft)) + 1), dtype=complex)
            for (_, x, kind), value in zip(dofs, shape, strict=True):
                free[DOFS * self.node(x) + PLACE[kind]] = value
            force = ross.Rotor(self.elements(shaft), [], []).K(0.0) @ free
            turn = np.exp(1j * ratio * self.speed * times)
            at = self.offset[shaft.name]
            table[:, at : at + len(free)] += np.outer(turn, force).real
        gears = {gear.name: gear for gear in self.system.gears}
        for torque in self.system.torques:
            gear = gears[str(torque.at)]
            # In ROSS the twist of the driven shaft is positive in its direction of rotation. The
            # driving torque acts with the rotation, the balancing torque against it.
            teeth = gears[self.system.meshes[0].driver].teeth
            known = self.system.torques[0].value
            if not isinstance(known, float):
                raise TypeError
            value = known if torque.value == known else -known * gear.teeth / teeth
            at = self.offset[gear.shaft] + DOFS * self.node(gear.position) + PLACE["twist"]
            table[:, at] += value
        return table

    def forget(self) -> None:
        """Empty the caches of ROSS, so that a repeated call computes its result again."""
        self.rotor_.run_modal.cache_clear()
        self.rotor_._run_freq_response.cache_clear()

    def frequencies(self, speed: float, count: int) -> Array:
        """Return the lowest damped natural frequencies [Hz]."""
        found = self.rotor_.run_modal(speed, num_modes=2 * count)
        return np.asarray(found.wd) / (2.0 * np.pi)

    def campbell(self, speeds: Array, count: int) -> Array:
        """Return the damped natural frequencies (speeds, count) [Hz], followed over the speed."""
        found = self.rotor_.run_campbell(speeds, frequencies=count)
        return np.asarray(found.wd) / (2.0 * np.pi)

    def responses(self, speeds: Array) -> Array:
        """Return the response to the unbalances of the first shaft (speeds, n), complex.

        ROSS keeps n × n matrices for each speed: blocks of 100 speeds limit the memory.
        """
        parts = [
            (int(self.offset[part.shaft] / DOFS) + self.node(part.position), abs(part.unbalance))
            for part in bodies(self.system)
            if part.unbalance
        ]
        nodes, magnitudes = zip(*parts, strict=True)
        blocks = []
        for some in np.array_split(speeds, max(1, len(speeds) // 100)):
            self.forget()
            found = self.rotor_.run_unbalance_response(
                list(nodes), list(magnitudes), [0.0] * len(nodes), list(some)
            )
            blocks.append(np.asarray(found.forced_resp).T)
        return np.concatenate(blocks)

    def frequency_response(self, frequencies: Array, place: tuple[str, float]) -> Array:
        """Return the response (frequencies, n) to a unit force along y of the order 1, complex."""
        at, blocks = self.offset[place[0]] + DOFS * self.node(place[1]), []
        for some in np.array_split(frequencies, max(1, len(frequencies) // 100)):
            self.forget()
            force = np.zeros((self.rotor_.ndof, len(some)))
            force[at] = 1.0
            found = self.rotor_.run_forced_response(force=force, speed_range=some)
            blocks.append(np.asarray(found.forced_resp).T)
        return np.concatenate(blocks)

    def simulate(self, force: Array, times: Array, method: str) -> Array:
        """Simulate from rest; return every coordinate at every time."""
        with contextlib.redirect_stdout(io.StringIO()):
            found = self.rotor_.run_time_response(self.speed, force, times, method=method)
        return np.asarray(found.yout)

    def displacement(self, point: tuple[str, float], motion: Array) -> Array:
        """Return the displacements (times, 2) at a (shaft, position)."""
        at = self.offset[point[0]] + DOFS * self.node(point[1])
        return motion[:, at : at + 2]
