//! Undamped modes of a large model from those of its components (component mode synthesis; Craig and Bampton 1968,
//! MacNeal 1971, Rubin 1975).
//!
//! Without meshes the model consists of uncoupled components: the torsion of each shaft, and its bending, in each plane
//! where no bearing couples the planes. Their modes are small problems. The modes below a frequency limit are kept. The
//! static displacements under unit loads at the interface coordinates are kept exactly: the part that the omitted modes
//! contribute to them (residual flexibility) becomes a shape of its own. For a given frequency the omitted dynamics decrease
//! with the fourth power of frequency over limit. Under sharp tooth engagement, whose load is a step, the error decreases
//! with the square of the limit.

use nalgebra::{DMatrix, DVector};

use super::real::{RealModes, rigid_body_modes, rigid_motions, spring_deflections};
use crate::linalg::{DecompositionError, symmetric_pencil};
use crate::model::Model;

/// A shape whose part independent of the other shapes is below this fraction is left out.
const DEPENDENT: f64 = 1e-8;

/// Undamped modes in the subspace of the component modes up to `limit`, rad/s, and of the static displacements under
/// loads at the coordinates `loaded`; with the loaded tooth flanks of `speed` (reference shaft, rad/s).
pub(super) fn modes_of_components(
    model: &Model,
    speed: f64,
    loaded: &[usize],
    limit: f64,
) -> Result<RealModes, DecompositionError> {
    let mass = model.mass_matrix();
    let kinetic = |motions: &DMatrix<f64>| motions.transpose() * &mass * motions;
    let stiffness = model.shaft_stiffness_matrix() + model.symmetric_part_matrix();
    let (rigid, deflections) = (rigid_motions(model), spring_deflections(model, None));
    let mut shapes: Vec<DVector<f64>> = Vec::new();
    for component in components(&mass, &stiffness) {
        let member = |index: usize| component.binary_search(&index).is_ok();
        let inside = |column: &usize| (0..model.len()).all(|row| rigid[(row, *column)] == 0.0 || member(row));
        let own: Vec<usize> = (0..rigid.ncols()).filter(inside).collect();
        let null = rigid_body_modes(&rigid.select_columns(&own), &deflections, kinetic)?.select_rows(&component);
        let block = |matrix: &DMatrix<f64>| matrix.select_rows(&component).select_columns(&component);
        let pencil = symmetric_pencil(&block(&stiffness), &block(&mass), &null)?;
        let local = |index: &usize| component.binary_search(index).ok();
        let loaded: Vec<usize> = loaded.iter().filter_map(local).collect();
        let kept = null.ncols().max(pencil.values.iter().take_while(|value| **value <= limit * limit).count());
        let basis = component_shapes(&pencil.values, &pencil.vectors, kept, &loaded);
        for column in basis.column_iter() {
            let mut shape = DVector::zeros(model.len());
            component.iter().zip(column.iter()).for_each(|(index, value)| shape[*index] = *value);
            shapes.push(shape);
        }
    }
    let basis = DMatrix::from_columns(&shapes);
    let null = rigid_body_modes(&rigid, &spring_deflections(model, Some(speed)), kinetic)?;
    let stiffness = stiffness + model.connection_stiffness_matrix(speed);
    let projected = basis.tr_mul(&(stiffness * &basis));
    let known = basis.tr_mul(&(&mass * &null));
    let size = basis.ncols();
    let mut vectors = &basis * symmetric_pencil(&projected, &DMatrix::identity(size, size), &known)?.vectors;
    vectors.columns_mut(0, null.ncols()).copy_from(&null);
    Ok(RealModes::of_shapes(model, speed, vectors, null.ncols()))
}

/// The first `kept` modes of a component, and the residual flexibility of the others at the coordinates `loaded`, all
/// orthonormal in M; `values` are ω².
fn component_shapes(values: &DVector<f64>, modes: &DMatrix<f64>, kept: usize, loaded: &[usize]) -> DMatrix<f64> {
    let omitted = values.len() - kept;
    let mut residuals: Vec<DVector<f64>> = Vec::new();
    for index in loaded {
        let flexibility = |mode: usize| modes[(*index, kept + mode)] / values[kept + mode];
        let mut residual = DVector::from_fn(omitted, |mode, _| flexibility(mode));
        let size = residual.norm();
        for _ in 0..2 {
            for known in &residuals {
                residual.axpy(-known.dot(&residual), known, 1.0);
            }
        }
        if residual.norm() > DEPENDENT * size {
            residuals.push(residual.normalize());
        }
    }
    let mut shapes = DMatrix::zeros(modes.nrows(), kept + residuals.len());
    shapes.columns_mut(0, kept).copy_from(&modes.columns(0, kept));
    if !residuals.is_empty() {
        let residuals = modes.columns(kept, omitted) * DMatrix::from_columns(&residuals);
        shapes.columns_mut(kept, residuals.ncols()).copy_from(&residuals);
    }
    shapes
}

/// Coordinates of the uncoupled components, ascending in each.
fn components(mass: &DMatrix<f64>, stiffness: &DMatrix<f64>) -> Vec<Vec<usize>> {
    let mut left: Vec<usize> = (0..mass.nrows()).rev().collect();
    let mut components = Vec::new();
    while let Some(first) = left.pop() {
        let (mut component, mut next) = (vec![first], 0);
        while next < component.len() {
            let row = component[next];
            let coupled = |index: &usize| mass[(row, *index)] != 0.0 || stiffness[(row, *index)] != 0.0;
            let (joined, rest): (Vec<usize>, Vec<usize>) = left.iter().partition(|index| coupled(index));
            component.extend(joined);
            left = rest;
            next += 1;
        }
        component.sort_unstable();
        components.push(component);
    }
    components
}
