//! The fixed point of a period map: accelerated iteration, and Newton's method where that does not converge.

use nalgebra::DVector;

use super::anderson::Anderson;
use super::preconditioner::Preconditioner;
use super::{SteadyState, norm};
use crate::analysis::AnalysisError;
use crate::analysis::simulate::{PeriodMap, Response};
use crate::linalg::conjugate_residuals;
use crate::scene::SceneError;

/// Predicted error in multiples of the tolerance below which a period is recorded.
const RECORDED_ERROR: f64 = 0.5;
/// Difference after a period in multiples of the tolerance up to which a recorded motion repeats: its steps are not those of
/// the iteration, and each has an error of the tolerance.
const MAX_REPETITION_ERROR: f64 = 10.0;
/// Largest error, in multiples of the tolerance, at which the iteration may stall.
pub(super) const MAX_STALLED_ERROR: f64 = 100.0;
/// An iteration stalls if its error exceeds this fraction of the error before.
const STALLED_REDUCTION: f64 = 0.3;
/// Number of iterations in which the accelerated iteration must converge.
const MAX_ITERATIONS: usize = 30;
/// Relative tolerance of the integration in the first iteration.
const FIRST_TOLERANCE: f64 = 1e-4;
/// Relative tolerance of the integration in the next iterations, as a fraction of the expected error of the period, down to the
/// given tolerance: a period with a large error need not be integrated accurately.
const TOLERANCE_FRACTION: f64 = 1e-3;
/// Error of a state in multiples of the tolerance of the integration.
pub(super) const STATE_ERROR_FACTOR: f64 = 10.0;
/// Change of a correction in multiples of its error from which a secant is taken.
const MIN_SECANT: f64 = 5.0;
/// Number of periods of running in before each attempt of Newton's method.
const RUN_IN_PERIODS: [usize; 5] = [0, 10, 20, 40, 80];
/// Largest number of iterations of an attempt.
const MAX_NEWTON_ITERATIONS: usize = 15;
/// The linear systems of Newton's method are solved up to this fraction.
const NEWTON_RTOL: f64 = 1e-3;
/// Smallest fraction of a step of Newton's method.
const SHORTEST_STEP: f64 = 1.0 / 32.0;
/// Difference of two states from which a derivative is taken, relative to the motion. A one-sided difference takes one period;
/// its error is about this, and the 1e-13 of the stage equations divided by it.
pub(super) const DERIVATIVE_DIFFERENCE: f64 = 3e-7;
/// Change of the rigid-body velocity in a period, in multiples of the tolerance, that a mean torque causes.
const MIN_DRIFT: f64 = 10.0;

/// The iteration for the fixed point of a period map.
pub struct Solver<'s, 'a> {
    map: &'s mut PeriodMap<'a>,
    preconditioner: Preconditioner,
    tolerance: f64,
    /// Number of recorded instants.
    samples: usize,
}

/// A state with what a period does to it.
struct Point {
    z: Vec<f64>,
    /// P(z) − z.
    defect: Vec<f64>,
    /// (I − e^{AT})⁻¹ (P(z) − z).
    correction: Vec<f64>,
    /// Energy norm of the motion.
    size: f64,
    /// Size of the correction in multiples of the tolerance.
    error: f64,
    /// The recorded period, if it was.
    response: Option<Box<Response>>,
}

/// How a period is integrated.
#[derive(Clone, Copy, PartialEq)]
enum Steps {
    /// With the levels of the period before.
    Same,
    /// With levels that meet a relative tolerance.
    Adapted(f64),
    /// With levels that meet the tolerance, and recorded.
    Recorded,
}

impl<'s, 'a> Solver<'s, 'a> {
    /// Creates the solver of a map that records a number of instants.
    ///
    /// # Errors
    /// [`AnalysisError`] if a decomposition fails.
    pub fn new(map: &'s mut PeriodMap<'a>, samples: usize) -> Result<Self, AnalysisError> {
        let preconditioner = Preconditioner::new(map.linear(), map.period());
        let tolerance = map.tolerance();
        Ok(Self { map, preconditioner, tolerance, samples })
    }

