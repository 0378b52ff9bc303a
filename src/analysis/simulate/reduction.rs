//! The modes that a run keeps ([`crate::modal::SubspaceKey`]), with a measured error.
//!
//! A part of the run is integrated with the modes up to L times the highest frequency that the teeth excite, and with
//! those up to 1.5 L, and the recorded signals are compared. This difference contains what the meshes feed back. The
//! equilibrium and the synchronous motion are those of the complete model.

use std::sync::Arc;

use num_complex::Complex64;

use super::exponential::countable_grid;
use super::initial::Start;
use super::modal_setup::{ModalSetup, resumes};
use super::options::is_large;
use super::pilot::Pilot;
use super::ramp::{linear_model, reference_speed};
use super::record::Record;
use super::{Initial, Options, RecordPlan, Run};
use crate::analysis::AnalysisError;
use crate::connection::{Connection, Row};
use crate::exponential::Selection;
use crate::integrate::Observer;
use crate::modal::{Extent, MIN_BANDED, Projected, StateMatrix, SubspaceKey};
use crate::model::{Excitation, Model};
use crate::motion::{EquationOfMotion, Speed};
use crate::scene::{COMPARED_DURATION, SceneError};

/// Runs shorter than this multiple of a pilot run compare models over a shorter part, because pilot runs take as long as
/// they save.
const SHORT_RUN_FACTOR: f64 = 3.0;
/// Largest part of all modes that a run keeps before it keeps all; a larger one saves too little.
const MAX_KEPT_PART: f64 = 0.75;
/// Errors of displacements and mesh forces of the reference for a given number of modes.
const DEFAULT_TARGET: [f64; 2] = [3e-4, 3e-3];
/// Error of the mesh force for L = 1 in a train with sharp engagement, from the scenes of `benches/reduction.py` at L = 6 to
/// 9: 0.09 to 0.15. It decreases with 1/L², because the load of a tooth that engages is a step.
const ERROR_OF_TEETH: f64 = 0.12;
/// Ratio of the errors of displacements and of mesh forces: 0.02 to 0.13 in these scenes.
const DISPLACEMENT_PART: f64 = 0.1;
/// Runs shorter than this, s, take the expected error: comparisons would take longer than the run, and so few tooth periods
/// say little about the error.
const SHORTEST_COMPARED: f64 = 0.01;
/// Smallest L: kept modes reach up to L times the highest tooth frequency.
const MIN_LIMIT: f64 = 2.0;
/// Ratio of successive L until the error is below the target.
const LIMIT_RATIO: f64 = 1.5;
/// Largest number of L that are tried.
const MAX_LIMITS: usize = 6;

/// Largest number of recorded coordinates whose static displacement under a load is kept.
const MAX_RECORDED: usize = 128;
/// Harmonics of the tooth meshing frequency, or of the rotation without teeth, that count as excited.
const EXCITED_HARMONICS: f64 = 10.0;

/// A reduction of the linear motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reduction {
    /// Number of modes that the run keeps.
    pub modes: usize,
    /// Estimated error of displacements and of mesh forces: RMS of the difference to all modes over RMS of the
    /// variation, at least 2 % of the mean, for the worst recorded signal.
    pub errors: [f64; 2],
}

/// What the reduction of a run reads beside its model.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ReductionKey {
    /// Options of the run, without output times.
    pub options: Options,
    /// The recorded quantities.
    pub plan: RecordPlan,
    /// Whether the run may take the reduction of the system of which its model is a variation.
    pub takes_base: bool,
}

impl ReductionKey {
    /// The key of a run that records `plan`; `None` for a run that continues another one, whose state decides on the modes
    /// too.
    pub fn new(run: &Run<'_>, plan: &RecordPlan) -> Option<Self> {
        let options = run.options;
        if options.checkpoint.is_some() || matches!(options.initial, Initial::Continue(_)) {
            return None;
        }
        let options = Options { times: Vec::new(), ..options.clone() };
        Some(Self { options, plan: plan.clone(), takes_base: run.base.is_some() })
    }
}

/// A reduction that a run with the same key found.
#[derive(Clone, Debug)]
pub(super) struct KnownReduction {
    /// The linear motion in the modes that the run keeps.
    pub projected: Arc<Projected>,
    /// L, whose multiple of the highest frequency that teeth excite limits the modes; none for a given number.
    pub limit: Option<f64>,
    pub reduction: Reduction,
}

/// A set-up with its reduction.
pub(super) type Reduced<'m> = (ModalSetup<'m>, KnownReduction);

