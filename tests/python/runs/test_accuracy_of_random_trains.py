"""The total error of ``accuracy="engineering"`` in random pairs and trains with every tooth model.

`make random` measures 200 cases. The normal run takes those whose mesh force varies by 4e-5 to 5e-3
of its mean: the tolerance of a run refers to the whole motion, and their errors exceed the level if
they are divided by the variation alone. In the first case, both flanks of undamped meshes touch.
"""

import os
import warnings
from dataclasses import dataclass, replace

import numpy as np
import pytest

import gearbow as gb
from gearbow.accuracy import LEVELS, refined, root_mean_square, unit_of_errors

LEVEL = LEVELS["engineering"]
TIMES = os.environ.get("GEARBOW_CASES")
CASES = range(20 * int(TIMES)) if TIMES else (2, 5, 19, 31, 70, 113, 130)
#: Tolerance of the reference: a thousandth of that of the level.
RTOL = 1e-7
#: Duration of a run [s]: the time for which the levels promise the error of undamped motions.
DURATION = 0.1
RECORD = ("gears", "meshes")


@dataclass(frozen=True)
class Case:
    """A random train without numbers of elements, and the speed of its first shaft [rad/s]."""

    name: str
    system: gb.RotorSystem
    speed: float


@dataclass(frozen=True)
class Measured:
    """The largest errors of a run by kind of signal, and whether the run announces them.

    Parameters
    ----------
    run : dict of {str: float}
        Errors of modes and integration.
    elements : dict of {str: float}
        Errors of the elements.
    is_announced : bool
        Whether the run gives a warning, or says that impacts can amplify small differences.
    """

    run: dict[str, float]
    elements: dict[str, float]
    is_announced: bool


def stiffness(
    random: np.random.Generator, kind: str, is_helical: bool, bore_radii: tuple[float, float]
) -> gb.Stiffness:
    """Draw a mesh stiffness of a kind; the bore radii [m] are those of driver and driven gear."""
    mean = float(random.uniform(1.5e8, 5e8))
    engagement = "sharp" if kind == "square, sharp" else float(random.uniform(0.05, 0.5))
    if kind == "constant":
        return gb.Stiffness.constant(mean)
    if kind == "iso6336":
        return gb.Stiffness.iso6336()
    if kind == "fourier":
        return gb.Stiffness.fourier(mean, [0.15 * mean, 0.05 * mean], [0.3, 1.1])
    if kind == "table":
        cycle = np.arange(16) / 16
        return gb.Stiffness.table(mean * (1.0 + 0.2 * np.tanh(3.0 * np.sin(2.0 * np.pi * cycle))))
    if kind.startswith("square"):
        return gb.Stiffness.square(mean, engagement=engagement)
    if kind == "parabolic":
        return gb.Stiffness.parabolic(mean, engagement=engagement)
    is_shared = not is_helical and random.random() < 0.5
    foundation = "shared" if is_shared else "separate"
    return gb.Stiffness.potential_energy(bore_radii, engagement=engagement, foundation=foundation)


KINDS = (
    "constant",
    "square, sharp",
    "square, smooth",
    "parabolic",
    "potential_energy",
    "iso6336",
    "fourier",
    "table",
)


