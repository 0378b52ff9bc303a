"""Mode shapes in space: displaced circles, radii, titles, axes, orbits, and long elements."""

from __future__ import annotations

import numpy as np
import pytest

import gearbow as gb
from gearbow._convert import nodal
from gearbow.description.layout import layout, reference_radius
from gearbow.description.train import Train
from gearbow.plotting.shapes import _at_maximum, _lever, _ring, refined
from reference.machines import pair_on_housing, stepped_rotor


def test_a_circle_moves_like_a_cross_section():
    # at an angle of 90 degrees a point of the circle is at (y, z) = (0, r), at 0 degrees at (r, 0)
    x, r, quarter = 0.3, 0.1, np.pi / 2
    around = np.array([0.0, quarter])
    rest = [[x, r, 0.0], [x, 0.0, r]]
    assert _ring(x, r, np.zeros(6), around) == pytest.approx(np.array(rest))
    # a translation moves all points equally
    moved = _ring(x, r, np.array([0.01, 0.02, 0.0, 0.0, 0.0, 0.03]), around)
    assert moved == pytest.approx(np.add(rest, [0.03, 0.01, 0.02]))
    # plane sections: u = -y dv/dx - z dw/dx, with dv/dx = Γ and dw/dx = -B
    tilted = _ring(x, r, np.array([0.0, 0.0, 0.1, 0.2, 0.0, 0.0]), around)
    assert tilted == pytest.approx(np.array([[x - 0.1 * r, r, 0.0], [x + 0.2 * r, 0.0, r]]))
    # a positive twist turns y towards z
    twisted = _ring(x, r, np.array([0.0, 0.0, 0.0, 0.0, 0.3, 0.0]), np.array([0.0]))
    assert twisted == pytest.approx(np.array([[x, r * np.cos(0.3), r * np.sin(0.3)]]))


def test_radii():
    gear = gb.Gear("g", "s", 0.1, 25, module=3e-3, face_width=0.03)
    assert reference_radius(gear) == pytest.approx(0.0375)
    # I_p = m r² / 2 of a thin disk
    assert reference_radius(gb.Disk("d", "s", 0.1, 8.0, 0.02, 0.04)) == pytest.approx(0.1)
    system = stepped_rotor()
    (shaft,) = layout(system, [[0.0, 0.0, 0.0]]).shafts
    assert [shaft.outer_radius(x) for x in (0.1, 0.3, 0.31, 0.8)] == pytest.approx(
        [0.02, 0.02, 0.03, 0.03]
    )


def test_a_twist_moves_the_rim_of_the_body_at_its_place():
    system = Train.of(stepped_rotor().description, stepped_rotor().speed_ratios).layout
    (disk,) = system.bodies
    assert disk.radius > 0.03
    assert _lever(system, ("s", 0.3, "twist")) == disk.radius
    assert _lever(system, ("s", 0.8, "twist")) == pytest.approx(0.03)
    assert (_lever(system, ("s", 0.3, "v")), _lever(system, ("s", 0.3, "B"))) == (1.0, 0.0)


def test_a_housing_below_named_supports_is_a_base():
    supports = {"left": 0.0, "right": 1.0}
    system = gb.RotorSystem(
        [gb.Shaft("rotor", length=1.0, outer_diameter=0.05, elements=2)],
        bearings=[
            gb.Bearing("rotor", x, stiffness=1e8, support=name) for name, x in supports.items()
        ],
        supports=[gb.Support(name, mass=5.0, stiffness=1e8, support="frame") for name in supports],
        housings=[gb.Housing("frame", mass=50.0, stiffness=1e7)],
    )
    bases = system.modes(count=2).layout.bases
    assert {base.name: base.feet for base in bases} == {
        "left": (("rotor", 0.0),),
        "right": (("rotor", 1.0),),
        "frame": (("rotor", 0.0), ("rotor", 1.0)),
    }


def test_a_shape_is_drawn_at_its_largest_displacement():
    shape = np.array([1.0 + 1.0j, 3.0j, -1.0])
    turned = _at_maximum(shape, shape)
    assert turned[1] == pytest.approx(3.0)
    assert np.abs(turned) == pytest.approx(np.abs(shape))
    assert turned[0] == pytest.approx(1.0 - 1.0j)


