//! Names of shafts, gears and disks, and the positions on shafts that need a node.

use std::borrow::Cow;
use std::collections::HashMap;

use super::description::{Base, Place, SceneDescription, Support};
use super::shaft::Station;
use super::{EntryPath, Node, SceneError, Shaft, nearest};

/// Characters that separate the names of a mesh, "driver/driven", and the kind of a recorded item, "bearing:shaft".
const NAME_SEPARATORS: [char; 2] = ['/', ':'];

/// A name, with the list, index and field of its entry.
struct NamePlace<'a> {
    list: &'static str,
    index: usize,
    field: Cow<'static, str>,
    name: &'a str,
}

/// Characters that no font draws, or that break a line, a table or a file: control characters, and the noncharacters U+FFFE and
/// U+FFFF, which XML forbids.
fn is_forbidden(sign: char) -> bool {
    sign.is_control() || matches!(sign, '\u{fffe}' | '\u{ffff}')
}

/// The names of a description. Each name is unique, and contains no separator or forbidden character.
pub(super) struct Names<'a> {
    shafts: HashMap<&'a str, usize>,
    bodies: HashMap<&'a str, (&'a str, f64)>,
}

impl<'a> Names<'a> {
    pub(super) fn new(system: &'a SceneDescription) -> Result<Self, SceneError> {
        let shafts = system.shafts.iter().enumerate().map(|(index, shaft)| ("shafts", index, shaft.name.as_str()));
        let bodies = bodies(system).map(|body| (body.list, body.index, body.name));
        let lists = shafts.chain(bodies);
        let lists = lists.map(|(list, index, name)| NamePlace { list, index, field: Cow::Borrowed("name"), name });
        let mut used: HashMap<&str, NamePlace> = HashMap::new();
        for place in lists.chain(housing_names(system)) {
            let field = |message: String| EntryPath::entry(place.list, place.index).field(&place.field).error(message);
            if place.name.is_empty() {
                return Err(field("must not be empty".to_owned()));
            }
            if let Some(sign) = place.name.chars().find(|sign| NAME_SEPARATORS.contains(sign)) {
                let (name, other) = (place.name, place.name.replace(NAME_SEPARATORS, "-"));
                return Err(field(format!(
                    "must not contain \"{sign}\", got \"{name}\"; texts such as \"driver/driven\" join names with it, so write \"{other}\""
                )));
            }
            if let Some(sign) = place.name.chars().find(|&sign| is_forbidden(sign)) {
                let (name, at) = (place.name, place.field.escape_debug().to_string());
                return Err(EntryPath::entry(place.list, place.index).field(&at).error(format!(
                    "must not contain the character U+{:04X}, got {name:?}; use letters, digits, signs and spaces",
                    u32::from(sign)
                )));
            }
            if let Some(NamePlace { list, index, field: part, name }) = used.get(place.name) {
                let first = EntryPath::entry(list, *index);
                let first = if part == "name" { first.to_string() } else { first.field(part).to_string() };
                return Err(field(format!("{first} has the name \"{name}\" too; names must be unique")));
            }
            used.insert(place.name, place);
        }
        Ok(Self {
            shafts: system.shafts.iter().enumerate().map(|(index, shaft)| (shaft.name.as_str(), index)).collect(),
            bodies: self::bodies(system).map(|body| (body.name, (body.shaft, body.position))).collect(),
        })
    }

    /// Finds a shaft by the name that the entry `at` contains.
    pub(super) fn shaft(&self, name: &str, at: &EntryPath) -> Result<usize, SceneError> {
        self.shafts.get(name).copied().ok_or_else(|| {
            at.error(format!("no shaft is called \"{name}\"{}", nearest(name, self.shafts.keys().copied())))
        })
    }

    /// The node at a position of [`Self::stations`].
    pub(super) fn node(
        &self,
        shafts: &[Shaft],
        shaft: &str,
        position: f64,
        at: &EntryPath,
    ) -> Result<Node, SceneError> {
        let shaft = self.shaft(shaft, &at.field("shaft"))?;
        let node = shafts[shaft]
            .node_at(position)
            .ok_or_else(|| at.field("position").error(format!("there is no node at {position} m")))?;
        Ok(Node { shaft, node })
    }

    /// The node at a gear, a disk or a position of a shaft, which the entry `at` contains.
    pub(super) fn place(&self, shafts: &[Shaft], place: &Place, at: &EntryPath) -> Result<Node, SceneError> {
        let (shaft, position) = self.shaft_and_position(place, at)?;
        let shaft = self.shaft(shaft, at)?;
        let node =
            shafts[shaft].node_at(position).ok_or_else(|| at.error(format!("there is no node at {position} m")))?;
        Ok(Node { shaft, node })
    }

