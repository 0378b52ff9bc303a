//! Peaks of the synchronous response at one node and their half-power speeds, at which the response is 1/√2 of the peak.
//!
//! API RP 684 calls the speed of a peak N_c, the half-power speeds N₁ and N₂, and N_c/(N₂ − N₁) the amplification factor.
//! All three are computed from the response itself, not by interpolation between the given speeds. Each direction of
//! rotation is searched from standstill to its highest speed, so that N₁ is always closer to standstill than N₂.

use std::f64::consts::FRAC_1_SQRT_2;

use nalgebra::Complex;

use super::instability::is_unstable;
use super::synchronous::{highest_spin, synchronous_of};
use super::{AnalysisError, ExcitationPart, Interrupt};
use crate::modal::CachedModel;
use crate::numerics::{Sample, bisect, maximum};

/// Relative tolerance of the speed of a peak. A maximum is flat; round-off prevents a smaller tolerance.
const PEAK_TOLERANCE: f64 = 1e-9;
/// Relative tolerance of half-power speeds.
const HALF_POWER_TOLERANCE: f64 = 1e-12;

/// The measured quantity: the major semi-axis of the orbit of a node.
#[derive(Clone, Copy, Debug)]
pub struct Probe {
    /// Index of the coordinate v; w follows.
    pub index: usize,
    /// Index of the shaft that excites.
    pub source: usize,
    /// Part of the excitation.
    pub part: ExcitationPart,
    /// Slow-roll speed, rad/s. Its response is subtracted as run-out.
    pub slow_roll: Option<f64>,
}

/// A peak of the response.
#[derive(Clone, Copy, Debug)]
pub struct Peak {
    /// Speed N_c of the reference shaft, rad/s.
    pub speed: f64,
    /// Major semi-axis at the peak, m.
    pub amplitude: f64,
    /// Half-power speed N₁ between standstill and the peak, rad/s; None if it lies outside the speed range.
    pub lower: Option<f64>,
    /// Half-power speed N₂ above the peak, rad/s; None if it lies outside the speed range.
    pub upper: Option<f64>,
    /// Whether the linear motion at the peak is stable.
    pub is_stable: bool,
}

/// Finds the peaks between ascending `speeds`. Each is a local maximum of the response at these speeds.
///
/// # Errors
/// [`AnalysisError`] if a response has no accurate solution, or `interrupt` requests a stop.
pub fn peaks(
    cached: &CachedModel,
    probe: Probe,
    speeds: &[f64],
    interrupt: &Interrupt,
) -> Result<Vec<Peak>, AnalysisError> {
    let highest = highest_spin(&cached.model, speeds);
    let displacement = |speed: f64| -> Result<[Complex<f64>; 2], AnalysisError> {
        interrupt.check()?;
        let amplitudes = &synchronous_of(cached, speed, speed, probe.source, probe.part, highest)?.phasors;
        Ok([amplitudes[probe.index], amplitudes[probe.index + 1]])
    };
    let runout = probe.slow_roll.map(displacement).transpose()?.unwrap_or_default();
    let size = |speed: f64| -> Result<f64, AnalysisError> {
        let [v, w] = displacement(speed)?;
        let (v, w) = (v - runout[0], (w - runout[1]) * Complex::i());
        Ok(f64::midpoint((v + w).norm(), (v - w).norm()))
    };
    let backward: Vec<f64> = speeds.iter().rev().filter(|speed| **speed <= 0.0).map(|speed| -speed).collect();
    let forward: Vec<f64> = speeds.iter().copied().filter(|speed| *speed >= 0.0).collect();
    let mirrored = |peak: Peak| Peak {
        speed: -peak.speed,
        lower: peak.lower.map(|speed| -speed),
        upper: peak.upper.map(|speed| -speed),
        ..peak
    };
    let found = peaks_from_zero_speed(&|speed| size(-speed), &backward)?.into_iter().rev().map(mirrored);
    let mut peaks: Vec<Peak> = found.chain(peaks_from_zero_speed(&size, &forward)?).collect();
    for peak in &mut peaks {
        peak.is_stable = !is_unstable(cached, peak.speed, interrupt)?;
    }
    Ok(peaks)
}

/// Finds the peaks of `size` between ascending, non-negative `speeds`; their stability is not examined.
fn peaks_from_zero_speed(
    size: &impl Fn(f64) -> Result<f64, AnalysisError>,
    speeds: &[f64],
) -> Result<Vec<Peak>, AnalysisError> {
    let sizes = speeds.iter().map(|speed| size(*speed)).collect::<Result<Vec<_>, _>>()?;
    let mut peaks = Vec::new();
    for at in 1..sizes.len().saturating_sub(1) {
        if sizes[at] <= sizes[at - 1] || sizes[at] < sizes[at + 1] {
            continue;
        }
        let Sample { at: speed, value: amplitude } = maximum(speeds[at - 1], speeds[at + 1], PEAK_TOLERANCE, size)?;
        let half = FRAC_1_SQRT_2 * amplitude;
        let below = (0..=at).rev().find(|index| speeds[*index] < speed && sizes[*index] < half);
        let above = (at..sizes.len()).find(|index| speeds[*index] > speed && sizes[*index] < half);
        // The bracket begins at the neighbour towards the peak, or at the peak itself.
        let lower =
            below.map(|index| half_power_speed(size, half, speeds[index + 1].min(speed), speeds[index])).transpose()?;
        let upper =
            above.map(|index| half_power_speed(size, half, speeds[index - 1].max(speed), speeds[index])).transpose()?;
        peaks.push(Peak { speed, amplitude, lower, upper, is_stable: true });
    }
    Ok(peaks)
}

/// Finds the speed at which the response falls to `level`, by bisection between `inside`, where it is larger, and
/// `outside`.
fn half_power_speed(
    size: &impl Fn(f64) -> Result<f64, AnalysisError>,
    level: f64,
    inside: f64,
    outside: f64,
) -> Result<f64, AnalysisError> {
    let resolution = HALF_POWER_TOLERANCE * outside.abs().max(inside.abs());
    let [inside, outside] = bisect(inside, outside, resolution, |speed| Ok::<_, AnalysisError>(size(speed)? < level))?;
    Ok(f64::midpoint(inside, outside))
}
