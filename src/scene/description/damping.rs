//! Damping ratios of modes.

use std::collections::BTreeMap;

use serde::de::{Error, MapAccess};
use serde::{Deserialize, Deserializer, Serialize};

use super::reading::{NumberOrEntries, number_or_entries};

/// Damping ratios as a description gives them.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum ModalDampingGiven {
    /// The same of every mode.
    Constant(f64),
    /// Over the frequency.
    Frequencies(RatioTable),
    /// By the number of the elastic mode, from 1, or "other".
    Modes(BTreeMap<String, f64>),
}

/// Damping ratios over the frequency.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RatioTable {
    /// Undamped frequencies, rad/s, ascending from zero or above.
    pub frequencies: Vec<f64>,
    /// Ratio at each frequency.
    pub ratios: Vec<f64>,
}

impl From<f64> for ModalDampingGiven {
    fn from(ratio: f64) -> Self {
        Self::Constant(ratio)
    }
}

impl<'de> Deserialize<'de> for ModalDampingGiven {
    fn deserialize<D: Deserializer<'de>>(source: D) -> Result<Self, D::Error> {
        number_or_entries(source)
    }
}

impl NumberOrEntries for ModalDampingGiven {
    const EXPECTED: &'static str = "a number, ratios by mode number, or a table of frequencies and ratios";

    fn number(ratio: f64) -> Self {
        ratio.into()
    }

    fn entries<'de, A: MapAccess<'de>>(mut entries: A) -> Result<Self, A::Error> {
        let (mut frequencies, mut ratios, mut modes) = (None, None, BTreeMap::new());
        while let Some(key) = entries.next_key::<String>()? {
            match key.as_str() {
                "frequencies" => frequencies = Some(entries.next_value::<Vec<f64>>()?),
                "ratios" => ratios = Some(entries.next_value::<Vec<f64>>()?),
                _ => {
                    let ratio = entries.next_value::<f64>()?;
                    modes.insert(key, ratio);
                }
            }
        }
        match (frequencies, ratios) {
            (None, None) => Ok(Self::Modes(modes)),
            (Some(frequencies), Some(ratios)) if modes.is_empty() => {
                Ok(Self::Frequencies(RatioTable { frequencies, ratios }))
            }
            _ => Err(A::Error::custom("needs frequencies and ratios, or ratios by mode number only")),
        }
    }
}
