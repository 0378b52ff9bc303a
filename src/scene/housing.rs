//! What bearings stand on: supports, housings and other shafts, and where each bearing is attached to them.
//!
//! A support is a housing that does not rotate, and may itself stand on a housing. The arms of the bearings follow from the positions of the shafts at rest.

use num_complex::Complex64;

use super::description::{self, Base, ElasticBody, SceneDescription};
use super::place::{Names, own_supports};
use super::speed_table::checked;
use super::train::Train;
use super::{EntryPath, Journal, Matrix2, Mesh, Node, SceneError, Shaft, Squeeze, nearest};

/// Largest distance of the two places of a bearing between shafts, over the radius of the shaft on which it stands: rounded
/// centre distances leave one.
const MAX_SHARED_DISTANCE: f64 = 0.01;

/// A rigid body on springs and dampers, on which bearings stand.
#[derive(Clone, Debug, Default)]
pub struct Housing {
    /// Name; the path of its entry if it has none.
    pub name: String,
    /// Mass, kg.
    pub mass: f64,
    /// Moments of inertia about x, y and z, kg m²; `None` if it does not rotate.
    pub inertia: Option<[f64; 3]>,
    /// Centre of mass (x, y, z), m; the origin is the left end of the first shaft.
    pub centre: [f64; 3],
    /// The place of a housing on which a support stands; `None` for the ground.
    pub attachment: Option<Attachment>,
    /// Stiffness to the ground, or to the place where it stands, over (y, z), N/m.
    pub stiffness: Matrix2,
    /// Damping to the ground, or to the place where it stands, over (y, z), N s/m.
    pub damping: Matrix2,
    /// Stiffness, N/m, and damping, N s/m, to the ground, or to the place where it stands, along the axis; `None` if it does not move along the axis.
    pub axial: Option<[f64; 2]>,
    /// Stiffness to the ground about x, y and z, N m/rad.
    pub rotational_stiffness: [f64; 3],
    /// Damping to the ground about x, y and z, N m s/rad.
    pub rotational_damping: [f64; 3],
    /// Loss factor η of the stiffness.
    pub loss_factor: f64,
    /// The squeeze film between it and the ground or the place where it stands.
    pub squeeze: Option<Squeeze>,
    /// Names of the points whose motion can be recorded, with their distance (x, y, z) from the centre of mass, m.
    pub points: Vec<(String, [f64; 3])>,
    /// The modes of an elastic housing, in place of mass, stiffness and points; `None` for a rigid one.
    pub elastic: Option<ElasticBody>,
}

impl Housing {
    /// Number of modes of an elastic housing; zero for a rigid one.
    pub fn mode_count(&self) -> usize {
        self.elastic.as_ref().map_or(0, |elastic| elastic.frequencies.len())
    }

    /// Finds the housing or a point of it by name. An elastic housing has no point of its own name.
    pub fn point(&self, name: &str) -> Option<HousingPoint> {
        if let Some(elastic) = &self.elastic {
            return elastic.interfaces.keys().position(|known| known == name).map(HousingPoint::Interface);
        }
        let point = || self.points.iter().find(|(point, _)| point == name).map(|(_, arm)| *arm);
        let arm = if self.name == name { Some([0.0; 3]) } else { point() };
        arm.map(HousingPoint::Arm)
    }

    /// Names of its points.
    pub fn point_names(&self) -> impl Iterator<Item = &str> {
        let interfaces = self.elastic.iter().flat_map(|elastic| elastic.interfaces.keys());
        self.points.iter().map(|(name, _)| name).chain(interfaces).map(String::as_str)
    }
}

/// A point of a support or housing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum HousingPoint {
    /// Distance (x, y, z) from the centre of mass of a rigid one, m; zero if it does not rotate.
    Arm([f64; 3]),
    /// Index of an interface of an elastic one, in the order of the names.
    Interface(usize),
}

/// Place of a bearing on what it stands on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Attachment {
    /// A support or housing.
    Housing {
        /// Index of the housing.
        housing: usize,
        /// Place of the bearing on it.
        point: HousingPoint,
    },
    /// A node of another shaft.
    Shaft(Node),
    /// A pin of a carrier that turns.
    Pin {
        /// Node of the carrier.
        carrier: Node,
        /// Distance (x, y, z) of the bearing from this node in the frame of the carrier, m: the planet is in its plane.
        arm: [f64; 3],
    },
}

