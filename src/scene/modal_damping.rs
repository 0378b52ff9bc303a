//! Damping ratios ζ of the undamped modes: one for all, one for each mode number, or a function of the frequency.

use num_complex::Complex64;

use super::curve::{Curve, check_points};
use super::description::ModalDampingGiven;
use super::{EntryPath, SceneError};

/// Name of the ratio of the modes without an entry.
const OTHER: &str = "other";

/// Damping ratio of each undamped mode.
#[derive(Clone, Debug, PartialEq)]
pub enum DampingRatios {
    /// The same of every mode.
    Constant(f64),
    /// Of single modes.
    Modes {
        /// Ratios of the elastic modes of lowest frequency, in ascending order of the frequency.
        ratios: Vec<f64>,
        /// Ratio of the modes without an entry.
        other: f64,
    },
    /// Over the frequency, rad/s; constant outside.
    Frequencies(Curve),
}

impl DampingRatios {
    /// Checks what a description gives.
    pub(super) fn new(given: Option<&ModalDampingGiven>) -> Result<Self, SceneError> {
        let at = EntryPath::root("modal_damping");
        match given {
            None => Ok(Self::Constant(0.0)),
            Some(ModalDampingGiven::Constant(ratio)) => Ok(Self::Constant(at.non_negative(*ratio)?)),
            Some(ModalDampingGiven::Modes(given)) => {
                let other = at.field(OTHER).non_negative(given.get(OTHER).copied().unwrap_or(0.0))?;
                let mut ratios = Vec::new();
                for (name, ratio) in given.iter().filter(|(name, _)| *name != OTHER) {
                    let number = name.parse::<u16>().ok().filter(|number| *number > 0).ok_or_else(|| {
                        at.error(format!(
                            "a key must be the number of an elastic mode from 1 to {}, or \"{OTHER}\", got \"{name}\"",
                            u16::MAX
                        ))
                    })?;
                    let number = usize::from(number);
                    ratios.resize(number.max(ratios.len()), other);
                    ratios[number - 1] = at.field(name).non_negative(*ratio)?;
                }
                Ok(Self::Modes { ratios, other })
            }
            Some(ModalDampingGiven::Frequencies(table)) => {
                let ratios: Vec<Complex64> = table.ratios.iter().map(|ratio| Complex64::from(*ratio)).collect();
                check_points(&at, "frequencies", "ratios", &table.frequencies, &ratios)?;
                at.field("frequencies").index(0).non_negative(table.frequencies[0])?;
                for (index, ratio) in table.ratios.iter().enumerate() {
                    at.field("ratios").index(index).non_negative(*ratio)?;
                }
                Ok(Self::Frequencies(Curve::new(table.frequencies.clone(), table.ratios.clone())))
            }
        }
    }

    /// ζ of the elastic mode with this index (from 0, in ascending order of the frequency) and this frequency, rad/s.
    #[inline]
    pub fn of_mode(&self, index: usize, frequency: f64) -> f64 {
        match self {
            Self::Constant(ratio) => *ratio,
            Self::Modes { ratios, other } => ratios.get(index).copied().unwrap_or(*other),
            Self::Frequencies(curve) => curve.at(frequency)[0],
        }
    }

    /// 2ζω of a mode with its number from zero and its frequency, rad/s, in 1/s.
    pub fn rate(&self, index: usize, frequency: f64) -> f64 {
        2.0 * self.of_mode(index, frequency) * frequency
    }

    /// Smallest ζ of a mode with an unknown number and this frequency, rad/s.
    pub fn smallest_at(&self, frequency: f64) -> f64 {
        match self {
            Self::Modes { ratios, other } => ratios.iter().copied().fold(*other, f64::min),
            _ => self.of_mode(0, frequency),
        }
    }

    /// Largest ζ.
    pub fn largest(&self) -> f64 {
        match self {
            Self::Constant(ratio) => *ratio,
            Self::Modes { ratios, other } => ratios.iter().copied().fold(*other, f64::max),
            Self::Frequencies(curve) => curve.largest(),
        }
    }

    /// Whether no mode has damping.
    pub fn is_zero(&self) -> bool {
        self.largest() == 0.0
    }

    /// Number of the highest mode with an entry of its own; zero if the ratio does not depend on the number.
    pub fn numbered_modes(&self) -> usize {
        if let Self::Modes { ratios, .. } = self { ratios.len() } else { 0 }
    }

    /// Refuses numbers above the number of coordinates of the model.
    ///
    /// # Errors
    /// [`SceneError`] with the highest number.
    pub(crate) fn check_numbers(&self, coordinates: usize) -> Result<(), SceneError> {
        let number = self.numbered_modes();
        if number <= coordinates {
            return Ok(());
        }
        let message = format!("mode {number} does not exist: the model has {coordinates} modes; give a lower number");
        Err(EntryPath::root("modal_damping").error(message))
    }
}
