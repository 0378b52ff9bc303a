//! A pair of involutes is a crossed belt between the base circles; its change of length is the mesh deflection.
//!
//! With S = r_a + r_b, centres apart by c = C₀(cos ψ, sin ψ) + (u_b − u_a), C = |c|, γ = arg c and cos α = S/C:
//!
//! ```text
//! δ = σ[ r_a θ_a + r_b θ_b − S(γ − ψ) ] − S(inv α − inv α₀),        inv α = tan α − α
//! ```
//!
//! σ is the sign of the driver's spin. The gradient of δ over the displacement of a is the line of action
//! n = σ cos α·(−sin γ, cos γ) + sin α·(cos γ, sin γ), over that of b it is −n, over the twists σr_a and σr_b.
//! Angles count counter-clockwise seen from +x, y to the right and z up.
//!
//! Every difference (γ − ψ, inv α − inv α₀) is computed as one, not as the difference of two rounded numbers: a
//! load of 1e-9 N deflects a mesh by 1e-18 m, which is still right to all its digits.

use crate::scene::{Gear, Mesh};

/// What the teeth and the centres at rest make of a pair.
#[derive(Clone, Debug)]
pub struct Involute {
    /// Base radii of driver and driven gear, m.
    pub base_radius: [f64; 2],
    /// √(tip radius² − base radius²) of driver and driven gear, m.
    tip_reach: [f64; 2],
    /// Base pitch of the driver, m.
    pub base_pitch: f64,
    /// Thickness of a tooth of the driver on its base circle, m: so far its back flank follows its drive flank.
    pub base_thickness: f64,
    /// S, the sum of the base radii, m.
    sum: f64,
    /// C₀, m.
    distance: f64,
    /// t₀ = C₀ sin α₀, the length of the line of action between the base circles at rest, m.
    tangent: f64,
    /// α₀, rad.
    pressure_angle: f64,
    /// ψ, rad, with its cosine and sine.
    angle: f64,
    direction: [f64; 2],
}

/// How the centres lie at an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Centres {
    /// Operating pressure angle α, rad.
    pub pressure_angle: f64,
    /// Distance C, m.
    pub distance: f64,
    /// Angle γ of the line of centres, rad: near the ψ that was given, whatever turns that contains.
    pub angle: f64,
    /// Contact ratio ε.
    pub contact_ratio: f64,
}

/// How the centres lie: what the lines of action of both flanks have in common.
#[derive(Clone, Copy, Debug)]
pub(super) struct CentreGeometry {
    /// Unit vector along the line of centres.
    direction: [f64; 2],
    /// C, m.
    distance: f64,
    /// C sin α, m.
    tangent: f64,
    /// γ − ψ, rad.
    turned: f64,
    /// α − α₀, rad.
    steeper: f64,
    /// S(inv α − inv α₀), m.
    longer: f64,
}

/// The deflection and its derivatives over the displacement of the driver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineOfAction {
    /// The part of δ that the centres make, −σS(γ − ψ) − S(inv α − inv α₀), m.
    pub deflection: f64,
    /// Unit vector n over (y, z).
    pub normal: [f64; 2],
    /// Unit vector m across it; ∂n/∂(u_b − u_a) = m mᵀ / `tangent`.
    pub tangent_direction: [f64; 2],
    /// C sin α, m.
    pub tangent: f64,
    /// γ − ψ, rad.
    pub turned: f64,
    /// α − α₀, rad.
    pub steeper: f64,
}

/// The base circles overlap: there is no line of action.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Overlap {
    /// Distance of the centres, m.
    pub distance: f64,
    /// Sum of the base radii, m.
    pub base_circles: f64,
}

