//! Set-up of a run of the exponential method at a changing speed.
//!
//! One linear motion carries the whole run: the one at the middle Ω_ref of all speeds of the profile. It depends on the
//! profile only, so that a continued run has the same one. The gyroscopic difference ΔΩ = Ω − Ω_ref acts as loads.

use std::sync::Arc;

use nalgebra::DMatrix;

use super::super::AnalysisError;
use super::Options;
use super::initial::Start;
use super::longest_step::rotation_of_longest_step;
use crate::exponential::{InterfaceMaps, NonlinearLoads, SpeedChange};
use crate::mesh::Overlap;
use crate::modal::{CachedModel, ModalStateSpace, RealModes, gyroscopic_pairs};
use crate::model::Model;
use crate::motion::EquationOfMotion;
use crate::scene::SceneError;

/// A gyroscopic coupling is neglected if its acceleration, relative to that of the motion, is below this multiple of the
/// tolerance. Tolerances limit the error of a step; the error of a run is about ten times as large.
const NEGLECTED: f64 = 10.0;
/// Tolerance of the gyroscopic couplings with fixed steps.
const FIXED_TOLERANCE: f64 = 1e-10;

/// Linear motion, the loads on it, and the maps between both, in all modes.
pub(super) type Complete<'m> = (Arc<ModalStateSpace>, NonlinearLoads<'m>, InterfaceMaps);

/// Sets up a run of a motion.
pub(super) fn set_up<'m>(
    cached: &'m CachedModel,
    options: &Options,
    mut motion: EquationOfMotion<'m>,
    start: &Start,
) -> Result<Complete<'m>, AnalysisError> {
    // Modal damping and the linear motion contain the bearings at the largest speed.
    let fastest = options.fastest();
    let at_fastest = cached.at_speed(fastest)?;
    let [slowest, largest] = options.speed.magnitudes();
    let reference_speed = ((slowest + largest) / 2.0).copysign(fastest);
    motion.linearise_at(reference_speed);
    let linear = match motion.varying_flanks_can_separate() && options.modes.is_none() {
        true => at_fastest.linear_without_meshes(reference_speed)?,
        false => None,
    };
    let linear = linear.map_or_else(|| at_fastest.linear(reference_speed), Ok)?;
    let real = at_fastest.real_modes(fastest)?;
    let corner = corner_frequency(&cached.model, real, fastest);
    let tolerance = if options.step.is_some() { FIXED_TOLERANCE } else { options.tolerance() };
    let difference = (largest - slowest) / 2.0;
    let pairs = if difference > 0.0 {
        let smallest = NEGLECTED * tolerance * corner / difference;
        gyroscopic_pairs(&cached.model, real, corner, smallest)?
    } else {
        Vec::new()
    };
    let change = SpeedChange {
        reference_speed,
        bearing_speed: fastest,
        pairs,
        longest_rotation: match options.step {
            Some(_) => f64::INFINITY,
            None => rotation_of_longest_step(&cached.model),
        },
    };
    let synchronous = DMatrix::zeros(cached.model.len(), cached.model.shafts.len());
    let loads = NonlinearLoads::new(motion, &linear, start.equilibrium.clone(), &synchronous);
    let (mut nonlinear_loads, mut maps) = without_overlap(cached, loads)?;
    nonlinear_loads.add_changing_speed(&linear, &change, &mut maps);
    let (linear, maps) = match options.modes {
        Some(count) => keep_modes(cached, &linear, &nonlinear_loads, &maps, count)?,
        None => (linear, maps),
    };
    Ok((linear, nonlinear_loads, maps))
}

/// The loads, or the error of base circles that overlap.
pub(super) fn without_overlap<L>(cached: &CachedModel, loads: Result<L, (usize, Overlap)>) -> Result<L, AnalysisError> {
    loads.map_err(|(mesh, overlap)| {
        let [driver, driven] = cached.model.gear_names(mesh);
        AnalysisError::overlap(driver, driven, "at the beginning", overlap)
    })
}

/// Angular frequency up to which modes carry most of the motion, rad/s: that of the lowest mode, or of the fastest shaft.
/// With the frequencies of the teeth, couplings between high modes would displace those between the modes that move most.
fn corner_frequency(model: &Model, real: &RealModes, fastest: f64) -> f64 {
    let lowest = real.frequencies.iter().copied().find(|frequency| *frequency > 0.0).unwrap_or(1.0);
    (model.max_speed_ratio() * fastest.abs()).max(lowest)
}

/// Reduces the linear motion and its maps to the modes that the loads excite most. The equilibrium and the synchronous
/// motion keep all modes.
fn keep_modes(
    cached: &CachedModel,
    linear: &ModalStateSpace,
    nonlinear_loads: &NonlinearLoads<'_>,
    maps: &InterfaceMaps,
    count: usize,
) -> Result<(Arc<ModalStateSpace>, InterfaceMaps), AnalysisError> {
    let constant: Vec<(usize, f64)> = cached.model.constant_load.iter().copied().enumerate().collect();
    let motion = &nonlinear_loads.motion;
    let rotating = motion.sources().flat_map(|shaft| motion.rotating_forces(shaft));
    let other = rotating.chain([constant]).map(|load| linear.column(&load));
    // Modes are not chosen for the loads by which a changing speed couples them.
    let acting = maps.columns[..maps.scalars].iter().chain(&maps.columns[maps.meshes..]);
    let loads: Vec<Vec<f64>> = acting.cloned().chain(other).collect();
    let slots = linear.most_excited(&loads, count);
    let Some(kept) = linear.select_pairs(&slots) else {
        let message = format!("cannot be left out: they do not carry the motion, condition {:.1e}", linear.condition);
        return Err(SceneError::new("modes", message).into());
    };
    let pick = |row: &Vec<f64>| kept.select_entries(row, &slots);
    let [rows, columns] = [&maps.rows, &maps.columns].map(|list| list.iter().map(pick).collect());
    let maps = InterfaceMaps { rows, columns, parts: kept.parts.clone(), ..maps.clone() };
    Ok((Arc::new(kept), maps))
}
