//! Choice of the step level, and the tolerances of a step.

use std::f64::consts::TAU;
use std::sync::Arc;

use crate::exponential::propagator::TimeGrid;

/// How the step level is chosen.
#[derive(Clone, Debug, PartialEq)]
pub enum LevelControl {
    /// The longest step throughout.
    Fixed,
    /// A given level within each longest step, so that runs from close initial states take the same steps.
    Planned {
        /// Level within each longest step of the run.
        levels: Arc<[u8]>,
        /// Tolerance of the stage equations, relative to the energy norm of the motion.
        solve_rtol: f64,
    },
    /// The longest step that meets the tolerance.
    Adaptive {
        /// Error of a step, relative to the energy norm of the motion.
        rtol: f64,
        /// Smallest energy norm that the tolerance is relative to.
        floor: f64,
        /// Permitted error of mesh forces relative to the unit of their errors, if there is one.
        force_error: Option<f64>,
    },
}

/// A step of twice the length is tried if its predicted error is below this fraction of the tolerance: a rejected step
/// costs more than the two shorter ones.
pub(in crate::exponential) const DOUBLING_FRACTION: f64 = 0.25;
/// Largest number of halvings after one rejection: the error says little about much shorter steps.
const MAX_HALVINGS: usize = 4;
/// The stage equations are solved to this fraction of the tolerance.
const SOLVE_FRACTION: f64 = 0.03;
/// The same if the loads contain the complete mesh forces.
const SOLVE_FRACTION_UNMESHED: f64 = 0.01;
/// Largest tolerance for this test: collocation is stable only if the stage equations are solved.
const MAX_SOLVE_RTOL: f64 = 1e-3;
/// The stage equations of fixed steps are solved to this fraction of the motion.
const FIXED_SOLVE_FRACTION: f64 = 1e-13;
/// Steps per period on the mesh stiffness while flanks can separate: the motion within a step is less accurate than that
/// at its end, and flanks separate and meet within steps.
const STEPS_PER_PERIOD: f64 = 3.0;

impl LevelControl {
    /// Tolerance of the error of a step, for a motion of this energy norm.
    pub(in crate::exponential) fn tolerance(&self, size: f64) -> f64 {
        match self {
            Self::Fixed | Self::Planned { .. } => f64::INFINITY,
            Self::Adaptive { rtol, floor, .. } => rtol * size.max(*floor),
        }
    }

    /// Tolerance of the stage equations, for a motion of this energy norm; `is_meshed` tells whether the linear motion
    /// contains the mean mesh stiffness.
    pub(in crate::exponential) fn solve_tolerance(&self, size: f64, is_meshed: bool) -> f64 {
        match self {
            Self::Fixed => FIXED_SOLVE_FRACTION * size,
            Self::Planned { solve_rtol, .. } => solve_rtol * size,
            Self::Adaptive { rtol, floor, .. } => {
                let fraction = if is_meshed { SOLVE_FRACTION } else { SOLVE_FRACTION_UNMESHED };
                fraction * rtol.min(MAX_SOLVE_RTOL) * size.max(*floor)
            }
        }
    }

    /// Level of a step from the unit `count` on, no longer than one of `level`: a level on whose grid the unit lies, if
    /// its step is at least half as long. Otherwise, as after a contact change, `level` itself, of whose step the part up
    /// to the grid is kept. Fixed steps reach the grid by shorter steps.
    pub(in crate::exponential) fn level_on_grid(&self, time_grid: &TimeGrid, count: u64, level: usize) -> usize {
        let (shortest, off_grid) = match self {
            Self::Fixed => (time_grid.substep_level(level), time_grid.substep_level(level)),
            Self::Planned { .. } | Self::Adaptive { .. } => ((level + 1).min(time_grid.finest), level),
        };
        (level..=shortest).find(|level| count.is_multiple_of(time_grid.units(*level))).unwrap_or(off_grid)
    }

    /// Planned level of a step from the unit `count` on; zero without a plan.
    pub(in crate::exponential) fn planned_level(&self, time_grid: &TimeGrid, count: u64) -> usize {
        let Self::Planned { levels, .. } = self else {
            return 0;
        };
        let longest = usize::try_from(count / time_grid.units(0)).unwrap_or(usize::MAX);
        levels.get(longest).map_or(0, |level| usize::from(*level))
    }

    /// Level of the longest step that resolves an oscillation on the mesh stiffness with this frequency, rad/s.
    pub(in crate::exponential) fn level_for_frequency(&self, time_grid: &TimeGrid, frequency: f64) -> usize {
        match self {
            Self::Fixed | Self::Planned { .. } => 0,
            Self::Adaptive { .. } => time_grid.level_of(TAU / (STEPS_PER_PERIOD * frequency)),
        }
    }
}

/// Level of the next attempt after a step with this error in multiples of the tolerance: that at which a smooth load would
/// meet the tolerance.
pub(in crate::exponential) fn level_for_error(time_grid: &TimeGrid, level: usize, error: f64, stages: usize) -> usize {
    let factor = error.powf(-0.5 / stages as f64);
    let level_of_smooth_load = time_grid.level_of(time_grid.step(level) * factor);
    level_of_smooth_load.clamp(level + 1, level + MAX_HALVINGS).min(time_grid.finest)
}
