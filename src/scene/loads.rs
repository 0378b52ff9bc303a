//! Couplings, drives, forces, and torques that depend on time or speed.

use num_complex::Complex64;

use super::curve::{Curve, check_points};
use super::description::{self, ForceValue, Outside, SceneDescription, TimeSeries, TorqueTable, TorqueValue};
use super::place::Names;
use super::{EntryPath, Node, SceneError, Shaft, complex};

/// A coupling between two coaxial shafts of one speed.
#[derive(Clone, Copy, Debug)]
pub struct Coupling {
    /// Nodes of the hubs a and b.
    pub hubs: [Node; 2],
    /// Along the axis: N/m and N s/m.
    pub axial: SpringDamper,
    /// Across the axis: N/m and N s/m.
    pub lateral: SpringDamper,
    /// Against tilting: N m/rad and N m s/rad.
    pub tilting: SpringDamper,
    /// Against twist: N m/rad and N m s/rad.
    pub torsional: SpringDamper,
    /// Parallel misalignment of the axis of b to that of a, y + iz, m.
    pub offset: Complex64,
    /// Angular misalignment of the axis of b to that of a, slopes along y + iz, rad.
    pub angle: Complex64,
    /// Eccentricity of the hub of b, m, with its angle in the rotating shaft.
    pub runout: Complex64,
}

/// Stiffness and damping in one direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpringDamper {
    /// Stiffness.
    pub stiffness: f64,
    /// Damping.
    pub damping: f64,
}

impl SpringDamper {
    /// Checks the entries `direction`_stiffness and `direction`_damping; one that is not given is zero.
    pub(super) fn new(
        direction: &str,
        stiffness: Option<f64>,
        damping: Option<f64>,
        at: &EntryPath,
    ) -> Result<Self, SceneError> {
        let read = |quantity: &str, given: Option<f64>| {
            at.field(&format!("{direction}_{quantity}")).non_negative(given.unwrap_or(0.0))
        };
        Ok(Self { stiffness: read("stiffness", stiffness)?, damping: read("damping", damping)? })
    }

    /// Whether it has neither.
    pub fn is_zero(&self) -> bool {
        self.stiffness == 0.0 && self.damping == 0.0
    }
}

/// A torsional spring and damper between a shaft and its prescribed angle.
#[derive(Clone, Copy, Debug)]
pub struct Drive {
    /// Node on which it acts.
    pub node: Node,
    /// Stiffness, N m/rad.
    pub stiffness: f64,
    /// Damping, N m s/rad.
    pub damping: f64,
}

/// A constant force, or one that turns with its shaft.
#[derive(Clone, Copy, Debug)]
pub struct Force {
    /// Node on which it acts.
    pub node: Node,
    /// Force y + iz, N; at the shaft angle 0 if it turns.
    pub value: Complex64,
    /// Whether it turns with the shaft.
    pub turns: bool,
    /// Component along the axis, N, which does not turn.
    pub axial: f64,
}

/// A load that depends on time, on the angle or on the speed of its shaft.
#[derive(Clone, Debug)]
pub struct VaryingLoad {
    /// Path of its value in the scene.
    pub path: String,
    /// Node on which it acts.
    pub node: Node,
    /// Its law.
    pub law: LoadLaw,
}

/// Law of a varying load.
#[derive(Clone, Debug)]
pub enum LoadLaw {
    /// Force over time along y and z, N.
    Force([Curve; 2]),
    /// Force amplitude·e^{i·order·ϑ}, N, at the shaft angle ϑ.
    Turning {
        /// Force y + iz at ϑ = 0, N.
        amplitude: Complex64,
        /// Angle of the force per angle of the shaft.
        order: f64,
    },
    /// Torque over time, N m.
    Torque(Curve),
    /// Torque over the magnitude of the actual speed Ω_s + θ̇, rad/s, in N m.
    SpeedTorque {
        /// The table.
        curve: Curve,
        /// Whether the end values hold for speeds Ω_s outside the table.
        holds: bool,
    },
}

impl LoadLaw {
    /// Whether it acts on the twist; otherwise on v and w.
    pub fn is_torque(&self) -> bool {
        matches!(self, Self::Torque(_) | Self::SpeedTorque { .. })
    }

    /// Torque at the first point of its table, N m, whose sign gives the loaded flanks before a run; zero for a force.
    pub fn first_torque(&self) -> f64 {
        match self {
            Self::Torque(curve) | Self::SpeedTorque { curve, .. } => curve.at(curve.range()[0])[0],
            Self::Force(_) | Self::Turning { .. } => 0.0,
        }
    }
}

/// All couplings.
pub(super) fn couplings(
    system: &SceneDescription,
    names: &Names,
    shafts: &[Shaft],
) -> Result<Vec<Coupling>, SceneError> {
    let coupling = |(index, given): (usize, &description::Coupling)| {
        let at = EntryPath::entry("couplings", index);
        let hub = |place, field: &str| names.place(shafts, place, &at.field(field));
        let hubs = [hub(&given.a, "a")?, hub(&given.b, "b")?];
        if hubs[0].shaft == hubs[1].shaft {
            let name = &shafts[hubs[0].shaft].name;
            return Err(at.field("b").error(format!("is on \"{name}\", as a is; a coupling joins two shafts")));
        }
        let spring = |direction, stiffness, damping| SpringDamper::new(direction, stiffness, damping, &at);
        Ok(Coupling {
            hubs,
            axial: spring("axial", given.axial_stiffness, given.axial_damping)?,
            lateral: spring("lateral", given.lateral_stiffness, given.lateral_damping)?,
            tilting: spring("tilting", given.tilting_stiffness, given.tilting_damping)?,
            torsional: spring("torsional", Some(given.torsional_stiffness), given.torsional_damping)?,
            offset: complex(given.offset, &at.field("offset"))?,
            angle: complex(given.angle, &at.field("angle"))?,
            runout: complex(given.runout, &at.field("runout"))?,
        })
    };
    system.couplings.iter().enumerate().map(coupling).collect()
}

