//! Speed ratios of the shafts and the balance of the torques.
//!
//! Meshes and couplings connect the shafts. A coupling joins shafts of one speed.

use super::description::{SceneDescription, TorqueValue};
use super::place::Names;
use super::{Coupling, EntryPath, Gear, Mesh, Scene, SceneError, Shaft, Torque};
use crate::numerics::EQUALITY_TOLERANCE;

/// Signed speed of each shaft relative to the reference shaft. Each external mesh multiplies it by −z_a/z_b.
pub(super) fn speed_ratios(system: &SceneDescription, names: &Names, train: Train<'_>) -> Result<Vec<f64>, SceneError> {
    let Train { gears, meshes, couplings } = train;
    let reference = reference(system, names)?;
    let teeth = |gear: usize| f64::from(gears[gear].teeth);
    let ratios = ratios_by(system.shafts.len(), reference, train, teeth);
    let of = |shaft: usize| {
        let name = |shaft: usize| &system.shafts[shaft].name;
        ratios[shaft].ok_or_else(|| {
            let message = format!(
                "no mesh or coupling connects \"{}\" to the reference shaft \"{}\", so its speed is unknown",
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

/// All torques, with the value of the torque that balances the others.
///
/// Balanced torques do no work on the rigid-body rotation, which does not deflect any mesh. That rotation follows from
/// the base radii, which published data may round differently from the tooth numbers.
pub(super) fn torques(
    system: &SceneDescription,
    names: &Names,
    shafts: &[Shaft],
    train: Train<'_>,
) -> Result<Vec<Torque>, SceneError> {
    let radius = |gear: usize| train.gears[gear].base_radius;
    let rotation = ratios_by(shafts.len(), reference(system, names)?, train, radius);
    let mut torques: Vec<Torque> = Vec::with_capacity(system.torques.len());
    let mut balance: Option<usize> = None;
    let mut power = 0.0;
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
                if let Some(first) = balance.replace(index) {
                    return Err(at.error(format!("torques[{first}] is a balancing torque too; only one is possible")));
                }
                0.0
            }
            _ => return Err(at.error("needs a value, or balance = true")),
        };
        power += value * rotation[node.shaft].unwrap_or(0.0);
        torques.push(Torque { node, value });
    }
    if let Some(index) = balance {
        // `speed_ratios` has checked that meshes and couplings connect every shaft to the reference shaft.
        torques[index].value = -power / rotation[torques[index].node.shaft].unwrap_or(1.0);
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
        let ratios = ratios_by(self.shafts.len(), start, train, |gear| self.gears[gear].base_radius);
        ratios.into_iter().map(Option::unwrap_or_default).collect()
    }
}

/// Speed ratio of each shaft to shaft `start`; None if no meshes or couplings connect them. `size` of a gear is its number of teeth
/// or its base radius.
fn ratios_by(
    shafts: usize,
    start: usize,
    Train { gears, meshes, couplings }: Train<'_>,
    size: impl Fn(usize) -> f64,
) -> Vec<Option<f64>> {
    let mut ratios: Vec<Option<f64>> = vec![None; shafts];
    ratios[start] = Some(1.0);
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
            return ratios;
        }
    }
}
