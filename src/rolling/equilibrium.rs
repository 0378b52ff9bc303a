//! Displacement at which rolling elements, or a ring of them, carry a given static load.

use super::RollingElements;
use super::ring::{Ring, RingVector};
use crate::bearing_force::{Balance, BalanceSearch, BearingForce, MAX_RESIDUAL, Uncarried, Vector};

/// Stiffness that is added to the diagonal of the tangent, relative to the secant stiffness, at a residual of the whole load: a
/// single loaded element has no stiffness across it.
const ADDED_FRACTION: f64 = 1e-2;
/// Smallest residual, relative to the load, for which the addition falls with it.
const MIN_ADDED_RESIDUAL: f64 = 1e-6;

/// The displacement at which a force is the load, N, which is not zero, in a search from a displacement, m. The elastic energy
/// of the force is convex, so that Newton's method with a small addition to the tangent and with a reduction of steps that raise
/// the residual converges from anywhere. `secant` is the stiffness under the load, N/m.
fn balance<const N: usize>(
    load: [f64; N],
    secant: f64,
    force: &dyn Fn([f64; N]) -> BearingForce<N>,
    start: [f64; N],
) -> Result<Balance<N>, Uncarried> {
    let search = BalanceSearch {
        load,
        force,
        added_stiffness: &|residual| secant * ADDED_FRACTION * residual.clamp(MIN_ADDED_RESIDUAL, 1.0),
        is_permitted: &|_, _| true,
    };
    let found = search.from(start);
    if found.residual <= MAX_RESIDUAL { Ok(found) } else { Err(Uncarried::Unbalanced(found.residual)) }
}

impl RollingElements {
    /// Displacement of the shaft, m, and the force there, under a static load over (y, z), N, at an angle of the cage, rad,
    /// or averaged over the angles of the cage.
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
        // Beyond the equilibrium all loaded elements carry.
        let found = balance(load, secant, &force, load.map(|load| 2.0 * load / secant))?;
        Ok((found.displacement, found.bearing))
    }
}

impl Ring {
    /// Coordinates of the ring under a static load, N, and the force there, averaged over the angles of the cage.
    ///
    /// # Errors
    /// [`Uncarried`] if the residual force exceeds `MAX_RESIDUAL` of the load.
    pub fn carrying(&self, load: RingVector) -> Result<(RingVector, BearingForce<5>), Uncarried> {
        if load == [0.0; 5] {
            return Ok(([0.0; 5], self.mean([0.0; 5])));
        }
        let found = balance(load, self.secant(load), &|x| self.mean(x), [0.0; 5])?;
        Ok((found.displacement, found.bearing))
    }

    /// Coordinates under the forces along (y, z) and the axis, N, with given slopes times the radius, m, at the cage angle zero.
    ///
    /// # Errors
    /// As [`Self::carrying`].
    pub fn carrying_tilted(&self, load: [f64; 3], tilt: [f64; 2]) -> Result<RingVector, Uncarried> {
        let complete = |[v, w, u]: [f64; 3]| [v, w, u, tilt[0], tilt[1]];
        if load == [0.0; 3] {
            return Ok(complete([0.0; 3]));
        }
        let force = |x: [f64; 3]| {
            let found = self.at::<true>(complete(x), 0.0);
            let stiffness = [0, 1, 2].map(|i| [0, 1, 2].map(|j| found.stiffness[i][j]));
            BearingForce { force: [0, 1, 2].map(|i| found.force[i]), stiffness, ..BearingForce::default() }
        };
        let found = balance(load, self.secant(load), &force, [0.0; 3])?;
        Ok(complete(found.displacement))
    }

    /// Stiffness under a load, N/m.
    fn secant<const N: usize>(&self, load: [f64; N]) -> f64 {
        self.secant_stiffness(load.into_iter().fold(0.0, f64::hypot))
    }
}
