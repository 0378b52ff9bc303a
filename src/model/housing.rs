//! Inertia of supports and housings: one independent coordinate after another.

use std::ops::Range;

use super::{Model, Numbering};
use crate::connection::Row;
use crate::linalg::BandOrder;
use crate::scene::{Housing, Node, Scene};

/// Inertia of the coordinates of all supports and housings.
#[derive(Clone, Debug, Default)]
pub struct HousingInertia {
    /// Index, in the order of the core, of the first coordinate.
    pub start: usize,
    /// Mass, kg, or moment of inertia, kg m², of each coordinate.
    pub inertia: Vec<f64>,
}

impl HousingInertia {
    pub(super) fn new(scene: &Scene, numbering: &Numbering) -> Self {
        let start = numbering.end_of_shafts();
        let mut inertia = vec![0.0; numbering.len() - start];
        for (index, housing) in scene.housings.iter().enumerate() {
            let node = Node { shaft: scene.shafts.len() + index, node: 0 };
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
        Self { start, inertia }
    }

    /// Indices of the coordinates, in the order of the core.
    #[inline(always)]
    pub fn coordinates(&self) -> Range<usize> {
        self.start..self.start + self.inertia.len()
    }

    /// Order of the coordinates in a band matrix.
    pub fn band_order(&self) -> BandOrder {
        BandOrder { per_node: 1, nodes: self.inertia.len(), per_element: 0 }
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

    /// Displacement along the axis of a node of a shaft, or of a point of a housing at the distance `arm` (x, y, z) from its
    /// centre of mass; empty if it does not move along the axis.
    pub fn axial_row(&self, node: Node, arm: [f64; 3]) -> Row {
        axial_row(&self.scene, &self.numbering, node, arm)
    }
}

/// Displacement along the axis of a node of a shaft, u, or of the point of a housing at the distance `arm` (x, y, z) from its
/// centre of mass, u + B z − Γ y, as entries over the coordinates. It is empty in a scene without axial motion.
pub(super) fn axial_row(scene: &Scene, numbering: &Numbering, node: Node, [_, y, z]: [f64; 3]) -> Row {
    let mut row: Row = numbering.displacement_along(node).map(|index| (index, 1.0)).into_iter().collect();
    let housing = node.shaft.checked_sub(scene.shafts.len()).map(|index| &scene.housings[index]);
    let rotates = scene.axial && housing.is_some_and(|housing| housing.inertia.is_some());
    if let Some(first) = numbering.translation(node).filter(|_| rotates) {
        // The coordinates are Γ and −B.
        row.extend([(first + 2, -y), (first + 3, -z)]);
    }
    row
}

/// Displacements along y and z of the point of a housing at the distance `arm` (x, y, z) from its centre of mass, as
/// entries over the coordinates: v + Γ x − θ z and w − B x + θ y. `first` is the index of v of the housing.
pub fn point_rows(housing: &Housing, first: usize, [x, y, z]: [f64; 3]) -> [Row; 2] {
    let mut rows = [vec![(first, 1.0)], vec![(first + 1, 1.0)]];
    if housing.inertia.is_some() {
        rows[0].extend([(first + 2, x), (first + 4, -z)]);
        rows[1].extend([(first + 3, x), (first + 4, y)]);
    }
    rows
}
