//! Order of the unknowns of a chain of nodes in a band matrix: those of a node, of the element after it, of the next node.
//!
//! A vector of a [`super::ChainMatrix`] has the unknowns of the nodes first and then those of the elements. An element
//! couples its internal unknowns to those of its two nodes, so that they lie between these in a band matrix.

/// Order of the unknowns of a chain in a band matrix.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BandOrder {
    /// Unknowns of each node.
    pub per_node: usize,
    /// Number of nodes.
    pub nodes: usize,
    /// Internal unknowns of each element between the nodes.
    pub per_element: usize,
}

impl BandOrder {
    /// Number of unknowns.
    pub fn len(&self) -> usize {
        self.per_node * self.nodes + self.per_element * self.nodes.saturating_sub(1)
    }

    /// Whether there are no unknowns.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Largest distance of two coupled unknowns: the number of subdiagonals.
    pub fn reach(&self) -> usize {
        2 * self.per_node + self.per_element - 1
    }

    /// Row of an unknown in the band matrix.
    #[inline]
    pub fn row(&self, unknown: usize) -> usize {
        let Self { per_node, nodes, per_element } = *self;
        if per_element == 0 {
            return unknown;
        }
        match unknown.checked_sub(per_node * nodes) {
            None => unknown + unknown / per_node * per_element,
            Some(internal) => internal + (internal / per_element + 1) * per_node,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_unknowns_of_an_element_lie_between_those_of_its_nodes() {
        let order = BandOrder { per_node: 2, nodes: 3, per_element: 3 };
        let rows: Vec<usize> = (0..order.len()).map(|unknown| order.row(unknown)).collect();
        assert_eq!(rows, [0, 1, 5, 6, 10, 11, 2, 3, 4, 7, 8, 9]);
        assert_eq!(order.reach(), 6);
    }

    #[test]
    fn a_chain_without_internal_unknowns_keeps_its_order() {
        let order = BandOrder { per_node: 1, nodes: 4, per_element: 0 };
        assert!((0..order.len()).all(|unknown| order.row(unknown) == unknown));
        assert_eq!((order.len(), order.reach(), order.is_empty()), (4, 1, false));
    }
}
