"""Motion with tooth pairs, compared with matrix exponentials and with SciPy on the gradient of an
energy.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from reference.bows import HalfSine
from reference.teeth import TeethLaw, Toothed, integrate, propagate, tips

SPEED = 600.0
PAIR = 1.5e8

TORSION = Toothed(torque=80.0, mesh={"damping_ratio": 0.03})
BOWED = Toothed(
    coupled=True,
    torque=80.0,
    bows={"a": HalfSine(5e-5, 0.4), "b": HalfSine(3e-5, -1.0)},
    mesh={"centre_line_angle": 0.3},
)


def with_ratio(scene: Toothed, contact_ratio: float) -> Toothed:
    a, b = tips(scene, contact_ratio)
    return replace(scene, gear={**scene.gear, "tip_radius": (a, b)})


def cycles(scene: Toothed, count: int, per_cycle: int) -> np.ndarray:
    period = 2 * np.pi / (SPEED * scene.teeth[0])
    # no output time is a switching time or a multiple of a step
    return (np.arange(count * per_cycle) + 0.37) * period / per_cycle


@pytest.mark.parametrize("contact_ratio", [0.9, 1.6, 2.0, 2.3])
@pytest.mark.parametrize("bowed", [False, True], ids=["torsion", "bowed"])
@pytest.mark.parametrize("method", ["rk45", "rk4", "exponential"])
def test_square_stiffness_against_matrix_exponentials(
    bowed: bool, contact_ratio: float, method: str
):
    scene = with_ratio(BOWED if bowed else TORSION, contact_ratio)
    stiffness = {"model": "square", "pair": PAIR, "engagement": "sharp"}
    scene = replace(scene, mesh={**scene.mesh, "stiffness": stiffness})
    law = scene.law(mean=PAIR * contact_ratio)
    times = cycles(scene, 6, 7)
    motion, force = propagate(scene, TeethLaw(law, live=False), PAIR, SPEED, times)
    system = scene.package()
    # rk4: (h omega)^4 of the fastest motion that is excited
    options: dict[str, Any] = (
        {"step": 5e-8 if bowed else 2e-7} if method == "rk4" else {"rtol": 1e-12}
    )
    found = system.simulate(
        times[-1],
        SPEED,
        initial="rest",
        geometry="frozen",
        times=times,
        method=method,
        **options,
    )
    n = motion.shape[1] // 2
    dofs = [name for *_, name in system.dofs]
    assert len(dofs) == n
    for gear, shaft in (("ga", "a"), ("gb", "b")):
        at = system.dofs.index((shaft, scene.position, "twist"))
        scale = np.ptp(motion[:, at])
        assert found.twist(gear) == pytest.approx(motion[:, at], abs=1e-9 * scale)
    mesh = found.mesh(("ga", "gb"))
    assert mesh.force == pytest.approx(force, abs=1e-9 * np.ptp(force))
    carrying = set(np.round(mesh.stiffness / PAIR, 9))
    assert carrying == {np.floor(contact_ratio), np.ceil(contact_ratio)}


def parabola(scene: Toothed, middle: float, end: float) -> Callable[[Any], Any]:
    low, high = TeethLaw(scene.law()).path(scene.law().centre_distance)
    centre, half = (low + high) / 2, (high - low) / 2
    return lambda s: middle * (1 - (1 - end) * ((s - centre) / half) ** 2)


def error(a: Any, b: Any) -> Any:
    return (
        4e-6 * np.cos(25 * a + 0.3)
        + 1e-6 * np.cos(50 * a)
        + 8e-6 * np.cos(a - 1)
        + 5e-6 * np.cos(2 * b)
    )


SQUARE = {"model": "square", "pair": PAIR, "engagement": 0.2, "phase": "twist"}
ERROR = {
    "tooth": [(4e-6, 0.3), (1e-6, 0.0)],
    "driver": [(8e-6, -1.0)],
    "driven": [(0.0, 0.0), (5e-6, 0.0)],
}
CASES: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {
    "square, moved by twist": ({"stiffness": SQUARE}, {"width": 0.2}),
    "square, limited by a base circle": ({"stiffness": SQUARE, "teeth": (12, 60)}, {"width": 0.2}),
    "square, limited by the other one": ({"stiffness": SQUARE, "teeth": (60, 12)}, {"width": 0.2}),
    "square, prescribed": (
        {"stiffness": {**SQUARE, "phase": "prescribed"}},
        {"width": 0.2, "twist": False},
    ),
    "square, frozen": ({"stiffness": SQUARE, "frozen": True}, {"width": 0.2, "live": False}),
    "parabolic": (
        {
            "stiffness": {
                "model": "parabolic",
                "pair": PAIR,
                "end_ratio": 0.5,
                "engagement": 0.3,
                "phase": "twist",
            }
        },
        {"width": 0.3, "pair": 0.5},
    ),
    "fourier": (
        {
            "stiffness": {
                "model": "fourier",
                "mean": 2e8,
                "amplitudes": [4e7, 1e7],
                "phases": [0.2, 1.0],
                "phase": "twist",
            }
        },
        {
            "cycle": lambda x: (
                2e8 + 4e7 * np.cos(2 * np.pi * x + 0.2) + 1e7 * np.cos(4 * np.pi * x + 1.0)
            )
        },
    ),
    "linear relief": (
        {"stiffness": SQUARE, "tip_relief": {"amount": 6e-6, "length": 2e-3}},
        {"width": 0.2, "relief": (6e-6, 2e-3, 1)},
    ),
    "parabolic relief": (
        {"stiffness": SQUARE, "tip_relief": {"amount": 6e-6, "length": 2e-3, "shape": "parabolic"}},
        {"width": 0.2, "relief": (6e-6, 2e-3, 2)},
    ),
    "error": ({"stiffness": SQUARE, "error": ERROR}, {"width": 0.2, "error": error}),
    "run-out": ({"stiffness": SQUARE, "runout": (2e-5 + 1e-5j, -1e-5j)}, {"width": 0.2}),
    "run-out, frozen": (
        {"stiffness": SQUARE, "runout": (2e-5 + 1e-5j, -1e-5j), "frozen": True},
        {"width": 0.2, "live": False},
    ),
    "backlash": ({"stiffness": SQUARE, "backlash": 5e-6}, {"width": 0.2, "backlash": 5e-6}),
    "damping in separation": (
        {"stiffness": SQUARE, "backlash": 5e-6, "damping_in_separation": True},
        {"width": 0.2, "backlash": 5e-6, "film": True},
    ),
    "damping in separation, frozen": (
        {
            "stiffness": SQUARE,
            "backlash": 5e-6,
            "damping_in_separation": True,
            "frozen": True,
            "error": ERROR,
        },
        {"width": 0.2, "backlash": 5e-6, "film": True, "live": False, "error": error},
    ),
    "all of it": (
        {
            "stiffness": SQUARE,
            "backlash": 5e-6,
            "error": ERROR,
            "runout": (2e-5 + 1e-5j, -1e-5j),
            "tip_relief": {"amount": 6e-6, "length": 2e-3},
        },
        {"width": 0.2, "backlash": 5e-6, "error": error, "relief": (6e-6, 2e-3, 1)},
    ),
    "all of it, damping in separation": (
        {
            "stiffness": SQUARE,
            "backlash": 5e-6,
            "damping_in_separation": True,
            "error": ERROR,
            "runout": (2e-5 + 1e-5j, -1e-5j),
        },
        {"width": 0.2, "backlash": 5e-6, "film": True, "error": error},
    ),
}


IN_BENDING = (
    "square, moved by twist",
    "square, limited by a base circle",
    "square, limited by the other one",
    "run-out",
    "all of it",
    "damping in separation, frozen",
    "all of it, damping in separation",
)


@pytest.mark.parametrize(
    ("name", "bowed"), [(name, False) for name in CASES] + [(name, True) for name in IN_BENDING]
)
def test_teeth_against_the_gradient_of_their_energy(name: str, bowed: bool):
    given, stated = CASES[name]
    mesh, teeth = dict(given), dict(stated)
    frozen, runout = mesh.pop("frozen", False), mesh.pop("runout", None)
    scene = BOWED if bowed else TORSION
    scene = replace(scene, teeth=mesh.pop("teeth", scene.teeth))
    scene = replace(
        scene,
        mesh={**scene.mesh, **mesh, "damping": 800.0, "damping_ratio": 0.0},
        gear={"runout": runout} if runout else {},
    )
    if runout:
        teeth["runout"] = runout
    end = teeth.get("pair", 1.0)
    if "cycle" not in teeth:
        teeth["pair"] = parabola(scene, PAIR, end)
    law = TeethLaw(scene.law(), **teeth)
    # the independent solution does not locate kinks of the force law (separation, relief), which
    # increases its error
    cornered = "backlash" in mesh or "tip_relief" in mesh
    # one or two mesh periods, for 60 teeth and for 25
    duration = (5e-4 if bowed or cornered else 1e-3) * min(1.0, 25 / scene.teeth[0])
    times = np.linspace(0.0, duration, 31)[1:]
    motion, force = integrate(scene, law, SPEED, times)
    system = scene.package()
    # the independent solution has a tolerance of 1e-10 per step, over a few hundred steps
    tolerance = 1e-6 if cornered else 1e-7
    for method in ("exponential", "rk45"):
        found = system.simulate(
            times[-1],
            SPEED,
            initial="rest",
            geometry="frozen" if frozen else "live",
            times=times,
            method=method,
            rtol=1e-12,
        )
        for gear, shaft in (("ga", "a"), ("gb", "b")):
            at = system.dofs.index((shaft, scene.position, "twist"))
            scale = np.ptp(motion[:, at])
            assert found.twist(gear) == pytest.approx(motion[:, at], abs=tolerance * scale)
        mesh_force = found.mesh(("ga", "gb")).force
        assert mesh_force == pytest.approx(force, abs=tolerance * np.ptp(force))
