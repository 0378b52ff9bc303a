//! Displacements, velocities and accelerations of selected coordinates, from modal states.

use nalgebra::{DMatrix, DVector};
use num_complex::Complex64;

use super::combinations::CombinationMap;
use super::state_map::StateMap;
use crate::exponential::loads::Loads;
use crate::exponential::propagator::{InterfaceMaps, Rows};
use crate::integrate::{Deferred, Halt, at_each};
use crate::linalg::semidefinite_root;
use crate::modal::ModalStateSpace;
use crate::model::Combination;
use crate::motion::PowerCoordinates;

/// Largest number of instants that are evaluated together.
pub const INSTANT_BATCH: usize = 8;
/// Largest number of instants that wait: the last outputs of a step are added to those of earlier steps.
pub const MAX_WAITING: usize = 2 * INSTANT_BATCH;

/// Coordinates that a run reads.
#[derive(Clone, Debug, Default)]
pub struct Selection {
    /// Indices of the displacements.
    pub displacements: Vec<usize>,
    /// Indices of the velocities.
    pub velocities: Vec<usize>,
    /// Indices of the accelerations.
    pub accelerations: Vec<usize>,
    /// Combinations of coordinates.
    pub combinations: Vec<Combination>,
    /// Indices of the displacements and of the velocities that outputs need besides the energies of the shafts, if the run
    /// records energies. `displacements` and `velocities` are then complete. The potentials of constant loads follow behind
    /// the displacements.
    pub without_energies: Option<[Vec<usize>; 2]>,
    /// Coordinates from which powers follow, if the run records energies.
    pub powers: Option<PowerCoordinates>,
}

/// Maps a state z to the selected displacements, velocities and accelerations.
#[derive(Clone, Debug)]
pub struct OutputMap {
    /// Indices of the displacements, then those of sums of displacements, which are written behind all coordinates.
    displacements: Vec<usize>,
    /// Indices of the velocities.
    velocities: Vec<usize>,
    /// Indices of the accelerations.
    accelerated: Vec<usize>,
    /// The displacements, then the velocities, m or rad and m/s or rad/s.
    map: StateMap,
    /// The map to the coordinates from which powers follow.
    pub(super) powers: Option<Box<OutputMap>>,
    /// The map to the energies of the shafts.
    pub(super) energies: Option<Box<ShaftEnergies>>,
    /// The map to the accelerations, if a run reads any.
    pub(in crate::exponential) accelerations: Option<Box<CombinationMap>>,
    /// The map to the combinations, if a run reads any.
    pub(in crate::exponential) combinations: Option<Box<CombinationMap>>,
    /// The map to scalars whose squares are the power of the distributed damping, if a run reads powers.
    damping: Option<StateMap>,
}

impl OutputMap {
    /// Collects the rows of a selection.
    pub fn new(loads: &Loads<'_>, linear: &ModalStateSpace, maps: &InterfaceMaps, selection: Selection) -> Self {
        let Selection { displacements, velocities, accelerations, combinations, without_energies, powers } = selection;
        let sums = powers.as_ref().map_or_else(Vec::new, |powers| powers.constant_loads().to_vec());
        let powers = powers.map(|PowerCoordinates { displacements, velocities, combinations }| {
            let coordinates = (displacements, velocities);
            let mut powers = Self::of_sums(loads, linear, coordinates, &combinations);
            powers.damping = Some(distributed_damping(loads, linear));
            Box::new(powers)
        });
        let map = |combinations: &[Combination]| {
            (!combinations.is_empty()).then(|| Box::new(CombinationMap::new(loads, linear, maps, combinations)))
        };
        let acceleration = |index: &usize| Combination { acceleration: vec![(*index, 1.0)], ..Combination::default() };
        let accelerated = accelerations;
        let of_coordinates: Vec<_> = accelerated.iter().map(acceleration).collect();
        let (accelerations, combinations) = (map(&of_coordinates), map(&combinations));
        let complete = Self::of_sums(loads, linear, (displacements, velocities), &[]);
        let Some([displacements, velocities]) = without_energies else {
            return Self { powers, accelerated, accelerations, combinations, ..complete };
        };
        let energies = Some(Box::new(ShaftEnergies::new(complete, loads.reference.len())));
        let motion = Self::of_sums(loads, linear, (displacements, velocities), &sums);
        Self { powers, energies, accelerated, accelerations, combinations, ..motion }
    }

