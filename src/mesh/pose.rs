//! What the force of a mesh depends on: coordinates, relative motion of the gears, and the directions of the deflection.

use super::contact::ShaftPhase;

/// Whether the line of action follows the centres.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Geometry {
    /// The line of action follows the moving centres.
    Live,
    /// The line of action is that of the centres at rest.
    Frozen,
}

/// Indices of the coordinates of a mesh in a vector of displacements.
#[derive(Clone, Copy, Debug)]
pub struct MeshCoordinates {
    /// v of driver and driven gear (w, Γ, −B follow v); `None` in a scene that has no bending.
    pub translation: Option<[usize; 2]>,
    /// u of driver and driven gear; `None` in a scene without axial motion.
    pub axial: Option<[usize; 2]>,
    /// θ of driver and driven gear.
    pub twist: [usize; 2],
    /// θ of the carrier, to which twists and centres are relative; `None` for gears on fixed axes.
    pub carrier: Option<usize>,
}

impl MeshCoordinates {
    /// Combination x θ_a + y θ_b of the twists relative to the carrier, as a row.
    pub fn twist_row(&self, [x, y]: [f64; 2]) -> Vec<(usize, f64)> {
        let [a, b] = self.twist;
        let relative = [(a, x), (b, y)].into_iter().chain(self.carrier.map(|carrier| (carrier, -(x + y))));
        relative.filter(|(_, factor)| *factor != 0.0).collect()
    }
}

/// Everything on which the force of a mesh depends except its contact mode.
#[derive(Clone, Copy, Debug)]
pub struct MeshPose<'a> {
    /// Whether its line of action follows the centres.
    pub geometry: Geometry,
    /// σ, the sign of the driver's spin.
    pub sigma: f64,
    /// Angles and spins of the shafts of driver and driven gear, relative to those of the carrier.
    pub phases: &'a [ShaftPhase; 2],
    /// Relative displacements.
    pub position: RelativeMotion,
    /// Relative velocities.
    pub velocity: RelativeMotion,
}

/// Relative motion of the gears of a mesh: displacements, or velocities (then per second).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RelativeMotion {
    /// u_b − u_a over (y, z), m.
    pub relative_displacement: [f64; 2],
    /// r_a θ_a + r_b θ_b, m; with helical teeth the rolling displacement ρ.
    pub rolling_displacement: f64,
    /// Mean tilt τ of helical gears, rad.
    pub tilt: [f64; 2],
    /// θ_a and θ_b, rad: used where the tooth engagement follows the twist, and for run-out.
    pub twist: [f64; 2],
}

/// Directions in which the deflection of a mesh changes with its coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Directions {
    /// Minus the derivative of δ with respect to u_b − u_a over (y, z): the unit vector of the line of action, and with
    /// helical teeth its change by the tilt of the gears.
    pub normal: [f64; 2],
    /// Vector between the centres, m; used by helical teeth.
    pub centres: [f64; 2],
}

#[inline(always)]
pub(super) fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}
