//! Accuracy levels: the total error that each promises, and the settings of a run that keep the promise.
//!
//! The total error is that of elements, modes and integration: RMS of the difference over RMS of the signal about its mean, or
//! over 2 % of the mean if this is larger. `benches/accuracy/measure.py` measures it.

use serde::{Deserialize, Serialize};

/// Time over which errors of runs are promised and compared, s; phase errors grow over it.
pub const COMPARED_DURATION: f64 = 0.1;
/// Share of the total error that a reduction to fewer modes may use.
pub const REDUCTION_SHARE: f64 = 1.0 / 3.0;
/// Smallest unit of an error, as a share of the mean of the signal: in 200 random trains, runs of the level "engineering" left
/// errors of up to 1.2e-4 of the mean mesh force, however little the force varied; the promised 1e-2 of this share is 2e-4.
pub const SHARE_OF_MEAN: f64 = 0.02;

/// Name of an accuracy level, from cheap to accurate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Accuracy {
    /// First look, orbits, contact ratios.
    Draft,
    /// Mesh forces and spectra.
    #[default]
    Engineering,
    /// Reference for other results.
    Reference,
}

/// What an accuracy level promises, and how runs keep it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AccuracyLevel {
    /// Name in files and in the Python package.
    pub name: &'static str,
    /// Largest total error of displacements.
    pub displacement: f64,
    /// Largest total error of mesh forces.
    pub mesh_force: f64,
    /// Relative tolerance of a step.
    pub rtol: f64,
    /// Whether long runs keep all modes.
    pub keeps_all_modes: bool,
}

impl Accuracy {
    /// All levels, from cheap to accurate.
    pub const ALL: [Self; 3] = [Self::Draft, Self::Engineering, Self::Reference];

    /// The promise of this level and its settings.
    pub const fn level(self) -> AccuracyLevel {
        match self {
            Self::Draft => AccuracyLevel {
                name: "draft",
                displacement: 1e-2,
                mesh_force: 1e-1,
                rtol: 1e-3,
                keeps_all_modes: false,
            },
            Self::Engineering => AccuracyLevel {
                name: "engineering",
                displacement: 1e-3,
                mesh_force: 1e-2,
                rtol: 1e-4,
                keeps_all_modes: false,
            },
            Self::Reference => AccuracyLevel {
                name: "reference",
                displacement: 1e-6,
                mesh_force: 1e-4,
                rtol: 1e-7,
                keeps_all_modes: true,
            },
        }
    }
}

impl AccuracyLevel {
    /// Largest errors of displacements and of mesh forces that a reduction to fewer modes may cause; `None` keeps all modes.
    pub fn reduction(&self) -> Option<[f64; 2]> {
        (!self.keeps_all_modes).then_some([REDUCTION_SHARE * self.displacement, REDUCTION_SHARE * self.mesh_force])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reduction_may_use_a_third_of_the_total_error_and_reference_keeps_all_modes() {
        let reduction = |accuracy: Accuracy| accuracy.level().reduction();
        assert_eq!(reduction(Accuracy::Draft), Some([1e-2, 1e-1].map(|error| REDUCTION_SHARE * error)));
        assert_eq!(reduction(Accuracy::Engineering), Some([1e-3, 1e-2].map(|error| REDUCTION_SHARE * error)));
        assert_eq!(reduction(Accuracy::Reference), None);
    }

    #[test]
    fn the_name_of_a_level_is_that_of_files() {
        for accuracy in Accuracy::ALL {
            let written = toml::Value::try_from(accuracy);
            assert_eq!(written, Ok(toml::Value::from(accuracy.level().name)));
        }
    }
}
