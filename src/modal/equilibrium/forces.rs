//! Forces on every coordinate of a system at rest, and what they leave unbalanced on every shaft, support and housing.

use std::borrow::Cow;

use nalgebra::{DMatrix, DVector};

use super::clearance::TangentPart;
use super::{EquilibriumError, EquilibriumSpeeds};
use crate::connection::{BearingTangent, Connection, NonlinearBearing, Row};
use crate::linalg::ChainMatrix;
use crate::mesh::{Flank, Geometry};
use crate::model::{Dof, DofKind, Model};
use crate::numerics::SUM_ROUND_OFF;

/// Load of a shaft, relative to the largest load of all, below which it is the round-off of other loads.
const LEAST_LOAD: f64 = 1e-6;

/// The flanks in contact of every mesh.
#[derive(Clone, Copy)]
pub(super) enum Contacts<'a> {
    /// These flanks carry, also if they pull.
    Given(&'a [Flank]),
    /// A flank with backlash carries if it is pressed.
    Pressed,
}

/// The laws of the nonlinear bearings.
#[derive(Clone, Copy)]
pub(super) enum Laws<'a> {
    /// Films and rolling elements.
    Exact,
    /// Their tangents, one for each.
    Tangents(&'a [BearingTangent]),
}

/// The tangent of a bearing that is a spring with its initial stiffness in every direction.
pub(super) fn elastic_tangent(bearing: &NonlinearBearing) -> BearingTangent {
    let n = bearing.rows.len();
    BearingTangent {
        displacement: DVector::zeros(n),
        force: DVector::zeros(n),
        stiffness: bearing.initial_stiffness * DMatrix::identity(n, n),
    }
}

/// The tangent where a bearing carries the force that the tangent `from` has at scalars u; none if it cannot carry it.
pub(super) fn tangent_towards(
    from: &BearingTangent,
    u: &DVector<f64>,
    bearing: &NonlinearBearing,
    speed: f64,
) -> Option<BearingTangent> {
    if bearing.is_squeeze() {
        return Some(BearingTangent { displacement: u.clone(), ..elastic_tangent(bearing) });
    }
    bearing.carrying(&force_at(from, u), speed).ok()
}

/// Force of a tangent at scalars u, N.
fn force_at(tangent: &BearingTangent, u: &DVector<f64>) -> DVector<f64> {
    &tangent.force + &tangent.stiffness * (u - &tangent.displacement)
}

/// What a coordinate belongs to.
#[derive(Clone, Copy)]
struct Place {
    /// Index of the shaft or, after the shafts, of the support or housing.
    body: usize,
    /// Motion that the coordinate describes.
    kind: DofKind,
    /// Length by which a moment is divided, m: that of the shaft, or that of the longest shaft for a housing; 1 for a force.
    length: f64,
    /// Distance of the node from the middle of its shaft along the axis, m.
    lever: f64,
    /// Whether it belongs to a node, not to the inside of an element.
    is_nodal: bool,
}

/// Shafts, supports and housings, on each of which the forces balance.
pub(super) struct Bodies {
    /// The place of every coordinate, n entries in the order of the core.
    places: Vec<Place>,
    /// Number of shafts, supports and housings.
    count: usize,
}

impl Bodies {
    pub(super) fn new(model: &Model) -> Self {
        let shafts = &model.scene.shafts;
        let longest = shafts.iter().map(|shaft| shaft.length()).fold(0.0, f64::max);
        let place = |dof: &Dof| {
            let shaft = shafts.get(dof.node.shaft);
            let length = shaft.map_or(longest, |shaft| shaft.length());
            let lever = shaft.map_or(0.0, |shaft| shaft.nodes[dof.node.node] - (shaft.nodes[0] + length / 2.0));
            let is_force = matches!(dof.kind, DofKind::V | DofKind::W | DofKind::Axial | DofKind::Mode);
            let length = if is_force { 1.0 } else { length };
            Place {
                body: dof.node.shaft,
                kind: dof.kind,
                length,
                lever,
                is_nodal: dof.degree.is_none() || dof.kind == DofKind::Mode,
            }
        };
        let mut dofs: Vec<&Dof> = model.numbering.dofs().iter().collect();
        dofs.sort_by_key(|dof| dof.index);
        Self { places: dofs.into_iter().map(place).collect(), count: shafts.len() + model.scene.housings.len() }
    }

