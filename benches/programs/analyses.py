"""Analyses of systems of increasing size, by every program that can do the same work."""

import functools
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

import numpy as np

import gearbow as gb
from programs.scenes import MEAN, PAIR, SPEED, STAGES, TRAIN, Array, bodies, geared, unbalanced
from programs.timing import Run

#: Prepares an analysis of a system; each call of the result prepares one run, which is timed.
Program: TypeAlias = Callable[[gb.RotorSystem], Callable[[], Run[Any]]]

MODES = 9  # lowest frequencies above zero that are compared
EIGENVALUES = 30  # of SciPy: pairs, the rigid-body rotation, and some more for ARPACK to converge
SPEEDS = np.linspace(1.0, 300.0, 1000)  # of the synchronous response, rad/s
DIAGRAM = np.linspace(0.0, 300.0, 20)  # speeds of the Campbell diagram, rad/s
OVERDAMPED = 5e4  # damping of bearings that makes modes overdamped, N s/m
MODAL_DAMPING = 0.02  # damping ratio of every mode
UNDAMPED = 100  # undamped modes on which the residual has modal damping
CHECKED = (0, 10, 19)  # speeds of the Campbell diagram with a reference
SAMPLE = slice(None, None, 111)  # speeds of the synchronous response with a reference
FREQUENCIES = np.linspace(1.0, 3000.0, 2000)  # of the frequency response, rad/s
FEW_FREQUENCIES = slice(None, None, 222)  # of these, with a reference
FEW_SPEEDS = np.linspace(1.0, 300.0, 50)  # of the response with modal damping, rad/s
FEW_SAMPLES = slice(None, None, 12)  # of these, with a reference


@dataclass(frozen=True)
class Subject:
    """A system that is analysed."""

    title: str
    build: Callable[[], gb.RotorSystem]
    ross: bool = False  # whether ROSS can model the system
    large: bool = False  # whether a quick comparison leaves it out


@dataclass(frozen=True)
class Analysis:
    """An analysis and the programs that carry it out."""

    title: str
    programs: Mapping[str, Program]
    exact: Callable[[gb.RotorSystem], Any]
    error: Callable[[Any, Any], float]  # of the found and the exact result
    subjects: tuple[str, ...] = ()  # names of the systems; all if empty


def of_gearbow(call: Callable[[gb.RotorSystem], Any]) -> Program:
    """Analyse a system that has kept nothing of earlier analyses."""

    def prepare(system: gb.RotorSystem) -> Callable[[], Run[Any]]:
        def fresh() -> Run[Any]:
            return functools.partial(call, gb.RotorSystem.from_dict(system.description))

        return fresh

    return prepare


def of_scipy(call: Callable[[Any], Any]) -> Program:
    """Analyse with SciPy; the matrices are assembled before."""

    def prepare(system: gb.RotorSystem) -> Callable[[], Run[Any]]:
        from programs.sparse import Sparse  # noqa: PLC0415  # not needed by gearbow

        sparse = Sparse(system, SPEED)
        return lambda: functools.partial(call, sparse)

    return prepare


def of_ross(call: Callable[[Any], Any]) -> Program:
    """Analyse with ROSS; the model is built before."""

    def prepare(system: gb.RotorSystem) -> Callable[[], Run[Any]]:
        from programs.ross_rotor import Ross  # noqa: PLC0415  # slow import

        model = Ross(system, SPEED)
        model.campbell(DIAGRAM[:2], 2)  # ROSS compiles its functions in the first call

        def fresh() -> Run[Any]:
            model.forget()
            return functools.partial(call, model)

        return fresh

    return prepare


def exactly(call: Callable[[Any], Any]) -> Callable[[gb.RotorSystem], Any]:
    """Compute a reference with the matrices of SciPy."""

    def exact(system: gb.RotorSystem) -> Any:
        return of_scipy(call)(system)()()

    return exact


