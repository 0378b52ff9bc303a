//! A completed step: its states, and its displacements and velocities for observers.

use super::output::OutputMap;
use super::substep::SubstepSampler;
use crate::exponential::step::Stepper;
use crate::integrate::{Deferred, Halt, Trajectory};
use crate::numerics::EQUALITY_TOLERANCE;

/// The step that was taken last, before it is committed.
#[derive(Clone, Copy)]
pub struct CompletedStep<'a, 'm> {
    pub stepper: &'a Stepper<'m>,
    /// Step level.
    pub level: usize,
    /// State z at the beginning.
    pub z: &'a [f64],
    /// Elapsed time at the beginning, s.
    pub begin: f64,
    /// Contact modes during the step, as integer codes.
    pub contact_modes: &'a [i64],
}

impl CompletedStep<'_, '_> {
    /// Length, s.
    pub fn length(&self) -> f64 {
        self.stepper.step_length(self.level)
    }

    /// Elapsed time at the fraction `part` of the step, s.
    pub fn time(&self, part: f64) -> f64 {
        self.begin + part * self.length()
    }

    /// State z `within` seconds after the beginning.
    pub fn state_at<'s>(&'s self, sampler: &'s mut SubstepSampler, within: f64) -> &'s [f64] {
        sampler.state_at(self.stepper, self.level, self.z, within)
    }
}

/// Displacements and velocities of a completed step up to an instant.
pub struct StepTrajectory<'a, 'm> {
    pub step: CompletedStep<'a, 'm>,
    /// Elapsed time up to which the step is kept, s.
    pub end: f64,
    pub output: &'a mut OutputMap,
    pub sampler: &'a mut SubstepSampler,
}

impl Trajectory for StepTrajectory<'_, '_> {
    fn begin(&self) -> f64 {
        self.step.begin
    }

    fn end(&self) -> f64 {
        self.end
    }

    fn states(&mut self, instants: &[f64], _: &[usize], q: &mut [f64], v: &mut [f64]) {
        let loads = self.step.stepper.loads();
        each_state(self.step, self.sampler, instants, |elapsed, z| {
            self.output.gather(z);
            if let Some(energies) = &mut self.output.energies {
                energies.collect(elapsed, z);
            }
            if let Some(accelerations) = &mut self.output.accelerations {
                accelerations.gather(z);
            }
            if let Some(combinations) = &mut self.output.combinations {
                combinations.gather(z);
            }
        });
        self.output.read_gathered(loads, instants, q, v);
    }

    fn defers_energies(&self) -> bool {
        true
    }

    fn deferred(&mut self, receive: &mut dyn FnMut(Deferred<'_>)) {
        self.output.evaluate_deferred(self.step.stepper.loads(), false, receive);
    }

    fn power_states(&mut self, instants: &[f64], _: &[usize], _: &[Vec<(usize, f64)>], q: &mut [f64], v: &mut [f64]) {
        if let Some(output) = &mut self.output.powers {
            each_state(self.step, self.sampler, instants, |_, z| output.gather(z));
            output.read_gathered(self.step.stepper.loads(), instants, q, v);
        }
    }

    fn gives_damping(&self) -> bool {
        true
    }

    fn accelerations(&mut self, instants: &[f64], _: &[usize], a: &mut [f64]) -> Result<(), Halt> {
        self.output.read_accelerations(self.step.stepper.loads(), instants, a)
    }

    fn combines(&mut self, instants: &[f64]) -> Result<bool, Halt> {
        let Some(map) = &mut self.output.combinations else { return Ok(false) };
        map.add_loads(self.step.stepper.loads(), instants)?;
        Ok(true)
    }

    fn is_resolved(&self) -> bool {
        false
    }

    fn ends_at_state(&self) -> bool {
        (self.end - self.step.begin - self.step.length()).abs() <= EQUALITY_TOLERANCE * self.step.length()
    }

    fn end_displacement(&self) -> Option<&[f64]> {
        None
    }
}

/// Calls `visit` with each instant of a step and the state z there.
fn each_state(
    step: CompletedStep<'_, '_>,
    sampler: &mut SubstepSampler,
    instants: &[f64],
    mut visit: impl FnMut(f64, &[f64]),
) {
    let length = step.length();
    for elapsed in instants {
        let within = elapsed - step.begin;
        // Instants at an end of the step take the state of that end.
        let z = if (within - length).abs() <= EQUALITY_TOLERANCE * length {
            &step.stepper.end_state
        } else if within.abs() <= EQUALITY_TOLERANCE * length {
            step.z
        } else {
            step.state_at(sampler, within)
        };
        visit(*elapsed, z);
    }
}
