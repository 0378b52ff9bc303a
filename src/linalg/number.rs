//! Numbers of vectors and matrices, and the error of a matrix without factors.

use nalgebra::ComplexField;
use thiserror::Error;

/// Error: a matrix has no LU factors.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("the matrix is singular")]
pub struct Singular;

/// Real or complex numbers in double precision.
pub trait Number: ComplexField<RealField = f64> + Copy {}

impl<T: ComplexField<RealField = f64> + Copy> Number for T {}
