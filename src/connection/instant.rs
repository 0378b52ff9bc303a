//! Quantities of a run that the interface of a connection needs.

use crate::mesh::{ContactMode, Geometry, Overlap, ShaftPhase};

/// Quantities at an instant of a run on which a connection depends in addition to its scalars.
#[derive(Clone, Copy, Debug)]
pub struct Instant {
    /// Time, s.
    pub time: f64,
    /// Angles and spins of the two shafts of a mesh; the first one is the shaft of a load, of a
    /// speed-dependent bearing or of an oil film, or the cage of rolling elements.
    pub phases: [ShaftPhase; 2],
    /// Contact mode of a mesh.
    pub contact_mode: ContactMode,
}

/// Where the tangent of a connection over its d directions is written, row after row.
#[derive(Debug)]
pub struct Tangent<'a> {
    /// ∂f_i/∂(g_j·u), N/m: d × d entries.
    pub stiffness: &'a mut [f64],
    /// ∂f_i/∂(g_j·u̇), N s/m: d × d entries, or none if no load of the run depends on rates.
    pub damping: &'a mut [f64],
}

impl<'a> Tangent<'a> {
    /// Splits off the first `count` entries of both.
    pub fn split_off(&mut self, count: usize) -> Self {
        let [stiffness, damping] = [&mut self.stiffness, &mut self.damping]
            .map(|entries: &mut &'a mut [f64]| entries.split_off_mut(..count.min(entries.len())).unwrap_or_default());
        Self { stiffness, damping }
    }
}

/// A journal that touches its bearing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Touch {
    /// Index of the bearing in the scene.
    pub bearing: usize,
    /// Part of the clearance used at the nearest pad, for a plain film the eccentricity ratio; one or more.
    pub nearness: f64,
}

/// A motion for which a connection has no force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum OutOfRange {
    /// The base circles of a mesh overlap.
    Overlap(Overlap),
    /// A journal touches its bearing.
    Touch(Touch),
}

impl From<Overlap> for OutOfRange {
    fn from(overlap: Overlap) -> Self {
        Self::Overlap(overlap)
    }
}

impl From<Touch> for OutOfRange {
    fn from(touch: Touch) -> Self {
        Self::Touch(touch)
    }
}

/// Interval in which the contact mode of a connection cannot change.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GuaranteedInterval {
    /// Lower bound on the time to the next change, s, for any oscillating part of the motion.
    pub time: f64,
    /// Angular frequency of the gear oscillation on the mesh stiffness that can end the interval, rad/s; zero if `time`
    /// is infinite.
    pub frequency: f64,
}

/// Quantities that all interfaces of a run share.
#[derive(Clone, Copy, Debug)]
pub struct InterfaceOptions<'a> {
    /// Whether the line of action follows the gear centres.
    pub geometry: Geometry,
    /// Displacements from which deviations are measured.
    pub reference: &'a [f64],
    /// Whether the linear motion contains the linear part of the connections.
    pub contained: bool,
    /// Speed of the reference shaft in the linear motion, rad/s.
    pub speed: f64,
    /// Speed of the reference shaft whose coefficients of speed-dependent bearings the linear motion contains, rad/s.
    pub bearing_speed: f64,
    /// Highest angular frequency of the gear oscillation on the mesh stiffness, rad/s.
    pub highest_frequency: f64,
    /// Acceleration of the teeth along the line of action per unit of mesh force, 1/kg.
    pub mobility: f64,
}
