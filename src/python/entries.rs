//! Reads plain Python data (numbers, texts, lists) into serde structs. Errors name the entry in words of the user.
//!
//! The functions below are for `#[serde(deserialize_with = "…")]`. They check the value and replace the message of
//! serde, which names Rust types.

use pyo3::prelude::*;
use pythonize::Depythonizer;
use serde::de::{DeserializeOwned, Error};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::scene::SceneError;

/// Counters must stay below this value, so that a further run cannot overflow 64 bits.
const COUNT_LIMIT: u64 = 1 << 63;

const COUNT: &str = "must be a whole number, not negative and below 2^63";

/// Reads a struct from a mapping. Entries without a field are ignored; the caller may read arrays from them.
///
/// # Errors
/// `name.key: message`, or `name: message` if an entry is missing.
pub fn read<T: DeserializeOwned>(given: &Bound<'_, PyAny>, name: &str) -> Result<T, SceneError> {
    serde_path_to_error::deserialize(&mut Depythonizer::from_object(given)).map_err(|error| {
        let path = error.path().to_string();
        let key = path.split(['.', '[']).next().unwrap_or_default().to_owned();
        let message = error.into_inner().to_string();
        // Serde offers the name of a missing field only in the text of its message.
        match message.strip_prefix("missing field `").and_then(|rest| rest.strip_suffix('`')) {
            Some(key) => SceneError::new(name, format!("lacks the entry \"{key}\"")),
            None if key.is_empty() => SceneError::new(name, message),
            None if name.is_empty() => SceneError::new(key, message),
            None => SceneError::new(format!("{name}.{key}"), message),
        }
    })
}

/// Reads a text.
pub fn text<'de, D: Deserializer<'de>>(source: D) -> Result<String, D::Error> {
    String::deserialize(source).map_err(|_| D::Error::custom("must be a text"))
}

/// Reads a number that may be infinite or NaN.
pub fn any_number<'de, D: Deserializer<'de>>(source: D) -> Result<f64, D::Error> {
    f64::deserialize(source).map_err(|_| D::Error::custom("must be a number"))
}

/// Reads a finite number.
pub fn finite<'de, D: Deserializer<'de>>(source: D) -> Result<f64, D::Error> {
    let value = any_number(source)?;
    if value.is_finite() { Ok(value) } else { Err(D::Error::custom("must be finite")) }
}

/// Reads a finite number that is not negative.
pub fn not_negative<'de, D: Deserializer<'de>>(source: D) -> Result<f64, D::Error> {
    let value = finite(source)?;
    if value >= 0.0 { Ok(value) } else { Err(D::Error::custom(format!("must not be negative, got {value:e}"))) }
}

/// Reads a counter.
pub fn count<'de, D: Deserializer<'de>>(source: D) -> Result<u64, D::Error> {
    let count = u64::deserialize(source).ok().filter(|count| *count < COUNT_LIMIT);
    count.ok_or_else(|| D::Error::custom(COUNT))
}

/// Reads a counter or None.
pub fn optional_count<'de, D: Deserializer<'de>>(source: D) -> Result<Option<usize>, D::Error> {
    Option::<usize>::deserialize(source).map_err(|_| D::Error::custom(COUNT))
}

/// Reads N counters.
pub fn counts<'de, D: Deserializer<'de>, const N: usize>(source: D) -> Result<[u64; N], D::Error> {
    let counts: Option<[u64; N]> = Vec::deserialize(source).ok().and_then(|counts| counts.try_into().ok());
    counts
        .filter(|counts| counts.iter().all(|count| *count < COUNT_LIMIT))
        .ok_or_else(|| D::Error::custom(format!("must be {N} whole numbers, not negative and below 2^63")))
}

/// Reads N numbers.
pub fn numbers<'de, D: Deserializer<'de>, const N: usize>(source: D) -> Result<[f64; N], D::Error> {
    let numbers: Option<[f64; N]> = Vec::deserialize(source).ok().and_then(|numbers| numbers.try_into().ok());
    numbers.ok_or_else(|| D::Error::custom(format!("must be {N} numbers")))
}

/// Writes N values as a list. Serde writes a Rust array as a tuple.
pub fn list<S: Serializer, T: Serialize, const N: usize>(values: &[T; N], sink: S) -> Result<S::Ok, S::Error> {
    sink.collect_seq(values)
}
