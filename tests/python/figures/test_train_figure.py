"""The figure of a train: scale, positions, symbols, arrows, bows, and labels without overlap."""

from __future__ import annotations

import runpy
from dataclasses import replace
from functools import cache, partial
from math import pi
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.patches import Circle, FancyArrowPatch, Rectangle
from matplotlib.transforms import Bbox

import gearbow as gb
from gearbow.description.train import Train
from gearbow.plotting import symbols
from gearbow.plotting.labels import Labels
from gearbow.plotting.symbols import developed
from gearbow.plotting.train import line_of_action
from reference.equations import base_radius
from reference.figure_texts import area, box_of, check_texts
from reference.machines import (
    SHAFTS,
    at_ends,
    chain,
    hostile,
    reverted_train,
    rotor_on_pedestal,
    star,
    train,
)


def gear(name: str, shaft: str, position: float, teeth: int) -> gb.Gear:
    return gb.Gear(name, shaft, position, teeth, module=3e-3, face_width=0.03)


def pair(angle: float = 0.0, **parts) -> gb.RotorSystem:
    return train(
        SHAFTS,
        [("g1", "input", 0.2, 25), ("g2", "output", 0.3, 50)],
        [("g1", "g2")],
        mesh={"stiffness": 2e8, "centre_line_angle": angle},
        bearing={"stiffness": 1e8},
        **{"torque": 0.0, **parts},
    )


@cache
def gearbox() -> gb.RotorSystem:
    """Return the gearbox of docs/gearbox.md."""
    example = Path(__file__).parents[3] / "examples" / "gearbox.py"
    if not example.is_file():
        pytest.skip("the examples are not installed")
    return runpy.run_path(str(example), run_name="gearbox")["gearbox"]()


TRAINS = {
    "gearbox": gearbox,
    "rotor": rotor_on_pedestal,
    "pair": pair,
    "reverted": reverted_train,
    "star": star,
    "chain": chain,
    "hostile": hostile,
}


@cache
def drawn(name: str):
    """Return the figure of a train."""
    return TRAINS[name]().plot()


def texts(panel) -> list[str]:
    return [text.get_text() for text in panel.texts]


def boxes(panel, kind) -> list[np.ndarray]:
    """Return the boxes of the patches of a kind: left, bottom, right, top [m]."""
    found = [patch for patch in panel.patches if type(patch) is kind]
    return [patch.get_path().get_extents(patch.get_patch_transform()).extents for patch in found]


@pytest.mark.parametrize("name", list(TRAINS))
def test_labels_do_not_overlap_and_lie_within_the_panels(name, tmp_path: Path):
    figure = drawn(name)
    check_texts(figure)
    for panel in figure.axes:
        for text in panel.texts:
            box = box_of(text)
            assert area(Bbox.intersection(box, panel.bbox)) > 0.98 * area(box), text.get_text()
    figure.savefig(tmp_path / "figure.png", dpi=60)
    assert (tmp_path / "figure.png").stat().st_size < 200_000


@pytest.mark.parametrize("name", list(TRAINS))
def test_every_name_is_in_both_views(name):
    system = TRAINS[name]()
    side, end = drawn(name).axes
    named = texts(side)
    for part in (*system.shafts, *system.gears, *system.disks):
        assert part.name in named
    for part in system.gears:
        assert f"{part.name}, z = {part.teeth}" in texts(end)
    for part in system.disks:
        assert part.name in texts(end)
    for panel in (side, end):
        assert panel.get_aspect() == 1.0


