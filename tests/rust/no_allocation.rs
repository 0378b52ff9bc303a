//! Time steps, and all functions that run once per step, allocate no memory.

use std::sync::Arc;

use crate::common::{Noise, cached, motion, train};
use allocation_counter::{AllocationInfo, measure};
use gearbow::analysis::simulate::{Initial, Method, Options, RecordPlan, simulate};
use gearbow::analysis::{Spectrum, equilibrium};
use gearbow::exponential::{
    self, Loads, OutputMap, PropagatorCache, PropagatorKey, QuadratureRule, Selection, Stepper, TimeGrid,
};
use gearbow::integrate::tableau::{DORMAND_PRINCE, RK4, Tableau};
use gearbow::integrate::{
    Adaptive, FirstOrderSystem as _, Halt, Observer, RungeKutta, State, Statistics, StepControl, Trajectory, run,
};
use gearbow::mesh::Geometry;
use gearbow::motion::{EquationOfMotion, Profile, ShaftRotation, Speed};
use gearbow::scene::SceneDescription;
use gearbow::scene::description::{Engagement, Stiffness, StiffnessKind, StiffnessModel};
use nalgebra::{DMatrix, DVector};

/// Observes one coordinate in the middle of every step.
struct Onlooker {
    end: f64,
    next: f64,
    seen: f64,
}

impl Observer for Onlooker {
    fn next(&self) -> Option<f64> {
        (self.next < self.end).then_some(self.next)
    }

    fn observe(&mut self, motion: &mut impl Trajectory, end: f64) -> Result<(), Halt> {
        let (mut q, mut v) = ([0.0; 4], [0.0; 4]);
        motion.states(&[(motion.begin() + motion.end()) / 2.0], &[3], &mut q, &mut v);
        self.seen += q[3];
        self.next = end;
        Ok(())
    }

    fn continues(&mut self, _: f64) -> bool {
        true
    }
}

/// The train with all damping models, and with internal coordinates.
fn damped() -> SceneDescription {
    let mut system = train();
    system.shafts[0].degree = Some(3);
    system.modal_damping = Some(0.01.into());
    system.rayleigh = Some([10.0, 1e-7]);
    system
}

/// The train with tooth separation and time-varying tooth engagement.
fn rattling() -> SceneDescription {
    let mut system = train();
    for mesh in &mut system.meshes {
        let square = StiffnessModel::of(StiffnessKind::Square);
        mesh.stiffness = Some(Stiffness::Model(StiffnessModel { mean: Some(2e8), ..square }));
        mesh.backlash = Some(1e-5);
    }
    system
}

/// Allocations of a run of about `steps` steps, and its statistics.
fn cost<const S: usize>(
    tableau: Tableau<S>,
    adaptive: bool,
    geometry: Geometry,
    system: &SceneDescription,
    steps: u32,
) -> (AllocationInfo, Statistics) {
    let cached = cached(system);
    let n = cached.model.len();
    let mut motion = EquationOfMotion::new(&cached, geometry, 100.0, 0.0, DVector::zeros(n)).unwrap();
    let longest = Spectrum::new(&cached, 100.0).unwrap().longest_step(&DORMAND_PRINCE);
    let control = if adaptive {
        StepControl::Adaptive(Adaptive { rtol: 1e-9, floor: 1e-12, longest })
    } else {
        StepControl::Fixed(longest)
    };
    let mut method = RungeKutta::new(tableau, 2 * n);
    let mut noise = Noise::new(6);
    let mut state = State::new([noise.vector(n, 1e-6), noise.vector(n, 0.01)].concat());
    let mut statistics = Statistics::new();
    let end = f64::from(steps) * longest;
    let mut onlooker = Onlooker { end, next: 0.0, seen: 0.0 };
    let info = measure(|| {
        run(&mut motion, &mut method, &control, &mut state, end, &mut onlooker, &mut statistics).unwrap();
    });
    assert!(onlooker.seen != 0.0);
    if adaptive {
        assert!(statistics.rejected > 0, "rejections are measured too");
    }
    assert!(statistics.steps >= u64::from(steps) - 1);
    (info, statistics)
}

#[test]
fn steps_allocate_nothing() {
    // This checks the allocation counter.
    assert_eq!(measure(|| drop(std::hint::black_box(vec![1.0; 3]))).count_total, 1);
    for geometry in [Geometry::Live, Geometry::Frozen] {
        for steps in [100, 200] {
            let (rk4, _) = cost(RK4, false, geometry, &damped(), steps);
            assert_eq!((rk4.count_total, rk4.bytes_total), (0, 0));
            let (rk45, _) = cost(DORMAND_PRINCE, true, geometry, &damped(), steps);
            assert_eq!((rk45.count_total, rk45.bytes_total), (0, 0));
        }
    }
}

