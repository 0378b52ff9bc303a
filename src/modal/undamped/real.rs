//! Undamped modes at rest: K φ = ω² M φ with φᵀMφ = 1, in ascending order of ω.
//!
//! K contains the shafts, the symmetric part of the bearing stiffness, and the mean mesh stiffness. The skew part of a
//! bearing stiffness (cross-coupling) belongs to the damped problem.
//!
//! Rigid-body modes (ω = 0) are computed first. The elastic energy of a shaft is zero only for its rigid motions: four
//! in bending, one in torsion and one along its axis. The null space of K therefore contains the rigid shaft motions that deflect no
//! bearing and no mesh. This is a small eigenproblem. It depends on the positions and directions of the springs, not
//! on their stiffness, so all springs have unit stiffness in it. A train on bearings has one rigid-body mode: its
//! rotation with undeflected teeth.
//!
//! The eigensolver computes ω² with an error of about ε·ω_max². A stiff bearing or a short element makes this error
//! large relative to the lowest ω². The eigenvectors are accurate, so ω² is computed again as the Rayleigh quotient
//! φᵀKφ/φᵀMφ, whose error is of second order in the error of φ. The elastic energy φᵀKφ is a sum over the strains of
//! the elements.

use std::collections::BTreeMap;
use std::ops::Range;

use nalgebra::{DMatrix, DVector, RowDVector};

use super::components::ComponentModes;
use crate::connection::{Connection, Row};
use crate::linalg::{DecompositionError, Sparse, symmetric_eigen, symmetric_pencil};
use crate::model::{DofKind, Link, Model, Support};
use crate::numerics::ROUND_OFF;
use crate::scene::Node;

/// A rigid motion is a rigid-body mode if its eigenvalue with springs of unit stiffness is below this. Round-off leaves
/// 1e-15.
const ZERO_STIFFNESS: f64 = 1e-13;

/// Undamped modes of a model, or of an uncoupled part of it.
#[derive(Clone, Debug, PartialEq)]
pub struct RealModes {
    /// Angular frequencies ω, rad/s: the zeros of the rigid-body modes, then ascending.
    pub frequencies: DVector<f64>,
    /// Mode shapes Φ with ΦᵀMΦ = I, one per column, n rows in the order of the core.
    pub vectors: DMatrix<f64>,
    /// Number of rigid-body modes; they are the first columns.
    pub null: usize,
}

impl RealModes {
    /// Modes of the complete model, with the loaded tooth flanks of `speed` (reference shaft, rad/s).
    pub(in crate::modal) fn new(model: &Model, speed: f64) -> Result<Self, DecompositionError> {
        let (vectors, null) = ComponentModes::new(model, Some(speed))?.shapes(model, 0..model.len());
        Ok(Self::of_shapes(model, speed, vectors, null))
    }

    /// Modes without meshes, for each uncoupled part: the bending and the torsion of each shaft, or everything if links
    /// couple the shafts. Mode shapes are zero outside their part.
    pub(in crate::modal) fn without_meshes(model: &Model) -> Result<Vec<Self>, DecompositionError> {
        let components = ComponentModes::new(model, None)?;
        let modes_of_part = |part: Range<usize>| {
            let (vectors, null) = components.shapes(model, part);
            Self::ascending(model, vectors, null, |shape| model.elastic_form_without_meshes(shape))
        };
        Ok(model.uncoupled_parts().into_iter().map(modes_of_part).collect())
    }

    /// Modes in a subspace (Rayleigh–Ritz), whose basis is orthonormal in M, one vector per column, and contains the
    /// rigid-body modes; with the loaded tooth flanks of `speed` (reference shaft, rad/s).
    pub(in crate::modal) fn in_subspace(
        model: &Model,
        speed: f64,
        basis: &DMatrix<f64>,
    ) -> Result<Self, DecompositionError> {
        let null = null_motions(model, speed)?;
        let transposed = basis.transpose();
        let projected = &transposed * times(&model.sparse_symmetric_stiffness(speed), basis);
        let known = transposed * model.mass_times(&null);
        let size = basis.ncols();
        let mut vectors = basis * symmetric_pencil(&projected, &DMatrix::identity(size, size), &known)?.vectors;
        vectors.columns_mut(0, null.ncols()).copy_from(&null);
        Ok(Self::of_shapes(model, speed, vectors, null.ncols()))
    }

