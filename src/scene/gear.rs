//! Spur gears and the pairs that they make.

use std::f64::consts::PI;

use num_complex::Complex64;

use super::contact::{check_contact, check_undercut};
use super::description::{self, STEEL, SceneDescription};
use super::place::Names;
use super::{Body, EntryPath, SceneError, Shaft, Teeth, complex, nearest};

/// Base pitches of a pair that differ by more than this part cannot mesh; published data round their radii.
const BASE_PITCH_TOLERANCE: f64 = 0.05;
/// Dedendum of full-depth teeth in modules (ISO 53).
pub(crate) const DEDENDUM: f64 = 1.25;
/// Modules, pressure angles and base pitches that agree to this part are the same number.
pub(super) const SAME: f64 = 1e-9;
/// Pressure angle of the basic rack where none is given (ISO 53).
const STANDARD_PRESSURE_ANGLE: f64 = 20.0 * PI / 180.0;

/// A checked gear.
#[derive(Clone, Debug)]
pub struct Gear {
    /// Its body.
    pub body: Body,
    /// Number of teeth z.
    pub teeth: u32,
    /// Base radius, m.
    pub base_radius: f64,
    /// Reference pitch radius, m.
    pub pitch_radius: f64,
    /// Tip radius, m.
    pub tip_radius: f64,
    /// Module, m.
    pub module: f64,
    /// Pressure angle of the basic rack, rad.
    pub pressure_angle: f64,
    /// Profile shift coefficient.
    pub profile_shift: f64,
    /// Face width, m, where it was given.
    pub face_width: Option<f64>,
    /// Run-out: how far the base circle stands off the shaft's axis, m, with its angle in the shaft.
    pub run_out: Complex64,
    /// Module and pressure angle of the basic rack, where the module was given.
    rack: Option<(f64, f64)>,
}

impl Gear {
    /// Base pitch 2πr/z, m.
    pub fn base_pitch(&self) -> f64 {
        2.0 * PI * self.base_radius / f64::from(self.teeth)
    }

    /// Half the angle of a tooth at the base circle, rad, of teeth that leave no backlash: π/2z + 2x tan α/z + inv α.
    pub fn half_angle(&self) -> f64 {
        let (teeth, tan) = (f64::from(self.teeth), self.pressure_angle.tan());
        PI / (2.0 * teeth) + 2.0 * self.profile_shift * tan / teeth + tan - self.pressure_angle
    }

    /// Length of the line of action from the base circle to the tip circle, √(tip radius² − base radius²), m.
    pub fn tip_reach(&self) -> f64 {
        (self.tip_radius.powi(2) - self.base_radius.powi(2)).sqrt()
    }

    /// The same to the root circle; zero where the involute ends on the base circle.
    pub fn root_reach(&self) -> f64 {
        (self.root_radius().powi(2) - self.base_radius.powi(2)).max(0.0).sqrt()
    }

    /// Root radius of full-depth teeth, m.
    pub fn root_radius(&self) -> f64 {
        self.pitch_radius - self.module * (DEDENDUM - self.profile_shift)
    }
}

/// Damping of a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Damping {
    /// The ratio ζ of c = 2ζ√(k mₑ), k being the mean stiffness and mₑ = (r_a²/I_pa + r_b²/I_pb)⁻¹.
    Ratio(f64),
    /// c, N s/m.
    Constant(f64),
}

/// A checked mesh.
#[derive(Clone, Debug)]
pub struct Mesh {
    /// Index of the driving gear.
    pub driver: usize,
    /// Index of the driven gear.
    pub driven: usize,
    /// Stiffness, engagement, relief, backlash and error.
    pub teeth: Teeth,
    /// Damping along the line of action.
    pub damping: Damping,
    /// Angle ψ of the line of centres at rest, rad.
    pub centre_line_angle: f64,
    /// Distance C₀ of the centres at rest, m.
    pub centre_distance: f64,
}

pub(super) fn gears(system: &SceneDescription, names: &Names, shafts: &[Shaft]) -> Result<Vec<Gear>, SceneError> {
    system
        .gears
        .iter()
        .enumerate()
        .map(|(index, given)| gear(given, names, shafts, &EntryPath::entry("gears", index)))
        .collect()
}

