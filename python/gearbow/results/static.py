"""Static equilibrium, and the losses at it."""

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, get_args

import numpy as np

from gearbow._convert import one_of
from gearbow._core import Model
from gearbow._extras import extra
from gearbow._result import (
    ROUND_OFF,
    Column,
    Figured,
    Result,
    WithSpeeds,
    in_micrometres,
    in_percent,
)
from gearbow._shown import MOST_ROWS, ReadOnly, Shown, read_only
from gearbow._types import Array, At, Plain, Side, StaticData, StaticFigure
from gearbow.description.coordinates import Coordinates
from gearbow.description.layout import Layout
from gearbow.description.places import Places, place, place_label
from gearbow.errors import SceneError
from gearbow.recording.access import journal_motion
from gearbow.results.at_places import AxialMotion
from gearbow.results.bearing_life import BearingLife, life_at
from gearbow.results.section_forces import SectionForces, forces_at_rest
from gearbow.units.speed import SpeedUnit

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class MeshState(Shown):
    """State of one mesh at equilibrium.

    The quantities are those of `MeshResponse`.

    Parameters
    ----------
    deflection, force, stiffness : float
        Deflection along the line of action [m], mesh force [N] and mesh stiffness [N/m].
    pressure_angle, centre_distance : float
        Operating pressure angle [rad], and distance between the centres [m].
    centre_line_angle : float
        Angle of the line of centres, driver to driven, from y towards z [rad].
    contact_ratio, pairs_in_contact : float
        Contact ratio, and number of tooth pairs that carry load.
    thrust : float
        Axial force of the teeth on the driven gear [N].

    Examples
    --------
    >>> import gearbow as gb
    >>> gb.results.MeshState(1e-6, 200.0, 2e8, 0.35, 0.1, 0.0, 1.6, 2.0, 0.0).thrust
    0.0
    """

    deflection: float
    force: float
    stiffness: float
    pressure_angle: float
    centre_distance: float
    centre_line_angle: float
    contact_ratio: float
    pairs_in_contact: float
    thrust: float


