//! Internal coordinates of shaft elements of degree p ≥ 2.
//!
//! Beside the nodal shape functions, which are the static solutions, an element has shape functions that vanish at both
//! ends: integrated Legendre polynomials of degree 2…p + 1 for the displacement u and of degree 2…p for the rotation φ,
//! the twist θ and the axial displacement. Equal degrees of u and φ would lose order. Without shear deformation φ = u', so that the pairs are
//! combined: u has the twice integrated polynomials of degree 4…p + 1.
//!
//! A static solution is orthogonal in strain energy to every function that vanishes at both ends. The stiffness matrix
//! therefore has no entries between nodal and internal coordinates, static displacements of the nodes do not depend on
//! p, and only mass and gyroscopic matrix are coupled. Natural frequencies converge with the order 2p.

use nalgebra::{DMatrix, DVector, Matrix4, Vector4};

use super::profile::{Profile, Section};
use crate::numerics::{gauss, integrated, integrated_slope, twice_integrated};
use crate::scene::{Element, Shaft};

/// An internal shape function of bending, with its degree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BendingFunction {
    /// Displacement u without rotation of the section.
    Displacement(usize),
    /// Rotation φ of the section without displacement.
    Rotation(usize),
    /// Displacement u with the rotation φ = u', for a beam without shear deformation.
    Deflection(usize),
}

/// Values of a shape function at a point.
pub(super) struct Shape {
    /// Displacement u.
    pub displacement: f64,
    /// Rotation φ, 1/m for a displacement in m.
    pub rotation: f64,
    /// Curvature φ'.
    curvature: f64,
    /// Shear strain u' − φ.
    shear: f64,
}

impl BendingFunction {
    /// Internal shape functions of an element of this degree, in the order of its coordinates.
    pub fn all(degree: usize, shear: bool) -> Vec<Self> {
        let pair = |n: usize| {
            let rotation = (n <= degree).then_some(Self::Rotation(n));
            std::iter::once(Self::Displacement(n)).chain(rotation)
        };
        match (degree, shear) {
            (0 | 1, _) => Vec::new(),
            (_, true) => (2..=degree + 1).flat_map(pair).collect(),
            (_, false) => (4..=degree + 1).map(Self::Deflection).collect(),
        }
    }

    /// Values at ξ in [−1, 1] of an element of length `l`, m.
    pub(super) fn at(self, xi: f64, l: f64) -> Shape {
        // dξ/dx.
        let rate = 2.0 / l;
        let none = Shape { displacement: 0.0, rotation: 0.0, curvature: 0.0, shear: 0.0 };
        match self {
            Self::Displacement(n) => {
                Shape { displacement: integrated(n, xi), shear: rate * integrated_slope(n, xi), ..none }
            }
            Self::Rotation(n) => {
                let value = integrated(n, xi);
                Shape { rotation: value, curvature: rate * integrated_slope(n, xi), shear: -value, ..none }
            }
            Self::Deflection(n) => Shape {
                displacement: twice_integrated(n, xi),
                rotation: rate * integrated(n - 1, xi),
                curvature: rate * rate * integrated_slope(n - 1, xi),
                ..none
            },
        }
    }

    /// Slope u' at ξ in [−1, 1] of an element of length `l`, m.
    fn slope(self, xi: f64, l: f64) -> f64 {
        let shape = self.at(xi, l);
        shape.shear + shape.rotation
    }

    /// Curvature φ' at ξ in [−1, 1] of an element of length `l`, m.
    pub fn curvature(self, xi: f64, l: f64) -> f64 {
        self.at(xi, l).curvature
    }
}

/// Degrees of the internal shape functions of the twist and of the axial displacement.
pub fn rod_degrees(degree: usize) -> std::ops::RangeInclusive<usize> {
    2..=degree
}

/// Factors of the coordinates of bending of an element in a displacement or a rotation.
#[derive(Clone, Debug)]
pub struct BendingShape {
    /// Factors of (u₁, φ₁, u₂, φ₂), the coordinates of the two nodes.
    pub nodal: Vector4<f64>,
    /// Factors of the internal coordinates.
    pub internal: Vec<f64>,
}

/// Shape functions of an element at one place: factors of its coordinates in the motion there.
#[derive(Clone, Debug)]
pub struct PlaceShape {
    /// The displacement u.
    pub displacement: BendingShape,
    /// The rotation φ.
    pub rotation: BendingShape,
    /// Factors of the twists of the two nodes.
    pub torsion: [f64; 2],
    /// Factors of the axial displacements of the two nodes.
    pub axial: [f64; 2],
    /// Factors of the internal coordinates of a rod (twist or axial displacement), by degree from 2.
    pub rod: Vec<f64>,
}

