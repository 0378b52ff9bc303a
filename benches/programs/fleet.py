"""Analyses of the machines of examples/machines, by gearbow and with the sparse solvers of SciPy.

SciPy takes the matrices of gearbow at each speed. Their assembly and the equilibrium of bearings
count in both times; the undamped modes that define modal damping do not count in that of SciPy.
docs/comparison.md states what each program does.
"""

import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from math import pi
from pathlib import Path
from typing import Any

import numpy as np
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import LinearOperator, eigs, splu

import gearbow as gb
from programs.pencil import SHIFT, Complex, Pencil, crossings
from programs.scenes import Array, bodies
from programs.sparse import modal_damping
from programs.timing import Run, timed

FOLDER = Path(__file__).resolve().parents[2] / "examples" / "machines"
COUNT = 12  # lowest modes, of which some may be overdamped
TRACKED = 6  # modes of a Campbell diagram, and critical speeds of a map
FURTHER = 10  # eigenvalues that SciPy finds beyond both of each pair, for ARPACK to converge
DAMPED = 120  # undamped modes with modal damping
SHARES = np.array([0.4, 0.8, 1.2])  # speeds of a diagram, relative to the rated speed
RANGE = (0.4, 1.2)  # speeds of a response, relative to the rated speed
MANY, FEW = 200, 20  # speeds of a response
LONGEST = 30.0  # CPU time of a response at MANY speeds above which FEW are taken, s
FREQUENCIES = (0.3, 30.0)  # of a frequency response, relative to the rated speed
STIFFNESSES = np.geomspace(1e7, 1e9, 8)  # of every bearing of a map, N/m
NEAR = 1e-4  # half the range of speeds around an intersection, relative to its speed
DURATION = 0.1  # of a run, s
#: Accepted difference of frequency responses with modal damping. gearbow leaves it out of undamped
#: modes far above the frequencies, from the 81st mode on: with damping of all modes, responses of
#: the gearbox differ by up to 1.3e-4 near resonances.
FEW_MODES = 1e-3
#: Accepted difference of synchronous responses and Campbell diagrams with modal damping, of which
#: both programs leave undamped modes out. For responses the peer damps DAMPED ones: in the wind
#: turbine 40, 120 and 200 leave 1.5e-4, 2.3e-6 and 4.6e-7 of the response. For eigenvalues gearbow
#: damps about three times as many modes as are asked for: in the gearbox 3e-6 of them remain.
DAMPED_MODES = 5e-6


@dataclass(frozen=True)
class Work:
    """An analysis of one machine, by one or both programs.

    Parameters
    ----------
    setting : str
        What is computed.
    gearbow, scipy : callable
        Prepares one run, which is timed.
    difference : callable, optional
        Largest relative difference of the results of gearbow and SciPy.
    accepted : float
        Difference above which the row fails.
    """

    setting: str
    gearbow: Callable[[], Run[Any]]
    scipy: Callable[[], Run[Any]] | None = None
    difference: Callable[[Any, Any], float] | None = None
    accepted: float = 1e-6


