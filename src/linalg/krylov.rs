//! Krylov space of a real or Hermitian operator, for its eigenvalues of largest magnitude: the band Arnoldi method (Saad 2011, Numerical
//! Methods for Large Eigenvalue Problems, sections 6.3 and 6.4).
//!
//! The basis V is orthonormal in an inner product that the caller chooses. Applying the operator T to the first m basis
//! vectors, one after the other, gives T V_m = V H, so that eigenvalues of the first m rows of H approximate those of T; the
//! other rows give the residuals. Start vectors may be added at any time: a space with p start vectors finds eigenvalues of
//! multiplicity p.

use nalgebra::{Complex, ComplexField as _, DMatrix, DVector};

use super::columns::{add_combination, combination, products};
use super::dense::{DecompositionError, Eigen, eigen};
use super::sparse_lu::Number;
use crate::numerics::ROUND_OFF;

/// An operator with the inner product in which it is close to normal.
pub trait Operator {
    /// Entries of the vectors.
    type Scalar: Number;
    /// Whether T is symmetric, or Hermitian, in the inner product; an operator on complex vectors is Hermitian.
    const SYMMETRIC: bool;
    /// Whether [`Self::apply_both`] costs little more than [`Self::apply`].
    const IN_PAIRS: bool = false;

    /// Number of entries of a vector.
    fn size(&self) -> usize;

    /// T x.
    ///
    /// # Errors
    /// [`DecompositionError`] if a linear system has no accurate solution.
    fn apply(&self, x: &[Self::Scalar]) -> Result<Vec<Self::Scalar>, DecompositionError>;

    /// T x and T y.
    ///
    /// # Errors
    /// As [`Self::apply`].
    fn apply_both(&self, x: &[Self::Scalar], y: &[Self::Scalar]) -> Result<[Vec<Self::Scalar>; 2], DecompositionError> {
        Ok([self.apply(x)?, self.apply(y)?])
    }

    /// W x, where xᴴWy is the inner product of x and y.
    fn weigh(&self, x: &[Self::Scalar]) -> Vec<Self::Scalar>;
}

/// Approximation of an eigenpair.
#[derive(Clone, Debug)]
pub struct RitzPair {
    /// Eigenvalue θ of the operator.
    pub value: Complex<f64>,
    /// Norm of the residual ‖T x − θ x‖ for ‖x‖ = 1, relative to |θ|.
    pub residual: f64,
    /// Components of x in the basis.
    components: DVector<Complex<f64>>,
}

/// A Krylov space.
#[derive(Debug)]
pub struct Krylov<'a, T: Operator> {
    operator: &'a T,
    /// Basis vectors, one after the other.
    basis: Vec<T::Scalar>,
    /// Number of the first basis vectors, which span a space that the operator maps into itself.
    locked: usize,
    /// Components of T v in the basis, for every basis vector v to which the operator was applied.
    images: Vec<Vec<T::Scalar>>,
    /// T v of the basis vector v after these, if it was computed with that of the last one.
    ahead: Option<Vec<T::Scalar>>,
    /// State of the random numbers.
    seed: u64,
    /// Whether the operator leads to no vector outside of the space, except for round-off.
    is_exhausted: bool,
}

impl<'a, T: Operator> Krylov<'a, T> {
    /// A space of the vectors of `locked`, which span a space that the operator maps into itself. Its eigenpairs are left
    /// out.
    pub fn new(operator: &'a T, locked: impl IntoIterator<Item = Vec<T::Scalar>>) -> Self {
        let mut space = Self {
            operator,
            basis: Vec::new(),
            locked: 0,
            images: Vec::new(),
            ahead: None,
            seed: 1,
            is_exhausted: false,
        };
        for vector in locked {
            space.push(vector);
        }
        space.locked = space.count();
        space
    }

