//! What is wrong with a scene, and where.

use std::fmt;

use thiserror::Error;

/// A description that cannot be: the path of the entry, and what is wrong with it.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{path}: {message}")]
pub struct SceneError {
    /// Where it stands, e.g. `shafts[1].bow.amplitude`.
    pub path: String,
    /// What is wrong, with the value.
    pub message: String,
}

impl SceneError {
    /// An error at `path`.
    pub fn new(path: impl fmt::Display, message: impl fmt::Display) -> Self {
        Self { path: path.to_string(), message: message.to_string() }
    }
}

/// The path of an entry, written as a user writes it.
#[derive(Clone, Debug)]
pub(crate) struct EntryPath(String);

impl EntryPath {
    /// An entry of the description itself.
    pub fn root(field: &str) -> Self {
        Self(field.to_owned())
    }

    /// Entry `index` of the list `field`.
    pub fn entry(field: &str, index: usize) -> Self {
        Self(format!("{field}[{index}]"))
    }

    /// `field` of this entry.
    pub fn field(&self, field: &str) -> Self {
        Self(format!("{}.{field}", self.0))
    }

    /// Entry `index` of this list.
    pub fn index(&self, index: usize) -> Self {
        Self(format!("{}[{index}]", self.0))
    }

    /// The error that stands here.
    pub fn error(&self, message: impl fmt::Display) -> SceneError {
        SceneError::new(&self.0, message)
    }

    /// `value`, if it is finite.
    pub fn finite(&self, value: f64) -> Result<f64, SceneError> {
        if value.is_finite() { Ok(value) } else { Err(self.error(format!("must be finite, got {}", lower(value)))) }
    }

    /// `value`, if it is finite and above zero.
    pub fn positive(&self, value: f64) -> Result<f64, SceneError> {
        if self.finite(value)? > 0.0 { Ok(value) } else { Err(self.error(format!("must be positive, got {value}"))) }
    }

    /// `value`, if it is finite and not below zero.
    pub fn non_negative(&self, value: f64) -> Result<f64, SceneError> {
        if self.finite(value)? >= 0.0 {
            Ok(value)
        } else {
            Err(self.error(format!("must not be negative, got {value}")))
        }
    }
}

/// The end of a message that suggests the name nearest to a misspelt one; nothing where none is near.
///
/// A name is near when at most a third of the letters, and at least one, must be inserted, deleted, replaced or swapped.
pub(crate) fn nearest<'a>(given: &str, names: impl IntoIterator<Item = &'a str>) -> String {
    let distance = |name: &'a str| (strsim::osa_distance(&given.to_lowercase(), &name.to_lowercase()), name);
    let most = (given.chars().count() / 3).max(1);
    match names.into_iter().map(distance).min_by_key(|(distance, _)| *distance) {
        Some((distance, name)) if distance <= most => format!("; did you mean \"{name}\"?"),
        _ => String::new(),
    }
}

/// A number that is not finite, as Python and TOML write it.
fn lower(value: f64) -> String {
    value.to_string().to_lowercase()
}

impl fmt::Display for EntryPath {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.0)
    }
}
