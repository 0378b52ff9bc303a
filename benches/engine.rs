//! Run time of assembly, modes, right-hand side, step and norm for trains of different size.
//!
//! The train has three shafts with 4 to 41 nodes each, five degrees of freedom per node, two meshes and six bearings.
//! `cargo bench` prints the medians. The time of a right-hand side is expected to grow linearly with n, and effects
//! that a scene does not include are expected to take no time.
#![allow(missing_docs, clippy::unwrap_used, reason = "criterion generates undocumented code, and the scenes are valid")]

mod common;

use std::hint::black_box;
use std::time::Duration;

use common::{NoObserver, SPEED, cached, cached_from, motion, system};
use criterion::{BenchmarkGroup, BenchmarkId, Criterion, criterion_group, criterion_main, measurement::WallTime};
use gearbow::analysis::Spectrum;
use gearbow::integrate::tableau::{DORMAND_PRINCE, RK4, Tableau};
use gearbow::integrate::{FirstOrderSystem as _, RungeKutta, State, Statistics, StepControl, StepInterval, run};
use gearbow::mesh::Geometry;
use gearbow::modal::{self, ModeSelection};
use gearbow::model::Model;
use gearbow::motion::EquationOfMotion;
use gearbow::scene::Scene;
use gearbow::scene::description::StiffnessKind;

/// Elements per shaft, for trains with 60, 135, 240 and 615 degrees of freedom.
const ELEMENTS: [usize; 4] = [3, 8, 15, 40];

/// Benchmark group with short samples, so that all benchmarks take at most three minutes.
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
            bencher.iter(|| modal::modes(black_box(&cached), SPEED, usize::MAX, ModeSelection::All).unwrap());
        });
    }
}

fn right_hand_side(criterion: &mut Criterion) {
    let mut group = group(criterion, "right-hand side");
    let cases = [
        ("live", Geometry::Live, true, SPEED),
        ("frozen", Geometry::Frozen, true, SPEED),
        ("live, no excitation", Geometry::Live, false, SPEED),
        ("live, no excitation, at rest", Geometry::Live, false, 0.0),
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
                let interval = StepInterval { begin: 0.0, end: step, length: step };
                method.step(&mut motion, interval, black_box(&y)).unwrap();
                // The step controller evaluates these norms after each step.
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

/// A thousand steps of rk4 at 240 degrees of freedom, with live or frozen geometry, tooth pairs, and backlash.
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
        let cached = cached_from(&system);
        let step = Spectrum::new(&cached, SPEED).unwrap().longest_step(&DORMAND_PRINCE);
        let equilibrium = gearbow::analysis::equilibrium(&cached, geometry, SPEED).unwrap();
        let y = [equilibrium.as_slice(), vec![0.0; cached.model.len()].as_slice()].concat();
        let mut motion = EquationOfMotion::new(&cached, geometry, SPEED, 0.0, equilibrium).unwrap();
        let mut method = RungeKutta::new(RK4, y.len());
        group.bench_function(name, |bencher| {
            bencher.iter(|| {
                let (mut state, mut statistics) = (State::new(y.clone()), Statistics::new());
                let end = 999.5 * step;
                run(
                    &mut motion,
                    &mut method,
                    &StepControl::Fixed(step),
                    &mut state,
                    end,
                    &mut NoObserver,
                    &mut statistics,
                )
                .unwrap();
                statistics.steps
            });
        });
    }
}

criterion_group!(engine, assembly, real_modes, damped_modes, right_hand_side, steps, norm, meshes);
criterion_main!(engine);