    fn shaft_and_position<'b>(&'b self, place: &'b Place, at: &EntryPath) -> Result<(&'b str, f64), SceneError> {
        match place {
            Place::Shaft(shaft, position) => Ok((shaft, *position)),
            Place::Body(name) => self.bodies.get(name.as_str()).copied().ok_or_else(|| {
                let hint = if self.shafts.contains_key(name.as_str()) {
                    format!("; it is a shaft: write (\"{name}\", x) with the position x on it, m")
                } else {
                    nearest(name, self.bodies.keys().copied())
                };
                at.error(format!("no gear or disk is called \"{name}\"{hint}"))
            }),
        }
    }

    /// Positions that need a node, for every shaft.
    pub(super) fn stations(&self, system: &SceneDescription) -> Result<Vec<Vec<Station>>, SceneError> {
        let mut stations = vec![Vec::new(); system.shafts.len()];
        let bearings = system.bearings.iter().enumerate();
        let bearings = bearings.map(|(index, own)| ("bearings", index, own.shaft.as_str(), own.position));
        let lists = bodies(system).map(|body| (body.list, body.index, body.shaft, body.position)).chain(bearings);
        for (list, index, shaft, position) in lists {
            let shaft = self.shaft(shaft, &EntryPath::entry(list, index).field("shaft"))?;
            stations[shaft].push(Station { position, list, index, field: "position" });
        }
        for (index, bearing) in system.bearings.iter().enumerate() {
            if let Some(Base::Shaft(shaft, position)) = &bearing.support {
                let shaft = self.shaft(shaft, &EntryPath::entry("bearings", index).field("support"))?;
                stations[shaft].push(Station { position: *position, list: "bearings", index, field: "support" });
            }
        }
        for (index, sleeve) in system.sleeves.iter().enumerate() {
            let shaft = self.shaft(&sleeve.shaft, &EntryPath::entry("sleeves", index).field("shaft"))?;
            let ends = [(sleeve.begin, "begin"), (sleeve.end, "end")];
            stations[shaft].extend(ends.map(|(position, field)| Station { position, list: "sleeves", index, field }));
        }
        for (place, list, index, field) in places(system) {
            let entry = EntryPath::entry(list, index);
            let at = entry.field(field);
            let (shaft, position) = self.shaft_and_position(place, &at)?;
            stations[self.shaft(shaft, &at)?].push(Station { position, list, index, field });
        }
        Ok(stations)
    }
}

/// A gear or disk of a description.
struct BodyEntry<'a> {
    list: &'static str,
    index: usize,
    name: &'a str,
    shaft: &'a str,
    position: f64,
}

/// Gears, then disks.
fn bodies(system: &SceneDescription) -> impl Iterator<Item = BodyEntry<'_>> {
    let entry = |list, index, name, shaft, position| BodyEntry { list, index, name, shaft, position };
    let gears = system.gears.iter().enumerate();
    let gears = gears.map(move |(index, gear)| entry("gears", index, &*gear.name, &*gear.shaft, gear.position));
    let disks = system.disks.iter().enumerate();
    gears.chain(disks.map(move |(index, disk)| entry("disks", index, &disk.name, &disk.shaft, disk.position)))
}

/// Places of carriers, torques, drives, forces and couplings, with list, index and field of each.
fn places(system: &SceneDescription) -> impl Iterator<Item = (&Place, &'static str, usize, &'static str)> {
    let entry = |list: &'static str, field: &'static str| move |(index, place): (usize, _)| (place, list, index, field);
    let meshes = system.meshes.iter().enumerate();
    let carriers = meshes.filter_map(|(index, mesh)| Some((mesh.carrier.as_ref()?, "meshes", index, "carrier")));
    let torques = system.torques.iter().map(|torque| &torque.at).enumerate().map(entry("torques", "at"));
    let drives = system.drives.iter().map(|drive| &drive.at).enumerate().map(entry("drives", "at"));
    let forces = system.forces.iter().map(|force| &force.at).enumerate().map(entry("forces", "at"));
    let a = system.couplings.iter().map(|coupling| &coupling.a).enumerate().map(entry("couplings", "a"));
    let b = system.couplings.iter().map(|coupling| &coupling.b).enumerate().map(entry("couplings", "b"));
    carriers.chain(torques).chain(drives).chain(forces).chain(a).chain(b)
}

/// The supports of single bearings, with the index of the bearing.
pub(super) fn own_supports(system: &SceneDescription) -> impl Iterator<Item = (usize, &Support)> {
    system.bearings.iter().enumerate().filter_map(|(index, bearing)| match &bearing.support {
        Some(Base::Own(support)) => Some((index, support)),
        _ => None,
    })
}

/// Names of all supports, housings and points of housings.
fn housing_names(system: &SceneDescription) -> impl Iterator<Item = NamePlace<'_>> {
    let place = |list, index, field: &'static str, name| NamePlace { list, index, field: Cow::Borrowed(field), name };
    let listed = system.supports.iter().enumerate();
    let listed =
        listed.filter_map(move |(index, given)| Some(place("supports", index, "name", given.name.as_deref()?)));
    let own = own_supports(system)
        .filter_map(move |(index, given)| Some(place("bearings", index, "support.name", given.name.as_deref()?)));
    let rigid = system.housings.iter().enumerate().flat_map(move |(index, given)| {
        let points = given.points.keys().map(move |name| {
            let field = Cow::Owned(format!("points.{name}"));
            NamePlace { list: "housings", index, field, name }
        });
        let interfaces = given.elastic.iter().flat_map(|elastic| elastic.interfaces.keys());
        let interfaces = interfaces.map(move |name| {
            let field = Cow::Owned(format!("elastic.interfaces.{name}"));
            NamePlace { list: "housings", index, field, name }
        });
        std::iter::once(place("housings", index, "name", given.name.as_str())).chain(points).chain(interfaces)
    });
    listed.chain(rigid).chain(own)
}
