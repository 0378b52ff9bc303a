//! Recording of the motion over periods.

use super::super::heartbeat::Heartbeat;
use super::super::modal_setup::in_physical_coordinates;
use super::super::record::Recorder;
use super::super::{Response, RunObserver, explain, limited_by, tolerance};
use super::PeriodMap;
use crate::analysis::AnalysisError;
use crate::exponential::run as integrate;
use crate::integrate::Statistics;

impl PeriodMap<'_> {
    /// The recorded motion of `count` periods from a state z, with steps that meet the tolerance, whose levels are kept.
    /// Returns the state at the end too.
    ///
    /// # Errors
    /// [`AnalysisError`] if the run ends early.
    pub fn record(&mut self, count: u64, z: &[f64], samples: usize) -> Result<(Response, Vec<f64>), AnalysisError> {
        let (origin, begin) = (self.start.rotation.origin, self.start.state.elapsed);
        let (end, duration) = (self.end(begin, count), self.period * count as f64);
        let times: Vec<f64> =
            (0..samples).map(|sample| origin + begin + duration * sample as f64 / samples as f64).collect();
        let motion = self.setup.loads.motion.clone();
        let tolerance = tolerance(self.options, &motion);
        let mut stepper = self.stepper.clone();
        stepper.levels = Some(vec![0; self.steps as usize]);
        let mut output = self.setup.output.clone();
        let (mut state, mut statistics) = (self.state(z), Statistics::new());
        let control = self.control(self.tolerance());
        let done = self.observer.done;
        let mut watch = |_| (self.observer.heartbeat.watch)(done);
        let mut observer = RunObserver {
            recorder: Recorder::new(motion, self.plan, &times, origin, begin, tolerance),
            heartbeat: Heartbeat::waiting(&mut watch),
            start: begin,
            end,
        };
        let outcome = integrate(&mut stepper, &mut output, control, &mut state, end, &mut observer, &mut statistics);
        let (record, recorder_state) = observer.recorder.finish();
        outcome.map_err(|halted| explain(self.cached, &halted, origin))?;
        self.runs += count as usize;
        self.levels = stepper.levels.take().unwrap_or_default().into();
        let last = state.y.clone();
        let state = in_physical_coordinates(state, &self.setup.linear, &self.setup.loads);
        let response = Response {
            record,
            recorder_state,
            last: self.options.last(&self.start.rotation, origin + begin + duration, state),
            limited_by: limited_by(self.options, None, &statistics),
            statistics,
            spectrum: self.spectrum,
            condition: Some(self.setup.linear.condition),
            reduction: self.reduction,
        };
        Ok((response, last))
    }
}