def frequency_error(found: Array, exact: Array) -> float:
    """Return the largest relative difference of each exact frequency from the nearest found."""
    found, exact = np.atleast_2d(found), np.atleast_2d(exact)
    if len(found) > len(exact):
        found = found[list(CHECKED)]
    pairs = zip(found, exact, strict=True)
    return float(
        max(np.max(np.min(np.abs(f[:, None] - e), axis=0) / e) for f, e in pairs if len(e))
    )


def relative_error(found: Any, exact: Any) -> float:
    """Return the norm of the difference over the norm of the exact values."""
    return float(np.linalg.norm(np.asarray(found) - exact) / np.linalg.norm(exact))


def lateral(system: gb.RotorSystem) -> list[tuple[str, float]]:
    """Return the (shaft, position) of every gear and disk."""
    return [(part.shaft, part.position) for part in bodies(system)]


def gearbow_static(system: gb.RotorSystem) -> Array:
    """Return the displacements of the gears at equilibrium [m]."""
    found = system.static(speed=SPEED)
    return np.array([found.displacement(place) for place in lateral(system)])


def scipy_static(sparse: Any, tolerance: float, *, extended: bool = False) -> Array:
    """Return the same from the coordinates that SciPy found."""
    found = sparse.static(tolerance, extended=extended)
    return np.array(
        [[found[sparse.index[(shaft, x, d)]] for d in "vw"] for shaft, x in lateral(sparse.system)]
    )


def gearbow_response(system: gb.RotorSystem) -> Any:
    """Return the displacements of the gears and disks (places, speeds, sources, 2), complex."""
    found = system.synchronous(SPEEDS)
    return np.array([found.displacement(place) for place in lateral(system)])[:, SAMPLE]


def scipy_response(sparse: Any, speeds: Array, refinements: int = 0) -> Any:
    """Return the same, at given speeds."""
    found = sparse.responses(speeds, refinements)
    if len(speeds) == len(SPEEDS):
        found = found[SAMPLE]
    rows = [[sparse.index[(shaft, x, d)] for d in "vw"] for shaft, x in lateral(sparse.system)]
    return np.moveaxis(found[..., rows], 2, 0)


def modally_damped_response(system: gb.RotorSystem) -> Any:
    """Return the displacements of the gears and disks with modal damping."""
    found = system.replace(modal_damping=MODAL_DAMPING).synchronous(FEW_SPEEDS)
    return np.array([found.displacement(place) for place in lateral(system)])[:, FEW_SAMPLES]


def modally_damped_reference(sparse: Any) -> Any:
    """Return the same, with modal damping on the lowest undamped modes."""
    found = sparse.modally_damped(FEW_SPEEDS[FEW_SAMPLES], MODAL_DAMPING, UNDAMPED)
    rows = [[sparse.index[(shaft, x, d)] for d in "vw"] for shaft, x in lateral(sparse.system)]
    return np.moveaxis(found[..., rows], 2, 0)


def gearbow_frequencies(system: gb.RotorSystem) -> Any:
    """Return the displacements (places, frequencies, 2) under a force on the first gear or disk."""
    places = lateral(system)
    source = gb.Force(places[0], 1.0)
    found = system.frequency_response(order=1.0, speeds=FREQUENCIES, source=source)
    return np.array([found.displacement(place)[:, 0] for place in places])[:, FEW_FREQUENCIES]


def scipy_frequencies(sparse: Any, frequencies: Array, refinements: int = 0) -> Any:
    """Return the same, at given frequencies."""
    places = lateral(sparse.system)
    found = sparse.frequency_response(frequencies, places[0], refinements)
    if len(frequencies) == len(FREQUENCIES):
        found = found[FEW_FREQUENCIES]
    rows = [[sparse.index[(shaft, x, d)] for d in "vw"] for shaft, x in places]
    return np.moveaxis(found[:, rows], 1, 0)


def ross_frequencies(model: Any) -> Any:
    """Return the same."""
    places = lateral(model.system)
    found = model.frequency_response(FREQUENCIES, places[0])[FEW_FREQUENCIES]
    return np.array([model.displacement(place, found) for place in places])


