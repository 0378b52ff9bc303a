//! A space of displacements V in which modes at all speeds are found.
//!
//! The equations VᵀS(λ)V y = 0 have as many unknowns as the space has dimensions. Modes change little with the speed: where the
//! residual of a mode φ = Vy in all coordinates is too large, one step of Newton's method in these coordinates extends the
//! space, and serves the other modes and speeds too.

use std::cell::RefCell;

use nalgebra::{DMatrix, DVector};
use num_complex::Complex64;

use super::newton::{Equations, Forces, FullEquations, ModeAtSpeed, Unknown, newton};
use crate::linalg::{LuFactors, Singular, image_of_parts};
use crate::modal::undamped::ModalDamping;
use crate::model::{Model, StructuralDamping};

/// Residual of an accurate mode at a speed. Where forces circulate, the error of λ is proportional to it, otherwise to its square.
const ACCURATE: f64 = 1e-10;
/// Residual of an accurate intersection with a line.
const ACCURATE_ON_LINE: f64 = 1e-12;
/// Number of times that the space is extended for one mode.
const MAX_EXTENSIONS: usize = 8;
/// Largest relative change of λ for which the factors of VᵀS(λ)V serve the next iteration too.
const SAME_FACTORS: f64 = 1e-3;
/// Number of iterations in sequence that the same factors serve.
const MAX_USES: usize = 3;
/// Part of a displacement outside of the space below which it is round-off.
const DEPENDENCE_TOLERANCE: f64 = 1e-10;

/// Matrices of one speed in the space, k × k, or their products with its vectors, n × k.
#[derive(Debug)]
struct Matrices {
    stiffness: DMatrix<f64>,
    damping: DMatrix<f64>,
    gyroscopic: DMatrix<f64>,
}

/// A space of displacements, with the matrices of a model at one speed.
#[derive(Debug)]
pub struct ModeSpace {
    /// V, n × k, orthonormal in M.
    shapes: DMatrix<f64>,
    /// MV, n × k.
    momenta: DMatrix<f64>,
    /// KV, CV and GV.
    images: Matrices,
    /// VᵀKV, VᵀCV and VᵀGV.
    projected: Matrices,
}

impl ModeSpace {
    /// An empty space for the displacements of a model.
    pub fn new(model: &Model) -> Self {
        let zeros = || DMatrix::zeros(model.len(), 0);
        let matrices = || Matrices { stiffness: zeros(), damping: zeros(), gyroscopic: zeros() };
        Self { shapes: zeros(), momenta: zeros(), images: matrices(), projected: matrices() }
    }

    /// Number of dimensions.
    pub fn dimension(&self) -> usize {
        self.shapes.ncols()
    }

    /// Changes the matrices from those of a model at a speed to those of another one with the same coordinates; `speeds` of the
    /// reference shaft, rad/s.
    pub fn change(&mut self, from: &FullEquations<'_>, to: &FullEquations<'_>, speeds: [f64; 2]) {
        let [stiffness, _, damping, ..] = to.model.matrix_changes(Some((from.model, speeds[0])), speeds[1]);
        add_entries(&stiffness, &self.shapes, &mut self.images.stiffness, &mut self.projected.stiffness);
        add_entries(&damping, &self.shapes, &mut self.images.damping, &mut self.projected.damping);
        if let (Some(before), Some(after)) = (from.modal, to.modal)
            && !std::ptr::eq(before, after)
        {
            self.images.damping += modal_force(after, &self.shapes) - modal_force(before, &self.shapes);
            self.projected.damping = self.shapes.transpose() * &self.images.damping;
        }
    }