    /// The operator.
    pub fn operator(&self) -> &'a T {
        self.operator
    }

    /// Number of basis vectors.
    fn count(&self) -> usize {
        self.basis.len() / self.operator.size().max(1)
    }

    /// Number of vectors to which the operator was applied.
    pub fn steps(&self) -> usize {
        self.images.len()
    }

    /// Whether the basis spans all vectors to which the operator leads.
    pub fn is_complete(&self) -> bool {
        self.is_exhausted || self.count() >= self.operator.size()
    }

    /// Adds `vector` to the basis, orthogonalized and normalized. Returns its components, of which the last is that of the
    /// added vector.
    fn push(&mut self, mut vector: Vec<T::Scalar>) -> Vec<T::Scalar> {
        let (size, count) = (self.operator.size(), self.count());
        let norm = |vector: &[T::Scalar], weighted: &[T::Scalar]| {
            vector.iter().zip(weighted).map(|(x, w)| (x.conjugate() * *w).real()).sum::<f64>().max(0.0).sqrt()
        };
        let mut components = vec![T::Scalar::from_real(0.0); count];
        // Norms before each orthogonalization, which is done twice: the first time leaves round-off of the removed components.
        let mut norms = [0.0; 2];
        let mut removed = 0.0;
        for size_before in &mut norms {
            let weighted = self.operator.weigh(&vector);
            *size_before = norm(&vector, &weighted);
            let part = products(&self.basis, &weighted);
            removed = part.iter().map(|value| value.modulus_squared()).sum::<f64>();
            let opposite: Vec<T::Scalar> = part.iter().map(|value| -*value).collect();
            add_combination(&self.basis, size, &opposite, &mut vector);
            components.iter_mut().zip(part).for_each(|(sum, part)| *sum += part);
        }
        let [before, rest] = norms;
        let after = (rest * rest - removed).max(0.0).sqrt();
        if after > ROUND_OFF * before && after.is_finite() {
            self.basis.extend(vector.iter().map(|value| value.unscale(after)));
            components.push(T::Scalar::from_real(after));
        }
        components
    }

    /// Adds a start vector with random entries.
    ///
    /// # Errors
    /// [`DecompositionError`] of the operator.
    pub fn add_start(&mut self) -> Result<(), DecompositionError> {
        let mut next = || {
            // SplitMix64 (Steele, Lea and Flood, OOPSLA 2014).
            self.seed = self.seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let mut z = self.seed;
            z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            (z ^ (z >> 31)) as f64 / u64::MAX as f64 - 0.5
        };
        let start: Vec<T::Scalar> = (0..self.operator.size()).map(|_| T::Scalar::from_real(next())).collect();
        // The operator removes the components of the small eigenvalues.
        let start = self.operator.apply(&start)?;
        self.add_vector(start);
        Ok(())
    }

    /// Adds the start vector `x`.
    pub fn add_vector(&mut self, x: Vec<T::Scalar>) {
        self.push(x);
    }

    /// Basis vectors apart from those of the locked space, one after the other.
    pub fn basis(&self) -> &[T::Scalar] {
        &self.basis[self.locked * self.operator.size()..]
    }

    /// Applies the operator to the next basis vector; adds a start vector if there is none.
    ///
    /// # Errors
    /// [`DecompositionError`] of the operator.
    pub fn step(&mut self) -> Result<(), DecompositionError> {
        let size = self.operator.size();
        let next = self.locked + self.images.len();
        if next == self.count() {
            self.add_start()?;
        }
        if next == self.count() {
            self.is_exhausted = true;
            return Ok(());
        }
        let (vector, following) = self.basis[next * size..].split_at(size);
        let image = match self.ahead.take() {
            Some(image) => image,
            None if T::IN_PAIRS && following.len() >= size => {
                let [image, ahead] = self.operator.apply_both(vector, &following[..size])?;
                self.ahead = Some(ahead);
                image
            }
            None => self.operator.apply(vector)?,
        };
        let components = self.push(image);
        self.images.push(components);
        Ok(())
    }

    /// The operator projected on the basis vectors to which it was applied, m × m; Hermitian for a symmetric operator, but for
    /// round-off.
    pub fn projected(&self) -> DMatrix<T::Scalar> {
        let m = self.images.len();
        let projected = DMatrix::from_fn(m, m, |row, column| self.entry(row, column));
        if T::SYMMETRIC { (&projected + projected.adjoint()).map(|value| value.unscale(2.0)) } else { projected }
    }

    /// Component of T v in a basis vector, for the vector v of a column.
    fn entry(&self, row: usize, column: usize) -> T::Scalar {
        self.images[column].get(self.locked + row).copied().unwrap_or(T::Scalar::from_real(0.0))
    }

    /// All approximations of eigenpairs.
    ///
    /// # Errors
    /// [`DecompositionError`] if the eigenvalue iteration does not converge.
    pub fn ritz_pairs(&self) -> Result<Vec<RitzPair>, DecompositionError> {
        let m = self.images.len();
        let rest = self.count() - self.locked - m;
        let projected = self.projected();
        let eigen = if T::SYMMETRIC {
            // Vectors of equal eigenvalues are then orthogonal.
            let found = projected.symmetric_eigen();
            Eigen { values: found.eigenvalues.map(Complex::from), vectors: found.eigenvectors.map(complex) }
        } else {
            eigen(&projected.map(|value| value.real()))?
        };
        let tail = DMatrix::from_fn(rest, m, |row, column| complex(self.entry(m + row, column)));
        let pair = |(value, vector): (&Complex<f64>, DVector<Complex<f64>>)| RitzPair {
            value: *value,
            residual: (&tail * &vector).norm() / value.norm(),
            components: vector,
        };
        let columns = eigen.vectors.column_iter().map(|column| column.into_owned());
        Ok(eigen.values.iter().zip(columns).map(pair).collect())
    }

    /// The vector of an approximation.
    pub fn vector(&self, pair: &RitzPair) -> DVector<Complex<f64>> {
        self.first_entries(pair, self.operator.size())
    }

    /// The first `count` entries of the vector of an approximation.
    pub fn first_entries(&self, pair: &RitzPair, count: usize) -> DVector<Complex<f64>> {
        let sum = |part: fn(&Complex<f64>) -> f64| {
            let weights: Vec<T::Scalar> =
                pair.components.iter().map(|value| T::Scalar::from_real(part(value))).collect();
            self.combination(&weights, count)
        };
        let parts = sum(|value| value.re).into_iter().zip(sum(|value| value.im));
        let entries = parts.map(|(real, imaginary)| complex(real) + Complex::<f64>::i() * complex(imaginary));
        DVector::from_iterator(count, entries)
    }

    /// The first `count` entries of a combination of the first basis vectors.
    pub fn combination(&self, weights: &[T::Scalar], count: usize) -> Vec<T::Scalar> {
        combination(self.basis(), self.operator.size(), weights, count)
    }
}

fn complex<T: Number>(value: T) -> Complex<f64> {
    Complex::new(value.real(), value.imaginary())
}
