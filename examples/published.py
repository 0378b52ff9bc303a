"""Comparison of computed and published values, as a Markdown table.

The files in ``examples/rotors`` describe the rotors of the literature. The functions below define
the systems of the closed-form solutions and of the mesh geometry.
Run with ``python examples/published.py``.
"""

import argparse
import math
import warnings
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

import gearbow as gb

ROTORS = Path(__file__).parent / "rotors"
RPM = math.pi / 30.0
TAU = 2.0 * math.pi
#: Quantities of the rows that the summary prints.
SUMMARY = (
    "damped frequencies at 1500 rpm",
    "critical speeds, forward",
    "Timoshenko beam",
    "response is zero",
    "contact ratio of 25/50 teeth",
)


def row(
    source: str,
    quantity: str,
    published: Sequence[float],
    computed: Iterable[float],
    decimals: int,
) -> str:
    """Return one row of the table; numbers have as many decimals as the published ones."""
    found = list(computed)
    largest = max(abs(c - p) / abs(p) for c, p in zip(found, published, strict=True))
    difference = "< 0.001 %" if largest < 1e-5 else f"{100.0 * largest:.1g} %"
    numbers = (" ".join(f"{x:.{decimals}f}" for x in series) for series in (published, found))
    return " | ".join(["", source, quantity, *numbers, difference, ""]).strip()


