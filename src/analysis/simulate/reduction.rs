//! Reduction of the linear motion to fewer modes, with a measured error.
//!
//! Large models are reduced twice. The modes of the components ([`Projected::of_components`]) give a subspace that the
//! accuracy of a run needs, without a large eigenvalue problem. In it, [`Directions`] finds those displacements that
//! carry the loads of this run to its recorded signals.
//!
//! The error is measured: a part of the run is integrated with the reduced and with the unreduced motion, and the
//! recorded signals are compared. This difference contains what the meshes feed back. The equilibrium and the
//! synchronous motion are those of the complete model.

use std::cell::OnceCell;
use std::rc::Rc;
use std::sync::Arc;

use nalgebra::DMatrix;

use super::component_subspace::{has_film, of_components};
use super::exponential::countable_grid;
use super::initial::Start;
use super::known_reduction::{KnownReduction, Reduction, excess, with_components};
use super::modal_setup::{ModalSetup, resumes};
use super::options::is_large;
use super::pilot::{PILOT_DURATION, Pilot, differences};
use super::ports::ports;
use super::ramp::reference_speed;
use super::record::Record;
use super::{RecordPlan, Run};
use crate::analysis::AnalysisError;
use crate::integrate::Observer;
use crate::modal::{Directions, LANES, Projected, StateMatrix};
use crate::motion::EquationOfMotion;
use crate::scene::SceneError;

/// Runs shorter than this multiple of a pilot run keep all modes, because two pilot runs cost more than they save.
const SHORT_RUN: f64 = 3.0;
/// The same for a small model ([`is_large`]) whose meshes separate and vary in stiffness. With all modes, its linear motion
/// contains the shafts alone, which are uncoupled, so that a reduction saves less: 5 to 20 % over 1 s.
const SHORT_SEPARATING_RUN: f64 = 10.0;
/// Largest part of all modes that a reduced model has; a larger one saves too little.
const LARGEST_PART: f64 = 0.75;
/// Number of modes up to which a choice among numbers of modes pays for all runs that are not short.
const FEW_MODES: f64 = 150.0;
/// Number of mode counts that are tried before the run keeps all modes.
const MAX_TRIALS: usize = 4;
/// Errors of displacements and mesh forces that determine the modes of the components without a given target.
const DEFAULT_TARGET: [f64; 2] = [3e-4, 3e-3];
/// Error of the mesh force for component modes up to the highest frequency that the teeth excite, in a train with sharp
/// engagement. It decreases with the square of the frequency limit, because the load of a tooth that engages is a step.
const COMPONENT_ERROR: f64 = 0.3;
/// Smallest frequency limit of the component modes, in multiples of the frequency that the teeth excite.
const SMALLEST_LIMIT: f64 = 4.0;
/// Ratio of successive frequency limits, and their number, until the error is below the target.
const NEXT_LIMIT: f64 = 1.6;
const MAX_LIMITS: usize = 4;
/// Ratio of the frequency limits of which the error is estimated.
const COARSER: f64 = 1.5;
/// Share of the remaining directions in the motion for the first tried number of modes, relative to the target.
const FIRST_SHARE: f64 = 0.1;
/// Largest errors, in multiples of the target, with which a continued run keeps its modes.
const CONTINUED: f64 = 3.0;

/// A set-up with its reduction.
pub(super) type Reduced<'m> = (ModalSetup<'m>, KnownReduction);

/// Finds the reductions that the options of a run ask for, one for each share of the permitted errors that the number of
/// modes may cause; none if the modes are nearly parallel.
pub(super) fn find<'m>(
    run: &Run<'m>,
    motion: &EquationOfMotion<'m>,
    start: &Start,
    plan: &RecordPlan,
    shares: &[f64],
    observer: &mut impl Observer,
) -> Result<Vec<Reduced<'m>>, AnalysisError> {
    let Some(mut reducer) = Reducer::new(run, motion, start, plan, observer)? else {
        if run.options.modes.is_some() {
            let message = "cannot be left out: nearly parallel modes do not carry the motion";
            return Err(SceneError::new("modes", message).into());
        }
        return Ok(Vec::new());
    };
    let chooses = !is_short(run, start, motion) && reducer.choice_pays();
    shares.iter().map(|share| reducer.reduction(chooses.then_some(*share), observer)).collect()
}

