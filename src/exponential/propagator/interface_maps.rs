//! Linear maps between the modal state z and the interface: u = w z, and ż = A z + Σ b p for the loads p.

use std::ops::Range;

use num_complex::Complex64;

use super::packed::Panel;
use crate::connection::{Direction, Interface};

/// Rows w and columns b of the interface over a state z.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct InterfaceMaps {
    /// Rows w: one for each interface scalar, then, where loads depend on rates, one for each rate, then those of a
    /// changing speed.
    pub rows: Vec<Vec<f64>>,
    /// Number of interface scalars of the connections.
    pub scalars: usize,
    /// Whether the rows contain the rates of the scalars.
    pub has_rates: bool,
    /// Columns b: one for each load. Loads that depend on the motion come first.
    pub columns: Vec<Vec<f64>>,
    /// Number of columns that belong to loads that depend on the motion.
    pub coupled_loads: usize,
    /// Slots of the independent parts of the state: nothing linear couples two parts.
    pub parts: Vec<Range<usize>>,
    /// Every direction of every connection, linearised at rest.
    pub tangents: Vec<LinearizedDirection>,
    /// Complex amplitudes of the rows in the synchronous motion, source after source.
    pub synchronous: Vec<Complex64>,
}

/// One direction of a connection, linearised at rest: the deflection is g·u over the scalars of the connection, and the
/// force f acts on them as the loads −g f.
#[derive(Clone, Debug, PartialEq)]
pub struct LinearizedDirection {
    /// Indices of the scalars of the connection among the scalars of all connections.
    pub scalars: Range<usize>,
    /// Gradient g of the deflection over these scalars.
    pub gradient: Vec<f64>,
    /// √k of the linear stiffness k along the direction, √(N/m), if the energy |z|² does not contain the connection;
    /// otherwise zero.
    pub root: f64,
}

impl LinearizedDirection {
    /// The directions of all connections.
    pub fn all(interfaces: &[Interface], includes_meshes: bool) -> Vec<Self> {
        let (mut from, mut tangents) = (0, Vec::new());
        for interface in interfaces {
            let scalars = from..from + interface.scalars();
            from = scalars.end;
            tangents.extend(interface.directions().into_iter().map(|Direction { gradient, stiffness }| {
                let root = if includes_meshes { 0.0 } else { stiffness.max(0.0).sqrt() };
                Self { scalars: scalars.clone(), gradient, root }
            }));
        }
        tangents
    }

    /// √k g·u. Its square is twice the mesh energy that |z|² does not contain, J.
    pub fn mesh_energy_norm(&self, interface_state: &[f64]) -> f64 {
        self.root * self.along(interface_state, 0)
    }

    /// g·u of the scalars (`from` = 0), or g·u̇ of their rates (`from` = number of all scalars).
    pub fn along(&self, interface_state: &[f64], from: usize) -> f64 {
        let own = &interface_state[from + self.scalars.start..from + self.scalars.end];
        own.iter().zip(&self.gradient).map(|(u, g)| u * g).sum()
    }
}

impl InterfaceMaps {
    /// Appends √k δ of every mesh to a state. The squared length is then twice the energy of modes and meshes.
    pub fn with_mesh_energy(&self, mut state: Vec<f64>) -> Vec<f64> {
        let product = |row: &Vec<f64>| row.iter().zip(&state).map(|(w, z)| w * z).sum();
        let scalars: Vec<f64> = self.rows.iter().take(self.scalars).map(product).collect();
        state.extend(self.tangents.iter().map(|tangent| tangent.mesh_energy_norm(&scalars)));
        state
    }
}

/// Gram matrix of `count` vectors that are stored one after the other.
pub fn gram(vectors: &[f64], count: usize) -> Panel {
    let len = vectors.len() / count.max(1);
    let vector = |k: usize| &vectors[k * len..(k + 1) * len];
    let dot = |i: usize, j: usize| vector(i).iter().zip(vector(j)).map(|(a, b)| a * b).sum();
    let entries: Vec<f64> = (0..count * count).map(|at| dot(at / count, at % count)).collect();
    Panel::new(&entries, count)
}
