//! Order in which the unknowns of a sparse matrix are eliminated.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Order of elimination that keeps the number of entries small: the unknown with the fewest neighbours first (minimum degree;
/// George and Liu, SIAM Review 31, 1989). An unknown without an entry on the diagonal comes after one of its neighbours. `places` are
/// the rows and columns of entries.
pub fn minimum_degree(size: usize, places: &[(usize, usize)]) -> Vec<usize> {
    let mut neighbours: Vec<Vec<u32>> = vec![Vec::new(); size];
    let mut is_ready = vec![false; size];
    for &(row, column) in places {
        if row == column {
            is_ready[row] = true;
        } else {
            neighbours[row].push(column as u32);
            neighbours[column].push(row as u32);
        }
    }
    for own in &mut neighbours {
        own.sort_unstable();
        own.dedup();
    }
    // Keys of the unknowns, the next one first; those of an unknown whose key has changed since are left.
    let key = |own: &[u32], is_ready: bool, unknown: u32| Reverse((!is_ready, own.len(), unknown));
    let unknowns = 0..size as u32;
    let mut waiting: BinaryHeap<_> =
        unknowns.map(|unknown| key(&neighbours[unknown as usize], is_ready[unknown as usize], unknown)).collect();
    let mut is_done = vec![false; size];
    let mut order = Vec::with_capacity(size);
    let mut union = Vec::new();
    while let Some(next) = waiting.pop() {
        let Reverse((_, _, unknown)) = next;
        let at = unknown as usize;
        if is_done[at] || next != key(&neighbours[at], is_ready[at], unknown) {
            continue;
        }
        is_done[at] = true;
        order.push(at);
        let clique = std::mem::take(&mut neighbours[at]);
        for other in &clique {
            let (own, is_ready) = (&mut neighbours[*other as usize], &mut is_ready[*other as usize]);
            let before = key(own, *is_ready, *other);
            merge(own, &clique, &mut union);
            union.retain(|each| each != other && *each != unknown);
            std::mem::swap(own, &mut union);
            *is_ready = true;
            let after = key(own, true, *other);
            if after != before {
                waiting.push(after);
            }
        }
    }
    order
}

/// The union of two ascending lists, ascending.
fn merge(mut a: &[u32], mut b: &[u32], union: &mut Vec<u32>) {
    union.clear();
    while let (Some((first, others)), Some((second, rest))) = (a.split_first(), b.split_first()) {
        union.push(*first.min(second));
        (a, b) = (if first <= second { others } else { a }, if second <= first { rest } else { b });
    }
    union.extend(a);
    union.extend(b);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chain_is_eliminated_from_its_ends_and_a_star_from_its_leaves() {
        let chain: Vec<(usize, usize)> = (0..5).map(|i| (i, i)).chain((0..4).map(|i| (i, i + 1))).collect();
        assert_eq!(minimum_degree(5, &chain), [0, 1, 2, 3, 4]);
        let star: Vec<(usize, usize)> = (0..5).map(|i| (i, i)).chain((1..5).map(|i| (0, i))).collect();
        let order = minimum_degree(5, &star);
        assert!(order.iter().position(|unknown| *unknown == 0) >= Some(3), "{order:?}");
    }

    #[test]
    fn an_unknown_without_a_diagonal_entry_comes_after_a_neighbour() {
        // 0 has one neighbour only, but no entry on the diagonal.
        assert_eq!(minimum_degree(3, &[(0, 1), (1, 1), (1, 2), (2, 2)]), [2, 1, 0]);
        // Without any diagonal, every unknown is still in the order.
        let mut order = minimum_degree(3, &[(0, 1), (1, 2)]);
        order.sort_unstable();
        assert_eq!(order, [0, 1, 2]);
    }
}
