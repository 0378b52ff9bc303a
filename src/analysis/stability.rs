//! Bounds of the eigenvalues of a model, which limit the step of explicit methods.

use nalgebra::{DMatrix, DVector};

use crate::integrate::tableau::Tableau;
use crate::linalg::{DecompositionError, symmetric_pencil};
use crate::mesh::GearMesh;
use crate::modal::CachedModel;
use crate::model::Support;

/// Bounds of the eigenvalues.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spectrum {
    /// Highest natural frequency ω_max of the undamped system, rad/s.
    pub omega_max: f64,
    /// Upper bound of xᵀCx/xᵀMx, 1/s.
    pub damping: f64,
    /// Upper bound of the increase of a frequency by the gyroscopic matrix, rad/s.
    pub gyroscopic: f64,
}

impl Spectrum {
    /// Computes the bounds at `speed` of the reference shaft, rad/s.
    ///
    /// # Errors
    /// [`DecompositionError`] if the undamped modes cannot be found.
    pub fn new(cached: &CachedModel, speed: f64) -> Result<Self, DecompositionError> {
        let model = &cached.model;
        let additional = stiffening(cached, speed) + skew_part(cached);
        let omega_max = (cached.real_modes(speed)?.highest().powi(2) + additional).sqrt();
        let [alpha, beta] = model.scene.rayleigh;
        let spread = alpha + beta * omega_max * omega_max + 2.0 * model.scene.modal_damping * omega_max;
        let spin = model.shafts.iter().map(|shaft| (shaft.ratio * speed).abs()).fold(0.0, f64::max);
        Ok(Self { omega_max, damping: spread + dampers(cached, speed)?, gyroscopic: 2.0 * spin })
    }

    /// Upper bound of |λ|, rad/s: λ² + dλ + ω² = 0 has |λ| ≤ (d + √(d² + 4ω²))/2.
    pub fn radius(&self) -> f64 {
        self.gyroscopic + (self.damping + (self.damping * self.damping + 4.0 * self.omega_max.powi(2)).sqrt()) / 2.0
    }

    /// Longest stable step of a Runge–Kutta method, s.
    ///
    /// A damped oscillator has |λ| = ω at the angle asin(d/2ω) from the imaginary axis, or is overdamped with |λ| ≤ d.
    /// For d ≤ ω_max/2, eigenvalues near ω_max are within 14.5° of the axis, and all others are well inside the stability
    /// region.
    pub fn longest_step<const S: usize>(&self, tableau: &Tableau<S>) -> f64 {
        let undamped = tableau.imaginary_limit / (self.omega_max + self.gyroscopic);
        let light = self.damping <= self.omega_max / 2.0;
        if light { undamped } else { undamped.min(tableau.real_limit / self.radius()) }
    }
}

/// Upper bound of the increase of ω_max² by meshes above their mean stiffness: Σ(k_max − k)·gᵀM⁻¹g.
fn stiffening(cached: &CachedModel, speed: f64) -> f64 {
    let model = &cached.model;
    let stiffer = |(index, mesh): (usize, &GearMesh)| {
        let excess = mesh.stiffest - mesh.stiffness;
        if excess <= 0.0 {
            return 0.0;
        }
        let sigma = model.sigma(index, speed);
        let mut gradient = DVector::zeros(model.len());
        mesh.gradient(sigma, mesh.normal_at_rest(sigma), |index, slope| gradient[index] += slope);
        let mut accelerated = gradient.clone();
        for shaft in &model.shafts {
            shaft.solve_mass(accelerated.as_mut_slice());
        }
        excess * gradient.dot(&accelerated)
    };
    model.meshes.iter().enumerate().map(stiffer).sum()
}

/// Upper bound of the increase of ω_max² by the skew part of bearing stiffnesses: Σ‖K − K_sym‖·(M⁻¹)_ii.
fn skew_part(cached: &CachedModel) -> f64 {
    let model = &cached.model;
    let add = |support: &Support| {
        let norm = support.skew_part().as_flattened().iter().map(|value| value * value).sum::<f64>().sqrt();
        if norm == 0.0 {
            return 0.0;
        }
        // The inertia is the same for v and w.
        let mut accelerated = vec![0.0; model.len()];
        accelerated[support.index] = 1.0;
        for shaft in &model.shafts {
            shaft.solve_mass(&mut accelerated);
        }
        norm * accelerated[support.index]
    };
    model.supports.iter().map(add).sum()
}

/// Largest eigenvalue of M⁻¹C for the dampers of bearings and meshes, 1/s. It is that of the small matrix DᵀM⁻¹D, where a
/// damper c on the coordinate g contributes the column √c·g of D.
fn dampers(cached: &CachedModel, speed: f64) -> Result<f64, DecompositionError> {
    let model = &cached.model;
    let mut columns: Vec<DVector<f64>> = Vec::new();
    for support in &model.supports {
        // The Frobenius norm bounds the damping in every direction, also of a non-symmetric matrix.
        let norm = support.damping.as_flattened().iter().map(|value| value * value).sum::<f64>().sqrt();
        for lane in (0..2).filter(|_| norm > 0.0) {
            let mut column = DVector::zeros(model.len());
            column[support.index + lane] = norm.sqrt();
            columns.push(column);
        }
    }
    for (index, mesh) in model.meshes.iter().enumerate().filter(|(_, mesh)| mesh.damping > 0.0) {
        let sigma = model.sigma(index, speed);
        let mut column = DVector::zeros(model.len());
        let normal = mesh.normal_at_rest(sigma);
        let flanks = if mesh.backlash.is_some() { 2.0 } else { 1.0_f64 };
        mesh.gradient(sigma, normal, |index, slope| column[index] += (flanks * mesh.damping).sqrt() * slope);
        columns.push(column);
    }
    if columns.is_empty() {
        return Ok(0.0);
    }
    let dampers = DMatrix::from_columns(&columns);
    let mut accelerated = dampers.clone();
    for mut column in accelerated.column_iter_mut() {
        for shaft in &model.shafts {
            shaft.solve_mass(column.as_mut_slice());
        }
    }
    let small = dampers.transpose() * accelerated;
    let identity = DMatrix::identity(small.nrows(), small.nrows());
    Ok(symmetric_pencil(&small, &identity, &DMatrix::zeros(small.nrows(), 0))?.values.max())
}
