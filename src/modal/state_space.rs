//! Everything linear at one speed as independent pairs of real coordinates, ż = A z.
//!
//! In undamped modes η, with x = ωη for each elastic one, the motion is ẏ = A y over y = (x, η̇) (see [`super::complex`]).
//! An eigenvalue λ = a ± ib with the vector r ± is of A gives the pair of coordinates along r and s, which moves by
//! [[a, b], [−b, a]]; a null motion is a pair of position and velocity, with the real eigenvalue that damps it or with
//! none; what is left of the real eigenvalues stands two and two. Lengths are those of y, the energy norm, so that |z|
//! is an energy norm as far as the modes are orthogonal.
//!
//! Modes that are nearly parallel, as at critical damping, cannot carry a motion to the last digits. How far they are
//! from it is the condition number; beyond [`WORST`] the motion stays in y, and A is dense.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};
use num_complex::Complex64;

use super::CachedModel;
use super::damped::FirstOrder;
use super::pairs::{ModePair, Pairs};
use super::real::RealModes;
use crate::linalg::DecompositionError;

/// The slots of every part are padded to a multiple of this, so that loops over them need no remainder.
pub const LANES: usize = 8;
/// The largest condition number of modes that carry a motion: they lose as many digits.
pub const WORST: f64 = 1e8;

/// The linear motion.
#[derive(Clone, Debug)]
pub enum Form {
    /// Pairs, as many as degrees of freedom.
    Pairs(Vec<ModePair>),
    /// A itself.
    Dense(DMatrix<f64>),
}

/// Everything linear at one speed. A state z holds the first coordinate of each slot, then the second of each.
#[derive(Clone, Debug)]
pub struct ModalStateSpace {
    /// How z moves by itself.
    pub form: Form,
    /// Lists of a, b, c, d of the blocks [[a, b], [c, d]] of A, where it has them.
    pub blocks: [Vec<f64>; 4],
    /// Slots, padded: z has twice as many entries.
    pub slots: usize,
    /// κ of the modes, the largest of ‖left vector‖·‖right vector‖; one where they are orthogonal.
    pub condition: f64,
    /// The largest |λ|, rad/s.
    pub radius: f64,
    /// Whether it contains the mean stiffness and damping of the meshes.
    pub meshed: bool,
    /// Slots of the parts that nothing couples in it.
    pub parts: Vec<Range<usize>>,
    /// q = Q z.
    displacement: DMatrix<f64>,
    /// q̇ = V z.
    velocity: DMatrix<f64>,
    /// z of a displacement, by M q.
    from_displacement: DMatrix<f64>,
    /// z of a velocity, by M q̇; ż of a force.
    from_velocity: DMatrix<f64>,
}

impl ModalStateSpace {
    /// The linear motion at `speed` of the reference shaft, with the mean mesh at rest.
    ///
    /// # Errors
    /// [`DecompositionError`] if a decomposition fails.
    pub fn new(cached: &CachedModel, speed: f64) -> Result<Self, DecompositionError> {
        let real = cached.real_modes(speed)?;
        let order = FirstOrder::of_train(cached, speed)?;
        let pairs = Pairs::new(real, &order)?;
        let (form, right, left, condition) = match pairs {
            Some(Pairs { pairs, right, left, condition }) if condition <= WORST => {
                (Form::Pairs(pairs), right, left, condition)
            }
            other => {
                let size = 2 * real.frequencies.len();
                let condition = other.map_or(f64::INFINITY, |pairs| pairs.condition);
                let identity = DMatrix::identity(size, size);
                (Form::Dense(order.whole()), identity.clone(), identity, condition)
            }
        };
        Ok(Self::assemble(true, condition, vec![(form, columns(real, &order, &right, &left))]))
    }

    /// The linear motion at `speed` of the shafts on their bearings, each as if it were alone: the bending of every shaft
    /// and its twist are parts that nothing couples. None where modes do not carry it.
    ///
    /// # Errors
    /// [`DecompositionError`] if a decomposition fails.
    pub fn of_parts(cached: &CachedModel, speed: f64) -> Result<Option<Self>, DecompositionError> {
        let model = &cached.model;
        if model.scene.modal_damping > 0.0 {
            return Ok(None);
        }
        let damping = model.unmeshed_damping_matrix() + model.gyroscopic_matrix() * speed;
        let skew_part = model.skew_part_matrix();
        let (mut worst, mut parts) = (1.0_f64, Vec::new());
        for real in RealModes::of_parts(model)? {
            let order = FirstOrder::new(&real, &damping, &skew_part);
            match Pairs::new(&real, &order)? {
                Some(Pairs { pairs, right, left, condition }) if condition <= WORST => {
                    worst = worst.max(condition);
                    parts.push((Form::Pairs(pairs), columns(&real, &order, &right, &left)));
                }
                _ => return Ok(None),
            }
        }
        Ok(Some(Self::assemble(false, worst, parts)))
    }