    /// Largest displacement, rotations times the length of their shaft, m.
    pub(super) fn size(&self, q: &DVector<f64>) -> f64 {
        q.iter().zip(&self.places).map(|(q, place)| q.abs() * place.length).fold(0.0, f64::max)
    }

    /// The load of every body, N: the sum of the absolute forces that act on its nodes, moments over its length. It is at
    /// least [`LEAST_LOAD`] of the largest one.
    pub(super) fn loads(&self, forces: &Forces) -> Vec<f64> {
        let mut loads = vec![0.0; self.count];
        for (size, place) in forces.acting.iter().zip(&self.places).filter(|(_, place)| place.is_nodal) {
            loads[place.body] += size / place.length;
        }
        let least = LEAST_LOAD * loads.iter().copied().fold(0.0, f64::max);
        loads.iter().map(|load| load.max(least)).collect()
    }

    /// Sum of the absolute unbalanced forces of `residual` on a body, moments over its length, relative to its load; the largest
    /// one of all bodies.
    pub(super) fn norm(&self, forces: &Forces, residual: &DVector<f64>, loads: &[f64]) -> f64 {
        let mut sums = vec![0.0; self.count];
        for (i, place) in self.places.iter().enumerate() {
            sums[place.body] += (residual[i].abs() - forces.round_off[i]).max(0.0) / place.length;
        }
        sums.iter().zip(loads).map(|(sum, load)| ratio(*sum, *load)).fold(0.0, f64::max)
    }

    /// Largest unbalanced force, or moment over the length, of every body over its load: of the forces at each of its
    /// coordinates, and of the sums of forces and moments over the body, in which its elastic forces cancel.
    pub(super) fn residuals(&self, forces: &Forces) -> Vec<f64> {
        let loads = self.loads(forces);
        let mut largest = vec![0.0_f64; self.count];
        // Forces along x, y, z and moments about them.
        let mut sums = vec![[0.0; 6]; self.count];
        let mut lengths = vec![0.0_f64; self.count];
        let residual = forces.residual();
        for (i, place) in self.places.iter().enumerate() {
            let excess = (residual[i].abs() - forces.round_off[i]).max(0.0) / place.length;
            largest[place.body] = largest[place.body].max(excess);
            if !place.is_nodal {
                continue;
            }
            let (sums, force) = (&mut sums[place.body], forces.external[i]);
            match place.kind {
                DofKind::Axial => sums[0] += force,
                DofKind::V => {
                    sums[1] += force;
                    sums[5] += place.lever * force;
                }
                DofKind::W => {
                    sums[2] += force;
                    // The coordinate is −B.
                    sums[4] += place.lever * force;
                }
                DofKind::Twist => sums[3] += force,
                DofKind::B => sums[4] += force,
                DofKind::Gamma => sums[5] += force,
                // Elastic forces of a housing balance mode by mode.
                DofKind::Mode => {}
            }
            lengths[place.body] = lengths[place.body].max(place.length);
        }
        let body = |body: usize| {
            let sum = |axis: usize| sums[body][axis].abs() / if axis < 3 { 1.0 } else { lengths[body] };
            ratio((0..6).map(sum).fold(largest[body], f64::max), loads[body])
        };
        (0..self.count).map(body).collect()
    }
}

/// An unbalanced force over a load; zero if nothing is unbalanced.
fn ratio(unbalanced: f64, load: f64) -> f64 {
    if unbalanced == 0.0 { 0.0 } else { unbalanced / load }
}

/// Generalised forces on every coordinate, n entries each in the order of the core, N or N m.
pub(super) struct Forces {
    /// Loads, forces of bearings, links, meshes and other connections on the shafts, and moments of axial forces.
    pub external: DVector<f64>,
    /// Sum of the absolute terms of `external`.
    acting: DVector<f64>,
    /// Elastic forces of the shafts on their nodes.
    elastic: DVector<f64>,
    /// What the round-off of q may change in `elastic` and in the mesh forces.
    round_off: DVector<f64>,
}

