//! The longest step of the exponential method, which resolves the rotation of shafts and teeth.

use std::f64::consts::TAU;

use crate::mesh::GearMesh;
use crate::model::Model;
use crate::scene::LoadLaw;

/// Smallest number of steps per revolution, per period of the slowest mode, and per tooth whose force depends on its
/// position.
pub(super) const STEPS_PER_CYCLE: f64 = 8.0;
/// Smallest number of steps per tooth whose stiffness is constant while it is engaged.
const STEPS_PER_TOOTH: f64 = 2.0;
/// Steps per revolution where bow and unbalance act as loads, in multiples of [`STEPS_PER_CYCLE`].
pub(super) const RESONANT_FACTOR: f64 = 8.0;

/// Largest number of intervals of a time series in one step, so that no step misses a pulse.
const MAX_SERIES_INTERVALS: f64 = 4.0;

/// Angular frequency of shafts, teeth, rolling elements and loads at a speed, rad/s, that the longest step resolves; `turning` is the number of steps
/// per revolution in multiples of [`STEPS_PER_CYCLE`].
pub(super) fn excitation_frequency(model: &Model, speed: f64, turning: f64) -> f64 {
    let speed = speed.abs();
    let turning = model.max_speed_ratio() * speed * turning;
    let travelling = model.max_mesh_order_of(GearMesh::depends_on_tooth_position) * speed;
    let engaging = model.max_mesh_order_of(GearMesh::switches) * speed * STEPS_PER_TOOTH / STEPS_PER_CYCLE;
    let loads = model.loads.iter().map(|load| match &load.law {
        LoadLaw::Turning { order, .. } => (order * load.ratio * speed).abs(),
        LoadLaw::Force([curve, _]) | LoadLaw::Torque(curve) => {
            TAU / (STEPS_PER_CYCLE * MAX_SERIES_INTERVALS * curve.mean_spacing())
        }
        LoadLaw::SpeedTorque { .. } => 0.0,
    });
    let passing = model
        .nonlinear_bearings
        .iter()
        .filter_map(|bearing| bearing.elements().map(|count| (count as f64 * bearing.ratio * speed).abs()));
    loads.chain(passing).fold(turning.max(travelling).max(engaging), f64::max)
}

/// Rotation of the reference shaft within the longest step at a changing speed, rad.
pub(super) fn rotation_of_longest_step(model: &Model) -> f64 {
    TAU / (STEPS_PER_CYCLE * excitation_frequency(model, 1.0, RESONANT_FACTOR))
}