    /// The motion of the pairs in `slots` alone; none of a motion that is not in pairs.
    pub fn keeping(&self, slots: &[usize]) -> Option<Self> {
        let Form::Pairs(pairs) = &self.form else {
            return None;
        };
        let both: Vec<usize> = slots.iter().copied().chain(slots.iter().map(|slot| self.slots + slot)).collect();
        let pairs = slots.iter().map(|slot| pairs[*slot]).collect();
        let columns = [
            self.displacement.select_columns(&both),
            self.velocity.select_columns(&both),
            self.from_displacement.select_rows(&both).transpose(),
            self.from_velocity.select_rows(&both).transpose(),
        ];
        Some(Self::assemble(self.meshed, self.condition, vec![(Form::Pairs(pairs), columns)]))
    }

    /// Of a state, a row or a column over all slots, the entries of the `slots` that this motion keeps.
    pub fn of_kept(&self, all: &[f64], slots: &[usize]) -> Vec<f64> {
        let mut kept = vec![0.0; self.len()];
        for (to, from) in slots.iter().enumerate() {
            kept[to] = all[*from];
            kept[self.slots + to] = all[all.len() / 2 + from];
        }
        kept
    }

    /// The `count` slots that loads move most, in the order in which they stand, given columns b of the loads.
    ///
    /// A load that jumps now and then has amplitudes that fall with the frequency, so what it moves a mode by goes like
    /// the static displacement |b|/|λ|² over |λ|. Of every load each mode has a share; its largest counts.
    pub fn most_moved(&self, columns: &[Vec<f64>], count: usize) -> Vec<usize> {
        let Form::Pairs(pairs) = &self.form else {
            return Vec::new();
        };
        // What nothing restores is always kept.
        let coasts = |pair: &ModePair| matches!(pair, ModePair::RigidBodyPair(_));
        let mut largest: Vec<f64> = pairs.iter().map(|pair| if coasts(pair) { f64::INFINITY } else { 0.0 }).collect();
        for column in columns {
            let moved = |(slot, pair): (usize, &ModePair)| match column[slot].hypot(column[self.slots + slot]) {
                load if load > 0.0 && !coasts(pair) => load / pair.slowest().powi(3),
                _ => 0.0,
            };
            let moved: Vec<f64> = pairs.iter().enumerate().map(moved).collect();
            let total = moved.iter().sum::<f64>();
            for (largest, moved) in largest.iter_mut().zip(moved).filter(|(_, moved)| *moved > 0.0) {
                *largest = largest.max(moved / total);
            }
        }
        let mut order: Vec<usize> = (0..pairs.len()).collect();
        order.sort_by(|a, b| largest[*b].total_cmp(&largest[*a]));
        order.truncate(count);
        order.sort_unstable();
        order
    }

    /// The motion with room in its slots: the form of every part, of which a dense one is the only one, with the columns
    /// of its coordinates.
    fn assemble(meshed: bool, condition: f64, given: Vec<(Form, Columns)>) -> Self {
        let mut parts: Vec<Range<usize>> = Vec::with_capacity(given.len());
        for (_, columns) in &given {
            let begin = parts.last().map_or(0, |before| before.end);
            parts.push(begin..begin + (columns[0].ncols() / 2).next_multiple_of(LANES));
        }
        let slots = parts.last().map_or(0, |last| last.end);
        let rows = given.first().map_or(0, |(_, columns)| columns[0].nrows());
        let mut padded: Columns = std::array::from_fn(|_| DMatrix::zeros(rows, 2 * slots));
        let mut pairs = Vec::with_capacity(slots);
        let mut dense = None;
        for ((form, columns), part) in given.into_iter().zip(&parts) {
            let used = columns[0].ncols() / 2;
            // The second coordinates of all parts begin at `slots`.
            let place = |column: usize| part.start + if column < used { column } else { slots + column - used };
            for (padded, columns) in padded.iter_mut().zip(columns) {
                for (index, column) in columns.column_iter().enumerate() {
                    padded.set_column(place(index), &column);
                }
            }
            match form {
                Form::Dense(matrix) => {
                    let mut padded = DMatrix::zeros(2 * slots, 2 * slots);
                    for (column, values) in matrix.column_iter().enumerate() {
                        for (row, value) in values.iter().enumerate() {
                            padded[(place(row), place(column))] = *value;
                        }
                    }
                    dense = Some(padded);
                }
                Form::Pairs(own) => {
                    pairs.extend(own);
                    pairs.resize(part.end, ModePair::Real([0.0; 2]));
                }
            }
        }
        let [displacement, velocity, from_displacement, from_velocity] = padded;
        let form = dense.map_or(Form::Pairs(pairs), Form::Dense);
        let radius = match &form {
            Form::Pairs(pairs) => pairs.iter().map(ModePair::radius).fold(0.0, f64::max),
            Form::Dense(matrix) => matrix.norm(),
        };
        let mut blocks: [Vec<f64>; 4] = std::array::from_fn(|_| Vec::new());
        if let Form::Pairs(pairs) = &form {
            for pair in pairs {
                for (list, entry) in blocks.iter_mut().zip(pair.block().as_flattened()) {
                    list.push(*entry);
                }
            }
        }
        Self {
            form,
            blocks,
            slots,
            condition,
            radius,
            meshed,
            parts,
            displacement,
            velocity,
            from_displacement: from_displacement.transpose(),
            from_velocity: from_velocity.transpose(),
        }
    }

