"""Types shared by the wrapper and the stubs of the compiled core."""

from collections.abc import Callable
from typing import Any, Literal, TypeAlias, TypedDict

import numpy as np
from numpy.typing import NDArray

Array: TypeAlias = NDArray[np.float64]
ComplexArray: TypeAlias = NDArray[np.complex128]

#: Plain data passed to the core: dict, list, str, bool, int, float.
Plain: TypeAlias = Any
#: Name of a gear or disk, or (shaft, position [m]).
At: TypeAlias = str | tuple[str, float]
#: A quantity to record: a name, a group, (shaft, position), (driver, driven),
#: ("bearing", shaft, position).
Record: TypeAlias = str | tuple[str, float] | tuple[str, str] | tuple[str, str, float]
#: A degree of freedom of a node: shaft, position [m], one of "u", "v", "w", "B", "G", "twist".
NodalDof: TypeAlias = tuple[str, float, str]
#: One degree of freedom: of a node, or of an element with the positions of its ends [m] and the
#: degree of its shape function, for example ("input", (0.0, 0.1), "v2").
Dof: TypeAlias = tuple[str, float | tuple[float, float], str]
#: Geometry of the meshes of a run: it follows the motion, or is that at rest.
Geometry: TypeAlias = Literal["live", "frozen"]
#: State in which a run begins.
InitialState: TypeAlias = Literal["synchronous", "static", "rest"]
#: Method of time integration.
Method: TypeAlias = Literal["exponential", "rk45", "rk4", "etdrk4"]
#: Accuracy level.
Accuracy: TypeAlias = Literal["draft", "engineering", "reference"]
#: Motion of the shafts that a system has.
ShaftMotion: TypeAlias = Literal["lateral", "torsion", "coupled"]
#: What a branch of steady states is followed over.
BranchParameter: TypeAlias = Literal["speed", "torque", "bow", "backlash"]
#: Statistic of a signal over a period.
Statistic: TypeAlias = Literal["min", "max", "mean", "rms"]
#: Model of the mesh stiffness.
StiffnessModel: TypeAlias = Literal[
    "constant", "iso6336", "square", "parabolic", "potential_energy", "table", "fourier"
]
#: Angle that the phase of a mesh follows: with the twist, or of the prescribed rotation.
MeshPhase: TypeAlias = Literal["twist", "prescribed"]
#: Gear bodies of the tooth pairs in contact.
Foundation: TypeAlias = Literal["separate", "shared"]
#: What holds outside the speeds of a table.
OutsideTable: TypeAlias = Literal["error", "hold"]
#: Coefficients of a bearing.
BearingQuantity: TypeAlias = Literal["stiffness", "damping"]
#: The two axes across the shaft in a table of another program.
TableAxes: TypeAlias = Literal["yz", "zy", "xy", "yx", "xz", "zx"]
#: Kind of the rolling elements.
RollingContact: TypeAlias = Literal["ball", "roller"]
#: Kind of a rolling bearing whose elements are estimated from its boundary dimensions.
RollingKind: TypeAlias = Literal[
    "deep_groove", "angular_contact", "cylindrical_roller", "tapered_roller", "needle_cage"
]
#: Model of an oil film.
FilmModel: TypeAlias = Literal["short", "finite"]
#: Profile of the bore of a journal bearing.
Profile: TypeAlias = Literal[
    "plain", "two axial grooves", "lemon", "offset", "three-lobe", "four-lobe"
]
#: Frequency at which the tilts of pads are eliminated from the coefficients of their bearing.
Reduction: TypeAlias = Literal["synchronous", "own"]
#: Where an oil film ruptures.
Rupture: TypeAlias = Literal["reynolds", "gumbel"]
#: What excites the synchronous response.
Excitation: TypeAlias = Literal["both", "bow", "unbalance"]
#: What balancing cancels.
BalanceTarget: TypeAlias = Literal["total", "elastic"]
#: Window of a spectrum.
Window: TypeAlias = Literal["hann", "flat top", "none"]
#: What a figure of a run shows.
RunFigure: TypeAlias = Literal[
    "orbits", "history", "twist", "mesh", "geometry", "bearings", "spectrum", "section forces"
]
#: What a figure of an equilibrium shows.
StaticFigure: TypeAlias = Literal["deflection", "section forces"]
#: Language of a report: English or German.
Language: TypeAlias = Literal["en", "de"]
#: How a mean stress lowers the amplitude that a shaft endures.
StrengthLine: TypeAlias = Literal["goodman", "din743"]
#: Side of a node: just before it, or just beyond it.
Side: TypeAlias = Literal["before", "beyond"]
#: Shaft, position [m] and side of a section; "before" between nodes.
Section: TypeAlias = tuple[str, float, str]
#: A recorded quantity of a place, a bearing or a mesh.
SignalQuantity: TypeAlias = Literal[
    "y",
    "z",
    "x",
    "twist",
    "velocity_y",
    "velocity_z",
    "velocity_x",
    "twist_rate",
    "acceleration_y",
    "acceleration_z",
    "acceleration_x",
    "force",
    "deflection",
    "stiffness",
    "pressure_angle",
    "centre_distance",
    "centre_line_angle",
    "contact_ratio",
    "pairs_in_contact",
    "thrust",
    "friction_force",
    "friction_power",
    "energy",
    "axial_force",
    "shear_y",
    "shear_z",
    "moment_y",
    "moment_z",
    "torque",
]
#: Quantity of a place that is differentiated.
SensitivityQuantity: TypeAlias = Literal[
    "displacement", "velocity", "acceleration", "twist", "axial_displacement", "bearing_force"
]
#: Horizontal axis of a figure of a run.
Abscissa: TypeAlias = Literal["time", "speed", "angle"]
#: What a figure of a frequency response shows.
FrequencyFigure: TypeAlias = Literal["bode", "nyquist", "waterfall"]
#: Kind of the figure of a synchronous response.
SynchronousFigure: TypeAlias = Literal["orbit", "bode", "polar"]
#: Quantity of a place in a figure of a frequency response.
FrequencyQuantity: TypeAlias = Literal[
    "displacement", "velocity", "acceleration", "twist", "bearing_force"
]
#: Direction across the shafts.
LateralDirection: TypeAlias = Literal["y", "z"]
#: Kind of a motion that a source prescribes.
MotionQuantity: TypeAlias = Literal["displacement", "velocity", "acceleration"]
#: A function called with the completed fraction of a run.
Progress: TypeAlias = Callable[[float], object]


