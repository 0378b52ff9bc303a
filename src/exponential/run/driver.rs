//! The loop over steps: step levels from the error estimate, and contact changes.

use super::contact_change::ExponentialEventLocator;
use super::level_control::{DOUBLING_FRACTION, LevelControl, level_for_error};
use crate::exponential::propagator::TimeGrid;
use crate::exponential::step::{Outcome, StepInstant, StepSpan, Stepper};
use crate::exponential::within_step::{CompletedStep, OutputMap, StepTrajectory, SubstepSampler};
use crate::integrate::{
    CHECK_INTERVAL, ExponentialState, FirstOrderSystem as _, ForceVariation, Halt, Halted, MAX_CHANGES_AT_ONE_TIME,
    MethodState, Observer, State, Statistics,
};
use crate::scene::SHARE_OF_MEAN;

/// Smallest reference of the tolerance, as a part of the energy norm of the motion. A mesh force that varies less is the
/// difference of larger numbers. The tolerance of the level "engineering", 1e-4, is then not below the 1e-7 of "reference".
const MIN_REFERENCE: f64 = 1e-3;

/// Integrates from `state` to `end` (elapsed time, s) and up to all instants for which the observer asks. `state.y` is a
/// state z in modal coordinates.
///
/// # Errors
/// [`Halted`]. `state` is then the last valid one.
pub fn run(
    stepper: &mut Stepper<'_>,
    output: &mut OutputMap,
    control: LevelControl,
    state: &mut State,
    end: f64,
    observer: &mut impl Observer,
    statistics: &mut Statistics,
) -> Result<(), Halted> {
    let mut driver = Driver::new(stepper, control, state);
    let outcome = driver.run(stepper, output, state, end, observer, statistics);
    output.evaluate_deferred(stepper.loads(), true, &mut |quantity| observer.deferred(quantity));
    state.method = MethodState::Exponential(driver.own);
    outcome.map_err(|halt| Halted { halt, elapsed: state.elapsed })
}

/// A step that meets the tolerance.
#[derive(Clone, Copy)]
struct AcceptedStep {
    level: usize,
    /// Error divided by the tolerance.
    error: f64,
}

struct Driver {
    time_grid: TimeGrid,
    control: LevelControl,
    /// Step level that the error asks for.
    level: usize,
    /// Energy norm that the tolerance of a step is relative to.
    size: f64,
    /// Contact changes in a row, each less than the shortest substep after the one before.
    changes_at_this_time: u32,
    /// What the method keeps between steps.
    own: ExponentialState,
    sampler: SubstepSampler,
    locator: ExponentialEventLocator,
}

impl Driver {
    fn new(stepper: &Stepper<'_>, control: LevelControl, state: &mut State) -> Self {
        let time_grid = stepper.context.cache.time_grid;
        let own = match std::mem::take(&mut state.method) {
            MethodState::Exponential(own)
                if own.time_base + time_grid.time(state.count) + own.since_unit == state.elapsed =>
            {
                own
            }
            // The state has another time grid. Units count from here.
            _ => {
                (state.count, state.next_step) = (0, 0.0);
                ExponentialState { time_base: state.elapsed, ..ExponentialState::default() }
            }
        };
        let level = if state.next_step > 0.0 { time_grid.level_of(state.next_step) } else { 0 };
        Self {
            time_grid,
            control,
            level,
            size: 0.0,
            changes_at_this_time: 0,
            own,
            sampler: SubstepSampler::new(stepper),
            locator: ExponentialEventLocator::new(stepper),
        }
    }

    fn run(
        &mut self,
        stepper: &mut Stepper<'_>,
        output: &mut OutputMap,
        state: &mut State,
        end: f64,
        observer: &mut impl Observer,
        statistics: &mut Statistics,
    ) -> Result<(), Halt> {
        self.start(stepper, output, state, observer, statistics)?;
        let switches = stepper.loads().motion.switching().is_some();
        let mut checks = 0;
        while state.elapsed < end || observer.next().is_some() {
            // A run does not stop between two changes at one unit, because their count is not part of the state.
            checks += u64::from(self.changes_at_this_time == 0);
            if self.changes_at_this_time == 0 && checks % CHECK_INTERVAL == 1 && !observer.continues(state.elapsed) {
                return Err(Halt::Interrupted);
            }
            let accepted = self.attempt(stepper, state, statistics)?;
            let units = self.units_to_grid(state.count, accepted.level);
            let locates = switches && self.changes_at_this_time < MAX_CHANGES_AT_ONE_TIME;
            let change = if locates { self.locate(stepper, accepted.level, state)? } else { None };
            let until = change.unwrap_or_else(|| self.time(state.count + units));
            let is_whole = change.is_none() && self.is_whole(units, accepted.level);
            if !is_whole && self.exceeds_tolerance(stepper, accepted.level, state, until, statistics)? {
                statistics.rejected += 1;
                self.level = accepted.level + 1;
                continue;
            }
            if observer.sees_every_step() || observer.next().is_some_and(|next| next <= until) {
                let step = completed(stepper, accepted.level, state);
                let mut trajectory = StepTrajectory { step, end: until, output, sampler: &mut self.sampler };
                observer.observe(&mut trajectory, until)?;
            }
            if until > end {
                break;
            }
            match change {
                Some(change) => {
                    self.report(stepper, output, accepted.level, state, change, observer);
                    self.switch(stepper, accepted.level, state, change, statistics)?;
                }
                None => self.advance(stepper, state, accepted, units, statistics)?,
            }
        }
        Ok(())
    }

