"""Stresses in turning shafts: closed forms, runs beside tones, notches, strength and limits of bows."""

from __future__ import annotations

from math import pi, sqrt
from typing import Any

import numpy as np
import pytest

import gearbow as gb
from reference import machines

DIAMETER = 0.02
#: Section moduli of the shaft below [m³], and its area [m²].
BENDING, TORSION, AREA = pi * DIAMETER**3 / 32, pi * DIAMETER**3 / 16, pi * DIAMETER**2 / 4


def _loaded(notches: Any = (), **more: Any) -> gb.RotorSystem:
    """A light shaft with a force of 100 N in its middle, a torque of 20 N m and a tension of 300 N."""
    shaft = gb.Shaft(
        "rotor", length=1.0, outer_diameter=DIAMETER, material=machines.LIGHT, elements=2
    )
    bearings = [
        gb.Bearing("rotor", x, stiffness=1e8, axial_stiffness=a)
        for x, a in ((0.0, 1e7), (1.0, 0.0))
    ]
    forces = [gb.Force(("rotor", 0.5), -100j), gb.Force(("rotor", 1.0), 0.0, axial=300.0)]
    torques = [gb.Torque(("rotor", 0.0), 20.0), gb.Torque(("rotor", 1.0), -20.0)]
    given = {"bearings": bearings, "forces": forces, "torques": torques, "notches": notches}
    return gb.RotorSystem([shaft], **{**given, **more})


def _at(found: gb.results.Stresses, x: float, side: str = "before") -> int:
    return next(i for i, (_, at, own) in enumerate(found.sections) if (at, own) == (x, side))


def test_a_standing_force_alternates_and_torque_is_a_mean() -> None:
    found = _loaded().stresses(30.0)
    i = _at(found, 0.5)
    assert found.bending[i] == pytest.approx([0.0, 25.0 / BENDING], abs=1e-6 * 25.0 / BENDING)
    assert found.axial[i] == pytest.approx([300.0 / AREA, 0.0], rel=1e-9, abs=1.0)
    assert abs(found.torsion[i, 0]) == pytest.approx(20.0 / TORSION, rel=1e-9)
    assert found.amplitude[i] == pytest.approx(25.0 / BENDING, rel=1e-6)
    mean = sqrt((300.0 / AREA) ** 2 + 3.0 * (20.0 / TORSION) ** 2)
    assert found.mean[i] == pytest.approx(mean, rel=1e-6)
    assert np.isnan(found.utilisation).all()


def test_at_rest_everything_is_a_mean() -> None:
    found = _loaded().stresses(0.0)
    i = _at(found, 0.5)
    # at rest the fibre matters: the mean is that of the most loaded one only if it is chosen
    assert found.amplitude[i] == 0.0
    limited = _loaded().stresses(0.0, endurance_limit=2e8, tensile_strength=6e8)
    direct = 25.0 / BENDING + 300.0 / AREA
    mean = sqrt(direct**2 + 3.0 * (20.0 / TORSION) ** 2)
    assert limited.mean[i] == pytest.approx(mean, rel=1e-4)
    assert limited.utilisation[i] == pytest.approx(mean / 6e8, rel=1e-4)


@pytest.mark.parametrize("line", ["goodman", "din743"])
def test_notches_and_mean_stresses(line: Any) -> None:
    notch = gb.Notch("rotor", 0.5, bending=1.8, torsion=1.5)
    found = _loaded([notch]).stresses(30.0, endurance_limit=2e8, tensile_strength=6e8, line=line)
    i = _at(found, 0.5)
    amplitude = 1.8 * 25.0 / BENDING
    mean = sqrt((300.0 / AREA) ** 2 + 3.0 * (20.0 / TORSION) ** 2)
    assert found.amplitude[i] == pytest.approx(amplitude, rel=1e-6)
    assert found.notches[i] == "1.8 / 1.5"
    if line == "goodman":
        expected = amplitude / 2e8 + mean / 6e8
    else:
        # DIN 743-1, (10) to (22): σ_ADK = σ_WK − ψ σ_m with σ_WK = σ_W/K, ψ = σ_WK/(2 σ_B − σ_WK)
        endured = 2e8 / 1.8
        left = endured - endured / (2 * 6e8 - endured) * mean
        expected = 25.0 / BENDING / left
    assert found.utilisation[i] == pytest.approx(expected, rel=1e-6)
    # given notches replace those of the system, also between nodes
    between = _loaded([notch]).stresses(30.0, notches=[gb.Notch("rotor", 0.3, bending=3.0)])
    assert between.notches[_at(between, 0.5)] == ""
    assert between.amplitude[_at(between, 0.3)] == pytest.approx(3.0 * 15.0 / BENDING, rel=1e-6)


