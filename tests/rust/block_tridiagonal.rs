//! Block-tridiagonal matrices, compared with the same matrices in dense form.

use crate::common::{Noise, largest};
use gearbow::linalg::{BlockTridiagonal, NotPositiveDefinite, load};
use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;

/// A random symmetric positive definite matrix, in block-tridiagonal and in dense form.
fn chain<const B: usize>(nodes: usize, noise: &mut Noise) -> (BlockTridiagonal<B>, DMatrix<f64>) {
    let mut chain = BlockTridiagonal::<B>::zeros(nodes);
    let mut dense = DMatrix::zeros(nodes * B, nodes * B);
    for first in 0..nodes.saturating_sub(1) {
        let factor = DMatrix::from_fn(2 * B, 2 * B, |_, _| noise.next());
        let element = &factor * factor.transpose();
        chain.add_element(first, |i, j| element[(i, j)]);
        let mut block = dense.view_mut((first * B, first * B), (2 * B, 2 * B));
        block += element;
    }
    for node in 0..nodes {
        for i in 0..B {
            let value = 0.2 + noise.next().abs();
            chain.add_at_node(node, i, i, value);
            dense[(node * B + i, node * B + i)] += value;
        }
    }
    (chain, dense)
}

/// Matrix that applies `dense` to each of `lanes` interleaved lanes.
fn in_lanes(dense: &DMatrix<f64>, lanes: usize) -> DMatrix<f64> {
    dense.kronecker(&DMatrix::identity(lanes, lanes))
}

fn agrees_with_dense<const B: usize, const L: usize>(nodes: usize, seed: u64) -> Result<(), TestCaseError> {
    let mut noise = Noise::new(seed);
    let (chain, dense) = chain::<B>(nodes, &mut noise);
    let mut visited = DMatrix::zeros(nodes * B, nodes * B);
    chain.for_each(|row, column, value| visited[(row, column)] += value);
    prop_assert_eq!(&visited, &dense);

    let lanes = in_lanes(&dense, L);
    let x = DVector::from_vec(noise.vector(nodes * B * L, 1.0));
    let size = lanes.norm() * x.norm();
    // Sums of at most 3B products; nalgebra adds them in a different order.
    let round_off = 1e-14 * size;

    let product = &lanes * &x;
    let start = noise.vector(x.len(), 1.0);
    let mut out = start.clone();
    chain.multiply_add::<L>(-0.5, x.as_slice(), &mut out);
    for ((out, start), product) in out.iter().zip(&start).zip(&product) {
        prop_assert!((out - (start - 0.5 * product)).abs() < round_off);
    }
    for node in 0..nodes {
        let range = node * B * L..(node + 1) * B * L;
        let (row, loaded) = (chain.row::<L>(node, x.as_slice()), load::<B, L>(x.as_slice(), node));
        prop_assert!(
            row.iter().flatten().zip(&product.as_slice()[range.clone()]).all(|(a, b)| (a - b).abs() < round_off)
        );
        prop_assert_eq!(loaded.as_flattened(), &x.as_slice()[range]);
    }
    prop_assert!((chain.quadratic_form::<L>(x.as_slice()) - x.dot(&product)).abs() < round_off * x.norm());

    let mut solution = product.clone();
    chain.factor().unwrap().solve::<L>(solution.as_mut_slice());
    // Explicit inverses of the pivot blocks multiply round-off by their condition numbers, here at most a few hundred.
    let residual = (&lanes * &solution - &product).norm();
    prop_assert!(residual < 1e-12 * size, "{residual:e} of {size:e}");
    let condition = dense.norm() * dense.clone().cholesky().unwrap().inverse().norm();
    prop_assert!((solution - &x).norm() < 1e-13 * condition * x.norm());
    Ok(())
}

