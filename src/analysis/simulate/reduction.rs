//! Reduction of the linear motion to fewer modes, with a measured error.

use std::sync::Arc;
use std::time::Instant;

use super::initial::Start;
use super::modal_setup::ModalSetup;
use super::record::{Record, Recorder};
use super::{HEARTBEAT, RecordPlan, Run, RunObserver, exponential, sample_step};
use crate::analysis::AnalysisError;
use crate::exponential::{InterfaceMaps, OutputMap, Selection};
use crate::integrate::{Halt, Observer, Statistics};
use crate::modal::{Directions, ModalStateSpace, Ports, Projected};
use crate::model::Model;
use crate::scene::{Node, SceneError};

/// Longest duration of a pilot run, s: the time over which errors are compared.
const PILOT_DURATION: f64 = 0.1;
/// Largest number of samples of a pilot run.
const MAX_SAMPLES: f64 = 4000.0;

/// A reduction of the linear motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reduction {
    /// Number of modes that the run keeps.
    pub modes: usize,
    /// Error of displacements, of mesh forces.
    pub errors: [f64; 2],
}

/// Reduces the set-up of a run as its options ask.
pub(super) fn reduced<'m>(
    run: &Run<'_>,
    complete: ModalSetup<'m>,
    start: &Start,
    plan: &RecordPlan,
    observer: &mut impl Observer,
) -> Result<(ModalSetup<'m>, Option<Reduction>), AnalysisError> {
    let Some(count) = run.options.modes else {
        return Ok((complete, None));
    };
    let model = &run.cached.model;
    let speed = run.options.fastest();
    let projected = Projected::complete(run.cached, speed)?;
    let selection = plan.selection(model);
    let ports = ports(model, &complete, &selection);
    let t0 = Instant::now();
    let found = Directions::new(model, &projected, &complete.linear, &ports, PILOT_DURATION)?;
    if std::env::var("RED_T").is_ok() { eprintln!("directions {:?}", t0.elapsed()); }
    let Some(directions) = found else {
        let condition = complete.linear.condition;
        let message = format!("cannot be left out: they do not carry the motion, condition {condition:.1e}");
        return Err(SceneError::new("modes", message).into());
    };
    let elastic = count.saturating_sub(projected.modes.null).min(directions.vectors.ncols());
    let kept = directions.vectors.columns(0, elastic).into_owned();
    let t0 = Instant::now();
    let linear = projected.restricted(model, speed, &kept)?.state_space()?;
    let small = with_linear(model, &complete, linear, selection);
    if std::env::var("RED_T").is_ok() { eprintln!("restrict {:?}", t0.elapsed()); }
    let t0 = Instant::now();
    let exact = pilot(run, complete.clone(), start, plan, observer)?;
    if std::env::var("RED_T").is_ok() { eprintln!("pilot exact {:?}", t0.elapsed()); }
    let t0 = Instant::now();
    let found = pilot(run, small.clone(), start, plan, observer)?;
    if std::env::var("RED_T").is_ok() { eprintln!("pilot reduced {:?}", t0.elapsed()); }
    let errors = differences(&found, &exact);
    Ok((small, Some(Reduction { modes: count, errors })))
}

/// The set-up with a reduced linear motion.
fn with_linear<'m>(
    model: &Model,
    complete: &ModalSetup<'m>,
    linear: ModalStateSpace,
    selection: Selection,
) -> ModalSetup<'m> {
    let embedding = complete.linear.map_from(model, &linear);
    let restriction = linear.map_from(model, &complete.linear);
    let row = |row: &Vec<f64>| embedding.tr_mul(&nalgebra::DVector::from_column_slice(row)).as_slice().to_vec();
    let column = |column: &Vec<f64>| (&restriction * nalgebra::DVector::from_column_slice(column)).as_slice().to_vec();
    let maps = &complete.maps;
    let maps = InterfaceMaps {
        rows: maps.rows.iter().map(row).collect(),
        columns: maps.columns.iter().map(column).collect(),
        parts: linear.parts.clone(),
        ..maps.clone()
    };
    let nonlinear_loads = complete.nonlinear_loads.clone();
    let output = OutputMap::new(&nonlinear_loads, &linear, selection);
    ModalSetup { linear: Arc::new(linear), nonlinear_loads, maps, output }
}

