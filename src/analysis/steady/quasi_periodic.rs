//! Steady motions of several frequencies without a common period.
//!
//! The map over a section of length T, a common period of the teeth, differs from section to section, because the shafts
//! have turned by other angles. The states at the sections are a sum of few harmonics of the other frequencies (Kaas-Petersen,
//! J. Comput. Phys. 58, 1985). Their coefficients are the unknowns; the map from as many sections as there are unknowns
//! gives the equations. The iteration is that of periodic motions: the correction of the linear motion, diagonal in modes and
//! harmonics, is accelerated by the secants of all iterations. The number of harmonics grows until the motion does not change.

use nalgebra::DMatrix;

use super::anderson::Anderson;
use super::harmonics::{BaseFrequency, Harmonics};
use super::preconditioner::Preconditioner;
use super::solver::{AMPLIFICATION, COARSEST, FRACTION, REPEATED, SECANT, drift, predicted, progress, stalls};
use super::turning::Turning;
use super::{SteadyState, norm};
use crate::analysis::AnalysisError;
use crate::analysis::simulate::PeriodMap;

/// Largest order of combinations of frequencies.
const MAX_ORDER: usize = 12;
/// Number of iterations in which the accelerated iteration must converge.
const MAX_ITERATIONS: usize = 40;
/// Relative error up to which the first order is solved where higher orders follow, and the fraction of the last change up to
/// which these are.
const FIRST_GOAL: f64 = 1e-3;
const NEXT_GOAL: f64 = 0.1;
/// Sections at which the harmonics are checked, in multiples of the largest one of the unknowns.
const CHECKED: [f64; 3] = [1.37, 2.19, 3.53];
/// Largest difference of the recorded motion from the harmonics at its end, in multiples of the tolerance.
const LEAVES: f64 = 1000.0;

/// The solution for the states at the sections.
pub struct QuasiPeriodic<'s, 'a> {
    map: &'s mut PeriodMap<'a>,
    constant: Preconditioner,
    base: Vec<BaseFrequency>,
    tolerance: f64,
    /// Energy norm of the motion.
    size: f64,
}

/// Coefficients of harmonics, with what the map does to them.
struct Solution {
    harmonics: Harmonics,
    /// A column for each unknown.
    coefficients: DMatrix<f64>,
    /// Largest difference of a state from the map of the state before, relative to the motion.
    defect: f64,
}

impl<'s, 'a> QuasiPeriodic<'s, 'a> {
    /// Creates the solution for a section map and the frequencies that the section does not contain.
    ///
    /// # Errors
    /// [`AnalysisError`] if a decomposition fails.
    pub fn new(map: &'s mut PeriodMap<'a>, base: Vec<BaseFrequency>) -> Result<Self, AnalysisError> {
        let constant = Preconditioner::new(map.linear(), map.period())?;
        let tolerance = map.tolerance();
        Ok(Self { map, constant, base, tolerance, size: 1.0 })
    }

    /// Finds the motion, and records `samples` instants of a number of sections.
    ///
    /// # Errors
    /// [`AnalysisError`] if the iteration does not converge.
    pub fn solve(&mut self, sections: u64, samples: usize) -> Result<SteadyState, AnalysisError> {
        let solution = self.harmonics()?;
        let (response, last) =
            self.map.record_periods(sections, &solution.harmonics.state(&solution.coefficients, 0), samples)?;
        let expected = solution.harmonics.state(&solution.coefficients, sections);
        let difference = self.distance(&last, &expected);
        if difference > LEAVES * self.tolerance {
            return Err(AnalysisError::Convergence(format!(
                "the motion of these frequencies is unstable, or contains further harmonics: a run that begins with it differs by {difference:.1e} of the motion at its end; run in with simulate()"
            )));
        }
        Ok(SteadyState {
            response,
            period: f64::INFINITY,
            residual: solution.defect.max(difference),
            periods: self.map.runs,
            is_affine: self.map.is_affine(),
        })
    }

    /// Raises the order of the harmonics until the motion does not change.
    fn harmonics(&mut self) -> Result<Solution, AnalysisError> {
        let initial = self.map.initial();
        self.size = self.map.size(&initial)?;
        let mut last: Option<Solution> = None;
        let mut coefficients = DMatrix::from_column_slice(initial.len(), 1, &initial);
        let mut changes: Vec<f64> = Vec::new();
        for order in 1..=MAX_ORDER {
            let Some(harmonics) = Harmonics::new(&self.base, order) else { break };
            if let Some(complete) = last.take_if(|last| last.harmonics.unknowns() == harmonics.unknowns()) {
                return Ok(complete);
            }
            // The unknowns of lower orders come first.
            let before = coefficients.clone().resize_horizontally(harmonics.unknowns(), 0.0);
            let goal = match changes.last() {
                _ if self.map.is_affine() => 1.0,
                None => (FIRST_GOAL / self.tolerance).max(1.0),
                Some(change) => (NEXT_GOAL * change).max(1.0),
            };
            let mut found = self.iterate(harmonics, before.clone(), goal)?;
            if order > 1 {
                changes.push((&found.coefficients - before).norm() / (self.tolerance * self.size));
            }
            let converges = self.map.is_affine() || goal <= 1.0 && predicted(&changes) <= 1.0;
            if converges {
                let unseen = self.unseen(&found)?;
                if unseen <= REPEATED * self.tolerance {
                    found.defect = found.defect.max(unseen);
                    return Ok(found);
                }
            }
            coefficients.clone_from(&found.coefficients);
            last = Some(found);
        }
        let (count, error) = last.map_or((0, 1.0), |last| (last.harmonics.angles.len(), last.defect));
        Err(AnalysisError::Convergence(format!(
            "the quasi-periodic motion did not converge with {count} combinations of its frequencies: the state after a section differs by {error:.1e} of the motion; give a larger rtol, or run in with simulate()"
        )))
    }

