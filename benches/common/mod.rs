//! The train that is measured: three shafts, two meshes, six bearings, torque in balance.
#![allow(
    dead_code,
    clippy::unwrap_used,
    reason = "each benchmark uses a part of this; the scenes are known to be right"
)]

use gearbow::integrate::{Halt, Observer, Trajectory};
use gearbow::mesh::Geometry;
use gearbow::modal::CachedModel;
use gearbow::model::Model;
use gearbow::motion::EquationOfMotion;
use gearbow::scene::description::{Stiffness, StiffnessKind, StiffnessModel};
use gearbow::scene::{Scene, SceneDescription};
use nalgebra::DVector;

/// Of the reference shaft, rad/s.
pub const SPEED: f64 = 100.0;

/// The train with so many elements a shaft, with bow and unbalance or without.
pub fn system(elements: usize, excited: bool) -> SceneDescription {
    // Gears stand at nodes that are there anyway, so that none is added.
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

/// Makes every mesh one of tooth pairs with the same mean stiffness.
pub fn set_teeth(system: &mut SceneDescription, kind: StiffnessKind) {
    for mesh in &mut system.meshes {
        let model = StiffnessModel { mean: Some(2e8), ..StiffnessModel::of(kind) };
        mesh.stiffness = Some(Stiffness::Model(model));
    }
}

/// The basis of a description.
pub fn basis_of(system: &SceneDescription) -> CachedModel {
    CachedModel::new(Model::new(Scene::new(system).unwrap()).unwrap())
}

/// The basis of the train.
pub fn cached(elements: usize, excited: bool) -> CachedModel {
    let cached = basis_of(&system(elements, excited));
    assert_eq!(cached.model.len(), 15 * (elements + 1));
    cached
}

/// A motion with a state that is small, so that time does not depend on how it goes.
pub fn motion(cached: &CachedModel, geometry: Geometry, speed: f64) -> (EquationOfMotion<'_>, Vec<f64>) {
    let n = cached.model.len();
    let y = (0..2 * n).map(|i| 1e-7 * (0.7 * i as f64).sin()).collect();
    (EquationOfMotion::new(cached, geometry, speed, 0.0, DVector::zeros(n)).unwrap(), y)
}

/// Sees nothing, and never stops a run.
pub struct Nobody;

impl Observer for Nobody {
    fn next(&self) -> Option<f64> {
        None
    }

    fn observe(&mut self, _motion: &mut impl Trajectory, _end: f64) -> Result<(), Halt> {
        Ok(())
    }

    fn go_on(&mut self, _elapsed: f64) -> bool {
        true
    }
}
