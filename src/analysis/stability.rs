//! How fast the fastest motion of a scene is: the limit of every explicit step.

use nalgebra::{DMatrix, DVector};

use crate::integrate::tableau::Tableau;
use crate::linalg::{DecompositionError, symmetric_pencil};
use crate::mesh::GearMesh;
use crate::modal::CachedModel;
use crate::model::Support;

/// Bounds of the eigenvalues.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spectrum {
    /// ω_max of the undamped system, rad/s.
    pub omega_max: f64,
    /// Bound of xᵀCx/xᵀMx, 1/s.
    pub damping: f64,
    /// Bound of what the gyroscopic matrix adds to a frequency, rad/s.
    pub gyroscopic: f64,
}

impl Spectrum {
    /// Bounds at `speed` of the reference shaft.
    ///
    /// # Errors
    /// [`DecompositionError`] if the undamped modes cannot be found.
    pub fn new(cached: &CachedModel, speed: f64) -> Result<Self, DecompositionError> {
        let model = &cached.model;
        let beside = stiffening(cached, speed) + skew_part(cached);
        let omega_max = (cached.real_modes(speed)?.highest().powi(2) + beside).sqrt();
        let [alpha, beta] = model.scene.rayleigh;
        let spread = alpha + beta * omega_max * omega_max + 2.0 * model.scene.modal_damping * omega_max;
        let spin = model.shafts.iter().map(|shaft| (shaft.ratio * speed).abs()).fold(0.0, f64::max);
        Ok(Self { omega_max, damping: spread + dampers(cached, speed)?, gyroscopic: 2.0 * spin })
    }

    /// Bound of |λ|: λ² + dλ + ω² = 0 has |λ| ≤ (d + √(d² + 4ω²))/2.
    pub fn radius(&self) -> f64 {
        self.gyroscopic + (self.damping + (self.damping * self.damping + 4.0 * self.omega_max.powi(2)).sqrt()) / 2.0
    }

    /// The longest stable step of a method, s.
    ///
    /// A damped oscillator has |λ| = ω, at the angle asin(d/2ω) from the imaginary axis, or is overdamped with |λ| ≤ d.
    /// While d ≤ ω_max/2 those near ω_max stay within 14.5° of the axis, and all others have room.
    pub fn longest_step<const S: usize>(&self, tableau: &Tableau<S>) -> f64 {
        let undamped = tableau.imaginary_limit / (self.omega_max + self.gyroscopic);
        let light = self.damping <= self.omega_max / 2.0;
        if light { undamped } else { undamped.min(tableau.real_limit / self.radius()) }
    }
}

/// A bound of what meshes that are stiffer than their mean add to ω_max²: (k_max − k)·gᵀM⁻¹g each.
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

/// A bound of what bearings that do more than restore add to ω_max²: the norm of K − K_restoring times (M⁻¹)_ii each.
fn skew_part(cached: &CachedModel) -> f64 {
    let model = &cached.model;
    let add = |support: &Support| {
        let norm = support.skew_part().as_flattened().iter().map(|value| value * value).sum::<f64>().sqrt();
        if norm == 0.0 {
            return 0.0;
        }
        // v and w have the same inertia.
        let mut accelerated = vec![0.0; model.len()];
        accelerated[support.index] = 1.0;
        for shaft in &model.shafts {
            shaft.solve_mass(&mut accelerated);
        }
        norm * accelerated[support.index]
    };
    model.supports.iter().map(add).sum()
}

/// The largest eigenvalue of M⁻¹C for the dampers of bearings and meshes: that of the small matrix dᵀM⁻¹d, where each
/// damper c on the coordinate g contributes the column d = √c·g.
fn dampers(cached: &CachedModel, speed: f64) -> Result<f64, DecompositionError> {
    let model = &cached.model;
    let mut columns: Vec<DVector<f64>> = Vec::new();
    for support in &model.supports {
        // Its Frobenius norm bounds what a damping matrix, symmetric or not, does in any direction.
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
