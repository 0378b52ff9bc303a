"""Mode shapes in universal files: nodes as data set 15, and one data set 55 for each mode."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gearbow._convert import shown
from gearbow._extras import extra
from gearbow._read_only import ReadOnly
from gearbow._types import Array, At, ComplexArray
from gearbow.errors import SceneError

__all__ = ["MeasuredShapes", "read_uff", "write_uff"]

#: Analysis types of data set 55: normal modes, and complex modes of displacements and velocities.
_NORMAL, _COMPLEX, _VELOCITY = 2, 3, 7
#: What id5 says of a file of gearbow, whose nodes are those of the system in their order.
_OWN = "gearbow"


@dataclass(frozen=True, eq=False)
class MeasuredShapes(ReadOnly):
    """Measured mode shapes.

    Parameters
    ----------
    places : tuple of (str or (str, float))
        Places of the motions.
    frequencies_hz : ndarray, shape (k,)
        Natural frequencies [Hz].
    displacements : ndarray, shape (k, places, 2)
        Shapes along y and z, in any unit; NaN for what was not measured.

    Examples
    --------
    >>> import numpy as np
    >>> import gearbow as gb
    >>> shapes = np.array([[[1.0, np.nan], [0.5, np.nan]]])
    >>> measured = gb.results.MeasuredShapes(("pinion", ("input", 0.0)), np.array([81.0]), shapes)
    >>> measured.displacements.shape
    (1, 2, 2)
    """

    places: tuple[At, ...]
    frequencies_hz: Array
    displacements: ComplexArray


def write_uff(
    path: Path,
    *,
    positions: Array,
    displacements: ComplexArray,
    eigenvalues: ComplexArray,
    names: Sequence[str],
    speed: float,
) -> None:
    """Write positions (nodes, 3) and displacements (modes, nodes, 3) of modes."""
    with extra("uff"):
        import pyuff  # noqa: PLC0415

    numbers = np.arange(1, len(positions) + 1)
    zeros = np.zeros(numbers.size, dtype=np.int64)
    sets: list[dict[str, object]] = [
        {
            "type": 15,
            "node_nums": numbers,
            "def_cs": zeros,
            "disp_cs": zeros,
            "color": zeros,
            **dict(zip("xyz", positions.T, strict=True)),
        }
    ]
    for number, (value, shape, name) in enumerate(
        zip(eigenvalues, displacements, names, strict=True), start=1
    ):
        sets.append(
            {
                "type": 55,
                "id1": f"mode {number}, {name}"[:80],
                "id2": f"{abs(value.imag) / (2.0 * np.pi):.9g} Hz",
                "id3": f"at {speed:g} rad/s of the reference shaft",
                "id4": "displacements along x, y, z",
                "id5": _OWN,
                "model_type": 1,
                "analysis_type": _COMPLEX,
                "data_ch": 2,
                "spec_data_type": 8,
                "data_type": 5,
                "n_data_per_node": 3,
                "load_case": 0,
                "mode_n": number,
                "eig": complex(value),
                "modal_a": 0j,
                "modal_b": 0j,
                "node_nums": numbers,
                **{f"r{i}": shape[:, i - 1] for i in (1, 2, 3)},
            }
        )
    pyuff.UFF(str(path)).write_sets(sets, mode="overwrite")


def read_uff(path: Path, places: Mapping[int, At] | None, nodes: Sequence[At]) -> MeasuredShapes:
    """Read the modes of a universal file; `nodes` are the places of a file of gearbow."""
    with extra("uff"):
        import pyuff  # noqa: PLC0415

    file = pyuff.UFF(str(path))
    found = []
    for index in np.flatnonzero(np.atleast_1d(file.get_set_types()) == 55):
        given = file.read_sets(int(index))
        if given["analysis_type"] in (_NORMAL, _COMPLEX, _VELOCITY):
            found.append(given)
    if not found:
        raise SceneError(f"{path}: has no mode shape (data set 55)")
    numbers = [int(number) for number in found[0]["node_nums"]]
    own = str(found[0].get("id5", "")).strip() == _OWN
    known = dict(places or (enumerate(nodes, start=1) if own else ()))
    used = [number for number in numbers if number in known]
    if not used:
        raise SceneError(
            f"places: needs the place of a node of {path}, for example "
            f'places={{{numbers[0]}: ("input", 0.2)}}, got {shown(places)}'
        )
    frequencies, shapes = [], []
    for given in found:
        rows = {int(number): i for i, number in enumerate(given["node_nums"])}
        if any(number not in rows for number in used):
            raise SceneError(f"{path}: every mode must have the nodes {used}")
        own_rows = [rows[number] for number in used]
        parts = [np.asarray(given[name], dtype=np.complex128)[own_rows] for name in ("r2", "r3")]
        shapes.append(np.stack(parts, axis=-1))
        if given["analysis_type"] == _NORMAL:
            frequencies.append(float(given["freq"]))
        else:
            frequencies.append(abs(complex(given["eig"]).imag) / (2.0 * np.pi))
    return MeasuredShapes(
        tuple(known[number] for number in used), np.array(frequencies), np.array(shapes)
    )
