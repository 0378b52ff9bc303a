//! A bearing whose force is a nonlinear function of displacement, velocity, speed and angle of the shaft: the oil film of a
//! journal bearing (`src/film/`) or rolling elements (`src/rolling/`), over scalars u of the displacements of the shaft relative
//! to what the bearing stands on: (v, w), and for a ring of five degrees of freedom the axial displacement and the slopes too.
//!
//! Analyses need a linear system, which depends on the equilibrium and so on speed and load. The bearing therefore has two
//! parts:
//!
//! - constant coefficients K₀ and C₀ of an [`OperatingPoint`]. They belong to the matrices, and with them everything linear
//!   needs no further code;
//! - the connection: the remainder F − K₀u − C₀u̇. Its linear part about the operating point is zero, so that it acts
//!   only where the force itself counts: in the equilibrium, in runs and in recorded forces.
//!
//! The sum is the force, whatever K₀ and C₀ are. `CachedModel::at_speed` finds the operating point of a speed. The force of
//! rolling elements varies with the angle of the cage; equilibrium and operating point use its mean over this angle, as those
//! of a mesh use its mean stiffness.

use std::f64::consts::TAU;

use nalgebra::{DMatrix, DVector};

use super::instant::{Instant, InterfaceOptions, OutOfRange, Tangent, Touch};
use super::{Bounds, Coefficients, Row, along_row};
use crate::bearing_force::{BearingForce, Matrix, Uncarried, Vector};
use crate::film::{Film, TiltingPads};
use crate::mesh::ShaftPhase;
use crate::rolling::{Ring, RollingElements};

/// Spins below this are standstill, rad/s.
const STANDSTILL_SPIN: f64 = 1e-12;

/// Largest number of scalars of a nonlinear bearing: those of a [`Ring`].
pub const MAX_SCALARS: usize = 5;

/// Linear coefficients that stand for a nonlinear bearing in the matrices.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OperatingPoint {
    /// Speed of the reference shaft, rad/s; none for the stiffness from which the search of the equilibrium starts.
    pub speed: Option<f64>,
    /// Stiffness K₀ over the scalars, N/m; entries beyond their number are zero.
    pub stiffness: [[f64; MAX_SCALARS]; MAX_SCALARS],
    /// Damping C₀ over (v, w), N s/m.
    pub damping: Matrix,
}

/// The law of a nonlinear bearing.
#[derive(Clone, Debug)]
pub enum BearingLaw {
    /// An oil film: that of a journal bearing or of one tilting pad, or a squeeze film.
    Film(Film),
    /// Tilting pads whose tilt is eliminated, for linear analyses.
    Tilting(TiltingPads),
    /// Rolling elements between rings that move along (v, w).
    Rolling(RollingElements),
    /// Rolling elements between rings of five degrees of freedom.
    Ring(Ring),
}

/// A law over `N` scalars.
trait Law<const N: usize> {
    /// Force and, with `DERIVATIVES`, stiffness and damping at a displacement, m, a velocity, m/s, and the angle and spin of what
    /// turns the bearing: the shaft of a film, the cage of rolling elements.
    fn at<const DERIVATIVES: bool>(&self, u: [f64; N], rates: [f64; N], phase: &ShaftPhase) -> BearingForce<N>;

    /// Force, stiffness and damping at rest, averaged over the angle, at a spin of what turns the bearing, rad/s.
    fn mean(&self, u: [f64; N], spin: f64) -> BearingForce<N>;

    /// Coefficients for vibrations at rest, with the force, at a spin of what turns the bearing, rad/s.
    fn vibration(&self, u: [f64; N], spin: f64) -> BearingForce<N> {
        self.mean(u, spin)
    }

    /// Elastic energy, J, at an angle of the cage, rad; a film stores none.
    fn energy(&self, _: [f64; N], _: f64) -> f64 {
        0.0
    }

    /// Elastic force, N, at an angle of the cage, rad.
    fn elastic_force(&self, _: [f64; N], _: f64) -> [f64; N] {
        [0.0; N]
    }

    /// Displacement, m, at which it carries a static force, N, at a spin, and force and stiffness there.
    fn carrying(&self, force: [f64; N], spin: f64) -> Result<([f64; N], BearingForce<N>), Uncarried>;
}