/// Whether a run keeps all modes without a comparison.
pub(super) fn keeps_all(run: &Run<'_>, plan: &RecordPlan, start: &Start) -> bool {
    let (options, model) = (run.options, &run.cached.model);
    match (options.modes, options.reduction) {
        (Some(count), _) => count >= model.len(),
        (None, Some(_)) => {
            // Two smaller eigenvalue problems take as long as that of all modes of a small model. Without meshes, a run is compared with
            // all modes.
            let is_cheap = model.len() <= MIN_BANDED || model.meshes.is_empty() && !is_large(model);
            plan.energy || is_short(run) && is_cheap && !start.is_reduced(model)
        }
        (None, None) => true,
    }
}

/// Whether a pilot run only measures the error.
fn is_short(run: &Run<'_>) -> bool {
    run.options.duration < SHORT_RUN_FACTOR * COMPARED_DURATION
}

impl<'m> Run<'m> {
    /// The set-up of the run in a subspace, or with the complete model.
    pub(super) fn complete(
        &self,
        motion: EquationOfMotion<'m>,
        start: &Start,
        plan: &RecordPlan,
        subspace: Option<&Projected>,
    ) -> Result<ModalSetup<'m>, AnalysisError> {
        let combinations = plan.combinations(&motion);
        let selection = Selection { combinations, ..plan.selection(&self.cached.model) };
        ModalSetup::new(self.cached, self.options, motion, start, selection, subspace)
    }
}

/// What the choice of modes needs.
pub(super) struct Reducer<'a, 'm> {
    pub run: &'a Run<'m>,
    pub motion: &'a EquationOfMotion<'m>,
    pub start: &'a Start,
    pub plan: &'a RecordPlan,
}

/// A set-up with its modes and the signals of its pilot run.
struct Candidate<'m> {
    setup: ModalSetup<'m>,
    projected: Arc<Projected>,
    signals: Record,
}

