//! Harmonic response at any frequency and speed: S(iω, Ω) x = f for the forces f of several sources, with
//! S(iω, Ω) = K + iω(C + ΩG) − ω²M.
//!
//! The motion is the real part of x e^{iωt}. One factorisation serves all sources of a frequency and speed.

use nalgebra::{Complex, DVector};

use super::harmonic_terms::HarmonicOutputs;
use super::sources::{Harmonic, HarmonicSource};
use super::synchronous::{MAX_RESIDUAL, SourceResponse, solve};
use super::{AnalysisError, Interrupt, Threads};
use crate::linalg::Side;
use crate::modal::{CachedModel, DynamicKey, Highest, null_motions};
use crate::model::Model;
use crate::numerics::EQUALITY_TOLERANCE;
use crate::scene::EntryPath;

/// Backward error up to which a response is not refined. Times the condition of the matrix it is the error of the response: at
/// 2,000 frequencies of a rotor on bearings with little damping, below 5e-9 of it.
const BACKWARD_ERROR: f64 = 1e-13;

/// Sources that act with one frequency at one speed.
#[derive(Clone, Copy, Debug)]
pub struct ResponsePoint<'s> {
    /// Number of the frequency or speed in messages.
    pub index: usize,
    /// Frequency and speed.
    pub at: Harmonic,
    /// The sources.
    pub sources: &'s [HarmonicSource],
}

/// Responses of a model to harmonic sources.
pub struct FrequencyResponses<'a> {
    cached: &'a CachedModel,
    /// Name of the list that [`ResponsePoint::index`] numbers.
    argument: &'static str,
    /// Highest frequency in question.
    highest: Highest,
}

impl<'a> FrequencyResponses<'a> {
    /// The responses of a model at frequencies, rad/s; nothing is computed yet.
    pub fn new(cached: &'a CachedModel, argument: &'static str, frequencies: impl Iterator<Item = f64>) -> Self {
        let highest = frequencies.map(f64::abs).fold(0.0, f64::max);
        Self { cached, argument, highest: Highest::Frequency(highest) }
    }

    /// The responses at `points`: `keep` takes each point, the model at its speed and frequency, and the responses to its sources,
    /// in the order of the points; a source without force has none.
    ///
    /// # Errors
    /// [`AnalysisError`] if a response has no accurate solution, a source drives a rigid-body motion at frequency zero, or
    /// `interrupt` requests a stop.
    pub fn each(
        &self,
        points: &[ResponsePoint<'_>],
        threads: &Threads,
        interrupt: &Interrupt,
        mut keep: impl FnMut(&ResponsePoint<'_>, &Model, &[Option<SourceResponse>]),
    ) -> Result<(), AnalysisError> {
        threads.in_order(
            points,
            |ResponsePoint { at, .. }| Ok(self.cached.at(at.speed, at.frequency)?),
            |point, cached| {
                interrupt.check()?;
                self.at(cached, point)
            },
            |point, cached, found| keep(point, &cached.model, &found),
        )
    }

    /// The responses of the model with the coefficients of speed and frequency.
    fn at(
        &self,
        cached: &CachedModel,
        point: &ResponsePoint<'_>,
    ) -> Result<Vec<Option<SourceResponse>>, AnalysisError> {
        let ResponsePoint { index, at, sources } = *point;
        let forces: Vec<_> = sources.iter().map(|source| source.force(&cached.model, at)).collect();
        if at.frequency == 0.0 {
            check_rigid_body_motion(&cached.model, &EntryPath::entry(self.argument, index), at.speed, &forces)?;
        }
        let respond = |force: &DVector<_>| self.one(cached, index, at, Side::Right, force);
        forces.iter().map(|force| force.as_ref().map(respond).transpose()).collect()
    }

    /// Solutions y of Sᵀ y = r for the rows r of outputs: a change f of the force changes the outputs by y·f.
    ///
    /// # Errors
    /// As [`Self::each`].
    pub fn adjoint(
        &self,
        index: usize,
        at: Harmonic,
        outputs: &HarmonicOutputs,
    ) -> Result<Vec<SourceResponse>, AnalysisError> {
        let cached = &*self.cached.at(at.speed, at.frequency)?;
        let rows = outputs.rows(&cached.model, at);
        rows.iter().map(|row| self.one(cached, index, at, Side::Left, row)).collect()
    }

    /// The response of a model with the coefficients of speed and frequency.
    fn one(
        &self,
        cached: &CachedModel,
        index: usize,
        at: Harmonic,
        side: Side,
        force: &DVector<Complex<f64>>,
    ) -> Result<SourceResponse, AnalysisError> {
        let Harmonic { frequency, speed } = at;
        if force.iter().all(|value| *value == Complex::ZERO) {
            return Ok(SourceResponse::zero(&cached.model));
        }
        let key = DynamicKey { speed, spin: frequency, flank_speed: speed };
        let found = solve(cached, key, self.highest, side, BACKWARD_ERROR, force)?;
        // A residual that is not a number is refused as well.
        found.filter(|found| found.residual <= MAX_RESIDUAL).ok_or_else(|| {
            AnalysisError::Convergence(format!(
                "{}[{index}]: the response at {frequency} rad/s and the speed {speed} rad/s has no accurate solution: it is an undamped natural frequency; add damping, or change the frequency or speed",
                self.argument
            ))
        })
    }
}

/// Refuses frequency zero if a force drives a rigid-body motion.
fn check_rigid_body_motion(
    model: &Model,
    path: &EntryPath<'_>,
    speed: f64,
    forces: &[Option<DVector<Complex<f64>>>],
) -> Result<(), AnalysisError> {
    let null = null_motions(model, speed)?;
    for (source, force) in forces.iter().enumerate() {
        let Some(force) = force else { continue };
        let drives = |motion: DVector<f64>| {
            let work: Complex<f64> = motion.iter().zip(force.iter()).map(|(motion, force)| force * *motion).sum();
            let size: f64 = motion.iter().zip(force.iter()).map(|(motion, force)| motion.abs() * force.norm()).sum();
            work.norm() > EQUALITY_TOLERANCE * size
        };
        if null.column_iter().any(|motion| drives(motion.into_owned())) {
            return Err(path
                    .error(format!(
                        "source[{source}] accelerates a rigid-body motion, which has no stiffness, so that the response at 0 is infinite; leave 0 out, or hold the motion with a bearing or gb.Drive"
                    ))
                    .into());
        }
    }
    Ok(())
}
