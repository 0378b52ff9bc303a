//! Deserialization of a description: whole numbers, and error messages in words of the description.

use std::fmt;
use std::marker::PhantomData;

use serde::de::{Error, MapAccess, SeqAccess, Unexpected, Visitor};
use serde::{Deserialize, Deserializer};
use toml::de::{DeTable, DeValue};

use crate::numerics::LARGEST_EXACT_INTEGER;
use crate::scene::{SceneError, nearest};

/// Names of the entries that are lists of a fixed length, and what their numbers are.
const FIXED_LISTS: [(&[&str], &str); 7] = [
    (&["inertia", "position", "rotational_stiffness", "rotational_damping", "points"], "3 numbers [x, y, z]"),
    (&["value"], "a pair [y, z]"),
    (&["grooves"], "a pair [angle of the middle, extent] for each groove"),
    (&["tooth", "driver", "driven"], "a pair [amplitude, phase] for each harmonic"),
    (&["bore_radii"], "a pair [driver, driven]"),
    (&["boundary"], "3 numbers [bore, outer, width]"),
    (&["rayleigh"], "a pair [alpha, beta]"),
];

/// Reads a value. An error begins with the path of the wrong entry.
pub(super) fn located<'de, T: Deserialize<'de>, D: Deserializer<'de>>(source: D) -> Result<T, SceneError> {
    serde_path_to_error::deserialize(source).map_err(|error| {
        let path = match error.path().to_string() {
            path if path == "." || path.is_empty() => "system".to_owned(),
            path => path,
        };
        let message = explain(&path, error.into_inner().to_string().trim_end());
        SceneError::new(path, message)
    })
}

/// Adds the line of a TOML text with the entry at the path of an error, or with the last part of the path that the text contains.
pub(super) fn with_line(error: SceneError, text: &str) -> SceneError {
    let Ok(document) = DeTable::parse(text) else {
        return error;
    };
    let document = DeValue::Table(document.into_inner());
    let (mut value, mut start) = (&document, None);
    for part in error.path.split(['.', '[']).map(|part| part.trim_end_matches(']')) {
        let found = match value {
            DeValue::Table(table) => {
                table.iter().find(|(key, _)| key.get_ref() == part).map(|(key, entry)| (Some(key), entry))
            }
            DeValue::Array(list) => {
                part.parse().ok().and_then(|index: usize| list.get(index)).map(|entry| (None, entry))
            }
            _ => None,
        };
        let Some((key, entry)) = found else { break };
        (value, start) = (entry.get_ref(), Some(key.map_or(entry.span().start, |key| key.span().start)));
    }
    let line = start.and_then(|start| {
        let number = text[..start].matches('\n').count();
        text.lines().nth(number).map(|line| (number + 1, line.trim()))
    });
    match line {
        Some((number, line)) => SceneError::new(&error.path, format!("{}; line {number}: {line}", error.message)),
        None => error,
    }
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
        if value.fract() == 0.0 && value.abs() <= LARGEST_EXACT_INTEGER as f64 {
            return self.visit_i64(value as i64);
        }
        if value.fract() == 0.0 {
            let bound = if value < 0.0 { "at least 1" } else { "smaller" };
            return Err(E::custom(format!("must be {bound}, got {value}")));
        }
        Err(E::custom(format!("must be a whole number, got {value}")))
    }
}

/// A value that is a number or entries with names, and perhaps a list. Its implementation is not derived: an error inside the
/// entries names the field, while an untagged enum only says that no variant fits.
pub(super) trait NumberOrEntries: Sized {
    /// What it can be, for messages.
    const EXPECTED: &'static str;

    /// The value of a number.
    fn number(value: f64) -> Self;

    /// Reads the entries.
    fn entries<'de, A: MapAccess<'de>>(map: A) -> Result<Self, A::Error>;

    /// Reads a list.
    fn list<'de, A: SeqAccess<'de>>(_: A) -> Result<Self, A::Error> {
        Err(A::Error::invalid_type(Unexpected::Seq, &Self::EXPECTED))
    }
}

/// Reads a number or entries; a whole number is a number too.
pub(super) fn number_or_entries<'de, T: NumberOrEntries, D: Deserializer<'de>>(source: D) -> Result<T, D::Error> {
    source.deserialize_any(NumberReader(PhantomData))
}

struct NumberReader<T>(PhantomData<T>);

impl<'de, T: NumberOrEntries> Visitor<'de> for NumberReader<T> {
    type Value = T;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(T::EXPECTED)
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<T, E> {
        Ok(T::number(value))
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<T, E> {
        Ok(T::number(value as f64))
    }

    fn visit_u64<E: Error>(self, value: u64) -> Result<T, E> {
        Ok(T::number(value as f64))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, sequence: A) -> Result<T, A::Error> {
        T::list(sequence)
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<T, A::Error> {
        T::entries(map)
    }
}

/// Translates an error message of serde about the entry at a path, and says how to write it.
///
/// Serde provides its errors as text only: ``unknown field `lenght`, expected one of `name`, `length` ``.
fn explain(path: &str, message: &str) -> String {
    // Remove the path, which the error already contains.
    let message = message.split("\nin `").next().unwrap_or(message);
    let mut message = message.replace("expected f64", "expected a number").replace("floating point", "number");
    // Without indices, the path is the name of a table in a file.
    let table: String = path.split('[').map(|piece| piece.split_once(']').map_or(piece, |(_, rest)| rest)).collect();
    if message.contains("invalid type: string") && message.contains("number") {
        message += "; write a number without quotes";
    } else if message.contains("invalid type: map, expected a sequence") {
        message += &format!("; write two brackets around the name of a list: [[{table}]]");
    } else if let Some(start) = message.rfind("expected struct ") {
        let header = if path.ends_with(']') { format!("[[{table}]]") } else { format!("[{table}]") };
        message.replace_range(start.., &format!("expected entries with names; write {header}"));
    } else if let Some(start) =
        message.rfind("expected an array of").or_else(|| message.rfind("expected fewer elements"))
    {
        let meaning =
            |name: &str| FIXED_LISTS.iter().find(|(names, _)| names.contains(&name)).map(|(_, meaning)| meaning);
        // The user chooses the names of points.
        let entry = table.split_once(".points.").map_or(table.as_str(), |_| "points");
        if let Some(meaning) = entry.rsplit('.').find_map(meaning) {
            message.replace_range(start.., &format!("expected {meaning}"));
        }
    }
    message = message
        .replace("expected a sequence", "expected a list")
        .replace("expected a map", "expected entries with names");
    let known = ["unknown field `", "unknown variant `"];
    let Some(start) = known.iter().find_map(|known| message.find(known).map(|at| at + known.len())) else {
        return message;
    };
    // Every second piece between the quotes is a name: first the unknown name, then the known names.
    let mut names = message[start..].split('`').step_by(2);
    let near = names.next().map(|given| nearest(given, names)).unwrap_or_default();
    message + &near
}
