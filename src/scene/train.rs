//! Speed ratios of the shafts and the balance of the torques.
//!
//! Meshes and couplings connect the shafts. A coupling joins shafts of one speed. A shaft without such a connection to the
//! reference shaft has a speed ratio of its own. A mesh on a carrier that turns relates three speeds (Willis 1841), and two meshes of
//! one planet relate those of sun, ring and carrier.

use super::description::{SceneDescription, TorqueValue};
use super::place::Names;
use super::{Coupling, EntryPath, Gear, Mesh, Scene, SceneError, Shaft, Torque};
use crate::numerics::EQUALITY_TOLERANCE;

/// Signed speed of each shaft relative to the reference shaft. Each external mesh multiplies it, relative to the carrier, by
/// −z_a/z_b, each mesh with an internal gear by z_a/z_b.
pub(super) fn speed_ratios(system: &SceneDescription, names: &Names, train: Train<'_>) -> Result<Vec<f64>, SceneError> {
    let Train { gears, meshes, couplings } = train;
    let reference = reference(system, names)?;
    let teeth = |gear: usize| gears[gear].sign() * f64::from(gears[gear].teeth);
    let relations = relations(train, teeth);
    let mut ratios = vec![None; system.shafts.len()];
    connect(&mut ratios, Known { shaft: reference, ratio: 1.0 }, &relations);
    for (shaft, given) in system.shafts.iter().enumerate() {
        if let Some(ratio) = given.speed_ratio {
            let entry = EntryPath::entry("shafts", shaft);
            check_ratio(ratio, ratios[shaft], train.is_in_stage(shaft), &entry.field("speed_ratio"))?;
            connect(&mut ratios, Known { shaft, ratio }, &relations);
        }
    }
    let of = |shaft: usize| {
        let name = |shaft: usize| &system.shafts[shaft].name;
        ratios[shaft].ok_or_else(|| {
            let message = format!(
                "no mesh or coupling connects \"{}\" to the reference shaft \"{}\", so its speed is unknown; for a shaft with a drive of its own give speed_ratio=, its speed over that of the reference shaft{}",
                name(shaft),
                name(reference),
                if train.is_in_stage(shaft) { "; of sun, ring and carrier of a planetary stage two speeds must be known, and a ring or a sun at rest has speed_ratio=0" } else { "" }
            );
            EntryPath::entry("shafts", shaft).error(message)
        })
    };
    let ratios = (0..system.shafts.len()).map(of).collect::<Result<Vec<_>, _>>()?;
    for (index, mesh) in meshes.iter().enumerate() {
        let b = gears[mesh.driven].body.node.shaft;
        let expected = Relation::of_mesh(mesh, gears, teeth).solve(1, |shaft| ratios[shaft]);
        let carrier = mesh.carrier.map_or(0.0, |node| ratios[node.shaft]);
        if (expected - ratios[b]).abs() > EQUALITY_TOLERANCE * expected.abs().max(carrier.abs()) {
            let message = format!(
                "closes a loop that cannot rotate: it gives shaft \"{}\" the speed ratio {expected}, the other meshes give {}",
                system.shafts[b].name, ratios[b]
            );
            return Err(EntryPath::entry("meshes", index).error(message));
        }
    }
    for (index, Coupling { hubs: [a, b], .. }) in couplings.iter().enumerate() {
        let [first, second] = [ratios[a.shaft], ratios[b.shaft]];
        if (first - second).abs() > EQUALITY_TOLERANCE * first.abs() {
            let [a, b] = [a, b].map(|hub| &system.shafts[hub.shaft].name);
            let message = format!(
                "joins \"{a}\" and \"{b}\", whose speed ratios are {first} and {second}; a coupling needs shafts of one speed"
            );
            return Err(EntryPath::entry("couplings", index).error(message));
        }
    }
    Ok(ratios)
}

/// Refuses a given speed ratio that differs from that of meshes and couplings, or is 0 for a shaft outside planetary stages.
fn check_ratio(given: f64, connected: Option<f64>, in_stage: bool, at: &EntryPath) -> Result<(), SceneError> {
    if at.finite(given)? == 0.0 && !in_stage {
        return Err(at.error("must not be 0; what stands still is a support or housing"));
    }
    match connected {
        Some(ratio) if (ratio - given).abs() > EQUALITY_TOLERANCE * ratio.abs().max(given.abs()) => {
            Err(at.error(format!("is {ratio} by the meshes and couplings of the shaft, got {given}; remove it")))
        }
        Some(_) | None => Ok(()),
    }
}

