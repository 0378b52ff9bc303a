"""gearbow beside SciPy: the same bowed train, the same equations, one core each.

SciPy gets what a careful user would write: the dense matrices of the train, one matrix-vector
product for everything linear, and the mesh law in plain floats. The train starts from rest; the
error of a method is the RMS of its gear displacements against SciPy's DOP853 with a tolerance of
1e-9, over the RMS of their motion about its mean, of the worst gear. Set-up is not counted.
Each method runs in a process of its own: ``python benches/compare_scipy.py``, which prints a
Markdown table.
"""

import argparse
import json
import math
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

import gearbow as gb

Array: TypeAlias = NDArray[np.float64]

SPEED = 100.0  # of the input shaft, rad/s
DURATION = 0.05  # s
TIMES = np.linspace(0.0, DURATION, 501)
BOW, LENGTH, SHAFTS = 1.5e-4, 0.5, ("input", "middle", "output")
STIFFNESS, TORQUE, MODULE = 2e8, 250.0, 3e-3
GEARS = {
    "g1": ("input", 0.25, 25),
    "g2": ("middle", 0.125, 50),
    "g3": ("middle", 0.375, 25),
    "g4": ("output", 0.25, 50),
}
MESHES = (("g1", "g2"), ("g3", "g4"))


def train() -> gb.RotorSystem:
    """Describe the train of the README."""
    bow = gb.Bow.half_sine(BOW)
    return gb.RotorSystem(
        shafts=[
            gb.Shaft(name, length=LENGTH, outer_diameter=0.05, elements=8, bow=bow)
            for name in SHAFTS
        ],
        gears=[
            gb.Gear(name, shaft, x, teeth, module=MODULE, face_width=0.03)
            for name, (shaft, x, teeth) in GEARS.items()
        ],
        meshes=[gb.Mesh(*pair, stiffness=STIFFNESS, damping_ratio=0.05) for pair in MESHES],
        bearings=[
            gb.Bearing(name, x, stiffness=1e8, damping=500.0)
            for name in SHAFTS
            for x in (0.0, LENGTH)
        ],
        torques=[gb.Torque("g1", TORQUE), gb.Torque.balance("g4")],
    )


class Dense:
    """The equations of the train for SciPy: y holds displacements, then velocities."""

    def __init__(self, system: gb.RotorSystem) -> None:
        matrices = system.matrices()
        self.index = {dof: i for i, dof in enumerate(system.dofs)}
        self.n = n = len(self.index)
        stiffness, damping = matrices.stiffness.copy(), matrices.damping.copy()
        self.spins = [float(ratio) * SPEED for ratio in system.speed_ratios]
        self.meshes = []
        for driver, driven in MESHES:
            law = MeshLaw(driver, driven, self)
            # The matrices hold each mesh as it is at rest; here its force is computed instead.
            rest = np.array(law.line(law.alpha, 0.0))
            stiffness[np.ix_(law.at, law.at)] -= law.stiffness * np.outer(rest, rest)
            damping[np.ix_(law.at, law.at)] -= law.damping * np.outer(rest, rest)
            self.meshes.append(law)
        columns = [-stiffness, -damping - SPEED * matrices.gyroscopic]
        columns += [self.bow_force(shaft) for shaft in system.shafts]
        columns.append(self.torques(system.speed_ratios))
        columns += [-np.eye(n)[:, law.at] for law in self.meshes]
        self.linear = np.linalg.solve(matrices.mass, np.hstack(columns))
        self.input = np.ones(self.linear.shape[1])

    def bow_force(self, shaft: gb.Shaft) -> Array:
        """Force K_s q_b of a bow at the shaft angles 0 and −90°: weights of cosine and sine."""
        alone = gb.RotorSystem(shafts=[shaft])
        k = math.pi / LENGTH
        turn = {"v": 1.0, "w": -1j, "G": k, "B": 1j * k}
        wave = {"v": math.sin, "w": math.sin, "G": math.cos, "B": math.cos}
        free = np.array([BOW * turn[d] * wave[d](k * x) for _, x, d in alone.dofs])
        force = np.zeros(self.n, dtype=complex)
        force[[self.index[dof] for dof in alone.dofs]] = alone.matrices().stiffness @ free
        return np.column_stack([force.real, -force.imag])

    def torques(self, ratios: Array) -> Array:
        """Torque at the input, and its balance at the output."""
        force = np.zeros((self.n, 1))
        force[self.index["input", 0.25, "twist"]] = TORQUE
        force[self.index["output", 0.25, "twist"]] = -TORQUE * ratios[0] / ratios[2]
        return force

    def __call__(self, t: float, y: Array) -> Array:
        """Evaluate dy/dt."""
        n, put = self.n, self.input
        put[: 2 * n] = y
        at = 2 * n
        for spin in self.spins:
            put[at], put[at + 1] = math.cos(spin * t), math.sin(spin * t)
            at += 2
        at += 1  # the torques are constant
        for law in self.meshes:
            put[at : at + 6] = law.forces(y[law.at].tolist(), y[law.at_velocity].tolist())
            at += 6
        return np.concatenate([y[n:], self.linear @ put])


