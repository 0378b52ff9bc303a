//! Undamped critical speeds where the stiffness of bearings depends on the speed, or on the frequency, which is that of the
//! excitation there.
//!
//! With the stiffness K(s) of one speed s, the eigenproblem gives critical speeds Ω_1(s) ≤ Ω_2(s) ≤ …. A critical speed of
//! the rotor is a root of Ω_j(s) − s, because only there mode and bearings belong to the same speed. The functions Ω_j are
//! continuous, since eigenvalues are. They are sampled at the speeds of all tables and between them, and each change of
//! sign is closed by the method of Illinois (Dowell and Jarratt, BIT 11, 1971). Two roots between neighbouring samples
//! would be missed: between two speeds of a table there are [`SAMPLES_PER_INTERVAL`], and the stiffness is monotone there.

use super::{Critical, Interrupt, named};
use crate::analysis::AnalysisError;
use crate::modal::{CachedModel, CriticalProblem};
use crate::numerics::{Sample, root};

/// Samples between two neighbouring speeds of the tables.
const SAMPLES_PER_INTERVAL: usize = 8;

/// Critical speeds with the stiffness at the same speed, by ascending |Ω|. A negative order of the excitation asks for negative
/// speeds; the search is one in |Ω|.
pub(super) fn critical_speeds(
    cached: &CachedModel,
    excitation: f64,
    interrupt: &Interrupt,
) -> Result<Vec<Critical>, AnalysisError> {
    let model_at = |size: f64| cached.at(size * excitation.signum(), size * excitation.abs());
    let at = |size: f64| -> Result<Vec<f64>, AnalysisError> {
        interrupt.check()?;
        let found = CriticalProblem::new(&*model_at(size)?, excitation)?.critical(excitation)?;
        Ok(found.into_iter().map(|met| met.speed.abs()).collect())
    };
    let samples = samples(cached, excitation)?;
    let found = samples.iter().map(|speed| Ok((*speed, at(*speed)?))).collect::<Result<Vec<_>, AnalysisError>>()?;
    // |Ω| whose stiffness counts, and the number of the critical speed.
    let mut roots: Vec<(f64, usize)> = Vec::new();
    let holds = cached.model.bearings.iter().all(|bearing| bearing.holds());
    if let Some((first, values)) = found.first().filter(|_| holds) {
        roots.extend(values.iter().enumerate().filter(|(_, value)| *value < first).map(|(number, _)| (*first, number)));
    }
    for pair in found.windows(2) {
        for (number, values) in pair[0].1.iter().zip(&pair[1].1).enumerate() {
            let sample = |at: f64, value: f64| Sample { at, value: value - at };
            let ends = [sample(pair[0].0, *values.0), sample(pair[1].0, *values.1)];
            if (ends[0].value >= 0.0) == (ends[1].value < 0.0) {
                let value =
                    |speed: f64| at(speed).map(|found| found.get(number).map_or(f64::INFINITY, |value| value - speed));
                roots.push((root(ends, value)?, number));
            }
        }
    }
    if let Some((last, values)) = found.last().filter(|_| holds) {
        roots.extend(values.iter().enumerate().filter(|(_, value)| *value >= last).map(|(number, _)| (*last, number)));
    }
    let mut critical = Vec::new();
    for (size, number) in roots {
        let model = model_at(size)?;
        let met = CriticalProblem::new(&model, excitation)?.critical(excitation)?.into_iter().nth(number);
        critical.extend(named(&model.model, model.spectral_range(excitation)?, met.as_slice(), interrupt)?);
    }
    critical.sort_by(|a, b| a.speed.abs().total_cmp(&b.speed.abs()));
    Ok(critical)
}

/// |Ω| of the reference shaft, ascending, within the range of all tables that do not hold their end values.
///
/// # Errors
/// [`AnalysisError`] if the tables have no speed in common.
fn samples(cached: &CachedModel, excitation: f64) -> Result<Vec<f64>, AnalysisError> {
    let model = &cached.model;
    let mut knots: Vec<f64> = model.bearings.iter().flat_map(|bearing| bearing.knots()).collect();
    knots.extend(model.table_frequencies().into_iter().map(|frequency| frequency / excitation.abs()));
    knots.sort_by(f64::total_cmp);
    knots.dedup();
    let between = |pair: &[f64]| {
        let (low, width) = (pair[0], pair[1] - pair[0]);
        (0..SAMPLES_PER_INTERVAL)
            .map(move |sample| low + width * sample as f64 / SAMPLES_PER_INTERVAL as f64)
            .collect::<Vec<_>>()
    };
    let last = knots.last().copied();
    let mut samples: Vec<f64> = knots.windows(2).flat_map(between).chain(last).collect();
    let check = |size: &f64| model.at_frequency(size * excitation.abs())?.check_speed(size * excitation.signum());
    samples.retain(|size| check(size).is_ok());
    if samples.is_empty() {
        knots.iter().try_for_each(check)?;
    }
    Ok(samples)
}
