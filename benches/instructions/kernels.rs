//! Kernels whose instructions are counted.
//!
//! Each function prepares the data of a kernel and returns the kernel. Only the second call of the kernel is counted.

use std::hint::black_box;

use gearbow::analysis::simulate::{Initial, Method, Options, RecordPlan, Request, System, simulate};
use gearbow::analysis::{ExcitationPart, Spectrum, equilibrium, lowest_modes, synchronous};
use gearbow::integrate::tableau::{DORMAND_PRINCE, RK4, Tableau};
use gearbow::integrate::{Adaptive, FirstOrderSystem as _, RungeKutta, State, Statistics, StepControl, run};
use gearbow::linalg::Side;
use gearbow::mesh::{ContactMode, Geometry, ShaftPhase};
use gearbow::modal::{self, ModeSelection};
use gearbow::model::{Model, Weights};
use gearbow::motion::{Profile, Speed};
use gearbow::scene::description::StiffnessKind;
use gearbow::scene::{Scene, SceneDescription};
use num_complex::Complex64;

use crate::common::{NoObserver, SPEED, cached, cached_from, gearbox, motion, set_teeth, system};

/// A prepared kernel.
pub type Work = Box<dyn FnMut()>;

/// Name of a kernel, and the function that prepares it.
pub type Kernel = (&'static str, fn() -> Work);

/// All kernels, in the order of the printed table. A new kernel needs a function and a line here.
pub const KERNELS: &[Kernel] = &[
    ("right-hand side, live, n = 240", || right_hand_side(Geometry::Live)),
    ("right-hand side, frozen, n = 240", || right_hand_side(Geometry::Frozen)),
    ("200 steps of rk4, live, n = 240", || steps(RK4, StepControl::Fixed)),
    ("the same duration with rk45, live, n = 240", || {
        steps(DORMAND_PRINCE, |longest| StepControl::Adaptive(Adaptive { rtol: 1e-6, floor: 0.0, longest }))
    }),
    ("real modes, n = 135", real_modes),
    ("damped modes, n = 60", damped_modes),
    ("static equilibrium, n = 135", static_equilibrium),
    ("sparse factors and a solution, n = 240", coupled_solution),
    ("modes(count=10), n = 240", few_modes),
    ("synchronous response, n = 240", synchronous_response),
    ("force of a mesh of tooth pairs", tooth_pairs),
    ("scene and assembly, n = 240", assembly),
    ("2000 records, n = 60", recording),
    ("0.05 s of exponential, frozen, square, n = 240", || exponential(Geometry::Frozen)),
    ("0.05 s of exponential, live, square, n = 240", || exponential(Geometry::Live)),
    ("0.05 s of exponential, run-up, live, square, n = 135", run_up),
    ("0.02 s of exponential, gearbox on rolling and journal bearings, n = 161", gearbox_run),
    ("0.005 s of exponential with 500 records, rotor on rings of rollers and balls", ring_run),
];

/// Elements per shaft of the train with 60 degrees of freedom.
const SMALL: usize = 3;
/// Elements per shaft of the train with 135 degrees of freedom.
const MIDDLE: usize = 8;
/// Elements per shaft of the train with 240 degrees of freedom.
const LARGE: usize = 15;

/// Leaks a model, because a kernel borrows it until the process ends.
fn leak(cached: System) -> &'static System {
    Box::leak(Box::new(cached))
}

/// A hundred evaluations of the right-hand side.
fn right_hand_side(geometry: Geometry) -> Work {
    let (mut motion, y) = motion(leak(cached(LARGE, true)), geometry, SPEED);
    let mut derivative = vec![0.0; y.len()];
    Box::new(move || {
        for i in 0..100 {
            motion.derivative(1e-5 * f64::from(i), black_box(&y), &mut derivative).unwrap();
        }
    })
}