def test_shafts_and_gears_have_their_positions():
    side, end = pair().plot().axes
    distance = 3e-3 * 75 / 2
    found = boxes(side, Rectangle)
    for expected in (
        (0.0, -0.025, 0.5, 0.025),
        (0.2 - 0.015, -0.0375, 0.2 + 0.015, 0.0375),
        # gears in mesh are in one plane: the output shaft begins at 0.2 m - 0.3 m
        (-0.1, distance - 0.025, 0.4, distance + 0.025),
        (0.2 - 0.015, distance - 0.075, 0.2 + 0.015, distance + 0.075),
    ):
        assert any(np.allclose(box, expected, atol=1e-12) for box in found), expected
    rims = {(circle.center, circle.radius) for circle in end.patches if isinstance(circle, Circle)}
    for centre, radius in (((0.0, 0.0), 0.0375), ((distance, 0.0), 0.075)):
        assert any(np.allclose([*c, r], [*centre, radius]) for c, r in rims)
    assert (side.get_xlabel(), side.get_ylabel()) == ("x [m]", "y [m]")
    assert (end.get_xlabel(), end.get_ylabel()) == ("y [m]", "z [m]")


def test_the_hidden_edges_of_a_bore_are_dashed():
    segments = [gb.Segment(0.3, 0.06), gb.Segment(0.5, 0.08, inner_diameter=0.03)]
    shaft = gb.Shaft("s", segments=segments)
    held = gb.Bearing("s", 0.1, stiffness=1e8, tilting_stiffness=1e6)
    side = gb.RotorSystem([shaft], bearings=[held]).plot().axes[0]
    dashed = [line.get_xydata() for line in side.get_lines() if line.get_linestyle() == "--"]
    expected = [[[0.3, 0.015], [0.8, 0.015]], [[0.3, -0.015], [0.8, -0.015]]]
    np.testing.assert_allclose(dashed, expected)


def test_a_train_is_developed_into_one_plane():
    distance = 3e-3 * 75 / 2
    for system, true in ((pair(), True), (pair(angle=2.0), False), (reverted_train(), True)):
        train = Train.of(system.description, system.speed_ratios)
        assert developed(train).true is true
        label = system.plot().axes[0].get_ylabel()
        assert label == ("y [m]" if true else "along the lines of centres [m]")
    train = Train.of(pair(angle=2.0).description, np.array([1.0, -0.5]))
    # cos 2 is negative: the driven shaft is below the driver
    assert developed(train).heights["output"] == pytest.approx(-distance)
    train = Train.of(star().description, star().speed_ratios)
    found = developed(train)
    assert len(found.moved) == 2
    heights = sorted(found.heights.values())
    # no shaft covers another one
    assert np.diff(heights).min() > 0.06


def test_arrows_have_the_sense_of_torques_and_rotations():
    torques = [gb.Torque("g1", 250.0), gb.Torque.balance("g2")]
    side, end = pair(torques=torques).plot().axes
    assert {"250 N m", "500 N m (balance)"} <= set(texts(side))
    arcs = [
        patch._path_original.vertices
        for patch in side.patches
        if isinstance(patch, FancyArrowPatch)
    ]
    # both are positive about x: y towards z, so that the front moves downwards
    assert len(arcs) == 2
    for arc in arcs:
        assert arc[0, 1] > arc[-1, 1]
    turned = [gb.Torque("g1", -250.0), gb.Torque.balance("g2")]
    side = pair(torques=turned).plot().axes[0]
    assert "−250 N m" in texts(side)
    for patch in side.patches:
        if isinstance(patch, FancyArrowPatch):
            assert patch._path_original.vertices[0, 1] < patch._path_original.vertices[-1, 1]
    # the input shaft turns from y to z, the output shaft in the other sense
    arcs = [
        patch._path_original.vertices for patch in end.patches if isinstance(patch, FancyArrowPatch)
    ]
    senses = {}
    for arc in arcs[1:]:  # the first is the force on the driven gear
        centre = 0.0 if arc[:, 0].max() < 0.03 else 3e-3 * 75 / 2
        angle = np.unwrap(np.arctan2(arc[:, 1], arc[:, 0] - centre))
        senses[centre] = np.sign(angle[-1] - angle[0])
    assert senses == {0.0: 1.0, 3e-3 * 75 / 2: -1.0}


