//! Section properties over an element, and its static shape functions.
//!
//! Layers (the shaft and its sleeves) have the same displacement and rotation, so that rigidities and inertias add. The
//! shape functions are the static solutions of the element. A cylinder has them in closed form; in a cone they follow from
//! integrals of the flexibilities. With M(x) = M_c + V(x − x_c), the shear force −V and the elastic centre
//! x_c = ∫x/EI dx / ∫1/EI dx,
//!
//! ```text
//! φ' = M/EI,   u' = φ − V/κGA,   M_c = (φ₂ − φ₁)/∫1/EI dx,
//! V = −(u₂ − u₁ − x_c φ₁ − (l − x_c) φ₂)/(∫(x − x_c)²/EI dx + ∫1/κGA dx)
//! ```

use std::f64::consts::PI;

use nalgebra::Vector4;

use crate::numerics::gauss;
use crate::scene::{Element, Material, Tube};

/// Points of a Gauss rule over an element. The flexibility 1/EI of a solid cone whose diameters have the ratio 4 is integrated to
/// 1e-12, and the product of a shape function of the largest degree with a sine over one radian to round-off.
pub const GAUSS_POINTS: usize = 16;

/// Shear coefficient κ of a hollow circular section with the ratio of radii m = rᵢ/rₒ (Cowper 1966).
pub fn shear_coefficient(poisson_ratio: f64, radii_ratio: f64) -> f64 {
    let square = radii_ratio * radii_ratio;
    let sum = (1.0 + square) * (1.0 + square);
    6.0 * (1.0 + poisson_ratio) * sum / ((7.0 + 6.0 * poisson_ratio) * sum + (20.0 + 12.0 * poisson_ratio) * square)
}

/// Properties of a section.
#[derive(Clone, Copy, Debug)]
pub struct Section {
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
}

impl Section {
    /// Properties of an element at ξ = x/l; without `shear` the shear deformation is neglected.
    pub fn at(element: &Element, shear: bool, xi: f64) -> Self {
        let body = Self::of_tube(&element.body, shear, xi);
        element.sleeves.iter().fold(body, |sum, sleeve| sum.plus(Self::of_tube(sleeve, shear, xi)))
    }

    fn of_tube(tube: &Tube, shear: bool, xi: f64) -> Self {
        let Material { youngs_modulus: e, shear_modulus: g, poisson_ratio, density } = tube.material;
        let [outer_radius, inner_radius] = tube.radii(xi);
        let area = PI * (outer_radius * outer_radius - inner_radius * inner_radius);
        let second_moment = area * (outer_radius * outer_radius + inner_radius * inner_radius) / 4.0;
        let polar = 2.0 * second_moment;
        let shear_rigidity =
            if shear { shear_coefficient(poisson_ratio, inner_radius / outer_radius) * g * area } else { 0.0 };
        Self {
            mass: density * area,
            rotary: density * second_moment,
            polar_mass: density * polar,
            flexural: e * second_moment * tube.stiffness_fraction,
            shear: shear_rigidity * tube.stiffness_fraction,
            torsional: g * polar * tube.stiffness_fraction,
            axial: e * area * tube.stiffness_fraction,
        }
    }

    fn plus(self, other: Self) -> Self {
        Self {
            mass: self.mass + other.mass,
            rotary: self.rotary + other.rotary,
            polar_mass: self.polar_mass + other.polar_mass,
            flexural: self.flexural + other.flexural,
            shear: self.shear + other.shear,
            torsional: self.torsional + other.torsional,
            axial: self.axial + other.axial,
        }
    }
}

/// Section properties and static shape functions of an element.
pub(super) struct Profile<'a> {
    element: &'a Element,
    shear: bool,
    shape: Shape,
}

enum Shape {
    /// A cylinder.
    Cylinder {
        /// Properties, the same at all ξ.
        section: Section,
        /// Shear parameter Φ = 12EI/(κGAl²); zero without shear deformation.
        phi: f64,
    },
    /// A cone.
    Cone(Cone),
}

