//! A journal bearing: the force of its oil film over u = (v, w) of a node.
//!
//! The film force is a nonlinear function of displacement, velocity and spin of the shaft (`src/film/`). Analyses need a
//! linear system, which depends on the equilibrium and so on speed and load. The bearing therefore has two parts:
//!
//! - a [`Support`](crate::model::Support) with the stiffness K₀ and the damping C₀ of an [`OperatingPoint`]. It belongs to
//!   the matrices, and with it everything linear needs no further code;
//! - the connection: the remainder F(u, u̇, Ω) − K₀u − C₀u̇. Its linear part about the operating point is zero, so that it acts
//!   only where the force itself counts: in the equilibrium, in runs and in recorded forces.
//!
//! The sum is the film force, whatever K₀ and C₀ are. `CachedModel::at_speed` finds the operating point of a speed.

use nalgebra::{DMatrix, DVector};

use super::instant::{Instant, InterfaceOptions, OutOfRange, Touch};
use super::{Bounds, Coefficients, Row};
use crate::film::{Film, FilmForce};
use crate::scene::Matrix2;

/// Spins below this are standstill, rad/s.
const STANDSTILL: f64 = 1e-12;

/// Linear coefficients that stand for a film in the matrices.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OperatingPoint {
    /// Speed of the reference shaft, rad/s; none for the stiffness from which the search of the equilibrium starts.
    pub speed: Option<f64>,
    /// Stiffness K₀ over (v, w), N/m.
    pub stiffness: Matrix2,
    /// Damping C₀ over (v, w), N s/m.
    pub damping: Matrix2,
}

/// A journal bearing.
#[derive(Clone, Debug)]
pub struct JournalBearing {
    /// Index of the bearing in the scene.
    pub number: usize,
    /// Index of the coordinate v of its node; w has the next index.
    pub index: usize,
    /// Ratio of the speed of its shaft to the speed of the reference shaft.
    pub ratio: f64,
    /// The oil film.
    pub film: Film,
    /// The coefficients in the matrices; none in a model without a speed.
    pub point: Option<OperatingPoint>,
}

impl JournalBearing {
    /// Whether the shaft stands still at a speed of the reference shaft, rad/s.
    pub fn stands(&self, speed: f64) -> bool {
        (self.ratio * speed).abs() < STANDSTILL
    }

    /// The two scalars of the bearing: v and w of the node.
    pub fn rows(&self) -> Vec<Row> {
        vec![vec![(self.index, 1.0)], vec![(self.index + 1, 1.0)]]
    }

    /// Film force, stiffness and damping at displacements q, velocities v and a speed of the reference shaft, rad/s.
    #[inline]
    pub fn film_force(&self, speed: f64, q: &[f64], v: &[f64]) -> FilmForce {
        let i = self.index;
        self.film.at([q[i], q[i + 1]], [v[i], v[i + 1]], self.ratio * speed)
    }

    /// Eccentricity ratio ε at displacements q.
    #[inline]
    pub fn eccentricity_ratio(&self, q: &[f64]) -> f64 {
        self.film.eccentricity_ratio([q[self.index], q[self.index + 1]])
    }

    /// Force and derivatives beyond those of the matrices.
    #[inline]
    fn remainder(&self, speed: f64, u: [f64; 2], rates: [f64; 2]) -> FilmForce {
        let mut film = self.film.at(u, rates, self.ratio * speed);
        if let Some(OperatingPoint { stiffness, damping, .. }) = &self.point {
            for i in 0..2 {
                for j in 0..2 {
                    film.force[i] -= stiffness[i][j] * u[j] + damping[i][j] * rates[j];
                    film.stiffness[i][j] -= stiffness[i][j];
                    film.damping[i][j] -= damping[i][j];
                }
            }
        }
        film
    }

    /// Force of the shaft on the bearing beyond that of the matrices, components (y, z), N, at a speed of the reference
    /// shaft, rad/s.
    ///
    /// # Errors
    /// [`Touch`] where the journal touches the bearing.
    #[inline]
    pub fn force(&self, speed: f64, q: &[f64], v: &[f64]) -> Result<[f64; 2], Touch> {
        let i = self.index;
        let (u, rates) = ([q[i], q[i + 1]], [v[i], v[i + 1]]);
        self.check(u)?;
        Ok(self.remainder(speed, u, rates).force)
    }