impl Involute {
    /// The pair of a mesh.
    pub fn new(mesh: &Mesh, gears: &[Gear]) -> Self {
        let (a, b) = (&gears[mesh.driver], &gears[mesh.driven]);
        let reach = |gear: &Gear| (gear.tip_radius.powi(2) - gear.base_radius.powi(2)).sqrt();
        let sum = a.base_radius + b.base_radius;
        let (sin, cos) = mesh.centre_line_angle.sin_cos();
        let tangent = ((mesh.centre_distance - sum) * (mesh.centre_distance + sum)).sqrt();
        Self {
            base_radius: [a.base_radius, b.base_radius],
            tip_reach: [reach(a), reach(b)],
            base_pitch: a.base_pitch(),
            base_thickness: 2.0 * a.base_radius * a.half_angle(),
            sum,
            distance: mesh.centre_distance,
            tangent,
            pressure_angle: tangent.atan2(sum),
            angle: mesh.centre_line_angle,
            direction: [cos, sin],
        }
    }

    /// `relative_displacement`, the displacement u_b − u_a, along and across the line of centres at rest.
    #[inline(always)]
    fn along_and_across(&self, relative_displacement: [f64; 2]) -> (f64, f64) {
        let [cos, sin] = self.direction;
        (
            cos * relative_displacement[0] + sin * relative_displacement[1],
            cos * relative_displacement[1] - sin * relative_displacement[0],
        )
    }

    /// The line of action of the centres at rest.
    pub fn line_at_rest(&self, sigma: f64) -> LineOfAction {
        let Self { direction, distance, tangent, .. } = *self;
        self.line(sigma, &CentreGeometry { direction, distance, tangent, turned: 0.0, steeper: 0.0, longer: 0.0 })
    }

    /// Distance of the centres, and the tangent length with its change from rest.
    #[inline(always)]
    fn lengths(&self, relative_displacement: [f64; 2]) -> Result<(f64, f64, f64), Overlap> {
        let (along, _) = self.along_and_across(relative_displacement);
        // C² − C₀²
        let growth = 2.0 * self.distance * along
            + relative_displacement[0] * relative_displacement[0]
            + relative_displacement[1] * relative_displacement[1];
        let square = self.tangent * self.tangent + growth;
        // A comparison that NaN passes: a run that diverged is not one whose base circles overlap.
        if square <= 0.0 {
            let distance = (self.distance * self.distance + growth).max(0.0).sqrt();
            return Err(Overlap { distance, base_circles: self.sum });
        }
        let tangent = square.sqrt();
        Ok(((self.distance * self.distance + growth).sqrt(), tangent, growth / (tangent + self.tangent)))
    }

    /// The line of action for centres that have moved `relative_displacement` = u_b − u_a; `sigma` is the sign of the driver's spin.
    ///
    /// # Errors
    /// [`Overlap`] of the base circles.
    pub fn line_of_action(&self, sigma: f64, relative_displacement: [f64; 2]) -> Result<LineOfAction, Overlap> {
        Ok(self.line(sigma, &self.centre_geometry(relative_displacement)?))
    }

    /// How the centres lie that have moved `relative_displacement`.
    ///
    /// # Errors
    /// [`Overlap`] of the base circles.
    #[inline(always)]
    pub(super) fn centre_geometry(&self, relative_displacement: [f64; 2]) -> Result<CentreGeometry, Overlap> {
        let (along, tangent_direction) = self.along_and_across(relative_displacement);
        let (distance, tangent, stretched) = self.lengths(relative_displacement)?;
        let turned = angle(tangent_direction, self.distance + along);
        // inv α − inv α₀ = (t − t₀)/S − [atan(t/S) − atan(t₀/S)]
        let steeper = angle(self.sum * stretched, self.sum * self.sum + tangent * self.tangent);
        let [cos, sin] = self.direction;
        let direction =
            [self.distance * cos + relative_displacement[0], self.distance * sin + relative_displacement[1]]
                .map(|c| c / distance);
        Ok(CentreGeometry { direction, distance, tangent, turned, steeper, longer: stretched - self.sum * steeper })
    }

    /// The line of action of centres that lie so.
    #[inline(always)]
    pub(super) fn line(&self, sigma: f64, centre_geometry: &CentreGeometry) -> LineOfAction {
        let CentreGeometry { direction: [y, z], distance, tangent, turned, steeper, longer } = *centre_geometry;
        let (cos_alpha, sin_alpha) = (self.sum / distance, tangent / distance);
        LineOfAction {
            deflection: -sigma * self.sum * turned - longer,
            normal: [sin_alpha * y - sigma * cos_alpha * z, sin_alpha * z + sigma * cos_alpha * y],
            tangent_direction: [cos_alpha * y + sigma * sin_alpha * z, cos_alpha * z - sigma * sin_alpha * y],
            tangent,
            turned,
            steeper,
        }
    }

