//! Static equilibrium under torques, gravity and the forces of meshes and bearings, by Newton's method with the exact tangent.
//!
//! Each step solves one system with sparse factors, in time proportional to n. The solution contains no
//! null motion (motion without elastic force, for example the rigid-body rotation), in the inner product of the mass
//! matrix. A load that drives a null motion has no equilibrium.

use nalgebra::DVector;

use thiserror::Error;

mod clearance;
mod forces;
mod refusals;

use self::clearance::{TangentPart, check_journals, check_tilts, regularisation, within_clearances};
use self::forces::{AtRest, Contacts, Forces, Laws, elastic_tangent, tangent_towards};
use self::refusals::{check_balance, check_constraints, check_rotation, unconverged};
use crate::bearing_force::MAX_RESIDUAL;
use crate::connection::BearingTangent;
use crate::film::{MAX_ECCENTRICITY_RATIO, TOUCHING_RATIO};
use crate::linalg::{CoupledChains, CoupledFactors, DecompositionError};
use crate::mesh::{Flank, Geometry, Overlap};
use crate::modal::undamped::{Pins, null_motions};
use crate::model::{Model, Weights};
use crate::numerics::EQUALITY_TOLERANCE;
use crate::scene::SceneError;

/// Largest displacement of a Newton step, relative to the largest displacement, below which the iteration has converged.
const CONVERGENCE_TOLERANCE: f64 = 1e-13;
/// The same limit for steps that have stopped to decrease, because of round-off in stiff scenes.
const STALL_TOLERANCE: f64 = 1e-7;
/// Ratio of the norms of the unbalanced forces after and before a step above which the tangent is computed anew.
const TANGENT_REUSE_RATIO: f64 = 1e-2;
/// Part of a step by which the distance from the equilibrium must decrease (Deuflhard, algorithm NLEQ-ERR).
const SUFFICIENT_APPROACH: f64 = 0.25;
/// Power of the unbalanced forces along a step at its end, relative to that at its begin, above which the step is doubled.
const UNFINISHED_DRIVE: f64 = 0.5;
/// Smallest fraction of a Newton step.
const LEAST_FRACTION: f64 = 1e-6;
/// Largest number of iterations for the displacements with which Newton's method starts.
const MAX_START_ITERATIONS: usize = 20;
/// Distance of a nonlinear bearing from where it carries its force, relative to its displacement, below which Newton's
/// method starts.
const START_TOLERANCE: f64 = 0.03;
/// Smallest increment of the part of the load that acts.
const LEAST_LOAD_INCREMENT: f64 = 1.0 / 128.0;
/// Largest number of iterations. A smooth problem takes three to five, a loaded journal or rolling bearing up to twenty.
const MAX_ITERATIONS: usize = 60;

/// The reason why there is no equilibrium.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum EquilibriumError {
    /// The loads have no equilibrium.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The base circles of a mesh overlap.
    #[error("base circles overlap")]
    Overlap {
        /// Names of the driving and the driven gear.
        gears: [String; 2],
        /// Distance of the centres and base radii.
        overlap: Overlap,
    },
    /// The iteration did not converge, or left forces unbalanced.
    #[error("{0}")]
    Convergence(String),
    /// A decomposition fails.
    #[error(transparent)]
    Decomposition(#[from] DecompositionError),
}

impl EquilibriumError {
    /// Overlap of the base circles of the mesh with this index.
    fn overlap(model: &Model, mesh: usize, overlap: Overlap) -> Self {
        Self::Overlap { gears: model.gear_names(mesh).map(str::to_owned), overlap }
    }
}

/// Speeds of the reference shaft, rad/s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EquilibriumSpeeds {
    /// The speed of nonlinear bearings.
    pub film: f64,
    /// The speed of torques over the speed, which also determines the flanks in contact.
    pub flanks: f64,
}

impl From<f64> for EquilibriumSpeeds {
    fn from(speed: f64) -> Self {
        Self { film: speed, flanks: speed }
    }
}

