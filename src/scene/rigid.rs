//! The largest stiffness of springs: beyond it they hold as rigidly as arithmetic can tell.
//!
//! A sum with a spring of 1e60 N/m keeps no digit of the stiffness of a shaft. A spring is rigid long before: it yields less than
//! the shaft by the ratio of their stiffnesses. Limiting this ratio once, in the scene, serves every analysis.

use super::{Attachment, HousingPoint, Matrix2, Node, Scene, Shaft};

/// Largest stiffness of a spring over that of the shaft next to it. Natural frequencies change by 1e-9 of themselves at most.
/// Dense decompositions leave 1e-5 of the forces in a mode at this ratio, and 1e-4, more than a mode may have, at 1e10
/// (2 to 60 elements).
pub const RIGID: f64 = 1e8;

/// Stiffness in each direction.
#[derive(Clone, Copy, Default)]
struct Stiffnesses {
    /// Across the axis, N/m.
    lateral: f64,
    /// Along the axis, N/m.
    axial: f64,
    /// Against tilting, N m/rad.
    tilting: f64,
    /// Against twist, N m/rad.
    torsional: f64,
}

impl Stiffnesses {
    /// Sums of the stiffnesses of two.
    fn plus(self, other: Self) -> Self {
        Self {
            lateral: self.lateral + other.lateral,
            axial: self.axial + other.axial,
            tilting: self.tilting + other.tilting,
            torsional: self.torsional + other.torsional,
        }
    }

    /// Stiffness of the elements next to a node.
    fn of_shaft(shaft: &Shaft, node: usize) -> Self {
        let around = &shaft.elements[node.saturating_sub(1)..(node + 1).min(shaft.elements.len())];
        around.iter().fold(Self::default(), |sum, element| {
            let length = element.length;
            let [axial, bending, torsion] = element.rigidities();
            sum.plus(Self {
                lateral: 12.0 * bending / length.powi(3),
                axial: axial / length,
                tilting: 4.0 * bending / length,
                torsional: torsion / length,
            })
        })
    }
}

impl Scene {
    /// Limits the stiffness of bearings, supports, housings, couplings and drives to [`RIGID`] times that of the shafts next to
    /// them.
    pub(super) fn limit_stiffness(&mut self) {
        let shafts = &self.shafts;
        let over = |nodes: &mut dyn Iterator<Item = Node>| {
            let at = |node: Node| Stiffnesses::of_shaft(&shafts[node.shaft], node.node);
            nodes.map(at).fold(Stiffnesses::default(), Stiffnesses::plus)
        };
        let limit = |stiffness: &mut f64, of_shafts: f64| *stiffness = stiffness.min(RIGID * of_shafts);
        let mut carried = vec![(Stiffnesses::default(), 0.0); self.housings.len()];
        for bearing in &mut self.bearings {
            let own = over(&mut bearing.nodes());
            bearing.stiffness.limit(RIGID * own.lateral);
            limit(&mut bearing.axial.stiffness, own.axial);
            limit(&mut bearing.tilting.stiffness, own.tilting);
            if let Some(Attachment::Housing { housing, point: HousingPoint::Arm(arm) }) = bearing.attachment {
                let (sum, rotational) = &mut carried[housing];
                *sum = sum.plus(own);
                let square: f64 = arm.iter().map(|distance| distance * distance).sum();
                *rotational += own.tilting + (own.lateral + own.axial) * square;
            }
        }
        // A support passes what it carries on to its housing.
        for index in 0..carried.len() {
            if let Some(Attachment::Housing { housing, point: HousingPoint::Arm(arm) }) =
                self.housings[index].attachment
            {
                let own = carried[index].0;
                let square: f64 = arm.iter().map(|distance| distance * distance).sum();
                carried[housing].0 = carried[housing].0.plus(own);
                carried[housing].1 += (own.lateral + own.axial) * square;
            }
        }
        for (housing, (own, rotational)) in self.housings.iter_mut().zip(carried) {
            housing.stiffness = limited(housing.stiffness, RIGID * own.lateral);
            housing.axial.iter_mut().for_each(|[stiffness, _]| limit(stiffness, own.axial));
            housing.rotational_stiffness.iter_mut().for_each(|stiffness| limit(stiffness, rotational));
        }
        for coupling in &mut self.couplings {
            let own = over(&mut coupling.hubs.into_iter());
            limit(&mut coupling.axial.stiffness, own.axial);
            limit(&mut coupling.lateral.stiffness, own.lateral);
            limit(&mut coupling.tilting.stiffness, own.tilting);
            limit(&mut coupling.torsional.stiffness, own.torsional);
        }
        for drive in &mut self.drives {
            limit(&mut drive.stiffness, over(&mut std::iter::once(drive.node)).torsional);
        }
    }
}

/// The stiffness with a diagonal of at most `largest`: directions are scaled, so that the others keep theirs.
pub(super) fn limited(stiffness: Matrix2, largest: f64) -> Matrix2 {
    let scale = [0, 1].map(|i| (largest / stiffness[i][i]).min(1.0).sqrt());
    [0, 1].map(|i| [0, 1].map(|j| scale[i] * scale[j] * stiffness[i][j]))
}
