//! Random valid descriptions do not change when they are saved and loaded, and a model can be built from them.

use gearbow::model::Model;
use gearbow::scene::description::{
    Bearing, BearingCoefficient, Bow, BowShape, Coefficient, Complex, Disk, Drive, Force, ForceValue, FrictionTable,
    Gear, Gravity, Material, Mesh, MeshFriction, Notch, Outside, Place, Segment, Shaft, SpeedTable, Stiffness,
    TableValue, Torque, TorqueValue,
};
use gearbow::scene::{Scene, SceneDescription};
use proptest::prelude::*;

fn maybe<T: std::fmt::Debug + Clone + 'static>(value: impl Strategy<Value = T> + 'static) -> BoxedStrategy<Option<T>> {
    prop::option::of(value).boxed()
}

/// Positive sizes between 10^least and 10^most, uniform in the exponent.
fn sizes(least: i32, most: i32) -> BoxedStrategy<f64> {
    (f64::from(least)..f64::from(most)).prop_map(|exponent| 10.0_f64.powf(exponent)).boxed()
}

fn bows(length: f64) -> BoxedStrategy<Bow> {
    let none = Bow {
        shape: BowShape::Sag,
        amplitude: None,
        phase: None,
        number: None,
        positions: None,
        amplitudes: None,
        phases: None,
    };
    let wave = (any::<bool>(), -1e-2..1e-2, maybe(-4.0..4.0), 1_u32..9).prop_map({
        let none = none.clone();
        move |(mode, amplitude, phase, number)| Bow {
            shape: if mode { BowShape::Mode } else { BowShape::HalfSine },
            amplitude: Some(amplitude),
            phase,
            number: mode.then_some(number),
            ..none.clone()
        }
    });
    let points = prop::collection::vec((0.01..1.0, -1e-2..1e-2, -4.0..4.0), 2..7).prop_map(move |points| {
        let whole: f64 = points.iter().map(|(gap, _, _)| gap).sum();
        let mut end = 0.0;
        let mut position = |gap: &f64| {
            end += gap / whole * length;
            end
        };
        Bow {
            shape: BowShape::Points,
            positions: Some(points.iter().map(|(gap, _, _)| position(gap)).collect()),
            amplitudes: Some(points.iter().map(|(_, amplitude, _)| *amplitude).collect()),
            phases: Some(points.iter().map(|(_, _, phase)| *phase).collect()),
            ..none.clone()
        }
    });
    prop_oneof![wave, points].boxed()
}

fn shafts(name: &'static str) -> BoxedStrategy<(Shaft, f64)> {
    let material = maybe((1e9..1e12, 1e3..2e4, 0.0..0.5, any::<bool>()).prop_map(|(modulus, density, nu, poisson)| {
        let shear = modulus / (2.0 * (1.0 + nu));
        Material {
            youngs_modulus: modulus,
            density,
            poisson_ratio: poisson.then_some(nu),
            shear_modulus: (!poisson).then_some(shear),
        }
    }));
    let segment = || {
        (0.05..2.0, 0.01..0.5, 0.0..0.9, maybe(1_usize..5)).prop_map(|(length, outer_diameter, bore, elements)| {
            Segment {
                length,
                outer_diameter,
                inner_diameter: bore * outer_diameter,
                elements,
                end_outer_diameter: None,
                end_inner_diameter: None,
                material: None,
            }
        })
    };
    (prop::collection::vec(segment(), 1..5), any::<(bool, bool)>(), maybe((1_usize..9).boxed()), material)
        .prop_flat_map(move |(segments, (uniform, shear), degree, material)| {
            let length: f64 = if uniform { segments[0].length } else { segments.iter().map(|part| part.length).sum() };
            let only = segments[0];
            let shaft = Shaft {
                name: name.to_owned(),
                length: uniform.then_some(only.length),
                outer_diameter: uniform.then_some(only.outer_diameter),
                inner_diameter: uniform.then_some(only.inner_diameter),
                elements: if uniform { only.elements } else { None },
                degree,
                shear,
                material,
                bow: None,
                speed_ratio: None,
                axial_force: None,
                internal_damping: None,
                loss_factor: None,
                segments: (!uniform).then_some(segments),
            };
            maybe(bows(length)).prop_map(move |bow| (Shaft { bow, ..shaft.clone() }, length))
        })
        .boxed()
}

fn complexes() -> BoxedStrategy<Complex> {
    prop_oneof![(-1e-2..1e-2).prop_map(Complex::Real), prop::array::uniform2(-1e-2..1e-2).prop_map(Complex::Pair)]
        .boxed()
}

