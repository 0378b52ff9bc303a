"""Limits of the path of contact: tips and base circles, at rest and in motion."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import gearbow as gb
from reference.machines import short_pair
from reference.teeth import Toothed

MODELS: dict[str, Any] = {
    "iso6336": gb.Stiffness.iso6336(),
    "square": gb.Stiffness.square(pair=2e8, engagement="sharp"),
    "smooth square": gb.Stiffness.square(pair=2e8, engagement=0.4),
    "parabolic": gb.Stiffness.parabolic(pair=2e8, end_ratio=0.1),
    "potential_energy": gb.Stiffness.potential_energy((0.009, 0.03)),
    "table": gb.Stiffness.table([3e8, 1e8, 5e7, 2e8]),
    "fourier": gb.Stiffness.fourier(3e8, [2.9e8, 1e7]),
}


def pair(
    teeth: tuple[int, int] = (25, 50),
    *,
    bow: gb.Bow | None = None,
    gear: dict[str, Any] | None = None,
    **mesh: Any,
) -> gb.RotorSystem:
    """Return two gears on stiff shafts with steel teeth of module 3 mm."""
    return short_pair(
        ("pinion", "wheel"),
        teeth,
        own={"b": {"bow": bow}},
        gear=gear or {},
        mesh={"damping_ratio": 0.1, **mesh},
        torque=50.0,
    )


def test_teeth_without_contact_are_an_error():
    message = (
        r"^meshes\[0\]\.centre_distance: the teeth of \"pinion\" and \"wheel\" cannot touch: their "
        r"tips reach each other on the line of action up to a centre distance of 0\.118430 m, got "
        r"0\.12 m"
    )
    with pytest.raises(gb.SceneError, match=message):
        pair(centre_distance=0.12)
    with pytest.raises(gb.SceneError, match="cannot touch"):
        pair(centre_distance=0.5, stiffness=3e8)


@pytest.mark.parametrize("model", MODELS)
def test_a_contact_ratio_below_one_warns(model: str):
    message = (
        r"^meshes\[0\]: the contact ratio is 0\.916, below 1: no teeth are in contact for 8 % of "
        r"the mesh cycle; probable cause: centre_distance is 0\.115 m, 0\.112500 m is without play"
    )
    with pytest.warns(gb.SceneWarning, match=message):
        system = pair(centre_distance=0.115, stiffness=MODELS[model])
    assert system.modes(count=2).frequencies_hz[1] > 10.0
    found = system.simulate(0.02, 60.0, output_step=1e-5).mesh(("pinion", "wheel"))
    assert found.stiffness.min() >= 0.0
    assert set(found.pairs_in_contact) == {0, 1}


def test_an_event_has_the_time_at_which_the_contact_ratio_is_one():
    system = pair(
        bow=gb.Bow.half_sine(4e-4), centre_distance=0.1145, stiffness=gb.Stiffness.parabolic(2e8)
    )
    run = system.simulate(0.4, 60.0, output_step=1e-5)
    margin = run.mesh(("pinion", "wheel")).contact_ratio - 1.0
    (at,) = np.nonzero(margin[:-1] * margin[1:] < 0.0)
    crossings = run.time[at] + 1e-5 * margin[at] / (margin[at] - margin[at + 1])
    # The run begins below 1: its first event is at the time 0.
    events = [
        each.time
        for each in run.events
        if each.time > 0.0 and each.kind.startswith("contact ratio")
    ]
    # The bow of the wheel turns twice: four crossings. The ratio is nearly linear within a step.
    np.testing.assert_allclose(events, crossings, rtol=0.0, atol=1e-6)
    assert len(events) == 4


def test_short_tips_are_named_as_the_cause():
    with pytest.warns(gb.SceneWarning, match=r"probable cause: the tip radii are 0\.038000 m and"):
        gb.RotorSystem(
            shafts=[gb.Shaft(name, length=0.2, outer_diameter=0.03, elements=2) for name in "ab"],
            gears=[
                gb.Gear(name, on, 0.1, teeth=z, module=3e-3, face_width=0.03, tip_radius=tip)
                for name, on, z, tip in (("p", "a", 25, 0.038), ("w", "b", 50, 0.0755))
            ],
            meshes=[gb.Mesh("p", "w")],
            bearings=[gb.Bearing(name, x, stiffness=1e8) for name in "ab" for x in (0.0, 0.2)],
        )


@pytest.mark.parametrize(
    ("teeth", "ratio", "beyond"), [((12, 60), 1.405, "1.747"), ((14, 80), 1.542, "0.902")]
)
def test_there_is_no_contact_beyond_a_base_circle(
    teeth: tuple[int, int], ratio: float, beyond: str
):
    with pytest.warns(gb.SceneWarning) as caught:
        system = pair(teeth)
    texts = [str(warning.message) for warning in caught]
    assert len(texts) == 2
    start = f'meshes[0]: involute interference: the tips of "wheel" reach {beyond} mm beyond the '
    assert texts[0].startswith(start)
    assert texts[1].startswith(f"gears[0]: {teeth[0]} teeth with a profile_shift of 0 are undercut")
    mesh = system.static().mesh(("pinion", "wheel"))
    law = Toothed(teeth=teeth).law()
    assert law.contact_ratio(law.centre_distance) == pytest.approx(ratio, abs=5e-4)
    # the load increases the centre distance by micrometres
    expected = law.contact_ratio(float(mesh.centre_distance))
    assert float(mesh.contact_ratio) == pytest.approx(expected, rel=1e-12)
    # tips and base circle of the pinion limit the path: the whole involute of the pinion
    reach = np.sqrt(law.tip_radius_a**2 - law.base_radius_a**2)
    assert expected == pytest.approx(reach / law.base_pitch, rel=1e-12)


def test_the_stiffness_of_iso_6336_uses_the_limited_path():
    with pytest.warns(gb.SceneWarning):
        found = pair((12, 60)).static().mesh(("pinion", "wheel")).stiffness
    single = 0.8 / (0.04723 + 0.15551 / 12 + 0.25791 / 60) * 1e9 * 0.03
    law = Toothed(teeth=(12, 60)).law()
    ratio = law.contact_ratio(law.centre_distance)
    assert float(found) == pytest.approx(single * (0.75 * ratio + 0.25), rel=1e-12)


@pytest.mark.parametrize("model", ["square", "smooth square", "parabolic", "potential_energy"])
def test_tooth_pairs_use_the_limited_path(model: str):
    with pytest.warns(gb.SceneWarning):
        system = pair((12, 60), stiffness=MODELS[model])
    period = 2 * np.pi / 12 / 50.0
    times = (np.arange(2000) + 0.5) * period / 500 + 0.01
    mesh = system.simulate(times[-1], 50.0, times=times).mesh(("pinion", "wheel"))
    # one sample in 500 at each of two edges
    assert mesh.pairs_in_contact.mean() == pytest.approx(1.4053, abs=4e-3)
    assert mesh.contact_ratio == pytest.approx(1.4053, abs=1e-4)


def test_a_standard_number_of_teeth_does_not_warn():
    pair((17, 17))  # a warning would be an error in these tests
    with pytest.warns(gb.SceneWarning, match=r"16 teeth .* undercut \(fewer than 17\)"):
        pair((16, 16))
    pair((16, 16), gear={"profile_shift": 0.07}, centre_distance=0.0484)


def test_events_of_a_path_of_contact_that_becomes_shorter():
    # a rotating bow of 1.5 mm varies the centre distance: tips pass a base circle during a
    # revolution
    system = pair((20, 40), bow=gb.Bow.half_sine(1.5e-3), stiffness=gb.Stiffness.square(pair=2e8))
    speed = 20.0
    turn = 2 * np.pi / (speed / 2)
    run = system.simulate(
        1.5 * turn, speed, output_step=turn / 4000, initial="synchronous", record=["meshes"]
    )
    mesh, law = run.mesh(("pinion", "wheel")), Toothed(teeth=(20, 40)).law()
    ratio = np.array([law.contact_ratio(distance) for distance in mesh.centre_distance])
    # same formula: round-off
    assert mesh.contact_ratio == pytest.approx(ratio, rel=1e-11)
    tangent = np.sqrt(mesh.centre_distance**2 - law.sum_of_radii**2)
    margin = tangent - np.sqrt(law.tip_radius_b**2 - law.base_radius_b**2)
    passed = np.flatnonzero(np.diff(np.sign(margin)))
    events = [event for event in run.events if event.kind.startswith("involute")]
    assert len(events) == len(passed) >= 3
    kinds = {1: "involute clearance", -1: "involute interference"}
    for event, index in zip(events, passed, strict=True):
        assert event.kind == kinds[int(np.sign(margin[index + 1]))]
        assert run.time[index] <= event.time <= run.time[index + 1]
    # without a limit, the derivative depends only on the tips
    free = np.flatnonzero(margin[:-1] > 0)
    free = free[margin[free + 1] > 0]
    slope = np.diff(mesh.contact_ratio)[free] / np.diff(tangent)[free]
    assert slope == pytest.approx(-1 / law.base_pitch, rel=1e-6)


def test_iso_6336_outside_its_range_is_an_error():
    # three teeth with so much profile shift have a negative flexibility q' in the formula of the
    # standard
    with pytest.raises(gb.SceneError, match=r"^meshes\[0\]\.stiffness: ISO 6336-1 gives -"):
        pair((3, 3), gear={"profile_shift": 2.0, "tip_radius": 0.012}, centre_distance=0.0135)
