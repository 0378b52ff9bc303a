//! The undamped modes that a run keeps, and the residual flexibility of the others at its interfaces (MacNeal 1971, Rubin
//! 1975).
//!
//! The share of a mode in the flexibility of an interface b (a connection, a load, a damper or a recorded place) is
//! (bᵀφ)²/ω² divided by the sum over all modes. A mode is kept if its frequency is below L ω_t, where ω_t is the highest
//! frequency that the teeth excite, and its largest share is not negligible. The load of a tooth with sharp engagement is a
//! step, whose error decreases with 1/L², and the displacement of a mode after a step decreases with 1/ω²; a share is
//! therefore negligible below C (ω/ω_t)²/L⁴, which is C/L² at the limit. The static displacement of the other modes at each
//! interface becomes a shape of its own. These shapes are orthogonal to the kept modes in M and K.
//!
//! Modes with a damping ratio of their own are kept with all below them, so that their numbers are those of the model.
//!
//! The displacements of growing modes, and of their duals, are always in the subspace: however small they are at the
//! beginning, they outgrow the rest. With them, the Galerkin projection keeps the eigenvalues of these modes.

use nalgebra::{DMatrix, DVector};

use super::real::RealModes;
use crate::connection::Row;
use crate::linalg::{DecompositionError, symmetric_pencil};
use crate::model::Model;

/// C: negligible share at L = 1. With 0.03, three of the scenes of `benches/accuracy` need L = 13 instead of 6 or 9; with 0.003,
/// runs at L = 6 keep 13 to 30 % more modes.
const NEGLIGIBLE_SHARE: f64 = 0.01;
/// Modes below this multiple of the fastest rotation are kept, because bow and unbalance can be in resonance with them.
const ROTATION_MARGIN: f64 = 1.5;
/// A static shape whose energy outside of the other shapes is below this share of its interface is round-off.
const DEPENDENCE_TOLERANCE: f64 = 1e-10;
/// Weight of the load on a single coordinate or seat relative to those of connections, which act along lines of action. With 0.003,
/// a train with separation loses modes that matter: its error of mesh forces rises from 1.5e-3 to 2.3e-2.
const COORDINATE_WEIGHT: f64 = 0.03;
/// Range of L in which a given number of modes is sought, and the ratio of two L that end the search.
const LIMITS_OF_COUNT: [f64; 2] = [0.01, 1e4];
const LIMIT_TOLERANCE: f64 = 0.01;

/// How many modes a run keeps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Extent {
    /// Modes up to this multiple L of the highest frequency that the teeth excite.
    Limit(f64),
    /// This number of modes, rigid-body modes and static shapes included.
    Count(usize),
}

/// What the modes that a run keeps read beside its model.
#[derive(Clone, Debug, PartialEq)]
pub struct SubspaceKey {
    /// Speeds of the reference shaft at which no growing mode may be left out, rad/s; the first one is that of the linear
    /// motion.
    pub speeds: Vec<f64>,
    /// Highest frequency that the teeth excite, rad/s.
    pub excited: f64,
    /// Speed of the fastest rotation, rad/s.
    pub rotation: f64,
    /// Highest frequency of the component modes from which those of a large model follow, rad/s; none for all modes of a
    /// small model.
    pub highest: Option<f64>,
    /// Loads of connections along their lines of action, as entries (index, coefficient).
    pub interfaces: Vec<Row>,
    /// Loads on single coordinates and on the seats of elastic housings, whose static displacements a large model keeps.
    pub coordinates: Vec<Row>,
    /// Further loads, on many coordinates of a shaft, as entries (index, coefficient), whose static displacements it keeps too.
    pub distributed: Vec<Row>,
    /// How many modes the run keeps; none keeps all.
    pub extent: Option<Extent>,
}

/// The modes `all` of a model, without those that the key leaves out but for their static shapes; the displacements
/// `growing`, n × k, stay in the subspace.
///
/// # Errors
/// [`DecompositionError`] if the decomposition of the static shapes fails.
pub fn kept_modes(
    model: &Model,
    all: &RealModes,
    key: &SubspaceKey,
    growing: &DMatrix<f64>,
) -> Result<RealModes, DecompositionError> {
    let Some(extent) = key.extent else {
        return Ok(all.clone());
    };
    let along = [&key.interfaces[..], &key.distributed].concat();
    let interfaces = Interfaces::new(all, &along, &key.coordinates, model.scene.modal_damping.numbered_modes());
    let (kept, statics) = match extent {
        Extent::Limit(limit) => interfaces.of_limit(key, limit),
        Extent::Count(count) => interfaces.of_count(key, count.saturating_sub(all.null)),
    };
    Subspace { model, all, speed: key.speeds[0] }.modes(&kept, &statics, growing)
}

