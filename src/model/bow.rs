//! The residual bow of a shaft at its nodes.

use num_complex::Complex64;

use crate::linalg::BlockTridiagonal;
use crate::scene::{Bow, Scene, SceneError};

/// A support this many times stiffer than the shaft holds a node in place to round-off.
const RIGID: f64 = 1e8;

/// u = b(x) and φ = b'(x) at the nodes of shaft `index`, if it is bowed. `mass` is that of bending, with the bodies.
pub(super) fn shape(
    scene: &Scene,
    index: usize,
    mass: &BlockTridiagonal<2>,
    stiffness: &BlockTridiagonal<2>,
) -> Result<Option<Vec<Complex64>>, SceneError> {
    let shaft = &scene.shafts[index];
    let at_nodes = |curve: &dyn Fn(f64) -> (Complex64, Complex64)| {
        let pair = |x: &f64| {
            let (value, slope) = curve(*x);
            [value, slope]
        };
        shaft.nodes.iter().flat_map(pair).collect()
    };
    Ok(match &shaft.bow {
        None => None,
        Some(Bow::Waves { amplitude, wave_number }) => Some(at_nodes(&|x| {
            let (sin, cos) = (wave_number * x).sin_cos();
            (*amplitude * sin, *amplitude * (wave_number * cos))
        })),
        Some(Bow::Points(spline)) => Some(at_nodes(&|x| spline.at(x))),
        Some(Bow::Sag { amplitude }) => {
            let sag = unit_sag(scene, index, mass, stiffness)?;
            Some(sag.iter().map(|value| *amplitude * *value).collect())
        }
    })
}

/// (u, φ) of the sag under the weight of the shaft and its bodies between rigid bearings, largest deflection 1.
///
/// The rigid-body part of a bow exerts no force, so how the bearings yield does not matter: run-out is measured
/// against the line of the bearings.
fn unit_sag(
    scene: &Scene,
    index: usize,
    mass: &BlockTridiagonal<2>,
    stiffness: &BlockTridiagonal<2>,
) -> Result<Vec<f64>, SceneError> {
    let shaft = &scene.shafts[index];
    let undefined = |message: &str| SceneError::new(format!("shafts[{index}].bow"), message);
    let mut held: Vec<usize> =
        scene.bearings.iter().filter(|bearing| bearing.node.shaft == index).map(|bearing| bearing.node.node).collect();
    held.sort_unstable();
    held.dedup();
    if held.len() < 2 {
        return Err(undefined("a sag needs bearings at two positions of the shaft"));
    }
    let mut largest: f64 = 0.0;
    stiffness.for_each(|row, column, value| {
        if row == column && row % 2 == 0 {
            largest = largest.max(value);
        }
    });
    let mut supported = stiffness.clone();
    for node in &held {
        supported.add_at_node(*node, 0, 0, RIGID * largest);
    }
    let factor = supported.factor().map_err(|_| undefined("the sag is lost to round-off"))?;
    let weightless: Vec<f64> = (0..shaft.nodes.len()).flat_map(|_| [1.0, 0.0]).collect();
    let mut sag = vec![0.0; weightless.len()];
    mass.multiply_add::<1>(1.0, &weightless, &mut sag);
    factor.solve::<1>(&mut sag);
    let deepest = sag.iter().step_by(2).fold(0.0_f64, |deepest, value| deepest.max(value.abs()));
    Ok(sag.iter().map(|value| value / deepest).collect())
}