impl Law<2> for Film {
    #[inline]
    fn at<const DERIVATIVES: bool>(&self, u: Vector, rates: Vector, phase: &ShaftPhase) -> BearingForce {
        self.at(u, rates, phase.spin)
    }

    fn mean(&self, u: Vector, spin: f64) -> BearingForce {
        self.at_rest(u, spin)
    }

    fn carrying(&self, force: Vector, spin: f64) -> Result<(Vector, BearingForce), Uncarried> {
        self.carrying(force, spin)
    }
}

impl Law<2> for TiltingPads {
    /// Runs refuse these pads; the force is that at rest.
    #[inline]
    fn at<const DERIVATIVES: bool>(&self, u: Vector, _: Vector, phase: &ShaftPhase) -> BearingForce {
        self.at(u, phase.spin, 0.0)
    }

    fn mean(&self, u: Vector, spin: f64) -> BearingForce {
        self.at(u, spin, 0.0)
    }

    fn vibration(&self, u: Vector, spin: f64) -> BearingForce {
        self.at(u, spin, spin)
    }

    fn carrying(&self, force: Vector, spin: f64) -> Result<(Vector, BearingForce), Uncarried> {
        self.carrying(force, spin, 0.0)
    }
}

impl Law<2> for RollingElements {
    #[inline]
    fn at<const DERIVATIVES: bool>(&self, u: Vector, rates: Vector, phase: &ShaftPhase) -> BearingForce {
        self.at::<DERIVATIVES>(u, rates, phase.angle)
    }

    fn mean(&self, u: Vector, _: f64) -> BearingForce {
        self.mean(u)
    }

    fn energy(&self, u: Vector, angle: f64) -> f64 {
        self.energy(u, angle)
    }

    fn elastic_force(&self, u: Vector, angle: f64) -> Vector {
        self.at::<false>(u, [0.0; 2], angle).force
    }

    fn carrying(&self, force: Vector, _: f64) -> Result<(Vector, BearingForce), Uncarried> {
        self.carrying(force, None)
    }
}

impl Law<5> for Ring {
    #[inline]
    fn at<const DERIVATIVES: bool>(&self, u: [f64; 5], _: [f64; 5], phase: &ShaftPhase) -> BearingForce<5> {
        self.at::<DERIVATIVES>(u, phase.angle)
    }

    fn mean(&self, u: [f64; 5], _: f64) -> BearingForce<5> {
        self.mean(u)
    }

    fn energy(&self, u: [f64; 5], angle: f64) -> f64 {
        self.energy(u, angle)
    }

    fn elastic_force(&self, u: [f64; 5], angle: f64) -> [f64; 5] {
        self.at::<false>(u, angle).force
    }

    fn carrying(&self, force: [f64; 5], _: f64) -> Result<([f64; 5], BearingForce<5>), Uncarried> {
        self.carrying(force)
    }
}

/// Evaluates an expression with the law of a bearing, whose type gives the number of scalars.
macro_rules! with_law {
    ($bearing:expr, $law:ident => $value:expr) => {
        match &$bearing.law {
            BearingLaw::Film($law) => $value,
            BearingLaw::Tilting($law) => $value,
            BearingLaw::Rolling($law) => $value,
            BearingLaw::Ring($law) => $value,
        }
    };
}

impl BearingLaw {
    /// Mean speed of the bearing, from the speeds of its shaft and of what it stands on: the sum of both, with which a film
    /// draws in oil (Reynolds' equation), or the speed of the cage.
    fn mean_speed(&self, [shaft, base]: [f64; 2]) -> f64 {
        let of_cage = |ratio: f64| ratio * shaft + (1.0 - ratio) * base;
        match self {
            Self::Film(_) | Self::Tilting(_) => shaft + base,
            Self::Rolling(elements) => of_cage(elements.cage_ratio),
            Self::Ring(ring) => of_cage(ring.cage_ratio),
        }
    }
}

/// The tilt of a pad as a coordinate.
#[derive(Clone, Copy, Debug)]
pub struct Tilt {
    /// Index of the coordinate.
    pub index: usize,
    /// Displacement of the centre of the pad per unit of the coordinate.
    pub scale: f64,
}