impl RealModes {
    /// The modes up to `highest`, rad/s, and the static displacements of the others under `loads`, with the loaded tooth flanks of
    /// `speed` (reference shaft, rad/s).
    ///
    /// # Errors
    /// [`DecompositionError`] if the decomposition of the static shapes fails.
    pub(in crate::modal) fn up_to(
        &self,
        model: &Model,
        speed: f64,
        loads: &[Row],
        highest: f64,
    ) -> Result<Self, DecompositionError> {
        let interfaces = Interfaces::new(self, &[], loads, 0);
        let kept: Vec<usize> =
            (0..interfaces.shares.len()).filter(|mode| interfaces.frequencies[*mode] <= highest).collect();
        let statics = interfaces.static_shapes(&kept, usize::MAX, DEPENDENCE_TOLERANCE);
        Subspace { model, all: self, speed }.modes(&kept, &statics, &DMatrix::zeros(model.len(), 0))
    }
}

/// Interfaces in the elastic modes of a model.
struct Interfaces {
    /// ω of the elastic modes, rad/s.
    frequencies: DVector<f64>,
    /// bᵀφ/ω over the elastic modes, of unit length, one column for each interface.
    energies: DMatrix<f64>,
    /// Largest share of each mode.
    shares: Vec<f64>,
    /// Number of lowest modes that are always kept, because they have damping ratios by their number.
    numbered: usize,
}

impl Interfaces {
    /// The interfaces of loads `along` lines of action and of those on single `coordinates`.
    fn new(all: &RealModes, along: &[Row], coordinates: &[Row], numbered: usize) -> Self {
        let (null, elastic) = (all.null, all.frequencies.len() - all.null);
        let frequencies = all.frequencies.rows(null, elastic).into_owned();
        let mut energies = DMatrix::zeros(elastic, along.len() + coordinates.len());
        for (mut column, row) in energies.column_iter_mut().zip(along.iter().chain(coordinates)) {
            for (mode, entry) in column.iter_mut().enumerate() {
                let load: f64 = row.iter().map(|(index, value)| all.vectors[(*index, null + mode)] * value).sum();
                *entry = load / frequencies[mode];
            }
            let size = column.norm();
            if size > 0.0 {
                column /= size;
            }
        }
        let single = COORDINATE_WEIGHT * COORDINATE_WEIGHT;
        let weights = along.iter().map(|row| if row.len() == 1 { single } else { 1.0 });
        let weights: Vec<f64> = weights.chain(coordinates.iter().map(|_| single)).collect();
        let shares = energies
            .row_iter()
            .map(|row| row.iter().zip(&weights).map(|(entry, weight)| weight * entry * entry).fold(0.0, f64::max))
            .collect();
        Self { frequencies, energies, shares, numbered }
    }

    /// The modes up to L = `limit` that are not negligible, and the static shapes of the others.
    fn of_limit(&self, key: &SubspaceKey, limit: f64) -> (Vec<usize>, Vec<DVector<f64>>) {
        let is_kept = |mode: &usize| {
            let frequency = self.frequencies[*mode];
            let relative = frequency / (limit * key.excited);
            let smallest = NEGLIGIBLE_SHARE * (relative / limit).powi(2);
            *mode < self.numbered
                || frequency <= ROTATION_MARGIN * key.rotation
                || frequency <= limit * key.excited && self.shares[*mode] > smallest
        };
        let kept: Vec<usize> = (0..self.shares.len()).filter(is_kept).collect();
        let statics = self.static_shapes(&kept, usize::MAX, NEGLIGIBLE_SHARE / limit.powi(2));
        (kept, statics)
    }

    /// `count` modes and static shapes: those of the largest L that has no more, and further modes with the largest shares.
    fn of_count(&self, key: &SubspaceKey, count: usize) -> (Vec<usize>, Vec<DVector<f64>>) {
        let total = |(kept, statics): &(Vec<usize>, Vec<DVector<f64>>)| kept.len() + statics.len();
        let [mut low, mut high] = LIMITS_OF_COUNT;
        let mut found = self.of_limit(key, low);
        while high > (1.0 + LIMIT_TOLERANCE) * low {
            let middle = (low * high).sqrt();
            let next = self.of_limit(key, middle);
            if total(&next) <= count {
                (low, found) = (middle, next);
            } else {
                high = middle;
            }
        }
        let (mut kept, mut statics) = found;
        statics.truncate(count.saturating_sub(kept.len()));
        let mut others: Vec<usize> = (0..self.shares.len()).filter(|mode| !kept.contains(mode)).collect();
        others.sort_by(|a, b| self.shares[*b].total_cmp(&self.shares[*a]));
        kept.extend(others.into_iter().take(count.saturating_sub(kept.len() + statics.len())));
        (kept, statics)
    }