impl<'m> Reducer<'_, 'm> {
    /// Finds the modes that the options of the run ask for; none if the run keeps all modes. `base` is the reduction of the
    /// system of which the model of the run is a variation.
    pub fn find(
        &self,
        base: Option<&KnownReduction>,
        observer: &mut impl Observer,
    ) -> Result<Option<Reduced<'m>>, AnalysisError> {
        let Some(count) = self.run.options.modes else {
            return self.of_accuracy(base, observer);
        };
        let found = self.of_count(count, observer)?;
        found.map(Some).ok_or_else(|| {
            SceneError::new("modes", "cannot be left out: nearly parallel modes do not carry the motion").into()
        })
    }

    /// A given number of modes, compared with all modes, or those of twice the frequencies that the default accuracy needs.
    fn of_count(&self, count: usize, observer: &mut impl Observer) -> Result<Option<Reduced<'m>>, AnalysisError> {
        let limit = 2.0 * first_limit(DEFAULT_TARGET);
        let pilot = Pilot::new(self.run, self.start);
        let Some(reference) = self.candidate(None, limit, &pilot, observer)? else {
            return Ok(None);
        };
        let found = if count >= reference.setup.linear.modes {
            None
        } else {
            self.candidate(Some(Extent::Count(count)), limit, &pilot, observer)?
        };
        let Some(found) = found else {
            return Ok(Some(reference.with_errors(None, [0.0; 2])));
        };
        let errors = pilot.errors(&found.signals, &reference.signals);
        Ok(Some(found.with_errors(None, errors)))
    }

    /// The modes that keep the error of the options.
    fn of_accuracy(
        &self,
        base: Option<&KnownReduction>,
        observer: &mut impl Observer,
    ) -> Result<Option<Reduced<'m>>, AnalysisError> {
        let target = self.run.options.reduction.unwrap_or(DEFAULT_TARGET);
        let pilot = match base {
            Some(_) => Pilot::check(self.run, self.start),
            None => Pilot::new(self.run, self.start),
        };
        let first = base.and_then(|base| base.limit).unwrap_or_else(|| first_limit(target));
        let limits = || std::iter::successors(Some(first), |limit| Some(limit * LIMIT_RATIO)).take(MAX_LIMITS);
        // A continued run keeps the modes of the run before it, so that it continues bit by bit.
        let mut continued = None;
        if self.start.is_reduced(&self.run.cached.model) {
            for limit in limits() {
                let Some((setup, _)) = self.set_up(Some(Extent::Limit(limit)), limit)? else {
                    return Ok(None);
                };
                if resumes(&setup.linear, &setup.loads, self.start) {
                    continued = Some(limit);
                    break;
                }
            }
        }
        let mut limit = continued.unwrap_or(first);
        let has_meshes = !self.run.cached.model.meshes.is_empty();
        if self.run.options.duration < SHORTEST_COMPARED && has_meshes {
            let Some((setup, projected)) = self.set_up(Some(Extent::Limit(limit)), limit)? else {
                return Ok(None);
            };
            let force = ERROR_OF_TEETH / (limit * limit);
            let found = Candidate { setup, projected, signals: Record::default() };
            let is_kept = continued.is_some() || !self.saves_little(&found.setup);
            return Ok(is_kept.then(|| found.with_errors(Some(limit), [DISPLACEMENT_PART * force, force])));
        }
        // Without teeth there is no law for the error of L, and few modes may lie between L and 1.5 L: the comparison is with all
        // modes, of a large model with those up to an L that is not tried.
        let mut all = None;
        let largest = limit * LIMIT_RATIO.powi(MAX_LIMITS as i32);
        if !has_meshes {
            let Some(found) = self.candidate(None, largest, &pilot, observer)? else {
                return Ok(None);
            };
            all = Some(found);
        }
        let (mut coarse, mut left): (Option<Candidate<'m>>, [f64; 2]) = (None, [0.0; 2]);
        for _ in 1..MAX_LIMITS {
            let current = match coarse.take() {
                Some(known) => known,
                None => {
                    let Some((setup, projected)) = self.set_up(Some(Extent::Limit(limit)), limit)? else {
                        return Ok(None);
                    };
                    if continued.is_none() && self.saves_little(&setup) {
                        return Ok(None);
                    }
                    let signals = pilot.signals(self.run, &setup, self.plan, observer)?;
                    Candidate { setup, projected, signals }
                }
            };
            let next = limit * LIMIT_RATIO;
            if let Some(all) = &all {
                let errors = pilot.errors(&current.signals, &all.signals);
                if continued.is_some() || excess(errors, target) <= 1.0 {
                    return Ok(Some(current.with_errors(Some(limit), errors)));
                }
                (limit, left) = (next, errors);
                continue;
            }
            let Some(fine) = self.candidate(Some(Extent::Limit(next)), next, &pilot, observer)? else {
                return Ok(None);
            };
            // The errors e of L and e/1.5² of 1.5 L differ by (1 − 1/1.5²) e.
            let decrease = LIMIT_RATIO.powi(-2);
            let errors = pilot.errors(&current.signals, &fine.signals).map(|found| found / (1.0 - decrease));
            if continued.is_some() || excess(errors, target) <= 1.0 {
                return Ok(Some(current.with_errors(Some(limit), errors)));
            }
            if excess(errors.map(|error| error * decrease), target) <= 1.0 {
                return Ok(if self.saves_little(&fine.setup) {
                    None
                } else {
                    Some(fine.with_errors(Some(next), errors.map(|error| error * decrease)))
                });
            }
            (coarse, limit) = (Some(fine), next);
            left = errors.map(|error| error * decrease);
        }
        // A small model keeps all modes. A large one keeps those that it has; a warning tells their error.
        let model = &self.run.cached.model;
        if let Some(all) = all {
            let left = left.map(|error| error * LIMIT_RATIO.powi(-2));
            let is_kept = is_large(model) && !self.saves_little(&all.setup) && excess(left, target) <= 1.0;
            return Ok(is_kept.then(|| all.with_errors(Some(largest), left)));
        }
        Ok(coarse.filter(|_| is_large(model)).map(|last| last.with_errors(Some(limit), left)))
    }

    /// Whether the complete model has hardly more modes.
    fn saves_little(&self, setup: &ModalSetup<'m>) -> bool {
        setup.linear.modes as f64 > MAX_KEPT_PART * self.run.cached.model.len() as f64
    }

    /// A set-up with the signals of its pilot run; none if the modes are nearly parallel.
    fn candidate(
        &self,
        extent: Option<Extent>,
        limit: f64,
        pilot: &Pilot,
        observer: &mut impl Observer,
    ) -> Result<Option<Candidate<'m>>, AnalysisError> {
        let Some((setup, projected)) = self.set_up(extent, limit)? else {
            return Ok(None);
        };
        let signals = pilot.signals(self.run, &setup, self.plan, observer)?;
        Ok(Some(Candidate { setup, projected, signals }))
    }

    /// The set-up with some modes, of a large model among those up to L = `limit`; none if the modes are nearly parallel.
    fn set_up(
        &self,
        extent: Option<Extent>,
        limit: f64,
    ) -> Result<Option<(ModalSetup<'m>, Arc<Projected>)>, AnalysisError> {
        let Self { run, motion, start, plan } = *self;
        let (options, model) = (run.options, &run.cached.model);
        let (fastest, speed) = (options.fastest(), reference_speed(options));
        let excited = excited_frequency(model, fastest);
        // At a changing speed, the subspace contains the bearings at the largest speed, and carries their differences.
        let linear_model = linear_model(run.cached, options)?;
        let projected = linear_model.subspace(SubspaceKey {
            speeds: if speed == fastest { vec![speed] } else { vec![speed, fastest] },
            excited,
            rotation: model.max_speed_ratio() * fastest.abs(),
            highest: is_large(model).then_some(limit * excited),
            interfaces: lines_of_action(&linear_model.model, fastest),
            coordinates: coordinate_loads(&linear_model.model, fastest, &plan.selection(model)),
            // At a constant speed they act at the start. With meshes, the forces of the teeth matter more.
            distributed: if matches!(options.speed, Speed::Changing(_)) || is_large(model) && model.meshes.is_empty() {
                rotating_loads(&linear_model.model)
            } else {
                Vec::new()
            },
            extent,
        })?;
        let setup = run.complete(motion.clone(), start, plan, Some(&projected))?;
        if matches!(setup.linear.matrix, StateMatrix::Dense(_)) {
            return Ok(None);
        }
        // A run that cannot be counted ends before its pilot.
        countable_grid(run.cached, options, &setup.linear, &setup.loads, run.end)?;
        Ok(Some((setup, projected)))
    }
}

