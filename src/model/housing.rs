//! Inertia of supports and housings: one independent coordinate after another.

use std::ops::Range;

use super::{Model, Numbering};
use crate::connection::Row;
use crate::scene::description::ElasticBody;
use crate::scene::{Attachment, Housing, HousingPoint, Node, Scene};

/// Inertia of the coordinates of all supports and housings.
#[derive(Clone, Debug, Default)]
pub struct HousingInertia {
    /// Index, in the order of the core, of the first coordinate.
    pub start: usize,
    /// Mass, kg, or moment of inertia, kg m², of each coordinate.
    pub inertia: Vec<f64>,
    /// Indices, in the order of the core, of the modes of each elastic housing. No entry of a matrix of its own couples them.
    pub modes: Vec<Range<usize>>,
}

impl HousingInertia {
    pub(super) fn new(scene: &Scene, numbering: &Numbering) -> Self {
        let start = numbering.end_of_shafts();
        let (mut inertia, mut own_modes) = (vec![0.0; numbering.len() - start], Vec::new());
        for (index, housing) in scene.housings.iter().enumerate() {
            let node = Node { shaft: scene.shafts.len() + index, node: 0 };
            if let Some(modes) = numbering.modes(node) {
                inertia[modes.start - start..modes.end - start].fill(1.0);
                own_modes.push(modes);
            }
            let Some(first) = numbering.translation(node) else { continue };
            let own = &mut inertia[first - start..];
            own[..2].fill(housing.mass);
            if let Some([x, y, z]) = housing.inertia {
                own[2..5].copy_from_slice(&[z, y, x]);
            }
            if let Some(along) = numbering.displacement_along(node) {
                inertia[along - start] = housing.mass;
            }
        }
        Self { start, inertia, modes: own_modes }
    }

    /// Indices of the coordinates, in the order of the core.
    #[inline(always)]
    pub fn coordinates(&self) -> Range<usize> {
        self.start..self.start + self.inertia.len()
    }

    /// Whether a coordinate, in the order of the core, is a mode of an elastic housing.
    pub fn is_mode(&self, index: usize) -> bool {
        self.modes.iter().any(|modes| modes.contains(&index))
    }

    /// The parts of a row: single coordinates, and all entries over the modes of one elastic housing.
    pub fn parts<'r>(&'r self, row: &'r [(usize, f64)]) -> impl Iterator<Item = &'r [(usize, f64)]> {
        row.chunk_by(|(a, _), (b, _)| self.modes.iter().any(|modes| modes.contains(a) && modes.contains(b)))
    }

    /// `out += M x`.
    pub fn multiply_mass(&self, x: &[f64], out: &mut [f64]) {
        let range = self.coordinates();
        for ((out, x), inertia) in out[range.clone()].iter_mut().zip(&x[range]).zip(&self.inertia) {
            *out += inertia * x;
        }
    }

    /// `x ← M⁻¹ x`.
    #[inline(always)]
    pub fn solve_mass(&self, x: &mut [f64]) {
        for (x, inertia) in x[self.coordinates()].iter_mut().zip(&self.inertia) {
            *x /= inertia;
        }
    }

    /// vᵀMv, J.
    pub fn kinetic_form(&self, v: &[f64]) -> f64 {
        v[self.coordinates()].iter().zip(&self.inertia).map(|(v, inertia)| inertia * v * v).sum()
    }
}

impl Model {
    /// Nodes of supports and housings.
    pub fn housing_nodes(&self) -> impl Iterator<Item = Node> + use<> {
        let shafts = self.scene.shafts.len();
        (0..self.scene.housings.len()).map(move |index| Node { shaft: shafts + index, node: 0 })
    }

    /// Index, in the order of the core, of the first mode of each elastic housing, and its modes.
    pub fn elastic_housings(&self) -> impl Iterator<Item = (usize, &ElasticBody)> {
        self.housing_nodes()
            .zip(&self.scene.housings)
            .filter_map(|(node, housing)| Some((self.numbering.modes(node)?.start, housing.elastic.as_ref()?)))
    }
}

/// Node and place of the housing on which a support stands; `None` for the ground.
pub(super) fn base_of(scene: &Scene, housing: &Housing) -> Option<(Node, HousingPoint)> {
    let Some(Attachment::Housing { housing, point }) = housing.attachment else { return None };
    Some((Node { shaft: scene.shafts.len() + housing, node: 0 }, point))
}