def test_a_step_without_a_notch_is_named() -> None:
    shaft = gb.Shaft("rotor", segments=[gb.Segment(0.4, 0.03), gb.Segment(0.4, 0.05)])
    bearings = [gb.Bearing("rotor", x, stiffness=1e8) for x in (0.0, 0.8)]
    system = gb.RotorSystem([shaft], bearings=bearings, gravity=9.81)
    found = system.stresses(10.0)
    assert (
        found.notches[_at(found, 0.4)] == found.notches[_at(found, 0.4, "beyond")] == "none given"
    )
    assert "none given" in found.table()
    ratio = found.bending[_at(found, 0.4), 1] / found.bending[_at(found, 0.4, "beyond"), 1]
    assert ratio == pytest.approx((0.05 / 0.03) ** 3, rel=1e-6)


def test_sleeves_carry_their_share() -> None:
    sleeve = gb.Sleeve("rotor", 0.3, 0.7, 0.03, DIAMETER, material=machines.LIGHT, stiffness="full")
    found = _loaded(sleeves=[sleeve]).stresses(30.0)
    inertia = pi * 0.03**4 / 64
    expected = 25.0 * DIAMETER / 2 / inertia
    assert found.bending[_at(found, 0.5), 1] == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("speed", [150.0, -150.0])
def test_bow_and_unbalance_are_means_and_weight_alternates(speed: float) -> None:
    """Tones of the linear analysis beside the extremes of a recorded run, with orbits of an ellipse."""
    shaft = {"bow": gb.Bow.half_sine(2e-4, 0.4), "elements": 5}
    disk = {**machines.inertia(12.0, 0.05, 0.09), "unbalance": 3e-4 * np.exp(0.3j), "position": 0.3}
    # so soft along y that the orbit is an ellipse with a backward part
    bearing = {"stiffness": (6e5, 9e6), "damping": 800.0}
    system = machines.rotor(shaft, disk, bearing, gravity=9.81)
    options: Any = {"endurance_limit": 2e8, "tensile_strength": 6e8}
    linear = system.stresses(speed, **options)
    # whole turns, so that the extremes of the two frequencies occur; 400 samples in a turn
    turn = 2 * pi / abs(speed)
    run = system.simulate(
        6 * turn, speed, record=["nodes", "section_forces"], rtol=1e-9, output_step=turn / 400
    )
    recorded = run.stresses(**options)
    assert recorded.sections == linear.sections
    scale = linear.amplitude.max()
    # extremes of two frequencies, whose amplitudes the linear analysis adds up
    assert recorded.amplitude == pytest.approx(linear.amplitude, rel=2e-3, abs=1e-4 * scale)
    assert recorded.utilisation == pytest.approx(linear.utilisation, rel=2e-3, abs=1e-5)
    i = _at(linear, 0.3)
    assert linear.bending[i, 0] != pytest.approx(0.0, abs=1e-2 * scale)


def test_both_senses_of_rotation_of_the_hostile_machine() -> None:
    """The bound of the tones encloses a run without teeth errors at both senses of rotation."""
    system = machines.without_tooth_errors(machines.hostile())
    for speed in (120.0, -120.0):
        linear = system.stresses(speed)
        run = system.simulate(0.15, speed, record=["nodes", "section_forces"])
        recorded = run.stresses(skip_time=0.05)
        at = {section: i for i, section in enumerate(recorded.sections)}
        scale = linear.amplitude.max()
        for i, section in enumerate(linear.sections):
            found = recorded.amplitude[at[section]]
            # the run lasts long enough for three of four tones to meet, and no tone is missing
            assert found <= 1.02 * linear.amplitude[i] + 1e-3 * scale
            assert found >= 0.6 * linear.amplitude[i] - 1e-3 * scale


def test_the_limit_of_a_bow_by_stress() -> None:
    bow = gb.Bow.half_sine(1e-4, 0.2)
    disk = {**machines.inertia(12.0, 0.05, 0.09), "unbalance": 3e-4, "position": 0.4}
    system = machines.rotor({"bow": bow, "elements": 5}, disk, gravity=9.81)
    strength: Any = {"tensile_strength": 3e8}
    limit = gb.BowLimit.stress("disk", 1e8, **strength)
    found = system.bow_limits("rotor", 150.0, limits=[limit]).limits[-1]
    assert found.limit == "stress"
    for factor, sign in ((0.999, -1), (1.001, 1)):
        turned = 0.2 + float(np.nan_to_num(found.phase))
        bent = gb.Bow.half_sine(factor * found.bow, turned)
        tried = system.replace(
            shafts=[gb.Shaft("rotor", length=1.0, outer_diameter=0.05, elements=5, bow=bent)]
        )
        use = tried.stresses(150.0, endurance_limit=1e8, **strength)
        at_disk = [i for i, (_, x, _) in enumerate(use.sections) if x == 0.4]
        assert sign * (use.utilisation[at_disk].max() - 1.0) > 0.0