    /// Length of z.
    pub fn len(&self) -> usize {
        2 * self.slots
    }

    /// Whether there is nothing to move.
    pub fn is_empty(&self) -> bool {
        self.slots == 0
    }

    /// z of displacements q and velocities v.
    pub fn state(&self, cached: &CachedModel, q: &[f64], v: &[f64]) -> DVector<f64> {
        let weigh = |x: &[f64]| {
            let mut out = vec![0.0; x.len()];
            cached.model.multiply_mass(x, &mut out);
            DVector::from_vec(out)
        };
        &self.from_displacement * weigh(q) + &self.from_velocity * weigh(v)
    }

    /// Displacements and velocities of z.
    pub fn motion(&self, z: &[f64]) -> (DVector<f64>, DVector<f64>) {
        let z = DVector::from_column_slice(z);
        (&self.displacement * &z, &self.velocity * &z)
    }

    /// Amplitudes of the displacements under a force that turns with `spin`, given by its values at ϑ = 0 and ϑ = π/2 as
    /// entries (index, value); none where no modes carry the motion, or nothing resists it.
    pub fn synchronous(&self, spin: f64, force: &[Vec<(usize, f64)>; 2]) -> Option<DVector<Complex64>> {
        let Form::Pairs(pairs) = &self.form else {
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

    /// The row w of a scalar Σ coefficient·q of its entries (index, coefficient), so that it is w·z; of its rate where
    /// `rate` says so.
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

    /// The column b of a force, entries (index, value), so that ż = A z + b.
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
        match &self.form {
            Form::Pairs(_) => {
                let (out_x, out_y) = out.split_at_mut(self.slots);
                let [a, b, c, d] = &self.blocks;
                for slot in 0..self.slots {
                    out_x[slot] = a[slot] * x[slot] + b[slot] * y[slot];
                    out_y[slot] = c[slot] * x[slot] + d[slot] * y[slot];
                }
            }
            Form::Dense(matrix) => {
                out.fill(0.0);
                for (column, z) in matrix.column_iter().zip(z) {
                    for (out, entry) in out.iter_mut().zip(column.iter()) {
                        *out += entry * z;
                    }
                }
            }
        }
    }

    /// The smallest |iΩ − λ| over the elastic modes, rad/s.
    pub fn nearest(&self, spin: f64) -> f64 {
        let at = Complex64::new(0.0, spin.abs());
        match &self.form {
            Form::Pairs(pairs) => {
                let oscillations = pairs.iter().filter_map(|pair| match pair {
                    ModePair::Oscillation(value) => Some((at - value).norm()),
                    _ => None,
                });
                oscillations.fold(f64::INFINITY, f64::min)
            }
            // Only modes tell; without them every speed may be a critical one.
            Form::Dense(_) => 0.0,
        }
    }
}

/// Q, V, and what measures z, transposed.
type Columns = [DMatrix<f64>; 4];

/// Those of pairs or of y itself.
fn columns(real: &RealModes, order: &FirstOrder, right: &DMatrix<f64>, left: &DMatrix<f64>) -> Columns {
    let (q, v) = order.physical(real);
    let (to_q, to_v) = order.measured(real);
    [q * right, v * right, (left * to_q).transpose(), (left * to_v).transpose()]
}
