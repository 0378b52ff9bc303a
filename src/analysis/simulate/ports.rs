//! Ports of a reduced model: the scalars through which loads and signals reach the linear motion.

use num_complex::Complex64;

use super::modal_setup::ModalSetup;
use crate::connection::Connection;
use crate::exponential::Selection;
use crate::modal::Ports;
use crate::model::Model;
use crate::scene::Node;

/// Largest number of recorded coordinates whose static displacement under a load is kept exactly.
const MAX_RECORDED: usize = 128;
/// Weight of loads across the line of action relative to those along it.
const ACROSS: f64 = 0.03;

/// Scalars on which loads act or that are recorded, as entries (index, coefficient) over the displacements.
pub(super) fn interface(model: &Model, speed: f64, selection: &Selection) -> Vec<Vec<(usize, f64)>> {
    let mut scalars: Vec<_> =
        model.connections(speed).flat_map(|connection: Connection<'_>| connection.rows()).collect();
    if selection.displacements.len() <= MAX_RECORDED {
        scalars.extend(selection.displacements.iter().map(|index| vec![(*index, 1.0)]));
    }
    scalars
}

/// What the reduced motion carries: forces of connections, prescribed loads, recorded displacements, and the states in
/// which a run can begin.
pub(super) fn ports(model: &Model, setup: &ModalSetup<'_>, selection: &Selection) -> Ports {
    let ModalSetup { linear, loads, maps, .. } = setup;
    let along = |vectors: &[Vec<f64>], gradient: &[f64]| {
        let mut sum = vec![0.0; linear.len()];
        for (vector, factor) in vectors.iter().zip(gradient) {
            sum.iter_mut().zip(vector).for_each(|(sum, value)| *sum += factor * value);
        }
        sum
    };
    let (mut ports, mut of_connections) = (Ports::default(), Vec::new());
    for tangent in &maps.tangents {
        of_connections.push(along(&maps.columns[tangent.scalars.clone()], &tangent.gradient));
        ports.rows.push(vec![along(&maps.rows[tangent.scalars.clone()], &tangent.gradient)]);
    }
    for column in &maps.columns[..maps.scalars] {
        of_connections.push(column.iter().map(|value| ACROSS * value).collect());
    }
    // The gyroscopic couplings of a changing speed act on low modes, which every reduced model contains.
    ports.columns = vec![of_connections, maps.columns[maps.coupled_loads..].to_vec()];
    let recorded = |index: usize| selection.displacements.binary_search(&index).is_ok();
    let nodes = model.scene.shafts.iter().enumerate();
    for node in nodes.flat_map(|(shaft, given)| (0..given.nodes.len()).map(move |node| Node { shaft, node })) {
        if let Some(v) = model.numbering.translation(node).filter(|v| recorded(*v)) {
            ports.rows.push([v, v + 1].map(|index| linear.row(&[(index, 1.0)], false)).to_vec());
        }
        let single = model.numbering.twist(node).into_iter().chain(model.numbering.displacement_along(node));
        for index in single.filter(|index| recorded(*index)) {
            ports.rows.push(vec![linear.row(&[(index, 1.0)], false)]);
        }
    }
    for index in model.housings.coordinates().filter(|index| recorded(*index)) {
        ports.rows.push(vec![linear.row(&[(index, 1.0)], false)]);
    }
    let rest = vec![0.0; model.len()];
    ports.states.push(linear.state(model, loads.reference.as_slice(), &rest).as_slice().to_vec());
    for source in 0..loads.source_count() {
        for part in [|value: Complex64| value.re, |value: Complex64| value.im] {
            let values = |rate: bool| -> Vec<f64> {
                (0..model.len()).map(|index| part(loads.amplitude(source, index, rate))).collect()
            };
            ports.states.push(linear.state(model, &values(false), &values(true)).as_slice().to_vec());
        }
    }
    ports
}