/// Displacements q of the equilibrium. `model` belongs to the speed of its nonlinear bearings. Bow and unbalance rotate and are not included.
///
/// # Errors
/// [`EquilibriumError`] if the load has no equilibrium, base circles overlap, a journal touches or carries no load, the
/// iteration fails, or its result leaves a force unbalanced.
pub fn equilibrium(
    model: &Model,
    geometry: Geometry,
    speeds: EquilibriumSpeeds,
) -> Result<DVector<f64>, EquilibriumError> {
    let speed = speeds.flanks;
    model.check_speed(speed)?;
    let load = &model.constant_load + model.speed_loads(speed);
    let null = null_motions(model, speed)?;
    check_balance(model, &null, &load, speed)?;
    let mut search = Search::new(AtRest::new(model, geometry, speeds), Pins::new(model, &null));
    let q = search.run(&load).map_err(|error| check_rotation(model, speeds.film, error))?;
    let residuals = search.at_rest.residuals(&q)?;
    if residuals.iter().all(|residual| *residual <= MAX_RESIDUAL) { Ok(q) } else { Err(unconverged(model, &residuals)) }
}

/// Largest unbalanced force, or moment over the length, of every shaft and then of every support and housing over its load,
/// at displacements q; see `forces::Bodies::residuals`.
///
/// # Errors
/// [`EquilibriumError::Overlap`] of base circles.
pub fn equilibrium_residuals(
    model: &Model,
    geometry: Geometry,
    speeds: EquilibriumSpeeds,
    q: &DVector<f64>,
) -> Result<Vec<f64>, EquilibriumError> {
    AtRest::new(model, geometry, speeds).residuals(q)
}

/// What a change of the forces does to an equilibrium.
pub struct EquilibriumChange<'m> {
    search: Search<'m>,
    q: DVector<f64>,
}

impl<'m> EquilibriumChange<'m> {
    /// Changes of the equilibrium q of a model, with the arguments of [`equilibrium`].
    ///
    /// # Errors
    /// [`EquilibriumError`] if the null motions cannot be found.
    pub fn new(
        model: &'m Model,
        geometry: Geometry,
        speeds: EquilibriumSpeeds,
        q: DVector<f64>,
    ) -> Result<Self, EquilibriumError> {
        let null = null_motions(model, speeds.flanks)?;
        Ok(Self { search: Search::new(AtRest::new(model, geometry, speeds), Pins::new(model, &null)), q })
    }

    /// Unbalanced forces at q of the equilibrium of another model, N and N m.
    ///
    /// # Errors
    /// [`EquilibriumError::Overlap`] of base circles.
    pub fn unbalanced(&self) -> Result<DVector<f64>, EquilibriumError> {
        Ok(self.search.at_rest.forces(Contacts::Pressed, Laws::Exact, &self.q, &mut |_| {})?.residual())
    }

    /// q without the null motions of this model.
    pub fn without_null_motions(&self) -> DVector<f64> {
        let mut q = self.q.clone();
        self.search.pins.remove_null_motions(&mut q);
        q
    }

    /// Changes of q under small additional `forces`, N and N m.
    ///
    /// # Errors
    /// [`EquilibriumError`] if base circles overlap or the tangent is singular.
    pub fn under(&self, forces: &[DVector<f64>]) -> Result<Vec<DVector<f64>>, EquilibriumError> {
        let flanks = vec![Flank::Drive; self.search.at_rest.model.meshes.len()];
        let flanks = pressed_flanks(&self.search.at_rest, &flanks, &self.q)?;
        let point = self.search.at(self.q.clone(), &flanks, Laws::Exact)?;
        let factors = self.search.tangent_factors(&point.tangent, 0.0)?;
        forces.iter().map(|force| self.search.step(&factors, force)).collect()
    }
}

/// A point after a step.
struct Advance {
    next: Point,
    /// Norm of the unbalanced forces over that before the step.
    ratio: f64,
    /// Overlap of base circles after a larger fraction of the step.
    overlap: Option<EquilibriumError>,
}

/// Displacements with the forces there, for given flanks.
struct Point {
    q: DVector<f64>,
    forces: Forces,
    /// Unbalanced forces without the part that only the springs on the null motions balance.
    residual: DVector<f64>,
    /// The part that only the springs on the null motions balance.
    carried: DVector<f64>,
    /// Tangent of the connections.
    tangent: Vec<TangentPart>,
}

/// Newton's method for the equilibrium.
struct Search<'m> {
    at_rest: AtRest<'m>,
    pins: Pins,
    /// Stiffness of shafts, bearings with constant coefficients, links and pins.
    linear: CoupledChains,
}

impl<'m> Search<'m> {
    fn new(at_rest: AtRest<'m>, pins: Pins) -> Self {
        let mut linear = at_rest.model.shaft_stiffness(&Weights::stiffness());
        pins.add_to(&at_rest.model, &mut linear);
        Self { at_rest, pins, linear }
    }