    /// Modes from their shapes, which are orthonormal in M; the first `null` ones are rigid-body modes.
    pub(in crate::modal) fn of_shapes(model: &Model, speed: f64, vectors: DMatrix<f64>, null: usize) -> Self {
        Self::ascending(model, vectors, null, |shape| model.elastic_form(shape, |mesh| model.sigma(mesh, speed)))
    }

    /// Sorts modes, of which the first `known` are rigid-body modes, by frequency; `elastic_form` gives φᵀKφ.
    pub(in crate::modal) fn ascending(
        model: &Model,
        vectors: DMatrix<f64>,
        known: usize,
        elastic_form: impl Fn(&[f64]) -> f64,
    ) -> Self {
        let rayleigh = |shape: &[f64]| elastic_form(shape) / model.kinetic_form(shape);
        let (vectors, squares) = separate_equal_modes(model, vectors, known, rayleigh);
        let frequency = |column: usize| squares[column].max(0.0).sqrt();
        let mut order: Vec<(f64, usize)> = (known..vectors.ncols()).map(|column| (frequency(column), column)).collect();
        order.sort_by(|a, b| a.0.total_cmp(&b.0));
        let columns: Vec<usize> = (0..known).chain(order.iter().map(|(_, column)| *column)).collect();
        let frequencies = std::iter::repeat_n(0.0, known).chain(order.iter().map(|(frequency, _)| *frequency));
        Self {
            frequencies: DVector::from_iterator(vectors.ncols(), frequencies),
            vectors: vectors.select_columns(&columns),
            null: known,
        }
    }

    /// Highest frequency ω_max, rad/s.
    pub fn highest(&self) -> f64 {
        self.frequencies.max()
    }

    /// ΦᵀAΦ for a sparse n × n matrix A.
    pub(in crate::modal) fn project_sparse(&self, matrix: &Sparse) -> DMatrix<f64> {
        if matrix.is_zero() {
            let size = self.vectors.ncols();
            return DMatrix::zeros(size, size);
        }
        self.vectors.transpose() * times(matrix, &self.vectors)
    }

    /// ΦᵀAΦ for an n × n matrix A.
    pub(in crate::modal) fn project(&self, matrix: &DMatrix<f64>) -> DMatrix<f64> {
        self.vectors.transpose() * (matrix * &self.vectors)
    }

    /// Damping matrix MΦ·diag(2ζω)·ΦᵀM, n × n, with the damping ratio ζ = `ratio` in every mode.
    pub(in crate::modal) fn damping_matrix(&self, model: &Model) -> DMatrix<f64> {
        let weighted = model.mass_matrix() * &self.vectors;
        let (mut scaled, ratios) = (weighted.clone(), &model.scene.modal_damping);
        for (index, mut column) in scaled.column_iter_mut().enumerate() {
            let frequency = self.frequencies[index];
            column *= ratios.rate(index.saturating_sub(self.null), frequency);
        }
        scaled * weighted.transpose()
    }
}

/// Rigid-body modes of the complete model, one per column and orthonormal in M, with the loaded tooth flanks of `speed`
/// (reference shaft, rad/s). Time and memory are proportional to n.
///
/// # Errors
/// [`DecompositionError`] if a decomposition fails.
pub fn null_motions(model: &Model, speed: f64) -> Result<DMatrix<f64>, DecompositionError> {
    let kinetic = |motions: &DMatrix<f64>| motions.transpose() * model.mass_times(motions);
    rigid_body_modes(model, &rigid_motions(model), &spring_deflections(model, Some(speed)), kinetic)
}

/// Product of a sparse matrix and the columns of a dense one.
pub fn times(matrix: &Sparse, columns: &DMatrix<f64>) -> DMatrix<f64> {
    let mut product = DMatrix::zeros(columns.nrows(), columns.ncols());
    let rows = columns.nrows().max(1);
    for (column, out) in columns.as_slice().chunks_exact(rows).zip(product.as_mut_slice().chunks_exact_mut(rows)) {
        matrix.multiply_add(1.0, column, out);
    }
    product
}

