//! Plausibility check of a whole scene. It finds values that no built machine has; most of them are mistakes of units.
//!
//! The ranges cover watches, turbogenerators, hydroelectric sets and ship shaft lines, and idealised models. A value
//! outside its range gives a warning with the usual range and the probable cause. A physically impossible value is an
//! error. `docs/using.md` lists the ranges and the reason for each.

mod findings;
mod ranges;

use std::f64::consts::PI;

use super::description::{self, SceneDescription, SleeveStiffness, SleeveStiffnessWord};
use super::gear::PUBLISHED_DATA_TOLERANCE;
use super::number::short;
use super::{
    Bearing, BearingCoefficient, Body, Bow, BowCurve, Damping, EntryPath, Gear, Journal, Node, Nonlinear,
    STANDARD_GRAVITY, Scene, SceneError, Shaft,
};
use findings::Findings;
use ranges::{
    ASK_MILLIMETRES, AXIAL_PRELOAD, BEARING_STIFFNESS, BODY_ECCENTRICITY, BODY_GYRATION, BODY_MASS, CENTRE_DISTANCE,
    FACE_WIDTH, FLANK_ROUGHNESS, GEAR_ADDENDUM, GEAR_DENSITY, GEAR_GYRATION, GEAR_MODULE, GEAR_RUNOUT, GRAVITY,
    JOURNAL_CLEARANCE, LOAD_RATING, LOSS_FACTOR, MESH_BACKLASH, MESH_DAMPING, MESH_FRICTION, MESH_STIFFNESS,
    MODAL_DAMPING, OIL_VISCOSITY, PITCH_LINE_SPEED, PRESSURE_ANGLE, PROFILE_SHIFT, RELIEF_LENGTH, ROLLING_CLEARANCE,
    SHAFT_BOW, SHAFT_DIAMETER, SHAFT_LENGTH, SHAFT_SAG, SHAFT_SLENDERNESS, SHAFT_TORSION, SHEAR_MODULUS, SOLID_DENSITY,
    TIP_REACH, TIP_RELIEF, TRANSMISSION_ERROR, YOUNGS_MODULUS,
};

/// Largest plausible deflection of a bow at the end of a shaft beyond the points, relative to the largest amplitude.
const MAX_EXTRAPOLATED_BOW: f64 = 0.5;

/// Smallest plausible stiffness of a bearing relative to that of its shaft. Smaller values give a warning if the
/// displacement under the weight also exceeds [`MAX_SETTLING`].
const MIN_RELATIVE_STIFFNESS: f64 = 0.01;
/// Largest plausible displacement of the bearings under the weight of the shaft, relative to its radius.
const MAX_SETTLING: f64 = 0.01;

/// Returns a warning for each implausible quantity.
///
/// # Errors
/// [`SceneError`] for a physically impossible value.
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
    for (index, sleeve) in system.sleeves.iter().enumerate() {
        let at = EntryPath::entry("sleeves", index);
        found.check(&at.field("outer_diameter"), sleeve.outer_diameter, &SHAFT_DIAMETER);
        // A sleeve without stiffness may have any modulus.
        let stiff = sleeve.stiffness.is_some_and(|given| given != SleeveStiffness::Word(SleeveStiffnessWord::None));
        match &sleeve.material {
            Some(given) if !stiff => {
                found.check(&at.field("material").field("density"), given.density, &SOLID_DENSITY);
            }
            given => check_material(given.as_ref(), &at.field("material"), &mut found),
        }
    }
    for (index, given) in system.meshes.iter().enumerate() {
        check_mesh(scene, given, index, &mut found);
    }
    for (index, bearing) in scene.bearings.iter().enumerate() {
        let at = EntryPath::entry("bearings", index);
        match &bearing.nonlinear {
            None => found.check(&at.field("stiffness"), largest_stiffness(&bearing.stiffness), &BEARING_STIFFNESS),
            Some(Nonlinear::Journal(journal)) => check_film(journal, &at, &mut found),
            Some(Nonlinear::Rolling(rolling)) => {
                let diameter = system.bearings[index].element_diameter.unwrap_or(f64::INFINITY);
                found.check(&at.field("clearance"), rolling.clearance.abs() / diameter, &ROLLING_CLEARANCE);
                let area = f64::from(rolling.elements) * (rolling.diameter_ratio * rolling.pitch_diameter).powi(2);
                let preload = rolling.axial_preload.unwrap_or(0.0);
                found.check(&at.field("axial_preload"), preload.abs() / area, &AXIAL_PRELOAD);
            }
        }
    }
    for (squeeze, name) in scene.housings.iter().filter_map(|housing| Some((housing.squeeze.as_ref()?, &housing.name)))
    {
        check_film(&squeeze.journal, &EntryPath::root(name), &mut found);
    }
    for (index, given) in system.bearings.iter().enumerate() {
        let (at, node) = (EntryPath::entry("bearings", index), scene.bearings[index].node);
        let shaft = &scene.shafts[node.shaft];
        let diameter = 2.0 * shaft.radius_at(node.node);
        for (name, rating) in [("dynamic_rating", given.dynamic_rating), ("static_rating", given.static_rating)] {
            if let Some(rating) = rating {
                found.check(&at.field(name), rating / diameter.powi(2), &LOAD_RATING);
            }
        }
    }
    for (index, torque) in scene.torques.iter().enumerate() {
        let (shaft, node) = (&scene.shafts[torque.node.shaft], torque.node.node);
        let modulus = shaft.elements[node.min(shaft.elements.len() - 1)].body.material.shear_modulus;
        let strain = 2.0 * torque.value.abs() / (PI * shaft.radius_at(node).powi(3) * modulus);
        found.check(&EntryPath::entry("torques", index), strain, &SHAFT_TORSION);
    }
    if scene.lateral {
        for shaft in 0..scene.shafts.len() {
            check_tilting(scene, shaft, &mut found);
            check_supports(scene, shaft, &mut found);
        }
    }
    found.check(&EntryPath::root("modal_damping"), scene.modal_damping.largest(), &MODAL_DAMPING);
    found.check(&EntryPath::root("gravity"), scene.gravity[0].hypot(scene.gravity[1]), &GRAVITY);
    Ok(found.messages().collect())
}

