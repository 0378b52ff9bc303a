"""The whole fleet: every analysis, figure, table, file and command on every machine of examples/machines.

The speed is the rated one, in both senses of rotation where this matters. The analyses and what their results have to satisfy are
those of `fleet_analyses`. A new figure is an entry of `FIGURES`, a new table one of `TABLES`, a new file one of `FILES`, a new
command one of `COMMANDS`, a new machine a file (see `fleet`). Cells of large machines with expensive analyses are slow.
"""

from __future__ import annotations

import json
import re
import warnings
from collections.abc import Callable
from dataclasses import dataclass, replace
from math import pi
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gearbow as gb
from fleet import FOLDER, MACHINES, OTHER_SENSE, SIZES, Machine, rows_of_list
from fleet_analyses import (
    ANALYSES,
    COUNT,
    SHARES,
    balanced_shaft,
    chosen,
    compute_balance,
    internally_damped,
    lateral,
    meshed,
    places,
    quantity,
    turn,
)
from gearbow.accuracy import LEVELS
from gearbow.cli.main import main
from reference.figure_texts import check_texts
from test_report import SECTION_NAMES, read_sections

pytestmark = pytest.mark.skipif(not FOLDER.is_dir(), reason="the examples are not installed")

#: The part of a result that gives the residual of its equations.
RESIDUALS: dict[str, Callable[[Any], Any]] = {
    "static": lambda result: [result.residual],
    "modes": lambda result: [result.residuals],
    "synchronous": lambda result: [result.residuals],
    "campbell": lambda result: [crossing.residual for crossing in result.intersections],
    "map": lambda result: result.residuals,
    "steady": lambda result: [result.residual],
}


@dataclass(frozen=True)
class Drawing:
    """How to draw a figure of a result, its number of panels, and the names that it shows.

    `largest` is the number of degrees of freedom above which the figure is slow: another one shows the same bodies and names.
    """

    analysis: str | None
    draw: Callable[[Any, gb.RotorSystem], Any]
    panels: Callable[[gb.RotorSystem], int]
    names: Callable[[gb.RotorSystem], list[str]] = lambda _: []
    needs: Callable[[gb.RotorSystem], bool] = lambda _: True
    units: bool = True  # the numbers of a sweep have none
    largest: int = 10_000


def of_run(
    kind: str,
    panels: Callable[[gb.RotorSystem], int],
    names: Any,
    needs: Any = lambda _: True,
    largest: int = 10_000,
) -> Drawing:
    return Drawing(
        "run",
        lambda run, s: run.plot(kind, None if kind in OWN_ITEMS else shown(s)),
        panels,
        names,
        needs,
        largest=largest,
    )


def shown(system: gb.RotorSystem) -> list[str]:
    """Bodies in the figures of machines with many."""
    bending = {name for name, _, kind in system.dofs if kind == "v"} or {
        s.name for s in system.shafts
    }
    return [at for at in places(system) if system.coordinates.shaft(at) in bending][:6]


def labels_of_bodies(system: gb.RotorSystem) -> list[str]:
    """Labels of these bodies in the drawing of the machine, where "stage 1–16" is one label."""
    from gearbow.plotting.labels import series

    bodies = [*system.gears, *system.disks]
    labels = {
        name: label
        for shaft in system.shafts
        for label, own in series([body.name for body in bodies if body.shaft == shaft.name])
        for name in own
    }
    return [labels[name] for name in shown(system)]


OWN_ITEMS = ("mesh", "geometry", "bearings")


def pairs(system: gb.RotorSystem) -> list[str]:
    return [f"{mesh.driver} – {mesh.driven}" for mesh in system.meshes]


def bearings(system: gb.RotorSystem) -> list[str]:
    return [f"{bearing.shaft} at {bearing.position:g} m" for bearing in system.bearings]


def load_data_set(path: Path) -> Any:
    xarray = pytest.importorskip("xarray")
    with xarray.open_dataset(path) as data:
        return data.load()


def load_table(path: Path) -> Any:
    return pytest.importorskip("pandas").read_csv(path)


def of_data_set(found: Any) -> Any:
    table = found.to_dataframe() if isinstance(found, gb.Sweep) else found
    return np.asarray(table["motion"])


