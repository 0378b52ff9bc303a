//! Speed ratios of the shafts and the balance of the torques.
//!
//! Meshes and couplings connect the shafts. A coupling joins shafts of one speed. A shaft without such a connection to the
//! reference shaft has a speed ratio of its own.

use super::description::{SceneDescription, TorqueValue};
use super::place::Names;
use super::{Coupling, EntryPath, Gear, Mesh, Scene, SceneError, Shaft, Torque};
use crate::numerics::EQUALITY_TOLERANCE;

/// Signed speed of each shaft relative to the reference shaft. Each external mesh multiplies it by −z_a/z_b, each mesh with an
/// internal gear by z_a/z_b.
pub(super) fn speed_ratios(system: &SceneDescription, names: &Names, train: Train<'_>) -> Result<Vec<f64>, SceneError> {
    let Train { gears, meshes, couplings } = train;
    let reference = reference(system, names)?;
    let teeth = |gear: usize| gears[gear].sign() * f64::from(gears[gear].teeth);
    let mut ratios = vec![None; system.shafts.len()];
    connect(&mut ratios, Known { shaft: reference, ratio: 1.0 }, train, teeth);
    for (shaft, given) in system.shafts.iter().enumerate() {
        if let Some(ratio) = given.speed_ratio {
            let entry = EntryPath::entry("shafts", shaft);
            check_ratio(ratio, ratios[shaft], &entry.field("speed_ratio"))?;
            connect(&mut ratios, Known { shaft, ratio }, train, teeth);
        }
    }
    let of = |shaft: usize| {
        let name = |shaft: usize| &system.shafts[shaft].name;
        ratios[shaft].ok_or_else(|| {
            let message = format!(
                "no mesh or coupling connects \"{}\" to the reference shaft \"{}\", so its speed is unknown; for a shaft with a drive of its own give speed_ratio=, its speed over that of the reference shaft",
                name(shaft),
                name(reference)
            );
            EntryPath::entry("shafts", shaft).error(message)
        })
    };
    let ratios = (0..system.shafts.len()).map(of).collect::<Result<Vec<_>, _>>()?;
    for (index, mesh) in meshes.iter().enumerate() {
        let (a, b) = (gears[mesh.driver].body.node.shaft, gears[mesh.driven].body.node.shaft);
        let expected = -ratios[a] * teeth(mesh.driver) / teeth(mesh.driven);
        if (expected - ratios[b]).abs() > EQUALITY_TOLERANCE * expected.abs() {
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

/// Refuses a given speed ratio that is 0 or differs from that of meshes and couplings.
fn check_ratio(given: f64, connected: Option<f64>, at: &EntryPath) -> Result<(), SceneError> {
    if at.finite(given)? == 0.0 {
        return Err(at.error("must not be 0; what stands still is a support or housing"));
    }
    match connected {
        Some(ratio) if (ratio - given).abs() > EQUALITY_TOLERANCE * ratio.abs() => {
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
    let rotation_with = |shaft: usize| rotations_by_radius(shafts.len(), shaft, train);
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

impl Scene {
    /// Rotation of each shaft in the rigid-body rotation that turns shaft `start` by 1: zero for shafts that couplings without
    /// torsional stiffness separate from it. It follows from the base radii, so that no mesh is deflected.
    pub(crate) fn rotations_with(&self, start: usize) -> Vec<f64> {
        let is_stiff = |coupling: &&Coupling| coupling.torsional.stiffness > 0.0;
        let couplings: Vec<Coupling> = self.couplings.iter().filter(is_stiff).copied().collect();
        let train = Train { gears: &self.gears, meshes: &self.meshes, couplings: &couplings };
        let rotations = rotations_by_radius(self.shafts.len(), start, train);
        rotations.into_iter().map(Option::unwrap_or_default).collect()
    }
}

/// Rotation of each shaft in the rigid-body rotation that turns shaft `start` by 1; None if nothing connects them.
fn rotations_by_radius(shafts: usize, start: usize, train: Train<'_>) -> Vec<Option<f64>> {
    let mut rotations = vec![None; shafts];
    connect(&mut rotations, Known { shaft: start, ratio: 1.0 }, train, |gear| {
        train.gears[gear].sign() * train.gears[gear].base_radius
    });
    rotations
}

/// A shaft with a known speed ratio.
struct Known {
    shaft: usize,
    ratio: f64,
}

/// Sets the speed ratios of a shaft and of all shafts that meshes and couplings connect to it. `size` of a gear is its number of
/// teeth or its base radius, negative for an internal gear.
fn connect(
    ratios: &mut [Option<f64>],
    Known { shaft, ratio }: Known,
    Train { gears, meshes, couplings }: Train<'_>,
    size: impl Fn(usize) -> f64,
) {
    ratios[shaft] = Some(ratio);
    // Repeated passes in the order of the description, so that the last mesh of a loop closes it.
    loop {
        let mut found = false;
        for mesh in meshes {
            for (from, to) in [(mesh.driver, mesh.driven), (mesh.driven, mesh.driver)] {
                let (here, next) = (gears[from].body.node.shaft, gears[to].body.node.shaft);
                if let (Some(ratio), None) = (ratios[here], ratios[next]) {
                    ratios[next] = Some(-ratio * size(from) / size(to));
                    found = true;
                }
            }
        }
        for Coupling { hubs: [a, b], .. } in couplings {
            for (here, next) in [(a.shaft, b.shaft), (b.shaft, a.shaft)] {
                if let (Some(ratio), None) = (ratios[here], ratios[next]) {
                    ratios[next] = Some(ratio);
                    found = true;
                }
            }
        }
        if !found {
            return;
        }
    }
}
