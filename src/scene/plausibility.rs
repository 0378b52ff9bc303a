//! One check of the whole scene for values that no machine has, which are mostly mistakes of units.
//!
//! Every range reaches from watches to turbogenerators, hydroelectric sets and shaft lines of ships, and further where
//! models idealise. A value outside is a warning with the usual range and the probable cause; what is physically
//! impossible is an error. `docs/using.md` lists the ranges with the reason for each.

use std::f64::consts::{PI, TAU};

use super::description::{self, SceneDescription};
use super::{BearingCoefficient, Body, Damping, EntryPath, Gear, Scene, SceneError, Shaft};

/// Standard gravity, m/s².
const GRAVITY: f64 = 9.806_65;
/// Published inertias are rounded; beyond this part I_p > 2 I_d is a mistake.
const INERTIA_TOLERANCE: f64 = 0.05;
/// An angle of a whole turn, with round-off.
const TURN: f64 = TAU * (1.0 + 1e-9);
/// Largest pitch-line speed, m/s. Turbo gears reach 200 m/s (AGMA 6011 covers those above 35 m/s).
const PITCH_LINE_SPEED: f64 = 250.0;

/// The range of a quantity in built machines.
struct Usual {
    quantity: &'static str,
    unit: &'static str,
    low: f64,
    high: f64,
    /// The probable cause of a value above the range.
    above: &'static str,
    /// The probable cause of a value below the range.
    below: &'static str,
}

const METRES: &str = "is it in millimetres?";
const UNIT: &str = "is it in another unit?";
const DEGREES: &str = "is it in degrees?";
const PERCENT: &str = "is it in percent?";

const fn usual(quantity: &'static str, unit: &'static str, low: f64, high: f64, above: &'static str) -> Usual {
    Usual { quantity, unit, low, high, above, below: UNIT }
}

/// Watch arbors have 2 mm, shaft lines of ships 100 m.
const LENGTH: Usual = usual("the length of a shaft", "m", 1e-3, 150.0, METRES);
/// Watch pivots have 0.07 mm, hydroelectric shafts 3 m.
const DIAMETER: Usual = usual("the diameter of a shaft", "m", 5e-5, 5.0, METRES);
/// Length over diameter: flat hubs; long shafts that need more bearings than two.
const SLENDERNESS: Usual = usual("length over diameter of a shaft", "", 0.3, 200.0, "are both in the same unit?");
/// Polyethylene has 0.2 GPa, diamond 1.2 TPa.
const MODULUS: Usual =
    Usual { below: "is it in MPa or GPa?", ..usual("the elastic modulus of a solid", "Pa", 1e8, 1.3e12, UNIT) };
/// Half the range of Young's modulus: G = E/2(1 + ν).
const SHEAR_MODULUS: Usual = Usual { quantity: "the shear modulus of a solid", low: 3e7, high: 6e11, ..MODULUS };
/// Foams have 100 kg/m³, osmium 22 600 kg/m³.
const DENSITY: Usual =
    Usual { below: "is it in g/cm3 or t/mm3?", ..usual("the density of a solid", "kg/m3", 100.0, 23e3, UNIT) };
/// Between supports, over the radius. Flexible rotors of test rigs reach 0.2.
const SAG: Usual = usual(
    "the deflection of a shaft under its weight, over its radius,",
    "",
    0.0,
    0.5,
    "are lengths, modulus, density and masses in SI units?",
);
/// Watch wheels have 0.05 mm, jack-up rigs and ship lifts 100 mm.
const MODULE: Usual = usual("the module of a gear", "m", 3e-5, 0.15, METRES);
/// Face width over reference diameter: thin wheels of instruments; long pinions.
const FACE_WIDTH: Usual = usual("face width over reference diameter", "", 2e-3, 20.0, METRES);
/// ISO 21771 and DIN 3992 go from −0.5 to 1; few teeth and wide centres need more.
const PROFILE_SHIFT: Usual =
    Usual { below: METRES, ..usual("the profile shift coefficient", "", -1.5, 2.5, "is it a length in millimetres?") };