/// All supports and housings: the listed supports, the listed housings, then the supports of single bearings.
pub(super) fn housings(system: &SceneDescription) -> Result<Vec<Housing>, SceneError> {
    let listed = system.supports.iter().enumerate();
    let listed = listed.map(|(index, given)| support(given, &EntryPath::entry("supports", index)));
    let rigid = system.housings.iter().enumerate();
    let rigid = rigid.map(|(index, given)| housing(given, &EntryPath::entry("housings", index)));
    let own = own_supports(system)
        .map(|(index, given)| support(given, &EntryPath::entry("bearings", index).field("support")));
    let found = listed.chain(rigid).chain(own).collect::<Result<Vec<_>, _>>()?;
    for (index, given) in system.supports.iter().enumerate() {
        if given.name.is_none() {
            let message = "needs a name, which bearings refer to with support=";
            return Err(EntryPath::entry("supports", index).field("name").error(message));
        }
    }
    for (list, index, name) in named_bases(system) {
        let names = |base: &Base| matches!(base, Base::Named(base) | Base::Interface(base, _) if base == name);
        let of_bearings = system.bearings.iter().filter_map(|bearing| bearing.support.as_ref());
        if !of_bearings.chain(bases_of_supports(system)).any(names) {
            let message =
                format!("no bearing stands on \"{name}\"; give gb.Bearing(..., support=\"{name}\"), or remove it");
            return Err(EntryPath::entry(list, index).error(message));
        }
    }
    Ok(found)
}

/// What the supports stand on.
fn bases_of_supports(system: &SceneDescription) -> impl Iterator<Item = &Base> {
    system
        .supports
        .iter()
        .chain(own_supports(system).map(|(_, given)| given))
        .filter_map(|given| given.support.as_deref())
}

/// The listed supports and housings: list, index and name of each.
fn named_bases(system: &SceneDescription) -> impl Iterator<Item = (&'static str, usize, &str)> {
    let supports = system.supports.iter().enumerate();
    let supports = supports.map(|(index, given)| ("supports", index, given.name.as_deref().unwrap_or_default()));
    let housings = system.housings.iter().enumerate();
    supports.chain(housings.map(|(index, given)| ("housings", index, given.name.as_str())))
}

/// Where the parts of a train at rest are.
pub(super) struct Places {
    /// Left end (x, y, z) of each shaft, m.
    pub origins: Vec<[f64; 3]>,
    /// Place of each bearing on its housing or on another shaft; `None` for a bearing on the ground.
    pub attachments: Vec<Option<Attachment>>,
}

/// Finds the places of shafts and bearings. Supports that stand on a housing receive their place on it.
pub(super) fn places(
    system: &SceneDescription,
    names: &Names,
    shafts: &[Shaft],
    train: Train<'_>,
    housings: &mut [Housing],
) -> Result<Places, SceneError> {
    let mut shared = shared_places(system, names, shafts)?;
    let pins: Vec<_> = shared.iter_mut().map(|nodes| pin(nodes, shafts, train)).collect();
    let origins = origins(shafts, train, shared.iter().flatten().copied());
    check_shared(&shared, shafts, &origins)?;
    let mut seats = Vec::with_capacity(system.bearings.len());
    for (index, bearing) in system.bearings.iter().enumerate() {
        let shaft = names.shaft(&bearing.shaft, &EntryPath::entry("bearings", index).field("shaft"))?;
        let radii = shafts[shaft].elements.iter().map(|element| element.outer_radius());
        let [x, y, z] = origins[shaft];
        seats.push(Seat { place: [x + bearing.position, y, z], radius: radii.fold(0.0, f64::max) });
    }
    let mut own = system.supports.len() + system.housings.len();
    let attachment = |(index, bearing): (usize, &description::Bearing)| {
        let at = EntryPath::entry("bearings", index);
        match &bearing.support {
            None => Ok(None),
            Some(Base::Shaft(..)) => Ok(pins[index].or(shared[index].map(|[_, base]| Attachment::Shaft(base)))),
            Some(Base::Own(_)) => {
                own += 1;
                Ok(Some(Attachment::Housing { housing: own - 1, point: HousingPoint::Arm([0.0; 3]) }))
            }
            Some(base) => seats[index].on(base, system, housings, &at.field("support")).map(Some),
        }
    };
    let found = system.bearings.iter().enumerate().map(attachment).collect::<Result<Vec<_>, _>>()?;
    let carried = |support: usize| {
        let stands = move |place: &Option<Attachment>| matches!(place, Some(Attachment::Housing { housing, .. }) if *housing == support);
        found.iter().zip(&seats).filter(move |(place, _)| stands(place)).map(|(_, seat)| seat)
    };
    for (index, given) in system.supports.iter().enumerate() {
        let at = EntryPath::entry("supports", index);
        housings[index].attachment = place_of_support(given, carried(index), system, housings, &at)?;
    }
    let first = system.supports.len() + system.housings.len();
    for (number, (bearing, given)) in own_supports(system).enumerate() {
        let (index, entry) = (first + number, EntryPath::entry("bearings", bearing));
        let at = entry.field("support");
        housings[index].attachment = place_of_support(given, carried(index), system, housings, &at)?;
    }
    Ok(Places { origins, attachments: found })
}