    /// Collects the rows of displacements and velocities with these indices, and of sums of displacements.
    fn of_sums(
        loads: &Loads<'_>,
        linear: &ModalStateSpace,
        (mut displacements, velocities): (Vec<usize>, Vec<usize>),
        sums: &[Vec<(usize, f64)>],
    ) -> Self {
        let single = |index: &usize| vec![(*index, 1.0)];
        let scalars = displacements.iter().map(single).chain(sums.iter().cloned());
        let scalars = scalars.map(|displacement| Combination { displacement, ..Combination::default() });
        let rates = velocities.iter().map(|index| Combination { velocity: single(index), ..Combination::default() });
        let combinations: Vec<_> = scalars.chain(rates).collect();
        let first = loads.reference.len();
        displacements.extend(first..first + sums.len());
        Self {
            map: StateMap::of(loads, linear, &combinations),
            displacements,
            velocities,
            accelerated: Vec::new(),
            powers: None,
            energies: None,
            accelerations: None,
            combinations: None,
            damping: None,
        }
    }

    /// The map that reads all selected coordinates at every output, also those from which only the energies of the shafts
    /// follow.
    pub(in crate::exponential) fn complete(self) -> Self {
        let Self { accelerated, accelerations, combinations, .. } = self;
        match self.energies {
            Some(energies) => Self { accelerated, accelerations, combinations, ..energies.output },
            None => Self { accelerated, accelerations, combinations, ..self },
        }
    }

    /// Evaluates the waiting instants in one batch and passes the results to `receive`. It waits for a full batch, unless `all`
    /// instants are wanted; see [`Trajectory::deferred`](crate::integrate::Trajectory::deferred).
    pub(in crate::exponential) fn evaluate_deferred(
        &mut self,
        loads: &Loads<'_>,
        all: bool,
        receive: &mut dyn FnMut(Deferred<'_>),
    ) {
        if let Some(energies) = &mut self.energies {
            energies.evaluate(loads, all, &mut |energies| receive(Deferred::ShaftEnergies(energies)));
        }
        if let Some(combinations) = &mut self.combinations {
            combinations.evaluate(loads, all, &mut |values| receive(Deferred::Combinations(values)));
        }
    }

    /// Writes the selected accelerations at the states that their map has gathered, which belong to `instants`, one vector after
    /// the other.
    ///
    /// # Errors
    /// [`Halt`] where a load is not defined.
    pub(in crate::exponential) fn read_accelerations(
        &mut self,
        loads: &Loads<'_>,
        instants: &[f64],
        a: &mut [f64],
    ) -> Result<(), Halt> {
        let Some(map) = &mut self.accelerations else { return Ok(()) };
        map.add_loads(loads, instants)?;
        let mut vectors = a.chunks_exact_mut((a.len() / instants.len().max(1)).max(1));
        map.evaluate(loads, true, &mut |values| {
            if let Some(a) = vectors.next() {
                self.accelerated.iter().zip(values).for_each(|(index, value)| a[*index] = *value);
            }
        });
        Ok(())
    }

    /// Writes the selected displacements and velocities of a state into vectors of all coordinates. The sums of displacements
    /// are written if there is room behind the coordinates.
    pub fn read(&mut self, loads: &Loads<'_>, elapsed: f64, z: &[f64], q: &mut [f64], v: &mut [f64]) {
        self.gather(z);
        self.read_gathered(loads, &[elapsed], q, v);
    }

    /// Adds a state to those that [`Self::read_gathered`] reads together.
    pub(in crate::exponential) fn gather(&mut self, z: &[f64]) {
        self.map.gather(z);
        if let Some(damping) = &mut self.damping {
            damping.gather(z);
        }
    }

    /// Writes the selected coordinates of all gathered states, which belong to `instants`, one vector after the other.
    pub(in crate::exponential) fn read_gathered(
        &mut self,
        loads: &Loads<'_>,
        instants: &[f64],
        q: &mut [f64],
        v: &mut [f64],
    ) {
        for (values, (_, q, v)) in self.map.evaluate(loads, instants).zip(at_each(instants, q, v)) {
            let (displacements, velocities) = values.split_at(self.displacements.len());
            for (index, value) in self.displacements.iter().zip(displacements) {
                if let Some(q) = q.get_mut(*index) {
                    *q = *value;
                }
            }
            for (index, value) in self.velocities.iter().zip(velocities) {
                v[*index] = *value;
            }
        }
        if let Some(damping) = &mut self.damping {
            // Without distributed damping, there are no values.
            let powers = damping.evaluate(loads, instants).map(|values| values.iter().map(|x| x * x).sum());
            for ((_, q, _), power) in at_each(instants, q, v).zip(powers.chain(std::iter::repeat(0.0))) {
                q[q.len() - 1] = power;
            }
        }
    }
}

/// Kinetic energy and elastic energy of the shafts at output instants. They follow from all displacements and velocities, whose
/// map from modal states does not fit into the cache of a processor core. States of several instants are therefore collected,
/// also over several steps, and the map is read once for all of them.
#[derive(Clone, Debug)]
pub(in crate::exponential) struct ShaftEnergies {
    /// The map to all coordinates.
    output: OutputMap,
    /// Elapsed times of the collected states, s.
    instants: Vec<f64>,
    /// Scratch: displacements and velocities at all instants, and displacements without the bow.
    q: Vec<f64>,
    v: Vec<f64>,
    unbent: Vec<f64>,
}

impl ShaftEnergies {
    /// Allocates the energies of a model with `len` coordinates, to all of which `output` maps.
    pub fn new(output: OutputMap, len: usize) -> Self {
        Self {
            output,
            instants: Vec::with_capacity(MAX_WAITING),
            q: vec![0.0; MAX_WAITING * len],
            v: vec![0.0; MAX_WAITING * len],
            unbent: vec![0.0; len],
        }
    }

