"""Published rotors: `reference.published` lists all parameters and printed frequencies."""

from __future__ import annotations

import numpy as np
import pytest

import gearbow as gb
from reference import published, scenes

RPM = 2 * np.pi / 60


def test_geared_pair_of_rao_shiau_and_chang():
    system = scenes.v1()
    modes = system.modes(speed=published.V1_SPEED)
    oscillating = modes.frequencies_hz[modes.frequencies_hz > 1.0]
    # two independent programs agree to 0.004 %; rounding of the printed digits adds as much
    assert oscillating[:13] == pytest.approx(published.V1_HZ, rel=1e-4)
    assert list(modes.whirl).count("rigid") == 1


def test_speed_ratio_follows_the_teeth_if_radii_are_rounded():
    system = scenes.v1()
    assert system.speed_ratios == pytest.approx([1.0, -328 / 23], rel=1e-15)
    # the printed radii give a ratio that differs by 2e-4
    assert 0.5086 / 0.03567 == pytest.approx(328 / 23, rel=3e-4)


def test_geared_pair_warns_of_its_rounded_radii():
    def pair(base_radius: float) -> gb.RotorSystem:
        def shaft(name: str) -> gb.Shaft:
            return gb.Shaft(name, length=0.5, outer_diameter=0.05, elements=2)

        def gear(name: str, on: str, teeth: int, radius: float) -> gb.Gear:
            return gb.Gear(
                name, shaft=on, position=0.25, teeth=teeth, base_radius=radius, face_width=0.03
            )

        return gb.RotorSystem(
            shafts=[shaft("a"), shaft("b")],
            gears=[gear("ga", "a", 25, 0.035), gear("gb", "b", 50, base_radius)],
            meshes=[gb.Mesh("ga", "gb", stiffness=1e8)],
        )

    pair(0.07)  # exact value: no warning (warnings are errors here)
    with pytest.warns(gb.SceneWarning):
        system = pair(0.0721)  # 3 % off
    assert system.speed_ratios == pytest.approx([1.0, -0.5], rel=1e-15)
    with pytest.raises(gb.SceneError):
        pair(0.0742)  # 6 % off


def criticals(system: gb.RotorSystem, sense: str, low: float, high: float) -> list[float]:
    """Return the critical speeds of one whirl sense by counting modes below the speed."""

    def below(rpm: float) -> int:
        modes = system.modes(speed=rpm * RPM)
        whirl = np.array(modes.whirl)
        return int(np.sum((whirl == sense) & (60 * modes.frequencies_hz < rpm)))

    def search(low: float, high: float, count_low: int, count_high: int) -> list[float]:
        if count_low == count_high:
            return []
        if high - low < 5.0:
            return [(low + high) / 2] * (count_high - count_low)
        middle = (low + high) / 2
        count = below(middle)
        return search(low, middle, count_low, count) + search(middle, high, count, count_high)

    return search(low, high, below(low), below(high))


def test_synchronous_critical_speeds_of_nelson_and_mcvaugh():
    system = scenes.v2()
    found = [(x, s) for s in ("backward", "forward") for x in criticals(system, s, 1e3, 1.1e5)]
    found = sorted(found)[:6]
    assert [s for _, s in found] == [s for _, s in published.V2_CRITICALS_RPM]
    # the geometry is rounded: within 1 %
    assert [x for x, _ in found] == pytest.approx(
        [x for x, _ in published.V2_CRITICALS_RPM], rel=1e-2
    )
    # comparison with the independent assembly, with the same rounded geometry
    train = published.v2()
    for rpm, _ in found:
        own = train.eigenvalues(rpm * RPM, lateral_only=True).imag / RPM
        assert np.min(np.abs(own - rpm)) < 6.0  # rpm; the search stops after 5


def test_example_5_9_1_of_friswell_and_others():
    system = scenes.v3()
    assert {dof[2] for dof in system.matrices().dofs} == {"v", "w", "B", "G"}
    # one unit of the last printed digit (716.786 is printed as 716.78)
    at_rest = 2 * np.pi * system.modes(count=5).frequencies_hz
    assert at_rest == pytest.approx(published.V3_AT_REST, abs=1e-2)
    turning = system.modes(speed=4000 * RPM, count=5)
    assert 2 * np.pi * turning.frequencies_hz == pytest.approx(published.V3_AT_4000_RPM, abs=1e-2)
    whirl = ["backward", "forward", "backward", "forward", "backward"]
    assert list(turning.whirl) == whirl


@pytest.mark.parametrize("motion", ["torsion", "coupled"])
def test_example_5_9_1_in_torsion(motion: str):
    modes = scenes.v3(motion=motion).modes(count=7)
    found = 2 * np.pi * modes.frequencies_hz
    gap = np.abs(found - published.V3_TORSION)
    assert gap.min() < 1e-2  # one unit of the last printed digit
    assert modes.whirl[int(np.argmin(gap))] == "torsion"
    # uncoupled: the bending frequencies do not change
    if motion == "coupled":
        for frequency in published.V3_AT_REST:
            assert np.abs(found - frequency).min() < 1e-2


@pytest.mark.parametrize(
    ("build", "train", "speed"),
    [
        (scenes.v1, published.v1, published.V1_SPEED),
        (scenes.v2, published.v2, 30000 * RPM),
        (scenes.v3, published.v3, 4000 * RPM),
    ],
    ids=["Rao", "Nelson", "Friswell"],
)
def test_same_frequencies_as_the_independent_assembly(build, train, speed: float):
    system, own = build(), train()
    lateral = len(system.matrices().dofs) < own.size
    exact = own.eigenvalues(speed, lateral_only=lateral).imag
    found = 2 * np.pi * system.modes(speed=speed).frequencies_hz
    found = found[found > 1.0][:12]
    # both solve a first-order pencil in floating point: eps times the ratio of its frequencies,
    # squared
    assert found == pytest.approx(exact[:12], rel=1e-7)
