//! State-space model of all linear forces at one speed, in modal coordinates: ż = A z + b.
//!
//! The first-order form ẏ = A y over y = (ωη, η̇) ([`super::first_order`]) is decoupled into pairs of real coordinates
//! ([`super::pairs`]). Vectors are scaled in y, where |y|² is twice the energy; |z| is therefore an energy norm as far
//! as the modes are orthogonal.
//!
//! Nearly parallel modes, for example at critical damping, lose digits. Their condition number measures this loss. If
//! it exceeds [`MAX_CONDITION`], z is y itself and A is a dense matrix.

use std::ops::Range;

use nalgebra::{DMatrix, DVector, DVectorView};
use num_complex::Complex64;

use super::first_order::FirstOrder;
use super::pairs::{ModePair, Pairs};
use crate::linalg::{DecompositionError, LANES, matrix_of_columns};
use crate::modal::undamped::RealModes;
use crate::model::Model;

/// Smallest ratio of a growth rate Re λ to |λ| and to the speed that counts as unstable; round-off causes smaller ones.
const MIN_GROWTH: f64 = 1e-6;

/// Largest accepted condition number κ of the modes. Results lose about log₁₀ κ digits.
pub const MAX_CONDITION: f64 = 1e8;

/// The matrix A of ż = A z.
#[derive(Clone, Debug)]
pub enum StateMatrix {
    /// Block-diagonal: one 2 × 2 block per slot.
    Pairs(Vec<ModePair>),
    /// Dense, 2·slots × 2·slots.
    Dense(DMatrix<f64>),
}

/// Linear model at one speed. Slot k has the entries k and slots + k of the state z.
#[derive(Clone, Debug)]
pub struct ModalStateSpace {
    /// The matrix A.
    pub matrix: StateMatrix,
    /// Entries a, b, c, d of the blocks [[a, b], [c, d]] of A, one per slot, 1/s; empty if A is dense.
    pub blocks: [Vec<f64>; 4],
    /// Number of modes.
    pub modes: usize,
    /// Number of slots with padding; z has twice as many entries.
    pub slots: usize,
    /// Condition number of the modes, the largest ‖left vectors‖·‖right vectors‖; 1 for orthogonal modes.
    pub condition: f64,
    /// Spectral radius, the largest |λ|, rad/s; for a dense A its Frobenius norm, which is an upper bound.
    pub radius: f64,
    /// Whether A contains the mean stiffness and damping of the meshes.
    pub includes_meshes: bool,
    /// Slots of each uncoupled part.
    pub parts: Vec<Range<usize>>,
    /// Q of q = Q z, n × 2·slots.
    pub(in crate::modal) displacement: DMatrix<f64>,
    /// V of q̇ = V z, n × 2·slots.
    velocity: DMatrix<f64>,
    /// P of z = P M q + R M q̇, 2·slots × n.
    from_displacement: DMatrix<f64>,
    /// R of z = P M q + R M q̇, 2·slots × n; a force f gives ż = A z + R f.
    pub(in crate::modal) from_velocity: DMatrix<f64>,
}

impl ModalStateSpace {
    /// Model of the complete system, with the mean mesh stiffness at rest.
    pub(in crate::modal) fn new(real: &RealModes, order: &FirstOrder) -> Result<Self, DecompositionError> {
        let pairs = Pairs::new(real, order)?;
        let (matrix, right, left, condition) = match pairs {
            Some(Pairs { pairs, right, left, condition }) if condition <= MAX_CONDITION => {
                (StateMatrix::Pairs(pairs), right, left, condition)
            }
            other => {
                let size = 2 * real.frequencies.len();
                let condition = other.map_or(f64::INFINITY, |pairs| pairs.condition);
                let identity = DMatrix::identity(size, size);
                (StateMatrix::Dense(order.full_matrix()), identity.clone(), identity, condition)
            }
        };
        Ok(Self::assemble(true, condition, vec![(matrix, Maps::new(real, order, &right, &left))]))
    }

