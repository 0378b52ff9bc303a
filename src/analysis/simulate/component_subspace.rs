//! Subspace of a large model for a run: the modes of its components that matter for the loads and the recorded coordinates.

use std::sync::Arc;

use num_complex::Complex64;

use super::pilot::PILOT_DURATION;
use super::ports::interface;
use super::ramp::reference_speed;
use super::{RecordPlan, Run};
use crate::analysis::AnalysisError;
use crate::modal::{DirectionSelection, Projected, SubspaceKey};
use crate::model::{Excitation, Model};
use crate::motion::{EquationOfMotion, Speed};

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
        scalars: if matches!(run.options.speed, Speed::Changing(_)) {
            [ports, rotating_loads(model)].concat()
        } else {
            ports
        },
        horizon: PILOT_DURATION,
        share: COMPONENT_SHARE / (limit * limit),
    });
    let highest = limit * excited_frequency(motion, fastest);
    Ok(at_fastest.subspace(SubspaceKey { speed, highest, loaded, selection })?)
}

/// Loads of bows and of unbalances at two angles of each shaft, as entries (index, coefficient) over the displacements. At a
/// changing speed they act on the linear motion, which must carry them. Only their shape matters: they have the length 1, so
/// that variations of their size share a subspace.
fn rotating_loads(model: &Model) -> Vec<Vec<(usize, f64)>> {
    let parts = [Excitation::steady_amplitude, |excitation: &Excitation| excitation.unbalance];
    let mut loads = Vec::new();
    for (shaft, part) in model.shafts.iter().flat_map(|shaft| parts.map(|part| (shaft, part))) {
        let size = shaft.excitations.iter().map(|excitation| part(excitation).norm_sqr()).sum::<f64>().sqrt();
        for angle in [Complex64::ONE, Complex64::I] {
            let entries = shaft.excitations.iter().flat_map(|excitation| {
                let load = part(excitation) * angle / size;
                [(excitation.index, load.re), (excitation.index + 1, load.im)]
            });
            if size > 0.0 {
                loads.push(entries.collect());
            }
        }
    }
    loads
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
