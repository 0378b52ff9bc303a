//! The elastic force of an element from its strains.
//!
//! K is a sum of squares: with κ = φ₂ − φ₁ and d = u₂ − u₁ − l(φ₁ + φ₂)/2 an element in bending stores
//! ½(EI/l)κ² + ½·12EI/(l³(1+φ))·d², in twist ½(GJ/l)(θ₂ − θ₁)². Products with K in this form are cheaper than with the
//! assembled matrix, and rigid motion cancels before it is multiplied by a large stiffness, not after.

/// Values of `B` unknowns, each in `L` lanes, at one node.
pub type Values<const B: usize, const L: usize> = [[f64; L]; B];

/// An elastic element between two nodes of `B` unknowns.
pub trait Elastic<const B: usize>: Copy {
    /// Forces of the element on its two nodes.
    fn forces<const L: usize>(&self, first: &Values<B, L>, second: &Values<B, L>) -> [Values<B, L>; 2];

    /// Twice the elastic energy.
    fn form<const L: usize>(&self, first: &Values<B, L>, second: &Values<B, L>) -> f64;
}

/// Bending of an element, over (u, φ).
#[derive(Clone, Copy, Debug)]
pub struct Bending {
    /// l/2, m.
    pub half_length: f64,
    /// EI/l, N m.
    pub flexural: f64,
    /// 12EI/(l³(1+φ)), N/m.
    pub transverse: f64,
}

impl Bending {
    #[inline(always)]
    fn strains(&self, first: [f64; 2], second: [f64; 2]) -> (f64, f64) {
        let deflected = (second[0] - first[0]) - self.half_length * (first[1] + second[1]);
        (deflected, second[1] - first[1])
    }
}

impl Elastic<2> for Bending {
    #[inline(always)]
    fn forces<const L: usize>(&self, first: &Values<2, L>, second: &Values<2, L>) -> [Values<2, L>; 2] {
        let mut forces = [[[0.0; L]; 2]; 2];
        for lane in 0..L {
            let (deflected, curved) =
                self.strains([first[0][lane], first[1][lane]], [second[0][lane], second[1][lane]]);
            let shear = self.transverse * deflected;
            let moment = self.flexural * curved;
            let lever = self.half_length * shear;
            forces[0][0][lane] = shear;
            forces[0][1][lane] = lever + moment;
            forces[1][0][lane] = -shear;
            forces[1][1][lane] = lever - moment;
        }
        forces
    }

    fn form<const L: usize>(&self, first: &Values<2, L>, second: &Values<2, L>) -> f64 {
        (0..L)
            .map(|lane| {
                let (deflected, curved) =
                    self.strains([first[0][lane], first[1][lane]], [second[0][lane], second[1][lane]]);
                self.transverse * deflected * deflected + self.flexural * curved * curved
            })
            .sum()
    }
}

/// Twist of an element, over θ.
#[derive(Clone, Copy, Debug)]
pub struct Twist {
    /// GJ/l, N m.
    pub stiffness: f64,
}

impl Elastic<1> for Twist {
    #[inline(always)]
    fn forces<const L: usize>(&self, first: &Values<1, L>, second: &Values<1, L>) -> [Values<1, L>; 2] {
        let mut forces = [[[0.0; L]; 1]; 2];
        for lane in 0..L {
            let torque = self.stiffness * (second[0][lane] - first[0][lane]);
            forces[0][0][lane] = torque;
            forces[1][0][lane] = -torque;
        }
        forces
    }

    fn form<const L: usize>(&self, first: &Values<1, L>, second: &Values<1, L>) -> f64 {
        (0..L).map(|lane| self.stiffness * (second[0][lane] - first[0][lane]).powi(2)).sum()
    }
}
