//! Section forces of shafts: places, forces of a state and of harmonic motions, and stresses per unit of force.

use nalgebra::Complex;
use num_complex::Complex64;
use numpy::{PyArray2, PyArray3, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;

use super::convert::{stack, table};
use super::handle::PyModel;
use crate::model::{Cut, Model, Moving, Numbering, Oscillating, SECTION_FORCES, StructuralDamping, Turning};
use crate::scene::{EntryPath, SceneError};

/// Shaft, position, m, and side of a cut: "before" or "beyond" the node there; between nodes, "before".
pub type SectionEntry = (String, f64, &'static str);

/// Describes a cut.
pub fn section_entry(model: &Model, cut: &Cut) -> SectionEntry {
    let side = if cut.is_beyond { "beyond" } else { "before" };
    (model.scene.shafts[cut.shaft].name.clone(), cut.position, side)
}

/// The cuts at positions of a shaft, m; at all its nodes without positions.
fn cuts(model: &Model, shaft: &str, positions: Option<Vec<f64>>) -> Result<Vec<Cut>, SceneError> {
    let at = EntryPath::root("at");
    let index = model.scene.known_shaft(shaft, &at)?;
    let positions = positions.unwrap_or_else(|| model.scene.shafts[index].nodes.clone());
    let found = positions.iter().map(|position| model.cuts(index, *position, &at));
    Ok(found.collect::<Result<Vec<_>, _>>()?.concat())
}

/// Converts a vector from the order of Python to that of the core.
fn in_core_order(numbering: &Numbering, outside: &[Complex64]) -> Vec<Complex64> {
    let part = |of: fn(&Complex64) -> f64| numbering.in_core_order(&outside.iter().map(of).collect::<Vec<_>>());
    part(|value| value.re).into_iter().zip(part(|value| value.im)).map(|(re, im)| Complex64::new(re, im)).collect()
}

/// Harmonic motions: a row for each.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Motions<'py> {
    /// Phasors (m, n) of the degrees of freedom.
    phasors: PyReadonlyArray2<'py, Complex<f64>>,
    /// Frequencies and speeds of the reference shaft, rad/s.
    frequencies: Vec<f64>,
    speeds: Vec<f64>,
    /// Whether each motion contains the bow of the shaft.
    bowed: Vec<bool>,
}

#[pymethods]
impl PyModel {
    /// The cuts at positions of a shaft, and for each the outer radius, m, and the stress at it per unit of N, 1/m², of bending moment
    /// and of torque, 1/m³.
    #[pyo3(signature = (shaft, positions=None))]
    fn sections(&self, shaft: &str, positions: Option<Vec<f64>>) -> PyResult<Vec<(SectionEntry, [f64; 4])>> {
        let model = self.model();
        let found = cuts(model, shaft, positions)?;
        let entry = |cut: &Cut| {
            let stress = &cut.stress;
            (section_entry(model, cut), [stress.radius, stress.axial, stress.bending, stress.torsion])
        };
        Ok(found.iter().map(entry).collect())
    }

    /// Section forces (k, 6) at the cuts of a shaft in a state at rest of the system, with `speed` of the reference shaft, rad/s.
    fn static_section_forces<'py>(
        &self,
        py: Python<'py>,
        shaft: &str,
        positions: Option<Vec<f64>>,
        state: PyReadonlyArray1<'py, f64>,
        speed: f64,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let model = self.model();
        let found = cuts(model, shaft, positions)?;
        model.scene.refuse_section_forces(shaft)?;
        let displacement = model.numbering.in_core_order(state.as_slice()?);
        let rest = vec![0.0; displacement.len()];
        let motion = Moving { displacement: &displacement, velocity: &rest, acceleration: &rest };
        let forces = found.iter().flat_map(|cut| {
            let turning = Turning { spin: model.shafts[cut.shaft].ratio * speed, ..Turning::default() };
            cut.forces(&motion, turning)
        });
        table(py, forces.collect(), found.len(), SECTION_FORCES)
    }

    /// Phasors (m, k, 6) of the section forces at the cuts of a shaft in harmonic motions.
    fn harmonic_section_forces<'py>(
        &self,
        py: Python<'py>,
        shaft: &str,
        positions: Option<Vec<f64>>,
        motions: Motions<'py>,
    ) -> PyResult<Bound<'py, PyArray3<Complex<f64>>>> {
        let model = self.model();
        let found = cuts(model, shaft, positions)?;
        model.scene.refuse_section_forces(shaft)?;
        let mut forces = Vec::with_capacity(motions.frequencies.len() * found.len() * SECTION_FORCES);
        let phasors = motions.phasors.as_array();
        let rows = phasors.rows().into_iter().zip(&motions.frequencies).zip(&motions.speeds).zip(&motions.bowed);
        for (((row, frequency), speed), is_bowed) in rows {
            let phasors = in_core_order(&model.numbering, &row.to_vec());
            let at = StructuralDamping { frequency: *frequency, speed: *speed };
            let motion = Oscillating { phasors: &phasors, at, is_bowed: *is_bowed };
            forces.extend(found.iter().flat_map(|cut| cut.oscillating(&motion)));
        }
        stack(py, forces, motions.frequencies.len(), found.len(), SECTION_FORCES)
    }
}
