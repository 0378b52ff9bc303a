//! What the interface of a connection needs from its run.

use crate::mesh::{ContactMode, Geometry, ShaftPhase};

/// What a connection depends on besides its scalars at an instant of a run.
#[derive(Clone, Copy, Debug)]
pub struct Instant {
    /// Angles and spins of the two shafts of a mesh.
    pub phases: [ShaftPhase; 2],
    /// Contact mode of a mesh.
    pub contact_mode: ContactMode,
}

/// Interval in which the contact mode of a connection cannot change.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GuaranteedInterval {
    /// Lower bound on the time to the next change, s, whatever part of the motion oscillates.
    pub time: f64,
    /// Angular frequency of the oscillation of the gears on the teeth that may end it, rad/s; zero if `time` is infinite.
    pub swing: f64,
}

/// What the interfaces of a run have in common.
#[derive(Clone, Copy, Debug)]
pub struct InterfaceOptions<'a> {
    /// Whether the line of action follows the gear centres.
    pub geometry: Geometry,
    /// Displacements from which deviations are measured.
    pub reference: &'a [f64],
    /// Whether the linear motion contains the linear part of the connections.
    pub contained: bool,
    /// Highest angular frequency of the oscillation of gears on their teeth, rad/s.
    pub highest_swing: f64,
    /// Acceleration of the teeth of a mesh along the line of action by a unit force, 1/kg.
    pub mobility: f64,
}