/// What the reduced motion carries: mesh forces, recorded displacements, and the states in which a run can begin.
fn ports(model: &Model, setup: &ModalSetup<'_>, selection: &Selection) -> Ports {
    let ModalSetup { linear, nonlinear_loads, maps, .. } = setup;
    let along = |vectors: &[Vec<f64>], gradient: &[f64]| {
        let mut sum = vec![0.0; linear.len()];
        for (vector, factor) in vectors.iter().zip(gradient) {
            sum.iter_mut().zip(vector).for_each(|(sum, value)| *sum += factor * value);
        }
        sum
    };
    let mut ports = Ports::default();
    let across: f64 = std::env::var("RED_ACROSS").ok().and_then(|v| v.parse().ok()).unwrap_or(0.1);
    for tangent in &maps.tangents {
        ports.columns.push(along(&maps.columns[tangent.scalars.clone()], &tangent.gradient));
        ports.rows.push(vec![along(&maps.rows[tangent.scalars.clone()], &tangent.gradient)]);
    }
    for column in &maps.columns[..maps.meshes] {
        ports.columns.push(column.iter().map(|value| across * value).collect());
    }
    ports.columns.extend(maps.columns[maps.meshes..].iter().cloned());
    let recorded = |index: usize| selection.displacements.binary_search(&index).is_ok();
    let nodes = model.scene.shafts.iter().enumerate();
    for node in nodes.flat_map(|(shaft, given)| (0..given.nodes.len()).map(move |node| Node { shaft, node })) {
        if let Some(v) = model.numbering.translation(node).filter(|v| recorded(*v)) {
            ports.rows.push([v, v + 1].map(|index| linear.row(&[(index, 1.0)], false)).to_vec());
        }
        if let Some(twist) = model.numbering.twist(node).filter(|twist| recorded(*twist)) {
            ports.rows.push(vec![linear.row(&[(twist, 1.0)], false)]);
        }
    }
    let rest = vec![0.0; model.len()];
    ports.states.push(linear.state(model, nonlinear_loads.reference.as_slice(), &rest).as_slice().to_vec());
    for source in 0..nonlinear_loads.source_count() {
        for part in [|value: num_complex::Complex64| value.re, |value: num_complex::Complex64| value.im] {
            let values = |rate: bool| -> Vec<f64> {
                (0..model.len()).map(|index| part(nonlinear_loads.amplitude(source, index, rate))).collect()
            };
            ports.states.push(linear.state(model, &values(false), &values(true)).as_slice().to_vec());
        }
    }
    ports
}

/// The first part of a run, sampled at equal intervals.
fn pilot(
    run: &Run<'_>,
    setup: ModalSetup<'_>,
    start: &Start,
    plan: &RecordPlan,
    observer: &mut impl Observer,
) -> Result<Record, AnalysisError> {
    let (options, model) = (run.options, &run.cached.model);
    let origin = start.course.origin;
    let duration = options.duration.min(PILOT_DURATION);
    let intervals = (duration / sample_step(model, options.fastest())).ceil().clamp(20.0, MAX_SAMPLES);
    let times: Vec<f64> =
        (1..=intervals as usize).map(|index| options.start + duration * index as f64 / intervals).collect();
    let begin = options.start - origin;
    let end = begin + duration;
    let plan = RecordPlan { energy: false, ..plan.clone() };
    let mut pilot = RunObserver {
        recorder: Recorder::new(setup.nonlinear_loads.motion.clone(), &plan, &times, origin, begin),
        watch: &mut |_| observer.go_on(begin),
        span: (begin, end),
        last_check: Instant::now() - HEARTBEAT,
    };
    let (_, outcome) =
        exponential::run(run.cached, options, setup, start, end, &mut pilot, &mut Statistics::new())?;
    if outcome.is_err_and(|halted| matches!(halted.halt, Halt::Interrupted)) {
        return Err(AnalysisError::Interrupted);
    }
    Ok(pilot.recorder.finish().0)
}

/// RMS of the difference over the RMS of the variation, of displacements and of mesh forces, for the worst signal.
fn differences(found: &Record, exact: &Record) -> [f64; 2] {
    let samples = found.time.len().min(exact.time.len());
    let worst = |found: &[f64], exact: &[f64], width: usize| {
        let channels = exact.len() / exact_len(exact, samples, width);
        (0..channels / width)
            .map(|signal| {
                let values = |all: &[f64], lane: usize| -> Vec<f64> {
                    (0..samples).map(|sample| all[sample * channels + signal * width + lane]).collect()
                };
                let (mut difference, mut variation, mut size) = (0.0, 0.0, 0.0);
                for lane in 0..width {
                    let (found, exact) = (values(found, lane), values(exact, lane));
                    let mean = exact.iter().sum::<f64>() / samples as f64;
                    for (a, b) in found.iter().zip(&exact) {
                        difference += (a - b) * (a - b);
                        variation += (b - mean) * (b - mean);
                        size += b * b;
                    }
                }
                if difference > 0.0 { (difference / variation.max(1e-18 * size)).sqrt() } else { 0.0 }
            })
            .fold(0.0, f64::max)
    };
    let [_, force, ..] = &exact.mesh;
    [worst(&found.displacement, &exact.displacement, 2), worst(&found.mesh[1], force, 1)]
}

fn exact_len(all: &[f64], samples: usize, width: usize) -> usize {
    if all.is_empty() { 1 } else { samples.max(width.min(1)).max(1) }
}