/// Integration from a small state over the time of 200 of the longest stable steps of `DORMAND_PRINCE`.
fn steps<const S: usize>(tableau: Tableau<S>, control: fn(f64) -> StepControl) -> Work {
    let cached = leak(cached(LARGE, true));
    let longest = Spectrum::new(cached, SPEED).unwrap().longest_step(&DORMAND_PRINCE);
    let (mut motion, y) = motion(cached, Geometry::Live, SPEED);
    let mut method = RungeKutta::new(tableau, y.len());
    let control = control(longest);
    Box::new(move || {
        let (mut state, mut statistics) = (State::new(y.clone()), Statistics::new());
        run(&mut motion, &mut method, &control, &mut state, 199.5 * longest, &mut NoObserver, &mut statistics).unwrap();
        black_box(state);
    })
}

/// Undamped modes. A model caches its modes, so each of the two calls has its own model.
fn real_modes() -> Work {
    let mut fresh = [cached(MIDDLE, true), cached(MIDDLE, true)].map(leak).into_iter();
    Box::new(move || {
        black_box(fresh.next().unwrap().real_modes(SPEED).unwrap());
    })
}

/// Damped modes of a model whose undamped modes are cached after the first call.
fn damped_modes() -> Work {
    let cached = leak(cached(SMALL, true));
    Box::new(move || {
        black_box(modal::modes(cached, SPEED, usize::MAX, ModeSelection::All).unwrap());
    })
}

/// Static equilibrium with live geometry.
fn static_equilibrium() -> Work {
    let model = cached(MIDDLE, true).model.clone();
    Box::new(move || {
        // A system keeps its equilibria, so that every call has its own.
        let cached = System::new(model.clone());
        black_box(equilibrium(&cached, Geometry::Live, SPEED).unwrap());
    })
}

/// Ten factorizations of the dynamic stiffness at different frequencies, each with one solution.
fn coupled_solution() -> Work {
    let cached = leak(cached(LARGE, true));
    let right = vec![Complex64::ONE; cached.model.len()];
    Box::new(move || {
        for i in 1..=10 {
            let weights = Weights::dynamic(Complex64::new(0.0, 1e3 * f64::from(i)), SPEED);
            let factors = cached.model.dynamic_stiffness(black_box(&weights), SPEED).factor().unwrap();
            let mut x = right.clone();
            factors.solve_to(Side::Right, 0.0, &mut x).unwrap();
            black_box(x);
        }
    })
}

/// The ten lowest damped modes from sparse factors.
fn few_modes() -> Work {
    let cached = leak(cached(LARGE, true));
    Box::new(move || {
        black_box(lowest_modes(cached, SPEED, 10, ModeSelection::All).unwrap());
    })
}

/// Synchronous response at ten speeds.
fn synchronous_response() -> Work {
    let cached = leak(cached(LARGE, true));
    Box::new(move || {
        for i in 1..=10 {
            black_box(synchronous(cached, 50.0 * f64::from(i), ExcitationPart::All).unwrap());
        }
    })
}