#[test]
fn contact_changes_allocate_nothing() {
    // A run with possible contact changes allocates its buffers once, independent of its length.
    let [short, long] = [200, 400].map(|steps| {
        let (rk4, few) = cost(RK4, false, Geometry::Live, &rattling(), steps);
        let (rk45, many) = cost(DORMAND_PRINCE, true, Geometry::Live, &rattling(), steps);
        ([rk4.count_total, rk45.count_total], [few.events, many.events])
    });
    assert_eq!(short.0, long.0);
    assert!(short.0[0] < 10, "{short:?}");
    assert!(short.1[0] > 0 && long.1[0] > short.1[0] && long.1[1] > short.1[1], "{short:?} {long:?}");
}

/// Number of allocations, steps and events of a run.
fn whole_run(method: Method, system: &SceneDescription, geometry: Geometry, duration: f64) -> (u64, u64, u64) {
    run_at(100.0.into(), method, system, geometry, duration)
}

/// The same at a given speed.
fn run_at(
    speed: Speed,
    method: Method,
    system: &SceneDescription,
    geometry: Geometry,
    duration: f64,
) -> (u64, u64, u64) {
    let cached = cached(system);
    let options = Options {
        duration,
        speed,
        method,
        step: None,
        rtol: None,
        stages: None,
        modes: None,
        reduction: None,
        kept_modes: None,
        force_error: None,
        initial: Initial::Rest,
        times: Vec::new(),
        geometry,
        start: 0.0,
        checkpoint: None,
    };
    let plan = RecordPlan::new(&cached.model, &[]).unwrap();
    let run = || simulate(&cached, &options, &plan, &mut |_| true).unwrap().statistics;
    run();
    let mut statistics = Statistics::new();
    let info = measure(|| statistics = run());
    (info.count_total, statistics.steps, statistics.events)
}

#[test]
fn further_steps_at_a_changing_speed_allocate_nothing() {
    for system in [train(), damped()] {
        let [short, long] = [0.05, 0.15].map(|duration| {
            let ramp = Profile::new(vec![0.0, 1.0], &[[100.0, 10.0, 0.0, 0.0]]).unwrap();
            run_at(Speed::Changing(ramp), Method::Exponential, &system, Geometry::Live, duration)
        });
        assert_eq!(short.0, long.0);
        assert!(long.1 > short.1 + 50, "{short:?} {long:?}");
    }
}

#[test]
fn further_steps_in_the_modes_allocate_nothing() {
    // The allocations of a run do not depend on its length.
    let mut sharp = rattling();
    sharp.meshes.iter_mut().for_each(|mesh| mesh.backlash = None);
    for mesh in &mut sharp.meshes {
        if let Some(Stiffness::Model(model)) = &mut mesh.stiffness {
            model.engagement = Some(Engagement::Named("sharp".to_owned()));
        }
    }
    for (system, switches) in [(train(), false), (damped(), false), (sharp, true)] {
        for geometry in [Geometry::Live, Geometry::Frozen] {
            for method in [Method::Exponential, Method::ExactRk4] {
                let [short, long] = [0.05, 0.15].map(|duration| whole_run(method, &system, geometry, duration));
                assert_eq!(short.0, long.0, "{method:?} {geometry:?} {switches}");
                assert!(long.1 > short.1 + 50, "{short:?} {long:?}");
                assert!(!switches || short.2 > 0 && long.2 > short.2, "{short:?} {long:?}");
            }
        }
    }
    let [short, long] = [1e-3, 2e-3].map(|duration| whole_run(Method::Rk4, &damped(), Geometry::Live, duration));
    assert_eq!(short.0, long.0);
    assert!(long.1 > short.1 + 50);
}

