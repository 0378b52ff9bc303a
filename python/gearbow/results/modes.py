"""Natural modes at one speed, and their comparison with measured ones."""

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from gearbow._convert import nodal, shown, whole
from gearbow._extras import extra
from gearbow._files import check_name
from gearbow._result import Column, Figured, Result, WithSpeeds, in_percent, plain_text
from gearbow._shown import ReadOnly, listed
from gearbow._types import Array, At, ComplexArray, Dof, ModesData, NodalDof
from gearbow.description.coordinates import Coordinates
from gearbow.description.layout import BaseOutline, InterfaceOutline, Layout
from gearbow.description.places import places as checked_places
from gearbow.errors import GearbowError, SceneError
from gearbow.results.at_places import Motion

if TYPE_CHECKING:
    from pathlib import Path

    from matplotlib.figure import Figure

    from gearbow.exchange.universal import MeasuredShapes


@dataclass(frozen=True, eq=False)
class ModeComparison(Figured, ReadOnly):
    """MAC of computed and measured mode shapes.

    `plot` draws MAC as a table of colours, with the computed modes along the horizontal axis.

    Parameters
    ----------
    mac : ndarray, shape (m, k)
        Modal assurance criterion of each computed mode with each measured one.
    computed_hz : ndarray, shape (m,)
        Computed natural frequencies [Hz].
    measured_hz : ndarray, shape (k,)
        Measured natural frequencies [Hz].

    Notes
    -----
    MAC is abs(Σ conj(φ_m) φ_c)²/(Σ abs(φ_m)² Σ abs(φ_c)²) over the measured places and directions
    (R. J. Allemang, D. L. Brown, *A correlation coefficient for modal vector analysis*, IMAC 1982):
    1 for proportional shapes, 0 for orthogonal ones and for a shape without motion there, such as
    a rotation.

    Examples
    --------
    >>> import gearbow as gb
    >>> modes = gb.examples()["bowed_rotor"].load().modes(count=2)
    >>> places = ("disk", ("rotor", 0.1))
    >>> shapes = modes.shapes_at(places)
    >>> found = modes.compare(gb.results.MeasuredShapes(places, modes.frequencies_hz, shapes))
    >>> found.mac.round(6)
    array([[1., 0.],
           [0., 1.]])
    """

    mac: Array
    computed_hz: Array
    measured_hz: Array

    @property
    def pairs(self) -> tuple[tuple[int, int], ...]:
        """The computed mode with the largest MAC for each measured one.

        A pair has the numbers of the computed and of the measured mode, from 1.
        """
        best = np.argmax(self.mac, axis=0).tolist() if self.mac.size else []
        return tuple((i + 1, j + 1) for j, i in enumerate(best))

    def _draw(self, ax: Any) -> "Figure":
        from gearbow.plotting import shapes as figures  # noqa: PLC0415

        return figures.assurance(self.mac, self.computed_hz, self.measured_hz, ax=ax)

    def _columns(self) -> list[Column]:
        computed, own = np.reshape(np.array(self.pairs, dtype=np.intp), (-1, 2)).T - 1
        found, measured = self.computed_hz[computed], self.measured_hz[own]
        with np.errstate(invalid="ignore", divide="ignore"):
            difference = 100.0 * (found / measured - 1.0)
        return [
            Column("measured mode", own + 1),
            Column("measured", measured, "Hz", ".3f"),
            Column("computed mode", computed + 1),
            Column("computed", found, "Hz", ".3f"),
            Column("difference", difference, "%", ".2f"),
            Column("MAC", self.mac[computed, own], "", ".4f"),
        ]

    def __repr__(self) -> str:
        best = self.mac.max(axis=0, initial=0.0)
        return f"ModeComparison({len(best)} measured modes, largest MAC {listed(best)})"