impl<'m> Candidate<'m> {
    /// The reduction with its errors of displacements and mesh forces.
    fn with_errors(self, limit: Option<f64>, errors: [f64; 2]) -> Reduced<'m> {
        let reduction = Reduction { modes: self.setup.linear.modes, errors };
        (self.setup, KnownReduction { projected: self.projected, limit, reduction })
    }
}

/// L whose error of mesh forces is about the target.
fn first_limit(target: [f64; 2]) -> f64 {
    (ERROR_OF_TEETH / target[1]).sqrt().max(MIN_LIMIT)
}

/// Largest ratio of the errors to their target.
fn excess(errors: [f64; 2], target: [f64; 2]) -> f64 {
    (errors[0] / target[0]).max(errors[1] / target[1])
}

/// Loads of local connections along their lines of action, as entries (index, coefficient); `speed` is that of the reference shaft,
/// rad/s.
fn lines_of_action(model: &Model, speed: f64) -> Vec<Row> {
    model.connections(speed).filter(Connection::is_local).flat_map(|connection| connection.rows()).collect()
}

/// Loads on the coordinates and seats of connections, bearings and links, and on recorded coordinates.
fn coordinate_loads(model: &Model, speed: f64, selection: &Selection) -> Vec<Row> {
    let recorded = &selection.displacements;
    let recorded = if recorded.len() <= MAX_RECORDED { &recorded[..] } else { &[] };
    model.coupled_loads(speed, recorded.iter().copied())
}

/// Loads of bows and of unbalances at two angles of each shaft, as entries (index, coefficient) over the displacements. At a
/// changing speed they act on the linear motion, which must carry them. Only their shape matters: they have the length 1, so
/// that variations of their size share a subspace.
fn rotating_loads(model: &Model) -> Vec<Row> {
    let parts = [Excitation::steady_amplitude, |excitation: &Excitation| excitation.unbalance];
    let mut loads = Vec::new();
    for (shaft, part) in model.shafts.iter().flat_map(|shaft| parts.map(|part| (shaft, part))) {
        let size = shaft.excitations.iter().map(|excitation| part(excitation).norm_sqr()).sum::<f64>().sqrt();
        for angle in [Complex64::ONE, Complex64::I] {
            let entries = shaft.excitations.iter().flat_map(|excitation| {
                let load = part(excitation) * angle / size;
                [(excitation.index, load.re), (excitation.index + 1, load.im)]
            });
            if size > 0.0 {
                loads.push(entries.collect());
            }
        }
    }
    loads
}

/// Highest angular frequency that is excited, rad/s: of the gears on their mesh stiffness, or of the harmonics of the tooth
/// meshing frequency or of the rotation.
fn excited_frequency(model: &Model, speed: f64) -> f64 {
    let order = model.max_mesh_order().max(model.max_speed_ratio());
    model.highest_mesh_frequency().max(EXCITED_HARMONICS * order * speed.abs())
}
