//! Elements that act between a few coordinates and are nonlinear or time-varying.
//!
//! A connection depends on the displacements q through a few scalars u = Wᵀq, and acts on the same coordinates with the
//! same coefficients. [`Connection`] is one enum. Each variant has its own file and answers the same questions:
//!
//! | question | answer | used by |
//! |---|---|---|
//! | Which scalars? | [`Connection::rows`] | matrices, null motions, exponential method |
//! | Which stiffness and damping, at a speed? | [`Connection::linear`] | matrices, modes, Campbell diagram, critical speeds, synchronous response, static equilibrium |
//! | Which force, energy and power at an instant? | `contact` or `force` of the variant | equation of motion, energy audit |
//! | Which tangent, of any rank up to the number of scalars? | `mean_tangent` or `static_tangent` of the variant; [`Interface::directions`], [`Interface::load`] | Newton's method in the static equilibrium and in the exponential method |
//! | Which contact mode, and how far is the next change? | [`Interface::contact_mode`], [`Interface::margins`], [`Interface::guaranteed_interval`] | events |
//! | Which bounds? | [`Connection::bounds`] | stability limit of the step |
//! | What can a run record, in which unit? | [`Connection::channels`] | recorder, files, spectra and figures |
//!
//! A [`TurningBow`] acts on a whole shaft and is in no matrix ([`Connection::is_local`]).
//! A bearing with constant coefficients is linear: it is part of the matrices and is not a connection. At a constant
//! speed a [`SpeedDependentBearing`] is also part of the matrices; only runs at a changing speed have its [`Interface`].
//!
//! The `match` over the variants has no wildcard. An analysis that does not handle a new variant does not compile.

mod bearing;
mod bow;
mod channel;
mod instant;
mod interface;
mod load;
mod mesh;
mod nonlinear_bearing;

use nalgebra::DMatrix;

pub use bearing::{BearingInterface, SpeedDependentBearing};
pub use bow::{BowInterface, TurningBow};
pub use channel::{BEARING_CHANNELS, Channel, MESH_CHANNELS, ROLLING_CHANNELS, mesh_values};
pub use instant::{GuaranteedInterval, Instant, InterfaceOptions, OutOfRange, Tangent, Touch};
pub use interface::Interface;
pub use load::{AppliedLoad, LoadInterface};
pub use mesh::MeshInterface;
pub use nonlinear_bearing::{BearingLaw, BearingTangent, NonlinearBearing, NonlinearInterface, OperatingPoint, Tilt};

use crate::mesh::GearMesh;

/// A scalar as entries (index of a coordinate, coefficient).
pub type Row = Vec<(usize, f64)>;

/// The scalar of a row for these displacements, or its rate for velocities.
#[inline]
pub fn along_row(row: &[(usize, f64)], values: &[f64]) -> f64 {
    row.iter().map(|(index, coefficient)| coefficient * values[*index]).sum()
}

