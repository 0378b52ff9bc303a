"""The rotor system with all its analyses."""

from gearbow.analysis.balance import balance
from gearbow.sweeps.many import simulate_many
from gearbow.system.continuation import ContinuationAnalyses
from gearbow.system.drawing import plot
from gearbow.tradeoff.ask import tradeoff

__all__ = ["RotorSystem"]


class RotorSystem(ContinuationAnalyses):
    """A system of shafts with gears, disks, bearings and torques.

    Parameters
    ----------
    shafts : sequence of Shaft
        The shafts, parallel to x.
    gears : sequence of Gear
        The gears.
    meshes : sequence of Mesh
        The meshes between gears.
    bearings : sequence of Bearing
        The bearings.
    torques : sequence of Torque
        Torques on the shafts.
    disks : sequence of Disk
        Rigid disks.
    supports : sequence of Support
        Supports that bearings refer to by name.
    housings : sequence of Housing
        Housings, which carry several bearings.
    couplings : sequence of Coupling
        Couplings between shafts of one speed.
    drives : sequence of Drive
        Drives, which hold the rotation.
    forces : sequence of Force
        Lateral forces.
    reference : str, optional
        Name of the reference shaft, whose speed all speeds refer to; None is the first.
    modal_damping : float, optional
        Damping ratio of the shafts, the same for every mode.
    rayleigh : tuple of (float, float), optional
        Damping αM + βK of the shafts [1/s, s].
    gravity : float or tuple of (float, float), optional
        Gravity [m/s²], along −z or as (y, z).
    motion : {"lateral", "torsion", "coupled"}, optional
        The degrees of freedom of a node; None chooses those that the scene requires.
    resolution : {"draft", "engineering", "reference"}
        How fine the elements are of shafts without a number of elements: the error of mesh forces
        is at most about 1e-1, 1e-2 or 1e-4, see `discretisation`.

    Attributes
    ----------
    shafts, gears, meshes, bearings, torques, disks : tuple
        The given parts.
    supports, housings, couplings, drives, forces : tuple
        The given parts.
    reference, modal_damping, rayleigh, gravity, motion, resolution
        The given options; None if not given.

    Raises
    ------
    SceneError
        If the description is invalid. The message begins with the path of the entry.

    Warns
    -----
    SceneWarning
        If the description is implausible.

    Examples
    --------
    >>> import gearbow as gb
    >>> bow = gb.Bow.half_sine(1.5e-4)
    >>> system = gb.RotorSystem(
    ...     shafts=[
    ...         gb.Shaft("input", length=0.5, outer_diameter=0.05, bow=bow),
    ...         gb.Shaft("output", length=0.5, outer_diameter=0.05),
    ...     ],
    ...     gears=[
    ...         gb.Gear("g1", "input", position=0.25, teeth=25, module=3e-3, face_width=0.03),
    ...         gb.Gear("g2", "output", position=0.25, teeth=50, module=3e-3, face_width=0.03),
    ...     ],
    ...     meshes=[gb.Mesh("g1", "g2", stiffness=2e8, damping_ratio=0.05)],
    ...     bearings=[
    ...         gb.Bearing(shaft, position=x, stiffness=1e8, damping=500.0)
    ...         for shaft in ("input", "output")
    ...         for x in (0.0, 0.5)
    ...     ],
    ...     torques=[gb.Torque("g1", 250.0), gb.Torque.balance("g2")],
    ... )
    >>> system.speed_ratios
    array([ 1. , -0.5])
    >>> system.modes().names()[0]
    'rigid-body rotation'
    >>> response = system.simulate(0.1, speed=100.0)
    >>> contact_ratio = response.mesh(("g1", "g2")).contact_ratio
    >>> print(f"{contact_ratio.max() - contact_ratio.min():.2f}")
    0.10
    """

    plot = plot
    simulate_many = simulate_many
    tradeoff = tradeoff
    balance = balance
