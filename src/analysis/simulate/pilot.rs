//! Pilot runs: the first part of a run, with which models of different size are compared.

use std::time::Instant;

use super::initial::Start;
use super::modal_setup::ModalSetup;
use super::record::{Record, Recorder};
use super::{RecordPlan, Run, RunObserver, exponential, sample_step};
use crate::analysis::AnalysisError;
use crate::integrate::{Halt, Observer, Statistics};

/// Longest duration of a pilot run, s: the time over which errors are compared.
pub(super) const PILOT_DURATION: f64 = 0.1;
/// Smallest and largest number of samples of a pilot run.
const PILOT_SAMPLES: [f64; 2] = [200.0, 4000.0];
/// Variation of a signal, relative to its size, below which it is round-off.
const ROUND_OFF: f64 = 1e-9;

/// The signals of the first part of a run, sampled at equal intervals; empty for a run without duration.
pub(super) fn pilot(
    run: &Run<'_>,
    setup: &ModalSetup<'_>,
    start: &Start,
    plan: &RecordPlan,
    observer: &mut impl Observer,
) -> Result<Record, AnalysisError> {
    let Run { cached, options, .. } = *run;
    if options.duration <= 0.0 {
        return Ok(Record::default());
    }
    let origin = start.rotation.origin;
    let duration = options.duration.min(PILOT_DURATION);
    let [least, most] = PILOT_SAMPLES;
    let intervals = (duration / sample_step(&cached.model, options.fastest())).ceil().clamp(least, most);
    let times: Vec<f64> =
        (1..=intervals as usize).map(|index| options.start + duration * index as f64 / intervals).collect();
    let begin = options.start - origin;
    let plan = RecordPlan { energy: false, ..plan.clone() };
    let mut pilot = RunObserver {
        recorder: Recorder::new(setup.nonlinear_loads.motion.clone(), &plan, &times, origin, (begin, 0.0)),
        watch: &mut |_| observer.continues(begin),
        span: (begin, begin + duration),
        last_check: Instant::now(),
    };
    let end = begin + duration;
    let mut counts = Statistics::new();
    let (_, outcome) = exponential::run(cached, options, setup.clone(), start, end, &mut pilot, &mut counts)?;
    if outcome.is_err_and(|halted| matches!(halted.halt, Halt::Interrupted)) {
        return Err(AnalysisError::Interrupted);
    }
    Ok(pilot.recorder.finish().0)
}

/// RMS of the difference over RMS of the variation, of displacements and of mesh forces, for the worst signal.
pub(super) fn differences(found: &Record, exact: &Record) -> [f64; 2] {
    let samples = found.time.len().min(exact.time.len());
    let worst = |found: &[f64], exact_signals: &[f64], lanes: usize| {
        let channels = exact_signals.len() / exact.time.len().max(1);
        let errors = (0..channels / lanes).map(|signal| {
            let sums = (signal * lanes..(signal + 1) * lanes)
                .map(|channel| squares(&found[channel..], &exact_signals[channel..], channels, samples));
            let [difference, variation, size] =
                sums.fold([0.0; 3], |sum, own| std::array::from_fn(|index| sum[index] + own[index]));
            let variation = variation.max(ROUND_OFF * ROUND_OFF * size);
            if difference > 0.0 { (difference / variation).sqrt() } else { 0.0 }
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