class Static(WithSpeeds, Result, ReadOnly, AxialMotion[Array, float]):
    """Equilibrium under torque, gravity and mesh forces, made by `gearbow.RotorSystem.static`.

    The rotating bow does not contribute. `plot` draws the displacements along y and z over the
    shafts in two panels, with marks at gears and disks, of a system without lateral motion the
    twist in one; or the section forces.

    Attributes
    ----------
    state : ndarray, shape (n,)
        Displacements of all degrees of freedom [m, rad].
    coordinates : Coordinates
        Degrees of freedom of the system.
    speed : float
        Speed of the reference shaft [rad/s].
    geometry : {"live", "frozen"}
        Whether the line of action follows the moving centres or is that at rest.

    Examples
    --------
    A shaft of 15.4 kg on two bearings of 1 MN/m sinks by 76 µm:

    >>> import gearbow as gb
    >>> rotor = gb.Shaft("rotor", length=1.0, outer_diameter=0.05)
    >>> bearings = [gb.Bearing("rotor", x, stiffness=1e6) for x in (0.0, 1.0)]
    >>> static = gb.RotorSystem(shafts=[rotor], bearings=bearings, gravity=9.81).static()
    >>> print("{:.0f} N on each, {:.1f} µm".format(
    ...     static.bearing_force(("rotor", 0.0))[1], 1e6 * static.displacement(("rotor", 0.0))[1]))
    -76 N on each, -75.6 µm
    """

    def __init__(
        self,
        data: StaticData,
        coordinates: Coordinates,
        *,
        layout: Layout,
        description: Mapping[str, Plain],
        speed: float = 0.0,
        geometry: str = "live",
        ratios: Mapping[str, float] | None = None,
        excitations: tuple[str, ...] = (),
    ) -> None:
        self.speed, self.geometry = speed, geometry
        self._layout = layout
        self._description = description
        self._ratios, self._excitations = dict(ratios or {}), excitations
        self._data = read_only(data)
        self.state = data["state"]
        self.coordinates = coordinates

    @property
    def residuals(self) -> dict[str, float]:
        """What the forces leave unbalanced on each shaft, support and housing, over its load.

        The forces are evaluated anew at `state`. The unbalanced force is the largest one of all
        degrees of freedom, or of the sums of forces and moments over the shaft; moments are divided
        by the length of the shaft, and those of a housing by that of the longest shaft. The load is
        the sum of the sizes of all forces of weight, torques, bearings, meshes, couplings and other
        loads on the shaft, and at least 1e-6 of the largest load of all. At a degree of freedom the
        round-off of elastic forces, ``8 ε Σ|K||q|`` with ε = 2.2e-16, does not count.
        """
        return dict(self._data["residuals"])

    @property
    def residual(self) -> float:
        """Largest value of `residuals`; usually below 1e-9, and never above 1e-6."""
        return max(self.residuals.values())

    def _at(self, quantity: str, at: Any) -> Any:
        if quantity in ("displacement", "twist", "axial"):
            moved = self.coordinates.motion(self.state, quantity, at)
            return moved if quantity == "displacement" else float(moved)
        if quantity == "journal":
            force, moved = self.bearing_force(at), self.bearing_displacement(at)
            bearings = self._description.get("bearings", ())
            return journal_motion(bearings, place(at), moved, force)
        found = self._data[quantity][Places.of("bearing", self._data["bearings"]).index(at)]  # type: ignore[literal-required]
        return float(found) if quantity == "axial_bearing_force" else found

    def _section_forces(self, at: At, side: Side) -> SectionForces:
        model = Model(dict(self._description))
        return forces_at_rest(model, self.coordinates, (self.state, self.speed), at, side)

    def mesh(self, at: str | tuple[str, str]) -> MeshState:
        """State of one mesh.

        Parameters
        ----------
        at : tuple of (str, str) or str
            The two gears, (driver, driven) in either order, or "driver/driven".

        Returns
        -------
        MeshState
            Deflection, force and geometry.
        """
        i = Places.of("mesh", self._data["meshes"]).index(at)
        # The equilibrium contains no friction.
        own = [field.name for field in dataclasses.fields(MeshState)]
        found = {name: float(self._data["mesh"][name][i]) for name in own}
        # The core counts the pairs at one instant, but its stiffness is the mean of a tooth cycle.
        if found["pairs_in_contact"] > 0.0:
            found["pairs_in_contact"] = found["contact_ratio"]
        return MeshState(**found)

    def bearing_life(self, *, factor: float = 1.0, reliability: float = 0.9) -> BearingLife:
        """Find the rating life of the rolling bearings under the forces of the equilibrium.

        Parameters
        ----------
        factor, reliability : float
            Factor a_ISO of the modified life, and its reliability from 0.9 to 0.9995 (ISO 281).

        Returns
        -------
        BearingLife
            Loads, rating life and static safety of each bearing.

        Raises
        ------
        SceneError
            If the shafts stand still, nothing moves laterally, or no bearing has a rating.

        Notes
        -----
        `RotorSystem.bearing_life` says which formulas it uses.
        """
        if self.speed == 0.0:
            raise SceneError("speed: must not be zero: bearings at standstill have no life")
        found = self._life(factor, reliability)
        found._remember(self.speed_unit)
        return found

    def _life(self, factor: float, reliability: float) -> BearingLife:
        """Find the life of the bearings, also at standstill."""
        if not any(direction == "v" for *_, direction in self.coordinates.dofs):
            raise SceneError('motion: "torsion" has no forces on bearings, and so no life')
        return life_at(
            self,
            self._description.get("bearings", ()),
            self._ratios,
            factor=factor,
            reliability=reliability,
            left_out=self._excitations,
        )

    def _contact_forces(self, at: tuple[str, float]) -> Array | None:
        """Give the contact forces around a ring of five degrees of freedom [N]."""
        places = Places.of("bearing", self._data["bearings"])
        return self._data["contact_forces"][places.index(at)]

    def __repr__(self) -> str:
        forces = [
            f"{driver}–{driven} {force:.4g} N"
            for (driver, driven), force in zip(
                self._data["meshes"][:MOST_ROWS], self._data["mesh"]["force"], strict=False
            )
        ]
        text = f"{self.state.size} degrees of freedom, {len(self._data['meshes'])} meshes"
        return f"Static({text}{': ' * bool(forces)}{', '.join(forces)})"

    def _heading(self) -> list[str]:
        at = f" at {self._speed_text(self.speed)}" if self.speed else ""
        return [f"static equilibrium{at}; unbalanced part of the load {self.residual:.1e}"]

    def _columns(self) -> list[Column]:
        mesh, none = self._data["mesh"], np.array([np.nan, np.nan])
        rows: list[tuple[str, float, float, Array, float]] = []
        for i, (driver, driven) in enumerate(self._data["meshes"]):
            label, deflection = f"mesh {driver}–{driven}", float(mesh["deflection"][i])
            rows.append((label, float(mesh["force"][i]), np.nan, none, deflection))
        moved = self._data["bearing_displacement"]
        for i, (shaft, x) in enumerate(self._data["bearings"]):
            force = float(np.hypot(*self._data["bearing_force"][i]))
            axial = float(self._data["axial_bearing_force"][i])
            rows.append((f"bearing {place_label((shaft, x))}", force, axial, moved[i], np.nan))
        directions = {direction for *_, direction in self.coordinates.dofs}
        for name in filter(
            self.coordinates.bends, (*self.coordinates.bodies, *self.coordinates.seats)
        ):
            rows.append((name, np.nan, np.nan, self.displacement(name), np.nan))
        displacements = np.array([row[3] for row in rows]).reshape(-1, 2)
        thrusts = np.array([row[2] for row in rows])
        largest = np.abs(np.nan_to_num(thrusts)).max(initial=0.0)
        along = [Column("axial force", thrusts, "N", round_off=ROUND_OFF * largest)]
        um = in_micrometres()
        given: Any = (".4g", um, ROUND_OFF * np.abs(np.nan_to_num(displacements)).max(initial=0.0))
        return [
            Column("place", [row[0] for row in rows]),
            Column("force", np.array([row[1] for row in rows]), "N"),
            *(along if "u" in directions else []),
            Column("displacement y", displacements[:, 0], "m", *given),
            Column("displacement z", displacements[:, 1], "m", *given),
            Column("mesh deflection", np.array([row[4] for row in rows]), "m", ".4g", um),
        ]

    def plot(
        self,
        kind: StaticFigure = "deflection",
        *,
        ax: Any = None,
        speed_unit: SpeedUnit | None = None,
    ) -> "Figure":
        """Draw the equilibrium.

        Parameters
        ----------
        kind : {"deflection", "section forces"}
            Displacements of the shafts, or axial and shear force, bending moment and torque along
            each of them, with gears, disks and bearings marked.
        ax : Axes or sequence of Axes, optional
            One for each panel of the figure; None makes a new figure.
        speed_unit : str, optional
            Unit of speeds, as for `table`; None is that of the given ones.

        Returns
        -------
        matplotlib.figure.Figure
            The figure. It is neither shown nor saved.
        """
        one_of(kind, get_args(StaticFigure), "kind")
        with extra("plot"):
            from gearbow.plotting import analyses, shapes  # noqa: PLC0415

        with self._showing(speed_unit):
            if kind == "deflection":
                return shapes.deflection(self.state, self.coordinates, self._layout, ax=ax)
            courses = {}
            for name in (shaft.name for shaft in self._layout.shafts):
                found = self.section_forces(name)
                bodies = [
                    (one.position, one.name) for one in self._layout.bodies if one.shaft == name
                ]
                bearings = [(x, "bearing") for shaft, x in self._data["bearings"] if shaft == name]
                courses[name] = analyses.Course(
                    found.positions, found.values, found.values, [*bodies, *bearings]
                )
            return analyses.section_forces(courses, ax=ax)


