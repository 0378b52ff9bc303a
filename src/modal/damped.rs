//! Damped modes at speed.
//!
//! In undamped modes η, with the displacement of each elastic one scaled by its ω (x = ωη), the motion is
//!
//! ```text
//! ẋ = ω η̇,        d(η̇)/dt = −ω x − D η̇ − N ω⁻¹ x,        D = Φᵀ(C + ΩG)Φ,    N = Φᵀ(K − K_restoring)Φ
//! ```
//!
//! Without damping the matrix is skew, so its eigenvalues are as well conditioned as they can be; faer does not
//! balance, and the raw matrix of M⁻¹K and M⁻¹C gives growth where there is none. Null motions have no x: nothing
//! depends on where they stand.

use nalgebra::{Complex, DMatrix, DVector};

use super::real::RealModes;
use super::whirl::{Whirl, classify};
use super::{CachedModel, real};
use crate::linalg::{DecompositionError, eigen};
use crate::model::Model;

/// Entries of D or N below this part of its largest do not couple a null motion to anything.
const UNCOUPLED: f64 = 1e-12;

/// One mode of vibration: a conjugate pair of eigenvalues, or a real one.
#[derive(Clone, Debug)]
pub struct Mode {
    /// λ, rad/s, imaginary part not negative.
    pub eigenvalue: Complex<f64>,
    /// φ in the inside order: φᴴMφ = 1, its largest entry real and positive.
    pub shape: DVector<Complex<f64>>,
    /// How it whirls.
    pub whirl: Whirl,
}

impl Mode {
    /// Damped frequency |Im λ|/2π, Hz.
    pub fn frequency_hz(&self) -> f64 {
        self.eigenvalue.im / (2.0 * std::f64::consts::PI)
    }

    /// Damping ratio −Re λ/|λ|, zero for a null motion.
    pub fn damping_ratio(&self) -> f64 {
        let size = self.eigenvalue.norm();
        if size == 0.0 { 0.0 } else { -self.eigenvalue.re / size }
    }
}

/// All modes at `speed` of the reference shaft, by ascending frequency.
///
/// # Errors
/// [`DecompositionError`] if a decomposition fails.
pub fn modes(cached: &CachedModel, speed: f64) -> Result<Vec<Mode>, DecompositionError> {
    let model = &cached.model;
    let real = cached.real_modes(speed)?;
    let order = FirstOrder::of_train(cached, speed)?;
    let (eigenvalues, coordinates) = if order.undamped { undamped(real) } else { damped(real, &order)? };
    let lateral = real::lateral_mask(model);
    let mass = model.mass_matrix();
    let named = |(eigenvalue, coordinates): (Complex<f64>, &DVector<Complex<f64>>)| {
        let shape = normalised(physical(real, coordinates));
        let whirl = classify(model, speed, eigenvalue, &shape, &mass, &lateral);
        Mode { eigenvalue, shape, whirl }
    };
    let mut modes: Vec<Mode> = eigenvalues.into_iter().zip(&coordinates).map(named).collect();
    modes.sort_by(|a, b| {
        a.eigenvalue.im.total_cmp(&b.eigenvalue.im).then(a.eigenvalue.norm().total_cmp(&b.eigenvalue.norm()))
    });
    Ok(modes)
}

/// The name of the mode of λ = `eigenvalue` and η = `coordinates` in undamped modes.
///
/// # Errors
/// [`DecompositionError`] if the undamped modes cannot be found.
pub fn whirl(
    cached: &CachedModel,
    speed: f64,
    eigenvalue: Complex<f64>,
    coordinates: &DVector<Complex<f64>>,
) -> Result<Whirl, DecompositionError> {
    let model = &cached.model;
    let shape = physical(cached.real_modes(speed)?, coordinates);
    Ok(classify(model, speed, eigenvalue, &shape, &model.mass_matrix(), &real::lateral_mask(model)))
}

/// φ = Φη.
fn physical(real: &RealModes, coordinates: &DVector<Complex<f64>>) -> DVector<Complex<f64>> {
    let part = |part: fn(&Complex<f64>) -> f64| &real.vectors * coordinates.map(|value| part(&value));
    let (re, im) = (part(|value| value.re), part(|value| value.im));
    DVector::from_fn(re.len(), |i, _| Complex::new(re[i], im[i]))
}