fn gear(given: &description::Gear, names: &Names, shafts: &[Shaft], at: &EntryPath) -> Result<Gear, SceneError> {
    if given.teeth < 3 {
        return Err(at.field("teeth").error(format!("must be at least 3, got {}", given.teeth)));
    }
    let teeth = f64::from(given.teeth);
    let optional = |name: &str, value: Option<f64>| value.map(|value| at.field(name).positive(value)).transpose();
    let pressure_angle =
        at.field("pressure_angle").positive(given.pressure_angle.unwrap_or(STANDARD_PRESSURE_ANGLE))?;
    if pressure_angle >= PI / 4.0 {
        let message = format!("must be below π/4 rad (is it in degrees?), got {pressure_angle}");
        return Err(at.field("pressure_angle").error(message));
    }
    let profile_shift = at.field("profile_shift").finite(given.profile_shift.unwrap_or(0.0))?;
    let module_given = optional("module", given.module)?;
    let (module, base_radius) = match (module_given, optional("base_radius", given.base_radius)?) {
        (Some(module), Some(base)) => {
            let expected = module * teeth / 2.0 * pressure_angle.cos();
            if (base - expected).abs() > BASE_PITCH_TOLERANCE * expected {
                let message =
                    format!("{base} m is not the base radius of this module and pressure angle, {expected} m");
                return Err(at.field("base_radius").error(message));
            }
            (module, base)
        }
        (Some(module), None) => (module, module * teeth / 2.0 * pressure_angle.cos()),
        (None, Some(base)) => (2.0 * base / (teeth * pressure_angle.cos()), base),
        (None, None) => return Err(at.error("needs module or base_radius")),
    };
    let pitch_radius = module * teeth / 2.0;
    let tip_radius = optional("tip_radius", given.tip_radius)?.unwrap_or(pitch_radius + module * (1.0 + profile_shift));
    if tip_radius <= base_radius {
        let message = format!("{tip_radius} m leaves no tooth above the base radius of {base_radius} m");
        return Err(at.field("tip_radius").error(message));
    }

    // What was not given of the inertia is that of a solid steel disk on the pitch circle.
    let face_width = optional("face_width", given.face_width)?;
    let needs_width = |name: &str| at.error(format!("needs face_width, or {name}"));
    let square = pitch_radius * pitch_radius;
    let mass = match (given.mass, face_width) {
        (Some(mass), _) => at.field("mass").non_negative(mass)?,
        (None, Some(width)) => STEEL.density * PI * square * width,
        (None, None) => return Err(needs_width("mass")),
    };
    let diametral_inertia = match (given.diametral_inertia, face_width) {
        (Some(inertia), _) => at.field("diametral_inertia").non_negative(inertia)?,
        (None, Some(width)) => mass * (3.0 * square + width * width) / 12.0,
        (None, None) => return Err(needs_width("diametral_inertia")),
    };
    let polar_inertia = match given.polar_inertia {
        Some(inertia) => at.field("polar_inertia").non_negative(inertia)?,
        None => mass * square / 2.0,
    };
    let body = Body {
        name: given.name.clone(),
        node: names.node(shafts, &given.shaft, given.position, at)?,
        mass,
        diametral_inertia,
        polar_inertia,
        unbalance: complex(given.unbalance, &at.field("unbalance"))?,
    };
    let rack = module_given.map(|module| (module, pressure_angle));
    let run_out = complex(given.run_out, &at.field("run_out"))?;
    Ok(Gear {
        body,
        teeth: given.teeth,
        base_radius,
        pitch_radius,
        tip_radius,
        module,
        pressure_angle,
        profile_shift,
        face_width,
        run_out,
        rack,
    })
}

pub(super) fn meshes(
    system: &SceneDescription,
    shafts: &[Shaft],
    gears: &[Gear],
    warnings: &mut Vec<String>,
) -> Result<Vec<Mesh>, SceneError> {
    let mut meshes: Vec<Mesh> = Vec::with_capacity(system.meshes.len());
    for (index, given) in system.meshes.iter().enumerate() {
        let at = EntryPath::entry("meshes", index);
        let mesh = mesh(given, shafts, gears, &at, warnings)?;
        let pair = |mesh: &Mesh| (mesh.driver.min(mesh.driven), mesh.driver.max(mesh.driven));
        if let Some(first) = meshes.iter().position(|other| pair(other) == pair(&mesh)) {
            return Err(at.error(format!("the same pair of gears as meshes[{first}]")));
        }
        meshes.push(mesh);
    }
    for (index, gear) in gears.iter().enumerate() {
        // A gear that is given by its base circle may have been cut by any rack.
        if gear.rack.is_some() && meshes.iter().any(|mesh| [mesh.driver, mesh.driven].contains(&index)) {
            check_undercut(gear, &EntryPath::entry("gears", index), warnings);
        }
    }
    Ok(meshes)
}

