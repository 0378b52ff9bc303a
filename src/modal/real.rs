//! Undamped modes of (M, K) at rest, with the mean mesh: φᵀMφ = 1, ascending.
//!
//! Motions without stiffness are found first and exactly. A shaft resists no rigid motion, so the null space of K is
//! that of bearings and meshes alone over the rigid motions of the shafts: four of bending and one of twist each, a
//! small eigenproblem. A train on bearings has one, its rolling. It is a matter of where springs stand, not of how stiff
//! they are: the softest bearing holds a shaft beside the stiffest mesh.
//!
//! The eigensolver's own ω² is wrong by ε·ω_max², which a stiff bearing or a short element makes large beside the low
//! ones. Its vectors are good, so ω² is taken from them once more as a Rayleigh quotient, whose error is of second
//! order, with the elastic energy summed from the strains of the elements.

use std::ops::{Deref, Range};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use nalgebra::{DMatrix, DVector, RowDVector};

use super::ModalStateSpace;
use crate::linalg::{DecompositionError, symmetric_pencil};
use crate::model::{DofKind, Model};
use crate::scene::{Node, SceneError};

/// Rigid motions that springs of unit stiffness resist by less than this are not resisted: round-off leaves 1e-15.
const NULL: f64 = 1e-13;
/// Squares of frequencies that differ by less than this part are equal: round-off tells no more of them apart.
const EQUAL: f64 = 1e-12;

/// Undamped modes.
#[derive(Clone, Debug)]
pub struct RealModes {
    /// ω, rad/s: zeros of the null motions first, then ascending.
    pub frequencies: DVector<f64>,
    /// Vectors in the inside order, one a column.
    pub vectors: DMatrix<f64>,
    /// How many null motions lead.
    pub null: usize,
}

impl RealModes {
    fn new(model: &Model, speed: f64) -> Result<Self, DecompositionError> {
        let mass = model.mass_matrix();
        let null = null_motions(&rigid_motions(model), &deflections(model, Some(speed)), &mass)?;
        // What a bearing does beside restoring, as by cross-coupling, belongs to the damped problem.
        let stiffness =
            model.shaft_stiffness_matrix() + model.symmetric_part_matrix() + model.connection_stiffness_matrix(speed);
        let vectors = symmetric_pencil(&stiffness, &mass, &null)?.vectors;
        let form = |shape: &[f64]| model.elastic_form(shape, |mesh| model.sigma(mesh, speed));
        Ok(Self::ascending(model, vectors, null.ncols(), form))
    }

    /// The modes of every part of a train whose meshes are taken out: the bending of each shaft, and its twist. The
    /// vectors of a part are zero in all others.
    pub(super) fn of_parts(model: &Model) -> Result<Vec<Self>, DecompositionError> {
        let mass = model.mass_matrix();
        let stiffness = model.shaft_stiffness_matrix() + model.symmetric_part_matrix();
        let (rigid, deflections) = (rigid_motions(model), deflections(model, None));
        let of_part = |part: Range<usize>| {
            let moves: Vec<usize> =
                (0..rigid.ncols()).filter(|i| rigid.column(*i).rows_range(part.clone()).amax() > 0.0).collect();
            let null = null_motions(&rigid.select_columns(&moves), &deflections, &mass)?;
            let block = |matrix: &DMatrix<f64>| matrix.view_range(part.clone(), part.clone()).into_owned();
            let null_in_part = null.rows_range(part.clone()).into_owned();
            let own = symmetric_pencil(&block(&stiffness), &block(&mass), &null_in_part)?.vectors;
            let mut vectors = DMatrix::zeros(model.len(), part.len());
            vectors.rows_range_mut(part).copy_from(&own);
            Ok(Self::ascending(model, vectors, null.ncols(), |shape| model.unmeshed_elastic_form(shape)))
        };
        model.numbering.parts().map(of_part).collect()
    }

