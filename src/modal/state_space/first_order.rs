//! First-order form of the linear equations of motion in undamped modal coordinates η, q = Φη.
//!
//! Each elastic displacement is scaled by its frequency, x = ωη:
//!
//! ```text
//! ẋ = ω η̇,    d(η̇)/dt = −ω x − D η̇ − N ω⁻¹ x,    D = Φᵀ(C + ΩG)Φ,    N = Φᵀ(K − K_symmetric)Φ
//! ```
//!
//! In these coordinates |y|² is twice the energy, and the matrix is skew-symmetric without damping. A rigid-body mode
//! has no x, because no force depends on its position.

use nalgebra::DMatrix;

use crate::modal::undamped::RealModes;
use crate::numerics::ROUND_OFF;

/// First-order form ẏ = A y.
///
/// y holds, in this order: x of the elastic modes, η̇ of the moving modes, η of the rigid-body modes, η̇ of the
/// uncoupled rigid-body modes. Lists contain indices of undamped modes.
#[derive(Clone, Debug)]
pub struct FirstOrder {
    /// Modes with ω > 0.
    pub elastic: Vec<usize>,
    /// Elastic modes, and rigid-body modes whose velocity is coupled to another mode or damped.
    pub moving: Vec<usize>,
    /// Matrix over the first two parts of y. These parts do not depend on the others.
    pub matrix: DMatrix<f64>,
    /// Whether C + ΩG and the skew part of K are zero.
    pub undamped: bool,
    /// Rigid-body modes: ω = 0.
    pub rigid_body: Vec<usize>,
    /// Rigid-body modes that no damping, gyroscopic or circulatory force acts on.
    pub uncoupled: Vec<usize>,
}

impl FirstOrder {
    /// Projects `damping` C + ΩG and `skew_part` K − K_symmetric, both n × n, on the undamped modes.
    pub fn new(real: &RealModes, damping: &DMatrix<f64>, skew_part: &DMatrix<f64>) -> Self {
        let undamped = damping.amax() == 0.0 && skew_part.amax() == 0.0;
        Self::projected(real, &real.project(damping), &real.project(skew_part), undamped)
    }

    /// The form with `damping` D and `skew_part` N in the coordinates of the m undamped modes, both m × m.
    pub fn projected(real: &RealModes, damping: &DMatrix<f64>, skew_part: &DMatrix<f64>, undamped: bool) -> Self {
        let n = real.frequencies.len();
        let elastic: Vec<usize> = (real.null..n).filter(|i| real.frequencies[*i] > 0.0).collect();
        let rigid_body: Vec<usize> = (0..n).filter(|i| real.frequencies[*i] == 0.0).collect();
        let (smallest_damping, smallest_skew) = (ROUND_OFF * damping.amax(), ROUND_OFF * skew_part.amax());
        let coupled = |i: usize| {
            damping.row(i).amax() > smallest_damping
                || damping.column(i).amax() > smallest_damping
                || skew_part.row(i).amax() > smallest_skew
        };
        let moving: Vec<usize> = (0..n).filter(|i| real.frequencies[*i] > 0.0 || coupled(*i)).collect();
        let uncoupled = rigid_body.iter().copied().filter(|i| !coupled(*i)).collect();
        let (e, m) = (elastic.len(), moving.len());

        let mut matrix = DMatrix::zeros(e + m, e + m);
        for (row, i) in moving.iter().enumerate() {
            for (column, j) in moving.iter().enumerate() {
                matrix[(e + row, e + column)] = -damping[(*i, *j)];
            }
            for (column, j) in elastic.iter().enumerate() {
                let frequency = if i == j { real.frequencies[*j] } else { 0.0 };
                matrix[(e + row, column)] = -frequency - skew_part[(*i, *j)] / real.frequencies[*j];
                if i == j {
                    matrix[(column, e + row)] = frequency;
                }
            }
        }
        Self { elastic, moving, matrix, undamped, rigid_body, uncoupled }
    }

    /// The matrix A over all of y, 2n × 2n.
    pub fn full_matrix(&self) -> DMatrix<f64> {
        let block = self.matrix.nrows();
        let size = block + self.rigid_body.len() + self.uncoupled.len();
        let mut matrix = DMatrix::zeros(size, size);
        matrix.view_mut((0, 0), (block, block)).copy_from(&self.matrix);
        for mode in &self.rigid_body {
            matrix[(self.position_index(*mode), self.velocity_index(*mode))] = 1.0;
        }
        matrix
    }

    /// Index in y of η of a rigid-body mode.
    pub fn position_index(&self, mode: usize) -> usize {
        self.matrix.nrows() + index_of(&self.rigid_body, mode).unwrap_or_default()
    }

    /// Index in y of η̇ of a mode.
    pub fn velocity_index(&self, mode: usize) -> usize {
        match index_of(&self.moving, mode) {
            Some(row) => self.elastic.len() + row,
            None => self.matrix.nrows() + self.rigid_body.len() + index_of(&self.uncoupled, mode).unwrap_or_default(),
        }
    }

    /// Calls `visit(mode, i, scale, j)` for every mode, where η = scale · yᵢ and η̇ = yⱼ.
    fn for_each_mode(&self, real: &RealModes, mut visit: impl FnMut(usize, usize, f64, usize)) {
        for (index, mode) in self.elastic.iter().enumerate() {
            visit(*mode, index, 1.0 / real.frequencies[*mode], self.velocity_index(*mode));
        }
        for mode in &self.rigid_body {
            visit(*mode, self.position_index(*mode), 1.0, self.velocity_index(*mode));
        }
    }

    /// Matrices Q and V, each n × 2n, with q = Q z and q̇ = V z, for y = `right` z.
    pub fn physical_maps(&self, real: &RealModes, right: &DMatrix<f64>) -> [DMatrix<f64>; 2] {
        let (count, size) = (real.vectors.ncols(), right.ncols());
        let (mut positions, mut rates) = (DMatrix::zeros(count, size), DMatrix::zeros(count, size));
        self.for_each_mode(real, |mode, position, scale, rate| {
            positions.set_row(mode, &(right.row(position) * scale));
            rates.set_row(mode, &right.row(rate));
        });
        [&real.vectors * positions, &real.vectors * rates]
    }

    /// Transposes of the matrices P and R, each n × 2n, with z = P M q + R M q̇, for z = `left` y.
    pub fn state_maps(&self, real: &RealModes, left: &DMatrix<f64>) -> [DMatrix<f64>; 2] {
        let (count, size) = (real.vectors.ncols(), left.nrows());
        let (mut positions, mut rates) = (DMatrix::zeros(count, size), DMatrix::zeros(count, size));
        self.for_each_mode(real, |mode, position, scale, rate| {
            positions.set_row(mode, &(left.column(position) / scale).transpose());
            rates.set_row(mode, &left.column(rate).transpose());
        });
        [&real.vectors * positions, &real.vectors * rates]
    }
}

fn index_of(list: &[usize], mode: usize) -> Option<usize> {
    list.iter().position(|i| *i == mode)
}