    fn at(&self, q: DVector<f64>, flanks: &[Flank], laws: Laws<'_>) -> Result<Point, EquilibriumError> {
        let mut tangent = Vec::new();
        let forces = self.at_rest.forces(Contacts::Given(flanks), laws, &q, &mut |part| tangent.push(part))?;
        let residual = forces.residual();
        let carried = self.pins.carried(&residual);
        Ok(Point { q, forces, residual: residual - &carried, carried, tangent })
    }

    /// Norms of the unbalanced forces at two points over the larger loads of both.
    fn norms(&self, points: [&Point; 2]) -> [f64; 2] {
        let [a, b] = points.map(|point| self.at_rest.bodies.loads(&point.forces));
        let loads: Vec<f64> = a.iter().zip(&b).map(|(a, b)| a.max(*b)).collect();
        points.map(|point| self.at_rest.bodies.norm(&point.forces, &point.residual, &loads))
    }

    /// Displacements and flanks with which Newton's method starts: zero displacements without nonlinear bearings and backlash, and
    /// where the search fails.
    ///
    /// With nonlinear bearings, forces are better known than displacements: they are nearly those of the lever. Each iteration solves
    /// the system with the tangents of the bearings where they carry the forces found before. Thus journals stay within their
    /// clearance, and rolling elements are in contact. The flanks follow from the torques: a flank that would have to pull gives
    /// forces in another direction than the opposite one, under which there may be no equilibrium.
    fn start(&self) -> Result<(DVector<f64>, Vec<Flank>), EquilibriumError> {
        let model = &*self.at_rest.model;
        let mut zero = DVector::zeros(model.len());
        let tilts = model.nonlinear_bearings.iter().filter_map(|b| b.initial_tilt(self.at_rest.speeds.film));
        tilts.for_each(|(index, value)| zero[index] = value);
        let mut flanks = vec![Flank::Drive; model.meshes.len()];
        let bearings = &model.nonlinear_bearings;
        // Linear tangents know one equilibrium of a pad; its film has another one, in which it carries nothing.
        let has_pads = bearings.iter().any(|bearing| bearing.tilt.is_some());
        if has_pads || bearings.is_empty() && model.meshes.iter().all(|mesh| mesh.backlash.is_none()) {
            return Ok((zero, flanks));
        }
        let mut tangents: Vec<BearingTangent> = bearings.iter().map(elastic_tangent).collect();
        let mut q = zero.clone();
        for _ in 0..MAX_START_ITERATIONS {
            let point = match self.at(q.clone(), &flanks, Laws::Tangents(&tangents)) {
                Err(EquilibriumError::Overlap { .. }) => return Ok((zero, flanks)),
                other => other?,
            };
            q += self.step(&self.tangent_factors(&point.tangent, 0.0)?, &point.residual)?;
            let mut distance = 0.0;
            for (tangent, bearing) in tangents.iter_mut().zip(bearings) {
                let u = bearing.scalar_vector(q.as_slice());
                let Some(found) = tangent_towards(tangent, &u, bearing, self.at_rest.speeds.film) else {
                    return Ok((zero, flanks));
                };
                *tangent = found;
                let carrying = &tangent.displacement;
                distance = f64::max(distance, (u - carrying).norm() / carrying.norm().max(f64::MIN_POSITIVE));
            }
            let pressed = match pressed_flanks(&self.at_rest, &flanks, &q) {
                Err(EquilibriumError::Overlap { .. }) => return Ok((zero, flanks)),
                other => other?,
            };
            // Whether both flanks are pressed depends on displacements that are known better at the end of the search.
            let one = |(before, after): (&Flank, &Flank)| if *after == Flank::Both { *before } else { *after };
            let loaded: Vec<Flank> = flanks.iter().zip(&pressed).map(one).collect();
            let is_known = loaded == flanks;
            flanks = loaded;
            if distance <= START_TOLERANCE && is_known {
                break;
            }
        }
        Ok((if check_journals(model, &q, 0.0..1.0).is_ok() { q } else { zero }, flanks))
    }

