//! A model together with its modes and state-space models, computed on first use and kept.

use std::ops::Deref;
use std::sync::{Arc, OnceLock};

use nalgebra::{DMatrix, DVector};
use num_complex::Complex64;

use super::dynamic_solver::{DynamicKey, DynamicStiffnessSolver};
use super::recent::Recent;
use crate::connection::Row;
use crate::linalg::{DecompositionError, Singular, Sparse, matrix_of_columns};
use crate::mesh::Geometry;
use crate::modal::equilibrium::{EquilibriumError, EquilibriumSpeeds, equilibrium};
use crate::modal::lowest::{
    Highest, LowestModes, MIN_BANDED, ModalSpace, UndampedSearch, UndampedSpace, lowest_undamped,
};
use crate::modal::state_space::{FirstOrder, ModalStateSpace, Projected, StateMatrix};
use crate::modal::undamped::{
    ComponentModes, ModalDamping, RealModes, SpectralRange, SubspaceKey, kept_modes, modes_of_loads,
};
use crate::model::Model;

/// Multiple of the highest frequency that the teeth excite up to which undamped modes show the growing modes. Oil films and
/// circulating forces let modes below the speed of rotation grow.
const GROWTH_LIMIT: f64 = 2.0;

/// Part of the highest frequency of a space of undamped modes up to which it approximates the eigenvalues of a model. The
/// relative error is about the fourth power of this part.
const MAX_APPROXIMATED: f64 = 0.4;

/// What a state-space model reads beside its model.
#[derive(Clone, Copy, Debug, PartialEq)]
struct LinearKey {
    /// Speed of the reference shaft, rad/s.
    speed: f64,
    /// Whether the meshes are included.
    includes_meshes: bool,
}

/// What the solver of a dynamic stiffness reads beside its model.
#[derive(Clone, Copy, Debug, PartialEq)]
struct SolverKey {
    /// Speed and frequency.
    at: DynamicKey,
    /// Highest frequency in question for modal damping; none without.
    highest: Option<Highest>,
}

/// What modal damping reads beside its model.
#[derive(Clone, Copy, Debug, PartialEq)]
struct DampingKey {
    /// Direction of rotation.
    rotation: usize,
    /// Highest frequency in question.
    highest: Highest,
}

/// What the lowest undamped modes read beside their model.
#[derive(Clone, Copy, Debug, PartialEq)]
struct LowestKey {
    /// Direction of rotation.
    rotation: usize,
    /// Which ones.
    wanted: LowestModes,
}

/// What the undamped modes of a large model up to a frequency read beside it.
#[derive(Clone, Debug, PartialEq)]
struct SynthesisKey {
    /// Direction of rotation.
    rotation: usize,
    /// Highest frequency of the component modes, rad/s.
    highest: f64,
    /// Loads whose static displacements are exact, as entries (index, coefficient).
    loads: Vec<Row>,
}

/// What a model in given modes reads beside it.
#[derive(Clone, Debug, PartialEq)]
struct GivenModesKey {
    /// Speed of the reference shaft, rad/s.
    speed: f64,
    /// Modes whose displacements the model can have.
    modes: Arc<RealModes>,
}

/// The inputs, besides the model, on which its growing modes depend.
#[derive(Clone, Copy, Debug, PartialEq)]
struct GrowthKey {
    /// Speed of the reference shaft, rad/s.
    speed: f64,
    /// Highest frequency of the undamped modes in which they are found, rad/s; none for all modes.
    highest: Option<f64>,
}

/// What a static equilibrium reads beside its model.
#[derive(Clone, Copy, Debug, PartialEq)]
struct EquilibriumKey {
    /// Geometry of the meshes.
    geometry: Geometry,
    /// Speeds of bearings and flanks.
    speeds: EquilibriumSpeeds,
}