    /// Adds a mode shape, n entries, to the space; the model is that of the matrices. Returns whether the shape was outside of the space.
    pub fn extend(
        &mut self,
        model: &Model,
        modal: Option<&ModalDamping>,
        speed: f64,
        shape: &DVector<Complex64>,
    ) -> bool {
        let before = self.dimension();
        for mut part in parts(shape) {
            let size = model.kinetic_form(part.as_slice()).sqrt();
            // Orthogonalization is done twice, because the first time leaves round-off of the removed components.
            for _ in 0..2 {
                part.gemv(-1.0, &self.shapes, &self.momenta.tr_mul(&part), 1.0);
            }
            let rest = model.kinetic_form(part.as_slice()).sqrt();
            if rest > DEPENDENCE_TOLERANCE * size {
                part.unscale_mut(rest);
                let of = |multiply: &dyn Fn(&[f64], &mut [f64])| {
                    let mut image = DVector::zeros(part.len());
                    multiply(part.as_slice(), image.as_mut_slice());
                    image
                };
                let momentum = of(&|x, out| model.multiply_mass(x, out));
                let stiffness = of(&|x, out| model.multiply_stiffness(speed, false, x, out));
                let damping = of(&|x, out| {
                    model.multiply_damping(speed, x, out);
                    if let Some(modal) = modal {
                        modal.multiply_add(1.0, x, out);
                    }
                });
                let gyroscopic = of(&|x, out| model.multiply_gyroscopic(x, out));
                append(&mut self.shapes, &part);
                append(&mut self.momenta, &momentum);
                let (images, projected) = (&mut self.images, &mut self.projected);
                for (image, images, projected) in [
                    (stiffness, &mut images.stiffness, &mut projected.stiffness),
                    (damping, &mut images.damping, &mut projected.damping),
                    (gyroscopic, &mut images.gyroscopic, &mut projected.gyroscopic),
                ] {
                    append(images, &image);
                    let size = images.ncols();
                    projected.resize_mut(size, size, 0.0);
                    projected.set_row(size - 1, &images.tr_mul(&part).transpose());
                    projected.set_column(size - 1, &self.shapes.tr_mul(&image));
                }
            }
        }
        self.dimension() > before
    }

    /// The mode near `start` of the model whose matrices the space has, with its residual; the space is extended where that
    /// residual asks for it. `None` if the iteration does not converge. `residual` gives the residual of a mode in all coordinates,
    /// and `size` its value.
    ///
    /// # Errors
    /// The error of `residual`.
    pub fn mode_near<R, E>(
        &mut self,
        model: &Model,
        modal: Option<&ModalDamping>,
        unknown: Unknown,
        start: ModeAtSpeed,
        mut residual: impl FnMut(&ModeAtSpeed) -> Result<R, E>,
        size: impl Fn(&R) -> f64,
    ) -> Result<Option<(ModeAtSpeed, R)>, E> {
        let mut best: Option<(ModeAtSpeed, R)> = None;
        let is_exact = matches!(unknown, Unknown::Speed(_));
        let accurate = if is_exact { ACCURATE_ON_LINE } else { ACCURATE };
        let mut at = start;
        for extension in 0..=MAX_EXTENSIONS {
            let coordinates = image_of_parts(&at.shape, |part| self.momenta.tr_mul(part));
            let reduced = ReducedEquations { space: self, model, is_exact, factors: RefCell::new(None) };
            let start = ModeAtSpeed { shape: coordinates, ..at };
            if let Some(found) = newton(&reduced, unknown, start) {
                at = ModeAtSpeed { shape: times(&self.shapes, &found.shape), ..found };
                let found = (at.clone(), residual(&at)?);
                let value = size(&found.1);
                let is_better = best.as_ref().is_none_or(|(_, known)| value < size(known));
                if is_better {
                    best = Some(found);
                }
                if value <= accurate || !is_better {
                    break;
                }
            }
            let equations = FullEquations { model, modal };
            let change = if extension < MAX_EXTENSIONS { equations.step(unknown, &at).ok() } else { None };
            let Some(change) = change.filter(|change| self.extend(model, modal, at.speed, &change.shape)) else {
                break;
            };
            at.shape += change.shape;
        }
        Ok(best)
    }
}

/// Adds entries (row, column, value) of a matrix A to its image AV and to VᵀAV.
fn add_entries(
    entries: &[(usize, usize, f64)],
    shapes: &DMatrix<f64>,
    image: &mut DMatrix<f64>,
    projected: &mut DMatrix<f64>,
) {
    for (index, mut image) in image.column_iter_mut().enumerate() {
        entries.iter().for_each(|(row, column, value)| image[*row] += value * shapes[(*column, index)]);
    }
    if entries.len() > shapes.nrows() {
        *projected = shapes.transpose() * &*image;
        return;
    }
    for (row, column, value) in entries {
        projected.ger(*value, &shapes.row(*row).transpose(), &shapes.row(*column).transpose(), 1.0);
    }
}

