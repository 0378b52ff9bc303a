//! What the search of an equilibrium needs for nonlinear bearings: journals stay within their clearance, and rolling elements
//! have a stiffness before they carry.

use nalgebra::{DMatrix, DVector};
use num_complex::Complex64;

use crate::connection::Row;
use crate::film::nearness_after_step;
use crate::linalg::CoupledChains;
use crate::model::Model;
use crate::scene::{EntryPath, SceneError};

/// A part of a tangent; parts add up.
pub(in crate::modal) enum TangentPart {
    /// Row, column and value of a matrix entry.
    Entry(usize, usize, f64),
    /// Scalars as entries over the coordinates, and the stiffness over them.
    Form(Vec<Row>, DMatrix<f64>),
}

impl TangentPart {
    /// Adds it to a matrix.
    pub fn add_to(&self, model: &Model, sum: &mut CoupledChains) {
        match self {
            Self::Entry(row, column, value) => model.add_entry(sum, *row, *column, Complex64::from(*value)),
            Self::Form(rows, stiffness) => model.add_form(sum, rows, |i, j| Complex64::from(stiffness[(i, j)])),
        }
    }
}

/// Stiffness that is added to rolling elements, relative to the one under the weight of their shaft, where the residual is
/// round-off: it constrains a shaft that moves freely in the clearance.
const FREE: f64 = 1e-10;

/// Stiffness that is added to rolling elements, which have none before they carry: the share of the residual in the load times
/// the stiffness under the weight. It vanishes with the residual, so that the iteration converges as fast as Newton's method
/// (Levenberg and Marquardt; Yamashita and Fukushima, Computing Suppl. 15, 2001).
pub(in crate::modal) fn regularisation(model: &Model, part: f64) -> impl Iterator<Item = TangentPart> {
    model.nonlinear_bearings.iter().filter(|bearing| bearing.elements().is_some()).map(move |bearing| {
        let stiffness = bearing.initial_stiffness * part.clamp(FREE, 1.0);
        let scalars = bearing.rows.len();
        TangentPart::Form(bearing.rows.clone(), DMatrix::from_diagonal_element(scalars, scalars, stiffness))
    })
}

/// Refuses eccentricity ratios outside a range: a journal that touches its bearing or carries no load.
pub(in crate::modal) fn check_journals(
    model: &Model,
    q: &DVector<f64>,
    range: std::ops::Range<f64>,
) -> Result<(), SceneError> {
    for journal in &model.nonlinear_bearings {
        let Some(ratio) = journal.nearness(q.as_slice()) else {
            continue;
        };
        let at = EntryPath::entry("bearings", journal.number);
        if ratio < range.start && journal.is_journal() {
            let message = "no load acts on the journal bearing, so that its film has no stiffness and the shaft whirls; add gravity, a torque or another load";
            return Err(at.error(message));
        }
        if ratio >= range.end || ratio.is_nan() {
            let message = format!(
                "no static equilibrium: the journal touches the bearing at this load and speed (eccentricity ratio {ratio:.3}); raise the speed, the viscosity or the length, or reduce the clearance or the load"
            );
            return Err(at.error(message));
        }
    }
    Ok(())
}

/// Refuses a tilting pad that carries nothing at a speed of the reference shaft, rad/s, so that its tilt is free.
pub(in crate::modal) fn check_tilts(model: &Model, q: &DVector<f64>, speed: f64) -> Result<(), SceneError> {
    match model.nonlinear_bearings.iter().find(|bearing| !bearing.is_wedged(q.as_slice(), speed)) {
        Some(bearing) => Err(EntryPath::entry("bearings", bearing.number).error(
            "a tilting pad carries nothing at this load and speed, so that its tilt is free; raise its preload, or use reduced=\"synchronous\"",
        )),
        None => Ok(()),
    }
}

/// Fraction of a Newton step that keeps journals off their bearings.
pub(in crate::modal) fn within_clearances(model: &Model, q: &DVector<f64>, step: &DVector<f64>) -> f64 {
    let mut fraction: f64 = 1.0;
    for journal in &model.nonlinear_bearings {
        let Some(ratio) = journal.nearness(q.as_slice()) else {
            continue;
        };
        let limit = nearness_after_step(ratio);
        let exceeds = |q: DVector<f64>| journal.nearness(q.as_slice()).is_some_and(|ratio| ratio > limit);
        while fraction > f64::EPSILON && exceeds(q + step * fraction) {
            fraction /= 2.0;
        }
    }
    fraction
}
