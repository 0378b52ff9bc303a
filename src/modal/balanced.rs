//! Directions of the displacements that matter most between loads and signals, by their Gramians.
//!
//! A load step at the time zero moves the system; the Gramian of the displacements η is the integral of η ηᵀ over this
//! motion. The displacements of the dual system, on which the signals act as loads, have a Gramian too. The Galerkin
//! error of a signal under a load is the product of what the subspace omits of the motion and of the dual motion, so
//! that the dominant directions of the sum of both Gramians make it small (second-order balanced truncation with equal
//! subspaces; Antoulas 2005, chapters 7 and 8).
//!
//! In modal coordinates the integrals are explicit. With the eigenvalues μ_i and the components β_i of the loads,
//! ∫ e^{−2σt} ζ_i ζ_jᴴ dt = β_i β_jᴴ/(2σ − μ_i − μ_jᴴ). The shift σ limits the integral of undamped modes.
//!
//! The displacements of growing modes and of their duals come before all others, so that every subspace contains them:
//! however small they are within the horizon, they outgrow the rest. With them, the Galerkin projection keeps the eigenvalues
//! of these modes.

use nalgebra::{DMatrix, DVector};
use num_complex::Complex64;

use super::pairs::ModePair;
use super::projected::Projected;
use super::state_space::{ModalStateSpace, StateMatrix};
use crate::linalg::{DecompositionError, symmetric_pencil};
use crate::model::Model;

/// A static displacement whose part independent of the others is below this fraction is left out.
const DEPENDENT: f64 = 1e-6;

/// Directions of the elastic displacements in the order of their importance.
#[derive(Clone, Debug)]
pub struct Directions {
    /// Orthonormal directions in the coordinates η of the elastic modes, one per column.
    pub vectors: DMatrix<f64>,
    /// Share of each direction in the Gramians.
    pub shares: Vec<f64>,
    /// Number of the first directions, which belong to growing modes: every subspace contains them.
    pub growing: usize,
}

/// What a reduced model carries from its loads to its signals.
#[derive(Clone, Debug, Default)]
pub struct Ports {
    /// Columns b of loads that step, in groups of equal importance.
    pub columns: Vec<Vec<Vec<f64>>>,
    /// States in which a run can begin.
    pub states: Vec<Vec<f64>>,
    /// Rows w of signals, in groups of the same unit and of equal importance.
    pub rows: Vec<Vec<Vec<f64>>>,
}

/// A complex coordinate ζ = x + iy of an oscillation, or a real one: its eigenvalue and its entries of z.
struct Coordinate {
    eigenvalue: Complex64,
    x: usize,
    y: Option<usize>,
}

impl Directions {
    /// Ranks the directions of a model; `linear` is its state-space model, in pairs. The responses have the `horizon`, s. The
    /// displacements `growing`, n × k, of growing modes come first.
    ///
    /// # Errors
    /// [`DecompositionError`] if the decomposition of the Gramian fails.
    pub fn new(
        model: &Model,
        projected: &Projected,
        linear: &ModalStateSpace,
        ports: &Ports,
        horizon: f64,
        growing: &DMatrix<f64>,
    ) -> Result<Self, DecompositionError> {
        let pairs = if let StateMatrix::Pairs(pairs) = &linear.matrix { &pairs[..] } else { &[] };
        let (size, shift) = (linear.len(), 1.0 / horizon);
        let (coordinates, dual) = (coordinates(pairs, shift, false), coordinates(pairs, shift, true));
        let null = projected.modes.null;
        let elastic = projected.modes.frequencies.len() - null;
        let weighted = model.mass_times(&projected.modes.vectors.columns(null, elastic).into_owned());
        // Products with an explicit transpose run several times as fast.
        let position = weighted.transpose() * &linear.displacement;
        let test = (&linear.from_velocity * &weighted).transpose();

        let mut total = DMatrix::zeros(elastic, elastic);
        // Adds the Gramian of the displacements with trace 1, and returns the Gramian with the same factor.
        let mut add = |map: &DMatrix<f64>, gramian: DMatrix<f64>| {
            let form = map * &gramian * map.transpose();
            let trace = form.trace();
            if trace > 0.0 {
                total += form / trace;
                gramian / trace
            } else {
                gramian
            }
        };
        let mut motion = DMatrix::zeros(size, size);
        for columns in &ports.columns {
            let steps = responses(&coordinates, columns, Some(shift));
            motion += add(&position, gramian(&coordinates, &steps, shift, size));
        }
        add(&position, gramian(&coordinates, &responses(&coordinates, &ports.states, None), shift, size));
        let rows = scaled(&ports.rows, &motion);
        add(&test, gramian(&dual, &responses(&dual, &rows, Some(shift)), shift, size));
        let statics = statics(&coordinates, &ports.columns.concat(), size);
        Self::ranked(&total, &weighted.tr_mul(growing), &(&position * statics))
    }