def check_checked(answer: dict[str, Any], _: Any, machine: Machine, __: Path) -> None:
    system = machine.system
    assert answer["warnings"] == []
    assert answer["degrees_of_freedom"] == len(system.dofs)


def check_drawn(_: dict[str, Any], __: Any, ___: Machine, folder: Path) -> None:
    assert (folder / "train.png").stat().st_size > 1000


def check_printed_modes(
    answer: dict[str, Any], modes: gb.results.Modes, _: Machine, __: Path
) -> None:
    frequencies = [mode["frequency_hz"] for mode in answer["modes"]]
    np.testing.assert_allclose(frequencies, modes.frequencies_hz, rtol=1e-9, atol=1e-9)
    assert [mode["whirl"] for mode in answer["modes"]] == list(modes.whirl)


def check_printed_campbell(
    answer: dict[str, Any], campbell: gb.results.Campbell, _: Machine, folder: Path
) -> None:
    # the speeds of the command differ by round-off
    np.testing.assert_allclose(
        answer["frequencies_hz"], campbell.frequencies_hz, rtol=1e-9, atol=1e-9
    )
    assert len(answer["intersections"]) == len(campbell.intersections)
    assert (folder / "campbell.png").stat().st_size > 1000


def check_printed_run(
    answer: dict[str, Any], run: gb.Response, machine: Machine, folder: Path
) -> None:
    saved = gb.Response.load(folder / "run.npz")
    assert answer["complete"]
    check_signals(answer, saved, machine.system)
    # the motion of a run does not depend on what it records, except for the error of its accuracy
    name = places(machine.system)[0]
    for one, other in (
        (saved.displacement(name)[0], run.displacement(name)[0]),
        (saved.twist(name)[0], run.twist(name)[0]),
    ):
        np.testing.assert_allclose(one, other, rtol=1e-2, atol=1e-12)


def check_signals(answer: dict[str, Any], saved: gb.Response, system: gb.RotorSystem) -> None:
    for name in places(system):
        extent = np.ptp(saved.displacement(name), axis=0)
        np.testing.assert_allclose(answer["points"][name]["peak_to_peak"], extent)
    for mesh in answer["meshes"]:
        force = saved.mesh(mesh).force
        assert answer["meshes"][mesh]["force"]["max"] == force.max()


def check_printed_steady(
    answer: dict[str, Any], steady: gb.SteadyState, machine: Machine, folder: Path
) -> None:
    saved = gb.SteadyState.load(folder / "steady.npz")
    if steady.method == "quasi-periodic":
        assert answer["period"] is None
    else:
        assert answer["period"] == pytest.approx(steady.period, rel=1e-12)
    assert answer["stable"] is steady.is_stable()
    check_signals(answer | {"meshes": {}}, saved.response, machine.system)


def any_pads(system: gb.RotorSystem) -> bool:
    return any(isinstance(each, gb.TiltingPadBearing) for each in system.bearings)


def tradeoff_signal(system: gb.RotorSystem) -> str:
    if not system.meshes:
        return places(system)[0]
    return f"{system.meshes[0].driver}/{system.meshes[0].driven}"


def check_printed_tradeoff(answer: dict[str, Any], _: Any, __: Machine, ___: Path) -> None:
    assert any(trial["front"] for trial in answer["trials"])


#: Largest system for what does not depend on the size of a machine.
_SMALL = 301

