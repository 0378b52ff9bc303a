//! Elements of a system whose modes are too many to be examined together: those of its parts.
//!
//! A part is two shafts in mesh, each with the shafts that couplings or bearings join to it; or such shafts without a mesh. A step
//! of a mesh force excites modes of high frequency, which decide on the elements, near its gears. The modes of
//! low frequency, which extend over the train, need fewer elements. A shaft takes the finest elements that one of its parts needs.

use std::collections::{BTreeSet, HashMap, HashSet};

use super::{AnalysisError, Choice, Interrupt, Resolved, resolve};
use crate::scene::description::{Base, MotionKind, Place, Shaft, TorqueValue};
use crate::scene::{Scene, SceneDescription};

/// The elements of the parts of the description `given`, whose checked entries are those of `scene`. `None` if there is only one
/// part, or if a part cannot be analysed without the others.
///
/// # Errors
/// As [`resolve`].
pub(super) fn resolve_parts(
    given: &SceneDescription,
    scene: &Scene,
    interrupt: &Interrupt,
) -> Result<Option<Resolved>, AnalysisError> {
    let parts = parts(scene);
    if parts.len() < 2 {
        return Ok(None);
    }
    let mut description = given.clone();
    let mut total: Option<Choice> = None;
    // Long trains consist of few kinds of parts.
    let mut known: Vec<(SceneDescription, Resolved)> = Vec::new();
    for shafts in parts {
        let part = part(given, scene, &shafts);
        let place = match known.iter().position(|(other, _)| *other == part) {
            Some(place) => place,
            None => {
                let Ok(resolved) = resolve(&part, None, interrupt) else {
                    // The complete system reports what is wrong.
                    interrupt.check()?;
                    return Ok(None);
                };
                known.push((part, resolved));
                known.len() - 1
            }
        };
        let Resolved { description: part, choice, .. } = &known[place].1;
        for (index, shaft) in shafts.iter().zip(&part.shafts) {
            let current = &mut description.shafts[*index];
            if given.shafts[*index].is_automatic() && (current.is_automatic() || size(shaft) > size(current)) {
                (current.elements, current.degree) = (shaft.elements, shaft.degree);
                current.segments.clone_from(&shaft.segments);
            }
        }
        total = match (total, choice) {
            (Some(total), Some(choice)) => Some(Choice {
                expected_error: total.expected_error.max(choice.expected_error),
                highest_frequency: total.highest_frequency.min(choice.highest_frequency),
                ..total
            }),
            (total, choice) => total.or_else(|| choice.clone()),
        };
    }
    Ok(Some(Resolved { description, choice: total, probe: None }))
}

/// Number of elements of a shaft times their degree.
fn size(shaft: &Shaft) -> usize {
    let segments = shaft.segments.iter().flatten().map(|segment| segment.elements.unwrap_or(1));
    (shaft.elements.unwrap_or(0) + segments.sum::<usize>()) * shaft.degree.unwrap_or(1)
}

/// Indices of the shafts of each part, ascending.
fn parts(scene: &Scene) -> BTreeSet<Vec<usize>> {
    let couplings = scene.couplings.iter().map(|coupling| coupling.hubs.map(|hub| hub.shaft));
    let between = scene.bearings.iter().filter_map(|bearing| {
        let mut shafts = bearing.nodes().map(|node| node.shaft).filter(|shaft| *shaft < scene.shafts.len());
        Some([shafts.next()?, shafts.next()?])
    });
    // The first shaft of those that couplings and bearings join.
    let mut joined: Vec<usize> = (0..scene.shafts.len()).collect();
    for [a, b] in couplings.chain(between) {
        let (kept, replaced) = (joined[a].min(joined[b]), joined[a].max(joined[b]));
        joined.iter_mut().filter(|first| **first == replaced).for_each(|first| *first = kept);
    }
    let meshes = scene.meshes.iter().map(|mesh| {
        let of_gears = [mesh.driver, mesh.driven].map(|gear| scene.gears[gear].body.node.shaft);
        let nodes = of_gears.into_iter().chain(mesh.carrier.map(|node| node.shaft));
        nodes.map(|shaft| joined[shaft]).collect::<Vec<_>>()
    });
    let meshes: BTreeSet<Vec<usize>> = meshes.collect();
    let in_mesh: HashSet<usize> = meshes.iter().flatten().copied().collect();
    let alone = joined.iter().filter(|first| !in_mesh.contains(first)).map(|first| vec![*first]);
    let with = |group: Vec<usize>| (0..joined.len()).filter(|shaft| group.contains(&joined[*shaft])).collect();
    meshes.iter().cloned().chain(alone).map(with).collect()
}