/// Mesh force at a thousand positions along four mesh cycles, with the default engagement of tooth pairs.
fn tooth_pairs() -> Work {
    let mut system = system(SMALL, true);
    set_teeth(&mut system, StiffnessKind::Parabolic);
    let cached = leak(cached_from(&system));
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

/// Validation and assembly of a scene.
fn assembly() -> Work {
    let system = system(LARGE, true);
    Box::new(move || {
        black_box(Model::new(Scene::new(black_box(&system)).unwrap()).unwrap());
    })
}

/// Recording of all channels at 2000 times within ten steps of a small train.
fn recording() -> Work {
    let cached = leak(cached(SMALL, true));
    let groups = ["nodes", "meshes", "bearings", "energy"];
    let requests = groups.map(|group| Request::Name(group.to_owned()));
    let plan = RecordPlan::new(&cached.model, &requests).unwrap();
    let duration = 10.0 * Spectrum::new(cached, SPEED).unwrap().longest_step(&DORMAND_PRINCE);
    let options = Options { times: (0..2000).map(|i| duration * f64::from(i) / 2000.0).collect(), ..options(duration) };
    Box::new(move || {
        black_box(simulate(cached, &options, &plan, &mut |_| true).unwrap());
    })
}

/// A run of the exponential method with few records. The first call caches the modes.
fn exponential(geometry: Geometry) -> Work {
    let mut description = system(LARGE, true);
    set_teeth(&mut description, StiffnessKind::Square);
    let cached = leak(cached_from(&description));
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

/// A run-up of the exponential method with few records. The first call caches the modes.
fn run_up() -> Work {
    let mut description = system(MIDDLE, true);
    set_teeth(&mut description, StiffnessKind::Square);
    let cached = leak(cached_from(&description));
    let plan = RecordPlan::new(&cached.model, &[Request::Name("gears".to_owned())]).unwrap();
    let ramp = Profile::new(vec![0.0, 0.05], &[[0.0, 4000.0, 0.0, 0.0]]).unwrap();
    let options = Options {
        speed: Speed::Changing(ramp),
        method: Method::Exponential,
        rtol: Some(1e-5),
        times: (0..=50).map(|i| 1e-3 * f64::from(i)).collect(),
        ..options(0.05)
    };
    Box::new(move || {
        black_box(simulate(cached, &options, &plan, &mut |_| true).unwrap());
    })
}

/// A run of the gearbox from its equilibrium: helical meshes, oil films and rolling elements. The first call caches the modes.
fn gearbox_run() -> Work {
    let cached = leak(cached_from(&gearbox()));
    let plan = RecordPlan::new(&cached.model, &[Request::Name("housings".to_owned())]).unwrap();
    let options = Options {
        method: Method::Exponential,
        rtol: Some(1e-4),
        times: (0..=20).map(|i| 1e-3 * f64::from(i)).collect(),
        initial: Initial::Static,
        ..options(0.02)
    };
    Box::new(move || {
        black_box(simulate(cached, &options, &plan, &mut |_| true).unwrap());
    })
}

/// A run of a rotor on two rings of rollers and two of balls, each with five degrees of freedom, with many records. The first call
/// caches the modes.
fn ring_run() -> Work {
    let common = "element_diameter = 0.012, pitch_diameter = 0.08, degrees_of_freedom = 5, axial_preload = 500.0, clearance = 0.0, damping = 500.0, axial_damping = 500.0";
    let ring = |position: f64, angle: f64, elements: &str| {
        format!("{{ shaft = \"rotor\", position = {position:?}, contact_angle = {angle:?}, {elements}, {common} }},")
    };
    let (rollers, balls) =
        ("elements = 18, contact = \"roller\", hertz_stiffness = 5e8", "elements = 15, hertz_stiffness = 1e10");
    let rings = [(0.0, -0.25, rollers), (0.1, 0.25, rollers), (0.5, -0.4, balls), (0.6, 0.4, balls)];
    let bearings: String = rings.map(|(position, angle, elements)| ring(position, angle, elements)).concat();
    let text = format!(
        r#"
        gravity = 9.81
        shafts = [{{ name = "rotor", length = 0.6, outer_diameter = 0.06, elements = 6 }}]
        disks = [{{ name = "disk", shaft = "rotor", position = 0.3, mass = 20.0, diametral_inertia = 0.1, polar_inertia = 0.2, unbalance = 2e-4 }}]
        bearings = [{bearings}]
        "#
    );
    let cached = leak(cached_from(&SceneDescription::from_toml(&text).unwrap()));
    let plan = RecordPlan::new(&cached.model, &[Request::Name("bearings".to_owned())]).unwrap();
    let options = Options {
        method: Method::Exponential,
        rtol: Some(1e-4),
        times: (0..=500).map(|i| 1e-5 * f64::from(i)).collect(),
        initial: Initial::Static,
        ..options(0.005)
    };
    Box::new(move || {
        black_box(simulate(cached, &options, &plan, &mut |_| true).unwrap());
    })
}

/// Options of a run of rk4 from rest without records; `duration` in s.
fn options(duration: f64) -> Options {
    Options {
        duration,
        speed: SPEED.into(),
        method: Method::Rk4,
        step: None,
        rtol: None,
        stages: None,
        modes: None,
        reduction: None,
        kept_modes: None,
        force_error: None,
        initial: Initial::Rest,
        times: Vec::new(),
        geometry: Geometry::Live,
        start: 0.0,
        checkpoint: None,
    }
}
