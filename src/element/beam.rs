//! Timoshenko beam element with two nodes and a solid or hollow circular section, cylindrical or conical, with sleeves around
//! it (Przemieniecki 1968; Nelson 1980).
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

use nalgebra::{Matrix2, Matrix4, Vector2, Vector4};

use super::profile::{Profile, Section};
use super::{Bending, Rod};
use crate::scene::Element;

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

/// Matrices of an element in torsion or along its axis, over the values at both ends. The shape functions are the exact
/// static solutions, which are linear in a cylinder.
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
    fn new(profile: &Profile<'_>, l: f64, inertia: fn(&Section) -> f64, rigidity: fn(&Section) -> f64) -> Self {
        let mass = match profile.cylinder() {
            Some((section, _)) => Matrix2::new(2.0, 1.0, 1.0, 2.0) * (inertia(&section) * l / 6.0),
            None => profile.integral(Matrix2::zeros(), |xi, dx| {
                let shape = Vector2::from(profile.rod(xi, rigidity).0);
                shape * shape.transpose() * (inertia(&profile.section(xi)) * dx)
            }),
        };
        let (_, stiffness) = profile.rod(1.0, rigidity);
        Self { mass, stiffness: Matrix2::new(1.0, -1.0, -1.0, 1.0) * stiffness, rod: Rod { stiffness } }
    }
}

/// Deflection, m, at ξ = x/l of an element under its own inertia at a uniform acceleration of 1 m/s², between ends with
/// the static displacements (u₁, φ₁, u₂, φ₂) = `ends`: that of the ends, and that of a clamped beam,
/// w x²(l − x)²/(24EI) + w x(l − x)/(2κGA), in a cone with the section in its middle.
pub fn deflection(element: &Element, shear: bool, ends: Vector4<f64>, xi: f64) -> f64 {
    let profile = Profile::new(element, shear);
    let section = profile.section(0.5);
    let between = element.length * element.length * xi * (1.0 - xi);
    let sheared = if shear { section.mass * between / (2.0 * section.shear) } else { 0.0 };
    let bent = section.mass * between * between / (24.0 * section.flexural);
    profile.displacement(xi).dot(&ends) + bent + sheared
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

impl Beam {
    /// Matrices of `element`; without `shear` the shear deformation is neglected.
    pub fn new(element: &Element, shear: bool) -> Self {
        let (l, profile) = (element.length, Profile::new(element, shear));
        let [flexural, transverse, centre] = profile.strain_stiffness();
        let [displaced, rotated] = match profile.cylinder() {
            Some((section, _)) => [
                integral(l, |xi| profile.displacement(xi)) * section.mass,
                integral(l, |xi| profile.rotation(xi)) * section.rotary,
            ],
            None => {
                let square = |shape: Vector4<f64>, factor: f64| shape * shape.transpose() * factor;
                [
                    profile.integral(Matrix4::zeros(), |xi, dx| {
                        square(profile.displacement(xi), profile.section(xi).mass * dx)
                    }),
                    profile.integral(Matrix4::zeros(), |xi, dx| {
                        square(profile.rotation(xi), profile.section(xi).rotary * dx)
                    }),
                ]
            }
        };
        let stiffness = match profile.cylinder() {
            Some((section, phi)) => cylinder_stiffness(section.flexural / (l * l * l * (1.0 + phi)), l, phi),
            None => {
                let curvature = Vector4::new(0.0, -1.0, 0.0, 1.0);
                let deflection = Vector4::new(-1.0, -centre, 1.0, centre - l);
                curvature * curvature.transpose() * flexural + deflection * deflection.transpose() * transverse
            }
        };
        Self {
            mass: displaced + rotated,
            gyroscopic: rotated * 2.0,
            stiffness,
            bending: Bending { half_length: l / 2.0, flexural, transverse },
            torsion: RodMatrices::new(&profile, l, |section| section.polar_mass, |section| section.torsional),
            axial: RodMatrices::new(&profile, l, |section| section.mass, |section| section.axial),
        }
    }

    /// Stiffness matrix of bending that the strains of [`Bending`] do not contain: that of a cone, whose elastic centre is not
    /// in its middle.
    pub fn stiffness_beyond_strains(&self) -> Matrix4<f64> {
        let Bending { half_length, flexural, transverse } = self.bending;
        let curvature = Vector4::new(0.0, -1.0, 0.0, 1.0);
        let deflection = Vector4::new(-1.0, -half_length, 1.0, -half_length);
        self.stiffness - curvature * curvature.transpose() * flexural - deflection * deflection.transpose() * transverse
    }
}

/// Stiffness matrix of a cylinder of the length `l`, m; `bending` is EI/(l³(1 + Φ)), N/m, and Φ = `phi`.
fn cylinder_stiffness(bending: f64, l: f64, phi: f64) -> Matrix4<f64> {
    let (a, b, c, d) = (12.0, 6.0 * l, (4.0 + phi) * l * l, (2.0 - phi) * l * l);
    #[rustfmt::skip]
    let stiffness = Matrix4::new(
         a,  b, -a,  b,
         b,  c, -b,  d,
        -a, -b,  a, -b,
         b,  d, -b,  c,
    );
    stiffness * bending
}

/// ∫NᵀN dx over an element of length `l`, m, for the shape functions N(ξ) = `shape`.
fn integral(l: f64, shape: impl Fn(f64) -> Vector4<f64>) -> Matrix4<f64> {
    GAUSS_RULE.iter().fold(Matrix4::zeros(), |sum, &(xi, weight)| {
        let shape = shape(xi);
        sum + shape * shape.transpose() * (weight * l)
    })
}