FIGURES = {
    "train": Drawing(None, lambda _, s: s.plot(), lambda _: 2, labels_of_bodies),
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
        "synchronous", lambda r, s: r.plot(shown(s)), lambda s: len(shown(s)), shown
    ),
    "bode": Drawing("synchronous", lambda r, s: r.bode(shown(s)), lambda _: 2, shown),
    "orbits": of_run("orbits", lambda s: len(shown(s)), shown, lateral),
    "history": of_run("history", lambda s: len(shown(s)), shown, lateral),
    "twist": of_run("twist", lambda s: len(shown(s)), shown, largest=_SMALL),
    "spectrum": of_run("spectrum", lambda s: len(shown(s)), shown, lateral, largest=_SMALL),
    "mesh": of_run("mesh", lambda s: 3 * len(s.meshes), pairs, meshed),
    "geometry": of_run("geometry", lambda s: 4 * len(s.meshes), pairs, meshed),
    "bearings": of_run(
        "bearings", lambda s: 2 * len(s.bearings), bearings, lambda s: bool(s.bearings)
    ),
    "map": Drawing("map", lambda r, _: r.plot(), lambda _: 1),
    "energy": Drawing("run up", lambda r, _: r.energy_balance().plot(), lambda _: 3),
    "steady": Drawing(
        "steady",
        lambda r, s: r.plot("history", places(s)[:1]),
        lambda _: 1,
        lambda s: places(s)[:1],
        lateral,
    ),
    "branch": Drawing(
        "branch",
        lambda r, s: r.plot(places(s)[0], quantity(s)),
        lambda _: 1,
        lambda s: places(s)[:1],
    ),
    "sweep": Drawing(
        "sweep", lambda r, _: r.plot("motion"), lambda _: 1, lambda _: ["motion"], units=False
    ),
    "orders": Drawing("orders", lambda r, _: r[1].plot(), lambda _: 1, lambda s: places(s)[:1]),
    "spectrum of a signal": Drawing(
        "orders",
        lambda r, s: r[0].spectrum(places(s)[0], quantity(s)).plot(),
        lambda _: 1,
        lambda s: places(s)[:1],
    ),
    "waterfall": Drawing(
        "waterfall", lambda r, _: r[1].plot(), lambda _: 2, lambda s: places(s)[:1]
    ),
}


@dataclass(frozen=True)
class Table:
    """How to make a table of a result, and its number of rows."""

    analysis: str
    make: Callable[[Any], Any]
    rows: Callable[[Any], int]


TABLES = {
    "modes": Table("modes", lambda r: r.to_dataframe(), lambda _: COUNT),
    "campbell": Table("campbell", lambda r: r.to_dataframe(), lambda r: len(r.intersections)),
    "run": Table("run", lambda r: r.to_dataframe(), lambda r: len(r.time)),
    "energy": Table("run up", lambda r: r.energy_balance().to_dataframe(), lambda r: len(r.time)),
    "branch": Table("branch", lambda r: r.to_dataframe(), lambda r: len(r.values)),
    "sweep": Table("sweep", lambda r: r.to_dataframe(), len),
}

#: Text tables: analysis, the text, and the names that it contains.
TEXTS = {
    "modes": lambda r: (r.table(), r.whirl),
    "campbell": lambda r: (
        r.table(),
        [f"{r.intersections[0].frequency_hz:.3f}"] if r.intersections else [],
    ),
    "orders": lambda r: (
        r[1].table(1),
        [
            max(zip(np.abs(r[1].amplitudes), r[1].orders, strict=True), key=lambda p: p[0])[
                1
            ].names[0]
        ],
    ),
}


@dataclass(frozen=True)
class File:
    """How to write a file of a result, how to read it, and what it keeps."""

    analysis: str | None
    name: str
    write: Callable[[Any, Path], Any]
    read: Callable[[Path], Any]
    keeps: Callable[[Any], Any]


def signals(run: Any) -> dict[str, Any]:
    """Give the signals of a response, a steady state or the data set of a file."""
    run = getattr(run, "response", run)
    data = run.to_xarray() if isinstance(run, gb.Response) else run
    return {name: array.values for name, array in data.data_vars.items()}


def branch(found: Any) -> dict[str, Any]:
    """Give the points of a branch or of the data set of its file."""
    if not isinstance(found, gb.Continuation):
        about = json.loads(found.attrs["metadata"])["branch"]
        # a motion whose multipliers are all small has none
        largest = np.array(
            [max((abs(complex(*z)) for z in point), default=0.0) for point in about["multipliers"]]
        )
        return {"values": about["values"], "stable": largest < 1.0}
    return {"values": found.values, "stable": found.stable}


