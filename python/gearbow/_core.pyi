"""Types of the compiled core."""

from collections.abc import Callable, Mapping
from typing import Any, Final, final

from typing_extensions import Self, Unpack

from gearbow._types import (
    Array,
    At,
    CampbellData,
    ComplexArray,
    CoreCheckpoint,
    DampedMotions,
    Dof,
    FilmData,
    HarmonicData,
    MatricesData,
    MeshGeometry,
    ModesData,
    NullVectors,
    Plain,
    Record,
    RollingData,
    RunData,
    RunOptions,
    SparseMatricesData,
    StaticData,
    SynchronousData,
)

__all__ = [
    "SHARE_OF_MEAN",
    "KeptModes",
    "Model",
    "__version__",
    "accuracy_levels",
    "check_final",
    "check_speed",
    "common_period",
    "connection_channels",
    "corrected_states",
    "film_coefficients",
    "has_constant_coefficients",
    "initial_state",
    "kept_modes",
    "mesh_geometry",
    "motion_forms",
    "multipliers",
    "panic_in_analysis",
    "recorded_period",
    "require_memory",
    "ring_coefficients",
    "rolling_coefficients",
    "rolling_estimate",
    "shaft_motion",
    "shaft_origins",
    "slowest_period",
    "squeeze_force",
    "steady_state",
    "table_at_frequency",
    "user_order",
    "whirl_classes",
]

SHARE_OF_MEAN: Final[float]
__version__: str

def accuracy_levels() -> dict[str, dict[str, float]]: ...
def check_final(last: Mapping[str, Any], checkpoint: Plain | None = None) -> None: ...
def check_speed(breaks: list[float], coefficients: list[list[float]]) -> None: ...
def connection_channels() -> dict[str, dict[str, str]]: ...
def film_coefficients(
    bearing: dict[str, Plain],
    load: tuple[float, float],
    speed: float,
    frequency: float | None = None,
) -> FilmData: ...
def squeeze_force(
    support: dict[str, Plain], displacement: tuple[float, float], velocity: tuple[float, float]
) -> list[float]: ...
def motion_forms(
    rates: ComplexArray,
    speeds: Array,
    entries: tuple[Any, Any, ComplexArray],
    adjoint: ComplexArray,
    phasors: ComplexArray,
    integrations: list[int],
) -> ComplexArray: ...
def mesh_geometry(description: Mapping[str, Plain]) -> list[MeshGeometry]: ...
def shaft_motion(
    description: Mapping[str, Plain], shaft: str, positions: list[float]
) -> dict[str, Array]: ...
def shaft_origins(description: Mapping[str, Plain]) -> list[list[float]]: ...
def require_memory(argument: str, what: str, needed: float, remedy: str) -> None: ...
def ring_coefficients(
    bearing: dict[str, Plain], load: tuple[float, float, float], tilt: tuple[float, float]
) -> dict[str, Plain]: ...
def rolling_coefficients(
    bearing: dict[str, Plain], load: tuple[float, float], cage: float | None = None
) -> RollingData: ...
def rolling_estimate(bearing: dict[str, Plain]) -> dict[str, Any] | None: ...

@final
class KeptModes:
    @property
    def modes(self) -> int: ...
    @property
    def modes_error(self) -> tuple[float, float]: ...

