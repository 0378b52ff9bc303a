//! Interfaces of the linear motion: what loads act on and what is recorded.

use num_complex::Complex64;

use crate::connection::{Connection, Row};
use crate::exponential::Selection;
use crate::model::{Excitation, Model};

/// Largest number of recorded coordinates whose static displacement under a load is kept.
const MAX_RECORDED: usize = 128;
/// Harmonics of the tooth meshing frequency, or of the rotation without teeth, that count as excited.
const EXCITED_HARMONICS: f64 = 10.0;

/// Loads of local connections along their lines of action, as entries (index, coefficient); `speed` is that of the reference shaft,
/// rad/s.
pub(super) fn lines_of_action(model: &Model, speed: f64) -> Vec<Row> {
    model.connections(speed).filter(Connection::is_local).flat_map(|connection| connection.rows()).collect()
}

/// Loads on the coordinates and seats of connections, bearings and links, and on recorded coordinates.
pub(super) fn coordinate_loads(model: &Model, speed: f64, selection: &Selection) -> Vec<Row> {
    let recorded = &selection.displacements;
    let recorded = if recorded.len() <= MAX_RECORDED { &recorded[..] } else { &[] };
    model.coupled_loads(speed, recorded.iter().copied())
}

/// Loads of bows and of unbalances at two angles of each shaft, as entries (index, coefficient) over the displacements. At a
/// changing speed they act on the linear motion, which must carry them. Only their shape matters: they have the length 1, so
/// that variations of their size share a subspace.
pub(super) fn rotating_loads(model: &Model) -> Vec<Row> {
    let parts = [Excitation::steady_amplitude, |excitation: &Excitation| excitation.unbalance];
    let mut loads = Vec::new();
    for (shaft, part) in model.shafts.iter().flat_map(|shaft| parts.map(|part| (shaft, part))) {
        let size = shaft.excitations.iter().map(|excitation| part(excitation).norm_sqr()).sum::<f64>().sqrt();
        for angle in [Complex64::ONE, Complex64::I] {
            let entries = shaft.excitations.iter().flat_map(|excitation| {
                let load = part(excitation) * angle / size;
                [(excitation.index, load.re), (excitation.index + 1, load.im)]
            });
            if size > 0.0 {
                loads.push(entries.collect());
            }
        }
    }
    loads
}

/// Highest angular frequency that is excited, rad/s: of the gears on their mesh stiffness, or of the harmonics of the tooth
/// meshing frequency or of the rotation.
pub(super) fn excited_frequency(model: &Model, speed: f64) -> f64 {
    let order = model.max_mesh_order().max(model.max_speed_ratio());
    model.highest_mesh_frequency().max(EXCITED_HARMONICS * order * speed.abs())
}