class Machine:
    """A machine.

    Parameters
    ----------
    path : Path
        Scene file whose header names the rated speed of the reference shaft.
    """

    def __init__(self, path: Path) -> None:
        self.path, self.name = path, path.stem
        self._modal: dict[float, tuple[Array, Array]] = {}

    @cached_property
    def speed(self) -> float:
        """Rated speed of the reference shaft [rad/s]."""
        text = self.path.read_text("utf-8")
        found = re.search(r"^# Rated speed: ([\d.]+) (rpm|rad/s)", text, re.MULTILINE)
        if not found:
            message = f"{self.path}: the header names no rated speed"
            raise ValueError(message)
        return float(found[1]) * (pi / 30.0 if found[2] == "rpm" else 1.0)

    @cached_property
    def system(self) -> gb.RotorSystem:
        """The machine, for descriptions and matrices."""
        return self.loaded()

    @cached_property
    def diagram(self) -> gb.results.Campbell:
        """Campbell diagram whose first intersection is found again."""
        return self.system.campbell(SHARES * self.speed, count=TRACKED)

    def loaded(self) -> gb.RotorSystem:
        """Return the machine as a user loads it."""
        return gb.RotorSystem.load(self.path)

    def fresh(self) -> gb.RotorSystem:
        """Return the machine with its elements, without results of earlier analyses."""
        return gb.RotorSystem.from_dict(self.system._model.resolved())

    @cached_property
    def changes(self) -> bool:
        """Whether the matrices depend on the speed."""
        first, other = (self.undamped().matrices(share * self.speed) for share in RANGE)
        return not (
            np.array_equal(first.stiffness, other.stiffness)
            and np.array_equal(first.damping, other.damping)
        )

    def undamped(self) -> gb.RotorSystem:
        """Return the machine without modal damping, whose matrix is full, and without results."""
        plain = dict(self.system._model.resolved())
        plain.pop("modal_damping", None)
        return gb.RotorSystem.from_dict(plain)

    def pencils(self, speeds: Array) -> Callable[[], list[Pencil]]:
        """Prepare the assembly of the equations of motion at some speeds.

        The undamped modes that define modal damping are known before.
        """
        ratio = float(self.system._model.resolved().get("modal_damping") or 0.0)
        if ratio > 0.0:
            known = self.undamped()
            for speed in map(float, speeds):
                self._prepare_damping(known, speed, ratio)
        system, changes = self.undamped(), self.changes

        def assemble() -> list[Pencil]:
            found: list[Pencil] = []
            matrices = None
            for speed in map(float, speeds):
                if matrices is None or changes:
                    matrices = system.matrices(speed, sparse=True)
                damping = csc_matrix(matrices.damping + speed * matrices.gyroscopic)
                mass, stiffness = csc_matrix(matrices.mass), csc_matrix(matrices.stiffness)
                momenta, rates = self._modal.get(speed, (None, None))
                found.append(Pencil(mass, damping, stiffness, momenta, rates, ratio))
            return found

        return assemble

    def pencil(self, speed: float) -> Pencil:
        """Return the equation of motion at a speed."""
        return self.pencils(np.array([speed]))()[0]

    def _prepare_damping(self, system: gb.RotorSystem, speed: float, ratio: float) -> None:
        """Find the undamped modes that define modal damping at a speed."""
        if speed not in self._modal:
            matrices = system.matrices(speed, sparse=True)
            mass, stiffness = csc_matrix(matrices.mass), csc_matrix(matrices.stiffness)
            # Oil films have no symmetric stiffness.
            symmetric = 0.5 * (stiffness + stiffness.T)
            count = min(DAMPED, mass.shape[0] - 2)
            self._modal[speed] = modal_damping(symmetric, mass, ratio, count)


def load(machine: Machine) -> Work:
    """Read the file, and choose the elements."""
    return Work("", lambda: machine.loaded)


def static(machine: Machine) -> Work:
    """Find the equilibrium at the rated speed."""

    def prepare() -> Run[Any]:
        system = machine.fresh()
        return lambda: system.static(speed=machine.speed)

    return Work("live geometry", prepare)


def modes(machine: Machine) -> Work:
    """Find the lowest modes at the rated speed.

    Internal damping of a shaft makes all motions of high frequency overdamped, so that these have
    the lowest frequencies: the modes of such a machine are its vibrations.
    """
    vibrating = any(shaft.internal_damping for shaft in machine.system.shafts)

    def prepare() -> Run[Any]:
        system = machine.fresh()
        return lambda: system.modes(machine.speed, count=COUNT, vibrating=vibrating).eigenvalues

    count = min(2 * COUNT + FURTHER, len(machine.system.dofs))
    setting = f"{COUNT} vibrations" if vibrating else f"{COUNT} modes"

    def assembled() -> Run[Any]:
        pencils = machine.pencils(np.array([machine.speed]))
        return lambda: pencils()[0].eigenvalues(count)[0]

    return Work(setting, prepare, assembled, not_found)