/// The first-order form over y = (x of elastic modes, η̇ of moving ones, η of null motions, η̇ of those that nothing
/// couples to anything).
#[derive(Clone, Debug)]
pub(super) struct FirstOrder {
    /// Modes with a frequency.
    pub elastic: Vec<usize>,
    /// These, and null motions whose velocity is coupled to theirs.
    pub moving: Vec<usize>,
    /// The matrix over the first two parts of y, which depend on nothing else.
    pub matrix: DMatrix<f64>,
    /// Whether there is neither damping nor gyroscopic coupling nor a bearing that does more than restore.
    pub undamped: bool,
    /// Null motions, and those of them that nothing couples to anything.
    null: Vec<usize>,
    alone: Vec<usize>,
}

impl FirstOrder {
    /// The first-order form of the whole train at `speed` of the reference shaft.
    pub fn of_train(cached: &CachedModel, speed: f64) -> Result<Self, DecompositionError> {
        let model = &cached.model;
        let damping = cached.damping_matrix(speed)? + model.gyroscopic_matrix() * speed;
        Ok(Self::new(cached.real_modes(speed)?, &damping, &model.skew_part_matrix()))
    }

    /// The first-order form over undamped modes, with C + ΩG and the part of K that does not restore.
    pub fn new(real: &RealModes, damping: &DMatrix<f64>, skew_part: &DMatrix<f64>) -> Self {
        let n = real.frequencies.len();
        let undamped = damping.amax() == 0.0 && skew_part.amax() == 0.0;
        let (damping, skew_part) = (project(real, damping), project(real, skew_part));

        let elastic: Vec<usize> = (real.null..n).filter(|i| real.frequencies[*i] > 0.0).collect();
        let null: Vec<usize> = (0..n).filter(|i| real.frequencies[*i] == 0.0).collect();
        let (damped, driven) = (UNCOUPLED * damping.amax(), UNCOUPLED * skew_part.amax());
        let coupled = |i: usize| {
            damping.row(i).amax() > damped || damping.column(i).amax() > damped || skew_part.row(i).amax() > driven
        };
        let moving: Vec<usize> = (0..n).filter(|i| real.frequencies[*i] > 0.0 || coupled(*i)).collect();
        let alone = null.iter().copied().filter(|i| !coupled(*i)).collect();
        let (e, m) = (elastic.len(), moving.len());

        let mut matrix = DMatrix::zeros(e + m, e + m);
        for (row, i) in moving.iter().enumerate() {
            for (column, j) in moving.iter().enumerate() {
                matrix[(e + row, e + column)] = -damping[(*i, *j)];
            }
            for (column, j) in elastic.iter().enumerate() {
                let own = if i == j { real.frequencies[*j] } else { 0.0 };
                matrix[(e + row, column)] = -own - skew_part[(*i, *j)] / real.frequencies[*j];
                if i == j {
                    matrix[(column, e + row)] = own;
                }
            }
        }
        Self { elastic, moving, matrix, undamped, null, alone }
    }

    /// The matrix over the whole of y.
    pub fn whole(&self) -> DMatrix<f64> {
        let block = self.matrix.nrows();
        let size = block + self.null.len() + self.alone.len();
        let mut matrix = DMatrix::zeros(size, size);
        matrix.view_mut((0, 0), (block, block)).copy_from(&self.matrix);
        for (index, mode) in self.null.iter().enumerate() {
            matrix[(block + index, self.rate(*mode))] = 1.0;
        }
        matrix
    }

    /// Where η̇ of a mode stands in y.
    fn rate(&self, mode: usize) -> usize {
        let find = |list: &[usize]| list.iter().position(|i| *i == mode);
        match find(&self.moving) {
            Some(row) => self.elastic.len() + row,
            None => self.matrix.nrows() + self.null.len() + find(&self.alone).unwrap_or_default(),
        }
    }

    /// Calls `visit(mode, where η stands, its scale, where η̇ stands)` for every mode: η is its scale times y.
    fn for_each(&self, real: &RealModes, mut visit: impl FnMut(usize, usize, f64, usize)) {
        for (index, mode) in self.elastic.iter().enumerate() {
            visit(*mode, index, 1.0 / real.frequencies[*mode], self.rate(*mode));
        }
        for (index, mode) in self.null.iter().enumerate() {
            visit(*mode, self.matrix.nrows() + index, 1.0, self.rate(*mode));
        }
    }

