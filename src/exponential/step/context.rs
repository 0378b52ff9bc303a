//! Data that all steps share: the loads, the tabulated propagators, and the interface maps in the layout of the kernels.

use std::sync::Arc;

use num_complex::Complex64;
use pulp::Arch;

use crate::exponential::loads::Loads;
use crate::exponential::propagator::{Aligned, PropagatorCache, Rows, aligned, kernel, panel_kernel};

/// A step that is taken: its level, and the elapsed times of its beginning and its end, s. The end may differ from the sum of
/// beginning and length by round-off.
#[derive(Clone, Copy, Debug)]
pub struct StepSpan {
    pub level: usize,
    pub begin: f64,
    pub end: f64,
}

/// An instant within a step.
#[derive(Clone, Copy, Debug)]
pub struct StepInstant {
    /// Fraction of the step.
    pub part: f64,
    /// Elapsed time, s.
    pub elapsed: f64,
}

/// What a step reads and never changes.
#[derive(Clone, Debug)]
pub(in crate::exponential) struct StepContext<'m> {
    /// Loads on the linear motion.
    pub loads: Loads<'m>,
    /// Propagators of all step levels.
    pub cache: Arc<PropagatorCache>,
    /// Instruction set of the processor.
    pub arch: Arch,
    /// Rows w of the interface.
    rows: Rows,
    /// Columns b of the loads, one after the other.
    pub columns: Aligned,
}

impl<'m> StepContext<'m> {
    /// Packs the interface maps of a cache.
    pub fn new(loads: Loads<'m>, cache: Arc<PropagatorCache>) -> Self {
        let maps = &cache.maps;
        let (rows, columns) = (Rows::new(&maps.rows, &maps.parts), aligned(&maps.columns.concat()));
        Self { loads, cache, arch: Arch::new(), rows, columns }
    }

    /// Number of stages of a step.
    pub fn stages(&self) -> usize {
        self.cache.rule.stages()
    }

    /// Length of a step, s.
    pub fn step(&self, level: usize) -> f64 {
        self.cache.time_grid.step(level)
    }

    /// Writes the scalars and rates w z of a state, without the synchronous motion.
    pub fn observe(&self, z: &[f64], out: &mut [f64]) {
        kernel::row_products(self.arch, &self.rows, z, out);
    }

    /// Writes the interface state of a state at a time for which no phasors are stored.
    pub fn observe_at(&self, elapsed: f64, z: &[f64], out: &mut [f64]) {
        self.observe(z, out);
        self.loads.add_synchronous_at(elapsed, out);
    }

    /// Twice the mesh energy that |z|² does not contain, J, from the scalars without the synchronous motion.
    pub fn mesh_energy(&self, interface_state: &[f64]) -> f64 {
        self.cache.maps.tangents.iter().map(|tangent| tangent.mesh_energy_norm(interface_state).powi(2)).sum()
    }

    /// Energy norm of the rate b p of the state under `loads` that depend on the motion.
    pub fn load_norm(&self, loads: &[f64]) -> f64 {
        panel_kernel::quadratic_form(self.arch, &self.cache.gram, loads).max(0.0).sqrt()
    }
}

/// Phasors e^{iϑ} of all rotating sources at one instant.
#[derive(Clone, Debug)]
pub(in crate::exponential) struct SourcePhasors {
    /// One value for each source.
    pub values: Vec<Complex64>,
    /// Elapsed time of the values, s; NaN before the first update.
    elapsed: f64,
}

impl SourcePhasors {
    /// Creates phasors without a time.
    pub fn new(loads: &Loads<'_>) -> Self {
        Self { values: vec![Complex64::ZERO; loads.source_count()], elapsed: f64::NAN }
    }

    /// Moves the phasors to a time. The end of a step is the beginning of the next, so that this is often free.
    pub fn update(&mut self, loads: &Loads<'_>, elapsed: f64) {
        if self.elapsed != elapsed {
            loads.phasors(elapsed, &mut self.values);
            self.elapsed = elapsed;
        }
    }
}
