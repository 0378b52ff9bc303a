//! Spur and helical gears: checks a described gear and computes its missing sizes and inertia.

use std::f64::consts::PI;

use num_complex::Complex64;

use super::description::{self, STEEL, SceneDescription};
use super::place::Names;
use super::{Body, EntryPath, SceneError, Shaft, complex};

/// Relative tolerance of relations between published data, which are rounded: base pitches of a pair in mesh, and I_p ≤ 2 I_d.
pub(super) const PUBLISHED_DATA_TOLERANCE: f64 = 0.05;
/// Dedendum of full-depth teeth in modules (ISO 53).
const STANDARD_DEDENDUM: f64 = 1.25;
/// Thickness of the rim of an internal gear outside its root circle, in modules, where mass and inertias are not given: from this
/// thickness on the rim has no effect on the strength of the roots (ISO 6336-3).
const STANDARD_RIM: f64 = 3.5;
/// Default pressure angle of the basic rack, rad (ISO 53).
const STANDARD_PRESSURE_ANGLE: f64 = 20.0 * PI / 180.0;

/// Largest helix angle, rad. Usual ones are below 45°.
const MAX_HELIX_ANGLE: f64 = PI / 3.0;

/// A checked gear.
#[derive(Clone, Debug)]
pub struct Gear {
    /// Rigid body of the gear.
    pub body: Body,
    /// Number of teeth z.
    pub teeth: u32,
    /// Whether the teeth point inwards. Radii are positive; [`Gear::sign`] gives numbers of teeth and radii the signs of
    /// ISO 21771, with which the formulas of external gears hold.
    pub internal: bool,
    /// Base radius, m.
    pub base_radius: f64,
    /// Reference pitch radius, m.
    pub pitch_radius: f64,
    /// Tip radius, m; the default is r ± m (1 + x), shortened where the tip clearance of a mesh would be too small.
    pub tip_radius: f64,
    /// Module, m; of a helical gear the normal module.
    pub module: f64,
    /// Pressure angle of the basic rack, rad: that in the normal section of a helical gear.
    pub pressure_angle: f64,
    /// Helix angle β on the reference circle, rad; positive for a right-hand helix, zero for a spur gear.
    pub helix_angle: f64,
    /// Profile shift coefficient.
    pub profile_shift: f64,
    /// Face width, m, if the description gives it.
    pub face_width: Option<f64>,
    /// Run-out: offset of the base circle from the axis of the shaft, m, with its angle in the shaft.
    pub runout: Complex64,
    /// Module, m, and pressure angle, rad, of the basic rack, if the description gives the module.
    pub(super) rack: Option<(f64, f64)>,
}

impl Gear {
    /// −1 for an internal gear, otherwise 1.
    pub fn sign(&self) -> f64 {
        if self.internal { -1.0 } else { 1.0 }
    }

    /// Base pitch 2πr/z, m.
    pub fn base_pitch(&self) -> f64 {
        2.0 * PI * self.base_radius / f64::from(self.teeth)
    }

    /// Transverse pressure angle α_t, rad: tan α_t = tan α_n/cos β.
    pub fn transverse_pressure_angle(&self) -> f64 {
        transverse_pressure_angle(self.pressure_angle, self.helix_angle)
    }

    /// Helix angle β_b on the base cylinder, rad: sin β_b = sin β cos α_n.
    pub fn base_helix_angle(&self) -> f64 {
        (self.helix_angle.sin() * self.pressure_angle.cos()).asin()
    }

    /// Length b tan β_b by which the contact moves along the path of contact over the face width b that this gear shares with
    /// another one, m; zero for spur gears and without a face width. Over the base pitch it is the overlap ratio
    /// ε_β = b sin β/(π m_n).
    pub fn overlap(&self, other: &Self) -> f64 {
        let width = self.face_width.zip(other.face_width).map_or(0.0, |(a, b)| a.min(b));
        if self.helix_angle == 0.0 { 0.0 } else { width * self.base_helix_angle().tan().abs() }
    }