#[test]
fn derivative_norms_and_energy_allocate_nothing() {
    let cached = cached(&train());
    let n = cached.model.len();
    let mut motion = EquationOfMotion::new(&cached, Geometry::Live, 100.0, 0.0, DVector::zeros(n)).unwrap();
    let y = Noise::new(6).vector(2 * n, 1e-6);
    let mut derivative = vec![0.0; 2 * n];
    let info = measure(|| {
        motion.derivative(0.1, &y, &mut derivative).unwrap();
        std::hint::black_box(motion.norm(&y) + motion.size(&y));
        std::hint::black_box(motion.energies(0.1, &y[..n], &y[n..]).unwrap());
        std::hint::black_box(motion.mesh_state(0, 0.1, &y[..n], &y[n..]).unwrap());
    });
    assert_eq!(info.count_total, 0);
    let ramp = Profile::new(vec![0.0, 0.2], &[[100.0, 500.0, 0.0, 0.0]]).unwrap();
    let rotation = ShaftRotation { speed: Speed::Changing(ramp), ..ShaftRotation::constant(200.0, 0.0) };
    let mut motion = EquationOfMotion::along(&cached, Geometry::Live, &rotation, DVector::zeros(n));
    let mut contact_modes = Vec::with_capacity(16);
    let info = measure(|| {
        motion.derivative(0.1, &y, &mut derivative).unwrap();
        motion.contact_modes_at(0.3, &y, &mut contact_modes).unwrap();
        motion.set_contact_modes(&contact_modes);
    });
    assert_eq!(info.count_total, 0, "a speed that changes");
}

/// Allocations of two runs of the exponential method. The second run is three times as long as the first. A run before
/// them creates all step propagators that they need.
fn exponential(
    system: &SceneDescription,
    geometry: Geometry,
    rule: &QuadratureRule,
    adaptive: bool,
) -> ([AllocationInfo; 2], [Statistics; 3]) {
    let (cached, speed) = (cached(system), 100.0);
    let n = cached.model.len();
    let linear = cached.linear(speed).unwrap();
    let reference = equilibrium(&cached, geometry, speed).unwrap();
    let equation = motion(&cached, geometry, speed, 0.0);
    let mut amplitudes = DMatrix::zeros(n, equation.sources().len());
    for (column, source) in equation.sources().iter().enumerate() {
        amplitudes.set_column(column, &linear.synchronous(source.spin, &source.columns()).unwrap());
    }
    let (field, maps) = Loads::new(equation, &linear, reference, &amplitudes).unwrap();
    let longest = if rule.explicit { 2e-6 } else { 2e-5 };
    let substep = (longest * linear.radius / 0.8).log2().ceil().max(4.0) as usize;
    let time_grid = TimeGrid { longest, finest: substep + 12, substep };
    let selection = Selection { displacements: vec![3], velocities: vec![3], ..Selection::default() };
    let mut output = OutputMap::new(&field, &linear, &maps, selection);
    let table = PropagatorCache::new(Arc::new(PropagatorKey {
        linear: linear.clone(),
        rule: rule.clone(),
        maps,
        time_grid,
        spins: field.spins(),
    }));
    let mut stepper = Stepper::new(field, table.into());
    let control = if adaptive {
        exponential::LevelControl::Adaptive { rtol: 1e-6, floor: 1e-12, force_error: None }
    } else {
        exponential::LevelControl::Fixed
    };
    let mut noise = Noise::new(6);
    let z = linear.state(&cached.model, &noise.vector(n, 1e-7), &noise.vector(n, 0.01));
    let mut state = State::new(z.as_slice().to_vec());
    let mut go = |steps: u32| {
        let mut statistics = Statistics::new();
        let end = state.elapsed + f64::from(steps) * longest;
        let mut onlooker = Onlooker { end, next: state.elapsed, seen: 0.0 };
        let info = measure(|| {
            let control = control.clone();
            exponential::run(&mut stepper, &mut output, control, &mut state, end, &mut onlooker, &mut statistics)
                .unwrap();
        });
        (info, statistics)
    };
    let (_, first) = go(3000);
    let (short, second) = go(500);
    let (long, third) = go(1500);
    ([short, long], [first, second, third])
}

#[test]
fn steps_of_the_exponential_method_allocate_nothing() {
    for system in [damped(), rattling()] {
        for geometry in [Geometry::Live, Geometry::Frozen] {
            for (rule, adaptive) in [
                (QuadratureRule::gauss(3), true),
                (QuadratureRule::gauss(2), false),
                (QuadratureRule::explicit(), false),
            ] {
                let ([short, long], [_, few, many]) = exponential(&system, geometry, &rule, adaptive);
                // A run allocates its buffers once, independent of its length.
                assert_eq!(short.count_total, long.count_total, "{rule:?} {few:?} {many:?}");
                assert!(long.count_total < 100);
                assert!(many.steps > few.steps + 900, "{few:?} {many:?}");
                if system.meshes[0].backlash.is_some() {
                    assert!(few.events > 0 && many.events > few.events, "{few:?} {many:?}");
                }
            }
        }
    }
}