/// Whether a run is too short for a choice among numbers of modes; a continued run keeps those of the run before it.
pub(super) fn is_short(run: &Run<'_>, start: &Start, motion: &EquationOfMotion<'_>) -> bool {
    let model = &run.cached.model;
    let separates = !is_large(model) && motion.varying_flanks_can_separate();
    let shortest = if separates { SHORT_SEPARATING_RUN } else { SHORT_RUN };
    run.options.duration < shortest * PILOT_DURATION && !start.is_reduced(model)
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
        let selection = plan.selection(&self.cached.model);
        ModalSetup::new(self.cached, self.options, motion, start, selection, subspace)
    }

    /// The set-up with the modes of the components, or all modes, of a known reduction, and that with its reduced motion if
    /// this differs.
    pub(super) fn with_reduction(
        &self,
        known: &KnownReduction,
        motion: EquationOfMotion<'m>,
        start: &Start,
        plan: &RecordPlan,
    ) -> Result<(ModalSetup<'m>, Option<ModalSetup<'m>>), AnalysisError> {
        let unreduced = self.complete(motion, start, plan, Some(&known.projected))?;
        let model = &self.cached.model;
        let is_reduced = !Arc::ptr_eq(&unreduced.linear, &known.linear);
        let reduced =
            is_reduced.then(|| unreduced.with_linear(model, Arc::clone(&known.linear), plan.selection(model)));
        Ok((unreduced, reduced))
    }
}

/// What a reduction needs.
struct Reducer<'a, 'm> {
    run: &'a Run<'m>,
    start: &'a Start,
    plan: &'a RecordPlan,
    /// The part of the run with which models are compared.
    pilot: Rc<Pilot>,
    /// The linear motion of the complete model, or of the modes of its components.
    projected: Arc<Projected>,
    /// The set-up of a run with this linear motion.
    unreduced: ModalSetup<'m>,
    /// The signals of this run.
    exact: Record,
    /// Errors of displacements and mesh forces from the modes of the components; `None` for the complete model.
    components: Option<[f64; 2]>,
    /// Directions of the displacements in the order of their importance; found at the first use.
    directions: OnceCell<Directions>,
}

impl<'a, 'm> Reducer<'a, 'm> {
    /// Prepares the reduction of a run; `None` if the modes are nearly parallel.
    fn new(
        run: &'a Run<'m>,
        motion: &EquationOfMotion<'m>,
        start: &'a Start,
        plan: &'a RecordPlan,
        observer: &mut impl Observer,
    ) -> Result<Option<Self>, AnalysisError> {
        let (options, model) = (run.options, &run.cached.model);
        let target = options.reduction.unwrap_or(DEFAULT_TARGET);
        let decides = options.modes.is_some() || !is_short(run, start, motion);
        let pilot = Rc::new(Pilot::new(run, start, decides));
        let prepared = |limit: f64| Self::prepared(run, motion, (start, &pilot), plan, limit);
        if !is_large(model) {
            let Some(mut reducer) = prepared(0.0)? else {
                return Ok(None);
            };
            reducer.exact = reducer.signals(&reducer.unreduced, observer)?;
            return Ok(Some(reducer));
        }
        let first = (COMPONENT_ERROR / target[1]).sqrt().max(SMALLEST_LIMIT);
        let limits = || std::iter::successors(Some(first), |limit| Some(limit * NEXT_LIMIT)).take(MAX_LIMITS);
        // A continued run uses the component modes of the run before it, so that it continues bit by bit.
        if start.is_reduced(model) {
            for limit in limits() {
                let Some(mut reducer) = prepared(limit)? else {
                    return Ok(None);
                };
                if reducer.resumes()? {
                    reducer.measure_components(motion, limit, observer)?;
                    return Ok(Some(reducer));
                }
            }
        }
        let mut last = None;
        for limit in limits() {
            let Some(mut reducer) = prepared(limit)? else {
                return Ok(None);
            };
            reducer.measure_components(motion, limit, observer)?;
            let is_accurate = reducer.excess([0.0; 2], target) <= 1.0;
            let is_complete = reducer.unreduced.linear.modes as f64 >= LARGEST_PART * model.len() as f64;
            last = Some(reducer);
            if is_accurate || is_complete || is_short(run, start, motion) {
                break;
            }
        }
        Ok(last)
    }