    /// The equilibrium under `load`: from [`Self::start`], or where this fails, from the equilibria under parts of all loads that
    /// increase (continuation; Allgower and Georg, Numerical Continuation Methods, 1990, section 1.2). Each starts from the one
    /// before.
    fn run(&mut self, load: &DVector<f64>) -> Result<DVector<f64>, EquilibriumError> {
        let mut end = match self.newton(load, self.start()?) {
            Err(end @ (EquilibriumError::Overlap { .. } | EquilibriumError::Convergence(_))) => end,
            other => return other.map(|(q, _)| q),
        };
        let (mut part, mut increment, mut known) = (0.0, 0.5, None);
        while part < 1.0 && increment >= LEAST_LOAD_INCREMENT {
            let next = f64::min(part + increment, 1.0);
            self.at_rest.load_factor = next;
            let start = if let Some(known) = &known { Clone::clone(known) } else { self.start()? };
            match self.newton(load, start) {
                Ok(found) => (part, increment, known) = (next, 2.0 * increment, Some(found)),
                Err(EquilibriumError::Decomposition(error)) => return Err(error.into()),
                Err(error) => (end, increment) = (error, increment / 2.0),
            }
        }
        self.at_rest.load_factor = 1.0;
        match known {
            Some((q, _)) if part == 1.0 => Ok(q),
            _ => Err(end),
        }
    }

    /// Newton's method from displacements and flanks, and those that it finds.
    fn newton(
        &self,
        load: &DVector<f64>,
        (q, mut flanks): (DVector<f64>, Vec<Flank>),
    ) -> Result<(DVector<f64>, Vec<Flank>), EquilibriumError> {
        let (model, bodies) = (&*self.at_rest.model, &self.at_rest.bodies);
        let mut point = self.at(q, &flanks, Laws::Exact)?;
        let mut previous = f64::INFINITY;
        let mut factors: Option<CoupledFactors> = None;
        let mut overlap = None;
        for _ in 0..MAX_ITERATIONS {
            let [norm, _] = self.norms([&point, &point]);
            let (known, is_old) = match factors.take() {
                Some(known) => (known, true),
                None => (self.tangent_factors(&point.tangent, norm)?, false),
            };
            let step = self.step(&known, &point.residual)?;
            let size = bodies.size(&step);
            let largest = bodies.size(&point.q).max(size);
            let is_stalled = size <= STALL_TOLERANCE * largest && size >= previous / 2.0;
            if size <= CONVERGENCE_TOLERANCE * largest || is_stalled {
                let q = point.q + step;
                let pressed = pressed_flanks(&self.at_rest, &flanks, &q)?;
                let is_final = pressed == flanks;
                (flanks, previous) = (pressed, f64::INFINITY);
                point = self.at(q, &flanks, Laws::Exact)?;
                if is_final {
                    check_constraints(&point.carried, load)?;
                    check_journals(model, &point.q, EQUALITY_TOLERANCE..MAX_ECCENTRICITY_RATIO)?;
                    check_tilts(model, &point.q, self.at_rest.speeds.film)?;
                    return Ok((point.q, flanks));
                }
                continue;
            }
            previous = size;
            let advance = match self.advance(&known, &point, &flanks, &step) {
                Err(EquilibriumError::Overlap { .. }) if is_old => None,
                other => other?,
            };
            match advance {
                Some(Advance { next, ratio, overlap: met }) => {
                    overlap = met;
                    // An old tangent is used as long as the unbalanced forces decrease fast.
                    factors = (ratio <= TANGENT_REUSE_RATIO).then_some(known);
                    point = next;
                }
                // A small step of the new tangent that is as long as this one has stopped to decrease.
                None if is_old => {}
                None => break,
            }
        }
        check_journals(model, &point.q, 0.0..TOUCHING_RATIO)?;
        check_constraints(&point.carried, load)?;
        Err(match overlap {
            Some(overlap) => overlap,
            None => unconverged(model, &self.at_rest.residuals(&point.q)?),
        })
    }

    /// Newton step, without null motions.
    fn step(&self, factors: &CoupledFactors, residual: &DVector<f64>) -> Result<DVector<f64>, EquilibriumError> {
        let step =
            self.at_rest.model.solve_real(factors, 0.0, residual.as_slice()).map_err(DecompositionError::from)?;
        let mut step = DVector::from_vec(step);
        self.pins.remove_null_motions(&mut step);
        Ok(step)
    }