    /// Pressure angle, distance, angle and contact ratio for centres that have moved `relative_displacement`.
    ///
    /// # Errors
    /// [`Overlap`] of the base circles.
    pub fn centres(&self, relative_displacement: [f64; 2]) -> Result<Centres, Overlap> {
        let (along, tangent_direction) = self.along_and_across(relative_displacement);
        let (distance, tangent, _) = self.lengths(relative_displacement)?;
        Ok(Centres {
            pressure_angle: tangent.atan2(self.sum),
            distance,
            angle: self.angle + tangent_direction.atan2(self.distance + along),
            contact_ratio: (self.tip_reach[0] + self.tip_reach[1] - tangent) / self.base_pitch,
        })
    }

    /// The same for centres whose base circles overlap: these have neither pressure angle nor contact ratio, which are
    /// then not numbers.
    pub(super) fn overlapping_centres(&self, relative_displacement: [f64; 2], overlap: &Overlap) -> Centres {
        let (along, tangent_direction) = self.along_and_across(relative_displacement);
        Centres {
            pressure_angle: f64::NAN,
            distance: overlap.distance,
            angle: self.angle + tangent_direction.atan2(self.distance + along),
            contact_ratio: f64::NAN,
        }
    }

    /// The path of contact where the line of action between the base circles is `tangent` long: s at its ends.
    pub fn path(&self, tangent: f64) -> [f64; 2] {
        [tangent - self.tip_reach[1], self.tip_reach[0]]
    }

    /// The path of contact of the centres at rest.
    pub fn path_at_rest(&self) -> [f64; 2] {
        self.path(self.tangent)
    }

    /// C₀ sin α₀, m.
    pub fn tangent_at_rest(&self) -> f64 {
        self.tangent
    }

    /// s = r_a[σ(ϑ_a − γ) + α] of pair 0 for a driver that has turned to ϑ_a (spin, and twist if it counts).
    #[inline(always)]
    pub fn position(&self, sigma: f64, turned: f64, centres_angle: f64, pressure_angle: f64) -> f64 {
        self.base_radius[0] * (sigma * (turned - centres_angle) + pressure_angle)
    }

    /// α₀, rad.
    pub fn pressure_angle_at_rest(&self) -> f64 {
        self.pressure_angle
    }

    /// ψ, rad.
    pub fn angle_at_rest(&self) -> f64 {
        self.angle
    }

    /// S, m.
    pub fn base_circles(&self) -> f64 {
        self.sum
    }
}

/// The angle of (x, y). Centres wander by little, where six terms of the series are all its digits.
#[inline(always)]
fn angle(y: f64, x: f64) -> f64 {
    const SERIES: [f64; 5] = [1.0 / 11.0, 1.0 / 9.0, 1.0 / 7.0, 1.0 / 5.0, 1.0 / 3.0];
    let slope = y / x;
    let square = slope * slope;
    if x > 0.0 && square < 1e-3 {
        slope - slope * square * SERIES.iter().fold(0.0, |rest, term| term - square * rest)
    } else {
        y.atan2(x)
    }
}

#[cfg(test)]
mod tests {
    use super::angle;

    #[test]
    fn small_angles_are_those_of_the_library() {
        for power in -20..1 {
            for digits in [1.0, 2.37, 3.16, 3.17, 9.99] {
                for (y, x) in [(1.0, 0.3), (-1.0, 7.0), (1.0, -2.0)] {
                    let y: f64 = y * digits * 10.0_f64.powi(power);
                    let exact = y.atan2(x);
                    // Round-off of the quotient and of the last sum.
                    assert!((angle(y, x) - exact).abs() <= 2.0 * f64::EPSILON * exact.abs(), "{y} {x}");
                }
            }
        }
        assert!(angle(0.0, 1.0) == 0.0 && angle(f64::NAN, 1.0).is_nan());
    }
}
