//! Pilot runs: a part of a run, with which models of different size are compared.
//!
//! It is the first part at a constant speed. At a changing speed it is the part around the largest speed, where the teeth
//! excite the highest frequencies.

use super::heartbeat::Heartbeat;
use super::initial::Start;
use super::modal_setup::ModalSetup;
use super::record::{Record, Recorder};
use super::{RecordPlan, Run, RunObserver, exponential, sample_step};
use crate::analysis::AnalysisError;
use crate::integrate::{Halt, Observer, Statistics};
use crate::scene::{COMPARED_DURATION, SHARE_OF_MEAN};

/// Part of a run that a pilot run takes, within `MIN_PILOT_DURATION` and `COMPARED_DURATION`.
const PILOT_PART: f64 = 1.0 / 3.0;
/// Shortest duration of a pilot run, s: less contains little but the transient at the beginning.
const MIN_PILOT_DURATION: f64 = 0.03;
/// Duration, s, where it compares a run with its system: several periods of the teeth.
const CHECK_DURATION: f64 = 0.02;
/// Smallest and largest number of samples of a pilot run.
const PILOT_SAMPLES: [f64; 2] = [200.0, 4000.0];

/// The part of a run that is integrated with models of different size.
pub(super) struct Pilot {
    /// Initial conditions.
    start: Start,
    /// Elapsed time at the beginning and at the end, s.
    span: [f64; 2],
    /// Times of the samples, at equal intervals, s; none for a run without duration.
    times: Vec<f64>,
    /// Ratio of the time over which errors count to the duration.
    ratio: f64,
}

impl Pilot {
    /// Chooses the part of a run that decides on the number of modes.
    pub fn new(run: &Run<'_>, start: &Start) -> Self {
        Self::lasting(run, start, (PILOT_PART * run.options.duration).clamp(MIN_PILOT_DURATION, COMPARED_DURATION))
    }

    /// Chooses the part of a run that checks whether a known number of modes keeps the accuracy.
    pub fn check(run: &Run<'_>, start: &Start) -> Self {
        Self::lasting(run, start, CHECK_DURATION)
    }

    /// Chooses a part of this duration, s, or the whole run if it is shorter.
    fn lasting(run: &Run<'_>, start: &Start, duration: f64) -> Self {
        let Run { cached, options, .. } = *run;
        let duration = duration.min(options.duration);
        let end = options.start + options.duration;
        let fastest = options.speed.time_of_fastest(options.start, end);
        let first = (fastest - duration / 2.0).min(end - duration).max(options.start);
        let [least, most] = PILOT_SAMPLES;
        let intervals = (duration / sample_step(&cached.model, options.fastest())).ceil().clamp(least, most);
        let count = if duration > 0.0 { intervals as usize } else { 0 };
        let begin = first - start.rotation.origin;
        Self {
            start: if first > options.start { start.moved(cached, options, first) } else { start.clone() },
            span: [begin, begin + duration],
            ratio: if duration > 0.0 { options.duration.min(COMPARED_DURATION).max(duration) / duration } else { 1.0 },
            times: (1..=count).map(|index| first + duration * index as f64 / intervals).collect(),
        }
    }

    /// Errors of displacements and of mesh forces of a run, from the signals of the pilot run.
    pub fn errors(&self, found: &Record, exact: &Record) -> [f64; 2] {
        differences(found, exact, self.ratio)
    }

    /// The signals of a model.
    pub fn signals(
        &self,
        run: &Run<'_>,
        setup: &ModalSetup<'_>,
        plan: &RecordPlan,
        observer: &mut impl Observer,
    ) -> Result<Record, AnalysisError> {
        if self.times.is_empty() {
            return Ok(Record::default());
        }
        let [begin, end] = self.span;
        let plan = RecordPlan { energy: false, velocity: false, acceleration: false, cuts: Vec::new(), ..plan.clone() };
        let (motion, origin) = (setup.loads.motion.clone(), self.start.rotation.origin);
        let mut watch = |_| observer.continues(run.options.start - origin);
        let mut pilot = RunObserver {
            recorder: Recorder::new(motion, &plan, &self.times, origin, begin, 0.0),
            heartbeat: Heartbeat::waiting(&mut watch),
            start: begin,
            end,
        };
        let mut counts = Statistics::new();
        let (_, outcome) =
            exponential::run(run.cached, run.options, setup.clone(), &self.start, end, &mut pilot, &mut counts)?;
        if outcome.is_err_and(|halted| matches!(halted.halt, Halt::Interrupted)) {
            return Err(AnalysisError::Interrupted);
        }
        Ok(pilot.recorder.finish().0)
    }
}

