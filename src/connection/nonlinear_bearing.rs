//! A bearing whose force is a nonlinear function of displacement, velocity, speed and angle of the shaft: the oil film of a
//! journal bearing (`src/film/`) or rolling elements (`src/rolling/`), over the displacements u = (v, w) of the shaft relative
//! to what the bearing stands on.
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

use nalgebra::{DMatrix, DVector};

use super::instant::{Instant, InterfaceOptions, OutOfRange, Tangent, Touch};
use super::{Bounds, Coefficients, Row};
use crate::bearing_force::{BearingForce, Uncarried, Vector};
use crate::film::Film;
use crate::mesh::ShaftPhase;
use crate::rolling::RollingElements;
use crate::scene::Matrix2;

/// Spins below this are standstill, rad/s.
const STANDSTILL_SPIN: f64 = 1e-12;

/// Linear coefficients that stand for a nonlinear bearing in the matrices.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OperatingPoint {
    /// Speed of the reference shaft, rad/s; none for the stiffness from which the search of the equilibrium starts.
    pub speed: Option<f64>,
    /// Stiffness K₀ over (v, w), N/m.
    pub stiffness: Matrix2,
    /// Damping C₀ over (v, w), N s/m.
    pub damping: Matrix2,
}

/// The law of a nonlinear bearing.
#[derive(Clone, Debug)]
pub enum BearingLaw {
    /// The oil film of a journal bearing.
    Film(Film),
    /// Rolling elements.
    Rolling(RollingElements),
}

impl BearingLaw {
    /// Force, stiffness and damping at a displacement, m, a velocity, m/s, and the angle and spin of what turns the bearing:
    /// the shaft of a film, the cage of rolling elements.
    #[inline]
    fn at(&self, u: Vector, rates: Vector, phase: &ShaftPhase) -> BearingForce {
        match self {
            Self::Film(film) => film.at(u, rates, phase.spin),
            Self::Rolling(elements) => elements.at(u, rates, phase.angle),
        }
    }

    /// Force, stiffness and damping at rest, averaged over the angle, at a spin of what turns the bearing, rad/s.
    fn mean(&self, u: Vector, spin: f64) -> BearingForce {
        match self {
            Self::Film(film) => film.at(u, [0.0; 2], spin),
            Self::Rolling(elements) => elements.mean(u),
        }
    }

    /// Elastic energy, J, and elastic force, N, at an angle of the cage, rad: a film stores no energy.
    fn elastic(&self, u: Vector, angle: f64) -> (f64, Vector) {
        match self {
            Self::Film(_) => (0.0, [0.0; 2]),
            Self::Rolling(elements) => (elements.energy(u, angle), elements.at(u, [0.0; 2], angle).force),
        }
    }

    /// Mean speed of the bearing, from the speeds of its shaft and of what it stands on: the sum of both, with which a film
    /// draws in oil (Reynolds' equation), or the speed of the cage.
    fn mean_speed(&self, [shaft, base]: [f64; 2]) -> f64 {
        match self {
            Self::Film(_) => shaft + base,
            Self::Rolling(elements) => elements.cage_ratio * shaft + (1.0 - elements.cage_ratio) * base,
        }
    }
}

/// A bearing with a nonlinear force.
#[derive(Clone, Debug)]
pub struct NonlinearBearing {
    /// Index of the bearing in the scene.
    pub number: usize,
    /// The scalars v and w: displacements of the shaft relative to what the bearing stands on.
    pub rows: [Row; 2],
    /// Ratio of the speed of what turns the bearing, the shafts of a film or the cage of rolling elements, to the speed of the
    /// reference shaft.
    pub ratio: f64,
    /// Index of what turns the bearing in [`Model::turning_ratio`](crate::model::Model::turning_ratio).
    pub turning: usize,
    /// The law.
    pub law: BearingLaw,
    /// Stiffness with which a search of the equilibrium starts, N/m.
    pub initial_stiffness: f64,
    /// The coefficients in the matrices; none in a model without a speed.
    pub point: Option<OperatingPoint>,
}

impl NonlinearBearing {
    /// A bearing with these scalars, without coefficients in the matrices, from the speed ratios of its shaft and of what it
    /// stands on.
    pub fn new(number: usize, rows: [Row; 2], turning: usize, ratios: [f64; 2], law: BearingLaw) -> Self {
        Self { number, rows, ratio: law.mean_speed(ratios), turning, law, initial_stiffness: 0.0, point: None }
    }

