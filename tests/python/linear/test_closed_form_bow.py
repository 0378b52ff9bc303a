"""Residual bow against closed forms: sine-bowed shaft, Jeffcott rotor, rigid-body bow, all shapes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

import gearbow as gb
from reference import closed_forms
from reference.elements import Section
from reference.scenes import single_shaft

# midspan amplitude over bow amplitude; L 1 m, d 0.05 m, E 207e9, nu 0.3, rho 7800 (validation table
# V4)
SPEEDS = (200.0, 400.0, 550.0, 700.0, 1200.0)
TABLE = {
    True: (1.110278, 1.659201, 4.018446, -4.613847, -0.388232),
    False: (1.109726, 1.654280, 3.964414, -4.733929, -0.390691),
}
BOW = 1e-4


def section(shear: bool = True, diameter: float = 0.05) -> Section:
    return Section(diameter, 207e9, 207e9 / 2.6, 7800.0, shear=shear)


def forward(system: gb.RotorSystem, at: str | tuple[str, float], speed: float) -> complex:
    amplitudes = system.synchronous([speed]).displacement(at)
    assert amplitudes.shape == (1, 1, 2)
    ahead, behind = closed_forms.forward_backward(amplitudes[0, 0])
    # isotropic supports: no backward whirl; round-off of a matrix of condition 1e9
    assert abs(behind) < 1e-8 * max(abs(ahead), BOW)
    return ahead


def test_a_slow_shaft_on_two_bearings_has_its_measured_bow_within_elements_too():
    # No force bends it back. The points of the bow lie within the elements.
    points = np.array([0.0, 0.13, 0.41, 0.68, 0.9, 1.0])
    phasors = BOW * np.array([0.0, 0.4, 1.0, 0.7, 0.25j, 0.0])
    bow = gb.Bow.points(points, np.abs(phasors), np.angle(phasors))
    curve = CubicSpline(points, phasors)
    system = single_shaft(bow, elements=2, degree=8)
    for x in (0.2, 0.3, 0.5, 0.6, 0.8):
        # A polynomial of degree 8 leaves 2.3e-4 of a spline with two points in the element.
        assert abs(forward(system, ("s", x), 1e-3) - curve(x)) < 5e-4 * BOW


@pytest.mark.parametrize("shear", [True, False], ids=["Timoshenko", "Rayleigh"])
def test_sine_bow_against_the_validation_table(shear: bool):
    speeds = np.array(SPEEDS)
    system = single_shaft(gb.Bow.half_sine(BOW), elements=8, shear=shear)
    found = system.synchronous(speeds).displacement(("s", 0.5))
    for i, (speed, printed) in enumerate(zip(SPEEDS, TABLE[shear], strict=True)):
        exact = closed_forms.bowed_shaft(section(shear), 1.0, speed)
        assert exact == pytest.approx(printed, abs=6e-7)  # half a unit of the last printed digit
        ahead, _ = closed_forms.forward_backward(found[i, 0])
        # eight elements have an error of at most 6e-4 (700 rad/s, near the critical speed)
        assert ahead / BOW == pytest.approx(exact, rel=1e-3)


@pytest.mark.parametrize(
    ("shear", "counts", "order"),
    # Rayleigh: cubic deflection, fourth order; the supports of 1e13 N/m leave 5e-7, hence no finer.
    # Timoshenko: the shear strain is constant along an element, second order once that term leads.
    [(False, (4, 8), 4.0), (True, (16, 32), 2.0)],
    ids=["Rayleigh", "Timoshenko"],
)
def test_error_decreases_with_the_order_of_the_element(
    shear: bool, counts: tuple[int, int], order: float
):
    speed = 700.0
    exact = closed_forms.bowed_shaft(section(shear), 1.0, speed)
    errors = []
    for count in counts:
        system = single_shaft(gb.Bow.half_sine(BOW), elements=count, shear=shear)
        errors.append(abs(forward(system, ("s", 0.5), speed) / BOW / exact - 1))
    # observed order of one refinement: within 0.2 of its limit (4.0 and 2.14 by the independent
    # assembly; finer elements show the flexibility of the supports)
    assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.2)


def test_higher_sine_bow_keeps_its_shape():
    # two half waves: midspan is at rest, the quarter points follow the closed form
    system = single_shaft(gb.Bow.mode(2, BOW), elements=32)
    exact = closed_forms.bowed_shaft(section(), 1.0, 900.0, half_waves=2)
    # (2 pi / 32)^2 / 12 of the shear contribution, 1.8e-2, is 6e-5 of the resonance term
    assert forward(system, ("s", 0.25), 900.0) / BOW == pytest.approx(exact, rel=2e-4)
    assert abs(forward(system, ("s", 0.5), 900.0)) < 1e-6 * BOW


class TestJeffcott:
    """A disk at the middle of a shaft with 1e-5 of its mass: one mass on one spring."""

    MASS, DELTA = 200.0, 2e-4
    LENGTH, DIAMETER, SUPPORT, ZETA = 1.0, 0.05, 1e8, 0.05

    @property
    def critical(self) -> float:
        bending = 48 * 207e9 * section().moment / self.LENGTH**3
        return float(np.sqrt(1 / (1 / bending + 1 / (2 * self.SUPPORT)) / self.MASS))

    def rotor(self, eccentricity: complex, phase: float = 0.0, zeta: float = ZETA):
        damping = 2 * zeta * self.MASS * self.critical
        return single_shaft(
            gb.Bow.half_sine(self.DELTA, phase=phase) if self.DELTA else None,
            elements=2,
            density=1.0,
            shear=False,
            support=self.SUPPORT,
            disks=[
                gb.Disk("disk", "s", 0.5, self.MASS, 1.0, 2.0, unbalance=self.MASS * eccentricity)
            ],
            bearings=[gb.Bearing("s", position=0.5, stiffness=0.0, damping=damping)],
        )

    # the shaft adds half of its 2e-3 kg to 200 kg: 5e-6 of mass, times the resonance factor 1/(2
    # zeta) = 10
    TOLERANCE = 1e-4

    @pytest.mark.parametrize("ratio", [0.01, 0.3, 0.8, 0.95, 1.0, 1.05, 1.3, 2.0, 5.0])
    @pytest.mark.parametrize(
        ("eccentricity", "phase"),
        [(0j, 0.0), (1e-4 * np.exp(2.1j), 0.0), (3e-4 * np.exp(-0.4j), 1.2)],
        ids=["bow", "bow and unbalance", "bow with phase"],
    )
    def test_amplitude_and_phase_through_the_critical_speed(self, ratio, eccentricity, phase):
        system = self.rotor(eccentricity, phase)
        bow = self.DELTA * np.exp(1j * phase)
        exact = closed_forms.jeffcott(ratio, bow, eccentricity, self.ZETA)
        found = forward(system, "disk", ratio * self.critical)
        assert abs(found - exact) < self.TOLERANCE * abs(exact)

    def test_phase_changes_by_180_degrees_through_the_critical_speed(self):
        system = self.rotor(0j)
        phases = [np.angle(forward(system, "disk", r * self.critical)) for r in (0.01, 1.0, 20.0)]
        # 2 zeta r / (1 - r^2): 1e-3 rad below, pi/2 at the critical speed, 5e-3 rad from pi far
        # above
        assert phases[0] == pytest.approx(0, abs=2e-3)
        assert phases[1] == pytest.approx(-np.pi / 2, abs=1e-3)
        assert abs(phases[2]) == pytest.approx(np.pi, abs=6e-3)

    @pytest.mark.parametrize("eccentricity", [1e-4, 5e-4])
    def test_opposite_bow_and_unbalance_cancel_at_one_speed(self, eccentricity):
        ratio = np.sqrt(self.DELTA / eccentricity)
        system = self.rotor(eccentricity * np.exp(1j * np.pi))
        peak = abs(forward(system, "disk", self.critical))
        # the remaining difference is the mass of the shaft: 5e-6 relative
        assert abs(forward(system, "disk", ratio * self.critical)) < 1e-4 * peak
        assert abs(forward(system, "disk", 0.9 * ratio * self.critical)) > 1e-2 * self.DELTA

    def test_equal_and_opposite_bow_and_unbalance_cancel_at_the_critical_speed(self):
        lightly = 1e-3  # the resonance factor of the bow is 500
        system = self.rotor(self.DELTA * np.exp(1j * np.pi), zeta=lightly)
        alone = self.rotor(0j, zeta=lightly)
        assert abs(forward(alone, "disk", self.critical)) == pytest.approx(
            self.DELTA / (2 * lightly),
            rel=1e-2,  # shaft mass 5e-6 over damping 2e-3
        )
        # 5e-6 of mass times the resonance factor 500
        assert abs(forward(system, "disk", self.critical)) < 5e-3 * self.DELTA


def test_rigid_body_bow_gives_no_force():
    where = np.linspace(0, 1, 9)
    bent = single_shaft(gb.Bow.half_sine(1e-3), support=1e9)
    scale = max(abs(forward(bent, ("s", x), 300.0)) for x in where)
    rigid = {
        "constant points": gb.Bow.points(where, np.full(9, 1e-3), np.full(9, 0.7)),
        "linear points": gb.Bow.points(where, 1e-3 * where, np.full(9, -2.0)),
        "constant function": gb.Bow.function(lambda _: 1e-3 * np.exp(0.3j)),
        "linear function": gb.Bow.function(lambda x: 1e-3 * (0.2 + 1j * x)),
    }
    for name, bow in rigid.items():
        found = single_shaft(bow, support=1e9).synchronous([300.0])
        worst = max(np.abs(found.displacement(("s", x))).max() for x in where)
        # round-off of K q_b: (12 / pi^4) 8^4 eps = 1e-13 of a bent shaft's force
        assert worst < 1e-10 * scale, name


def test_free_shaft_at_low_speed_follows_its_bow():
    where = np.linspace(0, 1, 9)
    system = single_shaft(gb.Bow.half_sine(BOW, phase=0.5), support=None)
    bow = BOW * np.exp(0.5j) * np.sin(np.pi * where)
    first = 22.3733 * np.sqrt(207e9 * section().moment / (7800.0 * section().area))  # free-free
    strains = []
    for speed in (20.0, 40.0):
        found = np.array([forward(system, ("s", x), speed) for x in where])
        line = np.polynomial.Polynomial.fit(where, found - bow, 1)
        strains.append(np.abs(found - bow - line(where)).max() / BOW)
        # inertia deflects it by the squared ratio of speed and first frequency
        assert strains[-1] < 2 * (speed / first) ** 2
        # and it rotates about its centre of mass: 2/pi of the bow below midspan
        assert found[4] == pytest.approx(BOW * np.exp(0.5j) * (1 - 2 / np.pi), rel=2e-3)
    assert strains[1] / strains[0] == pytest.approx(4, rel=0.05)


def sag(x):
    return 16 / 5 * (x - 2 * x**3 + x**4)  # sag of a uniform shaft on two supports, 1 at midspan


@pytest.mark.parametrize("shear", [False, True])
def test_the_amplitude_of_a_sag_is_its_largest_deflection_between_nodes_too(shear):
    def slow_roll(elements):
        segments = [
            gb.Segment(0.2, 0.035, elements=elements),
            gb.Segment(0.1, 0.05, elements=elements),
            gb.Segment(0.5, 0.035, 0.01, elements=elements),
        ]
        shaft = gb.Shaft("s", segments=segments, bow=gb.Bow.sag(BOW, phase=0.4), shear=shear)
        bearings = [gb.Bearing("s", x, stiffness=1e12) for x in (0.05, 0.78)]
        return forward(gb.RotorSystem([shaft], bearings=bearings), ("s", 0.3), 1.0)

    # the largest deflection is at 0.41 m; one element for the last segment has nodes at 0.3 m and
    # 0.78 m only. Round-off of the stiff bearings leaves 1e-9.
    assert slow_roll(1) == pytest.approx(slow_roll(20), rel=1e-7)


TWO_PLANES = {
    "curve": lambda x: np.sin(np.pi * x) + 0.4j * np.sin(2 * np.pi * x),
}


@pytest.mark.parametrize(
    ("make", "curve"),
    [
        (lambda p: gb.Bow.half_sine(BOW, phase=p), lambda x: np.sin(np.pi * x)),
        (lambda p: gb.Bow.sag(BOW, phase=p), sag),
        (lambda p: gb.Bow.mode(1, BOW, phase=p), lambda x: np.sin(np.pi * x)),
        (lambda p: gb.Bow.mode(3, BOW, phase=p), lambda x: np.sin(3 * np.pi * x)),
        (
            lambda p: gb.Bow.points([0, 0.25, 0.5, 1], BOW * np.array([0, 1, 3, 0]), [p] * 4),
            lambda x: np.select(
                [x == 0.25, x == 0.5], [1, 3], np.nan
            ),  # the closed form holds there only
        ),
        (
            lambda p: gb.Bow.function(lambda x: BOW * np.exp(1j * p) * TWO_PLANES["curve"](x)),
            TWO_PLANES["curve"],
        ),
    ],
    ids=["half_sine", "sag", "mode 1", "mode 3", "points", "function"],
)
@pytest.mark.parametrize("phase", [0.0, 0.9, -2.5])
def test_slow_roll_shows_the_shape(make, curve, phase):
    # on end supports, where every one of these bows is zero, a slow shaft has its stress-free
    # line
    system = single_shaft(make(phase), shear=False, support=1e10)
    for x in np.linspace(0, 1, 9)[1:-1]:
        expected = BOW * np.exp(1j * phase) * curve(x)
        if np.isnan(expected):
            continue
        # (0.01 rad/s over 630)^2 = 2.5e-10, and round-off
        assert abs(forward(system, ("s", float(x)), 0.01) - expected) < 1e-8 * BOW


def test_function_and_points_are_the_same_curve():
    def curve(x):
        return BOW * TWO_PLANES["curve"](x)

    where = np.linspace(0, 1, 33)
    values = np.array([curve(x) for x in where])
    half = single_shaft(gb.Bow.half_sine(BOW))
    second = single_shaft(gb.Bow.mode(2, 0.4 * BOW, phase=np.pi / 2))
    by_function = single_shaft(gb.Bow.function(curve))
    by_points = single_shaft(gb.Bow.points(where, np.abs(values), np.angle(values)))
    for x in (0.125, 0.5, 0.75):
        at = ("s", x)
        exact = forward(half, at, 400.0) + forward(second, at, 400.0)  # two planes, superposed
        assert abs(forward(by_function, at, 400.0) - exact) < 1e-6 * BOW
        # a cubic spline through 33 points: slopes within (2 pi / 32)^4 / 180 = 1e-5
        assert abs(forward(by_points, at, 400.0) - exact) < 3e-5 * BOW


@pytest.mark.filterwarnings(
    "ignore::gearbow.AccuracyWarning"
)  # relative error, for displacements that are not small
@pytest.mark.implausible
def test_response_is_linear_in_the_bow():
    at = ("s", 0.5)
    unit = forward(single_shaft(gb.Bow.half_sine(1.0)), at, 400.0)
    for amplitude in (1e-9, 1e-5, 1e-2):
        found = forward(single_shaft(gb.Bow.half_sine(amplitude)), at, 400.0)
        assert found / amplitude == pytest.approx(unit, rel=1e-12)  # one product more


#: Speeds [rad/s] below and above the first two critical speeds of the uniform shaft.
BETWEEN = np.array([200.0, 550.0, 900.0, 1500.0])
#: Promise of "engineering" for displacements.
PROMISED = 1e-3


def sine_amplitudes(half_waves: int) -> np.ndarray:
    """Return the amplitude over that of a sine bow at each speed."""
    exact = [closed_forms.bowed_shaft(section(), 1.0, speed, half_waves) for speed in BETWEEN]
    return np.array(exact)


@pytest.mark.parametrize("half_waves", range(1, 6))
def test_a_bow_that_is_no_part_of_the_system_is_as_accurate_as_its_own(half_waves: int):
    # The elements of a straight shaft resolve its lowest modes only.
    straight, shape = single_shaft(None, elements=None), gb.Bow.mode(half_waves, 1e-6)
    at, exact = ("s", 0.5 / half_waves), sine_amplitudes(half_waves)
    heated = gb.ThermalBow(at, gain=1.0, time_constant=10.0, shape=shape)
    found = straight.thermal_bow(heated, BETWEEN).response / 1e-6
    assert found == pytest.approx(exact, rel=PROMISED)
    allowed = gb.BowLimit.displacement(at, 1e-5)
    limits = straight.bow_limits("s", BETWEEN, shape=shape, limits=[allowed]).found
    bows = np.array([limit.bow for limit in limits])
    assert bows == pytest.approx(0.5e-5 / np.abs(exact), rel=PROMISED)
    bent = straight.replace(shafts=[replace(straight.shafts[0], bow=shape)])
    own = bent.frequency_response(order=1.0, speeds=BETWEEN, source=gb.ShaftExcitation("s"))
    ahead = [closed_forms.forward_backward(both)[0] for both in own.displacement(at)[:, 0]]
    assert np.array(ahead) / 1e-6 == pytest.approx(exact, rel=PROMISED)


def test_identified_half_waves_are_those_of_the_closed_form():
    straight = single_shaft(None, elements=None)
    bows = np.array([4e-5, -3e-5, 2e-5, 1.5e-5, -1e-5])
    waves, places = np.arange(1, 6), np.array([0.1, 0.3, 0.55])
    # the shape of each half wave is kept, its amplitude changes with the speed
    sines = np.sin(np.pi * np.outer(waves, places))
    amplitudes = np.array([sine_amplitudes(wave) for wave in waves]).T * bows
    measured = gb.Measurement(
        BETWEEN, (amplitudes @ sines).astype(complex), [gb.Probe("s", x) for x in places]
    )
    unknown = gb.unknown.bow("s", shapes=waves.size)
    found = gb.identify(straight, measured, [unknown], noise=1e-9, runout=False)
    assert found.values == pytest.approx(bows, rel=PROMISED)
