//! The linear motion of a run of the exponential method at a changing speed, and the loads that a speed change causes.
//!
//! One linear motion carries the whole run: the one at the middle Ω_ref of all speeds of the profile. It depends on the
//! profile only, so that a continued run has the same one. The gyroscopic and circulatory forces of the difference
//! ΔΩ = Ω − Ω_ref act as loads.

use super::super::AnalysisError;
use super::Options;
use super::exponential::rotation_of_longest_step;
use crate::exponential::SpeedChange;
use crate::modal::{AtSpeed, CachedModel, CouplingChoice, EquilibriumError, RealModes, speed_couplings};
use crate::model::Model;
use crate::motion::Speed;

/// A coupling is neglected if its acceleration, relative to that of the motion, is below this multiple of the
/// tolerance. Tolerances limit the error of a step; the error of a run is about ten times as large.
const NEGLECTED_COUPLING: f64 = 10.0;
/// The same limit in multiples of the error of displacements that a reduction may cause.
const NEGLECTED_SHARE: f64 = 0.1;
/// Tolerance of the couplings with fixed steps.
const FIXED_STEP_RTOL: f64 = 1e-10;

/// Speed of the reference shaft in the linear motion, rad/s.
pub(super) fn reference_speed(options: &Options) -> f64 {
    match options.speed {
        Speed::Constant(speed) => speed,
        Speed::Changing(_) => {
            let [slowest, largest] = options.speed.magnitudes();
            ((slowest + largest) / 2.0).copysign(options.fastest())
        }
    }
}

/// The model of the linear motion: bearings with the coefficients of the largest speed, and the circulatory forces of internal
/// damping at the reference speed.
pub(super) fn linear_model<'a>(cached: &'a CachedModel, options: &Options) -> Result<AtSpeed<'a>, EquilibriumError> {
    cached.with_circulation_at(options.fastest(), reference_speed(options))
}

/// The loads of a changing speed on the linear motion in the undamped modes `real`, of the complete model or of a subspace.
/// A run that records energies has `all_circulatory` couplings.
pub(super) fn speed_change(
    model: &Model,
    options: &Options,
    real: &RealModes,
    all_circulatory: bool,
) -> Result<SpeedChange, AnalysisError> {
    let fastest = options.fastest();
    let [slowest, largest] = options.speed.magnitudes();
    let corner = corner_frequency(model, real, fastest);
    let neglected = match (options.reduction, options.step) {
        (Some([displacement, _]), _) => NEGLECTED_SHARE * displacement,
        (None, Some(_)) => NEGLECTED_COUPLING * FIXED_STEP_RTOL,
        (None, None) => NEGLECTED_COUPLING * options.tolerance(),
    };
    let difference = (largest - slowest) / 2.0;
    let couplings = if difference > 0.0 {
        speed_couplings(model, real, CouplingChoice { corner, smallest: neglected / difference, all_circulatory })?
    } else {
        Vec::new()
    };
    Ok(SpeedChange {
        reference_speed: reference_speed(options),
        couplings,
        longest_rotation: match options.step {
            Some(_) => f64::INFINITY,
            None => rotation_of_longest_step(model),
        },
    })
}

/// Angular frequency up to which modes carry most of the motion, rad/s: that of the lowest mode, or of the fastest shaft.
/// With the frequencies of the teeth, couplings between high modes would displace those between the modes that move most.
fn corner_frequency(model: &Model, real: &RealModes, fastest: f64) -> f64 {
    let lowest = real.frequencies.iter().copied().find(|frequency| *frequency > 0.0).unwrap_or(1.0);
    (model.max_speed_ratio() * fastest.abs()).max(lowest)
}
