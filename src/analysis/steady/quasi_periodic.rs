//! Steady motions of several frequencies without a common period.
//!
//! The map over a section of length T, a common period of the teeth, differs from section to section, because the shafts
//! have turned by other angles. The states at the sections are a sum of few harmonics of the other frequencies (Kaas-Petersen,
//! J. Comput. Phys. 58, 1985). Their coefficients are the unknowns; the map from as many sections as there are unknowns
//! gives the equations. The iteration is that of periodic motions: the correction of the linear motion, diagonal in modes and
//! harmonics, is accelerated by the secants of all iterations. The number of harmonics grows until the motion does not change.

use nalgebra::DMatrix;

use super::anderson::Anderson;
use super::harmonics::{Combinations, Harmonics};
use super::period::Sections;
use super::preconditioner::Preconditioner;
use super::solver::{
    FIRST_TOLERANCE, MAX_REPETITION_ERROR, MIN_SECANT, STATE_ERROR_FACTOR, TOLERANCE_FRACTION, drift, next_rtol,
    predicted, progress, stalls,
};
use super::turning::Turning;
use super::{SteadyState, norm};
use crate::analysis::AnalysisError;
use crate::analysis::simulate::PeriodMap;

/// No more harmonics are added after [`MAX_SLOW_ADDITIONS`] additions in a row whose change of the motion is more than [`SLOW_ADDITION_RATIO`] times
/// that of the addition before, or after [`MAX_ADDITIONS`].
const MAX_SLOW_ADDITIONS: usize = 2;
const SLOW_ADDITION_RATIO: f64 = 0.5;
const MAX_ADDITIONS: usize = 20;
/// Duration of running in over that of the first run before the record.
const SHORTEST_RUN_IN: u64 = 8;
/// Longest run before the record in multiples of the duration of running in, and the margin of its prediction.
const LONGEST_RUN_IN: u64 = 4;
const RUN_IN_SAFETY: f64 = 1.2;
/// Work in multiples of running in, beyond that of the unknowns, after which no more harmonics are added.
const MAX_WORK: u64 = 8;
/// Number of sections for each unknown that the first harmonics take. Where running in takes less, it is tried first.
const FIRST_HARMONICS: u64 = 8;
/// Largest error, relative to the motion, that may remain.
const MAX_TRANSIENT: f64 = 1e-2;
/// Coefficients of a harmonic in multiples of the tolerance from which its neighbours matter.
const SIGNIFICANT_AMPLITUDE: f64 = 0.1;
/// Number of iterations in which the accelerated iteration must converge.
const MAX_ITERATIONS: usize = 40;
/// Relative error up to which the first harmonics are solved if others follow. The others are solved up to a fraction of the
/// last change of the motion.
const FIRST_GOAL: f64 = 1e-3;
const GOAL_FRACTION: f64 = 0.1;
/// Sections at which the harmonics are checked, in multiples of the largest one of the unknowns.
const CHECKED_SECTIONS: [f64; 3] = [1.37, 2.19, 3.53];
/// Largest difference of the recorded motion from the harmonics at its end, in multiples of the tolerance.
const MAX_END_DIFFERENCE: f64 = 1000.0;

/// The solution for the states at the sections.
pub struct QuasiPeriodic<'s, 'a> {
    map: &'s mut PeriodMap<'a>,
    constant: Preconditioner,
    sections: &'s Sections,
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

/// A state at the beginning of the record.
pub struct Begin {
    /// The state z.
    pub state: Vec<f64>,
    /// Estimated transient part of the state, relative to the motion.
    error: f64,
    solution: Solution,
}

impl Solution {
    /// The state at the beginning of a section.
    fn state(&self, section: i64) -> Vec<f64> {
        self.harmonics.state(&self.coefficients, section)
    }