/// A bearing with a nonlinear force.
#[derive(Clone, Debug)]
pub struct NonlinearBearing {
    /// Index of the bearing in the scene.
    pub number: usize,
    /// The scalars: displacements v and w of the shaft relative to what the bearing stands on; for a [`Ring`] then its other
    /// coordinates.
    pub rows: Vec<Row>,
    /// Ratio of the speed of what turns the bearing, the shafts of a film or the cage of rolling elements, to the speed of the
    /// reference shaft.
    pub ratio: f64,
    /// Index of what turns the bearing in [`Model::turning_ratio`](crate::model::Model::turning_ratio).
    pub turning: usize,
    /// The law.
    pub law: BearingLaw,
    /// Stiffness with which a search of the equilibrium starts, N/m.
    pub initial_stiffness: f64,
    /// The tilt of a tilting pad.
    pub tilt: Option<Tilt>,
    /// The coefficients in the matrices; none in a model without a speed.
    pub point: Option<OperatingPoint>,
}

impl NonlinearBearing {
    /// A bearing with these scalars, without coefficients in the matrices, from the speed ratios of its shaft and of what it
    /// stands on.
    pub fn new(number: usize, rows: Vec<Row>, turning: usize, ratios: [f64; 2], law: BearingLaw) -> Self {
        Self {
            number,
            rows,
            ratio: law.mean_speed(ratios),
            turning,
            law,
            initial_stiffness: 0.0,
            tilt: None,
            point: None,
        }
    }

    /// Whether a shaft turns in its oil film.
    pub fn is_journal(&self) -> bool {
        match &self.law {
            BearingLaw::Film(film) => !film.is_squeeze(),
            BearingLaw::Tilting(_) => true,
            BearingLaw::Rolling(_) | BearingLaw::Ring(_) => false,
        }
    }

    /// Whether it is a squeeze film below a support.
    pub fn is_squeeze(&self) -> bool {
        matches!(&self.law, BearingLaw::Film(film) if film.is_squeeze())
    }

    /// Orthonormal combinations of its scalars on which the force depends; those without a force may be missing.
    fn combinations(&self) -> Vec<Combination> {
        match &self.law {
            BearingLaw::Film(_) | BearingLaw::Tilting(_) | BearingLaw::Rolling(_) => identity(2),
            BearingLaw::Ring(ring) => ring.roller_directions().unwrap_or_else(|| identity(5)),
        }
    }

    /// Number of its rolling elements, if it has some.
    pub fn elements(&self) -> Option<usize> {
        match &self.law {
            BearingLaw::Film(_) | BearingLaw::Tilting(_) => None,
            BearingLaw::Rolling(elements) => Some(elements.count()),
            BearingLaw::Ring(ring) => Some(ring.count()),
        }
    }

    /// Number of loaded rolling elements at displacements q and an angle of the cage, and the largest contact force, N.
    pub fn loaded_elements(&self, q: &[f64], cage: f64) -> [f64; 2] {
        match &self.law {
            BearingLaw::Film(_) | BearingLaw::Tilting(_) => [0.0; 2],
            BearingLaw::Rolling(elements) => elements.loaded(self.scalars(q), cage),
            BearingLaw::Ring(ring) => ring.loaded(self.scalars(q), cage),
        }
    }

    /// Contact force, N, at evenly spaced angles around a [`Ring`] at displacements q: `count` or more, a whole number for each
    /// element; none for another bearing.
    pub fn contact_forces(&self, q: &[f64], count: usize) -> Option<Vec<f64>> {
        let BearingLaw::Ring(ring) = &self.law else { return None };
        let (u, elements) = (self.scalars(q), ring.count());
        let angles = count.div_ceil(elements);
        let cage = |i: usize| TAU * i as f64 / (angles * elements) as f64;
        Some((0..angles).flat_map(|i| ring.contacts(u, cage(i)).map(|[force, _]| force)).collect())
    }

    /// Whether it has no force at a speed of the reference shaft, rad/s, because its shaft stands still.
    pub fn stands(&self, speed: f64) -> bool {
        self.is_journal() && (self.ratio * speed).abs() < STANDSTILL_SPIN
    }