    /// Model at `speed` of the reference shaft, rad/s, without meshes: the bending and the torsion of every shaft are
    /// uncoupled parts. `None` if the modes are too ill-conditioned, or if the scene has modal damping, which couples
    /// the parts.
    pub(in crate::modal) fn without_meshes(model: &Model, speed: f64) -> Result<Option<Self>, DecompositionError> {
        if !model.scene.modal_damping.is_zero() {
            return Ok(None);
        }
        let damping = model.damping_matrix_without_meshes() + model.gyroscopic_matrix() * speed;
        let skew_part = model.skew_part_matrix();
        let (mut largest, mut parts) = (1.0_f64, Vec::new());
        for real in RealModes::without_meshes(model)? {
            let order = FirstOrder::new(&real, &damping, &skew_part);
            match Pairs::new(&real, &order)? {
                Some(Pairs { pairs, right, left, condition }) if condition <= MAX_CONDITION => {
                    largest = largest.max(condition);
                    parts.push((StateMatrix::Pairs(pairs), Maps::new(&real, &order, &right, &left)));
                }
                _ => return Ok(None),
            }
        }
        Ok(Some(Self::assemble(false, largest, parts)))
    }

    /// Combines uncoupled parts and pads their slots; a dense part is the only one.
    fn assemble(includes_meshes: bool, condition: f64, given: Vec<(StateMatrix, Maps)>) -> Self {
        let mut parts: Vec<Range<usize>> = Vec::with_capacity(given.len());
        let modes = given.iter().map(|(_, maps)| maps.slots()).sum();
        for (_, maps) in &given {
            let begin = parts.last().map_or(0, |before| before.end);
            parts.push(begin..begin + maps.slots().next_multiple_of(LANES));
        }
        let slots = parts.last().map_or(0, |last| last.end);
        let rows = given.first().map_or(0, |(_, maps)| maps.0[0].nrows());
        let mut padded = Maps(std::array::from_fn(|_| DMatrix::zeros(rows, 2 * slots)));
        let mut pairs = Vec::with_capacity(slots);
        let mut dense = None;
        for ((matrix, maps), part) in given.into_iter().zip(&parts) {
            let used = maps.slots();
            let place = |entry: usize| part.start + if entry < used { entry } else { slots + entry - used };
            padded.insert(&maps, place);
            match matrix {
                StateMatrix::Dense(matrix) => dense = Some(pad(&matrix, 2 * slots, place)),
                StateMatrix::Pairs(own) => {
                    pairs.extend(own);
                    pairs.resize(part.end, ModePair::Real([0.0; 2]));
                }
            }
        }
        let matrix = dense.map_or(StateMatrix::Pairs(pairs), StateMatrix::Dense);
        let Maps([displacement, velocity, from_displacement, from_velocity]) = padded;
        Self {
            blocks: blocks(&matrix),
            radius: radius(&matrix),
            matrix,
            modes,
            slots,
            condition,
            includes_meshes,
            parts,
            displacement,
            velocity,
            from_displacement: from_displacement.transpose(),
            from_velocity: from_velocity.transpose(),
        }
    }

    /// Whether modes are so nearly parallel that A is dense: neither propagators nor reductions exist.
    pub fn is_parallel(&self) -> bool {
        matches!(self.matrix, StateMatrix::Dense(_))
    }

    /// The mode pairs, one for each slot; none if A is dense.
    pub fn pairs(&self) -> &[ModePair] {
        if let StateMatrix::Pairs(pairs) = &self.matrix { pairs } else { &[] }
    }

    /// Number of entries of z.
    pub fn len(&self) -> usize {
        2 * self.slots
    }

    /// Whether z has no entries.
    pub fn is_empty(&self) -> bool {
        self.slots == 0
    }

    /// State z of displacements q and velocities v, n entries each; `model` is the one this was made from.
    pub fn state(&self, model: &Model, q: &[f64], v: &[f64]) -> DVector<f64> {
        let mass_times = |x: &[f64]| {
            let mut out = vec![0.0; x.len()];
            model.multiply_mass(x, &mut out);
            DVector::from_vec(out)
        };
        &self.from_displacement * mass_times(q) + &self.from_velocity * mass_times(v)
    }

    /// Displacements q and velocities q̇ of a state z, n entries each.
    pub fn motion(&self, z: &[f64]) -> (DVector<f64>, DVector<f64>) {
        let z = DVector::from_column_slice(z);
        (&self.displacement * &z, &self.velocity * &z)
    }