/// All drives.
pub(super) fn drives(system: &SceneDescription, names: &Names, shafts: &[Shaft]) -> Result<Vec<Drive>, SceneError> {
    let drive = |(index, given): (usize, &description::Drive)| {
        let at = EntryPath::entry("drives", index);
        Ok(Drive {
            node: names.place(shafts, &given.at, &at.field("at"))?,
            stiffness: at.field("stiffness").non_negative(given.stiffness)?,
            damping: at.field("damping").non_negative(given.damping.unwrap_or(0.0))?,
        })
    };
    system.drives.iter().enumerate().map(drive).collect()
}

/// Forces that are constant or turn with their shaft, and the constant axial part of others.
pub(super) fn forces(system: &SceneDescription, names: &Names, shafts: &[Shaft]) -> Result<Vec<Force>, SceneError> {
    let mut forces = Vec::new();
    for (index, given) in system.forces.iter().enumerate() {
        let at = EntryPath::entry("forces", index);
        let node = names.place(shafts, &given.at, &at.field("at"))?;
        let axial = at.field("axial").finite(given.axial.unwrap_or(0.0))?;
        let order = given.order.map(|order| at.field("order").finite(order)).transpose()?;
        match (&given.value, order) {
            (ForceValue::Constant(value), None | Some(1.0)) => {
                let value = complex(Some(*value), &at.field("value"))?;
                forces.push(Force { node, value, turns: order.is_some(), axial });
            }
            // The lateral part depends on time or angle.
            _ if axial != 0.0 => forces.push(Force { node, value: Complex64::ZERO, turns: false, axial }),
            _ => {}
        }
    }
    Ok(forces)
}

/// Forces and torques that depend on time or speed, and forces that turn at a multiple of the speed of their shaft.
pub(super) fn varying(
    system: &SceneDescription,
    names: &Names,
    shafts: &[Shaft],
) -> Result<Vec<VaryingLoad>, SceneError> {
    let mut loads = Vec::new();
    for (index, given) in system.forces.iter().enumerate() {
        let at = EntryPath::entry("forces", index);
        let value = at.field("value");
        let law = match (&given.value, given.order) {
            (ForceValue::Constant(_), None | Some(1.0)) => continue,
            (ForceValue::Constant(amplitude), Some(order)) => {
                LoadLaw::Turning { amplitude: complex(Some(*amplitude), &value)?, order }
            }
            (ForceValue::Series(series), None) => LoadLaw::Force(series_parts(series, &value)?),
            (ForceValue::Series(_), Some(_)) => {
                let message = "turns a constant force; give a time series without order";
                return Err(at.field("order").error(message));
            }
        };
        let node = names.place(shafts, &given.at, &at.field("at"))?;
        loads.push(VaryingLoad { path: value.to_string(), node, law });
    }
    for (index, given) in system.torques.iter().enumerate() {
        let at = EntryPath::entry("torques", index);
        let value = at.field("value");
        let law = match &given.value {
            None | Some(TorqueValue::Constant(_)) => continue,
            Some(TorqueValue::Series(series)) => {
                let [torque, imaginary] = series_parts(series, &value)?;
                if imaginary.steepest() > 0.0 || imaginary.at(0.0)[0] != 0.0 {
                    return Err(value.field("values").error("a torque is a real number, got complex values"));
                }
                LoadLaw::Torque(torque)
            }
            Some(TorqueValue::Table(table)) => speed_torque(table, &value)?,
        };
        let node = names.place(shafts, &given.at, &at.field("at"))?;
        loads.push(VaryingLoad { path: value.to_string(), node, law });
    }
    Ok(loads)
}

fn series_parts(series: &TimeSeries, at: &EntryPath) -> Result<[Curve; 2], SceneError> {
    let values: Vec<Complex64> = series.values.iter().map(|value| Complex64::from(*value)).collect();
    check_points(at, "times", "values", &series.times, &values)?;
    let slopes = series.slopes.as_ref().map(|slopes| slopes.iter().map(|slope| Complex64::from(*slope)).collect());
    let slopes: Option<Vec<Complex64>> = slopes;
    if let Some(slopes) = &slopes {
        check_points(at, "times", "slopes", &series.times, slopes)?;
    }
    let part = |part: fn(&Complex64) -> f64| {
        let curve = Curve::new(series.times.clone(), values.iter().map(part).collect());
        match &slopes {
            Some(slopes) => curve.with_slopes(slopes.iter().map(part).collect()),
            None => curve,
        }
    };
    Ok([part(|value| value.re), part(|value| value.im)])
}

fn speed_torque(table: &TorqueTable, at: &EntryPath) -> Result<LoadLaw, SceneError> {
    let values: Vec<Complex64> = table.values.iter().map(|value| Complex64::from(*value)).collect();
    check_points(at, "speeds", "values", &table.speeds, &values)?;
    at.field("speeds").index(0).non_negative(table.speeds[0])?;
    let curve = Curve::new(table.speeds.clone(), table.values.clone());
    Ok(LoadLaw::SpeedTorque { curve, holds: table.outside == Outside::Hold })
}