/// 14.5° to 28° are in use, 8° in instruments; 45° is an error.
const PRESSURE_ANGLE: Usual = usual("the pressure angle", "rad", 0.14, 0.8, DEGREES);
/// Tip above the reference circle in modules: 0.8 to 1.35, and the profile shift.
const ADDENDUM: Usual = usual("the addendum in modules", "", -1.5, 4.0, METRES);
/// A solid wheel of steel has 7850 kg/m³; with spokes less, with a hub, a coupling or a flywheel more.
const GEAR_DENSITY: Usual = usual(
    "mass of a gear over the volume of its reference cylinder",
    "kg/m3",
    20.0,
    1e5,
    "are mass and sizes in SI units?",
);
/// A solid disk has 0.71, a rim 1.
const GEAR_GYRATION: Usual =
    usual("radius of gyration of a gear over its reference radius", "", 0.05, 5.0, "is the inertia in kg m2?");
/// A solid disk has 0.35 of its diameter; hydroelectric rotors have 16 m.
const GYRATION: Usual = usual("the radius of gyration of a body", "m", 1e-4, 10.0, "is the inertia in kg m2?");
/// Watch wheels have 10 mg, hydroelectric rotors 2000 t.
const MASS: Usual = usual("the mass of a body", "kg", 1e-7, 3e6, "is it in grams?");
/// Mass times eccentricity over the masses of body and shaft, over the radius of the shaft. ISO 21940-11 allows 1e-6 m to
/// 1e-3 m of eccentricity.
const ECCENTRICITY: Usual = usual(
    "eccentricity (unbalance over mass) over the radius of the shaft",
    "",
    0.0,
    0.25,
    "an unbalance is in kg m; is it in g mm?",
);
/// Straightening removes what is above 1e-3.
const BOW: Usual = usual("bow over length of a shaft", "", 0.0, 0.05, METRES);
/// Eccentric gears have run-outs of 0.05 modules at most.
const RUN_OUT: Usual = usual("run-out in modules", "", 0.0, 0.5, METRES);
/// ISO/TR 10064-2 recommends 0.03 to 0.1 modules.
const BACKLASH: Usual = usual("backlash in modules", "", 0.0, 1.0, METRES);
/// ISO 21771 and common practice: 0.01 to 0.02 modules.
const RELIEF: Usual = usual("tip relief in modules", "", 0.0, 0.3, "is it in millimetres or micrometres?");
/// Relief reaches over part of the path of contact, which is shorter than six modules.
const RELIEF_LENGTH: Usual = usual("length of tip relief in modules", "", 0.0, 10.0, METRES);
/// ISO 1328-1, class 12: 0.05 modules.
const ERROR: Usual = usual("transmission error in modules", "", 0.0, 0.5, "is it in millimetres or micrometres?");
/// Working centres differ from reference centres by the profile shifts, a few modules at most.
const CENTRE_DISTANCE: Usual = usual("centre distance over the sum of the reference radii", "", 0.9, 1.25, METRES);
/// A tip beyond the axis of the other gear runs through its shaft.
const TIP_REACH: Usual = usual("tip radius over centre distance", "", 0.0, 1.0, METRES);
/// ISO 6336-1 gives 1.4e10 N/m² for steel; polymer gears have 1 % of it. Steel in N/mm would have 2e7.
const MESH_STIFFNESS: Usual = Usual {
    below: "is it in N/mm?",
    ..usual("mesh stiffness over face width (ten modules where none is given)", "N/m2", 5e7, 3e11, UNIT)
};
/// Measured: 0.03 to 0.17.
const MESH_DAMPING: Usual = usual("the damping ratio of a mesh", "", 0.0, 1.0, PERCENT);
/// Steel rotors have 0.001 to 0.02; squeeze films reach 0.3.
const MODAL_DAMPING: Usual = usual("a modal damping ratio", "", 0.0, 0.5, PERCENT);
/// Shear strain at the surface: steel yields at 0.01, polymers at 0.05.
const TORSION: Usual = usual("shear strain that a torque makes in its shaft", "", 0.0, 0.05, "is it in N mm?");
/// The largest planets have 25 m/s²; more is for rotors in centrifuges and for loads that are described by gravity.
const WEIGHT: Usual = usual("gravity", "m/s2", 0.0, 5e3, "is it in mm/s2?");
/// The stiffest bearings are rigid in all but name.
const BEARING: Usual = usual("the stiffness of a bearing", "N/m", 0.0, 1e14, UNIT);
/// Of a bearing beside that of its shaft; below it and below [`SETTLING`] it is a slip.
const SOFT: f64 = 0.01;
/// Part of the radius by which the bearings yield to the weight.
const SETTLING: f64 = 0.01;