FILES = {
    "scene.toml": File(
        None, "scene.toml", lambda s, p: s.save(p), gb.RotorSystem.load, lambda s: s.description
    ),
    "scene.json": File(
        None,
        "scene.json",
        lambda s, p: p.write_text(json.dumps(s.description), "utf-8"),
        lambda p: gb.RotorSystem.from_dict(json.loads(p.read_text("utf-8"))),
        lambda s: json.loads(json.dumps(s.description)),
    ),
    "run.npz": File("run", "run.npz", lambda r, p: r.save(p), gb.Response.load, signals),
    "run.nc": File("run", "run.nc", lambda r, p: r.save(p), load_data_set, signals),
    "steady.npz": File(
        "steady",
        "steady.npz",
        lambda r, p: r.save(p),
        gb.SteadyState.load,
        lambda r: {**signals(r), "period": r.period, "residual": r.residual},
    ),
    "steady.nc": File("steady", "steady.nc", lambda r, p: r.save(p), load_data_set, signals),
    "branch.npz": File(
        "branch", "branch.npz", lambda r, p: r.save(p), gb.Continuation.load, branch
    ),
    "branch.nc": File("branch", "branch.nc", lambda r, p: r.save(p), load_data_set, branch),
    "sweep.sweep": File(
        "sweep",
        "s.sweep",
        lambda r, p: r.save(p),
        gb.Sweep.load,
        lambda r: {"motion": of_data_set(r)},
    ),
    "sweep.nc": File(
        "sweep", "s.nc", lambda r, p: r.save(p), load_data_set, lambda r: {"motion": of_data_set(r)}
    ),
    "sweep.csv": File(
        "sweep", "s.csv", lambda r, p: r.save(p), load_table, lambda r: {"motion": of_data_set(r)}
    ),
}


@dataclass(frozen=True)
class Command:
    """Arguments of a command, and what its answer in JSON has to be beside the result of its analysis.

    A command repeats its analysis; `largest` is the number of degrees of freedom above which it is slow.
    """

    analysis: str | None
    arguments: Callable[[Machine, Path], list[Any]]
    check: Callable[[dict[str, Any], Any, Machine, Path], None]
    largest: int = _SMALL


COMMANDS = {
    "check": Command(None, lambda _m, _p: [], check_checked, largest=10_000),
    "plot": Command(None, lambda _, p: ["--out", p / "train.png"], check_drawn),
    "modes": Command(
        "modes",
        lambda m, _: [
            *("--speed", m.speed, "--count", COUNT),
            *(["--vibrating"] if internally_damped(m.system) else []),
        ],
        check_printed_modes,
    ),
    "campbell": Command(
        "campbell",
        lambda m, p: [
            *("--from", SHARES[0] * m.speed, "--to", SHARES[-1] * m.speed, "--points", len(SHARES)),
            *("--count", COUNT, "--out", p / "campbell.png"),
        ],
        check_printed_campbell,
    ),
    "run": Command(
        "run",
        lambda m, p: [
            *("--duration", 0.1 * turn(m.system, m.speed), "--speed", m.speed),
            *("--record", "gears", "disks", "meshes", "--out", p / "run.npz"),
        ],
        check_printed_run,
    ),
    "steady": Command(
        "steady",
        lambda m, p: ["--speed", m.speed, "--record", "gears", "disks", "--out", p / "steady.npz"],
        check_printed_steady,
        largest=150,
    ),
    "tradeoff": Command(
        "branch",
        lambda m, _: [
            *("--duration", 0.1 * turn(m.system, m.speed), "--speed", m.speed),
            # pads of little inertia are stiff: the check of the reference by a Runge–Kutta method takes 30 s
            *("--budget", 40 if any_pads(m.system) else 2),
            *("--signals", tradeoff_signal(m.system)),
        ],
        check_printed_tradeoff,
    ),
}

#: Largest system whose report `make test` writes, and largest one that it gives loss factors.
_LARGEST_REPORT, _LARGEST_WITH_LOSS = 150, 350
#: Largest system of which `make test` makes a run.
_LARGEST_RUN = 1000

CELLS = [(name, sense) for name, analysis in ANALYSES.items() for sense in analysis.senses]


def is_slow(parameters: dict[str, Any]) -> bool:
    """Tell whether a case needs an analysis that is expensive for its machine."""
    machine, analysis = parameters.get("machine"), parameters.get("analysis")
    if parameters.get("command") == "tradeoff":
        return True
    if "report" in parameters:
        # test_report writes those of a train, in both senses of rotation
        is_train = machine == "geared_pair"
        return is_train or parameters["report"] < 0 or SIZES[machine] > _LARGEST_REPORT
    if "loss" in parameters:
        return SIZES[machine] > _LARGEST_WITH_LOSS
    if "recording" in parameters:
        return SIZES[machine] > _LARGEST_RUN
    if "animation" in parameters:
        return SIZES[machine] > _SMALL
    for table, kind in ((FIGURES, "figure"), (COMMANDS, "command")):
        if kind in parameters and SIZES[machine] > table[parameters[kind]].largest:
            return True
    for table, kind in (
        (FIGURES, "figure"),
        (TABLES, "table"),
        (FILES, "file"),
        (COMMANDS, "command"),
    ):
        if kind in parameters:
            analysis = table[parameters[kind]].analysis
    if None in (machine, analysis):
        return False
    given, sense = ANALYSES[analysis], "+" if parameters.get("sense", 1) > 0 else "-"
    return SIZES[machine] > given.largest or f"{machine} {sense}" in given.expensive


