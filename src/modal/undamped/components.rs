//! Undamped modes of the components of a model that nothing couples, and those of a large model from the modes of its components
//! (component mode synthesis; Craig and Bampton 1968, MacNeal 1971, Rubin 1975).
//!
//! Without meshes the model consists of uncoupled components: the torsion of each shaft, and its bending, in each plane
//! where no bearing couples the planes. Their modes are small problems. The modes below a frequency limit are kept. The
//! static displacements under unit loads at the interface coordinates are kept exactly: the part that the omitted modes
//! contribute to them (residual flexibility) becomes a shape of its own. For a given frequency the omitted dynamics decrease
//! with the fourth power of frequency over limit. Under sharp tooth engagement, whose load is a step, the error decreases
//! with the square of the limit.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};

use super::real::{RealModes, RigidMotion, rigid_body_modes, rigid_motions, spring_deflections};
use crate::connection::Row;
use crate::linalg::{DecompositionError, Sparse, SymmetricPencil, matrix_of_columns, symmetric_pencil};
use crate::model::Model;
use crate::numerics::ROOT_OF_ROUND_OFF;

/// Undamped modes of components.
#[derive(Clone, Debug)]
pub struct ComponentModes(Vec<Component>);

/// A component with its undamped modes.
#[derive(Clone, Debug)]
struct Component {
    /// Coordinates in the order of the core, ascending.
    coordinates: Vec<usize>,
    /// Number of rigid-body modes.
    null: usize,
    /// ω² of all modes, ascending, rad²/s².
    values: DVector<f64>,
    /// Mode shapes, orthonormal in M, one per column.
    vectors: DMatrix<f64>,
}

impl ComponentModes {
    /// Modes of all components, with the connections and their loaded tooth flanks at `speed` (reference shaft, rad/s), or without
    /// connections.
    pub(in crate::modal) fn new(model: &Model, speed: Option<f64>) -> Result<Self, DecompositionError> {
        let mass = model.sparse_mass();
        let stiffness = match speed {
            Some(speed) => model.sparse_symmetric_stiffness(speed),
            None => model.sparse_stiffness_without_connections(),
        };
        let kinetic = |motions: &DMatrix<f64>| motions.transpose() * model.mass_times(motions);
        let (rigid, deflections) = (rigid_motions(model), spring_deflections(model, speed));
        let mut found: Vec<Component> = Vec::new();
        let mut problems: Vec<[DMatrix<f64>; 3]> = Vec::new();
        for coordinates in components(model.len(), &mass, &stiffness) {
            let is_own = |index: &usize| coordinates.binary_search(index).is_ok();
            let is_inside = |motion: &&RigidMotion| motion.displacements.iter().all(|(index, _)| is_own(index));
            let inside: Vec<RigidMotion> = rigid.iter().filter(is_inside).cloned().collect();
            let null = rigid_body_modes(model, &inside, &deflections, kinetic)?.select_rows(&coordinates);
            let problem = [block(&stiffness, &coordinates), block(&mass, &coordinates), null];
            // The two planes of a shaft, and equal shafts, have one decomposition.
            let (null, SymmetricPencil { values, vectors }) = match problems.iter().position(|known| *known == problem)
            {
                Some(equal) => {
                    let Component { null, values, vectors, .. } = found[equal].clone();
                    (null, SymmetricPencil { values, vectors })
                }
                None => (problem[2].ncols(), symmetric_pencil(&problem[0], &problem[1], &problem[2])?),
            };
            found.push(Component { coordinates, null, values, vectors });
            problems.push(problem);
        }
        Ok(Self(found))
    }

    /// The mode shapes of the components with coordinates in `part`, one per column, n rows, and the number of rigid-body modes,
    /// which come first.
    pub(in crate::modal) fn shapes(&self, model: &Model, part: Range<usize>) -> (DMatrix<f64>, usize) {
        let inside = || self.0.iter().filter(|component| part.contains(&component.coordinates[0]));
        let null = inside().map(|component| component.null).sum();
        let mut vectors = DMatrix::zeros(model.len(), part.len());
        let [mut rigid, mut elastic] = [0, null];
        for component in inside() {
            for (number, shape) in component.vectors.column_iter().enumerate() {
                let next = if number < component.null { &mut rigid } else { &mut elastic };
                component.coordinates.iter().zip(&shape).for_each(|(row, value)| vectors[(*row, *next)] = *value);
                *next += 1;
            }
        }
        (vectors, null)
    }

