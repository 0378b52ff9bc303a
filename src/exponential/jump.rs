//! Contact changes within the shortest step: the effect of a load that jumps after the beginning of a step.
//!
//! A step can only end at a unit of the time grid. A jump that happens τ after a unit is moved to the unit, and the state
//! gets the contribution of the old loads until the jump: ∫₀^τ e^{−As} b Δp(s) ds, where Δp is the old load minus the new
//! one. With the parabola Δp(s) = Σ dⱼ (s/τ)ʲ, the integral is a short series:
//!
//! ```text
//! Σ_m (−τ)ᵐ/m! Aᵐ g_m,        g_m = τ Σⱼ b dⱼ/(m + j + 1)
//! ```

use super::context::StepContext;
use super::interface_maps::InterfaceMaps;
use super::{kernel, panel_kernel, taylor_terms};
use crate::modal::{ModalStateSpace, StateMatrix};

/// Number of points of the parabola: at the beginning, in the middle and at the end of τ.
pub const POINTS: usize = 3;

/// The effect of a jump on the state, and the accelerations of the interface under loads.
#[derive(Clone, Debug)]
pub(super) struct JumpSeries {
    /// w A b: acceleration of every interface scalar under every load, scalar after scalar.
    mobility: Vec<f64>,
    /// Number of interface scalars, and of scalars and rates.
    scalars: [usize; 2],
    /// Scratch: coefficients dⱼ of all loads, and Σ b dⱼ over all loads.
    coefficients: [Vec<f64>; POINTS],
    moments: [Vec<f64>; POINTS],
    /// Scratch of a dense motion: the series, and its product with A.
    sum: Vec<f64>,
    product: Vec<f64>,
}

impl JumpSeries {
    /// Allocates the series of a linear motion.
    pub fn new(linear: &ModalStateSpace, maps: &InterfaceMaps) -> Self {
        let scalars = maps.scalars;
        let with_rates = if maps.has_rates { 2 * scalars } else { scalars };
        Self {
            mobility: mobility(linear, maps, scalars),
            scalars: [scalars, with_rates],
            coefficients: std::array::from_fn(|_| vec![0.0; maps.columns.len()]),
            moments: std::array::from_fn(|_| vec![0.0; linear.len()]),
            sum: vec![0.0; linear.len()],
            product: vec![0.0; linear.len()],
        }
    }

    /// Adds to `z` the effect of the old loads for a jump that happens `delay` seconds later. `jumps` holds the old loads
    /// minus the new ones at the beginning, in the middle and at the end of that time.
    pub fn apply(&mut self, context: &StepContext<'_>, delay: f64, jumps: &[Vec<f64>; POINTS], z: &mut [f64]) {
        if delay == 0.0 {
            return;
        }
        let [first, second, third] = &mut self.coefficients;
        for (k, ((first, second), third)) in first.iter_mut().zip(second).zip(third).enumerate() {
            let [begin, middle, end] = jumps.each_ref().map(|jump| jump[k]);
            (*first, *second) = (begin, 4.0 * middle - 3.0 * begin - end);
            *third = 2.0 * (begin - 2.0 * middle + end);
        }
        for (moment, coefficients) in self.moments.iter_mut().zip(&self.coefficients) {
            moment.fill(0.0);
            panel_kernel::accumulate(context.arch, &context.columns, coefficients, moment);
        }
        let linear = &context.cache.linear;
        let terms = taylor_terms(linear.radius * delay);
        let moments = self.moments.each_ref().map(|moment| &moment[..]);
        if let StateMatrix::Pairs(_) = linear.matrix {
            kernel::add_jump(context.arch, &linear.blocks, moments, (delay, terms), z);
            return;
        }
        self.sum.fill(0.0);
        for m in (0..terms).rev() {
            linear.multiply(&self.sum, &mut self.product);
            let factors: [f64; POINTS] = std::array::from_fn(|j| delay / (m + j + 1) as f64);
            for (entry, (sum, product)) in self.sum.iter_mut().zip(&self.product).enumerate() {
                let own: f64 = factors.iter().zip(moments).map(|(factor, moment)| factor * moment[entry]).sum();
                *sum = own - delay / (m + 1) as f64 * product;
            }
        }
        z.iter_mut().zip(&self.sum).for_each(|(z, sum)| *z += sum);
    }

    /// Moves the interface state, which lies `ahead` seconds before a jump, to the path on which the new loads lead to
    /// the same state at the jump: half the square of that time, or the time for rates, times the accelerations.
    pub fn correct_path(&self, jump: &[f64], ahead: f64, interface_state: &mut [f64]) {
        let [scalars, with_rates] = self.scalars;
        let (scalars, rates) = interface_state[..with_rates].split_at_mut(scalars);
        for (k, (scalar, mobility)) in scalars.iter_mut().zip(self.mobility.chunks_exact(jump.len().max(1))).enumerate()
        {
            let acceleration: f64 = mobility.iter().zip(jump).map(|(mobility, jump)| mobility * jump).sum();
            *scalar += ahead * ahead / 2.0 * acceleration;
            if let Some(rate) = rates.get_mut(k) {
                *rate += ahead * acceleration;
            }
        }
    }
}

/// w A b of every interface scalar and load.
fn mobility(linear: &ModalStateSpace, maps: &InterfaceMaps, scalars: usize) -> Vec<f64> {
    let mut rate = vec![0.0; linear.len()];
    let mut mobility = vec![0.0; scalars * maps.columns.len()];
    for (load, column) in maps.columns.iter().enumerate() {
        linear.multiply(column, &mut rate);
        for (scalar, row) in maps.rows.iter().take(scalars).enumerate() {
            mobility[scalar * maps.columns.len() + load] = row.iter().zip(&rate).map(|(w, rate)| w * rate).sum();
        }
    }
    mobility
}