    /// Half the angle of a tooth at the base circle without backlash, π/2z + 2x tan α_n/z ± inv α_t, rad, minus for internal
    /// gears.
    pub fn half_angle(&self) -> f64 {
        let (teeth, tan) = (f64::from(self.teeth), self.pressure_angle.tan());
        let transverse = self.transverse_pressure_angle();
        let involute = if self.helix_angle == 0.0 { tan } else { transverse.tan() };
        PI / (2.0 * teeth) + 2.0 * self.profile_shift * tan / teeth + self.sign() * (involute - transverse)
    }

    /// Length of the line of action between the base circle and the tip circle, √(tip radius² − base radius²), m.
    pub fn tip_reach(&self) -> f64 {
        (self.tip_radius.powi(2) - self.base_radius.powi(2)).sqrt()
    }

    /// Length of the line of action between the base circle and the root circle, m; zero if the root circle lies
    /// inside the base circle.
    pub fn root_reach(&self) -> f64 {
        (self.root_radius().powi(2) - self.base_radius.powi(2)).max(0.0).sqrt()
    }

    /// Tip radius r ± m (1 + x) of full-depth teeth, m; of an internal gear at least the base radius, within which its flanks
    /// have no involute.
    pub fn full_depth_tip_radius(&self) -> f64 {
        let tip = self.pitch_radius + self.sign() * self.module * (1.0 + self.profile_shift);
        if self.internal { tip.max(self.base_radius) } else { tip }
    }

    /// Root radius of full-depth teeth, m.
    pub fn root_radius(&self) -> f64 {
        self.pitch_radius - self.sign() * self.module * (STANDARD_DEDENDUM - self.profile_shift)
    }

    /// Radii of the body whose mass and inertias are the defaults: a disk of the reference circle, or the ring from the
    /// reference circle of an internal gear to its rim, m.
    pub(super) fn body_radii(&self) -> [f64; 2] {
        let rim = || self.root_radius() + STANDARD_RIM * self.module;
        if self.internal { [self.pitch_radius, rim()] } else { [0.0, self.pitch_radius] }
    }
}

/// Checks all gears.
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
    let pressure_angle =
        at.field("pressure_angle").positive(given.pressure_angle.unwrap_or(STANDARD_PRESSURE_ANGLE))?;
    if pressure_angle >= PI / 4.0 {
        let message = format!("must be below π/4 rad (is it in degrees?), got {pressure_angle}");
        return Err(at.field("pressure_angle").error(message));
    }
    let helix_angle = at.field("helix_angle").finite(given.helix_angle.unwrap_or(0.0))?;
    if helix_angle.abs() >= MAX_HELIX_ANGLE {
        let message = format!("must be between -π/3 and π/3 rad (is it in degrees?), got {helix_angle}");
        return Err(at.field("helix_angle").error(message));
    }
    let profile_shift = at.field("profile_shift").finite(given.profile_shift.unwrap_or(0.0))?;
    let module_given = optional(given.module, "module", at)?;
    if module_given.is_none() && profile_shift != 0.0 {
        let message = format!("{profile_shift} is a multiple of the module, which is not given; give module");
        return Err(at.field("profile_shift").error(message));
    }
    let transverse = transverse_pressure_angle(pressure_angle, helix_angle);
    let (module, base_radius) = module_and_base_radius(given, module_given, transverse, helix_angle.cos(), at)?;
    let pitch_radius = module / helix_angle.cos() * f64::from(given.teeth) / 2.0;
    let mut gear = Gear {
        body: Body {
            name: given.name.clone(),
            node: names.node(shafts, &given.shaft, given.position, at)?,
            ..Body::default()
        },
        teeth: given.teeth,
        internal: given.internal,
        base_radius,
        pitch_radius,
        tip_radius: 0.0,
        module,
        pressure_angle,
        helix_angle,
        profile_shift,
        face_width: optional(given.face_width, "face_width", at)?,
        rack: module_given.map(|module| (module, pressure_angle)),
        runout: complex(given.runout, &at.field("runout"))?,
    };
    gear.tip_radius = optional(given.tip_radius, "tip_radius", at)?.unwrap_or(gear.full_depth_tip_radius());
    let (tip_radius, root_radius) = (gear.tip_radius, gear.root_radius());
    let problem = if gear.internal {
        let inside =
            || format!("{tip_radius} m is inside the base circle of {base_radius} m, where flanks have no involute");
        let outside = || format!("{tip_radius} m leaves no tooth inside the root radius of {root_radius} m");
        if tip_radius < base_radius { Some(inside()) } else { (tip_radius >= root_radius).then(outside) }
    } else {
        (tip_radius <= base_radius)
            .then(|| format!("{tip_radius} m leaves no tooth above the base radius of {base_radius} m"))
    };
    if let Some(message) = problem {
        return Err(at.field("tip_radius").error(message));
    }
    set_body(&mut gear, given, at)?;
    Ok(gear)
}

