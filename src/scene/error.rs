//! Errors of a scene and the paths of its entries.

use std::fmt;

use thiserror::Error;

/// An invalid scene or option: the path of the entry and the problem.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{path}: {message}")]
pub struct SceneError {
    /// Path of the entry, for example `shafts[1].bow.amplitude`.
    pub path: String,
    /// The problem, with the value.
    pub message: String,
}

impl SceneError {
    /// Creates an error at `path`.
    pub fn new(path: impl fmt::Display, message: impl fmt::Display) -> Self {
        Self { path: path.to_string(), message: message.to_string() }
    }
}

/// The path of an entry in the notation of Python.
///
/// A path refers to the path before it and becomes text only in a message, because a valid scene needs no text.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EntryPath<'a> {
    /// Path of the entry that contains this one; `None` at the top level of the description.
    parent: Option<&'a EntryPath<'a>>,
    /// Name of a field; empty for an entry of the list `parent`.
    field: &'a str,
    /// Index within the list.
    index: Option<usize>,
}

impl<'a> EntryPath<'a> {
    /// A top-level entry of the description.
    pub fn root(field: &'a str) -> Self {
        Self { parent: None, field, index: None }
    }

    /// Entry `index` of the list `field`.
    pub fn entry(field: &'a str, index: usize) -> Self {
        Self { parent: None, field, index: Some(index) }
    }

    /// Field `field` of this entry.
    pub fn field<'b>(&'b self, field: &'b str) -> EntryPath<'b> {
        EntryPath { parent: Some(self), field, index: None }
    }

    /// Entry `index` of this list.
    pub fn index(&self, index: usize) -> EntryPath<'_> {
        EntryPath { parent: Some(self), field: "", index: Some(index) }
    }

    /// Creates an error at this path.
    pub fn error(&self, message: impl fmt::Display) -> SceneError {
        SceneError::new(self, message)
    }

    /// Refuses entries of this part that are given; `entries` come from [`given`].
    pub fn refuse(&self, entries: &[(&'static str, bool)], message: &str) -> Result<(), SceneError> {
        match entries.iter().find(|(_, is_given)| *is_given) {
            Some((name, _)) => Err(self.field(name).error(message)),
            None => Ok(()),
        }
    }

    /// Returns `value` if it is finite.
    pub fn finite(&self, value: f64) -> Result<f64, SceneError> {
        if value.is_finite() {
            Ok(value)
        } else {
            Err(self.error(format!("must be finite, got {}", lower_case(value))))
        }
    }

    /// Returns `value` if it is finite and positive.
    pub fn positive(&self, value: f64) -> Result<f64, SceneError> {
        if self.finite(value)? > 0.0 { Ok(value) } else { Err(self.error(format!("must be positive, got {value}"))) }
    }

    /// Returns `value` if it is finite and not negative.
    pub fn non_negative(&self, value: f64) -> Result<f64, SceneError> {
        if self.finite(value)? >= 0.0 {
            Ok(value)
        } else {
            Err(self.error(format!("must not be negative, got {value}")))
        }
    }
}

/// The names of optional entries of a part of a description, and whether each is given.
macro_rules! given {
    ($part:expr; $($name:ident),* $(,)?) => { [$((stringify!($name), $part.$name.is_some())),*] };
}
pub(crate) use given;

/// Returns the end of an error message that suggests the most similar name, or an empty text if no name is similar.
///
/// Names are similar if their edit distance (insertions, deletions, replacements and swaps) is at most a third of the
/// letters, and at least one edit is always allowed.
pub(crate) fn nearest<'a>(given: &str, names: impl IntoIterator<Item = &'a str>) -> String {
    let distance = |name: &'a str| (strsim::osa_distance(&given.to_lowercase(), &name.to_lowercase()), name);
    let most = (given.chars().count() / 3).max(1);
    match names.into_iter().map(distance).min_by_key(|(distance, _)| *distance) {
        Some((distance, name)) if distance <= most => format!("; did you mean \"{name}\"?"),
        _ => String::new(),
    }
}

/// Formats infinity and NaN as Python and TOML do.
fn lower_case(value: f64) -> String {
    value.to_string().to_lowercase()
}

impl fmt::Display for EntryPath<'_> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(parent) = self.parent {
            let dot = if self.field.is_empty() { "" } else { "." };
            write!(formatter, "{parent}{dot}")?;
        }
        formatter.write_str(self.field)?;
        self.index.map_or(Ok(()), |index| write!(formatter, "[{index}]"))
    }
}