/// The description of these shafts and of what acts on them. Shafts, bodies and bases have their numbers as names, so that equal
/// parts have equal descriptions.
fn part(given: &SceneDescription, scene: &Scene, shafts: &[usize]) -> SceneDescription {
    let numbered = shafts.iter().enumerate();
    let names: Names<'_> = numbered.map(|(i, shaft)| (given.shafts[*shaft].name.as_str(), i.to_string())).collect();
    let gears = given.gears.iter().map(|gear| (&gear.name, &gear.shaft));
    let bodies = gears.chain(given.disks.iter().map(|disk| (&disk.name, &disk.shaft)));
    let bodies = bodies.filter(|(_, shaft)| names.contains_key(shaft.as_str())).enumerate();
    let bodies: Names<'_> = bodies.map(|(i, (name, _))| (name.as_str(), format!("body {i}"))).collect();
    let rename_place = |place: &mut Place| match place {
        Place::Body(name) => rename(name, &bodies),
        Place::Shaft(shaft, _) => rename(shaft, &names),
    };
    let reference = shafts.iter().position(|shaft| scene.speed_ratios[*shaft] != 0.0).unwrap_or_default();
    let mut part = SceneDescription {
        reference: Some(reference.to_string()),
        motion: Some(match [scene.lateral, scene.torsion] {
            [true, false] => MotionKind::Lateral,
            [false, _] => MotionKind::Torsion,
            [true, true] => MotionKind::Coupled,
        }),
        shafts: shafts.iter().map(|index| given.shafts[*index].clone()).collect(),
        ..given.clone()
    };
    for (shaft, index) in part.shafts.iter_mut().zip(shafts) {
        rename(&mut shaft.name, &names);
        shaft.speed_ratio = Some(scene.speed_ratios[*index] / scene.speed_ratios[shafts[reference]]);
    }
    // A torque that balances others may stand outside, or balance others that do.
    for (torque, known) in part.torques.iter_mut().zip(&scene.torques).filter(|(torque, _)| torque.balance) {
        (torque.value, torque.balance) = (Some(TorqueValue::Constant(known.value)), false);
    }
    part.sleeves.retain_mut(|sleeve| rename(&mut sleeve.shaft, &names));
    part.gears.retain_mut(|gear| rename(&mut gear.name, &bodies) && rename(&mut gear.shaft, &names));
    part.disks.retain_mut(|disk| rename(&mut disk.name, &bodies) && rename(&mut disk.shaft, &names));
    part.meshes.retain_mut(|mesh| {
        let renamed = rename(&mut mesh.driver, &bodies) && rename(&mut mesh.driven, &bodies);
        renamed && mesh.carrier.as_mut().is_none_or(rename_place)
    });
    part.torques.retain_mut(|torque| rename_place(&mut torque.at));
    part.couplings.retain_mut(|coupling| rename_place(&mut coupling.a) && rename_place(&mut coupling.b));
    part.drives.retain_mut(|drive| rename_place(&mut drive.at));
    part.forces.retain_mut(|force| rename_place(&mut force.at));
    part.bearings.retain_mut(|bearing| rename(&mut bearing.shaft, &names));
    part.notches.clear();
    // The positions of interfaces are relative to the first shaft of the train: elastic housings count as ground.
    part.housings.retain(|housing| housing.elastic.is_none());
    let rigid: BTreeSet<&str> = part.housings.iter().map(|housing| housing.name.as_str()).collect();
    let listed: BTreeSet<&str> = part.supports.iter().filter_map(|support| support.name.as_deref()).collect();
    for bearing in &mut part.bearings {
        let is_elastic = match &bearing.support {
            Some(Base::Interface(..)) => true,
            Some(Base::Named(name)) => !rigid.contains(name.as_str()) && !listed.contains(name.as_str()),
            _ => false,
        };
        if is_elastic {
            bearing.support = None;
        }
    }
    let bases = part.bearings.iter().filter_map(|bearing| match &bearing.support {
        Some(Base::Named(name)) => Some(name.clone()),
        _ => None,
    });
    let bases: BTreeSet<String> = bases.collect();
    let bases: Names<'_> = bases.iter().enumerate().map(|(i, name)| (name.as_str(), format!("base {i}"))).collect();
    for bearing in &mut part.bearings {
        match &mut bearing.support {
            Some(Base::Shaft(name, _)) => rename(name, &names),
            Some(Base::Named(name)) => rename(name, &bases),
            Some(Base::Own(_) | Base::Interface(..)) | None => true,
        };
    }
    part.supports.retain_mut(|support| support.name.as_mut().is_some_and(|name| rename(name, &bases)));
    part.housings.retain_mut(|housing| rename(&mut housing.name, &bases));
    part
}

/// New names by the names that they replace.
type Names<'a> = HashMap<&'a str, String>;

/// Replaces a name; false if there is no new one.
fn rename(name: &mut String, names: &Names<'_>) -> bool {
    let new = names.get(name.as_str());
    if let Some(new) = new {
        name.clone_from(new);
    }
    new.is_some()
}