/// What is wrong of one quantity.
struct Finding {
    quantity: &'static str,
    message: String,
    /// The places at which it is wrong; the message speaks of the first.
    places: Vec<String>,
}

/// Warnings, one for each quantity, and for each place at most one.
#[derive(Default)]
struct Findings(Vec<Finding>);

impl Findings {
    /// Warns of a value outside its range.
    fn judge(&mut self, at: &EntryPath, value: f64, usual: &Usual) {
        if value >= usual.low && value <= usual.high {
            return;
        }
        let cause = if value > usual.high { usual.above } else { usual.below };
        let Usual { quantity, unit, low, high, .. } = usual;
        let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
        let range = if *low == 0.0 {
            format!("up to {}{unit}", short(*high))
        } else {
            format!("{} to {}{unit}", short(*low), short(*high))
        };
        self.add(quantity, at, &format!("{quantity} is {}{unit}, usual is {range}; {cause}", short(value)));
    }

    /// Warns of an angle beyond a turn.
    fn angle(&mut self, at: &EntryPath, angle: f64) {
        if angle.abs() > TURN {
            self.add("angle", at, &format!("{} rad is more than a turn, 2π = 6.283 rad; {DEGREES}", short(angle)));
        }
    }

    fn add(&mut self, quantity: &'static str, at: &EntryPath, message: &str) {
        let place = at.to_string();
        if self.0.iter().any(|finding| finding.places.contains(&place)) {
            return;
        }
        match self.0.iter_mut().find(|finding| finding.quantity == quantity) {
            Some(finding) => finding.places.push(place),
            None => self.0.push(Finding { quantity, message: format!("{at}: {message}"), places: vec![place] }),
        }
    }

    fn messages(self) -> impl Iterator<Item = String> {
        self.0.into_iter().map(|Finding { message, places, .. }| match &places[1..] {
            [] => message,
            further => format!("{message} (the same of {})", further.join(", ")),
        })
    }
}

/// Warns of what is implausible.
///
/// # Errors
/// [`SceneError`] for what is physically impossible.
pub(super) fn check(system: &SceneDescription, scene: &Scene) -> Result<Vec<String>, SceneError> {
    let mut found = Findings::default();
    for (index, (given, shaft)) in system.shafts.iter().zip(&scene.shafts).enumerate() {
        check_shaft(given, shaft, &EntryPath::entry("shafts", index), &mut found)?;
    }
    for (index, (given, gear)) in system.gears.iter().zip(&scene.gears).enumerate() {
        check_gear(given, gear, &EntryPath::entry("gears", index), &mut found);
    }
    let gears = scene.gears.iter().map(|gear| &gear.body).enumerate().map(|entry| ("gears", entry));
    let disks = scene.disks.iter().enumerate().map(|entry| ("disks", entry));
    for (list, (index, body)) in gears.chain(disks) {
        check_body(scene, body, &EntryPath::entry(list, index), &mut found)?;
    }
    for (index, given) in system.meshes.iter().enumerate() {
        check_mesh(scene, given, index, &mut found);
    }
    for (index, bearing) in scene.bearings.iter().enumerate() {
        let at = EntryPath::entry("bearings", index).field("stiffness");
        found.judge(&at, stiffest(&bearing.stiffness), &BEARING);
    }
    for (index, torque) in scene.torques.iter().enumerate() {
        let (shaft, node) = (&scene.shafts[torque.node.shaft], torque.node.node);
        let strain = 2.0 * torque.value.abs() / (PI * shaft.radius_at(node).powi(3) * shaft.material.shear_modulus);
        found.judge(&EntryPath::entry("torques", index), strain, &TORSION);
    }
    if scene.lateral {
        (0..scene.shafts.len()).for_each(|shaft| check_supports(scene, shaft, &mut found));
    }
    found.judge(&EntryPath::root("modal_damping"), scene.modal_damping, &MODAL_DAMPING);
    found.judge(&EntryPath::root("gravity"), scene.gravity[0].hypot(scene.gravity[1]), &WEIGHT);
    Ok(found.messages().collect())
}

