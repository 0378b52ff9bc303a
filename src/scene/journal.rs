//! Journal bearing: check of its entries.

use std::f64::consts::TAU;

use super::description::{self, FilmModel};
use super::{EntryPath, SceneError};

/// Ratios L/D for which the grid of the finite film is made; its errors were measured within them.
const LENGTH_RATIOS: [f64; 2] = [0.1, 2.0];
/// Smallest extent of a pad between two grooves, rad.
const MIN_PAD_ANGLE: f64 = 0.1;

/// Geometry and oil of a journal bearing.
#[derive(Clone, Debug, PartialEq)]
pub struct Journal {
    /// Diameter D of the journal, m.
    pub diameter: f64,
    /// Length L of the bearing, m.
    pub length: f64,
    /// Radial clearance c, m.
    pub clearance: f64,
    /// Dynamic viscosity μ, Pa s.
    pub viscosity: f64,
    /// Model of the film.
    pub film: FilmKind,
}

/// Model of the film.
#[derive(Clone, Debug, PartialEq)]
pub enum FilmKind {
    /// Short film, closed form.
    Short,
    /// Film of finite length, with its axial grooves: angle of the middle from y towards z, and extent, rad.
    Finite(Vec<[f64; 2]>),
}

impl Journal {
    /// Checks the entries of a bearing at the entry `at`; none for a linear bearing.
    ///
    /// # Errors
    /// [`SceneError`] for a bearing with both stiffness and film or with none, a film on a support, a missing entry, a value that is not
    /// positive, a clearance that is not below the radius, and grooves that do not leave a pad.
    pub(super) fn new(given: &description::Bearing, at: &EntryPath) -> Result<Option<Self>, SceneError> {
        let entries = [
            ("diameter", given.diameter),
            ("length", given.length),
            ("clearance", given.clearance),
            ("viscosity", given.viscosity),
        ];
        if !given.film_entries().iter().any(|(_, is_given)| *is_given) {
            return match given.stiffness {
                Some(_) => Ok(None),
                None => Err(at.error("missing field `stiffness`, or those of a journal bearing or rolling bearing")),
            };
        }
        for (name, is_given) in [("stiffness", given.stiffness.is_some()), ("damping", given.damping.is_some())] {
            if is_given {
                let message = "a journal bearing takes none, its film has it; leave it out, or leave out diameter, length, clearance, viscosity, film and grooves";
                return Err(at.field(name).error(message));
            }
        }
        let read = |(name, value): (&str, Option<f64>)| {
            let missing = || at.error(format!("missing field `{name}` of the journal bearing"));
            at.field(name).positive(value.ok_or_else(missing)?)
        };
        let [diameter, length, clearance, viscosity] = entries.map(read);
        let (diameter, length, clearance) = (diameter?, length?, clearance?);
        if clearance >= diameter / 2.0 {
            let message = format!(
                "must be below the radius of the journal, {} m, got {clearance}; usual is about a thousandth of it",
                diameter / 2.0
            );
            return Err(at.field("clearance").error(message));
        }
        let film = film(given, length / diameter, at)?;
        Ok(Some(Self { diameter, length, clearance, viscosity: viscosity?, film }))
    }
}

fn film(given: &description::Bearing, length_ratio: f64, at: &EntryPath) -> Result<FilmKind, SceneError> {
    let grooves = given.grooves.as_deref().unwrap_or_default();
    match given.film.unwrap_or_default() {
        FilmModel::Short if grooves.is_empty() => Ok(FilmKind::Short),
        FilmModel::Short => {
            let message = format!("a short film has none, got {}; use film=\"finite\"", grooves.len());
            Err(at.field("grooves").error(message))
        }
        FilmModel::Finite => {
            let [least, most] = LENGTH_RATIOS;
            if !(least..=most).contains(&length_ratio) {
                let message = format!(
                    "length / diameter of a finite film must be between {least} and {most}, got {length_ratio}; a shorter film is film=\"short\""
                );
                return Err(at.field("length").error(message));
            }
            check_grooves(grooves, &at.field("grooves"))?;
            Ok(FilmKind::Finite(grooves.to_vec()))
        }
    }
}

/// Refuses grooves that overlap or leave pads that are too short.
fn check_grooves(grooves: &[[f64; 2]], at: &EntryPath) -> Result<(), SceneError> {
    for (index, [middle, extent]) in grooves.iter().enumerate() {
        at.index(index).index(0).finite(*middle)?;
        at.index(index).index(1).positive(*extent)?;
    }
    let mut order: Vec<usize> = (0..grooves.len()).collect();
    let begin = |index: usize| (grooves[index][0] - grooves[index][1] / 2.0).rem_euclid(TAU);
    order.sort_by(|a, b| begin(*a).total_cmp(&begin(*b)));
    for (place, index) in order.iter().enumerate() {
        let next = order[(place + 1) % order.len()];
        let turn = if place + 1 == order.len() { TAU } else { 0.0 };
        let pad = begin(next) + turn - begin(*index) - grooves[*index][1];
        if pad < MIN_PAD_ANGLE {
            let message = format!(
                "leaves a pad of {pad:.4} rad to grooves[{next}], at least {MIN_PAD_ANGLE} is needed; give (angle of the middle, extent) of each groove in radians"
            );
            return Err(at.index(*index).error(message));
        }
    }
    Ok(())
}
