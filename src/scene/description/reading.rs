//! Deserialization of a description: whole numbers, and error messages in words of the description.

use std::fmt;
use std::marker::PhantomData;

use serde::de::{Error, Visitor};
use serde::{Deserialize, Deserializer};

use crate::scene::{SceneError, nearest};

/// Largest value up to which every whole number is a float, 2⁵³.
const LARGEST_WHOLE: f64 = 9_007_199_254_740_992.0;

/// Reads a value. An error begins with the path of the wrong entry.
pub(super) fn located<'de, T: Deserialize<'de>, D: Deserializer<'de>>(source: D) -> Result<T, SceneError> {
    serde_path_to_error::deserialize(source).map_err(|error| {
        let path = match error.path().to_string() {
            path if path == "." || path.is_empty() => "system".to_owned(),
            path => path,
        };
        SceneError::new(path, explain(error.into_inner().to_string().trim_end()))
    })
}

/// Reads a whole number; accepts 25.0, refuses 25.5.
pub(super) fn whole<'de, D: Deserializer<'de>, T: TryFrom<i64>>(source: D) -> Result<T, D::Error> {
    source.deserialize_any(Whole(PhantomData))
}

/// Reads a whole number of an optional entry.
pub(super) fn some_whole<'de, D: Deserializer<'de>, T: TryFrom<i64>>(source: D) -> Result<Option<T>, D::Error> {
    whole(source).map(Some)
}

struct Whole<T>(PhantomData<T>);

impl<T: TryFrom<i64>> Visitor<'_> for Whole<T> {
    type Value = T;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("a whole number")
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<T, E> {
        let bound = if value < 1 { "at least 1" } else { "smaller" };
        T::try_from(value).map_err(|_| E::custom(format!("must be {bound}, got {value}")))
    }

    fn visit_u64<E: Error>(self, value: u64) -> Result<T, E> {
        self.visit_i64(i64::try_from(value).unwrap_or(i64::MAX))
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<T, E> {
        if value.fract() == 0.0 && value.abs() <= LARGEST_WHOLE {
            return self.visit_i64(value as i64);
        }
        Err(E::custom(format!("must be a whole number, got {value}")))
    }
}

/// Translates an error message of serde and suggests the name that was probably meant.
///
/// Serde provides its errors as text only: ``unknown field `lenght`, expected one of `name`, `length` ``.
fn explain(message: &str) -> String {
    // Remove the path, which the error already contains.
    let message = message.split("\nin `").next().unwrap_or(message);
    let mut message = message.replace("expected f64", "expected a number").replace("floating point", "number");
    if message.contains("invalid type: string") && message.contains("number") {
        message += "; write a number without quotes";
    } else if message.contains("invalid type: map, expected a sequence") {
        message += "; write two brackets around the name of a list of parts: [[shafts]]";
    }
    let known = ["unknown field `", "unknown variant `"];
    let Some(start) = known.iter().find_map(|known| message.find(known).map(|at| at + known.len())) else {
        return message;
    };
    // Every second piece between the quotes is a name: first the unknown name, then the known names.
    let mut names = message[start..].split('`').step_by(2);
    let near = names.next().map(|given| nearest(given, names)).unwrap_or_default();
    message + &near
}