fn bearing_coefficients() -> BoxedStrategy<BearingCoefficient> {
    let table = (prop::collection::vec((1.0..1e3_f64, 0.0..1e9_f64), 2..5), any::<bool>()).prop_map(|(rows, holds)| {
        let mut speed = 0.0;
        let speeds = rows
            .iter()
            .map(|(step, _)| {
                speed += step;
                speed
            })
            .collect();
        let value = |value: f64| TableValue::One(Coefficient::Orthotropic([value, 1.0]));
        let values = rows.iter().map(|(_, k)| value(*k)).collect();
        let outside = if holds { Outside::Hold } else { Outside::Error };
        BearingCoefficient::Table(SpeedTable { speeds: Some(speeds), frequencies: None, values, outside })
    });
    prop_oneof![coefficients().prop_map(BearingCoefficient::from), table].boxed()
}

fn coefficients() -> BoxedStrategy<Coefficient> {
    prop_oneof![
        sizes(0, 12).prop_map(Coefficient::Isotropic),
        prop::array::uniform2(0.0..1e9).prop_map(Coefficient::Orthotropic),
        prop::array::uniform2(prop::array::uniform2(0.0..1e9)).prop_map(Coefficient::Full),
    ]
    .boxed()
}

/// Two shafts in mesh with disks, bearings and torques.
fn systems() -> impl Strategy<Value = SceneDescription> {
    let gear = || (8_u32..200, maybe(0.01..0.2), maybe(sizes(-3, 3)), maybe(complexes()), 0.0..=1.0_f64, -0.5..0.5);
    let pair = (gear(), gear(), 1e-3..2e-2, maybe(0.2..0.5));
    let mesh = (sizes(5, 10), 0..3, 0.0..0.2, maybe(-7.0..7.0));
    let places = prop::collection::vec(
        (any::<bool>(), 0.0..=1.0_f64, bearing_coefficients(), maybe(bearing_coefficients())),
        1..5,
    );
    let disks = prop::collection::vec((any::<bool>(), 0.0..=1.0_f64, sizes(-3, 3), maybe(complexes())), 0..3);
    let whole =
        (maybe(0.0..0.2), maybe(prop::array::uniform2(0.0..1e-3)), maybe(-20.0..20.0), any::<(bool, bool, bool)>());
    (shafts("one"), shafts("two"), pair, mesh, places, disks, whole).prop_map(
        |((one, l1), (two, l2), (a, b, module, pressure_angle), mesh, places, disks, whole)| {
            let on = |first: bool| if first { ("one".to_owned(), l1) } else { ("two".to_owned(), l2) };
            let gear =
                |name: &str,
                 first: bool,
                 (teeth, width, mass, unbalance, at, shift): (u32, Option<f64>, _, _, f64, f64)| {
                    let (shaft, length) = on(first);
                    let size: Option<f64> = mass;
                    Gear {
                        name: name.to_owned(),
                        shaft,
                        position: at * length,
                        teeth,
                        internal: false,
                        module: Some(module),
                        base_radius: None,
                        face_width: width.or(Some(0.02)),
                        pressure_angle,
                        helix_angle: Some(if first { 0.05 } else { -0.05 }),
                        profile_shift: Some(shift),
                        // With few teeth and a large negative profile shift, the default tip circle may lie inside the base circle.
                        tip_radius: Some(module * (f64::from(teeth) / 2.0 + 1.0)),
                        mass: size,
                        diametral_inertia: size.map(|size| size * 1e-3),
                        polar_inertia: size.map(|size| size * 2e-3),
                        unbalance,
                        runout: None,
                    }
                };
            let (stiffness, damped, damping, angle) = mesh;
            let (modal_damping, rayleigh, gravity, (named, balanced, vector)) = whole;
            let given = |index: i32| (damped == index).then_some(damping);
            let body = |(index, (first, at, size, unbalance)): (usize, (bool, f64, f64, _))| Disk {
                name: format!("disk {index}"),
                shaft: on(first).0,
                position: at * on(first).1,
                mass: size,
                diametral_inertia: size * 1e-2,
                polar_inertia: size * 2e-2,
                unbalance,
            };
            let bearing = |(first, at, stiffness, damping): (bool, f64, BearingCoefficient, _)| {
                let (shaft, length) = on(first);
                let (position, stiffness) = (at * length, Some(stiffness));
                Bearing { shaft, position, stiffness, damping, ..Bearing::default() }
            };
            let torque = |at: Place, value: Option<f64>| Torque {
                at,
                value: value.map(TorqueValue::Constant),
                balance: value.is_none(),
            };
            let table = MeshFriction::Table(FrictionTable {
                coefficient: Some(0.05),
                transition: Some(0.2),
                ..FrictionTable::default()
            });
            let (shaft, length) = on(false);
            let notch = Notch { shaft, position: 0.5 * length, bending: Some(1.5), torsion: vector.then_some(1.25) };
            SceneDescription {
                accuracy: None,
                reference: named.then(|| "two".to_owned()),
                modal_damping: modal_damping.map(Into::into),
                rayleigh,
                geometric_stiffness: named,
                bow_torque: vector,
                sleeves: Vec::new(),
                gravity: gravity.map(|g| if vector { Gravity::Vector([g, -g]) } else { Gravity::Down(g) }),
                motion: None,
                shafts: vec![one, two],
                gears: vec![gear("a", true, a), gear("b", false, b)],
                disks: disks.into_iter().enumerate().map(body).collect(),
                meshes: vec![Mesh {
                    driver: "a".to_owned(),
                    driven: "b".to_owned(),
                    stiffness: Some(Stiffness::Mean(stiffness)),
                    damping_ratio: given(0),
                    damping: given(1),
                    damping_in_separation: named.then_some(vector),
                    loss_factor: None,
                    centre_line_angle: angle,
                    tooth_angle: angle,
                    centre_distance: None,
                    backlash: None,
                    tip_relief: None,
                    error: None,
                    friction: vector.then_some(if named { MeshFriction::Coefficient(0.1) } else { table }),
                    carrier: None,
                }],
                bearings: places.into_iter().map(bearing).collect(),
                supports: Vec::new(),
                housings: Vec::new(),
                notches: named.then_some(notch).into_iter().collect(),
                couplings: Vec::new(),
                drives: vec![Drive { at: Place::Body("b".to_owned()), stiffness, damping: given(0) }],
                forces: vec![Force {
                    at: Place::Shaft("one".to_owned(), l2.min(l1)),
                    value: ForceValue::Constant(Complex::Pair([stiffness, damping])),
                    order: vector.then_some(1.0),
                    axial: Some(damping),
                }],
                torques: vec![
                    torque(Place::Body("a".to_owned()), Some(damping * 1e3)),
                    torque(Place::Shaft("two".to_owned(), l2), if balanced { None } else { Some(-1.0) }),
                ],
            }
        },
    )
}