    /// Sets the stiffness with which a search of the equilibrium starts: the bearing carries a weight, N, at a displacement
    /// of a third of the clearance of a film, or at gap and deflection of rolling elements.
    pub fn set_initial_stiffness(&mut self, weight: f64) {
        self.initial_stiffness = match &self.law {
            BearingLaw::Film(film) if film.is_squeeze() => 0.0,
            BearingLaw::Film(film) => 3.0 * weight / film.clearance(),
            BearingLaw::Tilting(pads) => 3.0 * weight / pads.clearance(),
            BearingLaw::Rolling(elements) => elements.secant_stiffness(weight),
            BearingLaw::Ring(ring) => ring.secant_stiffness(weight),
        };
    }

    /// Whether its pads are made for the other direction of rotation than that of a speed of the reference shaft.
    pub fn opposes(&self, speed: f64) -> bool {
        let spin = self.ratio * speed;
        match &self.law {
            BearingLaw::Film(film) => film.widens(spin),
            BearingLaw::Tilting(pads) => pads.widens(spin),
            BearingLaw::Rolling(_) | BearingLaw::Ring(_) => false,
        }
    }

    /// Coordinate and value of the tilt of a pad with which a search of the equilibrium starts at a speed of the reference shaft,
    /// rad/s: its film narrows in the direction of rotation. None for another bearing.
    pub fn initial_tilt(&self, speed: f64) -> Option<(usize, f64)> {
        let (BearingLaw::Film(film), Some(tilt)) = (&self.law, self.tilt) else { return None };
        Some((tilt.index, -film.start_wedge(self.ratio * speed) / tilt.scale))
    }

    /// Whether the film of a tilting pad narrows in the direction of rotation at displacements q and a speed of the reference
    /// shaft, rad/s, so that it carries; true for another bearing.
    pub fn is_wedged(&self, q: &[f64], speed: f64) -> bool {
        let BearingLaw::Film(film) = &self.law else { return true };
        let [y, z] = self.scalars(q);
        film.pivot().is_none_or(|[a, b]| (a * z - b * y) * self.ratio * speed > 0.0)
    }

    /// The scalars for displacements, or their rates for velocities.
    #[inline]
    pub fn scalars<const N: usize>(&self, q: &[f64]) -> [f64; N] {
        std::array::from_fn(|i| along_row(&self.rows[i], q))
    }

    /// The scalars for displacements as a vector.
    pub fn scalar_vector(&self, q: &[f64]) -> DVector<f64> {
        DVector::from_iterator(self.rows.len(), self.rows.iter().map(|row| along_row(row, q)))
    }

    /// The coefficients of a search that starts: its initial stiffness along every scalar.
    pub fn initial_point(&self) -> OperatingPoint {
        let mut point = OperatingPoint::default();
        (0..self.rows.len()).for_each(|i| point.stiffness[i][i] = self.initial_stiffness);
        point
    }

    /// Coefficients at displacements q of an equilibrium at a speed of the reference shaft, rad/s.
    pub fn point_at(&self, speed: f64, q: &[f64]) -> OperatingPoint {
        with_law!(self, law => Self::point_of(speed, &law.vibration(self.scalars(q), self.ratio * speed)))
    }

    fn point_of<const N: usize>(speed: f64, found: &BearingForce<N>) -> OperatingPoint {
        let mut point = OperatingPoint { speed: Some(speed), ..OperatingPoint::default() };
        for i in 0..N {
            point.stiffness[i][..N].copy_from_slice(&found.stiffness[i]);
        }
        for (row, found) in point.damping.iter_mut().zip(&found.damping) {
            row.copy_from_slice(&found[..2]);
        }
        point
    }

    /// Displacement, m, at which it carries a static force over the scalars, N, at a speed of the reference shaft, rad/s, and
    /// force and stiffness there.
    ///
    /// # Errors
    /// [`Uncarried`] if it cannot carry the force.
    pub fn carrying(&self, force: &DVector<f64>, speed: f64) -> Result<BearingTangent, Uncarried> {
        with_law!(self, law => {
            let (displacement, found) = Law::carrying(law, std::array::from_fn(|i| force[i]), self.ratio * speed)?;
            Ok(BearingTangent::new(&displacement, &found))
        })
    }

    /// Part of the clearance that a journal at displacements q has used at the nearest pad; none for rolling elements.
    #[inline]
    pub fn nearness(&self, q: &[f64]) -> Option<f64> {
        self.nearness_at(self.scalars(q))
    }