    /// The point after the largest fraction of a step that reduces the unbalanced forces, the distance from the equilibrium or the
    /// energy; none if no fraction does.
    ///
    /// The distance is the next step with the same factors (natural monotonicity test; Deuflhard, Newton Methods for Nonlinear
    /// Problems, 2004, section 3.3.1). Where a large motion has small curvature along stiff coordinates, forces grow on steps
    /// that come closer to the equilibrium. Forces that have a convex energy, as those of rolling elements, reduce it as long as they
    /// drive the motion along the step; such a step may be longer than that of the tangent with its regularisation.
    ///
    /// # Errors
    /// [`EquilibriumError::Overlap`] if no fraction does, and base circles overlap after the larger ones.
    fn advance(
        &self,
        factors: &CoupledFactors,
        point: &Point,
        flanks: &[Flank],
        step: &DVector<f64>,
    ) -> Result<Option<Advance>, EquilibriumError> {
        let mut fraction = within_clearances(&self.at_rest.model, &point.q, step);
        let bearings = &self.at_rest.model.nonlinear_bearings;
        let has_energy = !bearings.is_empty() && bearings.iter().all(|bearing| bearing.elements().is_some());
        // Power of the unbalanced forces on the step, over that at its begin.
        let drive = |next: &Point| next.residual.dot(step) / point.residual.dot(step);
        let mut overlap = None;
        while fraction >= LEAST_FRACTION {
            match self.at(&point.q + step * fraction, flanks, Laws::Exact) {
                Err(error @ EquilibriumError::Overlap { .. }) => overlap = Some(error),
                Err(error) => return Err(error),
                Ok(mut next) => {
                    let approaches = || -> Result<bool, EquilibriumError> {
                        let [step, left] =
                            [step, &self.step(factors, &next.residual)?].map(|q| self.at_rest.bodies.size(q));
                        Ok(left <= step * (1.0 - fraction * SUFFICIENT_APPROACH))
                    };
                    let descends = has_energy && drive(&next) >= 0.0;
                    let [before, mut after] = self.norms([point, &next]);
                    if after < before || descends || approaches()? {
                        while descends && drive(&next) >= UNFINISHED_DRIVE {
                            fraction *= 2.0;
                            next = match self.at(&point.q + step * fraction, flanks, Laws::Exact) {
                                Ok(further) if drive(&further) >= 0.0 => further,
                                _ => break,
                            };
                            [_, after] = self.norms([point, &next]);
                        }
                        return Ok(Some(Advance { next, ratio: after / before, overlap }));
                    }
                }
            }
            fraction /= 2.0;
        }
        overlap.map_or(Ok(None), Err)
    }

    /// Factors of the stiffness of shafts, bearings and pins with the tangent of the connections, where `norm` of the load is
    /// unbalanced.
    fn tangent_factors(&self, tangent: &[TangentPart], norm: f64) -> Result<CoupledFactors, DecompositionError> {
        let (model, mut sum) = (&self.at_rest.model, self.linear.clone());
        tangent.iter().for_each(|part| part.add_to(model, &mut sum));
        regularisation(model, norm).for_each(|part| part.add_to(model, &mut sum));
        Ok(sum.factor()?)
    }
}

/// The flanks of every mesh that are pressed at `q`, after an iteration with contact on `flanks`. A flank with backlash
/// does not pull. Both flanks are pressed if the centre distance is smaller than the backlash allows. Flanks are never
/// apart, because a mesh in equilibrium carries its torque: where neither is pressed, the opposite flank comes next.
fn pressed_flanks(
    AtRest { model, geometry, speeds, .. }: &AtRest<'_>,
    flanks: &[Flank],
    q: &DVector<f64>,
) -> Result<Vec<Flank>, EquilibriumError> {
    let pressed = |(index, flank): (usize, &Flank)| {
        let mesh = &model.meshes[index];
        if mesh.backlash.is_none() {
            return Ok(*flank);
        }
        let force = |back| {
            mesh.mean_tangent(*geometry, model.sigma(index, speeds.flanks), back, q.as_slice(), |_, _, _| {})
                .map(|(force, _)| force)
                .map_err(|overlap| EquilibriumError::overlap(model, index, overlap))
        };
        // The force of an unloaded mesh is round-off.
        let scale = mesh.stiffness * mesh.involute.base_radius[0] * f64::EPSILON;
        let presses = |force: f64, in_contact: bool| force > if in_contact { -scale } else { scale };
        let (drive, back) = (force(false)?, force(true)?);
        Ok(match Flank::of(presses(drive, flank.drives()), presses(back, flank.holds_back())) {
            Flank::Separated => Flank::of(!flank.drives(), flank.drives()),
            pressed => pressed,
        })
    };
    flanks.iter().enumerate().map(pressed).collect()
}
