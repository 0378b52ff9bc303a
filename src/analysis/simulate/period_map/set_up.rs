//! The set-up of a period map: the modes of its runs, their steps, and the state at the begin of a period.

use std::sync::Arc;

use super::super::exponential::countable_grid;
use super::super::heartbeat::Waiting;
use super::super::initial::start;
use super::super::reduction::Reduction;
use super::super::{Options, RecordPlan, Run, System, foreign_contact_modes, motion, of_run, reduced_setup};
use super::{PeriodMap, stepper};
use crate::analysis::{AnalysisError, Spectrum};
use crate::exponential::TimeGrid;
use crate::modal::RealModes;

/// Duration of the run that a reduction to fewer modes is chosen for, in periods: about as many as a solution takes.
const EXPECTED_PERIODS: f64 = 10.0;

/// Calls `solve` with the period map of a system; `options.duration` is the period, s.
///
/// # Errors
/// [`AnalysisError`] of the set-up, or of `solve`.
pub fn with_period_map<T>(
    system: &System,
    options: &Options,
    plan: &RecordPlan,
    watch: &mut dyn FnMut(f64) -> bool,
    solve: impl for<'a> FnOnce(&mut PeriodMap<'a>) -> Result<T, AnalysisError>,
) -> Result<T, AnalysisError> {
    let several = several_periods(options);
    let run = MapRun { options: &several, period: options.duration };
    with_map_of(system, options, plan, run, watch, solve)
}

/// The modes that the runs of a period map keep, for runs at other speeds and of other systems with the same coordinates, and
/// the reduction to them; none if they keep all modes.
///
/// # Errors
/// [`AnalysisError`] of the set-up.
pub fn kept_modes(
    system: &System,
    options: &Options,
    plan: &RecordPlan,
    watch: &mut dyn FnMut(f64) -> bool,
) -> Result<Option<(Arc<RealModes>, Reduction)>, AnalysisError> {
    let several = several_periods(options);
    options.check()?;
    system.model.check_speed(options.fastest())?;
    let cached = &of_run(system, options)?;
    let spectrum = Spectrum::new(cached, options.fastest())?;
    let start = start(cached, &several, &spectrum, watch)?;
    let end = start.state.elapsed + several.duration;
    let run = Run { cached, base: None, options: &several, spectrum: &spectrum, floor: start.floor, end };
    let mut observer = Waiting::new(watch);
    let known = reduced_setup::kept_modes(&run, &start, plan, &mut observer)?;
    Ok(known.map(|known| (Arc::new(known.projected.modes.clone()), known.reduction)))
}

/// The options of the run that a reduction to fewer modes is chosen for.
fn several_periods(options: &Options) -> Options {
    Options { duration: EXPECTED_PERIODS * options.duration, ..options.clone() }
}

/// Calls `solve` with the map over parts of the length `part`, s, of a motion of `options.duration`, s.
///
/// # Errors
/// [`AnalysisError`] of the set-up, or of `solve`.
pub fn with_part_map<T>(
    system: &System,
    options: &Options,
    plan: &RecordPlan,
    part: f64,
    watch: &mut dyn FnMut(f64) -> bool,
    solve: impl for<'a> FnOnce(&mut PeriodMap<'a>) -> Result<T, AnalysisError>,
) -> Result<T, AnalysisError> {
    with_map_of(system, options, plan, MapRun { options, period: part }, watch, solve)
}

/// The run whose modes the map has.
struct MapRun<'a> {
    options: &'a Options,
    /// Period of the map, s.
    period: f64,
}

/// Calls `solve` with the map over the period of a run.
fn with_map_of<T>(
    system: &System,
    options: &Options,
    plan: &RecordPlan,
    MapRun { options: several, period }: MapRun<'_>,
    watch: &mut dyn FnMut(f64) -> bool,
    solve: impl for<'a> FnOnce(&mut PeriodMap<'a>) -> Result<T, AnalysisError>,
) -> Result<T, AnalysisError> {
    options.check()?;
    for speed in options.speed.magnitudes() {
        system.model.check_speed(speed)?;
    }
    let cached = &of_run(system, options)?;
    let spectrum = Spectrum::new(cached, options.fastest())?;
    let start = start(cached, several, &spectrum, watch)?;
    let motion = motion(cached, options, plan, &start)?;
    if !motion.accepts_contact_modes(&start.state.contact_modes) {
        return Err(foreign_contact_modes(&start).into());
    }
    let end = start.state.elapsed + several.duration;
    let run = Run { cached, base: None, options: several, spectrum: &spectrum, floor: start.floor, end };
    let mut observer = Waiting::new(watch);
    let (setup, reduction) = reduced_setup::set_up(&run, motion.clone(), &start, plan, &mut observer)?;
    let setup = if setup.linear.includes_meshes {
        setup
    } else {
        // Without the meshes every shaft rotates freely, and the modes say little about the period map.
        let complete = cached.at_speed(options.fastest())?.projected(options.fastest())?;
        run.complete(motion, &start, plan, Some(&complete))?
    };
    if setup.linear.is_parallel() {
        let message = format!(
            "the modes are nearly parallel (condition number {:.1e}), as at critical damping; change the damping slightly, or run in with simulate()",
            setup.linear.condition
        );
        return Err(AnalysisError::Convergence(message));
    }
    let grid = countable_grid(cached, several, &setup.linear, &setup.loads, end)?;
    let steps = (period / grid.longest).ceil().max(1.0);
    let time_grid = TimeGrid { longest: period / steps, ..grid };
    let stepper = stepper(cached, options, &setup, time_grid);
    let levels = vec![0; steps as usize].into();
    let mut map = PeriodMap {
        cached,
        options,
        plan,
        period,
        setup,
        reduction,
        stepper,
        time_grid,
        steps: steps as u64,
        start,
        spectrum,
        levels,
        observer,
        runs: 0,
    };
    solve(&mut map)
}
