//! What the teeth of a mesh do: stiffness, engagement, relief, backlash and unloaded error, checked.

use super::description::{self, StiffnessKind};
use super::gear::SAME;
use super::{EntryPath, Gear, SceneError};

/// How a pair of teeth enters and leaves the path of contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Engagement {
    /// At once: the stiffness jumps, and a step of the integration ends there.
    Sharp,
    /// Over this part of the base pitch, half of it before and half after the end of the path.
    Smooth(f64),
}

pub use super::description::Foundation;

/// What moves the teeth along the path of contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// Spin, twist and centres, with the force ½δ² ∂k/∂q that belongs to them: energy is conserved, so that what
    /// damping takes from the vibration slows the rolling of a train whose torques are in balance.
    Twist,
    /// Spin and centres; the stiffness is prescribed, and what holds the speed does work through it.
    Prescribed,
}

/// Tip relief: how far the flank stands back near both ends of the path of contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Relief {
    /// At the very end, m.
    pub amount: f64,
    /// Along the path from its end, m.
    pub length: f64,
    /// 1 for a straight relief, 2 for a parabolic one.
    pub exponent: i32,
}

/// What a stiffness is known by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Scale {
    /// The mean of the mesh, N/m.
    Mean(f64),
    /// One pair, where it is stiffest, N/m.
    Pair(f64),
}

/// A stiffness model.
#[derive(Clone, Debug, PartialEq)]
pub enum StiffnessModel {
    /// Constant, N/m.
    Mean(f64),
    /// Constant, from ISO 6336-1 for this face width, m.
    Iso6336(f64),
    /// Pairs of the same stiffness along the path.
    Square(Scale),
    /// Pairs whose stiffness falls as a parabola to this part of it at the ends of the path.
    Parabolic(Scale, f64),
    /// Pairs from their teeth by potential energy, for this face width, m, and radii at which the blanks are held, m.
    PotentialEnergy(f64, [f64; 2], Foundation),
    /// Values of the whole mesh at equal parts of its cycle, N/m.
    Table(Vec<f64>),
    /// Mean of the whole mesh, N/m, and amplitude, N/m, and phase, rad, of its harmonics.
    Fourier(f64, Vec<[f64; 2]>),
}

/// Harmonics of an unloaded transmission error: amplitude, m, and phase, rad, of the orders 1, 2, ….
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TransmissionError {
    /// Of the mesh frequency.
    pub tooth: Vec<[f64; 2]>,
    /// Of the driver's shaft.
    pub driver: Vec<[f64; 2]>,
    /// Of the driven shaft.
    pub driven: Vec<[f64; 2]>,
    /// Values at equal parts of the mesh cycle, m; empty for none.
    pub table: Vec<f64>,
}

/// All of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Teeth {
    /// Stiffness.
    pub stiffness: StiffnessModel,
    /// Engagement of the pairs.
    pub engagement: Engagement,
    /// What moves them along the path.
    pub phase: Phase,
    /// Tip relief.
    pub relief: Option<Relief>,
    /// Backlash along the line of action, m; none for a mesh that never parts.
    pub backlash: Option<f64>,
    /// Unloaded transmission error.
    pub error: Option<TransmissionError>,
}

/// Engagement over a tenth of the base pitch needs no event to be integrated to 1e-7.
const DEFAULT_ENGAGEMENT: f64 = 0.1;
/// Stiffness of a parabolic pair at the ends of the path, as a part of that in the middle.
const DEFAULT_END_RATIO: f64 = 0.6;
/// Root radius over bore radius for which the fillet-foundation deflection was fitted: 1.4 to 7, which the source prints
/// with two digits, so that ratios that round to them count as inside.
const FOUNDATION_RANGE: [f64; 2] = [1.35, 7.05];

