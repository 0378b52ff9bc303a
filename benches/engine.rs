//! What the engine costs: assembly, modes, one right-hand side, one step, one norm, against the size of a train.
//!
//! Three shafts of 4 to 41 nodes with five degrees of freedom each, two meshes, six bearings. `cargo bench` prints the
//! medians; a right-hand side must grow linearly with n, and what a scene leaves out must cost nothing.
#![allow(missing_docs, clippy::unwrap_used, reason = "criterion's macros, and scenes that are known to be right")]

mod common;

use std::hint::black_box;
use std::time::Duration;

use common::{Nobody, SPEED, basis_of, cached, motion, system};
use criterion::{BenchmarkGroup, BenchmarkId, Criterion, criterion_group, criterion_main, measurement::WallTime};
use gearbow::analysis::Spectrum;
use gearbow::integrate::tableau::{DORMAND_PRINCE, RK4, Tableau};
use gearbow::integrate::{FirstOrderSystem as _, RungeKutta, State, Statistics, StepControl, run};
use gearbow::mesh::Geometry;
use gearbow::modal;
use gearbow::model::Model;
use gearbow::motion::EquationOfMotion;
use gearbow::scene::Scene;
use gearbow::scene::description::StiffnessKind;

/// Elements of each shaft: 60, 135, 240 and 615 degrees of freedom.
const ELEMENTS: [usize; 4] = [3, 8, 15, 40];

/// Short samples: the whole takes three minutes at most.
fn group<'a>(criterion: &'a mut Criterion, name: &str) -> BenchmarkGroup<'a, WallTime> {
    let mut group = criterion.benchmark_group(name);
    group.sample_size(30).warm_up_time(Duration::from_millis(300)).measurement_time(Duration::from_secs(1));
    group
}

fn assembly(criterion: &mut Criterion) {
    let mut group = group(criterion, "assembly");
    for elements in ELEMENTS {
        let system = system(elements, true);
        group.bench_function(BenchmarkId::from_parameter(15 * (elements + 1)), |bencher| {
            bencher.iter(|| Model::new(Scene::new(black_box(&system)).unwrap()).unwrap());
        });
    }
}

fn real_modes(criterion: &mut Criterion) {
    let mut group = group(criterion, "real modes");
    group.sample_size(10);
    for elements in ELEMENTS {
        let fresh = || cached(elements, true);
        group.bench_function(BenchmarkId::from_parameter(15 * (elements + 1)), |bencher| {
            bencher.iter_with_setup(fresh, |cached| {
                cached.real_modes(SPEED).unwrap();
                cached
            });
        });
    }
}

fn damped_modes(criterion: &mut Criterion) {
    let mut group = group(criterion, "damped modes");
    group.sample_size(10);
    for elements in [3, 8] {
        let cached = cached(elements, true);
        cached.real_modes(SPEED).unwrap();
        group.bench_function(BenchmarkId::from_parameter(15 * (elements + 1)), |bencher| {
            bencher.iter(|| modal::modes(black_box(&cached), SPEED).unwrap());
        });
    }
}

fn right_hand_side(criterion: &mut Criterion) {
    let mut group = group(criterion, "right-hand side");
    let cases = [
        ("live", Geometry::Live, true, SPEED),
        ("frozen", Geometry::Frozen, true, SPEED),
        ("live, no bow", Geometry::Live, false, SPEED),
        ("live, no bow, no spin", Geometry::Live, false, 0.0),
    ];
    for (name, geometry, excited, speed) in cases {
        for elements in ELEMENTS {
            let cached = cached(elements, excited);
            let (mut motion, y) = motion(&cached, geometry, speed);
            let mut derivative = vec![0.0; y.len()];
            group.bench_function(BenchmarkId::new(name, 15 * (elements + 1)), |bencher| {
                bencher.iter(|| motion.derivative(black_box(1e-3), black_box(&y), &mut derivative).unwrap());
            });
        }
    }
}

fn step<const S: usize>(criterion: &mut Criterion, name: &str, tableau: Tableau<S>, controlled: bool) {
    let mut group = group(criterion, name);
    for elements in ELEMENTS {
        let cached = cached(elements, true);
        let step = Spectrum::new(&cached, SPEED).unwrap().longest_step(&DORMAND_PRINCE);
        let (mut motion, y) = motion(&cached, Geometry::Live, SPEED);
        let mut method = RungeKutta::new(tableau, y.len());
        method.begin(&mut motion, 0.0, &y).unwrap();
        group.bench_function(BenchmarkId::from_parameter(15 * (elements + 1)), |bencher| {
            bencher.iter(|| {
                method.step(&mut motion, (0.0, step), black_box(&y), step).unwrap();
                // What the controller asks after each step.
                if controlled { motion.size(method.end()) + method.error(&mut motion, step) } else { 0.0 }
            });
        });
    }
}

fn steps(criterion: &mut Criterion) {
    step(criterion, "step of rk4", RK4, false);
    step(criterion, "step of rk45", DORMAND_PRINCE, true);
}

fn norm(criterion: &mut Criterion) {
    let mut group = group(criterion, "norm");
    for elements in ELEMENTS {
        let cached = cached(elements, true);
        let (mut motion, y) = motion(&cached, Geometry::Live, SPEED);
        group.bench_function(BenchmarkId::from_parameter(15 * (elements + 1)), |bencher| {
            bencher.iter(|| motion.norm(black_box(&y)));
        });
    }
}

/// A thousand steps of rk4 at 240 degrees of freedom: what live geometry, teeth and separation cost beside a frozen
/// mesh that never parts.
fn meshes(criterion: &mut Criterion) {
    let mut group = group(criterion, "1000 steps of rk4, mesh");
    group.sample_size(10);
    let cases = [
        ("frozen", Geometry::Frozen, false, None),
        ("live", Geometry::Live, false, None),
        ("live, teeth", Geometry::Live, true, None),
        ("live, backlash", Geometry::Live, false, Some(1e-4)),
        ("live, teeth, backlash", Geometry::Live, true, Some(1e-4)),
    ];
    for (name, geometry, teeth, backlash) in cases {
        let mut system = system(15, true);
        if teeth {
            common::set_teeth(&mut system, StiffnessKind::Parabolic);
        }
        for mesh in &mut system.meshes {
            mesh.backlash = backlash;
        }
        let cached = basis_of(&system);
        let step = Spectrum::new(&cached, SPEED).unwrap().longest_step(&DORMAND_PRINCE);
        let equilibrium = gearbow::analysis::equilibrium(&cached, geometry, SPEED).unwrap();
        let y = [equilibrium.as_slice(), vec![0.0; cached.model.len()].as_slice()].concat();
        let mut motion = EquationOfMotion::new(&cached, geometry, SPEED, 0.0, equilibrium).unwrap();
        let mut method = RungeKutta::new(RK4, y.len());
        group.bench_function(name, |bencher| {
            bencher.iter(|| {
                let (mut state, mut statistics) = (State::new(y.clone()), Statistics::new());
                let end = 999.5 * step;
                run(&mut motion, &mut method, &StepControl::Fixed(step), &mut state, end, &mut Nobody, &mut statistics)
                    .unwrap();
                statistics.steps
            });
        });
    }
}

criterion_group!(engine, assembly, real_modes, damped_modes, right_hand_side, steps, norm, meshes);
criterion_main!(engine);