    #[inline]
    fn nearness_at(&self, u: Vector) -> Option<f64> {
        match &self.law {
            BearingLaw::Film(film) => Some(film.nearness(u)),
            BearingLaw::Tilting(pads) => Some(pads.nearness(u)),
            BearingLaw::Rolling(_) | BearingLaw::Ring(_) => None,
        }
    }

    /// Force and, with `DERIVATIVES`, derivatives beyond those of the matrices.
    #[inline]
    fn beyond_matrices<const N: usize, const DERIVATIVES: bool>(
        &self,
        mut all: BearingForce<N>,
        u: [f64; N],
        rates: [f64; N],
    ) -> BearingForce<N> {
        if let Some(OperatingPoint { stiffness, damping, .. }) = &self.point {
            for (i, row) in stiffness.iter().take(N).enumerate() {
                for (j, entry) in row.iter().take(N).enumerate() {
                    all.force[i] -= entry * u[j];
                    if DERIVATIVES {
                        all.stiffness[i][j] -= entry;
                    }
                }
            }
            for (i, row) in damping.iter().enumerate() {
                for (j, entry) in row.iter().enumerate() {
                    all.force[i] -= entry * rates[j];
                    if DERIVATIVES {
                        all.damping[i][j] -= entry;
                    }
                }
            }
        }
        all
    }

    #[inline]
    fn remainder<const N: usize, const DERIVATIVES: bool>(
        &self,
        law: &impl Law<N>,
        phase: &ShaftPhase,
        u: [f64; N],
        rates: [f64; N],
    ) -> BearingForce<N> {
        self.beyond_matrices::<N, DERIVATIVES>(law.at::<DERIVATIVES>(u, rates, phase), u, rates)
    }

    /// Mean force at rest and its derivatives, beyond those of the matrices.
    fn mean_remainder<const N: usize>(&self, law: &impl Law<N>, speed: f64, u: [f64; N]) -> BearingForce<N> {
        self.beyond_matrices::<N, true>(law.mean(u, self.ratio * speed), u, [0.0; N])
    }

    /// Force of the shaft on the bearing beyond that of the matrices, along (y, z) and the axis, N, at the angle and spin of
    /// what turns the bearing.
    ///
    /// # Errors
    /// [`Touch`] where the journal touches the bearing.
    #[inline]
    pub fn force(&self, phase: &ShaftPhase, q: &[f64], v: &[f64]) -> Result<[f64; 3], Touch> {
        with_law!(self, law => {
            let u = self.scalars(q);
            self.check(&u)?;
            Ok(along_axes(&self.remainder::<_, false>(law, phase, u, self.scalars(v)).force))
        })
    }

    /// Subtracts the force beyond that of the matrices from generalised forces, at the angle and spin of what turns the bearing.
    ///
    /// # Errors
    /// As [`Self::force`].
    #[inline]
    pub fn apply(&self, phase: &ShaftPhase, q: &[f64], v: &[f64], out: &mut [f64]) -> Result<(), Touch> {
        with_law!(self, law => {
            let u = self.scalars(q);
            self.check(&u)?;
            let force = self.remainder::<_, false>(law, phase, u, self.scalars(v)).force;
            for (row, force) in self.rows.iter().zip(force) {
                row.iter().for_each(|(index, coefficient)| out[*index] -= coefficient * force);
            }
            Ok(())
        })
    }

    /// Mean force at rest beyond that of the matrices, along (y, z) and the axis, N.
    pub fn static_force(&self, speed: f64, q: &[f64]) -> [f64; 3] {
        with_law!(self, law => along_axes(&self.mean_remainder(law, speed, self.scalars(q)).force))
    }

    /// Refuses a displacement at which a journal touches the bearing.
    #[inline]
    fn check(&self, u: &[f64]) -> Result<(), Touch> {
        let Some(nearness) = self.nearness_at([u[0], u[1]]) else {
            return Ok(());
        };
        if nearness < 1.0 { Ok(()) } else { Err(Touch { bearing: self.number, nearness }) }
    }

    /// Mean force over the scalars beyond that of the matrices, N, and its derivative, N/m, at the displacements q of a
    /// system at rest.
    pub fn static_tangent(&self, speed: f64, q: &[f64]) -> (DVector<f64>, DMatrix<f64>) {
        with_law!(self, law => {
            let BearingForce { force, stiffness, .. } = self.mean_remainder(law, speed, self.scalars(q));
            let n = force.len();
            (DVector::from_column_slice(&force), DMatrix::from_fn(n, n, |i, j| stiffness[i][j]))
        })
    }

