//! Residual bow of a shaft: its stress-free shape b(x), in coordinates that rotate with the shaft.
//!
//! u = b(x) and φ = b'(x), complex with the real part in the y direction and the imaginary part in the z direction at
//! shaft angle zero. The force of the bow is K_s b. The shape has no shear strain, so that the forces on the internal
//! coordinates are ∫EI φ_i' b'' dx, with the curvature φ_i' of their shape functions. The internal coordinates of the
//! shape are K_ii⁻¹ times these forces: the shape of the elements that is closest to b(x) in strain energy.

use std::convert::Infallible;

use nalgebra::{DMatrix, Vector4};
use num_complex::Complex64;

use crate::element::{BendingFunction, GAUSS_POINTS, Section, deflection};
use crate::linalg::ChainMatrix;
use crate::numerics::{EQUALITY_TOLERANCE, Sample, gauss, maximum};
use crate::scene::{Bow, BowCurve, Element, RIGID, Scene, SceneError, Shaft};

/// Number of parts of an element between whose ends the largest deflection is searched.
const DEFLECTION_SAMPLES: usize = 16;

/// u, m, and φ, rad, at the nodes of shaft `index`, then the internal coordinates of bending; `None` for a straight shaft.
///
/// `mass` is the mass matrix of bending, including the bodies on the shaft.
pub(super) fn shape(
    scene: &Scene,
    index: usize,
    mass: &ChainMatrix<2>,
    stiffness: &ChainMatrix<2>,
) -> Result<Option<Vec<Complex64>>, SceneError> {
    let shaft = &scene.shafts[index];
    match &shaft.bow {
        None => Ok(None),
        Some(Bow::Curve(curve)) => Ok(Some(shape_of_curve(shaft, curve, stiffness))),
        Some(Bow::Sag { amplitude }) => {
            let sag = unit_sag(scene, index, mass, stiffness)?;
            Ok(Some(sag.iter().map(|value| *amplitude * *value).collect()))
        }
    }
}

/// (u, φ) of a curve at the nodes, then its internal coordinates.
fn shape_of_curve(shaft: &Shaft, curve: &BowCurve, stiffness: &ChainMatrix<2>) -> Vec<Complex64> {
    let mut shape = Vec::with_capacity(stiffness.len());
    for x in &shaft.nodes {
        let (deflection, slope) = curve.at(*x);
        shape.extend([deflection, slope]);
    }
    let rule = if stiffness.internal.is_empty() { Vec::new() } else { gauss(GAUSS_POINTS) };
    for (element, blocks) in stiffness.internal.iter().enumerate() {
        shape.extend(internal(shaft, curve, element, &rule, &blocks.block));
    }
    shape
}

/// Internal coordinates of bending of one element of a shaft, for the curve of a bow. `rule` holds points and weights on
/// (0, 1), `stiffness` is the stiffness matrix of these coordinates.
fn internal(
    shaft: &Shaft,
    curve: &BowCurve,
    element: usize,
    rule: &[(f64, f64)],
    stiffness: &DMatrix<f64>,
) -> Vec<Complex64> {
    let functions = BendingFunction::all(shaft.degree, shaft.shear);
    let (start, length) = (shaft.nodes[element], shaft.elements[element].length);
    let mut forces = DMatrix::<f64>::zeros(functions.len(), 2);
    for piece in curve.pieces(start, start + length).windows(2) {
        for (at, weight) in rule {
            let x = piece[0] + at * (piece[1] - piece[0]);
            let rigidity = Section::at(&shaft.elements[element], false, (x - start) / length).flexural;
            let moment = curve.curvature(x) * (rigidity * weight * (piece[1] - piece[0]));
            for (i, function) in functions.iter().enumerate() {
                let shape = function.curvature(2.0 * (x - start) / length - 1.0, length);
                forces[(i, 0)] += shape * moment.re;
                forces[(i, 1)] += shape * moment.im;
            }
        }
    }
    // The stiffness is positive definite: no internal shape function is free of strain.
    let solution = stiffness.clone().cholesky().map_or(forces.clone(), |factor| factor.solve(&forces));
    solution.row_iter().map(|row| Complex64::new(row[0], row[1])).collect()
}

/// (u, φ) of the sag under the weight of the shaft and its bodies on rigid bearings, with a largest
/// deflection of 1.
///
/// Bearings are rigid because run-out is measured relative to the line through the bearings. The rigid-body part of a
/// bow exerts no force.
fn unit_sag(
    scene: &Scene,
    index: usize,
    mass: &ChainMatrix<2>,
    stiffness: &ChainMatrix<2>,
) -> Result<Vec<f64>, SceneError> {
    let shaft = &scene.shafts[index];
    let undefined = |message: &str| SceneError::new(format!("shafts[{index}].bow"), message);
    let mut bearings: Vec<usize> = scene.held_nodes(index).map(|(_, node)| node).collect();
    bearings.sort_unstable();
    bearings.dedup();
    if bearings.len() < 2 {
        return Err(undefined(
            "a sag needs bearings at two positions of the shaft; add a bearing or choose another shape",
        ));
    }
    let mut largest: f64 = 0.0;
    stiffness.nodal.for_each(|row, column, value| {
        if row == column && row % 2 == 0 {
            largest = largest.max(value);
        }
    });
    let mut supported = stiffness.clone();
    for node in &bearings {
        supported.nodal.add_at_node(*node, 0, 0, RIGID * largest);
    }
    let factor =
        supported.factor().map_err(|_| undefined("the sag is lost to round-off; give the bow by points instead"))?;
    let mut translation: Vec<f64> = (0..shaft.nodes.len()).flat_map(|_| [1.0, 0.0]).collect();
    translation.resize(stiffness.len(), 0.0);
    let mut sag = vec![0.0; translation.len()];
    mass.multiply_add::<1>(1.0, &translation, &mut sag);
    factor.solve::<1>(&mut sag);
    let largest = largest_deflection(shaft, &sag);
    Ok(sag.iter().map(|value| value / largest).collect())
}

/// Largest deflection of a shaft under its own weight, with the displacements (u, φ) of its nodes, m. It can lie within an
/// element.
fn largest_deflection(shaft: &Shaft, nodes: &[f64]) -> f64 {
    let within = |(index, element): (usize, &Element)| {
        let ends = Vector4::from_column_slice(&nodes[2 * index..2 * index + 4]);
        let at = |xi: f64| deflection(element, shaft.shear, ends, xi).abs();
        let point = |i: usize| i as f64 / DEFLECTION_SAMPLES as f64;
        let best = (0..=DEFLECTION_SAMPLES).max_by(|a, b| at(point(*a)).total_cmp(&at(point(*b)))).unwrap_or_default();
        // Between two samples the deflection has one maximum.
        let ends = [best.saturating_sub(1), (best + 1).min(DEFLECTION_SAMPLES)].map(point);
        let found: Result<Sample, Infallible> = maximum(ends[0], ends[1], EQUALITY_TOLERANCE, |xi| Ok(at(xi)));
        found.map_or(0.0, |top| top.value).max(at(point(best)))
    };
    shaft.elements.iter().enumerate().map(within).fold(0.0, f64::max)
}