/// Modal damping times the columns of X.
fn modal_force(modal: &ModalDamping, columns: &DMatrix<f64>) -> DMatrix<f64> {
    modal.momenta.as_ref() * (&modal.rates * (modal.momenta.transpose() * columns))
}

/// Appends a column.
fn append(matrix: &mut DMatrix<f64>, column: &DVector<f64>) {
    let count = matrix.ncols();
    matrix.resize_horizontally_mut(count + 1, 0.0);
    matrix.set_column(count, column);
}

/// Real and imaginary part.
fn parts(x: &DVector<Complex64>) -> [DVector<f64>; 2] {
    [x.map(|value| value.re), x.map(|value| value.im)]
}

/// A x for a real matrix A.
fn times(matrix: &DMatrix<f64>, x: &DVector<Complex64>) -> DVector<Complex64> {
    image_of_parts(x, |part| matrix * part)
}

/// The equations of motion projected on the space, VᵀS(λ)V y = 0.
struct ReducedEquations<'s> {
    space: &'s ModeSpace,
    model: &'s Model,
    /// Whether each iteration has factors of its own.
    is_exact: bool,
    factors: RefCell<Option<ReducedFactors>>,
}

/// Factors of VᵀS(λ)V.
struct ReducedFactors {
    /// λ, rad/s.
    eigenvalue: Complex64,
    factors: LuFactors<Complex64>,
    /// Number of iterations that they have served.
    uses: usize,
}

impl ReducedEquations<'_> {
    /// VᵀHV with the structural damping H of a mode.
    fn structural(&self, at: &ModeAtSpeed) -> Option<DMatrix<Complex64>> {
        if at.eigenvalue.im == 0.0 || !self.model.has_structural_damping() {
            return None;
        }
        let shapes = self.space.shapes.map(Complex64::from);
        let mut image = DMatrix::zeros(shapes.nrows(), shapes.ncols());
        let damping = StructuralDamping { frequency: at.eigenvalue.im, speed: at.speed };
        for (row, column, value) in self.model.structural_entries(damping, at.speed) {
            (0..shapes.ncols()).for_each(|index| image[(row, index)] += value * shapes[(column, index)]);
        }
        Some(shapes.tr_mul(&image))
    }
}

impl Equations for ReducedEquations<'_> {
    fn forces(&self, at: &ModeAtSpeed) -> Forces {
        let Matrices { stiffness, damping, gyroscopic } = &self.space.projected;
        let gyroscopic = times(gyroscopic, &at.shape);
        let rate = times(damping, &at.shape) + &gyroscopic * Complex64::from(at.speed);
        let mut residual =
            times(stiffness, &at.shape) + &rate * at.eigenvalue + &at.shape * (at.eigenvalue * at.eigenvalue);
        if let Some(structural) = self.structural(at) {
            residual += structural * &at.shape;
        }
        Forces { inertia: at.shape.clone(), rate, gyroscopic, residual }
    }

    fn solve(&self, at: &ModeAtSpeed, right: DMatrix<Complex64>) -> Result<DMatrix<Complex64>, Singular> {
        let Matrices { stiffness, damping, gyroscopic } = &self.space.projected;
        let lambda = at.eigenvalue;
        let mut known = self.factors.borrow_mut();
        let is_close = |known: &ReducedFactors| {
            known.uses < MAX_USES && (lambda - known.eigenvalue).norm() <= SAME_FACTORS * lambda.norm()
        };
        if let Some(known) = known.as_mut().filter(|known| !self.is_exact && is_close(known)) {
            known.uses += 1;
            return Ok(known.factors.solve(&right));
        }
        let mut matrix = DMatrix::from_fn(self.space.dimension(), self.space.dimension(), |row, column| {
            let place = (row, column);
            stiffness[place] + lambda * (damping[place] + at.speed * gyroscopic[place])
        });
        (0..self.space.dimension()).for_each(|index| matrix[(index, index)] += lambda * lambda);
        if let Some(structural) = self.structural(at) {
            matrix += structural;
        }
        let factors = LuFactors::new(&matrix);
        Ok(known.insert(ReducedFactors { eigenvalue: lambda, factors, uses: 1 }).factors.solve(&right))
    }

    fn kinetic_form(&self, shape: &DVector<Complex64>) -> f64 {
        shape.norm_squared()
    }

    fn is_exact(&self) -> bool {
        self.is_exact
    }
}
