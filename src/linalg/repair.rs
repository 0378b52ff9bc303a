//! Eigenvectors of equal eigenvalues, found again where a decomposition has lost them.
//!
//! Back substitution in a real Schur form cannot tell two equal pairs of complex eigenvalues apart, and pairs that nearly
//! are not well: of such a cluster one vector comes out right and the others are off by up to some per cent. Inverse
//! iteration finds them, one after the other, each kept apart from the right ones of its equals.

use faer::linalg::solvers::Solve;
use nalgebra::{Complex, DMatrix, DVector};

use super::dense::{copy, view};

/// A vector whose residual is above this part of the matrix, times the root of its rows, is looked for again.
const WRONG: f64 = 1e-14;
/// Eigenvalues closer than this part of the matrix may have lost their vectors.
const NEAR: f64 = 1e-5;
/// Eigenvalues closer than this part of the matrix are equal: what is left between them is no more than round-off.
const EQUAL: f64 = 1e-12;
/// Inverse iteration starts off the eigenvalue by this part of the matrix, so that there is something to divide by.
const OFF: f64 = 1e-15;
/// Two steps reach round-off; a third mends a bad start.
const STEPS: usize = 3;

type Vector = DVector<Complex<f64>>;

/// Finds again the unit eigenvectors of `matrix` that are not right, and leaves what it cannot better.
pub(super) fn repair(matrix: &DMatrix<f64>, values: &[Complex<f64>], vectors: &mut [Vector]) {
    let size = matrix.norm();
    let wrong = WRONG * size * (matrix.nrows() as f64).sqrt();
    let residual = |value: Complex<f64>, vector: &Vector| {
        let part = |of: fn(&Complex<f64>) -> f64| matrix * vector.map(|entry| of(&entry));
        let image = part(|entry| entry.re).zip_map(&part(|entry| entry.im), Complex::new);
        (image - vector * value).norm()
    };
    let within = |a: usize, b: usize, part: f64| (values[a] - values[b]).norm() <= part * size;
    let crowded = |index: usize| (0..values.len()).any(|other| other != index && within(index, other, NEAR));
    let mut right: Vec<bool> =
        (0..values.len()).map(|index| !crowded(index) || residual(values[index], &vectors[index]) <= wrong).collect();
    for (index, value) in values.iter().copied().enumerate() {
        if right[index] || value.im < 0.0 {
            continue;
        }
        let shift = value + Complex::new(OFF * size, OFF * size);
        let shifted = DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |i, j| {
            Complex::from(matrix[(i, j)]) - if i == j { shift } else { Complex::ZERO }
        });
        let factors = view(&shifted).partial_piv_lu();
        let equals: Vec<Vector> = (0..values.len())
            .filter(|other| right[*other] && within(index, *other, EQUAL))
            .map(|other| vectors[other].clone())
            .collect();
        // What was found of it, and a part of every direction, the same in every run.
        let found = &vectors[index];
        let spread = |i: usize| Complex::from_polar(0.1 / (matrix.nrows() as f64).sqrt(), (i * i) as f64);
        let mut vector = DVector::from_fn(matrix.nrows(), |i, _| found[i] + spread(i));
        for _ in 0..STEPS {
            let solved = factors.solve(view(&DMatrix::from_column_slice(vector.len(), 1, vector.as_slice())));
            vector = copy(solved.as_ref()).column(0).into_owned();
            // Twice, as once leaves the round-off of what it takes off.
            for equal in equals.iter().chain(&equals) {
                let along = equal.dotc(&vector);
                vector -= equal * along;
            }
            let length = vector.norm();
            vector.unscale_mut(length);
        }
        if residual(value, &vector) < residual(value, &vectors[index]) {
            right[index] = residual(value, &vector) <= wrong;
            if let Some(other) = values.iter().position(|other| value.im > 0.0 && *other == value.conj()) {
                vectors[other] = vector.conjugate();
            }
            vectors[index] = vector;
        }
    }
}