def campbell(machine: Machine, shares: Array = SHARES, count: int = TRACKED) -> Work:
    """Follow modes over the speed, and find their intersections with excitation lines."""
    speeds = shares * machine.speed

    def prepare() -> Run[Any]:
        system = machine.fresh()

        def run() -> Any:
            found = system.campbell(speeds, count=count)
            if count == TRACKED:
                machine.diagram = found
            return found.eigenvalues

        return run

    number = min(2 * count + FURTHER, len(machine.system.dofs))

    def assembled() -> Run[Any]:
        pencils = machine.pencils(speeds)
        return lambda: [pencil.eigenvalues(number)[0] for pencil in pencils()]

    return Work(
        f"{len(speeds)} speeds × {count} modes",
        prepare,
        assembled,
        lambda found, exact: max(map(not_found, found, exact)),
        DAMPED_MODES if machine.system.modal_damping else 1e-6,
    )


def diagram(machine: Machine) -> Work:
    """Follow more modes over more speeds."""
    return campbell(machine, np.linspace(SHARES[0], SHARES[-1], 28), 14)


def synchronous(machine: Machine) -> Work | str:
    """Find the response to bow and unbalance; without bending, there is none."""
    if machine.system.motion == "torsion":
        return "none, because the machine has no lateral motion"

    def prepare(count: int) -> Run[Any]:
        system, speeds = machine.fresh(), machine.speed * np.linspace(*RANGE, count)
        return lambda: system.synchronous(speeds).amplitudes

    probe = timed(lambda: prepare(len(SHARES)))[1] / len(SHARES)
    count = MANY if MANY * probe <= LONGEST else FEW
    speeds = machine.speed * np.linspace(*RANGE, count)
    ratios, loads = machine.system.speed_ratios, forces(machine)
    excited = [i for i in range(len(ratios)) if any(part[i].any() for part in vars(loads).values())]

    def respond(pencils: Callable[[], list[Pencil]]) -> Complex:
        found = np.zeros((count, *loads.constant.shape), dtype=complex)
        for i, (speed, pencil) in enumerate(zip(speeds, pencils(), strict=True)):
            for shaft in excited:
                omega = float(ratios[shaft] * speed)
                found[i, shaft] = pencil.inverse(1j * omega)(loads.at(shaft, omega))
        return found

    def assembled() -> Run[Any]:
        pencils = machine.pencils(speeds)
        return lambda: respond(pencils)

    scale = np.sqrt(np.abs(machine.pencil(float(speeds[0])).stiffness.diagonal()))

    def difference(found: Complex, exact: Complex) -> float:
        apart = np.linalg.norm(scale * (found - exact), axis=2)
        size = np.linalg.norm(scale * exact, axis=2)
        return float(np.max(apart[size > 0.0] / size[size > 0.0]))

    accepted = DAMPED_MODES if machine.system.modal_damping else 1e-6
    return Work(f"{count} speeds", lambda: prepare(count), assembled, difference, accepted)


def frequency_response(machine: Machine) -> Work:
    """Find the response at the rated speed to a force, or to a torque without bending."""
    body = bodies(machine.system)[0]
    lateral = machine.system.motion != "torsion"
    source = gb.Force(str(body.name), 1.0) if lateral else gb.Torque(str(body.name), 1.0)

    def prepare(count: int) -> Run[Any]:
        system, frequencies = machine.fresh(), machine.speed * np.geomspace(*FREQUENCIES, count)
        return lambda: system.frequency_response(
            frequencies, source=source, speed=machine.speed
        ).phasors[:, 0]

    probe = timed(lambda: prepare(len(SHARES)))[1] / len(SHARES)
    count = MANY if MANY * probe <= LONGEST else FEW
    frequencies = machine.speed * np.geomspace(*FREQUENCIES, count)
    coordinates = machine.system.coordinates
    at = coordinates.lateral(str(body.name))[0] if lateral else coordinates.twist(str(body.name))
    force = np.zeros(len(machine.system.dofs), dtype=complex)
    force[at] = 1.0
    scale = np.sqrt(np.abs(machine.pencil(machine.speed).stiffness.diagonal()))

    def assembled() -> Run[Any]:
        pencils = machine.pencils(np.array([machine.speed]))

        def respond() -> Complex:
            pencil = pencils()[0]
            return np.array([pencil.inverse(1j * omega)(force) for omega in frequencies])

        return respond

    def difference(found: Complex, exact: Complex) -> float:
        apart, size = (np.linalg.norm(scale * each, axis=1) for each in (found - exact, exact))
        return float(np.max(apart / size))

    return Work(
        f"{count} frequencies",
        lambda: prepare(count),
        assembled,
        difference,
        FEW_MODES if machine.system.modal_damping else 1e-6,
    )


