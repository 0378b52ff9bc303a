//! Collects the warnings of the plausibility check.

use std::f64::consts::TAU;

use super::ranges::{ASK_DEGREES, Usual};
use crate::numerics::EQUALITY_TOLERANCE;
use crate::scene::EntryPath;
use crate::scene::number::short;

/// A quantity outside its range.
struct Finding {
    quantity: &'static str,
    message: String,
    /// Paths of all entries with this finding. The message describes the first one.
    paths: Vec<String>,
}

/// Warnings: one for each quantity, and at most one for each entry.
#[derive(Default)]
pub(super) struct Findings(Vec<Finding>);

impl Findings {
    /// Adds a finding if a value lies outside its range.
    pub(super) fn check(&mut self, at: &EntryPath, value: f64, usual: &Usual) {
        if value >= usual.low && value <= usual.high {
            return;
        }
        let cause = if value > usual.high { usual.above } else { usual.below };
        let Usual { quantity, unit, low, high, .. } = usual;
        let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
        let range = if *low == 0.0 {
            format!("up to {}{unit}", short(*high))
        } else {
            format!("{} to {}{unit}", short(*low), short(*high))
        };
        self.add(quantity, at, &format!("{quantity} is {}{unit}, usual is {range}; {cause}", short(value)));
    }

    /// Adds a finding if an angle, rad, is larger than a full turn.
    pub(super) fn check_angle(&mut self, at: &EntryPath, angle: f64) {
        if angle.abs() > TAU * (1.0 + EQUALITY_TOLERANCE) {
            self.add(
                "angle",
                at,
                &format!("{} rad is more than a full turn, 2π = 6.283 rad; {ASK_DEGREES}", short(angle)),
            );
        }
    }

    /// Adds a finding about a quantity.
    pub(super) fn add(&mut self, quantity: &'static str, at: &EntryPath, message: &str) {
        let path = at.to_string();
        if self.0.iter().any(|finding| finding.paths.contains(&path)) {
            return;
        }
        match self.0.iter_mut().find(|finding| finding.quantity == quantity) {
            Some(finding) => finding.paths.push(path),
            None => self.0.push(Finding { quantity, message: format!("{at}: {message}"), paths: vec![path] }),
        }
    }

    /// The text of all warnings.
    pub(super) fn messages(self) -> impl Iterator<Item = String> {
        self.0.into_iter().map(|Finding { message, paths, .. }| match &paths[1..] {
            [] => message,
            further => format!("{message} (also {})", further.join(", ")),
        })
    }
}
