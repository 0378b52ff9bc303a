//! What is counted. Each function makes everything a kernel needs and returns the kernel; only its second call counts.

use std::hint::black_box;

use gearbow::analysis::simulate::{Initial, Method, Options, RecordPlan, Request, simulate};
use gearbow::analysis::{Spectrum, equilibrium};
use gearbow::integrate::tableau::{DORMAND_PRINCE, RK4, Tableau};
use gearbow::integrate::{Adaptive, FirstOrderSystem as _, RungeKutta, State, Statistics, StepControl, run};
use gearbow::mesh::{ContactMode, Geometry, ShaftPhase};
use gearbow::modal::{self, CachedModel};
use gearbow::model::Model;
use gearbow::scene::Scene;
use gearbow::scene::description::StiffnessKind;

use crate::common::{Nobody, SPEED, basis_of, cached, motion, set_teeth, system};

/// A kernel, ready to run.
pub type Work = Box<dyn FnMut()>;

/// A kernel by its name.
pub type Kernel = (&'static str, fn() -> Work);

/// Every kernel, in the order of the table: a line here is all that a new one needs beside its function.
pub const KERNELS: &[Kernel] = &[
    ("right-hand side, live, n = 240", || right_hand_side(Geometry::Live)),
    ("right-hand side, frozen, n = 240", || right_hand_side(Geometry::Frozen)),
    ("200 steps of rk4, live, n = 240", || steps(RK4, StepControl::Fixed)),
    ("as long with rk45, live, n = 240", || {
        steps(DORMAND_PRINCE, |longest| StepControl::Adaptive(Adaptive { rtol: 1e-6, floor: 0.0, longest }))
    }),
    ("real modes, n = 135", real_modes),
    ("damped modes, n = 60", damped_modes),
    ("static equilibrium, n = 135", static_equilibrium),
    ("force of a mesh of tooth pairs", tooth_pairs),
    ("scene and assembly, n = 240", assembly),
    ("2000 records, n = 60", recording),
    ("0.05 s of exponential, frozen, square, n = 240", || exponential(Geometry::Frozen)),
    ("0.05 s of exponential, live, square, n = 240", || exponential(Geometry::Live)),
];

/// Elements a shaft of the trains of 60, 135 and 240 degrees of freedom.
const SMALL: usize = 3;
const MIDDLE: usize = 8;
const LARGE: usize = 15;

/// What a kernel works on stays until the process ends.
fn keep(cached: CachedModel) -> &'static CachedModel {
    Box::leak(Box::new(cached))
}

/// A hundred evaluations.
fn right_hand_side(geometry: Geometry) -> Work {
    let (mut motion, y) = motion(keep(cached(LARGE, true)), geometry, SPEED);
    let mut derivative = vec![0.0; y.len()];
    Box::new(move || {
        for i in 0..100 {
            motion.derivative(1e-5 * f64::from(i), black_box(&y), &mut derivative).unwrap();
        }
    })
}

/// 200 of the longest stable steps of Dormand and Prince, from a small motion.
fn steps<const S: usize>(tableau: Tableau<S>, control: fn(f64) -> StepControl) -> Work {
    let cached = keep(cached(LARGE, true));
    let longest = Spectrum::new(cached, SPEED).unwrap().longest_step(&DORMAND_PRINCE);
    let (mut motion, y) = motion(cached, Geometry::Live, SPEED);
    let mut method = RungeKutta::new(tableau, y.len());
    let control = control(longest);
    Box::new(move || {
        let (mut state, mut statistics) = (State::new(y.clone()), Statistics::new());
        run(&mut motion, &mut method, &control, &mut state, 199.5 * longest, &mut Nobody, &mut statistics).unwrap();
        black_box(state);
    })
}

/// A basis keeps the modes that it has found, so each call has one of its own.
fn real_modes() -> Work {
    let mut fresh = [cached(MIDDLE, true), cached(MIDDLE, true)].map(keep).into_iter();
    Box::new(move || {
        black_box(fresh.next().unwrap().real_modes(SPEED).unwrap());
    })
}

fn damped_modes() -> Work {
    let cached = keep(cached(SMALL, true));
    Box::new(move || {
        black_box(modal::modes(cached, SPEED).unwrap());
    })
}

fn static_equilibrium() -> Work {
    let cached = keep(cached(MIDDLE, true));
    Box::new(move || {
        black_box(equilibrium(cached, Geometry::Live, SPEED).unwrap());
    })
}

/// A thousand places along four mesh cycles, with the engagement that pairs have where nothing is said.
fn tooth_pairs() -> Work {
    let mut system = system(SMALL, true);
    set_teeth(&mut system, StiffnessKind::Parabolic);
    let cached = keep(basis_of(&system));
    let rest = equilibrium(cached, Geometry::Live, SPEED).unwrap();
    let zero = vec![0.0; cached.model.len()];
    let (mesh, sigma) = (&cached.model.meshes[0], cached.model.sigma(0, SPEED));
    Box::new(move || {
        for i in 0..1000 {
            let angle = 1e-3 * f64::from(i);
            let turning = [ShaftPhase { angle, spin: SPEED }, ShaftPhase { angle: -angle / 2.0, spin: -SPEED / 2.0 }];
            let pose = mesh.pose(Geometry::Live, sigma, &turning, black_box(rest.as_slice()), &zero);
            black_box(mesh.contact(&pose, &ContactMode::ALWAYS).unwrap());
        }
    })
}

fn assembly() -> Work {
    let system = system(LARGE, true);
    Box::new(move || {
        black_box(Model::new(Scene::new(black_box(&system)).unwrap()).unwrap());
    })
}

/// All that can be recorded, at 2000 times within few steps of a small train.
fn recording() -> Work {
    let cached = keep(cached(SMALL, true));
    let groups = ["nodes", "meshes", "bearings", "energy"];
    let requests = groups.map(|group| Request::Name(group.to_owned()));
    let plan = RecordPlan::new(&cached.model, &requests).unwrap();
    let duration = 10.0 * Spectrum::new(cached, SPEED).unwrap().longest_step(&DORMAND_PRINCE);
    let options = Options { times: (0..2000).map(|i| duration * f64::from(i) / 2000.0).collect(), ..options(duration) };
    Box::new(move || {
        black_box(simulate(cached, &options, &plan, &mut |_| true).unwrap());
    })
}

/// A run whose modes are known, with its tables; what is recorded is seldom.
fn exponential(geometry: Geometry) -> Work {
    let mut description = system(LARGE, true);
    set_teeth(&mut description, StiffnessKind::Square);
    let cached = keep(basis_of(&description));
    let plan = RecordPlan::new(&cached.model, &[Request::Name("gears".to_owned())]).unwrap();
    let options = Options {
        method: Method::Exponential,
        rtol: Some(1e-4),
        times: (0..=50).map(|i| 1e-3 * f64::from(i)).collect(),
        geometry,
        ..options(0.05)
    };
    Box::new(move || {
        black_box(simulate(cached, &options, &plan, &mut |_| true).unwrap());
    })
}

/// A run of rk4 from rest that records nothing.
fn options(duration: f64) -> Options {
    Options {
        duration,
        speed: SPEED.into(),
        method: Method::Rk4,
        step: None,
        rtol: None,
        stages: None,
        modes: None,
        initial: Initial::Rest,
        times: Vec::new(),
        geometry: Geometry::Live,
        start: 0.0,
        checkpoint: None,
    }
}