@dataclass(frozen=True, eq=False)
class Efficiency(WithSpeeds, Figured, ReadOnly):
    """Power, loss and efficiency of each of k meshes, and of the train, at m speeds.

    `plot` draws the losses relative to the input power over the speed, a line for each mesh and
    one for their sum; bars at a single speed.

    Parameters
    ----------
    meshes : tuple of (str, str)
        Driver and driven gear of each mesh.
    speeds : ndarray, shape (m,)
        Speeds of the reference shaft [rad/s].
    input_power : ndarray, shape (m,)
        Power that torques and drives supply [W].
    power, force : ndarray, shape (m, k)
        Power that each mesh transmits [W], and its force normal to the teeth [N].
    coefficient : ndarray, shape (m, k)
        Coefficient of friction; zero without friction.
    loss : ndarray, shape (m, k)
        Power that friction dissipates, mean over the mesh cycle [W].
    left_out : tuple of str
        Excitations of the system that this result does not contain.

    Notes
    -----
    The sliding friction of the tooth flanks is the only loss: no churning of oil, no seals, no
    friction of bearings. Mesh forces are those of the static equilibrium without friction.

    Examples
    --------
    >>> from dataclasses import replace
    >>> import gearbow as gb
    >>> system = gb.examples()["geared_pair"].load()
    >>> rough = system.replace(meshes=[replace(system.meshes[0], friction=0.05)])
    >>> found = rough.efficiency(gb.rpm(1500))
    >>> print(f"{100 * found.efficiency[0]:.2f} %, H_v = {found.loss_factor[0, 0]:.4f}")
    99.48 %, H_v = 0.1040
    """

    meshes: tuple[tuple[str, str], ...]
    speeds: Array
    input_power: Array
    power: Array
    force: Array
    coefficient: Array
    loss: Array
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

    def _heading(self) -> list[str]:
        return ["losses by friction of the teeth; no churning, no seals, no friction of bearings"]

    def _columns(self) -> list[Column]:
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

    def _draw(self, ax: Any) -> "Figure":
        from gearbow.plotting.analyses import losses  # noqa: PLC0415

        return losses(
            self.speeds,
            ["/".join(pair) for pair in self.meshes],
            100.0 * _ratio(self.loss, self.input_power[:, np.newaxis]),
            ax=ax,
        )


def _ratio(part: Array, whole: Array) -> Array:
    """Divide; NaN where the whole is zero."""
    found: Array = np.full(np.broadcast(part, whole).shape, np.nan)
    return np.divide(part, whole, out=found, where=whole > 0.0)