/// Combines modes of equal frequency so that each lies in one plane of one shaft, if possible. Returns them with ω², which is
/// one number for modes of equal frequency.
///
/// An eigensolver returns arbitrary combinations, which would couple planes and shafts that are uncoupled. The first
/// `known` modes stay unchanged; `rayleigh` gives ω². Modes of equal frequency are in the order of the shafts and planes, so
/// that round-off does not choose among them.
fn separate_equal_modes(
    model: &Model,
    mut vectors: DMatrix<f64>,
    known: usize,
    rayleigh: impl Fn(&[f64]) -> f64,
) -> (DMatrix<f64>, Vec<f64>) {
    let mut squares: Vec<f64> = vectors.column_iter().map(|column| rayleigh(column.as_slice())).collect();
    // A matrix with a different weight for each shaft and plane is diagonalized within the modes of equal frequency.
    let mut weights = DVector::zeros(model.len());
    for dof in model.numbering.dofs() {
        let plane = match dof.kind {
            DofKind::V | DofKind::Gamma | DofKind::Mode => 0.0,
            DofKind::W | DofKind::B | DofKind::Twist => 0.37,
            DofKind::Axial => 0.71,
        };
        weights[dof.index] = 1.0 + dof.node.shaft as f64 + plane;
    }
    let mut first = known;
    while first < vectors.ncols() {
        let equal = |column: &usize| (squares[*column] - squares[first]).abs() <= ROUND_OFF * squares[first];
        let count = (first..vectors.ncols()).take_while(equal).count().max(1);
        if count > 1 {
            let cluster = vectors.columns(first, count).into_owned();
            let weighted = DMatrix::from_fn(model.len(), count, |row, column| weights[row] * cluster[(row, column)]);
            let form = cluster.transpose() * model.mass_times(&weighted);
            let found = ((&form + form.transpose()) / 2.0).symmetric_eigen();
            let mut order: Vec<usize> = (0..count).collect();
            order.sort_by(|a, b| found.eigenvalues[*a].total_cmp(&found.eigenvalues[*b]));
            let rotation = found.eigenvectors.select_columns(&order);
            vectors.columns_mut(first, count).copy_from(&(cluster * rotation));
            let square = squares[first];
            squares[first..first + count].fill(square);
        }
        first += count;
    }
    (vectors, squares)
}

/// A rigid motion of one shaft or housing.
#[derive(Clone, Debug)]
pub(in crate::modal) struct RigidMotion {
    /// Number of the shaft; the coordinates of housings follow the shafts.
    body: usize,
    /// Displacements as entries (index, value).
    pub displacements: Row,
}

/// Rigid-body modes, one per column and orthonormal in M: the combinations of `rigid` motions that deflect no spring of
/// `springs`, whose rows give their deflections; `kinetic` gives XᵀMX.
///
/// The springs of one shaft leave few motions of it, so that the eigenproblem of all shafts is small.
pub(in crate::modal) fn rigid_body_modes(
    model: &Model,
    rigid: &[RigidMotion],
    springs: &[Row],
    kinetic: impl Fn(&DMatrix<f64>) -> DMatrix<f64>,
) -> Result<DMatrix<f64>, DecompositionError> {
    // Coordinate, number of the motion and displacement, in the order of the coordinates: a few of the model.
    let numbered = rigid.iter().enumerate();
    let mut moving: Vec<(usize, usize, f64)> = numbered
        .flat_map(|(motion, rigid)| rigid.displacements.iter().map(move |(index, value)| (*index, motion, *value)))
        .collect();
    moving.sort_by_key(|(index, ..)| *index);
    let at = |index: usize| {
        let first = moving.partition_point(|(other, ..)| *other < index);
        moving[first..].iter().take_while(move |(other, ..)| *other == index)
    };
    let moved = |spring: &Row| {
        let parts = spring.iter().flat_map(|(index, coefficient)| at(*index).map(move |part| (part, coefficient)));
        let mut sum: BTreeMap<usize, f64> = BTreeMap::new();
        parts.for_each(|((_, motion, value), coefficient)| *sum.entry(*motion).or_default() += value * coefficient);
        sum
    };
    let deflections: Vec<BTreeMap<usize, f64>> = springs.iter().map(moved).filter(|row| !row.is_empty()).collect();
    // Translations and rotations have different units, so each motion is scaled to a spring deflection of norm one.
    let mut scales = vec![0.0; rigid.len()];
    deflections.iter().flatten().for_each(|(motion, value)| scales[*motion] += value * value);
    scales.iter_mut().for_each(|square| *square = if *square > 0.0 { 1.0 / square.sqrt() } else { 1.0 });
    let scaled = |row: &BTreeMap<usize, f64>, motions: Range<usize>| {
        RowDVector::from_iterator(motions.len(), motions.map(|i| row.get(&i).map_or(0.0, |value| value * scales[i])))
    };
    let mut combinations: Vec<DVector<f64>> = Vec::new();
    let mut first = 0;
    for body in rigid.chunk_by(|a, b| a.body == b.body) {
        let own = first..first + body.len();
        first = own.end;
        let is_own = |row: &&BTreeMap<usize, f64>| row.keys().all(|motion| own.contains(motion));
        let touching = deflections.iter().filter(|row| row.range(own.clone()).next().is_some());
        let rows: Vec<_> = touching.filter(is_own).map(|row| scaled(row, own.clone())).collect();
        for free in without_deflection(&rows, body.len())?.column_iter() {
            let mut combination = DVector::zeros(rigid.len());
            combination.rows_mut(own.start, own.len()).copy_from(&free);
            combinations.push(combination);
        }
    }
    let free = DMatrix::from_fn(rigid.len(), combinations.len(), |i, j| combinations[j][i]);
    let rows = deflections.iter().map(|row| {
        let mut sum = RowDVector::zeros(free.ncols());
        row.iter().for_each(|(motion, value)| sum += free.row(*motion) * (value * scales[*motion]));
        sum
    });
    let rows: Vec<_> = rows.collect();
    let free = &free * without_deflection(&rows, free.ncols())?;
    let mut motions = DMatrix::zeros(model.len(), free.ncols());
    for (column, mut motion) in free.column_iter().zip(motions.column_iter_mut()) {
        for ((factor, scale), rigid) in column.iter().zip(&scales).zip(rigid) {
            rigid.displacements.iter().for_each(|(index, value)| motion[*index] += factor * scale * value);
        }
    }
    let size = motions.ncols();
    Ok(&motions
        * symmetric_pencil(&DMatrix::identity(size, size), &kinetic(&motions), &DMatrix::zeros(size, 0))?.vectors)
}