fn check_shaft(
    given: &description::Shaft,
    shaft: &Shaft,
    at: &EntryPath,
    found: &mut Findings,
) -> Result<(), SceneError> {
    let (length, diameter) = (shaft.length(), 2.0 * largest_radius(shaft));
    let place = |field: &str| if given.segments.is_some() { at.field("segments") } else { at.field(field) };
    found.judge(&place("length"), length, &LENGTH);
    found.judge(&place("outer_diameter"), diameter, &DIAMETER);
    found.judge(&place("length"), length / diameter, &SLENDERNESS);
    let material = at.field("material");
    found.judge(&material.field("youngs_modulus"), shaft.material.youngs_modulus, &MODULUS);
    if !is_massless(shaft.material.density) {
        found.judge(&material.field("density"), shaft.material.density, &DENSITY);
    }
    if given.material.is_some_and(|material| material.shear_modulus.is_some()) {
        found.judge(&material.field("shear_modulus"), shaft.material.shear_modulus, &SHEAR_MODULUS);
    }
    let Some(bow) = &given.bow else { return Ok(()) };
    let at = at.field("bow");
    let one = bow.amplitude.map(|amplitude| (at.field("amplitude"), amplitude.abs()));
    let list = bow.amplitudes.iter().flatten().map(|value| value.abs()).reduce(f64::max);
    for (at, amplitude) in one.into_iter().chain(list.map(|amplitude| (at.field("amplitudes"), amplitude))) {
        if amplitude > length {
            return Err(at.error(format!("{amplitude} m is more than the length of the shaft, {length} m; {METRES}")));
        }
        found.judge(&at, amplitude / length, &BOW);
    }
    bow.phase.iter().for_each(|phase| found.angle(&at.field("phase"), *phase));
    bow.phases.iter().flatten().enumerate().for_each(|(i, phase)| found.angle(&at.field("phases").index(i), *phase));
    Ok(())
}

/// Whether a density stands for a shaft without mass, such as that of a Jeffcott rotor: a small one that is no solid's in
/// kg/mm³ or t/mm³. In g/cm³ all that are heavier than water are above 1.
fn is_massless(density: f64) -> bool {
    density <= 1.0 && ![1e-9, 1e-12].iter().any(|unit| (DENSITY.low * unit..DENSITY.high * unit).contains(&density))
}

fn check_gear(given: &description::Gear, gear: &Gear, at: &EntryPath, found: &mut Findings) {
    let size = if given.module.is_some() { "module" } else { "base_radius" };
    found.judge(&at.field(size), gear.module, &MODULE);
    found.judge(&at.field("pressure_angle"), gear.pressure_angle, &PRESSURE_ANGLE);
    found.judge(&at.field("profile_shift"), gear.profile_shift, &PROFILE_SHIFT);
    if given.tip_radius.is_some() {
        found.judge(&at.field("tip_radius"), (gear.tip_radius - gear.pitch_radius) / gear.module, &ADDENDUM);
    }
    found.judge(&at.field("run_out"), gear.run_out.norm() / gear.module, &RUN_OUT);
    if let Some(width) = gear.face_width {
        found.judge(&at.field("face_width"), width / (2.0 * gear.pitch_radius), &FACE_WIDTH);
        let volume = PI * gear.pitch_radius.powi(2) * width;
        if given.mass.is_some_and(|mass| mass > 0.0) {
            found.judge(&at.field("mass"), gear.body.mass / volume, &GEAR_DENSITY);
        }
    }
    if given.polar_inertia.is_some_and(|inertia| inertia > 0.0) && gear.body.mass > 0.0 {
        let gyration = (gear.body.polar_inertia / gear.body.mass).sqrt();
        found.judge(&at.field("polar_inertia"), gyration / gear.pitch_radius, &GEAR_GYRATION);
    }
}