def load(name: str) -> gb.RotorSystem:
    """Read a rotor of the literature; the warning for rounded base radii is ignored."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", gb.SceneWarning)
        return gb.RotorSystem.load(ROTORS / f"{name}.toml")


def bisect(f: Callable[[float], float], low: float, high: float) -> float:
    """Find a root of `f` by bisection, to a relative tolerance of 1e-9."""
    sign = f(low) > 0.0
    while high - low > 1e-9 * high:
        middle = (low + high) / 2.0
        low, high = (middle, high) if (f(middle) > 0.0) == sign else (low, middle)
    return low


def rao() -> Iterable[str]:
    """Compare the geared pair; Friswell et al. (2010) print its frequencies."""
    published = [
        *(11.641, 12.284, 17.268, 18.458, 23.956, 37.681, 49.889),
        *(50.861, 56.248, 57.752, 59.188, 63.113, 74.203),
    ]
    # Skip the first mode, the rigid-body rotation of the train.
    computed = load("rao_1998").modes(speed=1500.0 * RPM).frequencies_hz[1 : len(published) + 1]
    source = "geared pair, Rao, Shiau and Chang 1998"
    yield row(source, "damped frequencies at 1500 rpm [Hz]", published, computed, 3)


def nelson() -> Iterable[str]:
    """Compare forward and backward critical speeds of a stepped rotor."""
    campbell = load("nelson_1976").campbell(np.linspace(0.0, 1.1e5, 12) * RPM, count=8)
    published = {"backward": (15470, 46612, 64752), "forward": (17159, 49983, 96457)}
    for whirl, speeds in published.items():
        found = [meeting.speed / RPM for meeting in campbell.criticals if meeting.whirl == whirl]
        computed = found[: len(speeds)]
        quantity = f"critical speeds, {whirl} [rpm]"
        yield row("stepped rotor, Nelson and McVaugh 1976", quantity, speeds, computed, 0)


def friswell() -> Iterable[str]:
    """Compare frequencies of a rotor with two disks, at rest and at 4000 rpm."""
    rotor = load("friswell_2010")
    source = "two disks, Friswell et al. 2010, example 5.9.1"
    at_rest = [86.66, 86.66, 274.31, 274.31, 650.41, 716.78]
    # Skip the first mode, the rigid-body rotation of the rotor.
    computed = TAU * rotor.modes().frequencies_hz[1:7]
    yield row(source, "frequencies at rest [rad/s]", at_rest, computed, 2)
    turning = [85.39, 87.80, 251.78, 294.71, 600.18]
    computed = TAU * rotor.modes(speed=4000.0 * RPM).frequencies_hz[1:6]
    yield row(source, "frequencies at 4000 rpm [rad/s]", turning, computed, 2)


def bowed_shaft() -> Iterable[str]:
    """Compare the synchronous response of a uniform shaft with a half-sine bow, rigid bearings."""
    speeds = (200.0, 400.0, 550.0, 700.0, 1200.0)
    published = {
        True: (1.110278, 1.659201, 4.018446, -4.613847, -0.388232),
        False: (1.109726, 1.654280, 3.964414, -4.733929, -0.390691),
    }
    steel = gb.Material(207e9, 7800.0, poisson_ratio=0.3)
    bow = gb.Bow.half_sine(1e-4)
    source = "bowed shaft between rigid bearings, closed form"
    for shear, numbers in published.items():
        shaft = gb.Shaft(
            "s",
            length=1.0,
            outer_diameter=0.05,
            elements=32,  # an even number: with a node in the middle
            material=steel,
            shear=shear,
            bow=bow,
        )
        bearings = [gb.Bearing("s", x, stiffness=1e13) for x in (0.0, 1.0)]
        system = gb.RotorSystem(shafts=[shaft], bearings=bearings)
        middle = system.synchronous(speeds).displacement(("s", 0.5))[:, 0, 0].real / 1e-4
        beam = "Timoshenko" if shear else "Rayleigh"
        quantity = f"midspan displacement / bow at 200, 400, 550, 700, 1200 rad/s, {beam} beam"
        yield row(source, quantity, numbers, middle, 4)
        if shear:
            frequency = TAU * system.modes(count=1).frequencies_hz
            yield row(source, "first natural frequency [rad/s]", [633.630], frequency, 3)


def jeffcott() -> Iterable[str]:
    """Compare the speed at which bow and opposite unbalance give zero response."""
    bow, eccentricity, mass = 2e-4, 1e-4, 200.0
    shaft = gb.Shaft(
        "s",
        length=1.0,
        outer_diameter=0.05,
        elements=2,  # a shaft without mass needs no higher degree
        material=gb.Material(207e9, 1.0, poisson_ratio=0.3),
        bow=gb.Bow.half_sine(bow),
    )
    rotor = gb.RotorSystem(
        shafts=[shaft],
        bearings=[gb.Bearing("s", x, stiffness=1e8) for x in (0.0, 1.0)],
        disks=[gb.Disk("disk", "s", 0.5, mass, 1.0, 2.0, unbalance=-mass * eccentricity)],
    )

    def whirl(speed: float) -> float:
        return float(rotor.synchronous(speed).displacement("disk")[0, 0, 0].real)

    critical = TAU * float(rotor.modes(count=1).frequencies_hz[0])
    still = bisect(whirl, 1.1 * critical, 2.0 * critical) / critical
    source = "Jeffcott rotor, Nicholas, Gunter and Allaire 1976"
    quantity = "speed / critical speed at which the response is zero, bow = −2 × eccentricity"
    yield row(source, quantity, [math.sqrt(bow / eccentricity)], [still], 5)


def torsion() -> Iterable[str]:
    """Compare torsional frequencies: a free shaft, and two gears with light shafts and a mesh."""
    shaft = gb.Shaft("s", length=1.0, outer_diameter=0.05)
    rod = gb.RotorSystem(shafts=[shaft], motion="torsion")
    published = [n / 2.0 * math.sqrt(207e9 / 2.6 / 7850.0) for n in (1, 2, 3)]
    computed = rod.modes(count=4).frequencies_hz[1:]
    yield row("free shaft, closed form", "torsional frequencies [Hz]", published, computed, 1)

    stiffness, gears = 2e8, {"a": (25, 0.035, 0.003), "b": (50, 0.070, 0.05)}
    weightless = gb.Material(207e9, 1.0, poisson_ratio=0.3)
    system = gb.RotorSystem(
        shafts=[
            gb.Shaft(f"shaft {a}", length=0.1, outer_diameter=0.05, material=weightless)
            for a in gears
        ],
        gears=[
            gb.Gear(
                name,
                f"shaft {name}",
                0.05,
                teeth,
                base_radius=radius,
                mass=1.0,
                diametral_inertia=inertia / 2.0,
                polar_inertia=inertia,
            )
            for name, (teeth, radius, inertia) in gears.items()
        ],
        meshes=[gb.Mesh(*gears, stiffness=stiffness)],
    )
    compliance = sum(radius**2 / inertia for _, radius, inertia in gears.values())
    published = [math.sqrt(stiffness * compliance) / TAU]
    computed = system.modes(count=2).frequencies_hz[1:]
    yield row(
        "two gears and their mesh, closed form", "torsional frequency [Hz]", published, computed, 2
    )


def pair(
    teeth: tuple[int, int],
    module: float,
    torque: float = 0.0,
    stiffness: float | gb.Stiffness = 2e8,
) -> gb.RotorSystem:
    """Return two gears on rigid shafts; each shaft has a total bearing stiffness of 2e8 N/m."""
    names = ("a", "b")
    rigid = gb.Material(1e15, 7850.0, poisson_ratio=0.3)
    return gb.RotorSystem(
        shafts=[
            gb.Shaft(f"shaft {name}", length=0.1, outer_diameter=0.2, material=rigid)
            for name in names
        ],
        gears=[
            gb.Gear(name, f"shaft {name}", 0.05, z, module=module, face_width=0.03)
            for name, z in zip(names, teeth, strict=True)
        ],
        meshes=[gb.Mesh(*names, stiffness=stiffness)],
        bearings=[
            gb.Bearing(f"shaft {name}", x, stiffness=1e8) for name in names for x in (0.0, 0.1)
        ],
        torques=[gb.Torque("a", torque), gb.Torque.balance("b")],
    )


def mesh() -> Iterable[str]:
    """Compare contact ratio, stiffness, pressure angle and their change with centre distance."""
    source = "involute pair, closed form"
    ratio = {
        z: pair(z, module).static().mesh("a/b").contact_ratio
        for z, module in (((25, 50), 3e-3), ((62, 62), 2e-3))
    }
    yield row(source, "contact ratio of 25/50 teeth", [1.68316], [ratio[25, 50]], 5)
    yield row(source, "contact ratio of 62/62 teeth", [1.7897799], [ratio[62, 62]], 7)

    # Divide by the face width of 30 mm; N/m² to N/(mm µm).
    standard = pair((25, 50), 3e-3, stiffness=gb.Stiffness.iso6336()).static().mesh("a/b")
    quantity = "mesh stiffness of 25/50 teeth [N/(mm µm)]"
    yield row("ISO 6336-1, method B", quantity, [20.64], [standard.stiffness / 0.03 / 1e9], 2)

    # Central difference: the torque moves the centres apart, the opposite torque together.
    torque, distance, alpha = 10.0, 0.1125, math.radians(20.0)
    apart, together = (
        pair((25, 50), 3e-3, sign * torque).static(speed=1.0).mesh("a/b") for sign in (1.0, -1.0)
    )
    moved = apart.centre_distance - together.centre_distance
    pitch = math.pi * 3e-3 * math.cos(alpha)
    slope = (apart.contact_ratio - together.contact_ratio) / moved
    quantity = "change of contact ratio per centre distance, 25/50 teeth [1/m]"
    yield row(source, quantity, [-1.0 / (pitch * math.sin(alpha))], [slope], 2)
    slope = (apart.pressure_angle - together.pressure_angle) / moved
    quantity = "change of pressure angle per centre distance, 25/50 teeth [rad/m]"
    yield row(source, quantity, [1.0 / (distance * math.tan(alpha))], [slope], 4)
    force = torque / (distance / 3.0 * math.cos(alpha))
    separation = 2.0 * force * math.sin(alpha) / 2e8
    quantity = "static increase of the centre distance under 10 N m [µm]"
    yield row(source, quantity, [1e6 * separation], [5e5 * moved], 5)


def helical() -> Iterable[str]:
    """Compare two rigid helical gears on springs, whose mesh is a rank-one update.

    Every frequency solves 1 + k Σ n_i²/(k_i − m_i ω²) = 0 over the twelve coordinates, with the
    unit normal n at the pitch point and its moments.
    """
    published = [
        *(453.350, 546.574, 562.698, 803.762, 918.881, 918.881),
        *(1429.359, 1837.763, 2182.997, 2250.791, 4031.408),
    ]
    helix = math.radians(20.0)
    bodies = {"a": (25, helix, 1.5, 1e-3, 1.8e-3), "b": (50, -helix, 6.0, 1.6e-2, 3e-2)}
    # Shafts with almost no mass and stiffness.
    nothing = gb.Material(youngs_modulus=1e5, density=1e-6, poisson_ratio=0.3)
    shaft: dict[str, Any] = {"length": 0.02, "outer_diameter": 0.05, "elements": 1, "degree": 1}
    springs: dict[str, Any] = {"stiffness": 2e8, "axial_stiffness": 5e7, "tilting_stiffness": 2e5}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", gb.SceneWarning)
        system = gb.RotorSystem(
            shafts=[gb.Shaft(name, **shaft, material=nothing) for name in bodies],
            gears=[
                gb.Gear(
                    f"gear {name}",
                    name,
                    0.01,
                    teeth,
                    module=3e-3,
                    helix_angle=angle,
                    mass=mass,
                    diametral_inertia=diametral,
                    polar_inertia=polar,
                )
                for name, (teeth, angle, mass, diametral, polar) in bodies.items()
            ],
            meshes=[gb.Mesh("gear a", "gear b", stiffness=3e8)],
            bearings=[gb.Bearing(name, 0.01, **springs) for name in bodies],
        )
    # The first mode is the rigid-body rotation; the last ones are those of the shafts.
    computed = system.modes(count=12).frequencies_hz[1:]
    yield row("rank-one update", "two helical gears on springs [Hz]", published, computed, 3)


def journals() -> Iterable[str]:
    """Compare the coefficients of a short and of a finite journal bearing with two grooves."""
    options: dict[str, Any] = {"diameter": 0.1, "length": 0.03, "clearance": 1e-4, "viscosity": 0.1}
    film = gb.JournalBearing("s", 0.0, **options).coefficients(525.0, 1500.0 * RPM)
    source = "short journal bearing, Friswell et al. 2010"
    yield row(source, "eccentricity ratio", [0.266298], [film.eccentricity_ratio], 6)
    published = (12.80796, 16.393593, -25.060393, 8.815303)
    quantity = "stiffness across and along the load [MN/m]"
    yield row(source, quantity, published, film.stiffness.ravel() / 1e6, 5)
    published = (232.89693, -81.924371, -81.924371, 294.911619)
    yield row(source, "damping [kN s/m]", published, film.damping.ravel() / 1e3, 4)

    # S = μNLD/W (R/c)² determines the load W at a speed of N turns per second.
    turns, sommerfeld, clearance = 50.0, 0.580, 1e-4
    load = 0.05 * turns * 0.05 * 0.1 / sommerfeld * (0.05 / clearance) ** 2
    grooves = [(0.0, math.radians(20.0)), (math.pi, math.radians(20.0))]
    options = {"diameter": 0.1, "length": 0.05, "clearance": clearance, "viscosity": 0.05}
    bearing = gb.JournalBearing("s", 0.0, **options, film="finite", grooves=grooves)
    film = bearing.coefficients(load, TAU * turns)
    source = "finite journal bearing, L/D 0.5, Lund and Thomsen 1978"
    yield row(source, "eccentricity ratio at S = 0.580", [0.477], [film.eccentricity_ratio], 3)
    angle = math.degrees(film.attitude_angle)
    yield row(source, "attitude angle [degrees]", [51.01], [angle], 2)
    # x is along the load, y is ahead of it by the rotation.
    turn = np.array([[0.0, -1.0], [1.0, 0.0]])
    stiffness = (turn @ film.stiffness @ turn.T).ravel() * clearance / load
    quantity = "stiffness xx, xy, yx, yy × c/W, x along the load"
    yield row(source, quantity, (2.67, 3.70, -0.78, 1.75), stiffness, 2)
    damping = (turn @ film.damping @ turn.T).ravel()[[0, 1, 3]] * clearance * TAU * turns / load
    yield row(source, "damping xx, xy, yy × cΩ/W", (6.96, 1.94, 2.40), damping, 2)

    # The table was read without the extent of its pads; with 80° the eccentricities agree.
    pads: dict[str, Any] = {"pad_count": 4, "pad_extent": math.radians(80.0), "preload": 0.0}
    four = gb.TiltingPadBearing("s", 0.0, **options, **pads, reduced="synchronous")
    numbers = np.array([0.756, 0.381, 0.168, 0.0576])
    loads = load * sommerfeld / numbers
    films = [four.coefficients(each, TAU * turns) for each in loads]
    source = "four tilting pads, L/D 0.5, load between pads, Someya 1989"
    found = np.array([film.eccentricity_ratio for film in films])
    quantity = "eccentricity ratio at S = 0.756, 0.381, 0.168, 0.0576"
    yield row(source, quantity, (0.5, 0.7, 0.9, 1.1), found, 3)
    found = np.array([film.stiffness[1, 1] for film in films]) * clearance / loads
    yield row(source, "stiffness × c/W", (1.94, 2.65, 3.72, 5.63), found, 2)
    found = np.array([film.damping[1, 1] for film in films]) * clearance * TAU * turns / loads
    yield row(source, "damping × cΩ/W", (3.33, 3.06, 2.97, 3.11), found, 2)


def rolling() -> Iterable[str]:
    """Compare deflections and contact forces of rolling bearings."""
    sizes: dict[str, Any] = {"element_diameter": 0.0127, "pitch_diameter": 0.065, "clearance": 0.0}
    # Sjövall's integral J_r(0.5) is the load over n times the largest contact force.
    given = {"elements": 15, "hertz_stiffness": 1e10, **sizes}
    bearing = gb.RollingBearing("s", 0.0, **given)
    deflection = -bearing.coefficients(1000.0).displacement[1]
    integral = 1000.0 / (15 * 1e10 * deflection**1.5)
    source = "ball bearing without clearance"
    yield row(source, "Sjövall's integral, Harris 2001", [0.2288], [integral], 4)
    largest = bearing.coefficients(1000.0, cage_angle=math.pi / 2.0).contact_forces.max()
    quantity = "largest contact force of 15 balls × n/F, Stribeck"
    yield row(source, quantity, [4.37], [15 * largest / 1000.0], 2)


def main() -> None:
    """Print the table, or with ``--summary`` one row of each kind of comparison."""
    parser = argparse.ArgumentParser(description="Compare gearbow with published values.")
    parser.add_argument("--summary", action="store_true", help="print five rows only")
    summary: bool = parser.parse_args().summary
    print("| source | quantity | published | computed | largest difference |")
    print("|---|---|---|---|---|")
    for rows in (
        *(rao, nelson, friswell, bowed_shaft, jeffcott, torsion, mesh, helical, journals, rolling),
    ):
        for printed in rows():
            if not summary or any(quantity in printed for quantity in SUMMARY):
                print(printed)


if __name__ == "__main__":
    main()