/// Place of a support that carries bearings at seats on the housing on which it stands; `None` for the ground.
fn place_of_support<'a>(
    given: &description::Support,
    mut carried: impl Iterator<Item = &'a Seat>,
    system: &SceneDescription,
    housings: &[Housing],
    at: &EntryPath<'_>,
) -> Result<Option<Attachment>, SceneError> {
    let (Some(base), at) = (&given.support, at.field("support")) else { return Ok(None) };
    // A support carries one bearing at least.
    let Some(seat) = carried.next() else { return Ok(None) };
    if carried.any(|other| other.place != seat.place) {
        let message = "carries bearings at several places, so that its place on the housing is unknown; give each bearing a support of its own";
        return Err(at.error(message));
    }
    match seat.on(base, system, housings, &at)? {
        Attachment::Housing { housing, .. } if housing < system.supports.len() => {
            Err(at.error("a support stands on the ground or on a housing, not on a support; name one of housings="))
        }
        attachment => Ok(Some(attachment)),
    }
}

/// A place (x, y, z), m, at which something stands on a housing, and the largest radius of the shaft there, m.
struct Seat {
    place: [f64; 3],
    radius: f64,
}

impl Seat {
    /// Its place on a listed support or housing.
    fn on(
        &self,
        base: &Base,
        system: &SceneDescription,
        housings: &[Housing],
        at: &EntryPath<'_>,
    ) -> Result<Attachment, SceneError> {
        let (name, interface) = match base {
            Base::Named(name) => (name, None),
            Base::Interface(name, interface) => (name, Some(interface.as_str())),
            Base::Own(_) | Base::Shaft(..) => {
                return Err(at.error("must be the name of a housing, or (housing, interface) of an elastic one"));
            }
        };
        let housing = named_bases(system).position(|(_, _, known)| known == name).ok_or_else(|| {
            let near = nearest(name, named_bases(system).map(|(_, _, known)| known));
            at.error(format!(
                "no support or housing is called \"{name}\"{near}; list it in supports= or housings=, or give (shaft, position) for a bearing on another shaft"
            ))
        })?;
        let body = &housings[housing];
        if let Some(elastic) = &body.elastic {
            let point = seat(elastic, interface, self.place, self.radius, at)?;
            return Ok(Attachment::Housing { housing, point });
        }
        if interface.is_some() {
            let message = format!("\"{}\" is no elastic housing and has no interfaces; name it alone", body.name);
            return Err(at.error(message));
        }
        let arm = std::array::from_fn(|axis| self.place[axis] - body.centre[axis]);
        let point = HousingPoint::Arm(if body.inertia.is_some() { arm } else { [0.0; 3] });
        Ok(Attachment::Housing { housing, point })
    }
}

/// The interface of an elastic housing on which a bearing at a place, m, stands, within a radius of the shaft, m.
fn seat(
    elastic: &ElasticBody,
    name: Option<&str>,
    place: [f64; 3],
    radius: f64,
    at: &EntryPath<'_>,
) -> Result<HousingPoint, SceneError> {
    let Some(name) = name else {
        let known: Vec<&str> = elastic.interfaces.keys().map(String::as_str).collect();
        let message = format!("name an interface of the elastic housing, (housing, interface): {}", known.join(", "));
        return Err(at.error(message));
    };
    let found = elastic.interfaces.iter().enumerate().find(|(_, (known, _))| *known == name);
    let Some((index, (_, interface))) = found else {
        let near = nearest(name, elastic.interfaces.keys().map(String::as_str));
        return Err(at.error(format!("the housing has no interface \"{name}\"{near}")));
    };
    let distance = (0..3).map(|axis| place[axis] - interface.position[axis]).fold(0.0, f64::hypot);
    if distance > radius {
        let message = format!(
            "the bearing is at {place:.6?} m, {:.6} m from the interface of the housing at {:.6?} m; mend a position, which both count from the left end of the first shaft",
            distance, interface.position
        );
        return Err(at.error(message));
    }
    Ok(HousingPoint::Interface(index))
}