fn check_body(scene: &Scene, body: &Body, at: &EntryPath, found: &mut Findings) -> Result<(), SceneError> {
    // A diametral inertia of zero is an idealisation, and in torsion alone it plays no part.
    let (polar, diametral) = (body.polar_inertia, body.diametral_inertia);
    if scene.lateral && diametral > 0.0 && polar > 2.0 * diametral * (1.0 + INERTIA_TOLERANCE) {
        return Err(at.field("polar_inertia").error(format!(
            "{polar} kg m2 is more than twice the diametral inertia, {diametral} kg m2, and no rigid body has that; are the two exchanged?"
        )));
    }
    if body.mass > 0.0 {
        found.judge(&at.field("mass"), body.mass, &MASS);
        if polar > 0.0 {
            found.judge(&at.field("polar_inertia"), (polar / body.mass).sqrt(), &GYRATION);
        }
    }
    let radius = scene.shafts[body.node.shaft].radius_at(body.node.node);
    found.judge(&at.field("unbalance"), eccentricity(scene, body) / radius, &ECCENTRICITY);
    Ok(())
}

fn check_mesh(scene: &Scene, given: &description::Mesh, index: usize, found: &mut Findings) {
    let (at, mesh) = (EntryPath::entry("meshes", index), &scene.meshes[index]);
    let pair = [&scene.gears[mesh.driver], &scene.gears[mesh.driven]];
    let module = pair[0].module.max(pair[1].module);
    let width = pair.iter().map(|gear| gear.face_width.unwrap_or(10.0 * gear.module)).fold(f64::INFINITY, f64::min);
    found.angle(&at.field("centre_line_angle"), mesh.centre_line_angle);
    let radii = pair[0].pitch_radius + pair[1].pitch_radius;
    found.judge(&at.field("centre_distance"), mesh.centre_distance / radii, &CENTRE_DISTANCE);
    for (gear, index) in pair.iter().zip([mesh.driver, mesh.driven]) {
        let at = EntryPath::entry("gears", index).field("tip_radius");
        found.judge(&at, gear.tip_radius / mesh.centre_distance, &TIP_REACH);
    }
    let place = at.field("stiffness");
    match &given.stiffness {
        None => {}
        Some(description::Stiffness::Mean(mean)) => found.judge(&place, mean / width, &MESH_STIFFNESS),
        Some(description::Stiffness::Model(model)) => {
            let highest = model.values.iter().flatten().copied().reduce(f64::max);
            for (name, value) in [("mean", model.mean), ("pair", model.pair), ("values", highest)] {
                value.iter().for_each(|value| found.judge(&place.field(name), value / width, &MESH_STIFFNESS));
            }
            let phases = model.phases.iter().flatten().enumerate();
            phases.for_each(|(i, phase)| found.angle(&place.field("phases").index(i), *phase));
        }
    }
    if let Damping::Ratio(ratio) = mesh.damping {
        found.judge(&at.field("damping_ratio"), ratio, &MESH_DAMPING);
    }
    found.judge(&at.field("backlash"), mesh.teeth.backlash.unwrap_or(0.0) / module, &BACKLASH);
    if let Some(relief) = &mesh.teeth.relief {
        let at = at.field("tip_relief");
        found.judge(&at.field("amount"), relief.amount / module, &RELIEF);
        found.judge(&at.field("length"), relief.length / module, &RELIEF_LENGTH);
    }
    if let Some(error) = &mesh.teeth.error {
        let at = at.field("error");
        for (name, list) in [("tooth", &error.tooth), ("driver", &error.driver), ("driven", &error.driven)] {
            for (i, [amplitude, phase]) in list.iter().enumerate() {
                found.judge(&at.field(name).index(i), amplitude.abs() / module, &ERROR);
                found.angle(&at.field(name).index(i), *phase);
            }
        }
        let largest = error.table.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
        found.judge(&at.field("table"), largest / module, &ERROR);
    }
}