def test_strain_gauges_turn_with_the_shaft() -> None:
    bow = gb.Bow.half_sine(1e-4, 0.3)
    system = machines.rotor(
        {"bow": bow, "elements": 4},
        gravity=9.81,
        torques=[gb.Torque(("rotor", 0.0), 5.0), gb.Torque(("rotor", 1.0), -5.0)],
    )
    run = system.simulate(0.1, 200.0, record=[("rotor", 0.5), "section_forces"], output_step=1e-4)
    bending = run.measure(gb.StrainGauge(("rotor", 0.5), "bending", angle=0.7))
    static = system.static(200.0).section_forces(("rotor", 0.5)).bending
    turning = system.synchronous([200.0]).section_forces(("rotor", 0.5)).bending[0, 0]
    # the weight alternates once a turn, the bow is constant; isotropic bearings have no other part
    assert np.ptp(bending) / 2.0 == pytest.approx(np.hypot(*static), rel=1e-3)
    mean = -np.imag((turning[0] + 1j * turning[1]) / 2.0 * np.exp(-0.7j))
    whole = np.abs(200.0 * run.time) < 2 * pi * 3
    assert bending[whole].mean() == pytest.approx(mean, rel=1e-2)
    torque = run.measure(gb.StrainGauge(("rotor", 0.5)))
    assert torque == pytest.approx(run.section_forces(("rotor", 0.5)).torque)
    found = run.spectrum(gb.StrainGauge(("rotor", 0.5), "bending"))
    assert found.unit == "N m"
    harmonic = system.frequency_response([50.0], source=gb.Torque(("rotor", 0.0), 1.0))
    phasor = harmonic.measure(gb.StrainGauge(("rotor", 0.5)))
    assert phasor == pytest.approx(harmonic.section_forces(("rotor", 0.5)).torque)
    with pytest.raises(gb.SceneError, match="gauges of bending turn with the shaft"):
        harmonic.measure(gb.StrainGauge(("rotor", 0.5), "bending"))
    with pytest.raises(
        gb.SceneError, match=r"strain_gauge.quantity: must be one of torque, bending"
    ):
        gb.StrainGauge("disk", "shear")  # type: ignore[arg-type]
    with pytest.raises(gb.SceneError, match=r"strain_gauge.angle: gauges of torque have none"):
        gb.StrainGauge("disk", angle=1.0)


def test_a_steady_state_has_section_forces() -> None:
    system = machines.rotor(
        {"bow": gb.Bow.half_sine(1e-4)}, bearing={"stiffness": 1e7, "damping": 900.0}
    )
    steady = system.steady_state(150.0, record=[("rotor", 0.5), "section_forces"])
    phasor = system.synchronous([150.0]).section_forces(("rotor", 0.5)).bending[0, 0, 1]
    found = steady.section_forces(("rotor", 0.5)).bending[:, 1]
    assert np.ptp(found) / 2.0 == pytest.approx(abs(phasor), rel=1e-3)


def test_scene_files_keep_notches(tmp_path: Any) -> None:
    notch = gb.Notch("rotor", 0.3, bending=2.1, torsion=1.7)
    system = _loaded([notch])
    system.save(tmp_path / "scene.toml")
    assert gb.read(tmp_path / "scene.toml").notches == (notch,)


@pytest.mark.parametrize(
    ("notch", "message"),
    [
        (gb.Notch("axle", 0.3), r'notches\[0\].shaft: .*"axle"'),
        (gb.Notch("rotor", 1.3), r"notches\[0\].position: lies beyond the end of shaft"),
        (
            gb.Notch("rotor", 0.3, bending=0.9),
            r"notches\[0\].bending: a notch factor is at least 1",
        ),
        (gb.Notch("rotor", 0.3, torsion=float("nan")), r"notches\[0\].torsion: must be finite"),
    ],
)
def test_invalid_notches(notch: gb.Notch, message: str) -> None:
    with pytest.raises(gb.SceneError, match=message):
        _loaded([notch])


def test_invalid_strength() -> None:
    system = _loaded()
    with pytest.raises(gb.SceneError, match="tensile_strength: the line for mean stresses"):
        system.stresses(1.0, endurance_limit=2e8)
    with pytest.raises(gb.SceneError, match="endurance_limit: must be one of rotor, got 'axle'"):
        system.stresses(1.0, endurance_limit={"axle": 2e8}, tensile_strength=6e8)
    with pytest.raises(gb.SceneError, match="line: must be one of goodman, din743"):
        system.stresses(1.0, line="soderberg")  # type: ignore[arg-type]
    with pytest.raises(gb.SceneError, match=r"endurance_limit\['rotor'\]: must be above zero"):
        system.stresses(1.0, endurance_limit=-2e8, tensile_strength=6e8)


def test_figure_and_table() -> None:
    found = _loaded().stresses(30.0, endurance_limit=2e8, tensile_strength=6e8)
    assert len(found.plot().axes) == 2
    assert len(_loaded().stresses(30.0).plot().axes) == 1


def test_a_figure_of_many_shafts_is_as_wide_as_a_page() -> None:
    # a report reduces wider figures to its page, so that numbers of neighbouring panels would overlap
    found = machines.hostile().stresses(30.0, endurance_limit=2e8, tensile_strength=6e8)
    figure = found.plot()
    assert figure.get_figwidth() <= 12.0
    assert len(figure.axes) == 8
    assert [panel.get_title(loc="left") for panel in figure.axes[::2]] == [
        *("input", "idler", "middle", "output")
    ]
    assert "equivalent ±" in found.table()
    assert "utilisation" in found.to_dataframe().columns