fn optional(value: Option<f64>, name: &str, at: &EntryPath) -> Result<Option<f64>, SceneError> {
    value.map(|value| at.field(name).positive(value)).transpose()
}

/// Transverse pressure angle, rad, of a gear with the pressure angle `normal` in the normal section, rad.
fn transverse_pressure_angle(normal: f64, helix_angle: f64) -> f64 {
    if helix_angle == 0.0 { normal } else { (normal.tan() / helix_angle.cos()).atan() }
}

/// Normal module and base radius, m, with the transverse pressure angle, rad, and the cosine of the helix angle. If the
/// description gives both, they must agree.
fn module_and_base_radius(
    given: &description::Gear,
    module: Option<f64>,
    pressure_angle: f64,
    helix_cosine: f64,
    at: &EntryPath,
) -> Result<(f64, f64), SceneError> {
    let teeth = f64::from(given.teeth);
    match (module, optional(given.base_radius, "base_radius", at)?) {
        (Some(module), Some(base)) => {
            let expected = module / helix_cosine * teeth / 2.0 * pressure_angle.cos();
            if (base - expected).abs() > PUBLISHED_DATA_TOLERANCE * expected {
                let message =
                    format!("{base} m is not the base radius of this module and pressure angle, {expected} m");
                return Err(at.field("base_radius").error(message));
            }
            Ok((module, base))
        }
        (Some(module), None) => Ok((module, module / helix_cosine * teeth / 2.0 * pressure_angle.cos())),
        (None, Some(base)) => Ok((2.0 * base / (teeth * pressure_angle.cos()) * helix_cosine, base)),
        (None, None) => Err(at.error("needs module or base_radius")),
    }
}

/// Sets mass, inertias and unbalance of a gear. Missing mass and inertia are those of a solid steel disk with the pitch radius,
/// of an internal gear those of a steel ring.
fn set_body(gear: &mut Gear, given: &description::Gear, at: &EntryPath) -> Result<(), SceneError> {
    let needs_width = |name: &str| at.error(format!("needs face_width, or {name}"));
    let [inner, outer] = gear.body_radii().map(|radius| radius * radius);
    let (area, square) = (outer - inner, outer + inner);
    let mass = match (given.mass, gear.face_width) {
        (Some(mass), _) => at.field("mass").non_negative(mass)?,
        (None, Some(width)) => STEEL.density * PI * area * width,
        (None, None) => return Err(needs_width("mass")),
    };
    let diametral_inertia = match (given.diametral_inertia, gear.face_width) {
        (Some(inertia), _) => at.field("diametral_inertia").non_negative(inertia)?,
        (None, Some(width)) => mass * (3.0 * square + width * width) / 12.0,
        (None, None) => return Err(needs_width("diametral_inertia")),
    };
    let polar_inertia = match given.polar_inertia {
        Some(inertia) => at.field("polar_inertia").non_negative(inertia)?,
        None => mass * square / 2.0,
    };
    let unbalance = complex(given.unbalance, &at.field("unbalance"))?;
    gear.body = Body { mass, diametral_inertia, polar_inertia, unbalance, ..gear.body.clone() };
    Ok(())
}