impl Teeth {
    pub(super) fn new(
        given: &description::Mesh,
        pair: [&Gear; 2],
        shaft_radii: [f64; 2],
        at: &EntryPath,
        warnings: &mut Vec<String>,
    ) -> Result<Self, SceneError> {
        let place = at.field("stiffness");
        let model = match &given.stiffness {
            None => description::StiffnessModel::of(StiffnessKind::Iso6336),
            Some(description::Stiffness::Mean(mean)) => description::StiffnessModel {
                mean: Some(*mean),
                ..description::StiffnessModel::of(StiffnessKind::Constant)
            },
            Some(description::Stiffness::Model(model)) => model.clone(),
        };
        unused(&model, &place)?;
        let stiffness = stiffness(&model, pair, shaft_radii, &place, warnings)?;
        let engagement = match &model.engagement {
            None => Engagement::Smooth(DEFAULT_ENGAGEMENT),
            Some(description::Engagement::Smooth(width)) => {
                let at = place.field("engagement");
                if at.positive(*width)? > 0.5 {
                    return Err(at.error(format!("must be at most half a base pitch, 0.5, got {width}")));
                }
                Engagement::Smooth(*width)
            }
            Some(description::Engagement::Named(name)) if name == "sharp" => Engagement::Sharp,
            Some(description::Engagement::Named(name)) => {
                let message = format!("must be \"sharp\" or a part of the base pitch, got \"{name}\"");
                return Err(place.field("engagement").error(message));
            }
        };
        let phase = match (model.phase, engagement) {
            (Some(description::Phase::Twist), Engagement::Sharp) => {
                let message = "\"twist\" needs a smooth engagement: a jump that depends on the motion is a blow";
                return Err(place.field("phase").error(message));
            }
            (Some(description::Phase::Twist), Engagement::Smooth(_)) => Phase::Twist,
            _ => Phase::Prescribed,
        };
        let pairs = match stiffness {
            StiffnessModel::PotentialEnergy(.., Foundation::Shared) if given.tip_relief.is_some() => {
                let message = "\"shared\" cannot be combined with tip_relief; use \"separate\"";
                return Err(place.field("foundation").error(message));
            }
            StiffnessModel::Square(_) | StiffnessModel::Parabolic(..) | StiffnessModel::PotentialEnergy(..) => true,
            _ => false,
        };
        let relief = given.tip_relief.as_ref().map(|relief| self::relief(relief, pairs, &at.field("tip_relief")));
        let error = given.error.as_ref().map(|error| transmission_error(error, &at.field("error")));
        Ok(Self {
            stiffness,
            engagement,
            phase,
            relief: relief.transpose()?,
            backlash: given.backlash.map(|backlash| at.field("backlash").non_negative(backlash)).transpose()?,
            error: error.transpose()?,
        })
    }
}