/// What follows from the linear part of a model alone, computed on first use: of the loads, only torques over the speed have an
/// effect on it, their damping.
#[derive(Debug, Default)]
struct LinearPart {
    /// Undamped modes for each [`crate::model::Rotation`].
    modes: [OnceLock<Result<RealModes, DecompositionError>>; 3],
    /// Lowest and highest frequency for each [`crate::model::Rotation`].
    ranges: [OnceLock<Result<SpectralRange, DecompositionError>>; 3],
    /// Lowest undamped modes; none where sparse matrices do not give them.
    lowest: Recent<LowestKey, Option<Arc<UndampedSpace>>, 2>,
    /// Modal damping.
    damping: Recent<DampingKey, Arc<ModalDamping>>,
    /// State-space models; `None` marks a model that modes cannot represent.
    linear: Recent<LinearKey, Option<Arc<ModalStateSpace>>>,
    /// Undamped modes of the components.
    components: OnceLock<Result<ComponentModes, DecompositionError>>,
    /// Undamped modes of a large model from those of its components.
    synthesised: Recent<SynthesisKey, Arc<RealModes>>,
    /// Displacements of growing modes; `None` where nearly parallel modes hide them.
    growing: Recent<GrowthKey, Option<Arc<DMatrix<f64>>>>,
    /// The modes that runs keep.
    subspaces: Recent<SubspaceKey, Arc<Projected>>,
    /// Reduced models whose modes the caller gives: those of another speed, or of another system with the same coordinates.
    in_given_modes: Recent<GivenModesKey, Arc<Projected>>,
    /// Dynamic stiffness at the last speeds; a singular one has no solver.
    dynamic: Recent<SolverKey, Arc<Result<DynamicStiffnessSolver, Singular>>>,
    /// Transposed stiffness and rate matrices at speeds of the reference shaft and of its flanks, rad/s.
    transposed: Recent<[f64; 2], Arc<OnceLock<[Sparse; 2]>>>,
    /// The linear parts at the speeds (rad/s) of the last analyses, if bearings depend on the speed.
    at_speeds: Recent<f64, Arc<LinearPart>>,
}

/// A model with its undamped modes and its most recent state-space models.
#[derive(Debug)]
pub struct CachedModel {
    /// Assembled model.
    pub model: Model,
    /// Modes and state-space models, which models with other loads may share.
    linear_part: OnceLock<Arc<LinearPart>>,
    /// Models at the speeds (rad/s) of the last analyses, if bearings depend on the speed.
    at_speeds: Recent<f64, Arc<CachedModel>>,
    /// The same model with circulatory forces of other speeds (rad/s).
    circulations: Recent<f64, Arc<CachedModel>>,
    /// Models at the speeds and frequencies of the last analyses, if bearings depend on the frequency.
    at_frequencies: Recent<[f64; 2], Arc<CachedModel>>,
    /// What the models at all speeds share, if bearings depend on the speed.
    nominal: OnceLock<Arc<Nominal>>,
    /// Displacements of the last static equilibria.
    equilibria: Recent<EquilibriumKey, DVector<f64>>,
}

/// A model whose undamped modes are close to those at any speed.
#[derive(Debug)]
struct Nominal {
    cached: CachedModel,
    /// Loads on the bearings that depend on the speed.
    rows: Vec<Row>,
    /// Spaces of few undamped modes at all speeds, by direction of rotation and number of modes.
    small_spaces: Recent<[usize; 2], Option<Arc<ModalSpace>>>,
    /// Spaces of the undamped modes at all speeds.
    spaces: Recent<DampingKey, Arc<ModalSpace>>,
}

/// A model at a constant speed: the model itself if nothing in it depends on the speed.
#[derive(Clone, Debug)]
pub enum AtSpeed<'a> {
    /// The model itself.
    Same(&'a CachedModel),
    /// A model whose bearings have the coefficients of the speed.
    Specialised(Arc<CachedModel>),
}