    /// The linear motion and its directions; `limit` is the frequency limit of the component modes of a large model, in
    /// multiples of the frequency that the teeth excite.
    fn prepared(
        run: &'a Run<'m>,
        motion: &EquationOfMotion<'m>,
        (start, pilot): (&'a Start, &Rc<Pilot>),
        plan: &'a RecordPlan,
        limit: f64,
    ) -> Result<Option<Self>, AnalysisError> {
        let projected = if limit > 0.0 {
            of_components(run, motion, plan, limit)?
        } else {
            Arc::new(run.cached.at_speed(run.options.fastest())?.projected(reference_speed(run.options))?)
        };
        let unreduced = run.complete(motion.clone(), start, plan, Some(&projected))?;
        if matches!(unreduced.linear.matrix, StateMatrix::Dense(_)) {
            return Ok(None);
        }
        // A run that cannot be counted ends before its pilot.
        countable_grid(run.cached, run.options, &unreduced.linear, &unreduced.loads, run.end)?;
        Ok(Some(Self {
            run,
            start,
            plan,
            pilot: Rc::clone(pilot),
            projected,
            unreduced,
            exact: Record::default(),
            components: None,
            directions: OnceCell::new(),
        }))
    }

    /// The signals of a pilot run with a set-up.
    fn signals(&self, setup: &ModalSetup<'m>, observer: &mut impl Observer) -> Result<Record, AnalysisError> {
        self.pilot.signals(self.run, setup, self.plan, observer)
    }

    /// Whether this run continues bit by bit a run with the same component modes.
    fn resumes(&self) -> Result<bool, AnalysisError> {
        let count = self.start.state.modal.len() / 2;
        let setup = if count < self.unreduced.linear.slots { self.reduced(count)? } else { self.unreduced.clone() };
        Ok(resumes(&setup.linear, &setup.loads, self.start))
    }

    /// Runs a pilot, and estimates the error e of the component modes up to `limit` from the difference to another limit. The
    /// errors c²e of the limit divided by c and e of the limit differ by (c² − 1)e.
    ///
    /// With an oil film, the error hardly decreases until the modes resolve the motion at the film, and then falls within a
    /// small range of the limit: a lower limit says little about it. The difference to a higher limit contains it; for an
    /// error of e/c² there, the two differ by (1 − 1/c²)e.
    fn measure_components(
        &mut self,
        motion: &EquationOfMotion<'m>,
        limit: f64,
        observer: &mut impl Observer,
    ) -> Result<(), AnalysisError> {
        self.exact = self.signals(&self.unreduced, observer)?;
        let model = &self.run.cached.model;
        let other = |limit: f64| of_components(self.run, motion, self.plan, limit);
        let (found, decrease) = if has_film(model) {
            // The maps of a larger subspace do not follow from those of this one.
            let fine = other(limit * NEXT_LIMIT)?;
            let fine = self.run.complete(motion.clone(), self.start, self.plan, Some(&fine))?;
            (differences(&self.exact, &self.signals(&fine, observer)?), 1.0 - NEXT_LIMIT.powi(-2))
        } else {
            let coarse = other(limit / COARSER)?.state_space()?;
            let coarse = self.unreduced.with_linear(model, coarse, self.plan.selection(model));
            (differences(&self.signals(&coarse, observer)?, &self.exact), COARSER * COARSER - 1.0)
        };
        self.components = Some(found.map(|difference| difference / decrease));
        Ok(())
    }

    /// The reduction that the options ask for. A chosen number of modes may cause `share` of the permitted errors; none is
    /// chosen without a share.
    fn reduction(&mut self, share: Option<f64>, observer: &mut impl Observer) -> Result<Reduced<'m>, AnalysisError> {
        let options = self.run.options;
        let (setup, reduction) = match (options.modes, options.reduction.zip(share)) {
            (None, Some((target, share))) => self.choose(target.map(|error| share * error), observer)?,
            (None, None) => self.without_choice(),
            (Some(count), _) => {
                let setup = self.reduced(count)?;
                let reduction = self.measured(&setup, observer)?;
                (setup, Some(reduction))
            }
        };
        let (projected, linear) = (Arc::clone(&self.projected), Arc::clone(&setup.linear));
        Ok((setup, KnownReduction { projected, linear, components: self.components, reduction }))
    }

    /// The run without a further reduction.
    fn without_choice(&self) -> (ModalSetup<'m>, Option<Reduction>) {
        let modes = self.unreduced.linear.modes;
        (self.unreduced.clone(), self.components.map(|errors| Reduction { modes, errors }))
    }

