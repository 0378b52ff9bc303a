//! Reynolds' equation of a film of finite length, with Reynolds' boundary condition (p = 0 and ∂p/∂n = 0 where the film
//! ruptures).
//!
//! With H = 1 − u·e_α, ζ from the middle (0) to an end (1) of the bearing, λ = D/L and P = p c²/(12 μ R² |w|), w in clearances
//! per second,
//!
//! ```text
//! ∂/∂α(H³ ∂P/∂α) + λ² H³ ∂²P/∂ζ² ≤ −cos(α − β),    P ≥ 0,    one of both is an equality
//! f = 3λ² ∫∫ P e_α dα dζ
//! ```
//!
//! where β is the direction of w. This linear complementarity problem is solved by the primal-dual active-set method
//! (Hintermüller, Ito and Kunisch, SIAM J. Optim. 13, 2003): the wet nodes of one iteration satisfy the equation; nodes with
//! negative pressure become dry, dry nodes at which the equation would raise the pressure become wet.
//! With Gümbel's condition all nodes satisfy the equation, and negative pressures count as zero.
//! At the ends of a pad the pressure is zero; in a full film it is zero opposite to w, where the film is stretched most.

use std::f64::consts::TAU;

use super::table::PadShape;
use super::{Vector, direction};
use crate::bearing_force::MAX_ITERATIONS;
use crate::linalg::{Band, Singular};
use crate::scene::Rupture;

/// Number of intervals over half the length, even for Simpson's rule.
const AXIAL_INTERVALS: usize = 8;
/// Number of circumferential intervals of a full film.
const CIRCUMFERENTIAL_INTERVALS: usize = 120;
/// Smallest number of circumferential intervals of a pad.
const MIN_PAD_INTERVALS: usize = 16;
/// Number of points at which the node density is integrated, for each interval.
const DENSITY_POINTS: usize = 4;

/// A solver for one pad, with its middle at the angle 0. It keeps the wet nodes of the last solution as the start of the next one.
#[derive(Clone, Debug)]
pub struct Reynolds {
    shape: PadShape,
    /// λ² = (D/L)².
    slenderness: f64,
    /// Wet nodes.
    wet: Vec<bool>,
    /// Scratch.
    grid: Grid,
}

/// One pad with its discretisation.
#[derive(Clone, Debug, Default)]
struct Grid {
    /// Angles of the nodes, rad.
    angles: Vec<f64>,
    /// H³ at the nodes.
    cubes: Vec<f64>,
    /// Conductance H³/Δα of each interval.
    conductances: Vec<f64>,
    /// Pressure at the inner nodes, one row of [`AXIAL_INTERVALS`] values after the other.
    pressure: Vec<f64>,
}

impl Reynolds {
    /// The solver for a pad.
    pub fn new(shape: &PadShape) -> Self {
        let slenderness = shape.length_ratio.powi(-2);
        Self { shape: *shape, slenderness, wet: Vec::new(), grid: Grid::default() }
    }

    /// The pad.
    pub fn shape(&self) -> &PadShape {
        &self.shape
    }

    /// f at the displacement u in clearances, at which the journal does not touch the pad, for a velocity in the direction
    /// `beta`, rad.
    pub fn force(&mut self, u: Vector, beta: f64) -> Vector {
        let middle = if self.shape.is_full() { beta } else { 0.0 };
        let half = self.shape.extent / 2.0;
        self.grid.place([middle - half, middle + half], u);
        self.grid.solve(self.slenderness, beta, self.shape.rupture, &mut self.wet);
        self.grid.integral().map(|value| 3.0 * self.slenderness * value)
    }
}

impl Reynolds {
    /// Angles of the nodes of the last force, rad, and the pressure P in the middle of the length there.
    pub fn middle_line(&self) -> [Vec<f64>; 2] {
        let inner = self.grid.pressure.iter().step_by(AXIAL_INTERVALS).copied();
        let pressure = std::iter::once(0.0).chain(inner).chain(std::iter::once(0.0));
        [self.grid.angles.clone(), pressure.collect()]
    }
}

impl Grid {
    /// Places the nodes of a pad; their density is that of the pressure curvature, H^{−1/2}.
    fn place(&mut self, [begin, end]: [f64; 2], u: Vector) {
        let intervals =
            ((CIRCUMFERENTIAL_INTERVALS as f64 * (end - begin) / TAU).ceil() as usize).max(MIN_PAD_INTERVALS);
        let (along, ratio) = direction(u);
        let psi = along[1].atan2(along[0]);
        let thickness = |angle: f64| 1.0 - ratio * (angle - psi).cos();
        let fine = DENSITY_POINTS * intervals;
        let step = (end - begin) / fine as f64;
        let density = |k: usize| thickness(begin + (k as f64 + 0.5) * step).sqrt().recip();
        let total: f64 = (0..fine).map(density).sum();
        self.angles.clear();
        self.angles.push(begin);
        let (mut passed, mut k) = (0.0, 0);
        for node in 1..intervals {
            let wanted = total * node as f64 / intervals as f64;
            while passed + density(k) < wanted {
                passed += density(k);
                k += 1;
            }
            self.angles.push(begin + (k as f64 + (wanted - passed) / density(k)) * step);
        }
        self.angles.push(end);
        self.cubes.clear();
        self.cubes.extend(self.angles.iter().map(|angle| thickness(*angle).powi(3)));
        self.conductances.clear();
        self.conductances.extend(
            self.angles.windows(2).map(|pair| thickness((pair[0] + pair[1]) / 2.0).powi(3) / (pair[1] - pair[0])),
        );
    }

    /// Number of rows of inner nodes.
    fn rows(&self) -> usize {
        self.angles.len() - 2
    }

