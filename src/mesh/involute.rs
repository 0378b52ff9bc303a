//! Involute geometry of a gear pair, modelled as a crossed belt between the base circles, or an open one if a gear is
//! internal. The mesh deflection is the change of the belt length.
//!
//! With S = r_a + r_b, the vector c = C₀(cos ψ, sin ψ) + (u_b − u_a) between the centres, C = |c|, γ = arg c and
//! cos α = S/C:
//!
//! ```text
//! δ = σ[ r_a θ_a + r_b θ_b − S(γ − ψ) ] − S(inv α − inv α₀),        inv α = tan α − α
//! ```
//!
//! σ is the sign of the driver's spin. The gradient of δ with respect to u_a is the unit vector of the line of action,
//! n = σ cos α·(−sin γ, cos γ) + sin α·(cos γ, sin γ). With respect to u_b it is −n, and with respect to the twists it
//! is σr_a and σr_b. Angles are positive counter-clockwise, viewed from +x with y to the right and z up.
//!
//! A pair with an internal gear has the same equations with −r_b in place of r_b and −C sin α in place of C sin α: the driven
//! gear turns in the same direction, and the belt lies on one side of both centres. Where S and C sin α have different signs,
//! cos α and sin α above are those of arg(S + i C sin α). Here, `tangent` is the signed length C sin α.
//!
//! The differences γ − ψ and inv α − inv α₀ are computed directly, without subtracting two rounded numbers. A load of
//! 1e-9 N deflects a mesh by 1e-18 m, and this deflection keeps its full relative accuracy.

use super::contact_path::ContactPath;
use crate::scene::{Gear, Mesh, PairGeometry};

/// Geometry of a gear pair with the centres at rest.
#[derive(Clone, Debug)]
pub struct Involute {
    /// Base radii of driver and driven gear, m; the second is negative if one gear is internal.
    pub base_radius: [f64; 2],
    /// Lengths of the line of action.
    pair: PairGeometry,
    /// Base pitch of the driver, m.
    pub base_pitch: f64,
    /// Overlap b tan β_b of helical teeth along the path of contact, m.
    overlap: f64,
    /// Thickness of a tooth of the driver on its base circle, m: the arc between its drive flank and its back flank.
    pub base_thickness: f64,
    /// Sum S of the base radii, m, with their signs.
    sum: f64,
    /// Centre distance C₀ at rest, m.
    distance: f64,
    /// Length t₀ = C₀ sin α₀ of the line of action between the base circles at rest, m; negative if a gear is internal.
    tangent: f64,
    /// Angle arg(S + i t₀) at rest, rad: the operating pressure angle, unless a gear is internal.
    pressure_angle: f64,
    /// Angle of the drive flank of a tooth of the driver on its base circle at the time zero, rad.
    tooth_angle: f64,
    /// Angle ψ of the line of centres at rest, rad, with its cosine and sine.
    angle: f64,
    direction: [f64; 2],
}

/// Position of the gear centres at an instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Centres {
    /// Operating pressure angle α, rad.
    pub pressure_angle: f64,
    /// Centre distance C, m.
    pub distance: f64,
    /// Angle γ of the line of centres, rad. It is close to the given ψ and contains the same whole revolutions.
    pub angle: f64,
    /// Contact ratio ε; for helical teeth the total one, ε_α + ε_β.
    pub contact_ratio: f64,
    /// C sin α minus the larger √(tip radius² − base radius²) of both gears, m; of an internal gear its √(tip radius² − base
    /// radius²) minus C sin α. If it is negative, a tip reaches beyond the base circle of the other gear, where no involute exists
    /// (involute interference).
    pub involute_clearance: f64,
}

/// Lengths between the gear axes, m.
struct Lengths {
    /// Centre distance C.
    distance: f64,
    /// Length t of the line of action between the base circles.
    tangent: f64,
    /// t − t₀: its change from rest.
    stretched: f64,
}

/// Position of the gear centres, which the lines of action of both flanks share.
#[derive(Clone, Copy, Debug)]
pub(super) struct CentreGeometry {
    /// Unit vector along the line of centres.
    direction: [f64; 2],
    /// Centre distance C, m.
    distance: f64,
    /// Length C sin α of the line of action between the base circles, m, with its sign.
    tangent: f64,
    /// Rotation γ − ψ of the line of centres from rest, rad.
    rotation: f64,
    /// Change α − α₀ of the pressure angle from rest, rad.
    pressure_angle_change: f64,
    /// Change of the belt length due to the pressure angle, S(inv α − inv α₀), m.
    lengthening: f64,
}