/// All torques, with the values of the torques that balance the others: one for all shafts that meshes and couplings connect.
///
/// Balanced torques do no work on the rigid-body rotation, which does not deflect any mesh. That rotation follows from
/// the base radii, which published data may round differently from the tooth numbers.
pub(super) fn torques(
    system: &SceneDescription,
    names: &Names,
    shafts: &[Shaft],
    train: Train<'_>,
) -> Result<Vec<Torque>, SceneError> {
    let rotation_with = |shaft: usize| rotations_by_radius(shafts, shaft, train);
    let mut torques: Vec<Torque> = Vec::with_capacity(system.torques.len());
    let mut balances: Vec<usize> = Vec::new();
    for (index, given) in system.torques.iter().enumerate() {
        let at = EntryPath::entry("torques", index);
        let node = names.place(shafts, &given.at, &at.field("at"))?;
        let value = match (&given.value, given.balance) {
            (Some(TorqueValue::Constant(value)), false) => at.field("value").finite(*value)?,
            (Some(_), false) => {
                if let Some(balance) = system.torques.iter().position(|torque| torque.balance) {
                    let message = format!(
                        "torques[{index}] depends on time or speed, which a constant torque cannot balance; hold the rotation with gb.Drive(at, stiffness=...) instead"
                    );
                    return Err(EntryPath::entry("torques", balance).error(message));
                }
                0.0
            }
            (None, true) => {
                if shafts[node.shaft].is_at_rest() {
                    return Err(at.error(format!(
                        "\"{}\" does not turn, so that a torque there has no power to balance; its drive holds it, and a member that turns takes the balancing torque",
                        shafts[node.shaft].name
                    )));
                }
                let rotation = rotation_with(node.shaft);
                if let Some(first) = balances.iter().find(|first| rotation[torques[**first].node.shaft].is_some()) {
                    return Err(at.error(format!("torques[{first}] is a balancing torque too; only one is possible")));
                }
                balances.push(index);
                0.0
            }
            _ => return Err(at.error("needs a value, or balance = true")),
        };
        torques.push(Torque { node, value });
    }
    for index in balances {
        let rotation = rotation_with(torques[index].node.shaft);
        let powers = torques.iter().map(|torque| torque.value * rotation[torque.node.shaft].unwrap_or(0.0));
        torques[index].value = -powers.sum::<f64>();
    }
    Ok(torques)
}

fn reference(system: &SceneDescription, names: &Names) -> Result<usize, SceneError> {
    system.reference.as_ref().map_or(Ok(0), |name| names.shaft(name, &EntryPath::root("reference")))
}

/// What connects shafts to each other.
#[derive(Clone, Copy)]
pub(super) struct Train<'a> {
    pub gears: &'a [Gear],
    pub meshes: &'a [Mesh],
    pub couplings: &'a [Coupling],
}

impl Train<'_> {
    /// Whether a shaft carries a gear or the carrier of a planetary stage whose carrier turns.
    fn is_in_stage(&self, shaft: usize) -> bool {
        let has = |mesh: &Mesh| {
            let of_gears = [mesh.driver, mesh.driven].map(|gear| self.gears[gear].body.node.shaft);
            mesh.carrier.is_some_and(|node| node.shaft == shaft || of_gears.contains(&shaft))
        };
        self.meshes.iter().any(has)
    }
}

impl Scene {
    /// Relations Σ c Ω = 0 between the speeds of shafts, in whole numbers: pairs (shaft, c).
    pub fn speed_relations(&self) -> Vec<Vec<(usize, i128)>> {
        let train = Train { gears: &self.gears, meshes: &self.meshes, couplings: &self.couplings };
        let relations = relations(train, |gear| self.gears[gear].sign() * f64::from(self.gears[gear].teeth));
        let whole = |(shaft, factor): (usize, f64)| (shaft, factor as i128);
        relations.into_iter().map(|relation| relation.0.into_iter().map(whole).collect()).collect()
    }

    /// Rotation of each shaft in the rigid-body rotation that turns shaft `start` by 1: zero for shafts that couplings without
    /// torsional stiffness separate from it. It follows from the base radii, so that no mesh is deflected.
    pub(crate) fn rotations_with(&self, start: usize) -> Vec<f64> {
        let is_stiff = |coupling: &&Coupling| coupling.torsional.stiffness > 0.0;
        let couplings: Vec<Coupling> = self.couplings.iter().filter(is_stiff).copied().collect();
        let train = Train { gears: &self.gears, meshes: &self.meshes, couplings: &couplings };
        let rotations = rotations_by_radius(&self.shafts, start, train);
        rotations.into_iter().map(Option::unwrap_or_default).collect()
    }
}