@dataclass(frozen=True)
class Forces:
    """Forces of the rotation of each shaft: constant + iω rate + ω² unbalance, (shafts, n) each."""

    constant: Complex
    rate: Complex
    unbalance: Complex

    def at(self, shaft: int, omega: float) -> Complex:
        """Return the force of a shaft that turns with ω [rad/s]."""
        force: Complex = (
            self.constant[shaft] + 1j * omega * self.rate[shaft] + omega**2 * self.unbalance[shaft]
        )
        return force


def forces(machine: Machine) -> Forces:
    """Return the forces of the rotation of each shaft.

    Those of bows, run-out and tooth errors follow from the responses of gearbow at two speeds. The
    comparison at all other speeds checks them.
    """
    system = machine.system
    names = [shaft.name for shaft in system.shafts]
    unbalances = np.zeros((len(names), len(system.dofs)), dtype=complex)
    # A body without lateral motion has no unbalance.
    for body in (body for body in bodies(system) if body.unbalance):
        y, z = system.coordinates.lateral(str(body.name))
        unbalances[names.index(body.shaft), y] += body.unbalance
        unbalances[names.index(body.shaft), z] -= 1j * body.unbalance
    speeds = machine.speed * np.array(RANGE)
    found = system.synchronous(speeds).amplitudes
    given = np.zeros_like(found)
    for k, speed in enumerate(speeds):
        matrices = system.matrices(speed)
        damping = matrices.damping + speed * matrices.gyroscopic
        for i, ratio in enumerate(system.speed_ratios):
            omega = ratio * speed
            dynamic = matrices.stiffness + 1j * omega * damping - omega**2 * matrices.mass
            if found[k, i].any():
                given[k, i] = dynamic @ found[k, i] - omega**2 * unbalances[i]
    rates = np.array(system.speed_ratios)[:, None]
    step = 1j * rates * (speeds[1] - speeds[0])
    # A shaft that stands still has no force of its rotation.
    slope = np.divide(given[1] - given[0], step, out=np.zeros_like(given[0]), where=step != 0.0)
    return Forces(given[0] - 1j * rates * speeds[0] * slope, slope, unbalances)


def critical_map(machine: Machine) -> Work | str:
    """Find the undamped critical speeds against the stiffness of all bearings, if there are any."""
    if not machine.system.bearings:
        return "none, because the machine has no bearings"

    def prepare() -> Run[Any]:
        system = gb.RotorSystem.from_dict(plain)
        return lambda: system.critical_speed_map(STIFFNESSES, count=TRACKED)

    stiffest = with_stiffness(machine.system.description, float(STIFFNESSES.max()))
    plain = gb.RotorSystem.from_dict(stiffest)._model.resolved()
    cases = []
    for stiffness in STIFFNESSES:
        system = gb.RotorSystem.from_dict(with_stiffness(plain, float(stiffness)))
        matrices = system.matrices(1.0, sparse=True)
        effective = csc_matrix(matrices.mass - 1j * matrices.gyroscopic)
        cases.append((csc_matrix(matrices.stiffness), effective))

    def difference(found: gb.results.CriticalSpeedMap, exact: list[Array]) -> float:
        return max(
            float(np.abs(values - speed).min() / speed)
            for row, values in zip(found.speeds, exact, strict=True)
            for speed in row
            if np.isfinite(speed)
        )

    return Work(
        f"{len(STIFFNESSES)} stiffnesses × {TRACKED} speeds",
        prepare,
        lambda: lambda: [critical_speeds(*case) for case in cases],
        difference,
    )