    /// The connection has no linear part.
    pub fn linear(&self) -> Coefficients {
        Coefficients::isotropic(self.rows.len(), 0.0, 0.0)
    }

    /// Bounds for the step limit of Runge–Kutta methods. The stiffness of rolling elements varies about that of the matrices,
    /// of which it may be twice as large; a film has no bound. Use a method with error control where the load varies much.
    pub fn bounds(&self) -> Bounds {
        let stiffness = self.point.filter(|_| self.elements().is_some()).map(|point| point.stiffness);
        let excess = stiffness.unwrap_or_default().as_flattened().iter().map(|k| k.abs()).fold(0.0, f64::max);
        Bounds { excess_stiffness: excess, damping: 0.0 }
    }

    /// Elastic energy beyond that which the matrices count, J, at the angle of what turns the bearing.
    pub fn energy(&self, phase: &ShaftPhase, q: &[f64]) -> f64 {
        with_law!(self, law => {
            let u = self.scalars(q);
            Law::energy(law, u, phase.angle) - self.counted(u, u) / 2.0
        })
    }

    /// Powers, W: that of the drive, which moves the cage with its elements against the elastic force, and that which the
    /// bearing takes from the shaft beyond what the matrices count as damping.
    pub fn powers(&self, phase: &ShaftPhase, q: &[f64], v: &[f64]) -> [f64; 2] {
        with_law!(self, law => {
            let (u, rates) = (self.scalars(q), self.scalars(v));
            let (force, elastic) = (self.remainder::<_, false>(law, phase, u, rates).force, law.elastic_force(u, phase.angle));
            let power: f64 = force.iter().zip(&elastic).zip(&rates).map(|((all, own), rate)| (all - own) * rate).sum();
            // ∂U/∂ψ: with the cage, the load turns backwards about the axis, both the displacement (v, w) and the slopes.
            let turned = |at: usize| elastic[at] * u[at + 1] - elastic[at + 1] * u[at];
            let drive = turned(0) + if u.len() == MAX_SCALARS { turned(3) } else { 0.0 };
            [phase.spin * drive, power + self.counted(u, rates)]
        })
    }

    /// aᵀKb with the symmetric part K of the stiffness in the matrices.
    fn counted<const N: usize>(&self, a: [f64; N], b: [f64; N]) -> f64 {
        let Some(OperatingPoint { stiffness: k, .. }) = &self.point else { return 0.0 };
        let entry = |i: usize, j: usize| (k[i][j] + k[j][i]) / 2.0 * a[i] * b[j];
        (0..N).map(|i| (0..N).map(|j| entry(i, j)).sum::<f64>()).sum()
    }
}

/// Components along (y, z) and the axis of a force over the scalars of a bearing; films and rings of two degrees of freedom have
/// none along the axis.
#[inline]
fn along_axes(force: &[f64]) -> [f64; 3] {
    [force[0], force[1], force.get(2).copied().unwrap_or(0.0)]
}

/// Tangent F + K (u − u₀) of the law of a nonlinear bearing over its scalars.
#[derive(Clone, Debug)]
pub struct BearingTangent {
    /// Scalars u₀, m.
    pub displacement: DVector<f64>,
    /// Force F there, N.
    pub force: DVector<f64>,
    /// Stiffness K there, N/m.
    pub stiffness: DMatrix<f64>,
}

impl BearingTangent {
    fn new<const N: usize>(displacement: &[f64; N], found: &BearingForce<N>) -> Self {
        Self {
            displacement: DVector::from_column_slice(displacement),
            force: DVector::from_column_slice(&found.force),
            stiffness: DMatrix::from_fn(N, N, |i, j| found.stiffness[i][j]),
        }
    }
}

/// A nonlinear bearing in a run. Its scalars there are the combinations of those of the bearing on which the force depends.
#[derive(Clone, Debug)]
pub struct NonlinearInterface {
    pub(super) bearing: NonlinearBearing,
    /// The combinations, which are orthonormal: coefficients over the scalars of the bearing, zero beyond their number.
    combinations: Vec<Combination>,
    /// Scalars of the bearing at the reference, m; zero beyond their number.
    reference: [f64; MAX_SCALARS],
    /// Generalised forces at the reference, without the part in the matrices, N, one for each combination.
    pub(super) reference_force: Vec<f64>,
}

