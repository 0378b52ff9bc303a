//! Interfaces of the linear motion: what loads act on and what is recorded.

use num_complex::Complex64;

use super::Options;
use crate::connection::{Connection, Row};
use crate::exponential::Selection;
use crate::model::Model;
use crate::motion::Speed;

/// Largest number of recorded coordinates whose static displacement under a load is kept.
const MAX_RECORDED: usize = 64;
/// Harmonics of the tooth meshing frequency, or of the rotation without teeth, that count as excited.
const HARMONICS: f64 = 10.0;

/// Loads on the interfaces as entries (index, coefficient): those of connections, along their lines of action and on each
/// coordinate, those of bearings and links, unit loads at recorded coordinates, and at a changing speed bow and unbalance.
pub(super) fn interfaces(model: &Model, options: &Options, selection: &Selection) -> Vec<Row> {
    let speed = options.fastest();
    let mut rows: Vec<Row> =
        model.connections(speed).flat_map(|connection: Connection<'_>| connection.rows()).collect();
    let mut single = model.coupled_coordinates(speed);
    if selection.displacements.len() <= MAX_RECORDED {
        single.extend_from_slice(&selection.displacements);
    }
    single.sort_unstable();
    single.dedup();
    rows.extend(single.into_iter().filter(|index| *index < model.len()).map(|index| vec![(index, 1.0)]));
    if matches!(options.speed, Speed::Changing(_)) {
        for shaft in model.shafts.iter().filter(|shaft| !shaft.excitations.is_empty()) {
            let amplitudes =
                shaft.excitations.iter().map(|given| (given.index, given.amplitude(shaft.ratio * speed, 0.0)));
            let amplitudes: Vec<(usize, Complex64)> = amplitudes.collect();
            rows.push(
                amplitudes.iter().flat_map(|(index, value)| [(*index, value.re), (index + 1, value.im)]).collect(),
            );
            rows.push(
                amplitudes.iter().flat_map(|(index, value)| [(*index, -value.im), (index + 1, value.re)]).collect(),
            );
        }
    }
    rows
}

/// Highest angular frequency that is excited, rad/s: of the gears on their mesh stiffness, or of the harmonics of the tooth
/// meshing frequency or of the rotation.
pub(super) fn excited_frequency(model: &Model, speed: f64) -> f64 {
    let order = model.max_mesh_order().max(model.max_speed_ratio());
    model.highest_mesh_frequency().max(HARMONICS * order * speed.abs())
}