    /// Matrices of q and of q̇ over y.
    pub fn physical(&self, real: &RealModes) -> (DMatrix<f64>, DMatrix<f64>) {
        let (n, size) = real.vectors.shape();
        let (mut displacement, mut velocity) = (DMatrix::zeros(n, 2 * size), DMatrix::zeros(n, 2 * size));
        self.for_each(real, |mode, place, scale, rate| {
            displacement.set_column(place, &(real.vectors.column(mode) * scale));
            velocity.set_column(rate, &real.vectors.column(mode));
        });
        (displacement, velocity)
    }

    /// Matrices of y over M q and over M q̇.
    pub fn measured(&self, real: &RealModes) -> (DMatrix<f64>, DMatrix<f64>) {
        let (n, size) = real.vectors.shape();
        let (mut displacement, mut velocity) = (DMatrix::zeros(2 * size, n), DMatrix::zeros(2 * size, n));
        self.for_each(real, |mode, place, scale, rate| {
            displacement.set_row(place, &(real.vectors.column(mode) / scale).transpose());
            velocity.set_row(rate, &real.vectors.column(mode).transpose());
        });
        (displacement, velocity)
    }
}

type Pairs = (Vec<Complex<f64>>, Vec<DVector<Complex<f64>>>);

fn undamped(real: &RealModes) -> Pairs {
    let n = real.frequencies.len();
    let axis = |i: usize| DVector::from_fn(n, |k, _| Complex::new(if k == i { 1.0 } else { 0.0 }, 0.0));
    let eigenvalues = real.frequencies.iter().map(|frequency| Complex::new(0.0, *frequency)).collect();
    (eigenvalues, (0..n).map(axis).collect())
}

/// Eigenvalues with Im λ ≥ 0, and η normalised to unit length.
fn damped(real: &RealModes, order: &FirstOrder) -> Result<Pairs, DecompositionError> {
    let n = real.frequencies.len();
    let FirstOrder { elastic, moving, matrix, .. } = order;
    let (e, m) = (elastic.len(), moving.len());
    let eigen = eigen(matrix)?;

    // Null motions: one mode each for where they stand; their velocities are among the others where they couple.
    let mut eigenvalues = vec![Complex::new(0.0, 0.0); n - e];
    let zero = |i: usize| real.frequencies[i] == 0.0;
    let mut coordinates: Vec<_> = (0..n)
        .filter(|i| zero(*i))
        .map(|i| DVector::from_fn(n, |k, _| Complex::new(if k == i { 1.0 } else { 0.0 }, 0.0)))
        .collect();
    let nothing = f64::EPSILON * matrix.amax() * (e + m) as f64;
    for (value, vector) in eigen.values.iter().zip(eigen.vectors.column_iter()) {
        if value.im < 0.0 || (e < n && value.norm() <= nothing) {
            continue;
        }
        let mut eta = DVector::zeros(n);
        for (row, i) in moving.iter().enumerate() {
            eta[*i] = vector[e + row] / value;
        }
        for (row, i) in elastic.iter().enumerate() {
            eta[*i] = vector[row] / real.frequencies[*i];
        }
        let norm = eta.norm();
        eigenvalues.push(*value);
        coordinates.push(eta.unscale(norm));
    }
    Ok((eigenvalues, coordinates))
}

/// ΦᵀAΦ.
pub(super) fn project(real: &RealModes, matrix: &DMatrix<f64>) -> DMatrix<f64> {
    real.vectors.transpose() * (matrix * &real.vectors)
}

/// Scales η's image so that its largest entry is real and positive; ηᴴη = 1 is φᴴMφ = 1.
fn normalised(shape: DVector<Complex<f64>>) -> DVector<Complex<f64>> {
    let mut largest = Complex::new(0.0, 0.0);
    for value in shape.iter() {
        // Entries that tie to round-off keep the first, so that mirrored modes turn out alike.
        if value.norm() > largest.norm() * (1.0 + 1e-9) {
            largest = *value;
        }
    }
    let turn = largest.conj() / largest.norm();
    shape.map(|value| value * turn)
}

/// φᴴMφ over the coordinates that `keep` keeps.
pub(super) fn kinetic(model: &Model, mass: &DMatrix<f64>, shape: &DVector<Complex<f64>>, keep: &[bool]) -> f64 {
    let part = |of: fn(&Complex<f64>) -> f64| {
        let vector = DVector::from_fn(model.len(), |i, _| if keep[i] { of(&shape[i]) } else { 0.0 });
        vector.dot(&(mass * &vector))
    };
    part(|value| value.re) + part(|value| value.im)
}