fn check_film(film: &Journal, at: &EntryPath, found: &mut Findings) {
    found.check(&at.field("clearance"), 2.0 * film.clearance / film.diameter, &JOURNAL_CLEARANCE);
    found.check(&at.field("viscosity"), film.viscosity, &OIL_VISCOSITY);
}

fn check_shaft(
    given: &description::Shaft,
    shaft: &Shaft,
    at: &EntryPath,
    found: &mut Findings,
) -> Result<(), SceneError> {
    let (length, diameter) = (shaft.length(), 2.0 * largest_radius(shaft));
    let place = |field: &'static str| if given.segments.is_some() { at.field("segments") } else { at.field(field) };
    found.check(&place("length"), length, &SHAFT_LENGTH);
    found.check(&place("outer_diameter"), diameter, &SHAFT_DIAMETER);
    found.check(&place("length"), length / diameter, &SHAFT_SLENDERNESS);
    found.check(&at.field("loss_factor"), shaft.loss_factor, &LOSS_FACTOR);
    check_material(given.material.as_ref(), &at.field("material"), found);
    for (index, segment) in given.segments.iter().flatten().enumerate() {
        check_material(segment.material.as_ref(), &at.field("segments").index(index).field("material"), found);
    }
    let Some(bow) = &given.bow else { return Ok(()) };
    let at = at.field("bow");
    let one = bow.amplitude.map(|amplitude| (at.field("amplitude"), amplitude.abs()));
    let list = bow.amplitudes.iter().flatten().map(|value| value.abs()).reduce(f64::max);
    for (at, amplitude) in one.into_iter().chain(list.map(|amplitude| (at.field("amplitudes"), amplitude))) {
        if amplitude > length {
            return Err(
                at.error(format!("{amplitude} m is more than the length of the shaft, {length} m; {ASK_MILLIMETRES}"))
            );
        }
        found.check(&at, amplitude / length, &SHAFT_BOW);
    }
    bow.phase.iter().for_each(|phase| found.check_angle(&at.field("phase"), *phase));
    bow.phases
        .iter()
        .flatten()
        .enumerate()
        .for_each(|(i, phase)| found.check_angle(&at.field("phases").index(i), *phase));
    check_extrapolation(shaft, list.unwrap_or(0.0), &at, found);
    Ok(())
}

/// Checks a material that the description gives; the default is plausible.
fn check_material(given: Option<&description::Material>, at: &EntryPath, found: &mut Findings) {
    let Some(material) = given else { return };
    found.check(&at.field("youngs_modulus"), material.youngs_modulus, &YOUNGS_MODULUS);
    if !is_massless(material.density) {
        found.check(&at.field("density"), material.density, &SOLID_DENSITY);
    }
    if let Some(modulus) = material.shear_modulus {
        found.check(&at.field("shear_modulus"), modulus, &SHEAR_MODULUS);
    }
}

