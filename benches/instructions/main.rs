//! Counts the instructions of fixed kernels under Valgrind and holds them against those stored in `instructions.toml`.
//!
//! Instructions do not depend on what else the machine does. Valgrind counts what runs between entry and return of
//! [`measured`] alone, so set-up is free. On every machine with AVX2 it shows a program the same processor, an
//! i7-4910MQ without AVX-512: code that chooses by processor, in faer and in the C library, chooses the same
//! everywhere. Compiler, C library and Valgrind do change counts; they are stored beside them, and counts of others
//! are shown but not judged.
//!
//! `make bench-check` compares, `make bench-accept` stores.
#![allow(missing_docs, clippy::unwrap_used, reason = "a benchmark that cannot go on has failed")]

#[path = "../common/mod.rs"]
mod common;
mod kernels;

use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Command, ExitCode};

use kernels::{KERNELS, Work};
use serde::{Deserialize, Serialize};

/// What a kernel may cost more than stored.
///
/// Noise is far below: the same binary twice, in any environment, and a rebuild after 250 other lines of the engine
/// had changed, give the same count within 0.02 %; within 0.4 % where a scene is read, for its hash maps draw keys.
const TOLERANCE: f64 = 0.03;

/// The first lines of the file.
const HEAD: &str = "\
# Instructions of the kernels of benches/instructions, as Valgrind counts them. `make bench-accept` writes this file;
# the reason for new counts belongs in CHANGELOG.md.

";

/// What the counts belong to.
#[derive(Debug, Deserialize, Serialize, PartialEq)]
struct Tools {
    processor: String,
    compiler: String,
    library: String,
    valgrind: String,
}

/// The file.
#[derive(Debug, Deserialize, Serialize)]
struct Stored {
    tools: Tools,
    instructions: BTreeMap<String, u64>,
}

/// Valgrind counts from here until it returns. Twice the same call: the first has met what is done only once.
#[inline(never)]
fn measured(work: &mut Work) {
    work();
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if let [option, name] = arguments.as_slice()
        && option == "--run"
    {
        let (_, prepare) = KERNELS.iter().find(|(known, _)| known == name).unwrap();
        let mut work = prepare();
        work();
        measured(&mut work);
        return ExitCode::SUCCESS;
    }
    let Some(valgrind) = said_by("valgrind", &["--version"]) else {
        println!("instructions: not counted, for Valgrind is not here (Debian: apt-get install valgrind)");
        return ExitCode::SUCCESS;
    };
    let tools = Tools {
        processor: processor(),
        compiler: said_by("rustc", &["--version"]).unwrap_or_default(),
        library: said_by("getconf", &["GNU_LIBC_VERSION"]).unwrap_or_default(),
        valgrind,
    };
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("benches/instructions.toml");
    let program = std::env::current_exe().unwrap();
    let counts = KERNELS.iter().map(|(name, _)| (*name, count(&program, name)));
    if arguments.iter().any(|argument| argument == "--accept") {
        return accept(&file, tools, counts);
    }
    compare(&file, &tools, counts)
}

/// What Valgrind shows of the processor: beside its family, only whether it has AVX2.
fn processor() -> String {
    #[cfg(target_arch = "x86_64")]
    if std::arch::is_x86_feature_detected!("avx2") {
        return "x86_64 with AVX2".to_owned();
    }
    std::env::consts::ARCH.to_owned()
}

/// What a program prints; nothing if it is not there.
fn said_by(program: &str, arguments: &[&str]) -> Option<String> {
    let done = Command::new(program).args(arguments).output().ok()?;
    Some(String::from_utf8_lossy(&done.stdout).trim().to_owned())
}

/// The instructions of one kernel.
fn count(program: &Path, name: &str) -> u64 {
    let done = Command::new("valgrind")
        .args(["--tool=callgrind", "--callgrind-out-file=/dev/null", "--collect-atstart=no"])
        .arg("--toggle-collect=*instructions*measured*")
        .arg(program)
        .args(["--run", name])
        // The length of the environment moves the stack.
        .env_clear()
        .env("PATH", std::env::var_os("PATH").unwrap_or_default())
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&done.stderr);
    let collected = said.lines().find_map(|line| line.split_once("Collected :"));
    let found = collected.and_then(|(_, number)| number.trim().parse().ok()).filter(|count| *count > 0);
    found.unwrap_or_else(|| panic!("\"{name}\" was not counted:\n{said}"))
}

/// Writes the file.
fn accept(file: &Path, tools: Tools, counts: impl Iterator<Item = (&'static str, u64)>) -> ExitCode {
    let instructions = counts.map(|(name, count)| (name.to_owned(), count)).collect();
    let text = toml::to_string(&Stored { tools, instructions }).unwrap();
    std::fs::write(file, HEAD.to_owned() + &text).unwrap();
    println!("{} is written; say in CHANGELOG.md why the counts changed", file.display());
    ExitCode::SUCCESS
}

/// Prints the table, and what follows from it.
fn compare(file: &Path, tools: &Tools, counts: impl Iterator<Item = (&'static str, u64)>) -> ExitCode {
    let stored: Stored = toml::from_str(&std::fs::read_to_string(file).unwrap()).unwrap();
    let (mut dearer, mut cheaper) = (Vec::new(), Vec::new());
    println!("| kernel | stored | now | change |\n|---|---|---|---|");
    for (name, now) in counts {
        let Some(before) = stored.instructions.get(name) else {
            println!("| {name} | – | {now} | new |");
            dearer.push(name);
            continue;
        };
        let change = now as f64 / *before as f64 - 1.0;
        println!("| {name} | {before} | {now} | {:+.2} % |", 100.0 * change);
        if change > TOLERANCE {
            dearer.push(name);
        } else if change < -TOLERANCE {
            cheaper.push(name);
        }
    }
    let percent = 100.0 * TOLERANCE;
    if *tools != stored.tools {
        println!("\nNot judged: these are counts of {tools:?},\nstored are those of {:?}.", stored.tools);
        return ExitCode::SUCCESS;
    }
    if !cheaper.is_empty() {
        println!("\nMore than {percent} % cheaper: {}. `make bench-accept` keeps the gain.", cheaper.join("; "));
    }
    if dearer.is_empty() {
        return ExitCode::SUCCESS;
    }
    println!("\nNew, or more than {percent} % dearer: {}.", dearer.join("; "));
    println!("If it is worth that: make bench-accept, and the reason in CHANGELOG.md.");
    ExitCode::FAILURE
}
