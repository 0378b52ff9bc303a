//! Subspace of a large model for a run: the modes of its components that matter for the loads and the recorded coordinates.

use std::sync::Arc;

use super::pilot::PILOT_DURATION;
use super::ports::interface;
use super::ramp::reference_speed;
use super::{RecordPlan, Run};
use crate::analysis::AnalysisError;
use crate::modal::{DirectionSelection, Projected, SubspaceKey};
use crate::model::Model;
use crate::motion::EquationOfMotion;

/// Share of the omitted directions in the motion for a frequency limit of one; it decreases with the error.
const COMPONENT_SHARE: f64 = 0.01;
/// Harmonics of the tooth meshing frequency that count as excited.
const HARMONICS: f64 = 10.0;

/// The linear motion in the component modes up to `limit`, in multiples of the frequency that the teeth excite, and in
/// it in the directions that matter for the loads and the recorded coordinates.
pub(super) fn of_components(
    run: &Run<'_>,
    motion: &EquationOfMotion<'_>,
    plan: &RecordPlan,
    limit: f64,
) -> Result<Arc<Projected>, AnalysisError> {
    let (fastest, speed) = (run.options.fastest(), reference_speed(run.options));
    // At a changing speed, the subspace contains the bearings at the largest speed, and carries their differences.
    let at_fastest = run.cached.at_speed(fastest)?;
    let ports = interface(&run.cached.model, fastest, &plan.selection(&run.cached.model));
    let model = &at_fastest.model;
    let mut loaded = model.coupled_coordinates(fastest);
    loaded.extend(ports.iter().flatten().map(|(index, _)| *index));
    loaded.sort_unstable();
    loaded.dedup();
    // An oil film is such a strong damper that it constrains the motion, which directions of undamped motion do not show.
    let selection = (!has_film(model)).then(|| DirectionSelection {
        scalars: ports,
        horizon: PILOT_DURATION,
        share: COMPONENT_SHARE / (limit * limit),
    });
    let highest = limit * excited_frequency(motion, fastest);
    Ok(at_fastest.subspace(SubspaceKey { speed, highest, loaded, selection })?)
}

/// Whether a bearing of the model has an oil film.
pub(super) fn has_film(model: &Model) -> bool {
    model.nonlinear_bearings.iter().any(|bearing| bearing.film().is_some())
}

/// Highest angular frequency that teeth excite, rad/s: of the gears on their mesh stiffness, or of the harmonics of
/// the tooth meshing frequency.
fn excited_frequency(motion: &EquationOfMotion<'_>, speed: f64) -> f64 {
    motion.highest_mesh_frequency().max(HARMONICS * motion.model().max_mesh_order() * speed.abs())
}