/// Integrals of the flexibilities of a cone.
struct Cone {
    /// Abscissae on (0, 1) and weights of a Gauss rule.
    rule: Vec<(f64, f64)>,
    /// Distance x_c of the elastic centre from the begin, m.
    centre: f64,
    /// ∫1/EI dx, 1/(N m).
    flexural: f64,
    /// ∫(x − x_c)²/EI dx + ∫1/κGA dx, m/N.
    transverse: f64,
}

impl<'a> Profile<'a> {
    /// The profile of an element; without `shear` the shear deformation is neglected.
    pub fn new(element: &'a Element, shear: bool) -> Self {
        let l = element.length;
        if element.body.is_cylinder() {
            let section = Section::at(element, shear, 0.0);
            let phi = if shear { 12.0 * section.flexural / (section.shear * l * l) } else { 0.0 };
            return Self { element, shear, shape: Shape::Cylinder { section, phi } };
        }
        let rule = gauss(GAUSS_POINTS);
        let integral = |of: &dyn Fn(f64, Section) -> f64| -> f64 {
            rule.iter().map(|(xi, weight)| weight * l * of(xi * l, Section::at(element, shear, *xi))).sum()
        };
        let flexural = integral(&|_, section| 1.0 / section.flexural);
        let centre = integral(&|x, section| x / section.flexural) / flexural;
        let transverse = integral(&|x, section| {
            (x - centre).powi(2) / section.flexural + if shear { 1.0 / section.shear } else { 0.0 }
        });
        Self { element, shear, shape: Shape::Cone(Cone { rule, centre, flexural, transverse }) }
    }

    /// Properties at ξ = x/l.
    pub fn section(&self, xi: f64) -> Section {
        match &self.shape {
            Shape::Cylinder { section, .. } => *section,
            Shape::Cone(_) => Section::at(self.element, self.shear, xi),
        }
    }

    /// The properties that a cylinder has everywhere; none for a cone.
    pub fn cylinder(&self) -> Option<(Section, f64)> {
        match self.shape {
            Shape::Cylinder { section, phi } => Some((section, phi)),
            Shape::Cone(_) => None,
        }
    }

    /// ∫`of` dx over the element, in the sections at ξ.
    pub fn integral<T: std::ops::Add<Output = T>>(&self, zero: T, of: impl Fn(f64, f64) -> T) -> T {
        let rule = gauss(GAUSS_POINTS);
        rule.iter().fold(zero, |sum, (xi, weight)| sum + of(*xi, weight * self.element.length))
    }

    /// Number of Gauss points that a cone needs beside those of the polynomials.
    pub fn further_points(&self) -> usize {
        if self.cylinder().is_some() { 0 } else { GAUSS_POINTS / 2 }
    }

    /// Stiffness over the strains: EI/l for the change φ₂ − φ₁, N m, the transverse stiffness, N/m, and the distance of the
    /// elastic centre from the begin, m.
    pub fn strain_stiffness(&self) -> [f64; 3] {
        let l = self.element.length;
        match &self.shape {
            Shape::Cylinder { section, phi } => {
                let bending = section.flexural / (l * l * l * (1.0 + phi));
                [section.flexural / l, 12.0 * bending, l / 2.0]
            }
            Shape::Cone(cone) => [1.0 / cone.flexural, 1.0 / cone.transverse, cone.centre],
        }
    }

    /// Shape functions Nᵥ of the displacement at ξ = x/l.
    pub fn displacement(&self, xi: f64) -> Vector4<f64> {
        let l = self.element.length;
        match &self.shape {
            Shape::Cylinder { phi, .. } => displacement(xi, l, *phi),
            Shape::Cone(cone) => {
                let x = xi * l;
                let [mut moment, mut shear] = [0.0; 2];
                for (share, weight) in &cone.rule {
                    let (s, ds) = (share * x, weight * x);
                    let section = Section::at(self.element, self.shear, share * xi);
                    moment += (x - s) / section.flexural * ds;
                    shear += (x - s) * (s - cone.centre) / section.flexural * ds;
                    shear -= if self.shear { ds / section.shear } else { 0.0 };
                }
                let [of_moment, of_shear] = cone.loads(l);
                Vector4::new(1.0, x, 0.0, 0.0) + of_moment * moment + of_shear * shear
            }
        }
    }