def test_coaxial_shafts_of_opposite_senses_have_two_arrows():
    spools = gb.RotorSystem.load(gb.examples()["dual_rotor"].path)
    _, end = spools.plot().axes
    assert sum(isinstance(patch, FancyArrowPatch) for patch in end.patches) == 2
    layout = Train.of(spools.description, spools.speed_ratios).layout
    between = [each for each in spools.bearings if isinstance(each.support, tuple)]
    assert between
    for each in between:
        inner, x = each.support
        apart = layout.shaft(each.shaft).origin - layout.shaft(inner).origin
        assert apart == pytest.approx([x - each.position, 0.0, 0.0], abs=1e-12)


def test_lines_of_action_touch_the_base_circles_in_the_sense_of_the_driver():
    system = hostile()
    _, end = drawn("hostile").axes
    lines = [line.get_xydata() for line in end.get_lines() if line.get_linestyle() == "--"]
    layout = Train.of(system.description, system.speed_ratios).layout
    assert layout.shaft("output").origin == pytest.approx([0.36, 0.0, 0.0], abs=1e-12)
    ratios = dict(zip((s.name for s in system.shafts), system.speed_ratios, strict=True))
    gears = {gear.name: gear for gear in system.gears}
    for mesh, (tail, head) in zip(system.meshes, lines, strict=True):
        way = (head - tail) / np.hypot(*(head - tail))
        for name in (mesh.driver, mesh.driven):
            shaft = gears[name].shaft
            arm = tail - layout.shaft(shaft).origin[1:]
            # the moment of a unit force on the driven gear, in the sense in which it turns
            moment = np.sign(ratios[shaft]) * (arm[0] * way[1] - arm[1] * way[0])
            assert moment == pytest.approx(base_radius(gears[name]), rel=1e-9)


def test_a_sleeve_is_drawn_in_both_views():
    shaft = gb.Shaft("s", length=1.0, outer_diameter=0.1)
    system = gb.RotorSystem([shaft], sleeves=[gb.Sleeve("s", 0.2, 0.6, 0.16, 0.1)])
    side, end = system.plot().axes
    assert any(patch.get_hatch() for patch in side.patches)
    (sleeve,) = (patch for patch in end.patches if patch.get_hatch())
    assert sleeve.get_radius() == pytest.approx(0.08)
    assert end.get_ylim()[1] > 0.08


def test_torques_that_vary_have_no_value():
    series = gb.TimeSeries([0.0, 1.0], [0.0, 5.0])
    system = pair(torques=[gb.Torque("g1", series)], drives=[gb.Drive("g2", 1e5)])
    assert {"torque", "drive"} <= set(texts(system.plot().axes[0]))
    function = pair(torques=[gb.Torque("g1", np.sin)], drives=[gb.Drive("g2", 1e5)])
    assert "torque" in texts(function.plot().axes[0])
    mixed = [gb.Torque("g1", 5.0), gb.Torque.balance("g2")]
    assert "10 N m (balance)" in texts(pair(torques=mixed).plot().axes[0])


def test_forces_have_their_components():
    forces = [
        gb.Force("left", 30.0 - 500.0j),
        gb.Force("right", 20.0, order=2),
        gb.Force(("rotor", 0.1), axial=-70.0),
        gb.Force(("rotor", 1.0), np.cos),
    ]
    side = rotor_on_pedestal(forces=forces).plot().axes[0]
    assert {
        "30 N along y, −500 N along z",
        "20 N along y, order 2",
        "−70 N axial",
        "force",
    } <= set(texts(side))
    arrows = [p._path_original.vertices for p in side.patches if isinstance(p, FancyArrowPatch)]
    heads = {round(float(arrow[-1, 0]), 6): arrow[-1] - arrow[0] for arrow in arrows}
    # along −x; a force that varies points downwards; the others have the sense of the component along y
    assert heads[0.1][0] < 0.0 == heads[0.1][1]
    assert heads[1.0][1] < 0.0 == heads[1.0][0]
    assert heads[0.4][1] > 0.0 == heads[0.4][0]
    assert heads[0.8][1] > 0.0 == heads[0.8][0]