/// Coefficients of a scalar of a run over the scalars of its bearing.
type Combination = [f64; MAX_SCALARS];

/// Every scalar of a bearing as a combination.
fn identity(scalars: usize) -> Vec<Combination> {
    (0..scalars).map(|own| std::array::from_fn(|i| if i == own { 1.0 } else { 0.0 })).collect()
}

/// Sum of values with the coefficients of a combination.
#[inline]
fn combined<const N: usize>(combination: &Combination, values: &[f64; N]) -> f64 {
    combination.iter().zip(values).map(|(coefficient, value)| coefficient * value).sum()
}

impl NonlinearInterface {
    pub(super) fn new(bearing: &NonlinearBearing, options: InterfaceOptions<'_>) -> Self {
        let combinations = bearing.combinations();
        let (force, _) = bearing.static_tangent(options.speed, options.reference);
        let [mut at_rest, mut reference] = [[0.0; MAX_SCALARS]; 2];
        at_rest[..bearing.rows.len()].copy_from_slice(force.as_slice());
        reference[..bearing.rows.len()].copy_from_slice(bearing.scalar_vector(options.reference).as_slice());
        let reference_force = combinations.iter().map(|combination| -combined(combination, &at_rest)).collect();
        Self { bearing: bearing.clone(), combinations, reference, reference_force }
    }

    /// Number of scalars.
    #[inline]
    pub(super) fn scalars(&self) -> usize {
        self.combinations.len()
    }

    /// The scalars as entries over the coordinates.
    pub(super) fn rows(&self) -> Vec<Row> {
        let row = |combination: &Combination| {
            let parts = self.bearing.rows.iter().zip(combination).filter(|(_, share)| **share != 0.0);
            parts.flat_map(|(row, share)| row.iter().map(move |(index, c)| (*index, share * c))).collect()
        };
        self.combinations.iter().map(row).collect()
    }

    /// The scalars of the bearing, or their rates, from values at the reference and those of the combinations.
    #[inline]
    fn of_bearing<const N: usize>(&self, reference: &[f64; MAX_SCALARS], values: &[f64]) -> [f64; N] {
        let mut scalars = std::array::from_fn(|i| reference[i]);
        for (combination, value) in self.combinations.iter().zip(values) {
            scalars.iter_mut().zip(combination).for_each(|(scalar, share): (&mut f64, _)| *scalar += share * value);
        }
        scalars
    }

    #[inline]
    pub(super) fn load(
        &self,
        instant: &Instant,
        u: &[f64],
        rates: &[f64],
        load: &mut [f64],
        tangent: Option<Tangent<'_>>,
    ) -> Result<(), OutOfRange> {
        with_law!(self.bearing, law => {
            let (u, rates) = (self.of_bearing(&self.reference, u), self.of_bearing(&[0.0; MAX_SCALARS], rates));
            self.bearing.check(&u)?;
            let phase = &instant.phases[0];
            let found = match tangent {
                Some(_) => self.bearing.remainder::<_, true>(law, phase, u, rates),
                None => self.bearing.remainder::<_, false>(law, phase, u, rates),
            };
            for ((load, combination), reference) in load.iter_mut().zip(&self.combinations).zip(&self.reference_force) {
                *load = -combined(combination, &found.force) - reference;
            }
            if let Some(Tangent { stiffness, damping }) = tangent {
                self.write(stiffness, &found.stiffness);
                self.write(damping, &found.damping);
            }
            Ok(())
        })
    }

    /// Writes the derivatives over the combinations, row after row, from those over the scalars of the bearing.
    #[inline]
    fn write<const N: usize>(&self, entries: &mut [f64], of_bearing: &[[f64; N]; N]) {
        for (column, combination) in self.combinations.iter().enumerate() {
            let change = of_bearing.each_ref().map(|row| combined(combination, row));
            for (entries, own) in entries.chunks_exact_mut(self.scalars()).zip(&self.combinations) {
                entries[column] = combined(own, &change);
            }
        }
    }
}