    /// Half the width of the two intervals at an inner row, rad.
    fn width(&self, row: usize) -> f64 {
        (self.angles[row + 2] - self.angles[row]) / 2.0
    }

    /// Conductance to the neighbour towards the end of the bearing.
    fn axial(&self, slenderness: f64, row: usize) -> f64 {
        slenderness * self.cubes[row + 1] * self.width(row) * AXIAL_INTERVALS as f64
    }

    /// Source of the equation at a node.
    fn source(&self, row: usize, column: usize, beta: f64) -> f64 {
        (self.angles[row + 1] - beta).cos() * self.width(row) * height(column)
    }

    /// Finds the pressure that is positive at the wet nodes and zero at all others (Reynolds' condition). The search begins
    /// with the wet nodes of an earlier solution.
    fn solve(&mut self, slenderness: f64, beta: f64, rupture: Rupture, wet: &mut Vec<bool>) {
        let count = self.rows() * AXIAL_INTERVALS;
        if rupture == Rupture::Gumbel {
            wet.clear();
            wet.resize(count, true);
            self.solve_wet(slenderness, beta, wet);
            self.pressure.iter_mut().for_each(|pressure| *pressure = pressure.max(0.0));
            return;
        }
        if wet.len() != count {
            wet.clear();
            wet.extend((0..count).map(|at| self.source(at / AXIAL_INTERVALS, 0, beta) > 0.0));
        }
        for _ in 0..MAX_ITERATIONS {
            self.solve_wet(slenderness, beta, wet);
            let mut changed = false;
            for (at, wet) in wet.iter_mut().enumerate() {
                let now = if *wet { self.pressure[at] > 0.0 } else { self.inflow(slenderness, beta, at) > 0.0 };
                changed |= now != *wet;
                *wet = now;
            }
            if !changed {
                break;
            }
        }
        self.pressure.iter_mut().for_each(|pressure| *pressure = pressure.max(0.0));
    }

    /// Source plus inflow from the neighbours of a dry node.
    fn inflow(&self, slenderness: f64, beta: f64, at: usize) -> f64 {
        let (row, column) = (at / AXIAL_INTERVALS, at % AXIAL_INTERVALS);
        let mut sum = self.source(row, column, beta);
        if row > 0 {
            sum += height(column) * self.conductances[row] * self.pressure[at - AXIAL_INTERVALS];
        }
        if row + 1 < self.rows() {
            sum += height(column) * self.conductances[row + 1] * self.pressure[at + AXIAL_INTERVALS];
        }
        let axial = self.axial(slenderness, row);
        if column > 0 {
            sum += axial * self.pressure[at - 1];
        }
        if column + 1 < AXIAL_INTERVALS {
            sum += axial * self.pressure[at + 1];
        }
        sum
    }

    /// Solves the equation at the wet nodes; the pressure is zero at dry ones.
    fn solve_wet(&mut self, slenderness: f64, beta: f64, wet: &[bool]) {
        let count = wet.len();
        self.pressure.clear();
        self.pressure.resize(count, 0.0);
        let Some(first) = wet.iter().position(|wet| *wet) else { return };
        let last = wet.iter().rposition(|wet| *wet).unwrap_or(first);
        let (first, last) = (first - first % AXIAL_INTERVALS, last - last % AXIAL_INTERVALS + AXIAL_INTERVALS);
        let mut band = Band::zeros(last - first, AXIAL_INTERVALS);
        for at in first..last {
            let (row, column, own) = (at / AXIAL_INTERVALS, at % AXIAL_INTERVALS, at - first);
            if !wet[at] {
                band.add(own, own, 1.0);
                continue;
            }
            let axial = self.axial(slenderness, row);
            let around = self.conductances[row] + self.conductances[row + 1];
            band.add(own, own, height(column) * around + axial * if column == 0 { 1.0 } else { 2.0 });
            let mut couple = |distance: usize, conductance: f64| {
                band.add(own, own - distance, -conductance);
                band.add(own - distance, own, -conductance);
            };
            if column > 0 && wet[at - 1] {
                couple(1, axial);
            }
            if own >= AXIAL_INTERVALS && wet[at - AXIAL_INTERVALS] {
                couple(AXIAL_INTERVALS, height(column) * self.conductances[row]);
            }
            self.pressure[at] = self.source(row, column, beta);
        }
        // The matrix is positive definite, unless its entries are not finite: then the pressure is not known.
        match band.factor() {
            Ok(factors) => factors.solve(&mut self.pressure[first..last]),
            Err(Singular) => self.pressure.fill(f64::NAN),
        }
    }

    /// ∫∫ P e_α dα dζ.
    fn integral(&self) -> Vector {
        let mut sum = [0.0; 2];
        for (row, pressure) in self.pressure.chunks_exact(AXIAL_INTERVALS).enumerate() {
            let line: f64 = pressure.iter().enumerate().map(|(column, pressure)| simpson(column) * pressure).sum();
            let (sin, cos) = self.angles[row + 1].sin_cos();
            let weighted = self.width(row) * line;
            sum = [sum[0] + weighted * cos, sum[1] + weighted * sin];
        }
        sum
    }
}

/// Axial extent of a node; half a step at the middle of the bearing.
fn height(column: usize) -> f64 {
    if column == 0 { 0.5 / AXIAL_INTERVALS as f64 } else { 1.0 / AXIAL_INTERVALS as f64 }
}

/// Weight of Simpson's rule at a node.
fn simpson(column: usize) -> f64 {
    let factor = if column == 0 {
        1.0
    } else if column % 2 == 1 {
        4.0
    } else {
        2.0
    };
    factor / (3.0 * AXIAL_INTERVALS as f64)
}