/// Nodes of each bearing between two shafts, on its own shaft and on the other one; `None` for another bearing.
fn shared_places(
    system: &SceneDescription,
    names: &Names,
    shafts: &[Shaft],
) -> Result<Vec<Option<[Node; 2]>>, SceneError> {
    let places = |(index, bearing): (usize, &description::Bearing)| {
        let Some(Base::Shaft(shaft, position)) = &bearing.support else {
            return Ok(None);
        };
        let entry = EntryPath::entry("bearings", index);
        let at = entry.field("support");
        let own = names.node(shafts, &bearing.shaft, bearing.position, &entry)?;
        let base = names.place(shafts, &description::Place::Shaft(shaft.clone(), *position), &at)?;
        if own.shaft == base.shaft {
            let message = format!("is on \"{shaft}\", the shaft of the bearing; name the other shaft");
            return Err(at.error(message));
        }
        Ok(Some([own, base]))
    };
    system.bearings.iter().enumerate().map(places).collect()
}

/// Takes the pin of a carrier that turns from the places of a bearing: one between the shaft of a planet and that of its carrier.
fn pin(nodes: &mut Option<[Node; 2]>, shafts: &[Shaft], train: Train<'_>) -> Option<Attachment> {
    let [own, base] = (*nodes)?;
    let of_planet = |mesh: &Mesh| {
        let carrier = mesh.carrier.filter(|node| node.shaft == base.shaft)?;
        let driver = train.gears[mesh.driver].body.node;
        let outwards = Complex64::from_polar(mesh.centre_distance, mesh.centre_line_angle);
        let driven = train.gears[mesh.driven].body.node;
        // Sun and ring have one axis, from which the line of centres points to the planet that they drive.
        let (planet, out) = if driven.shaft == own.shaft { (driven, outwards) } else { (driver, -outwards) };
        let x = |node: Node| shafts[node.shaft].nodes[node.node];
        let arm = [x(own) - x(planet), out.re, out.im];
        (planet.shaft == own.shaft).then_some(Attachment::Pin { carrier, arm })
    };
    let found = train.meshes.iter().find_map(of_planet);
    if found.is_some() {
        *nodes = None;
    }
    found
}

/// Refuses a bearing between two shafts whose places are apart.
fn check_shared(shared: &[Option<[Node; 2]>], shafts: &[Shaft], origins: &[[f64; 3]]) -> Result<(), SceneError> {
    for (index, nodes) in shared.iter().enumerate() {
        let Some(nodes) = nodes else { continue };
        let [own, base] = nodes.map(|node| {
            let [x, y, z] = origins[node.shaft];
            [x + shafts[node.shaft].nodes[node.node], y, z]
        });
        let distance = (0..3).map(|axis| own[axis] - base[axis]).fold(0.0, f64::hypot);
        if distance > MAX_SHARED_DISTANCE * shafts[nodes[1].shaft].radius_at(nodes[1].node) {
            let message = format!(
                "is {distance:.6} m from the place of the bearing on its shaft: meshes, couplings and other bearings between the shafts put them at {own:.6?} and {base:.6?} m; mend a position or a centre distance"
            );
            return Err(EntryPath::entry("bearings", index).field("support").error(message));
        }
    }
    Ok(())
}

