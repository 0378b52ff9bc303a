//! Speeds at which the linear motion is unstable: an eigenvalue has a positive real part.
//!
//! A response in the frequency domain exists there as well, but no real machine shows it, because every disturbance grows.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::Complex;

use super::own_frequency::lowest_modes_in_tables;
use super::{AnalysisError, Interrupt, Threads};
use crate::modal::{CachedModel, MIN_BANDED, is_growing};
use crate::numerics::EQUALITY_TOLERANCE;

/// Number of lowest modes that are examined.
const EXAMINED_MODES: usize = 6;
/// Number of modes more for each bearing, whose damper can make four modes without oscillation.
const MODES_OF_BEARING: usize = 4;
/// Number of undamped modes which tell faster than the damped modes whether one grows.
const APPROXIMATED_MODES: usize = 24;
/// Ratio of Re λ to |λ| in few undamped modes above which its sign is that of the mode, and below which it is zero. The error of the
/// approximations is about 1e-3 of their damping.
const CLEAR_RATIO: f64 = 1e-3;
/// Number of speeds that are examined at first, from the first to the last speed.
const FIRST_SPEEDS: usize = 9;

/// Whether the linear motion at a speed of the reference shaft, rad/s, is unstable. The lowest modes decide; without an
/// element that can feed energy into the motion, no mode is computed.
///
/// # Errors
/// [`AnalysisError`] if a decomposition fails, a bearing has no coefficients at the speed, or `interrupt` requests a stop.
pub fn is_unstable(cached: &CachedModel, speed: f64, interrupt: &Interrupt) -> Result<bool, AnalysisError> {
    interrupt.check()?;
    if cached.model.depends_on_frequency() {
        return Ok(!growing_modes(cached, speed)?.is_empty());
    }
    let at_speed = cached.at_speed(speed)?;
    if at_speed.model.is_dissipative(speed) {
        return Ok(false);
    }
    // The approximations have no structural damping.
    if at_speed.model.len() >= MIN_BANDED
        && !at_speed.model.has_structural_damping()
        && let Some(values) = at_speed.approximate_eigenvalues(speed, APPROXIMATED_MODES)?
    {
        let ratios = values.iter().filter(|value| value.norm() > 0.0).map(|value| value.re / value.norm());
        let is_clear = |ratio: f64| ratio.abs() > CLEAR_RATIO || ratio.abs() < EQUALITY_TOLERANCE;
        if ratios.clone().all(is_clear) {
            return Ok(ratios.clone().any(|ratio| ratio > CLEAR_RATIO));
        }
    }
    Ok(!growing_modes(cached, speed)?.is_empty())
}

/// Eigenvalues with Im λ ≥ 0, rad/s, of the growing modes among the lowest modes at a speed of the reference shaft, rad/s;
/// without an element that can feed energy into the motion, no mode is computed.
///
/// # Errors
/// [`AnalysisError`] if a decomposition fails, or a bearing has no coefficients at the speed.
pub(super) fn growing_modes(cached: &CachedModel, speed: f64) -> Result<Vec<Complex<f64>>, AnalysisError> {
    if is_dissipative(cached, speed)? {
        return Ok(Vec::new());
    }
    let count = EXAMINED_MODES + MODES_OF_BEARING * cached.model.scene.bearings.len();
    let eigenvalues = lowest_modes_in_tables(cached, speed, count)?.into_iter().map(|mode| mode.eigenvalue);
    Ok(eigenvalues.filter(|value| is_growing(*value, speed)).collect())
}

/// Whether no element can feed energy into the motion, with the coefficients of every frequency of the tables of bearings.
fn is_dissipative(cached: &CachedModel, speed: f64) -> Result<bool, AnalysisError> {
    for frequency in cached.model.table_frequencies() {
        // No mode has a frequency that a table does not contain.
        if let Ok(at) = cached.at(speed, frequency)
            && !at.model.is_dissipative(speed)
        {
            return Ok(false);
        }
    }
    Ok(cached.at(speed, cached.model.lowest_frequency())?.model.is_dissipative(speed))
}

/// The ranges of `speeds`, rad/s, in which the motion is unstable: the first and the last unstable speed of each.
///
/// Nine speeds from the first to the last one and those with the indices `peaks` are examined; between a stable and an
/// unstable one, bisection finds the first or the last unstable speed. An unstable range between two examined speeds that are
/// stable is not found.
///
/// # Errors
/// As `is_unstable`.
pub fn unstable_ranges(
    cached: &CachedModel,
    speeds: &[f64],
    peaks: &[usize],
    threads: &Threads,
    interrupt: &Interrupt,
) -> Result<Vec<[f64; 2]>, AnalysisError> {
    let mut order: Vec<usize> = (0..speeds.len()).collect();
    order.sort_by(|a, b| speeds[*a].total_cmp(&speeds[*b]));
    let grows = |place: usize| is_unstable(cached, speeds[order[place]], interrupt);
    let (steps, last) = ((FIRST_SPEEDS - 1).min(speeds.len().saturating_sub(1)), speeds.len().saturating_sub(1));
    let even = (0..=steps).filter(|_| !speeds.is_empty()).map(|step| step * last / steps.max(1));
    let at_peaks = (0..order.len()).filter(|place| peaks.contains(&order[*place]));
    let places: Vec<usize> = even.chain(at_peaks).collect::<BTreeSet<_>>().into_iter().collect();
    // Whether the motion grows, by the place in the ascending order.
    let mut known = BTreeMap::new();
    threads.in_order(
        &places,
        |place| match cached.model.depends_on_frequency() {
            true => Ok(None),
            false => Ok(Some(cached.at_speed(speeds[order[*place]])?)),
        },
        |place, at_speed| is_unstable(at_speed.as_deref().unwrap_or(cached), speeds[order[*place]], interrupt),
        |place, _, grows| {
            known.insert(*place, grows);
        },
    )?;
    let examined: Vec<(usize, bool)> = known.iter().map(|(place, grows)| (*place, *grows)).collect();
    for pair in examined.windows(2).filter(|pair| pair[0].1 != pair[1].1) {
        let [(mut low, below), (mut high, above)] = [pair[0], pair[1]];
        while high - low > 1 {
            let middle = usize::midpoint(low, high);
            *(if grows(middle)? == below { &mut low } else { &mut high }) = middle;
        }
        known.extend([(low, below), (high, above)]);
    }
    let mut ranges: Vec<[f64; 2]> = Vec::new();
    let mut previous = false;
    for (place, grows) in known {
        let speed = speeds[order[place]];
        match ranges.last_mut() {
            Some(range) if grows && previous => range[1] = speed,
            _ if grows => ranges.push([speed; 2]),
            _ => {}
        }
        previous = grows;
    }
    Ok(ranges)
}