class MeshLaw:
    """Change of length of the crossed belt between the base circles; centres along y at rest."""

    def __init__(self, driver: str, driven: str, dense: Dense) -> None:
        (self.shaft, x_a, z_a), (shaft_b, x_b, z_b) = GEARS[driver], GEARS[driven]
        pitch_a, pitch_b = MODULE * z_a / 2.0, MODULE * z_b / 2.0
        self.alpha = math.radians(20.0)
        self.distance = pitch_a + pitch_b
        self.r_a, self.r_b = pitch_a * math.cos(self.alpha), pitch_b * math.cos(self.alpha)
        self.sum = self.r_a + self.r_b
        self.sigma = math.copysign(1.0, dense.spins[SHAFTS.index(self.shaft)])
        inertia_a, inertia_b = (
            gb.STEEL.density * math.pi * r**4 * 0.03 / 2.0 for r in (pitch_a, pitch_b)
        )
        mass = 1.0 / (self.r_a**2 / inertia_a + self.r_b**2 / inertia_b)
        self.stiffness, self.damping = STIFFNESS, 2.0 * 0.05 * math.sqrt(STIFFNESS * mass)
        directions = ("v", "w", "twist")
        places = ((self.shaft, x_a), (shaft_b, x_b))
        self.at = np.array([dense.index[shaft, x, d] for shaft, x in places for d in directions])
        self.at_velocity = self.at + dense.n

    def line(self, alpha: float, gamma: float) -> tuple[float, float, float, float, float, float]:
        """Gradient of the deflection over (v, w, twist) of both gears."""
        across, along = self.sigma * math.cos(alpha), math.sin(alpha)
        y = along * math.cos(gamma) - across * math.sin(gamma)
        z = along * math.sin(gamma) + across * math.cos(gamma)
        return y, z, self.sigma * self.r_a, -y, -z, self.sigma * self.r_b

    def forces(self, q: list[float], v: list[float]) -> list[float]:
        """Mesh force times the gradient."""
        y, z = self.distance + q[3] - q[0], q[4] - q[1]
        gamma, alpha = math.atan2(z, y), math.acos(self.sum / math.hypot(y, z))
        rolled = self.r_a * q[2] + self.r_b * q[5] - self.sum * gamma
        involute = math.tan(alpha) - alpha - (math.tan(self.alpha) - self.alpha)
        line = self.line(alpha, gamma)
        rate = sum(slope * velocity for slope, velocity in zip(line, v, strict=True))
        deflection = self.sigma * rolled - self.sum * involute
        force = self.stiffness * deflection + self.damping * rate
        return [force * slope for slope in line]