#: A smaller damping ratio [%] is round-off of the eigenvalue.
_ROUND_OFF_PERCENT = 1e-10
#: A smaller share of the largest displacement or rotation of a shape is round-off.
_ROUND_OFF = 1e-12
#: Name of the motion to which each direction contributes: bending has the name of its translation,
#: and all modes of an elastic housing are one motion.
_DIRECTION = {"v": "v", "G": "v", "w": "w", "B": "w", "twist": "twist", "u": "u", "mode": "modes"}


@dataclass(frozen=True, eq=False)
class Modes(WithSpeeds, Result, ReadOnly, Motion[ComplexArray, ComplexArray]):
    """Natural modes at one speed, in ascending order of the size of their eigenvalues.

    Parameters
    ----------
    frequencies_hz : ndarray, shape (m,)
        Damped natural frequencies [Hz]; 0 for the rigid-body rotation of an unconstrained train.
    damping_ratios : ndarray, shape (m,)
        Damping ratios.
    whirl : tuple of str
        "forward", "backward", "mixed", "planar", "torsion", "axial", "rigid" or "coupled" for each
        mode; the orbits of a "mixed" mode turn forward at one place and backward at another.
    shapes : ndarray, shape (m, n)
        Complex shapes; the motion is Re(shape exp(eigenvalue t)).
    eigenvalues : ndarray, shape (m,)
        Complex eigenvalues [1/s].
    residuals : ndarray, shape (m,)
        Residual of the equations of motion for each mode: the force [λ²M + λ(C + ΩG) + K] φ
        relative to the forces in the mode, both in the energy norm of ``K + |λ|²M``. A relative
        error of an eigenvalue or a shape causes a residual of this size.
    speed : float
        Speed of the reference shaft [rad/s].
    dofs : tuple of (str, float or (float, float), str)
        Shaft, position [m] and direction of each degree of freedom, as `RotorSystem.dofs`.
    layout : Layout
        Geometry of the train at rest.
    coordinates : Coordinates
        Degrees of freedom of the system.

    Examples
    --------
    >>> import gearbow as gb
    >>> gb.examples()["bowed_rotor"].load().modes(speed=300.0, count=2).whirl
    ('backward', 'forward')
    """

    frequencies_hz: Array
    damping_ratios: Array
    whirl: tuple[str, ...]
    shapes: ComplexArray
    eigenvalues: ComplexArray
    residuals: Array
    speed: float
    dofs: tuple[Dof, ...]
    layout: Layout = field(repr=False)
    coordinates: Coordinates = field(repr=False)
    _shares: Mapping[tuple[str, str], Array] = field(repr=False)
    _vibrates: NDArray[np.bool_] = field(repr=False)

    _own_endings: ClassVar[tuple[str, ...]] = (".uff",)

    @classmethod
    def _from_data(
        cls,
        data: ModesData,
        speed: float,
        coordinates: Coordinates,
        layout: Layout,
    ) -> "Modes":
        """Make modes of the plain data of the core."""
        dofs = coordinates.dofs
        groups: dict[tuple[str, str], list[int]] = {}
        for index, (shaft, _, direction) in enumerate(dofs):
            group = (shaft, _DIRECTION[direction.rstrip("0123456789")])
            groups.setdefault(group, []).append(index)
        shares = data["kinetic_shares"]
        return cls(
            frequencies_hz=data["frequencies_hz"],
            damping_ratios=data["damping_ratios"],
            whirl=tuple(data["whirl"]),
            shapes=data["shapes"],
            eigenvalues=data["eigenvalues"],
            residuals=data["residuals"],
            speed=speed,
            dofs=dofs,
            layout=layout,
            coordinates=coordinates,
            _shares={group: shares[:, indices].sum(axis=1) for group, indices in groups.items()},
            _vibrates=data["vibrates"],
        )

    def _at(self, quantity: str, at: Any) -> Any:
        return self.coordinates.motion(self.shapes, quantity, at)

    def shapes_at(self, places: Sequence[At]) -> ComplexArray:
        """Lateral displacements of several places in the shape of each mode.

        Parameters
        ----------
        places : sequence of str or (str, float)
            As for `displacement`.

        Returns
        -------
        ndarray, shape (m, places, 2)
            Displacements along y and z, in the unit of `shapes`.

        Raises
        ------
        GearbowError
            If there is no such place, or the system has no lateral motion.
        """
        given = checked_places(places, "places")
        return np.stack([self.displacement(at) for at in given], axis=1)

    def compare(
        self,
        measured: "str | os.PathLike[str] | MeasuredShapes | Modes",
        *,
        places: Mapping[int, At] | None = None,
    ) -> "ModeComparison":
        """Compare with measured mode shapes, or with those of another model.

        Parameters
        ----------
        measured : str, path-like, MeasuredShapes or Modes
            A universal file (".uff", ".unv") with data sets 55, measured shapes, or modes, which
            are compared at the gears and disks, or at the nodes of systems without them.
        places : mapping of int to place, optional
            Place of each node of a file of another program; other nodes have no part.

        Returns
        -------
        ModeComparison
            MAC of each computed mode with each measured one.
        """
        from gearbow.exchange.universal import MeasuredShapes, read_uff  # noqa: PLC0415

        if places is not None and not isinstance(places, Mapping):
            raise SceneError(f"places: must be a mapping of nodes to places, got {shown(places)}")
        if isinstance(measured, str | os.PathLike):
            path, _ = check_name(measured, [".uff", ".unv"], "measured")
            measured = read_uff(path, places, self._places())
        elif places is not None:
            raise SceneError("places: belongs to a universal file, which has numbers of nodes")
        if isinstance(measured, Modes):
            common: Sequence[At] = list(self.coordinates.bodies) or self._nodes()
            measured = MeasuredShapes(
                tuple(common), measured.frequencies_hz, measured._translations(common)
            )
        if not isinstance(measured, MeasuredShapes):
            raise SceneError(
                "measured: must be a universal file, measured shapes or modes, got "
                f"{shown(measured)}"
            )
        known = np.isfinite(measured.displacements)
        shapes = [
            np.where(known, measured.displacements, 0.0),
            self._translations(measured.places),
        ]
        given, own = (each.reshape(len(each), 2 * each.shape[1]) for each in shapes)
        counted = known.reshape(len(known), 2 * known.shape[1])
        cross = np.abs(own @ np.conj(given).T) ** 2
        sizes = (np.abs(own) ** 2 @ counted.T) * np.sum(np.abs(given) ** 2, axis=1)
        mac = np.divide(cross, sizes, out=np.zeros_like(sizes), where=sizes > 0.0)
        return ModeComparison(mac, self.frequencies_hz, measured.frequencies_hz)

    def _translations(self, places: Sequence[At]) -> ComplexArray:
        """Give `shapes_at`, and zeros where round-off alone moves a shape there."""
        found = self.shapes_at(places)
        largest = np.abs(self.shapes).max(axis=1, initial=0.0)
        moved = np.abs(found).max(axis=(1, 2), initial=0.0) > _ROUND_OFF * largest
        return np.where(moved[:, None, None], found, 0.0)

    def _nodes(self) -> list[tuple[str, float]]:
        """Give the places of the nodes with lateral motion."""
        return list(dict.fromkeys((name, x) for name, x, kind in nodal(self.dofs) if kind == "v"))

    def _interfaces(self) -> list[tuple[BaseOutline, InterfaceOutline]]:
        """Give the interfaces of elastic housings, which are the nodes after those of shafts."""
        return [(base, each) for base in self.layout.bases for each in base.interfaces]

    def _places(self) -> list[At]:
        """Give the places of the nodes of a universal file."""
        return [*self._nodes(), *(each.name for _, each in self._interfaces())]

    def _save_own(self, path: "Path", _ending: str) -> None:
        """Write a universal file with the translations of all nodes and interfaces."""
        from gearbow.exchange.universal import write_uff  # noqa: PLC0415

        nodes = self._nodes()
        if not nodes:
            raise GearbowError("path: a universal file holds translations, which torsion has not")
        origins = {shaft.name: shaft.origin for shaft in self.layout.shafts}
        origins |= {base.name: base.centre for base in self.layout.bases}
        positions = [origins[name] + [x, 0.0, 0.0] for name, x in nodes]
        positions += [each.position for _, each in self._interfaces()]
        index = {dof: i for i, dof in enumerate(self.dofs)}
        along = np.zeros((len(self.shapes), len(positions)), dtype=np.complex128)
        for j, (name, x) in enumerate(nodes):
            if (name, x, "u") in index:
                along[:, j] = self.shapes[:, index[name, x, "u"]]
        for j, (base, each) in enumerate(self._interfaces(), start=len(nodes)):
            own = [i for i, (name, _, _) in enumerate(self.dofs) if name == base.name]
            along[:, j] = self.shapes[:, own] @ each.rows[0]
        shapes = np.concatenate([along[..., None], self.shapes_at(self._places())], axis=-1)
        write_uff(
            path,
            positions=np.array(positions),
            displacements=shapes,
            eigenvalues=self.eigenvalues,
            names=self.names(),
            speed=self.speed,
        )

    def energy_shares(self) -> dict[tuple[str, str], Array]:
        """Share of each shaft and direction in the kinetic energy of each mode.

        Returns
        -------
        dict of {(str, str): ndarray of shape (m,)}
            Share for each (shaft, "u" | "v" | "w" | "twist"), and (housing, "modes") for an elastic
            housing. The rotation of a bent shaft belongs
            to its translation. The shares of a mode add up to 1.
        """
        return dict(self._shares)

    def names(self) -> list[str]:
        """Name each shape by its largest motions, e.g. "middle y" or "twist of output".

        Returns
        -------
        list of str, length m
            Every motion with at least half of the largest share of kinetic energy. A rotation of
            the train without any stiffness is the "rigid-body rotation".
        """
        groups, shares = zip(*self.energy_shares().items(), strict=True)
        table = np.array(shares)
        names = []
        for mode, whirl in enumerate(self.whirl):
            order = np.argsort(-table[:, mode], kind="stable")
            largest = table[order[0], mode]
            # Round-off decides the order of equal shares: keep the order of the shafts.
            strong = sorted(int(g) for g in order if table[g, mode] >= 0.5 * largest)
            name = _name([groups[g] for g in strong])
            if whirl == "rigid":
                twists = groups[order[0]][1] == "twist"
                name = "rigid-body rotation" if twists else f"rigid motion of {name}"
            names.append(name)
        return names

    def _heading(self) -> list[str]:
        lines = [f"modes at {self._speed_text(self.speed)}"]
        overdamped, count = int(np.sum(self._overdamped())), len(self.whirl)
        if overdamped:
            lines.append(
                f"{overdamped} of {count} modes are overdamped; "
                "modes(count=, vibrating=True) leaves such modes out"
            )
        return lines

    def _overdamped(self) -> NDArray[np.bool_]:
        """Tell which modes are overdamped."""
        rigid = np.array([whirl == "rigid" for whirl in self.whirl], dtype=bool)
        overdamped: NDArray[np.bool_] = ~self._vibrates & (self.eigenvalues.real < 0.0) & ~rigid
        return overdamped

    def _vibrations(self) -> list[int]:
        """Give the numbers of the vibrations from 0: no rigid-body and no overdamped motion."""
        return [int(mode) for mode in np.flatnonzero(self._vibrates)]

    def _columns(self) -> list[Column]:
        return [
            Column("mode", np.arange(1, len(self.whirl) + 1)),
            Column("frequency", self.frequencies_hz, "Hz", ".3f"),
            Column("damping ratio", self.damping_ratios, "", ".3f", in_percent("damping")),
            Column("whirl", list(self.whirl)),
            Column("largest motion", self.names()),
        ]

    def _titles(self) -> list[str]:
        """Describe each mode in two lines: number, frequency, whirl and damping; its motion."""
        from gearbow.plotting.style import quantity  # noqa: PLC0415

        titles = []
        for mode, (value, whirl, name) in enumerate(
            zip(self.eigenvalues, self.whirl, self.names(), strict=True)
        ):
            kind = ""
            if whirl != "rigid" and self.frequencies_hz[mode] == 0.0:
                kind = "overdamped" if value.real < 0.0 else "growth without oscillation"
                kind = f": {kind}, time constant {quantity(1.0 / abs(value.real), 's', 3)}"
            elif whirl != "rigid":
                percent = 100.0 * self.damping_ratios[mode]
                percent = percent if abs(percent) > _ROUND_OFF_PERCENT else 0.0
                ratio = plain_text(percent, ".3g").replace("-", "−")
                frequency = quantity(self.frequencies_hz[mode], "Hz")
                kind = f": {frequency}, {whirl}, damping {ratio} %"
            titles.append(f"mode {mode + 1}{kind}\n{name}")
        return titles

    def __repr__(self) -> str:
        count, speed = self.frequencies_hz.size, self._speed_text(self.speed)
        return f"Modes({count} at {speed}: {listed(self.frequencies_hz)} Hz)"

    def plot(self, number: int | None = None, *, count: int = 6, ax: Any = None) -> "Figure":
        """Draw one mode of the train in three dimensions, or an overview of the first shapes.

        Parameters
        ----------
        number : int, optional
            Number of the mode to draw in three dimensions, from 1; None is the overview.
        count : int
            Number of modes in the overview.
        ax : Axes or sequence of Axes, optional
            Panel in three dimensions for one mode, or one for each mode; None makes a new figure.

        Returns
        -------
        matplotlib.figure.Figure
            The train to scale with its parts, or the shapes along the shafts in a panel each.
        """
        with extra("plot"):
            from gearbow.plotting import shapes as figures  # noqa: PLC0415

        if number is None:
            titles = self._titles()
            shares = self.energy_shares()
            drawn = np.full(len(self.whirl), "lateral", dtype=object)
            for rod in ("twist", "u"):
                share = sum(share for (_, direction), share in shares.items() if direction == rod)
                drawn[np.broadcast_to(share, drawn.shape) > 0.5] = rod
            chosen = np.arange(min(whole(count, "count"), len(self.whirl)))
            shapes, dofs = figures.refined(self.shapes[chosen], self.coordinates, self.layout)
            return figures.overview(
                [titles[mode] for mode in chosen],
                shapes,
                dofs,
                list(drawn[chosen]),
                self.layout,
                ax=ax,
            )
        title, shape, nodes = self._drawn(whole(number, "number"))
        return figures.draw(title, shape, nodes, self.layout, ax=ax)

    def _drawn(self, number: int) -> tuple[str, ComplexArray, Sequence[NodalDof]]:
        """Give title, shape and degrees of freedom of a mode, from 1, with points in elements."""
        from gearbow.plotting import shapes as figures  # noqa: PLC0415

        if not 1 <= number <= len(self.whirl):
            raise GearbowError(f"there is no mode {number}; there are {len(self.whirl)}, from 1")
        own = self.shapes[number - 1 : number]
        shapes, dofs = figures.refined(own, self.coordinates, self.layout)
        return self._titles()[number - 1], shapes[0], dofs


#: Axis of the displacement of a degree of freedom.
_AXES = {"v": "y", "w": "z", "u": "x"}


def _name(groups: Sequence[tuple[str, str]]) -> str:
    """Write (shaft, direction) pairs as text: "input y and z, twist of output"."""
    lateral: dict[str, list[str]] = {}
    twist, whole = [], []
    for shaft, direction in groups:
        if direction == "twist":
            twist.append(shaft)
        elif direction == "modes":
            whole.append(shaft)
        else:
            lateral.setdefault(shaft, []).append(_AXES[direction])
    words = [f"{shaft} {' and '.join(directions)}" for shaft, directions in lateral.items()]
    words += whole
    if twist:
        words.append(f"twist of {' and '.join(twist)}")
    return ", ".join(words)
