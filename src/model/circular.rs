//! Circular coordinates, in which the planes of a shaft uncouple: p = v + iw (forward) and m = v − iw (backward) of each
//! pair of bending coordinates; torsion, axial motion, supports and housings as they are.
//!
//! A vector of circular coordinates has, in the place of the bending coordinates of a shaft, first all p and then all m.
//! The coordinates of each of these chains, of torsion and of axial motion have the order of a band matrix: those of a node, the internal
//! ones of the element after it, those of the next node. Forces transform in the same way as displacements:
//! f_p = f_v + i f_w.

use nalgebra::{DMatrix, DVector};
use num_complex::Complex64;

use super::{Model, RodChain};
use crate::linalg::{BandOrder, CoupledChains, CoupledFactors, Side, Singular};

/// The coordinates of one chain of a shaft.
#[derive(Clone, Copy, Debug)]
pub(super) struct Part {
    /// Index, in the order of the core, of the first coordinate.
    start: usize,
    /// Order of the unknowns, (v, w), θ or the axial displacement, in a band matrix.
    order: BandOrder,
    /// Whether each unknown is a pair (v, w).
    lateral: bool,
}

impl Part {
    fn contains(&self, index: usize) -> bool {
        let lanes = if self.lateral { 2 } else { 1 };
        (self.start..self.start + lanes * self.order.len()).contains(&index)
    }
}

impl Model {
    /// Chains of all shafts, and the coordinates of supports and housings, in the order of the core.
    pub(super) fn find_parts(&self) -> Vec<Part> {
        let shafts = self.shafts.iter().flat_map(|shaft| {
            let bending = shaft.bending.as_ref();
            let bending =
                bending.map(|chain| Part { start: chain.start, order: chain.stiffness.band_order(), lateral: true });
            let rod =
                |chain: &RodChain| Part { start: chain.start, order: chain.stiffness.band_order(), lateral: false };
            bending.into_iter().chain(shaft.rods().map(rod))
        });
        let housings = BandOrder { per_node: 1, nodes: self.housings.inertia.len(), per_element: 0 };
        let housings = Part { start: self.housings.start, order: housings, lateral: false };
        shafts.chain((!self.housings.inertia.is_empty()).then_some(housings)).collect()
    }

    /// Circular coordinates of a coordinate, with the force on each for a unit force on the coordinate, and the part of
    /// each in the displacement of the coordinate. A force along v or w is f_p = 1 or i and f_m = 1 or −i; v = (p + m)/2
    /// and w = (p − m)/2i.
    pub(super) fn circular(&self, index: usize) -> [Option<(usize, Complex64, Complex64)>; 2] {
        let after = self.parts.partition_point(|part| part.start <= index);
        let Some(part) = self.parts[..after].last().filter(|part| part.contains(index)) else {
            return [None; 2];
        };
        let Part { start, order, lateral } = *part;
        let offset = index - start;
        if !lateral {
            return [Some((start + order.row(offset), Complex64::ONE, Complex64::ONE)), None];
        }
        let force = if offset.is_multiple_of(2) { Complex64::ONE } else { Complex64::I };
        let p = start + order.row(offset / 2);
        [Some((p, force, force.conj() * 0.5)), Some((p + order.len(), force.conj(), force * 0.5))]
    }

    /// Adds `value` to the entry of two coordinates in the order of the core.
    pub fn add_entry(&self, sum: &mut CoupledChains, row: usize, column: usize, value: Complex64) {
        if value == Complex64::ZERO {
            return;
        }
        let columns = self.circular(column);
        for (row, force, _) in self.circular(row).into_iter().flatten() {
            for (column, _, displacement) in columns.into_iter().flatten() {
                sum.add(row, column, value * force * displacement);
            }
        }
    }

    /// Converts a vector of displacements or forces from the order of the core to circular coordinates.
    fn to_circular(&self, x: &[Complex64]) -> Vec<Complex64> {
        let mut out = x.to_vec();
        for Part { start, order, lateral } in self.parts.iter().copied() {
            for unknown in 0..order.len() {
                let row = start + order.row(unknown);
                if lateral {
                    let (v, w) = (x[start + 2 * unknown], Complex64::I * x[start + 2 * unknown + 1]);
                    (out[row], out[row + order.len()]) = (v + w, v - w);
                } else {
                    out[row] = x[start + unknown];
                }
            }
        }
        out
    }

