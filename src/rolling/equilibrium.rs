//! Displacement at which rolling elements carry a given static load.

use super::RollingElements;
use crate::bearing_force::{BearingForce, Uncarried, Vector};

/// Largest number of Newton iterations; ten are usual.
const MAX_ITERATIONS: usize = 200;
/// Residual force, relative to the load, below which the iteration has converged.
const TOLERANCE: f64 = 1e-13;
/// Largest residual force, relative to the load, of a result: round-off may leave it.
const MAX_RESIDUAL: f64 = 1e-9;
/// Smallest fraction of a Newton step. With a smaller one, the residual changes by round-off only.
const LEAST_FRACTION: f64 = 1e-10;
/// Smallest part of the secant stiffness that is added to the tangent: a single loaded element has no stiffness across it.
const LEAST_ADDED: f64 = 1e-9;

impl RollingElements {
    /// Displacement of the shaft, m, and the force there, under a static load over (y, z), N, at an angle of the cage, rad,
    /// or averaged over the angles of the cage.
    ///
    /// The elastic energy is convex, so that Newton's method with a small addition to the tangent and with a reduction of
    /// steps that raise the residual converges from anywhere.
    ///
    /// # Errors
    /// [`Uncarried`] if the residual force exceeds `MAX_RESIDUAL` of the load.
    pub fn carrying(&self, load: Vector, cage: Option<f64>) -> Result<(Vector, BearingForce), Uncarried> {
        let size = |v: Vector| v[0].hypot(v[1]);
        let at = |u: Vector| cage.map_or_else(|| self.mean(u), |cage| self.at(u, [0.0; 2], cage));
        let residual = |found: &BearingForce| [load[0] - found.force[0], load[1] - found.force[1]];
        let whole = size(load);
        let mut u = [0.0; 2];
        if whole == 0.0 {
            return Ok((u, at(u)));
        }
        let secant = self.secant_stiffness(whole);
        // Beyond the equilibrium all loaded elements carry.
        u = load.map(|load| 2.0 * load / secant);
        let mut found = at(u);
        'search: for _ in 0..MAX_ITERATIONS {
            let missing = residual(&found);
            if size(missing) <= TOLERANCE * whole {
                break;
            }
            let added = secant * (1e-3 * size(missing) / whole).clamp(LEAST_ADDED, 1e-3);
            let [[a, b], [c, d]] = found.stiffness;
            let (a, d) = (a + added, d + added);
            let determinant = a * d - b * c;
            let step =
                [(d * missing[0] - b * missing[1]) / determinant, (a * missing[1] - c * missing[0]) / determinant];
            let mut fraction = 1.0;
            loop {
                let next = [u[0] + fraction * step[0], u[1] + fraction * step[1]];
                let there = at(next);
                if size(residual(&there)) < size(missing) {
                    (u, found) = (next, there);
                    break;
                }
                fraction /= 2.0;
                if fraction < LEAST_FRACTION || !fraction.is_finite() {
                    break 'search;
                }
            }
        }
        let missing = size(residual(&found)) / whole;
        if missing <= MAX_RESIDUAL { Ok((u, found)) } else { Err(Uncarried::Unbalanced(missing)) }
    }
}