    /// The run with the smallest tried number of modes whose errors of displacements and mesh forces are at most
    /// `target`; without a further reduction if that saves little.
    fn choose(
        &mut self,
        target: [f64; 2],
        observer: &mut impl Observer,
    ) -> Result<(ModalSetup<'m>, Option<Reduction>), AnalysisError> {
        let null = self.projected.modes.null;
        let largest = (LARGEST_PART * self.unreduced.linear.modes as f64) as usize;
        // A continued run keeps the modes of the run before it, so that it continues bit by bit.
        let (mut count, mut allowed) = if self.start.is_reduced(&self.run.cached.model) {
            (self.start.state.modal.len() / 2, CONTINUED)
        } else {
            (self.directions()?.count(FIRST_SHARE * target[1]) + null, 1.0)
        };
        for _ in 0..MAX_TRIALS {
            count = count.next_multiple_of(LANES);
            if count > largest {
                break;
            }
            let setup = self.reduced(count)?;
            let reduction = self.measured(&setup, observer)?;
            let excess = self.excess(reduction.errors, target);
            if excess <= allowed {
                return Ok((setup, Some(reduction)));
            }
            allowed = 1.0;
            count = (count + 1).max(self.directions()?.further(count - null, excess) + null);
        }
        Ok(self.without_choice())
    }

    /// Whether a choice among numbers of modes saves more time than it takes: the eigenvalue problem of a choice takes a time
    /// in proportion to the third power of the number of modes, and a step in proportion to the number. A continued run
    /// keeps its choice.
    fn choice_pays(&self) -> bool {
        let growth = (self.unreduced.linear.modes as f64 / FEW_MODES).max(1.0).powi(2);
        self.run.options.duration >= SHORT_RUN * growth * PILOT_DURATION
            || self.start.is_reduced(&self.run.cached.model)
    }

    /// Largest ratio of the errors, with those from the modes of the components, to their target.
    fn excess(&self, errors: [f64; 2], target: [f64; 2]) -> f64 {
        excess(errors, self.components, target)
    }

    /// Directions of the displacements in the order of their importance.
    fn directions(&self) -> Result<&Directions, AnalysisError> {
        if let Some(known) = self.directions.get() {
            return Ok(known);
        }
        let (model, linear) = (&self.run.cached.model, &self.unreduced.linear);
        let ports = ports(model, &self.unreduced, &self.plan.selection(model));
        let growing = self.growing_shapes()?;
        let found = Directions::new(model, &self.projected, linear, &ports, PILOT_DURATION, &growing)?;
        Ok(self.directions.get_or_init(|| found))
    }

    /// Displacements of the growing modes, n × k, which every reduced model keeps: at the speed of the linear motion, and of a
    /// run at a changing speed at the largest speed too.
    fn growing_shapes(&self) -> Result<DMatrix<f64>, AnalysisError> {
        let (options, linear) = (self.run.options, &self.unreduced.linear);
        let (speed, fastest) = (reference_speed(options), options.fastest());
        let shapes = linear.growing_shapes(speed);
        let at_fastest = self.run.cached.at_speed(fastest)?;
        if speed == fastest || is_large(&at_fastest.model) || at_fastest.model.is_dissipative(fastest) {
            return Ok(shapes);
        }
        let further = at_fastest.linear(fastest)?.growing_shapes(fastest);
        let columns: Vec<_> = shapes.column_iter().chain(further.column_iter()).collect();
        Ok(if columns.is_empty() { shapes } else { DMatrix::from_columns(&columns) })
    }

    /// The set-up with `count` modes, rigid-body modes included, or with as many as the growing modes take.
    fn reduced(&self, count: usize) -> Result<ModalSetup<'m>, AnalysisError> {
        let model = &self.run.cached.model;
        if count >= self.unreduced.linear.modes {
            return Ok(self.unreduced.clone());
        }
        let directions = self.directions()?;
        let elastic = count.saturating_sub(self.projected.modes.null).max(directions.growing);
        let kept = directions.vectors.columns(0, elastic).into_owned();
        // The frequencies are those with the bearings at the largest speed.
        let at_fastest = self.run.cached.at_speed(self.run.options.fastest())?;
        let subspace = self.projected.restricted(&at_fastest.model, reference_speed(self.run.options), &kept)?;
        let linear = subspace.state_space()?;
        Ok(self.unreduced.with_linear(model, linear, self.plan.selection(model)))
    }

    /// A reduction with its errors.
    fn measured(&self, setup: &ModalSetup<'m>, observer: &mut impl Observer) -> Result<Reduction, AnalysisError> {
        let found = differences(&self.signals(setup, observer)?, &self.exact);
        Ok(Reduction { modes: setup.linear.modes, errors: with_components(found, self.components) })
    }
}