    /// Norm of the coefficients of a harmonic.
    fn amplitude(&self, harmonic: usize) -> f64 {
        let (first, count) = self.harmonics.unknowns_of(harmonic);
        self.coefficients.columns(first, count).norm()
    }
}

impl<'s, 'a> QuasiPeriodic<'s, 'a> {
    /// Creates the solution for the map of sections.
    ///
    /// # Errors
    /// [`AnalysisError`] if a decomposition fails.
    pub fn new(map: &'s mut PeriodMap<'a>, sections: &'s Sections) -> Result<Self, AnalysisError> {
        let constant = Preconditioner::new(map.linear(), map.period());
        let tolerance = map.tolerance();
        Ok(Self { map, constant, sections, tolerance, size: 1.0 })
    }

    /// Finds the motion, and records `samples` instants of a number of sections.
    ///
    /// # Errors
    /// [`AnalysisError`] if the iteration does not converge.
    pub fn solve(&mut self, sections: u64, samples: usize) -> Result<SteadyState, AnalysisError> {
        let found = self.begin()?;
        let (response, last) = self.map.record(sections, &found.state, samples)?;
        let expected = found.solution.state(sections as i64);
        let difference = self.distance(&last, &expected);
        if found.error == 0.0 && difference > MAX_END_DIFFERENCE * self.tolerance {
            return Err(AnalysisError::Convergence(format!(
                "the motion of these frequencies is unstable, or contains further ones: a run that begins with it differs by {difference:.1e} of the motion at its end, {}; run in with simulate()",
                self.map
                    .place_of(&last.iter().zip(&expected).map(|(last, expected)| last - expected).collect::<Vec<_>>())
            )));
        }
        let warning = format!(
            "the motion has more harmonics than its solution: about {:.1e} of it are transient at the begin of the record",
            found.error
        );
        Ok(SteadyState {
            response,
            period: f64::INFINITY,
            // What is transient says more than the harmonics that it replaces.
            residual: if found.error > 0.0 { found.error } else { found.solution.defect.max(difference) },
            periods: self.map.runs,
            is_affine: self.map.is_affine(),
            warning: Some(warning).filter(|_| found.error > STATE_ERROR_FACTOR * self.tolerance),
        })
    }

    /// The state at the beginning of the record. Its harmonics need no more accuracy than running in leaves of a transient.
    ///
    /// # Errors
    /// [`AnalysisError`] if the iteration does not converge.
    pub fn begin(&mut self) -> Result<Begin, AnalysisError> {
        let initial = self.map.initial();
        self.size = self.map.size(&initial)?;
        let mut combinations = Combinations::new(self.sections.base.clone());
        let mut coefficients = DMatrix::from_column_slice(initial.len(), 1, &initial);
        if let Some(harmonics) = self.cheap_to_run_in(&combinations) {
            let mean = Solution { harmonics, coefficients: coefficients.clone(), defect: 1.0 };
            let found = self.settled(mean, LONGEST_RUN_IN)?;
            if self.is_accurate(&found) {
                return Ok(found);
            }
        }
        let mut changes = Changes { relative: Vec::new(), tolerance: self.tolerance };
        let (mut best, mut failure): (Option<Begin>, Option<String>) = (None, None);
        let begun = self.map.runs;
        while !changes.resist() && self.has_time(begun, coefficients.ncols()) {
            let Some(harmonics) = Harmonics::new(&combinations) else { break };
            // The unknowns of earlier harmonics come first.
            let before = coefficients.clone().resize_horizontally(harmonics.unknowns(), 0.0);
            let goal = if self.map.is_affine() { 1.0 } else { changes.goal() };
            let solution = match self.iterate(harmonics, before.clone(), goal) {
                Err(AnalysisError::Convergence(message)) if best.is_some() => {
                    failure = Some(message);
                    break;
                }
                solution => solution?,
            };
            if coefficients.ncols() > 1 {
                changes.relative.push((&solution.coefficients - before).norm() / self.size);
            }
            coefficients.clone_from(&solution.coefficients);
            let limit = SIGNIFICANT_AMPLITUDE * self.tolerance * self.size;
            let grows = combinations.grow(|harmonic| solution.amplitude(harmonic) > limit);
            let is_complete = goal <= 1.0 && (self.map.is_affine() || !grows || changes.converge());
            let found = if is_complete { self.verified(solution)? } else { self.settled(solution, 1)? };
            if self.is_accurate(&found) {
                return Ok(found);
            }
            best = Some(found).filter(|found| best.as_ref().is_none_or(|best| found.error < best.error)).or(best);
        }
        let best = best.map(|best| self.settled(best.solution, LONGEST_RUN_IN)).transpose()?;
        best.filter(|best| best.error <= MAX_TRANSIENT).ok_or_else(|| {
            AnalysisError::Convergence(failure.unwrap_or_else(|| format!(
                "the quasi-periodic motion did not converge: further harmonics change it by {:.1e} of its size, with {} unknowns of each coordinate; it is unstable, or its transient decays slowly; run in with simulate() and give its response as initial, or add damping",
                changes.last(),
                coefficients.ncols()
            )))
        })
    }