def test_a_housing_surrounds_its_own_shafts():
    system = pair()
    on_box = [
        replace(one, support="box") if one.shaft == "input" else one for one in system.bearings
    ]
    box = gb.Housing("box", mass=50.0, stiffness=1e8, inertia=(1.0, 1.0, 1.0))
    side = system.replace(bearings=on_box, housings=[box]).plot().axes[0]
    (area,) = (patch for patch in side.patches if patch.get_linestyle() == "--")
    # gear g1 has a radius of 37.5 mm, and the axis of the other shaft lies 112.5 mm away
    assert area.get_y() < -0.02
    assert 0.0375 < area.get_y() + area.get_height() < 0.09


def test_the_line_of_action_is_that_of_the_engine():
    # the gradient of the mesh deflection is the row of a mesh in the stiffness matrix
    for speed, sense in ((1.0, 1.0), (-1.0, -1.0)):
        system = pair(angle=0.3)
        matrices = system.matrices(speed)
        without = system.replace(meshes=[gb.Mesh("g1", "g2", stiffness=1e8, centre_line_angle=0.3)])
        mesh = matrices.stiffness - without.matrices(speed).stiffness
        own = system.dofs.index(("input", 0.2, "v"))
        row = mesh[own, own : own + 2] / np.hypot(*mesh[own, own : own + 2])
        way = line_of_action(np.radians(20.0), np.float64(0.3), sense)
        assert np.hypot(*way) == pytest.approx(1.0)
        # the sign of a row of n nᵀ is that of its first component
        assert row * np.sign(way[0]) == pytest.approx(way)


@pytest.mark.parametrize("phase", [0.0, 0.5, -2.0])
def test_the_bow_is_drawn_in_its_plane_with_its_factor(phase):
    bow = gb.Bow.half_sine(1e-4, phase)
    shaft = gb.Shaft("rotor", length=1.0, outer_diameter=0.05, bow=bow)
    system = gb.RotorSystem([shaft], bearings=at_ends([shaft], stiffness=1e8))
    side = system.plot(magnify=300.0).axes[0]
    assert side.get_title() == "side view, bow × 300"
    degrees = f"{np.degrees(phase):.0f}".replace("-", "−")
    assert f"bow 100 µm at {degrees}°" in texts(side)
    (curve,) = [line.get_xydata() for line in side.get_lines() if line.get_linewidth() == 2.2]
    # the deflection between the nodes follows the shape functions of the elements
    np.testing.assert_allclose(curve[:, 1], 0.03 * np.sin(pi * curve[:, 0]), atol=3e-5)


def test_all_shapes_of_a_bow_are_drawn():
    shapes = [
        gb.Bow.sag(1e-4, 1.0),
        gb.Bow.mode(2, 1e-4),
        gb.Bow.points([0.0, 0.5, 1.0], [0.0, 1e-4, 0.0]),
        gb.Bow.function(lambda x: 1e-4j * x),
    ]
    for bow in shapes:
        shaft = gb.Shaft("rotor", length=1.0, outer_diameter=0.05, bow=bow)
        side = gb.RotorSystem([shaft], bearings=at_ends([shaft], stiffness=1e8)).plot().axes[0]
        assert any("bow 100 µm at" in text for text in texts(side))
    straight = gb.Shaft("rotor", length=1.0, outer_diameter=0.05)
    assert gb.RotorSystem([straight], bearings=at_ends([straight], stiffness=1e8)).plot().axes[
        0
    ].get_title() == ("side view")


