"""A rotor of ROSS in gearbow: frequencies and damping ratios of both programs.

``python examples/from_ross.py`` reads the rotor and the modes that ROSS wrote into
``examples/ross_files``. With ``--write`` it makes both files again, which needs ROSS
(``pip install "ross-rotordynamics>=2.3,<3"``).
"""

import argparse
from pathlib import Path
from typing import Any

import numpy as np

import gearbow as gb

FILES = Path(__file__).parent / "ross_files"
#: The rotor, and its lateral modes: speed [rad/s], frequency [Hz] and damping ratio.
ROTOR, MODES = FILES / "rotor.toml", FILES / "modes.csv"
#: Speeds [rad/s], those of the bearing tables among them.
SPEEDS = (0.0, 200.0, 500.0)
#: Number of compared modes.
COUNT = 8


def rotor_of_ross() -> Any:
    """Make a stepped rotor with all kinds of elements that gearbow reads."""
    import ross  # noqa: PLC0415

    steel = ross.Material("steel", rho=7810.0, E=211e9, G_s=81.2e9)
    steps = [(0.10, 0.05, 0.0)] * 2 + [(0.12, 0.07, 0.02)] * 3 + [(0.10, 0.05, 0.0)] * 2
    shaft = [
        ross.ShaftElement(L=length, idl=bore, odl=diameter, material=steel, n=n)
        for n, (length, diameter, bore) in enumerate(steps)
    ]
    disks = [
        ross.DiskElement(n=2, m=15.0, Id=0.09, Ip=0.17, tag="impeller 1"),
        ross.DiskElement(n=5, m=22.0, Id=0.15, Ip=0.28, tag="impeller 2"),
    ]
    bearings = [
        ross.BearingElement(
            n=0,
            kxx=np.array([4e7, 5e7, 8e7]),
            kyy=np.array([5e7, 6e7, 9e7]),
            kxy=np.array([1e6, 2e6, 4e6]),
            kyx=np.array([-1e6, -2e6, -4e6]),
            cxx=np.array([3e3, 2e3, 1e3]),
            frequency=np.array(SPEEDS),
            tag="journal",
        ),
        ross.BearingElement(n=7, n_link=8, kxx=6e7, cxx=1e3, tag="ball"),
        ross.BearingElement(n=8, kxx=2e8, kyy=3e8, cxx=500.0, tag="pedestal"),
    ]
    seals = [ross.SealElement(n=4, kxx=1e6, kxy=3e5, kyx=-3e5, cxx=200.0, tag="labyrinth")]
    masses = [
        ross.PointMass(n=0, m=1.5, tag="hub"),
        ross.PointMass(n=8, m=8.0, tag="pedestal mass"),
    ]
    return ross.Rotor(shaft, disks, [*bearings, *seals], masses)


def modes_of_ross(rotor: Any) -> np.ndarray:
    """Give speed [rad/s], damped frequency [Hz] and damping ratio of the lateral modes."""
    n = rotor.number_dof
    # A node has the coordinates x, y, z and the rotations about them; a node beyond the shaft has
    # x and y alone.
    nodes = rotor.nodes
    on_shaft = [i for k in range(len(nodes)) for i in (n * k, n * k + 1, n * k + 3, n * k + 4)]
    extra = [i for i in range(n * len(nodes), rotor.ndof) if i % n < 2]
    lateral = np.ix_([*on_shaft, *extra], [*on_shaft, *extra])
    rows = []
    for speed in SPEEDS:
        mass, stiffness = rotor.M(speed)[lateral], rotor.K(speed)[lateral]
        damping = (rotor.C(speed) + rotor.G() * speed)[lateral]
        zero, one = np.zeros_like(mass), np.eye(len(mass))
        solve = np.linalg.solve
        state = np.block([[zero, one], [-solve(mass, stiffness), -solve(mass, damping)]])
        found = np.linalg.eigvals(state)
        found = found[found.imag > 1e-3]
        for value in found[np.argsort(found.imag)][:COUNT]:
            rows.append((speed, value.imag / (2.0 * np.pi), -value.real / abs(value)))
    return np.array(rows)


def write() -> None:
    """Write the rotor and its frequencies with ROSS."""
    rotor = rotor_of_ross()
    rotor.save(ROTOR)
    heads = "speed [rad/s],frequency [Hz],damping ratio"
    np.savetxt(MODES, modes_of_ross(rotor), delimiter=",", header=heads, fmt="%.9g")


def main() -> None:
    """Print the frequencies of both programs in Markdown."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--write", action="store_true", help="run ROSS and write its files again")
    if parser.parse_args().write:
        write()
    system = gb.RotorSystem.from_ross(ROTOR)
    print("| speed [rad/s] | ROSS [Hz] | gearbow [Hz] | ROSS, damping [%] | gearbow, damping [%] |")
    print("|---|---|---|---|---|")
    for rows in np.split(np.loadtxt(MODES, delimiter=","), len(SPEEDS)):
        found = system.modes(rows[0, 0])
        pairs = zip(rows, found.frequencies_hz, found.damping_ratios, strict=False)
        for (speed, frequency, damping), ours, ratio in pairs:
            print(
                f"| {speed:g} | {frequency:.3f} | {ours:.3f} | {100.0 * damping:.4f} | "
                f"{100.0 * ratio:.4f} |"
            )


if __name__ == "__main__":
    main()
