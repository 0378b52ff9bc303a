//! Checks the stiffness model of a mesh and its parameters.

use super::description::{self, Foundation, StiffnessKind};
use super::{EntryPath, Gear, SceneError};
use crate::numerics::EQUALITY_TOLERANCE;

/// Default stiffness of a parabolic pair at the ends of the path of contact, relative to its largest stiffness.
const DEFAULT_END_RATIO: f64 = 0.6;
/// Range of root radius over bore radius in which the fillet-foundation deflection was fitted. The source gives 1.4 to
/// 7; ratios that round to these two digits are inside.
const FOUNDATION_RANGE: [f64; 2] = [1.35, 7.05];

/// How the scale of a stiffness is given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Scale {
    /// Mean mesh stiffness, N/m.
    Mean(f64),
    /// Largest stiffness of one tooth pair, N/m.
    Pair(f64),
}

/// A checked stiffness model.
#[derive(Clone, Debug, PartialEq)]
pub enum StiffnessModel {
    /// Constant mesh stiffness, N/m.
    Mean(f64),
    /// Constant mesh stiffness by ISO 6336-1 for this face width, m.
    Iso6336(f64),
    /// Tooth pairs of constant stiffness.
    Square(Scale),
    /// Tooth pairs whose stiffness is a parabola along the path of contact; the number is the stiffness at the ends of
    /// the path relative to the largest one.
    Parabolic(Scale, f64),
    /// Tooth pairs by the potential-energy method, for this face width, m, and radii at which the gear bodies are fixed, m.
    PotentialEnergy(f64, [f64; 2], Foundation),
    /// Mesh stiffness at equal intervals of the mesh cycle, N/m.
    Table(Vec<f64>),
    /// Mean mesh stiffness, N/m, and `[amplitude, phase]` of the harmonics of the mesh cycle, N/m and rad.
    Fourier(f64, Vec<[f64; 2]>),
}

impl StiffnessModel {
    /// Whether the model describes single tooth pairs.
    pub(super) fn has_tooth_pairs(&self) -> bool {
        matches!(self, Self::Square(_) | Self::Parabolic(..) | Self::PotentialEnergy(..))
    }
}

/// A described model and where it stands in the description.
struct Given<'a> {
    model: &'a description::StiffnessModel,
    pair: [&'a Gear; 2],
    at: &'a EntryPath<'a>,
}

/// Checks a described model for the gears of `pair` on shafts of these outer radii, m.
pub(super) fn stiffness_model(
    model: &description::StiffnessModel,
    pair: [&Gear; 2],
    shaft_radii: [f64; 2],
    at: &EntryPath,
    warnings: &mut Vec<String>,
) -> Result<StiffnessModel, SceneError> {
    refuse_unused(model, at)?;
    let given = Given { model, pair, at };
    match model.model {
        // The error of a stiffness that is a single number belongs to the entry itself.
        StiffnessKind::Constant => {
            Ok(StiffnessModel::Mean(at.positive(model.mean.ok_or_else(|| at.error("needs mean"))?)?))
        }
        StiffnessKind::Iso6336 => Ok(StiffnessModel::Iso6336(given.face_width()?)),
        StiffnessKind::Square => Ok(StiffnessModel::Square(given.pair_scale()?)),
        StiffnessKind::Parabolic => given.parabolic(),
        StiffnessKind::PotentialEnergy => given.potential_energy(shaft_radii, warnings),
        StiffnessKind::Table => given.table(),
        StiffnessKind::Fourier => given.fourier(),
    }
}

