//! Pairs of gears in mesh: checks that the gears fit, their distance, teeth and damping.

use super::centre_distance::{check_play, default_distance, largest_tip_radius};
use super::contact::{PairGeometry, check_contact, check_undercut};
use super::description::{self, SceneDescription};
use super::gear::PUBLISHED_DATA_TOLERANCE;
use super::place::Names;
use super::{EntryPath, Gear, Node, SceneError, Shaft, Teeth, nearest};
use crate::numerics::EQUALITY_TOLERANCE;

/// Damping of a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Damping {
    /// Damping ratio ζ: c = 2ζ√(k mₑ), with the mean stiffness k and mₑ = (r_a²/I_pa + r_b²/I_pb)⁻¹.
    Ratio(f64),
    /// Damping coefficient c, N s/m.
    Constant(f64),
}

/// A checked mesh.
#[derive(Clone, Debug)]
pub struct Mesh {
    /// Index of the driving gear.
    pub driver: usize,
    /// Index of the driven gear.
    pub driven: usize,
    /// Stiffness, engagement, tip relief, backlash and transmission error.
    pub teeth: Teeth,
    /// Damping along the line of action.
    pub damping: Damping,
    /// Whether the damping acts while the flanks are separated as well.
    pub damping_in_separation: bool,
    /// Loss factor η of the stiffness.
    pub loss_factor: f64,
    /// Angle ψ from y to the line of centres at rest, driver to driven gear, rad.
    pub centre_line_angle: f64,
    /// Centre distance C₀ at rest, m.
    pub centre_distance: f64,
    /// Angle of the drive flank of a tooth of the driver on its base circle at the time zero, rad.
    pub tooth_angle: f64,
    /// The carrier with which the line of centres turns: all angles and twists of the mesh are relative to it; none on fixed axes.
    pub carrier: Option<Node>,
}

/// The gears of a mesh and their centre distance.
struct Pair {
    /// Index of the driving gear.
    driver: usize,
    /// Index of the driven gear.
    driven: usize,
    /// Centre distance at rest, m.
    centre_distance: f64,
}

/// Checks all meshes, and shortens default tip radii that would leave too little tip clearance.
pub(super) fn meshes(
    system: &SceneDescription,
    names: &Names,
    shafts: &[Shaft],
    gears: &mut [Gear],
    warnings: &mut Vec<String>,
) -> Result<Vec<Mesh>, SceneError> {
    let mut pairs: Vec<Pair> = Vec::with_capacity(system.meshes.len());
    for (index, given) in system.meshes.iter().enumerate() {
        let at = EntryPath::entry("meshes", index);
        let pair = pair(given, shafts, gears, &at, warnings)?;
        let gears_of = |pair: &Pair| (pair.driver.min(pair.driven), pair.driver.max(pair.driven));
        if let Some(first) = pairs.iter().position(|other| gears_of(other) == gears_of(&pair)) {
            return Err(at.error(format!("repeats the pair of gears of meshes[{first}]")));
        }
        pairs.push(pair);
    }
    shorten_tips(system, &pairs, gears)?;
    let gears = &*gears;
    let mut meshes = Vec::with_capacity(pairs.len());
    for (index, (given, pair)) in system.meshes.iter().zip(&pairs).enumerate() {
        let at = EntryPath::entry("meshes", index);
        let carrier = carrier(given, pair, names, shafts, gears, &at)?;
        meshes.push(Mesh { carrier, ..mesh(given, pair, shafts, gears, &at, warnings)? });
    }
    for (index, gear) in gears.iter().enumerate() {
        // The rack of a gear is unknown if the description gives its base radius only.
        if gear.rack.is_some() && pairs.iter().any(|pair| [pair.driver, pair.driven].contains(&index)) {
            check_undercut(gear, &EntryPath::entry("gears", index), warnings);
        }
    }
    Ok(meshes)
}

