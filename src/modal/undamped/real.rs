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

use std::ops::Range;

use nalgebra::{DMatrix, DVector, RowDVector};

use crate::connection::Connection;
use crate::linalg::{DecompositionError, Sparse, symmetric_pencil};
use crate::model::{DofKind, Link, Model};
use crate::scene::Node;

/// A rigid motion is a rigid-body mode if its eigenvalue with springs of unit stiffness is below this. Round-off leaves
/// 1e-15.
const ZERO_STIFFNESS: f64 = 1e-13;
/// Values of ω² with a smaller relative difference count as equal; round-off hides smaller differences.
const EQUAL: f64 = 1e-12;

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
        let mass = model.mass_matrix();
        let kinetic = |motions: &DMatrix<f64>| motions.transpose() * &mass * motions;
        let null = rigid_body_modes(&rigid_motions(model), &spring_deflections(model, Some(speed)), kinetic)?;
        let stiffness =
            model.shaft_stiffness_matrix() + model.symmetric_part_matrix() + model.connection_stiffness_matrix(speed);
        let vectors = symmetric_pencil(&stiffness, &mass, &null)?.vectors;
        Ok(Self::of_shapes(model, speed, vectors, null.ncols()))
    }

    /// Modes without meshes, for each uncoupled part: the bending and the torsion of each shaft, or everything if links
    /// couple the shafts. Mode shapes are zero outside their part.
    pub(in crate::modal) fn without_meshes(model: &Model) -> Result<Vec<Self>, DecompositionError> {
        let mass = model.mass_matrix();
        let stiffness = model.shaft_stiffness_matrix() + model.symmetric_part_matrix();
        let (rigid, deflections) = (rigid_motions(model), spring_deflections(model, None));
        let modes_of_part = |part: Range<usize>| {
            let in_part: Vec<usize> =
                (0..rigid.ncols()).filter(|i| rigid.column(*i).rows_range(part.clone()).amax() > 0.0).collect();
            let kinetic = |motions: &DMatrix<f64>| motions.transpose() * &mass * motions;
            let null = rigid_body_modes(&rigid.select_columns(&in_part), &deflections, kinetic)?;
            let block = |matrix: &DMatrix<f64>| matrix.view_range(part.clone(), part.clone()).into_owned();
            let null_in_part = null.rows_range(part.clone()).into_owned();
            let shapes = symmetric_pencil(&block(&stiffness), &block(&mass), &null_in_part)?.vectors;
            let mut vectors = DMatrix::zeros(model.len(), part.len());
            vectors.rows_range_mut(part).copy_from(&shapes);
            Ok(Self::ascending(model, vectors, null.ncols(), |shape| model.elastic_form_without_meshes(shape)))
        };
        model.uncoupled_parts().into_iter().map(modes_of_part).collect()
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
        let vectors = separate_equal_modes(model, vectors, known, rayleigh);
        let frequency = |column: usize| rayleigh(vectors.column(column).as_slice()).max(0.0).sqrt();
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
            column *= 2.0 * ratios.of_mode(index.saturating_sub(self.null), frequency) * frequency;
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
    rigid_body_modes(&rigid_motions(model), &spring_deflections(model, Some(speed)), kinetic)
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

/// Combines modes of equal frequency so that each lies in one plane of one shaft, if possible.
///
/// An eigensolver returns arbitrary combinations, which would couple planes and shafts that are uncoupled. The first
/// `known` modes stay unchanged; `rayleigh` gives ω².
fn separate_equal_modes(
    model: &Model,
    mut vectors: DMatrix<f64>,
    known: usize,
    rayleigh: impl Fn(&[f64]) -> f64,
) -> DMatrix<f64> {
    let squares: Vec<f64> = vectors.column_iter().map(|column| rayleigh(column.as_slice())).collect();
    // A matrix with a different weight for each shaft and plane is diagonalized within the modes of equal frequency.
    let mut weights = DVector::zeros(model.len());
    for dof in model.numbering.dofs() {
        let plane = match dof.kind {
            DofKind::V | DofKind::Gamma => 0.0,
            DofKind::W | DofKind::B | DofKind::Twist => 0.37,
            DofKind::Axial => 0.71,
        };
        weights[dof.index] = 1.0 + dof.node.shaft as f64 + plane;
    }
    let mut first = known;
    while first < vectors.ncols() {
        let equal = |column: &usize| (squares[*column] - squares[first]).abs() <= EQUAL * squares[first];
        let count = (first..vectors.ncols()).take_while(equal).count().max(1);
        if count > 1 {
            let cluster = vectors.columns(first, count).into_owned();
            let weighted = DMatrix::from_fn(model.len(), count, |row, column| weights[row] * cluster[(row, column)]);
            let form = cluster.transpose() * model.mass_times(&weighted);
            let rotation = ((&form + form.transpose()) / 2.0).symmetric_eigen().eigenvectors;
            vectors.columns_mut(first, count).copy_from(&(cluster * rotation));
        }
        first += count;
    }
    vectors
}

/// Rigid-body modes, one per column and orthonormal in M: the combinations of `rigid` motions (columns) that deflect no
/// spring. Each row of `deflections` gives the deflection of one spring per coordinate; `kinetic` gives XᵀMX.
pub(in crate::modal) fn rigid_body_modes(
    rigid: &DMatrix<f64>,
    deflections: &DMatrix<f64>,
    kinetic: impl Fn(&DMatrix<f64>) -> DMatrix<f64>,
) -> Result<DMatrix<f64>, DecompositionError> {
    let mut rigid = rigid.clone();
    let mut deflections = deflections * &rigid;
    // Translations and rotations have different units, so each motion is scaled to a spring deflection of norm one.
    for (mut motion, mut deflection) in rigid.column_iter_mut().zip(deflections.column_iter_mut()) {
        let size = deflection.norm();
        if size > 0.0 {
            motion /= size;
            deflection /= size;
        }
    }
    let none = |size| DMatrix::zeros(size, 0);
    let size = rigid.ncols();
    let pencil =
        symmetric_pencil(&(deflections.transpose() * deflections), &DMatrix::identity(size, size), &none(size))?;
    let free: Vec<usize> = (0..size).filter(|i| pencil.values[*i] <= ZERO_STIFFNESS).collect();
    let motions = rigid * pencil.vectors.select_columns(&free);
    let size = free.len();
    Ok(&motions * symmetric_pencil(&DMatrix::identity(size, size), &kinetic(&motions), &none(size))?.vectors)
}

/// Deflection of every bearing direction and of every mesh per coordinate, one spring per row, n columns.
///
/// `speed` (reference shaft, rad/s) selects the loaded tooth flanks; without it the meshes are left out.
pub(in crate::modal) fn spring_deflections(model: &Model, speed: Option<f64>) -> DMatrix<f64> {
    let mut rows = Vec::new();
    for support in &model.supports {
        for [along_v, along_w] in support.directions() {
            let mut row = RowDVector::zeros(model.len());
            (row[support.index], row[support.index + 1]) = (along_v, along_w);
            rows.push(row);
        }
    }
    let connections = speed.iter().flat_map(|speed| model.connections(*speed)).filter(Connection::is_elastic);
    let connections = connections.flat_map(|connection| connection.rows());
    for entries in model.links.iter().flat_map(Link::directions).chain(connections) {
        let mut row = RowDVector::zeros(model.len());
        entries.iter().for_each(|(column, coefficient)| row[*column] += coefficient);
        rows.push(row);
    }
    if rows.is_empty() { DMatrix::zeros(1, model.len()) } else { DMatrix::from_rows(&rows) }
}

/// Rigid motions of every single shaft and of every housing, one per column, n rows.
pub(in crate::modal) fn rigid_motions(model: &Model) -> DMatrix<f64> {
    let mut columns = Vec::new();
    for (shaft, given) in model.scene.shafts.iter().enumerate() {
        let middle = given.length() / 2.0;
        let mut push = |entry: &dyn Fn(usize, f64, &mut DVector<f64>)| {
            let mut column = DVector::zeros(model.len());
            for (node, x) in given.nodes.iter().enumerate() {
                entry(node, x - middle, &mut column);
            }
            columns.push(column);
        };
        if model.numbering.lateral(shaft).is_some() {
            for lane in 0..2 {
                let index = |node| model.numbering.translation(Node { shaft, node }).unwrap_or_default() + lane;
                push(&|node, _, column| column[index(node)] = 1.0);
                push(&|node, x, column| {
                    column[index(node)] = x;
                    column[index(node) + 2] = 1.0;
                });
            }
        }
        for start in model.numbering.torsion(shaft).into_iter().chain(model.numbering.axial(shaft)) {
            push(&|node, _, column| column[start + node] = 1.0);
        }
    }
    for index in model.housings.coordinates() {
        let mut column = DVector::zeros(model.len());
        column[index] = 1.0;
        columns.push(column);
    }
    DMatrix::from_columns(&columns)
}
