//! Undamped critical speeds where the stiffness of bearings depends on the speed.
//!
//! With the stiffness K(s) of one speed s, the eigenproblem gives critical speeds Ω_1(s) ≤ Ω_2(s) ≤ …. A critical speed of
//! the rotor is a root of Ω_j(s) − s, because only there mode and bearings belong to the same speed. The functions Ω_j are
//! continuous, since eigenvalues are. They are sampled at the speeds of all tables and between them, and each change of
//! sign is closed by the method of Illinois (Dowell and Jarratt, BIT 11, 1971). Two roots between neighbouring samples
//! would be missed: between two speeds of a table there are [`SAMPLES`], and the stiffness is monotone there.

use super::{Critical, Interrupt, named};
use crate::analysis::AnalysisError;
use crate::analysis::root::root;
use crate::modal::{CachedModel, Quadratic};

/// Samples between two neighbouring speeds of the tables.
const SAMPLES: usize = 8;

/// Critical speeds with the stiffness at the same speed, ascending.
pub(super) fn critical_speeds(
    cached: &CachedModel,
    excitation: f64,
    interrupt: &Interrupt,
) -> Result<Vec<Critical>, AnalysisError> {
    // Every answer has its own Quadratic, because undamped modes are those of one stiffness.
    let at = |speed: f64| -> Result<Vec<f64>, AnalysisError> {
        interrupt.check()?;
        let found = Quadratic::new(&*cached.at_speed(speed)?, 1.0)?.critical(excitation)?;
        Ok(found.into_iter().map(|met| met.speed).collect())
    };
    let samples = samples(cached);
    let Some((first, last)) = samples.first().copied().zip(samples.last().copied()) else {
        // The tables have no speed in common.
        for speed in cached.model.bearings.iter().flat_map(|bearing| bearing.knots()) {
            cached.model.check_speed(speed)?;
        }
        return Ok(Vec::new());
    };
    let found = samples.iter().map(|speed| at(*speed)).collect::<Result<Vec<_>, _>>()?;
    let mut critical = Vec::new();
    let mut add = |speed: f64, number: usize| -> Result<(), AnalysisError> {
        let model = cached.at_speed(speed)?;
        let nearest = Quadratic::new(&model, 1.0)?.critical(excitation)?.into_iter().nth(number);
        critical.extend(nearest.map(|met| named(&model, met, interrupt)).transpose()?);
        Ok(())
    };
    let holds = cached.model.bearings.iter().all(|bearing| bearing.holds());
    for (number, critical) in found[0].iter().enumerate() {
        if holds && *critical < first {
            add(first, number)?;
        }
    }
    for (speeds, values) in samples.windows(2).zip(found.windows(2)) {
        for (number, (low, high)) in values[0].iter().zip(&values[1]).enumerate() {
            let ends = [(speeds[0], low - speeds[0]), (speeds[1], high - speeds[1])];
            let starts = ends[0].1 >= 0.0;
            if starts == (ends[1].1 < 0.0) {
                let speed =
                    root(ends, |speed| Ok(at(speed)?.get(number).map_or(f64::INFINITY, |critical| critical - speed)))?;
                add(speed, number)?;
            }
        }
    }
    let end = &found[found.len() - 1];
    for number in (0..end.len()).filter(|number| holds && end[*number] >= last) {
        add(last, number)?;
    }
    critical.sort_by(|a, b| a.speed.total_cmp(&b.speed));
    Ok(critical)
}

/// Speeds of the reference shaft, ascending, within the range of all tables that do not hold their end values.
fn samples(cached: &CachedModel) -> Vec<f64> {
    let model = &cached.model;
    let mut knots: Vec<f64> = model.bearings.iter().flat_map(|bearing| bearing.knots()).collect();
    knots.sort_by(f64::total_cmp);
    knots.dedup();
    let between = |pair: &[f64]| {
        let (low, width) = (pair[0], pair[1] - pair[0]);
        (0..SAMPLES).map(move |sample| low + width * sample as f64 / SAMPLES as f64).collect::<Vec<_>>()
    };
    let last = knots.last().copied();
    let mut samples: Vec<f64> = knots.windows(2).flat_map(between).chain(last).collect();
    samples.retain(|speed| model.check_speed(*speed).is_ok());
    samples
}