    /// Adds the state z at an instant.
    pub fn collect(&mut self, elapsed: f64, z: &[f64]) {
        self.instants.push(elapsed);
        self.output.gather(z);
    }

    /// Passes kinetic energy and elastic energy of the shafts, J, of all collected states to `receive`, oldest first, if there
    /// are enough of them or `all` are wanted.
    pub fn evaluate(&mut self, loads: &Loads<'_>, all: bool, receive: &mut dyn FnMut([f64; 2])) {
        if self.instants.len() < if all { 1 } else { INSTANT_BATCH } {
            return;
        }
        let room = self.instants.len() * self.unbent.len();
        let (q, v) = (&mut self.q[..room], &mut self.v[..room]);
        self.output.read_gathered(loads, &self.instants, q, v);
        for (elapsed, q, v) in at_each(&self.instants, q, v) {
            receive(loads.motion.shaft_energies(elapsed, q, v, &mut self.unbent));
        }
        self.instants.clear();
    }
}

/// Scalars r z + Re(a e^{iϑ}) whose squares sum to vᵀDv with the distributed damping D.
fn distributed_damping(loads: &Loads<'_>, linear: &ModalStateSpace) -> StateMap {
    let (len, sources) = (linear.len(), loads.source_count());
    let root = loads.motion.distributed_damping().map_or_else(Vec::new, |damping| {
        // Velocities per unit of the state, then per cosine and sine of the phase of each source.
        let mut velocities = DMatrix::zeros(damping.nrows(), len + 2 * sources);
        for index in 0..damping.nrows() {
            let amplitudes = (0..sources).map(|source| loads.amplitude(source, index, true));
            let row = linear.row(&[(index, 1.0)], true).into_iter().chain(amplitudes.flat_map(|a| [a.re, -a.im]));
            velocities.row_mut(index).iter_mut().zip(row).for_each(|(entry, value)| *entry = value);
        }
        semidefinite_root(&(velocities.transpose() * (damping * &velocities)))
    });
    let rows: Vec<Vec<f64>> = root.iter().map(|row| row.as_slice()[..len].to_vec()).collect();
    let amplitude =
        |source: usize, row: &DVector<f64>| Complex64::new(row[len + 2 * source], -row[len + 2 * source + 1]);
    let amplitudes = (0..sources).flat_map(|source| root.iter().map(move |row| amplitude(source, row)));
    let reference = vec![0.0; rows.len()];
    StateMap::new(Rows::new(&rows, &linear.parts), reference, &amplitudes.collect::<Vec<_>>())
}