    /// Number of directions after which the remaining ones have this share in the size of the motion.
    pub fn count(&self, share: f64) -> usize {
        self.first_below(share * self.tail(0).sqrt()).max(self.growing)
    }

    /// Number of directions after which the size of the remaining motion is smaller by the factor `excess` than after
    /// `count` directions.
    pub fn further(&self, count: usize, excess: f64) -> usize {
        self.first_below(self.tail(count).sqrt() / excess)
    }

    fn first_below(&self, size: f64) -> usize {
        (0..self.shares.len()).find(|count| self.tail(*count).sqrt() <= size).unwrap_or(self.shares.len())
    }

    /// Sum of the shares after `count` directions, without the static ones.
    fn tail(&self, count: usize) -> f64 {
        self.shares.iter().skip(count).filter(|share| share.is_finite()).sum()
    }

    /// Ranks the directions of a model for the forces and signals with the entries `ports`, as if each undamped mode had
    /// only its own damping. No eigenvalue problem of the damped system is necessary. The displacements `growing`, n × k, of
    /// growing modes come first.
    ///
    /// # Errors
    /// [`DecompositionError`] if the decomposition of the Gramian fails.
    pub fn of_undamped(
        model: &Model,
        projected: &Projected,
        ports: &[Vec<(usize, f64)>],
        horizon: f64,
        growing: &DMatrix<f64>,
    ) -> Result<Self, DecompositionError> {
        let (modes, null, shift) = (&projected.modes, projected.modes.null, 1.0 / horizon);
        let size = modes.frequencies.len() - null;
        // The entries of z are ωη and η̇ of every mode.
        let pair = |index: usize| {
            let frequency = modes.frequencies[null + index];
            ModePair::Oscillation(Complex64::new(-projected.damping_of(null + index).max(0.0) / 2.0, frequency))
        };
        let pairs: Vec<ModePair> = (0..size).map(pair).collect();
        let coordinates = coordinates(&pairs, shift, false);
        let load = |port: &Vec<(usize, f64)>| -> Vec<f64> {
            let force = |mode: usize| port.iter().map(|(row, value)| modes.vectors[(*row, null + mode)] * value).sum();
            std::iter::repeat_n(0.0, size).chain((0..size).map(force)).collect()
        };
        let columns: Vec<Vec<f64>> = ports.iter().map(load).collect();
        let displacement = |matrix: &DMatrix<f64>| {
            DMatrix::from_fn(size, matrix.ncols(), |row, column| matrix[(row, column)] / modes.frequencies[null + row])
        };
        // Every load has the same importance: the trace of the Gramian of its displacements is one.
        let mut steps = responses(&coordinates, &columns, Some(shift));
        for load in 0..columns.len() {
            let trace = |(mode, (coordinate, given)): (usize, (&Coordinate, &Vec<Complex64>))| {
                let size = position_product(coordinate, coordinate, &given[load..=load], &given[load..=load], shift);
                size / modes.frequencies[null + mode].powi(2)
            };
            let total: f64 = coordinates.iter().zip(&steps).enumerate().map(trace).sum();
            let scale = 1.0 / total.max(f64::MIN_POSITIVE).sqrt();
            steps.iter_mut().for_each(|given| given[load] *= scale);
        }
        let mut total = DMatrix::zeros(size, size);
        for (i, (first, left)) in coordinates.iter().zip(&steps).enumerate() {
            for (j, (second, right)) in coordinates.iter().zip(&steps).enumerate().take(i + 1) {
                let frequencies = modes.frequencies[null + i] * modes.frequencies[null + j];
                let value = position_product(first, second, left, right, shift) / frequencies;
                (total[(i, j)], total[(j, i)]) = (value, value);
            }
        }
        let statics = statics(&coordinates, &columns, 2 * size).rows(0, size).into_owned();
        let growing = modes.vectors.columns(null, size).tr_mul(&model.mass_times(growing));
        Self::ranked(&total, &growing, &displacement(&statics))
    }

