//! (e^{iθ} − e^{AT})⁻¹: the correction of a motion of the linear system that turns by the angle θ in a section T.

use nalgebra::Complex;

use crate::modal::{ModalStateSpace, ModePair};

/// (e^{iθ} − e^{AT})⁻¹: 2 × 2 blocks, one for each slot.
pub struct Turning(Vec<[[Complex<f64>; 2]; 2]>);

impl Turning {
    /// The inverses for sections of length `period`, s, at angles θ other than zero, rad.
    pub fn at(linear: &ModalStateSpace, period: f64, angles: &[f64]) -> Vec<Self> {
        let turn = |angle: f64| Complex::from_polar(1.0, angle);
        let block = |pair: &ModePair, angle: f64| inverse_block(pair, period, turn(angle));
        angles.iter().map(|angle| Self(linear.pairs().iter().map(|pair| block(pair, *angle)).collect())).collect()
    }

    /// The correction for a defect of the same harmonic; none if the linear motion resonates without damping.
    pub fn correct(&self, defect: &[Complex<f64>]) -> Option<Vec<Complex<f64>>> {
        let (x, y) = defect.split_at(self.0.len());
        let product = |row: usize| {
            let entries = self.0.iter().zip(x.iter().zip(y));
            entries.map(move |(block, (x, y))| block[row][0] * x + block[row][1] * y)
        };
        let found: Vec<Complex<f64>> = product(0).chain(product(1)).collect();
        found.iter().all(|value| value.is_finite()).then_some(found)
    }
}

/// (e^{iθ} − e^{Bt})⁻¹ of the block B of a pair; `turn` is e^{iθ}.
fn inverse_block(pair: &ModePair, period: f64, turn: Complex<f64>) -> [[Complex<f64>; 2]; 2] {
    let zero = Complex::new(0.0, 0.0);
    match pair {
        ModePair::Oscillation(value) => {
            let (decay, (sin, cos)) = ((value.re * period).exp(), (value.im * period).sin_cos());
            // e^{iθ} − e^{Bt} = [[a, −b], [b, a]].
            let (a, b) = (turn - decay * cos, Complex::new(decay * sin, 0.0));
            let determinant = a * a + b * b;
            [[a / determinant, b / determinant], [-b / determinant, a / determinant]]
        }
        ModePair::Real([first, second]) => {
            let inverse = |rate: f64| (turn - (rate * period).exp()).inv();
            [[inverse(*first), zero], [zero, inverse(*second)]]
        }
        ModePair::RigidBodyPair(rate) => {
            let growth = if *rate == 0.0 { period } else { (rate * period).exp_m1() / rate };
            let (position, velocity) = ((turn - 1.0).inv(), (turn - (rate * period).exp()).inv());
            [[position, position * velocity * growth], [zero, velocity]]
        }
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Matrix2;

    use super::*;

    #[test]
    fn the_blocks_are_inverses() {
        let (period, turn) = (0.3, Complex::from_polar(1.0, 0.7));
        let pairs = [
            ModePair::Oscillation(Complex::new(-0.2, 5.0)),
            ModePair::Real([-1.0, -30.0]),
            ModePair::RigidBodyPair(0.0),
            ModePair::RigidBodyPair(-2.0),
        ];
        for pair in pairs {
            let [[a, b], [c, d]] = pair.block();
            let flow = (Matrix2::new(a, b, c, d) * period).exp().map(|value| Complex::new(value, 0.0));
            let [[a, b], [c, d]] = inverse_block(&pair, period, turn);
            let product = Matrix2::new(a, b, c, d) * (Matrix2::from_diagonal_element(turn) - flow);
            assert!((product - Matrix2::identity()).norm() < 1e-14, "{pair:?}");
        }
    }
}