/// Warns of a bow whose points end before the shaft does, if the straight extrapolation is large compared with the points.
fn check_extrapolation(shaft: &Shaft, largest: f64, at: &EntryPath, found: &mut Findings) {
    let Some(Bow::Curve(BowCurve::Points(spline))) = &shaft.bow else { return };
    let [first, last] = spline.range();
    for (end, measured) in [(0.0, first), (shaft.length(), last)] {
        let deflection = spline.at(end).0.norm();
        if (end - measured).abs() > 1e-9 * shaft.length() && deflection > MAX_EXTRAPOLATED_BOW * largest {
            found.add(
                "extrapolated bow",
                &at.field("positions"),
                &format!(
                    "the points end at {} m, and the straight line beyond them deflects the end of the shaft at {} m by {} m, more than half of the largest amplitude, {} m; add points up to the ends of the shaft",
                    short(measured),
                    short(end),
                    short(deflection),
                    short(largest)
                ),
            );
        }
    }
}

/// Whether a density means a massless shaft, for example of a Jeffcott rotor. Such a density is at most 1 and is not the
/// density of a solid in kg/mm³ or t/mm³. In g/cm³, solids heavier than water have values above 1.
fn is_massless(density: f64) -> bool {
    density <= 1.0
        && ![1e-9, 1e-12].iter().any(|unit| (SOLID_DENSITY.low * unit..SOLID_DENSITY.high * unit).contains(&density))
}

fn check_gear(given: &description::Gear, gear: &Gear, at: &EntryPath, found: &mut Findings) {
    let size = if given.module.is_some() { "module" } else { "base_radius" };
    found.check(&at.field(size), gear.module, &GEAR_MODULE);
    found.check(&at.field("pressure_angle"), gear.pressure_angle, &PRESSURE_ANGLE);
    found.check(&at.field("profile_shift"), gear.profile_shift, &PROFILE_SHIFT);
    if given.tip_radius.is_some() {
        found.check(
            &at.field("tip_radius"),
            gear.sign() * (gear.tip_radius - gear.pitch_radius) / gear.module,
            &GEAR_ADDENDUM,
        );
    }
    found.check(&at.field("runout"), gear.runout.norm() / gear.module, &GEAR_RUNOUT);
    if let Some(width) = gear.face_width {
        found.check(&at.field("face_width"), width / (2.0 * gear.pitch_radius), &FACE_WIDTH);
        let [inner, outer] = gear.body_radii();
        let volume = PI * (outer.powi(2) - inner.powi(2)) * width;
        if given.mass.is_some_and(|mass| mass > 0.0) {
            found.check(&at.field("mass"), gear.body.mass / volume, &GEAR_DENSITY);
        }
    }
    if given.polar_inertia.is_some_and(|inertia| inertia > 0.0) && gear.body.mass > 0.0 {
        let gyration = (gear.body.polar_inertia / gear.body.mass).sqrt();
        found.check(&at.field("polar_inertia"), gyration / gear.pitch_radius, &GEAR_GYRATION);
    }
}

fn check_body(scene: &Scene, body: &Body, at: &EntryPath, found: &mut Findings) -> Result<(), SceneError> {
    // A diametral inertia of zero is a usual idealisation. It has no effect in pure torsion.
    let (polar, diametral) = (body.polar_inertia, body.diametral_inertia);
    if scene.lateral && diametral > 0.0 && polar > 2.0 * diametral * (1.0 + PUBLISHED_DATA_TOLERANCE) {
        return Err(at.field("polar_inertia").error(format!(
            "{polar} kg m2 is more than twice the diametral inertia, {diametral} kg m2, which is impossible for a rigid body; are the two exchanged?"
        )));
    }
    if body.mass > 0.0 {
        found.check(&at.field("mass"), body.mass, &BODY_MASS);
        if polar > 0.0 {
            found.check(&at.field("polar_inertia"), (polar / body.mass).sqrt(), &BODY_GYRATION);
        }
    }
    let radius = scene.shafts[body.node.shaft].radius_at(body.node.node);
    found.check(&at.field("unbalance"), eccentricity(scene, body) / radius, &BODY_ECCENTRICITY);
    Ok(())
}

