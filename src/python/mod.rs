//! The Python extension module `gearbow._core`. Only this folder uses pyo3.
//!
//! `handle` is the class `Model`; its Python methods stand in `model`, `frequency`, `sensitivity`, `sections` and `simulate`. The
//! functions of the module stand in `steady`, `bearing` and `geometry`. Every analysis runs on a second thread (`background`), while the calling thread checks every 50 ms for Ctrl-C
//! and for the end of the sweep to which it belongs. Options, speeds, final states and responses are serde structs
//! (`options`, `speed`, `state`, `response`); `entries` reads them with errors that name the entry. `convert` makes plain
//! descriptions and NumPy arrays, `errors` exceptions and warnings.

#![expect(clippy::needless_pass_by_value, reason = "pyo3 extracts arguments by value")]

mod background;
mod bearing;
mod convert;
mod entries;
mod errors;
mod frequency;
mod geometry;
mod handle;
mod model;
mod options;
mod response;
mod sections;
mod sensitivity;
mod simulate;
mod speed;
mod state;
mod steady;

use pyo3::pymodule;

/// The compiled core of gearbow.
#[pymodule]
mod _core {
    /// Smallest unit of an error, as a share of the mean of the signal.
    #[pymodule_export]
    const SHARE_OF_MEAN: f64 = crate::scene::SHARE_OF_MEAN;

    #[pymodule_export]
    use super::background::panic_in_analysis;
    #[pymodule_export]
    use super::bearing::{
        film_coefficients, ring_coefficients, rolling_coefficients, rolling_estimate, squeeze_force, table_at_frequency,
    };
    #[pymodule_export]
    use super::convert::{connection_channels, require_memory};
    #[pymodule_export]
    use super::frequency::whirl_classes;
    #[pymodule_export]
    use super::geometry::{mesh_geometry, shaft_motion, shaft_origins};
    #[pymodule_export]
    use super::handle::PyModel;
    #[pymodule_export]
    use super::options::accuracy_levels;
    #[pymodule_export]
    use super::sensitivity::motion_forms;
    #[pymodule_export]
    use super::speed::check_speed;
    #[pymodule_export]
    use super::state::check_final;
    #[pymodule_export]
    use super::steady::{
        PyKeptModes, common_period, corrected_states, has_constant_coefficients, initial_state, kept_modes,
        multipliers, recorded_period, slowest_period, steady_state, user_order,
    };

    #[pymodule_init]
    fn init(module: &pyo3::Bound<'_, pyo3::types::PyModule>) -> pyo3::PyResult<()> {
        super::errors::keep_panics();
        pyo3::types::PyModuleMethods::add(module, "__version__", env!("CARGO_PKG_VERSION"))
    }
}
