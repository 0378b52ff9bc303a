//! Train of the benchmarks: three shafts, two meshes, six bearings, balanced torques.
#![allow(dead_code, clippy::unwrap_used, reason = "each benchmark uses a part of this file, and the scenes are valid")]

use gearbow::analysis::simulate::System;
use gearbow::integrate::{Halt, Observer, Trajectory};
use gearbow::mesh::Geometry;
use gearbow::model::Model;
use gearbow::motion::EquationOfMotion;
use gearbow::scene::description::{Stiffness, StiffnessKind, StiffnessModel};
use gearbow::scene::{Scene, SceneDescription};
use nalgebra::DVector;

/// Speed of the reference shaft, rad/s.
pub const SPEED: f64 = 100.0;

/// The train with `elements` per shaft; bow and unbalance if `excited`.
pub fn system(elements: usize, excited: bool) -> SceneDescription {
    // Gears are placed at existing nodes, so that they add none.
    let at = |part: usize| 0.5 * part as f64 / elements as f64;
    let (middle, third) = (elements / 2, elements / 3);
    let bow = if excited { ", bow = { shape = \"half_sine\", amplitude = 1.5e-4 }" } else { "" };
    let unbalance = if excited { ", unbalance = 1e-4" } else { "" };
    let mut text = String::from("shafts = [\n");
    for name in ["input", "middle", "output"] {
        text += &format!("{{ name = \"{name}\", length = 0.5, outer_diameter = 0.05, elements = {elements}{bow} }},\n");
    }
    text += "]\ngears = [\n";
    let gears = [
        ("g1", "input", middle, 25),
        ("g2", "middle", third, 50),
        ("g3", "middle", elements - third, 25),
        ("g4", "output", middle, 50),
    ];
    for (name, shaft, part, teeth) in gears {
        text += &format!(
            "{{ name = \"{name}\", shaft = \"{shaft}\", position = {}, teeth = {teeth}, module = 3e-3, face_width = 0.03{unbalance} }},\n",
            at(part)
        );
    }
    text += "]\nbearings = [\n";
    for name in ["input", "middle", "output"] {
        for x in [0.0, 0.5] {
            text += &format!("{{ shaft = \"{name}\", position = {x:?}, stiffness = 1e8, damping = 500.0 }},\n");
        }
    }
    text += r#"]
    meshes = [
        { driver = "g1", driven = "g2", stiffness = 2e8, damping_ratio = 0.05 },
        { driver = "g3", driven = "g4", stiffness = 2e8, damping_ratio = 0.05 },
    ]
    torques = [{ at = "g1", value = 250.0 }, { at = "g4", balance = true }]
    "#;
    SceneDescription::from_toml(&text).unwrap()
}

/// The helical gearbox of docs/gearbox.md on rolling and journal bearings, with the smallest number of elements, and films
/// in closed form: preparation then takes a small part of a counted run.
pub fn gearbox() -> SceneDescription {
    let text = include_str!("../gearbox.toml").replace("film = \"finite\"", "film = \"short\"");
    let mut system = SceneDescription::from_toml(&text).unwrap();
    system.accuracy = None;
    for shaft in &mut system.shafts {
        shaft.degree = Some(1);
        if shaft.segments.is_none() {
            shaft.elements = Some(1);
        }
        for segment in shaft.segments.iter_mut().flatten() {
            segment.elements = Some(1);
        }
    }
    system
}

/// Gives every mesh a stiffness model of tooth pairs with the same mean stiffness.
pub fn set_teeth(system: &mut SceneDescription, kind: StiffnessKind) {
    for mesh in &mut system.meshes {
        let model = StiffnessModel { mean: Some(2e8), ..StiffnessModel::of(kind) };
        mesh.stiffness = Some(Stiffness::Model(model));
    }
}

/// Model of a description, with nothing cached.
pub fn cached_from(system: &SceneDescription) -> System {
    System::new(Model::new(Scene::new(system).unwrap()).unwrap())
}

/// Model of the train, with nothing cached.
pub fn cached(elements: usize, excited: bool) -> System {
    let cached = cached_from(&system(elements, excited));
    assert_eq!(cached.model.len(), 15 * (elements + 1));
    cached
}

/// Equation of motion with a small state, so that flanks stay in contact and run time does not depend on the state.
pub fn motion(cached: &System, geometry: Geometry, speed: f64) -> (EquationOfMotion<'_>, Vec<f64>) {
    let n = cached.model.len();
    let y = (0..2 * n).map(|i| 1e-7 * (0.7 * i as f64).sin()).collect();
    (EquationOfMotion::new(cached, geometry, speed, 0.0, DVector::zeros(n)).unwrap(), y)
}

/// Observer that ignores all steps and never stops a run.
pub struct NoObserver;

impl Observer for NoObserver {
    fn next(&self) -> Option<f64> {
        None
    }

    fn observe(&mut self, _motion: &mut impl Trajectory, _end: f64) -> Result<(), Halt> {
        Ok(())
    }

    fn continues(&mut self, _elapsed: f64) -> bool {
        true
    }
}
