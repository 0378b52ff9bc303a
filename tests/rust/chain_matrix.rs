//! Matrices of chains with internal unknowns, compared with the same matrices in dense form.

use crate::common::Noise;
use gearbow::element::InternalBlocks;
use gearbow::linalg::{ChainMatrix, NotPositiveDefinite};
use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;

/// A random symmetric positive definite matrix of a chain with `inner` internal unknowns in each element, and the same
/// matrix in dense form. Without `coupled` nodes and internal unknowns are not coupled.
fn chain<const B: usize>(
    nodes: usize,
    inner: usize,
    coupled: bool,
    noise: &mut Noise,
) -> (ChainMatrix<B>, DMatrix<f64>) {
    let mut chain = ChainMatrix::<B>::zeros(nodes);
    let size = nodes * B + (nodes - 1) * inner;
    let mut dense = DMatrix::zeros(size, size);
    for first in 0..nodes - 1 {
        let whole = 2 * B + inner;
        let factor = DMatrix::from_fn(whole, whole, |_, _| noise.next());
        let mut element = &factor * factor.transpose() + DMatrix::identity(whole, whole) * 0.2;
        if !coupled {
            element.view_mut((0, 2 * B), (2 * B, inner)).fill(0.0);
            element.view_mut((2 * B, 0), (inner, 2 * B)).fill(0.0);
        }
        chain.nodal.add_element(first, |i, j| element[(i, j)]);
        chain.internal.push(InternalBlocks {
            coupling: coupled.then(|| element.view((0, 2 * B), (2 * B, inner)).into_owned()),
            block: element.view((2 * B, 2 * B), (inner, inner)).into_owned(),
        });
        let index = |i: usize| if i < 2 * B { first * B + i } else { nodes * B + first * inner + i - 2 * B };
        for i in 0..whole {
            for j in 0..whole {
                dense[(index(i), index(j))] += element[(i, j)];
            }
        }
    }
    (chain, dense)
}

fn agrees_with_dense<const B: usize, const L: usize>(
    nodes: usize,
    inner: usize,
    coupled: bool,
    seed: u64,
) -> Result<(), TestCaseError> {
    let mut noise = Noise::new(seed);
    let (chain, dense) = chain::<B>(nodes, inner, coupled, &mut noise);
    prop_assert_eq!(chain.len(), dense.nrows());
    let mut visited = DMatrix::zeros(dense.nrows(), dense.nrows());
    chain.for_each(|row, column, value| visited[(row, column)] += value);
    prop_assert_eq!(&visited, &dense);

    let lanes = dense.kronecker(&DMatrix::identity(L, L));
    let x = DVector::from_vec(noise.vector(dense.nrows() * L, 1.0));
    let size = lanes.norm() * x.norm();
    // Sums of some tens of products; nalgebra adds them in a different order.
    let round_off = 1e-14 * size;
    let product = &lanes * &x;
    let start = DVector::from_vec(noise.vector(x.len(), 1.0));
    let mut out = start.clone();
    chain.multiply_add::<L>(-0.5, x.as_slice(), out.as_mut_slice());
    prop_assert!((&out - (&start - &product * 0.5)).amax() < round_off);
    prop_assert!((chain.quadratic_form::<L>(x.as_slice()) - x.dot(&product)).abs() < round_off * x.norm());

    let mut solution = product.clone();
    chain.factor().unwrap().solve::<L>(solution.as_mut_slice());
    // The elimination multiplies round-off by the condition numbers of the blocks, here at most a few thousand.
    prop_assert!((&lanes * &solution - &product).norm() < 1e-11 * size);

    let mut sum = DMatrix::zeros(dense.nrows(), dense.nrows());
    let (other, other_dense) = self::chain::<B>(nodes, inner, !coupled, &mut noise);
    ChainMatrix::combination(2.0, &chain, -3.0, &other).for_each(|row, column, value| sum[(row, column)] += value);
    prop_assert!((sum - (&dense * 2.0 - &other_dense * 3.0)).amax() < 1e-14 * dense.norm());
    Ok(())
}

proptest! {
    #![proptest_config(crate::common::cases(60))]

    #[test]
    fn bending_agrees_with_dense(nodes in 2_usize..8, inner in 0_usize..6, coupled: bool, seed: u64) {
        agrees_with_dense::<2, 2>(nodes, inner, coupled, seed)?;
    }

    #[test]
    fn twist_agrees_with_dense(nodes in 2_usize..8, inner in 0_usize..4, coupled: bool, seed: u64) {
        agrees_with_dense::<1, 1>(nodes, inner, coupled, seed)?;
    }
}

#[test]
fn a_matrix_that_is_not_positive_definite_is_reported_with_its_node() {
    let (chain, _) = chain::<2>(4, 3, true, &mut Noise::new(1));
    assert!(chain.factor().is_ok() && !chain.is_zero());
    for wrong in [-1.0, f64::NAN] {
        let mut spoiled = chain.clone();
        spoiled.internal[2].block[(1, 1)] = wrong;
        assert_eq!(spoiled.factor().map(|_| ()), Err(NotPositiveDefinite { node: 2 }));
    }
    // The internal block is positive definite, but not after the coupling is taken into account.
    let mut spoiled = chain.clone();
    spoiled.internal[1].coupling = chain.internal[1].coupling.as_ref().map(|coupling| coupling * 100.0);
    assert!(spoiled.factor().is_err());
}