impl PlaceShape {
    /// The motion at ξ = x/l of an element of this degree.
    pub fn new(element: &Element, shear: bool, degree: usize, xi: f64) -> Self {
        let (l, profile) = (element.length, Profile::new(element, shear));
        let functions: Vec<Shape> =
            BendingFunction::all(degree, shear).iter().map(|function| function.at(2.0 * xi - 1.0, l)).collect();
        let internal = |value: fn(&Shape) -> f64| functions.iter().map(value).collect();
        Self {
            displacement: BendingShape {
                nodal: profile.displacement(xi),
                internal: internal(|shape| shape.displacement),
            },
            rotation: BendingShape { nodal: profile.rotation(xi), internal: internal(|shape| shape.rotation) },
            torsion: profile.rod(xi, |section| section.torsional).0,
            axial: profile.rod(xi, |section| section.axial).0,
            rod: rod_degrees(degree).map(|n| integrated(n, 2.0 * xi - 1.0)).collect(),
        }
    }
}

/// Blocks of a symmetric element matrix for its m internal coordinates.
#[derive(Clone, Debug)]
pub struct InternalBlocks {
    /// Entries between the coordinates of the two nodes (rows) and the internal ones, 2B × m; `None` if zero.
    pub coupling: Option<DMatrix<f64>>,
    /// Entries between the internal coordinates, m × m.
    pub block: DMatrix<f64>,
}

/// Matrices of the internal coordinates of one element.
#[derive(Clone, Debug)]
pub struct InternalBeam {
    /// Mass matrix of bending; entries in kg, kg m and kg m².
    pub mass: InternalBlocks,
    /// Gyroscopic matrix of bending, per unit spin; entries in kg, kg m and kg m².
    pub gyroscopic: InternalBlocks,
    /// Stiffness matrix of bending; entries in N/m, N and N m.
    pub stiffness: InternalBlocks,
    /// Matrices of torsion, in kg m² and N m/rad.
    pub torsion: InternalRod,
    /// Matrices along the axis, in kg and N/m.
    pub axial: InternalRod,
}

/// Matrices of the internal coordinates of one element in torsion or along its axis.
#[derive(Clone, Debug)]
pub struct InternalRod {
    /// Mass matrix.
    pub mass: InternalBlocks,
    /// Stiffness matrix.
    pub stiffness: InternalBlocks,
}

impl InternalBeam {
    /// Matrices of the elements of a shaft; empty for elements without internal coordinates.
    pub fn of_shaft(shaft: &Shaft) -> Vec<Self> {
        if shaft.degree == 1 {
            return Vec::new();
        }
        let matrices = |element| Self::new(element, shaft.shear, shaft.degree);
        shaft.elements.iter().map(matrices).collect()
    }

    /// Matrices of `element` with degree p = `degree`; without `shear` the shear deformation is neglected.
    pub fn new(element: &Element, shear: bool, degree: usize) -> Self {
        let (l, profile) = (element.length, Profile::new(element, shear));
        let functions = BendingFunction::all(degree, shear);
        let shapes = |xi: f64| -> Vec<Shape> { functions.iter().map(|f| f.at(2.0 * xi - 1.0, l)).collect() };
        let inertia = |xi: f64, area: f64, rotary: f64| {
            let shapes = shapes(xi);
            let u = DVector::from_iterator(shapes.len(), shapes.iter().map(|shape| shape.displacement));
            let phi = DVector::from_iterator(shapes.len(), shapes.iter().map(|shape| shape.rotation));
            let (nodal_u, nodal_phi) = (profile.displacement(xi), profile.rotation(xi));
            InternalBlocks {
                coupling: Some(outer(nodal_u.as_slice(), &u) * area + outer(nodal_phi.as_slice(), &phi) * rotary),
                block: &u * u.transpose() * area + &phi * phi.transpose() * rotary,
            }
        };
        let strain = |xi: f64, dx: f64| {
            let (shapes, section) = (shapes(xi), profile.section(xi));
            let curvature = DVector::from_iterator(shapes.len(), shapes.iter().map(|shape| shape.curvature));
            let sheared = DVector::from_iterator(shapes.len(), shapes.iter().map(|shape| shape.shear));
            let bending = &curvature * curvature.transpose() * (section.flexural * dx);
            InternalBlocks::uncoupled(bending + &sheared * sheared.transpose() * (section.shear * dx))
        };
        let rod = |inertia, rigidity| InternalRod::new(&profile, l, degree, inertia, rigidity);
        let points = degree + 2 + profile.further_points();
        let section = |xi: f64| profile.section(xi);
        Self {
            mass: over_element(points, l, |xi, dx| inertia(xi, section(xi).mass * dx, section(xi).rotary * dx)),
            gyroscopic: over_element(points, l, |xi, dx| inertia(xi, 0.0, 2.0 * section(xi).rotary * dx)),
            stiffness: over_element(points, l, strain),
            torsion: rod(|section| section.polar_mass, |section| section.torsional),
            axial: rod(|section| section.mass, |section| section.axial),
        }
    }
}