@pytest.fixture(scope="module", params=MACHINES)
def machine(request) -> Machine:
    """Return one machine after the other, so that its tests share its results."""
    return Machine(request.param)


def obtain(machine: Machine, analysis: str, sense: int = 1) -> Any:
    return machine.result(analysis, sense, ANALYSES[analysis].compute)


def applies(machine: Machine, analysis: str | None) -> bool:
    """Tell whether a machine has a result of an analysis."""
    if analysis is None:
        return True
    return ANALYSES[analysis].applies(machine.system) and machine.refusal(analysis, 1) is None


@pytest.mark.parametrize(("analysis", "sense"), CELLS)
def test_results_satisfy_their_equations(machine, analysis, sense):
    given, speed = ANALYSES[analysis], sense * machine.speed
    if not given.applies(machine.system):
        return
    refusal = machine.refusal(analysis, sense)
    if refusal is not None:
        with pytest.raises(refusal[0], match=refusal[1]):
            given.compute(machine.system, speed)
        return
    given.check(machine.system, speed, obtain(machine, analysis, sense))


@pytest.mark.parametrize("analysis", RESIDUALS)
def test_results_know_their_residual(machine, analysis):
    if not applies(machine, analysis):
        return
    given = np.concatenate(
        [np.ravel(part) for part in RESIDUALS[analysis](obtain(machine, analysis))]
    )
    limit = 1e-6
    if analysis == "steady":
        # The iteration ends when the error of the state is below the tolerance of the runs. Without a common period, a per cent of
        # the motion may be transient.
        is_periodic = obtain(machine, analysis).method != "quasi-periodic"
        limit = LEVELS[machine.system.accuracy].rtol if is_periodic else 1e-2
    assert np.all((given >= 0.0) & (given < limit))


@pytest.mark.parametrize("loss", [0.01])
def test_linear_analyses_have_loss_factors_and_runs_refuse_them(machine, loss):
    system, speed = machine.system, machine.speed
    bearings = [
        replace(each, loss_factor=loss) if isinstance(each, gb.Bearing) else each
        for each in system.bearings
    ]
    shafts = [replace(shaft, loss_factor=loss) for shaft in system.shafts]
    lossy = system.replace(shafts=shafts, bearings=bearings)
    before = obtain(machine, "modes").eigenvalues
    for value in lossy.modes(speed, count=COUNT, vibrating=internally_damped(system)).eigenvalues:
        # to first order, the loss of all elastic energy changes an eigenvalue by half the loss factor; round-off splits the double
        # eigenvalue of the rotation of a train
        assert np.abs(before - value).min() <= loss * abs(value) + 3e-2
    # the equilibrium does not depend on the loss factors, but for the round-off of another search
    state = obtain(machine, "static").state
    assert np.abs(lossy.static(speed=speed).state - state).max() <= 1e-12 * np.abs(state).max()
    if lateral(system):
        with warnings.catch_warnings():
            # a loss factor makes rotors unstable that are faster than a mode with little damping
            warnings.filterwarnings("ignore", "speeds: the motion is unstable", gb.AccuracyWarning)
            assert np.isfinite(lossy.synchronous(speed).amplitudes).all()
    for refused in (
        lambda: lossy.simulate(0.01, speed),
        lambda: lossy.simulate(0.01, gb.SpeedProfile.ramp(0.9 * speed, speed, 0.01)),
        lambda: lossy.steady_state(speed),
    ):
        with pytest.raises(gb.SceneError, match=r"shafts\[0\].loss_factor: has a meaning in the"):
            refused()