/// Rotations of a point of a housing about z, Γ, and about y, −B, as entries over the coordinates; `None` if it does not rotate. A
/// support rotates with the housing on which it stands.
pub(super) fn slope_rows(scene: &Scene, numbering: &Numbering, node: Node, point: HousingPoint) -> Option<[Row; 2]> {
    let housing = &scene.housings[node.shaft - scene.shafts.len()];
    if let (Some(rows), Some(modes)) = (interface_rows(housing, point), numbering.modes(node)) {
        return Some([modal_row(&rows[5], modes.start, 1.0), modal_row(&rows[4], modes.start, -1.0)]);
    }
    if let Some((node, point)) = base_of(scene, housing) {
        return slope_rows(scene, numbering, node, point);
    }
    let first = numbering.translation(node).filter(|_| housing.inertia.is_some())?;
    Some([vec![(first + 2, 1.0)], vec![(first + 3, 1.0)]])
}

/// Rows of an interface of an elastic housing over its modes.
fn interface_rows(housing: &Housing, point: HousingPoint) -> Option<&[Vec<f64>; 6]> {
    let HousingPoint::Interface(index) = point else { return None };
    housing.elastic.as_ref()?.interfaces.values().nth(index).map(|interface| &interface.rows)
}

/// A row over modes as entries over the coordinates, of which the first mode has the index `start`.
pub(super) fn modal_row(row: &[f64], start: usize, sign: f64) -> Row {
    let entries = row.iter().enumerate().filter(|(_, value)| **value != 0.0);
    entries.map(|(mode, value)| (start + mode, sign * value)).collect()
}

/// Displacement along the axis of a point of a housing, u + B z − Γ y at the distance (x, y, z) from the centre of mass of a rigid
/// one, as entries over the coordinates. It is empty in a scene without axial motion. A support without a coordinate of its own moves
/// with the housing on which it stands.
pub(super) fn axial_row(scene: &Scene, numbering: &Numbering, node: Node, point: HousingPoint) -> Row {
    let housing = &scene.housings[node.shaft - scene.shafts.len()];
    if let (Some(rows), Some(modes)) = (interface_rows(housing, point), numbering.modes(node)) {
        return if scene.axial { modal_row(&rows[0], modes.start, 1.0) } else { Row::new() };
    }
    if let (Some((node, point)), None) = (base_of(scene, housing), numbering.displacement_along(node)) {
        return axial_row(scene, numbering, node, point);
    }
    let HousingPoint::Arm([_, y, z]) = point else { return Row::new() };
    let mut row: Row = numbering.displacement_along(node).map(|index| (index, 1.0)).into_iter().collect();
    let rotates = scene.axial && housing.inertia.is_some();
    if let Some(first) = numbering.translation(node).filter(|_| rotates) {
        // The coordinates are Γ and −B.
        row.extend([(first + 2, -y), (first + 3, -z)]);
    }
    row
}

/// Displacements along y and z of a point of a housing as entries over the coordinates: v + Γ x − θ z and w − B x + θ y at the
/// distance (x, y, z) from the centre of mass of a rigid one. `None` without lateral motion.
pub fn point_rows(scene: &Scene, numbering: &Numbering, node: Node, point: HousingPoint) -> Option<[Row; 2]> {
    let housing = &scene.housings[node.shaft - scene.shafts.len()];
    if let (Some(rows), Some(modes)) = (interface_rows(housing, point), numbering.modes(node)) {
        return Some([1, 2].map(|axis| modal_row(&rows[axis], modes.start, 1.0)));
    }
    let HousingPoint::Arm([x, y, z]) = point else { return None };
    let first = numbering.translation(node)?;
    let mut rows = [vec![(first, 1.0)], vec![(first + 1, 1.0)]];
    if housing.inertia.is_some() {
        rows[0].extend([(first + 2, x), (first + 4, -z)]);
        rows[1].extend([(first + 3, x), (first + 4, y)]);
    }
    Some(rows)
}

/// Rotation about the axis of a point of a housing as entries over the coordinates; `None` if it does not rotate.
pub(super) fn roll_row(scene: &Scene, numbering: &Numbering, node: Node, point: HousingPoint) -> Option<Row> {
    let housing = &scene.housings[node.shaft - scene.shafts.len()];
    if let (Some(rows), Some(modes)) = (interface_rows(housing, point), numbering.modes(node)) {
        return Some(modal_row(&rows[3], modes.start, 1.0));
    }
    numbering.twist(node).map(|index| vec![(index, 1.0)])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_modes_of_a_housing_are_one_part_of_a_row() {
        let housings = HousingInertia { start: 2, inertia: vec![1.0; 7], modes: vec![3..6, 6..9] };
        let row = [(0, 1.0), (1, 1.0), (2, 1.0), (3, 0.5), (5, 0.2), (6, 1.0), (8, 1.0)];
        let sizes: Vec<usize> = housings.parts(&row).map(<[_]>::len).collect();
        assert_eq!(sizes, [1, 1, 1, 2, 2]);
    }
}
