//! A spring and damper with a cubic term on r scalars u = Wᵀq: F = (k + k₃|u|²) u + c u̇.
//!
//! This is the simplest connection that answers every question. On one scalar it is a cubic spring, F = k u + k₃u³ + c u̇.
//! On v and w of a node, or on their differences between two nodes, it is isotropic. Its tangent stiffness
//! (k + k₃|u|²) 1 + 2k₃ u uᵀ has rank r and entries off the diagonal. A scene cannot contain it. The tests build models
//! with it to check that no analysis ignores a connection, and `docs/adding_a_connection.md` uses it as the example.

use nalgebra::{DMatrix, DVector};

use super::instant::InterfaceOptions;
use super::{Bounds, Coefficients, Row};

/// A spring and damper with a cubic term.
#[derive(Clone, Debug)]
pub struct Spring {
    /// The scalars u as entries (index of a coordinate, coefficient).
    pub rows: Vec<Row>,
    /// Stiffness k, N/m for scalars in m.
    pub stiffness: f64,
    /// Cubic stiffness k₃, N/m³.
    pub cubic: f64,
    /// Damping c, N s/m.
    pub damping: f64,
}

impl Spring {
    /// Stiffness and damping about u = 0.
    pub fn linear(&self) -> Coefficients {
        Coefficients::isotropic(self.rows.len(), self.stiffness, self.damping)
    }

    /// Bounds for the step limit of Runge–Kutta methods: the damping c, N s/m, and no stiffness beyond k, N/m, because the
    /// cubic term has no bound. For a large cubic term, use a method with error control.
    pub fn bounds(&self) -> Bounds {
        Bounds { excess_stiffness: 0.0, damping: self.damping }
    }

    /// The scalars u for displacements q, or u̇ for velocities.
    #[inline]
    pub fn scalars(&self, q: &[f64]) -> impl Iterator<Item = f64> {
        self.rows.iter().map(|row| row.iter().map(|(index, coefficient)| coefficient * q[*index]).sum())
    }

    /// |u|² for displacements q, or |u̇|² for velocities.
    pub fn square(&self, q: &[f64]) -> f64 {
        self.scalars(q).map(|u| u * u).sum()
    }

    /// Ratio of the elastic force to u: k + k₃|u|², N/m, from |u|².
    #[inline]
    fn secant(&self, square: f64) -> f64 {
        self.stiffness + self.cubic * square
    }

    /// Subtracts the force F at q and v from the generalised forces of its coordinates.
    #[inline]
    pub fn apply(&self, q: &[f64], v: &[f64], out: &mut [f64]) {
        let secant = self.secant(self.square(q));
        for ((row, u), rate) in self.rows.iter().zip(self.scalars(q)).zip(self.scalars(v)) {
            let force = secant * u + self.damping * rate;
            row.iter().for_each(|(index, coefficient)| out[*index] -= coefficient * force);
        }
    }

    /// Elastic energy k|u|²/2 + k₃|u|⁴/4, J.
    pub fn energy(&self, q: &[f64]) -> f64 {
        let square = self.square(q);
        (self.stiffness / 2.0 + self.cubic / 4.0 * square) * square
    }

    /// Power dissipated by damping, c|u̇|², W.
    pub fn damping_power(&self, v: &[f64]) -> f64 {
        self.damping * self.square(v)
    }

    /// ∂F_i/∂u_j, N/m, at the scalars u, of which `u` gives each.
    #[inline]
    fn tangent(&self, u: impl Fn(usize) -> f64, [i, j]: [usize; 2]) -> f64 {
        let square = (0..self.rows.len()).map(|k| u(k) * u(k)).sum();
        let secant = if i == j { self.secant(square) } else { 0.0 };
        secant + 2.0 * self.cubic * u(i) * u(j)
    }

    /// F, N, and ∂F/∂u, N/m, at the displacements q of a system at rest.
    pub fn static_tangent(&self, q: &[f64]) -> (DVector<f64>, DMatrix<f64>) {
        let u = DVector::from_iterator(self.rows.len(), self.scalars(q));
        let tangent = DMatrix::from_fn(u.len(), u.len(), |i, j| self.tangent(|k| u[k], [i, j]));
        (&u * self.secant(u.norm_squared()), tangent)
    }
}

/// A spring in a run.
#[derive(Clone, Debug)]
pub struct SpringInterface {
    pub(super) spring: Spring,
    /// Scalars u at the reference, m.
    reference: Vec<f64>,
    /// Generalised forces −F at the reference, N.
    pub(super) reference_force: Vec<f64>,
    /// Stiffness, N/m, and damping, N s/m, that the linear motion contains.
    contained: [f64; 2],
}

impl SpringInterface {
    pub(super) fn new(spring: &Spring, options: InterfaceOptions<'_>) -> Self {
        let (force, _) = spring.static_tangent(options.reference);
        Self {
            spring: spring.clone(),
            reference: spring.scalars(options.reference).collect(),
            reference_force: force.iter().map(|force| -force).collect(),
            contained: if options.contained { [spring.stiffness, spring.damping] } else { [0.0; 2] },
        }
    }

    pub(super) fn has_rates(&self) -> bool {
        self.spring.damping != self.contained[1]
    }

    pub(super) fn is_affine(&self) -> bool {
        self.reference.len() == 1 && self.spring.cubic == 0.0 && !self.has_rates()
    }

    #[inline(always)]
    pub(super) fn load(&self, u: &[f64], rates: &[f64], load: &mut [f64]) {
        let square = self.reference.iter().zip(u).map(|(reference, u)| (reference + u) * (reference + u)).sum();
        let (secant, [stiffness, damping]) = (self.spring.secant(square), self.contained);
        for (i, (load, u)) in load.iter_mut().zip(u).enumerate() {
            let rate = rates.get(i).copied().unwrap_or(0.0);
            let force = secant * (self.reference[i] + u) + self.spring.damping * rate;
            *load = (-force - self.reference_force[i]) + stiffness * u + damping * rate;
        }
    }

    pub(super) fn residual_tangent(&self, u: &[f64], [stiffness, damping]: [&mut [f64]; 2]) {
        let len = self.reference.len();
        for (at, stiffness) in stiffness.iter_mut().enumerate() {
            let (i, j) = (at / len, at % len);
            let contained = if i == j { self.contained[0] } else { 0.0 };
            *stiffness = self.spring.tangent(|k| self.reference[k] + u[k], [i, j]) - contained;
        }
        for (at, damping) in damping.iter_mut().enumerate() {
            let is_diagonal = at / len == at % len;
            *damping = if is_diagonal { self.spring.damping - self.contained[1] } else { 0.0 };
        }
    }
}
