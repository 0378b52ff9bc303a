//! Runge–Kutta coefficients.

/// An explicit method whose last stage is the derivative at the end of the step (first same as last).
#[derive(Clone, Copy, Debug)]
pub struct Tableau<const S: usize> {
    /// Order of the solution.
    pub order: u32,
    /// Times of the stages as fractions of the step.
    pub nodes: [f64; S],
    /// Stage i is evaluated at y + hΣⱼ weights\[i\]\[j\] kⱼ. The last row gives the solution.
    pub weights: [[f64; S]; S],
    /// hΣⱼ error\[j\] kⱼ estimates the error of the solution. All zero without an embedded method.
    pub error: [f64; S],
    /// Largest h·ω for which a step h is stable on an undamped oscillator, and on a damped one whose eigenvalues lie
    /// within 14° of the imaginary axis.
    pub imaginary_limit: f64,
    /// Largest h·|λ| for which a step h is stable for every Re λ < 0 with h·|Im λ| within the imaginary limit.
    pub real_limit: f64,
}

/// The classical method of Kutta (1901). Its fifth stage is the derivative at the end of the step.
pub const RK4: Tableau<5> = Tableau {
    order: 4,
    nodes: [0.0, 0.5, 0.5, 1.0, 1.0],
    weights: [
        [0.0; 5],
        [0.5, 0.0, 0.0, 0.0, 0.0],
        [0.0, 0.5, 0.0, 0.0, 0.0],
        [0.0, 0.0, 1.0, 0.0, 0.0],
        [1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0, 0.0],
    ],
    error: [0.0; 5],
    // The limit is 2√2 on the imaginary axis, 2.785 on the real axis, and has its minimum 2.616 at an argument of 122°.
    imaginary_limit: 2.828,
    real_limit: 2.61,
};

/// Dormand and Prince 5(4) (1980). Its stability limit on the imaginary axis is 0.997.
pub const DORMAND_PRINCE: Tableau<7> = Tableau {
    order: 5,
    nodes: [0.0, 0.2, 0.3, 0.8, 8.0 / 9.0, 1.0, 1.0],
    weights: [
        [0.0; 7],
        [1.0 / 5.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        [3.0 / 40.0, 9.0 / 40.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        [44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0, 0.0, 0.0, 0.0, 0.0],
        [19_372.0 / 6_561.0, -25_360.0 / 2_187.0, 64_448.0 / 6_561.0, -212.0 / 729.0, 0.0, 0.0, 0.0],
        [9_017.0 / 3_168.0, -355.0 / 33.0, 46_732.0 / 5_247.0, 49.0 / 176.0, -5_103.0 / 18_656.0, 0.0, 0.0],
        [35.0 / 384.0, 0.0, 500.0 / 1_113.0, 125.0 / 192.0, -2_187.0 / 6_784.0, 11.0 / 84.0, 0.0],
    ],
    error: [71.0 / 57_600.0, 0.0, -71.0 / 16_695.0, 71.0 / 1_920.0, -17_253.0 / 339_200.0, 22.0 / 525.0, -1.0 / 40.0],
    imaginary_limit: 0.98,
    real_limit: 3.0,
};