/// Finds the gears of a mesh, checks that they fit, and finds their centre distance.
fn pair(
    given: &description::Mesh,
    shafts: &[Shaft],
    gears: &[Gear],
    at: &EntryPath,
    warnings: &mut Vec<String>,
) -> Result<Pair, SceneError> {
    let find = |field: &str, name: &str| {
        let place = at.field(field);
        gears.iter().position(|gear| gear.body.name == name).ok_or_else(|| {
            let hint = match shafts.iter().position(|shaft| shaft.name == name) {
                Some(shaft) => {
                    let own = gears.iter().filter(|gear| gear.body.node.shaft == shaft);
                    let names: Vec<_> = own.map(|gear| format!("\"{}\"", gear.body.name)).collect();
                    let names = if names.is_empty() { "it has none".to_owned() } else { names.join(", ") };
                    format!("; it is a shaft, and a mesh needs one of its gears: {names}")
                }
                None => nearest(name, gears.iter().map(|gear| gear.body.name.as_str())),
            };
            place.error(format!("no gear is called \"{name}\"{hint}"))
        })
    };
    let (driver, driven) = (find("driver", &given.driver)?, find("driven", &given.driven)?);
    let (a, b) = (&gears[driver], &gears[driven]);
    if a.body.node.shaft == b.body.node.shaft {
        let shaft = &shafts[a.body.node.shaft].name;
        return Err(at.error(format!(
            "\"{}\" and \"{}\" sit on the same shaft, \"{shaft}\"; gears in mesh need two shafts: change the shaft of one gear, or the gears of the mesh",
            given.driver, given.driven
        )));
    }
    check_sizes(a, b, at)?;
    check_racks(a, b, at, warnings)?;
    let centre_distance = match given.centre_distance {
        Some(distance) => at.field("centre_distance").positive(distance)?,
        None => default_distance([a, b], at)?,
    };
    let lengths = PairGeometry::of([a, b]);
    let base_circles = lengths.base_circles().abs();
    if centre_distance <= base_circles {
        let of = if lengths.base_radius[1] < 0.0 { "difference" } else { "sum" };
        let message = format!("{centre_distance} m is not above the {of} of the base radii, {base_circles} m");
        return Err(at.field("centre_distance").error(message));
    }
    Ok(Pair { driver, driven, centre_distance })
}

/// Shortens the tips of gears without a given tip radius. The mesh with the least clearance decides.
fn shorten_tips(system: &SceneDescription, pairs: &[Pair], gears: &mut [Gear]) -> Result<(), SceneError> {
    for (index, pair) in pairs.iter().enumerate() {
        for (own, other) in [(pair.driver, pair.driven), (pair.driven, pair.driver)] {
            let largest = largest_tip_radius(&gears[own], &gears[other], pair.centre_distance);
            let gear = &gears[own];
            if system.gears[own].tip_radius.is_some() || largest >= gear.sign() * gear.tip_radius {
                continue;
            }
            let least = if gear.internal { -gear.root_radius() } else { gear.base_radius };
            if largest <= least {
                return Err(EntryPath::entry("meshes", index).field("centre_distance").error(format!(
                    "at {} m, the root circle of \"{}\" leaves no tooth above the base circle of \"{}\"; use a larger \
                     centre_distance or a smaller profile_shift, or give tip_radius",
                    pair.centre_distance, gears[other].body.name, gears[own].body.name
                )));
            }
            gears[own].tip_radius = largest.abs();
        }
    }
    Ok(())
}

fn mesh(
    given: &description::Mesh,
    &Pair { driver, driven, centre_distance }: &Pair,
    shafts: &[Shaft],
    gears: &[Gear],
    at: &EntryPath,
    warnings: &mut Vec<String>,
) -> Result<Mesh, SceneError> {
    let (a, b) = (&gears[driver], &gears[driven]);
    check_contact([a, b], centre_distance, at, warnings)?;
    let shaft_radii = [a, b].map(|gear| shafts[gear.body.node.shaft].radius_at(gear.body.node.node));
    let teeth = Teeth::new(given, [a, b], shaft_radii, at, warnings)?;
    if given.centre_distance.is_some() {
        check_play([a, b], centre_distance, teeth.backlash, at, warnings);
    }
    let damping = match (given.damping, given.damping_ratio) {
        (Some(_), Some(_)) => {
            return Err(at.field("damping").error("cannot be combined with damping_ratio; give one of them"));
        }
        (Some(damping), None) => Damping::Constant(at.field("damping").non_negative(damping)?),
        (None, ratio) => Damping::Ratio(at.field("damping_ratio").non_negative(ratio.unwrap_or(0.0))?),
    };
    let centre_line_angle = at.field("centre_line_angle").finite(given.centre_line_angle.unwrap_or(0.0))?;
    let tooth_angle = at.field("tooth_angle").finite(given.tooth_angle.unwrap_or(0.0))?;
    let damping_in_separation = given.damping_in_separation.unwrap_or(false);
    let loss_factor = at.field("loss_factor").non_negative(given.loss_factor.unwrap_or(0.0))?;
    Ok(Mesh {
        driver,
        driven,
        teeth,
        damping,
        damping_in_separation,
        loss_factor,
        centre_line_angle,
        centre_distance,
        tooth_angle,
        carrier: None,
    })
}