impl Given<'_> {
    fn scale(&self) -> Result<Scale, SceneError> {
        match (self.model.mean, self.model.pair) {
            (Some(mean), None) => Ok(Scale::Mean(self.at.field("mean").positive(mean)?)),
            (None, Some(pair)) => Ok(Scale::Pair(self.at.field("pair").positive(pair)?)),
            _ => Err(self.at.error("needs one of mean and pair")),
        }
    }

    /// The scale of tooth pairs; helical pairs need a face width, which their contact lines cross.
    fn pair_scale(&self) -> Result<Scale, SceneError> {
        if self.is_helical() {
            self.face_width()?;
        }
        self.scale()
    }

    fn is_helical(&self) -> bool {
        self.pair[0].helix_angle != 0.0
    }

    fn face_width(&self) -> Result<f64, SceneError> {
        match self.pair.map(|gear| gear.face_width) {
            [Some(a), Some(b)] => Ok(a.min(b)),
            _ => Err(self.at.error("needs the face_width of both gears, or a number [N/m]")),
        }
    }

    fn list(&self, values: Option<&Vec<f64>>, name: &str) -> Result<Vec<f64>, SceneError> {
        let values = values.cloned().ok_or_else(|| self.at.error(format!("needs {name}")))?;
        for (index, value) in values.iter().enumerate() {
            self.at.field(name).index(index).finite(*value)?;
        }
        Ok(values)
    }

    fn parabolic(&self) -> Result<StiffnessModel, SceneError> {
        let at = self.at.field("end_ratio");
        let ratio = at.positive(self.model.end_ratio.unwrap_or(DEFAULT_END_RATIO))?;
        if ratio > 1.0 {
            return Err(at.error(format!("must be at most 1, got {ratio}")));
        }
        Ok(StiffnessModel::Parabolic(self.pair_scale()?, ratio))
    }

    fn potential_energy(
        &self,
        shaft_radii: [f64; 2],
        warnings: &mut Vec<String>,
    ) -> Result<StiffnessModel, SceneError> {
        if let Some(ring) = self.pair.iter().find(|gear| gear.internal) {
            let message = format!(
                "describes external teeth, and \"{}\" is internal; use iso6336, square, parabolic, table or fourier",
                ring.body.name
            );
            return Err(self.at.field("model").error(message));
        }
        let radii = self.model.bore_radii.unwrap_or(shaft_radii);
        let list = self.at.field("bore_radii");
        for (index, (radius, gear)) in radii.iter().zip(self.pair).enumerate() {
            let root = gear.root_radius();
            if root >= gear.tip_radius {
                let message = format!(
                    "\"{}\" has no tooth between its tip radius of {} m and its root radius of {root} m",
                    gear.body.name, gear.tip_radius
                );
                return Err(self.at.error(message));
            }
            let at = list.index(index);
            if at.positive(*radius)? >= root {
                let message = format!("{radius} m leaves no gear body below the root radius of {root} m");
                return Err(at.error(message));
            }
            let ratio = root / *radius;
            if !(FOUNDATION_RANGE[0] - EQUALITY_TOLERANCE..=FOUNDATION_RANGE[1] + EQUALITY_TOLERANCE).contains(&ratio) {
                warnings.push(format!(
                    "{at}: the root radius of \"{}\" is {ratio:.3} times the radius of {radius} m at which its body \
                     is fixed; the compliance of fillet and gear body was fitted for 1.4 to 7 (Sainsot, Velex and Duverger \
                     2004): give bore_radii in that range, or another stiffness model",
                    gear.body.name
                ));
            }
        }
        let foundation = self.model.foundation.unwrap_or(Foundation::Separate);
        if foundation == Foundation::Shared && self.is_helical() {
            let message = "\"shared\" has no helical teeth; use \"separate\"";
            return Err(self.at.field("foundation").error(message));
        }
        Ok(StiffnessModel::PotentialEnergy(self.face_width()?, radii, foundation))
    }

    fn table(&self) -> Result<StiffnessModel, SceneError> {
        let (values, at) = (self.list(self.model.values.as_ref(), "values")?, self.at.field("values"));
        if values.len() < 3 {
            return Err(at.error(format!("at least three are needed, got {}", values.len())));
        }
        for (index, value) in values.iter().enumerate() {
            at.index(index).non_negative(*value)?;
        }
        if values.iter().sum::<f64>() <= 0.0 {
            return Err(at.error("their mean must be positive"));
        }
        Ok(StiffnessModel::Table(values))
    }

    fn fourier(&self) -> Result<StiffnessModel, SceneError> {
        let mean = self.model.mean.ok_or_else(|| self.at.error("needs mean"))?;
        let mean = self.at.field("mean").positive(mean)?;
        let amplitudes = self.list(self.model.amplitudes.as_ref(), "amplitudes")?;
        let phases = match &self.model.phases {
            Some(phases) => self.list(Some(phases), "phases")?,
            None => vec![0.0; amplitudes.len()],
        };
        if phases.len() != amplitudes.len() {
            let message = format!("has {} entries for {} amplitudes", phases.len(), amplitudes.len());
            return Err(self.at.field("phases").error(message));
        }
        Ok(StiffnessModel::Fourier(mean, amplitudes.into_iter().zip(phases).map(|(a, p)| [a, p]).collect()))
    }
}

/// Refuses parameters that the model does not use.
fn refuse_unused(model: &description::StiffnessModel, at: &EntryPath) -> Result<(), SceneError> {
    use StiffnessKind::{Constant, Fourier, Parabolic, PotentialEnergy, Square, Table};
    let pairs = [Square, Parabolic, PotentialEnergy];
    let varies = [Square, Parabolic, PotentialEnergy, Table, Fourier];
    let fields: [(&str, bool, &[StiffnessKind]); 10] = [
        ("mean", model.mean.is_some(), &[Constant, Square, Parabolic, Fourier]),
        ("pair", model.pair.is_some(), &[Square, Parabolic]),
        ("end_ratio", model.end_ratio.is_some(), &[Parabolic]),
        ("values", model.values.is_some(), &[Table]),
        ("amplitudes", model.amplitudes.is_some(), &[Fourier]),
        ("phases", model.phases.is_some(), &[Fourier]),
        ("bore_radii", model.bore_radii.is_some(), &[PotentialEnergy]),
        ("foundation", model.foundation.is_some(), &[PotentialEnergy]),
        ("engagement", model.engagement.is_some(), &pairs),
        ("phase", model.phase.is_some(), &varies),
    ];
    for (name, given, kinds) in fields {
        if given && !kinds.contains(&model.model) {
            return Err(at.field(name).error("is not a parameter of this stiffness model"));
        }
    }
    Ok(())
}
