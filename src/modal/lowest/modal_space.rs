//! The undamped modes of low frequency with modal damping, of one model or at all speeds.
//!
//! If bearings change with the speed, D = MV R VᵀM with a space V that contains the modes at every speed, and R
//! = Q diag(2ζω) Qᵀ for the modes Φ = VQ: a new speed takes a small eigenproblem. If all modes have damping, R changes only in the
//! first coordinates of V: in the lowest modes of one model and the displacements (K + s²M)⁻¹w under loads w on the bearings. The
//! change of a matrix function by a matrix of low rank lies nearly in such a space (Beckermann, Kressner and Schweitzer 2018):
//!
//! ```text
//! R(Ω) = R₀ + f(A(Ω)) − f(A₀),    A = V₁ᵀKV₁,    f(A) = Q diag(2ζω) Qᵀ for A = Q diag(ω²) Qᵀ
//! ```

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};

use super::arnoldi::{UndampedSpace, first_steps, most_steps, undamped_modes};
use super::shift_invert::Problem;
use crate::connection::Row;
use crate::linalg::{DecompositionError, matrix_of_columns, symmetric_eigen};
use crate::modal::state_space::Projected;
use crate::modal::undamped::{
    ModalDamping, RealModes, ShiftInverse, SpectralRange, UndampedInverse, null_motions, times,
};
use crate::model::Model;
use crate::numerics::{ROOT_OF_ROUND_OFF, ROUND_OFF};

/// Smallest number of modes with damping in responses. In the machines of `examples/machines` with a ratio of 0.01, the others change
/// responses to bow and unbalance by less than 1e-5 of their size.
const MIN_DAMPED_MODES: usize = 80;
/// Smallest ratio of the highest frequency with damping to the highest one in question. The approximations of the Krylov space beyond
/// have damping as well for eigenvalues: with the 36 accurate modes that the 12th mode asks for, those of the same machines change by up
/// to 1.3e-6 of their size, with the approximations by 5e-7 at most, and in all but `gearbox` by 4e-9. In a
/// Campbell diagram of 14 modes of `gearbox` 3e-6 remain.
const FREQUENCY_MARGIN: f64 = 8.0;
/// Part of all modes up to which a Krylov space gives the lowest ones faster than dense matrices give all.
const MAX_KRYLOV_FRACTION: f64 = 0.3;
/// Smallest number of degrees of freedom for which sparse matrices give few modes or responses faster than dense ones.
pub const MIN_BANDED: usize = 100;
/// Largest number of degrees of freedom for which dense matrices replace sparse matrices that do not give an answer. All modes of
/// such a model take minutes.
pub const MAX_DENSE: usize = 2000;
/// Smallest number of lowest modes in which damping of all modes changes with the speed, and number of real shifts of the displacements
/// beside them. Forces on any coordinates of `overhung_rotor` then cause responses within 2e-10 of those with the modes of each speed;
/// with 20 modes and one shift within 2e-8, with six modes and eight shifts within 3e-10.
const MIN_CHANGING_MODES: usize = 20;
const SHIFTS: usize = 8;

/// Highest frequency in question.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Highest {
    /// This frequency, rad/s.
    Frequency(f64),
    /// The undamped frequency of the mode with this number, rigid-body modes included.
    Mode(usize),
}

/// Which of the lowest undamped modes are wanted, rigid-body modes included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LowestModes {
    /// Smallest number.
    count: usize,
    /// Highest frequency in question, beyond which the modes reach by [`FREQUENCY_MARGIN`]; none for the number alone.
    highest: Option<Highest>,
}

impl LowestModes {
    /// The modes with damping for a highest frequency in question.
    fn damped(highest: Highest) -> Self {
        let count = match highest {
            // Frequencies of bending increase with the square of the number of the mode.
            Highest::Mode(number) => (FREQUENCY_MARGIN.sqrt() * number as f64).ceil() as usize,
            Highest::Frequency(_) => MIN_DAMPED_MODES,
        };
        Self { count, highest: Some(highest) }
    }

