//! Conservation tests: energy to the order of the method, momentum, and bit-identical repetition.

use crate::common::{Noise, cached, everything, free_train, motion, train};
use gearbow::analysis::Spectrum;
use gearbow::integrate::tableau::{DORMAND_PRINCE, RK4, Tableau};
use gearbow::integrate::{
    Adaptive, FirstOrderSystem as _, Halt, Observer, RungeKutta, State, Statistics, StepControl, Trajectory, run,
};
use gearbow::mesh::Geometry;
use gearbow::modal::CachedModel;
use gearbow::motion::EquationOfMotion;
use nalgebra::DVector;

/// An observer that requests no output.
struct Nobody;

impl Observer for Nobody {
    fn next(&self) -> Option<f64> {
        None
    }

    fn observe(&mut self, _: &mut impl Trajectory, _: f64) -> Result<(), Halt> {
        Ok(())
    }

    fn continues(&mut self, _: f64) -> bool {
        true
    }
}

fn integrate<const S: usize>(
    motion: &mut EquationOfMotion<'_>,
    tableau: Tableau<S>,
    control: StepControl,
    y: Vec<f64>,
    end: f64,
) -> State {
    let (mut method, mut state) = (RungeKutta::new(tableau, y.len()), State::new(y));
    run(motion, &mut method, &control, &mut state, end, &mut Nobody, &mut Statistics::new()).unwrap();
    state
}

/// A state that contains only the lowest elastic modes, which small steps resolve.
fn slow(cached: &CachedModel, size: f64) -> Vec<f64> {
    let real = cached.real_modes(0.0).unwrap();
    let mut q = DVector::zeros(cached.model.len());
    for mode in real.null..real.null + 12 {
        let shape = real.vectors.column(mode);
        q += shape * (size / shape.amax());
    }
    [q.as_slice(), &vec![0.0; cached.model.len()]].concat()
}

#[test]
fn an_undamped_free_motion_conserves_energy_with_the_order_of_the_method() {
    // With few elements the steps are long enough for an error above round-off.
    let mut system = free_train();
    system.shafts.iter_mut().for_each(|shaft| shaft.elements = Some(1));
    let cached = cached(&system);
    let n = cached.model.len();
    let highest = cached.real_modes(0.0).unwrap().highest();
    let drift = |geometry: Geometry, step: f64, size: f64| {
        let mut motion = motion(&cached, geometry, 300.0, 0.0);
        let y = slow(&cached, size);
        let before = motion.energies(0.0, &y[..n], &y[n..]).unwrap().total();
        let state = integrate(&mut motion, RK4, StepControl::Fixed(step), y, 0.01);
        (motion.energies(state.elapsed, &state.y[..n], &state.y[n..]).unwrap().total() - before) / before
    };
    // The displacement is 3e-4 m and the centre distance is 0.11 m, so the line of action rotates by 1e-2 rad.
    let step = 2.0_f64.powi(-18);
    assert!(step * highest < 1.0 && step * highest > 0.1, "{}", step * highest);
    for geometry in [Geometry::Live, Geometry::Frozen] {
        let (coarse, fine) = (drift(geometry, step, 3e-4), drift(geometry, step / 2.0, 3e-4));
        let ratio = coarse / fine;
        // RK4 loses the fraction ω⁶h⁵/72 of the energy per second. The ratio is 2⁵, or 2⁴ for non-quadratic terms.
        assert!(ratio > 28.0 && ratio < 40.0, "{coarse:e} {fine:e}");
        assert!(fine.abs() < 1e-8 && fine.abs() > 1e-13, "{fine:e}");
    }
}

#[test]
fn the_gyroscopic_matrix_is_skew_and_does_no_work() {
    let cached = cached(&free_train());
    let model = &cached.model;
    let gyroscopic = model.gyroscopic_matrix();
    assert_eq!(gyroscopic, -gyroscopic.transpose());
    assert!(gyroscopic.amax() > 0.0);
    let n = model.len();
    let mut noise = Noise::new(2);
    let y = [noise.vector(n, 1e-5), noise.vector(n, 0.1)].concat();
    let acceleration = |speed: f64| {
        let mut derivative = vec![0.0; 2 * n];
        motion(&cached, Geometry::Live, speed, 0.0).derivative(0.0, &y, &mut derivative).unwrap();
        DVector::from_column_slice(&derivative[n..])
    };
    let added = model.mass_matrix() * (acceleration(3000.0) - acceleration(0.0));
    let v = DVector::from_column_slice(&y[n..]);
    let acting = v.abs().dot(&added.abs());
    assert!(acting > 0.0);
    // Round-off of accelerations that are 1e3 times larger than the contribution of the spin.
    assert!(v.dot(&added).abs() < 1e-10 * acting, "{:e}", v.dot(&added) / acting);
}