#: Entries, columns and row starts of a sparse matrix.
Rows: TypeAlias = tuple[Array, NDArray[np.int64], NDArray[np.int64]]


class SparseMatricesData(TypedDict):
    """Sparse system matrices."""

    mass: Rows
    stiffness: Rows
    damping: Rows
    gyroscopic: Rows


class MatricesData(TypedDict):
    """System matrices, each (n, n)."""

    mass: Array
    stiffness: Array
    damping: Array
    gyroscopic: Array


class ModesData(TypedDict):
    """Modes in ascending order of |λ|: m modes of n degrees of freedom."""

    eigenvalues: ComplexArray
    frequencies_hz: Array
    damping_ratios: Array
    whirl: list[str]
    residuals: Array
    shapes: ComplexArray
    kinetic_shares: Array
    vibrates: NDArray[np.bool_]


class CampbellData(TypedDict):
    """Modes at k speeds, (k, m), their intersections with excitation lines, and thresholds."""

    eigenvalues: ComplexArray
    whirl: list[list[str]]
    lines: list[dict[str, Any]]
    intersections: list[dict[str, Any]]
    thresholds: list[dict[str, Any]]


class NullVectors(TypedDict):
    """Right and left vectors of an eigenvalue (count, n), and products of them with its slope."""

    right: ComplexArray
    left: ComplexArray
    slopes: ComplexArray
    has_more: bool
    is_accurate: bool


