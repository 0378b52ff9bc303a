//! Bounds of the eigenvalues of a model, which limit the step of explicit methods.

use nalgebra::{DMatrix, DVector};

use super::AnalysisError;
use crate::connection::{Connection, Row};
use crate::integrate::tableau::Tableau;
use crate::linalg::{DecompositionError, symmetric_pencil};
use crate::modal::CachedModel;
use crate::model::{Link, Support};
use crate::scene::Matrix2;

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
    /// Computes the bounds at `speed` of the reference shaft, rad/s. Bearings that depend on the speed are bounded over
    /// all speeds of their tables.
    ///
    /// # Errors
    /// [`AnalysisError`] if the undamped modes cannot be found, or a bearing has no coefficients at the speed.
    pub fn new(cached: &CachedModel, speed: f64) -> Result<Self, AnalysisError> {
        let (model, reference) = (&cached.model, cached.at_speed(speed)?);
        let fastest = reference.spectral_range(speed)?.fastest;
        let internal = model.scene.shafts.iter().map(|shaft| shaft.internal_damping).fold(0.0, f64::max);
        let circulatory = internal * model.max_speed_ratio() * speed.abs() * fastest * fastest;
        let additional = stiffening(cached, speed) + skew_part(&reference) + circulatory;
        let omega_max = (fastest.powi(2) + additional).sqrt();
        let [alpha, beta] = model.scene.rayleigh;
        let spread =
            alpha + (beta + internal) * omega_max * omega_max + 2.0 * model.scene.modal_damping.largest() * omega_max;
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

/// Upper bound of the increase of ω_max² by connections that can be stiffer than their linear part: the norm of the excess
/// stiffness times Σ wᵀM⁻¹w over the scalars w of each connection.
fn stiffening(cached: &CachedModel, speed: f64) -> f64 {
    let model = &cached.model;
    let stiffer = |connection: Connection<'_>| {
        let excess = connection.bounds(speed).excess_stiffness;
        if excess <= 0.0 {
            return 0.0;
        }
        let accelerated = |entries: Row| {
            let mut row = DVector::zeros(model.len());
            entries.iter().for_each(|(index, coefficient)| row[*index] += coefficient);
            let mut accelerated = row.clone();
            model.solve_mass(accelerated.as_mut_slice());
            row.dot(&accelerated)
        };
        excess * connection.rows().into_iter().map(accelerated).sum::<f64>()
    };
    model.connections(speed).map(stiffer).sum()
}

/// Upper bound of the increase of ω_max² by the skew part of bearing stiffnesses: Σ‖K − K_sym‖·(M⁻¹)_ii.
fn skew_part(cached: &CachedModel) -> f64 {
    let model = &cached.model;
    let add = |support: &Support| {
        let norm = norm(&support.skew_part());
        if norm == 0.0 {
            return 0.0;
        }
        // The inertia is the same for v and w.
        let mut accelerated = vec![0.0; model.len()];
        accelerated[support.index] = 1.0;
        model.solve_mass(&mut accelerated);
        norm * accelerated[support.index]
    };
    let of_link = |link: &Link| match norm(&link.local.skew_part()) {
        0.0 => 0.0,
        norm => norm * link.mobility(model.len(), |x| model.solve_mass(x)),
    };
    model.supports.iter().map(add).sum::<f64>() + model.links.iter().map(of_link).sum::<f64>()
}

/// Frobenius norm.
fn norm(matrix: &Matrix2) -> f64 {
    matrix.as_flattened().iter().map(|value| value * value).sum::<f64>().sqrt()
}

/// Largest eigenvalue of M⁻¹C for the dampers of bearings and connections, 1/s. It is that of the small matrix DᵀM⁻¹D,
/// where a damper c on the coordinate g contributes the column √c·g of D.
fn dampers(cached: &CachedModel, speed: f64) -> Result<f64, DecompositionError> {
    let model = &cached.model;
    let mut columns: Vec<DVector<f64>> = Vec::new();
    for support in &model.supports {
        // The Frobenius norm bounds the damping in every direction, also of a non-symmetric matrix.
        let norm = norm(&support.damping);
        for lane in (0..2).filter(|_| norm > 0.0) {
            let mut column = DVector::zeros(model.len());
            column[support.index + lane] = norm.sqrt();
            columns.push(column);
        }
    }
    let links = model.links.iter().map(|link| (norm(&link.local.damping), link.rows.clone()));
    let connections = model.connections(speed);
    let connections = connections.map(|connection| (connection.bounds(speed).damping, connection.rows()));
    for (norm, rows) in links.chain(connections) {
        for entries in rows.into_iter().filter(|_| norm > 0.0) {
            let mut column = DVector::zeros(model.len());
            entries.iter().for_each(|(index, coefficient)| column[*index] += norm.sqrt() * coefficient);
            columns.push(column);
        }
    }
    if columns.is_empty() {
        return Ok(0.0);
    }
    let dampers = DMatrix::from_columns(&columns);
    let mut accelerated = dampers.clone();
    for mut column in accelerated.column_iter_mut() {
        model.solve_mass(column.as_mut_slice());
    }
    let small = dampers.transpose() * accelerated;
    let identity = DMatrix::identity(small.nrows(), small.nrows());
    Ok(symmetric_pencil(&small, &identity, &DMatrix::zeros(small.nrows(), 0))?.values.max())
}
