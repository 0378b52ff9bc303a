//! Shared test helpers: the train of the documentation, and reproducible random numbers.
#![allow(dead_code, clippy::unwrap_used, clippy::expect_used, reason = "every test file uses a part of this one")]

pub mod particles;

use gearbow::analysis::simulate::System;
use gearbow::mesh::{GearMesh, Geometry, MeshCoordinates};
use gearbow::modal::CachedModel;
use gearbow::model::Model;
use gearbow::motion::EquationOfMotion;
use gearbow::scene::description::{Bow, BowShape, Coefficient, Complex, Gravity};
use gearbow::scene::{Scene, SceneDescription};
use nalgebra::DVector;
use num_complex::Complex64;
use proptest::test_runner::{Config, RngSeed};

/// `count` random cases, the same in every run. GEARBOW_CASES multiplies the number and selects new cases.
pub fn cases(count: u32) -> Config {
    let config = Config { failure_persistence: None, ..Config::with_cases(count) };
    match std::env::var("GEARBOW_CASES").ok().and_then(|times| times.parse::<u32>().ok()) {
        Some(times) => Config { cases: count * times, ..config },
        None => Config { rng_seed: RngSeed::Fixed(1), ..config },
    }
}

/// A double-stage train: three shafts on six bearings, two meshes, bow on two shafts, balanced torques.
pub const TRAIN: &str = r#"
shafts = [
    { name = "input", length = 0.5, outer_diameter = 0.05, elements = 4, bow = { shape = "half_sine", amplitude = 1.5e-4 } },
    { name = "middle", length = 0.5, outer_diameter = 0.05, elements = 4, bow = { shape = "half_sine", amplitude = 1.5e-4, phase = 0.7 } },
    { name = "output", length = 0.5, outer_diameter = 0.05, elements = 4 },
]
gears = [
    { name = "g1", shaft = "input", position = 0.25, teeth = 25, module = 3e-3, face_width = 0.03, unbalance = [1e-4, 5e-5] },
    { name = "g2", shaft = "middle", position = 0.125, teeth = 50, module = 3e-3, face_width = 0.03 },
    { name = "g3", shaft = "middle", position = 0.375, teeth = 25, module = 3e-3, face_width = 0.03 },
    { name = "g4", shaft = "output", position = 0.25, teeth = 50, module = 3e-3, face_width = 0.03 },
]
meshes = [
    { driver = "g1", driven = "g2", stiffness = 2e8, damping_ratio = 0.05 },
    { driver = "g3", driven = "g4", stiffness = 2e8, damping_ratio = 0.05, centre_line_angle = 0.6 },
]
bearings = [
    { shaft = "input", position = 0.0, stiffness = 1e8, damping = 500.0 },
    { shaft = "input", position = 0.5, stiffness = 1e8, damping = 500.0 },
    { shaft = "middle", position = 0.0, stiffness = 1e8, damping = 500.0 },
    { shaft = "middle", position = 0.5, stiffness = 1e8, damping = 500.0 },
    { shaft = "output", position = 0.0, stiffness = 1e8, damping = 500.0 },
    { shaft = "output", position = 0.5, stiffness = 1e8, damping = 500.0 },
]
torques = [{ at = "g1", value = 250.0 }, { at = "g4", balance = true }]
"#;

/// Indices of (v_a, w_a, v_b, w_b, θ_a, θ_b) of a single mesh.
pub const COORDINATES: MeshCoordinates =
    MeshCoordinates { translation: Some([0, 2]), axial: None, twist: [4, 5], carrier: None };

