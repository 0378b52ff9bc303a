//! Checks how the teeth of a mesh are described: engagement, tip relief, backlash and transmission error.

use super::description::{self, Foundation, Phase, StiffnessKind};
use super::friction::{self, Friction};
use super::stiffness::{StiffnessModel, stiffness_model};
use super::{EntryPath, Gear, SceneError};

/// How a pair of teeth enters and leaves contact at the ends of the path of contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Engagement {
    /// Instantaneously: the stiffness jumps, and a time step ends at the jump.
    Sharp,
    /// Over this fraction of the base pitch, centred on the end of the path of contact.
    Smooth(f64),
}

/// Tip relief: removal of flank material near both ends of the path of contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Relief {
    /// Relief at the end of the path of contact, m.
    pub amount: f64,
    /// Length of the relief along the path of contact, from its end, m.
    pub length: f64,
    /// Exponent of the relief curve: 1 is linear, 2 is parabolic.
    pub exponent: i32,
}

/// Unloaded transmission error. Harmonic k of a list is `[amplitude, phase]` of order k + 1, in m and rad.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TransmissionError {
    /// Harmonics of the mesh frequency.
    pub tooth: Vec<[f64; 2]>,
    /// Harmonics of the rotation of the driver shaft.
    pub driver: Vec<[f64; 2]>,
    /// Harmonics of the rotation of the driven shaft.
    pub driven: Vec<[f64; 2]>,
    /// Values at equal intervals of the mesh cycle, m; may be empty.
    pub table: Vec<f64>,
}

/// The checked teeth of a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Teeth {
    /// Stiffness model.
    pub stiffness: StiffnessModel,
    /// Engagement of tooth pairs.
    pub engagement: Engagement,
    /// Motions that move the teeth along the path of contact.
    pub phase: Phase,
    /// Tip relief of both gears.
    pub relief: Option<Relief>,
    /// Backlash along the line of action, m; None if the flanks never separate.
    pub backlash: Option<f64>,
    /// Unloaded transmission error.
    pub error: Option<TransmissionError>,
    /// Friction between the flanks.
    pub friction: Option<Friction>,
}

/// Default engagement, as a fraction of the base pitch. The integration to 1e-7 then needs no event.
pub(super) const DEFAULT_ENGAGEMENT: f64 = 0.1;

impl Teeth {
    /// Checks the teeth of a mesh between the gears of `pair` on shafts of these outer radii, m.
    pub(super) fn new(
        given: &description::Mesh,
        pair: [&Gear; 2],
        shaft_radii: [f64; 2],
        at: &EntryPath,
        warnings: &mut Vec<String>,
    ) -> Result<Self, SceneError> {
        let place = at.field("stiffness");
        let model = match &given.stiffness {
            None => description::StiffnessModel::default(),
            Some(description::Stiffness::Mean(mean)) => description::StiffnessModel {
                mean: Some(*mean),
                ..description::StiffnessModel::of(StiffnessKind::Constant)
            },
            Some(description::Stiffness::Model(model)) => model.clone(),
        };
        let stiffness = stiffness_model(&model, pair, shaft_radii, &place, warnings)?;
        let engagement = engagement(model.engagement.as_ref(), &place.field("engagement"))?;
        let phase = phase(model.phase, engagement, &place.field("phase"))?;
        if matches!(stiffness, StiffnessModel::PotentialEnergy(.., Foundation::Shared)) && given.tip_relief.is_some() {
            let message = "\"shared\" cannot be combined with tip_relief; use \"separate\"";
            return Err(place.field("foundation").error(message));
        }
        if given.tip_relief.is_some() && pair[0].helix_angle != 0.0 {
            let message = "helical teeth take none; leave it out, or describe its effect by error=";
            return Err(at.field("tip_relief").error(message));
        }
        let pairs = stiffness.has_tooth_pairs();
        let relief = given.tip_relief.as_ref().map(|relief| self::relief(relief, pairs, &at.field("tip_relief")));
        let error = given.error.as_ref().map(|error| transmission_error(error, &at.field("error")));
        let friction = given.friction.as_ref().map(|own| friction::friction(own, pair, &at.field("friction")));
        Ok(Self {
            stiffness,
            engagement,
            phase,
            relief: relief.transpose()?,
            backlash: given.backlash.map(|backlash| at.field("backlash").non_negative(backlash)).transpose()?,
            error: error.transpose()?,
            friction: friction.transpose()?.flatten(),
        })
    }
}

fn engagement(given: Option<&description::Engagement>, at: &EntryPath) -> Result<Engagement, SceneError> {
    match given {
        None => Ok(Engagement::Smooth(DEFAULT_ENGAGEMENT)),
        Some(description::Engagement::Smooth(width)) => {
            if at.positive(*width)? > 0.5 {
                return Err(at.error(format!("must be at most half a base pitch, 0.5, got {width}")));
            }
            Ok(Engagement::Smooth(*width))
        }
        Some(description::Engagement::Named(name)) if name == "sharp" => Ok(Engagement::Sharp),
        Some(description::Engagement::Named(name)) => {
            Err(at.error(format!("must be \"sharp\" or a fraction of the base pitch, got \"{name}\"")))
        }
    }
}

fn phase(given: Option<Phase>, engagement: Engagement, at: &EntryPath) -> Result<Phase, SceneError> {
    if given == Some(Phase::Twist) && engagement == Engagement::Sharp {
        return Err(
            at.error("\"twist\" needs a smooth engagement: a stiffness jump that depends on the motion is an impact")
        );
    }
    Ok(given.unwrap_or(Phase::Prescribed))
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