fn mesh(
    given: &description::Mesh,
    shafts: &[Shaft],
    gears: &[Gear],
    at: &EntryPath,
    warnings: &mut Vec<String>,
) -> Result<Mesh, SceneError> {
    let find = |field: &str, name: &str| {
        let place = at.field(field);
        gears.iter().position(|gear| gear.body.name == name).ok_or_else(|| {
            let names = gears.iter().map(|gear| gear.body.name.as_str());
            place.error(format!("no gear is called \"{name}\"{}", nearest(name, names)))
        })
    };
    let (driver, driven) = (find("driver", &given.driver)?, find("driven", &given.driven)?);
    let (a, b) = (&gears[driver], &gears[driven]);
    if a.body.node.shaft == b.body.node.shaft {
        return Err(at.error(format!("\"{}\" and \"{}\" sit on the same shaft", given.driver, given.driven)));
    }
    check_racks(a, b, at, warnings)?;

    let centre_distance = match given.centre_distance {
        Some(distance) => at.field("centre_distance").positive(distance)?,
        None => a.pitch_radius + b.pitch_radius,
    };
    let base_circles = a.base_radius + b.base_radius;
    if centre_distance <= base_circles {
        let message =
            format!("{centre_distance} m lets the base circles overlap, whose radii add up to {base_circles} m");
        return Err(at.field("centre_distance").error(message));
    }
    check_contact([a, b], centre_distance, at, warnings)?;
    let shaft_radii = [a, b].map(|gear| shafts[gear.body.node.shaft].radius_at(gear.body.node.node));
    let teeth = Teeth::new(given, [a, b], shaft_radii, at, warnings)?;
    let damping = match (given.damping, given.damping_ratio) {
        (Some(_), Some(_)) => return Err(at.field("damping").error("stands beside damping_ratio; give one of them")),
        (Some(damping), None) => Damping::Constant(at.field("damping").non_negative(damping)?),
        (None, ratio) => Damping::Ratio(at.field("damping_ratio").non_negative(ratio.unwrap_or(0.0))?),
    };
    let centre_line_angle = at.field("centre_line_angle").finite(given.centre_line_angle.unwrap_or(0.0))?;
    Ok(Mesh { driver, driven, teeth, damping, centre_line_angle, centre_distance })
}

/// Gears mesh when their base pitches agree; gears of different racks cannot, whatever their base pitches.
fn check_racks(a: &Gear, b: &Gear, at: &EntryPath, warnings: &mut Vec<String>) -> Result<(), SceneError> {
    let differ = |first: f64, second: f64| (first - second).abs() > SAME * first.abs().max(second.abs());
    let names = || (a.body.name.as_str(), b.body.name.as_str());
    if let (Some((module_a, angle_a)), Some((module_b, angle_b))) = (a.rack, b.rack) {
        let (first, second) = names();
        if differ(module_a, module_b) {
            let message = format!("cannot mesh: \"{first}\" has module {module_a} m, \"{second}\" {module_b} m");
            return Err(at.error(message));
        }
        if differ(angle_a, angle_b) {
            let message =
                format!("cannot mesh: \"{first}\" has pressure angle {angle_a} rad, \"{second}\" {angle_b} rad");
            return Err(at.error(message));
        }
    }
    let (pitch_a, pitch_b) = (a.base_pitch(), b.base_pitch());
    let difference = (pitch_a - pitch_b).abs() / pitch_a.max(pitch_b);
    let (first, second) = names();
    let message = format!("the base pitch of \"{first}\" is {pitch_a} m, that of \"{second}\" {pitch_b} m");
    if difference > BASE_PITCH_TOLERANCE {
        return Err(at.error(format!("cannot mesh: {message}")));
    }
    if difference > SAME {
        warnings.push(format!("{at}: {message}; speeds follow the tooth numbers, forces the base radii"));
    }
    Ok(())
}
