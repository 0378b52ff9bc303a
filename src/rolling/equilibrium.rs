//! Displacement at which rolling elements carry a given static load.

use super::RollingElements;
use crate::bearing_force::{BalanceSearch, BearingForce, Uncarried, Vector};

/// Largest residual force, relative to the load, of a result: round-off may leave it.
const MAX_RESIDUAL: f64 = 1e-9;
/// Smallest part of the secant stiffness that is added to the tangent: a single loaded element has no stiffness across it.
const MIN_ADDED_FRACTION: f64 = 1e-9;
/// Largest part of the secant stiffness that is added, at a residual of the whole load.
const MAX_ADDED_FRACTION: f64 = 1e-3;

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
        let force = |u: Vector| cage.map_or_else(|| self.mean(u), |cage| self.at::<true>(u, [0.0; 2], cage));
        let whole = load[0].hypot(load[1]);
        if whole == 0.0 {
            return Ok(([0.0; 2], force([0.0; 2])));
        }
        let secant = self.secant_stiffness(whole);
        let search = BalanceSearch {
            load,
            force: &force,
            added_stiffness: &|residual| {
                secant * (MAX_ADDED_FRACTION * residual).clamp(MIN_ADDED_FRACTION, MAX_ADDED_FRACTION)
            },
            is_permitted: &|_, _| true,
        };
        // Beyond the equilibrium all loaded elements carry.
        let found = search.from(load.map(|load| 2.0 * load / secant));
        if found.residual <= MAX_RESIDUAL {
            Ok((found.displacement, found.bearing))
        } else {
            Err(Uncarried::Unbalanced(found.residual))
        }
    }
}