proptest! {
    #![proptest_config(crate::common::cases(150))]

    #[test]
    fn a_valid_description_survives_saving_and_loading(system in systems()) {
        let text = system.to_toml().unwrap();
        let again = SceneDescription::from_toml(&text).unwrap();
        // All digits of a float are written.
        prop_assert_eq!(&again, &system);
        prop_assert_eq!(again.to_toml().unwrap(), text);

        let scene = Scene::new(&system).unwrap();
        prop_assert_eq!(scene.speed_ratios.len(), 2);
        prop_assert!(scene.lateral && scene.torsion);
        let nodes: usize = scene.shafts.iter().map(|shaft| shaft.nodes.len()).sum();
        for (shaft, given) in scene.shafts.iter().zip(&system.shafts) {
            prop_assert_eq!(shaft.elements.len() + 1, shaft.nodes.len());
            prop_assert!(shaft.nodes.windows(2).all(|pair| pair[0] < pair[1]));
            let asked = given.elements.unwrap_or_else(|| given.segments.iter().flatten().map(|part| part.elements.unwrap_or(1)).sum());
            prop_assert!(shaft.elements.len() >= asked);
            prop_assert_eq!(shaft.degree, given.degree.unwrap_or(1));
        }
        for (gear, given) in scene.gears.iter().zip(&system.gears) {
            let x = scene.shafts[gear.body.node.shaft].nodes[gear.body.node.node];
            prop_assert!((x - given.position).abs() <= 1e-9 * scene.shafts[gear.body.node.shaft].length());
        }
        if system.torques[1].balance {
            // The torques do no work on the rigid-body rotation. Both gears have the same module, so that the ratio of
            // the radii equals that of the tooth numbers.
            let [a, b] = [0, 1].map(|i| scene.speed_ratios[scene.torques[i].node.shaft] * scene.torques[i].value);
            prop_assert!((a + b).abs() <= 1e-12 * a.abs());
        }
        let model = Model::new(scene).unwrap();
        let internal = model.scene.shafts.iter().map(|shaft| {
            let bending = if shaft.shear { 2 * shaft.degree - 1 } else { shaft.degree.saturating_sub(2) };
            // Twist and axial displacement, because the gears are helical.
            let rods = 2 * (shaft.degree - 1);
            if shaft.degree > 1 { (2 * bending + rods) * shaft.elements.len() } else { 0 }
        });
        prop_assert_eq!(model.len(), 6 * nodes + internal.sum::<usize>());
        prop_assert_eq!(model.numbering.nodal_dofs().len(), 6 * nodes);
        prop_assert!(model.constant_load.iter().all(|value| value.is_finite()));
    }
}
