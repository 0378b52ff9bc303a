//! Motion of any place: at a node, between the nodes of a shaft by the shape functions of its element, on a support or a
//! point of a housing.
//!
//! A force at a place acts on the same coordinates with the same factors.

use super::housing::{axial_row, point_rows, roll_row};
use super::{Model, Numbering};
use crate::connection::Row;
use crate::element::{BendingShape, PlaceShape};
use crate::scene::{EntryPath, HousingPoint, Node, Scene, SceneError, Shaft, description, nearest};

/// Motion of a place as entries (index of a coordinate, factor).
#[derive(Clone, Debug, PartialEq)]
pub struct PlaceRows {
    /// Displacements v and w, m; `None` without lateral motion.
    pub displacement: Option<[Row; 2]>,
    /// Rotations Γ and −B of a shaft, rad; `None` without lateral motion, and on a housing.
    pub rotation: Option<[Row; 2]>,
    /// Twist θ, rad; `None` without torsion.
    pub twist: Option<Row>,
    /// Axial displacement u, m; `None` without axial motion.
    pub axial: Option<Row>,
}

impl PlaceRows {
    /// Indices of the coordinates.
    pub fn coordinates(&self) -> impl Iterator<Item = usize> + '_ {
        let rows = self.displacement.iter().flatten().chain(&self.twist).chain(&self.axial);
        rows.flatten().map(|(index, _)| *index)
    }

    /// The motion at a position of shaft `index`, m.
    ///
    /// # Errors
    /// [`SceneError`] at `at` beyond the ends of the shaft.
    pub(crate) fn on_shaft(
        scene: &Scene,
        numbering: &Numbering,
        index: usize,
        position: f64,
        at: &EntryPath<'_>,
    ) -> Result<Self, SceneError> {
        let shaft = &scene.shafts[index];
        match shaft.node_at(position) {
            Some(node) => Ok(node_rows(numbering, Node { shaft: index, node })),
            None => Ok(between_nodes(scene, numbering, index, element_at(shaft, position, at)?)),
        }
    }
}

impl Model {
    /// The displacements of the place `place`, which the entry `at` contains.
    ///
    /// # Errors
    /// [`SceneError`] at `at` if there is no such place.
    pub(crate) fn place_rows(&self, place: &description::Place, at: &EntryPath<'_>) -> Result<PlaceRows, SceneError> {
        let scene = &self.scene;
        match place {
            description::Place::Body(name) => match (scene.body(name), scene.housing_point(name)) {
                (Some(body), _) => Ok(self.node_rows(body.node)),
                (None, Some((node, point))) => Ok(self.housing_rows(node, point)),
                (None, None) => {
                    let names = scene.bodies().map(|body| body.name.as_str()).chain(scene.housing_names());
                    let hint = if scene.shaft(name).is_some() {
                        format!("; it is a shaft: write (\"{name}\", x) with the position x on it, m")
                    } else {
                        nearest(name, names)
                    };
                    Err(at.error(format!("no gear, disk, support or housing is called \"{name}\"{hint}")))
                }
            },
            description::Place::Shaft(name, position) => {
                if let Some((node, point)) = scene.housing_point(name) {
                    return Ok(self.housing_rows(node, point));
                }
                PlaceRows::on_shaft(scene, &self.numbering, scene.known_shaft(name, at)?, *position, at)
            }
        }
    }

    /// The motion of a node of a shaft.
    pub fn node_rows(&self, node: Node) -> PlaceRows {
        node_rows(&self.numbering, node)
    }

    /// The displacements of a point of a housing.
    pub fn housing_rows(&self, node: Node, point: HousingPoint) -> PlaceRows {
        let axial = axial_row(&self.scene, &self.numbering, node, point);
        PlaceRows {
            displacement: point_rows(&self.scene, &self.numbering, node, point),
            rotation: None,
            twist: roll_row(&self.scene, &self.numbering, node, point),
            axial: (!axial.is_empty()).then_some(axial),
        }
    }
}

/// The motion of a node of a shaft.
fn node_rows(numbering: &Numbering, node: Node) -> PlaceRows {
    let row = |index| vec![(index, 1.0)];
    let first = numbering.translation(node);
    PlaceRows {
        displacement: first.map(|v| [row(v), row(v + 1)]),
        rotation: first.map(|v| [row(v + 2), row(v + 3)]),
        twist: numbering.twist(node).map(row),
        axial: numbering.displacement_along(node).map(row),
    }
}

/// A place within an element.
pub(super) struct Within {
    /// Index of the element.
    pub element: usize,
    /// x/l, the share of the length of the element.
    pub xi: f64,
}

/// The element at a position, m.
pub(super) fn element_at(shaft: &Shaft, position: f64, at: &EntryPath<'_>) -> Result<Within, SceneError> {
    let inside = |ends: &[f64]| (ends[0]..=ends[1]).contains(&position);
    let element = shaft.nodes.windows(2).position(inside).ok_or_else(|| {
        let end = shaft.nodes.last().copied().unwrap_or_default();
        at.error(format!(
            "shaft \"{}\" reaches from 0 to {end} m; give a position on it in metres, got {position} m",
            shaft.name
        ))
    })?;
    Ok(Within { element, xi: (position - shaft.nodes[element]) / (shaft.nodes[element + 1] - shaft.nodes[element]) })
}

/// The motion within an element of shaft `index`.
fn between_nodes(scene: &Scene, numbering: &Numbering, index: usize, Within { element, xi }: Within) -> PlaceRows {
    let shaft = &scene.shafts[index];
    let shape = PlaceShape::new(&shaft.elements[element], shaft.shear, shaft.degree, xi);
    let nodes = shaft.nodes.len();
    let bending = |start: usize, shape: &BendingShape| {
        let lane = |lane: usize| {
            // (u, φ) of a node has the coordinates (v, w, Γ, −B).
            let nodal = shape.nodal.iter().enumerate();
            let nodal = nodal.map(|(i, factor)| (start + 4 * element + 2 * i + lane, *factor));
            let first = start + 4 * nodes + 2 * shape.internal.len() * element;
            let internal = shape.internal.iter().enumerate();
            nodal.chain(internal.map(|(i, factor)| (first + 2 * i + lane, *factor))).collect()
        };
        [lane(0), lane(1)]
    };
    let rod = |start: usize, ends: [f64; 2]| {
        let first = start + nodes + shape.rod.len() * element;
        let [left, right] = ends;
        let nodal = [(start + element, left), (start + element + 1, right)];
        nodal.into_iter().chain(shape.rod.iter().enumerate().map(|(i, factor)| (first + i, *factor))).collect()
    };
    PlaceRows {
        displacement: numbering.lateral(index).map(|start| bending(start, &shape.displacement)),
        rotation: numbering.lateral(index).map(|start| bending(start, &shape.rotation)),
        twist: numbering.torsion(index).map(|start| rod(start, shape.torsion)),
        axial: numbering.axial(index).map(|start| rod(start, shape.axial)),
    }
}
