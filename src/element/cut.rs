//! Section forces within an element, as rows over its coordinates.
//!
//! The section forces at a place are what the part of the shaft beyond it (larger x) exerts on the part before it. The
//! generalised forces f₁ = (M ü − iΩG u̇ + K u)₁ of the first node are what the shaft before the element exerts on it, so that the
//! section forces at the begin are −f₁. Newton's law of the piece between the begin and the distance s from it gives
//!
//! ```text
//! Q(s) = Q(0) + ∫ρA ü dx,
//! M(s) = M(0) − s Q(s) + N₀(u(s) − u(0)) + ∫(ρA x ü + ρI(φ̈ − 2iΩ φ̇)) dx,
//! ```
//!
//! with the moment M conjugate to φ and a given axial force N₀. The forces are in equilibrium with those at the nodes, also where the
//! curvature of the shape functions is not: point loads on a shaft of one element give exact section forces.

use nalgebra::Matrix4;

use super::internal::{BendingFunction, InternalBeam, InternalBlocks, InternalRod, geometric_stiffness, rod_degrees};
use super::profile::{Profile, Section};
use super::{Beam, RodMatrices};
use crate::numerics::{gauss, integrated};
use crate::scene::Element;

/// Rows of the section forces at one place of an element.
#[derive(Clone, Debug)]
pub struct ElementCut {
    /// Shear force and bending moment.
    pub bending: BendingCut,
    /// Torque, over the twists.
    pub torsion: RodCut,
    /// Axial force, over the axial displacements.
    pub axial: RodCut,
}

/// Rows over (u₁, φ₁, u₂, φ₂) and the internal coordinates of bending.
#[derive(Clone, Debug)]
pub struct BendingCut {
    /// Over the accelerations; entries in kg, kg m and kg m².
    pub inertia: ForceRows,
    /// Over −i times the velocities, per unit spin; entries in kg, kg m and kg m².
    pub gyroscopic: ForceRows,
    /// Elastic forces over the displacements; entries in N/m, N and N m.
    pub stiffness: ForceRows,
    /// Forces of an axial force of 1 N over the displacements; entries in 1/m, 1 and m.
    pub geometric: ForceRows,
}

/// Rows that give the shear force Q, N, and the complex bending moment M, N m, which does work on the complex rotation φ.
#[derive(Clone, Debug, PartialEq)]
pub struct ForceRows {
    /// Row of Q.
    pub shear: Vec<f64>,
    /// Row of M.
    pub moment: Vec<f64>,
}

/// Rows of a rod over the values of its two nodes and its internal coordinates.
#[derive(Clone, Debug)]
pub struct RodCut {
    /// Over the accelerations, kg m² or kg.
    pub inertia: Vec<f64>,
    /// Over the displacements, N m/rad or N/m.
    pub stiffness: Vec<f64>,
}

impl ElementCut {
    /// The cut at ξ = x/l of an element of this degree; without `shear` the shear deformation is neglected.
    pub fn new(element: &Element, shear: bool, degree: usize, xi: f64) -> Self {
        let (profile, beam) = (Profile::new(element, shear), Beam::new(element, shear));
        let inner = (degree > 1).then(|| InternalBeam::new(element, shear, degree));
        let piece = Piece { profile: &profile, length: element.length, degree, shear, xi };
        let rod = |nodal: &RodMatrices, inner: Option<&InternalRod>, inertia, rigidity| {
            piece.rod(nodal, inner, inertia, rigidity)
        };
        let inner = inner.as_ref();
        Self {
            bending: piece.bending(&beam, inner, &geometric_stiffness(element, shear, degree)),
            torsion: rod(&beam.torsion, inner.map(|inner| &inner.torsion), |at| at.polar_mass, |at| at.torsional),
            axial: rod(&beam.axial, inner.map(|inner| &inner.axial), |at| at.mass, |at| at.axial),
        }
    }
}

/// The piece of an element between its begin and ξ.
struct Piece<'a> {
    profile: &'a Profile<'a>,
    /// Length of the element, m.
    length: f64,
    degree: usize,
    shear: bool,
    xi: f64,
}