    /// Modes of which `known` null motions lead, in the order of their frequencies; `form` gives φᵀKφ.
    fn ascending(model: &Model, vectors: DMatrix<f64>, known: usize, form: impl Fn(&[f64]) -> f64) -> Self {
        let square = |shape: &[f64]| form(shape) / model.kinetic_form(shape);
        let vectors = aligned(model, vectors, known, square);
        let frequency = |column: usize| square(vectors.column(column).as_slice()).max(0.0).sqrt();
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

    /// ω_max, rad/s.
    pub fn highest(&self) -> f64 {
        self.frequencies.max()
    }

    /// MΦ·diag(2ζω)·ΦᵀM.
    fn damping_matrix(&self, model: &Model, ratio: f64) -> DMatrix<f64> {
        let weighted = model.mass_matrix() * &self.vectors;
        let mut scaled = weighted.clone();
        for (mut column, frequency) in scaled.column_iter_mut().zip(&self.frequencies) {
            column *= 2.0 * ratio * frequency;
        }
        scaled * weighted.transpose()
    }
}

/// A model with its undamped modes, made when first asked for.
#[derive(Debug)]
pub struct CachedModel {
    /// The model.
    pub model: Model,
    /// By [`Rotation`].
    modes: [OnceLock<Result<RealModes, DecompositionError>>; 3],
    /// The linear motions that were asked for last, at a speed, with the meshes or without.
    linear: Mutex<Vec<(Key, Option<Arc<ModalStateSpace>>)>>,
    /// Models at the speeds [rad/s] of the last analyses, if bearings depend on the speed.
    at_speeds: Mutex<Vec<(f64, Arc<CachedModel>)>>,
}

/// A model at a constant speed: the model itself if nothing in it depends on the speed.
#[derive(Debug)]
pub enum AtSpeed<'a> {
    /// The model itself.
    Same(&'a CachedModel),
    /// A model whose bearings have the coefficients of the speed.
    Specialised(Arc<CachedModel>),
}

impl Deref for AtSpeed<'_> {
    type Target = CachedModel;

    fn deref(&self) -> &CachedModel {
        match self {
            Self::Same(model) => model,
            Self::Specialised(model) => model,
        }
    }
}

type Key = (f64, bool);

/// A study asks for a handful of speeds again and again.
const REMEMBERED: usize = 8;

impl CachedModel {
    /// The basis of a model.
    pub fn new(model: Model) -> Self {
        Self {
            model,
            modes: [const { OnceLock::new() }; 3],
            linear: Mutex::new(Vec::new()),
            at_speeds: Mutex::default(),
        }
    }

    /// The model at a constant speed of the reference shaft, rad/s; see [`Model::at_speed`].
    ///
    /// # Errors
    /// [`SceneError`] if a bearing has no coefficients at the speed.
    pub fn at_speed(&self, speed: f64) -> Result<AtSpeed<'_>, SceneError> {
        if self.model.bearings.is_empty() {
            return Ok(AtSpeed::Same(self));
        }
        let mut list = self.at_speeds.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, known)) = list.iter().find(|(known, _)| *known == speed) {
            return Ok(AtSpeed::Specialised(Arc::clone(known)));
        }
        let model = Arc::new(Self::new(self.model.at_speed(speed)?));
        if list.len() >= REMEMBERED {
            list.remove(0);
        }
        list.push((speed, Arc::clone(&model)));
        Ok(AtSpeed::Specialised(model))
    }

    /// Undamped modes, with the flanks that carry at `speed`.
    ///
    /// # Errors
    /// [`DecompositionError`] if the decomposition fails, or a bearing depends on the speed.
    pub fn real_modes(&self, speed: f64) -> Result<&RealModes, DecompositionError> {
        if !self.model.bearings.is_empty() {
            return Err(DecompositionError::SpeedDependent);
        }
        let cell = &self.modes[self.model.rotation(speed) as usize];
        cell.get_or_init(|| RealModes::new(&self.model, speed)).as_ref().map_err(|error| *error)
    }

    /// The linear motion at `speed` of the reference shaft.
    ///
    /// # Errors
    /// [`DecompositionError`] if a decomposition fails.
    pub fn linear(&self, speed: f64) -> Result<Arc<ModalStateSpace>, DecompositionError> {
        if let Some(Some(linear)) = self.known((speed, true)) {
            return Ok(linear);
        }
        let linear = Arc::new(ModalStateSpace::new(self, speed)?);
        self.remember((speed, true), Some(Arc::clone(&linear)));
        Ok(linear)
    }

    /// The linear motion of the shafts alone, in parts that only the meshes couple; none where modes do not carry it.
    ///
    /// # Errors
    /// [`DecompositionError`] if a decomposition fails.
    pub fn linear_of_parts(&self, speed: f64) -> Result<Option<Arc<ModalStateSpace>>, DecompositionError> {
        if let Some(linear) = self.known((speed, false)) {
            return Ok(linear);
        }
        let linear = ModalStateSpace::of_parts(self, speed)?.map(Arc::new);
        self.remember((speed, false), linear.clone());
        Ok(linear)
    }

    fn known(&self, key: Key) -> Option<Option<Arc<ModalStateSpace>>> {
        // A panic elsewhere leaves the list as it was.
        let list = self.linear.lock().unwrap_or_else(PoisonError::into_inner);
        list.iter().find(|(known, _)| *known == key).map(|(_, linear)| linear.clone())
    }

    fn remember(&self, key: Key, linear: Option<Arc<ModalStateSpace>>) {
        let mut list = self.linear.lock().unwrap_or_else(PoisonError::into_inner);
        if list.len() >= REMEMBERED {
            list.remove(0);
        }
        list.push((key, linear));
    }

    /// Damping C of shafts, bearings and meshes, with the modal damping.
    ///
    /// # Errors
    /// [`DecompositionError`] if the modes that modal damping needs cannot be found.
    pub fn damping_matrix(&self, speed: f64) -> Result<DMatrix<f64>, DecompositionError> {
        let mut matrix = self.model.damping_matrix(speed);
        if let Some(modal) = self.modal_damping_matrix(speed)? {
            matrix += modal;
        }
        Ok(matrix)
    }

    /// The modal damping alone, where the scene has any.
    ///
    /// # Errors
    /// [`DecompositionError`] if the modes cannot be found.
    pub fn modal_damping_matrix(&self, speed: f64) -> Result<Option<DMatrix<f64>>, DecompositionError> {
        let ratio = self.model.scene.modal_damping;
        if ratio == 0.0 {
            return Ok(None);
        }
        Ok(Some(self.real_modes(speed)?.damping_matrix(&self.model, ratio)))
    }
}

