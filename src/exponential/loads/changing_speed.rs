//! Loads of a run at a changing speed, beside those of the connections.
//!
//! The linear motion is that at one reference speed Ω_ref. What the speed changes acts as loads on it:
//!
//! - gyroscopic moments −(Ω − Ω_ref) G q̇, and the circulatory forces −(Ω − Ω_ref) N d of internal damping on the deviation d
//!   from the reference q₀, as a few couplings between two scalars of the velocities and of d
//!   ([`crate::modal::speed_couplings`]);
//! - the circulatory forces −Ω N q₀ on the reference;
//! - bow and unbalance: real and imaginary part of the phasor of every [`RotatingLoad`], with the exact angle of the shaft.
//!   There is no synchronous motion.
//!
//! The loads of the couplings depend on the motion: they take part in the solution of the stage equations and in the error
//! estimate. Their scalars follow those of the connections in the interface state. Speed-dependent bearings are
//! connections.

use nalgebra::DVector;

use crate::exponential::propagator::InterfaceMaps;
use crate::modal::{CoupledMotion, ModalStateSpace, SpeedCoupling};
use crate::motion::{EquationOfMotion, RotatingLoad, RotationState};

/// What the loads of a changing speed are made of.
#[derive(Clone, Debug)]
pub struct SpeedChange {
    /// Speed of the reference shaft in the linear motion, rad/s.
    pub reference_speed: f64,
    /// The gyroscopic and circulatory couplings.
    pub couplings: Vec<SpeedCoupling>,
    /// Rotation of the reference shaft within the longest step, rad; infinite for fixed steps.
    pub longest_rotation: f64,
}

/// The loads of a changing speed.
#[derive(Clone, Debug)]
pub(in crate::exponential) struct ChangingSpeedLoads {
    /// Speed of the reference shaft in the linear motion, rad/s.
    reference_speed: f64,
    /// Rotation of the reference shaft within the longest step, rad.
    longest_rotation: f64,
    /// Number of couplings.
    couplings: usize,
    /// Whether circulatory forces act on the reference, which is one load.
    moves_reference: bool,
    /// Bow, unbalance and turning forces; each has two loads.
    rotating: Vec<RotatingLoad>,
}

/// Numbers of the loads of a changing speed.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::exponential) struct LoadCounts {
    /// Interface scalars.
    pub scalars: usize,
    /// Loads that depend on the motion.
    pub coupled_loads: usize,
    /// All loads.
    pub loads: usize,
}

impl ChangingSpeedLoads {
    /// Creates the loads and adds their rows and columns to the maps. Columns follow those of the connections: first the
    /// loads that depend on the motion, which the maps count with those of the connections, then the circulatory forces on the
    /// `reference`, then bow and unbalance.
    pub fn new(
        motion: &EquationOfMotion<'_>,
        linear: &ModalStateSpace,
        change: &SpeedChange,
        reference: &DVector<f64>,
        maps: &mut InterfaceMaps,
    ) -> Self {
        let mut columns = Vec::new();
        for coupling in &change.couplings {
            for vector in &coupling.vectors {
                let entries: Vec<(usize, f64)> = vector.iter().copied().enumerate().collect();
                maps.rows.push(linear.row(&entries, coupling.motion == CoupledMotion::Velocities));
                columns.push(linear.column(&entries));
            }
        }
        let at = maps.coupled_loads;
        maps.coupled_loads += columns.len();
        let mut circulation = DVector::zeros(reference.len());
        motion.model().sparse_circulation().multiply_add(1.0, reference.as_slice(), circulation.as_mut_slice());
        let moves_reference = circulation.amax() > 0.0;
        if moves_reference {
            let entries: Vec<(usize, f64)> = circulation.iter().copied().enumerate().collect();
            columns.push(linear.column(&entries));
        }
        let rotating = motion.rotating_loads().to_vec();
        let rotating_columns = rotating.iter().flat_map(RotatingLoad::columns);
        columns.extend(rotating_columns.map(|column| linear.column(&column)));
        maps.columns.splice(at..at, columns);
        Self {
            reference_speed: change.reference_speed,
            longest_rotation: change.longest_rotation,
            couplings: change.couplings.len(),
            moves_reference,
            rotating,
        }
    }

    /// Numbers of the loads.
    pub fn counts(&self) -> LoadCounts {
        let coupled = 2 * self.couplings;
        let prescribed = usize::from(self.moves_reference) + 2 * self.rotating.len();
        LoadCounts { scalars: coupled, coupled_loads: coupled, loads: coupled + prescribed }
    }

    /// Longest step at a speed of the reference shaft, s.
    pub fn longest_step(&self, speed: f64) -> f64 {
        self.longest_rotation / speed.abs()
    }

    /// Writes the loads at the interface scalars `u`, with the reference shaft at this instant.
    pub fn load(&self, elapsed: f64, shaft: &RotationState, u: &[f64], loads: &mut [f64]) {
        let (coupling_loads, mut rotating_loads) = loads.split_at_mut(2 * self.couplings);
        let difference = shaft.speed - self.reference_speed;
        for (scalars, load) in u.chunks_exact(2).zip(coupling_loads.chunks_exact_mut(2)) {
            load[0] = difference * scalars[1];
            load[1] = -difference * scalars[0];
        }
        if self.moves_reference {
            rotating_loads[0] = -shaft.speed;
            rotating_loads = &mut rotating_loads[1..];
        }
        for (rotating, load) in self.rotating.iter().zip(rotating_loads.chunks_exact_mut(2)) {
            let phasor = rotating.phasor(elapsed, Some(shaft));
            load.copy_from_slice(&[phasor.re, phasor.im]);
        }
    }
}
