//! Loads that change by a jump within the shortest step that events use.
//!
//! Time counts in ticks, so a jump at τ after one is moved to the tick, and what the old loads would have done until then
//! is added to the state: ∫₀^τ e^{−As} B Δp(s) ds, Δp the old loads less the new. With Δp a parabola it is a short series
//! over columns Aᵐ b that are known.

use super::cache::InterfaceMaps;
use super::kernel;
use super::step::Stepper;
use crate::modal::ModalStateSpace;

/// Loads at the beginning, the middle and the end of a short stretch of time.
pub const POINTS: usize = 3;
/// Terms of the series: no mode turns by a radian in that time, and 1/16! is below round-off.
const TERMS: usize = 16;

/// The columns Aᵐ b.
#[derive(Clone, Debug)]
pub struct Powers {
    /// Load after load, m after m.
    columns: Vec<f64>,
}

impl Powers {
    /// The columns of all loads.
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
        Self { columns }
    }
}

impl Stepper<'_> {
    /// Adds to `z` what loads that jumped `since` seconds after it leave of those before; `jumps` are the old loads less
    /// the new at the beginning, the middle and the end of that time.
    pub(super) fn apply_jump(&self, since: f64, jumps: &[Vec<f64>; POINTS], z: &mut [f64]) {
        if since == 0.0 {
            return;
        }
        let each = TERMS * z.len();
        for (k, columns) in self.powers.columns.chunks_exact(each.max(1)).enumerate() {
            let [begin, middle, end] = jumps.each_ref().map(|jump| jump[k]);
            if [begin, middle, end] == [0.0; POINTS] {
                continue;
            }
            // Δp(s) = Σ dⱼ (s/τ)ʲ, and ∫₀^τ (−s)ᵐ/m! (s/τ)ʲ ds = (−τ)ᵐ/m! τ/(m + j + 1).
            let parabola = [begin, 4.0 * middle - 3.0 * begin - end, 2.0 * (begin - 2.0 * middle + end)];
            let (mut coefficients, mut power, mut count) = ([0.0; TERMS], since, 0);
            for (m, coefficient) in coefficients.iter_mut().enumerate() {
                let integral = |(j, d): (usize, &f64)| d / (m + j + 1) as f64;
                *coefficient = power * parabola.iter().enumerate().map(integral).sum::<f64>();
                count = m + 1;
                power *= -since / (m + 1) as f64;
                // Terms that no mode can tell from nothing.
                if (power / since).abs() * self.cache.linear.radius.powi(m as i32 + 1) < f64::EPSILON / 8.0 {
                    break;
                }
            }
            kernel::accumulate(self.arch, columns, &coefficients[..count], z);
        }
    }
}