def with_gearbow(**options: Any) -> Callable[[], Callable[[], Array]]:
    """Prepare a run of gearbow."""

    def prepare() -> Callable[[], Array]:
        system = train()
        system.modes(speed=SPEED, count=1)

        def run() -> Array:
            response = system.simulate(
                DURATION, SPEED, initial="rest", times=TIMES, record=["gears"], **options
            )
            return np.stack([response.displacement(name) for name in GEARS])

        return run

    return prepare


def with_scipy(method: str, **options: Any) -> Callable[[], Callable[[], Array]]:
    """Prepare a run of SciPy, whose error control alone does not keep its steps stable."""

    def prepare() -> Callable[[], Array]:
        from scipy.integrate import solve_ivp  # noqa: PLC0415  # gearbow's processes do without

        system = train()
        dense = Dense(system)
        statistics = system.simulate(0.0, SPEED, initial="rest").statistics
        cap = 0.98 / statistics.omega_max
        rows = [[dense.index[shaft, x, d] for d in ("v", "w")] for shaft, x, _ in GEARS.values()]

        def run() -> Array:
            found = solve_ivp(
                dense,
                (0.0, DURATION),
                np.zeros(2 * dense.n),
                method,
                TIMES,
                max_step=cap,
                **options,
            )
            return np.moveaxis(found.y[rows], 1, 2)

        return run

    return prepare


REFERENCE = "reference"
SCIPY = "SciPy RK45, rtol 1e-3, steps capped at 0.98/ω"
METHODS = {
    REFERENCE: with_scipy("DOP853", rtol=1e-9, atol=1e-15),
    SCIPY: with_scipy("RK45", rtol=1e-3, atol=1e-9),
    "gearbow rk45, rtol 1e-3": with_gearbow(method="rk45", rtol=1e-3),
    "gearbow rk45, rtol 1e-6": with_gearbow(method="rk45", rtol=1e-6),
    "gearbow rk4": with_gearbow(method="rk4"),
}


def measure(method: str, output: Path) -> None:
    """Run one method; write its displacements, print its cost."""
    run = METHODS[method]()
    begin = time.process_time()
    found = run()
    seconds = time.process_time() - begin
    np.save(output, found)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    megabytes = peak / (2**20 if sys.platform == "darwin" else 2**10)
    print(json.dumps({"seconds": seconds, "megabytes": megabytes}))


def apart(method: str, folder: Path) -> tuple[Array, dict[str, float]]:
    """Run one method in a process of its own, on one core."""
    output = folder / "found.npy"
    threads = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
    done = subprocess.run(
        [sys.executable, __file__, "--method", method, "--output", output],
        env={**os.environ, **dict.fromkeys(threads, "1")},
        check=True,
        stdout=subprocess.PIPE,
        text=True,
    )
    return np.load(output), json.loads(done.stdout)


def compare() -> None:
    """Print the table."""
    print("| method | CPU s per simulated s | error | SciPy's time over it | peak memory [MB] |")
    print("|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        exact, _ = apart(REFERENCE, Path(folder))
        motion = np.sqrt(np.mean((exact - exact.mean(axis=1, keepdims=True)) ** 2, axis=(1, 2)))
        base = math.nan
        for method in list(METHODS)[1:]:
            found, cost = apart(method, Path(folder))
            error = np.max(np.sqrt(np.mean((found - exact) ** 2, axis=(1, 2))) / motion)
            base = cost["seconds"] if method == SCIPY else base
            print(
                f"| {method} | {cost['seconds'] / DURATION:.3g} | {error:.0e}"
                f" | {base / cost['seconds']:.1f} | {cost['megabytes']:.0f} |"
            )


def main() -> None:
    """Compare all methods, or run one."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--method", choices=METHODS, help="run this one alone, for the comparison")
    parser.add_argument("--output", type=Path, help="where that one writes its displacements")
    arguments = parser.parse_args()
    if arguments.method is None:
        compare()
    else:
        measure(arguments.method, arguments.output)


if __name__ == "__main__":
    main()