    /// Evaluates the initial state and adopts its contact modes.
    fn start(
        &mut self,
        stepper: &mut Stepper<'_>,
        output: &mut OutputMap,
        state: &mut State,
        observer: &mut impl Observer,
        statistics: &mut Statistics,
    ) -> Result<(), Halt> {
        let mut evaluations = Statistics::new();
        if stepper.loads().motion.switching().is_some() {
            stepper.evaluate_begin(state.elapsed, &state.y, &mut evaluations)?;
            if state.contact_modes.is_empty() {
                let interface_state = &stepper.begin.interface_state;
                let loads = stepper.loads();
                loads.contact_modes(state.elapsed, interface_state, &[], &mut state.contact_modes)?;
            }
            stepper.context.loads.motion.set_contact_modes(&state.contact_modes);
        }
        stepper.evaluate_begin(state.elapsed, &state.y, &mut evaluations)?;
        if self.own.force_variations.len() != stepper.begin.contacts.len() {
            self.own.force_variations =
                stepper.begin.contacts.iter().map(|contact| ForceVariation::of(contact.force)).collect();
        }
        self.size = self.reference_size(stepper, stepper.size(&state.y, &stepper.begin));
        statistics.begin(evaluations.evaluations);
        let loads = stepper.loads();
        let mut read = |q: &mut [f64], v: &mut [f64]| output.read(loads, state.elapsed, &state.y, q, v);
        observer.switched(state.elapsed, &mut read, &state.contact_modes);
        Ok(())
    }

    /// Tries steps until one meets the tolerance.
    fn attempt(
        &mut self,
        stepper: &mut Stepper<'_>,
        state: &State,
        statistics: &mut Statistics,
    ) -> Result<AcceptedStep, Halt> {
        let begin = self.level.max(self.control.level_for_frequency(&self.time_grid, stepper.frequency_at_begin()));
        let begin = begin.max(self.time_grid.level_of(stepper.longest_step(state.elapsed)));
        let begin = begin.max(self.control.planned_level(&self.time_grid, state.count));
        let mut level = self.control.level_on_grid(&self.time_grid, state.count, begin);
        let mut rejected = false;
        loop {
            let next_level = match self.try_step(stepper, level, state, statistics)? {
                Outcome::Unsolved if level == self.time_grid.finest => return Err(Halt::Diverged),
                Outcome::Unsolved => level + 1,
                Outcome::Solved => {
                    let size = stepper.size(&stepper.end_state, &stepper.end);
                    let is_finite = size.is_finite();
                    let size = self.reference_size(stepper, size);
                    let tolerance = self.control.tolerance(self.size.max(size));
                    let error = match self.control {
                        LevelControl::Fixed | LevelControl::Planned { .. } => 0.0,
                        LevelControl::Adaptive { .. } => stepper.error(level) / tolerance,
                    };
                    if !is_finite {
                        return Err(Halt::Diverged);
                    }
                    // A long step in which the gears oscillate on the mesh stiffness is repeated with short steps.
                    let frequency = stepper.check_flanks(level, &mut self.locator.unchanged);
                    let longest = self.control.level_for_frequency(&self.time_grid, frequency);
                    if level + 1 < longest {
                        statistics.rejected += 1;
                        rejected = true;
                        level = self.control.level_on_grid(&self.time_grid, state.count, longest);
                        continue;
                    }
                    // The shortest step is accepted in any case: at a kink no step is short enough.
                    if error <= 1.0 || level == self.time_grid.finest {
                        self.size = size;
                        stepper.record_level(&self.time_grid, state.count, level);
                        let adapts = matches!(self.control, LevelControl::Adaptive { .. });
                        if adapts && self.level == level && level > 0 && !rejected {
                            let predicted =
                                stepper.estimator.error_of_doubled_step(&stepper.context, level) / tolerance;
                            self.level -= usize::from(predicted < DOUBLING_FRACTION);
                        }
                        return Ok(AcceptedStep { level, error });
                    }
                    level_for_error(&self.time_grid, level, error, stepper.context.stages())
                }
            };
            statistics.rejected += 1;
            rejected = true;
            if matches!(self.control, LevelControl::Adaptive { .. }) {
                self.level = self.level.max(next_level);
            }
            level = self.control.level_on_grid(&self.time_grid, state.count, next_level);
        }
    }