    /// Whether these are all, for the frequencies of the lowest modes, rad/s, of a model of n = `size`.
    fn are_all(self, frequencies: &[f64], size: usize) -> bool {
        let highest = frequencies.last().copied().unwrap_or(0.0);
        let is_far = self.highest.is_none_or(|limit| match limit {
            Highest::Frequency(limit) => highest >= FREQUENCY_MARGIN * limit,
            Highest::Mode(number) => frequencies.get(number).is_some_and(|limit| highest >= FREQUENCY_MARGIN * limit),
        });
        // A large model has no dense matrices for more modes.
        let is_limit = size > MAX_DENSE && frequencies.len() >= most_modes(size);
        self.count <= frequencies.len() && is_far || is_limit
    }
}

/// Largest number of undamped modes from a Krylov space, for n = `size`.
fn most_modes(size: usize) -> usize {
    (MAX_KRYLOV_FRACTION * size as f64) as usize
}

/// A search for the lowest undamped modes of a model.
pub struct UndampedSearch<'m> {
    /// The model.
    pub model: &'m Model,
    /// Speed of the reference shaft whose loaded tooth flanks are in contact, rad/s.
    pub speed: f64,
    /// Lowest and highest frequency.
    pub range: &'m SpectralRange,
    /// Lowest modes from sparse matrices; none if these do not give them.
    pub lowest: &'m dyn Fn(LowestModes) -> Result<Option<Arc<UndampedSpace>>, DecompositionError>,
    /// All modes, where sparse matrices do not give the lowest ones.
    pub all: &'m dyn Fn() -> Result<&'m RealModes, DecompositionError>,
}

/// A space of displacements V that contains the undamped modes of low frequency at all speeds, because it contains those of one
/// model and the static displacements of the others under loads on the bearings (MacNeal 1971, Rubin 1975).
#[derive(Debug)]
pub struct ModalSpace {
    /// V, n × m, elastic motions orthonormal in M.
    shapes: DMatrix<f64>,
    /// MV.
    momenta: Arc<DMatrix<f64>>,
    /// ω of the damped modes of the one model, rad/s, ascending.
    frequencies: Vec<f64>,
    /// Number of the first columns of V, V₁, in which the damping changes.
    changing: usize,
    /// R₀, m × m, with −f(A₀) in the coordinates of V₁, 1/s.
    constant_rates: DMatrix<f64>,
    /// Highest frequency of the modes, rad/s.
    pub(in crate::modal) highest: f64,
    /// As [`ModalDamping::reach`].
    reach: f64,
}

/// The lowest undamped modes of a model at `speed` of the reference shaft, rad/s, from sparse matrices; `None` if these do
/// not give them.
///
/// # Errors
/// [`DecompositionError`] if a decomposition fails.
pub fn lowest_undamped(
    model: &Model,
    speed: f64,
    range: &SpectralRange,
    wanted: LowestModes,
) -> Result<Option<UndampedSpace>, DecompositionError> {
    let size = model.len();
    let mut most = most_steps::<UndampedInverse<'_>>(wanted.count);
    if wanted.highest.is_some() && size <= MAX_DENSE {
        // Dense matrices give more modes faster.
        if wanted.count.max(MIN_DAMPED_MODES) > most_modes(size) {
            return Ok(None);
        }
        most = first_steps::<UndampedInverse<'_>>(most_modes(size));
    }
    let problem = Problem::new(model, speed, range, None)?.without_damping();
    let approximates = matches!(wanted.highest, Some(Highest::Mode(_)));
    undamped_modes(&problem, wanted.count, most, approximates, |frequencies| wanted.are_all(frequencies, size))
}

impl UndampedSearch<'_> {
    /// The modal damping of the model for a highest frequency in question.
    ///
    /// # Errors
    /// [`DecompositionError`] if the undamped modes cannot be found.
    pub(in crate::modal) fn damping(&self, highest: Highest) -> Result<ModalDamping, DecompositionError> {
        let modes = self.damped_modes(highest)?;
        Ok(ModalDamping::new(self.model, &modes.modes, reach(&modes)))
    }

    /// The modes with damping for a highest frequency in question.
    fn damped_modes(&self, highest: Highest) -> Result<Arc<UndampedSpace>, DecompositionError> {
        let is_limited = highest != Highest::Frequency(f64::INFINITY) || self.model.len() > MAX_DENSE;
        if is_limited && let Some(modes) = (self.lowest)(LowestModes::damped(highest))? {
            return Ok(modes);
        }
        let modes = (self.all)()?.clone();
        Ok(Arc::new(UndampedSpace { highest: modes.highest(), modes }))
    }
}

