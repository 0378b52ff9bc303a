//! What loads over time excite: the free vibration of a mode that a load p(t) leaves.
//!
//! A mode of the eigenvalue λ = −c/2 + iω follows a slow load quasi-statically. The rest of its motion has the amplitude
//! |z|, relative to the static displacement under a unit load, with ż = λz + ṗ. A load that is released suddenly has
//! |z| = 1 at every frequency, a slow change has a small |z|, and a tone has a large one at its own frequency: |z(ω)| is
//! the spectrum of the load as the mode sees it.
//!
//! Coarse elements shift a mode below a tone into resonance with it. Modes near the highest tone therefore count as if they
//! were in resonance.

use std::f64::consts::PI;

use num_complex::Complex64;

use crate::connection::AppliedLoad;
use crate::exponential::phi;
use crate::model::Model;
use crate::numerics::EQUALITY_TOLERANCE;
use crate::scene::{COMPARED_DURATION, Curve, LoadLaw, Scene};

/// A load has a tone at a frequency where a mode without damping reaches this amplitude, relative to the range of the load.
/// A step reaches 1, a pulse 2, and two periods of a tone 2π.
const MIN_TONE_AMPLITUDE: f64 = 3.0;
/// Frequencies near a tone, relative to it: those of modes that elements of an error of up to a factor of two shift to it, and
/// those that lie above it by the uncertainty of the tone.
const TONE_FREQUENCY_RANGE: [f64; 2] = [0.5, 1.25];
/// Ratio between the frequencies at which tones are sought. Within 5 % of its frequency, a long tone reaches 10.
const TONE_FREQUENCY_RATIO: f64 = 1.1;

/// A load that varies, as entries over the coordinates for a unit load.
pub struct VaryingLoad<'a> {
    /// Entries (index of a coordinate, coefficient).
    pub entries: Vec<(usize, f64)>,
    /// The load over time; `None` for a load that is released suddenly.
    curve: Option<&'a Curve>,
    /// Frequency of the highest tone, rad/s; 0 without a tone.
    tone: f64,
}

impl VaryingLoad<'_> {
    /// Largest amplitude |z| of a mode of the frequency ω, rad/s, and the damping c, 1/s.
    pub fn amplitude(&self, frequency: f64, damping: f64) -> f64 {
        let Some(curve) = self.curve else { return 1.0 };
        let own = amplitude(curve, Complex64::new(-damping / 2.0, frequency));
        if self.tone == 0.0 {
            return own;
        }
        // A tone sustains its motion, while the rule for released loads counts a vibration that decays.
        let sustained = (damping * COMPARED_DURATION).max(1.0).sqrt();
        if frequency < TONE_FREQUENCY_RANGE[0] * self.tone || frequency > TONE_FREQUENCY_RANGE[1] * self.tone {
            return own * sustained;
        }
        // A tone of the amplitude A that is in resonance for the time T, or until damping limits the motion: A ωT/2.
        let time = if damping > 0.0 { COMPARED_DURATION.min(2.0 / damping) } else { COMPARED_DURATION };
        own.max(curve.span() / 2.0 * frequency * time / 2.0) * sustained
    }
}

/// The loads of a model that depend on time, angle or speed. A load that turns, and a torque over the speed, have no time at
/// which they begin: they count as released suddenly.
pub fn varying_loads(model: &Model) -> Vec<VaryingLoad<'_>> {
    model.loads.iter().flat_map(parts).filter(|load| load.curve.is_none_or(|curve| curve.largest() > 0.0)).collect()
}

fn parts(load: &AppliedLoad) -> Vec<VaryingLoad<'_>> {
    let part = |row: usize, curve: Option<_>| VaryingLoad {
        entries: load.rows[row].clone(),
        curve,
        tone: curve.map_or(0.0, highest_tone_of),
    };
    match &load.law {
        LoadLaw::Force([along_y, along_z]) => vec![part(0, Some(along_y)), part(1, Some(along_z))],
        LoadLaw::Torque(curve) => vec![part(0, Some(curve))],
        LoadLaw::Turning { .. } => vec![part(0, None), part(1, None)],
        LoadLaw::SpeedTorque { .. } => vec![part(0, None)],
    }
}

/// Highest frequency of a tone of the loads over time, rad/s; 0 if they have none.
pub fn highest_tone(scene: &Scene) -> f64 {
    let curves = scene.varying_loads.iter().flat_map(|load| match &load.law {
        LoadLaw::Force(parts) => parts.iter().collect(),
        LoadLaw::Torque(curve) => vec![curve],
        LoadLaw::Turning { .. } | LoadLaw::SpeedTorque { .. } => Vec::new(),
    });
    curves.map(highest_tone_of).fold(0.0, f64::max)
}

fn highest_tone_of(curve: &Curve) -> f64 {
    let ([first, last], span) = (curve.range(), curve.span());
    if span == 0.0 {
        return 0.0;
    }
    let lowest = 2.0 * PI / (last - first);
    // Two points for each half period show a tone.
    let mut frequency = PI / (2.0 * curve.mean_spacing());
    while frequency > lowest {
        if amplitude(curve, Complex64::new(0.0, frequency)) > MIN_TONE_AMPLITUDE * span {
            return frequency;
        }
        frequency /= TONE_FREQUENCY_RATIO;
    }
    0.0
}

/// Largest |z| with ż = λz + ṗ, from the first value of the load, which acts suddenly.
fn amplitude(curve: &Curve, rate: Complex64) -> f64 {
    let half_period = PI / rate.im;
    let within = phi(rate * half_period);
    let mut z = Complex64::from(curve.at(curve.range()[0])[0]);
    let (mut most, mut known) = (z.norm_sqr(), (0.0, [Complex64::ZERO; 4]));
    for (width, [a, b, c]) in curve.derivative_pieces() {
        let after =
            |s: f64, phi: &[Complex64; 4]| z * phi[0] + (phi[1] * a + (phi[2] * b + phi[3] * (2.0 * c * s)) * s) * s;
        if width > half_period {
            // The amplitude within a long piece, where its end may be a zero of the response.
            most = most.max(after(half_period, &within).norm_sqr());
        }
        // Pieces of equal widths share the φ-functions.
        if (width - known.0).abs() > EQUALITY_TOLERANCE * width {
            known = (width, phi(rate * width));
        }
        z = after(width, &known.1);
        most = most.max(z.norm_sqr());
    }
    most.sqrt()
}