    /// The directions of `growing` and `statics`, then the eigenvectors of the rest of a Gramian.
    fn ranked(
        gramian: &DMatrix<f64>,
        growing: &DMatrix<f64>,
        statics: &DMatrix<f64>,
    ) -> Result<Self, DecompositionError> {
        let size = gramian.nrows();
        let mut vectors: Vec<DVector<f64>> = Vec::new();
        let mut kept = 0;
        for (index, column) in growing.column_iter().chain(statics.column_iter()).enumerate() {
            let mut rest = column.into_owned();
            for _ in 0..2 {
                for known in &vectors {
                    rest.axpy(-known.dot(&rest), known, 1.0);
                }
            }
            if rest.norm() > DEPENDENT * column.norm() {
                vectors.push(rest.normalize());
            }
            if index < growing.ncols() {
                kept = vectors.len();
            }
        }
        let count = vectors.len();
        let known = if count > 0 { DMatrix::from_columns(&vectors) } else { DMatrix::zeros(size, 0) };
        let transposed = known.transpose();
        let remove = |matrix: &DMatrix<f64>| matrix - &known * (&transposed * matrix);
        let rest = remove(&remove(gramian).transpose());
        let rest = (&rest + rest.transpose()) / 2.0;
        let pencil = symmetric_pencil(&rest, &DMatrix::identity(size, size), &known)?;
        let order: Vec<usize> = (0..count).chain((count..size).rev()).collect();
        let mut shares: Vec<f64> = order.iter().map(|index| pencil.values[*index].max(0.0)).collect();
        shares[..count].fill(f64::INFINITY);
        Ok(Self { vectors: pencil.vectors.select_columns(&order), shares, growing: kept })
    }
}

/// Coordinates of all pairs except for the rigid-body motions, constant entries and motions that grow at the rate `shift`,
/// 1/s, or faster, whose Gramian does not exist; those of the transposed matrix for the `dual` system.
fn coordinates(pairs: &[ModePair], shift: f64, dual: bool) -> Vec<Coordinate> {
    let mut coordinates = Vec::new();
    let slots = pairs.len();
    for (slot, pair) in pairs.iter().enumerate() {
        match pair {
            ModePair::Oscillation(value) => {
                let eigenvalue = if dual { *value } else { value.conj() };
                coordinates.push(Coordinate { eigenvalue, x: slot, y: Some(slots + slot) });
            }
            ModePair::Real(values) => {
                for (value, x) in values.iter().zip([slot, slots + slot]).filter(|(value, _)| **value != 0.0) {
                    coordinates.push(Coordinate { eigenvalue: Complex64::new(*value, 0.0), x, y: None });
                }
            }
            ModePair::RigidBodyPair(_) => {}
        }
    }
    coordinates.retain(|coordinate| coordinate.eigenvalue.re < shift);
    coordinates
}

/// Components β of `columns`, one list for each coordinate; with a `shift`, those of the response to their steps.
fn responses(coordinates: &[Coordinate], columns: &[Vec<f64>], shift: Option<f64>) -> Vec<Vec<Complex64>> {
    let response = |coordinate: &Coordinate| {
        let factor = shift.map_or(Complex64::new(1.0, 0.0), |shift| 1.0 / (coordinate.eigenvalue - shift));
        let component =
            |column: &Vec<f64>| Complex64::new(column[coordinate.x], coordinate.y.map_or(0.0, |y| column[y]));
        columns.iter().map(|column| component(column) * factor).collect()
    };
    coordinates.iter().map(response).collect()
}

/// ∫ e^{−2σt} x₁ x₂ dt of the first entries of two coordinates, summed over the responses that begin with the components
/// `left` and `right`.
fn position_product(
    first: &Coordinate,
    second: &Coordinate,
    left: &[Complex64],
    right: &[Complex64],
    shift: f64,
) -> f64 {
    let [product, square] = products(first, second, left, right, shift);
    (product.re + square.re) / 2.0
}

/// ∫ e^{−2σt} ζ₁ ζ̄₂ dt and ∫ e^{−2σt} ζ₁ ζ₂ dt, summed over the responses that begin with the components `left` and `right`.
fn products(
    first: &Coordinate,
    second: &Coordinate,
    left: &[Complex64],
    right: &[Complex64],
    shift: f64,
) -> [Complex64; 2] {
    let (mut product, mut square) = (Complex64::ZERO, Complex64::ZERO);
    for (a, b) in left.iter().zip(right) {
        product += a * b.conj();
        square += a * b;
    }
    product /= 2.0 * shift - first.eigenvalue - second.eigenvalue.conj();
    square /= 2.0 * shift - first.eigenvalue - second.eigenvalue;
    [product, square]
}

