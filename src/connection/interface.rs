//! A connection in a run: the loads that act on the linear motion through its scalars.
//!
//! Deviations are measured from a reference: the static equilibrium, if it exists. The linear motion may contain a linear
//! part of a connection: the mean stiffness and the damping of a mesh, the coefficients of a bearing at one speed or at its
//! operating point, the slope of a torque over the speed. The load on a scalar is the generalised force of the connection at
//! the instant, minus [`Interface::reference_force`], minus that of the linear part at the deviations.

use super::bearing::BearingInterface;
use super::bow::BowInterface;
use super::instant::{GuaranteedInterval, Instant, InterfaceOptions, OutOfRange, Tangent};
use super::load::LoadInterface;
use super::mesh::MeshInterface;
use super::nonlinear_bearing::NonlinearInterface;
use super::{Connection, Direction, Row};
use crate::mesh::{Contact, ContactMode, Overlap};

/// A connection in a run.
#[derive(Clone, Debug)]
pub enum Interface {
    /// A pair of gears.
    Mesh(Box<MeshInterface>),
    /// A bearing whose coefficients depend on the speed, in a run at a changing speed.
    Bearing(Box<BearingInterface>),
    /// An oil film or rolling elements.
    Nonlinear(Box<NonlinearInterface>),
    /// A load that depends on time, angle or speed.
    Load(Box<LoadInterface>),
    /// A bow that turns with the twist.
    Bow(Box<BowInterface>),
}

impl Interface {
    /// Creates the interface of a connection.
    ///
    /// # Errors
    /// [`Overlap`] of the base circles at the reference.
    pub fn new(connection: Connection<'_>, options: InterfaceOptions<'_>) -> Result<Self, Overlap> {
        match connection {
            Connection::Mesh(index, mesh, sigma) => {
                MeshInterface::new(index, mesh, sigma, options).map(|interface| Self::Mesh(Box::new(interface)))
            }
            Connection::Bearing(bearing) => Ok(Self::Bearing(Box::new(BearingInterface::new(bearing, options)))),
            Connection::Nonlinear(bearing) => Ok(Self::Nonlinear(Box::new(NonlinearInterface::new(bearing, options)))),
            Connection::Load(load) => Ok(Self::Load(Box::new(LoadInterface::new(load, options)))),
            Connection::Bow(bow) => Ok(Self::Bow(Box::new(BowInterface::new(bow, options)))),
        }
    }

    /// The interface of a mesh. No other connection has flanks.
    #[inline(always)]
    fn of_mesh(&self) -> Option<&MeshInterface> {
        match self {
            Self::Mesh(interface) => Some(interface),
            Self::Bearing(_) | Self::Nonlinear(_) | Self::Load(_) | Self::Bow(_) => None,
        }
    }

    /// Index of the mesh, if it is one.
    #[inline(always)]
    pub fn mesh(&self) -> Option<usize> {
        self.of_mesh().map(|interface| interface.mesh)
    }

    /// Index in [`Model::turning_ratio`](crate::model::Model::turning_ratio) of the angle and speed on which it depends; none
    /// for a mesh, which depends on two shafts.
    #[inline(always)]
    pub fn turning(&self) -> Option<usize> {
        match self {
            Self::Mesh(_) => None,
            Self::Bearing(interface) => Some(interface.bearing.turning),
            Self::Nonlinear(interface) => Some(interface.bearing.turning),
            Self::Load(interface) => Some(interface.load.shaft),
            Self::Bow(interface) => Some(interface.bow.turning),
        }
    }

    /// Number of scalars.
    #[inline(always)]
    pub fn scalars(&self) -> usize {
        match self {
            Self::Mesh(interface) => interface.scalars(),
            Self::Bearing(_) => 2,
            Self::Nonlinear(interface) => interface.scalars(),
            Self::Load(interface) => interface.load.rows.len(),
            Self::Bow(interface) => interface.bow.rows.len(),
        }
    }

    /// Whether the load depends on the rates of the scalars as well.
    pub fn has_rates(&self) -> bool {
        match self {
            Self::Mesh(interface) => interface.has_rates(),
            Self::Bearing(_) | Self::Nonlinear(_) => true,
            Self::Load(interface) => interface.has_rates(),
            Self::Bow(_) => false,
        }
    }

    /// Whether the load is an affine function of one scalar, for a given contact mode and time.
    pub fn is_affine(&self) -> bool {
        match self {
            Self::Mesh(interface) => interface.is_affine(),
            Self::Bearing(_) | Self::Nonlinear(_) | Self::Bow(_) => false,
            Self::Load(interface) => interface.is_affine(),
        }
    }

