"""Shafts of a REXS file: their sections, and where parts lie on them.

The axes u, v and w of the reference shaft, with u along the shaft, are x, y and z here.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from gearbow._types import Array, Plain
from gearbow.exchange.rexs_file import Component, RexsFile

#: Largest difference of positions that counts as rounding of the file [m].
_ROUNDING = 1e-6
#: Most components that refer to the position of the next one; a gear unit has two or three.
_MAX_REFERENCES = 100
#: Largest sine of the angle between parallel shafts.
_MAX_SINE = 1e-6


@dataclass(frozen=True)
class Frame:
    """Origin [m] and axes u, v, w (rows) of a component in the coordinates of the gear unit."""

    origin: Array
    axes: Array


@dataclass(frozen=True)
class PlacedShaft:
    """A shaft and its place in the train."""

    component: Component
    name: str
    #: Sections in the order along +x, with the u coordinates of their ends [m].
    sections: tuple[tuple[Component, float, float], ...]
    frame: Frame | None
    #: Whether u points along +x, 1.0, or along −x, −1.0.
    sense: float
    #: Where its axis crosses the plane y, z of the reference shaft [m].
    axis: Array | None

    def position(self, u: float) -> float:
        """Give the position from the left end [m]."""
        begin = self.sections[0][1] if self.sense > 0.0 else self.sections[0][2]
        found = self.sense * (u - begin)
        return 0.0 if abs(found) < _ROUNDING else found


class Shafts:
    """The shafts of a file, and the frames of its components."""

    def __init__(self, file: RexsFile, reference: Component, notes: list[str]) -> None:
        self._file = file
        self._notes = notes
        self.reference = self.frame(reference) or Frame(np.zeros(3), np.eye(3))

    def frame(self, component: Component, below: tuple[int, ...] = ()) -> Frame | None:
        """Find the frame of a component; None if the file does not place it."""
        origin = component.vector("support_vector", "length")
        if origin is None:
            return None
        u = self._unit(component, "u_axis_vector", (1.0, 0.0, 0.0))
        w = self._unit(component, "w_axis_vector", (0.0, 0.0, 1.0))
        if abs(u @ w) > _MAX_SINE:
            raise component.error("u_axis_vector and w_axis_vector must be at right angles")
        axes = np.array([u, np.cross(w, u), w])
        base = None
        if component.has("reference_component_for_position"):
            number = component.count("reference_component_for_position")
            if number in below or len(below) > _MAX_REFERENCES:
                raise component.error("reference_component_for_position: refers back to itself")
            if number != component.id:
                if number not in self._file.components:
                    raise component.error(
                        f"reference_component_for_position: there is no component {number}"
                    )
                base = self.frame(self._file.components[number], (*below, component.id))
        if base is None:
            return Frame(origin, axes)
        return Frame(base.origin + base.axes.T @ origin, axes @ base.axes)

    def _unit(self, component: Component, name: str, default: tuple[float, ...]) -> Array:
        found = component.vector(name, "length")
        found = np.array(default) if found is None else found
        length = math.hypot(*found.tolist())
        if not 0.0 < length < math.inf:
            raise component.error(f"{name}: must have a length above 0")
        return found / length

    def place(self, component: Component, name: str, sections: Iterable[Component]) -> PlacedShaft:
        """Find the place of a shaft, and order its sections."""
        ordered = self._sections(component, sections)
        frame = self.frame(component)
        if frame is None:
            return PlacedShaft(component, name, ordered, None, 1.0, None)
        axes = frame.axes @ self.reference.axes.T
        sense = math.copysign(1.0, axes[0, 0])
        if math.hypot(axes[0, 1], axes[0, 2]) > _MAX_SINE:
            raise component.error("must be parallel to the other shafts; see its u_axis_vector")
        axis = (self.reference.axes @ (frame.origin - self.reference.origin))[1:]
        if sense < 0.0:
            ordered = ordered[::-1]
        return PlacedShaft(component, name, ordered, frame, sense, axis)

    def _sections(
        self, shaft: Component, sections: Iterable[Component]
    ) -> tuple[tuple[Component, float, float], ...]:
        found = []
        for section in sections:
            begin = section.number("u_coordinate_on_shaft", "position")
            found.append((section, begin, begin + section.number("length", "length")))
        found.sort(key=lambda each: each[1])
        if not found:
            raise shaft.error("has no shaft_section")
        for (before, _, end), (section, begin, _) in pairwise(found):
            if abs(begin - end) > _ROUNDING:
                raise shaft.error(
                    f"{section} begins at {1e3 * begin:g} mm, but {before} before it ends at "
                    f"{1e3 * end:g} mm; sections must join, without gaps and layers"
                )
        return tuple(found)

    def locate(self, component: Component, shaft: PlacedShaft, name: str) -> float:
        """Find the position of a component on a shaft [m]; `name` is its coordinate in the file."""
        # The coordinate of a gear is its middle or its begin: files differ, and its
        # support_vector, which is its middle, decides.
        frame = self.frame(component)
        given = component.number(name, "position") if component.has(name) else None
        if frame is None or shaft.frame is None:
            if given is None:
                raise component.error(f"needs the attribute {name}")
            if component.has("face_width"):
                self._notes.append(
                    f"{name} of gears without support_vector counts as the middle of the face width"
                )
            return shaft.position(given)
        u = float(shaft.frame.axes[0] @ (frame.origin - shaft.frame.origin))
        candidates = [] if given is None else [given]
        if given is not None and component.has("face_width"):
            candidates.append(given + 0.5 * component.number("face_width", "face_width"))
        for each in candidates:
            if abs(each - u) < _ROUNDING:
                return shaft.position(each)
        if given is not None:
            self._notes.append(
                f"{component}: its support_vector is at {1e3 * u:g} mm on the shaft, which is "
                f"used; {name} is {1e3 * given:g} mm"
            )
        return shaft.position(u)

    def across(self, component: Component, shaft: PlacedShaft, names: tuple[str, str]) -> complex:
        """Give a vector across the shaft as y + iz, in N; absent parts are zero."""
        v, w = (component.number(name, "load", 0.0) for name in names)
        if shaft.frame is None:
            return complex(v, w)
        axes = shaft.frame.axes @ self.reference.axes.T
        y, z = v * axes[1, 1:] + w * axes[2, 1:]
        return complex(y, z)


def segment(section: Component, sense: float) -> dict[str, Plain]:
    """Give a segment with the diameters of a section, from its left to its right end."""
    found: dict[str, Plain] = {"length": section.number("length", "length")}
    for side, default in (("outer_diameter", None), ("inner_diameter", 0.0)):
        left, right = (section.number(f"{side}_{end}", side, default) for end in ("begin", "end"))
        if sense < 0.0:
            left, right = right, left
        if left != 0.0:
            found[side] = left
        if abs(left - right) > _ROUNDING:
            found[f"end_{side}"] = right
    return found
