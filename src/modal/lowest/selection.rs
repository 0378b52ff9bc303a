//! The order of modes, and which of them are vibrations.

use std::cmp::Ordering;

use num_complex::Complex64;

use crate::model::Model;

/// Smallest |Im λ|/|λ| of a vibration: the damping ratio is below 0.9987.
const MIN_OSCILLATION: f64 = 0.05;
/// Smallest rate of a motion in which a shaft relaxes, in units of 1/β. With β, two spring forces and no other damping, the rate is
/// above 1/β, because −1/μ₁ − 1/μ₂ = β for both overdamped motions μ of a mode.
const MIN_RELAXATION: f64 = 0.5;

/// Which modes are wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ModeSelection {
    /// All modes.
    All,
    /// Modes that vibrate, see [`vibrates`].
    Vibrations,
}

impl ModeSelection {
    /// Whether a mode with this eigenvalue (rad/s) at a speed of the reference shaft (rad/s) is wanted.
    pub fn contains(self, model: &Model, speed: f64, eigenvalue: Complex64) -> bool {
        self == Self::All || vibrates(model, speed, eigenvalue)
    }
}

/// Whether a mode with λ = `eigenvalue` (rad/s) at a speed of the reference shaft (rad/s) is a vibration: neither a rigid-body motion
/// nor an overdamped one, of which some turn slowly with the gyroscopic moments.
///
/// A shaft with internal damping β that turns with Ω relaxes in its own frame with μ ≈ −1/β. Seen from the ground this motion turns
/// with the shaft, λ = μ + iΩ, and is no vibration either.
pub fn vibrates(model: &Model, speed: f64, eigenvalue: Complex64) -> bool {
    let turns = |rate: Complex64| rate.im.abs() > MIN_OSCILLATION * rate.norm();
    let mut shafts = model.scene.shafts.iter().zip(&model.shafts);
    let relaxes = shafts.any(|(given, shaft)| {
        let rate = eigenvalue - Complex64::new(0.0, (shaft.ratio * speed).abs());
        given.internal_damping * rate.re < -MIN_RELAXATION && !turns(rate)
    });
    turns(eigenvalue) && !relaxes
}

/// The order of modes: by |λ|, and at equal |λ| by frequency.
pub fn ascending(first: Complex64, second: Complex64) -> Ordering {
    first.norm().total_cmp(&second.norm()).then(first.im.total_cmp(&second.im))
}