impl ModalSpace {
    /// The space for a highest frequency in question: modes of `search`, and static displacements under the loads `rows`.
    ///
    /// # Errors
    /// [`DecompositionError`] if the undamped modes cannot be found.
    pub(in crate::modal) fn new(
        search: &UndampedSearch<'_>,
        rows: &[Row],
        highest: Highest,
    ) -> Result<Self, DecompositionError> {
        let modes = search.damped_modes(highest)?;
        Self::of_modes(search, rows, &modes)
    }

    /// The same with the `count` lowest modes; `None` if sparse matrices do not give them.
    ///
    /// # Errors
    /// [`DecompositionError`] if a decomposition fails.
    pub(in crate::modal) fn of_lowest(
        search: &UndampedSearch<'_>,
        rows: &[Row],
        count: usize,
    ) -> Result<Option<Self>, DecompositionError> {
        let Some(modes) = (search.lowest)(LowestModes { count, highest: None })? else {
            return Ok(None);
        };
        Self::of_modes(search, rows, &modes).map(Some)
    }

    /// The space of known modes and of static displacements.
    fn of_modes(search: &UndampedSearch<'_>, rows: &[Row], modes: &UndampedSpace) -> Result<Self, DecompositionError> {
        let (model, speed) = (search.model, search.speed);
        let (reach, UndampedSpace { modes, highest }) = (reach(modes), modes);
        let null = modes.null;
        let known = modes.vectors.clone();
        let damped = known.ncols() - null;
        let mut loads = DMatrix::zeros(model.len(), rows.len());
        for (row, mut load) in rows.iter().zip(loads.column_iter_mut()) {
            row.iter().for_each(|(index, coefficient)| load[*index] += coefficient);
        }
        let shift = search.range.slowest.unwrap_or(1.0);
        let mut statics = ShiftInverse::new(model, speed, shift)?.solve_columns(&loads)?;
        let norm = |x: nalgebra::DVectorView<'_, f64>| model.kinetic_form(x.into_owned().as_slice()).sqrt();
        let scale =
            DVector::from_iterator(rows.len(), statics.column_iter().map(|x| 1.0 / norm(x).max(f64::MIN_POSITIVE)));
        // The known modes are orthonormal in M.
        for _ in 0..2 {
            statics -= &known * (known.transpose() * model.mass_times(&statics));
        }
        let mut form = statics.transpose() * model.mass_times(&statics);
        form.iter_mut().enumerate().for_each(|(place, value)| {
            *value *= scale[place % rows.len()] * scale[place / rows.len()];
        });
        let found = symmetric_eigen(&form)?;
        let independent = (0..rows.len()).filter(|index| found.values[*index] > ROOT_OF_ROUND_OFF);
        let scaled = DMatrix::from_diagonal(&scale);
        let mut columns: Vec<DVector<f64>> = known.column_iter().skip(null).map(|column| column.into_owned()).collect();
        columns.extend(
            independent.map(|index| &statics * (&scaled * found.vectors.column(index)) / found.values[index].sqrt()),
        );
        let shapes = matrix_of_columns(model.len(), &columns);
        let mut space = Self {
            momenta: Arc::new(model.mass_times(&shapes)),
            frequencies: modes.frequencies.as_slice()[null..].to_vec(),
            changing: shapes.ncols(),
            constant_rates: DMatrix::zeros(shapes.ncols(), shapes.ncols()),
            shapes,
            highest: *highest,
            reach,
        };
        if space.changing == damped {
            space.separate_constant(model, speed, shift, &loads)?;
        }
        Ok(space)
    }