def ross_response(model: Any) -> Any:
    """Return the same; only the first shaft has unbalance."""
    found = model.responses(SPEEDS)[SAMPLE]
    shafts = len(model.system.shafts)
    places = [model.displacement(place, found) for place in lateral(model.system)]
    return np.array([np.stack([place] + [0.0 * place] * (shafts - 1), axis=1) for place in places])


def first(system: gb.RotorSystem, **options: Any) -> Array:
    """Return the displacements of the gears over 1 ms (gears, times, 2) [m]."""
    response = system.simulate(1e-3, SPEED, times=np.linspace(0.0, 1e-3, 101), **options)
    return np.stack([response.displacement(place) for place in lateral(system)])


def motion_error(found: Array, exact: Array) -> float:
    """Return the norm of the difference over the norm of the motion about its mean."""
    motion = exact - exact.mean(axis=1, keepdims=True)
    return float(np.linalg.norm(found - exact) / np.linalg.norm(motion))


def strongly_damped(system: gb.RotorSystem) -> gb.RotorSystem:
    """Return a system with strongly damped bearings at the same places."""
    places = [(bearing.shaft, bearing.position) for bearing in system.bearings]
    return system.replace(
        bearings=[gb.Bearing(shaft, x, stiffness=1e8, damping=OVERDAMPED) for shaft, x in places]
    )


def overdamped_modes(system: gb.RotorSystem) -> gb.results.Modes:
    """Return the ten lowest modes with strongly damped bearings."""
    return strongly_damped(system).modes(SPEED, count=10)


def overdamped_matrices(system: gb.RotorSystem) -> Any:
    """Return the sparse matrices with strongly damped bearings."""
    return strongly_damped(system).matrices(SPEED, sparse=True)


def modally_damped_modes(system: gb.RotorSystem) -> gb.results.Modes:
    """Return the ten lowest modes with modal damping."""
    return system.replace(modal_damping=MODAL_DAMPING).modes(SPEED, count=10)


def modal_damping_residual(found: gb.results.Modes, matrices: Any) -> float:
    """Return the same with modal damping, of which the lowest undamped modes hold almost all."""
    from scipy.sparse.linalg import eigsh  # noqa: PLC0415  # not needed by gearbow

    squares, shapes = eigsh(matrices.stiffness, UNDAMPED, matrices.mass, sigma=-1e4)
    momenta = matrices.mass @ shapes
    rates = 2.0 * MODAL_DAMPING * np.sqrt(np.maximum(squares, 0.0))
    return mode_residual(found, matrices, lambda x: momenta @ (rates * (momenta.T @ x)))


def mode_residual(
    found: gb.results.Modes, matrices: Any, modal: Callable[[Array], Array] = np.zeros_like
) -> float:
    """Return the largest residual of a mode over the sum of the sizes of its terms.

    `modal` gives the force of modal damping, N, for a velocity.
    """
    rate = matrices.damping + SPEED * matrices.gyroscopic
    residuals = []
    for value, shape in zip(found.eigenvalues, found.shapes, strict=True):
        if value == 0.0:
            continue  # the rigid-body rotation, whose terms are round-off
        parts = (matrices.stiffness @ shape, value * (rate @ shape + modal(shape)))
        inertia = value**2 * (matrices.mass @ shape)
        size = sum(np.abs(part) for part in (*parts, inertia))
        residual = np.abs(parts[0] + parts[1] + inertia)
        residuals.append(np.linalg.norm(residual) / np.linalg.norm(size))
    return float(max(residuals))


def unbalanced_pair() -> gb.RotorSystem:
    """Return a geared pair with unbalance of the first gear, and without bow."""
    system = geared(PAIR, (("g1", "g2"),), MEAN, 0.0, bow=0.0)
    driver, driven = system.gears
    return system.replace(gears=[replace(driver, unbalance=1e-3), driven])