    /// Every scalar as entries (index, coefficient) over the displacements of the model; a load on it acts on the same
    /// coordinates with the same coefficients.
    pub fn rows(&self) -> Vec<Row> {
        match self {
            Self::Mesh(interface) => interface.rows(),
            Self::Bearing(interface) => interface.bearing.rows.to_vec(),
            Self::Nonlinear(interface) => interface.rows(),
            Self::Load(interface) => interface.load.rows.clone(),
            Self::Bow(interface) => interface.bow.rows.to_vec(),
        }
    }

    /// Generalised forces on the scalars at the reference and at rest: the mean over the angle for a mesh or rolling elements;
    /// for a bearing without the coefficients at its operating point.
    pub fn reference_force(&self) -> &[f64] {
        match self {
            Self::Mesh(interface) => interface.reference_force(),
            Self::Bearing(interface) => &interface.reference_force,
            Self::Nonlinear(interface) => &interface.reference_force,
            Self::Load(interface) => &interface.reference_force,
            Self::Bow(interface) => &interface.reference_force,
        }
    }

    /// Number d of [`Self::directions`].
    #[inline(always)]
    pub fn direction_count(&self) -> usize {
        match self {
            Self::Mesh(_) => 1,
            Self::Bow(_) => 0,
            Self::Bearing(_) | Self::Nonlinear(_) | Self::Load(_) => self.scalars(),
        }
    }

    /// The d directions over the scalars in which the load changes with the motion: for a mesh the gradient of the
    /// deflection, for another connection every scalar, for a bow none.
    pub fn directions(&self) -> Vec<Direction> {
        match self {
            Self::Mesh(interface) => vec![interface.direction()],
            Self::Bow(_) => Vec::new(),
            // The energy of the linear motion contains the stiffness of bearings, and a load has none.
            Self::Bearing(_) | Self::Nonlinear(_) | Self::Load(_) => Direction::of_scalars(self.scalars()),
        }
    }

    /// Writes the load on every scalar at deviations `u` and their `rates` (empty where [`Self::has_rates`] is false)
    /// into `load`; returns the contact. With the load −Σ g_i f_i along the directions g_i, `tangent` receives the derivatives of
    /// the f_i, less those that the linear motion contains.
    ///
    /// # Errors
    /// [`OutOfRange`] where base circles overlap or a journal touches its bearing.
    #[inline(always)]
    pub fn load(
        &self,
        instant: &Instant,
        u: &[f64],
        rates: &[f64],
        load: &mut [f64],
        tangent: Option<Tangent<'_>>,
    ) -> Result<Contact, OutOfRange> {
        match self {
            Self::Mesh(interface) => return Ok(interface.load(instant, u, rates, load, tangent)?),
            Self::Bearing(interface) => interface.load(instant, u, rates, load, tangent),
            Self::Nonlinear(interface) => interface.load(instant, u, rates, load, tangent)?,
            Self::Load(interface) => interface.load(instant, rates, load, tangent),
            Self::Bow(interface) => interface.load(instant, u, load),
        }
        Ok(Contact::default())
    }

    /// Interval in which the flanks of a mesh keep the state that they have in `contact`; infinite for another connection.
    pub fn guaranteed_interval(&self, contact_mode: &ContactMode, contact: &Contact) -> GuaranteedInterval {
        let never = GuaranteedInterval { time: f64::INFINITY, frequency: 0.0 };
        self.of_mesh().map_or(never, |interface| interface.guaranteed_interval(contact_mode.flank, contact))
    }

    /// Distances of the drive flank and of the back flank of a mesh from a change of the contact mode, m; infinite for another
    /// connection. A distance is positive
    /// while the flank keeps its state; for a pressed flank it is the remaining deflection.
    pub fn margins(&self, contact_mode: &ContactMode, contact: &Contact) -> [f64; 2] {
        self.of_mesh().map_or([f64::INFINITY; 2], |interface| interface.margins(contact_mode.flank, contact))
    }

    /// The contact mode at deviations `u` and their `rates`; none if the connection has no contact modes. Flanks that are
    /// `unchanged` keep their state.
    ///
    /// # Errors
    /// [`Overlap`] of the base circles.
    pub fn contact_mode(
        &self,
        instant: &Instant,
        u: &[f64],
        rates: &[f64],
        unchanged: bool,
    ) -> Result<Option<ContactMode>, Overlap> {
        self.of_mesh().map(|interface| interface.contact_mode(instant, u, rates, unchanged)).transpose()
    }

    /// Appends the ends of the path of contact of a mesh with sharp engagement, in base pitches, to `ends`: each with the tooth
    /// pair that is the first or the last in contact, flank by flank. Another connection has none.
    ///
    /// # Errors
    /// [`Overlap`] of the base circles.
    pub fn ends(&self, instant: &Instant, u: &[f64], ends: &mut Vec<(f64, i64)>) -> Result<(), Overlap> {
        self.of_mesh().map_or(Ok(()), |interface| interface.ends(instant, u, ends))
    }
}
