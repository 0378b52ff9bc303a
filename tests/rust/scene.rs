//! Invalid scenes are refused quickly, with the path of the wrong entry.

use crate::common::{TRAIN, train};
use allocation_counter::measure;
use gearbow::model::Model;
use gearbow::scene::description::{Bearing, Coefficient, Gravity, Segment, Shaft, Stiffness};
use gearbow::scene::{MAX_ELEMENTS, Scene, SceneDescription, SceneError};
use proptest::prelude::*;
use proptest::sample::Index;

/// Builds a model from a TOML text.
fn build(text: &str) -> Result<Model, SceneError> {
    Model::new(Scene::new(&SceneDescription::from_toml(text)?)?)
}

/// Checks that an error has a path and a message.
fn assert_helpful(error: &SceneError) {
    assert!(!error.path.is_empty() && !error.message.is_empty(), "{error:?}");
    assert!(error.to_string().starts_with(&error.path), "{error}");
}

/// Values that replace a piece of a description.
const REPLACEMENTS: [&str; 20] = [
    "",
    "0",
    "-1",
    "1e400",
    "nan",
    "inf",
    "-inf",
    "1e-320",
    "4294967295",
    "18446744073709551615",
    "\"\"",
    "\"g1\"",
    "[]",
    "{}",
    "true",
    "[[]]",
    "'\u{0}'",
    "1e308",
    "\"\u{1F980}\"",
    "0.25",
];

proptest! {
    #![proptest_config(crate::common::cases(400))]

    #[test]
    fn random_bytes_are_refused(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        if let Err(error) = build(&String::from_utf8_lossy(&bytes)) {
            assert_helpful(&error);
        } else {
            prop_assert!(false, "no random text describes a rotor");
        }
    }

    #[test]
    fn replaced_values_never_panic(at in any::<Index>(), with in any::<Index>(), more in any::<Option<(Index, Index)>>()) {
        // Values follow = or stand between commas and brackets.
        let mut pieces: Vec<&str> = TRAIN.split_inclusive(['=', ',', '{', '}', '[', ']', '\n']).collect();
        let mut replace = |at: Index, with: Index| {
            let place = at.index(pieces.len());
            let last = pieces[place].chars().last();
            // Keep the punctuation, so that most texts still parse.
            let replacement = format!("{}{}", with.get(&REPLACEMENTS), last.filter(|c| "=,{}[]\n".contains(*c)).map_or(String::new(), String::from));
            pieces[place] = replacement.leak();
        };
        replace(at, with);
        if let Some((at, with)) = more {
            replace(at, with);
        }
        if let Err(error) = build(&pieces.concat()) {
            assert_helpful(&error);
        }
    }

    #[test]
    fn mutated_text_never_panics(edits in prop::collection::vec((any::<Index>(), 0_usize..12, "[ -~]{0,4}"), 1..4)) {
        let mut text = TRAIN.to_owned();
        for (at, cut, insert) in edits {
            let start = at.index(text.len());
            let end = (start + cut).min(text.len());
            text.replace_range(start..end, &insert);
        }
        if let Err(error) = build(&text) {
            assert_helpful(&error);
        }
    }
}

/// Asserts that a description is refused with an error at `path`, before memory for the nodes is allocated.
fn assert_refused(system: &SceneDescription, path: &str) {
    let mut error = None;
    let info = measure(|| error = Scene::new(system).and_then(Model::new).err());
    assert_eq!(error.as_ref().map(|error| error.path.as_str()), Some(path), "{error:?}");
    // A list of 1e9 nodes needs 16 GB.
    assert!(info.bytes_max < 64 << 20, "{} bytes", info.bytes_max);
}

#[test]
fn huge_sizes_are_refused_before_memory_is_allocated() {
    let shaft = |elements: usize| {
        let mut system = train();
        system.shafts[1].elements = Some(elements);
        system
    };
    assert!(Scene::new(&shaft(MAX_ELEMENTS - 100)).is_ok());
    for elements in [MAX_ELEMENTS, 1_000_000_000, usize::MAX] {
        assert_refused(&shaft(elements), "shafts[1]");
    }
    let mut system = train();
    let segment = Segment {
        length: 0.25,
        outer_diameter: 0.05,
        inner_diameter: 0.0,
        elements: Some(usize::MAX),
        end_outer_diameter: None,
        end_inner_diameter: None,
        material: None,
    };
    system.shafts[2] = Shaft {
        length: None,
        outer_diameter: None,
        elements: None,
        segments: Some(vec![segment; 3]),
        ..system.shafts[2].clone()
    };
    assert_refused(&system, "shafts[2]");
    // Every position of a bearing becomes a node, and nodes count as well.
    let mut system = train();
    let bearing = system.bearings[0].clone();
    let many = 3 * MAX_ELEMENTS;
    system.bearings =
        (0..many).map(|i| Bearing { position: 0.5 * i as f64 / many as f64, ..bearing.clone() }).collect();
    assert_refused(&system, "shafts[0]");
}

#[test]
fn errors_name_the_wrong_entry() {
    let path_of = |change: &dyn Fn(&mut SceneDescription)| {
        let mut system = train();
        change(&mut system);
        let error = Scene::new(&system).and_then(Model::new).err().unwrap();
        assert_helpful(&error);
        error.path
    };
    assert_eq!(path_of(&|system| system.shafts.clear()), "shafts");
    assert_eq!(path_of(&|system| system.shafts[1].length = Some(f64::NAN)), "shafts[1].length");
    assert_eq!(
        path_of(&|system| system.shafts[0].bow.as_mut().unwrap().amplitude = Some(f64::INFINITY)),
        "shafts[0].bow.amplitude"
    );
    assert_eq!(path_of(&|system| system.gears[3].position = 0.6), "gears[3].position");
    assert_eq!(path_of(&|system| system.gears[2].name = "g1".to_owned()), "gears[2].name");
    assert_eq!(path_of(&|system| system.meshes[1].driven = "g5".to_owned()), "meshes[1].driven");
    assert_eq!(path_of(&|system| system.meshes[0].stiffness = Some(Stiffness::Mean(-1.0))), "meshes[0].stiffness");
    assert_eq!(path_of(&|system| system.meshes[0].centre_distance = Some(0.05)), "meshes[0].centre_distance");
    assert_eq!(
        path_of(&|system| system.bearings[4].stiffness = Some(Coefficient::Full([[1.0, f64::NAN], [0.0, 1.0]]).into())),
        "bearings[4].stiffness[0][1]"
    );
    assert_eq!(path_of(&|system| system.torques[0].balance = true), "torques[0]");
    assert_eq!(path_of(&|system| system.reference = Some("none".to_owned())), "reference");
    assert_eq!(path_of(&|system| system.gravity = Some(Gravity::Vector([0.0, f64::NAN]))), "gravity[1]");
    assert_eq!(path_of(&|system| system.meshes.truncate(1)), "shafts[2]");
    let text = |text: &str| SceneDescription::from_toml(text).unwrap_err().path;
    assert_eq!(text("shafts = 3"), "shafts");
    assert_eq!(text("\"\" = 3"), "system");
    assert_eq!(text("shafts = ["), "toml");
    assert_eq!(text(&TRAIN.replace("teeth = 25", "teeth = 2.5")), "gears[0].teeth");
    assert_eq!(text(&TRAIN.replace("elements = 4 }", "element = 4 }")), "shafts[2].element");
}