    /// Converts a vector from circular coordinates to the order of the core.
    fn displacements_of(&self, x: &[Complex64]) -> Vec<Complex64> {
        let mut out = x.to_vec();
        for Part { start, order, lateral } in self.parts.iter().copied() {
            for unknown in 0..order.len() {
                let row = start + order.row(unknown);
                if lateral {
                    let (p, m) = (x[row], x[row + order.len()]);
                    out[start + 2 * unknown] = (p + m) * 0.5;
                    out[start + 2 * unknown + 1] = (p - m) * Complex64::new(0.0, -0.5);
                } else {
                    out[start + unknown] = x[row];
                }
            }
        }
        out
    }

    /// Multiplies the circular coordinates p and m by a factor.
    fn scale_circular(&self, x: &mut [Complex64], factor: f64) {
        for Part { start, order, .. } in self.parts.iter().filter(|part| part.lateral) {
            x[*start..start + 2 * order.len()].iter_mut().for_each(|value| *value *= factor);
        }
    }

    /// Solution of S x = f, or Sᵀ x = f, in the order of the core, and its componentwise backward error: refined until this is at most
    /// `tolerance`, or the smallest one if it is zero; without a tolerance it is not refined, and the error is not known.
    ///
    /// Circular coordinates are T x, with TᴴT = D: 2 for p and m, and 1 for others. With S_c = T S T⁻¹, S⁻ᵀ f is the conjugate of
    /// S⁻ᴴ f* = T⁻¹ D S_c⁻ᴴ D⁻¹ T f*.
    ///
    /// # Errors
    /// [`Singular`] if round-off leaves no accurate solution.
    pub fn solve(
        &self,
        factors: &CoupledFactors,
        side: Side,
        tolerance: Option<f64>,
        force: &[Complex64],
    ) -> Result<(DVector<Complex64>, f64), Singular> {
        let conjugate = |values: &mut [Complex64]| values.iter_mut().for_each(|value| *value = value.conj());
        let mut x = match side {
            Side::Right => self.to_circular(force),
            Side::Left => {
                let mut force = force.to_vec();
                conjugate(&mut force);
                let mut x = self.to_circular(&force);
                self.scale_circular(&mut x, 0.5);
                conjugate(&mut x);
                x
            }
        };
        let error = match tolerance {
            Some(tolerance) => factors.solve_to(side, tolerance, &mut x)?,
            None => {
                factors.solve_once(side, &mut x);
                f64::NAN
            }
        };
        if side == Side::Left {
            conjugate(&mut x);
            self.scale_circular(&mut x, 2.0);
        }
        let mut x = self.displacements_of(&x);
        if side == Side::Left {
            conjugate(&mut x);
        }
        Ok((DVector::from_vec(x), error))
    }

    /// Solutions of a real system for the columns of `forces`, n × m, with the smallest backward errors.
    ///
    /// # Errors
    /// As [`Self::solve`].
    pub fn solve_columns(&self, factors: &CoupledFactors, forces: &DMatrix<f64>) -> Result<DMatrix<f64>, Singular> {
        let mut solved = forces.clone();
        // The matrix is real: real and imaginary part are two columns.
        for first in (0..forces.ncols()).step_by(2) {
            let second = (first + 1).min(forces.ncols() - 1);
            let pair = forces.column(first).zip_map(&forces.column(second), Complex64::new);
            let (x, _) = self.solve(factors, Side::Right, Some(0.0), pair.as_slice())?;
            solved.set_column(second, &x.map(|value| value.im));
            solved.set_column(first, &x.map(|value| value.re));
        }
        Ok(solved)
    }

    /// Solution of a real system, as [`Self::solve`].
    ///
    /// # Errors
    /// As [`Self::solve`].
    pub fn solve_real(&self, factors: &CoupledFactors, tolerance: f64, right: &[f64]) -> Result<Vec<f64>, Singular> {
        let right: Vec<Complex64> = right.iter().map(|value| Complex64::from(*value)).collect();
        let (x, _) = self.solve(factors, Side::Right, Some(tolerance), &right)?;
        Ok(x.iter().map(|value| value.re).collect())
    }
}