/// The deflection and its derivatives with respect to the displacement of the driver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineOfAction {
    /// Contribution of the centre displacements to δ, −σS(γ − ψ) − S(inv α − inv α₀), m.
    pub deflection: f64,
    /// Unit vector n of the line of action, components (y, z).
    pub normal: [f64; 2],
    /// Unit vector m perpendicular to n, components (y, z); ∂n/∂(u_b − u_a) = m mᵀ / `tangent`.
    pub tangent_direction: [f64; 2],
    /// Length C sin α of the line of action between the base circles, m.
    pub tangent: f64,
    /// Rotation γ − ψ of the line of centres from rest, rad.
    pub rotation: f64,
    /// Change α − α₀ of the pressure angle from rest, rad.
    pub pressure_angle_change: f64,
}

/// The base circles overlap, or that of a gear lies within that of an internal gear: there is no line of action.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Overlap {
    /// Distance of the centres, m.
    pub distance: f64,
    /// Sum of the base radii, m; their difference if a gear is internal.
    pub base_circles: f64,
}

impl Involute {
    /// Creates the gear pair of a mesh.
    pub fn new(mesh: &Mesh, gears: &[Gear]) -> Self {
        let (a, b) = (&gears[mesh.driver], &gears[mesh.driven]);
        let pair = PairGeometry::of([a, b]);
        let sum = pair.base_circles();
        let (sin, cos) = mesh.centre_line_angle.sin_cos();
        let tangent = pair.tangent(mesh.centre_distance);
        Self {
            base_radius: pair.base_radius,
            pair,
            base_pitch: a.base_pitch(),
            overlap: a.overlap(b),
            base_thickness: 2.0 * a.base_radius * a.half_angle(),
            sum,
            distance: mesh.centre_distance,
            tangent,
            pressure_angle: tangent.atan2(sum),
            tooth_angle: mesh.tooth_angle,
            angle: mesh.centre_line_angle,
            direction: [cos, sin],
        }
    }