fn check_mesh(scene: &Scene, given: &description::Mesh, index: usize, found: &mut Findings) {
    let (at, mesh) = (EntryPath::entry("meshes", index), &scene.meshes[index]);
    let pair = [&scene.gears[mesh.driver], &scene.gears[mesh.driven]];
    let module = pair[0].module.max(pair[1].module);
    let width = pair.iter().map(|gear| gear.face_width.unwrap_or(10.0 * gear.module)).fold(f64::INFINITY, f64::min);
    found.check_angle(&at.field("centre_line_angle"), mesh.centre_line_angle);
    if let Some(distance) = given.centre_distance {
        let radii = pair.map(|gear| gear.sign() * gear.pitch_radius).iter().sum::<f64>().abs();
        found.check(&at.field("centre_distance"), distance / radii, &CENTRE_DISTANCE);
    }
    let is_internal = pair.iter().any(|gear| gear.internal);
    for (gear, index) in pair.iter().zip([mesh.driver, mesh.driven]).filter(|_| !is_internal) {
        let at = EntryPath::entry("gears", index);
        found.check(&at.field("tip_radius"), gear.tip_radius / mesh.centre_distance, &TIP_REACH);
    }
    let place = at.field("stiffness");
    match &given.stiffness {
        None => {}
        Some(description::Stiffness::Mean(mean)) => found.check(&place, mean / width, &MESH_STIFFNESS),
        Some(description::Stiffness::Model(model)) => {
            let highest = model.values.iter().flatten().copied().reduce(f64::max);
            for (name, value) in [("mean", model.mean), ("pair", model.pair), ("values", highest)] {
                value.iter().for_each(|value| found.check(&place.field(name), value / width, &MESH_STIFFNESS));
            }
            let phases = model.phases.iter().flatten().enumerate();
            phases.for_each(|(i, phase)| found.check_angle(&place.field("phases").index(i), *phase));
        }
    }
    if let Damping::Ratio(ratio) = mesh.damping {
        found.check(&at.field("damping_ratio"), ratio, &MESH_DAMPING);
    }
    if let Some(description::MeshFriction::Coefficient(coefficient)) = given.friction {
        found.check(&at.field("friction"), coefficient, &MESH_FRICTION);
    }
    if let Some(description::MeshFriction::Table(friction)) = &given.friction {
        let at = at.field("friction");
        let given = [
            ("coefficient", friction.coefficient, &MESH_FRICTION),
            ("viscosity", friction.viscosity, &OIL_VISCOSITY),
            ("roughness", friction.roughness, &FLANK_ROUGHNESS),
        ];
        for (name, value, usual) in given {
            value.iter().for_each(|value| found.check(&at.field(name), *value, usual));
        }
    }
    found.check(&at.field("backlash"), mesh.teeth.backlash.unwrap_or(0.0) / module, &MESH_BACKLASH);
    if let Some(relief) = &mesh.teeth.relief {
        let at = at.field("tip_relief");
        found.check(&at.field("amount"), relief.amount / module, &TIP_RELIEF);
        found.check(&at.field("length"), relief.length / module, &RELIEF_LENGTH);
    }
    if let Some(error) = &mesh.teeth.error {
        let at = at.field("error");
        for (name, list) in [("tooth", &error.tooth), ("driver", &error.driver), ("driven", &error.driven)] {
            for (i, [amplitude, phase]) in list.iter().enumerate() {
                found.check(&at.field(name).index(i), amplitude.abs() / module, &TRANSMISSION_ERROR);
                found.check_angle(&at.field(name).index(i), *phase);
            }
        }
        let largest = error.table.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
        found.check(&at.field("table"), largest / module, &TRANSMISSION_ERROR);
    }
}

/// Warns of a shaft that nothing but one bearing without tilting stiffness holds: it may swing about the bearing.
fn check_tilting(scene: &Scene, shaft: usize, found: &mut Findings) {
    let holds = |bearing: &Bearing| bearing.nonlinear.is_some() || largest_stiffness(&bearing.stiffness) > 0.0;
    let holds_tilt = |bearing: &Bearing| bearing.tilting.stiffness > 0.0 || bearing.ring().is_some();
    let mut held = scene.held_nodes(shaft).map(|(index, node)| (&scene.bearings[index], node));
    let Some((_, node)) = held.clone().find(|(bearing, _)| holds(bearing)) else { return };
    if held.any(|(bearing, other)| holds_tilt(bearing) || other != node && holds(bearing)) {
        return;
    }
    let is_on = |node: &Node| node.shaft == shaft;
    let gears = scene.meshes.iter().flat_map(|mesh| [mesh.driver, mesh.driven]);
    let is_meshed = gears.map(|gear| scene.gears[gear].body.node).any(|gear| is_on(&gear) && gear.node != node);
    let is_coupled = scene.couplings.iter().any(|coupling| {
        let away = coupling.hubs.iter().find(|hub| is_on(hub)).is_some_and(|hub| hub.node != node);
        away && coupling.lateral.stiffness > 0.0 || coupling.tilting.stiffness > 0.0 && coupling.hubs.iter().any(is_on)
    });
    if !is_meshed && !is_coupled {
        let shape = &scene.shafts[shaft];
        let message = format!(
            "the bearing at {} m alone holds \"{}\", which may swing about it; add a bearing, or give tilting_stiffness",
            short(shape.nodes[node]),
            shape.name
        );
        found.add("single bearing", &EntryPath::entry("shafts", shaft), &message);
    }
}