    /// Records the period that reproduces its state. The iteration starts with `begin`, which needs no further iteration if it
    /// is accurate, or else with the initial state of the options.
    ///
    /// # Errors
    /// [`AnalysisError`] if no iteration converges.
    pub fn solve(&mut self, begin: Option<Vec<f64>>) -> Result<SteadyState, AnalysisError> {
        let begin = match begin {
            None => self.map.initial(),
            Some(z) => {
                let point = self.point(z, Steps::Recorded)?;
                if point.error <= 1.0 {
                    return self.found(point);
                }
                point.z.iter().zip(&point.correction).map(|(z, correction)| z + correction).collect()
            }
        };
        let mut best = match self.accelerated(begin)? {
            Ok(found) => return self.found(found),
            Err(best) => best,
        };
        for periods in RUN_IN_PERIODS {
            for _ in 0..periods {
                best.z = self.map.adapt(&best.z)?;
            }
            best = match self.newton(best.z)? {
                Ok(found) => return self.found(found),
                Err(best) => best,
            };
        }
        Err(AnalysisError::Convergence(format!(
            "the steady state did not converge in {} periods: the state after a period differs by {:.1e} of the motion, {}; start from another initial motion, add damping, or run in with simulate()",
            self.map.runs,
            norm(&best.defect) / best.size,
            self.map.place_of(&best.defect)
        )))
    }

    /// Integrates a period from z.
    fn point(&mut self, z: Vec<f64>, steps: Steps) -> Result<Point, AnalysisError> {
        let size = self.map.size(&z)?;
        let (response, image) = match steps {
            Steps::Same => (None, self.map.apply(&z)?),
            Steps::Adapted(rtol) => (None, self.map.adapt_to(&z, rtol)?),
            Steps::Recorded => {
                let (response, image) = self.map.record(1, &z, self.samples)?;
                (Some(Box::new(response)), image)
            }
        };
        let defect: Vec<f64> = image.iter().zip(&z).map(|(image, z)| image - z).collect();
        let correction = self.preconditioner.correct(&defect);
        let error = norm(&correction) / (self.tolerance * size);
        Ok(Point { z, defect, correction, size, error, response })
    }

    /// The accelerated iteration: the recorded fixed point, or the best point.
    fn accelerated(&mut self, mut z: Vec<f64>) -> Result<Result<Point, Point>, AnalysisError> {
        let (mut iteration, mut errors) = (Anderson::default(), Vec::new());
        let mut best: Option<Point> = None;
        // Tolerance of the steps.
        let mut rtol = FIRST_TOLERANCE.max(self.tolerance);
        for count in 0..MAX_ITERATIONS {
            let (is_fine, stalls, before) = (rtol <= self.tolerance, stalls(&errors), rtol);
            if count > 0 {
                rtol = next_rtol(&errors, rtol, self.tolerance);
            }
            // A period that is expected to be the last one is recorded.
            let is_last = is_fine && (predicted(&errors) <= RECORDED_ERROR || stalls);
            let point = self.point(z, if is_last { Steps::Recorded } else { Steps::Adapted(rtol) })?;
            if is_last && (point.error <= 1.0 || stalls && self.repeats(&point)) {
                return Ok(Ok(point));
            }
            self.map.report(progress(&errors, point.error));
            errors.push(point.error);
            z = iteration.next(&point.z, &point.correction, MIN_SECANT * STATE_ERROR_FACTOR * before * point.size);
            if best.as_ref().is_none_or(|best| point.error < best.error) {
                best = Some(point);
            } else if count > MAX_ITERATIONS / 2 && point.error > 1e3 * best.as_ref().map_or(0.0, |best| best.error) {
                break;
            }
        }
        best.map(Err).ok_or_else(|| AnalysisError::Convergence("the steady state has no iterations".to_owned()))
    }

    /// Whether the state after a period is the same up to the tolerance. Its error may be larger: lightly damped modes
    /// amplify the error of the integration.
    fn repeats(&self, point: &Point) -> bool {
        let rigid = &self.preconditioner.positions;
        let changes = point.defect.iter().enumerate().filter(|(entry, _)| !rigid.contains(entry));
        changes.map(|(_, change)| change * change).sum::<f64>().sqrt()
            <= MAX_REPETITION_ERROR * self.tolerance * point.size
    }

