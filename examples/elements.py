"""Error and cost of shaft elements by number and degree.

``python examples/elements.py frequencies`` prints the errors of natural frequencies of a shaft on
bearings, ``python examples/elements.py force`` the errors of the mesh forces of the double-stage
train of ``examples/tradeoff.py``, and ``python examples/elements.py conditioning`` what limits the
degree. docs/formulation.md contains these tables; ``make measure`` updates them.
"""

import argparse
import math
from collections.abc import Iterator
from dataclasses import replace
from time import process_time

import numpy as np
from numpy.typing import NDArray
from tradeoff import DURATION, LENGTH, MESHES, SPEED, train

import gearbow as gb

BEARING = 1e8  # N/m
COUNTS = (2, 4, 8)  # elements of the shaft on bearings
FINEST = (8, 8)  # elements and degree of its reference
REFERENCE = (4, 6)  # elements of each shaft and degree of the reference of the mesh forces
CHECK = (4, 5)  # the same of the run that checks the reference
SETTINGS = ((4, 1), (8, 1), (16, 1), (4, 2), (8, 2), (4, 3), (8, 3), (4, 4))
DAMPING = 0.02  # modal damping ratio of the second column
SAMPLES = 4001
RTOL = 1e-8


def rotor(elements: int, degree: int) -> gb.RotorSystem:
    """Return a shaft on two bearings."""
    shaft = gb.Shaft("s", length=LENGTH, outer_diameter=0.05, elements=elements, degree=degree)
    bearings = [gb.Bearing("s", x, stiffness=BEARING) for x in (0.0, LENGTH)]
    return gb.RotorSystem(shafts=[shaft], bearings=bearings, motion="coupled")


def frequencies(elements: int, degree: int) -> tuple[float, float]:
    """Return the third frequency of bending and the second one of torsion [Hz]."""
    modes = rotor(elements, degree).modes()
    whirl = np.array(modes.whirl)
    bending, twist = (modes.frequencies_hz[whirl == kind] for kind in ("planar", "torsion"))
    return float(bending[4]), float(twist[1])


def frequency_rows() -> Iterator[str]:
    """Yield a Markdown table of the errors of two frequencies."""
    exact = frequencies(*FINEST)
    counts = " | ".join(f"{count}" for count in COUNTS)
    yield f"| degree p | frequency | {counts} elements | order |"
    yield f"|{'---|' * (len(COUNTS) + 3)}"
    for degree in (1, 2, 3, 4):
        found = [frequencies(count, degree) for count in COUNTS]
        for i, name in enumerate(("third of bending", "second of torsion")):
            errors = [abs(one[i] / exact[i] - 1.0) for one in found]
            order = math.log2(errors[-2] / errors[-1])
            cells = " | ".join(f"{error:.0e}" for error in errors)
            yield f"| {degree} | {name} | {cells} | {order:.1f} |"


def forces(elements: int, degree: int, damping: float) -> tuple[NDArray[np.float64], int, float]:
    """Return the mesh forces [N], the number of coordinates and the CPU time of a run [s]."""
    given = train()
    shafts = [replace(shaft, elements=elements, degree=degree) for shaft in given.shafts]
    system = given.replace(shafts=shafts, modal_damping=damping)
    start = process_time()
    times = np.linspace(0.0, DURATION, SAMPLES)
    found = system.simulate(DURATION, SPEED, times=times, record=["meshes"], rtol=RTOL)
    seconds = process_time() - start
    return np.column_stack([found.mesh(mesh).force for mesh in MESHES]), len(system.dofs), seconds


def force_rows() -> Iterator[str]:
    """Yield a Markdown table of the errors of the mesh forces."""
    references = [forces(*REFERENCE, damping)[0] for damping in (0.0, DAMPING)]

    def error(found: NDArray[np.float64], reference: NDArray[np.float64]) -> float:
        apart = np.sqrt(np.mean((found - reference) ** 2, axis=0))
        return float(np.max(apart / reference.std(axis=0)))

    percent = f"{100 * DAMPING:.0f} % modal damping"
    yield f"| elements | degree p | coordinates | error | with {percent} | CPU time [s] |"
    yield "|---|---|---|---|---|---|"
    for elements, degree in (*SETTINGS, CHECK):
        runs = [forces(elements, degree, damping) for damping in (0.0, DAMPING)]
        one, two = (error(run[0], wanted) for run, wanted in zip(runs, references, strict=True))
        _, size, seconds = runs[1]
        yield f"| {elements} | {degree} | {size} | {one:.1e} | {two:.1e} | {seconds:.2g} |"


def conditioning_rows() -> Iterator[str]:
    """Yield a Markdown table of the condition and the highest frequency of four elements."""
    yield "| degree p | condition number of the scaled mass matrix | highest frequency [Hz] |"
    yield "|---|---|---|"
    for degree in (1, 2, 4, 8):
        system = rotor(4, degree)
        mass = system.matrices().mass
        size = np.sqrt(np.diag(mass))
        values = np.linalg.eigvalsh(mass / np.outer(size, size))
        highest = system.modes().frequencies_hz.max()
        yield f"| {degree} | {values[-1] / values[0]:.1e} | {highest:.1e} |"


def main() -> None:
    """Print one table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    tables = {
        "frequencies": frequency_rows,
        "force": force_rows,
        "conditioning": conditioning_rows,
    }
    parser.add_argument("table", choices=tables)
    for row in tables[parser.parse_args().table]():
        print(row)


if __name__ == "__main__":
    main()