    /// Shape functions N_θ of the rotation of the section at ξ = x/l.
    pub fn rotation(&self, xi: f64) -> Vector4<f64> {
        let l = self.element.length;
        match &self.shape {
            Shape::Cylinder { phi, .. } => rotation(xi, l, *phi),
            Shape::Cone(cone) => {
                let x = xi * l;
                let [mut moment, mut shear] = [0.0; 2];
                for (share, weight) in &cone.rule {
                    let (s, ds) = (share * x, weight * x);
                    let flexibility = ds / Section::at(self.element, self.shear, share * xi).flexural;
                    moment += flexibility;
                    shear += (s - cone.centre) * flexibility;
                }
                let [of_moment, of_shear] = cone.loads(l);
                Vector4::new(0.0, 1.0, 0.0, 0.0) + of_moment * moment + of_shear * shear
            }
        }
    }

    /// Slope Nᵥ' of the displacement at ξ = x/l, 1/m: the rotation, and the shear strain, which is constant in a cylinder.
    pub fn slope(&self, xi: f64) -> Vector4<f64> {
        let l = self.element.length;
        let strain = match &self.shape {
            Shape::Cylinder { phi, .. } => Vector4::new(-1.0 / l, -0.5, 1.0 / l, -0.5) * (phi / (1.0 + phi)),
            Shape::Cone(_) if !self.shear => Vector4::zeros(),
            Shape::Cone(cone) => cone.loads(l)[1] / -self.section(xi).shear,
        };
        self.rotation(xi) + strain
    }

    /// Shape functions of a rod at ξ = x/l, and its stiffness: in torsion, N m/rad, or along the axis, N/m.
    pub fn rod(&self, xi: f64, rigidity: fn(&Section) -> f64) -> ([f64; 2], f64) {
        match &self.shape {
            Shape::Cylinder { section, .. } => ([1.0 - xi, xi], rigidity(section) / self.element.length),
            Shape::Cone(cone) => {
                let flexibility = |end: f64| -> f64 {
                    let at = |(share, weight): &(f64, f64)| weight * end / rigidity(&self.section(share * end));
                    self.element.length * cone.rule.iter().map(at).sum::<f64>()
                };
                let (part, total) = (flexibility(xi), flexibility(1.0));
                ([1.0 - part / total, part / total], 1.0 / total)
            }
        }
    }
}

impl Cone {
    /// M_c and V for the displacements (u₁, φ₁, u₂, φ₂) of the ends of an element of the length `l`, m.
    fn loads(&self, l: f64) -> [Vector4<f64>; 2] {
        let moment = Vector4::new(0.0, -1.0, 0.0, 1.0) / self.flexural;
        [moment, Vector4::new(1.0, self.centre, -1.0, l - self.centre) / self.transverse]
    }
}

/// Shape functions Nᵥ of the displacement of a cylinder at ξ = x/l; Φ = 12EI/(κGAl²) = `phi` is the shear parameter.
fn displacement(xi: f64, l: f64, phi: f64) -> Vector4<f64> {
    let (square, cube) = (xi * xi, xi * xi * xi);
    Vector4::new(
        1.0 - 3.0 * square + 2.0 * cube + (1.0 - xi) * phi,
        l * (xi - 2.0 * square + cube + (xi - square) * phi / 2.0),
        3.0 * square - 2.0 * cube + xi * phi,
        l * (-square + cube - (xi - square) * phi / 2.0),
    ) / (1.0 + phi)
}

/// Shape functions N_θ of the rotation of the section of a cylinder at ξ = x/l.
fn rotation(xi: f64, l: f64, phi: f64) -> Vector4<f64> {
    let square = xi * xi;
    Vector4::new(
        6.0 / l * (square - xi),
        1.0 - 4.0 * xi + 3.0 * square + (1.0 - xi) * phi,
        6.0 / l * (xi - square),
        -2.0 * xi + 3.0 * square + xi * phi,
    ) / (1.0 + phi)
}