@pytest.mark.parametrize(("number", "moving"), [(1, 1), (2, 2)])
def test_a_mode_is_drawn_in_its_plane(number: int, moving: int):
    # the first mode moves along y, the second along z
    modes = stepped_rotor().modes(count=2)
    figure = modes.plot(number)
    (axes,) = figure.axes
    assert [axes.get_xlabel(), axes.get_ylabel(), axes.get_zlabel()] == ["x [m]", "y [m]", "z [m]"]
    title = figure.get_suptitle()
    assert title.startswith(f"mode {number}: {modes.frequencies_hz[number - 1]:.4g} Hz, ")
    assert modes.damping_ratios[number - 1] > 1e-3
    assert f"damping {100 * modes.damping_ratios[number - 1]:.3g} %" in title
    lines = [np.array(line.get_data_3d()) for line in axes.get_lines()]
    # the orbit of the disk: it stays at x = 0.3 m and moves in one plane
    radius = np.sqrt(2 * 0.1 / 10.0)
    orbits = [
        line
        for line in lines
        if line.shape[1] > 2 and np.ptp(line[0]) < 1e-12 and np.abs(line[1:]).max() < 0.9 * radius
    ]
    (orbit,) = orbits
    assert orbit[0, 0] == pytest.approx(0.3)
    assert np.ptp(orbit[moving]) > 0.02
    assert np.ptp(orbit[3 - moving]) < 1e-3 * np.ptp(orbit[moving])
    # it begins at its largest displacement
    first = {1: [0.3, np.abs(orbit[1]).max(), 0.0], 2: [0.3, 0.0, np.abs(orbit[2]).max()]}[moving]
    assert orbit[:, 0] == pytest.approx(first, abs=1e-3)


def stepped(elements: int, degree: int, *, shear: bool, motion: str) -> gb.RotorSystem:
    """Return a hollow stepped shaft with a disk on bearings that are softer along y."""
    bore = {"inner_diameter": 0.05, "elements": elements}
    segments = [gb.Segment(0.3, 0.06, **bore), gb.Segment(0.3, 0.04, elements=elements)]
    return gb.RotorSystem(
        [gb.Shaft("s", segments=segments, shear=shear, degree=degree)],
        disks=[gb.Disk("disk", "s", 0.1, 5.0, 0.02, 0.04)],
        bearings=[gb.Bearing("s", x, stiffness=(1e7, 2e7), damping=1e3) for x in (0.0, 0.6)],
        motion=motion,
    )


@pytest.mark.parametrize("shear", [True, False])
@pytest.mark.parametrize("motion", ["coupled", "torsion"])
def test_a_long_element_is_drawn_as_many_short_ones(shear: bool, motion: str):
    long, short = (
        stepped(elements, degree, shear=shear, motion=motion).modes(speed=300.0, count=4)
        for elements, degree in ((1, 7), (24, 2))
    )
    shapes, dofs = refined(long.shapes, long.coordinates, long.layout)
    places = {(round(x, 9), direction): n for n, (_, x, direction) in enumerate(dofs)}
    at = {
        n: places[round(x, 9), direction]
        for n, (_, x, direction) in enumerate(nodal(short.dofs))
        if (round(x, 9), direction) in places
    }
    assert len(at) > 0.5 * len(places)
    ours, theirs = shapes[:, list(at.values())], short.shapes[:, list(at)]
    for mine, other, frequency in zip(ours, theirs, short.frequencies_hz, strict=True):
        if frequency > 0.0:
            largest = int(np.argmax(np.abs(other)))
            # The natural frequencies of the two models differ by up to 1e-6, their shapes by 3e-4.
            np.testing.assert_allclose(mine / mine[largest], other / other[largest], atol=5e-4)


def test_a_shaft_of_one_element_is_drawn_bent():
    bearings = [gb.Bearing("s", x, stiffness=1e9) for x in (0.0, 1.0)]
    shaft = gb.Shaft("s", length=1.0, outer_diameter=0.05)
    modes = gb.RotorSystem([shaft], bearings=bearings, motion="lateral").modes(count=1)
    for line in modes.plot(count=1).axes[0].get_lines():
        middle = line.get_ydata()[line.get_xdata() == 0.5]
        assert np.abs(line.get_ydata()).max() == pytest.approx(np.abs(middle).max())
    # the axis of the shaft in space: its surface leaves the plane through the bearings
    (axes,) = modes.plot(1).axes
    mark = np.array(axes.get_lines()[1].get_data_3d())
    assert np.ptp(mark[1:], axis=1).max() > 0.05


def test_bases_reach_the_shafts_at_their_bearings():
    # from the centre of a housing or support at rest to the lower side of each shaft
    lines = pair_on_housing().modes(count=2).plot(1).axes[0].lines
    ends = {
        tuple(np.round([values[-1] for values in line.get_data_3d()], 9))
        for line in lines
        if line.get_color() == "0.6"
    }
    low = ((0.0, -0.025), (0.1125, -0.03))
    assert {(x, *place) for place in low for x in (0.0, 0.4)} <= ends