/// One element that acts between a few coordinates.
#[derive(Clone, Copy, Debug)]
pub enum Connection<'m> {
    /// A pair of gears: index of the mesh, its teeth, and σ, the sign of the spin of the driver.
    Mesh(usize, &'m GearMesh, f64),
    /// A bearing whose coefficients depend on the speed.
    Bearing(&'m SpeedDependentBearing),
    /// The force of an oil film or of rolling elements beyond its part in the matrices.
    Nonlinear(&'m NonlinearBearing),
    /// A load that depends on time, angle or speed.
    Load(&'m AppliedLoad),
    /// What the twist of a bowed shaft adds to the force of its bow.
    Bow(&'m TurningBow),
}

/// Stiffness and damping over the scalars of a connection.
#[derive(Clone, Debug, PartialEq)]
pub struct Coefficients {
    /// K, shape (r, r), N/m for scalars in m.
    pub stiffness: DMatrix<f64>,
    /// C, shape (r, r), N s/m.
    pub damping: DMatrix<f64>,
}

impl Coefficients {
    fn isotropic(scalars: usize, stiffness: f64, damping: f64) -> Self {
        let [stiffness, damping] =
            [stiffness, damping].map(|value| DMatrix::from_diagonal_element(scalars, scalars, value));
        Self { stiffness, damping }
    }

    fn over_two(stiffness: &[[f64; 2]; 2], damping: &[[f64; 2]; 2]) -> Self {
        let [stiffness, damping] = [stiffness, damping].map(|rows| DMatrix::from_fn(2, 2, |i, j| rows[i][j]));
        Self { stiffness, damping }
    }
}

/// A direction over the scalars in which the load of a connection changes with the motion.
#[derive(Clone, Debug, PartialEq)]
pub struct Direction {
    /// Gradient g over the scalars, shape (r,).
    pub gradient: Vec<f64>,
    /// Stiffness along the direction that the linear motion may lack, N/m.
    pub stiffness: f64,
}

impl Direction {
    /// Every scalar as one direction, without stiffness beyond that of the linear motion.
    fn of_scalars(count: usize) -> Vec<Self> {
        let unit = |at: usize| (0..count).map(|k| if k == at { 1.0 } else { 0.0 }).collect();
        (0..count).map(|at| Self { gradient: unit(at), stiffness: 0.0 }).collect()
    }
}

/// Bounds of the contribution of a connection to the fastest motion of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Norm of the stiffness beyond that of [`Connection::linear`], N/m.
    pub excess_stiffness: f64,
    /// Norm of the damping, N s/m.
    pub damping: f64,
}

impl Connection<'_> {
    /// Scalars of the connection; for a mesh, the deflection along the line of action at rest.
    pub fn rows(&self) -> Vec<Row> {
        match self {
            Self::Mesh(_, mesh, sigma) => {
                let mut row = Row::new();
                mesh.gradient(*sigma, &mesh.directions_at_rest(*sigma), |index, slope| row.push((index, slope)));
                vec![row]
            }
            Self::Bearing(bearing) => bearing.rows.to_vec(),
            Self::Nonlinear(bearing) => bearing.rows.clone(),
            Self::Load(load) => load.rows.clone(),
            Self::Bow(bow) => bow.rows.to_vec(),
        }
    }

    /// Whether it has stiffness, so that a rigid-body mode cannot move its scalars. The stiffness of a nonlinear bearing is in
    /// the matrices.
    pub fn is_elastic(&self) -> bool {
        !matches!(self, Self::Load(_) | Self::Nonlinear(_) | Self::Bow(_))
    }

    /// Whether it acts on the coordinates of a few nodes and may be in the matrices; a bow acts on its whole shaft, and the
    /// matrices do not contain its twist.
    pub fn is_local(&self) -> bool {
        !matches!(self, Self::Bow(_))
    }

    /// Stiffness and damping over the scalars at a speed of the reference shaft, rad/s; for a mesh, the mean values.
    pub fn linear(&self, speed: f64) -> Coefficients {
        match self {
            Self::Mesh(_, mesh, _) => Coefficients::isotropic(1, mesh.stiffness, mesh.damping),
            Self::Bearing(bearing) => bearing.linear(speed),
            Self::Nonlinear(bearing) => bearing.linear(),
            Self::Load(load) => load.linear(speed),
            Self::Bow(bow) => Coefficients::isotropic(bow.rows.len(), 0.0, 0.0),
        }
    }

    /// Loss factor η of the stiffness, which analyses in the frequency domain contain.
    pub fn loss_factor(&self) -> f64 {
        match self {
            Self::Mesh(_, mesh, _) => mesh.loss_factor,
            Self::Bearing(bearing) => bearing.bearing.loss_factor,
            Self::Nonlinear(_) | Self::Load(_) | Self::Bow(_) => 0.0,
        }
    }

    /// Bounds of the coefficients in a run whose linear part is the one at `speed`.
    pub fn bounds(&self, speed: f64) -> Bounds {
        match self {
            Self::Mesh(_, mesh, _) => {
                let flanks = if mesh.backlash.is_some() { 2.0 } else { 1.0_f64 };
                Bounds { excess_stiffness: mesh.largest_stiffness - mesh.stiffness, damping: flanks * mesh.damping }
            }
            Self::Bearing(bearing) => bearing.bounds(speed),
            Self::Nonlinear(bearing) => bearing.bounds(),
            Self::Load(load) => load.bounds(),
            // The bow is small against the radius of gyration of the shaft, whose stiffness the limit contains.
            Self::Bow(_) => Bounds { excess_stiffness: 0.0, damping: 0.0 },
        }
    }

    /// What a run can record of the connection.
    pub fn channels(&self) -> &'static [Channel] {
        match self {
            Self::Mesh(..) => &MESH_CHANNELS,
            Self::Bearing(_) | Self::Nonlinear(_) => &BEARING_CHANNELS,
            // A run knows its loads, and the force of a bow follows from the twist.
            Self::Load(_) | Self::Bow(_) => &[],
        }
    }

    /// Name of the connection in messages, with its stiffness; none for a bearing, whose stiffness depends on the
    /// speed, and for a load or a bow, which have none.
    pub fn described(&self) -> Option<String> {
        match self {
            Self::Mesh(index, mesh, _) => Some(format!("meshes[{index}], of {:.3e} N/m", mesh.normal_stiffness())),
            Self::Bearing(_) | Self::Nonlinear(_) | Self::Load(_) | Self::Bow(_) => None,
        }
    }
}