@pytest.mark.parametrize("damping", [1e-6])
def test_little_internal_damping_changes_little(machine, damping):
    system, speed = machine.system, machine.speed
    if not lateral(system):
        return
    last = machine.senses[-1] * speed
    without = system.replace(shafts=chosen(system))
    shafts = [
        replace(shaft, internal_damping=(shaft.internal_damping or 0.0) + damping)
        for shaft in without.shafts
    ]
    both = (without, system.replace(shafts=shafts))
    # Its forces are β(ω − Ω), 1e-3 at most, of the elastic ones: the compressor balances differently by 2.1e-3.
    close = {"rtol": 1e-2, "atol": 0.0}
    with warnings.catch_warnings():
        # it makes rotors unstable that are faster than a mode with little other damping
        warnings.filterwarnings("ignore", "speeds: the motion is unstable", gb.AccuracyWarning)
        first, other = (each.synchronous([speed, last]).amplitudes for each in both)
        scale = np.abs(first).max(axis=(1, 2), keepdims=True)
        np.testing.assert_allclose(other / scale, first / scale, rtol=0.0, atol=1e-2)
        limits, others = (each.bow_limits(each.shafts[0].name, last).found for each in both)
        assert [(one.limit, one.at) for one in others] == [(one.limit, one.at) for one in limits]
        np.testing.assert_allclose(
            [one.bow for one in others], [one.bow for one in limits], **close
        )
        if balanced_shaft(system) is not None:
            first, other = (np.abs(compute_balance(each, last).unbalances) for each in both)
            np.testing.assert_allclose(other, first, rtol=0.0, atol=1e-2 * first.max())


def test_rolling_bearings_carry_their_loads(machine):
    """A static safety above 2 against the static load rating of ISO 76."""
    static = machine.system.static(speed=machine.speed)
    for bearing in machine.system.bearings:
        if isinstance(bearing, gb.RollingBearing):
            at = (bearing.shaft, bearing.position)
            load = np.linalg.norm(static.bearing_force(at))
            if bearing.degrees_of_freedom == 5:
                thrust = abs(static.axial_bearing_force(at))
                angle = abs(size_of(bearing, "contact_angle"))
                load = max(load, 0.5 * load + 0.22 / np.tan(angle) * thrust)
            assert static_load_rating(bearing) > 2.0 * load, at


def size_of(bearing: gb.RollingBearing, name: str) -> Any:
    given = getattr(bearing, name)
    return getattr(bearing.estimate, name, None) if given is None else given


def static_load_rating(bearing: gb.RollingBearing) -> float:
    """Give the static load rating of ISO 76 from the sizes of the elements [N]."""
    names = ("elements", "element_diameter", "pitch_diameter", "contact_angle", "roller_length")
    count, diameter, pitch, angle, length = (size_of(bearing, name) for name in names)
    radial = np.cos(angle or 0.0)
    if length is not None:
        return 44e6 * (1.0 - diameter / pitch * radial) * count * length * diameter * radial
    # the factor f₀ of balls is 12.3 to 16.5
    return 12.3e6 * count * diameter**2 * radial


@pytest.mark.parametrize("figure", FIGURES)
def test_figures_show_every_part(machine, figure):
    pytest.importorskip("matplotlib")
    drawing, system = FIGURES[figure], machine.system
    if not (applies(machine, drawing.analysis) and drawing.needs(system)):
        return
    result = None if drawing.analysis is None else obtain(machine, drawing.analysis)
    drawn = drawing.draw(result, system)
    check_texts(drawn)
    assert len(drawn.axes) == drawing.panels(system)
    texts = [text.get_text() for legend in drawn.legends for text in legend.get_texts()]
    for panel in drawn.axes:
        # orbits of all shafts may be smaller than a figure shows
        assert panel.has_data() or panel.get_title(loc="right").startswith("below")
        texts += [panel.get_title(place) for place in ("left", "center", "right")]
        texts += [panel.get_xlabel(), panel.get_ylabel()]
        texts += [text.get_text() for text in panel.texts]
    for name in drawing.names(system):
        assert any(name in text for text in texts), name
    assert any("[" in text for text in texts) is drawing.units, "no unit"


