//! Timoshenko beam element with two nodes and a solid or hollow circular section (Przemieniecki 1968; Nelson 1980).
//!
//! The shape functions are the exact static solutions of the beam. A circular section has the same stiffness in both
//! planes, so one set of matrices over (u₁, φ₁, u₂, φ₂) applies to the xy plane, (u, φ) = (v, Γ), and to the xz plane,
//! (u, φ) = (w, −B). With the complex displacements u = v + iw and φ = Γ − iB the element is
//!
//! ```text
//! M ü − iΩ·G u̇ + K u = 0,    G = 2R,
//! ```
//!
//! where R is the rotary part of M and Ω the spin about x. The gyroscopic term couples the two planes. Forward whirl
//! for Ω > 0 is u ~ e^{iωt} with ω > 0.

use std::f64::consts::PI;

use nalgebra::{Matrix2, Matrix4, Vector4};

use super::{Bending, Rod};
use crate::scene::{Element, Material};

/// Matrices of one shaft element. Rows and columns of bending are (u₁, φ₁, u₂, φ₂), those of torsion
/// (θ₁, θ₂), and along the axis the axial displacements of both ends.
#[derive(Clone, Copy, Debug)]
pub struct Beam {
    /// Mass matrix ρA∫NᵥᵀNᵥ dx + R with rotary inertia R; entries in kg, kg m and kg m².
    pub mass: Matrix4<f64>,
    /// Gyroscopic matrix G = 2R with R = ρI∫N_θᵀN_θ dx, per unit spin; entries in kg, kg m and kg m².
    pub gyroscopic: Matrix4<f64>,
    /// Stiffness matrix of bending and shear; entries in N/m, N and N m.
    pub stiffness: Matrix4<f64>,
    /// Bending stiffness in terms of strains.
    pub bending: Bending,
    /// Matrices of torsion, in kg m² and N m/rad.
    pub torsion: RodMatrices,
    /// Matrices along the axis, in kg and N/m.
    pub axial: RodMatrices,
}

/// Matrices of an element in torsion or along its axis, over the values at both ends. The linear shape functions are the
/// exact static solutions.
#[derive(Clone, Copy, Debug)]
pub struct RodMatrices {
    /// Mass matrix.
    pub mass: Matrix2<f64>,
    /// Stiffness matrix.
    pub stiffness: Matrix2<f64>,
    /// Stiffness in terms of strains.
    pub rod: Rod,
}

impl RodMatrices {
    /// Matrices of an element of length `l`, m, with this inertia per unit length and this rigidity.
    fn new(inertia: f64, rigidity: f64, l: f64) -> Self {
        Self {
            mass: Matrix2::new(2.0, 1.0, 1.0, 2.0) * (inertia * l / 6.0),
            stiffness: Matrix2::new(1.0, -1.0, -1.0, 1.0) * (rigidity / l),
            rod: Rod { stiffness: rigidity / l },
        }
    }
}

/// Shear coefficient κ of a hollow circular section with the ratio of radii m = rᵢ/rₒ (Cowper 1966).
pub fn shear_coefficient(poisson_ratio: f64, radii_ratio: f64) -> f64 {
    let square = radii_ratio * radii_ratio;
    let sum = (1.0 + square) * (1.0 + square);
    6.0 * (1.0 + poisson_ratio) * sum / ((7.0 + 6.0 * poisson_ratio) * sum + (20.0 + 12.0 * poisson_ratio) * square)
}

/// Flexural rigidity EI of a section, N m².
pub fn flexural_rigidity(element: &Element, material: &Material) -> f64 {
    Section::new(element, material, false).flexural
}

/// Deflection, m, at ξ = x/l of an element under its own inertia at a uniform acceleration of 1 m/s², between ends with
/// the static displacements (u₁, φ₁, u₂, φ₂) = `ends`: that of the ends, and that of a clamped beam,
/// w x²(l − x)²/(24EI) + w x(l − x)/(2κGA).
pub fn deflection(element: &Element, material: &Material, shear: bool, ends: Vector4<f64>, xi: f64) -> f64 {
    let section = Section::new(element, material, shear);
    let (l, between) = (element.length, element.length * element.length * xi * (1.0 - xi));
    let sheared = if shear { section.mass * between / (2.0 * section.shear) } else { 0.0 };
    let bent = section.mass * between * between / (24.0 * section.flexural);
    displacement(xi, l, section.phi).dot(&ends) + bent + sheared
}

/// Nodes in [0, 1] and weights of the four-point Gauss rule, to the last bit: round-off of [`crate::numerics::gauss`] would make the
/// matrices of an element unsymmetric about its middle. The rule is exact for the products of shape functions, whose
/// degree is at most six.
const GAUSS_RULE: [(f64, f64); 4] = [
    (0.069_431_844_202_973_71, 0.173_927_422_568_726_93),
    (0.330_009_478_207_571_87, 0.326_072_577_431_273_07),
    (0.669_990_521_792_428_1, 0.326_072_577_431_273_07),
    (0.930_568_155_797_026_3, 0.173_927_422_568_726_93),
];