/// A model at rest at a speed.
pub(super) struct AtRest<'m> {
    /// The model without coefficients of its nonlinear bearings: their forces do not depend on these.
    pub model: Cow<'m, Model>,
    /// Whether the lines of action follow the centres of the gears.
    pub geometry: Geometry,
    /// Speeds of films and flanks.
    pub speeds: EquilibriumSpeeds,
    /// What the coordinates belong to.
    pub bodies: Bodies,
    /// Given loads, weights, and loads that depend on the speed, n entries each.
    loads: [DVector<f64>; 3],
    /// The part of the loads that acts.
    pub load_factor: f64,
}

impl<'m> AtRest<'m> {
    pub(super) fn new(model: &'m Model, geometry: Geometry, speeds: EquilibriumSpeeds) -> Self {
        let model = if model.nonlinear_bearings.is_empty() {
            Cow::Borrowed(model)
        } else {
            Cow::Owned(model.clone().without_operating_points())
        };
        let loads = [model.given_load(), model.weight(), model.speed_loads(speeds.flanks)];
        Self { bodies: Bodies::new(&model), model, geometry, speeds, loads, load_factor: 1.0 }
    }

    /// The forces at displacements q. Calls `visit` with the tangent of the connections, which is complete for given flanks.
    ///
    /// # Errors
    /// [`EquilibriumError::Overlap`] of base circles.
    pub(super) fn forces(
        &self,
        contacts: Contacts<'_>,
        laws: Laws<'_>,
        q: &DVector<f64>,
        visit: &mut dyn FnMut(TangentPart),
    ) -> Result<Forces, EquilibriumError> {
        let zero = || DVector::zeros(q.len());
        let mut forces = Forces { external: zero(), acting: zero(), elastic: zero(), round_off: zero() };
        for load in &self.loads {
            load.iter().enumerate().for_each(|(index, force)| forces.add(index, self.load_factor * force));
        }
        forces.add_elements(&self.model, q.as_slice());
        forces.add_connections(self, contacts, laws, q.as_slice(), visit)?;
        forces.add_elastic(&self.model, q.as_slice());
        Ok(forces)
    }
}

impl AtRest<'_> {
    /// Largest unbalanced force, or moment over the length, of every body over its load, with the flanks that are pressed.
    ///
    /// # Errors
    /// [`EquilibriumError::Overlap`] of base circles.
    pub(super) fn residuals(&self, q: &DVector<f64>) -> Result<Vec<f64>, EquilibriumError> {
        Ok(self.bodies.residuals(&self.forces(Contacts::Pressed, Laws::Exact, q, &mut |_| {})?))
    }
}

impl Forces {
    /// Unbalanced forces.
    pub(super) fn residual(&self) -> DVector<f64> {
        &self.external + &self.elastic
    }

    fn add(&mut self, index: usize, force: f64) {
        self.external[index] += force;
        self.acting[index] += force.abs();
    }

    fn add_over(&mut self, row: &Row, force: f64) {
        row.iter().for_each(|(index, factor)| self.add(*index, factor * force));
    }

    /// Bearings with constant coefficients and links.
    fn add_elements(&mut self, model: &Model, q: &[f64]) {
        for support in &model.supports {
            let [y, z] = support.elastic_force(q);
            self.add(support.index, -y);
            self.add(support.index + 1, -z);
        }
        for link in &model.links {
            let fixed = link.rest.map(|rest| rest.fixed).unwrap_or_default();
            let [y, z] = link.scalars(q);
            let force = link.local.elastic_force(&[y - fixed.re, z - fixed.im]);
            for (row, force) in link.rows.iter().zip(force) {
                self.add_over(row, -force);
            }
        }
    }