/// ∫ e^{−2σt} z zᵀ dt, `size` × `size`, summed over the responses that begin with the components `given`.
fn gramian(coordinates: &[Coordinate], given: &[Vec<Complex64>], shift: f64, size: usize) -> DMatrix<f64> {
    let mut gramian = DMatrix::zeros(size, size);
    for (first, left) in coordinates.iter().zip(given) {
        for (second, right) in coordinates.iter().zip(given) {
            let [product, square] = products(first, second, left, right, shift);
            gramian[(first.x, second.x)] = (product.re + square.re) / 2.0;
            if let Some(y) = second.y {
                gramian[(first.x, y)] = (square.im - product.im) / 2.0;
            }
            if let Some(y) = first.y {
                gramian[(y, second.x)] = (square.im + product.im) / 2.0;
                if let Some(other) = second.y {
                    gramian[(y, other)] = (product.re - square.re) / 2.0;
                }
            }
        }
    }
    gramian
}

/// Responses −A⁻¹b to constant loads, one column each.
fn statics(coordinates: &[Coordinate], columns: &[Vec<f64>], size: usize) -> DMatrix<f64> {
    let mut statics = DMatrix::zeros(size, columns.len());
    for (index, column) in columns.iter().enumerate() {
        for coordinate in coordinates {
            let load = Complex64::new(column[coordinate.x], coordinate.y.map_or(0.0, |y| column[y]));
            let response = -load / coordinate.eigenvalue;
            statics[(coordinate.x, index)] = response.re;
            if let Some(y) = coordinate.y {
                statics[(y, index)] = response.im;
            }
        }
    }
    statics
}

/// Rows divided by the size of their group in the motion with this Gramian.
fn scaled(groups: &[Vec<Vec<f64>>], gramian: &DMatrix<f64>) -> Vec<Vec<f64>> {
    let size = |row: &Vec<f64>| {
        let row = DVector::from_column_slice(row);
        row.dot(&(gramian * &row)).max(0.0)
    };
    let mut rows = Vec::new();
    for group in groups {
        let sizes: Vec<f64> = group.iter().map(size).collect();
        let norm = sizes.iter().sum::<f64>().sqrt();
        if norm > 0.0 {
            rows.extend(group.iter().map(|row| row.iter().map(|value| value / norm).collect::<Vec<f64>>()));
        }
    }
    rows
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};
    use num_complex::Complex64;

    use super::{coordinates, gramian, responses};
    use crate::modal::ModePair;

    /// The Gramian P of ż = A z with the load b solves (A − σ)P + P(A − σ)ᵀ + b bᵀ = 0, and that of its dual the same with
    /// Aᵀ.
    #[test]
    fn a_gramian_solves_the_lyapunov_equation() {
        let pairs = [
            ModePair::Oscillation(Complex64::new(-0.3, 7.0)),
            ModePair::Real([-2.0, -0.5]),
            ModePair::Oscillation(Complex64::new(0.0, 11.0)),
        ];
        let (size, shift) = (6, 0.25);
        let mut matrix = DMatrix::zeros(size, size);
        for (slot, pair) in pairs.iter().enumerate() {
            let block = pair.block();
            for (i, row) in block.iter().enumerate() {
                for (j, value) in row.iter().enumerate() {
                    matrix[(slot + 3 * i, slot + 3 * j)] = *value;
                }
            }
            matrix[(slot, slot)] -= shift;
            matrix[(slot + 3, slot + 3)] -= shift;
        }
        let column = vec![1.0, -0.4, 0.7, 0.2, 1.3, -0.6];
        let load = DVector::from_column_slice(&column);
        for (dual, matrix) in [(false, matrix.clone()), (true, matrix.transpose())] {
            let coordinates = coordinates(&pairs, shift, dual);
            let given = responses(&coordinates, std::slice::from_ref(&column), None);
            let found = gramian(&coordinates, &given, shift, size);
            let residual = &matrix * &found + &found * matrix.transpose() + &load * load.transpose();
            // Round-off of products of order ten.
            assert!(residual.amax() < 1e-13, "{residual}");
        }
    }
}