/// Deflection of a shaft and of its bearings under its weight, with the bodies on it spread over its length.
fn check_supports(scene: &Scene, shaft: usize, found: &mut Findings) {
    let bearings: Vec<_> =
        scene.bearings.iter().enumerate().filter(|(_, bearing)| bearing.node.shaft == shaft).collect();
    let at = EntryPath::entry("shafts", shaft);
    let shape = &scene.shafts[shaft];
    let mut supports: Vec<f64> = bearings.iter().map(|(_, bearing)| shape.nodes[bearing.node.node]).collect();
    supports.sort_by(f64::total_cmp);
    let span = supports.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
    if span == 0.0 {
        return;
    }
    let weight = GRAVITY * mass_on(scene, shaft);
    let length = shape.length();
    // Mean compliance of the sections; 5qs⁴/384EI of a beam on two supports.
    let compliance: f64 = shape.elements.iter().map(|element| element.length / second_moment(element)).sum();
    let compliance = compliance / (length * shape.material.youngs_modulus);
    let radius = largest_radius(shape);
    found.judge(&at, 5.0 / 384.0 * weight / length * span.powi(4) * compliance / radius, &SAG);
    let total: f64 = bearings.iter().map(|(_, bearing)| stiffest(&bearing.stiffness)).sum();
    let settling = weight / total / radius;
    let own = 48.0 / (compliance * span.powi(3));
    for (index, bearing) in bearings {
        let stiffness = stiffest(&bearing.stiffness);
        if stiffness > 0.0 && stiffness < SOFT * own && settling > SETTLING {
            let message = format!(
                "{} N/m is {} % of the stiffness of the shaft, and lets its weight move it by {} % of its radius; is it in N/mm?",
                short(stiffness),
                short(100.0 * stiffness / own),
                short(100.0 * settling)
            );
            found.add("bearing", &EntryPath::entry("bearings", index).field("stiffness"), &message);
        }
    }
}

/// Unbalance over the masses of the body and of its shaft, m.
pub(crate) fn eccentricity(scene: &Scene, body: &Body) -> f64 {
    if body.unbalance.norm() == 0.0 { 0.0 } else { body.unbalance.norm() / mass_on(scene, body.node.shaft) }
}

/// Whether an unbalance is so large that it is a mistake.
pub(crate) fn implausible_unbalance(scene: &Scene, body: &Body) -> bool {
    let radius = scene.shafts[body.node.shaft].radius_at(body.node.node);
    eccentricity(scene, body) > ECCENTRICITY.high * radius
}

impl Scene {
    /// Says that teeth move faster than those of any machine at this speed of the reference shaft, rad/s, if they do.
    pub fn pitch_line_warning(&self, speed: f64) -> Option<String> {
        let of = |gear: &Gear| (self.speed_ratios[gear.body.node.shaft] * speed * gear.pitch_radius).abs();
        let (name, fastest) =
            self.gears.iter().map(|gear| (&gear.body.name, of(gear))).max_by(|a, b| a.1.total_cmp(&b.1))?;
        (fastest > PITCH_LINE_SPEED).then(|| {
            format!(
                "speed: the pitch-line speed of \"{name}\" is {} m/s at {} rad/s, usual is up to {PITCH_LINE_SPEED} m/s; is the speed in rpm?",
                short(fastest),
                short(speed)
            )
        })
    }
}

fn mass_on(scene: &Scene, shaft: usize) -> f64 {
    let own = &scene.shafts[shaft];
    let volume: f64 = own
        .elements
        .iter()
        .map(|element| PI * (element.outer_radius.powi(2) - element.inner_radius.powi(2)) * element.length)
        .sum();
    let bodies: f64 = scene.bodies().filter(|body| body.node.shaft == shaft).map(|body| body.mass).sum();
    own.material.density * volume + bodies
}

fn largest_radius(shaft: &Shaft) -> f64 {
    shaft.elements.iter().map(|element| element.outer_radius).fold(0.0, f64::max)
}

fn second_moment(element: &super::Element) -> f64 {
    PI / 4.0 * (element.outer_radius.powi(4) - element.inner_radius.powi(4))
}

/// The largest stiffness along y or z, at any speed.
fn stiffest(stiffness: &BearingCoefficient) -> f64 {
    stiffness.extremes().iter().map(|stiffness| stiffness[0][0].max(stiffness[1][1])).fold(0.0, f64::max)
}

/// Four digits of a number.
fn short(value: f64) -> String {
    if value == 0.0 || (1e-3..1e6).contains(&value.abs()) {
        let digits = (3.0 - value.abs().max(1e-3).log10().floor()).clamp(0.0, 6.0) as usize;
        let text = format!("{value:.digits$}");
        if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
    } else {
        let text = format!("{value:.3e}");
        let (digits, exponent) = text.split_once('e').unwrap_or((&text, "0"));
        format!("{}e{exponent}", digits.trim_end_matches('0').trim_end_matches('.'))
    }
}
