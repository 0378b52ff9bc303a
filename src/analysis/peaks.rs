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
use crate::numerics::{EQUALITY_TOLERANCE, Sample, maximum, root};

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

/// Finds the peaks between ascending speeds, rad/s, at which `samples` give the response, m. Each is a local maximum of it at
/// these speeds.
///
/// # Errors
/// [`AnalysisError`] if a response has no accurate solution, or `interrupt` requests a stop.
pub fn peaks(
    cached: &CachedModel,
    probe: Probe,
    samples: &[Sample],
    interrupt: &Interrupt,
) -> Result<Vec<Peak>, AnalysisError> {
    let speeds: Vec<f64> = samples.iter().map(|sample| sample.at).collect();
    let highest = highest_spin(&cached.model, &speeds);
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
    let is_backward = |sample: &&Sample| sample.at <= 0.0;
    let backward: Vec<Sample> =
        samples.iter().rev().filter(is_backward).map(|sample| Sample { at: -sample.at, ..*sample }).collect();
    let forward: Vec<Sample> = samples.iter().copied().filter(|sample| sample.at >= 0.0).collect();
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

/// Finds the peaks of `size` between ascending, non-negative speeds of `samples`; their stability is not examined.
fn peaks_from_zero_speed(
    size: &impl Fn(f64) -> Result<f64, AnalysisError>,
    samples: &[Sample],
) -> Result<Vec<Peak>, AnalysisError> {
    let (speeds, sizes): (Vec<f64>, Vec<f64>) = samples.iter().map(|sample| (sample.at, sample.value)).unzip();
    let mut peaks = Vec::new();
    for at in 1..sizes.len().saturating_sub(1) {
        if sizes[at] <= sizes[at - 1] || sizes[at] < sizes[at + 1] {
            continue;
        }
        // A maximum is flat; round-off prevents a smaller tolerance.
        let Sample { at: speed, value: amplitude } = maximum(speeds[at - 1], speeds[at + 1], EQUALITY_TOLERANCE, size)?;
        let half = FRAC_1_SQRT_2 * amplitude;
        let below = (0..=at).rev().find(|index| speeds[*index] < speed && sizes[*index] < half);
        let above = (at..sizes.len()).find(|index| speeds[*index] > speed && sizes[*index] < half);
        // The response over the half-power one, less 1.
        let excess = |speed: f64| Ok::<_, AnalysisError>(size(speed)? / half - 1.0);
        let half_power_speed = |inside: usize, outside: usize, is_inside: bool| {
            // The bracket begins at the neighbour towards the peak, or at the peak itself.
            let within = if is_inside { (speeds[inside], sizes[inside]) } else { (speed, amplitude) };
            let ends = [within, (speeds[outside], sizes[outside])];
            root(ends.map(|(at, value)| Sample { at, value: value / half - 1.0 }), excess)
        };
        let lower = below.map(|index| half_power_speed(index + 1, index, speeds[index + 1] < speed)).transpose()?;
        let upper = above.map(|index| half_power_speed(index - 1, index, speeds[index - 1] > speed)).transpose()?;
        peaks.push(Peak { speed, amplitude, lower, upper, is_stable: true });
    }
    Ok(peaks)
}
