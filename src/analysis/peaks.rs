//! Peaks of the synchronous response at one place, with the speeds at which it is 1/√2 of them.
//!
//! API RP 684 calls the speed of a peak N_c, the two others N₁ and N₂, and N_c/(N₂ − N₁) the amplification factor. Here
//! all three are found on the response itself, not between the speeds at which it was asked for. Each sense of rotation
//! is searched from standstill to its highest speed, so that N₁ is always nearer to standstill than N₂.

use std::f64::consts::FRAC_1_SQRT_2;

use nalgebra::Complex;

use super::synchronous::synchronous_of;
use super::{AnalysisError, ExcitationPart, Interrupt};
use crate::modal::CachedModel;

/// A maximum is flat: closer than this part of its speed, round-off hides where it is.
const PEAK: f64 = 1e-9;
/// Half-power speeds are met to this part of their value.
const HALF_POWER: f64 = 1e-12;

/// What is measured: the largest semi-axis of an orbit.
#[derive(Clone, Copy, Debug)]
pub struct Probe {
    /// Index of v; w follows.
    pub index: usize,
    /// The shaft that excites.
    pub source: usize,
    /// What of it.
    pub part: ExcitationPart,
    /// The speed of slow roll, whose amplitudes are taken off as run-out, rad/s.
    pub slow_roll: Option<f64>,
}

/// A peak.
#[derive(Clone, Copy, Debug)]
pub struct Peak {
    /// N_c: the speed of the reference shaft, rad/s.
    pub speed: f64,
    /// The semi-axis there, m.
    pub amplitude: f64,
    /// N₁, rad/s, between standstill and the peak; none where the response does not fall so far within the range.
    pub lower: Option<f64>,
    /// N₂, rad/s, beyond the peak; none likewise.
    pub upper: Option<f64>,
}

/// The peaks between ascending `speeds`, each of which shows on these speeds as a local maximum.
///
/// # Errors
/// [`AnalysisError`] if the undamped modes cannot be found, or `interrupt` asks to stop.
pub fn peaks(
    cached: &CachedModel,
    probe: Probe,
    speeds: &[f64],
    interrupt: &Interrupt,
) -> Result<Vec<Peak>, AnalysisError> {
    let displacement = |speed: f64| -> Result<[Complex<f64>; 2], AnalysisError> {
        interrupt.check()?;
        let amplitudes = synchronous_of(cached, speed, speed, probe.source, probe.part)?;
        Ok([amplitudes[probe.index], amplitudes[probe.index + 1]])
    };
    let run_out = probe.slow_roll.map(displacement).transpose()?.unwrap_or_default();
    let size = |speed: f64| -> Result<f64, AnalysisError> {
        let [v, w] = displacement(speed)?;
        let (v, w) = (v - run_out[0], (w - run_out[1]) * Complex::i());
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
    let found = from_standstill(&|speed| size(-speed), &backward)?.into_iter().rev().map(mirrored);
    Ok(found.chain(from_standstill(&size, &forward)?).collect())
}

/// The peaks of `size` between ascending `speeds` that are not negative.
fn from_standstill(
    size: &impl Fn(f64) -> Result<f64, AnalysisError>,
    speeds: &[f64],
) -> Result<Vec<Peak>, AnalysisError> {
    let sizes = speeds.iter().map(|speed| size(*speed)).collect::<Result<Vec<_>, _>>()?;
    let mut peaks = Vec::new();
    for at in 1..sizes.len().saturating_sub(1) {
        if sizes[at] <= sizes[at - 1] || sizes[at] < sizes[at + 1] {
            continue;
        }
        let (speed, amplitude) = highest(size, speeds[at - 1], speeds[at + 1])?;
        let half = FRAC_1_SQRT_2 * amplitude;
        let below = (0..=at).rev().find(|index| speeds[*index] < speed && sizes[*index] < half);
        let above = (at..sizes.len()).find(|index| speeds[*index] > speed && sizes[*index] < half);
        // From the neighbour on the peak's side, or from the peak itself.
        let lower = below.map(|index| falls(size, half, speeds[index + 1].min(speed), speeds[index])).transpose()?;
        let upper = above.map(|index| falls(size, half, speeds[index - 1].max(speed), speeds[index])).transpose()?;
        peaks.push(Peak { speed, amplitude, lower, upper });
    }
    Ok(peaks)
}

/// The maximum between two speeds, by golden section.
fn highest(
    size: &impl Fn(f64) -> Result<f64, AnalysisError>,
    low: f64,
    high: f64,
) -> Result<(f64, f64), AnalysisError> {
    let golden = (5.0_f64.sqrt() - 1.0) / 2.0;
    let (mut low, mut high) = (low, high);
    let mut inner = [high - golden * (high - low), low + golden * (high - low)];
    let mut sizes = [size(inner[0])?, size(inner[1])?];
    while high - low > PEAK * high.abs() {
        if sizes[0] > sizes[1] {
            high = inner[1];
            inner = [high - golden * (high - low), inner[0]];
            sizes = [size(inner[0])?, sizes[0]];
        } else {
            low = inner[0];
            inner = [inner[1], low + golden * (high - low)];
            sizes = [sizes[1], size(inner[1])?];
        }
    }
    Ok(if sizes[0] > sizes[1] { (inner[0], sizes[0]) } else { (inner[1], sizes[1]) })
}

/// Where the response falls through `level` on the way from `inside`, where it is above, to `outside`: bisection.
fn falls(
    size: &impl Fn(f64) -> Result<f64, AnalysisError>,
    level: f64,
    inside: f64,
    outside: f64,
) -> Result<f64, AnalysisError> {
    let (mut inside, mut outside) = (inside, outside);
    while (outside - inside).abs() > HALF_POWER * outside.abs().max(inside.abs()) {
        let middle = f64::midpoint(inside, outside);
        if middle == inside || middle == outside {
            break;
        }
        if size(middle)? < level {
            outside = middle;
        } else {
            inside = middle;
        }
    }
    Ok(f64::midpoint(inside, outside))
}
