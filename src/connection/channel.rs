//! Quantities of connections that a run can record, with their units.

use crate::mesh::MeshState;

/// A quantity of a connection that a run can record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Channel {
    /// Name, as in a response.
    pub name: &'static str,
    /// SI unit; "1" for a ratio or a count.
    pub unit: &'static str,
}

const fn channel(name: &'static str, unit: &'static str) -> Channel {
    Channel { name, unit }
}

/// Channels of a mesh, in the order of [`mesh_values`].
pub const MESH_CHANNELS: [Channel; 11] = [
    channel("deflection", "m"),
    channel("force", "N"),
    channel("stiffness", "N/m"),
    channel("pressure_angle", "rad"),
    channel("centre_distance", "m"),
    channel("centre_line_angle", "rad"),
    channel("contact_ratio", "1"),
    channel("pairs_in_contact", "1"),
    channel("thrust", "N"),
    channel("friction_force", "N"),
    channel("friction_power", "W"),
];

/// Channels of the bearings at a node: components of the force of the shaft on them.
pub const BEARING_CHANNELS: [Channel; 2] = [channel("force_y", "N"), channel("force_z", "N")];

/// Channels of the rolling bearings at a node: number of loaded elements, and the largest contact force.
pub const ROLLING_CHANNELS: [Channel; 2] = [channel("loaded_elements", "1"), channel("largest_contact_force", "N")];

/// The value of every channel of a mesh.
pub fn mesh_values(state: &MeshState) -> [f64; MESH_CHANNELS.len()] {
    [
        state.deflection,
        state.force,
        state.stiffness,
        state.centres.pressure_angle,
        state.centres.distance,
        state.centres.angle,
        state.centres.contact_ratio,
        state.pairs_in_contact,
        state.thrust,
        state.friction_force,
        state.friction_power,
    ]
}
