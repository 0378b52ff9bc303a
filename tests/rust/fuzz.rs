//! Random changes of TOML files: each file gives a scene or an error with a path, in limited time and memory. `make fuzz`
//! tries a million files.

use std::sync::Mutex;
use std::time::{Duration, Instant};

use allocation_counter::measure;
use gearbow::analysis::equilibrium;
use gearbow::analysis::simulate::{Initial, Method, Options, RecordPlan, Request, System, simulate};
use gearbow::mesh::Geometry;
use gearbow::model::Model;
use gearbow::scene::{Scene, SceneDescription, SceneError};
use proptest::prelude::*;
use proptest::sample::Index;

/// Valid files, which the test changes.
const FILES: [&str; 5] = [
    crate::common::TRAIN,
    EVERYTHING,
    include_str!("../../examples/rotors/friswell_2010.toml"),
    include_str!("../../examples/rotors/nelson_1976.toml"),
    include_str!("../../examples/rotors/rao_1998.toml"),
];

/// A file with all entries that the other files do not contain.
const EVERYTHING: &str = r#"
reference = "b"
modal_damping = 0.02
rayleigh = [1.0, 1e-6]
gravity = [0.0, -9.81]
motion = "coupled"
[[shafts]]
name = "a"
shear = false
segments = [
    { length = 0.2, outer_diameter = 0.05, inner_diameter = 0.01, elements = 2 },
    { length = 0.3, outer_diameter = 0.06, elements = 1 },
]
material = { youngs_modulus = 2e11, density = 7800.0, shear_modulus = 8e10 }
bow = { shape = "points", positions = [0.0, 0.2, 0.5], amplitudes = [0.0, 1e-4, 0.0], phases = [0.0, 0.3, 0.4] }
[[shafts]]
name = "b"
length = 0.5
outer_diameter = 0.05
elements = 2
bow = { shape = "mode", number = 2, amplitude = 1e-4, phase = 1.0 }
[[shafts]]
name = "c"
length = 0.5
outer_diameter = 0.05
elements = 2
bow = { shape = "sag", amplitude = 1e-4 }
[[gears]]
name = "g1"
shaft = "a"
position = 0.1
teeth = 20
module = 3e-3
face_width = 0.02
pressure_angle = 0.3490658503988659
profile_shift = 0.1
runout = [1e-5, 0.0]
[[gears]]
name = "g2"
shaft = "b"
position = 0.1
teeth = 30
module = 3e-3
face_width = 0.02
unbalance = 1e-4
[[gears]]
name = "g3"
shaft = "c"
position = 0.1
teeth = 25
base_radius = 0.0352
mass = 1.0
diametral_inertia = 1e-3
polar_inertia = 2e-3
[[disks]]
name = "d"
shaft = "a"
position = 0.5
mass = 1.0
diametral_inertia = 1e-3
polar_inertia = 2e-3
unbalance = [1e-4, 1e-5]
[[meshes]]
driver = "g1"
driven = "g2"
stiffness = { model = "parabolic", pair = 1e8, end_ratio = 0.6, engagement = 0.1, phase = "prescribed" }
damping = 100.0
backlash = 1e-5
tip_relief = { amount = 1e-5, length = 2e-3, shape = "parabolic" }
error = { tooth = [[1e-6, 0.0], [5e-7, 1.0]], driver = [[1e-6, 0.5]] }
[[meshes]]
driver = "g2"
driven = "g3"
stiffness = { model = "table", values = [1e8, 1.5e8, 1.2e8, 1.1e8] }
damping_ratio = 0.02
centre_line_angle = 1.0
centre_distance = 0.0826
[[bearings]]
shaft = "a"
position = 0.0
stiffness = [[1e8, 1e6], [1e6, 1e8]]
damping = [100.0, 200.0]
[[bearings]]
shaft = "b"
position = 0.25
stiffness = 1e8
[[bearings]]
shaft = "c"
position = 0.0
stiffness = 1e8
[[bearings]]
shaft = "c"
position = 0.5
stiffness = 1e8
[[torques]]
at = "g1"
value = 10.0
[[torques]]
at = ["c", 0.5]
balance = true
"#;

