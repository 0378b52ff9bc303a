//! Warnings about accuracy: ill-conditioning, nearly parallel modes and large displacements.
//!
//! In coordinates with unit modal mass, the stiffness has entries up to ω_max². Their round-off, ε·ω_max², causes a
//! relative error of up to ε(ω_max/ω₀)² in the slowest mode, ω₀.

use nalgebra::DVector;

use super::AnalysisError;
use super::simulate::{Event, EventKind};
use crate::modal::{CachedModel, MAX_CONDITION};
use crate::model::{Model, Support};
use crate::scene::{Bearing, Shaft, short};

/// Relative error of the slowest mode above which a warning is given.
const ROUND_OFF_LIMIT: f64 = 1e-6;

/// Returns a warning if round-off may affect the slow modes, with the stiff element, bearing or mesh that causes it.
///
/// # Errors
/// [`AnalysisError`] if the undamped modes cannot be found, or a bearing has no coefficients at the speed.
pub fn ill_conditioning(cached: &CachedModel, speed: f64) -> Result<Option<String>, AnalysisError> {
    let cached = cached.at(speed, cached.model.lowest_frequency())?;
    let (model, range) = (&cached.model, cached.spectral_range(speed)?);
    let (Some(slowest), fastest) = (range.slowest, range.fastest) else {
        return Ok(None);
    };
    let lost = f64::EPSILON * (fastest / slowest).powi(2);
    if lost <= ROUND_OFF_LIMIT {
        return Ok(None);
    }
    let shape = range.fastest_shape.as_slice();
    // The cause has the largest strain energy in the fastest mode.
    let bearing = |support: &Support| {
        let [v, w] = [shape[support.index], shape[support.index + 1]];
        let k = &support.symmetric_part;
        k[0][0] * v * v + 2.0 * k[0][1] * v * w + k[1][1] * w * w
    };
    let bearings = model.supports.iter().map(|support| (bearing(support), bearing_stiffness(model, support)));
    let links = model.links.iter().map(|link| {
        (link.local.elastic_form(&link.scalars(shape)), format!("{}, of {:.3e} N/m", link.name, largest(&link.local)))
    });
    let connections = model.connections(speed).map(|connection| {
        let stiffness = connection.linear(speed).stiffness;
        let strain = DVector::from_vec(connection.rows().iter().map(|row| scalar(row, shape)).collect());
        (strain.dot(&(stiffness * &strain)), connection.described().unwrap_or_default())
    });
    let shafts = std::iter::once((model.shaft_form(shape), shortest_element(model)));
    let (_, cause) = shafts
        .chain(bearings)
        .chain(links)
        .chain(connections)
        .fold((f64::NEG_INFINITY, String::new()), |most, one| if one.0 > most.0 { one } else { most });
    Ok(Some(format!(
        "natural frequencies range from {slowest:.3e} to {fastest:.3e} rad/s, so that the relative error of the slowest mode by round-off may reach {lost:.0e}; the fastest mode is that of {cause}"
    )))
}

fn scalar(row: &[(usize, f64)], shape: &[f64]) -> f64 {
    row.iter().map(|(index, coefficient)| coefficient * shape[*index]).sum()
}

fn shortest_element(model: &Model) -> String {
    let (shaft, x, length) = model.scene.shortest_element();
    format!("the shortest element, {length:.3e} m, on shaft \"{shaft}\" at {x} m")
}

fn bearing_stiffness(model: &Model, support: &Support) -> String {
    let stands = |bearing: &Bearing| model.numbering.translation(bearing.node) == Some(support.index);
    let bearing = model.scene.bearings.iter().position(stands).unwrap_or(0);
    format!("bearings[{bearing}], of {:.3e} N/m", largest(support))
}

/// Largest entry of a stiffness matrix, N/m.
fn largest(support: &Support) -> f64 {
    support.stiffness.as_flattened().iter().fold(0.0_f64, |most, k| most.max(k.abs()))
}

/// Returns a warning if the largest displacement, m, exceeds the length of the longest shaft: the equations assume small
/// displacements. A system without bearings may move freely and gives no warning.
pub fn small_displacement_check(model: &Model, largest: f64) -> Option<String> {
    let length = model.scene.shafts.iter().map(Shaft::length).fold(0.0, f64::max);
    (largest > length && model.local_elements().next().is_some()).then(|| {
        format!("a displacement is {largest:.1e} m, more than the length of the longest shaft, {length} m: the equations assume small displacements")
    })
}

/// Returns a warning for each mesh whose contact ratio falls below one in a run with these `events`, at the first time.
pub fn contact_ratio_check<'a>(model: &'a Model, events: &'a [Event]) -> impl Iterator<Item = String> + 'a {
    (0..model.meshes.len()).filter_map(move |mesh| {
        let lost = |event: &&Event| event.mesh == mesh && event.kind == EventKind::RatioBelowOne;
        let Event { time, .. } = events.iter().find(lost)?;
        let [driver, driven] = model.gear_names(mesh);
        Some(format!("contact ratio: that of \"{driver}\" and \"{driven}\" falls below 1 at {} s: at times no teeth are in contact, and only a stiffness of tooth pairs is then zero; reduce the bow or the displacement of the gears", short(*time)))
    })
}

/// Returns a warning if the condition number of the modes of a run is so large that a Runge–Kutta method replaced the
/// exponential method.
pub fn parallel_modes_check(condition: Option<f64>) -> Option<String> {
    condition.filter(|condition| *condition > MAX_CONDITION).map(|condition| {
        format!("method: the modes are nearly parallel (condition number {condition:.1e}), as at critical damping, so that \"rk45\" integrates the motion in place of \"exponential\"; change the damping slightly for longer steps")
    })
}