impl Deref for AtSpeed<'_> {
    type Target = CachedModel;

    fn deref(&self) -> &CachedModel {
        match self {
            Self::Same(model) => model,
            Self::Specialised(model) => model,
        }
    }
}

impl CachedModel {
    /// Wraps a model; nothing is computed yet.
    pub fn new(model: Model) -> Self {
        Self {
            model,
            linear_part: OnceLock::new(),
            at_speeds: Recent::default(),
            circulations: Recent::default(),
            at_frequencies: Recent::default(),
            nominal: OnceLock::new(),
            equilibria: Recent::default(),
        }
    }

    /// Shares the modes and state-space models of `other`, which has the same linear part. Has no effect after the first
    /// analysis of this model.
    pub fn share(&self, other: &Self) {
        self.linear_part.get_or_init(|| Arc::clone(other.linear_part()));
    }

    fn linear_part(&self) -> &Arc<LinearPart> {
        self.linear_part.get_or_init(Arc::default)
    }

    /// The model at a constant speed of the reference shaft, rad/s; see [`Model::with_tables_at`]. Nonlinear bearings have the
    /// coefficients of the static equilibrium at that speed, with live geometry of the meshes.
    ///
    /// # Errors
    /// [`EquilibriumError`] if a bearing has no coefficients, or a torque no value, at the speed, or nonlinear bearings have
    /// no equilibrium.
    pub fn at_speed(&self, speed: f64) -> Result<AtSpeed<'_>, EquilibriumError> {
        if self.model.is_at_speed(speed) {
            self.model.check_speed(speed)?;
            return Ok(AtSpeed::Same(self));
        }
        let speed = self.model.static_speed(speed);
        if let Some(known) = self.at_speeds.get(&speed) {
            return Ok(AtSpeed::Specialised(known));
        }
        self.model.check_speed(speed)?;
        let model = self.model.with_tables_at(speed)?;
        let model = if model.is_at_speed(speed) { Self::new(model) } else { at_equilibrium(model, speed)? };
        model.nominal.get_or_init(|| Arc::clone(self.nominal.get_or_init(|| Arc::new(self.nominal_at(&model.model)))));
        model.linear_part.get_or_init(|| self.linear_part().at_speed(speed));
        let model = Arc::new(model);
        self.at_speeds.insert(speed, Arc::clone(&model));
        Ok(AtSpeed::Specialised(model))
    }

    /// The one model that stands for the model at all of some speeds of the reference shaft, rad/s; without one, the model itself.
    ///
    /// # Errors
    /// As [`Self::at_speed`].
    pub fn common_to(&self, speeds: &[f64]) -> Result<AtSpeed<'_>, EquilibriumError> {
        let mut known = speeds.iter().map(|speed| self.model.static_speed(*speed));
        match known.next() {
            Some(first) if known.all(|speed| speed == first) && !self.model.depends_on_frequency() => {
                self.at_speed(first)
            }
            _ => Ok(AtSpeed::Same(self)),
        }
    }

    /// The model at a speed of the reference shaft with the circulatory forces of internal damping at another one, both rad/s: that
    /// of the linear motion of a run at a changing speed.
    ///
    /// # Errors
    /// As [`Self::at_speed`].
    pub fn with_circulation_at(&self, speed: f64, circulation: f64) -> Result<AtSpeed<'_>, EquilibriumError> {
        let at_speed = self.at_speed(speed)?;
        if at_speed.model.circulation.is_none_or(|own| own == circulation) {
            return Ok(at_speed);
        }
        let found = at_speed.circulations.get_or(circulation, || {
            let mut model = at_speed.model.clone();
            model.circulation = Some(circulation);
            let made = Self::new(model);
            // Variations of the system have the same modes.
            made.linear_part.get_or_init(|| at_speed.linear_part().at_speed(circulation));
            Arc::new(made)
        });
        Ok(AtSpeed::Specialised(found))
    }

    /// The model at a constant speed of the reference shaft and a frequency of the vibration, both rad/s. Only the coefficients of
    /// bearings with tables over the frequency depend on the latter. Nonlinear bearings have the coefficients of the static
    /// equilibrium, which has the frequency zero.
    ///
    /// # Errors
    /// As [`Self::at_speed`], and if a bearing has no coefficients at the frequency.
    pub fn at(&self, speed: f64, frequency: f64) -> Result<AtSpeed<'_>, EquilibriumError> {
        if !self.model.depends_on_frequency() {
            return self.at_speed(speed);
        }
        let key = [speed, frequency.abs()];
        if let Some(known) = self.at_frequencies.get(&key) {
            return Ok(AtSpeed::Specialised(known));
        }
        let model = if frequency == 0.0 {
            self.model.at_frequency(0.0)?
        } else {
            self.with_operating_points_of(speed)?.model.at_frequency(frequency)?
        };
        let made = Self::new(model);
        if self.nominal.get().is_none() {
            let mut first = made.model.with_tables_at(speed)?;
            if !first.nonlinear_bearings.is_empty() {
                first = first.with_initial_operating_points();
            }
            self.nominal.get_or_init(|| Arc::new(self.nominal_at(&first)));
        }
        if let Some(nominal) = self.nominal.get() {
            made.nominal.get_or_init(|| Arc::clone(nominal));
        }
        let specialised = match made.at_speed(speed)? {
            AtSpeed::Specialised(model) => Some(model),
            AtSpeed::Same(_) => None,
        };
        let found = specialised.unwrap_or_else(|| Arc::new(made));
        self.at_frequencies.insert(key, Arc::clone(&found));
        Ok(AtSpeed::Specialised(found))
    }

    /// The model whose nonlinear bearings have their initial stiffness; with bearings that have tables over the speed, the first
    /// model at a speed, `first`.
    fn nominal_at(&self, first: &Model) -> Nominal {
        let tables = self.model.bearings.iter().flat_map(|bearing| bearing.rows.iter().cloned());
        let nonlinear = self.model.nonlinear_bearings.iter().flat_map(|bearing| bearing.rows.iter().cloned());
        let rows = tables.chain(nonlinear).collect();
        let model = if self.model.bearings.is_empty() && !self.model.circulates() {
            self.model.clone().with_initial_operating_points()
        } else {
            first.clone()
        };
        Nominal { cached: Self::new(model), rows, spaces: Recent::default(), small_spaces: Recent::default() }
    }

    /// The model whose nonlinear bearings have the coefficients of a speed of the reference shaft, rad/s, while tables of
    /// bearings keep their dependence on the speed: the model of a run at a changing speed.
    ///
    /// # Errors
    /// As [`Self::at_speed`].
    pub fn with_operating_points_of(&self, speed: f64) -> Result<AtSpeed<'_>, EquilibriumError> {
        if self.model.nonlinear_bearings.is_empty() {
            return Ok(AtSpeed::Same(self));
        }
        let at_speed = self.at(speed, 0.0)?;
        let mut points = at_speed.model.nonlinear_bearings.iter().filter_map(|bearing| bearing.point);
        let model = self.model.clone();
        let points: Vec<_> = model.nonlinear_bearings.iter().map(|bearing| bearing.turning).zip(&mut points).collect();
        let of = |turning: usize| points.iter().find(|(known, _)| *known == turning).map(|(_, point)| *point);
        let model = model.with_operating_points(|bearing| of(bearing.turning).unwrap_or_default());
        Ok(AtSpeed::Specialised(Arc::new(Self::new(model))))
    }

    /// Displacements of the static equilibrium, as [`equilibrium`].
    ///
    /// # Errors
    /// As [`equilibrium`].
    pub fn equilibrium(&self, geometry: Geometry, speeds: EquilibriumSpeeds) -> Result<DVector<f64>, EquilibriumError> {
        let [film, flanks] = [speeds.film, speeds.flanks].map(|speed| self.model.static_speed(speed));
        let key = EquilibriumKey { geometry, speeds: EquilibriumSpeeds { film, flanks } };
        self.equilibria.get_or_try(key, || equilibrium(&self.model, key.geometry, key.speeds))
    }

    /// Undamped modes, with the loaded tooth flanks of `speed` (reference shaft, rad/s).
    ///
    /// # Errors
    /// [`DecompositionError`] if the decomposition fails, or a bearing depends on the speed.
    pub fn real_modes(&self, speed: f64) -> Result<&RealModes, DecompositionError> {
        if self.model.needs_speed() {
            return Err(DecompositionError::SpeedDependent);
        }
        let rotation = self.model.rotation(speed);
        let cell = &self.linear_part().modes[rotation as usize];
        cell.get_or_init(|| RealModes::new(&self.model, rotation.speed())).as_ref().map_err(|error| *error)
    }

    /// Lowest and highest undamped frequency, with the loaded tooth flanks of `speed` (reference shaft, rad/s).
    ///
    /// # Errors
    /// [`DecompositionError`] if an iteration fails, or a bearing depends on the speed.
    pub fn spectral_range(&self, speed: f64) -> Result<&SpectralRange, DecompositionError> {
        if self.model.needs_speed() {
            return Err(DecompositionError::SpeedDependent);
        }
        let rotation = self.model.rotation(speed);
        let cell = &self.linear_part().ranges[rotation as usize];
        let range = || {
            // The choice does not depend on what is known, so that the same run has the same steps.
            if self.model.len() < MIN_BANDED {
                Ok(SpectralRange::of_modes(self.real_modes(rotation.speed())?))
            } else {
                SpectralRange::new(&self.model, rotation.speed())
            }
        };
        cell.get_or_init(range).as_ref().map_err(|error| *error)
    }

    /// State-space model of the complete system at `speed` of the reference shaft, rad/s.
    ///
    /// # Errors
    /// [`DecompositionError`] if a decomposition fails.
    pub fn linear(&self, speed: f64) -> Result<Arc<ModalStateSpace>, DecompositionError> {
        let key = LinearKey { speed, includes_meshes: true };
        let known = &self.linear_part().linear;
        if let Some(Some(linear)) = known.get(&key) {
            return Ok(linear);
        }
        let linear = Arc::new(ModalStateSpace::new(self.real_modes(key.speed)?, &self.first_order(key.speed)?)?);
        known.insert(key, Some(Arc::clone(&linear)));
        Ok(linear)
    }

    /// State-space model at `speed` without the meshes, so that shafts are uncoupled; `None` if the modes are too
    /// ill-conditioned to represent it.
    ///
    /// # Errors
    /// [`DecompositionError`] if a decomposition fails.
    pub fn linear_without_meshes(&self, speed: f64) -> Result<Option<Arc<ModalStateSpace>>, DecompositionError> {
        let key = LinearKey { speed, includes_meshes: false };
        let find = || Ok(ModalStateSpace::without_meshes(&self.model, key.speed)?.map(Arc::new));
        self.linear_part().linear.get_or_try(key, find)
    }

    /// The complete model at `speed` of the reference shaft, rad/s, in its undamped modes.
    ///
    /// # Errors
    /// [`DecompositionError`] if the undamped modes cannot be computed.
    pub fn projected(&self, speed: f64) -> Result<Projected, DecompositionError> {
        let projected = Projected::new(&self.model, self.real_modes(speed)?.clone(), speed);
        Ok(projected.with_state_space(self.linear(speed)?))
    }

    /// Undamped modes of the components.
    ///
    /// # Errors
    /// [`DecompositionError`] if a decomposition fails.
    pub fn component_modes(&self) -> Result<&ComponentModes, DecompositionError> {
        self.linear_part()
            .components
            .get_or_init(|| ComponentModes::new(&self.model, None))
            .as_ref()
            .map_err(|error| *error)
    }

    /// Undamped modes that `loads` (n entries each) excite, in a Krylov space of `steps` vectors, with the loaded tooth flanks
    /// of `speed` (reference shaft, rad/s). Time and memory are proportional to n.
    ///
    /// # Errors
    /// [`DecompositionError`] if a decomposition fails, or a bearing depends on the speed.
    pub fn modes_of_loads(
        &self,
        speed: f64,
        loads: &[Vec<f64>],
        steps: usize,
    ) -> Result<RealModes, DecompositionError> {
        modes_of_loads(&self.model, speed, self.spectral_range(speed)?, loads, steps)
    }

    /// The model in the modes that a run keeps.
    ///
    /// # Errors
    /// [`DecompositionError`] if a decomposition fails.
    pub fn subspace(&self, key: SubspaceKey) -> Result<Arc<Projected>, DecompositionError> {
        let speed = key.speeds[0];
        if key.highest.is_none() && key.extent.is_none() {
            return self.projected(speed).map(Arc::new);
        }
        self.linear_part().subspaces.get_or_try(key.clone(), || {
            let synthesised = key
                .highest
                .map(|highest| self.synthesised(speed, highest, [&key.coordinates[..], &key.distributed].concat()));
            let synthesised = synthesised.transpose()?;
            let all = match &synthesised {
                Some(modes) => modes,
                None => self.real_modes(speed)?,
            };
            let growing = if key.extent.is_some() { self.growing_of(&key)? } else { None };
            let modes = match growing {
                Some(growing) => kept_modes(&self.model, all, &key, &growing)?,
                // All are kept, or nearly parallel modes hide which ones grow.
                None => all.clone(),
            };
            Ok(Arc::new(Projected::new(&self.model, modes, speed)))
        })
    }

    /// The model at `speed` of the reference shaft, rad/s, in the displacements of `modes`: those of another speed, or of a
    /// system with the same coordinates.
    ///
    /// # Errors
    /// [`DecompositionError`] if a decomposition fails.
    pub fn in_modes(&self, modes: &Arc<RealModes>, speed: f64) -> Result<Arc<Projected>, DecompositionError> {
        let key = GivenModesKey { speed, modes: Arc::clone(modes) };
        self.linear_part().in_given_modes.get_or_try(key, || {
            let own = RealModes::in_subspace(&self.model, speed, &modes.vectors)?;
            Ok(Arc::new(Projected::new(&self.model, own, speed)))
        })
    }

    /// Displacements of the growing modes at the speeds of a key, n rows; `None` if nearly parallel modes hide them. The modes
    /// of a model that is large or has meshes are those up to a frequency, with the static displacements at coupled coordinates.
    fn growing_of(&self, key: &SubspaceKey) -> Result<Option<DMatrix<f64>>, DecompositionError> {
        let (model, first) = (&self.model, key.speeds[0]);
        let mut columns: Vec<DVector<f64>> = Vec::new();
        for speed in key.speeds.iter().copied().filter(|speed| !model.is_dissipative(*speed)) {
            let is_limited = !model.meshes.is_empty() || key.highest.is_some();
            let highest = is_limited.then_some(GROWTH_LIMIT * key.excited);
            let find = || -> Result<_, DecompositionError> {
                let linear = if let Some(highest) = highest {
                    let loads = model.coupled_loads(first, []);
                    let modes = if key.highest.is_some() {
                        self.synthesised(first, highest, loads.clone())?.up_to(model, first, &loads, highest)?
                    } else {
                        self.real_modes(first)?.up_to(model, first, &loads, highest)?
                    };
                    Projected::new(model, modes, speed).state_space()?
                } else {
                    self.linear(speed)?
                };
                let is_known = matches!(linear.matrix, StateMatrix::Pairs(_));
                Ok(is_known.then(|| Arc::new(linear.growing_shapes(speed))))
            };
            let Some(found) = self.linear_part().growing.get_or_try(GrowthKey { speed, highest }, find)? else {
                return Ok(None);
            };
            columns.extend(found.column_iter().map(|column| column.into_owned()));
        }
        Ok(Some(matrix_of_columns(model.len(), &columns)))
    }

    /// Undamped modes in the subspace of the component modes up to `highest`, rad/s, and of the static displacements under
    /// `loads`; with the loaded tooth flanks of `speed` (reference shaft, rad/s).
    fn synthesised(&self, speed: f64, highest: f64, loads: Vec<Row>) -> Result<Arc<RealModes>, DecompositionError> {
        let rotation = self.model.rotation(speed);
        let key = SynthesisKey { rotation: rotation as usize, highest, loads };
        self.linear_part().synthesised.get_or_try(key.clone(), || {
            self.component_modes()?.modes(&self.model, rotation.speed(), &key.loads, highest).map(Arc::new)
        })
    }

    /// Solver of the dynamic stiffness, with modal damping for a highest frequency in question or without; a singular one has
    /// none.
    ///
    /// # Errors
    /// [`DecompositionError`] if the null motions or the undamped modes cannot be found.
    pub fn dynamic_solver(
        &self,
        at: DynamicKey,
        highest: Option<Highest>,
    ) -> Result<Arc<Result<DynamicStiffnessSolver, Singular>>, DecompositionError> {
        self.linear_part().dynamic.get_or_try(SolverKey { at, highest }, || {
            let modal = highest.map(|highest| self.modal_damping(at.flank_speed, highest)).transpose()?;
            let transposed = self.linear_part().transposed.get_or([at.speed, at.flank_speed], Arc::default);
            let solver = DynamicStiffnessSolver::new(&self.model, at, modal.flatten())?;
            Ok(Arc::new(solver.map(|solver| solver.sharing(transposed))))
        })
    }

    /// First-order form of the complete system at `speed` of the reference shaft, rad/s.
    pub(in crate::modal) fn first_order(&self, speed: f64) -> Result<FirstOrder, DecompositionError> {
        let model = &self.model;
        let damping = self.damping_matrix(speed)? + model.gyroscopic_matrix() * speed;
        Ok(FirstOrder::new(self.real_modes(speed)?, &damping, &model.skew_part_matrix()))
    }

    /// Damping matrix C of shafts, bearings and meshes, n × n in the order of the core, including modal damping.
    ///
    /// # Errors
    /// [`DecompositionError`] if the modes that modal damping needs cannot be computed.
    pub fn damping_matrix(&self, speed: f64) -> Result<DMatrix<f64>, DecompositionError> {
        let mut matrix = self.model.damping_matrix(speed);
        if let Some(modal) = self.modal_damping_matrix(speed)? {
            matrix += modal;
        }
        Ok(matrix)
    }

    /// Approximations of the eigenvalues with Im λ ≥ 0 of lowest magnitude, rad/s, in the space of the `count` lowest undamped
    /// modes and of static displacements under loads on the bearings; `None` for a model that is the same at every speed.
    ///
    /// # Errors
    /// [`DecompositionError`] if a decomposition fails.
    pub fn approximate_eigenvalues(
        &self,
        speed: f64,
        count: usize,
    ) -> Result<Option<Vec<Complex64>>, DecompositionError> {
        let Some(nominal) = self.nominal.get() else {
            return Ok(None);
        };
        let rotation = self.model.rotation(speed);
        let find = || -> Result<_, DecompositionError> {
            let found = nominal
                .cached
                .undamped_search(rotation.speed(), |search| ModalSpace::of_lowest(search, &nominal.rows, count))?;
            Ok(found.map(Arc::new))
        };
        let Some(space) = nominal.small_spaces.get_or_try([rotation as usize, count], find)? else {
            return Ok(None);
        };
        let mut values = space.project(&self.model, speed)?.eigenvalues()?;
        values.retain(|value| value.norm() < MAX_APPROXIMATED * space.highest);
        Ok(Some(values))
    }

    /// Calls `find` with the search for undamped modes at `speed` of the reference shaft, rad/s.
    fn undamped_search<T>(
        &self,
        speed: f64,
        find: impl FnOnce(&UndampedSearch<'_>) -> Result<T, DecompositionError>,
    ) -> Result<T, DecompositionError> {
        let (range, rotation) = (self.spectral_range(speed)?, self.model.rotation(speed));
        let lowest = |wanted: LowestModes| {
            let find = || Ok(lowest_undamped(&self.model, rotation.speed(), range, wanted)?.map(Arc::new));
            self.linear_part().lowest.get_or_try(LowestKey { rotation: rotation as usize, wanted }, find)
        };
        let all = || self.real_modes(speed);
        find(&UndampedSearch { model: &self.model, speed, range, lowest: &lowest, all: &all })
    }

    /// Modal damping for a highest frequency in question; `None` if the scene has none.
    ///
    /// # Errors
    /// [`DecompositionError`] if the undamped modes cannot be found.
    pub fn modal_damping(&self, speed: f64, highest: Highest) -> Result<Option<Arc<ModalDamping>>, DecompositionError> {
        if self.model.scene.modal_damping.is_zero() {
            return Ok(None);
        }
        self.damped_modes(speed, highest).map(Some)
    }

    /// The same for any damping ratios, also for zero.
    ///
    /// # Errors
    /// As [`Self::modal_damping`].
    pub fn damped_modes(&self, speed: f64, highest: Highest) -> Result<Arc<ModalDamping>, DecompositionError> {
        let rotation = self.model.rotation(speed);
        let key = DampingKey { rotation: rotation as usize, highest };
        let find = || match self.nominal.get() {
            // All modes are those of this speed.
            Some(nominal) if highest != Highest::Frequency(f64::INFINITY) => {
                let space = || {
                    nominal.cached.undamped_search(rotation.speed(), |search| {
                        ModalSpace::new(search, &nominal.rows, highest).map(Arc::new)
                    })
                };
                let space = nominal.spaces.get_or_try(key, space)?;
                space.damping(&self.model, rotation.speed()).map(Arc::new)
            }
            _ => self.undamped_search(rotation.speed(), |search| search.damping(highest).map(Arc::new)),
        };
        self.linear_part().damping.get_or_try(key, find)
    }

    /// Modal damping matrix MΦ·diag(2ζω)·ΦᵀM of all modes, n × n; `None` if the scene has no modal damping.
    ///
    /// # Errors
    /// [`DecompositionError`] if the modes cannot be computed.
    pub fn modal_damping_matrix(&self, speed: f64) -> Result<Option<DMatrix<f64>>, DecompositionError> {
        if self.model.scene.modal_damping.is_zero() {
            return Ok(None);
        }
        Ok(Some(self.real_modes(speed)?.damping_matrix(&self.model)))
    }
}

/// The model with the coefficients of its nonlinear bearings at the static equilibrium at a speed, rad/s, which it keeps.
fn at_equilibrium(model: Model, speed: f64) -> Result<CachedModel, EquilibriumError> {
    let model = model.with_initial_operating_points();
    let q = equilibrium(&model, Geometry::Live, speed.into())?;
    let cached = CachedModel::new(model.with_operating_points_at(speed, q.as_slice()));
    cached.equilibria.insert(EquilibriumKey { geometry: Geometry::Live, speeds: speed.into() }, q);
    Ok(cached)
}

impl LinearPart {
    /// The linear part at a speed of the reference shaft, rad/s.
    fn at_speed(&self, speed: f64) -> Arc<Self> {
        if let Some(known) = self.at_speeds.get(&speed) {
            return known;
        }
        let found = Arc::new(Self::default());
        self.at_speeds.insert(speed, Arc::clone(&found));
        found
    }
}