def with_stiffness(plain: Any, stiffness: float) -> dict[str, Any]:
    """Return a scene whose bearings have this stiffness along y and z, without damping."""
    kept = ("shaft", "position", "axial_stiffness", "tilting_stiffness", "support")
    bearings = [
        {**{key: bearing[key] for key in kept if key in bearing}, "stiffness": stiffness}
        for bearing in plain["bearings"]
    ]
    others = {key: value for key, value in plain.items() if key != "modal_damping"}
    return {**others, "bearings": bearings}


def critical_speeds(stiffness: Any, effective: Any) -> Array:
    """Return the speeds Ω with K x = Ω² (M − iG) x near the lowest one [rad/s]."""
    shift = -(SHIFT**2)
    factors = splu(csc_matrix(stiffness - shift * effective))
    n = effective.shape[0]
    operator = LinearOperator((n, n), matvec=lambda x: factors.solve(effective @ x), dtype=complex)
    count = min(TRACKED + FURTHER, n - 2)
    start = np.ones(n, dtype=complex)
    squares = shift + 1.0 / eigs(operator, k=count, v0=start, return_eigenvectors=False)
    speeds: Array = np.sqrt(squares.real[squares.real > 1.0])
    return speeds


def intersection(machine: Machine) -> Work | str:
    """Find an intersection of a mode and an excitation line again, if there is any."""
    if not machine.diagram.intersections:
        return "none, because no line meets a mode"
    first = machine.diagram.intersections[0]
    speeds = first.speed * np.array([1.0 - NEAR, 1.0 + NEAR])

    def prepare() -> Run[Any]:
        system = machine.fresh()

        def run() -> Array:
            met = system.campbell(speeds, count=TRACKED).intersections
            return np.array([crossing.speed for crossing in met])

        return run

    orders = sorted({line.order for line in machine.diagram.lines})
    count = min(2 * TRACKED + FURTHER, len(machine.system.dofs))
    both = (float(speeds[0]), float(speeds[1]))

    def assembled() -> Run[Any]:
        pencils = machine.pencils(speeds)

        def meet() -> list[float]:
            lower, upper = pencils()
            return crossings((lower, upper), both, orders, count)

        return meet

    def difference(found: Array, exact: list[float]) -> float:
        if not (len(found) and exact):
            return float("inf")
        return float(max(np.abs(np.array(exact) - speed).min() / speed for speed in found))

    return Work(
        f"order {first.line.order:.4g}",
        prepare,
        assembled,
        difference,
    )


def first_run(machine: Machine) -> Work:
    """Simulate a machine for the first time."""

    def prepare() -> Run[Any]:
        system = machine.loaded()
        return lambda: system.simulate(DURATION, machine.speed)

    return Work(f"{DURATION:g} s", prepare)


def run(machine: Machine) -> Work:
    """Simulate a machine again."""
    system = machine.loaded()
    system.simulate(DURATION, machine.speed)
    return Work(f"{DURATION:g} s", lambda: lambda: system.simulate(DURATION, machine.speed))


def not_found(found: Complex, exact: Complex) -> float:
    """Return the largest relative distance of an oscillating eigenvalue from the nearest exact one.

    SciPy finds the eigenvalues near a shift, without overdamped ones that are far from it. A mode
    of a diagram that has passed other modes may be beyond all that SciPy finds, and is left out.
    """
    oscillating = found[(found.imag > 1.0) & (np.abs(found) <= np.abs(exact).max())]
    distances = np.abs(oscillating[:, None] - exact).min(axis=1) / np.abs(oscillating)
    return float(distances.max(initial=0.0))


#: Analyses of both programs.
LINEAR: dict[str, Callable[[Machine], Work | str]] = {
    "modes": modes,
    "campbell": campbell,
    "intersection": intersection,
    "synchronous": synchronous,
    "frequency_response": frequency_response,
    "critical_speed_map": critical_map,
}
#: Analyses of gearbow.
OTHERS: dict[str, Callable[[Machine], Work | str]] = {
    "load": load,
    "static": static,
    "first_run": first_run,
    "run": run,
}
#: Analyses that are measured only if they are named.
OPTIONAL: dict[str, Callable[[Machine], Work | str]] = {"campbell_28x14": diagram}