    /// Complex displacement amplitudes q̂, n entries, with q = Re(q̂ e^{iϑ}), under a force that rotates with `spin`,
    /// rad/s.
    ///
    /// `force` gives its values at the shaft angles ϑ = 0 and ϑ = π/2 as entries (index, value). `None` if A is dense,
    /// or if a mode is in undamped resonance.
    pub fn synchronous(&self, spin: f64, force: &[Vec<(usize, f64)>; 2]) -> Option<DVector<Complex64>> {
        let StateMatrix::Pairs(pairs) = &self.matrix else {
            return None;
        };
        // The force is Re((b_c − i b_s) e^{iϑ}).
        let [cosine, sine] = force.each_ref().map(|force| self.column(force));
        let mut state = DVector::zeros(self.len());
        for (slot, pair) in pairs.iter().enumerate() {
            let [x, y] = [slot, self.slots + slot].map(|at| Complex64::new(cosine[at], -sine[at]));
            if x == Complex64::ZERO && y == Complex64::ZERO {
                continue;
            }
            // (iΩ − A)⁻¹ by Cramer's rule.
            let [[a, b], [c, d]] = pair.block();
            let (first, second) = (Complex64::new(-a, spin), Complex64::new(-d, spin));
            let determinant = first * second - b * c;
            if determinant == Complex64::ZERO {
                return None;
            }
            state[slot] = (second * x + b * y) / determinant;
            state[self.slots + slot] = (first * y + c * x) / determinant;
        }
        let parts = |part: fn(&Complex64) -> f64| &self.displacement * state.map(|value| part(&value));
        let (re, im) = (parts(|value| value.re), parts(|value| value.im));
        Some(DVector::from_fn(re.len(), |i, _| Complex64::new(re[i], im[i])))
    }

    /// Displacements of the growing modes at `speed` of the reference shaft, rad/s, n × k: of the modes and of their duals,
    /// to which a force is projected. A Galerkin projection on a space that contains them keeps their eigenvalues. Empty if A
    /// is dense.
    pub fn growing_shapes(&self, speed: f64) -> DMatrix<f64> {
        let mut shapes = Vec::new();
        for (slot, pair) in self.pairs().iter().enumerate() {
            let grows = pair.eigenvalues().map(|value| is_growing(value, speed));
            let entries = [slot, self.slots + slot].into_iter().zip(grows);
            for (entry, _) in entries.filter(|(_, grows)| *grows) {
                shapes.push(self.displacement.column(entry).into_owned());
                shapes.push(self.from_velocity.row(entry).transpose());
            }
        }
        matrix_of_columns(self.displacement.nrows(), &shapes)
    }

    /// Eigenvalues of A, rad/s, without those of rigid-body motions; none if A is dense.
    pub fn eigenvalues(&self) -> Vec<Complex64> {
        let pairs = self.pairs();
        let used = pairs.iter().take(if self.parts.len() > 1 { pairs.len() } else { self.modes });
        used.filter(|pair| !matches!(pair, ModePair::RigidBodyPair(_))).flat_map(ModePair::eigenvalues).collect()
    }

    /// Output row w of the scalar w·z = Σ coefficient·qᵢ over the entries (i, coefficient) of `scalar`; with
    /// `rate` that of its time derivative.
    pub fn row(&self, scalar: &[(usize, f64)], rate: bool) -> Vec<f64> {
        let matrix = if rate { &self.velocity } else { &self.displacement };
        let mut row = vec![0.0; self.len()];
        for (index, coefficient) in scalar {
            for (row, value) in row.iter_mut().zip(matrix.row(*index).iter()) {
                *row += coefficient * value;
            }
        }
        row
    }

    /// Row w A: with it, w·z has the rate w A z under no force.
    pub fn rate_row(&self, row: &[f64]) -> Vec<f64> {
        let (x, y) = row.split_at(self.slots);
        match &self.matrix {
            StateMatrix::Pairs(_) => {
                let [a, b, c, d] = &self.blocks;
                let first = (0..self.slots).map(|slot| x[slot] * a[slot] + y[slot] * c[slot]);
                first.chain((0..self.slots).map(|slot| x[slot] * b[slot] + y[slot] * d[slot])).collect()
            }
            StateMatrix::Dense(matrix) => {
                let product = |column: DVectorView<'_, f64>| column.iter().zip(row).map(|(entry, w)| entry * w).sum();
                matrix.column_iter().map(product).collect()
            }
        }
    }

    /// Input column b of a force with the entries (index, value), for ż = A z + b.
    pub fn column(&self, force: &[(usize, f64)]) -> Vec<f64> {
        let mut column = vec![0.0; self.len()];
        for (index, value) in force {
            for (column, entry) in column.iter_mut().zip(self.from_velocity.column(*index).iter()) {
                *column += value * entry;
            }
        }
        column
    }