proptest! {
    #![proptest_config(crate::common::cases(100))]

    #[test]
    fn bending_agrees_with_dense(nodes in 1_usize..20, seed: u64) {
        agrees_with_dense::<2, 2>(nodes, seed)?;
    }

    #[test]
    fn one_plane_of_bending_agrees_with_dense(nodes in 1_usize..20, seed: u64) {
        agrees_with_dense::<2, 1>(nodes, seed)?;
    }

    #[test]
    fn twist_agrees_with_dense(nodes in 1_usize..20, seed: u64) {
        agrees_with_dense::<1, 1>(nodes, seed)?;
    }

    #[test]
    fn larger_blocks_and_more_lanes_agree_with_dense(nodes in 1_usize..10, seed: u64) {
        agrees_with_dense::<3, 4>(nodes, seed)?;
    }

    #[test]
    fn scaled_sum_agrees_with_dense(nodes in 1_usize..10, seed: u64, factor in -3.0..3.0) {
        let mut noise = Noise::new(seed);
        let (mut sum, mut expected) = chain::<2>(nodes, &mut noise);
        let (other, dense) = chain::<2>(nodes, &mut noise);
        sum.add_scaled(factor, &other);
        expected += factor * dense;
        let mut found = DMatrix::zeros(expected.nrows(), expected.ncols());
        sum.for_each(|row, column, value| found[(row, column)] += value);
        // Entries are below 20; the results differ by the round-off of one product and one sum.
        prop_assert!((found - &expected).amax() < 20.0 * 4.0 * f64::EPSILON);
    }
}

#[test]
fn a_matrix_that_is_not_positive_definite_is_reported_with_its_node() {
    let identity = |nodes: usize| {
        let mut chain = BlockTridiagonal::<2>::zeros(nodes);
        for node in 0..nodes {
            chain.add_at_node(node, 0, 0, 1.0);
            chain.add_at_node(node, 1, 1, 1.0);
        }
        chain
    };
    let failure = |chain: &BlockTridiagonal<2>| chain.factor().map(|_| ());
    assert_eq!(failure(&identity(5)), Ok(()));
    for wrong in [-1.0, -2.0, f64::NAN, f64::INFINITY] {
        for unknown in 0..2 {
            let mut chain = identity(5);
            chain.add_at_node(3, unknown, unknown, wrong);
            assert_eq!(failure(&chain), Err(NotPositiveDefinite { node: 3 }), "{wrong} at unknown {unknown}");
        }
    }
    // The diagonal is positive, but a 2 × 2 minor across two nodes is not.
    let mut coupled = identity(5);
    coupled.add_element(1, |i, j| if i.abs_diff(j) == 2 { 2.0 } else { 0.0 });
    assert_eq!(failure(&coupled), Err(NotPositiveDefinite { node: 2 }));
    assert_eq!(failure(&BlockTridiagonal::zeros(2)), Err(NotPositiveDefinite { node: 0 }));
    assert!(NotPositiveDefinite { node: 2 }.to_string().contains("node 2"));
}

#[test]
fn is_zero_detects_any_entry() {
    let mut chain = BlockTridiagonal::<1>::zeros(3);
    assert!(chain.is_zero());
    assert_eq!(chain.nodes(), 3);
    chain.add_element(1, |i, j| if i == j { 0.0 } else { 1e-300 });
    assert!(!chain.is_zero());
}

#[test]
fn long_chains_solve_to_round_off() {
    // 2000 torsional springs in series with a spring to ground at the end. The condition number is 4e6; the
    // factorization must not add to the error that it causes.
    let nodes = 2001;
    let mut chain = BlockTridiagonal::<1>::zeros(nodes);
    (0..nodes - 1).for_each(|first| chain.add_element(first, |i, j| if i == j { 1.0 } else { -1.0 }));
    chain.add_at_node(nodes - 1, 0, 0, 1.0);
    let mut x = vec![0.0; nodes];
    x[0] = 1.0;
    chain.factor().unwrap().solve::<1>(&mut x);
    // A unit torque at the free end twists every spring by one.
    let errors: Vec<f64> = x.iter().enumerate().map(|(node, value)| value - (nodes - node) as f64).collect();
    // All numbers are integers except the pivots 1 + 1/k. Each of the 2000 pivots adds at most one ulp of the result.
    assert!(largest(&errors) < 2001.0 * 2001.0 * f64::EPSILON, "{:e}", largest(&errors));
}
