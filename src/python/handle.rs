//! The class `_core.Model` and how an analysis runs on it. `model.rs` holds its Python methods.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};

use pyo3::prelude::*;

use super::background;
use super::errors::warn;
use crate::analysis::simulate::System;
use crate::analysis::{self, AnalysisError, Dense, ElementErrors, Interrupt, Resolved};
use crate::modal::CachedModel;
use crate::model::Model;
use crate::scene::{Node, Scene, SceneDescription};

/// A checked and assembled system.
#[pyclass(name = "Model", module = "gearbow._core", frozen)]
pub struct PyModel {
    /// The description that the user gave.
    pub description: SceneDescription,
    /// The description with the chosen numbers and degrees of elements.
    pub resolved: Resolved,
    /// The assembled model with its cached modes, shared with the threads that analyse it.
    pub cached: Arc<System>,
    /// Errors to expect of the elements, computed on first use.
    pub element_errors: OnceLock<ElementErrors>,
    /// Whether the warning about ill-conditioning has been issued.
    warned: AtomicBool,
}

impl PyModel {
    /// Checks and assembles a description.
    pub fn build(description: SceneDescription, interrupt: &Interrupt) -> Result<Self, AnalysisError> {
        let resolved = analysis::resolve(&description, None, interrupt)?;
        let model = assemble(&resolved.description)?;
        Ok(Self::of_model(description, resolved, System::new(model)))
    }

    /// Checks and assembles a system that differs from another one. If the two differ in loads only, it shares the modes of the
    /// other one. A variation has also its elements, where they meet the level, and the reduction of its runs.
    pub fn build_changed(
        description: SceneDescription,
        base: &Self,
        is_variation: bool,
        interrupt: &Interrupt,
    ) -> Result<Self, AnalysisError> {
        let takes_elements = is_variation
            && description.accuracy.unwrap_or_default() == base.description.accuracy.unwrap_or_default()
            && description.without_loads() == base.description.without_loads();
        let taken = if takes_elements { analysis::resolve_variation(&description, &base.resolved)? } else { None };
        let resolved = match taken {
            Some(resolved) => resolved,
            None => analysis::resolve(&description, Some(&base.resolved), interrupt)?,
        };
        if is_variation
            && base.model().nonlinear_bearings.is_empty()
            && !description.geometric_stiffness
            && resolved.description.without_loads() == base.resolved.description.without_loads()
            && let Some(model) = base.model().with_loads(Scene::new(&resolved.description)?)?
        {
            let shares = model.has_coordinates_of(base.model());
            let cached = if shares { System::variation(model, &base.cached) } else { System::new(model) };
            return Ok(Self::of_model(description, resolved, cached));
        }
        let model = assemble(&resolved.description)?;
        let made = Self::of_model(description, resolved, System::new(model));
        if !is_variation {
            made.share_linear_part(base);
        }
        Ok(made)
    }

    fn of_model(description: SceneDescription, resolved: Resolved, cached: System) -> Self {
        Self {
            description,
            resolved,
            cached: Arc::new(cached),
            warned: AtomicBool::new(false),
            element_errors: OnceLock::new(),
        }
    }

    /// The assembled model.
    pub fn model(&self) -> &Model {
        &self.cached.model
    }

    /// Uses the modes and state-space models of another system, if the two differ in loads only. The stiffness of nonlinear
    /// bearings depends on the loads, so that systems with them share nothing. Returns whether the two share.
    pub fn share_linear_part(&self, other: &Self) -> bool {
        let shares = self.model().nonlinear_bearings.is_empty()
            && !self.description.geometric_stiffness
            && self.model().has_coordinates_of(other.model())
            && self.resolved.description.without_loads() == other.resolved.description.without_loads();
        if shares {
            self.cached.share(&other.cached);
        }
        shares
    }

    /// Runs an analysis that Ctrl-C can stop. Refuses it if its dense matrices do not fit into memory.
    pub fn run<T, E>(
        &self,
        py: Python<'_>,
        dense: Dense,
        work: impl FnOnce(&CachedModel, &Interrupt) -> Result<T, E> + Send + 'static,
    ) -> PyResult<T>
    where
        T: Send + 'static,
        E: Send + 'static,
        PyErr: From<E>,
    {
        dense.require(self.model())?;
        let cached = Arc::clone(&self.cached);
        background::result_of(py, move |interrupt| work(&cached, interrupt))
    }

    /// Warns once of digits lost to round-off, before an analysis that needs the matrices of `dense`.
    pub fn warn_of_ill_conditioning(&self, py: Python<'_>, speed: f64, dense: Dense) -> PyResult<()> {
        let found = self.run(py, dense, move |cached, _| analysis::ill_conditioning(cached, speed))?;
        match found {
            Some(text) if !self.warned.swap(true, Ordering::Relaxed) => warn(py, text),
            _ => Ok(()),
        }
    }

    /// Speed, rad/s, at which ill-conditioning is assessed: zero, or one at which bearings have coefficients and the tables of
    /// torques have values.
    pub fn representative_speed(&self, fastest: f64) -> f64 {
        let model = self.model();
        if model.needs_speed() || !model.loads.is_empty() { fastest } else { 0.0 }
    }

    /// Name of the shaft or housing and position x, m, of a node.
    pub fn place(&self, node: Node) -> (&str, f64) {
        self.model().scene.place(node)
    }
}

/// The model of a description with elements.
fn assemble(description: &SceneDescription) -> Result<Model, AnalysisError> {
    let scene = Scene::new(description)?;
    if description.geometric_stiffness { analysis::with_axial_forces(scene) } else { Ok(Model::new(scene)?) }
}
