//! A connection in a run: the loads that act on the linear motion through its scalars.
//!
//! The linear motion may contain the linear part of a connection. Deviations are measured from a reference: the static
//! equilibrium, if it exists. A load is the force of the connection minus its force at the reference and minus the
//! linear part that the motion contains.

use super::instant::{GuaranteedInterval, Instant, InterfaceOptions};
use super::mesh::MeshInterface;
use super::{Connection, Row, Spring};
use crate::mesh::{Contact, ContactMode, Overlap};

/// A connection in a run.
#[derive(Clone, Debug)]
pub enum Interface {
    /// A pair of gears.
    Mesh(Box<MeshInterface>),
    /// A spring with a cubic term.
    Spring(SpringInterface),
}

/// A spring in a run.
#[derive(Clone, Debug)]
pub struct SpringInterface {
    spring: Spring,
    /// Scalar u at the reference, m, and generalised force −F at the reference, N.
    reference: f64,
    reference_force: f64,
    /// Stiffness, N/m, and damping, N s/m, that the linear motion contains.
    contained: [f64; 2],
}

impl Interface {
    /// Creates the interface of a connection; none if the linear motion contains the connection at a constant speed.
    ///
    /// # Errors
    /// [`Overlap`] of the base circles at the reference.
    pub fn new(connection: Connection<'_>, options: InterfaceOptions<'_>) -> Result<Option<Self>, Overlap> {
        match connection {
            Connection::Mesh(index, mesh, sigma) => {
                MeshInterface::new(index, mesh, sigma, options).map(|interface| Some(Self::Mesh(Box::new(interface))))
            }
            // A run in modal coordinates has a constant speed.
            Connection::Bearing(_) => Ok(None),
            Connection::Spring(spring) => Ok(Some(Self::Spring(SpringInterface::new(spring, options)))),
        }
    }

    /// Index of the mesh, if it is one.
    #[inline(always)]
    pub fn mesh(&self) -> Option<usize> {
        match self {
            Self::Mesh(interface) => Some(interface.mesh),
            Self::Spring(_) => None,
        }
    }

    /// Number of scalars.
    #[inline(always)]
    pub fn scalars(&self) -> usize {
        match self {
            Self::Mesh(interface) => interface.scalars(),
            Self::Spring(_) => 1,
        }
    }

    /// Whether the load depends on the rates of the scalars as well.
    pub fn has_rates(&self) -> bool {
        match self {
            Self::Mesh(interface) => interface.has_rates(),
            Self::Spring(interface) => interface.spring.damping != interface.contained[1],
        }
    }

    /// Whether the load is an affine function of one scalar, for a given contact mode and time.
    pub fn is_affine(&self) -> bool {
        match self {
            Self::Mesh(interface) => interface.is_affine(),
            Self::Spring(interface) => interface.spring.cubic == 0.0 && !self.has_rates(),
        }
    }

    /// Every scalar as entries (index, coefficient) over the displacements of the model; a load on it acts on the same
    /// coordinates with the same coefficients.
    pub fn rows(&self) -> Vec<Row> {
        match self {
            Self::Mesh(interface) => interface.rows(),
            Self::Spring(interface) => interface.spring.rows(),
        }
    }

    /// Generalised forces on the scalars at the reference.
    pub fn reference_force(&self) -> &[f64] {
        match self {
            Self::Mesh(interface) => interface.reference_force(),
            Self::Spring(interface) => std::slice::from_ref(&interface.reference_force),
        }
    }

    /// Direction of the deflection over the scalars, shape (r,), and the linear stiffness along it, N/m.
    pub fn tangent(&self) -> (&[f64], f64) {
        match self {
            Self::Mesh(interface) => interface.tangent(),
            Self::Spring(interface) => (&[1.0], interface.spring.stiffness),
        }
    }

    /// Writes the load on every scalar at deviations `u` and their `rates` (empty where [`Self::has_rates`] is false)
    /// into `load`; returns the contact.
    ///
    /// # Errors
    /// [`Overlap`] of the base circles.
    #[inline(always)]
    pub fn load(&self, instant: &Instant, u: &[f64], rates: &[f64], load: &mut [f64]) -> Result<Contact, Overlap> {
        match self {
            Self::Mesh(interface) => interface.load(instant, u, rates, load),
            Self::Spring(interface) => Ok(interface.load(u, rates, load)),
        }
    }

    /// Stiffness [N/m] and damping [N s/m] along the deflection in a contact that the linear motion does not contain.
    #[inline(always)]
    pub fn residual_tangent(&self, contact_mode: &ContactMode, contact: &Contact) -> [f64; 2] {
        match self {
            Self::Mesh(interface) => interface.residual_tangent(contact_mode.flank, contact),
            Self::Spring(SpringInterface { spring, contained: [stiffness, damping], .. }) => {
                [contact.stiffness - stiffness, spring.damping - damping]
            }
        }
    }

    /// Interval in which the flanks keep the state that they have in `contact`.
    pub fn guaranteed_interval(&self, contact_mode: &ContactMode, contact: &Contact) -> GuaranteedInterval {
        match self {
            Self::Mesh(interface) => interface.guaranteed_interval(contact_mode.flank, contact),
            Self::Spring(_) => GuaranteedInterval { time: f64::INFINITY, frequency: 0.0 },
        }
    }

    /// Distances of the drive flank and of the back flank from a change of the contact mode, m. A distance is positive
    /// while the flank keeps its state; for a pressed flank it is the remaining deflection.
    pub fn margins(&self, contact_mode: &ContactMode, contact: &Contact) -> [f64; 2] {
        match self {
            Self::Mesh(interface) => interface.margins(contact_mode.flank, contact),
            Self::Spring(_) => [f64::INFINITY; 2],
        }
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
        match self {
            Self::Mesh(interface) => interface.contact_mode(instant, u, rates, unchanged).map(Some),
            Self::Spring(_) => Ok(None),
        }
    }

    /// Appends the ends of the path of contact, in base pitches among the tooth pairs with sharp engagement, to `ends`:
    /// each with the pair that is the first or the last in contact, flank by flank.
    ///
    /// # Errors
    /// [`Overlap`] of the base circles.
    pub fn ends(&self, instant: &Instant, u: &[f64], ends: &mut Vec<(f64, i64)>) -> Result<(), Overlap> {
        match self {
            Self::Mesh(interface) => interface.ends(instant, u, ends),
            Self::Spring(_) => Ok(()),
        }
    }
}

impl SpringInterface {
    fn new(spring: &Spring, options: InterfaceOptions<'_>) -> Self {
        let reference = spring.scalar(options.reference);
        let contained = if options.contained { [spring.stiffness, spring.damping] } else { [0.0; 2] };
        let reference_force = -spring.contact(reference, 0.0).force;
        Self { spring: spring.clone(), reference, reference_force, contained }
    }

    #[inline(always)]
    fn load(&self, u: &[f64], rates: &[f64], load: &mut [f64]) -> Contact {
        let (u, rate) = (u[0], rates.first().copied().unwrap_or(0.0));
        let contact = self.spring.contact(self.reference + u, rate);
        load[0] = (-contact.force - self.reference_force) + self.contained[0] * u + self.contained[1] * rate;
        contact
    }
}
