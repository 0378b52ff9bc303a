"""Comparison with the cases that books and other programs publish to verify a program, as Markdown.

``python examples/verification.py`` prints the table of cases that were computed elsewhere, with
``--measured`` the table of rotors that were measured. Every function states the source of its data.
Nothing is fitted.
"""

import argparse
import math
import warnings
from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import Any

import gearbow as gb
from published import RPM, TAU, load, row

#: Stiffness of a rigid mesh over that of the stiffest spring; a larger one costs digits.
_RIGID = 1e6
#: Steel of the examples of Friswell et al.
FRISWELL_STEEL = gb.Material(211e9, 7810.0, shear_modulus=81.2e9)


def system(**parts: Any) -> gb.RotorSystem:
    """Build a system; warnings of unusual sizes are ignored, for the models are idealised."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", gb.SceneWarning)
        return gb.RotorSystem(**parts)


def vibrations(
    rotor: gb.RotorSystem, speed: float, count: int
) -> tuple[Sequence[float], Sequence[float]]:
    """Return damped frequencies [Hz] and damping ratios of the lowest vibrations."""
    modes = rotor.modes(speed=speed, vibrating=True)
    return modes.frequencies_hz[:count].tolist(), modes.damping_ratios[:count].tolist()


def percent(ratios: Sequence[float]) -> list[float]:
    """Return ratios in percent."""
    return [100.0 * ratio for ratio in ratios]


def two_disks(**bearing: Any) -> gb.RotorSystem:
    """Return the rotor of example 5.9.1 of Friswell et al. on other bearings."""
    bearings = [gb.Bearing("shaft", x, **bearing) for x in (0.0, 1.5)]
    return load("friswell_2010").replace(bearings=bearings)


def friswell() -> Iterable[str]:
    """Compare rotors with two disks on several bearings, and an overhung rotor.

    Friswell, Penny, Garvey and Lees, Dynamics of rotating machines (2010), as quoted by the tests
    of ROSS (ross/tests/test_examples.py).
    """
    unequal = two_disks(stiffness=(1e6, 8e5))
    source = "Friswell et al. 2010, example 5.9.2: unequal bearings"
    rest = [82.65, 86.66, 254.52, 274.31, 650.41, 679.49]
    turning = [82.33, 86.86, 239.64, 287.25, 583.49, 650.41]
    for name, speed, published in (("at rest", 0.0, rest), ("at 4000 rpm", 4000.0, turning)):
        found, _ = vibrations(unequal, speed * RPM, 6)
        quantity = f"frequencies {name} [rad/s]"
        yield row(source, quantity, published, [TAU * f for f in found], 2)

    found, _ = vibrations(two_disks(stiffness=(1e6, 2e5)), 4000.0 * RPM, 6)
    source = "Friswell et al. 2010, example 5.9.3: mixed modes"
    published = [8.545, 13.77, 22.35, 44.06, 78.76]
    yield row(source, "frequencies at 4000 rpm [Hz]", published, found[:5], 3)

    # The test of ROSS quotes these values for 4000 rpm, with a tolerance of 100 %.
    found, _ = vibrations(two_disks(stiffness=((1e6, 5e5), (5e5, 1e6))), 0.0, 7)
    source = "Friswell et al. 2010, example 5.9.4: cross-coupled bearings"
    published = [11.66, 14.80, 33.97, 49.19, 97.97, 126.61]
    yield row(source, "frequencies at rest [Hz]", published, [*found[:5], found[6]], 2)

    damped = two_disks(stiffness=1e6, damping=3e3)
    source = "Friswell et al. 2010, example 5.9.5: damped bearings"
    for name, speed, published in (
        ("at rest", 0.0, [13.89, 13.89, 46.54, 46.54]),
        ("at 4000 rpm", 4000.0, [13.68, 14.07, 41.98, 50.65]),
    ):
        found, _ = vibrations(damped, speed * RPM, 4)
        yield row(source, f"damped frequencies {name} [Hz]", published, found, 2)

    radius, bore, width = 0.175, 0.025, 0.07
    mass = math.pi * (radius**2 - bore**2) * width * 7810.0
    square = radius**2 + bore**2
    overhung = system(
        shafts=[
            gb.Shaft("shaft", length=1.5, outer_diameter=0.05, elements=6, material=FRISWELL_STEEL)
        ],
        disks=[
            gb.Disk("d", "shaft", 1.5, mass, mass * (square / 4 + width**2 / 12), mass * square / 2)
        ],
        bearings=[gb.Bearing("shaft", x, stiffness=1e7) for x in (0.0, 1.0)],
    )
    source = "Friswell et al. 2010, example 5.9.9: overhung rotor"
    rest = [90.14, 90.14, 630.73, 630.73, 830.43, 830.43]
    turning = [76.19, 103.91, 565.99, 634.23, 647.75]
    for name, speed, published in (("at rest", 0.0, rest), ("at 4000 rpm", 4000.0, turning)):
        found, _ = vibrations(overhung, speed * RPM, len(published))
        quantity = f"frequencies {name} [rad/s]"
        yield row(source, quantity, published, [TAU * f for f in found], 2)


def axial_force() -> Iterable[str]:
    """Compare the rotor with two disks under axial forces.

    Friswell et al., example 5.9.7, as example 22 of the documents of ROSS computes it: six
    elements, on isotropic bearings.
    """
    rotor = two_disks(stiffness=1e6)
    source = "Friswell et al. 2010, example 5.9.7: axial force"
    for kilonewtons, published in (
        (10, [13.936, 43.913, 114.760]),
        (100, [15.020, 46.132, 120.620]),
        (-10, [13.643, 43.402, 113.395]),
    ):
        shafts = [replace(rotor.shafts[0], axial_force=1e3 * kilonewtons)]
        found, _ = vibrations(rotor.replace(shafts=shafts, motion="lateral"), 0.0, 6)
        quantity = f"frequencies at rest with {kilonewtons} kN [Hz]"
        yield row(source, quantity, published, found[::2], 3)


def oil_film() -> Iterable[str]:
    """Compare the coefficients of a short bearing.

    Friswell et al., example 5.5.1, whose bearings are those of example 5.9.6, as quoted by the
    tests of ROSS (ross/tests/test_bearing_seal_element.py). There, x is across the load.
    """
    bearing = gb.JournalBearing(
        "shaft", 0.0, diameter=0.1, length=0.03, clearance=1e-4, viscosity=0.1
    )
    film = bearing.coefficients(load=525.0, speed=1500.0 * RPM)
    source = "Friswell et al. 2010, examples 5.5.1 and 5.9.6: short bearings"
    yield row(source, "eccentricity ratio", [0.266298], [film.eccentricity_ratio], 6)
    stiffness = [12.80796, 16.393593, -25.060393, 8.815303]
    found = (1e-6 * film.stiffness).ravel().tolist()
    yield row(source, "stiffness xx, xy, yx, yy [MN/m]", stiffness, found, 4)
    damping = [232.89693, -81.924371, -81.924371, 294.911619]
    found = (1e-3 * film.damping).ravel().tolist()
    yield row(source, "damping xx, xy, yx, yy [kN s/m]", damping, found, 3)


def internal_damping() -> Iterable[str]:
    """Compare the speeds from which internal damping makes a rotor unstable.

    Zorzi and Nelson, Finite element simulation of rotor-bearing systems with internal damping
    (1977), in the ANSYS verification manual as VM261.
    """
    shaft = gb.Shaft(
        "shaft",
        length=1.27,
        outer_diameter=0.1016,
        shear=False,
        internal_damping=2e-4,
        material=gb.Material(2.1e11, 7800.0, poisson_ratio=0.3),
    )
    bearings = [gb.Bearing("shaft", x, stiffness=1.75e7) for x in (0.0, 1.27)]
    rotor = system(shafts=[shaft], bearings=bearings, motion="lateral")
    campbell = rotor.campbell([50.0 * i for i in range(27)], count=4)
    found = [one.speed / RPM for one in campbell.thresholds if one.above == "unstable"]
    source = "beam with internal damping, Zorzi and Nelson, in ANSYS VM261"
    yield row(source, "forward critical speeds, thresholds [rpm]", [5000.2, 10523.0], found, 1)


def code_aster() -> Iterable[str]:
    """Compare a rotor with three disks on damped bearings.

    Code_Aster, test case SDLL124 (astest/sdll124a.comm and .mail): the external reference that the
    test states, for the rotor of Lalanne and Ferraris, and the values of Code_Aster itself.
    """
    steel = gb.Material(2e11, 7800.0, poisson_ratio=0.3)
    disks = (
        (0.2, 14.58013, 0.06463858, 0.1232021),
        (0.5, 45.94579, 0.4977461, 0.9763481),
        (1.0, 55.13495, 0.6023493, 1.171618),
    )
    rotor = system(
        shafts=[gb.Shaft("shaft", length=1.3, outer_diameter=0.1, elements=13, material=steel)],
        disks=[gb.Disk(f"disk at {x}", "shaft", x, *data) for x, *data in disks],
        bearings=[
            gb.Bearing("shaft", x, stiffness=(7e7, 5e7), damping=(700.0, 500.0)) for x in (0.0, 1.3)
        ],
    )
    frequencies, ratios = vibrations(rotor, 0.0, 4)
    source = "three disks, Lalanne and Ferraris, in Code_Aster SDLL124"
    published = [60.6148, 63.0260, 169.4900, 185.5630]
    yield row(source, "damped frequencies at rest [Hz]", published, frequencies, 3)
    published = [0.050328, 0.039882, 0.31232, 0.28533]
    yield row(source, "damping ratios at rest [%]", published, percent(ratios), 4)
    frequencies, ratios = vibrations(rotor, 30000.0 * RPM, 4)
    published = [54.112, 68.122, 154.650, 196.000]
    yield row(source, "damped frequencies at 30000 rpm [Hz]", published, frequencies, 3)
    published = [0.026624, 0.065256, 0.30442, 0.27612]
    yield row(source, "damping ratios at 30000 rpm [%]", published, percent(ratios), 4)
    source = "the same, computed by Code_Aster"
    published = [54.07759, 68.08303, 154.26899, 195.65561]
    yield row(source, "damped frequencies at 30000 rpm [Hz]", published, frequencies, 3)
    published = [0.0262739, 0.0655325, 0.308984, 0.270655]
    yield row(source, "damping ratios at 30000 rpm [%]", published, percent(ratios), 4)


def turbine_generator() -> Iterable[str]:
    """Compare the torsional modes of six rotors in line.

    IEEE Subsynchronous Resonance Task Force, First benchmark model for computer simulation of
    subsynchronous resonance, IEEE Trans. Power Apparatus and Systems 96 (1977) 1565: inertia
    constants [s] and stiffnesses [torque/rad] relative to 892.4 MVA at 60 Hz.
    """
    power, speed = 892.4e6, TAU * 60.0
    inertia_constants = {
        "HP": 0.092897,
        "IP": 0.155589,
        "LPA": 0.858670,
        "LPB": 0.884215,
        "GEN": 0.868495,
        "EXC": 0.0342165,
    }
    stiffnesses = (19.303, 34.929, 52.038, 70.858, 2.822)
    # Each rotor is a disk on a short shaft of 1 kg/m³, whose inertia is below 1e-4 of the disk's.
    light = gb.Material(207e9, 1.0, poisson_ratio=0.3)
    inertias = {
        name: 2.0 * constant * power / speed**2 for name, constant in inertia_constants.items()
    }
    names = list(inertias)
    line = system(
        motion="torsion",
        shafts=[gb.Shaft(name, length=0.1, outer_diameter=0.1, material=light) for name in names],
        disks=[
            gb.Disk(f"rotor {name}", name, 0.05, 1.0, inertia / 2.0, inertia)
            for name, inertia in inertias.items()
        ],
        couplings=[
            gb.Coupling(f"rotor {a}", f"rotor {b}", torsional_stiffness=stiffness * power / speed)
            for a, b, stiffness in zip(names, names[1:], stiffnesses, strict=False)
        ],
    )
    with warnings.catch_warnings():
        # The short shafts vibrate at 1e6 times the lowest frequency: round-off of 2e-5.
        warnings.simplefilter("ignore", gb.AccuracyWarning)
        found = line.modes(count=6).frequencies_hz[1:]
    source = "turbine generator, IEEE first benchmark model 1977"
    published = [15.71, 20.21, 25.55, 32.28, 47.46]
    yield row(source, "torsional frequencies [Hz]", published, found, 2)


def wind_turbine() -> Iterable[str]:
    """Compare the free torsional mode of a drive train.

    Jonkman, Butterfield, Musial and Scott, Definition of a 5-MW reference wind turbine,
    NREL/TP-500-38060 (2009): generator 534.116 kg m² behind a gear of ratio 97, spring
    867.637 MN m/rad, damper 6.215 MN m s/rad. Control programs for this turbine
    have 38,759,228 kg m² for its rotor.
    """
    rotor, generator = 38_759_228.0, 534.116 * 97.0**2
    light = gb.Material(207e9, 1.0, poisson_ratio=0.3)
    train = system(
        motion="torsion",
        shafts=[
            gb.Shaft(name, length=0.5, outer_diameter=0.5, material=light)
            for name in ("rotor", "generator")
        ],
        disks=[
            gb.Disk(f"{name} disk", name, 0.25, 1.0, inertia / 2.0, inertia)
            for name, inertia in (("rotor", rotor), ("generator", generator))
        ],
        couplings=[
            gb.Coupling(
                "rotor disk",
                "generator disk",
                torsional_stiffness=867.637e6,
                torsional_damping=6.215e6,
            )
        ],
    )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", gb.AccuracyWarning)
        (damped,), (ratio,) = vibrations(train, 0.0, 1)
    source = "NREL 5 MW drive train, Jonkman et al. 2009"
    undamped = damped / math.sqrt(1.0 - ratio**2)
    yield row(source, "undamped torsional frequency [Hz]", [2.2227], [undamped], 4)
    yield row(source, "damping ratio [%]", [5.0], percent([ratio]), 2)


def torsional_train(
    inertias: dict[str, float],
    springs: dict[tuple[str, str], float],
    teeth: dict[tuple[str, str], tuple[int, int]],
) -> gb.RotorSystem:
    """Return bodies [kg m²] joined by springs [N m/rad] and by rigid pairs of gears.

    Each body is a disk on a light shaft, where its gears are. Base radii are in proportion to the
    numbers of teeth.
    """
    light = gb.Material(207e9, 1.0, poisson_ratio=0.3)
    scale = 1e-4  # m for each tooth
    radius = scale * min((number for numbers in teeth.values() for number in numbers), default=1)
    rigid = _RIGID * max(springs.values()) / radius**2
    meshes, gears = [], {}
    for pair, numbers in teeth.items():
        for body, number in zip(pair, numbers, strict=True):
            # The inertia of a gear is that of its body; round-off needs one above zero.
            gears[body] = gb.Gear(
                f"gear {body}",
                body,
                0.05,
                number,
                base_radius=scale * number,
                face_width=0.1,
                mass=1.0,
                diametral_inertia=1.0,
                polar_inertia=1e-9 * max(inertias.values()),
            )
        meshes.append(gb.Mesh(f"gear {pair[0]}", f"gear {pair[1]}", stiffness=rigid))
    bodies = {name: inertia for name, inertia in inertias.items() if inertia > 0.0}

    def place(name: str) -> str:
        return f"body {name}" if name in bodies else f"gear {name}"

    return system(
        motion="torsion",
        shafts=[
            gb.Shaft(name, length=0.1, outer_diameter=0.01, elements=1, material=light)
            for name in inertias
        ],
        disks=[
            gb.Disk(f"body {name}", name, 0.05, 1.0, inertia / 2.0, inertia)
            for name, inertia in bodies.items()
        ],
        gears=list(gears.values()),
        meshes=meshes,
        couplings=[
            gb.Coupling(place(a), place(b), torsional_stiffness=stiffness)
            for (a, b), stiffness in springs.items()
        ],
    )


def geared_trains() -> Iterable[str]:
    """Compare torsional frequencies of trains with gears.

    Gunter and Chen, Introduction to dynamics of rotor-bearing systems (2001), example 8.1: a
    propeller that two turbines drive over double reduction gears. Data: openTorsion,
    examples/marine_steam_turbine_forced_response.py; the examples of Friswell et al. (2010) are
    those of its opentorsion/tests/tests.py.
    """
    unit = 0.112985  # N m in lbf in
    marine = torsional_train(
        {
            "propeller": 2.454e6 * unit,
            "bull": 0.826e6 * unit,
            "high pinion": 0.0,
            "high wheel": 2.723e4 * unit,
            "high turbine pinion": 0.0,
            "high turbine": 2.612e2 * unit,
            "low pinion": 0.0,
            "low wheel": 1.283e4 * unit,
            "low turbine pinion": 0.0,
            "low turbine": 1.509e4 * unit,
        },
        {
            ("propeller", "bull"): 826e6 * unit,
            ("high pinion", "high wheel"): 24.17e6 * unit,
            ("high turbine pinion", "high turbine"): 14.26e6 * unit,
            ("low pinion", "low wheel"): 203.94e6 * unit,
            ("low turbine pinion", "low turbine"): 30.51e6 * unit,
        },
        # The high- and the low-pressure turbine turn 78.2365 and 40.0424 times as fast as the
        # propeller, their intermediate shafts 9.4094 times.
        {
            ("bull", "high pinion"): (47047, 5000),
            ("high wheel", "high turbine pinion"): (41573, 5000),
            ("bull", "low pinion"): (47047, 5000),
            ("low wheel", "low turbine pinion"): (21278, 5000),
        },
    )
    source = "marine steam turbine, Gunter and Chen 2001, example 8.1"
    published = [177.71, 220.18, 1282.58, 2496.87, 2883.38]
    yield row(source, "torsional frequencies [1/min]", published, torsional(marine, 5, 60.0), 2)

    bodies = {"motor": 400e-6, "pinion": 25e-6, "wheel": 25e-6, "left": 700e-6, "right": 700e-6}
    equal = torsional_train(
        bodies,
        {("motor", "pinion"): 1e4, ("wheel", "left"): 5e3, ("pinion", "right"): 5e3},
        {("pinion", "wheel"): (50, 50)},
    )
    source = "Friswell et al. 2010, chapter 9: equal gears between three bodies"
    quantity = "torsional frequencies [Hz]"
    yield row(source, quantity, [425.4, 634.1, 3247.2], torsional(equal, 3, 1.0), 1)

    modulus = 68e9

    def stiffness(length: float, diameter: float) -> float:
        return modulus * math.pi * diameter**4 / 32.0 / length

    driven = stiffness(3.5, 0.25)
    branched = torsional_train(
        {"drive": 3200.0, "a": 200.0, "b": 200.0, "c": 800.0, "d": 800.0, "e": 450.0, "f": 450.0},
        {("drive", "a"): stiffness(2.5, 0.2), ("c", "e"): driven, ("d", "f"): driven},
        {("a", "b"): (50, 50), ("a", "c"): (50, 80), ("b", "d"): (50, 80)},
    )
    source = "Friswell et al. 2010, example 9.6.3: branched gears"
    yield row(source, quantity, [10.304, 20.479, 24.423], torsional(branched, 3, 1.0), 3)

    line = torsional_train(
        {"1": 3.5e-3, "2": 3.5e-3, "3": 3.5e-3, "4": 0.15, "5": 0.05},
        {("1", "2"): 12e3, ("2", "3"): 12e3, ("3", "4"): 14e3, ("4", "5"): 10e3},
        {},
    )
    source = "Friswell et al. 2010, example 9.7.1: five bodies in line"
    yield row(source, quantity, [81.21, 141.21, 378.95, 536.36], torsional(line, 4, 1.0), 2)


def torsional(train: gb.RotorSystem, count: int, factor: float) -> list[float]:
    """Return the lowest elastic frequencies, in Hz times a factor."""
    with warnings.catch_warnings():
        # Rigid meshes and light gears vibrate far above these frequencies.
        warnings.simplefilter("ignore", gb.AccuracyWarning)
        found = train.modes(count=count + 1).frequencies_hz
    return [factor * frequency for frequency in found if frequency > 1e-3][:count]


def flexible_rotor() -> Iterable[str]:
    """Compare a thin shaft with two disks in housings on leaf springs, at rest.

    Santos, Machinery dynamics lectures 41514, Technical University of Denmark (2017), published
    with the measured frequencies in github.com/jacoboesterby/RotorDynamics, FreeShaft.m. Two leaf
    springs carry each housing: they bend horizontally, and are stretched vertically.
    """
    steel = gb.Material(2e11, 7800.0, poisson_ratio=0.3)
    thickness, width, length = 1e-3, 28.5e-3, 75e-3
    horizontal = 2.0 * 12.0 * 2e11 * (width * thickness**3 / 12.0) / length**3
    vertical = 2.0 * 2e11 * width * thickness / length
    radius, breadth = 0.06, 0.011
    mass = math.pi * radius**2 * breadth * 2770.0
    diametral = mass * (radius**2 / 4.0 + breadth**2 / 12.0)
    disk = (mass, diametral, mass * radius**2 / 2.0)
    # The housings do not turn, and do not tilt with the shaft.
    housing = (0.40698, 1e-12, 1e-12)

    def frequencies(stiffness: float, count: int) -> list[float]:
        """Return frequencies of one plane; bearings of one stiffness give each twice."""
        rotor = system(
            shafts=[gb.Shaft("shaft", length=0.435, outer_diameter=5e-3, material=steel)],
            disks=[
                gb.Disk("housing 1", "shaft", 0.0, *housing),
                gb.Disk("disk 1", "shaft", 0.140, *disk),
                gb.Disk("disk 2", "shaft", 0.345, *disk),
                gb.Disk("housing 2", "shaft", 0.435, *housing),
            ],
            bearings=[gb.Bearing("shaft", x, stiffness=stiffness) for x in (0.0, 0.435)],
            motion="lateral",
        )
        found, _ = vibrations(rotor, 0.0, 2 * count)
        return list(found[::2])

    source = "two disks on a thin shaft, Santos, DTU 2017"
    quantity = "horizontal frequencies [Hz]"
    yield row(source, quantity, [13.0, 33.6, 43.0], frequencies(horizontal, 3), 1)
    yield row(source, "vertical frequencies [Hz]", [14.9, 46.0], frequencies(vertical, 2), 1)


def main() -> None:
    """Print one of the two tables."""
    parser = argparse.ArgumentParser(description="Compare gearbow with verification cases.")
    parser.add_argument("--measured", action="store_true", help="print the measured rotors")
    measured: bool = parser.parse_args().measured
    known = "measured" if measured else "published"
    print(f"| source | quantity | {known} | computed | largest difference |")
    print("|---|---|---|---|---|")
    computed = (
        friswell,
        axial_force,
        oil_film,
        internal_damping,
        code_aster,
        turbine_generator,
        wind_turbine,
        geared_trains,
    )
    for rows in (flexible_rotor,) if measured else computed:
        for printed in rows():
            print(printed)


if __name__ == "__main__":
    main()