/// Values that replace other values.
const WORDS: [&str; 40] = [
    "0",
    "-0.0",
    "1",
    "-1",
    "2",
    "3",
    "1e-300",
    "5e-324",
    "1e-9",
    "1e-3",
    "0.5",
    "1.0000000001",
    "1e3",
    "1e9",
    "1e18",
    "1e154",
    "1e308",
    "-1e308",
    "nan",
    "inf",
    "-inf",
    "1000000000",
    "4294967295",
    "9223372036854775807",
    "18446744073709551616",
    "true",
    "false",
    "\"\"",
    "\"a\"",
    "\"g1\"",
    "\"gears\"",
    "\"sharp\"",
    "[]",
    "[[]]",
    "{}",
    "[1.0, 2.0]",
    "[[1.0, 0.0], [0.0, 1.0]]",
    "1979-05-27",
    "\"\\u0000\"",
    "{ model = \"square\", pair = 1e8 }",
];

/// One change of a text. Each `Index` selects a place.
#[derive(Clone, Debug)]
enum Change {
    /// Replaces a word by one of [`WORDS`].
    Word(Index, Index),
    /// Replaces a word by another word of the file.
    Swap(Index, Index),
    /// Removes a line.
    Drop(Index),
    /// Repeats a line at another place.
    Repeat(Index, Index),
    /// Replaces bytes by other bytes.
    Bytes(Index, u8, Vec<u8>),
    /// Removes the end of the text.
    Cut(Index),
}

fn changes() -> impl Strategy<Value = Change> {
    let at = any::<Index>;
    prop_oneof![
        8 => (at(), at()).prop_map(|(place, word)| Change::Word(place, word)),
        3 => (at(), at()).prop_map(|(place, other)| Change::Swap(place, other)),
        2 => at().prop_map(Change::Drop),
        1 => (at(), at()).prop_map(|(line, place)| Change::Repeat(line, place)),
        1 => (at(), 0_u8..9, prop::collection::vec(any::<u8>(), 0..5)).prop_map(|(at, old, new)| Change::Bytes(at, old, new)),
        1 => at().prop_map(Change::Cut),
    ]
}

/// Begin and end of the words of a text, as byte offsets.
fn words(text: &str) -> Vec<(usize, usize)> {
    let mut found = Vec::new();
    let mut begin = None;
    for (i, sign) in text.char_indices().chain([(text.len(), ' ')]) {
        match (begin, sign.is_alphanumeric() || "._+-\"".contains(sign)) {
            (None, true) => begin = Some(i),
            (Some(from), false) => {
                found.push((from, i));
                begin = None;
            }
            _ => {}
        }
    }
    found
}

fn changed(mut text: String, change: &Change) -> String {
    let found = words(&text);
    let mut lines: Vec<&str> = text.lines().collect();
    match change {
        _ if found.is_empty() || lines.is_empty() => {}
        Change::Word(place, word) => {
            let (from, to) = found[place.index(found.len())];
            text.replace_range(from..to, WORDS[word.index(WORDS.len())]);
        }
        Change::Swap(place, other) => {
            let ((from, to), (other, end)) = (found[place.index(found.len())], found[other.index(found.len())]);
            let word = text[other..end].to_owned();
            text.replace_range(from..to, &word);
        }
        Change::Drop(line) => {
            lines.remove(line.index(lines.len()));
            text = lines.join("\n");
        }
        Change::Repeat(line, place) => {
            let line = lines[line.index(lines.len())];
            lines.insert(place.index(lines.len()), line);
            text = lines.join("\n");
        }
        Change::Bytes(place, old, new) => {
            let mut bytes = text.into_bytes();
            let at = place.index(bytes.len());
            let end = (at + usize::from(*old)).min(bytes.len());
            bytes.splice(at..end, new.iter().copied());
            text = String::from_utf8_lossy(&bytes).into_owned();
        }
        Change::Cut(place) => {
            let (end, _) = found[place.index(found.len())];
            text.truncate(end);
        }
    }
    text
}

fn texts() -> impl Strategy<Value = String> {
    let changes = prop::collection::vec(changes(), 0..5);
    let noise =
        prop::collection::vec(any::<u8>(), 0..64).prop_map(|bytes| String::from_utf8_lossy(&bytes).into_owned());
    prop_oneof![
        60 => (0..FILES.len(), changes)
            .prop_map(|(file, changes)| changes.iter().fold(FILES[file].to_owned(), changed)),
        1 => noise,
    ]
}