    /// Components of `relative_displacement` = u_b − u_a along and perpendicular to the line of centres at rest.
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
        self.line(
            sigma,
            &CentreGeometry {
                direction,
                distance,
                tangent,
                rotation: 0.0,
                pressure_angle_change: 0.0,
                lengthening: 0.0,
            },
        )
    }

    /// The lengths that follow from the displacement `relative_displacement` = u_b − u_a.
    ///
    /// # Errors
    /// [`Overlap`] of the base circles.
    #[inline(always)]
    fn lengths(&self, relative_displacement: [f64; 2]) -> Result<Lengths, Overlap> {
        let (along, _) = self.along_and_across(relative_displacement);
        // C² − C₀²
        let growth = 2.0 * self.distance * along
            + relative_displacement[0] * relative_displacement[0]
            + relative_displacement[1] * relative_displacement[1];
        let square = self.tangent * self.tangent + growth;
        // The comparison is false for NaN, so a diverged run does not report overlapping base circles.
        if square <= 0.0 {
            let distance = (self.distance * self.distance + growth).max(0.0).sqrt();
            return Err(Overlap { distance, base_circles: self.sum.abs() });
        }
        let tangent = square.sqrt().copysign(self.tangent);
        Ok(Lengths {
            distance: (self.distance * self.distance + growth).sqrt(),
            tangent,
            stretched: growth / (tangent + self.tangent),
        })
    }

    /// The line of action for the centre displacement `relative_displacement` = u_b − u_a; `sigma` is the sign of the
    /// driver's spin.
    ///
    /// # Errors
    /// [`Overlap`] of the base circles.
    pub fn line_of_action(&self, sigma: f64, relative_displacement: [f64; 2]) -> Result<LineOfAction, Overlap> {
        Ok(self.line(sigma, &self.centre_geometry(relative_displacement)?))
    }

    /// Position of the gear centres for the centre displacement `relative_displacement` = u_b − u_a.
    ///
    /// # Errors
    /// [`Overlap`] of the base circles.
    #[inline(always)]
    pub(super) fn centre_geometry(&self, relative_displacement: [f64; 2]) -> Result<CentreGeometry, Overlap> {
        let (along, tangent_direction) = self.along_and_across(relative_displacement);
        let Lengths { distance, tangent, stretched } = self.lengths(relative_displacement)?;
        let rotation = angle(tangent_direction, self.distance + along);
        // inv α − inv α₀ = (t − t₀)/S − [atan(t/S) − atan(t₀/S)]
        let pressure_angle_change = angle(self.sum * stretched, self.sum * self.sum + tangent * self.tangent);
        let [cos, sin] = self.direction;
        let direction =
            [self.distance * cos + relative_displacement[0], self.distance * sin + relative_displacement[1]]
                .map(|c| c / distance);
        Ok(CentreGeometry {
            direction,
            distance,
            tangent,
            rotation,
            pressure_angle_change,
            lengthening: stretched - self.sum * pressure_angle_change,
        })
    }

    /// The line of action for this position of the centres.
    #[inline(always)]
    pub(super) fn line(&self, sigma: f64, centre_geometry: &CentreGeometry) -> LineOfAction {
        let CentreGeometry { direction: [y, z], distance, tangent, rotation, pressure_angle_change, lengthening } =
            *centre_geometry;
        let (cos_alpha, sin_alpha) = (self.sum / distance, tangent / distance);
        LineOfAction {
            deflection: -sigma * self.sum * rotation - lengthening,
            normal: [sin_alpha * y - sigma * cos_alpha * z, sin_alpha * z + sigma * cos_alpha * y],
            tangent_direction: [cos_alpha * y + sigma * sin_alpha * z, cos_alpha * z - sigma * sin_alpha * y],
            tangent,
            rotation,
            pressure_angle_change,
        }
    }

    /// Pressure angle, distance, angle and contact ratio for the displacement `relative_displacement` = u_b − u_a.
    ///
    /// # Errors
    /// [`Overlap`] of the base circles.
    pub fn centres(&self, relative_displacement: [f64; 2]) -> Result<Centres, Overlap> {
        let (along, tangent_direction) = self.along_and_across(relative_displacement);
        let Lengths { distance, tangent, .. } = self.lengths(relative_displacement)?;
        let ContactPath { low, high, pitch, overlap, .. } = self.path(tangent);
        Ok(Centres {
            pressure_angle: (tangent / self.sum).abs().atan(),
            distance,
            angle: self.angle + tangent_direction.atan2(self.distance + along),
            contact_ratio: (high - low + overlap) / pitch,
            involute_clearance: tangent - self.pair.limiting_reach,
        })
    }

    /// Position of the gear centres if the base circles overlap. Pressure angle and contact ratio are then NaN.
    pub(super) fn overlapping_centres(&self, relative_displacement: [f64; 2], overlap: &Overlap) -> Centres {
        let (along, tangent_direction) = self.along_and_across(relative_displacement);
        Centres {
            pressure_angle: f64::NAN,
            distance: overlap.distance,
            angle: self.angle + tangent_direction.atan2(self.distance + along),
            contact_ratio: f64::NAN,
            involute_clearance: f64::NAN,
        }
    }

    /// The path of contact for a line of action of the length `tangent` between the base circles, with pair 0 at its
    /// origin.
    #[inline(always)]
    pub fn path(&self, tangent: f64) -> ContactPath {
        let ([low, high], limits) = (self.pair.path_of_contact(tangent), self.pair.limits(tangent));
        ContactPath { position: 0.0, tangent, low, high, limits, pitch: self.base_pitch, overlap: self.overlap }
    }

    /// The path of contact of the centres at rest.
    pub fn path_at_rest(&self) -> ContactPath {
        self.path(self.tangent)
    }

    /// Position s = r_a[σ(ϑ_a + τ − γ) + α] of pair 0, m, at the driver angle ϑ_a (spin angle, plus twist if included), with the
    /// angle τ of its tooth at the time zero.
    #[inline(always)]
    pub fn position(&self, sigma: f64, driver_angle: f64, centres_angle: f64, pressure_angle: f64) -> f64 {
        self.base_radius[0] * (sigma * (driver_angle + self.tooth_angle - centres_angle) + pressure_angle)
    }

    /// Angle arg(S + i C sin α) at rest, rad: the operating pressure angle, unless a gear is internal.
    pub fn pressure_angle_at_rest(&self) -> f64 {
        self.pressure_angle
    }

    /// Angle ψ of the line of centres at rest, rad.
    pub fn angle_at_rest(&self) -> f64 {
        self.angle
    }

    /// Vector from the centre of the driver to that of the driven gear at rest, m.
    pub fn centres_at_rest(&self) -> [f64; 2] {
        self.direction.map(|component| self.distance * component)
    }

    /// Sum S of the base radii, m; their difference if a gear is internal.
    pub fn base_circles(&self) -> f64 {
        self.sum
    }
}

/// Angle of the vector (x, y), rad. For small centre displacements, six terms of the series give full precision.
#[inline(always)]
fn angle(y: f64, x: f64) -> f64 {
    const ARCTANGENT_SERIES: [f64; 5] = [1.0 / 11.0, 1.0 / 9.0, 1.0 / 7.0, 1.0 / 5.0, 1.0 / 3.0];
    let slope = y / x;
    let square = slope * slope;
    if x > 0.0 && square < 1e-3 {
        slope - slope * square * ARCTANGENT_SERIES.iter().fold(0.0, |rest, term| term - square * rest)
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