class DampedMotions(TypedDict):
    """Shapes and momenta (m, n) of undamped modes, their ω² (m,), and the number with damping."""

    shapes: Array
    momenta: Array
    squares: Array
    damped: int


class HarmonicData(TypedDict):
    """Phasors by pair of frequency and speed, source and degree of freedom; forces likewise."""

    phasors: ComplexArray
    residuals: Array
    bearings: list[tuple[str, float]]
    bearing_force: ComplexArray
    bearing_displacement: ComplexArray
    meshes: list[tuple[str, str]]
    mesh_force: ComplexArray


class SynchronousData(HarmonicData):
    """The same by speed and source shaft, and the bow of every shaft."""

    bow: ComplexArray


class BalanceData(TypedDict, total=False):
    """At given displacements: forces that remain, and displacements without null motions (n,)."""

    unbalanced: Array
    without_null_motions: Array


class StaticData(BalanceData):
    """Static equilibrium: n degrees of freedom, the meshes and the bearings."""

    state: Array
    residuals: list[tuple[str, float]]
    meshes: list[tuple[str, str]]
    mesh: dict[str, Array]
    bearings: list[tuple[str, float]]
    bearing_force: Array
    bearing_displacement: Array
    axial_bearing_force: Array
    contact_forces: list[Array | None]


class FilmData(TypedDict):
    """Equilibrium of one journal bearing: displacement (2,) and coefficients (2, 2)."""

    displacement: list[float]
    stiffness: Array
    damping: Array
    pads: list["PadData"]


class PadData(TypedDict):
    """Film of one pad along the middle of its length: angles, thickness and pressure."""

    angles: Array
    thickness: Array
    pressure: Array
    pivot: float | None


class MeshGeometry(TypedDict):
    """Geometry of one mesh at rest, in m and rad; radii of an internal gear are negative."""

    centre_distance: float
    pressure_angle: float
    base_radii: tuple[float, float]
    tip_radii: tuple[float, float]
    root_radii: tuple[float, float]


class RollingData(TypedDict):
    """Equilibrium of one rolling bearing; its elements, stiffness of one, speed of the cage."""

    displacement: list[float]
    stiffness: Array
    damping: Array
    contact_forces: list[float]
    elements: int
    hertz_stiffness: float
    cage_ratio: float


class RunOptions(TypedDict):
    """Options of a run that are numbers and texts; `src/python/options.rs` reads them."""

    duration: float
    speed: Plain
    method: str
    step: float | None
    rtol: float | None
    stages: int | None
    modes: int | None
    accuracy: str | None
    geometry: str
    start: float


#: A checkpoint: the final state of a run, and its counters and recorder state.
CoreCheckpoint: TypeAlias = tuple[dict[str, Any], dict[str, Plain]]


class _Paused(TypedDict, total=False):
    """Entries that a run needs in addition to its final state to continue."""

    checkpoint: dict[str, Plain]


class _Optional(_Paused, total=False):
    """Arrays at k times that a run may lack: rates, axial motion, what older files do not have."""

    velocity: Array
    twist_rate: Array
    acceleration: Array
    axial: Array
    axial_velocity: Array
    axial_acceleration: Array
    axial_bearing_force: Array
    bearing_displacement: Array
    #: (N, Q_y, Q_z) and (M_y, M_z, T) of each section.
    section_force: Array
    section_moment: Array


class RunData(_Optional):
    """The response of a simulation at k times; `src/python/response.rs` writes it."""

    time: Array
    points: list[tuple[str, float, list[str]]]
    displacement: Array
    twist: Array
    bearings: list[tuple[str, float]]
    bearing_force: Array
    rolling_bearings: list[tuple[str, float]]
    rolling_contact: Array
    sections: list[Section]
    meshes: list[tuple[str, str]]
    mesh: dict[str, Array]
    energy: Array | None
    energy_terms: dict[str, Array] | None
    events: list[tuple[float, str, str, str]]
    final: dict[str, Any]
    statistics: dict[str, Any]