    /// Undamped modes of the complete model in the subspace of the component modes up to `limit`, rad/s, and of the static
    /// displacements of each component under `loads` as entries (index, coefficient); with the loaded tooth flanks of `speed`
    /// (reference shaft, rad/s).
    pub(in crate::modal) fn modes(
        &self,
        model: &Model,
        speed: f64,
        loads: &[Row],
        limit: f64,
    ) -> Result<RealModes, DecompositionError> {
        let mut shapes: Vec<DVector<f64>> = Vec::new();
        for Component { coordinates, null, values, vectors } in &self.0 {
            let local = |load: &Row| -> Row {
                let entries = load.iter();
                entries.filter_map(|(index, value)| Some((coordinates.binary_search(index).ok()?, *value))).collect()
            };
            let loads: Vec<Row> = loads.iter().map(local).filter(|load| !load.is_empty()).collect();
            let kept = (*null).max(values.iter().take_while(|value| **value <= limit * limit).count());
            for column in component_shapes(values, vectors, kept, &loads).column_iter() {
                let mut shape = DVector::zeros(model.len());
                coordinates.iter().zip(column.iter()).for_each(|(index, value)| shape[*index] = *value);
                shapes.push(shape);
            }
        }
        let basis = matrix_of_columns(model.len(), &shapes);
        RealModes::in_subspace(model, speed, &basis)
    }
}

/// The first `kept` modes of a component, and the residual flexibility of the others under `loads`, all orthonormal in M;
/// `values` are ω².
fn component_shapes(values: &DVector<f64>, modes: &DMatrix<f64>, kept: usize, loads: &[Row]) -> DMatrix<f64> {
    let omitted = values.len() - kept;
    let mut residuals: Vec<DVector<f64>> = Vec::new();
    for load in loads {
        let flexibility = |mode: usize| {
            let force: f64 = load.iter().map(|(index, value)| modes[(*index, kept + mode)] * value).sum();
            force / values[kept + mode]
        };
        let mut residual = DVector::from_fn(omitted, |mode, _| flexibility(mode));
        let size = residual.norm();
        for _ in 0..2 {
            for known in &residuals {
                residual.axpy(-known.dot(&residual), known, 1.0);
            }
        }
        if residual.norm() > ROOT_OF_ROUND_OFF * size {
            residuals.push(residual.normalize());
        }
    }
    let mut shapes = DMatrix::zeros(modes.nrows(), kept + residuals.len());
    shapes.columns_mut(0, kept).copy_from(&modes.columns(0, kept));
    let residuals = modes.columns(kept, omitted) * matrix_of_columns(omitted, &residuals);
    shapes.columns_mut(kept, residuals.ncols()).copy_from(&residuals);
    shapes
}

/// Rows and columns of a sparse matrix at ascending `coordinates`.
fn block(matrix: &Sparse, coordinates: &[usize]) -> DMatrix<f64> {
    let mut block = DMatrix::zeros(coordinates.len(), coordinates.len());
    matrix.for_each(|row, column, value| {
        if let (Ok(row), Ok(column)) = (coordinates.binary_search(&row), coordinates.binary_search(&column)) {
            block[(row, column)] = value;
        }
    });
    block
}

/// Coordinates of the uncoupled components among `size` coordinates, ascending in each.
fn components(size: usize, mass: &Sparse, stiffness: &Sparse) -> Vec<Vec<usize>> {
    let mut neighbours = vec![Vec::new(); size];
    for matrix in [mass, stiffness] {
        matrix.for_each(|row, column, _| {
            neighbours[row].push(column);
            neighbours[column].push(row);
        });
    }
    let (mut found, mut components) = (vec![false; size], Vec::new());
    for first in 0..size {
        if found[first] {
            continue;
        }
        found[first] = true;
        let (mut component, mut next) = (vec![first], 0);
        while next < component.len() {
            for other in &neighbours[component[next]] {
                if !found[*other] {
                    found[*other] = true;
                    component.push(*other);
                }
            }
            next += 1;
        }
        component.sort_unstable();
        components.push(component);
    }
    components
}