    /// Static displacements of the modes that are not `kept`, scaled by ω and orthonormal: at most `count` of them, those of
    /// the interfaces with the largest rest first, the last interface where rests are equal, until each rest is below
    /// `smallest`.
    fn static_shapes(&self, kept: &[usize], count: usize, smallest: f64) -> Vec<DVector<f64>> {
        let mut rests = self.energies.clone();
        kept.iter().for_each(|mode| rests.row_mut(*mode).fill(0.0));
        let mut shapes: Vec<DVector<f64>> = Vec::new();
        while shapes.len() < count {
            let sizes: Vec<f64> = rests.column_iter().map(|rest| rest.norm_squared()).collect();
            let largest = sizes.iter().copied().fold(0.0, f64::max);
            if largest <= smallest.max(DEPENDENCE_TOLERANCE) {
                break;
            }
            // Round-off does not choose among equal rests: the last interface has priority.
            let is_largest = |size: &f64| *size >= (1.0 - DEPENDENCE_TOLERANCE) * largest;
            let Some(largest) = sizes.iter().rposition(is_largest) else { break };
            let mut shape = rests.column(largest).into_owned();
            for known in &shapes {
                shape.axpy(-known.dot(&shape), known, 1.0);
            }
            shape.normalize_mut();
            for mut rest in rests.column_iter_mut() {
                rest.axpy(-shape.dot(&rest), &shape, 1.0);
            }
            shapes.push(shape);
        }
        shapes
    }
}

/// A subspace of the modes of a model.
struct Subspace<'a> {
    model: &'a Model,
    all: &'a RealModes,
    /// Speed of the reference shaft that determines the flanks in contact, rad/s.
    speed: f64,
}

impl Subspace<'_> {
    /// Undamped modes of the subspace of the rigid-body modes, the `kept` elastic ones, the static shapes, scaled by ω, and
    /// the displacements `growing`.
    fn modes(
        &self,
        kept: &[usize],
        statics: &[DVector<f64>],
        growing: &DMatrix<f64>,
    ) -> Result<RealModes, DecompositionError> {
        let Self { model, all, speed } = *self;
        let (null, elastic) = (all.null, all.frequencies.len() - all.null);
        let frequencies = all.frequencies.rows(null, elastic);
        let shapes = all.vectors.columns(null, elastic);
        let mut further: Vec<DVector<f64>> = Vec::new();
        let scale = DMatrix::from_fn(elastic, growing.ncols(), |mode, _| frequencies[mode]);
        let growing = (shapes.transpose() * model.mass_times(growing)).component_mul(&scale);
        for given in growing.column_iter().map(|column| column.into_owned()).chain(statics.iter().cloned()) {
            let mut rest = given.clone();
            kept.iter().for_each(|mode| rest[*mode] = 0.0);
            for _ in 0..2 {
                for known in &further {
                    rest.axpy(-known.dot(&rest), known, 1.0);
                }
            }
            if rest.norm_squared() > DEPENDENCE_TOLERANCE * given.norm_squared() {
                further.push(rest.normalize());
            }
        }
        let mut vectors = DMatrix::zeros(model.len(), null + kept.len() + further.len());
        vectors.columns_mut(0, null).copy_from(&all.vectors.columns(0, null));
        for (column, mode) in kept.iter().enumerate() {
            vectors.set_column(null + column, &shapes.column(*mode));
        }
        if !further.is_empty() {
            // The shapes are orthonormal in K: the pencil is that of M and the identity.
            let displacements =
                DMatrix::from_fn(elastic, further.len(), |mode, column| further[column][mode] / frequencies[mode]);
            let size = further.len();
            let mass = displacements.transpose() * &displacements;
            let pencil = symmetric_pencil(&DMatrix::identity(size, size), &mass, &DMatrix::zeros(size, 0))?;
            vectors.columns_mut(null + kept.len(), size).copy_from(&(shapes * (displacements * pencil.vectors)));
        }
        Ok(RealModes::of_shapes(model, speed, vectors, null))
    }
}
