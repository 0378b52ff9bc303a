//! Elements of a scene that differs from another one in loads only: those of the other scene, if they meet the level.

use super::excited_modes::LARGEST_TO_CHOOSE;
use super::layout::Layout;
use super::{
    Choice, Elements, Resolved, Search, at_lowest_speed, contact_phases, displacement_weight, excitations,
    with_elements,
};
use crate::modal::CachedModel;
use crate::model::Model;
use crate::scene::{Scene, SceneDescription, SceneError};

/// The model whose modes gave the elements of a scene, and these elements.
#[derive(Debug)]
pub(super) struct Probe {
    /// Its description.
    pub description: SceneDescription,
    /// The assembled model.
    pub model: Model,
    /// The same at the speed of its modes, for each stiffness of its meshes.
    pub phases: Vec<CachedModel>,
    /// Indices of the shafts whose elements are chosen.
    pub automatic: Vec<usize>,
    /// Segments of these shafts.
    pub layouts: Vec<Layout>,
    /// Chosen elements of each of these shafts.
    pub chosen: Vec<Elements>,
}

impl Probe {
    /// Gives its modes to the models of a description for each stiffness of the meshes, if the two differ in loads only.
    pub fn share(&self, description: &SceneDescription, phases: &[CachedModel]) {
        let is_same = |(phase, known): (&CachedModel, &CachedModel)| phase.model.has_coordinates_of(&known.model);
        let known = phases.iter().zip(&self.phases);
        if known.clone().all(is_same) && description.without_loads() == self.description.without_loads() {
            known.for_each(|(phase, known)| phase.share(known));
        }
    }
}

/// The elements of `base` for a description that differs from that of `base` in loads only. `None` if they do not meet the
/// level with these loads, or no modes were examined for `base`.
///
/// # Errors
/// [`SceneError`] if the scene is invalid.
pub fn resolve_variation(given: &SceneDescription, base: &Resolved) -> Result<Option<Resolved>, SceneError> {
    let (Some(probe), Some(choice)) = (&base.probe, &base.choice) else {
        return Ok(None);
    };
    let Probe { automatic, layouts, chosen, .. } = &**probe;
    let of_probe = with_elements_of(given, &probe.description);
    let Some(model) = probe.model.with_loads(Scene::new(&of_probe)?)? else {
        return Ok(None);
    };
    let phases = contact_phases(at_lowest_speed(model)?);
    probe.share(&of_probe, &phases);
    let Ok(excitations) = excitations(&phases, LARGEST_TO_CHOOSE) else {
        return Ok(None);
    };
    let (model, weight) = (&phases[0].model, displacement_weight(choice.level, &phases[0].model));
    let error = Search::new(given, automatic, layouts, &excitations, weight, model).of(chosen).error;
    if error > choice.permitted_error || error.is_nan() {
        return Ok(None);
    }
    let description = with_elements(given, automatic, |i| chosen[i].clone());
    let choice = Choice { expected_error: error.min(1.0), ..choice.clone() };
    Ok(Some(Resolved { description, choice: Some(choice), probe: base.probe.clone() }))
}

/// The description with the elements of all shafts of another one.
fn with_elements_of(given: &SceneDescription, other: &SceneDescription) -> SceneDescription {
    let mut description = given.clone();
    for (shaft, other) in description.shafts.iter_mut().zip(&other.shafts) {
        (shaft.elements, shaft.degree) = (other.elements, other.degree);
        shaft.segments.clone_from(&other.segments);
    }
    description
}
