"""Losses of the meshes of a train by friction, and its efficiency."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from gearbow._extras import extra
from gearbow._read_only import ReadOnly
from gearbow._result import Column, Result, in_percent
from gearbow._types import Array
from gearbow.units.speed import SpeedUnit

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True, eq=False)
class Efficiency(Result, ReadOnly):
    """Power, loss and efficiency of each of k meshes, and of the train, at m speeds.

    Parameters
    ----------
    meshes : tuple of (str, str)
        Driver and driven gear of each mesh.
    speeds : ndarray, shape (m,)
        Speeds of the reference shaft [rad/s].
    input_power : ndarray, shape (m,)
        Power that torques and drives supply [W].
    power : ndarray, shape (m, k)
        Power that each mesh transmits [W].
    force : ndarray, shape (m, k)
        Mesh force normal to the teeth [N].
    coefficient : ndarray, shape (m, k)
        Coefficient of friction; zero without friction.
    loss : ndarray, shape (m, k)
        Power that friction dissipates, mean over the mesh cycle [W].
    speed_unit : {"rad/s", "rpm"}
        Unit of speeds in tables and figures: that in which the speeds were given.
    left_out : tuple of str
        Excitations of the system that this result does not contain.

    Notes
    -----
    The sliding friction of the tooth flanks is the only loss: no churning of oil, no seals, no
    friction of bearings. Mesh forces are those of the static equilibrium without friction.

    Examples
    --------
    >>> import gearbow as gb
    >>> shafts = [gb.Shaft(name, length=0.2, outer_diameter=0.05) for name in ("input", "output")]
    >>> pinion = gb.Gear("pinion", "input", 0.1, teeth=25, module=3e-3, face_width=0.03)
    >>> wheel = gb.Gear("wheel", "output", 0.1, teeth=50, module=3e-3, face_width=0.03)
    >>> mesh = gb.Mesh("pinion", "wheel", friction=0.05)
    >>> places = [(shaft.name, x) for shaft in shafts for x in (0.0, 0.2)]
    >>> bearings = [gb.Bearing(name, x, stiffness=1e9) for name, x in places]
    >>> torques = [gb.Torque("pinion", 100.0), gb.Torque.balance("wheel")]
    >>> system = gb.RotorSystem(shafts, [pinion, wheel], [mesh], bearings, torques)
    >>> found = system.efficiency(gb.rpm(3000))
    >>> print(f"{100 * found.efficiency[0]:.2f} %, H_v = {found.loss_factor[0, 0]:.4f}")
    99.31 %, H_v = 0.1386
    """

    meshes: tuple[tuple[str, str], ...]
    speeds: Array
    input_power: Array
    power: Array
    force: Array
    coefficient: Array
    loss: Array
    speed_unit: SpeedUnit = "rad/s"
    left_out: tuple[str, ...] = ()

    @property
    def efficiency(self) -> Array:
        """Efficiency of the train at each speed, shape (m,); NaN without power."""
        return 1.0 - _ratio(self.loss.sum(axis=1), self.input_power)

    @property
    def mesh_efficiency(self) -> Array:
        """Efficiency of each mesh at each speed, shape (m, k); NaN without power."""
        return 1.0 - _ratio(self.loss, self.power)

    @property
    def loss_factor(self) -> Array:
        """Tooth loss factor H_v, loss over μ times power, shape (m, k); NaN without friction."""
        return _ratio(self.loss, self.coefficient * self.power)

    def _heading(self, speed_unit: SpeedUnit) -> list[str]:  # noqa: ARG002  # speeds are a column
        return ["losses by friction of the teeth; no churning, no seals, no friction of bearings"]

    def _columns(self) -> list[Column]:
        """Give a row for each mesh at each speed, and one for the train."""
        names = [*("/".join(pair) for pair in self.meshes), "train"]
        none = np.full((self.speeds.size, 1), np.nan)

        def _with_train(of_meshes: Array, of_train: Array) -> Array:
            found: Array = np.hstack([of_meshes, of_train.reshape(-1, 1)]).ravel()
            return found

        loss = _with_train(self.loss, self.loss.sum(axis=1))
        return [
            Column("speed", np.repeat(self.speeds, len(names)), "rad/s", ".6g"),
            Column("mesh", names * self.speeds.size),
            Column("power", _with_train(self.power, self.input_power), "W"),
            Column("mesh force", _with_train(self.force, none), "N"),
            Column("friction μ", _with_train(self.coefficient, none)),
            Column("loss factor H_v", _with_train(self.loss_factor, none)),
            Column("loss", loss, "W"),
            Column(
                "efficiency",
                _with_train(self.mesh_efficiency, self.efficiency),
                "",
                ".3f",
                in_percent("efficiency"),
            ),
        ]

    def __repr__(self) -> str:
        found = self.efficiency
        low, high = (100.0 * float(x) for x in (found.min(), found.max()))
        text = f"{low:.2f}" if low == high else f"{low:.2f} to {high:.2f}"
        speeds = "1 speed" if found.size == 1 else f"{found.size} speeds"
        meshes = "1 mesh" if len(self.meshes) == 1 else f"{len(self.meshes)} meshes"
        return f"Efficiency({meshes}, {speeds}, {text} %)"

    def plot(self, *, ax: Any = None, speed_unit: SpeedUnit | None = None) -> "Figure":
        """Draw the losses of the meshes relative to the input power over the speed.

        Parameters
        ----------
        ax : Axes, optional
            Panel; None makes a new figure.
        speed_unit : {"rad/s", "rpm"}, optional
            Unit of the axis of speeds; None is that in which the speeds were given.

        Returns
        -------
        matplotlib.figure.Figure
            One line for each mesh and one for their sum; bars at a single speed.

        Raises
        ------
        GearbowError
            If `ax` or the unit is invalid.
        """
        with extra("plot"):
            from gearbow.plotting.analyses import losses  # noqa: PLC0415

        return losses(
            self.speeds,
            ["/".join(pair) for pair in self.meshes],
            100.0 * _ratio(self.loss, self.input_power[:, np.newaxis]),
            speed_unit=self._speed_unit(speed_unit),
            ax=ax,
        )


def _ratio(part: Array, whole: Array) -> Array:
    """Divide; NaN where the whole is zero."""
    found: Array = np.full(np.broadcast(part, whole).shape, np.nan)
    return np.divide(part, whole, out=found, where=whole > 0.0)