/// Parameters that the model does not have are errors, not ignored.
fn unused(model: &description::StiffnessModel, at: &EntryPath) -> Result<(), SceneError> {
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

fn stiffness(
    model: &description::StiffnessModel,
    pair: [&Gear; 2],
    shaft_radii: [f64; 2],
    at: &EntryPath,
    warnings: &mut Vec<String>,
) -> Result<StiffnessModel, SceneError> {
    let needed = |value: Option<f64>, name: &str| {
        at.field(name).positive(value.ok_or_else(|| at.error(format!("needs {name}")))?)
    };
    let scale = || match (model.mean, model.pair) {
        (Some(mean), None) => Ok(Scale::Mean(at.field("mean").positive(mean)?)),
        (None, Some(pair)) => Ok(Scale::Pair(at.field("pair").positive(pair)?)),
        _ => Err(at.error("needs one of mean and pair")),
    };
    let face_width = || match pair.map(|gear| gear.face_width) {
        [Some(a), Some(b)] => Ok(a.min(b)),
        _ => Err(at.error("needs the face_width of both gears, or a number [N/m]")),
    };
    let list = |values: &Option<Vec<f64>>, name: &str| {
        let values = values.clone().ok_or_else(|| at.error(format!("needs {name}")))?;
        for (index, value) in values.iter().enumerate() {
            at.field(name).index(index).finite(*value)?;
        }
        Ok::<_, SceneError>(values)
    };
    Ok(match model.model {
        // A number is the whole stiffness: what is wrong with it is wrong there.
        StiffnessKind::Constant => {
            StiffnessModel::Mean(at.positive(model.mean.ok_or_else(|| at.error("needs mean"))?)?)
        }
        StiffnessKind::Iso6336 => StiffnessModel::Iso6336(face_width()?),
        StiffnessKind::Square => StiffnessModel::Square(scale()?),
        StiffnessKind::Parabolic => {
            let ratio = needed(model.end_ratio.or(Some(DEFAULT_END_RATIO)), "end_ratio")?;
            if ratio > 1.0 {
                return Err(at.field("end_ratio").error(format!("must be at most 1, got {ratio}")));
            }
            StiffnessModel::Parabolic(scale()?, ratio)
        }
        StiffnessKind::PotentialEnergy => {
            let mut radii = model.bore_radii.unwrap_or(shaft_radii);
            for (index, (radius, gear)) in radii.iter_mut().zip(pair).enumerate() {
                let root = gear.root_radius();
                if root >= gear.tip_radius {
                    let message = format!(
                        "\"{}\" has no tooth between its tip radius of {} m and its root radius of {root} m",
                        gear.body.name, gear.tip_radius
                    );
                    return Err(at.error(message));
                }
                let at = at.field("bore_radii").index(index);
                if at.positive(*radius)? >= root {
                    let message = format!("{radius} m leaves no blank below the root radius of {root} m");
                    return Err(at.error(message));
                }
                let ratio = root / *radius;
                if !(FOUNDATION_RANGE[0] - SAME..=FOUNDATION_RANGE[1] + SAME).contains(&ratio) {
                    warnings.push(format!(
                        "{at}: the root radius of \"{}\" is {ratio:.3} times the radius of {radius} m at which its \
                         blank is held; the compliance of fillet and blank was fitted for 1.4 to 7 (Sainsot, Velex and \
                         Duverger 2004): give bore_radii in that range, or another stiffness model",
                        gear.body.name
                    ));
                }
            }
            StiffnessModel::PotentialEnergy(face_width()?, radii, model.foundation.unwrap_or(Foundation::Separate))
        }
        StiffnessKind::Table => {
            let values = list(&model.values, "values")?;
            if values.len() < 3 {
                return Err(at.field("values").error(format!("at least three are needed, got {}", values.len())));
            }
            for (index, value) in values.iter().enumerate() {
                at.field("values").index(index).non_negative(*value)?;
            }
            if values.iter().sum::<f64>() <= 0.0 {
                return Err(at.field("values").error("their mean must be positive"));
            }
            StiffnessModel::Table(values)
        }
        StiffnessKind::Fourier => {
            let mean = needed(model.mean, "mean")?;
            let amplitudes = list(&model.amplitudes, "amplitudes")?;
            let phases = match &model.phases {
                Some(_) => list(&model.phases, "phases")?,
                None => vec![0.0; amplitudes.len()],
            };
            if phases.len() != amplitudes.len() {
                let message = format!("has {} entries for {} amplitudes", phases.len(), amplitudes.len());
                return Err(at.field("phases").error(message));
            }
            StiffnessModel::Fourier(mean, amplitudes.into_iter().zip(phases).map(|(a, p)| [a, p]).collect())
        }
    })
}

fn relief(given: &description::TipRelief, pairs: bool, at: &EntryPath) -> Result<Relief, SceneError> {
    if !pairs {
        return Err(at.error("needs a stiffness model of tooth pairs: square, parabolic or potential_energy"));
    }
    let exponent = match given.shape.as_deref() {
        None | Some("linear") => 1,
        Some("parabolic") => 2,
        Some(other) => {
            return Err(at.field("shape").error(format!("must be \"linear\" or \"parabolic\", got \"{other}\"")));
        }
    };
    let amount = at.field("amount").non_negative(given.amount)?;
    Ok(Relief { amount, length: at.field("length").positive(given.length)?, exponent })
}

fn transmission_error(given: &description::TransmissionError, at: &EntryPath) -> Result<TransmissionError, SceneError> {
    let harmonics = |list: &Option<Vec<[f64; 2]>>, name: &str| {
        let list = list.clone().unwrap_or_default();
        for (index, harmonic) in list.iter().enumerate() {
            for (part, value) in harmonic.iter().enumerate() {
                at.field(name).index(index).index(part).finite(*value)?;
            }
        }
        Ok::<_, SceneError>(list)
    };
    let table = given.table.clone().unwrap_or_default();
    if !table.is_empty() && table.len() < 3 {
        return Err(at.field("table").error(format!("at least three values are needed, got {}", table.len())));
    }
    for (index, value) in table.iter().enumerate() {
        at.field("table").index(index).finite(*value)?;
    }
    Ok(TransmissionError {
        tooth: harmonics(&given.tooth, "tooth")?,
        driver: harmonics(&given.driver, "driver")?,
        driven: harmonics(&given.driven, "driven")?,
        table,
    })
}
