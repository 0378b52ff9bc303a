//! A step allocates nothing, nor does anything else that is called once a step.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

mod common;

use allocation_counter::{AllocationInfo, measure};
use common::{Noise, basis, train};
use gearbow::analysis::Spectrum;
use gearbow::integrate::tableau::{DORMAND_PRINCE, RK4, Tableau};
use gearbow::integrate::{Adaptive, Control, Halt, Observer, RungeKutta, Span, State, Statistics, System as _, run};
use gearbow::mesh::Geometry;
use gearbow::motion::Motion;
use gearbow::scene::System;
use gearbow::scene::description::{Stiffness, StiffnessKind, StiffnessModel};
use nalgebra::DVector;

/// Looks at one coordinate in the middle of every step.
struct Onlooker {
    end: f64,
    next: f64,
    seen: f64,
}

impl Observer for Onlooker {
    fn next(&self) -> Option<f64> {
        (self.next < self.end).then_some(self.next)
    }

    fn observe(&mut self, span: &Span<'_>, end: f64) -> Result<(), Halt> {
        self.seen += span.at(&span.weights(span.start + span.step / 2.0), 3).0;
        self.next = end;
        Ok(())
    }

    fn go_on(&mut self, _: f64) -> bool {
        true
    }
}

/// The train with every damping that there is.
fn damped() -> System {
    let mut system = train();
    system.modal_damping = Some(0.01);
    system.rayleigh = Some([10.0, 1e-7]);
    system
}

/// The train with teeth that part and come and go one pair after the other.
fn rattling() -> System {
    let mut system = train();
    for mesh in &mut system.meshes {
        let square = StiffnessModel::of(StiffnessKind::Square);
        mesh.stiffness = Some(Stiffness::Model(StiffnessModel { mean: Some(2e8), ..square }));
        mesh.backlash = Some(1e-5);
    }
    system
}

/// What a run of about `steps` steps allocates, and what it did.
fn cost<const S: usize>(
    tableau: Tableau<S>,
    adaptive: bool,
    geometry: Geometry,
    system: &System,
    steps: u32,
) -> (AllocationInfo, Statistics) {
    let basis = basis(system);
    let n = basis.model.len();
    let mut motion = Motion::new(&basis, geometry, 100.0, 0.0, DVector::zeros(n)).unwrap();
    let longest = Spectrum::new(&basis, 100.0).unwrap().longest_step(&DORMAND_PRINCE);
    let control = if adaptive {
        Control::Adaptive(Adaptive { rtol: 1e-9, floor: 1e-12, longest })
    } else {
        Control::Fixed(longest)
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
    // The counter counts.
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
fn changes_of_law_allocate_nothing() {
    // A run that may see some makes room for them once, however long it is.
    let [short, long] = [200, 400].map(|steps| {
        let (rk4, few) = cost(RK4, false, Geometry::Live, &rattling(), steps);
        let (rk45, many) = cost(DORMAND_PRINCE, true, Geometry::Live, &rattling(), steps);
        ([rk4.count_total, rk45.count_total], [few.events, many.events])
    });
    assert_eq!(short.0, long.0);
    assert!(short.0[0] < 10, "{short:?}");
    assert!(short.1[0] > 0 && long.1[0] > short.1[0] && long.1[1] > short.1[1], "{short:?} {long:?}");
}

#[test]
fn derivative_norms_and_energy_allocate_nothing() {
    let basis = basis(&train());
    let n = basis.model.len();
    let mut motion = Motion::new(&basis, Geometry::Live, 100.0, 0.0, DVector::zeros(n)).unwrap();
    let y = Noise::new(6).vector(2 * n, 1e-6);
    let mut derivative = vec![0.0; 2 * n];
    let info = measure(|| {
        motion.derivative(0.1, &y, &mut derivative).unwrap();
        std::hint::black_box(motion.norm(&y) + motion.size(&y));
        std::hint::black_box(motion.energies(0.1, &y[..n], &y[n..]).unwrap());
        std::hint::black_box(motion.mesh_state(0, 0.1, &y[..n], &y[n..]).unwrap());
    });
    assert_eq!(info.count_total, 0);
}