    /// Refuses a displacement at which the journal touches the bearing.
    #[inline]
    fn check(&self, u: [f64; 2]) -> Result<(), Touch> {
        let eccentricity_ratio = self.film.eccentricity_ratio(u);
        if eccentricity_ratio < 1.0 { Ok(()) } else { Err(Touch { bearing: self.number, eccentricity_ratio }) }
    }

    /// Force over the scalars beyond that of the matrices, N, and its derivative, N/m, at the displacements q of a system at
    /// rest.
    pub fn static_tangent(&self, speed: f64, q: &[f64]) -> (DVector<f64>, DMatrix<f64>) {
        let i = self.index;
        let found = self.remainder(speed, [q[i], q[i + 1]], [0.0; 2]);
        (DVector::from_column_slice(&found.force), DMatrix::from_fn(2, 2, |i, j| found.stiffness[i][j]))
    }

    /// The connection has no linear part.
    pub fn linear(&self) -> Coefficients {
        Coefficients::isotropic(2, 0.0, 0.0)
    }

    /// Bounds for the step limit of Runge–Kutta methods: those of the matrices. The film has no bound; use a method with
    /// error control for a journal that comes close to the bearing.
    pub fn bounds(&self) -> Bounds {
        Bounds { excess_stiffness: 0.0, damping: 0.0 }
    }

    /// Elastic energy that the matrices count, with the opposite sign, J: a film stores none.
    pub fn energy(&self, q: &[f64]) -> f64 {
        -self.counted(q, q) / 2.0
    }

    /// Power that the film takes from the shaft beyond that which the matrices count as damping, W.
    pub fn damping_power(&self, speed: f64, q: &[f64], v: &[f64]) -> f64 {
        let i = self.index;
        let force = self.remainder(speed, [q[i], q[i + 1]], [v[i], v[i + 1]]).force;
        force[0] * v[i] + force[1] * v[i + 1] + self.counted(q, v)
    }

    /// aᵀKb with the symmetric part K of the stiffness in the matrices.
    fn counted(&self, a: &[f64], b: &[f64]) -> f64 {
        let (i, k) = (self.index, self.point.map_or([[0.0; 2]; 2], |point| point.stiffness));
        let cross = (k[0][1] + k[1][0]) / 2.0;
        k[0][0] * a[i] * b[i] + cross * (a[i] * b[i + 1] + a[i + 1] * b[i]) + k[1][1] * a[i + 1] * b[i + 1]
    }
}

/// A journal bearing in a run.
#[derive(Clone, Debug)]
pub struct JournalInterface {
    bearing: JournalBearing,
    /// Displacement (v, w) at the reference, m.
    reference: [f64; 2],
    /// Generalised forces at the reference, without the part in the matrices, N.
    pub(super) reference_force: [f64; 2],
}

impl JournalInterface {
    pub(super) fn new(bearing: &JournalBearing, options: InterfaceOptions<'_>) -> Self {
        let reference = [options.reference[bearing.index], options.reference[bearing.index + 1]];
        let force = bearing.remainder(options.speed, reference, [0.0; 2]).force;
        Self { bearing: bearing.clone(), reference, reference_force: force.map(|force| -force) }
    }

    pub(super) fn rows(&self) -> Vec<Row> {
        self.bearing.rows()
    }

    pub(super) fn linear(&self) -> Coefficients {
        self.bearing.linear()
    }

    fn displacement(&self, u: &[f64]) -> [f64; 2] {
        [self.reference[0] + u[0], self.reference[1] + u[1]]
    }

    #[inline]
    pub(super) fn load(&self, instant: &Instant, u: &[f64], rates: &[f64], load: &mut [f64]) -> Result<(), OutOfRange> {
        let at = self.displacement(u);
        self.bearing.check(at)?;
        let force = self.bearing.remainder(instant.speed, at, [rates[0], rates[1]]).force;
        for (i, load) in load.iter_mut().enumerate() {
            *load = -force[i] - self.reference_force[i];
        }
        Ok(())
    }

    #[inline]
    pub(super) fn residual_tangent(
        &self,
        instant: &Instant,
        (u, rates): (&[f64], &[f64]),
        [stiffness, damping]: [&mut [f64]; 2],
    ) {
        let found = self.bearing.remainder(instant.speed, self.displacement(u), [rates[0], rates[1]]);
        stiffness.copy_from_slice(found.stiffness.as_flattened());
        damping.copy_from_slice(found.damping.as_flattened());
    }
}