/// Section properties of an element.
#[derive(Clone, Copy, Debug)]
pub(super) struct Section {
    /// Mass per unit length ρA, kg/m.
    pub mass: f64,
    /// Diametral moment of inertia per unit length ρI, kg m.
    pub rotary: f64,
    /// Polar moment of inertia per unit length ρJ, kg m.
    pub polar_mass: f64,
    /// Flexural rigidity EI, N m².
    pub flexural: f64,
    /// Shear rigidity κGA, N; zero without shear deformation.
    pub shear: f64,
    /// Torsional rigidity GJ, N m².
    pub torsional: f64,
    /// Axial rigidity EA, N.
    pub axial: f64,
    /// Shear parameter Φ = 12EI/(κGAl²) of an element of length l; zero without shear deformation.
    pub phi: f64,
}

impl Section {
    /// Properties of `element`; without `shear` the shear deformation is neglected.
    pub fn new(element: &Element, material: &Material, shear: bool) -> Self {
        let Element { length: l, outer_radius, inner_radius } = *element;
        let Material { youngs_modulus: e, shear_modulus: g, poisson_ratio, density } = *material;
        let area = PI * (outer_radius * outer_radius - inner_radius * inner_radius);
        let second_moment = area * (outer_radius * outer_radius + inner_radius * inner_radius) / 4.0;
        let polar = 2.0 * second_moment;
        let (shear, phi) = if shear {
            let rigidity = shear_coefficient(poisson_ratio, inner_radius / outer_radius) * g * area;
            (rigidity, 12.0 * e * second_moment / (rigidity * l * l))
        } else {
            (0.0, 0.0)
        };
        Self {
            mass: density * area,
            rotary: density * second_moment,
            polar_mass: density * polar,
            flexural: e * second_moment,
            shear,
            torsional: g * polar,
            axial: e * area,
            phi,
        }
    }
}

impl Beam {
    /// Matrices of `element`; without `shear` the shear deformation is neglected.
    pub fn new(element: &Element, material: &Material, shear: bool) -> Self {
        let (l, section) = (element.length, Section::new(element, material, shear));
        let phi = section.phi;
        let translation = integral(l, |xi| displacement(xi, l, phi)) * section.mass;
        let rotary = integral(l, |xi| rotation(xi, l, phi)) * section.rotary;
        let bending = section.flexural / (l * l * l * (1.0 + phi));
        let (a, b, c, d) = (12.0, 6.0 * l, (4.0 + phi) * l * l, (2.0 - phi) * l * l);
        #[rustfmt::skip]
        let stiffness = bending * Matrix4::new(
             a,  b, -a,  b,
             b,  c, -b,  d,
            -a, -b,  a, -b,
             b,  d, -b,  c,
        );
        Self {
            mass: translation + rotary,
            gyroscopic: rotary * 2.0,
            stiffness,
            bending: Bending { half_length: l / 2.0, flexural: section.flexural / l, transverse: 12.0 * bending },
            torsion: RodMatrices::new(section.polar_mass, section.torsional, l),
            axial: RodMatrices::new(section.mass, section.axial, l),
        }
    }
}

/// Shape functions Nᵥ of the displacement at ξ = x/l; Φ = 12EI/(κGAl²) = `phi` is the shear parameter.
pub(super) fn displacement(xi: f64, l: f64, phi: f64) -> Vector4<f64> {
    let (square, cube) = (xi * xi, xi * xi * xi);
    Vector4::new(
        1.0 - 3.0 * square + 2.0 * cube + (1.0 - xi) * phi,
        l * (xi - 2.0 * square + cube + (xi - square) * phi / 2.0),
        3.0 * square - 2.0 * cube + xi * phi,
        l * (-square + cube - (xi - square) * phi / 2.0),
    ) / (1.0 + phi)
}

/// Shape functions N_θ of the rotation of the section at ξ = x/l.
pub(super) fn rotation(xi: f64, l: f64, phi: f64) -> Vector4<f64> {
    let square = xi * xi;
    Vector4::new(
        6.0 / l * (square - xi),
        1.0 - 4.0 * xi + 3.0 * square + (1.0 - xi) * phi,
        6.0 / l * (xi - square),
        -2.0 * xi + 3.0 * square + xi * phi,
    ) / (1.0 + phi)
}

/// ∫NᵀN dx over an element of length `l`, m, for the shape functions N(ξ) = `shape`.
fn integral(l: f64, shape: impl Fn(f64) -> Vector4<f64>) -> Matrix4<f64> {
    GAUSS_RULE.iter().fold(Matrix4::zeros(), |sum, &(xi, weight)| {
        let shape = shape(xi);
        sum + shape * shape.transpose() * (weight * l)
    })
}