/// Left end (x, y, z) of each shaft, m. The first shaft begins at the origin; meshes, couplings, carriers that turn, and the
/// bearings between two shafts, given as pairs of nodes, give the positions of the shafts relative to each other; a shaft
/// without them begins at the origin too.
fn origins(
    shafts: &[Shaft],
    Train { gears, meshes, couplings }: Train<'_>,
    shared: impl Iterator<Item = [Node; 2]>,
) -> Vec<[f64; 3]> {
    let mut origins: Vec<Option<[f64; 3]>> = vec![None; shafts.len()];
    let place = |node: Node| shafts[node.shaft].nodes[node.node];
    let position = |gear: usize| place(gears[gear].body.node);
    // A carrier that turns is at the place of the ring around its planets.
    let of_carrier = |mesh: &Mesh| {
        let ring = [mesh.driver, mesh.driven].into_iter().find(|gear| gears[*gear].internal)?;
        Some([gears[ring].body.node, mesh.carrier?])
    };
    let carriers = meshes.iter().filter_map(of_carrier);
    let coaxial: Vec<[Node; 2]> =
        couplings.iter().map(|coupling| coupling.hubs).chain(shared).chain(carriers).collect();
    while let Some(next) = origins.iter().position(Option::is_none) {
        origins[next] = Some([0.0; 3]);
        let mut found = true;
        while found {
            found = false;
            for mesh in meshes {
                let (sine, cosine) = mesh.centre_line_angle.sin_cos();
                let ends = [(mesh.driver, mesh.driven, 1.0), (mesh.driven, mesh.driver, -1.0)];
                for (from, to, sign) in ends {
                    let (known, wanted) = (gears[from].body.node.shaft, gears[to].body.node.shaft);
                    if let (Some([x, y, z]), None) = (origins[known], origins[wanted]) {
                        let distance = sign * mesh.centre_distance;
                        let x = x + position(from) - position(to);
                        origins[wanted] = Some([x, y + distance * cosine, z + distance * sine]);
                        found = true;
                    }
                }
            }
            for &[a, b] in &coaxial {
                for (known, wanted) in [(a, b), (b, a)] {
                    if let (Some([x, y, z]), None) = (origins[known.shaft], origins[wanted.shaft]) {
                        origins[wanted.shaft] = Some([x + place(known) - place(wanted), y, z]);
                        found = true;
                    }
                }
            }
        }
    }
    origins.into_iter().flatten().collect()
}

fn support(given: &description::Support, at: &EntryPath) -> Result<Housing, SceneError> {
    Ok(Housing {
        name: given.name.clone().unwrap_or_else(|| at.to_string()),
        mass: mass(given.mass, at)?,
        stiffness: checked(given.stiffness, &at.field("stiffness"))?,
        damping: given.damping.map_or(Ok([[0.0; 2]; 2]), |damping| checked(damping, &at.field("damping")))?,
        axial: axial([given.axial_stiffness, given.axial_damping], at)?,
        loss_factor: at.field("loss_factor").non_negative(given.loss_factor.unwrap_or(0.0))?,
        squeeze: Squeeze::new(given, at)?,
        ..Housing::default()
    })
}

/// The tilting pads of a bearing as a body of which each mode is the motion of one pad.
pub(super) fn pads(name: String, journal: &Journal) -> Option<Housing> {
    let tilting = journal.tilting.as_ref()?;
    let count = journal.pads.len();
    let mut body = ElasticBody { frequencies: vec![0.0; count], ..ElasticBody::default() };
    let mut along = [vec![0.0; count], vec![0.0; count], vec![0.0; count]];
    if let Some([mass, stiffness]) = tilting.spring {
        body.frequencies.extend(vec![(stiffness / mass).sqrt(); count]);
        for pad in &journal.pads {
            let (sin, cos) = pad.closest(1.0).sin_cos();
            for (row, part) in along.iter_mut().zip([0.0, cos, sin]) {
                row.push(mass.sqrt() * part);
            }
        }
    }
    body.damping_ratios = vec![0.0; body.frequencies.len()];
    body.translation = Some(along);
    Some(Housing { name, elastic: Some(body), ..Housing::default() })
}