#[test]
fn the_momentum_of_the_rigid_body_rotation_is_conserved() {
    // Balanced torques do no work on the rigid-body rotation, and live mesh forces have no component along it.
    let mut system = train();
    system.meshes.iter_mut().for_each(|mesh| mesh.centre_line_angle = Some(0.3));
    let cached = cached(&system);
    let (n, speed) = (cached.model.len(), 100.0);
    let real = cached.real_modes(speed).unwrap();
    let mut motion = motion(&cached, Geometry::Live, speed, 0.0);
    let weighted = cached.model.mass_matrix() * real.vectors.column(0);
    let mut noise = Noise::new(9);
    let y = [noise.vector(n, 1e-6), noise.vector(n, 0.01)].concat();
    let momentum = |y: &[f64]| weighted.dot(&DVector::from_column_slice(&y[n..]));
    let passing = |y: &[f64]| weighted.abs().dot(&DVector::from_column_slice(&y[n..]).abs());
    let before = momentum(&y);
    let step = 1.0 / Spectrum::new(&cached, speed).unwrap().radius();
    let (mut method, mut state) = (RungeKutta::new(RK4, 2 * n), State::new(y));
    let (mut drift, mut most) = (0.0_f64, 0.0_f64);
    for part in 1..=20 {
        let end = (f64::from(part) * 5000.0 + 0.5) * step;
        run(&mut motion, &mut method, &StepControl::Fixed(step), &mut state, end, &mut Nobody, &mut Statistics::new())
            .unwrap();
        drift = drift.max((momentum(&state.y) - before).abs());
        most = most.max(passing(&state.y));
    }
    assert_eq!(state.count, 100_000);
    // Each step exchanges momentum between the shafts with a rounding error of one ulp. The errors add at random, to
    // about 300 ulps.
    assert!(drift < 300.0 * f64::EPSILON * most, "{:e}", drift / most);
    assert!(before.abs() > 1e-6 * most, "the train rolls: {:e}", before / most);
}

#[test]
fn balanced_torques_do_not_start_the_rigid_body_rotation() {
    let cached = cached(&train());
    let rolling = cached.real_modes(0.0).unwrap().vectors.column(0).into_owned();
    let load = &cached.model.constant_load;
    let acting = rolling.abs().dot(&load.abs());
    // Two torques cancel in this sum.
    assert!(rolling.dot(load).abs() < 1e-14 * acting);
}

/// Bit patterns of the final state of a run.
fn bits(cached: &CachedModel, live: bool) -> Vec<u64> {
    let geometry = if live { Geometry::Live } else { Geometry::Frozen };
    let n = cached.model.len();
    let longest = Spectrum::new(cached, 100.0).unwrap().longest_step(&DORMAND_PRINCE);
    let mut noise = Noise::new(1);
    let y = [noise.vector(n, 1e-6), noise.vector(n, 0.01)].concat();
    let control = StepControl::Adaptive(Adaptive { rtol: 1e-6, floor: 1e-9, longest });
    let first = integrate(&mut motion(cached, geometry, 100.0, 0.0), DORMAND_PRINCE, control, y, 1e-3);
    let second = integrate(&mut motion(cached, geometry, 100.0, 0.0), RK4, StepControl::Fixed(longest), first.y, 1e-3);
    second.y.iter().map(|value| value.to_bits()).collect()
}

#[test]
fn a_repeated_run_is_bit_identical_in_any_thread() {
    let first = cached(&everything());
    let once = [bits(&first, true), bits(&first, false)];
    assert_ne!(once[0], once[1]);
    assert_eq!([bits(&first, true), bits(&first, false)], once, "twice");
    let again = cached(&everything());
    assert_eq!(bits(&again, true), once[0], "assembled anew");
    std::thread::scope(|scope| {
        // Two threads share one cached model. Each has its own motion.
        let threads = [true, false].map(|live| scope.spawn(move || bits(&cached(&everything()), live)));
        let shared = [true, false].map(|live| {
            scope.spawn({
                let first = &first;
                move || bits(first, live)
            })
        });
        assert_eq!(threads.map(|thread| thread.join().unwrap()), once);
        assert_eq!(shared.map(|thread| thread.join().unwrap()), once);
    });
}