@pytest.mark.parametrize("table", TABLES)
def test_tables_have_a_row_for_each_value(machine, table, tmp_path):
    pandas = pytest.importorskip("pandas")
    given = TABLES[table]
    if not applies(machine, given.analysis):
        return
    result = obtain(machine, given.analysis)
    made = given.make(result)
    assert len(made) >= given.rows(result)
    numbers = made.select_dtypes("number")
    assert numbers.shape[1] > 0
    # a table as CSV keeps the numbers: of a long run, those of 100 rows
    made = made.iloc[:: -(-len(made) // 100)]
    numbers = made.select_dtypes("number")
    made.to_csv(tmp_path / "table.csv")
    read = pandas.read_csv(tmp_path / "table.csv")
    for name in numbers:
        # older versions of pandas read numbers with an error of the last digit
        np.testing.assert_allclose(read[str(name)].to_numpy(), numbers[name].to_numpy(), rtol=1e-14)


@pytest.mark.parametrize("analysis", TEXTS)
def test_text_tables_name_their_rows(machine, analysis):
    if not applies(machine, analysis):
        return
    text, names = TEXTS[analysis](obtain(machine, analysis))
    assert len(text.splitlines()) >= 2 or not names
    for name in names:
        assert name in text


@pytest.mark.parametrize("file", FILES)
def test_files_keep_everything(machine, file, tmp_path):
    given = FILES[file]
    if not applies(machine, given.analysis):
        return
    result = machine.system if given.analysis is None else obtain(machine, given.analysis)
    given.write(result, tmp_path / given.name)
    expected, found = given.keeps(result), given.keeps(given.read(tmp_path / given.name))
    assert set(found) == set(expected)
    for name, values in expected.items():
        np.testing.assert_equal(found[name], values)


@pytest.mark.parametrize("recording", ["default"])
def test_a_run_records_something_by_default(machine, recording, capsys):  # noqa: ARG001
    system = machine.system
    run = system.simulate(1e-3, machine.speed, initial="rest")
    if system.gears:
        pairs = [(mesh.driver, mesh.driven) for mesh in system.meshes]
        assert run.recorded == [*(gear.name for gear in system.gears), *pairs]
        return
    disks = {disk.name for disk in system.disks}
    forces = {("bearing", each.shaft, each.position) for each in system.bearings}
    # Oil films add the motion of their journals.
    assert set(run.recorded) >= disks | forces
    given = ["run", str(machine.path), "--duration", "1 ms", "--speed", str(machine.speed)]
    with pytest.raises(SystemExit):
        main([*given, "--json"])
    answer = json.loads(capsys.readouterr().out)
    assert set(answer["points"]) >= disks
    assert len(answer["bearings"]) == len(forces)


@pytest.mark.parametrize("animation", ["run"])
def test_a_run_becomes_an_animation(machine, animation, tmp_path):
    pytest.importorskip("matplotlib")
    run = obtain(machine, animation)
    run.animate(tmp_path / "run.gif", duration=0.1, fps=10.0)
    assert (tmp_path / "run.gif").read_bytes().startswith(b"GIF8")


@pytest.mark.parametrize("command", COMMANDS)
def test_commands_answer_as_the_package(machine, command, tmp_path, capsys):
    given = COMMANDS[command]
    if not applies(machine, given.analysis):
        return
    arguments = [command, machine.path, *given.arguments(machine, tmp_path), "--json"]
    with pytest.raises(SystemExit) as end:
        main([str(argument) for argument in arguments])
    out, err = capsys.readouterr()
    assert end.value.code == 0, err
    result = None if given.analysis is None else obtain(machine, given.analysis)
    given.check(json.loads(out), result, machine, tmp_path)


@pytest.mark.parametrize("report", [1, -1])
def test_a_report_has_every_section(machine, report, tmp_path):
    pytest.importorskip("plotly")
    path = tmp_path / "report.html"
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # they are in the report
        machine.system.report(path, operating=report * machine.speed)
    sections = read_sections(path)
    assert list(sections) == [*SECTION_NAMES]
    if report not in machine.senses:
        without = [name for name, text in sections.items() if "Not computed" in text]
        assert {"static", "modes", "response"} <= {*without}, without
        assert all(re.search(OTHER_SENSE[1], sections[name]) for name in without), sections
        return
    # a machine at its rated speed lacks no section
    for name, text in sections.items():
        assert "Not computed" not in text, name


@pytest.mark.parametrize("figure", ["campbell"])
def test_a_diagram_has_every_mode_and_line(machine, figure):
    campbell = obtain(machine, figure)
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
    rows = rows_of_list()
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
