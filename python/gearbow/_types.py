"""Types shared by the wrapper and the stubs of the compiled core."""

from collections.abc import Callable
from typing import Any, TypeAlias, TypedDict

import numpy as np
from numpy.typing import NDArray

Array: TypeAlias = NDArray[np.float64]
ComplexArray: TypeAlias = NDArray[np.complex128]

#: Plain data that crosses into the core: dict, list, str, bool, int, float.
Plain: TypeAlias = Any
#: A gear or disk by its name, or a place as (shaft, position [m]).
At: TypeAlias = str | tuple[str, float]
#: What a response can record: a name, a group, (shaft, position), (driver, driven),
#: ("bearing", shaft, position).
Record: TypeAlias = str | tuple[str, float] | tuple[str, str] | tuple[str, str, float]
#: One degree of freedom: shaft, position [m], one of "v", "w", "B", "G", "twist".
Dof: TypeAlias = tuple[str, float, str]
Progress: TypeAlias = Callable[[float], object]


class MatricesData(TypedDict):
    """System matrices, each (n, n)."""

    mass: Array
    stiffness: Array
    damping: Array
    gyroscopic: Array


class ModesData(TypedDict):
    """Modes in ascending order of frequency; m modes of n degrees of freedom."""

    eigenvalues: ComplexArray
    frequencies_hz: Array
    damping_ratios: Array
    whirl: list[str]
    shapes: ComplexArray


class CampbellData(TypedDict):
    """Modes at k speeds, m of them in every row, and where they meet excitation lines."""

    eigenvalues: ComplexArray
    whirl: list[list[str]]
    lines: list[tuple[str, list[str], int]]
    orders: Array
    intersection_modes: list[int]
    intersection_lines: list[int]
    intersection_speeds: Array
    intersection_eigenvalues: ComplexArray
    intersection_whirl: list[str]


class SynchronousData(TypedDict):
    """Amplitudes by speed, source and degree of freedom; bearing forces as (y, z) pairs."""

    amplitudes: ComplexArray
    bearings: list[tuple[str, float]]
    bearing_force: ComplexArray
    bow: ComplexArray


class StaticData(TypedDict):
    """Static equilibrium: n degrees of freedom, the meshes and the bearings."""

    state: Array
    meshes: list[tuple[str, str]]
    mesh: dict[str, Array]
    bearings: list[tuple[str, float]]
    bearing_force: Array


#: Where a run was stopped: its final state, and what it had counted and seen.
CoreCheckpoint: TypeAlias = tuple[dict[str, Any], dict[str, Plain]]


class _Paused(TypedDict, total=False):
    """What the same run needs beside its final state to go on."""

    checkpoint: dict[str, Plain]


class RunData(_Paused):
    """What a simulation recorded at k times."""

    time: Array
    points: list[tuple[str, float, list[str]]]
    displacement: Array
    twist: Array
    bearings: list[tuple[str, float]]
    bearing_force: Array
    meshes: list[tuple[str, str]]
    mesh: dict[str, Array]
    energy: Array | None
    energy_terms: dict[str, Array] | None
    events: list[tuple[float, str, str, str]]
    final: dict[str, Any]
    statistics: dict[str, Any]