/// Time limit of one file. Most files take less than a millisecond; the machine may be busy.
const TIME_LIMIT: Duration = Duration::from_secs(120);
/// Memory limit of one file, bytes; the largest allowed scenes need a part of it.
const MEMORY_LIMIT: u64 = 200 << 20;
/// Largest number of degrees of freedom of a scene that is simulated; larger ones would take too long.
const MAX_SIMULATED_DOFS: usize = 80;

/// The text that is being tried and its start time. A watchdog thread prints the text after the time limit.
static CURRENT: Mutex<Option<(Instant, String)>> = Mutex::new(None);

fn start_watchdog() {
    static ONCE: std::sync::Once = std::sync::Once::new();
    ONCE.call_once(|| {
        std::thread::spawn(|| {
            loop {
                std::thread::sleep(Duration::from_secs(1));
                let now = CURRENT.lock().unwrap();
                if let Some((_, text)) = now.as_ref().filter(|(since, _)| since.elapsed() > TIME_LIMIT) {
                    eprintln!("no result after {TIME_LIMIT:?} for:\n{text}");
                    std::process::abort();
                }
            }
        });
    });
}

fn scene(text: &str) -> Result<Model, SceneError> {
    Model::new(Scene::new(&SceneDescription::from_toml(text)?)?)
}

/// Simulates a few steps; the run may return an error, but must not panic.
fn run(model: Model) {
    let n = model.len();
    let cached = System::new(model);
    let _ = equilibrium(&cached, Geometry::Live, 100.0).map(|found| assert_eq!(found.len(), n));
    for method in [Method::Exponential, Method::Rk45] {
        let options = Options {
            duration: 1e-3,
            speed: 100.0.into(),
            method,
            step: None,
            rtol: Some(1e-4),
            stages: None,
            modes: None,
            reduction: None,
            kept_modes: None,
            force_error: None,
            initial: Initial::Rest,
            times: vec![0.0, 1e-3],
            geometry: Geometry::Live,
            start: 0.0,
            checkpoint: None,
        };
        let requests = ["gears", "meshes", "energy"].map(|name| Request::Name(name.to_owned()));
        let plan = RecordPlan::new(&cached.model, &requests).unwrap();
        let mut reports = 0;
        // Extremely stiff scenes are stopped.
        let mut watch = |_| {
            reports += 1;
            reports < 3
        };
        if let Ok(response) = simulate(&cached, &options, &plan, &mut watch) {
            assert_eq!(response.record.time.len(), 2);
        }
    }
}

fn check(text: &str, runs: bool) {
    *CURRENT.lock().unwrap() = Some((Instant::now(), text.to_owned()));
    let mut found = None;
    let info = measure(|| found = Some(scene(text)));
    assert!(info.bytes_max < MEMORY_LIMIT, "{} MB for\n{text}", info.bytes_max >> 20);
    match found.unwrap() {
        Err(error) => assert!(!error.path.is_empty() && !error.message.is_empty(), "{error} for\n{text}"),
        Ok(model) if runs && model.len() <= MAX_SIMULATED_DOFS => run(model),
        Ok(_) => {}
    }
    *CURRENT.lock().unwrap() = None;
}

proptest! {
    #![proptest_config(crate::common::cases(3000))]

    #[test]
    fn every_text_gives_a_scene_or_an_error(text in texts(), lot in 0..500) {
        start_watchdog();
        check(&text, lot == 0);
    }
}

#[test]
fn the_files_are_valid() {
    for file in FILES {
        scene(file).unwrap();
    }
}

#[test]
fn absurd_sizes_are_refused_before_memory_is_allocated() {
    for (what, text) in [
        ("elements", crate::common::TRAIN.replace("elements = 4", "elements = 1000000000")),
        ("elements", crate::common::TRAIN.replace("elements = 4", "elements = 9223372036854775807")),
        ("elements", crate::common::TRAIN.replace("elements = 4", "elements = 16667")),
        ("counted by their degree", crate::common::TRAIN.replace("elements = 4", "elements = 2100, degree = 8")),
    ] {
        let mut found = None;
        let info = measure(|| found = Some(scene(&text)));
        let error = found.unwrap().unwrap_err().to_string();
        assert!(error.starts_with("shafts[") && error.contains(what) && error.contains("50000"), "{error}");
        assert!(info.bytes_max < 16 << 20, "{} bytes", info.bytes_max);
    }
}