/// The scene of one mesh: `gears` gives the fields of the gears ga and gb, `mesh` those of the mesh.
pub fn scene_of_mesh(gears: [&str; 2], mesh: &str) -> Scene {
    let [a, b] = gears;
    let text = format!(
        r#"
        shafts = [
            {{ name = "a", length = 1.0, outer_diameter = 0.05, elements = 2 }},
            {{ name = "b", length = 1.0, outer_diameter = 0.05, elements = 2 }},
        ]
        gears = [
            {{ name = "ga", shaft = "a", position = 0.5, face_width = 0.03, {a} }},
            {{ name = "gb", shaft = "b", position = 0.5, face_width = 0.03, {b} }},
        ]
        meshes = [{{ driver = "ga", driven = "gb", {mesh} }}]
        "#
    );
    Scene::new(&SceneDescription::from_toml(&text).unwrap()).unwrap()
}

/// The same mesh with its own coordinates.
pub fn mesh(gears: [&str; 2], mesh: &str) -> GearMesh {
    let scene = scene_of_mesh(gears, mesh);
    GearMesh::new(&scene.meshes[0], &scene.gears, COORDINATES)
}

/// The description of the train.
pub fn train() -> SceneDescription {
    SceneDescription::from_toml(TRAIN).unwrap()
}

/// The train without bow, unbalance, torque and damping. Its energy is constant.
pub fn free_train() -> SceneDescription {
    let mut system = train();
    system.shafts.iter_mut().for_each(|shaft| shaft.bow = None);
    system.gears.iter_mut().for_each(|gear| gear.unbalance = None);
    system.meshes.iter_mut().for_each(|mesh| mesh.damping_ratio = None);
    system.bearings.iter_mut().for_each(|bearing| bearing.damping = None);
    system.torques.clear();
    system
}

/// The model of a description.
pub fn model(system: &SceneDescription) -> Model {
    Model::new(Scene::new(system).unwrap()).unwrap()
}

/// The cached model of a description.
pub fn cached(system: &SceneDescription) -> System {
    System::new(model(system))
}

/// A train with all scene features: cross-coupled bearings, gravity, both dampings, a tilted bow.
pub fn everything() -> SceneDescription {
    let mut system = train();
    system.bearings[1].stiffness = Some(Coefficient::Full([[1e8, 3e6], [-2e6, 7e7]]).into());
    system.bearings[1].damping = Some(Coefficient::Full([[500.0, -80.0], [60.0, 300.0]]).into());
    system.gravity = Some(Gravity::Vector([1.0, -9.0]));
    system.rayleigh = Some([20.0, 1e-6]);
    system.modal_damping = Some(0.01.into());
    system.gears[3].unbalance = Some(Complex::Pair([0.0, 2e-4]));
    system.shafts[2].bow = Some(points(vec![0.0, 0.2, 0.5], |x| Complex64::new(1e-4 + 3e-3 * x * x, -1e-3 * x)));
    system
}

/// The bow with the values of `curve` at `positions`.
pub fn points(positions: Vec<f64>, curve: impl Fn(f64) -> Complex64) -> Bow {
    let values: Vec<_> = positions.iter().map(|x| curve(*x)).collect();
    Bow {
        shape: BowShape::Points,
        amplitude: None,
        phase: None,
        number: None,
        amplitudes: Some(values.iter().map(|value| value.norm()).collect()),
        phases: Some(values.iter().map(|value| value.arg()).collect()),
        positions: Some(positions),
    }
}

/// The motion of a cached model. Tolerances are relative to the deviation from the zero state.
pub fn motion(cached: &CachedModel, geometry: Geometry, speed: f64, origin: f64) -> EquationOfMotion<'_> {
    EquationOfMotion::new(cached, geometry, speed, origin, DVector::zeros(cached.model.len())).unwrap()
}

/// Reproducible random numbers between −1 and 1 (SplitMix64 of Steele, Lea and Flood).
pub struct Noise(u64);

impl Noise {
    /// The sequence with the seed `seed`.
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// The next number.
    pub fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^= z >> 31;
        (z >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    /// The next `len` numbers, each times `size`.
    pub fn vector(&mut self, len: usize, size: f64) -> Vec<f64> {
        (0..len).map(|_| size * self.next()).collect()
    }
}

/// The largest absolute value.
pub fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |largest, value| value.abs().max(largest))
}