    fn add_connections(
        &mut self,
        AtRest { model, geometry, speeds, .. }: &AtRest<'_>,
        contacts: Contacts<'_>,
        laws: Laws<'_>,
        q: &[f64],
        visit: &mut dyn FnMut(TangentPart),
    ) -> Result<(), EquilibriumError> {
        let mut bearings = 0;
        for connection in model.connections(speeds.flanks) {
            let (rows, (known, derivative)) = match connection {
                Connection::Mesh(index, mesh, sigma) => {
                    for back in [false, true] {
                        let is_given = match contacts {
                            Contacts::Given(flanks) if back => flanks[index].holds_back(),
                            Contacts::Given(flanks) => flanks[index].drives(),
                            Contacts::Pressed => !back || mesh.backlash.is_some(),
                        };
                        if !is_given {
                            continue;
                        }
                        let (pressed, directions) = mesh
                            .mean_tangent(*geometry, sigma, back, q, |row, column, value| {
                                visit(TangentPart::Entry(row, column, value))
                            })
                            .map_err(|overlap| EquilibriumError::overlap(model, index, overlap))?;
                        let pulls = matches!(contacts, Contacts::Pressed) && mesh.backlash.is_some() && pressed < 0.0;
                        let pressed = if pulls { 0.0 } else { pressed };
                        let sigma = if back { -sigma } else { sigma };
                        // Round-off of the deflection, a sum of much larger displacements.
                        let mut terms = 0.0;
                        mesh.gradient(sigma, &directions, |row, slope| terms += (slope * q[row]).abs());
                        let round_off = SUM_ROUND_OFF * mesh.stiffness * terms;
                        mesh.gradient(sigma, &directions, |row, slope| {
                            self.add(row, -pressed * slope);
                            self.round_off[row] += round_off * slope.abs();
                        });
                    }
                    continue;
                }
                // Loads over the speed have their value at this speed; other loads and bows no mean part. A model at a speed has
                // the coefficients of its tables in the matrices.
                Connection::Load(_) | Connection::Bow(_) | Connection::Bearing(_) => continue,
                Connection::Nonlinear(bearing) => {
                    let known = match laws {
                        Laws::Exact => bearing.static_tangent(speeds.film, q),
                        Laws::Tangents(tangents) => {
                            let tangent: &BearingTangent = &tangents[bearings];
                            (force_at(tangent, &bearing.scalar_vector(q)), tangent.stiffness.clone())
                        }
                    };
                    bearings += 1;
                    (&bearing.rows[..], known)
                }
            };
            rows.iter().zip(known.iter()).for_each(|(row, force)| self.add_over(row, -force));
            visit(TangentPart::Form(rows.to_vec(), derivative));
        }
        Ok(())
    }

    /// Elastic forces from strains, which avoid the round-off of rigid motions: these are much larger in soft bearings.
    fn add_elastic(&mut self, model: &Model, q: &[f64]) {
        for shaft in &model.shafts {
            if let Some(chain) = &shaft.bending {
                chain.subtract_elastic::<2>(&q[chain.start..], &mut self.elastic.as_mut_slice()[chain.start..]);
                self.add_round_off::<2, 2>(&chain.stiffness, chain.start, q);
                if let Some(geometric) = &shaft.geometric {
                    // The axial forces on a shaft keep their direction: about a tilted shaft they have a moment from outside.
                    let mut force = vec![0.0; chain.coordinates::<2>().len()];
                    geometric.multiply_add::<2>(-1.0, &q[chain.start..], &mut force);
                    for (index, force) in chain.coordinates::<2>().zip(force) {
                        self.external[index] += force;
                        self.elastic[index] -= force;
                    }
                }
            }
            for chain in shaft.rods() {
                chain.subtract_elastic::<1>(&q[chain.start..], &mut self.elastic.as_mut_slice()[chain.start..]);
                self.add_round_off::<1, 1>(&chain.stiffness, chain.start, q);
            }
        }
        if let Some(speed) = model.circulation {
            model.visit_circulation_per_speed(&mut |row, column, value| self.elastic[row] -= speed * value * q[column]);
            // Centrifugal forces do not balance within a shaft.
            model.visit_frames(speed, &mut |row, column, value| self.add(row, -value * q[column]));
        }
    }

    /// Adds the round-off of K q for a chain whose unknowns have `L` lanes.
    fn add_round_off<const B: usize, const L: usize>(&mut self, stiffness: &ChainMatrix<B>, start: usize, q: &[f64]) {
        stiffness.for_each(|row, column, value| {
            for lane in 0..L {
                let part = SUM_ROUND_OFF * value.abs() * q[start + L * column + lane].abs();
                self.round_off[start + L * row + lane] += part;
            }
        });
    }
}