KINDS_OF_BEARINGS = ("bearing", "journal bearing", "ball bearing", "roller bearing")
SYMBOLS: dict[str, Any] = {
    "ground": symbols.ground,
    "support": symbols.support,
    "coupling": lambda panel, x, y, point: symbols.coupling(panel, x, y, 0.5, point),
    **{kind: partial(symbols.bearing, kind=kind) for kind in KINDS_OF_BEARINGS},
}


@pytest.mark.parametrize("name", SYMBOLS)
def test_the_box_of_a_symbol_encloses_it(name: str):
    panel = Figure().subplots()
    box = SYMBOLS[name](panel, x=3.0, y=2.0, point=0.1)
    drawn = panel.dataLim.extents
    assert np.all(np.array(box[:2]) <= drawn[:2] + 1e-12)
    assert np.all(np.array(box[2:]) >= drawn[2:] - 1e-12)
    # and hardly more, so that names stand close to it
    assert np.all(np.subtract(box[2:], box[:2]) <= 1.3 * (drawn[2:] - drawn[:2]))


def test_the_legend_lists_the_symbols():
    kinds = [text.get_text() for text in drawn("gearbox").legends[0].get_texts()]
    assert kinds == [
        "bearing",
        "ball bearing",
        "roller bearing",
        "journal bearing",
        "housing",
        "coupling",
    ]
    side = drawn("gearbox").axes[0]
    assert "housing" in texts(side)
    figure = rotor_on_pedestal().plot()
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["bearing", "support"]
    assert "pedestal" in texts(figure.axes[0])


@pytest.mark.parametrize("magnify", [0.0, -1.0, np.nan, np.inf])
def test_an_invalid_factor_is_an_error(magnify):
    with pytest.raises(gb.SceneError, match=r"^magnify: must be"):
        rotor_on_pedestal().plot(magnify=magnify)


def test_a_free_shaft_without_anything_is_drawn():
    figure = gb.RotorSystem([gb.Shaft("s", length=1.0, outer_diameter=0.1)]).plot()
    assert figure.legends == []
    assert texts(figure.axes[0]) == ["s"]


def test_a_long_train_has_its_side_view_above_the_end_view():
    shaft = gb.Shaft("rotor", length=2.0, outer_diameter=0.05)
    disk = gb.Disk("disk", "rotor", 1.0, mass=5.0, diametral_inertia=0.01, polar_inertia=0.02)
    for length, above in ((2.0, True), (0.2, False)):
        own = replace(shaft, length=length)
        disks = [replace(disk, position=length / 2.0)]
        system = gb.RotorSystem([own], bearings=at_ends([own], stiffness=1e8), disks=disks)
        side, end = (panel.get_position() for panel in system.plot().axes)
        assert bool(side.y0 > end.y1) is above
        assert bool(side.x1 < end.x0) is not above


def test_equal_torques_side_by_side_have_one_label():
    shaft = gb.Shaft("crankshaft", length=1.0, outer_diameter=0.1)
    places = [0.2, 0.4, 0.6]
    torques = [gb.Torque(("crankshaft", x), 3.0) for x in places]
    torques.append(gb.Torque(("crankshaft", 0.8), "balance"))
    system = gb.RotorSystem([shaft], bearings=at_ends([shaft], stiffness=1e8), torques=torques)
    found = texts(system.plot().axes[0])
    assert "3 × 3 N m" in found
    assert "3 N m" not in found
    assert "−9 N m (balance)" in found


def test_labels_keep_away_from_arrows_of_forces(monkeypatch):
    # A box without area, as that of a line, keeps no label away.
    avoided = []
    of_class = Labels.avoid

    def avoid(self, *boxes, strictly=False):
        avoided.extend(boxes if strictly else [])
        of_class(self, *boxes, strictly=strictly)

    monkeypatch.setattr(Labels, "avoid", avoid)
    rotor_on_pedestal(forces=[gb.Force("left", 30.0), gb.Force(("rotor", 0.1), axial=-7.0)]).plot()
    assert avoided
    assert all(right > left and top > bottom for left, bottom, right, top in avoided)