/// Geometric stiffness ∫u'ᵀu' dx of bending for an axial force of 1 N (Friswell et al. 2010, Dynamics of Rotating Machines,
/// section 5.4.6): over the coordinates of the nodes, and of the internal coordinates of an element of this degree; entries in
/// 1/m, 1 and m.
pub fn geometric_stiffness(element: &Element, shear: bool, degree: usize) -> (Matrix4<f64>, InternalBlocks) {
    let (l, profile) = (element.length, Profile::new(element, shear));
    let functions = BendingFunction::all(degree, shear);
    let points = degree + 2 + profile.further_points();
    let nodal = gauss(points).iter().fold(Matrix4::zeros(), |sum, (xi, weight)| {
        let slope = profile.slope(*xi);
        sum + slope * slope.transpose() * (weight * l)
    });
    let internal = over_element(points, l, |xi, dx| {
        let slopes = functions.iter().map(|function| function.slope(2.0 * xi - 1.0, l));
        let slopes = DVector::from_iterator(functions.len(), slopes);
        InternalBlocks {
            coupling: Some(outer(profile.slope(xi).as_slice(), &slopes) * dx),
            block: &slopes * slopes.transpose() * dx,
        }
    });
    (nodal, internal)
}

impl InternalRod {
    /// Matrices of an element of length `l`, m, and of this degree, with this inertia per unit length and this rigidity.
    fn new(
        profile: &Profile<'_>,
        l: f64,
        degree: usize,
        inertia: fn(&Section) -> f64,
        rigidity: fn(&Section) -> f64,
    ) -> Self {
        let degrees: Vec<usize> = rod_degrees(degree).collect();
        let values = |xi: f64, function: fn(usize, f64) -> f64| {
            DVector::from_iterator(degrees.len(), degrees.iter().map(|n| function(*n, 2.0 * xi - 1.0)))
        };
        let mass = |xi: f64, dx: f64| {
            let (shape, inertia) = (values(xi, integrated), inertia(&profile.section(xi)));
            InternalBlocks {
                coupling: Some(outer(&profile.rod(xi, rigidity).0, &shape) * (inertia * dx)),
                block: &shape * shape.transpose() * (inertia * dx),
            }
        };
        let strain = |xi: f64, dx: f64| {
            let slope = values(xi, integrated_slope) * (2.0 / l);
            InternalBlocks::uncoupled(&slope * slope.transpose() * (rigidity(&profile.section(xi)) * dx))
        };
        let points = degree + 2 + profile.further_points();
        Self { mass: over_element(points, l, mass), stiffness: over_element(points, l, strain) }
    }
}

/// Integral over an element of length `l`, m: the sum of `point(ξ, dx)` over the points of a Gauss rule. In a cylinder, the
/// products of shape functions of degree p have at most the degree 2(p + 1), for which p + 2 points are exact.
fn over_element(points: usize, l: f64, point: impl Fn(f64, f64) -> InternalBlocks) -> InternalBlocks {
    let rule = gauss(points);
    rule.iter().map(|(xi, weight)| point(*xi, weight * l)).reduce(InternalBlocks::plus).unwrap_or_default()
}

/// abᵀ.
fn outer(a: &[f64], b: &DVector<f64>) -> DMatrix<f64> {
    DMatrix::from_fn(a.len(), b.len(), |i, j| a[i] * b[j])
}

impl Default for InternalBlocks {
    fn default() -> Self {
        Self::uncoupled(DMatrix::zeros(0, 0))
    }
}

impl InternalBlocks {
    /// Blocks without entries between nodal and internal coordinates.
    pub fn uncoupled(block: DMatrix<f64>) -> Self {
        Self { coupling: None, block }
    }

    /// Sum of two.
    pub fn plus(self, other: Self) -> Self {
        let coupling = match (self.coupling, other.coupling) {
            (Some(one), Some(other)) => Some(one + other),
            (one, other) => one.or(other),
        };
        Self { coupling, block: self.block + other.block }
    }

    /// Multiple.
    pub fn times(&self, factor: f64) -> Self {
        Self { coupling: self.coupling.as_ref().map(|coupling| coupling * factor), block: &self.block * factor }
    }

    /// Whether every entry is zero.
    pub fn is_zero(&self) -> bool {
        self.coupling.iter().chain([&self.block]).all(|part| part.iter().all(|entry| *entry == 0.0))
    }
}