    /// Tries one step of a level.
    fn try_step(
        &self,
        stepper: &mut Stepper<'_>,
        level: usize,
        state: &State,
        statistics: &mut Statistics,
    ) -> Result<Outcome, Halt> {
        let solve_tolerance = self.control.solve_tolerance(self.size, stepper.context.cache.linear.includes_meshes);
        let history = &self.own.history;
        let end = match self.own.since_unit {
            0.0 => self.time(state.count + self.time_grid.units(level)),
            _ => state.elapsed + self.time_grid.step(level),
        };
        let span = StepSpan { level, begin: state.elapsed, end };
        stepper.solver.guess(&stepper.context, span, &stepper.begin, history, &mut stepper.stages)?;
        match stepper.step(span, &state.y, solve_tolerance, statistics) {
            // The iteration may move the gear centres closer together than the motion does.
            Err(Halt::Overlap { .. } | Halt::Touch(_)) if level < self.time_grid.finest => Ok(Outcome::Unsolved),
            outcome => outcome,
        }
    }

    /// Elapsed time of the first contact change within the last step, s.
    fn locate(&mut self, stepper: &mut Stepper<'_>, level: usize, state: &State) -> Result<Option<f64>, Halt> {
        let end = state.elapsed + self.time_grid.step(level);
        if !self.locator.is_possible(stepper) && !stepper.loads().motion.leaves_piece(end) {
            return Ok(None);
        }
        if stepper.loads().motion.motion_changes_contact_modes() {
            stepper.stages.refresh(&stepper.context, level);
        }
        self.locator.locate(&completed(stepper, level, state), &mut self.sampler)
    }

    /// Whether the loads at the end of the part of a step that is kept, up to the elapsed time `until`, differ from the
    /// polynomial by more than the tolerance. The polynomial is less accurate there than at the end of the step.
    fn exceeds_tolerance(
        &mut self,
        stepper: &mut Stepper<'_>,
        level: usize,
        state: &State,
        until: f64,
        statistics: &mut Statistics,
    ) -> Result<bool, Halt> {
        let LevelControl::Adaptive { rtol, floor, .. } = self.control else {
            return Ok(false);
        };
        let within = until - state.elapsed;
        if level == self.time_grid.finest || within <= 0.0 {
            return Ok(false);
        }
        let z = self.sampler.state_at(stepper, level, &state.y, within);
        let at = StepInstant { part: within / self.time_grid.step(level), elapsed: until };
        let defect = stepper.defect_at(at, z, self.locator.scratch())?;
        statistics.evaluations += 1;
        Ok(within * defect > rtol * self.size.max(floor))
    }

    /// Tells the observer of a contact change. Displacements and velocities are the same in both contact modes.
    fn report(
        &mut self,
        stepper: &Stepper<'_>,
        output: &mut OutputMap,
        level: usize,
        state: &State,
        change: f64,
        observer: &mut impl Observer,
    ) {
        let loads = stepper.loads();
        // Angles of shafts within a piece of a variable speed follow from that piece only.
        if loads.motion.piece_at(state.elapsed).is_some() {
            output.evaluate_deferred(loads, true, &mut |quantity| observer.deferred(quantity));
        }
        let sampler = &mut self.sampler;
        let mut read = |q: &mut [f64], v: &mut [f64]| {
            let z = sampler.state_at(stepper, level, &state.y, change - state.elapsed);
            output.read(loads, change, z, q, v);
        };
        observer.switched(change, &mut read, &self.locator.new_contact_modes);
    }