@final
class Model:
    def __new__(cls, description: dict[str, Plain]) -> Self: ...
    @staticmethod
    def from_toml(text: str) -> Model: ...
    def to_toml(self) -> str: ...
    def share(self, other: Model) -> bool: ...
    def changed(self, description: Mapping[str, Plain], is_variation: bool) -> Model: ...
    def description(self) -> dict[str, Plain]: ...
    @property
    def choice(self) -> tuple[str, float, float, float] | None: ...
    @property
    def has_meshes(self) -> bool: ...
    def expected_error(self, speed: float | None = None) -> float: ...
    def resolved(self) -> dict[str, Plain]: ...
    @property
    def warnings(self) -> list[str]: ...
    @property
    def dofs(self) -> list[Dof]: ...
    def embed(self, coarser: Model, state: Array) -> Array: ...
    @property
    def shafts(self) -> list[str]: ...
    @property
    def speed_ratios(self) -> Array: ...
    @property
    def ratios_in_frames(self) -> Array: ...
    def indices(self, at: At) -> tuple[int | None, int | None, int | None]: ...
    def mesh_gradients(self, speed: float) -> Array: ...
    def mass_properties(self) -> list[list[float]]: ...
    def sections(
        self, shaft: str, positions: list[float] | None = None
    ) -> list[tuple[tuple[str, float, str], list[float]]]: ...
    def static_section_forces(
        self, shaft: str, positions: list[float] | None, state: Array, speed: float
    ) -> Array: ...
    def harmonic_section_forces(
        self, shaft: str, positions: list[float] | None, motions: dict[str, Any]
    ) -> ComplexArray: ...
    def matrices(self, speed: float = 0.0, frequency: float | None = None) -> MatricesData: ...
    def sparse_matrices(
        self, speed: float = 0.0, frequency: float | None = None
    ) -> SparseMatricesData: ...
    def modes(
        self, speed: float, count: int | None = None, vibrating: bool = False
    ) -> ModesData: ...
    def campbell(self, speeds: Array, count: int, harmonics: int, threads: int) -> CampbellData: ...
    def critical_speeds(
        self, order: float, count: int | None = None
    ) -> list[tuple[float, str]]: ...
    def critical_speed_map(
        self, stiffnesses: Array, order: float, count: int | None, threads: int
    ) -> list[list[tuple[float, str, float, int]]]: ...
    def synchronous(self, speeds: Array, excitation: str, threads: int) -> SynchronousData: ...
    def frequency_response(
        self, frequencies: Array, speeds: Array, sources: list[dict[str, Plain]], threads: int
    ) -> HarmonicData: ...
    def peaks(
        self,
        samples: list[tuple[float, float]],
        index: int,
        source: int,
        excitation: str,
        slow_roll: float | None,
    ) -> list[tuple[float, float, float, float, bool]]: ...
    @property
    def depends_on_speed(self) -> bool: ...
    def harmonic_terms(
        self,
        at: tuple[float, float, float],
        scale: float,
        sources: list[dict[str, Plain]],
        outputs: ComplexArray | tuple[str, int],
        base: tuple[Model, ComplexArray | tuple[str, int]] | None = None,
    ) -> tuple[Any, Any, ComplexArray]: ...
    def null_vectors(
        self, eigenvalue: tuple[float, float], speed: float, count: int, highest: float
    ) -> NullVectors: ...
    def damped_motions(self, speed: float, highest: float) -> DampedMotions: ...
    def damping_rates(self, squares: Array) -> Array: ...
    def harmonic_adjoint(
        self, frequencies: Array, speeds: Array, outputs: ComplexArray | tuple[str, int]
    ) -> ComplexArray: ...
    def static_changes(self, geometry: str, speed: float, state: Array, forces: Array) -> Array: ...
    def static(
        self, geometry: str = "live", speed: float = 0.0, state: Array | None = None
    ) -> StaticData: ...
    def losses(
        self, speeds: list[float], geometry: str
    ) -> list[tuple[float, list[list[float]]]]: ...
    def record_bytes(self, record: list[Record], times: int) -> int: ...
    def default_output_step(self, duration: float, speed: Plain, start: float) -> float: ...
    def simulate(
        self,
        *,
        initial: str | dict[str, Any],
        times: Array,
        record: list[Record],
        progress: Callable[[float], object] | None,
        checkpoint: CoreCheckpoint | None,
        **options: Unpack[RunOptions],
    ) -> RunData: ...

def common_period(model: Model, speed: float, given: float | None, longest: float) -> float: ...
def slowest_period(model: Model, speed: float) -> float | None: ...
def steady_state(
    model: Model,
    *,
    initial: str | dict[str, Any],
    samples: int,
    record: list[Record],
    progress: Callable[[float], object] | None,
    slowest: float | None,
    **options: Unpack[RunOptions],
) -> tuple[RunData, dict[str, Any]]: ...
def table_at_frequency(table: dict[str, Plain], frequency: float) -> Plain: ...
def user_order(model: Model, state: Array) -> Array: ...
def corrected_states(
    model: Model,
    *,
    initial: str | dict[str, Any],
    states: Array,
    levels: bytes | None,
    kept: KeptModes | None = None,
    **options: Unpack[RunOptions],
) -> tuple[Array, bytes]: ...
def has_constant_coefficients(model: Model, geometry: str) -> bool: ...
def initial_state(
    model: Model, *, initial: str | dict[str, Any], **options: Unpack[RunOptions]
) -> Array: ...
def kept_modes(
    model: Model,
    *,
    initial: str | dict[str, Any],
    record: list[Record],
    **options: Unpack[RunOptions],
) -> KeptModes | None: ...
def recorded_period(
    model: Model,
    *,
    initial: str | dict[str, Any],
    state: Array,
    samples: int,
    record: list[Record],
    kept: KeptModes | None = None,
    **options: Unpack[RunOptions],
) -> RunData: ...
def multipliers(
    model: Model,
    *,
    initial: str | dict[str, Any],
    smallest: float,
    record: list[Record],
    progress: Callable[[float], object] | None,
    only_largest: bool = False,
    kept: KeptModes | None = None,
    **options: Unpack[RunOptions],
) -> ComplexArray: ...
def whirl_classes() -> list[str]: ...
def panic_in_analysis(message: str) -> None: ...
