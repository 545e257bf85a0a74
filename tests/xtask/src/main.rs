//! Project commands. `cargo xtask test` is the one that says whether all is well.

mod call;
mod capi;
mod components;
mod deep;
mod firmware;
mod lines;
mod modules;
mod prepare;
mod release;
mod vulkan;

use call::{TARGETS, cargo, cargo_with, run};
use std::path::Path;
use std::process::ExitCode;
use std::thread;

const HELP: &str = "\
usage: cargo xtask COMMAND

  test         what every change needs: prepare the machine; check imports, format and lints; build for
               bare targets; run the tests of runtime, C calls, trainer, command line and one software
               GPU; tests on real data read ../shared/data and must find it when CI is set
  test --full  also documentation, C and C++ programs, pages, browsers, Blender, USD, validators, firmware,
               every device, and whether dependencies and packages are fit for a release
  imports      look for files that import each other, in a circle
  lines        count the lines of code of each crate
  shaders      make the SPIR-V in shaders/spirv from the GLSL
  header       make the C header in runtime/capi/include from the sources
  conformance  run every stage on every Vulkan device here and print how each compares with the CPU
               and the f64 oracle; [--json FILE] [--html FILE], more with --help
  vectors OUT  write inputs, outputs and tolerances of every stage into the folder OUT, for authors of
               backends
  firmware     run the same poses on bare targets in QEMU, in Node and here, and compare their bits;
               check that no allocator and no panic is linked; hold sizes, stack and instructions to
               tests/firmware/budget.txt
  dist         build the program `sinew` and the C library, and pack both into target/dist
  deep [SECONDS]
               run the runtime's tests and the C ABI's calls under Miri, a million mutated files, and
               every fuzz target for SECONDS (300); needs nightly
";

/// Packages that only `test --full` checks: the first part does not compile what they need.
const FULL: &str =
    "--exclude hostile --exclude native --exclude pages --exclude shaders --exclude tools";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    let done = match arguments[..] {
        ["test"] => test(),
        ["test", "--full"] => test().and_then(|()| full()),
        ["imports"] => modules::check(Path::new(".")),
        ["lines"] => lines::print(),
        ["header"] => capi::header(),
        ["firmware"] => firmware::firmware(),
        ["dist"] => release::dist(),
        ["shaders"] => cargo("run --locked -p shaders --features compile", &[]),
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

/// Checks what every change needs.
fn test() -> Result<(), String> {
    prepare::targets(&TARGETS)?;
    vulkan::prepare()?;
    modules::check(Path::new("."))?;
    cargo("fmt --all --check", &[])?;
    cargo(&format!("clippy --workspace {FULL} --all-targets --locked -- -D warnings"), &[])?;
    for target in TARGETS {
        // One package at a time: otherwise its features would unify with those of crates that need std.
        cargo(&format!("build -p sinew-runtime --locked --target {target}"), &[])?;
    }
    // Features are additive: none, all parts without internals, and all.
    for features in
        ["--no-default-features", "--features filter,prior,raster,record", "--all-features"]
    {
        let target = TARGETS[0];
        cargo(&format!("check -p sinew-runtime --locked --target {target} {features}"), &[])?;
    }
    // `devices` takes every device; the tests of sinew-gpu take one.
    cargo(&format!("test --workspace {FULL} --locked -- --skip devices::"), &[])
}

/// Checks the rest.
fn full() -> Result<(), String> {
    prepare::programs()?;
    vulkan::prepare_all()?;
    capi::prepare()?;
    cargo("clippy --workspace --all-targets --locked -- -D warnings", &[])?;
    let mut environment =
        vec![("SINEW_BPY", prepare::blender()?.into()), ("SINEW_USD", prepare::usd()?.into())];
    environment.extend(vulkan::drivers());
    environment.push(("SINEW_DEVICES", "all".into()));
    // Always the whole workspace: a part of it would have other features, and be built again.
    cargo("test --workspace --locked --no-run", &environment)?;
    // Images are linked and run on one core each, beside tests that seldom need both.
    let images = thread::spawn(firmware::firmware);
    let tests = capi::native()
        .and_then(|()| {
            let targets = "--test harm --test pages --test shaders --test tools";
            cargo(&format!("test --workspace --locked {targets}"), &environment)
        })
        .and_then(|()| {
            let targets = "--test conformance --test gpu";
            let devices = format!("test --workspace --locked {targets} -- devices:: vulkan::");
            cargo(&devices, &environment)
        })
        .and_then(|()| release::check())
        .and_then(|()| {
            cargo("doc --workspace --no-deps --locked", &[("RUSTDOCFLAGS", "-D warnings".into())])
        });
    let images = images.join().unwrap_or_else(|_| Err("the firmware's run panicked".to_owned()));
    tests.and(images)
}

/// Runs a program of the conformance package with arguments of its own.
fn conformance(program: &str, own: &[&str]) -> Result<(), String> {
    let environment: Vec<_> = vulkan::drivers().into_iter().collect();
    let arguments = format!("run --release --locked -p conformance --bin {program} --");
    run(cargo_with(&arguments, &environment).args(own))
}
