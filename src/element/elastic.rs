//! Elastic force and energy of an element from its strains.
//!
//! With κ = φ₂ − φ₁ and d = u₂ − u₁ − l(φ₁ + φ₂)/2, the elastic energy of an element is
//!
//! ```text
//! ½ (EI/l) κ² + ½ · 12EI/(l³(1 + Φ)) · d²   in bending,
//! ½ (GJ/l) (θ₂ − θ₁)²   in torsion,      ½ (EA/l) (u₂ − u₁)²   along the axis,
//! ```
//!
//! where Φ = 12EI/(κ_s GAl²) is the shear parameter with the shear coefficient κ_s. This form needs fewer operations
//! than the product with the matrix K. A rigid motion cancels in the strains, before the multiplication with a large
//! stiffness, which avoids round-off errors. Forces act on the nodes: f = −K q.

/// Values of the `B` unknowns, each with `L` lanes, at one node.
pub type Values<const B: usize, const L: usize> = [[f64; L]; B];

/// Elastic element between two nodes with `B` unknowns each.
pub trait Elastic<const B: usize>: Copy {
    /// Forces −K q of the element on its two nodes, N or N m.
    fn forces<const L: usize>(&self, first: &Values<B, L>, second: &Values<B, L>) -> [Values<B, L>; 2];

    /// qᵀKq, twice the elastic energy, J, summed over the lanes.
    fn quadratic_form<const L: usize>(&self, first: &Values<B, L>, second: &Values<B, L>) -> f64;
}

/// Bending stiffness of an element, over (u, φ).
#[derive(Clone, Copy, Debug)]
pub struct Bending {
    /// Half length l/2, m.
    pub half_length: f64,
    /// Flexural stiffness EI/l, N m.
    pub flexural: f64,
    /// Transverse stiffness 12EI/(l³(1 + Φ)), N/m.
    pub transverse: f64,
}

impl Bending {
    /// d, m, and κ, rad.
    #[inline(always)]
    fn strains(&self, first: [f64; 2], second: [f64; 2]) -> (f64, f64) {
        let deflection = (second[0] - first[0]) - self.half_length * (first[1] + second[1]);
        (deflection, second[1] - first[1])
    }
}

impl Elastic<2> for Bending {
    #[inline(always)]
    fn forces<const L: usize>(&self, first: &Values<2, L>, second: &Values<2, L>) -> [Values<2, L>; 2] {
        let mut forces = [[[0.0; L]; 2]; 2];
        for lane in 0..L {
            let (deflection, curvature) =
                self.strains([first[0][lane], first[1][lane]], [second[0][lane], second[1][lane]]);
            let shear = self.transverse * deflection;
            let moment = self.flexural * curvature;
            let shear_moment = self.half_length * shear;
            forces[0][0][lane] = shear;
            forces[0][1][lane] = shear_moment + moment;
            forces[1][0][lane] = -shear;
            forces[1][1][lane] = shear_moment - moment;
        }
        forces
    }

    fn quadratic_form<const L: usize>(&self, first: &Values<2, L>, second: &Values<2, L>) -> f64 {
        (0..L)
            .map(|lane| {
                let (deflection, curvature) =
                    self.strains([first[0][lane], first[1][lane]], [second[0][lane], second[1][lane]]);
                self.transverse * deflection * deflection + self.flexural * curvature * curvature
            })
            .sum()
    }
}

/// Stiffness of an element in torsion, over θ, or along its axis, over the axial displacement.
#[derive(Clone, Copy, Debug)]
pub struct Rod {
    /// Torsional stiffness GJ/l, N m/rad, or axial stiffness EA/l, N/m.
    pub stiffness: f64,
}

impl Elastic<1> for Rod {
    #[inline(always)]
    fn forces<const L: usize>(&self, first: &Values<1, L>, second: &Values<1, L>) -> [Values<1, L>; 2] {
        let mut forces = [[[0.0; L]; 1]; 2];
        for lane in 0..L {
            let force = self.stiffness * (second[0][lane] - first[0][lane]);
            forces[0][0][lane] = force;
            forces[1][0][lane] = -force;
        }
        forces
    }

    fn quadratic_form<const L: usize>(&self, first: &Values<1, L>, second: &Values<1, L>) -> f64 {
        (0..L).map(|lane| self.stiffness * (second[0][lane] - first[0][lane]).powi(2)).sum()
    }
}