    /// Whether the transient part of a state is within its error.
    fn is_accurate(&self, begin: &Begin) -> bool {
        begin.error <= STATE_ERROR_FACTOR * self.tolerance
    }

    /// The state of a solution that satisfies the equations at further sections too; otherwise the state after running in.
    fn verified(&mut self, mut solution: Solution) -> Result<Begin, AnalysisError> {
        let unseen = self.unseen(&solution)?;
        if unseen > MAX_REPETITION_ERROR * STATE_ERROR_FACTOR * self.tolerance {
            return self.settled(solution, 1);
        }
        solution.defect = solution.defect.max(unseen);
        Ok(Begin { state: solution.state(0), error: 0.0, solution })
    }

    /// Whether the work since `begun` leaves time for more than a number of unknowns.
    fn has_time(&self, begun: usize, unknowns: usize) -> bool {
        let limit = MAX_WORK * self.sections.run_in + FIRST_HARMONICS * unknowns as u64;
        (self.map.runs - begun) as u64 <= limit
    }

    /// The mean alone, if a run is cheaper than finding the first harmonics.
    fn cheap_to_run_in(&self, combinations: &Combinations) -> Option<Harmonics> {
        let first = Harmonics::new(combinations)?.unknowns() as u64;
        // For an affine map, the first harmonics are exact.
        if self.map.is_affine() || self.sections.run_in > FIRST_HARMONICS * first {
            return None;
        }
        Harmonics::new(&Combinations::new(Vec::new()))
    }