impl Piece<'_> {
    fn bending(
        &self,
        beam: &Beam,
        inner: Option<&InternalBeam>,
        (geometric, inner_geometric): &(Matrix4<f64>, InternalBlocks),
    ) -> BendingCut {
        let functions = BendingFunction::all(self.degree, self.shear);
        let within = |xi: f64| 2.0 * xi - 1.0;
        let displacement = |xi: f64| -> Vec<f64> {
            let inner = functions.iter().map(|function| function.at(within(xi), self.length).displacement);
            self.profile.displacement(xi).iter().copied().chain(inner).collect()
        };
        let rotation = |xi: f64| -> Vec<f64> {
            let inner = functions.iter().map(|function| function.at(within(xi), self.length).rotation);
            self.profile.rotation(xi).iter().copied().chain(inner).collect()
        };
        let end = self.xi * self.length;
        let rows = |nodal: &Matrix4<f64>, inner: Option<&InternalBlocks>| {
            ForceRows::at_begin(nodal, inner, functions.len()).moved(end)
        };
        let mut inertia = rows(&beam.mass, inner.map(|inner| &inner.mass));
        let mut gyroscopic = rows(&beam.gyroscopic, inner.map(|inner| &inner.gyroscopic));
        self.each_point(|xi, dx| {
            let (section, x) = (self.profile.section(xi), xi * self.length);
            let (displaced, rotated) = (displacement(xi), rotation(xi));
            add(&mut inertia.shear, section.mass * dx, &displaced);
            // The shear force at the end, which includes this share, acts at the distance end − x from it.
            add(&mut inertia.moment, section.mass * (x - end) * dx, &displaced);
            add(&mut inertia.moment, section.rotary * dx, &rotated);
            add(&mut gyroscopic.moment, 2.0 * section.rotary * dx, &rotated);
        });
        let mut geometric = rows(geometric, Some(inner_geometric));
        add(&mut geometric.moment, 1.0, &displacement(self.xi));
        geometric.moment[0] -= 1.0;
        let stiffness = rows(&beam.stiffness, inner.map(|inner| &inner.stiffness));
        BendingCut { inertia, gyroscopic, stiffness, geometric }
    }

    fn rod(
        &self,
        nodal: &RodMatrices,
        inner: Option<&InternalRod>,
        inertia: fn(&Section) -> f64,
        rigidity: fn(&Section) -> f64,
    ) -> RodCut {
        let degrees = rod_degrees(self.degree);
        let shape = |xi: f64| -> Vec<f64> {
            let own = degrees.clone().map(|n| integrated(n, 2.0 * xi - 1.0));
            self.profile.rod(xi, rigidity).0.into_iter().chain(own).collect()
        };
        let row = |matrix: &nalgebra::Matrix2<f64>, inner: Option<&InternalBlocks>| -> Vec<f64> {
            let own = (0..degrees.clone().count()).map(|column| coupling(inner, 0, column));
            matrix.row(0).iter().copied().chain(own).map(|value| -value).collect()
        };
        let mut masses = row(&nodal.mass, inner.map(|inner| &inner.mass));
        self.each_point(|xi, dx| add(&mut masses, inertia(&self.profile.section(xi)) * dx, &shape(xi)));
        RodCut { inertia: masses, stiffness: row(&nodal.stiffness, inner.map(|inner| &inner.stiffness)) }
    }

    /// Calls `visit` with ξ and dx of each point of a Gauss rule over the piece. In a cylinder the integrands have at most the
    /// degree p + 2, or 4.
    fn each_point(&self, mut visit: impl FnMut(f64, f64)) {
        for (at, weight) in gauss(self.degree + 2 + self.profile.further_points()) {
            visit(at * self.xi, weight * self.xi * self.length);
        }
    }
}

impl ForceRows {
    /// Minus the first two rows of a matrix over nodes and `inner_count` internal coordinates: the forces at the begin.
    fn at_begin(nodal: &Matrix4<f64>, inner: Option<&InternalBlocks>, inner_count: usize) -> Self {
        let row = |row: usize| {
            let own = (0..inner_count).map(|column| coupling(inner, row, column));
            nodal.row(row).iter().copied().chain(own).map(|value| -value).collect()
        };
        Self { shear: row(0), moment: row(1) }
    }

    /// The forces at the distance `s` from the place of these, m, without load between both.
    fn moved(mut self, s: f64) -> Self {
        for (moment, shear) in self.moment.iter_mut().zip(&self.shear) {
            *moment -= s * shear;
        }
        self
    }
}

/// Entry between a coordinate of the nodes and an internal one.
fn coupling(inner: Option<&InternalBlocks>, row: usize, column: usize) -> f64 {
    inner.and_then(|blocks| blocks.coupling.as_ref()).map_or(0.0, |coupling| coupling[(row, column)])
}

/// `sum += factor·row`.
fn add(sum: &mut [f64], factor: f64, row: &[f64]) {
    sum.iter_mut().zip(row).for_each(|(sum, value)| *sum += factor * value);
}
