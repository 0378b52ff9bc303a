"""Which frequencies a train excites, in orders of its reference shaft, and what they are called.

A shaft that turns at r_s Ω excites its harmonics n |r_s|; a mesh excites harmonics of its tooth
frequency, m z |r_s|; what a shaft does to a mesh stands beside these as sidebands m z |r| ± n |r_s|
(Randall, *A new method of modeling gear faults*, J. Mech. Design 104, 1982).
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from gearbow._convert import whole

if TYPE_CHECKING:
    from gearbow.system import RotorSystem

__all__ = ["Kinematics", "Order"]

#: Orders that differ by less, relative to the larger, are one: ratios of teeth are rounded.
SAME = 1e-9


@dataclass(frozen=True)
class Order:
    """One frequency of a train, in orders of the reference shaft.

    Parameters
    ----------
    value : float
        Frequency over that of the reference shaft.
    names : tuple of str
        Everything that excites it, the simplest first, e.g. "1× input" and "2× middle".
    """

    value: float
    names: tuple[str, ...]

    def __str__(self) -> str:
        return " = ".join(self.names)


@dataclass(frozen=True)
class Kinematics:
    """What turns with what: all that the orders of a train follow from.

    Parameters
    ----------
    shafts : tuple of (str, float)
        Name of each shaft, and its speed over that of the reference shaft, without sign.
    meshes : tuple of (str, str, str, str, float)
        Driver, driven, their shafts, and the tooth frequency of each mesh in orders.

    Examples
    --------
    >>> from gearbow.orders import Kinematics
    >>> train = Kinematics(
    ...     shafts=(("input", 1.0), ("output", 0.5)),
    ...     meshes=(("g1", "g2", "input", "output", 25.0),),
    ... )
    >>> for order in train.orders(shaft_harmonics=2, mesh_harmonics=1, sidebands=1):
    ...     print(f"{order.value:g}", order)
    0.5 1× output
    1 1× input = 2× output
    2 2× input
    24 1× mesh g1–g2 − 1× input
    24.5 1× mesh g1–g2 − 1× output
    25 1× mesh g1–g2
    25.5 1× mesh g1–g2 + 1× output
    26 1× mesh g1–g2 + 1× input
    """

    shafts: tuple[tuple[str, float], ...]
    meshes: tuple[tuple[str, str, str, str, float], ...]

    @classmethod
    def of(cls, system: "RotorSystem") -> "Kinematics":
        """Read them off a system.

        Parameters
        ----------
        system : RotorSystem
            The system.

        Returns
        -------
        Kinematics
            Its shafts and meshes.
        """
        ratios = {
            shaft.name: abs(float(ratio))
            for shaft, ratio in zip(system.shafts, system.speed_ratios, strict=True)
        }
        gears = {gear.name: gear for gear in system.gears}
        meshes = []
        for mesh in system.meshes:
            driver, driven = gears[mesh.driver], gears[mesh.driven]
            tooth = driver.teeth * ratios[driver.shaft]
            meshes.append((driver.name, driven.name, driver.shaft, driven.shaft, tooth))
        return cls(tuple(ratios.items()), tuple(meshes))

    @classmethod
    def _from_plain(cls, plain: dict[str, Any] | None) -> "Kinematics | None":
        if plain is None:
            return None
        return cls(*(tuple(tuple(row) for row in plain[key]) for key in ("shafts", "meshes")))

    def orders(
        self, shaft_harmonics: int = 4, mesh_harmonics: int = 3, sidebands: int = 1
    ) -> tuple[Order, ...]:
        """List the orders, each frequency once.

        Parameters
        ----------
        shaft_harmonics, mesh_harmonics : int
            How many harmonics of each shaft and of each tooth frequency.
        sidebands : int
            How many on either side of a tooth frequency, from each of the two shafts.

        Returns
        -------
        tuple of Order
            In ascending order.
        """
        shaft_harmonics = whole(shaft_harmonics, "shaft_harmonics", least=0)
        mesh_harmonics = whole(mesh_harmonics, "mesh_harmonics", least=0)
        sidebands = whole(sidebands, "sidebands", least=0)
        named = [
            *self._shafts(shaft_harmonics),
            *self._meshes(mesh_harmonics, 0),
            *self._meshes(mesh_harmonics, sidebands),
        ]
        merged: list[tuple[float, list[str]]] = []
        # The sort keeps what is simpler first among equals.
        for value, name in sorted(named, key=lambda pair: pair[0]):
            if merged and math.isclose(merged[-1][0], value, rel_tol=SAME):
                merged[-1][1].append(name)
            else:
                merged.append((value, [name]))
        rank = {name: place for place, (_, name) in enumerate(named)}
        return tuple(
            Order(value, tuple(sorted(names, key=rank.__getitem__))) for value, names in merged
        )

    def _shafts(self, harmonics: int) -> Iterator[tuple[float, str]]:
        for n in range(1, harmonics + 1):
            for name, ratio in self.shafts:
                yield n * ratio, f"{n}× {name}"

    def _meshes(self, harmonics: int, sidebands: int) -> Iterator[tuple[float, str]]:
        """Tooth frequencies where there are no sidebands, or else the sidebands alone."""
        ratios = dict(self.shafts)
        for m in range(1, harmonics + 1):
            for driver, driven, *shafts, tooth in self.meshes:
                name = f"{m}× mesh {driver}–{driven}"
                if not sidebands:
                    yield m * tooth, name
                for n in range(1, sidebands + 1):
                    for shaft in shafts:
                        for sign, word in ((1.0, "+"), (-1.0, "−")):
                            value = m * tooth + sign * n * ratios[shaft]
                            if value > 0.0:
                                yield value, f"{name} {word} {n}× {shaft}"