    /// The state at the beginning of the record after running in, for as long as the decay of the first changes asks for, up to `longest` times
    /// the duration of running in.
    fn settled(&mut self, solution: Solution, longest: u64) -> Result<Begin, AnalysisError> {
        let mut begin = Begin { error: f64::INFINITY, state: solution.state(0), solution };
        let shortest = self.sections.run_in.div_ceil(SHORTEST_RUN_IN);
        let (mut shorter, mut count) = (0, shortest);
        while count <= longest * self.sections.run_in {
            let first = -(count as i64);
            let state = match self.map.periods_from(first, count, &begin.solution.state(first), self.tolerance) {
                Err(AnalysisError::Interrupted) => return Err(AnalysisError::Interrupted),
                // An unstable motion may end the contact geometry.
                Err(_) => break,
                Ok(state) => state,
            };
            // A mode that decays slowly changes less between two runs than its error is.
            let between = self.map.period() * (count - shorter).max(1) as f64;
            let slow = Preconditioner::new(self.map.linear(), between);
            let change: Vec<f64> = state.iter().zip(&begin.state).map(|(long, short)| long - short).collect();
            let error = self.distance(&state, &begin.state).max(norm(&slow.correct(&change)) / self.size);
            let decay = (begin.error / error).ln() / (count - shorter) as f64;
            begin = Begin { state, error, ..begin };
            let left = error / (STATE_ERROR_FACTOR * self.tolerance);
            if left <= 1.0 {
                break;
            }
            shorter = count;
            // Not longer than it must be, but at most twice as long: the first changes decay in another way than later ones.
            let needed =
                if decay.is_finite() { (RUN_IN_SAFETY * left.ln() / decay.max(0.0)).ceil() } else { f64::INFINITY };
            count += if needed < count as f64 { (needed as u64).max(1) } else { count };
        }
        Ok(begin)
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
        let finest = self.tolerance * (TOLERANCE_FRACTION * goal).max(1.0);
        let mut rtol = FIRST_TOLERANCE.max(finest);
        for count in 0..MAX_ITERATIONS {
            let before = rtol;
            if count > 0 {
                rtol = next_rtol(&errors, rtol, self.tolerance, finest);
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
            let noise = MIN_SECANT * STATE_ERROR_FACTOR * before * self.size;
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
            column.copy_from_slice(&self.defect(harmonics, coefficients, *section, rtol)?);
        }
        Ok(defects)
    }

    fn defect(
        &mut self,
        harmonics: &Harmonics,
        coefficients: &DMatrix<f64>,
        section: i64,
        rtol: f64,
    ) -> Result<Vec<f64>, AnalysisError> {
        let image = self.map.periods_from(section, 1, &harmonics.state(coefficients, section), rtol)?;
        let next = harmonics.state(coefficients, section + 1);
        Ok(image.iter().zip(&next).map(|(image, next)| image - next).collect())
    }

    /// The correction of the linear motion for the defects of all sections; none where it resonates without damping.
    fn correction(&self, harmonics: &Harmonics, turning: &[Turning], defects: &DMatrix<f64>) -> Option<DMatrix<f64>> {
        let parts = harmonics.coefficients(defects)?;
        let mut correction = DMatrix::zeros(parts.nrows(), parts.ncols());
        correction.column_mut(0).copy_from_slice(&self.constant.correct(parts.column(0).as_slice()));
        for (harmonic, turning) in (1..).zip(turning) {
            let corrected = turning.correct(&harmonics.complex(harmonic, &parts))?;
            harmonics.store(harmonic, &corrected, &mut correction);
        }
        Some(correction)
    }

    /// Largest defect at sections from which the coefficients do not follow, relative to the motion.
    fn unseen(&mut self, solution: &Solution) -> Result<f64, AnalysisError> {
        let Solution { harmonics, coefficients, .. } = solution;
        let last = harmonics.sections.iter().copied().max().unwrap_or(0);
        let mut largest = 0.0_f64;
        for factor in CHECKED_SECTIONS {
            let section = (factor * (last + 1) as f64).ceil() as i64;
            let defect = self.defect(harmonics, coefficients, section, self.tolerance)?;
            drift(&self.constant, &defect, self.tolerance * self.size)?;
            largest = largest.max(self.relative_size(defect));
        }
        Ok(largest)
    }

    /// Difference of two states relative to the motion, apart from rigid-body rotation.
    fn distance(&self, a: &[f64], b: &[f64]) -> f64 {
        self.relative_size(a.iter().zip(b).map(|(a, b)| a - b).collect())
    }

    /// Size of a difference of states relative to the motion, apart from rigid-body rotation.
    fn relative_size(&self, mut difference: Vec<f64>) -> f64 {
        for entry in &self.constant.positions {
            difference[*entry] = 0.0;
        }
        norm(&difference) / self.size
    }
}

/// Changes of the motion by further harmonics.
struct Changes {
    /// The changes relative to the motion.
    relative: Vec<f64>,
    tolerance: f64,
}

impl Changes {
    /// The last change; 1 before the first.
    fn last(&self) -> f64 {
        self.relative.last().copied().unwrap_or(1.0)
    }

    /// Error in multiples of the tolerance up to which the next harmonics are solved.
    fn goal(&self) -> f64 {
        let goal = self.relative.last().map_or(FIRST_GOAL, |change| GOAL_FRACTION * change);
        (goal / self.tolerance).max(1.0)
    }

    /// Whether the next harmonics would change less than the error of a state.
    fn converge(&self) -> bool {
        predicted(&self.relative) <= STATE_ERROR_FACTOR * self.tolerance
    }

    /// Whether further harmonics do not help.
    fn resist(&self) -> bool {
        let little = self.relative.windows(2).rev().take_while(|pair| pair[1] > SLOW_ADDITION_RATIO * pair[0]).count();
        little >= MAX_SLOW_ADDITIONS || self.relative.len() >= MAX_ADDITIONS
    }
}
