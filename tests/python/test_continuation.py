"""Branches of steady states: Duffing's equation and a gear pair with clearance."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import gearbow as gb
from gearbow.analysis.arclength import Settings, branch
from reference.teeth import Toothed

#: Mean stiffness [N/m], half backlash [m] and damping ratio of the pair with clearance.
MEAN, HALF, ZETA = 2e8, 1e-5, 0.05
MESH = ("ga", "gb")


class Duffing:
    """Period map of Duffing's equation by the classical Runge–Kutta method."""

    STEPS = 100

    def images(self, states: np.ndarray, value: float) -> np.ndarray:
        step = 2 * np.pi / value / self.STEPS

        # A prediction may be far from the branch.
        with np.errstate(over="ignore", invalid="ignore"):
            return self.after_period(states, value, step)

    def after_period(self, states: np.ndarray, value: float, step: float) -> np.ndarray:
        def rate(t: float, x: np.ndarray) -> np.ndarray:
            force = 0.18 * np.cos(value * t)
            return np.array([x[1], force - 0.05 * x[1] - x[0] - 0.1 * x[0] ** 3])

        x = states.T
        for number in range(self.STEPS):
            t = number * step
            a = rate(t, x)
            b = rate(t + step / 2, x + step / 2 * a)
            c = rate(t + step / 2, x + step / 2 * b)
            d = rate(t + step, x + step * c)
            x = x + step / 6 * (a + 2 * b + 2 * c + d)
        return x.T

    def observed(self, *_: Any) -> tuple[None, float]:
        return None, np.inf


def test_a_branch_ends_at_the_bound_of_the_interval():
    rotor = gb.Shaft(
        "rotor", length=1.0, outer_diameter=0.05, elements=2, bow=gb.Bow.half_sine(1e-4)
    )
    bearings = [gb.Bearing("rotor", x, stiffness=1e8, damping=1e3) for x in (0.0, 1.0)]
    system = gb.RotorSystem(shafts=[rotor], bearings=bearings)
    middle = ("rotor", 0.5)
    for start, stop in ((1.0, 2.0), (2.0, 1.0)):
        branch = system.continuation("bow", start, stop, speed=100.0, record=[middle])
        assert branch.values[[0, -1]].tolist() == [start, stop]
        assert branch.message == ""
        # the response to a bow is proportional to it
        amplitude = branch.amplitude(middle)
        np.testing.assert_allclose(amplitude, amplitude[0] * branch.values / start, rtol=1e-7)


def test_the_folds_of_duffings_equation():
    points = list(
        branch(Duffing(), np.array([0.28, 0.0]), Settings(0.6, 1.4, step=0.05, largest=0.1))
    )
    folds = [point.value for point in points if point.kind == "fold"]
    # 15 odd harmonics give 1.269602 and 1.115700; the fixed steps have an error of 1e-6.
    assert folds == pytest.approx([1.269602, 1.115700], abs=3e-6)
    assert points[-1].value == 1.4
    # between the folds the motion is unstable by a multiplier beyond +1
    at = [i for i, point in enumerate(points) if point.kind == "fold"]
    for i, point in enumerate(points):
        largest = np.abs(point.multipliers[0])
        assert (largest > 1) == (at[0] < i < at[1]) or i in at
    assert len(points) < 200


def clearance(**changes: Any) -> gb.RotorSystem:
    """Return a gear pair of Kahraman and Singh: K f(x) with K = 1 − 0.2 cos Ωt − …, backlash 2."""
    bare = Toothed()
    shares = (0.2, 0.1, 0.05)
    zero = first_phase()
    stiffness = gb.Stiffness.fourier(
        MEAN,
        [share * MEAN for share in shares],
        [np.pi - number * zero for number in (1, 2, 3)],
        phase="prescribed",
    )
    error = gb.TransmissionError(tooth=[(share * HALF, 0.0) for share in (0.01, 0.004, 0.002)])
    mesh = {
        "stiffness": stiffness,
        "damping_ratio": ZETA,
        "backlash": 2 * HALF,
        "error": error,
        **changes,
    }
    radius = bare.law().base_radius_a
    return Toothed(mesh=mesh, torque=0.1 * MEAN * HALF * radius).package()


def first_phase() -> float:
    """Return the phase of the first harmonic of the mesh cycle at the shaft angle 0."""
    fourier = gb.Stiffness.fourier(MEAN, [0.1 * MEAN], phase="prescribed")
    system = Toothed(mesh={"stiffness": fourier}).package()
    period = 2 * np.pi / (100.0 * 25)
    found = system.simulate(
        period, 100.0, initial="rest", times=np.arange(32) * period / 32, record=["meshes"]
    )
    return float(np.angle(np.fft.rfft(found.mesh(*MESH).stiffness)[1]))