    /// Chooses a basis of which only the first vectors have damping that changes with the speed; all modes of the space must be damped.
    /// These vectors are the lowest modes, and what they leave of the displacements (K + s²M)⁻¹f under the `loads` f (n rows). The
    /// shifts s, rad/s, range from `slowest` to the highest frequency.
    fn separate_constant(
        &mut self,
        model: &Model,
        speed: f64,
        slowest: f64,
        loads: &DMatrix<f64>,
    ) -> Result<(), DecompositionError> {
        let ratios = &model.scene.modal_damping;
        let (lowest, size) = (ratios.numbered_modes().max(MIN_CHANGING_MODES), self.frequencies.len());
        if lowest >= size {
            return Ok(());
        }
        let (others, count) = (self.shapes.columns(lowest, size - lowest).into_owned(), size - lowest);
        let loads = others.transpose() * loads;
        let range = self.frequencies[size - 1] / slowest;
        let mut columns = Vec::with_capacity(SHIFTS * loads.ncols());
        for index in 0..SHIFTS {
            let shift = slowest * range.powf(index as f64 / (SHIFTS - 1) as f64);
            for load in loads.column_iter() {
                let mut response = load.into_owned();
                response.iter_mut().zip(&self.frequencies[lowest..]).for_each(|(x, w)| *x /= w * w + shift * shift);
                response.try_normalize_mut(0.0);
                columns.push(response);
            }
        }
        let responses = matrix_of_columns(count, &columns);
        let basis = symmetric_eigen(&-(&responses * responses.transpose()))?;
        let rates: Vec<f64> =
            self.frequencies.iter().enumerate().map(|(index, frequency)| ratios.rate(index, *frequency)).collect();
        let mut constant = DMatrix::from_diagonal(&DVector::from_column_slice(&rates));
        let scaled = DMatrix::from_fn(count, count, |row, column| rates[lowest + row] * basis.vectors[(row, column)]);
        constant.view_mut((lowest, lowest), (count, count)).copy_from(&(basis.vectors.transpose() * scaled));
        self.shapes.columns_mut(lowest, count).copy_from(&(others * &basis.vectors));
        self.momenta = Arc::new(model.mass_times(&self.shapes));
        self.changing = lowest + basis.values.iter().filter(|value| **value < -ROUND_OFF).count();
        self.constant_rates = constant - self.damping(model, speed)?.rates;
        Ok(())
    }

    /// A model in this space at `speed` of the reference shaft, rad/s.
    ///
    /// # Errors
    /// [`DecompositionError`] if a decomposition fails.
    pub(in crate::modal) fn project(&self, model: &Model, speed: f64) -> Result<Projected, DecompositionError> {
        let null = null_motions(model, speed)?;
        let columns: Vec<_> = null.column_iter().chain(self.shapes.column_iter()).map(|x| x.into_owned()).collect();
        let modes = RealModes::in_subspace(model, speed, &matrix_of_columns(model.len(), &columns))?;
        Ok(Projected::new(model, modes, speed))
    }

    /// Damping of the modes of a model in this space, with the loaded tooth flanks of `speed` (reference shaft, rad/s).
    ///
    /// # Errors
    /// [`DecompositionError`] if the decomposition of the projected stiffness fails.
    pub(in crate::modal) fn damping(&self, model: &Model, speed: f64) -> Result<ModalDamping, DecompositionError> {
        let shapes = self.shapes.columns(0, self.changing).into_owned();
        let stiffness = shapes.transpose() * times(&model.sparse_symmetric_stiffness(speed), &shapes);
        let modes = symmetric_eigen(&((&stiffness + stiffness.transpose()) / 2.0))?;
        let ratios = model.scene.modal_damping.clone();
        let kept = modes.vectors.columns(0, self.frequencies.len().min(self.changing)).into_owned();
        let mut scaled = kept.clone();
        let mut frequencies = self.frequencies.clone();
        for (index, mut column) in scaled.column_iter_mut().enumerate() {
            frequencies[index] = modes.values[index].max(0.0).sqrt();
            column *= ratios.rate(index, frequencies[index]);
        }
        frequencies.sort_by(f64::total_cmp);
        let mut rates = self.constant_rates.clone();
        let mut changing = rates.view_mut((0, 0), (self.changing, self.changing));
        changing += scaled * kept.transpose();
        Ok(ModalDamping { ratios, frequencies, momenta: Arc::clone(&self.momenta), rates, reach: self.reach })
    }
}

/// As [`ModalDamping::reach`], for these modes with damping.
fn reach(UndampedSpace { modes, highest }: &UndampedSpace) -> f64 {
    if modes.vectors.is_square() { f64::INFINITY } else { highest / FREQUENCY_MARGIN }
}
