//! Stiffness K of one rolling element between two raceways of bearing steel: Q = K δ^p.

use std::f64::consts::PI;

use super::STEEL_POISSON_RATIO;

/// Exponent p of a point contact.
pub const POINT_CONTACT: f64 = 1.5;
/// Exponent p of a line contact (Palmgren).
pub const LINE_CONTACT: f64 = 10.0 / 9.0;

/// Young's modulus of bearing steel, Pa.
const BEARING_STEEL_YOUNGS_MODULUS: f64 = 206e9;

/// Stiffness of a ball of the diameter d, m, between both races, N/m^1.5; `ratio` is d/D with the pitch diameter D,
/// `groove` the groove radii of the inner and the outer race over d.
///
/// The stiffness of one contact is that of Brewe and Hamrock (J. Lubr. Technol. 99, 1977; Hamrock, Schmid and Jacobson,
/// Fundamentals of Fluid Film Lubrication, 2nd ed., 2004), whose formulas for the ellipticity and the elliptic integrals
/// differ from the exact solution of Hertz by up to 3 % for grooves of 0.515 to 0.55 ball diameters, and by 9 % for a ball on
/// a plane.
pub fn ball_stiffness(diameter: f64, ratio: f64, contact_angle: f64, groove: [f64; 2]) -> f64 {
    let gamma = ratio * contact_angle.cos();
    let contact = |side: f64, groove: f64| {
        // Radii of relative curvature along and across the rolling direction, m; the outer race is concave along it.
        let along = diameter * (1.0 + side * gamma) / 2.0;
        let across = diameter / (2.0 - 1.0 / groove);
        let curvature = 1.0 / along + 1.0 / across;
        let quotient = across / along;
        let ellipticity = 1.0339 * quotient.powf(0.636);
        let second = 1.0003 + 0.5968 / quotient;
        let first = 1.5277 + 0.6023 * quotient.ln();
        let modulus = BEARING_STEEL_YOUNGS_MODULUS / (1.0 - STEEL_POISSON_RATIO * STEEL_POISSON_RATIO);
        PI * ellipticity * modulus * (second / (4.5 * curvature * first.powi(3))).sqrt()
    };
    in_series([contact(-1.0, groove[0]), contact(1.0, groove[1])], POINT_CONTACT)
}

/// Stiffness of a roller of the effective length l, m, between both races, N/m^(10/9).
///
/// Palmgren (Grundlagen der Wälzlagertechnik, 1959): each contact of steel deflects by δ = 3.84e-5 Q^0.9/l^0.8, in mm and N.
pub fn roller_stiffness(length: f64) -> f64 {
    let deflection = 3.84e-8 / (1e3 * length).powf(0.8);
    let contact = deflection.powf(-LINE_CONTACT);
    in_series([contact; 2], LINE_CONTACT)
}

/// Stiffness of two contacts that carry the same force.
fn in_series(contacts: [f64; 2], exponent: f64) -> f64 {
    contacts.map(|stiffness| stiffness.powf(-1.0 / exponent)).iter().sum::<f64>().powf(-exponent)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ball_between_two_planes_has_the_stiffness_of_hertz() {
        // A ball on a plane: K = (4/3) E* √R with E* = E/(2(1 − ν²)) for equal materials. Grooves of a large radius, and a
        // pitch circle of a large diameter, are planes.
        let modulus = BEARING_STEEL_YOUNGS_MODULUS / (1.0 - STEEL_POISSON_RATIO * STEEL_POISSON_RATIO) / 2.0;
        let one = 4.0 / 3.0 * modulus * 0.005_f64.sqrt();
        let wanted = in_series([one; 2], POINT_CONTACT);
        let found = ball_stiffness(0.01, 1e-9, 0.0, [1e9, 1e9]);
        // The approximations of Brewe and Hamrock are least accurate for a circular contact.
        assert!((found / wanted - 1.0).abs() < 0.09, "{found} {wanted}");
    }

    #[test]
    fn a_deep_groove_ball_bearing_has_the_stiffness_of_hertz() {
        // 209 bearing: D_w 12.7 mm, D_m 65 mm, f = 0.52. The exact elliptic integrals give 1.16563e10 N/m^1.5
        // (`tests/python/reference/rolling.py`).
        let found = ball_stiffness(0.0127, 12.7 / 65.0, 0.0, [0.52, 0.52]);
        // The approximations of Brewe and Hamrock.
        assert!((found / 1.16563e10 - 1.0).abs() < 0.03, "{found}");
    }
}