fn housing(given: &description::Housing, at: &EntryPath) -> Result<Housing, SceneError> {
    let vector = |name: &str, values: Option<[f64; 3]>, check: fn(&EntryPath, f64) -> Result<f64, SceneError>| {
        let at = at.field(name);
        values.iter().flatten().enumerate().try_for_each(|(axis, value)| check(&at.index(axis), *value).map(drop))
    };
    vector("inertia", given.inertia, |at, value| at.positive(value))?;
    vector("position", given.position, |at, value| at.finite(value))?;
    vector("rotational_stiffness", given.rotational_stiffness, |at, value| at.non_negative(value))?;
    vector("rotational_damping", given.rotational_damping, |at, value| at.non_negative(value))?;
    for (name, values) in
        [("rotational_stiffness", given.rotational_stiffness), ("rotational_damping", given.rotational_damping)]
    {
        if values.is_some() && given.inertia.is_none() {
            let message =
                "acts on rotations, which the housing does not have; give inertia=(about x, about y, about z)";
            return Err(at.field(name).error(message));
        }
    }
    let centre = given.position.unwrap_or_default();
    let points = at.field("points");
    let point = |(name, place): (&String, &[f64; 3])| {
        let at = points.field(name);
        place.iter().enumerate().try_for_each(|(axis, value)| at.index(axis).finite(*value).map(drop))?;
        Ok((name.clone(), std::array::from_fn(|axis| place[axis] - centre[axis])))
    };
    Ok(Housing {
        name: given.name.clone(),
        mass: mass(given.mass, at)?,
        inertia: given.inertia,
        centre,
        stiffness: checked(given.stiffness, &at.field("stiffness"))?,
        damping: given.damping.map_or(Ok([[0.0; 2]; 2]), |damping| checked(damping, &at.field("damping")))?,
        axial: axial([given.axial_stiffness, given.axial_damping], at)?,
        rotational_stiffness: given.rotational_stiffness.unwrap_or_default(),
        rotational_damping: given.rotational_damping.unwrap_or_default(),
        loss_factor: at.field("loss_factor").non_negative(given.loss_factor.unwrap_or(0.0))?,
        points: given.points.iter().map(point).collect::<Result<_, _>>()?,
        elastic: given.elastic.as_ref().map(|elastic| checked_body(elastic, &at.field("elastic"))).transpose()?,
        ..Housing::default()
    })
}

/// Checks the modes of an elastic housing.
fn checked_body(given: &ElasticBody, at: &EntryPath) -> Result<ElasticBody, SceneError> {
    let count = given.frequencies.len();
    let each = |name: &str, values: &[f64], check: fn(&EntryPath, f64) -> Result<f64, SceneError>| {
        let at = at.field(name);
        if values.len() != count {
            return Err(at.error(format!("must have one number for each of {count} modes, got {}", values.len())));
        }
        values.iter().enumerate().try_for_each(|(mode, value)| check(&at.index(mode), *value).map(drop))
    };
    each("frequencies", &given.frequencies, |at, value| at.non_negative(value))?;
    each("damping_ratios", &given.damping_ratios, |at, value| at.non_negative(value))?;
    given.translation.iter().flatten().try_for_each(|row| each("translation", row, |at, value| at.finite(value)))?;
    if let Some(radiation) = &given.radiation {
        let at = at.field("radiation");
        if radiation.len() != count {
            return Err(at.error(format!("must have one row for each of {count} modes, got {}", radiation.len())));
        }
        radiation.iter().try_for_each(|row| each("radiation", row, |at, value| at.finite(value)))?;
    }
    for (name, interface) in &given.interfaces {
        let path = format!("interfaces.{name}");
        interface.position.iter().try_for_each(|value| at.field(&path).finite(*value).map(drop))?;
        interface.rows.iter().try_for_each(|row| each(&path, row, |at, value| at.finite(value)))?;
        let mount = interface.stiffness.iter().chain(&interface.damping).flatten();
        mount.copied().try_for_each(|value| at.field(&path).non_negative(value).map(drop))?;
    }
    Ok(given.clone())
}

/// Stiffness and damping along the axis; `None` without a stiffness.
fn axial([stiffness, damping]: [Option<f64>; 2], at: &EntryPath) -> Result<Option<[f64; 2]>, SceneError> {
    let at_damping = at.field("axial_damping");
    let damping = at_damping.non_negative(damping.unwrap_or(0.0))?;
    match stiffness {
        Some(stiffness) => Ok(Some([at.field("axial_stiffness").non_negative(stiffness)?, damping])),
        None if damping > 0.0 => {
            Err(at_damping.error("acts on axial motion, which needs axial_stiffness; give one, 0 for no spring"))
        }
        None => Ok(None),
    }
}

fn mass(given: f64, at: &EntryPath) -> Result<f64, SceneError> {
    let at = at.field("mass");
    if at.finite(given)? > 0.0 {
        return Ok(given);
    }
    Err(at.error(format!(
        "must be positive, got {given}; for a support without mass, combine its stiffness with that of the bearing: k = 1/(1/k_bearing + 1/k_support)"
    )))
}
