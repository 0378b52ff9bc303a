//! Pilot runs: a part of a run, with which models of different size are compared.
//!
//! It is the first part at a constant speed. At a changing speed it is the part around the largest speed, where the teeth
//! excite the highest frequencies.

use std::time::Instant;

use super::initial::Start;
use super::modal_setup::ModalSetup;
use super::record::{Record, Recorder};
use super::{RecordPlan, Run, RunObserver, exponential, sample_step};
use crate::analysis::AnalysisError;
use crate::integrate::{Halt, Observer, SHARE_OF_MEAN, Statistics};

/// Longest duration of a pilot run, s: the time over which errors are compared.
pub(super) const PILOT_DURATION: f64 = 0.1;
/// Part of a run that a pilot run takes, and its shortest duration, s, where it decides on the number of modes.
const DECIDING: (f64, f64) = (1.0 / 3.0, 0.03);
/// The same where it only measures the error.
const MEASURING: (f64, f64) = (0.1, 0.01);
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
}

impl Pilot {
    /// Chooses the part of a run; `decides` says whether the number of modes follows from the pilot runs.
    pub fn new(run: &Run<'_>, start: &Start, decides: bool) -> Self {
        let (part, shortest) = if decides { DECIDING } else { MEASURING };
        Self::lasting(run, start, (part * run.options.duration).clamp(shortest, PILOT_DURATION))
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
            times: (1..=count).map(|index| first + duration * index as f64 / intervals).collect(),
        }
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
        let plan = RecordPlan { energy: false, velocity: false, acceleration: false, ..plan.clone() };
        let (motion, origin) = (setup.loads.motion.clone(), self.start.rotation.origin);
        let mut pilot = RunObserver {
            recorder: Recorder::new(motion, &plan, &self.times, origin, (begin, 0.0)),
            watch: &mut |_| observer.continues(run.options.start - origin),
            span: (begin, end),
            last_check: Instant::now(),
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
/// or over a share of the mean where this is larger.
pub(super) fn differences(found: &Record, exact: &Record) -> [f64; 2] {
    let samples = found.time.len().min(exact.time.len());
    let worst = |found: &[f64], exact_signals: &[f64], lanes: usize| {
        let channels = exact_signals.len() / exact.time.len().max(1);
        let errors = (0..channels / lanes).map(|signal| {
            let sums = (signal * lanes..(signal + 1) * lanes)
                .map(|channel| squares(&found[channel..], &exact_signals[channel..], channels, samples));
            let [difference, variation, size] =
                sums.fold([0.0; 3], |sum, own| std::array::from_fn(|index| sum[index] + own[index]));
            let square = variation.max(SHARE_OF_MEAN * SHARE_OF_MEAN * (size - variation));
            if difference > 0.0 { (difference / square).sqrt() } else { 0.0 }
        });
        errors.fold(0.0, f64::max)
    };
    let ([_, force, ..], [_, exact_force, ..]) = (&found.mesh, &exact.mesh);
    [worst(&found.displacement, &exact.displacement, 2), worst(force, exact_force, 1)]
}

/// Sums of squares of one channel: of the difference, of the variation about the mean, and of the values.
fn squares(found: &[f64], exact: &[f64], channels: usize, samples: usize) -> [f64; 3] {
    let values = |all: &'_ [f64]| all.iter().copied().step_by(channels).take(samples).collect::<Vec<f64>>();
    let (found, exact) = (values(found), values(exact));
    let mean = exact.iter().sum::<f64>() / samples as f64;
    let mut sums = [0.0; 3];
    for (found, exact) in found.iter().zip(&exact) {
        let terms = [found - exact, exact - mean, *exact];
        sums.iter_mut().zip(terms).for_each(|(sum, term)| *sum += term * term);
    }
    sums
}