SUBJECTS = {
    "rotor": Subject("rotor", unbalanced, ross=True),
    "pair": Subject("geared pair", unbalanced_pair, ross=True),
    **{
        f"train {elements}": Subject(
            "train",
            functools.partial(geared, TRAIN, STAGES, MEAN, 0.05, elements=elements),
            large=elements > 40,
        )
        for elements in (15, 40, 79, 319)
    },
}
TRAINS = tuple(name for name in SUBJECTS if name.startswith("train"))

ANALYSES = {
    "modes": Analysis(
        f"Ten lowest modes at {SPEED:g} rad/s",
        {
            "gearbow": of_gearbow(lambda system: system.modes(SPEED, count=10).frequencies_hz),
            "SciPy": of_scipy(lambda sparse: sparse.frequencies(SPEED, EIGENVALUES)),
            "ROSS": of_ross(lambda model: model.frequencies(SPEED, 10)),
        },
        exactly(lambda sparse: sparse.exact_frequencies(SPEED, MODES)),
        frequency_error,
    ),
    "overdamped": Analysis(
        f"Ten lowest modes at {SPEED:g} rad/s, bearings with {OVERDAMPED:g} N s/m",
        {"gearbow": of_gearbow(overdamped_modes)},
        overdamped_matrices,
        mode_residual,
        TRAINS,
    ),
    "modal": Analysis(
        f"Ten lowest modes at {SPEED:g} rad/s, modal damping {MODAL_DAMPING:g}",
        {"gearbow": of_gearbow(modally_damped_modes)},
        lambda system: system.matrices(SPEED, sparse=True),
        modal_damping_residual,
        TRAINS,
    ),
    "campbell": Analysis(
        f"Campbell diagram, ten modes at {len(DIAGRAM)} speeds",
        {
            "gearbow": of_gearbow(lambda system: system.campbell(DIAGRAM).frequencies_hz),
            "SciPy": of_scipy(
                lambda sparse: np.array(
                    [sparse.frequencies(speed, EIGENVALUES)[:MODES] for speed in DIAGRAM]
                )
            ),
            "ROSS": of_ross(lambda model: model.campbell(DIAGRAM, 10)),
        },
        exactly(
            lambda sparse: np.array([sparse.exact_frequencies(DIAGRAM[i], MODES) for i in CHECKED])
        ),
        frequency_error,
    ),
    "synchronous": Analysis(
        f"Synchronous response at {len(SPEEDS)} speeds",
        {
            "gearbow": of_gearbow(gearbow_response),
            "SciPy": of_scipy(lambda sparse: scipy_response(sparse, SPEEDS)),
            "ROSS": of_ross(ross_response),
        },
        exactly(lambda sparse: scipy_response(sparse, SPEEDS[SAMPLE], 2)),
        relative_error,
    ),
    "frequency": Analysis(
        f"Response to a force at {len(FREQUENCIES)} frequencies that equal the speed",
        {
            "gearbow": of_gearbow(gearbow_frequencies),
            "SciPy": of_scipy(lambda sparse: scipy_frequencies(sparse, FREQUENCIES)),
            "ROSS": of_ross(ross_frequencies),
        },
        exactly(lambda sparse: scipy_frequencies(sparse, FREQUENCIES[FEW_FREQUENCIES], 2)),
        relative_error,
    ),
    "modal-synchronous": Analysis(
        f"Synchronous response at {len(FEW_SPEEDS)} speeds, modal damping {MODAL_DAMPING:g}",
        {"gearbow": of_gearbow(modally_damped_response)},
        exactly(modally_damped_reference),
        relative_error,
        TRAINS,
    ),
    "static": Analysis(
        "Static equilibrium, live geometry",
        {
            "gearbow": of_gearbow(gearbow_static),
            "SciPy": of_scipy(lambda sparse: scipy_static(sparse, 1e-10)),
        },
        exactly(lambda sparse: scipy_static(sparse, 1e-14, extended=True)),
        relative_error,
        ("pair", *TRAINS),
    ),
    "first": Analysis(
        "First run, 1 ms from the synchronous motion",
        {"gearbow": of_gearbow(first)},
        lambda system: first(system, method="rk45", rtol=1e-10),
        motion_error,
        TRAINS,
    ),
}