    /// Its film, if it has one.
    pub fn film(&self) -> Option<&Film> {
        match &self.law {
            BearingLaw::Film(film) => Some(film),
            BearingLaw::Rolling(_) => None,
        }
    }

    /// Its rolling elements, if it has some.
    pub fn rolling(&self) -> Option<&RollingElements> {
        match &self.law {
            BearingLaw::Film(_) => None,
            BearingLaw::Rolling(elements) => Some(elements),
        }
    }

    /// Whether it has no force at a speed of the reference shaft, rad/s, because its shaft stands still.
    pub fn stands(&self, speed: f64) -> bool {
        self.film().is_some() && (self.ratio * speed).abs() < STANDSTILL_SPIN
    }

    /// Sets the stiffness with which a search of the equilibrium starts: the bearing carries a weight, N, at a displacement
    /// of a third of the clearance of a film, or at gap and deflection of rolling elements.
    pub fn set_initial_stiffness(&mut self, weight: f64) {
        self.initial_stiffness = match &self.law {
            BearingLaw::Film(film) => 3.0 * weight / film.clearance(),
            BearingLaw::Rolling(elements) => elements.secant_stiffness(weight),
        };
    }

    /// The two scalars for displacements, or their rates for velocities.
    #[inline]
    pub fn scalars(&self, q: &[f64]) -> Vector {
        self.rows.each_ref().map(|row| row.iter().map(|(index, coefficient)| coefficient * q[*index]).sum())
    }

    /// Coefficients at displacements q of an equilibrium at a speed of the reference shaft, rad/s.
    pub fn point_at(&self, speed: f64, q: &[f64]) -> OperatingPoint {
        let BearingForce { stiffness, damping, .. } = self.law.mean(self.scalars(q), self.ratio * speed);
        OperatingPoint { speed: Some(speed), stiffness, damping }
    }

    /// Displacement, m, at which it carries a static force over (y, z), N, at a speed of the reference shaft, rad/s, and force and
    /// stiffness there.
    ///
    /// # Errors
    /// [`Uncarried`] if it cannot carry the force.
    pub fn carrying(&self, force: Vector, speed: f64) -> Result<(Vector, BearingForce), Uncarried> {
        match &self.law {
            BearingLaw::Film(film) => film.carrying(force, self.ratio * speed),
            BearingLaw::Rolling(elements) => elements.carrying(force, None),
        }
    }

    /// Eccentricity ratio ε of a journal at displacements q; none for rolling elements.
    #[inline]
    pub fn eccentricity_ratio(&self, q: &[f64]) -> Option<f64> {
        self.film().map(|film| film.eccentricity_ratio(self.scalars(q)))
    }

    /// Force and derivatives beyond those of the matrices.
    #[inline]
    fn beyond_matrices(&self, mut all: BearingForce, u: Vector, rates: Vector) -> BearingForce {
        if let Some(OperatingPoint { stiffness, damping, .. }) = &self.point {
            for i in 0..2 {
                for j in 0..2 {
                    all.force[i] -= stiffness[i][j] * u[j] + damping[i][j] * rates[j];
                    all.stiffness[i][j] -= stiffness[i][j];
                    all.damping[i][j] -= damping[i][j];
                }
            }
        }
        all
    }

    #[inline]
    fn remainder(&self, phase: &ShaftPhase, u: Vector, rates: Vector) -> BearingForce {
        self.beyond_matrices(self.law.at(u, rates, phase), u, rates)
    }

    /// Mean force at rest and its derivatives, beyond those of the matrices.
    fn mean_remainder(&self, speed: f64, u: Vector) -> BearingForce {
        self.beyond_matrices(self.law.mean(u, self.ratio * speed), u, [0.0; 2])
    }

    /// Force of the shaft on the bearing beyond that of the matrices, components (y, z), N, at the angle and spin of what
    /// turns the bearing.
    ///
    /// # Errors
    /// [`Touch`] where the journal touches the bearing.
    #[inline]
    pub fn force(&self, phase: &ShaftPhase, q: &[f64], v: &[f64]) -> Result<Vector, Touch> {
        let (u, rates) = (self.scalars(q), self.scalars(v));
        self.check(u)?;
        Ok(self.remainder(phase, u, rates).force)
    }

    /// Refuses a displacement at which a journal touches the bearing.
    #[inline]
    fn check(&self, u: Vector) -> Result<(), Touch> {
        let Some(film) = self.film() else {
            return Ok(());
        };
        let eccentricity_ratio = film.eccentricity_ratio(u);
        if eccentricity_ratio < 1.0 { Ok(()) } else { Err(Touch { bearing: self.number, eccentricity_ratio }) }
    }