    /// Newton's method from z: the recorded fixed point, or the point from which no step reduces the correction.
    fn newton(&mut self, z: Vec<f64>) -> Result<Result<Point, Point>, AnalysisError> {
        let mut point = self.point(z, Steps::Adapted(self.tolerance))?;
        for _ in 0..MAX_NEWTON_ITERATIONS {
            // Derivatives need a base of the same steps.
            let base = self.point(point.z, Steps::Same)?;
            if base.error <= RECORDED_ERROR {
                point = self.point(base.z, Steps::Recorded)?;
                if point.error <= 1.0 || self.repeats(&point) {
                    return Ok(Ok(point));
                }
                continue;
            }
            let product = |direction: &DVector<f64>| self.product(&base, direction.as_slice()).map(DVector::from_vec);
            let correction = DVector::from_column_slice(&base.correction);
            let step = conjugate_residuals(&correction, NEWTON_RTOL, product, DVector::clone)?.x;
            point = self.line_search(&base, step.as_slice())?;
            // Further steps from here wander: a new start after running in is more likely to converge.
            if point.error >= base.error {
                return Ok(Err(base));
            }
        }
        Ok(Err(point))
    }

    /// (I − e^{AT})⁻¹ (I − P′) times a direction.
    fn product(&mut self, base: &Point, direction: &[f64]) -> Result<Vec<f64>, AnalysisError> {
        let factor = DERIVATIVE_DIFFERENCE * base.size / norm(direction);
        let moved: Vec<f64> = base.z.iter().zip(direction).map(|(z, part)| z + factor * part).collect();
        let image = self.map.apply(&moved)?;
        let difference = image.iter().zip(&moved).zip(&base.defect);
        let difference: Vec<f64> =
            difference.map(|((image, moved), defect)| (defect - (image - moved)) / factor).collect();
        Ok(self.preconditioner.correct(&difference))
    }

    /// The point after the longest part of a step that reduces the correction.
    fn line_search(&mut self, base: &Point, step: &[f64]) -> Result<Point, AnalysisError> {
        let mut part = 1.0;
        loop {
            let z = base.z.iter().zip(step).map(|(z, step)| z + part * step).collect();
            let found = self.point(z, Steps::Adapted(self.tolerance));
            let reduces = found.as_ref().is_ok_and(|point| point.error < base.error);
            if reduces || part <= SHORTEST_STEP || matches!(found, Err(AnalysisError::Interrupted)) {
                return found;
            }
            part /= 2.0;
        }
    }

    /// The steady state of a recorded point.
    fn found(&self, point: Point) -> Result<SteadyState, AnalysisError> {
        let Point { mut defect, size, response, .. } = point;
        drift(&self.preconditioner, &defect, self.tolerance * size)?;
        for entry in &self.preconditioner.positions {
            defect[*entry] = 0.0;
        }
        let response = response.ok_or_else(|| AnalysisError::Convergence("no period was recorded".to_owned()))?;
        Ok(SteadyState {
            response: *response,
            period: self.map.period(),
            residual: norm(&defect) / size,
            periods: self.map.runs,
            is_affine: self.map.is_affine(),
            warning: None,
        })
    }
}

/// Whether a mean torque changes the rigid-body velocity by more than `tolerance` allows.
///
/// # Errors
/// [`SceneError`] that names the remedy if it does.
fn drift(preconditioner: &Preconditioner, defect: &[f64], tolerance: f64) -> Result<(), AnalysisError> {
    let drift = preconditioner.velocities.iter().map(|entry| defect[*entry].abs()).fold(0.0, f64::max);
    if drift <= MIN_DRIFT * tolerance {
        return Ok(());
    }
    let message = "a mean torque accelerates the train, so that no motion is periodic; balance the torques, or hold the rotation with gb.Drive(at, stiffness=...)";
    Err(SceneError::new("torques", message).into())
}

/// Tolerance of the steps of the next iteration, between that of the solution and that of the last one.
fn next_rtol(errors: &[f64], rtol: f64, tolerance: f64) -> f64 {
    let expected = predicted(errors).max(STATE_ERROR_FACTOR * rtol / tolerance);
    (TOLERANCE_FRACTION * expected * tolerance).clamp(tolerance, rtol)
}

/// Error of the next iterate in multiples of the tolerance, if it decreases as in the last iteration.
fn predicted(errors: &[f64]) -> f64 {
    match errors {
        [.., before, last] => last * (last / before).min(1.0),
        [first] => *first,
        [] => f64::INFINITY,
    }
}

/// Whether the error is near the tolerance and decreases little: it is the error of the integration.
fn stalls(errors: &[f64]) -> bool {
    matches!(errors, [.., before, last] if *last <= MAX_STALLED_ERROR && *last > STALLED_REDUCTION * before)
}

/// Completed part of the solution: that of the decades between the first error and the tolerance.
pub(super) fn progress(errors: &[f64], last: f64) -> f64 {
    let first = errors.first().copied().unwrap_or(last).max(10.0);
    ((first / last).ln() / first.ln()).clamp(0.0, 0.95)
}
