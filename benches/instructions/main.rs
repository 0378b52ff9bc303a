//! Counts the instructions of fixed kernels with Valgrind and compares them with the counts in `instructions.toml`.
//!
//! Instruction counts do not depend on the load of the machine. Valgrind counts only between entry and return of
//! [`counted`], so preparation is not included. On every machine with AVX2, Valgrind emulates the same processor (an
//! i7-4910MQ without AVX-512), so faer and the C library select the same code everywhere. Compiler, C library and
//! Valgrind do change the counts. Their versions are stored; with other versions the comparison is printed but cannot
//! fail.
//!
//! `make bench-check` compares the counts, `make bench-accept` stores them.
#![allow(missing_docs, clippy::unwrap_used, reason = "a benchmark that cannot go on has failed")]

#[path = "../common/mod.rs"]
mod common;
mod kernels;

use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Command, ExitCode};

use kernels::{KERNELS, Work};
use serde::{Deserialize, Serialize};

/// Largest accepted increase of a count, relative.
///
/// Counts of the same code vary much less: by 0.02 % between environments and after unrelated changes of the engine,
/// and by 0.4 % if a scene is read, because hash maps use random keys.
const TOLERANCE: f64 = 0.03;

/// First lines of `instructions.toml`.
const HEAD: &str = "\
# Instruction counts of the kernels of benches/instructions, measured by Valgrind. `make bench-accept` writes this file;
# CHANGELOG.md gives the reason for new counts.

";

/// Versions of the tools that produced the counts.
#[derive(Debug, Deserialize, Serialize, PartialEq)]
struct Tools {
    processor: String,
    compiler: String,
    library: String,
    valgrind: String,
}

/// Content of `instructions.toml`.
#[derive(Debug, Deserialize, Serialize)]
struct Stored {
    tools: Tools,
    instructions: BTreeMap<String, u64>,
}

/// Runs a kernel. Valgrind counts the instructions of this function only.
#[inline(never)]
fn counted(work: &mut Work) {
    work();
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if let [option, name] = arguments.as_slice()
        && option == "--run"
    {
        let (_, prepare) = KERNELS.iter().find(|(known, _)| known == name).unwrap();
        let mut work = prepare();
        // The first call includes work that is done only once, such as filling caches.
        work();
        counted(&mut work);
        return ExitCode::SUCCESS;
    }
    let Some(valgrind) = output_of("valgrind", &["--version"]) else {
        println!("instructions: not counted, because Valgrind is not installed (Debian: apt-get install valgrind)");
        return ExitCode::SUCCESS;
    };
    let tools = Tools {
        processor: processor(),
        compiler: output_of("rustc", &["--version"]).unwrap_or_default(),
        library: output_of("getconf", &["GNU_LIBC_VERSION"]).unwrap_or_default(),
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

/// Properties of the processor that change the emulated one: its family, and whether it has AVX2.
fn processor() -> String {
    #[cfg(target_arch = "x86_64")]
    if std::arch::is_x86_feature_detected!("avx2") {
        return "x86_64 with AVX2".to_owned();
    }
    std::env::consts::ARCH.to_owned()
}

/// Output of a program; `None` if it is not installed.
fn output_of(program: &str, arguments: &[&str]) -> Option<String> {
    let done = Command::new(program).args(arguments).output().ok()?;
    Some(String::from_utf8_lossy(&done.stdout).trim().to_owned())
}

/// Instruction count of one kernel.
fn count(program: &Path, name: &str) -> u64 {
    let done = Command::new("valgrind")
        .args(["--tool=callgrind", "--callgrind-out-file=/dev/null", "--collect-atstart=no"])
        .arg("--toggle-collect=*instructions*counted*")
        .arg(program)
        .args(["--run", name])
        // An empty environment, because its length changes the alignment of the stack.
        .env_clear()
        .env("PATH", std::env::var_os("PATH").unwrap_or_default())
        .output()
        .unwrap();
    let report = String::from_utf8_lossy(&done.stderr);
    let collected = report.lines().find_map(|line| line.split_once("Collected :"));
    let found = collected.and_then(|(_, number)| number.trim().parse().ok()).filter(|count| *count > 0);
    found.unwrap_or_else(|| panic!("Valgrind did not count \"{name}\":\n{report}"))
}

/// Stores the counts.
fn accept(file: &Path, tools: Tools, counts: impl Iterator<Item = (&'static str, u64)>) -> ExitCode {
    let instructions = counts.map(|(name, count)| (name.to_owned(), count)).collect();
    let text = toml::to_string(&Stored { tools, instructions }).unwrap();
    std::fs::write(file, HEAD.to_owned() + &text).unwrap();
    println!("wrote {}; explain in CHANGELOG.md why the counts changed", file.display());
    ExitCode::SUCCESS
}

/// Prints the stored and the new counts; fails if a count is new or has increased by more than [`TOLERANCE`].
fn compare(file: &Path, tools: &Tools, counts: impl Iterator<Item = (&'static str, u64)>) -> ExitCode {
    let stored: Stored = toml::from_str(&std::fs::read_to_string(file).unwrap()).unwrap();
    let (mut increased, mut decreased) = (Vec::new(), Vec::new());
    println!("| kernel | stored | now | change |\n|---|---|---|---|");
    for (name, now) in counts {
        let Some(before) = stored.instructions.get(name) else {
            println!("| {name} | – | {now} | new |");
            increased.push(name);
            continue;
        };
        let change = now as f64 / *before as f64 - 1.0;
        println!("| {name} | {before} | {now} | {:+.2} % |", 100.0 * change);
        if change > TOLERANCE {
            increased.push(name);
        } else if change < -TOLERANCE {
            decreased.push(name);
        }
    }
    let percent = 100.0 * TOLERANCE;
    if *tools != stored.tools {
        println!("\nNot comparable: the counts were made with {tools:?},\nthe stored counts with {:?}.", stored.tools);
        return ExitCode::SUCCESS;
    }
    if !decreased.is_empty() {
        println!(
            "\nDecreased by more than {percent} %: {}. Run `make bench-accept` to store the lower counts.",
            decreased.join("; ")
        );
    }
    if increased.is_empty() {
        return ExitCode::SUCCESS;
    }
    println!("\nNew, or increased by more than {percent} %: {}.", increased.join("; "));
    println!("To accept the counts: run `make bench-accept` and give the reason in CHANGELOG.md.");
    ExitCode::FAILURE
}
