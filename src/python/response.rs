//! The response of a run as a Python dictionary of NumPy arrays and plain entries.

use numpy::{IntoPyArray, PyArray1};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use pythonize::pythonize;
use serde::Serialize;

use super::convert::{mesh_fields, mesh_names, stack, table};
use super::handle::PyModel;
use super::sections::section_entry;
use super::state::{write_checkpoint, write_final};
use crate::analysis::simulate::{Event, Point, RecordPlan, Response};
use crate::connection::ROLLING_CHANNELS;
use crate::model::SECTION_FORCES;
use crate::motion::{Energies, SourceTerms};

/// What a run cost and what limited its steps.
#[derive(Serialize)]
struct StatisticsEntries {
    /// Number of steps.
    steps: u64,
    /// Number of rejected steps.
    rejected: u64,
    /// Number of evaluations of the right-hand side.
    evaluations: u64,
    /// Number of contact changes at which a step ends.
    events: u64,
    /// Length of the shortest step, s; zero if there is none.
    step_min: f64,
    /// Length of the longest step, s.
    step_max: f64,
    /// Highest undamped natural frequency, rad/s.
    omega_max: f64,
    /// Condition number of the modes; NaN if the method does not use modes.
    condition: f64,
    /// Number of modes that a reduced model keeps.
    modes: Option<usize>,
    /// Estimated error of displacements and of mesh forces from the reduction to these modes.
    modes_error: Option<[f64; 2]>,
    /// What limited most steps: "step", "stability" or "tolerance".
    limited_by: &'static str,
}

impl From<&Response> for StatisticsEntries {
    fn from(response: &Response) -> Self {
        let count = &response.statistics;
        Self {
            steps: count.steps,
            rejected: count.rejected,
            evaluations: count.evaluations,
            events: count.events,
            step_min: if count.steps > 0 { count.shortest } else { 0.0 },
            step_max: count.longest,
            omega_max: response.spectrum.omega_max,
            condition: response.condition.unwrap_or(f64::NAN),
            modes: response.reduction.map(|reduction| reduction.modes),
            modes_error: response.reduction.map(|reduction| reduction.errors),
            limited_by: response.limited_by.name(),
        }
    }
}

/// Writes a response; `RunData` in `gearbow._types` lists its entries.
pub fn response_dict<'py>(
    owner: &PyModel,
    py: Python<'py>,
    plan: &RecordPlan,
    response: Response,
) -> PyResult<Bound<'py, PyDict>> {
    let model = owner.model();
    let dict = PyDict::new(py);
    dict.set_item("statistics", pythonize(py, &StatisticsEntries::from(&response))?)?;
    dict.set_item("final", write_final(py, &response.last)?)?;
    dict.set_item("checkpoint", write_checkpoint(py, &response.statistics, &response.recorder_state)?)?;

    let record = response.record;
    let (times, points, bearings) = (record.time.len(), plan.points.len(), plan.bearings.len());
    dict.set_item("time", record.time.into_pyarray(py))?;
    let place = |point: &Point| (point.part.clone(), point.position, point.names.clone());
    dict.set_item("points", plan.points.iter().map(place).collect::<Vec<_>>())?;
    dict.set_item("displacement", stack(py, record.displacement, times, points, 2)?)?;
    dict.set_item("twist", table(py, record.twist, times, points)?)?;
    if plan.velocity {
        dict.set_item("velocity", stack(py, record.velocity, times, points, 2)?)?;
        dict.set_item("twist_rate", table(py, record.twist_rate, times, points)?)?;
    }
    if plan.acceleration {
        dict.set_item("acceleration", stack(py, record.acceleration, times, points, 2)?)?;
    }
    if model.scene.axial {
        dict.set_item("axial", table(py, record.axial.displacement, times, points)?)?;
        if plan.velocity {
            dict.set_item("axial_velocity", table(py, record.axial.velocity, times, points)?)?;
        }
        if plan.acceleration {
            dict.set_item("axial_acceleration", table(py, record.axial.acceleration, times, points)?)?;
        }
        dict.set_item("axial_bearing_force", table(py, record.axial.bearing_force, times, bearings)?)?;
    }
    dict.set_item("bearings", plan.bearings.iter().map(|node| owner.place(*node)).collect::<Vec<_>>())?;
    dict.set_item("bearing_force", stack(py, record.bearing_force, times, bearings, 2)?)?;
    dict.set_item("bearing_displacement", stack(py, record.bearing_displacement, times, bearings, 2)?)?;
    let rolling = plan.bearings.iter().filter(|node| model.rolls_at(**node)).map(|node| owner.place(*node));
    let rolling: Vec<_> = rolling.collect();
    dict.set_item("rolling_contact", stack(py, record.rolling, times, rolling.len(), ROLLING_CHANNELS.len())?)?;
    dict.set_item("rolling_bearings", rolling)?;
    let sections: Vec<_> = plan.cuts.iter().map(|cut| section_entry(model, cut)).collect();
    let count = sections.len();
    dict.set_item("sections", sections)?;
    if count > 0 {
        dict.set_item("section_force", stack(py, record.section_force, times, count, SECTION_FORCES / 2)?)?;
        dict.set_item("section_moment", stack(py, record.section_moment, times, count, SECTION_FORCES / 2)?)?;
    }
    dict.set_item("meshes", mesh_names(model, plan.meshes.iter().copied()))?;
    dict.set_item("mesh", mesh_fields(py, record.mesh, times, plan.meshes.len(), false)?)?;
    dict.set_item("energy", plan.energy.then(|| energy(&record.energy, |(energies, _)| energies.total(), py)))?;
    dict.set_item("energy_terms", plan.energy.then(|| energy_terms(&record.energy, py)).transpose()?)?;
    let event = |event: &Event| {
        let [driver, driven] = model.gear_names(event.mesh);
        (event.time, driver, driven, event.kind.name())
    };
    dict.set_item("events", record.events.iter().map(event).collect::<Vec<_>>())?;
    Ok(dict)
}

/// Energies and the work of each source at one time, J.
type EnergyRow = (Energies, SourceTerms);

fn energy<'py>(record: &[EnergyRow], of: impl Fn(&EnergyRow) -> f64, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
    record.iter().map(of).collect::<Vec<_>>().into_pyarray(py)
}

fn energy_terms<'py>(record: &[EnergyRow], py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("kinetic", energy(record, |(energies, _)| energies.kinetic, py))?;
    dict.set_item("shafts", energy(record, |(energies, _)| energies.shafts, py))?;
    dict.set_item("bearings", energy(record, |(energies, _)| energies.bearings, py))?;
    dict.set_item("meshes", energy(record, |(energies, _)| energies.meshes, py))?;
    for (index, name) in SourceTerms::NAMES.into_iter().enumerate() {
        dict.set_item(name, energy(record, |(_, works)| works.values()[index], py))?;
    }
    Ok(dict)
}