/// Finds the node of the carrier of a mesh, which neither of its gears may share.
fn carrier(
    given: &description::Mesh,
    pair: &Pair,
    names: &Names,
    shafts: &[Shaft],
    gears: &[Gear],
    at: &EntryPath,
) -> Result<Option<Node>, SceneError> {
    let Some(place) = &given.carrier else { return Ok(None) };
    let at = at.field("carrier");
    let node = names.place(shafts, place, &at)?;
    if let Some(gear) = [pair.driver, pair.driven].into_iter().find(|gear| gears[*gear].body.node.shaft == node.shaft) {
        return Err(at.error(format!(
            "stands on the shaft \"{}\" of the gear \"{}\"; a planet turns on a shaft of its own, and sun and ring are not the carrier",
            shafts[node.shaft].name, gears[gear].body.name
        )));
    }
    let (a, b) = (&gears[pair.driver], &gears[pair.driven]);
    let follows_shaft = |gear: &Gear| gear.runout.norm() > 0.0;
    if let Some(gear) = [a, b].into_iter().find(|gear| follows_shaft(gear)) {
        return Err(at.error(format!(
            "the gear \"{}\" has run-out, which gearbow does not compute with a carrier that turns; give the run-out of another gear, or an error of the teeth",
            gear.body.name
        )));
    }
    if given.error.as_ref().is_some_and(|error| error.driver.is_some() || error.driven.is_some()) {
        return Err(at.error(
            "a mesh with a carrier that turns has no error per revolution of a shaft; give error.tooth or error.table",
        ));
    }
    Ok(Some(node))
}

/// Refuses gears of different modules, pressure angles, base pitches or helix angles.
fn check_racks(a: &Gear, b: &Gear, at: &EntryPath, warnings: &mut Vec<String>) -> Result<(), SceneError> {
    let differ = |first: f64, second: f64| (first - second).abs() > EQUALITY_TOLERANCE * first.abs().max(second.abs());
    let names = || (a.body.name.as_str(), b.body.name.as_str());
    if let (Some((module_a, angle_a)), Some((module_b, angle_b))) = (a.rack, b.rack) {
        let (first, second) = names();
        if differ(module_a, module_b) {
            return Err(at.error(format!(
                "cannot mesh: \"{first}\" has module {module_a} m, \"{second}\" {module_b} m; give both the same module"
            )));
        }
        if differ(angle_a, angle_b) {
            return Err(at.error(format!(
                "cannot mesh: \"{first}\" has pressure angle {angle_a} rad, \"{second}\" {angle_b} rad; give both the same"
            )));
        }
    }
    check_hands(a, b, at)?;
    let (pitch_a, pitch_b) = (a.base_pitch(), b.base_pitch());
    let difference = (pitch_a - pitch_b).abs() / pitch_a.max(pitch_b);
    let (first, second) = names();
    let message = format!("the base pitch of \"{first}\" is {pitch_a} m, that of \"{second}\" {pitch_b} m");
    if difference > PUBLISHED_DATA_TOLERANCE {
        return Err(at.error(format!("cannot mesh: {message}")));
    }
    if difference > EQUALITY_TOLERANCE {
        warnings.push(format!("{at}: {message}; speeds follow the tooth numbers, forces the base radii"));
    }
    Ok(())
}

/// Refuses two internal gears, and an internal gear that is not larger than its pinion.
fn check_sizes(a: &Gear, b: &Gear, at: &EntryPath) -> Result<(), SceneError> {
    let (first, second) = (a.body.name.as_str(), b.body.name.as_str());
    let [pinion, ring] = match (a.internal, b.internal) {
        (false, false) => return Ok(()),
        (true, true) => {
            return Err(
                at.error(format!("cannot mesh: \"{first}\" and \"{second}\" are both internal; one must be external"))
            );
        }
        (true, false) => [b, a],
        (false, true) => [a, b],
    };
    if ring.teeth > pinion.teeth && ring.base_radius > pinion.base_radius {
        return Ok(());
    }
    Err(at.error(format!(
        "cannot mesh: the internal gear \"{}\" needs more teeth than \"{}\", got {} and {}",
        ring.body.name, pinion.body.name, ring.teeth, pinion.teeth
    )))
}

/// Refuses helices that do not fit: external gears need opposite hands of the same angle, an internal gear has the hand of its
/// pinion.
fn check_hands(a: &Gear, b: &Gear, at: &EntryPath) -> Result<(), SceneError> {
    let (first, second, sign) = (a.helix_angle, b.helix_angle, -a.sign() * b.sign());
    if (first - sign * second).abs() <= EQUALITY_TOLERANCE * first.abs().max(second.abs()) {
        return Ok(());
    }
    let need = if sign < 0.0 {
        "external gears need opposite hands"
    } else {
        "an internal gear and its pinion need the same hand"
    };
    Err(at.error(format!(
        "cannot mesh: \"{}\" has helix_angle {first} rad, \"{}\" {second} rad; {need} of the same angle: give \"{}\" helix_angle={}",
        a.body.name, b.body.name, b.body.name, sign * first
    )))
}
