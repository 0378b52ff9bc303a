"""Numbers and units of modes, Campbell diagrams and critical speed maps against closed forms."""

from __future__ import annotations

import numpy as np
import pytest

import gearbow as gb
from reference import scenes
from reference.machines import inertia, jeffcott, rigid_rotor

MASS = 50.0 + scenes.DENSITY * np.pi / 4 * 0.1**2 * 0.2  # of disk and shaft


def block(
    stiffness: tuple[float, float], damping: float = 0.0, moment: float = 0.05
) -> gb.RotorSystem:
    """Return a disk of 50 kg amid a short shaft that is 1e3 times stiffer than its two bearings."""
    bearing = {"stiffness": stiffness, "damping": damping}
    return rigid_rotor(inertia(50.0, moment, moment), bearing, "s", motion="lateral")


def rows(table: str) -> list[list[str]]:
    """Return the words of the lines of a table without its header."""
    return [line.split() for line in table.splitlines()[1:]]


def test_frequencies_and_damping_of_modes_in_all_their_forms():
    # a mass on two bearings: ω² = 2k/m, ζ = c/√(2km), up to the flexibility of the shaft
    system = block((1e6, 2e6), damping=2e3)
    modes = system.modes(count=2)
    for mode, k in enumerate((1e6, 2e6)):
        undamped, ratio = np.sqrt(2 * k / MASS), 2e3 / np.sqrt(2 * k * MASS)
        frequency = undamped * np.sqrt(1 - ratio**2) / (2 * np.pi)
        assert modes.damping_ratios[mode] == pytest.approx(ratio, rel=1e-2)
        assert modes.frequencies_hz[mode] == pytest.approx(frequency, rel=1e-2)
    frame = modes.to_dataframe()
    np.testing.assert_array_equal(frame["frequency [Hz]"], modes.frequencies_hz)
    np.testing.assert_array_equal(frame["damping ratio"], modes.damping_ratios)
    head = modes.table().splitlines()[0]
    assert "frequency [Hz]  damping [%]" in head
    for number, words in enumerate(rows(modes.table())):
        assert words[0] == str(number + 1)
        assert float(words[1]) == pytest.approx(modes.frequencies_hz[number], abs=5.1e-4)
        assert float(words[2]) == pytest.approx(100 * modes.damping_ratios[number], abs=5.1e-4)


def test_energy_shares_of_a_mode_follow_its_motion():
    # softer along y: the first mode moves along y; nothing moves along z
    shares = block((1e6, 2e6)).modes(count=2).energy_shares()
    assert shares["s", "v"] == pytest.approx([1.0, 0.0], abs=1e-9)
    assert shares["s", "w"] == pytest.approx([0.0, 1.0], abs=1e-9)
    # tilting about the centre has rotary inertia only, of bending in the same plane
    tilting = block((1e6, 2e6), moment=5.0).modes(count=2)
    assert tilting.energy_shares()["s", "v"] == pytest.approx([1.0, 0.0], abs=1e-9)
    assert tilting.names() == ["s v", "s w"]
    # a circle has half of its energy in each direction
    whirling = scenes.v3().modes(speed=300.0, count=2)
    assert whirling.whirl == ("backward", "forward")
    (shaft,) = {name for name, _ in whirling.energy_shares()}
    for direction in ("v", "w"):
        assert whirling.energy_shares()[shaft, direction] == pytest.approx([0.5, 0.5], abs=1e-6)


def test_intersections_in_all_their_forms():
    # damped by 16 %: the modulus of the eigenvalue is far from its imaginary part
    system = jeffcott(damping=4e3)
    found = system.campbell(np.linspace(0.0, 500.0, 6), count=2)
    modes = system.modes(speed=300.0, count=2)
    at = found.frequencies_hz[3]
    assert np.sort(at) == pytest.approx(np.sort(modes.eigenvalues.imag / (2 * np.pi)), rel=1e-9)
    eigenvalue = modes.eigenvalues[0]
    expected = -eigenvalue.real / abs(eigenvalue)
    assert expected > 0.1
    assert found.damping_ratios[3].min() == pytest.approx(expected, rel=1e-3)
    assert found.intersections
    for intersection in found.intersections:
        assert intersection.frequency_hz == pytest.approx(
            intersection.speed / (2 * np.pi), rel=1e-9
        )
        assert intersection.damping_ratio == pytest.approx(expected, rel=1e-3)
    frame = found.to_dataframe()
    for column, name in (
        ("speed [rad/s]", "speed"),
        ("frequency [Hz]", "frequency_hz"),
        ("damping ratio", "damping_ratio"),
        ("whirl", "whirl"),
        ("mode", "mode"),
    ):
        assert list(frame[column]) == [getattr(m, name) for m in found.intersections]
    assert list(frame["order"]) == [1.0] * len(found.intersections)
    head = found.table().splitlines()[0]
    assert "speed [rad/s]  frequency [Hz]  damping [%]" in head
    for words, intersection in zip(rows(found.table()), found.intersections, strict=True):
        assert float(words[0]) == pytest.approx(intersection.speed, abs=5.1e-3)
        assert float(words[1]) == pytest.approx(intersection.frequency_hz, abs=5.1e-4)
        assert float(words[2]) == pytest.approx(100 * intersection.damping_ratio, abs=5.1e-4)
        assert words[3] == intersection.whirl
        assert int(words[4]) == intersection.mode + 1


def test_lines_of_a_diagram():
    system = scenes.PAIR.package()
    found = system.campbell([100.0, 2000.0], count=6, harmonics=3)
    expected = {"1× input": 1.0, "1× output": 0.5}
    expected |= {f"{m}× teeth of g1–g2": 25.0 * m for m in (1, 2, 3)}
    assert {line.name: line.order for line in found.lines} == pytest.approx(expected)
    assert found.criticals == tuple(m for m in found.intersections if "teeth" not in m.line.name)
    assert len(found.intersections) > len(found.criticals) > 0
    none = system.campbell([100.0, 2000.0], count=6, harmonics=0)
    assert {line.name for line in none.lines} == {"1× input", "1× output"}


@pytest.mark.parametrize("order", [1.0, 2.0])
def test_critical_speeds_of_a_rigid_rotor(order: float):
    # two bearings of stiffness k carry the mass: the critical speed is √(2k/m) over the order
    found = block((3e5, 7e5)).critical_speed_map([1e5, 4e5], order=order)
    assert found.order == order
    expected = np.sqrt(2 * np.array([1e5, 4e5]) / MASS) / order
    # up to the flexibility of the shaft
    assert [speeds[0] for speeds in found.speeds] == pytest.approx(expected, rel=1e-2)