def speed(ratio: float) -> float:
    """Return the speed for a tooth frequency Ω over the natural frequency."""
    return float(ratio * np.sqrt(MEAN / Toothed().effective_mass) / 25)


def test_the_pair_with_clearance_has_the_published_motion():
    steady = clearance().steady_state(
        speed(0.5), rtol=1e-10, initial="static", record=["meshes"], output_step=1e-7
    )
    x = steady.response.mesh(*MESH).deflection / HALF + 1
    # The damper acts in contact, and the flanks never pull: the value of an independent integration
    # with tolerance 1e-9. With a damper that pulls, the largest value is 1.2409336.
    assert x.max() == pytest.approx(1.24052582, abs=1e-7)


def test_the_pair_with_damping_in_separation_has_the_published_motion():
    steady = clearance(damping_in_separation=True).steady_state(
        speed(0.5), rtol=1e-10, initial="static", record=["meshes"], output_step=1e-7
    )
    x = steady.response.mesh(*MESH).deflection / HALF + 1
    assert x.max() == pytest.approx(1.2423926, abs=1e-6)
    assert x.std() == pytest.approx(0.0903348, abs=1e-6)
    # the damper acts always: |mu| = exp(-zeta T) with T = 2 pi / 0.5 of the natural frequency 1
    exact = np.exp(-ZETA * 2 * np.pi / 0.5)
    multipliers = steady.multipliers_above(0.5)
    assert np.abs(np.abs(multipliers) - exact).min() < 1e-6


def test_the_branch_of_the_pair_with_clearance_has_four_folds(tmp_path: Path):
    system = clearance(damping_in_separation=True)
    found = system.continuation(
        "speed", speed(0.95), speed(0.4), record=["meshes"], rtol=1e-9, step=0.05
    )
    assert not found.message
    ratios = found.folds / speed(1.0)
    assert ratios.size == 4
    assert np.all((ratios > 0.43) & (ratios < 0.84))
    # located to 1e-6: another step along the branch gives the same values
    assert ratios == pytest.approx([0.598153, 0.835838, 0.437007, 0.455324], abs=1e-6)
    # both branches of each jump are stable, the one between the folds is not
    inside = np.flatnonzero([kind == "fold" for kind in found.kinds])
    assert found.stable[0]
    assert found.stable[-1]
    assert not found.stable[inside[0] + 1 : inside[1]].any()
    assert found.contact_loss.size >= 2
    path = tmp_path / "branch.npz"
    found.save(path)
    again = gb.Continuation.load(path)
    np.testing.assert_array_equal(again.values, found.values)
    np.testing.assert_array_equal(again.stable, found.stable)
    np.testing.assert_array_equal(
        again.amplitude(MESH, "deflection"), found.amplitude(MESH, "deflection")
    )
    assert repr(again) == repr(found)


def test_a_branch_over_the_torque_keeps_what_it_reached():
    found = clearance().continuation(
        "torque", 1.0, 3.0, speed=speed(0.3), record=["meshes"], max_points=3
    )
    assert found.values.size >= 4
    assert found.message.startswith("max_points: 3 points reach")


def test_wrong_arguments_name_the_argument():
    system = clearance()
    with pytest.raises(gb.SceneError, match='parameter: must be one of "speed"'):
        system.continuation("mass", 1.0, 2.0)
    with pytest.raises(gb.SceneError, match="speed: give it"):
        system.continuation("torque", 1.0, 2.0)
    with pytest.raises(gb.SceneError, match="bow: no shaft has a bow"):
        system.continuation("bow", 1.0, 2.0, speed=10.0)


def test_an_interrupted_branch_keeps_its_points():
    def stop(fraction: float) -> None:
        if fraction > 0.5:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt) as caught:
        clearance().continuation(
            "backlash",
            HALF,
            3 * HALF,
            speed=speed(0.3),
            record=["meshes"],
            max_points=6,
            progress=stop,
        )
    kept: gb.Continuation = caught.value.branch  # type: ignore[attr-defined]
    assert kept.values.size == 4
    assert kept.message == "interrupted"
    assert kept.stable.all()
    assert "backlash" in repr(kept)
    kept.plot(MESH, "deflection").savefig(Path("/dev/null"), format="png")
    (panel,) = kept.plot(MESH, speed_unit="rpm").axes
    assert panel.get_xlabel() == "backlash [m]"
    table = kept.to_dataframe(MESH)
    assert len(table) == kept.values.size
    assert table.columns[1:3].tolist() == ["stable", "kind"]
    np.testing.assert_array_equal(table.iloc[:, -1], kept.amplitude(MESH))