    /// Mean force over the scalars beyond that of the matrices, N, and its derivative, N/m, at the displacements q of a
    /// system at rest.
    pub fn static_tangent(&self, speed: f64, q: &[f64]) -> (DVector<f64>, DMatrix<f64>) {
        let found = self.mean_remainder(speed, self.scalars(q));
        (DVector::from_column_slice(&found.force), DMatrix::from_fn(2, 2, |i, j| found.stiffness[i][j]))
    }

    /// The connection has no linear part.
    pub fn linear(&self) -> Coefficients {
        Coefficients::isotropic(2, 0.0, 0.0)
    }

    /// Bounds for the step limit of Runge–Kutta methods. The stiffness of rolling elements varies about that of the matrices,
    /// of which it may be twice as large; a film has no bound. Use a method with error control where the load varies much.
    pub fn bounds(&self) -> Bounds {
        let stiffness = self.point.filter(|_| self.rolling().is_some()).map(|point| point.stiffness);
        let excess = stiffness.unwrap_or_default().as_flattened().iter().map(|k| k.abs()).fold(0.0, f64::max);
        Bounds { excess_stiffness: excess, damping: 0.0 }
    }

    /// Elastic energy beyond that which the matrices count, J, at the angle of what turns the bearing.
    pub fn energy(&self, phase: &ShaftPhase, q: &[f64]) -> f64 {
        let u = self.scalars(q);
        self.law.elastic(u, phase.angle).0 - self.counted(u, u) / 2.0
    }

    /// Powers, W: that of the drive, which moves the cage with its elements against the elastic force, and that which the
    /// bearing takes from the shaft beyond what the matrices count as damping.
    pub fn powers(&self, phase: &ShaftPhase, q: &[f64], v: &[f64]) -> [f64; 2] {
        let (u, rates) = (self.scalars(q), self.scalars(v));
        let (force, (_, elastic)) = (self.remainder(phase, u, rates).force, self.law.elastic(u, phase.angle));
        let power = |force: Vector| force[0] * rates[0] + force[1] * rates[1];
        // ∂U/∂ψ = Σ Q_j u·∂e_j/∂ψ.
        let drive = phase.spin * (elastic[0] * u[1] - elastic[1] * u[0]);
        [drive, power(force) + self.counted(u, rates) - power(elastic)]
    }

    /// aᵀKb with the symmetric part K of the stiffness in the matrices.
    fn counted(&self, a: Vector, b: Vector) -> f64 {
        let k = self.point.map_or([[0.0; 2]; 2], |point| point.stiffness);
        let cross = (k[0][1] + k[1][0]) / 2.0;
        k[0][0] * a[0] * b[0] + cross * (a[0] * b[1] + a[1] * b[0]) + k[1][1] * a[1] * b[1]
    }
}

/// A nonlinear bearing in a run.
#[derive(Clone, Debug)]
pub struct NonlinearInterface {
    pub(super) bearing: NonlinearBearing,
    /// Displacement (v, w) at the reference, m.
    reference: Vector,
    /// Generalised forces at the reference, without the part in the matrices, N.
    pub(super) reference_force: Vector,
}

impl NonlinearInterface {
    pub(super) fn new(bearing: &NonlinearBearing, options: InterfaceOptions<'_>) -> Self {
        let reference = bearing.scalars(options.reference);
        let force = bearing.mean_remainder(options.speed, reference).force;
        Self { bearing: bearing.clone(), reference, reference_force: force.map(|force| -force) }
    }

    fn displacement(&self, u: &[f64]) -> Vector {
        [self.reference[0] + u[0], self.reference[1] + u[1]]
    }

    #[inline]
    pub(super) fn load(&self, instant: &Instant, u: &[f64], rates: &[f64], load: &mut [f64]) -> Result<(), OutOfRange> {
        let at = self.displacement(u);
        self.bearing.check(at)?;
        let force = self.bearing.remainder(&instant.phases[0], at, [rates[0], rates[1]]).force;
        for (i, load) in load.iter_mut().enumerate() {
            *load = -force[i] - self.reference_force[i];
        }
        Ok(())
    }

    #[inline]
    pub(super) fn residual_tangent(&self, instant: &Instant, u: &[f64], rates: &[f64], tangent: Tangent<'_>) {
        let found = self.bearing.remainder(&instant.phases[0], self.displacement(u), [rates[0], rates[1]]);
        tangent.stiffness.copy_from_slice(found.stiffness.as_flattened());
        tangent.damping.copy_from_slice(found.damping.as_flattened());
    }
}