    /// The accelerated iteration from given coefficients up to a `goal` in multiples of the tolerance.
    fn iterate(
        &mut self,
        harmonics: Harmonics,
        mut coefficients: DMatrix<f64>,
        goal: f64,
    ) -> Result<Solution, AnalysisError> {
        let turning = Turning::at(self.map.linear(), self.map.period(), &harmonics.angles[1..]);
        let (mut iteration, mut errors) = (Anderson::default(), Vec::new());
        let finest = self.tolerance * (FRACTION * goal).max(1.0);
        let mut rtol = COARSEST.max(finest);
        for count in 0..MAX_ITERATIONS {
            let before = rtol;
            if count > 0 {
                let expected = predicted(&errors).max(AMPLIFICATION * rtol / self.tolerance);
                rtol = (FRACTION * expected * self.tolerance).clamp(finest, rtol);
            }
            let defects = self.defects(&harmonics, &coefficients, rtol)?;
            let correction = self.correction(&harmonics, &turning, &defects).ok_or_else(|| {
                AnalysisError::Convergence(
                    "a frequency of the excitation is that of an undamped mode, so that no motion is bounded; add damping"
                        .to_owned(),
                )
            })?;
            let error = correction.norm() / (self.tolerance * self.size);
            errors.push(error);
            let size = defects.column_iter().map(|column| column.norm()).fold(0.0, f64::max) / self.size;
            if rtol <= finest && (error <= goal || stalls(&errors)) {
                let change = &coefficients + &correction;
                return Ok(Solution { harmonics, coefficients: change, defect: size });
            }
            self.map.report(progress(&errors, error));
            let noise = SECANT * AMPLIFICATION * before * self.size;
            let next = iteration.next(coefficients.as_slice(), correction.as_slice(), noise);
            coefficients.copy_from_slice(&next);
        }
        Err(AnalysisError::Convergence(format!(
            "the quasi-periodic motion did not converge in {} sections: it changes by {:.1e} of the motion; start from another initial motion, add damping, or run in with simulate()",
            self.map.runs,
            errors.last().copied().unwrap_or(f64::INFINITY) * self.tolerance
        )))
    }

    /// Differences between the map of the states at the sections and the states one section later, a column for each section.
    fn defects(
        &mut self,
        harmonics: &Harmonics,
        coefficients: &DMatrix<f64>,
        rtol: f64,
    ) -> Result<DMatrix<f64>, AnalysisError> {
        let mut defects = DMatrix::zeros(coefficients.nrows(), harmonics.unknowns());
        for (section, mut column) in harmonics.sections.iter().zip(defects.column_iter_mut()) {
            column.copy_from_slice(&self.defect(harmonics, coefficients, (*section, rtol))?);
        }
        Ok(defects)
    }

    fn defect(
        &mut self,
        harmonics: &Harmonics,
        coefficients: &DMatrix<f64>,
        (section, rtol): (u64, f64),
    ) -> Result<Vec<f64>, AnalysisError> {
        let image = self.map.period_of_number(section, &harmonics.state(coefficients, section), rtol)?;
        let next = harmonics.state(coefficients, section + 1);
        Ok(image.iter().zip(&next).map(|(image, next)| image - next).collect())
    }

    /// The correction of the linear motion for the defects of all sections; none where it resonates without damping.
    fn correction(&self, harmonics: &Harmonics, turning: &[Turning], defects: &DMatrix<f64>) -> Option<DMatrix<f64>> {
        let parts = harmonics.coefficients(defects)?;
        let mut correction = DMatrix::zeros(parts.nrows(), parts.ncols());
        correction.column_mut(0).copy_from_slice(&self.constant.correct(parts.column(0).as_slice()));
        for ((harmonic, first), turning) in harmonics.first_unknowns().skip(1).zip(turning) {
            let corrected = turning.correct(&harmonics.complex(harmonic, first, &parts))?;
            harmonics.store(harmonic, first, &corrected, &mut correction);
        }
        Some(correction)
    }

    /// Largest defect at sections from which the coefficients do not follow, relative to the motion.
    fn unseen(&mut self, solution: &Solution) -> Result<f64, AnalysisError> {
        let Solution { harmonics, coefficients, .. } = solution;
        let last = harmonics.sections.iter().copied().max().unwrap_or(0);
        let mut largest = 0.0_f64;
        for factor in CHECKED {
            let section = (factor * (last + 1) as f64).ceil() as u64;
            let mut defect = self.defect(harmonics, coefficients, (section, self.tolerance))?;
            drift(&self.constant, &defect, self.tolerance * self.size)?;
            for entry in &self.constant.positions {
                defect[*entry] = 0.0;
            }
            largest = largest.max(norm(&defect) / self.size);
        }
        Ok(largest)
    }

    /// Difference of two states relative to the motion, apart from rigid-body rotation.
    fn distance(&self, a: &[f64], b: &[f64]) -> f64 {
        let mut difference: Vec<f64> = a.iter().zip(b).map(|(a, b)| a - b).collect();
        for entry in &self.constant.positions {
            difference[*entry] = 0.0;
        }
        norm(&difference) / self.size
    }
}