    /// `out = A z`.
    pub fn multiply(&self, z: &[f64], out: &mut [f64]) {
        let (x, y) = z.split_at(self.slots);
        match &self.matrix {
            StateMatrix::Pairs(_) => {
                let (out_x, out_y) = out.split_at_mut(self.slots);
                let [a, b, c, d] = &self.blocks;
                for slot in 0..self.slots {
                    out_x[slot] = a[slot] * x[slot] + b[slot] * y[slot];
                    out_y[slot] = c[slot] * x[slot] + d[slot] * y[slot];
                }
            }
            StateMatrix::Dense(matrix) => {
                out.fill(0.0);
                for (column, z) in matrix.column_iter().zip(z) {
                    for (out, entry) in out.iter_mut().zip(column.iter()) {
                        *out += entry * z;
                    }
                }
            }
        }
    }

    /// Smallest distance |iΩ − λ| of the spin Ω to an eigenvalue of an oscillation, rad/s; zero if A is dense, because
    /// its eigenvalues are unknown.
    pub fn resonance_distance(&self, spin: f64) -> f64 {
        let at = Complex64::new(0.0, spin.abs());
        match &self.matrix {
            StateMatrix::Pairs(pairs) => {
                let oscillations = pairs.iter().filter_map(|pair| match pair {
                    ModePair::Oscillation(value) => Some((at - value).norm()),
                    _ => None,
                });
                oscillations.fold(f64::INFINITY, f64::min)
            }
            StateMatrix::Dense(_) => 0.0,
        }
    }
}

/// The matrices Q, V, Pᵀ and Rᵀ of q = Q z, q̇ = V z and z = P M q + R M q̇, each n × 2·slots.
struct Maps([DMatrix<f64>; 4]);

impl Maps {
    /// Maps of z with y = `right` z and z = `left` y.
    fn new(real: &RealModes, order: &FirstOrder, right: &DMatrix<f64>, left: &DMatrix<f64>) -> Self {
        let [q, v] = order.physical_maps(real, right);
        let [from_q, from_v] = order.state_maps(real, left);
        Self([q, v, from_q, from_v])
    }

    /// Number of slots.
    fn slots(&self) -> usize {
        self.0[0].ncols() / 2
    }

    /// Copies the columns of a part to their places.
    fn insert(&mut self, part: &Self, place: impl Fn(usize) -> usize) {
        for (padded, columns) in self.0.iter_mut().zip(&part.0) {
            for (entry, column) in columns.column_iter().enumerate() {
                padded.set_column(place(entry), &column);
            }
        }
    }
}

/// Copies a matrix into a zero matrix of `size` rows and columns; `place` gives the new index of a row or column.
fn pad(matrix: &DMatrix<f64>, size: usize, place: impl Fn(usize) -> usize) -> DMatrix<f64> {
    let mut padded = DMatrix::zeros(size, size);
    for (column, values) in matrix.column_iter().enumerate() {
        for (row, value) in values.iter().enumerate() {
            padded[(place(row), place(column))] = *value;
        }
    }
    padded
}

/// Entries a, b, c, d of the 2 × 2 blocks, one list each; empty for a dense matrix.
fn blocks(matrix: &StateMatrix) -> [Vec<f64>; 4] {
    let mut blocks: [Vec<f64>; 4] = std::array::from_fn(|_| Vec::new());
    if let StateMatrix::Pairs(pairs) = matrix {
        for pair in pairs {
            for (list, entry) in blocks.iter_mut().zip(pair.block().as_flattened()) {
                list.push(*entry);
            }
        }
    }
    blocks
}

/// Largest |λ|, rad/s, or an upper bound of it.
fn radius(matrix: &StateMatrix) -> f64 {
    match matrix {
        StateMatrix::Pairs(pairs) => pairs.iter().map(ModePair::largest).fold(0.0, f64::max),
        StateMatrix::Dense(matrix) => matrix.norm(),
    }
}

/// Whether a mode with the eigenvalue λ, rad/s, grows at a speed of the reference shaft, rad/s.
pub fn is_growing(eigenvalue: Complex64, speed: f64) -> bool {
    eigenvalue.re > MIN_GROWTH * eigenvalue.norm().max(speed.abs())
}