/// Checks the deflection of a shaft and of its bearings under its weight. The weight of the bodies on the shaft is
/// distributed over its length.
fn check_supports(scene: &Scene, shaft: usize, found: &mut Findings) {
    let bearings: Vec<_> = scene.held_nodes(shaft).map(|(index, node)| (index, node, &scene.bearings[index])).collect();
    let at = EntryPath::entry("shafts", shaft);
    let shape = &scene.shafts[shaft];
    let mut supports: Vec<f64> = bearings.iter().map(|(_, node, _)| shape.nodes[*node]).collect();
    supports.sort_by(f64::total_cmp);
    let span = supports.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
    if span == 0.0 {
        return;
    }
    let weight = STANDARD_GRAVITY * mass_on(scene, shaft);
    let length = shape.length();
    // A beam on two supports has the deflection 5qs⁴/384EI. The compliance is the mean over the sections.
    let compliance: f64 = shape.elements.iter().map(|element| element.length / element.rigidities()[1]).sum();
    let compliance = compliance / length;
    let radius = largest_radius(shape);
    found.check(&at, 5.0 / 384.0 * weight / length * span.powi(4) * compliance / radius, &SHAFT_SAG);
    let total: f64 = bearings.iter().map(|(.., bearing)| largest_stiffness(&bearing.stiffness)).sum();
    let settling = weight / total / radius;
    let own = 48.0 / (compliance * span.powi(3));
    for (index, _, bearing) in bearings {
        let stiffness = largest_stiffness(&bearing.stiffness);
        if stiffness > 0.0 && stiffness < MIN_RELATIVE_STIFFNESS * own && settling > MAX_SETTLING {
            let message = format!(
                "{} N/m is {} % of the stiffness of the shaft, and the weight of the shaft displaces it by {} % of its radius; is it in N/mm?",
                short(stiffness),
                short(100.0 * stiffness / own),
                short(100.0 * settling)
            );
            found.add("bearing", &EntryPath::entry("bearings", index).field("stiffness"), &message);
        }
    }
}

/// Unbalance over the mass of the body and its shaft, m.
pub(crate) fn eccentricity(scene: &Scene, body: &Body) -> f64 {
    if body.unbalance.norm() == 0.0 { 0.0 } else { body.unbalance.norm() / mass_on(scene, body.node.shaft) }
}

/// Whether an unbalance exceeds the plausible range.
pub(crate) fn implausible_unbalance(scene: &Scene, body: &Body) -> bool {
    let radius = scene.shafts[body.node.shaft].radius_at(body.node.node);
    eccentricity(scene, body) > BODY_ECCENTRICITY.high * radius
}

impl Scene {
    /// Returns a warning if the pitch-line speed is implausible at this speed of the reference shaft, rad/s.
    pub fn pitch_line_warning(&self, speed: f64) -> Option<String> {
        let of = |gear: &Gear| (self.speed_ratios[gear.body.node.shaft] * speed * gear.pitch_radius).abs();
        let (name, fastest) =
            self.gears.iter().map(|gear| (&gear.body.name, of(gear))).max_by(|a, b| a.1.total_cmp(&b.1))?;
        let most = PITCH_LINE_SPEED.high;
        (fastest > most).then(|| {
            format!(
                "speed: the pitch-line speed of \"{name}\" is {} m/s at {} rad/s, usual is up to {most} m/s; {}",
                short(fastest),
                short(speed),
                PITCH_LINE_SPEED.above
            )
        })
    }
}

fn mass_on(scene: &Scene, shaft: usize) -> f64 {
    let own = &scene.shafts[shaft];
    let shaft_mass: f64 = own.elements.iter().map(super::Element::mass).sum();
    let bodies: f64 = scene.bodies().filter(|body| body.node.shaft == shaft).map(|body| body.mass).sum();
    shaft_mass + bodies
}

fn largest_radius(shaft: &Shaft) -> f64 {
    shaft.elements.iter().map(super::Element::outer_radius).fold(0.0, f64::max)
}

/// The largest stiffness along y or z, at any speed, N/m.
fn largest_stiffness(stiffness: &BearingCoefficient) -> f64 {
    stiffness.extremes().iter().map(|stiffness| stiffness[0][0].max(stiffness[1][1])).fold(0.0, f64::max)
}
