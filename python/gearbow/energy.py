"""Where the energy of a run is, and what work brought it there."""

from dataclasses import dataclass, fields
from typing import TYPE_CHECKING

from gearbow._extras import extra
from gearbow._read_only import ReadOnly
from gearbow._types import Array

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

__all__ = ["EnergyBalance"]

#: Energies that the system holds, and works that were done on it, as the fields are called.
ENERGIES = ("kinetic", "shafts", "bearings", "meshes")
WORKS = ("torque", "gravity", "drive", "unbalance", "teeth", "damping")


@dataclass(frozen=True, eq=False)
class EnergyBalance(ReadOnly):
    """Energies of a system and the work that was done on it, at the k times of a response.

    Parameters
    ----------
    time : ndarray, shape (k,)
        Times [s].
    kinetic : ndarray, shape (k,)
        Kinetic energy of the motion beside the spin [J].
    shafts : ndarray, shape (k,)
        Elastic energy of the shafts, from their bowed shapes [J].
    bearings : ndarray, shape (k,)
        Elastic energy of the bearings [J].
    meshes : ndarray, shape (k,)
        Elastic energy of the meshes [J].
    torque : ndarray, shape (k,)
        Work of the torques on the motion beside the spin [J].
    gravity : ndarray, shape (k,)
        Work of gravity [J].
    drive : ndarray, shape (k,)
        Work of the drive, which keeps bowed shafts at their speed and changes the stiffness of
        bearings with the speed [J].
    unbalance : ndarray, shape (k,)
        Work of the unbalance [J].
    teeth : ndarray, shape (k,)
        Work of what is prescribed of the teeth: stiffness, transmission error, run-out [J].
    damping : ndarray, shape (k,)
        Work of all damping, which is negative, and of the cross-coupling of bearings [J].

    Notes
    -----
    Works count from the start of the run, also where it continues another. What is left over,
    `residual`, is the error of the integration.

    Examples
    --------
    A shaft that is let go from rest in the plane of its bow keeps its energy:

    >>> import gearbow as gb
    >>> bow = gb.Bow.half_sine(1e-4)
    >>> rotor = gb.Shaft("rotor", length=1.0, outer_diameter=0.05, elements=4, bow=bow)
    >>> bearings = [gb.Bearing("rotor", x, stiffness=1e9) for x in (0.0, 1.0)]
    >>> system = gb.RotorSystem(shafts=[rotor], bearings=bearings)
    >>> response = system.simulate(0.01, speed=0.0, initial="rest", record="energy", rtol=1e-8)
    >>> balance = response.energy_balance()
    >>> bool(abs(balance.residual).max() < 1e-6 * balance.total.max())
    True
    """

    time: Array
    kinetic: Array
    shafts: Array
    bearings: Array
    meshes: Array
    torque: Array
    gravity: Array
    drive: Array
    unbalance: Array
    teeth: Array
    damping: Array

    @property
    def total(self) -> Array:
        """All energy of the system.

        Returns
        -------
        ndarray, shape (k,)
            Kinetic energy and elastic energy of shafts, bearings and meshes [J].
        """
        return self.kinetic + self.shafts + self.bearings + self.meshes

    @property
    def work(self) -> Array:
        """All work that was done on the system since the start of the run.

        Returns
        -------
        ndarray, shape (k,)
            Work of torque, gravity, drive, unbalance, teeth and damping [J].
        """
        return self.torque + self.gravity + self.drive + self.unbalance + self.teeth + self.damping

    @property
    def residual(self) -> Array:
        """What the work leaves unexplained of the change of energy since the first recorded time.

        Returns
        -------
        ndarray, shape (k,)
            Change of `total` less the change of `work` [J]: the error of the integration.
        """
        total, work = self.total, self.work
        return (total - total[:1]) - (work - work[:1])

    def plot(self) -> "Figure":
        """Draw energies, works and what is left over, against time.

        Returns
        -------
        matplotlib.figure.Figure
            A panel for each; what is zero throughout is left out.
        """
        with extra("plot"):
            from gearbow import plots  # noqa: PLC0415

        return plots.energy_balance(self)

    def to_dataframe(self) -> "pd.DataFrame":
        """Give everything as one table.

        Returns
        -------
        pandas.DataFrame
            Rows by time [s]; a column for each term and "total", "work" and "residual", all with
            their unit, e.g. "kinetic [J]".
        """
        with extra("dataframe"):
            import pandas as pd  # noqa: PLC0415

        names = [*[field.name for field in fields(self)][1:], "total", "work", "residual"]
        columns = {f"{name} [J]": getattr(self, name) for name in names}
        table: pd.DataFrame = pd.DataFrame(columns, index=pd.Index(self.time, name="time [s]"))
        return table
