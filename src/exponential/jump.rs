//! Contact changes within the shortest step: the effect of a load that jumps after the beginning of a step.
//!
//! A step can only end at a unit of the time grid. A jump that happens τ after a unit is moved to the unit, and the state
//! gets the contribution of the old loads until the jump: ∫₀^τ e^{−As} b Δp(s) ds, where Δp is the old load minus the new
//! one. With Δp as a parabola, the integral is a short series over the columns Aᵐ b.

use super::context::StepContext;
use super::interface_maps::InterfaceMaps;
use super::panel_kernel;
use crate::modal::ModalStateSpace;

/// Number of points of the parabola: at the beginning, in the middle and at the end of τ.
pub const POINTS: usize = 3;
/// Terms of the series. No mode rotates by a radian in τ, and 1/16! is below round-off.
const TERMS: usize = 16;

/// Columns of the series, and the accelerations of the interface under loads.
#[derive(Clone, Debug)]
pub(super) struct JumpSeries {
    /// Columns Aᵐ b, load after load, m after m.
    columns: Vec<f64>,
    /// w A b: acceleration of every interface scalar under every load, scalar after scalar.
    mobility: Vec<f64>,
    /// Number of interface scalars, and of scalars and rates.
    scalars: [usize; 2],
}

impl JumpSeries {
    /// Computes the columns of all loads.
    pub fn new(linear: &ModalStateSpace, maps: &InterfaceMaps) -> Self {
        let mut columns = Vec::with_capacity(maps.columns.len() * TERMS * linear.len());
        for load in &maps.columns {
            let mut column = load.clone();
            for _ in 0..TERMS {
                columns.extend_from_slice(&column);
                let mut next = vec![0.0; column.len()];
                linear.multiply(&column, &mut next);
                column = next;
            }
        }
        let scalars = maps.scalars;
        let with_rates = if maps.has_rates { 2 * scalars } else { scalars };
        Self { columns, mobility: mobility(linear, maps, scalars), scalars: [scalars, with_rates] }
    }

    /// Adds to `z` the effect of the old loads for a jump that happens `delay` seconds later. `jumps` holds the old loads
    /// minus the new ones at the beginning, in the middle and at the end of that time.
    pub fn apply(&self, context: &StepContext<'_>, delay: f64, jumps: &[Vec<f64>; POINTS], z: &mut [f64]) {
        if delay == 0.0 {
            return;
        }
        let len = TERMS * z.len();
        for (k, columns) in self.columns.chunks_exact(len.max(1)).enumerate() {
            let [begin, middle, end] = jumps.each_ref().map(|jump| jump[k]);
            if [begin, middle, end] == [0.0; POINTS] {
                continue;
            }
            // Δp(s) = Σ dⱼ (s/τ)ʲ, and ∫₀^τ (−s)ᵐ/m! (s/τ)ʲ ds = (−τ)ᵐ/m! τ/(m + j + 1).
            let parabola = [begin, 4.0 * middle - 3.0 * begin - end, 2.0 * (begin - 2.0 * middle + end)];
            let (mut coefficients, mut power, mut count) = ([0.0; TERMS], delay, 0);
            for (m, coefficient) in coefficients.iter_mut().enumerate() {
                let integral = |(j, d): (usize, &f64)| d / (m + j + 1) as f64;
                *coefficient = power * parabola.iter().enumerate().map(integral).sum::<f64>();
                count = m + 1;
                power *= -delay / (m + 1) as f64;
                // The remaining terms are below round-off for every mode.
                if (power / delay).abs() * context.cache.linear.radius.powi(m as i32 + 1) < f64::EPSILON / 8.0 {
                    break;
                }
            }
            panel_kernel::accumulate(context.arch, columns, &coefficients[..count], z);
        }
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