    /// Advances to a contact change at an elapsed time, s, and adopts the new contact modes. The next step begins there.
    fn switch(
        &mut self,
        stepper: &mut Stepper<'_>,
        level: usize,
        state: &mut State,
        change: f64,
        statistics: &mut Statistics,
    ) -> Result<(), Halt> {
        stepper.stages.refresh(&stepper.context, level);
        let within = change - state.elapsed;
        let z = self.sampler.state_at(stepper, level, &state.y, within);
        stepper.end_state.copy_from_slice(z);
        std::mem::swap(&mut state.y, &mut stepper.end_state);
        state.contact_modes.clone_from(&self.locator.new_contact_modes);
        stepper.context.loads.motion.set_contact_modes(&state.contact_modes);
        let substep = self.time_grid.step(self.time_grid.substep_level(level));
        self.changes_at_this_time = if within < substep { self.changes_at_this_time + 1 } else { 0 };
        // Less than a unit remains, so that the grid of every level continues after the change.
        state.count += ((change - self.time(state.count)) / self.time_grid.unit()).floor() as u64;
        self.own.since_unit = change - self.time(state.count);
        state.elapsed = self.time(state.count) + self.own.since_unit;
        // The error of the step that ends here also holds for the next steps.
        state.next_step = self.time_grid.step(self.level);
        self.own.history.clear();
        statistics.events += 1;
        stepper.evaluate_begin(state.elapsed, &state.y, statistics)?;
        self.size = self.reference_size(stepper, stepper.size(&state.y, &stepper.begin));
        if within > 0.0 {
            statistics.accept(within, false);
        }
        Ok(())
    }

    /// Advances by the first `units` of a step, up to the grid of its level.
    fn advance(
        &mut self,
        stepper: &mut Stepper<'_>,
        state: &mut State,
        AcceptedStep { level, error }: AcceptedStep,
        units: u64,
        statistics: &mut Statistics,
    ) -> Result<(), Halt> {
        self.changes_at_this_time = 0;
        let (end, is_whole) = (self.time(state.count + units), self.is_whole(units, level));
        let length = if is_whole { self.time_grid.time(units) } else { end - state.elapsed };
        if !is_whole {
            let z = self.sampler.state_at(stepper, level, &state.y, length);
            stepper.end_state.copy_from_slice(z);
            stepper.evaluate_end(end, statistics)?;
            self.size = self.reference_size(stepper, stepper.size(&stepper.end_state, &stepper.end));
        }
        for (variation, contact) in self.own.force_variations.iter_mut().zip(&stepper.end.contacts) {
            *variation = variation.with(contact.force, length);
        }
        stepper.commit(&mut state.y);
        state.count += units;
        state.elapsed = end;
        self.own.since_unit = 0.0;
        state.previous_error = error;
        state.next_step = self.time_grid.step(self.level);
        self.own.history.clear();
        if is_whole {
            stepper.solver.store(&stepper.context, level, &stepper.stages, &mut self.own.history);
        }
        statistics.accept(length, level == 0);
        Ok(())
    }

    /// Whether a step of a level ends where `units` units do: it is as long, and begins at a unit.
    fn is_whole(&self, units: u64, level: usize) -> bool {
        units == self.time_grid.units(level) && self.own.since_unit == 0.0
    }

    /// Energy norm that the tolerance of a step is relative to, for a motion of the norm `size`.
    ///
    /// The tolerance permits errors of this energy in any part of the motion. Where the meshes carry little of it, as in a
    /// train that a large bow moves, an error of the mesh forces would exceed what the accuracy permits. The norm is
    /// therefore reduced until an error in one mesh alone, δF/√k, is at most the permitted part of the unit of this force.
    fn reference_size(&self, stepper: &Stepper<'_>, size: f64) -> f64 {
        let LevelControl::Adaptive { rtol, force_error: Some(permitted), .. } = self.control else {
            return size;
        };
        let meshes = &stepper.loads().motion.model().meshes;
        let forces = self.own.force_variations.iter().zip(meshes);
        let limits = forces.map(|(&force, mesh)| permitted / rtol * unit_of_errors(force) / mesh.stiffness.sqrt());
        size.min(limits.fold(f64::INFINITY, f64::min).max(MIN_REFERENCE * size))
    }

    /// Units from `count` to the next multiple of a step of a level: at least one unit, at most the step.
    fn units_to_grid(&self, count: u64, level: usize) -> u64 {
        let units = self.time_grid.units(level);
        units - count % units
    }

    /// Elapsed time at a unit, s.
    fn time(&self, unit: u64) -> f64 {
        self.own.time_base + self.time_grid.time(unit)
    }
}

/// The unit of the errors of a force, N: its standard deviation, or a share of its mean where this is larger.
fn unit_of_errors(force: ForceVariation) -> f64 {
    force.deviation().max(SHARE_OF_MEAN * force.mean.abs())
}

/// The last step, which began at `state`.
fn completed<'a, 'm>(stepper: &'a Stepper<'m>, level: usize, state: &'a State) -> CompletedStep<'a, 'm> {
    CompletedStep { stepper, level, z: &state.y, begin: state.elapsed, contact_modes: &state.contact_modes }
}