/// The same modes, those of equal frequency turned to lie in one plane of one shaft each as far as they can: an
/// eigensolver mixes them, and what does not couple would look as if it did. `square` gives ω².
fn aligned(model: &Model, mut vectors: DMatrix<f64>, known: usize, square: impl Fn(&[f64]) -> f64) -> DMatrix<f64> {
    let squares: Vec<f64> = vectors.column_iter().map(|column| square(column.as_slice())).collect();
    // Every shaft and plane has a weight of its own.
    let mut weights = DVector::zeros(model.len());
    for dof in model.numbering.dofs() {
        let plane = if matches!(dof.kind, DofKind::V | DofKind::Gamma) { 0.0 } else { 0.37 };
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
            let turn = ((&form + form.transpose()) / 2.0).symmetric_eigen().eigenvectors;
            vectors.columns_mut(first, count).copy_from(&(cluster * turn));
        }
        first += count;
    }
    vectors
}

/// Orthonormal motions (in M), one a column, among rigid ones of shafts: those that leave the springs alone whose
/// `deflections` are given.
fn null_motions(
    rigid: &DMatrix<f64>,
    deflections: &DMatrix<f64>,
    mass: &DMatrix<f64>,
) -> Result<DMatrix<f64>, DecompositionError> {
    let mut rigid = rigid.clone();
    let mut deflections = deflections * &rigid;
    // Translation, tilt and twist have units of their own: each motion is scaled to deflect the springs by one in all.
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
    let free: Vec<usize> = (0..size).filter(|i| pencil.values[*i] <= NULL).collect();
    let motions = rigid * pencil.vectors.select_columns(&free);
    let kinetic = motions.transpose() * mass * &motions;
    let size = free.len();
    Ok(motions * symmetric_pencil(&DMatrix::identity(size, size), &kinetic, &none(size))?.vectors)
}

/// What springs of unit stiffness in the place of bearings are deflected by, one a row, and in that of meshes with the
/// flanks that carry at a speed.
fn deflections(model: &Model, speed: Option<f64>) -> DMatrix<f64> {
    let mut rows = Vec::new();
    for support in &model.supports {
        for [along_v, along_w] in support.directions() {
            let mut row = RowDVector::zeros(model.len());
            (row[support.index], row[support.index + 1]) = (along_v, along_w);
            rows.push(row);
        }
    }
    for connection in speed.iter().flat_map(|speed| model.connections(*speed)) {
        for entries in connection.rows() {
            let mut row = RowDVector::zeros(model.len());
            entries.iter().for_each(|(column, coefficient)| row[*column] += coefficient);
            rows.push(row);
        }
    }
    if rows.is_empty() { DMatrix::zeros(1, model.len()) } else { DMatrix::from_rows(&rows) }
}

/// The rigid motions of every shaft on its own, one a column.
fn rigid_motions(model: &Model) -> DMatrix<f64> {
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
        if let Some(start) = model.numbering.torsion(shaft) {
            push(&|node, _, column| column[start + node] = 1.0);
        }
    }
    DMatrix::from_columns(&columns)
}

/// How many of the coordinates of a model bend.
pub(super) fn lateral_mask(model: &Model) -> Vec<bool> {
    let mut mask = vec![false; model.len()];
    for dof in model.numbering.dofs() {
        mask[dof.index] = matches!(dof.kind, DofKind::V | DofKind::W | DofKind::B | DofKind::Gamma);
    }
    mask
}
