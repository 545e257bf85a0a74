//! Project commands. `cargo xtask test` is the one that says whether all is well.

mod call;
mod capi;
mod components;
mod deep;
mod firmware;
mod modules;
mod prepare;
mod vulkan;

use call::{TARGETS, cargo, cargo_with, run};
use std::path::Path;
use std::process::ExitCode;
use std::thread;

const HELP: &str = "\
usage: cargo xtask COMMAND

  test         prepare the machine, then see that modules import one way, format, lint, document, build
               for every target and run every test; tests on real data read ../shared/data and must find
               it when CI is set
  shaders      make the SPIR-V in shaders/spirv of the GLSL
  header       make the C header in runtime/capi/include of the sources
  conformance  run every stage on every Vulkan device here and print how each compares with the CPU
               and the f64 oracle; [--json FILE] [--html FILE], more with --help
  vectors OUT  write inputs, outputs and tolerances of every stage into the folder OUT, for authors of
               backends
  firmware     run the same poses on bare targets in QEMU, in Node and here, and compare their bits; see
               that no allocator and no panic is linked; hold sizes, stack and instructions to
               tests/firmware/budget.txt
  deep [SECONDS]
               run the runtime's tests and the C ABI's calls under Miri, a million mutated files, and
               every fuzz target for SECONDS (300); needs nightly
";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let done = match arguments[..] {
        ["test"] => test(),
        ["header"] => capi::header(),
        ["firmware"] => firmware::firmware(),
        ["shaders"] => cargo("run --release --locked -p shaders", &[]),
        ["conformance", ref own @ ..] => conformance("conformance", own),
        ["vectors", ref own @ ..] => conformance("vectors", own),
        ["deep"] => deep::deep(None),
        ["deep", seconds] => deep::deep(Some(seconds)),
        _ => {
            eprint!("{HELP}");
            return ExitCode::from(2);
        }
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("xtask: {message}");
            ExitCode::FAILURE
        }
    }
}

fn test() -> Result<(), String> {
    prepare::programs()?;
    vulkan::prepare()?;
    capi::prepare()?;
    modules::check(Path::new("."))?;
    cargo("fmt --all --check", &[])?;
    cargo("clippy --workspace --all-targets --locked -- -D warnings", &[])?;
    cargo("doc --workspace --no-deps --locked", &[("RUSTDOCFLAGS", "-D warnings".into())])?;
    for target in TARGETS {
        // One package at a time: features would unify with crates that need std.
        cargo(&format!("build -p sinew-runtime --locked --target {target}"), &[])?;
    }
    let mut environment = vec![("SINEW_BPY", prepare::blender()?.into())];
    environment.extend(vulkan::drivers());
    cargo("test --workspace --locked --no-run", &environment)?;
    // Images are linked and run on one core each, beside tests that seldom need both.
    let images = thread::spawn(firmware::firmware);
    let tests = cargo("test --workspace --locked", &environment);
    let images = images.join().unwrap_or_else(|_| Err("the firmware's run panicked".to_owned()));
    tests.and(images)
}

/// Runs a program of the conformance package with arguments of its own.
fn conformance(program: &str, own: &[&str]) -> Result<(), String> {
    let environment: Vec<_> = vulkan::drivers().into_iter().collect();
    let arguments = format!("run --release --locked -p conformance --bin {program} --");
    run(cargo_with(&arguments, &environment).args(own))
}
