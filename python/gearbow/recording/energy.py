"""Energies of a system during a run, and the work done on it."""

from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from gearbow._read_only import ReadOnly
from gearbow._result import Column, Figured
from gearbow._types import Array

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: Fields that are energies of the system, and fields that are work done on it.
ENERGIES = ("kinetic", "shafts", "bearings", "meshes")
WORKS = ("torque", "gravity", "drive", "unbalance", "teeth", "damping")


@dataclass(frozen=True, eq=False)
class EnergyBalance(Figured, ReadOnly):
    """Energies of a system and the work done on it, at the k times of a response.

    `plot` draws energies, works and the residual against time in three panels. Terms that are
    zero throughout are omitted.

    Parameters
    ----------
    time : ndarray, shape (k,)
        Times [s].
    kinetic : ndarray, shape (k,)
        Kinetic energy of the vibration, without that of the rigid-body rotation [J].
    shafts : ndarray, shape (k,)
        Elastic energy of the shafts; a bowed shaft without load has none [J].
    bearings : ndarray, shape (k,)
        Elastic energy of the bearings [J].
    meshes : ndarray, shape (k,)
        Elastic energy of the meshes [J].
    torque : ndarray, shape (k,)
        Work of the torques on the vibration [J].
    gravity : ndarray, shape (k,)
        Work of gravity [J].
    drive : ndarray, shape (k,)
        Work of the drive that keeps bowed shafts, and deflected ones with internal damping, at the
        prescribed speed and changes the stiffness of bearings with the speed [J].
    unbalance : ndarray, shape (k,)
        Work of the unbalance [J].
    teeth : ndarray, shape (k,)
        Work of the prescribed excitation of the teeth: time-varying stiffness, transmission error
        and run-out [J].
    damping : ndarray, shape (k,)
        Work of all damping forces, which is negative, and of the cross-coupled stiffness of
        bearings [J].

    Notes
    -----
    Work is zero at the start of the run, also if the run continues another one. The `residual` is
    the integration error.

    Examples
    --------
    A bowed shaft is released from rest. Its energy is constant:

    >>> import gearbow as gb
    >>> bow = gb.Bow.half_sine(1e-4)
    >>> rotor = gb.Shaft("rotor", length=1.0, outer_diameter=0.05, bow=bow)
    >>> bearings = [gb.Bearing("rotor", x, stiffness=1e9) for x in (0.0, 1.0)]
    >>> system = gb.RotorSystem(shafts=[rotor], bearings=bearings)
    >>> response = system.simulate(0.01, speed=0.0, initial="rest", record="energy", rtol=1e-8)
    >>> balance = response.energy_balance()
    >>> bool(abs(balance.residual).max() < 1e-6 * balance.total.max())
    True
    """

    _indexed: ClassVar[bool] = True

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
        """Total energy of the system.

        Returns
        -------
        ndarray, shape (k,)
            Kinetic energy and elastic energy of shafts, bearings and meshes [J].
        """
        return self.kinetic + self.shafts + self.bearings + self.meshes

    @property
    def work(self) -> Array:
        """Total work on the system since the start of the run.

        Returns
        -------
        ndarray, shape (k,)
            Work of torque, gravity, drive, unbalance, teeth and damping [J].
        """
        return self.torque + self.gravity + self.drive + self.unbalance + self.teeth + self.damping

    @property
    def residual(self) -> Array:
        """Change of energy that the work does not explain, since the first recorded time.

        Returns
        -------
        ndarray, shape (k,)
            Change of `total` minus the change of `work` [J]: the integration error.
        """
        total, work = self.total, self.work
        return (total - total[:1]) - (work - work[:1])

    def _draw(self, ax: Any) -> "Figure":
        from gearbow.plotting import response as figures  # noqa: PLC0415

        def _terms(names: tuple[str, ...]) -> dict[str, Array]:
            return {name: getattr(self, name) for name in names}

        rows = {
            "energy": (_terms(ENERGIES), self.total),
            "work": (_terms(WORKS), self.work),
            "residual": (_terms(()), self.residual),
        }
        return figures.energy_balance(self.time, rows, ax=ax)

    def _terms(self) -> dict[str, Array]:
        names = [*[field.name for field in fields(self)][1:], "total", "work", "residual"]
        return {name: getattr(self, name) for name in names}

    def _columns(self) -> list[Column]:
        """Give a row for each term."""
        terms = self._terms()
        values = np.array(list(terms.values())).reshape(len(terms), -1)
        if not values.size:
            values = np.full((len(terms), 1), np.nan)
        return [
            Column("term", list(terms)),
            Column("smallest", values.min(axis=1), "J"),
            Column("largest", values.max(axis=1), "J"),
            Column("at the end", values[:, -1], "J"),
        ]

    def _series(self) -> list[Column]:
        terms = self._terms().items()
        return [Column("time", self.time, "s"), *(Column(name, own, "J") for name, own in terms)]