/// Rotation of each shaft in the rigid-body rotation that turns shaft `start` by 1; None if nothing connects them. Shafts with the
/// speed ratio 0 are at rest.
fn rotations_by_radius(shafts: &[Shaft], start: usize, train: Train<'_>) -> Vec<Option<f64>> {
    let relations = relations(train, |gear| train.gears[gear].sign() * train.gears[gear].base_radius);
    let mut rotations = vec![None; shafts.len()];
    for shaft in (0..shafts.len()).filter(|shaft| *shaft != start && shafts[*shaft].is_at_rest()) {
        rotations[shaft] = Some(0.0);
    }
    connect(&mut rotations, Known { shaft: start, ratio: 1.0 }, &relations);
    rotations
}

/// A shaft with a known speed ratio.
struct Known {
    shaft: usize,
    ratio: f64,
}

/// Speeds Ω of two or three shafts with Σ c Ω = 0: pairs (shaft, c).
struct Relation(Vec<(usize, f64)>);

impl Relation {
    /// That of a mesh, z_a (Ω_a − Ω_c) + z_b (Ω_b − Ω_c) = 0 with the speed Ω_c of its carrier. `size` of a gear is its number of
    /// teeth or its base radius, negative for an internal gear.
    fn of_mesh(mesh: &Mesh, gears: &[Gear], size: impl Fn(usize) -> f64) -> Self {
        let [a, b] = [mesh.driver, mesh.driven].map(|gear| (gears[gear].body.node.shaft, size(gear)));
        let carrier = mesh.carrier.map(|node| (node.shaft, -(a.1 + b.1)));
        Self([a, b].into_iter().chain(carrier).collect())
    }

    /// The speed of the shaft of an entry from those of the others.
    fn solve(&self, entry: usize, speed: impl Fn(usize) -> f64) -> f64 {
        let others = self.0.iter().enumerate().filter(|(other, _)| *other != entry);
        let sum: f64 = others.map(|(_, (shaft, factor))| -speed(*shaft) * factor).sum();
        sum / self.0[entry].1
    }
}

/// All relations between the speeds of shafts: those of meshes, then those of two meshes of one planet without the planet, then
/// those of couplings.
fn relations(Train { gears, meshes, couplings }: Train<'_>, size: impl Fn(usize) -> f64) -> Vec<Relation> {
    let mut found: Vec<Relation> = meshes.iter().map(|mesh| Relation::of_mesh(mesh, gears, &size)).collect();
    let ends = |mesh: &Mesh| [(mesh.driver, mesh.driven), (mesh.driven, mesh.driver)];
    for (index, first) in meshes.iter().enumerate() {
        let Some(carrier) = first.carrier else { continue };
        for second in
            meshes[index + 1..].iter().filter(|other| other.carrier.is_some_and(|node| node.shaft == carrier.shaft))
        {
            for (outer, planet) in ends(first) {
                for (other, shared) in ends(second) {
                    // Gears on one shaft have one speed: a planet may consist of two gears.
                    if gears[planet].body.node.shaft != gears[shared].body.node.shaft || outer == other {
                        continue;
                    }
                    let (x, y) = (size(outer) * size(shared), -size(other) * size(planet));
                    let shaft = |gear: usize| gears[gear].body.node.shaft;
                    found.push(Relation(vec![(shaft(outer), x), (shaft(other), y), (carrier.shaft, -(x + y))]));
                }
            }
        }
    }
    found.extend(couplings.iter().map(|Coupling { hubs: [a, b], .. }| Relation(vec![(a.shaft, 1.0), (b.shaft, -1.0)])));
    found
}

/// Sets the speed ratio of a shaft, and all that follow from the known ones.
fn connect(ratios: &mut [Option<f64>], Known { shaft, ratio }: Known, relations: &[Relation]) {
    ratios[shaft] = Some(ratio);
    // Repeated passes in the order of the description, so that the last mesh of a loop closes it.
    loop {
        let mut found = false;
        for relation in relations {
            let mut unknown = (0..relation.0.len()).filter(|entry| ratios[relation.0[*entry].0].is_none());
            if let (Some(entry), None) = (unknown.next(), unknown.next()) {
                ratios[relation.0[entry].0] = Some(relation.solve(entry, |shaft| ratios[shaft].unwrap_or_default()));
                found = true;
            }
        }
        if !found {
            return;
        }
    }
}
