//! What an answer may be worth less for than it looks: digits that round-off takes, motions that are not small.
//!
//! In coordinates in which every mode has the unit mass, the stiffness has entries up to ω_max². Round-off of ε·ω_max²
//! beside the ω₀² of the slowest mode takes that mode down to ε(ω_max/ω₀)² of itself, at worst.

use nalgebra::DVector;

use super::AnalysisError;
use crate::modal::CachedModel;
use crate::model::{Model, Support};
use crate::scene::Shaft;

/// The part of the slowest motion that round-off may take unsaid.
const LOST: f64 = 1e-6;

/// Says which element, bearing or mesh is so stiff that round-off takes digits of the slow motions, if one is.
///
/// # Errors
/// [`AnalysisError`] if the undamped modes cannot be found, or a bearing has no coefficients at the speed.
pub fn ill_conditioning(cached: &CachedModel, speed: f64) -> Result<Option<String>, AnalysisError> {
    let cached = cached.at_speed(speed)?;
    let (model, modes) = (&cached.model, cached.real_modes(speed)?);
    let (Some(slowest), fastest) = (modes.frequencies.iter().find(|frequency| **frequency > 0.0), modes.highest())
    else {
        return Ok(None);
    };
    let lost = f64::EPSILON * (fastest / slowest).powi(2);
    if lost <= LOST {
        return Ok(None);
    }
    let shape = modes.vectors.column(modes.frequencies.imax());
    let shape = shape.as_slice();
    // Whose strain energy is the largest in the fastest mode.
    let bearing = |support: &Support| {
        let [v, w] = [shape[support.index], shape[support.index + 1]];
        let k = &support.symmetric_part;
        k[0][0] * v * v + 2.0 * k[0][1] * v * w + k[1][1] * w * w
    };
    let bearings = model.supports.iter().map(bearing);
    let connections = model.connections(speed).map(|connection| {
        let stiffness = connection.linear(speed).stiffness;
        let strain = DVector::from_vec(connection.rows().iter().map(|row| scalar(row, shape)).collect());
        (strain.dot(&(stiffness * &strain)), connection.described().unwrap_or_default())
    });
    let shafts = std::iter::once((model.shaft_form(shape), shortest(model)));
    let (_, cause) = shafts
        .chain(bearings.enumerate().map(|(index, energy)| (energy, stiff(model, index))))
        .chain(connections)
        .fold((f64::NEG_INFINITY, String::new()), |most, one| if one.0 > most.0 { one } else { most });
    Ok(Some(format!(
        "frequencies reach from {slowest:.3e} to {fastest:.3e} rad/s, so that round-off may take up to {lost:.0e} of the slowest motion; the fastest is that of {cause}"
    )))
}

fn scalar(row: &[(usize, f64)], shape: &[f64]) -> f64 {
    row.iter().map(|(index, coefficient)| coefficient * shape[*index]).sum()
}

fn shortest(model: &Model) -> String {
    let (shaft, x, length) = model.scene.shortest_element();
    format!("the shortest element, {length:.3e} m, on shaft \"{shaft}\" at {x} m")
}

fn stiff(model: &Model, bearing: usize) -> String {
    let k = model.supports[bearing].stiffness;
    format!("bearings[{bearing}], of {:.3e} N/m", k.as_flattened().iter().fold(0.0_f64, |most, k| most.max(k.abs())))
}

/// Says that a displacement is larger than the longest shaft, if it is: displacements are taken to be small. What nothing
/// holds may fly as far as it likes.
pub fn small_displacement_check(model: &Model, largest: f64) -> Option<String> {
    let length = model.scene.shafts.iter().map(Shaft::length).fold(0.0, f64::max);
    (largest > length && !model.supports.is_empty()).then(|| {
        format!("a displacement of {largest:.1e} m, where the longest shaft has {length} m: the equations hold for small ones")
    })
}
