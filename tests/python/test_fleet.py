"""Every analysis on every machine of examples/machines, at the rated speed in both senses of rotation.

The equations that a result has to satisfy are those of `reference.equations`. A new analysis is an entry of `ANALYSES`, a new
figure an entry of `FIGURES`, a new machine a file (see `fleet`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import pi
from typing import Any

import numpy as np
import pytest

import gearbow as gb
from fleet import FOLDER, MACHINES, Machine
from reference.equations import Balance, Equations, rotating_force
from reference.figure_texts import check_texts

pytestmark = pytest.mark.skipif(not FOLDER.is_dir(), reason="the examples are not installed")

#: Number of modes.
COUNT = 6
#: Speeds of diagrams and responses, relative to the rated speed. Journal bearings carry nothing at speed 0.
SHARES = np.array([0.4, 0.8, 1.2])


def places(system: gb.RotorSystem) -> list[str]:
    return [body.name for body in (*system.gears, *system.disks)]


def compute_run(system: gb.RotorSystem, speed: float) -> gb.Response:
    """Run two revolutions of the slowest shaft."""
    slowest = min(abs(ratio * speed) for ratio in system.speed_ratios)
    hubs = [hub for coupling in system.couplings for hub in (coupling.a, coupling.b)]
    pedestals = [b.support.name for b in system.bearings if isinstance(b.support, gb.Support)]
    record = ["gears", "disks", "meshes", "bearings", "housings", *pedestals, *hubs]
    return system.simulate(2.0 * 2.0 * pi / slowest, speed, record=record)


def check_static(system: gb.RotorSystem, speed: float, static: gb.Static) -> None:
    balance = Balance(system, static, speed)
    for body in balance.terms:
        # round-off reaches 1e-14
        assert balance.residual(body) < 1e-6, body
    assert set(balance.terms) >= {shaft.name for shaft in system.shafts}


def check_modes(system: gb.RotorSystem, speed: float, modes: gb.Modes) -> None:
    equations = Equations(system, speed)
    assert len(modes.eigenvalues) == COUNT
    for value, shape in zip(modes.eigenvalues, modes.shapes, strict=True):
        # 1e-9 is reached with films, whose eigenvalues range from 1e1 to 1e8
        assert equations.mode_residual(value, shape) < 1e-7, value
    assert np.all(np.diff(modes.frequencies_hz) >= -1e-9)
    highest = float(modes.eigenvalues.imag.max())
    if highest > 0.0:
        for value in equations.eigenvalues_below(highest):
            # round-off splits the double eigenvalue 0 of the rotation of a train
            near = np.abs(modes.eigenvalues - value).min() < 1e-6 * highest
            assert near or abs(value) < 1e-3, f"{value} is missing"


def check_campbell(system: gb.RotorSystem, _: float, campbell: gb.Campbell) -> None:
    assert campbell.eigenvalues.shape == (len(SHARES), COUNT)
    for speed, values in zip(campbell.speeds, campbell.eigenvalues, strict=True):
        equations = Equations(system, speed)
        for value in values:
            assert equations.eigenvalue_residual(value) < 1e-8, (speed, value)
    for crossing in campbell.intersections[:: max(1, len(campbell.intersections) // 3)]:
        rate = 2.0 * pi * crossing.frequency_hz
        # the frequency is that of the excitation, and belongs to an eigenvalue at this speed
        assert rate == pytest.approx(crossing.line.order * crossing.speed, rel=1e-8)
        ratio = crossing.damping_ratio
        value = rate * (1j - ratio / np.sqrt(1.0 - ratio**2))
        assert Equations(system, crossing.speed).eigenvalue_residual(value) < 1e-8, crossing


def check_synchronous(system: gb.RotorSystem, _: float, found: gb.Synchronous) -> None:
    excited = False
    for speed, amplitudes in zip(found.speeds, found.amplitudes, strict=True):
        equations = Equations(system, speed)
        for shaft, ratio, given in zip(system.shafts, system.speed_ratios, amplitudes, strict=True):
            spin = ratio * speed
            force = rotating_force(system, shaft, spin)
            if not force.any():
                assert not given.any()
                continue
            excited = True
            scale = equations.scale(spin)
            residual = equations.dynamic_stiffness(1j * spin) @ given - force
            # 4e-11 is reached
            assert np.linalg.norm(residual / scale) < 1e-9 * np.linalg.norm(force / scale)
            difference = scale * (given - equations.response(spin, force))
            # the direct solution loses digits where the train nearly rotates freely: 3e-9 is reached
            assert np.linalg.norm(difference) < 1e-7 * np.linalg.norm(scale * given)
    assert excited


def check_run(system: gb.RotorSystem, speed: float, run: gb.Response) -> None:
    turn = slice(len(run.time) // 2, -1)
    balance = Balance(system, run, speed, turn)
    for body in balance.terms:
        # the decaying transient changes the momentum of a shaft by up to 1e-3 of its load in this turn
        assert balance.residual(body) < 3e-3, body
    static = system.static(speed=speed)
    for mesh in system.meshes:
        pair = (mesh.driver, mesh.driven)
        mean = run.mesh(*pair).force[turn].mean()
        # equal torques, and radii that the bow does not change: 1e-4 is reached
        assert mean == pytest.approx(static.mesh(*pair).force, rel=1e-3)


@dataclass(frozen=True)
class Analysis:
    """How to compute a result, and the equations that it has to satisfy."""

    compute: Callable[[gb.RotorSystem, float], Any]
    check: Callable[[gb.RotorSystem, float, Any], None]
    senses: tuple[int, ...] = (1, -1)


ANALYSES = {
    "static": Analysis(lambda s, speed: s.static(speed=speed), check_static),
    "modes": Analysis(lambda s, speed: s.modes(speed, COUNT), check_modes),
    # the speeds of a diagram are not negative
    "campbell": Analysis(
        lambda s, speed: s.campbell(SHARES * speed, count=COUNT), check_campbell, (1,)
    ),
    "synchronous": Analysis(lambda s, speed: s.synchronous(SHARES * speed), check_synchronous),
    "run": Analysis(compute_run, check_run),
}

#: The part of a result that gives the residual of its equations.
RESIDUALS: dict[str, Callable[[Any], Any]] = {
    "static": lambda result: result.residual,
    "modes": lambda result: result.residuals,
    "synchronous": lambda result: result.residuals,
    "campbell": lambda result: [crossing.residual for crossing in result.intersections],
}


@dataclass(frozen=True)
class Drawing:
    """How to draw a figure of a result, its number of panels, and the names that it shows."""

    analysis: str | None
    draw: Callable[[Any, gb.RotorSystem], Any]
    panels: Callable[[gb.RotorSystem], int]
    names: Callable[[gb.RotorSystem], list[str]] = lambda _: []
    meshes: bool = False  # whether it needs a mesh


def of_run(
    kind: str, panels: Callable[[gb.RotorSystem], int], names: Any, *, meshes: bool = False
) -> Drawing:
    return Drawing(
        "run",
        lambda run, s: run.plot(kind, None if kind in OWN_ITEMS else places(s)),
        panels,
        names,
        meshes,
    )


OWN_ITEMS = ("mesh", "geometry", "bearings")


def pairs(system: gb.RotorSystem) -> list[str]:
    return [f"{mesh.driver} – {mesh.driven}" for mesh in system.meshes]


def bearings(system: gb.RotorSystem) -> list[str]:
    return [f"{bearing.shaft} at {bearing.position:g} m" for bearing in system.bearings]


FIGURES = {
    "train": Drawing(None, lambda _, s: s.plot(), lambda _: 2, places),
    "modes": Drawing(
        "modes",
        lambda r, _: r.plot(),
        lambda _: COUNT,
        lambda s: [shaft.name for shaft in s.shafts],
    ),
    "mode": Drawing(
        "modes",
        lambda r, _: r.plot(COUNT),
        lambda _: 1,
        lambda s: [shaft.name for shaft in s.shafts],
    ),
    "campbell": Drawing("campbell", lambda r, _: r.plot(), lambda _: 2),
    "synchronous": Drawing(
        "synchronous", lambda r, s: r.plot(places(s)), lambda s: len(places(s)), places
    ),
    "bode": Drawing("synchronous", lambda r, s: r.bode(places(s)), lambda _: 2, places),
    "orbits": of_run("orbits", lambda s: len(places(s)), places),
    "history": of_run("history", lambda s: len(places(s)), places),
    "twist": of_run("twist", lambda s: len(places(s)), places),
    "spectrum": of_run("spectrum", lambda s: len(places(s)), places),
    "mesh": of_run("mesh", lambda s: 3 * len(s.meshes), pairs, meshes=True),
    "geometry": of_run("geometry", lambda s: 4 * len(s.meshes), pairs, meshes=True),
    "bearings": of_run("bearings", lambda s: 2 * len(s.bearings), bearings),
}

CELLS = [(name, sense) for name, analysis in ANALYSES.items() for sense in analysis.senses]


@pytest.fixture(scope="module", params=MACHINES)
def machine(request) -> Machine:
    """Return one machine after the other, so that its tests share its results."""
    return Machine(request.param)


def obtain(machine: Machine, analysis: str, sense: int) -> Any:
    return machine.result(analysis, sense, ANALYSES[analysis].compute)


@pytest.mark.parametrize(("analysis", "sense"), CELLS)
def test_results_satisfy_their_equations(machine, analysis, sense):
    result = obtain(machine, analysis, sense)
    ANALYSES[analysis].check(machine.system, sense * machine.speed, result)


@pytest.mark.parametrize("analysis", RESIDUALS)
def test_results_know_their_residual(machine, analysis):
    given = np.asarray(RESIDUALS[analysis](obtain(machine, analysis, 1)))
    assert np.all((given >= 0.0) & (given < 1e-6))


@pytest.mark.parametrize("figure", FIGURES)
def test_figures_show_every_part(machine, figure):
    pytest.importorskip("matplotlib")
    drawing, system = FIGURES[figure], machine.system
    if drawing.meshes and not system.meshes:
        return
    result = None if drawing.analysis is None else obtain(machine, drawing.analysis, 1)
    drawn = drawing.draw(result, system)
    check_texts(drawn)
    assert len(drawn.axes) == drawing.panels(system)
    texts = [text.get_text() for legend in drawn.legends for text in legend.get_texts()]
    for panel in drawn.axes:
        assert panel.has_data()
        texts += [panel.get_title(place) for place in ("left", "center", "right")]
        texts += [panel.get_xlabel(), panel.get_ylabel()]
        texts += [text.get_text() for text in panel.texts]
    for name in drawing.names(system):
        assert any(name in text for text in texts), name
    assert any("[" in text for text in texts), "no unit"


@pytest.mark.parametrize("figure", ["campbell"])
def test_a_diagram_has_every_mode_and_line(machine, figure):
    campbell = obtain(machine, figure, 1)
    upper, lower = campbell.plot().axes
    values = np.concatenate(
        [line.get_ydata() for line in upper.get_lines() if len(line.get_ydata()) > 2]
    )
    for frequencies in campbell.frequencies_hz.T:
        # the curve goes through the computed points
        assert all(
            np.isclose(values, frequency, rtol=1e-9, atol=1e-9).any() for frequency in frequencies
        )
    assert lower.get_lines()
    assert len(campbell.lines) == len(machine.system.shafts) + len(machine.system.meshes)


def test_the_list_of_machines_is_true(machine):
    rows = [
        [cell.strip() for cell in line.split("|")[1:-1]]
        for line in (FOLDER / "README.md").read_text("utf-8").splitlines()
        if line.startswith("| [")
    ]
    assert len(rows) == len(MACHINES)
    (row,) = [row for row in rows if row[0] == f"[{machine.name}.toml]({machine.name}.toml)"]
    system = machine.system
    assert [int(row[1]), int(row[2])] == [len(system.dofs), len(system.shafts)]
    value, unit = row[4].split()
    speed = float(value) * (pi / 30.0 if unit == "rpm" else 1.0)
    assert speed == pytest.approx(machine.speed, rel=1e-12)


def test_a_diagram_draws_axial_modes():
    # the ninth elastic mode of the reducer moves along the axis
    machine = Machine("coaxial_reducer")
    campbell = machine.system.campbell([0.9 * machine.speed, machine.speed], count=9, harmonics=0)
    assert "axial" in campbell.whirl
    (legend,) = campbell.plot().legends
    assert "axial" in [text.get_text() for text in legend.get_texts()]
