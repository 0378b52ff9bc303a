//! Damping ratios of modes.

use std::collections::BTreeMap;
use std::fmt;

use serde::de::{Error, MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};

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

/// Not derived: an error inside a table names the entry; an untagged enum only says that no variant fits.
impl<'de> Deserialize<'de> for ModalDampingGiven {
    fn deserialize<D: Deserializer<'de>>(source: D) -> Result<Self, D::Error> {
        struct Reader;

        impl<'de> Visitor<'de> for Reader {
            type Value = ModalDampingGiven;

            fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
                formatter.write_str("a number, ratios by mode number, or a table of frequencies and ratios")
            }

            fn visit_f64<E: Error>(self, ratio: f64) -> Result<ModalDampingGiven, E> {
                Ok(ratio.into())
            }

            fn visit_i64<E: Error>(self, ratio: i64) -> Result<ModalDampingGiven, E> {
                self.visit_f64(ratio as f64)
            }

            fn visit_u64<E: Error>(self, ratio: u64) -> Result<ModalDampingGiven, E> {
                self.visit_f64(ratio as f64)
            }

            fn visit_map<A: MapAccess<'de>>(self, mut entries: A) -> Result<ModalDampingGiven, A::Error> {
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
                    (None, None) => Ok(ModalDampingGiven::Modes(modes)),
                    (Some(frequencies), Some(ratios)) if modes.is_empty() => {
                        Ok(ModalDampingGiven::Frequencies(RatioTable { frequencies, ratios }))
                    }
                    _ => Err(A::Error::custom("needs frequencies and ratios, or ratios by mode number only")),
                }
            }
        }

        source.deserialize_any(Reader)
    }
}
