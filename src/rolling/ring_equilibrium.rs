//! Displacement at which a ring carries a given static load.

use super::ring::{Ring, RingVector};
use crate::bearing_force::{BalanceSearch, BearingForce, Uncarried};

/// Largest residual force of an equilibrium, relative to the load.
const MAX_RESIDUAL: f64 = 1e-9;
/// Stiffness that is added to the diagonal of the tangent, relative to the secant stiffness, at a residual of the whole load.
const ADDED_FRACTION: f64 = 1e-2;
/// Smallest residual, relative to the load, for which the addition falls with it.
const MIN_ADDED_RESIDUAL: f64 = 1e-6;

impl Ring {
    /// Coordinates of the ring under a static load, N, and the force there, averaged over the angles of the cage.
    ///
    /// # Errors
    /// [`Uncarried`] if the residual force exceeds `MAX_RESIDUAL` of the load.
    pub fn carrying(&self, load: RingVector) -> Result<(RingVector, BearingForce<5>), Uncarried> {
        if load == [0.0; 5] {
            return Ok(([0.0; 5], self.mean([0.0; 5])));
        }
        let x = self.balance(load, &|x| self.mean(x))?;
        Ok((x, self.mean(x)))
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
        self.balance(load, &force).map(complete)
    }

    /// The displacement at which a force, whose elastic energy is convex, is the load, N, which is not zero.
    fn balance<const N: usize>(
        &self,
        load: [f64; N],
        force: &dyn Fn([f64; N]) -> BearingForce<N>,
    ) -> Result<[f64; N], Uncarried> {
        let secant = self.secant_stiffness(load.into_iter().fold(0.0, f64::hypot));
        let search = BalanceSearch {
            load,
            force,
            added_stiffness: &|residual| secant * ADDED_FRACTION * residual.clamp(MIN_ADDED_RESIDUAL, 1.0),
            is_permitted: &|_, _| true,
        };
        let found = search.from([0.0; N]);
        if found.residual <= MAX_RESIDUAL { Ok(found.displacement) } else { Err(Uncarried::Unbalanced(found.residual)) }
    }
}