/// Errors of displacements and of mesh forces, for the worst signal: RMS of the difference over the RMS of the variation,
/// or over a share of the mean where this is larger. `ratio` is that of the time over which errors count to that of the
/// signals. An error that grows as tᵖ over the signals, as the phase error of a mode does with p = 1, grows to ratioᵖ times its
/// size.
fn differences(found: &Record, exact: &Record, ratio: f64) -> [f64; 2] {
    let samples = found.time.len().min(exact.time.len());
    let worst = |found: &[f64], exact_signals: &[f64], lanes: usize| {
        let channels = exact_signals.len() / exact.time.len().max(1);
        let errors = (0..channels / lanes).map(|signal| {
            let sums = (signal * lanes..(signal + 1) * lanes)
                .map(|channel| Squares::new(&found[channel..], &exact_signals[channel..], channels, samples));
            sums.fold(Squares::default(), Squares::with).error(ratio)
        });
        errors.fold(0.0, f64::max)
    };
    let ([_, force, ..], [_, exact_force, ..]) = (&found.mesh, &exact.mesh);
    [worst(&found.displacement, &exact.displacement, 2), worst(force, exact_force, 1)]
}

/// Sums of squares over the samples of a signal.
#[derive(Clone, Copy, Default)]
struct Squares {
    /// Of the difference in the first half of the samples, and in the second half.
    differences: [f64; 2],
    /// Of the exact values about their mean.
    variation: f64,
    /// Of the means.
    mean: f64,
}

impl Squares {
    /// The sums of the first of `channels` interleaved channels.
    fn new(found: &[f64], exact: &[f64], channels: usize, samples: usize) -> Self {
        let values = |all: &'_ [f64]| all.iter().copied().step_by(channels).take(samples).collect::<Vec<f64>>();
        let (found, exact) = (values(found), values(exact));
        let mean = exact.iter().sum::<f64>() / samples as f64;
        let mut sums = Self { mean: mean * mean * samples as f64, ..Self::default() };
        for (index, (found, exact)) in found.iter().zip(&exact).enumerate() {
            sums.differences[usize::from(2 * index >= samples)] += (found - exact).powi(2);
            sums.variation += (exact - mean).powi(2);
        }
        sums
    }

    /// The sums of two components of a vector.
    fn with(self, other: Self) -> Self {
        let [first, second] = self.differences;
        Self {
            differences: [first + other.differences[0], second + other.differences[1]],
            variation: self.variation + other.variation,
            mean: self.mean + other.mean,
        }
    }

    /// The relative error over `ratio` times the time of the samples.
    fn error(self, ratio: f64) -> f64 {
        let [first, second] = self.differences;
        if first + second == 0.0 {
            return 0.0;
        }
        // The squares of an error that grows as tᵖ add up to t²ᵖ⁺¹: the halves have the ratio 2²ᵖ⁺¹ − 1.
        let power = (((second / first + 1.0).log2() - 1.0) / 2.0).clamp(0.0, 1.0);
        let unit = self.variation.max(SHARE_OF_MEAN * SHARE_OF_MEAN * self.mean);
        ((first + second) / unit).sqrt() * ratio.powf(power)
    }
}

#[cfg(test)]
mod tests {
    use super::Squares;

    #[test]
    fn growing_errors_are_extrapolated() {
        let exact: Vec<f64> = (0..4000_i32).map(|k| (f64::from(k) * 0.7).sin()).collect();
        for (power, factor) in [(0_i32, 1.0_f64), (1, 3.0)] {
            let found: Vec<f64> =
                exact.iter().enumerate().map(|(k, x)| x + 1e-3 * (k as f64 / 4000.0).powi(power)).collect();
            let sums = Squares::new(&found, &exact, 1, exact.len());
            // The samples at equal intervals differ from the integral by 1/4000.
            assert!((sums.error(3.0) / sums.error(1.0) - factor).abs() < 2e-3 * factor, "{power}");
        }
    }
}
