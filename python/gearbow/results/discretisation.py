"""Number and degree of the elements of a system, and what to expect of them."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

from gearbow._shown import Shown
from gearbow._types import Plain


@dataclass(frozen=True)
class ShaftElements(Shown):
    """Elements of one shaft."""

    numbers: tuple[int, ...]
    degree: int


@dataclass(frozen=True)
class Discretisation(Shown):
    """Elements of a system.

    Parameters
    ----------
    shafts : mapping of {str: ShaftElements}
        Elements of each shaft.
    coordinates : int
        Number of degrees of freedom of the system.
    level : str or None
        Level of the chosen elements; None if all numbers are given.
    expected_error : float or None
        Expected error of the mesh forces, or of the displacements in a scene without meshes, from
        the response to a step of the load: RMS of the difference / RMS of the signal about its
        mean, over 0.1 s. None if all numbers are given.
    permitted_error : float or None
        Largest error that the level permits. The chosen elements exceed it only where a system
        would have more than 1200 coordinates.
    highest_frequency_hz : float or None
        Highest natural frequency with a relative error of at most 1e-3 [Hz].

    Examples
    --------
    >>> import gearbow as gb
    >>> rotor = gb.Shaft("rotor", length=1.0, outer_diameter=0.05, bow=gb.Bow.half_sine(1e-4))
    >>> bearings = [gb.Bearing("rotor", x, stiffness=1e8) for x in (0.0, 1.0)]
    >>> system = gb.RotorSystem([rotor], bearings=bearings)
    >>> system.discretisation.shafts["rotor"].degree > 1
    True
    """

    shafts: Mapping[str, ShaftElements]
    coordinates: int
    level: str | None = None
    expected_error: float | None = None
    permitted_error: float | None = None
    highest_frequency_hz: float | None = None

    @classmethod
    def of(
        cls,
        description: Mapping[str, Plain],
        choice: tuple[str, float, float, float] | None,
        coordinates: int,
    ) -> "Discretisation":
        """Collect the elements of a system.

        Parameters
        ----------
        description : mapping
            The scene as plain data, with numbers and degrees.
        choice : tuple or None
            Level, expected error, permitted error, and highest frequency [rad/s].
        coordinates : int
            Number of degrees of freedom.

        Returns
        -------
        Discretisation
            The elements.
        """
        shafts = {}
        for shaft in description["shafts"]:
            parts = shaft.get("segments", [shaft])
            numbers = tuple(part.get("elements", 1) for part in parts)
            shafts[shaft["name"]] = ShaftElements(numbers, shaft.get("degree", 1))
        if choice is None:
            return cls(shafts, coordinates)
        level, expected, permitted, highest = choice
        return cls(shafts, coordinates, level, expected, permitted, highest / (2.0 * math.pi))

    def __str__(self) -> str:
        lines = [
            f"{name}: {' + '.join(map(str, each.numbers))} elements of degree {each.degree}"
            for name, each in self.shafts.items()
        ]
        lines.append(f"{self.coordinates} degrees of freedom")
        if self.level is not None:
            lines.append(
                f"{self.level}: expected error {self.expected_error:.0e}, at most "
                f"{self.permitted_error:.0e}; frequencies up to {self.highest_frequency_hz:.0f} Hz "
                "are accurate to 1e-3"
            )
        return "\n".join(lines)