/// Orthonormal vectors of `size` entries whose products with all `rows` are zero, one per column.
fn without_deflection(rows: &[RowDVector<f64>], size: usize) -> Result<DMatrix<f64>, DecompositionError> {
    if rows.is_empty() || size == 0 {
        return Ok(DMatrix::identity(size, size));
    }
    let rows = DMatrix::from_rows(rows);
    let found = symmetric_eigen(&rows.tr_mul(&rows))?;
    let free: Vec<usize> = (0..size).filter(|i| found.values[*i] <= ZERO_STIFFNESS).collect();
    Ok(found.vectors.select_columns(&free))
}

/// Deflection of every bearing direction and of every mesh, one spring per row.
///
/// `speed` (reference shaft, rad/s) selects the loaded tooth flanks; without it the meshes are left out.
pub(in crate::modal) fn spring_deflections(model: &Model, speed: Option<f64>) -> Vec<Row> {
    let of_support = |support: &Support| {
        let index = support.index;
        support.directions().map(move |[along_v, along_w]| vec![(index, along_v), (index + 1, along_w)])
    };
    let supports = model.supports.iter().flat_map(of_support);
    let connections = speed.iter().flat_map(|speed| model.connections(*speed)).filter(Connection::is_elastic);
    let connections = connections.flat_map(|connection| connection.rows());
    supports.chain(model.links.iter().flat_map(Link::directions)).chain(connections).collect()
}

/// Rigid motions of every single shaft and of every housing; those of one follow each other.
pub(in crate::modal) fn rigid_motions(model: &Model) -> Vec<RigidMotion> {
    let mut motions = Vec::new();
    for (shaft, given) in model.scene.shafts.iter().enumerate() {
        let middle = given.length() / 2.0;
        let nodes = || given.nodes.iter().map(|x| x - middle).enumerate();
        let mut push = |displacements: Row| motions.push(RigidMotion { body: shaft, displacements });
        if model.numbering.lateral(shaft).is_some() {
            for lane in 0..2 {
                let index = |node| model.numbering.translation(Node { shaft, node }).unwrap_or_default() + lane;
                push(nodes().map(|(node, _)| (index(node), 1.0)).collect());
                push(nodes().flat_map(|(node, x)| [(index(node), x), (index(node) + 2, 1.0)]).collect());
            }
        }
        for start in model.numbering.torsion(shaft).into_iter().chain(model.numbering.axial(shaft)) {
            push(nodes().map(|(node, _)| (start + node, 1.0)).collect());
        }
    }
    for index in model.housings.coordinates() {
        motions.push(RigidMotion { body: model.scene.shafts.len() + index, displacements: vec![(index, 1.0)] });
    }
    motions
}