def drawn(seed: int) -> Case:
    """Draw a pair, or a serial train of three or four shafts; every seventh one is undamped."""
    random = np.random.default_rng([29, seed])
    kind = KINDS[seed % len(KINDS)]
    count = int(random.choice([2, 2, 3]))
    count = 4 if seed % 5 == 4 else count
    is_damped = seed % 7 != 2
    is_helical, is_bowed = random.random() < 0.5, random.random() < 0.7
    has_backlash, has_error = random.random() < 0.5, random.random() < 0.5
    helix = float(random.uniform(0.1, 0.4)) if is_helical else 0.0
    module = float(random.choice([2e-3, 3e-3, 4e-3]))
    shafts, gears, meshes, bearings = [], [], [], []

    def gear(name: str, shaft: int, x: float, teeth: int) -> None:
        hand = (-1.0) ** shaft
        gears.append(
            gb.Gear(
                name,
                f"s{shaft}",
                x,
                teeth=teeth,
                module=module,
                face_width=10.0 * module,
                helix_angle=hand * helix,
                unbalance=float(random.uniform(0.0, 1e-4)),
            )
        )

    for i in range(count):
        name, length = f"s{i}", float(random.uniform(0.2, 0.7))
        diameter = float(random.uniform(0.03, 0.06))
        bow = gb.Bow.half_sine(float(random.uniform(2e-5, 2e-4)), phase=float(random.uniform(0, 6)))
        shafts.append(
            gb.Shaft(name, length=length, outer_diameter=diameter, bow=bow if is_bowed else None)
        )
        places = np.sort(random.uniform(0.15, 0.85, 2)) * length
        if i > 0:
            gear(f"b{i}", i, float(places[0]), int(random.integers(30, 60)))
            meshes.append((f"a{i - 1}", f"b{i}"))
        if i < count - 1:
            gear(f"a{i}", i, float(places[1]), int(random.integers(18, 30)))
        damping = float(random.uniform(200.0, 1500.0)) * is_damped
        lateral = float(10 ** random.uniform(7.5, 8.6))
        bearings += [
            gb.Bearing(
                name,
                x,
                stiffness=lateral,
                damping=damping,
                axial_stiffness=1e8 if is_helical else None,
                axial_damping=500.0 * is_damped if is_helical else None,
            )
            for x in (0.0, length)
        ]
    error = gb.TransmissionError(
        tooth=[(float(random.uniform(1e-6, 4e-6)), 0.3)],
        driven=[(float(random.uniform(5e-6, 2e-5)), 1.0)],
    )
    teeth = stiffness(random, kind, is_helical, (4.5 * module, 7.5 * module))
    system = gb.RotorSystem(
        shafts=shafts,
        gears=gears,
        meshes=[
            gb.Mesh(
                *pair,
                stiffness=teeth,
                damping_ratio=float(random.uniform(0.02, 0.08)) * is_damped,
                centre_line_angle=float(random.uniform(0.0, 6.0)),
                backlash=1e-4 if has_backlash else None,
                error=error if has_error else None,
            )
            for pair in meshes
        ],
        bearings=bearings,
        torques=[
            gb.Torque("a0", float(random.uniform(30.0, 200.0))),
            gb.Torque.balance(f"b{count - 1}"),
        ],
        gravity=9.81,
        modal_damping=float(random.choice([0.005, 0.01, 0.02])) * is_damped,
    )
    features = [
        kind,
        f"{count} shafts",
        "helical" if is_helical else "spur",
        *(
            name
            for name, has in (
                ("backlash", has_backlash),
                ("error", has_error),
                ("bow", is_bowed),
                ("undamped", not is_damped),
            )
            if has
        ),
    ]
    speed = float(10 ** random.uniform(1.0, np.log10(1500.0)))
    return Case(f"{seed}: {', '.join(features)}, {speed:.1f} rad/s", system, speed)


def exact(system: gb.RotorSystem, speed: float) -> gb.Response:
    """Run all modes with a small tolerance."""
    return system.simulate(DURATION, speed, method="exponential", rtol=RTOL, record=RECORD)


def difference(run: gb.Response, other: gb.Response) -> dict[str, float]:
    """Return the largest errors of displacements and of mesh forces."""
    errors = {"displacement": 0.0, "mesh_force": 0.0}
    signals = [
        ("displacement", run.displacement(name), other.displacement(name))
        for name in other.recorded
        if isinstance(name, str)
    ] + [
        ("mesh_force", run.mesh(pair[:2]).force[:, None], other.mesh(pair[:2]).force[:, None])
        for pair in other.recorded
        if not isinstance(pair, str)
    ]
    for kind, ours, theirs in signals:
        error = root_mean_square(ours - theirs) / unit_of_errors(theirs)
        errors[kind] = max(errors[kind], error)
    return errors


def measured(case: Case) -> Measured:
    """Measure the errors of a case."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        run = case.system.simulate(DURATION, case.speed, accuracy=LEVEL.name, record=RECORD)
    finer = gb.RotorSystem.from_dict(refined(case.system._model.resolved()))
    same, fine = exact(case.system, case.speed), exact(finer, case.speed)
    is_warned = any(issubclass(each.category, gb.AccuracyWarning) for each in caught)
    return Measured(
        run=difference(run, same),
        elements=difference(same, fine),
        is_announced=is_warned or "impacts can amplify" in run.accuracy,
    )


@pytest.mark.implausible
# Some gears stand less than 1 mm apart; the errors of the level are far larger than the round-off.
@pytest.mark.filterwarnings("ignore:natural frequencies range:gearbow.AccuracyWarning")
@pytest.mark.parametrize("seed", CASES)
def test_no_error_exceeds_the_level_without_an_announcement(seed):
    case = drawn(seed)
    try:
        found = measured(case)
    except gb.ContactError:
        pytest.skip("the motion grows until the base circles overlap")
    if not found.is_announced:
        for kind, error in found.run.items():
            assert error <= getattr(LEVEL, kind), case.name
            assert found.elements[kind] <= getattr(LEVEL, kind), case.name


def test_a_level_keeps_the_error_of_a_mesh_force_with_short_peaks():
    # The range of the force of this undamped pair is 6.4 times its standard deviation; a sine has 2.8.
    # With the range as the unit of errors, the error of the force was 1.5e-2.
    found = measured(replace(drawn(300015), speed=-35.3))
    assert found.run["mesh_force"] <= LEVEL.mesh_force
