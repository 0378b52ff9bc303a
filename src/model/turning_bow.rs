//! Bows that turn with the twist of their shafts: the scalars of each.

use num_complex::Complex64;

use super::free_rotation::entries;
use super::{Excitation, Model, ShaftModel};
use crate::connection::{Row, TurningBow};
use crate::element::Elastic;
use crate::linalg::load;

/// Whether the bow of a shaft exerts a force.
pub fn is_bowed(shaft: &ShaftModel) -> bool {
    shaft.excitations.iter().any(|excitation| excitation.bow != Complex64::ZERO)
}

/// Real and imaginary part of (K_s b)ᴴu as entries over the displacements, with the bow b and u = v + iw.
pub fn bow_force(shaft: &ShaftModel) -> [Row; 2] {
    let (mut real, mut imaginary) = (Row::new(), Row::new());
    for Excitation { index, bow, .. } in &shaft.excitations {
        real.extend([(*index, bow.re), (*index + 1, bow.im)]);
        imaginary.extend([(*index, -bow.im), (*index + 1, bow.re)]);
    }
    [real, imaginary]
}

impl Model {
    /// The bows that turn with the twist: one for each bowed shaft with torsion, in the order of the shafts; none if the scene
    /// leaves their torque out.
    pub(super) fn turning_bows(&self) -> Vec<TurningBow> {
        if !self.scene.bow_torque {
            return Vec::new();
        }
        let bow = |(shaft, model): (usize, &ShaftModel)| {
            let twist = self.bow_twist(shaft)?;
            let force = model.excitations.iter().fold(0.0_f64, |size, excitation| size.hypot(excitation.bow.norm()));
            let [real, imaginary] = bow_force(model).map(|row| divided(row, force));
            Some(TurningBow { shaft, turning: self.in_frame(shaft), force, rows: [real, imaginary, twist] })
        };
        self.shafts.iter().enumerate().filter(|(_, shaft)| is_bowed(shaft)).filter_map(bow).collect()
    }

    /// The twist θ with which the bow of a shaft turns, as entries over the displacements; none without torsion.
    ///
    /// It is the mean over the shaft, weighted by the strain energy of the straightened bow. If nothing holds the rotation, it is
    /// relative to the rigid-body rotation of the train: the drive prescribes this rotation and supplies the power that bearings
    /// dissipate in the whirl, as it does for unbalance. No mesh force depends on the rigid-body rotation.
    fn bow_twist(&self, shaft: usize) -> Option<Row> {
        let (model, start) = (&self.shafts[shaft], self.numbering.torsion(shaft)?);
        let (chain, bow) = (model.bending.as_ref()?, model.bow.as_ref()?);
        // Relative to the largest value, whose square may underflow.
        let largest = bow.iter().map(|value| value.norm()).fold(0.0, f64::max);
        let lanes: Vec<f64> = bow.iter().flat_map(|value| [value.re / largest, value.im / largest]).collect();
        let mut weights = vec![0.0; chain.nodes];
        for (node, element) in chain.elements.iter().enumerate() {
            let strain = element.quadratic_form::<2>(&load(&lanes, node), &load(&lanes, node + 1));
            weights[node] += strain;
            weights[node + 1] += strain;
        }
        if weights.iter().all(|weight| *weight == 0.0) {
            // The nodes of an element without internal coordinates may lie on a line.
            weights.fill(1.0);
        }
        let sum: f64 = weights.iter().sum();
        let mean: Row = weights.iter().enumerate().map(|(node, weight)| (start + node, weight / sum)).collect();
        let Some(rotation) = self.free_rotation(shaft) else {
            return Some(mean);
        };
        let mut twist: Vec<f64> = self.inertia_shares(&rotation).into_iter().map(|share| -share).collect();
        // The rotation has the value 1 on this shaft.
        mean.iter().for_each(|(index, weight)| twist[*index] += weight);
        Some(entries(twist))
    }
}

fn divided(row: Row, size: f64) -> Row {
    row.into_iter().map(|(index, coefficient)| (index, coefficient / size)).collect()
}
